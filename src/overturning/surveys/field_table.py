"""Field tables as people keep them: any common separator, line end and byte order mark, read into cells.

Cells are not interpreted here; see `overturning.surveys.stones`.
"""

import csv
import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from overturning.errors import RecordError
from overturning.tables import MAX_TABLE_BYTES

_SEPARATORS: Final = {"\t": "tabs", ";": "semicolons", ",": "commas"}
_BYTE_ORDER_MARKS: Final = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}


@dataclass(frozen=True)
class NumberedTableRow:
    """Cells of one row of a table, without blanks at their ends, and the number of the row's first line."""

    first_line_number: int
    cells: tuple[str, ...]


@dataclass(frozen=True)
class TextTable:
    """Header, rows and separator of a text table, without its comments and empty rows.

    ``cell_separator`` is the character between cells; ``leading_comments`` are the comment lines above the header,
    without ``#``. ``line_numbers_of_row_like_comments`` are the numbers of comment lines below the header that have the
    cells of a row.
    """

    header: NumberedTableRow
    rows: tuple[NumberedTableRow, ...]
    cell_separator: str
    leading_comments: tuple[str, ...] = ()
    line_numbers_of_row_like_comments: tuple[int, ...] = ()

    @property
    def line_numbers_of_rows_with_pasted_row_in_cell(self) -> tuple[int, ...]:
        """Line numbers of rows with a cell of several lines, one of which seems to be a table row by its separators."""
        least = len(self.header.cells) - 1
        lines = [
            (row.first_line_number, line) for row in self.rows for cell in row.cells for line in cell.split("\n")[1:]
        ]
        found = [number for number, line in lines if least > 1 and line.count(self.cell_separator) >= least]
        return tuple(dict.fromkeys(found))

    @property
    def plural_separator_name(self) -> str:
        """Plural name of the table's separator for messages, such as "semicolons"."""
        return _SEPARATORS[self.cell_separator]


def read_text_table(path: Path, table_kind_in_messages: str) -> TextTable:
    """Read a text table with cells separated by commas, semicolons or tabs.

    UTF-8 with or without byte order mark, and UTF-16 with one, are read; line ends are those of any system. Lines that
    begin with ``#`` are comments, also if a spreadsheet put quotes around them. Rows of empty cells are skipped. A
    quoted cell may contain line breaks.

    Parameters
    ----------
    path : Path
        The file.
    table_kind_in_messages : str
        Name of this kind of file in messages, such as "survey".

    Raises
    ------
    RecordError
        If the file cannot be read as text, or has no header; the message names the file, line and remedy.
    """
    lines = re.split(
        r"\r\n|\r|\n", _read_table_text(path, table_kind_in_messages)
    )  # no other character ends a line of a CSV file
    remarks = tuple(_comment_text(line) for line in itertools.takewhile(_is_comment, lines))
    separator, rows = "", list[NumberedTableRow]()
    for number, line in enumerate(lines):
        if line.strip().lower() in ("sep=;", "sep=,", "sep=\t"):
            lines[number] = ""  # written by a spreadsheet; the header shows the separator
        elif line.strip() and not _is_comment(line):
            separator = _separator_of_header(line)
            break
    for start, cells in _rows_with_first_line_numbers(lines, separator or ",", path, table_kind_in_messages):
        if any(cells) and not cells[0].startswith("#"):
            rows.append(NumberedTableRow(start, tuple(cells)))
    if not rows:
        raise RecordError(f"{path}: the {table_kind_in_messages} is empty; its first line names the columns")
    comments = tuple(
        number
        for number, line in enumerate(lines, 1)
        if number > rows[0].first_line_number and _comment_resembles_table_row(line, separator, len(rows[0].cells))
    )
    return TextTable(rows[0], tuple(rows[1:]), separator, remarks, comments)


def _read_table_text(path: Path, table_kind_in_messages: str) -> str:
    """Return the text of a table file; if it is not in UTF-8, the RecordError says how to save the file."""
    try:
        if path.stat().st_size > MAX_TABLE_BYTES:
            raise RecordError(
                f"{path}: larger than {MAX_TABLE_BYTES} bytes; no {table_kind_in_messages} is: check the path, or cut "
                "the file"
            )
        content = path.read_bytes()
    except FileNotFoundError:
        raise RecordError(
            f"{path}: cannot be read: no such {table_kind_in_messages}; check the path in the config or the command"
        ) from None
    except OSError as problem:
        raise RecordError(
            f"{path}: cannot be read ({problem}); save the {table_kind_in_messages} as text in UTF-8"
        ) from None
    if content.startswith(b"PK\x03\x04"):
        raise RecordError(f"{path}: a spreadsheet (.xlsx or .ods), not text; save it as CSV UTF-8")
    encoding = _BYTE_ORDER_MARKS.get(content[:2], "utf-8-sig")
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as problem:
        if encoding == "utf-16":
            raise RecordError(
                f"{path}: damaged UTF-16 ({problem.reason}); save the {table_kind_in_messages} as UTF-8"
            ) from None
        line = content[: problem.start].count(b"\n") + 1
        raise RecordError(
            f"{path} line {line}: byte 0x{content[problem.start]:02X} is not UTF-8; the {table_kind_in_messages} was "
            "saved in another encoding, such as Latin-1, Windows-1252 or Shift-JIS: save it as CSV UTF-8"
        ) from None
    if "\0" in text:
        raise RecordError(
            f"{path}: zero bytes, as in UTF-16 without a byte order mark; save the {table_kind_in_messages} as UTF-8"
        )
    return text


def _is_comment(text_line: str) -> bool:
    """True if a line of a table is a comment, which starts with # (also after a quotation mark)."""
    return text_line.startswith(("#", '"#'))


def _comment_resembles_table_row(comment_line: str, cell_separator: str, header_column_count: int) -> bool:
    """True if a comment line resembles a table row: as many cells as the header, and text in two or more of them."""
    cells = comment_line.split(cell_separator)
    return (
        _is_comment(comment_line.lstrip())
        and len(cells) == header_column_count
        and sum(bool(cell.strip(' "')) for cell in cells) > 1
    )


def _comment_text(comment_line: str) -> str:
    """Return the text of a comment line, without quotes and separators that a spreadsheet program added."""
    from_spreadsheet = comment_line.startswith('"') or re.search(r"[,;\t]{2,}$", comment_line)
    return comment_line.strip('"# ,;\t' if from_spreadsheet else "# ")


def _separator_of_header(header_line: str) -> str:
    """Return the most frequent separator in a header line, outside quotation marks; a comma if there is none."""
    outside = "".join(header_line.split('"')[::2])
    return max(_SEPARATORS, key=lambda one: (outside.count(one), one == ","))


def _rows_with_first_line_numbers(
    lines_of_one_text: list[str], cell_separator: str, path: Path, table_kind_in_messages: str
) -> Iterator[tuple[int, list[str]]]:
    """Yield for each row its first line number and its cells; comments and empty lines are skipped."""
    place = 0

    def advance_through_remaining_lines() -> Iterator[str]:
        """Yield lines from index `place` on, and increase `place` by one with each; a row may take several lines."""
        nonlocal place
        while place < len(lines_of_one_text):
            place += 1
            yield lines_of_one_text[place - 1] + "\n"

    while place < len(lines_of_one_text):
        if not lines_of_one_text[place].strip() or lines_of_one_text[place].startswith("#"):
            place += 1
            continue
        start = place + 1
        try:
            cells = next(csv.reader(advance_through_remaining_lines(), delimiter=cell_separator, strict=True))
        except csv.Error as problem:  # a cell of more than 131,072 characters, or an open quote
            remedy = (
                "close the quote"
                if "unexpected end" in str(problem)
                else f"no cell of a {table_kind_in_messages} is that long: cut it"
                if "limit" in str(problem)
                else "double each quote inside a quoted cell"
            )
            raise RecordError(f"{path} line {start}: {problem}; {remedy}") from None
        yield start, [cell.strip() for cell in cells]
