"""CWA (Central Weather Administration, Taiwan; CWB before 2023): three components in one file, Gal, offset removed.

The format, as its files describe themselves: lines ``#Key: text``, of which ``#DataSequence`` names the columns with
their signs, ``#AmplitudeMAX`` the largest and smallest sample, and ``#Data`` the FORTRAN format; then a time and three
samples per line. Times are those of Taiwan.
"""

import re
from datetime import timedelta
from typing import Final

import numpy as np

from overturning.records.component import Component, StatedPeak
from overturning.records.formats.lines import FLOAT, Header, Lines, resolution, stated_time
from overturning.records.source import SourceFile
from overturning.units import GAL

TAIWAN: Final = timedelta(hours=8)
_AXES: Final = {"U": (None, 1), "N": (0.0, 0), "E": (90.0, 0)}


def detect(source: SourceFile) -> bool:
    """Whether a file begins like CWA's."""
    return source.data[:40].lstrip(b"\xef\xbb\xbf").startswith(b"#Earthquake Information")


def read(source: SourceFile) -> list[Component]:
    """Read all components; a RecordError names the line where the file is cut or contradicts itself."""
    lines = Lines.of(source)
    data_at = next((i for i, line in enumerate(lines.lines) if line.startswith("#Data:")), None)
    if data_at is None:
        raise lines.error(len(lines.lines) - 1, "no line #Data; the file is cut: get it again")
    header = Header.of(lines, data_at + 1, strip="#")
    if not header.text("AmplitudeUnit").lower().startswith("gal"):
        raise header.error("AmplitudeUnit", f"unit {header.text('AmplitudeUnit')!r}; only Gal is read")
    columns = _columns(header)
    rate = header.number("SampleRate(Hz)")
    if not 1.0 <= rate <= 100_000.0:
        raise header.error("SampleRate(Hz)", f"{rate:g} samples per second; correct it")
    values = lines.rows(data_at + 1, 1 + len(columns))
    lines.check_last_number(source.text[-200:])
    expected = round(header.number("RecordLength(sec)") * rate)
    # Some files have the sample at the end of the record, some do not.
    if not 0 <= values.shape[0] - expected <= 1:
        why = f"{values.shape[0]} samples, but {expected} are {header.text('RecordLength(sec)')} s at {rate:g} Hz"
        raise header.error("RecordLength(sec)", f"{why}; the file is cut or holds more: get it again")
    uneven = np.flatnonzero(np.abs(values[:, 0] - values[0, 0] - np.arange(values.shape[0]) / rate) > 0.0011)
    if uneven.size:
        raise lines.error(data_at + 1 + int(uneven[0]), f"time {values[uneven[0], 0]:g} s does not fit {rate:g} Hz")
    start = header.time("StartTime(GMT+08)", "%Y/%m/%d-%H:%M:%S.%f") - TAIWAN
    places = [("event_latitude", "EpicenterLatitude(N)"), ("event_longitude", "EpicenterLongitude(E)")]
    places += [("magnitude", "Magnitude(Ml)"), ("depth_km", "Depth(km)")]
    extra = {name: header.number(key) for name, key in places if header.text(key)}
    return [
        Component.of(
            source,
            f"{letter}({'+' if sign > 0 else '-'})",
            (None if azimuth is None else (azimuth + (0.0 if sign > 0 else 180.0)) % 360.0, vertical * sign),
            values[:, column] * GAL,
            1.0 / rate,
            start=start,
            station=header.text("StationCode"),
            event=f"earthquake of {header.text('Origin Time(GMT+08)')} (GMT+8)",
            origin=stated_time(header.text("Origin Time(GMT+08)"), "%Y/%m/%d-%H:%M:%S", TAIWAN),
            latitude=header.number("StationLatitude(N)"),
            longitude=header.number("StationLongitude(E)"),
            peak=_peak(header, letter),
            extra=extra,
        )
        for column, (letter, sign, azimuth, vertical) in enumerate(columns, 1)
    ]


def _columns(header: Header) -> list[tuple[str, int, float | None, int]]:
    """Letter, sign, azimuth and vertical sense of the columns after the time."""
    said = header.text("DataSequence")
    words = re.findall(r"\b([UNE])\(([+-])\)", said)
    if not said.startswith("Time") or sorted(letter for letter, _ in words) != ["E", "N", "U"]:
        raise header.error("DataSequence", f"columns {said!r}; known are Time U(+); N(+); E(+) in any order and sign")
    return [(letter, 1 if sign == "+" else -1, *_AXES[letter]) for letter, sign in words]


def _peak(header: Header, letter: str) -> StatedPeak:
    key = f"AmplitudeMAX. {letter}"
    stated = re.fullmatch(rf"({FLOAT})\s*~\s*({FLOAT})", header.text(key))
    if stated is None:
        raise header.error(key, f"{header.text(key)!r} where the largest and smallest sample belong; get it again")
    size = max(abs(header.number(key, stated[1])), abs(header.number(key, stated[2])))
    return StatedPeak(size * GAL, resolution(stated[1]) * GAL, line=header.at(key) + 1)
