"""An illustrative case with its film and figures, as stored in ``cases.json``."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from overturning.stored import read_json_result, write_result_as_json

CASES_FILE_NAME: Final = "cases.json"
"""File of the cases, next to their figures."""


@dataclass(frozen=True)
class IllustrativeCaseWithFigures:
    """Case that illustrates the results of a study, with the data of its film and the file names of its figures.

    Attributes
    ----------
    title, selection_rule : str
        Title of the case, and the rule that chose it.
    block_and_motion_description, block_parameters_text, record : str
        The block and its motion in words; B/H, H (m) and µ of the block as text; and the id of the record.
    variant_name_by_panel, panel_headings, panel_outcomes : tuple of str
        Variant, heading and outcome of each panel of the film.
    film : dict
        Data for the film player in the browser; see `overturning.figures.film.Film.player_data`.
    film_strip_file_name, strip_alt : str
        File of the strip of four frames that stands for the film on paper, and its alternative text.
    keyboard_help : str
        Help on the player's keys that work only in 2-D films, or only in 3-D films.
    figure_texts_and_options_by_file : dict
        Alternative text and options of each figure, by file name.
    """

    title: str
    selection_rule: str
    block_and_motion_description: str
    block_parameters_text: str
    record: str
    variant_name_by_panel: tuple[str, ...]
    panel_headings: tuple[str, ...]
    panel_outcomes: tuple[str, ...]
    film: dict[str, Any]
    film_strip_file_name: str
    strip_alt: str
    keyboard_help: str
    figure_texts_and_options_by_file: dict[str, dict[str, Any]]


def write_illustrative_case_list(drawn_cases: list[IllustrativeCaseWithFigures], folder: Path) -> None:
    """Write ``cases.json``: the illustrative cases of a study, with data of films and file names of figures."""
    write_result_as_json(drawn_cases, folder / CASES_FILE_NAME, indent=None)


def read_illustrative_case_list(folder: Path) -> list[IllustrativeCaseWithFigures]:
    """Read the illustrative cases of a study from ``cases.json`` in a folder; a `ResultError` if it is missing."""
    return read_json_result(list[IllustrativeCaseWithFigures], folder / CASES_FILE_NAME, "illustrative cases")
