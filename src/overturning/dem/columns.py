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
"""Ticks of a whole step: where a contact opens or closes the centred scheme takes fewer at a time;"""

EARLY_TICKS: Final = 32.0
"""after a change a step is one tick long for so many ticks,"""

LATE_TICKS: Final = 4
"""then so many ticks long"""

SETTLING: Final = 5.0
"""until this time has passed, in 1/ω: the contact's fast transient is over;"""

TAIL_STEP: Final = 32
"""then so many ticks"""

TAIL: Final = 8.0
"""for so long, in 1/ω, but at least two whole steps: the slower modes settle."""

MOST_TRIES: Final = 2.0
"""A long step is done so often with other corners taken to slide before its outcome is taken as it is."""

OPTIONS: Final[dict[str, Any]] = {"fastmath": False, "error_model": "numpy", "boundscheck": False}
"""Of every jitted function: no fast-math, no contraction, so that the bits are the same everywhere."""

# One row of COLUMNS numbers each: constants of the case,
(HALF_WIDTH, HALF_HEIGHT, INERTIA, STIFFNESS, TANGENTIAL, COMPLIANCE, DASHPOT, FRICTION, ALPHA, STEP) = (
    i * COLUMNS for i in range(10)
)
(WINDOW, TAIL_TICKS) = (82 * COLUMNS, 83 * COLUMNS)
# the position (angle with its cosine and sine), velocity and acceleration,
(X, Z, ANGLE, COS, SIN, VX, VZ, VW, AX, AZ, AW) = (i * COLUMNS for i in range(11, 22))
# the corners, left and right: tangential spring, place along s and penetration at the end of the last step, and, for
# the centred scheme, ±μ where the corner slid and the force with which it pressed,
(SPRING_L, SPRING_R, OLD_XL, OLD_UL, OLD_XR, OLD_UR, SLID_L, SLID_R, PRESSED_L, PRESSED_R) = (
    i * COLUMNS for i in range(22, 32)
)
# what the shaking does to the block: value, slope and change of slope over the ticks of this sample and the next,
(TICK, BASE, SLOPE, BEND, UP_BASE, UP_SLOPE, UP_BEND, FINE) = (i * COLUMNS for i in range(32, 40))
# what is booked on the way,
(PEAK_ANGLE, LAST_UPRIGHT, PEAK_SLIP, PEAK_DEPTH, WORK, LOST, POWER, LOSS) = (i * COLUMNS for i in range(40, 48))
# what one part of a step leaves to the next: the position, the velocities in the middle and as foreseen for the end,
(NEW_X, NEW_Z, NEW_ANGLE, NEW_COS, NEW_SIN, MID_VX, MID_VZ, MID_VW, END_VX, END_VZ, END_VW) = (
    i * COLUMNS for i in range(48, 59)
)
# arms of the corners to either side of the centre, their drops below it, their penetrations, springs and foreseen
# velocities, the shaking and half the step,
(ARM_L, ARM_R, DROP_L, DROP_R, NEW_UL, NEW_UR, NEW_SL, NEW_SR) = (i * COLUMNS for i in range(59, 67))
(END_XL, END_XR, END_ZL, END_ZR, PUSH, LIFT, HALF) = (i * COLUMNS for i in range(67, 74))
# and what is looked at once per sample only.
(AMPLITUDE, SAMPLE, UPRIGHT_UNTIL, ENERGY, BARRIER, CALM, AFTER, LOOK) = (i * COLUMNS for i in range(74, 82))
TRIES: Final = 84 * COLUMNS
ROWS: Final = 85
