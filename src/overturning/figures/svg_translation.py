"""Translation of the texts in an SVG file of Matplotlib, at the places of the English ones."""

import math
import re
from functools import cache
from html import escape, unescape
from typing import Final, NamedTuple

from overturning.translation.texts import ENGLISH, current_language, translate

_TEXT: Final = re.compile(r'(\s*)<text style="([^"]*)"([^>]*)>([^<]*)</text>')
_LINES: Final = re.compile(r"(?:\s*<text [^>]*>[^<]*</text>)+")
_PLACE: Final = re.compile(r' transform="translate\((\S+) (\S+)\)(?: rotate\((\S+)\))?"')
_SIZE: Final = re.compile(r"font-size: ([\d.]+)px")

FONTS: Final = {"ja": "'Noto Sans CJK JP', 'Hiragino Sans', 'Yu Gothic', 'IPAexGothic'"}
"""Names of fonts of a language that a browser tries before its own choice."""

_NO_LINE_START: Final = "、。，．・：；！？)）」』]％%°ー～,.;"
"""Characters with which no line begins."""


def translate_svg(svg: str, language: str | None = None) -> str:
    """Return the text of an SVG file with its texts in a language, by default the current one.

    A file in this language stays as it is. The layout stays that of the English texts. A text that is centred or
    aligned to the right stays so, and a text of several lines has at most as many lines as before.
    """
    language = language or current_language()
    if language == ENGLISH or f'<svg xml:lang="{language}" ' in svg:
        return svg
    text = _LINES.sub(lambda lines: _translate_lines(lines[0], language), svg)
    text = text.replace("Helvetica', 'Avant Garde', sans-serif", f"Helvetica', {FONTS[language]}, sans-serif")
    return text.replace("<svg ", f'<svg xml:lang="{language}" ', 1)


class _Line(NamedTuple):
    """Line of a text: its place (the start of its base line) if it has a transformation, its look and its letters."""

    indent: str
    style: str
    attributes: str
    text: str

    @property
    def size(self) -> float:
        """Size of the font, in units of the file."""
        found = _SIZE.search(self.style)
        return float(found[1]) if found else 10.0

    @property
    def start(self) -> tuple[float, float, float] | None:
        """Place, and rotation in degrees, clockwise; None for a text with an anchor of its own."""
        found = _PLACE.fullmatch(self.attributes)
        return (float(found[1]), float(found[2]), float(found[3] or 0.0)) if found else None

    @property
    def element(self) -> str:
        """The line as an element of the file."""
        return f'{self.indent}<text style="{self.style}"{self.attributes}>{escape(self.text, quote=False)}</text>'


def _translate_lines(svg_lines: str, language: str) -> str:
    """Translate the lines of one text, which follow each other in the file."""
    found = _TEXT.findall(svg_lines)
    lines = [_Line(indent, style, attributes, unescape(text)) for indent, style, attributes, text in found]
    english = "\n".join(one.text for one in lines)
    translation = translate(english, language)
    if translation == english:
        return svg_lines
    new = translation.split("\n")
    if len(new) < len(lines):
        new = break_lines(new, max(map(_english_width, lines)) / lines[0].size, len(lines))
    placed = lines if all(one.start is None for one in lines) else _with_anchors(lines)
    # A text of fewer lines than before leaves out the last places.
    return "".join(one._replace(text=text).element for one, text in zip(placed, new, strict=False))


@cache
def _letter_widths(text: str, size: float) -> float:
    """Return the width of a text in the font of the figures."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    properties = FontProperties(family="DejaVu Sans", size=size)
    return float(text_to_path.get_text_width_height_descent(text, properties, ismath=False)[0])


def _english_width(line: _Line) -> float:
    """Return the width of a line in units of the file."""
    return _letter_widths(line.text, line.size)


def _with_anchors(lines: list[_Line]) -> list[_Line]:
    """Return lines that begin at their places with an anchor where they are aligned: start, middle or end.

    A rotated text is centred. Several lines are aligned where their places differ least.
    """
    starts = [one.start for one in lines if one.start is not None]
    if len(starts) < len(lines):
        return lines
    widths = [_english_width(one) for one in lines]
    rotated = any(turn for _, _, turn in starts)
    if len(lines) == 1 and not rotated:
        return lines
    shifts = {"middle": 0.5, "start": 0.0, "end": 1.0}
    spreads = {
        anchor: _spread([x + share * width for (x, _, _), width in zip(starts, widths, strict=True)])
        for anchor, share in shifts.items()
    }
    anchor = "middle" if rotated else min(spreads, key=lambda name: (round(spreads[name], 1), name != "middle"))
    anchored = []
    for line, (x, y, turn), width in zip(lines, starts, widths, strict=True):
        along, angle = shifts[anchor] * width, math.radians(turn)
        place = f"translate({x + along * math.cos(angle):.2f} {y + along * math.sin(angle):.2f})"
        rotation = f" rotate({turn:g})" if turn else ""
        style = line.style.replace("fill:", f"text-anchor: {anchor}; fill:", 1)
        anchored.append(line._replace(style=style, attributes=f' transform="{place}{rotation}"'))
    return anchored


def _spread(values: list[float]) -> float:
    """Return the range of some values."""
    return max(values) - min(values)


def character_width(character: str) -> float:
    """Return the width of a character in units of the font size: 1 for Chinese and Japanese ones, 0.6 for others."""
    return 1.0 if ord(character) >= 0x2E80 else 0.6


def break_lines(lines: list[str], width: float, most_lines: int) -> list[str]:
    """Return lines broken at a width, in units of the font size, or at a larger one if there are too many then."""
    broken = [part for line in lines for part in _break_line(line, width)]
    return broken if len(broken) <= most_lines else break_lines(lines, 1.1 * width, most_lines)


def _break_line(line: str, width: float) -> list[str]:
    """Return the parts of a line at most as wide as a width: broken before a word or a Japanese character."""
    parts, current, used = list[str](), "", 0.0
    for piece in re.findall(r"[\x21-\x7e°µα−–]+|.", line):
        wide = sum(map(character_width, piece))
        if current and used + wide > width and piece[0] not in _NO_LINE_START:
            parts.append(current.rstrip())
            current, used = "", 0.0
        if current or not piece.isspace():
            current, used = current + piece, used + wide
    return [*parts, current.rstrip()] if current else parts or [""]
