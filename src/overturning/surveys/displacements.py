"""Shifts and twists of the standing stones of a survey, and fall directions, next to those of the 3-D model."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.settings import StonePopulation
from overturning.statistics.bootstrap import exact_median_interval, exact_share_interval
from overturning.surveys.counted_stones import fallen_and_all_stone_counts, stones_of_sites_with_standing_stones
from overturning.surveys.directions_in_space import compare_fall_directions
from overturning.surveys.displacement_results import (
    ComparedStatisticName,
    FallAndDisplacementComparison,
    ObservedAndComputedStatistic,
)
from overturning.surveys.row import SurveyRow
from overturning.surveys.stone_in_grid import (
    has_shape_far_outside_grid,
    nearest_grid_indices_of_stone,
    stone_dimensions_described_from_side_nearer_to_grid,
)
from overturning.surveys.stones import RANDOM_OUTCOME_SHARE, Stone, SurveyTable

MIN_SHIFT_COUNTED_AS_SHIFTED_M: Final = StonePopulation().shifted
"""Shift from which a standing stone counts as shifted, m; people rarely note smaller ones."""

MIN_TWIST_COUNTED_AS_TWISTED_DEG: Final = StonePopulation().rotated
"""Absolute twist from which a standing stone counts as twisted, degrees."""

_ROUNDING_TOLERANCE: Final = 1e-9


class _ObservedStone(NamedTuple):
    """Surveyed stone that statistics count, with its shift (m) and twist (degrees, clockwise); NaN if unknown."""

    stone: Stone
    shift_m: float
    clockwise_twist_deg: float


class _SimulatedCasesResemblingStones(NamedTuple):
    """Simulated cases that resemble observed stones: weight, friction index, shift (m), twist (degrees clockwise)."""

    weight: FloatArray
    friction_index: NDArray[np.intp]
    shift_m: FloatArray
    clockwise_twist_deg: FloatArray


class _CaseOutcomeArrays(NamedTuple):
    """Outcomes of all cases of a 3-D results cube, as arrays whose first axis is friction.

    `grid_values_by_dimension` has the coordinates of the dimensions by which a stone is compared with the cases.
    """

    dimension_names: tuple[str, ...]
    grid_values_by_dimension: dict[str, FloatArray]
    overturned_flags: NDArray[np.floating]
    fall_azimuth_deg: NDArray[np.floating]
    residual_slip_north_m: NDArray[np.floating]
    residual_slip_east_m: NDArray[np.floating]
    residual_twist_deg: NDArray[np.floating]

    @classmethod
    def from_cube(cls, cube: xr.Dataset) -> "_CaseOutcomeArrays":
        """Copy the outcomes of a results cube into arrays; without a friction dimension the first axis has length 1."""
        names = ("overturned", "fall_azimuth", "residual_slip_north", "residual_slip_east", "residual_twist")
        ordered = [cube[name].transpose("friction", ..., missing_dims="ignore") for name in names]
        arrays = (one.to_numpy() if "friction" in one.dims else one.to_numpy()[None] for one in ordered)
        dimensions = ("friction", *(str(name) for name in cube["overturned"].dims if name != "friction"))
        compared = [name for name in ("height", "b_over_h", "aspect", "orientation") if name in dimensions]
        return cls(dimensions, {name: cube[name].to_numpy() for name in compared}, *arrays)


def compare_falls_shifts_and_twists(
    table: SurveyTable,
    cube: xr.Dataset,
    results_cube_by_site: Mapping[str, xr.Dataset] | None = None,
    *,
    random_fall_direction_share: float = RANDOM_OUTCOME_SHARE,
) -> FallAndDisplacementComparison:
    """Compare the falls, shifts and twists of stones with those of similar stones in a 3-D study.

    Each stone is compared with the cases of the nearest orientation, height, B/H and D/B, seen from the side that is
    nearer to the grid (`stone_dimensions_described_from_side_nearer_to_grid`), unless its B/H or D/B lies far outside
    the grid. If the survey does not give one of these values, all its values in the grid have equal weight, as all
    frictions have. A standing stone without a noted shift or twist counts as not shifted or not twisted.

    Parameters
    ----------
    table : SurveyTable
        The survey, or the part of one site.
    cube : Dataset
        Cube of one record of a 3-D body, or of one element of a 3-D scene.
    results_cube_by_site : mapping of str to Dataset, optional
        Cubes for the stones of single sites, by name of the site.
    random_fall_direction_share : float
        Share of stones that fall in a random direction, 0 to below 1.

    Raises
    ------
    ArgumentError
        If the cube is of 2-D blocks, no stone counts as fallen or standing, or `random_fall_direction_share` is outside
        0 to below 1.
    """
    if not 0 <= random_fall_direction_share < 1:
        raise ArgumentError(f"background: {random_fall_direction_share}; a share from 0 to below 1")
    if "residual_twist" not in cube:
        raise ArgumentError("cube: of 2-D blocks, which neither twist nor slip obliquely; give that of a 3-D study")
    observed = [_observed_stone_of_row(table, line, row) for line, row in table.rows if row.counted_as != "not counted"]
    if not observed:
        raise ArgumentError("stones: none counts as fallen or standing; a comparison needs at least one")
    arrays = {id(one): _CaseOutcomeArrays.from_cube(one) for one in (cube, *(results_cube_by_site or {}).values())}
    used = {key: np.zeros(one.overturned_flags.shape, np.bool_) for key, one in arrays.items()}
    standing, never_stand, without_outcome, beyond = list[_SimulatedCasesResemblingStones](), 0, 0, 0
    fall_shares, fall_azimuths = list[tuple[int, FloatArray]](), list[FloatArray | None]()
    for one in observed:
        own = id((results_cube_by_site or {}).get(one.stone.site, cube))
        seen = stone_dimensions_described_from_side_nearer_to_grid(arrays[own].grid_values_by_dimension, one.stone)
        if has_shape_far_outside_grid(arrays[own].grid_values_by_dimension, seen):
            beyond += one.stone.stone_count
            fall_shares.append((one.stone.stone_count, np.full(arrays[own].overturned_flags.shape[0], math.nan)))
            fall_azimuths.append(None)
            continue
        chosen = nearest_grid_indices_of_stone(arrays[own].grid_values_by_dimension, seen)
        flags, azimuths, cells = _take_outcomes_of_similar_cases_and_mark_them(arrays[own], chosen, used[own])
        fall_shares.append((one.stone.stone_count, _fall_share_of_known_outcomes_by_friction(flags)))
        fall_azimuths.append(azimuths if np.isfinite(flags).any() else None)
        if not np.isfinite(flags).any():
            without_outcome += one.stone.stone_count
        elif not one.stone.fell and (cells is None or not cells.weight.size):
            never_stand += one.stone.stone_count
        elif not one.stone.fell and cells is not None:
            standing.append(cells._replace(weight=one.stone.stone_count * cells.weight))
    joined = (np.concatenate(parts) for parts in zip(*standing, strict=True))
    computed = _SimulatedCasesResemblingStones(*joined) if standing else None
    return FallAndDisplacementComparison(
        fell=sum(one.stone.stone_count for one in observed if one.stone.fell),
        stood=sum(one.stone.stone_count for one in observed if not one.stone.fell),
        similar_computed_case_count=sum(int(mask.sum()) for mask in used.values()),
        standing_stones_without_standing_simulation=never_stand,
        compared_statistics=(
            _compare_fallen_shares(observed, fall_shares),
            *_compare_shifts_and_twists_of_standing_stones(observed, computed),
        ),
        stones_without_computed_outcome=without_outcome,
        stones_far_outside_b_over_h_or_aspect_range=beyond,
        fall_direction_comparison=compare_fall_directions(
            [one.stone for one in observed], fall_azimuths, random_fall_direction_share=random_fall_direction_share
        ),
    )


def _observed_stone_of_row(survey_table: SurveyTable, line_number: int, row: SurveyRow) -> _ObservedStone:
    """Return a row's stone, shift (m) and clockwise twist (degrees): 0 if not stated, NaN if stated without amount."""
    shift = row.shift_m if "shifted" in row.stated_outcomes else 0.0
    twist = row.clockwise_twist_deg if "twisted" in row.stated_outcomes else 0.0
    return _ObservedStone(survey_table.create_stone_from_row(line_number, row), shift, twist)


def _take_outcomes_of_similar_cases_and_mark_them(
    outcomes: _CaseOutcomeArrays,
    grid_indices_nearest_to_stone: Mapping[str, NDArray[np.intp]],
    used_cases_mask: NDArray[np.bool_],
) -> tuple[NDArray[np.floating], FloatArray, _SimulatedCasesResemblingStones | None]:
    """Return outcomes of the simulated cases that resemble a stone, and set these cases True in `used_cases_mask`.

    Three values are returned: fall flags of all these cases (1: falls, 0: stands, NaN: unknown), with friction as first
    axis; azimuths (degrees) of the falls in a known direction; and displacements of the cases that stand, with weights
    whose sum is 1, or None if no case stands. `grid_indices_nearest_to_stone` are from `nearest_grid_indices_of_stone`.
    """
    sizes = zip(outcomes.dimension_names, outcomes.overturned_flags.shape, strict=True)
    at = np.ix_(*(grid_indices_nearest_to_stone.get(name, np.arange(size)) for name, size in sizes))
    flags = outcomes.overturned_flags[at]
    used_cases_mask[at] |= np.isfinite(flags)
    azimuths = np.asarray(outcomes.fall_azimuth_deg[at], np.float64)[flags == 1]
    azimuths = azimuths[np.isfinite(azimuths)]
    frictions = flags.shape[0]
    rows = (flags == 0).reshape(frictions, -1)
    if not rows.any():
        return flags, azimuths, None
    north, east, twist = (
        np.asarray(values[at], np.float64).reshape(rows.shape)[rows]
        for values in (outcomes.residual_slip_north_m, outcomes.residual_slip_east_m, outcomes.residual_twist_deg)
    )
    # Frictions have equal weight where both stand and fall; within a friction so have its standing cases.
    weight = np.where(rows, 1.0, 0.0) / np.maximum(rows.sum(axis=1, keepdims=True), 1) / rows.any(axis=1).sum()
    friction = np.broadcast_to(np.arange(frictions)[:, None], rows.shape)
    # Cases that were not simulated, because the motion is too weak, have no displacement.
    shift = np.hypot(np.nan_to_num(north), np.nan_to_num(east))
    return (
        flags, azimuths,
        _SimulatedCasesResemblingStones(weight[rows], friction[rows].astype(np.intp), shift, np.nan_to_num(twist)),
    )  # fmt: skip


def _fall_share_of_known_outcomes_by_friction(fall_flags_with_friction_first: NDArray[np.floating]) -> FloatArray:
    """Return the share of cases that fall, among those with known outcome, for each friction; NaN if none is known."""
    rows = fall_flags_with_friction_first.reshape(fall_flags_with_friction_first.shape[0], -1)
    counts, falls = np.isfinite(rows).sum(axis=1), (rows == 1).sum(axis=1)
    return np.asarray(np.divide(falls, counts, out=np.full(counts.shape, np.nan), where=counts > 0))


def _compare_fallen_shares(
    observed_stones: Sequence[_ObservedStone], stone_count_and_fall_shares_by_stone: Sequence[tuple[int, FloatArray]]
) -> ObservedAndComputedStatistic:
    """Return the observed share of stones that fell, with its interval, and the computed share, with its range.

    Sites that list no standing stone are left out. If no site lists one, the observed share is NaN, and the computed
    share is that of all sites.
    """
    of_share = stones_of_sites_with_standing_stones([one.stone for one in observed_stones])
    sites = {stone.site for stone in of_share or [one.stone for one in observed_stones]}
    pairs = zip(observed_stones, stone_count_and_fall_shares_by_stone, strict=True)
    counted = [pair for one, pair in pairs if one.stone.site in sites]
    shares, counts = np.array([share for _, share in counted]), np.array([count for count, _ in counted])
    known = np.isfinite(shares)
    with np.errstate(invalid="ignore"):
        by_friction = np.where(known, shares, 0.0).T @ counts / (known.T @ counts)
    return _observed_and_computed_share("fell", *fallen_and_all_stone_counts(of_share), by_friction)


def _observed_and_computed_share(
    name: ComparedStatisticName, matching_stone_count: int, stone_count: int, computed_share_by_friction: FloatArray
) -> ObservedAndComputedStatistic:
    """Return an observed share with its exact interval, and the computed share: mean and range over frictions."""
    share = matching_stone_count / stone_count if stone_count else math.nan
    low, high = exact_share_interval(matching_stone_count, stone_count) if stone_count else (math.nan, math.nan)
    computed = _mean_and_range_over_friction(computed_share_by_friction)
    return ObservedAndComputedStatistic(name, stone_count, share, low, high, *computed)


def _mean_and_range_over_friction(values_by_friction: FloatArray) -> tuple[float, float, float]:
    """Return mean, smallest and largest of the known values over friction; NaN if none is known.

    Smallest and largest are NaN for a single friction.
    """
    known = values_by_friction[np.isfinite(values_by_friction)]
    if not known.size:
        return math.nan, math.nan, math.nan
    low, high = (known.min(), known.max()) if values_by_friction.size > 1 else (math.nan, math.nan)
    return float(known.mean()), float(low), float(high)


def _compare_shifts_and_twists_of_standing_stones(
    observed_stones: Sequence[_ObservedStone], similar_standing_cases: _SimulatedCasesResemblingStones | None
) -> list[ObservedAndComputedStatistic]:
    """Return shares and medians of the shifts and twists of standing stones, observed and computed."""
    standing = [one for one in observed_stones if not one.stone.fell]
    counts = np.array([one.stone.stone_count for one in standing], np.intp)
    shift = np.repeat([one.shift_m for one in standing], counts)
    twist = np.repeat([one.clockwise_twist_deg for one in standing], counts)
    shift, twist = shift[np.isfinite(shift)], twist[np.isfinite(twist)]
    far = shift >= MIN_SHIFT_COUNTED_AS_SHIFTED_M - _ROUNDING_TOLERANCE
    turned = np.abs(twist) >= MIN_TWIST_COUNTED_AS_TWISTED_DEG - _ROUNDING_TOLERANCE
    none = np.empty(0)
    cells = similar_standing_cases or _SimulatedCasesResemblingStones(none, np.empty(0, np.intp), none, none)
    cells_far = cells.shift_m >= MIN_SHIFT_COUNTED_AS_SHIFTED_M - _ROUNDING_TOLERANCE
    cells_clockwise = cells.clockwise_twist_deg > 0
    cells_turned = np.abs(cells.clockwise_twist_deg) >= MIN_TWIST_COUNTED_AS_TWISTED_DEG - _ROUNDING_TOLERANCE

    def statistic_by_friction(statistic_of_cases: Callable[[NDArray[np.bool_]], float]) -> FloatArray:
        """Return, for each friction, the value of `statistic_of_cases` for a mask of the cases with this friction."""
        return np.array([statistic_of_cases(cells.friction_index == one) for one in np.unique(cells.friction_index)])

    def weighted_share_of_cases(counted_mask: NDArray[np.bool_], base_mask: NDArray[np.bool_]) -> float:
        """Return the weighted share of cases in `counted_mask` among those in `base_mask`; NaN if there are none."""
        total = cells.weight[base_mask].sum()
        return float(cells.weight[base_mask & counted_mask].sum() / total) if total > 0 else math.nan

    def weighted_median_of_cases(case_values: FloatArray, mask_of_cases_to_include: NDArray[np.bool_]) -> float:
        """Return the weighted median of `case_values` over cases in `mask_of_cases_to_include`; NaN if it has none."""
        order = case_values[mask_of_cases_to_include].argsort(kind="stable")
        below = cells.weight[mask_of_cases_to_include][order].cumsum()
        return (
            float(case_values[mask_of_cases_to_include][order][np.searchsorted(below, below[-1] / 2)])
            if below.size
            else math.nan
        )

    def compare_medians(
        name: ComparedStatisticName, observed_values: FloatArray, median_by_friction: FloatArray
    ) -> ObservedAndComputedStatistic:
        """Return the observed median with its exact interval, and the computed median with its range over frictions."""
        middle = float(np.median(observed_values)) if observed_values.size else math.nan
        interval, computed = exact_median_interval(observed_values), _mean_and_range_over_friction(median_by_friction)
        return ObservedAndComputedStatistic(name, observed_values.size, middle, *interval, *computed)

    return [
        _observed_and_computed_share(
            "shifted",
            int(far.sum()),
            far.size,
            statistic_by_friction(lambda own: weighted_share_of_cases(cells_far, own)),
        ),
        _observed_and_computed_share(
            "twisted",
            int(turned.sum()),
            turned.size,
            statistic_by_friction(lambda own: weighted_share_of_cases(cells_turned, own)),
        ),
        _observed_and_computed_share(
            "clockwise",
            int((twist[turned] > 0).sum()),
            int(turned.sum()),
            statistic_by_friction(lambda own: weighted_share_of_cases(cells_clockwise, own & cells_turned)),
        ),
        compare_medians(
            "shift_m",
            shift[far],
            statistic_by_friction(lambda own: weighted_median_of_cases(cells.shift_m, own & cells_far)),
        ),
        compare_medians(
            "twist_deg",
            np.abs(twist[turned]),
            statistic_by_friction(
                lambda own: weighted_median_of_cases(np.abs(cells.clockwise_twist_deg), own & cells_turned)
            ),
        ),
    ]
