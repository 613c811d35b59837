"""Translation of the texts in an SVG file of Matplotlib, at the places of the English ones."""

import math
import re
from functools import cache
from html import escape, unescape
from typing import Final, NamedTuple

from overturning.translation.texts import ENGLISH, current_language, translate

_TEXT_ELEMENT_PATTERN: Final = re.compile(r'(\s*)<text style="([^"]*)"([^>]*)>([^<]*)</text>')
_ADJACENT_TEXT_ELEMENTS_PATTERN: Final = re.compile(r"(?:\s*<text [^>]*>[^<]*</text>)+")
_TEXT_TRANSFORM_PATTERN: Final = re.compile(r' transform="translate\((\S+) (\S+)\)(?: rotate\((\S+)\))?"')
_FONT_SIZE_PATTERN: Final = re.compile(r"font-size: ([\d.]+)px")

BROWSER_FONTS_BY_LANGUAGE: Final = {"ja": "'Noto Sans CJK JP', 'Hiragino Sans', 'Yu Gothic', 'IPAexGothic'"}
"""Names of fonts of a language that a browser tries before its own choice."""

_CHARACTERS_NOT_AT_LINE_START: Final = "、。，．・：；！？)）」』]％%°ー～,.;"
"""Characters with which no line begins."""


def translate_svg(svg_text: str, language: str | None = None) -> str:
    """Translate the visible texts of an SVG file, by default into the language set by `use_translation_language`.

    A file that is already in the target language is returned unchanged. Positions and alignment stay those of the
    English texts, and a text of several lines has at most as many lines as before.
    """
    language = language or current_language()
    if language == ENGLISH or f'<svg xml:lang="{language}" ' in svg_text:
        return svg_text
    text = _ADJACENT_TEXT_ELEMENTS_PATTERN.sub(lambda lines: _translate_svg_text_lines(lines[0], language), svg_text)
    text = text.replace(
        "Helvetica', 'Avant Garde', sans-serif", f"Helvetica', {BROWSER_FONTS_BY_LANGUAGE[language]}, sans-serif"
    )
    return text.replace("<svg ", f'<svg xml:lang="{language}" ', 1)


class _SvgTextLine(NamedTuple):
    """One line of text in an SVG file: its indentation, style, other attributes (position) and letters."""

    indent: str
    style_attribute: str
    other_attributes: str
    text: str

    @property
    def font_size(self) -> float:
        """Size of the font, in units of the SVG file."""
        found = _FONT_SIZE_PATTERN.search(self.style_attribute)
        return float(found[1]) if found else 10.0

    @property
    def left_aligned_start_xy_and_rotation_deg(self) -> tuple[float, float, float] | None:
        """Position x, y and clockwise rotation, degrees, of the line; None for a centred or right-aligned text."""
        found = _TEXT_TRANSFORM_PATTERN.fullmatch(self.other_attributes)
        return (float(found[1]), float(found[2]), float(found[3] or 0.0)) if found else None

    @property
    def svg_element(self) -> str:
        """SVG element ``text`` with the style, position and letters of the line."""
        attributes = f'style="{self.style_attribute}"{self.other_attributes}'
        return f"{self.indent}<text {attributes}>{escape(self.text, quote=False)}</text>"


def _translate_svg_text_lines(svg_elements_of_text_lines: str, language: str) -> str:
    """Translate a text of one or more lines in an SVG file; return the SVG elements of the translated lines."""
    found = _TEXT_ELEMENT_PATTERN.findall(svg_elements_of_text_lines)
    lines = [_SvgTextLine(indent, style, attributes, unescape(text)) for indent, style, attributes, text in found]
    english = "\n".join(one.text for one in lines)
    translation = translate(english, language)
    if translation == english:
        return svg_elements_of_text_lines
    new = translation.split("\n")
    if len(new) < len(lines):
        new = break_lines_and_widen_to_max_line_count(
            new, max(map(_width_of_line, lines)) / lines[0].font_size, len(lines)
        )
    placed = (
        lines
        if all(one.left_aligned_start_xy_and_rotation_deg is None for one in lines)
        else _anchor_lines_at_start_middle_or_end(lines)
    )
    # A text of fewer lines than before leaves out the last places.
    return "".join(one._replace(text=text).svg_element for one, text in zip(placed, new, strict=False))


@cache
def _text_width(text: str, font_size: float) -> float:
    """Return the width of a text in DejaVu Sans, in the unit of `font_size`."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    properties = FontProperties(family="DejaVu Sans", size=font_size)
    return float(text_to_path.get_text_width_height_descent(text, properties, ismath=False)[0])


def _width_of_line(english_line: _SvgTextLine) -> float:
    """Return the width of a line of English text, in units of the SVG file."""
    return _text_width(english_line.text, english_line.font_size)


def _anchor_lines_at_start_middle_or_end(lines_of_one_text: list[_SvgTextLine]) -> list[_SvgTextLine]:
    """Return the lines of a text with the positions of their starts, middles or ends, whichever are aligned.

    A rotated text is anchored at its middle. Otherwise several lines are anchored where their x coordinates differ
    least. A single horizontal line, and lines that are already centred or right-aligned, stay unchanged.
    """
    starts = [
        one.left_aligned_start_xy_and_rotation_deg
        for one in lines_of_one_text
        if one.left_aligned_start_xy_and_rotation_deg is not None
    ]
    if len(starts) < len(lines_of_one_text):
        return lines_of_one_text
    widths = [_width_of_line(one) for one in lines_of_one_text]
    rotated = any(turn for _, _, turn in starts)
    if len(lines_of_one_text) == 1 and not rotated:
        return lines_of_one_text
    shifts = {"middle": 0.5, "start": 0.0, "end": 1.0}
    spreads = {
        anchor: _largest_minus_smallest([x + share * width for (x, _, _), width in zip(starts, widths, strict=True)])
        for anchor, share in shifts.items()
    }
    anchor = "middle" if rotated else min(spreads, key=lambda name: (round(spreads[name], 1), name != "middle"))
    anchored = []
    for line, (x, y, turn), width in zip(lines_of_one_text, starts, widths, strict=True):
        along, angle = shifts[anchor] * width, math.radians(turn)
        place = f"translate({x + along * math.cos(angle):.2f} {y + along * math.sin(angle):.2f})"
        rotation = f" rotate({turn:g})" if turn else ""
        style = line.style_attribute.replace("fill:", f"text-anchor: {anchor}; fill:", 1)
        anchored.append(line._replace(style_attribute=style, other_attributes=f' transform="{place}{rotation}"'))
    return anchored


def _largest_minus_smallest(values: list[float]) -> float:
    """Return the difference of the largest and the smallest value."""
    return max(values) - min(values)


def character_width_over_font_size(character: str) -> float:
    """Return the width of a character in units of the font size: 1 for Chinese and Japanese ones, 0.6 for others."""
    return 1.0 if ord(character) >= 0x2E80 else 0.6


def break_lines_and_widen_to_max_line_count(
    lines: list[str], max_width_in_font_sizes: float, max_line_count: int
) -> list[str]:
    """Break lines at a width, in font sizes, which grows by 10 % at a time until `max_line_count` lines are enough."""
    broken = [part for line in lines for part in _break_line_at_width(line, max_width_in_font_sizes)]
    return (
        broken
        if len(broken) <= max_line_count
        else break_lines_and_widen_to_max_line_count(lines, 1.1 * max_width_in_font_sizes, max_line_count)
    )


def break_text_at_width(text: str, max_width_inches: float, font_size_pt: float) -> str:
    """Return a text broken into lines of at most a width, inches, for a font of a size, pt."""
    return "\n".join(break_lines_and_widen_to_max_line_count([text], 72.0 * max_width_inches / font_size_pt, 100))


def pad_to_equal_line_count(texts: list[str]) -> tuple[list[str], int]:
    """Add blank lines to texts until all have as many lines as the longest; return the texts and their line count."""
    most = 1 + max(text.count("\n") for text in texts)
    return [text + (most - 1 - text.count("\n")) * "\n " for text in texts], most


def _break_line_at_width(line: str, max_width_in_font_sizes: float) -> list[str]:
    """Break a line into parts no wider than a width (in font sizes), before a word or a Japanese character."""
    parts, current, used = list[str](), "", 0.0
    for piece in re.findall(r"[\x21-\x7e°µα−–]+|.", line):
        wide = sum(map(character_width_over_font_size, piece))
        if current and used + wide > max_width_in_font_sizes and piece[0] not in _CHARACTERS_NOT_AT_LINE_START:
            parts.append(current.rstrip())
            current, used = "", 0.0
        if current or not piece.isspace():
            current, used = current + piece, used + wide
    return [*parts, current.rstrip()] if current else parts or [""]
