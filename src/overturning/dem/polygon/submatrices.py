"""3 × 3 submatrices of the equations of a step: products, inverse and elimination, for all cases in parallel."""

from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    TupleRowLayout,
    create_tuple_sum_difference_and_maximum_functions,
    create_window_slicer,
    hide_number_from_llvm,
)
from overturning.dem.polygon import rows
from overturning.dem.polygon.state import ElementConstants, PlanarMotionOrForce


class EquationSubmatrix(NamedTuple):
    """3 × 3 submatrix of a step's equations: a row per equation of motion, a column per velocity change."""

    row_x_column_velocity_x_change: float
    row_x_column_velocity_change_z: float
    row_x_column_angular_velocity_change: float
    row_z_column_velocity_x_change: float
    row_z_column_velocity_z_change: float
    row_z_column_angular_velocity_change: float
    row_rotation_column_velocity_x_change: float
    row_rotation_column_velocity_z_change: float
    row_rotation_column_angular_velocity_change: float


SUBMATRIX_ROW_LAYOUT: Final = TupleRowLayout(rows.PARALLEL_CASE_COUNT, EquationSubmatrix)


VALUE_COUNT_PER_SUBMATRIX_IN_ALL_LANES: Final = SUBMATRIX_ROW_LAYOUT.array_length


load, store, _ = SUBMATRIX_ROW_LAYOUT.tuple_reader_and_writer(EquationSubmatrix)


subtract_submatrix_elementwise = create_tuple_sum_difference_and_maximum_functions(EquationSubmatrix).minus


slice_submatrix_rows: Final = create_window_slicer(VALUE_COUNT_PER_SUBMATRIX_IN_ALL_LANES)
"""``slice_submatrix_rows(matrix, k)``: return the rows of submatrix number k."""


@njit(**INLINE_OPTIONS)
def scale_by_half_step_over_mass_and_inertia(
    force_per_velocity_submatrix: EquationSubmatrix, element_constants: ElementConstants, signed_half_step_time: float
) -> EquationSubmatrix:
    """Return a force-per-velocity submatrix × ± half the step, its rows divided by mass or moment of inertia."""
    m, i = (
        signed_half_step_time * element_constants.inverse_mass,
        signed_half_step_time * element_constants.inverse_inertia,
    )
    xx, xz, xw, zx, zz, zw, wx, wz, ww = force_per_velocity_submatrix
    return EquationSubmatrix(m * xx, m * xz, m * xw, m * zx, m * zz, m * zw, i * wx, i * wz, i * ww)


@njit(**INLINE_OPTIONS)
def submatrix_times_vector(submatrix: EquationSubmatrix, vector: PlanarMotionOrForce) -> PlanarMotionOrForce:
    """Return the product of a 3 × 3 submatrix of the equations and a vector (x, z, rotation) of an element."""
    xx, xz, xw, zx, zz, zw, wx, wz, ww = submatrix
    x, z = (xx * vector.x + xz * vector.z) + xw * vector.angular, (zx * vector.x + zz * vector.z) + zw * vector.angular
    return PlanarMotionOrForce(x, z, (wx * vector.x + wz * vector.z) + ww * vector.angular)


@njit(**INLINE_OPTIONS)
def submatrix_product(left_submatrix: EquationSubmatrix, right_submatrix: EquationSubmatrix) -> EquationSubmatrix:
    """Return the product of two 3 × 3 submatrices of the equations."""
    xx, xz, xw, zx, zz, zw, wx, wz, ww = right_submatrix
    x, z = (
        submatrix_times_vector(left_submatrix, PlanarMotionOrForce(xx, zx, wx)),
        submatrix_times_vector(left_submatrix, PlanarMotionOrForce(xz, zz, wz)),
    )
    w = submatrix_times_vector(left_submatrix, PlanarMotionOrForce(xw, zw, ww))
    return EquationSubmatrix(x.x, z.x, w.x, x.z, z.z, w.z, x.angular, z.angular, w.angular)


@njit(**INLINE_OPTIONS)
def inverse_of_submatrix(submatrix: EquationSubmatrix) -> EquationSubmatrix:
    """Return the inverse of a 3 × 3 submatrix of the equations, from cofactors and one division."""
    pxx, pxz, pxw, pzx, pzz, pzw, pwx, pwz, pww = submatrix
    xx, xz, xw = pzz * pww - pzw * pwz, pxw * pwz - pxz * pww, pxz * pzw - pxw * pzz
    zx, zz, zw = pzw * pwx - pzx * pww, pxx * pww - pxw * pwx, pxw * pzx - pxx * pzw
    wx, wz, ww = pzx * pwz - pzz * pwx, pxz * pwx - pxx * pwz, pxx * pzz - pxz * pzx
    by = 1.0 / ((pxx * xx + pxz * zx) + pxw * wx)
    return EquationSubmatrix(by * xx, by * xz, by * xw, by * zx, by * zz, by * zw, by * wx, by * wz, by * ww)


@njit(**INLINE_OPTIONS)
def subtract_terms_from_submatrix(
    submatrix_of_all_cases: Any,
    lane: int,
    submatrix_is_unset: bool,
    diagonal_value_if_unset: float,
    subtracted_terms: EquationSubmatrix,
) -> None:
    """Subtract terms from a submatrix in column `lane`; an unset one is `diagonal_value_if_unset` × unit matrix."""
    one = diagonal_value_if_unset
    xx, xz, xw, zx, zz, zw, wx, wz, ww = load(submatrix_of_all_cases, lane)
    store(submatrix_of_all_cases, lane, subtract_submatrix_elementwise(EquationSubmatrix(
        one if submatrix_is_unset else xx, 0.0 if submatrix_is_unset else xz, 0.0 if submatrix_is_unset else xw,
        0.0 if submatrix_is_unset else zx, one if submatrix_is_unset else zz, 0.0 if submatrix_is_unset else zw,
        0.0 if submatrix_is_unset else wx, 0.0 if submatrix_is_unset else wz, one if submatrix_is_unset else ww,
    ), subtracted_terms))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def invert_submatrix_in_place(submatrix_of_all_cases: Any) -> None:
    """Replace a submatrix of the equations by its inverse, for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        store(submatrix_of_all_cases, j, inverse_of_submatrix(load(submatrix_of_all_cases, j)))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def right_multiply_submatrix_by_pivot_inverse(submatrix_of_all_cases: Any, pivot_inverse_of_all_cases: Any) -> None:
    """Multiply a submatrix from the right by `pivot_inverse_of_all_cases`, in place and for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        store(
            submatrix_of_all_cases,
            j,
            submatrix_product(load(submatrix_of_all_cases, j), load(pivot_inverse_of_all_cases, j)),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def subtract_submatrix_product(
    minuend_of_all_cases: Any, left_factor_of_all_cases: Any, right_factor_of_all_cases: Any, minuend_is_unset: bool
) -> None:
    """Subtract the product of two submatrices from a third (zero if `minuend_is_unset`), for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        subtract_terms_from_submatrix(
            minuend_of_all_cases,
            j,
            minuend_is_unset,
            0.0,
            submatrix_product(load(left_factor_of_all_cases, j), load(right_factor_of_all_cases, j)),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def subtract_coupled_velocity_change(
    target_element_state_rows: Any, submatrix_of_all_cases: Any, source_element_state_rows: Any
) -> None:
    """Subtract submatrix × (velocity change of the source element) from the velocity change of the target element."""
    for j in range(hide_number_from_llvm(rows.PARALLEL_CASE_COUNT)):
        v, w = (
            rows.load_step_end_velocity_correction(target_element_state_rows, j),
            submatrix_times_vector(
                load(submatrix_of_all_cases, j), rows.load_step_end_velocity_correction(source_element_state_rows, j)
            ),
        )
        rows.store_step_end_velocity_correction(
            target_element_state_rows, j, PlanarMotionOrForce(v.x - w.x, v.z - w.z, v.angular - w.angular)
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def multiply_right_side_by_pivot_inverse(element_state_rows: Any, pivot_inverse_of_all_cases: Any) -> None:
    """Replace an element's right-hand side by its velocity change: multiply by the inverse of its pivot submatrix."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        rows.store_step_end_velocity_correction(
            element_state_rows,
            j,
            submatrix_times_vector(
                load(pivot_inverse_of_all_cases, j), rows.load_step_end_velocity_correction(element_state_rows, j)
            ),
        )
