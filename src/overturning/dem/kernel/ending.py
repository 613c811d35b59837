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

MAX_TILT_RATIO_OF_STANDING_BODY: Final = 0.95
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
    last_onset_sample: float
    """First sample after which the input motion cannot start any movement."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""
    last_time_below_critical_angle: float
    """Last time at which the body leant less than its critical angle, s."""
    initial_energy: float
    """Energy at the start: of a block or body per mass, m²/s²; of a stack, J."""
    overturning_energy: float
    """Energy needed to overturn: a block or body per mass, m²/s²; a stack, J."""


class LargestTiltNearCaseEnd(NamedTuple):
    """Largest ratio of tilt to critical angle in the second half of the time from the record's end to the case's end.

    It is 1 if the body was in the air, above the height at which it balances on its rim.
    """

    tilt_over_critical_angle: float


class SlideEndSample(NamedTuple):
    """Sample up to which a case is continued at its end because a stone still slides; 0 before that is known."""

    sample_or_zero_before_known: float


class CaseRestState(NamedTuple):
    """Base acceleration up to which a case's body stays at rest, and 1 if the body was at rest as the sample began."""

    rest_acceleration_limit_g: float
    """Horizontal acceleration over g up to which the body stays at rest; 0 if it is simulated anyway."""
    was_at_rest_at_sample_start: float
    """1 if the body was at rest at the beginning of the sample, else 0."""


@njit(**INLINE_OPTIONS)
def next_sample_tick_and_last_upright_time(
    case_progress: CaseProgress,
    tick: float,
    last_upright_tick: float,
    ticks_per_sample: float,
    sampling_interval: float,
) -> tuple[float, float, float]:
    """Return the sample and tick at which a case continues, and the last time (s) when the body was upright.

    `tick` counts from the start of the sample that ended, the returned tick from the start of the returned sample.
    `last_upright_tick` is the last tick in the sample that ended at which the body was upright; negative if none.
    """
    then = (case_progress.current_sample + last_upright_tick * (1.0 / ticks_per_sample)) * sampling_interval
    over = (1.0 if tick >= ticks_per_sample else 0.0) + (1.0 if tick >= 2.0 * ticks_per_sample else 0.0)
    return (
        case_progress.current_sample + over,
        tick - over * ticks_per_sample,
        then if last_upright_tick >= 0.0 else case_progress.last_time_below_critical_angle,
    )


@njit(**INLINE_OPTIONS)
def case_cannot_have_ended(
    case_progress: CaseProgress,
    tick: float,
    ticks_per_sample: float,
    record_end_sample: float,
    state_sum: float,
    is_within_limits: bool,
) -> bool:
    """True if a case cannot have ended yet: its state is finite and within limits, and strong shaking is still ahead.

    `state_sum` is the sum of all values of the state that must be finite. If the result is false, the case may have
    ended or not.
    """
    sample, until = (
        case_progress.current_sample + tick * (1.0 / ticks_per_sample),
        case_progress.last_onset_sample if case_progress.last_onset_sample < record_end_sample else record_end_sample,
    )
    # inf − inf and NaN − NaN are NaN, which is not equal to 0.
    return (state_sum - state_sum == 0.0) & is_within_limits & (sample < until)


@njit(**INLINE_OPTIONS)
def body_is_still(speed: float, acceleration: float, step_length: float, rest_acceleration_limit_g: float) -> bool:
    """True if a body in contact is at rest: its speed and its acceleration are both below limits.

    `speed` (m/s) and `acceleration` (m/s²) are the largest components after a step of `step_length` (s).
    `rest_acceleration_limit_g` is the base acceleration over g up to which the body stays at rest.

    Vibrations slower than the step appear in the acceleration, faster ones in the speed over half of the step.
    """
    least = MAX_ACCELERATION_AT_REST_TO_REST_LIMIT_RATIO * rest_acceleration_limit_g * GRAVITY
    return bool((2.0 * speed < least * step_length) & (acceleration < least))


@njit(**INLINE_OPTIONS)
def largest_tilt_near_case_end(
    largest_tilt_ratio_so_far: float,
    case_progress: CaseProgress,
    sample: float,
    record_end_sample: float,
    tilt_ratio: float,
    centre_height_gain: float,
) -> float:
    """Return the largest ratio of tilt to critical angle near a case's end so far, including this sample.

    See `LargestTiltNearCaseEnd`.

    `largest_tilt_ratio_so_far` is the value at the end of the sample before, `tilt_ratio` the tilt over the critical
    angle, `centre_height_gain` (m) the height of the centre above its height at rest.
    """
    if sample < 0.5 * (record_end_sample + case_progress.end_sample_if_undecided):
        return largest_tilt_ratio_so_far
    # A body above the height at which it balances on its rim is in the air; it may fall when it lands.
    return max(
        largest_tilt_ratio_so_far,
        1.0 if GRAVITY * centre_height_gain >= case_progress.overturning_energy else tilt_ratio,
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def update_slide_end_and_check_case_continues(
    state: Any, slide_end_index: int, sample: float, sliding_time: float, sampling_interval: float
) -> bool:
    """True if a case is simulated further at its end because a body still slides or spins.

    At the first call, the sample at which friction has stopped the motion is stored in `state[slide_end_index]`, which
    is 0 before. `sliding_time` (s) is the time in which friction would stop the fastest slide or spin on its own, or 0.
    A slide and a spin of one body slow each other down less than each would slow down on its own, and end together.
    """
    # The sample is not computed again: a cylinder that rolls on its rim without loss would be simulated for ever.
    if state[slide_end_index] == 0.0:
        state[slide_end_index] = sample + 3.0 * sliding_time / sampling_interval
    return bool(sample < state[slide_end_index])
