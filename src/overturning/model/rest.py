"""On which faces a convex body can rest by statics, in the plane and in space."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

FLAT: Final = 1e-6
"""Distance, as a share of the body's size, within which points lie in one plane or on one line."""


def can_rest(normals: FloatArray, offsets: FloatArray, size: float) -> NDArray[np.bool_]:
    """Whether the foot of the perpendicular from the centre of mass lies within each face: below all others.

    Parameters
    ----------
    normals : ndarray, shape (faces, 2) or (faces, 3)
        Outward, of length 1. Faces with the same normal count as one.
    offsets : ndarray, shape (faces,)
        Distances of the faces from the centre of mass, m.
    size : float
        Of the body, m; a foot nearer to an edge than `FLAT` of it does not carry.

    Returns
    -------
    ndarray of bool, shape (faces,)
    """
    feet = normals * offsets[:, None]
    beyond = feet @ normals.T - offsets
    beyond[normals @ normals.T > 1.0 - FLAT] = -np.inf
    return np.asarray(beyond.max(axis=1) < -FLAT * size)
