"""3-D vectors, matrices and rotations of one body. Sums add x and y first, so that mirror images are exact."""

from typing import NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import INLINE_OPTIONS, create_tuple_sum_difference_and_maximum_functions


class Vector3(NamedTuple):
    """Vector of three components, x, y and z."""

    x: float
    y: float
    z: float


class Quaternion(NamedTuple):
    """Unit quaternion of the rotation of a body from its pose at rest."""

    w: float
    x: float
    y: float
    z: float


class SymmetricMatrix(NamedTuple):
    """Symmetric 3 × 3 matrix, stored as its six different elements."""

    xx: float
    yy: float
    zz: float
    xy: float
    xz: float
    yz: float


class Matrix3(NamedTuple):
    """3 × 3 matrix by rows. In the rotation matrix of a body, `xy` is the x component of its y axis."""

    xx: float
    xy: float
    xz: float
    yx: float
    yy: float
    yz: float
    zx: float
    zy: float
    zz: float


plus, minus = (
    create_tuple_sum_difference_and_maximum_functions(Vector3).plus,
    create_tuple_sum_difference_and_maximum_functions(Vector3).minus,
)
matrix_plus = create_tuple_sum_difference_and_maximum_functions(Matrix3).plus
matrix_minus = create_tuple_sum_difference_and_maximum_functions(Matrix3).minus


@njit(**INLINE_OPTIONS)
def scale_vector(factor: float, v: Vector3) -> Vector3:
    """Return the product of a number and a vector."""
    return Vector3(factor * v.x, factor * v.y, factor * v.z)


@njit(**INLINE_OPTIONS)
def extrapolate_vector(vector_at_start: Vector3, duration: float, constant_rate: Vector3) -> Vector3:
    """Return a vector extrapolated at a constant rate: start + time × rate."""
    return Vector3(
        vector_at_start.x + duration * constant_rate.x,
        vector_at_start.y + duration * constant_rate.y,
        vector_at_start.z + duration * constant_rate.z,
    )


@njit(**INLINE_OPTIONS)
def cross_product(a: Vector3, b: Vector3) -> Vector3:
    """Return the cross product of two vectors."""
    return Vector3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@njit(**INLINE_OPTIONS)
def dot_product(a: Vector3, b: Vector3) -> float:
    """Return the scalar product of two vectors."""
    return (a.x * b.x + a.y * b.y) + a.z * b.z


@njit(**INLINE_OPTIONS)
def vector_length(vector: Vector3) -> float:
    """Return the length of a vector."""
    return float(np.sqrt(dot_product(vector, vector)))


@njit(**INLINE_OPTIONS)
def matrix_times_vector(m: Matrix3, v: Vector3) -> Vector3:
    """Return the product of a matrix and a vector."""
    return Vector3(
        (m.xx * v.x + m.xy * v.y) + m.xz * v.z,
        (m.yx * v.x + m.yy * v.y) + m.yz * v.z,
        (m.zx * v.x + m.zy * v.y) + m.zz * v.z,
    )


@njit(**INLINE_OPTIONS)
def matrix_product(a: Matrix3, b: Matrix3) -> Matrix3:
    """Return the product of two matrices."""
    p = matrix_times_vector(a, Vector3(b.xx, b.yx, b.zx))
    q = matrix_times_vector(a, Vector3(b.xy, b.yy, b.zy))
    r = matrix_times_vector(a, Vector3(b.xz, b.yz, b.zz))
    return Matrix3(p.x, q.x, r.x, p.y, q.y, r.y, p.z, q.z, r.z)


@njit(**INLINE_OPTIONS)
def transpose(m: Matrix3) -> Matrix3:
    """Return the transpose of a matrix."""
    return Matrix3(m.xx, m.yx, m.zx, m.xy, m.yy, m.zy, m.xz, m.yz, m.zz)


@njit(**INLINE_OPTIONS)
def expand_symmetric_matrix(symmetric_matrix: SymmetricMatrix) -> Matrix3:
    """Return a symmetric matrix as a `Matrix3` with all nine elements."""
    return Matrix3(
        symmetric_matrix.xx,
        symmetric_matrix.xy,
        symmetric_matrix.xz,
        symmetric_matrix.xy,
        symmetric_matrix.yy,
        symmetric_matrix.yz,
        symmetric_matrix.xz,
        symmetric_matrix.yz,
        symmetric_matrix.zz,
    )


@njit(**INLINE_OPTIONS)
def inverse_matrix(m: Matrix3) -> Matrix3:
    """Return the inverse of a 3 × 3 matrix by cofactors; inverses of exact mirror images are exact mirror images."""
    zx, zy, zz = m.xy * m.yz - m.xz * m.yy, m.xz * m.yx - m.xx * m.yz, m.xx * m.yy - m.xy * m.yx
    one = 1.0 / ((m.zx * zx + m.zy * zy) + m.zz * zz)
    return Matrix3(
        one * (m.yy * m.zz - m.yz * m.zy), one * (m.xz * m.zy - m.xy * m.zz), one * zx,
        one * (m.yz * m.zx - m.yx * m.zz), one * (m.xx * m.zz - m.xz * m.zx), one * zy,
        one * (m.yx * m.zy - m.yy * m.zx), one * (m.xy * m.zx - m.xx * m.zy), one * zz,
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def rotation_matrix(quaternion: Quaternion) -> Matrix3:
    """Return the rotation matrix of a quaternion; its columns are the axes of the body."""
    w, x, y, z = quaternion
    return Matrix3(
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def rotate_quaternion(initial_rotation: Quaternion, duration_s: float, angular_velocity: Vector3) -> Quaternion:
    """Return a rotation continued for a duration (s) at a constant angular velocity (rad/s, axes of the base)."""
    h = Vector3(
        0.5 * (duration_s * angular_velocity.x),
        0.5 * (duration_s * angular_velocity.y),
        0.5 * (duration_s * angular_velocity.z),
    )
    square = dot_product(h, h)
    c = 1.0 - square * (0.5 - square * (1.0 / 24.0))
    a = scale_vector(1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)), h)
    return Quaternion(
        c * initial_rotation.w - ((a.x * initial_rotation.x + a.y * initial_rotation.y) + a.z * initial_rotation.z),
        (c * initial_rotation.x + a.x * initial_rotation.w) + (a.y * initial_rotation.z - a.z * initial_rotation.y),
        (c * initial_rotation.y + a.y * initial_rotation.w) + (a.z * initial_rotation.x - a.x * initial_rotation.z),
        (c * initial_rotation.z + a.z * initial_rotation.w) + (a.x * initial_rotation.y - a.y * initial_rotation.x),
    )


@njit(**INLINE_OPTIONS)
def renormalise_nearly_unit_quaternion(q: Quaternion) -> Quaternion:
    """Return a quaternion of nearly unit length scaled to length 1."""
    unit = 1.5 - 0.5 * ((q.w * q.w + q.z * q.z) + (q.x * q.x + q.y * q.y))
    return Quaternion(q.w * unit, q.x * unit, q.y * unit, q.z * unit)
