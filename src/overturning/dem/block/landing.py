"""Flat landing of a block: both corners touch from the air in one impact (docs/method.md, "A flat landing")."""

import math

from numba import njit

from overturning.dem.block.state import BlockConstants, BlockState
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import slides_flat, touches_soon


@njit(**INLINE)
def is_airborne(state: BlockState) -> bool:
    """True if no corner touched the base at the end of the last step."""
    return (state.left.depth <= 0.0) & (state.right.depth <= 0.0)


@njit(**INLINE)
def remaining_landing_time(block: BlockConstants, state: BlockState, time_step: float) -> float:
    """Return the remaining time of a flat landing after a step, s; a landing starts only from free flight."""
    return block.landing if is_airborne(state) else state.landing - time_step


@njit(**INLINE)
def lands_flat(block: BlockConstants, state: BlockState, left: tuple[float, float], right: tuple[float, float]) -> bool:
    """True if both corners land in one impact, from their penetrations (m) and upward velocities (m/s) after the step.

    In a plastic landing the impulse must not be tensile. The impulse of a dashpot is h times the penetration, which is
    positive as long as the corner is in the ground, so the dashpot may pull.
    """
    both = touches_soon(block.together, left[0], left[1]) & touches_soon(block.together, right[0], right[1])
    return ((state.landing > 0.0) | is_airborne(state)) & both


@njit(**INLINE)
def flat_landing_slip(block: BlockConstants, is_flat_landing: bool, vx: float, vz: float) -> tuple[bool, float, float]:
    """Return if a block that lands flat slides (`slides_flat`), ±μ, and the share of friction's moment that acts.

    The velocity of the centre decides. If μ ≤ B/H, the resultant impulse passes through the base, which
    therefore takes the whole moment of friction.
    """
    slides = is_flat_landing & slides_flat(block.friction, vx, vz)
    return slides, math.copysign(block.friction, vx), (block.tilting if slides else 1.0)
