"""Find records with the same samples: one motion under two ids, or in two formats."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from overturning.errors import ConfigError
from overturning.records.record import Record

HALF_WINDOW: Final = 500
"""Number of samples before and after the peak in a fingerprint (resampled acceleration) of a record."""

INTERVAL: Final = 0.01
"""Time between the samples of a fingerprint, s."""

SMOOTHING: Final = 11
"""Number of samples in the moving average, which removes differences of rate and digits between file formats."""

MAX_SIZE_DIFFERENCE: Final = 0.03
"""Largest relative difference in size (root of the energy) of two motions that are compared."""

SAME_MOTION_CORRELATION: Final = 0.999
"""Smallest correlation of two equal motions; different records of the shipped table have at most 0.56."""


@dataclass(frozen=True)
class MotionFingerprint:
    """Resampled horizontal acceleration around a record's peak, used to find records with the same samples."""

    record_id: str
    size: float  # root of the energy of the window, m/s^1.5
    motion: npt.NDArray[np.complex64]  # north + i east, shape (2 HALF_WINDOW + 1,), zero beyond the record


def motion_fingerprint(record: Record) -> MotionFingerprint | None:
    """Compute the fingerprint of a record for finding duplicates; None for synthetic pulses and motions from Python."""
    if record.extra.get("format") == "synthetic" or record.extra.get("given"):
        return None
    moving = (record.north - record.north.mean()) + 1j * (record.east - record.east.mean())
    time = np.arange(moving.size) * record.sampling_interval
    even = np.arange(0.0, time[-1], INTERVAL)
    coarse = np.interp(even, time, moving.real) + 1j * np.interp(even, time, moving.imag)
    smooth = np.convolve(np.pad(coarse, HALF_WINDOW), np.full(SMOOTHING, 1 / SMOOTHING), "same")
    peak = int(np.abs(smooth).argmax())
    window = smooth[max(peak - HALF_WINDOW, 0) : peak + HALF_WINDOW + 1]
    window = np.pad(window, (0, 2 * HALF_WINDOW + 1 - window.size)).astype(np.complex64)
    return MotionFingerprint(record.record_id, float(np.sqrt(np.sum(np.abs(window) ** 2) * INTERVAL)), window)


def find_duplicate_records(fingerprints: Iterable[MotionFingerprint | None]) -> list[tuple[str, str]]:
    """Find records with the same samples, even if one is rotated; return pairs of their ids."""
    known = sorted((one for one in fingerprints if one is not None and one.size > 0), key=lambda one: one.size)
    sizes = np.array([one.size for one in known])
    pairs = []
    for at, one in enumerate(known):
        end = int(np.searchsorted(sizes, one.size * (1.0 + MAX_SIZE_DIFFERENCE), "right"))
        pairs += [
            (one, other)
            for other in known[at + 1 : end]
            if largest_motion_correlation(one, other) > SAME_MOTION_CORRELATION
        ]
    return [(min(a.record_id, b.record_id), max(a.record_id, b.record_id)) for a, b in pairs]


def largest_motion_correlation(first_fingerprint: MotionFingerprint, second_fingerprint: MotionFingerprint) -> float:
    """Return the largest correlation of two motions over time shifts, rotations and reflections."""
    length = 2 * first_fingerprint.motion.size
    spectra = [
        np.fft.fft(motion, length)
        for motion in (first_fingerprint.motion, second_fingerprint.motion, second_fingerprint.motion.conj())
    ]
    products = [np.abs(np.fft.ifft(spectra[0] * np.conj(spectrum))).max() for spectrum in spectra[1:]]
    return float(max(products)) * INTERVAL / (first_fingerprint.size * second_fingerprint.size)


def duplicate_record_messages(record_id_pairs: Iterable[tuple[str, str]]) -> list[str]:
    """Return one message for each pair of records with the same samples."""
    return [
        f"records {a} and {b} have the same samples: one motion would count twice; leave one out"
        for a, b in record_id_pairs
    ]


def refuse_duplicate_records(records: Iterable[Record]) -> None:
    """Raise a ConfigError that names the records that have the same samples."""
    if texts := duplicate_record_messages(find_duplicate_records(map(motion_fingerprint, records))):
        raise ConfigError("\n       ".join(texts))
