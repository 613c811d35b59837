"""A record from files, ready to be used: read, checked, processed."""

import inspect
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from overturning.errors import ArgumentError
from overturning.records.processing import process
from overturning.records.read import read_path
from overturning.records.record import Record
from overturning.records.source import ReadOptions
from overturning.records.steps import Step
from overturning.records.store import rounded


def read(
    paths: Path | str | Sequence[Path | str], *, processing: Sequence[Step] | None = None, **declarations: Any
) -> Record:
    """Read a record from a file, an archive, or several files that belong together, processed as a study does it.

    Parameters
    ----------
    paths : path or sequence of paths
        One file (others of the same record beside it are found), or the files of one sensor; the format goes by content.
    processing : sequence of steps, optional
        By kind of file where not given: what its agency has processed is left alone.
    **declarations
        What the files do not state: ``unit`` ("gal", "g", …), ``columns`` ("time:s north:gal east:gal up:gal"),
        ``sampling_interval_s``, ``processed`` (columns do not say it), ``azimuths_deg`` of the two horizontal axes,
        ``sensor`` ("surface", "borehole"), ``trust_data``; and ``record_id``.

    Returns
    -------
    Record
        Accelerations towards north, east and up, m/s²; `Motion.from_record` makes it a motion.

    Raises
    ------
    MissingDataError, RecordError
        If a file is missing, of no known format, damaged, or contradicts itself.
    """
    of_reader = {field.name for field in fields(ReadOptions)} - {"metadata"}
    known = of_reader | set(inspect.signature(read_path).parameters) - {"path", "options"}
    if unknown := sorted(declarations.keys() - known):
        raise ArgumentError(f"{unknown[0]}: no declaration of a record; known are {', '.join(sorted(known))}")
    options = ReadOptions(**{name: declarations.pop(name) for name in sorted(of_reader & declarations.keys())})
    record = read_path(paths, options=options, **declarations)
    return rounded(process(record, None if processing is None else tuple(processing)))
