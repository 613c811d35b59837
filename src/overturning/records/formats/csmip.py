"""CSMIP / CGS volume 1 and volume 2, and RAW, which has volume 1's layout: all channels in one file.

The format: Shakal & Huang (1985), CSMIP report OSMS 85-03. Per channel 13 lines of text (25 in volume 2), 100 integers
(16I5), 50 or 100 reals (8F10), a line with count, rate, unit and format of the samples, the samples, in volume 2 also
velocity and displacement (not read), and an end mark. Old volume-1 files and those of RENADIC (Universidad de Chile)
hold pairs of time and acceleration instead (10F7, g/10). RENADIC's axes L, T and V state no azimuth and no sense.
"""

import re
from dataclasses import replace
from datetime import datetime, timedelta
from functools import partial
from typing import Final

import numpy as np

from overturning.records.axis_direction import (
    UNKNOWN_DIRECTION,
    VERTICAL_DIRECTION_BY_FILM_AZIMUTH_CODE,
    checked_axis_direction_from_name_or_code,
    horizontal_direction_from_azimuth_code,
    parse_axis_direction,
)
from overturning.records.component import (
    RecordComponent,
    classify_as_borehole_or_else_surface,
    sensor_location_in_header_line,
)
from overturning.records.formats.header import ORIGIN_AND_HYPOCENTRE_FIELD_PATTERNS, HeaderFieldPatterns, HeaderFields
from overturning.records.formats.lines import FLOAT_PATTERN, TextLines, decorator_for_reading_all_components
from overturning.units import GAL, STANDARD_GRAVITY

UNIT_IN_M_S2_BY_NAME: Final = {"g": STANDARD_GRAVITY, "g/10": 0.1 * STANDARD_GRAVITY} | dict.fromkeys(
    ("cm/sec2", "cm/sec/sec", "cms/sec/sec", "cm/s2", "gal"), GAL
)
END_OF_DATA_PATTERN: Final = re.compile(r"^\s*(/&|-{3,}\s*END OF DATA|END OF DATA)", re.IGNORECASE)
UTC_TIME_PATTERN: Final = r"(\d+)/\s*(\d+)/\s*(\d+),?\s*(\d+):\s*(\d+):\s*([\d.]+)\s*(?:UTC|GMT)"
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    **ORIGIN_AND_HYPOCENTRE_FIELD_PATTERNS,
    "CHAN with the axis": r"^\s*(?:.*\s)?CHAN\s*(\d+):\s*([^\s,]+)",
    "coordinates": rf"\bSTATION\s+(?:ID|NO)\b.*?({FLOAT_PATTERN})\s*([NS]),?\s*({FLOAT_PATTERN})\s*([EW])",
    "station": r"STATION\s+(?:ID\.?|NO\.?)\s*(\S+)",
    "channel": r"^\s*CHAN\s*\d+:\s*(.*)",
    "event": r"^\s*R(?:e?co?rd) of (.*?)(?:\s{3,}|\(|$)|^\s*(.*\bEARTHQUAKE\b.*?)(?:\s{3,}|\(|$)",
    "magnitude": rf"^\s*HYPOCENTER\b.*\bML\s*[=:]\s*({FLOAT_PATTERN})",
    "start": rf"START TIME:\s*{UTC_TIME_PATTERN}",
    "trigger": rf"TRIGGER TIME:\s*{UTC_TIME_PATTERN}",
    "processed by": r"\bPROCESSED:[\s\d/,]*([A-Z][A-Z./&]+(?: \d+)?)(?=[\s,]|$)",
    "renadic": "(UNIVERSIDAD DE CHILE - RENADIC)",
    # Two corner frequencies, or two ramps; the inner ends of the ramps bound the pass band.
    "filter": (
        rf"BAND-?PASS.*?(?<![\d.])({FLOAT_PATTERN})\s+(?:AND|TO|-)\s+({FLOAT_PATTERN})(?:\s*-\s*{FLOAT_PATTERN})?"
        r"\s*(?:HZ|CYC)"
    ),
    "NO. OF POINTS": r"NO\.? OF POINTS\s*=\s*(\d+)|^\s*(\d+) POINTS OF .*CORRECTED",
    "record length": rf"RECORD LENGTH\s*=\s*({FLOAT_PATTERN})",
    "unit of the pairs": r"UNITS OF .*SEC AND (G/10|G|CM/SEC/SEC|CM/SEC2)(?=[.,;\s]|$)",
}
RECORDER_WITHOUT_SATELLITE_CLOCK_PATTERN: Final = re.compile(r"\b(QDR|SSA-?[12]|SMA(-?1)?)\b", re.IGNORECASE)
"""Recorders of RENADIC without a satellite clock."""
MAX_PRE_EVENT_MEMORY: Final = timedelta(seconds=120)
"""Longest pre-event memory of a recorder."""
SIGNATURES_OF_FORMAT_AGENCY: Final = ("CSMIP", "CGS", "CDMG", "DMG", "OSMS")
"""Names under which the agency of this format signs its files; other names are those of other agencies."""
PEAK_ACCELERATION_PATTERN_BY_VOLUME: Final = {
    1: rf"MAX\s*=\s*({FLOAT_PATTERN})\s*(g\b)",
    2: rf"PEAK ACCELERATION\s*=\s*({FLOAT_PATTERN})\s*(g\b|cms?/sec/sec|cm/sec2|cm/s2|gal)",
}
"""Pattern of the peak and its unit for each volume."""
SAMPLE_BLOCK_HEADING_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "number of samples": r"^\s*(\d+)\s+(?:points of\s+)?accel",
    "rate": rf"at\s+({FLOAT_PATTERN})\s*(?:pts|points|samples)\s*/\s*sec",
    "rate or interval": rf"at\s+(?:equal\S*\s+)?({FLOAT_PATTERN})\s*sec",
    "unit": r"\bin\s+(?:units of\s+)?(g/10|\S+?)[.,;]?(?:\s|$|\()",
    "format": r"\((\d+)[FE](\d+)\.\d+\)",
}
"""Fields of the line before the samples."""


@decorator_for_reading_all_components(r"\s*((UN)?CORRECTED|RESPONSE)", "get the file again")
def read_component_samples_and_count_lines(lines_from_channel_start: TextLines) -> tuple[RecordComponent, int]:
    """Read one component of a CSMIP or CGS file (California); return the component and its number of lines."""
    volume = {"U": 1, "C": 2}.get(lines_from_channel_start.lines[0].lstrip()[0].upper())
    if volume is None:
        raise lines_from_channel_start.line_error(0, "response spectra (volume 3); get volume 1 or 2")
    end = next((i for i, line in enumerate(lines_from_channel_start.lines) if END_OF_DATA_PATTERN.match(line)), None)
    if end is None:
        raise lines_from_channel_start.line_error(
            len(lines_from_channel_start.lines) - 1, "the file ends without the end mark of a channel; get it again"
        )
    channel_lines = replace(lines_from_channel_start, lines=lines_from_channel_start.lines[:end])
    lines_of_one_text = 13 if volume == 1 else 25
    header = HeaderFields.find_fields(
        channel_lines,
        {**HEADER_FIELD_PATTERNS, "peak": PEAK_ACCELERATION_PATTERN_BY_VOLUME[volume]},
        lines_of_one_text,
        min_line_count=lines_of_one_text + 14,
    )
    at = header.line_index_of_field("CHAN with the axis")
    number, axis = header.line_index_and_match_by_field["CHAN with the axis"][1].groups()
    # Volume 2 names the axis in its first line too; only the channel's own line states the sensor's location.
    channel = header.field_text("channel")
    if channel and parse_axis_direction(channel.split()[0].rstrip(",")) != parse_axis_direction(axis):
        line_number = channel_lines.file_line_count_before_first_line + at + 1
        why = f"axis {channel.split()[0]!r}, but line {line_number} says {axis!r}"
        raise header.line_error("channel", f"{why}; find out which, and correct the file")
    whole = channel_lines.read_fixed_width_integers(
        lines_of_one_text, column_width=5, numbers_per_line=16, number_count=100
    )
    code = int(whole[26])
    # The code alone does not define the sense: RENADIC codes V as 500 without stating that it points up.
    senses = {} if parse_axis_direction(axis) == UNKNOWN_DIRECTION else VERTICAL_DIRECTION_BY_FILM_AZIMUTH_CODE
    direction = checked_axis_direction_from_name_or_code(
        axis, senses.get(code, horizontal_direction_from_azimuth_code(code)), partial(channel_lines.line_error, at)
    )
    introduced = re.compile(str(SAMPLE_BLOCK_HEADING_FIELD_PATTERNS["number of samples"]), re.IGNORECASE)
    data_at = next((i for i in range(lines_of_one_text + 7, end) if introduced.match(channel_lines.lines[i])), 0)
    samples, interval, notes = (
        _read_evenly_spaced_samples_interval_and_notes(channel_lines, data_at, header)
        if data_at
        else _read_samples_interval_and_notes_from_time_pairs(channel_lines, lines_of_one_text, header)
    )
    (latitude, longitude), station, start = (
        header.field_latitude_and_longitude_deg("coordinates"),
        header.field_text("station"),
        header.utc_time_of_month_day_year_field("start"),
    )
    origin, places = header.origin_time_and_epicentre_metadata()
    if header.field_text("renadic"):
        # RENADIC omits the station number, and writes 0° N, 0° E for an unknown place.
        station, start, places = channel_lines.lines[5].strip(), _start_time_of_renadic_file(header, origin), {}
        origin = None
        latitude, longitude = (latitude, longitude) if latitude or longitude else (None, None)
    signed = header.field_text("processed by") if volume == 2 else ""
    by = {"processed_by": signed} if signed and signed.upper() not in SIGNATURES_OF_FORMAT_AGENCY else {}
    filtered = header.field_pattern_match("filter") if volume == 2 else None
    agency = {"agency_processing": f"band-pass filter {filtered[1]} to {filtered[2]} Hz"} if filtered else {}
    component = header.create_component(
        f"chan {number}: {axis}",
        direction,
        samples,
        interval,
        start_time_utc=start,
        station=station,
        origin_time_utc=origin,
        station_latitude_longitude_deg=(latitude, longitude),
        sensor_position=classify_as_borehole_or_else_surface(location_text=channel),
        sensor_location=sensor_location_in_header_line(channel),
        header_peak=header.field_peak_acceleration(
            "peak", UNIT_IN_M_S2_BY_NAME[_header_peak_unit(header)], format_states_sign_of_peak=True
        )
        if header.field_text("peak")
        else None,
        is_already_corrected=volume == 2,
        extra_metadata=places | agency | by,
        notes=notes,
    )
    return component, end + 1


def _start_time_of_renadic_file(header: HeaderFields, time_in_origin_field_utc: datetime | None) -> datetime | None:
    """Return the UTC time of the first sample of a RENADIC file (Chile); None if no satellite clock gives it.

    In files of recorders with a satellite clock, the field ORIGIN is the time of the first sample in whole seconds. The
    motion begins at TRIGGER TIME, after the pre-event memory of 20 to 50 s, and the arrivals of P waves agree with this
    reading. The memory lasts whole seconds, so TRIGGER TIME gives the fraction of a second of the first sample.
    Recorders without a satellite clock write local time as GMT, or the date 1980-01-01.
    """
    trigger = header.utc_time_of_month_day_year_field("trigger")
    if (
        trigger is None
        or time_in_origin_field_utc is None
        or RECORDER_WITHOUT_SATELLITE_CLOCK_PATTERN.search(header.lines[4])
    ):
        return None
    if (trigger.year, trigger.month, trigger.day) == (1980, 1, 1):
        return None
    start = time_in_origin_field_utc.replace(microsecond=trigger.microsecond)
    return start if timedelta() <= trigger - start <= MAX_PRE_EVENT_MEMORY else None


def _header_peak_unit(header: HeaderFields) -> str:
    """Return the unit of the peak acceleration in the header, in lower case; "" if no peak is stated."""
    match = header.field_pattern_match("peak")
    return match[2].lower() if match else ""


def _read_evenly_spaced_samples_interval_and_notes(
    channel_lines: TextLines, sample_block_heading_line_index: int, header: HeaderFields
) -> tuple[np.ndarray, float, tuple[str, ...]]:
    """Return samples at constant intervals, m/s², their sampling interval, s, and notes on surplus lines."""
    data = HeaderFields.find_fields(
        replace(
            channel_lines,
            lines=channel_lines.lines[sample_block_heading_line_index:],
            file_line_count_before_first_line=channel_lines.file_line_count_before_first_line
            + sample_block_heading_line_index,
        ),
        SAMPLE_BLOCK_HEADING_FIELD_PATTERNS,
        1,
    )
    rate = data.optional_number_in_field("rate")
    interval = (
        data.number_in_field("rate or interval")
        if rate is None
        else channel_lines.sampling_interval_of_rate(rate, sample_block_heading_line_index)
    )
    unit = data.field_text("unit").lower() or _header_peak_unit(header)
    if unit not in UNIT_IN_M_S2_BY_NAME:
        raise channel_lines.line_error(
            sample_block_heading_line_index, f"unit {unit or 'missing'!r}; known are {', '.join(UNIT_IN_M_S2_BY_NAME)}"
        )
    form, count = data.field_pattern_match("format"), int(data.field_text("number of samples"))
    per_line, width = (
        (int(form[1]), int(form[2]))
        if form
        else _sample_column_count_and_width(channel_lines, sample_block_heading_line_index + 1)
    )
    samples, _, notes = channel_lines.read_fixed_width_samples_next_line_and_notes(
        sample_block_heading_line_index + 1, column_width=width, numbers_per_line=per_line, number_count=count
    )
    if header.field_text("record length"):
        header.check_sample_count("NO. OF POINTS", count)
        channel_lines.check_duration_stated_in_line(
            header.line_index_of_field("record length"), count, interval, header.number_in_field("record length")
        )
    return samples * UNIT_IN_M_S2_BY_NAME[unit], interval, notes


def _sample_column_count_and_width(channel_lines: TextLines, first_sample_line_index: int) -> tuple[int, int]:
    """Return number and width of the sample columns of a file that does not state their FORTRAN format.

    There are eight columns. Their width is an eighth of the first line's length (``8F9.6`` of RAW files: nine), or ten
    characters if the length is no multiple of eight.
    """
    width, rest = divmod(
        len("".join(channel_lines.lines[first_sample_line_index : first_sample_line_index + 1]).rstrip()), 8
    )
    return 8, width if width > 0 and not rest else 10


def _read_samples_interval_and_notes_from_time_pairs(
    channel_lines: TextLines, line_count_before_header_numbers: int, header: HeaderFields
) -> tuple[np.ndarray, float, tuple[str, ...]]:
    """Read time-acceleration pairs of old volume-1 files; return samples, m/s², sampling interval, s, and notes."""
    count, first = int(header.number_in_field("NO. OF POINTS")), line_count_before_header_numbers + 14
    header.check_field_pattern("unit of the pairs", ".", "g, g/10 or cm/sec/sec")
    values = channel_lines.read_fixed_width_numbers(first, column_width=7, numbers_per_line=10, number_count=2 * count)
    _, notes = channel_lines.skip_surplus_number_lines_with_notes(
        first + -(-2 * count // 10), count, refuse_text_after_numbers=True
    )
    time, samples = values[0::2], values[1::2]
    interval = round(float(time[-1] - time[0]) / max(count - 1, 1), 6)
    channel_lines.check_times_have_constant_interval(
        first, time, interval, 5, "not evenly spaced (digitised film): get volume 2 of the record"
    )
    return samples * UNIT_IN_M_S2_BY_NAME[header.field_text("unit of the pairs").lower()], interval, notes
