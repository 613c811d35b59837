"""How each case is to be computed: its contact, its steps, and the time that can be left out."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.block.rows import LEAST_TAIL, SETTLING, TAIL, TICKS
from overturning.dem.blocks import Cases
from overturning.dem.contact import Contact, check_precision
from overturning.dem.quiet import quiet_windows
from overturning.dem.time_step import (
    Scheme,
    highest_eigenvalue,
    rocking_time,
    scheme_of,
    steps_per_sample,
)
from overturning.errors import ArgumentError
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

FloatArray = NDArray[np.float64]

DEEPEST: Final = 0.2
"""Penetration, in half the smaller side, beyond which the contact law no longer holds."""

AFTERMATH: Final = 20.0
"""Time after the record, in 1/p, at which a block that may still fall is undecided."""


@dataclass(frozen=True)
class Plan:
    """How each case is to be computed: functions of the case and its record alone."""

    scheme: Scheme
    cases: Cases
    row: NDArray[np.int64]
    ground: FloatArray
    upward: FloatArray | None
    steps: NDArray[np.int64]
    first: NDArray[np.int64]
    calm: FloatArray
    never: NDArray[np.bool_]
    after: FloatArray
    normal: FloatArray
    tangential: FloatArray
    dashpot: FloatArray
    square: FloatArray
    rate: FloatArray
    interval: float

    def table(self, chosen: NDArray[np.int64]) -> FloatArray:
        """Rows of the kernel's case table."""
        from overturning.dem.block import tables as k

        cases = self.cases
        height, ratio = np.asarray(cases.height)[chosen], np.asarray(cases.b_over_h)[chosen]
        tilt = np.asarray(cases.initial_tilt)[chosen]
        table = np.zeros((chosen.size, k.PARAMETERS))
        table[:, k.P_WIDTH], table[:, k.P_HEIGHT] = ratio * height, height
        table[:, k.P_STIFFNESS], table[:, k.P_TANGENTIAL] = self.normal[chosen], self.tangential[chosen]
        table[:, k.P_DASHPOT] = self.dashpot[chosen]
        table[:, k.P_ALPHA] = _rounded(np.arctan, ratio)
        table[:, k.P_AMPLITUDE] = np.asarray(cases.amplitude)[chosen]
        table[:, k.P_TILT] = tilt
        table[:, k.P_TILT_COS], table[:, k.P_TILT_SIN] = _rounded(np.cos, tilt), _rounded(np.sin, tilt)
        table[:, k.P_FIRST], table[:, k.P_CALM] = self.first[chosen], self.calm[chosen]
        table[:, k.P_AFTER] = self.after[chosen]
        # A lightly damped contact rings for longer.
        rate, frequency = self.rate[chosen], np.sqrt(self.square[chosen])
        ringing = np.clip(frequency / np.maximum(rate, 1e-300), 1.0, 8.0)
        settling = SETTLING * ringing / frequency
        rate_of_steps = self.steps[chosen] / self.interval
        table[:, k.P_TAIL] = np.maximum(np.ceil(TAIL / frequency * rate_of_steps), LEAST_TAIL) * TICKS
        table[:, k.P_WINDOW] = np.ceil(settling * rate_of_steps) * TICKS + table[:, k.P_TAIL]
        return table


def _rounded(function: np.ufunc, values: FloatArray) -> FloatArray:
    # libm and SIMD versions of these differ in the last digit between processors; rounding hides it.
    distinct, where = np.unique(values, return_inverse=True)
    return np.round(function(distinct), 12)[where]


def plan(
    motion: Motion,
    cases: Cases,
    *,
    density: float,
    contact: Contact,
    scheme: str,
    time_step: float | str,
    leave_out: bool,
    refinement: int = 1,
) -> Plan:
    """Check the arguments and work out what each case needs."""
    if not (np.isfinite(density) and density > 0):
        raise ArgumentError(f"density: {density}; it must be finite and above 0 kg/m³")
    method = scheme_of(scheme)
    height, ratio = np.asarray(cases.height), np.asarray(cases.b_over_h)
    width, friction = ratio * height, np.asarray(cases.friction)
    normal, tangential, dashpot = contact.specific(width, height, density)
    dashpot = dashpot * np.asarray(cases.damping_factor)
    row, ground = shaking(motion, cases)
    check_precision(normal, height, 0.0)
    square = highest_eigenvalue(normal, tangential, 0.5 * width, 0.5 * height)
    rate = highest_eigenvalue(dashpot, dashpot, 0.5 * width, 0.5 * height)
    period = rocking_time(width, height)
    steps = steps_per_sample(method, time_step, square, rate, motion.sampling_interval, period) * refinement
    samples = motion.samples
    after = samples + np.ceil(AFTERMATH * period / motion.sampling_interval)
    if leave_out:
        first, quiet, never = quiet_windows(
            motion, row, np.asarray(cases.amplitude), ground[:, :samples], np.minimum(ratio, friction)
        )
        tilted = np.asarray(cases.initial_tilt) != 0
        first[tilted], never[tilted] = 0, False
        calm = quiet.astype(np.float64)
        # A block whose weight alone presses it in too far has no answer: the kernel is to find and mark it.
        never &= STANDARD_GRAVITY / (2.0 * normal) <= DEEPEST * 0.5 * np.minimum(width, height)
    else:
        first, calm, never = np.zeros(cases.size, np.int64), np.full(cases.size, np.inf), np.zeros(cases.size, np.bool_)
    upward = None if motion.up is None else np.concatenate([motion.up, np.zeros(3)])
    return Plan(
        method, cases, row, ground, upward, steps, first, calm, never, after, normal, tangential, dashpot, square,
        rate, motion.sampling_interval,
    )  # fmt: skip


def shaking(motion: Motion, cases: Cases) -> tuple[NDArray[np.int64], FloatArray]:
    """Row of each case, and rows of the base's acceleration along the azimuths, m/s², three zeros after the record."""
    azimuths, row = np.unique(np.asarray(cases.azimuth_deg), return_inverse=True)
    ground = np.zeros((azimuths.size, motion.samples + 3))
    for index, azimuth in enumerate(azimuths):
        ground[index, : motion.samples] = motion.along(float(azimuth))
    return row, ground
