"""How often each element of a scene falls, and any; which falls first; how one stone's falls compare with another's."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.statistics.by_record import each_record


@dataclass(frozen=True)
class ElementFalls:
    """Falls of one element, or stone, over the ``cases`` whose outcome is known.

    It ``falls`` to either side in so many, ``first`` in those in which it falls before every other element of its scene
    or alone; ``share`` is falls/cases, ``median_time`` (s) the median of when it falls. Both are NaN where there is
    none.
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


_OUTCOME = ("overturned", "overturning_time")

ANYTHING = "any element"
"""Name of the row of a scene as a whole: it falls where any of its elements does, at the time of the first."""


def falls_by_element(cube: xr.Dataset) -> list[ElementFalls]:
    """Falls of each element of a cube, in order, and of several last of `ANYTHING`; else of the one "block".

    The cube is read one record at a time; of the times of falls all are kept, since medians need them: four bytes for
    each.
    """
    if "element" not in cube.dims:
        cube = cube.drop_vars("element", errors="ignore").expand_dims(element=["block"])
    elements = cube.sizes["element"]
    names = [str(name) for name in cube["element"].to_numpy().tolist()] + [ANYTHING] * (elements > 1)
    counts = np.zeros((3, len(names)), np.int64)
    moments: dict[str, list[NDArray[np.float32]]] = {name: [] for name in names}
    for one in each_record(cube, _OUTCOME):
        sides, times = (one[name].transpose(..., "element").to_numpy().reshape(-1, elements) for name in _OUTCOME)
        known = np.isfinite(sides)
        fell = known & (sides != 0)
        when = np.where(fell, np.nan_to_num(times, nan=np.inf), np.inf)
        if elements > 1:
            known, fell = (np.column_stack([known, known.any(axis=1)]), np.column_stack([fell, fell.any(axis=1)]))
            when = np.column_stack([when, when.min(axis=1)])
        first = fell & (when == when.min(axis=1, keepdims=True))
        counts += np.stack([cells.sum(axis=0) for cells in (known, fell, first)])
        for index, name in enumerate(names):
            moments[name].append(when[fell[:, index], index])
    rows = []
    for name, (cases, falls, earliest) in zip(names, counts.T.tolist(), strict=True):
        median = float(np.median(np.concatenate(moments.pop(name)), overwrite_input=True)) if falls else math.nan
        rows.append(ElementFalls(name, cases, falls, earliest, falls / cases if cases else math.nan, median))
    return rows


def compare_stones(name: str, cube: xr.Dataset, other_name: str, other: xr.Dataset) -> StoneComparison:
    """Compare the falls of two stones case by case, one record at a time.

    The cubes of one element each hold the same cases in the same order.
    """
    counts = np.zeros(7, np.int64)
    for one, another in zip(each_record(cube, _OUTCOME), each_record(other, _OUTCOME), strict=True):
        (sides, times), (others, other_times) = ([c[of].to_numpy().ravel() for of in _OUTCOME] for c in (one, another))
        known = np.isfinite(sides) & np.isfinite(others)
        this, that = known & (sides != 0), known & (others != 0)
        both, neither = this & that, known & ~this & ~that
        alike = (both & (sides == others), both & (times < other_times))
        counts += [int(cases.sum()) for cases in (known, both, this & ~that, that & ~this, neither, *alike)]
    return StoneComparison(name, other_name, *counts.tolist())
