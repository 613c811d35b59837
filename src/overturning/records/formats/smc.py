"""USGS SMC: one component per file, cm/s².

The format: Seekins et al. (1992), USGS DDS-7; per file 11 lines of text, 48 integers (8I10), 50 reals (5E15.7), comment
lines that begin with ``|``, then eight samples per line of ten columns each, which touch.
"""

import re
from datetime import datetime, timedelta
from functools import partial
from typing import Final

import numpy as np

from overturning.records.axis_direction import (
    AzimuthAndVerticalSense,
    checked_axis_direction_from_name_or_code,
    direction_from_azimuth_and_dip_with_notes,
)
from overturning.records.component import PeakStatedInFileHeader, RecordComponent
from overturning.records.formats.header import parse_time_as_utc
from overturning.records.formats.lines import TextLines
from overturning.records.source import SourceFile
from overturning.units import GAL

IS_CORRECTED_BY_FIRST_LINE: Final = {"1 UNCORRECTED ACCELEROGRAM": False, "2 CORRECTED ACCELEROGRAM": True}
HEADER_TEXT_LINE_COUNT: Final = 11
HEADER_LINE_COUNT: Final = 27
MISSING_VALUE_MARKER: Final = -32768
BRIDGE_SENSOR_LOCATION_BY_CODE: Final = {
    1: "base of a pier",
    2: "abutment of a bridge",
    3: "deck above a pier",
    4: "deck between piers",
}
DAM_SENSOR_LOCATION_BY_CODE: Final = {1: "base of a dam", 2: "crest of a dam", 3: "abutment of a dam"}
"""Location of a sensor on a bridge (integer 27) or a dam (integer 28)."""


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the one component of an SMC file (USGS), as a list; a RecordError names the line of an error."""
    text = TextLines(source_file, source_file.lines)
    lines = text.lines
    kind = lines[0].strip()
    if kind not in IS_CORRECTED_BY_FIRST_LINE:
        raise text.line_error(0, f"{kind!r}; only accelerograms are read (kinds 1 and 2): get that file")
    text.check_header_length(HEADER_LINE_COUNT)
    whole = text.read_fixed_width_integers(HEADER_TEXT_LINE_COUNT, column_width=10, numbers_per_line=8, number_count=48)
    real = text.read_fixed_width_numbers(17, column_width=15, numbers_per_line=5, number_count=50)
    known = {index: float(value) for index, value in enumerate(real) if value != real[0]}
    if 1 not in known:
        why = f"no sampling rate: {real[1]:.2g} is the format's word for undefined, so samples are not evenly spaced"
        raise text.line_error(17, f"{why}; use the corrected file")
    interval = text.sampling_interval_of_rate(known[1], 17)
    extreme = max((known[index] for index in (29, 31) if index in known), key=abs, default=None)
    samples, notes = _read_samples_in_gal_and_notes(text, int(whole[15]), int(whole[16]))
    axis, direction, inclined = _axis_name_direction_and_notes(text, whole)
    station = re.search(r"station\s*=\s*(.*?)[\s,]*component=", lines[5])
    return [
        RecordComponent.from_file(
            source_file,
            axis,
            direction,
            samples * GAL,
            interval,
            start_time_utc=_utc_time_of_first_sample(whole, text),
            station=(station[1] if station else "") or lines[2].strip(),
            origin_time_utc=parse_time_as_utc(" ".join(lines[3].split()[:4]), "%Y %m %d %H%M"),
            event=re.sub(r"^\s*\d+\s+\d+\s+\d+\s+\d*\s*", "", lines[3]).strip(),
            station_latitude_longitude_deg=(known.get(10), known.get(11)),
            # The header has seven digits, the data have five: they may differ by half a unit of the data's last digit.
            header_peak=PeakStatedInFileHeader.from_signed_acceleration(extreme * GAL, 1e-4, line_number=23)
            if extreme is not None
            else None,
            sensor_location=_sensor_location_in_structure(whole),
            is_already_corrected=IS_CORRECTED_BY_FIRST_LINE[kind],
            extra_metadata={"magnitude": known[5]} if 5 in known else {},
            notes=(*notes, *inclined, *_flagged_problem_and_longitude_notes(source_file.name, whole, known)),
        )
    ]


def _read_samples_in_gal_and_notes(
    lines: TextLines, comment_line_count: int, stated_sample_count: int
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the samples, cm/s², that follow the comment lines, and a note if there are more than stated."""
    if stated_sample_count < 2 or not 0 <= comment_line_count <= 10_000:
        raise lines.line_error(
            13, f"{stated_sample_count} samples and {comment_line_count} comment lines; correct the header"
        )
    first = HEADER_LINE_COUNT + comment_line_count
    for index, line in enumerate(lines.lines[HEADER_LINE_COUNT:first], HEADER_LINE_COUNT):
        if not line.startswith("|"):
            raise lines.line_error(index, "a comment should begin with |; get the file again")
    samples, _, notes = lines.read_fixed_width_samples_next_line_and_notes(
        first, column_width=10, numbers_per_line=8, number_count=stated_sample_count, refuse_text_after_numbers=True
    )
    return samples, notes


def _axis_name_direction_and_notes(
    lines: TextLines, header_integers: np.ndarray
) -> tuple[str, AzimuthAndVerticalSense, tuple[str, ...]]:
    """Return axis name and direction from the header, and a note if the axis is inclined.

    Raises a RecordError if text and integers disagree, or if the axis is neither horizontal nor vertical.
    """
    word = re.search(r"component=\s*(\S+)", lines.lines[5])
    axis = word[1] if word else str(header_integers[13])
    # The integers count from upwards: 0 up, 90 horizontal, 180 down.
    from_up, azimuth = (None if number == MISSING_VALUE_MARKER else float(number) for number in header_integers[12:14])
    dip = None if from_up is None else from_up - 90.0
    coded, notes = direction_from_azimuth_and_dip_with_notes("", azimuth, dip, f"{lines.source.name}: axis {axis}")
    return axis, checked_axis_direction_from_name_or_code(axis, coded, partial(lines.line_error, 5)), notes


def _sensor_location_in_structure(header_integers: np.ndarray) -> str:
    """Return the location of the sensor in a building, bridge or dam from the header's integers; else ""."""
    floor, bridge, dam = (int(header_integers[i]) for i in (24, 26, 27))
    if 0 < floor < 200:
        return f"{floor}{({1: 'st', 2: 'nd', 3: 'rd'}).get(floor, 'th')} floor"
    return BRIDGE_SENSOR_LOCATION_BY_CODE.get(bridge, DAM_SENSOR_LOCATION_BY_CODE.get(dam, ""))


def _flagged_problem_and_longitude_notes(
    file_name: str, header_integers: np.ndarray, header_real_by_index: dict[int, float]
) -> list[str]:
    """Return notes on a problem that the header flags, and on a longitude that may be positive to the west."""
    flagged = (
        [f"{file_name}: its header flags a problem with the record; read its comments"]
        if header_integers[17] == 1
        else []
    )
    east = header_real_by_index.get(11, 0.0)
    remedy = "give station_longitude_deg where it counts to the west, as some of these files do"
    return flagged + ([f"the station's longitude {east:g} is taken as east; {remedy}"] if east > 0 else [])


def _utc_time_of_first_sample(header_integers: np.ndarray, lines: TextLines) -> datetime | None:
    """Return the UTC time of the first sample from year, day of year and time of day; None if not stated.

    A time of whole minutes without milliseconds is that of the earthquake (digitised film), so it gives None, too.
    """
    year, day, hour, minute, second, millis = (int(n) for n in header_integers[1:7])
    if (
        MISSING_VALUE_MARKER in (year, day, hour, minute)
        or year == 0
        or (second in (0, MISSING_VALUE_MARKER) and millis == MISSING_VALUE_MARKER)
    ):
        return None
    if not (1 <= day <= 366 and 1880 <= year <= 2200):
        raise lines.line_error(11, f"start {year}, day {day}, {hour}:{minute}; correct the header")
    seconds = sum(value * unit for value, unit in ((second, 1), (millis, 0.001)) if value != MISSING_VALUE_MARKER)
    return lines.utc_time(11, (year, 1, 1), hour, minute, 0) + timedelta(days=day - 1, seconds=seconds)
