"""Processing steps of records: parameters, bounds, and their effect on a component."""

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.motion.fourier import cosine_taper_window
from overturning.motion.integration import integrate
from overturning.motion.motion import MAX_SAMPLES_OF_MOTION
from overturning.records.record import Record
from overturning.validation import StrictModel

MAX_RESAMPLING_NUMERATOR_OR_DENOMINATOR = 1000
"""Largest numerator or denominator of a resampling ratio."""


def _unsuitable_step_error(record: Record, step_and_parameter_label: str, reason: str) -> RecordError:
    """Return an error with the record, the processing step, and the reason why the step cannot be applied."""
    return RecordError(f"record {record.record_id}: {step_and_parameter_label}; {reason}")


def _refuse_too_many_samples(
    record: Record, step_and_parameter_label: str, sample_count_after_processing: float
) -> None:
    """Raise a RecordError if a processing step would give a record more than `MAX_SAMPLES_OF_MOTION` samples."""
    if sample_count_after_processing > MAX_SAMPLES_OF_MOTION:
        most = f"at most {MAX_SAMPLES_OF_MOTION:.0e} are possible"
        bounds = f"the record would have {sample_count_after_processing:.2g} samples, {most}"
        raise _unsuitable_step_error(record, step_and_parameter_label, bounds)


class _ProcessingStep(StrictModel):
    """Base class of the processing steps of a record, such as a filter or a cut."""

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:
        """Return the processed samples of a component, m/s²; raise a RecordError if the step cannot be applied."""
        raise NotImplementedError

    def start_shift_of_record_s(self, sampling_interval: float) -> float:  # noqa: ARG002
        """Return by how much this processing step shifts the record's start, s; negative if it then starts earlier."""
        return 0.0


class RemoveMean(_ProcessingStep):
    """Subtract from each component its mean over the first ``first_s`` s, or over the whole record if not given."""

    step: Literal["remove_mean"] = "remove_mean"
    first_s: float | None = Field(
        default=None, gt=0, description="Length of the pre-event part, s; none: the whole record."
    )

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: D102
        if self.first_s is None:
            return acceleration - acceleration.mean()
        count = round(self.first_s / record.sampling_interval)
        if not 1 <= count <= record.north.size:
            bounds = f"it must lie between one sample and {record.duration:g} s"
            raise _unsuitable_step_error(record, f"remove_mean.first_s {self.first_s:g}", bounds)
        return acceleration - acceleration[:count].mean()


class Detrend(_ProcessingStep):
    """Subtract from each component a polynomial that is fitted to the component by least squares."""

    step: Literal["detrend"] = "detrend"
    order: int = Field(default=1, ge=0, le=5, description="Order of the polynomial; 1 is a line.")

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: ARG002, D102
        # Legendre polynomials on [-1, 1] keep the least-squares problem well conditioned at every length.
        abscissa = np.linspace(-1.0, 1.0, acceleration.size)
        fit = np.polynomial.legendre.legfit(abscissa, acceleration, self.order)
        return np.asarray(acceleration - np.polynomial.legendre.legval(abscissa, fit), dtype=np.float64)


class Taper(_ProcessingStep):
    """Multiply both ends of each component by half a cosine bell."""

    step: Literal["taper"] = "taper"
    length_s: float = Field(gt=0, description="Length of the bell at each end, s.")

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: D102
        width = round(self.length_s / record.sampling_interval)
        if not 1 <= width <= acceleration.size // 2:
            bounds = f"it must lie between one sample and half the record, {0.5 * record.duration:g} s"
            raise _unsuitable_step_error(record, f"taper.length_s {self.length_s:g}", bounds)
        return acceleration * cosine_taper_window(acceleration.size, width)


PositiveNumber = Annotated[float, Field(gt=0)]


class ButterworthFilter(_ProcessingStep):
    """Butterworth low-pass or high-pass filter, run forward and backward so that the phase is unchanged."""

    step: Literal["highpass", "lowpass"]  # first key of the step
    corner_hz: PositiveNumber | Literal["auto"] = Field(
        description="Corner frequency; the amplitude there is halved by the two passes. "
        "A high-pass filter takes `auto` too."
    )
    order: int = Field(default=2, ge=1, le=8, description="Order of each of the two passes.")

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: D102
        from scipy.signal import butter, sosfiltfilt

        nyquist, corner = 0.5 / record.sampling_interval, float(self.corner_hz)
        if corner >= nyquist:
            bounds = f"it must lie below the Nyquist frequency {nyquist:g} Hz"
            raise _unsuitable_step_error(record, f"{self.step}.corner_hz {corner:g}", bounds)
        sections = butter(self.order, corner, btype=self.step, fs=1.0 / record.sampling_interval, output="sos")
        pad = self._zero_count_padded_at_each_end(record.sampling_interval)
        _refuse_too_many_samples(
            record, f"{self.step}.corner_hz {corner:g} needs added zeros", acceleration.size + 2 * pad
        )
        filtered = sosfiltfilt(sections, np.pad(acceleration, pad), padtype=None)
        # A zero-phase high-pass filter acts before the first sample too. Stripped of its pads its output would
        # integrate to a velocity that drifts (Boore, Sisi & Akkar 2012, BSSA 102, 751-760), so they stay.
        kept = filtered if self.step == "highpass" else filtered[pad : pad + acceleration.size]
        return np.ascontiguousarray(kept, dtype=np.float64)

    def _zero_count_padded_at_each_end(self, sampling_interval: float) -> int:
        """Return the number of zeros to add at each end; they last 1.5 order/corner seconds (Converse & Brady 1992)."""
        return math.ceil(1.5 * self.order / float(self.corner_hz) / sampling_interval)


class Highpass(ButterworthFilter):
    """Butterworth high-pass filter, run forward and backward so that the phase is unchanged.

    Zeros are added at both ends, each for 1.5 order/corner seconds. These pads are kept, because the filtered motion
    extends into them and the velocity would drift without them; so the record starts earlier by one pad. The corner
    ``auto`` is found from the noise before the onset (`overturning.records.processing`). A constant offset would make
    a step next to the zeros. So it is subtracted before the filter, unless an earlier step removed it.
    """

    step: Literal["highpass"] = "highpass"

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: D102
        before = {entry["step"] for entry in record.processing}
        offset = (
            0.0
            if before & {"remove_mean", "detrend", "highpass"}
            else _estimate_constant_offset(acceleration, record.sampling_interval)
        )
        return super().apply_to_component(acceleration - offset, record)

    def start_shift_of_record_s(self, sampling_interval: float) -> float:  # noqa: D102
        return -self._zero_count_padded_at_each_end(sampling_interval) * sampling_interval


def _estimate_constant_offset(acceleration: FloatArray, sampling_interval: float) -> float:
    """Estimate the constant offset of a component, m/s², from its mean and the medians of its first and last second.

    The offset is that of these three values which is closest to 0, or 0 if their signs differ.
    """
    end = max(1, round(1.0 / sampling_interval))
    levels = [float(np.median(acceleration[:end])), float(np.median(acceleration[-end:])), float(acceleration.mean())]
    return min(levels, key=abs) if min(levels) > 0 or max(levels) < 0 else 0.0


class Lowpass(ButterworthFilter):
    """Butterworth low-pass filter, run forward and backward (phase unchanged); the record keeps its length."""

    step: Literal["lowpass"] = "lowpass"
    corner_hz: PositiveNumber = Field(description="Corner frequency; the amplitude there is halved by the two passes.")

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: D102
        offset = _estimate_constant_offset(acceleration, record.sampling_interval)
        return super().apply_to_component(acceleration - offset, record) + offset


class Baseline(_ProcessingStep):
    """Baseline correction of the velocity by a published scheme, chosen by its name.

    ``boore-2001``: Boore (2001, BSSA 91, 1199-1211) after Iwan et al. (1985). A line v = v0 + a_f t is fitted to the
    end of the velocity. The slope a_f is subtracted from the acceleration after t2. Between t1 and t2 a constant is
    subtracted whose integral is the value of the line at t2. Without t1 and t2, a_f is subtracted from the time at
    which the line is zero to the end (Boore's v0 correction).
    """

    step: Literal["baseline"] = "baseline"
    scheme: Literal["boore-2001"] = Field(default="boore-2001", description="Name of the scheme.")
    fit_from_s: float = Field(gt=0, description="Where the fit to the end of the velocity begins, s.")
    t1_s: float | None = Field(default=None, ge=0, description="Where the offset of the strong motion begins, s.")
    t2_s: float | None = Field(default=None, gt=0, description="Where it ends, s; none: where the fitted line is zero.")

    @model_validator(mode="after")
    def _check_time_order(self) -> "Baseline":
        """Raise a ValueError if only one of t1 and t2 is given, or unless t1 < t2 ≤ start of the fit."""
        if (self.t1_s is None) != (self.t2_s is None):
            raise ValueError("t1_s and t2_s: give both or neither")
        if self.t1_s is not None and self.t2_s is not None and not self.t1_s < self.t2_s <= self.fit_from_s:
            raise ValueError("t1_s, t2_s, fit_from_s must ascend")
        return self

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: D102
        interval = record.sampling_interval
        time = np.arange(acceleration.size) * interval
        end = time >= self.fit_from_s - 1e-9
        if end.sum() < 10:
            bounds = f"the record ends at {record.duration:g} s and the fit needs ten samples"
            raise _unsuitable_step_error(record, f"baseline.fit_from_s {self.fit_from_s:g}", bounds)
        velocity = integrate(acceleration, interval)
        # Solve about the middle of the fitted part: well conditioned however late it lies.
        middle = float(time[end].mean())
        final, at_middle = np.polyfit(time[end] - middle, velocity[end], 1)
        at_zero = at_middle - final * middle
        corrected = acceleration.copy()
        if self.t1_s is None or self.t2_s is None:
            # Time at which the fitted line is zero; outside of the record there is no step to subtract.
            t2 = -at_zero / final if final else math.inf
            if 0.0 <= t2 <= self.fit_from_s:
                corrected[time >= t2] -= final
            return corrected
        first, after = (int(np.searchsorted(time, edge - 1e-9)) for edge in (self.t1_s, self.t2_s))
        if first == after:
            what = f"baseline.t1_s {self.t1_s:g} and t2_s {self.t2_s:g}"
            raise _unsuitable_step_error(record, what, f"no sample lies between; samples are {interval:g} s apart")
        # By the trapezoidal rule, the step at a sample begins half an interval before it, or with the record.
        begin, end_of_mean = max(first - 0.5, 0.0) * interval, (after - 0.5) * interval
        corrected[first:after] -= (at_zero + final * end_of_mean) / (end_of_mean - begin)
        corrected[after:] -= final
        return corrected


class Resample(_ProcessingStep):
    """Resample a record, band-limited; the new interval over the old one must be a ratio of small integers."""

    step: Literal["resample"] = "resample"
    sampling_interval_s: float = Field(gt=0, le=1, description="New time between samples, s.")

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: D102
        from scipy.signal import resample_poly

        exact = record.sampling_interval / self.sampling_interval_s
        ratio = Fraction(exact).limit_denominator(MAX_RESAMPLING_NUMERATOR_OR_DENOMINATOR)
        if (
            ratio.numerator > MAX_RESAMPLING_NUMERATOR_OR_DENOMINATOR
            or ratio == 0
            or not math.isclose(float(ratio), exact, rel_tol=1e-7)
        ):
            what = f"resample.sampling_interval_s {self.sampling_interval_s:g} from {record.sampling_interval:g}"
            raise _unsuitable_step_error(
                record,
                what,
                f"their ratio must be a fraction of whole numbers up to {MAX_RESAMPLING_NUMERATOR_OR_DENOMINATOR}",
            )
        if ratio == 1:
            return acceleration
        label = f"resample.sampling_interval_s {self.sampling_interval_s:g}"
        _refuse_too_many_samples(record, label, acceleration.size * float(ratio))
        offset = _estimate_constant_offset(
            acceleration, record.sampling_interval
        )  # The resampler assumes zeros beyond the ends.
        out = resample_poly(acceleration - offset, ratio.numerator, ratio.denominator) + offset
        return np.ascontiguousarray(out, dtype=np.float64)


class Cut(_ProcessingStep):
    """Keep only the samples of the record from the time ``start_s`` to ``end_s``."""

    step: Literal["cut"] = "cut"
    start_s: float = Field(default=0.0, ge=0, description="First sample kept, s after the record's start.")
    end_s: float | None = Field(default=None, gt=0, description="Last sample kept, s; none: to the end.")

    @model_validator(mode="after")
    def _check_time_order(self) -> "Cut":
        """Raise a ValueError unless the end lies after the start."""
        if self.end_s is not None and self.end_s <= self.start_s:
            raise ValueError(f"end_s {self.end_s:g} must lie after start_s {self.start_s:g}")
        return self

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: D102
        first = round(self.start_s / record.sampling_interval)
        last = acceleration.size if self.end_s is None else round(self.end_s / record.sampling_interval) + 1
        if last > acceleration.size or last - first < 2:
            what = f"cut from {self.start_s:g} s to {'the end' if self.end_s is None else f'{self.end_s:g} s'}"
            raise _unsuitable_step_error(
                record, what, f"two samples or more must lie within the record, {record.duration:g} s"
            )
        return acceleration[first:last].copy()

    def start_shift_of_record_s(self, sampling_interval: float) -> float:  # noqa: D102
        return round(self.start_s / sampling_interval) * sampling_interval


class Scale(_ProcessingStep):
    """Multiply every sample of a record by a factor."""

    step: Literal["scale"] = "scale"
    factor: float = Field(gt=0, description="Factor, without unit.")

    def apply_to_component(self, acceleration: FloatArray, record: Record) -> FloatArray:  # noqa: ARG002, D102
        return acceleration * self.factor


Step = Annotated[
    RemoveMean | Detrend | Taper | Highpass | Lowpass | Baseline | Resample | Cut | Scale,
    Field(discriminator="step"),
]
"""Any of the processing steps; the key ``step`` selects the class."""


def _refuse_step_at_user_time_after_auto_highpass(steps: Sequence[Step]) -> Sequence[Step]:
    """Raise a ValueError if a step with given times follows an automatic high-pass filter, which shifts the start."""
    moved = False  # True after a pad whose length depends on the automatic corner
    for step in steps:
        timed = isinstance(step, Cut | Baseline) or (isinstance(step, RemoveMean) and step.first_s is not None)
        if timed and moved:
            raise ValueError(
                f"{step.step} after highpass with corner_hz auto, which moves the start by as much as the corner says: "
                f"put {step.step} before it, or give corner_hz a number"
            )
        moved = moved or (isinstance(step, Highpass) and step.corner_hz == "auto")
    return steps


ProcessingSteps = Annotated[tuple[Step, ...], AfterValidator(_refuse_step_at_user_time_after_auto_highpass)]
"""Processing steps of a record, in the order in which they are applied."""
