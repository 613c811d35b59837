"""The report as one self-contained HTML page. No words of the report stand here, and all text is escaped."""

import base64
import re
from collections.abc import Iterator
from html import escape
from itertools import count
from pathlib import Path
from typing import assert_never
from urllib.parse import quote

from overturning.figures.page import film_element, film_player_script, read_template
from overturning.report import blocks


def pieces_of(report: blocks.Report) -> Iterator[str]:
    """The page, which needs nothing from outside, in pieces: with many figures it need not be in memory at once."""
    title = escape(report.title)
    style, script = (read_template(name, "report") for name in ("report.css", "sort.js"))
    question = f'<p class="question">{escape(report.question)}</p>\n' if report.question else ""
    yield (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>\n{style}{read_template('player.css')}\n</style>\n</head>\n<body>\n"
        f"<header>\n<h1>{title}</h1>\n{question}</header>\n{_contents(report)}\n<main>\n"
    )
    yield from _Page().inside(report, 2)
    yield f"\n</main>\n<script>\n{script}{film_player_script()}\n</script>\n</body>\n</html>\n"


def _contents(report: blocks.Report) -> str:
    """Links to the sections."""
    parts = [part for part in report.blocks if part.anchor]
    links = "".join(f'<li><a href="#{escape(part.anchor)}">{escape(part.title)}</a></li>' for part in parts)
    return f'<nav class="contents"><ol>{links}</ol></nav>' if links else ""


class _Page:
    """The body of one page, whose figures are numbered."""

    def __init__(self) -> None:
        self.numbers = count(1)

    def inside(
        self, block: blocks.Report | blocks.Section | blocks.Row | blocks.Disclosure, level: int
    ) -> Iterator[str]:
        for place, one in enumerate(block.blocks):
            yield "\n" if place else ""
            yield from self.block(one, level)

    def block(self, block: blocks.Block, level: int) -> Iterator[str]:
        match block:
            case blocks.Row():
                before, below, after = '<div class="pair">', level, "</div>"
            case blocks.Disclosure():
                before, below, after = f"<details><summary>{escape(block.title)}</summary>", level, "</details>"
            case blocks.Section():
                tag = "article" if block.together else "section"
                before = f"<{tag}{_anchor(block.anchor)}>\n<h{level}>{escape(block.title)}</h{level}>"
                below, after = level + 1, f"</{tag}>"
            case _:
                yield self.leaf(block)
                return
        yield f"{before}\n"
        yield from self.inside(block, below)
        yield f"\n{after}"

    def leaf(self, block: blocks.Leaf) -> str:
        match block:
            case blocks.Paragraph():
                kind = {blocks.Note: ' class="note"', blocks.Caution: ' class="warning"'}.get(type(block), "")
                return "" if block.medium == "paper" else f"<p{kind}>{escape(block.text)}</p>"
            case blocks.Answer():
                return f'<div class="answer">\n{_lines("p", block.sentences)}\n</div>'
            case blocks.Link():
                # A colon would make a scheme of what stands before it.
                return f'<p><a href="{escape(quote(block.file))}">{escape(block.text)}</a></p>'
            case blocks.Bullets():
                return f"<ul>\n{_lines('li', block.lines)}\n</ul>"
            case blocks.Code():
                return f"<pre>{escape(block.text)}</pre>"
            case blocks.Figure():
                caption = f"<figcaption>{escape(block.caption)}</figcaption>" if block.caption else ""
                shown = _inline(block.path, block.alt, f"figure-{next(self.numbers)}")
                return f"<figure>{shown}{caption}</figure>"
            case blocks.Table():
                return _table(block)
            case blocks.Film():
                return film_element(block.data, block.strip, block.text)
            case _:
                assert_never(block)


def _lines(tag: str, lines: tuple[str, ...]) -> str:
    return "\n".join(f"<{tag}>{escape(line)}</{tag}>" for line in lines)


def _anchor(name: str) -> str:
    return f' id="{escape(name)}"' if name else ""


def _table(table: blocks.Table) -> str:
    def row(tag: str, cells: tuple[str, ...]) -> str:
        shown = []
        for kind, cell in zip(table.kinds, map(escape, cells), strict=True):
            numeric = ' class="n"' if kind == "n" else ""
            inner = {"l": f'<a href="#{cell}">{cell}</a>', "c": f"<code>{cell}</code>"}.get(kind * (tag == "td"), cell)
            shown.append(f"<{tag}{numeric}>{inner}</{tag}>")
        return f"<tr>{''.join(shown)}</tr>"

    head = f"<thead>{row('th', table.heads)}</thead>\n" if any(table.heads) else ""
    body = "\n".join(row("td", cells) for cells in table.rows)
    kind = ' class="sortable"' if table.sortable else ""
    return (
        f'<div class="wide">\n<table{kind}{_anchor(table.anchor)}>\n{head}<tbody>\n{body}\n</tbody>\n</table>\n</div>'
    )


def _inline(path: Path, alt: str, name: str) -> str:
    """A figure to stand inside a page: a PNG as data, an SVG as an element.

    Its identifiers get the name, which no other figure has, since those of two figures would be one in the page.
    """
    if path.suffix != ".svg":
        data = base64.b64encode(path.read_bytes()).decode("ascii")
        return f'<img alt="{escape(alt)}" src="data:image/png;base64,{data}">'
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r'(\bid="|xlink:href="#|href="#|url\(#)', rf"\g<1>{name}-", text)
    attributes = f'role="img" aria-label="{escape(alt)}"'
    if size := re.search(r'<svg[^>]*? width="([0-9.]+)pt"', text):
        # As wide as it was drawn where there is room, so that its letters are as large as those around it.
        attributes += f' style="--full:{float(size[1]) * 4 / 3 / 16:.1f}rem"'
        for side in ("width", "height"):
            text = re.sub(rf'(<svg[^>]*?) {side}="[0-9.]+pt"', r"\1", text, count=1)
    return text.replace("<svg", f"<svg {attributes}", 1)
