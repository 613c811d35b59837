"""Assemble a record from the axes of a sensor: common window, rotation to north and east, checks."""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError, RefusalReasons
from overturning.motion.direction import direction_cosines
from overturning.motion.plausible import implausibility
from overturning.records.component import (
    MINIMUM_SINE,
    Component,
    agency_processing_of,
    check_peak,
    is_unsigned_vertical,
    seed_sensor,
    skew_notes,
    structure_note,
    third_axis,
)
from overturning.records.declarations import Declarations, VerticalSense
from overturning.records.doubts import check_dead_axis, sample_notes
from overturning.records.earthquakes import distance_km
from overturning.records.record import Record, peaks_of

MAX_SPREAD_S = 0.5
"""Largest difference in start or in length between components of one record, s."""

MIN_WINDOW_PEAK = 0.8
"""Smallest share of a component's peak in the common window, if lengths differ by more than `MAX_SPREAD_S`."""

MAX_STATION_DISTANCE_KM = 1.0
"""Largest distance between stated places of one station, km; files round them to degrees or minutes."""


def iso(moment: datetime | None) -> str | None:
    """Return a time (default zone UTC) as ISO 8601 in UTC, without trailing zeros of the second."""
    if moment is None:
        return None
    text = (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%S.%f")
    return text.rstrip("0").rstrip(".") + "Z"


def _to_north_east(
    first: FloatArray, first_azimuth_deg: float, second: FloatArray, second_azimuth_deg: float
) -> tuple[FloatArray, FloatArray]:
    """Rotate two horizontal components to north and east.

    Solves a₁ = n cos φ₁ + e sin φ₁, a₂ = n cos φ₂ + e sin φ₂, so the axes need not be exactly perpendicular.
    """
    c1, s1 = direction_cosines(first_azimuth_deg)
    c2, s2 = direction_cosines(second_azimuth_deg)
    determinant = round(c1 * s2 - c2 * s1, 12)
    # +0.0 turns a negative zero into zero, so that the stored bytes do not depend on the axes' order.
    north = (first * s2 - second * s1) / determinant + 0.0
    east = (second * c1 - first * c2) / determinant + 0.0
    return north, east


class _AssemblyReasons(RefusalReasons):
    """Reasons against a record, raised together, and contradictions that are trusted."""

    def __init__(self, *, trusting: bool) -> None:
        super().__init__()
        self.trusting = trusting
        self.trusted: list[str] = []

    @property
    def has_reasons(self) -> bool:
        """True if there are reasons against the record already."""
        return bool(self._found)

    def contradict(self, why: str, remedy: str) -> None:
        """Refuse a contradiction, or note that it is trusted."""
        if not self.trusting:
            raise RecordError(f"{why}; {remedy}")
        self.trusted.append(why)


def _common_window(components: Sequence[Component], reasons: _AssemblyReasons) -> list[Component]:
    """Cut components to the samples that all of them have.

    Starts are rounded to whole samples relative to the latest; a shift of less than half a sample remains. Raises a
    RecordError if the rates differ, or the starts by more than 0.5 s. Lengths may differ in one file, because recorders
    stop channels one after another. Different lengths of several files, different stations, earthquakes, sensors or
    places, and a mixture of raw and processed data are contradictions, which ``trust_data`` accepts.
    """
    said = [
        (c.station, c.extra.get("network", ""), c.event, "processed" if c.processed else "raw", c.location, sensor)
        for c, sensor in zip(components, map(seed_sensor, components), strict=True)
    ]
    for texts in zip(*said, strict=True):
        named = {" ".join(text.split()).casefold(): text for text in texts if text}
        if len(named) > 1:
            why = f"{components[0].file}: components of {' and '.join(map(repr, named.values()))}"
            remedy = "give the files of one sensor together, or say --trust-data if it is one record anyway"
            reasons.contradict(why, f"they are not of one record: {remedy}")
    interval = components[0].sampling_interval
    for other in components[1:]:
        if not math.isclose(other.sampling_interval, interval, rel_tol=1e-6):
            raise RecordError(
                f"{other.file}: sampling interval {other.sampling_interval:g} s along {other.axis}, "
                f"{components[0].file} has {interval:g} s; components of one record must share it"
            )
    _check_one_place(components, reasons)
    starts = [c.start for c in components if c.start is not None]
    offsets = [0] * len(components)
    if 0 < len(starts) < len(components):
        undated = " and ".join(f"{c.axis} of {c.file}" for c in components if c.start is None)
        remedy = "give it the start that it has, or say --trust-data to take first samples as those of one time"
        reasons.contradict(f"{undated} does not say when it begins, other components do", remedy)
    if len(starts) == len(components):
        latest = max(starts)
        spread = (latest - min(starts)).total_seconds()
        if spread > MAX_SPREAD_S:
            raise RecordError(
                f"{components[0].file}: components start {spread:.2f} s apart (at most {MAX_SPREAD_S} s); "
                "they are not of one record"
            )
        offsets = [round((latest - start).total_seconds() / interval) for start in starts]
    sizes = [c.samples.size for c in components]
    spread = (max(sizes) - min(sizes)) * interval
    one_file = len({c.sha256 for c in components}) == 1 or all(c.film for c in components)
    if spread > MAX_SPREAD_S + 0.5 * interval and not one_file:
        counts = f"{' and '.join(map(str, sizes))} samples, {spread:.2f} s apart (at most {MAX_SPREAD_S} s)"
        remedy = "get the file again, or say --trust-data to keep the common part"
        reasons.contradict(f"{components[0].file}: components have {counts}", remedy)
    length = min(size - offset for size, offset in zip(sizes, offsets, strict=True))
    if length < 2:
        raise RecordError(f"{components[0].file}: components have no common window")
    cut = []
    for component, offset in zip(components, offsets, strict=True):
        start = component.start and component.start + timedelta(seconds=offset * interval)
        cut.append(replace(component, samples=component.samples[offset : offset + length], start=start))
    if spread > MAX_SPREAD_S:
        _check_window_peak(components, cut, reasons)
    return cut


def _check_one_place(components: Sequence[Component], reasons: _AssemblyReasons) -> None:
    """Refuse components that state two places of one station."""
    places = [(c.latitude, c.longitude) for c in components if c.latitude is not None and c.longitude is not None]
    for place in places[1:]:
        if (apart := distance_km(places[0], place)) > MAX_STATION_DISTANCE_KM:
            first, other = (f"{north:g}° N, {east:g}° E" for north, east in (places[0], place))
            why = f"{components[0].file}: components at {first} and at {other}, {apart:.3g} km apart"
            remedy = "give the files of one sensor together, or say --trust-data if it is one record anyway"
            reasons.contradict(why, f"they are not of one record: {remedy}")


def _check_window_peak(whole: Sequence[Component], window: Sequence[Component], reasons: _AssemblyReasons) -> None:
    """Refuse a common window that holds less than `MIN_WINDOW_PEAK` of a component's peak."""
    for component, kept in zip(whole, window, strict=True):
        level = component.samples.mean()
        peak, left = (float(np.abs(samples - level).max()) for samples in (component.samples, kept.samples))
        if left < MIN_WINDOW_PEAK * peak:
            short, size = min(whole, key=lambda one: one.samples.size), component.samples.size
            why = (
                f"{short.file}: {short.axis} breaks off after {short.samples.size} of {size} samples, before the "
                f"largest motion along {component.axis} ({100 * left:.4g} Gal until then, {100 * peak:.4g} later)"
            )
            remedy = "get the file again, leave that component out, or say --trust-data to keep the common part"
            reasons.contradict(why, remedy)


def assemble(
    components: Sequence[Component], record_id: str, declared: Declarations | None = None, **stated: Any
) -> Record:
    """Make one record of the components of one sensor: two horizontal axes and at most one vertical one, in any order.

    `declared` gives directions of the axes and ``trust_data``, which accepts contradictions of header and data,
    different lengths and implausible amplitudes. `stated` are fields that replace those of the files (station, event,
    licence…). A vertical axis of unknown sense is left out unless its sense is declared. A `RecordError` names all
    reasons against the record: missing or repeated components, an unknown axis, a sensor that was not declared,
    different rates, starts or lengths, a header's peak that contradicts the data, a motion above 5 g or 1000 cm/s or
    below 0.0001 g.
    """
    declared = declared or Declarations()
    reasons = _AssemblyReasons(trusting=declared.trust_data)
    name = components[0].file if components else record_id
    components, notes = _apply_vertical_sense(components, declared.vertical_sense)
    notes += [note for component in components if (note := _unused_declaration_note(component, declared))]
    notes += dict.fromkeys(note for component in components if (note := structure_note(component.location)))
    differences: dict[str, float] = {}
    for component in components:
        with reasons.collect():
            if (difference := check_peak(component, reasons.contradict)) is not None:
                differences[component.axis] = round(difference, 6)
    by_files = [c for c in components if not c.vertical]
    with reasons.collect():
        components = _axes(components, declared.azimuths_deg, name)
        notes += skew_notes(components)
        notes += [
            f"axis {c.axis!r} is taken at {c.azimuth_deg:g}°, as declared; its file says {was.azimuth_deg:g}°"
            for c, was in zip(components, by_files, strict=False)
            if was.azimuth_deg is not None and (was.azimuth_deg - (c.azimuth_deg or 0.0)) % 360.0
        ]
    if not components:
        reasons.raise_all()
    window = components
    with reasons.collect():
        window = _common_window(components, reasons)
    # Skip this check after a peak that contradicts the header: its message is the better one for the same axis.
    if not reasons.has_reasons:
        with reasons.collect():
            check_dead_axis(window, reasons.contradict)
    with reasons.collect():
        notes += sample_notes(window, reasons.contradict)
    with reasons.collect():
        if (why := _check_amplitude(window)) and not declared.trust_data:
            why = f"{why}: correct it, or say --trust-data (trust_data in the record table)"
            raise RecordError(f"{window[0].file}: {why}")
    reasons.raise_all()
    trusted = [text for c in window for text in c.extra.get("trusted", ())] + reasons.trusted + ([why] if why else [])
    azimuths = [((c.azimuth_deg or 0.0) + declared.correction_deg) % 360.0 for c in window[:2]]
    north, east = _to_north_east(window[0].samples, azimuths[0], window[1].samples, azimuths[1])
    first = window[0]
    borehole = ["borehole sensor"] if declared.sensor == "borehole" else []
    extra: dict[str, Any] = dict(first.extra) | {"format": first.format, "processed": first.processed}
    extra |= agency_processing_of(window)
    extra |= {"axes": [c.axis for c in window]} | ({"origin_time": iso(first.origin)} if first.origin else {})
    extra |= {"header_peak_difference": differences} if differences else {}
    extra |= {"trusted_data": True, "trusted": trusted} if declared.trust_data else {}
    extra |= {"notes": notes} if (notes := [*notes, *dict.fromkeys(n for c in window for n in c.notes)]) else {}
    extra["declared"] = [*extra.get("declared", ()), *declared.axis_declarations, *borehole]
    hashes = list(dict.fromkeys(c.sha256 for c in window))
    station = stated.pop("station", first.station)
    if first.sensor == "borehole":
        station = borehole_name(station)
    of_files = {
        "station": station,
        "event": first.event,
        "source": " ".join(dict.fromkeys(c.file for c in window)),
        "latitude": first.latitude,
        "longitude": first.longitude,
    }
    return Record(
        record_id=record_id,
        north=north,
        east=east,
        up=window[2].samples * float(window[2].vertical) + 0.0 if len(window) == 3 else None,
        sampling_interval=first.sampling_interval,
        start=iso(first.start),
        # Hash of the file; of the joined hashes if the record has several files.
        sha256=hashes[0] if len(hashes) == 1 else hashlib.sha256("".join(hashes).encode()).hexdigest(),
        component_azimuths_deg=tuple(azimuths),
        processing=_cut_to_common(components, window, north, east),
        extra=extra,
        **(of_files | stated),
    )


def borehole_name(station: str) -> str:
    """Return the name of a station with the word borehole, unless it has it already."""
    return station if "borehole" in station.lower() else f"{station} (borehole)".strip()


def _unused_declaration_note(component: Component, declared: Declarations) -> str:
    """Return a note on declarations that are not used because the file states its own values; "" if none."""
    said = [f"unit {declared.unit}"] if declared.unit not in (None, component.unit) else []
    if declared.processed not in (None, component.processed):
        said.append("processed" if declared.processed else "raw")
    interval = component.sampling_interval
    if abs((declared.sampling_interval_s or interval) - interval) > 1e-3 * interval:
        said.append(f"{declared.sampling_interval_s:g} s")
    what = f"what is declared of axis {component.axis!r} ({', '.join(said)})"
    return f"{what} is not taken: {component.file} states its own" if said else ""


def _check_amplitude(components: Sequence[Component]) -> str:
    """Return the reason why the amplitudes are implausible, "" if none; raw data without mean, and without PGV."""
    raw = not all(c.processed for c in components)
    moving = [c.samples - c.samples.mean() if raw else c.samples for c in components]
    if not any(samples.any() for samples in moving):
        return "every sample is the same, as of a dead channel"
    return implausibility(moving, components[0].sampling_interval, unit=components[0].unit, pgv=not raw)


def _cut_to_common(
    whole: Sequence[Component], window: Sequence[Component], north: FloatArray, east: FloatArray
) -> tuple[dict[str, Any], ...]:
    """Return the processing step of the common window; empty if all components have the same length."""
    sizes = {c.axis: c.samples.size for c in whole}
    kept, interval = window[0].samples.size, window[0].sampling_interval
    left_out = max(sizes.values()) - kept
    found = peaks_of(np.stack([north, east]), interval)
    step = {"step": "common_window", "samples": sizes, "kept": kept, "left_out_s": round(left_out * interval, 6)}
    return (step | {"effect": {name: [peak, peak] for name, peak in found.items()}},) if left_out else ()


def _axes(components: Sequence[Component], azimuths_deg: Sequence[float] | None, name: str) -> list[Component]:
    """Return the two horizontal components with their azimuths, then the vertical one, if any."""
    vertical = [c for c in components if c.vertical]
    horizontal = [c for c in components if not c.vertical]
    if len(horizontal) != 2 or len(vertical) > 1:
        axes = ", ".join(c.axis for c in components) or "none"
        raise RecordError(
            f"{name}: components {axes}; a record has two horizontal components and at most one vertical one: "
            "give the files of one sensor together"
        )
    if azimuths_deg is not None:
        if len(azimuths_deg) != 2:
            raise RecordError(f"{name}: {len(azimuths_deg)} azimuths given; two are needed, one per horizontal axis")
        horizontal = [replace(c, azimuth_deg=float(a)) for c, a in zip(horizontal, azimuths_deg, strict=True)]
    known = [c.azimuth_deg for c in horizontal if c.azimuth_deg is not None]
    if len(known) < 2:
        files = " ".join(dict.fromkeys(c.file for c in horizontal if c.azimuth_deg is None))
        axes = ", ".join(repr(c.axis) for c in horizontal if c.azimuth_deg is None)
        raise RecordError(
            f"{files}: axis {axes} says nothing about north; give the azimuths of the two axes (azimuths_deg in the "
            "record table, --azimuths here)"
        )
    if abs(math.sin(math.radians(known[1] - known[0]))) < MINIMUM_SINE:
        raise RecordError(
            f"{name}: horizontal axes at {known[0]:g} and {known[1]:g} degrees; they must be near a right angle: give "
            "two components of one sensor"
        )
    return [*horizontal, *vertical]


def _apply_vertical_sense(
    components: Sequence[Component], sense: VerticalSense | None
) -> tuple[list[Component], list[str]]:
    """Give vertical axes of unknown sense the declared one, or leave them out; return the components and notes."""
    vertical = {"up": 1, "down": -1}.get(sense or "", 0)
    kept, notes, third = [], [], third_axis(components)
    for component in components:
        if sense == "none" and component.vertical:  # Left out as declared, although its sense is known.
            continue
        unknown = component.azimuth_deg is None and not component.vertical
        if not (unknown and (component is third or is_unsigned_vertical(component.axis))):
            kept.append(component)
            if vertical * component.vertical < 0:
                notes.append(f"axis {component.axis!r} is not taken {sense}, as declared: its file says the opposite")
        elif vertical:
            kept.append(replace(component, vertical=vertical))
        elif sense is None:
            notes.append(
                f"vertical axis {component.axis!r} left out: {component.file} does not say whether up or down; to use "
                "it declare vertical_sense up or down (in the record table; --vertical-sense on the command line)"
            )
    return kept, notes
