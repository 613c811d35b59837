"""K-NET and KiK-net ASCII of NIED, one component per file.

The format: seventeen header lines (key in columns 1 to 18, value after them), then counts, eight to a line;
acceleration in Gal is count times scale factor. (obspy reads it too, but takes a cut header, ``99.5Hz`` or a fractional
scale factor without a warning.)
"""

import re
from datetime import timedelta
from typing import Final

from overturning.arrays import FloatArray
from overturning.records.component import RecordComponent, SensorPosition
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields, parse_time_as_utc
from overturning.records.formats.lines import TextLines
from overturning.records.source import SourceFile
from overturning.units import GAL

HEADER_KEYS: Final = (
    *("Origin Time", "Lat.", "Long.", "Depth. (km)", "Mag.", "Station Code", "Station Lat.", "Station Long."),
    *("Station Height(m)", "Record Time", "Sampling Freq(Hz)", "Duration Time(s)", "Dir.", "Scale Factor"),
    *("Max. Acc. (gal)", "Last Correction", "Memo."),
)
"""Keys of the header's lines, in order."""
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    key: (line, rf"^{re.escape(key)}(.*)") for line, key in enumerate(HEADER_KEYS)
}

METADATA_NAME_BY_HEADER_KEY: Final = {
    "Mag.": "magnitude", "Depth. (km)": "depth_km", "Lat.": "event_latitude", "Long.": "event_longitude",
}  # fmt: skip
_DIRECTION_CODES_SENSOR_NUMBER_AND_POSITION: Final[tuple[tuple[tuple[str, ...], str, SensorPosition], ...]] = (
    (("N-S", "E-W", "U-D"), "", "surface"),
    (("1", "2", "3"), "1", "borehole"),
    (("4", "5", "6"), "2", "surface"),
)
EXTENSION_AZIMUTH_SENSE_SENSOR_BY_DIRECTION_CODE: Final[dict[str, tuple[str, float | None, int, SensorPosition]]] = {
    code: (f"{axis}{number}", azimuth, vertical, sensor)
    for codes, number, sensor in _DIRECTION_CODES_SENSOR_NUMBER_AND_POSITION
    for code, (axis, azimuth, vertical) in zip(codes, (("NS", 0.0, 0), ("EW", 90.0, 0), ("UD", None, 1)), strict=True)
}
"""File extension, azimuth (degrees), vertical sense and sensor for each direction code."""

TIME_FORMAT: Final = "%Y/%m/%d %H:%M:%S"
JAPAN_UTC_OFFSET: Final = timedelta(hours=9)
TRIGGER_TIME_AFTER_FIRST_SAMPLE: Final = timedelta(seconds=15)
"""Time of the trigger after the first sample; the header states the time of the trigger."""


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the one component of a K-NET or KiK-net file, m/s², as a list; its offset is not removed.

    A RecordError names the line of an error.
    """
    header = HeaderFields.find_fields(source_file, HEADER_FIELD_PATTERNS, min_line_count=len(HEADER_KEYS))
    if not re.fullmatch(r"[A-Z0-9]{3,7}", station := header.field_text("Station Code")):
        raise header.line_error(
            "Station Code", f"station code {station!r}; it has 3 to 7 letters and digits: correct it"
        )
    interval = header.sampling_interval_of_rate_field(
        "Sampling Freq(Hz)", header.field_text("Sampling Freq(Hz)").removesuffix("Hz")
    )
    direction = header.field_text("Dir.")
    if direction not in EXTENSION_AZIMUTH_SENSE_SENSOR_BY_DIRECTION_CODE:
        raise header.line_error(
            "Dir.",
            f"direction {direction!r}; known are "
            f"{', '.join(EXTENSION_AZIMUTH_SENSE_SENSOR_BY_DIRECTION_CODE)}: correct it",
        )
    extension, azimuth, vertical, sensor = EXTENSION_AZIMUTH_SENSE_SENSOR_BY_DIRECTION_CODE[direction]
    named = source_file.extension.upper()
    if named != extension and named in [
        known for known, *_ in EXTENSION_AZIMUTH_SENSE_SENSOR_BY_DIRECTION_CODE.values()
    ]:
        why = f"direction {direction!r} in a file named .{named}; components are swapped: give the file its right name"
        raise header.line_error("Dir.", why)
    start = header.field_utc_time(
        "Record Time", TIME_FORMAT, utc_offset=JAPAN_UTC_OFFSET + TRIGGER_TIME_AFTER_FIRST_SAMPLE
    )
    known = {name: header.field_text(key) for key, name in METADATA_NAME_BY_HEADER_KEY.items()}
    counts = _read_digitiser_counts(header)
    expected = round(header.number_in_field("Duration Time(s)") / interval)
    counts, notes = header.cut_to_stated_sample_count_with_notes("Duration Time(s)", counts, str(expected))
    return [
        header.create_component(
            extension,
            (azimuth, vertical),
            counts * _acceleration_per_count(header),
            interval,
            # The record table may give `kik-net` for both networks.
            format_name="k-net" if direction in _DIRECTION_CODES_SENSOR_NUMBER_AND_POSITION[0][0] else "kik-net",
            start_time_utc=start,
            station=station,
            event=header.field_text("Origin Time") + " JST",
            origin_time_utc=parse_time_as_utc(
                header.field_text("Origin Time"), TIME_FORMAT, utc_offset=JAPAN_UTC_OFFSET
            ),
            station_latitude_longitude_deg=(
                header.number_in_field("Station Lat."),
                header.number_in_field("Station Long."),
            ),
            header_peak=header.field_peak_acceleration("Max. Acc. (gal)", GAL, is_peak_after_mean_removal=True),
            sensor_position=sensor,
            # An unknown magnitude is blank.
            extra_metadata={
                name: float(text) for name, text in known.items() if re.fullmatch(r"[+-]?\d+(\.\d+)?", text)
            },
            notes=notes,
        )
    ]


def _acceleration_per_count(header: HeaderFields) -> float:
    """Return the acceleration of one count, m/s², from a scale factor such as ``7845(gal)/8223790``."""
    text = header.field_text("Scale Factor")
    match = re.fullmatch(r"([\d.]+)\s*\(gal\)\s*/\s*([\d.]+)", text)
    if match is None:
        raise header.line_error("Scale Factor", f"scale factor {text!r}; it reads like 7845(gal)/8223790")
    above, below = (header.number_in_field("Scale Factor", part) for part in match.groups())
    if above <= 0 or below <= 0:
        raise header.line_error("Scale Factor", f"scale factor {text!r}; both numbers must be positive")
    return above / below * GAL


def _read_digitiser_counts(lines: TextLines) -> FloatArray:
    """Return the samples as digitiser counts; raise a RecordError if the last number is incomplete."""
    for index, line in enumerate(lines.lines[len(HEADER_KEYS) :], len(HEADER_KEYS)):
        for word in line.split():
            if not re.fullmatch(r"[+-]?[0-9]{1,15}", word):
                raise lines.line_error(index, f"sample {word!r} is not a whole number; get the file again")
    full = [line.rstrip() for line in lines.lines[len(HEADER_KEYS) :] if line.strip()]
    if len(full) > 1 and not lines.ends_with_newline:
        ends, last = ([word.end() for word in re.finditer(r"\S+", line)] for line in full[-2:])
        if last != ends[: len(last)]:
            raise lines.line_error(len(lines.lines) - 1, "the last sample is cut; get the file again")
    return lines.read_all_numbers(len(HEADER_KEYS))
