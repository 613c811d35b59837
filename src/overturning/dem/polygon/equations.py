"""Linear equations of a step of the centred scheme: three for the velocity change of each moving element.

The equations are multiplied by half the step and the inverse masses, so that the matrix is the unit matrix plus the
terms of the contacts. Gaussian elimination works on 3 × 3 submatrices in the order of the elements, without pivoting:
the terms of sticking contacts are positive semidefinite, and a sliding end is made to stick before its terms could make
the matrix singular.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import APART, INLINE, INNER, OWNER, Rows, arithmetic, unknown, windows
from overturning.dem.polygon import rows
from overturning.dem.polygon.mechanics import Outer, PairAction
from overturning.dem.polygon.state import Inertia, Plane


class Submatrix(NamedTuple):
    """3 × 3 submatrix: one row per force component of an element, one column per velocity component of an element."""

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
    """Submatrices of a pair; the first letter is the element with the force, the second the one with the velocity."""

    aa: Any
    ab: Any
    ba: Any
    bb: Any


SPARE: Final = len(Blocks._fields)
"""Number of spare submatrices behind the matrix; they receive the terms of elements that move with the base."""


class Pattern(NamedTuple):
    """Nonzero pattern of the matrix: submatrices of touching elements, and those that elimination fills in."""

    used: Any
    """True where a submatrix is nonzero, shape (elements, elements)."""
    later: Any
    """Later elements that share a submatrix with each element, ascending, shape (elements, elements)."""
    count: Any
    """Number of entries in each row of `later`, shape (elements,)."""


@njit(**OWNER)
def empty_pattern(size: int) -> Any:
    """Return an empty pattern for `size` elements."""
    return Pattern(np.zeros((size, size), np.bool_), np.zeros((size, size), np.int64), np.zeros(size, np.int64))


@njit(**INNER)
def clear_pattern(pattern: Pattern) -> None:
    """Empty the pattern; the cost is proportional to the number of nonzero submatrices."""
    for k in range(pattern.count.size):
        pattern.used[k, k] = False
        for n in range(pattern.count[k]):
            m = pattern.later[k, n]
            pattern.used[k, m] = pattern.used[m, k] = False
        pattern.count[k] = 0


@njit(**INNER)
def mark_nonzero(pattern: Pattern, i: int, k: int) -> None:
    """Mark submatrix (i, k) as nonzero; the caller must mark (k, i), too."""
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
"""``of_submatrix(matrix, k)``: return the rows of submatrix number k."""


@njit(**INLINE)
def scaled(p: Submatrix, own: Inertia, factor: float) -> Submatrix:
    """Multiply the rows by a factor and the inverse masses of their element."""
    m, i = factor * own.inverse_mass, factor * own.inverse_inertia
    return Submatrix(m * p.xx, m * p.xz, m * p.xw, m * p.zx, m * p.zz, m * p.zw, i * p.wx, i * p.wz, i * p.ww)


@njit(**INLINE)
def times(p: Submatrix, v: Plane) -> Plane:
    """Return the product of a submatrix and a vector of three components."""
    x, z = (p.xx * v.x + p.xz * v.z) + p.xw * v.w, (p.zx * v.x + p.zz * v.z) + p.zw * v.w
    return Plane(x, z, (p.wx * v.x + p.wz * v.z) + p.ww * v.w)


@njit(**INLINE)
def product(p: Submatrix, q: Submatrix) -> Submatrix:
    """Return the product of two submatrices."""
    x, z = times(p, Plane(q.xx, q.zx, q.wx)), times(p, Plane(q.xz, q.zz, q.wz))
    w = times(p, Plane(q.xw, q.zw, q.ww))
    return Submatrix(x.x, z.x, w.x, x.z, z.z, w.z, x.w, z.w, w.w)


@njit(**INLINE)
def inverse_of(p: Submatrix) -> Submatrix:
    """Return the inverse of a submatrix, from cofactors and one division."""
    xx, xz, xw = p.zz * p.ww - p.zw * p.wz, p.xw * p.wz - p.xz * p.ww, p.xz * p.zw - p.xw * p.zz
    zx, zz, zw = p.zw * p.wx - p.zx * p.ww, p.xx * p.ww - p.xw * p.wx, p.xw * p.zx - p.xx * p.zw
    wx, wz, ww = p.zx * p.wz - p.zz * p.wx, p.xz * p.wx - p.xx * p.wz, p.xx * p.zz - p.xz * p.zx
    by = 1.0 / ((p.xx * xx + p.xz * zx) + p.xw * wx)
    return Submatrix(by * xx, by * xz, by * xw, by * zx, by * zz, by * zw, by * wx, by * wz, by * ww)


@njit(**INLINE)
def subtract_terms(submatrix: Any, j: int, fresh: bool, diagonal: float, p: Submatrix) -> None:
    """Subtract `p` from a submatrix; a `fresh` one starts as `diagonal` times the unit matrix."""
    one, old = diagonal, load(submatrix, j)
    store(submatrix, j, minus(Submatrix(
        one if fresh else old.xx, 0.0 if fresh else old.xz, 0.0 if fresh else old.xw,
        0.0 if fresh else old.zx, one if fresh else old.zz, 0.0 if fresh else old.zw,
        0.0 if fresh else old.wx, 0.0 if fresh else old.wz, one if fresh else old.ww,
    ), p))  # fmt: skip


@njit(**INLINE)
def enter_pair(into: Blocks, fresh: Any, j: int, c: Outer, half: float, a: Inertia, b: Inertia) -> None:
    """Add the terms of a pair to the matrix: the forces on its elements that depend on their velocities."""
    # The force on b is opposite to the one on a, and the relative velocity contains that of b with opposite sign.
    aa = Submatrix(c.xx, c.xz, c.xa, c.zx, c.zz, c.za, c.ax, c.az, c.aa)
    ab = Submatrix(c.xx, c.xz, c.xb, c.zx, c.zz, c.zb, c.ax, c.az, c.ab)
    ba = Submatrix(c.xx, c.xz, c.xa, c.zx, c.zz, c.za, c.bx, c.bz, c.ba)
    bb = Submatrix(c.xx, c.xz, c.xb, c.zx, c.zz, c.zb, c.bx, c.bz, c.bb)
    subtract_terms(into.aa, j, fresh[0], 1.0, scaled(aa, a, -half))
    subtract_terms(into.ab, j, fresh[1], 0.0, scaled(ab, a, half))
    subtract_terms(into.ba, j, fresh[1], 0.0, scaled(ba, b, half))
    subtract_terms(into.bb, j, fresh[2], 1.0, scaled(bb, b, -half))


@njit(**INLINE)
def enter_loads(on: Plane, by: Plane, c: PairAction, half: float, a: Inertia, b: Inertia) -> tuple[Plane, Plane]:
    """Return the right-hand sides of both elements of a pair, with its predicted forces added."""
    m, i, n, k = half * a.inverse_mass, half * a.inverse_inertia, half * b.inverse_mass, half * b.inverse_inertia
    return (
        Plane(on.x + m * c.x, on.z + m * c.z, on.w + i * c.moment_a),
        Plane(by.x - n * c.x, by.z - n * c.z, by.w - k * c.moment_b),
    )


@njit(**APART)
def invert(submatrix: Any) -> None:
    """Replace a submatrix by its inverse."""
    for j in range(rows.COLUMNS):
        store(submatrix, j, inverse_of(load(submatrix, j)))


@njit(**APART)
def divide(submatrix: Any, inverse: Any) -> None:
    """Multiply a submatrix from the right by the inverse of the pivot."""
    for j in range(rows.COLUMNS):
        store(submatrix, j, product(load(submatrix, j), load(inverse, j)))


@njit(**APART)
def eliminate(submatrix: Any, factor: Any, row: Any, fresh: bool) -> None:
    """Subtract factor × row from a submatrix; a `fresh` one starts as zero."""
    for j in range(rows.COLUMNS):
        subtract_terms(submatrix, j, fresh, 0.0, product(load(factor, j), load(row, j)))


@njit(**APART)
def subtract_product(target: Any, submatrix: Any, source: Any) -> None:
    """Subtract submatrix × (velocity change of `source`) from the velocity change of `target`."""
    for j in range(unknown(rows.COLUMNS)):
        v, w = rows.load_change(target, j), times(load(submatrix, j), rows.load_change(source, j))
        rows.store_change(target, j, Plane(v.x - w.x, v.z - w.z, v.w - w.w))


@njit(**APART)
def multiply_by_inverse(e: Any, inverse: Any) -> None:
    """Multiply the right-hand side of an element by the inverse of its pivot."""
    for j in range(rows.COLUMNS):
        rows.store_change(e, j, times(load(inverse, j), rows.load_change(e, j)))


@njit(**INNER)
def solve(state: Any, matrix: Any, pattern: Pattern, size: int) -> None:
    """Solve the equations for the velocity changes of all elements, which replace the right-hand sides.

    Submatrices outside the pattern are 0. In a stack each element shares a submatrix only with the next one, so that
    the work is proportional to the number of elements.
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
            subtract_product(rows.of_element(state, i), factor, rows.of_element(state, k))
            for o in range(count[k]):
                m = later[k, o]
                row = of_submatrix(matrix, k * size + m)
                eliminate(of_submatrix(matrix, i * size + m), factor, row, not used[i, m])
                if not used[i, m]:
                    mark_nonzero(pattern, i, m)
    for k in range(size - 1, -1, -1):
        if not used[k, k]:
            continue
        for n in range(count[k]):
            m = later[k, n]
            subtract_product(rows.of_element(state, k), of_submatrix(matrix, k * size + m), rows.of_element(state, m))
        multiply_by_inverse(rows.of_element(state, k), of_submatrix(matrix, k * size + k))


@njit(inline="always", **INNER)
def submatrix_or_spare(matrix: Any, moves: Any, i: int, k: int, spare: int) -> Any:
    """Return submatrix (i, k), or a spare one if either element moves with the base and thus has no equations."""
    return of_submatrix(matrix, i * moves.size + k if moves[i] and moves[k] else moves.size * moves.size + spare)


@njit(inline="always", **INNER)
def place(matrix: Any, pattern: Pattern, moves: Any, i: int, k: int) -> tuple[Blocks, Any]:
    """Return the submatrices of a pair, and True for each of aa, ab and bb that holds no terms yet."""
    used = pattern.used
    fresh = not used[i, i], not used[i, k], not used[k, k]
    used[i, i], used[k, k] = moves[i], moves[k]
    if moves[i] and moves[k] and not used[i, k]:
        mark_nonzero(pattern, i, k)
        mark_nonzero(pattern, k, i)
    aa, ab = submatrix_or_spare(matrix, moves, i, i, 0), submatrix_or_spare(matrix, moves, i, k, 1)
    return Blocks(aa, ab, submatrix_or_spare(matrix, moves, k, i, 2), submatrix_or_spare(matrix, moves, k, k, 3)), fresh
