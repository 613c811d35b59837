"""`make bench`: measure the speed of the kernels; writes a CSV file per machine and tables in the docs.

Rates and the times per case of the sweep are those of the fastest of several runs after a warm-up, within this process.
All other figures are from one run.
"""

import os
import platform
import re
import resource
import tempfile
import time
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer
from numba import njit

from overturning.dem.block.loops import CONSTANTS_AND_LOOP_CREATOR_BY_SCHEME
from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.dem.block.state import STATE_ROW_LAYOUT, TICKS_PER_WHOLE_STEP
from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.dem.time_step import IntegrationScheme
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.scene import gravestone
from overturning.motion.motion import Motion
from overturning.units import DEFAULT_STONE_DENSITY_KG_M3
from verification import scalar
from verification.inputs import (
    FRICTION_PREVENTING_SLIDING,
    case_grid,
    default_study_case_groups,
    read_motions_of_default_study,
)
from verification.measures import (
    differences_from_reference_results,
    join_results,
    percentage,
    run_case_groups,
    wrong_flag_and_flag_or_side_percentages,
)
from verification.tables import (
    RESULT_TABLE_FOLDER,
    MeasuredNumber,
    measured_numbers_table,
    named_parts_or_all_if_none,
    update_marked_tables_and_sentences_in_docs,
    write_measured_numbers,
)
from verification.timing import minimum_processor_time, run_python_program_and_measure_cpu_time
from verification.whole_run import (
    QUANTITY_PREFIX_WITH_FORK_SERVER,
    fork_server_comparison_table,
    measure_whole_run_with_and_without_fork_server,
)


@njit
def _sum_independent_multiply_add_chains(round_count: int) -> float:
    """Run 2048 multiply-adds per round, in 256 independent chains, so that LLVM can compute many at once."""
    values = np.ones(256)
    for _ in range(round_count):
        for j in range(256):
            v = values[j]
            # Loops of four passes, which LLVM unrolls.
            for _q in range(4):
                v = v * 0.999 + 0.1
            for _q in range(4):
                v = v * 0.999 + 0.1
            values[j] = v
    return values.sum()


SOFT_CONTACT = Contact(static_penetration=2e-5)
"""Contact for comparisons with the scalar loop, whose steps shrink with the stiffness."""


def measure_peak_flop_per_second_of_core() -> float:
    """Return the floating-point operations per second of independent, unfused multiplications and additions."""
    rounds = 200_000
    return rounds * 256 * 16 / minimum_processor_time(lambda: _sum_independent_multiply_add_chains(rounds))


def flop_per_block_step(compiled_loop: Any) -> int:
    """Return the floating-point operations of one block step, counted in the machine code.

    The count is that of vector instructions to add, subtract, multiply, divide, and take minima and maxima. Each
    operation occurs once in vector form; the scalar code for blocks beyond the last full vector is not counted.
    """
    assembly = next(iter(compiled_loop.inspect_asm().values()))
    return len(re.findall(r"\bv?(?:add|sub|mul|div|min|max)pd", assembly))


def wrap_loop_for_calls_from_python(inner_loop: Any) -> Any:
    """Wrap a compiled loop, which only compiled code can call, so that Python can call it."""

    @njit
    def advance_blocks(
        marker_whose_type_selects_variant: Any, state: Any, lane_count: int, step_count: int, ticks_per_sample: float
    ) -> None:
        """Advance all blocks in parallel by `step_count` time steps."""
        inner_loop(marker_whose_type_selects_variant, state, lane_count, step_count, ticks_per_sample)

    return advance_blocks


def motion_too_weak_to_overturn() -> Motion:
    """Return a motion of 20 s that overturns no block of the throughput benchmark."""
    t = np.arange(2000) * 0.01
    return Motion(2.0 * np.sin(2 * np.pi * t / 0.7), 0 * t, sampling_interval=0.01)


def scalar_loop_function_and_block_step_count(
    motion: Motion, uses_centred_scheme: bool, block_count: int = 8, steps_per_sample: int = 128
) -> tuple[Callable[[], object], int]:
    """Return a function that runs `block_count` blocks in the scalar loop, and its number of block steps per call."""
    width, height = np.array([0.24]), np.array([0.6])
    stiff, _, dashpot = (
        float(one[0])
        for one in SOFT_CONTACT.corner_stiffness_and_damping_per_mass(width, height, DEFAULT_STONE_DENSITY_KG_M3)
    )
    wave, own = motion.acceleration_along(0.0), (motion.sampling_interval, steps_per_sample, 0.12, 0.3, stiff, dashpot)
    frictions = np.linspace(0.3, 1.0, block_count).tolist()
    return lambda: [
        scalar.peak_rotation_and_steps_by_scalar_loop(uses_centred_scheme, wave, *own, mu) for mu in frictions
    ], block_count * steps_per_sample * (motion.sample_count - 1)


def measure_block_step_throughput() -> list[MeasuredNumber]:
    """Measure block steps per second and core, relative to a scalar loop and to the floating-point limit.

    Repeated steps are included; the limit is measured (`measure_peak_flop_per_second_of_core`).
    """
    rows: list[MeasuredNumber] = []
    motion, peak = motion_too_weak_to_overturn(), measure_peak_flop_per_second_of_core()
    many = Cases(0.0, 0.6, 0.4, np.linspace(0.3, 1.0, 512))
    how: dict[str, Any] = {"model": gravestone(SOFT_CONTACT), "leave_out": False}
    for scheme in ("centred", "cundall"):
        constants, loops = CONSTANTS_AND_LOOP_CREATOR_BY_SCHEME[IntegrationScheme[scheme.upper()]]
        advance = wrap_loop_for_calls_from_python(loops(with_vertical_base_motion=False, with_friction=True))
        advance(constants, np.zeros(STATE_ROW_LAYOUT.array_length), 8, 1, float(TICKS_PER_WHOLE_STEP))
        wide = run_cases(motion, many, scheme=scheme, **how).block_steps.sum()
        plain_run, narrow = scalar_loop_function_and_block_step_count(motion, scheme == "centred")
        # Interleaved, so that other load on the machine affects both alike.
        ratios, speeds = [], []
        for _ in range(3):
            run_many = partial(run_cases, motion, many, scheme=scheme, **how)
            speed = wide / minimum_processor_time(run_many, 1)
            ratios.append(speed / (narrow / minimum_processor_time(plain_run, 1)))
            speeds.append(speed)
        operations = flop_per_block_step(advance)
        rows += [
            MeasuredNumber(f"block steps per second and core, {scheme}", max(speeds) / 1e6, "million/s"),
            MeasuredNumber(f"speed over that of the scalar kernel, {scheme}", float(np.median(ratios)), "x"),
            MeasuredNumber(f"operations per block step, {scheme}", operations),
            MeasuredNumber(f"share of the floating-point limit, {scheme}", max(speeds) * operations / peak),
        ]
    return [MeasuredNumber("floating-point limit", peak / 1e9, "10^9/s"), *rows]


def measure_time_per_case_and_rigid_agreement() -> list[MeasuredNumber]:
    """Measure the time per case of about 1000 cases of 20 s, and the agreement with the exact rigid block."""
    motion = read_motions_of_default_study()["rinaldi"]
    axes = (
        np.arange(0.0, 360.0, 5.0),
        [0.6, 1.2],
        [0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4],
        [FRICTION_PREVENTING_SLIDING],
    )
    cases = case_grid(*axes)
    rigid = np.stack(
        [simulate_rigid_rocking(motion.scaled_by(factor), cases).overturned for factor in (1.0, 0.99, 1.01)]
    )
    firm = (rigid == rigid[0]).all(axis=0)
    # As a user runs it; the second run omits the mirrored half of the grid.
    given: dict[str, Any] = dict(zip(("azimuth_deg", "height", "b_over_h", "friction"), axes, strict=True))
    whole = minimum_processor_time(lambda: run_cases(motion, cases, leave_out=False), 15) / cases.case_count
    default = minimum_processor_time(lambda: simulate_as_arrays(motion, **given), 15) / cases.case_count
    exact = minimum_processor_time(lambda: simulate_rigid_rocking(motion, cases)) / cases.case_count
    return [
        MeasuredNumber("cases of the sweep", cases.case_count),
        MeasuredNumber("time per case, nothing left out", whole * 1e3, "ms"),
        MeasuredNumber("time per case, default", default * 1e3, "ms"),
        MeasuredNumber("time per case, exact rigid block", exact * 1e3, "ms"),
        MeasuredNumber(
            "agreement with the exact rigid block",
            100 * float((run_cases(motion, cases).overturned == rigid[0])[firm].mean()),
            "%",
        ),
    ]


def measure_compile_and_load_time() -> list[MeasuredNumber]:
    """Measure the time of compilation (start with an empty cache minus start with a filled one) and of loading."""
    program = (
        "import time, numpy as np; from overturning import Motion, Cases, run_cases\n"
        "w = np.sin(np.arange(50.0)); m = Motion(w, w, sampling_interval=0.01); t = time.process_time()\n"
        "run_cases(m, Cases(0, 0.6, 0.05, 1.0)); print(time.process_time() - t)"
    )
    with tempfile.TemporaryDirectory() as folder:
        cold, warm = (
            float(run_python_program_and_measure_cpu_time(program, NUMBA_CACHE_DIR=folder)[0]) for _ in range(2)
        )
    return [
        MeasuredNumber("compilation, cold", cold - warm, "s"),
        MeasuredNumber("loading a compiled kernel", warm, "s"),
    ]


def measure_time_and_errors_of_default_study(azimuth_count: int = 36) -> list[MeasuredNumber]:
    """Measure kernel time and the share of wrong overturning flags of the default study, on two threads.

    The study has 133,056 cases.
    """
    groups = default_study_case_groups(azimuth_count)
    run_cases(*default_study_case_groups(2, 28)[0])
    start, busy = time.perf_counter(), time.process_time()
    found = join_results([run_cases(*group, threads=2) for group in groups])
    seconds, busy = time.perf_counter() - start, time.process_time() - busy
    fine = run_case_groups(groups, threads=2, time_step="0.125 stable").results
    far = differences_from_reference_results(found, fine, (len(groups), azimuth_count, 2, -1, 3))
    rows = [
        MeasuredNumber("default study: flags, mirrored half included", 2 * found.status.size),
        MeasuredNumber("default study: kernel time on two threads", seconds, "s"),
        MeasuredNumber("default study: processor time, both threads together", busy, "s"),
    ]
    for where, counts in (
        ("where the neighbours agree", far.counts_where_neighbours_agree),
        ("of all cells, against an eighth of the step", far.counts_of_all_cases),
    ):
        flags, sides = wrong_flag_and_flag_or_side_percentages(counts)
        rows.append(MeasuredNumber(f"default study: wrong flags {where}", flags, "%"))
        rows.append(MeasuredNumber(f"default study: wrong sides {where}", sides, "%"))
    return rows


def measure_effect_of_skipping_samples_at_rest(azimuth_count: int = 18) -> list[MeasuredNumber]:
    """Measure the work saved in the default study by skipping samples at rest, and the outcomes that this changes."""
    groups = default_study_case_groups(azimuth_count)
    short = run_case_groups(groups, threads=2).results
    full = run_case_groups(groups, threads=2, leave_out=False).results
    nudged = [group._replace(motion=group.motion.scaled_by(1 + 1e-9)) for group in groups]
    other = differences_from_reference_results(
        run_case_groups(nudged, threads=2, leave_out=False).results, full
    ).counts_of_all_cases
    below = np.tile(np.asarray(groups[0].cases.friction) < np.asarray(groups[0].cases.b_over_h), len(groups))
    moves, far = short.block_steps > 0, differences_from_reference_results(short, full)
    return [
        MeasuredNumber("cases, mirrored half left out", below.size),
        MeasuredNumber("cases above a threshold, which are simulated", int(moves.sum())),
        MeasuredNumber(
            "block steps, share of those with nothing left out",
            percentage(far.computed_steps_times_elements, full.block_steps.sum()),
            "%",
        ),
        MeasuredNumber(
            "samples at rest and left out, mean per simulated case", float(short.samples_left_out[moves].mean())
        ),
        MeasuredNumber("flags changed by leaving out", far.counts_of_all_cases.flags),
        MeasuredNumber("sides changed by leaving out", far.counts_of_all_cases.flags + far.counts_of_all_cases.sides),
        MeasuredNumber("flags changed by amplitudes larger by 1e-9", other.flags),
        MeasuredNumber("sides changed by amplitudes larger by 1e-9", other.flags + other.sides),
        MeasuredNumber("simulated cases with μ < B/H", int((moves & below).sum())),
        MeasuredNumber("simulated cases with μ < B/H that fall", int((short.overturned[below] != 0).sum())),
        MeasuredNumber("largest rotation over α in cases with μ < B/H", float(short.peak_rotation[below].max())),
    ]


def measure_time_by_case_count_and_peak_memory() -> list[MeasuredNumber]:
    """Measure the memory of a million cases, and the time per case from 10⁴ to 10⁶ cases."""
    t = np.arange(60) * 0.02
    motion = Motion(6.0 * np.sin(2 * np.pi * t / 0.5), 0 * t, sampling_interval=0.02)
    rng = np.random.default_rng(2)
    rows: list[MeasuredNumber] = []
    each = {}
    run_cases(motion, Cases(0.0, 0.6, 0.3, 0.5))  # loads the compiled kernel
    for count in (10_000, 100_000, 1_000_000):
        cases = Cases(0.0, 0.6, rng.choice(np.linspace(0.2, 0.5, 31), count), rng.choice([0.4, 0.7, 1.0], count))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        start = time.process_time()
        run_cases(motion, cases)
        each[count] = (time.process_time() - start) / count
        rows.append(MeasuredNumber(f"time per case of {count} short cases", each[count] * 1e6, "us"))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    rows += [
        MeasuredNumber("time per case at 10^6 over that at 10^4", each[1_000_000] / each[10_000], "x"),
        MeasuredNumber("peak memory at 10^6 cases", peak / 2**20, "GiB"),
        MeasuredNumber("peak memory added by the 10^6 cases", (peak - before) / 2**20, "GiB"),
    ]
    return rows


MEASUREMENT_FUNCTION_BY_PART: dict[str, Callable[[], list[MeasuredNumber]]] = {
    "growth": measure_time_by_case_count_and_peak_memory, "throughput": measure_block_step_throughput,
    "sweep": measure_time_per_case_and_rigid_agreement,
    "compilation": measure_compile_and_load_time, "study": measure_time_and_errors_of_default_study,
    "whole-run": measure_whole_run_with_and_without_fork_server, "left-out": measure_effect_of_skipping_samples_at_rest
}  # fmt: skip


def main(
    parts: Annotated[
        list[str] | None, typer.Argument(help=f"{', '.join(MEASUREMENT_FUNCTION_BY_PART)}; default: all")
    ] = None,
) -> None:
    """Measure the speed of the kernels; stored numbers of parts that are not named are kept."""
    machine = re.sub(r"[^a-z0-9]+", "-", f"{platform.machine()} {os.cpu_count()} cores".lower()).strip("-")
    rows: list[MeasuredNumber] = []
    for name in (names := named_parts_or_all_if_none(parts, MEASUREMENT_FUNCTION_BY_PART)):
        measure = MEASUREMENT_FUNCTION_BY_PART[name]
        found = measure()
        print(body := measured_numbers_table(found), flush=True)
        rows += found
        known = write_measured_numbers(
            rows, RESULT_TABLE_FOLDER / f"{machine}.csv", keep_other_stored_numbers=bool(parts) or name != names[-1]
        )
        bodies = {
            "bench": measured_numbers_table(
                one for one in known if not one.quantity.startswith(QUANTITY_PREFIX_WITH_FORK_SERVER)
            )
        }
        own = (
            {"left-out": body}
            if name == "left-out"
            else {name: fork_server_comparison_table(found)}
            if name == "whole-run"
            else {}
        )
        update_marked_tables_and_sentences_in_docs(bodies | own)


if __name__ == "__main__":
    typer.run(main)
