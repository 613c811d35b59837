"""Site response of horizontal soil layers over a half-space, linear or equivalent-linear, by pystrata (group `soil`).

Shear waves travel vertically. Each horizontal component is computed separately, and the vertical one is not changed.
The complex shear modulus is that of pystrata, G (√(1 − 4ξ²) + 2iξ); with G (1 + 2iξ) amplitudes would differ by
up to 2 %.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.units import STANDARD_GRAVITY
from overturning.validation import StrictModel

MIN_VIBRATION_TAIL_S: Final = 5.0
"""Shortest tail: time after the record in which the soil vibrates, s; doubled until the vibration has decayed."""

MAX_ACCELERATION_TO_PEAK_RATIO_AFTER_TAIL: Final = 0.01
"""Largest acceleration at the surface after the tail, as a share of the peak."""

MIN_ZERO_PADDING_S: Final = 30.0
"""Shortest zero padding after the record, s; doubled until the wrap-around of the Fourier transform has decayed."""

MAX_ZERO_PADDING_S: Final = 600.0
"""Longest zero padding, s; a site that vibrates longer has almost no damping and is refused."""

MAX_WRAP_AROUND_TO_PEAK_RATIO: Final = 2e-3
"""Largest vibration at the end of the zero padding, as a share of the peak at the surface."""

EQUIVALENT_LINEAR_MAX_RELATIVE_CHANGE: Final = 0.01
"""Relative change of modulus and damping per iteration below which an equivalent-linear analysis has converged."""


class RockHalfSpace(StrictModel):
    """Elastic half-space of rock below the soil layers."""

    velocity_m_s: float = Field(gt=0, le=1e4, description="Shear-wave velocity, m/s.")
    density_kg_m3: float = Field(default=2200, ge=100, le=1e4, description="Density, kg/m³.")
    damping: float = Field(default=0.01, ge=0, lt=0.5, description="Damping ratio.")


class SoilLayer(StrictModel):
    """Layer of soil, linear or with a published modulus-reduction curve."""

    thickness_m: float = Field(gt=0, le=1e4, description="Thickness, m.")
    velocity_m_s: float = Field(gt=0, le=1e4, description="Shear-wave velocity, m/s.")
    density_kg_m3: float = Field(default=1800, ge=100, le=1e4, description="Density, kg/m³.")
    damping: float = Field(
        default=0.05,
        ge=0,
        lt=0.5,
        description="Damping ratio; ignored for a layer with a curve, which has its own.",
    )
    curve: str | None = Field(
        default=None, description="Published modulus-reduction curve, by pystrata's name; none: the layer is linear."
    )


@dataclass(frozen=True)
class SoilResponseOfOneComponent:
    """Acceleration of a horizontal component at the ground surface, and convergence of the soil response analysis."""

    # acceleration, m/s², shape (n + tail,); after it, at most `MAX_ACCELERATION_TO_PEAK_RATIO_AFTER_TAIL` of the peak
    surface_acceleration: FloatArray
    # True if the last iteration changed modulus and damping by less than `EQUIVALENT_LINEAR_MAX_RELATIVE_CHANGE`
    is_converged: bool
    last_relative_modulus_and_damping_change: (
        float  # relative change in the last iteration; 0 for a linear analysis, which has no iterations
    )
    max_shear_strain_of_any_layer: float  # largest shear strain of any layer; NaN for a linear analysis
    effective_strain_and_end_of_curve_if_exceeded: tuple[float, float] | None = (
        None  # effective strain, and the smaller end of the curve; None within
    )


def import_pystrata() -> Any:
    """Return the package pystrata; raise an ArgumentError with the installation command if it is missing."""
    try:
        with warnings.catch_warnings():  # on escapes in pystrata's docstrings, printed while it is compiled
            warnings.simplefilter("ignore", SyntaxWarning)
            import pystrata as package  # takes some seconds
    except ImportError as error:
        raise ArgumentError(
            f"site: soil layers need pystrata, which cannot be imported ({error}); python -m pip install "
            "'overturning[soil]', or remove the site"
        ) from None
    return package


def check_pystrata_has_soil_curves(soil_layers: Sequence[SoilLayer]) -> None:
    """Raise an `ArgumentError` if pystrata is missing, or lacks the curve of a soil layer or a part of this curve."""
    package = import_pystrata()
    for layer in soil_layers:
        if layer.curve is not None:
            _soil_type_with_published_curve(package, 1.0, layer.curve)


def propagate_through_soil(
    rock_acceleration: ArrayLike,
    sampling_interval: float,
    soil_layers_from_surface_down: Sequence[SoilLayer],
    rock: RockHalfSpace,
    *,
    motion_is_on_outcrop: bool = True,
) -> SoilResponseOfOneComponent:
    """Compute one horizontal component of the motion at the surface of soil layers from the same component in the rock.

    Parameters
    ----------
    rock_acceleration : array_like, shape (n,)
        Acceleration, m/s².
    sampling_interval : float
        Time between samples, s.
    soil_layers_from_surface_down : sequence of SoilLayer
        Layers from the surface down. The analysis is equivalent-linear if at least one has a curve.
    rock : RockHalfSpace
        Half-space below the layers.
    motion_is_on_outcrop : bool
        True if the motion is that of outcropping rock; False if it is that of the rock below the layers ("within", as
        in a borehole).

    Raises
    ------
    ArgumentError
        If a curve is not known, or pystrata is missing; if the response is not finite; or if the soil still vibrates
        `MAX_ZERO_PADDING_S` after the record.
    """
    package = import_pystrata()
    acceleration = np.asarray(rock_acceleration, dtype=np.float64)
    min_tail_and_left_out_end_sample_count = round(MIN_VIBRATION_TAIL_S / sampling_interval)
    zeros = max(acceleration.size, round(MIN_ZERO_PADDING_S / sampling_interval))
    longest = max(zeros, round(MAX_ZERO_PADDING_S / sampling_interval))
    while True:
        padded_sample_count = 1 << (acceleration.size + min_tail_and_left_out_end_sample_count + zeros - 1).bit_length()
        found = _propagate_with_zero_padding(
            package,
            acceleration,
            sampling_interval,
            soil_layers_from_surface_down,
            rock,
            motion_is_on_outcrop,
            padded_sample_count,
        )
        remaining = _residual_vibration_to_peak_ratio(
            found.surface_acceleration, min_tail_and_left_out_end_sample_count
        )
        if remaining <= MAX_WRAP_AROUND_TO_PEAK_RATIO:
            count = _surface_sample_count_to_keep(
                found.surface_acceleration, acceleration.size, min_tail_and_left_out_end_sample_count
            )
            return replace(found, surface_acceleration=found.surface_acceleration[:count])
        if zeros >= longest:
            raise ArgumentError(
                f"site: {100 * remaining:.2g} % of the peak acceleration of the surface is left "
                f"{padded_sample_count * sampling_interval:.0f} s after the start of the record; give the layers and "
                "the rock more damping (0.01 or more)"
            )
        zeros = min(2 * zeros, longest)


def _residual_vibration_to_peak_ratio(
    surface_acceleration: FloatArray, checked_and_left_out_end_sample_count: int
) -> float:
    """Return the largest acceleration near the end of the zero padding, divided by the peak acceleration.

    `checked_and_left_out_end_sample_count` samples are checked. Equally many after them, at the very end, are left out:
    there, an abrupt start of the record causes oscillations at the highest frequency.
    """
    peak = float(np.abs(surface_acceleration).max())
    return (
        float(
            np.abs(
                surface_acceleration[
                    -2 * checked_and_left_out_end_sample_count : -checked_and_left_out_end_sample_count
                ]
            ).max()
        )
        / peak
        if peak
        else 0.0
    )


def _surface_sample_count_to_keep(
    surface_acceleration: FloatArray, record_sample_count: int, min_tail_and_left_out_end_sample_count: int
) -> int:
    """Return the number of surface samples to keep: the record, and its zero padding until the vibration has decayed.

    The kept part of the padding starts with `min_tail_and_left_out_end_sample_count` samples and is doubled until all
    later accelerations are at most `MAX_ACCELERATION_TO_PEAK_RATIO_AFTER_TAIL` times the peak. The last
    `min_tail_and_left_out_end_sample_count` samples are not checked, as in `_residual_vibration_to_peak_ratio`.
    """
    size, tail = np.abs(surface_acceleration), min_tail_and_left_out_end_sample_count
    while (
        size[record_sample_count + tail : -min_tail_and_left_out_end_sample_count].max(initial=0.0)
        > MAX_ACCELERATION_TO_PEAK_RATIO_AFTER_TAIL * size.max()
    ):
        tail *= 2
    return min(record_sample_count + tail, surface_acceleration.size)


def _propagate_with_zero_padding(
    pystrata_package: Any,
    rock_acceleration: FloatArray,
    sampling_interval: float,
    soil_layers_from_surface_down: Sequence[SoilLayer],
    rock: RockHalfSpace,
    motion_is_on_outcrop: bool,
    padded_sample_count: int,
) -> SoilResponseOfOneComponent:
    """Compute the motion at the ground surface with one Fourier transform of the rock motion, padded with zeros."""
    motion = pystrata_package.motion.TimeSeriesMotion(
        "", "", sampling_interval, rock_acceleration / STANDARD_GRAVITY, fa_length=padded_sample_count
    )
    below = pystrata_package.site.Layer(_pystrata_soil_type(pystrata_package, rock), 0, rock.velocity_m_s)
    soil = [
        pystrata_package.site.Layer(_pystrata_soil_type(pystrata_package, one), one.thickness_m, one.velocity_m_s)
        for one in soil_layers_from_surface_down
    ]
    profile = pystrata_package.site.Profile([*soil, below])
    nonlinear = any(one.curve for one in soil_layers_from_surface_down)
    linear = pystrata_package.propagation.LinearElasticCalculator
    equivalent = pystrata_package.propagation.EquivalentLinearCalculator
    calculator = equivalent(tolerance=EQUIVALENT_LINEAR_MAX_RELATIVE_CHANGE) if nonlinear else linear()
    incoming = profile.location("outcrop" if motion_is_on_outcrop else "within", index=-1)
    with np.errstate(over="ignore", invalid="ignore"):  # an overflow gives values that are not finite, checked below
        calculator(motion, profile, incoming)
        transfer = calculator.calc_accel_tf(incoming, profile.location("outcrop", index=0))
    surface = np.asarray(motion.calc_time_series(transfer)[:padded_sample_count] * STANDARD_GRAVITY, dtype=np.float64)
    if not np.isfinite(surface).all():
        raise ArgumentError(
            "site: the response of the soil layers is not finite: waves of the highest frequency are damped out "
            "completely; check thickness_m (m) and velocity_m_s (m/s) of the layers"
        )
    change = float(max(profile.max_error)) if nonlinear else 0.0
    strain = max(float(np.max(layer.strain_max)) for layer in profile[:-1]) if nonlinear else float("nan")
    return SoilResponseOfOneComponent(
        surface,
        change < EQUIVALENT_LINEAR_MAX_RELATIVE_CHANGE,
        change,
        strain,
        _strain_and_curve_end_of_layer_most_beyond_curve(profile[:-1], soil_layers_from_surface_down),
    )


def _strain_and_curve_end_of_layer_most_beyond_curve(
    pystrata_profile_layers: Sequence[Any], soil_layers_from_surface_down: Sequence[SoilLayer]
) -> tuple[float, float] | None:
    """Return (effective strain, end of curve) of the soil layer furthest beyond its published curve; None if none is.

    The end is the largest strain of the curve. Beyond it, pystrata keeps the last modulus and damping, so that the
    iteration converges at any strain.
    """
    beyond = None
    for one, layer in zip(pystrata_profile_layers, soil_layers_from_surface_down, strict=True):
        if layer.curve is None:
            continue
        strain = float(np.max(one.strain))
        end = min(float(part.strains[-1]) for part in (one.soil_type.mod_reduc, one.soil_type.damping))
        if strain > end * (1 + 1e-9) and (beyond is None or strain / end > beyond[0] / beyond[1]):
            beyond = strain, end
    return beyond


def _pystrata_soil_type(pystrata_package: Any, soil_layer: SoilLayer | RockHalfSpace) -> Any:
    """Return the pystrata `SoilType` of a soil layer, or of the rock half-space below the layers."""
    unit_weight_kn_m3 = soil_layer.density_kg_m3 * STANDARD_GRAVITY / 1e3
    if isinstance(soil_layer, RockHalfSpace) or soil_layer.curve is None:
        return pystrata_package.site.SoilType("", unit_weight_kn_m3, None, soil_layer.damping)
    return _soil_type_with_published_curve(pystrata_package, unit_weight_kn_m3, soil_layer.curve)


def _soil_type_with_published_curve(pystrata_package: Any, unit_weight_kn_m3: float, published_curve_name: str) -> Any:
    """Return a pystrata `SoilType` with a published curve; raise an ArgumentError if the curve or a part is missing.

    Some publications give only a modulus reduction, or only a damping.
    """
    known = pystrata_package.site.known_published_curves()
    if published_curve_name not in known:
        first = ", ".join(sorted(known)[:6])
        raise ArgumentError(f"site: curve {published_curve_name!r}; known are {first} … ({len(known)} in all)")
    try:
        return pystrata_package.site.SoilType.from_published("", unit_weight_kn_m3, published_curve_name)
    except KeyError as missing:
        part = "modulus reduction" if missing.args == ("mod_reduc",) else "damping"
        raise ArgumentError(
            f"site: curve {published_curve_name!r}: pystrata has no {part} of this curve; choose a curve with "
            "modulus reduction and damping, such as 'Vucetic & Dobry (91), PI=30'"
        ) from None
