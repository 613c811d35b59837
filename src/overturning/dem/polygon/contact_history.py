"""History of a pair's contact points: reset, initial values at rest, and transfer to other faces after a search."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import contact_vertex_position, polygon_face, rotate_to_scene_axes
from overturning.dem.polygon.state import (
    CONTACT_CODE_OPEN,
    CONTACT_CODE_TRANSFERRED_FROM_OTHER_FACES,
    CONTACT_CODE_VERTEX_OF_B,
    ElementFace,
    PairState,
    PlanarContactPointStateAfterLastStep,
    Pose,
)


@njit(**INTERNAL_COMPILE_OPTIONS)
def reset_contact_history(pair_state_rows: Any, lane: int) -> None:
    """Reset both contact points of two elements to no contact and no force, for the case in column `lane`."""
    rows.store_point_1_history(
        pair_state_rows, lane, PlanarContactPointStateAfterLastStep(0.0, CONTACT_CODE_OPEN, 0.0, 0.0, 0.0)
    )
    rows.store_point_1_history(
        pair_state_rows,
        lane + rows.ROW_OFFSET_FROM_POINT_1_TO_POINT_2,
        PlanarContactPointStateAfterLastStep(0.0, CONTACT_CODE_OPEN, 0.0, 0.0, 0.0),
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def transfer_contact_history_to_new_faces(
    pair_state_rows: Any,
    pose_a: Pose,
    pose_b: Pose,
    lane: int,
    old_face_index_of_a: int,
    old_face_index_of_b: int,
    face_table_of_a: Any,
    face_table_of_b: Any,
) -> None:
    """Transfer the contact state of two elements from their previous nearest faces to the new ones.

    The force is resolved along normal and tangent of the new contact point; the next step sets the spring's stretch
    accordingly.
    """
    pair = rows.load_pair_state(pair_state_rows, lane)
    face_a, face_b, vertices = (
        int(pair.nearest_faces.face_index_of_a),
        int(pair.nearest_faces.face_index_of_b),
        pair.history.previous_vertex_positions,
    )
    reset_contact_history(pair_state_rows, lane)
    for end in range(2):
        old = pair.history.point_1 if end == 0 else pair.history.point_2
        if old.contact_vertex_status_code == CONTACT_CODE_OPEN:
            continue
        mine = old.contact_vertex_status_code != CONTACT_CODE_VERTEX_OF_B
        if mine:
            target = number_of_contact_point_inheriting_old_vertex(
                face_table_of_a, old_face_index_of_a + end, face_a, face_a + 1
            )
        else:
            target = number_of_contact_point_inheriting_old_vertex(
                face_table_of_b, old_face_index_of_b + 1 - end, face_b + 1, face_b
            )
        old_x, old_z = normal_force_direction_on_element_a(
            pose_a,
            pose_b,
            polygon_face(face_table_of_a, old_face_index_of_a),
            polygon_face(face_table_of_b, old_face_index_of_b),
            mine,
        )
        x, z = (
            old.normal_force * old_x + old.tangential_force * old_z,
            old.normal_force * old_z - old.tangential_force * old_x,
        )
        inner = (
            vertices.first_vertex_of_face_a.position_along_opposite_face <= pair.nearest_face_of_b.end_along_tangent
            if target == 0
            else vertices.second_vertex_of_face_a.position_along_opposite_face
            >= pair.nearest_face_of_b.start_along_tangent
        )
        new_x, new_z = normal_force_direction_on_element_a(
            pose_a, pose_b, pair.nearest_face_of_a, pair.nearest_face_of_b, inner
        )
        n, t = x * new_x + z * new_z, x * new_z - z * new_x
        there = rows.load_point_1_history(pair_state_rows, lane + target * rows.ROW_OFFSET_FROM_POINT_1_TO_POINT_2)
        if there.contact_vertex_status_code == CONTACT_CODE_OPEN or there.normal_force < n:
            rows.store_point_1_history(
                pair_state_rows,
                lane + target * rows.ROW_OFFSET_FROM_POINT_1_TO_POINT_2,
                PlanarContactPointStateAfterLastStep(
                    old.tangential_spring_stretch, CONTACT_CODE_TRANSFERRED_FROM_OTHER_FACES, n, t, 0.0
                ),
            )


@njit(**INTERNAL_COMPILE_OPTIONS)
def number_of_contact_point_inheriting_old_vertex(
    polygon_face_table: Any, old_vertex_index: int, new_vertex_index_at_point_0: int, new_vertex_index_at_point_1: int
) -> int:
    """Return which contact point (0 or 1) of the new nearest faces takes over the contact of vertex `old_vertex_index`.

    It is the point at the same vertex, else that at the nearer end of the face. Vertex indices are taken modulo the
    number of vertices.
    """
    count = polygon_face_table.shape[0]
    old_vertex_index, new_vertex_index_at_point_0, new_vertex_index_at_point_1 = (
        old_vertex_index % count,
        new_vertex_index_at_point_0 % count,
        new_vertex_index_at_point_1 % count,
    )
    if old_vertex_index == new_vertex_index_at_point_1:
        return 1
    if old_vertex_index == new_vertex_index_at_point_0:
        return 0
    x, z = polygon_face_table[old_vertex_index, 0], polygon_face_table[old_vertex_index, 1]
    x1, z1, x2, z2 = (
        polygon_face_table[new_vertex_index_at_point_0, 0] - x,
        polygon_face_table[new_vertex_index_at_point_0, 1] - z,
        polygon_face_table[new_vertex_index_at_point_1, 0] - x,
        polygon_face_table[new_vertex_index_at_point_1, 1] - z,
    )
    return 0 if x1 * x1 + z1 * z1 <= x2 * x2 + z2 * z2 else 1


@njit(**INTERNAL_COMPILE_OPTIONS)
def normal_force_direction_on_element_a(
    pose_a: Pose, pose_b: Pose, face_a: ElementFace, face_b: ElementFace, vertex_is_of_a: bool
) -> tuple[float, float]:
    """Return the direction of the normal force on element a, from the normal of the face that a vertex touches."""
    if vertex_is_of_a:
        return rotate_to_scene_axes(pose_b, face_b.outward_normal_x, face_b.outward_normal_z)
    x, z = rotate_to_scene_axes(pose_a, face_a.outward_normal_x, face_a.outward_normal_z)
    return -x, -z


@njit(**INTERNAL_COMPILE_OPTIONS)
def contact_vertex_position_from_centre_of_a(
    pair: PairState, pose_a: Pose, pose_b: Pose, point_index_0_or_1: int, vertex_is_of_a: bool
) -> tuple[float, float]:
    """Return the vector (m) from element a's centre to the vertex at contact point `point_index_0_or_1`."""
    own = pair.nearest_face_of_a if vertex_is_of_a else pair.nearest_face_of_b
    along = own.start_along_tangent if vertex_is_of_a == (point_index_0_or_1 == 0) else own.end_along_tangent
    x, z = (
        own.face_line_distance_from_element_centre * own.outward_normal_x - along * own.outward_normal_z,
        own.face_line_distance_from_element_centre * own.outward_normal_z + along * own.outward_normal_x,
    )
    if vertex_is_of_a:
        return rotate_to_scene_axes(pose_a, x, z)
    x, z = rotate_to_scene_axes(pose_b, x, z)
    return x - (pose_a.x - pose_b.x), z - (pose_a.z - pose_b.z)


@njit(**INTERNAL_COMPILE_OPTIONS)
def set_pair_forces_from_penetration_and_stretch(pair_state_rows: Any, lane: int) -> None:
    """Set the contact forces of two elements at rest from penetrations and stretches of tangential springs."""
    pair = rows.load_pair_state(pair_state_rows, lane)
    for end in range(2):
        old = pair.history.point_1 if end == 0 else pair.history.point_2
        if old.contact_vertex_status_code != CONTACT_CODE_OPEN:
            n = max(
                pair.contact_law.normal_stiffness
                * contact_vertex_position(old, end, pair.history.previous_vertex_positions).depth,
                0.0,
            )
            t = -pair.contact_law.tangential_stiffness * old.tangential_spring_stretch
            rows.store_point_1_history(
                pair_state_rows,
                lane + end * rows.ROW_OFFSET_FROM_POINT_1_TO_POINT_2,
                PlanarContactPointStateAfterLastStep(
                    old.tangential_spring_stretch, old.contact_vertex_status_code, n, t, 0.0
                ),
            )
