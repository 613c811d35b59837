"""Observed fall directions against those that a study predicts: likelihood ratio, and probabilities of arcs."""

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.statistics.circular import mean_angle_and_resultant, sector_index
from overturning.statistics.mean_direction import clear_mean_direction
from overturning.surveys.sectors import FallSectors
from overturning.surveys.stones import Stone

FallenStone = tuple[Stone, FloatArray, FloatArray]
"""A stone that fell in a known direction, its probabilities of the sectors of a study, and of the 8 octants."""

RANDOM_SURVEYS: Final = 2000
"""Number of surveys with random fall directions for a p-value."""

WIND_DEG: Final = 22.5
"""Width of one of 16 winds, degrees."""


def stone_count_by_octant(stone: Stone) -> FloatArray:
    """Return the share of a fallen stone that counts in each compass octant: 1 in one, or ½ in each of two.

    The shape is (8,). One of 16 winds between two octants (NNE) counts half in each: it is known to ±11.25°.
    """
    half = stone.direction_half_width_deg if stone.wind_16 else 0.0
    # Just inside the ends: an octant that the range only touches has no part of it.
    ends = sector_index(stone.azimuth_deg + np.array([-0.999, 0.999]) * half, 8)
    if ends[0] == ends[1]:
        return np.eye(8)[ends[0]]
    border = 45.0 * ends[1] - 22.5
    below = ((border - stone.azimuth_deg + 180.0) % 360.0 - 180.0 + half) / (2 * half)
    return np.asarray(below * np.eye(8)[ends[0]] + (1 - below) * np.eye(8)[ends[1]])


def fall_probability_of_arc(
    sectors: FallSectors, sector_probabilities: FloatArray, begin_deg: float, end_deg: float
) -> float:
    """Return the probability that a stone falls between two azimuths, clockwise from the first to the second.

    The density of fall directions is constant within each sector of the study; `sector_probabilities`, shape
    (sectors,), sum to 1. An arc from an azimuth to itself has the probability 0.
    """
    below = np.concatenate([[0.0], np.cumsum(np.tile(sector_probabilities, 2))])
    start = sectors.borders[0]
    borders = np.append(sectors.borders[:-1], sectors.borders + 360.0) - start
    begin = (begin_deg - start) % 360.0
    at = np.interp([begin, begin + (end_deg - begin_deg) % 360.0], borders, below)
    return float(min(max(at[1] - at[0], 0.0), 1.0))


def _probabilities_of_winds(sectors: FallSectors, sector_probabilities: FloatArray, offset_deg: float) -> FloatArray:
    """Return the probabilities of 16 arcs of `WIND_DEG`, the first centred at `offset_deg`, shape (16,)."""
    middles = offset_deg + WIND_DEG * np.arange(16)
    return np.array([
        fall_probability_of_arc(sectors, sector_probabilities, middle - WIND_DEG / 2, middle + WIND_DEG / 2)
        for middle in middles.tolist()
    ])  # fmt: skip


def _direction_classes(sectors: FallSectors, fallen_stone: FallenStone) -> tuple[FloatArray, FloatArray, int]:
    """Return predicted and uniform probabilities of the directions that a stone's record can name, and its own index.

    These are the 8 octants or 16 winds, turned by the declination, or the sectors of the study for degrees.
    """
    stone, density, octants = fallen_stone
    uniform = sectors.share
    if stone.octant:
        even = sectors.octant_from_sector_probabilities(uniform)
        return octants, even, int(sector_index(stone.azimuth_deg, 8))
    if stone.wind_16:
        offset = stone.azimuth_deg % WIND_DEG
        predicted, even = (_probabilities_of_winds(sectors, of, offset) for of in (density, uniform))
        return predicted, even, round((stone.azimuth_deg - offset) / WIND_DEG) % 16
    return density, uniform, sectors.nearest_azimuth_index(stone.azimuth_deg)


def log_likelihood_ratio_and_p_value(
    sectors: FallSectors, fallen_stones: Sequence[FallenStone], random_survey_count: int, seed: int
) -> tuple[float, float]:
    """Return the log-likelihood ratio of predicted to uniform fall directions over fallen stones, and its p-value.

    The p-value is the share of surveys with random directions whose sum is as large or larger. The random direction of
    a stone has the resolution of its observed direction: degrees, one of 16 winds, or an octant.
    """
    if not fallen_stones:
        return math.nan, math.nan
    generator = np.random.Generator(np.random.PCG64(seed))
    ratios, simulated = [], np.zeros(random_survey_count)
    for fallen_stone in fallen_stones:
        predicted, chance, place = _direction_classes(sectors, fallen_stone)
        with np.errstate(divide="ignore"):  # a density of 0 is possible without background
            logs = np.log(predicted / chance)
        ratios.append(logs[place])
        simulated += logs[generator.choice(chance.size, size=random_survey_count, p=chance / chance.sum())]
    total = float(np.sum(ratios))
    return total, (1 + int((simulated >= total - 1e-12).sum())) / (1 + random_survey_count)


def compare_observed_and_predicted_directions(
    sectors: FallSectors, fallen_stones: Sequence[FallenStone], random_survey_count: int, seed: int
) -> dict[str, Any]:
    """Return the numbers on directions that comparisons with 2-D and 3-D studies share, by name of their attribute.

    They are mean directions and resultants, octants, and the likelihood ratio with its p-value; see
    `overturning.surveys.comparison.SurveyPredictionComparison`.
    """
    mean, length, _ = clear_mean_direction(
        [stone.azimuth_deg for stone, *_ in fallen_stones], [stone.recorded_step_deg for stone, *_ in fallen_stones]
    )
    density = sum((of_stone for _, of_stone, _ in fallen_stones), np.zeros(sectors.azimuth.size))
    predicted_mean, predicted_length = mean_angle_and_resultant(sectors.azimuth, density)
    ratio, p_value = log_likelihood_ratio_and_p_value(sectors, fallen_stones, random_survey_count, seed)
    return {
        "mean_direction_deg": mean,
        "resultant": length,
        "predicted_mean_direction_deg": predicted_mean,
        "predicted_resultant": predicted_length,
        "octant_observed": sum((stone_count_by_octant(stone) for stone, *_ in fallen_stones), np.zeros(8)),
        "octant_predicted": sum((octants for *_, octants in fallen_stones), np.zeros(8)),
        "log_likelihood_ratio": ratio,
        "likelihood_ratio_p": p_value,
    }
