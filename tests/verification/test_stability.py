"""No case of the map is silent, on a small sample; the checks find what is wrong."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from overturning.dem.run import run_cases
from overturning.model.cases import Cases
from overturning.model.results import CaseResults
from overturning.model.scene import gravestone
from verification.stability.cases import (
    ADVERSARIAL_MOTION_KINDS,
    BlockCaseOfNumericalStabilityMap,
    cases_under_adversarial_motions,
    motion_of_case,
    space_filling_cases,
)
from verification.stability.checks import (
    StabilityCheckVerdict,
    motion_peak_horizontal_to_apparent_gravity_ratio,
    name_of_first_failed_block_check,
)
from verification.stability.figures import draw_block_outcomes_over_dimensionless_groups
from verification.stability.maps import (
    BLOCK_COLUMN_LONG_NAMES_AND_UNITS,
    DIMENSIONLESS_GROUP_NAMES,
    collect_stability_map_rows,
    contact_law_of_block_case,
    simulate_block_case_and_check_outcome,
)

STEP_BUDGET = 100_000
STABLE_CASE = BlockCaseOfNumericalStabilityMap(
    1e8, 1.0, 0.3, 1.0, 2650.0, 0.6, 6.0, 0.01, float("nan"), "centred", "pulse", 80.0, 0.0
)


@pytest.mark.long
def test_no_wrong_outcome_of_an_extreme_block_is_reported_as_valid() -> None:
    cases = [
        *space_filling_cases(256, 5),
        *(case for case in cases_under_adversarial_motions(2, 5) if case.motion_kind != "ten minutes"),
    ]
    found = collect_stability_map_rows(
        partial(simulate_block_case_and_check_outcome, max_block_steps=STEP_BUDGET), cases
    )
    assert set(found) == set(BLOCK_COLUMN_LONG_NAMES_AND_UNITS)
    assert found[found["ending"] == StabilityCheckVerdict.WRONG_WITHOUT_WARNING].empty
    marked = ~np.isin(
        found["ending"], (StabilityCheckVerdict.ALL_CHECKS_HOLD, StabilityCheckVerdict.NOT_SIMULATED_AT_REST)
    )
    assert (found["overturned"][marked] == -128).all()
    assert (found["overturned"][~marked] != -128).all()
    assert {
        StabilityCheckVerdict.ALL_CHECKS_HOLD,
        StabilityCheckVerdict.NOT_SIMULATED_AT_REST,
        StabilityCheckVerdict.NUMERICALLY_UNSTABLE,
        StabilityCheckVerdict.OVER_STEP_BUDGET,
    } <= set(found["ending"].tolist())
    # A case may finish the sample in which its budget ends.
    per_sample = found["block_steps"].max() - STEP_BUDGET
    assert per_sample < STEP_BUDGET


@pytest.mark.parametrize("name", ADVERSARIAL_MOTION_KINDS)
def test_adversarial_motions_have_the_properties_in_their_names(name: str) -> None:
    case = next(
        case
        for case in cases_under_adversarial_motions(8, 1)
        if case.motion_kind == name and case.peak_horizontal_acceleration > 0
    )
    motion = motion_of_case(case, 0)
    match name:
        case "impulse":
            assert np.count_nonzero(motion.north) == 1
        case "ten minutes":
            assert motion.sample_count * motion.sampling_interval == pytest.approx(600)
        case "vertical above g":
            assert motion.up is not None
            assert motion.up.min() < -9.80665
            assert motion_peak_horizontal_to_apparent_gravity_ratio(motion) == np.inf
        case "constant offset":
            assert np.ptp(motion.north) == 0
        case _:
            crossings = np.count_nonzero(np.diff(np.signbit(motion.north[1:])))
            frequency = crossings / 2 / (motion.sample_count * motion.sampling_interval)
            assert frequency == pytest.approx(float(name.split()[0]), rel=0.3)


def test_the_checks_of_single_blocks_detect_a_wrong_outcome() -> None:
    motion = motion_of_case(STABLE_CASE, 0)
    found = run_cases(
        motion,
        Cases(0.0, STABLE_CASE.height, STABLE_CASE.b_over_h, STABLE_CASE.friction),
        gravestone(contact_law_of_block_case(STABLE_CASE), STABLE_CASE.density),
    )
    assert name_of_first_failed_block_check(STABLE_CASE, motion, found) == ""
    wrong = {
        "flag and rotation": {"overturned": np.array([1 - abs(found.overturned[0])], np.int8)},
        "energy balance": {"energy_error": np.array([0.02], np.float32)},
        "penetration": {"peak_penetration": np.array([0.1], np.float32)},
        "no flag and no mark": {"overturned": np.array([-128], np.int8)},
        "flag in spite of the mark": {"status": np.array([3], np.int8)},
        "a number is not finite": {"peak_slip": np.array([np.nan], np.float32)},
        "left out above a threshold": {"status": np.array([1], np.int8)},
    }
    for reason, change in wrong.items():
        assert name_of_first_failed_block_check(STABLE_CASE, motion, CaseResults(**vars(found) | change)) == reason


def test_a_contact_that_is_too_stiff_is_refused_with_the_reason_stiffness() -> None:
    outcome = simulate_block_case_and_check_outcome(replace(STABLE_CASE, normal_stiffness_per_corner=1e18), 0)
    assert outcome["ending"] == StabilityCheckVerdict.ARGUMENT_REFUSED
    assert outcome["reason"] == "stiffness"
    assert outcome["overturned"] == -128


@pytest.mark.long
def test_the_figure_of_twenty_thousand_block_cases_is_a_small_file(tmp_path: Path) -> None:
    random = np.random.Generator(np.random.PCG64(3))
    rows = {group: 10.0 ** random.uniform(-3.0, 0.0, 20_000) for group in DIMENSIONLESS_GROUP_NAMES}
    rows["ending"] = random.choice(
        [
            StabilityCheckVerdict.ALL_CHECKS_HOLD,
            StabilityCheckVerdict.NOT_SIMULATED_AT_REST,
            StabilityCheckVerdict.NUMERICALLY_UNSTABLE,
            StabilityCheckVerdict.OVER_STEP_BUDGET,
        ],
        20_000,
    )
    rows["damping"][:5] = np.nan
    for name in ("one", "two"):
        draw_block_outcomes_over_dimensionless_groups(pd.DataFrame(rows), tmp_path / f"{name}.svg")
    made = (tmp_path / "one.svg").read_bytes()
    assert made == (tmp_path / "two.svg").read_bytes()
    assert len(made) < 400_000, "the worst that the map can be: four colours without any order"
