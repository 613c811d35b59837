"""Tables of errors and run times, as Markdown."""

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.contact import STATIC_PENETRATION
from overturning.verification.intervals import wilson
from overturning.verification.measures import RESOLUTION
from overturning.verification.page import over_steps
from overturning.verification.table import Columns


def _share(count: float, total: float) -> str:
    low, high = wilson(int(count), int(total))
    return f"{100 * count / max(total, 1):.2f} % ({int(count)} of {int(total)}; {100 * low:.2f} to {100 * high:.2f})"


def _number(value: float, percent: bool = False) -> str:
    if not np.isfinite(value):
        return "–"
    if percent and value == 0:
        return f"< {100 * RESOLUTION:.2g} %"
    return f"{100 * value:.2g} %" if percent else f"{value:.2g}"


_ERRORS: Final = "wrong flags (95 %) | wrong sides (95 %) | peak rotation | boundary |"


def _errors(at: Mapping[str, float]) -> str:
    """The cells under `_ERRORS`."""
    return (
        f"{_share(at['wrong_flags'], at['cases'])} | {_share(at['wrong_sides'], at['fallen'])} | "
        f"{_number(at['rotation_error'])} | {_number(at['boundary_shift'], percent=True)} |"
    )


def _chosen(rows: Columns, chosen: NDArray[np.bool_]) -> Iterator[tuple[dict[str, Any], str]]:
    """Each chosen row, and the mark of a default one."""
    for index in np.flatnonzero(chosen):
        at = {name: values[index] for name, values in rows.items()}
        yield at, " **default**" if at["default"] == 1 else ""


def steps_table(rows: Columns) -> str:
    """Errors of both schemes against a far finer step, as Markdown."""
    lines = [
        f"| cases | scheme | Δt/Δt stable | s per case | {_ERRORS}",
        "|---|---|---|---|---|---|---|---|",
    ]
    for at, mark in _chosen(rows, over_steps(rows, "rocking") | over_steps(rows, "sliding")):
        lines.append(
            f"| {at['cases_of']} | {at['method']}{mark} | {at['step_fraction']:g} | {at['seconds_per_case']:.2g} | {_errors(at)}"
        )
    return "\n".join(lines)


def stiffness_table(rows: Columns) -> str:
    """Errors of the default scheme and step over stiffness, as Markdown."""
    lines = [
        f"| cases | δ/B | s per case | against | {_ERRORS}",
        "|---|---|---|---|---|---|---|---|",
    ]
    several = np.isfinite(rows["penetration_ratio"]) & ~np.isclose(rows["penetration_ratio"], STATIC_PENETRATION)
    steps = several & (rows["against"] == "finer step")
    for at, mark in _chosen(rows, steps | (rows["against"] == "stiffest springs")):
        against = "the same, finer steps" if at["against"] == "finer step" else "stiffest, finer steps"
        lines.append(
            f"| {at['cases_of']} | {at['penetration_ratio']:.0e}{mark} | {at['seconds_per_case']:.2g} | {against} | {_errors(at)}"
        )
    return "\n".join(lines)


def rigid_table(rows: Columns) -> str:
    """Errors against rigid rocking and sliding, engines included, as Markdown."""
    lines = [
        "| cases | method | step | δ/B | s per case | wrong flags (95 %) | wrong sides | peak rotation | peak slip |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for at, mark in _chosen(rows, np.isin(rows["against"], ("rigid rocking", "exact sliding"))):
        engine = not np.isfinite(at["penetration_ratio"])
        step = f"1/{1 / at['step_fraction']:.0f} s" if engine else f"{at['step_fraction']:g}"
        delta = "–" if engine else f"{at['penetration_ratio']:.0e}"
        flags = _share(at["wrong_flags"], at["cases"]) if np.isfinite(at["wrong_flags"]) else "–"
        sides = f"{at['wrong_sides']:.0f} of {at['fallen']:.0f}" if np.isfinite(at["wrong_sides"]) else "–"
        lines.append(
            f"| {at['cases_of']} | {at['method']}{mark} | {step} | {delta} | "
            f"{at['seconds_per_case']:.2g} | {flags} | {sides} | {_number(at['rotation_error'])} | "
            f"{_number(at['slip_error'], percent=True)} |"
        )
    return "\n".join(lines)


def orders_table(found: Mapping[str, float]) -> str:
    """Orders of convergence as Markdown."""
    lines = ["| measure | order |", "|---|---|"]
    lines += [
        f"| {name.replace('_', ' ')} | {f'{value:.2f}' if np.isfinite(value) else 'shifts below what bisection resolves'} |"
        for name, value in found.items()
    ]
    return "\n".join(lines)
