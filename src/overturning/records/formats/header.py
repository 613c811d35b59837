"""Header of a text file, read by a table of fields with one pattern each; shared by the readers of text formats."""

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any, Final

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.records.component import Component, Direction, HeaderPeak
from overturning.records.formats.lines import FLOAT, Lines
from overturning.records.source import SourceFile

Fields = Mapping[str, str | tuple[int, str]]
"""Fields of a header by name: a pattern that is searched for in all lines, or a line's index from 0 and its pattern.

The first group of the pattern is the field's text. A field with a line index is required; any other field raises an
error only when a caller needs it.
"""

EARTHQUAKE: Final[Fields] = {
    "origin": r"\bORIGIN(?:\s*\([^)]*\))?:\s*(\d+/\s*\d+/\s*\d+,?\s+\d+:\s*\d+:\s*\d+)[\d.]*\s*(?:UTC|GMT)",
    "hypocentre": rf"\bHYPOCENTER(?:\s*\([^)]*\))?:\s*({FLOAT})\s*([NS]?)(?:,\s*|\s+)({FLOAT})\s*([EW]?)",
}
"""Origin and hypocentre in headers of COSMOS and CSMIP; old headers add the agency: ``ORIGIN(BRK):``."""

PLACE: Final = r"(\d+) +(\d+) +(\d+) *([NS]),? +(\d+) +(\d+) +(\d+) *([EW])"
"""Pattern of latitude and longitude in degrees, minutes and seconds."""


FIRST_YEAR: Final = 33
"""Smallest two-digit year that means 19xx: the first accelerogram was recorded in 1933."""


def resolution(text: str) -> float:
    """Return the unit of the last printed digit of a number: 0.001 for ``927.174``, 10 for ``1.23E3``."""
    mantissa, _, exponent = text.strip().upper().replace("D", "E").partition("E")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))


def stated_time(text: str, *patterns: str, ahead: timedelta = timedelta()) -> datetime | None:
    """Return a stated time in UTC; ``ahead`` is local time minus UTC. None if no pattern fits."""
    for pattern in patterns:
        with suppress(ValueError, OverflowError):
            return datetime.strptime(text.strip(), pattern).replace(tzinfo=UTC) - ahead
    return None


@dataclass(frozen=True)
class Header(Lines):
    """Lines of a file with the header's fields: line index and match of each field's pattern."""

    found: Mapping[str, tuple[int, re.Match[str]]] = field(default_factory=dict)

    @classmethod
    def of(cls, lines: Lines | SourceFile, fields: Fields, stop: int = 500, *, length: int = 0) -> "Header":
        """Find fields in the lines before ``stop``, ignoring case; the first line that fits counts.

        Raises a RecordError if there are fewer than ``length`` lines.
        """
        lines = Lines(lines, lines.lines) if isinstance(lines, SourceFile) else lines
        lines.check_header(length)
        found = {}
        for name, stated in fields.items():
            at, pattern = (None, stated) if isinstance(stated, str) else stated
            for index, line in enumerate(lines.lines[:stop]) if at is None else [(at, lines.lines[at])]:
                if match := re.search(pattern, line, re.IGNORECASE):
                    found[name] = index, match
                    break
            else:
                if at is not None:
                    raise lines.error(at, f"{line.strip()[:60]!r} where {name} belongs; get the file again")
        return cls(lines.source, lines.lines, lines.before, found)

    def at(self, name: str) -> int:
        """Return the line index of a field; raise a RecordError if the header does not state it."""
        if name not in self.found:
            why = f"no {name} in the header that begins here; the file is cut or of another kind: get it again"
            raise super().error(0, why)
        return self.found[name][0]

    def match(self, name: str) -> re.Match[str] | None:
        """Return the match of a field's pattern; None if not stated."""
        return self.found[name][1] if name in self.found else None

    def text(self, name: str) -> str:
        """Return the text of a field, its first group that matched; "" if not stated."""
        match = self.match(name)
        return next((group.strip() for group in match.groups() if group is not None), "") if match else ""

    def error(self, at: int | str, why: str) -> RecordError:
        """Return an error that names a line, given by index or by field."""
        return super().error(self.at(at) if isinstance(at, str) else at, why)

    def value(self, name: str, text: str | None = None) -> float:
        """Return the number in a field, or in a part of its text."""
        index = self.at(name)
        return self.number(self.text(name) if text is None else text, index, name)

    def optional(self, name: str) -> float | None:
        """Return the number in a field; None if not stated or blank."""
        return self.value(name) if self.text(name) else None

    def interval(self, name: str, text: str | None = None) -> float:
        """Return the sampling interval, s, from a field (or a part of its text) that states a rate in Hz."""
        return self.interval_of(self.value(name, text), self.at(name))

    def numbers(self, names: Mapping[str, str]) -> dict[str, Any]:
        """Return the numbers of the stated fields under their names in a record's ``extra``."""
        return {name: self.value(stated) for name, stated in names.items() if self.text(stated)}

    def peak(self, name: str, scale: float, text: str | None = None, *, after_mean: bool = False) -> HeaderPeak:
        """Return the peak that a field (or a part of its text) states; ``scale`` is its unit in m/s²."""
        stated = self.text(name) if text is None else text
        size = abs(self.value(name, stated))
        return HeaderPeak(size * scale, resolution(stated) * scale, after_mean, self.before + self.at(name) + 1)

    def moment(self, name: str, *patterns: str, text: str | None = None, ahead: timedelta = timedelta()) -> datetime:
        """Return the UTC time in a field (or a part of its text); ``ahead`` is local time minus UTC."""
        stated = self.text(name) if text is None else text
        index, moment = self.at(name), stated_time(stated, *patterns, ahead=ahead)
        if moment is None:
            like = datetime(2000, 10, 6, 13, 30).strftime(patterns[0])
            raise self.error(index, f"{name} {stated!r} is no time like {like}; correct it")
        return moment

    def clock(self, name: str) -> datetime | None:
        """Return the UTC time of a field with groups month, day, year, hour, minute, second; None if not stated."""
        match = self.match(name)
        if match is None:
            return None
        month, day, year, hour, minute = (int(match[i]) for i in range(1, 6))
        year += 0 if year > 99 else 1900 if year >= FIRST_YEAR else 2000
        return self.time(self.at(name), (year, month, day), hour, minute, self.value(name, match[6]))

    def place(self, name: str) -> tuple[float, float] | tuple[None, None]:
        """Return latitude and longitude, degrees, of a field; None twice if not stated.

        The field has the groups number, N or S, number, E or W, or the eight groups of `PLACE` (rounded to 1e-5°).
        """
        match = self.match(name)
        if match is None or match[1] is None:
            return None, None
        parts, each = match.groups(), len(match.groups()) // 2
        north, east = (
            sum(float(part) / 60**i for i, part in enumerate(of[:-1])) * (-1 if of[-1].upper() in ("S", "W") else 1)
            for of in (parts[:each], parts[each:])
        )
        return (north, east) if each == 2 else (round(north, 5), round(east, 5))

    def earthquake(self) -> tuple[datetime | None, dict[str, Any]]:
        """Return origin time, UTC, and epicentre entries from the fields of `EARTHQUAKE`; None and {} if not stated."""
        stated = re.sub(r"\s+|,", "", re.sub(r",?\s+(?=\d+:)", "-", self.text("origin")))
        origin = stated_time(stated, "%Y/%m/%d-%H:%M:%S", "%m/%d/%Y-%H:%M:%S", "%m/%d/%y-%H:%M:%S")
        if origin and origin.year >= 2000 + FIRST_YEAR:  # Python reads years up to 68 as 20xx.
            origin = origin.replace(year=origin.year - 100)
        return origin, epicentre(*self.place("hypocentre")) if any(self.place("hypocentre")) else {}

    def check_unit(self, name: str, pattern: str, read: str) -> None:
        """Refuse a field, such as a unit or a quantity, whose text does not fit a pattern."""
        if not re.match(pattern, self.text(name), re.IGNORECASE):
            raise self.error(name, f"{name} {self.text(name)!r}; only {read} is read: get that file")

    def check_count(self, name: str, found: int) -> None:
        """Refuse a number of samples that differs from the field's."""
        if self.value(name) != found:
            raise self.error(name, f"{self.text(name)} samples here, but {found} below; get the file again")

    def check_duration(self, name: str, count: int, interval: float, text: str | None = None) -> None:
        """Refuse ``count`` samples every ``interval`` s that do not last as long as a field (or a part of it) states.

        The stated duration may be rounded, and may include one interval after the last sample. No check if not stated.
        """
        stated = self.text(name) if text is None else text
        if stated:
            self.check_length(self.at(name), count, interval, self.value(name, stated), 1.01 * resolution(stated))

    def stated_samples(
        self, name: str, values: FloatArray, stated: str | None = None
    ) -> tuple[FloatArray, tuple[str, ...]]:
        """Return the number of samples that a field (or a part of its text) states, and a note if the file has more.

        Raises a RecordError if the file has fewer.
        """
        count, found = self.value(name, stated), len(values)
        if found < count or count != int(count):
            what = f"header promises {stated or self.text(name)} samples, the file has {found}"
            raise self.error(name, f"{what}; it is cut: get it again")
        more = found - int(count)
        return values[: int(count)], self.surplus_notes(int(count), f"{more} samples") if more else ()

    def component(
        self, axis: str, direction: Direction, samples: FloatArray, interval: float, **stated: Any
    ) -> Component:
        """Return a component of the file with the metadata in ``stated``.

        The header's fields ``station``, ``event``, ``coordinates``, ``magnitude`` and ``epicentre`` are added.
        """
        usual = {"station": self.text("station"), "event": " ".join(self.text("event").split())}
        extra = self.numbers({"magnitude": "magnitude"}) | stated.pop("extra", {})
        extra |= epicentre(*stated.pop("epicentre", self.place("epicentre")))
        stated = usual | {"coordinates": self.place("coordinates")} | stated
        return Component.from_file(self.source, axis, direction, samples, interval, extra=extra, **stated)


def epicentre(north: float | None, east: float | None) -> dict[str, float]:
    """Return an epicentre, degrees, as entries of a record's ``extra``; empty if unknown."""
    return {} if north is None or east is None else {"event_latitude": north, "event_longitude": east}
