"""What the readers of text files share: columns of numbers and their checks; components one after the other.

Everything is read strictly: what is not the number that it should be is an error with file and line.
"""

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.records.component import Component
from overturning.records.source import SourceFile

FLOAT: Final = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?"
_NUMBER: Final = re.compile(rf"\s*({FLOAT})\s*")
_ALLOWED: Final = set("0123456789+-.eE ")


@dataclass(frozen=True)
class Lines:
    """Lines of a file or of one channel in it; every index counts from 0 within them."""

    source: SourceFile
    lines: Sequence[str]
    before: int = 0  # lines of the file that come before these

    @property
    def ended(self) -> bool:
        """Whether the last line of the file has its end."""
        return self.source.text[-1:] in "\r\n"

    def error(self, index: int, why: str) -> RecordError:
        """An error that names file and line."""
        return RecordError(f"{self.source.name} line {self.before + index + 1}: {why}")

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

    def check_length(self, index: int, count: int, interval: float, length: float, digit: float = 0.0) -> None:
        """Refuse a count whose samples do not last as long, s, as a line states, to so much of its last digit."""
        if abs(count * interval - length) > max(2.0 * interval, 0.011, digit):
            what = f"{count} samples every {interval:g} s, but the header's length is {length:g} s"
            raise self.error(index, f"{what}; the file is cut or holds more: get it again")

    def surplus(self, samples: int, more: str) -> tuple[str, ...]:
        """What is said of a file that goes on after the samples that its header promises."""
        return (f"{self.source.name} goes on after the {samples} samples that its header promises: {more} left out",)

    def samples(
        self, first: int, *, width: int, per_line: int, count: int, last: bool = False
    ) -> tuple[FloatArray, int, tuple[str, ...]]:
        """Samples in fixed columns, the line after them, and a note; see `fixed_columns` and `after_samples`."""
        values = self.fixed_columns(first, width=width, per_line=per_line, count=count)
        return values, *self.after_samples(first + -(-count // per_line), count, last=last)

    def after_samples(self, at: int, samples: int, *, last: bool = False) -> tuple[int, tuple[str, ...]]:
        """The first line from `at` on that holds more than numbers, and what is said of the lines of numbers before it.

        `samples` are those that the header promises, which end before `at`. A RecordError where they are the `last` of
        the file, but words follow.
        """
        end = at
        while end < len(self.lines) and self.lines[end].strip() and not set(self.lines[end].rstrip()) - _ALLOWED:
            end += 1
        if last and any(line.strip() for line in self.lines[end:]):
            raise self.error(end, f"{self.lines[end][:40]!r} after the last of {samples} samples; get the file again")
        return end, self.surplus(samples, f"{end - at} line{'s' * (end - at > 1)} of numbers") if end > at else ()

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


_ReadOne = Callable[[Lines], tuple[Component, int]]


def in_turn(begins: str, remedy: str) -> Callable[[_ReadOne], Callable[[SourceFile], list[Component]]]:
    """A reader of files in which components stand one after the other, made of one that reads a component.

    That one gets the lines from the beginning of a component on, which fits a pattern, and says how many the component
    takes; blank lines are left. A RecordError names the line where one is cut or contradicts itself.
    """

    def read_all(read: _ReadOne, source: SourceFile) -> list[Component]:
        components, at = [], 0
        while at < len(source.lines):
            line, length = source.lines[at].strip(), 1
            if line:
                block = Lines(source, source.lines[at:], at)
                if not re.match(begins, line, re.IGNORECASE):
                    raise block.error(0, f"{line[:40]!r} where the next component should begin; {remedy}")
                component, length = read(block)
                components.append(component)
            at += length
        return components

    return lambda read: partial(read_all, read)
