"""The cases on which error is set against run time: records with and without sliding, sine pulses, sliding blocks."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.inputs import RECORDS, motion_of

FRICTIONS: Final = {"sliding": (0.33, 0.58), "rocking": (1.0, 10.0)}
"""Frictions at which many blocks of the set slide, and at which they rock."""

NO_SLIDING: Final = 10.0
"""μ at which nothing slides."""

_AXES: Final = ("azimuth_deg", "height", "b_over_h", "friction", "amplitude")


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

    def case(self, index: int) -> dict[str, float]:
        """Azimuth (degrees), height (m), B/H, friction and amplitude of one case."""
        return {name: float(np.asarray(getattr(self.cases, name))[index]) for name in _AXES}

    def taken(self, chosen: NDArray[np.int64]) -> "Group":
        """The same motion with some of the cases."""
        kept = self.cases
        return Group(self.motion, Cases(**{name: np.asarray(getattr(kept, name))[chosen] for name in _AXES}))


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
    return [Group(motion_of(source), Cases(*grid)) for source in RECORDS.values()]


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
    return [Group(motion_of(source), Cases(20.0, 0.2, 4.0, friction)) for source in RECORDS.values()]


def thinned(groups: Sequence[Group], every: int) -> list[Group]:
    """Every so many cases of each group."""
    return [group.taken(np.arange(0, group.cases.size, every)) for group in groups]


def thinned_values(groups: Sequence[Group], values: NDArray[Any], every: int) -> NDArray[Any]:
    """The values, of all groups' cases in a row, that belong to `thinned` groups."""
    ends = np.cumsum([group.cases.size for group in groups])[:-1]
    return np.concatenate([part[::every] for part in np.split(values, ends)])
