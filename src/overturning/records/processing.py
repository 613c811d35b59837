"""Apply processing steps to a record, in order, and write down what they did."""

import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from fractions import Fraction
from functools import partial
from typing import Any, Final, Literal

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.motion.integration import integrate
from overturning.motion.noise import noise_ratio
from overturning.motion.plausible import implausible
from overturning.records.assembly import iso
from overturning.records.record import Record, peaks_of
from overturning.records.steps import (
    Baseline,
    Cut,
    Detrend,
    Filter,
    Highpass,
    RemoveMean,
    Resample,
    Scale,
    Site,
    Step,
    Taper,
)

LARGEST_RATIO = 1000
"""Largest numerator or denominator of a resampling ratio."""

DEFAULT_HZ: Final = 0.1
"""Corner of the default processing, Hz; what is below it an accelerograph of the film age does not resolve."""

SIGNAL_TO_NOISE: Final = 3.0
"""Signal-to-noise ratio from which on a signal is taken for one, as is usual for strong-motion data."""

BOUNDS_HZ: Final = (0.03, 1.0)
"""Lowest and highest corner that is chosen by itself, Hz."""


def default_steps(record: Record, corner_hz: float | Literal["auto"] = DEFAULT_HZ) -> tuple[Step, ...]:
    """The steps for a record whose study names none.

    Files that an agency has processed, and synthetic records, are left alone. Raw ones lose their mean and the long
    periods that an accelerograph does not resolve: mean, taper of 2 s (5 % of a short record), zero-phase Butterworth
    high-pass of order 2 at 0.1 Hz, or at another corner.
    """
    if record.extra.get("processed", False):
        return ()
    return (RemoveMean(), Taper(length_s=min(2.0, 0.05 * record.duration)), Highpass(corner_hz=corner_hz, order=2))


def process(record: Record, steps: Sequence[Step] | None, site: Site | None = None) -> Record:
    """Apply steps in order, :func:`default_steps` of the record where None; then take it through the soil of a site.

    Returns
    -------
    Record
        With one entry per step added to ``processing``: the step's parameters and, under ``effect``, the largest PGA
        (m/s²), PGV (m/s) and PGD (m) of north and east before and after.

    Raises
    ------
    RecordError
        If a step does not fit the record (corner above the Nyquist frequency, cut beyond its end…), or what comes out
        is not the size of a ground motion.
    """
    steps = default_steps(record) if steps is None else steps
    for step in (*steps, *([] if site is None else [site])):
        chosen: dict[str, str] = {}
        if isinstance(step, Highpass) and step.corner_hz == "auto":
            corner, reason = choose_corner(record)
            step, chosen = step.model_copy(update={"corner_hz": corner}), {"chosen": reason}
        before = peaks_of(record.horizontal, record.sampling_interval)
        interval = step.sampling_interval_s if isinstance(step, Resample) else record.sampling_interval
        changed, shift = partial(_apply, step, record, chosen), _shift(step, record.sampling_interval)
        record = record.with_each(changed, sampling_interval=interval, start=_start_after(record, shift))
        after = peaks_of(record.horizontal, record.sampling_interval)
        effect = {name: [before[name], after[name]] for name in before}
        entry: dict[str, Any] = {"step": step.step, **step.model_dump(mode="json"), **chosen, "effect": effect}
        entry |= {"shift_s": round(shift, 9)} if shift else {}
        record = replace(record, processing=(*record.processing, entry))
    # A record that its agency has processed and nobody else has been looked at when it was read.
    looked_at = not steps and site is None and record.extra.get("processed", False)
    if not (looked_at or record.trusted) and (why := implausible(record.components, record.sampling_interval)):
        raise _refused(record, f"after processing, {why}", "correct unit or steps, or say trust_data")
    return record


def _shift(step: Step | Site, interval: float) -> float:
    """Time of the first sample after a step less that before it, s."""
    match step:
        case Cut():
            return round(step.start_s / interval) * interval
        case Highpass():
            return -_pad(step, interval) * interval
    return 0.0


def _start_after(record: Record, shift: float) -> str | None:
    moment = None if record.start is None else datetime.fromisoformat(record.start)
    return None if moment is None else iso(moment + timedelta(seconds=shift))


def _refused(record: Record, key: str, why: str) -> RecordError:
    return RecordError(f"record {record.record_id}: {key}; {why}")


def _apply(step: Step | Site, record: Record, told: dict[str, str], samples: FloatArray) -> FloatArray:
    interval = record.sampling_interval
    match step:
        case RemoveMean():
            return samples - samples[: _pre_event(step, record)].mean()
        case Detrend():
            return _detrend(samples, step.order)
        case Taper():
            return samples * _bell(samples.size, step, record)
        case Filter():
            return _butterworth(samples, step, record)
        case Baseline():
            return _boore_2001(samples, step, record)
        case Resample():
            return _resample(samples, step, record)
        case Cut():
            first = round(step.start_s / interval)
            last = samples.size if step.end_s is None else round(step.end_s / interval) + 1
            if last > samples.size or last - first < 2:
                what = f"cut from {step.start_s:g} to {step.end_s} s"
                raise _refused(record, what, f"the record ends at {record.duration:g} s")
            return samples[first:last].copy()
        case Scale():
            return samples * step.factor
        case Site():
            return _to_surface(samples, step, record, told)


def _to_surface(samples: FloatArray, step: Site, record: Record, told: dict[str, str]) -> FloatArray:
    from overturning.motion.soil import TAIL, Soil, through_soil

    if samples is record.up:
        return np.pad(samples, (0, round(TAIL / record.sampling_interval)))
    layers = [Soil(one.thickness_m, one.velocity_m_s, one.density_kg_m3, one.damping, one.curve) for one in step.layers]
    layers.append(Soil(0, step.rock.velocity_m_s, step.rock.density_kg_m3, step.rock.damping))
    passed = through_soil(samples, record.sampling_interval, layers, outcrop=step.motion == "outcrop")
    if any(one.curve for one in step.layers):
        axis = "north" if samples is record.north else "east"
        state = "converged" if passed.converged else f"not converged (last change {100 * passed.change:.1f} %)"
        told["chosen"] = "; ".join(
            [
                *([told["chosen"]] if "chosen" in told else []),
                f"{axis} {state}, strain {100 * passed.largest_strain:.2g} %",
            ]
        )
    return passed.samples


def _pre_event(step: RemoveMean, record: Record) -> int | None:
    if step.first_s is None:
        return None
    count = round(step.first_s / record.sampling_interval)
    if not 1 <= count <= record.north.size:
        bounds = f"it must lie between one sample and {record.duration:g} s"
        raise _refused(record, f"remove_mean.first_s {step.first_s:g}", bounds)
    return count


def _detrend(samples: FloatArray, order: int) -> FloatArray:
    # Legendre polynomials on [-1, 1] keep the least-squares problem well conditioned at every length.
    abscissa = np.linspace(-1.0, 1.0, samples.size)
    fit = np.polynomial.legendre.legfit(abscissa, samples, order)
    return np.asarray(samples - np.polynomial.legendre.legval(abscissa, fit), dtype=np.float64)


def _bell(count: int, step: Taper, record: Record) -> FloatArray:
    width = round(step.length_s / record.sampling_interval)
    if not 1 <= width <= count // 2:
        bounds = f"it must lie between one sample and half the record, {0.5 * record.duration:g} s"
        raise _refused(record, f"taper.length_s {step.length_s:g}", bounds)
    window = np.ones(count)
    window[:width] = 0.5 * (1.0 - np.cos(np.pi * np.arange(width) / width))
    window[-width:] = window[:width][::-1]
    return window


def _butterworth(samples: FloatArray, step: Filter, record: Record) -> FloatArray:
    from scipy.signal import butter, sosfiltfilt

    nyquist = 0.5 / record.sampling_interval
    corner = float(step.corner_hz)
    if corner >= nyquist:
        what = f"{step.step}.corner_hz {corner:g}"
        raise _refused(record, what, f"it must lie below the Nyquist frequency {nyquist:g} Hz")
    sections = butter(step.order, corner, btype=step.step, fs=1.0 / record.sampling_interval, output="sos")
    pad = _pad(step, record.sampling_interval)
    filtered = sosfiltfilt(sections, np.pad(samples, pad), padtype=None)
    # A zero-phase high-pass filter acts before the first sample too. Stripped of its pads its output would integrate to
    # a velocity that drifts (Boore, Sisi & Akkar 2012, BSSA 102, 751-760), so they stay.
    kept = filtered if isinstance(step, Highpass) else filtered[pad : pad + samples.size]
    return np.ascontiguousarray(kept, dtype=np.float64)


def _pad(step: Filter, interval: float) -> int:
    """Zeros at each end in which the filter rings out: 1.5 n / f_c seconds (Converse & Brady 1992, BAP)."""
    return math.ceil(1.5 * step.order / float(step.corner_hz) / interval)


def _boore_2001(samples: FloatArray, step: Baseline, record: Record) -> FloatArray:
    interval = record.sampling_interval
    time = np.arange(samples.size) * interval
    end = time >= step.fit_from_s - 1e-9
    if end.sum() < 10:
        bounds = f"the record ends at {record.duration:g} s and the fit needs ten samples"
        raise _refused(record, f"baseline.fit_from_s {step.fit_from_s:g}", bounds)
    velocity = integrate(samples, interval)
    # Solve about the middle of the fitted part: well conditioned however late it lies.
    middle = float(time[end].mean())
    final, at_middle = np.polyfit(time[end] - middle, velocity[end], 1)
    at_zero = at_middle - final * middle
    corrected = samples.copy()
    if step.t1_s is None or step.t2_s is None:
        # Where the fitted line is zero; outside of the record there is no step to take away.
        t2 = -at_zero / final if final else math.inf
        if 0.0 <= t2 <= step.fit_from_s:
            corrected[time >= t2] -= final
        return corrected
    mean = (at_zero + final * step.t2_s) / (step.t2_s - step.t1_s)
    corrected[(time >= step.t1_s) & (time < step.t2_s)] -= mean
    corrected[time >= step.t2_s] -= final
    return corrected


def _resample(samples: FloatArray, step: Resample, record: Record) -> FloatArray:
    from scipy.signal import resample_poly

    exact = record.sampling_interval / step.sampling_interval_s
    ratio = Fraction(exact).limit_denominator(LARGEST_RATIO)
    if ratio.numerator > LARGEST_RATIO or ratio == 0 or not math.isclose(float(ratio), exact, rel_tol=1e-7):
        what = f"resample.sampling_interval_s {step.sampling_interval_s:g} from {record.sampling_interval:g}"
        raise _refused(record, what, f"their ratio must be a fraction of whole numbers up to {LARGEST_RATIO}")
    if ratio == 1:
        return samples
    out = resample_poly(samples, ratio.numerator, ratio.denominator)
    return np.ascontiguousarray(out, dtype=np.float64)


def choose_corner(record: Record) -> tuple[float, str]:
    """Corner frequency, Hz, and the reason for it.

    It is the lowest frequency from which on, up to that of the largest ratio, the signal of both horizontal components
    is three times the noise before the onset; without such noise the default.
    """
    found = noise_ratio([record.north, record.east], record.sampling_interval)
    if found is None:
        return DEFAULT_HZ, f"no noise of 2 s before the onset to compare with: the default, {DEFAULT_HZ:g} Hz"
    window = f"noise of the first {found.onset:.1f} s"
    ratio = found.ratio.min(axis=0)
    best = int(ratio.argmax())
    below = np.flatnonzero(ratio[: best + 1] < SIGNAL_TO_NOISE)
    if ratio[best] < SIGNAL_TO_NOISE:
        corner, reason = BOUNDS_HZ[1], f"signal nowhere {SIGNAL_TO_NOISE:g} times the {window}: the highest corner"
    elif below.size:
        corner = float(found.frequency[below[-1] + 1])
        reason = f"signal less than {SIGNAL_TO_NOISE:g} times the {window} below it"
    else:
        corner = float(found.frequency[0])
        reason = f"signal more than {SIGNAL_TO_NOISE:g} times the {window} as far down as that tells"
    low, high = BOUNDS_HZ
    if not low <= corner <= high:
        reason += f"; kept within {low:g} to {high:g} Hz"
    return round(min(max(corner, low), high), 3), reason
