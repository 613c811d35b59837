"""ESM / ITACA / DYNA ASCII: one component per file, cm/s²; 64 lines ``KEY: value``, then one sample per line."""

import re
from typing import Final

from overturning.records.axis_direction import direction_from_channel_code
from overturning.records.component import RecordComponent, classify_as_borehole_or_else_surface
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields, parse_time_as_utc
from overturning.records.source import SourceFile
from overturning.units import GAL

HEADER_LINE_PATTERN: Final = r"[A-Z][A-Z0-9_/^]*:(\s.*)?"
HEADER_KEYS: Final = (
    *("EVENT_NAME", "EVENT_ID", "EVENT_DATE_YYYYMMDD", "EVENT_TIME_HHMMSS", "EVENT_LATITUDE_DEGREE"),
    *("EVENT_LONGITUDE_DEGREE", "MAGNITUDE_W", "STATION_CODE", "STATION_LATITUDE_DEGREE", "STATION_LONGITUDE_DEGREE"),
    "LOCATION",
    *("VS30_M/S", "SENSOR_DEPTH_M", "DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS", "SAMPLING_INTERVAL_S", "NDATA", "STREAM"),
    "DURATION_S",
    *("UNITS", "PGA_CM/S^2", "BASELINE_CORRECTION", "FILTER_TYPE", "LOW_CUT_FREQUENCY_HZ", "HIGH_CUT_FREQUENCY_HZ"),
    *("DATA_TYPE", "PROCESSING"),
)
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {key: rf"^{re.escape(key)}:(.*)" for key in HEADER_KEYS}


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the one component of an ESM or ITACA file, as a list; a RecordError for a wrong key, unit or count."""
    lines = source_file.lines
    first = next(
        (i for i, line in enumerate(lines) if not re.fullmatch(HEADER_LINE_PATTERN, line.rstrip())), len(lines)
    )
    header = HeaderFields.find_fields(source_file, HEADER_FIELD_PATTERNS, first)
    text = header.field_text
    header.line_index_of_field("STREAM")
    header.check_field_pattern("UNITS", r"cm\s*/\s*s\^?2$", "acceleration in cm/s^2")
    if text("DATA_TYPE"):  # Raw files write "acceleration" or "UNPROCESSED ACCELERATION".
        header.check_field_pattern("DATA_TYPE", r"(unprocessed )?acceleration$", "acceleration")
    samples, notes = header.cut_to_stated_sample_count_with_notes("NDATA", header.read_all_numbers(first))
    interval = header.number_in_field("SAMPLING_INTERVAL_S")
    header.check_stated_duration("DURATION_S", samples.size, interval)
    corners = [text(f"{end}_CUT_FREQUENCY_HZ") for end in ("LOW", "HIGH")]
    filtered = f"{text('FILTER_TYPE').lower() or 'filter'} {corners[0]} to {corners[1]} Hz"
    extra = header.number_fields_as_metadata({"magnitude": "MAGNITUDE_W", "vs30": "VS30_M/S"})
    first_sample = "DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS"
    raw = "NOT REMOVED" in text("BASELINE_CORRECTION").upper() or text("PROCESSING").lower() == "none"
    return [
        header.create_component(
            text("STREAM"),
            direction_from_channel_code(text("STREAM")),
            samples * GAL,
            interval,
            start_time_utc=header.field_utc_time(first_sample, "%Y%m%d_%H%M%S.%f", "%Y%m%d_%H%M%S")
            if text(first_sample)
            else None,
            station=text("STATION_CODE"),
            event=text("EVENT_NAME") or text("EVENT_ID"),
            origin_time_utc=parse_time_as_utc(
                f"{text('EVENT_DATE_YYYYMMDD')} {text('EVENT_TIME_HHMMSS')[:6]}", "%Y%m%d %H%M%S"
            ),
            station_latitude_longitude_deg=(
                header.optional_number_in_field("STATION_LATITUDE_DEGREE"),
                header.optional_number_in_field("STATION_LONGITUDE_DEGREE"),
            ),
            header_peak=header.field_peak_acceleration("PGA_CM/S^2", GAL, format_states_sign_of_peak=True)
            if text("PGA_CM/S^2")
            else None,
            sensor_position=classify_as_borehole_or_else_surface(header.optional_number_in_field("SENSOR_DEPTH_M")),
            sensor_location=text("LOCATION"),
            is_already_corrected=not (raw or text("DATA_TYPE").upper().startswith("UNPROCESSED")),
            epicentre=(
                header.optional_number_in_field("EVENT_LATITUDE_DEGREE"),
                header.optional_number_in_field("EVENT_LONGITUDE_DEGREE"),
            ),
            extra_metadata=extra | ({"agency_processing": filtered} if all(corners) else {}),
            notes=notes,
        )
    ]
