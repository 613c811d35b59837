"""Stable time step, and number of steps per sample of the record."""

from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.units import STANDARD_GRAVITY


class IntegrationScheme(IntEnum):
    """Time integration scheme of a simulation; its value is the scheme's number in the compiled kernels."""

    CUNDALL = 0
    CENTRED = 1


DAMPING_RATIO_ABOVE_WHICH_CENTRED_STEP_SHRINKS: Final = 2.0
"""Damping ratio ξ of the highest mode above which the centred scheme shortens the contact step in proportion to 1/ξ.

A longer step would be stable, but contact and slip are predicted from the velocity, which strong dashpots change too
much within the step.
"""

MAX_STEP_OVER_ROCKING_TIME_CONSTANT: Final = 0.006
"""Longest step that resolves the motion of a block between contact changes, in 1/p with p = √(3g/4R).

The centred scheme is stable with any step and any contact stiffness (docs/method.md).
"""

DAMPING_RATIO_BELOW_WHICH_CUNDALL_STEP_HALVES: Final = 0.25
"""Damping ratio of the highest mode below which Cundall's scheme uses half of the automatic step."""

DEFAULT_SCHEME: Final = "centred"

AUTO_TO_STABLE_STEP_RATIO: Final = {IntegrationScheme.CUNDALL: 0.5, IntegrationScheme.CENTRED: 1.0}
"""Step of ``time_step="auto"`` as a fraction of the stable step (docs/measurements.md shows how it was chosen)."""

SCENE_AUTO_TO_STABLE_STEP_RATIO: Final = 0.5
"""Step of ``time_step="auto"`` for a scene with Cundall's scheme, as a fraction of the stable step."""

MAX_STEPS_PER_SAMPLE: Final = 2_000_000
"""Largest number of steps per sample; more would take too long to compute."""


def parse_scheme(scheme_name: str) -> IntegrationScheme:
    """Return the time integration scheme with the given name; raise an `ArgumentError` for other names.

    Raises
    ------
    ArgumentError
        If no scheme has this name.
    """
    try:
        return IntegrationScheme[scheme_name.upper()]
    except (KeyError, AttributeError):
        known = ", ".join(scheme.name.lower() for scheme in IntegrationScheme)
        raise ArgumentError(f"scheme: {scheme_name!r}; known: {known}") from None


def block_highest_eigenvalue_bound(
    normal_stiffness_or_dashpot_per_mass: FloatArray,
    tangential_stiffness_or_dashpot_per_mass: FloatArray,
    half_width: FloatArray,
    half_height: FloatArray,
) -> FloatArray:
    """Return an upper bound of the highest ω² (from dashpots: 2ξω) of a block on two corners (upright) or on one.

    Upright, heave has the eigenvalue 2 K_n/m; sway and rocking are coupled. On one corner, a rectangle has 4 K/m if
    both springs have the stiffness K, and at most 4 max(K_n, K_s)/m otherwise.

    Parameters
    ----------
    normal_stiffness_or_dashpot_per_mass, tangential_stiffness_or_dashpot_per_mass : ndarray
        K_n/m and K_s/m, 1/s², or dashpots per mass, 1/s.
    half_width, half_height : ndarray
        Half width b and half height h, m.

    Returns
    -------
    ndarray
        ω², 1/s², or from dashpots 2ξω, 1/s.
    """
    per_inertia = 3.0 / (half_width**2 + half_height**2)
    sway = 2.0 * tangential_stiffness_or_dashpot_per_mass
    rock = (
        2.0
        * per_inertia
        * (
            tangential_stiffness_or_dashpot_per_mass * half_height**2
            + normal_stiffness_or_dashpot_per_mass * half_width**2
        )
    )
    coupling = 4.0 * per_inertia * (tangential_stiffness_or_dashpot_per_mass * half_height) ** 2
    # √((a−b)²/4 + c²) avoids the cancellation in √(trace² − 4 det).
    upright = 0.5 * (sway + rock) + np.sqrt(0.25 * (sway - rock) ** 2 + coupling)
    return np.maximum(
        np.maximum(upright, 2.0 * normal_stiffness_or_dashpot_per_mass),
        4.0 * np.maximum(normal_stiffness_or_dashpot_per_mass, tangential_stiffness_or_dashpot_per_mass),
    )


def block_lowest_eigenvalue(
    normal_stiffness_per_mass: FloatArray,
    tangential_stiffness_per_mass: FloatArray,
    half_width: FloatArray,
    half_height: FloatArray,
) -> FloatArray:
    """Return the lowest eigenvalue ω² (1/s²) of a block standing on both corners: heave, or sway with rocking.

    Parameters are those of `block_highest_eigenvalue_bound`.
    """
    per_inertia = 3.0 / (half_width**2 + half_height**2)
    sway = 2.0 * tangential_stiffness_per_mass
    rock = (
        2.0 * per_inertia * (tangential_stiffness_per_mass * half_height**2 + normal_stiffness_per_mass * half_width**2)
    )
    coupling = 4.0 * per_inertia * (tangential_stiffness_per_mass * half_height) ** 2
    upright = 0.5 * (sway + rock) + np.sqrt(0.25 * (sway - rock) ** 2 + coupling)
    # The product of both coupled eigenvalues is the determinant, from which rocking on tangential springs cancels.
    return np.minimum(
        4.0 * per_inertia * tangential_stiffness_per_mass * normal_stiffness_per_mass * half_width**2 / upright,
        2.0 * normal_stiffness_per_mass,
    )


def rocking_time_constant(width: FloatArray, height: FloatArray) -> FloatArray:
    """Return 1/p of a rocking block, s, with p = √(3g/4R) and R half its diagonal, m (Housner 1963)."""
    return np.asarray(np.sqrt(np.sqrt(width**2 + height**2) / (1.5 * STANDARD_GRAVITY)))


def longest_stable_or_accurate_step(
    scheme: IntegrationScheme,
    omega_squared_of_highest_mode: FloatArray,
    two_xi_omega_of_highest_mode: FloatArray,
    block_rocking_time_constant_by_case_s: FloatArray | None = None,
) -> FloatArray:
    """Return the longest time step of each case, s, that is stable and, for a block in the centred scheme, accurate.

    With ω and the damping ratio ξ_max of the highest mode, Cundall's scheme, whose dashpots lag by half a step,
    requires Δt ≤ (2/ω)(√(1 + ξ_max²) − ξ_max). The centred scheme evaluates the dashpots at the end of the
    step. For a scene this requires Δt ≤ 2/ω, less if ξ_max exceeds
    `DAMPING_RATIO_ABOVE_WHICH_CENTRED_STEP_SHRINKS`. For a block the springs too are evaluated at the end of the step,
    so only the resolution of the motion limits the step (`MAX_STEP_OVER_ROCKING_TIME_CONSTANT`).

    Parameters
    ----------
    scheme : IntegrationScheme
        The integration scheme.
    omega_squared_of_highest_mode : ndarray
        ω² of the highest mode, 1/s².
    two_xi_omega_of_highest_mode : ndarray
        2 ξ_max ω of the highest mode, 1/s.
    block_rocking_time_constant_by_case_s : ndarray, optional
        1/p of the block, s (`rocking_time_constant`); None for a scene.
    """
    if scheme == IntegrationScheme.CUNDALL:
        return 4.0 / (
            np.sqrt(two_xi_omega_of_highest_mode**2 + 4.0 * omega_squared_of_highest_mode)
            + two_xi_omega_of_highest_mode
        )
    return (
        2.0
        * inverse_contact_frequency_reduced_at_high_damping(omega_squared_of_highest_mode, two_xi_omega_of_highest_mode)
        if block_rocking_time_constant_by_case_s is None
        else MAX_STEP_OVER_ROCKING_TIME_CONSTANT * block_rocking_time_constant_by_case_s
    )


def inverse_contact_frequency_reduced_at_high_damping(
    omega_squared_of_highest_mode: FloatArray, two_xi_omega_of_highest_mode: FloatArray
) -> FloatArray:
    """Return 1/ω of the highest contact mode, s, times ξ₀/ξ if its damping ratio ξ exceeds ξ₀.

    ξ₀ is `DAMPING_RATIO_ABOVE_WHICH_CENTRED_STEP_SHRINKS`.
    """
    frequency = np.sqrt(omega_squared_of_highest_mode)
    return np.asarray(
        DAMPING_RATIO_ABOVE_WHICH_CENTRED_STEP_SHRINKS
        / np.maximum(0.5 * two_xi_omega_of_highest_mode / frequency, DAMPING_RATIO_ABOVE_WHICH_CENTRED_STEP_SHRINKS)
        / frequency
    )


def steps_per_sample(
    scheme: IntegrationScheme,
    requested_time_step: float | str,
    omega_squared_of_highest_mode: FloatArray,
    two_xi_omega_of_highest_mode: FloatArray,
    sampling_interval: float,
    block_rocking_time_constant_by_case_s: FloatArray | None = None,
) -> NDArray[np.int64]:
    """Return the number of time steps per sample of the record for each case, from the requested time step.

    The number depends only on the case and the sampling interval.

    Parameters
    ----------
    scheme : IntegrationScheme
        The integration scheme.
    requested_time_step : float or str
        Largest step, s; "auto"; or a fraction of the stable step such as "0.25 stable".
    omega_squared_of_highest_mode, two_xi_omega_of_highest_mode : ndarray
        ω² (1/s²) and 2 ξ_max ω (1/s) of the highest mode; see `longest_stable_or_accurate_step`.
    sampling_interval : float
        Time between samples, s.
    block_rocking_time_constant_by_case_s : ndarray, optional
        1/p of the block, s; None for a scene.

    Returns
    -------
    ndarray of int64
        Numbers with at most five significant binary digits, rounded up, so that cases with similar steps share a queue.

    Raises
    ------
    ArgumentError
        If the step exceeds the stable step, or a sample would take more than `MAX_STEPS_PER_SAMPLE` steps.
    """
    stable = longest_stable_or_accurate_step(
        scheme, omega_squared_of_highest_mode, two_xi_omega_of_highest_mode, block_rocking_time_constant_by_case_s
    )
    return steps_per_sample_from_stable_step(
        stable,
        stable
        * _automatic_to_stable_step_ratio(
            scheme, omega_squared_of_highest_mode, two_xi_omega_of_highest_mode, block_rocking_time_constant_by_case_s
        ),
        requested_time_step,
        sampling_interval,
    )


def steps_per_sample_from_stable_step(
    stable_step_by_case_s: FloatArray,
    automatic_step_by_case_s: FloatArray,
    requested_time_step: float | str,
    sampling_interval: float,
) -> NDArray[np.int64]:
    """Return each case's number of time steps per sample of the record, given its stable step and that for "auto".

    Other parameters and exceptions are those of `steps_per_sample`.
    """
    least = float(np.min(stable_step_by_case_s))
    if requested_time_step == "auto":
        step = automatic_step_by_case_s
    elif isinstance(requested_time_step, str):
        step = stable_step_by_case_s * _parse_fraction_of_stable_step(requested_time_step)
    else:
        if not (np.isfinite(requested_time_step) and requested_time_step > 0):
            raise ArgumentError(f"time_step: {requested_time_step}; it must be a positive number of seconds, or 'auto'")
        if requested_time_step > least:
            raise ArgumentError(f"time_step: {requested_time_step:g} s is not stable; at most {least:.4g} s, or 'auto'")
        step = np.full_like(stable_step_by_case_s, requested_time_step)
    shortest = sampling_interval / MAX_STEPS_PER_SAMPLE
    if np.min(step) < shortest <= np.min(automatic_step_by_case_s):
        raise ArgumentError(
            f"time_step: {requested_time_step!r}, a time step of {np.min(step):.3g} s, would take more than "
            f"{MAX_STEPS_PER_SAMPLE} steps per sample of {sampling_interval:g} s; at least {shortest:.3g} s, or 'auto'"
        )
    if np.min(step) < shortest:
        raise ArgumentError(
            f"contact: a time step of {np.min(step):.3g} s would take more than {MAX_STEPS_PER_SAMPLE} steps per "
            f"sample of {sampling_interval:g} s; choose less damping, a softer contact or a larger step"
        )
    steps = np.ceil(sampling_interval / step * (1.0 - 1e-12)).astype(np.int64)
    steps = np.maximum(steps, 1)
    # np.frexp returns the exact binary exponent; five significant binary digits remain.
    unit = np.int64(1) << np.maximum(np.frexp(steps.astype(np.float64))[1] - 5, 0).astype(np.int64)
    return (steps + unit - 1) // unit * unit


def requested_to_automatic_step_ratio(
    scheme: IntegrationScheme, requested_time_step: float | str, stable_step_by_case_s: FloatArray
) -> FloatArray | float:
    """Return the ratio of requested to automatic time step, for each block; 1 if the request is "auto"."""
    if requested_time_step == "auto":
        return 1.0
    wanted = (
        _parse_fraction_of_stable_step(requested_time_step)
        if isinstance(requested_time_step, str)
        else np.minimum(requested_time_step / stable_step_by_case_s, 1.0)
    )
    return wanted / AUTO_TO_STABLE_STEP_RATIO[scheme]


def _automatic_to_stable_step_ratio(
    scheme: IntegrationScheme,
    omega_squared_of_highest_mode: FloatArray,
    two_xi_omega_of_highest_mode: FloatArray,
    block_rocking_time_constant_by_case_s: FloatArray | None,
) -> FloatArray | float:
    """Return the automatic time step of each case as a fraction of its longest stable step."""
    # Chosen from the tables in docs/measurements.md, "The default step".
    if block_rocking_time_constant_by_case_s is not None and scheme == IntegrationScheme.CENTRED:
        return AUTO_TO_STABLE_STEP_RATIO[scheme]
    fraction = (
        SCENE_AUTO_TO_STABLE_STEP_RATIO
        if block_rocking_time_constant_by_case_s is None
        else AUTO_TO_STABLE_STEP_RATIO[scheme]
    )
    return np.where(
        0.5 * two_xi_omega_of_highest_mode / np.sqrt(omega_squared_of_highest_mode)
        < DAMPING_RATIO_BELOW_WHICH_CUNDALL_STEP_HALVES,
        0.5 * fraction,
        fraction,
    )


def _parse_fraction_of_stable_step(text: str) -> float:
    """Return the number in a text such as ``0.25 stable``; raise an `ArgumentError` for any other text."""
    number, _, word = text.partition(" ")
    try:
        fraction = float(number)
    except ValueError:
        fraction = float("nan")
    if word != "stable" or not 0 < fraction <= 1:
        raise ArgumentError(f"time_step: {text!r}; give seconds, 'auto', or a fraction such as '0.25 stable'")
    return fraction
