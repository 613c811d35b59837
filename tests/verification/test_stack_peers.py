"""Stacks of two and three stones against MuJoCo and LMGC90.

The solvers' answers are kept in stack-peers-mujoco.csv and stack-peers-lmgc90.csv, made by `python -m
verification.stack_peers`, since the tests' environment does not have them; where they are installed, some are found
again.
"""

from functools import cache
from importlib.util import find_spec

import numpy as np
import pandas as pd
import pytest

from tests.dem.near_field import near_field_motion_and_fault_component_azimuths as installed_near_field
from tests.expect import skip_test_unless_skipping_is_forbidden
from verification.stack_agreement import (
    CASE_PARAMETER_COLUMNS,
    OUTCOME_FILE_BY_SOLVER,
    outcomes_agree,
    topmost_stone_outcomes_in_this_program,
    trajectory_has_known_outcome,
)
from verification.stack_cases import StackUnderScaledRecord, case_parameters_as_table_row, draw_random_stack_cases
from verification.stack_engines import MODULE_NAME_BY_STACK_ENGINE
from verification.stack_peers import outcome_stability_and_run_time_in_solver


@cache
def random_stack_cases() -> list[StackUnderScaledRecord]:
    """The random cases that the program and each other solver simulate."""
    return draw_random_stack_cases()


@pytest.mark.parametrize("name", OUTCOME_FILE_BY_SOLVER)
def test_the_stored_stack_cases_are_reproduced_from_the_seed(name: str) -> None:
    installed_near_field(6)  # skips where the records are not installed
    kept, cases = pd.read_csv(OUTCOME_FILE_BY_SOLVER[name]), random_stack_cases()
    drawn = pd.DataFrame([case_parameters_as_table_row(number, cases[number]) for number in kept["case"]])
    pd.testing.assert_frame_equal(kept[CASE_PARAMETER_COLUMNS], drawn[CASE_PARAMETER_COLUMNS], check_dtype=False)
    assert kept["case"].tolist() == list(range(len(cases)))
    assert kept["sinking"].notna().all()
    robust = kept[kept["robust"] == 1]
    assert 0.3 < np.isfinite(robust["fall_azimuth_deg"]).mean() < 0.7


@pytest.mark.parametrize("name", OUTCOME_FILE_BY_SOLVER)
def test_at_least_200_stack_cases_are_robust_in_each_solver(name: str) -> None:
    assert pd.read_csv(OUTCOME_FILE_BY_SOLVER[name])["robust"].sum() >= 200


@cache
def flag_and_azimuth_agreement_with_solver(name: str) -> tuple[float, int, int]:
    """Return the share of robust cases with equal flags, and the numbers of equal azimuths and joint falls.

    The flags are those of overturning; equal azimuths are fall azimuths that agree; a joint fall is a case that falls
    in both programs.
    """
    installed_near_field(6)
    kept, cases = pd.read_csv(OUTCOME_FILE_BY_SOLVER[name]), random_stack_cases()
    some = kept[kept["robust"] == 1]
    found = [topmost_stone_outcomes_in_this_program(cases[number], [1.0])[0] for number in some["case"]]
    ours = np.array([outcome["fall_azimuth_deg"] for outcome in found])
    theirs = some["fall_azimuth_deg"].to_numpy()
    both = np.isfinite(ours) & np.isfinite(theirs)
    same_flag = (np.isfinite(ours) == np.isfinite(theirs)) & [
        trajectory_has_known_outcome(outcome) for outcome in found
    ]
    agree = sum(outcomes_agree(*pair) for pair in zip(ours[both], theirs[both], strict=True))
    return float(same_flag.mean()), agree, int(both.sum())


@pytest.mark.long
@pytest.mark.parametrize(("name", "azimuths"), [("MuJoCo", 83), ("LMGC90", 84)])
def test_most_stack_falls_and_fall_azimuths_agree_with_another_solver(name: str, azimuths: int) -> None:
    """At least 98 % of the overturning flags agree, and at least as many fall azimuths as in an earlier measurement."""
    same_flag, agree, both = flag_and_azimuth_agreement_with_solver(name)
    assert same_flag >= 0.98
    assert both >= 80
    assert agree >= azimuths


@pytest.mark.long
@pytest.mark.xfail(
    strict=True, reason="83 of 93 azimuths agree with MuJoCo, and 85 of 104 with LMGC90, whose corners sink"
)
@pytest.mark.parametrize("name", OUTCOME_FILE_BY_SOLVER)
def test_stack_fall_azimuth_goal_is_not_yet_reached(name: str) -> None:
    """Expected to fail: fewer than nine in ten fall azimuths agree.

    When the share is reached, the strict xfail mark must be removed.
    """
    _, agree, both = flag_and_azimuth_agreement_with_solver(name)
    assert agree >= 0.9 * both


@pytest.mark.long
@pytest.mark.parametrize("name", OUTCOME_FILE_BY_SOLVER)
def test_external_engines_reproduce_some_stored_stack_outcomes(name: str) -> None:
    if find_spec(MODULE_NAME_BY_STACK_ENGINE[name]) is None:
        skip_test_unless_skipping_is_forbidden(
            f"{name} is not installed (`make peers`); its kept answers are compared with this program"
        )
    kept, cases = pd.read_csv(OUTCOME_FILE_BY_SOLVER[name]), random_stack_cases()
    some = kept[(kept["robust"] == 1) & np.isfinite(kept["fall_azimuth_deg"])].iloc[:5]
    found = [
        outcome_stability_and_run_time_in_solver(name, cases[number])["fall_azimuth_deg"] for number in some["case"]
    ]
    same = [outcomes_agree(*pair) for pair in zip(found, some["fall_azimuth_deg"], strict=True)]
    assert sum(same) >= 4  # other versions differ in a chaotic case now and then
