"""Cundall's scheme for a block: central differences, spring at the whole step, dashpot half a step earlier."""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.block.landing import (
    block_lands_flat,
    flat_landing_slides_mu_and_moment_factor,
    remaining_flat_landing_duration_after_step,
)
from overturning.dem.block.state import (
    TICKS_PER_WHOLE_STEP,
    BlockAccelerationsFromBaseMotion,
    BlockConstants,
    BlockEnergyAccount,
    BlockPeaksAndLastUprightTick,
    BlockState,
    CornerState,
    corner_x_and_depth_from_centre,
    displacement_of_block_lower_side_middle,
)
from overturning.dem.kernel.ground import base_acceleration_at_tick
from overturning.dem.kernel.lanes import INLINE_OPTIONS, select
from overturning.dem.kernel.mechanics import clamp_magnitude, rotate_cosine_and_sine_by_small_angle, updated_maximum
from overturning.units import STANDARD_GRAVITY as GRAVITY

TICKS_PER_STEP: Final = TICKS_PER_WHOLE_STEP


class CornerContactForceAndNewState(NamedTuple):
    """Contact force of the base on a corner of a block, per block mass, and the new state of the corner."""

    normal_force_per_mass: float
    """Normal force, m/s²."""
    tangential_force_per_mass: float
    """Tangential force along s, m/s²."""
    x_from_centre: float
    """Position of the corner from the centre, along s, m."""
    friction_lever_arm: float
    """Lever of the tangential force: depth of the corner below the centre, less in a flat landing, m."""
    new_corner: CornerState
    """State of the corner for the next step."""
    released_normal_energy_over_half_stiffness: float
    """Energy released by the normal spring, over half its stiffness, m²."""
    released_tangential_energy_over_half_stiffness: float
    """Energy released by the tangential spring, over half its stiffness, m²."""
    non_spring_normal_force_per_mass: float
    """Normal force less that of the spring: the force of the dashpot, m/s²."""
    non_spring_tangential_force_per_mass: float
    """Tangential force less that of the spring: of the dashpot, or of friction beyond the spring, m/s²."""
    extra_spring_moment_in_flat_landing_per_mass: float
    """Moment by which the lever arm of the spring at the corner exceeds `friction_lever_arm`, per mass, m²/s²;
    0 except in a flat landing."""


@njit(**INLINE_OPTIONS)
def corner_contact_force(
    corner_sign: float,
    block: BlockConstants,
    state: BlockState,
    previous_corner: CornerState,
    dashpot_constant_per_mass_over_time_step: float,
    flat_slides_mu_and_friction_moment_factor: tuple[bool, bool, float, float],
) -> CornerContactForceAndNewState:
    """Compute the contact force of the base on a corner of a block, per block mass, in a step of Cundall's scheme.

    `dashpot_constant_per_mass_over_time_step` (1/s²) multiplies the displacements of the last step.
    `flat_slides_mu_and_friction_moment_factor` holds whether both corners land in one impact, and the results of
    `flat_landing_slides_mu_and_moment_factor`.
    """
    held, drifts, drift, tilting = flat_slides_mu_and_friction_moment_factor
    arm, drop = corner_x_and_depth_from_centre(corner_sign, block, state.cos, state.sin)
    place, depth = state.centre_x + arm, drop - state.centre_z
    slip, sinking = place - previous_corner.x_position, depth - previous_corner.penetration
    inside, was = depth > 0.0, previous_corner.penetration > 0.0
    # Spring and dashpot while the corner is in contact; no tension except in a flat landing.
    n = block.normal_stiffness_per_mass * depth + dashpot_constant_per_mass_over_time_step * sinking
    n = n if inside & (held | (n > 0.0)) else 0.0
    # A new contact starts with an unstretched spring; slip shortens the spring to the force that friction can hold.
    stretch = previous_corner.tangential_stretch + slip if was else 0.0
    most = block.friction * n
    whole = -(block.tangential_stiffness_per_mass * stretch) - dashpot_constant_per_mass_over_time_step * slip
    # A corner that lands flat may stick beyond the friction limit, but without contact it has no friction.
    slips = drifts if held & inside else abs(whole) > most
    f = -drift * n if drifts else (clamp_magnitude(whole, most) if slips else whole)
    remaining = (
        clamp_magnitude(stretch, (most if most > 0.0 else 0.0) * block.mass_over_tangential_stiffness)
        if slips
        else stretch
    )
    let_go = previous_corner.penetration if was & (not inside) else 0.0
    return CornerContactForceAndNewState(
        normal_force_per_mass=n, tangential_force_per_mass=f, x_from_centre=arm, friction_lever_arm=tilting * drop,
        new_corner=CornerState(remaining, place, depth, 0.0),
        released_normal_energy_over_half_stiffness=let_go * let_go,
        released_tangential_energy_over_half_stiffness=(
            (previous_corner.tangential_stretch + remaining) * (stretch - remaining)
        ),
        non_spring_normal_force_per_mass=n - block.normal_stiffness_per_mass * (depth if inside else 0.0),
        non_spring_tangential_force_per_mass=f + block.tangential_stiffness_per_mass * remaining,
        extra_spring_moment_in_flat_landing_per_mass=(
            block.tangential_stiffness_per_mass * remaining * (drop - tilting * drop)
        ),
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def corner_dashpot_and_friction_power_per_mass(
    corner_force: CornerContactForceAndNewState, centre_vx: float, centre_vz: float, angular_velocity: float
) -> float:
    """Return the power of a corner's dashpots and friction on the block, per block mass, m²/s³; negative: loss."""
    normal, tangential = (
        corner_force.non_spring_normal_force_per_mass,
        corner_force.non_spring_tangential_force_per_mass,
    )
    power = normal * (centre_vz - corner_force.x_from_centre * angular_velocity) + tangential * (
        centre_vx - corner_force.friction_lever_arm * angular_velocity
    )
    return power - corner_force.extra_spring_moment_in_flat_landing_per_mass * angular_velocity


@njit(**INLINE_OPTIONS)
def advance_block_one_step(
    block: BlockConstants,
    state: BlockState,
    peaks: BlockPeaksAndLastUprightTick,
    energy_account: BlockEnergyAccount,
    accelerations_from_base_motion: BlockAccelerationsFromBaseMotion,
    with_vertical_base_motion: bool,
) -> tuple[BlockState, BlockPeaksAndLastUprightTick, BlockEnergyAccount]:
    """Advance one block by one step of Cundall's scheme; return its state, peak values, and work and lost energy."""
    dt = block.seconds_per_tick * TICKS_PER_STEP
    push, lift = (
        base_acceleration_at_tick(
            accelerations_from_base_motion.negative_of_base_acceleration_x, state.ticks_since_sample_start
        ),
        base_acceleration_at_tick(
            accelerations_from_base_motion.upward_base_acceleration, state.ticks_since_sample_start
        ),
    )
    rate = block.dashpot_constant_per_mass / dt
    (arm_left, drop_left), (arm_right, drop_right) = (
        corner_x_and_depth_from_centre(-1.0, block, state.cos, state.sin),
        corner_x_and_depth_from_centre(1.0, block, state.cos, state.sin),
    )
    held = block_lands_flat(
        block,
        state,
        (drop_left - state.centre_z, state.centre_vz - arm_left * state.angular_velocity),
        (drop_right - state.centre_z, state.centre_vz - arm_right * state.angular_velocity),
    )
    flat = (held, *flat_landing_slides_mu_and_moment_factor(block, held, state.centre_vx, state.centre_vz))
    left, right = (
        corner_contact_force(-1.0, block, state, state.left, rate, flat),
        corner_contact_force(1.0, block, state, state.right, rate, flat),
    )
    nl, nr = left.normal_force_per_mass, right.normal_force_per_mass
    fl, fr = left.tangential_force_per_mass, right.tangential_force_per_mass
    # Accelerations in the frame of the base; left and right corner as one pair.
    ax, az = (fl + fr) + push, (nl + nr) - (GRAVITY + lift if with_vertical_base_motion else GRAVITY)
    aw = block.mass_over_moment_of_inertia * (
        (-left.friction_lever_arm * fl - left.x_from_centre * nl)
        + (-right.friction_lever_arm * fr - right.x_from_centre * nr)
    )
    # The energy account uses the velocities at the whole step.
    half = 0.5 * dt
    cx, cz, cw = state.centre_vx + half * ax, state.centre_vz + half * az, state.angular_velocity + half * aw
    power = push * cx - lift * cz if with_vertical_base_motion else push * cx
    let_go = 0.5 * (
        block.normal_stiffness_per_mass
        * (left.released_normal_energy_over_half_stiffness + right.released_normal_energy_over_half_stiffness)
        + block.tangential_stiffness_per_mass
        * (left.released_tangential_energy_over_half_stiffness + right.released_tangential_energy_over_half_stiffness)
    )
    lost = energy_account.lost_energy_per_mass + (
        let_go
        - dt
        * (
            corner_dashpot_and_friction_power_per_mass(left, cx, cz, cw)
            + corner_dashpot_and_friction_power_per_mass(right, cx, cz, cw)
        )
    )
    # Velocities half a step later, position one step later.
    vx, vz, vw = state.centre_vx + dt * ax, state.centre_vz + dt * az, state.angular_velocity + dt * aw
    turn, tick = dt * vw, state.ticks_since_sample_start + TICKS_PER_STEP
    c, sn = rotate_cosine_and_sine_by_small_angle(state.cos, state.sin, turn)
    x, z, angle = state.centre_x + dt * vx, state.centre_z + dt * vz, state.angle + turn
    peaks = BlockPeaksAndLastUprightTick(
        updated_maximum(peaks.max_abs_angle, abs(angle)),
        updated_maximum(peaks.max_abs_base_slip, abs(displacement_of_block_lower_side_middle(block, x, sn))),
        updated_maximum(
            peaks.max_corner_penetration,
            left.new_corner.penetration
            if left.new_corner.penetration > right.new_corner.penetration
            else right.new_corner.penetration,
        ),
        select(abs(angle) < block.critical_angle, tick, peaks.last_tick_in_sample_below_critical_angle),
    )
    moved = BlockState(
        centre_x=x, centre_z=z, angle=angle, cos=c, sin=sn, centre_vx=vx, centre_vz=vz, angular_velocity=vw,
        centre_ax=ax, centre_az=az, angular_acceleration=aw,
        left=left.new_corner, right=right.new_corner, ticks_since_sample_start=tick,
        remaining_flat_landing_time=remaining_flat_landing_duration_after_step(block, state, dt),
    )  # fmt: skip
    return moved, peaks, BlockEnergyAccount(energy_account.base_motion_work_per_mass + dt * power, lost, 0.0, 0.0)
