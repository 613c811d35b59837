"""What need not be computed: cases that cannot move, and the time before and after they can."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

SAFE_SHARE: Final = 0.1
"""A block at rest is computed from this share of its lower threshold on (docs/design-notes.md: why not from 1)."""

LEAD: Final = 2.0
"""And from this long before, s."""

BORNE: Final = 0.5
"""A body at rest is followed from this share of its lower threshold on (docs/method.md: up to it nothing creeps), and
one in space that is followed while it stands takes samples as steps below it;"""

BORNE_BY_STACKS: Final = 0.3
"""a scene from this one, since a joint that has slipped lifts earlier,"""

UNEVEN: Final = 0.9
"""and at the latest from this share of what lets its lighter corner slip: something moves when it is left alone."""


def quiet_windows(
    motion: Motion, row: NDArray[np.int64], amplitude: FloatArray, ground: FloatArray, threshold: FloatArray
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """First sample to compute, first sample of the final calm, and whether a case stays at rest.

    A rigid block cannot start to rock before |a| > (g + a_up) B/H, nor to slide before |a| > μ (g + a_up). Between
    two samples both accelerations are linear in time, so that their ratio is largest at one of the samples.

    Of each case: the `row` of `ground`, shape (azimuths, samples), m/s², the `amplitude`, and the `threshold` min(B/H,
    μ). From the sample `calm` on a block at rest stays at rest; `stays_at_rest` says that it is below both thresholds
    for the whole record.
    """
    count = row.size
    first, calm = np.zeros(count, np.int64), np.zeros(count, np.int64)
    stays_at_rest = np.zeros(count, np.bool_)
    lead = int(np.ceil(LEAD / motion.sampling_interval))
    samples = ground.shape[1]
    # Without vertical motion the ratio is linear in the amplitude: one look at the record serves all amplitudes.
    keys = [row] if motion.up is None else [row, amplitude]
    order = np.lexsort(keys[::-1])
    changes = np.any([np.diff(key[order]) != 0 for key in keys], axis=0)
    for group in np.split(order, np.flatnonzero(changes) + 1):
        if motion.up is None:
            ratio = np.abs(ground[row[group[0]]]) / STANDARD_GRAVITY
            level = threshold[group] / np.maximum(np.abs(amplitude[group]), 1e-300)
        else:
            factor = amplitude[group[0]]
            weight = STANDARD_GRAVITY + factor * motion.up
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = np.where(weight > 0, np.abs(factor * ground[row[group[0]]]) / weight, np.inf)
            level = threshold[group]
        # Of the samples above the lowest level alone: of all of them a running maximum would be half of the time here.
        safe = SAFE_SHARE * level
        loud = np.concatenate([[-1], np.flatnonzero(ratio > safe.min()), [samples]])
        rising = np.maximum.accumulate(ratio[loud[1:-1]])
        falling = np.maximum.accumulate(ratio[loud[-2:0:-1]])
        stays_at_rest[group] = ratio.max() <= level
        first[group] = np.maximum(loud[1:][np.searchsorted(rising, safe, side="right")] - 1 - lead, 0)
        # One more, since the motion goes on linearly from the last loud sample to the next.
        calm[group] = np.minimum(loud[-2::-1][np.searchsorted(falling, safe, side="right")] + 2, samples)
    return first, calm, stays_at_rest


def borne(lifts: FloatArray, slips: FloatArray, unloads: FloatArray, overshoot: FloatArray, share: float) -> FloatArray:
    """Horizontal acceleration, as a share of the weight, up to which a body at rest is not followed (docs/method.md).

    The rigid body starts to rock at `lifts` and to slide at `slips`; on springs its first corner is unloaded at
    `unloads`. The contact's forces are up to `overshoot` times those at rest. Above a `share` of the lower threshold it
    is followed in any case.
    """
    with np.errstate(divide="ignore"):
        creeps = 1.0 / (1.0 / np.maximum(unloads, 0.0) + 1.0 / np.maximum(slips, 0.0))
    return np.asarray(np.minimum(share * np.minimum(lifts, slips), UNEVEN * creeps / overshoot))


def overshoot(square: FloatArray, delay: FloatArray | float, interval: float) -> FloatArray:
    """How often the largest load at rest a contact's slowest mode can bear at most, whatever the shaking below a bound.

    Of two bounds the lower: the integral of |h|, h the force after an impulse of the base, for any motion; and for one
    that is linear between samples what its bends set ringing, 4/x each, x = ω Δt, which dies out by exp(−ξ x) in a
    sample.

    Parameters
    ----------
    square : ndarray
        ω² of the slowest mode, 1/s².
    delay : ndarray or float
        Dashpots over springs, s, so that ξ = ω · delay / 2.
    interval : float
        Time between samples, s.
    """
    frequency = np.sqrt(square)
    damping, phase = np.clip(0.5 * frequency * delay, 1e-6, 0.999), frequency * interval
    fast = np.sqrt(1.0 - damping**2)
    first = (np.pi - 2.0 * np.arcsin(damping)) / fast
    any_motion = 1.0 + 2.0 * np.exp(-damping * first) / -np.expm1(-np.pi * damping / fast)
    with np.errstate(divide="ignore"):  # of a body on one corner, which nothing holds
        bent = 1.0 + 4.0 / (phase * -np.expm1(-damping * phase))
    # Rounded, since libm and SIMD versions differ in the last digit between processors.
    return np.asarray(np.round(np.minimum(any_motion, bent), 6))
