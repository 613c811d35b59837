"""JMA (Japan Meteorological Agency), CSV: three components in one file, Gal, offset not removed.

The format, as its files describe themselves: lines ``KEY = text`` with station, coordinates, rate, unit, and the time
of the first sample (Japanese time); a line that names the columns NS, EW and UD, positive towards the first letter;
then three samples per line. Lines may end with commas. The header states neither count nor peak, so a file that was cut
between two lines looks complete.
"""

import re
from dataclasses import replace
from datetime import timedelta
from typing import Final

from overturning.records.axis_direction import AzimuthAndVerticalSense
from overturning.records.component import RecordComponent
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields
from overturning.records.formats.lines import FLOAT_PATTERN
from overturning.records.source import SourceFile
from overturning.units import GAL

JAPAN_UTC_OFFSET: Final = timedelta(hours=9)
DIRECTION_BY_AXIS_NAME: Final[dict[str, AzimuthAndVerticalSense]] = {"NS": (0.0, 0), "EW": (90.0, 0), "UD": (None, 1)}
TIME_FORMATS: Final = ("%Y %m %d %H %M %S", "%Y %m %d %H %M %S.%f", "%y %m %d %H %M %S", "%y %m %d %H %M %S.%f")
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "SITE CODE": r"^\s*SITE CODE\s*=\s*([^,]*)",
    "LAT.": rf"^\s*LAT\.?\s*=\s*({FLOAT_PATTERN})",
    "LON.": rf"^\s*LON\.?\s*=\s*({FLOAT_PATTERN})",
    "SAMPLING RATE": rf"^\s*SAMPLING (?:RATE|FREQ)\.?\s*=\s*({FLOAT_PATTERN})\s*Hz",
    "UNIT": r"^\s*UNIT\s*=\s*([^,]*)",
    "INITIAL TIME": r"^\s*INITIAL TIME\s*=\s*([^,]*)",
    "the line NS,EW,UD": r"^\s*((?:NS|EW|UD)\s*,\s*(?:NS|EW|UD)\s*,\s*(?:NS|EW|UD))[\s,]*$",
}


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the components of a JMA file (Japan); raise a RecordError with the line number if it is damaged."""
    header = HeaderFields.find_fields(source_file, HEADER_FIELD_PATTERNS, 20)
    first = header.line_index_of_field("the line NS,EW,UD") + 1
    header.check_field_pattern("UNIT", r"gal\b", "gal")
    columns = re.split(r"\s*,\s*", header.field_text("the line NS,EW,UD").upper())
    if len(set(columns)) < len(DIRECTION_BY_AXIS_NAME):
        raise header.line_error(
            "the line NS,EW,UD", f"columns {', '.join(columns)}; one of them comes twice: correct it"
        )
    if source_file.text.rstrip("\x1a\x00")[-1:] not in "\r\n":
        why = "the last line has no line end, so its last number may be cut; add one if it is whole"
        raise header.line_error(len(header.lines) - 1, why)
    # Keep the commas of a line with an empty cell, so that it is refused as a row of numbers.
    filled = (line.rstrip(", \t") for line in source_file.lines)
    spaced = [line if re.search(r",\s*,", line) else line.replace(",", " ") for line in filled]
    values = replace(header, lines=spaced).read_number_rows(first, len(columns))
    station = " ".join(header.field_text("SITE CODE").split())
    return [
        header.create_component(
            axis,
            DIRECTION_BY_AXIS_NAME[axis],
            values[:, column] * GAL,
            header.sampling_interval_of_rate_field("SAMPLING RATE"),
            start_time_utc=header.field_utc_time("INITIAL TIME", *TIME_FORMATS, utc_offset=JAPAN_UTC_OFFSET),
            station=station,
            station_latitude_longitude_deg=(header.number_in_field("LAT."), header.number_in_field("LON.")),
        )
        for column, axis in enumerate(columns)
    ]
