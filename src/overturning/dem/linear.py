"""Small dense linear algebra with bit-equal results on all processors, unlike LAPACK.

The matrices have 3 to some tens of rows: lists of Python floats are several times faster than NumPy's arrays.
"""

import math

import numpy as np

from overturning.arrays import FloatArray


def solve_positive_definite_system(matrix: FloatArray, right_side: FloatArray) -> FloatArray | None:
    """Solve a symmetric positive definite system by elimination with the largest remaining pivot on the diagonal.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Symmetric.
    right_side : ndarray, shape (n,) or (n, m)
        Right-hand side, or a column for each of m right-hand sides.

    Returns
    -------
    ndarray, shape (n,) or (n, m), or None
        None if the matrix is singular to 1e-12 of its largest diagonal entry: the structure can move without force.
    """
    n = len(right_side)
    a, b = matrix.tolist(), (right_side if right_side.ndim > 1 else right_side[:, None]).tolist()
    largest = float(np.max(np.diag(matrix))) if n else 0.0
    order: list[int] = []
    left = list(range(n))
    while left:
        pivot = max(left, key=lambda k: a[k][k])
        row, load = a[pivot], b[pivot]
        if not row[pivot] > 1e-12 * largest:
            return None
        left.remove(pivot)
        for k in left:
            factor = a[k][pivot] / row[pivot]
            a[k] = [value - factor * other for value, other in zip(a[k], row, strict=True)]
            b[k] = [value - factor * other for value, other in zip(b[k], load, strict=True)]
        order.append(pivot)
    for position in range(n - 1, -1, -1):
        k = order[position]
        for other in order[position + 1 :]:
            factor = a[k][other]
            b[k] = [total - factor * known for total, known in zip(b[k], b[other], strict=True)]
        b[k] = [total / a[k][k] for total in b[k]]
    return np.array(b, np.float64).reshape(right_side.shape)


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
    a = matrix.tolist()
    n = len(a)
    scale = float(np.max(np.abs(matrix))) if n else 0.0
    for _ in range(60):
        worst = 0.0
        for i in range(n):
            for k in range(i + 1, n):
                if abs(a[i][k]) <= 1e-14 * scale:
                    continue
                worst = max(worst, abs(a[i][k]))
                ratio = (a[k][k] - a[i][i]) / (2.0 * a[i][k])
                t = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(ratio * ratio + 1.0))
                c = 1.0 / math.sqrt(t * t + 1.0)
                s = t * c
                pairs = list(zip(a[i], a[k], strict=True))
                a[i], a[k] = [c * p - s * q for p, q in pairs], [s * p + c * q for p, q in pairs]
                for row in a:
                    p, q = row[i], row[k]
                    row[i], row[k] = c * p - s * q, s * p + c * q
        if worst == 0.0:
            break
    return float(np.max([a[k][k] for k in range(n)])) if n else 0.0


def lowest_eigenvalue(matrix: FloatArray) -> float:
    """Compute the smallest eigenvalue of a symmetric positive definite matrix; 0 for an empty or singular one."""
    inverse = solve_positive_definite_system(matrix, np.eye(len(matrix)))
    return 1.0 / highest_eigenvalue(0.5 * (inverse + inverse.T)) if inverse is not None and len(matrix) > 0 else 0.0
