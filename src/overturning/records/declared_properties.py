"""Properties of record files that the files do not state: in the record table, on the command line and in Python."""

from collections.abc import Iterable
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, BeforeValidator, Field, model_validator

from overturning.records.source import SourceFile
from overturning.units import ACCELERATION_UNITS_IN_M_S2
from overturning.validation import make_constructor_raise_argument_errors

AccelerationUnit = Literal["m/s2", "cm/s2", "gal", "mm/s2", "nm/s2", "g", "mg"]
SensorPosition = Literal["surface", "borehole"]
VerticalSense = Literal["up", "down", "none"]

assert set(ACCELERATION_UNITS_IN_M_S2) == set(get_args(AccelerationUnit))


_BoundedAngleDeg = Annotated[float, Field(ge=-540, le=540)]


def _split_text_of_numbers(text_or_value: Any) -> Any:
    """Split a text of numbers, such as "0,90", at commas and blanks; None if empty. Other values are unchanged."""
    return (
        [part for part in text_or_value.replace(",", " ").split() if part] or None
        if isinstance(text_or_value, str)
        else text_or_value
    )


class FilePropertiesInTableRow(
    BaseModel, extra="forbid", frozen=True, use_attribute_docstrings=True, allow_inf_nan=False
):
    """Properties of record files, such as unit and azimuths, that a user can give in the record table or as options."""

    format: Annotated[str, BeforeValidator(lambda name: "auto" if name is None else name)] = "auto"
    """The only accepted file format, or `auto` to detect it from the content; see docs/formats.md."""
    azimuths_deg: Annotated[
        tuple[_BoundedAngleDeg, _BoundedAngleDeg] | None, BeforeValidator(_split_text_of_numbers)
    ] = None
    """Azimuths of the two horizontal axes, if the file does not state them, e.g. `0,90`."""
    unit: AccelerationUnit | None = None
    """Unit of the samples, if the format does not state it (SAC): `m/s2`, `gal`, `g`…"""
    columns: str = ""
    """Columns of a CSV file: `time:s north:gal east:gal up:gal`; `skip` omits one. By file: `x_n.txt=north:gal`…"""
    sampling_interval_s: float | None = Field(default=None, gt=0, le=1)
    """Sampling interval of a CSV file without a time column, s."""
    processed: bool | None = None
    """Samples of a CSV or SAC file: corrected already (`true`) or raw (`false`)."""
    vertical_sense: VerticalSense | None = None
    """Sense of a vertical axis that does not state it (`Vert`): `up` or `down`; `none` omits the vertical axis."""
    sensor: SensorPosition | None = None
    """`surface` (default) or `borehole`; motion of a borehole is refused unless declared."""
    trust_data: bool = False
    """Accept contradictions of header and data, and amplitudes that are implausible for a ground motion."""


@make_constructor_raise_argument_errors
class DeclaredFileProperties(FilePropertiesInTableRow, frozen=True):
    """Properties of record files that the user gives because the files do not state them, or state them wrongly.

    An `ArgumentError` is raised if a property is invalid.
    """

    correction_deg: _BoundedAngleDeg = 0.0
    """Angle that is added to the azimuths of the axes: misorientation plus magnetic declination, clockwise, degrees."""
    stationxml_files: tuple[SourceFile, ...] = ()
    """StationXML files for MiniSEED or SAC files."""

    @model_validator(mode="after")
    def _refuse_columns_unless_csv(self) -> "DeclaredFileProperties":
        """Raise a ValueError if columns are given for another format than CSV."""
        if self.columns and self.format not in ("auto", "csv"):
            raise ValueError(f"columns: only csv has them, the format is {self.format!r}; leave out one of both")
        return self

    @property
    def declared_sample_property_texts(self) -> list[str]:
        """Properties of the samples that the user gives, such as the unit, as texts for the report."""
        words = [f"columns {self.columns}"] if self.columns else [f"unit {self.unit}"] if self.unit else []
        return words + {True: ["processed"], False: ["raw"], None: []}[self.processed]

    @property
    def declared_axis_property_texts(self) -> list[str]:
        """Properties of all axes of an instrument, given by the user (rotation, sense of the vertical), as texts."""
        words = [f"axes turned by {self.correction_deg:g}°"] if self.correction_deg else []
        return words + ([f"vertical {self.vertical_sense}"] if self.vertical_sense else [])

    def with_station_xml_from_files(self, source_files: Iterable[SourceFile]) -> "DeclaredFileProperties":
        """Return a copy of the properties to which the StationXML files among ``source_files`` are added."""
        found = [file for file in source_files if b"FDSNStationXML" in file.data[:2000]]
        return self.model_copy(update={"stationxml_files": (*self.stationxml_files, *found)})
