"""The report as one self-contained HTML page: tokens of its Markdown to HTML, figures inlined."""

import base64
import re
from collections.abc import Iterator, Mapping
from html import escape
from itertools import count
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from markdown_it.tree import SyntaxTreeNode

from overturning.errors import ResultError
from overturning.figures.page import film_player_script, read_template_text
from overturning.report.drawings import PHONE_FIGURE_PREFIX
from overturning.report.render import markdown_container_name_and_text, parse_markdown_line, single_image_of_paragraph
from overturning.translation.texts import read_label_translations

CONTAINER_WITH_LAZY_IMAGES: Final = "fold"
"""Container whose figures are images, which a browser reads when they come into view."""

_HTML_TAG_BY_NODE_TYPE: Final = {
    "paragraph": "p", "strong": "strong", "em": "em", "bullet_list": "ul", "ordered_list": "ol", "list_item": "li",
    "blockquote": "blockquote", "thead": "thead", "tbody": "tbody", "tr": "tr",
}  # fmt: skip


def render_report_html_page(
    tree: SyntaxTreeNode,
    title: str,
    language: str,
    figures: Mapping[str, Path] | None,
    films: Mapping[str, str],
) -> str:
    """Return the HTML page of a report, which loads nothing from the network.

    Parameters
    ----------
    tree : SyntaxTreeNode
        Text of the report, from `render.parse_markdown`.
    title : str
        Title of the page.
    language : str
        Code of the language.
    figures : mapping of str to Path, or None
        Files of the figures (.svg or .png) by the names that the text uses. None: a page without figures, which shows
        their alternative text.
    films : mapping of str to str
        Elements of the films (`figures.page.film_html_element`) by the names that the text uses.

    Raises
    ------
    ResultError
        If the text uses a figure that does not exist.
    """
    style, script = (read_template_text(name, "report") for name in ("report.css", "report.js"))
    body = "\n".join(
        _ReportPageBody(figures, films, read_label_translations(language)).html_of_markdown_nodes(tree.children)
    )
    return (
        f'<!DOCTYPE html>\n<html lang="{language}">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n"
        f"<style>\n{style}{read_template_text('player.css')}\n</style>\n</head>\n<body>\n"
        f"<main>\n{body}\n</main>\n<script>\n{script}{film_player_script()}\n</script>\n</body>\n</html>\n"
    )


class _ReportPageBody:
    """Converter of a report's Markdown nodes to the HTML inside the ``main`` element of its page.

    Attributes
    ----------
    figures, films : mapping
        Files of the figures, and elements of the films, by name.
    labels : mapping
        Words of the language; see `overturning.translation.texts.read_label_translations`.
    """

    def __init__(self, figures: Mapping[str, Path] | None, films: Mapping[str, str], labels: Mapping[str, str]) -> None:
        self.figures, self.films, self.labels, self.inlined = figures, films, labels, count(1)

    def html_of_markdown_nodes(self, nodes: list[SyntaxTreeNode], loads_images_lazily: bool = False) -> Iterator[str]:
        """Yield the HTML of paragraphs, headings, lists, tables, figures and containers of the report.

        If `loads_images_lazily`, figures are images that a browser reads when they come into view.
        """
        for node in nodes:
            name, text = markdown_container_name_and_text(node)
            if name:
                yield from self.html_of_markdown_container(node, name, text, loads_images_lazily)
            elif image := single_image_of_paragraph(node):
                yield self.figure_html(image, node.meta["figure"], loads_images_lazily)
            elif node.type == "heading":
                yield f"<{node.tag}{_html_id_attribute(node)}>{_html_of_inline_markdown(node)}</{node.tag}>"
            elif node.type in ("fence", "code_block"):
                yield f"<pre>{escape(node.content)}</pre>"
            elif node.type == "table":
                parts = "".join(map(_html_of_table_head_or_body, node.children))
                yield f'<div class="wide">\n<table>\n{parts}</table>\n</div>'
            elif node.type in ("bullet_list", "ordered_list", "list_item", "blockquote"):
                tag = _HTML_TAG_BY_NODE_TYPE[node.type]
                yield f"<{tag}>{''.join(self.html_of_markdown_nodes(node.children, loads_images_lazily))}</{tag}>"
            elif node.type == "paragraph":
                inner = _html_of_inline_markdown(node)
                yield inner if node.hidden else f"<p>{inner}</p>"
            else:
                yield from self.html_of_markdown_nodes(node.children, loads_images_lazily)

    def html_of_markdown_container(
        self, node: SyntaxTreeNode, name: str, text: str, loads_images_lazily: bool
    ) -> Iterator[str]:
        """Yield the HTML of a Markdown container (``::: name text``), such as a film or a collapsible section.

        A container ``paper`` is shown in the PDF only.
        """
        if name == "paper":
            return
        inner = "\n".join(
            self.html_of_markdown_nodes(node.children, loads_images_lazily or name == CONTAINER_WITH_LAZY_IMAGES)
        )
        if name == "fold":
            summary = _html_of_inline_markdown(parse_markdown_line(text))
            yield f"<details{_html_id_attribute(node)}><summary>{summary}</summary>\n{inner}\n</details>"
        elif name in ("table", "sortable"):
            number = node.meta["table"]
            caption = self.caption_html("table", number, _html_of_inline_markdown(parse_markdown_line(text)))
            kind = ' class="sortable"' if name == "sortable" else ""
            yield inner.replace("<table>", f"<table{kind}{_html_id_attribute(node)}>\n<caption>{caption}</caption>", 1)
        elif name == "film":
            yield f'<figure class="film-figure">{self.films.get(text, "")}\n{inner}</figure>'
        elif name == "page":
            yield inner
        else:
            yield f'<div class="{name}">\n{inner}\n</div>'

    def caption_html(self, kind: str, number: int | None, text: str) -> str:
        """Return the HTML of a figure or table caption, with the number (if any) in bold."""
        return f"<b>{self.labels[kind].format(number)}</b> {text}" if number else text

    def figure_html(self, image: SyntaxTreeNode, number: int | None, loads_images_lazily: bool) -> str:
        """Return the HTML of a figure with number and caption, and of its version for phones if there is one."""
        name = unquote(str(image.attrs["src"]))
        caption = self.caption_html("figure", number, escape(str(image.attrs.get("title", ""))))
        if self.figures is None:
            return f"<figure>{escape(image.content)}<figcaption>{caption}</figcaption></figure>"
        if name not in self.figures or not self.figures[name].is_file():
            raise ResultError(f"figure {name}: no such figure; run the figures of the study first")
        shown = _embedded_figure_html(
            self.figures[name], image.content, f"figure-{next(self.inlined)}", loads_images_lazily
        )
        if (narrow := self.figures.get(f"{PHONE_FIGURE_PREFIX}{name}")) is not None and not loads_images_lazily:
            phone = _embedded_figure_html(narrow, image.content, f"figure-{next(self.inlined)}", loads_images_lazily)
            shown = f'<div class="broad">{shown}</div><div class="narrow">{phone}</div>'
        return f"<figure>{shown}{f'<figcaption>{caption}</figcaption>' if caption else ''}</figure>"


def _html_id_attribute(node: SyntaxTreeNode) -> str:
    """Return the HTML attribute ``id`` of a Markdown node that is a link target; "" for other nodes."""
    return f' id="{escape(str(node.attrs["id"]))}"' if "id" in node.attrs else ""


def _html_of_inline_markdown(node: SyntaxTreeNode) -> str:
    """Return the HTML of the text inside a paragraph, heading or table cell, with links and emphasis."""
    parts = []
    for one in node.children:
        if one.type in ("strong", "em"):
            tag = _HTML_TAG_BY_NODE_TYPE[one.type]
            parts.append(f"<{tag}>{_html_of_inline_markdown(one)}</{tag}>")
        elif one.type == "link":
            parts.append(f'<a href="{escape(str(one.attrs["href"]))}">{_html_of_inline_markdown(one)}</a>')
        elif one.type == "code_inline":
            parts.append(f"<code>{escape(one.content)}</code>")
        elif one.type in ("softbreak", "hardbreak"):
            parts.append("\n" if one.type == "softbreak" else "<br>")
        else:
            parts.append(_html_of_inline_markdown(one) if one.children else escape(one.content))
    return "".join(parts)


def _html_of_table_head_or_body(group: SyntaxTreeNode) -> str:
    """Return the HTML of the head or body of a table; right-aligned cells have the class ``n``."""
    rows = []
    for row in group.children:
        cells = []
        for cell in row.children:
            numeric = ' class="n"' if "right" in str(cell.attrs.get("style", "")) else ""
            cells.append(f"<{cell.tag}{numeric}>{_html_of_inline_markdown(cell)}</{cell.tag}>")
        rows.append(f"<tr>{''.join(cells)}</tr>\n")
    return f"<{_HTML_TAG_BY_NODE_TYPE[group.type]}>\n{''.join(rows)}</{_HTML_TAG_BY_NODE_TYPE[group.type]}>\n"


def _embedded_figure_html(path: Path, alt: str, name: str, loads_images_lazily: bool) -> str:
    """Return the HTML that embeds a figure file in the page: an SVG as element with unique ids, else image data.

    If `loads_images_lazily` (inside a fold), an SVG is also embedded as image data, so that the page is lighter.
    """
    if path.suffix != ".svg" or loads_images_lazily:
        kind = "svg+xml" if path.suffix == ".svg" else "png"
        data = base64.b64encode(path.read_bytes()).decode("ascii")
        return f'<img alt="{escape(alt)}" loading="lazy" src="data:image/{kind};base64,{data}">'
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r'(\bid="|xlink:href="#|href="#|url\(#)', rf"\g<1>{name}-", text)
    attributes = f'role="img" aria-label="{escape(alt)}"'
    if size := re.search(r'<svg[^>]*? width="([0-9.]+)pt"', text):
        # As wide as it was drawn if there is room, so that its letters are as large as those around it.
        attributes += f' style="--full:{float(size[1]) * 4 / 3 / 16:.1f}rem"'
        for side in ("width", "height"):
            text = re.sub(rf'(<svg[^>]*?) {side}="[0-9.]+pt"', r"\1", text, count=1)
    return text.replace("<svg", f"<svg {attributes}", 1)
