"""Read a survey of gravestones: a table with one row for each stone, or for a group of equal stones."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from overturning.errors import RecordError
from overturning.surveys.columns import (
    column_name_states_true_north,
    errors_if_fell_column_may_hold_counts,
    looks_like_header,
    recognise_columns,
)
from overturning.surveys.field_table import NumberedTableRow, TextTable, read_text_table
from overturning.surveys.notation import OCTANTS, UNKNOWN_VALUE_TEXTS, largest_usual_step_dividing_azimuths_deg
from overturning.surveys.notes import (
    AZIMUTH_COLUMNS,
    label_of_line_numbers,
    notes_on_unused_stones_and_directions,
    warnings_on_survey_table,
)
from overturning.surveys.row import SURVEY_COLUMNS, SurveyRow
from overturning.tables import cell_error_messages

__all__ = ["OCTANTS", "RANDOM_OUTCOME_SHARE", "SURVEY_COLUMNS", "Stone", "SurveyRow"]

MAX_FACTOR_OUTSIDE_SIMULATED_RANGE: Final = 1.25
"""Largest factor by which a size or ratio of a stone may lie outside the simulated range to take the nearest value."""

RANDOM_OUTCOME_SHARE = 0.05
"""Assumed share of stones with a random outcome (pushed by a neighbour, bad footing). Without it, a single stone in a
direction of probability zero would reject the model."""

_COLUMNS_ALLOWING_UNKNOWN = set(SURVEY_COLUMNS) - {"site", "stone", "kind", "outcome", "fell", "round", "note", "photo"}
"""Columns of numbers and directions, in which a cell may state that the value is not known."""

_UNIT_CELLS = ("m", "cm", "mm", "deg", "degrees", "°", "-", "–", "yes/no")
"""Texts of cells in a line of units below the header."""

_TOTALS_OR_MEANS_ROW_LABELS = ("total", "totals", "grand total", "subtotal", "sum", "mean", "average", "σ",
                      "計", "合計", "総計", "小計", "平均")  # fmt: skip
"""Names of a line of totals or means, in lower case."""

_OUTCOME_COLUMNS = {"azimuth_deg", "octant", "fell", "outcome"}
_MAX_DECLINATION_FOR_OCTANTS_DEG = 11.25
"""Largest magnetic declination of an octant, a quarter of its width."""


@dataclass(frozen=True)
class Stone:
    """Stone of a survey, or a group of equal stones, that fell or stands.

    Attributes
    ----------
    fell : bool
        True if the stone fell.
    fall_azimuth_deg : float
        Direction towards which it fell, degrees clockwise from true north; NaN where it stood, or fell in an unknown
        direction.
    has_octant_direction : bool
        The direction was given as a compass octant, so it is known to ±22.5°.
    stone_count : int
        Number of stones in this row.
    b_over_h : float
        Width over height in the plane through the normal of the face; NaN where not given.
    b_over_h_side : float
        Width over height in the perpendicular vertical plane; NaN where not given (a square footprint is assumed then).
    face_azimuth_deg : float
        Direction that the front face looks to, degrees clockwise from true north; NaN where not given.
    height_m : float
        m; NaN where not given.
    has_round_plan : bool
        A column, which can fall in any plane.
    line_number : int
        Line of the file.
    has_16_point_direction : bool
        The direction was given as one of 16 compass points, so it is known to ±11.25°.
    site, name : str
        Cemetery, and name of the stone; "" where not given.
    fall_azimuth_recording_step_deg : float
        Step in which the survey's directions in degrees are recorded, degrees; 0 if finer than whole degrees.
    """

    fell: bool
    fall_azimuth_deg: float
    has_octant_direction: bool
    stone_count: int = 1
    b_over_h: float = math.nan
    b_over_h_side: float = math.nan
    face_azimuth_deg: float = math.nan
    line_number: int = 0
    height_m: float = math.nan
    has_round_plan: bool = False
    has_16_point_direction: bool = False
    site: str = ""
    name: str = ""
    fall_azimuth_recording_step_deg: float = 0.0

    @property
    def fell_in_known_direction(self) -> bool:
        """True if the stone fell in a known direction."""
        return self.fell and math.isfinite(self.fall_azimuth_deg)

    @property
    def direction_uncertainty_half_width_deg(self) -> float:
        """Half-width, degrees, of the interval in which the fall direction lies: 22.5 for an octant, 0 for degrees."""
        return 22.5 if self.has_octant_direction else 11.25 if self.has_16_point_direction else 0.0

    @property
    def direction_recording_step_deg(self) -> float:
        """Step, degrees, in which the fall direction is recorded: 45 for an octant, 22.5 for a compass point (NNE)."""
        return 2.0 * self.direction_uncertainty_half_width_deg or self.fall_azimuth_recording_step_deg

    @property
    def b_over_h_in_both_planes(self) -> tuple[float, float]:
        """B/H in the vertical plane of the face normal, and in the perpendicular vertical plane.

        If only one of the two is known, the footprint is taken as square; NaN if neither is known.
        """
        front, side = self.b_over_h, self.b_over_h_side
        return (side if math.isnan(front) else front), (front if math.isnan(side) else side)

    @property
    def slender_plane_azimuth_deg(self) -> float:
        """Azimuth, degrees, of the vertical plane in which the stone's B/H is smaller; NaN if its face is unknown."""
        front, side = self.b_over_h_in_both_planes
        return self.face_azimuth_deg + (90.0 if side < front else 0.0)


@dataclass(frozen=True)
class SurveyTable:
    """All rows of a survey file, including stones that statistics do not count, with notes and warnings.

    Attributes
    ----------
    survey_file_name : str
        Name of the file.
    rows : tuple of (int, SurveyRow)
        Line of the file, and validated row, in order.
    notes, warnings, leading_comments : tuple of str
        Notes on columns and stones that are not used; warnings about units and repeated stones; comment lines at the
        start of the file.
    uses_only_eight_compass_points : bool
        True if the compass points in ``azimuth_deg`` are only N, NE, E, …, so that they are known to ±22.5°.
    fall_azimuth_recording_step_deg : float
        Step in which fall directions in degrees are recorded, see `largest_usual_step_dividing_azimuths_deg`.
    """

    survey_file_name: str
    rows: tuple[tuple[int, SurveyRow], ...]
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    leading_comments: tuple[str, ...] = ()
    uses_only_eight_compass_points: bool = False
    fall_azimuth_recording_step_deg: float = 0.0

    @property
    def fallen_and_standing_stones(self) -> list[Stone]:
        """Stones of the survey that count as fallen or standing, in the order of the rows."""
        return [self.create_stone_from_row(line, row) for line, row in self.rows if row.counted_as != "not counted"]

    @property
    def site_names(self) -> list[str]:
        """Names of the survey's sites, in order of first appearance; "" for stones without a site."""
        return list(dict.fromkeys(row.site for _, row in self.rows))

    def select_site(self, site_name: str) -> "SurveyTable":
        """Return a table with the rows of one site only."""
        return SurveyTable(
            self.survey_file_name, tuple((line, row) for line, row in self.rows if row.site == site_name),
            uses_only_eight_compass_points=self.uses_only_eight_compass_points,
            fall_azimuth_recording_step_deg=self.fall_azimuth_recording_step_deg,
        )  # fmt: skip

    def count_stones(self, condition: Callable[[SurveyRow], bool]) -> int:
        """Return the number of stones in the rows for which `condition` is True."""
        return sum(row.count for _, row in self.rows if condition(row))

    def create_stone_from_row(self, line_number: int, row: SurveyRow) -> Stone:
        """Convert the row in line `line_number` of the survey to a stone, with directions relative to true north.

        Azimuths are turned from magnetic to true north. A stone that stands has no fall direction.
        """
        fell, north = row.counted_as == "fell", row.magnetic_declination_deg
        azimuth, wind = row.fall_direction
        by_octant = row.octant is not None or (wind is not None and self.uses_only_eight_compass_points)
        return Stone(
            fell=fell, fall_azimuth_deg=_normalise_azimuth_deg(azimuth + north) if fell else math.nan,
            has_octant_direction=by_octant and fell, has_16_point_direction=wind is not None and not by_octant and fell,
            face_azimuth_deg=_normalise_azimuth_deg(row.face_azimuth_deg.azimuth_deg + north), line_number=line_number,
            height_m=row.height_m, site=row.site, name=row.stone,
            fall_azimuth_recording_step_deg=self.fall_azimuth_recording_step_deg, stone_count=row.count,
            b_over_h=row.b_over_h,
            b_over_h_side=row.b_over_h_side, has_round_plan=row.round,
        )  # fmt: skip


def _normalise_azimuth_deg(azimuth_deg: float) -> float:
    """Return an azimuth as the equivalent angle from 0 to below 360 degrees."""
    turned = azimuth_deg % 360.0
    return 0.0 if turned == 360.0 else turned  # the remainder of a tiny negative angle is rounded to 360


def read_survey_table(path: Path, declination_deg: float | None = None) -> SurveyTable:
    """Read all rows of a survey file, validated; unknown columns are not used, but listed in a note.

    Cells are separated by commas, semicolons or tabs; see `overturning.surveys.field_table.read_text_table` for
    encodings. ``magnetic_declination_deg`` (east positive) is added to the stone's directions.

    Parameters
    ----------
    path : Path
        The file.
    declination_deg : float, optional
        Magnetic declination, degrees, east positive, of all directions; only for a table without a column of
        declinations.

    Raises
    ------
    RecordError
        If the file cannot be read, has no stone, or a fault; the message lists all faults with line, column, value and
        remedy, and no stone is read.
    """
    table = read_text_table(path, "survey")
    plan = recognise_columns(table.header.cells, SURVEY_COLUMNS)
    of_numbers = errors_if_fell_column_may_hold_counts(
        table.header.cells, plan.standard_name_by_column, [line.cells for line in table.rows]
    )
    header_line = table.header.first_line_number
    faults = [(header_line, message) for message in (*plan.error_messages, *of_numbers)]
    above = table.leading_comments[-1].split(table.cell_separator) if table.leading_comments else []
    if (
        "" in plan.standard_name_by_column
        and len(above) == len(plan.standard_name_by_column)
        and looks_like_header(above, SURVEY_COLUMNS, _OUTCOME_COLUMNS)
    ):
        faults = [(header_line, "the line above it names the columns, but is a comment; remove its #")]
    missing = not _OUTCOME_COLUMNS & set(plan.standard_name_by_column)
    if missing:
        faults.append((header_line, _missing_outcome_column_message(table)))
    if declination_deg is not None:
        if "magnetic_declination_deg" in plan.standard_name_by_column:
            faults.append((header_line, "a column gives the declination; leave out the option declination"))
        elif not abs(declination_deg) <= 180:
            raise RecordError(f"declination {declination_deg:g}: give degrees from -180 to 180, east positive")
    if declination_deg or "magnetic_declination_deg" in plan.standard_name_by_column:
        faults += [
            (header_line, message)
            for message in _errors_on_true_north_columns_with_declination(table, plan.standard_name_by_column)
        ]
    rows = list[tuple[int, SurveyRow]]()
    for line in table.rows:
        row, messages = _validate_row(
            line, plan.standard_name_by_column, table, declination_deg, lacks_outcome_column=missing
        )
        faults += [(line.first_line_number, message) for message in messages]
        rows += [(line.first_line_number, row)] if row is not None else []
    winds = {row.fall_direction.index_in_16_compass_points for _, row in rows} - {None}
    octants = bool(winds) and all(wind is not None and wind % 2 == 0 for wind in winds)
    step = largest_usual_step_dividing_azimuths_deg(
        [row.fall_direction.azimuth_deg for _, row in rows if row.fall_direction.index_in_16_compass_points is None]
    )
    faults += list(_errors_of_octants_ambiguous_by_declination(rows, uses_only_eight_compass_points=octants))
    if not table.rows and not faults:
        raise RecordError(f"{path}: no stone; write one row per stone below the header")
    if faults:
        raise RecordError(_format_row_errors(path, faults))
    notes = [f"{path.name}: {note}" for note in (*plan.notes, *notes_on_unused_stones_and_directions(rows))]
    return SurveyTable(
        path.name, tuple(rows), tuple(notes),
        tuple(warnings_on_survey_table(path.name, rows, table, plan.standard_name_by_column, declination_deg)),
        table.leading_comments,
        octants, step,
    )  # fmt: skip


def _missing_outcome_column_message(text_table: TextTable) -> str:
    """Return the error message for a survey header in which no column states the outcomes of the stones."""
    filled = [cell for cell in text_table.header.cells if cell]
    spaces = "; columns are separated by spaces: use commas, semicolons or tabs" if "  " in filled[0] else ""
    title = f"; a line above the names of the columns must begin with #: {filled[0]!r}" if len(filled) == 1 else ""
    listed = "" if title or spaces else f"; it has {', '.join(filled[:12])}"
    return f"no column azimuth_deg or octant, fell or outcome; name one of them in the header{spaces or title}{listed}"


def _errors_on_true_north_columns_with_declination(
    text_table: TextTable, standard_name_of_each_column: list[str]
) -> Iterator[str]:
    """Yield an error message for each column of azimuths from true north in a table that has a declination."""
    at = [place for place, meaning in enumerate(standard_name_of_each_column) if meaning == "magnetic_declination_deg"]
    cells = [row.cells[place] for row in text_table.rows for place in at if place < len(row.cells)]
    if at and all(not cell.strip("+-0.,°º˚") or cell.lower() in UNKNOWN_VALUE_TEXTS for cell in cells):
        return
    for name, meaning in zip(text_table.header.cells, standard_name_of_each_column, strict=True):
        if meaning in AZIMUTH_COLUMNS and column_name_states_true_north(name):
            yield (
                f"column {name!r} names true north, but a declination is given, which is added to all azimuths; leave "
                "out the declination, or rename the column"
            )


def _validate_row(
    numbered_row: NumberedTableRow,
    standard_name_by_column: list[str],
    table: TextTable,
    declination_deg: float | None,
    *,
    lacks_outcome_column: bool,
) -> tuple[SurveyRow | None, list[str]]:
    """Validate one row of a survey table; return the row (None if invalid) and error messages."""
    cells = numbered_row.cells
    # In a table of commas, an empty cell too many may come from a decimal comma: 120,5 reads as 120 and 5.
    while len(cells) > len(standard_name_by_column) and not cells[-1] and table.cell_separator != ",":
        cells = cells[:-1]
    if len(cells) > len(standard_name_by_column) or (
        len(cells) < len(standard_name_by_column) and table.cell_separator != "\t"
    ):
        comma = table.cell_separator == "," and len(cells) > len(standard_name_by_column)
        hint = "; with decimal commas, separate cells by semicolons, and end no line with a comma" if comma else ""
        return None, [
            f"{len(cells)} cells, the header names {len(standard_name_by_column)} columns; "
            f"separate cells by {table.plural_separator_name}{hint}"
        ]
    filled = [cell for cell in cells if cell]
    if len(filled) > 1 and all(cell.strip("[]()").lower() in _UNIT_CELLS for cell in filled):
        return None, ["a line of units; begin it with #"]
    if totals := [
        cell
        for meaning, cell in zip(standard_name_by_column, cells, strict=False)
        if _is_label_of_totals_or_means_row(meaning, cell)
    ]:
        return None, [f"{totals[0]!r} names a line of totals, which are no stones; remove the line, or begin it with #"]
    values = {
        meaning: cell
        for meaning, cell in zip(standard_name_by_column, cells, strict=False)
        if meaning and cell and not (meaning in _COLUMNS_ALLOWING_UNKNOWN and cell.lower() in UNKNOWN_VALUE_TEXTS)
    }
    if declination_deg is not None:
        values["magnetic_declination_deg"] = str(declination_deg)
    return SurveyRow.validate_cells(values, cell_error_messages, requires_outcome=not lacks_outcome_column)


def _is_label_of_totals_or_means_row(standard_column_name: str, cell_text: str) -> bool:
    """True if a cell in the column of sites or stones marks a row of totals or means, not a stone."""
    return standard_column_name in ("site", "stone") and cell_text.strip(" :").lower() in _TOTALS_OR_MEANS_ROW_LABELS


def _errors_of_octants_ambiguous_by_declination(
    line_numbers_and_survey_rows: list[tuple[int, SurveyRow]], *, uses_only_eight_compass_points: bool
) -> Iterator[tuple[int, str]]:
    """Yield line number and error message for each octant that a large declination makes ambiguous."""
    for line, row in line_numbers_and_survey_rows:
        by_compass_point = row.fall_direction.index_in_16_compass_points is not None
        by_octant = row.octant is not None or (by_compass_point and uses_only_eight_compass_points)
        if by_octant and abs(row.magnetic_declination_deg) > _MAX_DECLINATION_FOR_OCTANTS_DEG:
            yield (
                line,
                f"one of 8 compass points from magnetic north, {row.magnetic_declination_deg:g}° from true north, "
                "lies across "
                "two octants; give degrees, or the compass point from true north and no declination",
            )


def _format_row_errors(path: Path, line_numbers_and_error_messages: list[tuple[int, str]]) -> str:
    """Return one message for all errors in the rows of a survey table; lines with equal errors are listed together."""
    lines_of: dict[str, list[int]] = {}
    for line, message in sorted(line_numbers_and_error_messages, key=lambda one: one[0]):
        lines_of.setdefault(message, []).append(line)
    if len(lines_of) == 1:
        message, lines = next(iter(lines_of.items()))
        return f"{path} {label_of_line_numbers(lines)}: {message}"
    texts = [f"  {label_of_line_numbers(lines)}: {message}" for message, lines in lines_of.items()]
    return "\n".join([f"{path}: {len(lines_of)} faults, so no stone was read", *texts])
