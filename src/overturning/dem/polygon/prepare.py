"""Preparation of a scene at one size: element pairs, contact constants, equilibrium, eigenvalues, onset of motion."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.limits import static_penetration_exceeds_limit
from overturning.dem.polygon.rocking_onset import (
    Elements,
    LoadedContactPointsByElementAndCarrier,
    rocking_onset_acceleration_g_of_scene_and_groups,
)
from overturning.dem.polygon.statics import (
    ContactConstantsByPair,
    LoadedContactPoint,
    compute_pair_contact_laws,
    contact_points_at_rest_with_derivatives,
    largest_spring_and_dashpot_eigenvalues,
    loaded_points_with_small_inclinations_ignored,
    lowest_omega_squared_on_springs,
    static_equilibrium,
)
from overturning.model.geometry import (
    ConvexPiecePairIndices,
    PlacedElement,
    convex_piece_pairs_with_movable_element,
    scale_and_place_elements,
    wide_ground_element_name,
)
from overturning.model.scene import Scene
from overturning.model.support import first_overlap_or_support_error_message


@dataclass(frozen=True)
class SceneEquilibriumStiffnessAndRockingLimits:
    """Scene of one size: static equilibrium, contact constants, and base accelerations at which motion starts."""

    scene: Scene
    elements: list[PlacedElement]
    pairs: list[ConvexPiecePairIndices]  # elements, or their convex pieces, that can meet
    pair_contact_laws: ContactConstantsByPair
    static_displacements: FloatArray  # shape (elements, 3): x, z (m) and rotation (rad) at rest, relative to `elements`
    contact_points_loaded_at_rest: list[LoadedContactPoint]  # contact points that carry load at rest
    has_static_equilibrium: bool  # True if the scene has a static equilibrium
    max_omega_squared_on_springs: float  # largest eigenvalue of the springs, 1/s²
    max_dashpot_eigenvalue: float  # largest eigenvalue of the dashpots, 1/s
    min_omega_squared_on_springs: float  # smallest eigenvalue of the springs at rest, 1/s²
    no_rocking_below_acceleration_g: float  # |a|/g below which no element can start to rock; 0 if unknown
    lowest_and_last_element_index_by_rocking_group: NDArray[np.int64]  # (groups, 2): elements that rock as one
    rocking_onset_acceleration_g_by_group: FloatArray  # (groups,): |a|/g below which a group cannot start to rock
    tipping_angles_by_element_and_side: FloatArray  # (elements, 2): to −x and +x, rad; infinite: none
    weaker_side_critical_angles_else_fall_angles: (
        FloatArray  # (elements,): α, the smaller of both, rad; without one the angle of its fall
    )
    overturning_energies: FloatArray  # shape (elements,): energy to overturn each free element, J
    support_element_indices: NDArray[np.int64]  # (elements,): first element that carries it, or its own index
    element_base_midpoints: FloatArray  # shape (elements, 2): middle of the stretch on which it stands, m
    carrier_indices_by_element: list[set[int]]  # elements that carry each element at rest
    has_no_overlapping_or_floating_element: bool  # False if an element overlaps another or hangs in the air at this B/H

    @property
    def free_element_indices(self) -> NDArray[np.int64]:
        """Indices of the elements that forces can move (neither driven nor held), in the list of all elements."""
        return np.array([k for k, item in enumerate(self.elements) if not item.has_prescribed_motion], dtype=np.int64)

    @property
    def piece_vertex_counts(self) -> list[int]:
        """Number of vertices of each convex piece, in the order of the elements."""
        return [
            len(part.vertices_from_whole_polygon_centroid) for item in self.elements for part in item.shape.convex_parts
        ]

    @property
    def tipping_angles(self) -> FloatArray:
        """Smaller of each element's tipping angles α to −x and +x, rad, shape (elements,); NaN if it has none."""
        return np.where(
            np.isfinite(self.tipping_angles_by_element_and_side).all(axis=1),
            self.weaker_side_critical_angles_else_fall_angles,
            np.nan,
        )

    @property
    def max_recoverable_rotations_by_side(self) -> FloatArray:
        """Rotations to −x and +x from which each element can still return, rad, shape (elements, 2).

        These are the tipping angles or, without one, the angle at which the element has fallen.
        """
        angles = self.tipping_angles_by_element_and_side
        return np.where(np.isfinite(angles), angles, self.weaker_side_critical_angles_else_fall_angles[:, None])

    @property
    def tipping_angles_or_one_degree_in_rad(self) -> FloatArray:
        """Divisor of each element's peak rotation, rad, shape (elements,): its tipping angle α, or 1° without one."""
        return np.where(
            np.isnan(self.tipping_angles), np.radians(1.0), self.weaker_side_critical_angles_else_fall_angles
        )

    @property
    def mean_static_penetration_of_each_loaded_pair(self) -> FloatArray:
        """Mean static penetration of each pair of elements in contact at rest, m, shape (loaded contacts,)."""
        loaded = self.pair_contact_laws.carried_weight_at_rest > 0.0
        return self.pair_contact_laws.carried_weight_at_rest[loaded] / (
            2.0 * self.pair_contact_laws.normal_stiffness[loaded]
        )

    @property
    def static_penetration_exceeds_limit(self) -> bool:
        """True if the weight alone makes the penetration between two elements exceed the limit of the contact law."""
        smallest_side = smallest_free_element_side(self.elements)
        return bool(
            static_penetration_exceeds_limit(self.mean_static_penetration_of_each_loaded_pair, smallest_side).any()
        )

    @property
    def has_too_soft_contacts_or_invalid_placement(self) -> bool:
        """True if no case can have an outcome: at rest, penetration is too large, or elements overlap or float."""
        return self.static_penetration_exceeds_limit or not self.has_no_overlapping_or_floating_element

    @property
    def shortest_rocking_time_constant(self) -> float:
        """Time constant 1/p of the element that rocks fastest, s: p = √(3g/4R), R its largest vertex distance."""
        outlines = [self.elements[k].shape.vertices_from_whole_polygon_centroid for k in self.free_element_indices]
        square = min(float((outline**2).sum(axis=1).max()) for outline in outlines)
        return float(np.sqrt(np.sqrt(square) / (0.75 * self.scene.gravity)))

    @property
    def top_height_of_free_elements(self) -> float:
        """Height of the highest point of the free elements, m."""
        return max(float(self.elements[k].vertices_in_scene[:, 1].max()) for k in self.free_element_indices)

    @property
    def half_diagonal_of_scene_height_and_widest_element(self) -> float:
        """Half the diagonal of a box as high as the scene and as wide as its widest free element, m."""
        low = min(float(self.elements[k].vertices_in_scene[:, 1].min()) for k in self.free_element_indices)
        wide = max(self.elements[k].shape.width for k in self.free_element_indices)
        return 0.5 * float(np.sqrt((self.top_height_of_free_elements - low) ** 2 + wide**2))

    @cached_property
    def slip_distance_to_ground_edge_by_element(self) -> FloatArray:
        """Slip (m) at which each element leaves the edge of the ground; infinite for elements that stand on others."""
        ground = wide_ground_element_name(self.scene)
        far = [0.5 * item.shape.width if item.element.name == ground else np.inf for item in self.elements]
        supports, centres = self.support_element_indices, self.element_base_midpoints
        places = [item.centre_of_mass_x for item in self.elements]
        return np.array([far[on] - abs(x - places[on]) for on, (x, _) in zip(supports, centres, strict=True)])

    def support_and_held_stack_bottom_indices(self, element_index: int) -> tuple[int, int]:
        """Return the indices of an element's support and of its stack's lowest element (−1 if that is not held)."""
        supports, last = self.support_element_indices, element_index
        while not self.elements[last].has_prescribed_motion and supports[last] != last:
            last = int(supports[last])
        return int(supports[element_index]), last if self.elements[last].element.kind == "held" else -1

    def motion_onset_acceleration_g(self, friction_if_law_has_none: FloatArray) -> FloatArray:
        """Return the base acceleration |a|/g below which no element moves, for each given friction coefficient."""
        return np.minimum(
            self.no_rocking_below_acceleration_g, self.sliding_onset_acceleration_g(friction_if_law_has_none)
        )

    def sliding_onset_acceleration_g(self, friction_if_law_has_none: FloatArray) -> FloatArray:
        """Return the base acceleration |a|/g at which the first element starts to slide, for each friction coefficient.

        The result is µ on a level face, (µ − t)/(1 + µ t) on a face with slope t, 0 if an element slides at rest.
        """
        least = np.full(friction_if_law_has_none.shape, np.inf)
        for end in self.contact_points_loaded_at_rest:
            mu = self.pair_contact_laws.friction_coefficient[end.pair_index]
            x, z = np.abs(end.contact_point.normal_from_second_to_first)
            held = friction_if_law_has_none if mu < 0 else np.full(friction_if_law_has_none.shape, mu)
            least = np.minimum(least, np.maximum(held * z - x, 0.0) / np.maximum(z + held * x, 1e-300))
        return least


def prepare_scene(
    scene: Scene, reference_element_height: float | None = None, reference_element_b_over_h: float | None = None
) -> SceneEquilibriumStiffnessAndRockingLimits:
    """Compute equilibrium, contact constants and onset of motion of a scene of one size.

    Height (m) and B/H of the reference element set the size; where they are None, those of the scene file apply.
    """
    placed = scale_and_place_elements(scene, reference_element_height, reference_element_b_over_h)
    pairs = convex_piece_pairs_with_movable_element(placed)
    joints = contact_points_at_rest_with_derivatives(placed, pairs)
    laws = compute_pair_contact_laws(scene, placed, pairs, joints)
    equilibrium = static_equilibrium(scene, placed, joints, laws.normal_stiffness, laws.tangential_stiffness)
    displacement, loaded = equilibrium or (np.zeros((len(placed), 3)), [])
    bearing = loaded_points_with_small_inclinations_ignored(scene, placed, pairs, joints, loaded)
    stands = _loaded_contact_points_by_element_and_carrier(placed, pairs, bearing)
    threshold, parts, safe = rocking_onset_acceleration_g_of_scene_and_groups(placed, stands)
    if equilibrium is None or any(item.element.kind == "held" for item in placed):
        threshold, safe = 0.0, 0.0 * safe  # a held element moves relative to the others
    mu = laws.friction_coefficient
    if any(
        mu[k] >= 0 and laws.tangential_stiffness[k] * abs(slip) > mu[k] * laws.normal_stiffness[k] * approach
        for k, _, _, approach, slip in loaded
    ):
        threshold = 0.0  # an element slides by its own weight
    tips, critical, barrier, support, base = _tipping_angles_energies_and_supports(
        scene, placed, stands, _mask_of_elements_with_parallel_contact_normals(placed, pairs, bearing)
    )
    return SceneEquilibriumStiffnessAndRockingLimits(
        scene, placed, pairs, laws, displacement, loaded, equilibrium is not None,
        *largest_spring_and_dashpot_eigenvalues(placed, pairs, joints, laws),
        lowest_omega_squared_on_springs(placed, joints, laws),
        threshold, parts, safe, tips, critical, barrier, support, base,
        [set(stands.get(k, {})) for k in range(len(placed))],
        reference_element_b_over_h is None or not first_overlap_or_support_error_message(placed),
    )  # fmt: skip


def reason_scene_moves_by_itself(
    scene: Scene,
    reference_element_height: float | None,
    reference_element_b_over_h: float,
    friction_if_law_has_none: float,
) -> str:
    """Return the reason why elements of a scene move without any motion of the ground; an empty text if they rest."""
    prepared = prepare_scene(scene, reference_element_height, reference_element_b_over_h)
    if not prepared.has_static_equilibrium:
        return "the scene has no equilibrium at rest: an element falls or slides without an earthquake"
    # Forces of each face on its springs: the corners of a face share its friction.
    laws, across, along = prepared.pair_contact_laws, np.zeros(len(prepared.pairs)), np.zeros(len(prepared.pairs))
    for pair, _, _, approach, slip in prepared.contact_points_loaded_at_rest:
        across[pair] += laws.normal_stiffness[pair] * approach
        along[pair] += laws.tangential_stiffness[pair] * slip
    coefficient = np.where(laws.friction_coefficient < 0.0, friction_if_law_has_none, laws.friction_coefficient)
    if np.any(np.abs(along) > coefficient * across + 1e-9 * across.max(initial=0.0)):
        return "an element slides down its face without an earthquake: its friction is less than the slope"
    return ""


def free_element_critical_angles_deg(scene: Scene, reference_element_b_over_h_values: FloatArray) -> FloatArray:
    """Return the tipping angle α (degrees) of each free element, shape (B/H values, free elements)."""
    prepared = (prepare_scene(scene, None, float(ratio)) for ratio in reference_element_b_over_h_values)
    return np.stack([np.degrees(item.tipping_angles[item.free_element_indices]) for item in prepared])


CRITICAL_ANGLE_ATTRIBUTES: Final = {
    "units": "degree",
    "long_name": "critical angle, at which an element tips off what carries it as it stands in the scene",
    "comment": "missing where it has none of its own, as an arch stone or one that leans: "
    "its peak_rotation is in degrees",
}
"""CF attributes of the critical angles of a scene."""


def smallest_free_element_side(elements: Elements) -> float:
    """Return the smallest side of any free element, m."""
    return min(item.smaller_of_width_and_height for item in elements if not item.has_prescribed_motion)


MAX_SINE_BETWEEN_PARALLEL_NORMALS: Final = 0.05
"""Sine of the angle between two normals up to which they count as parallel."""

MIN_TIPPING_ANGLE_OF_STANDING_ELEMENT_RAD: Final = 1e-6
"""Smallest tipping angle, rad; an element with a smaller one counts as having none."""


def _loaded_contact_points_by_element_and_carrier(
    elements: Elements, pairs: list[ConvexPiecePairIndices], loaded_points: list[LoadedContactPoint]
) -> LoadedContactPointsByElementAndCarrier:
    """Return the contact points loaded at rest, by the free element that stands on them and the one that carries it."""
    result: LoadedContactPointsByElementAndCarrier = {}
    for index, _, end, _, _ in loaded_points:
        i, j = pairs[index][:2]
        upper, lower = (i, j) if end.normal_from_second_to_first[1] > 0 else (j, i)
        if not elements[upper].has_prescribed_motion and abs(end.normal_from_second_to_first[1]) > 1e-3:
            result.setdefault(upper, {}).setdefault(lower, []).append(end)
    return result


def _mask_of_elements_with_parallel_contact_normals(
    elements: Elements, pairs: list[ConvexPiecePairIndices], loaded_points: list[LoadedContactPoint]
) -> NDArray[np.bool_]:
    """Return a mask of the free elements that stand freely: all their loaded contacts have parallel normals.

    Its shape is (elements,). An arch stone, a stone in a groove and one that leans on a wall are held by faces that are
    not parallel; they have no tipping angle.
    """
    normals: list[list[tuple[float, float]]] = [[] for _ in elements]
    for index, _, end, _, _ in loaded_points:
        for k in pairs[index][:2]:
            normals[k].append(end.normal_from_second_to_first)
    result = np.zeros(len(elements), np.bool_)
    for k, found in enumerate(normals):
        directions = np.array(found).reshape(-1, 2)
        across = np.outer(directions[:, 0], directions[:, 1])
        result[k] = (
            not elements[k].has_prescribed_motion
            and len(found) > 0
            and bool((np.abs(across - across.T) < MAX_SINE_BETWEEN_PARALLEL_NORMALS).all())
        )
    return result


def _tipping_angles_energies_and_supports(
    scene: Scene,
    elements: Elements,
    supports: LoadedContactPointsByElementAndCarrier,
    parallel_contact_normals_element_mask: NDArray[np.bool_],
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64], FloatArray]:
    """Return each element's tipping angles, critical angle, overturning energy, support index and base midpoint.

    The fields of `SceneEquilibriumStiffnessAndRockingLimits` give units and shapes.
    """
    count = len(elements)
    tips, critical, barrier = np.full((count, 2), np.inf), np.full(count, 0.5 * np.pi), np.zeros(count)
    support, base = np.arange(count), np.array([[item.centre_of_mass_x, item.centre_of_mass_z] for item in elements])
    for k, item in enumerate(elements):
        if item.has_prescribed_motion:
            continue
        ends = [(lower, end.vertex_position) for lower, all_ends in supports.get(k, {}).items() for end in all_ends]
        rests = bool(ends)
        if not ends:  # no support at rest: take the lowest vertices instead
            low = item.vertices_in_scene[:, 1].min()
            near = low + 0.01 * item.smaller_of_width_and_height
            ends = [(k, (float(x), float(z))) for x, z in item.vertices_in_scene if z < near]
        support[k] = ends[0][0]
        base[k] = np.mean([point for _, point in ends], axis=0)
        reach, lift = [], []
        for side in (-1.0, 1.0):
            _, point = max(ends, key=lambda entry: side * entry[1][0])
            arm, rise = side * (point[0] - item.centre_of_mass_x), item.centre_of_mass_z - point[1]
            # Rounded, since libm differs between processors in the last digit.
            reach.append(round(float(np.arctan2(max(arm, 0.0), rise)), 12))
            lift.append(np.sqrt(arm * arm + rise * rise) - rise if arm > 0 else 0.0)
        if parallel_contact_normals_element_mask[k] and min(reach) > MIN_TIPPING_ANGLE_OF_STANDING_ELEMENT_RAD:
            tips[k] = reach
            critical[k], least = min(reach), min(lift)
        else:
            least = 0.0
            fall = item.fall_rotations_to_minus_and_plus_x_rad
            critical[k] = min(fall) if rests else max(min(reach), MIN_TIPPING_ANGLE_OF_STANDING_ELEMENT_RAD)
        barrier[k] = item.mass * scene.gravity * max(least, 1e-9 * item.smaller_of_width_and_height)
    return tips, critical, barrier, support, base
