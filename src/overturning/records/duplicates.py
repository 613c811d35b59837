"""Find records with the same samples: one motion under two ids, or in two formats."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from overturning.errors import ConfigError
from overturning.records.record import Record

SAMPLE_COUNT_EACH_SIDE_OF_PEAK: Final = 500
"""Number of samples before and after the peak in a fingerprint (resampled acceleration) of a record."""

FINGERPRINT_SAMPLING_INTERVAL_S: Final = 0.01
"""Time between the samples of a fingerprint, s."""

MOVING_AVERAGE_SAMPLE_COUNT: Final = 11
"""Number of samples in the moving average, which removes differences of rate and digits between file formats."""

MAX_RELATIVE_ROOT_ENERGY_DIFFERENCE: Final = 0.03
"""Largest relative difference in size (root of the energy) of two motions that are compared."""

MIN_CORRELATION_OF_DUPLICATES: Final = 0.999
"""Smallest correlation of two equal motions; different records of the shipped table have at most 0.56."""


@dataclass(frozen=True)
class MotionFingerprint:
    """Resampled horizontal acceleration around a record's peak, used to find records with the same samples."""

    record_id: str
    root_of_integral_of_squared_acceleration: float  # root of the energy of the window, m/s^1.5
    north_plus_i_east_acceleration_near_peak: npt.NDArray[
        np.complex64
    ]  # north + i east, shape (2 SAMPLE_COUNT_EACH_SIDE_OF_PEAK + 1,), zero beyond the record


def fingerprint_of_recorded_motion(record: Record) -> MotionFingerprint | None:
    """Compute the fingerprint of a record for finding duplicates; None for synthetic pulses and motions from Python."""
    if record.extra.get("format") == "synthetic" or record.extra.get("given"):
        return None
    moving = (record.north - record.north.mean()) + 1j * (record.east - record.east.mean())
    time = np.arange(moving.size) * record.sampling_interval
    even = np.arange(0.0, time[-1], FINGERPRINT_SAMPLING_INTERVAL_S)
    coarse = np.interp(even, time, moving.real) + 1j * np.interp(even, time, moving.imag)
    smooth = np.convolve(
        np.pad(coarse, SAMPLE_COUNT_EACH_SIDE_OF_PEAK),
        np.full(MOVING_AVERAGE_SAMPLE_COUNT, 1 / MOVING_AVERAGE_SAMPLE_COUNT),
        "same",
    )
    peak = int(np.abs(smooth).argmax())
    window = smooth[max(peak - SAMPLE_COUNT_EACH_SIDE_OF_PEAK, 0) : peak + SAMPLE_COUNT_EACH_SIDE_OF_PEAK + 1]
    window = np.pad(window, (0, 2 * SAMPLE_COUNT_EACH_SIDE_OF_PEAK + 1 - window.size)).astype(np.complex64)
    return MotionFingerprint(
        record.record_id, float(np.sqrt(np.sum(np.abs(window) ** 2) * FINGERPRINT_SAMPLING_INTERVAL_S)), window
    )


def find_id_pairs_of_duplicate_records(fingerprints: Iterable[MotionFingerprint | None]) -> list[tuple[str, str]]:
    """Find records of the same motion, even if one is rotated or shifted; return sorted pairs of their ids."""
    known = sorted(
        (one for one in fingerprints if one is not None and one.root_of_integral_of_squared_acceleration > 0),
        key=lambda one: one.root_of_integral_of_squared_acceleration,
    )
    sizes = np.array([one.root_of_integral_of_squared_acceleration for one in known])
    pairs = []
    for at, one in enumerate(known):
        end = int(
            np.searchsorted(
                sizes,
                one.root_of_integral_of_squared_acceleration * (1.0 + MAX_RELATIVE_ROOT_ENERGY_DIFFERENCE),
                "right",
            )
        )
        pairs += [
            (one, other)
            for other in known[at + 1 : end]
            if largest_motion_correlation(one, other) > MIN_CORRELATION_OF_DUPLICATES
        ]
    return [(min(a.record_id, b.record_id), max(a.record_id, b.record_id)) for a, b in pairs]


def largest_motion_correlation(first_fingerprint: MotionFingerprint, second_fingerprint: MotionFingerprint) -> float:
    """Return the largest correlation coefficient of two horizontal motions over time shifts, rotations, reflections."""
    length = 2 * first_fingerprint.north_plus_i_east_acceleration_near_peak.size
    spectra = [
        np.fft.fft(motion, length)
        for motion in (
            first_fingerprint.north_plus_i_east_acceleration_near_peak,
            second_fingerprint.north_plus_i_east_acceleration_near_peak,
            second_fingerprint.north_plus_i_east_acceleration_near_peak.conj(),
        )
    ]
    products = [np.abs(np.fft.ifft(spectra[0] * np.conj(spectrum))).max() for spectrum in spectra[1:]]
    return (
        float(max(products))
        * FINGERPRINT_SAMPLING_INTERVAL_S
        / (
            first_fingerprint.root_of_integral_of_squared_acceleration
            * second_fingerprint.root_of_integral_of_squared_acceleration
        )
    )


def duplicate_record_messages(id_pairs_of_duplicate_records: Iterable[tuple[str, str]]) -> list[str]:
    """Return one message for each pair of records with the same samples."""
    return [
        f"records {a} and {b} have the same samples: one motion would count twice; leave one out"
        for a, b in id_pairs_of_duplicate_records
    ]


def refuse_duplicate_records(records: Iterable[Record]) -> None:
    """Raise a ConfigError that names the records that have the same samples."""
    if texts := duplicate_record_messages(
        find_id_pairs_of_duplicate_records(map(fingerprint_of_recorded_motion, records))
    ):
        raise ConfigError("\n       ".join(texts))
