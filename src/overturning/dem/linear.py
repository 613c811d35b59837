"""Small dense linear algebra with bit-equal results on all processors, unlike LAPACK."""

import math

import numpy as np

from overturning.arrays import FloatArray


def solve_positive_definite_system(matrix: FloatArray, right_side: FloatArray) -> FloatArray | None:
    """Solve a symmetric positive definite system by elimination with the largest remaining pivot on the diagonal.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Symmetric.
    right_side : ndarray, shape (n,)
        Right-hand side.

    Returns
    -------
    ndarray, shape (n,), or None
        None if the matrix is singular to 1e-12 of its largest diagonal entry: the structure can move without force.
    """
    a, b = matrix.copy(), right_side.copy()
    n = b.size
    largest = float(np.max(np.diag(a))) if n else 0.0
    order: list[int] = []
    left = list(range(n))
    while left:
        pivot = max(left, key=lambda k: float(a[k, k]))
        if not a[pivot, pivot] > 1e-12 * largest:
            return None
        left.remove(pivot)
        for k in left:
            factor = a[k, pivot] / a[pivot, pivot]
            a[k] = a[k] - factor * a[pivot]
            b[k] = b[k] - factor * b[pivot]
        order.append(pivot)
    x = np.zeros(n)
    for position in range(n - 1, -1, -1):
        k = order[position]
        total = b[k]
        for other in order[position + 1 :]:
            total = total - a[k, other] * x[other]
        x[k] = total / a[k, k]
    return x


def highest_eigenvalue(matrix: FloatArray) -> float:
    """Compute the largest eigenvalue of a symmetric matrix by Jacobi rotations.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Symmetric.

    Returns
    -------
    float
        Largest eigenvalue, with a relative accuracy of about 1e-12; 0 for an empty matrix.
    """
    a = matrix.copy()
    n = len(a)
    scale = float(np.max(np.abs(a))) if n else 0.0
    for _ in range(60):
        worst = 0.0
        for i in range(n):
            for k in range(i + 1, n):
                if abs(a[i, k]) <= 1e-14 * scale:
                    continue
                worst = max(worst, abs(float(a[i, k])))
                ratio = float(a[k, k] - a[i, i]) / (2.0 * float(a[i, k]))
                t = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(ratio * ratio + 1.0))
                c = 1.0 / math.sqrt(t * t + 1.0)
                s = t * c
                row_i, row_k = a[i].copy(), a[k].copy()
                a[i], a[k] = c * row_i - s * row_k, s * row_i + c * row_k
                column_i, column_k = a[:, i].copy(), a[:, k].copy()
                a[:, i], a[:, k] = c * column_i - s * column_k, s * column_i + c * column_k
        if worst == 0.0:
            break
    return float(np.max(np.diag(a))) if n else 0.0


def lowest_eigenvalue(matrix: FloatArray) -> float:
    """Compute the smallest eigenvalue of a symmetric positive definite matrix; 0 for an empty or singular one."""
    columns = [solve_positive_definite_system(matrix, unit) for unit in np.eye(len(matrix))]
    inverse = np.array([column for column in columns if column is not None])
    return 1.0 / highest_eigenvalue(0.5 * (inverse + inverse.T)) if len(inverse) == len(matrix) > 0 else 0.0
