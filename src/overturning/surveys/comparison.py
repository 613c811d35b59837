"""Comparison of the observed falls of a survey with the prediction for its site, and its file."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.statistics.bootstrap import MAX_ABSOLUTE_DIFFERENCE_OF_EQUAL_VALUES
from overturning.statistics.circular import (
    StatisticalTestResult,
    chi_square_test_of_sectors,
    mean_angle_deg_and_mean_resultant_length,
    watson_u2_test_of_sectors,
)
from overturning.stored import (
    StoredFloatArray,
    StoredFloatOrInfinity,
    StoredFloatOrNan,
    StoredIntegerArray,
)
from overturning.surveys.counted_stones import fallen_and_all_stone_counts, stones_of_sites_with_standing_stones
from overturning.surveys.fall_directions import (
    RANDOM_SURVEYS_PER_P_VALUE,
    FallenStoneWithDirectionProbabilities,
    azimuth_goodness_of_fit,
    compare_observed_and_predicted_directions,
)
from overturning.surveys.prediction import (
    STANDING_OR_FALL_SIDES,
    SiteFallPrediction,
    SurveyFallPrediction,
    has_known_face_and_at_least_one_b_over_h,
    observed_standing_or_side_index,
)
from overturning.surveys.stones import RANDOM_OUTCOME_SHARE, Stone

MIN_RESULTANT_FOR_MEAN: Final = 1e-6
"""Mean resultant length of predicted directions up to which their mean is a matter of rounding."""


@dataclass(frozen=True)
class SurveyPredictionComparison:
    """Comparison of the falls in a survey with the falls predicted for its site, by numbers and tests.

    Attributes
    ----------
    fallen, stood : int
        Number of stones.
    fallen_count_at_sites_with_standing_stones, stone_count_at_sites_with_standing_stones : int
        Stones that fell, and stones that fell or stand, at the sites that list a standing stone. Both are 0 if no site
        lists one; then the share that fell is not known.
    observed_mean_direction_deg, observed_resultant_length : float
        Mean direction of the observed falls, degrees (NaN if random directions are not rejected), and mean resultant
        length.
    predicted_mean_direction_deg, predicted_resultant_length : float
        Mean of the predicted directions of the fallen stones, degrees, and mean resultant length; NaN without falls.
    computed_fall_share, lowest_computed_fall_share, highest_computed_fall_share : float
        Share of stones that fall in the study, among those at sites that list a standing stone (at all sites if none
        lists one): mean, smallest and largest over the heights and frictions of the study's grid. Smallest and largest
        are NaN if the share is the same for all, for instance with one friction for stones of stated height. See
        `SiteFallPrediction.simulated_fall_probability_by_height_and_friction` for stones without size or face.
    observed_count_by_octant, predicted_count_by_octant : ndarray, shape (8,)
        Observed and expected number of stones in each compass octant; see
        `fall_directions.octant_weights_of_fallen_stone`.
    log_likelihood_ratio : float
        Sum over fallen stones of ln(predicted/uniform); above 0 the prediction is better than uniform directions.
    likelihood_ratio_p : float
        Share of surveys with uniform random directions whose `log_likelihood_ratio` is at least as large.
    octant_chi_square_test, octant_watson_u2_test : StatisticalTestResult
        Chi-square and grouped Watson U² of the octants against the prediction; NaN without falls.
    exact_azimuth_watson_u2_test : StatisticalTestResult
        Watson U² of azimuths in degrees against the prediction; n = 0 without such azimuths. The distribution function
        of each stone begins at the mean predicted direction, or at the mean observed direction if the predicted
        directions have no mean, so that the result does not depend on the azimuth from which angles are measured.
    octant_uniformity_test : StatisticalTestResult
        Grouped Watson U² of the octants against uniformity.
    confusion_matrix : ndarray, shape (5, 5), or None
        Numbers of stones with known face and B/H and a computed outcome, by observed (rows) and most probable (columns)
        outcome, in the order of `STANDING_OR_FALL_SIDES`. None if there is no such stone.
    known_direction_falls_without_face_or_b_over_h : int
        Stones that fell in a known direction without face or B/H; all orientations are assumed for them.
    known_direction_falls_without_face_azimuth, known_direction_falls_without_b_over_h : int
        Stones that fell in a known direction without face azimuth, or without B/H.
    falls_without_direction : int
        Fallen stones with unknown direction; they count in `fallen`, but in no statistic of directions.
    stones_outside_b_over_h_grid : int
        Stones with a B/H outside the grid of the study; the nearest value is used, or they are not predicted.
    stones_far_outside_b_over_h_grid : int
        Stones of `stones_outside_b_over_h_grid` that are not predicted, because their B/H lies far outside the grid.
    stones_outside_height_grid : int
        Stones with a height outside the grid of the study; their `computed_fall_share` is that of the nearest height.
    assumed_random_fall_direction_share : float
        Assumed share of stones that fall in a random direction.
    known_direction_falls_without_any_computed_fall : int
        Stones that fell in a known direction although no such stone falls in the study; their predicted direction is
        uniform.
    stones_without_computed_outcome : int
        Stones without a computed outcome, although their B/H is not far outside the grid: no block of this B/H has one.
        Like those of `stones_far_outside_b_over_h_grid`, they do not count in `computed_fall_share` and
        `confusion_matrix`.
    known_direction_falls_without_computed_outcome : int
        Stones of `stones_without_computed_outcome` that fell in a known direction; a random one is predicted for them.
    known_direction_falls_without_prediction : int
        Stones of `stones_without_computed_outcome` and `stones_far_outside_b_over_h_grid` that fell in a known
        direction.
    """

    fallen: int
    stood: int
    fallen_count_at_sites_with_standing_stones: int
    stone_count_at_sites_with_standing_stones: int
    observed_mean_direction_deg: StoredFloatOrNan
    observed_resultant_length: StoredFloatOrNan
    predicted_mean_direction_deg: StoredFloatOrNan
    predicted_resultant_length: StoredFloatOrNan
    computed_fall_share: StoredFloatOrNan
    lowest_computed_fall_share: StoredFloatOrNan
    highest_computed_fall_share: StoredFloatOrNan
    observed_count_by_octant: StoredFloatArray
    predicted_count_by_octant: StoredFloatArray
    log_likelihood_ratio: StoredFloatOrInfinity
    likelihood_ratio_p: StoredFloatOrNan
    octant_chi_square_test: StatisticalTestResult
    octant_watson_u2_test: StatisticalTestResult
    exact_azimuth_watson_u2_test: StatisticalTestResult
    octant_uniformity_test: StatisticalTestResult
    confusion_matrix: StoredIntegerArray | None
    known_direction_falls_without_face_or_b_over_h: int
    known_direction_falls_without_face_azimuth: int
    known_direction_falls_without_b_over_h: int
    falls_without_direction: int
    stones_outside_b_over_h_grid: int
    stones_outside_height_grid: int
    assumed_random_fall_direction_share: float
    known_direction_falls_without_any_computed_fall: int = 0
    stones_far_outside_b_over_h_grid: int = 0
    stones_without_computed_outcome: int = 0
    known_direction_falls_without_computed_outcome: int = 0
    known_direction_falls_without_prediction: int = 0

    @property
    def fallen_count_in_known_direction(self) -> int:
        """Number of stones that fell in a known direction."""
        return self.fallen - self.falls_without_direction


def _sector_probabilities_given_fall(site_prediction: SiteFallPrediction, stone: Stone) -> FloatArray:
    """Return the predicted probabilities that a stone, if it falls, falls into each sector, shape (sectors,)."""
    if not has_known_face_and_at_least_one_b_over_h(stone):
        return site_prediction.sector_probabilities_given_fall_for_unknown_face(*stone.b_over_h_in_both_planes)
    if site_prediction.no_simulated_block_like_stone_falls(stone):
        return site_prediction.share
    sides = site_prediction.standing_and_side_probabilities(stone)[1:]
    # Distribution function from the first border over two circles; each cell gets its part of each sector.
    below = np.concatenate([[0.0], np.cumsum(np.tile(sides / sides.sum(), 2))])
    begin = (site_prediction.borders[:-1] - stone.face_azimuth_deg + 45.0) % 360.0
    ends = np.stack([begin, begin + np.diff(site_prediction.borders)])
    return np.asarray(np.diff(np.interp(ends, 90.0 * np.arange(below.size), below), axis=0)[0])


def compare_survey_with_prediction(
    stones: Sequence[Stone],
    cube: xr.Dataset,
    *,
    results_cube_by_site: Mapping[str, xr.Dataset] | None = None,
    random_outcome_stone_share: float = RANDOM_OUTCOME_SHARE,
    random_survey_count: int = RANDOM_SURVEYS_PER_P_VALUE,
    random_survey_seed: int = 1,
) -> SurveyPredictionComparison:
    """Compare the observed falls of stones with those that the results of a study predict for their site.

    Parameters
    ----------
    stones : sequence of Stone
        Stones from `read_counted_stones`.
    cube, results_cube_by_site, random_outcome_stone_share
        As in `SurveyFallPrediction`.
    random_survey_count, random_survey_seed : int
        Number and seed of random surveys for the p-values of the likelihood ratio, and of
        `exact_azimuth_watson_u2_test` for azimuths recorded in steps (parametric bootstrap: Davison & Hinkley 1997,
        Bootstrap Methods and their Application, section 4.2).

    Raises
    ------
    ArgumentError
        If there is no stone, or the cubes of two sites have different grids.
    """
    if not stones:
        raise ArgumentError("stones: none; a survey needs at least one row")
    predictions = SurveyFallPrediction(
        cube, results_cube_by_site, random_outcome_stone_share=random_outcome_stone_share
    )
    site = predictions.default_prediction  # sectors and octants are the same at all sites
    fallen = _stones_fallen_in_known_direction_with_predictions(predictions, stones)
    uniform_octant = site.octant_probabilities_from_sectors(site.share)
    directions = compare_observed_and_predicted_directions(site, fallen, random_survey_count, random_survey_seed)
    observed, predicted = directions["observed_count_by_octant"], directions["predicted_count_by_octant"]
    share = predicted / predicted.sum() if fallen else uniform_octant
    # Both means turn with the survey and the cube.
    origin = directions["predicted_mean_direction_deg"]
    if not directions["predicted_resultant_length"] > MIN_RESULTANT_FOR_MEAN:
        exactly = [stone.fall_azimuth_deg for stone, *_ in fallen if stone.direction_uncertainty_half_width_deg == 0]
        origin = mean_angle_deg_and_mean_resultant_length(exactly)[0]
    of_share = stones_of_sites_with_standing_stones(stones)
    share_fell, share_stones = fallen_and_all_stone_counts(of_share)
    share_mean, share_low, share_high = _predicted_fall_share_over_heights_and_frictions(
        predictions, of_share or stones
    )
    return SurveyPredictionComparison(
        **_stone_counts_as_comparison_attributes(predictions, stones),
        fallen_count_at_sites_with_standing_stones=share_fell,
        stone_count_at_sites_with_standing_stones=share_stones,
        computed_fall_share=share_mean,
        lowest_computed_fall_share=share_low,
        highest_computed_fall_share=share_high,
        **directions,
        octant_chi_square_test=chi_square_test_of_sectors(observed, share),
        octant_watson_u2_test=watson_u2_test_of_sectors(observed, share),
        exact_azimuth_watson_u2_test=azimuth_goodness_of_fit(
            site, fallen, float(np.nan_to_num(origin)), random_survey_count, random_survey_seed
        ),
        octant_uniformity_test=watson_u2_test_of_sectors(observed, uniform_octant),
        confusion_matrix=_confusion_matrix_of_standing_and_fall_sides(predictions, stones),
        assumed_random_fall_direction_share=random_outcome_stone_share,
    )


def _stones_fallen_in_known_direction_with_predictions(
    predictions: SurveyFallPrediction, stones: Sequence[Stone]
) -> list[FallenStoneWithDirectionProbabilities]:
    """Return the stones that fell in a known direction, with their predicted sector and octant probabilities.

    A row of several equal stones is repeated `Stone.stone_count` times.
    """
    fallen: list[FallenStoneWithDirectionProbabilities] = []
    for stone in stones:
        if stone.fell_in_known_direction:
            site_prediction = predictions.site_prediction_for_stone(stone)
            density = _sector_probabilities_given_fall(site_prediction, stone)
            fallen += stone.stone_count * [(stone, density, site_prediction.octant_probabilities_from_sectors(density))]
    return fallen


def _predicted_fall_share_over_heights_and_frictions(
    predictions: SurveyFallPrediction, stones: Sequence[Stone]
) -> tuple[float, float, float]:
    """Return the predicted share of stones that fall: mean, smallest and largest over heights and frictions.

    Heights and frictions are those of the cube; smallest and largest are NaN if the share is the same for all.
    """
    predict = predictions.site_prediction_for_stone
    falls = np.array([predict(stone).simulated_fall_probability_by_height_and_friction(stone) for stone in stones])
    weight = np.isfinite(falls) * np.array([stone.stone_count for stone in stones])[:, None, None]
    known = weight.sum(axis=0) > 0
    if not known.any():
        return math.nan, math.nan, math.nan
    share = (np.nan_to_num(falls) * weight).sum(axis=0)[known] / weight.sum(axis=0)[known]
    low, high = (
        (share.min(), share.max()) if np.ptp(share) > MAX_ABSOLUTE_DIFFERENCE_OF_EQUAL_VALUES else (math.nan, math.nan)
    )
    return float(share.mean()), float(low), float(high)


def _stone_counts_as_comparison_attributes(
    predictions: SurveyFallPrediction, stones: Sequence[Stone]
) -> dict[str, Any]:
    """Return numbers of stones (fallen, standing, without face, …) by attribute of `SurveyPredictionComparison`."""

    def count_stones_with(condition: Callable[[Stone], bool]) -> int:
        """Return the number of stones for which `condition` is True; a row counts `Stone.stone_count` times."""
        return sum(stone.stone_count for stone in stones if condition(stone))

    def lacks_outcome_although_b_over_h_near_grid(stone: Stone) -> bool:
        """Return True if a stone has no computed outcome, although its B/H is not far outside the grid."""
        prediction = predictions.site_prediction_for_stone(stone)
        return not prediction.has_known_fall_probability(stone) and not prediction.has_b_over_h_far_outside_grid(stone)

    return {
        "fallen": count_stones_with(lambda stone: stone.fell),
        "stood": count_stones_with(lambda stone: not stone.fell),
        "known_direction_falls_without_face_or_b_over_h": count_stones_with(
            lambda stone: stone.fell_in_known_direction and not has_known_face_and_at_least_one_b_over_h(stone)
        ),
        "known_direction_falls_without_face_azimuth": count_stones_with(
            lambda stone: stone.fell_in_known_direction and math.isnan(stone.face_azimuth_deg)
        ),
        "known_direction_falls_without_b_over_h": count_stones_with(
            lambda stone: stone.fell_in_known_direction and math.isnan(stone.b_over_h_in_both_planes[0])
        ),
        "falls_without_direction": count_stones_with(lambda stone: stone.fell and not stone.fell_in_known_direction),
        "stones_outside_b_over_h_grid": count_stones_with(predictions.default_prediction.has_b_over_h_outside_grid),
        "stones_far_outside_b_over_h_grid": count_stones_with(
            lambda stone: predictions.site_prediction_for_stone(stone).has_b_over_h_far_outside_grid(stone)
        ),
        "stones_outside_height_grid": count_stones_with(predictions.default_prediction.has_height_outside_grid),
        "known_direction_falls_without_any_computed_fall": count_stones_with(
            lambda stone: (
                stone.fell_in_known_direction
                and predictions.site_prediction_for_stone(stone).no_simulated_block_like_stone_falls(stone)
            )
        ),
        "stones_without_computed_outcome": count_stones_with(lacks_outcome_although_b_over_h_near_grid),
        "known_direction_falls_without_computed_outcome": count_stones_with(
            lambda stone: stone.fell_in_known_direction and lacks_outcome_although_b_over_h_near_grid(stone)
        ),
        "known_direction_falls_without_prediction": count_stones_with(
            lambda stone: (
                stone.fell_in_known_direction
                and not predictions.site_prediction_for_stone(stone).has_known_fall_probability(stone)
            )
        ),
    }


def _confusion_matrix_of_standing_and_fall_sides(
    predictions: SurveyFallPrediction, stones: Sequence[Stone]
) -> NDArray[np.int64] | None:
    """Count the stones by observed outcome (rows) and most probable outcome (columns): stands or side of fall.

    The shape is (5, 5); sides are in the order of `STANDING_OR_FALL_SIDES`. None if no stone of known face and B/H has
    a computed outcome.
    """
    known = [
        stone
        for stone in stones
        if has_known_face_and_at_least_one_b_over_h(stone)
        and (stone.fell_in_known_direction or not stone.fell)
        and predictions.site_prediction_for_stone(stone).has_known_fall_probability(stone)
    ]
    confusion = np.zeros((len(STANDING_OR_FALL_SIDES), len(STANDING_OR_FALL_SIDES)), dtype=np.int64)
    for stone in known:
        probable = int(np.argmax(predictions.site_prediction_for_stone(stone).standing_and_side_probabilities(stone)))
        confusion[observed_standing_or_side_index(stone), probable] += stone.stone_count
    return confusion if known else None
