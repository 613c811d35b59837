"""How the general kernel keeps its cases: named tuples of one case, in rows of an array with a column per case.

The array has the rows of the column itself (`Case`), then a block of rows for each element (`Element`) and for each pair
(`Pair`). A function that computes one case takes and gives such tuples; `load_element(rows, j)`, `store_pose(rows, j, pose)`
and the like fetch and keep those of column j. The innermost loops run over columns without branches and LLVM makes vector code
of them; they know only ``+ - * /`` and comparisons, so that a column's bits depend neither on its neighbours, nor on the
thread, nor on the width of the processor's vectors.
"""

from collections.abc import Iterable
from typing import Any, Final, NamedTuple

from numba import njit
from numba.extending import intrinsic

from overturning.dem.lanes import OPTIONS, Rows

COLUMNS: Final = 16
"""Cases side by side: enough to hide the latency of one case's operations, few enough for the first cache."""

# What an end's `Memory.carrier` says: open, closed by a's vertex or by b's, or found anew by a search.
OPEN: Final = 0.0
MINE: Final = 1.0
THEIRS: Final = -1.0
HANDED_ON: Final = 2.0


class Shaking(NamedTuple):
    """Acceleration of the base, linear between two samples, and time."""

    base: float
    """Towards the azimuth: at the sample (m/s²) and per step,"""
    slope: float
    up_base: float
    """upwards,"""
    up_slope: float
    tick: float
    """steps since the sample."""


class Case(NamedTuple):
    """What a column holds of its case besides elements and pairs."""

    shaking: Shaking
    step: float
    """Time step (s), and steps per second,"""
    rate: float
    amplitude: float
    """factor on the record,"""
    sample: float
    """sample of the record,"""
    calm: float
    """samples after which it can be at rest for good, and after which it is undecided,"""
    after: float
    energy: float
    """energy at the start, J."""


class Pose(NamedTuple):
    """Centre (m), rotation (rad) and its cosine and sine."""

    x: float
    z: float
    angle: float
    cos: float
    sin: float


class Plane(NamedTuple):
    """Velocity or acceleration (m, s, rad), or force (N) with moment (N m), in the plane."""

    x: float
    z: float
    w: float


class Body(NamedTuple):
    """Constants of an element; inverse masses are 0 where forces do not move it."""

    inverse_mass: float
    inverse_inertia: float
    mass: float
    weight: float
    """1 where gravity acts, else 0,"""
    frame: float
    """1 where the base moves under it, 0 where it moves with the base,"""
    held: float
    """1 where it stays in space, else 0,"""
    critical: float
    """α, rad."""


class Course(NamedTuple):
    """What is noted of an element's motion at each step."""

    moved: float
    """Motion (m) and rotation (rad) of the last step,"""
    turned: float
    work: float
    """work of what moves the base and of what holds the element, J,"""
    peak_angle: float
    last_upright: float
    """steps of this sample up to the last at which |rotation| was below α, −1 if none."""


class Standing(NamedTuple):
    """What is looked at once per sample."""

    upright_until: float
    """Last time with |rotation| < α, s,"""
    side: float
    """where it has fallen: ±1, else 0,"""
    peak_slip: float
    slip: float
    safe_from: float
    """sample from which on the shaking is too weak to throw it down from rest,"""
    base_x: float
    """points of its base and of what it stands on, whose distance is the slip, m."""
    base_z: float
    support_x: float
    support_z: float


class Element(NamedTuple):
    """An element; velocity half a step ago, force at the whole step."""

    pose: Pose
    velocity: Plane
    now: Plane
    """Velocity at the whole step with the forces known so far."""
    acceleration: Plane
    force: Plane
    body: Body
    course: Course
    standing: Standing


class Face(NamedTuple):
    """A face in its element's axes: outward normal, distance from the centre, ends along the tangent (−n_z, n_x)."""

    nx: float
    nz: float
    off: float
    low: float
    high: float


class Law(NamedTuple):
    """Contact law at a vertex: stiffnesses (N/m), dashpot (N s/m), friction, 1/tangential stiffness."""

    normal: float
    tangential: float
    dashpot: float
    friction: float
    compliance: float


class Nearest(NamedTuple):
    """Which faces are nearest, and for how much motion that holds, m."""

    face_a: float
    face_b: float
    lever: float
    """Reach of a rotation,"""
    limit: float
    """motion before the faces can change, and before a contact can begin (−1: there may be one now),"""
    reach: float
    used: float
    """motion since the search."""


class Seen(NamedTuple):
    """Depth behind the other face of a face's end, and place along it (of b's along its opposite), m."""

    depth: float
    place: float


class Vertices(NamedTuple):
    """Both ends of a's face and of b's."""

    a1: Seen
    a2: Seen
    b1: Seen
    b2: Seen


class Memory(NamedTuple):
    """What an end remembers: stretch of its tangential spring, carrier, forces along normal and tangent."""

    spring: float
    carrier: float
    normal: float
    tangent: float


class Action(NamedTuple):
    """What both ends do: force on a (N), the opposite on b; moments about the centres of a and, reversed, of b, N m."""

    x: float
    z: float
    moment_a: float
    moment_b: float


class Pair(NamedTuple):
    """Two elements a and b that can meet; vertices as a step ago."""

    face_a: Face
    face_b: Face
    law: Law
    nearest: Nearest
    before: Vertices
    one: Memory
    two: Memory
    action: Action
    deepest: float
    """Largest penetration, m; energy taken from the elements, J."""
    taken: float


CASE: Final = Rows(COLUMNS, Case)
ELEMENT: Final = Rows(COLUMNS, Element)
PAIR: Final = Rows(COLUMNS, Pair)
CASE_SIZE: Final = CASE.size
ELEMENT_SIZE: Final = ELEMENT.size
PAIR_SIZE: Final = PAIR.size

load_case, store_case, _ = CASE.access(Case)
_, store_shaking, _ = CASE.access(Case, "shaking")
load_element, _, _ = ELEMENT.access(Element)
load_pose, store_pose, _ = ELEMENT.access(Element, "pose")
_, store_velocity, _ = ELEMENT.access(Element, "velocity")
_, store_now, _ = ELEMENT.access(Element, "now")
_, store_acceleration, _ = ELEMENT.access(Element, "acceleration")
_, store_force, _ = ELEMENT.access(Element, "force")
_, store_course, _ = ELEMENT.access(Element, "course")
load_pair, _, _ = PAIR.access(Pair)
_, store_face_a, _ = PAIR.access(Pair, "face_a")
_, store_face_b, _ = PAIR.access(Pair, "face_b")
_, store_law, _ = PAIR.access(Pair, "law")
load_nearest, store_nearest, _ = PAIR.access(Pair, "nearest")
_, store_vertices, _ = PAIR.access(Pair, "before")
load_memory, store_memory, _ = PAIR.access(Pair, "one")
_, store_action, _ = PAIR.access(Pair, "action")

# Rows of numbers that are changed by themselves. Added to a column, SECOND leads from end 1's memory to end 2's.
SECOND: Final = PAIR.row(Pair, "two.spring") - PAIR.row(Pair, "one.spring")
TICK: Final = CASE.row(Case, "shaking.tick")
SAMPLE: Final = CASE.row(Case, "sample")
ENERGY: Final = CASE.row(Case, "energy")
LAST_UPRIGHT: Final = ELEMENT.row(Element, "course.last_upright")
UPRIGHT_UNTIL: Final = ELEMENT.row(Element, "standing.upright_until")
SIDE: Final = ELEMENT.row(Element, "standing.side")
PEAK_SLIP: Final = ELEMENT.row(Element, "standing.peak_slip")
SLIP: Final = ELEMENT.row(Element, "standing.slip")
SAFE_FROM: Final = ELEMENT.row(Element, "standing.safe_from")
LIMIT: Final = PAIR.row(Pair, "nearest.limit")
REACH: Final = PAIR.row(Pair, "nearest.reach")
USED: Final = PAIR.row(Pair, "nearest.used")
DEEPEST: Final = PAIR.row(Pair, "deepest")
TAKEN: Final = PAIR.row(Pair, "taken")


def flat(values: Iterable[Any]) -> list[float]:
    """The numbers of nested tuples, in the order of their rows."""
    return [number for value in values for number in (flat(value) if isinstance(value, tuple) else [float(value)])]


@intrinsic
def borrowed(_: Any, array: Any) -> Any:
    """The same array without an owner: its slices count no references, whose locked instructions took a fifth of the time.

    Whoever borrows has to hold on to the array itself.
    """

    def make(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, value=values[0])
        view.meminfo = view.meminfo.type(None)
        view.parent = view.parent.type(None)
        return view._getvalue()

    return array(array), make


@njit(inline="always", **OPTIONS)
def of_element(state: Any, element: int) -> Any:
    """The rows of an element."""
    at = CASE_SIZE + element * ELEMENT_SIZE
    return state[at : at + ELEMENT_SIZE]


@njit(inline="always", **OPTIONS)
def of_pair(state: Any, elements: int, pair: int) -> Any:
    """The rows of a pair; those of all elements come before them."""
    at = CASE_SIZE + elements * ELEMENT_SIZE + pair * PAIR_SIZE
    return state[at : at + PAIR_SIZE]
