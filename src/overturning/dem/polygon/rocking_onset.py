"""Base acceleration at which groups of stacked elements of a scene start to rock as one body."""

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.geometry import ContactPointGeometry, PlacedElement

Elements = list[PlacedElement]


LoadedContactPointsByElementAndCarrier = dict[int, dict[int, list[ContactPointGeometry]]]
"""Loaded contact points, by the element that stands on them and the element that carries it."""


def rocking_onset_acceleration_g_of_scene_and_groups(
    elements: Elements, supports: LoadedContactPointsByElementAndCarrier
) -> tuple[float, NDArray[np.int64], FloatArray]:
    """Return the base accelerations |a|/g at which a scene and each of its groups of elements start to rock.

    A group, which rocks as one body, is an element with elements that stand on it, directly or not. It lifts off when
    the resultant of weight and inertia force leaves its base: |a|/g > arm / height of the common centre.

    Returns
    -------
    threshold : float
        Smallest |a|/g over all elements, each with everything that it carries.
    groups : ndarray of int64, shape (groups, 2)
        Indices of each group's lowest element and of its last in the scene's list; it exists only while both stand.
    least : ndarray, shape (groups,)
        Smallest |a|/g of all groups with these two elements. `threshold` and `least` are 0 if an element does not stand
        on exactly one other: there is no closed form then.
    """
    free = [k for k, item in enumerate(elements) if not item.has_prescribed_motion]
    if any(len(supports.get(k, {})) != 1 for k in free):
        return 0.0, np.array([(k, k) for k in free]), np.zeros(len(free))
    threshold, groups = np.inf, dict[tuple[int, int], float]()
    for k in free:
        points = [end.vertex_position for ends in supports[k].values() for end in ends]
        for side in (-1.0, 1.0):
            edge = max(points, key=lambda point: side * point[0])
            whole = _indices_of_elements_overturning_together(elements, supports, k, max(free), edge, side, -np.inf)
            threshold = min(threshold, _uplift_acceleration_g_of_group(elements, whole, edge, side))
            for last in whole:
                least = _uplift_acceleration_g_of_group(
                    elements, _indices_of_elements_overturning_together(elements, supports, k, last, edge, side,
                    -np.inf),
                    edge, side,
                )  # fmt: skip
                # Leave out elements that hold the group down at this acceleration, until the result no longer changes.
                while (
                    less := _uplift_acceleration_g_of_group(
                        elements,
                        _indices_of_elements_overturning_together(elements, supports, k, last, edge, side, least),
                        edge,
                        side,
                    )
                ) < least:
                    least = less
                groups[k, last] = min(groups.get((k, last), np.inf), max(least, 0.0))
    return max(threshold, 0.0), np.array(list(groups)), np.array(list(groups.values()))


def _uplift_acceleration_g_of_group(
    elements: Elements,
    group_element_indices: list[int],
    pivot_x_and_z: tuple[float, float],
    x_sign_of_rocking_direction: float,
) -> float:
    """Return the base acceleration |a|/g at which a group of elements starts to rock about an edge, to −x or +x.

    `x_sign_of_rocking_direction` is −1 or +1.
    """
    mass = sum(elements[n].mass for n in group_element_indices)
    x = sum(elements[n].mass * elements[n].centre_of_mass_x for n in group_element_indices) / mass
    z = sum(elements[n].mass * elements[n].centre_of_mass_z for n in group_element_indices) / mass
    return float(x_sign_of_rocking_direction * (pivot_x_and_z[0] - x) / (z - pivot_x_and_z[1]))


def _indices_of_elements_overturning_together(
    elements: Elements,
    supports: LoadedContactPointsByElementAndCarrier,
    lowest_element_index: int,
    max_element_index_in_group: int,
    pivot_x_and_z: tuple[float, float],
    x_sign_of_rocking_direction: float,
    base_acceleration_over_g: float,
) -> list[int]:
    """Return the indices of an element and of the elements on it that overturn with it at a base acceleration.

    Elements with an index above `max_element_index_in_group` are left out. `base_acceleration_over_g` is |a|/g;
    −infinity includes all other elements that stand on the lowest one.
    """

    def restoring_moment_over_g_and_overturned_elements(element_index: int) -> tuple[float, list[int]]:
        """Return restoring moment over g (kg m) and indices of an element and the elements on it that overturn too."""
        item, whole = elements[element_index], base_acceleration_over_g == -np.inf
        arm, height = (
            x_sign_of_rocking_direction * (pivot_x_and_z[0] - item.centre_of_mass_x),
            item.centre_of_mass_z - pivot_x_and_z[1],
        )
        held = 0.0 if whole else item.mass * (arm - base_acceleration_over_g * height)
        part = [element_index]
        for moment, more in map(
            restoring_moment_over_g_and_overturned_elements,
            (n for n in range(max_element_index_in_group + 1) if element_index in supports.get(n, ())),
        ):
            if whole or moment < 0.0 or max_element_index_in_group in more:
                held, part = held + moment, part + more
        return held, part

    return sorted(restoring_moment_over_g_and_overturned_elements(lowest_element_index)[1])
