"""COSMOS volumes 0, 1 and 2 (format 1.20): one or more channels per file, in counts, g or cm/s².

The format: COSMOS Strong Motion Data Format, version 1.20 (2001). Per channel 13 lines of text after the first,
integers, reals and comments; a line before each set states the count and the FORTRAN format. The samples follow, with
the same kind of line before them, and an end mark. Counts of volume 0 become g by the reals 22 (µV per
count), 42 (sensitivity of the sensor, V/g) and 47 (gain).
"""

import re
from collections.abc import Sequence
from datetime import datetime
from functools import partial
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.records.axis_direction import (
    UNKNOWN_DIRECTION,
    AzimuthAndVerticalSense,
    checked_axis_direction_from_name_or_code,
    direction_from_channel_code,
    horizontal_direction_from_azimuth_code,
)
from overturning.records.component import (
    PeakStatedInFileHeader,
    RecordComponent,
    classify_as_borehole_or_else_surface,
    sensor_location_in_header_line,
)
from overturning.records.formats.header import ORIGIN_AND_HYPOCENTRE_FIELD_PATTERNS, HeaderFieldPatterns, HeaderFields
from overturning.records.formats.lines import TextLines, decorator_for_reading_all_components
from overturning.units import GAL, STANDARD_GRAVITY

UNIT_IN_M_S2_BY_CODE: Final = {2: STANDARD_GRAVITY, 4: GAL, 10: GAL, 11: 1e-3 * STANDARD_GRAVITY}
"""COSMOS table 2: g, cm/s², Gal, mg."""
UNIT_CODE_OF_DIGITISER_COUNTS: Final = 50
UNIT_CODE_BY_WORD: Final = {
    "g": 2,
    "cm/sec2": 4,
    "cm/sec/sec": 4,
    "cm/s2": 4,
    "cm/s/s": 4,
    "gal": 10,
    "mg": 11,
    "counts": UNIT_CODE_OF_DIGITISER_COUNTS,
}
"""Code of table 2 for each unit that the text may state; other words are ignored."""
MISSING_VALUE_MARKER: Final = -999.0

BLOCK_FORMAT_PATTERN: Final = re.compile(r"\s*(\d+)\s.*Format\s*=\s*\((\d+)[IFE](\d+)", re.IGNORECASE)
COMMENT_COUNT_PATTERN: Final = re.compile(r"\s*(\d+)\s+Comment", re.IGNORECASE)
END_OF_DATA_PATTERN: Final = re.compile(r"^\s*(/&|End-of-data|---+\s*End of data)", re.IGNORECASE)
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    **ORIGIN_AND_HYPOCENTRE_FIELD_PATTERNS,
    "corrected": "^\\s*(Corrected)",
    "processed by": r"Src:\s*(\S.*)",
    "processed": r"^\s*Processed:\s*(\S.*?),?\s+Max",
    "filter": r"Record filtered\s+(below\s.*?)\s*$",
    "clock": r"start time:\s*[\d/]+[,\s]+[\d:. ]+?\s*([A-Z]{3,4})\b",
    "event": (1, "(.*)"),
    "station": r"Code:\s*(\S+)",
    "axis": r"Sta Cha\w*:?\s+\S+?:\s*(.*?)\s*(?:\(|Location|$)",
}


def _parse_number_block_format_and_line_after_block(
    lines_from_channel_start: TextLines, number_block_heading_line_index: int, number_block_label_for_error: str
) -> tuple[dict[str, Any], int]:
    """Return number count, numbers per line and column width of a block, and the index of the line after the block."""
    match = (
        BLOCK_FORMAT_PATTERN.match(lines_from_channel_start.lines[number_block_heading_line_index])
        if number_block_heading_line_index < len(lines_from_channel_start.lines)
        else None
    )
    if match is None:
        raise lines_from_channel_start.line_error(
            number_block_heading_line_index,
            f"no line that introduces the {number_block_label_for_error}; the file is cut: get it again",
        )
    count, per_line, width = (int(number) for number in match.groups())
    if not (1 <= per_line <= 100 and 1 <= width <= 100):
        raise lines_from_channel_start.line_error(
            number_block_heading_line_index, f"format {match[0].strip()!r}; correct it"
        )
    form = {"number_count": count, "numbers_per_line": per_line, "column_width": width}
    return form, number_block_heading_line_index + 1 + -(-count // per_line)


@decorator_for_reading_all_components(r"\s*(Corrected|Uncorrected|Raw) accel.*\(Format v", "get the file again")
def read_component_samples_and_count_lines(lines_from_channel_start: TextLines) -> tuple[RecordComponent, int]:
    """Read one component of a COSMOS file; return the component and its number of lines."""
    text = lines_from_channel_start.lines
    stated = re.search(r"with\s+(\d+)\s+text lines", text[0])
    ints_at = int(stated[1]) if stated else 13
    form, reals_at = _parse_number_block_format_and_line_after_block(lines_from_channel_start, ints_at, "integers")
    header = HeaderFields.find_fields(lines_from_channel_start, HEADER_FIELD_PATTERNS, ints_at)
    whole = lines_from_channel_start.read_fixed_width_integers(ints_at + 1, **form)
    form, comments_at = _parse_number_block_format_and_line_after_block(lines_from_channel_start, reals_at, "reals")
    real = lines_from_channel_start.read_fixed_width_numbers(reals_at + 1, **form)
    if whole.size < 100 or real.size < 100:
        raise lines_from_channel_start.line_error(
            ints_at, f"{whole.size} integers and {real.size} reals; 100 each are needed"
        )
    comments = COMMENT_COUNT_PATTERN.match(text[comments_at]) if comments_at < len(text) else None
    if comments is None:
        raise lines_from_channel_start.line_error(
            comments_at, "no line that introduces the comments; get the file again"
        )
    data_at = comments_at + 1 + int(comments[1])
    form, _ = _parse_number_block_format_and_line_after_block(lines_from_channel_start, data_at, "samples")
    unit = _checked_sample_unit_code(lines_from_channel_start, data_at, int(whole[2]))
    scale = (
        _acceleration_per_count(lines_from_channel_start, reals_at, real)
        if unit == UNIT_CODE_OF_DIGITISER_COUNTS
        else UNIT_IN_M_S2_BY_CODE[unit]
    )
    samples, end, notes = lines_from_channel_start.read_fixed_width_samples_next_line_and_notes(data_at + 1, **form)
    if end >= len(text) or not END_OF_DATA_PATTERN.match(text[end]):
        raise lines_from_channel_start.line_error(
            end, f"no end mark after {samples.size} samples; the count is wrong or the file is cut"
        )
    interval = float(real[61]) * 1e-3 if real[61] > 0 else float(real[33])
    if real[62] > 0:
        lines_from_channel_start.check_duration_stated_in_line(data_at, samples.size, interval, float(real[62]))
    axis, direction = _axis_name_and_direction(header, text[comments_at + 1 : data_at], int(whole[53]))
    known = {index: float(value) for index, value in enumerate(real) if value != MISSING_VALUE_MARKER}
    origin, places = header.origin_time_and_epicentre_metadata()
    # Resolution of the stated peak: one count, or 1e-5 of the unit.
    digit = (1.0 if unit == UNIT_CODE_OF_DIGITISER_COUNTS else 1e-5) * scale
    peak = (
        PeakStatedInFileHeader(
            abs(known[63]) * scale,
            digit,
            line_number=lines_from_channel_start.file_line_count_before_first_line + reals_at + 12,
        )
        if 63 in known
        else None
    )
    component = header.create_component(
        axis,
        direction,
        samples * scale,
        interval,
        # The header does not state the offset of a local clock from UTC.
        start_time_utc=_utc_time_of_first_sample(lines_from_channel_start, whole, float(real[29]))
        if header.field_text("clock").upper() in ("", "UTC", "GMT")
        else None,
        origin_time_utc=origin,
        station_latitude_longitude_deg=(known.get(0), known.get(1)),
        sensor_position=classify_as_borehole_or_else_surface(location_text=text[8]),
        sensor_location=sensor_location_in_header_line(text[8]),
        header_peak=peak,
        is_already_corrected=bool(header.field_text("corrected")),
        extra_metadata=({"magnitude": known[12]} if 12 in known else {})
        | places
        | _processing_agency_and_filter_metadata(header),
        notes=notes,
    )
    return component, end + 1


def _processing_agency_and_filter_metadata(header: HeaderFields) -> dict[str, str]:
    """Return agency and filter of corrected data as metadata (`Record.extra`); {} if the data are not corrected."""
    if not header.field_text("corrected"):
        return {}
    when, corners = header.field_text("processed"), " ".join(header.field_text("filter").split())
    unnamed = f"the agency of the file ({when})" if when else "the agency of the file"
    filtered = {"agency_processing": f"filtered {corners}"} if corners else {}
    return {"processed_by": header.field_text("processed by") or unnamed} | filtered


def _acceleration_per_count(
    lines_from_channel_start: TextLines, reals_heading_line_index: int, header_reals: FloatArray
) -> float:
    """Return the acceleration of one digitiser count, m/s², from µV per count, V/g and gain in the header's reals."""
    microvolts, volts_per_g = float(header_reals[21]), float(header_reals[41])
    gain = 1.0 if header_reals[46] == MISSING_VALUE_MARKER else float(header_reals[46])
    for number, value, what in ((22, microvolts, "µV per count"), (42, volts_per_g, "V/g"), (47, gain, "gain")):
        if not value > 0:
            why = "is not stated" if value == MISSING_VALUE_MARKER else f"is {value:g}"
            raise lines_from_channel_start.line_error(
                reals_heading_line_index, f"counts, but real {number} ({what}) {why}; get volume 1 or 2"
            )
    return microvolts * 1e-6 / (volts_per_g * gain) * STANDARD_GRAVITY


def _checked_sample_unit_code(
    lines_from_channel_start: TextLines, sample_block_heading_line_index: int, unit_code_in_header_integers: int
) -> int:
    """Return the unit code of the samples (COSMOS table 2); raise a RecordError if the header contradicts itself."""
    line = lines_from_channel_start.lines[sample_block_heading_line_index]
    stated = re.search(r"units\s*=\s*([^,(]+)\(\s*(\d+)\s*\)", line, re.IGNORECASE)
    number = int(stated[2]) if stated else unit_code_in_header_integers
    if number not in (*UNIT_IN_M_S2_BY_CODE, UNIT_CODE_OF_DIGITISER_COUNTS) or not re.search(
        r"accel", line, re.IGNORECASE
    ):
        what = stated[1].strip() if stated else unit_code_in_header_integers
        remedy = "only acceleration in g, cm/sec2, gal, mg or counts is read: get volume 0, 1 or 2"
        raise lines_from_channel_start.line_error(sample_block_heading_line_index, f"samples in {what}; {remedy}")
    if (
        unit_code_in_header_integers in (*UNIT_IN_M_S2_BY_CODE, UNIT_CODE_OF_DIGITISER_COUNTS)
        and unit_code_in_header_integers != number
    ):
        raise lines_from_channel_start.line_error(
            sample_block_heading_line_index,
            f"unit {number}, but the integers say {unit_code_in_header_integers}; get the file again",
        )
    worded = UNIT_CODE_BY_WORD.get(stated[1].strip().lower().replace("^", ""), number) if stated else number
    if UNIT_IN_M_S2_BY_CODE.get(worded) != UNIT_IN_M_S2_BY_CODE.get(number):
        raise lines_from_channel_start.line_error(
            sample_block_heading_line_index,
            f"samples in {stated and stated[1].strip()}, but the code says {number}; get it again",
        )
    return number


def _axis_name_and_direction(
    header: HeaderFields, comment_lines: Sequence[str], azimuth_or_vertical_code: int
) -> tuple[str, AzimuthAndVerticalSense]:
    """Return axis name and direction from the header's axis text and azimuth code, or else a SEED channel code."""
    word = header.field_text("axis")
    coded = {400: (None, 1), 401: (None, -1)}.get(
        azimuth_or_vertical_code, horizontal_direction_from_azimuth_code(azimuth_or_vertical_code)
    )
    direction = checked_axis_direction_from_name_or_code(word, coded, partial(header.line_error, "axis"))
    if direction == UNKNOWN_DIRECTION and azimuth_or_vertical_code in (0, -999):
        found = re.search(r"<SCNL>\s*[^.\s]+\.([A-Z0-9]{3})\.", "\n".join([*header.lines[:13], *comment_lines]))
        word = found[1] if found else word
        direction = direction_from_channel_code(found[1] if found else "")
    return word or str(azimuth_or_vertical_code), direction


def _utc_time_of_first_sample(
    lines_from_channel_start: TextLines, header_integers: np.ndarray, seconds_after_minute: float
) -> datetime | None:
    """Return the UTC time of the first sample from the header's integers (year to minute) and seconds, or None."""
    year, _, month, day, hour, minute = (int(header_integers[i]) for i in range(39, 45))
    if MISSING_VALUE_MARKER in (year, month, day, hour, minute) or not 0 <= seconds_after_minute < 61:
        return None
    return lines_from_channel_start.utc_time(0, (year, month, day), hour, minute, round(seconds_after_minute, 6))
