"""Text of the report: from findings through the templates of a language to Markdown and its tokens."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from itertools import count
from typing import Any, Final

import jinja2
from markdown_it import MarkdownIt
from markdown_it.tree import SyntaxTreeNode
from markupsafe import Markup
from mdit_py_plugins.attrs import attrs_block_plugin
from mdit_py_plugins.container import container_plugin
from pydantic import BaseModel

from overturning.errors import ResultError
from overturning.report.filters import FILTERS_WITH_WORD_BETWEEN_INTERVAL_ENDS, LANGUAGE_INDEPENDENT_TEMPLATE_FILTERS
from overturning.translation.texts import LANGUAGES, read_label_translations, translate, translate_whole_text_by_table

MARKDOWN_CONTAINER_NAMES: Final = (
    "kicker", "answer", "limits", "note", "caution", "pair", "film", "fold", "table", "sortable", "page", "paper"
)  # fmt: skip
"""Containers of the Markdown (``::: name text``): how a part of the text looks, or on which medium it is shown."""

MARKDOWN_SPECIAL_CHARACTERS: Final = frozenset("\\`*_{}[]<>#|~!&$\"'^:")
"""Characters with a meaning in Markdown."""


@dataclass(frozen=True)
class ReportMedia:
    """Films and figures that exist for a report, as its templates need them.

    Attributes
    ----------
    films : sequence
        Texts about each film (`overturning.report.write.TextsAboutReportFilm`).
    figure_names_by_record : mapping of str to tuple of str
        Names of the figures in the chapter of each record, by record id.
    explorer_address : str
        Address of the explorer; empty if there is none.
    station_map_names : sequence of str
        Names of the maps of the stations.
    has_rose_of_all_falls, has_posterior_figures : bool
        True if there is a rose of all falls, or figures of the inferred motions.
    """

    films: Sequence[Any] = ()
    figure_names_by_record: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    explorer_address: str = ""
    station_map_names: Sequence[str] = ()
    has_rose_of_all_falls: bool = False
    has_posterior_figures: bool = False


def render_template_as_markdown(
    findings: BaseModel,
    language: str = "en",
    films_and_figures: ReportMedia | None = None,
    template_name: str = "report",
) -> str:
    """Render a template of the report as Markdown text in one language.

    Parameters
    ----------
    findings : Findings or another part of findings
        Numbers; a template shows nothing else, besides films and figures.
    language : str, default "en"
        Language of the templates, one of `LANGUAGES`.
    films_and_figures : ReportMedia, optional
        Films and figures that exist.
    template_name : str, default "report"
        Name of the template: ``report``, or that of one section.

    Returns
    -------
    str
        Markdown; characters of values that have a meaning in Markdown are escaped.

    Raises
    ------
    ResultError
        If there are no templates of this language.
    """
    return (
        create_template_environment(language)
        .get_template(f"{template_name}.md.j2")
        .render(f=findings, media=films_and_figures or ReportMedia())
    )


@cache
def create_template_environment(language: str) -> jinja2.Environment:
    """Return the Jinja environment for the report templates of a language; a `ResultError` if there are none."""
    if language not in LANGUAGES:
        raise ResultError(f"language {language}: no report in this language; choose one of {', '.join(LANGUAGES)}")
    labels = read_label_translations(language)
    loaded = jinja2.Environment(
        loader=jinja2.PackageLoader("overturning", f"report/templates/{language}"),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        finalize=escape_markdown,
        trim_blocks=True,
        lstrip_blocks=True,
        # "{#name}" is an anchor of the Markdown.
        comment_start_string="<#",
        comment_end_string="#>",
    )
    loaded.filters |= LANGUAGE_INDEPENDENT_TEMPLATE_FILTERS
    loaded.filters |= {
        name: partial(each, word_between_ends=labels["to"])
        for name, each in FILTERS_WITH_WORD_BETWEEN_INTERVAL_ENDS.items()
    }
    loaded.filters["label"] = partial(translate_whole_text_by_table, translation_table=labels)
    loaded.filters["translated"] = partial(translate, language=language)
    loaded.tests["infinite"] = math.isinf
    return loaded


def escape_markdown(template_value: Any) -> Markup:
    """Convert a value to Markdown text: special characters are escaped, and line ends become spaces."""
    if isinstance(template_value, Markup):
        return template_value
    text = "" if template_value is None else " ".join(str(template_value).split("\n"))
    return Markup("".join(f"\\{one}" if one in MARKDOWN_SPECIAL_CHARACTERS else one for one in text))


def parse_markdown_and_number_figures_and_tables(markdown_text: str) -> SyntaxTreeNode:
    """Parse the report's Markdown to a syntax tree; number figures and tables outside collapsible sections.

    The number is stored in ``meta["figure"]`` of a paragraph that contains only an image, and in ``meta["table"]`` of a
    container ``table`` or ``sortable``. It is None in a container ``fold``, ``page`` or ``paper``.
    """
    parser = MarkdownIt("commonmark", {"html": False}).enable("table").use(attrs_block_plugin)
    for name in MARKDOWN_CONTAINER_NAMES:
        parser.use(container_plugin, name=name)
    tree = SyntaxTreeNode(parser.parse(markdown_text))
    numbers = {"figure": count(1), "table": count(1)}
    for node, is_collapsed in _nodes_and_whether_collapsed_or_in_one_format(tree):
        kind = (
            "figure"
            if single_image_of_paragraph(node)
            else "table"
            if markdown_container_name_and_text(node)[0] in ("table", "sortable")
            else ""
        )
        if kind:
            node.meta[kind] = None if is_collapsed else next(numbers[kind])
    return tree


def _nodes_and_whether_collapsed_or_in_one_format(
    node: SyntaxTreeNode, node_is_collapsed_or_in_one_format: bool = False
) -> Iterator[tuple[SyntaxTreeNode, bool]]:
    """Yield each node of a Markdown tree, and True if it is collapsed or only on the HTML page or in the PDF."""
    for one in node.children:
        yield one, node_is_collapsed_or_in_one_format
        yield from _nodes_and_whether_collapsed_or_in_one_format(
            one,
            node_is_collapsed_or_in_one_format or markdown_container_name_and_text(one)[0] in ("fold", "page", "paper"),
        )


def markdown_container_name_and_text(node: SyntaxTreeNode) -> tuple[str, str]:
    """Return name and text of a Markdown container, ``::: name text``; two empty texts for other nodes."""
    if not node.type.startswith("container_"):
        return "", ""
    name, _, text = node.info.strip().partition(" ")
    return name, text.strip()


def single_image_of_paragraph(node: SyntaxTreeNode) -> SyntaxTreeNode | None:
    """Return the image in a paragraph that contains nothing else; None for all other nodes."""
    if node.type == "paragraph" and len(node.children) == 1:
        inline = node.children[0].children
        if len(inline) == 1 and inline[0].type == "image":
            return inline[0]
    return None


def parse_markdown_line(markdown_line: str) -> SyntaxTreeNode:
    """Parse a single line of Markdown, such as the caption of a table, to a syntax tree."""
    return SyntaxTreeNode(MarkdownIt("commonmark", {"html": False}).parseInline(markdown_line))
