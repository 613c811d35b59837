"""COSMOS volumes 1 and 2 (format 1.20): one or more channels per file, in g or cm/s².

The format: COSMOS Strong Motion Data Format, version 1.20 (2001). Per channel 13 lines of text after the first, integers,
reals and comments, each set introduced by a line that says how many follow and in which FORTRAN format; then the samples,
introduced the same way; a line that ends the channel.
"""

import re
from datetime import UTC, datetime, timedelta
from typing import Final

from overturning.errors import RecordError
from overturning.records.axes import channel_axis, parse_axis
from overturning.records.component import Component, StatedPeak
from overturning.records.formats.numbers import fixed_columns, fixed_integers
from overturning.records.source import SourceFile
from overturning.units import GAL, STANDARD_GRAVITY

NAME: Final = "cosmos"
UNITS: Final = {2: STANDARD_GRAVITY, 4: GAL, 10: GAL, 11: 1e-3 * STANDARD_GRAVITY}
"""COSMOS table 2: g, cm/s², Gal, mg."""
NULL: Final = -999.0

_FIRST: Final = re.compile(r"\s*(Corrected|Uncorrected|Raw) accel.*\(Format v", re.IGNORECASE)
_SET: Final = re.compile(r"\s*(\d+)\s.*Format\s*=\s*\((\d+)([IFE])(\d+)", re.IGNORECASE)
_END: Final = re.compile(r"^\s*(/&|End-of-data|---+\s*End of data)", re.IGNORECASE)


def detect(source: SourceFile) -> bool:
    """Whether a file begins like COSMOS."""
    return bool(_FIRST.match(source.data[:200].decode("latin-1").lstrip("ï»¿")))


def read(source: SourceFile) -> list[Component]:
    """Read all channels.

    Raises
    ------
    RecordError
        If a channel is cut or its unit is none of acceleration.
    """
    lines = source.lines
    components = []
    at = 0
    while at < len(lines):
        if not lines[at].strip():
            at += 1
            continue
        component, at = _channel(source, lines, at)
        components.append(component)
    return components


def _set(lines: list[str], at: int, name: str, what: str) -> tuple[int, int, int, int]:
    """Count, numbers per line, width, and the line after the set, from the line that introduces it."""
    match = _SET.match(lines[at]) if at < len(lines) else None
    if match is None:
        raise RecordError(f"{name} line {at + 1}: no line that introduces the {what}; the file is cut: get it again")
    count, per_line, width = int(match[1]), int(match[2]), int(match[4])
    if not (1 <= per_line <= 100 and 1 <= width <= 100):
        raise RecordError(f"{name} line {at + 1}: format {match[0].strip()!r}; correct it")
    return count, per_line, width, at + 1 + -(-count // per_line)


def _channel(source: SourceFile, lines: list[str], at: int) -> tuple[Component, int]:
    name = source.name
    if not _FIRST.match(lines[at]):
        raise RecordError(f"{name} line {at + 1}: {lines[at][:40]!r} where the next channel should begin; get it again")
    stated_lines = re.search(r"with\s+(\d+)\s+text lines", lines[at])
    ints_at = at + (int(stated_lines[1]) if stated_lines else 13)
    text = lines[at:ints_at]
    count, per_line, width, reals_at = _set(lines, ints_at, name, "integers")
    whole = fixed_integers(lines[ints_at + 1 :], name, ints_at + 2, width=width, per_line=per_line, count=count)
    count, per_line, width, comments_at = _set(lines, reals_at, name, "reals")
    real = fixed_columns(lines[reals_at + 1 :], name, reals_at + 2, width=width, per_line=per_line, count=count)
    if whole.size < 100 or real.size < 100:
        raise RecordError(
            f"{name} line {ints_at + 1}: {whole.size} integers and {real.size} reals; 100 each are needed"
        )
    comment = re.match(r"\s*(\d+)\s+Comment", lines[comments_at] if comments_at < len(lines) else "", re.IGNORECASE)
    if comment is None:
        raise RecordError(f"{name} line {comments_at + 1}: no line that introduces the comments; get the file again")
    comments = lines[comments_at + 1 : comments_at + 1 + int(comment[1])]
    data_at = comments_at + 1 + int(comment[1])
    count, per_line, width, end = _set(lines, data_at, name, "samples")
    scale = _unit(lines[data_at], int(whole[1]), name, data_at)
    samples = fixed_columns(lines[data_at + 1 :], name, data_at + 2, width=width, per_line=per_line, count=count)
    if end >= len(lines) or not _END.match(lines[end]):
        raise RecordError(
            f"{name} line {end + 1}: no end mark after {count} samples; the count is wrong or the file is cut"
        )
    interval = float(real[61]) * 1e-3 if real[61] > 0 else float(real[33])
    if real[62] > 0 and abs(count * interval - real[62]) > max(2 * interval, 0.011):
        raise RecordError(
            f"{name} line {data_at + 1}: {count} samples every {interval:g} s, but the header's length is {real[62]:g} s; get it again"
        )
    axis, azimuth, vertical = _axis(text, [*text, *comments], int(whole[53]), name, at)
    return (
        Component(
            samples=samples * scale,
            sampling_interval=interval,
            axis=axis,
            azimuth_deg=azimuth,
            vertical=vertical,
            file=name,
            sha256=source.sha256,
            format=NAME,
            start=_start(whole, real, name, at),
            station=_word(text, r"Code:\s*(\S+)"),
            event=" ".join(text[1].split()),
            latitude=float(real[0]) if real[0] != NULL else None,
            longitude=float(real[1]) if real[1] != NULL else None,
            # The reals have six decimals; the samples as many as their own format.
            peak=StatedPeak(abs(float(real[63])) * scale, 1e-5 * scale, line=reals_at + 12)
            if real[63] != NULL
            else None,
            processed=text[0].lstrip().upper().startswith("CORRECTED"),
            extra={"magnitude": float(real[12])} if real[12] != NULL else {},
        ),
        end + 1,
    )


def _unit(line: str, code: int, name: str, data_at: int) -> float:
    stated = re.search(r"units\s*=\s*([^,(]+)\(\s*(\d+)\s*\)", line, re.IGNORECASE)
    number = int(stated[2]) if stated else code
    if number not in UNITS or not re.search(r"accel", line, re.IGNORECASE):
        what = stated[1].strip() if stated else code
        raise RecordError(
            f"{name} line {data_at + 1}: samples in {what}; only acceleration in g, cm/sec2, gal or mg is read: get volume 1 or 2"
        )
    if stated and code in UNITS and code != number:
        raise RecordError(f"{name} line {data_at + 1}: unit {number}, but the integers say {code}; get the file again")
    return UNITS[number]


def _axis(text: list[str], everything: list[str], code: int, name: str, at: int) -> tuple[str, float | None, int]:
    """Axis from the text, checked against the code; from the SEED channel where neither says it."""
    match = re.search(r"Sta Cha\w*\s+\S+?:\s*(.*?)\s*(?:\(|Location|$)", text[8])
    word = match[1] if match else ""
    azimuth, vertical = parse_axis(word)
    coded = {400: (None, 1), 401: (None, -1)}.get(code, (float(code % 360), 0) if 1 <= code <= 360 else (None, 0))
    if (azimuth, vertical) == (None, 0):
        azimuth, vertical = coded
    elif coded != (None, 0) and coded != (azimuth, vertical):
        raise RecordError(
            f"{name} line {at + 9}: axis {word!r} in the text, code {code} in the integers; components may be swapped: find out "
            "which, and give azimuths_deg"
        )
    if (azimuth, vertical) == (None, 0) and code in (0, -999):
        channel = _word(everything, r"<SCNL>\s*[^.\s]+\.([A-Z0-9]{3})\.")
        azimuth, vertical = channel_axis(channel)
        word = channel or word
    return word or str(code), azimuth, vertical


def _word(lines: list[str], pattern: str) -> str:
    for line in lines:
        if match := re.search(pattern, line):
            return match[1]
    return ""


def _start(whole: object, real: object, name: str, at: int) -> datetime | None:
    year, _, month, day, hour, minute = (int(whole[i]) for i in range(39, 45))  # type: ignore[index]
    second = float(real[29])  # type: ignore[index]
    if NULL in (year, month, day, hour, minute) or not 0 <= second < 61:
        return None
    try:
        return datetime(year, month, day, hour, minute, tzinfo=UTC) + timedelta(seconds=round(second, 6))
    except ValueError as problem:
        raise RecordError(
            f"{name} line {at + 1}: start {year}-{month}-{day} {hour}:{minute} ({problem}); correct it"
        ) from problem
