"""Measured figures within the sentences of README.md and docs/.

A page contains ``<!--=name-->5<!--/-->``. `verification.tables.publish_markdown` calls `fill_markers`, which replaces
the text between the markers by the figure `FIGURES[name]`, computed from the tables in verification/results. To state a
new figure, add it to `FIGURES`, write its marker into the page, and run `python -m verification.tables`.
"""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

import pandas as pd

MARK: Final = re.compile(r"<!--=([\w-]+)-->(.*?)<!--/-->", flags=re.DOTALL)


def table_cell(file: str, quantity: str, number_format: str, results: Path) -> str:
    """Return a figure from a file of `verification.tables.write_figures`, in the format `number_format`."""
    rows = pd.read_csv(results / file)
    return number_format.format(rows.loc[rows["quantity"] == quantity, "value"].item())


def eighth_step_figures(number_format: str, results: Path) -> str:
    """Format wrong flags with the default step and with 1/8 of it, %, and the ratio of their processor times."""
    curve = pd.read_csv(results / "default-step.csv")
    own = curve[curve["scheme"] == "centred"].set_index("step")
    wrong, seconds = own["wrong flags, %"], own["processor time, s"]
    return number_format.format(wrong[1.0], wrong[0.125], seconds[0.125] / seconds[1.0])


def rigid_block_counts(number_format: str, results: Path) -> str:
    """Format the counts of record cases, of those unlike the rigid block, and of those among the engines' cases."""
    rows = pd.read_csv(results / "work-precision.csv")
    own = (rows["cases_of"] == "records, no sliding") & (rows["method"] == "centred") & (rows["default"] == 1)
    (at,) = rows.loc[own, ["cases", "wrong_flags", "wrong_sides", "disagree"]].to_numpy(float)
    return number_format.format(at[0], at[1] + at[2], at[3])


def boulder_test_count(results: Path) -> str:
    """Return the number of shaking-table tests that are predicted from tests with other motions."""
    rows = pd.read_csv(results / "shaking-table.csv")
    return str(rows.loc[rows["split"] == "motion left out", "tests"].max())


def indented_output(file: str, results: Path) -> str:
    """Return what a command printed, from a file, as a block of code between empty lines."""
    lines = (results / file).read_text(encoding="utf-8").splitlines()
    return "\n\n" + "\n".join(f"    {line}" if line else "" for line in lines) + "\n\n"


_BENCH: Final = "x86-64-2-cores.csv"
_TUTORIAL: Final = "tutorial.csv"
_PLANES: Final = "2-D model predicts correctly whether it falls"

FIGURES: Final[dict[str, Callable[[Path], str]]] = {
    "study-cases": partial(table_cell, _BENCH, "default study: flags, mirrored half included", "{:,.0f}"),
    "left-out-cases": partial(table_cell, _BENCH, "cases, mirrored half left out", "{:,.0f}"),
    "left-out-flags": partial(table_cell, _BENCH, "flags changed by leaving out", "{:.0f}"),
    "left-out-sides": partial(table_cell, _BENCH, "sides changed by leaving out", "{:.0f}"),
    "operations-centred": partial(table_cell, _BENCH, "operations per block step, centred", "{:.0f}"),
    "operations-cundall": partial(table_cell, _BENCH, "operations per block step, cundall", "{:.0f}"),
    "whole-step-flags": partial(eighth_step_figures, "{0:.1f} %"),
    "eighth-step-flags": partial(eighth_step_figures, "{1:.1f} %"),
    "eighth-step-time": partial(eighth_step_figures, "{2:.1f}"),
    "planes-right": partial(table_cell, "in-space.csv", _PLANES, "{:.0f} %"),
    "planes-right-near": partial(
        table_cell, "in-space.csv", f"{_PLANES}, a neighbour in B/H has another flag", "{:.0f} %"
    ),
    "planes-other-edge": partial(
        table_cell, "in-space.csv", "2-D model predicts another edge than the one it falls over", "{:.0f} %"
    ),
    "pillars-flags": partial(table_cell, "scenes.csv", "three pillars under real records: flags", "{:,.0f}"),
    "box2d-right": partial(table_cell, "scenes.csv", "Box2D: correct side of the shaft", "{:.0f} %"),
    "pymunk-right": partial(table_cell, "scenes.csv", "pymunk: correct side of the shaft", "{:.0f} %"),
    "scene-right": partial(
        table_cell, "scenes.csv", "default: correct side of the shaft, cases of the other engines", "{:.0f} %"
    ),
    "rigid-cases": partial(rigid_block_counts, "{0:.0f}"),
    "rigid-otherwise": partial(rigid_block_counts, "{1:.0f}"),
    "rigid-otherwise-shared": partial(rigid_block_counts, "{2:.0f}"),
    "boulder-tests": boulder_test_count,
    "waiau-cases": partial(table_cell, _TUTORIAL, "2-D: cases", "{:.0f}"),
    "waiau-with-only": partial(table_cell, _TUTORIAL, "2-D: falls with vertical motion only", "{:.1f} %"),
    "waiau-without-only": partial(table_cell, _TUTORIAL, "2-D: falls without vertical motion only", "{:.1f} %"),
    "waiau-both": partial(table_cell, _TUTORIAL, "2-D: falls in both", "{:.1f} %"),
    "waiau-same-side": partial(table_cell, _TUTORIAL, "2-D: same side, of falls in both", "{:.1f} %"),
    "waiau-slender-with": partial(table_cell, _TUTORIAL, "2-D: B/H 0.35, falls with vertical motion", "{:.0f} %"),
    "waiau-slender-without": partial(table_cell, _TUTORIAL, "2-D: B/H 0.35, falls without vertical motion", "{:.0f} %"),
    "waiau-stout-with": partial(table_cell, _TUTORIAL, "2-D: B/H 0.55, falls with vertical motion", "{:.0f} %"),
    "waiau-stout-without": partial(table_cell, _TUTORIAL, "2-D: B/H 0.55, falls without vertical motion", "{:.0f} %"),
    "waiau-stones": partial(table_cell, _TUTORIAL, "3-D: stones", "{:.0f}"),
    "waiau-space-with": partial(table_cell, _TUTORIAL, "3-D: falls with vertical motion", "{:.0f} %"),
    "waiau-space-without": partial(table_cell, _TUTORIAL, "3-D: falls without vertical motion", "{:.0f} %"),
    "waiau-space-changes": partial(table_cell, _TUTORIAL, "3-D: another outcome", "{:.0f}"),
    "waiau-space-both": partial(table_cell, _TUTORIAL, "3-D: falls in both", "{:.0f}"),
    "waiau-space-turned": partial(table_cell, _TUTORIAL, "3-D: another direction", "{:.0f} %"),
    "waiau-space-median": partial(table_cell, _TUTORIAL, "3-D: median change of direction", "{:.0f}°"),
    "tutorial-survey": partial(indented_output, "tutorial-survey.txt"),
}
"""Function that returns the text of a marker from the folder of the tables, by name."""


def fill_markers(text: str, results_folder: Path) -> str:
    """Return a page with the figures written between its markers; a KeyError for an unknown marker."""
    return MARK.sub(lambda found: f"<!--={found[1]}-->{FIGURES[found[1]](results_folder)}<!--/-->", text)
