"""The stable time step, and how many steps a case takes per sample of its record."""

from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.units import STANDARD_GRAVITY


class Scheme(IntEnum):
    """Integration schemes, by the number under which the kernel knows them."""

    CUNDALL = 0
    CENTRED = 1


HEAVY_DAMPING: Final = 2.0
"""Above this damping ratio of the highest mode the step in which the centred scheme lets a contact change shrinks in
proportion to its inverse: it would stay stable, but which corners press and slip is guessed from a velocity that the
dashpots change too much."""

MAX_ROCKING_STEP: Final = 0.006
"""The centred scheme is stable with any step; this one, in 1/p with p = √(3g/4R), is the longest that follows the
motion of a block between changes of contact, whatever the contact's stiffness (docs/method.md)."""

BARE_DAMPING: Final = 0.25
"""Below this damping ratio of the highest mode Cundall's scheme takes half the automatic step."""

DEFAULT_SCHEME: Final = "centred"

AUTO_FRACTION: Final = {Scheme.CUNDALL: 0.5, Scheme.CENTRED: 1.0}
"""The step of ``time_step="auto"`` as a fraction of the stable one (docs/measurements.md shows how it was chosen)."""

SCENE_FRACTION: Final = 0.5
"""The same for a scene of polygons with Cundall's scheme."""

MAX_STEPS_PER_SAMPLE: Final = 2_000_000
"""More than this cannot be resolved in any reasonable time."""


def parse_scheme(name: str) -> Scheme:
    """The scheme of a name.

    Raises
    ------
    ArgumentError
        If there is none.
    """
    try:
        return Scheme[name.upper()]
    except (KeyError, AttributeError):
        known = ", ".join(scheme.name.lower() for scheme in Scheme)
        raise ArgumentError(f"scheme: {name!r}; known: {known}") from None


def highest_eigenvalue(
    normal: FloatArray, tangential: FloatArray, half_width: FloatArray, half_height: FloatArray
) -> FloatArray:
    """Highest eigenvalue of the upright block on both corners, and of the tilted one on one corner.

    Upright, heave has 2 K_n/m; sway and rocking couple. On one corner, mass and inertia of a rectangle seen from the
    corner give K/m · (1 + 3) where both springs are equal, and no more than 4 max(K_n, K_s)/m for any pair.

    Parameters
    ----------
    normal, tangential : ndarray
        K_n/m and K_s/m, or dashpots per mass.
    half_width, half_height : ndarray
        b and h, m.

    Returns
    -------
    ndarray
        ω² in 1/s² (or twice the damping rate for dashpots, 1/s).
    """
    per_inertia = 3.0 / (half_width**2 + half_height**2)
    sway = 2.0 * tangential
    rock = 2.0 * per_inertia * (tangential * half_height**2 + normal * half_width**2)
    coupling = 4.0 * per_inertia * (tangential * half_height) ** 2
    # √((a−b)²/4 + c²) keeps its digits where √(trace² − 4 det) loses them.
    upright = 0.5 * (sway + rock) + np.sqrt(0.25 * (sway - rock) ** 2 + coupling)
    return np.maximum(np.maximum(upright, 2.0 * normal), 4.0 * np.maximum(normal, tangential))


def lowest_eigenvalue(
    normal: FloatArray, tangential: FloatArray, half_width: FloatArray, half_height: FloatArray
) -> FloatArray:
    """Lowest eigenvalue of the upright block on both corners, ω² in 1/s²: heave, or sway with rocking.

    Parameters as of `highest_eigenvalue`.
    """
    per_inertia = 3.0 / (half_width**2 + half_height**2)
    sway = 2.0 * tangential
    rock = 2.0 * per_inertia * (tangential * half_height**2 + normal * half_width**2)
    coupling = 4.0 * per_inertia * (tangential * half_height) ** 2
    upright = 0.5 * (sway + rock) + np.sqrt(0.25 * (sway - rock) ** 2 + coupling)
    # The product of both is the determinant, in which rocking on the tangential springs cancels.
    return np.minimum(4.0 * per_inertia * tangential * normal * half_width**2 / upright, 2.0 * normal)


def rocking_time(width: FloatArray, height: FloatArray) -> FloatArray:
    """1/p of a rocking block, s: p = √(3g/4R), R half the diagonal (Housner 1963)."""
    return np.asarray(np.sqrt(np.sqrt(width**2 + height**2) / (1.5 * STANDARD_GRAVITY)))


def stable_step(scheme: Scheme, square: FloatArray, rate: FloatArray, period: FloatArray | None = None) -> FloatArray:
    """Largest stable time step, s.

    Cundall's scheme, whose dashpot lags by half a step, needs Δt ≤ (2/ω)(√(1 + ξ_max²) − ξ_max). The centred
    scheme takes the dashpots at the end of the step. For a scene of polygons that leaves Δt ≤ 2/ω, less where
    ξ_max is above `HEAVY_DAMPING`; for a block it takes the springs there, too, and is limited by the motion alone,
    `MAX_ROCKING_STEP`.

    Parameters
    ----------
    scheme : Scheme
        The integration scheme.
    square : ndarray
        ω² of the highest mode, 1/s².
    rate : ndarray
        2 ξ_max ω of the highest mode, 1/s.
    period : ndarray, optional
        1/p of the block, s (`rocking_time`); None for a scene of polygons.
    """
    if scheme == Scheme.CUNDALL:
        return 4.0 / (np.sqrt(rate**2 + 4.0 * square) + rate)
    return 2.0 * contact_time(square, rate) if period is None else MAX_ROCKING_STEP * period


def contact_time(square: FloatArray, rate: FloatArray) -> FloatArray:
    """1/ω of a contact's highest mode, s, less where ξ_max is above `HEAVY_DAMPING`; see `stable_step`."""
    frequency = np.sqrt(square)
    return np.asarray(HEAVY_DAMPING / np.maximum(0.5 * rate / frequency, HEAVY_DAMPING) / frequency)


def steps_per_sample(
    scheme: Scheme,
    time_step: float | str,
    square: FloatArray,
    rate: FloatArray,
    sampling_interval: float,
    period: FloatArray | None = None,
) -> NDArray[np.int64]:
    """Whole steps per sample, a function of the case and the record's sampling interval alone.

    Parameters
    ----------
    scheme : Scheme
        The integration scheme.
    time_step : float or str
        Largest step, s; "auto"; or a fraction of the stable step such as "0.25 stable".
    square, rate : ndarray
        As for `stable_step`.
    sampling_interval : float
        s.
    period : ndarray, optional
        As for `stable_step`.

    Returns
    -------
    ndarray of int64
        Rounded up to a number with at most five binary digits, so that cases with nearly equal steps share a queue.

    Raises
    ------
    ArgumentError
        If the step is above the stable one, or so small that a sample takes millions.
    """
    stable = stable_step(scheme, square, rate, period)
    return steps_from_stable(stable, stable * _automatic(scheme, square, rate, period), time_step, sampling_interval)


def steps_from_stable(
    stable: FloatArray, automatic: FloatArray, time_step: float | str, sampling_interval: float
) -> NDArray[np.int64]:
    """Steps per sample for a stable and an automatic step, s; the rest and the errors as of `steps_per_sample`."""
    least = float(np.min(stable))
    if time_step == "auto":
        step = automatic
    elif isinstance(time_step, str):
        step = stable * _fraction(time_step)
    else:
        if not (np.isfinite(time_step) and time_step > 0):
            raise ArgumentError(f"time_step: {time_step}; it must be a positive number of seconds, or 'auto'")
        if time_step > least:
            raise ArgumentError(f"time_step: {time_step:g} s is not stable; at most {least:.4g} s, or 'auto'")
        step = np.full_like(stable, time_step)
    if np.min(step) * MAX_STEPS_PER_SAMPLE < sampling_interval:
        raise ArgumentError(
            f"contact: a time step of {np.min(step):.3g} s would take more than {MAX_STEPS_PER_SAMPLE} steps per "
            f"sample of {sampling_interval:g} s; choose less damping, a softer contact or a larger step"
        )
    steps = np.ceil(sampling_interval / step * (1.0 - 1e-12)).astype(np.int64)
    steps = np.maximum(steps, 1)
    # np.frexp is exact: the exponent of the number, five digits of which are kept.
    unit = np.int64(1) << np.maximum(np.frexp(steps.astype(np.float64))[1] - 5, 0).astype(np.int64)
    return (steps + unit - 1) // unit * unit


def step_reduction(scheme: Scheme, time_step: float | str, stable: FloatArray) -> FloatArray | float:
    """By how much a wanted step is shorter than the automatic one of a block; checked by `steps_per_sample`."""
    if time_step == "auto":
        return 1.0
    wanted = _fraction(time_step) if isinstance(time_step, str) else np.minimum(time_step / stable, 1.0)
    return wanted / AUTO_FRACTION[scheme]


def _automatic(scheme: Scheme, square: FloatArray, rate: FloatArray, period: FloatArray | None) -> FloatArray | float:
    # docs/measurements.md, "The default step", has the tables from which these were read.
    if period is not None and scheme == Scheme.CENTRED:
        return AUTO_FRACTION[scheme]
    fraction = SCENE_FRACTION if period is None else AUTO_FRACTION[scheme]
    return np.where(0.5 * rate / np.sqrt(square) < BARE_DAMPING, 0.5 * fraction, fraction)


def _fraction(text: str) -> float:
    number, _, word = text.partition(" ")
    try:
        fraction = float(number)
    except ValueError:
        fraction = float("nan")
    if word != "stable" or not 0 < fraction <= 1:
        raise ArgumentError(f"time_step: {text!r}; give seconds, 'auto', or a fraction such as '0.25 stable'")
    return fraction
