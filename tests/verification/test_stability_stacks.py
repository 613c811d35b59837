"""No case of a 3-D stack is silent, on a small sample; the checks find wrong outcomes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from overturning.dem.run import simulate_cases
from overturning.model.cases import Cases
from overturning.model.results import CaseResults
from overturning.model.stack import Stack
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from tests.dem.test_stack import acceleration_components_with_plateau
from verification.stability.checks import StabilityCheckVerdict
from verification.stability.maps import collect_stability_map_rows
from verification.stability.stacks import (
    MAX_PENETRATION_TO_WIDTH_OF_STIFF_CONTACT,
    STACK_COLUMN_LONG_NAMES_AND_UNITS,
    ParametersOfStackCases,
    generate_random_parameters_of_stack_cases,
    name_of_first_failed_stack_check,
    simulate_stack_cases_and_check_outcomes,
    stack_scene_from_parameters,
)

pytestmark = pytest.mark.long


def test_no_wrong_outcome_of_an_extreme_stack_is_reported_as_valid() -> None:
    settings = generate_random_parameters_of_stack_cases(16, 7)
    rows = collect_stability_map_rows(simulate_stack_cases_and_check_outcomes, settings, threads=2)
    assert set(rows) == set(STACK_COLUMN_LONG_NAMES_AND_UNITS)
    silent = rows["ending"] == StabilityCheckVerdict.WRONG_WITHOUT_WARNING
    assert not silent.any(), rows["reason"][silent].tolist()
    answered = rows["ending"].isin((StabilityCheckVerdict.ALL_CHECKS_HOLD, StabilityCheckVerdict.NOT_SIMULATED_AT_REST))
    assert ((rows["fallen"] >= 0) == answered).all()
    # Soft contacts, up to a hundredth of their width, leave the range of the contact law.
    assert answered[rows["penetration_ratio"] < MAX_PENETRATION_TO_WIDTH_OF_STIFF_CONTACT].mean() > 0.6
    assert (rows["fallen"] > 1).any(), "some stacks come down"
    again = collect_stability_map_rows(simulate_stack_cases_and_check_outcomes, settings[:3])
    assert again.equals(rows[: len(again)])


def simulated_stack_case() -> tuple[ParametersOfStackCases, Motion, CaseResults]:
    """Return a setting with two stones, of which the upper falls, its motion, and the results of its case."""
    setting = replace(
        generate_random_parameters_of_stack_cases(1, 1)[0],
        stone_sizes=np.array([[0.6, 0.6, 0.3], [0.2, 0.2, 0.6]]), stone_densities=np.array([2650.0, 2650.0]),
        static_penetration_to_width_ratio=2e-6, contact_damping_ratio=1.0, friction_by_case=np.array([0.7]),
        amplitude_factor_by_case=np.array([1.0]),
        orientation_deg_by_case=np.array([0.0]),
    )  # fmt: skip
    motion = Motion(*acceleration_components_with_plateau(0.4, 0.0), sampling_interval=0.01, trust_data=True)
    found = simulate_cases(Stack(stack_scene_from_parameters(setting)), motion, Cases([0.0], 0.6, 1.0 / 3.0, 0.7))
    assert found.status[0] == CaseStatus.SIMULATED
    assert found.overturned[0].tolist() == [0, 1]
    return setting, motion, found


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"overturned": [1, 0]}, "a stone stands on a fallen one"),
        ({"overturned": [0, 0]}, "flag, azimuth and time"),
        ({"peak_tilt": [0.0, 3.0]}, "fallen without tilt"),
        ({"energy_error": 0.02}, "energy balance"),
        ({"peak_penetration": 1.0}, "penetration"),
        ({"residual_twist": [np.nan, np.nan]}, "a number is not finite"),
        ({"status": CaseStatus.UNSTABLE}, "flag in spite of the mark"),
        ({"status": CaseStatus.AT_REST}, "left out above a threshold"),
    ],
)
def test_the_stack_checks_detect_a_wrong_outcome(changes: dict[str, Any], reason: str) -> None:
    setting, motion, found = simulated_stack_case()
    assert name_of_first_failed_stack_check(setting, motion, found, 0) == ""
    changed = CaseResults(**vars(found) | {
        name: np.array([values]).astype(getattr(found, name).dtype) for name, values in changes.items()
    })  # fmt: skip
    assert name_of_first_failed_stack_check(setting, motion, changed, 0) == reason


def test_the_stack_checks_detect_falls_under_shaking_too_weak_to_open_a_joint() -> None:
    setting, motion, found = simulated_stack_case()
    for amplitude, reason in ((0.0, "moved without motion"), (0.15, "fell below the least acceleration")):
        weak = replace(setting, amplitude_factor_by_case=np.array([amplitude]))
        assert name_of_first_failed_stack_check(weak, motion, found, 0).startswith(reason)
    np.testing.assert_allclose(setting.min_joint_opening_acceleration, 9.80665 / 3.0, err_msg="the shaft opens at B/H")
