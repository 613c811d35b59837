"""The stability map: every case ends with a checked answer, with a mark, or with a refusal, and none is silent."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from enum import IntEnum
from typing import Any, Final, TypeVar

import numpy as np
import pandas as pd

from overturning.arrays import FloatArray
from overturning.dem.kernel.balance import ENERGY_BOUND
from overturning.dem.plan import DEEPEST
from overturning.dem.run import run_cases
from overturning.dem.time_step import highest_eigenvalue, rocking_time, scheme_of, stable_step, steps_per_sample
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.results import Results
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.stability.cases import PAPER_DAMPING, StabilityCase, motion_of_case

Item = TypeVar("Item")
Found = TypeVar("Found")

BUDGET: Final = 1_000_000
"""Block steps of a case of the map; fewer than a study's case may take, so that the map is made in minutes."""

SMALL_SLIDE: Final = 1e-9
"""Slip that a block at rest may show, per metre of its size: rounding."""


class Ending(IntEnum):
    """How a case of the map ends."""

    RIGHT = 0
    """Computed, and every check holds."""
    AT_REST = 1
    """Left out, and below both thresholds for the whole motion by an independent look at the motion."""
    UNDECIDED = 2
    UNSTABLE = 3
    FAILED = 4
    OVER_BUDGET = 5
    REFUSED = 6
    """An error that names the argument."""
    SILENT = 7
    """A flag that a check contradicts. There must be none."""


GROUPS: Final = ("penetration_ratio", "damping", "step_ratio", "acceleration_ratio", "friction_ratio")


def contact_of_case(case: StabilityCase) -> Contact:
    """The contact of a case of the map."""
    if np.isnan(case.damping_ratio):
        return Contact(stiffness=case.stiffness, damping=PAPER_DAMPING)
    return Contact(stiffness=case.stiffness, damping_ratio=case.damping_ratio)


def run_case(case: StabilityCase, number: int, budget: int = BUDGET) -> dict[str, Any]:
    """Run one case and check its answer: a row of the map, named as in `MEANINGS`.

    Parameters
    ----------
    case : StabilityCase
        The case.
    number : int
        Its place on the map; seeds the noise.
    budget : int
        Block steps.
    """
    motion, contact = motion_of_case(case, number), contact_of_case(case)
    row: dict[str, Any] = {"ending": Ending.REFUSED, "reason": "", "overturned": INT8_MISSING, "block_steps": 0}
    row |= dict.fromkeys(("energy_error", "penetration", "rotation", "slip"), float("nan"))
    row |= _groups(case, contact, motion)
    cases = Cases(0.0, case.height, case.b_over_h, case.friction)
    given: dict[str, Any] = {"scheme": case.scheme, "time_step": case.time_step, "budget": budget}
    try:
        found = run_cases(motion, cases, density=case.density, contact=contact, **given)
    except ArgumentError as error:
        return row | {"reason": str(error).partition(":")[0]}
    reason = contradiction(case, motion, found)
    return row | {
        "ending": Ending.SILENT if reason else Ending(int(found.status[0])),
        "reason": reason,
        "overturned": int(found.overturned[0]),
        "energy_error": float(found.energy_error[0]),
        "penetration": float(found.peak_penetration[0]) / (case.b_over_h * case.height),
        "rotation": float(found.peak_rotation[0]),
        "slip": float(found.peak_slip[0]),
        "block_steps": int(found.block_steps[0]),
    }


def contradiction(case: StabilityCase, motion: Motion, found: Results) -> str:
    """The first check that an answer does not hold; empty where all hold.

    A marked case must have no flag. A flag must come with energy balance, bounded penetration, finite numbers, and
    agree with what a rigid block under this motion can do: below both thresholds it neither falls nor slides.
    """
    status, flag = int(found.status[0]), int(found.overturned[0])
    width, alpha = case.b_over_h * case.height, np.arctan(case.b_over_h)
    sunk = static_penetration(case)
    reason = unsound(found, 0, sunk, DEEPEST * 0.5 * min(width, case.height))
    if reason or status not in (Status.SIMULATED, Status.AT_REST):
        return reason
    if (flag != 0) != (found.peak_rotation[0] * alpha >= 0.5 * np.pi * (1 - 1e-6)):
        return "flag and rotation"
    if (flag != 0) != bool(np.isfinite(found.overturning_time[0])):
        return "flag and time"
    demand, resting = demand_of(motion), min(case.b_over_h, case.friction)
    if status == Status.AT_REST and demand > resting:
        return "left out above a threshold"
    if demand == 0.0 and (flag != 0 or found.peak_slip[0] > SMALL_SLIDE * (width + case.height)):
        return "moved without motion"
    if flag != 0 and demand < 0.2 * case.b_over_h and case.friction < 0.5 * case.b_over_h and sunk < 1e-4 * width:
        return "fell below the threshold of rocking"
    return ""


def unsound(found: Results, row: int, sunk: float, limit: float) -> str:
    """What is wrong with an answer by its own numbers, whatever the motion; empty where nothing is.

    Parameters
    ----------
    found : Results or Results
        Answers.
    row : int
        Which of them.
    sunk, limit : float
        Largest static penetration, and the one beyond which the contact law means nothing, m.
    """
    flags = found.overturned[row]
    if found.status[row] not in (Status.SIMULATED, Status.AT_REST):
        return "" if np.all(flags == INT8_MISSING) else "flag in spite of the mark"
    if not np.isin(flags, (-1, 0, 1)).all():
        return "no flag and no mark"
    numbers = (found.energy_error, found.peak_penetration, found.peak_rotation, found.peak_slip, found.residual_slip)
    if not all(np.isfinite(values[row]).all() for values in numbers):
        return "a number is not finite"
    if sunk > limit or found.peak_penetration[row] > limit * (1 + 1e-6):
        return "penetration"
    return "" if found.energy_error[row] <= ENERGY_BOUND else "energy balance"


def static_penetration(case: StabilityCase) -> float:
    """Static penetration δ = m g/(2 K_n), m."""
    return case.density * case.b_over_h * case.height**2 * STANDARD_GRAVITY / (2.0 * case.stiffness)


def demand_of(motion: Motion) -> float:
    """Largest abs(a)/(g + a_up) of the motion, towards north; infinite where the ground falls faster than the block."""
    weight = STANDARD_GRAVITY + (np.zeros(motion.samples) if motion.up is None else motion.up)
    if (weight <= 0).any():
        return float("inf")
    return float(np.max(np.abs(motion.north) / weight))


def step_ratio(
    case: StabilityCase, square: FloatArray, rate: FloatArray, interval: float, period: FloatArray | None = None
) -> float:
    """Δt/Δt_stable of a case, from the highest eigenvalues of springs and dashpots; what was asked for if refused."""
    scheme = scheme_of(case.scheme)
    try:
        per_sample = float(steps_per_sample(scheme, case.time_step, square, rate, interval, period)[0])
    except ArgumentError:
        return case.step_fraction
    return interval / per_sample / float(stable_step(scheme, square, rate, period)[0])


def _groups(case: StabilityCase, contact: Contact, motion: Motion) -> dict[str, float]:
    width = np.array([case.b_over_h * case.height])
    height = np.array([case.height])
    normal, tangential, dashpot = contact.specific(width, height, case.density)
    square = highest_eigenvalue(normal, tangential, 0.5 * width, 0.5 * height)
    rate = highest_eigenvalue(dashpot, dashpot, 0.5 * width, 0.5 * height)
    period = rocking_time(width, height)
    ratio = step_ratio(case, square, rate, motion.sampling_interval, period)
    return {
        "penetration_ratio": static_penetration(case) / float(width[0]),
        "damping": float(dashpot[0]) / (2.0 * np.sqrt(0.5 * float(normal[0]))),
        "step_ratio": ratio,
        "acceleration_ratio": case.peak / (STANDARD_GRAVITY * case.b_over_h),
        "friction_ratio": case.friction / case.b_over_h,
    }


def run_map(
    cases: Sequence[StabilityCase],
    *,
    budget: int = BUDGET,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> list[dict[str, Any]]:
    """Run all cases; the outcome does not depend on the threads."""
    return numbered(lambda number, case: run_case(case, number, budget), cases, threads, progress, 1000)


def numbered(
    run: Callable[[int, Item], Found],
    items: Sequence[Item],
    threads: int,
    progress: Callable[[int, int], None] | None,
    every: int,
) -> list[Found]:
    """What `run` makes of each item and its number, in their order; after every so many it says how many are done."""
    found: list[Found] = []
    with ThreadPoolExecutor(max_workers=threads) as pool:
        for one in pool.map(run, range(len(items)), items):
            found.append(one)
            if progress and len(found) % every == 0:
                progress(len(found), len(items))
    return found


def table_of(cases: Sequence[StabilityCase], outcomes: Sequence[dict[str, Any]]) -> pd.DataFrame:
    """The map as a table: what was asked, and what came of it."""
    rows = pd.DataFrame([vars(case) | outcome for case, outcome in zip(cases, outcomes, strict=True)])
    return rows.astype({"ending": np.int8, "overturned": np.int8})


MEANINGS: Final = {
    "stiffness": ("normal stiffness of a corner, per metre of depth", "N m-1"),
    "damping_ratio": ("damping ratio of heave asked for; NaN: the paper's dashpot", "1"),
    "b_over_h": ("slenderness", "1"),
    "height": ("height of the block", "m"),
    "density": ("density", "kg m-3"),
    "friction": ("friction coefficient", "1"),
    "peak": ("largest horizontal acceleration", "m s-2"),
    "sampling_interval": ("sampling interval of the motion", "s"),
    "step_fraction": ("time step over the stable one, asked for; NaN: automatic", "1"),
    "scheme": ("integration scheme", ""),
    "motion": ("kind of motion", ""),
    "period": ("period of pulse and square wave, in samples", "1"),
    "vertical": ("largest upward over largest horizontal acceleration", "1"),
    "ending": ("how the case ended: " + ", ".join(f"{e.value} {e.name.lower()}" for e in Ending), "1"),
    "reason": ("argument that a refusal names, or check that does not hold", ""),
    "overturned": ("side to which the block falls; -128: no answer", "1"),
    "energy_error": ("residual of work and energy", "1"),
    "penetration": ("largest penetration over the width", "1"),
    "rotation": ("largest rotation over the critical angle", "1"),
    "slip": ("largest slip of the base's midpoint", "m"),
    "block_steps": ("block steps computed", "1"),
    "penetration_ratio": ("static penetration over width", "1"),
    "damping": ("damping ratio of heave", "1"),
    "step_ratio": ("time step over the stable one", "1"),
    "acceleration_ratio": ("largest acceleration over g B/H", "1"),
    "friction_ratio": ("friction coefficient over B/H", "1"),
}
"""Long name and unit of the map's columns."""
