"""Positions of vertices at earlier times, extrapolated back from the present motion."""

from numba import njit

from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.kernel.mechanics import rotate_cosine_and_sine_by_small_angle
from overturning.dem.polygon.faces import locate_vertices_of_both_faces, relative_face_position
from overturning.dem.polygon.state import (
    ElementState,
    PairState,
    Pose,
    VertexPositionsAtOtherFace,
)


@njit(**INTERNAL_COMPILE_OPTIONS)
def earlier_vertex_positions(
    pair: PairState, element_a: ElementState, element_b: ElementState, time_before_present: float
) -> VertexPositionsAtOtherFace:
    """Return earlier positions of the vertices of two elements' nearest faces, extrapolated at present velocities."""
    f = relative_face_position(
        pair.nearest_face_of_a,
        pair.nearest_face_of_b,
        pose_extrapolated_back_in_time(element_a, time_before_present),
        pose_extrapolated_back_in_time(element_b, time_before_present),
    )
    a1, a2, b1, b2 = locate_vertices_of_both_faces(
        pair.nearest_face_of_a, pair.nearest_face_of_b, f, pair.history.previous_vertex_positions
    )
    return VertexPositionsAtOtherFace(
        a1.position_at_face, a2.position_at_face, b1.position_at_face, b2.position_at_face
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def pose_extrapolated_back_in_time(element: ElementState, time_before_present: float) -> Pose:
    """Return an element's earlier pose, extrapolated at its present velocity; `angle` keeps its present value."""
    c, s = rotate_cosine_and_sine_by_small_angle(
        element.pose.cos, element.pose.sin, -time_before_present * element.velocity.angular
    )
    return Pose(
        element.pose.x - time_before_present * element.velocity.x,
        element.pose.z - time_before_present * element.velocity.z,
        element.pose.angle,
        c,
        s,
    )
