"""How fast and how exact scenes are: element steps per second, and a stacked grave against pymunk and Box2D.

Usage: python -m benchmarks.scenes [--output FILE.csv] [--peer-cases N]

All times are processor times of one core in one run, the kernel's the least of two after a warm-up. Right is what the general
kernel finds with a fifth of the default step, on cases whose outcome it finds with twice that step and with Cundall's scheme as
well. Peers are compared at 1/240 s and 30 iterations.
"""

import argparse
import csv
import math
import platform
import sys
import time
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from overturning.dem.cases import Cases
from overturning.dem.numerics import Numerics
from overturning.dem.polygon.geometry import Placed, native_size, place
from overturning.dem.results import Results
from overturning.dem.run import run
from overturning.dem.scene import Scene, load_scene
from overturning.dem.simulate import simulate_arrays
from overturning.motion.motion import Motion

GRAVITY = 9.80665
STEP = 1.0 / 240.0
SCALE = 20.0  # Box2D's tolerances suit bodies of metres
Row = tuple[str, float, str, str]
ROOT = Path(__file__).parents[1]
AFTER = 3.0


def fastest(run: Callable[[], Any], repeats: int = 3) -> float:
    """Least processor time of several runs, s, after one to warm up."""
    run()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)


def record(number: int = 7) -> Motion:
    """Twenty seconds of a near-field record that throws shafts down."""
    sys.path.insert(0, str(ROOT))
    from tests.dem.near_field import near_field

    motion, _, _ = near_field(number)
    peak = int(np.argmax(np.hypot(motion.north, motion.east)))
    first = max(peak - round(6.0 / motion.sampling_interval), 0)
    span = slice(first, first + round(20.0 / motion.sampling_interval))
    return Motion(motion.north[span], motion.east[span], sampling_interval=motion.sampling_interval)


def resample(acceleration: np.ndarray, interval: float, step: float) -> np.ndarray:
    """Acceleration at the engines' own steps, zero after the record."""
    times = (np.arange(int((acceleration.size * interval + AFTER) / step)) + 0.5) * step
    return np.interp(times, np.arange(acceleration.size) * interval, acceleration, right=0.0)


def pymunk(
    placed: list[Placed], acceleration: np.ndarray, interval: float, friction: float, step: float = STEP,
    early: bool = False,
) -> list[int]:  # fmt: skip
    """Sides to which the elements fall in pymunk; the shaking is a gravity that turns and stretches."""
    import pymunk as engine

    space = engine.Space()
    space.iterations = 30
    space.collision_slop = 1e-5
    space.collision_bias = 0.1**60
    line = engine.Segment(space.static_body, (-100, 0), (100, 0), 0.0)
    line.friction = math.sqrt(friction)  # pymunk multiplies the two
    space.add(line)
    bodies = []
    for item in placed:
        body = engine.Body(item.mass, item.inertia)
        body.position = (item.x, item.z)
        shape = engine.Poly(body, item.shape.vertices.tolist())
        shape.friction = math.sqrt(friction)
        space.add(body, shape)
        bodies.append(body)
    sides = [0] * len(bodies)
    for ground in resample(acceleration, interval, step):
        space.gravity = (-float(ground), -GRAVITY)
        space.step(step)
        for index, body in enumerate(bodies):
            if sides[index] == 0 and abs(body.angle) > 0.49 * math.pi:
                sides[index] = -1 if body.angle > 0 else 1
        if all(sides) or (early and sides[-1]):
            break
    return sides


def box2d(
    placed: list[Placed], acceleration: np.ndarray, interval: float, friction: float, step: float = STEP,
    early: bool = False,
) -> list[int]:  # fmt: skip
    """Sides to which the elements fall in Box2D."""
    from Box2D import b2EdgeShape, b2PolygonShape, b2World

    world = b2World(gravity=(0.0, -GRAVITY * SCALE), doSleep=False)
    world.CreateStaticBody(shapes=b2EdgeShape(vertices=[(-1000, 0), (1000, 0)])).fixtures[0].friction = friction
    bodies = []
    for item in placed:
        # Without this a stone falls asleep before the shaking begins, whatever the world's doSleep says.
        body = world.CreateDynamicBody(position=(item.x * SCALE, item.z * SCALE), allowSleep=False)
        shape = b2PolygonShape(vertices=[(x * SCALE, z * SCALE) for x, z in item.shape.vertices.tolist()])
        density = item.mass / item.shape.area
        body.CreateFixture(shape=shape, density=density, friction=friction, restitution=0.0)
        bodies.append(body)
    sides = [0] * len(bodies)
    for ground in resample(acceleration, interval, step):
        world.gravity = (-float(ground) * SCALE, -GRAVITY * SCALE)
        world.Step(step, 30, 10)
        for index, body in enumerate(bodies):
            if sides[index] == 0 and abs(body.angle) > 0.49 * math.pi:
                sides[index] = -1 if body.angle > 0 else 1
        if all(sides) or (early and sides[-1]):
            break
    return sides


def throughput() -> Iterator[Row]:
    """Element steps per second and core; everything stands, nothing is left out."""
    time_axis = np.arange(300) * 0.01
    motion = Motion(2.0 * np.sin(9 * time_axis), 0 * time_axis, sampling_interval=0.01)
    for name, bound in (("three-tier", ">= 10"), ("against-a-wall", ""), ("boulder", "")):
        scene = load_scene(name, ROOT)
        height, ratio = native_size(scene)
        cases = Cases(0.0, height, ratio, np.linspace(0.5, 1.0, 192))
        steps = run(scene, motion, cases, Numerics(leave_out=False)).block_steps.sum()
        seconds = fastest(lambda s=scene, c=cases: run(s, motion, c, Numerics(leave_out=False)), 2)
        yield (f"element steps per second and core, {name}", steps / seconds / 1e6, "million/s", bound)


def with_law(scene: Scene, static_penetration: float, damping_ratio: float) -> Scene:
    """The same scene with another contact law."""
    law = {"between": ("stone", "stone"), "static_penetration": static_penetration, "damping_ratio": damping_ratio}
    return Scene.model_validate(scene.model_dump() | {"contacts": [law]})


def against_peers(count: int) -> Iterator[Row]:
    """A shaft on two bases: time per case and share of right outcomes."""
    scene, motion = load_scene("three-tier", ROOT), record()
    height, ratio = native_size(scene)
    azimuths, slender, friction = np.arange(0, 360, 30.0), (0.2, 0.25, 0.3, round(ratio, 10)), (0.6, 1.0)
    grid = np.meshgrid(azimuths, [height], slender, friction, indexing="ij")
    cases = Cases(*(axis.ravel() for axis in grid))
    given = {"azimuth_deg": azimuths, "height": [height], "b_over_h": slender, "friction": friction}
    fine, firm = reference(scene, motion, cases)
    right = fine.overturned[:, 2]
    yield ("cases of the sweep", float(cases.size), "", "")
    yield ("cases in which the shaft falls", 100 * float((right != 0).mean()), "%", "")
    yield ("cases without a firm outcome", 100 * float((~firm).mean()), "%", "")
    chosen = np.random.default_rng(1).choice(np.flatnonzero(firm), min(count, int(firm.sum())), replace=False)
    times, ended, found = {}, {}, {}
    for name, engine in available().items():
        for early, spent in ((False, times), (True, ended)):
            start = time.process_time()
            sides = []
            for i in chosen:
                item = np.asarray(cases.azimuth_deg)[i], np.asarray(cases.b_over_h)[i], np.asarray(cases.friction)[i]
                placed = place(scene, height, float(item[1]))[1:]
                sides.append(
                    engine(placed, motion.along(float(item[0])), motion.sampling_interval, float(item[2]), early=early)
                )
            spent[name] = (time.process_time() - start) / chosen.size
            found[name] = np.array(sides)[:, 2]
        yield (f"{name}: time per case", times[name] * 1e3, "ms", "")
        yield (f"{name}: time per case, ended when the shaft has fallen", ended[name] * 1e3, "ms", "")
        yield (f"{name}: shaft's side right", 100 * float((found[name] == right[chosen]).mean()), "%", "")
    if len(found) == 2:
        one, other = found.values()
        yield ("agreement of the peers with each other", 100 * float((one == other).mean()), "%", "")
    for label, penetration, damping, scheme, step in GROUPS:
        stones = with_law(scene, penetration, damping)
        options = {"scheme": scheme, "time_step": step}
        whole = fastest(lambda s=stones, o=options: run(s, motion, cases, Numerics(leave_out=False, **o)), 2)
        left = fastest(lambda s=stones, o=options: simulate_arrays(motion, scene=s, **o, **given), 2)
        whole, left = whole / cases.size, left / cases.size
        coarse = run(stones, motion, cases, Numerics(leave_out=False, **options))
        same = coarse.overturned[:, 2] == right
        stands = firm & same & (right == 0)
        error = np.abs(coarse.peak_rotation[stands, 2] / fine.peak_rotation[stands, 2] - 1)
        yield (f"{label}: time per case, nothing left out", whole * 1e3, "ms", "")
        yield (f"{label}: time per case, as a user runs it", left * 1e3, "ms", "<= 2" if label == "default" else "")
        yield (f"{label}: shaft's side right, peers' cases", 100 * float(same[chosen].mean()), "%", "")
        yield (f"{label}: shaft's side right, all firm", 100 * float(same[firm].mean()), "%", "")
        yield (f"{label}: error of the shaft's peak rotation, median", 100 * float(np.median(error)), "%", "")
        for name, each in times.items():
            bound = ">= 20 at equal agreement" if name == "pymunk" and label == "default" else ""
            yield (f"{label}: faster than {name}, nothing left out", each / whole, "x", "")
            yield (f"{label}: faster than {name}, as a user runs it", each / left, "x", bound)
        if label == "default":
            for name, each in ended.items():
                yield (f"{label}: faster than {name} that ends too when the shaft has fallen", each / left, "x", "")


GROUPS = (
    ("default", 2e-5, 1.0, "centred", "auto"),
    ("largest step", 2e-5, 1.0, "centred", "0.9 stable"),
    ("cundall", 2e-5, 1.0, "cundall", "auto"),
    ("less damping", 2e-5, 0.3, "centred", "auto"),
    ("softer", 5e-5, 1.0, "centred", "auto"),
    ("softest", 1e-4, 1.0, "centred", "auto"),
)
"""Label, static penetration over width, damping ratio, scheme, time step."""


def reference(scene: Scene, motion: Motion, cases: Cases) -> tuple[Results, np.ndarray]:
    """Outcome at a fifth of the default step, and where twice that step and Cundall's scheme find the same side."""
    fine = run(scene, motion, cases, Numerics(time_step="0.1 stable"))
    firm = np.ones(cases.size, dtype=bool)
    for scheme, step in (("centred", "0.2 stable"), ("cundall", "0.3 stable")):
        other = run(scene, motion, cases, Numerics(scheme=scheme, time_step=step))
        firm &= other.overturned[:, 2] == fine.overturned[:, 2]
    return fine, firm


def available() -> dict[str, Callable[..., list[int]]]:
    """The engines that are installed (dependency group `peers`)."""
    found = {}
    for name, module, engine in (("pymunk", "pymunk", pymunk), ("Box2D", "Box2D", box2d)):
        try:
            __import__(module)
        except ImportError:
            print(f"{name} is not installed: pip install 'overturning[peers]'")
            continue
        found[name] = engine
    return found


MARKS = ("<!-- figures: made by `python -m benchmarks.scenes`, do not edit -->", "<!-- end of figures -->")


def write_table(rows: list[Row], page: Path) -> None:
    """Put the figures as a table between their marks in a page."""
    text = page.read_text(encoding="utf-8")
    before, _, rest = text.partition(MARKS[0])
    _, _, after = rest.partition(MARKS[1])
    lines = ["| figure | value | target |", "|---|---|---|"]
    lines += [f"| {name} | {value:.4g} {unit} | {bound} |" for name, value, unit, bound in rows]
    page.write_text(f"{before}{MARKS[0]}\n\n" + "\n".join(lines) + f"\n\n{MARKS[1]}{after}", encoding="utf-8")


def main() -> None:
    """Measure, print the table and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks" / "results" / "scenes.csv")
    parser.add_argument("--peer-cases", type=int, default=40)
    arguments = parser.parse_args()
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    with arguments.output.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("figure", "value", "unit", "target"))
        rows = []
        for name, value, unit, bound in chain(throughput(), against_peers(arguments.peer_cases)):
            rows.append((name, value, unit, bound))
            print(f"{name:62s} {value:10.4g} {unit:10s} {bound}", flush=True)
            writer.writerow((name, f"{value:.4g}", unit, bound))
        writer.writerow(("machine", platform.machine(), "", ""))
    write_table(rows, ROOT / "docs" / "scenes.md")


if __name__ == "__main__":
    main()
