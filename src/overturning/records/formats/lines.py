"""Lines of a text file, read strictly: what is not the number that it should be is an error with file and line."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.records.component import StatedPeak
from overturning.records.source import SourceFile

FLOAT: Final = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?"
_NUMBER: Final = re.compile(rf"\s*({FLOAT})\s*")
_ALLOWED: Final = set("0123456789+-.eE")


def resolution(text: str) -> float:
    """Unit of the last printed digit of a number: 0.001 for ``927.174``, 10 for ``1.23E3``."""
    mantissa, _, exponent = text.strip().upper().replace("D", "E").partition("E")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))


@dataclass(frozen=True)
class Header:
    """Texts of header lines ``KEY: text`` by key, with the lines that they stand in."""

    lines: "Lines"
    texts: dict[str, tuple[int, str]]

    @classmethod
    def of(cls, lines: "Lines", stop: int, strip: str = "") -> "Header":
        """Header of the lines before ``stop``, less the characters ``strip`` before each; the first of a key counts."""
        texts: dict[str, tuple[int, str]] = {}
        for index, line in enumerate(lines.lines[:stop]):
            key, colon, text = line.lstrip(strip).partition(":")
            if colon:
                texts.setdefault(" ".join(key.split()), (index, text.strip()))
        return cls(lines, texts)

    def at(self, key: str) -> int:
        """Line of a key; a RecordError where there is none."""
        if key not in self.texts:
            raise RecordError(f"{self.lines.file}: no header line {key}; get the file again")
        return self.texts[key][0]

    def text(self, key: str) -> str:
        """Text of a key; empty where there is none."""
        return self.texts.get(key, (0, ""))[1]

    def error(self, key: str, why: str) -> RecordError:
        """An error that names the line of a key."""
        return self.lines.error(self.at(key), why)

    def number(self, key: str, text: str | None = None) -> float:
        """Number of a key, or in a part of its text."""
        index = self.at(key)
        return self.lines.number(self.text(key) if text is None else text, index, key)

    def time(self, key: str, pattern: str, text: str | None = None) -> datetime:
        """Time of a key, or in a part of its text, in the given pattern; taken as UTC."""
        said = self.text(key) if text is None else text
        try:
            return datetime.strptime(said, pattern).replace(tzinfo=UTC)
        except ValueError:
            raise self.error(key, f"{key} {said!r} is no time like {pattern}; correct it") from None


def stated_time(text: str, pattern: str, ahead: timedelta = timedelta()) -> datetime | None:
    """A time that a header states beside, in UTC, of a clock that is ahead of it; None where it does not read so."""
    try:
        return datetime.strptime(text.strip(), pattern).replace(tzinfo=UTC) - ahead
    except (ValueError, OverflowError):
        return None


@dataclass(frozen=True)
class Lines:
    """Lines of a file or of one channel in it; every index counts from 0 within them."""

    file: str  # what an error names
    lines: Sequence[str]
    before: int = 0  # lines of the file that come before these

    @classmethod
    def of(cls, source: SourceFile) -> "Lines":
        """All lines of a file."""
        return cls(source.name, source.lines)

    def error(self, index: int, why: str) -> RecordError:
        """An error that names file and line."""
        return RecordError(f"{self.file} line {self.before + index + 1}: {why}")

    def number(self, text: str, index: int, what: str) -> float:
        """A finite number that fills a text of a line; not blank, ``nan``, ``******``, nor two numbers that touch."""
        match = _NUMBER.fullmatch(text)
        if match is None:
            raise self.error(index, f"{what} is {text.strip()!r}, not a number; correct it or get the file again")
        return float(match[1].replace("D", "E").replace("d", "e"))

    def peak(self, text: str, index: int, what: str, scale: float) -> StatedPeak:
        """The peak that a text taken from a line states in a unit of ``scale`` m/s²."""
        size = abs(self.number(text, index, what))
        return StatedPeak(size * scale, resolution(text) * scale, line=self.before + index + 1)

    def find(self, pattern: str, stop: int | None = None) -> tuple[re.Match[str], int] | None:
        """First match of a pattern, whichever case, and its line, before the line ``stop``; None without one."""
        for index, line in enumerate(self.lines[:stop]):
            if match := re.search(pattern, line, re.IGNORECASE):
                return match, index
        return None

    def earthquake(self) -> tuple[datetime | None, dict[str, float]]:
        """Origin time, UTC, and epicentre, degrees, as COSMOS and CSMIP headers state them; None and empty without."""
        origin, places = None, {}
        if found := self.find(r"\bORIGIN:\s*(\d+/\s*\d+/\s*\d+),?\s+(\d+:\s*\d+:\s*\d+)[\d.]*\s*(?:UTC|GMT)"):
            said = re.sub(r"\s", "", f"{found[0][1]}-{found[0][2]}")
            forms = ("%Y/%m/%d-%H:%M:%S", "%m/%d/%Y-%H:%M:%S", "%m/%d/%y-%H:%M:%S")
            origin = next((time for form in forms if (time := stated_time(said, form))), None)
        if found := self.find(rf"\bHYPOCENTER:\s*({FLOAT})\s*([NS]?),?\s+({FLOAT})\s*([EW]?)"):
            north, east = (float(found[0][i]) * (-1 if found[0][i + 1].upper() in ("S", "W") else 1) for i in (1, 3))
            places = {"event_latitude": north, "event_longitude": east} if north or east else {}
        return origin, places

    def time(self, index: int, day: Sequence[int], hour: int, minute: int, seconds: float) -> datetime:
        """A time in UTC from year, month and day, and the time of the day; a RecordError where there is none such."""
        year, month, of_month = day
        try:
            return datetime(year, month, of_month, hour, minute, tzinfo=UTC) + timedelta(seconds=seconds)
        except ValueError as problem:
            raise self.error(
                index, f"start {year}-{month}-{of_month} {hour}:{minute} ({problem}); correct it"
            ) from problem

    def column(self, first: int) -> FloatArray:
        """All numbers of the free-format lines from ``first`` on, in reading order."""
        words = " ".join(self.lines[first:]).split()
        try:
            # "nan", "inf" and "1_000" are numbers to Python but not to any of the formats.
            if any(set(word) - _ALLOWED for word in words):
                raise ValueError
            return np.array(words, dtype=np.float64)
        except ValueError:
            rest = enumerate(self.lines[first:], first)
            values = [self.number(word, index, "a sample") for index, line in rest for word in line.split()]
            return np.array(values, dtype=np.float64)

    def rows(self, first: int, columns: int, stop: int | None = None) -> FloatArray:
        """Numbers of the free-format lines from ``first`` to before ``stop``, so many on each; shape (lines, columns).

        Blank lines at the end are left. A RecordError names the line that has another count, or what is no number.
        """
        lines = list(self.lines[first:stop])
        while lines and not lines[-1].strip():
            lines.pop()
        words: list[str] = []
        for index, line in enumerate(lines, first):
            cells = line.split()
            if len(cells) != columns or set("".join(cells)) - _ALLOWED:
                for cell in cells:
                    self.number(cell, index, "a sample")
                why = f"{len(cells)} numbers where {columns} belong; columns touch, or the line is cut"
                raise self.error(index, f"{why}: get the file again")
            words += cells
        try:
            return np.array(words, dtype=np.float64).reshape(-1, columns)
        except ValueError:
            for place, word in enumerate(words):
                self.number(word, first + place // columns, "a sample")
            raise

    def check_last_number(self, end: str) -> None:
        """Refuse a last number that was cut off: fewer decimals than the one before it, and no line end behind it.

        ``end`` is the end of the file, at least two numbers.
        """
        if end[-1:] in "\r\n":
            return
        words = end.split()[-2:]
        if len(words) == 2 and len(words[0].lstrip("+-")) != len(words[1].lstrip("+-")):
            before, last = (w.partition(".")[2] for w in words)
            if len(before) != len(last):
                raise self.error(len(self.lines) - 1, f"the last number, {words[1]!r}, is cut; get the file again")

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
        words: list[str] = []
        for index in range(first, first + needed):
            words += self._cells(index, width, min(per_line, count - len(words)))
        try:
            return np.array(words, dtype=np.float64)
        except ValueError:
            for index, word in enumerate(words):
                self.number(word, first + index // per_line, "a sample")
            raise

    def _cells(self, index: int, width: int, count: int) -> list[str]:
        """The columns of one line, each of characters that numbers have."""
        line = self.lines[index].rstrip()
        cells = [line[k * width : (k + 1) * width] for k in range(count)]
        rest = line[count * width :].strip()
        # Numbers are set flush right, so a line that is shorter than its columns has lost the end of its last number.
        cut = len(line) < count * width
        if rest or cut or not all(cell.strip() and not set(cell.strip()) - _ALLOWED for cell in cells):
            for cell in cells:
                self.number(cell, index, "a sample")
            if rest:
                why = f"{rest!r} after the last of {count} columns of {width} characters; the columns have moved"
            else:
                why = f"{len(line)} characters where {count} columns of {width} belong; the line is cut"
            raise self.error(index, f"{why}: get the file again")
        return cells

    def fixed_integers(self, first: int, *, width: int, per_line: int, count: int) -> NDArray[np.int64]:
        """Whole numbers of up to nine digits in fixed columns (FORTRAN ``10I8``); see :meth:`fixed_columns`."""
        values = self.fixed_columns(first, width=width, per_line=per_line, count=count)
        wrong = np.flatnonzero((np.abs(values) >= 1e9) | (values != np.round(values)))
        if wrong.size:
            raise self.error(
                first + int(wrong[0]) // per_line,
                f"{values[wrong[0]]:g} where a whole number belongs; get the file again",
            )
        return values.astype(np.int64)
