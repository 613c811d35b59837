"""Runs cases through the scalar kernel, with the numbers that the plan of a sweep gives them."""

import numpy as np

from overturning.dem.block.plan import plan_block
from overturning.dem.cases import Cases
from overturning.dem.contact import Contact
from overturning.dem.kernel import P_DASHPOT, P_STIFFNESS, P_TAIL, P_TANGENTIAL, P_WINDOW
from overturning.dem.numerics import Numerics
from overturning.dem.scene import gravestone
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
    numerics = Numerics(scheme=scheme, time_step=time_step, leave_out=leave_out)
    how = plan_block(gravestone(contact), motion, cases, numerics)
    table = how.table
    up = np.zeros(0) if motion.up is None else motion.up
    out = np.zeros((cases.size, 4))
    for i in range(cases.size):
        half_height = 0.5 * cases.height[i]
        out[i] = scalar_kernel.run(
            scheme == "centred", how.ground[how.row[i], : motion.samples] * cases.amplitude[i],
            up * cases.amplitude[i], motion.sampling_interval, how.steps[i], half_height * cases.b_over_h[i],
            half_height, table[i, P_STIFFNESS], table[i, P_TANGENTIAL], table[i, P_DASHPOT], cases.friction[i], table[i, P_WINDOW],
            table[i, P_TAIL], cases.initial_tilt[i], how.first[i], inertial,
        )  # fmt: skip
    return out
