"""SAC, read by obspy: one component per file. Its header states no unit: StationXML or a declaration gives it."""

import struct
from datetime import UTC
from typing import Any, Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.axis_direction import (
    channel_direction_mismatch_notes,
    direction_from_azimuth_and_dip_with_notes,
    direction_with_channel_code_fallback_and_notes,
)
from overturning.records.component import PeakStatedInFileHeader, RecordComponent, classify_as_borehole_or_else_surface
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.formats.header import epicentre_metadata
from overturning.records.formats.miniseed import read_obspy_stream, stream_components_in_m_s2
from overturning.records.formats.stationxml import inventory_has_channel_of_trace, read_stationxml_inventory
from overturning.records.source import SourceFile
from overturning.units import ACCELERATION_UNITS_IN_M_S2

UNDEFINED_HEADER_VALUE: Final = -12345.0

OTHER_QUANTITY_BY_IDEP: Final[dict[float | None, str]] = {6.0: "displacement", 7.0: "velocity", 50.0: "volts"}
"""Quantity for each value of SAC's IDEP that is not acceleration."""

OTHER_CONTENT_BY_IFTYPE: Final[dict[float | None, str]] = {
    2.0: "a spectrum",
    3.0: "a spectrum",
    4.0: "x and y",
    51.0: "x, y and z",
}
"""Content for each value of SAC's IFTYPE that is not a time series."""


def read_components(source_file: SourceFile, user_declared_properties: DeclaredFileProperties) -> list[RecordComponent]:
    """Read the one component of a SAC file, as a list; its unit comes from StationXML or the user.

    A RecordError is raised if neither of them states a unit.
    """
    # Check the interval first: obspy divides by it while reading.
    intervals = [struct.unpack(f"{order}f", source_file.data[:4])[0] for order in "<>"]
    if not any(1e-6 < interval < 1e3 for interval in intervals):
        raise RecordError(f"{source_file.name}: sampling interval {intervals[0]:g} s in the header; get the file again")
    stream = read_obspy_stream(source_file, "SAC", checksize=True)
    header = stream[0].stats.sac
    uneven = "samples at uneven times" if header.get("leven") == 0 else ""
    if what := OTHER_CONTENT_BY_IFTYPE.get(header.get("iftype")) or uneven:
        raise RecordError(f"{source_file.name}: {what} by its header, not evenly sampled acceleration; get that file")
    inventory = read_stationxml_inventory(user_declared_properties.stationxml_files)
    # With a declared unit, ignore StationXML that does not contain this channel.
    if inventory is not None and (
        user_declared_properties.unit is None or inventory_has_channel_of_trace(stream[0], inventory)
    ):
        return stream_components_in_m_s2(stream, inventory, source_file, user_declared_properties)
    if user_declared_properties.unit is None:
        raise RecordError(
            f"{source_file.name}: SAC does not say its unit; declare it (unit in the record table, --unit here: "
            f"{', '.join(ACCELERATION_UNITS_IN_M_S2)}) or give StationXML"
        )
    return [_component_of_trace(stream[0], source_file, user_declared_properties.unit, user_declared_properties)]


def _component_of_trace(
    obspy_trace: Any,
    source_file: SourceFile,
    declared_unit_if_file_states_none: str,
    user_declared_properties: DeclaredFileProperties,
) -> RecordComponent:
    """Convert a SAC trace of a given unit to a record component, m/s²; a RecordError if it is no acceleration."""
    header, scale = obspy_trace.stats.sac, ACCELERATION_UNITS_IN_M_S2[declared_unit_if_file_states_none]

    def header_number(header_key: str) -> float | None:
        """Return a number of the SAC header; None if it is undefined."""
        value = header.get(header_key)
        return None if value is None or value == UNDEFINED_HEADER_VALUE else float(value)

    if (kind := header_number("idep")) in OTHER_QUANTITY_BY_IDEP:
        raise RecordError(
            f"{source_file.name}: {OTHER_QUANTITY_BY_IDEP[kind]} by its header (IDEP {kind:g}); "
            "only acceleration is read: "
            "get that file"
        )
    extremes = [v for key in ("depmin", "depmax") if (v := header_number(key)) is not None and np.isfinite(v)]
    extreme = max(extremes, key=abs, default=None)
    # Origin and first sample are relative to one reference time, which the header may omit.
    dated, moment, late = header_number("nzyear") is not None, obspy_trace.stats.starttime, header_number("o")
    after = None if late is None or not dated else late - (header_number("b") or 0.0)
    origin = (moment + after).datetime.replace(tzinfo=UTC) if after is not None and abs(after) < 1e6 else None
    epicentre = epicentre_metadata(header_number("evla"), header_number("evlo"))
    # SAC's CMPINC is counted from upwards: 0 up, 90 horizontal, 180 down.
    azimuth, inclination = header_number("cmpaz"), header_number("cmpinc")
    channel = f"{source_file.name}: channel {obspy_trace.id}"
    dip = None if inclination is None else inclination - 90.0
    direction, notes = direction_from_azimuth_and_dip_with_notes(obspy_trace.stats.channel, azimuth, dip, channel)
    notes += channel_direction_mismatch_notes(obspy_trace.stats.channel, direction, "its header")
    if azimuth is None or inclination is None:
        why = f"{source_file.name}: its header states no direction (CMPAZ, CMPINC)"
        direction, coded = direction_with_channel_code_fallback_and_notes(obspy_trace.stats.channel, direction, why)
        notes += coded
    if (factor := header_number("scale")) not in (None, 0.0, 1.0):
        notes += (
            f"{source_file.name}: its header's SCALE, {factor:g}, is not applied: samples are in "
            f"{declared_unit_if_file_states_none}, as "
            "declared",
        )
    return RecordComponent.from_file(
        source_file,
        obspy_trace.stats.channel or "unnamed",
        direction,
        np.asarray(obspy_trace.data, dtype=np.float64) * scale,
        round(float(obspy_trace.stats.delta), 9),
        start_time_utc=moment.datetime.replace(tzinfo=UTC) if dated else None,
        station=obspy_trace.stats.station,
        event=str(header.get("kevnm", "")).strip(),
        origin_time_utc=origin,
        station_latitude_longitude_deg=(header_number("stla"), header_number("stlo")),
        header_peak=PeakStatedInFileHeader.from_signed_acceleration(extreme * scale, 2e-7)
        if extreme is not None
        else None,
        sensor_position=classify_as_borehole_or_else_surface(header_number("stdp")),
        sensor_location=obspy_trace.stats.location,
        is_already_corrected=bool(user_declared_properties.processed),
        unit_declared_if_format_states_none=declared_unit_if_file_states_none,
        extra_metadata={
            "network": obspy_trace.stats.network,
            "declared": user_declared_properties.declared_sample_property_texts,
        }
        | epicentre,
        notes=notes,
    )
