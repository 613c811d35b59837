"""Time steps of stacks: the longest steps in a sample, and the control of their lengths."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.step_control import longest_step_count_per_sample_and_step_control
from overturning.dem.kernel.clock import STACK_STEP_CONTROL
from overturning.dem.numerics import NumericalOptions
from overturning.dem.stack.state import TICKS_PER_WHOLE_STEP

CAP_ON_MIN_ALLOWED_STEP_TICKS: Final = TICKS_PER_WHOLE_STEP / 512.0
"""Longest finest step, ticks, also where the contacts vibrate slowly: the landing of a stone needs it."""


def steps_per_sample_and_step_control_of_stacks(
    numerics: NumericalOptions,
    omega_squared_by_case: FloatArray,
    two_xi_omega_by_case: FloatArray,
    sampling_interval_s: float,
    rocking_time_constant_s_by_case: FloatArray,
) -> tuple[NDArray[np.int64], dict[str, FloatArray]]:
    """Return the number of longest steps in a sample and the columns of the step control of stacks, by case.

    ω² (1/s²) and 2ξω (1/s) are those of the highest mode of a stack on its contacts.
    """
    steps, control = longest_step_count_per_sample_and_step_control(
        numerics,
        omega_squared_by_case,
        two_xi_omega_by_case,
        sampling_interval_s,
        rocking_time_constant_s_by_case,
        STACK_STEP_CONTROL,
    )
    control["min_allowed_step_ticks"] = np.minimum(control["min_allowed_step_ticks"], CAP_ON_MIN_ALLOWED_STEP_TICKS)
    # When the vibration of a light stone has decayed, that of the heavy stones around it goes on.
    control["long_steps_before_doubling"] = np.where(
        control["min_allowed_step_ticks"] < CAP_ON_MIN_ALLOWED_STEP_TICKS,
        control["steps_before_doubling_after_contact_change"],
        control["long_steps_before_doubling"],
    )
    return steps, control
