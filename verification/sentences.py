"""Measured figures within the sentences of README.md and docs/: each out of the table that it comes from.

In a page stands ``<!--=name-->5<!--/-->``; `fill`, which `verification.tables.publish` calls, puts there what `FIGURES`
make of the tables in verification/results by that name. To state a figure, enter it in `FIGURES`, write its mark,
and run `python -m verification.tables`.
"""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

import pandas as pd

MARK: Final = re.compile(r"<!--=([\w-]+)-->(.*?)<!--/-->", flags=re.DOTALL)


def cell(file: str, quantity: str, written: str, results: Path) -> str:
    """A figure of a file that `verification.tables.write_figures` wrote, as `written` says."""
    rows = pd.read_csv(results / file)
    return written.format(rows.loc[rows["quantity"] == quantity, "value"].item())


def eighth_of_the_step(written: str, results: Path) -> str:
    """Wrong flags of the default and of an eighth of its step, %, and the time of these over the default's."""
    curve = pd.read_csv(results / "default-step.csv")
    own = curve[curve["scheme"] == "centred"].set_index("step")
    wrong, seconds = own["wrong flags, %"], own["processor time, s"]
    return written.format(wrong[1.0], wrong[0.125], seconds[0.125] / seconds[1.0])


def beside_the_rigid_block(written: str, results: Path) -> str:
    """Record cases beside the rigid block, those that the default ends otherwise, and such among the engines' cases."""
    rows = pd.read_csv(results / "work-precision.csv")
    own = (rows["cases_of"] == "records, no sliding") & (rows["method"] == "centred") & (rows["default"] == 1)
    (at,) = rows.loc[own, ["cases", "wrong_flags", "wrong_sides", "disagree"]].to_numpy(float)
    return written.format(at[0], at[1] + at[2], at[3])


def tests_of_the_boulder(results: Path) -> str:
    """Tests of the shaking table, each of which is foretold from those of other motions."""
    rows = pd.read_csv(results / "shaking-table.csv")
    return str(rows.loc[rows["split"] == "motion left out", "tests"].max())


_BENCH: Final = "x86-64-2-cores.csv"
_PLANES: Final = "2-D model predicts correctly whether it falls"

FIGURES: Final[dict[str, Callable[[Path], str]]] = {
    "study-cases": partial(cell, _BENCH, "default study: flags, mirrored half included", "{:,.0f}"),
    "left-out-cases": partial(cell, _BENCH, "cases, mirrored half left out", "{:,.0f}"),
    "left-out-flags": partial(cell, _BENCH, "flags changed by leaving out", "{:.0f}"),
    "left-out-sides": partial(cell, _BENCH, "sides changed by leaving out", "{:.0f}"),
    "operations-centred": partial(cell, _BENCH, "operations per block step, centred", "{:.0f}"),
    "operations-cundall": partial(cell, _BENCH, "operations per block step, cundall", "{:.0f}"),
    "whole-step-flags": partial(eighth_of_the_step, "{0:.1f} %"),
    "eighth-step-flags": partial(eighth_of_the_step, "{1:.1f} %"),
    "eighth-step-time": partial(eighth_of_the_step, "{2:.1f}"),
    "planes-right": partial(cell, "in-space.csv", _PLANES, "{:.0f} %"),
    "planes-right-beside": partial(cell, "in-space.csv", f"{_PLANES}, a neighbour in B/H has another flag", "{:.0f} %"),
    "planes-other-edge": partial(
        cell, "in-space.csv", "2-D model predicts another edge than the one it falls over", "{:.0f} %"
    ),
    "pillars-flags": partial(cell, "scenes.csv", "three pillars under real records: flags", "{:,.0f}"),
    "box2d-right": partial(cell, "scenes.csv", "Box2D: correct side of the shaft", "{:.0f} %"),
    "pymunk-right": partial(cell, "scenes.csv", "pymunk: correct side of the shaft", "{:.0f} %"),
    "scene-right": partial(
        cell, "scenes.csv", "default: correct side of the shaft, cases of the other engines", "{:.0f} %"
    ),
    "rigid-cases": partial(beside_the_rigid_block, "{0:.0f}"),
    "rigid-otherwise": partial(beside_the_rigid_block, "{1:.0f}"),
    "rigid-otherwise-shared": partial(beside_the_rigid_block, "{2:.0f}"),
    "boulder-tests": tests_of_the_boulder,
}
"""What stands at a mark, from the folder of the tables."""


def fill(text: str, results: Path) -> str:
    """A page with its marks filled; one that `FIGURES` do not know is a KeyError."""
    return MARK.sub(lambda found: f"<!--={found[1]}-->{FIGURES[found[1]](results)}<!--/-->", text)
