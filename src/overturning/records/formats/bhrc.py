"""BHRC, Iran (Building and Housing Research Center's ISMN), volume 1: components one after the other in one file, g/10.

The format: per component 13 lines of text, 7 of integers (5 columns each), 7 of reals (13 columns each), of which the
sixth is the rate, ten samples per line (10E13.6), and a line ``/&``. The azimuths of L and T stand in the station's
line; whether V is up is said nowhere. The header states no peak, and no time of the first sample.
"""

import re
from typing import Final

from overturning.records.component import UNKNOWN, Component, Direction
from overturning.records.formats.lines import FLOAT, Lines
from overturning.records.source import SourceFile
from overturning.units import STANDARD_GRAVITY

TEXT_LINES: Final = 13
HEADER_LINES: Final = 27
_STATION: Final = rf"^(.*?)\s*Station\s+({FLOAT})\s*N\s+({FLOAT})\s*E.*Azimuth\s+L\s+({FLOAT})\s+T\s+({FLOAT})"
_EPICENTRE: Final = rf"Epicenter\s+({FLOAT})\s*N\s+({FLOAT})\s*E"


def detect(source: SourceFile) -> bool:
    """Whether a file begins like BHRC's."""
    return source.data[:20].lstrip(b"\xef\xbb\xbf").startswith(b"* VOL")


def read(source: SourceFile) -> list[Component]:
    """Read all components; a RecordError names the line where one is cut or contradicts itself."""
    components = []
    at = 0
    while at < len(source.lines):
        if not source.lines[at].strip():
            at += 1
            continue
        component, length = _component(source, Lines(source.name, source.lines[at:], at))
        components.append(component)
        at += length
    return components


def _component(source: SourceFile, block: Lines) -> tuple[Component, int]:
    """The component that begins with these lines, and how many lines it takes."""
    text = block.lines
    if not text[0].startswith("* VOL1"):
        raise block.error(0, f"{text[0][:40]!r} where the next component should begin; only volume 1 is read")
    if len(text) < HEADER_LINES:
        raise block.error(len(text) - 1, "the file ends in the header of a component; get it again")
    if not re.match(r"UNITS ARE SECONDS AND G/10\s*$", text[11]):
        raise block.error(11, f"{text[11].strip()!r}; only seconds and g/10 are read")
    stated = re.search(rf"NO\. OF POINTS\s*=\s*(\d+)\s+DURATION\s*=\s*({FLOAT})", text[10])
    if stated is None:
        raise block.error(10, f"{text[10].strip()[:60]!r} states no number of points; get the file again")
    count, duration = int(stated[1]), float(stated[2])
    rate = block.number(text[TEXT_LINES + 8][:13], TEXT_LINES + 8, "the rate")
    if not 1.0 <= rate <= 100_000.0 or abs(count / rate - duration) > max(2.0 / rate, 0.011):
        raise block.error(
            10, f"{count} points in {duration:g} s, but the numbers below say {rate:g} per second; get it again"
        )
    samples = block.fixed_columns(HEADER_LINES, width=13, per_line=10, count=count)
    end = HEADER_LINES + -(-count // 10)
    if end >= len(text) or not text[end].startswith("/&"):
        raise block.error(
            min(end, len(text) - 1), f"no end mark /& after {count} samples; the file is cut: get it again"
        )
    axis, direction, place = _axis(block)
    epicentre = re.search(_EPICENTRE, text[8])
    magnitude = re.search(rf"Mw\s*({FLOAT})", text[8])
    extra = {"magnitude": float(magnitude[1])} if magnitude else {}
    if epicentre:
        extra |= {"event_latitude": float(epicentre[1]), "event_longitude": float(epicentre[2])}
    origin = text[2].partition(":")[2].split()
    component = Component.of(
        source,
        axis,
        direction,
        samples * 0.1 * STANDARD_GRAVITY,
        1.0 / rate,
        station=place[0],
        event=f"earthquake of {' '.join(origin)}" if origin else "",
        latitude=place[1],
        longitude=place[2],
        extra=extra,
    )
    return component, end + 1


def _axis(block: Lines) -> tuple[str, Direction, tuple[str, float, float]]:
    """Name of the axis with its direction, and the station with its place."""
    found = re.search(_STATION, block.lines[7])
    if found is None:
        raise block.error(7, f"{block.lines[7].strip()[:60]!r} is not what the format has here")
    axis = block.lines[4].strip()
    azimuths = {"L": float(found[4]) % 360.0, "T": float(found[5]) % 360.0}
    if axis not in (*azimuths, "V") or not re.match(rf"COMP\s+{axis}", block.lines[6]):
        raise block.error(4, f"component {axis!r} and {block.lines[6].strip()!r}; known are L, V and T")
    direction = (azimuths[axis], 0) if axis in azimuths else UNKNOWN
    return axis, direction, (found[1], float(found[2]), float(found[3]))
