"""Headings of declared columns: which lines they are, and what they say against the declaration."""

import re
from collections.abc import Mapping, Sequence
from typing import Final

from overturning.records.component import UNKNOWN, parse_axis
from overturning.records.formats.lines import FLOAT
from overturning.units import UNITS

SECONDS: Final = {"s": 1.0, "ms": 1e-3}
NUMBER: Final = re.compile(rf"{FLOAT}|[+-]?(nan|inf|infinity)", re.IGNORECASE)
"""Of a cell with letters that is no heading, but a number or the lack of one."""

_QUANTITIES: Final = (
    ("velocity", r"(?<![a-z])[mc]?m(/s|s-1)(?![/a-z0-9.*-])|(?<![a-z])(vel(oc(ity)?)?|kine?)(?![a-z])"),
    ("displacement", r"(?<![a-z])displ?(acement)?(?![a-z])|[(\[,_][mc]?m[)\]]?$"),
)
"""What a heading names that is no acceleration, by a unit or a word, after `_plain`."""


def _plain(text: str) -> str:
    """A heading in small letters, with one spelling of powers and seconds, and without blanks around its unit."""
    text = text.strip("\"'# \t").lower().replace("²", "2").replace("^", "").replace("**", "")
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
    found = []
    for line in lines:
        text = line.strip().lstrip("#").strip()
        ways = [text.split(separator)] if separator else []
        blanks = [re.split(r"\s{2,}|\t", text), text.split(), *([[text]] if width == 1 else [])]
        ways += [way for way in blanks if all(re.search("[A-Za-z]", cell) for cell in way)]
        if text and (cells := next((way for way in ways if len(way) == width), None)):
            found.append([cell.strip() for cell in cells])
    return found


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
            other_axis = word != "time" and parse_axis(axis) not in (UNKNOWN, parse_axis(word))
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
