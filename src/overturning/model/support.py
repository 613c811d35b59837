"""Contacts and support of the elements of a scene at rest."""

from typing import NamedTuple

import numpy as np

from overturning.errors import ArgumentError
from overturning.model.geometry import (
    MAX_GAP_TO_ELEMENT_SIZE_RATIO_AT_CONTACT,
    ContactPointGeometry,
    ConvexPiecePairIndices,
    PlacedElement,
    SceneElementsAndMaterials,
    _index_pairs_and_gaps_of_movable_elements,
    convex_piece_pairs_with_movable_element,
    convex_pieces_of_each_pair,
    possible_contact_points_of_elements,
    scale_and_place_elements,
)


class TouchingContactPoint(NamedTuple):
    """Contact point at which two elements touch: indices of the convex-piece pair and the point, and geometry."""

    piece_pair_index: int
    point_index_in_pair: int  # 0 or 1
    contact_point: ContactPointGeometry


def touching_contact_points(
    placed_elements: list[PlacedElement],
    piece_pairs: list[ConvexPiecePairIndices],
    max_inclination_of_faces_in_contact_rad: float = 0.0,
) -> list[TouchingContactPoint]:
    """Return the contact points of a scene at rest: those at which two elements touch.

    Two faces that touch at one end and are inclined by less than `max_inclination_of_faces_in_contact_rad` touch at
    both ends.
    """
    touching = []
    for index, (a, b) in enumerate(convex_pieces_of_each_pair(placed_elements, piece_pairs)):
        ends, closed = (
            possible_contact_points_of_elements(a, b),
            MAX_GAP_TO_ELEMENT_SIZE_RATIO_AT_CONTACT
            * min(a.smaller_of_width_and_height, b.smaller_of_width_and_height),
        )
        (x, z), (u, w) = ends[0].vertex_position, ends[1].vertex_position
        far = np.sin(max_inclination_of_faces_in_contact_rad) * np.sqrt((x - u) ** 2 + (z - w) ** 2)
        for side, end in enumerate(ends):
            if end.signed_gap <= closed or (ends[1 - side].signed_gap <= closed and end.signed_gap < far):
                touching.append(TouchingContactPoint(index, side, end))
    return touching


def check_elements_have_support_without_overlap(scene: SceneElementsAndMaterials) -> None:
    """Raise an `ArgumentError` that names the element and a remedy if elements overlap or lack support."""
    if fault := first_overlap_or_support_error_message(scale_and_place_elements(scene)):
        raise ArgumentError(fault)


def first_overlap_or_support_error_message(placed_elements: list[PlacedElement]) -> str:
    """Return an error message for the first element that overlaps another or lacks support; "" if there is none."""
    for i, j, gap in sorted(_index_pairs_and_gaps_of_movable_elements(placed_elements)):
        a, b = placed_elements[i], placed_elements[j]
        if -gap > 1e-6 * min(a.smaller_of_width_and_height, b.smaller_of_width_and_height):
            return (
                f"element {a.element.name}: overlaps {b.element.name} by {-gap:.3g} m; move it, or place it with "
                f"stands_on: {b.element.name}"
            )
    pairs = convex_piece_pairs_with_movable_element(placed_elements)
    carried = {i for i, item in enumerate(placed_elements) if item.has_prescribed_motion}
    ends = touching_contact_points(placed_elements, pairs)
    while more := {
        up
        for index, _, end in ends
        for up, low, sign in (
            (pairs[index].first_element_index, pairs[index].second_element_index, 1.0),
            (pairs[index].second_element_index, pairs[index].first_element_index, -1.0),
        )
        if low in carried and up not in carried and sign * end.normal_from_second_to_first[1] > 1e-3
    }:
        carried |= more
    for i, item in enumerate(placed_elements):
        if i not in carried:
            return (
                f"element {item.element.name}: hangs in the air, nothing carries it; place it with stands_on: and an "
                "element listed before it"
            )
    return ""
