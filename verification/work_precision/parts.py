"""Error against run time: schemes over time steps, springs over stiffness, the exact block, and other engines.

The references are the kernel with a far finer step or with the stiffest springs, Housner's rocking block, the exact
sliding block, and the balance of work and energy.
"""

import itertools
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from overturning.arrays import FloatArray
from overturning.dem.block.rigid import TAYLOR_SERIES_ORDER, simulate_rigid_rocking
from overturning.dem.time_step import AUTO_TO_STABLE_STEP_RATIO, DEFAULT_SCHEME, parse_scheme
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, Contact
from overturning.model.results import CaseResults
from overturning.model.scene import gravestone
from overturning.study.answers import count_outcome_differences
from verification.engines import BLOCK_ENGINES, FallSideOfSingleBlockFunction, fall_side_of_block, installed_engines
from verification.inputs import (
    CaseGroup,
    block_case_groups_under_records,
    groups_with_every_nth_case,
    non_sliding_case_groups_under_records,
    rocking_case_groups_under_sine_pulses,
    sliding_block_case_groups,
    values_of_every_nth_case,
)
from verification.measures import OverturningFlags, median_peak_rotation_error_over_alpha, run_case_groups
from verification.reference.sliding import peak_and_final_slip
from verification.timing import run_and_measure_min_processor_time
from verification.work_precision.boundaries import (
    boundaries_between_falling_and_standing_cases,
    boundary_b_over_h_by_usual_and_finest_numerics,
    median_relative_boundary_shift,
)

ErrorTableRow = dict[str, Any]

COMPARED_SCHEMES: Final = ("centred", "cundall")
TIME_STEPS_AS_SHARES_OF_STABLE_STEP: Final = (1.0, 0.9, 0.5, 0.25, 0.12, 0.06, 0.03, 0.01)
"""Time steps, as Δt/Δt_stable."""
MIN_STEP_TO_STABLE_STEP_IN_CUNDALL_SCHEME: Final = 0.1
"""Smallest Δt/Δt_stable of Cundall's scheme; its stable step is 1/50 of that of the centred scheme by default."""
STATIC_PENETRATION_TO_WIDTH_RATIOS: Final = (2e-3, 2e-4, 2e-5, 2e-6, DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, 2e-8)
"""Static penetrations, as δ/B."""
AUTOMATIC_STEP_TO_STABLE_STEP_RATIO: Final = AUTO_TO_STABLE_STEP_RATIO[parse_scheme(DEFAULT_SCHEME)]
REFERENCE_STEP_TO_STABLE_STEP_RATIO: Final = 0.006
"""Δt/Δt_stable of the reference, which uses the centred scheme."""
MIN_STEP_TO_STABLE_STEP_WITH_ALL_CASES_RUN, CASE_STRIDE_AT_SMALL_TIME_STEPS = 0.05, 3
"""Below this Δt/Δt_stable only every third case is run, to limit the run time to minutes."""
MIN_STEP_TO_STABLE_STEP_FOR_BOUNDARIES: Final = 0.02
"""Below this Δt/Δt_stable no boundary is computed."""
MAX_FALL_BOUNDARIES_PER_RECORD: Final = 4
"""Largest number of boundaries for each record."""
STIFFNESS_STUDY_REFERENCE_TO_STABLE_STEP: Final = 0.03
"""Δt/Δt_stable of the references with other stiffnesses; their errors are far below the effect of the stiffness."""
RELATIVE_HALF_WIDTH_OF_STIFFNESS_STUDY_BRACKET: Final = 0.02
"""Half-width of the bracket for boundaries with other stiffnesses, as a share of B/H."""
EVERY_NTH_CASE_RUN_IN_ENGINES_BY_SET: Final = {"sine pulses": 5, "records, no sliding": 2}
"""The engines run every n-th case of a set, since a case takes at least a hundred times as long as in the kernel."""
ENGINE_TIME_STEPS_S: Final = tuple(1 / 60 / 2**halved for halved in range(7))
"""Time steps of the engines, s: 1 to 64 substeps of 1/60 s, their usual step."""
TAYLOR_SERIES_ORDERS: Final = (2, 3, 4, 6, TAYLOR_SERIES_ORDER, 10)
"""Orders of the series of the exact block."""
REFERENCE_SERIES_ORDER: Final = 16
"""Order of the series of the reference."""

COLUMN_LONG_NAMES_AND_UNITS: Final = {
    "cases_of": ("set of cases", ""),
    "method": ("scheme of the kernel, the exact block, or an engine", ""),
    "against": ("what the error is against", ""),
    "step_fraction": (
        "time step over the stable one; of an engine: in s; of the exact block: order of its series",
        "1",
    ),
    "penetration_ratio": ("static penetration over width", "1"),
    "default": ("1 at the default setting", "1"),
    "seconds_per_case": ("processor time per case, least of the runs", "s"),
    "block_steps_per_case": ("block steps per case", "1"),
    "cases": ("cases with an answer in both", "1"),
    "wrong_flags": ("cases that fall instead of standing, or the reverse", "1"),
    "fallen": ("cases that fall in both", "1"),
    "wrong_sides": ("cases that fall to the wrong side", "1"),
    "unanswered": ("cases without an answer", "1"),
    "shared": ("cases that the engines run too", "1"),
    "disagree": ("of these, cases with another flag or side", "1"),
    "rotation_error": ("median error of peak rotation over the critical angle where the block stands", "1"),
    "boundary_shift": ("median shift of the overturning boundary over B/H", "1"),
    "energy_error": ("mean residual of work and energy", "1"),
    "slip_error": ("largest error of peak slip over peak slip", "1"),
}
"""Long name and unit of the columns."""


def error_table_with_nan_if_not_measured(rows: Sequence[ErrorTableRow]) -> pd.DataFrame:
    """Return rows as a data frame with all columns of the error table; a value that a row lacks is NaN."""
    table = pd.DataFrame(rows, columns=list(COLUMN_LONG_NAMES_AND_UNITS))
    return table.astype({name: np.float64 for name, (_, unit) in COLUMN_LONG_NAMES_AND_UNITS.items() if unit})


class SchemeStepAndPenetration(NamedTuple):
    """Setting of a computation: scheme, time step over the longest stable one, and static penetration over width."""

    scheme: str
    time_step_to_stable_step_ratio: float
    static_penetration_to_width_ratio: float = DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO

    @property
    def run_cases_arguments(self) -> dict[str, Any]:
        """Return this setting as arguments of `run_cases`."""
        contact = Contact(static_penetration=self.static_penetration_to_width_ratio)
        return {
            "scheme": self.scheme,
            "time_step": f"{self.time_step_to_stable_step_ratio:g} stable",
            "model": gravestone(contact),
        }

    def error_table_row(self, case_kind: str, reference_kind: str, **columns: Any) -> ErrorTableRow:
        """Return a table row with this setting, the kind of cases, the kind of reference and further columns."""
        own = {
            "method": self.scheme,
            "step_fraction": self.time_step_to_stable_step_ratio,
            "penetration_ratio": self.static_penetration_to_width_ratio,
        }
        default = self == SchemeStepAndPenetration(DEFAULT_SCHEME, AUTOMATIC_STEP_TO_STABLE_STEP_RATIO)
        return {"cases_of": case_kind, "against": reference_kind, "default": default} | own | columns

    def run_and_measure_cost_per_case(self, groups: Sequence[CaseGroup]) -> tuple[CaseResults, ErrorTableRow]:
        """Run groups of cases with this setting; return results, and the cost per case as columns of the table."""
        found, seconds = run_case_groups(groups, 3, **self.run_cases_arguments)
        count = found.status.size
        return found, {"seconds_per_case": seconds / count, "block_steps_per_case": found.block_steps.sum() / count}


def error_table_columns(
    results: CaseResults, reference_flags_and_rotations_over_alpha: tuple[OverturningFlags, FloatArray]
) -> ErrorTableRow:
    """Return the numbers of wrong flags and sides, and the median error of peak rotation, as columns of the table."""
    error = median_peak_rotation_error_over_alpha(
        results.overturned, results.peak_rotation, *reference_flags_and_rotations_over_alpha
    )
    return wrong_flag_and_side_counts(results.overturned, reference_flags_and_rotations_over_alpha[0]) | {
        "rotation_error": error
    }


def wrong_flag_and_side_counts(flags: OverturningFlags, reference_flags: OverturningFlags) -> ErrorTableRow:
    """Return columns of counts: cases, wrong flags, cases that fall in both, wrong sides, cases without outcome."""
    found = count_outcome_differences(reference_flags, flags).model_dump()
    return {"wrong_flags": found.pop("flags"), "wrong_sides": found.pop("sides"), **found}


def scheme_settings_for_each_time_step(
    min_step_to_stable_step_ratio: float = 0.0, includes_finest_step: bool = True
) -> Iterator[SchemeStepAndPenetration]:
    """Yield settings of both schemes with each time step above a share of the stable one.

    Without `includes_finest_step` the finest step of each scheme is left out.
    """
    for scheme in COMPARED_SCHEMES:
        fractions = [
            share
            for share in TIME_STEPS_AS_SHARES_OF_STABLE_STEP
            if scheme != "cundall" or share >= MIN_STEP_TO_STABLE_STEP_IN_CUNDALL_SCHEME
        ]
        for fraction in fractions[: None if includes_finest_step else -1]:
            if fraction > min_step_to_stable_step_ratio:
                yield SchemeStepAndPenetration(scheme, fraction)


def flags_and_peak_rotations_over_alpha(
    groups: Sequence[CaseGroup], setting: SchemeStepAndPenetration
) -> tuple[OverturningFlags, FloatArray]:
    """Return flags and peak rotations of the cases with a setting, for comparison."""
    found = run_case_groups(groups, **setting.run_cases_arguments).results
    return found.overturned, found.peak_rotation.astype(np.float64)


def measure_errors_against_finer_steps(sliding_or_rocking_blocks: str) -> Iterator[ErrorTableRow]:
    """Measure the errors of both schemes by time step under six real records.

    The reference is the centred scheme at a far finer step.
    """
    groups, finest = (
        block_case_groups_under_records(sliding_or_rocking_blocks),
        SchemeStepAndPenetration("centred", REFERENCE_STEP_TO_STABLE_STEP_RATIO),
    )
    right, few = (
        flags_and_peak_rotations_over_alpha(groups, finest),
        groups_with_every_nth_case(groups, CASE_STRIDE_AT_SMALL_TIME_STEPS),
    )
    right_few = (
        values_of_every_nth_case(groups, right[0], CASE_STRIDE_AT_SMALL_TIME_STEPS),
        values_of_every_nth_case(groups, right[1], CASE_STRIDE_AT_SMALL_TIME_STEPS),
    )
    where = boundaries_between_falling_and_standing_cases(groups, right[0], MAX_FALL_BOUNDARIES_PER_RECORD)
    near, exact = boundary_b_over_h_by_usual_and_finest_numerics(groups, where, {}, finest.run_cases_arguments)
    for setting in scheme_settings_for_each_time_step():
        thin = setting.time_step_to_stable_step_ratio < MIN_STEP_TO_STABLE_STEP_WITH_ALL_CASES_RUN
        found, columns = setting.run_and_measure_cost_per_case(few if thin else groups)
        columns |= error_table_columns(found, right_few if thin else right)
        if setting.time_step_to_stable_step_ratio >= MIN_STEP_TO_STABLE_STEP_FOR_BOUNDARIES:
            columns["boundary_shift"] = median_relative_boundary_shift(
                groups, where, setting.run_cases_arguments, near, exact
            )
        yield setting.error_table_row(f"records, {sliding_or_rocking_blocks}", "finer step", **columns)


def measure_errors_over_stiffness(sliding_or_rocking_blocks: str) -> Iterator[ErrorTableRow]:
    """Measure errors by contact stiffness at the automatic time step.

    References are finer steps with the same and with the largest stiffness.
    """
    groups, stiffest = (
        block_case_groups_under_records(sliding_or_rocking_blocks),
        STATIC_PENETRATION_TO_WIDTH_RATIOS[-1],
    )
    exact = {
        delta: flags_and_peak_rotations_over_alpha(
            groups, SchemeStepAndPenetration("centred", STIFFNESS_STUDY_REFERENCE_TO_STABLE_STEP, delta)
        )
        for delta in STATIC_PENETRATION_TO_WIDTH_RATIOS
        if delta != DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO  # included in the comparison of time steps
    }
    usual = SchemeStepAndPenetration(DEFAULT_SCHEME, AUTOMATIC_STEP_TO_STABLE_STEP_RATIO, stiffest).run_cases_arguments
    slow = SchemeStepAndPenetration(
        "centred", 2 * STIFFNESS_STUDY_REFERENCE_TO_STABLE_STEP, stiffest
    ).run_cases_arguments
    where = boundaries_between_falling_and_standing_cases(
        groups, run_case_groups(groups, **usual).results.overturned, MAX_FALL_BOUNDARIES_PER_RECORD
    )
    near, right = boundary_b_over_h_by_usual_and_finest_numerics(
        groups, where, usual, slow, RELATIVE_HALF_WIDTH_OF_STIFFNESS_STUDY_BRACKET
    )
    for delta in STATIC_PENETRATION_TO_WIDTH_RATIOS:
        setting = SchemeStepAndPenetration(DEFAULT_SCHEME, AUTOMATIC_STEP_TO_STABLE_STEP_RATIO, delta)
        found, spent = setting.run_and_measure_cost_per_case(groups)
        shift = median_relative_boundary_shift(
            groups, where, setting.run_cases_arguments, near, right, RELATIVE_HALF_WIDTH_OF_STIFFNESS_STUDY_BRACKET
        )
        columns = spent | error_table_columns(found, exact[stiffest]) | {"boundary_shift": shift}
        yield setting.error_table_row(f"records, {sliding_or_rocking_blocks}", "stiffest springs", **columns)
        if delta in exact:
            yield setting.error_table_row(
                f"records, {sliding_or_rocking_blocks}",
                "finer step",
                **spent,
                **error_table_columns(found, exact[delta]),
            )


def measure_energy_balance() -> Iterator[ErrorTableRow]:
    """Measure the mean relative residual of work and energy of cases that slide or rock, by scheme and time step."""
    groups = [
        part
        for kind in ("sliding", "rocking")
        for part in groups_with_every_nth_case(block_case_groups_under_records(kind), 6)
    ]
    for setting in scheme_settings_for_each_time_step(includes_finest_step=False):
        found = run_case_groups(groups, **setting.run_cases_arguments).results
        simulated = found.status == 0
        residual = float(np.mean(found.energy_error[simulated]))
        yield setting.error_table_row(
            "records, all", "energy balance", cases=int(simulated.sum()), energy_error=residual
        )


def fall_sides_and_peak_rotations_of_rigid_blocks(
    groups: Sequence[CaseGroup], series_order: int = REFERENCE_SERIES_ORDER, amplitude_factor: float = 1.0
) -> tuple[OverturningFlags, FloatArray]:
    """Return fall sides (±1; 0: stands) and peak rotations over α of Housner's block under scaled motions."""
    found = [
        simulate_rigid_rocking(motion.scaled_by(amplitude_factor), cases, series_order) for motion, cases in groups
    ]
    return np.concatenate([one.overturned for one in found]), np.concatenate([one.peak_rotation for one in found])


def amplitude_robust_cases_and_their_outcomes(
    groups: Sequence[CaseGroup],
) -> tuple[list[CaseGroup], tuple[OverturningFlags, FloatArray]]:
    """Return the cases whose rigid-block outcome does not change with ±1 % of amplitude, and these outcomes."""
    flags, peaks = fall_sides_and_peak_rotations_of_rigid_blocks(groups)
    same = np.all(
        [
            fall_sides_and_peak_rotations_of_rigid_blocks(groups, amplitude_factor=factor)[0] == flags
            for factor in (0.99, 1.01)
        ],
        axis=0,
    )
    of_each = np.split(same, np.cumsum([group.cases.case_count for group in groups])[:-1])
    kept = [group.subset(np.flatnonzero(own)) for group, own in zip(groups, of_each, strict=True)]
    return kept, (flags[same], peaks[same])


def non_sliding_block_groups_by_set() -> dict[str, list[CaseGroup]]:
    """Return the sets of blocks that cannot slide, by name."""
    return {
        "sine pulses": rocking_case_groups_under_sine_pulses(),
        "records, no sliding": non_sliding_case_groups_under_records(),
    }


def measure_errors_against_rigid_rocking() -> Iterator[ErrorTableRow]:
    """Compare the schemes, by time step and stiffness, and the exact block with Housner's rocking block.

    The exact block is compared by order of its series.
    """
    others = [
        SchemeStepAndPenetration(DEFAULT_SCHEME, AUTOMATIC_STEP_TO_STABLE_STEP_RATIO, delta)
        for delta in STATIC_PENETRATION_TO_WIDTH_RATIOS
        if delta != DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO
    ]
    for name, every in non_sliding_block_groups_by_set().items():
        groups, right = amplitude_robust_cases_and_their_outcomes(every)
        for setting in (*scheme_settings_for_each_time_step(0.05), *others):
            found, spent = setting.run_and_measure_cost_per_case(groups)
            common = counts_of_all_and_wrong_cases_engines_simulate(name, groups, found.overturned, right[0])
            yield setting.error_table_row(name, "rigid rocking", **spent, **error_table_columns(found, right), **common)
        for order in TAYLOR_SERIES_ORDERS:
            (flags, peaks), seconds = run_and_measure_min_processor_time(
                partial(fall_sides_and_peak_rotations_of_rigid_blocks, groups, order)
            )
            own = {"method": "exact", "step_fraction": order, "seconds_per_case": seconds / flags.size}
            own |= wrong_flag_and_side_counts(flags, right[0]) | counts_of_all_and_wrong_cases_engines_simulate(
                name, groups, flags, right[0]
            )
            own["rotation_error"] = median_peak_rotation_error_over_alpha(flags, peaks, *right)
            yield {"cases_of": name, "against": "rigid rocking", "default": order == TAYLOR_SERIES_ORDER} | own


def counts_of_all_and_wrong_cases_engines_simulate(
    case_set_key: str, groups: Sequence[CaseGroup], flags: OverturningFlags, reference_flags: OverturningFlags
) -> ErrorTableRow:
    """Return two columns: the number of cases that physics engines also run, and of those with a wrong flag or side.

    `flags` and `reference_flags` have one value per case of all groups: ±1 (side of the fall) or 0 (stands).
    """
    some, known = (
        values_of_every_nth_case(groups, values, EVERY_NTH_CASE_RUN_IN_ENGINES_BY_SET[case_set_key])
        for values in (flags, reference_flags)
    )
    return {"shared": some.size, "disagree": int((some != known).sum())}


def measure_peak_slip_errors_against_exact_block() -> Iterator[ErrorTableRow]:
    """Compare the peak slip of squat blocks with the exact sliding block, over time steps."""
    groups = sliding_block_case_groups()
    exact = np.array([
        peak_and_final_slip(
            group.acceleration_of_case(index),
            group.motion.sampling_interval,
            group.parameters_of_case(index)["friction"],
        )[0]
        for group in groups
        for index in range(group.cases.case_count)
    ])  # fmt: skip
    moved = exact > 1e-3
    for setting in scheme_settings_for_each_time_step(includes_finest_step=False):
        found, spent = setting.run_and_measure_cost_per_case(groups)
        error = float(np.max(np.abs(found.peak_slip[moved].astype(np.float64) / exact[moved] - 1.0)))
        yield setting.error_table_row(
            "sliding blocks", "exact sliding", **spent, cases=int(moved.sum()), slip_error=error
        )


def measure_engine_errors_against_rigid_rocking() -> Iterator[ErrorTableRow]:
    """Compare installed engines, over their time steps, with Housner's block for cases that cannot slide."""
    engines, against = installed_engines(BLOCK_ENGINES), {"against": "rigid rocking", "default": 0}
    if not engines:  # without engines the table has one row that states it
        yield {"cases_of": "sine pulses", "method": "no engine installed", **against}
        return
    for name, every in non_sliding_block_groups_by_set().items():
        kept, right = amplitude_robust_cases_and_their_outcomes(every)
        few, flags = (
            groups_with_every_nth_case(kept, EVERY_NTH_CASE_RUN_IN_ENGINES_BY_SET[name]),
            values_of_every_nth_case(kept, right[0], EVERY_NTH_CASE_RUN_IN_ENGINES_BY_SET[name]),
        )
        for (method, engine), step in itertools.product(engines.items(), ENGINE_TIME_STEPS_S):
            sides, seconds = run_and_measure_min_processor_time(
                partial(_fall_sides_of_blocks_in_engine, engine, few, step),
                1,
                partial(_fall_side_of_case_in_engine, engine, few[0], 0, step),
            )
            own = {"method": method, "step_fraction": step, "seconds_per_case": seconds / sides.size}
            own |= {"shared": sides.size, "disagree": int((sides != flags).sum())}
            yield {"cases_of": name, **against, **own, **wrong_flag_and_side_counts(sides, flags)}


def _fall_sides_of_blocks_in_engine(
    engine: FallSideOfSingleBlockFunction, groups: Sequence[CaseGroup], time_step: float
) -> OverturningFlags:
    """Return the sides to which the blocks of all groups fall in an engine (±1; 0: none)."""
    sides = [
        _fall_side_of_case_in_engine(engine, group, index, time_step)
        for group in groups
        for index in range(group.cases.case_count)
    ]
    return np.array(sides, np.int8)


def _fall_side_of_case_in_engine(
    engine: FallSideOfSingleBlockFunction, group: CaseGroup, case_index: int, time_step: float
) -> int:
    """Return the side to which the block of one case falls in an engine (±1; 0: none)."""
    case, interval = group.parameters_of_case(case_index), group.motion.sampling_interval
    return fall_side_of_block(
        engine,
        group.acceleration_of_case(case_index),
        interval,
        case["height"],
        case["b_over_h"],
        case["friction"],
        time_step,
    )


MEASUREMENT_FUNCTIONS_BY_PART: Final[dict[str, Sequence[Callable[[], Iterator[ErrorTableRow]]]]] = {
    "rocking": [partial(measure_errors_against_finer_steps, "rocking")],
    "sliding": [partial(measure_errors_against_finer_steps, "sliding")],
    "stiffness": [partial(measure_errors_over_stiffness, "rocking"), partial(measure_errors_over_stiffness, "sliding")],
    "rigid": [measure_errors_against_rigid_rocking, measure_peak_slip_errors_against_exact_block],
    "energy": [measure_energy_balance],
    "peers": [measure_engine_errors_against_rigid_rocking],
}
"""Measurements by part; each part is a table that can be computed independently."""
