"""What the readers of text files share: a header as a table of fields, each with the pattern that states it."""

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any, Final

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.records.component import Component, Direction, StatedPeak
from overturning.records.formats.lines import FLOAT, Lines
from overturning.records.source import SourceFile

Fields = Mapping[str, str | tuple[int, str]]
"""Where a header states what: a pattern of the line, which is searched for, or the line, from 0, and its pattern.

What is wanted is the pattern's first group. A field with a line must be there; any other only once it is asked for.
"""

EARTHQUAKE: Final[Fields] = {
    "origin": r"\bORIGIN(?:\s*\([^)]*\))?:\s*(\d+/\s*\d+/\s*\d+,?\s+\d+:\s*\d+:\s*\d+)[\d.]*\s*(?:UTC|GMT)",
    "hypocentre": rf"\bHYPOCENTER(?:\s*\([^)]*\))?:\s*({FLOAT})\s*([NS]?)(?:,\s*|\s+)({FLOAT})\s*([EW]?)",
}
"""The earthquake as headers of COSMOS and CSMIP state it, old ones with the agency: ``ORIGIN(BRK):``."""

PLACE: Final = r"(\d+) +(\d+) +(\d+) *([NS]),? +(\d+) +(\d+) +(\d+) *([EW])"
"""Degrees, minutes and seconds of a latitude and a longitude."""


FIRST_YEAR: Final = 33
"""Years of two digits from here on are those of 19xx: the first accelerogram is of 1933."""


def resolution(text: str) -> float:
    """Unit of the last printed digit of a number: 0.001 for ``927.174``, 10 for ``1.23E3``."""
    mantissa, _, exponent = text.strip().upper().replace("D", "E").partition("E")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))


def stated_time(text: str, *patterns: str, ahead: timedelta = timedelta()) -> datetime | None:
    """A time that a header states, in UTC, of a clock that is ahead of it; None where no pattern fits."""
    for pattern in patterns:
        with suppress(ValueError, OverflowError):
            return datetime.strptime(text.strip(), pattern).replace(tzinfo=UTC) - ahead
    return None


@dataclass(frozen=True)
class Header(Lines):
    """Lines with what the header among them states: for each field its line and the match of its pattern."""

    found: Mapping[str, tuple[int, re.Match[str]]] = field(default_factory=dict)

    @classmethod
    def of(cls, lines: Lines | SourceFile, fields: Fields, stop: int = 500, *, length: int = 0) -> "Header":
        """Look for fields, in capitals or not, in the lines before ``stop``; the first line that fits counts.

        A RecordError where the lines end within a header of so many.
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
        """Line of a field; a RecordError where it is not stated."""
        if name not in self.found:
            why = f"no {name} in the header that begins here; the file is cut or of another kind: get it again"
            raise super().error(0, why)
        return self.found[name][0]

    def match(self, name: str) -> re.Match[str] | None:
        """Match of a field's pattern; None where it is not stated."""
        return self.found[name][1] if name in self.found else None

    def text(self, name: str) -> str:
        """Text of a field, the first group that took part; empty where it is not stated."""
        match = self.match(name)
        return next((group.strip() for group in match.groups() if group is not None), "") if match else ""

    def error(self, at: int | str, why: str) -> RecordError:
        """An error that names a line, or that of a field."""
        return super().error(self.at(at) if isinstance(at, str) else at, why)

    def value(self, name: str, text: str | None = None) -> float:
        """Number of a field, or in a part of its text."""
        index = self.at(name)
        return self.number(self.text(name) if text is None else text, index, name)

    def optional(self, name: str) -> float | None:
        """Number of a field; None where it is not stated, or blank."""
        return self.value(name) if self.text(name) else None

    def interval(self, name: str, text: str | None = None) -> float:
        """Sampling interval, s, of a field, or a part of its text, that states a rate in Hz."""
        return self.interval_of(self.value(name, text), self.at(name))

    def numbers(self, names: Mapping[str, str]) -> dict[str, Any]:
        """Numbers of the fields that are stated, by the names that a record's ``extra`` has for them."""
        return {name: self.value(stated) for name, stated in names.items() if self.text(stated)}

    def peak(self, name: str, scale: float, text: str | None = None, *, after_mean: bool = False) -> StatedPeak:
        """The peak that a field, or a part of its text, states in a unit of ``scale`` m/s²."""
        stated = self.text(name) if text is None else text
        size = abs(self.value(name, stated))
        return StatedPeak(size * scale, resolution(stated) * scale, after_mean, self.before + self.at(name) + 1)

    def moment(self, name: str, *patterns: str, text: str | None = None, ahead: timedelta = timedelta()) -> datetime:
        """Time of a field, or in a part of its text, in one of the patterns, of a clock that is ahead of UTC."""
        stated = self.text(name) if text is None else text
        index, moment = self.at(name), stated_time(stated, *patterns, ahead=ahead)
        if moment is None:
            like = datetime(2000, 10, 6, 13, 30).strftime(patterns[0])
            raise self.error(index, f"{name} {stated!r} is no time like {like}; correct it")
        return moment

    def clock(self, name: str) -> datetime | None:
        """Time, UTC, of a field of six groups, month, day, year, hour, minute and second; None where not stated."""
        match = self.match(name)
        if match is None:
            return None
        month, day, year, hour, minute = (int(match[i]) for i in range(1, 6))
        year += 0 if year > 99 else 1900 if year >= FIRST_YEAR else 2000
        return self.time(self.at(name), (year, month, day), hour, minute, self.value(name, match[6]))

    def place(self, name: str) -> tuple[float, float] | tuple[None, None]:
        """Latitude and longitude, degrees, of a field of four groups: number, N or S, number, E or W; else None.

        Or of the eight groups of `PLACE`, to 0.00001 degrees.
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
        """Origin time, UTC, and epicentre, degrees, as `EARTHQUAKE` has them; None and empty where not stated."""
        stated = re.sub(r"\s+|,", "", re.sub(r",?\s+(?=\d+:)", "-", self.text("origin")))
        origin = stated_time(stated, "%Y/%m/%d-%H:%M:%S", "%m/%d/%Y-%H:%M:%S", "%m/%d/%y-%H:%M:%S")
        if origin and origin.year >= 2000 + FIRST_YEAR:  # Python takes years up to 68 for those of this century
            origin = origin.replace(year=origin.year - 100)
        return origin, epicentre(*self.place("hypocentre")) if any(self.place("hypocentre")) else {}

    def check_unit(self, name: str, pattern: str, read: str) -> None:
        """Refuse a unit, or what else says which quantity it is, that does not fit a pattern."""
        if not re.match(pattern, self.text(name), re.IGNORECASE):
            raise self.error(name, f"{name} {self.text(name)!r}; only {read} is read: get that file")

    def check_count(self, name: str, found: int) -> None:
        """Refuse another number of samples than a field states."""
        if self.value(name) != found:
            raise self.error(name, f"{self.text(name)} samples here, but {found} below; get the file again")

    def check_duration(self, name: str, count: int, interval: float, text: str | None = None) -> None:
        """Refuse an interval, s, at which so many samples last another time than a field, or a part of it, states.

        Nothing where it is not stated. The length may be rounded, and counted to the last sample or one further.
        """
        stated = self.text(name) if text is None else text
        if stated:
            self.check_length(self.at(name), count, interval, self.value(name, stated), 1.01 * resolution(stated))

    def promised(self, name: str, values: FloatArray, stated: str | None = None) -> tuple[FloatArray, tuple[str, ...]]:
        """As many of the samples as a field promises, or a part of its text, and what is said of a file with more.

        A RecordError where the file has fewer.
        """
        count, found = self.value(name, stated), len(values)
        if found < count or count != int(count):
            what = f"header promises {stated or self.text(name)} samples, the file has {found}"
            raise self.error(name, f"{what}; it is cut: get it again")
        more = found - int(count)
        return values[: int(count)], self.surplus(int(count), f"{more} samples") if more else ()

    def component(
        self, axis: str, direction: Direction, samples: FloatArray, interval: float, **stated: Any
    ) -> Component:
        """A component of the file, with what is stated of it.

        Fields ``station``, ``event``, ``coordinates``, ``magnitude`` and ``epicentre`` do so by themselves.
        """
        usual = {"station": self.text("station"), "event": " ".join(self.text("event").split())}
        extra = self.numbers({"magnitude": "magnitude"}) | stated.pop("extra", {})
        extra |= epicentre(*stated.pop("epicentre", self.place("epicentre")))
        stated = usual | {"place": self.place("coordinates")} | stated
        return Component.of(self.source, axis, direction, samples, interval, extra=extra, **stated)


def epicentre(north: float | None, east: float | None) -> dict[str, float]:
    """An epicentre, degrees, as a record's ``extra`` has it; empty where it is not known."""
    return {} if north is None or east is None else {"event_latitude": north, "event_longitude": east}
