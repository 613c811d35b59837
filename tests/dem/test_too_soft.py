"""A contact so soft that the block's weight alone presses it in too far has no answer, shaken or not."""

import numpy as np
import pytest

from overturning.dem.cases import Cases
from overturning.dem.contact import Contact
from overturning.dem.run import run_cases
from overturning.dem.status import Status
from overturning.dem.variables import INT8_MISSING
from overturning.motion.motion import Motion


@pytest.mark.parametrize("peak", [0.0, 0.1, 5.0])
@pytest.mark.parametrize("leave_out", [True, False])
def test_block_pressed_in_too_far_is_marked(peak: float, leave_out: bool) -> None:
    north = peak * np.sin(np.arange(200) * 0.1)
    motion = Motion(north, np.zeros(200), sampling_interval=0.01)
    cases = Cases(0.0, 1.0, [0.3, 0.3], 0.6)
    soft = run_cases(motion, cases, contact=Contact(stiffness=1e4), leave_out=leave_out)
    assert soft.status.tolist() == [Status.UNSTABLE] * 2
    assert soft.overturned.tolist() == [INT8_MISSING] * 2
    stiff = run_cases(motion, cases, contact=Contact(stiffness=1e8), leave_out=leave_out)
    assert (stiff.overturned != INT8_MISSING).all()
