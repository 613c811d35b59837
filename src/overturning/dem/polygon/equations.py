"""The equations of a step of the centred scheme: three for the change of velocity of each element that moves.

They are scaled by half the step and the inverse masses: 1 plus what the contacts add. Elimination goes by blocks of
3 × 3 in the order of the elements, without a pivot: the matrix is 1 plus something that only adds, but for sliding
ends, which stick before they take too much away.
"""

from functools import cache
from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE, OPTIONS, Rows
from overturning.dem.polygon import rows
from overturning.dem.polygon.state import Body, Outer, Plane


class Block(NamedTuple):
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


BLOCK: Final = Rows(rows.COLUMNS, Block)
BLOCK_SIZE: Final = BLOCK.size
load_block, store_block, _ = BLOCK.access(Block)


@njit(inline="always", **OPTIONS)
def of_block(matrix: Any, size: int, i: int, k: int) -> Any:
    """The rows of a block."""
    at = (i * size + k) * BLOCK_SIZE
    return matrix[at : at + BLOCK_SIZE]


@njit(**INLINE)
def part(c: Outer, on_a: bool, by_a: bool) -> Block:
    """Of a pair, what the velocities of one element add to the forces on one element, by its sign as if b were a."""
    xw, zw = (c.xa if by_a else c.xb), (c.za if by_a else c.zb)
    wx, wz = (c.ax if on_a else c.bx), (c.az if on_a else c.bz)
    of_a, of_b = (c.aa if by_a else c.ab), (c.ba if by_a else c.bb)
    return Block(c.xx, c.xz, xw, c.zx, c.zz, zw, wx, wz, of_a if on_a else of_b)


@njit(**INLINE)
def scaled(p: Block, body: Body, factor: float) -> Block:
    """Rows times a factor and the inverse masses of their element."""
    m, i = factor * body.inverse_mass, factor * body.inverse_inertia
    return Block(m * p.xx, m * p.xz, m * p.xw, m * p.zx, m * p.zz, m * p.zw, i * p.wx, i * p.wz, i * p.ww)


@njit(**INLINE)
def minus(p: Block, q: Block) -> Block:
    """Difference of two blocks."""
    return Block(
        p.xx - q.xx, p.xz - q.xz, p.xw - q.xw, p.zx - q.zx, p.zz - q.zz, p.zw - q.zw, p.wx - q.wx, p.wz - q.wz, p.ww - q.ww
    )  # fmt: skip


@njit(**INLINE)
def product(p: Block, q: Block) -> Block:
    """Product of two blocks."""
    return Block(
        (p.xx * q.xx + p.xz * q.zx) + p.xw * q.wx, (p.xx * q.xz + p.xz * q.zz) + p.xw * q.wz, (p.xx * q.xw + p.xz * q.zw) + p.xw * q.ww,
        (p.zx * q.xx + p.zz * q.zx) + p.zw * q.wx, (p.zx * q.xz + p.zz * q.zz) + p.zw * q.wz, (p.zx * q.xw + p.zz * q.zw) + p.zw * q.ww,
        (p.wx * q.xx + p.wz * q.zx) + p.ww * q.wx, (p.wx * q.xz + p.wz * q.zz) + p.ww * q.wz, (p.wx * q.xw + p.wz * q.zw) + p.ww * q.ww,
    )  # fmt: skip


@njit(**INLINE)
def times(p: Block, v: Plane) -> Plane:
    """A block times three numbers."""
    return Plane(
        (p.xx * v.x + p.xz * v.z) + p.xw * v.w, (p.zx * v.x + p.zz * v.z) + p.zw * v.w, (p.wx * v.x + p.wz * v.z) + p.ww * v.w
    )  # fmt: skip


@njit(**INLINE)
def inverse_of(p: Block) -> Block:
    """Inverse of a block, by cofactors and one division."""
    xx, xz, xw = p.zz * p.ww - p.zw * p.wz, p.xw * p.wz - p.xz * p.ww, p.xz * p.zw - p.xw * p.zz
    zx, zz, zw = p.zw * p.wx - p.zx * p.ww, p.xx * p.ww - p.xw * p.wx, p.xw * p.zx - p.xx * p.zw
    wx, wz, ww = p.zx * p.wz - p.zz * p.wx, p.xz * p.wx - p.xx * p.wz, p.xx * p.zz - p.xz * p.zx
    by = 1.0 / ((p.xx * xx + p.xz * zx) + p.xw * wx)
    return Block(by * xx, by * xz, by * xw, by * zx, by * zz, by * zw, by * wx, by * wz, by * ww)


@cache
def adder(on_a: bool, by_a: bool) -> Any:
    """Loop that adds a part of a pair's couple to its block of the matrix; `e` is the element that the forces act on."""

    @njit(**OPTIONS)
    def add(block: Any, q: Any, e: Any, own: Any) -> None:
        for j in range(rows.COLUMNS):
            c, body, case = rows.load_couple(q, j).outer, rows.load_body(e, j), rows.load_case(own, j)
            half = 0.5 * (case.step * case.attempt.length)
            # On the other element acts the opposite, and the opposite velocity counts.
            p = scaled(part(c, on_a, by_a), body, half if on_a != by_a else -half)
            store_block(block, j, minus(load_block(block, j), p))

    return add


add_aa, add_ab, add_ba, add_bb = adder(True, True), adder(True, False), adder(False, True), adder(False, False)


@njit(**OPTIONS)
def add_loads(q: Any, a: Any, b: Any, own: Any) -> None:
    """Add a pair's predicted forces to the right-hand sides."""
    for j in range(rows.COLUMNS):
        c, on, by, case = (
            rows.load_couple(q, j).load,
            rows.load_body(a, j),
            rows.load_body(b, j),
            rows.load_case(own, j),
        )
        half, d, e = 0.5 * (case.step * case.attempt.length), rows.load_change(a, j), rows.load_change(b, j)
        m, i = half * on.inverse_mass, half * on.inverse_inertia
        rows.store_change(a, j, Plane(d.x + m * c.x, d.z + m * c.z, d.w + i * c.moment_a))
        m, i = half * by.inverse_mass, half * by.inverse_inertia
        rows.store_change(b, j, Plane(e.x - m * c.x, e.z - m * c.z, e.w - i * c.moment_b))


@njit(**OPTIONS)
def clear(block: Any, diagonal: float) -> None:
    """A block with a number on its diagonal."""
    for j in range(rows.COLUMNS):
        store_block(block, j, Block(diagonal, 0.0, 0.0, 0.0, diagonal, 0.0, 0.0, 0.0, diagonal))


@njit(**OPTIONS)
def invert(block: Any) -> None:
    """Put the inverse in a block's place."""
    for j in range(rows.COLUMNS):
        store_block(block, j, inverse_of(load_block(block, j)))


@njit(**OPTIONS)
def divide(block: Any, inverse: Any) -> None:
    """Multiply a block by a pivot's inverse from the right."""
    for j in range(rows.COLUMNS):
        store_block(block, j, product(load_block(block, j), load_block(inverse, j)))


@njit(**OPTIONS)
def eliminate(block: Any, factor: Any, row: Any) -> None:
    """Take a factor times a block of the pivot's row off a block."""
    for j in range(rows.COLUMNS):
        store_block(block, j, minus(load_block(block, j), product(load_block(factor, j), load_block(row, j))))


@njit(**OPTIONS)
def carry(target: Any, block: Any, source: Any) -> None:
    """Take a block times an element's numbers off those of another element."""
    for j in range(rows.COLUMNS):
        v, w = rows.load_change(target, j), times(load_block(block, j), rows.load_change(source, j))
        rows.store_change(target, j, Plane(v.x - w.x, v.z - w.z, v.w - w.w))


@njit(**OPTIONS)
def finish_row(e: Any, inverse: Any) -> None:
    """An element's numbers times its pivot's inverse."""
    for j in range(rows.COLUMNS):
        rows.store_change(e, j, times(load_block(inverse, j), rows.load_change(e, j)))


@njit(**OPTIONS)
def solve(state: Any, matrix: Any, used: Any, size: int) -> None:
    """Solve for the changes of all elements' velocities, which take the place of the right-hand sides; blocks not `used` are 0."""
    for k in range(size):
        if not used[k, k]:
            continue
        pivot = of_block(matrix, size, k, k)
        invert(pivot)
        for i in range(k + 1, size):
            if not used[i, k]:
                continue
            factor = of_block(matrix, size, i, k)
            divide(factor, pivot)
            carry(rows.of_element(state, i), factor, rows.of_element(state, k))
            for m in range(k + 1, size):
                if used[k, m]:
                    use(matrix, used, size, i, m)
                    eliminate(of_block(matrix, size, i, m), factor, of_block(matrix, size, k, m))
    for k in range(size - 1, -1, -1):
        if not used[k, k]:
            continue
        for m in range(k + 1, size):
            if used[k, m]:
                carry(rows.of_element(state, k), of_block(matrix, size, k, m), rows.of_element(state, m))
        finish_row(rows.of_element(state, k), of_block(matrix, size, k, k))


@njit(**OPTIONS)
def use(matrix: Any, used: Any, size: int, i: int, k: int) -> None:
    """Clear a block that is used for the first time."""
    if not used[i, k]:
        used[i, k] = True
        clear(of_block(matrix, size, i, k), 1.0 if i == k else 0.0)


@njit(**OPTIONS)
def add_pair(state: Any, matrix: Any, used: Any, moves: Any, size: int, q: Any, i: int, k: int) -> None:
    """Add a pair's part to the equations; an element that moves with the base has none."""
    a, b = rows.of_element(state, i), rows.of_element(state, k)
    add_loads(q, a, b, state)
    if moves[i]:
        use(matrix, used, size, i, i)
        add_aa(of_block(matrix, size, i, i), q, a, state)
    if moves[k]:
        use(matrix, used, size, k, k)
        add_bb(of_block(matrix, size, k, k), q, b, state)
    if moves[i] and moves[k]:
        use(matrix, used, size, i, k)
        use(matrix, used, size, k, i)
        add_ab(of_block(matrix, size, i, k), q, a, state)
        add_ba(of_block(matrix, size, k, i), q, b, state)
