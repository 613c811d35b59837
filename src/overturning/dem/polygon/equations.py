"""The equations of a step of the centred scheme: three for the change of velocity of each element that moves.

They are scaled by half the step and the inverse masses: 1 plus what the contacts add. Elimination goes by submatrices
of 3 × 3 in the order of the elements, without a pivot: the matrix is 1 plus something that only adds, but for sliding
ends, which stick before they take too much away.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import APART, INLINE, INNER, OWNER, Rows, arithmetic, unknown, windows
from overturning.dem.polygon import rows
from overturning.dem.polygon.mechanics import Action, Outer
from overturning.dem.polygon.state import Inertia, Plane


class Submatrix(NamedTuple):
    """Three by three numbers, rows of the forces' element, columns of the velocities'."""

    xx: float
    xz: float
    xw: float
    zx: float
    zz: float
    zw: float
    wx: float
    wz: float
    ww: float


SUBMATRIX: Final = Rows(rows.COLUMNS, Submatrix)
SIZE: Final = SUBMATRIX.size
load, store, _ = SUBMATRIX.access(Submatrix)
minus = arithmetic(Submatrix).minus


class Blocks(NamedTuple):
    """The four submatrices of a pair, rows of the forces' element, columns of the velocities'."""

    aa: Any
    ab: Any
    ba: Any
    bb: Any


SPARE: Final = len(Blocks._fields)
"""Places behind the matrix, for what is entered for an element that moves with the base."""


class Pattern(NamedTuple):
    """Which submatrices are not 0: those of elements that touch, and what elimination adds."""

    used: Any
    """True where a submatrix is not 0, shape (elements, elements)."""
    later: Any
    """Of each element the later ones with which it shares a submatrix, ascending, shape (elements, elements)."""
    count: Any
    """Number of these, shape (elements,)."""


@njit(**OWNER)
def pattern_of(size: int) -> Any:
    """No submatrix is used yet."""
    return Pattern(np.zeros((size, size), np.bool_), np.zeros((size, size), np.int64), np.zeros(size, np.int64))


@njit(**INNER)
def clear(pattern: Pattern) -> None:
    """Let no submatrix be used, at a cost by the number of those that are."""
    for k in range(pattern.count.size):
        pattern.used[k, k] = False
        for n in range(pattern.count[k]):
            m = pattern.later[k, n]
            pattern.used[k, m] = pattern.used[m, k] = False
        pattern.count[k] = 0


@njit(**INNER)
def use(pattern: Pattern, i: int, k: int) -> None:
    """Let a submatrix be used; both of two elements must be, one after the other."""
    pattern.used[i, k] = True
    if i >= k:
        return
    n = pattern.count[i]
    while n > 0 and pattern.later[i, n - 1] > k:
        pattern.later[i, n] = pattern.later[i, n - 1]
        n -= 1
    pattern.later[i, n] = k
    pattern.count[i] += 1


of_submatrix: Final = windows(SIZE)
"""``of_submatrix(matrix, k)``: the rows of a submatrix, by its number."""


@njit(**INLINE)
def scaled(p: Submatrix, own: Inertia, factor: float) -> Submatrix:
    """Rows times a factor and the inverse masses of their element."""
    m, i = factor * own.inverse_mass, factor * own.inverse_inertia
    return Submatrix(m * p.xx, m * p.xz, m * p.xw, m * p.zx, m * p.zz, m * p.zw, i * p.wx, i * p.wz, i * p.ww)


@njit(**INLINE)
def times(p: Submatrix, v: Plane) -> Plane:
    """A submatrix times three numbers."""
    x, z = (p.xx * v.x + p.xz * v.z) + p.xw * v.w, (p.zx * v.x + p.zz * v.z) + p.zw * v.w
    return Plane(x, z, (p.wx * v.x + p.wz * v.z) + p.ww * v.w)


@njit(**INLINE)
def product(p: Submatrix, q: Submatrix) -> Submatrix:
    """Product of two submatrices."""
    x, z = times(p, Plane(q.xx, q.zx, q.wx)), times(p, Plane(q.xz, q.zz, q.wz))
    w = times(p, Plane(q.xw, q.zw, q.ww))
    return Submatrix(x.x, z.x, w.x, x.z, z.z, w.z, x.w, z.w, w.w)


@njit(**INLINE)
def inverse_of(p: Submatrix) -> Submatrix:
    """Inverse of a submatrix, by cofactors and one division."""
    xx, xz, xw = p.zz * p.ww - p.zw * p.wz, p.xw * p.wz - p.xz * p.ww, p.xz * p.zw - p.xw * p.zz
    zx, zz, zw = p.zw * p.wx - p.zx * p.ww, p.xx * p.ww - p.xw * p.wx, p.xw * p.zx - p.xx * p.zw
    wx, wz, ww = p.zx * p.wz - p.zz * p.wx, p.xz * p.wx - p.xx * p.wz, p.xx * p.zz - p.xz * p.zx
    by = 1.0 / ((p.xx * xx + p.xz * zx) + p.xw * wx)
    return Submatrix(by * xx, by * xz, by * xw, by * zx, by * zz, by * zw, by * wx, by * wz, by * ww)


@njit(**INLINE)
def enter(submatrix: Any, j: int, fresh: bool, diagonal: float, p: Submatrix) -> None:
    """Take numbers off those of a submatrix that are there, off the unit matrix' where it is `fresh`."""
    one, old = diagonal, load(submatrix, j)
    store(submatrix, j, minus(Submatrix(
        one if fresh else old.xx, 0.0 if fresh else old.xz, 0.0 if fresh else old.xw,
        0.0 if fresh else old.zx, one if fresh else old.zz, 0.0 if fresh else old.zw,
        0.0 if fresh else old.wx, 0.0 if fresh else old.wz, one if fresh else old.ww,
    ), p))  # fmt: skip


@njit(**INLINE)
def enter_pair(into: Blocks, fresh: Any, j: int, c: Outer, half: float, a: Inertia, b: Inertia) -> None:
    """Enter what the velocities of a pair's elements add to the forces on them."""
    # On the other element acts the opposite, and the opposite velocity counts.
    aa = Submatrix(c.xx, c.xz, c.xa, c.zx, c.zz, c.za, c.ax, c.az, c.aa)
    ab = Submatrix(c.xx, c.xz, c.xb, c.zx, c.zz, c.zb, c.ax, c.az, c.ab)
    ba = Submatrix(c.xx, c.xz, c.xa, c.zx, c.zz, c.za, c.bx, c.bz, c.ba)
    bb = Submatrix(c.xx, c.xz, c.xb, c.zx, c.zz, c.zb, c.bx, c.bz, c.bb)
    enter(into.aa, j, fresh[0], 1.0, scaled(aa, a, -half))
    enter(into.ab, j, fresh[1], 0.0, scaled(ab, a, half))
    enter(into.ba, j, fresh[1], 0.0, scaled(ba, b, half))
    enter(into.bb, j, fresh[2], 1.0, scaled(bb, b, -half))


@njit(**INLINE)
def enter_loads(on: Plane, by: Plane, c: Action, half: float, a: Inertia, b: Inertia) -> tuple[Plane, Plane]:
    """Right-hand sides of a pair's elements with its predicted forces."""
    m, i, n, k = half * a.inverse_mass, half * a.inverse_inertia, half * b.inverse_mass, half * b.inverse_inertia
    return (
        Plane(on.x + m * c.x, on.z + m * c.z, on.w + i * c.moment_a),
        Plane(by.x - n * c.x, by.z - n * c.z, by.w - k * c.moment_b),
    )


@njit(**APART)
def invert(submatrix: Any) -> None:
    """Put the inverse in a submatrix' place."""
    for j in range(rows.COLUMNS):
        store(submatrix, j, inverse_of(load(submatrix, j)))


@njit(**APART)
def divide(submatrix: Any, inverse: Any) -> None:
    """Multiply a submatrix by a pivot's inverse from the right."""
    for j in range(rows.COLUMNS):
        store(submatrix, j, product(load(submatrix, j), load(inverse, j)))


@njit(**APART)
def eliminate(submatrix: Any, factor: Any, row: Any, fresh: bool) -> None:
    """Take a factor times a submatrix of the pivot's row off a submatrix, off zeros where that is `fresh`."""
    for j in range(rows.COLUMNS):
        enter(submatrix, j, fresh, 0.0, product(load(factor, j), load(row, j)))


@njit(**APART)
def carry(target: Any, submatrix: Any, source: Any) -> None:
    """Take a submatrix times an element's numbers off those of another element."""
    for j in range(unknown(rows.COLUMNS)):
        v, w = rows.load_change(target, j), times(load(submatrix, j), rows.load_change(source, j))
        rows.store_change(target, j, Plane(v.x - w.x, v.z - w.z, v.w - w.w))


@njit(**APART)
def finish_row(e: Any, inverse: Any) -> None:
    """An element's numbers times its pivot's inverse."""
    for j in range(rows.COLUMNS):
        rows.store_change(e, j, times(load(inverse, j), rows.load_change(e, j)))


@njit(**INNER)
def solve(state: Any, matrix: Any, pattern: Pattern, size: int) -> None:
    """Solve for the changes of all elements' velocities, which take the place of the right-hand sides.

    Submatrices that are not used are 0. In a stack each element shares one with the next alone, whatever the height:
    the work grows with the number of elements.
    """
    used, later, count = pattern.used, pattern.later, pattern.count
    for k in range(size):
        if not used[k, k]:
            continue
        pivot = of_submatrix(matrix, k * size + k)
        invert(pivot)
        for n in range(count[k]):
            i = later[k, n]
            factor = of_submatrix(matrix, i * size + k)
            divide(factor, pivot)
            carry(rows.of_element(state, i), factor, rows.of_element(state, k))
            for o in range(count[k]):
                m = later[k, o]
                row = of_submatrix(matrix, k * size + m)
                eliminate(of_submatrix(matrix, i * size + m), factor, row, not used[i, m])
                if not used[i, m]:
                    use(pattern, i, m)
    for k in range(size - 1, -1, -1):
        if not used[k, k]:
            continue
        for n in range(count[k]):
            m = later[k, n]
            carry(rows.of_element(state, k), of_submatrix(matrix, k * size + m), rows.of_element(state, m))
        finish_row(rows.of_element(state, k), of_submatrix(matrix, k * size + k))


@njit(inline="always", **INNER)
def block(matrix: Any, moves: Any, i: int, k: int, spare: int) -> Any:
    """A submatrix, or a spare place behind the matrix where an element moves with the base: it has no equations."""
    return of_submatrix(matrix, i * moves.size + k if moves[i] and moves[k] else moves.size * moves.size + spare)


@njit(inline="always", **INNER)
def place(matrix: Any, pattern: Pattern, moves: Any, i: int, k: int) -> tuple[Blocks, Any]:
    """Where a pair is entered, and which of its submatrices are fresh: those of a, between both, and of b."""
    used = pattern.used
    fresh = not used[i, i], not used[i, k], not used[k, k]
    used[i, i], used[k, k] = moves[i], moves[k]
    if moves[i] and moves[k] and not used[i, k]:
        use(pattern, i, k)
        use(pattern, k, i)
    aa, ab = block(matrix, moves, i, i, 0), block(matrix, moves, i, k, 1)
    return Blocks(aa, ab, block(matrix, moves, k, i, 2), block(matrix, moves, k, k, 3)), fresh
