"""The same stones in Box2D, pymunk and MuJoCo: rigid-body engines that solve contacts as constraints.

All get the shaking as a gravity vector that turns and stretches with time, which is exact for a rigid base. They are
installed by `make peers` (dependency group `peers`); one that is not is left out.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from importlib.util import find_spec
from typing import Any, Final, NamedTuple

import numpy as np

from overturning.model.geometry import Placed
from overturning.units import STANDARD_GRAVITY

STEP: Final = 1.0 / 240.0
"""Time step where none is asked for, s."""

SCALE: Final = 20.0
"""Box2D's tolerances suit bodies of metres; a gravestone is shown to it twenty times as large."""

FALLEN: Final = 0.49 * math.pi
"""Rotation from which a stone has fallen, rad."""

AFTER_BLOCK: Final = 5.0
AFTER_SCENE: Final = 3.0
"""Seconds for which a block and a scene go on after the record."""


class Stone(NamedTuple):
    """A free body: place of its centre (m), corners about it (m), mass per metre of depth (kg/m), moment of inertia."""

    x: float
    z: float
    corners: Sequence[tuple[float, float]]
    mass: float
    inertia: float


def block(height: float, b_over_h: float) -> Stone:
    """A rectangle on the ground, of unit mass."""
    b, h = 0.5 * height * b_over_h, 0.5 * height
    return Stone(0.0, h, ((-b, -h), (b, -h), (b, h), (-b, h)), 1.0, (b * b + h * h) / 3.0)


def stones(placed: Iterable[Placed]) -> list[Stone]:
    """The free elements of a scene."""
    return [Stone(one.x, one.z, one.shape.vertices.tolist(), one.mass, one.inertia) for one in placed]


def resample(acceleration: np.ndarray, interval: float, step: float, after: float) -> np.ndarray:
    """Acceleration at the engines' own steps, zero after the record."""
    times = (np.arange(int((acceleration.size * interval + after) / step)) + 0.5) * step
    return np.interp(times, np.arange(acceleration.size) * interval, acceleration, right=0.0)


def _sides(bodies: list[Any], ground: np.ndarray, advance: Callable[[float], None], early: bool) -> list[int]:
    """Sides to which bodies fall, in the order given; `early` ends when the last has fallen."""
    sides = [0] * len(bodies)
    for acceleration in ground.tolist():
        advance(acceleration)
        for index, body in enumerate(bodies):
            if sides[index] == 0 and abs(body.angle) > FALLEN:
                sides[index] = -1 if body.angle > 0 else 1
        if all(sides) or (early and sides[-1]):
            break
    return sides


def box2d(free: Sequence[Stone], ground: np.ndarray, friction: float, step: float, early: bool = False) -> list[int]:
    """Sides to which stones fall in Box2D under an acceleration given at the engine's steps."""
    from Box2D import b2EdgeShape, b2PolygonShape, b2World

    world = b2World(gravity=(0.0, -STANDARD_GRAVITY * SCALE), doSleep=False)
    world.CreateStaticBody(shapes=b2EdgeShape(vertices=[(-1000, 0), (1000, 0)])).fixtures[0].friction = friction
    bodies = []
    for stone in free:
        # Without this a stone falls asleep before the shaking begins, whatever the world's doSleep says.
        body = world.CreateDynamicBody(position=(stone.x * SCALE, stone.z * SCALE), allowSleep=False)
        shape = b2PolygonShape(vertices=[(x * SCALE, z * SCALE) for x, z in stone.corners])
        body.CreateFixture(shape=shape, density=stone.mass / _area(stone), friction=friction, restitution=0.0)
        bodies.append(body)

    def advance(acceleration: float) -> None:
        world.gravity = (-acceleration * SCALE, -STANDARD_GRAVITY * SCALE)
        world.Step(step, 30, 10)

    return _sides(bodies, ground, advance, early)


def pymunk(free: Sequence[Stone], ground: np.ndarray, friction: float, step: float, early: bool = False) -> list[int]:
    """Sides to which stones fall in pymunk under an acceleration given at the engine's steps."""
    import pymunk as engine

    space = engine.Space()
    space.iterations = 30
    space.collision_slop = 1e-5
    space.collision_bias = 0.1**60
    line = engine.Segment(space.static_body, (-100, 0), (100, 0), 0.0)
    line.friction = math.sqrt(friction)  # pymunk multiplies the two
    space.add(line)
    bodies = []
    for stone in free:
        body = engine.Body(stone.mass, stone.inertia)
        body.position = (stone.x, stone.z)
        shape = engine.Poly(body, list(stone.corners))
        shape.friction = math.sqrt(friction)
        space.add(body, shape)
        bodies.append(body)

    def advance(acceleration: float) -> None:
        space.gravity = (-acceleration, -STANDARD_GRAVITY)
        space.step(step)

    return _sides(bodies, ground, advance, early)


def mujoco(free: Sequence[Stone], ground: np.ndarray, friction: float, step: float) -> list[int]:
    """Side to which a block falls in MuJoCo: a box in a plane, a metre deep."""
    import mujoco as engine

    (stone,) = free
    (b, h) = stone.corners[2]
    model = engine.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{step}" integrator="implicitfast" cone="elliptic"/>
        <default><geom friction="{friction} 0 0" condim="3" solref="{2.0 * step} 1"/></default>
        <worldbody><geom type="plane" size="100 100 1"/><body pos="0 0 {h}">
        <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
        <geom type="box" size="{b} 0.5 {h}" mass="1"/></body></worldbody></mujoco>"""
    )
    data = engine.MjData(model)
    model.opt.gravity[2] = -STANDARD_GRAVITY
    for acceleration in ground.tolist():
        model.opt.gravity[0] = -acceleration
        engine.mj_step(model, data)
        if abs(data.qpos[2]) > FALLEN:
            return [1 if data.qpos[2] > 0 else -1]
    return [0]


Engine = Callable[..., list[int]]
ENGINES: Final[dict[str, Engine]] = {"Box2D": box2d, "pymunk": pymunk, "MuJoCo": mujoco}
"""By name."""


def installed(names: Iterable[str] = ("Box2D", "pymunk")) -> dict[str, Engine]:
    """The engines that are installed; a note for each that is not."""
    found = {}
    for name in names:
        if find_spec(name if name == "Box2D" else name.lower()) is None:
            print(f"{name} is not installed: make peers")
        else:
            found[name] = ENGINES[name]
    return found


def side_of_block(
    engine: Engine, acceleration: np.ndarray, interval: float, height: float, b_over_h: float, friction: float,
    step: float = STEP,
) -> int:  # fmt: skip
    """Side to which a block falls in an engine."""
    ground = resample(acceleration, interval, step, AFTER_BLOCK)
    return engine([block(height, b_over_h)], ground, friction, step)[0]


def sides_of_scene(
    engine: Engine, placed: Iterable[Placed], acceleration: np.ndarray, interval: float, friction: float,
    step: float = STEP, early: bool = False,
) -> list[int]:  # fmt: skip
    """Sides to which the free elements of a scene fall in an engine."""
    return engine(stones(placed), resample(acceleration, interval, step, AFTER_SCENE), friction, step, early=early)


def _area(stone: Stone) -> float:
    x, z = np.array(stone.corners).T
    return abs(float(np.dot(x, np.roll(z, -1)) - np.dot(z, np.roll(x, -1)))) / 2
