"""State of the joints of a 3-D stack and of their contact points: named tuples, and their layout in rows of arrays.

A *joint* is the contact of a stone with what it stands on; its quantities are in the frame of the lower face: origin at
the centre of that face, axes of the lower stone. See `overturning.dem.stack.state`.
"""

import math
from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.vectors import Matrix3, Vector3
from overturning.dem.kernel.lanes import INLINE_OPTIONS, TupleRowLayout
from overturning.dem.stack.state import PARALLEL_CASE_COUNT, ForceAndMomentOrVelocities, VelocityToForceBlocks


class JointConstants(NamedTuple):
    """Springs, dashpots and friction of the contact (joint) of a stone with the stone or ground below it."""

    normal_stiffness: float
    """Normal stiffness of the whole joint, N/m."""
    normal_dashpot: float
    """Normal dashpot of the whole joint, N·s/m."""
    tangential_stiffness: float
    """Tangential stiffness, N/m, in any direction."""
    tangential_compliance_or_zero_without_spring: float
    """1 over the tangential stiffness, m/N; 0 without tangential springs."""
    tangential_dashpot: float
    """Tangential dashpot, N·s/m."""
    friction: float
    """Coefficient of friction μ."""
    flat_landing_duration_s: float
    """Duration of a flat landing after the first touch, s."""
    tilting_share_of_friction_moment_in_flat_landing: float
    """Share of the moment of friction that tilts a stone that slides in a flat landing, 0 or 1."""
    min_rim_distance_to_defer_flat_landing_contact: float
    """Least distance of the base from the rim of the face below at which corners between the two ends of the base wait
    in a flat landing, m; `overturning.dem.stack.landing.RIM_DISTANCE_MARKING_NO_CONTACT_DEFERRAL_M` for bases of four
    corners."""
    upper_base_corner_count: float
    """Number of corners of the upper base."""


class TangentialVectorWithScaledTwist(NamedTuple):
    """Tangential displacement, velocity or direction at a contact of two stones: x, y and scaled twist.

    The twist is multiplied by the mean distance of the normal forces from the centre of pressure.
    """

    x: float
    y: float
    twist_times_radius: float


@njit(**INLINE_OPTIONS)
def squared_length(v: TangentialVectorWithScaledTwist) -> float:
    """Return x² + y² + twist² of a tangential vector, whose twist is already multiplied by a radius."""
    return (v.x * v.x + v.y * v.y) + v.twist_times_radius * v.twist_times_radius


@njit(**INLINE_OPTIONS)
def scale_tangent_twist_vector(factor: float, v: TangentialVectorWithScaledTwist) -> TangentialVectorWithScaledTwist:
    """Return a tangential vector (components x, y, twist) multiplied by a number."""
    return TangentialVectorWithScaledTwist(factor * v.x, factor * v.y, factor * v.twist_times_radius)


@njit(**INLINE_OPTIONS)
def unit_tangent_twist_vector(v: TangentialVectorWithScaledTwist) -> TangentialVectorWithScaledTwist:
    """Return a tangential vector (components x, y, twist) scaled to length 1; zero for a zero vector."""
    square = squared_length(v)
    return scale_tangent_twist_vector(1.0 / math.sqrt(square if square > 0.0 else 1.0), v)


class JointContactState(NamedTuple):
    """Contact state of two stones after the last step: spring stretch, slip velocity, pressure centre, normal force."""

    tangential_spring_stretch: TangentialVectorWithScaledTwist
    """Stretch of the tangential springs, m."""
    slip_velocity_at_pressure_centre: TangentialVectorWithScaledTwist
    """Velocity of the upper stone relative to the lower at the centre of pressure, m/s."""
    pressure_centre_x: float
    """Centre of pressure along x, m."""
    pressure_centre_y: float
    """Centre of pressure along y, m."""
    mean_distance_of_forces_from_pressure_centre: float
    """Mean distance of the normal forces from the centre of pressure, m."""
    normal_force: float
    """Normal force, N."""
    slid_in_last_step_or_rejected_attempt: float
    """1 if the joint slid in the last step, or in an attempt rejected since; else 0."""
    uses_non_corner_point: float
    """1 if a contact point other than a corner of the upper stone had a share of the stiffness, else 0."""


class JointAtStepStartAndEnd(NamedTuple):
    """Contact state of two stones before a step and after it (valid if the step is accepted)."""

    at_step_start: JointContactState
    at_step_end: JointContactState


class FlatLandingTimesLeftAndPointHeights(NamedTuple):
    """Shortest and longest time left (s) in a flat landing of a stone, and lowest and highest contact point (m).

    Times and heights (above the lower face) are extremes over the contact points of two stones.
    """

    shortest_remaining_impact_time_in_flat_landing: float
    """Shortest remaining landing time of the points, s; 0 or less if one of them does not land."""
    longest_flat_landing_time_left_of_loaded_points: float
    """Longest remaining landing time of loaded points, s; a large negative number if none is loaded."""
    lowest_point_height_above_lower_face: float
    """Smallest height of a point of the patch above the lower face at the predicted end of the step, m."""
    highest_point_height_above_lower_face: float
    """Largest height of a point of the patch, m."""


class JointRelativePoseAndVelocity(NamedTuple):
    """Relative pose and velocity of a stone at the predicted end of a step, in the frame of the face below it."""

    upper_base_centre: Vector3
    """Position of the centre of the upper stone's base, m."""
    upper_x_axis: Vector3
    """Direction of the upper stone's x axis."""
    upper_y_axis: Vector3
    """Direction of the upper stone's y axis."""
    velocity_at_origin: Vector3
    """Relative velocity at the origin, m/s."""
    angular_velocity: Vector3
    """Relative angular velocity, rad/s."""
    smallest_distance_of_base_corners_inside_rim: float
    """Smallest distance of a corner of the upper base from the rim of the lower face, m; negative outside."""
    contact_patch_perimeter: float
    """Length of the rim of the patch, m."""


class JointFrameAxesAndOrigin(NamedTuple):
    """Axes and origin of a joint's frame (contact of two stones) at the predicted step end, in axes of the ground."""

    axes: Matrix3
    """Directions of the axes of the frame, as columns; z is the normal of contact."""
    origin: Vector3
    """Position of the origin, m."""


class LoadSumsToFindContactNormal(NamedTuple):
    """Sums over the contact points of two partly overlapping faces, from which the normal of contact follows.

    Each point counts with its load: its share of the joint's stiffness × its penetration, m.
    """

    stiffness_share_times_penetration: float
    """Sum of the loads, m."""
    stiffness_share_times_penetration_times_x: float
    """Sums of load × position in the lower face, m²."""
    stiffness_share_times_penetration_times_y: float
    stiffness_share_times_penetration_times_slope_x: float
    """Sums of load × horizontal component of the normal over its vertical component, m."""
    stiffness_share_times_penetration_times_slope_y: float


class JointNormalForceSumsWithDerivatives(NamedTuple):
    """Sums over the contact points of two stones: normal force, its moments, and their velocity derivatives."""

    normal_force: float
    """Normal force at the predicted end, N."""
    normal_force_times_x: float
    """First moments of the force, N·m."""
    normal_force_times_y: float
    half_step_times_normal_force_decrease_per_velocity: float
    """Half of the step × decrease of the normal force by the opening velocity, kg, and its moments."""
    half_step_times_normal_force_decrease_per_velocity_times_x: float
    half_step_times_normal_force_decrease_per_velocity_times_y: float
    half_step_times_normal_force_decrease_per_velocity_times_x_squared: float
    half_step_times_normal_force_decrease_per_velocity_times_xy: float
    half_step_times_normal_force_decrease_per_velocity_times_y_squared: float


class SumOfForceTimesDistanceToPressureCentre(NamedTuple):
    """Sum, over the contact points of two stones, of normal force × distance from the centre of pressure, N·m."""

    force_times_distance_from_pressure_centre: float


class AssumedJointFrictionInStep(NamedTuple):
    """Friction between two stones assumed in a step's equations: point of action, spring stretch, direction."""

    friction_application_point_x: float
    """Point at which friction acts, m."""
    friction_application_point_y: float
    friction_application_point_height_above_lower_face: float
    mean_distance_of_forces_from_pressure_centre: float
    """Mean distance of the normal forces from the centre of pressure, m."""
    tangential_spring_stretch: TangentialVectorWithScaledTwist
    """Stretch of the tangential springs at the predicted end, m."""
    slip_velocity_at_friction_point: TangentialVectorWithScaledTwist
    """Relative velocity at that point, m/s."""
    is_assumed_loaded: float
    """1 if the joint is assumed to carry load."""
    is_assumed_to_slide: float
    """1 if the joint is assumed to slide."""
    friction_direction: TangentialVectorWithScaledTwist
    """Direction of friction, unit vector."""


class PredictedJointForceAndDerivatives(NamedTuple):
    """Predicted force and moment between two stones at the end of a step, and their derivatives by the velocities.

    The derivatives have the opposite sign and are multiplied by half of the step. After the equations are solved, the
    first field holds the changes of the stones' relative velocity and angular velocity instead.
    """

    predicted_wrench_replaced_by_velocity_change: ForceAndMomentOrVelocities
    half_step_times_wrench_decrease_per_velocity: VelocityToForceBlocks


class FaceCorner(NamedTuple):
    """Corner of the upper stone's base or of the face below, with the side that starts at the corner."""

    x_from_face_centre: float
    """Position in the axes of its stone from the centre of its face, m."""
    y_from_face_centre: float
    next_side_outward_normal_x: float
    """Outward normal of the side that starts at the corner."""
    next_side_outward_normal_y: float
    next_side_distance_from_face_centre: float
    """Distance of that side from the centre of the face, m."""
    joint_stiffness_share_if_whole_base_rests: float
    """Share of the joint's stiffness at the corner while the whole base rests."""


class ContactPointPosition(NamedTuple):
    """Position of a contact point of two stones at the predicted end of a step, in the frame of the lower face."""

    x_in_lower_face_frame: float
    y_in_lower_face_frame: float
    upper_base_height_above_lower_face: float
    """Height of the upper base above the lower face, m."""
    joint_stiffness_share: float
    """Share of the stiffness of the joint that stands at the point."""


class SidePartInContactPatch(NamedTuple):
    """Part of a face's side that bounds the contact patch (overlap of two faces); its ends as shares of the side."""

    begin_side_fraction: float
    """Start, as a share of the side."""
    end_side_fraction: float
    """End, as a share of the side."""
    length: float
    """Length of the part, m."""


class BaseOverhangAndContactNormalSlopesAtSide(NamedTuple):
    """Overhang of the upper base beyond a side of the lower face, and slopes of contact normals where sides cross."""

    max_base_corner_distance_beyond_side: float
    """Largest distance by which a corner of the upper base lies beyond the side, m."""
    contact_normal_slope_at_clipped_side_start: float
    """Slope of the contact normal across the side where its clipped part begins; 0 for a vertical normal."""
    contact_normal_slope_at_clipped_side_end: float
    """Slope of the contact normal across the side where its clipped part ends; 0 for a vertical normal."""


class ContactPointState(NamedTuple):
    """State of a contact point of two stones after the last step: penetration, force, landing time, stiffness."""

    penetration: float
    """Penetration, m; negative in the air."""
    force_per_stiffness_share: float
    """Normal force over `stiffness_share`, N."""
    remaining_flat_landing_time: float
    """Remaining time of a flat landing, s; 0 or less if there is none."""
    joint_stiffness_share: float
    """Share of the stiffness of the joint that stands at the point."""
    force_free_penetration_in_flat_landing: float
    """Penetration that the point took up without force while it waited in a flat landing, m."""


class JointPointAtStepStartAndEnd(NamedTuple):
    """State of a contact point of two stones before a step and after it (valid if the step is accepted)."""

    at_step_start: ContactPointState
    at_step_end: ContactPointState


class HalfStepAndFlatLandingConditionsOfPoint(NamedTuple):
    """Length of a step, and conditions of a flat landing, for one contact point of two stones."""

    half_step_length_s: float
    """Half the length of the step, s."""
    base_lands_flat: bool
    """True if the base of the upper stone lands flat."""
    landing_time_if_touching_now_s: float
    """Landing time of the point if it touches now, s."""
    is_load_deferred_in_flat_landing: bool
    """True if the point carries load only later in the landing."""
    joint_had_points: bool
    """True if the joint has had contact points since the last step; False when a case begins."""


class JointFrictionSolutionInputs(NamedTuple):
    """Conditions under which the friction between two stones is predicted and solved in a step."""

    half_step_length_s: float
    """Half the length of the step, s."""
    decides_sliding_from_predicted_forces: bool
    """True if the predicted forces decide about sliding; False if the state after the last step is assumed."""
    base_lands_flat: bool
    """True if the base of the upper stone lands flat."""
    upper_centre_height_above_base: float
    """Height of the upper stone's centre above its base, m."""


class NormalForceAndEarlyContactImpulseSums(NamedTuple):
    """Normal force, and impulse of contacts that closed early in a step, with their moments, of one or several points.

    The impulse comes in addition to that of the normal force during half of the step.
    """

    normal_force: float
    """Normal force, N, and its first moments, N·m."""
    normal_force_times_x: float
    normal_force_times_y: float
    extra_impulse_of_points_closed_early_in_step: float
    """Additional impulse of points that closed early in the step, N·s, and its first moments."""
    early_contact_impulse_times_x: float
    early_contact_impulse_times_y: float


class SolvedContactForceSums(NamedTuple):
    """Sums over all contact points of two stones of normal forces and impulses from a step's solved equations."""

    point_force_and_impulse_sums_at_step_end: NormalForceAndEarlyContactImpulseSums


JOINT_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, JointConstants, JointAtStepStartAndEnd, FlatLandingTimesLeftAndPointHeights,
    JointFrameAxesAndOrigin, LoadSumsToFindContactNormal, JointRelativePoseAndVelocity,
    JointNormalForceSumsWithDerivatives,
    SumOfForceTimesDistanceToPressureCentre, AssumedJointFrictionInStep, PredictedJointForceAndDerivatives,
    SolvedContactForceSums
)  # fmt: skip
POINT_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT,
    FaceCorner,
    ContactPointPosition,
    SidePartInContactPatch,
    BaseOverhangAndContactNormalSlopesAtSide,
    JointPointAtStepStartAndEnd,
)
