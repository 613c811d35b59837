"""Faces on which a convex body can rest, by statics, in 2-D and 3-D."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

FLAT: Final = 1e-6
"""Relative distance within which points lie in one plane or on one line, as a share of the body's size."""


def can_rest(normals: FloatArray, offsets: FloatArray, size: float) -> NDArray[np.bool_]:
    """Return True for each face that contains the foot of the perpendicular from the centre of mass.

    Parameters
    ----------
    normals : ndarray, shape (faces, 2) or (faces, 3)
        Outward unit normals. Faces with the same normal count as one.
    offsets : ndarray, shape (faces,)
        Distances of the faces from the centre of mass, m.
    size : float
        Size of the body, m; a foot closer to an edge than `FLAT` × size does not carry the body.

    Returns
    -------
    ndarray of bool, shape (faces,)
    """
    feet = normals * offsets[:, None]
    beyond = feet @ normals.T - offsets
    beyond[normals @ normals.T > 1.0 - FLAT] = -np.inf
    return np.asarray(beyond.max(axis=1) < -FLAT * size)
