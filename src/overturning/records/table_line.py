"""Add a line to the record table, after its files have been read."""

import re
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError

from overturning.errors import ArgumentError, ConfigError, MissingDataError, OverturningError
from overturning.files import atomic_write, path_in_working_folder_or_package
from overturning.records.catalogue import RecordTableRow, read_record_table
from overturning.records.duplicates import (
    duplicate_record_messages,
    find_id_pairs_of_duplicate_records,
    fingerprint_of_recorded_motion,
)
from overturning.records.earthquakes import assign_records_to_earthquakes
from overturning.records.processing import process_record
from overturning.records.read import read_components_and_paths_of_file_and_siblings, read_record
from overturning.records.record import Record
from overturning.validation import format_validation_error

COLUMNS_OF_NEW_RECORD_TABLE = ("id", "format", "source", "station", "event", "fault_strike_deg", "pulse", "licence")
"""Columns of a new table."""


def copy_files_and_add_record_to_table(
    paths: Sequence[Path], cell_text_by_column_name: dict[str, str], record_table_path: Path, record_folder: Path
) -> Record:
    """Copy a record's files to ``record_folder`` and add a line for them to the record table; return the record.

    If ``paths`` has one file and no ``source`` is given, the other files of its record are found and included. A
    missing table is created with the lines of the package's table. Defaults of ``id`` and ``source`` are made of the
    file names. Raises an `OverturningError` for an unknown column, an id that exists already, or a file that is missing
    or cannot be read; nothing is written then.
    """
    _check_files_and_columns_exist(paths, cell_text_by_column_name)
    stem = "".join(sign if sign.isalnum() or sign in "_-" else "-" for sign in paths[0].name.split(".")[0].lower())
    cells = {"id": stem, "format": "auto", "source": " ".join(path.name for path in paths), **cell_text_by_column_name}
    before = path_in_working_folder_or_package(record_table_path)
    rows = read_record_table(before) if before.exists() else {}
    if cells["id"] in rows:
        raise ConfigError(f"{record_table_path}: id {cells['id']!r} is there already; give another one")
    entry = _validated_table_row(cells)
    if len(paths) == 1 and "source" not in cell_text_by_column_name:
        paths = read_components_and_paths_of_file_and_siblings(paths[0], entry.declared_file_properties)[1]
        cells["source"] = " ".join(path.name for path in paths)
        entry = entry.model_copy(update={"source": cells["source"]})
    _check_cell_characters(cells)
    if (
        blank := next((path for path in paths if re.search(r"\s", path.name)), None)
    ) and "source" not in cell_text_by_column_name:
        raise ArgumentError(f"{blank.name!r}: blanks set off the files of a record in its table; rename it")
    with tempfile.TemporaryDirectory() as name:
        for path in paths:
            shutil.copyfile(path, Path(name) / path.name)
        record = process_record(read_record(entry, Path(name)), None)
    _copy_record_files(paths, record_folder)
    _write_table_with_added_line(record_table_path, before, cells)
    return record


def _check_files_and_columns_exist(paths: Sequence[Path], cell_text_by_column_name: dict[str, str]) -> None:
    """Raise an error if a path is not a file, or if the record table has no column of a given name."""
    missing = [path for path in paths if not path.is_file()]
    if missing:
        why = "a folder; name the files of one record in it" if missing[0].is_dir() else "no such file"
        raise MissingDataError(f"{missing[0]}: {why}")
    unknown = sorted(set(cell_text_by_column_name) - RecordTableRow.model_fields.keys())
    if unknown:
        raise ArgumentError(
            f"{unknown[0]}: no column of the record table; known are {', '.join(RecordTableRow.model_fields)}"
        )


def _validated_table_row(cell_text_by_column_name: dict[str, str]) -> RecordTableRow:
    """Validate the cells of a record-table row; raise an ArgumentError for an invalid cell."""
    try:
        return RecordTableRow.model_validate({name: text for name, text in cell_text_by_column_name.items() if text})
    except ValidationError as error:
        first = error.errors()[0]
        raise ArgumentError(f"{'.'.join(map(str, first['loc']))}: {format_validation_error(first)}") from None


def _check_cell_characters(cell_text_by_column_name: dict[str, str]) -> None:
    """Raise an ArgumentError if a cell contains characters, such as a tab, that would break the record table."""
    for text in cell_text_by_column_name.values():
        if re.search(r'[\t\n\r]|^"', text):
            raise ArgumentError(
                f"{text!r}: a cell of the record table has no tab or line end and begins with no quotation mark"
            )


def _copy_record_files(paths: Sequence[Path], record_folder: Path) -> None:
    """Copy files to the folder of record files; an ArgumentError if other files have the same names there."""
    record_folder.mkdir(parents=True, exist_ok=True)
    for path in paths:
        target = record_folder / path.name
        if target.exists() and target.read_bytes() != path.read_bytes():
            raise ArgumentError(f"{target}: another file of this name is there; rename yours")
        if not target.exists():
            shutil.copyfile(path, target)


def earthquake_and_duplicate_notes_on_new_record(
    record: Record, record_table_path: Path, record_folder: Path
) -> list[str]:
    """Return notes on a new record of the record table: doubtful earthquake, or same samples as another record.

    For other records whose files cannot be read, only the earthquake is compared, from their lines of the table.
    """
    others = [
        _read_record_or_return_row(entry, record_folder)
        for entry in read_record_table(record_table_path).values()
        if entry.id != record.record_id
    ]
    known = assign_records_to_earthquakes(others).notes
    notes = [
        f"earthquakes: {note}" for note in assign_records_to_earthquakes([*others, record]).notes if note not in known
    ]
    read = [process_record(one, None) for one in others if isinstance(one, Record)]
    texts = duplicate_record_messages(
        find_id_pairs_of_duplicate_records(map(fingerprint_of_recorded_motion, [*read, record]))
    )
    return notes + [f"  {text}" for text in texts if record.record_id in text.split()]


def _read_record_or_return_row(table_row: RecordTableRow, record_folder: Path) -> Record | RecordTableRow:
    """Read the record of a row of the record table; return the row itself if its files cannot be read."""
    try:
        return read_record(table_row, record_folder)
    except OverturningError:
        return table_row


def _write_table_with_added_line(
    record_table_path: Path, existing_table_path: Path, cell_text_by_column_name: dict[str, str]
) -> None:
    """Write a record table with the lines of ``existing_table_path`` and a new one; columns are added as needed."""
    lines = (
        existing_table_path.read_text(encoding="utf-8-sig").splitlines()
        if existing_table_path.exists()
        else ["\t".join(COLUMNS_OF_NEW_RECORD_TABLE)]
    )
    head = next(index for index, line in enumerate(lines) if line.strip() and not line.startswith("#"))
    columns = lines[head].split("\t")
    known = [column.strip().lower() for column in columns]
    new = [column for column, cell in cell_text_by_column_name.items() if cell and column not in known]
    lines[head] = "\t".join([*columns, *new])
    lines.append("\t".join(cell_text_by_column_name.get(column, "") for column in (*known, *new)).rstrip("\t"))
    with atomic_write(record_table_path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
