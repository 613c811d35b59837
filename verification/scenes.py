"""`python -m verification.scenes [PART ...]`: speed and accuracy of scenes, and a gravestone in two kernels.

Parts: `speed`, element steps per second; `peers`, a stacked grave compared with pymunk and Box2D; `steps`, error over
the step; `pillars`, effect of leaving out if stones may tip together; `kernels`, comparison of the kernel for single
blocks with the general one. All times are processor times of one core in one run; those of the kernel are the minimum
of two runs after a warm-up. The reference is the general kernel with a tenth of the default step, for firm cases: those
with the same outcome for twice that step and for Cundall's scheme. The other engines run at 1/240 s with 30 iterations.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Annotated, Any, Final

import numpy as np
import typer

from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.model.cases import Cases
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, DEFAULT_CONTACT_DAMPING_RATIO
from overturning.model.geometry import reference_element_height_and_b_over_h, scale_and_place_elements
from overturning.model.results import CaseResults
from overturning.model.scene import Scene, gravestone, load_scene, parse_scene_content
from overturning.motion.motion import Motion
from verification.engines import SCENE_ENGINES, FallSidesOfSceneFunction, fall_sides_of_scene, installed_engines
from verification.inputs import CaseGroup, case_grid, read_motions_of_default_study, read_strong_part_of_pulse_record
from verification.measures import join_results
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    MeasuredNumber,
    markdown_table,
    measured_numbers_table,
    named_parts_or_all_if_none,
    update_marked_tables_and_sentences_in_docs,
    write_measured_numbers,
)
from verification.timing import (
    minimum_processor_time,
    run_and_measure_min_processor_time,
    run_case_groups_in_subprocess,
)

COMPARED_TOP_ELEMENT_INDEX: Final = 2
"""Index of the compared element, the topmost of three."""
COMPARED_ENGINES: Final = ("pymunk", "Box2D")

SIZES_OF_TWO_STONES_AND_FINIAL: Final = (
    ((0.40, 0.40), (0.36, 0.40), (0.06, 0.40)),
    ((0.30, 0.45), (0.28, 0.45), (0.06, 0.30)),
    ((0.60, 0.50), (0.50, 0.60), (0.08, 0.50)),
)
"""Width and height, m, of two stones and the finial on them. It falls first; then both stones may tip together."""

COMPARED_SETTINGS = (
    ("default", DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, DEFAULT_CONTACT_DAMPING_RATIO, "centred", "auto"),
    (
        "half the step",
        DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO,
        DEFAULT_CONTACT_DAMPING_RATIO,
        "centred",
        "0.5 stable",
    ),
    ("less damping", DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, 1.0, "centred", "auto"),
    ("softer", 2e-6, DEFAULT_CONTACT_DAMPING_RATIO, "centred", "auto"),
    ("softest", 2e-5, DEFAULT_CONTACT_DAMPING_RATIO, "centred", "auto"),
    ("softest, cundall", 2e-5, DEFAULT_CONTACT_DAMPING_RATIO, "cundall", "auto"),
)
"""Label, static penetration over width, damping ratio, scheme, time step."""


def three_tier_scene_and_cases() -> tuple[Scene, CaseGroup]:
    """Return the scene of a shaft on two bases, and its 96 cases."""
    scene = load_scene("three-tier", ROOT)
    height, ratio = reference_element_height_and_b_over_h(scene)
    ratios = [0.2, 0.25, 0.3, round(ratio, 10)]
    return scene, CaseGroup(
        read_strong_part_of_pulse_record(7), case_grid(np.arange(0, 360, 30.0), height, ratios, [0.6, 1.0])
    )


def median_peak_rotation_error_percent(
    peak_rotations: Any, reference_peak_rotations: Any, mask_of_cases_to_include: np.ndarray
) -> float:
    """Return the median absolute relative error, percent, of the peak rotations that a mask selects."""
    return 100 * float(
        np.median(
            np.abs(
                peak_rotations[mask_of_cases_to_include]
                / np.where(reference_peak_rotations > 0, reference_peak_rotations, np.inf)[mask_of_cases_to_include]
                - 1
            )
        )
    )


def measure_element_steps_per_second() -> Iterator[MeasuredNumber]:
    """Measure element steps per second and core in cases that stand, without skipping samples at rest."""
    time_axis = np.arange(300) * 0.01
    motion = Motion(2.0 * np.sin(9 * time_axis), 0 * time_axis, sampling_interval=0.01)
    for name in ("three-tier", "against-a-wall", "boulder"):
        scene = load_scene(name, ROOT)
        cases = Cases(0.0, *reference_element_height_and_b_over_h(scene), np.linspace(0.5, 1.0, 192))
        found, seconds = run_and_measure_min_processor_time(
            partial(simulate_cases, scene, motion, cases, NumericalOptions(leave_out=False)), 2
        )
        yield MeasuredNumber(
            f"element steps per second and core, {name}", found.block_steps.sum() / seconds / 1e6, "million/s"
        )


def scene_with_other_contact_law(scene: Scene, static_penetration_to_width_ratio: float, damping_ratio: float) -> Scene:
    """Return a scene with one contact law of given static penetration over width and damping ratio everywhere."""
    law = {
        "between": ("stone", "stone"),
        "static_penetration": static_penetration_to_width_ratio,
        "damping_ratio": damping_ratio,
    }
    return Scene.model_validate(scene.model_dump() | {"contacts": [law]})


def measure_speed_and_accuracy_beside_physics_engines(engine_case_count: int) -> Iterator[MeasuredNumber]:
    """Measure speed and accuracy of this program and of physics engines for a shaft on two bases.

    The measured numbers are times per case, shares of cases with the correct side of the shaft's fall, and errors of
    peak rotations.
    """
    scene, (motion, cases) = three_tier_scene_and_cases()
    fine, firm = reference_results_and_step_insensitive_case_mask(scene, motion, cases)
    right = fine.overturned[:, COMPARED_TOP_ELEMENT_INDEX]
    yield MeasuredNumber("cases of the sweep", cases.case_count)
    yield MeasuredNumber("cases in which the shaft falls", 100 * float((right != 0).mean()), "%")
    yield MeasuredNumber("cases whose outcome changes with step or scheme", 100 * float((~firm).mean()), "%")
    chosen = np.random.default_rng(1).choice(
        np.flatnonzero(firm), min(engine_case_count, int(firm.sum())), replace=False
    )
    some = CaseGroup(motion, cases).subset(chosen)
    times, ended, found = {}, {}, {}
    for name, engine in installed_engines(SCENE_ENGINES).items():
        _, ended[name] = run_and_measure_min_processor_time(
            partial(fall_sides_of_shaft, engine, scene, some, stop_after_shaft_falls=True), 1, int
        )
        found[name], times[name] = run_and_measure_min_processor_time(
            partial(fall_sides_of_shaft, engine, scene, some), 1, int
        )
        yield MeasuredNumber(f"{name}: time per case", times[name] / chosen.size * 1e3, "ms")
        yield MeasuredNumber(
            f"{name}: time per case, ended when the shaft has fallen", ended[name] / chosen.size * 1e3, "ms"
        )
        yield MeasuredNumber(
            f"{name}: correct side of the shaft", 100 * float((found[name] == right[chosen]).mean()), "%"
        )
    if len(found) == 2:
        one, other = found.values()
        yield MeasuredNumber("agreement of the other engines with each other", 100 * float((one == other).mean()), "%")
    axes: dict[str, Any] = {name: np.unique(getattr(cases, name)) for name in ("azimuth_deg", "height", "b_over_h")}
    for label, penetration, damping, scheme, step in COMPARED_SETTINGS:
        stones = scene_with_other_contact_law(scene, penetration, damping)
        options: dict[str, Any] = {"scheme": scheme, "time_step": step}
        coarse, whole = run_and_measure_min_processor_time(
            partial(simulate_cases, stones, motion, cases, NumericalOptions(leave_out=False, **options)), 2
        )
        used = partial(simulate_as_arrays, motion, stones, friction=np.unique(cases.friction), **axes, **options)
        whole, left = whole / cases.case_count, minimum_processor_time(used, 2) / cases.case_count
        same = coarse.overturned[:, COMPARED_TOP_ELEMENT_INDEX] == right
        yield MeasuredNumber(f"{label}: time per case, nothing left out", whole * 1e3, "ms")
        yield MeasuredNumber(f"{label}: time per case, as a user runs it", left * 1e3, "ms")
        yield MeasuredNumber(
            f"{label}: correct side of the shaft, cases of the other engines", 100 * float(same[chosen].mean()), "%"
        )
        yield MeasuredNumber(f"{label}: correct side of the shaft, all firm cases", 100 * float(same[firm].mean()), "%")
        stands = firm & same & (right == 0)
        error = median_peak_rotation_error_percent(
            coarse.peak_rotation[:, COMPARED_TOP_ELEMENT_INDEX],
            fine.peak_rotation[:, COMPARED_TOP_ELEMENT_INDEX],
            stands,
        )
        yield MeasuredNumber(f"{label}: median error of the shaft's peak rotation", error, "%")
        stands = firm[:, None] & (coarse.overturned == fine.overturned) & (fine.overturned == 0)
        error = median_peak_rotation_error_percent(coarse.peak_rotation, fine.peak_rotation, stands)
        yield MeasuredNumber(f"{label}: median error of all peak rotations", error, "%")
        for name, each in times.items():
            yield MeasuredNumber(
                f"{label}: speed over that of {name}, nothing left out", each / chosen.size / whole, "x"
            )
            yield MeasuredNumber(
                f"{label}: speed over that of {name}, as a user runs it", each / chosen.size / left, "x"
            )
        for name, each in ended.items() if label == "default" else ():
            text = f"{label}: speed over that of {name} ended when the shaft has fallen"
            yield MeasuredNumber(text, each / chosen.size / left, "x")


def fall_sides_of_shaft(
    engine: FallSidesOfSceneFunction,
    scene: Scene,
    group: CaseGroup,
    time_step: float = 1 / 240,
    stop_after_shaft_falls: bool = False,
) -> np.ndarray:
    """Return the side to which the shaft falls in each case in an engine (±1; 0: none)."""
    sides = []
    for index in range(group.cases.case_count):
        case = group.parameters_of_case(index)
        placed = scale_and_place_elements(scene, case["height"], case["b_over_h"])[1:]
        wave, interval = group.acceleration_of_case(index), group.motion.sampling_interval
        sides.append(
            fall_sides_of_scene(engine, placed, wave, interval, case["friction"], time_step, stop_after_shaft_falls)[
                COMPARED_TOP_ELEMENT_INDEX
            ]
        )
    return np.array(sides)


def reference_results_and_step_insensitive_case_mask(
    scene: Scene, motion: Motion, cases: Cases
) -> tuple[CaseResults, np.ndarray]:
    """Return results with a tenth of the stable step, and a mask of the cases that do not depend on step and scheme.

    The mask is True if a step twice as long and Cundall's scheme give the shaft the same overturning flag.
    """
    fine = simulate_cases(scene, motion, cases, NumericalOptions(time_step="0.1 stable", leave_out=False))
    firm = np.ones(cases.case_count, dtype=bool)
    for scheme, step in (("centred", "0.2 stable"), ("cundall", "auto")):
        other = simulate_cases(scene, motion, cases, NumericalOptions(scheme=scheme, time_step=step))
        firm &= other.overturned[:, COMPARED_TOP_ELEMENT_INDEX] == fine.overturned[:, COMPARED_TOP_ELEMENT_INDEX]
    return fine, firm


def table_of_errors_and_run_time_by_step() -> str:
    """Return a table of errors and run time by time step, without skipping samples at rest.

    The reference has 1/20 of the default step.
    """
    chosen, group, rows = ("auto", "0.9 stable", "0.5 stable", "0.25 stable"), three_tier_scene_and_cases()[1], []
    settings = [{"time_step": step, "leave_out": False} for step in (*chosen, "0.05 stable")]
    found = run_case_groups_in_subprocess([group], settings, scene_name="three-tier", repetition_count=2)
    exact = found[-1].results
    for step, (results, seconds) in zip(chosen, found, strict=False):
        stands = (exact.overturned == 0) & (results.overturned == 0)
        of_shaft = stands & (np.arange(stands.shape[1]) == COMPARED_TOP_ELEMENT_INDEX)
        errors = (
            median_peak_rotation_error_percent(results.peak_rotation, exact.peak_rotation, part)
            for part in (stands, of_shaft)
        )
        time = f"{1e3 * seconds / len(stands):.3g}"
        rows.append((step.replace("auto", "default"), time, *(f"{one:.2g}" for one in errors)))
    return markdown_table(
        ("", "time per case, ms", "error of all peak rotations, %", "error of the shaft's peak rotation, %"), rows
    )


def count_flags_sensitive_to_rest_skip_or_amplitude() -> Iterator[MeasuredNumber]:
    """Count overturning flags of three pillars that change with the skipping of rest or with the amplitude.

    Samples at rest are skipped, or the amplitude is changed by ±1e-9.
    """
    ways = {
        "leaving out": (True, 1.0),
        "an amplitude larger by 1e-9": (False, 1 + 1e-9),
        "an amplitude smaller by 1e-9": (False, 1 - 1e-9),
    }
    flags, changed = 0, dict.fromkeys(ways, 0)
    for sizes in SIZES_OF_TWO_STONES_AND_FINIAL:
        elements: list[dict[str, Any]] = [{"name": "0", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]}]
        for number, (width, height) in enumerate(sizes, 1):
            elements.append({"name": f"{number}", "width": width, "height": height, "stands_on": f"{number - 1}"})
        scene = parse_scene_content({"name": "pillar", "elements": elements})
        cases = case_grid(np.arange(0, 360, 45.0), *reference_element_height_and_b_over_h(scene), 1.0)
        for motion in read_motions_of_default_study().values():
            full = simulate_cases(scene, motion, cases, NumericalOptions(leave_out=False)).overturned
            flags += full.size
            for way, (short, factor) in ways.items():
                found = simulate_cases(
                    scene, motion.scaled_by(factor), cases, NumericalOptions(leave_out=short)
                ).overturned
                changed[way] += int((found != full).sum())
    yield MeasuredNumber("three pillars under real records: flags", flags)
    for way, number in changed.items():
        yield MeasuredNumber(f"three pillars under real records: flags changed by {way}", number)


def compare_block_and_general_kernels(
    pulse_record_numbers: Sequence[int] = (6, 7, 8, 9, 10),
) -> Iterator[MeasuredNumber]:
    """Compare flags, sides and rotations of a gravestone in the kernel for single blocks and in that for scenes.

    A cell is chaotic if either kernel gives another flag (falls or stands) with the amplitude changed by ±1e-9 or with
    half the step. Such a flag cannot be computed reliably; the kernels should agree in all other cells.
    """
    motions = [read_strong_part_of_pulse_record(number) for number in pulse_record_numbers]
    # Half of the azimuths; the others are mirror images.
    cases = case_grid(np.arange(0, 180, 15.0), 0.6, np.arange(2, 13) * 0.05, [0.58, 1.0])

    def simulate_gravestone_under_all_motions(
        uses_general_kernel: bool, amplitude_factor: float = 1.0, time_step: str = "auto"
    ) -> CaseResults:
        """Simulate the gravestone with the kernel for scenes or for single blocks, under all motions times a factor."""
        numerics = NumericalOptions(general=uses_general_kernel, time_step=time_step, leave_out=False)
        return join_results(
            [simulate_cases(gravestone(), motion.scaled_by(amplitude_factor), cases, numerics) for motion in motions]
        )

    (own, seconds), (other, general_seconds) = (
        run_and_measure_min_processor_time(partial(simulate_gravestone_under_all_motions, general), 1)
        for general in (False, True)
    )
    chaos = np.zeros(own.status.size, bool)
    for general, nominal in ((False, own), (True, other)):
        for change in ({"amplitude_factor": 1 + 1e-9}, {"amplitude_factor": 1 - 1e-9}, {"time_step": "0.5 stable"}):
            chaos |= (simulate_gravestone_under_all_motions(general, **change).overturned != 0) != (
                nominal.overturned != 0
            )
    fell, far = own.overturned != 0, (own.overturned != 0) != (other.overturned != 0)
    stands = ~fell & ~far & ~chaos
    rocked = np.maximum(other.peak_rotation, 1e-12)
    same, side = (100 * float(np.mean(one[~chaos])) for one in (~far, own.overturned == other.overturned))
    about = "a gravestone in both kernels"
    yield MeasuredNumber(f"{about}: cells", own.status.size)
    yield MeasuredNumber(f"{about}: share of cells that fall", 100 * float(fell.mean()), "%")
    yield MeasuredNumber(f"{about}: chaotic cells", int(chaos.sum()))
    yield MeasuredNumber(f"{about}: cells with different flags", int(far.sum()))
    yield MeasuredNumber(f"{about}: cells with different flags, without chaotic cells", int((far & ~chaos).sum()))
    yield MeasuredNumber(f"{about}: same flag, without chaotic cells", same, "%")
    yield MeasuredNumber(f"{about}: same side, without chaotic cells", side, "%")
    apart = float(np.median(np.abs(own.peak_rotation[stands] / rocked[stands] - 1)))
    yield MeasuredNumber(f"{about}: median relative difference of peak rotation", apart)
    yield MeasuredNumber(
        f"{about}: time in the general kernel over that in the kernel for single blocks", general_seconds / seconds, "x"
    )


def main(
    parts: Annotated[
        list[str] | None, typer.Argument(help="speed, peers, steps, pillars, kernels; default: all")
    ] = None,
    peer_cases: Annotated[int, typer.Option(min=1, help="number of cases for the other engines")] = 40,
) -> None:
    """Measure speed and accuracy of simulated scenes and write the tables.

    Parts that are not named keep their stored figures.
    """
    made: dict[str, tuple[str, Callable[[], Iterator[MeasuredNumber]]]] = {
        "speed": ("scenes.csv", measure_element_steps_per_second),
        "peers": ("scenes.csv", partial(measure_speed_and_accuracy_beside_physics_engines, peer_cases)),
        "pillars": ("scenes.csv", count_flags_sensitive_to_rest_skip_or_amplitude),
        "kernels": ("both-kernels.csv", compare_block_and_general_kernels),
    }
    others = tuple(f"{label}:" for label, *_ in COMPARED_SETTINGS[1:])
    for name in named_parts_or_all_if_none(parts, (*made, "steps")):
        if name == "steps":
            update_marked_tables_and_sentences_in_docs({"scene-steps": table_of_errors_and_run_time_by_step()})
            continue
        file, measure = made[name]
        figures = write_measured_numbers(list(measure()), RESULT_TABLE_FOLDER / file, keep_other_stored_numbers=True)
        shown = [figure for figure in figures if not figure.quantity.startswith(others)]
        print(body := measured_numbers_table(shown), flush=True)
        update_marked_tables_and_sentences_in_docs({"both-kernels" if name == "kernels" else "scene-speed": body})


if __name__ == "__main__":
    typer.run(main)
