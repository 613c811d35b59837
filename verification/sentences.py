"""Measured figures within the sentences of README.md and docs/.

A page contains ``<!--=name-->5<!--/-->``. `verification.tables.update_marked_tables_and_sentences_in_docs` calls
`fill_measured_numbers_into_page`, which replaces the text between the markers by the figure `FIGURES[name]`, computed
from the tables in verification/results. To state a new figure, add it to `NUMBER_FUNCTION_BY_MARKER`, write its marker
into the page, and run `python -m verification.tables`.
"""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

import pandas as pd

MARKED_NUMBER_PATTERN: Final = re.compile(r"<!--=([\w-]+)-->(.*?)<!--/-->", flags=re.DOTALL)


def formatted_measured_number(
    file_name: str, quantity: str, text_template_for_number: str, results_folder: Path
) -> str:
    """Return a measured number from a CSV file as text in the format `text_template_for_number`.

    `verification.tables.write_measured_numbers` writes such files.
    """
    rows = pd.read_csv(results_folder / file_name)
    return text_template_for_number.format(rows.loc[rows["quantity"] == quantity, "value"].item())


def format_wrong_flag_shares_and_cost_of_eighth_step(text_template_for_number: str, results_folder: Path) -> str:
    """Return as text: wrong-flag shares, %, at the default time step and 1/8 of it, and ratio of processor times."""
    curve = pd.read_csv(results_folder / "default-step.csv")
    own = curve[curve["scheme"] == "centred"].set_index("step")
    wrong, seconds = own["wrong flags, %"], own["processor time, s"]
    return text_template_for_number.format(wrong[1.0], wrong[0.125], seconds[0.125] / seconds[1.0])


def format_rigid_block_disagreement_counts(text_template_for_number: str, results_folder: Path) -> str:
    """Format the numbers of all cases under records and of two kinds of cases that differ from the rigid block.

    The first kind are all cases with another outcome than that of the rigid block, the second those of them that the
    physics engines also simulate.
    """
    rows = pd.read_csv(results_folder / "work-precision.csv")
    own = (rows["cases_of"] == "records, no sliding") & (rows["method"] == "centred") & (rows["default"] == 1)
    (at,) = rows.loc[own, ["cases", "wrong_flags", "wrong_sides", "disagree"]].to_numpy(float)
    return text_template_for_number.format(at[0], at[1] + at[2], at[3])


def boulder_test_count_predicted_from_other_motions(results_folder: Path) -> str:
    """Return the number of shaking-table tests that are predicted from tests with other motions."""
    rows = pd.read_csv(results_folder / "shaking-table.csv")
    return str(rows.loc[rows["split"] == "motion left out", "tests"].max())


def printed_output_as_code_block(file_name: str, results_folder: Path) -> str:
    """Return what a command printed, from a file, as a block of code between empty lines."""
    lines = (results_folder / file_name).read_text(encoding="utf-8").splitlines()
    return "\n\n" + "\n".join(f"    {line}" if line else "" for line in lines) + "\n\n"


_TWO_CORE_BENCHMARK_FILE: Final = "x86-64-2-cores.csv"
_TUTORIAL_NUMBERS_FILE: Final = "tutorial.csv"
_PLANAR_ACCURACY_QUANTITY: Final = "2-D model predicts correctly whether it falls"

NUMBER_FUNCTION_BY_MARKER: Final[dict[str, Callable[[Path], str]]] = {
    "study-cases": partial(
        formatted_measured_number, _TWO_CORE_BENCHMARK_FILE, "default study: flags, mirrored half included", "{:,.0f}"
    ),
    "left-out-cases": partial(
        formatted_measured_number, _TWO_CORE_BENCHMARK_FILE, "cases, mirrored half left out", "{:,.0f}"
    ),
    "left-out-flags": partial(
        formatted_measured_number, _TWO_CORE_BENCHMARK_FILE, "flags changed by leaving out", "{:.0f}"
    ),
    "left-out-sides": partial(
        formatted_measured_number, _TWO_CORE_BENCHMARK_FILE, "sides changed by leaving out", "{:.0f}"
    ),
    "operations-centred": partial(
        formatted_measured_number, _TWO_CORE_BENCHMARK_FILE, "operations per block step, centred", "{:.0f}"
    ),
    "operations-cundall": partial(
        formatted_measured_number, _TWO_CORE_BENCHMARK_FILE, "operations per block step, cundall", "{:.0f}"
    ),
    "whole-step-flags": partial(format_wrong_flag_shares_and_cost_of_eighth_step, "{0:.1f} %"),
    "eighth-step-flags": partial(format_wrong_flag_shares_and_cost_of_eighth_step, "{1:.1f} %"),
    "eighth-step-time": partial(format_wrong_flag_shares_and_cost_of_eighth_step, "{2:.1f}"),
    "planes-right": partial(formatted_measured_number, "in-space.csv", _PLANAR_ACCURACY_QUANTITY, "{:.0f} %"),
    "planes-right-near": partial(
        formatted_measured_number,
        "in-space.csv",
        f"{_PLANAR_ACCURACY_QUANTITY}, a neighbour in B/H has another flag",
        "{:.0f} %",
    ),
    "planes-other-edge": partial(
        formatted_measured_number,
        "in-space.csv",
        "2-D model predicts another edge than the one it falls over",
        "{:.0f} %",
    ),
    "pillars-flags": partial(
        formatted_measured_number, "scenes.csv", "three pillars under real records: flags", "{:,.0f}"
    ),
    "box2d-right": partial(formatted_measured_number, "scenes.csv", "Box2D: correct side of the shaft", "{:.0f} %"),
    "pymunk-right": partial(formatted_measured_number, "scenes.csv", "pymunk: correct side of the shaft", "{:.0f} %"),
    "scene-right": partial(
        formatted_measured_number,
        "scenes.csv",
        "default: correct side of the shaft, cases of the other engines",
        "{:.0f} %",
    ),
    "rigid-cases": partial(format_rigid_block_disagreement_counts, "{0:.0f}"),
    "rigid-otherwise": partial(format_rigid_block_disagreement_counts, "{1:.0f}"),
    "rigid-otherwise-shared": partial(format_rigid_block_disagreement_counts, "{2:.0f}"),
    "boulder-tests": boulder_test_count_predicted_from_other_motions,
    "waiau-cases": partial(formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: cases", "{:.0f}"),
    "waiau-with-only": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: falls with vertical motion only", "{:.1f} %"
    ),
    "waiau-without-only": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: falls without vertical motion only", "{:.1f} %"
    ),
    "waiau-both": partial(formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: falls in both", "{:.1f} %"),
    "waiau-same-side": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: same side, of falls in both", "{:.1f} %"
    ),
    "waiau-slender-with": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: B/H 0.35, falls with vertical motion", "{:.0f} %"
    ),
    "waiau-slender-without": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: B/H 0.35, falls without vertical motion", "{:.0f} %"
    ),
    "waiau-stout-with": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: B/H 0.55, falls with vertical motion", "{:.0f} %"
    ),
    "waiau-stout-without": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "2-D: B/H 0.55, falls without vertical motion", "{:.0f} %"
    ),
    "waiau-stones": partial(formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "3-D: stones", "{:.0f}"),
    "waiau-space-with": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "3-D: falls with vertical motion", "{:.0f} %"
    ),
    "waiau-space-without": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "3-D: falls without vertical motion", "{:.0f} %"
    ),
    "waiau-space-changes": partial(formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "3-D: another outcome", "{:.0f}"),
    "waiau-space-both": partial(formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "3-D: falls in both", "{:.0f}"),
    "waiau-space-turned": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "3-D: another direction", "{:.0f} %"
    ),
    "waiau-space-median": partial(
        formatted_measured_number, _TUTORIAL_NUMBERS_FILE, "3-D: median change of direction", "{:.0f}°"
    ),
    "tutorial-survey": partial(printed_output_as_code_block, "tutorial-survey.txt"),
}
"""Function that returns the text of a marker from the folder of the tables, by name."""


def fill_measured_numbers_into_page(text: str, results_folder: Path) -> str:
    """Return the text of a page with the measured numbers filled in between its markers.

    Raise a KeyError for an unknown marker.
    """
    return MARKED_NUMBER_PATTERN.sub(
        lambda found: f"<!--={found[1]}-->{NUMBER_FUNCTION_BY_MARKER[found[1]](results_folder)}<!--/-->", text
    )
