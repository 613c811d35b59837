"""Faces on which a convex body can rest, by statics, in 2-D and 3-D."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

FLAT: Final = 1e-6
"""Relative distance within which points lie in one plane or on one line, as a share of the body's size."""


def mask_of_resting_faces(
    face_normals: FloatArray, distances_of_vertices_from_faces: FloatArray, body_size: float
) -> NDArray[np.bool_]:
    """Return a mask of the faces on which a body can rest: the foot of the centre of mass lies inside the face.

    Parameters
    ----------
    face_normals : ndarray, shape (faces, 2) or (faces, 3)
        Outward unit normals. Faces with the same normal count as one.
    distances_of_vertices_from_faces : ndarray, shape (faces,)
        Distances of the faces from the centre of mass, m.
    body_size : float
        Size of the body, m; a foot closer to an edge than `FLAT` × size does not carry the body.

    Returns
    -------
    ndarray of bool, shape (faces,)
    """
    feet = face_normals * distances_of_vertices_from_faces[:, None]
    beyond = feet @ face_normals.T - distances_of_vertices_from_faces
    beyond[face_normals @ face_normals.T > 1.0 - FLAT] = -np.inf
    return np.asarray(beyond.max(axis=1) < -FLAT * body_size)
