"""Rectangles under every test's measured motion: a cloud of them, of which a fitted neighbourhood is an ensemble."""

import hashlib
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from overturning.arrays import FloatArray
from overturning.dem.cases import Cases
from overturning.dem.run import run_cases
from overturning.files import atomic_write
from overturning.study.sources import source_hash
from verification.shaking_table.data import Tests

COUNT: Final = 4096
SEED: Final = 1


class Bounds(NamedTuple):
    """Ends of the cloud; all but friction are spread evenly over the logarithm."""

    b_over_h: tuple[float, float] = (0.05, 0.45)
    height: tuple[float, float] = (0.3, 2.0)
    friction: tuple[float, float] = (0.4, 1.0)
    damping: tuple[float, float] = (0.3, 3.0)
    amplitude: tuple[float, float] = (0.6, 1 / 0.6)


BOUNDS: Final = Bounds()


class Cloud(NamedTuple):
    """Rectangles, each row shape (members,), and whether each fell in each test, shape (tests, members)."""

    b_over_h: FloatArray
    height: FloatArray
    amplitude: FloatArray
    fell: NDArray[np.bool_]


def rectangles(count: int = COUNT) -> dict[str, FloatArray]:
    """Scrambled Sobol points over `BOUNDS`, a row for each of its names."""
    unit = qmc.Sobol(len(BOUNDS), seed=SEED).random(count).T
    rows: dict[str, FloatArray] = {}
    for name, (low, high), u in zip(Bounds._fields, BOUNDS, unit, strict=True):
        rows[name] = low + (high - low) * u if name == "friction" else low * (high / low) ** u
    return rows


def cloud(tests: Tests, kept: Path | None = None, *, count: int = COUNT, threads: int = 1) -> Cloud:
    """Run every rectangle under every test, or read what was run before with the same sources.

    Parameters
    ----------
    tests : Tests
        The tests.
    kept : Path, optional
        Folder in which the outcome is kept.
    count, threads : int
        Rectangles, and threads to run them on.
    """
    rows = rectangles(count)
    key = hashlib.sha256(source_hash("verification.shaking_table.rectangles", Path("verification").resolve()).encode())
    key.update(b"".join(one.tobytes() for one in tests.acceleration))
    path = kept / f"cloud-{count}-{key.hexdigest()[:16]}.npy" if kept else None
    if path is not None and path.is_file():
        fell = np.unpackbits(np.load(path), axis=1, count=count).astype(bool)
    else:
        cases = Cases(0.0, rows["height"], rows["b_over_h"], rows["friction"], rows["amplitude"], rows["damping"])
        fell = np.zeros((len(tests.acceleration), count), dtype=bool)
        for index in range(len(tests.acceleration)):
            fell[index] = np.abs(run_cases(tests.ground(index), cases, threads=threads).overturned) == 1
        if path is not None:
            with atomic_write(path) as part, part.open("wb") as file:
                np.save(file, np.packbits(fell, axis=1))
    return Cloud(rows["b_over_h"], rows["height"], rows["amplitude"], fell)
