"""Read a survey of fallen gravestones: a table with one row for each stone, or for a group of equal stones."""

import difflib
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

from pydantic import AfterValidator, BaseModel, BeforeValidator, Field, model_validator

from overturning.errors import RecordError
from overturning.model.cases import checked_stone_height
from overturning.tables import read_table_rows

OCTANTS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
"""Compass octants in their order; octant i is centred on 45° i."""

BACKGROUND = 0.05
"""Assumed share of stones with a random outcome (pushed by a neighbour, bad footing). Without it, a single stone in a
direction of probability zero would reject the model."""

_YES, _NO = {"yes", "fell", "true", "1", "y"}, {"no", "stood", "false", "0", "n"}


@dataclass(frozen=True)
class Stone:
    """Stone of a survey, or a group of equal stones: one row of the survey table, as observed.

    Attributes
    ----------
    fell : bool
        True if the stone fell.
    azimuth_deg : float
        Direction towards which it fell, degrees clockwise from true north; NaN where it stood, or fell in an unknown
        direction.
    octant : bool
        The direction was given as a compass octant, so it is known to ±22.5°.
    count : int
        Stones in this row.
    b_over_h : float
        Width over height in the plane through the normal of the face; NaN where not given.
    b_over_h_side : float
        The same in the plane at right angles; NaN where not given (a square footprint is assumed then).
    face_azimuth_deg : float
        Direction that the front face looks to, degrees clockwise from true north; NaN where not given.
    height : float
        m; NaN where not given.
    round : bool
        A column, which can fall in any plane.
    line : int
        Line of the file.
    """

    fell: bool
    azimuth_deg: float
    octant: bool
    count: int = 1
    b_over_h: float = math.nan
    b_over_h_side: float = math.nan
    face_azimuth_deg: float = math.nan
    line: int = 0
    height: float = math.nan
    round: bool = False

    @property
    def fell_in_known_direction(self) -> bool:
        """True if the stone fell in a known direction."""
        return self.fell and math.isfinite(self.azimuth_deg)

    @property
    def slenderness_in_both_planes(self) -> tuple[float, float]:
        """B/H in the plane of the face normal, and in the plane across; NaN if both are unknown.

        If only one is given, the footprint is taken as square.
        """
        front, side = self.b_over_h, self.b_over_h_side
        return (side if math.isnan(front) else front), (front if math.isnan(side) else side)

    @property
    def slender_face_azimuth_deg(self) -> float:
        """Azimuth of the face normal, degrees, in whose plane B/H is smaller; NaN without a face."""
        front, side = self.slenderness_in_both_planes
        return self.face_azimuth_deg + (90.0 if side < front else 0.0)


def _parse_yes_or_no(text: str) -> bool:
    """Convert the text of a table cell to True for "yes", False for "no", or synonyms of these."""
    if text.lower() not in _YES | _NO:
        raise ValueError("write yes or no")
    return text.lower() in _YES


def _parse_octant_index(text: str) -> int:
    """Convert the name of a compass octant to its index, clockwise from 0 for north."""
    if text.upper() not in OCTANTS:
        raise ValueError(f"use one of {' '.join(OCTANTS)}")
    return OCTANTS.index(text.upper())


def _refuse_azimuth_in_gon(azimuth_text: str | float) -> str | float:
    """Return `azimuth_text` unchanged; a ValueError is raised for a number that is probably in gon."""
    try:
        azimuth = float(azimuth_text)
    except ValueError:
        return azimuth_text  # the field refuses it
    if 360 < azimuth <= 400:
        raise ValueError("give degrees from -360 to 360; an azimuth in gon (400 to a turn) times 0.9")
    return azimuth_text


_Degrees = Annotated[float, BeforeValidator(_refuse_azimuth_in_gon), Field(ge=-360, le=360)]
_Slenderness = Annotated[float, Field(ge=0.01, le=5)]


class SurveyRow(BaseModel):
    """Validated row of a survey table; the fields are its columns."""

    fell: Annotated[bool | None, BeforeValidator(_parse_yes_or_no)] = None
    azimuth_deg: _Degrees = math.nan
    octant: Annotated[int | None, BeforeValidator(_parse_octant_index)] = None
    count: Annotated[int, Field(ge=1, le=1_000_000)] = 1
    b_over_h: _Slenderness = math.nan
    b_over_h_side: _Slenderness = math.nan
    face_azimuth_deg: _Degrees = math.nan
    magnetic_declination_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0
    height_m: Annotated[float, AfterValidator(checked_stone_height)] = math.nan
    round: Annotated[bool, BeforeValidator(_parse_yes_or_no)] = False

    @model_validator(mode="after")
    def _check_direction_of_fall(self) -> "SurveyRow":
        exact, octant = math.isfinite(self.azimuth_deg), self.octant is not None
        if exact and self.octant is not None:
            named = f"azimuth_deg {self.azimuth_deg:g} and octant {OCTANTS[self.octant]}"
            raise ValueError(f"{named}: give azimuth_deg or octant, not both")
        if octant and abs(self.magnetic_declination_deg) > 11.25:  # a quarter of its width
            raise ValueError(
                f"octant: one from magnetic north, {self.magnetic_declination_deg:g}° from true north, lies across "
                "two octants; give azimuth_deg, or the octant from true north and no magnetic_declination_deg"
            )
        if self.fell is None and not (exact or octant):
            raise ValueError(
                "fell: empty, and no direction; write no for a stone that stood, yes for one that fell in an unknown "
                "direction"
            )
        if self.fell is False and (exact or octant):
            raise ValueError("fell: a stone that stood has no fall direction; empty azimuth_deg and octant")
        return self

    def to_stone(self, line_number: int) -> Stone:
        """Convert this row, from line `line_number` of the file, to a stone.

        Azimuths are turned from magnetic to true north.
        """
        azimuth, north = self.azimuth_deg if self.octant is None else 45.0 * self.octant, self.magnetic_declination_deg
        return Stone(
            fell=self.fell is not False,
            azimuth_deg=(azimuth + north) % 360,
            octant=self.octant is not None,
            face_azimuth_deg=(self.face_azimuth_deg + north) % 360,
            line=line_number,
            height=self.height_m,
            **{name: getattr(self, name) for name in ("count", "b_over_h", "b_over_h_side", "round")},
        )


COLUMNS = tuple(SurveyRow.model_fields)
"""Columns a survey may have; ``azimuth_deg``, ``octant`` or, of stones that all stood, ``fell`` is needed."""


_SYNONYMS: Final = {
    **dict.fromkeys(("az", "azi", "direction", "bearing", "heading", "trend"), "azimuth_deg"),
    **dict.fromkeys(("azm", "azimut", "dir", "fall_direction", "direction_of_fall", "fall_dir"), "azimuth_deg"),
    **dict.fromkeys(("fall_azimuth", "azimuth_of_fall", "fall_bearing", "fall_az"), "azimuth_deg"),
    **dict.fromkeys(("b/h", "bh", "b_h", "slenderness", "aspect"), "b_over_h"),
    **dict.fromkeys(("h", "height"), "height_m"),
    **dict.fromkeys(("fallen", "overturned", "toppled", "outcome", "state", "status", "fall"), "fell"),
    **dict.fromkeys(("face", "facing", "face_azimuth"), "face_azimuth_deg"),
    **dict.fromkeys(("declination", "magnetic_declination"), "magnetic_declination_deg"),
    **dict.fromkeys(("column", "cylinder", "shape"), "round"),
}
"""Names that people give to columns of a survey, each with the name of the column."""

_SHORT: Final = 5
"""Largest number of letters of a short column name; short names resemble many other words."""

_LEAST: Final = 3
"""Smallest number of different azimuths for which a warning about their unit is given."""

_NEAR: Final = 0.75
"""Smallest similarity (of `difflib`) of a misspelt column name and the known name."""


def _is_misspelling(column_name: str, known_column: str) -> bool:
    """True if `column_name` is a misspelling of the short column name `known_column`.

    Letters may be swapped, omitted or doubled, or an s added.

    Words of their own are as near: county, country, ground.
    """
    swapped = sorted(column_name) == sorted(known_column)
    lacks_one = any(column_name == known_column[:at] + known_column[at + 1 :] for at in range(len(known_column)))
    doubled = any(column_name == known_column[: at + 1] + known_column[at:] for at in range(len(known_column)))
    return swapped or lacks_one or doubled or column_name in (f"{known_column}s", f"{known_column}ed")


def _intended_column_name(column_name: str) -> str:
    """Return the known column name that `column_name` probably means; "" if it resembles none."""
    plain = re.sub(r"[\s-]+", "_", re.sub(r"[(\[].*?[)\]]|°", "", column_name).strip()).strip("_?.")
    long = [one for one in (*COLUMNS, *_SYNONYMS) if len(one) > _SHORT]
    near = [one for one in COLUMNS if len(one) <= _SHORT and _is_misspelling(plain, one)]
    near = near or difflib.get_close_matches(plain, long, 1, _NEAR)
    found = _SYNONYMS.get(plain) or (near[0] if near else "")
    return _SYNONYMS.get(found, found)


def azimuth_unit_warnings(survey_rows: Sequence[SurveyRow], file_name: str) -> list[str]:
    """Return a warning for each azimuth column of a survey that may be in radians or gon, with `file_name`.

    Azimuths in radians lie within ±2π and are no whole numbers. Azimuths in gon cannot be recognised unless they lie
    above 360, which `SurveyRow` refuses, or are the half and full quarters of 400.
    """
    doubts = []
    for column in ("azimuth_deg", "face_azimuth_deg"):
        values = [getattr(one, column) for one in survey_rows if math.isfinite(getattr(one, column))]
        different = set(values)
        largest = max(map(abs, values), default=0.0)
        if len(different) >= _LEAST and largest <= 2 * math.pi and any(one % 1 for one in values):
            doubts.append(
                f"{file_name}: column {column}: {len(values)} values, none beyond {largest:g}°: radians? Multiply by "
                "57.29578"
            )
        elif len(different) >= _LEAST and all(one % 50 == 0 for one in values) and any(one % 90 for one in values):
            doubts.append(
                f"{file_name}: column {column}: {len(values)} values, all multiples of 50°: gon (400 to a turn)? "
                "Multiply by 0.9"
            )
    return doubts


def read_survey(path: Path) -> list[Stone]:
    """Read the stones of a survey file, in the order of its rows; notes and warnings are dropped.

    See `read_survey_with_notes`.
    """
    return read_survey_with_notes(path)[0]


def read_survey_with_notes(path: Path) -> tuple[list[Stone], list[str], list[str]]:
    """Read a survey file: return its stones in order, notes on unused columns, and warnings about units.

    A CSV with a header, UTF-8 with or without byte order mark; columns as `COLUMNS`. ``magnetic_declination_deg`` (east
    positive) is added to the stone's directions, so leave it empty where they were taken from true north. Lines that
    begin with ``#`` are comments. Columns of other names are not used, and named in a note.

    Raises
    ------
    RecordError
        If the file cannot be read, has no stone, a misspelt column or a wrong cell; names file, line, column.
    """
    one_of, others = ("azimuth_deg", "octant", "fell"), list[str]()

    def reason_to_refuse_column(column_name: str) -> str:
        """Return why an unknown column is refused; "" if the column is only ignored."""
        if meant := _intended_column_name(column_name):
            return f"did you mean {meant}? A column for something else needs a name that is less like it"
        others.append(column_name or "without a name")
        return ""

    rows = read_table_rows(
        path,
        SurveyRow,
        delimiter=",",
        error_class=RecordError,
        table_kind="survey",
        required_alternatives=one_of,
        unknown_column_message=reason_to_refuse_column,
    )
    found = list(rows)
    if not found:
        raise RecordError(f"{path}: no stone; write one row per stone below the header")
    notes = [f"{path.name}: not used: column{'s' * (len(others) > 1)} {', '.join(others)}"] if others else []
    return (
        [row.to_stone(line) for line, row in found],
        notes,
        azimuth_unit_warnings([row for _, row in found], path.name),
    )
