"""The functions users call: a grid of cases, and the path of one."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.dem.blocks import Cases
from overturning.dem.cases import BUDGET, Progress, run_cases
from overturning.dem.contact import Contact
from overturning.dem.grid import Grid, axis, dataset
from overturning.dem.plan import DEEPEST, plan
from overturning.dem.status import Status
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.motion.motion import Motion
from overturning.units import GRANITE_DENSITY, STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

FloatArray = NDArray[np.float64]


def simulate_arrays(
    motion: Motion,
    *,
    azimuth_deg: ArrayLike,
    height: ArrayLike,
    b_over_h: ArrayLike,
    friction: ArrayLike,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    scheme: str = DEFAULT_SCHEME,
    time_step: float | str = "auto",
    leave_out: bool = True,
    threads: int = 1,
    progress: Progress | None = None,
) -> dict[str, NDArray[Any]]:
    """Simulate every combination of azimuth, height, slenderness and friction under one motion.

    Parameters
    ----------
    motion : Motion
        The ground's.
    azimuth_deg : array_like, shape (a,)
        Degrees clockwise from north, any real numbers.
    height : array_like, shape (h,)
        H, m.
    b_over_h : array_like, shape (b,)
        Slenderness B/H.
    friction : array_like, shape (f,)
        μ between block and base.
    density : float
        kg/m³; matters only where the contact is given in absolute terms.
    contact : Contact, optional
        Springs and dashpots; `Contact()` where not given.
    scheme : str
        Integration scheme, see docs/method.md.
    time_step : float or str
        Largest step, s; "auto"; or a fraction of the stable step such as "0.25 stable".
    leave_out : bool
        Leave out what changes no flag: mirrored azimuths, cases below both thresholds, the time before and after
        a block can move.
    threads : int
        Threads to share the cases among; the bits do not depend on it.
    progress : callable, optional
        Called now and then with the block steps done and those expected.

    Returns
    -------
    dict of ndarray, shape (a, h, b, f)
        The cube's variables by name, missing floats as NaN, and ``block_steps``, the work of each cell, 0 where it
        was left out.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    axes = [axis(name, values) for name, values in (
        ("azimuth_deg", azimuth_deg), ("height", height), ("b_over_h", b_over_h), ("friction", friction)
    )]  # fmt: skip
    grid = Grid.of(axes, leave_out)
    found = run_cases(
        motion, grid.cases, density=density, contact=contact, scheme=scheme, time_step=time_step, leave_out=leave_out,
        threads=threads, progress=progress,
    )  # fmt: skip
    return grid.spread(found)


def simulate(
    motion: Motion,
    *,
    azimuth_deg: ArrayLike,
    height: ArrayLike,
    b_over_h: ArrayLike,
    friction: ArrayLike,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    scheme: str = DEFAULT_SCHEME,
    time_step: float | str = "auto",
    leave_out: bool = True,
    threads: int = 1,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """Simulate every combination of azimuth, height, slenderness and friction under one motion, as a dataset.

    Parameters and exceptions are those of `simulate_arrays`.

    Returns
    -------
    xarray.Dataset
        The cube's variables over `azimuth`, `height`, `b_over_h`, `friction`.

    Examples
    --------
    >>> import numpy as np, overturning
    >>> pulse = 3.0 * np.sin(2 * np.pi * np.arange(101) / 100)
    >>> motion = overturning.Motion(pulse, 0 * pulse, sampling_interval=0.01)
    >>> result = overturning.simulate(motion, azimuth_deg=[0, 180], height=[0.6], b_over_h=[0.15], friction=[1.0])
    >>> int(result.overturned.sum())  # the two directions mirror each other
    0
    """
    arrays = simulate_arrays(
        motion, azimuth_deg=azimuth_deg, height=height, b_over_h=b_over_h, friction=friction, density=density,
        contact=contact, scheme=scheme, time_step=time_step, leave_out=leave_out, threads=threads, progress=progress,
    )  # fmt: skip
    return dataset(
        arrays,
        {
            "azimuth": (axis("azimuth_deg", azimuth_deg), "degree", "azimuth, clockwise from north"),
            "height": (axis("height", height), "m", "height of the block"),
            "b_over_h": (axis("b_over_h", b_over_h), "1", "slenderness B/H"),
            "friction": (axis("friction", friction), "1", "friction coefficient"),
        },
    )


def trajectory(
    motion: Motion,
    *,
    azimuth_deg: float,
    height: float,
    b_over_h: float,
    friction: float,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    scheme: str = DEFAULT_SCHEME,
    time_step: float | str = "auto",
    leave_out: bool = True,
    amplitude: float = 1.0,
    initial_tilt: float = 0.0,
) -> "xr.Dataset":
    """The path of one case, bit-equal to its cell of a sweep with the same arguments.

    Parameters are those of `simulate_arrays` with one value each; `amplitude` and `initial_tilt` (rad) as in `Cases`.

    Returns
    -------
    xarray.Dataset
        Over `time` (s after the record's start; about once per sample of the record, more often where a contact changes or a step is done again,
        and after it until the case ends): `rotation`
        (rad), `angular_velocity` (rad/s), `x`, `z` (centre of the block relative to the base's midpoint at rest, m),
        `velocity_x`, `velocity_z` (m/s), `base_slip` (m), `penetration_left`, `penetration_right` (m, negative where
        the corner is up) and `ground_acceleration` (m/s²). The attributes hold the cell's values.
    """
    import xarray as xr

    from overturning.dem.block import queue as kernel
    from overturning.dem.block import tables as k

    case = Cases([azimuth_deg], [height], [b_over_h], [friction], [amplitude], 1.0, [initial_tilt])
    how = plan(
        motion, case, density=density, contact=contact or Contact(), scheme=scheme, time_step=time_step,
        leave_out=leave_out,
    )  # fmt: skip
    one = np.zeros(1, np.int64)
    out = np.zeros((1, k.RESULTS))
    out[0, k.R_STATUS] = Status.AT_REST
    path = np.zeros((0, k.TRAJECTORY))
    noted = 0
    if not how.never[0]:
        # The first run counts the rows, the second fills them.
        for _ in range(2):
            noted = kernel.run_queue(
                kernel.SCHEMES[how.scheme][0], one, how.table(one), one, np.full(1, friction) if friction > 0 else None,
                kernel.Ground(how.ground, how.upward, motion.samples, motion.sampling_interval), int(how.steps[0]),
                kernel.Limits(STANDARD_GRAVITY, DEEPEST, BUDGET), np.zeros(1, np.int64), path, out,
            )  # fmt: skip
            path = path if noted else np.zeros((int(out[0, k.R_STEPS]) // int(how.steps[0]), k.TRAJECTORY))
    path = np.concatenate([_rest(motion, how, noted), path[:noted]])
    names = {
        "rotation": (k.T_ANGLE, "rad", "rotation, positive towards the azimuth"),
        "angular_velocity": (k.T_VW, "rad s-1", "angular velocity"),
        "x": (k.T_X, "m", "centre of the block towards the azimuth, relative to the base"),
        "z": (k.T_Z, "m", "height of the centre of the block"),
        "velocity_x": (k.T_VX, "m s-1", "velocity of the centre towards the azimuth, relative to the base"),
        "velocity_z": (k.T_VZ, "m s-1", "upward velocity of the centre"),
        "base_slip": (k.T_BASE_SLIP, "m", "displacement of the midpoint of the block's base"),
        "penetration_left": (k.T_DEPTH_L, "m", "penetration of the corner away from the azimuth"),
        "penetration_right": (k.T_DEPTH_R, "m", "penetration of the corner towards the azimuth"),
        "ground_acceleration": (k.T_GROUND, "m s-2", "acceleration of the base towards the azimuth"),
    }
    cell = {
        "status": int(out[0, k.R_STATUS]),
        "peak_rotation": float(np.float32(out[0, k.R_ANGLE])),
        "overturned": int(out[0, k.R_SIDE]),
        "block_steps": int(out[0, k.R_STEPS]),
        "azimuth_deg": azimuth_deg,
        "height": height,
        "b_over_h": b_over_h,
        "friction": friction,
    }
    return xr.Dataset(
        {name: ("time", path[:, column], {"units": units, "long_name": text}) for name, (column, units, text) in names.items()},
        {"time": ("time", path[:, k.T_TIME], {"units": "s", "long_name": "time after the record's start"})},
        cell,
    )  # fmt: skip


def _rest(motion: Motion, how: Any, noted: int) -> FloatArray:
    """Rows of the time that was left out before the first computed sample, the block at rest."""
    from overturning.dem.block import tables as k

    count = int(how.first[0]) if noted else motion.samples
    rows = np.zeros((count, k.TRAJECTORY))
    rows[:, k.T_TIME] = np.arange(count) * motion.sampling_interval
    depth = 0.5 * STANDARD_GRAVITY / how.normal[0]
    rows[:, k.T_Z] = 0.5 * float(np.asarray(how.cases.height)[0]) - depth
    rows[:, k.T_DEPTH_L] = rows[:, k.T_DEPTH_R] = depth
    rows[:, k.T_GROUND] = how.ground[0, :count] * float(np.asarray(how.cases.amplitude)[0])
    return rows
