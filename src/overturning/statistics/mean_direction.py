"""Mean direction or axis of independent observations, such as the falls of single stones, with its interval."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.statistics.bootstrap import (
    finite_statistics_of_bootstrap_samples,
    interval_tail_share_for_few_earthquakes,
    mean_vector_of_each_bootstrap_sample,
)
from overturning.statistics.circular import (
    MAX_RESULTANT_LENGTH_FROM_ROUNDING,
    MIN_RESULTANT_WITH_MEAN_DIRECTION,
    StatisticalTestResult,
    mean_angle_deg_and_mean_resultant_length,
    rayleigh_test_by_random_rotation,
)

MAX_OBSERVATIONS_FOR_BOOTSTRAP: Final = 1000
"""Largest number of observations whose interval is from the bootstrap; more have the interval of large samples."""


@dataclass(frozen=True)
class MeanDirectionWithInterval:
    """Mean direction or axis of independent observations.

    Attributes
    ----------
    observation_count : int
        Number of observations.
    significant_mean_deg : float
        Mean, 0 to below 360 for directions and 0 to below 180 for axes; NaN if the test does not reject random
        directions at the level of the interval, or the mean resultant length is below
        `MIN_RESULTANT_WITH_MEAN_DIRECTION`.
    interval_half_width_deg : float
        Half the width of the confidence interval of the mean; NaN without mean, or for fewer than eight observations.
    mean_resultant_length : float
        Mean resultant length, 0 to 1; for axes that of the doubled angles. NaN without observations.
    test_of_no_common_direction : StatisticalTestResult
        Test of the null hypothesis that the observations have no common direction (or axis).
    """

    observation_count: int
    significant_mean_deg: float
    interval_half_width_deg: float
    mean_resultant_length: float
    test_of_no_common_direction: StatisticalTestResult


def mean_direction_if_significant_resultant_and_test(
    azimuths_deg: ArrayLike,
    fall_azimuth_recording_step_deg: ArrayLike = 0.0,
    *,
    axial: bool = False,
    confidence_level: float = 0.95,
) -> tuple[float, float, StatisticalTestResult]:
    """Return mean direction (or axis; degrees), mean resultant length, and test of no common direction.

    The mean is NaN unless it is significant: the test rejects random directions at `confidence_level`, and the
    resultant is at least `MIN_RESULTANT_WITH_MEAN_DIRECTION`. For the test and the parameters see
    `mean_direction_with_interval`.
    """
    angle = np.asarray(azimuths_deg, dtype=np.float64)
    fold = 2 if axial else 1
    mean, resultant = mean_angle_deg_and_mean_resultant_length(angle, axial=axial)
    if angle.size > MAX_OBSERVATIONS_FOR_BOOTSTRAP:
        p_value = math.exp(-angle.size * resultant**2)
        test = StatisticalTestResult("Rayleigh", angle.size, resultant, p_value)
    else:
        vectors = np.cos(np.radians(fold * angle)), np.sin(np.radians(fold * angle))
        test = rayleigh_test_by_random_rotation(*vectors, fold * np.asarray(fall_azimuth_recording_step_deg))
    clear = test.p_value <= 1 - confidence_level and resultant >= MIN_RESULTANT_WITH_MEAN_DIRECTION
    return mean if clear else math.nan, resultant, test


def mean_direction_with_interval(
    azimuths_deg: ArrayLike,
    fall_azimuth_recording_step_deg: ArrayLike = 0.0,
    *,
    axial: bool = False,
    confidence_level: float = 0.95,
    bootstrap_sample_count: int = 4000,
) -> MeanDirectionWithInterval:
    """Compute the mean direction (or axis) of angles, its interval, and the test of no common direction.

    The half-width of the interval is a quantile of the distances of bootstrap means from the mean, corrected for few
    observations (`interval_tail_share_for_few_earthquakes`), and the test is `rayleigh_test_by_random_rotation`. For
    more than `MAX_OBSERVATIONS_FOR_BOOTSTRAP` angles the interval is that of large samples (Fisher 1993, Statistical
    Analysis of Circular Data, section 4.4.4), and the test is Rayleigh's, p = exp(−nR²).

    Directions that are recorded in steps, such as eight compass points, may all have the same error. The interval is
    wider by a bound of this error (`_rounding_error_bound_of_mean_deg`), and the test by random rotation rounds the
    rotated angles to their steps.

    The interval contains the true mean less often than `confidence_level` says if the test hardly rejects random
    directions: means are given only for those samples whose falls happen to agree.

    Parameters
    ----------
    azimuths_deg : array_like, shape (n,)
        Azimuths, degrees clockwise from north.
    fall_azimuth_recording_step_deg : array_like, shape (n,) or ()
        Step in which each azimuth is recorded, degrees, a divisor of 180: 45 for eight compass points; 0 without steps.
    axial : bool
        True if opposite azimuths are the same.
    confidence_level : float
        Probability of the interval; a mean is given if p of the test is at most 1 − level.
    bootstrap_sample_count : int
        Number of bootstrap samples.
    """
    angle = np.asarray(azimuths_deg, dtype=np.float64)
    fold = 2 if axial else 1
    vectors = np.column_stack([np.cos(np.radians(fold * angle)), np.sin(np.radians(fold * angle))])
    mean, resultant, test = mean_direction_if_significant_resultant_and_test(
        angle, fall_azimuth_recording_step_deg, axial=axial, confidence_level=confidence_level
    )
    if math.isnan(mean):
        return MeanDirectionWithInterval(angle.size, math.nan, math.nan, resultant, test)
    half = _half_width_of_mean_deg(vectors, fold * mean, resultant, confidence_level, bootstrap_sample_count)
    half += _rounding_error_bound_of_mean_deg(
        fold * angle, fold * np.broadcast_to(fall_azimuth_recording_step_deg, angle.shape)
    )
    return MeanDirectionWithInterval(angle.size, mean, half / fold, resultant, test)


def _rounding_error_bound_of_mean_deg(
    recorded_angles_deg: FloatArray, recording_step_deg_by_angle: FloatArray
) -> float:
    """Return a bound of the error (degrees) of a mean direction due to angles recorded in steps (N, NE, E, …).

    The recorded angles and their steps have the shape (n,). An angle without a step (0) has no error.
    """
    errors = [
        float((recording_step_deg_by_angle == step).sum())
        * _rounding_error_bound_for_equal_steps_deg(
            recorded_angles_deg[recording_step_deg_by_angle == step], float(step)
        )
        for step in np.unique(recording_step_deg_by_angle[recording_step_deg_by_angle > 0]).tolist()
    ]
    return sum(errors) / max(recording_step_deg_by_angle.size, 1)


def _rounding_error_bound_for_equal_steps_deg(recorded_angles_deg: FloatArray, recording_step_deg: float) -> float:
    """Return a bound of the error (degrees) of the mean of angles that are rounded to multiples of one step.

    The angles are taken as normally distributed over two neighbouring steps of width w, with the share p in the fuller
    one. Their mean then lies σ z_p from the border between the two steps (σ: standard deviation, z: quantile of the
    normal distribution), the mean of the rounded angles (p − ½) w from it. The bound is the difference of these two
    distances, for the smallest σ that gives the share q found in the next step on either side: w/(2 z_(1−q)).
    A uniform background, the median number of angles in all other steps, is first subtracted from each step.
    """
    count = round(360.0 / recording_step_deg)
    index = np.round((recorded_angles_deg - recorded_angles_deg[0]) / recording_step_deg).astype(np.intp) % count
    filled = np.bincount(index, minlength=count).astype(np.float64)
    first = int((filled + np.roll(filled, -1)).argmax())
    around = np.roll(filled, 1 - first)  # before, the two fullest neighbours, after, all others
    others = float(np.median(around[4:])) if count > 4 else 0.0
    two = np.maximum(around[1:3] - others, 0.0)
    if count < 4 or not two.sum():
        return 0.5 * recording_step_deg
    # Less two standard deviations of the number of spread angles there.
    more = max(float(around[0] + around[3]) - 2.0 * others - 2.0 * math.sqrt(2.0 * others), 0.0)
    in_one, outer_share = float(two.max() / two.sum()), more / (float(two.sum()) + more)
    if outer_share >= 0.5 or two.sum() < 0.5 * recorded_angles_deg.size:  # spread over many steps
        return 0.0
    spread = 0.5 * recording_step_deg / -float(scipy.special.ndtri(outer_share)) if outer_share else 0.0
    nearer = spread * float(scipy.special.ndtri(in_one)) if spread else 0.0
    return max((in_one - 0.5) * recording_step_deg - nearer, 0.0)


def _half_width_of_mean_deg(
    unit_vectors: FloatArray,
    mean_vector_angle_deg: float,
    mean_resultant_length: float,
    confidence_level: float,
    bootstrap_sample_count: int,
) -> float:
    """Return half the width (degrees) of the mean direction's interval, from unit vectors of shape (n, 2)."""
    n = len(unit_vectors)
    middle = np.array([math.cos(math.radians(mean_vector_angle_deg)), math.sin(math.radians(mean_vector_angle_deg))])
    if n > MAX_OBSERVATIONS_FOR_BOOTSTRAP:
        along = unit_vectors @ middle
        dispersion = max(1 - float((2 * along**2 - 1).mean()), 0.0) / (
            2 * mean_resultant_length**2
        )  # 0 of equal angles
        error = float(scipy.special.ndtri((1 + confidence_level) / 2)) * math.sqrt(dispersion / n)
        return math.degrees(math.asin(min(error, 1.0)))

    def distances_of_sample_means_from_overall_mean_deg(
        vectors_by_bootstrap_sample_and_observation: FloatArray,
    ) -> FloatArray:
        cosine, sine = mean_vector_of_each_bootstrap_sample(vectors_by_bootstrap_sample_and_observation).T
        away = np.degrees(np.arctan2(sine * middle[0] - cosine * middle[1], cosine * middle[0] + sine * middle[1]))
        return np.where(np.hypot(cosine, sine) < MAX_RESULTANT_LENGTH_FROM_ROUNDING, 180.0, np.abs(away))

    distances = finite_statistics_of_bootstrap_samples(
        distances_of_sample_means_from_overall_mean_deg, unit_vectors, bootstrap_sample_count
    )
    if not distances.size:
        return math.nan
    return float(np.quantile(distances, 1 - 2 * interval_tail_share_for_few_earthquakes(n, confidence_level)))
