"""Nearest faces: which two of a pair's faces can touch, and for how much motion that stays so.

The faces of an element, or of one of its convex pieces, come as an array, a row per face: first and second end, outward
normal, distance from the centre, and in the last three whether either end carries and whether it is no cut.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import APART, INNER
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import face_of, rotated, seen_before
from overturning.dem.polygon.memory import forget, hand_on
from overturning.dem.polygon.state import Bounds, Nearest, Pose


class Candidate(NamedTuple):
    """A face of either element, and the face of the other one that goes with it."""

    gap: float
    """Separation of the elements by the face, m,"""
    a: int
    """both faces,"""
    b: int
    opposed: float
    """product of their normals, and by how much that of the next best is worse."""
    play: float


@njit(**INNER)
def separation(a: Pose, b: Pose, shape_a: Any, shape_b: Any, face: int) -> float:
    """Signed distance of b's nearest vertex from the line of a face of a, positive outside."""
    nx, nz = rotated(a, shape_a[face, 4], shape_a[face, 5])
    dx, dz = b.x - a.x, b.z - a.z
    least = np.inf
    for k in range(shape_b.shape[0]):
        x, z = rotated(b, shape_b[k, 0], shape_b[k, 1])
        least = min(least, nx * (x + dx) + nz * (z + dz))
    return least - shape_a[face, 6]


@njit(**INNER)
def most_opposed(a: Pose, b: Pose, shape_a: Any, shape_b: Any, face: int) -> tuple[int, float, float]:
    """The face of b most opposite to one of a, the product of their normals, and by how much the next is worse."""
    c, s = a.cos * b.cos + a.sin * b.sin, a.sin * b.cos - a.cos * b.sin
    nx, nz = c * shape_a[face, 4] + s * shape_a[face, 5], c * shape_a[face, 5] - s * shape_a[face, 4]
    best, least, second = 0, np.inf, np.inf
    for k in range(shape_b.shape[0]):
        product = nx * shape_b[k, 4] + nz * shape_b[k, 5]
        if product < least:
            best, least, second = k, product, least
        elif product < second:
            second = product
    return best, least, second - least


@njit(**INNER)
def candidate(a: Pose, b: Pose, shape_a: Any, shape_b: Any, k: int) -> Candidate:
    """What goes with the k-th face, a's first and then b's."""
    of_b = k - shape_a.shape[0]
    if of_b < 0:
        other, product, clear = most_opposed(a, b, shape_a, shape_b, k)
        return Candidate(separation(a, b, shape_a, shape_b, k), k, other, product, clear)
    other, product, clear = most_opposed(b, a, shape_b, shape_a, of_b)
    return Candidate(separation(b, a, shape_b, shape_a, of_b), other, of_b, product, clear)


@njit(**INNER)
def nearest_of(a: Pose, b: Pose, shape_a: Any, shape_b: Any, old: Nearest) -> Candidate:
    """The nearest faces: of the largest separation, then of the more opposite normals, then of the lower index."""
    best = Candidate(-np.inf, int(old.face_a), int(old.face_b), np.inf, 0.0)
    for k in range(shape_a.shape[0] + shape_b.shape[0]):
        other = candidate(a, b, shape_a, shape_b, k)
        if other.gap > best.gap or (other.gap == best.gap and other.opposed < best.opposed):
            best = other
    return best


@njit(**INNER)
def farthest(shape: Any) -> float:
    """Square of the distance of an element's farthest vertex from its centre, m²."""
    square = 0.0
    for k in range(shape.shape[0]):
        square = max(square, shape[k, 0] * shape[k, 0] + shape[k, 1] * shape[k, 1])
    return square


@njit(**INNER)
def motion_left(a: Pose, b: Pose, shape_a: Any, shape_b: Any, best: Candidate, lever: float) -> float:
    """Motion that cannot change the nearest faces, m.

    Gaps change by no more than it, products of normals by no more than rotation.
    """
    limit = 0.4 * lever * best.play
    for k in range(shape_a.shape[0] + shape_b.shape[0]):
        other = candidate(a, b, shape_a, shape_b, k)
        room = 0.4 * (best.gap - other.gap)
        agrees = other.a == best.a and other.b == best.b
        limit = min(limit, max(room, 0.4 * lever * other.play) if agrees else room)
    return limit


@njit(**INNER)
def search(q: Any, a: Any, b: Any, j: int, step: float, shape_a: Any, shape_b: Any) -> None:
    """Find the nearest faces of a pair in a column, how much motion cannot change them, and what the springs remember.

    Of all faces the one with the largest separation from the other element is nearest; with it goes the other
    element's face most nearly opposite. A pair that has no faces yet, those of a column at rest, keeps its memory.
    """
    old, first, second = rows.load_nearest(q, j), rows.load_element(a, j), rows.load_element(b, j)
    on, by = first.pose, second.pose
    best = nearest_of(on, by, shape_a, shape_b, old)
    dx, dz = on.x - by.x, on.z - by.z
    lever = np.sqrt(dx * dx + dz * dz) + np.sqrt(max(farthest(shape_a), farthest(shape_b)))
    limit = motion_left(on, by, shape_a, shape_b, best, lever)
    # Two more steps like the last one are kept clear, so that the first step in reach is still one without contact.
    moved, turned = first.course.moved + second.course.moved, first.course.turned + second.course.turned
    clear = 0.9 * best.gap - 2.0 * (moved + lever * turned)
    reach = clear if clear > 0.0 else -1.0
    ahead = 2.0 * ((first.trial.moved + second.trial.moved) + lever * (first.trial.turned + second.trial.turned))
    rows.store_nearest(q, j, Nearest(best.a, best.b, lever, max(limit, reach), reach, 0.0, ahead))
    if clear > 0.0:
        forget(q, j)
    changed = old.face_a != best.a or old.face_b != best.b
    if changed:
        rows.store_face_a(q, j, face_of(shape_a, best.a))
        rows.store_face_b(q, j, face_of(shape_b, best.b))
        rows.store_bounds(q, j, bounds_of(shape_a, best.a, shape_b, best.b))
    if changed or old.reach > 0.0 or clear > 0.0:
        rows.store_vertices(q, j, seen_before(rows.load_pair(q, j), first, second, step))
    if changed and old.face_a >= 0.0:
        hand_on(q, on, by, j, int(old.face_a), int(old.face_b), shape_a, shape_b)


@njit(**INNER)
def changes(q: Any, a: Any, b: Any, j: int, shape_a: Any, shape_b: Any) -> bool:
    """Whether a pair's nearest faces change in the step that is predicted."""
    pair, on, by = rows.load_pair(q, j), rows.load_element(a, j).trial.pose, rows.load_element(b, j).trial.pose
    old = pair.nearest
    if old.ahead < old.limit or old.ahead < old.reach:
        return False
    best = nearest_of(on, by, shape_a, shape_b, old)
    return bool(best.a != old.face_a or best.b != old.face_b)


@njit(**INNER)
def bounds_of(shape_a: Any, a: int, shape_b: Any, b: int) -> Bounds:
    """Where the vertices of two faces begin to carry: at the end of the other face, or nowhere."""
    on_a, on_b = face_of(shape_a, a), face_of(shape_b, b)
    a_to_b, b_to_a = shape_b[b, 11] > 0.0, shape_a[a, 11] > 0.0
    return Bounds(
        on_b.low if a_to_b and shape_a[a, 9] > 0.0 else np.inf,
        -on_a.high if b_to_a and shape_b[b, 10] > 0.0 else np.inf,
        on_b.high if a_to_b and shape_a[a, 10] > 0.0 else -np.inf,
        -on_a.low if b_to_a and shape_b[b, 9] > 0.0 else -np.inf,
    )


@njit(**APART)
def count_motion(q: Any, a: Any, b: Any) -> tuple[int, int]:
    """Add the last step's motion; in how many columns the pair could touch, and in how many it has to be searched.

    A step that is predicted counts twice: the contacts may change it.
    """
    near, due = 0, 0
    for j in range(rows.COLUMNS):
        old, on, by = rows.load_nearest(q, j), rows.load_element(a, j), rows.load_element(b, j)
        first, second, one, two = on.course, by.course, on.trial, by.trial
        used = (old.used + (first.moved + second.moved)) + old.lever * (first.turned + second.turned)
        ahead = used + 2.0 * ((one.moved + two.moved) + old.lever * (one.turned + two.turned))
        q[rows.USED + j] = used
        q[rows.AHEAD + j] = ahead
        near += 1 if ahead >= old.reach else 0
        due += 1 if ahead >= old.limit else 0
    return near, due


@njit(**INNER)
def in_reach(state: Any, q: Any, a: Any, b: Any, m: int, n: int, sizes: Any, shapes: Any) -> bool:
    """Whether a pair could touch in any column in this step; its nearest faces are searched where they may change.

    The pieces m and n of its elements have so many vertices, `sizes`, and faces, `shapes`.
    """
    near, due = count_motion(q, a, b)
    if due > 0:
        near = 0
        for j in range(rows.COLUMNS):
            if q[rows.AHEAD + j] >= q[rows.LIMIT + j]:
                v, dt = int(state[rows.VARIANT + j]), 2.0 * rows.load_case(state, j).lag
                shape_a, shape_b = shapes[v, m, : sizes[m]], shapes[v, n, : sizes[n]]
                search(q, a, b, j, dt, shape_a, shape_b)
                if dt == 0.0 and changes(q, a, b, j, shape_a, shape_b):
                    state[rows.CHANGED + j] = 1.0
            near += 1 if q[rows.AHEAD + j] >= q[rows.REACH + j] else 0
    return near > 0
