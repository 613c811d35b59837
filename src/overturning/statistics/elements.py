"""How often each element of a scene falls, which falls first, and how one stone's falls compare with another's."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr


@dataclass(frozen=True)
class ElementFalls:
    """Falls of one element, or stone, over the ``cases`` whose outcome is known.

    It ``falls`` to either side in so many, ``first`` in those in which it falls before every other element of its scene or
    alone; ``share`` is falls/cases, ``median_time`` (s) the median of when it falls. Both are NaN where there is none.
    """

    name: str
    cases: int
    falls: int
    first: int
    share: float
    median_time: float


@dataclass(frozen=True)
class StoneComparison:
    """Two stones under the same motions: in how many ``cases``, both outcomes known, which of them falls.

    Of ``both`` they fall to the ``same_side`` in so many, and in so many the first stone falls ``earlier``.
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
    """Falls of each element of a cube, in the scene's order; without the dimension `element` of the one "block"."""
    if "element" not in cube.dims:
        cube = cube.drop_vars("element", errors="ignore").expand_dims(element=["block"])
    sides, times = (
        cube[name].transpose(..., "element").to_numpy().reshape(-1, cube.sizes["element"])
        for name in ("overturned", "overturning_time")
    )
    known = np.isfinite(sides)
    fell = known & (sides != 0)
    when = np.where(fell, np.nan_to_num(times, nan=np.inf), np.inf)
    first = fell & (when == when.min(axis=1, keepdims=True))
    rows = []
    for index, name in enumerate(cube["element"].to_numpy().tolist()):
        cases, falls = int(known[:, index].sum()), int(fell[:, index].sum())
        share, median = falls / cases if cases else math.nan, math.nan
        if falls:
            median = float(np.median(when[fell[:, index], index]))
        rows.append(ElementFalls(str(name), cases, falls, int(first[:, index].sum()), share, median))
    return rows


def compare_stones(name: str, cube: xr.Dataset, other_name: str, other: xr.Dataset) -> StoneComparison:
    """Compare the falls of two stones case by case; the cubes of one element each hold the same cases in the same order."""
    sides, others = (c["overturned"].to_numpy().ravel() for c in (cube, other))
    times, other_times = (c["overturning_time"].to_numpy().ravel() for c in (cube, other))
    known = np.isfinite(sides) & np.isfinite(others)
    this, that = known & (sides != 0), known & (others != 0)
    both, neither = this & that, known & ~this & ~that
    alike = (both & (sides == others), both & (times < other_times))
    counted = (known, both, this & ~that, that & ~this, neither, *alike)
    return StoneComparison(name, other_name, *(int(cases.sum()) for cases in counted))
