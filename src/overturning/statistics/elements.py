"""Falls of each element of a scene, order of falls, and comparison of the falls of two stones."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.plane_weights import case_weights_by_azimuth_spacing, plane_azimuth_period_deg
from overturning.motion.direction import angle_between_azimuths
from overturning.statistics.bootstrap import MeanOverEarthquakes, mean_share_over_earthquakes
from overturning.statistics.by_record import iterate_results_by_record


@dataclass(frozen=True)
class ElementFallCounts:
    """Numbers of falls of one element of a scene, among the cases with a known outcome.

    ``fall_count`` is the number of cases in which the element falls, to either side;
    ``count_of_falls_with_no_earlier_fall`` the number of its falls before which no other element of the scene falls,
    and ``count_of_falls_without_other_falls`` that of its falls in cases in which no other element falls at all.
    ``fall_share`` is the share of the known cases in which it falls (NaN without cases), and ``median_fall_time_s`` the
    median time of its falls, s (NaN without falls).
    """

    element_name: str
    known_outcome_case_count: int
    fall_count: int
    count_of_falls_with_no_earlier_fall: int
    count_of_falls_without_other_falls: int
    fall_share: float
    median_fall_time_s: float


@dataclass(frozen=True)
class ElementDisplacementSummary:
    """Final displacements of one element of a 3-D scene relative to its support: quantiles of slip and rotation.

    ``standing_case_count`` is the number of cases in which it stands, and ``fallen_case_count`` that in which it has
    fallen. ``standing_median_and_p90_slip_m`` (m) and ``standing_median_and_p90_twist_deg`` (absolute rotation about
    the vertical, degrees) are the medians and 90th percentiles over the standing cases; NaN without such cases.
    ``count_of_falls_over_support_rim`` is the number of cases in which it slides off the rim of its support; None for a
    model that does not distinguish such falls.
    """

    element_name: str
    standing_case_count: int
    fallen_case_count: int
    standing_median_and_p90_slip_m: tuple[float, float]
    standing_median_and_p90_twist_deg: tuple[float, float]
    count_of_falls_over_support_rim: int | None


@dataclass(frozen=True)
class StoneFallComparisonOfTwoCubes:
    """Comparison of the falls of two stones, "this" and "other", under the same motions; means over earthquakes.

    ``share_of_cases_only_this_falls``, ``share_of_cases_only_other_falls`` and ``share_of_cases_both_fall`` are shares
    of the cases whose outcome is known for both stones. ``same_direction_share_if_both_fall`` (falls within 45° of
    each other), ``this_earlier_share_if_both_fall`` and ``share_of_simultaneous_falls_if_both_fall`` are shares of the
    cases in which both stones fall. ``this_first_or_alone_share_if_any_falls`` is the share, of the cases in which at
    least one stone falls, in which "this" falls before the other or alone; a case with falls at the same time counts
    half, so the shares of the two stones add up to 1.
    """

    share_of_cases_only_this_falls: MeanOverEarthquakes
    share_of_cases_only_other_falls: MeanOverEarthquakes
    share_of_cases_both_fall: MeanOverEarthquakes
    same_direction_share_if_both_fall: MeanOverEarthquakes
    this_earlier_share_if_both_fall: MeanOverEarthquakes
    share_of_simultaneous_falls_if_both_fall: MeanOverEarthquakes
    this_first_or_alone_share_if_any_falls: MeanOverEarthquakes


_FALL_AND_TIME_VARIABLES = ("overturned", "overturning_time")
_FALL_TIME_AND_AZIMUTH_VARIABLES = (*_FALL_AND_TIME_VARIABLES, "fall_azimuth")
_DISPLACEMENT_VARIABLES = ("overturned", "residual_slip_north", "residual_slip_east", "residual_twist")

ANY_ELEMENT_LABEL = "any element"
"""Label of the falls of a whole scene, which falls when its first element falls."""


def count_falls_of_each_and_any_element(cube: xr.Dataset) -> list[ElementFallCounts]:
    """Count the falls of each element of a scene in a study's results, and the cases in which any element falls.

    For several elements a last row, `ANY_ELEMENT_LABEL`, counts the cases in which any element falls.

    A cube without elements has one row, "block". The cube is read one record at a time. The times of all falls are
    kept in memory for the medians (four bytes each).
    """
    if "element" not in cube.dims:
        cube = cube.drop_vars("element", errors="ignore").expand_dims(element=["block"])
    elements = cube.sizes["element"]
    names = [str(name) for name in cube["element"].to_numpy().tolist()] + [ANY_ELEMENT_LABEL] * (elements > 1)
    counts = np.zeros((4, len(names)), np.int64)
    moments: dict[str, list[NDArray[np.float32]]] = {name: [] for name in names}
    for counts_of_record, times_of_record in map(
        _fall_counts_and_times_by_element, iterate_results_by_record(cube, _FALL_AND_TIME_VARIABLES)
    ):
        counts += counts_of_record
        for name, times in zip(names, times_of_record, strict=True):
            moments[name].append(times)
    rows = []
    for name, (cases, falls, earliest, alone) in zip(names, counts.T.tolist(), strict=True):
        median = float(np.median(np.concatenate(moments.pop(name)), overwrite_input=True)) if falls else math.nan
        rows.append(
            ElementFallCounts(name, cases, falls, earliest, alone, falls / cases if cases else math.nan, median)
        )
    return rows


def _fall_counts_and_times_by_element(record_cube: xr.Dataset) -> tuple[NDArray[np.int64], list[NDArray[np.float32]]]:
    """Count the falls of each element under one record, and list the times of the falls.

    The counts have four rows: cases with a known outcome, falls, falls before which no other element falls, and falls
    in cases in which no other element falls. They have a column for each element; with several elements, a last column
    counts the cases in which any element falls. This is a function of its own, so that its arrays of all cases are
    released before the next record is read.
    """
    elements = record_cube.sizes["element"]
    sides, when = (
        record_cube[name].transpose(..., "element").to_numpy().reshape(-1, elements)
        for name in _FALL_AND_TIME_VARIABLES
    )
    known = np.isfinite(sides)
    fell = known & (sides != 0)
    when = np.where(fell, np.nan_to_num(when, nan=np.inf), np.inf)
    if elements > 1:
        known, fell = (np.column_stack([known, known.any(axis=1)]), np.column_stack([fell, fell.any(axis=1)]))
        when = np.column_stack([when, when.min(axis=1)])
    first = fell & (when == when.min(axis=1, keepdims=True))
    alone = fell & (fell[:, :elements].sum(axis=1, keepdims=True) == 1)
    counts = np.stack([cells.sum(axis=0) for cells in (known, fell, first, alone)])
    return counts, [when[fell[:, index], index] for index in range(fell.shape[1])]


_DISPLACEMENT_QUANTILES: Final = (0.5, 0.9)
"""Quantiles of the displacements of standing elements."""


def summarise_element_displacements(cube: xr.Dataset) -> list[ElementDisplacementSummary]:
    """Summarise the final displacements of each element in a 3-D study's results, one row per element.

    A cube without elements has one row, "block". Cases that were not simulated, because the motion is too weak to move
    anything, count as standing without displacement. The cube is read one record at a time; the displacements of all
    standing cases are kept in memory for the quantiles (eight bytes each).
    """
    if "element" not in cube.dims:
        cube = cube.drop_vars("element", errors="ignore").expand_dims(element=["block"])
    names = [str(name) for name in cube["element"].to_numpy().tolist()]
    has_slides = "slid_off" in cube
    slips: list[list[NDArray[np.float32]]] = [[] for _ in names]
    twists: list[list[NDArray[np.float32]]] = [[] for _ in names]
    fallen, slid = np.zeros(len(names), np.int64), np.zeros(len(names), np.int64)
    for one in iterate_results_by_record(cube, _DISPLACEMENT_VARIABLES + ("slid_off",) * has_slides):
        for place, name in enumerate(names):
            of = one.sel(element=name)
            stands = (of["overturned"] == 0).to_numpy()
            slip = np.hypot(of["residual_slip_north"].to_numpy(), of["residual_slip_east"].to_numpy())
            slips[place].append(np.nan_to_num(slip[stands]))
            twists[place].append(np.nan_to_num(np.abs(of["residual_twist"].to_numpy()[stands])))
            fallen[place] += int((of["overturned"] == 1).sum())
            slid[place] += int((of["slid_off"] == 1).sum()) if has_slides else 0
    return [
        ElementDisplacementSummary(
            name,
            sum(map(len, slips[place])),
            int(fallen[place]),
            _pooled_median_and_90th_percentile(slips[place]),
            _pooled_median_and_90th_percentile(twists[place]),
            int(slid[place]) if has_slides else None,
        )
        for place, name in enumerate(names)
    ]


def _pooled_median_and_90th_percentile(
    values_of_standing_cases_by_record: list[NDArray[np.float32]],
) -> tuple[float, float]:
    """Compute the median and the 90th percentile of values of all records together; NaN if there are none."""
    values = np.concatenate(values_of_standing_cases_by_record).astype(np.float64)
    median, most = np.quantile(values, _DISPLACEMENT_QUANTILES).tolist() if values.size else (math.nan, math.nan)
    return median, most


def count_falls_of_two_stones(cube_of_this_stone: xr.Dataset, cube_of_other_stone: xr.Dataset) -> xr.Dataset:
    """Count, for each record, the cases in which both of two stones fall, and those in which only one falls.

    Each stone has its own results dataset. In 2-D, the cases of an azimuth count with its weight by
    `case_weights_by_azimuth_spacing`, so that azimuths added to a regular grid do not count twice.

    Parameters
    ----------
    cube_of_this_stone, cube_of_other_stone : Dataset
        Cubes of one element each with the same cases in the same order.

    Returns
    -------
    Dataset
        Weighted numbers of cases over ``record``: ``cases`` with a known outcome in both cubes; of these, ``both``,
        ``only_this`` and ``only_other``, in which the stone falls; of ``both``, ``same_way`` with falls within 45° of
        each other, ``earlier``, in which the first stone falls before the other, and ``same_time``, in which both fall
        at the same time. ``compared`` is the number of cases without weights.
    """
    weights = np.ones(1)
    if "azimuth" in cube_of_this_stone.indexes:
        weight = case_weights_by_azimuth_spacing(
            cube_of_this_stone["azimuth"].to_numpy(), plane_azimuth_period_deg(cube_of_this_stone)
        )
        flags = cube_of_this_stone["overturned"].isel(record=0)
        weights = xr.DataArray(weight, dims="azimuth").broadcast_like(flags).transpose(*flags.dims).to_numpy().ravel()
    pairs = zip(
        iterate_results_by_record(cube_of_this_stone, _FALL_TIME_AND_AZIMUTH_VARIABLES),
        iterate_results_by_record(cube_of_other_stone, _FALL_TIME_AND_AZIMUTH_VARIABLES),
        strict=True,
    )
    rows = [_count_falls_of_both_or_only_one_stone(one, another, weights) for one, another in pairs]
    names = ("compared", "cases", "both", "only_this", "only_other", "same_way", "earlier", "same_time")
    return xr.Dataset({name: ("record", of) for name, of in zip(names, np.array(rows).T, strict=True)})


def _count_falls_of_both_or_only_one_stone(
    record_cube_of_this_stone: xr.Dataset, record_cube_of_other_stone: xr.Dataset, weight_by_case: FloatArray
) -> list[float]:
    """Count, under one record, the cases in which both of two stones fall, and those in which only one of them does.

    `weight_by_case` has the shape (cases,), or (1,) for equal weights.
    """
    this, that = (c["overturned"].to_numpy().ravel() for c in (record_cube_of_this_stone, record_cube_of_other_stone))
    known = np.isfinite(this) & np.isfinite(that)
    fell, other_fell = known & (this != 0), known & (that != 0)
    both, (way, other_way) = (
        fell & other_fell,
        (
            _fall_azimuths_deg_relative_to_motion_if_2d(c)
            for c in (record_cube_of_this_stone, record_cube_of_other_stone)
        ),
    )
    same = both & (angle_between_azimuths(way, other_way) <= 45.0)
    when, other_when = (
        c["overturning_time"].to_numpy().ravel() for c in (record_cube_of_this_stone, record_cube_of_other_stone)
    )
    earlier, same_time = both & (when < other_when), both & (when == other_when)
    counted = (known, both, fell & ~other_fell, other_fell & ~fell, same, earlier, same_time)
    return [float(known.sum()), *(float((cells * weight_by_case).sum()) for cells in counted)]


def _fall_azimuths_deg_relative_to_motion_if_2d(record_cube: xr.Dataset) -> FloatArray:
    """Return the fall azimuth of each simulated case, degrees; in 2-D relative to the azimuth of the motion.

    In 2-D the value is 0 or 180. Values of cases in which the block stands have no meaning.
    """
    if "fall_azimuth" in record_cube:
        return np.asarray(record_cube["fall_azimuth"].to_numpy().ravel(), np.float64)
    return np.where(record_cube["overturned"].to_numpy().ravel() > 0, 0.0, 180.0)


def compare_falls_of_two_stones_over_earthquakes(
    two_stone_fall_counts_by_record: xr.Dataset, earthquake_name_by_record: NDArray[np.str_]
) -> StoneFallComparisonOfTwoCubes:
    """Convert counts of two stones' falls under each record to shares of cases, as means over earthquakes.

    The counts are those of `count_falls_of_two_stones`; `earthquake_name_by_record` has each record's earthquake, shape
    (records,).
    """
    with_fall = (
        two_stone_fall_counts_by_record["both"]
        + two_stone_fall_counts_by_record["only_this"]
        + two_stone_fall_counts_by_record["only_other"]
    )
    first = (
        two_stone_fall_counts_by_record["only_this"]
        + two_stone_fall_counts_by_record["earlier"]
        + 0.5 * two_stone_fall_counts_by_record["same_time"]
    )
    two_stone_fall_counts_by_record = two_stone_fall_counts_by_record.assign(first=first, with_fall=with_fall)

    def mean_ratio_of_counts_over_earthquakes(
        numerator_count_name: str, denominator_count_name: str
    ) -> MeanOverEarthquakes:
        total = two_stone_fall_counts_by_record[denominator_count_name].to_numpy().astype(np.float64)
        with np.errstate(invalid="ignore"):
            return mean_share_over_earthquakes(
                two_stone_fall_counts_by_record[numerator_count_name].to_numpy() / np.where(total > 0, total, np.nan),
                earthquake_name_by_record,
            )

    this, other, both = (
        mean_ratio_of_counts_over_earthquakes(name, "cases") for name in ("only_this", "only_other", "both")
    )
    return StoneFallComparisonOfTwoCubes(
        this,
        other,
        both,
        mean_ratio_of_counts_over_earthquakes("same_way", "both"),
        mean_ratio_of_counts_over_earthquakes("earlier", "both"),
        mean_ratio_of_counts_over_earthquakes("same_time", "both"),
        mean_ratio_of_counts_over_earthquakes("first", "with_fall"),
    )
