"""Which points of a base that comes down flat carry: first its ends, then the others (docs/method.md).

In a plastic landing of a rigid body the impulse acts at the far end alone, since all other points lift from it. Springs
at points between would share it with the end while they still come down.
"""

from typing import Any, Final

from numba import njit

from overturning.dem.body.state import IN_THE_AIR, ROWS, VERTEX, Body, Lying, Memory, Point, Vertex
from overturning.dem.body.vectors import Matrix, apply
from overturning.dem.kernel.lanes import INLINE, INNER
from overturning.model.solid import MAX_CARRYING_CORNERS

LEVEL: Final = 1.0 - 1e-6
"""Vertices that are as deep below the centre as this share of the foot are of the base."""

RESTS: Final = 0.5
"""A point rests where the force of its dashpot is below this share of that of its spring."""


@njit(**INLINE)
def is_of_base(body: Body, vertex: Vertex) -> bool:
    """Whether a vertex is one of the base."""
    return vertex.own.z <= -LEVEL * body.foot


@njit(**INLINE)
def rests(body: Body, old: Memory) -> float:
    """1 where a point is carried by its spring rather than by its dashpot: it neither lands nor lifts."""
    spring = body.stiffness * old.depth
    return 1.0 if (old.depth > 0.0) & (abs(old.normal - spring) < RESTS * spring) else 0.0


@njit(**INLINE)
def with_vertex(body: Body, lying: Lying, f: Matrix, vertex: Vertex, old: Memory) -> Lying:
    """How the base lies, of the vertices so far and one more."""
    height, below, still = apply(f, vertex.own).z, is_of_base(body, vertex), rests(body, old)
    # Of several that are equally low or high one that rests, so that mirror images are exact.
    low = below & ((height < lying.low) | ((height == lying.low) & (still > lying.low_rests)))
    high = below & ((height > lying.high) | ((height == lying.high) & (still > lying.high_rests)))
    return Lying(
        height if low else lying.low, height if high else lying.high,
        still if low else lying.low_rests, still if high else lying.high_rests, lying.landing, lying.begun,
    )  # fmt: skip


@njit(**INLINE)
def waits(body: Body, lying: Lying, vertex: Vertex, height: float, old: Memory) -> bool:
    """Whether a vertex of the base that comes down, at a height from the centre, does not carry yet."""
    slack = body.ends * (lying.high - lying.low)
    between = (height > lying.low + slack) & (height < lying.high - slack) & is_of_base(body, vertex)
    return between & (old.depth <= 0.0) & (not lies(lying))


@njit(**INLINE)
def lands_flat(lying: Lying) -> bool:
    """Whether all points of the base land at once, so that a dashpot may pull, as of `dem.block.state.lands_flat`."""
    return lying.landing > 0.0


@njit(**INLINE)
def longer(begun: float, landing: float, depth: float) -> float:
    """The longer of two landings, the second one of a point that is so deep and counts where it is in contact."""
    return landing if (depth > 0.0) & (landing > begun) else begun


@njit(**INLINE)
def landing_of(body: Body, lying: Lying) -> float:
    """For how long a point lands that touches now: as those that have touched, or all of it from the air."""
    return body.landing if lying.begun == IN_THE_AIR else lying.begun


@njit(**INLINE)
def lies(lying: Lying) -> bool:
    """Whether both ends of a base rest on the ground."""
    return (lying.low_rests > 0.0) & (lying.high_rests > 0.0)


load_body, load_frame = ROWS.access(Body).load, ROWS.access(Matrix).load
load_lying, store_lying, _ = ROWS.access(Lying)
load_vertex, load_memory = VERTEX.access(Vertex).load, VERTEX.access(Point, "old").load
OF_A_VERTEX: Final = VERTEX.size
LANDING_OF, DEPTH_OF = VERTEX.row(Point, "old.landing"), VERTEX.row(Point, "old.depth")
LEAST, BEGUN = ROWS.row(Lying, "landing"), ROWS.row(Lying, "begun")


@njit(**INNER)
def lie_all(state: Any, vertices: Any, half: int, base: int, columns: int, round_: Any) -> None:
    """How the bases of all bodies lie; opposite vertices begin at `half`, a base has `base` of them."""
    if round_:
        # The deepest and the highest point of the rim.
        for j in range(columns):
            body, ahead = load_body(state, j), load_memory(vertices[:OF_A_VERTEX], j)
            behind = load_memory(vertices[half : half + OF_A_VERTEX], j)
            landing = ahead.landing if ahead.landing < behind.landing else behind.landing
            begun = longer(longer(IN_THE_AIR, ahead.landing, ahead.depth), behind.landing, behind.depth)
            store_lying(state, j, Lying(0.0, 0.0, rests(body, ahead), rests(body, behind), landing, begun))
        return
    few = base <= MAX_CARRYING_CORNERS
    for j in range(columns):
        first = Lying(0.0, 0.0, 1.0, 1.0, 1e300, IN_THE_AIR)
        store_lying(state, j, first if few else Lying(1e300, -1e300, 0.0, 0.0, 1e300, IN_THE_AIR))
    for point in range(0, 2 * half, OF_A_VERTEX):
        one = vertices[point : point + OF_A_VERTEX]
        for j in range(columns):
            of_base = is_of_base(load_body(state, j), load_vertex(one, j))
            left, least = one[LANDING_OF + j], state[LEAST + j]
            state[LEAST + j] = left if of_base & (left < least) else least
            begun = state[BEGUN + j]
            state[BEGUN + j] = longer(begun, left, one[DEPTH_OF + j]) if of_base else begun
    if few:
        return
    for point in range(0, 2 * half, OF_A_VERTEX):
        one = vertices[point : point + OF_A_VERTEX]
        for j in range(columns):
            lying = load_lying(state, j)
            store_lying(state, j, with_vertex(
                load_body(state, j), lying, load_frame(state, j), load_vertex(one, j), load_memory(one, j)
            ))  # fmt: skip
