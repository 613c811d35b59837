"""Hand-written tables: a header line and one row per line, each validated by a pydantic model."""

import csv
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, TypeAdapter, ValidationError

from overturning.errors import OverturningError, closest_name_hint
from overturning.validation import format_validation_error

_NAME_BY_DELIMITER = {"\t": "tabs", ",": "commas", ";": "semicolons", "  ": "spaces"}

MAX_TABLE_BYTES = 20_000_000
"""Largest size of a table, bytes: far more than a table written by hand."""

Row = TypeVar("Row", bound=BaseModel)


def read_table_rows(
    path: Path,
    row_model: type[Row],
    *,
    delimiter: str,
    error_class: type[OverturningError],
    table_kind: str,
    columns_of_which_one_is_required: Sequence[str] = (),
    reason_to_refuse_unknown_column: Callable[[str], str] | None = None,
) -> Iterator[tuple[int, Row]]:
    """Yield the line number and the validated content of each row of a table in a UTF-8 text file.

    Lines that begin with ``#`` are comments; empty lines are skipped; an empty cell means the column's default. In a
    tab-separated table, empty cells at the end of a line may be left out.

    Parameters
    ----------
    path, delimiter, table_kind : Path, str, str
        The file, the separator of its cells (comma or tab), and the name of this kind of file in messages.
    row_model : type of BaseModel
        Model whose fields are the columns that the table may have.
    error_class : type of OverturningError
        Exception to raise; its message names file, line, column, value and remedy.
    columns_of_which_one_is_required : sequence of str
        Columns at least one of which must be in the header.
    reason_to_refuse_unknown_column : callable, optional
        Function that receives the name of an unknown column and returns the reason to refuse the table, or "" to ignore
        the column. By default unknown columns are refused.
    """
    lines = _numbered_table_lines(path, row_model, error_class, table_kind)
    cells_of = []
    for number, line in lines:
        try:
            cells_of.append([cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))])
        except csv.Error as problem:  # a cell of more than 131,072 characters
            raise error_class(
                f"{path} line {number}: {problem}; no cell of a {table_kind} is that long: cut it"
            ) from None
    columns = [cell.lower() for cell in cells_of[0]]
    if len(columns) == 1 and (other := _unexpected_delimiter(columns[0], delimiter)):
        raise error_class(
            f"{path} line {lines[0][0]}: columns are separated by {_NAME_BY_DELIMITER[other]}; use "
            f"{_NAME_BY_DELIMITER[delimiter]}"
        )
    if why := _column_error_message(
        columns, row_model, columns_of_which_one_is_required, reason_to_refuse_unknown_column
    ):
        raise error_class(f"{path} line {lines[0][0]}: {why}")
    adapter = TypeAdapter(row_model)
    for (number, _), cells in zip(lines[1:], cells_of[1:], strict=True):
        if len(cells) > len(columns) or (len(cells) < len(columns) and delimiter != "\t"):
            raise error_class(
                f"{path} line {number}: {len(cells)} cells, the header names {len(columns)} columns; separate cells by "
                f"{_NAME_BY_DELIMITER[delimiter]}"
            )
        values = {
            column: cell
            for column, cell in zip(columns, cells, strict=False)
            if cell and column in row_model.model_fields
        }
        try:
            row = adapter.validate_python(values)
        except ValidationError as problem:
            raise error_class(f"{path} line {number}: {cell_error_messages(problem, row_model, values)[0]}") from None
        yield number, row


def _numbered_table_lines(
    path: Path, row_model: type[BaseModel], error_class: type[OverturningError], table_kind: str
) -> list[tuple[int, str]]:
    """Return number and text of each line except comments and empty lines; raise an error if there is none."""
    try:
        if path.stat().st_size > MAX_TABLE_BYTES:
            raise error_class(
                f"{path}: larger than {MAX_TABLE_BYTES} bytes; no {table_kind} is: check the path, or cut the file"
            )
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise error_class(
            f"{path}: cannot be read: no such {table_kind}; check the path in the config or the command"
        ) from None
    except (OSError, UnicodeDecodeError) as problem:
        raise error_class(f"{path}: cannot be read ({problem}); save the {table_kind} as text in UTF-8") from None
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not lines:
        raise error_class(
            f"{path}: the {table_kind} is empty; its first line names columns of {', '.join(row_model.model_fields)}"
        )
    return lines


def _unexpected_delimiter(header_line: str, expected_delimiter: str) -> str:
    """Return the delimiter that a table's header contains instead of the expected one; "" if there is none."""
    return next((one for one in _NAME_BY_DELIMITER if one != expected_delimiter and one in header_line.strip()), "")


def _column_error_message(
    column_names: Sequence[str],
    row_model: type[BaseModel],
    columns_of_which_one_is_required: Sequence[str],
    reason_to_refuse_unknown_column: Callable[[str], str] | None,
) -> str:
    """Return a message for an unknown, repeated or missing column in a table's header; "" if it is correct."""
    for column in column_names:
        if column not in row_model.model_fields:
            why = (
                reason_to_refuse_unknown_column(column)
                if reason_to_refuse_unknown_column
                else closest_name_hint(column, row_model.model_fields)
            )
            if why:
                return f"column {column!r} is not known; {why}"
    known = [column for column in column_names if column in row_model.model_fields]
    if len(set(known)) < len(known):
        return f"a column is named twice; name each column once: {', '.join(column_names)}"
    if columns_of_which_one_is_required and not set(columns_of_which_one_is_required) & set(column_names):
        return f"no column {' or '.join(columns_of_which_one_is_required)}; name one of them in the header"
    return ""


def cell_error_messages(
    validation_error: ValidationError, row_model: type[BaseModel], cell_texts_by_column: dict[str, str]
) -> list[str]:
    """Return a message for each invalid cell of a table row: column, value and the expected value.

    A rule between several cells gives one message per line of its text, without a column.
    """
    messages = []
    for entry in validation_error.errors():
        message = format_validation_error(entry)
        if not entry["loc"]:
            messages += message.split("\n")
            continue
        column = str(entry["loc"][0])
        field = row_model.model_fields[column]
        low, high = (
            next((getattr(bound, name) for bound in field.metadata if getattr(bound, name, None) is not None), None)
            for name in ("ge", "le")
        )
        if low is not None and high is not None and entry["type"] != "value_error":
            message = f"give a {'whole ' if field.annotation is int else ''}number from {low:g} to {high:g}"
        messages.append(f"column {column} {cell_texts_by_column.get(column, '')!r}: {message}")
    return messages
