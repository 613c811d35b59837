"""Notations of a survey table: numbers with decimal commas, directions (degrees, compass point, bearing), outcomes."""

import difflib
import math
import re
from collections.abc import Iterable
from typing import Final, Literal, NamedTuple

COMPASS_POINTS_16: Final = (
    "N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE", "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW",
)  # fmt: skip
"""The 16 compass points in their order; point i is centred on 22.5° i."""

OCTANTS = COMPASS_POINTS_16[::2]
"""Compass octants in their order; octant i is centred on 45° i."""

DIRECTION_FORMAT_HINT: Final = (
    "give a number of degrees from -360 to 360, one of the 16 compass points (N, NNE, …), or a quadrant bearing such "
    "as S40E"
)
"""Remedy for a direction that cannot be read."""

_BEARING: Final = re.compile(r"([NS])\s*(\d+(?:[.,]\d+)?)\s*(?:[°º˚]|deg)?\s*([EW])", re.IGNORECASE)
_NUMBER: Final = r"[+-]?\d+(?:[.,]\d+)?"


UNKNOWN_VALUE_TEXTS: Final = ("?", "-", "–", "—", "n/a", "na", "unknown", "not known")
"""Texts of a cell of a number or direction that is not known; it counts as empty."""


class StatedDirection(NamedTuple):
    """Direction in a survey table: azimuth, degrees clockwise from the table's north, and compass point, if any.

    ``index_in_16_compass_points`` is the index in `COMPASS_POINTS_16`; None if the direction was given in degrees or as
    a quadrant bearing.
    """

    azimuth_deg: float
    index_in_16_compass_points: int | None = None


NO_DIRECTION: Final = StatedDirection(math.nan)
"""Direction of an empty cell."""


def normalise_number_text(text: object) -> object:
    """Prepare the text of a number for `float`: replace a decimal comma by a point, a minus sign by a hyphen."""
    if not isinstance(text, str):
        return text
    plain = text.strip().replace("\N{MINUS SIGN}", "-")
    if "_" in plain:  # `float` reads 0_4 as 4
        raise ValueError("write a number without underscores")
    return plain.replace(",", ".") if re.fullmatch(r"[+-]?\d*,\d+", plain) else plain


def make_shift_text_readable_as_float(text: object) -> object:
    """Prepare the text of a shift for `float`; refuse a comma or point that may separate thousands, as in 1,000."""
    if isinstance(text, str) and re.fullmatch(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", text.strip()):
        raise ValueError("may be a thousand or have three decimals; write 1000, or fewer decimals")
    return normalise_number_text(text)


def normalise_degrees_text(text: object) -> object:
    """Prepare the text of an angle for `float`: remove a degree sign, convert a decimal comma to a point."""
    plain = normalise_number_text(text)
    return normalise_number_text(re.sub(r"\s*([°º˚]|deg|degrees)$", "", plain)) if isinstance(plain, str) else plain


def parse_direction(text: object) -> StatedDirection:
    """Convert the text of a direction, such as ``120``, ``NNE``, ``S40E`` or ``N 25° W``, to a `StatedDirection`.

    A ValueError names the allowed forms.
    """
    if isinstance(text, StatedDirection):
        return text
    plain = str(text).strip()
    if plain.upper() in COMPASS_POINTS_16:
        wind = COMPASS_POINTS_16.index(plain.upper())
        return StatedDirection(22.5 * wind, wind)
    if found := _BEARING.fullmatch(plain):
        start, angle, end = found[1].upper(), float(found[2].replace(",", ".")), found[3].upper()
        if angle > 90:
            raise ValueError("the angle of a quadrant bearing is 0 to 90 degrees, as in S40E")
        sign = 1.0 if (start == "N") == (end == "E") else -1.0
        return StatedDirection(((0.0 if start == "N" else 180.0) + sign * angle) % 360)
    try:
        degrees = float(str(normalise_degrees_text(plain)))
    except ValueError:
        raise ValueError(DIRECTION_FORMAT_HINT) from None
    if 360 < degrees <= 400:
        raise ValueError("give degrees from -360 to 360; an azimuth in gon (400 to a turn) times 0.9")
    if not abs(degrees) <= 360:
        raise ValueError(DIRECTION_FORMAT_HINT)
    return StatedDirection(degrees)


def largest_usual_step_dividing_azimuths_deg(azimuths_deg: Iterable[float]) -> float:
    """Return the step in which azimuths were recorded: the largest of 45, 30, 15, 10, 5 and 1° that divides all.

    It is 0 if none of the steps divides all azimuths. NaN stands for an azimuth that is not known.
    """
    known = [one for one in azimuths_deg if math.isfinite(one)]
    steps = (45.0, 30.0, 15.0, 10.0, 5.0, 1.0) if known else ()
    return next((step for step in steps if not any(azimuth % step for azimuth in known)), 0.0)


OutcomeKind = Literal["fell", "stands", "shifted", "twisted", "broken", "repaired", "fixed", "unknown"]
"""Outcome of a stone in a survey."""

OUTCOME_KINDS_NOT_COUNTED_AS_STANDING: Final[tuple[OutcomeKind, ...]] = ("fixed", "repaired", "broken", "unknown")
"""Outcomes of stones that count neither as fallen nor as standing, unless they fell; the first one found is the reason.

The model is of a rigid stone that stands freely: a stone fixed to its base never counts, not even if it fell.
"""

_OUTCOME_KIND_BY_WORD: Final[dict[str, OutcomeKind]] = {
    **dict.fromkeys(("stands", "stood", "standing", "upright", "intact", "undamaged", "not fallen"), "stands"),
    **dict.fromkeys(("broken", "snapped", "fractured"), "broken"),
    **dict.fromkeys(("repaired", "restored", "re-erected", "reerected", "rebuilt", "reset"), "repaired"),
    **dict.fromkeys(("fixed", "fixed to its base", "fixed to base", "dowelled", "doweled", "pinned"), "fixed"),
    **dict.fromkeys(("unknown", "not known", "not seen", "?"), "unknown"),
}
_FALL_REGEX: Final = re.compile(
    r"(?:fell|fallen|overturned|toppled)(?: over)?(?:\s+(?:in\s+)?(?:to\s+|towards\s+)?(.+))?", re.IGNORECASE
)
_SHIFT_REGEX: Final = re.compile(
    rf"(?:shifted|moved|displaced)(?:\s+by)?(?:\s+({_NUMBER})\s*(mm|cm|m)?)?", re.IGNORECASE
)
_TWIST_REGEX: Final = re.compile(
    rf"(?:twisted|rotated)(?:\s+by)?(?:\s+({_NUMBER})\s*(?:[°º˚]|deg|degrees)?)?"
    r"(?:\s+(clockwise|cw|anticlockwise|counterclockwise|ccw))?",
    re.IGNORECASE,
)
_UNKNOWN_DIRECTION_REGEX: Final = re.compile(
    r"[,;:(]?\s*(?:(?:in\s+)?(?:an?\s+)?unknown\s+direction|direction\s+(?:is\s+)?(?:not\s+known|unknown|\?))\s*\)?",
    re.IGNORECASE,
)
_OUTCOME_SEPARATOR_REGEX: Final = re.compile(r"\s*(?:[;/&]|\+(?!\s*\d)|,(?!\d)|(?<!\d),|\band\b)\s*")
_METRES_BY_UNIT: Final = {"mm": 0.001, "cm": 0.01, "m": 1.0}
OUTCOME_FORMAT_HINT: Final = (
    "write fell, fell direction unknown, stands, shifted 3 cm, twisted 10 (degrees, clockwise positive), broken, "
    "repaired, fixed (to its base) or unknown; several are separated by a comma"
)
"""Remedy for an outcome that cannot be read."""


class StatedOutcome(NamedTuple):
    """Outcome of a stone as stated in one table cell: fallen, standing, shifted, twisted and others.

    Attributes
    ----------
    kinds : tuple of str
        What happened, in the order of the cell.
    fall_direction : StatedDirection
        Direction of the fall if the cell names it, as in "fell SE".
    states_unknown_fall_direction : bool
        True if the cell states that the direction of the fall is not known.
    shift_m : float
        Shift of the base, m; NaN where not given.
    clockwise_twist_deg : float
        Rotation about the vertical, degrees, clockwise seen from above positive; NaN where not given.
    twist_sense_if_angle_not_stated : int
        1 if the cell states "clockwise" without an angle, -1 for "anticlockwise", otherwise 0.
    """

    kinds: tuple[OutcomeKind, ...] = ()
    fall_direction: StatedDirection = NO_DIRECTION
    states_unknown_fall_direction: bool = False
    shift_m: float = math.nan
    clockwise_twist_deg: float = math.nan
    twist_sense_if_angle_not_stated: int = 0

    def merged_with(self, other_outcome_in_cell: "StatedOutcome") -> "StatedOutcome":
        """Combine the outcomes that two statements of one table cell state, such as "fell SE" and "broken"."""
        direction = (
            other_outcome_in_cell.fall_direction
            if math.isfinite(other_outcome_in_cell.fall_direction.azimuth_deg)
            else self.fall_direction
        )
        return StatedOutcome(
            (*self.kinds, *other_outcome_in_cell.kinds),
            direction,
            self.states_unknown_fall_direction,
            other_outcome_in_cell.shift_m if math.isfinite(other_outcome_in_cell.shift_m) else self.shift_m,
            other_outcome_in_cell.clockwise_twist_deg
            if math.isfinite(other_outcome_in_cell.clockwise_twist_deg)
            else self.clockwise_twist_deg,
            other_outcome_in_cell.twist_sense_if_angle_not_stated or self.twist_sense_if_angle_not_stated,
        )


def parse_outcome(text: object) -> StatedOutcome:
    """Convert the text of an outcome, such as "twisted 10, shifted 3 cm", to a `StatedOutcome`.

    A ValueError names the allowed forms.
    """
    if isinstance(text, StatedOutcome):
        return text
    whole = str(text).strip().replace("\N{MINUS SIGN}", "-")
    rest = _UNKNOWN_DIRECTION_REGEX.sub("", whole)
    found = StatedOutcome(states_unknown_fall_direction=rest != whole)
    for part in filter(None, _OUTCOME_SEPARATOR_REGEX.split(rest)):
        one = _parse_single_outcome(part)
        if any(kind in found.kinds for kind in one.kinds if kind in ("fell", "shifted", "twisted")):
            raise ValueError(f"{one.kinds[0]} is stated twice; state it once")
        found = found.merged_with(one)
    if "fell" not in found.kinds and found.states_unknown_fall_direction:
        raise ValueError("only a fall has a direction; write fell direction unknown")
    if not found.kinds:
        raise ValueError(OUTCOME_FORMAT_HINT)
    if found.states_unknown_fall_direction and math.isfinite(found.fall_direction.azimuth_deg):
        raise ValueError("gives a direction and states that it is not known; leave out one of them")
    if {"fell", "stands"} <= set(found.kinds):
        raise ValueError("a stone fell or stands, not both")
    return found


def _parse_single_outcome(outcome_statement: str) -> StatedOutcome:
    """Convert one statement of a table cell, such as "fell SE" or "twisted 10", to a `StatedOutcome`."""
    words = " ".join(outcome_statement.lower().replace("_", " ").split())
    if words in _OUTCOME_KIND_BY_WORD:
        return StatedOutcome((_OUTCOME_KIND_BY_WORD[words],))
    if fell := _FALL_REGEX.fullmatch(words):
        if _OUTCOME_KIND_BY_WORD.get(fell[1]) == "unknown":
            raise ValueError("write fell direction unknown")
        if _OUTCOME_KIND_BY_WORD.get(fell[1]) in ("broken", "repaired", "fixed"):
            raise ValueError(f"separate several outcomes by a comma, as in fell, {fell[1]}")
        return StatedOutcome(("fell",), parse_direction(fell[1]) if fell[1] else NO_DIRECTION)
    if shifted := _SHIFT_REGEX.fullmatch(words):
        if shifted[1] and not shifted[2]:
            raise ValueError("give the unit of the shift: mm, cm or m")
        size = (
            float(str(make_shift_text_readable_as_float(shifted[1]))) * _METRES_BY_UNIT[shifted[2]]
            if shifted[1]
            else math.nan
        )
        if size < 0 or size > 10:
            raise ValueError("give a shift from 0 to 10 m")
        return StatedOutcome(("shifted",), shift_m=size)
    if twisted := _TWIST_REGEX.fullmatch(words):
        sense = 0 if not twisted[2] else 1 if twisted[2] in ("clockwise", "cw") else -1
        if not twisted[1]:
            return StatedOutcome(("twisted",), twist_sense_if_angle_not_stated=sense)
        angle = float(twisted[1].replace(",", "."))
        if sense and angle < 0:
            raise ValueError("give the sign of the twist or clockwise/anticlockwise, not both")
        if abs(angle) > 180:
            raise ValueError("give a twist from -180 to 180 degrees, clockwise positive")
        return StatedOutcome(("twisted",), clockwise_twist_deg=(sense or 1) * angle)
    near = difflib.get_close_matches(
        words, ["fell", "fallen", "toppled", "overturned", "shifted", "twisted", *_OUTCOME_KIND_BY_WORD], 1, 0.7
    )
    raise ValueError((f"did you mean {near[0]}? " if near else "") + OUTCOME_FORMAT_HINT)


def azimuth_unit_warning(column_name: str, azimuths_deg: Iterable[float], survey_file_name: str) -> str:
    """Return a warning if azimuths in a column may be in radians or gon (400 = circle), not in degrees; else "".

    Radians are suspected if all values lie within ±2π and some are not whole numbers; gon, if all values are
    multiples of 50 (400 gon / 8), and some are no multiples of 90. Fewer than three different values give no warning.
    """
    values = [one for one in azimuths_deg if math.isfinite(one)]
    largest = max(map(abs, values), default=0.0)
    if len(set(values)) < _MIN_DISTINCT_AZIMUTHS_TO_SUSPECT_RADIANS_OR_GON:
        return ""
    if largest <= 2 * math.pi and any(one % 1 for one in values):
        return (
            f"{survey_file_name}: column {column_name}: {len(values)} values, none beyond {largest:g}°: radians? "
            "Multiply by 57.29578"
        )
    if all(one % 50 == 0 for one in values) and any(one % 90 for one in values):
        return (
            f"{survey_file_name}: column {column_name}: {len(values)} values, all multiples of 50°: gon (400 to a "
            "turn)? Multiply by 0.9"
        )
    return ""


_MIN_DISTINCT_AZIMUTHS_TO_SUSPECT_RADIANS_OR_GON: Final = 3
"""Smallest number of different azimuths for which a warning about their unit is given."""
