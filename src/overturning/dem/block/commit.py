"""Third part of a step of the centred scheme for a block: corner forces within their limits, and the new state."""

import math

from numba import njit

from overturning.dem.block.landing import remaining_flat_landing_duration_after_step
from overturning.dem.block.state import (
    MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS,
    AssumedCornerContact,
    BlockAfterAttemptedStep,
    BlockConstants,
    BlockEnergyAccount,
    BlockPeaksAndLastUprightTick,
    BlockPredictedAtStepEnd,
    BlockState,
    BlockVelocityCorrectionAndCornerFriction,
    CornerPredictedAtStepEnd,
    CornerState,
    SignedFrictionCoefficientOrZeroIfSticking,
    SolvedCornerContact,
    SolvedCornerContactPair,
    displacement_of_block_lower_side_middle,
)
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, StepContactChanges
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.kernel.mechanics import clamp_magnitude, updated_maximum
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INLINE_OPTIONS)
def corner_forces_new_state_and_contact_changes(
    block: BlockConstants,
    predicted_block: BlockPredictedAtStepEnd,
    predicted_corner: CornerPredictedAtStepEnd,
    previous_corner: CornerState,
    assumed_contact: AssumedCornerContact,
    velocity_correction: BlockVelocityCorrectionAndCornerFriction,
    with_friction: bool,
) -> SolvedCornerContact:
    """Return a corner's contact force per block mass at a step's end, its new state, and its contact changes.

    The solution of the step's equations corrects velocities, and positions by half a step times these corrections.
    Friction limits the tangential force. Contact also counts as changed if a corner in the air was predicted to
    penetrate the base, but the corrections push it out. A corner in the air is marked as sliding, which has no effect.
    """
    du, dw = (
        velocity_correction.centre_vx - predicted_corner.depth_below_centre * velocity_correction.angular_velocity,
        velocity_correction.centre_vz - predicted_corner.x_from_centre * velocity_correction.angular_velocity,
    )
    ux, uz = predicted_corner.velocity_x + du, predicted_corner.velocity_z + dw
    half = predicted_block.half_step_duration
    depth, stretch, place = (
        predicted_corner.penetration - half * dw,
        predicted_corner.tangential_stretch + half * du,
        (predicted_block.centre_x + predicted_corner.x_from_centre) + half * du,
    )
    inside, was = depth > 0.0, previous_corner.penetration > 0.0
    changed = predicted_corner.penetration if predicted_corner.penetration > depth else depth
    changed = -depth if was else changed
    # No tension except in a flat landing.
    spring = block.normal_stiffness_per_mass * depth if inside else 0.0
    n = spring - block.dashpot_constant_per_mass * uz
    n = n if assumed_contact.lands_flat | (n > 0.0) else 0.0
    n = n if inside else 0.0
    # Friction; the spring of a slipping corner is shortened to the force that friction can hold.
    most = block.friction * n
    f = block.tangential_stiffness_per_mass * stretch + block.dashpot_constant_per_mass * ux
    sign, slips = math.copysign(block.friction, f), abs(f) > most
    # A corner that lands flat may stick or slide beyond the friction limit, but without contact it has no friction.
    lands = assumed_contact.lands_flat & inside
    sign, slips = (
        (assumed_contact.flat_landing_signed_mu, assumed_contact.slides_in_flat_landing) if lands else (sign, slips)
    )
    found, assumed = (
        sign if slips else 0.0,
        0.0
        if assumed_contact.uses_predicted_forces_for_contact_and_sliding
        else assumed_contact.signed_mu_or_zero_if_sticking,
    )
    f = sign * n if slips else f
    remaining = (
        clamp_magnitude(stretch, (most if most > 0.0 else 0.0) * block.mass_over_tangential_stiffness)
        if slips
        else stretch
    )
    lever = assumed_contact.friction_moment_factor * predicted_corner.depth_below_centre
    turning = (predicted_corner.depth_below_centre - lever) * (
        predicted_block.step_end_angular_velocity + velocity_correction.angular_velocity
    )
    # Friction acts at the shortened lever arm; the spring is stretched at the corner itself.
    damping, sliding = (spring - n) * uz, (f - block.tangential_stiffness_per_mass * remaining) * ux + f * turning
    sinking = depth - previous_corner.penetration
    cut = depth * previous_corner.penetration
    cut = math.copysign(cut if cut < 0.0 else 0.0, sinking)
    fresh, loaded = inside & (not was), most > 0.0
    moment, let_go = (
        lever * f - predicted_corner.x_from_centre * n,
        (previous_corner.tangential_stretch + remaining) * (stretch - remaining),
    )
    return SolvedCornerContact(
        new_corner=CornerState(remaining, place, depth, n),
        tangential_force_per_mass=f,
        moment_per_mass=moment if with_friction else -(predicted_corner.x_from_centre * n),
        dissipated_power_per_mass=damping + sliding if with_friction else damping,
        released_tangential_energy_over_half_stiffness=let_go if with_friction else 0.0,
        released_normal_energy_over_half_stiffness=cut,
        has_closed_in_step=fresh,
        penetration_change_if_newly_closed_else_one=sinking if fresh else 1.0,
        positive_if_contact_changed=changed,
        vertical_travel_if_contact_changed_else_zero=abs(sinking) if changed > 0.0 else 0.0,
        signed_mu_or_zero_if_sticking=found,
        has_wrong_slip_assumption=(found != assumed) & loaded,
        has_velocity_against_assumed_slip=(assumed * ux < 0.0) & loaded,
        friction_sign_changed_in_step=(found * previous_corner.tangential_stretch < 0.0) & loaded,
    )


@njit(**INLINE_OPTIONS)
def contact_changes_in_block_step(
    block: BlockConstants,
    case_step_control: CaseStepLengthsAndDoublingCounts,
    step_ticks: float,
    uses_predicted_forces_for_contact_and_sliding: bool,
    solved_corners: SolvedCornerContactPair,
    with_friction: bool,
) -> StepContactChanges:
    """Return the changes of contact and sliding in an attempted step, which decide whether the step is accepted."""
    left, right = solved_corners.left, solved_corners.right
    change_l, change_r = left.positive_if_contact_changed, right.positive_if_contact_changed
    travel_l, travel_r = (
        left.vertical_travel_if_contact_changed_else_zero, right.vertical_travel_if_contact_changed_else_zero,
    )  # fmt: skip
    changed = (change_l if change_l > change_r else change_r) > 0.0
    far = travel_l if travel_l > travel_r else travel_r
    gentle = (far <= block.max_contact_change_travel_without_halving_step) & (
        step_ticks <= MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS * case_step_control.min_allowed_step_ticks
    )
    stands = (left.new_corner.normal_force_per_mass > 0.0) & (right.new_corner.normal_force_per_mass > 0.0)
    if not with_friction:
        return StepContactChanges(
            contact_opened_or_closed=changed,
            motion_requires_shorter_step=False,
            may_accept_despite_contact_change=gentle,
            has_wrong_slip_assumption=False,
            has_velocity_against_assumed_slip=False,
            friction_sign_changed_in_step=False,
            slides_on_all_points=False,
            all_contacts_are_closed=stands,
        )
    wrong, back = (
        (left.has_wrong_slip_assumption | right.has_wrong_slip_assumption)
        & (not uses_predicted_forces_for_contact_and_sliding),
        (left.friction_sign_changed_in_step | right.friction_sign_changed_in_step)
        & (not uses_predicted_forces_for_contact_and_sliding),
    )
    loaded = left.new_corner.normal_force_per_mass + right.new_corner.normal_force_per_mass > 0.0
    slides = (left.signed_mu_or_zero_if_sticking != 0.0) & (right.signed_mu_or_zero_if_sticking != 0.0) & loaded
    return StepContactChanges(
        contact_opened_or_closed=changed,
        motion_requires_shorter_step=False,
        may_accept_despite_contact_change=gentle,
        has_wrong_slip_assumption=wrong,
        has_velocity_against_assumed_slip=left.has_velocity_against_assumed_slip
        | right.has_velocity_against_assumed_slip,
        friction_sign_changed_in_step=back,
        slides_on_all_points=slides,
        all_contacts_are_closed=stands,
    )


@njit(**INLINE_OPTIONS)
def assumed_signed_friction_for_next_attempt(
    slip_assumed_in_solved_step: SignedFrictionCoefficientOrZeroIfSticking,
    uses_predicted_forces_for_contact_and_sliding: bool,
    solved_corners: SolvedCornerContactPair,
    next_attempt_repeats_step: bool,
    keeps_assumption_at_both_corners: bool,
) -> SignedFrictionCoefficientOrZeroIfSticking:
    """Return, for both corners, the signed friction ±μ (0: sticking) that the next attempted step assumes.

    The friction of the solved step is assumed. A corner keeps the friction that the solved step had assumed if
    `keeps_assumption_at_both_corners`, or if that was correct and the step is repeated.
    """
    of_left, of_right = (
        (
            0.0
            if uses_predicted_forces_for_contact_and_sliding
            else slip_assumed_in_solved_step.left_signed_mu_or_zero_if_sticking
        ),
        (
            0.0
            if uses_predicted_forces_for_contact_and_sliding
            else slip_assumed_in_solved_step.right_signed_mu_or_zero_if_sticking
        ),
    )
    left, right = solved_corners.left, solved_corners.right
    keeps_left, keeps_right = (
        keeps_assumption_at_both_corners | (next_attempt_repeats_step & (not left.has_wrong_slip_assumption)),
        keeps_assumption_at_both_corners | (next_attempt_repeats_step & (not right.has_wrong_slip_assumption)),
    )
    return SignedFrictionCoefficientOrZeroIfSticking(
        of_left if keeps_left else left.signed_mu_or_zero_if_sticking,
        of_right if keeps_right else right.signed_mu_or_zero_if_sticking,
    )


@njit(**INLINE_OPTIONS)
def time_since_contact_closed_minus_half_step_or_zero(
    half_step_duration: float, corner: SolvedCornerContact, other_corner: SolvedCornerContact
) -> float:
    """Return the time (s) from contact closure at a corner to the end of the step, less half a step; 0 without closure.

    A corner that was in contact before, or is not in contact now, has no closure in this step.

    A contact that closes within a step acts only in the rest of the step, while the equations assume that it acts in
    half of the step. One division gives the times of both corners.
    """
    own, other = (
        corner.penetration_change_if_newly_closed_else_one,
        other_corner.penetration_change_if_newly_closed_else_one,
    )
    inverse = 2.0 * half_step_duration / (own * other)
    time = corner.new_corner.penetration * (inverse * other) - half_step_duration
    return time if corner.has_closed_in_step else 0.0


@njit(**INLINE_OPTIONS)
def compute_block_state_after_step_if_accepted(
    block: BlockConstants,
    block_at_step_start: BlockAfterAttemptedStep,
    predicted_block: BlockPredictedAtStepEnd,
    velocity_correction: BlockVelocityCorrectionAndCornerFriction,
    solved_corners: SolvedCornerContactPair,
    step_ticks: float,
    with_vertical_base_motion: bool,
    with_friction: bool,
) -> BlockAfterAttemptedStep:
    """Compute a block's state, peaks, and sums of work and lost energy after a step; valid if the step is accepted."""
    (s, peaks, account), (left, right) = block_at_step_start, solved_corners
    half, turn, tick = (
        predicted_block.half_step_duration,
        predicted_block.half_step_duration * velocity_correction.angular_velocity,
        s.ticks_since_sample_start + step_ticks,
    )
    x, z, angle = (
        predicted_block.centre_x + half * velocity_correction.centre_vx,
        predicted_block.centre_z + half * velocity_correction.centre_vz,
        predicted_block.angle + turn,
    )
    c, sn = predicted_block.cos - predicted_block.sin * turn, predicted_block.sin + predicted_block.cos * turn
    nl, nr = left.new_corner.normal_force_per_mass, right.new_corner.normal_force_per_mass
    deep_l, deep_r = left.new_corner.penetration, right.new_corner.penetration
    ax, az = (
        predicted_block.negative_of_base_acceleration_x
        - (left.tangential_force_per_mass + right.tangential_force_per_mass)
        if with_friction
        else predicted_block.negative_of_base_acceleration_x,
        (nl + nr) - (GRAVITY + predicted_block.upward_base_acceleration),
    )
    aw = block.mass_over_moment_of_inertia * (left.moment_per_mass + right.moment_per_mass)
    vx, vz, vw = (
        predicted_block.mid_step_centre_vx + half * ax,
        predicted_block.mid_step_centre_vz + half * az,
        predicted_block.mid_step_angular_velocity + half * aw,
    )
    pl, pr = (
        time_since_contact_closed_minus_half_step_or_zero(half, left, right),
        time_since_contact_closed_minus_half_step_or_zero(half, right, left),
    )
    vx = vx - (pl * left.tangential_force_per_mass + pr * right.tangential_force_per_mass) if with_friction else vx
    vz = vz + (pl * nl + pr * nr)
    vw = vw + block.mass_over_moment_of_inertia * (pl * left.moment_per_mass + pr * right.moment_per_mass)
    # Work of the base motion; loss in dashpots, friction, and contacts that open or close within the step.
    power, loss = (
        predicted_block.negative_of_base_acceleration_x * vx - predicted_block.upward_base_acceleration * vz
        if with_vertical_base_motion
        else predicted_block.negative_of_base_acceleration_x * vx,
        left.dissipated_power_per_mass + right.dissipated_power_per_mass,
    )
    springs = block.tangential_stiffness_per_mass * (
        left.released_tangential_energy_over_half_stiffness + right.released_tangential_energy_over_half_stiffness
    ) + block.normal_stiffness_per_mass * (
        left.released_normal_energy_over_half_stiffness + right.released_normal_energy_over_half_stiffness
    )
    early_loss = pl * left.dissipated_power_per_mass + pr * right.dissipated_power_per_mass
    lost = (half * (account.dissipated_power_per_mass + loss) + early_loss) + 0.5 * springs
    peaks = BlockPeaksAndLastUprightTick(
        updated_maximum(peaks.max_abs_angle, abs(angle)),
        updated_maximum(peaks.max_abs_base_slip, abs(displacement_of_block_lower_side_middle(block, x, sn))),
        updated_maximum(peaks.max_corner_penetration, deep_l if deep_l > deep_r else deep_r),
        tick if abs(angle) < block.critical_angle else peaks.last_tick_in_sample_below_critical_angle,
    )
    work = account.base_motion_work_per_mass + half * (account.base_motion_power_per_mass + power)
    account = BlockEnergyAccount(work, account.lost_energy_per_mass + lost, power, loss)
    state = BlockState(
        centre_x=x,
        centre_z=z,
        angle=angle,
        cos=c,
        sin=sn,
        centre_vx=vx,
        centre_vz=vz,
        angular_velocity=vw,
        centre_ax=ax,
        centre_az=az,
        angular_acceleration=aw,
        left=left.new_corner,
        right=right.new_corner,
        ticks_since_sample_start=tick,
        remaining_flat_landing_time=remaining_flat_landing_duration_after_step(block, s, 2.0 * half),
    )
    return BlockAfterAttemptedStep(state, peaks, account)
