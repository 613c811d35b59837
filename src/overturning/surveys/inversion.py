"""Inversion of a survey for the motion: likelihood of its stones for each motion, strength and rotation."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.statistics.circular import sector_index
from overturning.surveys.posterior import (
    MOTION_ROTATION_COUNT,
    MOTION_ROTATION_STEP_DEG,
    MotionPosterior,
    SurveyInversionResult,
)
from overturning.surveys.responses import (
    StoneHeightAndSideRatios,
    StoneOutcomeProbabilities,
    outcome_probabilities_if_nothing_is_known,
)
from overturning.surveys.stone_outcomes import (
    DIRECTION_BIN_COUNT,
    DIRECTION_BIN_WIDTH_DEG,
    ORIENTATION_STEP_DEG,
    SIMULATED_PGV_M_S,
    STANDING_OUTCOME_INDEX,
)
from overturning.surveys.stones import RANDOM_OUTCOME_SHARE, Stone

DIRECTION_LIKELIHOOD_EXPONENT: Final = 0.3
"""Exponent of the likelihood of the directions.

All directions of a survey share the error of a motion that is not the true one, so they carry less information than
independent ones. The value is calibrated in `verification/backwards_coverage.py`.
"""

ALL_OUTCOME_INDICES: Final = np.arange(DIRECTION_BIN_COUNT + 1)
"""Outcome indices: those of all direction bins, and `STANDING_OUTCOME_INDEX`."""

_OCTANT_OR_STANDING_BY_OUTCOME_INDEX: Final = np.append(
    sector_index(DIRECTION_BIN_WIDTH_DEG * np.arange(DIRECTION_BIN_COUNT), 8), 8
)
"""Compass octant of each direction bin; 8 stands for standing."""

FIT_CHECK_RANDOM_SURVEY_COUNT: Final = 200
"""Number of random surveys in the check of fit."""

MIN_FIT_P_VALUE: Final = 0.01
"""Smallest p-value of the check of fit; below it no motion of the library fits the survey."""


@dataclass(frozen=True)
class SurveyInversion:
    """Bayesian inversion of a survey: infers the ground motion from the fallen and standing stones.

    Parameters
    ----------
    stone_outcome_probabilities : StoneOutcomeProbabilities
        Probabilities of the outcomes of all kinds of stones of the surveys, for each candidate motion.
    random_outcome_stone_share : float
        Share of stones with a random outcome (pushed, badly founded).
    share_of_stones_fixed_to_base : float
        Share of stones fixed to their base, which always stand.
    """

    stone_outcome_probabilities: StoneOutcomeProbabilities
    random_outcome_stone_share: float = RANDOM_OUTCOME_SHARE
    share_of_stones_fixed_to_base: float = 0.0

    def outcome_probabilities(
        self, stone: Stone, requested_outcome_indices: NDArray[np.intp] = ALL_OUTCOME_INDICES
    ) -> NDArray[np.float32]:
        """Return the probabilities of a stone's outcomes, shape (motions, velocity levels, rotations, outcomes).

        An outcome is the index of a direction bin of the fall, or `STANDING_OUTCOME_INDEX`; by default all are
        returned. The probabilities allow for the shares of stones with a random outcome and of fixed stones. Velocity
        levels are peak velocities to which a motion is scaled; rotations turn it about the vertical.
        """
        table = self.stone_outcome_probabilities.outcome_probability_table(
            StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(stone)
        )
        turn, face = MOTION_ROTATION_STEP_DEG * np.arange(MOTION_ROTATION_COUNT), stone.slender_plane_azimuth_deg
        place, apart = np.zeros(MOTION_ROTATION_COUNT, np.intp), np.zeros(MOTION_ROTATION_COUNT, np.float64)
        if table.shape[2] > 1 and math.isnan(face):
            table = table.mean(axis=2, keepdims=True)
        elif table.shape[2] > 1:
            place = np.round((face - turn) / ORIENTATION_STEP_DEG).astype(np.intp)
            apart = np.asarray(face - turn - ORIENTATION_STEP_DEG * place, np.float64)
        # Convert bins from true north to bins relative to the rotated motion and the simulated face.
        back = np.round((turn + apart) / DIRECTION_BIN_WIDTH_DEG).astype(np.intp)[:, None]
        seen = table[
            :,
            :,
            (place % table.shape[2])[:, None],
            np.where(
                requested_outcome_indices == STANDING_OUTCOME_INDEX,
                STANDING_OUTCOME_INDEX,
                (requested_outcome_indices - back) % DIRECTION_BIN_COUNT,
            ),
        ]
        free = (
            1 - self.random_outcome_stone_share
        ) * seen + self.random_outcome_stone_share * outcome_probabilities_if_nothing_is_known()[
            requested_outcome_indices
        ].astype(np.float32)
        return np.asarray(
            (1 - self.share_of_stones_fixed_to_base) * free
            + np.float32(self.share_of_stones_fixed_to_base) * (requested_outcome_indices == STANDING_OUTCOME_INDEX)
        )

    def fall_and_direction_log_likelihoods_of_survey(self, stones: Sequence[Stone]) -> FloatArray:
        """Compute log-likelihoods of falls and fall directions in a survey, (2, motions, levels, rotations).

        Stones are taken as independent. The first index is 0 for the log-likelihood that the stones fell or stand as
        observed, and 1 for that of the observed fall directions, given the falls.
        """
        total = np.zeros(
            (2, len(self.stone_outcome_probabilities.motions), SIMULATED_PGV_M_S.size, MOTION_ROTATION_COUNT)
        )
        for stone in stones:
            chance = self.outcome_probabilities(
                stone, np.append(outcome_indices_matching_observation(stone), STANDING_OUTCOME_INDEX)
            )
            stands, falls = chance[..., -1], 1 - chance[..., -1]
            total[0] += stone.stone_count * np.log(falls if stone.fell else stands)
            if stone.fell_in_known_direction:
                total[1] += stone.stone_count * np.log(chance[..., :-1].sum(axis=-1) / falls)
        return total

    def compute_posterior(
        self,
        log_likelihoods_of_falls_and_directions: FloatArray,
        *,
        prior_weights: ArrayLike = 1.0,
        direction_likelihood_exponent: float = DIRECTION_LIKELIHOOD_EXPONENT,
    ) -> MotionPosterior:
        """Compute the posterior probabilities of motion, peak-velocity level and rotation from log-likelihoods.

        In the shapes below, s is the number of motions, l of peak-velocity levels, and r of rotations.

        Parameters
        ----------
        log_likelihoods_of_falls_and_directions : ndarray, shape (2, s, l, r)
            Result of `fall_and_direction_log_likelihoods_of_survey`.
        prior_weights : array_like
            Prior weights that broadcast to (s, l, r); default: uniform.
        direction_likelihood_exponent : float
            Exponent of the likelihood of the directions, see `DIRECTION_LIKELIHOOD_EXPONENT`.
        """
        of_falls, of_directions = log_likelihoods_of_falls_and_directions
        total = of_falls + direction_likelihood_exponent * of_directions
        weight = np.broadcast_to(np.asarray(prior_weights, dtype=np.float64), total.shape)
        probability = weight * np.exp(total - total[weight > 0].max())
        motions = self.stone_outcome_probabilities.motions
        return MotionPosterior(
            motion_names=tuple(one.name for one in motions),
            pgv_levels_m_s=SIMULATED_PGV_M_S,
            clockwise_rotations_deg=np.arange(0.0, 360.0, MOTION_ROTATION_STEP_DEG),
            posterior_probability=probability / probability.sum(),
            prior_probability=weight / weight.sum(),
            pga_m_s2_at_pgv_1_m_s=np.array([one.pga_m_s2 / one.pgv_m_s for one in motions]),
            unrotated_peak_velocity_azimuth_deg=np.array([one.peak_velocity_azimuth_deg for one in motions]),
        )

    def invert_survey(self, survey_name: str, stones: Sequence[Stone]) -> SurveyInversionResult:
        """Infer the ground motion from the stones of the survey `survey_name`, with a check of the goodness of fit.

        The motion is inferred from all stones together and, if the survey has several sites, from the stones of each
        site by itself.
        """
        parts = {
            site: [one for one in stones if one.site == site] for site in dict.fromkeys(one.site for one in stones)
        }
        log_likelihoods = {
            site: self.fall_and_direction_log_likelihoods_of_survey(part) for site, part in parts.items()
        }
        together = self._inversion_result_for_stones(
            survey_name, stones, np.sum(list(log_likelihoods.values()), axis=0)
        )
        if len(parts) == 1:
            return together
        sites = (self._inversion_result_for_stones(site, part, log_likelihoods[site]) for site, part in parts.items())
        return replace(together, site_results=tuple(sites))

    def _inversion_result_for_stones(
        self, survey_or_site_name: str, stones: Sequence[Stone], log_likelihoods_of_falls_and_directions: FloatArray
    ) -> SurveyInversionResult:
        """Return the posterior of the motions, the p-value of fit, and the numbers of fallen and standing stones."""
        posterior = self.compute_posterior(log_likelihoods_of_falls_and_directions)
        fell, stood = (sum(one.stone_count for one in stones if one.fell is kind) for kind in (True, False))
        fit = self.posterior_predictive_p_value(stones, posterior)
        return SurveyInversionResult(
            survey_or_site_name, fell, stood, self.share_of_stones_fixed_to_base, fit, posterior
        )

    def posterior_predictive_p_value(
        self, stones: Sequence[Stone], posterior: MotionPosterior, random_survey_seed: int = 1
    ) -> float:
        """Compute the p-value of fit: share of random surveys that fit no better than the observed survey.

        A random survey has the stones of the survey, with outcomes under a motion drawn from the posterior (Gelman,
        Meng & Stern 1996, Statistica Sinica 6, 733). The fit to one motion, level and rotation is the sum, over stones,
        of the log probability that the stone falls or stands as observed, and, if it fell, the log of the density of
        its direction over the largest density of a direction (so that the resolution of directions has no effect).
        The measure of fit is the maximum over all motions, levels and rotations with a prior above 0.
        """
        generator = np.random.Generator(np.random.PCG64(random_survey_seed))
        possible = np.flatnonzero(posterior.prior_probability.ravel() > 0)
        share = posterior.posterior_probability.ravel()[possible]
        drawn = generator.choice(possible.size, FIT_CHECK_RANDOM_SURVEY_COUNT, p=share / share.sum())
        totals = np.zeros((possible.size, 1 + FIT_CHECK_RANDOM_SURVEY_COUNT), np.float32)
        for stone in stones:
            chance = self.outcome_probabilities(stone).reshape(-1, DIRECTION_BIN_COUNT + 1)[possible]
            own = int(outcome_indices_matching_observation(stone)[0])
            if stone.has_16_point_direction:
                own = round(stone.fall_azimuth_deg / DIRECTION_BIN_WIDTH_DEG) % DIRECTION_BIN_COUNT
            if stone.has_octant_direction:
                chance = np.stack(
                    [chance[:, place == _OCTANT_OR_STANDING_BY_OUTCOME_INDEX].sum(axis=1) for place in range(9)], axis=1
                )
                own = int(sector_index(stone.fall_azimuth_deg, 8))
            elif stone.fell and not stone.fell_in_known_direction:
                chance, own = np.stack([chance[:, :-1].sum(axis=1), chance[:, -1]], axis=1), 0
            below, falls = chance[drawn].cumsum(axis=1), chance[:, :-1]
            density = falls / falls.max(axis=1, keepdims=True)
            good = np.log(np.append(density * falls.sum(axis=1, keepdims=True), chance[:, -1:], 1))
            for _ in range(stone.stone_count):
                lot = generator.random(FIT_CHECK_RANDOM_SURVEY_COUNT)[:, None] * below[:, -1:]
                totals += good[:, np.append(own, (lot >= below).sum(axis=1))]
        best = totals.max(axis=0)
        return float((1 + (best[1:] <= best[0] + 1e-4).sum()) / (1 + FIT_CHECK_RANDOM_SURVEY_COUNT))


def outcome_indices_matching_observation(stone: Stone) -> NDArray[np.intp]:
    """Return the indices of the simulated outcomes (directions, or standing) that fit the observation of a stone.

    They are `STANDING_OUTCOME_INDEX` for a standing stone, otherwise the direction bins that agree with the direction
    of the fall; all bins if the direction is unknown.
    """
    if not stone.fell:
        return np.array([STANDING_OUTCOME_INDEX])
    if not stone.fell_in_known_direction:
        return np.arange(DIRECTION_BIN_COUNT)
    if stone.has_octant_direction:
        return np.flatnonzero(
            _OCTANT_OR_STANDING_BY_OUTCOME_INDEX[:STANDING_OUTCOME_INDEX] == sector_index(stone.fall_azimuth_deg, 8)
        )
    if stone.has_16_point_direction:
        away = (
            DIRECTION_BIN_WIDTH_DEG * np.arange(DIRECTION_BIN_COUNT) - stone.fall_azimuth_deg + 180.0
        ) % 360.0 - 180.0
        return np.flatnonzero(np.abs(away) <= stone.direction_uncertainty_half_width_deg)
    return np.array([round(stone.fall_azimuth_deg / DIRECTION_BIN_WIDTH_DEG) % DIRECTION_BIN_COUNT])
