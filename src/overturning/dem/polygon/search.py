"""Nearest faces: which two of a pair's faces can touch, and for how much motion that stays so."""

from typing import Any

import numpy as np
from numba import njit

# isort: off
from overturning.dem.polygon.columns import (
    ANX, BNX, COLUMNS, COS, FACE_A, FACE_B, LEVER, LIMIT, MOVED, OPTIONS, REACH, SIN, STEP, TURNED, USED, X, Z,
)  # fmt: skip

# isort: on
from overturning.dem.polygon.faces import depths_before
from overturning.dem.polygon.memory import hand_on, let_go


@njit(**OPTIONS)
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


@njit(**OPTIONS)
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


@njit(**OPTIONS)
def candidate(
    a: Any, b: Any, j: int, na: int, nb: int, shape_a: Any, shape_b: Any, k: int
) -> tuple[float, int, int, float, float]:
    """Separation by the k-th face, a's first and then b's, the pair of faces that goes with it, and how clearly.

    Clearly: the product of the normals, and by how much the next best is worse.
    """
    if k < na:
        gap = separation(a, b, j, nb, shape_a, shape_b, k)
        other, product, clear = most_opposed(a, b, j, nb, shape_a, shape_b, k)
        return gap, k, other, product, clear
    gap = separation(b, a, j, na, shape_b, shape_a, k - na)
    other, product, clear = most_opposed(b, a, j, na, shape_b, shape_a, k - na)
    return gap, other, k - na, product, clear


@njit(**OPTIONS)
def search(q: Any, a: Any, b: Any, own: Any, j: int, na: int, nb: int, shape_a: Any, shape_b: Any) -> None:
    """Nearest faces of a pair in one column, how much motion cannot change them, and what the springs remember.

    Of all faces the one with the largest separation from the other element is nearest; with it goes the other
    element's face most nearly opposite. Equal separations: the pair with the more nearly opposite normals, then the
    lower index, those of a first. A pair that has no faces yet, those of a column at rest, keeps its memory.
    """
    old_a, old_b = int(q[FACE_A + j]), int(q[FACE_B + j])
    most, face_a, face_b, opposed, play = -np.inf, old_a, old_b, np.inf, 0.0
    for k in range(na + nb):
        gap, first, second, product, clear = candidate(a, b, j, na, nb, shape_a, shape_b, k)
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
    for k in range(na + nb):
        gap, first, second, _, clear = candidate(a, b, j, na, nb, shape_a, shape_b, k)
        room = 0.4 * (most - gap)
        agrees = first == face_a and second == face_b
        limit = min(limit, max(room, 0.4 * lever * clear) if agrees else room)
    was_far = q[REACH + j] > 0.0
    # Two more steps like the last one are kept clear, so that the first step in reach is still one without contact.
    last = (a[MOVED + j] + b[MOVED + j]) + lever * (a[TURNED + j] + b[TURNED + j])
    reach = 0.9 * most - 2.0 * last
    q[LEVER + j], q[USED + j], q[REACH + j] = lever, 0.0, reach if reach > 0.0 else -1.0
    q[LIMIT + j] = max(limit, q[REACH + j])
    if reach > 0.0:
        let_go(q, j)
    changed = old_a != face_a or old_b != face_b
    if changed:
        q[FACE_A + j], q[FACE_B + j] = face_a, face_b
        put_face(q, ANX + j, shape_a, face_a)
        put_face(q, BNX + j, shape_b, face_b)
    if changed or was_far or reach > 0.0:
        depths_before(q, a, b, j, own[STEP + j])
    if changed and old_a >= 0:
        hand_on(q, a, b, j, old_a, old_b, face_a, face_b, na, nb, shape_a, shape_b)


@njit(**OPTIONS)
def put_face(q: Any, at: int, shape: Any, face: int) -> None:
    """Normal, distance and ends along the tangent of a face."""
    nx, nz = shape[face, 4], shape[face, 5]
    q[at], q[at + COLUMNS], q[at + 2 * COLUMNS] = nx, nz, shape[face, 6]
    q[at + 3 * COLUMNS] = nx * shape[face, 1] - nz * shape[face, 0]
    q[at + 4 * COLUMNS] = nx * shape[face, 3] - nz * shape[face, 2]
