"""Assemble a record from the axes of a sensor: checks, rotation to north and east, description."""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.motion.direction import cosine_and_sine_of_azimuth
from overturning.motion.plausible import implausible_amplitude_reason
from overturning.records.axis_direction import is_vertical_axis_name_without_up_or_down
from overturning.records.component import (
    MIN_SINE_BETWEEN_HORIZONTAL_AXES,
    RecordComponent,
    agency_processing_metadata,
    checked_relative_header_peak_difference,
    find_vertical_by_elimination,
    non_perpendicular_axes_notes,
    note_on_sensor_high_in_structure,
)
from overturning.records.declared_properties import DeclaredFileProperties, VerticalSense
from overturning.records.doubts import report_dead_horizontal_axis, sample_quality_notes
from overturning.records.record import Record
from overturning.records.window import (
    AssemblyRefusalCollector,
    check_and_cut_to_common_window,
    common_window_processing_entries,
)


def format_iso_utc_time(time_or_none: datetime | None) -> str | None:
    """Format a time as ISO 8601 text in UTC; a time without zone counts as UTC, and None gives None."""
    if time_or_none is None:
        return None
    text = (
        (time_or_none if time_or_none.tzinfo else time_or_none.replace(tzinfo=UTC))
        .astimezone(UTC)
        .strftime("%Y-%m-%dT%H:%M:%S.%f")
    )
    return text.rstrip("0").rstrip(".") + "Z"


def _rotate_samples_to_north_east(
    first_axis_acceleration: FloatArray,
    first_axis_azimuth_deg: float,
    second_axis_acceleration: FloatArray,
    second_axis_azimuth_deg: float,
) -> tuple[FloatArray, FloatArray]:
    """Return north and east acceleration, from accelerations along two horizontal axes of given azimuths, degrees.

    Solves a₁ = n cos φ₁ + e sin φ₁, a₂ = n cos φ₂ + e sin φ₂, so the axes need not be exactly
    perpendicular.
    """
    c1, s1 = cosine_and_sine_of_azimuth(first_axis_azimuth_deg)
    c2, s2 = cosine_and_sine_of_azimuth(second_axis_azimuth_deg)
    determinant = round(c1 * s2 - c2 * s1, 12)
    # +0.0 turns a negative zero into zero, so that the stored bytes do not depend on the axes' order.
    north = (first_axis_acceleration * s2 - second_axis_acceleration * s1) / determinant + 0.0
    east = (second_axis_acceleration * c1 - first_axis_acceleration * c2) / determinant + 0.0
    return north, east


def assemble_record(
    components: Sequence[RecordComponent],
    record_id: str,
    user_declared_properties: DeclaredFileProperties | None = None,
    **replaced_fields: Any,
) -> Record:
    """Assemble one record from the components of one sensor: two horizontal ones and at most one vertical one.

    The components may be in any order. `user_declared_properties` gives axis directions and ``trust_data``, which
    accepts contradictions of header and data, different lengths and implausible amplitudes. `replaced_fields` replace
    fields of the files (station, event, licence…). A vertical axis of unknown sense is left out unless its sense is
    declared. A `RecordError` names all reasons against the record: missing or repeated components, an axis of unknown
    azimuth, axes of several sensors, different sampling intervals, starts or lengths, a header's peak that contradicts
    the data, a motion above 5 g or 1000 cm/s or below 0.0001 g.
    """
    user_declared_properties = user_declared_properties or DeclaredFileProperties()
    refusals = AssemblyRefusalCollector(accept_contradictions=user_declared_properties.trust_data)
    name = components[0].file_name if components else record_id
    components, notes = _set_unknown_vertical_sense_or_omit_with_notes(
        components, user_declared_properties.vertical_sense
    )
    notes += [
        note
        for component in components
        if (note := _note_on_ignored_user_properties(component, user_declared_properties))
    ]
    notes += dict.fromkeys(
        note for component in components if (note := note_on_sensor_high_in_structure(component.sensor_location))
    )
    differences = _relative_header_peak_difference_by_axis(components, refusals)
    by_files = [c for c in components if not c.vertical_sense]
    with refusals.suppress_record_error_and_keep_reasons():
        components = _order_components_set_azimuths_and_check(components, user_declared_properties.azimuths_deg, name)
        notes += non_perpendicular_axes_notes(components)
        notes += _declared_azimuth_mismatch_notes(components, by_files)
    if not components:
        refusals.raise_collected_reasons()
    window = _cut_to_window_and_check_samples(components, refusals, notes)
    refusals.raise_collected_reasons()
    azimuths = [((c.azimuth_deg or 0.0) + user_declared_properties.correction_deg) % 360.0 for c in window[:2]]
    north, east = _rotate_samples_to_north_east(
        window[0].acceleration, azimuths[0], window[1].acceleration, azimuths[1]
    )
    first = window[0]
    extra = _extra_record_metadata(
        window, user_declared_properties, notes, differences, refusals.contradictions_accepted_with_trust_data
    )
    hashes = list(dict.fromkeys(c.sha256 for c in window))
    station = replaced_fields.pop("station", first.station)
    if first.sensor_position == "borehole":
        station = station_name_with_word_borehole(station)
    of_files = {
        "station": station,
        "event": first.event,
        "source": " ".join(dict.fromkeys(c.file_name for c in window)),
        "latitude": first.station_latitude_deg,
        "longitude": first.station_longitude_deg,
    }
    return Record(
        record_id=record_id,
        north=north,
        east=east,
        up=window[2].acceleration * float(window[2].vertical_sense) + 0.0 if len(window) == 3 else None,
        sampling_interval=first.sampling_interval,
        start=format_iso_utc_time(first.start_time_utc),
        # Hash of the file; of the joined hashes if the record has several files.
        sha256=hashes[0] if len(hashes) == 1 else hashlib.sha256("".join(hashes).encode()).hexdigest(),
        component_azimuths_deg=tuple(azimuths),
        processing=common_window_processing_entries(components, window, north, east),
        extra=extra,
        **(of_files | replaced_fields),
    )


def _relative_header_peak_difference_by_axis(
    components: Sequence[RecordComponent], refusals_out: AssemblyRefusalCollector
) -> dict[str, float]:
    """Return |peak of samples − peak in header| / peak in header of each component, by axis name.

    Axes without a peak in the header are left out, and so are axes whose header peak contradicts the samples. A
    contradiction is added to `refusals_out`, as a reason to refuse the record unless the user trusts its data.
    """
    differences = {}
    for component in components:
        with refusals_out.suppress_record_error_and_keep_reasons():
            if (
                difference := checked_relative_header_peak_difference(
                    component, refusals_out.refuse_or_store_contradiction
                )
            ) is not None:
                differences[component.axis_name_in_file] = round(difference, 6)
    return differences


def _declared_azimuth_mismatch_notes(
    components_after_azimuth_declarations: Sequence[RecordComponent],
    components_with_azimuths_from_files: Sequence[RecordComponent],
) -> list[str]:
    """Return a note for each axis whose azimuth, as given by the user, differs from the azimuth in its file."""
    return [
        f"axis {c.axis_name_in_file!r} is taken at {c.azimuth_deg:g}°, as declared; "
        f"its file says {by_file.azimuth_deg:g}°"
        for c, by_file in zip(components_after_azimuth_declarations, components_with_azimuths_from_files, strict=False)
        if by_file.azimuth_deg is not None and (by_file.azimuth_deg - (c.azimuth_deg or 0.0)) % 360.0
    ]


def _cut_to_window_and_check_samples(
    components: Sequence[RecordComponent], refusals_out: AssemblyRefusalCollector, notes_out: list[str]
) -> Sequence[RecordComponent]:
    """Cut components to their common time window and check the samples.

    Reasons to refuse the record go to `refusals_out`, and notes on doubtful samples to `notes_out`.
    """
    window = components
    with refusals_out.suppress_record_error_and_keep_reasons():
        window = check_and_cut_to_common_window(components, refusals_out)
    # Skip this check after a peak that contradicts the header: its message is the better one for the same axis.
    if not refusals_out.has_refusal_reasons:
        with refusals_out.suppress_record_error_and_keep_reasons():
            report_dead_horizontal_axis(window, refusals_out.refuse_or_store_contradiction)
    with refusals_out.suppress_record_error_and_keep_reasons():
        notes_out += sample_quality_notes(window, refusals_out.refuse_or_store_contradiction)
    with refusals_out.suppress_record_error_and_keep_reasons():
        why = _implausible_amplitude_reason(window)
        if why and not refusals_out.trusts_contradictions:
            why = f"{why}: correct it, or say --trust-data (trust_data in the record table)"
            raise RecordError(f"{window[0].file_name}: {why}")
        refusals_out.contradictions_accepted_with_trust_data += [why] if why else []
    return window


def _extra_record_metadata(
    components_in_common_window: Sequence[RecordComponent],
    user_declared_properties: DeclaredFileProperties,
    notes: list[str],
    relative_header_peak_difference_by_axis: dict[str, float],
    contradictions_accepted_by_user: Sequence[str],
) -> dict[str, Any]:
    """Return the dictionary `Record.extra` of a record: properties for which the class `Record` has no field.

    Notes and contradictions that the readers of the files found are added to those given.
    """
    first = components_in_common_window[0]
    extra: dict[str, Any] = dict(first.extra_metadata) | {
        "format": first.format_name,
        "processed": first.is_already_corrected,
    }
    extra |= agency_processing_metadata(components_in_common_window)
    extra |= {"axes": [c.axis_name_in_file for c in components_in_common_window]} | (
        {"origin_time": format_iso_utc_time(first.origin_time_utc)} if first.origin_time_utc else {}
    )
    extra |= (
        {"header_peak_difference": relative_header_peak_difference_by_axis}
        if relative_header_peak_difference_by_axis
        else {}
    )
    if user_declared_properties.trust_data:
        by_reader = [text for c in components_in_common_window for text in c.extra_metadata.get("trusted", ())]
        extra |= {"trusted_data": True, "trusted": [*by_reader, *contradictions_accepted_by_user]}
    extra |= (
        {"notes": notes}
        if (notes := [*notes, *dict.fromkeys(n for c in components_in_common_window for n in c.notes)])
        else {}
    )
    borehole = ["borehole sensor"] if user_declared_properties.sensor == "borehole" else []
    # The azimuths are declared in the order of the files, so the text says which axis has which azimuth.
    stated = [] if user_declared_properties.azimuths_deg is None else components_in_common_window
    azimuths = [
        f"axis {c.axis_name_in_file!r} of {c.file_name} at {c.azimuth_deg:g}°"
        for c in stated
        if c.azimuth_deg is not None
    ]
    extra["declared"] = [
        *extra.get("declared", ()),
        *azimuths,
        *user_declared_properties.declared_axis_property_texts,
        *borehole,
    ]
    return extra


def station_name_with_word_borehole(station_name: str) -> str:
    """Add the word "borehole" to the name of a station, unless the name contains it already."""
    return station_name if "borehole" in station_name.lower() else f"{station_name} (borehole)".strip()


def _note_on_ignored_user_properties(
    component: RecordComponent, user_declared_properties: DeclaredFileProperties
) -> str:
    """Return a note if a unit, rate or state given by the user is ignored, since the file states another; else ""."""
    said = (
        [f"unit {user_declared_properties.unit}"]
        if user_declared_properties.unit not in (None, component.unit_declared_if_format_states_none)
        else []
    )
    if user_declared_properties.processed not in (None, component.is_already_corrected):
        said.append("processed" if user_declared_properties.processed else "raw")
    interval = component.sampling_interval
    if abs((user_declared_properties.sampling_interval_s or interval) - interval) > 1e-3 * interval:
        said.append(f"{user_declared_properties.sampling_interval_s:g} s")
    what = f"what is declared of axis {component.axis_name_in_file!r} ({', '.join(said)})"
    return f"{what} is not taken: {component.file_name} states its own" if said else ""


def _implausible_amplitude_reason(components: Sequence[RecordComponent]) -> str:
    """Return the reason why the amplitudes of components are implausible for ground motion; "" if plausible.

    For raw data, the mean is subtracted first and the velocity is not checked.
    """
    raw = not all(c.is_already_corrected for c in components)
    moving = [c.acceleration - c.acceleration.mean() if raw else c.acceleration for c in components]
    if not any(samples.any() for samples in moving):
        return "every sample is the same, as of a dead channel"
    return implausible_amplitude_reason(
        moving,
        components[0].sampling_interval,
        declared_unit_if_file_states_none=components[0].unit_declared_if_format_states_none,
        check_velocity=not raw,
    )


def _order_components_set_azimuths_and_check(
    components: Sequence[RecordComponent],
    declared_horizontal_azimuths_deg: Sequence[float] | None,
    file_name_for_errors: str,
) -> list[RecordComponent]:
    """Order the components of a record: two horizontal ones, then a vertical one; set azimuths that the user gives.

    Raises a RecordError for other numbers of components, unknown azimuths, and horizontal axes not near a right angle.
    """
    vertical = [c for c in components if c.vertical_sense]
    horizontal = [c for c in components if not c.vertical_sense]
    if len(horizontal) != 2 or len(vertical) > 1:
        axes = ", ".join(c.axis_name_in_file for c in components) or "none"
        raise RecordError(
            f"{file_name_for_errors}: components {axes}; a record has two horizontal components and at most one "
            "vertical one: give the files of one sensor together"
        )
    if declared_horizontal_azimuths_deg is not None:
        if len(declared_horizontal_azimuths_deg) != 2:
            raise RecordError(
                f"{file_name_for_errors}: {len(declared_horizontal_azimuths_deg)} azimuths given; two are needed, one "
                "per horizontal axis"
            )
        horizontal = [
            replace(c, azimuth_deg=float(a)) for c, a in zip(horizontal, declared_horizontal_azimuths_deg, strict=True)
        ]
    known = [c.azimuth_deg for c in horizontal if c.azimuth_deg is not None]
    if len(known) < 2:
        files = " ".join(dict.fromkeys(c.file_name for c in horizontal if c.azimuth_deg is None))
        axes = ", ".join(repr(c.axis_name_in_file) for c in horizontal if c.azimuth_deg is None)
        raise RecordError(
            f"{files}: axis {axes} says nothing about north; give the azimuths of the two axes (azimuths_deg in the "
            "record table, --azimuths here)"
        )
    if abs(math.sin(math.radians(known[1] - known[0]))) < MIN_SINE_BETWEEN_HORIZONTAL_AXES:
        raise RecordError(
            f"{file_name_for_errors}: horizontal axes at {known[0]:g} and {known[1]:g} degrees; they must be near a "
            "right angle: give two components of one sensor"
        )
    return [*horizontal, *vertical]


def _set_unknown_vertical_sense_or_omit_with_notes(
    components: Sequence[RecordComponent], declared_vertical_sense: VerticalSense | None
) -> tuple[list[RecordComponent], list[str]]:
    """Set a vertical axis of unknown sense to the sense (up or down) given by the user, or omit it; return notes."""
    vertical = {"up": 1, "down": -1}.get(declared_vertical_sense or "", 0)
    kept, notes, third = [], [], find_vertical_by_elimination(components)
    for component in components:
        if (
            declared_vertical_sense == "none" and component.vertical_sense
        ):  # Left out as declared, although its sense is known.
            continue
        unknown = component.azimuth_deg is None and not component.vertical_sense
        if not (
            unknown and (component is third or is_vertical_axis_name_without_up_or_down(component.axis_name_in_file))
        ):
            kept.append(component)
            if vertical * component.vertical_sense < 0:
                notes.append(
                    f"axis {component.axis_name_in_file!r} is not taken {declared_vertical_sense}, as declared: "
                    "its file says the opposite"
                )
        elif vertical:
            kept.append(replace(component, vertical_sense=vertical))
        elif declared_vertical_sense is None:
            notes.append(
                f"vertical axis {component.axis_name_in_file!r} left out: {component.file_name} does not say whether "
                f"up or "
                "down; to use it declare vertical_sense up or down (in the record table; --vertical-sense on the "
                "command line)"
            )
    return kept, notes
