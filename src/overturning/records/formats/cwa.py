"""CWA (Central Weather Administration, Taiwan; CWB before 2023): three components in one file, Gal, offset removed.

The format, as its files describe themselves: header lines ``#Key: text``. ``#DataSequence`` names the columns with
their signs, ``#AmplitudeMAX`` the largest and smallest sample, ``#Data`` the FORTRAN format. Each data line has a time
and three samples. Times are Taiwan time.
"""

import re
from datetime import timedelta
from typing import Final

from overturning.records.axis_direction import AzimuthAndVerticalSense
from overturning.records.component import PeakStatedInFileHeader, RecordComponent
from overturning.records.formats.header import HeaderFieldPatterns, HeaderFields, parse_time_as_utc
from overturning.records.formats.lines import FLOAT_PATTERN
from overturning.records.source import SourceFile
from overturning.units import GAL

TAIWAN_UTC_OFFSET: Final = timedelta(hours=8)
DIRECTION_BY_AXIS_NAME: Final[dict[str, AzimuthAndVerticalSense]] = {
    "U(+)": (None, 1),
    "N(+)": (0.0, 0),
    "E(+)": (90.0, 0),
    "U(-)": (None, -1),
    "N(-)": (180.0, 0),
    "E(-)": (270.0, 0),
}
HEADER_KEYS: Final = (
    *("Origin Time(GMT+08)", "EpicenterLongitude(E)", "EpicenterLatitude(N)", "Depth(km)", "Magnitude(Ml)"),
    *("StationCode", "StationLongitude(E)", "StationLatitude(N)", "StartTime(GMT+08)", "RecordLength(sec)"),
    *("SampleRate(Hz)", "AmplitudeUnit", "DataSequence", *(f"AmplitudeMAX. {letter}" for letter in "UNE"), "Data"),
)
HEADER_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {key: rf"^#{re.escape(key)}\s*:(.*)" for key in HEADER_KEYS}


def read_components(source_file: SourceFile) -> list[RecordComponent]:
    """Read the components of a CWA file (Taiwan); raise a RecordError with the line number if it is damaged."""
    header = HeaderFields.find_fields(source_file, HEADER_FIELD_PATTERNS)
    first = header.line_index_of_field("Data") + 1
    header.check_field_pattern("AmplitudeUnit", "gal", "Gal")
    sequence = header.field_text("DataSequence")
    columns = re.findall(r"\b[UNE]\([+-]\)", sequence)
    if not sequence.startswith("Time") or sorted(axis[0] for axis in columns) != ["E", "N", "U"]:
        why = f"columns {sequence!r}; known are Time U(+); N(+); E(+) in any order and sign"
        raise header.line_error("DataSequence", why)
    interval = header.sampling_interval_of_rate_field("SampleRate(Hz)")
    values = header.read_number_rows(first, 1 + len(columns))
    expected = round(header.number_in_field("RecordLength(sec)") / interval)
    # Some files have the sample at the end of the record, some do not.
    expected += len(values) == expected + 1
    values, notes = header.cut_to_stated_sample_count_with_notes("RecordLength(sec)", values, str(expected))
    header.check_times_have_constant_interval(first, values[:, 0], interval, 1, "get the file again")
    return [
        header.create_component(
            axis,
            DIRECTION_BY_AXIS_NAME[axis],
            values[:, column] * GAL,
            interval,
            start_time_utc=header.field_utc_time(
                "StartTime(GMT+08)", "%Y/%m/%d-%H:%M:%S.%f", utc_offset=TAIWAN_UTC_OFFSET
            ),
            station=header.field_text("StationCode"),
            event=f"earthquake of {header.field_text('Origin Time(GMT+08)')} (GMT+8)",
            origin_time_utc=parse_time_as_utc(
                header.field_text("Origin Time(GMT+08)"), "%Y/%m/%d-%H:%M:%S", utc_offset=TAIWAN_UTC_OFFSET
            ),
            station_latitude_longitude_deg=(
                header.number_in_field("StationLatitude(N)"),
                header.number_in_field("StationLongitude(E)"),
            ),
            header_peak=_read_header_peak(header, f"AmplitudeMAX. {axis[0]}"),
            epicentre=(
                header.optional_number_in_field("EpicenterLatitude(N)"),
                header.optional_number_in_field("EpicenterLongitude(E)"),
            ),
            extra_metadata=header.number_fields_as_metadata({"magnitude": "Magnitude(Ml)", "depth_km": "Depth(km)"}),
            notes=notes,
        )
        for column, axis in enumerate(columns, 1)
    ]


def _read_header_peak(header: HeaderFields, field_name: str) -> PeakStatedInFileHeader:
    """Return the peak of a component, the larger of the two extremes in a header field."""
    stated = re.fullmatch(rf"({FLOAT_PATTERN})\s*~\s*({FLOAT_PATTERN})", header.field_text(field_name))
    if stated is None:
        raise header.line_error(
            field_name, f"{header.field_text(field_name)!r} where the largest and smallest sample belong; get it again"
        )
    return header.field_peak_acceleration(
        field_name,
        GAL,
        max(stated.groups(), key=lambda text: abs(header.number_in_field(field_name, text))),
        format_states_sign_of_peak=True,
    )
