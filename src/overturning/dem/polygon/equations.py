"""The equations of a step of the centred scheme: three for the change of velocity of each element that moves.

They are scaled by half the step and the inverse masses: 1 plus what the contacts add. Elimination goes by submatrices
of 3 × 3 in the order of the elements, without a pivot: the matrix is 1 plus something that only adds, but for sliding
ends, which stick before they take too much away.
"""

from functools import cache
from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE, INNER, Rows, arithmetic
from overturning.dem.polygon import rows
from overturning.dem.polygon.mechanics import Outer
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


@njit(inline="always", **INNER)
def of_submatrix(matrix: Any, size: int, i: int, k: int) -> Any:
    """The rows of a submatrix."""
    at = (i * size + k) * SIZE
    return matrix[at : at + SIZE]


@njit(**INLINE)
def part(c: Outer, on_a: bool, by_a: bool) -> Submatrix:
    """Of a pair, what the velocities of one element add to the forces on one element, by its sign as if b were a."""
    xw, zw = (c.xa if by_a else c.xb), (c.za if by_a else c.zb)
    wx, wz = (c.ax if on_a else c.bx), (c.az if on_a else c.bz)
    of_a, of_b = (c.aa if by_a else c.ab), (c.ba if by_a else c.bb)
    return Submatrix(c.xx, c.xz, xw, c.zx, c.zz, zw, wx, wz, of_a if on_a else of_b)


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


@cache
def adder(on_a: bool, by_a: bool) -> Any:
    """Loop that adds a part of a pair's couple to its submatrix; `e` is the element that the forces act on."""

    @njit(**INNER)
    def add(submatrix: Any, q: Any, e: Any, own: Any) -> None:
        for j in range(rows.COLUMNS):
            c, body, case = rows.load_couple(q, j).outer, rows.load_inertia(e, j), rows.load_case(own, j)
            half = 0.5 * (case.step * case.attempt.length)
            # On the other element acts the opposite, and the opposite velocity counts.
            p = scaled(part(c, on_a, by_a), body, half if on_a != by_a else -half)
            store(submatrix, j, minus(load(submatrix, j), p))

    return add


add_aa, add_ab, add_ba, add_bb = adder(True, True), adder(True, False), adder(False, True), adder(False, False)


@njit(**INNER)
def add_loads(q: Any, a: Any, b: Any, own: Any) -> None:
    """Add a pair's predicted forces to the right-hand sides."""
    for j in range(rows.COLUMNS):
        c, case, on, by = (
            rows.load_couple(q, j).load,
            rows.load_case(own, j),
            rows.load_change(a, j),
            rows.load_change(b, j),
        )
        half, first, second = 0.5 * (case.step * case.attempt.length), rows.load_inertia(a, j), rows.load_inertia(b, j)
        m, i = half * first.inverse_mass, half * first.inverse_inertia
        rows.store_change(a, j, Plane(on.x + m * c.x, on.z + m * c.z, on.w + i * c.moment_a))
        m, i = half * second.inverse_mass, half * second.inverse_inertia
        rows.store_change(b, j, Plane(by.x - m * c.x, by.z - m * c.z, by.w - i * c.moment_b))


@njit(**INNER)
def clear(submatrix: Any, diagonal: float) -> None:
    """A submatrix with a number on its diagonal."""
    for j in range(rows.COLUMNS):
        store(submatrix, j, Submatrix(diagonal, 0.0, 0.0, 0.0, diagonal, 0.0, 0.0, 0.0, diagonal))


@njit(**INNER)
def invert(submatrix: Any) -> None:
    """Put the inverse in a submatrix' place."""
    for j in range(rows.COLUMNS):
        store(submatrix, j, inverse_of(load(submatrix, j)))


@njit(**INNER)
def divide(submatrix: Any, inverse: Any) -> None:
    """Multiply a submatrix by a pivot's inverse from the right."""
    for j in range(rows.COLUMNS):
        store(submatrix, j, product(load(submatrix, j), load(inverse, j)))


@njit(**INNER)
def eliminate(submatrix: Any, factor: Any, row: Any) -> None:
    """Take a factor times a submatrix of the pivot's row off a submatrix."""
    for j in range(rows.COLUMNS):
        store(submatrix, j, minus(load(submatrix, j), product(load(factor, j), load(row, j))))


@njit(**INNER)
def carry(target: Any, submatrix: Any, source: Any) -> None:
    """Take a submatrix times an element's numbers off those of another element."""
    for j in range(rows.COLUMNS):
        v, w = rows.load_change(target, j), times(load(submatrix, j), rows.load_change(source, j))
        rows.store_change(target, j, Plane(v.x - w.x, v.z - w.z, v.w - w.w))


@njit(**INNER)
def finish_row(e: Any, inverse: Any) -> None:
    """An element's numbers times its pivot's inverse."""
    for j in range(rows.COLUMNS):
        rows.store_change(e, j, times(load(inverse, j), rows.load_change(e, j)))


@njit(**INNER)
def solve(state: Any, matrix: Any, used: Any, size: int) -> None:
    """Solve for the changes of all elements' velocities, which take the place of the right-hand sides.

    Submatrices that are not `used` are 0.
    """
    for k in range(size):
        if not used[k, k]:
            continue
        pivot = of_submatrix(matrix, size, k, k)
        invert(pivot)
        for i in range(k + 1, size):
            if not used[i, k]:
                continue
            factor = of_submatrix(matrix, size, i, k)
            divide(factor, pivot)
            carry(rows.of_element(state, i), factor, rows.of_element(state, k))
            for m in range(k + 1, size):
                if used[k, m]:
                    use(matrix, used, size, i, m)
                    eliminate(of_submatrix(matrix, size, i, m), factor, of_submatrix(matrix, size, k, m))
    for k in range(size - 1, -1, -1):
        if not used[k, k]:
            continue
        for m in range(k + 1, size):
            if used[k, m]:
                carry(rows.of_element(state, k), of_submatrix(matrix, size, k, m), rows.of_element(state, m))
        finish_row(rows.of_element(state, k), of_submatrix(matrix, size, k, k))


@njit(**INNER)
def use(matrix: Any, used: Any, size: int, i: int, k: int) -> None:
    """Clear a submatrix that is used for the first time."""
    if not used[i, k]:
        used[i, k] = True
        clear(of_submatrix(matrix, size, i, k), 1.0 if i == k else 0.0)


@njit(**INNER)
def add_pair(state: Any, matrix: Any, used: Any, moves: Any, size: int, q: Any, i: int, k: int) -> None:
    """Add a pair's part to the equations; an element that moves with the base has none."""
    a, b = rows.of_element(state, i), rows.of_element(state, k)
    add_loads(q, a, b, state)
    if moves[i]:
        use(matrix, used, size, i, i)
        add_aa(of_submatrix(matrix, size, i, i), q, a, state)
    if moves[k]:
        use(matrix, used, size, k, k)
        add_bb(of_submatrix(matrix, size, k, k), q, b, state)
    if moves[i] and moves[k]:
        use(matrix, used, size, i, k)
        use(matrix, used, size, k, i)
        add_ab(of_submatrix(matrix, size, i, k), q, a, state)
        add_ba(of_submatrix(matrix, size, k, i), q, b, state)
