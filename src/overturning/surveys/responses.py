"""Probabilities of the outcomes of stones under candidate motions, from outcomes simulated on a grid of sizes."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import REASON_SEPARATOR, ArgumentError
from overturning.settings import StonePopulation
from overturning.surveys.library import CandidateMotion
from overturning.surveys.stone_outcomes import (
    DIRECTION_BIN_COUNT,
    DIRECTION_BIN_WIDTH_DEG,
    SIMULATED_B_OVER_H,
    SIMULATED_D_OVER_B,
    SIMULATED_FRICTIONS,
    SIMULATED_HEIGHTS_M,
    SIMULATED_PGV_M_S,
    UNKNOWN_OUTCOME_INDEX,
    face_azimuths_to_simulate_for_d_over_b,
    outcomes_of_needed_sizes,
    size_keys_with_stored_outcomes,
    stone_outcome_cache_folder,
)
from overturning.surveys.stones import MAX_FACTOR_OUTSIDE_SIMULATED_RANGE, Stone

LN_B_OVER_H_STANDARD_DEVIATION_AT_EQUAL_SIZE: Final = 0.15
"""Standard deviation of ln B/H among stones with equal measured sizes (worn edges, footings, restitution)."""

LN_PGV_STANDARD_DEVIATION_WITHIN_SITE: Final = 0.15
"""Standard deviation of ln PGV over the site of one survey."""

CONCENTRATION, UNIFORM_FALL_DIRECTION_SHARE = 8.0, 0.2
"""Scatter of falls about the simulated direction: concentration (von Mises), and share with uniform directions."""

CASE_PROCESSOR_SECONDS_PER_MOTION_SECOND: Final = 3e-5
"""Processor time of a case per second of motion, s; order of magnitude, measured with columns and prisms."""

RANDOM_SIZE_COUNT: Final = 64
"""Number of random draws for unknown sizes."""


@dataclass(frozen=True)
class StoneHeightAndSideRatios:
    """Kind of stone to simulate for a survey: height, B/H (each None if unknown) and D/B.

    Attributes
    ----------
    height_m, smaller_b_over_h : float or None
        Height, m, and the smaller B/H of its two planes; None if unknown.
    d_over_b : float
        D/B, broader over narrower side, of a rectangular stone; 0 for a round stone.
    """

    height_m: float | None = None
    smaller_b_over_h: float | None = None
    d_over_b: float = 1.0

    @classmethod
    def from_stone_with_nearest_d_over_b(cls, stone: Stone) -> "StoneHeightAndSideRatios":
        """Return height, smaller B/H and nearest simulated D/B of a survey's stone.

        An `ArgumentError` is raised if height or B/H lie beyond the simulated range by more than the factor
        `MAX_FACTOR_OUTSIDE_SIMULATED_RANGE`.
        """
        front, side = stone.b_over_h_in_both_planes
        for name, value, grid in (
            ("height_m", stone.height_m, SIMULATED_HEIGHTS_M),
            ("b_over_h", min(front, side), SIMULATED_B_OVER_H),
        ):
            if not (
                math.isnan(value)
                or grid[0] / MAX_FACTOR_OUTSIDE_SIMULATED_RANGE
                <= value
                <= MAX_FACTOR_OUTSIDE_SIMULATED_RANGE * grid[-1]
            ):
                where = f"line {stone.line_number}: {name} {value:g}"
                raise ArgumentError(
                    f"{where}; stones of {grid[0]:g} to {grid[-1]:.3g} are computed: leave out the stone"
                )
        height = None if math.isnan(stone.height_m) else stone.height_m
        if math.isnan(front):
            return cls(height, None, 0.0 if stone.has_round_plan else 1.0)
        aspect = max(front, side) / min(front, side)
        nearest = min(SIMULATED_D_OVER_B, key=lambda one: abs(math.log(one / aspect)))
        return cls(
            height, front if stone.has_round_plan else min(front, side), 0.0 if stone.has_round_plan else nearest
        )

    @property
    def orientations_to_simulate_deg(self) -> FloatArray:
        """Face azimuths to simulate, degrees from the motion's north, without those equal by symmetry."""
        return face_azimuths_to_simulate_for_d_over_b(self.d_over_b)

    def size_grid_weights(self, population_for_unknown_sizes: StonePopulation) -> FloatArray:
        """Return the weight of each simulated height and B/H for stones of this kind, shape (heights, B/H); sum 1.

        Simulated values are `SIMULATED_HEIGHTS_M` and `SIMULATED_B_OVER_H`. Unknown sizes are distributed as in
        `population_for_unknown_sizes`. The weights of B/H are normal in ln B/H about a stone's value, with the standard
        deviation `LN_B_OVER_H_STANDARD_DEVIATION_AT_EQUAL_SIZE`.
        """
        generator = np.random.Generator(np.random.PCG64(population_for_unknown_sizes.seed))
        unit = scipy.stats.qmc.Sobol(2, scramble=True, rng=generator).random(RANDOM_SIZE_COUNT).T
        height, width = (
            one.low + (one.high - one.low) * u
            for one, u in zip(
                (population_for_unknown_sizes.height, population_for_unknown_sizes.width), unit, strict=True
            )
        )
        height = height if self.height_m is None else np.full(RANDOM_SIZE_COUNT, self.height_m)
        shape = width / height if self.smaller_b_over_h is None else np.full(RANDOM_SIZE_COUNT, self.smaller_b_over_h)
        place = np.interp(np.log(height), np.log(SIMULATED_HEIGHTS_M), np.arange(SIMULATED_HEIGHTS_M.size))
        of_height = np.maximum(0.0, 1 - np.abs(place[:, None] - np.arange(SIMULATED_HEIGHTS_M.size)))
        apart = (
            np.abs(np.log(SIMULATED_B_OVER_H / np.clip(shape, SIMULATED_B_OVER_H[0], SIMULATED_B_OVER_H[-1])[:, None]))
            / LN_B_OVER_H_STANDARD_DEVIATION_AT_EQUAL_SIZE
        )
        of_shape = np.where(apart <= 2.0, np.exp(-0.5 * apart**2), 0.0)
        return np.asarray(of_height.T @ (of_shape / of_shape.sum(axis=1, keepdims=True)) / RANDOM_SIZE_COUNT)


def dimensions_of_survey_stones(stones: Sequence[Stone], survey_file_name: str) -> list[StoneHeightAndSideRatios]:
    """Return height and shape of each stone of a survey as a `StoneHeightAndSideRatios`.

    An ArgumentError lists all stones too far outside the simulated range, see
    `StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b`.
    """
    kinds, faults = [], []
    for stone in stones:
        try:
            kinds.append(StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(stone))
        except ArgumentError as error:
            faults.append(f"{survey_file_name} {error}")
    if faults:
        raise ArgumentError(REASON_SEPARATOR.join(faults))
    return kinds


def note_on_stones_simulated_with_smaller_d_over_b(stones: Sequence[Stone]) -> tuple[str, ...]:
    """Return a note if stones of a survey are broader than the largest D/B that is simulated; () if none is."""
    shapes = [(stone.stone_count, stone.b_over_h_in_both_planes) for stone in stones if not stone.has_round_plan]
    most = MAX_FACTOR_OUTSIDE_SIMULATED_RANGE * SIMULATED_D_OVER_B[-1]
    broad = [(count, max(both) / min(both)) for count, both in shapes if max(both) > most * min(both)]
    if not broad:
        return ()
    count, largest = sum(count for count, _ in broad), max(aspect for _, aspect in broad)
    stones_are = "1 stone is" if count == 1 else f"{count} stones are"
    return (
        f"{stones_are} simulated with D/B {SIMULATED_D_OVER_B[-1]:g}, the largest; D/B in the survey: up to "
        f"{largest:.3g}",
    )


class StoneOutcomeProbabilities:
    """Probabilities of outcomes of stones under candidate motions scaled to several peak velocities.

    Simulated outcomes are cached in files.

    Parameters
    ----------
    candidate_motions, stone_kinds : sequence of CandidateMotion, sequence of StoneHeightAndSideRatios
        Motions and kinds of stones; raise an `ArgumentError` if there is none of either.
    population_for_unknown_sizes : StonePopulation, optional
        Distribution of unknown heights and B/H.
    outcome_cache_folder : Path, optional
        Cache folder; default: in the cache of the user.
    thread_count : int
        Number of threads.
    report_count_of_finished_and_all_motions : callable, optional
        Called with the number of finished motions and of all motions.
    """

    def __init__(
        self,
        candidate_motions: Sequence[CandidateMotion],
        stone_kinds: Sequence[StoneHeightAndSideRatios],
        population_for_unknown_sizes: StonePopulation | None = None,
        *,
        outcome_cache_folder: Path | None = None,
        thread_count: int = 1,
        report_count_of_finished_and_all_motions: Callable[[int, int], None] | None = None,
    ) -> None:
        if not candidate_motions or not stone_kinds:
            raise ArgumentError(
                f"{len(candidate_motions)} motions, {len(stone_kinds)} kinds of stones; at least one of each is needed"
            )
        self.motions = tuple(candidate_motions)
        outcome_cache_folder = outcome_cache_folder or stone_outcome_cache_folder()
        self._size_weights_by_dimensions = simulated_size_weights_by_stone_kind(
            stone_kinds, population_for_unknown_sizes
        )
        needed = masks_of_sizes_to_simulate_by_d_over_b(self._size_weights_by_dimensions)
        self._outcomes_by_d_over_b: dict[float, list[dict[str, NDArray[np.int8]]]] = {aspect: [] for aspect in needed}
        for done, one in enumerate(candidate_motions):
            if report_count_of_finished_and_all_motions:
                report_count_of_finished_and_all_motions(done, len(candidate_motions))
            for aspect, nodes in needed.items():
                self._outcomes_by_d_over_b[aspect].append(
                    outcomes_of_needed_sizes(one, aspect, nodes, outcome_cache_folder, thread_count)
                )
        if report_count_of_finished_and_all_motions:
            report_count_of_finished_and_all_motions(len(candidate_motions), len(candidate_motions))
        self.outcome_probability_table = lru_cache(64)(self._outcome_probability_table)

    def _outcome_probability_table(self, stone_kind: StoneHeightAndSideRatios) -> NDArray[np.float32]:
        """Return the probabilities of each fall direction, relative to the motion's north, and of standing.

        The shape is (motions, peak-velocity levels, orientations of the stone, direction bins + 1); the last index is
        standing.
        """
        return np.stack(
            [
                _outcome_probabilities_by_velocity_scale_of_motion(one, self._size_weights_by_dimensions[stone_kind])
                for one in self._outcomes_by_d_over_b[stone_kind.d_over_b]
            ]
        )


def simulated_size_weights_by_stone_kind(
    stone_kinds: Sequence[StoneHeightAndSideRatios], population_for_unknown_sizes: StonePopulation | None = None
) -> dict[StoneHeightAndSideRatios, FloatArray]:
    """Return, for each kind of stone, the share of stones that each simulated height and B/H represents.

    The arrays of shares have the shape (heights, B/H); see `StoneHeightAndSideRatios.size_grid_weights`.
    """
    return {
        kind: kind.size_grid_weights(population_for_unknown_sizes or StonePopulation())
        for kind in dict.fromkeys(stone_kinds)
    }


def masks_of_sizes_to_simulate_by_d_over_b(
    size_grid_weights_by_stone_kind: dict[StoneHeightAndSideRatios, FloatArray],
) -> dict[float, NDArray[np.bool_]]:
    """Return, by D/B, a mask of the pairs of height and B/H that must be simulated, shape (heights, B/H).

    A pair must be simulated if its weight for some kind of stone with this D/B is positive.
    """
    needed: dict[float, NDArray[np.bool_]] = {}
    for kind, weight in size_grid_weights_by_stone_kind.items():
        needed[kind.d_over_b] = needed.get(kind.d_over_b, np.zeros(weight.shape, np.bool_)) | (weight > 0)
    return needed


def count_cases_to_simulate_and_estimate_time_s(
    candidate_motions: Sequence[CandidateMotion],
    stone_kinds: Sequence[StoneHeightAndSideRatios],
    outcome_cache_folder: Path | None = None,
    *,
    counts_cases_with_stored_outcomes: bool = False,
) -> tuple[int, float]:
    """Return the number of cases that `StoneOutcomeProbabilities` has to simulate, and the estimated time, s.

    Parameters
    ----------
    candidate_motions, stone_kinds : sequence of CandidateMotion, sequence of StoneHeightAndSideRatios
        Motions, and heights and shapes of the stones.
    outcome_cache_folder : Path, optional
        Cache folder; default: in the cache of the user.
    counts_cases_with_stored_outcomes : bool
        Count also the cases whose outcomes are shipped with the package or in the cache folder.

    Returns
    -------
    cases : int
        Cases of all motions.
    processor_s : float
        Processor time, s; of the order of magnitude.
    """
    cases, seconds = 0, 0.0
    for aspect, nodes in masks_of_sizes_to_simulate_by_d_over_b(
        simulated_size_weights_by_stone_kind(stone_kinds)
    ).items():
        names = {f"{h}-{b}" for h, b in np.argwhere(nodes).tolist()}
        each = (
            len(SIMULATED_FRICTIONS)
            * SIMULATED_PGV_M_S.size
            * StoneHeightAndSideRatios(d_over_b=aspect).orientations_to_simulate_deg.size
        )
        for one in candidate_motions:
            known = (
                set()
                if counts_cases_with_stored_outcomes
                else size_keys_with_stored_outcomes(one, aspect, outcome_cache_folder or stone_outcome_cache_folder())
            )
            count = each * len(names - known)
            cases += count
            seconds += (
                CASE_PROCESSOR_SECONDS_PER_MOTION_SECOND * count * one.motion.north.size * one.motion.sampling_interval
            )
    return cases, seconds


def _outcome_probabilities_by_velocity_scale_of_motion(
    outcome_arrays_by_size_key: dict[str, NDArray[np.int8]], size_grid_weights: FloatArray
) -> NDArray[np.float32]:
    """Return the probabilities of standing and of each fall direction, for one kind of stone under one motion.

    The shape is (peak velocities to which the motion is scaled, orientations of the stone, direction bins + 1); the
    last index is standing. `outcome_arrays_by_size_key` has the outcomes of each simulated size (see
    `outcomes_of_needed_sizes`). The outcomes are averaged over frictions, over sizes with the weights
    `size_grid_weights`, and over neighbouring peak velocities, since the peak velocity differs within a site.
    """
    nodes = np.argwhere(size_grid_weights > 0).tolist()
    outcome = np.stack([outcome_arrays_by_size_key[f"{h}-{b}"] for h, b in nodes])
    _, frictions, levels, orientations = outcome.shape
    place = np.arange(levels * orientations).reshape(levels, orientations) * (UNKNOWN_OUTCOME_INDEX + 1) + outcome
    mass = np.broadcast_to(size_grid_weights[size_grid_weights > 0][:, None, None, None] / frictions, outcome.shape)
    counts = np.bincount(place.ravel(), mass.ravel(), levels * orientations * (UNKNOWN_OUTCOME_INDEX + 1)).reshape(
        levels, -1
    )
    near = np.exp(
        -0.5 * (np.log(SIMULATED_PGV_M_S[:, None] / SIMULATED_PGV_M_S) / LN_PGV_STANDARD_DEVIATION_WITHIN_SITE) ** 2
    )
    shares = (near / near.sum(axis=1, keepdims=True) @ counts).reshape(levels, orientations, UNKNOWN_OUTCOME_INDEX + 1)[
        ..., :UNKNOWN_OUTCOME_INDEX
    ]
    # Without known outcomes the probabilities are uninformative.
    shares += 1e-6 * outcome_probabilities_if_nothing_is_known()
    shares /= shares.sum(axis=-1, keepdims=True)
    shares[..., :DIRECTION_BIN_COUNT] = (
        shares[..., :DIRECTION_BIN_COUNT] @ simulated_to_observed_direction_probabilities()
    )
    return shares.astype(np.float32)


def outcome_probabilities_if_nothing_is_known() -> FloatArray:
    """Return outcome probabilities if nothing is known: ½ for standing, the rest equal for all fall directions.

    The shape is (direction bins + 1,); standing is last.
    """
    return np.append(np.full(DIRECTION_BIN_COUNT, 0.5 / DIRECTION_BIN_COUNT), 0.5)


@cache
def simulated_to_observed_direction_probabilities() -> FloatArray:
    """Return the probabilities of each observed fall direction (columns), given the simulated direction (rows).

    Rows and columns are direction bins: equal sectors of azimuth.
    """
    angle = np.radians(DIRECTION_BIN_WIDTH_DEG * np.arange(DIRECTION_BIN_COUNT))
    density = scipy.stats.vonmises.pdf(angle, CONCENTRATION)
    row = (
        1 - UNIFORM_FALL_DIRECTION_SHARE
    ) * density / density.sum() + UNIFORM_FALL_DIRECTION_SHARE / DIRECTION_BIN_COUNT
    return np.asarray(
        row[(np.arange(DIRECTION_BIN_COUNT) - np.arange(DIRECTION_BIN_COUNT)[:, None]) % DIRECTION_BIN_COUNT]
    )
