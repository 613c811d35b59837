"""BHRC, Iran (Building and Housing Research Center's ISMN), volume 1: all components in one file, unit g/10.

The format, per component: 13 lines of text, 7 lines of integers (5 columns each), 7 of reals (13 columns each; the
sixth is the sampling rate), ten samples per line (10E13.6), and a line ``/&``. The station's line states the
azimuths of L and T. The file does not state the sense of V, the peak, or the time of the first sample.
"""

from typing import Final

from overturning.records.axis_direction import UNKNOWN_DIRECTION
from overturning.records.component import RecordComponent
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields
from overturning.records.formats.lines import FLOAT_PATTERN, TextLines, decorator_for_reading_all_components
from overturning.units import STANDARD_GRAVITY

HEADER_LINE_COUNT: Final = 27
SAMPLING_RATE_LINE_INDEX: Final = 21
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "origin": (2, r"^[^:]*:\s*(.*)"),
    "L, V or T": (4, r"^\s*([LTV])\s*$"),
    "component": (6, r"^COMP\s+([LTV])"),
    "station": (7, rf"^(.*?)\s*Station\s+{FLOAT_PATTERN}\s*N"),
    "coordinates": (7, rf"Station\s+({FLOAT_PATTERN})\s*(N)\s+({FLOAT_PATTERN})\s*(E)"),
    "azimuths of L and T": (7, rf"Azimuth\s+L\s+({FLOAT_PATTERN})\s+T\s+({FLOAT_PATTERN})"),
    "epicentre": rf"Epicenter\s+({FLOAT_PATTERN})\s*(N)\s+({FLOAT_PATTERN})\s*(E)",
    "magnitude": rf"Epicenter.*Mw\s*({FLOAT_PATTERN})",
    "NO. OF POINTS": (10, r"NO\. OF POINTS\s*=\s*(\d+)"),
    "DURATION": (10, rf"DURATION\s*=\s*({FLOAT_PATTERN})"),
    "UNITS ARE SECONDS AND G/10 (no other is read)": (11, r"^(UNITS ARE SECONDS AND G/10)\s*$"),
}


@decorator_for_reading_all_components(r"\* VOL1", "only volume 1 is read")
def read_component_samples_and_count_lines(lines_from_channel_start: TextLines) -> tuple[RecordComponent, int]:
    """Read one component of a BHRC file (Iran); return the component and its number of lines."""
    header = HeaderFields.find_fields(
        lines_from_channel_start, HEADER_FIELD_PATTERNS, HEADER_LINE_COUNT, min_line_count=HEADER_LINE_COUNT
    )
    text = lines_from_channel_start.lines
    axis, azimuths = header.field_text("L, V or T"), header.field_pattern_match("azimuths of L and T")
    if axis != header.field_text("component"):
        raise header.line_error("L, V or T", f"component {axis!r}, but {text[6].strip()!r} below it; find out which")
    assert azimuths is not None
    direction = UNKNOWN_DIRECTION if axis == "V" else (float(azimuths[1 if axis == "L" else 2]) % 360.0, 0)
    interval = lines_from_channel_start.sampling_interval_of_rate(
        lines_from_channel_start.parse_number(
            text[SAMPLING_RATE_LINE_INDEX][:13], SAMPLING_RATE_LINE_INDEX, "the rate"
        ),
        SAMPLING_RATE_LINE_INDEX,
    )
    count = int(header.field_text("NO. OF POINTS"))
    lines_from_channel_start.check_duration_stated_in_line(10, count, interval, header.number_in_field("DURATION"))
    samples, end, notes = lines_from_channel_start.read_fixed_width_samples_next_line_and_notes(
        HEADER_LINE_COUNT, column_width=13, numbers_per_line=10, number_count=count
    )
    if end >= len(text) or not text[end].startswith("/&"):
        at = min(end, len(text) - 1)
        raise lines_from_channel_start.line_error(
            at, f"no end mark /& after {count} samples; the file is cut: get it again"
        )
    when = " ".join(header.field_text("origin").split())
    event = f"earthquake of {when}" if when else ""
    samples = samples * 0.1 * STANDARD_GRAVITY
    return header.create_component(axis, direction, samples, interval, event=event, notes=notes), end + 1
