"""PEER AT2: one component per file, in g, with the new header and two old ones.

Four lines of text (database; earthquake, date, station, component; unit; count and interval), then samples in free
format. The header states no peak; the earthquake's date has no time.
"""

import re
from typing import Any, Final

from overturning.records.axis_direction import direction_with_channel_code_fallback_and_notes, parse_axis_direction
from overturning.records.component import RecordComponent
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields
from overturning.records.formats.lines import FLOAT_PATTERN
from overturning.records.source import SourceFile
from overturning.units import STANDARD_GRAVITY

HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "names": (1, "(.*)"),
    "ACCELERATION IN UNITS OF G (as in .AT2 files)": (2, r"(ACCELERATION.*UNITS OF G)(?![\w/*])"),
    "corners": rf"HP=\s*({FLOAT_PATTERN})\s*Hz\s+LP=\s*({FLOAT_PATTERN})\s*Hz",
    "NPTS": (3, r"(\d+)\s+\S+\s+NPTS\s*,\s*DT|NPTS\s*=\s*(\d+)"),
    "DT": (3, rf"({FLOAT_PATTERN})\s+NPTS\s*,\s*DT|DT\s*=\s*({FLOAT_PATTERN})"),
}

BOREHOLE_AXIS_PATTERN: Final = re.compile("(NS|EW|UD)1", re.IGNORECASE)
"""Axis names of KiK-net's borehole sensor; the names of its surface sensor end with 2."""


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the one component of a PEER AT2 file, as a list; a RecordError for a wrong unit or sample count."""
    header = HeaderFields.find_fields(source_file, HEADER_FIELD_PATTERNS, 4, min_line_count=5)
    samples, notes = header.cut_to_stated_sample_count_with_notes("NPTS", header.read_all_numbers(4))
    parts = [part.strip() for part in header.field_text("names").split(",")]
    axis = re.sub(r"\(.*\)", "", parts[-1]).strip()
    # The new header has a separate date; the earthquake's name before it may contain commas (Chi-Chi, Taiwan-06).
    dated = next((i for i, part in enumerate(parts[:-1]) if re.fullmatch(r"\d+/\d+/\d+", part)), 0)
    event, station = parts[0], parts[1:-1]
    if dated:
        event, station = f"{', '.join(parts[:dated])} {parts[dated]}", parts[dated + 1 : -1]
    corners = header.field_pattern_match("corners")
    filtered = {"agency_processing": f"band-pass filter {corners[1]} to {corners[2]} Hz"} if corners else {}
    direction, coded = direction_with_channel_code_fallback_and_notes(
        axis, parse_axis_direction(axis), f"{source_file.name}: its header states no azimuth"
    )
    more: Any = {
        "station": ", ".join(station),
        "event": event,
        "is_already_corrected": True,
        "extra_metadata": filtered,
    }
    more |= {
        "notes": (*notes, *coded),
        "sensor_position": "borehole" if BOREHOLE_AXIS_PATTERN.fullmatch(axis) else "surface",
    }
    return [header.create_component(axis, direction, samples * STANDARD_GRAVITY, header.number_in_field("DT"), **more)]
