"""What the kernel of scenes knows of a case, its elements and their pairs: named tuples, laid out by `rows`."""

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
    """What a step found, above 0 where it did, as of `overturning.dem.kernel.clock.Found`."""

    changed: float
    wrong: float
    reversed: float
    slides: float
    back: float


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
    bears: float
    """horizontal acceleration over g that leaves it at rest,"""
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
    """part of the record in which it was last looked at."""


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


class Inertia(NamedTuple):
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
    back: float
    """Rotation to −x up to which the element can come back, rad."""
    on: float
    """Rotation to +x up to which the element can come back, rad."""


class Course(NamedTuple):
    """What is noted of an element's motion at each step."""

    moved: float
    """Motion (m) and rotation (rad) of the last step,"""
    turned: float
    work: float
    """work of what moves the base and of what holds the element, J,"""
    peak_back: float
    """Largest rotation to −x, rad."""
    peak_on: float
    """Largest rotation to +x, rad."""
    last_upright: float
    """Ticks of this sample up to the last at which the element could come back, −1 if none."""
    power: float
    """power at the last step, W (centred scheme)."""


class Travel(NamedTuple):
    """Motion of an element since some pair of the scene sleeps (`overturning.dem.polygon.distant`)."""

    moved: float
    """Length of its path, m."""
    turned: float
    """Sum of its absolute rotations, rad."""


class Standing(NamedTuple):
    """What is looked at once per sample."""

    upright_until: float
    """Last time at which it could come back by its rotation and was not too low, and at which it was on what carried
    it, s,"""
    carried_until: float
    side: float
    """where it has fallen: ±1, else 0,"""
    peak_slip: float
    slip: float


class Home(NamedTuple):
    """Where an element stands at rest."""

    base_x: float
    """Points of its base and of what it stands on, whose distance is the slip, m;"""
    base_z: float
    support_x: float
    support_z: float
    x: float
    """centre, m, and height below which it has fallen."""
    z: float
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
    inertia: Inertia
    course: Course
    travel: Travel
    standing: Standing
    home: Home


class Face(NamedTuple):
    """A face in its element's axes: outward normal, distance from the centre, ends along the tangent (−n_z, n_x)."""

    nx: float
    nz: float
    off: float
    low: float
    high: float


class Law(NamedTuple):
    """Contact law at a vertex: stiffnesses (N/m), dashpot (N s/m), friction, 1/tangential stiffness, landing (s).

    The landing is the time after the first touch in which a flat landing lasts; 0 where the rule is not applied.
    """

    normal: float
    tangential: float
    dashpot: float
    friction: float
    compliance: float
    landing: float


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
    """What an end remembers: stretch of its tangential spring, carrier, forces along normal and tangent.

    And for how long it still lands, s, 0 or less where it does not.
    """

    spring: float
    carrier: float
    normal: float
    tangent: float
    landing: float


OPEN, MINE, THEIRS, HANDED_ON = 0.0, 1.0, -1.0, 2.0
"""What an end's `Memory.carrier` says: open, closed by a's vertex or by b's, or found anew by a search."""


class History(NamedTuple):
    """What a pair remembers of its last step."""

    before: Vertices
    one: Memory
    two: Memory
    deepest: float
    """Largest penetration so far, m,"""
    taken: float
    """energy taken from the elements, J."""


class Pair(NamedTuple):
    """Two elements a and b that can touch."""

    face_a: Face
    face_b: Face
    bounds: Bounds
    law: Law
    nearest: Nearest
    history: History
    slid_one: float
    """±μ of an end that was last found sliding (centred scheme)."""
    slid_two: float
    stands: float
    """1 where a was carried by b at rest, −1 where b by a, else 0."""
