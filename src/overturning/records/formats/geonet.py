"""GeoNet (GNS Science, New Zealand) V1A and V2A: three components in one file, mm/s².

The format: Cousins (2008), "GNS accelerogram data files, standard format". Per component 16 lines of text, 4 lines of
ten integers (10I8), 6 lines of ten reals (10F8), then ten samples per line (10F8). Corrected files also hold velocity
and displacement, which are not read.
"""

from datetime import timedelta
from functools import partial
from typing import Final

from overturning.records.axis_direction import (
    UNKNOWN_DIRECTION,
    checked_axis_direction_from_name_or_code,
    parse_axis_direction,
)
from overturning.records.component import RecordComponent
from overturning.records.formats.header import (
    DEGREE_MINUTE_SECOND_PATTERN,
    HeaderFieldPatterns,
    HeaderFields,
    parse_time_as_utc,
)
from overturning.records.formats.lines import FLOAT_PATTERN, TextLines, decorator_for_reading_all_components

MILLIMETRE_IN_M: Final = 1e-3
HEADER_TEXT_LINE_COUNT: Final = 16
HEADER_LINE_COUNT: Final = 26
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "station": rf"^Site\s+(\S+)\s+{DEGREE_MINUTE_SECOND_PATTERN}",
    "coordinates": rf"^Site\s+\S+\s+{DEGREE_MINUTE_SECOND_PATTERN}",
    "near": (6, "(.*)"),
    "origin": (7, "(.*)"),
    "epicentre": rf"^Epicentre\s+{DEGREE_MINUTE_SECOND_PATTERN}",
    "Number of points": (9, r"Number of points\s+(\d+)"),
    "interval": (10, rf"at\s+(?:intervals of\s+)?({FLOAT_PATTERN})\s*s"),
    "unit": rf"units of\s+({FLOAT_PATTERN})\s*mm/s/s",
    "bands": r"(transition bands are\s+.*?)\s*$",
    "component": (12, r"Component\s+(\S+)"),
    "Acceleration: Peak in mm/s/s": (13, rf"Acceleration:\s+Peak\s+({FLOAT_PATTERN})\s*mm/s/s"),
}


@decorator_for_reading_all_components(r"(Unc|C)orrected", "get the file again")
def read_component_samples_and_count_lines(lines_from_channel_start: TextLines) -> tuple[RecordComponent, int]:
    """Read one component of a GeoNet file (New Zealand); return the component and its number of lines."""
    header = HeaderFields.find_fields(
        lines_from_channel_start, HEADER_FIELD_PATTERNS, HEADER_TEXT_LINE_COUNT, min_line_count=HEADER_LINE_COUNT
    )
    text = lines_from_channel_start.lines
    corrected = text[0].startswith("Corrected")
    whole = lines_from_channel_start.read_fixed_width_integers(
        HEADER_TEXT_LINE_COUNT, column_width=8, numbers_per_line=10, number_count=40
    )
    real = lines_from_channel_start.read_fixed_width_numbers(20, column_width=8, numbers_per_line=10, number_count=60)
    count = int(whole[33])
    header.check_sample_count("Number of points", count)
    interval = header.number_in_field("interval")
    if abs(interval - real[25]) > 5e-4:
        raise header.line_error(
            "interval", f"interval {interval} s, but the numbers below say {real[25]}; get it again"
        )
    axis = header.field_text("component")
    # The code of a vertical axis has no meaning.
    coded = UNKNOWN_DIRECTION if parse_axis_direction(axis)[1] else (float(whole[27]) % 360.0, 0)
    samples = lines_from_channel_start.read_fixed_width_numbers(
        HEADER_LINE_COUNT, column_width=8, numbers_per_line=10, number_count=count
    )
    end = HEADER_LINE_COUNT + sum(-(-int(n) // 10) for n in whole[33 : 36 if corrected else 34])
    if end > len(text):
        raise lines_from_channel_start.line_error(len(text) - 1, f"the file ends in the data of {axis}; get it again")
    *day, hour, minute, millis = (int(whole[i]) for i in (8, 9, 18, 19, 38, 39))  # Start of the buffer, UT.
    # "near" names the place of the epicentre, which may be far from the station.
    when, where = (" ".join(header.field_text(name).split()) for name in ("origin", "near"))
    bands = header.field_text("bands").replace(" are", "") if corrected else ""
    agency = {"agency_processing": f"band-pass filter, {bands}"} if bands else {}
    end, notes = lines_from_channel_start.skip_surplus_number_lines_with_notes(end, count)
    return header.create_component(
        axis,
        checked_axis_direction_from_name_or_code(axis, coded, partial(header.line_error, "component")),
        samples * (MILLIMETRE_IN_M if corrected else MILLIMETRE_IN_M * header.number_in_field("unit")),
        interval,
        # Corrected files begin before the start of the buffer, usually by 5 s.
        start_time_utc=lines_from_channel_start.utc_time(HEADER_TEXT_LINE_COUNT, day, hour, minute, millis / 1000)
        - timedelta(seconds=float(whole[31]) * interval),
        event=f"earthquake of {when}" + (f" (epicentre {where})" if where else ""),
        origin_time_utc=parse_time_as_utc(" ".join(text[7].split()), "%Y %B %d %H:%M:%S UT"),
        header_peak=header.field_peak_acceleration(
            "Acceleration: Peak in mm/s/s", MILLIMETRE_IN_M, format_states_sign_of_peak=True
        ),
        is_already_corrected=corrected,
        # 0 stands for an unknown magnitude.
        extra_metadata=({"magnitude": float(real[14])} if real[14] > 0 else {}) | agency,
        notes=notes,
    ), end
