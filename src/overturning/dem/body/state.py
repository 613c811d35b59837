"""State of a 3-D body: named tuples, and their layout in the rows of arrays.

Quantities are per mass, as in `overturning.dem.block.state`; an inertia is in m². The frame moves with the base and is
rotated by the body's orientation: x points to its azimuth, y 90° anticlockwise of it, z up. The body's own axes
coincide with these at rest; vectors "in space" are components in this frame. `overturning.dem.kernel.lanes` describes
the memory layout. The vertices of a body have an array of their own, one block of rows `VERTEX_ROW_LAYOUT` per vertex.
"""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.vectors import (
    Matrix3,
    Quaternion,
    SymmetricMatrix,
    Vector3,
)
from overturning.dem.kernel.clock import BODY_STEP_CONTROL, CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import (
    CaseProgress,
    LargestTiltRatioInSecondHalfAfterRecord,
    LastSampleOfContinuedSlidingCase,
    RestAccelerationLimitAndAtRestFlag,
)
from overturning.dem.kernel.ground import LinearBaseAcceleration
from overturning.dem.kernel.lanes import INLINE_OPTIONS, TupleRowLayout

PARALLEL_CASE_COUNT: Final = 16
"""Number of bodies computed side by side: their rows fit into an L1 cache of 48 KB, those of more bodies would not."""

MIN_OMEGA_DT_FOR_STEPS_OF_ONE_SAMPLE: Final = 10.0
"""Smallest ratio of sampling interval to 1/ω for which a standing body without vibration takes sample-long steps."""

TICKS_PER_WHOLE_STEP: Final = BODY_STEP_CONTROL.ticks_per_whole_step
"""Ticks of a whole step."""


class BodyConstants(NamedTuple):
    """Inertia, contact constants and limits of a body, which do not change during a case."""

    mass_times_inverse_inertia: SymmetricMatrix
    """Inverse inertia in the body's own axes, m/I, 1/m²."""
    inertia_per_mass: SymmetricMatrix
    """Inertia in the body's own axes, I/m, m²."""
    centre_height: float
    """Height of the centre above the base, m."""
    round_base_radius_or_zero: float
    """Radius of a round base, m; 0 for a base with vertices."""
    point_normal_stiffness_per_mass: float
    """Normal stiffness of a vertex, K/m, 1/s²."""
    point_tangential_stiffness_per_mass: float
    """Tangential stiffness of a vertex, K_s/m, 1/s², in any direction."""
    point_tangential_compliance_times_mass: float
    """1 over the tangential stiffness per mass, m/K_s, s²; 0 without tangential springs."""
    point_dashpot_constant_per_mass: float
    """Dashpot of a vertex, h/m, 1/s."""
    friction: float
    """Coefficient of friction μ."""
    critical_lean_as_continued_squared_sine: float
    """`squared_sine_of_lean_continued_beyond_90_deg` at the critical angle."""
    extreme_vertex_tolerance_to_height_range: float
    """Share of the rise from the lowest to the highest base vertex within which vertices belong to the ends."""
    tick_length_s: float
    """Length of a tick, s."""
    flat_landing_duration_s: float
    """Duration of a flat landing after the first touch, s."""


class BodyState(NamedTuple):
    """Position, rotation, velocities and accelerations of a body in the frame of the base."""

    centre_position: Vector3
    """Position of the centre of mass, m."""
    rotation: Quaternion
    """Rotation from rest."""
    velocity_relative_to_base: Vector3
    """Velocity of the centre relative to the base, m/s."""
    angular_momentum_per_mass: Vector3
    """Angular momentum about the centre in space, per mass, m²/s."""
    angular_velocity: Vector3
    """Angular velocity in space, rad/s."""
    acceleration_relative_to_base: Vector3
    """Acceleration of the centre relative to the base at the end of the last step, m/s²."""
    contact_moment_per_mass: Vector3
    """Moment of the contact forces about the centre at the end of the last step, per mass, m²/s²."""
    ticks_since_sample_start: float
    """Ticks since the start of the sample."""


class BodyVertex(NamedTuple):
    """Position of a vertex of a body, and the base edge that starts at this vertex."""

    position_from_centre_in_body_axes: Vector3
    """Position from the centre in the body's own axes, m."""
    starting_edge_outward_normal_x: float
    """Outward normal, in the body's own axes, of the base edge that starts at the vertex; 0 if not a base vertex."""
    starting_edge_outward_normal_y: float
    starting_edge_distance_from_point_below_centre: float
    """Distance of that edge from the point below the centre, m; very large for a vertex that is not of the base."""


class BodyContactPointState(NamedTuple):
    """State of a contact point after the last step: spring stretch, position, penetration and normal force."""

    tangential_spring_stretch_x: float
    """Stretch of the tangential springs along x, m."""
    tangential_spring_stretch_y: float
    """Stretch of the tangential springs along y, m."""
    position_x_or_rim_point_velocity_x: float
    """Position of a vertex along x, m; for a point of a rim, its velocity, m/s."""
    position_y_or_rim_point_velocity_y: float
    """Position of a vertex along y, m; for a point of a rim, its velocity, m/s."""
    penetration: float
    """Penetration, m; negative in the air."""
    normal_force_per_mass: float
    """Normal force per mass, m/s²."""
    slid_in_last_step_or_rejected_attempt: float
    """1 if the point slid in the last step, or in an attempt rejected since; else 0."""
    remaining_flat_landing_time: float
    """Remaining time of a flat landing, s; 0 or less if there is none."""


class ContactPointAtStepStartAndEnd(NamedTuple):
    """State of a contact point before a step and after it (valid if the step is accepted)."""

    at_step_start: BodyContactPointState
    at_step_end: BodyContactPointState


LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S: Final = -1e300
"""Longest remaining landing time of a base or joint without loaded points, s: less than that of any loaded point."""


class BodyBaseContactState(NamedTuple):
    """Contact state of a body's base: lowest and highest vertex, flat landing times left, tilting share of friction."""

    lowest_base_vertex_height_above_centre: float
    """Height of the lowest base vertex relative to the centre, m; negative."""
    highest_base_vertex_height_above_centre: float
    """Height of the highest base vertex relative to the centre, m."""
    lowest_vertex_is_loaded_and_nearly_at_rest: float
    """1 if the lowest base vertex rests, else 0."""
    highest_vertex_is_loaded_and_nearly_at_rest: float
    """1 if the highest base vertex rests, else 0."""
    shortest_remaining_impact_time_of_base_points: float
    """Shortest remaining landing time of the base points, s; 0 or less if one of them does not land."""
    longest_landing_time_left_of_loaded_points: float
    """Longest remaining landing time of loaded base points, s; a large negative number if none is loaded."""
    tilting_share_of_friction_moment_in_flat_landing: float
    """Share of the moment of friction that tilts the body if it slides in a flat landing, 0 or 1."""


class BodyPeaksAndLastUprightTick(NamedTuple):
    """Largest lean, squared slip (m²) and penetration (m) of a body so far, and last tick at which it was upright.

    The lean is sin² of the tilt up to 90°, 2 − sin² beyond. A tick is the unit of time of the steps.
    """

    peak_lean_as_continued_squared_sine: float
    peak_squared_base_slip: float
    peak_penetration: float
    last_upright_tick_in_sample: float
    """Last tick of this sample below the critical angle; −1 if there is none."""


class BodyEnergyAndMomentumAccount(NamedTuple):
    """Work done by the base, energy lost (m²/s²) and vertical angular momentum supplied (m²/s) to a body, per mass.

    The last three fields are the rates of the first three at the end of the last step. Moment and angular momentum are
    about the vertical through the origin.
    """

    base_motion_work_per_mass: float
    lost_energy_per_mass: float
    supplied_vertical_angular_momentum_per_mass: float
    base_motion_power_per_mass_at_step_end: float
    dissipated_power_per_mass_at_step_end: float
    vertical_torque_per_mass_at_step_end: float


class InertialAndUpwardBaseAccelerations3D(NamedTuple):
    """Horizontal inertial accelerations and upward acceleration of the base, m/s², linear in time within a sample."""

    negative_of_base_acceleration_x: LinearBaseAcceleration
    """−a along x."""
    inertial_acceleration_y: LinearBaseAcceleration
    """−a along y."""
    upward_base_acceleration: LinearBaseAcceleration
    """Upward acceleration of the base, added to gravity."""


class LoadedBaseMotionSampleNumber(NamedTuple):
    """Number, counted from 1, of the sample whose base motion is loaded for a case; 0 if none is loaded."""

    one_based_sample_number_or_zero: float


class BodyTerminationLimits(NamedTuple):
    """Limits at which the case of a body ends or has failed; those common to all models are in `CaseProgress`."""

    initial_vertical_angular_momentum_per_mass: float
    """Vertical angular momentum about the origin at the start, per mass, m²/s."""
    min_base_edge_distance_from_centre: float
    """Smallest horizontal distance from the centre to an edge of the base, m."""
    fall_tilt_cosine: float
    """Cosine of the smallest tilt at which the body has fallen."""
    max_penetration: float
    """Penetration beyond which the case has failed, m."""
    max_base_acceleration_for_sample_long_steps_g: float
    """Horizontal acceleration below which a standing body takes sample-long steps, as a share of its weight."""


class PredictedContactPoint(NamedTuple):
    """Predicted penetration, velocity, contact and sliding of a contact point of a body at the end of a step."""

    position_from_centre: Vector3
    """Position from the centre, m."""
    penetration: float
    """Penetration, m."""
    tangential_spring_stretch_x: float
    """Stretch of the tangential springs along x, m."""
    tangential_spring_stretch_y: float
    """Stretch of the tangential springs along y, m."""
    velocity: Vector3
    """Velocity, m/s."""
    is_assumed_in_contact: float
    """1 if the point is assumed to be in contact, else 0."""
    is_assumed_to_slide: float
    """1 if the point is assumed to slide, else 0."""
    friction_direction_x: float
    """Direction of friction, x component of a unit vector."""
    friction_direction_y: float
    """Direction of friction, y component."""
    is_load_deferred_until_both_base_ends_rest: float
    """1 if the point carries only after the ends of the base rest, else 0."""
    body_lands_flat: float
    """1 if the body lands flat, so that the dashpot may pull, else 0."""
    tilting_share_of_friction_moment: float
    """Share of the moment of friction that tilts the body; 1 except in a flat landing."""
    tilting_share_of_friction_moment_in_flat_landing: float
    """Share of the moment of friction that tilts the body if the point slides in a flat landing."""
    flat_landing_time_left_if_contact_begins_now: float
    """Landing time of the point if it touches now, s."""


class StepRejectedAndSameContactStateFlags(NamedTuple):
    """Flags (1 or 0) of an attempted step: it is rejected; the next attempt assumes the same sliding."""

    is_step_rejected: float
    next_attempt_keeps_slip_assumption: float


class BodyPredictedForStepEnd(NamedTuple):
    """Predicted state of a body at the end of a step of the centred scheme, before the equations are solved."""

    centre_position: Vector3
    rotation: Quaternion
    velocity_at_half_step: Vector3
    """Velocity after half of the step, m/s."""
    angular_momentum_per_mass_at_half_step: Vector3
    """Angular momentum after half of the step, m²/s."""
    end_velocity: Vector3
    """Velocity at the end of the step, m/s."""
    end_angular_velocity: Vector3
    """Angular velocity at the end of the step, rad/s."""
    negative_horizontal_and_upward_base_acceleration: Vector3
    """−a along x and y, and the upward acceleration of the base, m/s²."""
    half_step_length_s: float
    """Half the length of the step, s."""


class ContactForcesAndNegatedVelocityDerivatives(NamedTuple):
    """Sums over a body's contact points, per mass, for the equations of a step: forces, moments, and their derivatives.

    The derivatives by the velocities have the opposite sign and are multiplied by half the length of the step.
    """

    force_per_mass: Vector3
    moment_per_mass: Vector3
    half_step_times_force_decrease_per_velocity: Matrix3
    """Decrease of force by velocity × half step."""
    half_step_times_force_decrease_per_angular_velocity: Matrix3
    """Decrease of force by angular velocity × half step, m."""
    half_step_times_moment_decrease_per_velocity: Matrix3
    """Decrease of moment by velocity × half step, m."""
    half_step_times_moment_decrease_per_angular_velocity: Matrix3
    """Decrease of moment by angular velocity × half step, m²."""


class BodyVelocityCorrection(NamedTuple):
    """Correction of a body's predicted velocity (m/s) and angular velocity (rad/s) at the end of a step."""

    velocity: Vector3
    angular_velocity: Vector3


class ContactForceAndMomentSum(NamedTuple):
    """Sum of the contact forces and moments of a body over its contact points at the end of a step, per mass."""

    force_per_mass: Vector3
    moment_per_mass: Vector3
    extra_impulse_per_mass_from_early_closure: Vector3
    """Additional momentum of contacts that closed early in the step, per mass, m/s."""
    extra_angular_impulse_per_mass_from_early_closure: Vector3
    """Additional angular momentum of contacts that closed early in the step, m²/s."""
    dissipated_power_per_mass: float
    """Power dissipated by dashpots and friction, m²/s³."""
    lost_spring_energy_per_mass: float
    """Spring energy lost in the step by slip or opening, m²/s²."""


class LargestContactChangesOfBody(NamedTuple):
    """Contact changes in an attempted step: for each kind of change, the largest value over a body's contact points."""

    positive_if_contact_opened_or_closed: float
    """Above 0 if a contact opened or closed."""
    has_wrong_slip_assumption: float
    """1 if a point stuck or slid contrary to the assumption."""
    has_friction_opposite_to_assumption: float
    """1 if the friction of a point assumed to slide acts against the assumed direction."""
    some_loaded_point_sticks: float
    """1 if a loaded point sticks."""
    friction_sign_changed_in_step: float
    """1 if a point slides whose friction had the opposite sign before."""
    some_point_carries_no_load: float
    """1 if a point carries no load."""
    largest_penetration: float
    """Largest penetration, m."""


STATE_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, BodyConstants, CaseStepLengthsAndDoublingCounts, BodyState, Matrix3,
    BodyBaseContactState, BodyPeaksAndLastUprightTick,
    BodyEnergyAndMomentumAccount, InertialAndUpwardBaseAccelerations3D, LoadedBaseMotionSampleNumber, CaseProgress,
    BodyTerminationLimits, NextStepToAttempt, StepRejectedAndSameContactStateFlags, BodyPredictedForStepEnd,
    ContactForcesAndNegatedVelocityDerivatives, BodyVelocityCorrection, ContactForceAndMomentSum,
    LargestContactChangesOfBody, RestAccelerationLimitAndAtRestFlag, LargestTiltRatioInSecondHalfAfterRecord,
    LastSampleOfContinuedSlidingCase,
)  # fmt: skip
VERTEX_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, BodyVertex, ContactPointAtStepStartAndEnd, PredictedContactPoint
)


@njit(**INLINE_OPTIONS)
def squared_sine_of_lean_continued_beyond_90_deg(body_axes: Matrix3) -> float:
    """Return sin² of the tilt of a body's vertical axis (its lean); 2 − sin² if the tilt exceeds 90°."""
    square = body_axes.xz * body_axes.xz + body_axes.yz * body_axes.yz
    return square if body_axes.zz > 0.0 else 2.0 - square
