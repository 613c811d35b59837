"""CWA (Central Weather Administration, Taiwan; CWB before 2023): three components in one file, Gal, offset removed.

The format, as its files describe themselves: header lines ``#Key: text``. ``#DataSequence`` names the columns with
their signs, ``#AmplitudeMAX`` the largest and smallest sample, ``#Data`` the FORTRAN format. Each data line has a time
and three samples. Times are Taiwan time.
"""

import re
from datetime import timedelta
from typing import Final

from overturning.records.component import Component, Direction, HeaderPeak
from overturning.records.formats.header import Fields, Header, stated_time
from overturning.records.formats.lines import FLOAT
from overturning.records.source import SourceFile
from overturning.units import GAL

TAIWAN: Final = timedelta(hours=8)
AXES: Final[dict[str, Direction]] = {
    "U(+)": (None, 1),
    "N(+)": (0.0, 0),
    "E(+)": (90.0, 0),
    "U(-)": (None, -1),
    "N(-)": (180.0, 0),
    "E(-)": (270.0, 0),
}
KEYS: Final = (
    *("Origin Time(GMT+08)", "EpicenterLongitude(E)", "EpicenterLatitude(N)", "Depth(km)", "Magnitude(Ml)"),
    *("StationCode", "StationLongitude(E)", "StationLatitude(N)", "StartTime(GMT+08)", "RecordLength(sec)"),
    *("SampleRate(Hz)", "AmplitudeUnit", "DataSequence", *(f"AmplitudeMAX. {letter}" for letter in "UNE"), "Data"),
)
FIELDS: Final[Fields] = {key: rf"^#{re.escape(key)}\s*:(.*)" for key in KEYS}


def read(source: SourceFile) -> list[Component]:
    """Read all components; a RecordError names the line where the file is cut or contradicts itself."""
    header = Header.of(source, FIELDS)
    first = header.at("Data") + 1
    header.check_unit("AmplitudeUnit", "gal", "Gal")
    sequence = header.text("DataSequence")
    columns = re.findall(r"\b[UNE]\([+-]\)", sequence)
    if not sequence.startswith("Time") or sorted(axis[0] for axis in columns) != ["E", "N", "U"]:
        why = f"columns {sequence!r}; known are Time U(+); N(+); E(+) in any order and sign"
        raise header.error("DataSequence", why)
    interval = header.interval("SampleRate(Hz)")
    values = header.rows(first, 1 + len(columns))
    expected = round(header.value("RecordLength(sec)") / interval)
    # Some files have the sample at the end of the record, some do not.
    expected += len(values) == expected + 1
    values, notes = header.stated_samples("RecordLength(sec)", values, str(expected))
    header.check_spacing(first, values[:, 0], interval, 1, "get the file again")
    return [
        header.component(
            axis,
            AXES[axis],
            values[:, column] * GAL,
            interval,
            start=header.moment("StartTime(GMT+08)", "%Y/%m/%d-%H:%M:%S.%f", ahead=TAIWAN),
            station=header.text("StationCode"),
            event=f"earthquake of {header.text('Origin Time(GMT+08)')} (GMT+8)",
            origin=stated_time(header.text("Origin Time(GMT+08)"), "%Y/%m/%d-%H:%M:%S", ahead=TAIWAN),
            coordinates=(header.value("StationLatitude(N)"), header.value("StationLongitude(E)")),
            peak=_peak(header, f"AmplitudeMAX. {axis[0]}"),
            epicentre=(header.optional("EpicenterLatitude(N)"), header.optional("EpicenterLongitude(E)")),
            extra=header.numbers({"magnitude": "Magnitude(Ml)", "depth_km": "Depth(km)"}),
            notes=notes,
        )
        for column, axis in enumerate(columns, 1)
    ]


def _peak(header: Header, key: str) -> HeaderPeak:
    stated = re.fullmatch(rf"({FLOAT})\s*~\s*({FLOAT})", header.text(key))
    if stated is None:
        raise header.error(key, f"{header.text(key)!r} where the largest and smallest sample belong; get it again")
    return header.peak(key, GAL, max(stated.groups(), key=lambda text: abs(header.value(key, text))))
