"""Error against run time, against rigid solutions: Housner's rocking block, the exact sliding block; other engines beside."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.contact import STATIC_PENETRATION
from overturning.dem.run import run_cases
from overturning.dem.time_step import AUTO_FRACTION, DEFAULT_SCHEME, scheme_of
from overturning.verification.measures import counts
from overturning.verification.work_precision import (
    FRACTIONS,
    PENETRATIONS,
    REPEATS,
    SCHEMES,
    FloatArray,
    Say,
    errors,
    measured,
    row,
    setting_columns,
    settings,
    thinned,
    thinned_values,
)
from overturning.verification.work_precision_cases import Group, pulse_groups, rigid_record_groups, slide_groups

ENGINES_EVERY: Final = {"sine pulses": 10, "records, no sliding": 5}
"""The engines run every so many of the cases: each takes a hundred times a case of the kernel."""


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


def robust(groups: Sequence[Group]) -> tuple[list[Group], tuple[NDArray[np.int8], FloatArray]]:
    """The cases whose rigid answer does not change with the amplitude by ±1 %, and these answers."""
    kept, flags, peaks = [], [], []
    for group in groups:
        nominal = rocking(group)
        same = np.ones(group.cases.size, bool)
        for factor in (0.99, 1.01):
            stronger = replace(group.cases, amplitude=factor * np.asarray(group.cases.amplitude))
            same &= rocking(Group(group.motion, stronger))[0] == nominal[0]
        chosen = np.flatnonzero(same)
        kept.append(group.taken(chosen))
        flags.append(nominal[0][chosen])
        peaks.append(nominal[1][chosen])
    return kept, (np.concatenate(flags), np.concatenate(peaks))


def rigid_sets() -> dict[str, list[Group]]:
    """Blocks that cannot slide, by name of the set."""
    return {"sine pulses": pulse_groups(), "records, no sliding": rigid_record_groups()}


def against_rigid_rocking(say: Say) -> list[dict[str, Any]]:
    """Schemes over time steps, and the default one over stiffness, against Housner's rocking block."""
    automatic = AUTO_FRACTION[scheme_of(DEFAULT_SCHEME)]
    chosen = [(scheme, fraction, STATIC_PENETRATION) for scheme in SCHEMES for fraction in FRACTIONS if fraction > 0.05]
    chosen += [(DEFAULT_SCHEME, automatic, delta) for delta in PENETRATIONS if delta != STATIC_PENETRATION]
    rows = []
    for name, every in rigid_sets().items():
        groups, right = robust(every)
        for scheme, fraction, penetration in chosen:
            flags, peaks, spent = measured(groups, settings(scheme, fraction, penetration))
            numbers = errors(flags, peaks, right)
            rows.append(
                row(
                    name, scheme, "rigid rocking", **setting_columns(scheme, fraction, penetration), **spent, **numbers,
                )
            )  # fmt: skip
        say(f"{name}: {len(right[0])} robust cases, {len(chosen)} settings are done")
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
                    "sliding blocks", scheme, "exact sliding", **setting_columns(scheme, fraction), **spent,
                    cases=int(moved.sum()),
                    slip_error=float(np.max(np.abs(slips[moved] / exact[moved] - 1.0))),
                )
            )  # fmt: skip
    say(f"sliding: {exact.size} cases are done")
    return rows


def peer_rows(
    engines: dict[str, Callable[..., int]], steps: Sequence[float], set_step: Callable[[float], None], say: Say
) -> list[dict[str, Any]]:
    """Rigid-body engines on the cases that cannot slide.

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
    rows = []
    for cases_of, every in rigid_sets().items():
        kept, right = robust(every)
        thin = ENGINES_EVERY[cases_of]
        groups, flags = thinned(kept, thin), thinned_values(kept, right[0], thin)
        for name, engine in engines.items():
            for step in steps:
                set_step(step)
                sides, seconds = _engine_run(engine, groups)
                found = counts(sides, flags)
                rows.append(
                    row(
                        cases_of, name, "rigid rocking", step_fraction=step, default=0,
                        seconds_per_case=seconds / sides.size, cases=found.cases, wrong_flags=found.flags,
                        fallen=found.fallen, wrong_sides=found.sides, unanswered=found.unanswered,
                    )
                )  # fmt: skip
                say(f"{cases_of}: {name} at {step:g} s is done")
    return rows


def _engine_run(engine: Callable[..., int], groups: Sequence[Group]) -> tuple[NDArray[np.int8], float]:
    """Sides of all cases, and the least processor time of `REPEATS` runs after a first case that warms up, s."""
    _one(engine, groups[0], 0)
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        sides = [_one(engine, group, index) for group in groups for index in range(group.cases.size)]
        times.append(time.process_time() - begin)
    return np.array(sides, np.int8), min(times)


def _one(engine: Callable[..., int], group: Group, index: int) -> int:
    cases = group.cases
    names = ("azimuth_deg", "amplitude", "height", "b_over_h", "friction")
    azimuth, factor, height, ratio, friction = (float(np.asarray(getattr(cases, name))[index]) for name in names)
    return engine(factor * group.motion.along(azimuth), group.motion.sampling_interval, height, ratio, friction)
