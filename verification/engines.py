"""Simulation of stones with Box2D, pymunk, MuJoCo and Bullet: rigid-body engines that solve contacts as constraints.

The shaking is applied as a time-dependent gravity vector, which is exact for a rigid base. `make peers` installs the
engines (dependency group `peers`); missing ones are skipped. Directions: x (in 2-D: s) towards the azimuth, y 90°
anticlockwise of it, z up.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.util import find_spec
from typing import Any, Final, NamedTuple, TypeVar

import numpy as np

from overturning.model.geometry import PlacedElement
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

DEFAULT_TIME_STEP_S: Final = 1.0 / 240.0
"""Default time step, s."""

BOX2D_LENGTH_OVER_TRUE_LENGTH: Final = 20.0
"""Factor on all lengths for Box2D, whose tolerances are made for bodies of metres."""

MIN_ROTATION_OF_FALLEN_BODY_RAD: Final = 0.49 * math.pi
"""Rotation from which a stone counts as fallen, rad."""

MAX_VERTICAL_COMPONENT_OF_FALLEN_AXIS: Final = 0.05
"""Vertical component of the axis below which a prism counts as fallen."""

BLOCK_SIMULATION_TIME_AFTER_RECORD_S: Final = 5.0
SCENE_SIMULATION_TIME_AFTER_RECORD_S: Final = 3.0
"""Simulated time after the record, s, for a block and for a scene."""


class PlanarBody(NamedTuple):
    """Free 2-D body: centre, m, corners from the centre, m, mass, kg, and moment of inertia, kg m², per m of depth."""

    centre_x: float
    centre_z: float
    corners_from_centre: Sequence[tuple[float, float]]
    mass_per_metre_depth: float
    inertia_about_centre_per_metre_depth: float


def rectangular_planar_body_of_unit_mass(height: float, b_over_h: float) -> PlanarBody:
    """Return a rectangular stone that stands on the ground, with unit mass."""
    b, h = 0.5 * height * b_over_h, 0.5 * height
    return PlanarBody(0.0, h, ((-b, -h), (b, -h), (b, h), (-b, h)), 1.0, (b * b + h * h) / 3.0)


def convert_elements_to_planar_bodies(free_elements: Iterable[PlacedElement]) -> list[PlanarBody]:
    """Convert the free elements of a scene (those neither driven nor fixed) to 2-D bodies for a physics engine."""
    return [
        PlanarBody(
            one.centre_of_mass_x,
            one.centre_of_mass_z,
            one.shape.vertices_from_whole_polygon_centroid.tolist(),
            one.mass,
            one.inertia_about_centre_of_mass,
        )
        for one in free_elements
    ]


def interpolate_acceleration_at_step_middles(
    record_acceleration: np.ndarray, sampling_interval: float, time_step: float, time_after_record: float
) -> np.ndarray:
    """Interpolate one acceleration component at the middle of each time step of an engine; 0 after the record."""
    times = (
        np.arange(int((record_acceleration.size * sampling_interval + time_after_record) / time_step)) + 0.5
    ) * time_step
    return np.interp(times, np.arange(record_acceleration.size) * sampling_interval, record_acceleration, right=0.0)


def _simulate_fall_sides(
    engine_bodies: list[Any],
    ground_acceleration_by_time_step: np.ndarray,
    advance_engine_one_step: Callable[[float], None],
    stop_after_fall_of_last_listed_body: bool,
) -> list[int]:
    """Run a physics engine and return the side to which each body falls (±1; 0: none).

    With `stop_after_fall_of_last_listed_body`, end when the last body of the list has fallen.
    """
    sides = [0] * len(engine_bodies)
    for acceleration in ground_acceleration_by_time_step.tolist():
        advance_engine_one_step(acceleration)
        for index, body in enumerate(engine_bodies):
            if sides[index] == 0 and abs(body.angle) > MIN_ROTATION_OF_FALLEN_BODY_RAD:
                sides[index] = -1 if body.angle > 0 else 1
        if all(sides) or (stop_after_fall_of_last_listed_body and sides[-1]):
            break
    return sides


def fall_sides_in_box2d(
    free_bodies: Sequence[PlanarBody],
    ground_acceleration_by_time_step: np.ndarray,
    friction: float,
    time_step: float,
    stop_after_fall_of_last_listed_body: bool = False,
) -> list[int]:
    """Return the side to which each stone falls in Box2D under ground accelerations at its time steps."""
    from Box2D import b2EdgeShape, b2PolygonShape, b2World

    world = b2World(gravity=(0.0, -STANDARD_GRAVITY * BOX2D_LENGTH_OVER_TRUE_LENGTH), doSleep=False)
    world.CreateStaticBody(shapes=b2EdgeShape(vertices=[(-1000, 0), (1000, 0)])).fixtures[0].friction = friction
    bodies = []
    for stone in free_bodies:
        # Otherwise a stone is set to sleep before the shaking begins, in spite of doSleep=False of the world.
        body = world.CreateDynamicBody(
            position=(stone.centre_x * BOX2D_LENGTH_OVER_TRUE_LENGTH, stone.centre_z * BOX2D_LENGTH_OVER_TRUE_LENGTH),
            allowSleep=False,
        )
        shape = b2PolygonShape(
            vertices=[
                (x * BOX2D_LENGTH_OVER_TRUE_LENGTH, z * BOX2D_LENGTH_OVER_TRUE_LENGTH)
                for x, z in stone.corners_from_centre
            ]
        )
        body.CreateFixture(
            shape=shape, density=stone.mass_per_metre_depth / _polygon_area(stone), friction=friction, restitution=0.0
        )
        bodies.append(body)

    def advance_world(ground_acceleration: float) -> None:
        """Move the world of Box2D by a time step under a ground acceleration, m/s²."""
        world.gravity = (
            -ground_acceleration * BOX2D_LENGTH_OVER_TRUE_LENGTH,
            -STANDARD_GRAVITY * BOX2D_LENGTH_OVER_TRUE_LENGTH,
        )
        world.Step(time_step, 30, 10)

    return _simulate_fall_sides(
        bodies, ground_acceleration_by_time_step, advance_world, stop_after_fall_of_last_listed_body
    )


def fall_sides_in_pymunk(
    free_bodies: Sequence[PlanarBody],
    ground_acceleration_by_time_step: np.ndarray,
    friction: float,
    time_step: float,
    stop_after_fall_of_last_listed_body: bool = False,
) -> list[int]:
    """Return the side to which each stone falls in pymunk under ground accelerations at its time steps."""
    import pymunk as engine

    space = engine.Space()
    space.iterations = 30
    space.collision_slop = 1e-5
    space.collision_bias = 0.1**60
    line = engine.Segment(space.static_body, (-100, 0), (100, 0), 0.0)
    line.friction = math.sqrt(friction)  # pymunk multiplies the frictions of both shapes
    space.add(line)
    bodies = []
    for stone in free_bodies:
        body = engine.Body(stone.mass_per_metre_depth, stone.inertia_about_centre_per_metre_depth)
        body.position = (stone.centre_x, stone.centre_z)
        shape = engine.Poly(body, list(stone.corners_from_centre))
        shape.friction = math.sqrt(friction)
        space.add(body, shape)
        bodies.append(body)

    def advance_world(ground_acceleration: float) -> None:
        """Move the space of pymunk by a time step under a ground acceleration, m/s²."""
        space.gravity = (-ground_acceleration, -STANDARD_GRAVITY)
        space.step(time_step)

    return _simulate_fall_sides(
        bodies, ground_acceleration_by_time_step, advance_world, stop_after_fall_of_last_listed_body
    )


def fall_sides_of_single_block_in_mujoco(
    free_bodies: Sequence[PlanarBody], ground_acceleration_by_time_step: np.ndarray, friction: float, time_step: float
) -> list[int]:
    """Return a list with the fall side of the only body in MuJoCo, a box, 1 m deep, that moves in a vertical plane."""
    import mujoco as engine

    (stone,) = free_bodies
    (b, h) = stone.corners_from_centre[2]
    axes = (("slide", "1 0 0"), ("slide", "0 0 1"), ("hinge", "0 1 0"))
    joints = "".join(f'<joint type="{kind}" axis="{axis}"/>' for kind, axis in axes)
    model = _mujoco_model_of_box((b, 0.5, h), joints, friction, time_step)
    data = engine.MjData(model)
    model.opt.gravity[2] = -STANDARD_GRAVITY
    for acceleration in ground_acceleration_by_time_step.tolist():
        model.opt.gravity[0] = -acceleration
        engine.mj_step(model, data)
        if abs(data.qpos[2]) > MIN_ROTATION_OF_FALLEN_BODY_RAD:
            return [1 if data.qpos[2] > 0 else -1]
    return [0]


def _mujoco_model_of_box(
    half_sizes_xyz_m: tuple[float, float, float],
    joints_xml: str,
    friction: float,
    time_step: float,
    impedance_ratio: int = 1,
) -> Any:
    """Return a model of a box of 1 kg on a plane; `impedance_ratio` is that of friction to normal contact."""
    import mujoco as engine

    size = " ".join(map(str, half_sizes_xyz_m))
    return engine.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{time_step}" integrator="implicitfast" cone="elliptic"
        impratio="{impedance_ratio}"/>
        <default><geom friction="{friction} 0 0" condim="3" solref="{2.0 * time_step} 1"/></default>
        <worldbody><geom type="plane" size="100 100 1"/><body pos="0 0 {half_sizes_xyz_m[2]}">{joints_xml}
        <geom type="box" size="{size}" mass="1"/></body></worldbody></mujoco>"""
    )


class PrismHalfSizesAndFriction(NamedTuple):
    """Free 3-D prism: half sizes along x, y and z, m, and friction coefficient."""

    half_width: float
    half_depth: float
    half_height: float
    friction: float


def effective_gravity_at_step_middles(motion: Motion, prism_orientation_deg: float, time_step: float) -> np.ndarray:
    """Return gravity minus ground acceleration by time step, m/s², shape (steps, 3), x along `prism_orientation_deg`.

    The values are those of `interpolate_acceleration_at_step_middles`: at the middle of each step.
    """
    along = [motion.acceleration_along(prism_orientation_deg), motion.acceleration_along(prism_orientation_deg - 90.0)]
    waves = [*along, np.zeros(motion.sample_count) if motion.up is None else motion.up]
    x, y, z = (
        interpolate_acceleration_at_step_middles(
            wave, motion.sampling_interval, time_step, BLOCK_SIMULATION_TIME_AFTER_RECORD_S
        )
        for wave in waves
    )
    return np.stack([-x, -y, -STANDARD_GRAVITY - z], axis=1)


def fall_direction_in_mujoco(
    prism: PrismHalfSizesAndFriction, effective_gravity_at_step_middles: np.ndarray, time_step: float
) -> tuple[float, float] | None:
    """Return x and y of the unit vector along the axis of a prism that falls in MuJoCo; None if it stands."""
    import mujoco as engine

    model = _mujoco_model_of_box(
        (prism.half_width, prism.half_depth, prism.half_height),
        "<freejoint/>",
        prism.friction,
        time_step,
        impedance_ratio=10,
    )
    data = engine.MjData(model)
    for pull in effective_gravity_at_step_middles:
        model.opt.gravity[:] = pull
        engine.mj_step(model, data)
        if data.xmat[1][8] < MAX_VERTICAL_COMPONENT_OF_FALLEN_AXIS:
            return float(data.xmat[1][2]), float(data.xmat[1][5])
    return None


def fall_direction_in_bullet(
    prism: PrismHalfSizesAndFriction, effective_gravity_at_step_middles: np.ndarray, time_step: float
) -> tuple[float, float] | None:
    """Return x and y of the unit vector along the axis of a prism that falls in Bullet; None if it stands."""
    import pybullet as engine

    client = engine.connect(engine.DIRECT)
    try:
        engine.setPhysicsEngineParameter(
            fixedTimeStep=time_step, numSolverIterations=100, numSubSteps=0, contactSlop=0.0, enableConeFriction=1,
            erp=0.2, contactERP=0.2, frictionERP=0.2, restitutionVelocityThreshold=1e9, physicsClientId=client,
        )  # fmt: skip
        ground = engine.createMultiBody(
            0, engine.createCollisionShape(engine.GEOM_PLANE, physicsClientId=client), physicsClientId=client
        )
        shape = engine.createCollisionShape(
            engine.GEOM_BOX, halfExtents=[prism.half_width, prism.half_depth, prism.half_height], physicsClientId=client
        )
        body = engine.createMultiBody(1.0, shape, basePosition=[0, 0, prism.half_height], physicsClientId=client)
        for one, friction in ((ground, 1.0), (body, prism.friction)):
            engine.changeDynamics(
                one, -1, lateralFriction=friction, rollingFriction=0, spinningFriction=0, restitution=0,
                linearDamping=0,
                angularDamping=0, collisionMargin=0.0, activationState=engine.ACTIVATION_STATE_DISABLE_SLEEPING,
                physicsClientId=client,
            )  # fmt: skip
        for pull in effective_gravity_at_step_middles.tolist():
            engine.setGravity(*pull, physicsClientId=client)
            engine.stepSimulation(physicsClientId=client)
            x, y, z, w = engine.getBasePositionAndOrientation(body, physicsClientId=client)[1]
            if 1.0 - 2.0 * (x * x + y * y) < MAX_VERTICAL_COMPONENT_OF_FALLEN_AXIS:
                return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    finally:
        engine.disconnect(client)
    return None


EngineFunction = TypeVar("EngineFunction")
FallSideOfSingleBlockFunction = Callable[[Sequence[PlanarBody], np.ndarray, float, float], list[int]]
FallSidesOfSceneFunction = Callable[[Sequence[PlanarBody], np.ndarray, float, float, bool], list[int]]
FallDirectionFunction = Callable[[PrismHalfSizesAndFriction, np.ndarray, float], tuple[float, float] | None]
SCENE_ENGINES: Final[dict[str, FallSidesOfSceneFunction]] = {
    "Box2D": fall_sides_in_box2d,
    "pymunk": fall_sides_in_pymunk,
}
BLOCK_ENGINES: Final[dict[str, FallSideOfSingleBlockFunction]] = {
    "Box2D": fall_sides_in_box2d,
    "pymunk": fall_sides_in_pymunk,
    "MuJoCo": fall_sides_of_single_block_in_mujoco,
}
ENGINES_3D: Final[dict[str, FallDirectionFunction]] = {
    "MuJoCo": fall_direction_in_mujoco,
    "Bullet": fall_direction_in_bullet,
}
_MODULE_NAME_BY_ENGINE: Final = {"Box2D": "Box2D", "pymunk": "pymunk", "MuJoCo": "mujoco", "Bullet": "pybullet"}


def installed_engines(engines: Mapping[str, EngineFunction]) -> dict[str, EngineFunction]:
    """Return the engines that are installed; print a note for each missing one."""
    missing = {name for name in engines if find_spec(_MODULE_NAME_BY_ENGINE[name]) is None}
    for name in missing:
        print(f"{name} is not installed: make peers")
    return {name: engine for name, engine in engines.items() if name not in missing}


def fall_side_of_block(
    engine: FallSideOfSingleBlockFunction, record_acceleration: np.ndarray, sampling_interval: float,
    height: float, b_over_h: float, friction: float,
    time_step: float = DEFAULT_TIME_STEP_S,
) -> int:  # fmt: skip
    """Return the side to which a block falls in a physics engine (±1; 0: none)."""
    ground = interpolate_acceleration_at_step_middles(
        record_acceleration, sampling_interval, time_step, BLOCK_SIMULATION_TIME_AFTER_RECORD_S
    )
    return engine([rectangular_planar_body_of_unit_mass(height, b_over_h)], ground, friction, time_step)[0]


def fall_sides_of_scene(
    engine: FallSidesOfSceneFunction, placed_elements: Iterable[PlacedElement],
    record_acceleration: np.ndarray, sampling_interval: float, friction: float,
    time_step: float = DEFAULT_TIME_STEP_S, stop_after_fall_of_last_listed_body: bool = False,
) -> list[int]:  # fmt: skip
    """Return the sides to which the free elements of a scene fall in a physics engine (±1; 0: none)."""
    return engine(
        convert_elements_to_planar_bodies(placed_elements),
        interpolate_acceleration_at_step_middles(
            record_acceleration, sampling_interval, time_step, SCENE_SIMULATION_TIME_AFTER_RECORD_S
        ),
        friction,
        time_step,
        stop_after_fall_of_last_listed_body,
    )


def fall_azimuth_of_prism(
    engine: FallDirectionFunction,
    motion: Motion,
    prism_orientation_deg: float,
    prism: PrismHalfSizesAndFriction,
    time_step: float,
) -> float:
    """Return the azimuth to which the top of a fallen prism points in an engine, degrees; NaN if it stands."""
    axis = engine(prism, effective_gravity_at_step_middles(motion, prism_orientation_deg, time_step), time_step)
    return np.nan if axis is None else float((prism_orientation_deg - np.degrees(np.arctan2(axis[1], axis[0]))) % 360.0)


def _polygon_area(body: PlanarBody) -> float:
    """Return the area of a stone's outline, m²."""
    x, z = np.array(body.corners_from_centre).T
    return abs(float(np.dot(x, np.roll(z, -1)) - np.dot(z, np.roll(x, -1)))) / 2
