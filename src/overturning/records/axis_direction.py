"""Directions of the axes of a sensor, from names, codes and azimuths in record files."""

import re
from collections.abc import Callable
from typing import Final

from overturning.errors import RecordError
from overturning.motion.direction import angle_between_azimuths

AzimuthAndVerticalSense = tuple[float | None, int]
"""Direction of an axis: azimuth (degrees clockwise from north or None), vertical sense (+1 up, −1 down, else 0)."""


UNKNOWN_DIRECTION: AzimuthAndVerticalSense = (None, 0)


_AXIS_NAMES_BY_DIRECTION: dict[AzimuthAndVerticalSense, str] = {
    (None, 1): "UP U Z +Z UPWARD UD U-D",
    (None, -1): "DOWN DN DWN DOWNWARD -Z",
    (0.0, 0): "N NS N-S NORTH",
    (90.0, 0): "E EW E-W EAST",
    (180.0, 0): "S SOUTH",
    (270.0, 0): "W WEST",
}


_DIRECTION_BY_AXIS_NAME = {
    word: direction for direction, words in _AXIS_NAMES_BY_DIRECTION.items() for word in words.split()
}


def parse_axis_direction(axis_name_in_file: str) -> AzimuthAndVerticalSense:
    """Return the azimuth, degrees, and the vertical sense of an axis from its name, such as ``N28W`` or ``Up``.

    The azimuth is at least 0 and less than 360°, or None; the vertical sense is +1 up, −1 down, else 0. Names are
    ``N28W`` (28° from north towards west), ``S90E``, ``270``, ``360 Deg``, ``N``, ``Up``, ``Down``, and the Japanese
    ``NS2``, ``EW2``, ``UD2`` (positive towards the first letter; the number is that of the sensor). The result is
    (None, 0) for names without a direction, such as ``H1``, ``RAD`` and ``--L``, and for ``VERT``, whose sense is
    unknown.
    """
    word = re.sub(r"\s*(DEG(REES?)?|°)\.?$", "", axis_name_in_file.strip().upper()).strip()
    word = re.sub(r"^(N-?S|E-?W|U-?D)[12]$", r"\1", word)
    if word in _DIRECTION_BY_AXIS_NAME:
        return _DIRECTION_BY_AXIS_NAME[word]
    if match := re.fullmatch(r"([NS])\s*(\d{1,2}(?:\.\d+)?)\s*([EW])", word):
        angle = float(match[2])
        if angle > 90:
            return UNKNOWN_DIRECTION
        from_north = angle if match[1] == "N" else 180.0 - angle
        return (from_north if match[3] == "E" else -from_north) % 360.0, 0
    if re.fullmatch(r"\d{1,3}(\.\d+)?", word) and float(word) <= 360:
        return float(word) % 360.0, 0
    return UNKNOWN_DIRECTION


def is_vertical_axis_name_without_up_or_down(axis_name_in_file: str) -> bool:
    """Return True for an axis name that means vertical without a sense (up or down), such as ``V`` or ``Vert``."""
    word = axis_name_in_file.strip().upper().rpartition(":")[2].strip().rstrip(".")
    return word in {"V", "+V", "-V", "VER", "VRT", "VERT", "VERTICAL", "402"}


def direction_from_channel_code(channel_code: str) -> AzimuthAndVerticalSense:
    """Return the direction in the last letter of a SEED channel code: Z up, N north, E east, or `UNKNOWN_DIRECTION`."""
    return {"Z": (None, 1), "N": (0.0, 0), "E": (90.0, 0)}.get(channel_code[-1:].upper(), UNKNOWN_DIRECTION)


def channel_direction_mismatch_notes(
    channel_code: str, taken_direction: AzimuthAndVerticalSense, direction_source_label: str
) -> tuple[str, ...]:
    """Return a note if the direction taken for an axis is over 5° from that of its SEED channel code; else ()."""
    coded = direction_from_channel_code(channel_code) if len(channel_code) == 3 else UNKNOWN_DIRECTION
    if UNKNOWN_DIRECTION in (coded, taken_direction):
        return ()
    if coded[0] is None or taken_direction[0] is None:
        alike = coded == taken_direction
    else:
        alike = angle_between_azimuths(coded[0], taken_direction[0]) <= 5.0
    where = {1: "up", -1: "down"}.get(taken_direction[1], f"at {taken_direction[0] or 0.0:g}°")
    said = {"N": "north", "E": "east", "Z": "up"}[channel_code[-1].upper()]
    note = f"channel {channel_code} is taken {where}, as {direction_source_label} says; its code says {said}"
    return () if alike else (note,)


def direction_with_channel_code_fallback_and_notes(
    channel_code: str, stated_direction: AzimuthAndVerticalSense, reason_direction_is_unknown: str
) -> tuple[AzimuthAndVerticalSense, tuple[str, ...]]:
    """Return the stated direction of an axis; if it is unknown, return that in its channel code, and a note on this."""
    if stated_direction != UNKNOWN_DIRECTION:
        return stated_direction, ()
    coded = (
        direction_from_channel_code(channel_code)
        if re.fullmatch("[A-Z]{2}[NEZ]", channel_code.upper())
        else parse_axis_direction(channel_code)
    )
    if coded == UNKNOWN_DIRECTION:
        return UNKNOWN_DIRECTION, ()
    where = {1: "up", -1: "down"}.get(coded[1], f"at {coded[0] or 0.0:g}°")
    return coded, (f"{reason_direction_is_unknown}; the code of channel {channel_code} says {where}",)


MAX_AXIS_TILT_FROM_LEVEL_OR_VERTICAL_DEG: Final = 5.0
"""Largest angle between the horizontal (or vertical) and an axis that is read as horizontal (vertical), degrees."""


MAX_AXIS_INCLINATION_WITHOUT_NOTE_DEG: Final = 1.0
"""Largest angle between an axis and the horizontal or the vertical that needs no note, degrees."""


def direction_from_azimuth_and_dip_with_notes(
    channel_code: str, azimuth_deg: float | None, dip_deg: float | None, file_and_channel_label: str
) -> tuple[AzimuthAndVerticalSense, tuple[str, ...]]:
    """Return the direction of an axis from azimuth and dip (down positive), degrees, and a note if it is inclined.

    A missing dip counts as 0 if the SEED channel code says north or east. Otherwise, and for a horizontal axis without
    azimuth, the direction is `UNKNOWN_DIRECTION`. A RecordError is raised for an axis that is neither horizontal nor
    vertical (within 5°).
    """
    if dip_deg is None and direction_from_channel_code(channel_code)[0] is not None:
        dip_deg = 0.0
    if dip_deg is None:
        return UNKNOWN_DIRECTION, ()
    steep = abs(dip_deg) > 45.0
    inclination = abs(abs(dip_deg) - 90.0) if steep else abs(dip_deg)
    if not inclination <= MAX_AXIS_TILT_FROM_LEVEL_OR_VERTICAL_DEG:
        raise RecordError(
            f"{file_and_channel_label} dips by {dip_deg:g}°; only axes within "
            f"{MAX_AXIS_TILT_FROM_LEVEL_OR_VERTICAL_DEG:g}° of horizontal or vertical are read: "
            "rotate its sensor's channels to north, east and up, or correct the dip"
        )
    direction: AzimuthAndVerticalSense = (None, 1 if dip_deg < 0 else -1) if steep else UNKNOWN_DIRECTION
    if not steep and azimuth_deg is not None:
        direction = float(azimuth_deg) % 360.0, 0
    if inclination <= MAX_AXIS_INCLINATION_WITHOUT_NOTE_DEG:
        return direction, ()
    what = "vertical" if steep else "horizontal"
    return direction, (f"{file_and_channel_label} dips by {dip_deg:g}°; it is read as {what}",)


def horizontal_direction_from_azimuth_code(azimuth_code: float) -> AzimuthAndVerticalSense:
    """Return the direction of a header's azimuth code, degrees, above 0 and up to 360; else `UNKNOWN_DIRECTION`."""
    return (float(azimuth_code) % 360.0, 0) if 0 < azimuth_code <= 360 else UNKNOWN_DIRECTION


VERTICAL_DIRECTION_BY_FILM_AZIMUTH_CODE: Final[dict[int, AzimuthAndVerticalSense]] = {500: (None, 1), 600: (None, -1)}
"""Codes of a vertical axis in place of an azimuth, in California's film formats; 400 states no sense."""


def checked_axis_direction_from_name_or_code(
    axis_name_in_file: str,
    header_code_direction: AzimuthAndVerticalSense,
    create_axis_line_error: Callable[[str], RecordError],
) -> AzimuthAndVerticalSense:
    """Return the direction in an axis name, else in the header code; raise an error if they differ by over 1°."""
    named = parse_axis_direction(axis_name_in_file)
    if UNKNOWN_DIRECTION in (named, header_code_direction):
        return header_code_direction if named == UNKNOWN_DIRECTION else named
    coded, coded_sense = header_code_direction
    apart = 0.0 if named[0] is None or coded is None else angle_between_azimuths(named[0], coded)
    if named[1] != coded_sense or apart > 1.0:
        code = {1: "up", -1: "down"}[coded_sense] if coded is None else f"{coded:g} degrees"
        why = f"axis {axis_name_in_file.strip()!r}, but the numbers below it say {code}; components may be swapped"
        raise create_axis_line_error(f"{why}: find out which, and correct the file")
    return named
