"""Cases and times that need no simulation: the input motion is too weak to move the body."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

SIMULATION_START_TO_ONSET_THRESHOLD_RATIO: Final = 0.1
"""Share of the lower threshold at which the simulation of a block starts (docs/design-notes.md explains why not 1)."""

SIMULATED_TIME_BEFORE_START_THRESHOLD_S: Final = 2.0
"""Simulated time before that share is reached, s."""

MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO: Final = 0.5
"""Largest rest threshold of a single body, as a share of its lower threshold of rocking and sliding.

Up to it nothing creeps (docs/method.md). A 3-D body that is simulated while it stands takes sample-long steps below it.
"""

MAX_SCENE_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO: Final = 0.3
"""Largest rest threshold of a scene, as a share of its lower threshold: a joint that has slipped lifts earlier."""

MAX_REST_LIMIT_TO_CORNER_SLIP_ACCELERATION_RATIO: Final = 0.9
"""Upper limit of the rest threshold, as a share of the acceleration at which the lighter corner slips."""


def simulated_sample_ranges_and_stays_at_rest(
    motion: Motion,
    motion_row_by_case: NDArray[np.int64],
    amplitude_factor_by_case: FloatArray,
    unscaled_acceleration_by_azimuth_m_s2: FloatArray,
    rocking_or_sliding_threshold_g_by_case: FloatArray,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Return each case's range of samples to simulate, and whether the block stays at rest for the whole record.

    Outside the range the base motion is too weak to move a block at rest.

    A rigid block cannot start to rock before |a| > (g + a_up) B/H, nor to slide before |a| > μ (g + a_up). Between two
    samples both accelerations are linear in time, so that their ratio is largest at one of the samples.

    Parameters
    ----------
    motion : Motion
        Input motion.
    motion_row_by_case : ndarray, shape (n,)
        Row of `unscaled_acceleration_by_azimuth_m_s2` for each case.
    amplitude_factor_by_case : ndarray, shape (n,)
        Factor on the motion.
    unscaled_acceleration_by_azimuth_m_s2 : ndarray, shape (azimuths, samples)
        Acceleration along each azimuth, m/s².
    rocking_or_sliding_threshold_g_by_case : ndarray, shape (n,)
        min(B/H, μ).

    Returns
    -------
    first, calm : ndarray of int64, shape (n,)
        First sample to compute; sample from which on a block at rest stays at rest.
    stays_at_rest : ndarray of bool, shape (n,)
        True if the motion is below both thresholds for the whole record.
    """
    count = motion_row_by_case.size
    first, calm = np.zeros(count, np.int64), np.zeros(count, np.int64)
    stays_at_rest = np.zeros(count, np.bool_)
    lead = int(np.ceil(SIMULATED_TIME_BEFORE_START_THRESHOLD_S / motion.sampling_interval))
    samples = unscaled_acceleration_by_azimuth_m_s2.shape[1]
    # Without vertical motion the ratio is linear in the amplitude: all amplitudes share one pass over the record.
    keys = [motion_row_by_case] if motion.up is None else [motion_row_by_case, amplitude_factor_by_case]
    order = np.lexsort(keys[::-1])
    changes = np.any([np.diff(key[order]) != 0 for key in keys], axis=0)
    for group in np.split(order, np.flatnonzero(changes) + 1):
        if motion.up is None:
            ratio = np.abs(unscaled_acceleration_by_azimuth_m_s2[motion_row_by_case[group[0]]]) / STANDARD_GRAVITY
            level = rocking_or_sliding_threshold_g_by_case[group] / np.maximum(
                np.abs(amplitude_factor_by_case[group]), 1e-300
            )
        else:
            factor = amplitude_factor_by_case[group[0]]
            weight = STANDARD_GRAVITY + factor * motion.up
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = np.where(
                    weight > 0,
                    np.abs(factor * unscaled_acceleration_by_azimuth_m_s2[motion_row_by_case[group[0]]]) / weight,
                    np.inf,
                )
            level = rocking_or_sliding_threshold_g_by_case[group]
        # Only samples above the lowest level: a running maximum over all samples would take half of the time here.
        safe = SIMULATION_START_TO_ONSET_THRESHOLD_RATIO * level
        loud = np.concatenate([[-1], np.flatnonzero(ratio > safe.min()), [samples]])
        rising = np.maximum.accumulate(ratio[loud[1:-1]])
        falling = np.maximum.accumulate(ratio[loud[-2:0:-1]])
        stays_at_rest[group] = ratio.max() <= level
        first[group] = np.maximum(loud[1:][np.searchsorted(rising, safe, side="right")] - 1 - lead, 0)
        # One more sample: the motion is linear from the last strong sample to the next.
        calm[group] = np.minimum(loud[-2::-1][np.searchsorted(falling, safe, side="right")] + 2, samples)
    return first, calm, stays_at_rest


def largest_acceleration_without_motion_g(
    rocking_threshold_g: FloatArray,
    sliding_threshold_g: FloatArray,
    first_corner_unloading_acceleration_g: FloatArray,
    max_dynamic_to_static_force_ratio: FloatArray,
    max_rest_to_onset_threshold_ratio: float,
) -> FloatArray:
    """Return the base acceleration |a|/g up to which a body at rest stays at rest, so that samples can be skipped.

    Parameters
    ----------
    rocking_threshold_g, sliding_threshold_g : ndarray
        Accelerations, over g, at which the rigid body starts to rock and to slide.
    first_corner_unloading_acceleration_g : ndarray
        Acceleration, over g, at which its first corner is unloaded on springs.
    max_dynamic_to_static_force_ratio : ndarray
        Largest ratio of dynamic to static contact force; see `dynamic_to_static_force_ratio_upper_bound`.
    max_rest_to_onset_threshold_ratio : float
        Upper limit of the result, as a share of the lower of `rocking_threshold_g` and `sliding_threshold_g`.
    """
    with np.errstate(divide="ignore"):
        creeps = 1.0 / (
            1.0 / np.maximum(first_corner_unloading_acceleration_g, 0.0) + 1.0 / np.maximum(sliding_threshold_g, 0.0)
        )
    return np.asarray(
        np.minimum(
            max_rest_to_onset_threshold_ratio * np.minimum(rocking_threshold_g, sliding_threshold_g),
            MAX_REST_LIMIT_TO_CORNER_SLIP_ACCELERATION_RATIO * creeps / max_dynamic_to_static_force_ratio,
        )
    )


def dynamic_to_static_force_ratio_upper_bound(
    omega_squared_of_lowest_mode: FloatArray, dashpot_to_spring_ratio_s: FloatArray | float, sampling_interval: float
) -> FloatArray:
    """Return an upper bound of the ratio of a contact force in base motion to its static value at peak acceleration.

    The result is the lower of two bounds. The first, for any motion, is the integral of |h|, where h is the force after
    an impulse of the base. The second is for a motion that is linear between samples: each kink of the motion excites
    a vibration of amplitude 4/x, x = ω Δt, over the static value, which decays by exp(−ξ x) per sample.

    Parameters
    ----------
    omega_squared_of_lowest_mode : ndarray
        ω² of the slowest mode, 1/s².
    dashpot_to_spring_ratio_s : ndarray or float
        Ratio of dashpot to spring constants, s; the damping ratio ξ is ω/2 times this ratio.
    sampling_interval : float
        Time between samples, s.
    """
    frequency = np.sqrt(omega_squared_of_lowest_mode)
    damping, phase = np.clip(0.5 * frequency * dashpot_to_spring_ratio_s, 1e-6, 0.999), frequency * sampling_interval
    fast = np.sqrt(1.0 - damping**2)
    first = (np.pi - 2.0 * np.arcsin(damping)) / fast
    any_motion = 1.0 + 2.0 * np.exp(-damping * first) / -np.expm1(-np.pi * damping / fast)
    with np.errstate(divide="ignore"):  # frequency 0: a body on one corner
        bent = 1.0 + 4.0 / (phase * -np.expm1(-damping * phase))
    # Rounded, since libm and SIMD versions differ in the last digit between processors.
    return np.asarray(np.round(np.minimum(any_motion, bent), 6))
