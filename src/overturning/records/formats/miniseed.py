"""MiniSEED with StationXML, read by obspy: the channel's gain or response converts counts to acceleration."""

import io
from datetime import UTC
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError, RecordRefusalReasonCollector
from overturning.records.axis_direction import (
    channel_direction_mismatch_notes,
    direction_with_channel_code_fallback_and_notes,
)
from overturning.records.component import RecordComponent, classify_as_borehole_or_else_surface
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.formats.stationxml import (
    acceleration_unit_in_m_s2,
    find_channel_epoch,
    is_metre_per_second,
    normalise_filter_coefficient_sums_with_notes,
    read_stationxml_inventory,
)
from overturning.records.source import SourceFile
from overturning.units import ACCELERATION_UNITS_IN_M_S2

MAX_TAPER_DURATION_S: Final = 5.0
"""Longest taper at each end before a response is removed, s."""
BLANK_LOCATION_CODE: Final = "--"
"""Written form of a blank location code; it distinguishes sensors like any other code."""
VELOCITY_SENSOR_FULL_SCALE_M_S: Final = 0.01
"""Velocity at which most velocity sensors reach the end of their range, m/s."""


def read_components(source_file: SourceFile, user_declared_properties: DeclaredFileProperties) -> list[RecordComponent]:
    """Read the components of a MiniSEED file; a RecordError for damage, gaps, or if StationXML is missing."""
    size = len(source_file.data)
    if size % 128:
        why = f"{size} bytes are no whole number of MiniSEED records; it is cut: get it again"
        raise RecordError(f"{source_file.name}: {why}")
    stream, inventory = (
        read_obspy_stream(source_file, "MSEED"),
        read_stationxml_inventory(user_declared_properties.stationxml_files),
    )
    if inventory is None:
        why = "MiniSEED holds counts without gain or orientation; give the station's StationXML with it"
        raise RecordError(f"{source_file.name}: {why}")
    return stream_components_in_m_s2(stream, inventory, source_file, user_declared_properties)


def read_obspy_stream(source_file: SourceFile, obspy_format: str, **options: Any) -> Any:
    """Read the traces of a file with obspy; raise a RecordError if it is damaged."""
    import obspy

    try:
        return obspy.read(io.BytesIO(source_file.data), format=obspy_format, **options)
    except Exception as problem:  # struct, numpy, libmseed and obspy each raise their own
        raise RecordError(f"{source_file.name}: damaged {obspy_format} ({problem}); get it again") from problem


def stream_components_in_m_s2(
    obspy_stream: Any, obspy_inventory: Any, source_file: SourceFile, user_declared_properties: DeclaredFileProperties
) -> list[RecordComponent]:
    """Convert an obspy Stream from counts to components in m/s², by the gain or response in the StationXML.

    Raises a RecordError if a trace has a gap or is not in the inventory, or if its code names a velocity sensor while
    the inventory states acceleration and no unit is declared.
    """
    name = source_file.name
    try:
        obspy_stream.merge(method=-1)
    except Exception as problem:
        raise RecordError(f"{name}: pieces of a channel do not fit together ({problem}); get it again") from problem
    for number, trace in enumerate(obspy_stream):
        if trace.id in [other.id for other in obspy_stream[:number]]:
            raise RecordError(f"{name}: channel {trace.id} has a gap or an overlap; cut the file to one side of it")
        if trace.stats.npts < 2:
            raise RecordError(f"{name}: channel {trace.id} has {trace.stats.npts} samples; get the file again")
    components, reasons = [], RecordRefusalReasonCollector()
    for trace in obspy_stream:
        with reasons.suppress_record_error_and_keep_reasons():
            components.append(_component_of_trace(trace, obspy_inventory, source_file, user_declared_properties))
    reasons.raise_collected_reasons()
    return components


def _component_of_trace(
    obspy_trace: Any, obspy_inventory: Any, source_file: SourceFile, user_declared_properties: DeclaredFileProperties
) -> RecordComponent:
    """Convert one obspy trace to a record component, m/s²; a RecordError if the channel's StationXML is unsuitable."""
    channel, moment, code = (
        f"{source_file.name}: channel {obspy_trace.id}",
        obspy_trace.stats.starttime,
        obspy_trace.stats.channel,
    )
    epoch = find_channel_epoch(obspy_trace, obspy_inventory, source_file, user_declared_properties)
    unit, scale = epoch.input_unit, acceleration_unit_in_m_s2(epoch.input_unit)
    if scale is None and not is_metre_per_second(unit):
        raise RecordError(f"{channel} is in {unit or 'no unit'} in the StationXML; acceleration or velocity is needed")
    if scale is not None and code[1:2] == "H" and user_declared_properties.unit is None:
        raise RecordError(
            f"{channel} is of a velocity sensor by its code (H), but in {unit} in the StationXML; correct it, or "
            "declare the unit (unit m/s2 in the record table, --unit m/s2) if it is an acceleration"
        )
    if scale is None and code[1:2] == "N" and len(code) == 3:
        raise RecordError(
            f"{channel} is of an accelerometer by its code (N), but in {unit} in the StationXML; correct its units"
        )
    direction, coded = direction_with_channel_code_fallback_and_notes(
        code, epoch.direction, f"{channel}: the StationXML states no azimuth and dip"
    )
    # The code does not replace a direction that the StationXML calls unknown.
    direction, coded = (epoch.direction, ()) if epoch.is_orientation_unknown else (direction, coded)
    notes = [*channel_direction_mismatch_notes(code, direction, "the StationXML"), *coded, *epoch.notes]
    samples, removed = np.asarray(obspy_trace.data, dtype=np.float64) / epoch.gain_in_counts_per_unit, "gain"
    if scale is not None:
        samples *= scale
    else:
        if (speed := 0.5 * float(np.ptp(samples))) > VELOCITY_SENSOR_FULL_SCALE_M_S:
            what = f"channel {code} of a velocity sensor reaches {100 * speed:.2g} cm/s"
            notes += [f"{what}: most saturate from 1 or 2 cm/s on, and their acceleration is wrong then; look at it"]
        response, changed = normalise_filter_coefficient_sums_with_notes(epoch.obspy_channel.response, channel)
        samples, removed = _acceleration_from_velocity_trace(obspy_trace, response, source_file.name), "response"
        notes += changed
    return RecordComponent.from_file(
        source_file,
        code,
        direction,
        samples,
        float(obspy_trace.stats.delta),
        start_time_utc=moment.datetime.replace(tzinfo=UTC),
        station=obspy_trace.stats.station,
        station_latitude_longitude_deg=(epoch.obspy_channel.latitude, epoch.obspy_channel.longitude),
        sensor_position=classify_as_borehole_or_else_surface(epoch.obspy_channel.depth),
        sensor_location=obspy_trace.stats.location or BLANK_LOCATION_CODE,
        unit_declared_if_format_states_none=user_declared_properties.unit
        if user_declared_properties.unit and ACCELERATION_UNITS_IN_M_S2.get(user_declared_properties.unit) == scale
        else "",
        extra_metadata={"removed": removed, "network": obspy_trace.stats.network}
        | epoch.trusted_contradictions_metadata,
        notes=tuple(notes),
    )


def _acceleration_from_velocity_trace(obspy_trace: Any, obspy_response: Any, file_name: str) -> FloatArray:
    """Return the acceleration, m/s², from a velocity sensor's trace, by removing its response above 0.02 Hz.

    The pass band limits the amplification, instead of a water level. A water level is relative to the largest response
    to acceleration, which a broadband sensor has at its corner period. With a corner period of 120 s, the response is
    60 dB lower at 12 Hz, so a water level of 60 dB would make the acceleration above 12 Hz too small.
    """
    if not obspy_response.response_stages:
        why = f"response of {obspy_trace.id} has no stages, so it cannot be removed from a velocity sensor"
        raise RecordError(f"{file_name}: {why}; get level=response")
    nyquist = 0.5 * obspy_trace.stats.sampling_rate
    band = (0.01, 0.02, 0.8 * nyquist, 0.95 * nyquist)
    copy = obspy_trace.copy()
    copy.stats.response = obspy_response
    copy.data = np.asarray(copy.data, dtype=np.float64)
    # Fraction of both ends together, as obspy defines it. Its default of 5 % tapers 90 s at each end of an hour, which
    # may contain the earthquake.
    tapered = min(0.05, 2.0 * MAX_TAPER_DURATION_S / (copy.stats.npts * copy.stats.delta))
    try:
        # Otherwise evalresp prints to the terminal if the gain differs from its stages; the record has a note of it.
        copy.remove_response(
            output="ACC", pre_filt=band, water_level=300, zero_mean=True, taper_fraction=tapered,
            hide_sensitivity_mismatch_warning=True,
        )  # fmt: skip
    except Exception as problem:
        why = f"response of {obspy_trace.id} cannot be removed ({problem})"
        raise RecordError(f"{file_name}: {why}; get level=response") from problem
    return np.asarray(copy.data, dtype=np.float64)
