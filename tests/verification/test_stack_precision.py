"""The table of error against run time of stacks, from rows written by hand."""

import math

import pandas as pd

from verification.stack_precision import TIME_STEPS_BY_SOLVER_S_OR_AUTO_STEP_SHARE, error_against_run_time_table


def test_wrong_stack_outcomes_are_counted_against_the_finest_step() -> None:
    """With the finest step two stacks fall to 0° and 350° and one stands.

    A coarse step gives 15°, 30° and 90°: one wrong flag and one azimuth that is 40° off.
    """
    rows = []
    for solver, steps in TIME_STEPS_BY_SOLVER_S_OR_AUTO_STEP_SHARE.items():
        for step in steps:
            azimuths = [0.0, 350.0, math.nan] if step in (steps[-1], steps[1]) else [15.0, 30.0, 90.0]
            rows += [
                {"solver": solver, "step": step, "case": case, "fall_azimuth_deg": azimuth, "seconds": 0.002}
                for case, azimuth in enumerate(azimuths)
            ]
    table = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in error_against_run_time_table(pd.DataFrame(rows)).split("\n")[2:]
    ]
    assert len(table) == sum(len(steps) - 1 for steps in TIME_STEPS_BY_SOLVER_S_OR_AUTO_STEP_SHARE.values())
    coarsest, second = table[0], table[1]
    assert coarsest[2:4] == ["2 ms", "33.3 % (1 of 3; 6.1 to 79.2)"]
    assert coarsest[4].startswith("50.0 % (1 of 2;")
    assert second[3].startswith("0.0 % (0 of 3;")
    assert second[4].startswith("0.0 % (0 of 2;")
