"""Text of the report's templates for a terminal: sentences and tables without markup."""

from collections.abc import Iterator
from itertools import chain

from markdown_it.tree import SyntaxTreeNode

from overturning.report.render import markdown_container_name_and_text, single_image_of_paragraph

MARKDOWN_CONTAINERS_LEFT_OUT_OF_TERMINAL = ("page", "paper")
"""Containers that a terminal does not show."""


def terminal_lines_of_markdown(markdown_tree: SyntaxTreeNode) -> Iterator[str]:
    """Yield the lines of a Markdown text for a terminal: paragraphs and aligned tables, with empty lines between."""
    blocks = (block for block in _terminal_lines_by_block(markdown_tree.children) if block)
    yield from chain.from_iterable(["", *block] if place else block for place, block in enumerate(blocks))


def plain_text_of_uncollapsed_paragraphs(markdown_tree: SyntaxTreeNode) -> Iterator[str]:
    """Yield the paragraphs of a Markdown text outside collapsible sections, without markup."""
    for node in markdown_tree.children:
        if markdown_container_name_and_text(node)[0] in (
            *MARKDOWN_CONTAINERS_LEFT_OUT_OF_TERMINAL,
            "fold",
        ) or single_image_of_paragraph(node):
            continue
        if node.type == "paragraph":
            yield plain_text(node)
        elif node.type not in ("heading", "table"):
            yield from plain_text_of_uncollapsed_paragraphs(node)


def _terminal_lines_by_block(nodes: list[SyntaxTreeNode]) -> Iterator[list[str]]:
    """Yield, for each paragraph, heading, table and block of code, its lines for a terminal; figures are left out."""
    for node in nodes:
        if markdown_container_name_and_text(node)[
            0
        ] in MARKDOWN_CONTAINERS_LEFT_OUT_OF_TERMINAL or single_image_of_paragraph(node):
            continue
        if node.type == "table":
            yield _terminal_lines_of_table(node)
        elif node.type in ("paragraph", "heading"):
            yield plain_text(node).split("\n")
        elif node.type in ("fence", "code_block"):
            yield node.content.rstrip("\n").split("\n")
        else:
            yield from _terminal_lines_by_block(node.children)


def _terminal_lines_of_table(table_node: SyntaxTreeNode) -> list[str]:
    """Return the rows of a Markdown table as lines of text with aligned columns."""
    rows = [row for group in table_node.children for row in group.children]
    texts = [[plain_text(cell) for cell in row.children] for row in rows]
    right = ["right" in str(cell.attrs.get("style", "")) for cell in rows[0].children]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    lines = []
    for row in texts:
        cells = zip(right, row, widths, strict=True)
        lines.append(("  " + "  ".join(text.rjust(w) if r else text.ljust(w) for r, text, w in cells)).rstrip())
    return lines


def plain_text(node: SyntaxTreeNode) -> str:
    """Return the text inside a Markdown node, without markup."""
    if node.type in ("softbreak", "hardbreak"):
        return " "
    return "".join(map(plain_text, node.children)) if node.children else node.content
