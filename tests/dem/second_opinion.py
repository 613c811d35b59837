"""Runs cases through the scalar kernel, with the numbers that the plan of a sweep gives them."""

import numpy as np

from overturning.dem.blocks import Cases
from overturning.dem.contact import Contact
from overturning.dem.kernel import P_TAIL, P_WINDOW
from overturning.dem.plan import plan
from overturning.motion.motion import Motion
from tests.dem import scalar_kernel


def scalar_outcomes(
    motion: Motion,
    cases: Cases,
    *,
    contact: Contact | None = None,
    scheme: str = "centred",
    time_step: float | str = "auto",
    leave_out: bool = False,
    inertial: bool = False,
) -> np.ndarray:
    """Side, peak rotation over α, peak slip and block steps of each case."""
    how = plan(
        motion, cases, density=2650.0, contact=contact or Contact(), scheme=scheme, time_step=time_step,
        leave_out=leave_out,
    )  # fmt: skip
    table = how.table(np.arange(cases.size))
    up = np.zeros(0) if motion.up is None else motion.up
    out = np.zeros((cases.size, 4))
    for i in range(cases.size):
        half_height = 0.5 * cases.height[i]
        out[i] = scalar_kernel.run(
            scheme == "centred", how.ground[how.row[i], : motion.samples] * cases.amplitude[i],
            up * cases.amplitude[i], motion.sampling_interval, how.steps[i], half_height * cases.b_over_h[i],
            half_height, how.normal[i], how.tangential[i], how.dashpot[i], cases.friction[i], table[i, P_WINDOW],
            table[i, P_TAIL], cases.initial_tilt[i], how.first[i], inertial,
        )  # fmt: skip
    return out
