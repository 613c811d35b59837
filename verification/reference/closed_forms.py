"""Closed forms of the rigid block (Housner 1963) and of a damped spring, for comparison with the kernel.

Angles in rad, positive towards +s as in docs/method.md; α = arctan(B/H), R half the diagonal, p² = 3g/4R.
"""

import math

from overturning.units import STANDARD_GRAVITY


def rocking_frequency_parameter(height: float, b_over_h: float) -> float:
    """Return the rocking frequency p = √(3g/4R), rad/s (Housner 1963, eq. 3)."""
    radius = 0.5 * height * math.sqrt(1.0 + b_over_h**2)
    return math.sqrt(0.75 * STANDARD_GRAVITY / radius)


def angular_velocity_after_over_before_impact(b_over_h: float) -> float:
    """Return the ratio of angular velocities after and before an impact, 1 − 1.5 sin²α (Housner 1963, eq. 9)."""
    return 1.0 - 1.5 * b_over_h**2 / (1.0 + b_over_h**2)


def rocking_threshold_acceleration(b_over_h: float, upward_acceleration: float = 0.0) -> float:
    """Return the horizontal base acceleration at which a rigid block begins to rock, (g + a_up) B/H, m/s²."""
    return (STANDARD_GRAVITY + upward_acceleration) * b_over_h


def sliding_threshold_acceleration(friction: float, upward_acceleration: float = 0.0) -> float:
    """Return the horizontal base acceleration at which a rigid block begins to slide, μ (g + a_up), m/s²."""
    return (STANDARD_GRAVITY + upward_acceleration) * friction


def time_from_tilt_to_first_impact(height: float, b_over_h: float, initial_tilt_rad: float) -> float:
    """Return the time, s, from release at rest at a tilt (rad) to the first impact, without small-angle approximation.

    It follows from the energy integral θ̇² = 2p² (cos(α − θ₀) − cos(α − θ)). The substitution θ =
    θ₀ (1 − u²) removes the singularity; the integral uses 200 Gauss–Legendre points.

    Raises
    ------
    ValueError
        If the tilt is not between 0 and α.
    """
    import numpy as np

    alpha = math.atan(b_over_h)
    if not 0 < initial_tilt_rad < alpha:
        raise ValueError(f"tilt: {initial_tilt_rad}; it must lie between 0 and α = {alpha:.6g}")
    nodes, weights = np.polynomial.legendre.leggauss(200)
    u = 0.5 * (nodes + 1.0)
    angle = initial_tilt_rad * (1.0 - u**2)
    # cos a − cos b as a product keeps its digits near u = 0.
    half_sum = alpha - 0.5 * (angle + initial_tilt_rad)
    half_difference = 0.5 * (initial_tilt_rad - angle)
    drop = 2.0 * np.sin(half_sum) * np.sin(half_difference)
    rate = rocking_frequency_parameter(height, b_over_h) * np.sqrt(2.0 * drop)
    return float(np.sum(0.5 * weights * 2.0 * initial_tilt_rad * u / rate))


def rocking_amplitude_after_impact(b_over_h: float, amplitude_before_impact_rad: float) -> float:
    """Return the amplitude of free rocking after the next impact, rad, from that before it.

    The impact multiplies the energy by the square of the ratio `angular_velocity_after_over_before_impact`.
    """
    alpha = math.atan(b_over_h)
    lost = angular_velocity_after_over_before_impact(b_over_h) ** 2 * (
        math.cos(alpha - amplitude_before_impact_rad) - math.cos(alpha)
    )
    return alpha - math.acos(math.cos(alpha) + lost)


def time_and_velocity_at_end_of_bounce(
    impact_speed: float, stiffness_over_mass: float, dashpot_over_mass: float, gravity: float = STANDARD_GRAVITY
) -> tuple[float, float]:
    """Compute when and how fast a mass that falls on a spring and dashpot (which cannot pull) loses contact again.

    The penetration U follows Ü = g − ω² U − 2c U̇ with U(0) = 0 and U̇(0) = impact_speed, as long as ω² U + 2c U̇
    > 0.

    Parameters
    ----------
    impact_speed : float
        Downward velocity at touch, m/s.
    stiffness_over_mass : float
        ω² = K/m, 1/s².
    dashpot_over_mass : float
        2c = h/m, 1/s; below 2ω.
    gravity : float
        m/s².

    Returns
    -------
    time, velocity : float
        From touch until the force is zero again, s, and the upward velocity then, m/s.

    Raises
    ------
    ValueError
        If the contact is not underdamped.
    """
    from scipy.optimize import brentq

    c = 0.5 * dashpot_over_mass
    if stiffness_over_mass <= c * c:
        raise ValueError("rate: the contact must be underdamped")
    omega = math.sqrt(stiffness_over_mass - c * c)
    rest = gravity / stiffness_over_mass

    def spring_penetration_and_velocity_after_touch(time_since_touch: float) -> tuple[float, float]:
        """Return the penetration of the spring, m, and its rate, m/s, at a time since the touch, s."""
        a, b = -rest, (impact_speed - c * rest) / omega
        decay = math.exp(-c * time_since_touch)
        depth = rest + decay * (a * math.cos(omega * time_since_touch) + b * math.sin(omega * time_since_touch))
        rate_of_depth = decay * (
            (b * omega - c * a) * math.cos(omega * time_since_touch)
            - (a * omega + c * b) * math.sin(omega * time_since_touch)
        )
        return depth, rate_of_depth

    def contact_force_over_mass(time_since_touch: float) -> float:
        """Return the upward force of spring and dashpot over the mass, m/s², at a time since the touch, s."""
        depth, velocity = spring_penetration_and_velocity_after_touch(time_since_touch)
        return stiffness_over_mass * depth + dashpot_over_mass * velocity

    end = float(brentq(contact_force_over_mass, 0.5 * math.pi / omega * 0.2, 1.2 * math.pi / omega, xtol=1e-15))
    return end, -spring_penetration_and_velocity_after_touch(end)[1]
