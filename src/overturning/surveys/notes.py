"""Notes and warnings on a survey table: stones that do not count, doubtful units, repeated stones, and comments."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from overturning.surveys.columns import column_name_states_magnetic_north
from overturning.surveys.field_table import TextTable
from overturning.surveys.notation import OUTCOME_KINDS_NOT_COUNTED_AS_STANDING, StatedDirection, azimuth_unit_warning
from overturning.surveys.row import SurveyRow

AZIMUTH_COLUMNS: Final = ("azimuth_deg", "face_azimuth_deg")
"""Columns of directions that may be measured from magnetic or true north."""

_MAX_PLAUSIBLE_HEIGHT_M: Final = 10.0
"""Height above which a surveyed stone is doubtful, m."""

_MAX_PLAUSIBLE_B_OVER_H: Final = 2.0
"""B/H above which a surveyed stone is doubtful: hardly any motion overturns a stone as wide."""


def label_of_line_numbers(line_numbers: list[int]) -> str:
    """Return a label such as "line 3" or "lines 3, 5"; at most 12 lines are named."""
    unique = list(dict.fromkeys(line_numbers))
    more = f" and {len(unique) - 12} more" if len(unique) > 12 else ""
    return f"line{'s' * (len(unique) > 1)} {', '.join(map(str, unique[:12]))}{more}"


def notes_on_unused_stones_and_directions(
    line_numbers_and_survey_rows: Sequence[tuple[int, SurveyRow]],
) -> Iterator[str]:
    """Yield notes on surveyed stones that statistics do not count, and on fall directions of standing stones."""
    reasons = Counter[str]()
    for _, row in line_numbers_and_survey_rows:
        if row.counted_as == "not counted":
            reasons[next(kind for kind in OUTCOME_KINDS_NOT_COUNTED_AS_STANDING if kind in row.stated_outcomes)] += (
                row.count
            )
    if reasons:
        listed = ", ".join(f"{number} {reason}" for reason, number in reasons.items())
        yield f"not counted as fallen or standing: {reasons.total()} (outcomes: {listed})"
    moved = [
        line
        for line, row in line_numbers_and_survey_rows
        if "fell" not in row.stated_outcomes and math.isfinite(row.fall_direction.azimuth_deg)
    ]
    if moved:
        yield f"the direction of a stone that did not fall is not used: {label_of_line_numbers(moved)}"


def warnings_on_survey_table(
    survey_file_name: str,
    line_numbers_and_survey_rows: Sequence[tuple[int, SurveyRow]],
    text_table: TextTable,
    standard_name_of_each_column: list[str],
    declination_deg: float | None,
) -> Iterator[str]:
    """Yield warnings about azimuths in a doubtful unit or from magnetic north, repeated stones, and comment lines."""
    columns: dict[str, Callable[[SurveyRow], StatedDirection]] = {
        "azimuth_deg": lambda row: row.azimuth_deg,
        "face_azimuth_deg": lambda row: row.face_azimuth_deg,
    }
    for column, direction in columns.items():
        values = [
            one.azimuth_deg
            for _, row in line_numbers_and_survey_rows
            if (one := direction(row)).index_in_16_compass_points is None
        ]
        if warning := azimuth_unit_warning(column, values, survey_file_name):
            yield warning
    columns_read = zip(text_table.header.cells, standard_name_of_each_column, strict=True)
    magnetic = [
        (title, meaning)
        for title, meaning in columns_read
        if meaning in AZIMUTH_COLUMNS and column_name_states_magnetic_north(title)
    ]
    for title, meaning in magnetic[: declination_deg is None]:
        lines = [
            line
            for line, row in line_numbers_and_survey_rows
            if "magnetic_declination_deg" not in row.model_fields_set and meaning in row.model_fields_set
        ]
        if lines:
            where = "" if len(lines) == len(line_numbers_and_survey_rows) else f" in {label_of_line_numbers(lines)}"
            yield (
                f"{survey_file_name}: column {title!r} names magnetic north, but no declination is given{where}; its "
                "azimuths are used as if from true north: add a column declination (degrees, east positive); "
                "overturning survey also has the option --declination"
            )
    yield from _warnings_on_implausible_stone_sizes(survey_file_name, line_numbers_and_survey_rows)
    if text_table.line_numbers_of_rows_with_pasted_row_in_cell:
        lines_label = label_of_line_numbers(list(text_table.line_numbers_of_rows_with_pasted_row_in_cell))
        yield (
            f"{survey_file_name}: {lines_label}: a cell in quotation marks contains "
            "whole rows of the table; if a quotation mark is there by mistake, remove it"
        )
    if text_table.line_numbers_of_row_like_comments:
        yield (
            f"{survey_file_name}: {label_of_line_numbers(list(text_table.line_numbers_of_row_like_comments))}: "
            "not used, because # marks a comment, but with the cells of a row; if # begins the name of a stone, write "
            "the name without #"
        )
    lines_of: dict[tuple[str, str], list[int]] = {}
    for line, row in line_numbers_and_survey_rows:
        if row.stone and row.count == 1:
            lines_of.setdefault((row.site, row.stone), []).append(line)
    for (_, stone), lines in lines_of.items():
        if len(lines) > 1:
            where = label_of_line_numbers(lines)
            yield f"{survey_file_name}: stone {stone!r} is listed {len(lines)} times, and counts each time: {where}"


def _warnings_on_implausible_stone_sizes(
    survey_file_name: str, line_numbers_and_survey_rows: Sequence[tuple[int, SurveyRow]]
) -> Iterator[str]:
    """Yield warnings about stone heights that may be in centimetres, and B/H that may be H/B."""
    if high := {
        line: row.height_m for line, row in line_numbers_and_survey_rows if row.height_m > _MAX_PLAUSIBLE_HEIGHT_M
    }:
        largest = max(high.values())
        where = label_of_line_numbers(list(high))
        yield f"{survey_file_name}: {where}: a height up to {largest:g} m: in centimetres? Heights are in m"
    for column in ("b_over_h", "b_over_h_side"):
        if wide := [
            line for line, row in line_numbers_and_survey_rows if getattr(row, column) > _MAX_PLAUSIBLE_B_OVER_H
        ]:
            yield (
                f"{survey_file_name}: {label_of_line_numbers(wide)}: {column} above {_MAX_PLAUSIBLE_B_OVER_H:g}, of a "
                "stone much wider than high: height over width? Give width over height"
            )
