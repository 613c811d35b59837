"""The general kernel: convex polygons that meet at vertices and faces, many cases side by side.

All jitted code of this kernel is in this file. Quantity ``Q`` of column (case) ``j`` stands at ``[Q + j]`` of a block of
rows, one block per element and one per pair, so that the innermost loops run over columns without branches and LLVM
makes vector code of them. Fast-math and contraction are off and those loops know only ``+ - * /`` and comparisons: a
column's bits depend neither on its neighbours, nor on the thread, nor on the width of the processor's vectors.

Signs: x points to the azimuth, z up, rotation is positive clockwise (towards the azimuth). The point (p, q) of an
element is at ``(x + c p + s q, z − s p + c q)`` with c, s the cosine and sine of its rotation; a force (X, Z) at the
place (p', q') from the centre has the moment ``q' X − p' Z``.

One step of Cundall's scheme: nearest faces where the motion since the last search could have changed them (`search`),
forces of every pair at the whole step (`contact`), accelerations, velocities half a step later, poses (`advance`).
docs/scenes.md derives the rules.
"""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.cache import keep_compiled, prefer_full_width

prefer_full_width()

COLUMNS: Final = 64
"""Cases side by side."""

# A column's own rows,
(STEP, RATE, TICK, BASE, SLOPE, UP_BASE, UP_SLOPE, GROUND, UP) = (i * COLUMNS for i in range(9))
(AMPLITUDE, SAMPLE, CALM, AFTER, ENERGY) = (i * COLUMNS for i in range(9, 14))
OWN: Final = 14
# those of an element: pose, velocity at the half step, acceleration, motion of the last step, force,
(X, Z, ANGLE, COS, SIN, VX, VZ, VW, AX, AZ, AW, MOVED, TURNED, FX, FZ, MOMENT) = (i * COLUMNS for i in range(16))
# constants,
(INVERSE_MASS, INVERSE_INERTIA, MASS, FRAME, WEIGHT, HELD, CRITICAL) = (i * COLUMNS for i in range(16, 23))
# what is booked, and what is looked at once per sample only;
(WORK, PEAK_ANGLE, LAST_UPRIGHT) = (i * COLUMNS for i in range(23, 26))
(UPRIGHT_UNTIL, SIDE, PEAK_SLIP, SLIP) = (i * COLUMNS for i in range(26, 30))
BODY: Final = 30
# those of a face: ends counter-clockwise, outward normal, distance from the centre, middle along the tangent, half length,
(AX1, AZ1, AX2, AZ2, ANX, ANZ, AOFF, AMID, AHALF) = (i * COLUMNS for i in range(9))
# the same of the pair's second element,
(BX1, BZ1, BX2, BZ2, BNX, BNZ, BOFF, BMID, BHALF) = (i * COLUMNS for i in range(9, 18))
# contact law, reach of a rotation, limits of motion: before faces can change, before a contact can begin; face indices,
(KN, KS, HN, HS, FRICTION, COMPLIANCE, LEVER, LIMIT, REACH, FACE_A, FACE_B) = (i * COLUMNS for i in range(18, 29))
# gaps and places along the face one step ago of a's first and second vertex and of b's,
(GA1, SA1, GA2, SA2, GB1, SB1, GB2, SB2) = (i * COLUMNS for i in range(29, 37))
# memory of both ends: spring, closed, whose vertex (1: a's, 0: b's), forces along normal and tangent and in the plane,
(SPRING_1, CLOSED_1, WHOSE_1, N_1, T_1, FX_1, FZ_1) = (i * COLUMNS for i in range(37, 44))
(SPRING_2, CLOSED_2, WHOSE_2, N_2, T_2, FX_2, FZ_2) = (i * COLUMNS for i in range(44, 51))
# motion since the search, largest penetration, energy lost, force on a, moments on a and b.
(USED, DEEPEST, LOST, SUM_X, SUM_Z, MOMENT_A, MOMENT_B) = (i * COLUMNS for i in range(51, 58))
PAIR: Final = 58

_options: dict[str, Any] = {"fastmath": False, "error_model": "numpy", "boundscheck": False}


@njit(**_options)
def contact(q: Any, a: Any, b: Any, own: Any, columns: int) -> None:
    """Forces of one pair: spring, dashpot and slider at both ends of the faces' common stretch."""
    for j in range(columns):
        rate = own[RATE + j]
        ca, sa, cb, sb = a[COS + j], a[SIN + j], b[COS + j], b[SIN + j]
        dx, dz = a[X + j] - b[X + j], a[Z + j] - b[Z + j]
        # Outward normals of both faces in the plane; tangents are (−n_z, n_x).
        anx, anz = ca * q[ANX + j] + sa * q[ANZ + j], ca * q[ANZ + j] - sa * q[ANX + j]
        bnx, bnz = cb * q[BNX + j] + sb * q[BNZ + j], cb * q[BNZ + j] - sb * q[BNX + j]
        half_a, half_b = q[AHALF + j], q[BHALF + j]
        # Ends of a's face seen from a's centre, those of b's face too.
        a1x, a1z = ca * q[AX1 + j] + sa * q[AZ1 + j], ca * q[AZ1 + j] - sa * q[AX1 + j]
        a2x, a2z = ca * q[AX2 + j] + sa * q[AZ2 + j], ca * q[AZ2 + j] - sa * q[AX2 + j]
        b1x, b1z = (cb * q[BX1 + j] + sb * q[BZ1 + j]) - dx, (cb * q[BZ1 + j] - sb * q[BX1 + j]) - dz
        b2x, b2z = (cb * q[BX2 + j] + sb * q[BZ2 + j]) - dx, (cb * q[BZ2 + j] - sb * q[BX2 + j]) - dz
        # Gap from the other's face and place along it.
        x, z = a1x + dx, a1z + dz
        ga1, sa1 = (bnx * x + bnz * z) - q[BOFF + j], (bnx * z - bnz * x) - q[BMID + j]
        x, z = a2x + dx, a2z + dz
        ga2, sa2 = (bnx * x + bnz * z) - q[BOFF + j], (bnx * z - bnz * x) - q[BMID + j]
        gb1, sb1 = (anx * b1x + anz * b1z) - q[AOFF + j], (anx * b1z - anz * b1x) - q[AMID + j]
        gb2, sb2 = (anx * b2x + anz * b2z) - q[AOFF + j], (anx * b2z - anz * b2x) - q[AMID + j]
        kn, ks, mu, compliance = q[KN + j], q[KS + j], q[FRICTION + j], q[COMPLIANCE + j]
        hn, hs = q[HN + j] * rate, q[HS + j] * rate

        # End 1: the inner one of a's first and b's second vertex.
        mine = sa1 <= half_b
        within = (mine & (sa1 >= -half_b)) | ((not mine) & (sb2 <= half_a) & (sb2 >= -half_a))
        nx, nz = (bnx if mine else -anx), (bnz if mine else -anz)
        rx, rz = (a1x if mine else b2x), (a1z if mine else b2z)
        depth, before = -(ga1 if mine else gb2), -(q[GA1 + j] if mine else q[GB2 + j])
        # Slip of a over b, along (n_z, −n_x); a's place along b's tangent grows against it, and so does b's along a's.
        slip = -((sa1 - q[SA1 + j]) if mine else (sb2 - q[SB2 + j]))
        near = q[USED + j] >= q[REACH + j]
        closed = within & near & (depth > 0.0)
        was = q[CLOSED_1 + j] > 0.0
        whose = 1.0 if mine else 0.0
        handed = was & (whose != q[WHOSE_1 + j])
        fn = kn * depth + hn * (depth - before)
        fn = fn if closed & (fn > 0.0) else 0.0
        same = q[SPRING_1 + j] + slip
        kept = -((q[FX_1 + j] * nz - q[FZ_1 + j] * nx) + hs * slip) * compliance
        stretch = kept if handed else same
        stretch = stretch if was else 0.0
        cap = mu * fn
        ft = -(ks * stretch) - hs * slip
        ft = cap if ft > cap else ft
        ft = -cap if ft < -cap else ft
        most = cap * compliance
        spring = most if stretch > most else stretch
        spring = -most if spring < -most else spring
        p, o = (depth if closed else 0.0), (before if was & (before > 0.0) else 0.0)
        old = q[SPRING_1 + j] if was else 0.0
        lost = 0.5 * ((q[N_1 + j] + fn) * (depth - before) - (q[T_1 + j] + ft) * slip)
        lost = lost - 0.5 * (kn * (p * p - o * o) + ks * (spring * spring - old * old))
        fx1, fz1 = fn * nx + ft * nz, fn * nz - ft * nx
        ma1, mb1 = rz * fx1 - rx * fz1, (rz + dz) * fx1 - (rx + dx) * fz1
        deepest = depth if closed & (depth > q[DEEPEST + j]) else q[DEEPEST + j]
        q[SPRING_1 + j] = spring
        q[CLOSED_1 + j] = 1.0 if closed else 0.0
        q[WHOSE_1 + j] = whose
        q[N_1 + j], q[T_1 + j] = fn, ft
        q[FX_1 + j], q[FZ_1 + j] = fx1, fz1

        # End 2: the inner one of a's second and b's first vertex.
        mine = sa2 >= -half_b
        within = (mine & (sa2 <= half_b)) | ((not mine) & (sb1 <= half_a) & (sb1 >= -half_a))
        nx, nz = (bnx if mine else -anx), (bnz if mine else -anz)
        rx, rz = (a2x if mine else b1x), (a2z if mine else b1z)
        depth, before = -(ga2 if mine else gb1), -(q[GA2 + j] if mine else q[GB1 + j])
        slip = -((sa2 - q[SA2 + j]) if mine else (sb1 - q[SB1 + j]))
        closed = within & near & (depth > 0.0)
        was = q[CLOSED_2 + j] > 0.0
        whose = 1.0 if mine else 0.0
        handed = was & (whose != q[WHOSE_2 + j])
        fn = kn * depth + hn * (depth - before)
        fn = fn if closed & (fn > 0.0) else 0.0
        same = q[SPRING_2 + j] + slip
        kept = -((q[FX_2 + j] * nz - q[FZ_2 + j] * nx) + hs * slip) * compliance
        stretch = kept if handed else same
        stretch = stretch if was else 0.0
        cap = mu * fn
        ft = -(ks * stretch) - hs * slip
        ft = cap if ft > cap else ft
        ft = -cap if ft < -cap else ft
        most = cap * compliance
        spring = most if stretch > most else stretch
        spring = -most if spring < -most else spring
        p, o = (depth if closed else 0.0), (before if was & (before > 0.0) else 0.0)
        old = q[SPRING_2 + j] if was else 0.0
        gone = 0.5 * ((q[N_2 + j] + fn) * (depth - before) - (q[T_2 + j] + ft) * slip)
        gone = gone - 0.5 * (kn * (p * p - o * o) + ks * (spring * spring - old * old))
        fx2, fz2 = fn * nx + ft * nz, fn * nz - ft * nx
        deepest = depth if closed & (depth > deepest) else deepest
        q[SPRING_2 + j] = spring
        q[CLOSED_2 + j] = 1.0 if closed else 0.0
        q[WHOSE_2 + j] = whose
        q[N_2 + j], q[T_2 + j] = fn, ft
        q[FX_2 + j], q[FZ_2 + j] = fx2, fz2

        q[GA1 + j], q[SA1 + j], q[GA2 + j], q[SA2 + j] = ga1, sa1, ga2, sa2
        q[GB1 + j], q[SB1 + j], q[GB2 + j], q[SB2 + j] = gb1, sb1, gb2, sb2
        q[DEEPEST + j] = deepest
        q[LOST + j] = q[LOST + j] + (lost + gone)
        q[SUM_X + j], q[SUM_Z + j] = fx1 + fx2, fz1 + fz2
        q[MOMENT_A + j] = ma1 + (rz * fx2 - rx * fz2)
        q[MOMENT_B + j] = mb1 + ((rz + dz) * fx2 - (rx + dx) * fz2)


@njit(**_options)
def add_forces(q: Any, a: Any, b: Any, columns: int) -> None:
    """Add a pair's force and moments to both elements'."""
    for j in range(columns):
        a[FX + j] = a[FX + j] + q[SUM_X + j]
        a[FZ + j] = a[FZ + j] + q[SUM_Z + j]
        a[MOMENT + j] = a[MOMENT + j] + q[MOMENT_A + j]
    for j in range(columns):
        b[FX + j] = b[FX + j] - q[SUM_X + j]
        b[FZ + j] = b[FZ + j] - q[SUM_Z + j]
        b[MOMENT + j] = b[MOMENT + j] - q[MOMENT_B + j]


@njit(**_options)
def advance(e: Any, own: Any, columns: int, gravity: float) -> None:
    """Accelerations at the whole step, velocities half a step later, pose one step later: central differences."""
    for j in range(columns):
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
        e[MOVED + j], e[TURNED + j] = dt * (abs(vx) + abs(vz)), abs(turn)
        e[PEAK_ANGLE + j] = size if size > e[PEAK_ANGLE + j] else e[PEAK_ANGLE + j]
        e[LAST_UPRIGHT + j] = tick + 1.0 if size < e[CRITICAL + j] else e[LAST_UPRIGHT + j]
        e[FX + j], e[FZ + j], e[MOMENT + j] = 0.0, 0.0, 0.0


@njit(**_options)
def shake(own: Any, columns: int) -> None:
    """Acceleration of the base now, linear between samples."""
    for j in range(columns):
        own[GROUND + j] = own[BASE + j] + own[SLOPE + j] * own[TICK + j]
        own[UP + j] = own[UP_BASE + j] + own[UP_SLOPE + j] * own[TICK + j]


@njit(**_options)
def count_motion(q: Any, a: Any, b: Any, columns: int) -> int:
    """Add the last step's motion; 1 if a pair could touch, plus 1024 for each column that has to search."""
    flags = 0
    for j in range(columns):
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
        for k in range(9):
            q[AX1 + k * COLUMNS + j] = shape_a[face_a, k]
            q[BX1 + k * COLUMNS + j] = shape_b[face_b, k]
        if not fresh:
            hand_on(q, j, old_a, old_b, face_a, face_b, na, nb, shape_a, shape_b)
    if changed or was_far or reach > 0.0:
        old_gaps(q, a, b, own, j)


@njit(**_options)
def let_go(q: Any, j: int) -> None:
    """Forget both ends of a pair that is out of reach; what their springs still hold is booked as lost."""
    for end in range(2):
        base = SPRING_1 if end == 0 else SPRING_2
        if q[base + (CLOSED_1 - SPRING_1) + j] > 0.0:
            force = q[base + (N_1 - SPRING_1) + j]
            q[LOST + j] += 0.5 * (force * force / q[KN + j] + q[KS + j] * q[base + j] ** 2)
        for k in range(7):
            q[base + k * COLUMNS + j] = 0.0


@njit(**_options)
def old_gaps(q: Any, a: Any, b: Any, own: Any, j: int) -> None:
    """Gaps of the new faces' vertices one step ago: poses taken back by the last velocities."""
    gaps_before(q, a, b, j, own[STEP + j])


@njit(**_options)
def gaps_before(q: Any, a: Any, b: Any, j: int, dt: float) -> None:
    """Gaps of the faces' vertices a time dt ago, 0 for now."""
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
    for k in range(4):
        mine = k < 2
        own_c, own_s, other_c, other_s = pose[0, 0], pose[0, 1], pose[1, 0], pose[1, 1]
        dx, dz = pose[0, 2] - pose[1, 2], pose[0, 3] - pose[1, 3]
        if not mine:
            own_c, own_s, other_c, other_s = other_c, other_s, own_c, own_s
            dx, dz = -dx, -dz
        point = (AX1 if k == 0 else AX2) if mine else (BX1 if k == 2 else BX2)
        face = BX1 if mine else AX1
        px, pz = q[point + j], q[point + COLUMNS + j]
        nx, nz = q[face + (ANX - AX1) + j], q[face + (ANZ - AX1) + j]
        mx, mz = other_c * nx + other_s * nz, other_c * nz - other_s * nx
        x, z = (own_c * px + own_s * pz) + dx, (own_c * pz - own_s * px) + dz
        q[GA1 + 2 * k * COLUMNS + j] = (mx * x + mz * z) - q[face + (AOFF - AX1) + j]
        q[SA1 + 2 * k * COLUMNS + j] = (mx * z - mz * x) - q[face + (AMID - AX1) + j]


@njit(**_options)
def hand_on(
    q: Any, j: int, old_a: int, old_b: int, face_a: int, face_b: int, na: int, nb: int, shape_a: Any, shape_b: Any
) -> None:
    """Give each loaded end's memory to the new end with the same vertex, else to the one nearest in place.

    ``WHOSE`` becomes −1, so that the next step stretches the spring to the share of the old force along the new face.
    """
    memory = np.zeros((2, 7))
    for end in range(2):
        base = SPRING_1 if end == 0 else SPRING_2
        for k in range(7):
            memory[end, k] = q[base + k * COLUMNS + j]
            q[base + k * COLUMNS + j] = 0.0
    for end in range(2):
        if memory[end, 1] == 0.0:
            continue
        mine = memory[end, 2] > 0.0
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
        base = SPRING_1 if target == 0 else SPRING_2
        if q[base + (CLOSED_1 - SPRING_1) + j] > 0.0 and q[base + (N_1 - SPRING_1) + j] >= memory[end, 3]:
            continue
        for k in range(7):
            q[base + k * COLUMNS + j] = memory[end, k]
        q[base + (WHOSE_1 - SPRING_1) + j] = -1.0


@njit(**_options)
def step(state: Any, columns: int, layout: Any, sizes: Any, shapes: Any, variant: Any, gravity: float) -> None:
    """One step of all columns."""
    own = state[: OWN * COLUMNS]
    shake(own, columns)
    elements = sizes.size
    for p in range(layout.shape[0]):
        first, second = layout[p, 0], layout[p, 1]
        at = (OWN + elements * BODY + p * PAIR) * COLUMNS
        q = state[at : at + PAIR * COLUMNS]
        a = state[(OWN + first * BODY) * COLUMNS : (OWN + (first + 1) * BODY) * COLUMNS]
        b = state[(OWN + second * BODY) * COLUMNS : (OWN + (second + 1) * BODY) * COLUMNS]
        flags = count_motion(q, a, b, columns)
        if flags >= 1024:
            for j in range(columns):
                if q[USED + j] >= q[LIMIT + j]:
                    search(
                        q, a, b, own, j, sizes[first], sizes[second], shapes[variant[j], first],
                        shapes[variant[j], second], False,
                    )  # fmt: skip
            flags = 0
            for j in range(columns):
                flags += 1 if q[USED + j] >= q[REACH + j] else 0
        if flags > 0:
            contact(q, a, b, own, columns)
            add_forces(q, a, b, columns)
    for e in range(elements):
        if layout_moves(state, e):
            advance(state[(OWN + e * BODY) * COLUMNS : (OWN + (e + 1) * BODY) * COLUMNS], own, columns, gravity)
    for j in range(columns):
        own[TICK + j] = own[TICK + j] + 1.0


@njit(**_options)
def layout_moves(state: Any, element: int) -> bool:
    """Whether an element is free or held; a driven one rests in the frame of the base."""
    return bool(state[(OWN + element * BODY) * COLUMNS + FRAME] != 0.0)


# Rows of a free element's rules: whether it is free, angle and height at which it has fallen, what it stands on, the
# point of its base and of the support whose distance is its slip, and the energy that its overturning takes.
(IS_FREE, FALL_ANGLE, LOWEST, SUPPORT, BASE_X, BASE_Z, SUPPORT_X, SUPPORT_Z, BARRIER) = range(9)
RULES: Final = 9
# Rows of a scene's limits: deepest penetration, kinetic energy at rest, least barrier.
DEEPEST_ALLOWED, REST_ENERGY, LEAST_BARRIER = range(3)
LIMITS: Final = 3
# Columns of the case table.
(P_AMPLITUDE, P_FRICTION, P_DAMPING, P_FIRST, P_CALM, P_AFTER) = range(6)
PARAMETERS: Final = 6
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
    for p in range(layout.shape[0]):
        first, second = layout[p, 0], layout[p, 1]
        at = (OWN + sizes.size * BODY + p * PAIR) * COLUMNS
        q = state[at : at + PAIR * COLUMNS]
        a = state[(OWN + first * BODY) * COLUMNS : (OWN + (first + 1) * BODY) * COLUMNS]
        b = state[(OWN + second * BODY) * COLUMNS : (OWN + (second + 1) * BODY) * COLUMNS]
        q[FRICTION + j] = q[FRICTION + j] if q[FRICTION + j] >= 0.0 else case[P_FRICTION]
        q[HN + j], q[HS + j] = q[HN + j] * case[P_DAMPING], q[HS + j] * case[P_DAMPING]
        search(q, a, b, own, j, sizes[first], sizes[second], shapes[first], shapes[second], True)
    own[ENERGY + j] = energy(state, j, layout, sizes.size, gravity)


@njit(**_options)
def energy(state: Any, j: int, layout: Any, elements: int, gravity: float) -> float:
    """Kinetic and gravitational energy of a column at the last half step and spring energy at the whole step before, J."""
    total = 0.0
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS + j
        if state[at + INVERSE_MASS] == 0.0:
            continue
        height = state[at + Z] - 0.5 * state[STEP + j] * state[at + VZ]
        total += kinetic(state, at) + state[at + MASS] * gravity * height
    for p in range(layout.shape[0]):
        at = (OWN + elements * BODY + p * PAIR) * COLUMNS + j
        for end in range(2):
            base = at + (SPRING_1 if end == 0 else SPRING_2)
            if state[base + (CLOSED_1 - SPRING_1)] > 0.0:
                mine = state[base + (WHOSE_1 - SPRING_1)] != 0.0
                gap = state[at + ((GA1 if end == 0 else GA2) if mine else (GB2 if end == 0 else GB1))]
                total += 0.5 * (state[at + KN] * gap * gap + state[at + KS] * state[base] ** 2)
    return total


@njit(**_options)
def kinetic(state: Any, at: int) -> float:
    """Kinetic energy of an element, J, from the velocities half a step back."""
    vx, vz, vw = state[at + VX], state[at + VZ], state[at + VW]
    return float(0.5 * (state[at + MASS] * (vx * vx + vz * vz) + vw * vw / state[at + INVERSE_INERTIA]))


@njit(**_options)
def next_sample(state: Any, columns: int, elements: int, row: Any, ground: Any, upward: Any, steps: int) -> None:
    """Bring the turning pairs back to length 1 and load the ground motion of each column's sample."""
    scale = 1.0 / steps
    last = ground.shape[1] - 3
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS
        for j in range(columns):
            c, s = state[at + COS + j], state[at + SIN + j]
            unit = 1.5 - 0.5 * (c * c + s * s)
            state[at + COS + j], state[at + SIN + j] = c * unit, s * unit
    for j in range(columns):
        i = min(int(state[SAMPLE + j]), last)
        factor = state[AMPLITUDE + j]
        a0, a1 = ground[row[j], i] * factor, ground[row[j], i + 1] * factor
        state[BASE + j], state[SLOPE + j] = a0, (a1 - a0) * scale
        if upward.size > 0:
            a0, a1 = upward[i] * factor, upward[i + 1] * factor
            state[UP_BASE + j], state[UP_SLOPE + j] = a0, (a1 - a0) * scale
        state[TICK + j] = 0.0


@njit(**_options)
def book_upright(state: Any, columns: int, elements: int, steps: int, interval: float) -> None:
    """The last time at which each standing element's rotation was below the critical angle; the sample is over."""
    scale = 1.0 / steps
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS
        for j in range(columns):
            passed = state[at + LAST_UPRIGHT + j]
            if passed >= 0.0 and state[at + SIDE + j] == 0.0:
                state[at + UPRIGHT_UNTIL + j] = (state[SAMPLE + j] + passed * scale) * interval
            state[at + LAST_UPRIGHT + j] = -1.0
    for j in range(columns):
        state[SAMPLE + j] += 1.0


@njit(**_options)
def verdict(state: Any, j: int, layout: Any, elements: int, rules: Any, limits: Any, end: float, gravity: float) -> int:
    """Status of a column at the end of a sample: -1 to go on, else a `Status`."""
    check, moving, standing, fallen, slid = 0.0, 0.0, 0, 0, False
    for e in range(elements):
        at = (OWN + e * BODY) * COLUMNS + j
        check += state[at + X] + state[at + Z] + state[at + VX] + state[at + VZ] + state[at + VW] + state[at + COS]
        if rules[e, IS_FREE] == 0.0:
            continue
        on = (OWN + int(rules[e, SUPPORT]) * BODY) * COLUMNS + j
        dx, dz = base_point(state, at, rules[e, BASE_X], rules[e, BASE_Z])
        ox, oz = base_point(state, on, rules[e, SUPPORT_X], rules[e, SUPPORT_Z])
        slip = state[on + COS] * (dx - ox) - state[on + SIN] * (dz - oz)
        state[at + SLIP] = slip
        state[at + PEAK_SLIP] = max(state[at + PEAK_SLIP], abs(slip))
        moving += kinetic(state, at)
        slid = slid or abs(slip) > 0.1 * abs(rules[e, BASE_Z])
        if state[at + SIDE] == 0.0:
            if state[at + PEAK_ANGLE] >= rules[e, FALL_ANGLE]:
                state[at + SIDE] = 1.0 if state[at + ANGLE] > 0.0 else -1.0
            elif state[at + Z] < rules[e, LOWEST]:
                state[at + SIDE] = 1.0 if dx > ox else -1.0
        fallen += 1 if state[at + SIDE] != 0.0 else 0
        standing += 1 if state[at + SIDE] == 0.0 else 0
    if not np.isfinite(check):
        return 3
    grip, touching = 0, 0
    for p in range(layout.shape[0]):
        at = (OWN + elements * BODY + p * PAIR) * COLUMNS + j
        if state[at + DEEPEST] > limits[DEEPEST_ALLOWED]:
            return 3
        touching = int(state[at + CLOSED_1] + state[at + CLOSED_2])
        first, second = layout[p, 0], layout[p, 1]
        for e in (first, second):
            if rules[e, IS_FREE] > 0.0 and state[(OWN + e * BODY) * COLUMNS + j + SIDE] == 0.0:
                grip += touching
    if standing == 0:
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
        safe = fallen == 0 and not slid and spare < 0.5 * limits[LEAST_BARRIER]
        # Nothing can fall then; the largest rotations are known once what is left cannot reach them again.
        if safe and not may_rise(state, j, elements, rules, spare):
            return 0
        if sample >= state[AFTER + j]:
            return 0 if moving < 1e-4 * limits[LEAST_BARRIER] else 2
    return -1


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
        if q[CLOSED_1 + j] == 0.0 and q[CLOSED_2 + j] == 0.0:
            continue
        for k in range(8):
            before[k] = q[GA1 + k * COLUMNS + j]
        first, second = layout[p, 0], layout[p, 1]
        a = state[(OWN + first * BODY) * COLUMNS : (OWN + (first + 1) * BODY) * COLUMNS]
        b = state[(OWN + second * BODY) * COLUMNS : (OWN + (second + 1) * BODY) * COLUMNS]
        gaps_before(q, a, b, j, 0.0)
        for end in range(2):
            base = SPRING_1 if end == 0 else SPRING_2
            mine = q[base + (WHOSE_1 - SPRING_1) + j] != 0.0
            k = (0 if end == 0 else 2) if mine else (6 if end == 0 else 4)
            depth = before[k] - q[GA1 + k * COLUMNS + j]
            slip = before[k + 1] - q[GA1 + (k + 1) * COLUMNS + j]
            work += 0.5 * (q[base + (N_1 - SPRING_1) + j] * depth - q[base + (T_1 - SPRING_1) + j] * slip)
        for k in range(8):
            q[GA1 + k * COLUMNS + j] = before[k]
    return work


@njit(**_options)
def finish(
    state: Any, j: int, layout: Any, elements: int, limits: Any, status: int, steps: int, gravity: float,
    out: Any, each: Any,
) -> None:  # fmt: skip
    """Write the results of a column."""
    deepest, work, lost = 0.0, 0.0, closing_work(state, j, layout, elements)
    for p in range(layout.shape[0]):
        at = (OWN + elements * BODY + p * PAIR) * COLUMNS + j
        deepest = max(deepest, state[at + DEEPEST])
        lost += state[at + LOST]
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
    balance = (energy(state, j, layout, elements, gravity) - state[ENERGY + j]) - work + lost
    out[R_STATUS], out[R_DEPTH], out[R_STEPS] = status, deepest, steps
    out[R_ENERGY] = abs(balance) / max(work, limits[LEAST_BARRIER])


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
    queue: Any, cases: Any, row_of_case: Any, variant_of_case: Any, initial: Any, layout: Any, sizes: Any, shapes: Any,
    rules: Any, limits: Any, ground: Any, upward: Any, samples: int, interval: float, steps: int, gravity: float,
    budget: int, counter: Any, path: Any, results: Any, each: Any,
) -> int:  # fmt: skip
    """Run the cases of a queue, all with the same number of steps per sample; a finished column takes the next one.

    Parameters
    ----------
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
    state = np.zeros(rows * COLUMNS)
    case, row = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    variant, done = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    free = 0
    for e in range(elements):
        free += 1 if rules[0, e, IS_FREE] > 0.0 else 0
    active, head, noted, filled = 0, 0, 0, 0
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
            return noted
        columns = (active + 7) // 8 * 8
        # Columns that never held a case repeat the first, so that nothing undefined is computed beside the others.
        filled = max(filled, active)
        while filled < columns:
            row[filled], variant[filled] = row[0], variant[0]
            for r in range(rows):
                state[r * COLUMNS + filled] = state[r * COLUMNS]
            filled += 1
        next_sample(state, columns, elements, row, ground, upward, steps)
        if noted < path.shape[0]:
            note(state, 0, elements, interval, path[noted])
            noted += 1
        for _ in range(steps):
            step(state, columns, layout, sizes, shapes, variant, gravity)
        book_upright(state, columns, elements, steps, interval)
        counter[0] += active * steps * free
        j = 0
        while j < active:
            done[j] += steps
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
