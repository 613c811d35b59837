"""Read and write ``motion.nc``, a record as one NetCDF file; the same record always gives the same bytes."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from overturning.errors import ResultError
from overturning.files import atomic_write, checksum_at_end_matches
from overturning.records.record import Record

STORED_ACCELERATION_DECIMALS = 9
"""Decimals of the stored samples, m/s²; rounding makes all results the same on every processor."""

MOTION_FILE_SCHEMA = "overturning motion 1"

_RECORD_TEXT_FIELD_NAMES = ("record_id", "start", "station", "event", "source", "sha256", "licence")
_OPTIONAL_NUMERIC_RECORD_FIELD_NAMES = ("fault_strike_deg", "latitude", "longitude")


def round_samples_to_stored_decimals(record: Record) -> Record:
    """Round the samples of a record to the precision of stored files, 1e-9 m/s².

    Negative zeros become zeros.
    """
    return record.with_changed_components(lambda samples: np.round(samples, STORED_ACCELERATION_DECIMALS) + 0.0)


def write_record_to_motion_file(record: Record, path: Path | str, unprocessed_record: Record | None = None) -> None:
    """Write a record to a NetCDF motion file (CF-1.11) atomically; create the folder if it is missing.

    With ``unprocessed_record``, the file also holds the record before its processing, for comparison.
    """
    import netCDF4

    record = round_samples_to_stored_decimals(record)
    with atomic_write(Path(path)) as part, netCDF4.Dataset(part, "w", format="NETCDF4") as file:
        file.setncatts(_record_netcdf_attributes(record))
        _write_record_time_series(file, record)
        if unprocessed_record is not None:
            file.sampling_interval_unprocessed = unprocessed_record.sampling_interval
            if unprocessed_record.start:
                file.start_unprocessed = unprocessed_record.start
            _write_record_time_series(
                file, round_samples_to_stored_decimals(unprocessed_record), "_unprocessed", ", before processing"
            )


def _write_record_time_series(
    netcdf_file: Any, record: Record, variable_name_suffix: str = "", long_name_suffix: str = ""
) -> None:
    """Write the times and components of a record as variables of an open NetCDF file."""
    netcdf_file.createDimension(f"time{variable_name_suffix}", record.north.size)
    time = np.arange(record.north.size) * record.sampling_interval
    for name, values, unit, long_name in (
        ("time", time, "s", "time after the start of the record"),
        ("north", record.north, "m s-2", "ground acceleration towards north"),
        ("east", record.east, "m s-2", "ground acceleration towards east"),
        ("up", record.up, "m s-2", "upward ground acceleration"),
    ):
        if values is not None:
            variable = netcdf_file.createVariable(
                f"{name}{variable_name_suffix}", "f8", (f"time{variable_name_suffix}",), zlib=True, shuffle=True
            )
            variable.setncatts({"long_name": long_name + long_name_suffix, "units": unit})
            variable[:] = values


def _record_netcdf_attributes(record: Record) -> dict[str, Any]:
    """Return the global NetCDF attributes of a stored record: metadata and processing."""
    attributes: dict[str, Any] = {
        "Conventions": "CF-1.11",
        "title": f"Ground motion {record.record_id}",
        "schema": MOTION_FILE_SCHEMA,
        "sampling_interval": record.sampling_interval,
    }
    attributes |= {name: getattr(record, name) for name in _RECORD_TEXT_FIELD_NAMES if getattr(record, name)}
    attributes |= {
        name: float(getattr(record, name))
        for name in _OPTIONAL_NUMERIC_RECORD_FIELD_NAMES
        if getattr(record, name) is not None
    }
    if record.component_azimuths_deg:
        attributes["component_azimuths_deg"] = np.array(record.component_azimuths_deg, dtype=np.float64)
    attributes["processing"] = json.dumps(list(record.processing), ensure_ascii=False)
    attributes["extra"] = json.dumps(record.extra, sort_keys=True, ensure_ascii=False)
    return attributes


def read_record_from_motion_file(path: Path | str) -> Record:
    """Read a record from a NetCDF motion file; a ResultError if it is missing, damaged or of another kind."""
    return _read_stored_record(Path(path), "")


def read_record_before_processing_if_processed(path: Path | str) -> Record | None:
    """Read the record before processing from a NetCDF motion file; None if the record was not processed."""
    import netCDF4

    read_record_from_motion_file(path)
    with netCDF4.Dataset(path) as file:
        there = "north_unprocessed" in file.variables
    return replace(_read_stored_record(Path(path), "_unprocessed"), processing=()) if there else None


def _read_stored_record(path: Path, variable_name_suffix: str) -> Record:
    """Read a record from a NetCDF motion file; the suffix of variable names selects it processed or unprocessed."""
    import netCDF4

    if path.is_file() and not checksum_at_end_matches(path):
        raise ResultError(
            f"{path}: damaged, or not a {MOTION_FILE_SCHEMA!r} file; run the study again, which writes it again"
        )
    try:
        with netCDF4.Dataset(path) as file:
            attributes = {name: file.getncattr(name) for name in file.ncattrs()}
            if attributes.get("schema") != MOTION_FILE_SCHEMA:
                raise ResultError(
                    f"{path}: not a {MOTION_FILE_SCHEMA!r} file; run the study again, which writes it again"
                )
            samples = {
                name: np.asarray(file[name + variable_name_suffix][:].filled(np.nan), dtype=np.float64)
                for name in ("north", "east", "up")
                if name + variable_name_suffix in file.variables
            }
            attributes |= {"start": attributes.get("start_unprocessed", "")} if variable_name_suffix else {}
            fields: dict[str, Any] = {
                name: str(attributes[name]) for name in _RECORD_TEXT_FIELD_NAMES if name in attributes
            }
            fields |= {
                name: float(attributes[name]) for name in _OPTIONAL_NUMERIC_RECORD_FIELD_NAMES if name in attributes
            }
            azimuths = np.atleast_1d(attributes.get("component_azimuths_deg", ()))
            return Record(
                north=samples["north"],
                east=samples["east"],
                up=samples.get("up"),
                sampling_interval=float(attributes[f"sampling_interval{variable_name_suffix}"]),
                component_azimuths_deg=tuple(float(a) for a in azimuths),
                processing=tuple(json.loads(attributes["processing"])),
                extra=json.loads(attributes["extra"]),
                **fields,
            )
    except FileNotFoundError:
        raise ResultError(f"{path}: no such file; run the study, or the rule that reads records") from None
    except (OSError, KeyError, IndexError, ValueError, RuntimeError) as problem:
        if isinstance(problem, ResultError):
            raise
        raise ResultError(f"{path}: damaged ({problem}); run the study again, which writes it again") from problem
