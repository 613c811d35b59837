"""How the kernel keeps its blocks: one array, a row per quantity, a column per block.

Quantity ``Q`` of column ``j`` is ``state[Q + j]``, so that the loops over the columns address one base with constant
offsets and turn into full-width vector code. Units are per unit of mass: a stiffness is K/m (1/s²), a dashpot h/m (1/s),
a force an acceleration.
"""

from typing import Any, Final

from overturning.dem.cache import prefer_full_width

prefer_full_width()  # before anything is compiled

COLUMNS: Final = 48
"""Blocks side by side: enough to hide the latency of one column's operations, few enough to stay in the first cache."""

TICKS: Final = 128
"""Ticks of a whole step, into which the centred scheme divides it where a contact changes."""

EARLY_TICKS: Final = 32.0
"""After a change of contact steps are one tick long for so many ticks."""

LATE_STEP: Final = 4
"""Then they are so many ticks long until the contact's fast transient is over (`SETTLING`)."""

SETTLING: Final = 5.0
"""Time from the change to the end of these steps, in 1/ω, rounded up to whole steps; longer where the contact rings."""

TAIL_STEP: Final = 32
"""Then steps are so many ticks long, while the slower modes settle (`TAIL`)."""

TAIL: Final = 8.0
"""Time for which they are, in 1/ω, rounded up to whole steps,"""

LEAST_TAIL: Final = 2.0
"""of which it has so many at least."""

MOST_TRIES: Final = 2.0
"""A long step is done again so often with other corners taken to slide; then it is done in shorter ones."""

OPTIONS: Final[dict[str, Any]] = {"fastmath": False, "error_model": "numpy", "boundscheck": False}
"""Of every jitted function: no fast-math, no contraction, so that the bits are the same everywhere."""

# One row of COLUMNS numbers each: constants of the case, the last two in ticks,
(HALF_WIDTH, HALF_HEIGHT, INERTIA, STIFFNESS, TANGENTIAL, COMPLIANCE, DASHPOT, FRICTION, ALPHA, STEP) = (
    i * COLUMNS for i in range(10)
)
(WINDOW, TAIL_TICKS) = (i * COLUMNS for i in range(10, 12))
# the position (angle with its cosine and sine), velocity and acceleration,
(X, Z, ANGLE, COS, SIN, VX, VZ, VW, AX, AZ, AW) = (i * COLUMNS for i in range(12, 23))
# the corners, left and right: tangential spring, place along s and penetration at the end of the last step, and, for
# the centred scheme, ±μ where the corner is taken to slide and the force with which it pressed,
(SPRING_L, SPRING_R, OLD_XL, OLD_UL, OLD_XR, OLD_UR, SLID_L, SLID_R, PRESSED_L, PRESSED_R) = (
    i * COLUMNS for i in range(23, 33)
)
# where in its sample the column is, how many ticks are left until whole steps, how often this step was done again,
(TICK, FINE, TRIES) = (i * COLUMNS for i in range(33, 36))
# what the shaking does to the block: value, slope and change of slope over the ticks of this sample and the next,
(BASE, SLOPE, BEND, UP_BASE, UP_SLOPE, UP_BEND) = (i * COLUMNS for i in range(36, 42))
# what is booked on the way,
(PEAK_ANGLE, LAST_UPRIGHT, PEAK_SLIP, PEAK_DEPTH, WORK, LOST, POWER, LOSS) = (i * COLUMNS for i in range(42, 50))
# what one part of a step leaves to the next: the position, the velocities in the middle and as foreseen for the end,
(NEW_X, NEW_Z, NEW_ANGLE, NEW_COS, NEW_SIN, MID_VX, MID_VZ, MID_VW, END_VX, END_VZ, END_VW) = (
    i * COLUMNS for i in range(50, 61)
)
# arms of the corners to either side of the centre, their drops below it, their penetrations and springs,
(ARM_L, ARM_R, DROP_L, DROP_R, NEW_UL, NEW_UR, NEW_SL, NEW_SR) = (i * COLUMNS for i in range(61, 69))
# their foreseen velocities, the shaking and half the step;
(END_XL, END_XR, END_ZL, END_ZR, PUSH, LIFT, HALF) = (i * COLUMNS for i in range(69, 76))
# and what is looked at once per sample only.
(AMPLITUDE, SAMPLE, UPRIGHT_UNTIL, ENERGY, BARRIER, CALM, AFTER, LOOK) = (i * COLUMNS for i in range(76, 84))
ROWS: Final = 84
