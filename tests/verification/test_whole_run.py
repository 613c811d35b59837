"""Tables of complete runs: what starting steps costs, and two versions in pairs."""

import subprocess
from pathlib import Path

import pytest

from verification import whole_run
from verification.tables import ROOT, MeasuredNumber
from verification.whole_run import (
    QUANTITY_PREFIX_WITH_FORK_SERVER,
    QUANTITY_PREFIX_WITHOUT_FORK_SERVER,
    TotalCostOfCommandSteps,
    WholeRunCost,
    compare_run_costs_with_other_checkout,
    fork_server_comparison_table,
    read_step_costs,
)


@pytest.mark.parametrize("header", ["command\toutput\tcpu_time\tmax_rss\n", ""])
def test_measured_costs_of_workflow_steps_are_added_by_command(tmp_path: Path, header: str) -> None:
    table = tmp_path / "steps.tsv"
    rows = "read\ta.nc\t0.50\t90.0\nsweep\ta.nc\t4.00\t150.0\nread\tb.nc\t0.25\t95.5\n"
    table.write_text(header + rows, encoding="utf-8")
    costs = read_step_costs(table)
    assert costs == {"read": TotalCostOfCommandSteps(2, 0.75, 95.5), "sweep": TotalCostOfCommandSteps(1, 4.0, 150.0)}
    assert list(costs) == ["sweep", "read"], "the longest first"


def test_start_up_table_rows_compare_runs_with_and_without_the_fork_server() -> None:
    quantity = "processor time of `read` × 28"
    figures = [
        MeasuredNumber(f"{QUANTITY_PREFIX_WITH_FORK_SERVER}: {quantity}", 1.62, "s"),
        MeasuredNumber(f"{QUANTITY_PREFIX_WITHOUT_FORK_SERVER}: {quantity}", 16.6, "s"),
    ]
    assert fork_server_comparison_table(figures).splitlines()[2:] == [f"| {quantity} | 16.6 s | 1.62 s |"]


def test_checkouts_are_timed_in_pairs_without_their_first_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both checkouts are twice as slow in the second pair of runs, which leaves the ratio of their times unchanged.

    The first run of each checkout is not counted.
    """
    subprocess.run(["git", "init", "-q", str(tmp_path)], check=True)
    author = ("-c", "user.name=a", "-c", "user.email=a@b")
    subprocess.run(["git", *author, "commit", "-q", "--allow-empty", "-m", "x"], cwd=tmp_path, check=True)
    walls = {tmp_path: iter((500.0, 100.0, 200.0)), ROOT: iter((900.0, 50.0, 100.0))}
    served = []

    def return_invented_run_times(with_fork_server: bool, checkout: Path, study: str) -> WholeRunCost:
        served.append((with_fork_server, checkout, study))
        wall, name = next(walls[checkout]), "report" if checkout == ROOT else "crate"
        return WholeRunCost(
            wall,
            2 * wall,
            wall / 5,
            {"sweep": TotalCostOfCommandSteps(1, wall, 1.0), name: TotalCostOfCommandSteps(1, 1.0, 1.0)},
            "",
        )

    monkeypatch.setattr(whole_run, "run_whole_study_and_measure_cost", return_invented_run_times)
    rows = [
        line.strip("| ").split(" | ")
        for line in compare_run_costs_with_other_checkout(tmp_path, 2, "name: a").splitlines()[2:]
    ]
    assert served == [(False, tmp_path, "name: a"), (True, ROOT, "name: a")] * 3
    found = {row[0]: row[1:] for row in rows}
    assert found["time on two cores, s"] == ["150", "75", "0.50"]
    assert found["processor time of `sweep`, s"] == ["150", "75", "0.50"]
    assert found["processor time of `crate`, s"] == ["1", "–", "–"]
    assert found["processor time of `report`, s"] == ["–", "1", "–"]
