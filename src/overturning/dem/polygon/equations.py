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
)
from overturning.dem.polygon import rows
from overturning.dem.polygon.mechanics import PairForce, PairVelocityToForceMatrix
from overturning.dem.polygon.state import ElementConstants, PlanarMotionOrForce
from overturning.dem.polygon.submatrices import (
    EquationSubmatrix,
    invert_submatrix_in_place,
    multiply_right_side_by_pivot_inverse,
    right_multiply_submatrix_by_pivot_inverse,
    scale_by_half_step_over_mass_and_inertia,
    slice_submatrix_rows,
    subtract_coupled_velocity_change,
    subtract_submatrix_product,
    subtract_terms_from_submatrix,
)


class PairSubmatrices(NamedTuple):
    """Four equation submatrices of elements a and b: force on a or b (row) by the velocity of a or b (column)."""

    submatrix_in_row_of_a_and_column_of_a: Any
    submatrix_in_row_of_a_and_column_of_b: Any
    submatrix_in_row_of_b_and_column_of_a: Any
    submatrix_in_row_of_b_and_column_of_b: Any


IGNORED_BASE_SUBMATRIX_COUNT: Final = len(PairSubmatrices._fields)
"""Number of spare submatrices behind the matrix; they receive the terms of elements that move with the base."""


class NonzeroSubmatrixPattern(NamedTuple):
    """Pattern of nonzero submatrices in the equations: of touching elements, and those filled by the elimination."""

    is_submatrix_nonzero: Any
    """True where a submatrix is nonzero, shape (elements, elements)."""
    coupled_higher_index_elements: Any
    """Later elements that share a submatrix with each element, ascending, shape (elements, elements)."""
    coupled_higher_index_element_counts: Any
    """Number of entries in each row of `coupled_higher_index_elements`, shape (elements,)."""


@njit(**ALLOCATING_INLINE_OPTIONS)
def create_empty_nonzero_pattern(element_count: int) -> Any:
    """Return a pattern without nonzero submatrices for the equations of `element_count` elements."""
    return NonzeroSubmatrixPattern(
        np.zeros((element_count, element_count), np.bool_),
        np.zeros((element_count, element_count), np.int64),
        np.zeros(element_count, np.int64),
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def clear_nonzero_pattern(nonzero_pattern: NonzeroSubmatrixPattern) -> None:
    """Mark all submatrices of the equations as zero, in a time proportional to the number of nonzero ones."""
    for k in range(nonzero_pattern.coupled_higher_index_element_counts.size):
        nonzero_pattern.is_submatrix_nonzero[k, k] = False
        for n in range(nonzero_pattern.coupled_higher_index_element_counts[k]):
            m = nonzero_pattern.coupled_higher_index_elements[k, n]
            nonzero_pattern.is_submatrix_nonzero[k, m] = nonzero_pattern.is_submatrix_nonzero[m, k] = False
        nonzero_pattern.coupled_higher_index_element_counts[k] = 0


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_submatrix_nonzero(
    nonzero_pattern: NonzeroSubmatrixPattern, row_element_index: int, column_element_index: int
) -> None:
    """Mark equation submatrix (row, column) as nonzero; the caller must also mark submatrix (column, row)."""
    nonzero_pattern.is_submatrix_nonzero[row_element_index, column_element_index] = True
    if row_element_index >= column_element_index:
        return
    n = nonzero_pattern.coupled_higher_index_element_counts[row_element_index]
    while n > 0 and nonzero_pattern.coupled_higher_index_elements[row_element_index, n - 1] > column_element_index:
        nonzero_pattern.coupled_higher_index_elements[row_element_index, n] = (
            nonzero_pattern.coupled_higher_index_elements[row_element_index, n - 1]
        )
        n -= 1
    nonzero_pattern.coupled_higher_index_elements[row_element_index, n] = column_element_index
    nonzero_pattern.coupled_higher_index_element_counts[row_element_index] += 1


@njit(**INLINE_OPTIONS)
def add_pair_contact_matrix_to_equation_submatrices(
    pair_equation_submatrices: PairSubmatrices,
    unset_flags_of_submatrices_aa_ab_bb: Any,
    lane: int,
    pair_matrix: PairVelocityToForceMatrix,
    half_step_time: float,
    constants_of_a: ElementConstants,
    constants_of_b: ElementConstants,
) -> None:
    """Add the contact matrix of elements a and b (velocities to forces) to their four equation submatrices."""
    # The force on b is opposite to the one on a, and the relative velocity contains that of b with opposite sign.
    m = pair_matrix
    xx, xz, zx, zz = (
        m.force_on_a_x_per_relative_velocity_x, m.force_on_a_x_per_relative_velocity_z,
        m.force_on_a_z_per_relative_velocity_x, m.force_on_a_z_per_relative_velocity_z,
    )  # fmt: skip
    xa, za, xb, zb = (
        m.force_on_a_x_per_angular_velocity_a, m.force_on_a_z_per_angular_velocity_a,
        m.force_on_a_x_per_negated_angular_velocity_b, m.force_on_a_z_per_negated_angular_velocity_b,
    )  # fmt: skip
    ax, az, bx, bz = (
        m.moment_on_a_per_relative_velocity_x, m.moment_on_a_per_relative_velocity_z,
        m.moment_on_b_per_relative_velocity_x,
        m.moment_on_b_per_relative_velocity_z,
    )  # fmt: skip
    aa = EquationSubmatrix(xx, xz, xa, zx, zz, za, ax, az, m.moment_on_a_per_angular_velocity_a)
    ab = EquationSubmatrix(xx, xz, xb, zx, zz, zb, ax, az, m.moment_on_a_per_negated_angular_velocity_b)
    ba = EquationSubmatrix(xx, xz, xa, zx, zz, za, bx, bz, m.moment_on_b_per_angular_velocity_a)
    bb = EquationSubmatrix(xx, xz, xb, zx, zz, zb, bx, bz, m.moment_on_b_per_negated_angular_velocity_b)
    subtract_terms_from_submatrix(
        pair_equation_submatrices.submatrix_in_row_of_a_and_column_of_a,
        lane,
        unset_flags_of_submatrices_aa_ab_bb[0],
        1.0,
        scale_by_half_step_over_mass_and_inertia(aa, constants_of_a, -half_step_time),
    )
    subtract_terms_from_submatrix(
        pair_equation_submatrices.submatrix_in_row_of_a_and_column_of_b,
        lane,
        unset_flags_of_submatrices_aa_ab_bb[1],
        0.0,
        scale_by_half_step_over_mass_and_inertia(ab, constants_of_a, half_step_time),
    )
    subtract_terms_from_submatrix(
        pair_equation_submatrices.submatrix_in_row_of_b_and_column_of_a,
        lane,
        unset_flags_of_submatrices_aa_ab_bb[1],
        0.0,
        scale_by_half_step_over_mass_and_inertia(ba, constants_of_b, half_step_time),
    )
    subtract_terms_from_submatrix(
        pair_equation_submatrices.submatrix_in_row_of_b_and_column_of_b,
        lane,
        unset_flags_of_submatrices_aa_ab_bb[2],
        1.0,
        scale_by_half_step_over_mass_and_inertia(bb, constants_of_b, -half_step_time),
    )


@njit(**INLINE_OPTIONS)
def right_hand_sides_with_pair_force_added(
    right_hand_side_of_a: PlanarMotionOrForce,
    right_hand_side_of_b: PlanarMotionOrForce,
    pair_force: PairForce,
    half_step_time: float,
    constants_of_a: ElementConstants,
    constants_of_b: ElementConstants,
) -> tuple[PlanarMotionOrForce, PlanarMotionOrForce]:
    """Return the right-hand sides of elements a and b in the equations, with contact force `pair_force` added."""
    m, i, n, k = (
        half_step_time * constants_of_a.inverse_mass,
        half_step_time * constants_of_a.inverse_inertia,
        half_step_time * constants_of_b.inverse_mass,
        half_step_time * constants_of_b.inverse_inertia,
    )
    return (
        PlanarMotionOrForce(
            right_hand_side_of_a.x + m * pair_force.force_on_a_x,
            right_hand_side_of_a.z + m * pair_force.force_on_a_z,
            right_hand_side_of_a.angular + i * pair_force.moment_of_force_on_a_about_a,
        ),
        PlanarMotionOrForce(
            right_hand_side_of_b.x - n * pair_force.force_on_a_x,
            right_hand_side_of_b.z - n * pair_force.force_on_a_z,
            right_hand_side_of_b.angular - k * pair_force.moment_of_force_on_a_about_b,
        ),
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def solve_velocity_changes_in_place(
    case_states: Any,
    equation_submatrices_of_all_cases: Any,
    nonzero_pattern: NonzeroSubmatrixPattern,
    element_count: int,
) -> None:
    """Solve the equations of a step by elimination; velocity changes of the elements replace the right-hand sides.

    Submatrices outside the pattern are 0. In a stack each element shares a submatrix only with the next one, so that
    the work is proportional to the number of elements.
    """
    used, later, count = (
        nonzero_pattern.is_submatrix_nonzero,
        nonzero_pattern.coupled_higher_index_elements,
        nonzero_pattern.coupled_higher_index_element_counts,
    )
    for k in range(element_count):
        if not used[k, k]:
            continue
        pivot = slice_submatrix_rows(equation_submatrices_of_all_cases, k * element_count + k)
        invert_submatrix_in_place(pivot)
        for n in range(count[k]):
            i = later[k, n]
            factor = slice_submatrix_rows(equation_submatrices_of_all_cases, i * element_count + k)
            right_multiply_submatrix_by_pivot_inverse(factor, pivot)
            subtract_coupled_velocity_change(
                rows.slice_element_rows(case_states, i), factor, rows.slice_element_rows(case_states, k)
            )
            for o in range(count[k]):
                m = later[k, o]
                row = slice_submatrix_rows(equation_submatrices_of_all_cases, k * element_count + m)
                subtract_submatrix_product(
                    slice_submatrix_rows(equation_submatrices_of_all_cases, i * element_count + m),
                    factor,
                    row,
                    not used[i, m],
                )
                if not used[i, m]:
                    mark_submatrix_nonzero(nonzero_pattern, i, m)
    for k in range(element_count - 1, -1, -1):
        if not used[k, k]:
            continue
        for n in range(count[k]):
            m = later[k, n]
            subtract_coupled_velocity_change(
                rows.slice_element_rows(case_states, k),
                slice_submatrix_rows(equation_submatrices_of_all_cases, k * element_count + m),
                rows.slice_element_rows(case_states, m),
            )
        multiply_right_side_by_pivot_inverse(
            rows.slice_element_rows(case_states, k),
            slice_submatrix_rows(equation_submatrices_of_all_cases, k * element_count + k),
        )


@njit(inline="always", **INTERNAL_COMPILE_OPTIONS)
def equation_submatrix_or_placeholder(
    equation_submatrices_of_all_cases: Any,
    moves_relative_to_base_by_element: Any,
    row_element_index: int,
    column_element_index: int,
    unused_submatrix_index: int,
) -> Any:
    """Return the equation submatrix of two elements (row, column), or a spare one if either moves with the base.

    An element that moves with the base has no equations; terms written to a spare submatrix are ignored.
    """
    return slice_submatrix_rows(
        equation_submatrices_of_all_cases,
        row_element_index * moves_relative_to_base_by_element.size + column_element_index
        if moves_relative_to_base_by_element[row_element_index]
        and moves_relative_to_base_by_element[column_element_index]
        else moves_relative_to_base_by_element.size * moves_relative_to_base_by_element.size + unused_submatrix_index,
    )


@njit(inline="always", **INTERNAL_COMPILE_OPTIONS)
def mark_nonzero_and_return_pair_submatrices(
    equation_submatrices_of_all_cases: Any,
    nonzero_pattern: NonzeroSubmatrixPattern,
    moves_relative_to_base_by_element: Any,
    element_index_a: int,
    element_index_b: int,
) -> tuple[PairSubmatrices, Any]:
    """Return the submatrices of elements a and b, marked as nonzero, and whether aa, ab and bb were zero before."""
    used = nonzero_pattern.is_submatrix_nonzero
    fresh = (
        not used[element_index_a, element_index_a],
        not used[element_index_a, element_index_b],
        not used[element_index_b, element_index_b],
    )
    used[element_index_a, element_index_a], used[element_index_b, element_index_b] = (
        moves_relative_to_base_by_element[element_index_a],
        moves_relative_to_base_by_element[element_index_b],
    )
    if (
        moves_relative_to_base_by_element[element_index_a]
        and moves_relative_to_base_by_element[element_index_b]
        and not used[element_index_a, element_index_b]
    ):
        mark_submatrix_nonzero(nonzero_pattern, element_index_a, element_index_b)
        mark_submatrix_nonzero(nonzero_pattern, element_index_b, element_index_a)
    aa, ab = (
        equation_submatrix_or_placeholder(
            equation_submatrices_of_all_cases, moves_relative_to_base_by_element, element_index_a, element_index_a, 0
        ),
        equation_submatrix_or_placeholder(
            equation_submatrices_of_all_cases, moves_relative_to_base_by_element, element_index_a, element_index_b, 1
        ),
    )
    return PairSubmatrices(
        aa,
        ab,
        equation_submatrix_or_placeholder(
            equation_submatrices_of_all_cases, moves_relative_to_base_by_element, element_index_b, element_index_a, 2
        ),
        equation_submatrix_or_placeholder(
            equation_submatrices_of_all_cases, moves_relative_to_base_by_element, element_index_b, element_index_b, 3
        ),
    ), fresh
