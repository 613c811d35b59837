"""How fast and how exact scenes are: element steps per second, and a stacked grave against pymunk and Box2D.

Run it with ``python -m verification.scene_speed``. All times are processor times of one core in one run, the kernel's
the least of two after a warm-up. Right is what the general kernel finds with a tenth of the default step, on cases
whose outcome it finds with twice that step and with Cundall's scheme as well. Peers are compared at 1/240 s and 30
iterations.
"""

import time
from collections.abc import Iterator
from functools import partial
from typing import Annotated, Any, Final

import numpy as np
import typer

from overturning.dem.numerics import Numerics
from overturning.dem.run import run
from overturning.dem.simulate import simulate_arrays
from overturning.model.cases import Cases
from overturning.model.geometry import native_size, place
from overturning.model.results import Results
from overturning.model.scene import Scene, load_scene
from overturning.motion.motion import Motion
from verification import summary
from verification.engines import installed, sides_of_scene
from verification.inputs import near_field
from verification.tables import RESULTS, ROOT, Figure, figures_table, publish, write_figures
from verification.timing import fastest

SHAFT: Final = 2
"""The element looked at, the topmost of three."""

GROUPS = (
    ("default", 2e-5, 1.0, "centred", "auto"),
    ("half the step", 2e-5, 1.0, "centred", "0.5 stable"),
    ("cundall", 2e-5, 1.0, "cundall", "auto"),
    ("less damping", 2e-5, 0.3, "centred", "auto"),
    ("softer", 5e-5, 1.0, "centred", "auto"),
    ("softest", 1e-4, 1.0, "centred", "auto"),
)
"""Label, static penetration over width, damping ratio, scheme, time step."""


def throughput() -> Iterator[Figure]:
    """Element steps per second and core; everything stands, nothing is left out."""
    time_axis = np.arange(300) * 0.01
    motion = Motion(2.0 * np.sin(9 * time_axis), 0 * time_axis, sampling_interval=0.01)
    for name, bound in (("three-tier", ">= 10"), ("against-a-wall", ""), ("boulder", "")):
        scene = load_scene(name, ROOT)
        height, ratio = native_size(scene)
        cases = Cases(0.0, height, ratio, np.linspace(0.5, 1.0, 192))
        steps = run(scene, motion, cases, Numerics(leave_out=False)).block_steps.sum()
        seconds = fastest(partial(run, scene, motion, cases, Numerics(leave_out=False)), 2)
        yield Figure(f"element steps per second and core, {name}", steps / seconds / 1e6, "million/s", bound)


def with_law(scene: Scene, static_penetration: float, damping_ratio: float) -> Scene:
    """The same scene with another contact law."""
    law = {"between": ("stone", "stone"), "static_penetration": static_penetration, "damping_ratio": damping_ratio}
    return Scene.model_validate(scene.model_dump() | {"contacts": [law]})


def against_peers(count: int) -> Iterator[Figure]:
    """A shaft on two bases: time per case and share of right outcomes."""
    scene, motion = load_scene("three-tier", ROOT), near_field(7)
    height, ratio = native_size(scene)
    grid: dict[str, Any] = {
        "azimuth_deg": np.arange(0, 360, 30.0),
        "height": np.array([height]),
        "b_over_h": np.array([0.2, 0.25, 0.3, round(ratio, 10)]),
        "friction": np.array([0.6, 1.0]),
    }
    cases = Cases(*(axis.ravel() for axis in np.meshgrid(*grid.values(), indexing="ij")))
    fine, firm = reference(scene, motion, cases)
    right = fine.overturned[:, SHAFT]
    yield Figure("cases of the sweep", cases.size)
    yield Figure("cases in which the shaft falls", 100 * float((right != 0).mean()), "%")
    yield Figure("cases without a firm outcome", 100 * float((~firm).mean()), "%")
    chosen = np.random.default_rng(1).choice(np.flatnonzero(firm), min(count, int(firm.sum())), replace=False)
    times, ended, found = {}, {}, {}
    for name in installed():
        _, ended[name] = engine_run(name, scene, motion, cases, chosen, early=True)
        found[name], times[name] = engine_run(name, scene, motion, cases, chosen, early=False)
        yield Figure(f"{name}: time per case", times[name] * 1e3, "ms")
        yield Figure(f"{name}: time per case, ended when the shaft has fallen", ended[name] * 1e3, "ms")
        yield Figure(f"{name}: shaft's side right", 100 * float((found[name] == right[chosen]).mean()), "%")
    if len(found) == 2:
        one, other = found.values()
        yield Figure("agreement of the peers with each other", 100 * float((one == other).mean()), "%")
    for label, penetration, damping, scheme, step in GROUPS:
        stones = with_law(scene, penetration, damping)
        options: dict[str, Any] = {"scheme": scheme, "time_step": step}
        coarse = run(stones, motion, cases, Numerics(leave_out=False, **options))
        whole = fastest(partial(run, stones, motion, cases, Numerics(leave_out=False, **options)), 2)
        left = fastest(partial(simulate_arrays, motion, scene=stones, **options, **grid), 2)
        whole, left = whole / cases.size, left / cases.size
        same = coarse.overturned[:, SHAFT] == right
        stands = firm & same & (right == 0)
        error = np.abs(coarse.peak_rotation[stands, SHAFT] / fine.peak_rotation[stands, SHAFT] - 1)
        yield Figure(f"{label}: time per case, nothing left out", whole * 1e3, "ms")
        yield Figure(
            f"{label}: time per case, as a user runs it", left * 1e3, "ms", "<= 2" if label == "default" else ""
        )
        yield Figure(f"{label}: shaft's side right, peers' cases", 100 * float(same[chosen].mean()), "%")
        yield Figure(f"{label}: shaft's side right, all firm", 100 * float(same[firm].mean()), "%")
        yield Figure(f"{label}: error of the shaft's peak rotation, median", 100 * float(np.median(error)), "%")
        stands = firm[:, None] & (coarse.overturned == fine.overturned) & (fine.overturned == 0)
        error = np.abs(coarse.peak_rotation[stands] / fine.peak_rotation[stands] - 1)
        yield Figure(f"{label}: error of all peak rotations, median", 100 * float(np.median(error)), "%")
        for name, each in times.items():
            bound = ">= 50 at equal agreement" if name == "pymunk" and label == "default" else ""
            yield Figure(f"{label}: faster than {name}, nothing left out", each / whole, "x")
            yield Figure(f"{label}: faster than {name}, as a user runs it", each / left, "x", bound)
        if label == "default":
            for name, each in ended.items():
                bound = ">= 25 at equal agreement" if name == "pymunk" else ""
                yield Figure(
                    f"{label}: faster than {name} that ends too when the shaft has fallen", each / left, "x", bound
                )


def engine_run(
    name: str, scene: Scene, motion: Motion, cases: Cases, chosen: np.ndarray, early: bool
) -> tuple[np.ndarray, float]:
    """Sides to which the shaft falls in an engine, and its time per case, s."""
    engine, start, sides = installed()[name], time.process_time(), []
    for azimuth, height, ratio, friction in zip(
        *(
            np.asarray(axis)[chosen].tolist()
            for axis in (cases.azimuth_deg, cases.height, cases.b_over_h, cases.friction)
        ),
        strict=True,
    ):
        placed, wave = place(scene, height, ratio)[1:], motion.along(azimuth)
        sides.append(sides_of_scene(engine, placed, wave, motion.sampling_interval, friction, early=early)[SHAFT])
    return np.array(sides), (time.process_time() - start) / chosen.size


def reference(scene: Scene, motion: Motion, cases: Cases) -> tuple[Results, np.ndarray]:
    """Outcome at a tenth of the default step, and where twice that step and Cundall's scheme find the same side."""
    fine = run(scene, motion, cases, Numerics(time_step="0.1 stable", leave_out=False))
    firm = np.ones(cases.size, dtype=bool)
    for scheme, step in (("centred", "0.2 stable"), ("cundall", "0.3 stable")):
        other = run(scene, motion, cases, Numerics(scheme=scheme, time_step=step))
        firm &= other.overturned[:, SHAFT] == fine.overturned[:, SHAFT]
    return fine, firm


def main(
    peer_cases: Annotated[int, typer.Option(min=1, help="cases that the peers run")] = 40,
    steps_only: Annotated[
        bool, typer.Option(help="element steps per second alone; the other figures are kept")
    ] = False,
) -> None:
    """Measure how fast and how exact scenes are."""
    figures = []
    for figure in (*throughput(), *(() if steps_only else against_peers(peer_cases))):
        figures.append(figure)
        print(*figure, sep=" | ", flush=True)
    figures = write_figures(figures, RESULTS / "scenes.csv", keep=steps_only)
    others = tuple(f"{label}:" for label, *_ in GROUPS[1:])
    shown = [figure for figure in figures if not figure.quantity.startswith(others)]
    publish({"scene-speed": figures_table(shown)} | summary.bodies())


if __name__ == "__main__":
    typer.run(main)
