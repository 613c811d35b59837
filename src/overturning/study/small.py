"""A small study in memory, without the workflow."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from overturning.records.processing import process
from overturning.records.read import read_record
from overturning.records.record import Record
from overturning.records.store import rounded
from overturning.study.cube import open_cube
from overturning.study.ensemble import draw_members
from overturning.study.gather import gather
from overturning.study.load import check_study, entries_of
from overturning.study.scenes import numerics_of
from overturning.study.sweep import sweep_record

if TYPE_CHECKING:
    import xarray as xr


def run_study(records: Sequence[Record | str], threads: int = 1, client: Any = None, **keys: Any) -> "xr.Dataset":
    """Run a study of a few records and return its cube, with its ensemble: the same numbers as the workflow's.

    Parameters
    ----------
    records : sequence of Record or str
        Records as `overturning.read` returns them, or ids of the record table.
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
    ConfigError
        If a key or value is wrong, or a record is not in the table.
    """
    names = [record if isinstance(record, str) else record.record_id for record in records]
    # The records themselves are given: the table is asked for those that are not.
    settings = {"name": "study", **keys, "records": {**keys.get("records", {}), "use": names}}
    study = check_study(settings, "run_study")
    asked = [record for record in records if isinstance(record, str)]
    only = study.model_copy(update={"records": study.records.model_copy(update={"use": tuple(asked)})})
    entries = entries_of(only, "run_study") if asked else {}
    used = [
        rounded(process(read_record(entries[record], Path(study.records.folder)), study.processing, study.site))
        if isinstance(record, str)
        else record
        for record in records
    ]
    numerics = numerics_of(study, threads, client=client)
    members = draw_members(study.ensemble) if study.ensemble.members else None
    with tempfile.TemporaryDirectory() as name:
        parts = [Path(name) / f"{index}.nc" for index in range(len(used))]
        for record, part in zip(used, parts, strict=True):
            sweep_record(study, record, part, members=members, numerics=numerics)
        gather(study, used, parts, Path(name) / "cube.nc")
        with open_cube(Path(name) / "cube.nc", element=None, amplitude=None) as cube:
            return cube.load()
