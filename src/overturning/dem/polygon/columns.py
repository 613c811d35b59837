"""How the general kernel keeps its cases: one array, a row per quantity, a column per case.

Quantity ``Q`` of column ``j`` stands at ``[Q + j]`` of a block of rows: the column's own, then one block per element and
one per pair. The innermost loops run over columns without branches and LLVM makes vector code of them; they know only
``+ - * /`` and comparisons, so that a column's bits depend neither on its neighbours, nor on the thread, nor on the width
of the processor's vectors.

All modules of this folder count as the kernel's sources (`overturning.dem.cache`); nothing that is compiled may come from
another one.
"""

from typing import Any, Final

from numba import njit
from numba.extending import intrinsic

from overturning.dem.cache import prefer_full_width

prefer_full_width()  # before anything is compiled

COLUMNS: Final = 16
"""Cases side by side: enough to hide the latency of one case's operations, few enough for the first cache."""

OPTIONS: Final[dict[str, Any]] = {"fastmath": False, "error_model": "numpy", "boundscheck": False}
"""Of every jitted function: no fast-math, no contraction, so that the bits are the same everywhere."""

INLINE: Final[dict[str, Any]] = {**OPTIONS, "forceinline": True}
"""Of those called within a loop over the columns: without it the loop would not become vector code."""

# A column's own rows,
(STEP, RATE, TICK, BASE, SLOPE, UP_BASE, UP_SLOPE, GROUND, UP) = (i * COLUMNS for i in range(9))
(AMPLITUDE, SAMPLE, CALM, AFTER, ENERGY) = (i * COLUMNS for i in range(9, 14))
OWN: Final = 14
# those of an element: pose, velocity at the half step, motion of the last step, force at the whole step,
(X, Z, ANGLE, COS, SIN, VX, VZ, VW, MOVED, TURNED, FX, FZ, MOMENT) = (i * COLUMNS for i in range(13))
# velocity at the whole step, with the forces known so far, acceleration,
(NOW_X, NOW_Z, NOW_W, AX, AZ, AW) = (i * COLUMNS for i in range(13, 19))
# constants,
(INVERSE_MASS, INVERSE_INERTIA, MASS, FRAME, WEIGHT, HELD, CRITICAL) = (i * COLUMNS for i in range(19, 26))
# what is booked, and what is looked at once per sample only;
(WORK, PEAK_ANGLE, LAST_UPRIGHT) = (i * COLUMNS for i in range(26, 29))
(UPRIGHT_UNTIL, SIDE, PEAK_SLIP, SLIP) = (i * COLUMNS for i in range(29, 33))
# points of its base and of what it stands on, whose distance is the slip.
(BASE_X, BASE_Z, SUPPORT_X, SUPPORT_Z) = (i * COLUMNS for i in range(33, 37))
# Sample from which on the shaking is too weak to throw it down from rest.
SAFE_FROM = 37 * COLUMNS
BODY: Final = 38
# those of a pair, of its first element's face: outward normal, distance from the centre, ends along the tangent,
(ANX, ANZ, AOFF, ALO, AHI) = (i * COLUMNS for i in range(5))
# the same of the pair's second element,
(BNX, BNZ, BOFF, BLO, BHI) = (i * COLUMNS for i in range(5, 10))
# contact law, reach of a rotation, limits of motion: before faces can change, before a contact can begin; face indices,
(KN, KS, DASHPOT, FRICTION, COMPLIANCE, LEVER, LIMIT, REACH, FACE_A, FACE_B) = (i * COLUMNS for i in range(10, 20))
# depths and places along the face (along its opposite for b's) one step ago of a's first and second vertex and of b's,
(DA1, SA1, DA2, SA2, DB1, SB1, DB2, SB2) = (i * COLUMNS for i in range(20, 28))
# memory of both ends: spring, contact, forces along normal and tangent; `SECOND` leads from end 1's to end 2's,
(SPRING, CONTACT, NORMAL, TANGENT) = (i * COLUMNS for i in range(28, 32))
MEMORY: Final = 4
SECOND: Final = MEMORY * COLUMNS
# motion since the search, largest penetration, energy taken from the elements, force on a, moments on a and b.
(USED, DEEPEST, TAKEN, SUM_X, SUM_Z, MOMENT_A, MOMENT_B) = (i * COLUMNS for i in range(36, 43))
PAIR: Final = 43

# What an end's CONTACT says: open, closed by a's vertex or by b's, or found anew by a search.
OPEN: Final = 0.0
MINE: Final = 1.0
THEIRS: Final = -1.0
HANDED_ON: Final = 2.0


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
def element_rows(state: Any, element: int) -> Any:
    """The rows of an element."""
    at = (OWN + element * BODY) * COLUMNS
    return state[at : at + BODY * COLUMNS]


@njit(inline="always", **OPTIONS)
def pair_rows(state: Any, elements: int, pair: int) -> Any:
    """The rows of a pair; those of all elements come before them."""
    at = (OWN + elements * BODY + pair * PAIR) * COLUMNS
    return state[at : at + PAIR * COLUMNS]
