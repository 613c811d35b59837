"""Which way a motion goes: where its peaks point, and the axis and period of its strongest velocity pulse."""

import numpy as np

from overturning.arrays import FloatArray
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion

PULSE_PERIODS = np.geomspace(0.4, 12.0, 36)
"""Periods among which that of the pulse is sought, s: 10 % apart."""

SPREAD = 0.24
"""Standard deviation of the wavelet's envelope, in periods: about one cycle is heard."""


def peak_azimuths(motion: Motion) -> dict[str, float]:
    """Azimuths to which the horizontal acceleration and velocity point at their peaks, degrees; NaN without motion."""
    acceleration = motion.horizontal
    velocity = integrate(acceleration, motion.sampling_interval)
    return {name: _largest(series) for name, series in (("pga", acceleration), ("pgv", velocity))}


def _largest(series: FloatArray) -> float:
    square = (series**2).sum(axis=0)
    at = int(square.argmax())
    return _azimuth(*series[:, at]) if square[at] > 0 else float("nan")


def _azimuth(north: float, east: float) -> float:
    return float(np.round(np.degrees(np.arctan2(east, north)) % 360.0, 6) % 360.0)


def pulse_axis(motion: Motion) -> tuple[float, float]:
    """Axis (degrees, 0 to 180) and period (s) of the strongest pulse in the velocity of a motion; NaN without motion.

    The wavelet coefficient that is largest over times, periods and horizontal directions, as Shahi and Baker (2014,
    Bulletin of the Seismological Society of America 104) choose theirs; the wavelet is a complex Gabor one of unit
    energy, so that the phase of the pulse does not matter. In the direction at φ the coefficient is that of north times
    cos φ plus that of east times sin φ; the axis maximises its magnitude.
    """
    velocity = integrate(motion.horizontal, motion.sampling_interval)
    if not np.abs(velocity).max() > 0:
        return float("nan"), float("nan")
    step = max(1, int(np.floor(0.1 * PULSE_PERIODS[0] / motion.sampling_interval)))
    interval, series = step * motion.sampling_interval, velocity[:, ::step]
    count = 2 * series.shape[1] + int(6.0 * PULSE_PERIODS[-1] / interval)
    spectrum = np.fft.fft(series, count)
    frequency = np.fft.fftfreq(count, interval)
    best, found = 0.0, (float("nan"), float("nan"))
    for period in PULSE_PERIODS:
        spread = SPREAD * period
        window = np.sqrt(spread) * np.exp(-0.5 * (2.0 * np.pi * spread * (frequency - 1.0 / period)) ** 2)
        north, east = np.fft.ifft(spectrum * window)[:, : series.shape[1]]
        # |n cos φ + e sin φ|² = (nn + ee)/2 + (nn − ee)/2 cos 2φ + Re(n e*) sin 2φ, largest at this:
        difference, product = 0.5 * (np.abs(north) ** 2 - np.abs(east) ** 2), (north * east.conj()).real
        strength = 0.5 * (np.abs(north) ** 2 + np.abs(east) ** 2) + np.hypot(difference, product)
        at = int(strength.argmax())
        if strength[at] > best * (1.0 + 1e-9):
            best = float(strength[at])
            axis = 0.5 * np.degrees(np.arctan2(product[at], difference[at])) % 180.0
            found = (float(np.round(axis, 4) % 180.0), float(period))
    return found
