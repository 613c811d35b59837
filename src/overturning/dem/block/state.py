"""What the kernel of one block knows of it: named tuples, and the rows of the array that holds them.

Units are per unit of mass: a stiffness is K/m (1/s²), a dashpot h/m (1/s), a force an acceleration. Coordinates and
signs are those of docs/method.md, "The block and its base"; `overturning.dem.kernel.lanes` says how blocks lie side by
side.
"""

import math
from typing import Final, NamedTuple

from numba import njit

from overturning.dem.kernel.clock import BLOCK, Attempt, Clock
from overturning.dem.kernel.ending import CaseProgress, RestState
from overturning.dem.kernel.ground import Line
from overturning.dem.kernel.lanes import INLINE, Rows
from overturning.dem.kernel.mechanics import slides_flat

COLUMNS: Final = 48
"""Blocks side by side: enough to hide the latency of one block's operations, few enough to stay in the first cache."""

TICKS: Final = BLOCK.whole
"""Ticks of a whole step."""

GENTLE: Final = 0.3
"""A step of up to `GENTLE_STEPS` finest ones is short enough where the corner that opens or closes moves in it by no
more than this share of its way in a finest step at B p α, about the speed of a corner of a block that just falls."""

GENTLE_STEPS: Final = 8.0
"""Length of the longest of these steps, in finest ones."""

MOST_FRICTION: Final = 100.0
"""Friction coefficient above which a block is computed with this one: its corners do not slide. With more, what a
corner that touches down slides by in a step may outweigh its energy, the more so the more damped the contact is."""

RIGID: Final = 100.0
"""Whole samples are the steps of a block on both corners where 1/ω is so many times shorter than they are."""


class Block(NamedTuple):
    """Constants of a case."""

    half_width: float
    half_height: float
    inertia: float
    """m/I, 1/m²;"""
    stiffness: float
    """of a corner's normal spring,"""
    tangential: float
    """of its tangential one,"""
    compliance: float
    """1 over that, 0 where there is none;"""
    dashpot: float
    friction: float
    """μ;"""
    alpha: float
    """arctan(B/H), rad;"""
    step: float
    """length of a tick, s;"""
    gentle: float
    """how far a corner may move in a step that is not the finest and in which it opens or closes, m;"""
    landing: float
    """how long a corner lands after it has touched, s."""


class Corner(NamedTuple):
    """What a corner remembers of the end of the last step."""

    spring: float
    """Stretch of its tangential spring, m;"""
    place: float
    """where it was along s, m;"""
    depth: float
    """its penetration, m, negative in the air;"""
    normal: float
    """and the normal force (centred scheme)."""


class Given(NamedTuple):
    """What a corner is taken to do in a step of the centred scheme."""

    slid: float
    """±μ where it slides;"""
    fine: bool
    """whether the step is fine;"""
    held: bool
    """whether its dashpot holds it, as of `lands_flat`,"""
    drifts: bool
    """and whether the block slides meanwhile,"""
    drift: float
    """by ±μ, both as of `drift_of`."""


class State(NamedTuple):
    """Where a block is: its centre in the frame of the base, rotation with its cosine and sine, and its corners."""

    x: float
    z: float
    angle: float
    cos: float
    sin: float
    vx: float
    vz: float
    vw: float
    ax: float
    az: float
    aw: float
    left: Corner
    right: Corner
    tick: float
    """Ticks since the sample began;"""
    landing: float
    """for how long the block still lands, s, 0 or less where it does not."""


class Taken(NamedTuple):
    """What the corners are taken to do in the next step (centred scheme): ±μ where one slides, 0 where it sticks."""

    left: float
    right: float


class Peaks(NamedTuple):
    """What is kept of the path: largest rotation, slip of the base's midpoint, penetration, and last tick below α."""

    angle: float
    slip: float
    depth: float
    last_upright: float


class Account(NamedTuple):
    """The energy account, per mass: work of the shaking and losses so far, and the rates of both at the last step."""

    work: float
    lost: float
    power: float
    loss: float


class Shaking(NamedTuple):
    """What the moving base does to the block in its own frame, m/s²."""

    push: Line
    """−a along s;"""
    lift: Line
    """a_up, which adds to gravity."""


class Drift(NamedTuple):
    """Position of a block and its velocities at the end of a step, were its acceleration to stay."""

    x: float
    z: float
    cos: float
    sin: float
    vx: float
    vz: float
    vw: float


class PredictedCorner(NamedTuple):
    """A corner where the block would be if its acceleration stayed."""

    arm: float
    """From the centre along s,"""
    drop: float
    """and down, m;"""
    depth: float
    stretch: float
    ux: float
    """velocity along s"""
    uz: float
    """and up, m/s."""


class Predicted(NamedTuple):
    """A step of the centred scheme before its equations are solved."""

    x: float
    z: float
    angle: float
    cos: float
    sin: float
    vx: float
    """Velocity after half the step,"""
    vz: float
    vw: float
    ex: float
    """at its end,"""
    ez: float
    ew: float
    push: float
    """shaking at its end;"""
    lift: float
    half: float
    """half its length, s."""
    left: PredictedCorner
    right: PredictedCorner


class Change(NamedTuple):
    """What the solution adds to the predicted velocities, and ±μ of the corners that slide in it."""

    vx: float
    vz: float
    vw: float
    slid_left: float
    slid_right: float


class Sliding(NamedTuple):
    """What a corner is taken to do tangentially."""

    f: float
    """Its force as predicted;"""
    slides: bool
    slid: float
    """±μ where it slides;"""
    free: bool
    """whether a normal force pushes it out while it slides."""


class Contribution(NamedTuple):
    """A corner in the three equations: forces at rest at the end of the step, and what each velocity adds to them."""

    n: float
    f: float
    press: float
    stick: float
    slide: float


class Corrected(NamedTuple):
    """A corner at the solution."""

    corner: Corner
    """What it is to remember;"""
    f: float
    """its tangential force,"""
    moment: float
    """moment of both forces,"""
    loss: float
    """power of its dashpots and slider,"""
    let_go: float
    """energy that its springs let go, tangential"""
    cut: float
    """and normal, over half their stiffness;"""
    fresh: bool
    """whether the contact has closed in this step,"""
    sunk: float
    """how deep it has sunk since, 1 where it has not;"""
    changed: float
    """above 0 where the contact has opened or closed;"""
    far: float
    """and how far the corner has moved up or down in that step, m, 0 else;"""
    found: float
    """±μ where it slips,"""
    wrong: bool
    """whether it was taken to do otherwise,"""
    reversed: bool
    """whether it is taken to slide against its velocity: a slip reversal,"""
    back: bool
    """and whether friction held it the other way before."""


class Corners(NamedTuple):
    """Both corners at the solution."""

    left: Corrected
    right: Corrected


class Kept(NamedTuple):
    """What a step that is accepted changes of a case."""

    state: State
    peaks: Peaks
    account: Account


ROWS: Final = Rows(
    COLUMNS, Block, Clock, State, Attempt, Taken, Peaks, Account, Shaking, CaseProgress, Predicted, Change, RestState
)


@njit(**INLINE)
def arm_of(side: float, block: Block, c: float, s: float) -> tuple[float, float]:
    """A lower corner from the centre: along s, and down; side is −1 for the left one, +1 for the right one."""
    b, h = side * block.half_width, block.half_height
    return b * c - h * s, h * c + b * s


@njit(**INLINE)
def is_in_the_air(s: State) -> bool:
    """Whether no corner touched at the end of the last step."""
    return (s.left.depth <= 0.0) & (s.right.depth <= 0.0)


@njit(**INLINE)
def landing_of(block: Block, s: State, dt: float) -> float:
    """For how long a block still lands after a step dt: from the air it begins, and so never while it rocks."""
    return block.landing if is_in_the_air(s) else s.landing - dt


@njit(**INLINE)
def lands_flat(s: State, left: float, right: float) -> bool:
    """Whether both corners land at once in a step, at whose end they are so deep.

    A plastic landing has no tension over all of it. A dashpot's part of it is h times the depth, which is positive as
    long as the corner is in the ground: until then the dashpot may pull (docs/method.md, "A flat landing").
    """
    return ((s.landing > 0.0) | is_in_the_air(s)) & (left > 0.0) & (right > 0.0)


@njit(**INLINE)
def drift_of(block: Block, held: bool, vx: float, vz: float) -> tuple[bool, float]:
    """Whether a block that lands flat slides, by `slides_flat` of its centre's velocities, and ±μ of it."""
    return held & slides_flat(block.friction, vx, vz), math.copysign(block.friction, vx)


@njit(**INLINE)
def base_slip(block: Block, x: float, s: float) -> float:
    """Displacement of the midpoint of the block's base, m, from the centre's and the sine of the rotation."""
    return x - block.half_height * s
