"""USGS SMC: one component per file, cm/s².

The format: Seekins et al. (1992), USGS DDS-7; per file 11 lines of text, 48 integers (8I10), 50 reals (5E15.7), comment
lines that begin with ``|``, then eight samples per line of ten columns each, which touch.
"""

import re
from datetime import UTC, datetime, timedelta
from typing import Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.component import Component, Direction, StatedPeak, agree, parse_axis
from overturning.records.formats.lines import Lines
from overturning.records.source import SourceFile
from overturning.units import GAL

KINDS: Final = {"1 UNCORRECTED ACCELEROGRAM": False, "2 CORRECTED ACCELEROGRAM": True}
REFUSED: Final = ("3 VELOCITY", "4 DISPLACEMENT", "5 ", "6 ")
TEXT_LINES: Final = 11
NULL: Final = -32768


def detect(source: SourceFile) -> bool:
    """Whether a file begins like SMC."""
    first = source.data[:100].split(b"\n")[0].decode("latin-1").strip()
    return first in KINDS or bool(re.fullmatch(r"[3-6] [A-Z ]*(VELOCITY|DISPLACEMENT|SPECTR)[A-Z ]*", first))


def read(source: SourceFile) -> list[Component]:
    """Read one component; a RecordError names the line where it is no accelerogram, is cut, or contradicts itself."""
    lines = source.lines
    text = Lines.of(source)
    kind = lines[0].strip()
    if kind not in KINDS:
        raise text.error(0, f"{kind!r}; only accelerograms are read (kinds 1 and 2): get that file")
    if len(lines) < TEXT_LINES + 16:
        raise text.error(len(lines) - 1, "the file ends in the header; get it again")
    whole = text.fixed_integers(11, width=10, per_line=8, count=48)
    real = text.fixed_columns(17, width=15, per_line=5, count=50)
    known = {index: float(value) for index, value in enumerate(real) if value != real[0]}
    peaks = [abs(known[index]) for index in (29, 31) if index in known]
    samples = _samples(text, whole, real)
    axis, direction = _axis(text, whole)
    return [
        Component.of(
            source,
            axis,
            direction,
            samples * GAL,
            1.0 / float(real[1]),
            start=_start(whole, text),
            station=_station(lines[5]) or lines[2].strip(),
            event=re.sub(r"^\s*\d+\s+\d+\s+\d+\s+\d*\s*", "", lines[3]).strip(),
            latitude=known.get(10),
            longitude=known.get(11),
            # Seven digits in the header, five in the data: half a unit of the data's last digit is what may differ.
            peak=StatedPeak(max(peaks) * GAL, 1e-4 * max(peaks) * GAL, line=23) if peaks else None,
            processed=KINDS[kind],
            extra={"magnitude": known[5]} if 5 in known else {},
        )
    ]


def _samples(text: Lines, whole: np.ndarray, real: np.ndarray) -> np.ndarray:
    """The samples, in cm/s², after the comments."""
    comments, count = int(whole[15]), int(whole[16])
    if count < 2 or not 0 <= comments <= 10_000:
        raise text.error(13, f"{count} samples and {comments} comment lines; correct the header")
    if real[1] == real[0]:
        why = f"no sampling rate: {real[1]:.2g} is the format's word for undefined, so samples are not evenly spaced"
        raise text.error(17, f"{why}; use the corrected file")
    if not 1.0 <= real[1] <= 100_000.0:
        raise text.error(17, f"{real[1]:g} samples per second; unevenly sampled or senseless: use the corrected file")
    first = TEXT_LINES + 16 + comments
    for index in range(27, min(first, len(text.lines))):
        if not text.lines[index].startswith("|"):
            raise text.error(index, "a comment should begin with |; get the file again")
    samples = text.fixed_columns(first, width=10, per_line=8, count=count)
    rest = [line for line in text.lines[first + -(-count // 8) :] if line.strip()]
    if rest:
        raise RecordError(
            f"{text.file}: {len(rest)} lines after the last of {count} samples; the header's count is wrong"
        )
    return samples


def _axis(text: Lines, whole: np.ndarray) -> tuple[str, Direction]:
    """Name of the axis, azimuth and vertical sense, from the text and from the numbers, which must agree."""
    word = re.search(r"component=\s*(\S+)", text.lines[5])
    axis = word[1] if word else str(whole[13])
    azimuth, vertical = parse_axis(axis)
    if whole[12] == 90 and not vertical and whole[13] != NULL:
        agree(text.file, 6, axis, azimuth, float(whole[13]))
        return axis, (float(whole[13]) % 360.0, 0)
    if whole[12] in (0, 180):
        return axis, (None, 1 if whole[12] == 0 else -1)
    return axis, (azimuth, vertical)


def _station(line: str) -> str:
    match = re.search(r"station\s*=\s*(.*?)\s*component=", line)
    return match[1].rstrip(" ,") if match else ""


def _start(whole: np.ndarray, text: Lines) -> datetime | None:
    """Year, day of the year, hour, minute, second, millisecond; None where the header does not know them."""
    year, day, hour, minute, second, millis = (int(n) for n in whole[1:7])
    if NULL in (year, day, hour, minute) or year == 0:
        return None
    if not (1 <= day <= 366 and 0 <= hour < 24 and 0 <= minute < 60 and 1880 <= year <= 2200):
        raise text.error(11, f"start {year}, day {day}, {hour}:{minute}; correct the header")
    moment = datetime(year, 1, 1, hour, minute, tzinfo=UTC) + timedelta(days=day - 1)
    if second != NULL:
        moment += timedelta(seconds=second)
    if millis != NULL:
        moment += timedelta(milliseconds=millis)
    return moment
