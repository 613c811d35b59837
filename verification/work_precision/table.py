"""Error against run time: settings, measuring, and rows of the table, for all parts alike."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from overturning.arrays import FloatArray
from overturning.dem.run import run_cases
from overturning.dem.time_step import AUTO_FRACTION, DEFAULT_SCHEME, scheme_of
from overturning.model.contact import STATIC_PENETRATION, Contact
from overturning.study.convergence import compare
from verification.measures import Flags, rotation_error
from verification.tables import read_table
from verification.timing import measured
from verification.work_precision.cases import Group

Say = Callable[[str], None]

FRACTIONS: Final = (1.0, 0.9, 0.5, 0.25, 0.12, 0.06, 0.03, 0.01)
"""Δt/Δt_stable."""

PENETRATIONS: Final = (2e-3, 2e-4, 2e-5, 2e-6, STATIC_PENETRATION, 2e-8)
"""δ/B."""

SCHEMES: Final = ("centred", "cundall")
LEAST_EXPLICIT: Final = 0.1
"""Cundall's scheme is not run in finer steps: the springs set its longest, a fiftieth of the other's by default."""

PARTS: Final = ("rocking", "sliding", "stiffness", "rigid", "energy", "peers")
"""Parts that can be computed beside one another, each a table."""


def fractions_of(scheme: str) -> tuple[float, ...]:
    """Shares of its longest step at which a scheme is run."""
    return FRACTIONS if scheme != "cundall" else tuple(share for share in FRACTIONS if share >= LEAST_EXPLICIT)


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


def run(groups: Sequence[Group], arguments: dict[str, Any]) -> tuple[Flags, FloatArray, dict[str, float]]:
    """Flags, peak rotations, and what a case cost in one thread; before that the first group warms up."""
    found, seconds = measured(
        lambda: [run_cases(group.motion, group.cases, **arguments) for group in groups],
        warm_up=lambda: run_cases(groups[0].motion, groups[0].cases, **arguments),
    )
    flags = np.concatenate([one.overturned for one in found])
    peaks = np.concatenate([one.peak_rotation for one in found]).astype(np.float64)
    steps = sum(int(one.block_steps.sum()) for one in found)
    return flags, peaks, {"seconds_per_case": seconds / flags.size, "block_steps_per_case": steps / flags.size}


def errors(flags: Flags, peaks: FloatArray, right: tuple[Flags, FloatArray]) -> dict[str, float]:
    """Counts and median error of peak rotation, as columns of the table."""
    return counted(flags, right[0]) | {"rotation_error": rotation_error(flags, peaks, *right)}


def counted(flags: Flags, right: Flags) -> dict[str, float]:
    """Counts as columns of the table."""
    found = compare(right, flags).model_dump()
    return {"wrong_flags": found.pop("flags"), "wrong_sides": found.pop("sides"), **found}


def table_of(rows: Sequence[dict[str, Any]]) -> pd.DataFrame:
    """The table of rows; what was not measured is NaN."""
    table = pd.DataFrame(rows, columns=list(MEANINGS))
    return table.astype({name: np.float64 for name, (_, unit) in MEANINGS.items() if unit})


def read_parts(folder: Path) -> pd.DataFrame:
    """The tables of all parts as one."""
    return pd.concat([read_table(folder / f"{part}.nc") for part in PARTS], ignore_index=True)
