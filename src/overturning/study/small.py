"""Run small studies from Python, without the workflow, and convert cubes to tables."""

import tempfile
import threading
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from overturning.errors import ArgumentError, ConfigError, MissingDataError
from overturning.files import atomic_write
from overturning.motion.motion import Accelerogram, Motion
from overturning.records.duplicates import refuse_duplicate_records
from overturning.records.processing import process_record
from overturning.records.read import read_record
from overturning.records.record import Record, as_record
from overturning.records.store import round_samples_to_stored_decimals
from overturning.study.cube import open_cube
from overturning.study.ensemble_members import draw_parameter_changes_of_members
from overturning.study.gather import merge_outcome_files_into_cube
from overturning.study.load import read_record_table_rows_of_study, study_from_content
from overturning.study.scenes import numerical_options_of_study
from overturning.study.schema import Study
from overturning.study.sweep import simulate_and_write_cases_of_record

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from distributed import Client


_NETCDF_WRITING_LOCK: Final = threading.RLock()
"""Lock of `run_study`: the library that writes its files must not be called by several threads at once."""


def to_dataframe(cube: "xr.Dataset") -> "pd.DataFrame":
    """Convert the outcomes in a results cube, or in a part of it, to a pandas table with one row per case.

    Parameters
    ----------
    cube : xarray.Dataset
        Cube from `overturning.open_cube`, `overturning.run_study` or `overturning.simulate`.

    Returns
    -------
    pandas.DataFrame
        A row for each case, in the order of the cube. Columns: the record's id, the cube's dimensions, its variables,
        and metadata of the record, such as station and magnitude. A cube of `overturning.simulate` has no record, and
        the table no columns for it. Missing values are NaN.

    Raises
    ------
    ArgumentError
        If the dataset has no outcomes by case, for instance a trajectory.
    """
    if (
        not set(getattr(cube, "data_vars", ()))
        or "overturned" not in cube
        or set(cube.dims) != set(cube["overturned"].dims)
    ):
        raise ArgumentError(
            f"cube: a {type(cube).__name__} without outcomes by case; give a cube of open_cube, run_study or simulate"
        )
    first = [str(name) for name in cube["overturned"].dims]
    named = (
        cube.assign_coords(record=cube["record_id"].variable).drop_vars("record_id") if "record_id" in cube else cube
    )
    if not first:  # a single case: a table of one row
        return named.expand_dims(case=1).to_dataframe().reset_index(drop=True)
    table = named.to_dataframe(dim_order=first).reset_index()
    known = [name for name in ("record", *first, *cube.data_vars) if name in table]
    return table[list(dict.fromkeys([*known, *table]))]


def write_table_of_cases(cube: "xr.Dataset", csv_or_parquet_path: Path) -> int:
    """Write all cases of a results cube as .csv or .parquet, record by record; return the number of cases.

    A MissingDataError is raised if pyarrow, which Parquet needs, is not installed.
    """
    parts = (to_dataframe(cube.isel(record=[number]).load()) for number in range(cube.sizes["record"]))
    if csv_or_parquet_path.suffix.lower() == ".csv":
        with atomic_write(csv_or_parquet_path) as part, part.open("w", encoding="utf-8", newline="") as text:
            return sum(table.to_csv(text, index=False, header=text.tell() == 0) or len(table) for table in parts)
    try:
        from pyarrow import Table, parquet
    except ImportError:
        raise MissingDataError(
            f"{csv_or_parquet_path.name}: Parquet needs pyarrow; python -m pip install 'overturning[parquet]', "
            "or write .csv"
        ) from None
    rows = 0
    with atomic_write(csv_or_parquet_path) as part, ExitStack() as stack:
        writer = None
        for table in parts:
            arrow = Table.from_pandas(table, preserve_index=False)
            writer = writer or stack.enter_context(parquet.ParquetWriter(part, arrow.schema))
            writer.write_table(arrow)
            rows += arrow.num_rows
    return rows


def run_study(
    records: Iterable[Record | Motion | str], threads: int = 1, client: "Client | None" = None, **keys: Any
) -> "xr.Dataset":
    """Run a study of a few records, with its ensemble, without a workflow, and return the results cube.

    Calls from several threads run one after the other; give `threads` instead.

    Parameters
    ----------
    records : iterable of Record, Motion or str
        Processed records as `overturning.read` returns them, motions, or ids of the record table. A motion gets the id
        ``motion-2`` if it is the second in the list.
    threads : int
        Number of threads.
    client : dask.distributed.Client, optional
        Cluster whose workers compute the cases.
    **keys
        Keys of a study file, for instance ``azimuth={"step": 10}, b_over_h=[0.2, 0.4], friction=[0.6]``.

    Returns
    -------
    xarray.Dataset
        The cube, in memory, as `overturning.open_cube` reads it with all elements and amplitudes.

    Raises
    ------
    ArgumentError
        If a single record is given instead of a list, or an element of the list is no record, motion or id.
    ConfigError
        If a key or value is wrong, an id is not in the record table, `keys` has ``processing`` although a record or
        motion is given, two records have the same samples (motions may), or `keys` has ``variants``.
    """
    given = _convert_motions_in_list_to_records(records)
    names = [record if isinstance(record, str) else record.record_id for record in given]
    # The records themselves are given: the table is asked for those that are not.
    settings = {"name": "study", **keys, "records": {"use": names}}
    study = study_from_content(settings, "run_study")
    if study.variants:
        raise ConfigError(
            "run_study: variants: one cube is returned, that of the study itself; run each as a study of its own"
        )
    used = _read_and_process_records(given, study)
    refuse_duplicate_records(used)
    numerics = numerical_options_of_study(study, threads, dask_client=client)
    members = draw_parameter_changes_of_members(study.ensemble) if study.ensemble.members else None
    with _NETCDF_WRITING_LOCK, tempfile.TemporaryDirectory() as name:
        parts = [Path(name) / f"{index}.nc" for index in range(len(used))]
        for record, part in zip(used, parts, strict=True):
            simulate_and_write_cases_of_record(study, record, part, members=members, numerics=numerics)
        merge_outcome_files_into_cube(study, used, parts, Path(name) / "cube.nc")
        with open_cube(Path(name) / "cube.nc", element=None, amplitude=None) as cube:
            return cube.load()


def _convert_motions_in_list_to_records(records: Iterable[Record | Motion | str]) -> list[Record | str]:
    """Return records and record ids from a list; each motion in it gets an id and becomes a record.

    An ArgumentError is raised if `records` is no list, or an element is no record, motion or id.
    """
    if isinstance(records, str | Accelerogram):
        raise ArgumentError("records: one that is no list; give a list of them, run_study([record], …)")
    if not isinstance(records, Iterable) or isinstance(records, Mapping):
        raise ArgumentError(f"records: a {type(records).__name__}; give a list of them, run_study([record], …)")
    records = list(records)  # a generator can be read only once
    others = [type(one).__name__ for one in records if not isinstance(one, str | Accelerogram)]
    if others:
        raise ArgumentError(f"records: a {others[0]}; give a record of overturning.read, a Motion, or an id")
    return [one if isinstance(one, str) else as_record(one, f"motion-{n}") for n, one in enumerate(records, 1)]


def _read_and_process_records(records_or_ids: Sequence[Record | str], study: Study) -> list[Record]:
    """Read and process the records given by id; apply the study's soil layers, if any, to these and the given ones."""
    asked = [record for record in records_or_ids if isinstance(record, str)]
    if study.processing is not None and len(asked) < len(records_or_ids):
        raise ConfigError(
            "run_study: processing: a record or motion that is given is taken as it is; process it as it is read, "
            "overturning.read(…, processing=…)"
        )
    only = study.model_copy(update={"records": study.records.model_copy(update={"use": tuple(asked)})})
    entries = read_record_table_rows_of_study(only, "run_study") if asked else {}
    return [
        round_samples_to_stored_decimals(
            process_record(read_record(entries[record], Path(study.records.folder)), study.processing, study.site)
        )
        if isinstance(record, str)
        else round_samples_to_stored_decimals(process_record(record, (), study.site))
        if study.site
        else record
        for record in records_or_ids
    ]
