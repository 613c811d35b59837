"""The function users call for a grid of cases in space."""

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.dem.body.cases import SpaceCases, sizes_of
from overturning.dem.body.grid import SPACE_DIMENSIONS
from overturning.dem.body.run import run_in_space
from overturning.dem.numerics import Numerics
from overturning.errors import ArgumentError
from overturning.model.contact import VertexContact
from overturning.model.shapes import Shape, shape_of
from overturning.model.variables import INT8_MISSING, SPACE_VARIABLES
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr

LEVEL: Final = "none: the motion has two components, so the base moves level"


def simulate_in_space_arrays(
    motion: Motion,
    *,
    orientation_deg: ArrayLike,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    aspect: ArrayLike = 1.0,
    body: str | int | Shape = "rectangle",
    contact: VertexContact | None = None,
    **options: Any,
) -> dict[str, NDArray[Any]]:
    """Simulate every combination of orientation, size, slenderness, aspect and friction of a body under one motion.

    Parameters
    ----------
    motion : Motion
        The ground's, all of its components.
    orientation_deg : array_like, shape (o,)
        Azimuth to which the body's first side faces, degrees clockwise from north, any real numbers.
    height, b_over_h : array_like, shape (h,), (b,)
        H (m) and B/H. A polyhedron has its own slenderness, and its own height where none is given.
    friction : array_like, shape (f,)
        μ.
    aspect : array_like, shape (a,)
        D/B of a rectangle: its width across over that along the orientation.
    body : str, int or Shape
        "rectangle", "circle", the number of sides of a regular prism, or a `Polyhedron`.
    contact : VertexContact, optional
        Springs and dashpots; `VertexContact()` where not given.
    **options
        Fields of `overturning.dem.numerics.Numerics`. With ``leave_out`` orientations that symmetry makes equal are computed once.

    Returns
    -------
    dict of ndarray, shape (o, h, b, a, f)
        `SPACE_VARIABLES` by name, missing floats as NaN, and ``block_steps``, the work of each cell, 0 where it was left out.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    shape = shape_of(body)
    ratio, size = sizes_of(shape, b_over_h, height)
    axes = [
        np.atleast_1d(np.asarray(values, np.float64)) for values in (orientation_deg, size, ratio, aspect, friction)
    ]
    for name, row in zip(SPACE_DIMENSIONS, axes, strict=True):
        if row.ndim != 1 or row.size == 0:
            raise ArgumentError(f"{name}: shape {row.shape}; give a row of at least one value")
    if not shape.oblong and axes[3].tolist() != [1.0]:
        raise ArgumentError(f"aspect: {axes[3].tolist()}; only a rectangle has one")
    numerics = Numerics(**options)
    cells = SpaceCases(*(values.ravel() for values in np.meshgrid(*axes, indexing="ij")))
    turned, turns = _reduced(shape, cells) if numerics.leave_out else (cells, np.zeros(cells.size, np.int64))
    # Cells that are the same but for a turn by which the body looks the same share their case.
    _, first, place = np.unique(turned.table, axis=0, return_index=True, return_inverse=True)
    results = run_in_space(shape, motion, SpaceCases(*turned.table[np.sort(first)].T), numerics, contact)
    place = np.argsort(np.argsort(first))[place]
    arrays = {name: values[place] for name, values in vars(results).items()}
    down = arrays["fall_face"] != INT8_MISSING
    sides = np.maximum(turns.max(initial=0), 1) if not down.any() else len(shape.body(1.0, 0.5, 1.0).faces)
    arrays["fall_face"][down] = (arrays["fall_face"][down] - turns[down]) % sides
    again = np.ones(cells.size, np.bool_)
    again[first] = False
    arrays["block_steps"][again] = 0
    return {name: values.reshape([axis.size for axis in axes]) for name, values in arrays.items()}


def _reduced(shape: Shape, cells: SpaceCases) -> tuple[SpaceCases, NDArray[np.int64]]:
    """Cases with orientations within the body's period, and by how many sides each was turned for that."""
    table = cells.table.copy()
    turns = np.zeros(cells.size, np.int64)
    sizes, which = np.unique(table[:, 1:4], axis=0, return_inverse=True)
    for index, size in enumerate(sizes):
        body, chosen = shape.body(*(float(value) for value in size)), which == index
        if body.period == 0.0:
            table[chosen, 0] = 0.0
            continue
        whole = np.floor(table[chosen, 0] / body.period)
        table[chosen, 0] -= whole * body.period
        turns[chosen] = np.round(whole * body.period / 360.0 * max(len(body.faces), 1)).astype(np.int64)
    return SpaceCases(*table.T), turns


def simulate_in_space(
    motion: Motion,
    *,
    orientation_deg: ArrayLike,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    aspect: ArrayLike = 1.0,
    body: str | int | Shape = "rectangle",
    **options: Any,
) -> "xr.Dataset":
    """Simulate a free body in space for every combination of orientation, size, slenderness, aspect and friction, as a dataset.

    Parameters and exceptions are those of `simulate_in_space_arrays`.

    Returns
    -------
    xarray.Dataset
        `SPACE_VARIABLES` over `orientation`, `height`, `b_over_h`, `aspect` and `friction`. The attribute `vertical_motion` says
        whether the base moved up and down.

    Examples
    --------
    >>> import numpy as np, overturning
    >>> pulse = 6.0 * np.sin(2 * np.pi * np.arange(101) / 100)
    >>> motion = overturning.Motion(pulse, 0 * pulse, sampling_interval=0.01)
    >>> found = overturning.simulate_in_space(motion, orientation_deg=[0, 30], height=[0.6], b_over_h=[0.15], friction=[0.6])
    >>> found.overturned.values.ravel().tolist()
    [1, 1]
    """
    import xarray as xr

    shape = shape_of(body)
    arrays = simulate_in_space_arrays(
        motion, orientation_deg=orientation_deg, height=height, b_over_h=b_over_h, friction=friction, aspect=aspect,
        body=shape, **options,
    )  # fmt: skip
    ratio, size = sizes_of(shape, b_over_h, height)
    about = (
        (orientation_deg, "degree", "azimuth that the first side faces, clockwise from north"),
        (size, "m", "height of the block"),
        (ratio, "1", "slenderness B/H"),
        (aspect, "1", "aspect D/B of the base"),
        (friction, "1", "friction coefficient"),
    )
    coordinates: dict[str, Any] = {
        name: (name, np.atleast_1d(np.asarray(values)), {"units": units, "long_name": text})
        for name, (values, units, text) in zip(SPACE_DIMENSIONS, about, strict=True)
    }
    return xr.Dataset(
        {item.name: (SPACE_DIMENSIONS, arrays[item.name], item.all_attributes) for item in SPACE_VARIABLES},
        coordinates,
        {"body": shape.name, "vertical_motion": LEVEL if motion.up is None else "as recorded"},
    )
