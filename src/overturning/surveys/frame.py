"""Surveys of gravestones as pandas tables."""

import os
from typing import TYPE_CHECKING

from overturning.arrays import convert_argument_to_float_array
from overturning.files import convert_argument_to_path
from overturning.surveys.stones import SurveyTable, read_survey_table

if TYPE_CHECKING:
    import pandas as pd


def read_survey(path: "str | os.PathLike[str]", *, declination_deg: float | None = None) -> "pd.DataFrame":
    """Read a survey of gravestones from a text table; return one row per stone as a pandas table.

    The whole file is checked first; a table with a fault is not read. Columns, notations and outcomes are described in
    docs/formats.md.

    Parameters
    ----------
    path : str or path-like
        Table of text with a header; cells separated by commas, semicolons or tabs.
    declination_deg : float, optional
        Magnetic declination, degrees, east positive, that is added to all directions; only for a table without a
        column of declinations. By default directions of such a table are from true north.

    Returns
    -------
    pandas.DataFrame
        A row for each row of the file that is no comment, in order. Missing numbers are NaN, missing texts "".

        - ``site``, ``stone``, ``kind``, ``note``, ``photo``: texts of the file.
        - ``outcome``: what happened, such as "fell" or "shifted, twisted".
        - ``counted_as``: "fell", "stands" or "not counted" (broken, repaired, fixed or unknown).
        - ``azimuth_deg``: direction towards which the stone fell, degrees clockwise from true north, 0 to below 360.
        - ``azimuth_half_width_deg``: 22.5 for an octant, 11.25 for one of 16 compass points, 0 for degrees; NaN without
          direction.
        - ``count``: number of stones of the row.
        - ``b_over_h``, ``b_over_h_side``: width over height in the plane through the normal of the front face, and in
          the plane at right angles.
        - ``face_azimuth_deg``: azimuth of the front face, degrees clockwise from true north.
        - ``height_m``: height, m.
        - ``has_round_plan``: True for a column.
        - ``shift_m``: shift of the base, m.
        - ``twist_deg``: rotation about the vertical, degrees, clockwise seen from above positive.
        - ``lat``, ``lon``: decimal degrees, north and east positive; ``x``, ``y``: m, to the east and north.
        - ``line``: line of the file.

        The attributes ``attrs["notes"]`` and ``attrs["warnings"]`` are lists of notes on columns and stones that are
        not used, and of warnings, such as azimuths that look like radians.

    Raises
    ------
    RecordError
        If the file cannot be read or has a fault; the message lists all faults with line, column, value and remedy.

    Examples
    --------
    >>> stones = overturning.read_survey("stones.csv", declination_deg=-7.5)  # doctest: +SKIP
    >>> stones.groupby("site")["counted_as"].value_counts()  # doctest: +SKIP
    """
    declination = (
        None if declination_deg is None else float(convert_argument_to_float_array("declination_deg", declination_deg))
    )
    return survey_data_frame(read_survey_table(convert_argument_to_path("path", path), declination))


def survey_data_frame(survey_table: SurveyTable) -> "pd.DataFrame":
    """Convert a survey table to a pandas table with one row per stone or group of stones."""
    import pandas as pd

    rows = []
    for line, row in survey_table.rows:
        stone = survey_table.create_stone_from_row(line, row)
        directed = stone.fell_in_known_direction
        rows.append(
            {
                **{name: getattr(row, name) for name in ("site", "stone", "kind")},
                "outcome": ", ".join(row.stated_outcomes),
                "counted_as": row.counted_as,
                "azimuth_deg": stone.fall_azimuth_deg,
                "azimuth_half_width_deg": stone.direction_uncertainty_half_width_deg if directed else float("nan"),
                "count": stone.stone_count,
                "b_over_h": stone.b_over_h,
                "b_over_h_side": stone.b_over_h_side,
                "face_azimuth_deg": stone.face_azimuth_deg,
                "height_m": stone.height_m,
                "round": stone.has_round_plan,
                "shift_m": row.shift_m,
                "twist_deg": row.clockwise_twist_deg,
                **{name: getattr(row, name) for name in ("lat", "lon", "x", "y", "note", "photo")},
                "line": line,
            }
        )
    found = pd.DataFrame(rows)
    found.attrs = {"notes": list(survey_table.notes), "warnings": list(survey_table.warnings)}
    return found
