"""Flat landing of a block: both corners touch from the air in one impact (docs/method.md, "A flat landing")."""

import math

from numba import njit

from overturning.dem.block.state import BlockConstants, BlockState
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.kernel.mechanics import base_end_touches_within_time, base_slides_in_flat_landing


@njit(**INLINE_OPTIONS)
def block_is_airborne(state: BlockState) -> bool:
    """True if no corner of a block touched the base at the end of the last step."""
    return (state.left.penetration <= 0.0) & (state.right.penetration <= 0.0)


@njit(**INLINE_OPTIONS)
def remaining_flat_landing_duration_after_step(
    block: BlockConstants, state: BlockState, step_duration_s: float
) -> float:
    """Return the remaining time (s) of a landing on both corners after a step; the full duration if airborne."""
    return (
        block.prescribed_flat_landing_duration
        if block_is_airborne(state)
        else state.remaining_flat_landing_time - step_duration_s
    )


@njit(**INLINE_OPTIONS)
def block_lands_flat(
    block: BlockConstants,
    state: BlockState,
    left_penetration_and_upward_velocity: tuple[float, float],
    right_penetration_and_upward_velocity: tuple[float, float],
) -> bool:
    """True if both lower corners of a block strike the base in one impact (a flat landing).

    Penetration (m) and upward velocity (m/s) of each corner are those at the time of the contact forces.

    In a flat landing a dashpot may pull on the block for a while. Its impulse so far is the dashpot constant times the
    penetration, which is positive as long as the corner is in the ground, so that the impulse never pulls.
    """
    left_depth, left_velocity = left_penetration_and_upward_velocity
    right_depth, right_velocity = right_penetration_and_upward_velocity
    time = block.max_time_between_touches_in_one_impact
    both = base_end_touches_within_time(time, left_depth, left_velocity) & base_end_touches_within_time(
        time, right_depth, right_velocity
    )
    return ((state.remaining_flat_landing_time > 0.0) | block_is_airborne(state)) & both


@njit(**INLINE_OPTIONS)
def flat_landing_slides_mu_and_moment_factor(
    block: BlockConstants, is_flat_landing: bool, centre_vx: float, centre_vz: float
) -> tuple[bool, float, float]:
    """Return whether a block landing on both corners slides, ±μ, and the factor on the moment of friction.

    The friction coefficient ±μ has the sign of `centre_vx`. If the block slides and μ ≤ B/H, the factor is 0:
    the resultant impulse then passes through the base, so that normal forces balance the whole moment of friction.
    Otherwise the factor is 1.
    """
    slides = is_flat_landing & base_slides_in_flat_landing(block.friction, centre_vx, centre_vz)
    return (
        slides,
        math.copysign(block.friction, centre_vx),
        (block.friction_moment_factor_if_sliding_in_flat_landing if slides else 1.0),
    )
