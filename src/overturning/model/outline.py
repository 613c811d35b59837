"""Convex outlines with fewer points: of a footprint in the plane, and of a whole body."""

from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from overturning.arrays import FloatArray

MAX_HULL_REFINEMENT_ROUNDS: Final = 60
"""Largest number of rounds in which points are added to an outline."""


STEEP_FACET_MIN_NORMAL_Z: Final = -np.cos(np.radians(45.0))
"""Vertical component of the outward normal above which a facet of a body touches the ground only when it falls."""

HULL_TOLERANCE_FACTOR_FOR_STEEP_FACETS: Final = 8.0
"""Factor on the tolerance of steep facets: a body that touches with them has passed its point of balance."""


def simplified_convex_hull_vertices(
    points: FloatArray,
    max_distance_from_simplified_hull: float,
    always_kept_point_indices: NDArray[np.intp] | None = None,
) -> FloatArray:
    """Return a few of the given points, whose convex hull is smaller than that of all by at most a tolerance (m).

    Parameters
    ----------
    points : ndarray, shape (n, 2) or (n, 3)
        Points, m, that do not lie on one line or in one plane.
    max_distance_from_simplified_hull : float
        Largest distance of a point from the returned hull, m; 0 for all vertices of the hull. In 3-D, it is
        multiplied by `HULL_TOLERANCE_FACTOR_FOR_STEEP_FACETS` at facets that are steeper than 45° or face up.
    always_kept_point_indices : ndarray of int, optional
        Indices of points that the returned hull always encloses, without tolerance.

    Returns
    -------
    ndarray, shape (m, 2) or (m, 3)
        Vertices of the simplified hull; in 2-D anticlockwise.
    """
    whole = scipy.spatial.ConvexHull(points)
    if max_distance_from_simplified_hull <= 0.0:
        return points[whole.vertices]
    vertices = candidates = points[whole.vertices]
    chosen = np.unique(np.concatenate([candidates.argmin(axis=0), candidates.argmax(axis=0)]))
    kept = (
        candidates[chosen]
        if always_kept_point_indices is None
        else np.concatenate([points[always_kept_point_indices], candidates[chosen]])
    )
    for _ in range(MAX_HULL_REFINEMENT_ROUNDS):
        try:
            hull = scipy.spatial.ConvexHull(kept)
        except scipy.spatial.QhullError:  # the first points lie in one plane
            return vertices
        beyond = candidates @ hull.equations[:, :-1].T + hull.equations[:, -1]
        # A point inside stays inside, because the hull only grows.
        outside = beyond.max(axis=1) > max_distance_from_simplified_hull
        if not outside.any():
            return kept[hull.vertices]
        candidates, beyond = candidates[outside], beyond[outside]
        if points.shape[1] == 3:
            beyond /= np.where(
                hull.equations[:, 2] > STEEP_FACET_MIN_NORMAL_Z, HULL_TOLERANCE_FACTOR_FOR_STEEP_FACETS, 1.0
            )
        farthest = beyond.max(axis=0)
        if not (farthest > max_distance_from_simplified_hull).any():
            return kept[hull.vertices]
        # Add the farthest point beyond each facet; small errors wait for the next round, which may not need them.
        facets = farthest > max(max_distance_from_simplified_hull, 0.5 * float(farthest.max()))
        kept = np.concatenate([kept, candidates[np.unique(beyond[:, facets].argmax(axis=0))]])
    return vertices
