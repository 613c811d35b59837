"""Observed fall directions against those that a study predicts: likelihood ratio, and probabilities of arcs."""

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.statistics.circular import (
    StatisticalTestResult,
    mean_angle_deg_and_mean_resultant_length,
    sector_index,
    watson_u2_test,
)
from overturning.statistics.mean_direction import mean_direction_if_significant_resultant_and_test
from overturning.surveys.sectors import AzimuthSectors
from overturning.surveys.stones import Stone

FallenStoneWithDirectionProbabilities = tuple[Stone, FloatArray, FloatArray]
"""A stone that fell in a known direction, its probabilities of the sectors of a study, and of the 8 octants."""

RANDOM_SURVEYS_PER_P_VALUE: Final = 2000
"""Number of surveys with random fall directions for a p-value."""

COMPASS_POINT_WIDTH_DEG: Final = 22.5
"""Width of one of 16 compass points, degrees."""


def octant_weights_of_fallen_stone(stone: Stone) -> FloatArray:
    """Return the share, 0 to 1, of a fallen stone that counts in each compass octant: all in one, or part in two.

    The shape is (8,). A direction between two octants, such as NNE, is known to ±11.25° and counts half in each. An
    azimuth in degrees that was recorded in steps of, say, 10° stands for an arc of this width; if the arc extends over
    two octants, the stone counts in each by the part of the arc.
    """
    if stone.has_octant_direction or not stone.direction_recording_step_deg:
        return np.eye(8)[sector_index(stone.fall_azimuth_deg, 8)]
    return _share_of_each_arc_in_each_octant(np.array([stone.fall_azimuth_deg]), stone.direction_recording_step_deg)[0]


def _share_of_each_arc_in_each_octant(arc_middle_azimuths_deg: FloatArray, arc_width_deg: float) -> FloatArray:
    """Return the share of each arc of a circle that lies in each compass octant, shape (arcs, 8)."""
    # Borders of three full circles: an arc that crosses north continues in the next circle.
    border = 45.0 * np.arange(-8, 17) - 22.5
    below = np.clip((border - (arc_middle_azimuths_deg % 360.0)[:, None]) / arc_width_deg + 0.5, 0.0, 1.0)
    return np.asarray(np.diff(below, axis=1).reshape(-1, 3, 8).sum(axis=1))


def fall_direction_probabilities_of_arcs(
    sectors: AzimuthSectors,
    fall_direction_probability_by_sector: FloatArray,
    arc_begin_azimuth_deg: ArrayLike,
    arc_end_azimuth_deg: ArrayLike,
) -> FloatArray:
    """Return the probabilities that a stone falls between two azimuths, clockwise from the first to the second.

    The probabilities `fall_direction_probability_by_sector`, shape (sectors,), sum to 1; within each sector the
    density is constant. An arc from an azimuth to itself has the probability 0. The azimuths, degrees, are arrays of
    one shape, or numbers.
    """
    below = np.concatenate([[0.0], fall_direction_probability_by_sector, fall_direction_probability_by_sector]).cumsum()
    start = sectors.borders[0]
    borders = np.append(sectors.borders[:-1], sectors.borders + 360.0) - start
    first, last = np.asarray(arc_begin_azimuth_deg, np.float64), np.asarray(arc_end_azimuth_deg, np.float64)
    begin = (first - start) % 360.0
    return np.clip(
        np.interp(begin + (last - first) % 360.0, borders, below) - np.interp(begin, borders, below), 0.0, 1.0
    )


def _distinguishable_direction_arcs_deg(stone: Stone) -> tuple[FloatArray, FloatArray]:
    """Divide the circle into arcs as wide as the step in which a stone's direction is recorded; return their ends.

    The result is the begin and the end of each arc, degrees. One arc has the recorded direction in its middle; the
    first one begins between 0° and the step.
    """
    step = stone.direction_recording_step_deg
    begin = (stone.fall_azimuth_deg - 0.5 * step) % step + step * np.arange(round(360.0 / step), dtype=np.float64)
    return begin, begin + step


def _expected_octant_weights_of_fallen_stone(
    sectors: AzimuthSectors, fallen_stone: FallenStoneWithDirectionProbabilities
) -> FloatArray:
    """Return the expected share, 0 to 1, with which a fallen stone counts in each compass octant, shape (8,).

    The expectation is over the predicted fall directions; each direction counts as an observed one does in
    `octant_weights_of_fallen_stone`, so that a direction recorded in steps may count in two octants.
    """
    stone, density, octants = fallen_stone
    if stone.has_octant_direction or not stone.direction_recording_step_deg:
        return octants
    begin, end = _distinguishable_direction_arcs_deg(stone)
    shares = _share_of_each_arc_in_each_octant(0.5 * (begin + end), stone.direction_recording_step_deg)
    return np.asarray(fall_direction_probabilities_of_arcs(sectors, density, begin, end) @ shares)


def azimuth_goodness_of_fit(
    sectors: AzimuthSectors,
    fallen_stones: Sequence[FallenStoneWithDirectionProbabilities],
    distribution_function_origin_azimuth_deg: float,
    random_survey_count: int,
    random_survey_seed: int,
) -> StatisticalTestResult:
    """Test with Watson's U² whether fall azimuths of stones follow the distributions predicted for the stones.

    The test is of the values of the predicted distribution functions at the observed azimuths; each function is 0 at
    `distribution_function_origin_azimuth_deg` and increases clockwise. An azimuth recorded in steps stands for an arc
    as wide as the step and has the value reached with half of the arc's probability; the p-value is then from random
    surveys, drawn from the prediction and recorded in the same steps. Only azimuths in degrees are tested, not octants
    and compass points.
    """
    exact = [one for one in fallen_stones if one[0].direction_uncertainty_half_width_deg == 0.0]
    drawn = np.random.Generator(np.random.PCG64(random_survey_seed)).random((random_survey_count, len(exact)))
    observed = np.zeros(len(exact))
    for place, (stone, density, _) in enumerate(exact):
        step = stone.direction_recording_step_deg
        first = stone.fall_azimuth_deg - 0.5 * step
        half = 0.5 * fall_direction_probabilities_of_arcs(sectors, density, first, first + step)
        observed[place] = (
            fall_direction_probabilities_of_arcs(sectors, density, distribution_function_origin_azimuth_deg, first)
            + half
        ) % 1.0
        if step:
            begin, _ = _distinguishable_direction_arcs_deg(stone)
            borders = np.sort(
                fall_direction_probabilities_of_arcs(sectors, density, distribution_function_origin_azimuth_deg, begin)
            )
            around = 0.5 * (borders[-1] + borders[0] + 1.0) % 1.0  # of the arc in which the origin lies
            middles = np.concatenate([[around], 0.5 * (borders[1:] + borders[:-1]), [around]])
            drawn[:, place] = middles[np.searchsorted(borders, drawn[:, place], side="right")]
    in_steps = any(stone.direction_recording_step_deg for stone, *_ in exact)
    return watson_u2_test(observed, drawn if in_steps else None)


def _predicted_and_uniform_probabilities_and_class(
    sectors: AzimuthSectors, fallen_stone: FallenStoneWithDirectionProbabilities
) -> tuple[FloatArray, FloatArray, int]:
    """Return predicted and uniform probabilities of a stone's direction classes, and the index of the observed class.

    The classes are the 8 octants, the 16 compass points (turned by the magnetic declination) or, for a direction in
    degrees, the azimuth sectors of the study.
    """
    stone, density, octants = fallen_stone
    uniform = sectors.share
    if stone.has_octant_direction:
        even = sectors.octant_probabilities_from_sectors(uniform)
        return octants, even, int(sector_index(stone.fall_azimuth_deg, 8))
    if stone.has_16_point_direction:
        begin, end = _distinguishable_direction_arcs_deg(stone)
        predicted, even = (fall_direction_probabilities_of_arcs(sectors, of, begin, end) for of in (density, uniform))
        return (
            predicted,
            even,
            round((stone.fall_azimuth_deg - 0.5 * COMPASS_POINT_WIDTH_DEG - begin[0]) / COMPASS_POINT_WIDTH_DEG) % 16,
        )
    return density, uniform, sectors.nearest_sector_index(stone.fall_azimuth_deg)


def direction_log_likelihood_ratio_and_p_value(
    sectors: AzimuthSectors,
    fallen_stones: Sequence[FallenStoneWithDirectionProbabilities],
    random_survey_count: int,
    random_survey_seed: int,
) -> tuple[float, float]:
    """Return the log-likelihood ratio of predicted to uniform fall directions over fallen stones, and its p-value.

    The p-value is the share of surveys with random directions whose ratio is as large or larger. The random direction
    of a stone has the resolution of its observed direction: degrees, one of 16 compass points, or an octant.
    """
    if not fallen_stones:
        return math.nan, math.nan
    generator = np.random.Generator(np.random.PCG64(random_survey_seed))
    ratios, simulated = [], np.zeros(random_survey_count)
    for fallen_stone in fallen_stones:
        predicted, chance, place = _predicted_and_uniform_probabilities_and_class(sectors, fallen_stone)
        with np.errstate(divide="ignore"):  # a density of 0 is possible without background
            logs = np.log(predicted / chance)
        ratios.append(logs[place])
        simulated += logs[generator.choice(chance.size, size=random_survey_count, p=chance / chance.sum())]
    total = float(np.sum(ratios))
    return total, (1 + int((simulated >= total - 1e-12).sum())) / (1 + random_survey_count)


def compare_observed_and_predicted_directions(
    sectors: AzimuthSectors,
    fallen_stones: Sequence[FallenStoneWithDirectionProbabilities],
    random_survey_count: int,
    random_survey_seed: int,
) -> dict[str, Any]:
    """Compare observed with predicted fall directions; return the results by name.

    The results are mean directions and resultant lengths, counts by octant, and the likelihood ratio with its p-value;
    their names are those of attributes of `overturning.surveys.comparison.SurveyPredictionComparison`.
    """
    mean, length, _ = mean_direction_if_significant_resultant_and_test(
        [stone.fall_azimuth_deg for stone, *_ in fallen_stones],
        [stone.direction_recording_step_deg for stone, *_ in fallen_stones],
    )
    density = sum((of_stone for _, of_stone, _ in fallen_stones), np.zeros(sectors.azimuth.size))
    predicted_mean, predicted_length = mean_angle_deg_and_mean_resultant_length(sectors.azimuth, density)
    ratio, p_value = direction_log_likelihood_ratio_and_p_value(
        sectors, fallen_stones, random_survey_count, random_survey_seed
    )
    return {
        "observed_mean_direction_deg": mean,
        "observed_resultant_length": length,
        "predicted_mean_direction_deg": predicted_mean,
        "predicted_resultant_length": predicted_length,
        "observed_count_by_octant": sum(
            (octant_weights_of_fallen_stone(stone) for stone, *_ in fallen_stones), np.zeros(8)
        ),
        "predicted_count_by_octant": sum(
            (_expected_octant_weights_of_fallen_stone(sectors, one) for one in fallen_stones), np.zeros(8)
        ),
        "log_likelihood_ratio": ratio,
        "likelihood_ratio_p": p_value,
    }
