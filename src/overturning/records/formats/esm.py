"""ESM / ITACA / DYNA ASCII: one component per file, cm/s²; 64 lines ``KEY: value``, then one sample per line."""

import re
from datetime import UTC, datetime
from typing import Final

from overturning.errors import RecordError
from overturning.records.component import Component, channel_axis, sensor_at
from overturning.records.formats.lines import Lines, stated_time
from overturning.records.source import SourceFile
from overturning.units import GAL

_KNOWN: Final = {
    "STATION_LATITUDE_DEGREE": "latitude",
    "STATION_LONGITUDE_DEGREE": "longitude",
    "MAGNITUDE_W": "magnitude",
    "VS30_M/S": "vs30",
    "EVENT_LATITUDE_DEGREE": "event_latitude",
    "EVENT_LONGITUDE_DEGREE": "event_longitude",
}

_LINE: Final = re.compile(r"([A-Z][A-Z0-9_/^]*):\s?(.*)")


def detect(source: SourceFile) -> bool:
    """Whether a file begins like DYNA."""
    return source.data[:12].lstrip(b"\xef\xbb\xbf").startswith((b"EVENT_NAME:", b"EVENT_ID:"))


def read(source: SourceFile) -> list[Component]:
    """Read one component; a RecordError where a key is missing, the count is wrong, or the unit is not cm/s²."""
    lines = Lines.of(source)
    header: dict[str, tuple[int, str]] = {}
    first = 0
    for first, line in enumerate(source.lines):
        match = _LINE.fullmatch(line.rstrip())
        if match is None:
            break
        header[match[1]] = (first, match[2].strip())

    def text(key: str) -> str:
        return header.get(key, (0, ""))[1]

    def at(key: str) -> int:
        if key not in header:
            raise RecordError(f"{source.name}: no header line {key}; get the file again")
        return header[key][0]

    def value(key: str) -> float:
        return lines.number(text(key), at(key), key)

    units_at, _ = at("UNITS"), at("STREAM")
    if text("UNITS").replace(" ", "").lower() not in ("cm/s^2", "cm/s2"):
        raise lines.error(units_at, f"unit {text('UNITS')!r}; only cm/s^2 is read: get acceleration")
    # Raw files write it small, or say that it is unprocessed.
    if text("DATA_TYPE").upper().removeprefix("UNPROCESSED ") != "ACCELERATION" and "DATA_TYPE" in header:
        raise lines.error(at("DATA_TYPE"), f"{text('DATA_TYPE')}; only ACCELERATION is read: get that file")
    samples = lines.column(first)
    lines.check_last_number(source.text[-200:])
    if samples.size != int(value("NDATA")):
        raise lines.error(
            at("NDATA"),
            f"header promises {text('NDATA')} samples, the file has {samples.size}; it is cut: get it again",
        )
    known: dict[str, float | str] = {name: value(key) for key, name in _KNOWN.items() if text(key)}
    corners = [text(f"{end}_CUT_FREQUENCY_HZ") for end in ("LOW", "HIGH")]
    if all(corners):
        known["agency_processing"] = f"{text('FILTER_TYPE').lower() or 'filter'} {corners[0]} to {corners[1]} Hz"
    stated = text("PGA_CM/S^2")
    return [
        Component.of(
            source,
            text("STREAM"),
            channel_axis(text("STREAM")),
            samples * GAL,
            value("SAMPLING_INTERVAL_S"),
            start=_start(lines, *header.get("DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS", (0, ""))),
            station=text("STATION_CODE"),
            event=text("EVENT_NAME") or text("EVENT_ID"),
            origin=stated_time(f"{text('EVENT_DATE_YYYYMMDD')} {text('EVENT_TIME_HHMMSS')[:6]}", "%Y%m%d %H%M%S"),
            latitude=known.pop("latitude", None),
            longitude=known.pop("longitude", None),
            peak=lines.peak(stated, at("PGA_CM/S^2"), "PGA", GAL) if stated else None,
            sensor=sensor_at(value("SENSOR_DEPTH_M") if text("SENSOR_DEPTH_M") else None),
            processed=not (
                "NOT REMOVED" in text("BASELINE_CORRECTION").upper()
                or text("PROCESSING").lower() == "none"
                or text("DATA_TYPE").upper().startswith("UNPROCESSED")
            ),
            extra=known,
        )
    ]


def _start(lines: Lines, index: int, text: str) -> datetime | None:
    if not text:
        return None
    for pattern in ("%Y%m%d_%H%M%S.%f", "%Y%m%d_%H%M%S"):
        try:
            return datetime.strptime(text, pattern).replace(tzinfo=UTC)
        except ValueError:
            continue
    raise lines.error(index, f"first sample at {text!r}; it reads like 20161030_064010.450: correct it")
