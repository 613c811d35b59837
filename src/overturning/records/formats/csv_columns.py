"""Plain columns (CSV, tab, blanks) whose meaning and units the record table declares: nothing is guessed."""

import re
from typing import Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.component import UNKNOWN, Component, parse_axis
from overturning.records.formats.lines import Lines
from overturning.records.source import ReadOptions, SourceFile
from overturning.units import UNITS

SECONDS: Final = {"s": 1.0, "ms": 1e-3}


def read(source: SourceFile, options: ReadOptions) -> list[Component]:
    """Read all declared columns.

    ``columns`` names every column in order: ``time:s`` or ``time:ms``, ``skip``, or an axis with its unit:
    ``north:gal``, ``N28W:g``, ``270:m/s2``, ``up:gal``, ``down:gal``. Lines that begin with ``#`` and one line of
    headings are passed over.
    """
    name = source.name
    columns = _declared(options.columns, name)
    if options.processed is None:
        raise RecordError(
            f"{name}: columns do not say whether the samples are raw or have been corrected; declare it (processed in "
            "the record table: true or false; --processed or --raw here)"
        )
    rows, first_line = _rows(source, len(columns))
    interval = options.sampling_interval_s
    for index, (word, unit) in enumerate(columns):
        if word == "time":
            interval = _even(rows[:, index] * SECONDS[unit], name, first_line, interval)
    if interval is None:
        raise RecordError(f"{name}: no column time and no sampling_interval_s; declare one of them")
    components = []
    for index, (word, unit) in enumerate(columns):
        if word in ("time", "skip"):
            continue
        samples = rows[:, index] * UNITS[unit]
        more = {"processed": options.processed, "unit": unit, "extra": {"declared": options.declared}}
        components.append(Component.of(source, word, parse_axis(word), samples, interval, **more))
    return components


def _declared(text: str, name: str) -> list[tuple[str, str]]:
    if not text.strip():
        raise RecordError(
            f"{name}: columns are not declared; say what they are, e.g. `time:s north:gal east:gal up:gal` "
            "(columns in the record table, --columns here)"
        )
    columns = []
    for word in text.split():
        axis, _, unit = word.rpartition(":") if ":" in word else (word, "", "")
        if axis.lower() == "skip":
            columns.append(("skip", ""))
        elif axis.lower() == "time" and unit in SECONDS:
            columns.append(("time", unit))
        elif unit.lower() in UNITS and parse_axis(axis) != UNKNOWN:
            columns.append((axis, unit.lower()))
        elif len(columns) == 0 and re.search(r"[,;]", word):
            raise RecordError(f"{name}: columns {text!r}; set them off by blanks, not by commas or semicolons")
        else:
            raise RecordError(
                f"{name}: column {word!r}; declare time:s, skip, or axis:unit with an axis such as north, N28W, 270, "
                f"up and a unit of {', '.join(UNITS)}"
            )
    return columns


def _rows(source: SourceFile, width: int) -> tuple[np.ndarray, int]:
    lines = Lines.of(source)
    separator = _separator(source)
    values: list[list[float]] = []
    first_line = heading = 0
    for index, line in enumerate(source.lines):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        cells = [c.strip() for c in (text.split(separator) if separator else text.split())]
        if not values and not heading and any(re.search(r"[A-Za-z]{1,}", c) and not _numeric(c) for c in cells):
            heading = index + 1
            continue
        if wrong := _wrong_separator(line, cells, separator, width):
            raise lines.error(index, wrong)
        values.append([lines.number(cell, index, "a cell") for cell in cells])
        first_line = first_line or index + 1
    if source.data[-1:] not in (b"\n", b"\r"):
        raise lines.error(
            len(source.lines) - 1,
            "the last line has no line end, so its last number may be cut; add one if it is whole",
        )
    if len(values) < 2:
        raise RecordError(f"{source.name}: {len(values)} rows of numbers; a record needs at least 2")
    return np.array(values, dtype=np.float64), first_line


def _wrong_separator(line: str, cells: list[str], separator: str | None, width: int) -> str:
    """What is wrong with the marks between or in the cells of a line; empty where nothing is."""
    decimal = next((cell for cell in cells if re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell)), None)
    if decimal or (separator == "," and len(cells) == 2 * width and all(re.fullmatch(r"[+-]?\d*", c) for c in cells)):
        return f"{decimal or line.strip()[:30]!r} has decimal commas; write decimal points (sed 's/,/./g')"
    if len(cells) == width:
        return ""
    if separator != ";" and ";" in line:
        return "cells are set off by semicolons here, but not in the first line; set off all lines alike"
    return f"{len(cells)} columns, {width} are declared; correct either"


def _numeric(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _separator(source: SourceFile) -> str | None:
    first = next((line for line in source.lines if line.strip() and not line.startswith("#")), "")
    return next((c for c in ";\t," if c in first), None)


def _even(time: np.ndarray, name: str, first_line: int, declared: float | None) -> float:
    interval = float(time[-1] - time[0]) / (time.size - 1)
    steps = np.diff(time)
    uneven = np.flatnonzero(np.abs(steps - interval) > max(0.02 * abs(interval), 1e-9))
    if interval <= 0 or uneven.size:
        line = first_line + (int(uneven[0]) + 1 if uneven.size else 1)
        raise RecordError(f"{name} line {line}: times are not evenly spaced; resample the file first")
    interval = round(interval, 9)
    if declared is not None and abs(declared - interval) > 1e-3 * interval:
        raise RecordError(
            f"{name}: times are {interval:g} s apart, sampling_interval_s says {declared:g}; correct either"
        )
    return interval
