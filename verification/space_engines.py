"""The same prism in space in MuJoCo and Bullet: rigid-body engines that solve contacts as constraints.

Both get the shaking as a gravity vector that turns and stretches with time, which is exact for a rigid base.
"""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Final, NamedTuple

import numpy as np

from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

AFTER: Final = 5.0
"""Seconds for which a prism goes on after the record."""

FALLEN: Final = 0.05
"""Vertical component of its axis below which it has fallen: no engine brings it to lie within the same step."""


class Prism(NamedTuple):
    """Half sizes along x, y and z, m, and the friction coefficient."""

    b: float
    d: float
    h: float
    friction: float


def seen_from(motion: Motion, orientation_deg: float, step: float) -> np.ndarray:
    """Gravity in the frame of the base, x to the orientation, y 90° anticlockwise of it, at the middle of each step."""
    along = [motion.along(orientation_deg), motion.along(orientation_deg - 90.0)]
    up = np.zeros(motion.samples) if motion.up is None else motion.up
    times = (np.arange(int((motion.duration + AFTER) / step)) + 0.5) * step
    at = np.arange(motion.samples) * motion.sampling_interval
    x, y, z = (np.interp(times, at, values, right=0.0) for values in (*along, up))
    return np.stack([-x, -y, -STANDARD_GRAVITY - z], axis=1)


def mujoco(prism: Prism, gravity: np.ndarray, step: float) -> tuple[float, float] | None:
    """Horizontal direction of the axis when the prism has fallen in MuJoCo, none where it stands."""
    import mujoco as engine

    model = engine.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{step}" integrator="implicitfast" cone="elliptic" impratio="10"/>
        <default><geom friction="{prism.friction} 0 0" condim="3" solref="{2.0 * step} 1"/></default>
        <worldbody><geom type="plane" size="100 100 1"/><body pos="0 0 {prism.h}"><freejoint/>
        <geom type="box" size="{prism.b} {prism.d} {prism.h}" mass="1"/></body></worldbody></mujoco>"""
    )
    data = engine.MjData(model)
    for pull in gravity:
        model.opt.gravity[:] = pull
        engine.mj_step(model, data)
        if data.xmat[1][8] < FALLEN:
            return float(data.xmat[1][2]), float(data.xmat[1][5])
    return None


def bullet(prism: Prism, gravity: np.ndarray, step: float) -> tuple[float, float] | None:
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
            if 1.0 - 2.0 * (x * x + y * y) < FALLEN:
                return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    finally:
        engine.disconnect(client)
    return None


Engine = Callable[[Prism, np.ndarray, float], tuple[float, float] | None]
ENGINES: Final[dict[str, Engine]] = {"MuJoCo": mujoco, "Bullet": bullet}
"""By name."""


def installed() -> dict[str, Engine]:
    """The engines that are installed; a note for each that is not."""
    modules = {"MuJoCo": "mujoco", "Bullet": "pybullet"}
    missing = [name for name, module in modules.items() if find_spec(module) is None]
    for name in missing:
        print(f"{name} is not installed: make peers")
    return {name: engine for name, engine in ENGINES.items() if name not in missing}


def fall_azimuth(engine: Engine, motion: Motion, orientation_deg: float, prism: Prism, step: float) -> float:
    """Azimuth to which the top points when the prism has fallen, degrees; NaN where it stands."""
    axis = engine(prism, seen_from(motion, orientation_deg, step), step)
    return np.nan if axis is None else float((orientation_deg - np.degrees(np.arctan2(axis[1], axis[0]))) % 360.0)
