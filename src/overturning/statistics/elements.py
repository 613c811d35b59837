"""How often each element of a scene falls, which falls first, and how one stone's falls compare with another's."""

from dataclasses import dataclass

import numpy as np
import xarray as xr


@dataclass(frozen=True)
class ElementFalls:
    """Falls of one element over all cases in which the outcome is known.

    Attributes
    ----------
    name : str
        The element, or the stone.
    cases : int
        Cases with a known outcome.
    falls : int
        Cases in which it falls to either side.
    first : int
        Cases in which it falls before every other element of its scene, or alone.
    share : float
        falls/cases; NaN without cases.
    median_time : float
        Median of the time of its falls, s; NaN without falls.
    """

    name: str
    cases: int
    falls: int
    first: int
    share: float
    median_time: float


@dataclass(frozen=True)
class StoneComparison:
    """Two stones under the same motions.

    Attributes
    ----------
    name, other : str
        The stones.
    cases : int
        Cases in which both outcomes are known.
    both, only_this, only_other, neither : int
        Cases in which they fall.
    same_side : int
        Of `both`, cases in which they fall to the same side.
    earlier : int
        Of `both`, cases in which the first stone falls before the other.
    """

    name: str
    other: str
    cases: int
    both: int
    only_this: int
    only_other: int
    neither: int
    same_side: int
    earlier: int


def falls_by_element(cube: xr.Dataset) -> list[ElementFalls]:
    """Falls of each element of a cube with the dimension `element`, in the scene's order.

    Parameters
    ----------
    cube : xarray.Dataset
        With `overturned` and `overturning_time`; without the dimension, the one element is called "block".

    Returns
    -------
    list of ElementFalls
    """
    if "element" not in cube.dims:
        cube = cube.drop_vars("element", errors="ignore").expand_dims(element=["block"])
    sides = cube["overturned"].transpose(..., "element").to_numpy().reshape(-1, cube.sizes["element"])
    times = cube["overturning_time"].transpose(..., "element").to_numpy().reshape(-1, cube.sizes["element"])
    known = np.isfinite(sides)
    fell = known & (sides != 0)
    when = np.where(fell, np.nan_to_num(times, nan=np.inf), np.inf)
    earliest = when.min(axis=1, keepdims=True)
    first = fell & (when == earliest)
    rows = []
    for index, name in enumerate(cube["element"].to_numpy().tolist()):
        cases, falls = int(known[:, index].sum()), int(fell[:, index].sum())
        rows.append(
            ElementFalls(
                str(name),
                cases,
                falls,
                int(first[:, index].sum()),
                falls / cases if cases else float("nan"),
                float(np.median(when[fell[:, index], index])) if falls else float("nan"),
            )
        )
    return rows


def compare_stones(name: str, cube: xr.Dataset, other_name: str, other: xr.Dataset) -> StoneComparison:
    """Compare the falls of two stones case by case.

    Parameters
    ----------
    name, other_name : str
        What to call them.
    cube, other : xarray.Dataset
        Cubes of one element each, with the same cases in the same order.

    Returns
    -------
    StoneComparison
    """
    sides, others = (c["overturned"].to_numpy().ravel() for c in (cube, other))
    times, other_times = (c["overturning_time"].to_numpy().ravel() for c in (cube, other))
    known = np.isfinite(sides) & np.isfinite(others)
    this, that = known & (sides != 0), known & (others != 0)
    both = this & that
    return StoneComparison(
        name,
        other_name,
        int(known.sum()),
        int(both.sum()),
        int((this & ~that).sum()),
        int((that & ~this).sum()),
        int((known & ~this & ~that).sum()),
        int((both & (sides == others)).sum()),
        int((both & (times < other_times)).sum()),
    )
