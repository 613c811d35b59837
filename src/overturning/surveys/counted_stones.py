"""Stones of a survey that count as fallen or standing."""

from collections.abc import Sequence
from pathlib import Path

from overturning.errors import RecordError
from overturning.surveys.stones import Stone, SurveyTable, read_survey_table


def stones_of_sites_with_standing_stones(stones: Sequence[Stone]) -> list[Stone]:
    """Return the stones of the survey sites that list at least one standing stone.

    Other sites are left out: they may list only their fallen stones, so that the share that fell is not known.
    """
    sites = {stone.site for stone in stones if not stone.fell}
    return [stone for stone in stones if stone.site in sites]


def fallen_and_all_stone_counts(stones: Sequence[Stone]) -> tuple[int, int]:
    """Return the number of stones that fell, and the number of all stones."""
    return sum(stone.stone_count for stone in stones if stone.fell), sum(stone.stone_count for stone in stones)


def read_counted_stones(path: Path) -> list[Stone]:
    """Read from a survey file the stones that statistics count as fallen or standing, in the file's order.

    See `read_survey_table`.
    """
    return read_fallen_and_standing_stones_notes_and_warnings(path)[0]


def read_fallen_and_standing_stones_notes_and_warnings(path: Path) -> tuple[list[Stone], list[str], list[str]]:
    """Read a survey file; return the stones that count as fallen or standing, notes, and warnings about units.

    See `read_survey_table`; a RecordError is also raised if no stone counts as fallen or standing.
    """
    table = read_survey_table(path)
    check_survey_has_counted_stone(table, path)
    return table.fallen_and_standing_stones, list(table.notes), list(table.warnings)


def check_survey_has_counted_stone(survey_table: SurveyTable, path: Path) -> None:
    """Raise a `RecordError` if no stone of a survey counts as fallen or standing; `path` is the file of the survey."""
    if not survey_table.fallen_and_standing_stones:
        raise RecordError(f"{path}: no stone counts as fallen or standing; all are broken, repaired, fixed or unknown")
