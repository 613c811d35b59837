"""PEER AT2: one component per file, in g, with the old and the new header.

Four lines of text (database; earthquake, date, station, component; unit; count and interval), then samples in free
format. The header states no peak; the earthquake's date has no time.
"""

import re
from typing import Final

from overturning.errors import RecordError
from overturning.records.component import Component, parse_axis
from overturning.records.formats.lines import FLOAT, Lines
from overturning.records.source import SourceFile
from overturning.units import STANDARD_GRAVITY

_COUNTS: Final = (
    re.compile(rf"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*({FLOAT})", re.IGNORECASE),
    re.compile(rf"^\s*(\d+)\s+({FLOAT})\s+NPTS\s*,\s*DT", re.IGNORECASE),
)


def detect(source: SourceFile) -> bool:
    """Whether a file begins like a PEER time series."""
    return b"PEER" in source.data[:100].upper() and b"DATABASE" in source.data[:120].upper()


def read(source: SourceFile) -> list[Component]:
    """Read one component; a RecordError where it is no acceleration in g, or the header promises other samples."""
    lines = source.lines
    text = Lines.of(source)
    if len(lines) < 5:
        raise text.error(len(lines) - 1, "the file ends in the header; get it again")
    if not re.search(r"ACCELERATION.*UNITS OF G\b", lines[2], re.IGNORECASE):
        raise text.error(2, f"{lines[2].strip()[:60]!r}; only acceleration in units of g is read: get the .AT2 file")
    match = next((m for pattern in _COUNTS if (m := pattern.search(lines[3]))), None)
    if match is None:
        raise text.error(3, f"{lines[3].strip()[:60]!r} states no NPTS and DT; correct it")
    count, interval = int(match[1]), text.number(match[2], 3, "DT")
    samples = text.column(4)
    text.check_last_number(source.text[-200:])
    if samples.size != count:
        raise RecordError(
            f"{source.name}: {samples.size} samples, line 4 promises {count}; the file is cut or joined: get it again"
        )
    parts = [p.strip() for p in lines[1].split(",")]
    axis = re.sub(r"\(.*\)", "", parts[-1]).strip()
    event, station = _names(parts)
    corners = re.search(rf"HP=\s*({FLOAT})\s*Hz\s+LP=\s*({FLOAT})\s*Hz", lines[2], re.IGNORECASE)
    filtered = {"agency_processing": f"band-pass filter {corners[1]} to {corners[2]} Hz"} if corners else {}
    more = {"station": station, "event": event, "processed": True, "extra": filtered}
    return [Component.of(source, axis, parse_axis(axis), samples * STANDARD_GRAVITY, interval, **more)]


def _names(parts: list[str]) -> tuple[str, str]:
    """Earthquake with date, and station: ``Name, 1/17/1994, Station, 228`` or ``NAME 01/17/94 12:31, STATION, 228``."""
    if len(parts) >= 4 and re.fullmatch(r"\d+/\d+/\d+", parts[1]):
        return f"{parts[0]} {parts[1]}", ", ".join(parts[2:-1])
    return parts[0], ", ".join(parts[1:-1])
