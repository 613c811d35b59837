"""Step control of a case: acceptance of an attempted step and length of the next (docs/method.md, "The clock").

A whole step is as long as the motion allows. A step in which a contact would open or close is rejected and halved, down
to the finest step, which resolves the contact. After the change, each length is kept for some steps before it doubles.
Lengths are in ticks. A longer step begins only at a multiple of its length, so that each step lies within one sample,
over which the input motion is linear.
"""

from typing import Final, NamedTuple

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.time_step import MAX_STEP_OVER_ROCKING_TIME_CONSTANT


class StepLimitsCommonToAllCases(NamedTuple):
    """Constants of the step control that all cases of a kernel share: limits of step lengths and of repetitions."""

    longest_whole_step_in_rocking_time_constants: float
    """Longest whole step, in 1/p; p = √(3g/4R) of the element that rocks fastest."""
    max_contact_change_step_times_omega: float
    """Longest step in which a contact may open or close, in 1/ω of the highest mode of the contact."""
    ticks_per_whole_step: float
    """Ticks of a whole step: a power of two, whose exponent is the largest number of halvings."""
    max_predicted_force_step_in_shortest_steps: float
    """Longest step, in finest steps, that uses predicted forces for contact and slip; longer ones the last state."""
    max_repetitions_with_corrected_sliding: float
    """Number of repetitions of a longer step with corrected sliding points before it is shortened."""
    steps_before_doubling_after_contact_change: float
    """Steps of one length after a contact change before the length doubles; more for a lightly damped contact."""
    long_step_threshold_in_shortest_steps: float
    """Length, in finest steps, from which a step is long: it does not resolve the vibration after a contact change."""
    long_steps_before_doubling: float
    """Long steps of one length before the length doubles; also steps of a length to which a step was shortened."""

    @property
    def max_step_halvings(self) -> int:
        """Largest number of times that a whole step may be halved."""
        return int(self.ticks_per_whole_step).bit_length() - 1

    def steps_of_equal_length_before_doubling(
        self, omega_squared_of_highest_mode: FloatArray, two_xi_omega_of_highest_mode: FloatArray
    ) -> FloatArray:
        """Return, for each case, the number of steps of one length after a contact change before the length doubles.

        The arguments, arrays of the same shape, are ω² (1/s²) and 2ξω (1/s) of each case's highest vibration mode.
        The number grows as 1/(2ξ), up to 8-fold, if the damping ratio ξ is below one half.
        """
        return np.asarray(
            self.steps_before_doubling_after_contact_change
            * np.clip(
                np.sqrt(omega_squared_of_highest_mode) / np.maximum(two_xi_omega_of_highest_mode, 1e-300), 1.0, 8.0
            )
        )


# Measured in docs/measurements.md (rigid limit, default step), by `python -m verification.scenes steps` (scenes) and
# `python -m verification.space` (3-D bodies). A 3-D body needs shorter steps: its lowest point moves along a rim.
BLOCK_STEP_CONTROL: Final = StepLimitsCommonToAllCases(
    longest_whole_step_in_rocking_time_constants=MAX_STEP_OVER_ROCKING_TIME_CONSTANT,
    max_contact_change_step_times_omega=0.08,
    ticks_per_whole_step=2.0**24,
    max_predicted_force_step_in_shortest_steps=4.0,
    max_repetitions_with_corrected_sliding=2.0,
    steps_before_doubling_after_contact_change=8.0,
    long_step_threshold_in_shortest_steps=8.0,
    long_steps_before_doubling=2.0,
)
SCENE_STEP_CONTROL: Final = BLOCK_STEP_CONTROL._replace(
    longest_whole_step_in_rocking_time_constants=0.0125,
    max_contact_change_step_times_omega=0.16,
    ticks_per_whole_step=2.0**20,
)
BODY_STEP_CONTROL: Final = BLOCK_STEP_CONTROL._replace(
    longest_whole_step_in_rocking_time_constants=0.004, max_contact_change_step_times_omega=0.1,
    ticks_per_whole_step=2.0**9, max_predicted_force_step_in_shortest_steps=2.0,
    max_repetitions_with_corrected_sliding=3.0, long_steps_before_doubling=4.0,
)  # fmt: skip
# A light stone below heavy ones vibrates far faster on their stiff contacts than a single body does.
STACK_STEP_CONTROL: Final = BODY_STEP_CONTROL._replace(
    max_contact_change_step_times_omega=0.2, ticks_per_whole_step=2.0**13
)

MAX_STEP_IN_SAMPLES_WHILE_ALL_CONTACTS_SLIDE: Final = 0.25
"""Longest step of a body that slides on all its contacts, in samples; it could stop or start within a longer one."""

MAX_SLIP_ONSET_STEP_IN_SAMPLES: Final = 0.0625
"""Longest step in which a body begins to slide, in samples; it is assumed to slide during the whole step."""

MAX_FRICTION_REVERSAL_STEP_IN_SAMPLES: Final = 0.015625
"""Longest step in which friction changes its sign, in samples; half of it still has the old sign."""

FLOAT_TO_INTEGER_ROUNDING_OFFSET: Final = 2.0**52
"""2**52: adding and subtracting it rounds a positive float64 to an integer."""


class CaseStepLengthsAndDoublingCounts(NamedTuple):
    """Step lengths of one case, in ticks, and the number of equal steps after which the length may double."""

    min_allowed_step_ticks: float
    """Finest step, ticks."""
    longest_step_with_all_contacts_closed_ticks: float
    """Step while the body rests on all contacts (≥ whole step), ticks."""
    steps_before_doubling_after_contact_change: float
    """Steps of one length after a contact change before the length doubles."""
    long_steps_before_doubling: float
    """Long steps of one length before the length doubles; see `StepLimitsCommonToAllCases`."""


class NextStepToAttempt(NamedTuple):
    """Next time step to attempt: its length, number of steps before a longer one is tried, and repetitions so far."""

    length_in_ticks: float
    """Length, ticks."""
    remaining_steps_before_lengthening: float
    """Steps of this length before longer ones may be tried."""
    repetitions_with_corrected_sliding_so_far: float
    """Number of repetitions of this step so far with other sliding points, at the same length."""


class StepContactChanges(NamedTuple):
    """Changes of contact and sliding in an attempted time step, which decide whether the step is accepted."""

    contact_opened_or_closed: bool
    """True if a contact opens or closes."""
    motion_requires_shorter_step: bool
    """True if the motion requires a shorter step."""
    may_accept_despite_contact_change: bool
    """True if the step may be accepted although a contact changes, since the contact moves little."""
    has_wrong_slip_assumption: bool
    """True if the sticking or sliding of a point in the solved step differs from the assumption."""
    has_velocity_against_assumed_slip: bool
    """True if a point slides against its velocity (slip reversal)."""
    friction_sign_changed_in_step: bool
    """True if the friction of a sliding point had the opposite sign before, so that it changes sign in the step."""
    slides_on_all_points: bool
    """True if all contact points of a body slide."""
    all_contacts_are_closed: bool
    """True if all contacts are closed at the end of the step."""


@njit(**INLINE_OPTIONS)
def decide_rejection_sliding_and_next_step(
    kernel_step_control: StepLimitsCommonToAllCases,
    case_step_control: CaseStepLengthsAndDoublingCounts,
    attempted_step: NextStepToAttempt,
    contact_changes: StepContactChanges,
    tick_at_end_of_attempt: float,
    ticks_per_sample: float,
) -> tuple[bool, bool, NextStepToAttempt]:
    """Decide whether an attempted step is rejected, and which step is attempted next.

    Returns (True if rejected, True if the next attempt assumes the same sliding, next attempt).
    `tick_at_end_of_attempt` counts from the start of the sample. A body may begin to slide in a step of up to
    `MAX_SLIP_ONSET_STEP_IN_SAMPLES` of a sample, and friction may change its sign in a step of up to
    `MAX_FRICTION_REVERSAL_STEP_IN_SAMPLES`. If a step in which a body begins to slide is halved, the points that stuck
    are assumed to stick again.
    """
    length = attempted_step.length_in_ticks
    shorter = (
        (contact_changes.contact_opened_or_closed | contact_changes.motion_requires_shorter_step)
        & (length > case_step_control.min_allowed_step_ticks)
        & (not contact_changes.may_accept_despite_contact_change)
    )
    wrong = contact_changes.has_wrong_slip_assumption & (not shorter)
    onset = contact_changes.slides_on_all_points & (length > MAX_SLIP_ONSET_STEP_IN_SAMPLES * ticks_per_sample)
    back = contact_changes.friction_sign_changed_in_step & (
        length > MAX_FRICTION_REVERSAL_STEP_IN_SAMPLES * ticks_per_sample
    )
    halved = ((contact_changes.has_velocity_against_assumed_slip | back) & (not shorter)) | (
        wrong
        & (
            onset
            | (
                attempted_step.repetitions_with_corrected_sliding_so_far
                >= kernel_step_control.max_repetitions_with_corrected_sliding
            )
        )
    )
    retry, sooner = wrong & (not halved), wrong & onset & (not contact_changes.has_velocity_against_assumed_slip)
    shorter = shorter | halved
    longest = (
        case_step_control.longest_step_with_all_contacts_closed_ticks
        if contact_changes.all_contacts_are_closed
        else kernel_step_control.ticks_per_whole_step
    )
    above = (
        2.0 * length
        if length < kernel_step_control.ticks_per_whole_step
        else case_step_control.longest_step_with_all_contacts_closed_ticks
    )
    times = tick_at_end_of_attempt / above
    fits = (times + FLOAT_TO_INTEGER_ROUNDING_OFFSET) - FLOAT_TO_INTEGER_ROUNDING_OFFSET == times
    longer = (
        (attempted_step.remaining_steps_before_lengthening <= 1.0)
        & (length < longest)
        & fits
        & (
            not (
                contact_changes.slides_on_all_points
                & (above > MAX_STEP_IN_SAMPLES_WHILE_ALL_CONTACTS_SLIDE * ticks_per_sample)
            )
        )
    )
    left = (
        (
            case_step_control.long_steps_before_doubling
            if length
            >= kernel_step_control.long_step_threshold_in_shortest_steps * case_step_control.min_allowed_step_ticks
            else case_step_control.steps_before_doubling_after_contact_change
        )
        if longer
        else attempted_step.remaining_steps_before_lengthening - 1.0
    )
    left = (
        case_step_control.steps_before_doubling_after_contact_change
        if contact_changes.contact_opened_or_closed
        else left
    )
    left = case_step_control.long_steps_before_doubling if shorter else left
    left = attempted_step.remaining_steps_before_lengthening if retry else left
    then = above if longer & (not (contact_changes.contact_opened_or_closed | retry)) else length
    then = 0.5 * length if shorter else then
    then = (
        kernel_step_control.ticks_per_whole_step
        if (length > kernel_step_control.ticks_per_whole_step)
        & (shorter | (not contact_changes.all_contacts_are_closed))
        else then
    )
    return (
        shorter | retry,
        sooner,
        NextStepToAttempt(then, left, attempted_step.repetitions_with_corrected_sliding_so_far + 1.0 if retry else 0.0),
    )
