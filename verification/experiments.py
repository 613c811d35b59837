"""`python -m verification.experiments [NAME ...]`: measurements behind the choice of contact, step and clock.

Each experiment runs several settings for cases of the default study, compares the results with a reference and writes
its tables between markers in docs/measurements.md.
"""

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple
from unittest.mock import patch

import numpy as np
import pandas as pd
import typer
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.dem.block.state import MAX_SIMULATED_FRICTION_COEFFICIENT
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import (
    DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO,
    DEFAULT_CONTACT_DAMPING_RATIO,
    Contact,
    VertexContact,
)
from overturning.model.scene import gravestone
from overturning.model.shapes import RectangularPrism
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from verification.inputs import (
    FRICTION_PREVENTING_SLIDING,
    CaseGroup,
    case_grid,
    default_study_case_groups,
    half_circle_azimuths,
    read_motions_of_default_study,
)
from verification.measures import (
    MIN_COMPARED_PEAK_ROTATION_OVER_ALPHA,
    OverturningFlags,
    differences_from_reference_results,
    percentage,
    run_case_groups,
    wrong_flag_and_flag_or_side_percentages,
)
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    markdown_table,
    named_parts_or_all_if_none,
    update_marked_tables_and_sentences_in_docs,
    wrap_text,
    write_csv,
)
from verification.timing import ResultsWithProcessorTime, run_case_groups_in_subprocess

MarkdownByMarker = dict[str, str]


class PartOfDefaultStudy(NamedTuple):
    """Part of the default study that an experiment runs: some azimuths under every n-th record."""

    azimuth_count: int
    every_nth_record: int
    compared_checkout_folder: Path | None = None
    """Checkout with another state of the sources, for comparison."""
    table_folder: Path = RESULT_TABLE_FOLDER
    """Folder in which the tables are stored."""

    def case_groups(self) -> list[CaseGroup]:
        """Return the cases of this part of the default study, a group for each record."""
        return default_study_case_groups(self.azimuth_count, self.every_nth_record)


def markdown_table_of_named_rows(
    first_column_header: str, cells_by_row_and_column_name: dict[str, dict[str, float]], other_column_headers: list[str]
) -> str:
    """Return a Markdown table with a row per name, its numbers in the columns of `other_column_headers`."""
    return markdown_table(
        (first_column_header, *other_column_headers),
        [(name, *(row[head] for head in other_column_headers)) for name, row in cells_by_row_and_column_name.items()],
    )


SCHEMES_AND_SHARES_OF_LONGEST_STEP: Final = [("centred", share) for share in (0.0625, 0.125, 0.25, 0.5, 0.75, 1.0)] + [
    ("cundall", share) for share in (0.25, 0.5, 0.9)
]
"""Schemes with shares of their longest step; the automatic step of the centred scheme is its longest."""
FINEST_STEP_RUN_ARGUMENTS: Final[dict[str, Any]] = {"scheme": "centred", "time_step": "0.03125 stable"}
BOUNDARY_SHIFT_COLUMN: Final = "shift of the boundary, %"
ERROR_COLUMN_TITLES: Final = [
    "median error of peak rotation",
    BOUNDARY_SHIFT_COLUMN,
    "wrong flags, %",
    "wrong sides, %",
]


def measure_error_by_scheme_and_step(study_part: PartOfDefaultStudy) -> MarkdownByMarker:
    """Measure error and cost by scheme and time step, on which the choice of the defaults is based."""
    groups = study_part.case_groups()
    ratios = np.unique(groups[0].cases.b_over_h)
    shape = (len(groups), study_part.azimuth_count, -1, ratios.size, np.unique(groups[0].cases.friction).size)

    def overturning_boundary_b_over_h(overturned_flags: OverturningFlags) -> FloatArray:
        """Return the B/H below which the block falls, from the number of falling cells along B/H."""
        return np.asarray(ratios[0] + (overturned_flags.reshape(shape) != 0).sum(axis=3) * (ratios[1] - ratios[0]))

    exact, rows = run_case_groups(groups, threads=2, **FINEST_STEP_RUN_ARGUMENTS).results, []
    right = overturning_boundary_b_over_h(exact.overturned)
    for scheme, share in SCHEMES_AND_SHARES_OF_LONGEST_STEP:
        found, seconds = run_case_groups(groups, threads=2, scheme=scheme, time_step=f"{share} stable")
        far = differences_from_reference_results(found, exact)
        shift = (np.abs(overturning_boundary_b_over_h(found.overturned) - right) / right)[right > ratios[0]]
        rows.append(
            {"scheme": scheme, "step": share, "cases": far.counts_of_all_cases.cases}
            | far.cost_and_error_columns(seconds)
            | {BOUNDARY_SHIFT_COLUMN: round(100 * float(shift.mean()), 3)}
        )
        print(rows[-1], flush=True)
    curve = pd.DataFrame(rows)
    write_csv(curve, study_part.table_folder / "default-step.csv")
    shown = ["scheme", "step", "processor time, s", *ERROR_COLUMN_TITLES, "marked", "largest energy error"]
    return {
        "default-step": markdown_table(shown, curve[shown].to_numpy(dtype=object)),
        "equal-error": cost_ratio_table_of_default_to_cundall_scheme(curve),
    }


def cost_ratio_table_of_default_to_cundall_scheme(error_curves: pd.DataFrame) -> str:
    """Return a table of the default scheme's processor time over that of Cundall's scheme at the same error.

    The time of Cundall's scheme at this error is found by log-log interpolation.

    Errors need not decrease with the step: the coarsest step that reaches the error of the default counts.
    """
    default = error_curves[error_curves["scheme"] == "centred"].iloc[-1]
    yardstick, lines = error_curves[error_curves["scheme"] == "cundall"].sort_values("processor time, s"), []
    for head in ERROR_COLUMN_TITLES:
        errors = np.log(yardstick[head].clip(lower=1e-12).to_numpy())
        costs = np.log(yardstick["processor time, s"].to_numpy())
        error = np.log(max(default[head], 1e-12))
        reached = np.flatnonzero(errors <= error)
        # Beyond the ends of the curve the nearest end counts, which understates the advantage at a smaller error.
        at, where = (int(reached[0]), "") if reached.size else (errors.size - 1, ", at most")
        cost = costs[at]
        if reached.size and at:
            cost = np.interp(error, errors[[at, at - 1]], costs[[at, at - 1]])
        elif reached.size:
            where = ", at least"
        lines.append((head, f"{default[head]:.3g}", f"1/{np.exp(cost) / default['processor time, s']:.0f}{where}"))
    return markdown_table(
        ("measure of error", "error of the default", "processor time over that of Cundall's scheme"), lines
    )


def measure_wrong_flags_by_step_and_contact(study_part: PartOfDefaultStudy) -> MarkdownByMarker:
    """Measure shares of unstable cases and of wrong overturning flags by time step, contact stiffness and damping."""
    groups, lines = study_part.case_groups(), []
    steps = {"automatic": "auto"} | {f"{share:g}": f"{share} stable" for share in (0.25, 0.5, 0.75, 1.0)}
    for penetration in (2e-3, 2e-4, 2e-5, 2e-6, 1e-7):
        for ratio in (0.02, 0.1, 0.25, 1.0, 4.0):
            given: dict[str, Any] = {"model": gravestone(Contact(static_penetration=penetration, damping_ratio=ratio))}
            exact = run_case_groups(groups, threads=2, time_step="0.125 stable", **given).results
            own = differences_from_reference_results(exact, exact)
            computed = (
                own.counts_of_cases_simulated_in_reference.cases + own.counts_of_cases_simulated_in_reference.unanswered
            )
            cells = [f"{percentage(own.count_of_cases_with_unstable_status, computed):.2f}"]
            for step in steps.values():
                far = differences_from_reference_results(
                    run_case_groups(groups, threads=2, time_step=step, **given).results, exact
                )
                cells.append(
                    f"{percentage(far.count_of_cases_with_unstable_status, computed):.2f} / "
                    f"{wrong_flag_and_flag_or_side_percentages(far.counts_of_cases_simulated_in_reference)[0]:.2f}"
                )
            lines.append((f"{penetration:g}", f"{ratio:g}", *cells))
            print(*lines[-1], flush=True)
    cells_of = markdown_table(("δ/B", "ξ", "0.125", *steps), lines)
    about = (
        f"Each row of the table of steps and contacts has {computed} cases, under {len(groups)} records along "
        f"{study_part.azimuth_count} azimuths, in which the shaking is strong enough to move the block."
    )
    return {"step-and-contact": f"{cells_of}\n\n{wrap_text(about)}"}


STEP_CONTROL_CHANGE_CODE_TEMPLATE: Final = (
    "from overturning.dem.kernel import clock; clock.BLOCK_STEP_CONTROL = clock.BLOCK_STEP_CONTROL._replace({}={})"
)
SHORTEST_STEP_TIMES_OMEGA_CODE_TEMPLATE: Final = STEP_CONTROL_CHANGE_CODE_TEMPLATE.format(
    "max_contact_change_step_times_omega", "{}"
)
STEPS_BEFORE_DOUBLING_CODE_TEMPLATE: Final = STEP_CONTROL_CHANGE_CODE_TEMPLATE.format(
    "steps_before_doubling_after_contact_change", "{}"
)
STEP_CONTROL_CHANGE_CODE_BY_NAME: Final = {
    "unchanged": "",
    "finest step half as long": SHORTEST_STEP_TIMES_OMEGA_CODE_TEMPLATE.format(0.04),
    "finest step twice as long": SHORTEST_STEP_TIMES_OMEGA_CODE_TEMPLATE.format(0.16),
    "finest step four times as long": SHORTEST_STEP_TIMES_OMEGA_CODE_TEMPLATE.format(0.32),
    "finest step eight times as long": SHORTEST_STEP_TIMES_OMEGA_CODE_TEMPLATE.format(0.64),
    "every change in a finest step": (
        "from overturning.dem.block import state; state.MAX_CONTACT_CHANGE_TRAVEL_OVER_B_P_ALPHA_MIN_DT *= 0"
    ),
    "four steps of each length": STEPS_BEFORE_DOUBLING_CODE_TEMPLATE.format(4.0),
    "sixteen steps of each length": STEPS_BEFORE_DOUBLING_CODE_TEMPLATE.format(16.0),
    "one step of each length above eight finest steps": STEP_CONTROL_CHANGE_CODE_TEMPLATE.format(
        "long_steps_before_doubling", 1.0
    ),
    "whole steps while standing": (
        "from overturning.dem.block import state; state.MIN_OMEGA_DT_FOR_STANDING_STEPS_OF_ONE_SAMPLE *= 1e9"
    ),
    "no step repeated at the same length, only halved": STEP_CONTROL_CHANGE_CODE_TEMPLATE.format(
        "max_repetitions_with_corrected_sliding", 0.0
    ),
}
"""Statements that change one rule of the clock before the kernel is imported, by name."""


def measure_effects_of_step_control_rules(study_part: PartOfDefaultStudy) -> MarkdownByMarker:
    """Measure error and cost with one rule of the step control changed at a time, each change in its own process."""
    groups, rows = study_part.case_groups(), {}
    exact = run_case_groups(groups, threads=2, time_step="0.125 stable").results
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, before) in enumerate(STEP_CONTROL_CHANGE_CODE_BY_NAME.items()):
            (found,) = run_case_groups_in_subprocess(
                groups, [{}], statements_before_import=before, NUMBA_CACHE_DIR=f"{folder}/{number}"
            )
            rows[name] = differences_from_reference_results(found.results, exact).cost_and_error_columns(
                found.processor_time_s
            )
            print(name, rows[name], flush=True)
    return {"fine-steps": markdown_table_of_named_rows("", rows, list(next(iter(rows.values()))))}


def measure_error_by_stiffness_and_step(study_part: PartOfDefaultStudy) -> MarkdownByMarker:
    """Measure error and cost by contact stiffness and time step, and the share of chaotic cases.

    The outcome of a chaotic case changes with a tiny change of amplitude, stiffness or step.
    """
    groups = study_part.case_groups()
    # A change in the ninth digit, below the accuracy of any record.
    moved = [CaseGroup(motion.scaled_by(1 + 1e-9), cases) for motion, cases in groups]

    def run_with_penetration(
        static_penetration_to_width_ratio: float, case_groups: list[CaseGroup] = groups, **how: Any
    ) -> ResultsWithProcessorTime:
        """Run groups of cases on contacts with a given static penetration over the width of the block."""
        return run_case_groups(
            case_groups, model=gravestone(Contact(static_penetration=static_penetration_to_width_ratio)), **how
        )

    def wrong_flag_and_wrong_flag_or_side_percent_texts(
        compared_results: ResultsWithProcessorTime, reference_results: ResultsWithProcessorTime
    ) -> tuple[str, ...]:
        """Return the percentages of cases with a wrong flag and with a wrong flag or side, as texts."""
        return tuple(
            f"{share:.2f}"
            for share in wrong_flag_and_flag_or_side_percentages(
                differences_from_reference_results(
                    compared_results.results, reference_results.results
                ).counts_of_all_cases
            )
        )

    steps = {"0.125": "0.125 stable", "0.25": "0.25 stable", "0.5": "0.5 stable", "auto": "auto"}
    reference = (2e-8, "0.125")
    exact, lines, costs = run_with_penetration(reference[0], time_step=steps[reference[1]]), [], {}
    if study_part.compared_checkout_folder is not None:
        (before,) = run_case_groups_in_subprocess(groups, [{}], checkout_folder=study_part.compared_checkout_folder)
        costs["of the other checkout"] = differences_from_reference_results(
            before.results, exact.results
        ).cost_and_error_columns(before.processor_time_s)
    for penetration in (2e-5, 2e-6, 5e-7, DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, 2e-8):
        found = {
            name: exact if (penetration, name) == reference else run_with_penetration(penetration, time_step=step)
            for name, step in steps.items()
        }
        cells = (
            "–" if one is exact else " / ".join(wrong_flag_and_wrong_flag_or_side_percent_texts(one, exact))
            for one in found.values()
        )
        lines.append((f"{penetration:g}", *cells))
        costs[f"{penetration:g}"] = differences_from_reference_results(
            found["auto"].results, exact.results
        ).cost_and_error_columns(found["auto"].processor_time_s)
        print(lines[-1], costs[f"{penetration:g}"], flush=True)
    own, finer = (
        run_with_penetration(DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO),
        run_with_penetration(DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, refinement=8),
    )
    stiffer = run_with_penetration(DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO / 4)
    pairs = {
        "default, and time step / 8": (own, finer),
        "default, and contact stiffness × 4": (own, stiffer),
        "time step / 8, and time step / 16": (
            finer,
            run_with_penetration(DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, refinement=16),
        ),
        "contact stiffness × 4, and contact stiffness × 16": (
            stiffer,
            run_with_penetration(DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO / 16),
        ),
        "default, and default with amplitude × (1 + 1e-9)": (
            own,
            run_with_penetration(DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, moved),
        ),
        "time step / 8, and time step / 8 with amplitude × (1 + 1e-9)": (
            finer,
            run_with_penetration(DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, moved, refinement=8),
        ),
    }
    heads = ["million block steps", "processor time, s", *ERROR_COLUMN_TITLES[2:], ERROR_COLUMN_TITLES[0], "marked"]
    return {
        "rigid-limit": markdown_table_of_named_rows("δ/B", costs, heads),
        "rigid-limit-map": markdown_table(("δ/B", *steps), lines),
        "chaos": markdown_table(
            ("between", "flags that differ, %", "sides that differ, %"),
            [(name, *wrong_flag_and_wrong_flag_or_side_percent_texts(*pair)) for name, pair in pairs.items()],
        ),
    }


class FallSidesPeakRotationsAndStepCounts(NamedTuple):
    """Results of a kernel for the cases of all motions, in order: sides, peak rotations over α, and steps."""

    fall_sides: NDArray[Any]
    peak_rotations_over_alpha: FloatArray
    step_count_by_case: NDArray[Any]


def simulate_blocks_with_block_or_scene_kernel(
    group: CaseGroup, damping_ratio: float, use_scene_kernel: bool
) -> FallSidesPeakRotationsAndStepCounts:
    """Run blocks with the 2-D kernel for single blocks or, if `use_scene_kernel`, with that for scenes."""
    found = simulate_cases(
        gravestone(Contact(damping_ratio=damping_ratio)), *group, NumericalOptions(general=use_scene_kernel)
    )
    return FallSidesPeakRotationsAndStepCounts(
        found.overturned.ravel(), np.asarray(found.peak_rotation.ravel(), np.float64), found.block_steps
    )


def simulate_square_prisms_facing_motion(group: CaseGroup, damping_ratio: float) -> FallSidesPeakRotationsAndStepCounts:
    """Simulate 3-D square prisms with one face perpendicular to the motion.

    For each case the motion is reduced to its component along the azimuth of the case.
    """
    parts, cases = [], group.cases
    for azimuth in np.unique(cases.azimuth_deg):
        chosen, along = np.asarray(cases.azimuth_deg) == azimuth, group.motion.acceleration_along(float(azimuth))
        ahead = Motion(along, 0.0 * along, sampling_interval=group.motion.sampling_interval)
        shapes = Cases(
            0.0, np.asarray(cases.height)[chosen], np.asarray(cases.b_over_h)[chosen], FRICTION_PREVENTING_SLIDING
        )
        contact = VertexContact(damping_ratio=damping_ratio)
        found = simulate_cases(Body(RectangularPrism(), contact), ahead, shapes)
        side = np.where(np.cos(np.radians(found.fall_azimuth)) > 0, 1, -1)
        parts.append((np.where(found.overturned == 1, side, found.overturned), found.peak_tilt, found.block_steps))
    sides, tilts, steps = (np.concatenate(part) for part in zip(*parts, strict=True))
    return FallSidesPeakRotationsAndStepCounts(sides, np.radians(tilts) / np.arctan(np.asarray(cases.b_over_h)), steps)


def compare_with_housner_block_by_damping_ratio(study_part: PartOfDefaultStudy) -> MarkdownByMarker:
    """Compare blocks that do not slide with Housner's block, for several damping ratios, in three kernels.

    The kernels are those for single blocks, for scenes and for 3-D bodies. An overturning flag is firm if it does not
    change under a motion 1 % weaker or stronger. A peak rotation is wrong if its error exceeds 0.01 α. Blocks are
    squat from B/H = 0.4.
    """
    cases = case_grid(np.arange(1.24, 180.0, 15.0), [0.6, 1.6], np.arange(0.1, 0.51, 0.05), FRICTION_PREVENTING_SLIDING)
    groups = [
        CaseGroup(motion, cases)
        for motion in list(read_motions_of_default_study().values())[:: study_part.every_nth_record]
    ]
    kernels: dict[str, Callable[[CaseGroup, float], FallSidesPeakRotationsAndStepCounts]] = {
        "kernel for single blocks": partial(simulate_blocks_with_block_or_scene_kernel, use_scene_kernel=False),
        "general kernel": partial(simulate_blocks_with_block_or_scene_kernel, use_scene_kernel=True),
        "3-D kernel": simulate_square_prisms_facing_motion,
    }
    weaker, exact, stronger = (
        [simulate_rigid_rocking(motion.scaled_by(factor), cases) for motion, _ in groups]
        for factor in (0.99, 1.0, 1.01)
    )
    side, peak = (np.concatenate(part) for part in zip(*exact, strict=True))
    firm = np.all([np.concatenate([one.overturned for one in other]) == side for other in (weaker, stronger)], axis=0)
    rocks = firm & (side == 0) & (peak > MIN_COMPARED_PEAK_ROTATION_OVER_ALPHA)
    squat = np.tile(np.asarray(cases.b_over_h) > 0.39, len(groups))
    lines = []
    for damping in (0.5, 1.0, 2.0, DEFAULT_CONTACT_DAMPING_RATIO, 4.0, 6.0, 10.0):
        cells = [f"{damping:g}"]
        for kernel in kernels.values():
            found = FallSidesPeakRotationsAndStepCounts(
                *map(np.concatenate, zip(*(kernel(group, damping) for group in groups), strict=True))
            )
            stands, away = rocks & (found.fall_sides == 0), np.abs(found.peak_rotations_over_alpha - peak)
            off = (f"{percentage((away[of] > 0.01).sum(), of.sum()):.1f}" for of in (stands, stands & squat))
            wrong, spent = (firm & (found.fall_sides != side)).sum(), found.step_count_by_case.sum() / 1e6
            cells.append(" / ".join([f"{wrong}", *off, f"{np.median(away[stands]):.2g}", f"{spent:.1f}"]))
        lines.append(tuple(cells))
        print(lines[-1], flush=True)
    about = (
        f"{firm.sum()} of {firm.size} blocks are firm. {rocks.sum()} of the firm blocks rock without falling; "
        f"{(rocks & squat).sum()} of these {rocks.sum()} blocks are squat (B/H of at least 0.4)."
    )
    return {"damping-ratio": markdown_table(("ξ", *kernels), lines) + f"\n\n{wrap_text(about)}"}


FRICTIONS_FROM_KERNEL_MAXIMUM_UPWARDS: Final = (MAX_SIMULATED_FRICTION_COEFFICIENT, 300.0, 1e3, 1e4, 1e6)
"""Frictions from `MAX_SIMULATED_FRICTION_COEFFICIENT`, the largest that blocks are computed with."""


def measure_effect_of_friction_above_simulated_limit(study_part: PartOfDefaultStudy) -> MarkdownByMarker:
    """Measure the effect of friction above `MAX_SIMULATED_FRICTION_COEFFICIENT` on results and number of steps."""
    shapes = half_circle_azimuths(study_part.azimuth_count), [0.6, 2.0], np.arange(0.1, 0.61, 0.1)
    motions, lines, first = list(read_motions_of_default_study().values())[:: study_part.every_nth_record], [], None
    with patch("overturning.dem.block.plan.MAX_SIMULATED_FRICTION_COEFFICIENT", np.inf):
        for friction in FRICTIONS_FROM_KERNEL_MAXIMUM_UPWARDS:
            groups = [CaseGroup(motion, case_grid(*shapes, friction)) for motion in motions]
            found = run_case_groups(groups, threads=2).results
            first = found if first is None else first
            steps = found.block_steps.sum() / first.block_steps.sum()
            far = differences_from_reference_results(found, first).counts_of_all_cases
            unbalanced = percentage((found.status == CaseStatus.UNSTABLE).sum(), found.status.size)
            lines.append(
                (
                    f"{friction:g}",
                    f"{steps:.2f}",
                    f"{unbalanced:.1f}",
                    *(f"{one:.2f}" for one in wrong_flag_and_flag_or_side_percentages(far)),
                )
            )
            print(*lines[-1], flush=True)
    heads = ("μ", "steps", "unstable, %", "flags that differ, %", "sides that differ, %")
    about = (
        f"Each row of the table of friction coefficients has {far.cases + far.unanswered} cases under {len(motions)} "
        "records; the column *steps* gives the number of time steps, divided by the number in the first row."
    )
    return {"most-friction": f"{markdown_table(heads, lines)}\n\n{wrap_text(about)}"}


FUNCTION_AND_STUDY_PART_BY_EXPERIMENT: Final[
    dict[str, tuple[Callable[[PartOfDefaultStudy], MarkdownByMarker], PartOfDefaultStudy]]
] = {
    "default-step": (measure_error_by_scheme_and_step, PartOfDefaultStudy(2, 1)),
    "step-and-contact": (measure_wrong_flags_by_step_and_contact, PartOfDefaultStudy(4, 10)),
    "fine-steps": (measure_effects_of_step_control_rules, PartOfDefaultStudy(6, 4)),
    "rigid-limit": (measure_error_by_stiffness_and_step, PartOfDefaultStudy(18, 4)),
    "damping-ratio": (compare_with_housner_block_by_damping_ratio, PartOfDefaultStudy(12, 4)),
    "most-friction": (measure_effect_of_friction_above_simulated_limit, PartOfDefaultStudy(18, 4)),
}
"""Experiment and the part of the default study that it runs, by name."""


def main(
    names: Annotated[
        list[str] | None, typer.Argument(help=f"{', '.join(FUNCTION_AND_STUDY_PART_BY_EXPERIMENT)}; default: all")
    ] = None,
    checkout: Annotated[Path | None, typer.Option(help="checkout with other sources, for a row of rigid-limit")] = None,
    trial: Annotated[
        bool, typer.Option(help="run two records and one azimuth; print the tables without storing them")
    ] = False,
) -> None:
    """Run experiments and write the tables into the docs."""
    for name in named_parts_or_all_if_none(names, FUNCTION_AND_STUDY_PART_BY_EXPERIMENT):
        measure, study_part = FUNCTION_AND_STUDY_PART_BY_EXPERIMENT[name]
        if trial:
            study_part = PartOfDefaultStudy(1, 14, table_folder=ROOT / "results" / "trial")
            print(*measure(study_part._replace(compared_checkout_folder=checkout)).values(), sep="\n\n")
            continue
        update_marked_tables_and_sentences_in_docs(measure(study_part._replace(compared_checkout_folder=checkout)))


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    typer.run(main)
