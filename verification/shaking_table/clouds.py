"""Stones under every test's measured motion: clouds of rectangles and of prisms, whose neighbourhoods are ensembles."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from overturning.arrays import FloatArray
from overturning.dem.numerics import Numerics
from overturning.dem.run import run, run_cases
from overturning.files import atomic_write
from overturning.model.cases import Cases
from overturning.model.contact import DAMPING_RATIO
from overturning.model.shapes import Rectangle
from overturning.motion.motion import Motion
from overturning.study.sources import source_hash
from verification.shaking_table.data import Tests

SEED: Final = 1
AMPLITUDE: Final = (1 / 1.15, 1.15)
ASPECT: Final = 1.15
"""D/B of the prisms: that of the boulder, 0.77 m over 0.67 m."""

Rows = dict[str, FloatArray]


class Kind(NamedTuple):
    """One kind of stone: how many are drawn, between which ends, and what runs them under a motion."""

    name: str
    stones: int
    bounds: dict[str, tuple[float, float]]
    fell: Callable[[Motion, Rows, int], NDArray[np.bool_]]


class Cloud(NamedTuple):
    """Stones, each row shape (members,), and whether each fell in each test, shape (tests, members)."""

    b_over_h: FloatArray
    height: FloatArray
    fell: NDArray[np.bool_]


def _rectangles_fell(motion: Motion, rows: Rows, threads: int) -> NDArray[np.bool_]:
    cases = Cases(0.0, rows["height"], rows["b_over_h"], rows["friction"], rows["amplitude"], rows["damping"])
    return np.asarray(np.abs(run_cases(motion, cases, threads=threads).overturned) == 1)


def _prisms_fell(motion: Motion, rows: Rows, threads: int) -> NDArray[np.bool_]:
    cases = Cases(
        rows["orientation"],
        rows["height"],
        rows["b_over_h"],
        rows["friction"],
        rows["amplitude"],
        rows["damping"],
        aspect=ASPECT,
    )
    numerics = Numerics(threads=threads)
    return np.asarray(run(Rectangle(), motion, cases, numerics).overturned == 1)


_CONTACT: Final[dict[str, tuple[float, float]]] = {
    "friction": (0.4, 1.0), "damping": (0.3, 3.0), "amplitude": AMPLITUDE,
}  # fmt: skip
RECTANGLES: Final = Kind(
    "rectangles", 4096, {"b_over_h": (0.05, 0.45), "height": (0.3, 2.0), **_CONTACT}, _rectangles_fell
)
PRISMS: Final = Kind(
    "prisms", 384, {"b_over_h": (0.05, 0.2), "height": (0.4, 1.5), **_CONTACT, "orientation": (0.0, 90.0)},
    _prisms_fell,
)  # fmt: skip


def with_damping(kind: Kind, ratio: float) -> Kind:
    """A kind whose stones all land with one damping ratio, rather than with any between its ends."""
    factor = ratio / DAMPING_RATIO
    return kind._replace(name=f"{kind.name}-{ratio:g}", bounds=kind.bounds | {"damping": (factor, factor)})


_EVEN: Final = ("friction", "orientation")
"""Spread evenly; all else is spread evenly over the logarithm."""


def drawn(kind: Kind, count: int) -> Rows:
    """Scrambled Sobol points between the ends of a kind, a row for each of its names."""
    unit = qmc.Sobol(len(kind.bounds), seed=SEED).random(count).T
    return {
        name: low + (high - low) * u if name in _EVEN else low * (high / low) ** u
        for (name, (low, high)), u in zip(kind.bounds.items(), unit, strict=True)
    }


def cloud(kind: Kind, tests: Tests, kept: Path | None = None, *, count: int | None = None, threads: int = 1) -> Cloud:
    """Run every stone of a kind under every test, or read what was run before with the same sources.

    Parameters
    ----------
    kind : Kind
        What is run.
    tests : Tests
        The tests.
    kept : Path, optional
        Folder in which the outcome is kept.
    count, threads : int
        Stones, the kind's own number where not given, and threads to run them on.
    """
    count = count or kind.stones
    rows = drawn(kind, count)
    key = hashlib.sha256(source_hash("verification.shaking_table.clouds", Path("verification").resolve()).encode())
    key.update(b"".join(one.tobytes() for one in tests.acceleration))
    path = kept / f"{kind.name}-{count}-{key.hexdigest()[:16]}.npy" if kept else None
    if path is not None and path.is_file():
        packed: NDArray[Any] = np.load(path)
        fell = np.unpackbits(packed, axis=1, count=count).astype(bool)
    else:
        fell = np.zeros((len(tests.acceleration), count), dtype=bool)
        for index in range(len(tests.acceleration)):
            fell[index] = kind.fell(tests.ground(index), rows, threads)
        if path is not None:
            with atomic_write(path) as part, part.open("wb") as file:
                np.save(file, np.packbits(fell, axis=1))
    return Cloud(rows["b_over_h"], rows["height"], fell)
