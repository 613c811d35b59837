"""The paths of all elements of a scene in one case, and the forces between them."""

from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.dem.numerics import Numerics
from overturning.dem.plan import Path
from overturning.dem.run import plan
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.results import Results
from overturning.model.scene import Scene, scene_or_gravestone
from overturning.model.variables import INT8_MISSING, VARIABLES
from overturning.motion.motion import Motion, as_motion
from overturning.units import GRANITE_DENSITY

if TYPE_CHECKING:
    import xarray as xr


POSES = {
    "x": ("m", "centre towards the azimuth, in the frame of the base"),
    "z": ("m", "height of the centre"),
    "rotation": ("rad", "rotation, positive towards the azimuth"),
    "velocity_x": ("m s-1", "velocity towards the azimuth, relative to the base"),
    "velocity_z": ("m s-1", "upward velocity"),
    "angular_velocity": ("rad s-1", "angular velocity"),
}


def trajectory(
    motion: Motion,
    *,
    azimuth_deg: float,
    height: float | None = None,
    b_over_h: float | None = None,
    friction: float = 1.0,
    scene: Scene | None = None,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    amplitude: float = 1.0,
    initial_tilt: float = 0.0,
    **options: Any,
) -> "xr.Dataset":
    """The paths of all elements in one case, bit-equal to its cell of a sweep with the same arguments.

    Parameters
    ----------
    motion, azimuth_deg, height, b_over_h, friction, scene, density, contact
        As in `overturning.dem.simulate.simulate_arrays`, one value each.
    amplitude, initial_tilt : float
        As in `overturning.model.cases.Cases`.
    **options
        Fields of `overturning.dem.numerics.Numerics`.

    Returns
    -------
    xarray.Dataset
        Over `time` (about once per sample of the record, for a single block more often where a contact changes or a step
        is done again; after the record until the case ends) and `element` (all of them): `x`, `z` (centre, m), `rotation`
        (rad, positive towards the azimuth), `velocity_x`, `velocity_z` (m/s), `angular_velocity` (rad/s), `base_slip`
        (m, of the middle of the lower side from its place), all in the frame of the base; `ground_acceleration` over
        `time` (m/s²). Over `time` and `contact` (both ends of each pair of elements that can meet): `contact_force` (N,
        on the element `contact_on` from `contact_by`; mean from this time to the next) and `contact_place` (m; mean
        weighted by the normal force), NaN where nothing is known and, of the place, where nothing touches. Over
        `element`: `kind`, `critical_angle` (α, rad), `fallen_angle` (at which it has fallen, rad), `vertices` (about the centre, m, NaN beyond an element's last) and
        the cell's outcome, missing where the element is not free; the whole case's outcome without a dimension.
        The general kernel adds the forces up at each of its steps; for a single block they follow from the path.
        Attributes: the names of the scene and of its reference element, the weight of all free elements (N), the case's
        block steps and what it was called with.

    Raises
    ------
    ArgumentError
        As `overturning.simulate`, and where the path would be longer than `overturning.dem.plan.MOST_PATH`.
    """
    motion = as_motion(motion)
    scene, size, ratio = scene_or_gravestone(scene, contact, density, height, b_over_h)
    case = Cases([azimuth_deg], [size], [ratio], [friction], [amplitude], 1.0, [initial_tilt])
    planned = plan(scene, motion, case, Numerics(**options))
    answers, path = planned.trace()
    results = planned.uncomputed()
    if answers is not None:
        results.store(np.zeros(1, np.int64), answers)
    attributes = {
        "scene": scene.name,
        "reference": scene.shown_name,
        "weight": scene.gravity * sum(item.mass for item in path.placed if not item.fixed),
        "block_steps": int(results.block_steps[0]),
        "azimuth_deg": azimuth_deg,
        "height": size,
        "b_over_h": ratio,
        "friction": friction,
        "amplitude": amplitude,
    }
    return _dataset(path, results, attributes)


def _dataset(path: Path, results: Results, attributes: dict[str, Any]) -> "xr.Dataset":
    import xarray as xr

    def described(dimensions: str, values: Any, units: str, long_name: str) -> tuple[Any, ...]:
        return dimensions.split(), values, {"units": units, "long_name": long_name}

    vertices = np.full((len(path.placed), max(len(item.shape.vertices) for item in path.placed), 2), np.nan)
    for item, row in zip(path.placed, vertices, strict=True):
        row[: len(item.shape.vertices)] = item.shape.vertices
    x, _, angle = np.moveaxis(path.poses[:, :, :3], 2, 0)
    slip = x - [item.x for item in path.placed] + np.nanmin(vertices[:, :, 1], axis=1) * np.sin(angle)
    variables = {
        name: described("time element", path.poses[:, :, column], *about)
        for column, (name, about) in enumerate(POSES.items())
    }
    mean = "mean from this time to the next"
    variables |= {
        "base_slip": described("time element", slip, "m", "displacement of the middle of the lower side"),
        "ground_acceleration": described("time", path.ground, "m s-2", "acceleration of the base towards the azimuth"),
        "contact_force": described("time contact xz", path.force, "N", f"force on contact_on, {mean}"),
        "contact_place": described("time contact xz", path.place, "m", f"where it acts, {mean}"),
        "contact_on": ("contact", [on for on, _ in path.contacts]),
        "contact_by": ("contact", [by for _, by in path.contacts]),
        "kind": ("element", [item.element.kind for item in path.placed]),
        "critical_angle": described("element", path.critical, "rad", "critical angle"),
        "fallen_angle": described(
            "element",
            [np.nan if item.fixed else item.fallen for item in path.placed],
            "rad",
            "rotation at which it has fallen",
        ),
        "vertices": described("element vertex xz", vertices, "m", "vertices about the centre, counter-clockwise"),
    }
    free = [index for index, item in enumerate(path.placed) if not item.fixed]
    for variable in (item for item in VARIABLES if item.name != "mirrored"):
        values = getattr(results, variable.name)[0]
        if variable.per_element:
            missing = INT8_MISSING if variable.dtype == "i1" else np.nan
            values, of_free = np.full(len(path.placed), missing, variable.dtype), values
            values[free] = of_free
        variables[variable.name] = (("element",) if variable.per_element else (), values, variable.all_attributes)
    coordinates = {
        "time": described("time", path.time, "s", "time after the record's start"),
        "element": ("element", [item.element.name for item in path.placed]),
    }
    return xr.Dataset(variables, coordinates, attributes)
