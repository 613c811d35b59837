"""Which earthquake a record belongs to: decided here and nowhere else, for all records of a study together.

Every interval resamples earthquakes, so one earthquake under two names would count as two.
"""

import difflib
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from itertools import combinations
from typing import Any, Final

import numpy as np

from overturning.errors import ArgumentError
from overturning.records.catalogue import RecordEntry, parse_utc
from overturning.records.record import Record
from overturning.units import EARTH_RADIUS_KM

MAX_ORIGIN_DIFFERENCE: Final = timedelta(seconds=60)
"""Largest difference between origin times of one earthquake: old headers round them to the minute."""

MAX_EPICENTRE_DISTANCE_KM: Final = 100.0
"""Largest distance between epicentres of one earthquake as different agencies have them, km."""

MAX_START_DIFFERENCE: Final = timedelta(minutes=2)
"""Records that start no further apart than this are likely of one earthquake."""

MAX_NAMED_DIFFERENCE: Final = timedelta(hours=1)
"""Records that start further apart than this are hardly of one earthquake."""

MIN_NAME_SIMILARITY: Final = 0.85
"""Similarity of two names (difflib: twice the letters that match over all letters) from which on they may be one."""

MAX_LISTED_DOUBTS: Final = 10
"""Doubts that are named one by one."""

_FILLING: Final = re.compile(
    r"\b(rcrd|record|earthquake|eq|of|the|(?:mon|tue|wed|thu|fri|sat|sun)|jst|utc?|gmt|epicentre.*)\b"
)
_MONTHS: Final = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"]
_MONTH: Final = rf"(?:\d\d?|(?:{'|'.join(_MONTHS)})[a-z]*)"
_DATES: Final = (
    re.compile(rf"\b(?P<year>(?:1[89]|20)\d\d)[-/ ](?P<month>{_MONTH})[-/ ](?P<day>\d\d?)\b"),
    re.compile(rf"\b(?P<month>{_MONTH})[-/ ]\s*(?P<day>\d\d?)[-/, ]\s*(?P<year>(?:1[89]|20)?\d\d)\b"),
    re.compile(r"\b(?P<year>(?:1[89]|20)\d\d)\b"),
)
"""Dates as names have them; which of two numbers is the month does not matter."""


@dataclass(frozen=True)
class _EarthquakeData:
    """What is known of the earthquake of one record."""

    record_id: str
    name: str
    event_id: str = ""
    origin: datetime | None = None
    place: tuple[float, float] | None = None  # epicentre: latitude and longitude, degrees
    start: datetime | None = None  # of the record
    synthetic: bool = False

    def same(self, other: "_EarthquakeData") -> bool | None:
        """Whether two records are of one earthquake, where ids or origins say it; None where they do not."""
        if self.event_id and other.event_id:
            return self.event_id == other.event_id
        if self.origin is None or other.origin is None:
            return None
        near = (
            self.place is None
            or other.place is None
            or distance_km(self.place, other.place) <= MAX_EPICENTRE_DISTANCE_KM
        )
        return near and abs(self.origin - other.origin) <= MAX_ORIGIN_DIFFERENCE


def _earthquake_data(record: Record | RecordEntry) -> _EarthquakeData:
    """What a record states, or a line of the record table whose files have not been read."""
    times: tuple[str | None, str | None]  # origin, and start of the record
    if isinstance(record, RecordEntry):
        named, stated, times = record.id, record.model_dump(), (record.origin_time, None)
        place = (record.epicentre_latitude_deg, record.epicentre_longitude_deg)
    else:
        named, stated, times = record.record_id, record.extra, (record.extra.get("origin_time"), record.start)
        place = (stated.get("event_latitude"), stated.get("event_longitude"))
    try:
        origin, start = (datetime.fromisoformat(parse_utc(text)) if text else None for text in times)
    except ValueError as fault:  # of a `Record` made in Python
        raise ArgumentError(f"record {named}: start {times[1]!r}, origin time {times[0]!r}: {fault}") from None
    return _EarthquakeData(
        named,
        " ".join(record.event.split()),
        stated.get("event_id", ""),
        origin,
        None if place[0] is None or place[1] is None else (float(place[0]), float(place[1])),
        start,
        stated.get("format") == "synthetic",
    )


def distance_km(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Length of the great circle between two places, km (haversine formula)."""
    (lat1, lon1), (lat2, lon2) = np.radians(first), np.radians(second)
    half = np.sin((lat2 - lat1) / 2) ** 2 + np.cos(lat1) * np.cos(lat2) * np.sin((lon2 - lon1) / 2) ** 2
    return float(2 * EARTH_RADIUS_KM * np.arcsin(np.sqrt(min(half, 1.0))))


@dataclass
class _Earthquake:
    """Records that belong together, by their places among all."""

    members: dict[int, _EarthquakeData] = field(default_factory=dict)
    stated: dict[tuple[Any, ...], _EarthquakeData] = field(
        default_factory=dict
    )  # the first member with each id and origin
    names: dict[str, str] = field(default_factory=dict)  # in small letters, and as written

    def add(self, index: int, one: _EarthquakeData) -> None:
        self.members[index] = one
        self.stated.setdefault((one.event_id, one.origin, one.place), one)
        self.names.setdefault(one.name.casefold(), one.name)

    def holds(self, one: _EarthquakeData) -> bool:
        certain = [same for member in self.stated.values() if (same := member.same(one)) is not None]
        named = one.name.casefold() in self.names and (one.name != "" or not self.more)
        return all(certain) if certain else named

    @property
    def first(self) -> _EarthquakeData:
        return self.members[min(self.members)]

    @property
    def name(self) -> str:
        """The first name in the order of the records, else the id or origin."""
        named = [self.members[index].name for index in sorted(self.members) if self.members[index].name]
        return named[0] if named else self.more

    @property
    def more(self) -> str:
        """What tells it from another one of the same name."""
        ids = [one.event_id for one in self.stated.values() if one.event_id]
        origins = [f"{one.origin:%Y-%m-%d %H:%M}" for one in self.stated.values() if one.origin]
        return next(iter(ids + origins), "")


@dataclass(frozen=True)
class Earthquakes:
    """Which records are of one earthquake."""

    labels: tuple[str, ...]  # of each record: the same text where, and only where, the earthquake is the same
    merged: tuple[str, ...]  # earthquakes that had several names, a sentence each
    doubtful: tuple[str, ...]  # what may be wrong, with names and remedy, a sentence each

    @property
    def notes(self) -> tuple[str, ...]:
        """Earthquakes of several names, and doubts; of many doubts the first and their number."""
        left_out = len(self.doubtful) - MAX_LISTED_DOUBTS
        more = (f"{left_out} more doubts of this kind",) if left_out > 0 else ()
        return (*self.merged, *self.doubtful[:MAX_LISTED_DOUBTS], *more)


def earthquakes_of(records: Iterable[Record | RecordEntry]) -> Earthquakes:
    """Decide which earthquake each record belongs to.

    An ``event_id`` of the record table decides where both records have one. Else origin times within 60 s of each
    other, with epicentres within 100 km where both are known, make one earthquake, and origins further apart make two,
    whatever the names. Where one origin is not known, the same name does, in capitals or not. Records that say nothing
    of their earthquake count as one, so that no interval becomes too narrow. Labels are in the order of the records;
    doubts are names that resemble each other on no other date, records of two names that start together, one name with
    several origins, and records of one name that start more than an hour apart.
    """
    known = [_earthquake_data(record) for record in records]
    found: list[_Earthquake] = []
    unclear = []
    # What is known best comes first, so that names alone join what ids and origins have set apart.
    for index in sorted(range(len(known)), key=lambda i: (not known[i].event_id, known[i].origin is None)):
        homes = [one for one in found if one.holds(known[index])]
        if not homes:
            homes = [_Earthquake()]
            found += homes
        elif len(homes) > 1:
            names = " or ".join(f"{one.name!r} ({one.more})" for one in homes)
            unclear.append(f"record {known[index].record_id} may be of {names} and counts as the first; give event_id")
        homes[0].add(index, known[index])
    found.sort(key=lambda one: min(one.members))
    return Earthquakes(
        _labels(found),
        tuple(_merged_names(found)),
        (*unclear, *_doubts_of_split(found), *_doubts_within(found), *_doubts_between(found)),
    )


def _labels(found: list[_Earthquake]) -> tuple[str, ...]:
    """The earthquake's name for each record, with id or origin where two earthquakes share the name."""
    names = Counter(one.name for one in found)
    labels: dict[int, str] = {}
    taken: set[str] = set()
    for one in found:
        name, more = one.name, one.more
        label = f"{name} ({more})" if names[name] > 1 and more and more != name else name
        while label in taken:
            label += "'"
        taken.add(label)
        labels |= dict.fromkeys(one.members, label)
    return tuple(labels[index] for index in sorted(labels))


def _merged_names(found: list[_Earthquake]) -> Iterable[str]:
    for one in found:
        names = [name for name in one.names.values() if name]
        if len(names) > 1:
            why = "one event_id" if any(each.event_id for each in one.stated.values()) else "one origin"
            yield f"{' and '.join(map(repr, names))} are one earthquake ({why}, {one.more})"


def _doubts_within(found: list[_Earthquake]) -> Iterable[str]:
    """Doubts about records that count as one earthquake only because of their name."""
    for one in found:
        loose = [each for each in one.members.values() if not (each.event_id or each.origin or each.synthetic)]
        started = sorted((each.start, each.record_id) for each in loose if each.start)
        if started:
            started = sorted(
                [*started, *((each.origin, each.record_id) for each in one.stated.values() if each.origin)]
            )
        if len(loose) > 1 and not one.name:
            ids = _listed_ids(loose)
            yield f"{len(loose)} records ({ids}) name no earthquake and count as one; give event or event_id"
        elif started and started[-1][0] - started[0][0] > MAX_NAMED_DIFFERENCE:
            hours = (started[-1][0] - started[0][0]).total_seconds() / 3600
            ids = f"{started[0][1]} and {started[-1][1]}"
            yield f"{one.name!r}: records {ids} start {hours:.3g} h apart and count as one earthquake; give event_id"


def _doubts_of_split(found: list[_Earthquake]) -> Iterable[str]:
    """Doubts about earthquakes that count as several, although they have one name, because of their origins."""
    of_name: dict[str, list[_Earthquake]] = {}
    for one in found:
        if one.name and not any(each.event_id for each in one.stated.values()):
            of_name.setdefault(one.name.casefold(), []).append(one)
    for several in of_name.values():
        if len(several) > 1:
            origins = ", ".join(f"{one.more} {one.first.record_id}" for one in several)
            yield (
                f"{several[0].name!r} names {len(several)} earthquakes by their origins ({origins}); give event_id if "
                "it is one"
            )


def _listed_ids(records: list[_EarthquakeData]) -> str:
    return ", ".join(one.record_id for one in records[:3]) + (", …" if len(records) > 3 else "")


def _doubts_between(found: list[_Earthquake]) -> Iterable[str]:
    """Doubts about earthquakes that count as two only because of their names."""
    named = [(one, _name_and_date(one)) for one in found if one.name and not one.first.synthetic]
    for (first, words), (second, others) in combinations(named, 2):
        if words[1] and others[1] and words[1] != others[1]:
            continue
        if any(a.same(b) is False for a in first.stated.values() for b in second.stated.values()):
            continue
        begun, other_begun = first.first.start, second.first.start
        together = begun is not None and other_begun is not None and abs(begun - other_begun) <= MAX_START_DIFFERENCE
        if together or _are_similar(words, others):
            why = "have records that start together" if together else "resemble each other"
            yield (
                f"{first.name!r} ({first.first.record_id}) and {second.name!r} ({second.first.record_id}) {why} and "
                "count as two earthquakes; give both one event_id, or each its own"
            )


def _name_and_date(one: _Earthquake) -> tuple[str, str, tuple[int, ...]]:
    """Words of an earthquake's name, its year, and day and month in whichever order; empty where not known."""
    name = one.name.casefold()
    year: str = ""
    day: tuple[int, ...] = ()
    if match := next((found for pattern in _DATES if (found := pattern.search(name))), None):
        date = match.groupdict()
        year = date["year"][-2:]
        if "day" in date:
            month = date["month"][:3]
            day = tuple(sorted((_MONTHS.index(month) + 1 if month in _MONTHS else int(month), int(date["day"]))))
        name = f"{name[: match.start()]} {name[match.end() :]}"
    name = _FILLING.sub(" ", re.sub(r"\d+:[\d:.]+", " ", name))
    return " ".join(re.findall(r"\w+", name)), year, day


def _are_similar(first: tuple[str, str, tuple[int, ...]], second: tuple[str, str, tuple[int, ...]]) -> bool:
    """Whether two names of one year may be one: no other day or number, and words alike or among the other's."""
    (words, _, day), (others, _, other_day) = first, second
    if day and other_day and day != other_day:
        return False
    if not (words and others):
        return bool(day and day == other_day)
    numbers, other_numbers = (set(re.findall(r"\d+", text)) for text in (words, others))
    if numbers and other_numbers and numbers != other_numbers:
        return False
    fewer, more = sorted((set(words.split()), set(others.split())), key=len)
    matcher = difflib.SequenceMatcher(None, words, others)
    return fewer <= more or (
        matcher.real_quick_ratio() >= MIN_NAME_SIMILARITY and matcher.ratio() >= MIN_NAME_SIMILARITY
    )
