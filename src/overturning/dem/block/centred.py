"""The centred scheme for a block: trapezoidal rule, springs and dashpots at the end of the step (docs/method.md).

The step of one block has three parts, as in docs/method.md: `predict_block_at_step_end` and
`solve_velocity_corrections` are here, `corner_forces_new_state_and_contact_changes` and
`compute_block_state_after_step_if_accepted` in `overturning.dem.block.commit`. `overturning.dem.block.loops` has the
loops over the blocks.
"""

import math
from typing import Final

from numba import njit

from overturning.dem.block.landing import block_lands_flat, flat_landing_slides_mu_and_moment_factor
from overturning.dem.block.state import (
    AssumedCornerContact,
    BlockAccelerationsFromBaseMotion,
    BlockConstants,
    BlockExtrapolatedToStepEnd,
    BlockPredictedAtStepEnd,
    BlockState,
    BlockVelocityCorrectionAndCornerFriction,
    CornerEquationTerms,
    CornerPredictedAtStepEnd,
    CornerState,
    PredictedCornerForceAndAssumedSlidingFlag,
    SignedFrictionCoefficientOrZeroIfSticking,
    corner_x_and_depth_from_centre,
)
from overturning.dem.kernel.clock import BLOCK_STEP_CONTROL
from overturning.dem.kernel.ground import base_acceleration_in_this_or_next_sample
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.kernel.mechanics import rotate_cosine_and_sine_by_small_angle
from overturning.units import STANDARD_GRAVITY as GRAVITY

LONGEST_PREDICTED_FORCE_STEP_IN_SHORTEST_STEPS: Final = BLOCK_STEP_CONTROL.max_predicted_force_step_in_shortest_steps

MIN_RELATIVE_MOBILITY_OF_SLIDING_CORNER: Final = 0.25
"""Least effect of a normal force on a sliding corner, as a share of its effect on a free particle; below, it sticks."""


# 1. Predict -----------------------------------------------------------------------------------------------------------


@njit(**INLINE_OPTIONS)
def predict_corner_at_step_end(
    corner_sign: float,
    block: BlockConstants,
    previous_corner: CornerState,
    extrapolated_block: BlockExtrapolatedToStepEnd,
) -> CornerPredictedAtStepEnd:
    """Predict position, velocity and spring stretch of a corner of a block at the end of a step (centred scheme).

    The tangential spring of a corner that was not in contact before starts unstretched.
    """
    arm, drop = corner_x_and_depth_from_centre(corner_sign, block, extrapolated_block.cos, extrapolated_block.sin)
    stretch = previous_corner.tangential_stretch + ((extrapolated_block.centre_x + arm) - previous_corner.x_position)
    stretch = stretch if previous_corner.penetration > 0.0 else 0.0
    return CornerPredictedAtStepEnd(
        arm,
        drop,
        drop - extrapolated_block.centre_z,
        stretch,
        extrapolated_block.centre_vx - drop * extrapolated_block.angular_velocity,
        extrapolated_block.centre_vz - arm * extrapolated_block.angular_velocity,
    )


@njit(**INLINE_OPTIONS)
def predict_block_at_step_end(
    block: BlockConstants,
    state: BlockState,
    step_ticks: float,
    accelerations_from_base_motion: BlockAccelerationsFromBaseMotion,
    ticks_per_sample: float,
) -> BlockPredictedAtStepEnd:
    """Predict a block and its lower corners at the end of a step, relative to the base, with constant acceleration."""
    dt, tick = block.seconds_per_tick * step_ticks, state.ticks_since_sample_start + step_ticks
    half = 0.5 * dt
    kx, kz, kw = half * state.centre_ax, half * state.centre_az, half * state.angular_acceleration
    vx, vz, vw = state.centre_vx + kx, state.centre_vz + kz, state.angular_velocity + kw
    ex, ez, ew = vx + kx, vz + kz, vw + kw
    turn = dt * vw
    c, sn = rotate_cosine_and_sine_by_small_angle(state.cos, state.sin, turn)
    x, z = state.centre_x + dt * vx, state.centre_z + dt * vz
    past = tick - ticks_per_sample
    past = past if past > 0.0 else 0.0
    at = BlockExtrapolatedToStepEnd(x, z, c, sn, ex, ez, ew)
    left, right = (
        predict_corner_at_step_end(-1.0, block, state.left, at),
        predict_corner_at_step_end(1.0, block, state.right, at),
    )
    push, lift = (
        base_acceleration_in_this_or_next_sample(
            accelerations_from_base_motion.negative_of_base_acceleration_x, tick, past
        ),
        base_acceleration_in_this_or_next_sample(accelerations_from_base_motion.upward_base_acceleration, tick, past),
    )
    return BlockPredictedAtStepEnd(
        centre_x=x,
        centre_z=z,
        angle=state.angle + turn,
        cos=c,
        sin=sn,
        mid_step_centre_vx=vx,
        mid_step_centre_vz=vz,
        mid_step_angular_velocity=vw,
        step_end_centre_vx=ex,
        step_end_centre_vz=ez,
        step_end_angular_velocity=ew,
        negative_of_base_acceleration_x=push,
        upward_base_acceleration=lift,
        half_step_duration=half,
        left=left,
        right=right,
    )


# 2. Solve -------------------------------------------------------------------------------------------------------------


@njit(**INLINE_OPTIONS)
def predict_normal_force_per_mass_and_contact(
    block: BlockConstants,
    predicted_corner: CornerPredictedAtStepEnd,
    previous_corner: CornerState,
    uses_predicted_forces_for_contact_and_sliding: bool,
    is_flat_landing: bool,
) -> tuple[float, bool]:
    """Return the predicted normal force at a corner per block mass (m/s²), and True if the corner is in contact.

    A corner is in contact if it penetrates the base and the predicted force pushes, or pulls in a flat landing. In a
    step too long to resolve the contact vibration (`uses_predicted_forces_for_contact_and_sliding` is False), the
    prediction is inaccurate; a corner that was in contact after the last step then stays in contact.
    """
    n = (
        block.normal_stiffness_per_mass * predicted_corner.penetration
        - block.dashpot_constant_per_mass * predicted_corner.velocity_z
    )
    return n, ((is_flat_landing | (n > 0.0)) & (predicted_corner.penetration > 0.0)) | (
        (not uses_predicted_forces_for_contact_and_sliding) & (previous_corner.normal_force_per_mass != 0.0)
    )


@njit(**INLINE_OPTIONS)
def predict_corner_tangential_force_and_sliding(
    block: BlockConstants,
    predicted_corner: CornerPredictedAtStepEnd,
    normal_force_per_mass: float,
    assumed_contact: AssumedCornerContact,
) -> PredictedCornerForceAndAssumedSlidingFlag:
    """Return a corner's predicted tangential force, and whether the step's equations assume that the corner slides.

    In a step that resolves the contact vibration, sliding is predicted from the forces. A longer step assumes the
    sliding of the step before, and is repeated if this assumption proves wrong. In a flat landing both corners slide or
    stick together (`flat_landing_slides_mu_and_moment_factor`).

    The result also tells whether the corner can slide without Painlevé's paradox (possible from μ = 4/3): friction
    that turns the corner into the base, although the normal force pushes it out.
    """
    slid, fine = (
        assumed_contact.signed_mu_or_zero_if_sticking,
        assumed_contact.uses_predicted_forces_for_contact_and_sliding,
    )
    spring = block.tangential_stiffness_per_mass * predicted_corner.tangential_stretch
    f = spring + block.dashpot_constant_per_mass * predicted_corner.velocity_x
    excess = abs(f) - block.friction * normal_force_per_mass if fine else abs(slid)
    slid = math.copysign(block.friction, f) if fine else slid
    slides, slid = (
        (assumed_contact.slides_in_flat_landing, assumed_contact.flat_landing_signed_mu)
        if assumed_contact.lands_flat
        else (excess > 0.0, slid)
    )
    freedom = 1.0 + block.mass_over_moment_of_inertia * predicted_corner.x_from_centre * (
        predicted_corner.x_from_centre
        - slid * (assumed_contact.friction_moment_factor * predicted_corner.depth_below_centre)
    )
    return PredictedCornerForceAndAssumedSlidingFlag(f, slides, slid, freedom > MIN_RELATIVE_MOBILITY_OF_SLIDING_CORNER)


@njit(**INLINE_OPTIONS)
def signed_friction_coefficient_and_sliding(
    corner_friction: PredictedCornerForceAndAssumedSlidingFlag,
    other_corner_friction: PredictedCornerForceAndAssumedSlidingFlag,
    other_corner_in_contact: bool,
) -> tuple[float, bool]:
    """Return ±μ with the sign of a corner's friction force (0 if it cannot slide), and True if the corner slides.

    A corner cannot slide if friction would turn it into the base (Painlevé's paradox), unless the other corner is in
    contact and sticks: then the block can only rotate about the other corner, which lifts this one.
    """
    free = corner_friction.has_no_painleve_paradox_if_sliding | (
        other_corner_in_contact & (not other_corner_friction.slides)
    )
    return (corner_friction.signed_mu_if_sliding if free else 0.0), corner_friction.slides & free


@njit(**INLINE_OPTIONS)
def zero_velocity_normal_force_and_its_scaled_decrease(
    block: BlockConstants,
    predicted_corner: CornerPredictedAtStepEnd,
    half_step_duration: float,
    normal_force_per_mass: float,
    is_in_contact: bool,
) -> tuple[float, float]:
    """Return a corner's normal force per mass at zero velocity, m/s², and half a step × its decrease per velocity.

    Both values apply to the end of the step, and are 0 without contact. The velocity is the upward velocity of the
    corner, so that the second value is dimensionless.
    """
    normal = block.dashpot_constant_per_mass + half_step_duration * block.normal_stiffness_per_mass
    return (normal_force_per_mass + normal * predicted_corner.velocity_z if is_in_contact else 0.0), (
        half_step_duration * normal if is_in_contact else 0.0
    )


@njit(**INLINE_OPTIONS)
def corner_equation_terms(
    block: BlockConstants,
    predicted_corner: CornerPredictedAtStepEnd,
    half_step_duration: float,
    normal_force_per_mass: float,
    is_in_contact: bool,
    tangential_force_per_mass: float,
    is_sliding: bool,
    signed_mu_or_zero_if_sticking: float,
) -> CornerEquationTerms:
    """Return one corner's terms, per block mass, in the linear equations for a block's velocities at a step's end."""
    normal_force_per_mass, press = zero_velocity_normal_force_and_its_scaled_decrease(
        block, predicted_corner, half_step_duration, normal_force_per_mass, is_in_contact
    )
    tangential = block.dashpot_constant_per_mass + half_step_duration * block.tangential_stiffness_per_mass
    sticks = is_in_contact & (not is_sliding)
    tangential_force_per_mass = (
        tangential_force_per_mass - tangential * predicted_corner.velocity_x
        if sticks
        else signed_mu_or_zero_if_sticking * normal_force_per_mass
    )
    return CornerEquationTerms(
        normal_force_per_mass,
        tangential_force_per_mass,
        press,
        half_step_duration * tangential if sticks else 0.0,
        signed_mu_or_zero_if_sticking * press if is_sliding else 0.0,
    )


@njit(**INLINE_OPTIONS)
def solve_velocity_corrections(
    block: BlockConstants,
    state: BlockState,
    assumed_slip: SignedFrictionCoefficientOrZeroIfSticking,
    uses_predicted_forces_for_contact_and_sliding: bool,
    predicted_block: BlockPredictedAtStepEnd,
) -> BlockVelocityCorrectionAndCornerFriction:
    """Solve the linear equations of a step, with friction, for the corrections of a block's predicted velocities.

    The three equations are solved by elimination without pivoting, since the matrix is the identity plus a positive
    part. A sliding corner whose friction would make this part too small (Painlevé's paradox) is made to stick.
    """
    half, inertia = predicted_block.half_step_duration, block.mass_over_moment_of_inertia
    left, right = predicted_block.left, predicted_block.right
    arm_l, arm_r = left.x_from_centre, right.x_from_centre
    held = block_lands_flat(block, state, (left.penetration, left.velocity_z), (right.penetration, right.velocity_z))
    nl, on_l = predict_normal_force_per_mass_and_contact(
        block, left, state.left, uses_predicted_forces_for_contact_and_sliding, held
    )
    nr, on_r = predict_normal_force_per_mass_and_contact(
        block, right, state.right, uses_predicted_forces_for_contact_and_sliding, held
    )
    # A corner in the air has no force, so the last step does not tell whether it slid.
    drifts, drift, tilting = flat_landing_slides_mu_and_moment_factor(
        block, held, predicted_block.step_end_centre_vx, predicted_block.step_end_centre_vz
    )
    drop_l, drop_r = left.depth_below_centre, right.depth_below_centre
    lever_l, lever_r = tilting * drop_l, tilting * drop_r
    mu_l, mu_r = assumed_slip
    fine_l, fine_r = (
        uses_predicted_forces_for_contact_and_sliding | (state.left.normal_force_per_mass == 0.0),
        uses_predicted_forces_for_contact_and_sliding | (state.right.normal_force_per_mass == 0.0),
    )
    guess_l = predict_corner_tangential_force_and_sliding(
        block, left, nl, AssumedCornerContact(mu_l, fine_l, held, drifts, drift, tilting)
    )
    guess_r = predict_corner_tangential_force_and_sliding(
        block, right, nr, AssumedCornerContact(mu_r, fine_r, held, drifts, drift, tilting)
    )
    slid_l, slides_l = signed_friction_coefficient_and_sliding(guess_l, guess_r, on_r)
    slid_r, slides_r = signed_friction_coefficient_and_sliding(guess_r, guess_l, on_l)
    nl, fl, press_l, stick_l, slide_l = corner_equation_terms(
        block, left, half, nl, on_l, guess_l.tangential_force_per_mass, slides_l, slid_l
    )
    nr, fr, press_r, stick_r, slide_r = corner_equation_terms(
        block, right, half, nr, on_r, guess_r.tangential_force_per_mass, slides_r, slid_r
    )
    hx = predicted_block.mid_step_centre_vx + half * (predicted_block.negative_of_base_acceleration_x - (fl + fr))
    hz = predicted_block.mid_step_centre_vz + half * ((nl + nr) - (GRAVITY + predicted_block.upward_base_acceleration))
    hw = predicted_block.mid_step_angular_velocity + half * (
        inertia * ((lever_l * fl - arm_l * nl) + (lever_r * fr - arm_r * nr))
    )
    wl, wr = press_l * arm_l, press_r * arm_r
    el, er = slide_l * lever_l - wl, slide_r * lever_r - wr
    gl, gr = stick_l * lever_l, stick_r * lever_r
    sway = stick_l * drop_l + stick_r * drop_r
    a11, a12, a13 = (
        1.0 + (stick_l + stick_r),
        -(slide_l + slide_r),
        (slide_r * arm_r + slide_l * arm_l) - sway,
    )
    a22, a23 = 1.0 + (press_l + press_r), -(wl + wr)
    a31, a32 = inertia * (gl + gr), inertia * (el + er)
    a33 = 1.0 + inertia * ((gl * drop_l - el * arm_l) + (gr * drop_r - er * arm_r))
    both, first, second = a11 * a22, a31 * a22, a32 * a11 + a31 * a12
    last = (a33 * both + first * a13) - second * a23
    inverse = 1.0 / (both * last)
    ew = ((hw * both + first * hx) - second * hz) * (inverse * both)
    inverse = inverse * last
    ez = (hz - a23 * ew) * (inverse * a11)
    ex = ((hx - a12 * ez) - a13 * ew) * (inverse * a22)
    return BlockVelocityCorrectionAndCornerFriction(
        ex - predicted_block.step_end_centre_vx, ez - predicted_block.step_end_centre_vz,
        ew - predicted_block.step_end_angular_velocity, slid_l, slid_r,
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def solve_frictionless_step_velocity_corrections(
    block: BlockConstants,
    state: BlockState,
    assumed_slip: SignedFrictionCoefficientOrZeroIfSticking,  # noqa: ARG001, as `solve_velocity_corrections`
    uses_predicted_forces_for_contact_and_sliding: bool,
    predicted_block: BlockPredictedAtStepEnd,
) -> BlockVelocityCorrectionAndCornerFriction:
    """Solve the linear equations of a frictionless step for the corrections of a block's predicted velocities."""
    half, inertia = predicted_block.half_step_duration, block.mass_over_moment_of_inertia
    left, right = predicted_block.left, predicted_block.right
    arm_l, arm_r = left.x_from_centre, right.x_from_centre
    held = block_lands_flat(block, state, (left.penetration, left.velocity_z), (right.penetration, right.velocity_z))
    nl, on_l = predict_normal_force_per_mass_and_contact(
        block, left, state.left, uses_predicted_forces_for_contact_and_sliding, held
    )
    nr, on_r = predict_normal_force_per_mass_and_contact(
        block, right, state.right, uses_predicted_forces_for_contact_and_sliding, held
    )
    nl, press_l = zero_velocity_normal_force_and_its_scaled_decrease(block, left, half, nl, on_l)
    nr, press_r = zero_velocity_normal_force_and_its_scaled_decrease(block, right, half, nr, on_r)
    ex = predicted_block.mid_step_centre_vx + half * predicted_block.negative_of_base_acceleration_x
    hz = predicted_block.mid_step_centre_vz + half * ((nl + nr) - (GRAVITY + predicted_block.upward_base_acceleration))
    hw = predicted_block.mid_step_angular_velocity - half * (inertia * (arm_l * nl + arm_r * nr))
    wl, wr = press_l * arm_l, press_r * arm_r
    a22, a23 = 1.0 + (press_l + press_r), -(wl + wr)
    a32, a33 = inertia * a23, 1.0 + inertia * (wl * arm_l + wr * arm_r)
    last = a33 * a22 - a32 * a23
    inverse = 1.0 / (a22 * last)
    ew = (hw * a22 - a32 * hz) * (inverse * a22)
    ez = (hz - a23 * ew) * (inverse * last)
    return BlockVelocityCorrectionAndCornerFriction(
        ex - predicted_block.step_end_centre_vx,
        ez - predicted_block.step_end_centre_vz,
        ew - predicted_block.step_end_angular_velocity,
        0.0,
        0.0,
    )
