"""USC volume 1 (University of Southern California, Los Angeles): film digitised at uneven times, g/10.

The format, as its files have it: per channel 13 lines of text (with their lengths in columns 73 and 74), 100 integers
(16I5, or 20I4), 50 reals (8F10), then lines of a blank and five (or four) pairs of time and acceleration (F7); a line
of text may end the channel. Integer 27 is the azimuth (500 up, 600 down), integer 28 the count; real 5 is the unit as a
fraction of g, real 12 the magnitude. The header states neither a peak nor a start time.
"""

import re
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.records.axis_direction import (
    VERTICAL_DIRECTION_BY_FILM_AZIMUTH_CODE,
    checked_axis_direction_from_name_or_code,
    horizontal_direction_from_azimuth_code,
)
from overturning.records.component import RecordComponent
from overturning.records.formats.header import (
    DEGREE_MINUTE_SECOND_PATTERN,
    HeaderFieldPatterns,
    HeaderFields,
    parse_time_as_utc,
)
from overturning.records.formats.lines import FLOAT_PATTERN, TextLines, decorator_for_reading_all_components
from overturning.units import STANDARD_GRAVITY

HEADER_TEXT_LINE_COUNT: Final = 13
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "origin": (2, r"^(\w{3} +\d+, *\d{4} +-?\d{4} +GMT)|^"),
    "station": (4, r"^STATION USC# *(\d+)"),
    "coordinates": (4, rf"{DEGREE_MINUTE_SECOND_PATTERN}|$"),
    "site": (5, r"^(.{1,72})"),
    "COMP": (6, r"^COMP +(\S+)"),
    "event": (7, r"^(.{1,72})"),
    "epicentre": rf"^EPICENTER\D+{DEGREE_MINUTE_SECOND_PATTERN}",
    "NO. OF POINTS": (10, r"^NO\. OF POINTS *= *(\d+)"),
    "DURATION": (10, rf"DURATION *= *({FLOAT_PATTERN})"),
    "UNITS ARE SEC AND G/10 (no other is read)": (11, r"^(UNITS ARE SEC AND G/10)\b"),
}
RESAMPLED_SAMPLING_INTERVAL_S: Final = 0.005
"""Sampling interval after resampling of uneven times, s; the instruments record up to 25 Hz."""
INTERPOLATION_OVERSAMPLING_FACTOR: Final = 5
"""Oversampling factor of the cubic interpolation before the anti-alias filter."""
MAX_TIME_BETWEEN_SAMPLES_S: Final = 0.1
"""Longest time between two samples, s; the instruments have periods of 0.04 s."""


@decorator_for_reading_all_components(
    r"FILE +\d+ OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I\b", "only volume 1 is read: get that file"
)
def read_component_samples_and_count_lines(lines_from_channel_start: TextLines) -> tuple[RecordComponent, int]:
    """Read one component of a USC volume-1 file (California); return the component and its number of lines."""
    header = HeaderFields.find_fields(
        lines_from_channel_start,
        HEADER_FIELD_PATTERNS,
        HEADER_TEXT_LINE_COUNT,
        min_line_count=HEADER_TEXT_LINE_COUNT + 14,
    )
    text = lines_from_channel_start.lines
    # The narrow variant has its reals two lines earlier and four pairs per line.
    narrow = "." in text[HEADER_TEXT_LINE_COUNT + 5]
    whole = lines_from_channel_start.read_fixed_width_integers(
        HEADER_TEXT_LINE_COUNT, column_width=4 if narrow else 5, numbers_per_line=20 if narrow else 16, number_count=100
    )
    reals_at = HEADER_TEXT_LINE_COUNT + (5 if narrow else 7)
    real = lines_from_channel_start.read_fixed_width_numbers(
        reals_at, column_width=10, numbers_per_line=8, number_count=50
    )
    if abs(real[4] - 0.1) > 1e-6:
        raise lines_from_channel_start.line_error(
            reals_at, f"a unit of {real[4]:g} g, but the text says g/10; get the file again"
        )
    code, count = int(whole[26]), int(whole[27])
    header.check_sample_count("NO. OF POINTS", count)
    per_line, first = (8 if narrow else 10), reals_at + 7
    pairs = replace(lines_from_channel_start, lines=[line[1:] for line in text])
    values = pairs.read_fixed_width_numbers(first, column_width=7, numbers_per_line=per_line, number_count=2 * count)
    end, notes = lines_from_channel_start.skip_surplus_number_lines_with_notes(first + -(-2 * count // per_line), count)
    time, samples = values[0::2], values[1::2] * 0.1 * STANDARD_GRAVITY
    if abs(time[-1] - header.number_in_field("DURATION")) > 0.011:
        why = f"the last sample is at {time[-1]:g} s, the header's length {header.field_text('DURATION')} s"
        raise header.line_error("DURATION", f"{why}; the file is cut: get it again")
    samples, interval, resampled = _resample_uneven_samples_with_interval_and_notes(
        lines_from_channel_start, first, per_line // 2, time, samples
    )
    ends = end < len(text) and bool(text[end].strip()) and not text[end].startswith("FILE")
    return header.create_component(
        header.field_text("COMP"),
        checked_axis_direction_from_name_or_code(
            header.field_text("COMP"),
            VERTICAL_DIRECTION_BY_FILM_AZIMUTH_CODE.get(code, horizontal_direction_from_azimuth_code(code)),
            partial(header.line_error, "COMP"),
        ),
        samples,
        interval,
        station=f"USC {header.field_text('station')}, {header.field_text('site')}",
        origin_time_utc=parse_time_as_utc(re.sub("[-,]", " ", header.field_text("origin")), "%b %d %Y %H%M GMT"),
        is_digitised_from_analogue_film=True,
        extra_metadata={"magnitude": float(real[11])} if real[11] > 0 else {},
        notes=(*notes, *resampled),
    ), end + ends


def _resample_uneven_samples_with_interval_and_notes(
    lines_from_channel_start: TextLines,
    first_pair_line_index: int,
    pairs_per_line: int,
    time_s: FloatArray,
    acceleration: FloatArray,
) -> tuple[FloatArray, float, tuple[str, ...]]:
    """Return accelerations at constant intervals, the interval, s, and a note if uneven times required resampling."""
    steps = np.diff(time_s)
    wrong = np.flatnonzero([time_s[0] != 0, *(steps <= 0) | (steps > MAX_TIME_BETWEEN_SAMPLES_S)])
    if wrong.size:
        why = f"time {time_s[wrong[0]]:g} s; times begin at 0 and rise by at most {MAX_TIME_BETWEEN_SAMPLES_S:g} s"
        raise lines_from_channel_start.line_error(
            first_pair_line_index + int(wrong[0]) // pairs_per_line, f"{why}: get the file again"
        )
    mean = float(steps.mean())
    even = round(mean, 3)
    if np.abs(time_s - even * np.arange(time_s.size)).max() < 0.00051:
        return acceleration, even, ()
    from scipy.interpolate import PchipInterpolator
    from scipy.signal import resample_poly

    fine = np.arange(int(time_s[-1] / RESAMPLED_SAMPLING_INTERVAL_S * INTERPOLATION_OVERSAMPLING_FACTOR + 1e-6) + 1) * (
        RESAMPLED_SAMPLING_INTERVAL_S / INTERPOLATION_OVERSAMPLING_FACTOR
    )
    out = resample_poly(
        PchipInterpolator(time_s, acceleration)(fine), 1, INTERPOLATION_OVERSAMPLING_FACTOR, padtype="line"
    )
    note = (
        f"{lines_from_channel_start.source.name}: uneven times, {1e3 * mean:.1f} ms apart on average and "
        f"{1e3 * steps.max():.0f} ms at most, resampled to {1e3 * RESAMPLED_SAMPLING_INTERVAL_S:g} ms "
        "(monotone cubic, anti-alias filter at "
        f"{0.5 / RESAMPLED_SAMPLING_INTERVAL_S:g} Hz)"
    )
    return np.ascontiguousarray(out, dtype=np.float64), RESAMPLED_SAMPLING_INTERVAL_S, (note,)
