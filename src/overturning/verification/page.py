"""Measured figures into the page about verification, between marks: nothing is typed by hand."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.contact import STATIC_PENETRATION
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.verification.measures import order
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
    with atomic_write(page) as part:
        part.write_text(text, encoding="utf-8")


def over_steps(rows: Columns, kind: str) -> NDArray[np.bool_]:
    """The rows of a set of records in which the time step varies and the stiffness does not."""
    own = np.isclose(rows["penetration_ratio"], STATIC_PENETRATION)
    return np.asarray((rows["cases_of"] == f"records, {kind}") & (rows["against"] == "finer step") & own)


def orders(rows: Columns) -> dict[str, float]:
    """Order of convergence of each scheme on each continuous measure."""
    found = {}
    high, low = ORDER_FRACTIONS
    steps = (rows["step_fraction"] <= high) & (rows["step_fraction"] >= low)
    for kind in ("rocking", "sliding"):
        for measure in ("rotation_error", "boundary_shift"):
            for method in ("centred", "cundall"):
                chosen = steps & over_steps(rows, kind) & (rows["method"] == method)
                found[f"{kind}, {measure}, {method}"] = order(rows["step_fraction"][chosen], rows[measure][chosen])
    for method in ("centred", "cundall"):
        chosen = steps & (rows["against"] == "energy balance") & (rows["method"] == method)
        found[f"energy, {method}"] = order(rows["step_fraction"][chosen], rows["energy_error"][chosen])
    return found
