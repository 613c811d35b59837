"""Which cases of a study are run again, and the study's answers to them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.study.netcdf import open_raw
from overturning.study.sections import Verification

_CHANCES: Final = ("probability_towards", "probability_away", "probability_falls")
"""Variables of a cube with an ensemble whose sum is the share of members that fall."""

_ROUNDING: Final = 1e-6


@dataclass(frozen=True)
class Sample:
    """Cases in the random order in which they are run again, with the study's answers."""

    record: NDArray[np.int64]  # position of the record, shape (n,)
    index: NDArray[np.int64]  # positions along the dimensions of the study, shape (n, 4), or (n, 5) in space
    overturned: NDArray[np.int8]  # the study's flags, shape (n, elements); one column for a block
    status: NDArray[np.int8]  # how they were found, shape (n,)
    computed: int  # cases of the study that were not mirrored, nor repeated in space
    divided: NDArray[
        np.bool_
    ]  # some members of the ensemble fall and others stand, like `overturned`; False without one
    azimuth: NDArray[np.float32] | None = None  # in space, the azimuths to which they fall, shape (n,)

    @property
    def size(self) -> int:
        """Number of cases."""
        return len(self.record)


def choose(
    settings: Verification, records: int, computed: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Choose cells of a study at random, each at most once: of each its record, shape (n,), and its index.

    Any first part of the choice is a random choice too. Cells that are not `computed`, an array like the grid, the same
    for every record, are not chosen: they mirror others and would be the same computation again.
    """
    cells = np.argwhere(computed)
    total = records * len(cells)
    wanted = min(total, max(settings.at_least, round(settings.share * records * computed.size)))
    generator = np.random.Generator(np.random.PCG64(settings.seed))
    chosen = generator.permutation(total)[:wanted]
    return chosen // len(cells), cells[chosen % len(cells)]


def read_sample(cube: Path, settings: Verification) -> Sample:
    """Choose cells of a cube and read the study's answers to them; a ResultError where the cube cannot be read."""
    with open_raw(cube, "opened", "run the study again") as file:
        records = file.dimensions["record"].size
        # The answers as recorded, where a study has its motions at several amplitudes.
        recorded = (int(np.flatnonzero(file["amplitude"][:] == 1.0)[0]),) if "amplitude" in file.dimensions else ()
        computed = file["mirrored" if "mirrored" in file.variables else "repeated"][(0, *recorded)] == 0
        record, index = choose(settings, records, computed)
        flags = file["overturned"]
        elements = flags.shape[-1] if "element" in flags.dimensions else 1
        overturned, status = np.zeros((record.size, elements), np.int8), np.zeros(record.size, np.int8)
        divided = np.zeros(overturned.shape, np.bool_)
        chances = [file[name] for name in _CHANCES if name in file.variables]
        azimuth = np.zeros(record.size, np.float32) if "fall_azimuth" in file.variables else None
        for number in range(records):
            rows = np.flatnonzero(record == number)
            where = tuple(index[rows].T)
            overturned[rows] = flags[(number, *recorded)][where].reshape(rows.size, elements)
            status[rows] = file["status"][(number, *recorded)][where]
            if chances:
                falls = sum(chance[(number, *recorded)][where].reshape(rows.size, elements) for chance in chances)
                divided[rows] = (falls > 0) & (falls < 1 - _ROUNDING)
            if azimuth is not None:
                azimuth[rows] = file["fall_azimuth"][(number, *recorded)][where]
    return Sample(record, index, overturned, status, records * int(computed.sum()), divided, azimuth)
