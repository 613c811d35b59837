"""Merge the files with simulated outcomes of chunks of cases into one results cube (NetCDF)."""

import json
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import cache, partial
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from overturning.dem.simulate import element_critical_angle_coordinate_or_none
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.model.grid import CaseGrid
from overturning.model.variables import INT8_MISSING, OutcomeVariable
from overturning.records.catalogue import (
    COLUMN_LONG_NAME_AND_UNIT_BY_METADATA_NAME,
    METADATA_KEYS_OF_FAULT_TRACE_AND_SOURCES,
)
from overturning.records.duplicates import refuse_duplicate_records
from overturning.records.earthquakes import assign_records_to_earthquakes
from overturning.records.record import Record, processing_peaks_and_notes_of_record
from overturning.study.load import study_settings_with_file_names_for_absolute_paths
from overturning.study.netcdf import (
    create_coordinate_variable,
    create_grid_dimensions_and_coordinates,
    create_outcome_variable,
    outcome_content_hash,
)
from overturning.study.parts import open_checked_outcome_file_for_reading, read_record_id_and_variant_of_outcome_file
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    StudyToSceneSizeConversion,
    note_on_different_stone_size_of_variant,
    variant_grid,
    variant_model,
    variant_uses_vertical_motion,
)
from overturning.study.schema import Study
from overturning.study.sweep import cube_variables_of_study

CF_CONVENTIONS_VERSION = "CF-1.11"
RECORD_COORDINATE_VARIABLE_NAMES = (
    *("record_id", "station", "event", "fault_normal", "pulse", "vertical"),
    *("station_latitude", "station_longitude", "epicentre_latitude", "epicentre_longitude"),
    *COLUMN_LONG_NAME_AND_UNIT_BY_METADATA_NAME,
)
"""Auxiliary coordinates of the dimension record."""

_PACKAGES_WITH_STORED_VERSIONS = ("overturning", "numba", "llvmlite", "numpy", "scipy", "obspy", "xarray", "netCDF4")
"""Packages that affect the numerical results; the cube lists their versions."""


def merge_outcome_files_into_cube(
    study: Study,
    records: Sequence[Record],
    sweep_part_paths: Sequence[Path],
    cube_path: Path,
    variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
) -> None:
    """Merge files with outcomes of records and chunks of cases into the results cube of a study or variant.

    Each file has cases of one record; the order of the files does not matter. At most one variable of one record is in
    memory. A `ResultError` is raised if a file belongs to another study or a case is in no file, a `ConfigError` if two
    records have the same samples.
    """
    from netCDF4 import Dataset

    refuse_duplicate_records(records)
    grid, variables = variant_grid(study, variant), cube_variables_of_study(study)
    of_record: dict[str, list[Path]] = {record.record_id: [] for record in records}
    for part in sweep_part_paths:
        name, of_variant = read_record_id_and_variant_of_outcome_file(part)
        if name not in of_record or of_variant != variant:
            raise ResultError(f"{part}: holds record {name}, variant {of_variant}, which are not in this study")
        of_record[name].append(part)
    with atomic_write(cube_path) as unfinished, Dataset(unfinished, "w", format="NETCDF4") as cube:
        create_cube_structure(cube, study, records, variant)
        cube.block_steps = 0
        whole = [
            _copy_record_outcomes_into_cube_if_complete(paths, cube, at, grid, variables)
            for at, paths in enumerate(of_record.values())
        ]
        if missing := [name for name, found in zip(of_record, whole, strict=True) if not found]:
            raise ResultError(
                f"{cube_path}: no part holds all cells of {', '.join(missing)}; run the sweep of these records again"
            )
        cube.content_sha256 = outcome_content_hash(cube, variables)


def create_cube_structure(
    cube: Any, study: Study, records: Sequence[Record], variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
) -> None:
    """Create the dimensions, coordinates, attributes and empty variables of a results cube in a netCDF4 file."""
    model, grid = variant_model(study, variant), variant_grid(study, variant)
    cube.setncatts(_global_cube_attributes(study, records, variant))
    cube.createDimension("record", len(records))
    _add_record_coordinate_variables(cube, records, variant_uses_vertical_motion(study, variant))
    create_grid_dimensions_and_coordinates(cube, grid)
    cube[model.direction_dimension_name].setncatts(model.azimuth_period_attribute_in_2d_or_empty)
    if said := note_on_different_stone_size_of_variant(study, variant):
        cube["height"].comment = cube["b_over_h"].comment = said
    own = StudyToSceneSizeConversion.for_variant(study, variant).scene_b_over_h_if_study_reference_differs
    sized = grid if own is None else grid.copy_with_dimension_values(b_over_h=np.full(grid["b_over_h"].size, own))
    # None for a single block, where it follows from B/H.
    if (critical := element_critical_angle_coordinate_or_none(model, sized)) is not None:
        dimensions, values, attributes = critical
        angles = cube.createVariable("critical_angle", "f8", dimensions, fill_value=np.nan)
        angles.setncatts(attributes)
        angles[:] = values
    for variable in cube_variables_of_study(study):
        names = ("element_name",) if "element" in grid.one_record_cube_dimensions_of_variable(variable) else ()
        create_outcome_variable(cube, variable, grid, "record").coordinates = " ".join(
            (*RECORD_COORDINATE_VARIABLE_NAMES, *names)
        )


def _copy_record_outcomes_into_cube_if_complete(
    sweep_part_paths: Sequence[Path],
    cube: Any,
    record_index: int,
    grid: CaseGrid,
    outcome_variables: Sequence[OutcomeVariable],
) -> bool:
    """Copy a record's outcomes from its files into a cube; return False, copying nothing, if a case is in no file."""
    with ExitStack() as stack:
        parts = [
            stack.enter_context(open_checked_outcome_file_for_reading(path, grid, outcome_variables))
            for path in sweep_part_paths
        ]
        filled = np.zeros(grid.shape, dtype=bool)
        for part in parts:
            filled[np.ix_(*part.study_grid_indices_by_dimension)] = True
        if not filled.all():
            return False
        cube.block_steps += sum(int(part.file.block_steps) for part in parts)
        for variable in outcome_variables:
            cells = np.full(
                grid.one_record_cube_shape_of_variable(variable), variable.fill_value_in_file, variable.dtype_in_file
            )
            for part in parts:
                part.copy_variable_into(variable.name, cells)
            cube[variable.name][record_index] = cells
    return True


def _add_record_coordinate_variables(cube: Any, records: Sequence[Record], uses_vertical_motion: bool) -> None:
    """Add coordinates of records, such as station and fault-normal azimuth, to a cube; unknown values are missing."""
    add = partial(create_coordinate_variable, cube, "record")
    add("record", "i4", range(len(records)), long_name="number of the record", units="1")
    for name, long_name, texts in (
        ("record_id", "identifier of the record", [record.record_id for record in records]),
        ("station", "station of the record", [record.station for record in records]),
        (
            "event",
            "earthquake of the record, one name for each earthquake",
            assign_records_to_earthquakes(records).earthquake_labels_in_record_order,
        ),
    ):
        add(name, str, texts, long_name=long_name)
    strikes = [record.fault_strike_deg for record in records]
    normals = [None if strike is None else (strike + 90.0) % 360.0 for strike in strikes]
    about = "azimuth of the fault normal, strike + 90 degrees"
    add("fault_normal", "f8", normals, np.nan, long_name=about, units="degree")
    _add_station_and_epicentre_coordinates(add, records)
    for name, (_, long_name, unit) in COLUMN_LONG_NAME_AND_UNIT_BY_METADATA_NAME.items():
        known = [record.extra.get(name) for record in records]
        if unit:
            add(name, "f8", known, np.nan, long_name=long_name, units=unit)
        else:
            add(name, str, [str(word or "") for word in known], long_name=long_name)
    missing, flag = np.int8(INT8_MISSING), {"units": "1", "flag_values": np.array([0, 1], dtype=np.int8)}
    for name, long_name, meanings, flags in (
        ("pulse", "whether the record has a velocity pulse", "no_pulse pulse", [r.extra.get("pulse") for r in records]),
        (
            *("vertical", "whether vertical motion was applied", "horizontal_only with_vertical"),
            [uses_vertical_motion and record.up is not None for record in records],
        ),
    ):
        add(name, "i1", flags, missing, long_name=long_name, **flag, flag_meanings=meanings)


def _add_station_and_epicentre_coordinates(
    add_record_coordinate_function: Callable[..., None], records: Sequence[Record]
) -> None:
    """Add latitude and longitude of stations and epicentres to a results cube."""
    for where, pairs in (
        ("station", [(record.latitude, record.longitude) for record in records]),
        ("epicentre", [(r.extra.get("event_latitude"), r.extra.get("event_longitude")) for r in records]),
    ):
        for index, (name, unit) in enumerate((("latitude", "degrees_north"), ("longitude", "degrees_east"))):
            # A location needs both coordinates.
            values = [None if None in pair else pair[index] for pair in pairs]
            said = {"standard_name": name, "long_name": f"{name} of the {where}", "units": unit}
            add_record_coordinate_function(f"{where}_{name}", "f8", values, np.nan, **said)


@cache
def _package_version(package_name: str) -> str:
    """Return the version of an installed package; cached, since reading it takes 2 ms."""
    return metadata.version(package_name)


def _global_cube_attributes(study: Study, records: Sequence[Record], variant: str) -> dict[str, str]:
    """Return the global attributes of a results cube: study, records, processing and software versions."""
    sources = [
        {"id": record.record_id, "source": record.source, "sha256": record.sha256, "licence": record.licence}
        | {name: record.extra[name] for name in METADATA_KEYS_OF_FAULT_TRACE_AND_SOURCES if name in record.extra}
        for record in records
    ]
    return {
        "Conventions": CF_CONVENTIONS_VERSION,
        "title": study.title or study.name,
        "institution": "overturning",
        "source": f"overturning {_package_version('overturning')}: "
        "distinct element simulation of a block on a moving base",
        # No time of day, so that equal runs give equal files.
        "history": f"gathered by overturning {_package_version('overturning')} from one sweep per record",
        "references": "see the documentation of overturning",
        "comment": variant_model(study, variant).overturned_variable_comment,
        "study": json.dumps(study_settings_with_file_names_for_absolute_paths(study), ensure_ascii=False),
        "variant": variant,
        "earthquakes": json.dumps(assign_records_to_earthquakes(records).notes, ensure_ascii=False),
        "record_sources": json.dumps(sources, ensure_ascii=False),
        "record_processing": json.dumps(
            {record.record_id: processing_peaks_and_notes_of_record(record) for record in records},
            ensure_ascii=False,
            default=str,
        ),
        "versions": json.dumps({name: _package_version(name) for name in _PACKAGES_WITH_STORED_VERSIONS}),
    }
