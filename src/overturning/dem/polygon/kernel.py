"""The general kernel: convex polygons that meet at vertices and faces, many cases side by side.

All jitted code of this kernel is in this file. Quantity ``Q`` of column (case) ``j`` stands at ``[Q + j]`` of a block of
rows, one block per element and one per pair, so that the innermost loops run over columns without branches and LLVM
makes vector code of them. Fast-math and contraction are off and those loops know only ``+ - * /`` and comparisons: a
column's bits depend neither on its neighbours, nor on the thread, nor on the width of the processor's vectors.

Signs: x points to the azimuth, z up, rotation is positive clockwise (towards the azimuth). The point (p, q) of an
element is at ``(x + c p + s q, z − s p + c q)`` with c, s the cosine and sine of its rotation; a force (X, Z) at the
place (p', q') from the centre has the moment ``q' X − p' Z``. The tangent of a face with outward normal n is
``(−n_z, n_x)``; an end's force is ``f_n n + f_t (n_z, −n_x)`` on the pair's first element.

One step: nearest faces where the motion since the last search could have changed them (`search`), forces of every pair
at the whole step (`contact_cundall`, `contact_centred`), accelerations, velocities half a step later, poses (`advance`).
docs/scenes.md derives the rules.
"""

from typing import Any, Final

import numpy as np
from numba import njit
from numba.extending import intrinsic

from overturning.dem.cache import keep_compiled, prefer_full_width

prefer_full_width()

COLUMNS: Final = 16
"""Cases side by side: enough to hide the latency of one case's operations, few enough for the first cache."""

LOOK: Final = 0.1
"""A case is looked at after each so many seconds of its record, or each sample where that is longer."""

SAFE_TILT: Final = 0.1
SAFE_SLIP: Final = 1.0
SAFE_ENERGY: Final = 0.1
"""After a fall: rotation over α, slip over half its height and kinetic energy over its barrier up to which an element that
the rest of the record cannot lift is taken to stand for good."""

# A column's own rows,
(STEP, RATE, TICK, BASE, SLOPE, UP_BASE, UP_SLOPE, GROUND, UP) = (i * COLUMNS for i in range(9))
(AMPLITUDE, SAMPLE, CALM, AFTER, ENERGY) = (i * COLUMNS for i in range(9, 14))
OWN: Final = 14
# those of an element: pose, velocity at the half step, motion of the last step, force at the whole step,
(X, Z, ANGLE, COS, SIN, VX, VZ, VW, MOVED, TURNED, FX, FZ, MOMENT) = (i * COLUMNS for i in range(13))
# velocity at the whole step, with the forces known so far, acceleration,
(NOW_X, NOW_Z, NOW_W, AX, AZ, AW) = (i * COLUMNS for i in range(13, 19))
# constants,
(INVERSE_MASS, INVERSE_INERTIA, MASS, FRAME, WEIGHT, HELD, CRITICAL) = (i * COLUMNS for i in range(19, 26))
# what is booked, and what is looked at once per sample only;
(WORK, PEAK_ANGLE, LAST_UPRIGHT) = (i * COLUMNS for i in range(26, 29))
(UPRIGHT_UNTIL, SIDE, PEAK_SLIP, SLIP) = (i * COLUMNS for i in range(29, 33))
# points of its base and of what it stands on, whose distance is the slip.
(BASE_X, BASE_Z, SUPPORT_X, SUPPORT_Z) = (i * COLUMNS for i in range(33, 37))
# Sample from which on the shaking is too weak to throw it down from rest.
SAFE_FROM = 37 * COLUMNS
BODY: Final = 38
# those of a pair, of its first element's face: outward normal, distance from the centre, ends along the tangent,
(ANX, ANZ, AOFF, ALO, AHI) = (i * COLUMNS for i in range(5))
# the same of the pair's second element,
(BNX, BNZ, BOFF, BLO, BHI) = (i * COLUMNS for i in range(5, 10))
# contact law, reach of a rotation, limits of motion: before faces can change, before a contact can begin; face indices,
(KN, KS, DASHPOT, FRICTION, COMPLIANCE, LEVER, LIMIT, REACH, FACE_A, FACE_B) = (i * COLUMNS for i in range(10, 20))
# depths and places along the face (along its opposite for b's) one step ago of a's first and second vertex and of b's,
(DA1, SA1, DA2, SA2, DB1, SB1, DB2, SB2) = (i * COLUMNS for i in range(20, 28))
# memory of both ends: spring, contact, forces along normal and tangent,
(SPRING_1, CONTACT_1, N_1, T_1, SPRING_2, CONTACT_2, N_2, T_2) = (i * COLUMNS for i in range(28, 36))
MEMORY: Final = 4
# motion since the search, largest penetration, energy taken from the elements, force on a, moments on a and b.
(USED, DEEPEST, TAKEN, SUM_X, SUM_Z, MOMENT_A, MOMENT_B) = (i * COLUMNS for i in range(36, 43))
PAIR: Final = 43

# What an end's CONTACT says: open, closed by a's vertex or by b's, or found anew by a search.
OPEN: Final = 0.0
MINE: Final = 1.0
THEIRS: Final = -1.0
HANDED_ON: Final = 2.0

CENTRED: Final = 1
"""The number of the centred scheme."""

_options: dict[str, Any] = {"fastmath": False, "error_model": "numpy", "boundscheck": False}
_inline: dict[str, Any] = {**_options, "forceinline": True}


@intrinsic
def borrowed(_: Any, array: Any) -> Any:
    """The same array without an owner: its slices count no references, whose locked instructions took a fifth of the time.

    Whoever borrows has to hold on to the array itself.
    """

    def make(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, value=values[0])
        view.meminfo = view.meminfo.type(None)
        view.parent = view.parent.type(None)
        return view._getvalue()

    return array(array), make


@njit(**_inline)
def seen(off: float, along: float, q: float, r: float) -> tuple[float, float]:
    """Place of a face's point along the other face's normal and tangent, from its own centre; q, r turn it there."""
    return off * q + along * r, along * q - off * r


@njit(**_inline)
def stretched(
    spring: float, slip: float, memory: float, whose: float, n: float, t: float, q: float, r: float, drag: float,
    compliance: float,
) -> float:  # fmt: skip
    """Stretch of an end's spring: grown by the slip, or, where the end has changed, such that the force is kept.

    A new contact begins unstretched.
    """
    share = t if memory == HANDED_ON else -((whose * r) * n) - t * q
    kept = -(share + drag) * compliance
    stretch = spring + slip if memory == whose else kept
    return stretch if memory != OPEN else 0.0


@njit(**_inline)
def held_to(value: float, most: float) -> float:
    """A value brought between −most and most."""
    value = most if value > most else value
    least = -most
    return least if value < least else value


@njit(**_inline)
def compliances(
    inverse: float, ia: float, ib: float, a1: float, a2: float, b1: float, b2: float
) -> tuple[float, float, float]:
    """How both ends give way to forces of their own and of each other, per mass: levers a on the first element, b on the second."""
    one = inverse + (ia * (a1 * a1) + ib * (b1 * b1))
    two = inverse + (ia * (a2 * a2) + ib * (b2 * b2))
    return one, two, inverse + (ia * (a1 * a2) + ib * (b1 * b2))


@njit(**_inline)
def contact(q: Any, a: Any, b: Any, own: Any, centred: bool) -> None:
    """Forces of one pair: spring, dashpot and slider at both ends of the faces' common stretch.

    Cundall's scheme has the dashpot's velocity half a step ago, from the difference of depths. The centred one has it at
    the whole step: the velocity of both elements with all forces found so far, this pair's own solved for, first the
    normal ones of both ends, then the tangential.
    """
    for j in range(COLUMNS):
        ca, sa, cb, sb = a[COS + j], a[SIN + j], b[COS + j], b[SIN + j]
        dx, dz = a[X + j] - b[X + j], a[Z + j] - b[Z + j]
        # Outward normals of both faces in the plane, and how one lies in the axes of the other.
        anx, anz = ca * q[ANX + j] + sa * q[ANZ + j], ca * q[ANZ + j] - sa * q[ANX + j]
        bnx, bnz = cb * q[BNX + j] + sb * q[BNZ + j], cb * q[BNZ + j] - sb * q[BNX + j]
        turn_q, turn_r = bnx * anx + bnz * anz, bnz * anx - bnx * anz
        # From b's centre to a's along b's normal and tangent, and along a's.
        bn, bt, an, at = bnx * dx + bnz * dz, bnx * dz - bnz * dx, anx * dx + anz * dz, anx * dz - anz * dx
        a_off, a_lo, a_hi = q[AOFF + j], q[ALO + j], q[AHI + j]
        b_off, b_lo, b_hi = q[BOFF + j], q[BLO + j], q[BHI + j]
        # Ends of a's face along b's normal and tangent from a's centre, and those of b's along the opposite of a's.
        across = -turn_q
        a1n, a1t = seen(a_off, a_lo, turn_q, turn_r)
        a2n, a2t = seen(a_off, a_hi, turn_q, turn_r)
        b1n, b1t = seen(b_off, b_lo, across, turn_r)
        b2n, b2t = seen(b_off, b_hi, across, turn_r)
        # The same from the other's centre, and their depths behind its face.
        ha1, ha2, hb1, hb2 = a1n + bn, a2n + bn, b1n + an, b2n + an
        sa1, sa2, sb1, sb2 = a1t + bt, a2t + bt, b1t + at, b2t + at
        da1, da2, db1, db2 = b_off - ha1, b_off - ha2, a_off + hb1, a_off + hb2
        near = q[USED + j] >= q[REACH + j]
        # The inner one of a's first and b's second vertex carries end 1, of a's second and b's first end 2.
        mine_1, mine_2 = sa1 <= b_hi, sa2 >= b_lo
        a_low, a_high = -a_lo, -a_hi
        in_1 = (mine_1 & (sa1 >= b_lo)) | ((not mine_1) & (sb2 >= a_high) & (sb2 <= a_low))
        in_2 = (mine_2 & (sa2 <= b_hi)) | ((not mine_2) & (sb1 >= a_high) & (sb1 <= a_low))
        back_x, back_z = -anx, -anz
        nx1, nz1 = (bnx if mine_1 else back_x), (bnz if mine_1 else back_z)
        nx2, nz2 = (bnx if mine_2 else back_x), (bnz if mine_2 else back_z)
        depth_1, depth_2 = (da1 if mine_1 else db2), (da2 if mine_2 else db1)
        pa1, pa2, pb1, pb2 = q[DA1 + j], q[DA2 + j], q[DB1 + j], q[DB2 + j]
        before_1, before_2 = (pa1 if mine_1 else pb2), (pa2 if mine_2 else pb1)
        # Slip of a over b, along (n_z, −n_x); a's place along b's tangent grows against it.
        ra1, ra2, rb1, rb2 = q[SA1 + j] - sa1, q[SA2 + j] - sa2, sb1 - q[SB1 + j], sb2 - q[SB2 + j]
        slip_1, slip_2 = (ra1 if mine_1 else rb2), (ra2 if mine_2 else rb1)
        # Levers of a normal and of a tangential force about both centres.
        an1, at1 = (a1t if mine_1 else sb2), (a1n if mine_1 else hb2)
        an2, at2 = (a2t if mine_2 else sb1), (a2n if mine_2 else hb1)
        bn1, bt1 = (sa1 if mine_1 else b2t), (ha1 if mine_1 else b2n)
        bn2, bt2 = (sa2 if mine_2 else b1t), (ha2 if mine_2 else b1n)
        closed_1, closed_2 = in_1 & near & (depth_1 > 0.0), in_2 & near & (depth_2 > 0.0)
        whose_1, whose_2 = (MINE if mine_1 else THEIRS), (MINE if mine_2 else THEIRS)
        kn, ks, mu, compliance, dash = q[KN + j], q[KS + j], q[FRICTION + j], q[COMPLIANCE + j], q[DASHPOT + j]
        old_n1, old_n2, old_t1, old_t2 = q[N_1 + j], q[N_2 + j], q[T_1 + j], q[T_2 + j]
        n1, n2 = kn * depth_1, kn * depth_2
        if centred:
            ux, uz = a[NOW_X + j] - b[NOW_X + j], a[NOW_Z + j] - b[NOW_Z + j]
            wa, wb = a[NOW_W + j], b[NOW_W + j]
            ia, ib = a[INVERSE_INERTIA + j], b[INVERSE_INERTIA + j]
            inverse = a[INVERSE_MASS + j] + b[INVERSE_MASS + j]
            dt = own[STEP + j]
            half = 0.5 * dt
            # Twice the response over half a step: the other pairs' answer is a step old, and would else be overtaken.
            beta = dt * dash
            n1 = n1 - dash * ((nx1 * ux + nz1 * uz) + (wa * an1 - wb * bn1))
            n2 = n2 - dash * ((nx2 * ux + nz2 * uz) + (wa * an2 - wb * bn2))
            drag_1 = dash * ((nz1 * ux - nx1 * uz) + (wa * at1 - wb * bt1))
            drag_2 = dash * ((nz2 * ux - nx2 * uz) + (wa * at2 - wb * bt2))
            on_1, on_2 = closed_1 & (n1 > 0.0), closed_2 & (n2 > 0.0)
            one, two, both = compliances(inverse, ia, ib, an1, an2, bn1, bn2)
            d1, d2, cross = 1.0 + beta * one, 1.0 + beta * two, beta * both
            d1, d2 = (d1 if closed_1 else 1.0), (d2 if closed_2 else 1.0)
            c1, c2 = (cross if closed_1 else 0.0), (cross if closed_2 else 0.0)
            r1, r2 = (n1 if on_1 else 0.0) - old_n1, (n2 if on_2 else 0.0) - old_n2
            one, two, both = compliances(inverse, ia, ib, at1, at2, bt1, bt2)
            e1, e2, cross = 1.0 + beta * one, 1.0 + beta * two, beta * both
            e1, e2 = (e1 if closed_1 else 1.0), (e2 if closed_2 else 1.0)
            f1, f2 = (cross if closed_1 else 0.0), (cross if closed_2 else 0.0)
            # One division for both pairs of equations.
            first, second = d1 * d2 - c1 * c2, e1 * e2 - f1 * f2
            shared = 1.0 / (first * second)
            first, second = shared * second, shared * first
            n1, n2 = old_n1 + (d2 * r1 - c1 * r2) * first, old_n2 + (d1 * r2 - c2 * r1) * first
        else:
            fade = dash * own[RATE + j]
            n1, n2 = n1 + fade * (depth_1 - before_1), n2 + fade * (depth_2 - before_2)
            drag_1, drag_2 = fade * slip_1, fade * slip_2
            on_1, on_2 = closed_1, closed_2
        n1, n2 = (n1 if on_1 & (n1 > 0.0) else 0.0), (n2 if on_2 & (n2 > 0.0) else 0.0)
        if centred:
            # What the new normal forces change in the slip.
            more_1, more_2 = n1 - old_n1, n2 - old_n2
            wa, wb = (beta * ia) * (an1 * more_1 + an2 * more_2), (beta * ib) * (bn1 * more_1 + bn2 * more_2)
            drag_1, drag_2 = drag_1 + (wa * at1 + wb * bt1), drag_2 + (wa * at2 + wb * bt2)
        memory_1, memory_2 = q[CONTACT_1 + j], q[CONTACT_2 + j]
        stretch_1 = stretched(
            q[SPRING_1 + j], slip_1, memory_1, whose_1, old_n1, old_t1, turn_q, turn_r, drag_1, compliance
        )
        stretch_2 = stretched(
            q[SPRING_2 + j], slip_2, memory_2, whose_2, old_n2, old_t2, turn_q, turn_r, drag_2, compliance
        )
        t1, t2 = -(ks * stretch_1) - drag_1, -(ks * stretch_2) - drag_2
        if centred:
            r1, r2 = (t1 if on_1 else 0.0) - old_t1, (t2 if on_2 else 0.0) - old_t2
            t1, t2 = old_t1 + (e2 * r1 - f1 * r2) * second, old_t2 + (e1 * r2 - f2 * r1) * second
        cap_1, cap_2 = mu * n1, mu * n2
        t1, t2 = held_to(t1, cap_1), held_to(t2, cap_2)
        spring_1, spring_2 = held_to(stretch_1, cap_1 * compliance), held_to(stretch_2, cap_2 * compliance)
        taken_1 = (old_n1 + n1) * (depth_1 - before_1) - (old_t1 + t1) * slip_1
        taken_2 = (old_n2 + n2) * (depth_2 - before_2) - (old_t2 + t2) * slip_2
        deepest = q[DEEPEST + j]
        deepest = depth_1 if closed_1 & (depth_1 > deepest) else deepest
        deepest = depth_2 if closed_2 & (depth_2 > deepest) else deepest
        sum_x, sum_z = (n1 * nx1 + t1 * nz1) + (n2 * nx2 + t2 * nz2), (n1 * nz1 - t1 * nx1) + (n2 * nz2 - t2 * nx2)
        moment_a = (an1 * n1 + at1 * t1) + (an2 * n2 + at2 * t2)
        moment_b = (bn1 * n1 + bt1 * t1) + (bn2 * n2 + bt2 * t2)
        a[FX + j], b[FX + j] = a[FX + j] + sum_x, b[FX + j] - sum_x
        a[FZ + j], b[FZ + j] = a[FZ + j] + sum_z, b[FZ + j] - sum_z
        a[MOMENT + j], b[MOMENT + j] = a[MOMENT + j] + moment_a, b[MOMENT + j] - moment_b
        if centred:
            # The elements' velocities with this pair's new forces in place of its old.
            more_x, more_z = half * (sum_x - q[SUM_X + j]), half * (sum_z - q[SUM_Z + j])
            ma, mb = a[INVERSE_MASS + j], b[INVERSE_MASS + j]
            a[NOW_X + j], b[NOW_X + j] = a[NOW_X + j] + ma * more_x, b[NOW_X + j] - mb * more_x
            a[NOW_Z + j], b[NOW_Z + j] = a[NOW_Z + j] + ma * more_z, b[NOW_Z + j] - mb * more_z
            a[NOW_W + j] = a[NOW_W + j] + (half * ia) * (moment_a - q[MOMENT_A + j])
            b[NOW_W + j] = b[NOW_W + j] - (half * ib) * (moment_b - q[MOMENT_B + j])
        q[SPRING_1 + j], q[SPRING_2 + j] = spring_1, spring_2
        q[CONTACT_1 + j], q[CONTACT_2 + j] = (whose_1 if closed_1 else OPEN), (whose_2 if closed_2 else OPEN)
        q[N_1 + j], q[N_2 + j], q[T_1 + j], q[T_2 + j] = n1, n2, t1, t2
        q[DA1 + j], q[SA1 + j], q[DA2 + j], q[SA2 + j] = da1, sa1, da2, sa2
        q[DB1 + j], q[SB1 + j], q[DB2 + j], q[SB2 + j] = db1, sb1, db2, sb2
        q[DEEPEST + j] = deepest
        q[TAKEN + j] = q[TAKEN + j] + 0.5 * (taken_1 + taken_2)
        q[SUM_X + j], q[SUM_Z + j], q[MOMENT_A + j], q[MOMENT_B + j] = sum_x, sum_z, moment_a, moment_b


@njit(**_options)
def contact_cundall(q: Any, a: Any, b: Any, own: Any) -> None:
    """Forces of one pair by Cundall's scheme."""
    contact(q, a, b, own, False)


@njit(**_options)
def contact_centred(q: Any, a: Any, b: Any, own: Any) -> None:
    """Forces of one pair with dashpots at the whole step."""
    contact(q, a, b, own, True)


@njit(**_options)
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
        square = turn * turn
        sine = turn * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
        versine = square * (0.5 - square * (1.0 / 24.0))
        angle = e[ANGLE + j] + turn
        size = abs(angle)
        e[COS + j], e[SIN + j] = c - (c * versine + s * sine), s - (s * versine - c * sine)
        e[X + j], e[Z + j], e[ANGLE + j] = e[X + j] + dt * vx, e[Z + j] + dt * vz, angle
        e[VX + j], e[VZ + j], e[VW + j] = vx, vz, vw
        e[AX + j], e[AZ + j], e[AW + j] = ax, az, aw
        # At the next whole step, were the forces to stay.
        e[NOW_X + j], e[NOW_Z + j], e[NOW_W + j] = vx + half * ax, vz + half * az, vw + half * aw
        e[MOVED + j], e[TURNED + j] = dt * (abs(vx) + abs(vz)), abs(turn)
        e[PEAK_ANGLE + j] = size if size > e[PEAK_ANGLE + j] else e[PEAK_ANGLE + j]
        e[LAST_UPRIGHT + j] = tick + 1.0 if size < e[CRITICAL + j] else e[LAST_UPRIGHT + j]
        e[FX + j], e[FZ + j], e[MOMENT + j] = 0.0, 0.0, 0.0


@njit(**_options)
def shake(own: Any) -> None:
    """Acceleration of the base now, linear between samples."""
    for j in range(COLUMNS):
        own[GROUND + j] = own[BASE + j] + own[SLOPE + j] * own[TICK + j]
        own[UP + j] = own[UP_BASE + j] + own[UP_SLOPE + j] * own[TICK + j]


@njit(**_options)
def count_motion(q: Any, a: Any, b: Any) -> int:
    """Add the last step's motion; 1 if a pair could touch, plus 1024 for each column that has to search."""
    flags = 0
    for j in range(COLUMNS):
        used = (q[USED + j] + (a[MOVED + j] + b[MOVED + j])) + q[LEVER + j] * (a[TURNED + j] + b[TURNED + j])
        q[USED + j] = used
        flags += (1 if used >= q[REACH + j] else 0) + (1024 if used >= q[LIMIT + j] else 0)
    return flags


@njit(**_options)
def separation(a: Any, b: Any, j: int, nb: int, shape_a: Any, shape_b: Any, face: int) -> float:
    """Signed distance of b's nearest vertex from the line of a face of a, positive outside."""
    ca, sa, cb, sb = a[COS + j], a[SIN + j], b[COS + j], b[SIN + j]
    nx = ca * shape_a[face, 4] + sa * shape_a[face, 5]
    nz = ca * shape_a[face, 5] - sa * shape_a[face, 4]
    dx, dz = b[X + j] - a[X + j], b[Z + j] - a[Z + j]
    least = np.inf
    for k in range(nb):
        px, pz = shape_b[k, 0], shape_b[k, 1]
        x, z = (cb * px + sb * pz) + dx, (cb * pz - sb * px) + dz
        least = min(least, nx * x + nz * z)
    return least - shape_a[face, 6]


@njit(**_options)
def most_opposed(a: Any, b: Any, j: int, nb: int, shape_a: Any, shape_b: Any, face: int) -> tuple[int, float, float]:
    """The face of b most nearly opposite to one of a, the product of their normals, and by how much the next is worse."""
    c = a[COS + j] * b[COS + j] + a[SIN + j] * b[SIN + j]
    s = a[SIN + j] * b[COS + j] - a[COS + j] * b[SIN + j]
    nx, nz = c * shape_a[face, 4] + s * shape_a[face, 5], c * shape_a[face, 5] - s * shape_a[face, 4]
    best, least, second = 0, np.inf, np.inf
    for k in range(nb):
        product = nx * shape_b[k, 4] + nz * shape_b[k, 5]
        if product < least:
            best, least, second = k, product, least
        elif product < second:
            second = product
    return best, least, second - least


@njit(**_options)
def search(q: Any, a: Any, b: Any, own: Any, j: int, na: int, nb: int, shape_a: Any, shape_b: Any, fresh: bool) -> None:
    """Nearest faces of a pair in one column, how much motion cannot change them, and what the springs remember.

    Of all faces the one with the largest separation from the other element is nearest; with it goes the other
    element's face most nearly opposite. Equal separations: the pair with the more nearly opposite normals, then the
    lower index, those of a first.
    """
    most, face_a, face_b, opposed, play = -np.inf, 0, 0, np.inf, 0.0
    for turn in range(2):
        for k in range(na if turn == 0 else nb):
            if turn == 0:
                gap = separation(a, b, j, nb, shape_a, shape_b, k)
                other, product, clear = most_opposed(a, b, j, nb, shape_a, shape_b, k)
                first, second = k, other
            else:
                gap = separation(b, a, j, na, shape_b, shape_a, k)
                other, product, clear = most_opposed(b, a, j, na, shape_b, shape_a, k)
                first, second = other, k
            if gap > most or (gap == most and product < opposed):
                most, face_a, face_b, opposed, play = gap, first, second, product, clear
    # A gap changes by no more than the motion, a product of normals by no more than the rotation.
    dx, dz = a[X + j] - b[X + j], a[Z + j] - b[Z + j]
    radius = 0.0
    for k in range(na):
        radius = max(radius, shape_a[k, 0] ** 2 + shape_a[k, 1] ** 2)
    for k in range(nb):
        radius = max(radius, shape_b[k, 0] ** 2 + shape_b[k, 1] ** 2)
    lever = np.sqrt(dx * dx + dz * dz) + np.sqrt(radius)
    limit = 0.4 * lever * play
    for turn in range(2):
        for k in range(na if turn == 0 else nb):
            if turn == 0:
                gap = separation(a, b, j, nb, shape_a, shape_b, k)
                other, _, clear = most_opposed(a, b, j, nb, shape_a, shape_b, k)
                agrees = k == face_a and other == face_b
            else:
                gap = separation(b, a, j, na, shape_b, shape_a, k)
                other, _, clear = most_opposed(b, a, j, na, shape_b, shape_a, k)
                agrees = k == face_b and other == face_a
            room = 0.4 * (most - gap)
            limit = min(limit, max(room, 0.4 * lever * clear) if agrees else room)
    old_a, old_b = int(q[FACE_A + j]), int(q[FACE_B + j])
    was_far = q[REACH + j] > 0.0
    # Two more steps like the last one are kept clear, so that the first step in reach is still one without contact.
    last = (a[MOVED + j] + b[MOVED + j]) + lever * (a[TURNED + j] + b[TURNED + j])
    reach = 0.9 * most - 2.0 * last
    q[LEVER + j], q[USED + j], q[REACH + j] = lever, 0.0, reach if reach > 0.0 else -1.0
    q[LIMIT + j] = max(limit, q[REACH + j])
    if reach > 0.0:
        let_go(q, j)
    changed = old_a != face_a or old_b != face_b or fresh
    if changed:
        q[FACE_A + j], q[FACE_B + j] = face_a, face_b
        put_face(q, ANX + j, shape_a, face_a)
        put_face(q, BNX + j, shape_b, face_b)
    if changed or was_far or reach > 0.0:
        depths_before(q, a, b, j, own[STEP + j])
    if changed and not fresh:
        hand_on(q, a, b, j, old_a, old_b, face_a, face_b, na, nb, shape_a, shape_b)


@njit(**_options)
def put_face(q: Any, at: int, shape: Any, face: int) -> None:
    """Normal, distance and ends along the tangent of a face."""
    nx, nz = shape[face, 4], shape[face, 5]
    q[at], q[at + COLUMNS], q[at + 2 * COLUMNS] = nx, nz, shape[face, 6]
    q[at + 3 * COLUMNS] = nx * shape[face, 1] - nz * shape[face, 0]
    q[at + 4 * COLUMNS] = nx * shape[face, 3] - nz * shape[face, 2]


@njit(**_options)
def let_go(q: Any, j: int) -> None:
    """Forget both ends of a pair that is out of reach, and its forces."""
    for k in range(2 * MEMORY):
        q[SPRING_1 + k * COLUMNS + j] = 0.0
    q[SUM_X + j], q[SUM_Z + j], q[MOMENT_A + j], q[MOMENT_B + j] = 0.0, 0.0, 0.0, 0.0


@njit(**_options)
def depths_before(q: Any, a: Any, b: Any, j: int, dt: float) -> None:
    """Depths and places of the faces' vertices a time dt ago, 0 for now."""
    pose = np.empty((2, 4))
    for k in range(2):
        e = a if k == 0 else b
        turn = -dt * e[VW + j]
        square = turn * turn
        sine = turn * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
        versine = square * (0.5 - square * (1.0 / 24.0))
        c, s = e[COS + j], e[SIN + j]
        pose[k, 0], pose[k, 1] = c - (c * versine + s * sine), s - (s * versine - c * sine)
        pose[k, 2], pose[k, 3] = e[X + j] - dt * e[VX + j], e[Z + j] - dt * e[VZ + j]
    dx, dz = pose[0, 2] - pose[1, 2], pose[0, 3] - pose[1, 3]
    ca, sa, cb, sb = pose[0, 0], pose[0, 1], pose[1, 0], pose[1, 1]
    anx, anz = ca * q[ANX + j] + sa * q[ANZ + j], ca * q[ANZ + j] - sa * q[ANX + j]
    bnx, bnz = cb * q[BNX + j] + sb * q[BNZ + j], cb * q[BNZ + j] - sb * q[BNX + j]
    turn_q, turn_r = bnx * anx + bnz * anz, bnz * anx - bnx * anz
    for k in range(4):
        if k < 2:
            n, t = seen(q[AOFF + j], q[(ALO if k == 0 else AHI) + j], turn_q, turn_r)
            depth, place = q[BOFF + j] - (n + (bnx * dx + bnz * dz)), t + (bnx * dz - bnz * dx)
        else:
            n, t = seen(q[BOFF + j], q[(BLO if k == 2 else BHI) + j], -turn_q, turn_r)
            depth, place = q[AOFF + j] + (n + (anx * dx + anz * dz)), t + (anx * dz - anz * dx)
        q[DA1 + 2 * k * COLUMNS + j], q[SA1 + 2 * k * COLUMNS + j] = depth, place


@njit(**_options)
def hand_on(
    q: Any, a: Any, b: Any, j: int, old_a: int, old_b: int, face_a: int, face_b: int, na: int, nb: int, shape_a: Any,
    shape_b: Any,
) -> None:  # fmt: skip
    """Give each loaded end's memory to the new end with the same vertex, else to the one nearest in place.

    Its forces are turned into the directions of the new end, so that the next step stretches the spring to the share of
    the old force along the new face.
    """
    memory = np.zeros((2, MEMORY))
    for end in range(2):
        base = SPRING_1 if end == 0 else SPRING_2
        for k in range(MEMORY):
            memory[end, k] = q[base + k * COLUMNS + j]
            q[base + k * COLUMNS + j] = 0.0
    for end in range(2):
        if memory[end, 1] == OPEN:
            continue
        mine = memory[end, 1] != THEIRS
        if mine:
            vertex = old_a if end == 0 else (old_a + 1) % na
            one, two = face_a, (face_a + 1) % na
        else:
            vertex = (old_b + 1) % nb if end == 0 else old_b
            one, two = (face_b + 1) % nb, face_b
        target = 0
        if vertex == two:
            target = 1
        elif vertex != one:
            shape, ring = (shape_a, na) if mine else (shape_b, nb)
            x, z = shape[vertex % ring, 0], shape[vertex % ring, 1]
            to_one = (shape[one, 0] - x) ** 2 + (shape[one, 1] - z) ** 2
            to_two = (shape[two, 0] - x) ** 2 + (shape[two, 1] - z) ** 2
            target = 0 if to_one <= to_two else 1
        old_x, old_z = end_normal(a, b, j, shape_a, shape_b, old_a, old_b, mine)
        n, t = memory[end, 2], memory[end, 3]
        x, z = n * old_x + t * old_z, n * old_z - t * old_x
        inner = q[SA1 + j] <= q[BHI + j] if target == 0 else q[SA2 + j] >= q[BLO + j]
        new_x, new_z = end_normal(a, b, j, shape_a, shape_b, face_a, face_b, inner)
        n, t = x * new_x + z * new_z, x * new_z - z * new_x
        base = SPRING_1 if target == 0 else SPRING_2
        if q[base + (CONTACT_1 - SPRING_1) + j] != OPEN and q[base + (N_1 - SPRING_1) + j] >= n:
            continue
        q[base + j], q[base + (CONTACT_1 - SPRING_1) + j] = memory[end, 0], HANDED_ON
        q[base + (N_1 - SPRING_1) + j], q[base + (T_1 - SPRING_1) + j] = n, t


@njit(**_options)
def end_normal(
    a: Any, b: Any, j: int, shape_a: Any, shape_b: Any, face_a: int, face_b: int, mine: bool
) -> tuple[float, float]:
    """Direction of the normal force on a at an end: b's normal where the vertex is a's, else a's turned round."""
    if mine:
        c, s, nx, nz = b[COS + j], b[SIN + j], shape_b[face_b, 4], shape_b[face_b, 5]
        return c * nx + s * nz, c * nz - s * nx
    c, s, nx, nz = a[COS + j], a[SIN + j], shape_a[face_a, 4], shape_a[face_a, 5]
    return -(c * nx + s * nz), -(c * nz - s * nx)


@njit(**_options)
def step(state: Any, scheme: int, layout: Any, sizes: Any, shapes: Any, variant: Any, gravity: float) -> None:
    """One step of all columns."""
    own = state[: OWN * COLUMNS]
    shake(own)
    elements = sizes.size
    for p in range(layout.shape[0]):
        first, second = layout[p, 0], layout[p, 1]
        at = (OWN + elements * BODY + p * PAIR) * COLUMNS
        q = state[at : at + PAIR * COLUMNS]
        a = state[(OWN + first * BODY) * COLUMNS : (OWN + (first + 1) * BODY) * COLUMNS]
        b = state[(OWN + second * BODY) * COLUMNS : (OWN + (second + 1) * BODY) * COLUMNS]
        flags = count_motion(q, a, b)
        if flags >= 1024:
            for j in range(COLUMNS):
                if q[USED + j] >= q[LIMIT + j]:
                    search(
                        q, a, b, own, j, sizes[first], sizes[second], shapes[variant[j], first],
                        shapes[variant[j], second], False,
                    )  # fmt: skip
            flags = 0
            for j in range(COLUMNS):
                flags += 1 if q[USED + j] >= q[REACH + j] else 0
        if flags > 0:
            if scheme == CENTRED:
                contact_centred(q, a, b, own)
            else:
                contact_cundall(q, a, b, own)
    for e in range(elements):
        if layout_moves(state, e):
            advance(state[(OWN + e * BODY) * COLUMNS : (OWN + (e + 1) * BODY) * COLUMNS], own, gravity)
    for j in range(COLUMNS):
        own[TICK + j] = own[TICK + j] + 1.0


@njit(**_options)
def layout_moves(state: Any, element: int) -> bool:
    """Whether an element is free or held; a driven one rests in the frame of the base."""
    return bool(state[(OWN + element * BODY) * COLUMNS + FRAME] != 0.0)


# Rows of a free element's rules: whether it is free, angle and height at which it has fallen, what it stands on, and the
# energy that its overturning takes.
(IS_FREE, FALL_ANGLE, LOWEST, SUPPORT, BARRIER) = range(5)
RULES: Final = 5
# Rows of a scene's limits: deepest penetration, kinetic energy at rest, least barrier.
DEEPEST_ALLOWED, REST_ENERGY, LEAST_BARRIER = range(3)
LIMITS: Final = 3
# Columns of the case table.
(P_AMPLITUDE, P_FRICTION, P_DAMPING, P_FIRST, P_CALM, P_AFTER) = range(6)
PARAMETERS: Final = 6  # and of each element SAFE_FROM
# Results of a case, and of each element.
(R_STATUS, R_DEPTH, R_ENERGY, R_STEPS) = range(4)
RESULTS: Final = 4
(E_SIDE, E_TIME, E_ANGLE, E_SLIP, E_RESIDUAL) = range(5)
ELEMENT_RESULTS: Final = 5
# A trajectory's columns: time and ground acceleration, then six for each element.
(T_TIME, T_GROUND) = range(2)
(T_X, T_Z, T_ANGLE, T_VX, T_VZ, T_VW) = range(6)


@njit(**_options)
def start(
    state: Any, j: int, case: Any, initial: Any, layout: Any, sizes: Any, shapes: Any, interval: float, steps: int,
    gravity: float,
) -> None:  # fmt: skip
    """Put a case into column j: the scene's column at rest, its own friction, damping and amplitude."""
    for row in range(initial.size):
        state[row * COLUMNS + j] = initial[row]
    own = state[: OWN * COLUMNS]
    own[STEP + j], own[RATE + j] = interval / steps, steps / interval
    own[AMPLITUDE + j], own[SAMPLE + j] = case[P_AMPLITUDE], case[P_FIRST]
    own[CALM + j], own[AFTER + j] = case[P_CALM], case[P_AFTER]
    for e in range(sizes.size):
        state[(OWN + e * BODY) * COLUMNS + UPRIGHT_UNTIL + j] = case[P_FIRST] * interval
        state[(OWN + e * BODY) * COLUMNS + SAFE_FROM + j] = case[PARAMETERS + e]
    for p in range(layout.shape[0]):
        first, second = layout[p, 0], layout[p, 1]
        at = (OWN + sizes.size * BODY + p * PAIR) * COLUMNS
        q = state[at : at + PAIR * COLUMNS]
        a = state[(OWN + first * BODY) * COLUMNS : (OWN + (first + 1) * BODY) * COLUMNS]
        b = state[(OWN + second * BODY) * COLUMNS : (OWN + (second + 1) * BODY) * COLUMNS]
        q[FRICTION + j] = q[FRICTION + j] if q[FRICTION + j] >= 0.0 else case[P_FRICTION]
        q[DASHPOT + j] = q[DASHPOT + j] * case[P_DAMPING]
        settled = q[LIMIT + j] == np.inf
        search(q, a, b, own, j, sizes[first], sizes[second], shapes[first], shapes[second], True)
        if settled:
            q[LIMIT + j], q[REACH + j] = np.inf, -1.0
        load_at_rest(q, a, b, j)
        q[TAKEN + j] = springs(state, at + j)
    own[ENERGY + j] = energy(state, j, layout, sizes.size, gravity)


@njit(**_options)
def load_at_rest(q: Any, a: Any, b: Any, j: int) -> None:
    """Give the ends of a scene at rest, whose springs are loaded, the forces that go with them."""
    dx, dz = a[X + j] - b[X + j], a[Z + j] - b[Z + j]
    total_x, total_z, moment_a, moment_b = 0.0, 0.0, 0.0, 0.0
    for end in range(2):
        base = SPRING_1 if end == 0 else SPRING_2
        if q[base + (CONTACT_1 - SPRING_1) + j] == OPEN:
            continue
        mine = q[base + (CONTACT_1 - SPRING_1) + j] == MINE
        e, face, along = (a, ANX, ALO if end == 0 else AHI) if mine else (b, BNX, BHI if end == 0 else BLO)
        other, normal = (b, BNX) if mine else (a, ANX)
        depth = q[((DA1 if end == 0 else DA2) if mine else (DB2 if end == 0 else DB1)) + j]
        n, t = max(q[KN + j] * depth, 0.0), -q[KS + j] * q[base + j]
        q[base + (N_1 - SPRING_1) + j], q[base + (T_1 - SPRING_1) + j] = n, t
        fx, fz = q[face + j], q[face + COLUMNS + j]
        off, place = q[face + 2 * COLUMNS + j], q[along + j]
        px, pz = off * fx - place * fz, off * fz + place * fx
        rx, rz = e[COS + j] * px + e[SIN + j] * pz, e[COS + j] * pz - e[SIN + j] * px
        fx, fz = q[normal + j], q[normal + COLUMNS + j]
        nx, nz = other[COS + j] * fx + other[SIN + j] * fz, other[COS + j] * fz - other[SIN + j] * fx
        if not mine:
            nx, nz, rx, rz = -nx, -nz, rx - dx, rz - dz
        x, z = n * nx + t * nz, n * nz - t * nx
        total_x, total_z = total_x + x, total_z + z
        moment_a, moment_b = moment_a + (rz * x - rx * z), moment_b + ((rz + dz) * x - (rx + dx) * z)
    q[SUM_X + j], q[SUM_Z + j], q[MOMENT_A + j], q[MOMENT_B + j] = total_x, total_z, moment_a, moment_b


@njit(**_options)
def energy(state: Any, j: int, layout: Any, elements: int, gravity: float) -> float:
    """Kinetic and gravitational energy of a column at the last half step and spring energy at the whole step before, J."""
    total = 0.0
    for p in range(layout.shape[0]):
        total += springs(state, (OWN + elements * BODY + p * PAIR) * COLUMNS + j)
    return total + moving_energy(state, j, elements, gravity)


@njit(**_options)
def moving_energy(state: Any, j: int, elements: int, gravity: float) -> float:
    """Kinetic and gravitational energy of a column at the last half step, J."""
    total = 0.0
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS + j
        if state[at + INVERSE_MASS] == 0.0:
            continue
        height = state[at + Z] - 0.5 * state[STEP + j] * state[at + VZ]
        total += kinetic(state, at) + state[at + MASS] * gravity * height
    return total


@njit(**_options)
def springs(state: Any, at: int) -> float:
    """Energy of a pair's springs, J."""
    total = 0.0
    for end in range(2):
        base = at + (SPRING_1 if end == 0 else SPRING_2)
        memory = state[base + (CONTACT_1 - SPRING_1)]
        if memory != OPEN:
            mine = memory != THEIRS
            depth = state[at + ((DA1 if end == 0 else DA2) if mine else (DB2 if end == 0 else DB1))]
            total += 0.5 * (state[at + KN] * depth * depth + state[at + KS] * state[base] ** 2)
    return total


@njit(**_options)
def kinetic(state: Any, at: int) -> float:
    """Kinetic energy of an element, J, from the velocities half a step back."""
    vx, vz, vw = state[at + VX], state[at + VZ], state[at + VW]
    return float(0.5 * (state[at + MASS] * (vx * vx + vz * vz) + vw * vw / state[at + INVERSE_INERTIA]))


@njit(**_options)
def next_sample(state: Any, elements: int, row: Any, ground: Any, upward: Any, steps: int) -> None:
    """Bring the turning pairs back to length 1 and load the ground motion of each column's sample."""
    scale = 1.0 / steps
    last = ground.shape[1] - 3
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS
        for j in range(COLUMNS):
            c, s = state[at + COS + j], state[at + SIN + j]
            unit = 1.5 - 0.5 * (c * c + s * s)
            state[at + COS + j], state[at + SIN + j] = c * unit, s * unit
    for j in range(COLUMNS):
        i = min(int(state[SAMPLE + j]), last)
        factor = state[AMPLITUDE + j]
        a0, a1 = ground[row[j], i] * factor, ground[row[j], i + 1] * factor
        state[BASE + j], state[SLOPE + j] = a0, (a1 - a0) * scale
        if upward.size > 0:
            a0, a1 = upward[i] * factor, upward[i + 1] * factor
            state[UP_BASE + j], state[UP_SLOPE + j] = a0, (a1 - a0) * scale
        state[TICK + j] = 0.0


@njit(**_options)
def end_sample(state: Any, elements: int, rules: Any, steps: int, interval: float) -> None:
    """Each element's slip, and the last time at which a standing one's rotation was below the critical angle."""
    own = state[: OWN * COLUMNS]
    for k in range(elements):
        if rules[k, IS_FREE] == 0.0:
            continue
        on = int(rules[k, SUPPORT])
        e = state[(OWN + k * BODY) * COLUMNS : (OWN + (k + 1) * BODY) * COLUMNS]
        book_slip(e, state[(OWN + on * BODY) * COLUMNS : (OWN + (on + 1) * BODY) * COLUMNS])
        book_upright(e, own, 1.0 / steps, interval)
    for j in range(COLUMNS):
        own[SAMPLE + j] = own[SAMPLE + j] + 1.0


@njit(**_options)
def book_slip(e: Any, on: Any) -> None:
    """Distance of an element's base from its place on the support, along the support."""
    for j in range(COLUMNS):
        c, s, cs, ss = e[COS + j], e[SIN + j], on[COS + j], on[SIN + j]
        x = e[X + j] + (c * e[BASE_X + j] + s * e[BASE_Z + j])
        z = e[Z + j] + (c * e[BASE_Z + j] - s * e[BASE_X + j])
        ox = on[X + j] + (cs * e[SUPPORT_X + j] + ss * e[SUPPORT_Z + j])
        oz = on[Z + j] + (cs * e[SUPPORT_Z + j] - ss * e[SUPPORT_X + j])
        slip = cs * (x - ox) - ss * (z - oz)
        most, size = e[PEAK_SLIP + j], abs(slip)
        e[SLIP + j] = slip
        e[PEAK_SLIP + j] = size if size > most else most


@njit(**_options)
def book_upright(e: Any, own: Any, scale: float, interval: float) -> None:
    """The last time at which a standing element's rotation was below the critical angle."""
    for j in range(COLUMNS):
        passed, until = e[LAST_UPRIGHT + j], e[UPRIGHT_UNTIL + j]
        now = (own[SAMPLE + j] + passed * scale) * interval
        e[UPRIGHT_UNTIL + j] = now if (passed >= 0.0) & (e[SIDE + j] == 0.0) else until
        e[LAST_UPRIGHT + j] = -1.0


@njit(**_options)
def verdict(state: Any, j: int, layout: Any, elements: int, rules: Any, limits: Any, end: float, gravity: float) -> int:
    """Status of a column at the end of a sample: -1 to go on, else a `Status`."""
    check, moving, standing, fallen, slid, safe = 0.0, 0.0, 0, 0, False, 0
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS + j
        check += state[at + X] + state[at + Z] + state[at + VX] + state[at + VZ] + state[at + VW] + state[at + COS]
        if rules[e, IS_FREE] == 0.0:
            continue
        moving += kinetic(state, at)
        slid = slid or abs(state[at + SLIP]) > 0.1 * abs(state[at + BASE_Z])
        if state[at + SIDE] == 0.0:
            if state[at + PEAK_ANGLE] >= rules[e, FALL_ANGLE]:
                state[at + SIDE] = 1.0 if state[at + ANGLE] > 0.0 else -1.0
            elif state[at + Z] < rules[e, LOWEST]:
                on = (OWN + int(rules[e, SUPPORT]) * BODY) * COLUMNS + j
                x, _ = base_point(state, at, state[at + BASE_X], state[at + BASE_Z])
                ox, _ = base_point(state, on, state[at + SUPPORT_X], state[at + SUPPORT_Z])
                state[at + SIDE] = 1.0 if x > ox else -1.0
        fallen += 1 if state[at + SIDE] != 0.0 else 0
        if state[at + SIDE] == 0.0:
            standing += 1
            safe += 1 if is_safe(state, j, at, rules[e, BARRIER]) else 0
    if not np.isfinite(check):
        return 3
    grip, touching = 0, 0
    for p in range(layout.shape[0]):
        at = (OWN + elements * BODY + p * PAIR) * COLUMNS + j
        if state[at + DEEPEST] > limits[DEEPEST_ALLOWED]:
            return 3
        touching = (1 if state[at + CONTACT_1] != OPEN else 0) + (1 if state[at + CONTACT_2] != OPEN else 0)
        first, second = layout[p, 0], layout[p, 1]
        for e in (first, second):
            if rules[e, IS_FREE] > 0.0 and state[(OWN + e * BODY) * COLUMNS + j + SIDE] == 0.0:
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


@njit(**_options)
def is_safe(state: Any, j: int, at: int, barrier: float) -> bool:
    """Whether an element stands upright, nearly in its place and nearly at rest, and the shaking to come is too weak for it."""
    return bool(
        state[SAMPLE + j] >= state[at + SAFE_FROM]
        and abs(state[at + ANGLE]) < SAFE_TILT * state[at + CRITICAL]
        and abs(state[at + SLIP]) < SAFE_SLIP * abs(state[at + BASE_Z])
        and kinetic(state, at) < SAFE_ENERGY * barrier
    )


@njit(**_options)
def may_rise(state: Any, j: int, elements: int, rules: Any, spare: float) -> bool:
    """Whether an energy could turn an element that has rocked farther than it has been: E/E_max = 1 − (1 − θ/α)²."""
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS + j
        reached = state[at + PEAK_ANGLE] / state[at + CRITICAL]
        if rules[e, IS_FREE] == 0.0 or reached < 1e-3:
            continue
        share = min(max(spare / rules[e, BARRIER], 0.0), 1.0)
        if 1.0 - np.sqrt(1.0 - share) > reached:
            return True
    return False


@njit(**_options)
def base_point(state: Any, at: int, px: float, pz: float) -> tuple[float, float]:
    """Where a point of an element is."""
    c, s = state[at + COS], state[at + SIN]
    return state[at + X] + (c * px + s * pz), state[at + Z] + (c * pz - s * px)


@njit(**_options)
def closing_work(state: Any, j: int, layout: Any, elements: int) -> float:
    """Work of the contacts in the half step that separates the last forces from the last velocities, J.

    The energy that the scheme gives a body is force times displacement, half of it before and half after the whole
    step at which the force acts; `contact` books the second half with the next step.
    """
    work = 0.0
    before = np.empty(8)
    for p in range(layout.shape[0]):
        at = (OWN + elements * BODY + p * PAIR) * COLUMNS
        q = state[at : at + PAIR * COLUMNS]
        if q[CONTACT_1 + j] == OPEN and q[CONTACT_2 + j] == OPEN:
            continue
        for k in range(8):
            before[k] = q[DA1 + k * COLUMNS + j]
        first, second = layout[p, 0], layout[p, 1]
        a = state[(OWN + first * BODY) * COLUMNS : (OWN + (first + 1) * BODY) * COLUMNS]
        b = state[(OWN + second * BODY) * COLUMNS : (OWN + (second + 1) * BODY) * COLUMNS]
        depths_before(q, a, b, j, 0.0)
        for end in range(2):
            base = SPRING_1 if end == 0 else SPRING_2
            mine = q[base + (CONTACT_1 - SPRING_1) + j] != THEIRS
            k = (0 if end == 0 else 2) if mine else (6 if end == 0 else 4)
            depth = q[DA1 + k * COLUMNS + j] - before[k]
            slip = before[k + 1] - q[DA1 + (k + 1) * COLUMNS + j]
            slip = slip if mine else -slip
            work += 0.5 * (q[base + (N_1 - SPRING_1) + j] * depth - q[base + (T_1 - SPRING_1) + j] * slip)
        for k in range(8):
            q[DA1 + k * COLUMNS + j] = before[k]
    return work


@njit(**_options)
def finish(
    state: Any, j: int, layout: Any, elements: int, limits: Any, status: int, steps: int, gravity: float,
    out: Any, each: Any,
) -> None:  # fmt: skip
    """Write the results of a column."""
    deepest, work, taken = 0.0, 0.0, closing_work(state, j, layout, elements)
    for p in range(layout.shape[0]):
        at = (OWN + elements * BODY + p * PAIR) * COLUMNS + j
        deepest = max(deepest, state[at + DEEPEST])
        taken += state[at + TAKEN]
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS + j
        work += state[at + WORK]
        side = state[at + SIDE]
        each[e, E_SIDE] = side
        each[e, E_TIME] = np.nan
        if side != 0.0:
            each[e, E_TIME] = state[at + UPRIGHT_UNTIL]
        each[e, E_ANGLE] = min(state[at + PEAK_ANGLE], 0.5 * np.pi) / state[at + CRITICAL]
        each[e, E_SLIP], each[e, E_RESIDUAL] = state[at + PEAK_SLIP], state[at + SLIP]
    balance = (moving_energy(state, j, elements, gravity) - state[ENERGY + j]) - work + taken
    out[R_STATUS], out[R_DEPTH], out[R_STEPS] = status, deepest, steps
    out[R_ENERGY] = abs(balance) / max(work, limits[LEAST_BARRIER], taken)


@njit(**_options)
def note(state: Any, j: int, elements: int, interval: float, path: Any) -> None:
    """Write a column's state into a row of its trajectory, velocities brought to the whole step."""
    path[T_TIME] = state[SAMPLE + j] * interval
    path[T_GROUND] = state[BASE + j]
    half = 0.5 * state[STEP + j]
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS + j
        to = 2 + 6 * e
        path[to + T_X], path[to + T_Z], path[to + T_ANGLE] = state[at + X], state[at + Z], state[at + ANGLE]
        path[to + T_VX] = state[at + VX] + half * state[at + AX]
        path[to + T_VZ] = state[at + VZ] + half * state[at + AZ]
        path[to + T_VW] = state[at + VW] + half * state[at + AW]


@njit(nogil=True, **_options)
def run_queue(
    scheme: int, queue: Any, cases: Any, row_of_case: Any, variant_of_case: Any, initial: Any, layout: Any, sizes: Any, shapes: Any,
    rules: Any, limits: Any, ground: Any, upward: Any, samples: int, interval: float, steps: int, gravity: float,
    budget: int, counter: Any, path: Any, results: Any, each: Any,
) -> int:  # fmt: skip
    """Run the cases of a queue, all with the same number of steps per sample; a finished column takes the next one.

    Parameters
    ----------
    scheme : int
        A `overturning.dem.time_step.Scheme`.
    queue : ndarray of int64, shape (m,)
        Rows of `cases` to run, in this order.
    cases : ndarray, shape (n, PARAMETERS)
        The case table.
    row_of_case, variant_of_case : ndarray of int64, shape (n,)
        Row of `ground` that shakes each case, and its variant of the scene.
    initial : ndarray, shape (variants, rows)
        A column at rest.
    layout : ndarray of int64, shape (pairs, 2)
        The two elements of each pair.
    sizes : ndarray of int64, shape (elements,)
        Number of vertices of each element.
    shapes : ndarray, shape (variants, elements, vertices, 9)
        Faces: both ends, normal, distance, middle, half length.
    rules, limits : ndarray, shape (variants, elements, RULES), (variants, LIMITS)
        When an element has fallen, when a case has failed or rests.
    ground : ndarray, shape (azimuths, samples + 3)
        Acceleration of the base towards the azimuth, m/s², padded with zeros.
    upward : ndarray, shape (samples + 3,) or (0,)
        Upward acceleration, m/s².
    samples, interval, steps : int, float, int
        Length of the record, time between samples (s), steps per sample.
    gravity : float
        m/s².
    budget : int
        Largest number of steps of one case.
    counter : ndarray of int64, shape (1,)
        Grows by the element steps done; for progress.
    path : ndarray, shape (rows, 2 + 6 elements)
        Filled with the first column's state at each sample; no rows to leave out.
    results, each : ndarray, shape (n, RESULTS), (n, elements, ELEMENT_RESULTS)
        Filled in the rows of the queue.

    Returns
    -------
    int
        Rows of `path` that were filled.
    """
    rows, elements = initial.shape[1], sizes.size
    owner = np.zeros(rows * COLUMNS)
    state: Any = borrowed(owner)  # type: ignore[call-arg]
    case, row = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    variant, done = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    free = 0
    for e in range(elements):
        free += 1 if rules[0, e, IS_FREE] > 0.0 else 0
    active, head, noted, filled = 0, 0, 0, 0
    stride = max(int(LOOK / interval), 1)
    while True:
        while active < COLUMNS and head < queue.size:
            c = queue[head]
            case[active], row[active], variant[active], done[active] = c, row_of_case[c], variant_of_case[c], 0
            start(
                state, active, cases[c], initial[variant[active]], layout, sizes, shapes[variant[active]], interval,
                steps, gravity,
            )  # fmt: skip
            active, head = active + 1, head + 1
        if active == 0:
            owner[0] = noted  # held until here
            return noted
        # Columns that never held a case repeat the first, so that nothing undefined is computed beside the others.
        filled = max(filled, active)
        while filled < COLUMNS:
            row[filled], variant[filled] = row[0], variant[0]
            for r in range(rows):
                state[r * COLUMNS + filled] = state[r * COLUMNS]
            filled += 1
        next_sample(state, elements, row, ground, upward, steps)
        if noted < path.shape[0]:
            note(state, 0, elements, interval, path[noted])
            noted += 1
        for _ in range(steps):
            step(state, scheme, layout, sizes, shapes, variant, gravity)
        end_sample(state, elements, rules[0], steps, interval)
        counter[0] += active * steps * free
        j = 0
        while j < active:
            done[j] += steps
            if int(state[SAMPLE + j]) % stride != 0 and done[j] < budget:
                j += 1
                continue
            scene = variant[j]
            ended = verdict(state, j, layout, elements, rules[scene], limits[scene], float(samples), gravity)
            if ended < 0 and done[j] >= budget:
                ended = 5
            if ended < 0:
                j += 1
                continue
            finish(
                state, j, layout, elements, limits[scene], ended, done[j], gravity, results[case[j]],
                each[case[j]],
            )  # fmt: skip
            # The last column moves into the free place.
            active -= 1
            case[j], row[j], variant[j], done[j] = case[active], row[active], variant[active], done[active]
            for r in range(rows):
                state[r * COLUMNS + j] = state[r * COLUMNS + active]


keep_compiled(run_queue)
