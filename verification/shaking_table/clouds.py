"""Random rectangles and prisms from wide ranges of size, simulated under the measured motion of every test."""

import hashlib
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from overturning.arrays import FloatArray
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import run_cases, simulate_cases
from overturning.files import atomic_write
from overturning.kernel_cache import sources_digest
from overturning.model.cases import Cases
from overturning.model.shapes import RectangularPrism
from overturning.motion.motion import Motion
from verification.shaking_table.data import ShakingTableTests

SEED: Final = 1
AMPLITUDE_FACTOR_RANGE: Final = (1 / 1.15, 1.15)
PRISM_DEPTH_OVER_WIDTH: Final = 1.15
"""D/B of the prisms, as for the boulder: 0.77 m / 0.67 m."""

NEIGHBOURHOOD_CENTRE_B_OVER_H: Final = np.geomspace(0.07, 0.33, 36)
NEIGHBOURHOOD_CENTRE_HEIGHTS_M: Final = np.geomspace(0.40, 1.60, 16)
"""Centres of the neighbourhoods: B/H, and height in m."""

NEIGHBOURHOOD_HALF_WIDTH_LN_B_OVER_H: Final = np.log(1.3)
NEIGHBOURHOOD_HALF_WIDTH_LN_HEIGHT: Final = np.log(1.65)
"""Half-widths of a neighbourhood in ln B/H and ln H; all stones within count equally."""

StoneParameters = dict[str, FloatArray]


class RandomStoneBoundsAndFallSimulator(NamedTuple):
    """Distribution of random stones: their number, bounds of each parameter, and function that simulates them."""

    name: str
    stone_count: int
    bounds_by_parameter: dict[str, tuple[float, float]]
    simulate_falls: Callable[[Motion, StoneParameters], NDArray[np.bool_]]


class StonesWithSimulatedOutcomes(NamedTuple):
    """Parameters of random stones, shape (stones,), and their simulated outcomes, shape (tests, stones)."""

    b_over_h: FloatArray
    height: FloatArray
    damping_ratio_over_default: FloatArray
    """Damping ratio divided by that of the default contact."""
    fell_by_test_and_stone: NDArray[np.bool_]


def _rectangles_fall(motion: Motion, stone_values_by_parameter_name: StoneParameters) -> NDArray[np.bool_]:
    """Return True for the rectangles (2-D) that fall under a motion."""
    cases = Cases(
        0.0,
        stone_values_by_parameter_name["height"],
        stone_values_by_parameter_name["b_over_h"],
        stone_values_by_parameter_name["friction"],
        stone_values_by_parameter_name["amplitude"],
        stone_values_by_parameter_name["damping"],
    )
    return np.asarray(np.abs(run_cases(motion, cases).overturned) == 1)


def _prisms_fall(motion: Motion, stone_values_by_parameter_name: StoneParameters) -> NDArray[np.bool_]:
    """Return True for the prisms (3-D) that fall under a motion."""
    cases = Cases(
        stone_values_by_parameter_name["orientation"],
        stone_values_by_parameter_name["height"],
        stone_values_by_parameter_name["b_over_h"],
        stone_values_by_parameter_name["friction"],
        stone_values_by_parameter_name["amplitude"],
        stone_values_by_parameter_name["damping"],
        aspect=PRISM_DEPTH_OVER_WIDTH,
    )
    return np.asarray(simulate_cases(RectangularPrism(), motion, cases, NumericalOptions()).overturned == 1)


_COMMON_PARAMETER_BOUNDS: Final[dict[str, tuple[float, float]]] = {
    "friction": (0.4, 1.0), "damping": (0.3, 3.0), "amplitude": AMPLITUDE_FACTOR_RANGE,
}  # fmt: skip
RECTANGLE_DISTRIBUTION: Final = RandomStoneBoundsAndFallSimulator(
    "rectangles", 4096, {"b_over_h": (0.05, 0.45), "height": (0.3, 2.0), **_COMMON_PARAMETER_BOUNDS}, _rectangles_fall
)
PRISM_DISTRIBUTION: Final = RandomStoneBoundsAndFallSimulator(
    "prisms", 384,
    {"b_over_h": (0.05, 0.2), "height": (0.4, 1.5), **_COMMON_PARAMETER_BOUNDS, "orientation": (0.0, 90.0)},
    _prisms_fall,
)  # fmt: skip


_UNIFORMLY_DISTRIBUTED_PARAMETERS: Final = ("friction", "orientation")
"""Parameters with a uniform distribution; the logarithms of the others have one."""


def sample_stones(distribution: RandomStoneBoundsAndFallSimulator, stone_count: int) -> StoneParameters:
    """Return parameters of random stones: scrambled Sobol points within the bounds of each parameter."""
    unit = qmc.Sobol(len(distribution.bounds_by_parameter), seed=SEED).random(stone_count).T
    return {
        name: low + (high - low) * u if name in _UNIFORMLY_DISTRIBUTED_PARAMETERS else low * (high / low) ** u
        for (name, (low, high)), u in zip(distribution.bounds_by_parameter.items(), unit, strict=True)
    }


def is_in_any_candidate_size_range(stone_values_by_parameter_name: StoneParameters) -> NDArray[np.bool_]:
    """Return True for stones within one of the neighbourhoods of B/H and height among which a model chooses."""
    shape, size = np.log(stone_values_by_parameter_name["b_over_h"]), np.log(stone_values_by_parameter_name["height"])
    ends = [
        (np.log(centres[[0, -1]]), width)
        for centres, width in (
            (NEIGHBOURHOOD_CENTRE_B_OVER_H, NEIGHBOURHOOD_HALF_WIDTH_LN_B_OVER_H),
            (NEIGHBOURHOOD_CENTRE_HEIGHTS_M, NEIGHBOURHOOD_HALF_WIDTH_LN_HEIGHT),
        )
    ]
    return np.logical_and.reduce([
        (low - width < of) & (of < high + width) for of, ((low, high), width) in zip((shape, size), ends, strict=True)
    ])  # fmt: skip


def simulate_random_stones_or_read_outcomes(
    distribution: RandomStoneBoundsAndFallSimulator,
    tests: ShakingTableTests,
    cache_folder: Path | None = None,
    *,
    stone_count: int | None = None,
    threads: int = 1,
) -> StonesWithSimulatedOutcomes:
    """Simulate random stones under the motion of every test, or read those that an earlier run of this code stored.

    Parameters
    ----------
    distribution : RandomStoneBoundsAndFallSimulator
        Kind of stone.
    tests : ShakingTableTests
        The tests.
    cache_folder : Path, optional
        Folder in which the results are stored.
    stone_count, threads : int
        Number of stones to draw (default: that of the kind), and of tests to run at the same time.
    """
    stone_count = stone_count or distribution.stone_count
    rows = sample_stones(distribution, stone_count)
    chosen = is_in_any_candidate_size_range(rows)
    rows = {name: values[chosen] for name, values in rows.items()}
    key = hashlib.sha256(sources_digest(Path(__file__).parent).encode())
    key.update(b"".join(one.tobytes() for one in tests.accelerations))
    path = cache_folder / f"{distribution.name}-{stone_count}-{key.hexdigest()[:16]}.npy" if cache_folder else None
    members = int(chosen.sum())
    if path is not None and path.is_file():
        packed: NDArray[Any] = np.load(path)
        fell = np.unpackbits(packed, axis=1, count=members).astype(bool)
    else:
        fell = np.zeros((len(tests.accelerations), members), dtype=bool)
        begin = time.monotonic()
        # The kernel releases Python's lock, so one test is planned while another one runs.
        with ThreadPoolExecutor(threads) as pool:
            found = pool.map(
                lambda index: distribution.simulate_falls(tests.measured_motion(index), rows), range(len(fell))
            )
            for index, falls in enumerate(found):
                fell[index] = falls
                _print_progress(distribution.name, index + 1, len(fell), time.monotonic() - begin)
        if path is not None:
            with atomic_write(path) as part, part.open("wb") as file:
                np.save(file, np.packbits(fell, axis=1))
    return StonesWithSimulatedOutcomes(rows["b_over_h"], rows["height"], rows["damping"], fell)


def _print_progress(stone_kind_name: str, finished_test_count: int, total_count: int, elapsed_time_s: float) -> None:
    """Print the number of simulated tests: updated in place on a terminal, otherwise a line for each tenth."""
    remaining_time_s = elapsed_time_s / finished_test_count * (total_count - finished_test_count)
    line = f"{stone_kind_name}: {finished_test_count} of {total_count} tests, {remaining_time_s:.0f} s to go"
    if sys.stderr.isatty():
        print(f"\r{line:<60}", end="\n" if finished_test_count == total_count else "", file=sys.stderr, flush=True)
    elif finished_test_count * 10 // total_count > (finished_test_count - 1) * 10 // total_count:
        print(line, file=sys.stderr, flush=True)
