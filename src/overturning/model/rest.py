"""Faces on which a convex body can rest, by statics, in 2-D and 3-D."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO: Final = 1e-6
"""Relative distance within which points lie in one plane or on one line, as a share of the body's size."""

MAX_SINE_OF_COPLANAR_FACES: Final = 1e-6
"""Sine of the angle between two faces below which they lie in one plane: rounding of the normals."""


def mask_of_resting_faces(
    face_normals: FloatArray,
    face_distances_from_centre_of_mass: FloatArray,
    largest_extent: float,
    slice_of_tested_faces: slice = slice(None),
) -> NDArray[np.bool_]:
    """Return a mask of the faces on which a body can rest: the foot of the centre of mass lies inside the face.

    Parameters
    ----------
    face_normals : ndarray, shape (faces, 2) or (faces, 3)
        Outward unit normals. Faces with the same normal count as one. If two faces are inclined by less than √(2
        `FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO`) (0.08°), like triangles of one face with rounded vertices, the foot
        may also lie on their common edge.
    face_distances_from_centre_of_mass : ndarray, shape (faces,)
        Distances of the faces from the centre of mass, m.
    largest_extent : float
        Largest extent of the body, m. A face does not carry the body if the foot is closer to its edge than
        `FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO` × extent.
    slice_of_tested_faces : slice
        Faces to test; default: all.

    Returns
    -------
    ndarray of bool, shape (tested faces,)
    """
    tested = face_normals[slice_of_tested_faces]
    feet = tested * face_distances_from_centre_of_mass[slice_of_tested_faces, None]
    within = face_distances_from_centre_of_mass - feet @ face_normals.T
    cosine = tested @ face_normals.T
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    # Distance of the foot from the line in which the planes of two faces meet.
    margin = np.where(sine < MAX_SINE_OF_COPLANAR_FACES, np.inf, within / np.maximum(sine, MAX_SINE_OF_COPLANAR_FACES))
    least = (
        np.where(
            cosine > 1.0 - FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO,
            -FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO,
            FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO,
        )
        * largest_extent
    )
    return np.asarray((margin > least).all(axis=1))
