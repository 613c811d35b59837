"""CISMID (Universidad Nacional de Ingeniería, Peru): three components in one file, cm/s².

The format, as its files describe themselves: five numbered sections. The sections on station, earthquake and record
have lines ``KEY : text``; the comments describe the processing; the data begin with a line that names their columns:
time, EW, NS and UD. Times are local times of Peru.
"""

import re
from datetime import datetime, timedelta
from typing import Final

from overturning.records.axis_direction import AzimuthAndVerticalSense
from overturning.records.component import PeakStatedInFileHeader, RecordComponent
from overturning.records.formats.header import (
    HeaderFieldPatterns,
    HeaderFields,
    parse_time_as_utc,
    signed_coordinate_from_hemisphere,
)
from overturning.records.formats.lines import FLOAT_PATTERN, TextLines
from overturning.records.source import SourceFile
from overturning.units import GAL

PERU_UTC_OFFSET: Final = timedelta(hours=-5)
YEARS_WITH_SUMMER_TIME_IN_PERU: Final = (1986, 1987, 1990, 1994)
"""Years with summer time in Peru (January to April); the headers do not state whether they use it."""
TIME_FORMAT: Final = "%B %d, %Y %H:%M:%S"
DIRECTION_BY_AXIS_NAME: Final[dict[str, AzimuthAndVerticalSense]] = {"NS": (0.0, 0), "EW": (90.0, 0), "UD": (None, 1)}
FILTER_MENTION_PATTERN: Final = re.compile(r"(?<!un)(?<!not )(?<!no )(?<!without )(?<!without a )filter", re.IGNORECASE)
"""Comments on samples that were filtered."""
COORDINATE_PATTERN: Final = rf"\s*:\s*({FLOAT_PATTERN})(?:\s*°?\s*([NSEWO])\b)?"
COORDINATE_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    name: f"^{name}{COORDINATE_PATTERN}" for name in ("LATITUDE", "LONGITUDE")
}
STATION_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "station": r"^STATION CODE\s*:\s*(\S*)",
    **COORDINATE_FIELD_PATTERNS,
    "SAMPLING FREQUENCY (Hz)": rf"^SAMPLING FREQUENCY \(Hz\)\s*:\s*({FLOAT_PATTERN})",
}
EARTHQUAKE_SECTION_HEADING_PATTERN: Final[HeaderFieldPatterns] = {
    "section 2": r"^2\.\s*(INFORMATION ABOUT THE EARTHQUAKE)"
}
EARTHQUAKE_AND_RECORD_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "DATE": r"^DATE\s*:\s*(.*)",
    "ORIGIN TIME": r"^ORIGIN TIME \(Local\)\s*:\s*(\S*)",
    **COORDINATE_FIELD_PATTERNS,
    "depth": rf"^DEPTH \(km\)\s*:\s*({FLOAT_PATTERN})",
    "magnitude": rf"^MAGNITUDE\s*:\s*({FLOAT_PATTERN})",
    "RECORD TIME": r"^RECORD TIME \(Local\)\s*:\s*(\S*)",
    "NUMBER OF SAMPLES": r"^NUMBER OF SAMPLES\s*:\s*(\S*)",
    "MAXIMUM ACCELERATION": rf"^MAXIMUM ACCELERATION\s*:\s*({FLOAT_PATTERN}\s+{FLOAT_PATTERN}\s+{FLOAT_PATTERN})\s*$",
    "DATA UNITS": r"^DATA UNITS\s*:\s*(.*)",
    "section 4": r"^4\.\s*(COMMENTS)",
    "the line T, EW, NS, UD": r"^\s*T\s+((?:EW|NS|UD)\s+(?:EW|NS|UD)\s+(?:EW|NS|UD))\s*$",
}


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the components of a CISMID file (Peru); raise a RecordError with the line number if it is damaged."""
    at = HeaderFields.find_fields(source_file, EARTHQUAKE_SECTION_HEADING_PATTERN, 40).line_index_of_field("section 2")
    # The section on the earthquake has coordinates, too.
    station = HeaderFields.find_fields(TextLines(source_file, source_file.lines[:at]), STATION_FIELD_PATTERNS)
    header = HeaderFields.find_fields(
        TextLines(source_file, source_file.lines[at:], at), EARTHQUAKE_AND_RECORD_FIELD_PATTERNS, 40
    )
    header.check_field_pattern("DATA UNITS", r"(cm/s2|cm/s\^2|gal)\s*$", "cm/s2")
    heading = header.line_index_of_field("the line T, EW, NS, UD")
    columns = header.field_text("the line T, EW, NS, UD").upper().split()
    if len(set(columns)) < len(DIRECTION_BY_AXIS_NAME):
        raise header.line_error(heading, f"columns {', '.join(columns)}; one of them comes twice: correct it")
    interval = station.sampling_interval_of_rate_field("SAMPLING FREQUENCY (Hz)")
    values, notes = header.cut_to_stated_sample_count_with_notes(
        "NUMBER OF SAMPLES", header.read_number_rows(heading + 1, 1 + len(columns))
    )
    header.check_times_have_constant_interval(heading + 1, values[:, 0], interval, 1, "get the file again")
    comments = " ".join(" ".join(header.lines[header.line_index_of_field("section 4") + 1 : heading - 1]).split())
    origin, start = (_utc_time_of_local_time_field(header, name) for name in ("ORIGIN TIME", "RECORD TIME"))
    if origin and start and start < origin - timedelta(hours=12):  # The date is the earthquake's.
        start += timedelta(days=1)
    return [
        header.create_component(
            axis,
            DIRECTION_BY_AXIS_NAME[axis],
            values[:, column] * GAL,
            interval,
            start_time_utc=start,
            station=station.field_text("station"),
            event=f"earthquake of {header.field_text('DATE')} {header.field_text('ORIGIN TIME')} (Peru)",
            origin_time_utc=origin,
            station_latitude_longitude_deg=_latitude_and_longitude_in_section(station),
            header_peak=_stated_peak_of_column(header, column - 1),
            epicentre=_latitude_and_longitude_in_section(header),
            # A baseline correction alone leaves long-period noise in the samples; a filter removes it.
            is_already_corrected=bool(FILTER_MENTION_PATTERN.search(comments)),
            extra_metadata=header.number_fields_as_metadata({"depth_km": "depth"})
            | ({"agency_processing": comments} if comments else {}),
            notes=notes,
        )
        for column, axis in enumerate(columns, 1)
    ]


def _latitude_and_longitude_in_section(header: HeaderFields) -> tuple[float | None, float | None]:
    """Read latitude and longitude, degrees, from a section of a CISMID header; None if not stated.

    A southern latitude or western longitude has a minus sign or the letter S, W or O (Spanish for west).
    """
    stated = [header.field_pattern_match(name) for name in COORDINATE_FIELD_PATTERNS]
    latitude, longitude = (
        signed_coordinate_from_hemisphere(float(one[1]), one[2] or "") if one else None for one in stated
    )
    return latitude, longitude


def _utc_time_of_local_time_field(header: HeaderFields, field_name: str) -> datetime | None:
    """Return the local time in a header field as UTC; None for months in which summer time is uncertain."""
    moment = parse_time_as_utc(
        f"{header.field_text('DATE')} {header.field_text(field_name)}", TIME_FORMAT, utc_offset=PERU_UTC_OFFSET
    )
    return None if moment and moment.year in YEARS_WITH_SUMMER_TIME_IN_PERU and moment.month <= 4 else moment


def _stated_peak_of_column(
    header: HeaderFields, index_among_acceleration_columns: int
) -> PeakStatedInFileHeader | None:
    """Return the peak that the header states for an acceleration column, counted from 0; None if it states no peaks."""
    stated = header.field_text("MAXIMUM ACCELERATION").split()
    return (
        header.field_peak_acceleration("MAXIMUM ACCELERATION", GAL, stated[index_among_acceleration_columns])
        if stated
        else None
    )
