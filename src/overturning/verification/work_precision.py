"""Error against run time: settings, measuring, and rows of the table, for all parts alike."""

import time
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.contact import STATIC_PENETRATION, Contact
from overturning.dem.run import run_cases
from overturning.dem.time_step import AUTO_FRACTION, DEFAULT_SCHEME, scheme_of
from overturning.verification.measures import counts, rotation_error
from overturning.verification.work_precision_cases import Group

FloatArray = NDArray[np.float64]
Say = Callable[[str], None]

FRACTIONS: Final = (1.0, 0.9, 0.5, 0.25, 0.12, 0.06, 0.03, 0.01)
"""Δt/Δt_stable."""

PENETRATIONS: Final = (2e-3, 2e-4, 2e-5, 2e-6)
"""δ/B."""

SCHEMES: Final = ("centred", "cundall")
REPEATS: Final = 3

TEXTS: Final = ("cases_of", "method", "against")
NUMBERS: Final = (
    "step_fraction", "penetration_ratio", "default", "seconds_per_case", "block_steps_per_case", "cases", "wrong_flags",
    "fallen", "wrong_sides", "unanswered", "rotation_error", "boundary_shift", "slip_error", "energy_error",
)  # fmt: skip

MEANINGS: Final = {
    "cases_of": ("set of cases", ""),
    "method": ("scheme of the kernel, or engine", ""),
    "against": ("what the error is against", ""),
    "step_fraction": ("time step over the stable one; of an engine: time step in s", "1"),
    "penetration_ratio": ("static penetration over width", "1"),
    "default": ("1 at the default setting", "1"),
    "seconds_per_case": ("processor time per case, least of the runs", "s"),
    "block_steps_per_case": ("block steps per case", "1"),
    "cases": ("cases with an answer in both", "1"),
    "wrong_flags": ("cases that fall instead of standing, or the reverse", "1"),
    "fallen": ("cases that fall in both", "1"),
    "wrong_sides": ("cases that fall to the wrong side", "1"),
    "unanswered": ("cases without an answer", "1"),
    "rotation_error": ("median error of peak rotation over the critical angle where the block stands", "1"),
    "boundary_shift": ("median shift of the overturning boundary over B/H", "1"),
    "energy_error": ("mean residual of work and energy", "1"),
    "slip_error": ("largest error of peak slip over peak slip", "1"),
}


def settings(scheme: str, fraction: float, penetration: float = STATIC_PENETRATION) -> dict[str, Any]:
    """Arguments of `run_cases`."""
    return {
        "scheme": scheme,
        "time_step": f"{fraction:g} stable",
        "contact": Contact(static_penetration=penetration),
    }


def setting_columns(scheme: str, fraction: float, penetration: float = STATIC_PENETRATION) -> dict[str, float]:
    """The same settings as columns of the table, and whether they are those that a study has by default."""
    automatic = AUTO_FRACTION[scheme_of(DEFAULT_SCHEME)]
    default = scheme == DEFAULT_SCHEME and fraction == automatic and penetration == STATIC_PENETRATION
    return {"step_fraction": fraction, "penetration_ratio": penetration, "default": default}


def measured(
    groups: Sequence[Group], arguments: dict[str, Any]
) -> tuple[NDArray[np.int8], FloatArray, dict[str, float]]:
    """Flags, peak rotations, and what a case cost: the least processor time of `REPEATS` runs, one thread.

    Before them the first group is run once, to compile and to warm up.
    """
    run_cases(groups[0].motion, groups[0].cases, **arguments)
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        found = [run_cases(group.motion, group.cases, **arguments) for group in groups]
        times.append(time.process_time() - begin)
    flags = np.concatenate([one.overturned for one in found])
    peaks = np.concatenate([one.peak_rotation for one in found]).astype(np.float64)
    steps = sum(int(one.block_steps.sum()) for one in found)
    return flags, peaks, {"seconds_per_case": min(times) / flags.size, "block_steps_per_case": steps / flags.size}


def row(cases_of: str, method: str, against: str, **numbers: float) -> dict[str, Any]:
    """A row of the table; what was not measured is NaN."""
    return {"cases_of": cases_of, "method": method, "against": against} | {
        name: float(numbers.get(name, float("nan"))) for name in NUMBERS
    }


def errors(flags: NDArray[np.int8], peaks: FloatArray, right: tuple[NDArray[np.int8], FloatArray]) -> dict[str, float]:
    """Counts and median error of peak rotation, as columns of the table."""
    found = counts(flags, right[0])
    return {
        "cases": found.cases,
        "wrong_flags": found.flags,
        "fallen": found.fallen,
        "wrong_sides": found.sides,
        "unanswered": found.unanswered,
        "rotation_error": rotation_error(flags, peaks, *right),
    }


def thinned(groups: Sequence[Group], every: int) -> list[Group]:
    """Every so many cases of each group."""
    return [group.taken(np.arange(0, group.cases.size, every)) for group in groups]


def thinned_values(groups: Sequence[Group], values: NDArray[Any], every: int) -> NDArray[Any]:
    """The values, of all groups' cases in a row, that belong to `thinned` groups."""
    ends = np.cumsum([group.cases.size for group in groups])[:-1]
    return np.concatenate([part[::every] for part in np.split(values, ends)])


def columns_of(rows: Sequence[dict[str, Any]]) -> dict[str, NDArray[Any]]:
    """Rows as columns."""
    return {name: np.array([one[name] for one in rows]) for name in (*TEXTS, *NUMBERS)}
