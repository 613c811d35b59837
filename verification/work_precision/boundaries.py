"""Overturning boundaries: the B/H at which the flag changes, a continuous measure of error.

A method is given by arguments of `run_cases`, a bracket as a share of B/H around an approximate boundary.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.block.state import PARALLEL_CASE_COUNT
from overturning.dem.run import run_cases
from overturning.model.cases import Cases
from overturning.model.variables import INT8_MISSING
from verification.inputs import CaseGroup
from verification.measures import OverturningFlags

RunCasesArguments = Mapping[str, Any]

BISECTION_HALVING_COUNT: Final = 15
"""Number of halvings of the bracket of a boundary, which is then known to 3e-7 of B/H."""

MAX_BISECTION_LEVELS_COMPUTED_TOGETHER: Final = 3
"""Largest number of halvings whose midpoints are run together, to fill the columns of the kernel; same result."""

RELATIVE_BRACKET_HALF_WIDTH: Final = 0.005
"""Half-width of the bracket in which the boundary of a method is searched, as a share of B/H."""

RELATIVE_BOUNDARY_RESOLUTION: Final = 2 * RELATIVE_BRACKET_HALF_WIDTH / 2**BISECTION_HALVING_COUNT
"""Width of the last bracket, as a share of B/H; a smaller shift counts as 0."""


class OverturningBoundaryAlongBOverH(NamedTuple):
    """Overturning boundary between a falling case and its standing neighbour along B/H."""

    case_group_index: int
    """Number of its group."""
    parameters_of_falling_case: dict[str, float]
    """Azimuth (degrees), height (m), friction and B/H of the falling case."""
    b_over_h_of_standing_neighbour: float
    """B/H of its standing neighbour."""


def boundaries_between_falling_and_standing_cases(
    groups: Sequence[CaseGroup], flags: OverturningFlags, max_count_per_group: int
) -> list[OverturningBoundaryAlongBOverH]:
    """Return boundaries: falling cases whose next larger B/H stands, at most `max_count_per_group` in each group.

    `flags` has one flag per case, group after group: ±1 (falls), 0 (stands) or missing.
    """
    found: list[OverturningBoundaryAlongBOverH] = []
    begin = 0
    for number, group in enumerate(groups):
        names = ("azimuth_deg", "height", "friction", "b_over_h")
        rows = np.stack([np.asarray(getattr(group.cases, name)) for name in names], axis=1)
        mine = flags[begin : begin + len(rows)]
        begin += len(rows)
        order = np.lexsort(rows.T[::-1])
        here = 0
        for falls, stands in itertools.pairwise(order):
            same = np.array_equal(rows[falls, :3], rows[stands, :3])
            if same and mine[stands] == 0 and mine[falls] not in (0, INT8_MISSING) and here < max_count_per_group:
                case = dict(zip(names, rows[falls].tolist(), strict=True))
                found.append(OverturningBoundaryAlongBOverH(number, case, float(rows[stands, 3])))
                here += 1
    return found


def boundary_b_over_h_by_usual_and_finest_numerics(
    groups: Sequence[CaseGroup],
    boundaries: Sequence[OverturningBoundaryAlongBOverH],
    usual_run_cases_arguments: RunCasesArguments,
    finest_run_cases_arguments: RunCasesArguments,
    relative_half_width_of_search_bracket: float = RELATIVE_BRACKET_HALF_WIDTH,
) -> tuple[FloatArray, FloatArray]:
    """Return the B/H of overturning boundaries, first by the usual numerics, then by the finest.

    The finest numerics search only in a bracket around the B/H that the usual ones give.
    """
    near = bisect_boundaries(
        groups,
        boundaries,
        usual_run_cases_arguments,
        *falling_and_standing_b_over_h(boundaries),
        2 * BISECTION_HALVING_COUNT,
    )
    return near, bisect_boundaries(
        groups,
        boundaries,
        finest_run_cases_arguments,
        near * (1 - relative_half_width_of_search_bracket),
        near * (1 + relative_half_width_of_search_bracket),
    )


def falling_and_standing_b_over_h(
    boundaries: Sequence[OverturningBoundaryAlongBOverH],
) -> tuple[FloatArray, FloatArray]:
    """Return B/H of the falling cases and of their standing neighbours."""
    return np.array([place.parameters_of_falling_case["b_over_h"] for place in boundaries]), np.array(
        [place.b_over_h_of_standing_neighbour for place in boundaries]
    )


def bisect_boundaries(
    groups: Sequence[CaseGroup],
    boundaries: Sequence[OverturningBoundaryAlongBOverH],
    run_cases_arguments: RunCasesArguments,
    falling_b_over_h_by_boundary: FloatArray,
    standing_b_over_h_by_boundary: FloatArray,
    halving_count: int = BISECTION_HALVING_COUNT,
) -> FloatArray:
    """Return, for each boundary, the B/H between falling and standing, by bisection of all boundaries together.

    The result is NaN for a boundary with a NaN among the two given B/H, and for one whose block does not fall at
    `falling_b_over_h_by_boundary` or does not stand at `standing_b_over_h_by_boundary`.
    """
    known = np.isfinite(falling_b_over_h_by_boundary) & np.isfinite(standing_b_over_h_by_boundary)
    falling_b_over_h_by_boundary, standing_b_over_h_by_boundary = (
        np.where(known, falling_b_over_h_by_boundary, 1.0),
        np.where(known, standing_b_over_h_by_boundary, 1.0),
    )
    fell = _blocks_fall(
        groups, boundaries, run_cases_arguments, np.stack([falling_b_over_h_by_boundary, standing_b_over_h_by_boundary])
    )
    good = known & fell[0] & ~fell[1]
    most = max(sum(place.case_group_index == number for place in boundaries) for number in range(len(groups)))
    together = max(1, min(MAX_BISECTION_LEVELS_COMPUTED_TOGETHER, int(np.log2(PARALLEL_CASE_COUNT / max(most, 1) + 1))))
    while halving_count > 0:
        depth = min(together, halving_count)
        halving_count -= depth
        # All midpoints that the next halvings may need: a binary tree of intervals, level by level.
        lows, highs, middles = falling_b_over_h_by_boundary[None], standing_b_over_h_by_boundary[None], []
        for _ in range(depth):
            middle = 0.5 * (lows + highs)
            middles.append(middle)
            lows = np.stack([lows, middle], axis=1).reshape(-1, falling_b_over_h_by_boundary.size)
            highs = np.stack([middle, highs], axis=1).reshape(-1, falling_b_over_h_by_boundary.size)
        fell = _blocks_fall(groups, boundaries, run_cases_arguments, np.concatenate(middles))
        node, begin, each = (
            np.zeros(falling_b_over_h_by_boundary.size, np.int64),
            0,
            np.arange(falling_b_over_h_by_boundary.size),
        )
        for middle in middles:
            falls, at = fell[begin + node, each], middle[node, each]
            falling_b_over_h_by_boundary, standing_b_over_h_by_boundary = (
                np.where(falls, at, falling_b_over_h_by_boundary),
                np.where(falls, standing_b_over_h_by_boundary, at),
            )
            node, begin = 2 * node + falls, begin + len(middle)
    return np.where(good, 0.5 * (falling_b_over_h_by_boundary + standing_b_over_h_by_boundary), np.nan)


def _blocks_fall(
    groups: Sequence[CaseGroup],
    boundaries: Sequence[OverturningBoundaryAlongBOverH],
    run_cases_arguments: RunCasesArguments,
    b_over_h_by_trial_and_boundary: FloatArray,
) -> NDArray[np.bool_]:
    """Return True where the block of a boundary falls at a trial B/H; shape (trials, boundaries)."""
    fell = np.zeros(b_over_h_by_trial_and_boundary.shape, bool)
    for number, group in enumerate(groups):
        rows = [row for row, place in enumerate(boundaries) if place.case_group_index == number]
        if rows:
            axes = {
                name: np.tile(
                    [boundaries[row].parameters_of_falling_case[name] for row in rows],
                    len(b_over_h_by_trial_and_boundary),
                )
                for name in ("azimuth_deg", "height", "friction")
            }
            found = run_cases(
                group.motion,
                Cases(b_over_h=b_over_h_by_trial_and_boundary[:, rows].ravel(), **axes),
                **run_cases_arguments,
            )
            fell[:, rows] = (found.overturned != 0).reshape(-1, len(rows))
    return fell


def median_relative_boundary_shift(
    groups: Sequence[CaseGroup],
    boundaries: Sequence[OverturningBoundaryAlongBOverH],
    run_cases_arguments: RunCasesArguments,
    bracket_centre_b_over_h: FloatArray,
    reference_boundary_b_over_h: FloatArray,
    relative_half_width_of_search_bracket: float = RELATIVE_BRACKET_HALF_WIDTH,
) -> float:
    """Return the median of |B/H − reference B/H| / (reference B/H) over boundaries computed by a method.

    Each boundary is searched in a bracket around its `bracket_centre_b_over_h`; if the bracket has none, its relative
    half-width counts as the shift. The reference must be found in the same brackets: if the flag changes more than once
    in a bracket, method and reference then find the same change. Boundaries with a NaN in
    `reference_boundary_b_over_h` are left out.
    """
    usable = np.isfinite(reference_boundary_b_over_h)
    if not usable.any():
        return float("nan")
    chosen = [place for place, use in zip(boundaries, usable, strict=True) if use]
    found = bisect_boundaries(
        groups,
        chosen,
        run_cases_arguments,
        bracket_centre_b_over_h[usable] * (1 - relative_half_width_of_search_bracket),
        bracket_centre_b_over_h[usable] * (1 + relative_half_width_of_search_bracket),
    )
    return float(
        np.median(
            np.where(
                np.isnan(found),
                relative_half_width_of_search_bracket,
                np.abs(found / reference_boundary_b_over_h[usable] - 1.0),
            )
        )
    )
