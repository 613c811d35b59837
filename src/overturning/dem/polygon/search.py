"""Search of the nearest faces of a pair: the two faces that can touch, and the motion for which this remains valid.

The faces of an element, or of one of its convex pieces, are an array with a row per face: first and second end, outward
normal, distance from the centre; columns 9 and 10 are 1 if the first and second end can be a contact vertex, column 11
is 1 unless the face is a cut between two pieces.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import APART, INNER
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import earlier_vertex_positions, polygon_face, rotate_to_scene_axes
from overturning.dem.polygon.memory import reset_contact_history, transfer_contact_history
from overturning.dem.polygon.state import CarryingBounds, NearestFaces, Pose


class FacePair(NamedTuple):
    """Face of one element, and the face of the other element most nearly opposite to it."""

    gap: float
    """Distance between the elements along the normal of the face, m."""
    a: int
    """Index of the face of a."""
    b: int
    """Index of the face of b."""
    opposed: float
    """Scalar product of both normals; −1 if they are opposite."""
    play: float
    """Difference of that product to the one of the next best face."""


@njit(**INNER)
def separation(a: Pose, b: Pose, shape_a: Any, shape_b: Any, face: int) -> float:
    """Return the signed distance of the nearest vertex of b from the line of a face of a, m, positive outside."""
    nx, nz = rotate_to_scene_axes(a, shape_a[face, 4], shape_a[face, 5])
    dx, dz = b.x - a.x, b.z - a.z
    least = np.inf
    for k in range(shape_b.shape[0]):
        x, z = rotate_to_scene_axes(b, shape_b[k, 0], shape_b[k, 1])
        least = min(least, nx * (x + dx) + nz * (z + dz))
    return least - shape_a[face, 6]


@njit(**INNER)
def most_opposed(a: Pose, b: Pose, shape_a: Any, shape_b: Any, face: int) -> tuple[int, float, float]:
    """Return the face of b most opposite to one of a, the product of their normals, and the margin to the next face."""
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
def face_pair(a: Pose, b: Pose, shape_a: Any, shape_b: Any, k: int) -> FacePair:
    """Return the face pair of the k-th face, counting the faces of a and then those of b."""
    of_b = k - shape_a.shape[0]
    if of_b < 0:
        other, product, clear = most_opposed(a, b, shape_a, shape_b, k)
        return FacePair(separation(a, b, shape_a, shape_b, k), k, other, product, clear)
    other, product, clear = most_opposed(b, a, shape_b, shape_a, of_b)
    return FacePair(separation(b, a, shape_b, shape_a, of_b), other, of_b, product, clear)


@njit(**INNER)
def nearest_faces(a: Pose, b: Pose, shape_a: Any, shape_b: Any, old: NearestFaces) -> FacePair:
    """Return the nearest faces: largest separation first, then the more opposite normals, then the lower index."""
    best = FacePair(-np.inf, int(old.face_a), int(old.face_b), np.inf, 0.0)
    for k in range(shape_a.shape[0] + shape_b.shape[0]):
        other = face_pair(a, b, shape_a, shape_b, k)
        if other.gap > best.gap or (other.gap == best.gap and other.opposed < best.opposed):
            best = other
    return best


@njit(**INNER)
def squared_radius(shape: Any) -> float:
    """Return the squared distance of the farthest vertex from the centre, m²."""
    square = 0.0
    for k in range(shape.shape[0]):
        square = max(square, shape[k, 0] * shape[k, 0] + shape[k, 1] * shape[k, 1])
    return square


@njit(**INNER)
def safe_motion(a: Pose, b: Pose, shape_a: Any, shape_b: Any, best: FacePair, lever: float) -> float:
    """Return a motion that cannot change the nearest faces, m.

    A gap changes by at most the motion, a product of normals by at most the rotation.
    """
    limit = 0.4 * lever * best.play
    for k in range(shape_a.shape[0] + shape_b.shape[0]):
        other = face_pair(a, b, shape_a, shape_b, k)
        room = 0.4 * (best.gap - other.gap)
        agrees = other.a == best.a and other.b == best.b
        limit = min(limit, max(room, 0.4 * lever * other.play) if agrees else room)
    return limit


@njit(**INNER)
def search(q: Any, a: Any, b: Any, j: int, step: float, shape_a: Any, shape_b: Any) -> None:
    """Update the nearest faces of a pair in case j, the motion for which they remain valid, and the contact history.

    The face with the largest separation from the other element is nearest; its partner is the most nearly opposite
    face of the other element. A pair that has no faces yet (a case at rest) keeps its contact history.
    """
    old, first, second = rows.load_nearest(q, j), rows.load_element(a, j), rows.load_element(b, j)
    on, by = first.pose, second.pose
    best = nearest_faces(on, by, shape_a, shape_b, old)
    dx, dz = on.x - by.x, on.z - by.z
    lever = np.sqrt(dx * dx + dz * dz) + np.sqrt(max(squared_radius(shape_a), squared_radius(shape_b)))
    limit = safe_motion(on, by, shape_a, shape_b, best, lever)
    # Leave a margin of two steps like the last one, so that the first step within reach is still without contact.
    moved, turned = first.totals.moved + second.totals.moved, first.totals.turned + second.totals.turned
    clear = 0.9 * best.gap - 2.0 * (moved + lever * turned)
    reach = clear if clear > 0.0 else -1.0
    ahead = 2.0 * ((first.trial.moved + second.trial.moved) + lever * (first.trial.turned + second.trial.turned))
    rows.store_nearest(q, j, NearestFaces(best.a, best.b, lever, max(limit, reach), reach, 0.0, ahead))
    if clear > 0.0:
        reset_contact_history(q, j)
    changed = old.face_a != best.a or old.face_b != best.b
    if changed:
        rows.store_face_a(q, j, polygon_face(shape_a, best.a))
        rows.store_face_b(q, j, polygon_face(shape_b, best.b))
        rows.store_bounds(q, j, bounds_of(shape_a, best.a, shape_b, best.b))
    if changed or old.reach > 0.0 or clear > 0.0:
        rows.store_vertices(q, j, earlier_vertex_positions(rows.load_pair(q, j), first, second, step))
    if changed and old.face_a >= 0.0:
        transfer_contact_history(q, on, by, j, int(old.face_a), int(old.face_b), shape_a, shape_b)


@njit(**INNER)
def nearest_faces_change(q: Any, a: Any, b: Any, j: int, shape_a: Any, shape_b: Any) -> bool:
    """True if the nearest faces of a pair change in the predicted step."""
    pair, on, by = rows.load_pair(q, j), rows.load_element(a, j).trial.pose, rows.load_element(b, j).trial.pose
    old = pair.nearest
    if old.ahead < old.limit or old.ahead < old.reach:
        return False
    best = nearest_faces(on, by, shape_a, shape_b, old)
    return bool(best.a != old.face_a or best.b != old.face_b)


@njit(**INNER)
def bounds_of(shape_a: Any, a: int, shape_b: Any, b: int) -> CarryingBounds:
    """Return the places on the other face from which the vertices of two faces carry an end; ±infinity for never."""
    on_a, on_b = polygon_face(shape_a, a), polygon_face(shape_b, b)
    a_to_b, b_to_a = shape_b[b, 11] > 0.0, shape_a[a, 11] > 0.0
    return CarryingBounds(
        on_b.low if a_to_b and shape_a[a, 9] > 0.0 else np.inf,
        -on_a.high if b_to_a and shape_b[b, 10] > 0.0 else np.inf,
        on_b.high if a_to_b and shape_a[a, 10] > 0.0 else -np.inf,
        -on_a.low if b_to_a and shape_b[b, 9] > 0.0 else -np.inf,
    )


@njit(**APART)
def count_motion(q: Any, a: Any, b: Any) -> tuple[int, int]:
    """Add the motion of the last step; count the cases in which the pair could touch, and those that need a search.

    The motion of the predicted step counts twice, because the contacts may change it.
    """
    near, due = 0, 0
    for j in range(rows.COLUMNS):
        old, on, by = rows.load_nearest(q, j), rows.load_element(a, j), rows.load_element(b, j)
        first, second, one, two = on.totals, by.totals, on.trial, by.trial
        used = (old.used + (first.moved + second.moved)) + old.lever * (first.turned + second.turned)
        ahead = used + 2.0 * ((one.moved + two.moved) + old.lever * (one.turned + two.turned))
        q[rows.USED + j] = used
        q[rows.AHEAD + j] = ahead
        near += 1 if ahead >= old.reach else 0
        due += 1 if ahead >= old.limit else 0
    return near, due


@njit(**INNER)
def in_reach(state: Any, q: Any, a: Any, b: Any, m: int, n: int, sizes: Any, shapes: Any) -> bool:
    """Search the nearest faces where they may change; return True if the pair could touch in any case in this step.

    m and n are the indices of its convex pieces in `sizes` (numbers of vertices) and `shapes` (faces).
    """
    near, due = count_motion(q, a, b)
    if due > 0:
        near = 0
        for j in range(rows.COLUMNS):
            if q[rows.AHEAD + j] >= q[rows.LIMIT + j]:
                v, dt = int(state[rows.VARIANT + j]), 2.0 * rows.load_case(state, j).lag
                shape_a, shape_b = shapes[v, m, : sizes[m]], shapes[v, n, : sizes[n]]
                search(q, a, b, j, dt, shape_a, shape_b)
                if dt == 0.0 and nearest_faces_change(q, a, b, j, shape_a, shape_b):
                    state[rows.CHANGED + j] = 1.0
            near += 1 if q[rows.AHEAD + j] >= q[rows.REACH + j] else 0
    return near > 0
