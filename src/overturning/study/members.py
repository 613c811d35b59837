"""The members of an ensemble: scrambled Sobol points in the stated neighbourhood of a case."""

import csv
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.files import atomic_write, checksum_matches, seal
from overturning.study.sections import Ensemble

SCRAMBLES = 2
"""Independent scrambles; the difference between their means shows how well the members know the probability."""

COLUMNS = ("scramble", "amplitude", "b_over_h", "friction", "damping", "azimuth_deg", "initial_tilt")


@dataclass(frozen=True)
class Members:
    """What each member changes, the same for every cell.

    Attributes
    ----------
    scramble : ndarray of int, shape (n,)
        Which scramble the member belongs to, 0 or 1.
    amplitude, b_over_h, friction, damping : ndarray, shape (n,)
        Factors.
    azimuth_deg : ndarray, shape (n,)
        Turn of the sensor, degrees, added to the azimuth.
    initial_tilt : ndarray, shape (n,)
        Rotation at the start, rad.
    """

    scramble: NDArray[np.int64]
    amplitude: FloatArray
    b_over_h: FloatArray
    friction: FloatArray
    damping: FloatArray
    azimuth_deg: FloatArray
    initial_tilt: FloatArray

    @property
    def size(self) -> int:
        """Number of members."""
        return int(self.scramble.size)

    def some(self, chosen: NDArray[np.intp]) -> "Members":
        """Some of the members."""
        return Members(**{item.name: getattr(self, item.name)[chosen] for item in fields(self)})

    def batches(self, size: int) -> list[NDArray[np.intp]]:
        """The members in the order in which they are run: batches of `size`, the next ones of each scramble in turn."""
        own = [np.flatnonzero(self.scramble == scramble) for scramble in range(SCRAMBLES)]
        each = size // SCRAMBLES
        return [
            np.concatenate([places[start : start + each] for places in own])
            for start in range(0, max(places.size for places in own), each)
        ]


def draw_members(settings: Ensemble) -> Members:
    """Draw the members: two scrambles of one Sobol sequence.

    Owen (1998), ACM Transactions on Modeling and Computer Simulation 8.

    Parameters
    ----------
    settings : Ensemble
        Number, half-widths and seed.

    Returns
    -------
    Members
        Rounded to 1e-9, so that the file they are kept in holds the very same numbers.
    """
    from scipy.stats import qmc

    half = settings.members // SCRAMBLES
    streams = np.random.SeedSequence(settings.seed).spawn(SCRAMBLES)
    power = max(half - 1, 0).bit_length()  # the sequence is made in powers of two; its beginning is the same in each
    points = np.concatenate(
        [
            qmc.Sobol(d=6, scramble=True, rng=np.random.Generator(np.random.PCG64(stream))).random_base2(power)[:half]
            for stream in streams
        ]
    )
    offset = 2 * points - 1
    widths = (settings.amplitude, settings.b_over_h, settings.friction, settings.damping)
    factors = [np.round(1 + width * offset[:, column], 9) for column, width in enumerate(widths)]
    return Members(
        scramble=np.repeat(np.arange(SCRAMBLES), half),
        amplitude=factors[0],
        b_over_h=factors[1],
        friction=factors[2],
        damping=factors[3],
        azimuth_deg=np.round(settings.azimuth * offset[:, 4], 9),
        initial_tilt=np.round(settings.initial_tilt * offset[:, 5], 9),
    )


def write_members(members: Members, path: Path) -> None:
    """Write the members as CSV, with a checksum."""
    with atomic_write(path) as part:
        with part.open("w", encoding="utf-8", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(COLUMNS)
            for row in range(members.size):
                table.writerow([repr(getattr(members, name)[row].item()) for name in COLUMNS])
        seal(part)


def read_members(path: Path) -> Members:
    """Read members written by `write_members`.

    Raises
    ------
    ResultError
        If the file is missing, damaged or none of ours.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            header, *rows = list(csv.reader(line for line in file if line.strip() and not line.startswith("#")))
        if tuple(header) != COLUMNS or not checksum_matches(path):
            raise ValueError(header)
        table = np.array(rows, dtype=np.float64).reshape(-1, len(COLUMNS))
    except (OSError, ValueError):
        raise ResultError(
            f"{path}: damaged, or no table of ensemble members; run the study again, which makes it anew"
        ) from None
    columns = {name: table[:, column] for column, name in enumerate(COLUMNS) if name != "scramble"}
    return Members(scramble=table[:, 0].astype(np.int64), **columns)
