"""CSMNC, China (China Strong Motion Networks Center): one component per file, cm/s².

The format, as its files describe themselves: the second line of text ends with the origin time. ``COMP.`` names the
axis; the lines after it state quantity and unit, count and interval, peak and duration. After the name of the centre
and a blank line follow eight samples per line. Times are Beijing time (BTM). Only later files state the recorder's
time, which is the time of the first sample.
"""

from datetime import timedelta
from typing import Final

from overturning.records.axis_direction import AzimuthAndVerticalSense, parse_axis_direction
from overturning.records.component import RecordComponent, classify_as_borehole_or_else_surface
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields, parse_time_as_utc
from overturning.records.formats.lines import FLOAT_PATTERN
from overturning.records.source import SourceFile
from overturning.units import GAL

BEIJING_UTC_OFFSET: Final = timedelta(hours=8)
BEIJING_TIME_PATTERN: Final = r"(\d{4}-\d+-\d+\s+\d+:\d+:\d+(?:\.\d+)?)\s*BTM"
TIME_FORMATS: Final = ("%Y-%m-%d %H:%M:%S", "%Y-%m-%d %H:%M:%S.%f")
COORDINATES_PATTERN: Final = rf"({FLOAT_PATTERN})\s*([NS])[,\s]+({FLOAT_PATTERN})\s*([EW])"
DIRECTION_BY_AXIS_NAME: Final[dict[str, AzimuthAndVerticalSense]] = {"NS": (0.0, 0), "EW": (90.0, 0), "UD": (None, 1)}
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "origin": (1, rf"{BEIJING_TIME_PATTERN}\s*$"),
    "event": (2, "(.*)"),
    "epicentre": rf"^\s*EPICENTER\s+{COORDINATES_PATTERN}",
    "depth": rf"^\s*EPICENTER\b.*\bDEPTH\s*({FLOAT_PATTERN})\s*KM",
    "magnitude": rf"^\s*MAGNITUDE\s+({FLOAT_PATTERN})",
    "station": r"^\s*STATION:\s*(\S+)",
    "coordinates": rf"^\s*STATION:\s*\S+\s+{COORDINATES_PATTERN}",
    "observing point": r"^\s*OBSERVING POINT:\s*(.*)",
    "COMP. with the axis": r"^\s*COMP\.\s*(\S.*)",
    "quantity": r"^\s*((?:UN)?CORRECTED \S.*)",
    "NO. OF POINTS": r"NO\. OF POINTS:\s*(\d+)",
    "interval": rf"EQUALLY SPACED INTERVALS OF:\s*({FLOAT_PATTERN})\s*SEC",
    "peak": rf"PEAK VALUE:\s*({FLOAT_PATTERN})",
    "duration": rf"DURATION:\s*({FLOAT_PATTERN})\s*SEC",
    "start": rf"RECORDER TIME:\s*{BEIJING_TIME_PATTERN}",
    "the line CSMNC": r"^\s*(CSMNC)\s*$",
}
ACCELERATION_LINE_PATTERN: Final = r"(UN)?CORRECTED ACCELERATION\s+UNIT:\s*(CM/SEC/SEC|GAL)\s*$"


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the one component of a CSMNC file (China), as a list; a RecordError names the line of an error."""
    header = HeaderFields.find_fields(source_file, HEADER_FIELD_PATTERNS, 20, min_line_count=17)
    header.check_field_pattern("quantity", ACCELERATION_LINE_PATTERN, "acceleration in CM/SEC/SEC")
    axis = header.field_text("COMP. with the axis")
    samples, notes = header.cut_to_stated_sample_count_with_notes(
        "NO. OF POINTS", header.read_all_numbers(header.line_index_of_field("the line CSMNC") + 1)
    )
    interval = header.number_in_field("interval")
    header.check_stated_duration("duration", samples.size, interval)
    return [
        header.create_component(
            axis,
            DIRECTION_BY_AXIS_NAME.get(axis.upper(), parse_axis_direction(axis)),
            samples * GAL,
            interval,
            start_time_utc=header.field_utc_time("start", *TIME_FORMATS, utc_offset=BEIJING_UTC_OFFSET)
            if header.field_text("start")
            else None,
            origin_time_utc=parse_time_as_utc(
                header.field_text("origin"), *TIME_FORMATS, utc_offset=BEIJING_UTC_OFFSET
            ),
            header_peak=header.field_peak_acceleration("peak", GAL) if header.field_text("peak") else None,
            sensor_position=classify_as_borehole_or_else_surface(location_text=header.field_text("observing point")),
            sensor_location=" ".join(header.field_text("observing point").split()),
            is_already_corrected=header.field_text("quantity").upper().startswith("CORRECTED"),
            extra_metadata=header.number_fields_as_metadata({"depth_km": "depth"}),
            notes=notes,
        )
    ]
