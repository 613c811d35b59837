"""`python -m verification.space`: speed and accuracy of the 3-D model, for docs/measurements.md.

Measures compilation, memory, order of convergence, the shipped study, energy, the effect of step, contact and
amplitude, and the agreement with other engines.
"""

import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from itertools import combinations, product
from typing import Annotated, Any, Final
from unittest import mock

import numpy as np
import typer

from overturning.dem.kernel.balance import STEP_DIVISOR_PER_RERUN, rerun_until_energy_balances_or_mark_unstable
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import plan_simulation
from overturning.dem.simulate import simulate_as_arrays
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import VertexContact
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import load_scene
from overturning.model.shapes import RectangularPrism
from overturning.model.stack import Stack
from overturning.model.status import CaseStatus
from overturning.motion.direction import angle_between_azimuths
from overturning.motion.motion import Motion
from overturning.study.load import load_study
from overturning.study.scenes import variant_grid
from verification import inputs
from verification.engines import ENGINES_3D, PrismHalfSizesAndFriction, fall_azimuth_of_prism, installed_engines
from verification.inputs import read_motions_of_default_study, strong_horizontal_part_of_motion
from verification.measures import convergence_order
from verification.reference import body_cundall
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    MeasuredNumber,
    measured_numbers_table,
    named_parts_or_all_if_none,
    update_marked_tables_and_sentences_in_docs,
    write_measured_numbers,
)
from verification.timing import run_and_measure_min_processor_time, run_python_program_and_measure_cpu_time

OutcomeArrays = dict[str, np.ndarray]

SINGLE_STONE_STACK_LABEL: Final = "a stack of one stone"

DEFAULT_CASE_GRID_AXES: Final[dict[str, Any]] = {
    "orientation_deg": np.arange(0.0, 90.0, 15.0), "height": [0.6], "b_over_h": [0.2, 0.3, 0.4], "friction": [0.58],
}  # fmt: skip
TIME_STEP_OF_PHYSICS_ENGINES_S: Final = 2e-4
"""Time step of the other engines, s; a smaller one changes no more flags than the engines differ in."""
TIME_STEP_DIVISORS_OF_CONVERGENCE_TEST: Final = (1, 2, 4, 8)
"""Refinement factors of the default step at which the order of convergence is measured."""
TIME_STEP_DIVISOR_OF_REFERENCE: Final = 64
AZIMUTH_RESOLUTION_OF_CUBE_RAD: Final = float(np.radians(np.spacing(np.float32(360.0))))
"""Rounding of an azimuth in single precision, rad: the resolution of a cube."""


def rocking_motion_without_overturning(sample_count: int = 2000) -> Motion:
    """Return a motion of 20 s that rocks bodies and overturns none."""
    t = np.arange(sample_count) * 0.01
    return Motion(1.5 * np.sin(9.0 * t), 1.2 * np.cos(12.0 * t), 0.5 * np.sin(9.0 * t), sampling_interval=0.01)


def simulate_case_grid_under_motions(
    motions: list[Motion],
    amplitude_factor: float = 1.0,
    case_grid_values_by_axis: dict[str, Any] = DEFAULT_CASE_GRID_AXES,
    **options: Any,
) -> OutcomeArrays:
    """Simulate a grid of bodies under motions multiplied by a factor; return outcomes by name, motions first."""
    given = {"model": "rectangle", "threads": 2, **case_grid_values_by_axis, **options}
    found = [simulate_as_arrays(motion.scaled_by(amplitude_factor), **given) for motion in motions]
    return {name: np.stack([one[name] for one in found]) for name in found[0]}


def measure_steps_per_second_and_compile_time_of_3d() -> Iterator[MeasuredNumber]:
    """Measure block steps per second and core of 3-D bodies on four vertices or a circular rim, and the compile time.

    The compile time is that of a first case with an empty cache of compiled code, imports included.
    """
    grid = {
        "orientation_deg": DEFAULT_CASE_GRID_AXES["orientation_deg"],
        "height": [0.6],
        "b_over_h": np.linspace(0.4, 0.5, 16),
    }
    for scheme, body, name in (
        ("cundall", "rectangle", "cundall, four vertices"),
        ("cundall", "circle", "cundall, rim"),
        ("centred", "rectangle", "centred, four vertices"),
        ("centred", "circle", "centred, rim"),
    ):
        options: dict[str, Any] = {"friction": [0.6], "leave_out": False, "scheme": scheme}
        found, seconds = run_and_measure_min_processor_time(
            partial(simulate_as_arrays, rocking_motion_without_overturning(), body, **grid, **options), 2
        )
        rate = found["block_steps"].sum() / seconds / 1e6
        yield MeasuredNumber(f"space: block steps per second and core, {name}", rate, "million")
    with tempfile.TemporaryDirectory() as folder:
        cold = run_python_program_and_measure_cpu_time(_MEMORY_MEASUREMENT_PROGRAM, 1, NUMBA_CACHE_DIR=folder)[1]
    yield MeasuredNumber("space: processor time of the first case with an empty cache, imports included", cold, "s")


_MEMORY_MEASUREMENT_PROGRAM: Final = """
import resource, sys, numpy as np, verification.space as s
s.simulate_as_arrays(
    s.rocking_motion_without_overturning(100), "rectangle", orientation_deg=0, height=1, b_over_h=np.linspace(0.4, 0.5,
    int(sys.argv[1])), leave_out=False,
)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def measure_memory_by_3d_case_count() -> Iterator[MeasuredNumber]:
    """Measure how the peak memory grows with the number of cases; each number of cases has its own process."""
    _, few, many = (
        int(run_python_program_and_measure_cpu_time(_MEMORY_MEASUREMENT_PROGRAM, count)[0])
        for count in (1000, 1000, 21000)
    )
    yield MeasuredNumber("space: memory of 1000 cases", few / 1024, "MB")
    yield MeasuredNumber("space: memory of each further 1000", (many - few) / 1024 / 20, "MB")


def prism_outcomes_in_double_precision(motion: Motion, cases: Cases, numerics: NumericalOptions) -> OutcomeArrays:
    """Return outcomes of prisms in double precision; the single precision of a cube would hide small errors."""
    plan = plan_simulation(Body(RectangularPrism()), motion, cases, numerics)
    found: OutcomeArrays = {}
    for group in np.unique(plan.parallel_group_by_case):
        chosen = np.flatnonzero(plan.parallel_group_by_case == group)
        computed, _ = plan.simulate_group_with_reruns_on_energy_error(chosen, np.zeros(1, np.int64))
        for name, values in computed.items():
            found.setdefault(name, np.full(cases.case_count, np.nan))[chosen] = values
    return found


def convergence_order_and_errors_by_quantity(scheme: str) -> dict[str, tuple[float, np.ndarray]]:
    """Return, by quantity, the order of convergence and the median error with each time-step divisor, rad.

    The quantities are the peak tilt of stones that rock and stand, and the fall azimuth of stones that fall. The stones
    do not slide; the azimuth of sliding ones converges with an order of 0.5 to 0.8 only.
    """
    t = np.arange(160) * 0.01
    window = np.where(t < 1.2, np.sin(np.pi * t / 1.2) ** 2, 0.0)
    pulse = Motion(
        5.0 * window * np.sin(5.0 * t), 4.0 * window * np.cos(8.0 * t), sampling_interval=0.01, trust_data=True
    )
    cases = inputs.case_grid(np.arange(5.0, 90.0, 10.0), 0.6, [0.14, 0.2, 0.31, 0.32, 0.33, 0.34], 0.8)
    found = [
        prism_outcomes_in_double_precision(pulse, cases, NumericalOptions(scheme=scheme, refinement=step))
        for step in (*TIME_STEP_DIVISORS_OF_CONVERGENCE_TEST, TIME_STEP_DIVISOR_OF_REFERENCE)
    ]
    fell = np.all([one["overturned"] == 1 for one in found], axis=0)
    stood = np.all([(one["overturned"] == 0) & (one["peak_tilt"] > 0.5) for one in found], axis=0)
    slopes = {}
    for name, chosen in (("peak_tilt", stood), ("fall_azimuth", fell)):
        away = [np.radians(angle_between_azimuths(one[name], found[-1][name]))[chosen] for one in found[:-1]]
        errors = np.median(away, axis=1)
        # Errors below the rounding do not show the order: the first of them ends the fit.
        count = 1 + int(np.argmax(np.append(errors, 0.0) <= AZIMUTH_RESOLUTION_OF_CUBE_RAD))
        slopes[name] = (
            convergence_order(1 / np.array(TIME_STEP_DIVISORS_OF_CONVERGENCE_TEST)[:count], errors[:count]),
            errors,
        )
    return slopes


def measure_convergence_order() -> Iterator[MeasuredNumber]:
    """Measure order of convergence and error of the tilt of standing stones and the azimuth of falling ones."""
    for scheme in ("centred", "cundall"):
        for name, (slope, errors) in convergence_order_and_errors_by_quantity(scheme).items():
            yield MeasuredNumber(f"space, {scheme}: order of convergence, {name}", slope)
            yield MeasuredNumber(
                f"space, {scheme}: median error at its step, {name}", float(np.degrees(errors[0])), "°"
            )


def measure_cost_and_reruns_of_shipped_3d_study() -> Iterator[MeasuredNumber]:
    """Measure time, errors and reruns of the study config/in-space.yaml without its ensemble.

    Cases whose energy does not balance are rerun with finer steps. Cases marked unstable or undecided are counted, too.
    """
    grid, again = variant_grid(load_study(ROOT / "config" / "in-space.yaml")), list[int]()
    axes = {"orientation_deg": grid.direction_values_deg} | {name: grid[name] for name in grid.dimension_names[1:]}
    motions = list(read_motions_of_default_study().values())
    simulate_case_grid_under_motions(
        motions[:1], case_grid_values_by_axis={name: values[:1] for name, values in axes.items()}
    )

    def run_until_energy_balances_and_count_reruns(run_selected_cases: Callable[[Any, int], None], *more: Any) -> None:
        """Run cases and rerun those whose energy does not balance, like the package; count the rerun cases."""

        def run_cases_counting_reruns(case_indices: Any, step_divisor: int) -> None:
            """Run cases, and note their number if they are rerun with finer steps."""
            again.append(case_indices.size if step_divisor == STEP_DIVISOR_PER_RERUN else 0)
            run_selected_cases(case_indices, step_divisor)

        rerun_until_energy_balances_or_mark_unstable(run_cases_counting_reruns, *more)

    with mock.patch(
        "overturning.dem.plan.rerun_until_energy_balances_or_mark_unstable", run_until_energy_balances_and_count_reruns
    ):
        found, seconds = run_and_measure_min_processor_time(
            partial(simulate_case_grid_under_motions, motions, case_grid_values_by_axis=axes), 1, int
        )
    status, about = found["status"], "space, config/in-space.yaml"
    yield MeasuredNumber(f"{about}: cases", status.size)
    yield MeasuredNumber(f"{about}: processor time of two cores", seconds, "s")
    yield MeasuredNumber(f"{about}: cases computed again because their energy did not balance", sum(again))
    yield MeasuredNumber(f"{about}: cases marked unstable", int((status == CaseStatus.UNSTABLE).sum()))
    yield MeasuredNumber(f"{about}: cases undecided", int((status == CaseStatus.UNDECIDED).sum()))
    for name in ("energy_error", "angular_momentum_error"):
        worst = float(found[name][status == CaseStatus.SIMULATED].max())
        yield MeasuredNumber(f"{about}: largest {name.replace('_', ' ')} of an answer", worst)


def measure_energy_errors_and_sensitivity(motions: list[Motion]) -> Iterator[MeasuredNumber]:
    """Measure energy errors, and how outcomes change with amplitude, finer time steps and other contacts.

    The amplitude changes by 1 %.
    """
    nominal, seconds = run_and_measure_min_processor_time(
        partial(simulate_case_grid_under_motions, motions), 1, partial(simulate_case_grid_under_motions, motions[:1])
    )
    fell = nominal["overturned"] == 1
    yield MeasuredNumber("space: cases", fell.size)
    yield MeasuredNumber("space: processor time per case", 1e3 * seconds / fell.size, "ms")
    yield MeasuredNumber("space: largest energy error", float(nominal["energy_error"].max()))
    yield MeasuredNumber("space: largest angular-momentum error", float(nominal["angular_momentum_error"].max()))
    keep, firm = np.ones(fell.shape, bool), np.ones(fell.shape, bool)
    for factor in (0.99, 1.01):
        other = simulate_case_grid_under_motions(motions, factor)
        same = other["overturned"] == nominal["overturned"]
        keep &= same
        firm &= same & (~fell | (angle_between_azimuths(other["fall_azimuth"], nominal["fall_azimuth"]) < 15.0))
    yield MeasuredNumber("space: cases that keep the flag under ±1 % of amplitude", 100.0 * keep.mean(), "%")
    text = "space: falls whose azimuth moves by more than 15° under ±1 % of amplitude"
    yield MeasuredNumber(text, 100.0 * (~firm)[fell & keep].mean(), "%")
    for name, options in (
        ("half the step", {"time_step": "0.5 stable"}),
        ("quarter of the step", {"time_step": "0.25 stable"}),
        ("cundall", {"scheme": "cundall"}),
        ("cundall, half the step", {"scheme": "cundall", "time_step": "0.25 stable"}),
        ("δ/B 2e-5", {"model": Body(RectangularPrism(), VertexContact(static_penetration=2e-5))}),
        ("δ/B 2e-7", {"model": Body(RectangularPrism(), VertexContact(static_penetration=2e-7))}),
        (SINGLE_STONE_STACK_LABEL, {"model": Stack()}),
    ):
        run = partial(simulate_case_grid_under_motions, **options)
        other, seconds = run_and_measure_min_processor_time(partial(run, motions), 1, partial(run, motions[:1]))
        other = {name: values.reshape(fell.shape) for name, values in other.items()}
        same = other["overturned"] == nominal["overturned"]
        moved = angle_between_azimuths(other["fall_azimuth"], nominal["fall_azimuth"])[firm & fell & same]
        yield MeasuredNumber(f"space, {name}: different flags, of firm cases", 100.0 * (~same)[firm].mean(), "%")
        yield MeasuredNumber(
            f"space, {name}: azimuths more than 15° off, of firm falls", 100.0 * (moved > 15.0).mean(), "%"
        )
        yield MeasuredNumber(f"space, {name}: median change of azimuth, of firm falls", float(np.median(moved)), "°")
        yield MeasuredNumber(f"space, {name}: processor time per case", 1e3 * seconds / fell.size, "ms")
        if name == SINGLE_STONE_STACK_LABEL:
            more = float(other["block_steps"].sum() / nominal["block_steps"].sum())
            yield MeasuredNumber(f"space, {name}: time steps over those of a body", more)
            yield MeasuredNumber(f"space, {name}: largest energy error", float(other["energy_error"].max()))


def measure_processor_time_of_three_tier_grave_and_shaft() -> Iterator[MeasuredNumber]:
    """Measure the time of a case of the three-tier grave, and of its shaft alone, under records of about 20 s."""
    chosen = [
        one
        for one in read_motions_of_default_study().values()
        if 14.0 <= one.sample_count * one.sampling_interval <= 28.0
    ]
    scene = load_scene("three-tier", ROOT)
    height, b_over_h = reference_element_height_and_b_over_h(scene)
    stones: dict[str, dict[str, Any]] = {
        "three stones": {"model": Stack(scene)},
        "one stone": {"model": "rectangle", "height": [height], "b_over_h": [b_over_h]},
    }
    orientations, spent = np.arange(0.0, 90.0, 1.25), dict.fromkeys(stones, 0.0)
    for motion, factor in product(chosen, (1.0, 1.5)):
        for name, options in stones.items():
            run = partial(simulate_as_arrays, friction=[0.6], **options)
            one = partial(run, motion.scaled_by(factor), orientation_deg=orientations)
            spent[name] += run_and_measure_min_processor_time(one, 1, partial(run, motion, orientation_deg=[0.0]))[1]
    for name, seconds in spent.items():
        count = 2 * len(chosen) * orientations.size
        yield MeasuredNumber(
            f"space, records of 14 to 28 s, {name}: processor time per case", 1e3 * seconds / count, "ms"
        )
    yield MeasuredNumber(
        "space, records of 14 to 28 s: time of three stones over that of one",
        spent["three stones"] / spent["one stone"],
    )


def measure_agreement_with_physics_engines(motions: list[Motion], compared_case_count: int) -> Iterator[MeasuredNumber]:
    """Compare overturning flags and fall azimuths of randomly chosen cases with those of physics engines."""
    ours, seconds = run_and_measure_min_processor_time(
        partial(simulate_case_grid_under_motions, motions), 1, partial(simulate_case_grid_under_motions, motions[:1])
    )
    fine = simulate_case_grid_under_motions(
        motions, time_step="0.25 stable", model=Body(RectangularPrism(), VertexContact(static_penetration=2e-7))
    )
    shape = ours["overturned"].shape
    cells = np.unravel_index(np.random.default_rng(1).permutation(ours["overturned"].size)[:compared_case_count], shape)
    flags, azimuths = {}, {}
    for name, engine in installed_engines(ENGINES_3D).items():
        begin, found = time.process_time(), []
        for m, o, _, b, *_ in np.stack(cells, axis=1).tolist():
            half = 0.3 * DEFAULT_CASE_GRID_AXES["b_over_h"][b]
            prism = PrismHalfSizesAndFriction(half, half, 0.3, DEFAULT_CASE_GRID_AXES["friction"][0])
            found.append(
                fall_azimuth_of_prism(
                    engine,
                    motions[m],
                    DEFAULT_CASE_GRID_AXES["orientation_deg"][o],
                    prism,
                    TIME_STEP_OF_PHYSICS_ENGINES_S,
                )
            )
        azimuths[name], flags[name] = np.array(found), np.isfinite(found)
        theirs = (time.process_time() - begin) / len(found)
        yield MeasuredNumber(f"{name} in space: processor time per case", theirs, "s")
        yield MeasuredNumber(
            f"{name} in space: its time per case over that of this program", theirs * ours["status"].size / seconds
        )
    yield MeasuredNumber("space: cases that all engines run", cells[0].size)
    stack = simulate_case_grid_under_motions(motions, model=Stack())
    for name, one in (("this program", ours), (f"this program, {SINGLE_STONE_STACK_LABEL}", stack)):
        flags[name] = one["overturned"].reshape(shape)[cells] == 1
        azimuths[name] = one["fall_azimuth"].reshape(shape)[cells]
    for name, own in flags.items():
        wrong = 100.0 * (own != (fine["overturned"][cells] == 1)).mean()
        yield MeasuredNumber(f"space: flags different from the finest reference's, {name}", wrong, "%")
    for a, b in combinations(flags, 2):
        both, differ = flags[a] & flags[b], 100.0 * float((flags[a] != flags[b]).mean())
        yield MeasuredNumber(f"space: flags that differ, {a} and {b}", differ, "%")
        near = angle_between_azimuths(azimuths[a], azimuths[b])[both] <= 20.0
        yield MeasuredNumber(f"space: azimuths within 20° where both fall, {a} and {b}", 100.0 * near.mean(), "%")


def main(
    parts: Annotated[list[str] | None, typer.Argument(help="parts to measure; default: all")] = None,
    records: Annotated[int, typer.Option(min=1, help="records of the default study")] = 28,
    peer_cases: Annotated[int, typer.Option(min=1, help="number of cases for the other engines")] = 200,
) -> None:
    """Measure speed, memory, convergence and errors of the 3-D model, and write them into the docs."""
    every = list(read_motions_of_default_study().values())[:: max(28 // records, 1)]
    chosen, figures = [strong_horizontal_part_of_motion(motion) for motion in every[:records]], list[MeasuredNumber]()
    made: dict[str, Callable[[], Iterator[MeasuredNumber]]] = {
        "throughput": measure_steps_per_second_and_compile_time_of_3d, "memory": measure_memory_by_3d_case_count,
        "convergence": measure_convergence_order,
        "study": measure_cost_and_reruns_of_shipped_3d_study,
        "exactness": partial(measure_energy_errors_and_sensitivity, chosen),
        "stack": measure_processor_time_of_three_tier_grave_and_shaft,
        "peers": partial(measure_agreement_with_physics_engines, chosen, peer_cases),
    }  # fmt: skip
    with body_cundall.allow_cundall_scheme_for_bodies():
        for name in (names := named_parts_or_all_if_none(parts, made)):
            for figure in made[name]():
                figures.append(figure)
                print(*figure, sep=" | ", flush=True)
            known = write_measured_numbers(
                figures, RESULT_TABLE_FOLDER / "space.csv", keep_other_stored_numbers=bool(parts) or name != names[-1]
            )
            update_marked_tables_and_sentences_in_docs({"space": measured_numbers_table(known)})


if __name__ == "__main__":
    typer.run(main)
