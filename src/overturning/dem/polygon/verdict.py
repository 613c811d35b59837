"""How a case ends: what an element has done by the end of a sample, and what that means for its column."""

from typing import Any, Final

import numpy as np
from numba import njit

# isort: off
from overturning.dem.polygon.columns import (
    AFTER, ANGLE, BASE_X, BASE_Z, CALM, COLUMNS, CONTACT, COS, CRITICAL, DEEPEST, ENERGY, INLINE, LAST_UPRIGHT, OPEN,
    OPTIONS, PEAK_ANGLE, PEAK_SLIP, SAFE_FROM, SAMPLE, SECOND, SIDE, SIN, SLIP, SUPPORT_X, SUPPORT_Z, TAKEN,
    UPRIGHT_UNTIL, VW, VX, VZ, WORK, X, Z, element_rows, pair_rows,
)  # fmt: skip
from overturning.dem.polygon.tables import (
    BARRIER, DEEPEST_ALLOWED, E_ANGLE, E_RESIDUAL, E_SIDE, E_SLIP, E_TIME, FALL_ANGLE, IS_FREE, LEAST_BARRIER, LOWEST,
    R_DEPTH, R_ENERGY, R_STATUS, R_STEPS, REST_ENERGY, SUPPORT,
)  # fmt: skip

# isort: on
from overturning.dem.polygon.energy import closing_work, energy, kinetic, moving_energy

SAFE_TILT: Final = 0.1
SAFE_SLIP: Final = 1.0
SAFE_ENERGY: Final = 0.1
"""After a fall: rotation over α, slip over half its height and kinetic energy over its barrier up to which an element that
the rest of the record cannot lift is taken to stand for good."""


@njit(**OPTIONS)
def verdict(state: Any, j: int, layout: Any, elements: int, rules: Any, limits: Any, end: float, gravity: float) -> int:
    """Status of a column at the end of a sample: -1 to go on, else a `Status`."""
    check, moving, standing, fallen, slid, safe = 0.0, 0.0, 0, 0, False, 0
    for e in range(elements):
        body = element_rows(state, e)
        check += body[X + j] + body[Z + j] + body[VX + j] + body[VZ + j] + body[VW + j] + body[COS + j]
        if rules[e, IS_FREE] == 0.0:
            continue
        moving += kinetic(body, j)
        slid = slid or abs(body[SLIP + j]) > 0.1 * abs(body[BASE_Z + j])
        if body[SIDE + j] == 0.0:
            if body[PEAK_ANGLE + j] >= rules[e, FALL_ANGLE]:
                body[SIDE + j] = 1.0 if body[ANGLE + j] > 0.0 else -1.0
            elif body[Z + j] < rules[e, LOWEST]:
                on = element_rows(state, int(rules[e, SUPPORT]))
                x, _ = point_of(body, j, body[BASE_X + j], body[BASE_Z + j])
                ox, _ = point_of(on, j, body[SUPPORT_X + j], body[SUPPORT_Z + j])
                body[SIDE + j] = 1.0 if x > ox else -1.0
        if body[SIDE + j] != 0.0:
            fallen += 1
        else:
            standing += 1
            safe += 1 if is_safe(body, j, state[SAMPLE + j], rules[e, BARRIER]) else 0
    if not np.isfinite(check):
        return 3
    grip = 0
    for p in range(layout.shape[0]):
        q = pair_rows(state, elements, p)
        if q[DEEPEST + j] > limits[DEEPEST_ALLOWED]:
            return 3
        touching = (1 if q[CONTACT + j] != OPEN else 0) + (1 if q[CONTACT + SECOND + j] != OPEN else 0)
        for e in (layout[p, 0], layout[p, 1]):
            if rules[e, IS_FREE] > 0.0 and element_rows(state, e)[SIDE + j] == 0.0:
                grip += touching
    if standing == 0 or (fallen > 0 and safe == standing):
        return 0
    sample = state[SAMPLE + j]
    if sample < end and sample < state[CALM + j]:
        return -1
    # A scene at rest after the last instant at which it could start stays as it is: nothing moves, and every standing
    # element has at least two loaded ends.
    if moving < limits[REST_ENERGY] and grip >= 2 * standing:
        return 0
    if sample >= end:
        total = energy(state, j, layout, elements, gravity)
        spare = total - state[ENERGY + j]
        bound = fallen == 0 and not slid and spare < 0.5 * limits[LEAST_BARRIER]
        # Nothing can fall then; the largest rotations are known once what is left cannot reach them again.
        if bound and not may_rise(state, j, elements, rules, spare):
            return 0
        if sample >= state[AFTER + j]:
            return 0 if moving < 1e-4 * limits[LEAST_BARRIER] else 2
    return -1


@njit(**OPTIONS)
def is_safe(e: Any, j: int, sample: float, barrier: float) -> bool:
    """Whether an element stands upright, nearly in its place and nearly at rest, and the shaking to come is too weak for it."""
    return bool(
        sample >= e[SAFE_FROM + j]
        and abs(e[ANGLE + j]) < SAFE_TILT * e[CRITICAL + j]
        and abs(e[SLIP + j]) < SAFE_SLIP * abs(e[BASE_Z + j])
        and kinetic(e, j) < SAFE_ENERGY * barrier
    )


@njit(**OPTIONS)
def may_rise(state: Any, j: int, elements: int, rules: Any, spare: float) -> bool:
    """Whether an energy could turn an element that has rocked farther than it has been: E/E_max = 1 − (1 − θ/α)²."""
    for e in range(elements):
        body = element_rows(state, e)
        reached = body[PEAK_ANGLE + j] / body[CRITICAL + j]
        if rules[e, IS_FREE] == 0.0 or reached < 1e-3:
            continue
        share = min(max(spare / rules[e, BARRIER], 0.0), 1.0)
        if 1.0 - np.sqrt(1.0 - share) > reached:
            return True
    return False


@njit(**INLINE)
def point_of(e: Any, j: int, px: float, pz: float) -> tuple[float, float]:
    """Where a point of an element is."""
    c, s = e[COS + j], e[SIN + j]
    return e[X + j] + (c * px + s * pz), e[Z + j] + (c * pz - s * px)


@njit(**OPTIONS)
def book_slip(e: Any, on: Any) -> None:
    """Distance of an element's base from its place on the support, along the support."""
    for j in range(COLUMNS):
        x, z = point_of(e, j, e[BASE_X + j], e[BASE_Z + j])
        ox, oz = point_of(on, j, e[SUPPORT_X + j], e[SUPPORT_Z + j])
        slip = on[COS + j] * (x - ox) - on[SIN + j] * (z - oz)
        most, size = e[PEAK_SLIP + j], abs(slip)
        e[SLIP + j] = slip
        e[PEAK_SLIP + j] = size if size > most else most


@njit(**OPTIONS)
def book_upright(e: Any, own: Any, scale: float, interval: float) -> None:
    """The last time at which a standing element's rotation was below the critical angle."""
    for j in range(COLUMNS):
        passed, until = e[LAST_UPRIGHT + j], e[UPRIGHT_UNTIL + j]
        now = (own[SAMPLE + j] + passed * scale) * interval
        e[UPRIGHT_UNTIL + j] = now if (passed >= 0.0) & (e[SIDE + j] == 0.0) else until
        e[LAST_UPRIGHT + j] = -1.0


@njit(**OPTIONS)
def finish(
    state: Any, j: int, layout: Any, elements: int, limits: Any, status: int, steps: int, gravity: float,
    out: Any, each: Any,
) -> None:  # fmt: skip
    """Write the results of a column."""
    deepest, work, taken = 0.0, 0.0, closing_work(state, j, layout, elements)
    for p in range(layout.shape[0]):
        q = pair_rows(state, elements, p)
        deepest = max(deepest, q[DEEPEST + j])
        taken += q[TAKEN + j]
    for e in range(elements):
        body = element_rows(state, e)
        work += body[WORK + j]
        side = body[SIDE + j]
        each[e, E_SIDE] = side
        each[e, E_TIME] = np.nan
        if side != 0.0:
            each[e, E_TIME] = body[UPRIGHT_UNTIL + j]
        each[e, E_ANGLE] = min(body[PEAK_ANGLE + j], 0.5 * np.pi) / body[CRITICAL + j]
        each[e, E_SLIP], each[e, E_RESIDUAL] = body[PEAK_SLIP + j], body[SLIP + j]
    balance = (moving_energy(state, j, elements, gravity) - state[ENERGY + j]) - work + taken
    out[R_STATUS], out[R_DEPTH], out[R_STEPS] = status, deepest, steps
    out[R_ENERGY] = abs(balance) / max(work, limits[LEAST_BARRIER], taken)
