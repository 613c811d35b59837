"""The functions users call: a grid of cases of a scene, and the paths of its elements in one case."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.dem.blocks import Cases
from overturning.dem.cases import Progress
from overturning.dem.contact import Contact
from overturning.dem.grid import Grid, axis, dataset
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.cases import plan_scene, run_scene_cases
from overturning.dem.polygon.geometry import native_size, place, symmetric
from overturning.dem.polygon.prepare import WIDE
from overturning.dem.polygon.scene import Scene
from overturning.dem.simulate import simulate_arrays
from overturning.dem.status import Status
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.dem.variables import PER_ELEMENT
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

FloatArray = NDArray[np.float64]


def is_block(scene: Scene) -> bool:
    """Whether a scene is one upright free rectangle in the middle of a driven one: the fast kernel's scene."""
    if len(scene.elements) != 2 or scene.gravity != STANDARD_GRAVITY:
        return False
    ground, block = scene.elements
    return (
        ground.kind == "driven"
        and block.kind == "free"
        and ground.vertices is None
        and block.vertices is None
        and ground.rotation_deg == block.rotation_deg == 0
        and block.fallen_rotation_deg == 90
        and block.fallen_drop is None
        and block.at[0] == ground.at[0]
        and (ground.width or 0) > WIDE * max(block.width or 0, block.height or 0)
    )


def block_contact(scene: Scene) -> Contact:
    """The contact of a two-rectangle scene as the fast kernel takes it."""
    ground, block = scene.elements
    law = scene.law(ground, block)
    return Contact(
        stiffness=law.stiffness,
        stiffness_ratio=law.stiffness_ratio,
        damping_ratio=law.damping_ratio,
        damping=law.damping,
        static_penetration=law.static_penetration,
    )


def simulate_scene_arrays(
    scene: Scene,
    motion: Motion,
    *,
    azimuth_deg: ArrayLike,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    scheme: str | None = None,
    time_step: float | str = "auto",
    leave_out: bool = True,
    threads: int = 1,
    progress: Progress | None = None,
    general: bool = False,
) -> dict[str, NDArray[Any]]:
    """Simulate every combination of azimuth, size, slenderness and friction of a scene under one motion.

    Parameters
    ----------
    scene : Scene
        The scene.
    motion : Motion
        The ground's.
    azimuth_deg : array_like, shape (a,)
        Degrees clockwise from north.
    height, b_over_h : array_like, shape (h,), (b,), optional
        Height (m) and slenderness of the reference element; the scene's own where not given. All lengths scale with
        the height; the slenderness changes the reference element's width alone.
    friction : array_like, shape (f,)
        µ of every contact law without one.
    scheme, time_step, leave_out, threads, progress
        As in `overturning.dem.simulate.simulate_arrays`.
    general : bool
        Take the general kernel where the fast one would do.

    Returns
    -------
    dict of ndarray, shape (a, h, b, f) or (a, h, b, f, elements)
        The cube's variables by name and ``block_steps``. The last dimension, the free elements in the scene's order,
        is there for `PER_ELEMENT` where the scene has more than one.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    own_height, own_ratio = native_size(scene)
    axes = [
        axis("azimuth_deg", azimuth_deg),
        axis("height", own_height if height is None else height),
        axis("b_over_h", own_ratio if b_over_h is None else b_over_h),
        axis("friction", friction),
    ]
    if is_block(scene) and not general:
        law = scene.law(*scene.elements)
        arrays = simulate_arrays(
            motion, azimuth_deg=axes[0], height=axes[1], b_over_h=axes[2],
            friction=axes[3] if law.friction is None else [law.friction],
            density=scene.materials[scene.elements[1].material].density, contact=block_contact(scene),
            time_step=time_step, leave_out=leave_out, threads=threads, progress=progress,
            scheme=scheme or DEFAULT_SCHEME,
        )  # fmt: skip
        whole = tuple(axis.size for axis in axes)
        return {name: np.broadcast_to(values, whole).copy() for name, values in arrays.items()}
    mirrors = all(symmetric(place(scene, h, b)) for h in axes[1].tolist() for b in axes[2].tolist())
    grid = Grid.of(axes, leave_out and mirrors)
    found = run_scene_cases(
        scene, motion, grid.cases, scheme=scheme, time_step=time_step, leave_out=leave_out, threads=threads,
        progress=progress,
    )  # fmt: skip
    arrays = grid.spread(found)
    if len(scene.free) == 1:
        arrays |= {name: arrays[name][..., 0] for name in PER_ELEMENT}
    return arrays


def simulate_scene(
    scene: Scene,
    motion: Motion,
    *,
    azimuth_deg: ArrayLike,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    **options: Any,
) -> "xr.Dataset":
    """The same as `simulate_scene_arrays`, as a dataset with named coordinates.

    Returns
    -------
    xarray.Dataset
        The cube's variables over `azimuth`, `height`, `b_over_h`, `friction` and, for those of `PER_ELEMENT` where
        there is more than one free element, `element`.
    """
    own_height, own_ratio = native_size(scene)
    arrays = simulate_scene_arrays(
        scene, motion, azimuth_deg=azimuth_deg, height=height, b_over_h=b_over_h, friction=friction, **options
    )
    height, b_over_h = own_height if height is None else height, own_ratio if b_over_h is None else b_over_h
    return dataset(
        arrays,
        {
            "azimuth": (axis("azimuth_deg", azimuth_deg), "degree", "azimuth, clockwise from north"),
            "height": (axis("height", height), "m", "height of the reference element"),
            "b_over_h": (axis("b_over_h", b_over_h), "1", "slenderness B/H of the reference element"),
            "friction": (axis("friction", friction), "1", "friction coefficient"),
        },
        scene.free if len(scene.free) > 1 else (),
        {"scene": scene.name},
    )


def scene_trajectory(
    scene: Scene,
    motion: Motion,
    *,
    azimuth_deg: float,
    height: float | None = None,
    b_over_h: float | None = None,
    friction: float = 1.0,
    scheme: str | None = None,
    time_step: float | str = "auto",
    leave_out: bool = True,
    amplitude: float = 1.0,
) -> "xr.Dataset":
    """The paths of all elements in one case, bit-equal to its cell of a sweep by the general kernel.

    Parameters
    ----------
    scene, motion, azimuth_deg, height, b_over_h, friction, scheme, time_step, leave_out
        As in `simulate_scene_arrays`, one value each.
    amplitude : float
        Factor on the motion.

    Returns
    -------
    xarray.Dataset
        Over `time` (the record's samples, and on until the case ends) and `element` (all of them): `x`, `z` (centre,
        m), `rotation` (rad, positive towards the azimuth), `velocity_x`, `velocity_z` (m/s), `angular_velocity`
        (rad/s), in the frame of the base; `ground_acceleration` over `time` (m/s²); `vertices` (element, vertex, xz;
        about the centre, NaN beyond an element's last), `kind` and `sample` (0 before the first computed one).
        The attributes hold the cell's outcome, per free element where it is so.
    """
    import xarray as xr

    own_height, own_ratio = native_size(scene)
    size, ratio = (own_height if height is None else height), (own_ratio if b_over_h is None else b_over_h)
    case = Cases([azimuth_deg], [size], [ratio], [friction], [amplitude])
    how = plan_scene(scene, motion, case, scheme=scheme, time_step=time_step, leave_out=leave_out)
    prepared = how.variants[0]
    count = len(prepared.placed)
    first, last = int(how.table[0, t.P_FIRST]), int(how.table[0, t.P_AFTER])
    path = np.zeros((last - first + 3, 2 + 6 * count))
    noted, out, each = 0, np.full((1, t.RESULTS), float(Status.AT_REST)), np.zeros((1, count, t.ELEMENT_RESULTS))
    if not how.never[0]:
        out, each, noted = how.run(motion, np.zeros(1, np.int64), np.zeros(1, np.int64), path)
    quiet = np.zeros((first if noted else motion.samples, 2 + 6 * count))
    quiet[:, t.T_TIME] = np.arange(len(quiet)) * motion.sampling_interval
    quiet[:, t.T_GROUND] = how.ground[0, : len(quiet)] * amplitude
    for index, item in enumerate(prepared.placed):
        rest = np.array([item.x, item.z, 0.0]) + prepared.displacement[index]
        quiet[:, 2 + 6 * index : 5 + 6 * index] = rest
    path = np.concatenate([quiet, path[:noted]])
    poses = path[:, 2:].reshape(len(path), count, 6)
    most = max(len(item.shape.vertices) for item in prepared.placed)
    vertices = np.full((count, most, 2), np.nan)
    for index, item in enumerate(prepared.placed):
        vertices[index, : len(item.shape.vertices)] = item.shape.vertices
    names = {
        "x": (t.T_X, "m", "centre towards the azimuth, in the frame of the base"),
        "z": (t.T_Z, "m", "height of the centre"),
        "rotation": (t.T_ANGLE, "rad", "rotation, positive towards the azimuth"),
        "velocity_x": (t.T_VX, "m s-1", "velocity towards the azimuth, relative to the base"),
        "velocity_z": (t.T_VZ, "m s-1", "upward velocity"),
        "angular_velocity": (t.T_VW, "rad s-1", "angular velocity"),
    }
    free = prepared.free
    variables: dict[str, Any] = {
        name: (("time", "element"), poses[:, :, column], {"units": units, "long_name": text})
        for name, (column, units, text) in names.items()
    }
    variables["ground_acceleration"] = (
        "time", path[:, t.T_GROUND], {"units": "m s-2", "long_name": "acceleration of the base towards the azimuth"},
    )  # fmt: skip
    variables["vertices"] = (
        ("element", "vertex", "xz"), vertices, {"units": "m", "long_name": "vertices about the centre, counter-clockwise"},
    )  # fmt: skip
    variables["kind"] = ("element", [item.element.kind for item in prepared.placed])
    return xr.Dataset(
        variables,
        {
            "time": ("time", path[:, t.T_TIME], {"units": "s", "long_name": "time after the record's start"}),
            "element": ("element", [item.element.name for item in prepared.placed]),
        },
        {
            "scene": scene.name, "status": int(out[0, t.R_STATUS]), "free": list(scene.free),
            "overturned": each[0, free, t.E_SIDE].astype(int).tolist(),
            "overturning_time": each[0, free, t.E_TIME].tolist(),
            "peak_rotation": each[0, free, t.E_ANGLE].tolist(),
            "azimuth_deg": azimuth_deg, "height": size, "b_over_h": ratio, "friction": friction,
        },
    )  # fmt: skip
