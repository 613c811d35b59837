"""CSMIP / CGS volume 1 and volume 2, and RAW, which has volume 1's layout: all channels in one file.

The format: Shakal & Huang (1985), CSMIP report OSMS 85-03. Per channel 13 lines of text (25 in volume 2), 100 integers
(16I5), 50 or 100 reals (8F10), a line that says how many samples follow, at which rate, in which unit and format; the
samples; in volume 2 velocity and displacement, which are not read; a line that ends the channel. Old volume-1 files
hold pairs of time and acceleration instead (10F7, g/10), and so do those of RENADIC (Universidad de Chile), whose L, T
and V say nothing about north and up.
"""

import re
from dataclasses import replace
from datetime import datetime
from typing import Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.component import Component, StatedPeak, parse_axis, sensor_at
from overturning.records.formats.lines import FLOAT, Lines
from overturning.records.source import SourceFile
from overturning.units import GAL, STANDARD_GRAVITY

_UNITS: Final = {
    "g": STANDARD_GRAVITY,
    "g/10": 0.1 * STANDARD_GRAVITY,
    "cm/sec2": GAL,
    "cm/sec/sec": GAL,
    "cms/sec/sec": GAL,
    "cm/s2": GAL,
    "gal": GAL,
}
_END: Final = re.compile(r"^\s*(/&|-{3,}\s*END OF DATA|END OF DATA)", re.IGNORECASE)
_DATA_LINE: Final = re.compile(r"^\s*(\d+)\s+(?:points of\s+)?accel", re.IGNORECASE)
_UNIT: Final = re.compile(r"\bin\s+(?:units of\s+)?(g/10|\S+?)[.,;]?(?:\s|$|\()", re.IGNORECASE)
_PEAK: Final = {
    1: rf"MAX\s*=\s*({FLOAT})\s*(g\b)",
    2: rf"PEAK ACCELERATION\s*=\s*({FLOAT})\s*(g\b|cms?/sec/sec|cm/sec2|cm/s2|gal)",
}
"""The line that states the peak and its unit, by volume."""


def detect(source: SourceFile) -> bool:
    """Whether a file begins like a CSMIP volume."""
    first = source.data[:200].split(b"\n")[0].decode("latin-1").upper()
    return bool(re.match(r"\s*(UNCORRECTED|CORRECTED|RESPONSE AND FOURIER).*(ACCELEROGRAM|SPECTRA)", first)) and not (
        source.data[:400].find(b"\nSite ") > 0
    )


def read(source: SourceFile) -> list[Component]:
    """Read all channels; a RecordError names the line where one is cut, contradicts itself or is not evenly spaced."""
    lines = source.lines
    if lines[0].upper().lstrip().startswith("RESPONSE"):
        raise RecordError(f"{source.name} line 1: response spectra (volume 3); get volume 1 or 2")
    volume = 2 if lines[0].upper().lstrip().startswith("CORRECTED") else 1
    components = []
    at = 0
    while at < len(lines):
        if not lines[at].strip():
            at += 1
            continue
        end = next((i for i in range(at, len(lines)) if _END.match(lines[i])), None)
        if end is None:
            raise RecordError(
                f"{source.name} line {len(lines)}: the file ends without the end mark of a channel; get it again"
            )
        components.append(_channel(source, Lines(source.name, lines[at:end], at), volume))
        at = end + 1
    return components


def _channel(source: SourceFile, block: Lines, volume: int) -> Component:
    text_lines = 13 if volume == 1 else 25
    if len(block.lines) < text_lines + 14:
        raise block.error(len(block.lines) - 1, "the channel ends in its header; get the file again")
    if not re.match(r"\s*(UN)?CORRECTED", block.lines[0], re.IGNORECASE):
        raise block.error(0, f"{block.lines[0][:40]!r} where the next channel should begin; get it again")
    text = replace(block, lines=block.lines[:text_lines])
    channel, channel_line = _needed(text, r"^\s*(?:.*\s)?CHAN\s*(\d+):\s*([^\s,]+)", "no line CHAN with the axis")
    axis = channel[2]
    azimuth, vertical = parse_axis(axis)
    whole = block.fixed_integers(text_lines, width=5, per_line=16, count=100)
    if azimuth is not None and 0 < whole[26] <= 360 and abs((whole[26] - azimuth + 180) % 360 - 180) > 1:
        raise block.error(
            channel_line,
            f"axis {axis} in the text, {whole[26]:g} in the numbers below; components may be swapped: find out which, "
            "and give azimuths_deg",
        )
    below = range(text_lines + 7, len(block.lines))
    data_at = next((index for index in below if _DATA_LINE.match(block.lines[index])), None)
    if data_at is None:
        samples, interval = _pairs(block, text)
    else:
        samples, interval = _evenly(block, data_at, _unit(block.lines[data_at], text, volume))
    place = text.find(rf"({FLOAT})\s*([NS]),?\s*({FLOAT})\s*([EW])")
    latitude = longitude = None
    if place:
        latitude = float(place[0][1]) * (1 if place[0][2].upper() == "N" else -1)
        longitude = float(place[0][3]) * (1 if place[0][4].upper() == "E" else -1)
    station = text.find(r"STATION\s+(?:ID\.?|NO\.?)\s*(\S+)")
    if renadic := text.find("UNIVERSIDAD DE CHILE - RENADIC"):
        # Its files leave the station's number out, and place stations that it does not know at 0° N, 0° E.
        station = replace(text, lines=text.lines[5:6]).find(r"^\s*(.*\S)")
        latitude, longitude = (None, None) if latitude == 0 and longitude == 0 else (latitude, longitude)
    event = replace(text, lines=text.lines[1:12]).find(r"^\s*R(?:e?co?rd) of (.*?)(?:\s{3,}|\(|$)")
    origin, places = text.earthquake()
    return Component.of(
        source,
        f"chan {channel[1]}: {axis}",
        (azimuth, vertical),
        samples,
        interval,
        start=_trigger(text) if renadic else _start(text),
        station=station[0][1] if station else "",
        event=" ".join(event[0][1].split()) if event else "",
        origin=None if renadic else origin,
        latitude=latitude,
        longitude=longitude,
        sensor=sensor_at(text=block.lines[channel_line]),
        peak=_peak(text, volume),
        processed=volume == 2,
        extra=({} if renadic else places) | (_filter(text) if volume == 2 else {}),
    )


def _filter(text: Lines) -> dict[str, str]:
    """The band-pass filter of volume 2, where the header states its corners."""
    stated = text.find(rf"BAND-?PASS.*?\b({FLOAT})\s+(?:AND|TO|-)\s+({FLOAT})\s*HZ")
    return {"agency_processing": f"band-pass filter {stated[0][1]} to {stated[0][2]} Hz"} if stated else {}


def _needed(text: Lines, pattern: str, missing: str) -> tuple[re.Match[str], int]:
    match = text.find(pattern)
    if match is None:
        raise text.error(0, f"{missing} in the channel's header; get the file again")
    return match


def _unit(line: str, text: Lines, volume: int) -> str:
    """Unit in the data line; where old files leave it out, that of the stated peak; empty where neither says it."""
    if match := _UNIT.search(line):
        return match[1].lower()
    peak = text.find(_PEAK[volume])
    return peak[0][2].lower() if peak else ""


def _evenly(block: Lines, data_at: int, unit: str) -> tuple[np.ndarray, float]:
    line = block.lines[data_at]
    count = int(_DATA_LINE.match(line)[1])  # type: ignore[index]
    interval = _interval(block, data_at)
    if unit not in _UNITS:
        raise block.error(data_at, f"unit {unit or 'missing'!r}; known are {', '.join(_UNITS)}")
    form = re.search(r"\((\d+)[FE](\d+)\.\d+\)", line, re.IGNORECASE)
    per_line, width = (int(form[1]), int(form[2])) if form else (8, 10)
    samples = block.fixed_columns(data_at + 1, width=width, per_line=per_line, count=count)
    stated = block.find(rf"NO\.? OF POINTS\s*=\s*(\d+).*RECORD LENGTH\s*=\s*({FLOAT})", data_at)
    if stated:
        points, length = int(stated[0][1]), float(stated[0][2])
        if points != count or abs(points * interval - length) > max(2 * interval, 0.011):
            raise block.error(
                stated[1],
                f"{points} points in {length:g} s, but line {block.before + data_at + 1} says {count} points every "
                f"{interval:g} s; get the file again",
            )
    after = data_at + 1 + -(-count // per_line)
    rest = block.lines[after] if after < len(block.lines) else ""
    if rest.strip() and not re.search(r"[A-Za-z]{4}", rest):
        raise block.error(after, f"samples after the last of {count}; the header's count is wrong")
    return samples * _UNITS[unit], interval


def _interval(block: Lines, data_at: int) -> float:
    """Sampling interval in the line that introduces the samples, s."""
    line = block.lines[data_at]
    if by_rate := re.search(rf"at\s+({FLOAT})\s*(?:pts|points|samples)\s*/\s*sec", line, re.IGNORECASE):
        return 1.0 / (block.number(by_rate[1], data_at, "rate") or float("nan"))
    if by_interval := re.search(rf"at\s+(?:equal\S*\s+)?({FLOAT})\s*sec", line, re.IGNORECASE):
        return block.number(by_interval[1], data_at, "interval")
    raise block.error(data_at, f"no rate or interval in {line.strip()!r}; get the file again")


def _pairs(block: Lines, text: Lines) -> tuple[np.ndarray, float]:
    """Old volume 1: time and acceleration in turn, ten columns of seven."""
    stated, _ = _needed(text, r"NO\.? OF POINTS\s*=\s*(\d+)", "no line NO. OF POINTS")
    unit, _ = _needed(
        text, r"UNITS OF .*SEC AND (G/10|G|CM/SEC/SEC|CM/SEC2)(?=[.,;\s]|$)", "no unit in a line UNITS OF"
    )
    count = int(stated[1])
    first = len(text.lines) + 14
    values = block.fixed_columns(first, width=7, per_line=10, count=2 * count)
    after = first + -(-2 * count // 10)
    if any(line.strip() for line in block.lines[after:]):
        raise block.error(after, f"samples after the last of {count}; the header's count is wrong")
    time, samples = values[0::2], values[1::2]
    steps = np.diff(time)
    interval = round(float(time[-1] - time[0]) / max(count - 1, 1), 6)
    if count < 2 or not (steps > 0).all() or np.abs(time - time[0] - interval * np.arange(count)).max() > 0.0011:
        raise block.error(first, "samples are not evenly spaced (digitised film); get volume 2 of the record")
    return samples * _UNITS[unit[1].lower()], interval


def _peak(text: Lines, volume: int) -> StatedPeak | None:
    stated = text.find(_PEAK[volume])
    if stated is None:
        return None
    match, index = stated
    return text.peak(match[1], index, "the peak", _UNITS[match[2].lower()])


def _trigger(text: Lines) -> datetime | None:
    """RENADIC's trigger time; None where the recorder's clock was never set and says 1980-01-01."""
    stated = text.find(r"TRIGGER TIME:\s*(\d+)/\s*(\d+)/\s*(\d+)\s+(\d+):\s*(\d+):\s*([\d.]+)\s*GMT")
    if stated is None:
        return None
    match, index = stated
    month, day, year, hour, minute = (int(match[i]) for i in range(1, 6))
    if (year, month, day) == (1980, 1, 1):
        return None
    return text.time(index, (year, month, day), hour, minute, text.number(match[6], index, "second"))


def _start(text: Lines) -> datetime | None:
    stated = text.find(r"START TIME:\s*(\d+)/\s*(\d+)/\s*(\d+),?\s*(\d+):\s*(\d+):\s*([\d.]+)\s*(UTC|GMT)")
    if stated is None:
        return None
    match, index = stated
    month, day, year, hour, minute = (int(match[i]) for i in range(1, 6))
    year += 0 if year > 99 else 1900 if year >= 50 else 2000
    return text.time(index, (year, month, day), hour, minute, text.number(match[6], index, "second"))
