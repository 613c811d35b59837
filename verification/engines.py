"""The same stones in Box2D, pymunk, MuJoCo and Bullet: rigid-body engines that solve contacts as constraints.

All get the shaking as a gravity vector that turns and stretches with time, which is exact for a rigid base. They are
installed by `make peers` (dependency group `peers`); one that is not is left out. Directions: x and the horizontal
direction s of a plane to the azimuth, y 90° anticlockwise of it, z up.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.util import find_spec
from typing import Any, Final, NamedTuple

import numpy as np

from overturning.model.geometry import PlacedElement
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

STEP: Final = 1.0 / 240.0
"""Time step where none is asked for, s."""

SCALE: Final = 20.0
"""Box2D's tolerances suit bodies of metres; a gravestone is shown to it twenty times as large."""

FALLEN: Final = 0.49 * math.pi
"""Rotation from which a stone has fallen, rad."""

FLAT: Final = 0.05
"""Vertical component of its axis below which a prism has fallen: no engine brings it to lie within the same step."""

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


def stones(placed: Iterable[PlacedElement]) -> list[Stone]:
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
    axes = (("slide", "1 0 0"), ("slide", "0 0 1"), ("hinge", "0 1 0"))
    joints = "".join(f'<joint type="{kind}" axis="{axis}"/>' for kind, axis in axes)
    model = _mujoco_model((b, 0.5, h), joints, friction, step)
    data = engine.MjData(model)
    model.opt.gravity[2] = -STANDARD_GRAVITY
    for acceleration in ground.tolist():
        model.opt.gravity[0] = -acceleration
        engine.mj_step(model, data)
        if abs(data.qpos[2]) > FALLEN:
            return [1 if data.qpos[2] > 0 else -1]
    return [0]


def _mujoco_model(half: tuple[float, float, float], joints: str, friction: float, step: float, ratio: int = 1) -> Any:
    """A box of a kilogram on a plane; `ratio` is that of the resistances of friction and of the contact."""
    import mujoco as engine

    size = " ".join(map(str, half))
    return engine.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{step}" integrator="implicitfast" cone="elliptic" impratio="{ratio}"/>
        <default><geom friction="{friction} 0 0" condim="3" solref="{2.0 * step} 1"/></default>
        <worldbody><geom type="plane" size="100 100 1"/><body pos="0 0 {half[2]}">{joints}
        <geom type="box" size="{size}" mass="1"/></body></worldbody></mujoco>"""
    )


class Prism(NamedTuple):
    """Half sizes along x, y and z, m, and the friction coefficient."""

    b: float
    d: float
    h: float
    friction: float


def seen_from(motion: Motion, orientation_deg: float, step: float) -> np.ndarray:
    """Gravity in the frame of the base, x to the orientation, at the middle of each step."""
    along = [motion.along(orientation_deg), motion.along(orientation_deg - 90.0)]
    waves = [*along, np.zeros(motion.samples) if motion.up is None else motion.up]
    x, y, z = (resample(wave, motion.sampling_interval, step, AFTER_BLOCK) for wave in waves)
    return np.stack([-x, -y, -STANDARD_GRAVITY - z], axis=1)


def mujoco_in_space(prism: Prism, gravity: np.ndarray, step: float) -> tuple[float, float] | None:
    """Horizontal direction of the axis when the prism has fallen in MuJoCo, none where it stands."""
    import mujoco as engine

    model = _mujoco_model((prism.b, prism.d, prism.h), "<freejoint/>", prism.friction, step, ratio=10)
    data = engine.MjData(model)
    for pull in gravity:
        model.opt.gravity[:] = pull
        engine.mj_step(model, data)
        if data.xmat[1][8] < FLAT:
            return float(data.xmat[1][2]), float(data.xmat[1][5])
    return None


def bullet_in_space(prism: Prism, gravity: np.ndarray, step: float) -> tuple[float, float] | None:
    """The same in Bullet."""
    import pybullet as engine

    client = engine.connect(engine.DIRECT)
    try:
        engine.setPhysicsEngineParameter(
            fixedTimeStep=step, numSolverIterations=100, numSubSteps=0, contactSlop=0.0, enableConeFriction=1,
            erp=0.2, contactERP=0.2, frictionERP=0.2, restitutionVelocityThreshold=1e9, physicsClientId=client,
        )  # fmt: skip
        ground = engine.createMultiBody(
            0, engine.createCollisionShape(engine.GEOM_PLANE, physicsClientId=client), physicsClientId=client
        )
        shape = engine.createCollisionShape(
            engine.GEOM_BOX, halfExtents=[prism.b, prism.d, prism.h], physicsClientId=client
        )
        body = engine.createMultiBody(1.0, shape, basePosition=[0, 0, prism.h], physicsClientId=client)
        for one, friction in ((ground, 1.0), (body, prism.friction)):
            engine.changeDynamics(
                one, -1, lateralFriction=friction, rollingFriction=0, spinningFriction=0, restitution=0,
                linearDamping=0,
                angularDamping=0, collisionMargin=0.0, activationState=engine.ACTIVATION_STATE_DISABLE_SLEEPING,
                physicsClientId=client,
            )  # fmt: skip
        for pull in gravity.tolist():
            engine.setGravity(*pull, physicsClientId=client)
            engine.stepSimulation(physicsClientId=client)
            x, y, z, w = engine.getBasePositionAndOrientation(body, physicsClientId=client)[1]
            if 1.0 - 2.0 * (x * x + y * y) < FLAT:
                return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    finally:
        engine.disconnect(client)
    return None


Engine = Callable[..., list[int]]
SpaceEngine = Callable[[Prism, np.ndarray, float], tuple[float, float] | None]
ENGINES: Final[dict[str, Engine]] = {"Box2D": box2d, "pymunk": pymunk, "MuJoCo": mujoco}
SPACE_ENGINES: Final[dict[str, SpaceEngine]] = {"MuJoCo": mujoco_in_space, "Bullet": bullet_in_space}
_MODULES: Final = {"Box2D": "Box2D", "pymunk": "pymunk", "MuJoCo": "mujoco", "Bullet": "pybullet"}


def installed(engines: Mapping[str, Any], *names: str) -> dict[str, Any]:
    """The engines that are installed, of those named or of all; a note for each that is not."""
    missing = {name for name in names or engines if find_spec(_MODULES[name]) is None}
    for name in missing:
        print(f"{name} is not installed: make peers")
    return {name: engines[name] for name in names or engines if name not in missing}


def side_of_block(
    engine: Engine, acceleration: np.ndarray, interval: float, height: float, b_over_h: float, friction: float,
    step: float = STEP,
) -> int:  # fmt: skip
    """Side to which a block falls in an engine."""
    ground = resample(acceleration, interval, step, AFTER_BLOCK)
    return engine([block(height, b_over_h)], ground, friction, step)[0]


def sides_of_scene(
    engine: Engine, placed: Iterable[PlacedElement], acceleration: np.ndarray, interval: float, friction: float,
    step: float = STEP, early: bool = False,
) -> list[int]:  # fmt: skip
    """Sides to which the free elements of a scene fall in an engine."""
    return engine(stones(placed), resample(acceleration, interval, step, AFTER_SCENE), friction, step, early=early)


def fall_azimuth(engine: SpaceEngine, motion: Motion, orientation_deg: float, prism: Prism, step: float) -> float:
    """Azimuth to which the top points when the prism has fallen, degrees; NaN where it stands."""
    axis = engine(prism, seen_from(motion, orientation_deg, step), step)
    return np.nan if axis is None else float((orientation_deg - np.degrees(np.arctan2(axis[1], axis[0]))) % 360.0)


def _area(stone: Stone) -> float:
    x, z = np.array(stone.corners).T
    return abs(float(np.dot(x, np.roll(z, -1)) - np.dot(z, np.roll(x, -1)))) / 2
