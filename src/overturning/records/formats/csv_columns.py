"""Plain columns (CSV, tab, blanks) whose meaning and units the record table declares: nothing is guessed."""

import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import Reasons, RecordError
from overturning.records.component import UNKNOWN, Component, parse_axis
from overturning.records.formats.lines import FLOAT, Lines
from overturning.records.source import Declarations, SourceFile
from overturning.units import UNITS

SECONDS: Final = {"s": 1.0, "ms": 1e-3}
NUMBER: Final = re.compile(rf"{FLOAT}|[+-]?(nan|inf|infinity)", re.IGNORECASE)
"""Of a cell with letters that is no heading, but a number or the lack of one."""


def read(source: SourceFile, declared: Declarations) -> list[Component]:
    """Read all declared columns.

    ``columns`` names every column in order: ``time:s`` or ``time:ms``, ``skip``, or an axis with its unit:
    ``north:gal``, ``N28W:g``, ``270:m/s2``, ``up:gal``, ``down:gal``. Lines that begin with ``#`` and one line of
    headings are passed over.
    """
    name, reasons = source.name, Reasons()
    with reasons.of():
        columns = _columns(declared.columns, name)
        if declared.sampling_interval_s is None and "time" not in dict(columns):
            raise RecordError(f"{name}: no column time and no sampling_interval_s; declare one of them")
    with reasons.of():
        if declared.processed is None:
            raise RecordError(
                f"{name}: columns do not say whether the samples are raw or have been corrected; declare it (processed "
                "in the record table: true or false; --processed or --raw here)"
            )
    reasons.tell()
    lines = Lines(source, source.lines)
    rows, first, notes = _rows(lines, columns)
    interval = declared.sampling_interval_s or 0.0
    for index, (word, unit) in enumerate(columns):
        if word == "time":
            interval = _interval(lines, first, rows[:, index] * SECONDS[unit], declared.sampling_interval_s)
    extra = {"declared": declared.of_samples}
    return [
        Component.of(
            source,
            word,
            parse_axis(word),
            rows[:, index] * UNITS[unit],
            interval,
            processed=declared.processed,
            unit=unit,
            extra=extra,
            notes=notes,
        )
        for index, (word, unit) in enumerate(columns)
        if word not in ("time", "skip")
    ]


def _columns(text: str, name: str) -> list[tuple[str, str]]:
    """Axis and unit of each column."""
    if not text.strip():
        raise RecordError(
            f"{name}: columns are not declared; say what they are, e.g. `time:s north:gal east:gal up:gal` "
            "(columns in the record table, --columns here)"
        )
    columns = []
    for word in text.split():
        axis, _, unit = word.rpartition(":") if ":" in word else (word, "", "")
        if axis.lower() == "skip" or (axis.lower() == "time" and unit in SECONDS):
            columns.append((axis.lower(), unit))
        elif unit.lower() in UNITS and parse_axis(axis) != UNKNOWN:
            columns.append((axis, unit.lower()))
        elif not columns and re.search(r"[,;]", word):
            raise RecordError(f"{name}: columns {text!r}; set them off by blanks, not by commas or semicolons")
        else:
            raise RecordError(
                f"{name}: column {word!r}; declare time:s, skip, or axis:unit with an axis such as north, N28W, 270, "
                f"up and a unit of {', '.join(UNITS)}"
            )
    return columns


def _rows(lines: Lines, columns: Sequence[tuple[str, str]]) -> tuple[FloatArray, int, tuple[str, ...]]:
    """Numbers of all rows, the line of the first, and which headings say otherwise than what is declared."""
    width = len(columns)
    notes: tuple[str, ...] = ()
    texts = {i: text for i, line in enumerate(lines.lines) if (text := line.strip()) and not text.startswith("#")}
    separator = next((mark for mark in ";\t," if mark in next(iter(texts.values()), "")), None)
    cells = {i: [cell.strip() for cell in text.split(separator)] for i, text in texts.items()}
    if cells and any(re.search("[A-Za-z]", cell) and not NUMBER.fullmatch(cell) for cell in next(iter(cells.values()))):
        notes = _said_otherwise(lines.source.name, cells.pop(next(iter(cells))), columns)
    for index, row in cells.items():
        if wrong := _wrong_separator(texts[index], row, separator, width):
            raise lines.error(index, wrong)
    values = [[lines.number(cell, index, "a cell") for cell in row] for index, row in cells.items()]
    if not lines.ended:
        why = "the last line has no line end, so its last number may be cut; add one if it is whole"
        raise lines.error(len(lines.lines) - 1, why)
    if len(values) < 2:
        raise RecordError(f"{lines.source.name}: {len(values)} rows of numbers; a record needs at least 2")
    return np.array(values, dtype=np.float64), next(iter(cells)), notes


def _said_otherwise(name: str, headings: Sequence[str], columns: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    """What is said of headings that name another axis or unit, ``E``, ``north (g)``, than is declared."""
    notes = []
    for text, (word, unit) in zip(headings, columns, strict=False):
        axis, _, rest = text.strip("\"' ").replace("[", "(").partition("(")
        named = rest.rstrip(")] ").lower().replace("²", "2").replace("^", "").replace("/s/s", "/s2")
        other_axis = parse_axis(axis) not in (UNKNOWN, parse_axis(word))
        if word not in ("time", "skip") and (other_axis or UNITS.get(named, UNITS[unit]) != UNITS[unit]):
            notes.append(f"{name}: the column under {text!r} is taken as {word} in {unit}, as declared")
    return tuple(notes)


def _wrong_separator(line: str, cells: list[str], separator: str | None, width: int) -> str:
    """What is wrong with the marks between or in the cells of a line; empty where nothing is."""
    decimal = next((cell for cell in cells if re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell)), None)
    if decimal or (separator == "," and len(cells) == 2 * width and all(re.fullmatch(r"[+-]?\d*", c) for c in cells)):
        return f"{decimal or line[:30]!r} has decimal commas; write decimal points (sed 's/,/./g')"
    if len(cells) == width:
        return ""
    if separator != ";" and ";" in line:
        return "cells are set off by semicolons here, but not in the first line; set off all lines alike"
    return f"{len(cells)} columns, {width} are declared; correct either"


def _interval(lines: Lines, first: int, time: FloatArray, declared: float | None) -> float:
    """Sampling interval of a column of times, s, which agrees with the declared one."""
    exact = float(time[-1] - time[0]) / (time.size - 1)
    steps = np.abs(np.diff(time) - exact)
    if exact <= 0 or steps.max() > max(0.02 * exact, 1e-9):
        at = int(np.flatnonzero(steps > max(0.02 * abs(exact), 1e-9))[0]) if exact > 0 else 0
        raise lines.error(first + at + 1, "times are not evenly spaced; resample the file first")
    interval = round(exact, 9)
    if declared is not None and abs(declared - interval) > 1e-3 * interval:
        why = f"times are {interval:g} s apart, sampling_interval_s says {declared:g}; correct either"
        raise RecordError(f"{lines.source.name}: {why}")
    return interval
