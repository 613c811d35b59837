"""Columns of numbers (CSV, tabs, blanks) with declared axes and units; the reader guesses neither."""

import re
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError, RecordRefusalReasonCollector
from overturning.records.axis_direction import UNKNOWN_DIRECTION, parse_axis_direction
from overturning.records.component import RecordComponent
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.formats.headings import (
    SECONDS_BY_TIME_UNIT,
    first_number_line_index,
    heading_conflict_notes_and_refusal_reason,
    split_heading_lines_into_cells,
    unit_line_conflict_notes_and_refusal_reason,
)
from overturning.records.formats.lines import TextLines
from overturning.records.source import SourceFile
from overturning.units import ACCELERATION_UNITS_IN_M_S2


def read_components(source_file: SourceFile, user_declared_properties: DeclaredFileProperties) -> list[RecordComponent]:
    """Read components from the columns of a text file, whose axes and units the user declares.

    ``columns`` names every column in order: ``time:s`` or ``time:ms``, ``skip``, or an axis with its unit:
    ``north:gal``, ``N28W:g``, ``270:m/s2``, ``up:gal``, ``down:gal``. With one file per component,
    ``x_n.txt=north:gal x_e.txt=east:gal`` assigns an axis to each file; names may contain ``*``. ``north:gal*8`` means
    eight values of one axis per line, ``north:gal*8F10`` the same in fields of ten characters. Headings and lines that
    begin with ``#`` are skipped.
    """
    name, reasons = source_file.name, RecordRefusalReasonCollector()
    columns: list[tuple[str, str]] = []
    with reasons.suppress_record_error_and_keep_reasons():
        text, sisters = _column_declaration_and_record_key_of_file(user_declared_properties.columns, name)
        text, per_line, width = _split_column_values_per_line_and_field_width(text, name)
        columns = _parse_axes_and_units(text, name)
        if user_declared_properties.sampling_interval_s is None and "time" not in dict(columns):
            raise RecordError(f"{name}: no column time and no sampling_interval_s; declare one of them")
    with reasons.suppress_record_error_and_keep_reasons():
        if user_declared_properties.processed is None:
            raise RecordError(
                f"{name}: columns do not say whether the samples are raw or have been corrected; declare it (processed "
                "in the record table: true or false; --processed or --raw here)"
            )
    reasons.raise_collected_reasons()
    lines = TextLines(source_file, source_file.lines)
    rows, first, notes = _read_number_rows_first_line_and_notes(
        lines, columns, user_declared_properties, per_line, width
    )
    interval = user_declared_properties.sampling_interval_s or 0.0
    for index, (word, unit) in enumerate(columns):
        if word == "time":
            interval = _checked_sampling_interval(
                lines, first, rows[:, index] * SECONDS_BY_TIME_UNIT[unit], user_declared_properties.sampling_interval_s
            )
    extra = {"declared": user_declared_properties.declared_sample_property_texts}
    return [
        RecordComponent.from_file(
            source_file,
            word,
            parse_axis_direction(word),
            rows[:, index] * ACCELERATION_UNITS_IN_M_S2[unit],
            interval,
            is_already_corrected=user_declared_properties.processed,
            unit_declared_if_format_states_none=unit,
            extra_metadata=extra,
            notes=notes,
            shared_key_of_record_files=sisters,
        )
        for index, (word, unit) in enumerate(columns)
        if word not in ("time", "skip")
    ]


def _column_declaration_and_record_key_of_file(
    columns_declared_of_all_files_text: str, file_name: str
) -> tuple[str, str]:
    """Return the column declaration for a file, and a key that is equal for all files of the same record.

    The key joins the parts of the file's name that match each ``*``; it is "" if the declaration names no files.
    """
    words = columns_declared_of_all_files_text.split()
    if not any("=" in word for word in words):
        return columns_declared_of_all_files_text, ""
    declared: dict[str, list[str]] = {}
    pattern = ""
    for word in words:
        named, equals, column = word.rpartition("=")
        pattern = named if equals else pattern
        if not pattern:
            raise RecordError(f"{file_name}: column {word!r} stands before the name of its file; write x_n.txt={word}")
        declared.setdefault(pattern, []).extend([column] if column else [])
    base = PurePosixPath(file_name).name.rpartition(":")[2]
    found = {
        pattern: "=" + "=".join(parts.groups())
        for pattern in declared
        if (parts := re.fullmatch(re.escape(pattern).replace(r"\*", "(.*)"), base))
    }
    # A full name takes precedence over patterns.
    pattern = base if base in found else next(iter(found), "")
    if not pattern:
        why = f"no columns are declared of it, only of {', '.join(declared)}; add {base}=axis:unit"
        raise RecordError(f"{file_name}: {why}")
    if len(found) > 1 and pattern != base:
        raise RecordError(f"{file_name}: its name fits {' and '.join(found)}; write patterns that fit one axis each")
    return " ".join(declared[pattern]), found[pattern]


def _split_column_values_per_line_and_field_width(
    columns_declared_of_all_files_text: str, file_name: str
) -> tuple[str, int, int]:
    """Split ``north:gal*8F10`` into column, values per line (8) and field width (10); a number not stated is 0."""
    match = re.fullmatch(r"(\S+)\*(\d+)(?:[FEfe](\d+)(?:\.\d+)?)?", columns_declared_of_all_files_text.strip())
    if match is None:
        if "*" in columns_declared_of_all_files_text:
            raise RecordError(
                f"{file_name}: columns {columns_declared_of_all_files_text!r}; only a single column has several values "
                f"a line: "
                "north:gal*8"
            )
        return columns_declared_of_all_files_text, 0, 0
    per_line, width = int(match[2]), int(match[3] or 0)
    if not (1 <= per_line <= 1000 and (match[3] is None or 1 <= width <= 100)):
        raise RecordError(
            f"{file_name}: columns {columns_declared_of_all_files_text!r}; 1 to 1000 values a line, of 1 to 100 "
            f"characters"
        )
    return match[1], per_line, width


def _parse_axes_and_units(columns_declared_of_all_files_text: str, file_name: str) -> list[tuple[str, str]]:
    """Return the axis and unit of each declared column; raise a RecordError if the declaration is invalid."""
    if not columns_declared_of_all_files_text.strip():
        raise RecordError(
            f"{file_name}: columns are not declared; say what they are, e.g. `time:s north:gal east:gal up:gal` "
            "(columns in the record table, --columns here)"
        )
    columns = []
    for word in columns_declared_of_all_files_text.split():
        axis, _, unit = word.rpartition(":") if ":" in word else (word, "", "")
        if axis.lower() == "skip" or (axis.lower() == "time" and unit in SECONDS_BY_TIME_UNIT):
            columns.append((axis.lower(), unit))
        elif unit.lower() in ACCELERATION_UNITS_IN_M_S2 and parse_axis_direction(axis) != UNKNOWN_DIRECTION:
            columns.append((axis, unit.lower()))
        elif not columns and re.search(r"[,;]", word):
            raise RecordError(
                f"{file_name}: columns {columns_declared_of_all_files_text!r}; set them off by blanks, not by commas "
                f"or semicolons"
            )
        else:
            raise RecordError(
                f"{file_name}: column {word!r}; declare time:s, skip, or axis:unit with an axis such as north, N28W, "
                f"270, up and a unit of {', '.join(ACCELERATION_UNITS_IN_M_S2)}"
            )
    return columns


def _read_number_rows_first_line_and_notes(
    lines: TextLines,
    axis_and_unit_of_declared_columns: Sequence[tuple[str, str]],
    user_declared_properties: DeclaredFileProperties,
    samples_of_one_axis_per_line_or_0: int,
    characters_per_sample_or_0: int,
) -> tuple[FloatArray, int, tuple[str, ...]]:
    """Return the numbers of a file, shape (rows, columns), the index of their first line, and notes on headings."""
    name, first = lines.source.name, first_number_line_index(lines.lines)
    trusting = user_declared_properties.trust_data
    texts = {
        i: line if characters_per_sample_or_0 else text
        for i, line in enumerate(lines.lines[first:], first)
        if (text := line.strip()) and text[0] != "#"
    }
    separator = next((mark for mark in ";\t," if mark in next(iter(texts.values()), "")), None)
    headings = split_heading_lines_into_cells(lines.lines[:first], separator, len(axis_and_unit_of_declared_columns))
    notes, why = heading_conflict_notes_and_refusal_reason(name, headings, axis_and_unit_of_declared_columns)
    stated, quantity = unit_line_conflict_notes_and_refusal_reason(
        name, lines.lines[:first], separator, axis_and_unit_of_declared_columns
    )
    notes, why = notes + stated, why or quantity
    if why and not trusting:
        raise RecordError(f"{name}: {why}; declare its acceleration, or say --trust-data if the heading is wrong")
    notes += (f"{name}: trusted although {why}",) if why else ()
    if samples_of_one_axis_per_line_or_0:
        values = _read_axis_with_several_samples_per_line(
            lines, texts, separator, samples_of_one_axis_per_line_or_0, characters_per_sample_or_0
        )
    else:
        cells = {i: text.split(separator) for i, text in texts.items()}
        if separator is not None:
            cells = {i: [cell.strip() for cell in row] for i, row in cells.items()}
        for index, row in cells.items():
            if wrong := _separator_or_decimal_mark_error(
                texts[index], row, separator, len(axis_and_unit_of_declared_columns)
            ):
                raise lines.line_error(index, wrong)
        values = lines.parse_cells_as_numbers(cells, "a cell").reshape(-1, len(axis_and_unit_of_declared_columns))
    if not lines.ends_with_newline:
        why = "the last line has no line end, so its last number may be cut; add one if it is whole"
        raise lines.line_error(len(lines.lines) - 1, why)
    if len(values) < 2:
        raise RecordError(f"{name}: {len(values)} rows of numbers; a record needs at least 2")
    # Some files begin with the count of samples, or with count and interval on two lines.
    counted = float(values[0, 0]) in (len(values) - 1, len(values) - 2) and len(values) > 10
    if counted and axis_and_unit_of_declared_columns[0][0] != "time" and not trusting:
        why = f"{values[0, 0]:g} is the count of the lines below, not a sample; write # before it, or say --trust-data"
        raise lines.line_error(next(iter(texts)), why)
    for (word, _), column in zip(axis_and_unit_of_declared_columns, values.T, strict=True):
        mark = 0.0 if word in ("time", "skip") or trusting else _missing_sample_marker_or_zero(column)
        if mark:
            index = list(texts)[
                int(np.flatnonzero(np.abs(column) == mark)[0]) // max(samples_of_one_axis_per_line_or_0, 1)
            ]
            why = f"{mark:g} marks a missing sample; cut the record there, or say --trust-data if it is a sample"
            raise lines.line_error(index, why)
    return values, next(iter(texts)), notes


_MISSING_SAMPLE_MARKERS: Final = frozenset(
    float(f"{'9' * whole}.{'9' * decimals}") for whole in range(3, 7) for decimals in range(4)
)
"""Numbers that programs write in place of a missing sample, such as 999.99, with either sign."""


def _missing_sample_marker_or_zero(numbers_of_column: FloatArray) -> float:
    """Return the number, such as 999.99, that stands for missing samples in a file; 0 if there is none.

    Such a number consists of nines, and all other samples are less than half as large.
    """
    sizes = np.unique(np.abs(numbers_of_column))
    largest = float(sizes[-1])
    return largest if largest in _MISSING_SAMPLE_MARKERS and (sizes.size == 1 or sizes[-2] < 0.5 * largest) else 0.0


def _read_axis_with_several_samples_per_line(
    lines: TextLines,
    text_by_line_index: Mapping[int, str],
    separator: str | None,
    samples_per_line: int,
    characters_per_sample_or_0: int,
) -> FloatArray:
    """Read the samples of a file with a single axis and several samples per line, shape (samples, 1)."""
    cells_by_line: dict[int, list[str]] = {}
    last = max(text_by_line_index, default=0)
    for index, text in text_by_line_index.items():
        line = text.rstrip()
        cells = (
            re.findall(f".{{1,{characters_per_sample_or_0}}}", line)
            if characters_per_sample_or_0
            else line.strip(f"{separator or ' '} ").split(separator)
        )
        if (
            len(cells) > samples_per_line
            or (len(cells) < samples_per_line and index != last)
            or (characters_per_sample_or_0 and len(line) % characters_per_sample_or_0)
        ):
            lines.parse_cells_as_numbers(cells_by_line, "a value")  # an error in an earlier line is reported first
            why = f"{len(cells)} values, {samples_per_line} are declared"
            each = f" of {characters_per_sample_or_0} characters" if characters_per_sample_or_0 else ""
            raise lines.line_error(index, f"{why}{each}; correct either")
        cells_by_line[index] = cells
    return lines.parse_cells_as_numbers(cells_by_line, "a value").reshape(-1, 1)


def _separator_or_decimal_mark_error(
    line_text: str, cell_texts_of_line: list[str], separator: str | None, declared_column_count: int
) -> str:
    """Return an error message if a line has decimal commas, wrong separators or not one cell per column; else ""."""
    if len(cell_texts_of_line) == declared_column_count and (separator == "," or "," not in line_text):
        return ""
    decimal = next((cell for cell in cell_texts_of_line if re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell)), None)
    if decimal or (
        separator == ","
        and len(cell_texts_of_line) == 2 * declared_column_count
        and all(re.fullmatch(r"[+-]?\d*", c) for c in cell_texts_of_line)
    ):
        return f"{decimal or line_text[:30]!r} has decimal commas; write decimal points (sed 's/,/./g')"
    if len(cell_texts_of_line) == declared_column_count:
        return ""
    if separator != ";" and ";" in line_text:
        return "cells are set off by semicolons here, but not in the first line; set off all lines alike"
    return f"{len(cell_texts_of_line)} columns, {declared_column_count} are declared; correct either"


def _checked_sampling_interval(
    lines: TextLines, first_time_line_index: int, time_s: FloatArray, declared_sampling_interval_s: float | None
) -> float:
    """Return the mean interval of a time column, s; a RecordError if it is uneven by over 2 % or not as declared."""
    exact = float(time_s[-1] - time_s[0]) / (time_s.size - 1)
    steps = np.abs(np.diff(time_s) - exact)
    if exact <= 0 or steps.max() > max(0.02 * exact, 1e-9):
        at = int(np.flatnonzero(steps > max(0.02 * abs(exact), 1e-9))[0]) if exact > 0 else 0
        raise lines.line_error(first_time_line_index + at + 1, "times are not evenly spaced; resample the file first")
    interval = round(exact, 9)
    if declared_sampling_interval_s is not None and abs(declared_sampling_interval_s - interval) > 1e-3 * interval:
        why = (
            f"times are {interval:g} s apart, sampling_interval_s says {declared_sampling_interval_s:g}; correct either"
        )
        raise RecordError(f"{lines.source.name}: {why}")
    return interval
