"""Progress of a case and termination tests of the block and body kernels (docs/method.md, "How a case ends")."""

from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.units import STANDARD_GRAVITY as GRAVITY

CASE_NOT_ENDED: Final = -1
"""Code in place of a `CaseStatus` for a case that has not ended."""

MAX_KINETIC_ENERGY_AT_REST_OVER_MG_HALF_WIDTH: Final = 1e-9
"""Largest kinetic energy of a body at rest on its base, in m g times half the width of the base."""

MAX_ACCELERATION_AT_REST_TO_REST_LIMIT_RATIO: Final = 0.05
"""Largest residual acceleration of a body at rest, as a share of the acceleration that it can bear."""

MAX_TILT_RATIO_AT_REST: Final = 0.01
"""Largest lean of a body at rest, as a share of its tipping angle."""

MAX_LATE_TILT_RATIO_COUNTED_AS_STANDING: Final = 0.95
"""Tilt over the critical angle below which the tilt of a standing body stays on a base at rest.

A cylinder that wobbles on its rim loses no energy, and its largest tilt repeats to 0.1 %."""

NEGLIGIBLE_REMAINING_SLIP_M: Final = 1e-6
"""Largest remaining slide of a single body at which its case may end, m."""


class CaseProgress(NamedTuple):
    """Progress of a case, and the sample numbers and energies that decide when the case ends."""

    amplitude_factor: float
    """Factor on the motion."""
    current_sample: float
    """Current sample of the record."""
    cannot_start_moving_from_sample: float
    """Sample from which on the input motion cannot start any movement."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""
    last_time_below_critical_angle: float
    """Last time at which the body leant less than its critical angle, s."""
    initial_energy: float
    """Energy at the start: of a block or body per mass, m²/s²; of a stack, J."""
    energy_needed_to_overturn: float
    """Energy needed to overturn: a block or body per mass, m²/s²; a stack, J."""


class LargestTiltRatioInSecondHalfAfterRecord(NamedTuple):
    """Largest ratio of tilt to critical angle in the second half of the time from the record's end to the case's end.

    It is 1 if the body was in the air, above the height at which it balances on its rim.
    """

    largest_tilt_over_critical_angle: float


class LastSampleOfContinuedSlidingCase(NamedTuple):
    """Sample up to which a case is simulated because a stone still slides at its regular end; 0 if not yet known."""

    end_sample_while_sliding_or_zero_if_unknown: float


class RestAccelerationLimitAndAtRestFlag(NamedTuple):
    """Base acceleration up to which a case's body stays at rest, and 1 if the body was at rest as the sample began."""

    max_base_acceleration_without_motion_g: float
    """Horizontal acceleration over g up to which the body stays at rest; 0 if it is simulated anyway."""
    was_at_rest_at_sample_start: float
    """1 if the body was at rest at the beginning of the sample, else 0."""


@njit(**INLINE_OPTIONS)
def continuation_sample_tick_and_last_upright_time(
    case_progress: CaseProgress,
    ticks_since_start_of_ended_sample: float,
    last_upright_tick_in_ended_sample: float,
    ticks_per_sample: float,
    sampling_interval: float,
) -> tuple[float, float, float]:
    """Return a case's current sample, tick in it and last upright time (s), after steps that may pass a sample's end.

    The body is upright while it leans less than its critical angle. `last_upright_tick_in_ended_sample` is the last
    tick at which it was upright in the sample in which the steps began; negative if none.
    """
    then = (
        case_progress.current_sample + last_upright_tick_in_ended_sample * (1.0 / ticks_per_sample)
    ) * sampling_interval
    over = (1.0 if ticks_since_start_of_ended_sample >= ticks_per_sample else 0.0) + (
        1.0 if ticks_since_start_of_ended_sample >= 2.0 * ticks_per_sample else 0.0
    )
    return (
        case_progress.current_sample + over,
        ticks_since_start_of_ended_sample - over * ticks_per_sample,
        then if last_upright_tick_in_ended_sample >= 0.0 else case_progress.last_time_below_critical_angle,
    )


@njit(**INLINE_OPTIONS)
def case_cannot_have_ended(
    case_progress: CaseProgress,
    ticks_since_sample_start: float,
    ticks_per_sample: float,
    record_end_sample: float,
    sum_of_state_values_to_check_finite: float,
    tilt_and_penetration_within_limits: bool,
) -> bool:
    """True if a case cannot have ended: its state is valid, and base motion that can move a body is still ahead.

    `sum_of_state_values_to_check_finite` is finite only if all values of the state are. If the result is false, the
    case may have ended or not.
    """
    sample, until = (
        case_progress.current_sample + ticks_since_sample_start * (1.0 / ticks_per_sample),
        case_progress.cannot_start_moving_from_sample
        if case_progress.cannot_start_moving_from_sample < record_end_sample
        else record_end_sample,
    )
    # inf − inf and NaN − NaN are NaN, which is not equal to 0.
    return (
        (sum_of_state_values_to_check_finite - sum_of_state_values_to_check_finite == 0.0)
        & tilt_and_penetration_within_limits
        & (sample < until)
    )


@njit(**INLINE_OPTIONS)
def body_is_still(
    speed_including_rotation_m_s: float,
    acceleration_including_rotation_m_s2: float,
    last_step_duration_s: float,
    max_base_acceleration_without_motion_g: float,
) -> bool:
    """True if a body in contact is at rest: its speed and acceleration are below limits.

    The limits are proportional to `max_base_acceleration_without_motion_g`, the base acceleration over g up to which
    the body stays at rest. Speed and acceleration, relative to the base, include those due to rotation; they are taken
    after the last step.

    Vibrations slower than the step appear in the acceleration, faster ones in the speed over half of the step.
    """
    least = MAX_ACCELERATION_AT_REST_TO_REST_LIMIT_RATIO * max_base_acceleration_without_motion_g * GRAVITY
    return bool(
        (2.0 * speed_including_rotation_m_s < least * last_step_duration_s)
        & (acceleration_including_rotation_m_s2 < least)
    )


@njit(**INLINE_OPTIONS)
def largest_tilt_ratio_in_second_half_after_record(
    previous_late_largest_tilt_ratio: float,
    case_progress: CaseProgress,
    current_sample: float,
    record_end_sample: float,
    largest_tilt_over_critical_angle: float,
    centre_height_above_rest_m: float,
) -> float:
    """Return the largest tilt ratio so far in the second half of the time from the record's end to the case's end.

    The tilt ratio is the tilt over the critical angle; see `LargestTiltRatioInSecondHalfAfterRecord`.

    `previous_late_largest_tilt_ratio` is the value at the end of the sample before, `centre_height_above_rest_m`
    the height of the centre above its height at rest.
    """
    if current_sample < 0.5 * (record_end_sample + case_progress.end_sample_if_undecided):
        return previous_late_largest_tilt_ratio
    # A body above the height at which it balances on its rim is in the air; it may fall when it lands.
    return max(
        previous_late_largest_tilt_ratio,
        1.0
        if GRAVITY * centre_height_above_rest_m >= case_progress.energy_needed_to_overturn
        else largest_tilt_over_critical_angle,
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def set_slide_end_once_and_check_case_continues(
    state_array: Any,
    state_array_index_of_slide_end_sample: int,
    current_sample: float,
    longest_time_until_friction_stops_s: float,
    sampling_interval: float,
) -> bool:
    """True if a case is simulated beyond its regular end because a body still slides or spins.

    The first call stores the sample at which the case then ends, at `state_array_index_of_slide_end_sample` of the
    state array, in place of 0. This sample is later by 3 times `longest_time_until_friction_stops_s`, the time in which
    friction would stop the fastest slide or spin on its own (0 if none). The factor is above 1 because a slide and a
    spin of one body slow each other down less than each would slow down on its own, and end together.
    """
    # The sample is not computed again: a cylinder that rolls on its rim without loss would be simulated for ever.
    if state_array[state_array_index_of_slide_end_sample] == 0.0:
        state_array[state_array_index_of_slide_end_sample] = (
            current_sample + 3.0 * longest_time_until_friction_stops_s / sampling_interval
        )
    return bool(current_sample < state_array[state_array_index_of_slide_end_sample])
