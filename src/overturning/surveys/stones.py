"""A survey of fallen gravestones as somebody wrote it down: one row per stone, or per group of like stones."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from overturning.errors import RecordError

OCTANTS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
"""Compass octants in their order; octant i is centred on 45° i."""

COLUMNS = ("fell", "azimuth_deg", "octant", "count", "b_over_h", "b_over_h_side", "face_azimuth_deg",
           "magnetic_declination_deg")  # fmt: skip
"""Columns a survey may have; ``azimuth_deg`` or ``octant`` is needed."""

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
        The same in the plane at right angles; NaN where not given (a square plan is assumed then).
    face_azimuth_deg : float
        Direction that the front face looks to, degrees clockwise from true north; NaN where not given.
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


class _Row:
    def __init__(self, name: str, line: int, cells: dict[str, str]) -> None:
        self.name, self.line, self.cells = name, line, cells

    def error(self, column: str, why: str) -> RecordError:
        value = self.cells.get(column, "")
        return RecordError(f"{self.name}, line {self.line}: {column} {value!r}: {why}")

    def number(self, column: str, low: float, high: float, default: float = math.nan) -> float:
        text = self.cells.get(column, "")
        if text == "":
            return default
        try:
            value = float(text)
        except ValueError:
            raise self.error(column, f"give a number from {low:g} to {high:g}") from None
        if not low <= value <= high:
            raise self.error(column, f"it must lie from {low:g} to {high:g}")
        return value

    def stone(self) -> Stone:
        declination = self.number("magnetic_declination_deg", -180, 180, 0.0)
        text = self.cells.get("fell", "").lower()
        if text and text not in _YES | _NO:
            raise self.error("fell", "write yes or no")
        octant, exact = self.cells.get("octant", "").upper(), self.number("azimuth_deg", -360, 360)
        if octant and octant not in OCTANTS:
            raise self.error("octant", f"use one of {' '.join(OCTANTS)}")
        directed = bool(octant) or math.isfinite(exact)
        fell = text in _YES if text else directed
        if octant and math.isfinite(exact):
            raise self.error("octant", "give azimuth_deg or octant, not both")
        if fell and not directed:
            raise self.error("fell", "a stone that fell needs azimuth_deg or octant")
        if directed and not fell:
            raise self.error("fell", "a stone that stood has no fall direction; empty azimuth_deg and octant")
        count = self.number("count", 1, 1_000_000, 1)
        if count != int(count):
            raise self.error("count", "give a whole number")
        azimuth = 45.0 * OCTANTS.index(octant) if octant else exact
        return Stone(
            fell=fell,
            azimuth_deg=(azimuth + declination) % 360 if fell else math.nan,
            octant=bool(octant),
            count=int(count),
            b_over_h=self.number("b_over_h", 0.01, 5),
            b_over_h_side=self.number("b_over_h_side", 0.01, 5),
            face_azimuth_deg=(self.number("face_azimuth_deg", -360, 360) + declination) % 360,
            line=self.line,
        )


def read_survey(path: Path) -> list[Stone]:
    """Read a survey.

    A CSV with a header; columns as `COLUMNS`. ``magnetic_declination_deg`` (east positive) is added to the stone's
    directions, so leave it empty where they were taken from true north. Lines that begin with ``#`` are comments.

    Parameters
    ----------
    path : Path
        The file, UTF-8 with or without byte order mark.

    Returns
    -------
    list of Stone
        In the order of the file.

    Raises
    ------
    RecordError
        If the file cannot be read, has no stone or an unknown column, or a cell is wrong; names file, line, column.
    """
    name = path.name
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise RecordError(f"{name}: cannot be read ({error.strerror}); give the path of a CSV file") from None
    except UnicodeDecodeError:
        raise RecordError(f"{name}: not UTF-8; save the table as CSV in UTF-8") from None
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not lines:
        raise RecordError(f"{name}: empty; the first line names columns, for instance azimuth_deg,count")
    rows = list(csv.reader([line for _, line in lines]))
    header = [cell.strip().lower() for cell in rows[0]]
    unknown = [cell for cell in header if cell not in COLUMNS]
    if unknown:
        raise RecordError(f"{name}, line {lines[0][0]}: column {unknown[0]!r} is not known; use {', '.join(COLUMNS)}")
    if len(set(header)) < len(header) or not {"azimuth_deg", "octant"} & set(header):
        raise RecordError(f"{name}, line {lines[0][0]}: name each column once, azimuth_deg or octant among them")
    stones = []
    for (line, _), cells in zip(lines[1:], rows[1:], strict=True):
        if len(cells) != len(header):
            raise RecordError(f"{name}, line {line}: {len(cells)} cells, the header names {len(header)} columns")
        stones.append(_Row(name, line, dict(zip(header, (c.strip() for c in cells), strict=True))).stone())
    if not stones:
        raise RecordError(f"{name}: no stone; write one row per stone below the header")
    return stones
