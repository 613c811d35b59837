"""`python -m verification.stack_peers [PART ...]`: stacks of two and three stones compared with MuJoCo and LMGC90.

Parts: `MuJoCo` and `LMGC90` run the cases in that solver; `table` compares this program with their stored outcomes and
writes the tables of docs/validation.md. A case is robust in a solver if that solver keeps the flag, and the azimuth
within 20°, with ±1 % of amplitude and with half the time step; this program has no say in it. An interrupted run
resumes: finished cases are kept in results/verification.
"""

import hashlib
import json
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Final

import pandas as pd
import typer

from overturning.errors import ArgumentError
from overturning.motion.motion import Motion
from verification.stack_agreement import (
    OUTCOME_FILE_BY_SOLVER,
    RELATIVE_AMPLITUDE_CHANGE_OF_ROBUST_CASE,
    outcomes_agree,
    publish_agreement_with_solvers,
)
from verification.stack_cases import StackUnderScaledRecord, case_parameters_as_table_row, draw_random_stack_cases
from verification.stack_engines import MODULE_NAME_BY_STACK_ENGINE, STACK_ENGINES, topmost_stone_outcome_in_engine
from verification.tables import ROOT, named_parts_or_all_if_none, write_csv

TIME_STEP_BY_SOLVER_S: Final = {"MuJoCo": 5e-4, "LMGC90": 5e-4}
"""Time steps of the solvers, s."""
PARTIAL_RESULT_FOLDER: Final = ROOT / "results" / "verification"
SOURCE_FILES_OF_OUTCOMES: Final = ("engines.py", "stack_cases.py", "stack_engines.py", "stack_peers.py")
"""Files of this folder on which the outcomes of a solver depend."""


def partial_results_path(solver_name: str) -> Path:
    """Return the file of finished cases of a solver; its name has a hash of the sources that outcomes depend on."""
    digest = hashlib.sha256()
    for name in SOURCE_FILES_OF_OUTCOMES:
        digest.update((ROOT / "verification" / name).read_bytes())
    time_step = TIME_STEP_BY_SOLVER_S[solver_name]
    return PARTIAL_RESULT_FOLDER / f"stack-peers-{solver_name.lower()}-{time_step:g}-{digest.hexdigest()[:8]}.jsonl"


def label_motion_and_time_step_of_robustness_runs(
    case: StackUnderScaledRecord, time_step: float
) -> Iterator[tuple[str, Motion, float]]:
    """Yield label, motion and time step of the runs that must agree in a robust case; the first is the nominal one."""
    yield "", case.part_of_scaled_record_that_can_move_a_stone, time_step
    yield "half the step", case.part_of_scaled_record_that_can_move_a_stone, 0.5 * time_step
    for factor in (1.0 - RELATIVE_AMPLITUDE_CHANGE_OF_ROBUST_CASE, 1.0 + RELATIVE_AMPLITUDE_CHANGE_OF_ROBUST_CASE):
        yield f"amplitude × {factor:g}", case.part_of_scaled_record_that_can_move_a_stone.scaled_by(factor), time_step


def outcome_stability_and_run_time_in_solver(solver_name: str, case: StackUnderScaledRecord) -> dict[str, Any]:
    """Return the outcome of a case, whether slight changes keep it, and the processor time of the nominal run."""
    engine, nominal, changed, seconds = STACK_ENGINES[solver_name], None, "", 0.0
    for label, motion, time_step in label_motion_and_time_step_of_robustness_runs(
        case, TIME_STEP_BY_SOLVER_S[solver_name]
    ):
        begin = time.process_time()
        found = topmost_stone_outcome_in_engine(engine, case.stack, motion, case.orientation_deg, time_step)
        if nominal is None:
            nominal, seconds = found, time.process_time() - begin
        elif not outcomes_agree(found.fall_azimuth_deg, nominal.fall_azimuth_deg):
            changed = label
            break
    assert nominal is not None
    return nominal.as_outcome_table_columns() | {"robust": int(not changed), "changed_by": changed, "seconds": seconds}


def run_unfinished_cases_and_join_outcomes(solver_name: str, process_count: int) -> pd.DataFrame:
    """Run the cases that a solver has not finished; return a table of the outcomes of all cases, one row per case."""
    cases = draw_random_stack_cases()
    partial_path = partial_results_path(solver_name)
    partial_path.parent.mkdir(parents=True, exist_ok=True)
    finished = {}
    if partial_path.is_file():
        for row in map(json.loads, partial_path.read_text(encoding="utf-8").splitlines()):
            number = row["case"]
            if number < len(cases) and case_parameters_as_table_row(number, cases[number]).items() <= row.items():
                finished[number] = row
    with ProcessPoolExecutor(process_count) as pool, partial_path.open("a", encoding="utf-8") as partial_file:
        waiting = {
            pool.submit(outcome_stability_and_run_time_in_solver, solver_name, case): (number, case)
            for number, case in enumerate(cases)
            if number not in finished
        }
        for future in as_completed(waiting):
            row = case_parameters_as_table_row(*waiting[future]) | future.result()
            finished[row["case"]] = row
            print(json.dumps(row), file=partial_file, flush=True)
    return pd.DataFrame([finished[number] for number in range(len(cases))])


def main(
    parts: Annotated[list[str] | None, typer.Argument(help="parts to run; default: all")] = None,
    processes: Annotated[int, typer.Option(min=1, help="number of processes")] = 2,
) -> None:
    """Run the cases in the other solvers, and compare this program with them."""
    for part in named_parts_or_all_if_none(parts, [*STACK_ENGINES, "table"]):
        if part == "table":
            publish_agreement_with_solvers()
        elif find_spec(MODULE_NAME_BY_STACK_ENGINE[part]) is None:
            raise ArgumentError(f"{part} is not installed: make peers")
        else:
            write_csv(run_unfinished_cases_and_join_outcomes(part, processes), OUTCOME_FILE_BY_SOLVER[part])


if __name__ == "__main__":
    typer.run(main)
