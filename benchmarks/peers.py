"""The same block in Box2D and pymunk: rigid-body engines that solve contacts as constraints.

Both get the shaking as a gravity vector that turns and stretches with time, which is exact for a rigid base.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

GRAVITY = 9.80665
STEP = 1.0 / 240.0
SCALE = 20.0  # Box2D's tolerances suit metres-sized bodies; a gravestone is shown to it twenty times as large


def resample(acceleration: np.ndarray, interval: float, seconds_after: float = 5.0) -> np.ndarray:
    """Acceleration at the engines' own steps, zero after the record."""
    end = acceleration.size * interval + seconds_after
    times = (np.arange(int(end / STEP)) + 0.5) * STEP
    return np.interp(times, np.arange(acceleration.size) * interval, acceleration, right=0.0)


def box2d(acceleration: np.ndarray, interval: float, height: float, b_over_h: float, friction: float) -> int:
    """Side to which the block falls in Box2D."""
    from Box2D import b2EdgeShape, b2PolygonShape, b2World

    world = b2World(gravity=(0.0, -GRAVITY * SCALE), doSleep=False)
    world.CreateStaticBody(shapes=b2EdgeShape(vertices=[(-1000, 0), (1000, 0)])).fixtures[0].friction = friction
    half = (0.5 * height * b_over_h * SCALE, 0.5 * height * SCALE)
    # Without this the block falls asleep before the shaking begins, whatever the world's doSleep says.
    body = world.CreateDynamicBody(position=(0.0, half[1]), allowSleep=False)
    body.CreateFixture(shape=b2PolygonShape(box=half), density=1.0, friction=friction, restitution=0.0)
    for ground in resample(acceleration, interval):
        world.gravity = (-ground * SCALE, -GRAVITY * SCALE)
        world.Step(STEP, 30, 10)
        if abs(body.angle) > 0.5 * math.pi * 0.98:
            return -1 if body.angle > 0 else 1
    return 0


def pymunk(acceleration: np.ndarray, interval: float, height: float, b_over_h: float, friction: float) -> int:
    """Side to which the block falls in pymunk."""
    import pymunk as engine

    space = engine.Space()
    space.iterations = 30
    space.collision_slop = 1e-5
    space.collision_bias = 0.1**60
    ground_line = engine.Segment(space.static_body, (-100, 0), (100, 0), 0.0)
    ground_line.friction = 1.0
    width = height * b_over_h
    body = engine.Body(1.0, engine.moment_for_box(1.0, (width, height)))
    body.position = (0.0, 0.5 * height)
    box = engine.Poly.create_box(body, (width, height))
    box.friction = friction  # pymunk multiplies the two
    space.add(ground_line, body, box)
    for ground in resample(acceleration, interval):
        space.gravity = (-float(ground), -GRAVITY)
        space.step(STEP)
        if abs(body.angle) > 0.5 * math.pi * 0.98:
            return -1 if body.angle > 0 else 1
    return 0


def available() -> dict[str, Callable[..., Any]]:
    """The engines that are installed (dependency group `peers`)."""
    found: dict[str, Callable[..., Any]] = {}
    for name, module, run in (("Box2D", "Box2D", box2d), ("pymunk", "pymunk", pymunk)):
        try:
            __import__(module)
        except ImportError:
            continue
        found[name] = run
    return found
