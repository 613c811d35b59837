"""GeoNet (GNS Science, New Zealand) V1A and V2A: three components in one file, mm/s².

The format: Cousins (2008), "GNS accelerogram data files, standard format". Per component 16 lines of text, 4 lines of ten
integers (10I8), 6 lines of ten reals (10F8), then ten samples per line of eight columns each; corrected files go on with
velocity and displacement, which are not read.
"""

import re
from datetime import UTC, datetime, timedelta
from typing import Final

from overturning.errors import RecordError
from overturning.records.axes import agree, parse_axis
from overturning.records.component import Component, StatedPeak
from overturning.records.formats.numbers import FLOAT, fixed_columns, fixed_integers, number, resolution
from overturning.records.source import SourceFile

NAME: Final = "geonet"
MM: Final = 1e-3
TEXT_LINES: Final = 16
HEADER_LINES: Final = 26

_PLACE = r"(\d+) (\d+) (\d+)([NS])\s+(\d+) (\d+) (\d+)([EW])"
"""Degrees, minutes and seconds of a latitude and a longitude."""


def detect(source: SourceFile) -> bool:
    """Whether a file begins like a GeoNet accelerogram."""
    head = source.data[:400].decode("latin-1")
    return bool(re.match(r"(Unc|C)orrected accelerogram \S+ ", head)) and "\nSite " in head


def read(source: SourceFile) -> list[Component]:
    """Read all components of a file.

    Raises
    ------
    RecordError
        If a block is cut, its counts or intervals contradict each other, or an axis is not what its numbers say.
    """
    lines = source.lines
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    components = []
    at = 0
    while at < len(lines):
        component, at = _block(source, lines, at)
        components.append(component)
    return components


def _block(source: SourceFile, lines: list[str], at: int) -> tuple[Component, int]:
    name = source.name
    corrected = lines[at].startswith("Corrected")
    if not corrected and not lines[at].startswith("Uncorrected"):
        raise RecordError(
            f"{name} line {at + 1}: {lines[at][:40]!r} where the next component should begin; get it again"
        )
    if len(lines) < at + HEADER_LINES:
        raise RecordError(f"{name} line {len(lines)}: the file ends in the header of a component; get it again")
    text = lines[at : at + TEXT_LINES]
    whole = fixed_integers(lines[at + 16 : at + 20], name, at + 17, width=8, per_line=10, count=40)
    real = fixed_columns(lines[at + 20 : at + 26], name, at + 21, width=8, per_line=10, count=60)
    count = int(whole[33])
    stated = _search(text, 9, r"Number of points\s+(\d+)", name, at)
    if count != int(stated) or count < 2:
        raise RecordError(f"{name} line {at + 10}: {stated} points, but the numbers below say {count}; get it again")
    interval = number(
        _search(text, 10, rf"at\s+(?:intervals of\s+)?({FLOAT})\s*s", name, at), name, at + 11, "interval"
    )
    if abs(interval - real[25]) > 5e-4:
        raise RecordError(
            f"{name} line {at + 11}: interval {interval} s, but the numbers below say {real[25]}; get it again"
        )
    scale = MM
    if not corrected:
        unit = _search(text, 10, rf"units of\s+({FLOAT})\s*mm/s/s", name, at)
        scale *= number(unit, name, at + 11, "unit")
    elif "mm/s/s" not in text[13]:
        raise RecordError(f"{name} line {at + 14}: no peak in mm/s/s; other units are not part of this format")
    axis = _search(text, 12, r"Component\s+(\S+)", name, at)
    azimuth, vertical = parse_axis(axis)
    if not vertical:
        agree(name, at + 13, axis, azimuth, float(whole[27]))
    start = at + HEADER_LINES
    samples = fixed_columns(lines[start:], name, start + 1, width=8, per_line=10, count=count)
    peak = _search(text, 13, rf"Acceleration:\s+[Pp]eak\s+({FLOAT})\s*mm/s/s", name, at)
    site = re.match(rf"Site\s+(\S+)\s+{_PLACE}", text[1])
    latitude, longitude = _coordinates(site, 2) if site else (None, None)
    extra: dict[str, float] = {"magnitude": float(real[14])} if real[14] > 0 else {}
    epicentre = re.match(rf"Epicentre\s+{_PLACE}", text[8])
    if epicentre:
        extra["event_latitude"], extra["event_longitude"] = _coordinates(epicentre, 1)
    component = Component(
        samples=samples * scale,
        sampling_interval=float(interval),
        axis=axis,
        azimuth_deg=azimuth,
        vertical=vertical,
        file=name,
        sha256=source.sha256,
        format=NAME,
        # Corrected files have samples prepended (5 s as a rule) before the start of the buffer.
        start=_start(whole, name, at) - timedelta(seconds=float(whole[31]) * interval),
        station=site[1] if site else "",
        event=" ".join(text[6].split()),
        latitude=latitude,
        longitude=longitude,
        peak=StatedPeak(abs(number(peak, name, at + 14, "peak")) * MM, resolution(peak) * MM, line=at + 14),
        processed=corrected,
        extra=extra,
    )
    skipped = [count, *(int(n) for n in whole[34:36])] if corrected else [count]
    end = start + sum(-(-n // 10) for n in skipped)
    if end > len(lines):
        raise RecordError(f"{name} line {len(lines)}: the file ends in the data of {axis}; get it again")
    return component, end


def _search(text: list[str], index: int, pattern: str, file: str, at: int) -> str:
    match = re.search(pattern, text[index])
    if match is None:
        raise RecordError(f"{file} line {at + index + 1}: {text[index].strip()[:60]!r} is not what the format has here")
    return match[1]


def _coordinates(place: re.Match[str], group: int) -> tuple[float, float]:
    """Latitude and longitude, degrees, of a match whose eight groups of the place begin at ``group``."""

    def angle(first: int, negative: str) -> float:
        degrees = int(place[first]) + int(place[first + 1]) / 60 + int(place[first + 2]) / 3600
        return round(-degrees if place[first + 3] == negative else degrees, 5)

    return angle(group, "S"), angle(group + 4, "W")


def _start(whole: object, file: str, at: int) -> datetime:
    """Buffer start: year, month, day, hour, minute, milliseconds of the second, UT."""
    year, month, day, hour, minute, millis = (int(whole[i]) for i in (8, 9, 18, 19, 38, 39))  # type: ignore[index]
    try:
        return datetime(year, month, day, hour, minute, tzinfo=UTC) + timedelta(milliseconds=millis)
    except ValueError as problem:
        raise RecordError(f"{file} line {at + 17}: start {year}-{month}-{day} {hour}:{minute} ({problem})") from problem
