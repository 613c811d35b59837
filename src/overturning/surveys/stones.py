"""A survey of fallen gravestones as somebody wrote it down: one row per stone, or per group of like stones."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BaseModel, BeforeValidator, Field, model_validator

from overturning.errors import RecordError
from overturning.model.cases import checked_height
from overturning.tables import read_rows

OCTANTS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
"""Compass octants in their order; octant i is centred on 45° i."""

BACKGROUND = 0.05
"""Share of stones taken to fall any way (pushed by a neighbour, on a bad footing): without it a single stone in a
direction of probability zero would rule the model out for ever."""

_YES, _NO = {"yes", "fell", "true", "1", "y"}, {"no", "stood", "false", "0", "n"}


@dataclass(frozen=True)
class Stone:
    """One row of a survey.

    Attributes
    ----------
    fell : bool
        Whether it fell.
    azimuth_deg : float
        Direction towards which it fell, degrees clockwise from true north; NaN where it stood.
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
    def slenderness(self) -> tuple[float, float]:
        """B/H in the plane of the face's normal and at right angles; where one is not given the footprint is square."""
        front, side = self.b_over_h, self.b_over_h_side
        return (side if math.isnan(front) else front), (front if math.isnan(side) else side)

    @property
    def narrow_face_deg(self) -> float:
        """Azimuth of the face across the smaller B/H, degrees; NaN where no face is given."""
        front, side = self.slenderness
        return self.face_azimuth_deg + (90.0 if side < front else 0.0)


def _yes_or_no(text: str) -> bool:
    if text.lower() not in _YES | _NO:
        raise ValueError("write yes or no")
    return text.lower() in _YES


def _octant_number(text: str) -> int:
    if text.upper() not in OCTANTS:
        raise ValueError(f"use one of {' '.join(OCTANTS)}")
    return OCTANTS.index(text.upper())


_Degrees = Annotated[float, Field(ge=-360, le=360)]
_Slenderness = Annotated[float, Field(ge=0.01, le=5)]


class SurveyRow(BaseModel):
    """One line of a survey: its columns."""

    fell: Annotated[bool | None, BeforeValidator(_yes_or_no)] = None
    azimuth_deg: _Degrees = math.nan
    octant: Annotated[int | None, BeforeValidator(_octant_number)] = None
    count: Annotated[int, Field(ge=1, le=1_000_000)] = 1
    b_over_h: _Slenderness = math.nan
    b_over_h_side: _Slenderness = math.nan
    face_azimuth_deg: _Degrees = math.nan
    magnetic_declination_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0
    height_m: Annotated[float, AfterValidator(checked_height)] = math.nan
    round: Annotated[bool, BeforeValidator(_yes_or_no)] = False

    @model_validator(mode="after")
    def _one_direction_if_it_fell(self) -> "SurveyRow":
        exact, octant = math.isfinite(self.azimuth_deg), self.octant is not None
        if exact and self.octant is not None:
            named = f"azimuth_deg {self.azimuth_deg:g} and octant {OCTANTS[self.octant]}"
            raise ValueError(f"{named}: give azimuth_deg or octant, not both")
        if octant and abs(self.magnetic_declination_deg) > 11.25:  # a quarter of its width
            raise ValueError(
                f"octant: one from magnetic north, {self.magnetic_declination_deg:g}° from true north, lies across "
                "two octants; give azimuth_deg, or the octant from true north and no magnetic_declination_deg"
            )
        if self.fell and not (exact or octant):
            raise ValueError("fell: a stone that fell needs azimuth_deg or octant")
        if self.fell is False and (exact or octant):
            raise ValueError("fell: a stone that stood has no fall direction; empty azimuth_deg and octant")
        return self

    def stone(self, line: int) -> Stone:
        """The stone, its directions counted from true north."""
        azimuth, north = self.azimuth_deg if self.octant is None else 45.0 * self.octant, self.magnetic_declination_deg
        return Stone(
            fell=math.isfinite(azimuth),
            azimuth_deg=(azimuth + north) % 360,
            octant=self.octant is not None,
            face_azimuth_deg=(self.face_azimuth_deg + north) % 360,
            line=line,
            height=self.height_m,
            **{name: getattr(self, name) for name in ("count", "b_over_h", "b_over_h_side", "round")},
        )


COLUMNS = tuple(SurveyRow.model_fields)
"""Columns a survey may have; ``azimuth_deg``, ``octant`` or, of stones that all stood, ``fell`` is needed."""


def read_survey(path: Path) -> list[Stone]:
    """Read a survey, its stones in the order of the file.

    A CSV with a header, UTF-8 with or without byte order mark; columns as `COLUMNS`. ``magnetic_declination_deg`` (east
    positive) is added to the stone's directions, so leave it empty where they were taken from true north. Lines that
    begin with ``#`` are comments.

    Raises
    ------
    RecordError
        If the file cannot be read, has no stone or an unknown column, or a cell is wrong; names file, line, column.
    """
    one_of = ("azimuth_deg", "octant", "fell")
    rows = read_rows(path, SurveyRow, delimiter=",", error=RecordError, kind="survey", one_of=one_of)
    stones = [row.stone(line) for line, row in rows]
    if not stones:
        raise RecordError(f"{path}: no stone; write one row per stone below the header")
    return stones
