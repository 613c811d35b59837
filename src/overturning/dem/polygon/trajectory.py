"""The paths of all elements of a scene in one case, and the forces between them."""

from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.arrays import FloatArray
from overturning.dem.blocks import Cases
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.cases import plan_scene
from overturning.dem.polygon.geometry import native_size
from overturning.dem.polygon.prepare import Prepared
from overturning.dem.polygon.scene import Scene
from overturning.dem.status import Status
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr


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
        As in `overturning.dem.polygon.simulate.simulate_scene_arrays`, one value each.
    amplitude : float
        Factor on the motion.

    Returns
    -------
    xarray.Dataset
        Over `time` (the record's samples, and on until the case ends) and `element` (all of them): `x`, `z` (centre,
        m), `rotation` (rad, positive towards the azimuth), `velocity_x`, `velocity_z` (m/s), `angular_velocity`
        (rad/s), in the frame of the base; `ground_acceleration` over `time` (m/s²); `vertices` (element, vertex, xz;
        about the centre, NaN beyond an element's last) and `kind`. Over `time` and `contact` (both ends of each pair
        that can meet): `contact_force` (N, on the element `contact_on` from `contact_by`; mean from this sample to the
        next) and `contact_place` (m, its mean weighted by the normal force), NaN where nothing was computed and,
        of the place, where nothing touched.
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
    poses_end, pairs = 2 + 6 * count, len(prepared.pairs)
    path = np.zeros((last - first + 3, poses_end + 2 * t.FORCE_COLUMNS * pairs))
    noted, out, each = 0, np.full((1, t.RESULTS), float(Status.AT_REST)), np.zeros((1, count, t.ELEMENT_RESULTS))
    if not how.never[0]:
        out, each, noted = how.run(motion, np.zeros(1, np.int64), np.zeros(1, np.int64), path)
    quiet = np.zeros((first if noted else motion.samples, path.shape[1]))
    quiet[:, poses_end:] = np.nan
    quiet[:, t.T_TIME] = np.arange(len(quiet)) * motion.sampling_interval
    quiet[:, t.T_GROUND] = how.ground[0, : len(quiet)] * amplitude
    for index, item in enumerate(prepared.placed):
        rest = np.array([item.x, item.z, 0.0]) + prepared.displacement[index]
        quiet[:, 2 + 6 * index : 5 + 6 * index] = rest
    path = np.concatenate([quiet, path[:noted]])
    poses = path[:, 2:poses_end].reshape(len(path), count, 6)
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
    variables |= _contacts(prepared, path[:, poses_end:].reshape(len(path), 2 * pairs, t.FORCE_COLUMNS))
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
            "weight": sum(prepared.placed[k].mass for k in free) * scene.gravity,
            "azimuth_deg": azimuth_deg, "height": size, "b_over_h": ratio, "friction": friction,
        },
    )  # fmt: skip


def _contacts(prepared: Prepared, noted: FloatArray) -> dict[str, Any]:
    """Forces and places of the ends of all pairs, shape (time, ends, FORCE_COLUMNS), as variables."""
    force, load = noted[:, :, [t.T_FX, t.T_FZ]], noted[:, :, [t.T_LOAD]]
    place = noted[:, :, [t.T_LOAD_X, t.T_LOAD_Z]] / np.where(load > 0.0, load, np.nan)
    names: list[tuple[str, str]] = []
    for index, (first, second) in enumerate(prepared.pairs):
        # On the later element, which stands on the earlier one, unless forces do not move it.
        on, by = sorted((first, second), key=lambda k: (prepared.placed[k].fixed, -k))
        if on == second:
            force[:, 2 * index : 2 * index + 2] *= -1.0
        names += 2 * [(prepared.placed[on].element.name, prepared.placed[by].element.name)]
    text = "mean from this sample to the next"
    return {
        "contact_force": (
            ("time", "contact", "xz"),
            force,
            {"units": "N", "long_name": f"force on contact_on, {text}"},
        ),
        "contact_place": (("time", "contact", "xz"), place, {"units": "m", "long_name": f"where it acts, {text}"}),
        "contact_on": ("contact", [on for on, _ in names]),
        "contact_by": ("contact", [by for _, by in names]),
    }
