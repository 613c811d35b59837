"""Equations of a step of a stack: terms of the contacts of its stones, and elimination of stones from the top down."""

from numba import njit

from overturning.dem.body.vectors import (
    Matrix3,
    SymmetricMatrix,
    Vector3,
    cross_product,
    expand_symmetric_matrix,
    inverse_matrix,
    matrix_minus,
    matrix_plus,
    matrix_product,
    matrix_times_vector,
    plus,
    transpose,
)
from overturning.dem.kernel.lanes import INLINE_OPTIONS, create_tuple_sum_difference_and_maximum_functions
from overturning.dem.stack.joint_state import PredictedJointForceAndDerivatives
from overturning.dem.stack.state import (
    DiagonalBlockAndRightSide,
    ForceAndMomentOrVelocities,
    StoneCorrectionFromStoneBelow,
    VelocityToForceBlocks,
)

sum_of_6x6_matrices = create_tuple_sum_difference_and_maximum_functions(VelocityToForceBlocks).plus
difference_of_6x6_matrices = create_tuple_sum_difference_and_maximum_functions(VelocityToForceBlocks).minus
add_wrenches_or_velocities = create_tuple_sum_difference_and_maximum_functions(ForceAndMomentOrVelocities).plus
subtract_wrenches_or_velocities = create_tuple_sum_difference_and_maximum_functions(ForceAndMomentOrVelocities).minus


@njit(**INLINE_OPTIONS)
def matrix_times_cross_matrix(m: Matrix3, a: Vector3) -> Matrix3:
    """Return the product M [a] of a matrix and the cross-product matrix of a, where [a] v = a × v."""
    x = cross_product(Vector3(m.xx, m.xy, m.xz), a)
    y = cross_product(Vector3(m.yx, m.yy, m.yz), a)
    z = cross_product(Vector3(m.zx, m.zy, m.zz), a)
    return Matrix3(x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z)


@njit(**INLINE_OPTIONS)
def cross_matrix_times_matrix(a: Vector3, m: Matrix3) -> Matrix3:
    """Return the product [a] M of the cross-product matrix of a and a matrix, where [a] v = a × v."""
    x = cross_product(a, Vector3(m.xx, m.yx, m.zx))
    y = cross_product(a, Vector3(m.xy, m.yy, m.zy))
    z = cross_product(a, Vector3(m.xz, m.yz, m.zz))
    return Matrix3(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)


@njit(**INLINE_OPTIONS)
def rotate_matrix(rotation_to_new_axes: Matrix3, m: Matrix3) -> Matrix3:
    """Return R M Rᵀ, the matrix M in axes rotated by R."""
    return matrix_product(matrix_product(rotation_to_new_axes, m), transpose(rotation_to_new_axes))


@njit(**INLINE_OPTIONS)
def rotate_contact_equations(
    rotation_to_new_axes: Matrix3, joint_equations: PredictedJointForceAndDerivatives
) -> PredictedJointForceAndDerivatives:
    """Return two stones' contact force and its derivatives in a step's equations, rotated to new axes."""
    wrench = joint_equations.predicted_wrench_replaced_by_velocity_change
    joint_matrix = joint_equations.half_step_times_wrench_decrease_per_velocity
    return PredictedJointForceAndDerivatives(
        ForceAndMomentOrVelocities(
            matrix_times_vector(rotation_to_new_axes, wrench.force_or_velocity),
            matrix_times_vector(rotation_to_new_axes, wrench.moment_or_angular_velocity),
        ),
        VelocityToForceBlocks(
            rotate_matrix(rotation_to_new_axes, joint_matrix.force_per_velocity),
            rotate_matrix(rotation_to_new_axes, joint_matrix.force_per_angular_velocity),
            rotate_matrix(rotation_to_new_axes, joint_matrix.moment_per_velocity),
            rotate_matrix(rotation_to_new_axes, joint_matrix.moment_per_angular_velocity),
        ),
    )


@njit(**INLINE_OPTIONS)
def shift_contact_matrix_to_stone_centres(
    half_step_times_wrench_decrease_per_velocity: VelocityToForceBlocks,
    contact_origin_from_loaded_stone_centre: Vector3,
    contact_origin_from_moving_stone_centre: Vector3,
) -> VelocityToForceBlocks:
    """Return a contact's velocity-to-force matrix, shifted from the contact's origin to the centres of stones.

    The matrix leads from the velocities of the moving stone to force and moment on the loaded stone, which may be the
    same. Both vectors lead from the centre of a stone to the origin of the contact.
    """
    fw = matrix_minus(
        half_step_times_wrench_decrease_per_velocity.force_per_angular_velocity,
        matrix_times_cross_matrix(
            half_step_times_wrench_decrease_per_velocity.force_per_velocity, contact_origin_from_moving_stone_centre
        ),
    )
    return VelocityToForceBlocks(
        half_step_times_wrench_decrease_per_velocity.force_per_velocity,
        fw,
        matrix_plus(
            half_step_times_wrench_decrease_per_velocity.moment_per_velocity,
            cross_matrix_times_matrix(
                contact_origin_from_loaded_stone_centre, half_step_times_wrench_decrease_per_velocity.force_per_velocity
            ),
        ),
        matrix_plus(
            matrix_minus(
                half_step_times_wrench_decrease_per_velocity.moment_per_angular_velocity,
                matrix_times_cross_matrix(
                    half_step_times_wrench_decrease_per_velocity.moment_per_velocity,
                    contact_origin_from_moving_stone_centre,
                ),
            ),
            cross_matrix_times_matrix(contact_origin_from_loaded_stone_centre, fw),
        ),
    )


@njit(**INLINE_OPTIONS)
def shift_wrench_to_stone_centre(
    wrench_about_reference_point: ForceAndMomentOrVelocities, reference_point_from_stone_centre: Vector3
) -> ForceAndMomentOrVelocities:
    """Return a force and its moment about a stone's centre, given the moment about another point."""
    return ForceAndMomentOrVelocities(
        wrench_about_reference_point.force_or_velocity,
        plus(
            wrench_about_reference_point.moment_or_angular_velocity,
            cross_product(reference_point_from_stone_centre, wrench_about_reference_point.force_or_velocity),
        ),
    )


@njit(**INLINE_OPTIONS)
def mass_matrix_of_stone(
    stone_mass: float, inertia_per_mass: SymmetricMatrix, stone_axes: Matrix3
) -> VelocityToForceBlocks:
    """Return the 6 × 6 mass matrix (kg, kg·m²) of a stone in the axes of the ground."""
    i = rotate_matrix(stone_axes, expand_symmetric_matrix(inertia_per_mass))
    zero = Matrix3(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return VelocityToForceBlocks(
        Matrix3(stone_mass, 0.0, 0.0, 0.0, stone_mass, 0.0, 0.0, 0.0, stone_mass), zero, zero,
        Matrix3(
            stone_mass * i.xx, stone_mass * i.xy, stone_mass * i.xz, stone_mass * i.yx, stone_mass * i.yy,
            stone_mass * i.yz, stone_mass * i.zx, stone_mass * i.zy, stone_mass * i.zz,
        ),
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def product_of_6x6_matrices(a: VelocityToForceBlocks, b: VelocityToForceBlocks) -> VelocityToForceBlocks:
    """Return the product of two 6 × 6 matrices."""
    return VelocityToForceBlocks(
        matrix_plus(
            matrix_product(a.force_per_velocity, b.force_per_velocity),
            matrix_product(a.force_per_angular_velocity, b.moment_per_velocity),
        ),
        matrix_plus(
            matrix_product(a.force_per_velocity, b.force_per_angular_velocity),
            matrix_product(a.force_per_angular_velocity, b.moment_per_angular_velocity),
        ),
        matrix_plus(
            matrix_product(a.moment_per_velocity, b.force_per_velocity),
            matrix_product(a.moment_per_angular_velocity, b.moment_per_velocity),
        ),
        matrix_plus(
            matrix_product(a.moment_per_velocity, b.force_per_angular_velocity),
            matrix_product(a.moment_per_angular_velocity, b.moment_per_angular_velocity),
        ),
    )


@njit(**INLINE_OPTIONS)
def matrix_6x6_times_wrench(a: VelocityToForceBlocks, w: ForceAndMomentOrVelocities) -> ForceAndMomentOrVelocities:
    """Return the product of a 6 × 6 matrix and a force and moment (vector of 6)."""
    return ForceAndMomentOrVelocities(
        plus(
            matrix_times_vector(a.force_per_velocity, w.force_or_velocity),
            matrix_times_vector(a.force_per_angular_velocity, w.moment_or_angular_velocity),
        ),
        plus(
            matrix_times_vector(a.moment_per_velocity, w.force_or_velocity),
            matrix_times_vector(a.moment_per_angular_velocity, w.moment_or_angular_velocity),
        ),
    )


@njit(**INLINE_OPTIONS)
def inverse_of_6x6_matrix(a: VelocityToForceBlocks) -> VelocityToForceBlocks:
    """Return the inverse of a 6 × 6 matrix by its 3 × 3 blocks."""
    p = inverse_matrix(a.force_per_velocity)
    q = matrix_product(p, a.force_per_angular_velocity)
    s = inverse_matrix(matrix_minus(a.moment_per_angular_velocity, matrix_product(a.moment_per_velocity, q)))
    t = matrix_product(matrix_product(s, a.moment_per_velocity), p)
    qs = matrix_product(q, s)
    zero = Matrix3(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return VelocityToForceBlocks(matrix_plus(p, matrix_product(q, t)), matrix_minus(zero, qs), matrix_minus(zero, t), s)


@njit(**INLINE_OPTIONS)
def half_step_times_change_of_force_and_moment(
    half_step_length_s: float,
    stone_mass: float,
    contact_force_and_moment: ForceAndMomentOrVelocities,
    inertial_and_gravity_acceleration: Vector3,
    acceleration_and_moment_per_mass_at_start: ForceAndMomentOrVelocities,
) -> ForceAndMomentOrVelocities:
    """Return half step × change of a stone's force and moment in the step: right-hand side of its equations."""
    f, m = contact_force_and_moment.force_or_velocity, contact_force_and_moment.moment_or_angular_velocity
    a, t = acceleration_and_moment_per_mass_at_start
    return ForceAndMomentOrVelocities(
        Vector3(
            half_step_length_s * (f.x + stone_mass * (inertial_and_gravity_acceleration.x - a.x)),
            half_step_length_s * (f.y + stone_mass * (inertial_and_gravity_acceleration.y - a.y)),
            half_step_length_s * (f.z + stone_mass * (inertial_and_gravity_acceleration.z - a.z)),
        ),
        Vector3(
            half_step_length_s * (m.x - stone_mass * t.x),
            half_step_length_s * (m.y - stone_mass * t.y),
            half_step_length_s * (m.z - stone_mass * t.z),
        ),
    )


@njit(**INLINE_OPTIONS)
def scale_wrench(factor: float, w: ForceAndMomentOrVelocities) -> ForceAndMomentOrVelocities:
    """Return a force and moment, both multiplied by a number."""
    f, m = w.force_or_velocity, w.moment_or_angular_velocity
    return ForceAndMomentOrVelocities(
        Vector3(factor * f.x, factor * f.y, factor * f.z), Vector3(factor * m.x, factor * m.y, factor * m.z)
    )


@njit(**INLINE_OPTIONS)
def eliminate_stone_from_equations(
    upper_stone_equations: DiagonalBlockAndRightSide,
    lower_stone_equations: DiagonalBlockAndRightSide,
    joint_equations: PredictedJointForceAndDerivatives,
    half_step_length_s: float,
    contact_origin_from_upper_stone_centre: Vector3,
    contact_origin_from_lower_stone_centre: Vector3,
) -> tuple[StoneCorrectionFromStoneBelow, DiagonalBlockAndRightSide]:
    """Eliminate the upper of two stones from a stack's equations; return its correction, and the lower's equations.

    The correction is that of the upper stone's velocities, as a function of the lower stone's. `upper_stone_equations`
    and `lower_stone_equations` do not contain the contact of the two stones yet; the returned equations do.
    """
    joint_matrix = joint_equations.half_step_times_wrench_decrease_per_velocity
    wrench = scale_wrench(half_step_length_s, joint_equations.predicted_wrench_replaced_by_velocity_change)
    own = sum_of_6x6_matrices(
        upper_stone_equations.diagonal_block,
        shift_contact_matrix_to_stone_centres(
            joint_matrix, contact_origin_from_upper_stone_centre, contact_origin_from_upper_stone_centre
        ),
    )
    coupling, back = (
        shift_contact_matrix_to_stone_centres(
            joint_matrix, contact_origin_from_upper_stone_centre, contact_origin_from_lower_stone_centre
        ),
        shift_contact_matrix_to_stone_centres(
            joint_matrix, contact_origin_from_lower_stone_centre, contact_origin_from_upper_stone_centre
        ),
    )
    inverse = inverse_of_6x6_matrix(own)
    factor_below = product_of_6x6_matrices(inverse, coupling)
    fixed_part = matrix_6x6_times_wrench(
        inverse,
        add_wrenches_or_velocities(
            upper_stone_equations.impulse_right_hand_side,
            shift_wrench_to_stone_centre(wrench, contact_origin_from_upper_stone_centre),
        ),
    )
    # e = fixed part + factor · e_below: the coupling has a minus sign.
    return StoneCorrectionFromStoneBelow(factor_below, fixed_part), DiagonalBlockAndRightSide(
        difference_of_6x6_matrices(
            sum_of_6x6_matrices(
                lower_stone_equations.diagonal_block,
                shift_contact_matrix_to_stone_centres(
                    joint_matrix, contact_origin_from_lower_stone_centre, contact_origin_from_lower_stone_centre
                ),
            ),
            product_of_6x6_matrices(back, factor_below),
        ),
        add_wrenches_or_velocities(
            subtract_wrenches_or_velocities(
                lower_stone_equations.impulse_right_hand_side,
                shift_wrench_to_stone_centre(wrench, contact_origin_from_lower_stone_centre),
            ),
            matrix_6x6_times_wrench(back, fixed_part),
        ),
    )


@njit(**INLINE_OPTIONS)
def solve_velocity_correction_of_lowest_stone(
    lowest_stone_equations_without_upper_stones: DiagonalBlockAndRightSide,
    joint_equations: PredictedJointForceAndDerivatives,
    half_step_length_s: float,
    contact_origin_from_stone_centre: Vector3,
) -> ForceAndMomentOrVelocities:
    """Return the velocity correction of the lowest stone, after the stones above it have been eliminated."""
    own = sum_of_6x6_matrices(
        lowest_stone_equations_without_upper_stones.diagonal_block,
        shift_contact_matrix_to_stone_centres(
            joint_equations.half_step_times_wrench_decrease_per_velocity,
            contact_origin_from_stone_centre,
            contact_origin_from_stone_centre,
        ),
    )
    right = add_wrenches_or_velocities(
        lowest_stone_equations_without_upper_stones.impulse_right_hand_side,
        shift_wrench_to_stone_centre(
            scale_wrench(half_step_length_s, joint_equations.predicted_wrench_replaced_by_velocity_change),
            contact_origin_from_stone_centre,
        ),
    )
    return matrix_6x6_times_wrench(inverse_of_6x6_matrix(own), right)
