"""Find records with the same samples: one motion under two ids, or in two formats."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from overturning.errors import ConfigError
from overturning.records.record import Record

HALF_WINDOW_SAMPLES: Final = 500
"""Number of samples before and after the peak in a fingerprint (resampled acceleration) of a record."""

FINGERPRINT_INTERVAL_S: Final = 0.01
"""Time between the samples of a fingerprint, s."""

MOVING_AVERAGE_SAMPLES: Final = 11
"""Number of samples in the moving average, which removes differences of rate and digits between file formats."""

MAX_RELATIVE_ROOT_ENERGY_DIFFERENCE: Final = 0.03
"""Largest relative difference in size (root of the energy) of two motions that are compared."""

MIN_CORRELATION_OF_DUPLICATES: Final = 0.999
"""Smallest correlation of two equal motions; different records of the shipped table have at most 0.56."""


@dataclass(frozen=True)
class MotionFingerprint:
    """Resampled horizontal acceleration around a record's peak, used to find records with the same samples."""

    record_id: str
    root_energy: float  # root of the energy of the window, m/s^1.5
    resampled_acceleration: npt.NDArray[
        np.complex64
    ]  # north + i east, shape (2 HALF_WINDOW_SAMPLES + 1,), zero beyond the record


def motion_fingerprint(record: Record) -> MotionFingerprint | None:
    """Compute the fingerprint of a record for finding duplicates; None for synthetic pulses and motions from Python."""
    if record.extra.get("format") == "synthetic" or record.extra.get("given"):
        return None
    moving = (record.north - record.north.mean()) + 1j * (record.east - record.east.mean())
    time = np.arange(moving.size) * record.sampling_interval
    even = np.arange(0.0, time[-1], FINGERPRINT_INTERVAL_S)
    coarse = np.interp(even, time, moving.real) + 1j * np.interp(even, time, moving.imag)
    smooth = np.convolve(
        np.pad(coarse, HALF_WINDOW_SAMPLES), np.full(MOVING_AVERAGE_SAMPLES, 1 / MOVING_AVERAGE_SAMPLES), "same"
    )
    peak = int(np.abs(smooth).argmax())
    window = smooth[max(peak - HALF_WINDOW_SAMPLES, 0) : peak + HALF_WINDOW_SAMPLES + 1]
    window = np.pad(window, (0, 2 * HALF_WINDOW_SAMPLES + 1 - window.size)).astype(np.complex64)
    return MotionFingerprint(
        record.record_id, float(np.sqrt(np.sum(np.abs(window) ** 2) * FINGERPRINT_INTERVAL_S)), window
    )


def find_duplicate_records(fingerprints: Iterable[MotionFingerprint | None]) -> list[tuple[str, str]]:
    """Find records with the same samples, even if one is rotated; return pairs of their ids."""
    known = sorted(
        (one for one in fingerprints if one is not None and one.root_energy > 0), key=lambda one: one.root_energy
    )
    sizes = np.array([one.root_energy for one in known])
    pairs = []
    for at, one in enumerate(known):
        end = int(np.searchsorted(sizes, one.root_energy * (1.0 + MAX_RELATIVE_ROOT_ENERGY_DIFFERENCE), "right"))
        pairs += [
            (one, other)
            for other in known[at + 1 : end]
            if largest_motion_correlation(one, other) > MIN_CORRELATION_OF_DUPLICATES
        ]
    return [(min(a.record_id, b.record_id), max(a.record_id, b.record_id)) for a, b in pairs]


def largest_motion_correlation(first_fingerprint: MotionFingerprint, second_fingerprint: MotionFingerprint) -> float:
    """Return the largest correlation of two motions over time shifts, rotations and reflections."""
    length = 2 * first_fingerprint.resampled_acceleration.size
    spectra = [
        np.fft.fft(motion, length)
        for motion in (
            first_fingerprint.resampled_acceleration,
            second_fingerprint.resampled_acceleration,
            second_fingerprint.resampled_acceleration.conj(),
        )
    ]
    products = [np.abs(np.fft.ifft(spectra[0] * np.conj(spectrum))).max() for spectrum in spectra[1:]]
    return (
        float(max(products)) * FINGERPRINT_INTERVAL_S / (first_fingerprint.root_energy * second_fingerprint.root_energy)
    )


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
