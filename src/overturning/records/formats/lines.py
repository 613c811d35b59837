"""Columns of numbers in text files, with checks, and files of consecutive components; shared by the text readers.

Reading is strict: text in place of a number is an error that names file and line.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.records.component import RecordComponent
from overturning.records.source import SourceFile

FLOAT_PATTERN: Final = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?"
_NUMBER_PATTERN: Final = re.compile(rf"\s*({FLOAT_PATTERN})\s*")
_NUMBER_CHARACTERS: Final = set("0123456789+-.eE ")


@dataclass(frozen=True)
class TextLines:
    """Lines of a text file, or of its part that begins with a channel; line indices count from its first line, 0."""

    source: SourceFile
    lines: Sequence[str]
    file_line_count_before_first_line: int = 0  # number of lines of the file before these

    @property
    def ends_with_newline(self) -> bool:
        """True if the last line of the file ends with a newline character; if not, the file may be cut."""
        return self.source.text[-1:] in "\r\n"

    def line_error(self, line_index: int, problem: str) -> RecordError:
        """Return an error with the file name, the line number and a description of the problem."""
        return RecordError(
            f"{self.source.name} line {self.file_line_count_before_first_line + line_index + 1}: {problem}"
        )

    def parse_number(self, number_text: str, line_index: int, quantity_label: str) -> float:
        """Parse a text as one finite number; raise a RecordError for other text, such as blanks, ``nan`` or ``***``."""
        match = _NUMBER_PATTERN.fullmatch(number_text)
        if match is None:
            raise self.line_error(
                line_index,
                f"{quantity_label} is {number_text.strip()!r}, not a number; correct it or get the file again",
            )
        return float(match[1].replace("D", "E").replace("d", "e"))

    def utc_time(
        self, line_index: int, year_month_day: Sequence[int], hour: int, minute: int, seconds_after_minute: float
    ) -> datetime:
        """Return year, month, day, hour, minute and seconds of a line as a UTC time; a RecordError names the line."""
        year, month, of_month = year_month_day
        try:
            return datetime(year, month, of_month, hour, minute, tzinfo=UTC) + timedelta(seconds=seconds_after_minute)
        except ValueError as problem:
            stated = f"start {year}-{month}-{of_month} {hour}:{minute}"
            raise self.line_error(line_index, f"{stated} ({problem}); correct it") from problem

    def check_header_length(self, min_line_count: int) -> None:
        """Raise a RecordError if the file has fewer than ``min_line_count`` lines, and so ends in its header."""
        if len(self.lines) < min_line_count:
            raise self.line_error(len(self.lines) - 1, "the file ends in the header; get it again")

    def sampling_interval_of_rate(self, sampling_rate_hz: float, line_index: int) -> float:
        """Return the sampling interval, s, for a sampling rate, Hz, that a line of the file states."""
        if not 1.0 <= sampling_rate_hz <= 100_000.0:
            raise self.line_error(
                line_index,
                f"{sampling_rate_hz:g} Hz is no rate of an accelerograph (1 to 100000 Hz); correct it, or get the "
                "corrected file",
            )
        return 1.0 / sampling_rate_hz

    def check_duration_stated_in_line(
        self,
        line_index: int,
        found_sample_count: int,
        sampling_interval: float,
        stated_duration_s: float,
        tolerance_s: float = 0.0,
    ) -> None:
        """Raise a RecordError if the duration of the samples differs from a duration, s, that a line states.

        The duration is count × interval. The tolerance is the longest of two intervals, 11 ms and `tolerance_s`.
        """
        if abs(found_sample_count * sampling_interval - stated_duration_s) > max(
            2.0 * sampling_interval, 0.011, tolerance_s
        ):
            what = f"{found_sample_count} samples every {sampling_interval:g} s, but the header's length is "
            what += f"{stated_duration_s:g} s"
            raise self.line_error(line_index, f"{what}; the file is cut or holds more: get it again")

    def surplus_number_notes(self, stated_sample_count: int, surplus_count_text: str) -> tuple[str, ...]:
        """Return a note that numbers after the samples stated in the header are left out, and how many."""
        return (
            f"{self.source.name} goes on after the {stated_sample_count} samples that its header promises: "
            f"{surplus_count_text} left out",
        )

    def read_fixed_width_samples_next_line_and_notes(
        self,
        first_line_index: int,
        *,
        column_width: int,
        numbers_per_line: int,
        number_count: int,
        refuse_text_after_numbers: bool = False,
    ) -> tuple[FloatArray, int, tuple[str, ...]]:
        """Read ``number_count`` samples in fixed-width columns; return also the next line's index and surplus notes."""
        values = self.read_fixed_width_numbers(
            first_line_index, column_width=column_width, numbers_per_line=numbers_per_line, number_count=number_count
        )
        return values, *self.skip_surplus_number_lines_with_notes(
            first_line_index + -(-number_count // numbers_per_line),
            number_count,
            refuse_text_after_numbers=refuse_text_after_numbers,
        )

    def skip_surplus_number_lines_with_notes(
        self, line_index_after_samples: int, stated_sample_count: int, *, refuse_text_after_numbers: bool = False
    ) -> tuple[int, tuple[str, ...]]:
        """Skip lines of numbers after the last sample; return the next line's index, and a note if lines are skipped.

        `line_index_after_samples` is the first line after the samples that the header states. With
        `refuse_text_after_numbers`, a RecordError is raised if text follows the skipped lines.
        """
        end = line_index_after_samples
        while (
            end < len(self.lines) and self.lines[end].strip() and not set(self.lines[end].rstrip()) - _NUMBER_CHARACTERS
        ):
            end += 1
        if refuse_text_after_numbers and any(line.strip() for line in self.lines[end:]):
            raise self.line_error(
                end, f"{self.lines[end][:40]!r} after the last of {stated_sample_count} samples; get the file again"
            )
        return end, self.surplus_number_notes(
            stated_sample_count,
            f"{end - line_index_after_samples} line{'s' * (end - line_index_after_samples > 1)} of numbers",
        ) if end > line_index_after_samples else ()

    def check_times_have_constant_interval(
        self,
        first_time_line_index: int,
        time_s: FloatArray,
        sampling_interval: float,
        time_count_per_line: float,
        remedy: str,
    ) -> None:
        """Raise a RecordError if a time in ``time_s``, s, deviates by more than 1.1 ms from constant intervals."""
        uneven = np.flatnonzero(np.abs(time_s - time_s[0] - sampling_interval * np.arange(time_s.size)) > 0.0011)
        if uneven.size:
            at = first_time_line_index + int(uneven[0] // time_count_per_line)
            raise self.line_error(
                at, f"time {time_s[uneven[0]]:g} s does not fit an interval of {sampling_interval:g} s; {remedy}"
            )

    def read_all_numbers(self, first_line_index: int) -> FloatArray:
        """Read all numbers, separated by blanks, from a line to the end of the file; skip blank lines.

        A RecordError names text that is no number, and a line with another count of numbers than the first one: in a
        damaged line a number may be split in two, which would shift all later samples. The last line may be shorter.
        """
        cells = {
            k: words
            for k, line in enumerate(self.lines[first_line_index:], first_line_index)
            if (words := line.split())
        }
        values = self.parse_cells_as_numbers(cells)
        count, last = len(next(iter(cells.values()), ())), max(cells, default=0)
        wrong = next((k for k, words in cells.items() if len(words) != count and (k != last or len(words) > count)), 0)
        if wrong:
            what = f"{len(cells[wrong])} numbers where {count} belong"
            raise self.line_error(wrong, f"{what}; the line is damaged: get the file again")
        self._check_last_number_is_complete()
        return values

    def read_number_rows(self, first_line_index: int, column_count: int) -> FloatArray:
        """Read the numbers, separated by blanks, from line ``first_line_index`` on, shape (lines, columns).

        Blank lines at the end are ignored. A RecordError names a line without ``column_count`` numbers.
        """
        cells = [line.split() for line in self.lines[first_line_index:]]
        while cells and not cells[-1]:
            cells.pop()
        for index, line in enumerate(cells, first_line_index):
            if len(line) != column_count:
                why = f"{len(line)} numbers where {column_count} belong; columns touch, or the line is cut"
                raise self._raise_cell_error_or_create_line_error(index, line, why)
        values = self.parse_cells_as_numbers(dict(enumerate(cells, first_line_index))).reshape(-1, column_count)
        self._check_last_number_is_complete()
        return values

    def read_fixed_width_numbers(
        self, first_line_index: int, *, column_width: int, numbers_per_line: int, number_count: int
    ) -> FloatArray:
        """Read ``number_count`` numbers in fixed-width columns, which need no blanks in between (FORTRAN ``8F10.3``).

        Later lines are ignored. Raises a RecordError if lines are missing or a column holds no number.
        """
        needed = -(-number_count // numbers_per_line)
        there = max(len(self.lines) - first_line_index, 0)
        if there < needed:
            raise self.line_error(
                first_line_index + there,
                f"the file ends after {there} of {needed} lines of samples; it is cut: get it again",
            )
        return self.parse_cells_as_numbers(
            {
                first_line_index + k: self._split_line_into_fixed_columns(
                    first_line_index + k, column_width, min(numbers_per_line, number_count - k * numbers_per_line)
                )
                for k in range(needed)
            }
        )

    def _split_line_into_fixed_columns(self, line_index: int, column_width: int, column_count: int) -> list[str]:
        """Split a line into texts of fixed width; raise a RecordError if text follows the last column."""
        line = self.lines[line_index].rstrip()
        cells = [line[k * column_width : (k + 1) * column_width] for k in range(column_count)]
        if rest := line[column_count * column_width :].strip():
            columns = f"{column_count} columns of {column_width} characters"
            why = f"{rest!r} after the last of {columns}; the columns have moved"
            raise self._raise_cell_error_or_create_line_error(line_index, cells, why)
        # Numbers are right-aligned, so a line shorter than its columns has lost the end of its last number.
        if len(line) < column_count * column_width:
            why = f"{len(line)} characters where {column_count} columns of {column_width} belong; the line is cut"
            raise self._raise_cell_error_or_create_line_error(line_index, cells, why)
        return cells

    def _raise_cell_error_or_create_line_error(
        self, line_index: int, cell_texts_of_line: Sequence[str], problem: str
    ) -> RecordError:
        """Return an error about a problem in a line, or raise an error about the first cell that is no number."""
        for cell in cell_texts_of_line:
            self.parse_number(cell, line_index, "a sample")
        return self.line_error(line_index, f"{problem}: get the file again")

    def parse_cells_as_numbers(
        self, cell_texts_by_line_index: Mapping[int, Sequence[str]], quantity_label: str = "a sample"
    ) -> FloatArray:
        """Convert cell texts to a one-dimensional array of numbers; a RecordError names the line of another text."""
        words = [word for cells in cell_texts_by_line_index.values() for word in cells]
        # Python also accepts "nan", "inf" and "1_000", which no format allows.
        if not set("".join(words)) - _NUMBER_CHARACTERS:
            with suppress(ValueError):
                return np.array(words, dtype=np.float64)
        numbers = [
            self.parse_number(word, index, quantity_label)
            for index, cells in cell_texts_by_line_index.items()
            for word in cells
        ]
        return np.array(numbers, dtype=np.float64)

    def _check_last_number_is_complete(self) -> None:
        """Raise a RecordError if the file ends without newline, and its last two numbers differ in decimals."""
        words = " ".join(self.lines[-2:]).split()[-2:]
        if not self.ends_with_newline and len(words) == 2 and len(words[0].lstrip("+-")) != len(words[1].lstrip("+-")):
            before, last = (w.partition(".")[2] for w in words)
            if len(before) != len(last):
                raise self.line_error(len(self.lines) - 1, f"the last number, {words[1]!r}, is cut; get the file again")

    def read_fixed_width_integers(
        self, first_line_index: int, *, column_width: int, numbers_per_line: int, number_count: int
    ) -> NDArray[np.int64]:
        """Read whole numbers in fixed-width columns (FORTRAN ``10I8``), each of up to nine digits."""
        values = self.read_fixed_width_numbers(
            first_line_index, column_width=column_width, numbers_per_line=numbers_per_line, number_count=number_count
        )
        wrong = np.flatnonzero((np.abs(values) >= 1e9) | (values != np.round(values)))
        if wrong.size:
            at = first_line_index + int(wrong[0]) // numbers_per_line
            raise self.line_error(at, f"{values[wrong[0]]:g} where a whole number belongs; get the file again")
        return values.astype(np.int64)


_ComponentReader = Callable[[TextLines], tuple[RecordComponent, int]]


def decorator_for_reading_all_components(
    first_line_pattern_of_component: str, remedy_text: str
) -> Callable[[_ComponentReader], Callable[[SourceFile], list[RecordComponent]]]:
    """Return a decorator that turns a reader of one component into a reader of all components of a file.

    Each component begins with a line that fits ``first_line_pattern_of_component``. The decorated function gets the
    lines from there to the end of the file, and returns the component and the number of its lines. Blank lines before
    a component are skipped. A RecordError that ends with ``remedy_text`` names a line that begins no component.
    """

    def read_all_components(read_component: _ComponentReader, source_file: SourceFile) -> list[RecordComponent]:
        """Read the components of a file one after the other, with the decorated reader of one component."""
        components, at = [], 0
        while at < len(source_file.lines):
            line, length = source_file.lines[at].strip(), 1
            if line:
                block = TextLines(source_file, source_file.lines[at:], at)
                if not re.match(first_line_pattern_of_component, line, re.IGNORECASE):
                    raise block.line_error(0, f"{line[:40]!r} where the next component should begin; {remedy_text}")
                component, length = read_component(block)
                components.append(component)
            at += length
        return components

    return lambda read: partial(read_all_components, read)
