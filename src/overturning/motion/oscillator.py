"""Response of a damped oscillator to ground acceleration that is linear between samples.

The method is that of Nigam & Jennings (1969, BSSA 59, 909-922), written as a recursive filter of second order. The
recorded motion is band-limited, not linear between samples, and the peak of the response may also lie between samples.
Therefore the motion is interpolated first (zero-padded Fourier transform): for short periods to 64 points per period
(or the number requested), and for long sampling intervals to steps of at most 0.0025 s, but at most 16 points per
sample.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray, convert_argument_to_float_array
from overturning.errors import ArgumentError

ResponseQuantity = Literal["displacement", "velocity"]

INTERPOLATED_POINTS_PER_OSCILLATOR_PERIOD = 64
"""Points per period of an oscillator; the peak of a sine of that period is then at most 0.12 % too low."""

MAX_INTERPOLATION_STEP_S = 0.0025
"""Longest step between two points of the interpolated motion, s.

Linear interpolation at this step keeps 98.7 % of the amplitude at 25 Hz, the Nyquist frequency of samples of 20 ms.
Linear interpolation between samples of 20 ms would keep 41 % and make the spectrum intensity up to 5.2 % too low.
"""

MAX_INTERPOLATED_POINTS_PER_SAMPLE = 16
"""Largest number of points of the interpolated motion per sample."""


MAX_OSCILLATOR_PERIOD_S = 1000.0
"""Longest period of an oscillator, s; with a longer one, the time after the motion has too many samples."""


def checked_periods(period_s: ArrayLike) -> FloatArray:
    """Return periods, s, as a one-dimensional array; raise an ArgumentError unless all are positive and in bounds."""
    periods = np.atleast_1d(convert_argument_to_float_array("period_s", period_s))
    if periods.ndim != 1 or periods.size == 0 or not ((periods > 0) & (periods <= MAX_OSCILLATOR_PERIOD_S)).all():
        raise ArgumentError(
            f"period_s: give one or more positive numbers of seconds, at most {MAX_OSCILLATOR_PERIOD_S:g}, in one row"
        )
    return periods


@lru_cache(maxsize=4096)
def oscillator_filter_coefficients(
    period_s: float, damping_ratio: float, sampling_interval: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return coefficients of the filters from ground acceleration to oscillator displacement and velocity.

    The three arrays of shape (3,) are the numerator for relative displacement, the numerator for relative velocity, and
    their common denominator.

    For d̈ + 2hωḋ + ω²d = −a, with damping ratio h, the displacement d and velocity v at the next sample are
    A (d, v) + B₀ a_k + B₁ a_(k+1). A is the exponential of the system matrix times the sampling interval. The
    z-transform of this recursion gives the coefficients.
    """
    omega = 2.0 * math.pi / period_s
    free = omega * math.sqrt(1.0 - damping_ratio**2)
    decay = math.exp(-damping_ratio * omega * sampling_interval)
    c, s = decay * math.cos(free * sampling_interval), decay * math.sin(free * sampling_interval) / free
    # A = exp(M Δt) of the system matrix M = [[0, 1], [−ω², −2hω]].
    matrix = np.array([[c + damping_ratio * omega * s, s], [-(omega**2) * s, c - damping_ratio * omega * s]])
    inverse = np.array([[-2.0 * damping_ratio / omega, -1.0 / omega**2], [1.0, 0.0]])
    force = np.array([0.0, -1.0])
    # Response to a constant and to a unit slope: ∫ A(1 − s) ds and ∫ A(1 − s) s ds over a sample, by force.
    constant = inverse @ (matrix - np.eye(2)) @ force
    slope = inverse @ (constant / sampling_interval - force)
    before = constant - slope
    trace = float(matrix[0, 0] + matrix[1, 1])
    determinant = float(matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0])
    reduced = matrix - trace * np.eye(2)
    numerators = np.stack([slope, before + reduced @ slope, reduced @ before])
    return numerators[:, 0].copy(), numerators[:, 1].copy(), np.array([1.0, -trace, determinant])


class OscillatorResponseCalculator:
    """Calculator of the peak responses of linear oscillators of any period to one horizontal motion.

    The motion is given in m/s², shape (2, n). The response may peak after the motion has ended, but a free vibration
    of period T peaks within T/2. With the longest period T, zeros are therefore appended for min(T, 10 s), or for T/2
    if this is longer.
    """

    def __init__(
        self,
        north_and_east_acceleration: FloatArray,
        sampling_interval: float,
        longest_oscillator_period_s: float,
        interpolated_points_per_oscillator_period: int = INTERPOLATED_POINTS_PER_OSCILLATOR_PERIOD,
    ) -> None:
        self._points = interpolated_points_per_oscillator_period
        rest = math.ceil(
            max(min(longest_oscillator_period_s, 10.0), 0.5 * longest_oscillator_period_s) / sampling_interval
        )
        self._samples = north_and_east_acceleration.shape[1]
        self._components = np.pad(north_and_east_acceleration, ((0, 0), (0, rest)))
        self._interval = sampling_interval
        self._finer: dict[int, FloatArray] = {1: self._components}

    def _interpolated_components(self, interpolated_points_per_sample: int) -> FloatArray:
        if interpolated_points_per_sample not in self._finer:
            from scipy.fft import irfft, next_fast_len, rfft

            # scipy.signal.resample, with the same bits: importing it takes longer than the spectra of a record.
            count = self._components.shape[1]
            length = next_fast_len(count, real=True)
            spectrum = rfft(np.pad(self._components, ((0, 0), (0, length - count))))
            if length % 2 == 0:  # the finer motion has twice the component at the old Nyquist frequency
                spectrum[:, -1] *= 0.5
            finer = irfft(spectrum / (1.0 / interpolated_points_per_sample), n=length * interpolated_points_per_sample)
            self._finer[interpolated_points_per_sample] = finer[:, : count * interpolated_points_per_sample]
        return self._finer[interpolated_points_per_sample]

    def interpolated_points_per_sample_for_period(self, period_s: float) -> int:
        """Return the points per sample (1, 2, 4, 8 or 16) of the interpolated motion for an oscillator period, s."""
        wanted = self._interval * max(
            self._points / max(period_s, 3.0 * self._interval), 1.0 / MAX_INTERPOLATION_STEP_S
        )
        return min(MAX_INTERPOLATED_POINTS_PER_SAMPLE, 2 ** max(0, math.ceil(math.log2(wanted))))

    def peak_responses(
        self,
        period_s: float,
        damping_ratio: float,
        response_quantities: Sequence[ResponseQuantity],
        north_east_cosines_by_azimuth: FloatArray,
    ) -> FloatArray:
        """Return an oscillator's peak relative displacement (m) or velocity (m/s) along m azimuths.

        The result has a row for each of `response_quantities` and a column for each azimuth. Each row of
        `north_east_cosines_by_azimuth`, shape (m, 2), has the direction cosines of an azimuth towards north and east.
        """
        from overturning.motion.peaks import largest_filtered_motion_along_azimuths

        if not 0 <= damping_ratio < 1:
            raise ArgumentError(f"damping: {damping_ratio}; give a ratio from 0 to below 1")
        factor = self.interpolated_points_per_sample_for_period(period_s)
        # The free response decays: its peak lies within one period after the end of the motion.
        until = self._samples + math.ceil(period_s / self._interval)
        motion = self._interpolated_components(factor)[:, : factor * until]
        displacement, velocity, below = oscillator_filter_coefficients(period_s, damping_ratio, self._interval / factor)
        above = {"displacement": displacement, "velocity": velocity}
        return np.stack(
            [
                largest_filtered_motion_along_azimuths(motion, above[quantity], below, north_east_cosines_by_azimuth)
                for quantity in response_quantities
            ]
        )
