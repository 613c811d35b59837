"""Start of a case of a block: its constants and the state at the first sample."""

from typing import Any

import numpy as np
from numba import njit

from overturning.dem.block.access import (
    REST_ACCELERATION_LIMIT_ROW_OFFSET,
    STATE_ROW_COUNT,
    store_block_constants,
    store_block_state,
    store_case_progress,
    store_next_step_to_attempt,
    store_peaks_and_last_upright_tick,
    store_signed_friction_or_zero,
    store_step_lengths_and_doubling_counts,
)
from overturning.dem.block.ending import (
    block_mechanical_energy_per_mass,
)
from overturning.dem.block.state import (
    PARALLEL_CASE_COUNT,
    BlockConstants,
    BlockPeaksAndLastUprightTick,
    BlockState,
    CornerState,
    SignedFrictionCoefficientOrZeroIfSticking,
    corner_x_and_depth_from_centre,
)
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import (
    CaseProgress,
)
from overturning.dem.kernel.lanes import (
    INTERNAL_COMPILE_OPTIONS,
)
from overturning.dem.kernel.mechanics import (
    FLAT_LANDING_DURATION_IN_DECAY_TIMES,
    max_time_between_touches_in_one_impact,
)
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_block_constants_and_initial_state(
    state: Any, lane: int, case_table_row: Any, sampling_interval: float, ticks_per_sample: float
) -> None:
    """Write the constants, step control and initial state of a case's block to column `lane` of the state array."""
    for row in range(STATE_ROW_COUNT):
        state[row * PARALLEL_CASE_COUNT + lane] = 0.0
    b, h = 0.5 * case_table_row.width, 0.5 * case_table_row.height
    c, s = case_table_row.initial_tilt_cosine, case_table_row.initial_tilt_sine
    k, ks = case_table_row.normal_stiffness_per_mass, case_table_row.tangential_stiffness_per_mass
    dashpot, inertia = case_table_row.dashpot_constant_per_mass, 3.0 / (b * b + h * h)
    block = BlockConstants(
        half_width=b, half_height=h, mass_over_moment_of_inertia=inertia,
        normal_stiffness_per_mass=k, tangential_stiffness_per_mass=ks,
        mass_over_tangential_stiffness=1.0 / ks if ks > 0.0 else 0.0, dashpot_constant_per_mass=dashpot,
        friction=case_table_row.friction,
        critical_angle=case_table_row.critical_angle, seconds_per_tick=sampling_interval / ticks_per_sample,
        max_contact_change_travel_without_halving_step=case_table_row.max_contact_change_travel_without_halving_step,
        prescribed_flat_landing_duration=FLAT_LANDING_DURATION_IN_DECAY_TIMES * dashpot / k,
        max_time_between_touches_in_one_impact=max_time_between_touches_in_one_impact(k, dashpot),
        friction_moment_factor_if_sliding_in_flat_landing=0.0 if case_table_row.friction * h <= b else 1.0,
    )  # fmt: skip
    tilted = s != 0.0
    z = (b * abs(s) + h * c) - (GRAVITY / k if tilted else 0.5 * GRAVITY / k)
    x = b * ((1.0 - c) if s > 0.0 else (c - 1.0)) + h * s if tilted else 0.0
    (arm_l, drop_l), (arm_r, drop_r) = (
        corner_x_and_depth_from_centre(-1.0, block, c, s),
        corner_x_and_depth_from_centre(1.0, block, c, s),
    )
    left, right = CornerState(0.0, x + arm_l, drop_l - z, 0.0), CornerState(0.0, x + arm_r, drop_r - z, 0.0)
    ul, ur = max(left.penetration, 0.0), max(right.penetration, 0.0)
    az, aw = k * (ul + ur) - GRAVITY, inertia * k * (-arm_l * ul + -arm_r * ur)
    at_rest = BlockState(
        centre_x=x, centre_z=z, angle=case_table_row.initial_tilt, cos=c, sin=s, centre_vx=0.0, centre_vz=0.0,
        angular_velocity=0.0, centre_ax=0.0, centre_az=az, angular_acceleration=aw, left=left, right=right,
        ticks_since_sample_start=0.0, remaining_flat_landing_time=0.0,
    )  # fmt: skip
    store_block_constants(state, lane, block)
    store_step_lengths_and_doubling_counts(state, lane, CaseStepLengthsAndDoublingCounts(
        case_table_row.min_allowed_step_ticks, case_table_row.longest_step_with_all_contacts_closed_ticks,
        case_table_row.steps_before_doubling_after_contact_change, case_table_row.long_steps_before_doubling,
    ))  # fmt: skip
    store_block_state(state, lane, at_rest)
    length, steps = case_table_row.min_allowed_step_ticks, case_table_row.steps_before_doubling_after_contact_change
    store_next_step_to_attempt(state, lane, NextStepToAttempt(length, steps, 0.0))
    store_signed_friction_or_zero(state, lane, SignedFrictionCoefficientOrZeroIfSticking(0.0, 0.0))
    store_peaks_and_last_upright_tick(
        state, lane, BlockPeaksAndLastUprightTick(abs(case_table_row.initial_tilt), 0.0, 0.0, -1.0)
    )
    barrier, first = GRAVITY * (np.sqrt(b * b + h * h) - h), block_mechanical_energy_per_mass(block, at_rest, 0.0)
    state[REST_ACCELERATION_LIMIT_ROW_OFFSET + lane] = case_table_row.max_base_acceleration_without_motion_g
    store_case_progress(state, lane, CaseProgress(
        case_table_row.amplitude_factor, case_table_row.first_simulated_sample,
        case_table_row.cannot_start_moving_from_sample,
        case_table_row.end_sample_if_undecided, case_table_row.first_simulated_sample * sampling_interval,
        first, barrier,
    ))  # fmt: skip
