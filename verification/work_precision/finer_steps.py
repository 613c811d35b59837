"""Error against run time on six records: schemes over time steps, springs over stiffness, the energy balance."""

from typing import Any, Final

import numpy as np

from overturning.dem.run import run_cases
from overturning.dem.time_step import AUTO_FRACTION, DEFAULT_SCHEME, scheme_of
from overturning.model.contact import STATIC_PENETRATION
from verification.work_precision.boundaries import answers, boundaries, boundary_shift, kernel, located
from verification.work_precision.cases import record_groups, thinned, thinned_values
from verification.work_precision.table import (
    PENETRATIONS,
    SCHEMES,
    Say,
    errors,
    fractions_of,
    run,
    setting_columns,
    settings,
)

FINEST: Final = 0.006
"""Δt/Δt_stable of the reference, with the centred scheme."""

THIN_BELOW: Final = 0.05
"""At finer steps every third case is run, so that the diagrams are made in minutes."""

EVERY: Final = 3

LEAST_WITH_BOUNDARY: Final = 0.02
"""At finer steps no boundary is looked for."""

MOST: Final = 4
"""Overturning boundaries of each record."""

FINE_FOR_STIFFNESS: Final = 0.03
"""Δt/Δt_stable of the references of other stiffnesses, whose errors are far below what the stiffness changes."""

WIDE_BRACKET: Final = 0.02
"""Half the bracket, as a share of B/H, in which the boundary of another stiffness is looked for."""


def against_finer_steps(kind: str, say: Say) -> list[dict[str, Any]]:
    """Schemes over time steps, against the centred scheme at a far finer step, on six real records.

    Parameters
    ----------
    kind : str
        "sliding" or "rocking".
    say : callable
        Takes progress lines.
    """
    groups = record_groups(kind)
    finest = kernel(**settings("centred", FINEST))
    right = answers(groups, finest)
    few = thinned(groups, EVERY)
    right_few = (thinned_values(groups, right[0], EVERY), thinned_values(groups, right[1], EVERY))
    where = boundaries(groups, right[0], MOST)
    near, exact = located(groups, where, kernel(), finest)
    say(f"{kind}: reference of {right[0].size} cases and {len(where)} boundaries is done")
    rows = []
    for scheme in SCHEMES:
        for fraction in fractions_of(scheme):
            thin = fraction < THIN_BELOW
            chosen, truth = (few, right_few) if thin else (groups, right)
            arguments = settings(scheme, fraction)
            flags, peaks, spent = run(chosen, arguments)
            numbers = errors(flags, peaks, truth)
            if fraction >= LEAST_WITH_BOUNDARY:
                numbers["boundary_shift"] = boundary_shift(groups, where, kernel(**arguments), near, exact)
            of: dict[str, Any] = {"cases_of": f"records, {kind}", "method": scheme, "against": "finer step"}
            rows.append(of | setting_columns(scheme, fraction) | spent | numbers)
            say(f"{kind}: {scheme} at {fraction:g} of the stable step is done")
    return rows


def over_stiffness(kind: str, say: Say) -> list[dict[str, Any]]:
    """Springs over stiffness at the default share of the stable step, against finer steps at the same and the largest.

    Parameters
    ----------
    kind : str
        "sliding" or "rocking".
    say : callable
        Takes progress lines.
    """
    groups, stiffest = record_groups(kind), PENETRATIONS[-1]
    fraction = AUTO_FRACTION[scheme_of(DEFAULT_SCHEME)]
    exact = {
        delta: answers(groups, kernel(**settings("centred", FINE_FOR_STIFFNESS, delta)))
        for delta in PENETRATIONS
        if delta != STATIC_PENETRATION
    }
    usual, slow = settings(DEFAULT_SCHEME, fraction, stiffest), settings("centred", 2 * FINE_FOR_STIFFNESS, stiffest)
    where = boundaries(groups, answers(groups, kernel(**usual))[0], MOST)
    near, right = located(groups, where, kernel(**usual), kernel(**slow), WIDE_BRACKET)
    say(f"{kind}: references over stiffness are done")
    rows = []
    for delta in PENETRATIONS:
        arguments = settings(DEFAULT_SCHEME, fraction, delta)
        flags, peaks, spent = run(groups, arguments)
        shift = boundary_shift(groups, where, kernel(**arguments), near, right, WIDE_BRACKET)
        common: dict[str, Any] = {"cases_of": f"records, {kind}", "method": DEFAULT_SCHEME} | spent
        common |= setting_columns(DEFAULT_SCHEME, fraction, delta)
        numbers = errors(flags, peaks, exact[stiffest])
        rows.append(common | numbers | {"against": "stiffest springs", "boundary_shift": shift})
        if delta in exact:  # that of the default stiffness has a row already
            rows.append(common | errors(flags, peaks, exact[delta]) | {"against": "finer step"})
        say(f"{kind}: δ/B {delta:g} is done")
    return rows


def energy_balance(say: Say) -> list[dict[str, Any]]:
    """Mean residual of work and energy of cases that slide or rock, over time steps."""
    groups = [part for kind in ("sliding", "rocking") for part in thinned(record_groups(kind), 6)]
    rows = []
    for scheme in SCHEMES:
        for fraction in fractions_of(scheme)[:-1]:
            found = [run_cases(g.motion, g.cases, **settings(scheme, fraction)) for g in groups]
            residual = np.concatenate([one.energy_error for one in found])
            simulated = np.concatenate([one.status for one in found]) == 0
            of: dict[str, Any] = {"cases_of": "records, all", "method": scheme, "against": "energy balance"}
            numbers = {"cases": int(simulated.sum()), "energy_error": float(np.mean(residual[simulated]))}
            rows.append(of | setting_columns(scheme, fraction) | numbers)
    say(f"energy: {len(rows)} settings are done")
    return rows
