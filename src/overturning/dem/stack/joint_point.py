"""Normal spring and dashpot at one contact point of two stones: predicted force, terms of equations, and solution."""

import math
from typing import Final

from numba import njit

from overturning.dem.body.vectors import Vector3
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.stack.joint_state import (
    ContactPointPosition,
    ContactPointState,
    HalfStepAndFlatLandingConditionsOfPoint,
    JointConstants,
    JointNormalForceSumsWithDerivatives,
    JointRelativePoseAndVelocity,
    NormalForceAndEarlyContactImpulseSums,
)
from overturning.dem.stack.state import ContactPowerLossAndLostSpringEnergy, LargestContactChangesOfStack

MIN_POINT_STIFFNESS_SHARE_TO_SHORTEN_STEP: Final = 1e-3
"""Smallest share of the joint's stiffness with which a point asks for a finer step when it opens or closes."""


@njit(**INLINE_OPTIONS)
def point_opening_rate(relative_motion: JointRelativePoseAndVelocity, point_position: ContactPointPosition) -> float:
    """Return the velocity (m/s) at which a contact point of two stones opens at the predicted end of a step."""
    return relative_motion.velocity_at_origin.z + (
        relative_motion.angular_velocity.x * point_position.y_in_lower_face_frame
        - relative_motion.angular_velocity.y * point_position.x_in_lower_face_frame
    )


@njit(**INLINE_OPTIONS)
def predicted_force_per_stiffness_share_and_contact(
    joint_constants: JointConstants, relative_motion: JointRelativePoseAndVelocity,
    point_position: ContactPointPosition,
    point_state_at_step_start: ContactPointState, forces_decide_flat_landing_and_deferral_flags: tuple[bool, bool,
    bool],
) -> tuple[float, bool]:  # fmt: skip
    """Return a contact point's predicted normal force over its stiffness share, N, and True if it is in contact.

    The predicted force decides about contact in a step that resolves the contact vibration, and at a point that is new
    in the contact patch; otherwise the contact state after the last step decides.
    """
    forces_decide_contact, lands_flat, waits = forces_decide_flat_landing_and_deferral_flags
    depth = (
        -point_position.upper_base_height_above_lower_face
        - point_state_at_step_start.force_free_penetration_in_flat_landing
    )
    pressure = joint_constants.normal_stiffness * depth - joint_constants.normal_dashpot * point_opening_rate(
        relative_motion, point_position
    )
    now = ((pressure > 0.0) | lands_flat) & (depth > 0.0)
    decides = forces_decide_contact | (point_state_at_step_start.joint_stiffness_share == 0.0)
    touches = now if decides else point_state_at_step_start.force_per_stiffness_share != 0.0
    return pressure, touches & (point_position.joint_stiffness_share > 0.0) & (not waits)


@njit(**INLINE_OPTIONS)
def normal_force_sum_terms_of_point(
    joint_constants: JointConstants,
    half_step_length_s: float,
    point_position: ContactPointPosition,
    normal_force_if_stiffness_share_is_1: float,
    is_assumed_in_contact: bool,
) -> JointNormalForceSumsWithDerivatives:
    """Return one contact point's terms in the sums of force and moment between two stones in a step's equations."""
    n = point_position.joint_stiffness_share * normal_force_if_stiffness_share_is_1 if is_assumed_in_contact else 0.0
    rate = joint_constants.normal_dashpot + half_step_length_s * joint_constants.normal_stiffness
    g = half_step_length_s * (point_position.joint_stiffness_share * rate) if is_assumed_in_contact else 0.0
    gx, gy = g * point_position.x_in_lower_face_frame, g * point_position.y_in_lower_face_frame
    return JointNormalForceSumsWithDerivatives(
        n,
        n * point_position.x_in_lower_face_frame,
        n * point_position.y_in_lower_face_frame,
        g,
        gx,
        gy,
        gx * point_position.x_in_lower_face_frame,
        gx * point_position.y_in_lower_face_frame,
        gy * point_position.y_in_lower_face_frame,
    )


@njit(**INLINE_OPTIONS)
def point_contact_forces_and_state_at_step_end(
    joint_constants: JointConstants, relative_motion: JointRelativePoseAndVelocity,
    point_position: ContactPointPosition,
    point_state_at_step_start: ContactPointState, relative_velocity_and_spin_changes: tuple[Vector3, Vector3],
    half_step_and_flat_landing_conditions: HalfStepAndFlatLandingConditionsOfPoint,
) -> tuple[
    NormalForceAndEarlyContactImpulseSums, LargestContactChangesOfStack, ContactPowerLossAndLostSpringEnergy,
    ContactPointState
]:  # fmt: skip
    """Return normal force, contact changes, losses and new state of a contact point from a step's solved equations.

    `relative_velocity_and_spin_changes` is the change of the relative velocity at the origin and of the relative
    angular velocity.
    """
    joint, position, previous = joint_constants, point_position, point_state_at_step_start
    change = relative_velocity_and_spin_changes
    half_step, lands_flat, new_landing, waits, joint_has_points = half_step_and_flat_landing_conditions
    w = position.joint_stiffness_share
    counts, had = w > 0.0, previous.joint_stiffness_share > 0.0
    joins = joint_has_points & (not had)
    rise = change[0].z + (change[1].x * position.y_in_lower_face_frame - change[1].y * position.x_in_lower_face_frame)
    # A point that waits takes up its penetration without force; the offset ends when the point opens.
    deep = -position.upper_base_height_above_lower_face - half_step * rise
    between, waits = waits, waits & (deep > 0.0)
    unloaded = previous.force_free_penetration_in_flat_landing
    offset = (deep if deep > unloaded else unloaded) if waits else unloaded
    offset = offset if deep > 0.0 else 0.0
    predicted_rate = point_opening_rate(relative_motion, position)
    before = -position.upper_base_height_above_lower_face - offset
    rate = predicted_rate + rise
    depth = before - half_step * rise
    inside, was = (depth > 0.0) & (not waits), previous.penetration > 0.0
    changed = before if before > depth else depth
    changed = (deep if unloaded == 0.0 else 0.0) if waits else -depth if was else changed
    heavy = w > MIN_POINT_STIFFNESS_SHARE_TO_SHORTEN_STEP
    spring = joint.normal_stiffness * depth if inside else 0.0
    pressure = spring - joint.normal_dashpot * rate
    pressure = pressure if counts & inside & (lands_flat | (pressure > 0.0)) else 0.0
    # A point that joins the patch has no last state: compare with the one that was assumed.
    pressed = lands_flat | (joint.normal_stiffness * before > joint.normal_dashpot * predicted_rate)
    assumed = (before > 0.0) & pressed & (not waits)
    changed = changed if had else 1.0 if joins & (assumed != (pressure != 0.0)) else 0.0
    fresh = inside & had & (not was) & counts
    more = depth * (2.0 * half_step / (depth - previous.penetration if fresh else 1.0)) - half_step if fresh else 0.0
    landing = (new_landing if fresh | (not had) else previous.remaining_flat_landing_time) - 2.0 * half_step
    landing = joint.flat_landing_duration_s if waits & (unloaded == 0.0) else landing
    n = w * pressure
    power = w * (spring - pressure) * rate
    over = depth * previous.penetration
    over = math.copysign(over if over < 0.0 else 0.0, depth - previous.penetration)
    both = (depth if inside else 0.0) * (previous.penetration if was else depth if joins else 0.0)
    let_go = (w * over if inside | was else 0.0) + both * (previous.joint_stiffness_share - w)
    let_go = 0.5 * joint.normal_stiffness * let_go if counts | had else 0.0
    findings = LargestContactChangesOfStack(
        positive_if_contact_opened_or_closed=changed if heavy else 0.0,
        has_wrong_slip_assumption=0.0,
        has_friction_opposite_to_assumption=0.0,
        has_sticking_loaded_joint=0.0,
        friction_sign_changed_in_step=0.0,
        some_point_carries_no_load=1.0 if heavy & (not (pressure > 0.0)) & (offset == 0.0) & (not between) else 0.0,
        largest_penetration=depth if counts else 0.0,
        has_loaded_joint=0.0,
    )
    return (
        NormalForceAndEarlyContactImpulseSums(
            n,
            n * position.x_in_lower_face_frame,
            n * position.y_in_lower_face_frame,
            more * n,
            more * (n * position.x_in_lower_face_frame),
            more * (n * position.y_in_lower_face_frame),
        ),
        findings,
        ContactPowerLossAndLostSpringEnergy(power, let_go + more * power),
        ContactPointState(
            penetration=depth if counts & (not waits) else 0.0,
            force_per_stiffness_share=pressure,
            remaining_flat_landing_time=landing if (inside | waits) & counts else 0.0,
            joint_stiffness_share=w,
            force_free_penetration_in_flat_landing=offset if counts else 0.0,
        ),
    )
