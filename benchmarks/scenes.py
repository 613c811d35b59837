"""How fast and how exact scenes are: element steps per second, and a stacked grave against pymunk and Box2D.

Usage: python -m benchmarks.scenes [--output FILE.csv] [--peer-cases N]

All times are processor times of one core in one run, the least of three after a warm-up (the peers': of one). Right is what the
general kernel finds with a fifth of the default step, on cases whose flags it finds at one and a half times that step as well.
"""

import argparse
import csv
import math
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from overturning.dem.blocks import Cases
from overturning.dem.polygon.cases import run_scene_cases
from overturning.dem.polygon.geometry import Placed, native_size, place
from overturning.dem.polygon.scene import load_scene
from overturning.dem.polygon.simulate import simulate_scene_arrays
from overturning.motion.motion import Motion

GRAVITY = 9.80665
STEP = 1.0 / 240.0
SCALE = 20.0  # Box2D's tolerances suit bodies of metres
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


def resample(acceleration: np.ndarray, interval: float) -> np.ndarray:
    """Acceleration at the engines' own steps, zero after the record."""
    times = (np.arange(int((acceleration.size * interval + AFTER) / STEP)) + 0.5) * STEP
    return np.interp(times, np.arange(acceleration.size) * interval, acceleration, right=0.0)


def pymunk(placed: list[Placed], acceleration: np.ndarray, interval: float, friction: float) -> list[int]:
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
    for ground in resample(acceleration, interval):
        space.gravity = (-float(ground), -GRAVITY)
        space.step(STEP)
        for index, body in enumerate(bodies):
            if sides[index] == 0 and abs(body.angle) > 0.49 * math.pi:
                sides[index] = -1 if body.angle > 0 else 1
        if all(sides):
            break
    return sides


def box2d(placed: list[Placed], acceleration: np.ndarray, interval: float, friction: float) -> list[int]:
    """Sides to which the elements fall in Box2D."""
    from Box2D import b2EdgeShape, b2PolygonShape, b2World

    world = b2World(gravity=(0.0, -GRAVITY * SCALE), doSleep=False)
    world.CreateStaticBody(shapes=b2EdgeShape(vertices=[(-1000, 0), (1000, 0)])).fixtures[0].friction = friction
    bodies = []
    for item in placed:
        body = world.CreateDynamicBody(position=(item.x * SCALE, item.z * SCALE))
        shape = b2PolygonShape(vertices=[(x * SCALE, z * SCALE) for x, z in item.shape.vertices.tolist()])
        density = item.mass / item.shape.area
        body.CreateFixture(shape=shape, density=density, friction=friction, restitution=0.0)
        bodies.append(body)
    sides = [0] * len(bodies)
    for ground in resample(acceleration, interval):
        world.gravity = (-float(ground) * SCALE, -GRAVITY * SCALE)
        world.Step(STEP, 30, 10)
        for index, body in enumerate(bodies):
            if sides[index] == 0 and abs(body.angle) > 0.49 * math.pi:
                sides[index] = -1 if body.angle > 0 else 1
        if all(sides):
            break
    return sides


def throughput() -> list[tuple[str, float, str, str]]:
    """Element steps per second and core; everything stands, nothing is left out."""
    time_axis = np.arange(1000) * 0.01
    motion = Motion(2.0 * np.sin(9 * time_axis), 0 * time_axis, sampling_interval=0.01)
    rows = []
    for name, bound in (("three-tier", ">= 10"), ("against-a-wall", ""), ("boulder", "")):
        scene = load_scene(name, ROOT)
        height, ratio = native_size(scene)
        cases = Cases(0.0, height, ratio, np.linspace(0.5, 1.0, 192))
        steps = run_scene_cases(scene, motion, cases, leave_out=False).block_steps.sum()
        seconds = fastest(lambda s=scene, c=cases: run_scene_cases(s, motion, c, leave_out=False))
        rows.append((f"element steps per second and core, {name}", steps / seconds / 1e6, "million/s", bound))
    return rows


def against_peers(count: int) -> list[tuple[str, float, str, str]]:
    """A shaft on two bases: time per case and share of right outcomes."""
    scene, motion = load_scene("three-tier", ROOT), record()
    height, ratio = native_size(scene)
    azimuths, slender, friction = np.arange(0, 360, 15.0), (0.2, 0.25, 0.3, round(ratio, 10)), (0.5, 0.8, 1.1)
    grid = np.meshgrid(azimuths, [height], slender, friction, indexing="ij")
    cases = Cases(*(axis.ravel() for axis in grid))
    given = {"azimuth_deg": azimuths, "height": [height], "b_over_h": slender, "friction": friction}
    fine = run_scene_cases(scene, motion, cases, time_step="0.1 stable").overturned
    firm = (fine == run_scene_cases(scene, motion, cases, time_step="0.15 stable").overturned).all(axis=1)
    whole = fastest(lambda: run_scene_cases(scene, motion, cases, leave_out=False), 1) / cases.size
    default = fastest(lambda: simulate_scene_arrays(scene, motion, **given), 1) / cases.size
    coarse = run_scene_cases(scene, motion, cases).overturned
    rows = [
        ("cases of the sweep", float(cases.size), "", ""),
        ("cases in which the shaft falls", 100 * float((fine[:, 2] != 0).mean()), "%", ""),
        ("cases without a firm outcome", 100 * float((~firm).mean()), "%", ""),
        ("time per case, nothing left out", whole * 1e3, "ms", ""),
        ("time per case, default", default * 1e3, "ms", ""),
        ("shaft's side as with the fine step", 100 * float((coarse == fine)[firm, 2].mean()), "%", ""),
    ]
    chosen = np.random.default_rng(1).choice(np.flatnonzero(firm), min(count, int(firm.sum())), replace=False)
    found = {}
    for name, run in available().items():
        start = time.process_time()
        sides = []
        for i in chosen:
            item = np.asarray(cases.azimuth_deg)[i], np.asarray(cases.b_over_h)[i], np.asarray(cases.friction)[i]
            placed = place(scene, height, float(item[1]))[1:]
            sides.append(run(placed, motion.along(float(item[0])), motion.sampling_interval, float(item[2])))
        each = (time.process_time() - start) / chosen.size
        found[name] = np.array(sides)
        rows += [
            (f"{name}: time per case", each * 1e3, "ms", ""),
            (
                f"{name}: shaft's side as with the fine step",
                100 * float((found[name] == fine[chosen])[:, 2].mean()),
                "%",
                "",
            ),
            (f"faster than {name}, nothing left out", each / whole, "x", ""),
            (f"faster than {name}, default", each / default, "x", ">= 20" if name == "pymunk" else ""),
        ]
    if len(found) == 2:
        one, other = found.values()
        rows.append(("agreement of the peers with each other", 100 * float((one == other)[:, 2].mean()), "%", ""))
        rows.append(("agreement with ours, same cases", 100 * float((coarse == fine)[chosen, 2].mean()), "%", ""))
    return rows


def available() -> dict[str, Callable[..., list[int]]]:
    """The engines that are installed (dependency group `peers`)."""
    found = {}
    for name, module, run in (("pymunk", "pymunk", pymunk), ("Box2D", "Box2D", box2d)):
        try:
            __import__(module)
        except ImportError:
            print(f"{name} is not installed: pip install 'overturning[peers]'")
            continue
        found[name] = run
    return found


def main() -> None:
    """Measure, print the table and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks" / "results" / "scenes.csv")
    parser.add_argument("--peer-cases", type=int, default=40)
    arguments = parser.parse_args()
    rows = throughput() + against_peers(arguments.peer_cases)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    with arguments.output.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("figure", "value", "unit", "target"))
        for name, value, unit, bound in rows:
            print(f"{name:55s} {value:10.4g} {unit:10s} {bound}")
            writer.writerow((name, f"{value:.4g}", unit, bound))
        writer.writerow(("processor", platform.machine(), "", ""))


if __name__ == "__main__":
    main()
