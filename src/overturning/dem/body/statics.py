"""Statics of a body on the springs of its vertices: equilibrium, extreme eigenvalues and unloading of vertices."""

import math
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.linear import highest_eigenvalue, lowest_eigenvalue, solve_positive_definite_system
from overturning.model.solid import RigidSolid
from overturning.units import STANDARD_GRAVITY

MAX_CACHED_SOLIDS: Final = 4096
"""Number of solids whose statics are kept: planning computes the same solids for each record of a study."""


def body_pose_at_rest_on_springs(body: RigidSolid, vertex_normal_stiffness_per_mass: float) -> FloatArray:
    """Return the pose of a body at rest on its base springs: centre (m) and small rotation vector (rad), shape (6,).

    The penetration of a vertex is a linear function of its x and y; vertices where it would be negative carry no load.
    `vertex_normal_stiffness_per_mass` is the stiffness of a vertex per mass, 1/s².
    """
    x, y = body.contact_points_from_centre_of_mass[: body.base_vertex_count, :2].T
    on = np.ones(body.base_vertex_count, np.bool_)
    for _ in range(body.base_vertex_count):
        rows = np.stack([np.ones(body.base_vertex_count), x, y])[:, on]
        # fsum does not depend on the order: symmetric bodies stay symmetric to the last digit.
        matrix = np.array([[math.fsum(a * b) for b in rows] for a in rows])
        plane = solve_positive_definite_system(
            matrix, np.array([STANDARD_GRAVITY / vertex_normal_stiffness_per_mass, 0.0, 0.0])
        )
        if plane is None:
            break
        sunk = plane[0] + plane[1] * x + plane[2] * y
        if (sunk[on] > 0).all():
            return np.array([0.0, 0.0, body.centre_height - plane[0], -plane[2], plane[1], 0.0])
        on &= sunk > 0
    return np.array(
        [
            0.0,
            0.0,
            body.centre_height - STANDARD_GRAVITY / (body.base_vertex_count * vertex_normal_stiffness_per_mass),
            0.0,
            0.0,
            0.0,
        ]
    )


@lru_cache(MAX_CACHED_SOLIDS)
def largest_squared_frequency_on_springs_of_any_face(body: RigidSolid) -> float:
    """Return the largest eigenvalue ω² of a body on equal springs at its vertices, for the stable time step.

    Each spring has the stiffness 1/s² per body mass. The result is the maximum over the faces that can lie flat, with
    springs at all vertices of the face. Contact at an edge or a single vertex has fewer springs, hence no higher
    eigenvalue. The tilt of the body does not matter for isotropic springs.
    """
    faces = (np.arange(body.base_vertex_count), *body.point_indices_by_non_base_contact_face)
    return max(highest_eigenvalue(_mass_scaled_stiffness_of_unit_springs(body, face)) for face in faces)


@lru_cache(MAX_CACHED_SOLIDS)
def smallest_squared_frequency_on_unit_springs(body: RigidSolid) -> float:
    """Return the smallest eigenvalue ω² of an upright body on equal springs at its base vertices.

    Each spring has the stiffness 1/s² per body mass, as in `largest_squared_frequency_on_springs_of_any_face`.
    """
    return lowest_eigenvalue(_mass_scaled_stiffness_of_unit_springs(body, np.arange(body.base_vertex_count)))


@lru_cache(MAX_CACHED_SOLIDS)
def unloading_acceleration_g_and_min_to_mean_load(body: RigidSolid) -> tuple[float, float]:
    """Return the base acceleration |a|/g that unloads a base vertex, and the least vertex load over the mean one.

    The acceleration is horizontal, in the most unfavourable direction; the loads are those of the upright body at rest.
    Both results are 0 if a vertex carries no load at rest.
    """
    x, y = body.contact_points_from_centre_of_mass[: body.base_vertex_count, :2].T
    rows = np.stack([np.ones(body.base_vertex_count), x, y])
    matrix = np.array([[math.fsum(a * b) for b in rows] for a in rows])
    planes = solve_positive_definite_system(matrix, np.eye(3))
    if planes is None:
        return 0.0, 0.0
    # Force at each vertex over the weight: from gravity, and from the moments of accelerations along x and y.
    own, ahead, aside = (np.sum(plane[:, None] * rows, axis=0) for plane in planes.T)
    change = body.centre_height * np.sqrt(ahead**2 + aside**2)
    least = float(np.min(own))
    return (float(np.min(own / change)), least * body.base_vertex_count) if least > 0.0 else (0.0, 0.0)


def _mass_scaled_stiffness_of_unit_springs(
    body: RigidSolid, vertex_indices_with_springs: NDArray[np.int64]
) -> FloatArray:
    """Return the 6 × 6 stiffness matrix, scaled to unit mass and inertia, of a body on unit springs at vertices."""
    inertia = body.inertia_per_mass
    # Lower triangular root of the inertia, I = C Cᵀ, and its inverse.
    c00 = math.sqrt(inertia[0, 0])
    c10, c20 = inertia[1, 0] / c00, inertia[2, 0] / c00
    c11 = math.sqrt(inertia[1, 1] - c10 * c10)
    c21 = (inertia[2, 1] - c20 * c10) / c11
    c22 = math.sqrt(inertia[2, 2] - c20 * c20 - c21 * c21)
    root = np.array([[c00, 0.0, 0.0], [c10, c11, 0.0], [c20, c21, c22]])
    matrix = np.zeros((6, 6))
    for x, y, z in body.contact_points_from_centre_of_mass[vertex_indices_with_springs]:
        # A rotation vector w moves the vertex by w × r.
        turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        each = np.concatenate([np.eye(3), _multiply_by_inverse_transposed_cholesky_factor(turn, root)], axis=1)
        matrix += np.sum(each[:, :, None] * each[:, None, :], axis=0)
    return matrix


def _multiply_by_inverse_transposed_cholesky_factor(
    matrix_to_multiply: FloatArray, inertia_per_mass_cholesky_factor: FloatArray
) -> FloatArray:
    """Return A C⁻ᵀ for a 3 × 3 matrix A and the lower triangular Cholesky root C of an inertia tensor."""
    out = np.zeros((3, 3))
    for k in range(3):
        known = sum((out[:, i] * inertia_per_mass_cholesky_factor[k, i] for i in range(k)), start=np.zeros(3))
        out[:, k] = (matrix_to_multiply[:, k] - known) / inertia_per_mass_cholesky_factor[k, k]
    return out
