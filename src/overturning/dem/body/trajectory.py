"""The path of a body in space in one case."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body import plan as body_plan
from overturning.dem.body.cases import SpaceCases, sizes_of
from overturning.dem.body.plan import SpacePlan, Start
from overturning.dem.body.results import SpaceResults
from overturning.dem.body.rules import ROW, START
from overturning.dem.numerics import Numerics
from overturning.model.contact import VertexContact
from overturning.model.shapes import Shape, shape_of
from overturning.model.variables import SPACE_VARIABLES
from overturning.motion.direction import direction_cosines
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr


def trajectory_in_space(
    motion: Motion,
    *,
    orientation_deg: float,
    height: float | None = None,
    b_over_h: float | None = None,
    friction: float = 1.0,
    aspect: float = 1.0,
    body: str | int | Shape = "rectangle",
    contact: VertexContact | None = None,
    amplitude: float = 1.0,
    start: Start | None = None,
    **options: Any,
) -> "xr.Dataset":
    """The path of a body in one case, bit-equal to its cell of a sweep with the same arguments.

    Parameters
    ----------
    motion, orientation_deg, height, b_over_h, friction, aspect, body, contact
        As in `overturning.dem.body.simulate.simulate_in_space_arrays`, one value each.
    amplitude : float
        Factor on the whole motion.
    start : Start, optional
        Where and how it begins; at rest on its base where not given.
    **options
        Fields of `overturning.dem.numerics.Numerics`.

    Returns
    -------
    xarray.Dataset
        Over `time`, about once per sample until the case ends, in the frame of the base: `place` and `velocity` of the centre over `enu`
        (east, north, up; m and m/s), `quaternion` over `wxyz`, the rotation from the pose at rest, `angular_velocity` over `enu`
        (rad/s), `tilt_north` and `tilt_east` (components of the body's axis, 1), `ground_acceleration` over `enu` (m/s²). Over `corner` and
        `enu`, `outline`: the body at rest about its centre, m; over `edge` and `end`, `edges` between corners. So a corner is at
        place + quaternion · outline · conjugate. And the cell's outcome. Attributes: what it was called with, and its block steps.

    Raises
    ------
    ArgumentError
        As `overturning.dem.body.run.run_in_space`, and where the path would be longer than `overturning.dem.plan.MOST_PATH`.
    """
    shape = shape_of(body)
    ratio, size = (float(np.asarray(value)) for value in sizes_of(shape, b_over_h, height))
    case = SpaceCases([orientation_deg], size, ratio, aspect, friction, amplitude)
    numerics = Numerics(**options)
    planned = body_plan.plan_in_space(shape, motion, case, numerics, contact or VertexContact(), start)
    results, path = _trace(planned)
    attributes = {
        "body": shape.name, "orientation_deg": orientation_deg, "height": size, "b_over_h": ratio, "aspect": aspect,
        "friction": friction, "amplitude": amplitude, "block_steps": int(results.block_steps[0]),
    }  # fmt: skip
    corners, edges = shape.outline(size, ratio, aspect)
    return _dataset(path, results, attributes, corners, edges)


def _trace(planned: SpacePlan) -> tuple[SpaceResults, NDArray[np.void]]:
    """Results and path of a plan's only case."""
    results, only = planned.uncomputed(), np.zeros(1, np.int64)
    motion, case, path = planned.motion, planned.table[0], np.zeros(0, ROW)
    still = bool(planned.never[0] or planned.hopeless[0])
    if not still:
        out, path = planned.compute(only, np.zeros(1, np.int64), np.zeros(motion.samples, ROW))
        planned.store(results, only, out)
    rest = np.zeros(motion.samples if still else int(planned.first[0]), ROW)
    rest["time"] = np.arange(rest.size) * motion.sampling_interval
    for name in START.names or ():
        rest[name] = case["start"][name]
    rest["ground_x"], rest["ground_y"] = planned.along[0, :, : rest.size] * case["amplitude"]
    if motion.up is not None:
        rest["ground_z"] = motion.up[: rest.size] * case["amplitude"]
    return results, np.concatenate([rest, path])


def _dataset(
    path: NDArray[np.void],
    results: SpaceResults,
    attributes: dict[str, Any],
    corners: FloatArray,
    edges: NDArray[np.int64],
) -> "xr.Dataset":
    import xarray as xr

    cosine, sine = direction_cosines(float(attributes["orientation_deg"]))

    def enu(columns: FloatArray) -> FloatArray:
        # x points to the orientation, y 90° anticlockwise of it.
        x, y, z = np.moveaxis(columns, -1, 0)
        return np.stack([x * sine - y * cosine, x * cosine + y * sine, z], axis=-1)

    def described(dimensions: str, values: Any, units: str, long_name: str) -> tuple[Any, ...]:
        return dimensions.split(), values, {"units": units, "long_name": long_name}

    def of(*names: str) -> FloatArray:
        return np.stack([path[name] for name in names], axis=-1)

    quaternion = of("qw", "qx", "qy", "qz")
    w, x, y, z = quaternion.T
    axis = enu(np.stack([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], axis=-1))
    variables = {
        "place": described("time enu", enu(of("x", "y", "z")), "m", "centre, in the frame of the base"),
        "quaternion": described(
            "time wxyz",
            np.concatenate([quaternion[:, :1], enu(quaternion[:, 1:])], axis=1),
            "1",
            "rotation from the pose at rest",
        ),
        "velocity": described("time enu", enu(of("vx", "vy", "vz")), "m s-1", "of the centre, relative to the base"),
        "angular_velocity": described("time enu", enu(of("wx", "wy", "wz")), "rad s-1", "angular velocity"),
        "tilt_north": described("time", axis[:, 1], "1", "northward component of the body's axis"),
        "tilt_east": described("time", axis[:, 0], "1", "eastward component of the body's axis"),
        "ground_acceleration": described(
            "time enu", enu(of("ground_x", "ground_y", "ground_z")), "m s-2", "acceleration of the base"
        ),
        "outline": described("corner enu", enu(corners), "m", "corners at rest, from the centre"),
        "edges": (("edge", "end"), edges),
    }
    variables |= {item.name: ((), getattr(results, item.name)[0], item.all_attributes) for item in SPACE_VARIABLES}
    coordinates = {
        "time": described("time", path["time"], "s", "time after the record's start"),
        "enu": ("enu", ["east", "north", "up"]),
    }
    return xr.Dataset(variables, coordinates, attributes)
