"""Fall axes relative to fault normals and other references, averaged over earthquakes.

Records of one earthquake share its source, so they are averaged first and count as one. The sign of a fault normal is
arbitrary, so only axes are compared with it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.plane_weights import azimuths_in_results_bias_mean_fall_axis
from overturning.statistics.bootstrap import (
    MeanOverEarthquakes,
    bootstrap_interval,
    distinct_earthquake_names,
    finite_statistics_of_bootstrap_samples,
    interval_tail_share_for_few_earthquakes,
    mean_of_each_bootstrap_sample,
    mean_vector_of_each_bootstrap_sample,
    means_by_earthquake,
)
from overturning.statistics.by_record import apply_to_record_batches_and_join, record_masks_by_group
from overturning.statistics.circular import (
    MAX_RESULTANT_LENGTH_FROM_ROUNDING,
    MIN_RESULTANT_WITH_MEAN_DIRECTION,
    rayleigh_test_by_random_rotation,
    wrap_axis_difference_to_90_deg,
)
from overturning.statistics.falls import (
    mean_cosine_and_sine_to_reference,
    mean_directions_and_axes_from_vector_sums,
    sum_fall_vectors_over_directions,
    unknown_outcomes_may_bias_fall_axis,
)

BOUNDS_OF_COSINE_DIFFERENCE = (-2.0, 2.0)
"""Smallest and largest possible difference between two cosines."""


def fall_sums_for_direction_statistics_by_record(cube: xr.Dataset, *kept_dims: str) -> xr.Dataset:
    """Sum falls and fall vectors for each record, over azimuths and the blocks that direction statistics use.

    Only the dimensions ``kept_dims`` and ``record`` are kept. See `sum_fall_vectors_over_directions`, and
    `mask_of_blocks_for_direction_statistics` for the blocks.
    """
    model = default_model_of_same_kind_as_results_cube(cube)
    over = [name for name in model.case_dims_without_direction if name not in kept_dims]
    made = apply_to_record_batches_and_join(
        partial(sum_fall_vectors_over_directions, summed_dims=over, only_informative_blocks=True),
        cube,
        model.variable_names_read_for_fall_probability,
    )
    return made.transpose("record", *kept_dims)


def mean_fall_directions_and_axes_by_record(cube: xr.Dataset) -> xr.Dataset:
    """Compute mean direction and mean axis of falls under each record, over the blocks that direction statistics use.

    For these blocks see `mask_of_blocks_for_direction_statistics`. The variables are those of
    `mean_fall_directions_and_axes_over_azimuths`, and ``is_imposed``: True for a record whose unknown outcomes may bias
    the axis (`unknown_outcomes_may_bias_fall_axis`). The means and resultants of such a record are missing; those of
    all records are missing if the choice of plane azimuths already gives falls a mean axis
    (`plane_azimuths_alone_impose_fall_axis`). The cube is read in batches of records.
    """
    model = default_model_of_same_kind_as_results_cube(cube)
    of_batch = partial(
        sum_fall_vectors_over_directions, summed_dims=model.case_dims_without_direction, only_informative_blocks=True
    )
    sums = apply_to_record_batches_and_join(of_batch, cube, model.variable_names_read_for_fall_probability)
    imposed = unknown_outcomes_may_bias_fall_axis(sums)
    means = mean_directions_and_axes_from_vector_sums(sums).where(
        ~imposed & (not azimuths_in_results_bias_mean_fall_axis(cube))
    )
    return means.assign(is_imposed=imposed)


def fall_axes_from_fault_normal_by_earthquake(cube: xr.Dataset, *kept_dims: str) -> xr.Dataset:
    """Compute the mean fall axis of each earthquake, as an angle from the fault normal.

    The cube is read in batches of records. All falls of the informative blocks
    (`mask_of_blocks_for_direction_statistics`) under a record have equal weight; an earthquake has the mean of the
    means of its records.

    Parameters
    ----------
    cube : Dataset
        With the coordinates ``fault_normal(record)``, degrees, and ``event(record)``, the name of the earthquake.
    kept_dims : str
        Dimensions of the block that are not averaged over.

    Returns
    -------
    Dataset
        Over the dimension ``event`` (in order of first appearance) and ``kept_dims``: ``cosine`` and ``sine``, the
        means of cos 2Δ and sin 2Δ over falls, with Δ the angle from the fault normal; ``resultant``, the length of
        this vector; ``largest``, the mean over records of the resultant of the falls of each record, an upper bound of
        the mean of cos 2Δ; ``axis``, the axis of the vector (degrees in (−90, 90], 0 is the fault normal);
        ``falls``, True if any block falls; and ``records``, the number of records. All but the last two are missing if
        no block falls, no fault normal is known, or the choice of plane azimuths already gives falls a mean axis
        (`plane_azimuths_alone_impose_fall_axis`). They leave out records whose unknown outcomes may bias the axis
        (`unknown_outcomes_may_bias_fall_axis`). ``axis`` is also missing if the resultant is below
        `MIN_RESULTANT_WITH_MEAN_DIRECTION`.
    """
    sums = fall_sums_for_direction_statistics_by_record(cube, *kept_dims)
    vectors, events = (
        mean_cosine_and_sine_to_reference(sums, cube["fault_normal"]).where(
            ~unknown_outcomes_may_bias_fall_axis(sums) & (not azimuths_in_results_bias_mean_fall_axis(cube))
        ),
        np.atleast_1d(cube["event"].values).astype(str),
    )
    cosine, sine = (means_by_earthquake(vectors[name].values, events) for name in ("cosine", "sine"))
    largest = means_by_earthquake(np.hypot(vectors["cosine"].values, vectors["sine"].values), events)
    length, any_falls = np.hypot(cosine, sine), sums["all_falls"].where(cube["fault_normal"].notnull())
    axis = np.where(
        length >= MIN_RESULTANT_WITH_MEAN_DIRECTION,
        wrap_axis_difference_to_90_deg(np.degrees(np.arctan2(sine, cosine)) / 2),
        np.nan,
    )
    about_axis = {"long_name": "mean fall axis relative to the fault normal", "units": "degree"}
    about_length = {"long_name": "mean resultant length of doubled fall axes", "units": "1"}
    names = distinct_earthquake_names(events)
    dims, counts = ("event", *kept_dims), [(events == one).sum() for one in names]
    found = {
        "cosine": (dims, cosine), "sine": (dims, sine), "axis": (dims, axis, about_axis),
        "resultant": (dims, length, about_length), "largest": (dims, largest), "records": ("event", counts),
        "falls": (dims, means_by_earthquake(any_falls.values, events) > 0),
    }  # fmt: skip
    return xr.Dataset(found, {"event": ("event", np.array(names, dtype=str))})


def fall_axes_from_fault_normal_by_group(
    cube: xr.Dataset, coordinate: str = "pulse", edges: Sequence[float] = ()
) -> dict[str, xr.Dataset]:
    """Compute, by name of the group of records, the mean fall axis of each earthquake of the group.

    `coordinate` and `edges` define the groups as in `record_masks_by_group`; groups without records are left out.
    """
    return {
        name: fall_axes_from_fault_normal_by_earthquake(cube.isel(record=np.flatnonzero(members)))
        for name, members in record_masks_by_group(cube, coordinate, edges).items()
        if members.any()
    }


@dataclass(frozen=True)
class MeanFallAxisAndAlignmentOverEarthquakes:
    """Mean axis of the falls under several earthquakes, and mean alignment of the falls with the fault normal.

    Attributes
    ----------
    earthquake_count : int
        Number of earthquakes, with or without falls.
    mean_cos_of_doubled_angle_to_fault_normal : MeanOverEarthquakes
        Mean of cos 2Δ (Δ: angle from the fault normal to a fall) over the earthquakes with falls and a known fault
        normal: 1 if all fall normal to the fault, −1 if parallel to it, near 0 if in all directions.
    mean_axis_from_fault_normal_deg : float
        Axis of the mean vector of the earthquakes relative to the fault normal, (−90, 90]; NaN without falls, if the
        resultant is below `MIN_RESULTANT_WITH_MEAN_DIRECTION`, or if the `rayleigh_test_by_random_rotation` does not
        reject "no common axis".
    mean_axis_interval_half_width_deg : float
        Half-width of the bootstrap interval symmetric about the mean axis: a quantile of the angles between bootstrap
        axes and mean axis (Fisher 1993, Statistical Analysis of Circular Data, section 8.3.2), for the level see
        `interval_tail_share_for_few_earthquakes`; NaN below `MIN_EARTHQUAKES_FOR_INTERVAL` and without an axis.
    earthquakes_with_axis, earthquakes_with_axis_within_45_deg_of_normal : int
        Number of earthquakes that have an axis (resultant at least `MIN_RESULTANT_WITH_MEAN_DIRECTION`), and of these
        with an axis within 45° of the fault normal.
    mean_resultant_length_of_doubled_fall_axes : float
        Upper bound of `mean_cos_of_doubled_angle_to_fault_normal`: the mean over earthquakes of ``largest`` of
        `fall_axes_from_fault_normal_by_earthquake`, reached if the fall axis of each record is its fault normal.
    p_value_of_no_common_axis : float
        p-value of the `rayleigh_test_by_random_rotation` over earthquakes; NaN without falls.
    """

    earthquake_count: int
    mean_cos_of_doubled_angle_to_fault_normal: MeanOverEarthquakes
    mean_axis_from_fault_normal_deg: float
    mean_axis_interval_half_width_deg: float
    earthquakes_with_axis: int
    earthquakes_with_axis_within_45_deg_of_normal: int
    mean_resultant_length_of_doubled_fall_axes: float = math.nan
    p_value_of_no_common_axis: float = math.nan


def summarise_fall_axes(
    fall_axes_by_earthquake: xr.Dataset, *, confidence_level: float = 0.95, bootstrap_sample_count: int = 10_000
) -> MeanFallAxisAndAlignmentOverEarthquakes:
    """Average the fall axes of earthquakes: mean axis and mean alignment with the fault normal, with intervals.

    `fall_axes_by_earthquake` is a result of `fall_axes_from_fault_normal_by_earthquake`.
    """
    vectors = np.column_stack([fall_axes_by_earthquake["cosine"].values, fall_axes_by_earthquake["sine"].values])
    vectors = vectors[np.isfinite(vectors[:, 0])]
    cosine, sine = vectors.mean(axis=0) if len(vectors) else (math.nan, math.nan)
    test = rayleigh_test_by_random_rotation(*vectors.T)
    has_axis = test.p_value <= 1 - confidence_level and math.hypot(cosine, sine) >= MIN_RESULTANT_WITH_MEAN_DIRECTION
    mean = float(wrap_axis_difference_to_90_deg(math.degrees(math.atan2(sine, cosine)) / 2)) if has_axis else math.nan

    def axis_distances_from_mean_deg(vectors_by_bootstrap_sample_and_earthquake: FloatArray) -> FloatArray:
        """Return angles, degrees, between the mean axis of each bootstrap sample of vectors and that of all vectors."""
        drawn_cosine, drawn_sine = mean_vector_of_each_bootstrap_sample(vectors_by_bootstrap_sample_and_earthquake).T
        away = np.abs(wrap_axis_difference_to_90_deg(np.degrees(np.arctan2(drawn_sine, drawn_cosine)) / 2 - mean))
        return np.where(np.hypot(drawn_cosine, drawn_sine) < MAX_RESULTANT_LENGTH_FROM_ROUNDING, 90.0, away)

    distances = (
        finite_statistics_of_bootstrap_samples(axis_distances_from_mean_deg, vectors, bootstrap_sample_count)
        if has_axis
        else np.zeros(0)
    )
    ends = bootstrap_interval(
        mean_of_each_bootstrap_sample,
        vectors[:, 0],
        confidence_level=confidence_level,
        bootstrap_sample_count=bootstrap_sample_count,
        statistic_bounds=(-1.0, 1.0),
    )
    half_width = math.nan
    if distances.size:
        half_width = float(
            np.quantile(distances, 1 - 2 * interval_tail_share_for_few_earthquakes(len(vectors), confidence_level))
        )
    known = fall_axes_by_earthquake["axis"].values[np.isfinite(fall_axes_by_earthquake["axis"].values)]
    closer = int((np.abs(known) < 45).sum())
    alignment, most = MeanOverEarthquakes(len(vectors), float(cosine), *ends), fall_axes_by_earthquake["largest"].values
    largest = float(most[np.isfinite(most)].mean()) if len(vectors) else math.nan
    count = int(fall_axes_by_earthquake.sizes["event"])
    return MeanFallAxisAndAlignmentOverEarthquakes(
        count, alignment, mean, half_width, int(known.size), closer, largest, test.p_value
    )


def difference_in_mean_alignment_with_fault_normal(
    fall_axes_by_earthquake_in_first_set: xr.Dataset, fall_axes_by_earthquake_in_second_set: xr.Dataset
) -> MeanOverEarthquakes:
    """Compute the mean alignment of falls with the fault normal in one set of records minus that in another.

    Both sets, such as pulse records and their control, are results of `fall_axes_from_fault_normal_by_earthquake`. An
    earthquake with records in both sets is drawn once for both, so that its own orientation does not count as a
    difference. ``earthquake_count`` is the number of earthquakes with falls in the smaller set; there is no interval if
    it is below `MIN_EARTHQUAKES_FOR_INTERVAL`.
    """
    names = distinct_earthquake_names(
        [*fall_axes_by_earthquake_in_first_set["event"].values, *fall_axes_by_earthquake_in_second_set["event"].values]
    )
    values = np.stack(
        [
            axes["cosine"].reindex(event=names).values
            for axes in (fall_axes_by_earthquake_in_first_set, fall_axes_by_earthquake_in_second_set)
        ]
    )
    n = int(np.isfinite(values).sum(axis=1).min())

    def mean_alignment_differences_by_sample(alignment_by_sample_earthquake_and_set: FloatArray) -> FloatArray:
        counts = np.isfinite(alignment_by_sample_earthquake_and_set).sum(axis=1)
        means = np.nansum(alignment_by_sample_earthquake_and_set, axis=1) / np.where(counts > 0, counts, np.nan)
        return np.asarray(means[:, 0] - means[:, 1])

    difference = float(mean_alignment_differences_by_sample(values.T[None])[0])
    ends = bootstrap_interval(
        mean_alignment_differences_by_sample,
        values.T,
        bootstrap_sample_count=10_000,
        count_of_earthquakes_that_matter=n,
        statistic_bounds=BOUNDS_OF_COSINE_DIFFERENCE,
    )
    return MeanOverEarthquakes(n, difference, *ends)
