"""Linear equations of a step of the centred scheme: three for the velocity change of each moving element.

The equations are multiplied by half the step and the inverse masses, so that the matrix is the unit matrix plus the
terms of the contacts. Gaussian elimination works on 3 × 3 submatrices in the order of the elements, without pivoting:
the terms of sticking contacts are positive semidefinite, and a sliding point is made to stick before its terms could
make the matrix singular.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import (
    ALLOCATING_INLINE_OPTIONS,
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    TupleRowLayout,
    create_elementwise_tuple_functions,
    create_window_slicer,
    hide_number_from_llvm,
)
from overturning.dem.polygon import rows
from overturning.dem.polygon.mechanics import PairForce, PairVelocityToForceMatrix
from overturning.dem.polygon.state import ElementConstants, PlanarVector


class EquationSubmatrix(NamedTuple):
    """3 × 3 submatrix of the step's equations: rows are force components, columns velocities (x, z, rotation)."""

    xx: float
    xz: float
    xw: float
    zx: float
    zz: float
    zw: float
    wx: float
    wz: float
    ww: float


SUBMATRIX_ROW_LAYOUT: Final = TupleRowLayout(rows.PARALLEL_CASE_COUNT, EquationSubmatrix)
SUBMATRIX_SIZE: Final = SUBMATRIX_ROW_LAYOUT.size
load, store, _ = SUBMATRIX_ROW_LAYOUT.tuple_reader_and_writer(EquationSubmatrix)
minus = create_elementwise_tuple_functions(EquationSubmatrix).minus


class PairSubmatrices(NamedTuple):
    """Four equation submatrices of elements a and b; `ab`: force on a by the velocity of b, and so on."""

    aa: Any
    ab: Any
    ba: Any
    bb: Any


SPARE_SUBMATRIX_COUNT: Final = len(PairSubmatrices._fields)
"""Number of spare submatrices behind the matrix; they receive the terms of elements that move with the base."""


class NonzeroPattern(NamedTuple):
    """Pattern of nonzero submatrices in the equations: of touching elements, and those filled by the elimination."""

    is_nonzero: Any
    """True where a submatrix is nonzero, shape (elements, elements)."""
    later_coupled_elements: Any
    """Later elements that share a submatrix with each element, ascending, shape (elements, elements)."""
    later_coupled_counts: Any
    """Number of entries in each row of `later_coupled_elements`, shape (elements,)."""


@njit(**ALLOCATING_INLINE_OPTIONS)
def create_empty_nonzero_pattern(element_count: int) -> Any:
    """Return a pattern without nonzero submatrices for the equations of `element_count` elements."""
    return NonzeroPattern(
        np.zeros((element_count, element_count), np.bool_),
        np.zeros((element_count, element_count), np.int64),
        np.zeros(element_count, np.int64),
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def clear_nonzero_pattern(nonzero_pattern: NonzeroPattern) -> None:
    """Mark all submatrices of the equations as zero, in a time proportional to the number of nonzero ones."""
    for k in range(nonzero_pattern.later_coupled_counts.size):
        nonzero_pattern.is_nonzero[k, k] = False
        for n in range(nonzero_pattern.later_coupled_counts[k]):
            m = nonzero_pattern.later_coupled_elements[k, n]
            nonzero_pattern.is_nonzero[k, m] = nonzero_pattern.is_nonzero[m, k] = False
        nonzero_pattern.later_coupled_counts[k] = 0


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_submatrix_nonzero(nonzero_pattern: NonzeroPattern, row: int, column: int) -> None:
    """Mark equation submatrix (row, column) as nonzero; the caller must also mark submatrix (column, row)."""
    nonzero_pattern.is_nonzero[row, column] = True
    if row >= column:
        return
    n = nonzero_pattern.later_coupled_counts[row]
    while n > 0 and nonzero_pattern.later_coupled_elements[row, n - 1] > column:
        nonzero_pattern.later_coupled_elements[row, n] = nonzero_pattern.later_coupled_elements[row, n - 1]
        n -= 1
    nonzero_pattern.later_coupled_elements[row, n] = column
    nonzero_pattern.later_coupled_counts[row] += 1


submatrix_window: Final = create_window_slicer(SUBMATRIX_SIZE)
"""``of_submatrix(matrix, k)``: return the rows of submatrix number k."""


@njit(**INLINE_OPTIONS)
def scale_rows_by_inverse_mass(p: EquationSubmatrix, inertia: ElementConstants, factor: float) -> EquationSubmatrix:
    """Return submatrix `p` with its force rows × `factor`/mass and its moment row × `factor`/moment of inertia."""
    m, i = factor * inertia.inverse_mass, factor * inertia.inverse_inertia
    return EquationSubmatrix(m * p.xx, m * p.xz, m * p.xw, m * p.zx, m * p.zz, m * p.zw, i * p.wx, i * p.wz, i * p.ww)


@njit(**INLINE_OPTIONS)
def submatrix_times_vector(p: EquationSubmatrix, v: PlanarVector) -> PlanarVector:
    """Return the product of a 3 × 3 submatrix `p` and a vector `v`."""
    x, z = (p.xx * v.x + p.xz * v.z) + p.xw * v.w, (p.zx * v.x + p.zz * v.z) + p.zw * v.w
    return PlanarVector(x, z, (p.wx * v.x + p.wz * v.z) + p.ww * v.w)


@njit(**INLINE_OPTIONS)
def submatrix_product(p: EquationSubmatrix, q: EquationSubmatrix) -> EquationSubmatrix:
    """Return the product of two 3 × 3 submatrices of the equations."""
    x, z = (
        submatrix_times_vector(p, PlanarVector(q.xx, q.zx, q.wx)),
        submatrix_times_vector(p, PlanarVector(q.xz, q.zz, q.wz)),
    )
    w = submatrix_times_vector(p, PlanarVector(q.xw, q.zw, q.ww))
    return EquationSubmatrix(x.x, z.x, w.x, x.z, z.z, w.z, x.w, z.w, w.w)


@njit(**INLINE_OPTIONS)
def inverse_of_submatrix(p: EquationSubmatrix) -> EquationSubmatrix:
    """Return the inverse of a 3 × 3 submatrix of the equations, from cofactors and one division."""
    xx, xz, xw = p.zz * p.ww - p.zw * p.wz, p.xw * p.wz - p.xz * p.ww, p.xz * p.zw - p.xw * p.zz
    zx, zz, zw = p.zw * p.wx - p.zx * p.ww, p.xx * p.ww - p.xw * p.wx, p.xw * p.zx - p.xx * p.zw
    wx, wz, ww = p.zx * p.wz - p.zz * p.wx, p.xz * p.wx - p.xx * p.wz, p.xx * p.zz - p.xz * p.zx
    by = 1.0 / ((p.xx * xx + p.xz * zx) + p.xw * wx)
    return EquationSubmatrix(by * xx, by * xz, by * xw, by * zx, by * zz, by * zw, by * wx, by * wz, by * ww)


@njit(**INLINE_OPTIONS)
def subtract_terms_from_submatrix(
    submatrix: Any, lane: int, is_empty: bool, diagonal: float, terms: EquationSubmatrix
) -> None:
    """Subtract `terms` from a submatrix in column `lane`; an unset submatrix counts as `diagonal` × unit matrix."""
    one, old = diagonal, load(submatrix, lane)
    store(submatrix, lane, minus(EquationSubmatrix(
        one if is_empty else old.xx, 0.0 if is_empty else old.xz, 0.0 if is_empty else old.xw,
        0.0 if is_empty else old.zx, one if is_empty else old.zz, 0.0 if is_empty else old.zw,
        0.0 if is_empty else old.wx, 0.0 if is_empty else old.wz, one if is_empty else old.ww,
    ), terms))  # fmt: skip


@njit(**INLINE_OPTIONS)
def add_pair_matrix_to_submatrices(
    submatrices: PairSubmatrices,
    empty_flags: Any,
    lane: int,
    pair_matrix: PairVelocityToForceMatrix,
    half_step_time: float,
    inertia_a: ElementConstants,
    inertia_b: ElementConstants,
) -> None:
    """Add the contact matrix of elements a and b (velocities to forces) to their four equation submatrices."""
    # The force on b is opposite to the one on a, and the relative velocity contains that of b with opposite sign.
    m = pair_matrix
    xx, xz, zx, zz = (
        m.force_x_per_velocity_x, m.force_x_per_velocity_z, m.force_z_per_velocity_x, m.force_z_per_velocity_z,
    )  # fmt: skip
    xa, za, xb, zb = (
        m.force_x_per_rotation_a, m.force_z_per_rotation_a, m.force_x_per_rotation_b, m.force_z_per_rotation_b,
    )  # fmt: skip
    ax, az, bx, bz = (
        m.moment_a_per_velocity_x, m.moment_a_per_velocity_z, m.moment_b_per_velocity_x, m.moment_b_per_velocity_z,
    )  # fmt: skip
    aa = EquationSubmatrix(xx, xz, xa, zx, zz, za, ax, az, m.moment_a_per_rotation_a)
    ab = EquationSubmatrix(xx, xz, xb, zx, zz, zb, ax, az, m.moment_a_per_rotation_b)
    ba = EquationSubmatrix(xx, xz, xa, zx, zz, za, bx, bz, m.moment_b_per_rotation_a)
    bb = EquationSubmatrix(xx, xz, xb, zx, zz, zb, bx, bz, m.moment_b_per_rotation_b)
    subtract_terms_from_submatrix(
        submatrices.aa, lane, empty_flags[0], 1.0, scale_rows_by_inverse_mass(aa, inertia_a, -half_step_time)
    )
    subtract_terms_from_submatrix(
        submatrices.ab, lane, empty_flags[1], 0.0, scale_rows_by_inverse_mass(ab, inertia_a, half_step_time)
    )
    subtract_terms_from_submatrix(
        submatrices.ba, lane, empty_flags[1], 0.0, scale_rows_by_inverse_mass(ba, inertia_b, half_step_time)
    )
    subtract_terms_from_submatrix(
        submatrices.bb, lane, empty_flags[2], 1.0, scale_rows_by_inverse_mass(bb, inertia_b, -half_step_time)
    )


@njit(**INLINE_OPTIONS)
def add_pair_force_to_right_sides(
    right_side_a: PlanarVector,
    right_side_b: PlanarVector,
    pair_force: PairForce,
    half_step_time: float,
    inertia_a: ElementConstants,
    inertia_b: ElementConstants,
) -> tuple[PlanarVector, PlanarVector]:
    """Return the right-hand sides of elements a and b in the equations, with contact force `pair_force` added."""
    m, i, n, k = (
        half_step_time * inertia_a.inverse_mass,
        half_step_time * inertia_a.inverse_inertia,
        half_step_time * inertia_b.inverse_mass,
        half_step_time * inertia_b.inverse_inertia,
    )
    return (
        PlanarVector(
            right_side_a.x + m * pair_force.x,
            right_side_a.z + m * pair_force.z,
            right_side_a.w + i * pair_force.moment_a,
        ),
        PlanarVector(
            right_side_b.x - n * pair_force.x,
            right_side_b.z - n * pair_force.z,
            right_side_b.w - k * pair_force.moment_b,
        ),
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def invert_submatrix_in_place(submatrix: Any) -> None:
    """Replace a submatrix of the equations by its inverse, for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        store(submatrix, j, inverse_of_submatrix(load(submatrix, j)))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def multiply_by_pivot_inverse(submatrix: Any, pivot_inverse: Any) -> None:
    """Multiply a submatrix from the right by `pivot_inverse`, in place and for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        store(submatrix, j, submatrix_product(load(submatrix, j), load(pivot_inverse, j)))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def subtract_submatrix_product(submatrix: Any, factor: Any, pivot_row: Any, is_empty: bool) -> None:
    """Subtract the product of submatrices `factor` and `pivot_row` from a submatrix; an unset one counts as zero."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        subtract_terms_from_submatrix(
            submatrix, j, is_empty, 0.0, submatrix_product(load(factor, j), load(pivot_row, j))
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def subtract_coupled_velocity_change(target_rows: Any, submatrix: Any, source_rows: Any) -> None:
    """Subtract submatrix × (velocity change of the source element) from the velocity change of the target element."""
    for j in range(hide_number_from_llvm(rows.PARALLEL_CASE_COUNT)):
        v, w = (
            rows.load_change(target_rows, j),
            submatrix_times_vector(load(submatrix, j), rows.load_change(source_rows, j)),
        )
        rows.store_change(target_rows, j, PlanarVector(v.x - w.x, v.z - w.z, v.w - w.w))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def multiply_right_side_by_pivot_inverse(element_rows: Any, pivot_inverse: Any) -> None:
    """Replace an element's right-hand side by its velocity change: multiply by the inverse of its pivot submatrix."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        rows.store_change(
            element_rows, j, submatrix_times_vector(load(pivot_inverse, j), rows.load_change(element_rows, j))
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def solve_velocity_changes(state: Any, matrix: Any, nonzero_pattern: NonzeroPattern, element_count: int) -> None:
    """Solve the equations of a step by elimination; velocity changes of the elements replace the right-hand sides.

    Submatrices outside the pattern are 0. In a stack each element shares a submatrix only with the next one, so that
    the work is proportional to the number of elements.
    """
    used, later, count = (
        nonzero_pattern.is_nonzero,
        nonzero_pattern.later_coupled_elements,
        nonzero_pattern.later_coupled_counts,
    )
    for k in range(element_count):
        if not used[k, k]:
            continue
        pivot = submatrix_window(matrix, k * element_count + k)
        invert_submatrix_in_place(pivot)
        for n in range(count[k]):
            i = later[k, n]
            factor = submatrix_window(matrix, i * element_count + k)
            multiply_by_pivot_inverse(factor, pivot)
            subtract_coupled_velocity_change(rows.element_window(state, i), factor, rows.element_window(state, k))
            for o in range(count[k]):
                m = later[k, o]
                row = submatrix_window(matrix, k * element_count + m)
                subtract_submatrix_product(submatrix_window(matrix, i * element_count + m), factor, row, not used[i, m])
                if not used[i, m]:
                    mark_submatrix_nonzero(nonzero_pattern, i, m)
    for k in range(element_count - 1, -1, -1):
        if not used[k, k]:
            continue
        for n in range(count[k]):
            m = later[k, n]
            subtract_coupled_velocity_change(
                rows.element_window(state, k),
                submatrix_window(matrix, k * element_count + m),
                rows.element_window(state, m),
            )
        multiply_right_side_by_pivot_inverse(
            rows.element_window(state, k), submatrix_window(matrix, k * element_count + k)
        )


@njit(inline="always", **INTERNAL_COMPILE_OPTIONS)
def equation_submatrix_or_placeholder(
    matrix: Any, equation_flags: Any, row: int, column: int, spare_number: int
) -> Any:
    """Return equation submatrix (`row`, `column`), or an unused one if either element has no unknown velocity.

    Elements that are driven or held have none.
    """
    return submatrix_window(
        matrix,
        row * equation_flags.size + column
        if equation_flags[row] and equation_flags[column]
        else equation_flags.size * equation_flags.size + spare_number,
    )


@njit(inline="always", **INTERNAL_COMPILE_OPTIONS)
def mark_nonzero_and_return_pair_submatrices(
    matrix: Any, nonzero_pattern: NonzeroPattern, equation_flags: Any, element_a: int, element_b: int
) -> tuple[PairSubmatrices, Any]:
    """Return the four equation submatrices of elements a and b, marked as nonzero, and flags of those unset before."""
    used = nonzero_pattern.is_nonzero
    fresh = not used[element_a, element_a], not used[element_a, element_b], not used[element_b, element_b]
    used[element_a, element_a], used[element_b, element_b] = equation_flags[element_a], equation_flags[element_b]
    if equation_flags[element_a] and equation_flags[element_b] and not used[element_a, element_b]:
        mark_submatrix_nonzero(nonzero_pattern, element_a, element_b)
        mark_submatrix_nonzero(nonzero_pattern, element_b, element_a)
    aa, ab = (
        equation_submatrix_or_placeholder(matrix, equation_flags, element_a, element_a, 0),
        equation_submatrix_or_placeholder(matrix, equation_flags, element_a, element_b, 1),
    )
    return PairSubmatrices(
        aa,
        ab,
        equation_submatrix_or_placeholder(matrix, equation_flags, element_b, element_a, 2),
        equation_submatrix_or_placeholder(matrix, equation_flags, element_b, element_b, 3),
    ), fresh
