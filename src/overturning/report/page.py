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
    markdown_tree: SyntaxTreeNode,
    page_title: str,
    language: str,
    figure_path_by_name: Mapping[str, Path] | None,
    film_html_by_name: Mapping[str, str],
) -> str:
    """Return the HTML page of a report, which loads nothing from the network.

    Parameters
    ----------
    markdown_tree : SyntaxTreeNode
        Text of the report, from `render.parse_markdown_and_number_figures_and_tables`.
    page_title : str
        Title of the page.
    language : str
        Code of the language.
    figure_path_by_name : mapping of str to Path, or None
        Files of the figures (.svg or .png) by the names that the text uses. None: a page without figures, which shows
        their alternative text.
    film_html_by_name : mapping of str to str
        Elements of the films (`figures.page.film_html_element`) by the names that the text uses.

    Raises
    ------
    ResultError
        If the text uses a figure that does not exist.
    """
    style, script = (read_template_text(name, "report") for name in ("report.css", "report.js"))
    body = "\n".join(
        _MarkdownToReportPageConverter(
            figure_path_by_name, film_html_by_name, read_label_translations(language)
        ).html_of_markdown_nodes(markdown_tree.children)
    )
    return (
        f'<!DOCTYPE html>\n<html lang="{language}">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(page_title)}</title>\n"
        f"<style>\n{style}{read_template_text('player.css')}\n</style>\n</head>\n<body>\n"
        f"<main>\n{body}\n</main>\n<script>\n{script}{film_player_script()}\n</script>\n</body>\n</html>\n"
    )


class _MarkdownToReportPageConverter:
    """Converter of a report's Markdown nodes to the HTML inside the ``main`` element of its page.

    Attributes
    ----------
    figure_path_by_name, film_html_by_name : mapping
        Files of the figures, and HTML elements of the films, by the names that the text uses.
    label_translation_by_english_text : mapping
        Words of the language; see `overturning.translation.texts.read_label_translations`.
    """

    def __init__(
        self,
        figure_path_by_name: Mapping[str, Path] | None,
        film_html_by_name: Mapping[str, str],
        label_translation_by_english_text: Mapping[str, str],
    ) -> None:
        self.figures, self.films, self.labels, self.inlined = (
            figure_path_by_name,
            film_html_by_name,
            label_translation_by_english_text,
            count(1),
        )

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
        self,
        container_node: SyntaxTreeNode,
        container_name: str,
        text_after_container_name: str,
        loads_images_lazily: bool,
    ) -> Iterator[str]:
        """Yield the HTML of a Markdown container (``::: name text``), such as a film or a collapsible section.

        A container ``paper`` is shown in the PDF only.
        """
        if container_name == "paper":
            return
        inner = "\n".join(
            self.html_of_markdown_nodes(
                container_node.children, loads_images_lazily or container_name == CONTAINER_WITH_LAZY_IMAGES
            )
        )
        if container_name == "fold":
            summary = _html_of_inline_markdown(parse_markdown_line(text_after_container_name))
            yield f"<details{_html_id_attribute(container_node)}><summary>{summary}</summary>\n{inner}\n</details>"
        elif container_name in ("table", "sortable"):
            number = container_node.meta["table"]
            caption = self.caption_html(
                "table", number, _html_of_inline_markdown(parse_markdown_line(text_after_container_name))
            )
            kind = ' class="sortable"' if container_name == "sortable" else ""
            yield inner.replace(
                "<table>", f"<table{kind}{_html_id_attribute(container_node)}>\n<caption>{caption}</caption>", 1
            )
        elif container_name == "film":
            yield f'<figure class="film-figure">{self.films.get(text_after_container_name, "")}\n{inner}</figure>'
        elif container_name == "page":
            yield inner
        else:
            yield f'<div class="{container_name}">\n{inner}\n</div>'

    def caption_html(
        self, figure_or_table_label_key: str, figure_or_table_number: int | None, caption_html_text: str
    ) -> str:
        """Return the HTML of a figure or table caption, with the number (if any) in bold."""
        return (
            f"<b>{self.labels[figure_or_table_label_key].format(figure_or_table_number)}</b> {caption_html_text}"
            if figure_or_table_number
            else caption_html_text
        )

    def figure_html(self, image_node: SyntaxTreeNode, figure_number: int | None, loads_images_lazily: bool) -> str:
        """Return the HTML of a figure with number and caption, and of its version for phones if there is one."""
        name = unquote(str(image_node.attrs["src"]))
        caption = self.caption_html("figure", figure_number, escape(str(image_node.attrs.get("title", ""))))
        if self.figures is None:
            return f"<figure>{escape(image_node.content)}<figcaption>{caption}</figcaption></figure>"
        if name not in self.figures or not self.figures[name].is_file():
            raise ResultError(f"figure {name}: no such figure; run the figures of the study first")
        shown = _embedded_figure_html(
            self.figures[name], image_node.content, f"figure-{next(self.inlined)}", loads_images_lazily
        )
        if (narrow := self.figures.get(f"{PHONE_FIGURE_PREFIX}{name}")) is not None and not loads_images_lazily:
            phone = _embedded_figure_html(
                narrow, image_node.content, f"figure-{next(self.inlined)}", loads_images_lazily
            )
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


def _html_of_table_head_or_body(table_head_or_body: SyntaxTreeNode) -> str:
    """Return the HTML of the head or body of a table; right-aligned cells have the class ``n``."""
    rows = []
    for row in table_head_or_body.children:
        cells = []
        for cell in row.children:
            numeric = ' class="n"' if "right" in str(cell.attrs.get("style", "")) else ""
            cells.append(f"<{cell.tag}{numeric}>{_html_of_inline_markdown(cell)}</{cell.tag}>")
        rows.append(f"<tr>{''.join(cells)}</tr>\n")
    tag = _HTML_TAG_BY_NODE_TYPE[table_head_or_body.type]
    return f"<{tag}>\n{''.join(rows)}</{tag}>\n"


def _embedded_figure_html(
    figure_path: Path, alternative_text: str, unique_id_prefix: str, loads_images_lazily: bool
) -> str:
    """Return the HTML that embeds a figure file: an SVG as ``svg`` element with unique ids, a PNG as image data.

    If `loads_images_lazily` (in a collapsible section), an SVG is embedded as image data too, so that the page is
    lighter.
    """
    if figure_path.suffix != ".svg" or loads_images_lazily:
        kind = "svg+xml" if figure_path.suffix == ".svg" else "png"
        data = base64.b64encode(figure_path.read_bytes()).decode("ascii")
        return f'<img alt="{escape(alternative_text)}" loading="lazy" src="data:image/{kind};base64,{data}">'
    text = figure_path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r'(\bid="|xlink:href="#|href="#|url\(#)', rf"\g<1>{unique_id_prefix}-", text)
    attributes = f'role="img" aria-label="{escape(alternative_text)}"'
    if size := re.search(r'<svg[^>]*? width="([0-9.]+)pt"', text):
        # As wide as it was drawn if there is room, so that its letters are as large as those around it.
        attributes += f' style="--full:{float(size[1]) * 4 / 3 / 16:.1f}rem"'
        for side in ("width", "height"):
            text = re.sub(rf'(<svg[^>]*?) {side}="[0-9.]+pt"', r"\1", text, count=1)
    return text.replace("<svg", f"<svg {attributes}", 1)
