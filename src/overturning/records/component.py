"""Component of a record: samples and metadata of one sensor axis; and names of axes as networks write them."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.motion.direction import angle_between_azimuths
from overturning.records.axis_direction import AzimuthAndVerticalSense
from overturning.records.declared_properties import SensorPosition
from overturning.records.source import SourceFile


def find_vertical_by_elimination(components: "Sequence[RecordComponent]") -> "RecordComponent | None":
    """Return which of three components is vertical because the other two are horizontal; None if this is unclear.

    Either the other two have azimuths near a right angle, or the three names differ only in the numbers 1, 2 and 3, and
    the vertical one has the 3 (``HN3``).
    """
    unknown = [c for c in components if c.azimuth_deg is None and not c.vertical_sense]
    if len(components) != 3 or any(c.vertical_sense for c in components):
        return None
    first, second, *_ = [c.azimuth_deg for c in components if c.azimuth_deg is not None] + [0.0, 0.0]
    if len(unknown) == 1:
        return unknown[0] if abs(math.sin(math.radians(second - first))) >= MIN_SINE_BETWEEN_HORIZONTAL_AXES else None
    by_name = {c.axis_name_in_file.strip().upper(): c for c in unknown}
    third = next((name for name in by_name if name.endswith("3")), "")
    return by_name[third] if set(by_name) == {third[:-1] + number for number in "123"} else None


MIN_SINE_BETWEEN_HORIZONTAL_AXES: Final = 0.9
"""Smallest sine of the angle between two horizontal axes that can be rotated to north and east."""


def normalise_coordinates(latitude_deg: float | None, longitude_deg: float | None) -> tuple[float | None, float | None]:
    """Return latitude and longitude, degrees, with the longitude within ±180°; (None, None) for invalid values.

    A longitude counted from 0 to 360° is converted. An unknown latitude or longitude, None, is returned unchanged.
    """
    if latitude_deg is None or longitude_deg is None:
        return latitude_deg, longitude_deg
    if not (abs(latitude_deg) <= 90.0 and -180.0 <= longitude_deg <= 360.0):  # NaN fails the comparisons too.
        return None, None
    return latitude_deg, longitude_deg - 360.0 if longitude_deg > 180.0 else longitude_deg


HEADER_PEAK_RELATIVE_TOLERANCE = 0.005
"""Largest relative difference between the peaks of header and data, 0.5 %."""

MAX_SURFACE_SENSOR_DEPTH_M = 3.0
"""Largest depth of a surface sensor, m: vaults, piers and posts in the soil."""


def classify_as_borehole_or_else_surface(
    sensor_depth_m: float | None = None, location_text: str = ""
) -> SensorPosition:
    """Return "borehole" for a sensor deeper than 3 m, or called so in the text on its location; else "surface"."""
    size = r"(\d+(?:\.\d+)?)\s*(m|ft|feet)\b"
    for pattern in (
        rf"depth\D{{0,5}}{size}",
        rf"{size}\.?\s*(?:deep|depth|below(?! +(?:the +)?(?:deck|roof|top|girder|crest)))",
    ):
        if stated := re.search(pattern, location_text, re.IGNORECASE):
            sensor_depth_m = float(stated[1]) * (1.0 if stated[2].lower() == "m" else 0.3048)
    named = re.search(r"\b(down|bore)[- ]?hole\b", location_text, re.IGNORECASE)
    is_deep = sensor_depth_m is not None and sensor_depth_m > MAX_SURFACE_SENSOR_DEPTH_M
    return "borehole" if named or is_deep else "surface"


_TALL_STRUCTURE_PATTERN: Final = "(pier|column|tower|pylon|tank|bent|arch|chimney|mast)"

_RAISED_SENSOR_LOCATION_PATTERN: Final = re.compile(
    r"\b(roof|penthouse|attic|mezzanine|deck|crest|girder|parapet|gallery|mid-?height|level +([2-9]|[1-9]\d)\b|"
    r"(second|third|fourth|fifth|[2-9](nd|rd|th)|[1-9]\d(st|nd|rd|th)) +(fl|level|stor)|"
    rf"{_TALL_STRUCTURE_PATTERN}\b[^,;]*\b(top|cap)\b|top +of +(the +)?{_TALL_STRUCTURE_PATTERN}\b)",
    re.IGNORECASE,
)


def sensor_location_in_header_line(header_line: str) -> str:
    """Return the location of a sensor that a header line states; "" if it states none."""
    found = re.search(r"\bLocation:\s*(.*)", header_line, re.IGNORECASE)
    return " ".join(found[1].split()) if found else ""


def note_on_sensor_high_in_structure(sensor_location: str) -> str:
    """Return a note if a sensor is located high up in a building or other structure; "" for any other location."""
    return (
        f"a sensor at {sensor_location!r} has the motion of a structure, not of the ground"
        if _RAISED_SENSOR_LOCATION_PATTERN.search(sensor_location)
        else ""
    )


@dataclass(frozen=True)
class PeakStatedInFileHeader:
    """Peak acceleration of a component according to its file header, with resolution and line number."""

    absolute_acceleration: float  # m/s²
    resolution_of_printed_peak: float = 0.0  # unit of the last printed digit, m/s²; the comparison allows half of it
    is_after_mean_removal: bool = False  # True if it is the peak after subtraction of the mean
    line_number: int | None = None  # line of the file with the peak, counted from 1
    sign: int = 0  # of the sample with the peak, +1 or −1; 0 if the header does not state it

    @classmethod
    def from_signed_acceleration(
        cls, signed_acceleration_m_s2: float, last_digit_unit_to_peak_ratio: float, line_number: int | None = None
    ) -> "PeakStatedInFileHeader":
        """Create a header peak from a signed acceleration, m/s², and the ratio last printed digit's unit / peak."""
        sign, peak = (signed_acceleration_m_s2 > 0) - (signed_acceleration_m_s2 < 0), abs(signed_acceleration_m_s2)
        return cls(peak, last_digit_unit_to_peak_ratio * peak, line_number=line_number, sign=sign)


@dataclass(frozen=True)
class RecordComponent:
    """Acceleration along one axis of one sensor, as read from its file."""

    acceleration: FloatArray  # samples, m/s², positive along the axis, shape (n,)
    sampling_interval: float  # s
    axis_name_in_file: str  # as the file writes it (``N28W``, ``NS2``, ``--L``)
    azimuth_deg: float | None  # of the axis, degrees clockwise from north; None for a vertical or an unknown axis
    vertical_sense: int  # +1 where the axis points up, −1 where it points down, 0 for a horizontal or an unknown axis
    file_name: str  # name of the file, without its folder
    sha256: str  # of the file
    format_name: str = ""  # name in the table of formats
    start_time_utc: datetime | None = None  # time of the first sample, UTC
    station: str = ""
    event: str = ""
    origin_time_utc: datetime | None = None  # of the earthquake
    station_latitude_deg: float | None = None
    station_longitude_deg: float | None = None
    header_peak: PeakStatedInFileHeader | None = None
    sensor_position: SensorPosition = "surface"
    sensor_location: str = ""  # location of the sensor at its station: text of the file, or a SEED code
    is_already_corrected: bool = False  # True for corrected data, which the default processing does not change
    unit_declared_if_format_states_none: str = (
        ""  # unit of the samples that the user declares, if the format states none
    )
    is_digitised_from_analogue_film: bool = False  # digitised from film; its traces may end at different times
    shared_key_of_record_files: str = ""  # key that declared files of one record share
    extra_metadata: Mapping[str, Any] = field(default_factory=dict)  # other metadata of the file
    notes: tuple[str, ...] = ()  # notes for the user on how it was read

    @classmethod
    def from_file(
        cls, source_file: SourceFile, axis_name_in_file: str, direction: AzimuthAndVerticalSense,
        acceleration: FloatArray,
        sampling_interval: float, *, station_latitude_longitude_deg: tuple[float | None, float | None] = (None, None),
        **other_fields: Any,
    ) -> "RecordComponent":  # fmt: skip
        """Create a component from the samples along one axis of a file; ``direction`` is azimuth and vertical sense.

        Station longitudes above 180° become negative. Impossible coordinates are left out, with a note.
        """
        latitude, longitude = normalise_coordinates(*station_latitude_longitude_deg)
        if latitude is None and None not in station_latitude_longitude_deg:
            place = "latitude {:g}° and longitude {:g}°".format(*station_latitude_longitude_deg)
            why = (
                f"{place} in the header are no place on the globe; give station_latitude_deg and station_longitude_deg"
            )
            other_fields["notes"] = (
                *other_fields.get("notes", ()), f"{source_file.name}: station left off the map: {why}",
            )  # fmt: skip
        other_fields |= {"station_latitude_deg": latitude, "station_longitude_deg": longitude}
        return cls(
            acceleration,
            sampling_interval,
            axis_name_in_file,
            *direction,
            source_file.name,
            source_file.sha256,
            **other_fields,
        )

    def __post_init__(self) -> None:
        bad = np.flatnonzero(~np.isfinite(self.acceleration))
        if bad.size:
            what = f"sample {int(bad[0])} of {self.axis_name_in_file} is not a number"
            raise RecordError(f"{self.file_name}: {what}; repair the file or leave it out")
        if self.acceleration.size < 2:
            count = f"{self.acceleration.size} samples along {self.axis_name_in_file}"
            raise RecordError(f"{self.file_name}: {count}; a record needs at least 2")
        if not (np.isfinite(self.sampling_interval) and 1e-5 <= self.sampling_interval <= 1.0):
            what = f"sampling interval {self.sampling_interval:g} s; 0.00001 to 1 s is what accelerographs have"
            raise RecordError(f"{self.file_name}: {what}: correct the header")


def _samples_for_header_peak_comparison(component: RecordComponent) -> FloatArray:
    """Return samples, m/s², to compare with the header's peak, less their mean if the header's peak is without it."""
    samples, stated = component.acceleration, component.header_peak
    return samples - samples.mean() if stated is not None and stated.is_after_mean_removal else samples


def peak_acceleration_comparable_to_header(component: RecordComponent) -> float:
    """Return a component's peak acceleration, m/s², without its mean if the header's peak was computed without it."""
    return float(np.abs(_samples_for_header_peak_comparison(component)).max())


def checked_relative_header_peak_difference(
    component: RecordComponent, report_contradiction_and_remedy: Callable[[str, str], None]
) -> float | None:
    """Return |peak of samples − peak in header| / peak in header of a component; None if the header has no peak.

    Call ``report_contradiction_and_remedy`` and return None if the two peaks differ by more than 0.5 % and by more than
    half a unit of the header's last digit, or if no sample of this size has the sign that the header states.
    """
    stated, peak = component.header_peak, peak_acceleration_comparable_to_header(component)
    if stated is None:
        return None
    level, difference = stated.absolute_acceleration, abs(peak - stated.absolute_acceleration)
    # 0.51 instead of 0.5, because the header's decimal number is not exact in binary.
    tolerance = max(HEADER_PEAK_RELATIVE_TOLERANCE * level, 0.51 * stated.resolution_of_printed_peak)
    line = f" line {stated.line_number}" if stated.line_number else ""
    on_side = float((stated.sign * _samples_for_header_peak_comparison(component)).max()) if stated.sign else peak
    if difference <= tolerance < level - on_side:
        report_contradiction_and_remedy(
            f"{component.file_name}{line}: the header states a peak of {stated.sign * level * 100:.6g} Gal along "
            f"{component.axis_name_in_file}, the data has {-stated.sign * peak * 100:.6g} Gal",
            "the sign of its samples is reversed: get the file again, or say --trust-data",
        )
        return None
    if difference > tolerance:
        report_contradiction_and_remedy(
            f"{component.file_name}{line}: the header states a peak of {level * 100:.6g} Gal "
            f"along {component.axis_name_in_file}, the data has {peak * 100:.6g} Gal (0.5 % allowed)",
            "the file is cut or its units are not what they seem: get it again, or say --trust-data",
        )
        return None
    return difference / level if level else 0.0


MAX_DEVIATION_FROM_RIGHT_ANGLE_WITHOUT_NOTE_DEG = 5.0
"""Largest deviation of two horizontal axes from a right angle without a note, degrees."""


def non_perpendicular_axes_notes(components: Sequence[RecordComponent]) -> list[str]:
    """Return a note if the first two components, which are horizontal, are over 5° from a right angle; else []."""
    first, second = (c.azimuth_deg or 0.0 for c in components[:2])
    apart = angle_between_azimuths(second, first)
    if abs(apart - 90.0) <= MAX_DEVIATION_FROM_RIGHT_ANGLE_WITHOUT_NOTE_DEG:
        return []
    which = f"horizontal axes at {first:g}° and {second:g}°, {apart:g}° apart"
    return [f"{which}, are taken as stated: look whether both azimuths are right"]


def agency_processing_metadata(components: Sequence[RecordComponent]) -> dict[str, str]:
    """Return the agency's processing as metadata for `Record.extra`, by axis if the axes differ; {} if not stated."""
    done = {c.axis_name_in_file: str(c.extra_metadata.get("agency_processing", "")) for c in components}
    if not any(done.values()):
        return {}
    alike = len(set(done.values())) == 1
    of_each = "; ".join(f"{axis}: {what or 'not stated'}" for axis, what in done.items())
    return {"agency_processing": next(iter(done.values())) if alike else of_each}


def seed_band_and_instrument_code(component: RecordComponent) -> str:
    """Return band and instrument letters of a component's SEED channel code, such as ``HN``; "" for other names."""
    name = component.axis_name_in_file
    coded = component.format_name in ("miniseed", "sac", "esm-dyna") and re.fullmatch("[A-Z]{2}[A-Z0-9]", name)
    return name[:2] if coded else ""
