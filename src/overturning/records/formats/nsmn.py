"""NSMN, Türkiye (AFAD's National Strong-Motion Network): three components in one file, Gal.

The format: eighteen lines, of which the first is the title, those in between are ``KEY: text`` in a fixed order, and
the last names the columns, N-S, E-W and U-D; then three samples per line. The files are in the code page of the place,
so names may hold any letters.
"""

import re
from typing import Final

from overturning.errors import RecordError
from overturning.records.component import Component
from overturning.records.formats.lines import FLOAT, Header, Lines, stated_time
from overturning.records.source import SourceFile
from overturning.units import GAL

TITLE: Final = b"STRONG GROUND MOTION RECORDS OF TURK"
_AXES: Final = {"N-S": (0.0, 0), "E-W": (90.0, 0), "U-D": (None, 1)}
HEADER_LINES: Final = 18
_PLACE: Final = rf"({FLOAT})\s*N\s*-\s*({FLOAT})\s*E"


def detect(source: SourceFile) -> bool:
    """Whether a file has NSMN's title."""
    return TITLE in source.data[:200].split(b"\n")[0].upper()


def read(source: SourceFile) -> list[Component]:
    """Read all components; a RecordError names the line where the file is cut or contradicts itself."""
    lines = Lines.of(source)
    names_at = next((i for i, line in enumerate(lines.lines[:40]) if line.split()[:3] == list(_AXES)), None)
    if names_at is None:
        raise lines.error(
            min(len(lines.lines), 40) - 1, "no line that names the columns N-S, E-W and U-D; get the file again"
        )
    if names_at != HEADER_LINES - 1:
        raise lines.error(names_at, f"the columns are named here, not in line {HEADER_LINES}; get the file again")
    header = Header.of(lines, names_at)
    when, count, interval, peaks = (_key(lines, index) for index in (11, 12, 13, 14))
    values = lines.rows(names_at + 1, 3)
    lines.check_last_number(source.text[-200:])
    if values.shape[0] != header.number(count):
        raise header.error(count, f"header promises {header.text(count)} samples, the file has {values.shape[0]}")
    if (unit := re.search(r"\(([^)]*)\)", peaks)) and unit[1].lower() not in ("gal", "cm/s2", "cm/s^2", "cm/s/s"):
        raise header.error(peaks, f"peaks in {unit[1]}; only Gal is read")
    clock = re.match(r"(\d+/\d+/\d+ \d+:\d+:\d+)(\.\d+)?", header.text(when))
    if clock is None:
        raise header.error(when, f"{header.text(when)!r} is no time; correct it")
    start = header.time(when, "%d/%m/%Y %H:%M:%S.%f", clock[1] + (clock[2] or ".0")[:7])
    place, epicentre = (_coordinates(header, _key(lines, index)) for index in (7, 3))
    more = dict(zip(("event_latitude", "event_longitude"), epicentre, strict=True)) if None not in epicentre else {}
    components = []
    for column, (axis, direction) in enumerate(_AXES.items()):
        stated = re.search(rf"{axis}[\s):=]*({FLOAT})", header.text(peaks))
        if stated is None:
            raise header.error(peaks, f"no peak of {axis}; get the file again")
        components.append(
            Component.of(
                source,
                axis,
                direction,
                values[:, column] * GAL,
                header.number(interval),
                start=start,
                station=header.text(_key(lines, 6)),
                event=f"earthquake of {header.text(_key(lines, 2))}",
                origin=stated_time(header.text(_key(lines, 2)).partition(".")[0], "%d/%m/%Y %H:%M:%S"),
                latitude=place[0],
                longitude=place[1],
                peak=lines.peak(stated[1], header.at(peaks), "the peak", GAL),
                extra=more,
            )
        )
    return components


def _key(lines: Lines, index: int) -> str:
    """Key of a header line; a RecordError where the line is none."""
    key, colon, _ = lines.lines[index].partition(":")
    if not colon:
        raise lines.error(index, f"{lines.lines[index].strip()[:40]!r} where KEY: text belongs; get the file again")
    return " ".join(key.split())


def _coordinates(header: Header, key: str) -> tuple[float | None, float | None]:
    """Latitude and longitude, degrees; None where the header leaves them blank."""
    said = header.text(key)
    if not said:
        return None, None
    found = re.search(_PLACE, said)
    if found is None:
        raise RecordError(f"{header.lines.file} line {header.at(key) + 1}: place {said!r}; it reads like 40.84N-31.15E")
    return float(found[1]), float(found[2])
