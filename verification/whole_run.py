"""Cost of a complete run of the default study, from the records to the report, in a separate folder.

`python -m verification.bench whole-run` runs the study twice: with the fork server of a run, and with each step in a
process of its own. The processor times of each kind of step show what starting processes costs.
"""

import csv
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Final, NamedTuple

import netCDF4

from overturning.commands.fork_client import SERVER_SOCKET_ENVIRONMENT_VARIABLE
from overturning.errors import ResultError
from verification.project import StudyWorkflowCopy
from verification.tables import ROOT, MeasuredNumber, current_commit, markdown_table, text_of_value_and_unit

CORE_COUNT_OF_WHOLE_RUN: Final = 2

MIN_PROCESSOR_TIME_OF_LISTED_COMMAND_S: Final = 2.0
"""Commands whose steps take at least this processor time together, s, are listed."""

QUANTITY_PREFIX_WITH_FORK_SERVER: Final = "default study, whole run"
QUANTITY_PREFIX_WITHOUT_FORK_SERVER: Final = "default study, whole run, a process for each step"
"""First words of the quantities of the two runs."""

STEP_TABLE_FILE_NAME: Final = "steps.tsv"
"""Table of processor time and memory of each step, in the folder `benchmarks` of the results."""

STEP_MEASURING_PROGRAM: Final = """\
#!{python} -S
import os, sys
step = os.fork()
if not step:
    os.execv({program!r}, [{program!r}, *sys.argv[1:]])
_, status, used = os.wait4(step, 0)
with open({table!r}, "a") as table:
    table.write("%s\\t\\t%.3f\\t%.1f\\n" % (sys.argv[1], used.ru_utime + used.ru_stime, used.ru_maxrss / 1000))
sys.exit(os.waitstatus_to_exitcode(status))
"""
"""Program `overturning` that measures each step in a process of its own, in a table like that of the fork server."""


class TotalCostOfCommandSteps(NamedTuple):
    """Cost of the steps of one command in a complete run: their number, processor time together, and largest memory."""

    step_count: int
    total_processor_time_s: float
    max_memory_mb: float


class WholeRunCost(NamedTuple):
    """Cost of one complete run of a study."""

    elapsed_time_s: float
    processor_time_s: float
    time_to_first_map_s: float  # time until the first polar map exists
    step_cost_by_command: dict[str, TotalCostOfCommandSteps]  # by command
    cube_sha256: str


def run_whole_study_and_measure_cost(
    uses_fork_server: bool, checkout_folder: Path = ROOT, study_yaml: str = ""
) -> WholeRunCost:
    """Run a study (text of its file; default: the default study) of a checkout in a new folder; return its cost."""
    with tempfile.TemporaryDirectory() as scratch:
        project = StudyWorkflowCopy(
            Path(scratch) / "project",
            study_yaml,
            "--cores",
            str(CORE_COUNT_OF_WHOLE_RUN),
            source_checkout_folder=checkout_folder,
        )
        how, table = (
            project.subprocess_arguments_of_snakemake_run(result_file_name=""),
            project.results / "benchmarks" / STEP_TABLE_FILE_NAME,
        )
        if not uses_fork_server:
            table = Path(scratch) / STEP_TABLE_FILE_NAME
            program = str(Path(sys.executable).with_name("overturning"))
            wrapper = Path(scratch) / "overturning"
            text = STEP_MEASURING_PROGRAM.format(python=sys.executable, program=program, table=str(table))
            wrapper.write_text(text, encoding="utf-8")
            wrapper.chmod(0o755)
            how["env"] |= {SERVER_SOCKET_ENVIRONMENT_VARIABLE: "off", "PATH": f"{scratch}:{how['env']['PATH']}"}
        before, begin, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter(), time.time()
        subprocess.run(**how, check=True)
        wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)
        first = min(path.stat().st_mtime for path in project.results.glob("figures/polar/*.svg"))
        with netCDF4.Dataset(project.cube_path) as cube:  # also of a version whose cubes `open_cube` refuses
            return WholeRunCost(wall, spent, first - began, read_step_costs(table), str(cube.content_sha256))


def read_step_costs(step_time_and_memory_log_path: Path) -> dict[str, TotalCostOfCommandSteps]:
    """Read a table of steps; return the cost by command, the command with most processor time first."""
    costs: dict[str, TotalCostOfCommandSteps] = {}
    with step_time_and_memory_log_path.open(encoding="utf-8", newline="") as file:
        for row in csv.reader(file, delimiter="\t"):
            if row[0] != "command":
                steps, seconds, memory = costs.get(row[0], (0, 0.0, 0.0))
                costs[row[0]] = TotalCostOfCommandSteps(steps + 1, seconds + float(row[2]), max(memory, float(row[3])))
    return dict(sorted(costs.items(), key=lambda one: -one[1].total_processor_time_s))


def measure_whole_run_with_and_without_fork_server() -> list[MeasuredNumber]:
    """Run the default study with the fork server and with a process per step; return elapsed and processor times."""
    served, own = (
        run_whole_study_and_measure_cost(uses_fork_server=True),
        run_whole_study_and_measure_cost(uses_fork_server=False),
    )
    if served.cube_sha256 != own.cube_sha256:
        raise ResultError(f"the cubes differ: {served.cube_sha256}, {own.cube_sha256}")
    rows = []
    for run, what in ((served, QUANTITY_PREFIX_WITH_FORK_SERVER), (own, QUANTITY_PREFIX_WITHOUT_FORK_SERVER)):
        rows += [
            MeasuredNumber(f"{what}: time on two cores", run.elapsed_time_s, "s"),
            MeasuredNumber(f"{what}: processor time", run.processor_time_s, "s"),
            MeasuredNumber(f"{what}: first polar map after", 100.0 * run.time_to_first_map_s / run.elapsed_time_s, "%"),
        ]
    for command in (
        name
        for name, cost in own.step_cost_by_command.items()
        if cost.total_processor_time_s >= MIN_PROCESSOR_TIME_OF_LISTED_COMMAND_S
    ):
        for run, what in ((served, QUANTITY_PREFIX_WITH_FORK_SERVER), (own, QUANTITY_PREFIX_WITHOUT_FORK_SERVER)):
            cost = run.step_cost_by_command[command]
            quantity = f"{what}: processor time of `{command}` × {cost.step_count}"
            rows.append(MeasuredNumber(quantity, cost.total_processor_time_s, "s"))
    return rows


def fork_server_comparison_table(measured_numbers: Sequence[MeasuredNumber]) -> str:
    """Return a Markdown table of a whole run: a row per quantity, a column without and one with the fork server."""
    values = {one.quantity: text_of_value_and_unit(one) for one in measured_numbers}
    names = [
        quantity.removeprefix(f"{QUANTITY_PREFIX_WITHOUT_FORK_SERVER}: ")
        for quantity in values
        if quantity.startswith(QUANTITY_PREFIX_WITHOUT_FORK_SERVER)
    ]
    rows = [
        (
            name,
            values[f"{QUANTITY_PREFIX_WITHOUT_FORK_SERVER}: {name}"],
            values[f"{QUANTITY_PREFIX_WITH_FORK_SERVER}: {name}"],
        )
        for name in names
    ]
    return markdown_table(("", "a process for each step", "fork server"), rows)


def compare_run_costs_with_other_checkout(checkout_folder: Path, pair_count: int, study_yaml: str = "") -> str:
    """Run a study (default: the default study) of another checkout and of this one in turn; return a table of costs.

    A row gives the medians over the pairs, and the median of the ratios within a pair. The first run of each state,
    which compiles its kernels and bytecode, is not counted. Steps of a checkout without a fork server run in processes
    of their own.
    """
    has_server = (checkout_folder / "src" / "overturning" / "commands" / "fork_server.py").exists()
    both = [(has_server, checkout_folder), (True, ROOT)]
    runs = [[run_whole_study_and_measure_cost(*state, study_yaml) for state in both] for _ in range(pair_count + 1)][1:]
    columns = [[_times_by_table_row_name(one) for one in states] for states in zip(*runs, strict=True)]
    rows = []
    for name in dict.fromkeys(name for column in columns for name in column[0]):
        before, after = ([one[name] for one in column if name in one] for column in columns)
        ratio = f"{median(new / old for old, new in zip(before, after, strict=True)):.2f}" if before and after else "–"
        rows.append((name, *(f"{median(values):.3g}" if values else "–" for values in (before, after)), ratio))
    earlier = subprocess.run(
        ["git", "rev-parse", "--short=8", "HEAD"], cwd=checkout_folder, capture_output=True, text=True, check=True
    ).stdout.strip()
    return markdown_table(("", f"commit {earlier}", f"commit {current_commit()}", "ratio"), rows)


def _times_by_table_row_name(run_cost: WholeRunCost) -> dict[str, float]:
    """Return the times of a complete run, s, by table row: elapsed, first map, processor, each command, the rest."""
    steps = {
        f"processor time of `{name}`, s": cost.total_processor_time_s
        for name, cost in run_cost.step_cost_by_command.items()
    }
    rest = run_cost.processor_time_s - sum(steps.values())
    return {
        "time on two cores, s": run_cost.elapsed_time_s,
        "time until the first polar map, s": run_cost.time_to_first_map_s,
        "processor time, s": run_cost.processor_time_s,
        **steps,
        "processor time of Snakemake and of what starts the steps, s": rest,
    }
