"""Synthetic ground motions in closed form, usable like recorded ones.

A line of text defines a pulse by shape and parameters: ``sine amplitude_gal=300 period_s=1 azimuth_deg=60``. Samples
are values of the formula, so every sampling interval gives points of the same curve. Motions are linear between
samples: a jump at an end of a pulse takes one sampling interval, outside of the pulse.
"""

import hashlib
import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from overturning.arrays import FloatArray
from overturning.errors import ConfigError
from overturning.motion.direction import cosine_and_sine_of_azimuth
from overturning.motion.motion import MAX_SAMPLES_OF_MOTION
from overturning.records.record import Record
from overturning.units import GAL
from overturning.validation import StrictModel, format_validation_error


class _PulseBaseClass(StrictModel):
    """Base class of acceleration pulses: amplitude, azimuth, sampling interval, and rest before and after the pulse."""

    amplitude_gal: float = Field(gt=0, le=1e5, description="Largest factor of the formula, Gal.")
    azimuth_deg: float = Field(
        default=0.0, ge=-360, le=360, description="Direction of the motion, clockwise from north."
    )
    sampling_interval_s: float = Field(default=0.005, ge=1e-5, le=0.1, description="Time between samples, s.")
    before_s: float = Field(default=1.0, ge=0, le=1000, description="Rest before the pulse, s.")
    after_s: float = Field(default=1.0, ge=0, le=1000, description="Rest after the pulse, s.")

    @property
    def shortest_period(self) -> float:
        """Shortest period of the pulse, s; infinite for a pulse without a period."""
        return float(getattr(self, "period_s", math.inf))


class HarmonicPulse(_PulseBaseClass):
    """Sine or cosine pulse with a given number of cycles of period T: a = A sin(2πt/T) or A cos(2πt/T)."""

    shape: Literal["sine", "cosine"]
    period_s: float = Field(gt=0, le=1000, description="Period T, s.")
    cycles: float = Field(default=1.0, gt=0, le=1000, description="Number of cycles.")

    @property
    def duration(self) -> float:
        """Duration of the pulse, s: the period times the number of cycles."""
        return self.period_s * self.cycles

    def acceleration(self, time_since_pulse_start_s: FloatArray) -> FloatArray:  # noqa: D102
        wave = np.sin if self.shape == "sine" else np.cos
        return np.asarray(self.amplitude_gal * GAL * wave(2.0 * np.pi * time_since_pulse_start_s / self.period_s))


class RickerPulse(_PulseBaseClass):
    """Ricker (1943) pulse of period T: a = A (1 − 2x²) exp(−x²), where x = π (t − t₀)/T.

    The pulse is centred at t₀, and zero for |t − t₀| > 1.6 T.
    """

    shape: Literal["ricker"] = "ricker"
    period_s: float = Field(gt=0, le=1000, description="Inverse of the frequency with the largest amplitude, s.")

    @property
    def duration(self) -> float:
        """Duration of the pulse, s: 3.2 periods; the amplitude is below 1e-9 of the peak outside."""
        return 3.2 * self.period_s

    def acceleration(self, time_since_pulse_start_s: FloatArray) -> FloatArray:  # noqa: D102
        x = np.pi * (time_since_pulse_start_s - 0.5 * self.duration) / self.period_s
        return self.amplitude_gal * GAL * (1.0 - 2.0 * x**2) * np.exp(-(x**2))


class MavroeidisPapageorgiouPulse(_PulseBaseClass):
    """Near-fault pulse of Mavroeidis & Papageorgiou (2003, BSSA 93, 1099-1131), equation 3.

    The velocity is v = V/2 [1 + cos(2πf(t − t₀)/γ)] cos(2πf(t − t₀) + ν) for |t − t₀| ≤ γ/(2f), with
    f = 1/T and the middle of the pulse t₀. The acceleration is its derivative. ``amplitude_gal`` is A = 2πf V.
    """

    shape: Literal["mavroeidis-papageorgiou"] = "mavroeidis-papageorgiou"
    period_s: float = Field(gt=0, le=1000, description="Prevailing period T, s.")
    gamma: float = Field(default=1.5, gt=1, le=100, description="Oscillatory character γ.")
    phase_deg: float = Field(default=0.0, ge=-360, le=360, description="Phase ν, degrees.")

    @property
    def duration(self) -> float:
        """Duration of the pulse, s: γ times the period."""
        return self.gamma * self.period_s

    def acceleration(self, time_since_pulse_start_s: FloatArray) -> FloatArray:  # noqa: D102
        phase = 2.0 * np.pi * (time_since_pulse_start_s - 0.5 * self.duration) / self.period_s
        slow, fast = phase / self.gamma, phase + math.radians(self.phase_deg)
        bracket = np.sin(slow) * np.cos(fast) / self.gamma + (1.0 + np.cos(slow)) * np.sin(fast)
        return -0.5 * self.amplitude_gal * GAL * bracket


class _PulseBaseClassWithDuration(_PulseBaseClass):
    """Base class of pulses whose duration is a parameter instead of following from a period."""

    duration_s: float = Field(gt=0, le=1000, description="Duration, s.")

    @property
    def duration(self) -> float:
        """Duration of the pulse, s, as set by the user."""
        return self.duration_s


class ConstantPulse(_PulseBaseClassWithDuration):
    """Pulse of constant acceleration A towards the azimuth of the pulse, for a given duration."""

    shape: Literal["constant"] = "constant"

    def acceleration(self, time_since_pulse_start_s: FloatArray) -> FloatArray:  # noqa: D102
        return np.full_like(time_since_pulse_start_s, self.amplitude_gal * GAL)


class NoisePulse(_PulseBaseClassWithDuration):
    """Pulse of band-limited white noise, multiplied by a cosine bell over its duration D.

    a = A/N^½ sin²(πt/D) Σ_k √2 cos(2πf_k t + φ_k), with the N frequencies f_k = k/D from ``low_hz`` to
    ``high_hz``, all of the same amplitude. The phases φ_k come from the seed by SHA-256, so that the pulse is the same
    with every version of every library. Without the bell, the root mean square of a would be A.
    """

    shape: Literal["noise"] = "noise"
    duration_s: float = Field(gt=0, le=300, description="Length D of the burst, s.")
    low_hz: float = Field(default=0.1, gt=0, le=1000, description="Lowest frequency, Hz.")
    high_hz: float = Field(default=20.0, gt=0, le=1000, description="Highest frequency, Hz.")
    seed: int = Field(default=0, ge=0, description="Seed of the phases.")

    @property
    def shortest_period(self) -> float:
        """Shortest period of the noise pulse, s: the inverse of its highest frequency."""
        return 1.0 / self.high_hz

    def acceleration(self, time_since_pulse_start_s: FloatArray) -> FloatArray:  # noqa: D102
        # Include frequencies that miss an end of the band by rounding only.
        first = max(1, math.ceil(self.low_hz * self.duration_s * (1.0 - 1e-12)))
        numbers = range(first, math.floor(self.high_hz * self.duration_s * (1.0 + 1e-12)) + 1)
        if not numbers:
            raise ConfigError(
                f"noise: no frequency between {self.low_hz:g} and {self.high_hz:g} Hz in {self.duration_s:g} s"
            )
        total = np.zeros_like(time_since_pulse_start_s)
        for k in numbers:
            digest = hashlib.sha256(f"{self.seed}:{k}".encode()).digest()
            phase = 2.0 * np.pi * int.from_bytes(digest[:8]) / 2.0**64
            total += np.cos(2.0 * np.pi * k * time_since_pulse_start_s / self.duration_s + phase)
        bell = np.sin(np.pi * time_since_pulse_start_s / self.duration_s) ** 2
        return self.amplitude_gal * GAL * math.sqrt(2.0 / len(numbers)) * bell * total


Pulse = Annotated[
    HarmonicPulse | RickerPulse | MavroeidisPapageorgiouPulse | ConstantPulse | NoisePulse, Field(discriminator="shape")
]
"""Any of the pulse classes; the key ``shape`` selects the class.

Each has a ``duration``, s, and a method ``acceleration``, m/s², of times from 0 to ``duration``, s.
"""

_PULSE_TYPE_ADAPTER: TypeAdapter[Pulse] = TypeAdapter(Pulse)
PULSE_SHAPES = ("sine", "cosine", "ricker", "mavroeidis-papageorgiou", "constant", "noise")


def parse_pulse(pulse_text: str) -> Pulse:
    """Parse a pulse from text such as ``sine amplitude_gal=300 period_s=1 azimuth_deg=60``.

    Raises a ConfigError that names each invalid parameter, its value and the bound.
    """
    shape, *rest = pulse_text.split() or [""]
    values = {"shape": shape}
    for word in rest:
        key, equals, value = word.partition("=")
        if not equals or key in values:
            raise ConfigError(f"pulse {pulse_text!r}: {word!r}; write each parameter once, as key=value")
        values[key] = value
    try:
        return _PULSE_TYPE_ADAPTER.validate_python(values)
    except ValidationError as problem:
        faults = []
        for fault in problem.errors():
            key = str(fault["loc"][-1]) if fault["loc"] else "shape"
            value = f" {values[key]!r}" if key in values else ""
            faults.append(
                f"shape {values['shape']!r}; known are {', '.join(PULSE_SHAPES)}"
                if fault["type"].startswith("union_tag")
                else f"{key}{value}: {format_validation_error(fault)}"
            )
        raise ConfigError(f"pulse {pulse_text!r}: {'; '.join(faults)}") from None


def record_of_pulse(pulse: Pulse, record_id: str = "pulse") -> Record:
    """Create a record of a horizontal pulse along its azimuth, with zero acceleration before and after it.

    ``extra`` marks it as processed, so that no filter changes it. Raises a ConfigError for a too coarse interval (fewer
    than ten samples in the pulse, or fewer than four in its shortest period), and for more than `MAX_SAMPLES_OF_MOTION`
    samples.
    """
    interval = pulse.sampling_interval_s
    if pulse.duration < 10 * interval:
        raise ConfigError(
            f"record {record_id}: the pulse lasts {pulse.duration:g} s; it needs at least ten samples: "
            f"sampling_interval_s ≤ {pulse.duration / 10:g}"
        )
    if pulse.shortest_period < 4 * interval:
        raise ConfigError(
            f"record {record_id}: the pulse has periods of {pulse.shortest_period:g} s; each needs at least four "
            f"samples: sampling_interval_s ≤ {pulse.shortest_period / 4:g}"
        )
    if (wanted := (pulse.before_s + pulse.duration + pulse.after_s) / interval) > MAX_SAMPLES_OF_MOTION:
        raise ConfigError(
            f"record {record_id}: {wanted:.2g} samples, at most {MAX_SAMPLES_OF_MOTION:.0e} are possible; give a "
            "shorter pulse, less rest or a longer sampling_interval_s"
        )
    count = math.floor((pulse.before_s + pulse.duration + pulse.after_s) / interval + 1e-9) + 1
    time = np.arange(count) * interval - pulse.before_s
    # Include samples that miss an end of the pulse by rounding only.
    inside = (time >= -1e-9 * interval) & (time <= pulse.duration + 1e-9 * interval)
    along = np.zeros(count)
    along[inside] = pulse.acceleration(np.clip(time[inside], 0.0, pulse.duration))
    cosine, sine = cosine_and_sine_of_azimuth(pulse.azimuth_deg)
    given = pulse.model_dump(exclude={"shape"}).items()
    line = " ".join([pulse.shape, *(f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in given)])
    return Record(
        record_id=record_id,
        north=along * cosine + 0.0,
        east=along * sine + 0.0,
        up=None,
        sampling_interval=interval,
        source=f"synthetic {line}",
        sha256=hashlib.sha256(line.encode()).hexdigest(),
        licence="synthetic",
        event=f"{pulse.shape} pulse",
        component_azimuths_deg=(pulse.azimuth_deg % 360.0, (pulse.azimuth_deg + 90.0) % 360.0),
        # Skip the amplitude check: a pulse states its unit and may have any size.
        extra={"format": "synthetic", "processed": True, "trusted_data": True},
    )
