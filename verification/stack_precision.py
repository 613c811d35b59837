"""`python -m verification.stack_precision [SOLVER ...]`: error of stacks against run time, in three programs.

Each solver runs the first cases of `verification.stack_cases` with several time steps. A flag is wrong if it differs
from that of the same solver with its finest step, an azimuth if it lies more than 20° from it where both fall. The run
time is the processor time of a case on one core; this program computes eight orientations of a stack together.
"""

import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from importlib.util import find_spec
from typing import Annotated, Final

import numpy as np
import pandas as pd
import typer

from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import plan_simulation, simulate_cases
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.stack import Stack
from overturning.model.status import CaseStatus
from verification.stack_agreement import PROGRAM_LABEL, outcomes_agree, share_text_with_counts_and_wilson_interval
from verification.stack_cases import StackUnderScaledRecord, draw_random_stack_cases, scene_of_stack
from verification.stack_engines import MODULE_NAME_BY_STACK_ENGINE, STACK_ENGINES, topmost_stone_outcome_in_engine
from verification.tables import (
    RESULT_TABLE_FOLDER,
    markdown_table,
    named_parts_or_all_if_none,
    update_marked_tables_and_sentences_in_docs,
    write_csv,
)

COMPARED_CASE_COUNT: Final = 60
"""Number of cases."""
TIME_STEPS_BY_SOLVER_S_OR_AUTO_STEP_SHARE: Final = {
    PROGRAM_LABEL: (1.0, 0.5, 0.25, 0.125, 0.03125),
    "MuJoCo": (4e-3, 2e-3, 1e-3, 5e-4, 1.25e-4),
    "LMGC90": (2e-3, 1e-3, 5e-4, 2e-4),
}
"""Time steps, longest first: shares of the automatic step in this program, s in the others; the last is the
reference."""
RESULT_TABLE_PATH: Final = RESULT_TABLE_FOLDER / "stack-precision.csv"


def fall_azimuth_and_processor_time_in_program(
    case: StackUnderScaledRecord, step_to_automatic_step_ratio: float
) -> tuple[float, float]:
    """Return the fall azimuth, degrees (NaN if the topmost stone stands), and the processor time of a case, s.

    Eight orientations of the stack are computed together; the time of a case is an eighth of the whole.
    """
    model, together = Stack(scene_of_stack(case.stack)), 8
    height, b_over_h = reference_element_height_and_b_over_h(model.scene)
    orientations = (case.orientation_deg + 45.0 * np.arange(together)) % 360.0
    cases = Cases(orientations, height, b_over_h, case.stack.friction)
    steps = plan_simulation(
        model, case.part_of_scaled_record_that_can_move_a_stone, cases, NumericalOptions()
    ).steps_per_sample[0]
    begin = time.process_time()
    found = simulate_cases(
        model,
        case.part_of_scaled_record_that_can_move_a_stone,
        cases,
        NumericalOptions(
            time_step=step_to_automatic_step_ratio
            * case.part_of_scaled_record_that_can_move_a_stone.sampling_interval
            / float(steps)
        ),
    )
    seconds = (time.process_time() - begin) / together
    fell = CaseStatus(found.status[0]).trajectory_has_known_outcome and found.overturned[0, -1] == 1
    return float(found.fall_azimuth[0, -1]) if fell else np.nan, seconds


def fall_azimuth_and_processor_time_in_solver(
    solver_name: str, time_step: float, case: StackUnderScaledRecord
) -> tuple[float, float]:
    """Return the fall azimuth, degrees (NaN if the topmost stone stands), and the processor time of a case, s."""
    if solver_name == PROGRAM_LABEL:
        return fall_azimuth_and_processor_time_in_program(case, time_step)
    begin = time.process_time()
    found = topmost_stone_outcome_in_engine(
        STACK_ENGINES[solver_name],
        case.stack,
        case.part_of_scaled_record_that_can_move_a_stone,
        case.orientation_deg,
        time_step,
    )
    return found.fall_azimuth_deg, time.process_time() - begin


def run_solver_with_all_steps(solver_name: str, process_count: int) -> pd.DataFrame:
    """Run all cases in a solver with each of its time steps; return one row per case and time step."""
    cases = draw_random_stack_cases()[:COMPARED_CASE_COUNT]
    fall_azimuth_and_processor_time_in_program(cases[0], 1.0)  # compiles the kernel
    with ProcessPoolExecutor(process_count) as pool:
        made = [
            list(pool.map(partial(fall_azimuth_and_processor_time_in_solver, solver_name, step), cases))
            for step in TIME_STEPS_BY_SOLVER_S_OR_AUTO_STEP_SHARE[solver_name]
        ]
    return pd.DataFrame([
        {"solver": solver_name, "step": step, "case": number, "fall_azimuth_deg": azimuth, "seconds": seconds}
        for step, found in zip(TIME_STEPS_BY_SOLVER_S_OR_AUTO_STEP_SHARE[solver_name], made, strict=True)
        for number, (azimuth, seconds) in enumerate(found)
    ])  # fmt: skip


def error_against_run_time_table(rows_by_case_and_time_step: pd.DataFrame) -> str:
    """Return a Markdown table: time per case, wrong flags and wrong azimuths, by solver and time step."""
    lines = []
    for solver, steps in TIME_STEPS_BY_SOLVER_S_OR_AUTO_STEP_SHARE.items():
        mine = rows_by_case_and_time_step[rows_by_case_and_time_step["solver"] == solver]
        reference = mine[mine["step"] == steps[-1]]["fall_azimuth_deg"].to_numpy()
        for step in steps[:-1]:
            chosen = mine[mine["step"] == step]
            azimuths = chosen["fall_azimuth_deg"].to_numpy()
            both = np.isfinite(azimuths) & np.isfinite(reference)
            away = [not outcomes_agree(*pair) for pair in zip(azimuths[both], reference[both], strict=True)]
            label = f"{step:g} of the automatic step" if solver == PROGRAM_LABEL else f"{1e3 * step:g} ms"
            lines.append((
                solver, label, f"{1e3 * chosen['seconds'].mean():.3g} ms",
                share_text_with_counts_and_wilson_interval(int((np.isfinite(azimuths) != np.isfinite(reference)).sum()),
                len(azimuths)),
                share_text_with_counts_and_wilson_interval(sum(away), len(away)),
            ))  # fmt: skip
    return markdown_table(
        ("solver", "time step", "time per case", "wrong flags (95 %)", "azimuths off by more than 20° (95 %)"), lines
    )


def main(
    solvers: Annotated[list[str] | None, typer.Argument(help="solvers to run; default: all")] = None,
    processes: Annotated[int, typer.Option(min=1, help="number of processes")] = 1,
) -> None:
    """Measure the errors of stack outcomes against run time, and write the table of docs/validation.md."""
    kept = pd.read_csv(RESULT_TABLE_PATH) if RESULT_TABLE_PATH.is_file() else pd.DataFrame()
    for solver in named_parts_or_all_if_none(solvers, TIME_STEPS_BY_SOLVER_S_OR_AUTO_STEP_SHARE):
        if solver != PROGRAM_LABEL and find_spec(MODULE_NAME_BY_STACK_ENGINE[solver]) is None:
            raise ArgumentError(f"{solver} is not installed: make peers")
        others = kept[kept["solver"] != solver] if len(kept) else kept
        kept = pd.concat([others, run_solver_with_all_steps(solver, processes)], ignore_index=True)
        write_csv(kept, RESULT_TABLE_PATH)
    update_marked_tables_and_sentences_in_docs({"stack-precision": error_against_run_time_table(kept)})


if __name__ == "__main__":
    typer.run(main)
