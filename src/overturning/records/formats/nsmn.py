"""NSMN, Türkiye (AFAD's National Strong-Motion Network): three components in one file, Gal.

The format: eighteen header lines (title, lines ``KEY: text`` in a fixed order, and the names of the columns N-S, E-W
and U-D), then three samples per line. The files are in a local code page, so names may contain any letters.
"""

import re
from typing import Final

from overturning.records.component import RecordComponent
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields, parse_time_as_utc
from overturning.records.formats.lines import FLOAT_PATTERN
from overturning.records.source import SourceFile
from overturning.units import GAL

DIRECTION_BY_AXIS_NAME: Final = {"N-S": (0.0, 0), "E-W": (90.0, 0), "U-D": (None, 1)}
HEADER_LINE_COUNT: Final = 18
COORDINATES_PATTERN: Final = rf":\s*(?:$|({FLOAT_PATTERN})\s*(N)\s*-\s*({FLOAT_PATTERN})\s*(E))"
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "origin": (2, ":(.*)"),
    "an epicentre like 40.84N-31.15E": (3, COORDINATES_PATTERN),
    "station": (6, ":(.*)"),
    "a place like 40.84N-31.15E": (7, COORDINATES_PATTERN),
    "time of the record": (11, r":\s*(\d+/\d+/\d+ \d+:\d+:\d+(?:\.\d+)?)"),
    "number of data": (12, ":(.*)"),
    "sampling interval": (13, ":(.*)"),
    "PGA in Gal (no other unit is read)": (14, r"^[^:(]*(?:\((?:gal|cm/s2|cm/s\^2|cm/s/s)\)[^:]*)?:(.*)"),
    "the line N-S, E-W, U-D": (17, r"^\s*N-S\s+E-W\s+U-D(\s|$)"),
}


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the components of an NSMN file (Türkiye); raise a RecordError with the line number if it is damaged."""
    header = HeaderFields.find_fields(source_file, HEADER_FIELD_PATTERNS, min_line_count=HEADER_LINE_COUNT)
    values, notes = header.cut_to_stated_sample_count_with_notes(
        "number of data", header.read_number_rows(HEADER_LINE_COUNT, 3)
    )
    moment, _, fraction = header.field_text("time of the record").partition(".")
    components = []
    for column, (axis, direction) in enumerate(DIRECTION_BY_AXIS_NAME.items()):
        stated = re.search(rf"{axis}[\s):=]*({FLOAT_PATTERN})", header.field_text("PGA in Gal (no other unit is read)"))
        if stated is None:
            raise header.line_error("PGA in Gal (no other unit is read)", f"no peak of {axis}; get the file again")
        components.append(
            header.create_component(
                axis,
                direction,
                values[:, column] * GAL,
                header.number_in_field("sampling interval"),
                start_time_utc=header.field_utc_time(
                    "time of the record", "%d/%m/%Y %H:%M:%S.%f", override_text=f"{moment}.{fraction[:6] or 0}"
                ),
                event=f"earthquake of {header.field_text('origin')}",
                # Files of about 2017 have the year first here, but not in the time of the record.
                origin_time_utc=parse_time_as_utc(
                    re.sub(r"(:\d+:\d+).*", r"\1", header.field_text("origin")),
                    "%d/%m/%Y %H:%M:%S",
                    "%Y/%m/%d %H:%M:%S",
                ),
                station_latitude_longitude_deg=header.field_latitude_and_longitude_deg("a place like 40.84N-31.15E"),
                header_peak=header.field_peak_acceleration("PGA in Gal (no other unit is read)", GAL, stated[1]),
                epicentre=header.field_latitude_and_longitude_deg("an epicentre like 40.84N-31.15E"),
                notes=notes,
            )
        )
    return components
