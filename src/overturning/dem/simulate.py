"""The functions users call for a grid of cases: as arrays, and as a dataset."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.dem.numerics import Numerics
from overturning.dem.polygon.prepare import CRITICAL, critical_angles
from overturning.dem.run import run
from overturning.model.contact import Contact
from overturning.model.geometry import plane_period
from overturning.model.grid import DIMENSIONS, Grid
from overturning.model.scene import Scene, scene_or_gravestone
from overturning.model.symmetry import FULL_TURN
from overturning.model.variables import VARIABLES
from overturning.motion.motion import Motion, as_motion
from overturning.units import GRANITE_DENSITY

if TYPE_CHECKING:
    import xarray as xr


def simulate_arrays(
    motion: Motion,
    *,
    azimuth_deg: ArrayLike,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    scene: Scene | None = None,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    **options: Any,
) -> dict[str, NDArray[Any]]:
    """Simulate every combination of azimuth, size, slenderness and friction under one motion.

    Parameters and exceptions are those of `overturning.simulate`.

    Returns
    -------
    dict of ndarray, shape (a, h, b, f) or (a, h, b, f, elements)
        The cube's variables by name, missing floats as NaN, and ``block_steps``, the work of each cell, 0 where it
        was left out. The last dimension, the free elements in the scene's order, is there where the scene has more than
        one and the variable is each element's.
    """
    motion = as_motion(motion)
    scene, height, b_over_h = scene_or_gravestone(scene, contact, density, height, b_over_h)
    grid = Grid.over(azimuth_deg=azimuth_deg, height=height, b_over_h=b_over_h, friction=friction)
    return simulate_grid(scene, motion, grid, Numerics(**options))


def simulate_grid(scene: Scene, motion: Motion, grid: Grid, numerics: Numerics) -> dict[str, NDArray[Any]]:
    """Simulate the cases of a grid; as `simulate_arrays`."""
    period = plane_period(scene) if numerics.leave_out else FULL_TURN
    # Where the scene has all its coefficients, the answers are the same for each one of the grid.
    few = grid if scene.sweeps_friction else Grid(grid.azimuth, grid.height, grid.b_over_h, grid.friction[:1])
    results = run(scene, motion, few.cases(period), numerics)
    arrays = few.spread(results.element(0) if len(scene.free) == 1 else results, period)
    return {name: np.repeat(values, grid.shape[3] // few.shape[3], axis=3) for name, values in arrays.items()}


def simulate(
    motion: Motion,
    *,
    azimuth_deg: ArrayLike,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    scene: Scene | None = None,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    **options: Any,
) -> "xr.Dataset":
    """Simulate every combination of azimuth, size, slenderness and friction under one motion, as a dataset.

    Parameters
    ----------
    motion : Motion or Record
        The ground's; a record as `overturning.read` returns it.
    azimuth_deg : array_like, shape (a,)
        Degrees clockwise from north, any real numbers.
    height, b_over_h : array_like, shape (h,), (b,), optional
        Height (m) and slenderness of the reference element; the scene's own where not given. All lengths scale with
        the height; the slenderness changes the reference element's width alone.
    friction : array_like, shape (f,)
        µ of every contact law without one.
    scene : Scene, optional
        The scene; one block on the ground where not given.
    density : float
        kg/m³, of the block; matters only where the contact is given in absolute terms. A scene has its own.
    contact : Contact, optional
        Springs and dashpots of the block; `overturning.Contact()` where not given. A scene has its own.
    **options
        Fields of `overturning.dem.numerics.Numerics`.

    Returns
    -------
    xarray.Dataset
        The cube's variables over `azimuth`, `height`, `b_over_h`, `friction` and, where the scene has more than one free
        element and the variable is each element's, `element`.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.

    Examples
    --------
    >>> import numpy as np, overturning
    >>> pulse = 3.0 * np.sin(2 * np.pi * np.arange(101) / 100)
    >>> motion = overturning.Motion(pulse, 0 * pulse, sampling_interval=0.01)
    >>> result = overturning.simulate(motion, azimuth_deg=[0, 180], height=[0.6], b_over_h=[0.15], friction=[1.0])
    >>> int(result.overturned.sum())  # the two directions mirror each other
    0
    """
    import xarray as xr

    arrays = simulate_arrays(
        motion, azimuth_deg=azimuth_deg, height=height, b_over_h=b_over_h, friction=friction, scene=scene, density=density,
        contact=contact, **options,
    )  # fmt: skip
    named, height, b_over_h = scene_or_gravestone(scene, None, GRANITE_DENSITY, height, b_over_h)
    several = named.free if len(named.free) > 1 else ()
    grid = Grid.over(several, azimuth_deg=azimuth_deg, height=height, b_over_h=b_over_h, friction=friction)
    about = (
        ("degree", "azimuth, clockwise from north"),
        ("m", "height of the reference element"),
        ("1", "slenderness B/H of the reference element"),
        ("1", "friction coefficient"),
    )
    coordinates: dict[str, Any] = {
        name: (name, getattr(grid, name), {"units": units, "long_name": text})
        for name, (units, text) in zip(DIMENSIONS, about, strict=True)
    }
    if several:
        coordinates["element"] = list(several)
    if not named.single_block:
        angles = critical_angles(named, grid.b_over_h)
        coordinates["critical_angle"] = (
            ("b_over_h", "element") if several else "b_over_h", angles if several else angles[:, 0], CRITICAL,
        )  # fmt: skip
    return xr.Dataset(
        {item.name: (grid.dimensions(item), arrays[item.name], item.all_attributes) for item in VARIABLES},
        coordinates,
        {"scene": named.name},
    )
