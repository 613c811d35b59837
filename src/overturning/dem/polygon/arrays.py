"""Input and output tables of the scene kernel, and the arrays of a scene in all its variants (sizes and damping)."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.mechanics import FLAT_LANDING_DURATION_IN_DECAY_TIMES
from overturning.dem.limits import MAX_PENETRATION_TO_HALF_SIDE_RATIO
from overturning.dem.polygon import rows
from overturning.dem.polygon import state as k
from overturning.dem.polygon.prepare import SceneEquilibriumStiffnessAndRockingLimits, smallest_free_element_side
from overturning.dem.polygon.tables import ELEMENT_FALL_AND_SUPPORT_DTYPE, TERMINATION_LIMITS_DTYPE
from overturning.model.geometry import (
    MIN_GROUND_WIDTH_TO_LARGEST_ELEMENT_RATIO,
    PlacedElement,
    convex_pieces_of_each_pair,
    possible_contact_points_of_elements,
)

MAX_KINETIC_ENERGY_AT_REST_OVER_MG_HALF_SIDE: Final = 1e-9
"""Largest kinetic energy at rest, as a share of m g times half the smallest side of the lightest element."""

MIN_MASS_TO_HEAVIEST_FOR_FLAT_LANDING_RULE: Final = 0.1
"""Smallest mass of an element for which the rule of flat landings is applied, over the heaviest free element's."""

MIN_LYING_ROTATION_OVER_ROTATION_ONTO_FACE: Final = 0.999
"""Share of the rotation onto another face from which an element counts as lying on it; contacts are compliant."""


class SceneArrays(NamedTuple):
    """Constants and initial states of a 2-D scene for the kernel, for each variant (one size and damping)."""

    initial_state_by_scene_variant: FloatArray
    """Rows of a lane at rest, shape (variants, rows)."""
    pair_element_and_piece_indices: NDArray[np.int64]
    """Indices of the two elements of each pair, and of their convex pieces among all pieces, shape (pairs, 4)."""
    lowest_and_last_element_index_by_rocking_group: NDArray[np.int64]
    """Lowest and last listed element of each group that can move as one, shape (groups, 2)."""
    piece_vertex_counts: NDArray[np.int64]
    """Number of vertices of each piece, shape (pieces,)."""
    piece_face_tables: FloatArray
    """Rows of `Polygon.face_geometry_and_contact_flag_table` by piece, shape (variants, pieces, vertices, 12)."""
    fall_and_support_table: NDArray[np.void]
    """Fall limits, support and overturning energy of each element, shape (variants, elements)."""
    termination_limits: NDArray[np.void]
    """Limits of failure and rest, of type `TERMINATION_LIMITS_DTYPE`, shape (variants,)."""
    gravity: float
    """Acceleration of gravity, m/s²."""


def build_scene_arrays(
    prepared_scenes_by_size_and_damping: list[SceneEquilibriumStiffnessAndRockingLimits],
) -> SceneArrays:
    """Return the kernel's input arrays for variants of a scene that differ only in size and damping."""
    one = prepared_scenes_by_size_and_damping[0]
    first = np.cumsum([0, *(len(item.shape.convex_parts) for item in one.elements)]).tolist()
    layout = [
        (
            pair.first_element_index,
            pair.second_element_index,
            first[pair.first_element_index] + pair.piece_index_in_first_element,
            first[pair.second_element_index] + pair.second_piece_index,
        )
        for pair in one.pairs
    ]
    sizes = np.array(one.piece_vertex_counts, np.int64)
    shapes = np.zeros((len(prepared_scenes_by_size_and_damping), sizes.size, int(sizes.max()), 12))
    for v, prepared in enumerate(prepared_scenes_by_size_and_damping):
        for index, part in enumerate(part for item in prepared.elements for part in item.shape.convex_parts):
            shapes[v, index, : sizes[index]] = part.face_geometry_and_contact_flag_table
    return SceneArrays(
        initial_state_by_scene_variant=np.stack(
            [case_state_column_at_rest(item) for item in prepared_scenes_by_size_and_damping]
        ),
        pair_element_and_piece_indices=np.array(layout, np.int64).reshape(-1, 4),
        lowest_and_last_element_index_by_rocking_group=one.lowest_and_last_element_index_by_rocking_group,
        piece_vertex_counts=sizes,
        piece_face_tables=shapes,
        fall_and_support_table=np.stack(
            [fall_limits_supports_and_overturning_energies(item) for item in prepared_scenes_by_size_and_damping]
        ),
        termination_limits=np.stack(
            [penetration_and_energy_limits_of_case_end(item) for item in prepared_scenes_by_size_and_damping]
        ),
        gravity=one.scene.gravity,
    )


def case_state_column_at_rest(prepared_scene: SceneEquilibriumStiffnessAndRockingLimits) -> FloatArray:
    """Return the state array's values for one case, with the scene at rest: one column of the array, shape (rows,)."""
    elements = [_element_state_at_rest(prepared_scene, index) for index in range(len(prepared_scene.elements))]
    pieces = convex_pieces_of_each_pair(prepared_scene.elements, prepared_scene.pairs)
    pairs = [_pair_state_at_rest(prepared_scene, index, *of_pair) for index, of_pair in enumerate(pieces)]
    step = [0.0] * (rows.PAIR_ROW_LAYOUT.row_count - len(rows.flatten_nested_tuples(pairs[0])) if pairs else 0)
    return np.array(
        [0.0] * rows.CASE_ROW_LAYOUT.row_count
        + rows.flatten_nested_tuples(elements)
        + [number for pair in pairs for number in rows.flatten_nested_tuples(pair) + step]
    )


def _element_state_at_rest(
    prepared_scene: SceneEquilibriumStiffnessAndRockingLimits, element_index: int
) -> k.ElementState:
    """Return the `ElementState` at rest of the element with number `element_index` in the prepared scene."""
    placed, still = prepared_scene.elements, k.PlanarMotionOrForce(0.0, 0.0, 0.0)
    item, (dx, dz, turn) = placed[element_index], prepared_scene.static_displacements[element_index]
    # For the minute rotations at rest, these series give cosine and sine with length 1 to the last digit.
    pose = k.Pose(
        item.centre_of_mass_x + dx,
        item.centre_of_mass_z + dz,
        turn,
        1.0 - 0.5 * turn * turn,
        turn * (1.0 - turn * turn / 6.0),
    )
    free = (
        (0.0, 0.0, 0.0, 0.0)
        if item.has_prescribed_motion
        else (1.0 / item.mass, 1.0 / item.inertia_about_centre_of_mass, item.mass, 1.0)
    )
    support = placed[prepared_scene.support_element_indices[element_index]]
    x, z = prepared_scene.element_base_midpoints[element_index]
    return k.ElementState(
        pose=pose,
        velocity=still,
        predicted=k.PredictedElement(pose, still, still, 0.0, 0.0, still),
        acceleration=still,
        contact_force_sum=still,
        constants=k.ElementConstants(
            *free,
            float(item.element.kind != "driven"),
            float(item.element.kind == "held"),
            float(prepared_scene.weaker_side_critical_angles_else_fall_angles[element_index]),
            *prepared_scene.max_recoverable_rotations_by_side[element_index].tolist(),
        ),
        step_motion_with_work_and_peaks_so_far=k.ElementStepMotionWorkAndPeaks(
            abs_dx_plus_abs_dz_in_step=0.0,
            abs_rotation_in_step=0.0,
            work_by_base_and_fixing_forces_so_far=0.0,
            peak_rotation_to_minus_x=max(-turn, 0.0),
            peak_rotation_to_plus_x=max(turn, 0.0),
            last_recoverable_tick_in_sample=-1.0,
            power_against_inertial_or_fixing_forces=0.0,
        ),
        motion_since_first_contact_test_pause=k.ElementMotionSinceFirstPairSuspended(0.0, 0.0),
        slip_fall_side_and_last_upright_time=k.ElementSlipFallSideAndLastUprightTime(0.0, 0.0, 0.0, 0.0, 0.0),
        rest_pose_and_slip_measurement_points=k.ElementRestPoseAndSlipMeasurementPoints(
            x - item.centre_of_mass_x,
            z - item.centre_of_mass_z,
            x - support.centre_of_mass_x,
            z - support.centre_of_mass_z,
            item.centre_of_mass_x,
            item.centre_of_mass_z,
            item.centre_of_mass_z - item.fall_threshold_drop,
        ),
    )


def _pair_state_at_rest(
    prepared_scene: SceneEquilibriumStiffnessAndRockingLimits,
    pair_index: int,
    piece_of_a: PlacedElement,
    piece_of_b: PlacedElement,
) -> k.PairState:
    """Return the contact state at rest of two convex pieces, one each of elements a and b of the prepared scene."""
    placed, laws, pair = prepared_scene.elements, prepared_scene.pair_contact_laws, prepared_scene.pairs[pair_index]
    tangential = laws.tangential_stiffness[pair_index]
    ends = [k.PlanarContactPointStateAfterLastStep(0.0, k.CONTACT_CODE_OPEN, 0.0, 0.0, 0.0)] * 2
    for end in prepared_scene.contact_points_loaded_at_rest:
        if end.pair_index == pair_index:
            of_a = _contact_vertex_belongs_to_first_element(piece_of_a, piece_of_b, end.point_number)
            carrier = k.CONTACT_CODE_VERTEX_OF_A if of_a else k.CONTACT_CODE_VERTEX_OF_B
            ends[end.point_number] = k.PlanarContactPointStateAfterLastStep(
                end.tangential_spring_stretch, carrier, 0.0, 0.0, 0.0
            )
    seen, face = k.VertexPositionAtFace(0.0, 0.0), k.ElementFace(0.0, 0.0, 0.0, 0.0, 0.0)
    vertices = k.VertexPositionsAtOtherFace(seen, seen, seen, seen)
    settled = np.inf if is_upright_rectangle_on_wide_driven_ground(placed) else 0.0
    return k.PairState(
        nearest_face_of_a=face,
        nearest_face_of_b=face,
        ranges_where_vertices_touch_opposite_faces=k.VertexContactLimitsAlongOppositeFace(0.0, 0.0, 0.0, 0.0),
        contact_law=k.ContactPointConstants(
            laws.normal_stiffness[pair_index],
            tangential,
            laws.dashpot_coefficient[pair_index],
            laws.friction_coefficient[pair_index],
            1.0 / tangential if tangential > 0 else 0.0,
            FLAT_LANDING_DURATION_IN_DECAY_TIMES
            if pair_uses_flat_landing_rule(placed, pair.first_element_index, pair.second_element_index)
            else 0.0,
        ),
        nearest_faces=k.NearestFacesAndMotionLimits(
            face_index_of_a=-1.0,
            face_index_of_b=-1.0,
            lever_arm_converting_rotation_to_motion=0.0,
            max_motion_keeping_nearest_faces=settled,
            max_motion_without_contact=-1.0,
            motion_since_face_search=0.0,
            relative_motion_bound_since_search_at_step_end=0.0,
        ),
        history=k.PairContactStateAfterLastStep(vertices, ends[0], ends[1], peak_penetration=0.0, absorbed_energy=0.0),
        signed_mu_of_point_1_or_0_if_sticking=0.0,
        signed_mu_of_point_2_or_0_if_sticking=0.0,
        rest_support_sign_plus_if_a_on_b=float(
            pair.second_element_index in prepared_scene.carrier_indices_by_element[pair.first_element_index]
        )
        - (pair.first_element_index in prepared_scene.carrier_indices_by_element[pair.second_element_index]),
    )


def pair_uses_flat_landing_rule(elements: list[PlacedElement], element_index_a: int, element_index_b: int) -> bool:
    """True if two elements use the contact rule for landing on a whole face in one impact (docs/method.md).

    Both elements must be heavy enough: a slab of a hundredth of the mass of the stone above it opens and closes its
    contacts in nearly every step, and dashpots that pull in each of these landings multiply the steps by 10 to 90.
    """
    heaviest = max(item.mass for item in elements if not item.has_prescribed_motion)
    return all(
        elements[n].has_prescribed_motion or elements[n].mass >= MIN_MASS_TO_HEAVIEST_FOR_FLAT_LANDING_RULE * heaviest
        for n in (element_index_a, element_index_b)
    )


def is_upright_rectangle_on_wide_driven_ground(elements: list[PlacedElement]) -> bool:
    """True for a scene of one upright rectangle on wide driven ground: its touching faces do not change until it falls.

    Only the lower corners of the rectangle can touch the ground until it lies on its side, when it has fallen.
    """
    if len(elements) != 2:
        return False
    ground, stone = elements
    return (
        all(item.element.width is not None and item.element.rotation_deg == 0 for item in elements)
        and ground.element.kind == "driven"
        and stone.element.kind == "free"
        and max(fall_rotations_to_both_sides(stone)) < 0.5 * np.pi
        and abs(float(stone.vertices_in_scene[:, 1].min() - ground.vertices_in_scene[:, 1].max()))
        <= 1e-9 * stone.smaller_of_width_and_height
        and ground.shape.width
        > MIN_GROUND_WIDTH_TO_LARGEST_ELEMENT_RATIO * max(stone.shape.width, stone.shape.height)
        + 2.0 * abs(stone.centre_of_mass_x - ground.centre_of_mass_x)
    )


def _contact_vertex_belongs_to_first_element(
    first_element: PlacedElement, second_element: PlacedElement, point_index_0_or_1: int
) -> bool:
    """True if the vertex at contact point `point_index_0_or_1` of two elements is a vertex of the first element."""
    point = possible_contact_points_of_elements(first_element, second_element)[point_index_0_or_1].vertex_position
    return bool(
        min(np.hypot(x - point[0], z - point[1]) for x, z in first_element.vertices_in_scene)
        < 1e-9 * first_element.smaller_of_width_and_height
    )


def fall_rotations_to_both_sides(element: PlacedElement) -> tuple[float, float]:
    """Return the rotations to −x and to +x at which an element counts as fallen, rad.

    They are `MIN_LYING_ROTATION_OVER_ROTATION_ONTO_FACE` times the rotations onto the next face, or the rotation given
    in the scene file.
    """
    brings_down = element.element.fallen_rotation_deg in (None, 90.0)
    back, on = element.fall_rotations_to_minus_and_plus_x_rad
    return (
        (
            round(MIN_LYING_ROTATION_OVER_ROTATION_ONTO_FACE * back, 12),
            round(MIN_LYING_ROTATION_OVER_ROTATION_ONTO_FACE * on, 12),
        )
        if brings_down
        else (back, on)
    )


def fall_limits_supports_and_overturning_energies(
    prepared_scene: SceneEquilibriumStiffnessAndRockingLimits,
) -> NDArray[np.void]:
    """Return fall limits, support and energy to overturn by element, shape (elements,).

    The rows have the type `ELEMENT_FALL_AND_SUPPORT_DTYPE`.
    """
    return np.array(
        [
            (
                not item.has_prescribed_motion,
                *fall_rotations_to_both_sides(item),
                *prepared_scene.tipping_angles_by_element_and_side[k],
                *prepared_scene.support_and_held_stack_bottom_indices(k),
                prepared_scene.overturning_energies[k],
            )
            for k, item in enumerate(prepared_scene.elements)
        ],
        ELEMENT_FALL_AND_SUPPORT_DTYPE,
    )


def penetration_and_energy_limits_of_case_end(
    prepared_scene: SceneEquilibriumStiffnessAndRockingLimits,
) -> NDArray[np.void]:
    """Return the penetration and energy limits that end a case of a prepared scene, of type `TERMINATION_LIMITS_DTYPE`.

    The energy error is relative to the energy that overturns an element, or to its weight times its smaller side if it
    falls without base motion and needs no such energy.
    """
    free = [prepared_scene.elements[n] for n in prepared_scene.free_element_indices]
    whole = np.array([item.mass * prepared_scene.scene.gravity * item.smaller_of_width_and_height for item in free])
    barrier = prepared_scene.overturning_energies[prepared_scene.free_element_indices]
    needs, lightest = barrier > 1e-6 * whole, min(free, key=lambda item: item.mass)
    rest_energy = (
        MAX_KINETIC_ENERGY_AT_REST_OVER_MG_HALF_SIDE
        * lightest.mass
        * prepared_scene.scene.gravity
        * 0.5
        * lightest.smaller_of_width_and_height
    )
    least_barrier, least_scale = np.where(needs, barrier, -np.inf).min(), np.where(needs, barrier, whole).min()
    return np.array(
        (
            MAX_PENETRATION_TO_HALF_SIDE_RATIO * 0.5 * smallest_free_element_side(prepared_scene.elements),
            rest_energy,
            least_barrier,
            least_scale,
        ),
        TERMINATION_LIMITS_DTYPE,
    )
