"""Central differences: the elements' accelerations, velocities half a step later and poses one step later."""

from typing import Any

from numba import njit

# isort: off
from overturning.dem.polygon.columns import (
    ANGLE, AX, AZ, AW, BASE, COLUMNS, COS, CRITICAL, FRAME, FX, FZ, GROUND, HELD, INLINE, INVERSE_INERTIA, INVERSE_MASS,
    LAST_UPRIGHT, LEVER, LIMIT, MASS, MOMENT, MOVED, NOW_W, NOW_X, NOW_Z, OPTIONS, PEAK_ANGLE, REACH, SIN, SLOPE, STEP,
    TICK, TURNED, UP, UP_BASE, UP_SLOPE, USED, VW, VX, VZ, WEIGHT, WORK, X, Z,
)  # fmt: skip
# isort: on


@njit(**INLINE)
def turned(c: float, s: float, turn: float) -> tuple[float, float]:
    """Cosine and sine of an angle turned by a small one, rad, by series: libm's bits differ between processors."""
    square = turn * turn
    sine = turn * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
    versine = square * (0.5 - square * (1.0 / 24.0))
    return c - (c * versine + s * sine), s - (s * versine - c * sine)


@njit(**OPTIONS)
def shake(own: Any) -> None:
    """Acceleration of the base now, linear between samples."""
    for j in range(COLUMNS):
        own[GROUND + j] = own[BASE + j] + own[SLOPE + j] * own[TICK + j]
        own[UP + j] = own[UP_BASE + j] + own[UP_SLOPE + j] * own[TICK + j]


@njit(**OPTIONS)
def count_motion(q: Any, a: Any, b: Any) -> int:
    """Add the last step's motion; 1 if a pair could touch, plus 1024 for each column that has to search."""
    flags = 0
    for j in range(COLUMNS):
        used = (q[USED + j] + (a[MOVED + j] + b[MOVED + j])) + q[LEVER + j] * (a[TURNED + j] + b[TURNED + j])
        q[USED + j] = used
        flags += (1 if used >= q[REACH + j] else 0) + (1024 if used >= q[LIMIT + j] else 0)
    return flags


@njit(**OPTIONS)
def advance(e: Any, own: Any, gravity: float) -> None:
    """Accelerations at the whole step, velocities half a step later, pose one step later: central differences."""
    for j in range(COLUMNS):
        dt, tick = own[STEP + j], own[TICK + j]
        frame = e[FRAME + j]
        ground, up = own[GROUND + j] * frame, own[UP + j] * frame
        c, s = e[COS + j], e[SIN + j]
        vx, vz, vw = e[VX + j], e[VZ + j], e[VW + j]
        inverse = e[INVERSE_MASS + j]
        ax = e[FX + j] * inverse - ground
        az = e[FZ + j] * inverse - (gravity * e[WEIGHT + j] + up)
        aw = e[MOMENT + j] * e[INVERSE_INERTIA + j]
        half = 0.5 * dt
        cx, cz = vx + half * ax, vz + half * az
        held = e[HELD + j]
        power = e[MASS + j] * (ground * cx + up * cz) + held * (e[FX + j] * cx + e[FZ + j] * cz)
        e[WORK + j] = e[WORK + j] - dt * power
        vx, vz, vw = vx + dt * ax, vz + dt * az, vw + dt * aw
        turn = dt * vw
        angle = e[ANGLE + j] + turn
        size = abs(angle)
        e[COS + j], e[SIN + j] = turned(c, s, turn)
        e[X + j], e[Z + j], e[ANGLE + j] = e[X + j] + dt * vx, e[Z + j] + dt * vz, angle
        e[VX + j], e[VZ + j], e[VW + j] = vx, vz, vw
        e[AX + j], e[AZ + j], e[AW + j] = ax, az, aw
        # At the next whole step, were the forces to stay.
        e[NOW_X + j], e[NOW_Z + j], e[NOW_W + j] = vx + half * ax, vz + half * az, vw + half * aw
        e[MOVED + j], e[TURNED + j] = dt * (abs(vx) + abs(vz)), abs(turn)
        e[PEAK_ANGLE + j] = size if size > e[PEAK_ANGLE + j] else e[PEAK_ANGLE + j]
        e[LAST_UPRIGHT + j] = tick + 1.0 if size < e[CRITICAL + j] else e[LAST_UPRIGHT + j]
        e[FX + j], e[FZ + j], e[MOMENT + j] = 0.0, 0.0, 0.0
