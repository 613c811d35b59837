"""`python -m verification.tutorial`: measure the figures of docs/tutorial.md and what its survey command prints.

Writes verification/results/tutorial.csv and tutorial-survey.txt, from which `verification.sentences` fills the page.
"""

import contextlib
import io
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr

import overturning
from overturning.cli import main as run_command
from overturning.files import write_text
from overturning.motion.direction import angle_between_azimuths
from overturning.study.load import load_study
from verification.measures import percentage
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    MeasuredNumber,
    update_marked_tables_and_sentences_in_docs,
    wrap_text,
    write_measured_numbers,
)

TUTORIAL_STUDY_SETTINGS: Final[dict[str, Any]] = {
    "azimuth": {"step": 10}, "b_over_h": {"start": 0.1, "stop": 0.6, "step": 0.1}, "height": [0.6],
    "friction": [0.58, 1.0],
}  # fmt: skip
"""Study of the record wtmc that the tutorial writes as config/mine.yaml."""

SETTINGS_OF_3D_STUDY: Final[dict[str, Any]] = {
    "body": {}, "orientation": {"step": 5}, "b_over_h": {"start": 0.1, "stop": 0.6, "step": 0.05}, "height": [0.6],
    "friction": [0.58, 1.0],
}  # fmt: skip
"""3-D study that the tutorial runs with and without the vertical component."""

TUTORIAL_SURVEY_CSV: Final = "octant,count\nSE,5\nS,2\nNW,1\n"
"""File of the survey in the tutorial."""

SHOWN_B_OVER_H: Final = (0.35, 0.55)
"""B/H whose shares the tutorial states."""

MIN_COUNTED_AZIMUTH_CHANGE_DEG: Final = 15.0
"""Change of the fall azimuth that the tutorial counts, degrees."""


def output_of_tutorial_survey_command() -> str:
    """Return what `overturning survey` prints for the tutorial's study and survey, with lines of the page's length."""
    printed = io.StringIO()
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        overturning.run_study(["wtmc"], threads=2, **TUTORIAL_STUDY_SETTINGS).to_netcdf("cube.nc")
        Path("survey.csv").write_text(TUTORIAL_SURVEY_CSV, encoding="utf-8")
        with contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
            run_command(["survey", "survey.csv", "--cube", "cube.nc", "--figure", "survey.png"])
    return "\n".join(one if one.startswith("  ") else wrap_text(one) for one in printed.getvalue().splitlines()) + "\n"


def cubes_with_and_without_vertical_motion(**study_settings: Any) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the cubes of a study of the record wtmc with and without its vertical component, without ensembles."""
    study_settings |= {"ensemble": {"members": 0}, "verification": "none", "threads": 2}
    with_up, without = (
        overturning.run_study(["wtmc"], **study_settings, simulation={"vertical": vertical})
        for vertical in (True, False)
    )
    return with_up, without


def count_2d_falls_with_and_without_vertical_motion() -> Iterator[MeasuredNumber]:
    """Yield shares of 2-D blocks of config/waiau.yaml that fall under record wtmc, with and without vertical motion."""
    study = load_study(ROOT / "config" / "waiau.yaml")
    with_up, without = cubes_with_and_without_vertical_motion(
        azimuth=study.azimuth.model_dump(), b_over_h=list(study.b_over_h), height=list(study.height),
        friction=list(study.friction),
    )  # fmt: skip
    first, second = (cube["overturned"].to_numpy() for cube in (with_up, without))
    both = (first != 0) & (second != 0)
    yield MeasuredNumber("2-D: cases", first.size)
    yield MeasuredNumber(
        "2-D: falls with vertical motion only", percentage(((first != 0) & ~both).sum(), both.size), "%"
    )
    yield MeasuredNumber(
        "2-D: falls without vertical motion only", percentage(((second != 0) & ~both).sum(), both.size), "%"
    )
    yield MeasuredNumber("2-D: falls in both", percentage(both.sum(), both.size), "%")
    yield MeasuredNumber(
        "2-D: same side, of falls in both", percentage((both & (first == second)).sum(), both.sum()), "%"
    )
    for b_over_h in SHOWN_B_OVER_H:
        for setting, cube in (("with", with_up), ("without", without)):
            falls = cube["overturned"].sel(b_over_h=b_over_h, method="nearest") != 0
            share = percentage(falls.sum().item(), falls.size)
            yield MeasuredNumber(f"2-D: B/H {b_over_h:g}, falls {setting} vertical motion", share, "%")


def count_3d_falls_with_and_without_vertical_motion() -> Iterator[MeasuredNumber]:
    """Yield shares of 3-D stones that fall with and without vertical motion, and changes of their fall azimuths."""
    cubes = cubes_with_and_without_vertical_motion(**SETTINGS_OF_3D_STUDY)
    first, second = (cube["overturned"].to_numpy() == 1 for cube in cubes)
    both = first & second
    turned = angle_between_azimuths(*(cube["fall_azimuth"].to_numpy().astype(np.float64)[both] for cube in cubes))
    yield MeasuredNumber("3-D: stones", first.size)
    yield MeasuredNumber("3-D: falls with vertical motion", percentage(first.sum(), first.size), "%")
    yield MeasuredNumber("3-D: falls without vertical motion", percentage(second.sum(), first.size), "%")
    yield MeasuredNumber("3-D: another outcome", int((first != second).sum()))
    yield MeasuredNumber("3-D: falls in both", int(both.sum()))
    yield MeasuredNumber(
        "3-D: another direction", percentage((turned >= MIN_COUNTED_AZIMUTH_CHANGE_DEG).sum(), turned.size), "%"
    )
    yield MeasuredNumber("3-D: median change of direction", float(np.median(turned)), "degrees")


def main() -> None:
    """Write the measured numbers and the printed output of the tutorial, and fill them into its page."""
    write_measured_numbers(
        [*count_2d_falls_with_and_without_vertical_motion(), *count_3d_falls_with_and_without_vertical_motion()],
        RESULT_TABLE_FOLDER / "tutorial.csv",
    )
    write_text(RESULT_TABLE_FOLDER / "tutorial-survey.txt", output_of_tutorial_survey_command())
    update_marked_tables_and_sentences_in_docs({})


if __name__ == "__main__":
    main()
