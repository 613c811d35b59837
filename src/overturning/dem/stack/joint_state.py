"""State of the joints of a 3-D stack and of their contact points: named tuples, and their layout in rows of arrays.

A *joint* is the contact of a stone with what it stands on; its quantities are in the frame of the lower face: origin at
the centre of that face, axes of the lower stone. See `overturning.dem.stack.state`.
"""

import math
from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.vectors import Matrix3, Vector3
from overturning.dem.kernel.lanes import INLINE_OPTIONS, TupleRowLayout
from overturning.dem.stack.state import PARALLEL_CASE_COUNT, VelocityToForceBlocks, Wrench


class JointConstants(NamedTuple):
    """Springs, dashpots and friction of the contact (joint) of a stone with the stone or ground below it."""

    normal_stiffness: float
    """Normal stiffness of the whole joint, N/m."""
    normal_dashpot: float
    """Normal dashpot of the whole joint, N·s/m."""
    tangential_stiffness: float
    """Tangential stiffness, N/m, in any direction."""
    tangential_compliance: float
    """1 over the tangential stiffness, m/N; 0 without tangential springs."""
    tangential_dashpot: float
    """Tangential dashpot, N·s/m."""
    friction: float
    """Coefficient of friction μ."""
    landing_duration: float
    """Duration of a flat landing after the first touch, s."""
    friction_moment_share: float
    """Share of the moment of friction that tilts a stone that slides in a flat landing, 0 or 1."""
    min_rim_distance_of_waiting_corners: float
    """Least distance of the base from the rim of the face below at which corners between the two ends of the base wait
    in a flat landing, m; `overturning.dem.stack.landing.RIM_DISTANCE_WITHOUT_DEFERRED_CONTACT` for bases of four
    corners."""
    base_corner_count: float
    """Number of corners of the upper base."""


class TangentTwistVector(NamedTuple):
    """Tangential displacement, velocity or direction at a contact of two stones: x, y and scaled twist.

    The twist is multiplied by the mean distance of the normal forces from the centre of pressure.
    """

    x: float
    y: float
    twist: float


@njit(**INLINE_OPTIONS)
def squared_length(v: TangentTwistVector) -> float:
    """Return x² + y² + twist² of a tangential vector, whose twist is already multiplied by a radius."""
    return (v.x * v.x + v.y * v.y) + v.twist * v.twist


@njit(**INLINE_OPTIONS)
def scale_tangent_twist_vector(factor: float, v: TangentTwistVector) -> TangentTwistVector:
    """Return a tangential vector (components x, y, twist) multiplied by a number."""
    return TangentTwistVector(factor * v.x, factor * v.y, factor * v.twist)


@njit(**INLINE_OPTIONS)
def unit_tangent_twist_vector(v: TangentTwistVector) -> TangentTwistVector:
    """Return a tangential vector (components x, y, twist) scaled to length 1; zero for a zero vector."""
    square = squared_length(v)
    return scale_tangent_twist_vector(1.0 / math.sqrt(square if square > 0.0 else 1.0), v)


class JointContactState(NamedTuple):
    """Contact state of two stones after the last step: spring stretch, slip velocity, pressure centre, normal force."""

    stretch: TangentTwistVector
    """Stretch of the tangential springs, m."""
    velocity: TangentTwistVector
    """Velocity of the upper stone relative to the lower at the centre of pressure, m/s."""
    pressure_centre_x: float
    """Centre of pressure along x, m."""
    pressure_centre_y: float
    """Centre of pressure along y, m."""
    mean_pressure_radius: float
    """Mean distance of the normal forces from the centre of pressure, m."""
    normal_force: float
    """Normal force, N."""
    has_slid: float
    """1 if the joint slid, else 0."""
    has_loaded_non_corner_point: float
    """1 if a contact point other than a corner of the upper stone had a share of the stiffness, else 0."""


class JointAtStepStartAndEnd(NamedTuple):
    """Contact state of two stones before a step (`old`), and after it (`new`, valid if the step is accepted)."""

    old: JointContactState
    new: JointContactState


class RemainingFlatLandingTimes(NamedTuple):
    """Shortest and longest time left (s) in a flat landing of a stone, and lowest and highest contact point (m).

    The times are those over the contact points of two stones, in the impact of a base that lands flat.
    """

    shortest: float
    """Shortest remaining landing time of the points, s; 0 or less if one of them does not land."""
    longest: float
    """Longest remaining landing time of loaded points, s; `LANDING_TIME_VALUE_FOR_BASE_IN_AIR` if there is none."""
    lowest_point_height: float
    """Smallest height of a point of the patch above the lower face at the predicted end of the step, m."""
    highest_point_height: float
    """Largest height of a point of the patch, m."""


class JointRelativeMotion(NamedTuple):
    """Relative pose and velocity of a stone at the predicted end of a step, in the frame of the face below it."""

    base_centre: Vector3
    """Position of the centre of the upper stone's base, m."""
    upper_x_axis: Vector3
    """Direction of the upper stone's x axis."""
    upper_y_axis: Vector3
    """Direction of the upper stone's y axis."""
    velocity: Vector3
    """Relative velocity at the origin, m/s."""
    angular_velocity: Vector3
    """Relative angular velocity, rad/s."""
    min_rim_distance: float
    """Smallest distance of a corner of the upper base from the rim of the lower face, m; negative outside."""
    patch_perimeter: float
    """Length of the rim of the patch, m."""


class JointFrameAxesAndOrigin(NamedTuple):
    """Axes and origin of the coordinate frame of a joint (contact of two stones), in the axes of the ground.

    They are those at the predicted end of a step.
    """

    axes: Matrix3
    """Directions of the axes of the frame, as columns; z is the normal of contact."""
    origin: Vector3
    """Position of the origin, m."""


class ContactNormalSums(NamedTuple):
    """Sums over the contact points of two stones that overlap in part, from which the normal of contact follows.

    Each point counts with its load: its share of the joint's stiffness × its penetration, m.
    """

    load: float
    """Sum of the loads, m."""
    load_times_x: float
    """Sums of load × position in the lower face, m²."""
    load_times_y: float
    load_times_slope_x: float
    """Sums of load × horizontal component of the normal over its vertical component, m."""
    load_times_slope_y: float


class JointNormalForceSums(NamedTuple):
    """Sums over the contact points of two stones: normal force, its moments, and their velocity derivatives."""

    force: float
    """Normal force at the predicted end, N."""
    force_times_x: float
    """First moments of the force, N·m."""
    force_times_y: float
    impulse_per_velocity: float
    """Half of the step times the derivative of the force by the opening velocity, kg, and its moments."""
    impulse_per_velocity_times_x: float
    impulse_per_velocity_times_y: float
    impulse_per_velocity_times_xx: float
    impulse_per_velocity_times_xy: float
    impulse_per_velocity_times_yy: float


class SumOfForceTimesDistance(NamedTuple):
    """Sum, over the contact points of two stones, of normal force × distance from the centre of pressure, N·m."""

    moment: float


class JointFrictionInStepEquations(NamedTuple):
    """Friction between two stones assumed in a step's equations: point of action, spring stretch, direction."""

    pressure_centre_x: float
    """Point at which friction acts, m."""
    pressure_centre_y: float
    pressure_centre_z: float
    mean_pressure_radius: float
    """Mean distance of the normal forces from the centre of pressure, m."""
    stretch: TangentTwistVector
    """Stretch of the tangential springs at the predicted end, m."""
    velocity: TangentTwistVector
    """Relative velocity at that point, m/s."""
    is_loaded: float
    """1 if the joint is assumed to carry load."""
    slides: float
    """1 if the joint is assumed to slide."""
    direction: TangentTwistVector
    """Direction of friction, unit vector."""


class JointEquations(NamedTuple):
    """Predicted force and moment between two stones at the end of a step, and their derivatives by the velocities."""

    wrench: Wrench
    blocks: VelocityToForceBlocks


class FaceCorner(NamedTuple):
    """Corner of the upper stone's base or of the face below, with the side that starts at the corner."""

    x: float
    """Position in the axes of its stone from the centre of its face, m."""
    y: float
    side_normal_x: float
    """Outward normal of the side that starts at the corner."""
    side_normal_y: float
    side_distance: float
    """Distance of that side from the centre of the face, m."""
    stiffness_share: float
    """Share of the joint's stiffness at the corner while the whole base rests."""


class ContactPointPosition(NamedTuple):
    """Position of a contact point of two stones at the predicted end of a step, in the frame of the lower face."""

    x: float
    y: float
    z: float
    """Height of the upper base above the lower face, m."""
    stiffness_share: float
    """Share of the stiffness of the joint that stands at the point."""


class SidePartInContactPatch(NamedTuple):
    """Part of a face's side that bounds the contact patch (overlap of two faces); its ends as shares of the side."""

    begin: float
    """Start, as a share of the side."""
    end: float
    """End, as a share of the side."""
    length: float
    """Length of the part, m."""


class BaseOverhangAtSide(NamedTuple):
    """Overhang of the upper base beyond a side of the lower face, and slopes of contact normals where sides cross."""

    overhang: float
    """Largest distance by which a corner of the upper base lies beyond the side, m."""
    normal_slope_at_begin: float
    """Slope of the contact normal across the side where its clipped part begins; 0 for a vertical normal."""
    normal_slope_at_end: float
    """Slope of the contact normal across the side where its clipped part ends; 0 for a vertical normal."""


class ContactPointState(NamedTuple):
    """State of a contact point of two stones after the last step: penetration, force, landing time, stiffness."""

    penetration: float
    """Penetration, m; negative in the air."""
    force_per_stiffness_share: float
    """Normal force over `stiffness_share`, N."""
    remaining_flat_landing_time: float
    """Remaining time of a flat landing, s; 0 or less if there is none."""
    stiffness_share: float
    """Share of the stiffness of the joint that stands at the point."""
    penetration_without_force: float
    """Penetration that the point took up without force while it waited in a flat landing, m."""


class JointPointAtStepStartAndEnd(NamedTuple):
    """State of a contact point of two stones before a step (`old`), and after it (`new`, valid if accepted)."""

    old: ContactPointState
    new: ContactPointState


class JointPointForceAndImpulse(NamedTuple):
    """Normal force, and impulse of contacts that closed early in a step, with their moments, of one or several points.

    The impulse comes in addition to that of the normal force during half of the step.
    """

    force: float
    """Normal force, N, and its first moments, N·m."""
    force_times_x: float
    force_times_y: float
    early_contact_impulse: float
    """Additional impulse of points that closed early in the step, N·s, and its first moments."""
    early_impulse_times_x: float
    early_impulse_times_y: float


class SolvedContactForceSums(NamedTuple):
    """Sums over all contact points of two stones of normal forces and impulses from a step's solved equations."""

    at_end: JointPointForceAndImpulse


JOINT_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, JointConstants, JointAtStepStartAndEnd, RemainingFlatLandingTimes, JointFrameAxesAndOrigin,
    ContactNormalSums, JointRelativeMotion, JointNormalForceSums, SumOfForceTimesDistance,
    JointFrictionInStepEquations, JointEquations, SolvedContactForceSums
)  # fmt: skip
POINT_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT,
    FaceCorner,
    ContactPointPosition,
    SidePartInContactPatch,
    BaseOverhangAtSide,
    JointPointAtStepStartAndEnd,
)
