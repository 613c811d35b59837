"""Headings of declared columns: find them, and compare them with the declaration."""

import re
from collections.abc import Mapping, Sequence
from typing import Final

from overturning.records.axis_direction import (
    UNKNOWN_DIRECTION,
    AzimuthAndVerticalSense,
    direction_from_channel_code,
    parse_axis_direction,
)
from overturning.records.formats.lines import FLOAT_PATTERN
from overturning.units import ACCELERATION_UNITS_IN_M_S2

SECONDS_BY_TIME_UNIT: Final = {"s": 1.0, "ms": 1e-3}
NUMBER_NAN_OR_INFINITY_PATTERN: Final = re.compile(rf"{FLOAT_PATTERN}|[+-]?(nan|inf|infinity)", re.IGNORECASE)
"""Cell with letters that is a number (``1e-3``) or stands for a missing one (``nan``), not a heading."""

_PATTERNS_OF_NON_ACCELERATION_QUANTITIES: Final = (
    (
        "velocity",
        r"(?<![a-z])[mc]?m(/s|s-1)(?![/a-z0-9.*-])|(?<![a-z])(vel(oc(ity)?)?|kine?)(?![a-z])"
        r"|^v_?([nexyz]|ns|ew|ud|north|east|up)$",
    ),
    ("displacement", r"(?<![a-z])displ?(acement)?(?![a-z])|(^|[(\[,_])[mc]?m[)\]]?$"),
    ("counts", r"(?<![a-z])(counts?|volts?)(?![a-z])"),
)
"""Quantities other than acceleration, with the pattern of their units and words in a normalised heading."""

_CHANNEL_CODE_PATTERN: Final = re.compile("[A-Z][A-Z][NEZ]")
"""SEED channel code of a known direction, such as ``HNE``."""

_PREFIXED_AXIS_PATTERN: Final = re.compile("(?:acc|a)-?([NEZU]|N-?S|E-?W|U-?D|north|east|up)", re.IGNORECASE)
"""Axis after an abbreviation of acceleration: ``aN``, ``accEW``."""

_STATED_UNIT_PATTERN: Final = re.compile(
    r"\bunits?\b[ :=]*(?:(?:are|is|of|in) +)?[(\[]?([a-z0-9/%]+)|\bin ([a-z0-9/]+)|[(\[](.*?)[)\]]"
)
"""Unit in a normalised line of text: ``units: g``, ``acceleration in m/s2``, ``velocity (cm/s)``."""


def _normalise_heading(column_heading: str) -> str:
    """Return a column heading in lower case, with uniform spelling of units such as m/s2."""
    plain = column_heading.strip("\"'# \t").lower().replace("²", "2").replace("^", "").replace("**", "")
    spelled = re.sub(r"(?<=m)[ .*·]?s-(1|2)\b", lambda power: "/s" if power[1] == "1" else "/s2", plain)
    return re.sub(r"(?<=[m/])sec\b", "s", re.sub(r"/sec(?=[/2\s)\]]|$)", "/s", spelled)).replace("/s/s", "/s2")


def first_number_line_index(lines: Sequence[str]) -> int:
    """Return the index of the first line of numbers, after comments (``#``) and lines of words; 0 if there is none."""
    for index, line in enumerate(lines):
        text = line.strip()
        cells = [cell for cell in re.split(r"[;,\s]+", text) if cell]
        worded = any(
            re.search("[A-Za-z\u0080-\uffff]", cell) and not NUMBER_NAN_OR_INFINITY_PATTERN.fullmatch(cell)
            for cell in cells
        )
        if cells and not text.startswith("#") and not worded:
            return index
    return 0


def split_heading_lines_into_cells(
    lines_above_numbers: Sequence[str], separator: str | None, declared_column_count: int
) -> list[list[str]]:
    """Split each heading line above the numbers into cells; leave out lines without one cell per column.

    Cells are separated like the numbers, by two or more blanks or tabs, or by single blanks. A line of prose may have
    as many words as columns by chance, so cells separated by blanks must each contain a letter.
    """
    return [
        cells
        for line in lines_above_numbers
        if (cells := _split_heading_line_or_empty_if_count_differs(line, separator, declared_column_count))
    ]


def _strip_comment_marks(line: str, separator: str | None) -> str:
    """Return a line without leading comment marks: ``#``, ``%``, ``!``, ``//``, ``;``."""
    return line.strip().lstrip("#%!/* \t" + ("" if separator == ";" else ";")).strip()


def _split_heading_line_or_empty_if_count_differs(
    line: str, separator: str | None, declared_column_count: int
) -> list[str]:
    """Split a heading line into cells; return [] if the line does not have one cell per column."""
    text = _strip_comment_marks(line, separator)
    ways = [text.split(separator)] if separator else []
    blanks = [re.split(r"\s{2,}|\t", text), text.split(), *([[text]] if declared_column_count == 1 else [])]
    ways += [way for way in blanks if all(re.search("[A-Za-z]", cell) for cell in way)]
    cells = next((way for way in ways if len(way) == declared_column_count), []) if text else []
    return [cell.strip() for cell in cells]


def axis_direction_in_column_heading(column_heading: str) -> AzimuthAndVerticalSense:
    """Return the axis direction in a column heading such as ``HNE`` or ``Acc.E-W (gal)``; else `UNKNOWN_DIRECTION`."""
    if (whole := parse_axis_direction(column_heading.partition("(")[0].partition("[")[0])) != UNKNOWN_DIRECTION:
        return whole
    named = set[AzimuthAndVerticalSense]()
    for word in re.split(r"[\s_.:,()\[\]]+", column_heading):
        prefixed = _PREFIXED_AXIS_PATTERN.fullmatch(word)
        if _CHANNEL_CODE_PATTERN.fullmatch(word.upper()) and len(word) == 3:
            named.add(direction_from_channel_code(word))
        elif re.search("[A-Za-z]", word) and word != "s":  # "s" stands for seconds, not south.
            named.add(parse_axis_direction(prefixed[1] if prefixed else word))
    named.discard(UNKNOWN_DIRECTION)
    return named.pop() if len(named) == 1 else UNKNOWN_DIRECTION


def unit_line_conflict_notes_and_refusal_reason(
    file_name: str,
    lines_above_numbers: Sequence[str],
    separator: str | None,
    axis_and_unit_of_declared_columns: Sequence[tuple[str, str]],
) -> tuple[tuple[str, ...], str]:
    """Return notes on lines of text with another unit than declared, and the reason to refuse the file (or "").

    A line such as ``# units: g`` applies to all columns. The file is refused for a line that names a quantity other
    than acceleration, such as ``Velocity (cm/s)``. Column headings: `heading_conflict_notes_and_refusal_reason`.
    """
    units = {unit for word, unit in axis_and_unit_of_declared_columns if word not in ("time", "skip")}
    notes, others = [], []
    for line in lines_above_numbers:
        text = _strip_comment_marks(line, separator)
        plain = _normalise_heading(text)
        quantity = re.match(r"(?:(?:un)?corrected |processed |ground )*(velocity|displacement)\b", plain)
        about = bool(quantity) or re.match(r"(?:(?:un)?corrected |processed |ground )*acc|.*\bunits?\b", plain)
        if (
            _split_heading_line_or_empty_if_count_differs(line, separator, len(axis_and_unit_of_declared_columns))
            or not about
        ):
            continue
        stated = [word for match in _STATED_UNIT_PATTERN.finditer(plain) for word in match.groups() if word]
        what = (
            quantity[1]
            if quantity
            else next((w for word in stated if (w := _quantity_other_than_acceleration(word))), "")
        )
        if what and "acc" not in plain:
            others.append(f"the line {text[:60]!r} says {what}, {' and '.join(sorted(units))} is declared")
            continue
        named = next((word for word in stated if word in ACCELERATION_UNITS_IN_M_S2), "")
        if named and any(ACCELERATION_UNITS_IN_M_S2[named] != ACCELERATION_UNITS_IN_M_S2[unit] for unit in units):
            taken = f"columns are taken in {' and '.join(sorted(units))}, as declared"
            notes.append(f"{file_name}: the line {text[:60]!r} names {named}; {taken}")
    return tuple(dict.fromkeys(notes)), "; ".join(dict.fromkeys(others))


def heading_conflict_notes_and_refusal_reason(
    file_name: str,
    cells_of_heading_lines: Sequence[Sequence[str]],
    axis_and_unit_of_declared_columns: Sequence[tuple[str, str]],
) -> tuple[tuple[str, ...], str]:
    """Return notes on headings with another axis or unit than the user states, and the reason to refuse the file.

    The reason names a quantity other than acceleration; "" if there is none.

    Parameters
    ----------
    file_name : str
        Name of the file.
    cells_of_heading_lines : sequence of sequences of str
        Cells of the lines of headings: ``E``, ``north (g)``, ``N-S(cm/s/s)``.
    axis_and_unit_of_declared_columns : sequence of pairs
        Declared axis and unit of each column.
    """
    notes, others = [], []
    for cells in cells_of_heading_lines:
        for text, (word, unit) in zip(cells, axis_and_unit_of_declared_columns, strict=True):
            axis, _, rest = text.strip("\"'# ").replace("[", "(").partition("(")
            known: Mapping[str, float] = SECONDS_BY_TIME_UNIT if word == "time" else ACCELERATION_UNITS_IN_M_S2
            # A second line of headings may hold units only.
            named = _normalise_heading(rest or axis).rstrip(")] ").replace("seconds", "s").replace("sec", "s")
            other_axis = word != "time" and axis_direction_in_column_heading(text.strip("\"'# ")) not in (
                UNKNOWN_DIRECTION,
                parse_axis_direction(word),
            )
            if word == "skip":
                continue
            if other_axis or known.get(named, known[unit]) != known[unit]:
                notes.append(f"{file_name}: the column under {text!r} is taken as {word} in {unit}, as declared")
            elif word != "time" and (what := _quantity_other_than_acceleration(text)):
                others.append(f"the heading {text!r} says {what}, {word} in {unit} is declared")
    return tuple(dict.fromkeys(notes)), "; ".join(dict.fromkeys(others))


def _quantity_other_than_acceleration(column_heading: str) -> str:
    """Return the quantity in a column heading if it is not acceleration, such as "velocity"; else ""."""
    plain = _normalise_heading(column_heading)
    return next((what for what, pattern in _PATTERNS_OF_NON_ACCELERATION_QUANTITIES if re.search(pattern, plain)), "")
