"""The record table: which records there are, where they come from, and what is known about them."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from overturning.errors import ConfigError
from overturning.records.options import Unit
from overturning.tables import read_rows


def _numbers(value: Any) -> Any:
    return [part for part in value.replace(",", " ").split() if part] or None if isinstance(value, str) else value


def _moment(text: str) -> str:
    try:
        moment = datetime.fromisoformat(text) if len(text) > 10 else None
    except ValueError:
        moment = None
    if moment is None:
        raise ValueError("give date and time in UTC, like 2016-11-13T11:02:56")
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).astimezone(UTC).isoformat()


_Latitude = Annotated[float | None, Field(ge=-90, le=90, allow_inf_nan=False)]
_Longitude = Annotated[float | None, Field(ge=-180, le=180, allow_inf_nan=False)]


METADATA: Final[dict[str, tuple[str, str, str]]] = {
    "magnitude": ("magnitude", "magnitude of the earthquake", "1"),
    "rupture_distance": ("rupture_distance_km", "closest distance of the station to the rupture", "km"),
    "site_class": ("site_class", "site class", ""),
    "vs30": ("vs30_m_s", "mean shear-wave velocity of the upper 30 m", "m s-1"),
    "pulse_period": ("pulse_period_s", "period of the velocity pulse", "s"),
    "wall": ("wall", "side of the fault, hanging or foot (wall)", ""),
}
"""What a record is described by, for the statistics: column of the record table, long name, unit (empty: a word)."""


class RecordEntry(BaseModel):
    """One line of the record table."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    id: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]*$", description="Short name, lower case; names files too.")
    format: str = Field(default="auto", description="File format, or `auto` to go by the content; see docs/formats.md.")
    source: str = Field(
        min_length=1, description="Files in the data folder, or `set:id`, or a pulse, or `example:file`."
    )
    station: str = Field(default="", description="Name of the station; empty: as the file says.")
    event: str = Field(
        default="",
        description="Earthquake with its year; records that share it count as one unless their origin times differ.",
    )
    event_id: str = Field(
        default="",
        pattern=r"^\S{0,60}$",
        description="Any word that stands for the earthquake: decides which records are of one.",
    )
    origin_time: Annotated[str, AfterValidator(_moment)] = Field(
        default="", description="Of the earthquake, UTC (`2016-11-13T11:02:56`); empty: as the file says."
    )
    fault_strike_deg: float | None = Field(
        default=None,
        ge=0,
        lt=360.001,
        description="Strike of the fault, degrees clockwise from north; the normal is strike + 90.",
    )
    pulse: bool | None = Field(default=None, description="Whether the record has a velocity pulse.")
    magnitude: float | None = Field(default=None, ge=0, le=10, description="Magnitude of the earthquake.")
    rupture_distance_km: float | None = Field(
        default=None, ge=0, le=2000, description="Closest distance of the station to the rupture, km."
    )
    site_class: str = Field(
        default="", pattern=r"^\S{0,20}$", description="Site class, in the user's own scheme (`C`, `D`)."
    )
    vs30_m_s: float | None = Field(
        default=None, gt=30, le=5000, description="Mean shear-wave velocity of the upper 30 m, m/s."
    )
    pulse_period_s: float | None = Field(default=None, gt=0, le=60, description="Period of the velocity pulse, s.")
    wall: Literal["hanging", "foot"] | None = Field(
        default=None, description="Side of the fault: `hanging` or `foot` (wall); empty: neither, or not known."
    )
    station_latitude_deg: _Latitude = Field(
        default=None, description="Of the station, north positive, for the map; empty: as the file says."
    )
    station_longitude_deg: _Longitude = Field(default=None, description="Of the station, east positive.")
    epicentre_latitude_deg: _Latitude = Field(
        default=None, description="Of the epicentre, north positive; empty: as the file says."
    )
    epicentre_longitude_deg: _Longitude = Field(default=None, description="Of the epicentre, east positive.")
    orientation_correction_deg: float = Field(
        default=0.0,
        ge=-360,
        le=360,
        description="Added to the file's azimuths: misorientation of the sensor, clockwise.",
    )
    magnetic_declination_deg: float = Field(
        default=0.0,
        ge=-180,
        le=180,
        description="Added to azimuths that the file counts from magnetic north; east is positive.",
    )
    azimuths_deg: Annotated[
        tuple[float, float] | None,
        BeforeValidator(_numbers),
        Field(description="Azimuths of the two horizontal axes where the file does not state them, e.g. `0 90`."),
    ] = None
    unit: Unit | None = Field(default=None, description="Unit of the samples where the format leaves it open (SAC).")
    columns: str = Field(
        default="", description="Columns of a CSV file: `time:s north:gal east:gal up:gal`; `skip` passes one over."
    )
    sampling_interval_s: float | None = Field(
        default=None, gt=0, le=1, description="Of a CSV file without a time column, s."
    )
    processed: bool | None = Field(
        default=None,
        description="Whether the samples of a CSV or SAC file have been corrected already (`true`) or are raw (`false`).",
    )
    vertical_sense: Literal["up", "down", "none"] | None = Field(
        default=None,
        description="Which way a vertical axis points that does not say so (`Vert`); `none` leaves it out.",
    )
    sensor: Literal["surface", "borehole"] = Field(
        default="surface", description="`surface`, or `borehole`, whose motion is refused unless it is declared."
    )
    trust_data: bool = Field(
        default=False,
        description="Go on where header and data contradict each other, or the motion's size is none of a ground motion.",
    )
    sha256: str = Field(
        default="",
        pattern=r"^([0-9a-f]{64})?$",
        description="Expected SHA-256 of the record's file; empty: not checked.",
    )
    licence: str = Field(default="", description="Terms under which the data may be used.")

    @model_validator(mode="after")
    def _places_in_pairs(self) -> "RecordEntry":
        for place in ("station", "epicentre"):
            pair = [f"{place}_{name}_deg" for name in ("latitude", "longitude")]
            empty = [column for column in pair if getattr(self, column) is None]
            if len(empty) == 1:
                raise ValueError(f"column {empty[0]}: empty; give both {pair[0]} and {pair[1]}, or neither")
        return self

    @property
    def metadata(self) -> dict[str, Any]:
        """What the table says of the record for the statistics, by the names of `METADATA`; without what it leaves empty."""
        stated = {name: getattr(self, column) for name, (column, _, _) in METADATA.items()}
        return {name: value for name, value in stated.items() if value not in (None, "")}

    @property
    def azimuth_correction_deg(self) -> float:
        """What is added to the file's azimuths, degrees."""
        return self.orientation_correction_deg + self.magnetic_declination_deg


def read_catalogue(path: Path | str) -> dict[str, RecordEntry]:
    """Read a record table: tab-separated, one header line, empty cells for what is not known, ``#`` for comments.

    Returns
    -------
    dict of str to RecordEntry
        By id, in the table's order.

    Raises
    ------
    ConfigError
        Naming file, line, column and value: unknown or doubled columns, a doubled id, a value out of bounds.
    """
    path = Path(path)
    entries: dict[str, RecordEntry] = {}
    for line, entry in read_rows(path, RecordEntry, delimiter="\t", error=ConfigError, kind="record table"):
        if entry.id in entries:
            raise ConfigError(f"{path} line {line}: column id {entry.id!r}: it stands twice; ids must differ")
        entries[entry.id] = entry
    return entries
