"""Motion through soil: horizontal layers over a half-space, linear or equivalent-linear, by pystrata (group `soil`).

Shear waves travel vertically; each horizontal component goes through on its own, and the vertical one is not changed.
The complex shear modulus is pystrata's, G (√(1 − 4ξ²) + 2iξ); with G (1 + 2iξ) amplitudes would differ by
up to 2 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.units import STANDARD_GRAVITY

TAIL: Final = 5.0
"""Seconds after the record in which the soil may go on; the motion gets longer by them."""

QUIET: Final = 30.0
"""Least seconds of zeros behind that, so that what the discrete Fourier transform wraps around has died away."""

TOLERANCE: Final = 0.01
"""Relative change of modulus and damping below which an equivalent-linear run has converged."""


@dataclass(frozen=True)
class Soil:
    """A layer, or the half-space below."""

    thickness: float  # m; 0 for the half-space
    velocity: float  # of shear waves, m/s
    density: float  # kg/m³
    damping: float  # ratio; counts for nothing where there is a curve, which has its own
    curve: str | None = None  # published modulus-reduction and damping curve, by pystrata's name; None: linear


@dataclass(frozen=True)
class Passed:
    """A component at the surface."""

    samples: FloatArray  # acceleration, m/s², shape (n + tail,)
    converged: bool  # whether the last iteration changed modulus and damping by less than `TOLERANCE`
    change: float  # that change; 0 of a linear run, which has no iterations
    largest_strain: float  # largest shear strain of any layer; NaN of a linear run


def pystrata() -> Any:
    """The package, or an ArgumentError that says how to get it."""
    try:
        import pystrata as package  # takes some seconds
    except ImportError as error:
        raise ArgumentError(
            f"site: pystrata is not there ({error}); install the group: pip install 'overturning[soil]'"
        ) from None
    return package


def through_soil(
    samples: ArrayLike, sampling_interval: float, layers: Sequence[Soil], *, outcrop: bool = True
) -> Passed:
    """Take a component from rock to the surface.

    Parameters
    ----------
    samples : array_like, shape (n,)
        Acceleration, m/s².
    sampling_interval : float
        s.
    layers : sequence of Soil
        From the surface down; the last, of thickness 0, is the half-space. Equivalent-linear where a layer has a curve.
    outcrop : bool
        Whether the motion is that of outcropping rock, or of the rock below the layers ("within", as in a borehole).

    Raises
    ------
    ArgumentError
        If there is no layer, the last is no half-space, a curve is not known, or pystrata is missing.
    """
    if len(layers) < 2 or layers[-1].thickness != 0 or any(one.thickness <= 0 for one in layers[:-1]):
        raise ArgumentError("site: give layers with a thickness above 0, and below them a half-space")
    package = pystrata()
    acceleration = np.asarray(samples, dtype=np.float64)
    count = acceleration.size + round(TAIL / sampling_interval)
    length = 1 << (count + max(acceleration.size, round(QUIET / sampling_interval)) - 1).bit_length()
    motion = package.motion.TimeSeriesMotion(
        "", "", sampling_interval, acceleration / STANDARD_GRAVITY, fa_length=length
    )
    profile = package.site.Profile(
        [package.site.Layer(_soil_type(package, one), one.thickness, one.velocity) for one in layers]
    )
    nonlinear = any(one.curve for one in layers)
    linear, equivalent = package.propagation.LinearElasticCalculator, package.propagation.EquivalentLinearCalculator
    calculator = equivalent(tolerance=TOLERANCE) if nonlinear else linear()
    below = profile.location("outcrop" if outcrop else "within", index=-1)
    calculator(motion, profile, below)
    transfer = calculator.calc_accel_tf(below, profile.location("outcrop", index=0))
    surface = motion.calc_time_series(transfer)[:count] * STANDARD_GRAVITY
    change = float(max(profile.max_error)) if nonlinear else 0.0
    strain = max(float(np.max(layer.strain_max)) for layer in profile[:-1]) if nonlinear else float("nan")
    return Passed(np.asarray(surface, dtype=np.float64), change < TOLERANCE, change, strain)


def _soil_type(package: Any, soil: Soil) -> Any:
    weight = soil.density * STANDARD_GRAVITY / 1e3  # kN/m³
    if soil.curve is None:
        return package.site.SoilType("", weight, None, soil.damping)
    known = package.site.known_published_curves()
    if soil.curve not in known:
        raise ArgumentError(
            f"site: curve {soil.curve!r}; known are {', '.join(sorted(known)[:6])} … ({len(known)} in all)"
        )
    return package.site.SoilType.from_published("", weight, soil.curve)
