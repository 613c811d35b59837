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
from overturning.dem.polygon.state import ElementConstants, PlanarMotionOrForce


class EquationSubmatrix(NamedTuple):
    """3 × 3 submatrix of a step's equations: a row per equation of motion, a column per velocity (x, z, rotation)."""

    row_x_column_x: float
    row_x_column_z: float
    row_x_column_rotation: float
    row_z_column_x: float
    row_z_column_z: float
    row_z_column_rotation: float
    row_rotation_column_x: float
    row_rotation_column_z: float
    row_rotation_column_rotation: float


SUBMATRIX_ROW_LAYOUT: Final = TupleRowLayout(rows.PARALLEL_CASE_COUNT, EquationSubmatrix)
FLOATS_PER_SUBMATRIX_OF_ALL_CASES: Final = SUBMATRIX_ROW_LAYOUT.size
load, store, _ = SUBMATRIX_ROW_LAYOUT.tuple_reader_and_writer(EquationSubmatrix)
subtract_submatrix_elementwise = create_elementwise_tuple_functions(EquationSubmatrix).minus


class PairSubmatrices(NamedTuple):
    """Four equation submatrices of elements a and b, each for the forces on one of them by the velocity of one."""

    force_on_a_by_velocity_of_a: Any
    force_on_a_by_velocity_of_b: Any
    force_on_b_by_velocity_of_a: Any
    force_on_b_by_velocity_of_b: Any


PLACEHOLDER_SUBMATRIX_COUNT: Final = len(PairSubmatrices._fields)
"""Number of spare submatrices behind the matrix; they receive the terms of elements that move with the base."""


class NonzeroPattern(NamedTuple):
    """Pattern of nonzero submatrices in the equations: of touching elements, and those filled by the elimination."""

    is_nonzero: Any
    """True where a submatrix is nonzero, shape (elements, elements)."""
    later_coupled_element_indices: Any
    """Later elements that share a submatrix with each element, ascending, shape (elements, elements)."""
    later_coupled_element_counts: Any
    """Number of entries in each row of `later_coupled_element_indices`, shape (elements,)."""


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
    for k in range(nonzero_pattern.later_coupled_element_counts.size):
        nonzero_pattern.is_nonzero[k, k] = False
        for n in range(nonzero_pattern.later_coupled_element_counts[k]):
            m = nonzero_pattern.later_coupled_element_indices[k, n]
            nonzero_pattern.is_nonzero[k, m] = nonzero_pattern.is_nonzero[m, k] = False
        nonzero_pattern.later_coupled_element_counts[k] = 0


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_submatrix_nonzero(nonzero_pattern: NonzeroPattern, row: int, column: int) -> None:
    """Mark equation submatrix (row, column) as nonzero; the caller must also mark submatrix (column, row)."""
    nonzero_pattern.is_nonzero[row, column] = True
    if row >= column:
        return
    n = nonzero_pattern.later_coupled_element_counts[row]
    while n > 0 and nonzero_pattern.later_coupled_element_indices[row, n - 1] > column:
        nonzero_pattern.later_coupled_element_indices[row, n] = nonzero_pattern.later_coupled_element_indices[
            row, n - 1
        ]
        n -= 1
    nonzero_pattern.later_coupled_element_indices[row, n] = column
    nonzero_pattern.later_coupled_element_counts[row] += 1


slice_submatrix_rows: Final = create_window_slicer(FLOATS_PER_SUBMATRIX_OF_ALL_CASES)
"""``slice_submatrix_rows(matrix, k)``: return the rows of submatrix number k."""


@njit(**INLINE_OPTIONS)
def scale_rows_by_inverse_mass(p: EquationSubmatrix, inertia: ElementConstants, factor: float) -> EquationSubmatrix:
    """Return submatrix `p` with its force rows × `factor`/mass and its moment row × `factor`/moment of inertia."""
    m, i = factor * inertia.inverse_mass, factor * inertia.inverse_inertia
    xx, xz, xw, zx, zz, zw, wx, wz, ww = p
    return EquationSubmatrix(m * xx, m * xz, m * xw, m * zx, m * zz, m * zw, i * wx, i * wz, i * ww)


@njit(**INLINE_OPTIONS)
def submatrix_times_vector(p: EquationSubmatrix, v: PlanarMotionOrForce) -> PlanarMotionOrForce:
    """Return the product of a 3 × 3 submatrix `p` and a vector `v`."""
    xx, xz, xw, zx, zz, zw, wx, wz, ww = p
    x, z = (xx * v.x + xz * v.z) + xw * v.angular, (zx * v.x + zz * v.z) + zw * v.angular
    return PlanarMotionOrForce(x, z, (wx * v.x + wz * v.z) + ww * v.angular)


@njit(**INLINE_OPTIONS)
def submatrix_product(p: EquationSubmatrix, q: EquationSubmatrix) -> EquationSubmatrix:
    """Return the product of two 3 × 3 submatrices of the equations."""
    xx, xz, xw, zx, zz, zw, wx, wz, ww = q
    x, z = (
        submatrix_times_vector(p, PlanarMotionOrForce(xx, zx, wx)),
        submatrix_times_vector(p, PlanarMotionOrForce(xz, zz, wz)),
    )
    w = submatrix_times_vector(p, PlanarMotionOrForce(xw, zw, ww))
    return EquationSubmatrix(x.x, z.x, w.x, x.z, z.z, w.z, x.angular, z.angular, w.angular)


@njit(**INLINE_OPTIONS)
def inverse_of_submatrix(p: EquationSubmatrix) -> EquationSubmatrix:
    """Return the inverse of a 3 × 3 submatrix of the equations, from cofactors and one division."""
    pxx, pxz, pxw, pzx, pzz, pzw, pwx, pwz, pww = p
    xx, xz, xw = pzz * pww - pzw * pwz, pxw * pwz - pxz * pww, pxz * pzw - pxw * pzz
    zx, zz, zw = pzw * pwx - pzx * pww, pxx * pww - pxw * pwx, pxw * pzx - pxx * pzw
    wx, wz, ww = pzx * pwz - pzz * pwx, pxz * pwx - pxx * pwz, pxx * pzz - pxz * pzx
    by = 1.0 / ((pxx * xx + pxz * zx) + pxw * wx)
    return EquationSubmatrix(by * xx, by * xz, by * xw, by * zx, by * zz, by * zw, by * wx, by * wz, by * ww)


@njit(**INLINE_OPTIONS)
def subtract_terms_from_submatrix(
    submatrix: Any, lane: int, is_empty: bool, diagonal: float, terms: EquationSubmatrix
) -> None:
    """Subtract `terms` from a submatrix in column `lane`; an unset submatrix counts as `diagonal` × unit matrix."""
    one = diagonal
    xx, xz, xw, zx, zz, zw, wx, wz, ww = load(submatrix, lane)
    store(submatrix, lane, subtract_submatrix_elementwise(EquationSubmatrix(
        one if is_empty else xx, 0.0 if is_empty else xz, 0.0 if is_empty else xw,
        0.0 if is_empty else zx, one if is_empty else zz, 0.0 if is_empty else zw,
        0.0 if is_empty else wx, 0.0 if is_empty else wz, one if is_empty else ww,
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
        m.force_x_per_angular_velocity_a, m.force_z_per_angular_velocity_a,
        m.force_x_per_angular_velocity_b, m.force_z_per_angular_velocity_b,
    )  # fmt: skip
    ax, az, bx, bz = (
        m.moment_a_per_velocity_x, m.moment_a_per_velocity_z, m.moment_b_per_velocity_x, m.moment_b_per_velocity_z,
    )  # fmt: skip
    aa = EquationSubmatrix(xx, xz, xa, zx, zz, za, ax, az, m.moment_a_per_angular_velocity_a)
    ab = EquationSubmatrix(xx, xz, xb, zx, zz, zb, ax, az, m.moment_a_per_angular_velocity_b)
    ba = EquationSubmatrix(xx, xz, xa, zx, zz, za, bx, bz, m.moment_b_per_angular_velocity_a)
    bb = EquationSubmatrix(xx, xz, xb, zx, zz, zb, bx, bz, m.moment_b_per_angular_velocity_b)
    subtract_terms_from_submatrix(
        submatrices.force_on_a_by_velocity_of_a,
        lane,
        empty_flags[0],
        1.0,
        scale_rows_by_inverse_mass(aa, inertia_a, -half_step_time),
    )
    subtract_terms_from_submatrix(
        submatrices.force_on_a_by_velocity_of_b,
        lane,
        empty_flags[1],
        0.0,
        scale_rows_by_inverse_mass(ab, inertia_a, half_step_time),
    )
    subtract_terms_from_submatrix(
        submatrices.force_on_b_by_velocity_of_a,
        lane,
        empty_flags[1],
        0.0,
        scale_rows_by_inverse_mass(ba, inertia_b, half_step_time),
    )
    subtract_terms_from_submatrix(
        submatrices.force_on_b_by_velocity_of_b,
        lane,
        empty_flags[2],
        1.0,
        scale_rows_by_inverse_mass(bb, inertia_b, -half_step_time),
    )


@njit(**INLINE_OPTIONS)
def add_pair_force_to_right_sides(
    right_side_a: PlanarMotionOrForce,
    right_side_b: PlanarMotionOrForce,
    pair_force: PairForce,
    half_step_time: float,
    inertia_a: ElementConstants,
    inertia_b: ElementConstants,
) -> tuple[PlanarMotionOrForce, PlanarMotionOrForce]:
    """Return the right-hand sides of elements a and b in the equations, with contact force `pair_force` added."""
    m, i, n, k = (
        half_step_time * inertia_a.inverse_mass,
        half_step_time * inertia_a.inverse_inertia,
        half_step_time * inertia_b.inverse_mass,
        half_step_time * inertia_b.inverse_inertia,
    )
    return (
        PlanarMotionOrForce(
            right_side_a.x + m * pair_force.force_on_a_x,
            right_side_a.z + m * pair_force.force_on_a_z,
            right_side_a.angular + i * pair_force.moment_of_force_on_a_about_a,
        ),
        PlanarMotionOrForce(
            right_side_b.x - n * pair_force.force_on_a_x,
            right_side_b.z - n * pair_force.force_on_a_z,
            right_side_b.angular - k * pair_force.moment_of_force_on_a_about_b,
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
        rows.store_change(target_rows, j, PlanarMotionOrForce(v.x - w.x, v.z - w.z, v.angular - w.angular))


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
        nonzero_pattern.later_coupled_element_indices,
        nonzero_pattern.later_coupled_element_counts,
    )
    for k in range(element_count):
        if not used[k, k]:
            continue
        pivot = slice_submatrix_rows(matrix, k * element_count + k)
        invert_submatrix_in_place(pivot)
        for n in range(count[k]):
            i = later[k, n]
            factor = slice_submatrix_rows(matrix, i * element_count + k)
            multiply_by_pivot_inverse(factor, pivot)
            subtract_coupled_velocity_change(
                rows.slice_element_rows(state, i), factor, rows.slice_element_rows(state, k)
            )
            for o in range(count[k]):
                m = later[k, o]
                row = slice_submatrix_rows(matrix, k * element_count + m)
                subtract_submatrix_product(
                    slice_submatrix_rows(matrix, i * element_count + m), factor, row, not used[i, m]
                )
                if not used[i, m]:
                    mark_submatrix_nonzero(nonzero_pattern, i, m)
    for k in range(element_count - 1, -1, -1):
        if not used[k, k]:
            continue
        for n in range(count[k]):
            m = later[k, n]
            subtract_coupled_velocity_change(
                rows.slice_element_rows(state, k),
                slice_submatrix_rows(matrix, k * element_count + m),
                rows.slice_element_rows(state, m),
            )
        multiply_right_side_by_pivot_inverse(
            rows.slice_element_rows(state, k), slice_submatrix_rows(matrix, k * element_count + k)
        )


@njit(inline="always", **INTERNAL_COMPILE_OPTIONS)
def equation_submatrix_or_placeholder(
    matrix: Any, moves_relative_to_base: Any, row: int, column: int, spare_number: int
) -> Any:
    """Return equation submatrix (`row`, `column`), or an unused one if either element moves with the base.

    Such an element has no equations.
    """
    return slice_submatrix_rows(
        matrix,
        row * moves_relative_to_base.size + column
        if moves_relative_to_base[row] and moves_relative_to_base[column]
        else moves_relative_to_base.size * moves_relative_to_base.size + spare_number,
    )


@njit(inline="always", **INTERNAL_COMPILE_OPTIONS)
def mark_nonzero_and_return_pair_submatrices(
    matrix: Any, nonzero_pattern: NonzeroPattern, moves_relative_to_base: Any, element_a: int, element_b: int
) -> tuple[PairSubmatrices, Any]:
    """Return the four equation submatrices of elements a and b, marked as nonzero, and flags of those unset before."""
    used = nonzero_pattern.is_nonzero
    fresh = not used[element_a, element_a], not used[element_a, element_b], not used[element_b, element_b]
    used[element_a, element_a], used[element_b, element_b] = (
        moves_relative_to_base[element_a],
        moves_relative_to_base[element_b],
    )
    if moves_relative_to_base[element_a] and moves_relative_to_base[element_b] and not used[element_a, element_b]:
        mark_submatrix_nonzero(nonzero_pattern, element_a, element_b)
        mark_submatrix_nonzero(nonzero_pattern, element_b, element_a)
    aa, ab = (
        equation_submatrix_or_placeholder(matrix, moves_relative_to_base, element_a, element_a, 0),
        equation_submatrix_or_placeholder(matrix, moves_relative_to_base, element_a, element_b, 1),
    )
    return PairSubmatrices(
        aa,
        ab,
        equation_submatrix_or_placeholder(matrix, moves_relative_to_base, element_b, element_a, 2),
        equation_submatrix_or_placeholder(matrix, moves_relative_to_base, element_b, element_b, 3),
    ), fresh
