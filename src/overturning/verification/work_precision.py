"""Error against run time: schemes over time steps and stiffness, against a far finer step and against rigid solutions."""

import time
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.cases import run_cases
from overturning.dem.contact import STATIC_PENETRATION, Contact
from overturning.dem.time_step import AUTO_FRACTION, DEFAULT_SCHEME, scheme_of
from overturning.verification.measures import (
    BRACKET,
    HALVINGS,
    Runner,
    answers,
    bisect,
    boundaries,
    boundary_shift,
    counts,
    kernel,
    rotation_error,
)
from overturning.verification.work_precision_cases import Group, pulse_groups, record_groups, slide_groups

FloatArray = NDArray[np.float64]
Say = Callable[[str], None]

FRACTIONS: Final = (0.9, 0.5, 0.25, 0.12, 0.06, 0.03, 0.01)
"""Δt/Δt_stable."""

FINEST: Final = 0.006
"""Δt/Δt_stable of the reference, with the centred scheme."""

THIN_BELOW: Final = 0.05
"""At finer steps every sixth case is run, so that the diagrams are made in minutes."""

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


def is_default(scheme: str, fraction: float, penetration: float) -> bool:
    """Whether these are the settings that a study has by default."""
    automatic = AUTO_FRACTION[scheme_of(DEFAULT_SCHEME)]
    return scheme == DEFAULT_SCHEME and fraction == automatic and penetration == STATIC_PENETRATION


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


def thinned(groups: Sequence[Group]) -> list[Group]:
    """Every sixth case."""
    return [group.taken(np.arange(0, group.cases.size, 6)) for group in groups]


def against_finer_steps(kind: str, say: Say, azimuths: int = 2, most: int = 2) -> list[dict[str, Any]]:
    """Schemes over time steps, against the centred scheme at a far finer step, on six real records.

    Parameters
    ----------
    kind : str
        "sliding" or "rocking".
    say : callable
        Takes progress lines.
    azimuths, most : int
        Azimuths, and overturning boundaries of each record.
    """
    groups = record_groups(kind, azimuths)
    finest = kernel(**settings("centred", FINEST))
    right = answers(groups, finest)
    few, right_few = thinned(groups), (_every_sixth(groups, right[0]), _every_sixth(groups, right[1]))
    where = boundaries(groups, right[0], most)
    low, high = np.array([place[1]["b_over_h"] for place in where]), np.array([place[2] for place in where])
    # The way there with the usual step, the last of it with the fine one.
    near = bisect(groups, where, kernel(), low, high, 2 * HALVINGS)
    exact = bisect(groups, where, finest, near * (1 - BRACKET), near * (1 + BRACKET))
    say(f"{kind}: reference of {right[0].size} cases and {len(where)} boundaries is done")
    rows = []
    for scheme in SCHEMES:
        for fraction in FRACTIONS:
            thin = fraction < THIN_BELOW
            chosen, truth = (few, right_few) if thin else (groups, right)
            arguments = settings(scheme, fraction)
            run = kernel(**arguments)
            flags, peaks, spent = measured(chosen, arguments)
            numbers = errors(flags, peaks, truth)
            if not thin:
                numbers["boundary_shift"] = boundary_shift(groups, where, run, near, exact)
            rows.append(
                row(
                    f"records, {kind}", scheme, "finer step", step_fraction=fraction, penetration_ratio=STATIC_PENETRATION,
                    default=is_default(scheme, fraction, STATIC_PENETRATION), **spent, **numbers,
                )
            )  # fmt: skip
            say(f"{kind}: {scheme} at {fraction:g} of the stable step is done")
    return rows


def _every_sixth(groups: Sequence[Group], values: NDArray[Any]) -> NDArray[Any]:
    ends = np.cumsum([group.cases.size for group in groups])[:-1]
    return np.concatenate([part[::6] for part in np.split(values, ends)])


def rocking(group: Group) -> tuple[NDArray[np.int8], FloatArray]:
    """Housner's rocking block on each case of a group."""
    from overturning.reference.rocking import rocking_outcome

    cases = group.cases
    found = []
    for index in range(cases.size):
        factor, azimuth = (float(np.asarray(values)[index]) for values in (cases.amplitude, cases.azimuth_deg))
        height, ratio = (float(np.asarray(values)[index]) for values in (cases.height, cases.b_over_h))
        found.append(
            rocking_outcome(factor * group.motion.along(azimuth), group.motion.sampling_interval, height, ratio)
        )
    return np.array([side for side, _ in found], np.int8), np.array([peak for _, peak in found])


def robust_pulses(groups: Sequence[Group]) -> tuple[list[Group], tuple[NDArray[np.int8], FloatArray]]:
    """The pulse cases whose rigid answer does not change with the amplitude by ±1 %, and these answers."""
    kept, flags, peaks = [], [], []
    for group in groups:
        nominal = rocking(group)
        same = np.ones(group.cases.size, bool)
        for factor in (0.99, 1.01):
            changed = Group(group.motion.__class__(
                factor * group.motion.north, group.motion.east, sampling_interval=group.motion.sampling_interval
            ), group.cases)  # fmt: skip
            same &= rocking(changed)[0] == nominal[0]
        chosen = np.flatnonzero(same)
        kept.append(group.taken(chosen))
        flags.append(nominal[0][chosen])
        peaks.append(nominal[1][chosen])
    return kept, (np.concatenate(flags), np.concatenate(peaks))


def against_rigid_rocking(say: Say, periods: int = 12, blocks: int = 24) -> list[dict[str, Any]]:
    """Schemes over time steps and stiffness against Housner's rocking block under sine pulses."""
    groups, right = robust_pulses(pulse_groups(periods, blocks))
    chosen = [(scheme, fraction, STATIC_PENETRATION) for scheme in SCHEMES for fraction in FRACTIONS[:-1]]
    automatic = AUTO_FRACTION[scheme_of(DEFAULT_SCHEME)]
    chosen += [(DEFAULT_SCHEME, automatic, delta) for delta in PENETRATIONS if delta != STATIC_PENETRATION]
    rows = []
    for scheme, fraction, penetration in chosen:
        arguments = settings(scheme, fraction, penetration)
        flags, peaks, spent = measured(groups, arguments)
        numbers = errors(flags, peaks, right)
        rows.append(
            row(
                "sine pulses", scheme, "rigid rocking", step_fraction=fraction, penetration_ratio=penetration,
                default=is_default(scheme, fraction, penetration), **spent, **numbers,
            )
        )  # fmt: skip
    say(f"pulses: {len(right[0])} cases, {len(rows)} settings are done")
    return rows


def against_exact_sliding(say: Say) -> list[dict[str, Any]]:
    """Peak slip of squat blocks against the exact sliding block, over time steps."""
    from overturning.reference.sliding import slide

    groups = slide_groups()
    exact = np.array([
        slide(group.motion.along(20.0), group.motion.sampling_interval, float(friction))[0]
        for group in groups
        for friction in np.asarray(group.cases.friction)
    ])  # fmt: skip
    rows = []
    for scheme in SCHEMES:
        for fraction in FRACTIONS[:-1]:
            arguments = settings(scheme, fraction)
            slips = np.concatenate([run_cases(g.motion, g.cases, **arguments).peak_slip for g in groups])
            _, _, spent = measured(groups, arguments)
            moved = exact > 1e-3
            rows.append(
                row(
                    "sliding blocks", scheme, "exact sliding", step_fraction=fraction,
                    penetration_ratio=STATIC_PENETRATION, default=is_default(scheme, fraction, STATIC_PENETRATION),
                    **spent, cases=int(moved.sum()),
                    slip_error=float(np.max(np.abs(slips[moved] / exact[moved] - 1.0))),
                )
            )  # fmt: skip
    say(f"sliding: {exact.size} cases are done")
    return rows


def energy_balance(say: Say) -> list[dict[str, Any]]:
    """Mean residual of work and energy of cases that slide or rock, over time steps."""
    groups = [part for kind in ("sliding", "rocking") for part in thinned(record_groups(kind, 2))]
    rows = []
    for scheme in SCHEMES:
        for fraction in FRACTIONS[:-1]:
            found = [run_cases(g.motion, g.cases, **settings(scheme, fraction)) for g in groups]
            residual = np.concatenate([one.energy_error for one in found])
            simulated = np.concatenate([one.status for one in found]) == 0
            rows.append(
                row(
                    "records, all", scheme, "energy balance", step_fraction=fraction, cases=int(simulated.sum()),
                    penetration_ratio=STATIC_PENETRATION, default=is_default(scheme, fraction, STATIC_PENETRATION),
                    energy_error=float(np.mean(residual[simulated])),
                )
            )  # fmt: skip
    say(f"energy: {len(rows)} settings are done")
    return rows


def peer_rows(
    engines: dict[str, Callable[..., int]], steps: Sequence[float], set_step: Callable[[float], None], say: Say
) -> list[dict[str, Any]]:
    """Rigid-body engines on the pulse cases.

    Parameters
    ----------
    engines : dict of str to callable
        Side to which a block falls, from acceleration, sampling interval, height, B/H and friction.
    steps : sequence of float
        Their time steps, s.
    set_step : callable
        Makes the engines use a step.
    say : callable
        Takes progress lines.
    """
    groups, right = robust_pulses(pulse_groups())
    groups, flags = thinned(groups), _every_sixth(groups, right[0])
    rows = []
    for name, engine in engines.items():
        for step in steps:
            set_step(step)
            times = []
            for _ in range(REPEATS + 1):
                begin = time.process_time()
                sides = np.array(
                    [_one(engine, group, index) for group in groups for index in range(group.cases.size)], np.int8
                )
                times.append(time.process_time() - begin)
            found = counts(sides, flags)
            rows.append(
                row(
                    "sine pulses", name, "rigid rocking", step_fraction=step, default=0,
                    seconds_per_case=min(times[1:]) / sides.size, cases=found.cases, wrong_flags=found.flags,
                    fallen=found.fallen, wrong_sides=found.sides, unanswered=found.unanswered,
                )
            )  # fmt: skip
            say(f"{name} at {step:g} s is done")
    return rows


def _one(engine: Callable[..., int], group: Group, index: int) -> int:
    cases = group.cases
    factor, height, ratio, friction = (
        float(np.asarray(values)[index]) for values in (cases.amplitude, cases.height, cases.b_over_h, cases.friction)
    )
    return engine(factor * group.motion.north, group.motion.sampling_interval, height, ratio, friction)


def columns_of(rows: Sequence[dict[str, Any]]) -> dict[str, NDArray[Any]]:
    """Rows as columns."""
    return {name: np.array([one[name] for one in rows]) for name in (*TEXTS, *NUMBERS)}


PARTS: Final[dict[str, Callable[[Say], list[dict[str, Any]]]]] = {
    "sliding": lambda say: against_finer_steps("sliding", say),
    "rocking": lambda say: against_finer_steps("rocking", say),
    "rigid": lambda say: against_rigid_rocking(say) + against_exact_sliding(say),
    "energy": energy_balance,
}
"""What can be computed beside one another, by name."""

__all__ = ["MEANINGS", "PARTS", "Runner", "columns_of", "peer_rows", "row"]
