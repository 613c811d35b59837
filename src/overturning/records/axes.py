"""Axis names as networks write them: bearings, azimuths, words, channel codes."""

import re

from overturning.errors import RecordError

Direction = tuple[float | None, int]
"""Azimuth, degrees clockwise from north or None, and vertical sense: +1 up, −1 down, 0 otherwise."""

UNKNOWN: Direction = (None, 0)

_WORDS: dict[Direction, str] = {
    (None, 1): "UP U Z +Z UPWARD",
    (None, -1): "DOWN DN DWN DOWNWARD -Z",
    (0.0, 0): "N NS N-S NORTH",
    (90.0, 0): "E EW E-W EAST",
    (180.0, 0): "S SOUTH",
    (270.0, 0): "W WEST",
}
_NAMED = {word: direction for direction, words in _WORDS.items() for word in words.split()}


def parse_axis(text: str) -> Direction:
    """Azimuth (0 ≤ azimuth < 360 degrees clockwise from north) and vertical sense (+1 up, −1 down, 0 otherwise) of an axis name.

    Names are ``N28W`` (28° from north towards west), ``S90E``, ``270``, ``360 Deg``, ``N``, ``Up``, ``Down``… None and 0: nothing
    is known (``H1``, ``RAD``, ``--L``, and a bare ``VERT``, whose sense nobody states).
    """
    word = re.sub(r"\s*(DEG(REES?)?|°)\.?$", "", text.strip().upper()).strip()
    if word in _NAMED:
        return _NAMED[word]
    if match := re.fullmatch(r"([NS])\s*(\d{1,2}(?:\.\d+)?)\s*([EW])", word):
        angle = float(match[2])
        if angle > 90:
            return UNKNOWN
        from_north = angle if match[1] == "N" else 180.0 - angle
        return (from_north if match[3] == "E" else -from_north) % 360.0, 0
    if re.fullmatch(r"\d{1,3}(\.\d+)?", word) and float(word) <= 360:
        return float(word) % 360.0, 0
    return UNKNOWN


def is_vertical_of_unknown_sense(text: str) -> bool:
    """Whether an axis is vertical but nobody says which way up it is: ``V``, ``+V``, ``VER``, ``Vert``, COSMOS code 402."""
    word = text.strip().upper().rpartition(":")[2].strip().rstrip(".")
    return word in {"V", "+V", "-V", "VER", "VRT", "VERT", "VERTICAL", "402"}


def channel_axis(code: str) -> Direction:
    """Azimuth and vertical sense of a SEED channel code by its last letter: Z up, N and E within 5° of north and east."""
    return {"Z": (None, 1), "N": (0.0, 0), "E": (90.0, 0)}.get(code[-1:].upper(), UNKNOWN)


def agree(file: str, line: int, text: str, first: float | None, second: float | None) -> None:
    """Refuse two statements of an azimuth in one file that are more than a degree apart."""
    if first is None or second is None:
        return
    if abs((first - second + 180.0) % 360.0 - 180.0) > 1.0:
        raise RecordError(
            f"{file} line {line}: axis {text.strip()!r} ({first:g} degrees), but the numbers below it say {second:g}; "
            "components may be swapped: find out which, and give azimuths_deg"
        )
