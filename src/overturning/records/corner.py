"""The corner frequency of a high-pass filter, from the noise before the onset."""

from typing import Final

import numpy as np

from overturning.motion.noise import noise_ratio
from overturning.records.record import Record

DEFAULT_HZ: Final = 0.1
"""Corner of the default processing, Hz; what is below it an accelerograph of the film age does not resolve."""

RATIO: Final = 3.0
"""Signal-to-noise ratio from which on a signal is taken for one, as is usual for strong-motion data."""

BOUNDS_HZ: Final = (0.03, 1.0)
"""Lowest and highest corner that is chosen by itself, Hz."""


def choose_corner(record: Record) -> tuple[float, str]:
    """Corner frequency, Hz, and the reason for it.

    It is the lowest frequency from which on, up to that of the largest ratio, the signal of both horizontal components is
    three times the noise before the onset; without such noise the default.
    """
    found = noise_ratio([record.north, record.east], record.sampling_interval)
    if found is None:
        return DEFAULT_HZ, f"no noise of 2 s before the onset to compare with: the default, {DEFAULT_HZ:g} Hz"
    window = f"noise of the first {found.onset:.1f} s"
    ratio = found.ratio.min(axis=0)
    best = int(ratio.argmax())
    below = np.flatnonzero(ratio[: best + 1] < RATIO)
    if ratio[best] < RATIO:
        corner, reason = BOUNDS_HZ[1], f"signal nowhere {RATIO:g} times the {window}: the highest corner"
    elif below.size:
        corner = float(found.frequency[below[-1] + 1])
        reason = f"signal less than {RATIO:g} times the {window} below it"
    else:
        corner = float(found.frequency[0])
        reason = f"signal more than {RATIO:g} times the {window} as far down as that tells"
    low, high = BOUNDS_HZ
    if not low <= corner <= high:
        reason += f"; kept within {low:g} to {high:g} Hz"
    return round(min(max(corner, low), high), 3), reason
