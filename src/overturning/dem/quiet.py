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
        rising = np.maximum.accumulate(ratio)
        falling = np.maximum.accumulate(ratio[::-1])
        stays_at_rest[group] = rising[-1] <= level
        first[group] = np.maximum(np.searchsorted(rising, SAFE_SHARE * level, side="right") - 1 - lead, 0)
        # One more, since the motion goes on linearly from the last loud sample to the next.
        calm[group] = np.minimum(samples - np.searchsorted(falling, SAFE_SHARE * level, side="right") + 1, samples)
    return first, calm, stays_at_rest
