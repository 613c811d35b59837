"""Header of a text file, read by a table of fields with one pattern each; shared by the readers of text formats."""

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any, Final

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.records.axis_direction import AzimuthAndVerticalSense
from overturning.records.component import PeakStatedInFileHeader, RecordComponent, normalise_coordinates
from overturning.records.formats.lines import FLOAT_PATTERN, TextLines
from overturning.records.source import SourceFile

HeaderFieldPatterns = Mapping[str, str | tuple[int, str]]
"""Fields of a header by name: a pattern that is searched for in all lines, or a line's index from 0 and its pattern.

The first group of the pattern is the field's text. A field with a line index is required; any other field raises an
error only when a caller needs it.
"""

ORIGIN_AND_HYPOCENTRE_FIELD_PATTERNS: Final[HeaderFieldPatterns] = {
    "origin": r"\bORIGIN(?:\s*\([^)]*\))?:\s*(\d+/\s*\d+/\s*\d+,?\s+\d+:\s*\d+:\s*\d+)[\d.]*\s*(?:UTC|GMT)",
    "origin minute": r"\b(\d{1,2}\s+[A-Z]{3,9}\.?,?\s+\d{4})\s*-\s*(\d{2}):?(\d{2})\s*(?:UTC|GMT)",
    "hypocentre": (
        rf"\bHYPOCENTER(?:\s*\([^)]*\))?:\s*({FLOAT_PATTERN})\s*([NS]?)(?:,\s*|\s+)({FLOAT_PATTERN})\s*([EW]?)"
    ),
}
"""Origin and hypocentre in headers of COSMOS and CSMIP; old headers add the agency: ``ORIGIN(BRK):``.

Headers of other agencies in the format of CSMIP state the minute alone: ``15 OCT 1979 - 2317 UTC``.
"""

DEGREE_MINUTE_SECOND_PATTERN: Final = r"(\d+) +(\d+) +(\d+) *([NS]),? +(\d+) +(\d+) +(\d+) *([EW])"
"""Pattern of latitude and longitude in degrees, minutes and seconds."""


FIRST_TWO_DIGIT_YEAR_OF_1900S: Final = 33
"""Smallest two-digit year that means 19xx: the first accelerogram was recorded in 1933."""


def last_digit_resolution(number_text: str) -> float:
    """Return the value of one unit of a printed number's last digit: 0.001 for ``927.174``, 10 for ``1.23E3``."""
    mantissa, _, exponent = number_text.strip().upper().replace("D", "E").partition("E")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))


def signed_coordinate_from_hemisphere(latitude_or_longitude_deg: float, hemisphere_letter: str) -> float:
    """Return a latitude or longitude, degrees, positive to the north or east, from a number and a hemisphere letter.

    The letter is N, E, S, W, O (Spanish for west) or empty. With S, W or O the result is negative, even for a negative
    number: some headers write both the minus sign and the letter.
    """
    return (
        -abs(latitude_or_longitude_deg) if hemisphere_letter.upper() in ("S", "W", "O") else latitude_or_longitude_deg
    )


def parse_time_as_utc(time_text: str, *time_patterns: str, utc_offset: timedelta = timedelta()) -> datetime | None:
    """Parse a time by the first format that matches, and return it in UTC; None if no format matches.

    ``utc_offset`` is local time minus UTC.
    """
    for pattern in time_patterns:
        with suppress(ValueError, OverflowError):
            return datetime.strptime(time_text.strip(), pattern).replace(tzinfo=UTC) - utc_offset
    return None


@dataclass(frozen=True)
class HeaderFields(TextLines):
    """Header of a text file: its lines, and for each field the line number and the matched text."""

    line_index_and_match_by_field: Mapping[str, tuple[int, re.Match[str]]] = field(default_factory=dict)

    @classmethod
    def find_fields(
        cls,
        lines_or_source_file: TextLines | SourceFile,
        field_patterns: HeaderFieldPatterns,
        searched_line_count: int = 500,
        *,
        min_line_count: int = 0,
    ) -> "HeaderFields":
        """Find the header fields by their patterns (regular expressions) in the first lines of a file.

        A pattern with a line index is searched for in that line only, any other in the first ``searched_line_count``
        lines. Raises a RecordError if a line with an index does not match its pattern, or if there are fewer than
        ``min_line_count`` lines.
        """
        lines_or_source_file = (
            TextLines(lines_or_source_file, lines_or_source_file.lines)
            if isinstance(lines_or_source_file, SourceFile)
            else lines_or_source_file
        )
        lines_or_source_file.check_header_length(min_line_count)
        found = {}
        for name, stated in field_patterns.items():
            at, pattern = (None, stated) if isinstance(stated, str) else stated
            search = re.compile(pattern, re.IGNORECASE).search
            for index, line in (
                enumerate(lines_or_source_file.lines[:searched_line_count])
                if at is None
                else [(at, lines_or_source_file.lines[at])]
            ):
                if match := search(line):
                    found[name] = index, match
                    break
            else:
                if at is not None:
                    raise lines_or_source_file.line_error(
                        at, f"{line.strip()[:60]!r} where {name} belongs; get the file again"
                    )
        return cls(
            lines_or_source_file.source,
            lines_or_source_file.lines,
            lines_or_source_file.file_line_count_before_first_line,
            found,
        )

    def line_index_of_field(self, field_name: str) -> int:
        """Return the line index of a header field; raise a RecordError if the header lacks the field."""
        if field_name not in self.line_index_and_match_by_field:
            why = f"no {field_name} in the header that begins here; the file is cut or of another kind: get it again"
            raise super().line_error(0, why)
        return self.line_index_and_match_by_field[field_name][0]

    def field_pattern_match(self, field_name: str) -> re.Match[str] | None:
        """Return the match of a header field with its regular expression; None if the header lacks the field."""
        return (
            self.line_index_and_match_by_field[field_name][1]
            if field_name in self.line_index_and_match_by_field
            else None
        )

    def field_text(self, field_name: str) -> str:
        """Return the text of a header field; "" if the header lacks the field."""
        match = self.field_pattern_match(field_name)
        return next((group.strip() for group in match.groups() if group is not None), "") if match else ""

    def line_error(self, line_index_or_field_name: int | str, problem: str) -> RecordError:
        """Return an error about a line of the file, which is given by its index or by the name of a header field."""
        return super().line_error(
            self.line_index_of_field(line_index_or_field_name)
            if isinstance(line_index_or_field_name, str)
            else line_index_or_field_name,
            problem,
        )

    def number_in_field(self, field_name: str, override_text: str | None = None) -> float:
        """Return the number in a header field (or in `override_text`); raise a RecordError if the text is no number."""
        index = self.line_index_of_field(field_name)
        return self.parse_number(
            self.field_text(field_name) if override_text is None else override_text, index, field_name
        )

    def optional_number_in_field(self, field_name: str) -> float | None:
        """Return the number in a header field; None if the field is missing or blank."""
        return self.number_in_field(field_name) if self.field_text(field_name) else None

    def sampling_interval_of_rate_field(self, field_name: str, override_text: str | None = None) -> float:
        """Return the sampling interval, s, from the sampling rate, Hz, in a header field (or in `override_text`)."""
        return self.sampling_interval_of_rate(
            self.number_in_field(field_name, override_text), self.line_index_of_field(field_name)
        )

    def number_fields_as_metadata(self, field_name_by_metadata_name: Mapping[str, str]) -> dict[str, Any]:
        """Return the numbers in header fields as metadata (`Record.extra`); missing fields are left out."""
        return {
            name: self.number_in_field(stated)
            for name, stated in field_name_by_metadata_name.items()
            if self.field_text(stated)
        }

    def field_peak_acceleration(
        self,
        field_name: str,
        unit_in_m_s2: float,
        override_text: str | None = None,
        *,
        is_peak_after_mean_removal: bool = False,
        format_states_sign_of_peak: bool = False,
    ) -> PeakStatedInFileHeader:
        """Return the peak acceleration (converted to m/s²), its sign and its resolution from a header field.

        The sign is −1 or 1, or 0 if unknown: a positive number has 1 only with ``format_states_sign_of_peak``.
        """
        stated = self.field_text(field_name) if override_text is None else override_text
        number = self.number_in_field(field_name, stated)
        return PeakStatedInFileHeader(
            abs(number) * unit_in_m_s2,
            last_digit_resolution(stated) * unit_in_m_s2,
            is_peak_after_mean_removal,
            self.file_line_count_before_first_line + self.line_index_of_field(field_name) + 1,
            -1 if number < 0 else int(format_states_sign_of_peak and number > 0),
        )

    def field_utc_time(
        self,
        field_name: str,
        *time_patterns: str,
        override_text: str | None = None,
        utc_offset: timedelta = timedelta(),
    ) -> datetime:
        """Return the UTC time in a header field (or in `override_text`); ``utc_offset`` is local time minus UTC."""
        stated = self.field_text(field_name) if override_text is None else override_text
        index, moment = (
            self.line_index_of_field(field_name),
            parse_time_as_utc(stated, *time_patterns, utc_offset=utc_offset),
        )
        if moment is None:
            like = datetime(2000, 10, 6, 13, 30).strftime(time_patterns[0])
            raise self.line_error(index, f"{field_name} {stated!r} is no time like {like}; correct it")
        return moment

    def utc_time_of_month_day_year_field(self, field_name: str) -> datetime | None:
        """Return the UTC time in a header field (month, day, year, hour, minute, second); None if it is missing."""
        match = self.field_pattern_match(field_name)
        if match is None:
            return None
        month, day, year, hour, minute = (int(match[i]) for i in range(1, 6))
        year += 0 if year > 99 else 1900 if year >= FIRST_TWO_DIGIT_YEAR_OF_1900S else 2000
        return self.utc_time(
            self.line_index_of_field(field_name),
            (year, month, day),
            hour,
            minute,
            self.number_in_field(field_name, match[6]),
        )

    def field_latitude_and_longitude_deg(self, field_name: str) -> tuple[float, float] | tuple[None, None]:
        """Return the latitude and longitude, degrees, in a header field; (None, None) if the field is missing.

        The field's pattern has four groups (number, N or S, number, E or W), or the eight groups of
        `DEGREE_MINUTE_SECOND_PATTERN`; the latter are rounded to 1e-5°.
        """
        match = self.field_pattern_match(field_name)
        if match is None or match[1] is None:
            return None, None
        parts, each = match.groups(), len(match.groups()) // 2
        north, east = (
            signed_coordinate_from_hemisphere(sum(float(part) / 60**i for i, part in enumerate(of[:-1])), of[-1])
            for of in (parts[:each], parts[each:])
        )
        return (north, east) if each == 2 else (round(north, 5), round(east, 5))

    def origin_time_and_epicentre_metadata(self) -> tuple[datetime | None, dict[str, Any]]:
        """Return the earthquake's origin time, UTC, or None, and its epicentre as metadata (`Record.extra`), or {}."""
        stated = re.sub(r"\s+|,", "", re.sub(r",?\s+(?=\d+:)", "-", self.field_text("origin")))
        origin = parse_time_as_utc(stated, "%Y/%m/%d-%H:%M:%S", "%m/%d/%Y-%H:%M:%S", "%m/%d/%y-%H:%M:%S")
        if origin and origin.year >= 2000 + FIRST_TWO_DIGIT_YEAR_OF_1900S:  # Python reads years up to 68 as 20xx.
            origin = origin.replace(year=origin.year - 100)
        if origin is None and (minute := self.field_pattern_match("origin minute")):
            day, month, year = re.split(r"[.,\s]+", minute[1])
            origin = parse_time_as_utc(f"{day} {month[:3]} {year} {minute[2]} {minute[3]}", "%d %b %Y %H %M")
        return origin, epicentre_metadata(*self.field_latitude_and_longitude_deg("hypocentre")) if any(
            self.field_latitude_and_longitude_deg("hypocentre")
        ) else {}

    def check_field_pattern(self, field_name: str, required_text_pattern: str, supported_content_label: str) -> None:
        """Raise a RecordError if a header field, such as the unit of the samples, does not match a pattern."""
        if not re.match(required_text_pattern, self.field_text(field_name), re.IGNORECASE):
            raise self.line_error(
                field_name,
                f"{field_name} {self.field_text(field_name)!r}; only {supported_content_label} is read: get that file",
            )

    def check_sample_count(self, field_name: str, found_sample_count: int) -> None:
        """Raise a RecordError if the number of samples found differs from that in a header field."""
        if self.number_in_field(field_name) != found_sample_count:
            raise self.line_error(
                field_name,
                f"{self.field_text(field_name)} samples here, but {found_sample_count} below; get the file again",
            )

    def check_stated_duration(
        self, field_name: str, found_sample_count: int, sampling_interval: float, override_text: str | None = None
    ) -> None:
        """Raise a RecordError if the duration of the samples differs from that in a header field (or `override_text`).

        The stated duration may be rounded, and may include one interval after the last sample. No check if not stated.
        """
        stated = self.field_text(field_name) if override_text is None else override_text
        if stated:
            self.check_duration_stated_in_line(
                self.line_index_of_field(field_name),
                found_sample_count,
                sampling_interval,
                self.number_in_field(field_name, stated),
                1.01 * last_digit_resolution(stated),
            )

    def cut_to_stated_sample_count_with_notes(
        self, field_name: str, samples_or_rows: FloatArray, override_text: str | None = None
    ) -> tuple[FloatArray, tuple[str, ...]]:
        """Cut samples to the number that a header field (or `override_text`) states; return also a note if any are cut.

        Raises a RecordError if the file has fewer.
        """
        count, found = self.number_in_field(field_name, override_text), len(samples_or_rows)
        if found < count or count != int(count):
            what = f"header promises {override_text or self.field_text(field_name)} samples, the file has {found}"
            raise self.line_error(field_name, f"{what}; it is cut: get it again")
        more = found - int(count)
        return samples_or_rows[: int(count)], self.surplus_number_notes(int(count), f"{more} samples") if more else ()

    def create_component(
        self,
        axis_name_in_file: str,
        axis_direction: AzimuthAndVerticalSense,
        acceleration: FloatArray,
        sampling_interval: float,
        **metadata: Any,
    ) -> RecordComponent:
        """Create a record component from samples, ``metadata``, and the station and earthquake in the file's header.

        The header's fields ``station``, ``event``, ``coordinates``, ``magnitude`` and ``epicentre`` are added.
        """
        usual = {"station": self.field_text("station"), "event": " ".join(self.field_text("event").split())}
        extra = self.number_fields_as_metadata({"magnitude": "magnitude"}) | metadata.pop("extra_metadata", {})
        extra |= epicentre_metadata(*metadata.pop("epicentre", self.field_latitude_and_longitude_deg("epicentre")))
        metadata = (
            usual | {"station_latitude_longitude_deg": self.field_latitude_and_longitude_deg("coordinates")} | metadata
        )
        return RecordComponent.from_file(
            self.source,
            axis_name_in_file,
            axis_direction,
            acceleration,
            sampling_interval,
            extra_metadata=extra,
            **metadata,
        )


def epicentre_metadata(latitude_deg: float | None, longitude_deg: float | None) -> dict[str, Any]:
    """Return an epicentre, degrees, as metadata (`Record.extra`); {} if latitude or longitude is unknown or wrong."""
    place = normalise_coordinates(latitude_deg, longitude_deg)
    return {} if None in place else {"event_latitude": place[0], "event_longitude": place[1]}
