"""Relative position of the nearest faces of a pair: their four vertices, and both contact points."""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.dem.polygon.state import (
    CONTACT_CODE_VERTEX_OF_B,
    ElementFace,
    PairState,
    PlanarContactPointStateAfterLastStep,
    Pose,
    VertexPositionAtFace,
    VertexPositionsAtOtherFace,
)


class LeverArmsAboutElementCentre(NamedTuple):
    """Signed lever arms of a normal and of a tangential contact force about the centre of an element, m."""

    of_normal_force: float
    """Moment of the normal force over this force, m."""
    of_tangential_force: float
    """Moment of the tangential force over this force, m."""


class PlanarContactPoint(NamedTuple):
    """Contact point of two elements: vertex at which it lies, normal, penetration, slip and lever arms.

    The nearest faces of two elements overlap along a segment; a contact point lies at each end of it.
    """

    vertex_is_of_a: bool
    """True if the contact vertex belongs to a, False if to b."""
    vertex_projects_onto_other_face: bool
    """True if the vertex lies opposite the other face."""
    is_in_contact: bool
    """True if the vertex also penetrates that face: a contact."""
    normal_towards_a_x: float
    """Direction of the normal force on a, x component."""
    normal_towards_a_z: float
    """Direction of the normal force on a, z component."""
    penetration: float
    """Penetration of the vertex, m; negative while there is a gap."""
    previous_step_penetration: float
    """Penetration a step ago, m."""
    slip_of_a_in_step: float
    """Slip of a over b since then, along (n_z, −n_x), m."""
    lever_arms_about_a: LeverArmsAboutElementCentre
    """Lever arms about the centre of a."""
    lever_arms_about_b: LeverArmsAboutElementCentre
    """Lever arms about the centre of b."""


class ContactSegment(NamedTuple):
    """Segment along which the nearest faces of two elements overlap, with a contact point at each end.

    `cosine_of_angle_between_outward_normals` and `sine_of_angle_between_outward_normals` are cosine and sine of the
    rotation from the outward normal of one face to that of the other, as in `RelativeFacePosition`.
    """

    cosine_of_angle_between_outward_normals: float
    sine_of_angle_between_outward_normals: float
    point_1: PlanarContactPoint
    point_2: PlanarContactPoint
    face_vertex_positions: VertexPositionsAtOtherFace


class RelativeFacePosition(NamedTuple):
    """Relative position of a face of element a and a face of b: normals, angle between them, centre distances."""

    outward_normal_of_face_a_x: float
    """Outward normal of a's face in the axes of the scene, x component."""
    outward_normal_of_face_a_z: float
    """Outward normal of a's face, z component."""
    outward_normal_of_face_b_x: float
    """Outward normal of b's face, x component."""
    outward_normal_of_face_b_z: float
    """Outward normal of b's face, z component."""
    cosine_of_angle_between_outward_normals: float
    """Cosine of the rotation from one normal to the other."""
    sine_of_angle_between_outward_normals: float
    """Sine of that rotation, b_nz a_nx − b_nx a_nz."""
    b_to_a_centre_distance_along_normal_a: float
    """Distance from the centre of b to that of a along a's normal, m."""
    b_to_a_centre_distance_along_tangent_a: float
    """Distance from the centre of b to that of a along a's tangent, m."""
    b_to_a_centre_distance_along_normal_b: float
    """Distance from the centre of b to that of a along b's normal, m."""
    b_to_a_centre_offset_along_tangent_of_face_b: float
    """Distance from the centre of b to that of a along b's tangent, m."""


class VertexPositionAndLeverArms(NamedTuple):
    """Position of a face's vertex relative to the opposite face, now and a step ago, with lever arms of its force."""

    position_at_face: VertexPositionAtFace
    """Depth behind the other face and place along it, m; b's vertices are measured in the opposite direction."""
    previous_step_penetration: float
    """Depth a step ago, m."""
    slip_of_a_in_step: float
    """Slip of a over b since then, along (n_z, −n_x), m."""
    lever_arms_about_a: LeverArmsAboutElementCentre
    """Lever arms about the centre of a."""
    lever_arms_about_b: LeverArmsAboutElementCentre
    """Lever arms about the centre of b."""


@njit(**INLINE_OPTIONS)
def rotate_to_scene_axes(element_pose: Pose, x_in_element_axes: float, z_in_element_axes: float) -> tuple[float, float]:
    """Return the scene components of a vector with components (x, z) in the axes of an element."""
    c, s, x, z = element_pose.cos, element_pose.sin, x_in_element_axes, z_in_element_axes
    return c * x + s * z, c * z - s * x


@njit(**INTERNAL_COMPILE_OPTIONS)
def polygon_face(polygon_face_table: Any, face_index: int) -> ElementFace:
    """Return the face with number `face_index` of a polygon from the array of all its faces."""
    nx, nz = polygon_face_table[face_index, 4], polygon_face_table[face_index, 5]
    low = nx * polygon_face_table[face_index, 1] - nz * polygon_face_table[face_index, 0]
    high = nx * polygon_face_table[face_index, 3] - nz * polygon_face_table[face_index, 2]
    return ElementFace(nx, nz, polygon_face_table[face_index, 6], low, high)


@njit(**INLINE_OPTIONS)
def relative_face_position(
    face_a: ElementFace, face_b: ElementFace, pose_a: Pose, pose_b: Pose
) -> RelativeFacePosition:
    """Return normals, angle and centre distances of two faces, one of element a and one of element b."""
    dx, dz = pose_a.x - pose_b.x, pose_a.z - pose_b.z
    anx, anz = rotate_to_scene_axes(pose_a, face_a.outward_normal_x, face_a.outward_normal_z)
    bnx, bnz = rotate_to_scene_axes(pose_b, face_b.outward_normal_x, face_b.outward_normal_z)
    turn_q, turn_r = bnx * anx + bnz * anz, bnz * anx - bnx * anz
    an, at = anx * dx + anz * dz, anx * dz - anz * dx
    return RelativeFacePosition(
        outward_normal_of_face_a_x=anx,
        outward_normal_of_face_a_z=anz,
        outward_normal_of_face_b_x=bnx,
        outward_normal_of_face_b_z=bnz,
        cosine_of_angle_between_outward_normals=turn_q,
        sine_of_angle_between_outward_normals=turn_r,
        b_to_a_centre_distance_along_normal_a=an,
        b_to_a_centre_distance_along_tangent_a=at,
        b_to_a_centre_distance_along_normal_b=bnx * dx + bnz * dz,
        b_to_a_centre_offset_along_tangent_of_face_b=bnx * dz - bnz * dx,
    )


@njit(**INLINE_OPTIONS)
def convert_components_to_other_face_axes(
    normal_component: float, tangent_component: float, cosine_of_axes_rotation: float, sine_of_axes_rotation: float
) -> tuple[float, float]:
    """Convert components along the normal and tangent of one face to those along the normal and tangent of another.

    `cosine_of_axes_rotation` and `sine_of_axes_rotation` belong to the angle between the axes of the two faces.
    """
    n, t, c, s = normal_component, tangent_component, cosine_of_axes_rotation, sine_of_axes_rotation
    return n * c + t * s, t * c - n * s


@njit(**INLINE_OPTIONS)
def locate_vertex_of_a_at_face_of_b(
    vertex_position_along_own_normal: float,
    vertex_position_along_own_tangent: float,
    other_face_distance_from_centre: float,
    relative_position: RelativeFacePosition,
    previous_step_position: VertexPositionAtFace,
) -> VertexPositionAndLeverArms:
    """Return where a vertex of element a lies at a face of b: depth behind it, place along it, slip, lever arms."""
    own_n, own_t = convert_components_to_other_face_axes(
        vertex_position_along_own_normal,
        vertex_position_along_own_tangent,
        relative_position.cosine_of_angle_between_outward_normals,
        relative_position.sine_of_angle_between_outward_normals,
    )
    height = own_n + relative_position.b_to_a_centre_distance_along_normal_b
    place = own_t + relative_position.b_to_a_centre_offset_along_tangent_of_face_b
    seen = VertexPositionAtFace(other_face_distance_from_centre - height, place)
    return VertexPositionAndLeverArms(
        seen,
        previous_step_position.depth,
        previous_step_position.position_along_opposite_face - place,
        LeverArmsAboutElementCentre(own_t, own_n),
        LeverArmsAboutElementCentre(place, height),
    )


@njit(**INLINE_OPTIONS)
def locate_vertex_of_b_at_face_of_a(
    vertex_position_along_own_normal: float,
    vertex_position_along_own_tangent: float,
    other_face_distance_from_centre: float,
    relative_position: RelativeFacePosition,
    previous_step_position: VertexPositionAtFace,
) -> VertexPositionAndLeverArms:
    """Return where a vertex of element b lies at a face of a: depth behind the face, place along it, slip, lever arms.

    The place along the face increases while a slips over b in the positive direction.
    """
    own_n, own_t = convert_components_to_other_face_axes(
        vertex_position_along_own_normal,
        vertex_position_along_own_tangent,
        -relative_position.cosine_of_angle_between_outward_normals,
        relative_position.sine_of_angle_between_outward_normals,
    )
    height = own_n + relative_position.b_to_a_centre_distance_along_normal_a
    place = own_t + relative_position.b_to_a_centre_distance_along_tangent_a
    seen = VertexPositionAtFace(other_face_distance_from_centre + height, place)
    return VertexPositionAndLeverArms(
        seen,
        previous_step_position.depth,
        place - previous_step_position.position_along_opposite_face,
        LeverArmsAboutElementCentre(place, height),
        LeverArmsAboutElementCentre(own_t, own_n),
    )


@njit(**INLINE_OPTIONS)
def locate_vertices_of_both_faces(
    face_a: ElementFace,
    face_b: ElementFace,
    relative_position: RelativeFacePosition,
    previous_step_positions: VertexPositionsAtOtherFace,
) -> tuple[
    VertexPositionAndLeverArms, VertexPositionAndLeverArms, VertexPositionAndLeverArms, VertexPositionAndLeverArms
]:
    """Return positions of the four vertices of two opposite faces, first of a's face, then of b's face."""
    return (
        locate_vertex_of_a_at_face_of_b(
            face_a.face_line_distance_from_element_centre,
            face_a.start_along_tangent,
            face_b.face_line_distance_from_element_centre,
            relative_position,
            previous_step_positions.first_vertex_of_face_a,
        ),
        locate_vertex_of_a_at_face_of_b(
            face_a.face_line_distance_from_element_centre,
            face_a.end_along_tangent,
            face_b.face_line_distance_from_element_centre,
            relative_position,
            previous_step_positions.second_vertex_of_face_a,
        ),
        locate_vertex_of_b_at_face_of_a(
            face_b.face_line_distance_from_element_centre,
            face_b.start_along_tangent,
            face_a.face_line_distance_from_element_centre,
            relative_position,
            previous_step_positions.first_vertex_of_face_b,
        ),
        locate_vertex_of_b_at_face_of_a(
            face_b.face_line_distance_from_element_centre,
            face_b.end_along_tangent,
            face_a.face_line_distance_from_element_centre,
            relative_position,
            previous_step_positions.second_vertex_of_face_b,
        ),
    )


@njit(**INLINE_OPTIONS)
def build_planar_contact_point(
    vertex_is_of_a: bool,
    vertex_projects_onto_other_face: bool,
    relative_position: RelativeFacePosition,
    vertex_of_a: VertexPositionAndLeverArms,
    vertex_of_b: VertexPositionAndLeverArms,
) -> PlanarContactPoint:
    """Return a contact point of two elements: at `vertex_of_a` if `vertex_is_of_a`, else at `vertex_of_b`."""
    a, b = vertex_of_a, vertex_of_b
    depth = a.position_at_face.depth if vertex_is_of_a else b.position_at_face.depth
    return PlanarContactPoint(
        vertex_is_of_a=vertex_is_of_a,
        vertex_projects_onto_other_face=vertex_projects_onto_other_face,
        is_in_contact=vertex_projects_onto_other_face & (depth > 0.0),
        normal_towards_a_x=relative_position.outward_normal_of_face_b_x
        if vertex_is_of_a
        else -relative_position.outward_normal_of_face_a_x,
        normal_towards_a_z=relative_position.outward_normal_of_face_b_z
        if vertex_is_of_a
        else -relative_position.outward_normal_of_face_a_z,
        penetration=depth,
        previous_step_penetration=a.previous_step_penetration if vertex_is_of_a else b.previous_step_penetration,
        slip_of_a_in_step=a.slip_of_a_in_step if vertex_is_of_a else b.slip_of_a_in_step,
        lever_arms_about_a=LeverArmsAboutElementCentre(
            a.lever_arms_about_a.of_normal_force if vertex_is_of_a else b.lever_arms_about_a.of_normal_force,
            a.lever_arms_about_a.of_tangential_force if vertex_is_of_a else b.lever_arms_about_a.of_tangential_force,
        ),
        lever_arms_about_b=LeverArmsAboutElementCentre(
            a.lever_arms_about_b.of_normal_force if vertex_is_of_a else b.lever_arms_about_b.of_normal_force,
            a.lever_arms_about_b.of_tangential_force if vertex_is_of_a else b.lever_arms_about_b.of_tangential_force,
        ),
    )


@njit(**INLINE_OPTIONS)
def find_contact_segment(pair: PairState, pose_a: Pose, pose_b: Pose) -> ContactSegment:
    """Return the overlap of two elements' nearest faces, with open contact points if they are too far apart."""
    return find_contact_segment_open_if_out_of_reach(
        pair,
        pose_a,
        pose_b,
        pair.nearest_faces.relative_motion_bound_since_search_at_step_end
        >= pair.nearest_faces.max_motion_without_contact,
    )


@njit(**INLINE_OPTIONS)
def find_contact_segment_open_if_out_of_reach(
    pair: PairState, pose_a: Pose, pose_b: Pose, elements_may_touch: bool
) -> ContactSegment:
    """Return the overlap of two elements' nearest faces; its contact points are open unless `elements_may_touch`.

    Contact point 1 lies at the first vertex of a's face or the second of b's face, point 2 at the second of a's face or
    the first of b's face: each at the one of the two vertices that bounds the overlap.
    """
    f = relative_face_position(pair.nearest_face_of_a, pair.nearest_face_of_b, pose_a, pose_b)
    a1, a2, b1, b2 = locate_vertices_of_both_faces(
        pair.nearest_face_of_a, pair.nearest_face_of_b, f, pair.history.previous_vertex_positions
    )
    low = pair.nearest_face_of_b.start_along_tangent
    high = pair.nearest_face_of_b.end_along_tangent
    to = pair.ranges_where_vertices_touch_opposite_faces
    mine_1, mine_2 = (
        a1.position_at_face.position_along_opposite_face <= high,
        a2.position_at_face.position_along_opposite_face >= low,
    )
    top, bottom = -pair.nearest_face_of_a.start_along_tangent, -pair.nearest_face_of_a.end_along_tangent
    in_1 = (
        mine_1 & (a1.position_at_face.position_along_opposite_face >= to.min_contact_coordinate_of_first_vertex_of_a)
    ) | (
        (not mine_1)
        & (b2.position_at_face.position_along_opposite_face >= to.min_contact_coordinate_of_second_vertex_of_b)
        & (b2.position_at_face.position_along_opposite_face <= top)
    )
    in_2 = (
        mine_2 & (a2.position_at_face.position_along_opposite_face <= to.max_contact_coordinate_of_second_vertex_of_a)
    ) | (
        (not mine_2)
        & (b1.position_at_face.position_along_opposite_face >= bottom)
        & (b1.position_at_face.position_along_opposite_face <= to.max_contact_coordinate_of_first_vertex_of_b)
    )
    one = build_planar_contact_point(mine_1, in_1 & elements_may_touch, f, a1, b2)
    two = build_planar_contact_point(mine_2, in_2 & elements_may_touch, f, a2, b1)
    return ContactSegment(
        f.cosine_of_angle_between_outward_normals,
        f.sine_of_angle_between_outward_normals,
        one,
        two,
        VertexPositionsAtOtherFace(a1.position_at_face, a2.position_at_face, b1.position_at_face, b2.position_at_face),
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def contact_vertex_position(
    point_history: PlanarContactPointStateAfterLastStep,
    point_index_0_or_1: int,
    face_vertex_positions: VertexPositionsAtOtherFace,
) -> VertexPositionAtFace:
    """Return the position of the vertex at which contact point `point_index_0_or_1` lies."""
    if point_history.contact_vertex_status_code != CONTACT_CODE_VERTEX_OF_B:
        return (
            face_vertex_positions.first_vertex_of_face_a
            if point_index_0_or_1 == 0
            else face_vertex_positions.second_vertex_of_face_a
        )
    return (
        face_vertex_positions.second_vertex_of_face_b
        if point_index_0_or_1 == 0
        else face_vertex_positions.first_vertex_of_face_b
    )
