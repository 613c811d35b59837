"""Apply processing steps to a record, in order, and record their parameters and effects."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from functools import partial
from typing import Any, Final, Literal

import numpy as np

from overturning.errors import RecordError
from overturning.motion.noise import shortest_usable_noise_window_s, signal_and_noise_spectra
from overturning.motion.plausible import implausible_amplitude_reason
from overturning.records.assembly import format_iso_utc_time
from overturning.records.record import Record, largest_pga_pgv_pgd_of_components
from overturning.records.site import SoilSite
from overturning.records.steps import Baseline, Highpass, RemoveMean, Resample, Step, Taper

FALLBACK_HIGHPASS_CORNER_HZ: Final = 0.1
"""Default corner frequency, Hz, without usable noise; analogue accelerographs do not resolve lower ones."""

MIN_SIGNAL_TO_NOISE_RATIO: Final = 3.0
"""Smallest signal-to-noise ratio of a usable signal, as usual for strong-motion data."""

AUTO_HIGHPASS_CORNER_BOUNDS_HZ: Final = (0.03, 1.0)
"""Lowest and highest corner frequency of the automatic choice, Hz."""


def default_processing_steps(record: Record, highpass_corner_hz: float | Literal["auto"] = "auto") -> tuple[Step, ...]:
    """Return the default processing steps of a record, used if the study sets none.

    Records that an agency processed, and synthetic ones, get no steps. Raw records get: mean removed, taper of 2 s (5 %
    of a short record), zero-phase Butterworth high-pass of order 2 at ``highpass_corner_hz``; with "auto", at the
    corner that `choose_highpass_corner_hz_and_reason` finds from the noise before the onset. Raises a
    `RecordError` for a raw record so short that a taper of 5 % contains no sample.
    """
    if record.extra.get("processed", False):
        return ()
    length = min(2.0, 0.05 * record.duration)
    if round(length / record.sampling_interval) < 1:
        raise RecordError(
            f"record {record.record_id}: {record.sample_count} samples are too few for the default processing (taper "
            "of 5 % at each end); declare the record processed, or set processing steps in the study"
        )
    return (RemoveMean(), Taper(length_s=length), Highpass(corner_hz=highpass_corner_hz, order=2))


def process_record(record: Record, steps: Sequence[Step] | None, site: SoilSite | None = None) -> Record:
    """Process a record by the given steps in order; then compute its motion on top of a site's soil layers, if given.

    If ``steps`` is None, they are `default_processing_steps`. ``processing`` of the returned record has one more entry
    per step: the step's parameters and, under ``effect``, the largest PGA (m/s²), PGV (m/s) and PGD (m) of north and
    east before and after. Raises a `RecordError` if a step does not fit the record (corner above the Nyquist frequency,
    cut beyond its end…), or if the result has implausible amplitudes.
    """
    steps = default_processing_steps(record) if steps is None else steps
    for step in steps:
        chosen = ""
        if isinstance(step, Highpass) and step.corner_hz == "auto":
            corner, chosen = choose_highpass_corner_hz_and_reason(record)
            step = step.model_copy(update={"corner_hz": corner})
        shift, change = (
            step.start_shift_of_record_s(record.sampling_interval),
            partial(step.apply_to_component, record=record),
        )
        interval = step.sampling_interval_s if isinstance(step, Resample) else record.sampling_interval
        changed = record.with_changed_components(change, sampling_interval=interval)
        if isinstance(step, Baseline) and (still := _names_of_unchanged_nonzero_components(record, changed)):
            chosen = f"nothing taken from {' and '.join(still)}, as the line is zero at no time before the fit"
        record = _copy_with_processing_entry_and_shifted_start(record, changed, step, chosen, shift)
    if site is not None:
        surface, chosen = site.propagate_record_to_surface_with_note(record)
        record = _copy_with_processing_entry_and_shifted_start(record, surface, site, chosen)
    # Unchanged records of an agency were checked when they were read.
    looked_at = not steps and site is None and record.extra.get("processed", False)
    if not (looked_at or record.user_trusts_data) and (
        why := implausible_amplitude_reason(record.components, record.sampling_interval)
    ):
        raise RecordError(
            f"record {record.record_id}: after processing, {why}; correct unit or steps, or say trust_data"
        )
    return record


def _names_of_unchanged_nonzero_components(record_before: Record, record_after: Record) -> list[str]:
    """Return the names of the non-zero components of a record that a processing step left unchanged."""
    pairs = zip(("north", "east", "up"), record_before.components, record_after.components, strict=False)
    return [name for name, was, now in pairs if was.any() and np.array_equal(was, now)]


def _copy_with_processing_entry_and_shifted_start(
    record_before: Record,
    record_after: Record,
    step_or_site: Step | SoilSite,
    note_on_parameter_choice: str,
    start_shift_to_later_s: float = 0.0,
) -> Record:
    """Return a copy of `record_after` with the start time shifted, and a processing entry for the step added."""
    peaks = [
        largest_pga_pgv_pgd_of_components(record.horizontal_components, record.sampling_interval)
        for record in (record_before, record_after)
    ]
    entry: dict[str, Any] = {"step": step_or_site.step, **step_or_site.model_dump(mode="json")}
    entry |= {"chosen": note_on_parameter_choice} if note_on_parameter_choice else {}
    entry["effect"] = {name: [each[name] for each in peaks] for name in peaks[0]}
    entry |= {"shift_s": round(start_shift_to_later_s, 9)} if start_shift_to_later_s else {}
    start = record_after.start
    start = start and format_iso_utc_time(datetime.fromisoformat(start) + timedelta(seconds=start_shift_to_later_s))
    return replace(record_after, processing=(*record_before.processing, entry), start=start)


def choose_highpass_corner_hz_and_reason(record: Record) -> tuple[float, str]:
    """Choose the corner frequency of a record's high-pass filter from its noise; return it (Hz) and the reason.

    The signal-to-noise ratio is the lower one of north and east; the noise is that before the onset plus the permanent
    offset. The corner is the lowest frequency from which the ratio is at least 3 up to the frequency of its maximum. If
    it is at least 3 from the lowest frequency of the spectrum on, the corner is that frequency, at most 0.1 Hz. Without
    usable noise the corner is 0.1 Hz; if the ratio is below 3 everywhere, 1 Hz. It is kept within 0.03 to 1 Hz.
    """
    if not (np.ptp(record.north) or np.ptp(record.east)):
        return FALLBACK_HIGHPASS_CORNER_HZ, "no horizontal motion"
    found = signal_and_noise_spectra([record.north, record.east], record.sampling_interval)
    if found is None:
        shortest = shortest_usable_noise_window_s(record.sampling_interval)
        return FALLBACK_HIGHPASS_CORNER_HZ, f"no noise of {shortest:g} s before the onset to compare with"
    window = f"noise of the first {found.onset_s:.1f} s"
    ratio = found.signal_over_noise_plus_offset_spectrum.min(axis=0)
    best = int(ratio.argmax())
    below = np.flatnonzero(ratio[: best + 1] < MIN_SIGNAL_TO_NOISE_RATIO)
    if ratio[best] < MIN_SIGNAL_TO_NOISE_RATIO:
        corner, reason = (
            AUTO_HIGHPASS_CORNER_BOUNDS_HZ[1],
            f"signal nowhere {MIN_SIGNAL_TO_NOISE_RATIO:g} times the {window}, so the highest corner is taken",
        )
    elif below.size:
        corner, last = float(found.band_centre_frequencies_hz[below[-1] + 1]), below[-1]
        row = int(found.signal_over_noise_plus_offset_spectrum[:, last].argmin())
        what = (
            "offset that the shock leaves"
            if found.baseline_step_amplitude_per_root_duration[row, last]
            > found.noise_amplitude_per_root_duration[row, last]
            else window
        )
        reason = f"signal less than {MIN_SIGNAL_TO_NOISE_RATIO:g} times the {what} below it"
    else:
        corner = min(float(found.band_centre_frequencies_hz[0]), FALLBACK_HIGHPASS_CORNER_HZ)
        reason = f"signal more than {MIN_SIGNAL_TO_NOISE_RATIO:g} times the {window} as far down as that tells"
        reason += (
            f", {found.band_centre_frequencies_hz[0]:.2g} Hz"
            if found.band_centre_frequencies_hz[0] > FALLBACK_HIGHPASS_CORNER_HZ
            else ""
        )
    low, high = AUTO_HIGHPASS_CORNER_BOUNDS_HZ
    if not low <= corner <= high:
        reason += f", kept within {low:g} to {high:g} Hz"
    return round(min(max(corner, low), high), 3), reason
