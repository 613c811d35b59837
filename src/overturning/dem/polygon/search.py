"""Search of the nearest faces of a pair: the two faces that can touch, and the motion for which this remains valid.

The faces of an element, or of one of its convex pieces, are an array with a row per face: first and second end, outward
normal, distance from the centre; columns 9 and 10 are 1 if the first and second end can be a contact vertex, column 11
is 1 unless the face is a cut between two pieces.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS, NO_ALIAS_COMPILE_OPTIONS
from overturning.dem.polygon import rows
from overturning.dem.polygon.contact_history import reset_contact_history, transfer_contact_history_to_new_faces
from overturning.dem.polygon.earlier_positions import earlier_vertex_positions
from overturning.dem.polygon.faces import polygon_face, rotate_to_scene_axes
from overturning.dem.polygon.state import NearestFacesAndMotionLimits, Pose, VertexContactLimitsAlongOppositeFace


class MostNearlyOppositeFaces(NamedTuple):
    """Most nearly opposite faces of elements a and b: face indices, gap, and scalar product of their normals."""

    gap: float
    """Distance between the elements along the normal of the face, m."""
    face_index_of_a: int
    """Index of the face of a."""
    face_index_of_b: int
    """Index of the face of b."""
    scalar_product_of_normals: float
    """Scalar product of both normals; −1 if they are opposite."""
    scalar_product_difference_to_next_best_face: float
    """Difference of that product to the one of the next best face."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def separation_of_b_from_face_of_a(
    pose_a: Pose, pose_b: Pose, face_table_of_a: Any, face_table_of_b: Any, face_index: int
) -> float:
    """Return the distance (m) of b's nearest vertex from the line through a face of a; negative behind the face."""
    nx, nz = rotate_to_scene_axes(pose_a, face_table_of_a[face_index, 4], face_table_of_a[face_index, 5])
    dx, dz = pose_b.x - pose_a.x, pose_b.z - pose_a.z
    least = np.inf
    for k in range(face_table_of_b.shape[0]):
        x, z = rotate_to_scene_axes(pose_b, face_table_of_b[k, 0], face_table_of_b[k, 1])
        least = min(least, nx * (x + dx) + nz * (z + dz))
    return least - face_table_of_a[face_index, 6]


@njit(**INTERNAL_COMPILE_OPTIONS)
def most_opposite_face_of_b(
    pose_a: Pose, pose_b: Pose, face_table_of_a: Any, face_table_of_b: Any, face_index: int
) -> tuple[int, float, float]:
    """Return index of b's face most nearly opposite to a face of a, scalar product of their normals, and margin.

    The margin is the scalar product for the next best face of b minus that for the returned face.
    """
    c, s = pose_a.cos * pose_b.cos + pose_a.sin * pose_b.sin, pose_a.sin * pose_b.cos - pose_a.cos * pose_b.sin
    nx, nz = (
        c * face_table_of_a[face_index, 4] + s * face_table_of_a[face_index, 5],
        c * face_table_of_a[face_index, 5] - s * face_table_of_a[face_index, 4],
    )
    best, least, second = 0, np.inf, np.inf
    for k in range(face_table_of_b.shape[0]):
        product = nx * face_table_of_b[k, 4] + nz * face_table_of_b[k, 5]
        if product < least:
            best, least, second = k, product, least
        elif product < second:
            second = product
    return best, least, second - least


@njit(**INTERNAL_COMPILE_OPTIONS)
def opposite_face_pair(
    pose_a: Pose, pose_b: Pose, face_table_of_a: Any, face_table_of_b: Any, face_number_counting_a_then_b: int
) -> MostNearlyOppositeFaces:
    """Return a face of element a or b, chosen by number, and the most nearly opposite face of the other element.

    The number counts the faces of a, then those of b.
    """
    of_b = face_number_counting_a_then_b - face_table_of_a.shape[0]
    if of_b < 0:
        other, product, clear = most_opposite_face_of_b(
            pose_a, pose_b, face_table_of_a, face_table_of_b, face_number_counting_a_then_b
        )
        return MostNearlyOppositeFaces(
            separation_of_b_from_face_of_a(
                pose_a, pose_b, face_table_of_a, face_table_of_b, face_number_counting_a_then_b
            ),
            face_number_counting_a_then_b,
            other,
            product,
            clear,
        )
    other, product, clear = most_opposite_face_of_b(pose_b, pose_a, face_table_of_b, face_table_of_a, of_b)
    return MostNearlyOppositeFaces(
        separation_of_b_from_face_of_a(pose_b, pose_a, face_table_of_b, face_table_of_a, of_b),
        other,
        of_b,
        product,
        clear,
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def find_nearest_faces(
    pose_a: Pose, pose_b: Pose, face_table_of_a: Any, face_table_of_b: Any, previous_faces: NearestFacesAndMotionLimits
) -> MostNearlyOppositeFaces:
    """Return the nearest faces of elements a and b: the pair with the largest gap, at equal gaps the most opposite."""
    best = MostNearlyOppositeFaces(
        -np.inf, int(previous_faces.face_index_of_a), int(previous_faces.face_index_of_b), np.inf, 0.0
    )
    for k in range(face_table_of_a.shape[0] + face_table_of_b.shape[0]):
        other = opposite_face_pair(pose_a, pose_b, face_table_of_a, face_table_of_b, k)
        if other.gap > best.gap or (
            other.gap == best.gap and other.scalar_product_of_normals < best.scalar_product_of_normals
        ):
            best = other
    return best


@njit(**INTERNAL_COMPILE_OPTIONS)
def squared_polygon_radius(polygon_face_table: Any) -> float:
    """Return the squared distance of the farthest vertex of a polygon from its centre, m²."""
    square = 0.0
    for k in range(polygon_face_table.shape[0]):
        square = max(
            square,
            polygon_face_table[k, 0] * polygon_face_table[k, 0] + polygon_face_table[k, 1] * polygon_face_table[k, 1],
        )
    return square


@njit(**INTERNAL_COMPILE_OPTIONS)
def largest_motion_keeping_nearest_faces(
    pose_a: Pose,
    pose_b: Pose,
    face_table_of_a: Any,
    face_table_of_b: Any,
    nearest_face_pair: MostNearlyOppositeFaces,
    lever_arm_converting_rotation_to_motion: float,
) -> float:
    """Return the relative motion (m) of elements a and b up to which their nearest faces cannot change.

    The gap at a face changes by at most the motion, the scalar product of two normals by at most the rotation (rad).
    """
    limit = (
        0.4 * lever_arm_converting_rotation_to_motion * nearest_face_pair.scalar_product_difference_to_next_best_face
    )
    for k in range(face_table_of_a.shape[0] + face_table_of_b.shape[0]):
        other = opposite_face_pair(pose_a, pose_b, face_table_of_a, face_table_of_b, k)
        room = 0.4 * (nearest_face_pair.gap - other.gap)
        agrees = (
            other.face_index_of_a == nearest_face_pair.face_index_of_a
            and other.face_index_of_b == nearest_face_pair.face_index_of_b
        )
        limit = min(
            limit,
            max(room, 0.4 * lever_arm_converting_rotation_to_motion * other.scalar_product_difference_to_next_best_face)
            if agrees
            else room,
        )
    return limit


@njit(**INTERNAL_COMPILE_OPTIONS)
def update_nearest_faces_and_contact_history(
    pair_state_rows: Any,
    element_a_state_rows: Any,
    element_b_state_rows: Any,
    lane: int,
    back_extrapolation_time: float,
    face_table_of_a: Any,
    face_table_of_b: Any,
) -> None:
    """Update two elements' nearest faces, the motion for which these stay valid, and their contact history.

    The face with the largest separation from the other element is nearest; its partner is the most nearly opposite face
    of the other element. A pair whose faces have not been searched yet (a case at rest) keeps its contact history.
    """
    old, first, second = (
        rows.load_nearest_faces_and_motion_limits(pair_state_rows, lane),
        rows.load_element_state(element_a_state_rows, lane),
        rows.load_element_state(element_b_state_rows, lane),
    )
    on, by = first.pose, second.pose
    best = find_nearest_faces(on, by, face_table_of_a, face_table_of_b, old)
    dx, dz = on.x - by.x, on.z - by.z
    lever = np.sqrt(dx * dx + dz * dz) + np.sqrt(
        max(squared_polygon_radius(face_table_of_a), squared_polygon_radius(face_table_of_b))
    )
    limit = largest_motion_keeping_nearest_faces(on, by, face_table_of_a, face_table_of_b, best, lever)
    # Leave a margin of two steps like the last one, so that the first step within reach is still without contact.
    moved, turned = (
        first.step_motion_with_work_and_peaks_so_far.abs_dx_plus_abs_dz_in_step
        + second.step_motion_with_work_and_peaks_so_far.abs_dx_plus_abs_dz_in_step,
        first.step_motion_with_work_and_peaks_so_far.abs_rotation_in_step
        + second.step_motion_with_work_and_peaks_so_far.abs_rotation_in_step,
    )
    clear = 0.9 * best.gap - 2.0 * (moved + lever * turned)
    reach = clear if clear > 0.0 else -1.0
    ahead = 2.0 * (
        (first.predicted.abs_dx_plus_abs_dz_in_step + second.predicted.abs_dx_plus_abs_dz_in_step)
        + lever * (first.predicted.abs_rotation_in_step + second.predicted.abs_rotation_in_step)
    )
    rows.store_nearest_faces_and_motion_limits(
        pair_state_rows,
        lane,
        NearestFacesAndMotionLimits(
            best.face_index_of_a, best.face_index_of_b, lever, max(limit, reach), reach, 0.0, ahead
        ),
    )
    if clear > 0.0:
        reset_contact_history(pair_state_rows, lane)
    changed = old.face_index_of_a != best.face_index_of_a or old.face_index_of_b != best.face_index_of_b
    if changed:
        rows.store_nearest_face_of_a(pair_state_rows, lane, polygon_face(face_table_of_a, best.face_index_of_a))
        rows.store_nearest_face_of_b(pair_state_rows, lane, polygon_face(face_table_of_b, best.face_index_of_b))
        rows.store_vertex_contact_limits(
            pair_state_rows,
            lane,
            ranges_where_vertices_touch_opposite_faces(
                face_table_of_a, best.face_index_of_a, face_table_of_b, best.face_index_of_b
            ),
        )
    if changed or old.max_motion_without_contact > 0.0 or clear > 0.0:
        rows.store_previous_vertex_positions(
            pair_state_rows,
            lane,
            earlier_vertex_positions(
                rows.load_pair_state(pair_state_rows, lane), first, second, back_extrapolation_time
            ),
        )
    if changed and old.face_index_of_a >= 0.0:
        transfer_contact_history_to_new_faces(
            pair_state_rows,
            on,
            by,
            lane,
            int(old.face_index_of_a),
            int(old.face_index_of_b),
            face_table_of_a,
            face_table_of_b,
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def nearest_faces_will_change(
    pair_state_rows: Any,
    element_a_state_rows: Any,
    element_b_state_rows: Any,
    lane: int,
    face_table_of_a: Any,
    face_table_of_b: Any,
) -> bool:
    """True if the predicted motion in a step changes which faces of two elements are nearest to each other."""
    pair, on, by = (
        rows.load_pair_state(pair_state_rows, lane),
        rows.load_element_state(element_a_state_rows, lane).predicted.pose,
        rows.load_element_state(element_b_state_rows, lane).predicted.pose,
    )
    old = pair.nearest_faces
    if (
        old.relative_motion_bound_since_search_at_step_end < old.max_motion_keeping_nearest_faces
        or old.relative_motion_bound_since_search_at_step_end < old.max_motion_without_contact
    ):
        return False
    best = find_nearest_faces(on, by, face_table_of_a, face_table_of_b, old)
    return bool(best.face_index_of_a != old.face_index_of_a or best.face_index_of_b != old.face_index_of_b)


@njit(**INTERNAL_COMPILE_OPTIONS)
def ranges_where_vertices_touch_opposite_faces(
    face_table_of_a: Any, face_index_of_a: int, face_table_of_b: Any, face_index_of_b: int
) -> VertexContactLimitsAlongOppositeFace:
    """Return the ranges (m) along two opposite faces in which a vertex of one face can touch the other face."""
    on_a, on_b = polygon_face(face_table_of_a, face_index_of_a), polygon_face(face_table_of_b, face_index_of_b)
    a_to_b, b_to_a = face_table_of_b[face_index_of_b, 11] > 0.0, face_table_of_a[face_index_of_a, 11] > 0.0
    return VertexContactLimitsAlongOppositeFace(
        on_b.start_along_tangent if a_to_b and face_table_of_a[face_index_of_a, 9] > 0.0 else np.inf,
        -on_a.end_along_tangent if b_to_a and face_table_of_b[face_index_of_b, 10] > 0.0 else np.inf,
        on_b.end_along_tangent if a_to_b and face_table_of_a[face_index_of_a, 10] > 0.0 else -np.inf,
        -on_a.start_along_tangent if b_to_a and face_table_of_b[face_index_of_b, 9] > 0.0 else -np.inf,
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def sum_pair_motion_and_count_near_and_search_cases(
    pair_state_rows: Any, element_a_state_rows: Any, element_b_state_rows: Any
) -> tuple[int, int]:
    """Sum two elements' motion since their face search; return in how many cases they may touch or change faces.

    The two numbers are those of cases in which the elements may touch in the step, and in which their nearest faces
    may change. The motion predicted for the step counts twice, because the contacts may change it.
    """
    near, due = 0, 0
    for j in range(rows.PARALLEL_CASE_COUNT):
        old, on, by = (
            rows.load_nearest_faces_and_motion_limits(pair_state_rows, j),
            rows.load_element_state(element_a_state_rows, j),
            rows.load_element_state(element_b_state_rows, j),
        )
        first, second, one, two = (
            on.step_motion_with_work_and_peaks_so_far,
            by.step_motion_with_work_and_peaks_so_far,
            on.predicted,
            by.predicted,
        )
        used = (
            old.motion_since_face_search + (first.abs_dx_plus_abs_dz_in_step + second.abs_dx_plus_abs_dz_in_step)
        ) + old.lever_arm_converting_rotation_to_motion * (first.abs_rotation_in_step + second.abs_rotation_in_step)
        ahead = used + 2.0 * (
            (one.abs_dx_plus_abs_dz_in_step + two.abs_dx_plus_abs_dz_in_step)
            + old.lever_arm_converting_rotation_to_motion * (one.abs_rotation_in_step + two.abs_rotation_in_step)
        )
        pair_state_rows[rows.MOTION_SINCE_FACE_SEARCH_ROW_OFFSET + j] = used
        pair_state_rows[rows.MAX_MOTION_SINCE_SEARCH_AT_STEP_END_ROW_OFFSET + j] = ahead
        near += 1 if ahead >= old.max_motion_without_contact else 0
        due += 1 if ahead >= old.max_motion_keeping_nearest_faces else 0
    return near, due


@njit(**INTERNAL_COMPILE_OPTIONS)
def update_nearest_faces_and_check_possible_contact(
    case_states: Any,
    pair_state_rows: Any,
    element_a_state_rows: Any,
    element_b_state_rows: Any,
    scene_piece_index_of_a: int,
    scene_piece_index_of_b: int,
    vertex_count_by_piece: Any,
    face_table_by_variant_and_piece: Any,
) -> bool:
    """Update two elements' nearest faces where they may have changed; True if the elements could touch in any case.

    `scene_piece_index_of_a` and `…_of_b` are the indices of their convex pieces among all pieces of the scene.
    """
    near, due = sum_pair_motion_and_count_near_and_search_cases(
        pair_state_rows, element_a_state_rows, element_b_state_rows
    )
    if due > 0:
        near = 0
        for j in range(rows.PARALLEL_CASE_COUNT):
            if (
                pair_state_rows[rows.MAX_MOTION_SINCE_SEARCH_AT_STEP_END_ROW_OFFSET + j]
                >= pair_state_rows[rows.MAX_MOTION_KEEPING_NEAREST_FACES_ROW_OFFSET + j]
            ):
                v, dt = (
                    int(case_states[rows.SCENE_VARIANT_INDEX_ROW_OFFSET + j]),
                    2.0 * rows.load_scene_state(case_states, j).velocity_lag_behind_pose,
                )
                shape_a, shape_b = (
                    face_table_by_variant_and_piece[
                        v, scene_piece_index_of_a, : vertex_count_by_piece[scene_piece_index_of_a]
                    ],
                    face_table_by_variant_and_piece[
                        v, scene_piece_index_of_b, : vertex_count_by_piece[scene_piece_index_of_b]
                    ],
                )
                update_nearest_faces_and_contact_history(
                    pair_state_rows, element_a_state_rows, element_b_state_rows, j, dt, shape_a, shape_b
                )
                if dt == 0.0 and nearest_faces_will_change(
                    pair_state_rows, element_a_state_rows, element_b_state_rows, j, shape_a, shape_b
                ):
                    case_states[rows.CONTACT_CHANGED_ROW_OFFSET + j] = 1.0
            near += (
                1
                if pair_state_rows[rows.MAX_MOTION_SINCE_SEARCH_AT_STEP_END_ROW_OFFSET + j]
                >= pair_state_rows[rows.MAX_MOTION_WITHOUT_CONTACT_ROW_OFFSET + j]
                else 0
            )
    return near > 0
