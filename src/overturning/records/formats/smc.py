"""USGS SMC: one component per file, cm/s².

The format: Seekins et al. (1992), USGS DDS-7; per file 11 lines of text, 48 integers (8I10), 50 reals (5E15.7), comment lines
that begin with ``|``, then eight samples per line of ten columns each, which touch.
"""

import re
from datetime import UTC, datetime, timedelta
from typing import Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.axes import agree, parse_axis
from overturning.records.component import Component, StatedPeak
from overturning.records.formats.numbers import fixed_columns, fixed_integers
from overturning.records.source import SourceFile
from overturning.units import GAL

NAME: Final = "smc"
KINDS: Final = {"1 UNCORRECTED ACCELEROGRAM": False, "2 CORRECTED ACCELEROGRAM": True}
REFUSED: Final = ("3 VELOCITY", "4 DISPLACEMENT", "5 ", "6 ")
TEXT_LINES: Final = 11
NULL: Final = -32768


def detect(source: SourceFile) -> bool:
    """Whether a file begins like SMC."""
    first = source.data[:100].split(b"\n")[0].decode("latin-1").strip()
    return first in KINDS or bool(re.fullmatch(r"[3-6] [A-Z ]*(VELOCITY|DISPLACEMENT|SPECTR)[A-Z ]*", first))


def read(source: SourceFile) -> list[Component]:
    """Read one component.

    Raises
    ------
    RecordError
        If the file is no accelerogram, is cut, or its header contradicts itself.
    """
    name, lines = source.name, source.lines
    kind = lines[0].strip()
    if kind not in KINDS:
        raise RecordError(f"{name} line 1: {kind!r}; only accelerograms are read (kinds 1 and 2): get that file")
    if len(lines) < TEXT_LINES + 16:
        raise RecordError(f"{name} line {len(lines)}: the file ends in the header; get it again")
    whole = fixed_integers(lines[11:17], name, 12, width=10, per_line=8, count=48)
    real = fixed_columns(lines[17:27], name, 18, width=15, per_line=5, count=50)
    null = real[0]
    comments, count = int(whole[15]), int(whole[16])
    if count < 2 or not 0 <= comments <= 10_000:
        raise RecordError(f"{name} line 14: {count} samples and {comments} comment lines; correct the header")
    if not 1.0 <= real[1] <= 100_000.0:
        raise RecordError(
            f"{name} line 18: {real[1]:g} samples per second; unevenly sampled or senseless: use the corrected file"
        )
    first = TEXT_LINES + 16 + comments
    for index in range(27, min(first, len(lines))):
        if not lines[index].startswith("|"):
            raise RecordError(f"{name} line {index + 1}: a comment should begin with |; get the file again")
    samples = fixed_columns(lines[first:], name, first + 1, width=10, per_line=8, count=count)
    rest = [line for line in lines[first + -(-count // 8) :] if line.strip()]
    if rest:
        raise RecordError(f"{name}: {len(rest)} lines after the last of {count} samples; the header's count is wrong")
    word = re.search(r"component=\s*(\S+)", lines[5])
    axis = word[1] if word else str(whole[13])
    azimuth, vertical = parse_axis(axis)
    if whole[12] == 90 and not vertical and whole[13] != NULL:
        agree(name, 6, axis, azimuth, float(whole[13]))
        azimuth = float(whole[13]) % 360.0
    elif whole[12] in (0, 180):
        vertical = 1 if whole[12] == 0 else -1
        azimuth = None
    peaks = [abs(float(real[i])) for i in (29, 31) if real[i] != null]
    return [
        Component(
            samples=samples * GAL,
            sampling_interval=1.0 / float(real[1]),
            axis=axis,
            azimuth_deg=azimuth,
            vertical=vertical,
            file=name,
            sha256=source.sha256,
            format=NAME,
            start=_start(whole, name),
            station=_station(lines[5]) or lines[2].strip(),
            event=re.sub(r"^\s*\d+\s+\d+\s+\d+\s+\d*\s*", "", lines[3]).strip(),
            latitude=float(real[10]) if real[10] != null else None,
            longitude=float(real[11]) if real[11] != null else None,
            # Seven digits in the header, five in the data: half a unit of the data's last digit is what may differ.
            peak=StatedPeak(max(peaks) * GAL, 1e-4 * max(peaks) * GAL, line=23) if peaks else None,
            processed=KINDS[kind],
            extra={"magnitude": float(real[5])} if real[5] != null else {},
        )
    ]


def _station(line: str) -> str:
    match = re.search(r"station\s*=\s*(.*?)\s*component=", line)
    return match[1].rstrip(" ,") if match else ""


def _start(whole: np.ndarray, file: str) -> datetime | None:
    """Year, day of the year, hour, minute, second, millisecond; None where the header does not know them."""
    year, day, hour, minute, second, millis = (int(n) for n in whole[1:7])
    if NULL in (year, day, hour, minute) or year == 0:
        return None
    if not (1 <= day <= 366 and 0 <= hour < 24 and 0 <= minute < 60 and 1880 <= year <= 2200):
        raise RecordError(f"{file} line 12: start {year}, day {day}, {hour}:{minute}; correct the header")
    moment = datetime(year, 1, 1, hour, minute, tzinfo=UTC) + timedelta(days=day - 1)
    if second != NULL:
        moment += timedelta(seconds=second)
    if millis != NULL:
        moment += timedelta(milliseconds=millis)
    return moment
