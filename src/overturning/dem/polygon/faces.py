"""Relative position of the nearest faces of a pair: depths and places of their four vertices, and both contact ends."""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE, INNER
from overturning.dem.kernel.mechanics import rotate_pair
from overturning.dem.polygon.state import THEIRS, ElementState, Face, Memory, Pair, Pose, Seen, Vertices


class Levers(NamedTuple):
    """Lever arms of the normal and of the tangential force about a centre, m."""

    n: float
    t: float


class End(NamedTuple):
    """One end of the common stretch of two faces."""

    mine: bool
    """True if the contact vertex of this end belongs to a, False if to b."""
    faces: bool
    """True if the vertex lies opposite the other face."""
    closed: bool
    """True if the vertex also penetrates that face: a contact."""
    nx: float
    """Direction of the normal force on a, x component."""
    nz: float
    """Direction of the normal force on a, z component."""
    depth: float
    """Penetration of the vertex, m; negative while there is a gap."""
    before: float
    """Penetration a step ago, m."""
    slip: float
    """Slip of a over b since then, along (n_z, −n_x), m."""
    a: Levers
    """Lever arms about the centre of a."""
    b: Levers
    """Lever arms about the centre of b."""


class Stretch(NamedTuple):
    """Common stretch of two faces: their relative rotation, both ends, and all four vertices.

    `turn_q` and `turn_r` are the cosine and sine of the rotation between both faces, as in `RelativePosition`.
    """

    turn_q: float
    turn_r: float
    one: End
    two: End
    now: Vertices


class RelativePosition(NamedTuple):
    """Relative position of two faces."""

    anx: float
    """Outward normal of a's face in the axes of the scene, x component."""
    anz: float
    """Outward normal of a's face, z component."""
    bnx: float
    """Outward normal of b's face, x component."""
    bnz: float
    """Outward normal of b's face, z component."""
    turn_q: float
    """Cosine of the rotation from one normal to the other."""
    turn_r: float
    """Sine of that rotation, b_nz a_nx − b_nx a_nz."""
    an: float
    """Distance from the centre of b to that of a along a's normal, m."""
    at: float
    """Distance from the centre of b to that of a along a's tangent, m."""
    bn: float
    """Distance from the centre of b to that of a along b's normal, m."""
    bt: float
    """Distance from the centre of b to that of a along b's tangent, m."""


class FaceVertex(NamedTuple):
    """Vertex of one face in the axes of the other face."""

    seen: Seen
    """Depth behind the other face and place along it, m; b's vertices are measured in the opposite direction."""
    before: float
    """Depth a step ago, m."""
    slip: float
    """Slip of a over b since then, along (n_z, −n_x), m."""
    a: Levers
    """Lever arms about the centre of a."""
    b: Levers
    """Lever arms about the centre of b."""


@njit(**INLINE)
def rotated(pose: Pose, x: float, z: float) -> tuple[float, float]:
    """Rotate a vector from the axes of an element to those of the scene."""
    return pose.cos * x + pose.sin * z, pose.cos * z - pose.sin * x


@njit(**INNER)
def face_of(shape: Any, face: int) -> Face:
    """Return a face of a shape by its index."""
    nx, nz = shape[face, 4], shape[face, 5]
    low, high = nx * shape[face, 1] - nz * shape[face, 0], nx * shape[face, 3] - nz * shape[face, 2]
    return Face(nx, nz, shape[face, 6], low, high)


@njit(**INLINE)
def relative_position(face_a: Face, face_b: Face, a: Pose, b: Pose) -> RelativePosition:
    """Compute the relative position of the faces of a pair."""
    dx, dz = a.x - b.x, a.z - b.z
    anx, anz = rotated(a, face_a.nx, face_a.nz)
    bnx, bnz = rotated(b, face_b.nx, face_b.nz)
    turn_q, turn_r = bnx * anx + bnz * anz, bnz * anx - bnx * anz
    an, at = anx * dx + anz * dz, anx * dz - anz * dx
    return RelativePosition(
        anx=anx,
        anz=anz,
        bnx=bnx,
        bnz=bnz,
        turn_q=turn_q,
        turn_r=turn_r,
        an=an,
        at=at,
        bn=bnx * dx + bnz * dz,
        bt=bnx * dz - bnz * dx,
    )


@njit(**INLINE)
def rotate_to_other_face(off: float, along: float, q: float, r: float) -> tuple[float, float]:
    """Rotate a point of a face, relative to its own centre, to the normal and tangent of the other face.

    `q` and `r` are the cosine and sine of that rotation.
    """
    return off * q + along * r, along * q - off * r


@njit(**INLINE)
def vertex_of_a(off: float, along: float, wall: float, f: RelativePosition, before: Seen) -> FaceVertex:
    """Describe a vertex of a relative to the face of b, which lies `wall` (m) from the centre of b."""
    own_n, own_t = rotate_to_other_face(off, along, f.turn_q, f.turn_r)
    height, place = own_n + f.bn, own_t + f.bt
    seen = Seen(wall - height, place)
    return FaceVertex(seen, before.depth, before.place - place, Levers(own_t, own_n), Levers(place, height))


@njit(**INLINE)
def vertex_of_b(off: float, along: float, wall: float, f: RelativePosition, before: Seen) -> FaceVertex:
    """Describe a vertex of b relative to the face of a; its place increases with the slip of a."""
    own_n, own_t = rotate_to_other_face(off, along, -f.turn_q, f.turn_r)
    height, place = own_n + f.an, own_t + f.at
    seen = Seen(wall + height, place)
    return FaceVertex(seen, before.depth, place - before.place, Levers(place, height), Levers(own_t, own_n))


@njit(**INLINE)
def vertices(
    a: Face, b: Face, f: RelativePosition, before: Vertices
) -> tuple[FaceVertex, FaceVertex, FaceVertex, FaceVertex]:
    """Describe the first and second vertex of a's face, then those of b's."""
    return (
        vertex_of_a(a.off, a.low, b.off, f, before.a1),
        vertex_of_a(a.off, a.high, b.off, f, before.a2),
        vertex_of_b(b.off, b.low, a.off, f, before.b1),
        vertex_of_b(b.off, b.high, a.off, f, before.b2),
    )


@njit(**INLINE)
def end_of(mine: bool, faces: bool, f: RelativePosition, a: FaceVertex, b: FaceVertex) -> End:
    """Return an end: with a's vertex if `mine`, else with b's."""
    depth = a.seen.depth if mine else b.seen.depth
    return End(
        mine=mine,
        faces=faces,
        closed=faces & (depth > 0.0),
        nx=f.bnx if mine else -f.anx,
        nz=f.bnz if mine else -f.anz,
        depth=depth,
        before=a.before if mine else b.before,
        slip=a.slip if mine else b.slip,
        a=Levers(a.a.n if mine else b.a.n, a.a.t if mine else b.a.t),
        b=Levers(a.b.n if mine else b.b.n, a.b.t if mine else b.b.t),
    )


@njit(**INLINE)
def common_stretch(pair: Pair, a: Pose, b: Pose) -> Stretch:
    """Compute the common stretch of a pair; neither end touches if the elements are out of reach."""
    return stretch_of(pair, a, b, pair.nearest.ahead >= pair.nearest.reach)


@njit(**INLINE)
def stretch_of(pair: Pair, a: Pose, b: Pose, near: bool) -> Stretch:
    """Compute the common stretch of a pair; the contact vertex of each end is the inner of two vertices.

    End 1 lies at a's first or b's second vertex, end 2 at a's second or b's first.
    """
    f = relative_position(pair.face_a, pair.face_b, a, b)
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
def seen_before(pair: Pair, a: ElementState, b: ElementState, dt: float) -> Vertices:
    """Compute depths and places of the vertices of both faces a time `dt` (s) ago."""
    f = relative_position(pair.face_a, pair.face_b, pose_before(a, dt), pose_before(b, dt))
    a1, a2, b1, b2 = vertices(pair.face_a, pair.face_b, f, pair.history.before)
    return Vertices(a1.seen, a2.seen, b1.seen, b2.seen)


@njit(**INNER)
def pose_before(e: ElementState, dt: float) -> Pose:
    """Return the pose of an element a time `dt` (s) ago."""
    c, s = rotate_pair(e.pose.cos, e.pose.sin, -dt * e.velocity.w)
    return Pose(e.pose.x - dt * e.velocity.x, e.pose.z - dt * e.velocity.z, e.pose.angle, c, s)


@njit(**INNER)
def carried(memory: Memory, end: int, of: Vertices) -> Seen:
    """Return the contact vertex of an end (0 or 1): a's first or second, or b's second or first."""
    if memory.carrier != THEIRS:
        return of.a1 if end == 0 else of.a2
    return of.b2 if end == 0 else of.b1
