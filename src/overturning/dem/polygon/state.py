"""What the general kernel knows of a case, its elements and its pairs: named tuples, whose rows `overturning.dem.polygon.rows` lays out."""

from typing import NamedTuple

from overturning.dem.kernel.clock import Attempt, Clock
from overturning.dem.kernel.ground import Line


class Shaking(NamedTuple):
    """Acceleration of the base, linear between two samples, and time."""

    base: Line
    """Towards the azimuth,"""
    up: Line
    """upwards,"""
    tick: float
    """ticks since the sample."""


class Marks(NamedTuple):
    """What a step found, above 0 where it did."""

    changed: float
    """A contact opens or closes;"""
    wrong: float
    """an end sticks or slides otherwise than taken;"""
    reversed: float
    """an end slides against its velocity: a slip reversal;"""
    slides: float
    """all of a pair's ends in contact slide;"""
    back: float
    """one slides that friction held the other way before."""


class Verdict(NamedTuple):
    """What becomes of the step, above 0 where so."""

    again: float
    """It is not taken;"""
    sooner: float
    """its ends are taken to do the same in the next one;"""
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
    clock: Clock
    attempt: Attempt
    found: Marks
    verdict: Verdict
    amplitude: float
    """factor on the record,"""
    sample: float
    """sample of the record,"""
    calm: float
    """samples after which it can be at rest for good, and after which it is undecided,"""
    after: float
    energy: float
    """energy at the start, J;"""
    variant: float
    """which variant of the scene it is of;"""
    looked: float
    """part of the record in which it was last looked at,"""
    due: float
    """and 1 where it is to be looked at."""


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
    """Last time at which it was turned by less than α and not too low, and at which it was on what carried it, s,"""
    carried_until: float
    side: float
    """where it has fallen: ±1, else 0,"""
    peak_slip: float
    slip: float
    base_x: float
    """points of its base and of what it stands on, whose distance is the slip, m."""
    base_z: float
    support_x: float
    support_z: float
    home_x: float
    """Centre at rest (m), and height below which it has fallen."""
    home_z: float
    lowest: float


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


class Bounds(NamedTuple):
    """Where on the other face a vertex begins to carry an end, m; ±infinity where it never does, as one of a cut."""

    one_a: float
    """Least place of a's first vertex and of b's second,"""
    one_b: float
    two_a: float
    """greatest of a's second and of b's first."""
    two_b: float


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
    """Stretch of its tangential spring as predicted, m,"""
    slid: float
    """±μ where it slides."""


class Outer(NamedTuple):
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


class Couple(NamedTuple):
    """A pair's part in the equations."""

    outer: Outer
    """What velocities add to forces,"""
    load: Action
    """and forces as predicted."""


class Corrected(NamedTuple):
    """A pair at the end of a step that may not be taken."""

    before: Vertices
    one: Memory
    two: Memory
    deepest: float
    taken: float


class Pair(NamedTuple):
    """Two elements a and b that can touch; vertices as a step ago."""

    face_a: Face
    face_b: Face
    bounds: Bounds
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
    stands: float
    """1 where a was carried by b at rest, −1 where b by a, else 0."""


class Step(NamedTuple):
    """A pair while a step of the centred scheme is computed."""

    ends: Stretch
    one: Taken
    two: Taken
    couple: Couple
    corrected: Corrected
