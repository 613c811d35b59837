"""What the readers of text files share: a header as a table of fields, columns of numbers, and the checks of both.

Everything is read strictly: what is not the number that it should be is an error with file and line.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.records.component import Component, StatedPeak
from overturning.records.source import SourceFile

FLOAT: Final = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?"
_NUMBER: Final = re.compile(rf"\s*({FLOAT})\s*")
_ALLOWED: Final = set("0123456789+-.eE ")

Fields = Mapping[str, str | tuple[int, str]]
"""Where a header states what: a pattern of the line, which is searched for, or the line, from 0, and its pattern.

What is wanted is the pattern's first group. A field with a line must be there; any other only once it is asked for.
"""

EARTHQUAKE: Final[Fields] = {
    "origin": r"\bORIGIN:\s*(\d+/\s*\d+/\s*\d+,?\s+\d+:\s*\d+:\s*\d+)[\d.]*\s*(?:UTC|GMT)",
    "hypocentre": rf"\bHYPOCENTER:\s*({FLOAT})\s*([NS]?),?\s+({FLOAT})\s*([EW]?)",
}
"""The earthquake as headers of COSMOS and CSMIP state it."""


def resolution(text: str) -> float:
    """Unit of the last printed digit of a number: 0.001 for ``927.174``, 10 for ``1.23E3``."""
    mantissa, _, exponent = text.strip().upper().replace("D", "E").partition("E")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))


def stated_time(text: str, *patterns: str, ahead: timedelta = timedelta()) -> datetime | None:
    """A time that a header states, in UTC, of a clock that is ahead of it; None where no pattern fits."""
    for pattern in patterns:
        with suppress(ValueError, OverflowError):
            return datetime.strptime(text.strip(), pattern).replace(tzinfo=UTC) - ahead
    return None


@dataclass(frozen=True)
class Lines:
    """Lines of a file or of one channel in it; every index counts from 0 within them."""

    file: str  # what an error names
    lines: Sequence[str]
    before: int = 0  # lines of the file that come before these
    ended: bool = True  # whether the last line has its end

    @classmethod
    def of(cls, source: SourceFile) -> "Lines":
        """All lines of a file."""
        return cls(source.name, source.lines, ended=source.text[-1:] in "\r\n")

    def error(self, index: int, why: str) -> RecordError:
        """An error that names file and line."""
        return RecordError(f"{self.file} line {self.before + index + 1}: {why}")

    def number(self, text: str, index: int, what: str) -> float:
        """A finite number that fills a text of a line; not blank, ``nan``, ``******``, nor two numbers that touch."""
        match = _NUMBER.fullmatch(text)
        if match is None:
            raise self.error(index, f"{what} is {text.strip()!r}, not a number; correct it or get the file again")
        return float(match[1].replace("D", "E").replace("d", "e"))

    def time(self, index: int, day: Sequence[int], hour: int, minute: int, seconds: float) -> datetime:
        """A time in UTC from year, month and day, and the time of the day; a RecordError where there is none such."""
        year, month, of_month = day
        try:
            return datetime(year, month, of_month, hour, minute, tzinfo=UTC) + timedelta(seconds=seconds)
        except ValueError as problem:
            stated = f"start {year}-{month}-{of_month} {hour}:{minute}"
            raise self.error(index, f"{stated} ({problem}); correct it") from problem

    def check_header(self, length: int) -> None:
        """Refuse lines that end within a header of so many."""
        if len(self.lines) < length:
            raise self.error(len(self.lines) - 1, "the file ends in the header; get it again")

    def interval_of(self, rate: float, index: int) -> float:
        """Sampling interval, s, of a rate, Hz, that a line states."""
        if not 1.0 <= rate <= 100_000.0:
            raise self.error(
                index,
                f"{rate:g} Hz is no rate of an accelerograph (1 to 100000 Hz); correct it, or get the corrected file",
            )
        return 1.0 / rate

    def check_length(self, index: int, count: int, interval: float, length: float) -> None:
        """Refuse a count whose samples do not last as long, s, as a line states."""
        if abs(count * interval - length) > max(2.0 * interval, 0.011):
            what = f"{count} samples every {interval:g} s, but the header's length is {length:g} s"
            raise self.error(index, f"{what}; the file is cut or holds more: get it again")

    def check_spacing(self, first: int, time: FloatArray, interval: float, per_line: float, remedy: str) -> None:
        """Refuse times, s, which begin in the line ``first``, that are more than a millisecond off even ones."""
        uneven = np.flatnonzero(np.abs(time - time[0] - interval * np.arange(time.size)) > 0.0011)
        if uneven.size:
            at = first + int(uneven[0] // per_line)
            raise self.error(at, f"time {time[uneven[0]]:g} s does not fit an interval of {interval:g} s; {remedy}")

    def column(self, first: int) -> FloatArray:
        """All numbers of the free-format lines from ``first`` on, in reading order."""
        values = self._values([line.split() for line in self.lines[first:]], first)
        self._check_last_number()
        return values

    def rows(self, first: int, columns: int) -> FloatArray:
        """Numbers of the free-format lines from ``first`` on, so many on each; shape (lines, columns).

        Blank lines at the end are left. A RecordError names the line that has another count, or what is no number.
        """
        cells = [line.split() for line in self.lines[first:]]
        while cells and not cells[-1]:
            cells.pop()
        for index, line in enumerate(cells, first):
            if len(line) != columns:
                why = f"{len(line)} numbers where {columns} belong; columns touch, or the line is cut"
                raise self._wrong(index, line, why)
        values = self._values(cells, first).reshape(-1, columns)
        self._check_last_number()
        return values

    def fixed_columns(self, first: int, *, width: int, per_line: int, count: int) -> FloatArray:
        """Read ``count`` numbers in columns of fixed width that may touch (FORTRAN ``8F10.3``), from line ``first`` on.

        Lines after those that hold the numbers are left. A RecordError where lines are missing, or a column holds no
        number.
        """
        needed = -(-count // per_line)
        there = max(len(self.lines) - first, 0)
        if there < needed:
            raise self.error(
                first + there, f"the file ends after {there} of {needed} lines of samples; it is cut: get it again"
            )
        cells = [self._cells(first + k, width, min(per_line, count - k * per_line)) for k in range(needed)]
        return self._values(cells, first)

    def _cells(self, index: int, width: int, count: int) -> list[str]:
        """The columns of one line."""
        line = self.lines[index].rstrip()
        cells = [line[k * width : (k + 1) * width] for k in range(count)]
        if rest := line[count * width :].strip():
            why = f"{rest!r} after the last of {count} columns of {width} characters; the columns have moved"
            raise self._wrong(index, cells, why)
        # Numbers are set flush right, so a line that is shorter than its columns has lost the end of its last number.
        if len(line) < count * width:
            why = f"{len(line)} characters where {count} columns of {width} belong; the line is cut"
            raise self._wrong(index, cells, why)
        return cells

    def _wrong(self, index: int, cells: Sequence[str], why: str) -> RecordError:
        """What is wrong with a line: one of its cells, which is raised at once, or what is stated of the whole line."""
        for cell in cells:
            self.number(cell, index, "a sample")
        return self.error(index, f"{why}: get the file again")

    def _values(self, cells: Sequence[Sequence[str]], first: int) -> FloatArray:
        """Numbers of the cells of the lines from ``first`` on, in reading order."""
        words = [word for line in cells for word in line]
        # "nan", "inf" and "1_000" are numbers to Python but not to any of the formats.
        if not set("".join(words)) - _ALLOWED:
            with suppress(ValueError):
                return np.array(words, dtype=np.float64)
        numbers = [self.number(word, index, "a sample") for index, line in enumerate(cells, first) for word in line]
        return np.array(numbers, dtype=np.float64)

    def _check_last_number(self) -> None:
        """Refuse a last number that was cut off: fewer decimals than the one before it, and no line end behind it."""
        words = " ".join(self.lines[-2:]).split()[-2:]
        if not self.ended and len(words) == 2 and len(words[0].lstrip("+-")) != len(words[1].lstrip("+-")):
            before, last = (w.partition(".")[2] for w in words)
            if len(before) != len(last):
                raise self.error(len(self.lines) - 1, f"the last number, {words[1]!r}, is cut; get the file again")

    def fixed_integers(self, first: int, *, width: int, per_line: int, count: int) -> NDArray[np.int64]:
        """Whole numbers of up to nine digits in fixed columns (FORTRAN ``10I8``); see :meth:`fixed_columns`."""
        values = self.fixed_columns(first, width=width, per_line=per_line, count=count)
        wrong = np.flatnonzero((np.abs(values) >= 1e9) | (values != np.round(values)))
        if wrong.size:
            at = first + int(wrong[0]) // per_line
            raise self.error(at, f"{values[wrong[0]]:g} where a whole number belongs; get the file again")
        return values.astype(np.int64)


def in_turn(read: Callable[[SourceFile, Lines], tuple[Component, int]]) -> Callable[[SourceFile], list[Component]]:
    """A reader of files in which components stand one after the other, made of one that reads a component.

    That one gets the file and its lines from the beginning of a component on, and says how many the component takes;
    blank lines are left. A RecordError names the line where one is cut or contradicts itself.
    """

    def read_all(source: SourceFile) -> list[Component]:
        components, at = [], 0
        while at < len(source.lines):
            length = 1
            if source.lines[at].strip():
                component, length = read(source, Lines(source.name, source.lines[at:], at))
                components.append(component)
            at += length
        return components

    return read_all


@dataclass(frozen=True)
class Header:
    """What a header states: for each field its line and the match of its pattern."""

    lines: Lines
    found: Mapping[str, tuple[int, re.Match[str]]]

    @classmethod
    def of(cls, lines: Lines, fields: Fields, stop: int = 500) -> "Header":
        """Look for fields, in capitals or not, in the lines before ``stop``; the first line that fits counts."""
        found = {}
        for name, field in fields.items():
            at, pattern = (None, field) if isinstance(field, str) else field
            for index, line in enumerate(lines.lines[:stop]) if at is None else [(at, lines.lines[at])]:
                if match := re.search(pattern, line, re.IGNORECASE):
                    found[name] = index, match
                    break
            else:
                if at is not None:
                    raise lines.error(at, f"{line.strip()[:60]!r} where {name} belongs; get the file again")
        return cls(lines, found)

    def at(self, name: str) -> int:
        """Line of a field; a RecordError where it is not stated."""
        if name not in self.found:
            why = f"no {name} in the header that begins here; the file is cut or of another kind: get it again"
            raise self.lines.error(0, why)
        return self.found[name][0]

    def match(self, name: str) -> re.Match[str] | None:
        """Match of a field's pattern; None where it is not stated."""
        return self.found[name][1] if name in self.found else None

    def text(self, name: str) -> str:
        """Text of a field, the first group that took part; empty where it is not stated."""
        match = self.match(name)
        return next((group.strip() for group in match.groups() if group is not None), "") if match else ""

    def error(self, name: str, why: str) -> RecordError:
        """An error that names the line of a field."""
        return self.lines.error(self.at(name), why)

    def number(self, name: str, text: str | None = None) -> float:
        """Number of a field, or in a part of its text."""
        index = self.at(name)
        return self.lines.number(self.text(name) if text is None else text, index, name)

    def optional(self, name: str) -> float | None:
        """Number of a field; None where it is not stated, or blank."""
        return self.number(name) if self.text(name) else None

    def numbers(self, names: Mapping[str, str]) -> dict[str, Any]:
        """Numbers of the fields that are stated, by the names that a record's ``extra`` has for them."""
        return {name: self.number(field) for name, field in names.items() if self.text(field)}

    def peak(self, name: str, scale: float, text: str | None = None, *, after_mean: bool = False) -> StatedPeak:
        """The peak that a field, or a part of its text, states in a unit of ``scale`` m/s²."""
        stated = self.text(name) if text is None else text
        size = abs(self.number(name, stated))
        return StatedPeak(size * scale, resolution(stated) * scale, after_mean, self.lines.before + self.at(name) + 1)

    def time(self, name: str, *patterns: str, text: str | None = None, ahead: timedelta = timedelta()) -> datetime:
        """Time of a field, or in a part of its text, in one of the patterns, of a clock that is ahead of UTC."""
        stated = self.text(name) if text is None else text
        index, moment = self.at(name), stated_time(stated, *patterns, ahead=ahead)
        if moment is None:
            like = datetime(2000, 10, 6, 13, 30).strftime(patterns[0])
            raise self.lines.error(index, f"{name} {stated!r} is no time like {like}; correct it")
        return moment

    def clock(self, name: str) -> datetime | None:
        """Time, UTC, of a field of six groups, month, day, year, hour, minute and second; None where not stated."""
        match = self.match(name)
        if match is None:
            return None
        month, day, year, hour, minute = (int(match[i]) for i in range(1, 6))
        year += 0 if year > 99 else 1900 if year >= 50 else 2000
        return self.lines.time(self.at(name), (year, month, day), hour, minute, self.number(name, match[6]))

    def place(self, name: str) -> tuple[float, float] | tuple[None, None]:
        """Latitude and longitude, degrees, of a field of four groups: number, N or S, number, E or W; else None."""
        match = self.match(name)
        if match is None or match[1] is None:
            return None, None
        north, east = (float(match[i]) * (-1 if match[i + 1].upper() in ("S", "W") else 1) for i in (1, 3))
        return north, east

    def earthquake(self) -> tuple[datetime | None, dict[str, Any]]:
        """Origin time, UTC, and epicentre, degrees, as `EARTHQUAKE` has them; None and empty where not stated."""
        stated = re.sub(r"\s+|,", "", re.sub(r",?\s+(?=\d+:)", "-", self.text("origin")))
        origin = stated_time(stated, "%Y/%m/%d-%H:%M:%S", "%m/%d/%Y-%H:%M:%S", "%m/%d/%y-%H:%M:%S")
        return origin, epicentre(*self.place("hypocentre")) if any(self.place("hypocentre")) else {}

    def check_unit(self, name: str, pattern: str, read: str) -> None:
        """Refuse a unit, or what else says which quantity it is, that does not fit a pattern."""
        if not re.match(pattern, self.text(name), re.IGNORECASE):
            raise self.error(name, f"{name} {self.text(name)!r}; only {read} is read: get that file")

    def check_count(self, name: str, found: int, promised: str | None = None) -> None:
        """Refuse another number of samples than a field states, or a part of its text."""
        if self.number(name, promised) != found:
            what = f"header promises {promised or self.text(name)} samples, the file has {found}"
            raise self.error(name, f"{what}; it is cut or holds more: get it again")


def epicentre(north: float | None, east: float | None) -> dict[str, float]:
    """An epicentre, degrees, as a record's ``extra`` has it; empty where it is not known."""
    return {} if north is None or east is None else {"event_latitude": north, "event_longitude": east}
