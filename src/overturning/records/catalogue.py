"""Record table: records, their metadata, and the location of their files."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import AfterValidator, BaseModel, Field, model_validator

from overturning.errors import ConfigError, MissingDataError
from overturning.records.declared_properties import DeclaredFileProperties, FilePropertiesInTableRow
from overturning.records.fault_trace import checked_fault_trace_text
from overturning.records.source import SourceFile, has_non_record_name, read_source_file, unpack_archive
from overturning.tables import read_table_rows


def convert_to_utc_text(time_text: str) -> str:
    """Return an ISO 8601 date and time as text in UTC (the default zone); raise a ValueError for any other text."""
    try:
        moment = datetime.fromisoformat(time_text) if len(time_text) > 10 else None
    except ValueError:
        moment = None
    if moment is None:
        raise ValueError("give date and time in UTC, like 2016-11-13T11:02:56")
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).astimezone(UTC).isoformat()


_LatitudeDeg = Annotated[float | None, Field(ge=-90, le=90, allow_inf_nan=False)]
_LongitudeDeg = Annotated[float | None, Field(ge=-180, le=180, allow_inf_nan=False)]


COLUMN_LONG_NAME_AND_UNIT_BY_METADATA_NAME: Final[dict[str, tuple[str, str, str]]] = {
    "magnitude": ("magnitude", "magnitude of the earthquake", "1"),
    "rupture_distance": ("rupture_distance_km", "closest distance of the station to the rupture", "km"),
    "site_class": ("site_class", "site class", ""),
    "vs30": ("vs30_m_s", "mean shear-wave velocity of the upper 30 m", "m s-1"),
    "pulse_period": ("pulse_period_s", "period of the velocity pulse", "s"),
    "wall": ("wall", "side of the fault, hanging or foot (wall)", ""),
}
"""Metadata of a record for the statistics: column of the record table, long name, unit ("" for text)."""


class RecordDescriptionInTableRow(BaseModel, extra="forbid", frozen=True, use_attribute_docstrings=True):
    """Columns of the table of records that identify a record and describe its earthquake, station and site."""

    id: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,99}$")
    """Short name in lower case; also used in file names."""
    source: str = Field(min_length=1)
    """Files in the data folder, `set:id`, a pulse, or `example:file`."""
    station: str = ""
    """Name of the station; empty: as stated in the file."""
    event: str = ""
    """Earthquake with its year; records of one name are of one earthquake unless their origin times differ."""
    event_id: str = Field(default="", pattern=r"^\S{0,60}$")
    """Identifier of the earthquake; records with the same one are of one earthquake."""
    origin_time: Annotated[str, AfterValidator(convert_to_utc_text)] = ""
    """Origin time of the earthquake, UTC (`2016-11-13T11:02:56`); empty: as stated in the file."""
    fault_strike_deg: float | None = Field(default=None, ge=0, lt=360.001)
    """Strike of the fault, degrees clockwise from north; the normal is strike + 90."""
    pulse: bool | None = None
    """True for a record with a velocity pulse."""
    magnitude: float | None = Field(default=None, ge=0, le=10)
    """Magnitude of the earthquake."""
    rupture_distance_km: float | None = Field(default=None, ge=0, le=2000)
    """Closest distance of the station to the rupture, km."""
    site_class: str = Field(default="", pattern=r"^\S{0,20}$")
    """Site class, in the user's own scheme (`C`, `D`)."""
    vs30_m_s: float | None = Field(default=None, gt=30, le=5000)
    """Mean shear-wave velocity of the upper 30 m, m/s."""
    pulse_period_s: float | None = Field(default=None, gt=0, le=60)
    """Period of the velocity pulse, s."""
    wall: Literal["hanging", "foot"] | None = None
    """Side of the fault: `hanging` or `foot` (wall); empty: neither, or unknown."""
    station_latitude_deg: _LatitudeDeg = None
    """Latitude of the station, north positive; empty: as stated in the file."""
    station_longitude_deg: _LongitudeDeg = None
    """Longitude of the station, east positive."""
    epicentre_latitude_deg: _LatitudeDeg = None
    """Latitude of the epicentre, north positive; empty: as stated in the file."""
    epicentre_longitude_deg: _LongitudeDeg = None
    """Longitude of the epicentre, east positive."""
    coordinates_source: str = Field(default="", max_length=300)
    """Publication or catalogue of the coordinates in this line; without it the station is left off the map."""
    fault_trace: Annotated[str, AfterValidator(checked_fault_trace_text)] = ""
    """Trace of the fault, latitude and longitude: `40.71 29.34, 40.73 29.52`; pieces are separated by semicolons."""
    fault_trace_source: str = Field(default="", max_length=300)
    """Publication or catalogue of the fault trace; required if a trace is given."""
    licence: str = ""
    """Terms under which the data may be used."""

    @model_validator(mode="after")
    def _check_coordinate_pairs_and_fault_trace_source(self) -> "RecordDescriptionInTableRow":
        """Raise a ValueError for a latitude without longitude (or the reverse) or a fault trace without source."""
        for place in ("station", "epicentre"):
            pair = [f"{place}_{name}_deg" for name in ("latitude", "longitude")]
            empty = [column for column in pair if getattr(self, column) is None]
            if len(empty) == 1:
                raise ValueError(f"column {empty[0]}: empty; give both {pair[0]} and {pair[1]}, or neither")
        if self.fault_trace and not self.fault_trace_source:
            raise ValueError("column fault_trace_source: empty; name the publication or catalogue of fault_trace")
        return self

    @property
    def coordinate_source_and_fault_trace_metadata(self) -> dict[str, str]:
        """Fault trace of the record's earthquake, and sources of trace and coordinates, if the table states them.

        The key ``coordinates_source`` exists (its text may be empty) if the row of the record states coordinates.
        """
        columns = ("station_latitude_deg", "epicentre_latitude_deg")
        source = {"coordinates_source": self.coordinates_source}
        trace = {"fault_trace": self.fault_trace, "fault_trace_source": self.fault_trace_source}
        stated = any(getattr(self, column) is not None for column in columns)
        return (source if stated else {}) | (trace if self.fault_trace else {})

    @property
    def metadata_for_statistics(self) -> dict[str, Any]:
        """Known values of the record that statistics use, such as the magnitude, by their name in the cube."""
        stated = {
            name: getattr(self, column) for name, (column, _, _) in COLUMN_LONG_NAME_AND_UNIT_BY_METADATA_NAME.items()
        }
        return {name: value for name, value in stated.items() if value not in (None, "")}


METADATA_KEYS_OF_FAULT_TRACE_AND_SOURCES: Final = ("coordinates_source", "fault_trace", "fault_trace_source")
"""Entries of a record's ``extra`` that the cube stores.

See `RecordTableRow.coordinate_source_and_fault_trace_metadata`.
"""

COLUMNS_NOT_AFFECTING_SAMPLES: Final = tuple(
    name for name in RecordDescriptionInTableRow.model_fields if name not in ("id", "source")
)
"""Columns that do not affect the samples of a record: if one of them changes, no simulation is repeated."""


class RecordTableRow(FilePropertiesInTableRow, RecordDescriptionInTableRow, frozen=True):
    """Row of the record table: one record, its metadata, and properties that its files do not state."""

    orientation_correction_deg: float = Field(default=0.0, ge=-360, le=360)
    """Angle added to the azimuths in the file: misorientation of the sensor, degrees clockwise."""
    magnetic_declination_deg: float = Field(default=0.0, ge=-180, le=180)
    """Angle added to azimuths that the file states relative to magnetic north, degrees; east is positive."""
    sha256: str = Field(default="", pattern=r"^([0-9a-f]{64})?$")
    """Expected SHA-256 of the record's file; empty: not checked."""

    def copy_with_descriptive_columns_reset(self) -> "RecordTableRow":
        """Return a copy of the row in which all `COLUMNS_NOT_AFFECTING_SAMPLES` have their defaults."""
        return self.model_copy(
            update={name: RecordTableRow.model_fields[name].default for name in COLUMNS_NOT_AFFECTING_SAMPLES}
        )

    @property
    def declared_file_properties(self) -> DeclaredFileProperties:
        """Properties of the record's files that the user gives in this table row, such as unit and azimuths."""
        return DeclaredFileProperties(
            correction_deg=self.orientation_correction_deg + self.magnetic_declination_deg,
            **self.model_dump(include={*FilePropertiesInTableRow.model_fields}),
        )

    @property
    def names_of_filled_file_property_columns(self) -> list[str]:
        """Names of filled columns that describe files; a synthetic pulse, which has no file, must have none."""
        other = {*RecordDescriptionInTableRow.model_fields, "format", "trust_data", "sha256"}
        stated = self.model_dump(exclude=other, exclude_defaults=True)
        return [name for name, value in stated.items() if value != "surface"]


def read_record_table(path: Path | str) -> dict[str, RecordTableRow]:
    """Read a table of records; return its rows by record id, in the order of the table.

    The table is tab-separated with one header line and ``#`` for comments; an empty cell means unknown. An unknown or
    repeated column, a repeated id or a value out of bounds raises a `ConfigError` that names file, line, column and
    value.
    """
    path = Path(path)
    entries: dict[str, RecordTableRow] = {}
    for line, entry in read_table_rows(
        path, RecordTableRow, delimiter="\t", error_class=ConfigError, table_kind="record table"
    ):
        if entry.id in entries:
            raise ConfigError(f"{path} line {line}: column id {entry.id!r}: it occurs twice; ids must differ")
        entries[entry.id] = entry
    return entries


SOURCE_PREFIX_OF_PACKAGED_EXAMPLE: Final = "example:"
"""Prefix of a file that is part of the package (`records/examples`)."""


def paths_of_record_files(table_row: RecordTableRow, data_dir: Path) -> list[Path]:
    """Return the paths of the files of a record; [] for records of FEMA P-695, which are read from one archive."""
    return (
        []
        if table_row.format == "fema-p695"
        else [path for _, path in _find_files_named_in_source_column(table_row, data_dir)]
    )


def read_record_files(table_row: RecordTableRow, data_dir: Path) -> list[SourceFile]:
    """Read the files of a record, named in its column ``source``: in full, by stem (``STEM.*``) or in an archive."""
    files: list[SourceFile] = []
    for word, path in _find_files_named_in_source_column(table_row, data_dir):
        file = read_source_file(path)
        within = _has_archive_extension(path) and not path.name.startswith(word)
        files += _archive_members_with_stem(file, word) if within else [file]
    return files


def _find_files_named_in_source_column(table_row: RecordTableRow, data_dir: Path) -> list[tuple[str, Path]]:
    """Find the file or archive for each name in the column ``source`` of a record; return pairs of name and path.

    Raises a MissingDataError for names without a file; otherwise a record whose vertical component is missing would be
    read as one with two components.
    """
    archives = [path for path in _sorted_matching_files(data_dir, "*") if _has_archive_extension(path)]
    located: list[tuple[str, Path]] = []
    missing: list[str] = []
    for word in table_row.source.split():
        if word.startswith(SOURCE_PREFIX_OF_PACKAGED_EXAMPLE):
            located.append(
                (
                    word.removeprefix(SOURCE_PREFIX_OF_PACKAGED_EXAMPLE),
                    _example_zip_path(table_row, word.removeprefix(SOURCE_PREFIX_OF_PACKAGED_EXAMPLE)),
                )
            )
            continue
        named = [data_dir / word] if (data_dir / word).is_file() else []
        matching = [path for path in _sorted_matching_files(data_dir, f"{word}.*") if not has_non_record_name(path)]
        plain = [path for path in matching if not _has_archive_extension(path)]
        holding = (
            named
            or plain
            or matching[:1]
            or [a for a in archives if _archive_members_with_stem(read_source_file(a), word)][:1]
        )
        located += [(word, path) for path in holding]
        missing += [] if holding else [word]
    if missing:
        raise _missing_record_files_error(table_row, data_dir, missing)
    return located


def _example_zip_path(table_row: RecordTableRow, example_name: str) -> Path:
    """Return the path of an example record's zip file in the package; raise a MissingDataError for an unknown name."""
    folder = Path(__file__).parent / "examples"
    path = folder / f"{example_name}.zip"
    if not path.is_file():
        known = ", ".join(file.stem for file in _sorted_matching_files(folder, "*.zip"))
        raise MissingDataError(
            f"record {table_row.id}: no example {example_name!r} comes with the package; there is {known}"
        )
    return path


def _sorted_matching_files(folder: Path, glob_pattern: str) -> list[Path]:
    """Return the files in a folder whose names match a glob pattern, in order; [] if the folder is missing."""
    return sorted(path for path in folder.glob(glob_pattern) if path.is_file()) if folder.is_dir() else []


def _has_archive_extension(path: Path) -> bool:
    """Return True if a file has the extension of a zip or tar archive."""
    return path.name.lower().endswith((".tar", ".tar.gz", ".tgz", ".tar.bz2", ".zip"))


def _archive_members_with_stem(archive_file: SourceFile, file_stem: str) -> list[SourceFile]:
    """Return the members of an archive whose name is `file_stem`, or `file_stem` with any extension."""
    return [m for m in unpack_archive(archive_file) if m.name == file_stem or m.name.startswith(f"{file_stem}.")]


def _missing_record_files_error(
    table_row: RecordTableRow, data_dir: Path, missing_source_names: list[str]
) -> MissingDataError:
    """Return an error that names the missing files of a record, the folder searched, and how to get the files."""
    which, remedy = f"{' '.join(missing_source_names)} is", "put the file there, or name the folder in the config"
    if table_row.format in ("k-net", "kik-net"):
        remedy = (
            "download them from NIED's K-NET and KiK-net (www.kyoshin.bosai.go.jp, free account) and put them into "
            "that folder: they may not be redistributed"
        )
    if table_row.format in ("k-net", "kik-net") and "." not in table_row.source:
        # File extensions of KiK-net end with the number of the sensor.
        number = (
            {"surface": "2", "borehole": "1"}[table_row.sensor or "surface"] if table_row.format == "kik-net" else ""
        )
        which = ", ".join(f"{table_row.source}.{axis}{number}" for axis in ("NS", "EW", "UD"))
        which += " (or the archive that holds them) are"
    return MissingDataError(f"record {table_row.id}: {which} not in {data_dir}; {remedy}")
