"""Error and run time against rigid solutions: Housner's rocking block, the exact sliding block; other engines."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.dem.run import run_cases
from overturning.dem.time_step import AUTO_FRACTION, DEFAULT_SCHEME, scheme_of
from overturning.model.contact import STATIC_PENETRATION
from verification.engines import Engine, installed, side_of_block
from verification.measures import Flags
from verification.timing import measured
from verification.work_precision.cases import (
    Group,
    pulse_groups,
    rigid_record_groups,
    slide_groups,
    thinned,
    thinned_values,
)
from verification.work_precision.table import (
    PENETRATIONS,
    SCHEMES,
    Say,
    counted,
    errors,
    fractions_of,
    run,
    setting_columns,
    settings,
)

ENGINES_EVERY: Final = {"sine pulses": 10, "records, no sliding": 5}
"""The engines run every so many of the cases: each takes a hundred times a case of the kernel."""

ENGINE_STEPS: Final = (1 / 120, 1 / 240, 1 / 480, 1 / 960)
"""Time steps of the engines, s."""


def rocking(group: Group) -> tuple[Flags, FloatArray]:
    """Housner's rocking block on each case of a group."""
    from verification.reference.rocking import rocking_outcome

    found = []
    for index in range(group.cases.size):
        case = group.case(index)
        wave = _wave(group, index)
        found.append(rocking_outcome(wave, group.motion.sampling_interval, case["height"], case["b_over_h"]))
    return np.array([side for side, _ in found], np.int8), np.array([peak for _, peak in found])


def robust(groups: Sequence[Group]) -> tuple[list[Group], tuple[Flags, FloatArray]]:
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
    chosen = [
        (scheme, fraction, STATIC_PENETRATION)
        for scheme in SCHEMES
        for fraction in fractions_of(scheme)
        if fraction > 0.05
    ]
    chosen += [(DEFAULT_SCHEME, automatic, delta) for delta in PENETRATIONS if delta != STATIC_PENETRATION]
    rows = []
    for name, every in rigid_sets().items():
        groups, right = robust(every)
        for scheme, fraction, penetration in chosen:
            flags, peaks, spent = run(groups, settings(scheme, fraction, penetration))
            numbers = errors(flags, peaks, right)
            of: dict[str, Any] = {"cases_of": name, "method": scheme, "against": "rigid rocking"}
            rows.append(of | setting_columns(scheme, fraction, penetration) | spent | numbers)
        say(f"{name}: {len(right[0])} robust cases, {len(chosen)} settings are done")
    return rows


def against_exact_sliding(say: Say) -> list[dict[str, Any]]:
    """Peak slip of squat blocks against the exact sliding block, over time steps."""
    from verification.reference.sliding import slide

    groups = slide_groups()
    exact = np.array([
        slide(group.motion.along(20.0), group.motion.sampling_interval, float(friction))[0]
        for group in groups
        for friction in np.asarray(group.cases.friction)
    ])  # fmt: skip
    rows = []
    for scheme in SCHEMES:
        for fraction in fractions_of(scheme)[:-1]:
            arguments = settings(scheme, fraction)
            slips = np.concatenate([run_cases(g.motion, g.cases, **arguments).peak_slip for g in groups])
            _, _, spent = run(groups, arguments)
            moved = exact > 1e-3
            of: dict[str, Any] = {"cases_of": "sliding blocks", "method": scheme, "against": "exact sliding"}
            error = float(np.max(np.abs(slips[moved] / exact[moved] - 1.0)))
            rows.append(
                of | setting_columns(scheme, fraction) | spent | {"cases": int(moved.sum()), "slip_error": error}
            )
    say(f"sliding: {exact.size} cases are done")
    return rows


def engines_against_rigid_rocking(say: Say) -> list[dict[str, Any]]:
    """Rigid-body engines that are installed, over their time steps, on the cases that cannot slide."""
    engines = installed(("Box2D", "pymunk", "MuJoCo"))
    if not engines:  # a table without engines has one row that says so
        return [{"cases_of": "sine pulses", "method": "no engine installed", "against": "rigid rocking", "default": 0}]
    rows = []
    for cases_of, every in rigid_sets().items():
        kept, right = robust(every)
        thin = ENGINES_EVERY[cases_of]
        few, flags = thinned(kept, thin), thinned_values(kept, right[0], thin)
        for (name, engine), step in itertools.product(engines.items(), ENGINE_STEPS):
            sides, seconds = measured(
                partial(_sides, engine, few, step), warm_up=partial(_side, engine, few[0], 0, step)
            )
            of: dict[str, Any] = {
                "cases_of": cases_of,
                "method": name,
                "against": "rigid rocking",
                "step_fraction": step,
                "default": 0,
            }
            rows.append(of | {"seconds_per_case": seconds / sides.size} | counted(sides, flags))
            say(f"{cases_of}: {name} at {step:g} s is done")
    return rows


def _sides(engine: Engine, groups: Sequence[Group], step: float) -> Flags:
    return np.array(
        [_side(engine, group, index, step) for group in groups for index in range(group.cases.size)], np.int8
    )


def _side(engine: Engine, group: Group, index: int, step: float) -> int:
    wave, case = _wave(group, index), group.case(index)
    interval = group.motion.sampling_interval
    return side_of_block(engine, wave, interval, case["height"], case["b_over_h"], case["friction"], step)


def _wave(group: Group, index: int) -> FloatArray:
    """Acceleration of a case."""
    case = group.case(index)
    return case["amplitude"] * group.motion.along(case["azimuth_deg"])
