"""Statics of a body on the springs of its vertices: how it rests on them, and their highest frequency."""

import math

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.linear import highest_eigenvalue, lowest_eigenvalue, solve
from overturning.model.solid import Solid
from overturning.units import STANDARD_GRAVITY


def rest(body: Solid, normal: float) -> FloatArray:
    """Place of the centre (m), small rotation vector (rad): the body at rest on the springs of its base, shape (6,).

    Its weight is carried by vertices that have sunk in by a linear function of the place; of those that this would
    lift, none.
    """
    x, y = body.points[: body.base, :2].T
    on = np.ones(body.base, np.bool_)
    for _ in range(body.base):
        rows = np.stack([np.ones(body.base), x, y])[:, on]
        # Opposite vertices together: what is symmetric stays so to the last digit.
        matrix = np.array([[math.fsum(a * b) for b in rows] for a in rows])
        plane = solve(matrix, np.array([STANDARD_GRAVITY / normal, 0.0, 0.0]))
        if plane is None:
            break
        sunk = plane[0] + plane[1] * x + plane[2] * y
        if (sunk[on] > 0).all():
            return np.array([0.0, 0.0, body.foot - plane[0], -plane[2], plane[1], 0.0])
        on &= sunk > 0
    return np.array([0.0, 0.0, body.foot - STANDARD_GRAVITY / (body.base * normal), 0.0, 0.0, 0.0])


def highest_mode(body: Solid) -> float:
    """Largest eigenvalue of a body on equal springs in all directions, over the stiffness of one of them per mass.

    Each further spring only raises it: the upright body on all vertices of its base is faster than on an edge or one
    vertex of it, and of springs that are equal in all directions the tilt changes nothing. So the faces that can lie
    flat are looked at, each with all its vertices.
    """
    faces = (np.arange(body.base), *body.facets)
    return max(highest_eigenvalue(_stiffness(body, face)) for face in faces)


def lowest_mode(body: Solid) -> float:
    """Smallest eigenvalue of a body upright on equal springs at all vertices of its base, as of `highest_mode`."""
    return lowest_eigenvalue(_stiffness(body, np.arange(body.base)))


def unloading(body: Solid) -> tuple[float, float]:
    """When the first vertex of the base is unloaded, and the least of what they carry upright over their mean.

    The first is a horizontal acceleration in any direction, as a share of the weight; both are 0 where one carries
    nothing.
    """
    x, y = body.points[: body.base, :2].T
    rows = np.stack([np.ones(body.base), x, y])
    matrix = np.array([[math.fsum(a * b) for b in rows] for a in rows])
    planes = [solve(matrix, unit) for unit in np.eye(3)]
    if any(plane is None for plane in planes):
        return 0.0, 0.0
    # Force at each vertex, over the weight: of gravity, and of the moments of accelerations along x and y.
    own, ahead, aside = (np.sum(plane[:, None] * rows, axis=0) for plane in planes if plane is not None)
    change = body.foot * np.sqrt(ahead**2 + aside**2)
    least = float(np.min(own))
    return (float(np.min(own / change)), least * body.base) if least > 0.0 else (0.0, 0.0)


def _stiffness(body: Solid, face: NDArray[np.int64]) -> FloatArray:
    """Matrix of unit springs in all directions at vertices of a body, seen so that all six masses are 1."""
    inertia = body.inertia
    # Lower triangular root of the inertia, I = C Cᵀ, and its inverse.
    c00 = math.sqrt(inertia[0, 0])
    c10, c20 = inertia[1, 0] / c00, inertia[2, 0] / c00
    c11 = math.sqrt(inertia[1, 1] - c10 * c10)
    c21 = (inertia[2, 1] - c20 * c10) / c11
    c22 = math.sqrt(inertia[2, 2] - c20 * c20 - c21 * c21)
    root = np.array([[c00, 0.0, 0.0], [c10, c11, 0.0], [c20, c21, c22]])
    matrix = np.zeros((6, 6))
    for x, y, z in body.points[face]:
        # A rotation vector w moves the vertex by w × r.
        turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        each = np.concatenate([np.eye(3), _over(turn, root)], axis=1)
        matrix += np.sum(each[:, :, None] * each[:, None, :], axis=0)
    return matrix


def _over(rows: FloatArray, root: FloatArray) -> FloatArray:
    """Rows times the inverse of the transposed lower triangular root, by substitution."""
    out = np.zeros((3, 3))
    for k in range(3):
        known = sum((out[:, i] * root[k, i] for i in range(k)), start=np.zeros(3))
        out[:, k] = (rows[:, k] - known) / root[k, k]
    return out
