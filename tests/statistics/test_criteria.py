"""Published criteria compared with closed forms and the rocking block; their scores counted by hand."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.statistics.criteria import (
    MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO,
    SLENDERNESS_ONLY_RULE_NAME,
    OverturningCriteriaScores,
    WeightedFallPredictionCounts,
    score_overturning_criteria,
)
from overturning.statistics.criteria_limits import (
    OVERTURNING_CRITERIA,
    block_frequency_parameter,
    ishiyama_velocity_limit,
    kaneko_hayashi_median_fall_pga,
    kaneko_hayashi_transition_frequency,
    pulse_acceleration_to_overturn_after_impact,
    sine_pulse_pga_to_overturn_without_impact,
    west_acceleration_limit,
)
from overturning.units import STANDARD_GRAVITY


def test_west_and_ishiyama_limits_match_closed_forms() -> None:
    assert west_acceleration_limit([0.1, 0.4]) == pytest.approx([0.980665, 3.92266])
    height, slender = 1.0, 0.4
    alpha, radius = math.atan(slender), math.hypot(height, slender * height) / 2
    expected = 0.4 * math.sqrt(8 * 9.80665 * radius / 3 * (1 - math.cos(alpha)) / math.cos(alpha) ** 2)
    assert ishiyama_velocity_limit(height, slender) == pytest.approx(expected)
    # The rule of thumb for slender blocks.
    height_cm, width_cm = np.array([50.0, 100.0, 200.0]), np.array([5.0, 10.0, 20.0])
    cm_s = 100 * ishiyama_velocity_limit(height_cm / 100, width_cm / height_cm)
    assert cm_s == pytest.approx(10 * width_cm / np.sqrt(height_cm), rel=0.04)


@pytest.mark.parametrize("value", [0.0, -0.1, math.nan, math.inf])
def test_overturning_limits_refuse_sizes_that_are_not_positive(value: float) -> None:
    with pytest.raises(ArgumentError, match="positive"):
        west_acceleration_limit(value)
    with pytest.raises(ArgumentError, match="positive"):
        ishiyama_velocity_limit(value, 0.4)


@pytest.mark.parametrize("height", [0.3, 1.0, 2.0])
@pytest.mark.parametrize("slender", [0.1, 0.3, 0.6])
def test_two_branches_of_the_kaneko_hayashi_limit_meet(height: float, slender: float) -> None:
    border = 1 / (2 * math.pi * kaneko_hayashi_transition_frequency(height, slender))
    below, above = kaneko_hayashi_median_fall_pga(height, slender, border * np.array([1 + 1e-9, 1 - 1e-9]))
    assert below == pytest.approx(9.80665 * slender * (1 + slender))
    assert above == pytest.approx(below, rel=6e-4)  # 10 · 15.6 · 2π is 980.2, not 980.665
    # Far above the border it is a limit of PGV, 10 B/√H (1 + B/H)^2.5 in cm and cm/s.
    ratio, height_cm = border / np.array([2.0, 5.0]), 100 * height
    pgv = 100 * ratio * kaneko_hayashi_median_fall_pga(height, slender, ratio)
    assert pgv == pytest.approx(10 * slender * height_cm / math.sqrt(height_cm) * (1 + slender) ** 2.5)


def fall_sides_of_rocking_block_under_sine_cycle(
    amplitudes_over_west: Any, frequency_ratio: float, height: float, slender: float
) -> np.ndarray:
    """Return the fall sides (−1, 0 or 1) of a rocking block under one sine cycle of ω = ``frequency_ratio`` · p.

    p is the frequency parameter of the block. Amplitudes are multiples of West's acceleration, g B/H.
    """
    period = 2 * math.pi / (frequency_ratio * float(block_frequency_parameter(height, slender)))
    motion = Motion(np.sin(2 * math.pi * np.arange(801) / 800), np.zeros(801), sampling_interval=period / 800)
    return simulate_rigid_rocking(
        motion, Cases(0.0, height, slender, 1.0, amplitude=np.multiply(amplitudes_over_west, 9.80665 * slender))
    ).overturned


def overturning_threshold_per_wests_acceleration(
    criterion: Any, frequency_ratio: float, height: float, slender: float
) -> float:
    """Return the PGA limit of a criterion over West's acceleration, for a sine of ω = ratio · p (p: of the block)."""
    pgv_over_pga = 2 / (frequency_ratio * float(block_frequency_parameter(height, slender)))
    return float(criterion(height, slender, pgv_over_pga)) / (9.80665 * slender)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 3.0, 5.0])
def test_pulse_limit_without_impact_matches_the_simulated_rocking_block(ratio: float) -> None:
    # A base that accelerates towards +s first throws the block towards −s: the fall without impact.
    factor = overturning_threshold_per_wests_acceleration(sine_pulse_pga_to_overturn_without_impact, ratio, 1.0, 0.1)
    assert (
        fall_sides_of_rocking_block_under_sine_cycle([0.995 * factor, 1.015 * factor], ratio, 1.0, 0.1) == -1
    ).tolist() == [
        False,
        True,
    ]


@pytest.mark.parametrize("ratio", [1.0, 2.0, 3.0, 4.0])
def test_pulse_limit_after_one_impact_is_near_the_simulated_block(ratio: float) -> None:
    factor = overturning_threshold_per_wests_acceleration(pulse_acceleration_to_overturn_after_impact, ratio, 1.0, 0.1)
    factors = np.arange(1.01, 2.0, 0.01)
    first = factors[fall_sides_of_rocking_block_under_sine_cycle(factors, ratio, 1.0, 0.1) == 1].min()
    assert 0.98 <= factor / first <= 1.11


def test_no_criterion_predicts_a_fall_below_the_rocking_acceleration() -> None:
    ratio = np.geomspace(0.02, 0.5, 30)
    for criterion in OVERTURNING_CRITERIA:
        assert (
            criterion.pga_limit_from_height_b_over_h_pgv_over_pga(0.6, 0.3, ratio)
            >= west_acceleration_limit(0.3) * (1 - 1e-12)
        ).all()


def test_hit_rate_and_skill_match_hand_computation() -> None:
    found = WeightedFallPredictionCounts(2, 1, 1, 1)
    assert found.hit_rate == pytest.approx(2 / 3)
    assert found.peirce_skill_score == pytest.approx(2 / 3 - 1 / 2)


def test_wests_criterion_has_full_skill_for_falls_by_its_own_formula(make_cube_from_fall_rules) -> None:
    azimuth, slender = np.arange(0, 180, 20), np.array([0.1, 0.2, 0.3, 0.4])
    pga = STANDARD_GRAVITY * np.linspace(0.05, 0.45, azimuth.size)
    cube = make_cube_from_fall_rules(
        lambda at, _, ratio, *__: np.interp(at, azimuth, pga) >= STANDARD_GRAVITY * ratio, azimuth=azimuth,
        b_over_h=slender, friction=[1.0], events="abcdefgh",
    )  # fmt: skip
    peaks = {
        name: (("record", "azimuth"), np.tile(values, (8, 1))) for name, values in (("pga", pga), ("pgv", pga / 30))
    }
    found = score_overturning_criteria(cube, xr.Dataset(peaks, {"azimuth": azimuth}))
    assert found is not None
    west, *others, blind = found.rule_scores
    assert (west.name, blind.name) == ("West", SLENDERNESS_ONLY_RULE_NAME)
    for one in (
        west.peirce_skill_over_all_cases,
        west.weighted_mean_skill_over_block_sizes,
    ):  # 0.05^(1/8) of all earthquakes have the skill 1, the others at least -1
        assert (one.earthquake_count, one.mean, one.interval_low, one.interval_high) == pytest.approx(
            (8, 1.0, 2 * 0.05 ** (1 / 8) - 1, 1.0)
        )
    assert all(
        one.peirce_skill_over_all_cases.mean < 1 and one.weighted_mean_skill_over_block_sizes.mean < 1 for one in others
    )
    # Within a block only the motion differs, so a rule without motion has no skill.
    assert blind.weighted_mean_skill_over_block_sizes.mean == pytest.approx(0.0)
    assert found.criterion_counts_by_height_and_b_over_h[0.6, 0.1][0].actual_fall_share == pytest.approx(
        np.mean(pga >= 0.1 * STANDARD_GRAVITY)
    )
    assert len(found.criterion_counts_by_height_and_b_over_h) == 8


def test_best_criterion_has_largest_mean_skill_within_blocks(make_cube_from_fall_rules) -> None:
    # Falls by the pulse after one impact, of blocks that mostly fall (B/H 0.1) or mostly stand (0.4).
    azimuth, slender = np.arange(0, 180, 10), np.array([0.1, 0.2, 0.3, 0.4])
    pga = STANDARD_GRAVITY * np.linspace(0.15, 0.60, azimuth.size)
    ratio = np.where(np.arange(azimuth.size) % 3 == 0, 0.05, 0.15)
    limit = {
        each: np.array([float(pulse_acceleration_to_overturn_after_impact(0.6, each, one)) for one in ratio])
        for each in slender.tolist()
    }  # fmt: skip
    falls = {each: pga >= limit[each] for each in limit}
    table = np.stack([*falls.values()])
    cube = make_cube_from_fall_rules(
        lambda at, _, shape, *__: table[(10 * shape - 0.5).astype(int), (at // 10).astype(int)],
        azimuth=azimuth, height=[0.6], b_over_h=slender, friction=[1.0], events="abcdefgh",
    )  # fmt: skip
    peaks = {name: (("record", "azimuth"), np.tile(one, (8, 1))) for name, one in (("pga", pga), ("pgv", pga * ratio))}
    found = score_overturning_criteria(cube, xr.Dataset(peaks, {"azimuth": azimuth}))
    assert found is not None
    blind = found.rule_scores[-1]
    assert (
        found.score_of_best_criterion.name,
        found.score_of_best_criterion.weighted_mean_skill_over_block_sizes.mean,
    ) == (
        "pulse, one impact",
        pytest.approx(1.0),
    )
    # All earthquakes are alike: 0.05^(1/8) of all earthquakes have the lead, the others at least -2.
    for lead in found.best_minus_other_skill_by_criterion_name.values():
        assert lead.interval_low == pytest.approx(0.05 ** (1 / 8) * (lead.mean + 2) - 2)
    # By hand: hits minus false alarms for each block with falls and stands, averaged with weights f(1 − f).
    skills = {}
    for name, rule in ((one.name, one.pga_limit_from_height_b_over_h_pgv_over_pga) for one in OVERTURNING_CRITERIA):
        said = {each: pga >= np.array([float(rule(0.6, each, one)) for one in ratio]) for each in falls}
        mixed = [each for each in falls if 0 < falls[each].mean() < 1]
        skills[name] = np.average(
            [said[each][falls[each]].mean() - said[each][~falls[each]].mean() for each in mixed],
            weights=[falls[each].mean() * (1 - falls[each].mean()) for each in mixed],
        )
    assert {one.name: one.weighted_mean_skill_over_block_sizes.mean for one in found.rule_scores[:-1]} == pytest.approx(
        skills
    )
    assert [one.name for one in found.rule_scores[:-1]] == [one.name for one in OVERTURNING_CRITERIA]
    best = max(skills.values())
    assert {name: lead.mean for name, lead in found.best_minus_other_skill_by_criterion_name.items()} == pytest.approx(
        {name: best - skill for name, skill in skills.items() if skill < best}
    )
    # The rule without motion: the best of all bounds between the shapes.
    rows = [(each, fell) for each in falls for fell in falls[each]]
    best = max(
        np.mean([shape < bound for shape, fell in rows if fell])
        - np.mean([shape < bound for shape, fell in rows if not fell])
        for bound in (0.15, 0.25, 0.35)
    )  # fmt: skip
    assert (blind.name, blind.peirce_skill_over_all_cases.mean, blind.weighted_mean_skill_over_block_sizes.mean) == (
        SLENDERNESS_ONLY_RULE_NAME,
        pytest.approx(best),
        pytest.approx(0.0),
    )
    # ω = 2 PGA/PGV and p² = 3g/4R by hand.
    sizes = [0.5 * 0.6 * math.hypot(1, each) for each in falls]
    beyond = [
        2 / one / math.sqrt(0.75 * STANDARD_GRAVITY / size) > MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO
        for size in sizes
        for one in ratio
    ]
    assert 0 < found.case_share_above_valid_pulse_frequency_ratio < 1
    assert found.case_share_above_valid_pulse_frequency_ratio == pytest.approx(np.mean(beyond))


PGA_OVER_WEST_AND_PGV_OVER_PGA = np.array([(1.60, 0.15), (1.30, 0.07), (1.45, 0.12), (2.60, 0.05)])
"""PGA over g B/H and PGV/PGA, s, of motions for which of Kaneko–Hayashi and the pulse with one impact both predict that
a block of 0.6 m and B/H 0.3 falls, neither, the first alone, and the second alone. West and Ishiyama always predict a
fall, the pulse without impact never."""
NAME_OF_KANEKO_HAYASHI_CRITERION, NAME_OF_ONE_IMPACT_CRITERION = "Kaneko–Hayashi", "pulse, one impact"


def scores_of_criterion_with_random_success_rate(
    make_cube_from_fall_rules: Callable[..., xr.Dataset],
    generator: np.random.Generator,
    beta_parameters: tuple[float, float],
) -> OverturningCriteriaScores:
    """Return scores from 14 synthetic earthquakes in which the first of two criteria has a random success rate.

    Where the criteria differ, the first one is right with a probability drawn per earthquake from a beta distribution.
    """
    azimuth = np.arange(0, 180, 15)
    kind = generator.integers(4, size=(14, azimuth.size))
    right = generator.random(kind.shape) < generator.beta(*beta_parameters, size=(14, 1))
    falls = np.choose(kind, [np.full(kind.shape, True), np.full(kind.shape, False), right, ~right]).astype(float)
    rules = [lambda at, *_, own=own: own[(at // 15).astype(int)] for own in falls]
    cube = make_cube_from_fall_rules(
        rules, azimuth=azimuth, height=[0.6], b_over_h=[0.3], friction=[1.0], events="abcdefghijklmn"
    )  # fmt: skip
    pga = STANDARD_GRAVITY * 0.3 * PGA_OVER_WEST_AND_PGV_OVER_PGA[kind, 0]
    peaks = {
        "pga": (("record", "azimuth"), pga),
        "pgv": (("record", "azimuth"), pga * PGA_OVER_WEST_AND_PGV_OVER_PGA[kind, 1]),
    }
    found = score_overturning_criteria(cube, xr.Dataset(peaks, {"azimuth": azimuth}))
    assert found is not None
    return found


@pytest.mark.long
def test_best_criterion_is_named_only_if_criteria_differ(make_cube_from_fall_rules: Callable[..., xr.Dataset]) -> None:
    """Regression: the criterion with the higher skill was called the best even if two were equal."""
    generator = np.random.default_rng(42)
    alike = [
        scores_of_criterion_with_random_success_rate(make_cube_from_fall_rules, generator, (2, 2)) for _ in range(400)
    ]
    assert {one.score_of_best_criterion.name for one in alike} == {
        NAME_OF_KANEKO_HAYASHI_CRITERION,
        NAME_OF_ONE_IMPACT_CRITERION,
    }
    assert (
        np.mean(
            [
                all(lead.interval_low > 0 for lead in one.best_minus_other_skill_by_criterion_name.values())
                for one in alike
            ]
        )
        <= 0.07
    )
    # Both lead the three that always say the same.
    assert (
        np.mean(
            [
                sum(lead.interval_low > 0 for lead in one.best_minus_other_skill_by_criterion_name.values()) >= 3
                for one in alike
            ]
        )
        >= 0.95
    )
    better = [
        scores_of_criterion_with_random_success_rate(make_cube_from_fall_rules, generator, (6, 2)) for _ in range(60)
    ]
    ranked = [
        one.score_of_best_criterion.name
        for one in better
        if all(lead.interval_low > 0 for lead in one.best_minus_other_skill_by_criterion_name.values())
    ]
    assert set(ranked) == {NAME_OF_KANEKO_HAYASHI_CRITERION}
    assert len(ranked) >= 48


def test_blocks_that_nearly_always_stand_have_little_weight_in_scores(
    make_cube_from_fall_rules: Callable[..., xr.Dataset],
) -> None:
    """The weight of a block is f(1 − f), with f its share of falls: by hand for f = 1/2 and f = 1/50."""
    azimuth = np.arange(0, 180, 3.6)
    strong = np.arange(50) < 25
    pga = STANDARD_GRAVITY * np.where(strong, 0.9, 0.25)
    falls = {
        0.3: strong,
        0.8: np.arange(50) == 30,
    }  # West: correct for the first earthquake, wrong for the only fall of the other

    def falls_by_azimuth_and_b_over_h(at: np.ndarray, _: np.ndarray, slender: np.ndarray, __: np.ndarray) -> np.ndarray:
        place = np.rint(at / 3.6).astype(int)
        return np.where(slender < 0.5, falls[0.3][place], falls[0.8][place]).astype(float)

    cube = make_cube_from_fall_rules(
        falls_by_azimuth_and_b_over_h,
        azimuth=azimuth,
        height=[0.6],
        b_over_h=[0.3, 0.8],
        friction=[1.0],
        events="abcdefgh",
    )
    peaks = {name: (("record", "azimuth"), np.tile(one, (8, 1))) for name, one in (("pga", pga), ("pgv", pga / 10))}
    found = score_overturning_criteria(cube, xr.Dataset(peaks, {"azimuth": azimuth}))
    assert found is not None
    weights = np.array([0.5 * 0.5, 0.02 * 0.98])
    assert found.rule_scores[0].weighted_mean_skill_over_block_sizes.mean == pytest.approx(
        weights @ [1.0, -25 / 49] / weights.sum()
    )
