"""What the ends of a pair's contact remember: at rest, and when a search gives the pair other faces."""

from typing import Any

import numpy as np
from numba import njit

# isort: off
from overturning.dem.polygon.columns import (
    AHI, ALO, ANX, BHI, BLO, BNX, COLUMNS, CONTACT, COS, HANDED_ON, KN, KS, MEMORY, MINE, MOMENT_A, MOMENT_B, NORMAL,
    OPEN, OPTIONS, SA1, SA2, SECOND, SIN, SPRING, SUM_X, SUM_Z, TANGENT, THEIRS, X, Z,
)  # fmt: skip

# isort: on
from overturning.dem.polygon.faces import depth_row


@njit(**OPTIONS)
def let_go(q: Any, j: int) -> None:
    """Forget both ends of a pair that is out of reach, and its forces."""
    for k in range(2 * MEMORY):
        q[SPRING + k * COLUMNS + j] = 0.0
    q[SUM_X + j], q[SUM_Z + j], q[MOMENT_A + j], q[MOMENT_B + j] = 0.0, 0.0, 0.0, 0.0


@njit(**OPTIONS)
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
        at = end * SECOND + j
        for k in range(MEMORY):
            memory[end, k] = q[SPRING + k * COLUMNS + at]
            q[SPRING + k * COLUMNS + at] = 0.0
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
        at = target * SECOND + j
        if q[CONTACT + at] != OPEN and q[NORMAL + at] >= n:
            continue
        q[SPRING + at], q[CONTACT + at] = memory[end, 0], HANDED_ON
        q[NORMAL + at], q[TANGENT + at] = n, t


@njit(**OPTIONS)
def end_normal(
    a: Any, b: Any, j: int, shape_a: Any, shape_b: Any, face_a: int, face_b: int, mine: bool
) -> tuple[float, float]:
    """Direction of the normal force on a at an end: b's normal where the vertex is a's, else a's turned round."""
    if mine:
        c, s, nx, nz = b[COS + j], b[SIN + j], shape_b[face_b, 4], shape_b[face_b, 5]
        return c * nx + s * nz, c * nz - s * nx
    c, s, nx, nz = a[COS + j], a[SIN + j], shape_a[face_a, 4], shape_a[face_a, 5]
    return -(c * nx + s * nz), -(c * nz - s * nx)


@njit(**OPTIONS)
def end_place(q: Any, a: Any, b: Any, j: int, end: int, mine: bool) -> tuple[float, float, float, float]:
    """An end's vertex, from the centre of a, and the direction of the normal force on a."""
    e, face, along = (a, ANX, ALO if end == 0 else AHI) if mine else (b, BNX, BHI if end == 0 else BLO)
    other, normal = (b, BNX) if mine else (a, ANX)
    fx, fz = q[face + j], q[face + COLUMNS + j]
    off, place = q[face + 2 * COLUMNS + j], q[along + j]
    px, pz = off * fx - place * fz, off * fz + place * fx
    rx, rz = e[COS + j] * px + e[SIN + j] * pz, e[COS + j] * pz - e[SIN + j] * px
    fx, fz = q[normal + j], q[normal + COLUMNS + j]
    nx, nz = other[COS + j] * fx + other[SIN + j] * fz, other[COS + j] * fz - other[SIN + j] * fx
    if mine:
        return rx, rz, nx, nz
    return rx - (a[X + j] - b[X + j]), rz - (a[Z + j] - b[Z + j]), -nx, -nz


@njit(**OPTIONS)
def load_at_rest(q: Any, a: Any, b: Any, j: int) -> None:
    """Give the ends of a scene at rest, whose springs are loaded, the forces that go with them."""
    dx, dz = a[X + j] - b[X + j], a[Z + j] - b[Z + j]
    total_x, total_z, moment_a, moment_b = 0.0, 0.0, 0.0, 0.0
    for end in range(2):
        at = end * SECOND + j
        if q[CONTACT + at] == OPEN:
            continue
        mine = q[CONTACT + at] == MINE
        n, t = max(q[KN + j] * q[depth_row(mine, end) + j], 0.0), -q[KS + j] * q[SPRING + at]
        q[NORMAL + at], q[TANGENT + at] = n, t
        rx, rz, nx, nz = end_place(q, a, b, j, end, mine)
        x, z = n * nx + t * nz, n * nz - t * nx
        total_x, total_z = total_x + x, total_z + z
        moment_a, moment_b = moment_a + (rz * x - rx * z), moment_b + ((rz + dz) * x - (rx + dx) * z)
    q[SUM_X + j], q[SUM_Z + j], q[MOMENT_A + j], q[MOMENT_B + j] = total_x, total_z, moment_a, moment_b
