"""Headings of declared columns: which lines they are, and what they say against the declaration."""

import re
from collections.abc import Mapping, Sequence
from typing import Final

from overturning.records.component import UNKNOWN, Direction, channel_axis, parse_axis
from overturning.records.formats.lines import FLOAT
from overturning.units import UNITS

SECONDS: Final = {"s": 1.0, "ms": 1e-3}
NUMBER: Final = re.compile(rf"{FLOAT}|[+-]?(nan|inf|infinity)", re.IGNORECASE)
"""Of a cell with letters that is no heading, but a number or the lack of one."""

_QUANTITIES: Final = (
    (
        "velocity",
        r"(?<![a-z])[mc]?m(/s|s-1)(?![/a-z0-9.*-])|(?<![a-z])(vel(oc(ity)?)?|kine?)(?![a-z])"
        r"|^v_?([nexyz]|ns|ew|ud|north|east|up)$",
    ),
    ("displacement", r"(?<![a-z])displ?(acement)?(?![a-z])|(^|[(\[,_])[mc]?m[)\]]?$"),
    ("counts", r"(?<![a-z])(counts?|volts?)(?![a-z])"),
)
"""What a heading names that is no acceleration, by a unit or a word, after `_plain`."""

_SEED: Final = re.compile("[A-Z][A-Z][NEZ]")
"""Channel codes, HNE."""

_PREFIXED: Final = re.compile("(?:acc|a)-?([NEZU]|N-?S|E-?W|U-?D|north|east|up)", re.IGNORECASE)
"""An axis with the word acceleration before it: ``aN``, ``accEW``."""

_STATED_UNIT: Final = re.compile(
    r"\bunits?\b[ :=]*(?:(?:are|is|of|in) +)?[(\[]?([a-z0-9/%]+)|\bin ([a-z0-9/]+)|[(\[](.*?)[)\]]"
)
"""The unit in a line of text, after `_plain`: ``units: g``, ``acceleration in m/s2``, ``velocity (cm/s)``."""


def _plain(text: str) -> str:
    """A heading in small letters, with one spelling of powers and seconds, and without blanks around its unit."""
    text = text.strip("\"'# \t").lower().replace("²", "2").replace("^", "").replace("**", "")
    text = re.sub(r"(?<=m)[ .*·]?s-(1|2)\b", lambda power: "/s" if power[1] == "1" else "/s2", text)
    return re.sub(r"(?<=[m/])sec\b", "s", re.sub(r"/sec(?=[/2\s)\]]|$)", "/s", text)).replace("/s/s", "/s2")


def first_row(lines: Sequence[str]) -> int:
    """Index of the first line of numbers, after comments behind ``#`` and lines that hold a word; 0 where none is."""
    for index, line in enumerate(lines):
        text = line.strip()
        cells = [cell for cell in re.split(r"[;,\s]+", text) if cell]
        worded = any(re.search("[A-Za-z\u0080-\uffff]", cell) and not NUMBER.fullmatch(cell) for cell in cells)
        if cells and not text.startswith("#") and not worded:
            return index
    return 0


def cells_of_headings(lines: Sequence[str], separator: str | None, width: int) -> list[list[str]]:
    """Cells of each line above the numbers, behind ``#`` or not, that has as many as there are columns.

    They are set off as the numbers are, or by blanks; those of several words by two blanks or more. Prose may have as
    many words as there are columns by chance, so that of words set off by blanks each has a letter.
    """
    return [cells for line in lines if (cells := _cells(line, separator, width))]


def _uncommented(line: str, separator: str | None) -> str:
    """A line without the marks of a comment before it: ``#``, ``%``, ``!``, ``//``, ``;``."""
    return line.strip().lstrip("#%!/* \t" + ("" if separator == ";" else ";")).strip()


def _cells(line: str, separator: str | None, width: int) -> list[str]:
    """Cells of a line of headings; none of any other line."""
    text = _uncommented(line, separator)
    ways = [text.split(separator)] if separator else []
    blanks = [re.split(r"\s{2,}|\t", text), text.split(), *([[text]] if width == 1 else [])]
    ways += [way for way in blanks if all(re.search("[A-Za-z]", cell) for cell in way)]
    cells = next((way for way in ways if len(way) == width), []) if text else []
    return [cell.strip() for cell in cells]


def heading_axis(text: str) -> Direction:
    """Direction that a heading names: ``N``, ``HNE``, ``acc_e``, ``Acc.E-W (gal)``; unknown where it names two."""
    if (whole := parse_axis(text.partition("(")[0].partition("[")[0])) != UNKNOWN:
        return whole
    named = set[Direction]()
    for word in re.split(r"[\s_.:,()\[\]]+", text):
        prefixed = _PREFIXED.fullmatch(word)
        if _SEED.fullmatch(word.upper()) and len(word) == 3:
            named.add(channel_axis(word))
        elif re.search("[A-Za-z]", word) and word != "s":  # a number may be anything, and s is second
            named.add(parse_axis(prefixed[1] if prefixed else word))
    named.discard(UNKNOWN)
    return named.pop() if len(named) == 1 else UNKNOWN


def statements(
    name: str, lines: Sequence[str], separator: str | None, columns: Sequence[tuple[str, str]]
) -> tuple[tuple[str, ...], str]:
    """Notes on lines of text above the numbers that state another unit, and the reason where one is no acceleration.

    Such a line is for all columns: ``Velocity (cm/s)``, ``# units: g``. See `otherwise`.
    """
    units = {unit for word, unit in columns if word not in ("time", "skip")}
    notes, others = [], []
    for line in lines:
        text = _uncommented(line, separator)
        plain = _plain(text)
        quantity = re.match(r"(?:(?:un)?corrected |processed |ground )*(velocity|displacement)\b", plain)
        about = bool(quantity) or re.match(r"(?:(?:un)?corrected |processed |ground )*acc|.*\bunits?\b", plain)
        if _cells(line, separator, len(columns)) or not about:
            continue
        stated = [word for match in _STATED_UNIT.finditer(plain) for word in match.groups() if word]
        what = quantity[1] if quantity else next((w for word in stated if (w := _quantity(word))), "")
        if what and "acc" not in plain:
            others.append(f"the line {text[:60]!r} says {what}, {' and '.join(sorted(units))} is declared")
            continue
        named = next((word for word in stated if word in UNITS), "")
        if named and any(UNITS[named] != UNITS[unit] for unit in units):
            taken = f"columns are taken in {' and '.join(sorted(units))}, as declared"
            notes.append(f"{name}: the line {text[:60]!r} names {named}; {taken}")
    return tuple(dict.fromkeys(notes)), "; ".join(dict.fromkeys(others))


def otherwise(
    name: str, headings: Sequence[Sequence[str]], columns: Sequence[tuple[str, str]]
) -> tuple[tuple[str, ...], str]:
    """Notes on headings that name another axis or unit than is declared; reason where one is no acceleration, or "".

    Parameters
    ----------
    name : str
        Of the file.
    headings : sequence of sequences of str
        Cells of the lines of headings: ``E``, ``north (g)``, ``N-S(cm/s/s)``.
    columns : sequence of pairs
        Declared axis and unit of each.
    """
    notes, others = [], []
    for cells in headings:
        for text, (word, unit) in zip(cells, columns, strict=True):
            axis, _, rest = text.strip("\"'# ").replace("[", "(").partition("(")
            known: Mapping[str, float] = SECONDS if word == "time" else UNITS
            # A line of units alone stands below one of names.
            named = _plain(rest or axis).rstrip(")] ").replace("seconds", "s").replace("sec", "s")
            other_axis = word != "time" and heading_axis(text.strip("\"'# ")) not in (UNKNOWN, parse_axis(word))
            if word == "skip":
                continue
            if other_axis or known.get(named, known[unit]) != known[unit]:
                notes.append(f"{name}: the column under {text!r} is taken as {word} in {unit}, as declared")
            elif word != "time" and (what := _quantity(text)):
                others.append(f"the heading {text!r} says {what}, {word} in {unit} is declared")
    return tuple(dict.fromkeys(notes)), "; ".join(dict.fromkeys(others))


def _quantity(text: str) -> str:
    """The quantity of a heading that is no acceleration; empty of any other."""
    plain = _plain(text)
    return next((what for what, pattern in _QUANTITIES if re.search(pattern, plain)), "")
