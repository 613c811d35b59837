"""Agreement of this program with MuJoCo and LMGC90 on stacks of two and three stones."""

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, Final

import numpy as np
import pandas as pd

from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.stack import Stack
from overturning.model.status import CaseStatus
from overturning.motion.direction import angle_between_azimuths
from overturning.study.ensemble import wilson_95_percent_interval
from verification.stack_cases import (
    StackUnderScaledRecord,
    case_parameters_as_table_row,
    draw_random_stack_cases,
    scene_of_stack,
)
from verification.stack_engines import STACK_ENGINES, critical_angle
from verification.tables import (
    RESULT_TABLE_FOLDER,
    markdown_table,
    update_marked_tables_and_sentences_in_docs,
    write_csv,
)

MAX_AZIMUTH_DIFFERENCE_DEG: Final = 20.0
"""Difference of two fall azimuths, degrees, up to which they agree."""
RELATIVE_AMPLITUDE_CHANGE_OF_ROBUST_CASE: Final = 0.01
"""Change of amplitude under which a robust case keeps its outcome."""
RELATIVE_AMPLITUDE_CHANGES_TO_MATCH_OTHER_SOLVER: Final = (0.002, 0.005, 0.01, 0.02, 0.03, 0.05)
"""Changes of amplitude that are searched for the outcome of another solver."""
MIN_DISAGREEMENT_CAUSING_SLIP_TO_WIDTH_RATIO: Final = 0.1
"""Slip of a standing stone, as a share of the width of its patch, that counts as a cause."""
LARGE_CORNER_PENETRATION_TO_WIDTH_RATIO: Final = 0.01
"""Sinking of a corner into the stone below, as a share of the shaft's width, that counts as a fault of a solver."""
OUTCOME_FILE_BY_SOLVER: Final = {
    name: RESULT_TABLE_FOLDER / f"stack-peers-{name.lower()}.csv" for name in STACK_ENGINES
}
"""Stored outcomes of each solver."""
AGREEMENT_TABLE_FILE: Final = RESULT_TABLE_FOLDER / "stack-peers.csv"
PROGRAM_LABEL: Final = "this program"
NO_OUTCOME_TEXT: Final = "none"
"""Text for a case that a solver did not run, or for which this program has no outcome."""
CASE_PARAMETER_COLUMNS: Final = ["case", "record", "orientation_deg", "amplitude", "friction", "sizes"]


def outcomes_agree(first_fall_azimuth_deg: float, second_fall_azimuth_deg: float) -> bool:
    """True if two outcomes agree: both stand (NaN), or both fall to azimuths within 20°."""
    if math.isnan(first_fall_azimuth_deg) or math.isnan(second_fall_azimuth_deg):
        return math.isnan(first_fall_azimuth_deg) and math.isnan(second_fall_azimuth_deg)
    return angle_between_azimuths(first_fall_azimuth_deg, second_fall_azimuth_deg) <= MAX_AZIMUTH_DIFFERENCE_DEG


def topmost_stone_outcomes_in_this_program(
    case: StackUnderScaledRecord, amplitude_factors: Sequence[float]
) -> list[dict[str, Any]]:
    """Return the outcome of the topmost stone in this program for each factor on the motion of a case.

    An outcome has the fall azimuth (degrees; NaN if it stands), the status, and whether any stone slides off.
    """
    model, cases = Stack(scene_of_stack(case.stack)), len(amplitude_factors)
    height, b_over_h = reference_element_height_and_b_over_h(model.scene)
    grid = Cases(
        case.orientation_deg, height, b_over_h, np.full(cases, case.stack.friction), np.array(amplitude_factors)
    )
    found = simulate_cases(model, case.part_of_scaled_record_that_can_move_a_stone, grid, NumericalOptions())
    fell = found.overturned[:, -1] == 1
    azimuths = np.where(fell, found.fall_azimuth[:, -1], np.nan).tolist()
    rows = zip(azimuths, found.status.tolist(), (found.slid_off == 1).any(axis=1).tolist(), strict=True)
    return [{"fall_azimuth_deg": azimuth, "status": status, "slid_off": int(slid)} for azimuth, status, slid in rows]


def trajectory_has_known_outcome(topmost_stone_outcome: dict[str, Any]) -> bool:
    """True if this program states whether the topmost stone falls."""
    return CaseStatus(topmost_stone_outcome["status"]).trajectory_has_known_outcome


def outcome_and_robustness_in_this_program(case: StackUnderScaledRecord) -> dict[str, Any]:
    """Return the outcome of a case in this program, and whether it is robust: the same with ±1 % of amplitude.

    A case without an outcome at one of the three amplitudes is not robust.
    """
    factors = (1.0, 1.0 - RELATIVE_AMPLITUDE_CHANGE_OF_ROBUST_CASE, 1.0 + RELATIVE_AMPLITUDE_CHANGE_OF_ROBUST_CASE)
    nominal, *others = topmost_stone_outcomes_in_this_program(case, factors)
    changed = [
        f"amplitude × {factor:g}"
        for factor, other in zip(factors[1:], others, strict=True)
        if not (
            trajectory_has_known_outcome(other)
            and outcomes_agree(other["fall_azimuth_deg"], nominal["fall_azimuth_deg"])
        )
    ]
    changed = changed if trajectory_has_known_outcome(nominal) else [NO_OUTCOME_TEXT]
    return nominal | {"robust": int(not changed), "changed_by": " ".join(changed[:1])}


def amplitude_change_percent_to_reach_azimuth(case: StackUnderScaledRecord, fall_azimuth_deg: float) -> float:
    """Return the smallest amplitude change, %, with which this program reaches an outcome; NaN if none does.

    The outcome is a fall of the topmost stone to within 20° of `fall_azimuth_deg`, or, if this is NaN, that it stands.
    The changes of `RELATIVE_AMPLITUDE_CHANGES_TO_MATCH_OTHER_SOLVER` are tried in both directions.
    """
    changes = [sign * change for change in RELATIVE_AMPLITUDE_CHANGES_TO_MATCH_OTHER_SOLVER for sign in (-1.0, 1.0)]
    for change, found in zip(
        changes, topmost_stone_outcomes_in_this_program(case, [1.0 + change for change in changes]), strict=True
    ):
        if trajectory_has_known_outcome(found) and outcomes_agree(found["fall_azimuth_deg"], fall_azimuth_deg):
            return 100.0 * change
    return math.nan


def read_outcomes_of_other_solvers() -> pd.DataFrame:
    """Read the stored outcomes of the other solvers, one row per case; the columns of a solver begin with its name.

    Outcomes that a solver has not computed are NaN.
    """
    found = pd.DataFrame(
        [case_parameters_as_table_row(number, case) for number, case in enumerate(draw_random_stack_cases())]
    )
    for name, path in OUTCOME_FILE_BY_SOLVER.items():
        outcomes = pd.read_csv(path).set_index("case").drop(columns=CASE_PARAMETER_COLUMNS[1:])
        found = found.join(outcomes.add_prefix(f"{name} "), on="case")
    return found


def simulate_and_join_stored_outcomes_of_other_solvers(process_count: int = 2) -> pd.DataFrame:
    """Simulate all cases in this program; return its outcomes and the stored ones of the solvers, one row per case."""
    with ProcessPoolExecutor(process_count) as pool:
        own = pd.DataFrame(
            list(pool.map(outcome_and_robustness_in_this_program, draw_random_stack_cases(), chunksize=10))
        )
    return pd.concat([read_outcomes_of_other_solvers(), own.add_prefix(f"{PROGRAM_LABEL} ")], axis=1)


def outcome_text(outcomes_of_case: pd.Series, solver: str) -> str:
    """Return the outcome in a solver as text: "stands", the fall azimuth, or `NO_OUTCOME_TEXT`.

    An outcome that changes with ±1 % of amplitude, or in the other solvers with half the time step, is in brackets.
    """
    azimuth = outcomes_of_case[f"{solver} fall_azimuth_deg"]
    text = f"{azimuth:.0f}°" if np.isfinite(azimuth) else "stands"
    unresolved = solver == PROGRAM_LABEL and not trajectory_has_known_outcome(
        {"status": outcomes_of_case[f"{PROGRAM_LABEL} status"]}
    )
    if unresolved or pd.isna(outcomes_of_case[f"{solver} robust"]):
        return NO_OUTCOME_TEXT
    return text if outcomes_of_case[f"{solver} robust"] == 1 else f"({text})"


def outcomes_are_known_and_agree(outcomes_of_case: pd.Series, first_solver: str, second_solver: str) -> bool:
    """True if two solvers give the same outcome; a case without an outcome agrees with nothing."""
    return NO_OUTCOME_TEXT not in (
        outcome_text(outcomes_of_case, first_solver),
        outcome_text(outcomes_of_case, second_solver),
    ) and outcomes_agree(
        outcomes_of_case[f"{first_solver} fall_azimuth_deg"], outcomes_of_case[f"{second_solver} fall_azimuth_deg"]
    )


def agreement_counts(
    outcomes_of_all_solvers_by_case: pd.DataFrame, first_solver: str, second_solver: str
) -> dict[str, int]:
    """Return counts of cases for two solvers, by name.

    `cases` are all cases, `falls` those in the second solver, `flags` equal flags, `both` falls in both solvers, and
    `near` those of `both` with azimuths within 20°.
    """
    counts = dict.fromkeys(("cases", "falls", "flags", "both", "near"), 0)
    for _, row in outcomes_of_all_solvers_by_case.iterrows():
        fell = [np.isfinite(row[f"{name} fall_azimuth_deg"]) for name in (first_solver, second_solver)]
        missing = NO_OUTCOME_TEXT in (outcome_text(row, first_solver), outcome_text(row, second_solver))
        both, equal = all(fell) and not missing, fell[0] == fell[1] and not missing
        for name, value in {"cases": True, "falls": fell[1], "flags": equal, "both": both}.items():
            counts[name] += int(value)
        counts["near"] += int(both and outcomes_are_known_and_agree(row, first_solver, second_solver))
    return counts


def smaller_side_of_topmost_stone(stone_sizes_text: str) -> float:
    """Return the smaller side, m, of the topmost stone, from the text of the column of sizes."""
    return min(float(side) for side in stone_sizes_text.split()[-1].split("x")[:2])


def share_text_with_counts_and_wilson_interval(count: int, total: int) -> str:
    """Return a share as text: percent, counts, and the 95 % interval of Wilson."""
    if total == 0:
        return "–"
    low, high = map(float, wilson_95_percent_interval(count, total))
    return f"{100.0 * count / total:.1f} % ({count} of {total}; {100.0 * low:.1f} to {100.0 * high:.1f})"


def agreement_table_rows(outcomes_of_all_solvers_by_case: pd.DataFrame) -> Iterator[Sequence[str]]:
    """Yield the rows of the table of agreement: compared solvers, cases, flags and azimuths."""
    stones = outcomes_of_all_solvers_by_case["sizes"].map(lambda sizes: len(sizes.split()))
    robust = {name: outcomes_of_all_solvers_by_case[f"{name} robust"] == 1 for name in OUTCOME_FILE_BY_SOLVER}
    for name, mask in robust.items():
        yield _agreement_table_row(outcomes_of_all_solvers_by_case[mask], PROGRAM_LABEL, name, f"robust in {name}")
        for count in (2, 3):
            yield _agreement_table_row(
                outcomes_of_all_solvers_by_case[mask & (stones == count)],
                PROGRAM_LABEL,
                name,
                f"… stacks of {count} stones",
            )
        sinks = outcomes_of_all_solvers_by_case[
            f"{name} sinking"
        ] > LARGE_CORNER_PENETRATION_TO_WIDTH_RATIO * outcomes_of_all_solvers_by_case["sizes"].map(
            smaller_side_of_topmost_stone
        )
        if (mask & sinks).any():
            yield _agreement_table_row(
                outcomes_of_all_solvers_by_case[mask & ~sinks], PROGRAM_LABEL, name, f"… no corner sinks in {name}"
            )
    everywhere = outcomes_of_all_solvers_by_case[np.logical_and.reduce(list(robust.values()))]
    first, second = OUTCOME_FILE_BY_SOLVER
    for pair in ((PROGRAM_LABEL, first), (PROGRAM_LABEL, second), (first, second)):
        yield _agreement_table_row(everywhere, *pair, "robust in both solvers")


def _agreement_table_row(
    outcomes_of_chosen_cases: pd.DataFrame, first_solver: str, second_solver: str, case_kind: str
) -> Sequence[str]:
    """Return a row of the table of agreement: two solvers, kind of cases, counts and shares."""
    n = agreement_counts(outcomes_of_chosen_cases, first_solver, second_solver)
    return (
        f"{first_solver}, {second_solver}", case_kind, str(n["cases"]), str(n["falls"]),
        share_text_with_counts_and_wilson_interval(n["flags"], n["cases"]),
        share_text_with_counts_and_wilson_interval(n["near"], n["both"]),
    )  # fmt: skip


def fall_share_and_robustness_rows_by_solver(outcomes_of_all_solvers_by_case: pd.DataFrame) -> Iterator[Sequence[str]]:
    """Yield the rows of the table of randomly drawn cases, one per solver; shares are of the cases with an outcome."""
    for name in (*OUTCOME_FILE_BY_SOLVER, PROGRAM_LABEL):
        ran = outcomes_of_all_solvers_by_case.apply(
            lambda row, name=name: outcome_text(row, name) != NO_OUTCOME_TEXT, axis=1
        )
        fell, robust = (
            np.isfinite(outcomes_of_all_solvers_by_case[f"{name} fall_azimuth_deg"])[ran],
            (outcomes_of_all_solvers_by_case[f"{name} robust"] == 1)[ran],
        )
        seconds = (
            outcomes_of_all_solvers_by_case[f"{name} seconds"].mean() if name in OUTCOME_FILE_BY_SOLVER else math.nan
        )
        yield (
            name, str(int(ran.sum())), f"{100.0 * fell.mean():.0f} %", str(int(robust.sum())),
            f"{100.0 * fell[robust].mean():.0f} %", f"{seconds:.1f}" if np.isfinite(seconds) else "–",
        )  # fmt: skip


def disagreement_cause(outcomes_of_case: pd.Series, case: StackUnderScaledRecord, other_solver: str) -> str:
    """Return why this program and a solver differ on a case whose outcome in the solver is robust, as text.

    An outcome in the solver is robust if it is the same with ±1 % of amplitude and with half the time step.
    """
    other = next(name for name in OUTCOME_FILE_BY_SOLVER if name != other_solver)
    causes = []
    if outcome_text(outcomes_of_case, PROGRAM_LABEL) == NO_OUTCOME_TEXT:
        causes.append(f"no outcome ({CaseStatus(int(outcomes_of_case[f'{PROGRAM_LABEL} status'])).name.lower()})")
    elif outcomes_of_case[f"{PROGRAM_LABEL} robust"] != 1:
        causes.append(f"marginal here ({outcomes_of_case[f'{PROGRAM_LABEL} changed_by']})")
    elif np.isfinite(
        change := amplitude_change_percent_to_reach_azimuth(case, outcomes_of_case[f"{other_solver} fall_azimuth_deg"])
    ):
        causes.append(f"same outcome here with {change:+.1f} % of amplitude")
    if outcomes_of_case[f"{other_solver} sinking"] > LARGE_CORNER_PENETRATION_TO_WIDTH_RATIO * min(
        case.stack.width_depth_height_by_stone[-1][:2]
    ):
        causes.append(f"a corner sinks by {1e3 * outcomes_of_case[f'{other_solver} sinking']:.0f} mm in {other_solver}")
    if slides_off_in_either_or_far_in_other_solver(outcomes_of_case, case, other_solver):
        causes.append("slides")
    if outcome_text(outcomes_of_case, other) == NO_OUTCOME_TEXT:
        return "; ".join(causes) or "unexplained"
    if outcomes_are_known_and_agree(outcomes_of_case, other, PROGRAM_LABEL):
        causes.append(f"{other} agrees with this program")
    elif not outcomes_are_known_and_agree(outcomes_of_case, other, other_solver):
        causes.append(f"{other} differs from both")
    return "; ".join(causes) or f"unexplained: {other} agrees with {other_solver}"


def slides_off_in_either_or_far_in_other_solver(
    outcomes_of_case: pd.Series, case: StackUnderScaledRecord, other_solver: str
) -> bool:
    """True if a stone slides off in this program or in `other_solver`, or slides far while upright in the latter."""
    fallen = int(outcomes_of_case[f"{other_solver} fallen_stone"])
    upright = fallen >= 0 and outcomes_of_case[f"{other_solver} tilt_deg"] < math.degrees(
        critical_angle(case.stack, fallen)
    )
    far = outcomes_of_case[f"{other_solver} slip"] > MIN_DISAGREEMENT_CAUSING_SLIP_TO_WIDTH_RATIO * min(
        case.stack.width_depth_height_by_stone[-1][:2]
    )
    return bool(outcomes_of_case[f"{PROGRAM_LABEL} slid_off"] == 1 or upright or far)


def disagreement_table_rows(outcomes_of_all_solvers_by_case: pd.DataFrame) -> Iterator[Sequence[str]]:
    """Yield a table row for each case that is robust in a solver but has another outcome in this program."""
    cases = draw_random_stack_cases()
    for peer in OUTCOME_FILE_BY_SOLVER:
        for _, row in outcomes_of_all_solvers_by_case[
            outcomes_of_all_solvers_by_case[f"{peer} robust"] == 1
        ].iterrows():
            if not outcomes_are_known_and_agree(row, PROGRAM_LABEL, peer):
                case = cases[row["case"]]
                yield (
                    peer, str(row["case"]), str(len(case.stack.width_depth_height_by_stone)),
                    f"{case.stack.friction:.2f}",
                    *(outcome_text(row, name) for name in (PROGRAM_LABEL, *OUTCOME_FILE_BY_SOLVER)),
                    disagreement_cause(row, case, peer),
                )  # fmt: skip


def publish_agreement_with_solvers() -> None:
    """Compare this program with the stored outcomes; write the table of all cases and the tables of the docs."""
    table = simulate_and_join_stored_outcomes_of_other_solvers()
    write_csv(table, AGREEMENT_TABLE_FILE)
    differ = list(disagreement_table_rows(table))
    drawn = ("", "cases with an outcome", "fall", "robust", "robust ones that fall", "s per case")
    compared = ("compared", "cases", "number", "falls", "same flag (95 %)", "azimuth within 20° (95 %)")
    listed = ("solver", "case", "stones", "µ", PROGRAM_LABEL, *OUTCOME_FILE_BY_SOLVER, "cause")
    tables = (
        markdown_table(drawn, fall_share_and_robustness_rows_by_solver(table)),
        markdown_table(compared, agreement_table_rows(table)),
    )
    update_marked_tables_and_sentences_in_docs({
        "stack-peers": "\n\n".join(tables), "stack-disagreements": markdown_table(listed, differ),
    })  # fmt: skip
