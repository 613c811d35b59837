"""CSMIP / CGS volume 1 and volume 2, and RAW, which has volume 1's layout: all channels in one file.

The format: Shakal & Huang (1985), CSMIP report OSMS 85-03. Per channel 13 lines of text (25 in volume 2), 100 integers (16I5),
50 or 100 reals (8F10), a line that says how many samples follow, at which rate, in which unit and format; the samples; in
volume 2 velocity and displacement, which are not read; a line that ends the channel. Old volume-1 files hold pairs of time
and acceleration instead (10F7, g/10).
"""

import re
from datetime import UTC, datetime, timedelta
from typing import Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.axes import parse_axis
from overturning.records.component import Component, StatedPeak
from overturning.records.formats.numbers import FLOAT, fixed_columns, fixed_integers, number, resolution
from overturning.records.source import SourceFile
from overturning.units import GAL, STANDARD_GRAVITY

NAME: Final = "csmip"

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
    """Read all channels.

    Raises
    ------
    RecordError
        If a channel is cut, its unit or rate is missing or contradictory, or its samples are not evenly spaced.
    """
    lines = source.lines
    if lines[0].upper().lstrip().startswith("RESPONSE"):
        raise RecordError(f"{source.name} line 1: response spectra (volume 3); get volume 1 or 2")
    volume = 2 if lines[0].upper().lstrip().startswith("CORRECTED") else 1
    components = []
    at = 0
    while True:
        while at < len(lines) and not lines[at].strip():
            at += 1
        if at >= len(lines):
            break
        end = next((i for i in range(at, len(lines)) if _END.match(lines[i])), None)
        if end is None:
            raise RecordError(
                f"{source.name} line {len(lines)}: the file ends without the end mark of a channel; get it again"
            )
        components.append(_channel(source, lines[at:end], at, volume))
        at = end + 1
    return components


def _channel(source: SourceFile, block: list[str], at: int, volume: int) -> Component:
    name = source.name
    text_lines = 13 if volume == 1 else 25
    if len(block) < text_lines + 14:
        raise RecordError(f"{name} line {at + len(block)}: the channel ends in its header; get the file again")
    if not re.match(r"\s*(UN)?CORRECTED", block[0], re.IGNORECASE):
        raise RecordError(f"{name} line {at + 1}: {block[0][:40]!r} where the next channel should begin; get it again")
    text = block[:text_lines]
    channel = _find(text, r"^\s*(?:.*\s)?CHAN\s*(\d+):\s*([^\s,]+)", name, at, "no line CHAN with the axis")
    axis = channel[0][2]
    azimuth, vertical = parse_axis(axis)
    whole = fixed_integers(
        block[text_lines : text_lines + 7], name, at + text_lines + 1, width=5, per_line=16, count=100
    )
    if azimuth is not None and 0 < whole[26] <= 360 and abs((whole[26] - azimuth + 180) % 360 - 180) > 1:
        raise RecordError(
            f"{name} line {at + channel[1] + 1}: axis {axis} in the text, {whole[26]:g} in the numbers below; components may be "
            "swapped: find out which, and give azimuths_deg"
        )
    data_at = next((i for i in range(text_lines + 7, len(block)) if _DATA_LINE.match(block[i])), None)
    if data_at is None:
        samples, interval = _pairs(block, text, text_lines, name, at)
    else:
        samples, interval = _evenly(block, data_at, _unit(block[data_at], text, volume), name, at)
    place = _find(text, rf"({FLOAT})\s*([NS]),?\s*({FLOAT})\s*([EW])", name, at, None)
    latitude = longitude = None
    if place:
        latitude = float(place[0][1]) * (1 if place[0][2].upper() == "N" else -1)
        longitude = float(place[0][3]) * (1 if place[0][4].upper() == "E" else -1)
    station = _find(text, r"STATION\s+(?:ID\.?|NO\.?)\s*(\S+)", name, at, None)
    return Component(
        samples=samples,
        sampling_interval=interval,
        axis=f"chan {channel[0][1]}: {axis}",
        azimuth_deg=azimuth,
        vertical=vertical,
        file=name,
        sha256=source.sha256,
        format=NAME,
        start=_start(text, name, at),
        station=station[0][1] if station else "",
        event=_event(text),
        latitude=latitude,
        longitude=longitude,
        peak=_peak(text, volume, name, at),
        processed=volume == 2,
    )


def _find(text: list[str], pattern: str, name: str, at: int, missing: str | None) -> tuple[re.Match[str], int]:
    for index, line in enumerate(text):
        if match := re.search(pattern, line, re.IGNORECASE):
            return match, index
    if missing is None:
        return ()  # type: ignore[return-value]
    raise RecordError(f"{name} line {at + 1}: {missing} in the channel's header; get the file again")


def _unit(line: str, text: list[str], volume: int) -> str:
    """Unit in the data line; where old files leave it out, that of the stated peak; empty where neither says it."""
    if match := _UNIT.search(line):
        return match[1].lower()
    peak = _find(text, _PEAK[volume], "", 0, None)
    return peak[0][2].lower() if peak else ""


def _evenly(block: list[str], data_at: int, unit: str, name: str, at: int) -> tuple[np.ndarray, float]:
    line = block[data_at]
    where = f"{name} line {at + data_at + 1}"
    count = int(_DATA_LINE.match(line)[1])  # type: ignore[index]
    by_rate = re.search(rf"at\s+({FLOAT})\s*(?:pts|points|samples)\s*/\s*sec", line, re.IGNORECASE)
    by_interval = re.search(rf"at\s+(?:equal\S*\s+)?({FLOAT})\s*sec", line, re.IGNORECASE)
    if by_rate:
        interval = 1.0 / (number(by_rate[1], name, at + data_at + 1, "rate") or float("nan"))
    elif by_interval:
        interval = number(by_interval[1], name, at + data_at + 1, "interval")
    else:
        raise RecordError(f"{where}: no rate or interval in {line.strip()!r}; get the file again")
    if unit not in _UNITS:
        raise RecordError(f"{where}: unit {unit or 'missing'!r}; known are {', '.join(_UNITS)}")
    form = re.search(r"\((\d+)[FE](\d+)\.\d+\)", line, re.IGNORECASE)
    per_line, width = (int(form[1]), int(form[2])) if form else (8, 10)
    first = data_at + 1
    samples = fixed_columns(block[first:], name, at + first + 1, width=width, per_line=per_line, count=count)
    stated = _find(block[:data_at], rf"NO\.? OF POINTS\s*=\s*(\d+).*RECORD LENGTH\s*=\s*({FLOAT})", name, at, None)
    if stated:
        points, length = int(stated[0][1]), float(stated[0][2])
        if points != count or abs(points * interval - length) > max(2 * interval, 0.011):
            raise RecordError(
                f"{name} line {at + stated[1] + 1}: {points} points in {length:g} s, but line {at + data_at + 1} says {count} "
                f"points every {interval:g} s; get the file again"
            )
    after = first + -(-count // per_line)
    if after < len(block) and block[after].strip() and not re.search(r"[A-Za-z]{4}", block[after]):
        raise RecordError(
            f"{name} line {at + after + 1}: samples after the last of {count}; the header's count is wrong"
        )
    return samples * _UNITS[unit], interval


def _pairs(block: list[str], text: list[str], text_lines: int, name: str, at: int) -> tuple[np.ndarray, float]:
    """Old volume 1: time and acceleration in turn, ten columns of seven."""
    stated = _find(text, r"NO\.? OF POINTS\s*=\s*(\d+)", name, at, "no line NO. OF POINTS")
    unit = _find(text, r"UNITS OF .*SEC AND (G/10|G|CM/SEC/SEC|CM/SEC2)", name, at, "no line UNITS OF")
    count = int(stated[0][1])
    first = text_lines + 14
    values = fixed_columns(block[first:], name, at + first + 1, width=7, per_line=10, count=2 * count)
    time, samples = values[0::2], values[1::2]
    steps = np.diff(time)
    interval = round(float(time[-1] - time[0]) / max(count - 1, 1), 6)
    if count < 2 or not (steps > 0).all() or np.abs(time - time[0] - interval * np.arange(count)).max() > 0.0011:
        raise RecordError(
            f"{name} line {at + first + 1}: samples are not evenly spaced (digitised film); get volume 2 of the record"
        )
    return samples * _UNITS[unit[0][1].lower()], interval


def _peak(text: list[str], volume: int, name: str, at: int) -> StatedPeak | None:
    found = _find(text, _PEAK[volume], name, at, None)
    if not found:
        return None
    match, index = found
    scale = _UNITS[match[2].lower()]
    return StatedPeak(abs(float(match[1])) * scale, resolution(match[1]) * scale, line=at + index + 1)


def _start(text: list[str], name: str, at: int) -> datetime | None:
    pattern = r"START TIME:\s*(\d+)/\s*(\d+)/\s*(\d+),?\s*(\d+):\s*(\d+):\s*([\d.]+)\s*(UTC|GMT)"
    found = _find(text, pattern, name, at, None)
    if not found:
        return None
    month, day, year, hour, minute = (int(found[0][i]) for i in range(1, 6))
    year += 0 if year > 99 else 1900 if year >= 50 else 2000
    try:
        return datetime(year, month, day, hour, minute, tzinfo=UTC) + timedelta(seconds=float(found[0][6]))
    except ValueError as problem:
        raise RecordError(
            f"{name} line {at + found[1] + 1}: start {found[0][0]!r} ({problem}); correct it"
        ) from problem


def _event(text: list[str]) -> str:
    for line in text[1:12]:
        if match := re.match(r"\s*R(?:e?co?rd) of (.*?)(?:\s{3,}|\(|$)", line, re.IGNORECASE):
            return " ".join(match[1].split())
    return ""
