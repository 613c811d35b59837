"""Time steps of bodies and stacks: the longest steps in a sample, and the control of their lengths."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.state import MIN_OMEGA_DT_FOR_STEPS_OF_ONE_SAMPLE
from overturning.dem.kernel.clock import BODY_STEP_CONTROL as PACE
from overturning.dem.kernel.clock import StepLimitsCommonToAllCases
from overturning.dem.numerics import NumericalOptions
from overturning.dem.time_step import (
    IntegrationScheme,
    inverse_contact_frequency_reduced_at_high_damping,
    steps_per_sample,
)


def longest_step_count_per_sample_and_step_control(
    numerics: NumericalOptions,
    omega_squared_of_highest_contact_mode_by_case: FloatArray,
    two_xi_omega_of_highest_contact_mode_by_case: FloatArray,
    sampling_interval_s: float,
    rocking_time_constant_s_by_case: FloatArray,
    kernel_step_control: StepLimitsCommonToAllCases = PACE,
) -> tuple[NDArray[np.int64], dict[str, FloatArray]]:
    """Return, for n cases, the number of longest steps in a sample, and their step control as columns by name.

    The columns are the fields of `overturning.dem.kernel.clock.CaseStepLengthsAndDoublingCounts`. ω² (1/s²) and
    2ξω (1/s) belong to the highest vibration mode on the contact springs; the rocking time constant is 1/p (s). All
    arrays have the shape (n,). `kernel_step_control` holds the step limits of the kernel.

    Raises
    ------
    ArgumentError
        If the time step is longer than the longest allowed one.
    """
    # The scheme is stable with any step; accuracy limits it, expressed as the stable step of an undamped oscillator.
    whole = kernel_step_control.longest_whole_step_in_rocking_time_constants * rocking_time_constant_s_by_case
    per_sample = partial(
        steps_per_sample, IntegrationScheme.CUNDALL, omega_squared_of_highest_mode=(2.0 / whole) ** 2,
        two_xi_omega_of_highest_mode=np.zeros(whole.size), sampling_interval=sampling_interval_s,
        block_rocking_time_constant_by_case_s=rocking_time_constant_s_by_case,
    )  # fmt: skip
    usual = per_sample("1 stable")
    steps = usual if numerics.time_step == "auto" else per_sample(numerics.time_step)
    tick = sampling_interval_s / steps / kernel_step_control.ticks_per_whole_step
    contact = inverse_contact_frequency_reduced_at_high_damping(
        omega_squared_of_highest_contact_mode_by_case, two_xi_omega_of_highest_contact_mode_by_case
    )
    share = np.minimum(sampling_interval_s / steps / whole, 1.0)
    most = kernel_step_control.max_contact_change_step_times_omega * share * contact / tick
    finest = np.exp2(np.frexp(np.clip(most, 1.0, kernel_step_control.ticks_per_whole_step))[1] - 1.0)
    # A refined case has shorter ticks, hence more of them.
    steps = steps * numerics.refinement
    # A contact that is not overdamped would keep oscillating in steps of a sample.
    rigid = (
        np.sqrt(omega_squared_of_highest_contact_mode_by_case) * sampling_interval_s
        >= MIN_OMEGA_DT_FOR_STEPS_OF_ONE_SAMPLE
    ) & (two_xi_omega_of_highest_contact_mode_by_case >= np.sqrt(omega_squared_of_highest_contact_mode_by_case))
    return steps, {
        "min_allowed_step_ticks": finest,
        "longest_step_with_all_contacts_closed_ticks": kernel_step_control.ticks_per_whole_step
        * np.where(rigid, np.gcd(usual, steps), 1),
        "steps_before_doubling_after_contact_change": np.round(
            kernel_step_control.steps_of_equal_length_before_doubling(
                omega_squared_of_highest_contact_mode_by_case, two_xi_omega_of_highest_contact_mode_by_case
            )
            * steps
            / usual
        ),
        "long_steps_before_doubling": np.round(kernel_step_control.long_steps_before_doubling * steps / usual),
    }
