"""Table of the cost of starting steps."""

from pathlib import Path

import pytest

from verification.tables import MeasuredFigure
from verification.whole_run import WITH_SERVER, WITHOUT_SERVER, StepCost, read_step_costs, start_up_table


@pytest.mark.parametrize("header", ["command\toutput\tcpu_time\tmax_rss\n", ""])
def test_costs_of_the_steps_of_a_command_are_added(tmp_path: Path, header: str) -> None:
    table = tmp_path / "steps.tsv"
    rows = "read\ta.nc\t0.50\t90.0\nsweep\ta.nc\t4.00\t150.0\nread\tb.nc\t0.25\t95.5\n"
    table.write_text(header + rows, encoding="utf-8")
    costs = read_step_costs(table)
    assert costs == {"read": StepCost(2, 0.75, 95.5), "sweep": StepCost(1, 4.0, 150.0)}
    assert list(costs) == ["sweep", "read"], "the longest first"


def test_a_row_has_the_figures_of_both_runs() -> None:
    quantity = "processor time of `read` × 28"
    figures = [
        MeasuredFigure(f"{WITH_SERVER}: {quantity}", 1.62, "s"),
        MeasuredFigure(f"{WITHOUT_SERVER}: {quantity}", 16.6, "s"),
    ]
    assert start_up_table(figures).splitlines()[2:] == [f"| {quantity} | 16.6 s | 1.62 s |"]
