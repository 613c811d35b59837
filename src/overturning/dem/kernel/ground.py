"""Motion of the base, linear between samples, for all kernels."""

import math
from functools import reduce
from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.units import STANDARD_GRAVITY as GRAVITY

SAMPLES_PER_REST_CHECK_BLOCK: Final = 8
"""Number of samples in a block; samples of a body at rest are skipped in whole blocks."""

LEAD_TIME_BEFORE_POSSIBLE_MOVEMENT_S: Final = 0.5
"""Simulated time before the input motion can move a body at rest, s; its springs then match the motion."""

CHECKED_SAMPLES_PER_REST_CHECK_BLOCK: Final = 2
"""Number of samples, at the start of each block, at which rest is tested; with one, a long step could skip it."""

VERTICAL_ACCELERATION_FACTOR_IN_REST_TEST: Final = 2.0
"""Factor on vertical acceleration in the rest test: 1 for the lower weight, and 1 for vibration."""


class BaseAccelerationsAndMaximaInWindowAhead(NamedTuple):
    """Base acceleration at each sample, and its largest value in a time window after a sample.

    The acceleration is zero after the record.
    """

    horizontal_acceleration: FloatArray
    """Horizontal acceleration, m/s²: along each azimuth, shape (azimuths, samples + 3), or along x and y of a
    3-D body, shape (orientations, 2, samples + 3)."""
    upward_acceleration: FloatArray | None
    """Upward acceleration, m/s², shape (samples + 3,). None compiles a kernel without vertical motion."""
    max_abs_horizontal_acceleration_by_rest_check: FloatArray
    """Largest horizontal acceleration ahead, shape (directions, blocks, CHECKED_SAMPLES_PER_REST_CHECK_BLOCK),
    m/s²."""
    max_abs_vertical_acceleration_by_rest_check: FloatArray
    """Largest vertical acceleration ahead, up or down, shape (blocks, CHECKED_SAMPLES_PER_REST_CHECK_BLOCK),
    m/s²."""


class LinearBaseAcceleration(NamedTuple):
    """One component of the base acceleration (m/s²), linear in time (ticks, a time unit) up to the next sample."""

    value_at_sample_start: float
    """Value at the start of the sample."""
    slope_per_tick: float
    """Slope per tick."""
    slope_change_at_sample_end_per_tick: float
    """Change of the slope at the end of the sample, per tick."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def linear_base_acceleration_of_sample(
    acceleration_by_sample_m_s2: Any, sample_index: int, amplitude_factor: float, samples_per_tick: float
) -> LinearBaseAcceleration:
    """Return one component of the base acceleration, × a factor, as a linear function from a sample to the next.

    `acceleration_by_sample_m_s2` holds the component at each sample, m/s².
    """
    a0, a1, a2 = (
        acceleration_by_sample_m_s2[sample_index] * amplitude_factor,
        acceleration_by_sample_m_s2[sample_index + 1] * amplitude_factor,
        acceleration_by_sample_m_s2[sample_index + 2] * amplitude_factor,
    )
    return LinearBaseAcceleration(a0, (a1 - a0) * samples_per_tick, ((a2 - a1) - (a1 - a0)) * samples_per_tick)


@njit(**INLINE_OPTIONS)
def base_acceleration_at_tick(base_acceleration: LinearBaseAcceleration, ticks_since_sample_start: float) -> float:
    """Return a component of the base acceleration, m/s², at a tick (smallest unit of time) within its sample."""
    return base_acceleration.value_at_sample_start + base_acceleration.slope_per_tick * ticks_since_sample_start


@njit(**INLINE_OPTIONS)
def base_acceleration_in_this_or_next_sample(
    base_acceleration: LinearBaseAcceleration, ticks_since_sample_start: float, ticks_past_sample_end: float
) -> float:
    """Return a component of the base acceleration, m/s², at a tick (unit of time) of its sample or of the next one.

    `ticks_past_sample_end` is the number of ticks from the end of the sample to this tick; 0 within the sample.
    """
    return (
        base_acceleration.value_at_sample_start + base_acceleration.slope_per_tick * ticks_since_sample_start
    ) + base_acceleration.slope_change_at_sample_end_per_tick * ticks_past_sample_end


def max_acceleration_in_window_by_rest_check(
    acceleration_magnitude_by_sample_m_s2: FloatArray, sampling_interval: float
) -> FloatArray:
    """Return the largest base acceleration in a time window after each sample at which rest is tested.

    The window covers the next `SAMPLES_PER_REST_CHECK_BLOCK` samples and then the time
    `LEAD_TIME_BEFORE_POSSIBLE_MOVEMENT_S`. The value is infinite if the record ends within these samples. The maximum
    of each block is shared by all windows that contain it; a maximum over all samples of each window took half of the
    time of a sweep for long records.

    Parameters
    ----------
    acceleration_magnitude_by_sample_m_s2 : ndarray, shape (…, samples + 3)
        Magnitude of the acceleration, m/s², with zeros after the record.
    sampling_interval : float
        Time between samples, s.

    Returns
    -------
    ndarray, shape (…, samples // SAMPLES_PER_REST_CHECK_BLOCK + 1, CHECKED_SAMPLES_PER_REST_CHECK_BLOCK)
        Values for the first samples of each block, m/s².
    """
    samples = acceleration_magnitude_by_sample_m_s2.shape[-1] - 3
    window, count = (
        SAMPLES_PER_REST_CHECK_BLOCK + int(np.ceil(LEAD_TIME_BEFORE_POSSIBLE_MOVEMENT_S / sampling_interval)) + 1,
        samples // SAMPLES_PER_REST_CHECK_BLOCK + 1,
    )
    padded = np.zeros((count + window // SAMPLES_PER_REST_CHECK_BLOCK + 1, SAMPLES_PER_REST_CHECK_BLOCK))
    late = [
        SAMPLES_PER_REST_CHECK_BLOCK * np.arange(count) + look > samples - SAMPLES_PER_REST_CHECK_BLOCK
        for look in range(CHECKED_SAMPLES_PER_REST_CHECK_BLOCK)
    ]
    rows = acceleration_magnitude_by_sample_m_s2.reshape(-1, acceleration_magnitude_by_sample_m_s2.shape[-1])
    ahead = np.empty((len(rows), count, CHECKED_SAMPLES_PER_REST_CHECK_BLOCK))
    # One direction at a time: its samples fit into the processor's cache.
    for row, found in zip(rows, ahead, strict=True):
        padded.flat[: samples + 1] = row[: samples + 1]
        by_place = np.ascontiguousarray(padded.T)
        whole = by_place.max(axis=0)
        for look in range(CHECKED_SAMPLES_PER_REST_CHECK_BLOCK):
            # The window covers the rest of its own block, `further` whole blocks, and `left` samples of the last.
            further, left = divmod(window - (SAMPLES_PER_REST_CHECK_BLOCK - look), SAMPLES_PER_REST_CHECK_BLOCK)
            parts = [*by_place[look:, :count], *(whole[block : block + count] for block in range(1, 1 + further))]
            parts += [*by_place[:left, 1 + further : 1 + further + count]]
            found[:, look] = np.where(late[look], np.inf, reduce(np.maximum, parts))
    return ahead.reshape(*acceleration_magnitude_by_sample_m_s2.shape[:-1], count, CHECKED_SAMPLES_PER_REST_CHECK_BLOCK)


@njit(**INLINE_OPTIONS)
def is_rest_check_sample(current_sample: float) -> bool:
    """True if the program tests at this sample whether a body is at rest, so that samples can be skipped.

    These are the first `CHECKED_SAMPLES_PER_REST_CHECK_BLOCK` samples of each block of
    `SAMPLES_PER_REST_CHECK_BLOCK` samples.
    """
    blocks = current_sample * (1.0 / SAMPLES_PER_REST_CHECK_BLOCK)
    return blocks - math.floor(blocks) < CHECKED_SAMPLES_PER_REST_CHECK_BLOCK / SAMPLES_PER_REST_CHECK_BLOCK


@njit(**INLINE_OPTIONS)
def next_window_motion_is_below_rest_limit(
    ground_motion: BaseAccelerationsAndMaximaInWindowAhead,
    motion_row: int,
    current_sample: float,
    amplitude_factor: float,
    max_base_acceleration_without_motion_g: float,
) -> bool:
    """True if the base motion in a time window after `current_sample` cannot move a body at rest.

    The window is that of `max_acceleration_in_window_by_rest_check`. `amplitude_factor` multiplies the motion; the body
    resists a horizontal acceleration of `max_base_acceleration_without_motion_g` · g. An acceleration is linear
    between samples, so it is largest at one of them.
    """
    block, look = (
        min(
            int(current_sample) // SAMPLES_PER_REST_CHECK_BLOCK,
            ground_motion.max_abs_vertical_acceleration_by_rest_check.shape[0] - 1,
        ),
        int(current_sample) % SAMPLES_PER_REST_CHECK_BLOCK,
    )
    across, up = (
        ground_motion.max_abs_horizontal_acceleration_by_rest_check[motion_row, block, look],
        ground_motion.max_abs_vertical_acceleration_by_rest_check[block, look],
    )
    return bool(
        abs(amplitude_factor)
        * (across + VERTICAL_ACCELERATION_FACTOR_IN_REST_TEST * max_base_acceleration_without_motion_g * up)
        < max_base_acceleration_without_motion_g * GRAVITY
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def count_skippable_samples(
    ground_motion: BaseAccelerationsAndMaximaInWindowAhead,
    motion_row: int,
    current_sample: float,
    amplitude_factor: float,
    max_base_acceleration_without_motion_g: float,
) -> int:
    """Return the number of samples from the current one on, in whole blocks, in which a body at rest stays at rest.

    The parameters are those of `next_window_motion_is_below_rest_limit`.
    """
    count = 0
    while next_window_motion_is_below_rest_limit(
        ground_motion, motion_row, current_sample + count, amplitude_factor, max_base_acceleration_without_motion_g
    ):
        count += SAMPLES_PER_REST_CHECK_BLOCK
    return count
