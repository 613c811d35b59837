"""Estimation of the motion from surveys: with a library of known outcomes, and with simulated stones."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.errors import ArgumentError, ResultError
from overturning.findings.inferred_motion import inferred_motion_findings
from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.records.store import write_record_to_motion_file
from overturning.report.drawings import write_ground_motion_posterior_figure
from overturning.settings import StonePopulation
from overturning.surveys import stone_outcomes
from overturning.surveys.inversion import SurveyInversion, outcome_indices_matching_observation
from overturning.surveys.library import (
    CandidateMotion,
    candidate_motions,
    candidate_motions_from_shipped_records,
    read_records_with_paths_as_duplicate_ids,
)
from overturning.surveys.posterior import MOTION_ROTATION_COUNT, read_inversion_result, write_inversion_result
from overturning.surveys.responses import (
    CASE_PROCESSOR_SECONDS_PER_MOTION_SECOND,
    StoneHeightAndSideRatios,
    StoneOutcomeProbabilities,
    count_cases_to_simulate_and_estimate_time_s,
    dimensions_of_survey_stones,
)
from overturning.surveys.stone_outcomes import (
    DIRECTION_BIN_COUNT,
    SIMULATED_B_OVER_H,
    SIMULATED_FRICTIONS,
    SIMULATED_HEIGHTS_M,
    SIMULATED_PGV_M_S,
    STANDING_OUTCOME_INDEX,
)
from overturning.surveys.stones import Stone
from tests.study.small_study import sine_cycle_record

ROUND_COLUMN_HEIGHTS_AND_B_OVER_H = ((0.9, 0.2), (1.2, 0.25), (1.6, 0.3))
"""Heights, m, and B/H of the columns of a ruin."""


def elliptic_candidate_motion(period: float, event: str = "", east_over_north: float = 0.0) -> CandidateMotion:
    """Return a motion: a sine of 2 m/s² to the north, and `east_over_north` times it to the east.

    The sine to the east begins a quarter period later.
    """
    time = np.arange(0, 1.25 * period + 0.05, 0.01)
    north = np.where(time <= period, 2.0 * np.sin(2 * np.pi * time / period), 0.0)
    lag = time - period / 4
    across = np.where((lag >= 0) & (lag <= period), 2.0 * east_over_north * np.sin(2 * np.pi * lag / period), 0.0)
    return CandidateMotion.from_motion(f"{period:g} s", event, Motion(north, across, sampling_interval=0.01))


def outcomes_by_pgv_rule(
    candidate_motion: CandidateMotion, aspect: float, size_grid_indices: list[tuple[int, int]], threads: int
) -> np.ndarray:
    """Return outcomes in place of the kernel: stones fall where PGV exceeds the limit 3 m/s · B/H · √(H/m).

    Stones fall to the north under the motion named 0.5 s, and to the south under any other.
    """
    height, shape = (
        grid[np.array(size_grid_indices)[:, i]] for i, grid in enumerate((SIMULATED_HEIGHTS_M, SIMULATED_B_OVER_H))
    )
    falls = 3 * (shape * np.sqrt(height))[:, None] < SIMULATED_PGV_M_S
    way = np.where(falls, 0 if candidate_motion.name == "0.5 s" else DIRECTION_BIN_COUNT // 2, STANDING_OUTCOME_INDEX)
    size = (
        len(size_grid_indices),
        len(SIMULATED_FRICTIONS),
        SIMULATED_PGV_M_S.size,
        StoneHeightAndSideRatios(d_over_b=aspect).orientations_to_simulate_deg.size,
    )
    return np.broadcast_to(way[:, None, :, None], size).astype(np.int8)


@pytest.fixture
def inversion_with_known_outcomes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SurveyInversion:
    """Return an inversion for round columns with two candidate motions; `outcomes_by_pgv_rule` replaces the kernel."""
    monkeypatch.setattr(stone_outcomes, "simulate_outcomes_of_sizes", outcomes_by_pgv_rule)
    kinds = [StoneHeightAndSideRatios(*size, 0.0) for size in ROUND_COLUMN_HEIGHTS_AND_B_OVER_H]
    return SurveyInversion(
        StoneOutcomeProbabilities(
            [elliptic_candidate_motion(0.5), elliptic_candidate_motion(0.8)], kinds, outcome_cache_folder=tmp_path
        )
    )


def fallen_or_standing_round_column(size: tuple[float, float], azimuth: float = math.nan, count: int = 1) -> Stone:
    """Return a round column of a size (height, m, and B/H) that fell to an azimuth, or stood if it is NaN.

    The azimuth is in degrees.
    """
    height, shape = size
    return Stone(math.isfinite(azimuth), azimuth, False, count, b_over_h=shape, height_m=height, has_round_plan=True)


def test_motions_with_equal_ids_have_distinct_names_in_the_results(tmp_path: Path) -> None:
    """Regression: for a record on rock and on soil the figure had one bar, and the table two lines with one name."""
    paths = [tmp_path / name for name in ("a.nc", "soft/a.nc", "b.nc")]
    for path, peak in zip(paths, (3.0, 5.0, 4.0), strict=True):
        write_record_to_motion_file(sine_cycle_record(path.stem, peak), path)
    assert [
        one.name for one in candidate_motions(read_records_with_paths_as_duplicate_ids(paths), only_user_records=True)
    ] == [
        *map(str, paths[:2]),
        "b",
    ]


def test_outcome_probabilities_of_a_stone_add_up_to_1(inversion_with_known_outcomes: SurveyInversion) -> None:
    chances = inversion_with_known_outcomes.outcome_probabilities(
        fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0])
    )
    assert chances.shape == (2, SIMULATED_PGV_M_S.size, MOTION_ROTATION_COUNT, DIRECTION_BIN_COUNT + 1)
    assert chances.sum(axis=-1) == pytest.approx(1, abs=1e-5)


def test_without_stones_the_posterior_is_the_prior_and_pgv_is_unbounded(
    inversion_with_known_outcomes: SurveyInversion,
) -> None:
    one = inversion_with_known_outcomes.compute_posterior(
        inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey([])
    )
    assert one.posterior_probability == pytest.approx(one.prior_probability)
    # Even over the levels: the middle 90 % of the logarithm, each level a cell about it.
    half = np.log(SIMULATED_PGV_M_S[1] / SIMULATED_PGV_M_S[0]) / 2
    width = np.log(SIMULATED_PGV_M_S[-1] / SIMULATED_PGV_M_S[0]) + 2 * half
    expected = SIMULATED_PGV_M_S[0] * np.exp([0.05 * width - half, 0.95 * width - half])
    assert one.credible_interval(one.pgv_by_motion_and_level, uses_prior_instead_of_posterior=True) == pytest.approx(
        tuple(expected)
    )
    # Each level holds a thirteenth, more than a tail.
    assert one.credible_interval(one.pgv_by_motion_and_level) == (0.0, math.inf)


def test_fallen_and_standing_stones_bound_the_peak_velocity(inversion_with_known_outcomes: SurveyInversion) -> None:
    """Under the stub that replaces the kernel, the three columns fall from a PGV of 0.57, 0.82 and 1.14 m/s on."""
    stones = [
        fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], 0, 8),
        fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[1], 0, 8),
        fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], count=8),
    ]
    one = inversion_with_known_outcomes.compute_posterior(
        inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey(stones)
    )
    low, high = one.credible_interval(one.pgv_by_motion_and_level)
    assert 0.5 < low < 1.14
    assert 0.82 < high < 1.6
    # Directions that scatter tell an axis the less the smaller their power.
    logs = inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey(
        [fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], azimuth) for azimuth in (0, 20, 350, 40)]
    )
    assert (
        inversion_with_known_outcomes.compute_posterior(
            logs, direction_likelihood_exponent=1.0
        ).credible_axis_arc_middle_and_width_deg()[1]
        < inversion_with_known_outcomes.compute_posterior(
            logs, direction_likelihood_exponent=0.1
        ).credible_axis_arc_middle_and_width_deg()[1]
    )


def test_rotating_the_survey_rotates_the_axis_of_the_motion(inversion_with_known_outcomes: SurveyInversion) -> None:
    def axis_arc_middle_and_width_of_rotated_survey(turn: float) -> tuple[float, float]:
        stones = [
            fallen_or_standing_round_column(size, (way + turn) % 360, 4)
            for size, way in zip(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H, (0, 10, 180), strict=True)
        ]
        return inversion_with_known_outcomes.compute_posterior(
            inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey(stones)
        ).credible_axis_arc_middle_and_width_deg()

    first, turned = axis_arc_middle_and_width_of_rotated_survey(0), axis_arc_middle_and_width_of_rotated_survey(70)
    assert abs((first[0] + 90) % 180 - 90) <= 10
    assert turned[1] == first[1]
    assert (turned[0] - first[0]) % 180 == pytest.approx(70)


def test_probability_of_an_octant_is_the_sum_of_its_direction_bins(
    inversion_with_known_outcomes: SurveyInversion,
) -> None:
    octant = Stone(True, 45.0, True, b_over_h=0.2, height_m=0.9, has_round_plan=True)
    assert (outcome_indices_matching_observation(octant) * 5).tolist() == [25, 30, 35, 40, 45, 50, 55, 60, 65]
    ways = [
        inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey(
            [fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], azimuth)]
        ).sum(axis=0)
        for azimuth in range(25, 70, 5)
    ]
    assert inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey([octant]).sum(
        axis=0
    ) == pytest.approx(np.log(np.exp(ways).sum(axis=0)), abs=1e-5)


def test_probability_of_an_unknown_direction_is_the_sum_of_all_bins(
    inversion_with_known_outcomes: SurveyInversion,
) -> None:
    lost = Stone(True, math.nan, False, b_over_h=0.2, height_m=0.9, has_round_plan=True)
    ways = [
        inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey(
            [fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], azimuth)]
        ).sum(axis=0)
        for azimuth in range(0, 360, 5)
    ]
    fell = inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey([lost])
    assert fell[0] == pytest.approx(np.log(np.exp(ways).sum(axis=0)), abs=1e-5)
    assert not fell[1].any()
    answers = [
        inversion_with_known_outcomes.invert_survey("x", 6 * [stone]) for stone in (lost, replace(lost, fell=False))
    ]
    assert [(one.fell, one.stood) for one in answers] == [(6, 0), (0, 6)]
    low, stood = (one.posterior.credible_interval(one.posterior.pgv_by_motion_and_level) for one in answers)
    assert low[0] > 0.2 > stood[0]
    np.testing.assert_allclose(answers[0].posterior.posterior_probabilities_of_velocity_axis().sum(), 1)
    assert answers[0].goodness_of_fit_p_value > 0.1


def test_falls_alone_give_the_peak_velocity_no_upper_bound(inversion_with_known_outcomes: SurveyInversion) -> None:
    asked = inversion_with_known_outcomes.invert_survey(
        "ruin.csv", [fallen_or_standing_round_column(size, 0, 6) for size in ROUND_COLUMN_HEIGHTS_AND_B_OVER_H]
    )
    low, high = asked.posterior.credible_interval(asked.posterior.pgv_by_motion_and_level)
    assert low > 0.6
    assert high == math.inf
    assert inferred_motion_findings(asked).has_no_upper_strength_bound
    stood = inversion_with_known_outcomes.invert_survey(
        "ruin.csv", [fallen_or_standing_round_column(size, count=6) for size in ROUND_COLUMN_HEIGHTS_AND_B_OVER_H]
    )
    assert stood.posterior.credible_interval(stood.posterior.pgv_by_motion_and_level)[0] == 0.0
    assert inferred_motion_findings(stood).has_no_lower_strength_bound


def test_survey_with_only_falls_has_an_uninformative_axis_arc(inversion_with_known_outcomes: SurveyInversion) -> None:
    """A survey with only falls has an axis arc of 162°, which contains a random axis with 162/180 = 90 %.

    In simulated surveys, arcs from falls alone contained the true axis no more often than random arcs.
    """
    fell = [
        fallen_or_standing_round_column(size, azimuth, 4)
        for size in ROUND_COLUMN_HEIGHTS_AND_B_OVER_H
        for azimuth in (350, 0, 10)
    ]
    every, some = (
        inversion_with_known_outcomes.invert_survey("ruin.csv", stones)
        for stones in (fell, [*fell, fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2])])
    )
    assert some.credible_axis_arc_middle_and_width_deg == some.posterior.credible_axis_arc_middle_and_width_deg()
    assert (
        some.credible_axis_arc_middle_and_width_deg[1]
        < 120
        > every.posterior.credible_axis_arc_middle_and_width_deg()[1]
    )
    assert (
        every.credible_axis_arc_middle_and_width_deg[0] == every.posterior.credible_axis_arc_middle_and_width_deg()[0]
    )
    assert every.credible_axis_arc_middle_and_width_deg[1] == pytest.approx(162)
    assert inferred_motion_findings(every).everything_fell
    assert not inferred_motion_findings(some).everything_fell
    truth = np.random.default_rng(3).uniform(0, 180, 20_000)
    held = (
        np.abs((truth - every.credible_axis_arc_middle_and_width_deg[0] + 90) % 180 - 90)
        <= every.credible_axis_arc_middle_and_width_deg[1] / 2
    )
    assert held.mean() == pytest.approx(0.9, abs=0.01)
    nothing = inversion_with_known_outcomes.invert_survey(
        "none.csv", [fallen_or_standing_round_column(size, count=6) for size in ROUND_COLUMN_HEIGHTS_AND_B_OVER_H]
    )
    assert not nothing.everything_fell


def test_a_survey_that_no_motion_explains_does_not_fit(inversion_with_known_outcomes: SurveyInversion) -> None:
    """A survey of fallen broad low columns and standing slender tall ones does not fit any motion.

    No motion causes these outcomes under the stub that replaces the kernel.
    """
    odd = inversion_with_known_outcomes.invert_survey(
        "odd.csv",
        [
            fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], 0, 12),
            fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], count=12),
        ],
    )
    assert odd.goodness_of_fit_p_value < 0.01
    assert not inferred_motion_findings(odd).any_motion_fits
    even = inversion_with_known_outcomes.invert_survey(
        "even.csv",
        [
            fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], 0, 12),
            fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], count=12),
        ],
    )
    assert even.goodness_of_fit_p_value > 0.1
    assert inferred_motion_findings(even).any_motion_fits


def test_missing_sizes_are_counted_and_weighted_by_the_population(
    inversion_with_known_outcomes: SurveyInversion,
) -> None:
    tall, shaped = (
        Stone(True, 60, False, 4, b_over_h=0.2, has_round_plan=True),
        Stone(True, 60, False, 2, height_m=0.75),
    )
    answer = inversion_with_known_outcomes.invert_survey(
        "x.csv", [fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], 0)]
    )
    assert not inferred_motion_findings(
        answer, [fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0])]
    ).has_assumed_sizes
    found = inferred_motion_findings(
        answer, [fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0]), tall, shaped]
    )
    assert (found.stones_without_height, found.stones_without_b_over_h) == (4, 2)
    heights, shapes = (
        StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(one).size_grid_weights(StonePopulation())
        for one in (tall, shaped)
    )
    assert 0.6 < np.exp(np.log(SIMULATED_HEIGHTS_M) @ heights.sum(axis=1)) < 0.9
    assert 0.3 < 0.75 * np.exp(np.log(SIMULATED_B_OVER_H) @ shapes.sum(axis=0)) < 0.4


def test_a_survey_with_zero_background_has_a_posterior(inversion_with_known_outcomes: SurveyInversion) -> None:
    """A survey with background 0 has a posterior, since stones of equal description may behave differently.

    Even with the setting `surveys: [{background: 0}]` no outcome is impossible.
    """
    stones = [
        fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], 0, 8),
        fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], 180, 1),
        fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], count=8),
    ]
    logs = replace(
        inversion_with_known_outcomes, random_outcome_stone_share=0.0
    ).fall_and_direction_log_likelihoods_of_survey(stones)
    assert np.isfinite(logs).all()
    one, other = (
        inversion_with_known_outcomes.compute_posterior(each)
        for each in (logs, inversion_with_known_outcomes.fall_and_direction_log_likelihoods_of_survey(stones))
    )
    assert one.credible_interval(one.pgv_by_motion_and_level) == pytest.approx(
        other.credible_interval(other.pgv_by_motion_and_level), rel=0.3
    )


def test_standing_stones_bound_the_pgv_less_if_many_are_fixed(inversion_with_known_outcomes: SurveyInversion) -> None:
    stones = [fallen_or_standing_round_column(size, count=4) for size in ROUND_COLUMN_HEIGHTS_AND_B_OVER_H]
    loose = SurveyInversion(
        inversion_with_known_outcomes.stone_outcome_probabilities, share_of_stones_fixed_to_base=0.8
    )
    bound, less = (
        one.compute_posterior(one.fall_and_direction_log_likelihoods_of_survey(stones))
        for one in (inversion_with_known_outcomes, loose)
    )
    assert less.posterior_probability[:, 6:].sum() > 2 * bound.posterior_probability[:, 6:].sum()


def test_stone_dimensions_to_simulate_have_the_smaller_of_both_b_over_h() -> None:
    stone = Stone(True, 0.0, False, b_over_h=0.5, b_over_h_side=0.25, face_azimuth_deg=30, height_m=0.8)
    assert StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(stone) == StoneHeightAndSideRatios(0.8, 0.25, 2.0)
    assert stone.slender_plane_azimuth_deg == 120
    square = Stone(True, 0.0, False, b_over_h=0.25, face_azimuth_deg=30)
    assert (StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(square), square.slender_plane_azimuth_deg) == (
        StoneHeightAndSideRatios(None, 0.25, 1.0),
        30,
    )


def test_a_slab_falls_over_its_narrow_side_only(tmp_path: Path) -> None:
    """Of two slabs of B/H 0.15 by 0.6 under a pulse along north, the one that faces north falls, the other stands.

    The other faces east. The peak of 0.4 g lies between the accelerations that lift the two edges, 0.15 g and 0.6 g.
    """
    one = elliptic_candidate_motion(1.0)
    slab = {"b_over_h": 0.15, "b_over_h_side": 0.6, "height_m": 0.45}
    north, east = (Stone(False, math.nan, False, face_azimuth_deg=face, **slab) for face in (0.0, 90.0))
    asked = SurveyInversion(
        StoneOutcomeProbabilities(
            [one], [StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(north)], outcome_cache_folder=tmp_path
        )
    )
    level = int(np.argmin(np.abs(SIMULATED_PGV_M_S * one.pga_m_s2 / one.pgv_m_s - 0.4 * 9.80665)))
    stands = [asked.outcome_probabilities(stone)[0, level, 0, STANDING_OUTCOME_INDEX] for stone in (north, east)]
    assert stands[0] < 0.3
    assert stands[1] > 0.8
    # Turned by a quarter with its motion, each does the same.
    assert asked.outcome_probabilities(east)[
        0, level, MOTION_ROTATION_COUNT // 4, STANDING_OUTCOME_INDEX
    ] == pytest.approx(stands[0], abs=1e-6)


@pytest.mark.long
def test_pgv_bounds_contain_a_true_motion_missing_from_the_library(tmp_path: Path) -> None:
    """Bounds of the PGV from inversion contain the true PGV if the candidates do not include the true motion.

    Columns are simulated under the record of Parachute Test Site at about 87 cm/s, and inverted with records of other
    earthquakes only.

    An earlier inversion, with a plain likelihood and synthetic pulses in planes, gave a 90 % interval of 152.3 to 152.8
    cm/s.
    """
    every = candidate_motions_from_shipped_records()
    truth = next(one for one in every if "Parachute" in one.name)
    names = ("Petrolia", "Sturno", "Array #6", "Erzincan", "Karakyr", "Corralitos", "Yermo", "TCU102")
    others = [one for one in every if any(name in one.name for name in names)]
    height, shape = np.full(24, 1.5), np.repeat([0.2, 0.35], 12)
    factors = np.linspace(0.6, 0.9, 24)
    result = simulate_cases("circle", truth.motion, Cases(0.0, height, shape, 0.7, factors))
    stones = [
        fallen_or_standing_round_column(
            (height[i], shape[i]), float(result.fall_azimuth[i]) if result.overturned[i] == 1 else math.nan
        )
        for i in range(24)
    ]
    asked = SurveyInversion(
        StoneOutcomeProbabilities(
            others,
            [StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(stone) for stone in stones],
            outcome_cache_folder=tmp_path,
            thread_count=2,
        )
    )
    low, high = (
        one := asked.compute_posterior(asked.fall_and_direction_log_likelihoods_of_survey(stones))
    ).credible_interval(one.pgv_by_motion_and_level)
    assert low < factors.mean() * truth.pgv_m_s < high
    assert high / low < 8  # before the survey 15


def test_simulated_outcomes_of_stones_are_cached_in_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[int] = []

    def count_and_fake_simulations(
        one: CandidateMotion, aspect: float, nodes: list[tuple[int, int]], threads: int
    ) -> np.ndarray:
        calls.append(len(nodes))
        return outcomes_by_pgv_rule(one, aspect, nodes, threads)

    monkeypatch.setattr(stone_outcomes, "simulate_outcomes_of_sizes", count_and_fake_simulations)
    one, kind = elliptic_candidate_motion(0.5), StoneHeightAndSideRatios(*ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], 0.0)
    first = StoneOutcomeProbabilities([one], [kind], outcome_cache_folder=tmp_path).outcome_probability_table(kind)
    assert np.array_equal(
        StoneOutcomeProbabilities([one], [kind], outcome_cache_folder=tmp_path).outcome_probability_table(kind), first
    )
    assert len(calls) == 1
    # Another size computes what is not there yet, another motion everything.
    StoneOutcomeProbabilities(
        [one],
        [kind, StoneHeightAndSideRatios(*ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], 0.0)],
        outcome_cache_folder=tmp_path,
    )
    StoneOutcomeProbabilities([elliptic_candidate_motion(0.8)], [kind], outcome_cache_folder=tmp_path)
    assert calls[1] > 0
    assert calls[2] == calls[0]
    for path in tmp_path.iterdir():
        path.write_bytes(path.read_bytes()[:100])
    assert np.array_equal(
        StoneOutcomeProbabilities([one], [kind], outcome_cache_folder=tmp_path).outcome_probability_table(kind), first
    )
    assert len(calls) == 4


def test_stone_sizes_outside_the_simulated_range_are_refused() -> None:
    for name, stone in (
        ("b_over_h 1.5", Stone(False, math.nan, False, b_over_h=1.5, line_number=7)),
        ("height_m 50", Stone(False, math.nan, False, height_m=50.0, line_number=7)),
    ):
        with pytest.raises(ArgumentError, match=f"line 7: {name}; stones of .* are computed: leave out the stone"):
            StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(
                stone
            )  # without its height it would be computed as one of 0.6 to 0.9 m


def test_error_about_stone_sizes_names_the_file_and_all_lines() -> None:
    sizes = ((24.0, 2), (1.0, 3), (20.0, 4))
    stones = [Stone(False, math.nan, False, height_m=height, line_number=line) for height, line in sizes]
    with pytest.raises(ArgumentError, match=r"(?s)ruin\.csv line 2: height_m 24; .*ruin\.csv line 4: height_m 20; "):
        dimensions_of_survey_stones(stones, "ruin.csv")


def test_the_predicted_case_count_is_that_of_simulated_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The predicted number of cases is that of the cases then simulated, without cached ones.

    The predicted computing time grows with the duration of the motions.
    """
    asked: list[int] = []

    def fake_standing_results_and_count_cases(
        shape: str, motion: Motion, cases: Cases, numerics: NumericalOptions
    ) -> SimpleNamespace:
        asked.append(np.size(cases.height))
        return SimpleNamespace(overturned=np.zeros(asked[-1]), fall_azimuth=np.full(asked[-1], np.nan))

    monkeypatch.setattr(stone_outcomes, "simulate_cases", fake_standing_results_and_count_cases)
    motions = [elliptic_candidate_motion(0.5), elliptic_candidate_motion(0.8)]
    kinds = [
        StoneHeightAndSideRatios(*ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], 0.0),
        StoneHeightAndSideRatios(*ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[1], 2.0),
    ]
    cases, seconds = count_cases_to_simulate_and_estimate_time_s(motions, kinds, tmp_path)
    StoneOutcomeProbabilities(motions, kinds, outcome_cache_folder=tmp_path)
    assert cases == sum(asked)
    lasts = [one.motion.north.size * one.motion.sampling_interval for one in motions]
    assert seconds == pytest.approx(CASE_PROCESSOR_SECONDS_PER_MOTION_SECOND * cases / 2 * sum(lasts))
    assert count_cases_to_simulate_and_estimate_time_s(motions, kinds, tmp_path) == (0, 0.0)
    more, _ = count_cases_to_simulate_and_estimate_time_s(
        motions, [*kinds, StoneHeightAndSideRatios(*ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], 0.0)], tmp_path
    )
    asked.clear()
    StoneOutcomeProbabilities(
        motions,
        [*kinds, StoneHeightAndSideRatios(*ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], 0.0)],
        outcome_cache_folder=tmp_path,
    )
    assert 0 < more == sum(asked)


def test_each_combination_of_size_friction_pgv_and_face_is_simulated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The kernel gets the size, friction, peak velocity and face azimuth of each combination.

    The stand-in of the kernel returns a direction that names height, B/H, friction, level and face of its case.
    """

    def arbitrary_direction_bin_encoding_case(height, shape, friction, amplitude, azimuth):  # one of 72 bins
        parts = [
            np.searchsorted(grid, value * 1.001) - 1
            for grid, value in ((SIMULATED_HEIGHTS_M, height), (SIMULATED_B_OVER_H, shape))
        ]
        level = np.searchsorted(SIMULATED_PGV_M_S, amplitude * one.pgv_m_s * 1.001) - 1
        return (7 * parts[0] + 11 * parts[1] + 13 * level + 5 * np.round(azimuth / 15) + 17 * (friction > 0.5)) % 72

    def fake_falls_with_azimuths_from_case_parameters(
        shape: str, motion: Motion, cases: Cases, numerics: NumericalOptions
    ) -> SimpleNamespace:
        bins = arbitrary_direction_bin_encoding_case(
            cases.height, cases.b_over_h, cases.friction, cases.amplitude, cases.azimuth_deg
        )
        return SimpleNamespace(overturned=np.ones(bins.size), fall_azimuth=5.0 * bins)

    one = elliptic_candidate_motion(0.5)
    monkeypatch.setattr(stone_outcomes, "simulate_cases", fake_falls_with_azimuths_from_case_parameters)
    nodes = [(2, 5), (2, 6), (3, 5)]
    found = stone_outcomes.simulate_outcomes_of_sizes(one, 2.0, nodes, 1)
    assert found.shape == (3, len(SIMULATED_FRICTIONS), SIMULATED_PGV_M_S.size, 12)
    for (h, b), f, at, o in ((nodes[n], f, at, o) for n, f, at, o in np.argwhere(found >= 0)[::7].tolist()):
        expected = arbitrary_direction_bin_encoding_case(
            SIMULATED_HEIGHTS_M[h],
            SIMULATED_B_OVER_H[b],
            SIMULATED_FRICTIONS[f],
            SIMULATED_PGV_M_S[at] / one.pgv_m_s,
            15.0 * o,
        )
        assert found[nodes.index((h, b)), f, at, o] == expected
    assert stone_outcomes.simulate_outcomes_of_sizes(one, 0.0, nodes, 1).shape == (
        3,
        len(SIMULATED_FRICTIONS),
        SIMULATED_PGV_M_S.size,
        1,
    )


def test_motion_is_estimated_for_each_site_and_for_all_together(
    tmp_path: Path, inversion_with_known_outcomes: SurveyInversion
) -> None:
    """With a flat prior the posterior of independent sites is proportional to the product of their posteriors."""
    at_a = [
        replace(fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], 0, 4), site="A"),
        replace(fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], count=3), site="A"),
    ]
    at_b = [
        replace(fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[1], 10, 2), site="B"),
        replace(fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[2], count=2), site="B"),
    ]
    found = inversion_with_known_outcomes.invert_survey("ruin.csv", [*at_a, at_b[0], at_b[1]])
    alone = [inversion_with_known_outcomes.invert_survey("ruin.csv", part) for part in (at_a, at_b)]
    assert [(one.survey_or_site_name, one.fell, one.stood) for one in found.site_results] == [("A", 4, 3), ("B", 2, 2)]
    for site, one in zip(found.site_results, alone, strict=True):
        assert site.posterior.posterior_probability == pytest.approx(one.posterior.posterior_probability)
        assert (site.goodness_of_fit_p_value, one.site_results) == (one.goodness_of_fit_p_value, ())
    product = alone[0].posterior.posterior_probability * alone[1].posterior.posterior_probability
    assert found.posterior.posterior_probability == pytest.approx(product / product.sum())
    write_inversion_result(found, tmp_path / "motion.nc")
    back = read_inversion_result(tmp_path / "motion.nc")
    assert inferred_motion_findings(back) == inferred_motion_findings(found)
    assert [one.site for one in inferred_motion_findings(back).sites] == ["A", "B"]


def test_library_has_61_motions_of_20_earthquakes(candidate_motions_of_package: tuple[CandidateMotion, ...]) -> None:
    every = candidate_motions_of_package
    assert len(every) == 61
    assert len({one.earthquake_name for one in every}) == 20
    assert sum(one.earthquake_name == "Imperial Valley" for one in every) == 6
    rinaldi = next(one for one in every if "Rinaldi" in one.name)
    # PGV of the fault-normal component by the PEER flatfile: 167 cm/s.
    assert rinaldi.pgv_m_s == pytest.approx(1.67, abs=0.02)
    with pytest.raises(ArgumentError, match="--alone"):
        candidate_motions(only_user_records=True)


def test_posterior_is_read_back_from_file(tmp_path: Path, inversion_with_known_outcomes: SurveyInversion) -> None:
    asked = SurveyInversion(
        inversion_with_known_outcomes.stone_outcome_probabilities, share_of_stones_fixed_to_base=0.1
    ).invert_survey(
        "ruin.csv",
        [
            fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[0], 0),
            fallen_or_standing_round_column(ROUND_COLUMN_HEIGHTS_AND_B_OVER_H[1]),
        ],
    )
    write_inversion_result(asked, tmp_path / "motion.nc")
    back = read_inversion_result(tmp_path / "motion.nc")
    assert (back.fell, back.stood, back.assumed_fixed_stone_share, back.goodness_of_fit_p_value) == (
        1,
        1,
        0.1,
        asked.goodness_of_fit_p_value,
    )
    assert back.posterior.posterior_probability == pytest.approx(asked.posterior.posterior_probability)
    # One sine of amplitude A and period T along an axis: PGA A, PGV A T/π.
    assert back.posterior.pga_m_s2_at_pgv_1_m_s == pytest.approx(np.pi / np.array([0.5, 0.8]), rel=0.01)
    assert inferred_motion_findings(back) == inferred_motion_findings(asked)
    write_ground_motion_posterior_figure(back, tmp_path / "motion.svg")
    assert "axis of the largest velocity" in (tmp_path / "motion.svg").read_text(encoding="utf-8")
    with pytest.raises(ResultError, match="run the study again"):
        read_inversion_result(tmp_path / "nothing.nc")
