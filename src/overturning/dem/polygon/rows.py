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


class Line(NamedTuple):
    """A component of the base's acceleration over a sample, m/s²: value at its begin, slope per tick, change of slope at its end."""

    value: float
    slope: float
    bend: float


class Shaking(NamedTuple):
    """Acceleration of the base, linear between two samples, and time."""

    base: Line
    """Towards the azimuth,"""
    up: Line
    """upwards,"""
    tick: float
    """ticks since the sample."""


class Attempt(NamedTuple):
    """How the next step is to be tried (centred scheme)."""

    length: float
    """Its length in ticks,"""
    left: float
    """how many of this length are to come before longer ones,"""
    tries: float
    """how often it has been done again with other ends sliding."""


class Found(NamedTuple):
    """What a step found, above 0 where it did."""

    changed: float
    """A contact opens or closes;"""
    wrong: float
    """an end sticks or slides otherwise than taken;"""
    reversed: float
    """a sliding end has turned round."""


class Verdict(NamedTuple):
    """What becomes of the step, above 0 where so."""

    again: float
    """It is not taken;"""
    then: Attempt
    """the next one."""


class Case(NamedTuple):
    """What a column holds of its case besides elements and pairs."""

    shaking: Shaking
    step: float
    """Length of a tick (s), ticks per second,"""
    rate: float
    lag: float
    """time by which velocities lag behind poses, s,"""
    finest: float
    """ticks of the shortest step,"""
    dwell: float
    """steps of one length after a change of contact, before those of twice the length,"""
    attempt: Attempt
    found: Found
    verdict: Verdict
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
    """ticks of this sample up to the last at which |rotation| was below α, −1 if none,"""
    power: float
    """power at the last step, W (centred scheme)."""


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


class Trial(NamedTuple):
    """An element at the end of a step, were its acceleration to stay (centred scheme)."""

    pose: Pose
    half: Plane
    """Velocity after half the step,"""
    end: Plane
    """and at its end;"""
    moved: float
    """motion (m) and rotation (rad) of the step;"""
    turned: float
    change: Plane
    """what the solution adds to the velocity at the end."""


class Element(NamedTuple):
    """An element; velocity `Case.lag` ago, force at the whole step."""

    pose: Pose
    velocity: Plane
    trial: Trial
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
    """motion since the search,"""
    ahead: float
    """and at the end of this step."""


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
    """The common stretch of two faces: how one is turned to the other, both ends, all vertices as the next step needs them."""

    turn_q: float
    turn_r: float
    one: End
    two: End
    now: Vertices


class Taken(NamedTuple):
    """What an end is taken to do in the equations of a step."""

    stretch: float
    """Stretch of its tangential spring as foreseen, m,"""
    slid: float
    """±μ where it slides."""


class Couple(NamedTuple):
    """What the velocities of a pair's elements add to their forces (N s/m and so on): rows forces, columns velocities.

    Signs as if b were a: the opposite force acts on b, and the opposite velocity counts.
    """

    xx: float
    xz: float
    zx: float
    zz: float
    xa: float
    za: float
    xb: float
    zb: float
    ax: float
    az: float
    bx: float
    bz: float
    aa: float
    ab: float
    ba: float
    bb: float
    load: Action
    """Forces as foreseen."""


class Met(NamedTuple):
    """A pair at the end of a step that may not be taken."""

    before: Vertices
    one: Memory
    two: Memory
    deepest: float
    taken: float


class Pair(NamedTuple):
    """Two elements a and b that can meet; vertices as a step ago."""

    face_a: Face
    face_b: Face
    law: Law
    nearest: Nearest
    before: Vertices
    one: Memory
    two: Memory
    deepest: float
    """Largest penetration, m; energy taken from the elements, J."""
    taken: float
    slid_one: float
    """±μ of an end that was last found sliding (centred scheme)."""
    slid_two: float


class Step(NamedTuple):
    """A pair while a step of the centred scheme is computed."""

    ends: Stretch
    one: Taken
    two: Taken
    couple: Couple
    met: Met


CASE: Final = Rows(COLUMNS, Case)
ELEMENT: Final = Rows(COLUMNS, Element)
PAIR: Final = Rows(COLUMNS, Pair, Step)
CASE_SIZE: Final = CASE.size
ELEMENT_SIZE: Final = ELEMENT.size
PAIR_SIZE: Final = PAIR.size

load_case, store_case, _ = CASE.access(Case)
_, store_base, _ = CASE.access(Case, "shaking.base")
_, store_up, _ = CASE.access(Case, "shaking.up")
_, store_attempt, _ = CASE.access(Case, "attempt")
_, store_then, _ = CASE.access(Case, "verdict.then")
_, store_found, _ = CASE.access(Case, "found")
load_element, _, _ = ELEMENT.access(Element)
load_pose, store_pose, _ = ELEMENT.access(Element, "pose")
_, store_velocity, _ = ELEMENT.access(Element, "velocity")
_, store_trial, _ = ELEMENT.access(Element, "trial")
load_change, store_change, _ = ELEMENT.access(Element, "trial.change")
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
load_body, _, _ = ELEMENT.access(Element, "body")
load_step, _, _ = PAIR.access(Step)
_, store_ends, _ = PAIR.access(Step, "ends")
_, store_taken_one, _ = PAIR.access(Step, "one")
_, store_taken_two, _ = PAIR.access(Step, "two")
load_couple, store_couple, _ = PAIR.access(Step, "couple")
_, store_met, _ = PAIR.access(Step, "met")
keep_vertices, keep_memory = PAIR.access(Pair, "before").store_unless, PAIR.access(Pair, "one").store_unless
keep_pose, keep_velocity, keep_acceleration = (
    ELEMENT.access(Element, name).store_unless for name in ("pose", "velocity", "acceleration")
)
keep_course = ELEMENT.access(Element, "course").store_unless

# Rows of numbers that are changed by themselves. Added to a column, SECOND leads from end 1's memory to end 2's.
SECOND: Final = PAIR.row(Pair, "two.spring") - PAIR.row(Pair, "one.spring")
TICK: Final = CASE.row(Case, "shaking.tick")
FRAME: Final = ELEMENT.row(Element, "body.frame")
MOVED: Final = ELEMENT.row(Element, "course.moved")
TURNED: Final = ELEMENT.row(Element, "course.turned")
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
AHEAD: Final = PAIR.row(Pair, "nearest.ahead")
SLID_ONE: Final = PAIR.row(Pair, "slid_one")
SLID_TWO: Final = PAIR.row(Pair, "slid_two")
LENGTH: Final = CASE.row(Case, "attempt.length")
CHANGED: Final = CASE.row(Case, "found.changed")
AGAIN: Final = CASE.row(Case, "verdict.again")
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
