"""Equations of a step of a stack: contributions of joints, and exact elimination from the top to the bottom."""

from numba import njit

from overturning.dem.body.vectors import (
    Matrix3,
    SymmetricMatrix,
    Vector3,
    cross_product,
    full_matrix,
    inverse_matrix,
    matrix_minus,
    matrix_plus,
    matrix_product,
    matrix_times_vector,
    plus,
    transpose,
)
from overturning.dem.kernel.lanes import INLINE, create_elementwise_tuple_functions
from overturning.dem.stack.joint_state import JointEquations
from overturning.dem.stack.state import DiagonalBlockAndRightSide, EliminatedStone, ForceVelocityBlocks, Wrench

blocks_plus, blocks_minus = (
    create_elementwise_tuple_functions(ForceVelocityBlocks).plus,
    create_elementwise_tuple_functions(ForceVelocityBlocks).minus,
)
wrench_plus, wrench_minus = (
    create_elementwise_tuple_functions(Wrench).plus,
    create_elementwise_tuple_functions(Wrench).minus,
)


@njit(**INLINE)
def matrix_times_cross_matrix(m: Matrix3, a: Vector3) -> Matrix3:
    """Return the product M [a] of a matrix and the cross-product matrix of a, where [a] v = a × v."""
    x = cross_product(Vector3(m.xx, m.xy, m.xz), a)
    y = cross_product(Vector3(m.yx, m.yy, m.yz), a)
    z = cross_product(Vector3(m.zx, m.zy, m.zz), a)
    return Matrix3(x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z)


@njit(**INLINE)
def cross_matrix_times_matrix(a: Vector3, m: Matrix3) -> Matrix3:
    """Return the product [a] M of the cross-product matrix of a and a matrix, where [a] v = a × v."""
    x = cross_product(a, Vector3(m.xx, m.yx, m.zx))
    y = cross_product(a, Vector3(m.xy, m.yy, m.zy))
    z = cross_product(a, Vector3(m.xz, m.yz, m.zz))
    return Matrix3(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)


@njit(**INLINE)
def rotate_matrix(r: Matrix3, m: Matrix3) -> Matrix3:
    """Return R M Rᵀ, the matrix M in axes rotated by R."""
    return matrix_product(matrix_product(r, m), transpose(r))


@njit(**INLINE)
def rotate_equations(r: Matrix3, local: JointEquations) -> JointEquations:
    """Rotate the equations of a joint by `r`, from the axes of the lower stone to the axes of the ground."""
    w, b = local.wrench, local.blocks
    return JointEquations(
        Wrench(matrix_times_vector(r, w.force), matrix_times_vector(r, w.moment)),
        ForceVelocityBlocks(
            rotate_matrix(r, b.fv), rotate_matrix(r, b.fw), rotate_matrix(r, b.mv), rotate_matrix(r, b.mw)
        ),
    )


@njit(**INLINE)
def shift_blocks(b: ForceVelocityBlocks, row_arm: Vector3, column_arm: Vector3) -> ForceVelocityBlocks:
    """Return a joint's matrix from the velocity of one stone to the force on another, about both centres.

    The arms lead from the centres to the origin of the joint: of the stone on which it acts, and of the one that moves.
    """
    fw = matrix_minus(b.fw, matrix_times_cross_matrix(b.fv, column_arm))
    return ForceVelocityBlocks(
        b.fv,
        fw,
        matrix_plus(b.mv, cross_matrix_times_matrix(row_arm, b.fv)),
        matrix_plus(
            matrix_minus(b.mw, matrix_times_cross_matrix(b.mv, column_arm)), cross_matrix_times_matrix(row_arm, fw)
        ),
    )


@njit(**INLINE)
def shift_wrench(w: Wrench, arm: Vector3) -> Wrench:
    """Return force and moment about a stone's centre; `arm` leads from there to the point they referred to before."""
    return Wrench(w.force, plus(w.moment, cross_product(arm, w.force)))


@njit(**INLINE)
def inertia_blocks(mass: float, inertia: SymmetricMatrix, axes: Matrix3) -> ForceVelocityBlocks:
    """Return the 6 × 6 mass matrix of a stone in the axes of the ground, kg and kg·m²."""
    i = rotate_matrix(axes, full_matrix(inertia))
    zero = Matrix3(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return ForceVelocityBlocks(
        Matrix3(mass, 0.0, 0.0, 0.0, mass, 0.0, 0.0, 0.0, mass), zero, zero,
        Matrix3(
            mass * i.xx, mass * i.xy, mass * i.xz, mass * i.yx, mass * i.yy, mass * i.yz, mass * i.zx, mass * i.zy,
            mass * i.zz,
        ),
    )  # fmt: skip


@njit(**INLINE)
def blocks_product(a: ForceVelocityBlocks, b: ForceVelocityBlocks) -> ForceVelocityBlocks:
    """Return the product of two 6 × 6 matrices."""
    return ForceVelocityBlocks(
        matrix_plus(matrix_product(a.fv, b.fv), matrix_product(a.fw, b.mv)),
        matrix_plus(matrix_product(a.fv, b.fw), matrix_product(a.fw, b.mw)),
        matrix_plus(matrix_product(a.mv, b.fv), matrix_product(a.mw, b.mv)),
        matrix_plus(matrix_product(a.mv, b.fw), matrix_product(a.mw, b.mw)),
    )


@njit(**INLINE)
def blocks_times_wrench(a: ForceVelocityBlocks, w: Wrench) -> Wrench:
    """Return the product of a 6 × 6 matrix and a vector of 6."""
    return Wrench(
        plus(matrix_times_vector(a.fv, w.force), matrix_times_vector(a.fw, w.moment)),
        plus(matrix_times_vector(a.mv, w.force), matrix_times_vector(a.mw, w.moment)),
    )


@njit(**INLINE)
def inverse_blocks(a: ForceVelocityBlocks) -> ForceVelocityBlocks:
    """Return the inverse of a 6 × 6 matrix by its 3 × 3 blocks."""
    p = inverse_matrix(a.fv)
    q = matrix_product(p, a.fw)
    s = inverse_matrix(matrix_minus(a.mw, matrix_product(a.mv, q)))
    t = matrix_product(matrix_product(s, a.mv), p)
    qs = matrix_product(q, s)
    zero = Matrix3(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return ForceVelocityBlocks(matrix_plus(p, matrix_product(q, t)), matrix_minus(zero, qs), matrix_minus(zero, t), s)


@njit(**INLINE)
def right_side(half: float, mass: float, wrench: Wrench, inertial: Vector3, old: Wrench) -> Wrench:
    """Return half step × change of force and moment since its start, the right-hand side of a stone's equations."""
    f, m = wrench.force, wrench.moment
    return Wrench(
        Vector3(
            half * (f.x + mass * (inertial.x - old.force.x)), half * (f.y + mass * (inertial.y - old.force.y)),
            half * (f.z + mass * (inertial.z - old.force.z)),
        ),
        Vector3(
            half * (m.x - mass * old.moment.x), half * (m.y - mass * old.moment.y), half * (m.z - mass * old.moment.z)
        ),
    )  # fmt: skip


@njit(**INLINE)
def scale_wrench(factor: float, w: Wrench) -> Wrench:
    """Return a force and moment, both multiplied by a number."""
    f, m = w.force, w.moment
    return Wrench(Vector3(factor * f.x, factor * f.y, factor * f.z), Vector3(factor * m.x, factor * m.y, factor * m.z))


@njit(**INLINE)
def eliminate_stone(
    diagonal: DiagonalBlockAndRightSide,
    lower: DiagonalBlockAndRightSide,
    joint: JointEquations,
    half: float,
    upper_arm: Vector3,
    lower_arm: Vector3,
) -> tuple[EliminatedStone, DiagonalBlockAndRightSide]:
    """Eliminate a stone from the equations; return its solution and the reduced equations of the stone below it.

    `diagonal` and `lower` do not contain the joint between the two stones yet.
    """
    b, w = joint.blocks, scale_wrench(half, joint.wrench)
    own = blocks_plus(diagonal.blocks, shift_blocks(b, upper_arm, upper_arm))
    coupling, back = shift_blocks(b, upper_arm, lower_arm), shift_blocks(b, lower_arm, upper_arm)
    inverse = inverse_blocks(own)
    below = blocks_product(inverse, coupling)
    alone = blocks_times_wrench(inverse, wrench_plus(diagonal.right, shift_wrench(w, upper_arm)))
    # e = alone + below · e_below: the coupling has a minus sign.
    return EliminatedStone(below, alone), DiagonalBlockAndRightSide(
        blocks_minus(blocks_plus(lower.blocks, shift_blocks(b, lower_arm, lower_arm)), blocks_product(back, below)),
        wrench_plus(wrench_minus(lower.right, shift_wrench(w, lower_arm)), blocks_times_wrench(back, alone)),
    )


@njit(**INLINE)
def solve_lowest_stone(diagonal: DiagonalBlockAndRightSide, joint: JointEquations, half: float, arm: Vector3) -> Wrench:
    """Return the velocity correction of the lowest stone, after the stones above it have been eliminated."""
    own = blocks_plus(diagonal.blocks, shift_blocks(joint.blocks, arm, arm))
    right = wrench_plus(diagonal.right, shift_wrench(scale_wrench(half, joint.wrench), arm))
    return blocks_times_wrench(inverse_blocks(own), right)
