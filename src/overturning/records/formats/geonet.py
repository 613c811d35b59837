"""GeoNet (GNS Science, New Zealand) V1A and V2A: three components in one file, mm/s².

The format: Cousins (2008), "GNS accelerogram data files, standard format". Per component 16 lines of text, 4 lines of
ten integers (10I8), 6 lines of ten reals (10F8), then ten samples per line of eight columns each; corrected files go on
with velocity and displacement, which are not read.
"""

import re
from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import Any, Final

import numpy as np

from overturning.records.component import Component, StatedPeak, agree, parse_axis
from overturning.records.formats.lines import FLOAT, Lines, stated_time
from overturning.records.source import SourceFile

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
    """Read all components; a RecordError names the line where a block is cut or contradicts itself."""
    lines = list(source.lines)
    while lines and not lines[-1].strip():
        lines.pop()
    components = []
    at = 0
    while at < len(lines):
        component, length = _block(source, Lines(source.name, lines[at:], at))
        components.append(component)
        at += length
    return components


def _block(source: SourceFile, block: Lines) -> tuple[Component, int]:
    """The component that begins with these lines, and how many lines it takes."""
    text = block.lines
    corrected = text[0].startswith("Corrected")
    if not corrected and not text[0].startswith("Uncorrected"):
        raise block.error(0, f"{text[0][:40]!r} where the next component should begin; get it again")
    if len(text) < HEADER_LINES:
        raise block.error(len(text) - 1, "the file ends in the header of a component; get it again")
    whole = block.fixed_integers(16, width=8, per_line=10, count=40)
    real = block.fixed_columns(20, width=8, per_line=10, count=60)
    count = int(whole[33])
    stated = _search(block, 9, r"Number of points\s+(\d+)")
    if count != int(stated) or count < 2:
        raise block.error(9, f"{stated} points, but the numbers below say {count}; get it again")
    interval = block.number(_search(block, 10, rf"at\s+(?:intervals of\s+)?({FLOAT})\s*s"), 10, "interval")
    if abs(interval - real[25]) > 5e-4:
        raise block.error(10, f"interval {interval} s, but the numbers below say {real[25]}; get it again")
    scale = MM
    if not corrected:
        scale *= block.number(_search(block, 10, rf"units of\s+({FLOAT})\s*mm/s/s"), 10, "unit")
    elif "mm/s/s" not in text[13]:
        raise block.error(13, "no peak in mm/s/s; other units are not part of this format")
    axis = _search(block, 12, r"Component\s+(\S+)")
    azimuth, vertical = parse_axis(axis)
    if not vertical:
        agree(block.file, block.before + 13, axis, azimuth, float(whole[27]))
    samples = block.fixed_columns(HEADER_LINES, width=8, per_line=10, count=count)
    skipped = [count, *(int(n) for n in whole[34:36])] if corrected else [count]
    end = HEADER_LINES + sum(-(-n // 10) for n in skipped)
    if end > len(text):
        raise block.error(len(text) - 1, f"the file ends in the data of {axis}; get it again")
    component = Component.of(
        source,
        axis,
        (azimuth, vertical),
        samples * scale,
        float(interval),
        # Corrected files have samples prepended (5 s as a rule) before the start of the buffer.
        start=_buffer_start(block, whole) - timedelta(seconds=float(whole[31]) * interval),
        event=_event(text),
        origin=stated_time(" ".join(text[7].split()), "%Y %B %d %H:%M:%S UT"),
        peak=_peak(block),
        processed=corrected,
        **_places(text, _of_the_header(text, real, corrected)),
    )
    return component, end


def _search(block: Lines, index: int, pattern: str) -> str:
    match = re.search(pattern, block.lines[index])
    if match is None:
        raise block.error(index, f"{block.lines[index].strip()[:60]!r} is not what the format has here")
    return match[1]


def _peak(block: Lines) -> StatedPeak:
    peak = _search(block, 13, rf"Acceleration:\s+[Pp]eak\s+({FLOAT})\s*mm/s/s")
    return block.peak(peak, 13, "peak", MM)


def _event(text: Sequence[str]) -> str:
    """The earthquake by its time, and by its place as that of the epicentre, which may be far from the station."""
    when, where = (" ".join(text[line].split()) for line in (7, 6))
    return f"earthquake of {when}" + (f" (epicentre {where})" if where else "")


def _of_the_header(text: Sequence[str], real: np.ndarray, corrected: bool) -> dict[str, Any]:
    """Magnitude, and what the agency's filter was."""
    magnitude = {"magnitude": float(real[14])} if real[14] > 0 else {}
    bands = re.search(r"transition bands are\s+(.*?)\s*$", text[11])
    filtered = {"agency_processing": f"band-pass filter, transition bands {bands[1]}"} if corrected and bands else {}
    return magnitude | filtered


def _places(text: Sequence[str], extra: dict[str, float]) -> dict[str, Any]:
    """Station and its coordinates, and among what else the file states those of the epicentre."""
    places: dict[str, Any] = {"extra": extra}
    if site := re.match(rf"Site\s+(\S+)\s+{_PLACE}", text[1]):
        places["station"] = site[1]
        places["latitude"], places["longitude"] = _coordinates(site, 2)
    if epicentre := re.match(rf"Epicentre\s+{_PLACE}", text[8]):
        extra["event_latitude"], extra["event_longitude"] = _coordinates(epicentre, 1)
    return places


def _coordinates(place: re.Match[str], group: int) -> tuple[float, float]:
    """Latitude and longitude, degrees, of a match whose eight groups of the place begin at ``group``."""

    def angle(first: int, negative: str) -> float:
        degrees = int(place[first]) + int(place[first + 1]) / 60 + int(place[first + 2]) / 3600
        return round(-degrees if place[first + 3] == negative else degrees, 5)

    return angle(group, "S"), angle(group + 4, "W")


def _buffer_start(block: Lines, whole: np.ndarray) -> datetime:
    """Buffer start: year, month, day, hour, minute, milliseconds of the second, UT."""
    year, month, day, hour, minute, millis = (int(whole[i]) for i in (8, 9, 18, 19, 38, 39))
    return block.time(16, (year, month, day), hour, minute, millis / 1000)
