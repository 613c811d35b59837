"""Statics of a scene: contact loads at rest, static penetration, contact constants and natural frequencies."""

from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np

from overturning.arrays import FloatArray
from overturning.dem.linear import highest_eigenvalue, lowest_eigenvalue, solve_positive_definite_system
from overturning.model.contact import DEFAULT_CONTACT_DAMPING_RATIO
from overturning.model.geometry import ContactPointGeometry, ConvexPiecePairIndices, PlacedElement
from overturning.model.scene import Scene
from overturning.model.support import TouchingContactPoint, touching_contact_points

MAX_LEAN_COUNTED_AS_FLUSH_RAD: Final = np.radians(0.1)
"""Lean up to which an element counts as standing flush on its face when its tipping angle is computed, rad."""

CONTACT_POINTS_PER_FLUSH_FACE: Final = 2
"""Number of contact points of a face that stands flush on another."""


class LoadedContactPoint(NamedTuple):
    """Contact point loaded at rest: index of the element pair, number (0 or 1), geometry, spring stretches (m)."""

    pair_index: int
    point_number: int
    contact_point: ContactPointGeometry
    normal_spring_compression: float
    tangential_spring_stretch: float


class ContactPointDisplacementDerivatives(NamedTuple):
    """Contact point at rest, with the derivatives of its approach and slip by the displacements of all elements."""

    contact_point: TouchingContactPoint
    approach_derivatives: FloatArray
    """By x, z and rotation of each free element, shape (3 · free elements,)."""
    slip_derivatives: FloatArray
    """As `approach`."""


@dataclass(frozen=True)
class ContactConstantsByPair:
    """Contact constants for each pair of elements that can touch, arrays of shape (pairs,)."""

    normal_stiffness: FloatArray  # K_n, N/m
    tangential_stiffness: FloatArray  # K_s, N/m
    dashpot_coefficient: FloatArray  # h, N·s/m, in both directions
    friction_coefficient: FloatArray  # µ; −1 if the pair takes the friction of the case
    carried_weight_at_rest: FloatArray  # weight at rest, N
    gravity_load_for_contact_stiffness: (
        FloatArray  # weight for which the contact is made, N: that at rest, or of the lighter element
    )


def _displacement_slices_of_free_elements(elements: list[PlacedElement]) -> dict[int, slice]:
    """Return, for each free element, the slice of its x, z and clockwise rotation in the displacement vector."""
    free = [i for i, item in enumerate(elements) if not item.has_prescribed_motion]
    return {i: slice(3 * n, 3 * n + 3) for n, i in enumerate(free)}


def contact_points_at_rest_with_derivatives(
    elements: list[PlacedElement], pairs: list[ConvexPiecePairIndices], max_angle_between_faces_rad: float = 0.0
) -> list[ContactPointDisplacementDerivatives]:
    """Return the contact points of the elements at rest, with derivatives of approach and slip by displacements.

    Two faces touch if the angle between them is at most `max_angle_between_faces_rad`, rad.
    """
    return _contact_points_with_displacement_derivatives(
        elements, pairs, touching_contact_points(elements, pairs, max_angle_between_faces_rad)
    )


def _contact_points_with_displacement_derivatives(
    elements: list[PlacedElement], pairs: list[ConvexPiecePairIndices], touching_points: list[TouchingContactPoint]
) -> list[ContactPointDisplacementDerivatives]:
    """Return contact points with the derivatives of their approach and slip by the elements' displacements."""
    return [
        ContactPointDisplacementDerivatives(
            touch,
            *_contact_point_displacement_derivatives(elements, pairs[touch.piece_pair_index], touch.contact_point),
        )
        for touch in touching_points
    ]


def loaded_points_with_small_inclinations_ignored(
    scene: Scene,
    elements: list[PlacedElement],
    pairs: list[ConvexPiecePairIndices],
    point_derivatives: list[ContactPointDisplacementDerivatives],
    loaded_points: list[LoadedContactPoint],
) -> list[LoadedContactPoint]:
    """Return the contact points loaded at rest; faces inclined by less than a limit count as flush.

    Otherwise a lean of 1e-6 rad would leave the whole scene without static equilibrium, and without tipping angles. An
    element that leans by more is held fixed if the other elements have no equilibrium without this.
    """
    flush = contact_points_at_rest_with_derivatives(elements, pairs, MAX_LEAN_COUNTED_AS_FLUSH_RAD)
    if len(flush) == len(point_derivatives) and (loaded_points or not point_derivatives):
        return loaded_points
    upper = [
        pairs[pair].first_element_index if end.normal_from_second_to_first[1] > 0 else pairs[pair].second_element_index
        for (pair, _, end), _, _ in flush
    ]
    leaning = {
        k
        for k, item in enumerate(elements)
        if not item.has_prescribed_motion and upper.count(k) < CONTACT_POINTS_PER_FLUSH_FACE
    }
    held = [
        replace(item, element=item.element.model_copy(update={"kind": "held"})) if k in leaning else item
        for k, item in enumerate(elements)
    ]
    ones = np.ones(len(pairs))
    # A wall next to a leaning element does not carry its weight: if necessary, try again without friction on faces.
    for items, tangential in ((elements, ones), (elements, 0.0 * ones), (held, ones)):
        free = {k for k, item in enumerate(items) if not item.has_prescribed_motion}
        ends = [
            joint.contact_point for joint in flush if free.intersection(pairs[joint.contact_point.piece_pair_index][:2])
        ]
        found = (
            static_equilibrium(
                scene, items, _contact_points_with_displacement_derivatives(items, pairs, ends), ones, tangential
            )
            if free
            else None
        )
        if found is not None:
            return found[1]
    return []


def _contact_point_displacement_derivatives(
    elements: list[PlacedElement], pair: ConvexPiecePairIndices, touching_point: ContactPointGeometry
) -> tuple[FloatArray, FloatArray]:
    """Return derivatives of a contact point's approach and slip by the n free elements' displacements, (3 n,) each."""
    number = _displacement_slices_of_free_elements(elements)
    approach, slip = np.zeros(3 * len(number)), np.zeros(3 * len(number))
    for k, sign in ((pair.first_element_index, 1.0), (pair.second_element_index, -1.0)):
        if k in number:
            rx, rz = (
                touching_point.vertex_position[0] - elements[k].centre_of_mass_x,
                touching_point.vertex_position[1] - elements[k].centre_of_mass_z,
            )
            for row, (ux, uz), direction in (
                (approach, touching_point.normal_from_second_to_first, -1.0),
                (slip, touching_point.positive_slip_direction_of_first_element, 1.0),
            ):
                row[number[k]] = sign * direction * np.array([ux, uz, ux * rz - uz * rx])
    return approach, slip


def _contact_stiffness_matrix(
    displacement_count: int,
    point_derivatives: list[ContactPointDisplacementDerivatives],
    normal_stiffness_by_pair: FloatArray,
    tangential_stiffness_by_pair: FloatArray,
) -> FloatArray:
    """Return the stiffness matrix of all contact springs, shape (`displacement_count`, `displacement_count`).

    If the arguments are dashpot constants instead of stiffnesses, the result is the damping matrix.
    """
    matrix = np.zeros((displacement_count, displacement_count))
    for touch, approach, slip in point_derivatives:
        matrix += normal_stiffness_by_pair[touch.piece_pair_index] * np.outer(
            approach, approach
        ) + tangential_stiffness_by_pair[touch.piece_pair_index] * np.outer(slip, slip)
    return matrix


def static_equilibrium(
    scene: Scene,
    elements: list[PlacedElement],
    point_derivatives: list[ContactPointDisplacementDerivatives],
    normal_stiffness_by_pair: FloatArray,
    tangential_stiffness_by_pair: FloatArray,
) -> tuple[FloatArray, list[LoadedContactPoint]] | None:
    """Return displacements and loaded contact points of a scene in equilibrium on its springs, without tension.

    Returns
    -------
    tuple of ndarray and list of LoadedContactPoint, or None
        Displacements of the elements, shape (elements, 3), m and rad, and the contact points that carry load. None
        without equilibrium: an element slides off or falls by itself.
    """
    # A frictionless contact has no tangential spring; a very soft one keeps the matrix regular.
    held, point_derivatives = (
        np.maximum(tangential_stiffness_by_pair, 1e-9 * normal_stiffness_by_pair),
        point_derivatives.copy(),
    )
    number = _displacement_slices_of_free_elements(elements)
    load = np.concatenate([(0.0, -elements[k].mass * scene.gravity, 0.0) for k in number])
    while point_derivatives:
        solution = solve_positive_definite_system(
            _contact_stiffness_matrix(load.size, point_derivatives, normal_stiffness_by_pair, held), load
        )
        if solution is None:
            return None
        ends = [
            LoadedContactPoint(*touch, float((approach * solution).sum()), float((slip * solution).sum()))
            for touch, approach, slip in point_derivatives
        ]
        least = min(ends, key=lambda end: end.normal_spring_compression)
        if least.normal_spring_compression > 1e-9 * max(end.normal_spring_compression for end in ends):
            displacement = np.zeros((len(elements), 3))
            for k, at in number.items():
                displacement[k] = solution[at]
            return displacement, ends
        del point_derivatives[ends.index(least)]  # this point is in tension
    return None


def compute_pair_contact_laws(
    scene: Scene,
    elements: list[PlacedElement],
    pairs: list[ConvexPiecePairIndices],
    point_derivatives: list[ContactPointDisplacementDerivatives],
) -> ContactConstantsByPair:
    """Return springs, dashpots and friction of all contacts; stiffness "auto" follows from the load at rest.

    A pair that carries the weight W over a common stretch of width B penetrates by δ = W/(2 K_n); δ/B is the
    `static_penetration` of its contact law. A pair that does not touch at rest gets the spring that its lighter free
    element would have while standing on its smaller side.
    """
    ones = np.ones(len(pairs))
    equilibrium = static_equilibrium(scene, elements, point_derivatives, ones, ones)
    whole = [pair[:2] for pair in pairs]
    together = np.array(
        [whole.index(both) for both in whole], dtype=np.int64
    )  # pairs of pieces of the same two elements
    carried, width = np.zeros(len(pairs)), np.zeros(len(pairs))
    for end in equilibrium[1] if equilibrium is not None else ():
        carried[together[end.pair_index]] += end.normal_spring_compression
    for one, other in combinations((joint.contact_point for joint in point_derivatives), 2):
        if together[one.piece_pair_index] == together[other.piece_pair_index]:
            (x, z), (u, w) = one.contact_point.vertex_position, other.contact_point.vertex_position
            apart = np.sqrt((x - u) ** 2 + (z - w) ** 2)  # libm's hypot depends on the processor
            width[together[one.piece_pair_index]] = max(width[together[one.piece_pair_index]], apart)
    carried, width = carried[together], width[together]
    normal, tangential, dashpot, friction, weights = (np.zeros(len(pairs)) for _ in range(5))
    for index, pair in enumerate(pairs):
        a, b = elements[pair.first_element_index], elements[pair.second_element_index]
        law = scene.contact_law(a.element, b.element)
        free = [item for item in (a, b) if not item.has_prescribed_motion]
        depth = min(a.element.depth, b.element.depth)
        lightest = min(free, key=lambda item: item.mass)
        weight = carried[index]
        # A contact with hardly any load at rest must still be stiff enough for impacts.
        if weight < 0.01 * lightest.mass * scene.gravity:
            weight = lightest.mass * scene.gravity
        weights[index] = weight
        stretch = (
            width[index]
            if width[index] > 0.01 * lightest.smaller_of_width_and_height
            else lightest.smaller_of_width_and_height
        )
        if law.stiffness == "auto":
            normal[index] = weight / (2.0 * law.static_penetration * stretch)
        else:
            normal[index] = law.stiffness * depth
        tangential[index] = law.stiffness_ratio * normal[index]
        if law.damping is not None:
            dashpot[index] = law.damping * depth
        else:
            ratio = DEFAULT_CONTACT_DAMPING_RATIO if law.damping_ratio is None else law.damping_ratio
            dashpot[index] = 2.0 * ratio * np.sqrt(0.5 * normal[index] * (weight / scene.gravity))
        friction[index] = -1.0 if law.friction is None else law.friction
    return ContactConstantsByPair(normal, tangential, dashpot, friction, carried, weights)


def largest_spring_and_dashpot_eigenvalues(
    elements: list[PlacedElement],
    pairs: list[ConvexPiecePairIndices],
    point_derivatives: list[ContactPointDisplacementDerivatives],
    pair_laws: ContactConstantsByPair,
) -> tuple[float, float]:
    """Return the largest eigenvalues of the springs (ω², 1/s²) and of the dashpots (1/s) for the stable time step.

    Each is the larger of two values: the eigenvalue of the scene at rest, and the largest, of all pairs touching at one
    vertex, of K (1/m + r²/I) summed over both elements; r is the distance of an element's farthest vertex from its
    centre. For a rectangle on a fixed element the second value is 4 K/m.
    """
    root, values = _inverse_root_masses_and_inertias(elements), []
    for normal, tangential in (
        (pair_laws.normal_stiffness, pair_laws.tangential_stiffness),
        (pair_laws.dashpot_coefficient, pair_laws.dashpot_coefficient),
    ):
        matrix = _contact_stiffness_matrix(root.size, point_derivatives, normal, tangential)
        highest = highest_eigenvalue(root[:, None] * matrix * root)
        for index, pair in enumerate(pairs):
            compliance = 0.0
            for item in (elements[k] for k in pair[:2] if not elements[k].has_prescribed_motion):
                radius = float((item.shape.vertices_from_whole_polygon_centroid**2).sum(axis=1).max())
                compliance += 1.0 / item.mass + radius / item.inertia_about_centre_of_mass
            highest = max(highest, max(normal[index], tangential[index]) * compliance)
        values.append(float(highest))
    return values[0], values[1]


def lowest_omega_squared_on_springs(
    elements: list[PlacedElement],
    point_derivatives: list[ContactPointDisplacementDerivatives],
    pair_laws: ContactConstantsByPair,
) -> float:
    """Return the lowest eigenvalue ω² of a scene on its contact springs, 1/s²; 0 if an element moves freely."""
    root = _inverse_root_masses_and_inertias(elements)
    matrix = _contact_stiffness_matrix(
        root.size, point_derivatives, pair_laws.normal_stiffness, pair_laws.tangential_stiffness
    )
    return lowest_eigenvalue(root[:, None] * matrix * root)


def _inverse_root_masses_and_inertias(elements: list[PlacedElement]) -> FloatArray:
    """Return 1/√m, 1/√m, 1/√I of each free element (m in kg, I in kg m²), shape (3 · free elements,)."""
    free = [item for item in elements if not item.has_prescribed_motion]
    return np.sqrt(
        np.concatenate([(1.0 / item.mass, 1.0 / item.mass, 1.0 / item.inertia_about_centre_of_mass) for item in free])
    )
