"""Hand-written tables: a header line and one row per line, each validated by a pydantic model."""

import csv
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, TypeAdapter, ValidationError

from overturning.errors import OverturningError, did_you_mean
from overturning.validation import format_validation_error

_NAMES = {"\t": "tabs", ",": "commas", ";": "semicolons", "  ": "spaces"}

MOST_BYTES = 20_000_000
"""Largest size of a table, bytes: far more than a table written by hand."""

Row = TypeVar("Row", bound=BaseModel)


def read_rows(
    path: Path,
    model: type[Row],
    *,
    delimiter: str,
    error: type[OverturningError],
    kind: str,
    one_of: Sequence[str] = (),
    refusal: Callable[[str], str] | None = None,
) -> Iterator[tuple[int, Row]]:
    """Yield the line number and the validated row for each row of a table (UTF-8 with or without byte order mark).

    Lines that begin with ``#`` are comments; empty lines are skipped; an empty cell means the column's default. In a
    tab-separated table, empty cells at the end of a line may be left out.

    Parameters
    ----------
    path, delimiter, kind : Path, str, str
        The file, the separator of its cells (comma or tab), and the name of this kind of file in messages.
    model : type of BaseModel
        Model whose fields are the columns that the table may have.
    error : type of OverturningError
        Exception to raise; its message names file, line, column, value and remedy.
    one_of : sequence of str
        Columns at least one of which must be in the header.
    refusal : callable, optional
        Function that receives the name of an unknown column and returns the reason to refuse the table, or "" to ignore
        the column. By default unknown columns are refused.
    """
    lines = _lines(path, model, error, kind)
    cells_of = []
    for number, line in lines:
        try:
            cells_of.append([cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))])
        except csv.Error as problem:  # a cell of more than 131,072 characters
            raise error(f"{path} line {number}: {problem}; no cell of a {kind} is that long: cut it") from None
    columns = [cell.lower() for cell in cells_of[0]]
    if len(columns) == 1 and (other := _other_delimiter(columns[0], delimiter)):
        raise error(f"{path} line {lines[0][0]}: columns are separated by {_NAMES[other]}; use {_NAMES[delimiter]}")
    if why := _wrong_columns(columns, model, one_of, refusal):
        raise error(f"{path} line {lines[0][0]}: {why}")
    adapter = TypeAdapter(model)
    for (number, _), cells in zip(lines[1:], cells_of[1:], strict=True):
        if len(cells) > len(columns) or (len(cells) < len(columns) and delimiter != "\t"):
            raise error(
                f"{path} line {number}: {len(cells)} cells, the header names {len(columns)} columns; separate cells by "
                f"{_NAMES[delimiter]}"
            )
        values = {
            column: cell for column, cell in zip(columns, cells, strict=False) if cell and column in model.model_fields
        }
        try:
            row = adapter.validate_python(values)
        except ValidationError as problem:
            raise error(f"{path} line {number}: {_wrong_cell(problem, model, values)}") from None
        yield number, row


def _lines(path: Path, model: type[BaseModel], error: type[OverturningError], kind: str) -> list[tuple[int, str]]:
    """Return the lines that are neither empty nor comments, with their numbers; raise `error` if there is none."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise error(f"{path}: larger than {MOST_BYTES} bytes; no {kind} is: check the path, or cut the file")
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise error(f"{path}: cannot be read: no such {kind}; check the path in the config or the command") from None
    except (OSError, UnicodeDecodeError) as problem:
        raise error(f"{path}: cannot be read ({problem}); save the {kind} as text in UTF-8") from None
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not lines:
        raise error(f"{path}: the {kind} is empty; its first line names columns of {', '.join(model.model_fields)}")
    return lines


def _other_delimiter(header: str, delimiter: str) -> str:
    """Return the separator found in a header that has no `delimiter`; empty if there is none."""
    return next((one for one in _NAMES if one != delimiter and one in header.strip()), "")


def _wrong_columns(
    columns: Sequence[str],
    model: type[BaseModel],
    one_of: Sequence[str],
    refusal: Callable[[str], str] | None,
) -> str:
    """Return the first fault of the columns of a header; empty if there is none."""
    for column in columns:
        if column not in model.model_fields:
            why = refusal(column) if refusal else did_you_mean(column, model.model_fields)
            if why:
                return f"column {column!r} is not known; {why}"
    known = [column for column in columns if column in model.model_fields]
    if len(set(known)) < len(known):
        return f"a column is named twice; name each column once: {', '.join(columns)}"
    if one_of and not set(one_of) & set(columns):
        return f"no column {' or '.join(one_of)}; name one of them in the header"
    return ""


def _wrong_cell(problem: ValidationError, model: type[BaseModel], values: dict[str, str]) -> str:
    """Return a message for the first error of a row: column, value and the expected value."""
    first = problem.errors()[0]
    message = format_validation_error(first)
    if not first["loc"]:
        return message
    column = str(first["loc"][0])
    field = model.model_fields[column]
    low, high = (
        next((getattr(bound, name) for bound in field.metadata if getattr(bound, name, None) is not None), None)
        for name in ("ge", "le")
    )
    if low is not None and high is not None and first["type"] != "value_error":
        message = f"give a {'whole ' if field.annotation is int else ''}number from {low:g} to {high:g}"
    return f"column {column} {values.get(column, '')!r}: {message}"
