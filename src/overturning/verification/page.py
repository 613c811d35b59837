"""Measured figures into the page about verification, between marks, and as a summary: nothing is typed by hand."""

import itertools
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from overturning.errors import ResultError
from overturning.files import whole
from overturning.verification.intervals import wilson
from overturning.verification.measures import RESOLUTION, order
from overturning.verification.stability import Ending
from overturning.verification.stability_cases import SPECIAL
from overturning.verification.table import Columns, read_table

ORDER_FRACTIONS: Final = (0.5, 0.05)
"""Largest and smallest Δt/Δt_stable between which the order of convergence is read off."""


def joined(paths: Mapping[str, Path]) -> Columns:
    """The tables of the parts as one; a column that a part does not have is NaN there."""
    tables = [read_table(path)[0] for path in paths.values()]
    names = list(dict.fromkeys(name for table in tables for name in table))
    return {
        name: np.concatenate([
            table[name] if name in table else np.full(len(table["method"]), np.nan) for table in tables
        ])
        for name in names
    }  # fmt: skip


def insert(text: str, mark: str, body: str) -> str:
    """The text with a body between the lines ``<!-- mark:begin -->`` and ``<!-- mark:end -->``.

    Raises
    ------
    ResultError
        If the marks are not there.
    """
    begin, end = f"<!-- {mark}:begin -->", f"<!-- {mark}:end -->"
    if begin not in text or end not in text:
        raise ResultError(f"the page has no marks {begin} and {end}; put them where the figures belong")
    return re.sub(f"{re.escape(begin)}.*?{re.escape(end)}", lambda _: f"{begin}\n{body}\n{end}", text, flags=re.DOTALL)


def write_page(page: Path, bodies: Mapping[str, str]) -> None:
    """Put every body between its marks in a page."""
    try:
        text = page.read_text(encoding="utf-8")
    except OSError as error:
        raise ResultError(f"{page}: cannot be read ({error.strerror})") from None
    for mark, body in bodies.items():
        text = insert(text, mark, body)
    with whole(page) as part:
        part.write_text(text, encoding="utf-8")


def orders(rows: Columns) -> dict[str, float]:
    """Order of convergence of each scheme on each continuous measure."""
    found = {}
    high, low = ORDER_FRACTIONS
    steps = (rows["step_fraction"] <= high) & (rows["step_fraction"] >= low)
    for kind in ("rocking", "sliding"):
        for measure in ("rotation_error", "boundary_shift"):
            for method in ("centred", "cundall"):
                chosen = steps & (rows["cases_of"] == f"records, {kind}") & (rows["method"] == method)
                found[f"{kind}, {measure}, {method}"] = order(rows["step_fraction"][chosen], rows[measure][chosen])
    for method in ("centred", "cundall"):
        chosen = steps & (rows["against"] == "energy balance") & (rows["method"] == method)
        found[f"energy, {method}"] = order(rows["step_fraction"][chosen], rows["energy_error"][chosen])
    return found


def _share(count: float, total: float) -> str:
    low, high = wilson(int(count), int(total))
    return f"{100 * count / max(total, 1):.2f} % ({int(count)} of {int(total)}; {100 * low:.2f} to {100 * high:.2f})"


def _number(value: float, percent: bool = False) -> str:
    if not np.isfinite(value):
        return "–"
    if percent and value == 0:
        return f"< {100 * RESOLUTION:.2g} %"
    return f"{100 * value:.2g} %" if percent else f"{value:.2g}"


def steps_table(rows: Columns) -> str:
    """Errors of both schemes against a far finer step, as Markdown."""
    lines = [
        "| cases | scheme | Δt/Δt stable | s per case | wrong flags (95 %) | wrong sides (95 %) | peak rotation | boundary |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for index in np.flatnonzero(rows["against"] == "finer step"):
        at = {name: values[index] for name, values in rows.items()}
        mark = " **default**" if at["default"] == 1 else ""
        lines.append(
            f"| {at['cases_of']} | {at['method']}{mark} | {at['step_fraction']:g} | {at['seconds_per_case']:.2g} | "
            f"{_share(at['wrong_flags'], at['cases'])} | {_share(at['wrong_sides'], at['fallen'])} | "
            f"{_number(at['rotation_error'])} | {_number(at['boundary_shift'], percent=True)} |"
        )
    return "\n".join(lines)


def rigid_table(rows: Columns) -> str:
    """Errors against rigid rocking and sliding, engines included, as Markdown."""
    lines = [
        "| cases | method | step | δ/B | s per case | wrong flags (95 %) | wrong sides | peak rotation | peak slip |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for index in np.flatnonzero(np.isin(rows["against"], ("rigid rocking", "exact sliding"))):
        at = {name: values[index] for name, values in rows.items()}
        engine = not np.isfinite(at["penetration_ratio"])
        mark = " **default**" if at["default"] == 1 else ""
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


def stability_table(rows: Columns, about: Mapping[str, Any]) -> str:
    """How the cases of the map end, as Markdown."""
    kinds = {"space-filling": ~np.isin(rows["motion"], SPECIAL)} | {name: rows["motion"] == name for name in SPECIAL}
    heads = [ending.name.lower().replace("_", " ") for ending in Ending]
    lines = [f"| motion | cases | {' | '.join(heads)} |", "|---" * (len(heads) + 2) + "|"]
    for name, chosen in kinds.items():
        counted = [int((rows["ending"][chosen] == ending).sum()) for ending in Ending]
        lines.append(f"| {name} | {int(chosen.sum())} | {' | '.join(map(str, counted))} |")
    right = rows["ending"] == Ending.RIGHT
    reasons, number = np.unique(rows["reason"][rows["ending"] == Ending.REFUSED], return_counts=True)
    refusals = ", ".join(f"{count} for `{name}`" for name, count in zip(reasons, number, strict=True))
    lines += [
        "",
        f"{len(right)} cases in all, at most {about['budget']:.3g} block steps each. The largest residual of work and energy among the "
        f"{int(right.sum())} right ones is {np.max(rows['energy_error'][right]):.4f}, its median "
        f"{np.median(rows['energy_error'][right]):.2g}. Refused: {refusals or 'none'}. Silent: "
        f"{int((rows['ending'] == Ending.SILENT).sum())}.",
        "",
        f"| δ/B | cases | {' | '.join(heads)} |",
        "|---" * (len(heads) + 2) + "|",
    ]
    edges = (0.0, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2, 1e-1, np.inf)
    for low, high in itertools.pairwise(edges):
        chosen = (rows["penetration_ratio"] >= low) & (rows["penetration_ratio"] < high)
        shares = [
            f"{100 * np.mean(rows['ending'][chosen] == ending):.1f} %" if chosen.any() else "–" for ending in Ending
        ]
        lines.append(f"| {low:g} to {high:g} | {int(chosen.sum())} | {' | '.join(shares)} |")
    return "\n".join(lines)
