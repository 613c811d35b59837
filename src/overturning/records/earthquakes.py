"""Group the records of a study by earthquake.

All confidence intervals resample earthquakes, so one earthquake under two names would count twice.
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
from overturning.records.catalogue import RecordTableRow, convert_to_utc_text
from overturning.records.record import Record
from overturning.units import EARTH_RADIUS_KM

MAX_ORIGIN_TIME_DIFFERENCE_OF_ONE_EARTHQUAKE: Final = timedelta(seconds=60)
"""Largest difference between origin times of one earthquake: old headers round them to the minute."""

MAX_EPICENTRE_DIFFERENCE_OF_ONE_EARTHQUAKE_KM: Final = 100.0
"""Largest distance between epicentres of one earthquake from different agencies, km."""

MAX_START_DIFFERENCE_SUGGESTING_SAME_EARTHQUAKE: Final = timedelta(minutes=2)
"""Largest difference between the starts of two records that are probably of the same earthquake."""

MAX_START_DIFFERENCE_WITHOUT_DOUBT_FOR_SAME_NAME: Final = timedelta(hours=1)
"""Largest difference between the starts of two records with one earthquake name that raises no doubt."""

MIN_SIMILARITY_OF_EARTHQUAKE_NAMES: Final = 0.85
"""Smallest similarity of two names of one earthquake (difflib: twice the matching letters over all letters)."""

MAX_LISTED_DOUBTFUL_ASSIGNMENTS: Final = 10
"""Largest number of doubts that are listed one by one."""

_IGNORED_WORDS_OF_EARTHQUAKE_NAMES: Final = re.compile(
    r"\b(rcrd|record|earthquake|eq|of|the|(?:mon|tue|wed|thu|fri|sat|sun)|jst|utc?|gmt|epicentre.*)\b"
)
_MONTHS: Final = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"]
_MONTH_PATTERN: Final = rf"(?:\d\d?|(?:{'|'.join(_MONTHS)})[a-z]*)"
_DATE_PATTERNS: Final = (
    re.compile(rf"\b(?P<year>(?:1[89]|20)\d\d)[-/ ](?P<month>{_MONTH_PATTERN})[-/ ](?P<day>\d\d?)\b"),
    re.compile(rf"\b(?P<month>{_MONTH_PATTERN})[-/ ]\s*(?P<day>\d\d?)[-/, ]\s*(?P<year>(?:1[89]|20)?\d\d)\b"),
    re.compile(r"\b(?P<year>(?:1[89]|20)\d\d)\b"),
)
"""Patterns of dates in earthquake names; the order of day and month does not matter."""


@dataclass(frozen=True)
class _EarthquakeMetadataOfRecord:
    """Metadata of one record by which its earthquake is identified: names, ids, times and epicentre."""

    record_id: str
    earthquake_name: str
    event_id: str = ""
    origin_time_utc: datetime | None = None
    epicentre_latitude_longitude_deg: tuple[float, float] | None = None
    record_start_utc: datetime | None = None  # of the record
    is_synthetic: bool = False

    def is_same_earthquake_if_known(self, other_record_metadata: "_EarthquakeMetadataOfRecord") -> bool | None:
        """Return whether two records are of one earthquake, by event ids or origins; None if these are unknown."""
        if self.event_id and other_record_metadata.event_id:
            return self.event_id == other_record_metadata.event_id
        if self.origin_time_utc is None or other_record_metadata.origin_time_utc is None:
            return None
        near = (
            self.epicentre_latitude_longitude_deg is None
            or other_record_metadata.epicentre_latitude_longitude_deg is None
            or great_circle_distance_km(
                self.epicentre_latitude_longitude_deg, other_record_metadata.epicentre_latitude_longitude_deg
            )
            <= MAX_EPICENTRE_DIFFERENCE_OF_ONE_EARTHQUAKE_KM
        )
        return (
            near
            and abs(self.origin_time_utc - other_record_metadata.origin_time_utc)
            <= MAX_ORIGIN_TIME_DIFFERENCE_OF_ONE_EARTHQUAKE
        )


def _earthquake_metadata_of_record(record: Record | RecordTableRow) -> _EarthquakeMetadataOfRecord:
    """Return the metadata that identify the earthquake of a record or of a row of the record table."""
    times: tuple[str | None, str | None]  # origin, and start of the record
    if isinstance(record, RecordTableRow):
        named, stated, times = record.id, record.model_dump(), (record.origin_time, None)
        place = (record.epicentre_latitude_deg, record.epicentre_longitude_deg)
    else:
        named, stated, times = record.record_id, record.extra, (record.extra.get("origin_time"), record.start)
        place = (stated.get("event_latitude"), stated.get("event_longitude"))
    try:
        origin, start = (datetime.fromisoformat(convert_to_utc_text(text)) if text else None for text in times)
    except ValueError as fault:  # of a `Record` made in Python
        raise ArgumentError(f"record {named}: start {times[1]!r}, origin time {times[0]!r}: {fault}") from None
    return _EarthquakeMetadataOfRecord(
        named,
        " ".join(record.event.split()),
        stated.get("event_id", ""),
        origin,
        None if place[0] is None or place[1] is None else (float(place[0]), float(place[1])),
        start,
        stated.get("format") == "synthetic",
    )


def great_circle_distance_km(
    first_latitude_longitude_deg: tuple[float, float], second_latitude_longitude_deg: tuple[float, float]
) -> float:
    """Return the great-circle distance between two places (latitude, longitude in degrees), km (haversine formula)."""
    (lat1, lon1), (lat2, lon2) = np.radians(first_latitude_longitude_deg), np.radians(second_latitude_longitude_deg)
    half = np.sin((lat2 - lat1) / 2) ** 2 + np.cos(lat1) * np.cos(lat2) * np.sin((lon2 - lon1) / 2) ** 2
    return float(2 * EARTH_RADIUS_KM * np.arcsin(np.sqrt(min(half, 1.0))))


@dataclass
class _RecordsOfEarthquake:
    """Records that belong to one earthquake, each with its index in the study and its metadata."""

    metadata_by_record_index: dict[int, _EarthquakeMetadataOfRecord] = field(default_factory=dict)
    first_metadata_by_id_origin_time_and_epicentre: dict[tuple[Any, ...], _EarthquakeMetadataOfRecord] = field(
        default_factory=dict
    )  # the first member with each id and origin
    original_name_by_lower_case_name: dict[str, str] = field(default_factory=dict)  # lower-case name: name as written

    def add_record(self, record_index: int, record_metadata: _EarthquakeMetadataOfRecord) -> None:
        """Add a record, given by its index in the study and its metadata, to the records of the earthquake."""
        self.metadata_by_record_index[record_index] = record_metadata
        self.first_metadata_by_id_origin_time_and_epicentre.setdefault(
            (
                record_metadata.event_id,
                record_metadata.origin_time_utc,
                record_metadata.epicentre_latitude_longitude_deg,
            ),
            record_metadata,
        )
        self.original_name_by_lower_case_name.setdefault(
            record_metadata.earthquake_name.casefold(), record_metadata.earthquake_name
        )

    def matches_earthquake_of_record(self, record_metadata: _EarthquakeMetadataOfRecord) -> bool:
        """Return True if a record belongs to this earthquake: by id or origin time, or else by name."""
        certain = [
            same
            for member in self.first_metadata_by_id_origin_time_and_epicentre.values()
            if (same := member.is_same_earthquake_if_known(record_metadata)) is not None
        ]
        named = record_metadata.earthquake_name.casefold() in self.original_name_by_lower_case_name and (
            record_metadata.earthquake_name != "" or not self.event_id_or_origin_time
        )
        return all(certain) if certain else named

    @property
    def first_record_metadata(self) -> _EarthquakeMetadataOfRecord:
        """Metadata of the first record of the earthquake."""
        return self.metadata_by_record_index[min(self.metadata_by_record_index)]

    @property
    def name_or_id_or_origin_time(self) -> str:
        """Name of the earthquake in the first of its records that states one; else its id or origin time."""
        named = [
            self.metadata_by_record_index[index].earthquake_name
            for index in sorted(self.metadata_by_record_index)
            if self.metadata_by_record_index[index].earthquake_name
        ]
        return named[0] if named else self.event_id_or_origin_time

    @property
    def event_id_or_origin_time(self) -> str:
        """Id or origin time of the earthquake, to distinguish earthquakes of the same name; "" if unknown."""
        ids = [one.event_id for one in self.first_metadata_by_id_origin_time_and_epicentre.values() if one.event_id]
        origins = [
            f"{one.origin_time_utc:%Y-%m-%d %H:%M}"
            for one in self.first_metadata_by_id_origin_time_and_epicentre.values()
            if one.origin_time_utc
        ]
        return next(iter(ids + origins), "")


@dataclass(frozen=True)
class RecordEarthquakesAndAssignmentNotes:
    """Earthquake of each record of a study, with notes on doubtful assignments."""

    earthquake_labels_in_record_order: tuple[str, ...]  # label of each record; equal for records of one earthquake only
    notes_on_earthquakes_with_several_names: tuple[str, ...]  # one sentence per earthquake with several names
    doubtful_assignment_notes: tuple[str, ...]  # one sentence per doubtful assignment, with names and remedy

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on earthquakes with several names, and on up to ten doubtful assignments of records."""
        left_out = len(self.doubtful_assignment_notes) - MAX_LISTED_DOUBTFUL_ASSIGNMENTS
        more = (f"{left_out} more doubts of this kind",) if left_out > 0 else ()
        return (
            *self.notes_on_earthquakes_with_several_names,
            *self.doubtful_assignment_notes[:MAX_LISTED_DOUBTFUL_ASSIGNMENTS],
            *more,
        )


def assign_records_to_earthquakes(records: Iterable[Record | RecordTableRow]) -> RecordEarthquakesAndAssignmentNotes:
    """Assign each record of a study to an earthquake; return one label per record, and notes on doubts.

    Two records that have an ``event_id`` (record table) are of one earthquake if the ids are equal. Otherwise, two
    records with origin times are of one earthquake if these are within 60 s and the epicentres, if both are known,
    within 100 km; their names do not matter. If an origin time is unknown, equal names (ignoring case) mean one
    earthquake. Records without id, origin time and name count as one earthquake, so that no confidence interval over
    earthquakes becomes too narrow.

    Labels are in the order of the records. Doubts are: similar names without different dates, records with two names
    that start together, one name with several origins, and records with one name that start more than an hour apart.
    """
    known = [_earthquake_metadata_of_record(record) for record in records]
    found: list[_RecordsOfEarthquake] = []
    unclear = []
    # Assign records with ids and origins first; records with names only then join these earthquakes.
    for index in sorted(range(len(known)), key=lambda i: (not known[i].event_id, known[i].origin_time_utc is None)):
        homes = [one for one in found if one.matches_earthquake_of_record(known[index])]
        if not homes:
            homes = [_RecordsOfEarthquake()]
            found += homes
        elif len(homes) > 1:
            names = " or ".join(f"{one.name_or_id_or_origin_time!r} ({one.event_id_or_origin_time})" for one in homes)
            unclear.append(f"record {known[index].record_id} may be of {names} and counts as the first; give event_id")
        homes[0].add_record(index, known[index])
    found.sort(key=lambda one: min(one.metadata_by_record_index))
    return RecordEarthquakesAndAssignmentNotes(
        _earthquake_label_of_each_record(found),
        tuple(_notes_on_earthquakes_with_several_names(found)),
        (
            *unclear,
            *_notes_on_names_shared_by_earthquakes(found),
            *_warnings_on_records_of_uncertain_earthquake(found),
            *_warnings_on_earthquakes_possibly_identical(found),
        ),
    )


def _earthquake_label_of_each_record(earthquakes: list[_RecordsOfEarthquake]) -> tuple[str, ...]:
    """Return the earthquake name of each record; id or origin time is added if several earthquakes share the name."""
    names = Counter(one.name_or_id_or_origin_time for one in earthquakes)
    labels: dict[int, str] = {}
    taken: set[str] = set()
    for one in earthquakes:
        name, more = one.name_or_id_or_origin_time, one.event_id_or_origin_time
        label = f"{name} ({more})" if names[name] > 1 and more and more != name else name
        while label in taken:
            label += "'"
        taken.add(label)
        labels |= dict.fromkeys(one.metadata_by_record_index, label)
    return tuple(labels[index] for index in sorted(labels))


def _notes_on_earthquakes_with_several_names(earthquakes: list[_RecordsOfEarthquake]) -> Iterable[str]:
    """Yield a note for each earthquake to which records with different earthquake names are assigned."""
    for one in earthquakes:
        names = [name for name in one.original_name_by_lower_case_name.values() if name]
        if len(names) > 1:
            why = (
                "one event_id"
                if any(each.event_id for each in one.first_metadata_by_id_origin_time_and_epicentre.values())
                else "one origin"
            )
            yield f"{' and '.join(map(repr, names))} are one earthquake ({why}, {one.event_id_or_origin_time})"


def _warnings_on_records_of_uncertain_earthquake(earthquakes: list[_RecordsOfEarthquake]) -> Iterable[str]:
    """Yield a warning for each earthquake with several nameless records, or with records that start over 1 h apart.

    Records with an event id or an origin time, and synthetic ones, are certain and cause no warning.
    """
    for one in earthquakes:
        loose = [
            each
            for each in one.metadata_by_record_index.values()
            if not (each.event_id or each.origin_time_utc or each.is_synthetic)
        ]
        started = sorted((each.record_start_utc, each.record_id) for each in loose if each.record_start_utc)
        if started:
            started = sorted(
                [
                    *started,
                    *(
                        (each.origin_time_utc, each.record_id)
                        for each in one.first_metadata_by_id_origin_time_and_epicentre.values()
                        if each.origin_time_utc
                    ),
                ]
            )
        if len(loose) > 1 and not one.name_or_id_or_origin_time:
            ids = _format_first_three_record_ids(loose)
            yield f"{len(loose)} records ({ids}) name no earthquake and count as one; give event or event_id"
        elif started and started[-1][0] - started[0][0] > MAX_START_DIFFERENCE_WITHOUT_DOUBT_FOR_SAME_NAME:
            hours = (started[-1][0] - started[0][0]).total_seconds() / 3600
            ids = f"{started[0][1]} and {started[-1][1]}"
            apart = f"records {ids} start {hours:.3g} h apart"
            yield f"{one.name_or_id_or_origin_time!r}: {apart} and count as one earthquake; give event_id"


def _notes_on_names_shared_by_earthquakes(earthquakes: list[_RecordsOfEarthquake]) -> Iterable[str]:
    """Yield a note for each name that several earthquakes with different origins, without event ids, have in common."""
    of_name: dict[str, list[_RecordsOfEarthquake]] = {}
    for one in earthquakes:
        if one.name_or_id_or_origin_time and not any(
            each.event_id for each in one.first_metadata_by_id_origin_time_and_epicentre.values()
        ):
            of_name.setdefault(one.name_or_id_or_origin_time.casefold(), []).append(one)
    for several in of_name.values():
        if len(several) > 1:
            origins = ", ".join(
                f"{one.event_id_or_origin_time} {one.first_record_metadata.record_id}" for one in several
            )
            yield (
                f"{several[0].name_or_id_or_origin_time!r} names {len(several)} earthquakes by their origins "
                f"({origins}); give event_id if it is one"
            )


def _format_first_three_record_ids(metadata_of_records: list[_EarthquakeMetadataOfRecord]) -> str:
    """Return the ids of the first three records as text, followed by … if there are more."""
    ids = [one.record_id for one in metadata_of_records]
    return ", ".join(ids[:3]) + (", …" if len(ids) > 3 else "")


def _warnings_on_earthquakes_possibly_identical(earthquakes: list[_RecordsOfEarthquake]) -> Iterable[str]:
    """Yield a warning for each pair of earthquakes that may be one: similar names, or records that start together."""
    named = [
        (one, _name_words_year_and_day_month(one))
        for one in earthquakes
        if one.name_or_id_or_origin_time and not one.first_record_metadata.is_synthetic
    ]
    for (first, words), (second, others) in combinations(named, 2):
        if words[1] and others[1] and words[1] != others[1]:
            continue
        if any(
            a.is_same_earthquake_if_known(b) is False
            for a in first.first_metadata_by_id_origin_time_and_epicentre.values()
            for b in second.first_metadata_by_id_origin_time_and_epicentre.values()
        ):
            continue
        begun, other_begun = first.first_record_metadata.record_start_utc, second.first_record_metadata.record_start_utc
        together = (
            begun is not None
            and other_begun is not None
            and abs(begun - other_begun) <= MAX_START_DIFFERENCE_SUGGESTING_SAME_EARTHQUAKE
        )
        if together or _may_name_same_earthquake(words, others):
            why = "have records that start together" if together else "resemble each other"
            yield (
                f"{first.name_or_id_or_origin_time!r} ({first.first_record_metadata.record_id}) and "
                f"{second.name_or_id_or_origin_time!r} "
                f"({second.first_record_metadata.record_id}) {why} and "
                "count as two earthquakes; give both one event_id, or each its own"
            )


def _name_words_year_and_day_month(earthquake: _RecordsOfEarthquake) -> tuple[str, str, tuple[int, ...]]:
    """Return the words, the two-digit year, and the sorted numbers of day and month in an earthquake's name."""
    name = earthquake.name_or_id_or_origin_time.casefold()
    year: str = ""
    day: tuple[int, ...] = ()
    if match := next((found for pattern in _DATE_PATTERNS if (found := pattern.search(name))), None):
        date = match.groupdict()
        year = date["year"][-2:]
        if "day" in date:
            month = date["month"][:3]
            day = tuple(sorted((_MONTHS.index(month) + 1 if month in _MONTHS else int(month), int(date["day"]))))
        name = f"{name[: match.start()]} {name[match.end() :]}"
    name = _IGNORED_WORDS_OF_EARTHQUAKE_NAMES.sub(" ", re.sub(r"\d+:[\d:.]+", " ", name))
    return " ".join(re.findall(r"\w+", name)), year, day


def _may_name_same_earthquake(
    words_year_and_day_month_of_first_name: tuple[str, str, tuple[int, ...]],
    words_year_and_day_month_of_second_name: tuple[str, str, tuple[int, ...]],
) -> bool:
    """Return True if two names, each as words, year, and day with month, may mean one earthquake.

    The words of the names must be similar, and days, or numbers among the words, must not differ. If a name has no
    words, the days must be equal.
    """
    (words, _, day), (others, _, other_day) = (
        words_year_and_day_month_of_first_name,
        words_year_and_day_month_of_second_name,
    )
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
        matcher.real_quick_ratio() >= MIN_SIMILARITY_OF_EARTHQUAKE_NAMES
        and matcher.ratio() >= MIN_SIMILARITY_OF_EARTHQUAKE_NAMES
    )
