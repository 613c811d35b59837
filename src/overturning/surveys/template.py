"""Template of a survey table, with a comment on each column."""

import textwrap
from collections.abc import Sequence
from typing import Final

from overturning.surveys.row import SurveyRow

TEMPLATE_COLUMNS: Final = (
    "site", "stone", "kind", "outcome", "azimuth_deg", "declination", "face_azimuth_deg", "height_m", "b_over_h",
    "b_over_h_side", "lat", "lon", "note", "photo",
)  # fmt: skip
"""Columns of the template; the others are described in its comments."""

_EXAMPLE_ROWS: Final = (
    "Temple A,A1,three-tier grave,fell,S40E,-7.5,120,0.6,0.35,,35.3812,133.3427,,IMG_0012.jpg",
    "Temple A,A2,three-tier grave,fell direction unknown,,,120,0.6,0.35,,,,moved before the survey,",
    'Temple A,A3,lantern,"shifted 3 cm, twisted -10",,,120,1.4,0.3,,,,,',
)


def survey_table_template_text() -> str:
    """Return the text of an empty survey table: explanations of the columns, example rows, and the header.

    The text is ASCII, so that spreadsheets of any system show it unchanged.
    """
    lines = [
        "Survey of gravestones: one row for each stone, or for a group of equal stones (count).",
        "Lines that begin with # are comments. Delete columns that you do not need, or add your own.",
        "Separate cells by commas, semicolons or tabs; with decimal commas, by semicolons or tabs.",
        "Save the table as CSV UTF-8. An empty cell is not known.",
        "",
    ]
    for column, field in SurveyRow.model_fields.items():
        name = "declination" if column == "magnetic_declination_deg" else column
        description = str(field.description).replace(" (also named `declination`)", "")
        text = f"{name}: {description}".replace("`", "").replace("11.25°", "11.25 degrees")
        lines += textwrap.wrap(text, 98, subsequent_indent="    ")
    lines += ["", "Examples:", *_EXAMPLE_ROWS]
    comments = "".join(f"# {line}".rstrip() + "\n" for line in lines)
    return f"{comments}{','.join(TEMPLATE_COLUMNS)}\n"


def remarks_without_template_text(survey_comment_lines: Sequence[str]) -> tuple[str, ...]:
    """Return the comment lines that the user wrote into a survey, without those of the template."""
    own = {line.strip("# ,") for line in survey_table_template_text().splitlines()}
    return tuple(line for line in survey_comment_lines if line and line.strip(" ,") not in own)
