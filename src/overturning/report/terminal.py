"""Text of the report's templates for a terminal: sentences and tables without markup."""

from collections.abc import Iterator
from itertools import chain

from markdown_it.tree import SyntaxTreeNode

from overturning.report.render import container_of, picture_of

LEFT_OUT = ("page", "paper")
"""Containers that a terminal does not show."""


def plain_lines(tree: SyntaxTreeNode) -> Iterator[str]:
    """Yield the lines of a text: paragraphs, and tables with aligned columns; an empty line between them."""
    blocks = (block for block in _blocks(tree.children) if block)
    yield from chain.from_iterable(["", *block] if place else block for place, block in enumerate(blocks))


def paragraphs_of(tree: SyntaxTreeNode) -> Iterator[str]:
    """Yield the paragraphs of a text outside folds, without markup."""
    for node in tree.children:
        if container_of(node)[0] in (*LEFT_OUT, "fold") or picture_of(node):
            continue
        if node.type == "paragraph":
            yield text_of(node)
        elif node.type not in ("heading", "table"):
            yield from paragraphs_of(node)


def _blocks(nodes: list[SyntaxTreeNode]) -> Iterator[list[str]]:
    """Yield the lines of each paragraph, heading, table and block of code; figures are left out."""
    for node in nodes:
        if container_of(node)[0] in LEFT_OUT or picture_of(node):
            continue
        if node.type == "table":
            yield _table(node)
        elif node.type in ("paragraph", "heading"):
            yield text_of(node).split("\n")
        elif node.type in ("fence", "code_block"):
            yield node.content.rstrip("\n").split("\n")
        else:
            yield from _blocks(node.children)


def _table(node: SyntaxTreeNode) -> list[str]:
    """Return the rows of a table; cells that are aligned to the right stay so."""
    rows = [row for group in node.children for row in group.children]
    texts = [[text_of(cell) for cell in row.children] for row in rows]
    right = ["right" in str(cell.attrs.get("style", "")) for cell in rows[0].children]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    lines = []
    for row in texts:
        cells = zip(right, row, widths, strict=True)
        lines.append(("  " + "  ".join(text.rjust(w) if r else text.ljust(w) for r, text, w in cells)).rstrip())
    return lines


def text_of(node: SyntaxTreeNode) -> str:
    """Return the text inside a block, without markup."""
    if node.type in ("softbreak", "hardbreak"):
        return " "
    return "".join(map(text_of, node.children)) if node.children else node.content
