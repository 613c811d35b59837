"""How the general kernel keeps its cases: named tuples of one case, in rows of an array with a column per case.

The array has the rows of the column itself (`Case`), then a block of rows for each element (`Element`) and for each pair
(`Pair`). A function that computes one case takes and gives such tuples; `load_element(rows, j)`, `store_pose(rows, j, pose)`
and the like fetch and keep those of column j. The innermost loops run over columns without branches and LLVM makes vector code
of them; they know only ``+ - * /`` and comparisons, so that a column's bits depend neither on its neighbours, nor on the
thread, nor on the width of the processor's vectors.
"""

from collections.abc import Iterable
from typing import Any, Final

from numba import njit
from numba.extending import intrinsic

from overturning.dem.kernel.lanes import OPTIONS, Rows, arithmetic
from overturning.dem.polygon.state import Case, Element, Marks, Pair, Step

COLUMNS: Final = 16
"""Cases side by side: enough to hide the latency of one case's operations, few enough for the first cache."""

# What an end's `Memory.carrier` says: open, closed by a's vertex or by b's, or found anew by a search.
OPEN: Final = 0.0
MINE: Final = 1.0
THEIRS: Final = -1.0
HANDED_ON: Final = 2.0


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
_, store_marks, _ = CASE.access(Case, "found")
no_marks = arithmetic(Marks).zero
load_element, _, _ = ELEMENT.access(Element)
load_pose, store_pose, _ = ELEMENT.access(Element, "pose")
_, store_velocity, _ = ELEMENT.access(Element, "velocity")
_, store_trial, _ = ELEMENT.access(Element, "trial")
load_change, store_change, _ = ELEMENT.access(Element, "trial.change")
_, store_acceleration, _ = ELEMENT.access(Element, "acceleration")
load_force, store_force, _ = ELEMENT.access(Element, "force")
_, store_course, _ = ELEMENT.access(Element, "course")
load_pair, _, _ = PAIR.access(Pair)
_, store_face_a, _ = PAIR.access(Pair, "face_a")
_, store_face_b, _ = PAIR.access(Pair, "face_b")
_, store_bounds, _ = PAIR.access(Pair, "bounds")
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
_, store_corrected, _ = PAIR.access(Step, "corrected")
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
CARRIED_UNTIL: Final = ELEMENT.row(Element, "standing.carried_until")
SIDE: Final = ELEMENT.row(Element, "standing.side")
PEAK_SLIP: Final = ELEMENT.row(Element, "standing.peak_slip")
SLIP: Final = ELEMENT.row(Element, "standing.slip")
LIMIT: Final = PAIR.row(Pair, "nearest.limit")
REACH: Final = PAIR.row(Pair, "nearest.reach")
USED: Final = PAIR.row(Pair, "nearest.used")
AHEAD: Final = PAIR.row(Pair, "nearest.ahead")
SLID_ONE: Final = PAIR.row(Pair, "slid_one")
SLID_TWO: Final = PAIR.row(Pair, "slid_two")
VARIANT: Final = CASE.row(Case, "variant")
LOOKED: Final = CASE.row(Case, "looked")
DUE: Final = CASE.row(Case, "due")
LENGTH: Final = CASE.row(Case, "attempt.length")
CHANGED: Final = CASE.row(Case, "found.changed")
AGAIN: Final = CASE.row(Case, "verdict.again")
SOONER: Final = CASE.row(Case, "verdict.sooner")
DEEPEST: Final = PAIR.row(Pair, "deepest")
TAKEN: Final = PAIR.row(Pair, "taken")
STANDS: Final = PAIR.row(Pair, "stands")


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
