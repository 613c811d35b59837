"""Observed fall directions of the stones of a survey against those of similar stones of a 3-D study."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.stored import StoredFloatArray, StoredFloatOrInfinity, StoredFloatOrNan
from overturning.surveys.fall_directions import (
    RANDOM_SURVEYS_PER_P_VALUE,
    FallenStoneWithDirectionProbabilities,
    compare_observed_and_predicted_directions,
)
from overturning.surveys.sectors import AzimuthSectors
from overturning.surveys.stones import RANDOM_OUTCOME_SHARE, Stone

FALL_AZIMUTH_SMOOTHING_HALF_WIDTH_DEG: Final = 22.5
"""Half width of the sector of azimuth to which a computed fall is spread, degrees: that of an octant.

Only a few computed cases resemble a stone of known face and size, and tiny differences of the motion turn their falls
by some degrees.
"""

FALL_DIRECTION_SECTORS: Final = AzimuthSectors(np.arange(0.0, 360.0, 5.0))
"""Sectors of azimuth in which directions are predicted."""


@dataclass(frozen=True)
class FallDirectionComparisonIn3D:
    """Comparison of the observed fall directions of stones with those of the falls of a 3-D study.

    Attributes
    ----------
    fallen_in_known_direction : int
        Number of stones that fell in a known direction.
    known_direction_falls_without_any_computed_fall, known_direction_falls_without_computed_outcome : int
        Of these stones, the number without a similar computed stone that falls, and the number without a similar
        computed stone that has an outcome; a random direction is predicted for them.
    observed_mean_direction_deg, observed_resultant_length : float
        Mean direction of the observed falls, degrees (NaN if random directions are not rejected), and length of the
        mean unit vector.
    predicted_mean_direction_deg, predicted_resultant_length : float
        Mean of the predicted directions of these stones, degrees, and length of the mean unit vector.
    observed_count_by_octant, predicted_count_by_octant : ndarray, shape (8,)
        Observed and expected number of stones in each compass octant; see
        `overturning.surveys.fall_directions.octant_weights_of_fallen_stone`.
    log_likelihood_ratio, likelihood_ratio_p : float
        Sum over the stones of ln(predicted/uniform), above 0 if the prediction is better than random directions; and
        share of surveys with random directions that have a sum at least as large.
    assumed_random_fall_direction_share : float
        Assumed share of stones that fall in a random direction.
    """

    fallen_in_known_direction: int
    known_direction_falls_without_any_computed_fall: int
    known_direction_falls_without_computed_outcome: int
    observed_mean_direction_deg: StoredFloatOrNan
    observed_resultant_length: StoredFloatOrNan
    predicted_mean_direction_deg: StoredFloatOrNan
    predicted_resultant_length: StoredFloatOrNan
    observed_count_by_octant: StoredFloatArray
    predicted_count_by_octant: StoredFloatArray
    log_likelihood_ratio: StoredFloatOrInfinity
    likelihood_ratio_p: StoredFloatOrNan
    assumed_random_fall_direction_share: float


def fall_shares_by_sector_smoothed_over_arcs(fall_azimuths_deg: FloatArray) -> FloatArray:
    """Return the share of falls in each azimuth sector of `FALL_DIRECTION_SECTORS`; each fall is spread over an arc.

    `fall_azimuths_deg`, shape (falls,), are azimuths towards which stones fall, degrees; at least one. The arc extends
    `FALL_AZIMUTH_SMOOTHING_HALF_WIDTH_DEG` to each side of the azimuth. The result has shape (sectors,) and sum 1.
    """
    turns = np.array([-360.0, 0.0, 360.0])[:, None, None]
    start = np.asarray(fall_azimuths_deg % 360.0)[:, None] - FALL_AZIMUTH_SMOOTHING_HALF_WIDTH_DEG + turns
    below = np.clip(
        (FALL_DIRECTION_SECTORS.borders - start) / (2 * FALL_AZIMUTH_SMOOTHING_HALF_WIDTH_DEG), 0.0, 1.0
    ).sum(axis=0)
    return np.asarray(np.diff(below, axis=1).mean(axis=0))


def compare_fall_directions(
    stones: Sequence[Stone],
    computed_fall_azimuths_by_stone_deg: Sequence[FloatArray | None],
    *,
    random_fall_direction_share: float = RANDOM_OUTCOME_SHARE,
    random_survey_seed: int = 1,
) -> FallDirectionComparisonIn3D | None:
    """Compare the directions in which stones fell with those in which similar stones of a 3-D study fall.

    Parameters
    ----------
    stones : sequence of Stone
        Stones of the survey; those that stand, or fell in an unknown direction, are left out.
    computed_fall_azimuths_by_stone_deg : sequence of ndarray or None
        For each stone, the azimuths towards which the similar computed stones fall, degrees, shape (falls,); None if no
        similar stone has an outcome.
    random_fall_direction_share : float
        Share of stones that fall in a random direction, 0 to below 1.
    random_survey_seed : int
        Seed of the surveys with random directions (parametric bootstrap; see
        `overturning.surveys.fall_directions.direction_log_likelihood_ratio_and_p_value`).

    Returns
    -------
    FallDirectionComparisonIn3D or None
        None if no stone fell in a known direction.
    """
    fallen, never, without_outcome = list[FallenStoneWithDirectionProbabilities](), 0, 0
    for stone, computed in zip(stones, computed_fall_azimuths_by_stone_deg, strict=True):
        if not stone.fell_in_known_direction:
            continue
        density = FALL_DIRECTION_SECTORS.share
        if computed is None:
            without_outcome += stone.stone_count
        elif not computed.size:
            never += stone.stone_count
        else:
            density = (1 - random_fall_direction_share) * fall_shares_by_sector_smoothed_over_arcs(
                computed
            ) + random_fall_direction_share * FALL_DIRECTION_SECTORS.share
        fallen += stone.stone_count * [
            (stone, density, FALL_DIRECTION_SECTORS.octant_probabilities_from_sectors(density))
        ]
    if not fallen:
        return None
    return FallDirectionComparisonIn3D(
        fallen_in_known_direction=len(fallen),
        known_direction_falls_without_any_computed_fall=never,
        known_direction_falls_without_computed_outcome=without_outcome,
        assumed_random_fall_direction_share=random_fall_direction_share,
        **compare_observed_and_predicted_directions(
            FALL_DIRECTION_SECTORS, fallen, RANDOM_SURVEYS_PER_P_VALUE, random_survey_seed
        ),
    )
