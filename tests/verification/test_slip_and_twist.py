"""The table of errors of slip and twist against the step, from rows written by hand."""

import pandas as pd

from verification.slip_and_twist import TIME_STEP_DIVISORS, slip_and_twist_error_table


def test_slip_errors_of_standing_stones_are_relative_to_the_finest_step() -> None:
    """Three of five shafts count: one falls with the longest step, and one slips by less than 1 mm."""
    reference = [0.010, 0.020, 0.040, 0.0005, 0.030]
    longest = [0.011, 0.018, 0.040, 0.0010, 0.090]
    rows = pd.DataFrame([
        {"model": "on the ground", "refinement": refinement, "case": case, "slip": slip, "twist": 100.0 * slip,
         "overturned": float(refinement == TIME_STEP_DIVISORS[0] and case == 4)}
        for refinement in TIME_STEP_DIVISORS
        for case, slip in enumerate(longest if refinement == TIME_STEP_DIVISORS[0] else reference)
    ])  # fmt: skip
    table = [
        [cell.strip() for cell in line.split("|")[1:-1]] for line in slip_and_twist_error_table(rows).split("\n")[2:]
    ]
    assert [line[1] for line in table] == ["slip"] * 3 + ["twist"] * 3
    # Errors 10, 10 and 0 %; quantile 0.9 of 0.1, 1.1, 1.8 and 4 cm, and of 0.05, 1, 2 and 4 cm.
    assert table[0][2:] == ["1", "3", "10 %", "10 %", "3.34 cm", "3.4 cm"]
    assert table[1][2:6] == ["0.5", "3", "0 %", "0 %"]
    assert table[3][2:] == ["1", "3", "10 %", "10 %", "3.34°", "3.4°"]
