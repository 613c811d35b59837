"""What a report is made of: sections of paragraphs, figures, tables. All text is text, never markup."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

Medium = Literal["both", "page", "paper"]
"""Where a text is shown: on the page (HTML) and on paper (PDF), or on one of them only."""


@dataclass(frozen=True)
class Paragraph:
    """A paragraph.

    Attributes
    ----------
    text : str
        What it says.
    medium : Medium
        Where it is shown.
    """

    text: str
    medium: Medium = "both"


class Note(Paragraph):
    """A paragraph in small print."""


class Caution(Paragraph):
    """A paragraph that the reader must not miss."""


@dataclass(frozen=True)
class Answer:
    """The sentences that answer the question, set apart."""

    sentences: tuple[str, ...]


@dataclass(frozen=True)
class Bullets:
    """A list."""

    lines: tuple[str, ...]


@dataclass(frozen=True)
class Code:
    """Text whose spaces and ends of lines are kept."""

    text: str


@dataclass(frozen=True)
class Figure:
    """A figure.

    Attributes
    ----------
    path : Path
        The file, .svg or .png.
    alt : str
        What it shows, for those who cannot see it.
    caption : str
        Text below it.
    width : float
        Width on paper, as a share of the place there is.
    most_height : float
        Largest height on paper, cm.
    """

    path: Path
    alt: str
    caption: str = ""
    width: float = 1.0
    most_height: float = 22.0


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    head : str
        Its heading.
    kind : str
        "number" (or what is to stand below each other like numbers), "text", "link" (anchor of a section of this report)
        or "code" (a hash, that may be broken anywhere).
    """

    head: str
    kind: Literal["number", "text", "link", "code"] = "number"


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes
    ----------
    columns : tuple of Column
        Headings; a table whose headings are all empty has no row of headings.
    rows : tuple of tuple of str
        Cells.
    anchor : str
        Name to find it by.
    sortable : bool
        Whether the page sorts it by the column whose heading is clicked.
    """

    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]
    anchor: str = ""
    sortable: bool = False


@dataclass(frozen=True)
class Film:
    """A film on the page.

    Attributes
    ----------
    data : dict
        What the player plays, from `figures.film.film_data`.
    text : str
        What stands in its place on paper.
    """

    data: dict[str, Any]
    text: str


@dataclass(frozen=True)
class Row:
    """Blocks side by side; as wide as the shares say on paper, all alike where there are none."""

    blocks: tuple["Block", ...]
    shares: tuple[float, ...] = ()


@dataclass(frozen=True)
class Disclosure:
    """Blocks that the page shows when asked to, paper always."""

    title: str
    blocks: tuple["Block", ...]


@dataclass(frozen=True)
class Section:
    """A heading and what stands below it; sections inside are one level deeper.

    Attributes
    ----------
    title : str
        The heading.
    blocks : tuple of Block
        What it says.
    anchor : str
        Name to find it by.
    together : bool
        Whether it is not to be divided between pages.
    """

    title: str
    blocks: tuple["Block", ...]
    anchor: str = ""
    together: bool = False


Block = Paragraph | Answer | Bullets | Code | Figure | Table | Film | Row | Disclosure | Section


@dataclass(frozen=True)
class Report:
    """The whole report.

    Attributes
    ----------
    title, question : str
        What was studied.
    sections : tuple of Section
        What it says.
    """

    title: str
    question: str
    sections: tuple[Section, ...]


def each_block(blocks: tuple[Block, ...]) -> Iterator[Block]:
    """All blocks in their order, those inside others too."""
    for block in blocks:
        yield block
        if isinstance(block, Row | Disclosure | Section):
            yield from each_block(block.blocks)


def text_columns(*heads: str) -> tuple[Column, ...]:
    """Columns of text."""
    return tuple(Column(head, "text") for head in heads)


def number_columns(*heads: str) -> tuple[Column, ...]:
    """Columns of numbers."""
    return tuple(Column(head) for head in heads)
