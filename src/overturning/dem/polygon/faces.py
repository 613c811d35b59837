"""Where the nearest faces of a pair lie to each other: depths and places of their four vertices, and the two ends."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.polygon.advance import turned

# isort: off
from overturning.dem.polygon.columns import (
    AHI, ALO, ANX, ANZ, AOFF, BHI, BLO, BNX, BNZ, BOFF, COLUMNS, COS, DA1, DB1, INLINE, OPTIONS, REACH, SA1, SB1, SIN,
    USED, VW, VX, VZ, X, Z,
)  # fmt: skip
# isort: on

SECOND_VERTEX = 2 * COLUMNS
"""From the first vertex' depth and place to the second's."""


class Facing(NamedTuple):
    """How two faces lie to each other."""

    anx: float
    """Outward normals of both faces in the plane,"""
    anz: float
    bnx: float
    bnz: float
    turn_q: float
    """how one lies in the axes of the other,"""
    turn_r: float
    an: float
    """and from b's centre to a's along a's normal and tangent and along b's, m."""
    at: float
    bn: float
    bt: float


class Vertex(NamedTuple):
    """A vertex of one face seen from the other face."""

    place: float
    """Place along the other face (along its opposite for b's vertices), m,"""
    depth: float
    """depth behind it now and a step ago, m,"""
    before: float
    slip: float
    """slip of a over b since then, along (n_z, −n_x), m,"""
    an: float
    """levers of a normal and of a tangential force about a's centre and about b's, m."""
    at: float
    bn: float
    bt: float


class End(NamedTuple):
    """One end of the faces' common stretch."""

    mine: bool
    """Whether a's vertex carries it, else b's,"""
    closed: bool
    """whether it touches,"""
    nx: float
    """direction of the normal force on a; the rest as of the vertex."""
    nz: float
    depth: float
    before: float
    slip: float
    an: float
    at: float
    bn: float
    bt: float


@njit(**INLINE)
def facing(q: Any, j: int, ca: float, sa: float, cb: float, sb: float, dx: float, dz: float) -> Facing:
    """How the faces of a pair lie to each other, from the cosines and sines of both and the way from b's centre to a's."""
    anx, anz = ca * q[ANX + j] + sa * q[ANZ + j], ca * q[ANZ + j] - sa * q[ANX + j]
    bnx, bnz = cb * q[BNX + j] + sb * q[BNZ + j], cb * q[BNZ + j] - sb * q[BNX + j]
    turn_q, turn_r = bnx * anx + bnz * anz, bnz * anx - bnx * anz
    an, at = anx * dx + anz * dz, anx * dz - anz * dx
    return Facing(anx, anz, bnx, bnz, turn_q, turn_r, an, at, bnx * dx + bnz * dz, bnx * dz - bnz * dx)


@njit(**INLINE)
def seen(off: float, along: float, q: float, r: float) -> tuple[float, float]:
    """Place of a face's point along the other face's normal and tangent, from its own centre; q, r turn it there."""
    return off * q + along * r, along * q - off * r


@njit(**INLINE)
def vertex_of_a(q: Any, at: int, off: float, along: float, wall: float, f: Facing) -> Vertex:
    """A vertex of a behind b's face, which lies `wall` from b's centre."""
    own_n, own_t = seen(off, along, f.turn_q, f.turn_r)
    height, place = own_n + f.bn, own_t + f.bt
    return Vertex(place, wall - height, q[DA1 + at], q[SA1 + at] - place, own_t, own_n, place, height)


@njit(**INLINE)
def vertex_of_b(q: Any, at: int, off: float, along: float, wall: float, f: Facing) -> Vertex:
    """A vertex of b behind a's face; its place along the opposite of that face grows with a's slip."""
    own_n, own_t = seen(off, along, -f.turn_q, f.turn_r)
    height, place = own_n + f.an, own_t + f.at
    return Vertex(place, wall + height, q[DB1 + at], place - q[SB1 + at], place, height, own_t, own_n)


@njit(**INLINE)
def end_of(mine: bool, closed: bool, f: Facing, a: Vertex, b: Vertex) -> End:
    """The end that a's or b's vertex carries."""
    return End(
        mine,
        closed & ((a.depth if mine else b.depth) > 0.0),
        f.bnx if mine else -f.anx,
        f.bnz if mine else -f.anz,
        a.depth if mine else b.depth,
        a.before if mine else b.before,
        a.slip if mine else b.slip,
        a.an if mine else b.an,
        a.at if mine else b.at,
        a.bn if mine else b.bn,
        a.bt if mine else b.bt,
    )


@njit(**INLINE)
def ends(q: Any, a: Any, b: Any, j: int) -> tuple[float, float, End, End]:
    """Both ends of a pair's common stretch now, which is noted for the next step, and how one face is turned to the other.

    The inner one of a's first and b's second vertex carries end 1, of a's second and b's first end 2.
    """
    f = facing(q, j, a[COS + j], a[SIN + j], b[COS + j], b[SIN + j], a[X + j] - b[X + j], a[Z + j] - b[Z + j])
    a_off, a_lo, a_hi = q[AOFF + j], q[ALO + j], q[AHI + j]
    b_off, b_lo, b_hi = q[BOFF + j], q[BLO + j], q[BHI + j]
    a1, a2 = vertex_of_a(q, j, a_off, a_lo, b_off, f), vertex_of_a(q, j + SECOND_VERTEX, a_off, a_hi, b_off, f)
    b1, b2 = vertex_of_b(q, j, b_off, b_lo, a_off, f), vertex_of_b(q, j + SECOND_VERTEX, b_off, b_hi, a_off, f)
    near = q[USED + j] >= q[REACH + j]
    mine_1, mine_2 = a1.place <= b_hi, a2.place >= b_lo
    a_low, a_high = -a_lo, -a_hi
    in_1 = (mine_1 & (a1.place >= b_lo)) | ((not mine_1) & (b2.place >= a_high) & (b2.place <= a_low))
    in_2 = (mine_2 & (a2.place <= b_hi)) | ((not mine_2) & (b1.place >= a_high) & (b1.place <= a_low))
    one, two = end_of(mine_1, in_1 & near, f, a1, b2), end_of(mine_2, in_2 & near, f, a2, b1)
    note_vertex(q, DA1 + j, a1)
    note_vertex(q, DA1 + SECOND_VERTEX + j, a2)
    note_vertex(q, DB1 + j, b1)
    note_vertex(q, DB1 + SECOND_VERTEX + j, b2)
    return f.turn_q, f.turn_r, one, two


@njit(**INLINE)
def note_vertex(q: Any, at: int, vertex: Vertex) -> None:
    """Keep a vertex' depth and place for the next step."""
    q[at], q[at + COLUMNS] = vertex.depth, vertex.place


@njit(**OPTIONS)
def depths_before(q: Any, a: Any, b: Any, j: int, dt: float) -> None:
    """Depths and places of the faces' vertices a time dt ago, 0 for now."""
    pose = np.empty((2, 4))
    for k in range(2):
        e = a if k == 0 else b
        pose[k, 0], pose[k, 1] = turned(e[COS + j], e[SIN + j], -dt * e[VW + j])
        pose[k, 2], pose[k, 3] = e[X + j] - dt * e[VX + j], e[Z + j] - dt * e[VZ + j]
    f = facing(q, j, pose[0, 0], pose[0, 1], pose[1, 0], pose[1, 1], pose[0, 2] - pose[1, 2], pose[0, 3] - pose[1, 3])
    for k in range(2):
        at = j + k * SECOND_VERTEX
        note_vertex(q, DA1 + at, vertex_of_a(q, at, q[AOFF + j], q[(ALO if k == 0 else AHI) + j], q[BOFF + j], f))
        note_vertex(q, DB1 + at, vertex_of_b(q, at, q[BOFF + j], q[(BLO if k == 0 else BHI) + j], q[AOFF + j], f))


@njit(**OPTIONS)
def depth_row(mine: bool, end: int) -> int:
    """Row of the depth of the vertex that carries an end: of a's first and second, of b's second and first."""
    if mine:
        return DA1 if end == 0 else DA1 + SECOND_VERTEX
    return DB1 + SECOND_VERTEX if end == 0 else DB1
