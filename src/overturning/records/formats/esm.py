"""ESM / ITACA / DYNA ASCII: one component per file, cm/s²; 64 lines ``KEY: value``, then one sample per line."""

import re
from datetime import UTC, datetime
from typing import Final

from overturning.errors import RecordError
from overturning.records.axes import channel_axis
from overturning.records.component import Component, StatedPeak
from overturning.records.formats.numbers import check_last_number, column, number, resolution
from overturning.records.source import SourceFile
from overturning.units import GAL

NAME: Final = "esm-dyna"

_EVENT = {
    "MAGNITUDE_W": "magnitude",
    "EVENT_LATITUDE_DEGREE": "event_latitude",
    "EVENT_LONGITUDE_DEGREE": "event_longitude",
}

_LINE: Final = re.compile(r"([A-Z][A-Z0-9_/^]*):\s?(.*)")


def detect(source: SourceFile) -> bool:
    """Whether a file begins like DYNA."""
    return source.data[:12].lstrip(b"\xef\xbb\xbf").startswith((b"EVENT_NAME:", b"EVENT_ID:"))


def read(source: SourceFile) -> list[Component]:
    """Read one component.

    Raises
    ------
    RecordError
        If a key is missing, the unit is not cm/s², the count is wrong, or the data is not acceleration.
    """
    name, lines = source.name, source.lines
    header: dict[str, tuple[int, str]] = {}
    first = 0
    for first, line in enumerate(lines):
        match = _LINE.fullmatch(line.rstrip())
        if match is None:
            break
        header[match[1]] = (first + 1, match[2].strip())

    def text(key: str) -> str:
        if key not in header:
            raise RecordError(f"{name}: no header line {key}; get the file again")
        return header[key][1]

    def value(key: str) -> float:
        return number(text(key), name, header[key][0], key)

    if text("UNITS").replace(" ", "").lower() not in ("cm/s^2", "cm/s2"):
        raise RecordError(
            f"{name} line {header['UNITS'][0]}: unit {text('UNITS')!r}; only cm/s^2 is read: get acceleration"
        )
    kind = header.get("DATA_TYPE", (0, "ACCELERATION"))
    if kind[1] != "ACCELERATION":
        raise RecordError(f"{name} line {kind[0]}: {kind[1]}; only ACCELERATION is read: get that file")
    samples = column(lines[first:], name, first + 1)
    check_last_number(source.text[-200:], name, len(lines))
    if samples.size != int(value("NDATA")):
        raise RecordError(
            f"{name} line {header['NDATA'][0]}: header promises {text('NDATA')} samples, the file has {samples.size}; "
            "it is cut: get it again"
        )
    stream = text("STREAM")
    azimuth, vertical = channel_axis(stream)
    peak = header.get("PGA_CM/S^2", (0, ""))
    return [
        Component(
            samples=samples * GAL,
            sampling_interval=value("SAMPLING_INTERVAL_S"),
            axis=stream,
            azimuth_deg=azimuth,
            vertical=vertical,
            file=name,
            sha256=source.sha256,
            format=NAME,
            start=_start(header, name),
            station=header.get("STATION_CODE", (0, ""))[1],
            event=(header.get("EVENT_NAME", (0, ""))[1] or header.get("EVENT_ID", (0, ""))[1]),
            latitude=value("STATION_LATITUDE_DEGREE") if header.get("STATION_LATITUDE_DEGREE", (0, ""))[1] else None,
            longitude=value("STATION_LONGITUDE_DEGREE") if header.get("STATION_LONGITUDE_DEGREE", (0, ""))[1] else None,
            peak=StatedPeak(abs(number(peak[1], name, peak[0], "PGA")) * GAL, resolution(peak[1]) * GAL, line=peak[0])
            if peak[1]
            else None,
            processed="NOT REMOVED" not in header.get("BASELINE_CORRECTION", (0, ""))[1].upper(),
            extra={name: value(key) for key, name in _EVENT.items() if header.get(key, (0, ""))[1]},
        )
    ]


def _start(header: dict[str, tuple[int, str]], file: str) -> datetime | None:
    line, text = header.get("DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS", (0, ""))
    if not text:
        return None
    for pattern in ("%Y%m%d_%H%M%S.%f", "%Y%m%d_%H%M%S"):
        try:
            return datetime.strptime(text, pattern).replace(tzinfo=UTC)
        except ValueError:
            continue
    raise RecordError(f"{file} line {line}: first sample at {text!r}; it reads like 20161030_064010.450: correct it")
