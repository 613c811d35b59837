"""The report as one self-contained HTML page. No words of the report stand here, and all text is escaped."""

import base64
import re
from html import escape
from importlib import resources
from itertools import count
from pathlib import Path
from typing import assert_never

from overturning.figures.film_page import embedded_json, player_script, player_style
from overturning.report.blocks import (
    Answer,
    Block,
    Bullets,
    Caution,
    Code,
    Column,
    Disclosure,
    Figure,
    Film,
    Note,
    Paragraph,
    Report,
    Row,
    Section,
    Table,
)


def render_html(report: Report) -> str:
    """The page.

    Parameters
    ----------
    report : Report
        What it says.

    Returns
    -------
    str
        HTML that needs nothing from outside.
    """
    title, style, script = (
        escape(report.title),
        _file("report.css") + player_style(),
        _file("sort.js") + player_script(),
    )
    question = f'<p class="question">{escape(report.question)}</p>\n' if report.question else ""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>\n{style}\n</style>\n</head>\n<body>\n"
        f"<header>\n<h1>{title}</h1>\n{question}</header>\n<main>\n{_Page().blocks(report.sections, 2)}\n</main>\n"
        f"<script>\n{script}\n</script>\n</body>\n</html>\n"
    )


def _file(name: str) -> str:
    return resources.files("overturning").joinpath("report/templates", name).read_text(encoding="utf-8")


class _Page:
    """The body of one page, whose figures are numbered."""

    def __init__(self) -> None:
        self.numbers = count(1)

    def blocks(self, blocks: tuple[Block, ...], level: int) -> str:
        return "\n".join(filter(None, (self.block(block, level) for block in blocks)))

    def block(self, block: Block, level: int) -> str:
        match block:
            case Paragraph():
                kind = {Note: ' class="note"', Caution: ' class="warning"'}.get(type(block), "")
                return "" if block.medium == "paper" else f"<p{kind}>{escape(block.text)}</p>"
            case Answer():
                lines = "\n".join(f"<p>{escape(sentence)}</p>" for sentence in block.sentences)
                return f'<div class="answer">\n{lines}\n</div>'
            case Bullets():
                lines = "\n".join(f"<li>{escape(line)}</li>" for line in block.lines)
                return f"<ul>\n{lines}\n</ul>"
            case Code():
                return f"<pre>{escape(block.text)}</pre>"
            case Figure():
                return self.figure(block)
            case Table():
                return _table(block)
            case Film():
                return f'<div class="film"><script type="application/json">{embedded_json(block.data)}</script></div>'
            case Row():
                return f'<div class="pair">\n{self.blocks(block.blocks, level)}\n</div>'
            case Disclosure():
                inside = self.blocks(block.blocks, level)
                return f"<details><summary>{escape(block.title)}</summary>\n{inside}\n</details>"
            case Section():
                name = "article" if block.together else "section"
                head = f"<{name}{_anchor(block.anchor)}>\n<h{level}>{escape(block.title)}</h{level}>"
                return f"{head}\n{self.blocks(block.blocks, level + 1)}\n</{name}>"
            case _:
                assert_never(block)

    def figure(self, figure: Figure) -> str:
        shown = inline_figure(figure.path, figure.alt, f"figure-{next(self.numbers)}")
        caption = f"<figcaption>{escape(figure.caption)}</figcaption>" if figure.caption else ""
        return f"<figure>{shown}{caption}</figure>"


def _anchor(name: str) -> str:
    return f' id="{escape(name)}"' if name else ""


def _table(table: Table) -> str:
    heads = "".join(_cell("th", column, escape(column.head)) for column in table.columns)
    head = f"<thead><tr>{heads}</tr></thead>\n" if any(column.head for column in table.columns) else ""
    rows = []
    for row in table.rows:
        cells = []
        for column, text in zip(table.columns, row, strict=True):
            shown = escape(text)
            if column.kind == "link":
                shown = f'<a href="#{shown}">{shown}</a>'
            elif column.kind == "code":
                shown = f"<code>{shown}</code>"
            cells.append(_cell("td", column, shown))
        rows.append(f"<tr>{''.join(cells)}</tr>")
    kind = ' class="sortable"' if table.sortable else ""
    body = "\n".join(rows)
    return (
        f'<div class="wide">\n<table{kind}{_anchor(table.anchor)}>\n{head}<tbody>\n{body}\n</tbody>\n</table>\n</div>'
    )


def _cell(tag: str, column: Column, text: str) -> str:
    kind = ' class="n"' if column.kind == "number" else ""
    return f"<{tag}{kind}>{text}</{tag}>"


def inline_figure(path: Path, alt: str, name: str) -> str:
    """A figure to stand inside a page: an SVG as an element, a PNG as data.

    Parameters
    ----------
    path : Path
        The figure, .svg or .png.
    alt : str
        What it shows, for those who cannot see it.
    name : str
        Put before the identifiers of an SVG, since those of two figures would otherwise be one in the page.

    Returns
    -------
    str
        HTML.
    """
    if path.suffix != ".svg":
        data = base64.b64encode(path.read_bytes()).decode("ascii")
        return f'<img alt="{escape(alt)}" src="data:image/png;base64,{data}">'
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'(\bid="|xlink:href="#|href="#|url\(#)', rf"\g<1>{name}-", text)
    attributes = f'role="img" aria-label="{escape(alt)}"'
    if size := re.search(r'<svg[^>]*? width="([0-9.]+)pt"', text):
        # As wide as it was drawn where there is room, so that its letters are as large as those around it.
        attributes += f' style="width:100%;max-width:{float(size[1]) * 4 / 3 / 16:.1f}rem"'
        for side in ("width", "height"):
            text = re.sub(rf'(<svg[^>]*?) {side}="[0-9.]+pt"', r"\1", text, count=1)
    return text.replace("<svg", f"<svg {attributes}", 1)
