"""Where the nearest faces of a pair lie to each other: depths and places of their four vertices, and the two ends."""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE, INNER
from overturning.dem.kernel.mechanics import turned
from overturning.dem.polygon.state import THEIRS, Element, Face, Memory, Pair, Pose, Seen, Vertices


class Levers(NamedTuple):
    """Levers of a normal and of a tangential force about a centre, m."""

    n: float
    t: float


class End(NamedTuple):
    """One end of the faces' common stretch."""

    mine: bool
    """Whether a's vertex carries it, else b's,"""
    faces: bool
    """whether it lies on the other face,"""
    closed: bool
    """and whether it touches,"""
    nx: float
    """direction of the normal force on a,"""
    nz: float
    depth: float
    """the rest as of the vertex."""
    before: float
    slip: float
    a: Levers
    b: Levers


class Stretch(NamedTuple):
    """The common stretch of two faces: how one is turned to the other, both ends, and all vertices."""

    turn_q: float
    turn_r: float
    one: End
    two: End
    now: Vertices


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

    seen: Seen
    """Depth behind the other face and place along it (along its opposite for b's vertices), m,"""
    before: float
    """depth a step ago, m,"""
    slip: float
    """slip of a over b since then, along (n_z, −n_x), m,"""
    a: Levers
    """levers about a's centre and about b's."""
    b: Levers


@njit(**INLINE)
def rotated(pose: Pose, x: float, z: float) -> tuple[float, float]:
    """A vector of an element's axes in the plane."""
    return pose.cos * x + pose.sin * z, pose.cos * z - pose.sin * x


@njit(**INNER)
def face_of(shape: Any, face: int) -> Face:
    """A face by its number."""
    nx, nz = shape[face, 4], shape[face, 5]
    low, high = nx * shape[face, 1] - nz * shape[face, 0], nx * shape[face, 3] - nz * shape[face, 2]
    return Face(nx, nz, shape[face, 6], low, high)


@njit(**INLINE)
def facing(face_a: Face, face_b: Face, a: Pose, b: Pose) -> Facing:
    """How the faces of a pair lie to each other."""
    dx, dz = a.x - b.x, a.z - b.z
    anx, anz = rotated(a, face_a.nx, face_a.nz)
    bnx, bnz = rotated(b, face_b.nx, face_b.nz)
    turn_q, turn_r = bnx * anx + bnz * anz, bnz * anx - bnx * anz
    an, at = anx * dx + anz * dz, anx * dz - anz * dx
    return Facing(anx, anz, bnx, bnz, turn_q, turn_r, an, at, bnx * dx + bnz * dz, bnx * dz - bnz * dx)


@njit(**INLINE)
def seen_from(off: float, along: float, q: float, r: float) -> tuple[float, float]:
    """Place of a face's point along the other face's normal and tangent, from its own centre; q, r turn it there."""
    return off * q + along * r, along * q - off * r


@njit(**INLINE)
def vertex_of_a(off: float, along: float, wall: float, f: Facing, before: Seen) -> Vertex:
    """A vertex of a behind b's face, which lies `wall` from b's centre."""
    own_n, own_t = seen_from(off, along, f.turn_q, f.turn_r)
    height, place = own_n + f.bn, own_t + f.bt
    seen = Seen(wall - height, place)
    return Vertex(seen, before.depth, before.place - place, Levers(own_t, own_n), Levers(place, height))


@njit(**INLINE)
def vertex_of_b(off: float, along: float, wall: float, f: Facing, before: Seen) -> Vertex:
    """A vertex of b behind a's face; its place along the opposite of that face grows with a's slip."""
    own_n, own_t = seen_from(off, along, -f.turn_q, f.turn_r)
    height, place = own_n + f.an, own_t + f.at
    seen = Seen(wall + height, place)
    return Vertex(seen, before.depth, place - before.place, Levers(place, height), Levers(own_t, own_n))


@njit(**INLINE)
def vertices(a: Face, b: Face, f: Facing, before: Vertices) -> tuple[Vertex, Vertex, Vertex, Vertex]:
    """First and second vertex of a's face, then of b's."""
    return (
        vertex_of_a(a.off, a.low, b.off, f, before.a1),
        vertex_of_a(a.off, a.high, b.off, f, before.a2),
        vertex_of_b(b.off, b.low, a.off, f, before.b1),
        vertex_of_b(b.off, b.high, a.off, f, before.b2),
    )


@njit(**INLINE)
def end_of(mine: bool, faces: bool, f: Facing, a: Vertex, b: Vertex) -> End:
    """The end that a's or b's vertex carries."""
    depth = a.seen.depth if mine else b.seen.depth
    return End(
        mine,
        faces,
        faces & (depth > 0.0),
        f.bnx if mine else -f.anx,
        f.bnz if mine else -f.anz,
        depth,
        a.before if mine else b.before,
        a.slip if mine else b.slip,
        Levers(a.a.n if mine else b.a.n, a.a.t if mine else b.a.t),
        Levers(a.b.n if mine else b.b.n, a.b.t if mine else b.b.t),
    )


@njit(**INLINE)
def common_stretch(pair: Pair, a: Pose, b: Pose) -> Stretch:
    """Both ends of a pair's common stretch, of which none touches where the elements are out of reach."""
    return stretch_of(pair, a, b, pair.nearest.ahead >= pair.nearest.reach)


@njit(**INLINE)
def stretch_of(pair: Pair, a: Pose, b: Pose, near: bool) -> Stretch:
    """Both ends of a pair's common stretch; the inner vertex carries each.

    Of a's first and b's second vertex end 1, of the others end 2.
    """
    f = facing(pair.face_a, pair.face_b, a, b)
    a1, a2, b1, b2 = vertices(pair.face_a, pair.face_b, f, pair.history.before)
    low, high, to = pair.face_b.low, pair.face_b.high, pair.bounds
    mine_1, mine_2 = a1.seen.place <= high, a2.seen.place >= low
    top, bottom = -pair.face_a.low, -pair.face_a.high
    in_1 = (mine_1 & (a1.seen.place >= to.one_a)) | (
        (not mine_1) & (b2.seen.place >= to.one_b) & (b2.seen.place <= top)
    )
    in_2 = (mine_2 & (a2.seen.place <= to.two_a)) | (
        (not mine_2) & (b1.seen.place >= bottom) & (b1.seen.place <= to.two_b)
    )
    one, two = end_of(mine_1, in_1 & near, f, a1, b2), end_of(mine_2, in_2 & near, f, a2, b1)
    return Stretch(f.turn_q, f.turn_r, one, two, Vertices(a1.seen, a2.seen, b1.seen, b2.seen))


@njit(**INNER)
def seen_before(pair: Pair, a: Element, b: Element, dt: float) -> Vertices:
    """Depths and places of the faces' vertices a time dt ago, 0 for now."""
    f = facing(pair.face_a, pair.face_b, pose_before(a, dt), pose_before(b, dt))
    a1, a2, b1, b2 = vertices(pair.face_a, pair.face_b, f, pair.history.before)
    return Vertices(a1.seen, a2.seen, b1.seen, b2.seen)


@njit(**INNER)
def pose_before(e: Element, dt: float) -> Pose:
    """Pose of an element a time dt ago."""
    c, s = turned(e.pose.cos, e.pose.sin, -dt * e.velocity.w)
    return Pose(e.pose.x - dt * e.velocity.x, e.pose.z - dt * e.velocity.z, e.pose.angle, c, s)


@njit(**INNER)
def carried(memory: Memory, end: int, of: Vertices) -> Seen:
    """The vertex that carries an end, 0 or 1: of a's first and second, of b's second and first."""
    if memory.carrier != THEIRS:
        return of.a1 if end == 0 else of.a2
    return of.b2 if end == 0 else of.b1
