"""COSMOS volumes 0, 1 and 2 (format 1.20): one or more channels per file, in counts, g or cm/s².

The format: COSMOS Strong Motion Data Format, version 1.20 (2001). Per channel 13 lines of text after the first,
integers, reals and comments, each set introduced by a line that says how many follow and in which FORTRAN format; then
the samples, introduced the same way; a line that ends the channel. Counts of volume 0 become g by the reals 22 (µV per
count), 42 (sensitivity of the sensor, V/g) and 47 (gain).
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from typing import Final

import numpy as np

from overturning.records.component import UNKNOWN, Component, Direction, StatedPeak, channel_axis, parse_axis, sensor_at
from overturning.records.formats.lines import Lines
from overturning.records.source import SourceFile
from overturning.units import GAL, STANDARD_GRAVITY

UNITS: Final = {2: STANDARD_GRAVITY, 4: GAL, 10: GAL, 11: 1e-3 * STANDARD_GRAVITY}
"""COSMOS table 2: g, cm/s², Gal, mg."""
COUNTS: Final = 50
NULL: Final = -999.0

_FIRST: Final = re.compile(r"\s*(Corrected|Uncorrected|Raw) accel.*\(Format v", re.IGNORECASE)
_SET: Final = re.compile(r"\s*(\d+)\s.*Format\s*=\s*\((\d+)([IFE])(\d+)", re.IGNORECASE)
_END: Final = re.compile(r"^\s*(/&|End-of-data|---+\s*End of data)", re.IGNORECASE)


def detect(source: SourceFile) -> bool:
    """Whether a file begins like COSMOS."""
    return bool(_FIRST.match(source.data[:200].decode("latin-1").lstrip("ï»¿")))


def read(source: SourceFile) -> list[Component]:
    """Read all channels; a RecordError names the line where one is cut or its unit is none of acceleration."""
    lines = Lines.of(source)
    components = []
    at = 0
    while at < len(lines.lines):
        if not lines.lines[at].strip():
            at += 1
            continue
        component, at = _channel(source, lines, at)
        components.append(component)
    return components


def _set(lines: Lines, at: int, what: str) -> tuple[dict[str, int], int]:
    """Count, numbers per line and width, and the line after the set, from the line that introduces it."""
    match = _SET.match(lines.lines[at]) if at < len(lines.lines) else None
    if match is None:
        raise lines.error(at, f"no line that introduces the {what}; the file is cut: get it again")
    count, per_line, width = int(match[1]), int(match[2]), int(match[4])
    if not (1 <= per_line <= 100 and 1 <= width <= 100):
        raise lines.error(at, f"format {match[0].strip()!r}; correct it")
    return {"count": count, "per_line": per_line, "width": width}, at + 1 + -(-count // per_line)


def _channel(source: SourceFile, lines: Lines, at: int) -> tuple[Component, int]:
    """The channel that begins at a line, and the line after it."""
    all_lines = lines.lines
    if not _FIRST.match(all_lines[at]):
        raise lines.error(at, f"{all_lines[at][:40]!r} where the next channel should begin; get it again")
    stated_lines = re.search(r"with\s+(\d+)\s+text lines", all_lines[at])
    ints_at = at + (int(stated_lines[1]) if stated_lines else 13)
    text = all_lines[at:ints_at]
    form, reals_at = _set(lines, ints_at, "integers")
    whole = lines.fixed_integers(ints_at + 1, **form)
    form, comments_at = _set(lines, reals_at, "reals")
    real = lines.fixed_columns(reals_at + 1, **form)
    if whole.size < 100 or real.size < 100:
        raise lines.error(ints_at, f"{whole.size} integers and {real.size} reals; 100 each are needed")
    comment = re.match(
        r"\s*(\d+)\s+Comment", all_lines[comments_at] if comments_at < len(all_lines) else "", re.IGNORECASE
    )
    if comment is None:
        raise lines.error(comments_at, "no line that introduces the comments; get the file again")
    data_at = comments_at + 1 + int(comment[1])
    form, end = _set(lines, data_at, "samples")
    unit = _unit(lines, data_at, int(whole[2]))
    scale = _of_a_count(lines, reals_at, real) if unit == COUNTS else UNITS[unit]
    samples = lines.fixed_columns(data_at + 1, **form)
    if end >= len(all_lines) or not _END.match(all_lines[end]):
        raise lines.error(end, f"no end mark after {samples.size} samples; the count is wrong or the file is cut")
    interval = float(real[61]) * 1e-3 if real[61] > 0 else float(real[33])
    if real[62] > 0 and abs(samples.size * interval - real[62]) > max(2 * interval, 0.011):
        raise lines.error(
            data_at,
            f"{samples.size} samples every {interval:g} s, but the header's length is {real[62]:g} s; get it again",
        )
    axis, direction = _axis(lines, at, [*text, *all_lines[comments_at + 1 : data_at]], int(whole[53]))
    known = {index: float(value) for index, value in enumerate(real) if value != NULL}
    origin, places = replace(lines, lines=text).earthquake()
    component = Component.of(
        source,
        axis,
        direction,
        samples * scale,
        interval,
        start=_start(lines, at, whole, float(real[29])),
        station=_word(text, r"Code:\s*(\S+)"),
        event=" ".join(text[1].split()),
        origin=origin,
        latitude=known.get(0),
        longitude=known.get(1),
        sensor=sensor_at(text=lines.lines[at + 8]),
        # The reals have six decimals; the samples as many as their own format: counts are whole.
        peak=StatedPeak(abs(known[63]) * scale, (1.0 if unit == COUNTS else 1e-5) * scale, line=reals_at + 12)
        if 63 in known
        else None,
        processed=text[0].lstrip().upper().startswith("CORRECTED"),
        extra=({"magnitude": known[12]} if 12 in known else {}) | places | _agency(text),
    )
    return component, end + 1


def _agency(text: Sequence[str]) -> dict[str, str]:
    """Who has processed a corrected file, and with which filter."""
    if not text[0].lstrip().upper().startswith("CORRECTED"):
        return {}
    by, when = _word(text, r"Src:\s*(\S.*)"), _word(text, r"^\s*Processed:\s*(\S.*?),?\s+Max")
    corners = _word(text, r"Record filtered\s+(below\s.*?)\s*$")
    return {"processed_by": by or f"the agency of the file ({when})" if by or when else "the agency of the file"} | (
        {"agency_processing": " ".join(f"filtered {corners}".split())} if corners else {}
    )


def _of_a_count(lines: Lines, reals_at: int, real: np.ndarray) -> float:
    """Acceleration of one count, m/s², from the recorder's step and the sensor's sensitivity."""
    microvolts, volts_per_g = float(real[21]), float(real[41])
    gain = 1.0 if real[46] == NULL else float(real[46])
    for number, value, what in ((22, microvolts, "µV per count"), (42, volts_per_g, "V/g"), (47, gain, "gain")):
        if not value > 0:
            said = "is not stated" if value == NULL else f"is {value:g}"
            raise lines.error(reals_at, f"counts, but real {number} ({what}) {said}; get volume 1 or 2")
    return microvolts * 1e-6 / (volts_per_g * gain) * STANDARD_GRAVITY


def _unit(lines: Lines, data_at: int, code: int) -> int:
    """Code of the samples' unit."""
    line = lines.lines[data_at]
    stated = re.search(r"units\s*=\s*([^,(]+)\(\s*(\d+)\s*\)", line, re.IGNORECASE)
    number = int(stated[2]) if stated else code
    known = number in UNITS or number == COUNTS
    if not known or not re.search(r"accel", line, re.IGNORECASE):
        what = stated[1].strip() if stated else code
        raise lines.error(
            data_at,
            f"samples in {what}; only acceleration in g, cm/sec2, gal, mg or counts is read: get volume 0, 1 or 2",
        )
    if stated and (code in UNITS or code == COUNTS) and code != number:
        raise lines.error(data_at, f"unit {number}, but the integers say {code}; get the file again")
    return number


def _axis(lines: Lines, at: int, everything: Sequence[str], code: int) -> tuple[str, Direction]:
    """Axis from the text, checked against the code; from the SEED channel where neither says it."""
    match = re.search(r"Sta Cha\w*\s+\S+?:\s*(.*?)\s*(?:\(|Location|$)", lines.lines[at + 8])
    word = match[1] if match else ""
    direction = parse_axis(word)
    coded = {400: (None, 1), 401: (None, -1)}.get(code, (float(code % 360), 0) if 1 <= code <= 360 else UNKNOWN)
    if direction == UNKNOWN:
        direction = coded
    elif coded != UNKNOWN and coded != direction:
        raise lines.error(
            at + 8,
            f"axis {word!r} in the text, code {code} in the integers; components may be swapped: find out which, and "
            "give azimuths_deg",
        )
    if direction == UNKNOWN and code in (0, -999):
        channel = _word(everything, r"<SCNL>\s*[^.\s]+\.([A-Z0-9]{3})\.")
        direction = channel_axis(channel)
        word = channel or word
    return word or str(code), direction


def _word(lines: Sequence[str], pattern: str) -> str:
    return next((match[1] for line in lines if (match := re.search(pattern, line))), "")


def _start(lines: Lines, at: int, whole: np.ndarray, second: float) -> datetime | None:
    year, _, month, day, hour, minute = (int(whole[i]) for i in range(39, 45))
    if NULL in (year, month, day, hour, minute) or not 0 <= second < 61:
        return None
    return lines.time(at, (year, month, day), hour, minute, round(second, 6))
