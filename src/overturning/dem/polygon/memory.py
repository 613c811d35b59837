"""Contact history of a pair's ends: reset, initial values at rest, and transfer to other faces after a search."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import INNER
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import carried, face_of, rotated
from overturning.dem.polygon.state import OPEN, THEIRS, TRANSFERRED, Face, Memory, Pair, Pose


@njit(**INNER)
def reset_contact_history(q: Any, j: int) -> None:
    """Reset the contact history of both ends of a pair."""
    rows.store_memory(q, j, Memory(0.0, OPEN, 0.0, 0.0, 0.0))
    rows.store_memory(q, j + rows.SECOND, Memory(0.0, OPEN, 0.0, 0.0, 0.0))


@njit(**INNER)
def transfer_contact_history(
    q: Any, a: Pose, b: Pose, j: int, old_a: int, old_b: int, shape_a: Any, shape_b: Any
) -> None:
    """Transfer the history of each loaded end from the old faces to the new end that takes its place.

    The force is resolved along normal and tangent of the new end; the next step sets the spring's stretch accordingly.
    """
    pair = rows.load_pair(q, j)
    face_a, face_b, vertices = int(pair.nearest.face_a), int(pair.nearest.face_b), pair.history.before
    reset_contact_history(q, j)
    for end in range(2):
        old = pair.history.one if end == 0 else pair.history.two
        if old.carrier == OPEN:
            continue
        mine = old.carrier != THEIRS
        if mine:
            target = nearest_end(shape_a, old_a + end, face_a, face_a + 1)
        else:
            target = nearest_end(shape_b, old_b + 1 - end, face_b + 1, face_b)
        old_x, old_z = end_normal(a, b, face_of(shape_a, old_a), face_of(shape_b, old_b), mine)
        x, z = old.normal * old_x + old.tangent * old_z, old.normal * old_z - old.tangent * old_x
        inner = vertices.a1.place <= pair.face_b.high if target == 0 else vertices.a2.place >= pair.face_b.low
        new_x, new_z = end_normal(a, b, pair.face_a, pair.face_b, inner)
        n, t = x * new_x + z * new_z, x * new_z - z * new_x
        there = rows.load_memory(q, j + target * rows.SECOND)
        if there.carrier == OPEN or there.normal < n:
            rows.store_memory(q, j + target * rows.SECOND, Memory(old.spring, TRANSFERRED, n, t, 0.0))


@njit(**INNER)
def nearest_end(shape: Any, vertex: int, one: int, two: int) -> int:
    """Return which vertex of a new face replaces a vertex, 0 for `one` or 1 for `two`: itself, else the nearer one.

    Vertex indices are taken modulo the number of vertices.
    """
    count = shape.shape[0]
    vertex, one, two = vertex % count, one % count, two % count
    if vertex == two:
        return 1
    if vertex == one:
        return 0
    x, z = shape[vertex, 0], shape[vertex, 1]
    x1, z1, x2, z2 = shape[one, 0] - x, shape[one, 1] - z, shape[two, 0] - x, shape[two, 1] - z
    return 0 if x1 * x1 + z1 * z1 <= x2 * x2 + z2 * z2 else 1


@njit(**INNER)
def end_normal(a: Pose, b: Pose, face_a: Face, face_b: Face, mine: bool) -> tuple[float, float]:
    """Return the direction of the normal force on a at an end: b's normal for a vertex of a, else minus a's normal."""
    if mine:
        return rotated(b, face_b.nx, face_b.nz)
    x, z = rotated(a, face_a.nx, face_a.nz)
    return -x, -z


@njit(**INNER)
def end_place(pair: Pair, a: Pose, b: Pose, end: int, mine: bool) -> tuple[float, float]:
    """Return the position of an end's vertex from the centre of a, m."""
    own = pair.face_a if mine else pair.face_b
    along = own.low if mine == (end == 0) else own.high
    x, z = own.off * own.nx - along * own.nz, own.off * own.nz + along * own.nx
    if mine:
        return rotated(a, x, z)
    x, z = rotated(b, x, z)
    return x - (a.x - b.x), z - (a.z - b.z)


@njit(**INNER)
def load_at_rest(q: Any, j: int) -> None:
    """Set the forces of the ends of a scene at rest from their loaded springs."""
    pair = rows.load_pair(q, j)
    for end in range(2):
        old = pair.history.one if end == 0 else pair.history.two
        if old.carrier != OPEN:
            n = max(pair.law.normal * carried(old, end, pair.history.before).depth, 0.0)
            t = -pair.law.tangential * old.spring
            rows.store_memory(q, j + end * rows.SECOND, Memory(old.spring, old.carrier, n, t, 0.0))
