"""What a report is made of: sections of paragraphs, figures, tables. All text is text, never markup."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Literal, ParamSpec

from overturning.report.text import WRITTEN, cell


@dataclass(frozen=True)
class Paragraph:
    """A paragraph, on the page (HTML) and on paper (PDF) or on one of them only."""

    text: str
    medium: Literal["both", "page", "paper"] = "both"


class Note(Paragraph):
    """A paragraph in small print."""


class Caution(Paragraph):
    """A paragraph that the reader must not miss."""


@dataclass(frozen=True)
class Answer:
    """The sentences that answer the question, set apart."""

    sentences: tuple[str, ...]


@dataclass(frozen=True)
class Link:
    """A link from the page to a file that lies beside it; on paper its text and the file's name."""

    text: str
    file: str


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
    """A figure, .svg or .png.

    ``alt`` tells those who cannot see it what it shows; on paper it is as wide as ``width`` says, a share of the place
    there is, and at most ``most_height`` cm high.
    """

    path: Path
    alt: str
    caption: str = ""
    width: float = 1.0
    most_height: float = 22.0


@dataclass(frozen=True)
class Table:
    """A table, as of `table`.

    ``kinds`` has a letter for each column: t text, w text that is wide and shares the place with other wide ones, n
    number, l link to the section of that anchor, c code, which may break anywhere.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    kinds: str
    anchor: str
    sortable: bool


def table(
    heads: Sequence[str], rows: Iterable[Sequence[Any]], kinds: str = "", *, anchor: str = "", sortable: bool = False
) -> Table:
    """A table.

    Parameters
    ----------
    heads : sequence of str
        Headings of the columns; where all are empty there is no row of headings.
    rows : iterable of sequence
        Cells: text, or numbers, which are written as the letter of their column says.
    kinds : str
        A letter for each column, one of `Table` or of `text.WRITTEN`; n for the columns that have none.
    anchor : str
        Name to find it by.
    sortable : bool
        Whether the page sorts it by the column whose heading is clicked.
    """
    letters = kinds.ljust(len(heads), "n")
    cells = tuple(tuple(cell(*pair) for pair in zip(row, letters, strict=True)) for row in rows)
    return Table(tuple(heads), cells, "".join("n" if each in WRITTEN else each for each in letters), anchor, sortable)


@dataclass(frozen=True)
class Film:
    """A film on the page, from `figures.film.Film.data`; on paper its strip of four frames, ``text`` describes it."""

    data: dict[str, Any]
    text: str
    strip: Path | None = None


@dataclass(frozen=True)
class Row:
    """Blocks side by side; on paper as wide as the shares say, one below the other where there are none."""

    blocks: tuple["Block", ...]
    shares: tuple[float, ...] = ()


@dataclass(frozen=True)
class Disclosure:
    """Blocks that the page shows when asked to, and paper never."""

    title: str
    blocks: tuple["Block", ...]
    medium: Literal["page"] = "page"


@dataclass(frozen=True)
class Section:
    """A heading and what stands below it; sections inside are one level deeper.

    ``anchor`` is the name to find it by; a section that is to be kept ``together`` is not divided between pages; its
    ``medium`` is as of a paragraph.
    """

    title: str
    blocks: tuple["Block", ...]
    anchor: str = ""
    together: bool = False
    medium: Literal["both", "page"] = "both"


Leaf = Paragraph | Answer | Link | Bullets | Code | Figure | Table | Film
Block = Leaf | Row | Disclosure | Section
Said = Iterator[Block | str | None]
"""What is said one by one: blocks, texts, which are paragraphs where there is any, and nothing."""

Of = ParamSpec("Of")


def blocks_of(said: Said) -> tuple[Block, ...]:
    """The blocks of what is said."""
    return tuple(Paragraph(one) if isinstance(one, str) else one for one in said if one)


def section(
    title: str, anchor: str, medium: Literal["both", "page"] = "both"
) -> Callable[[Callable[Of, Said]], Callable[Of, Section | None]]:
    """Make a section, as of `Section`, of what a function says; None where it says nothing."""

    def of(say: Callable[Of, Said]) -> Callable[Of, Section | None]:
        @wraps(say)
        def made(*args: Of.args, **kwargs: Of.kwargs) -> Section | None:
            blocks = blocks_of(say(*args, **kwargs))
            return Section(title, blocks, anchor, medium=medium) if blocks else None

        return made

    return of


@dataclass(frozen=True)
class Report:
    """The whole report."""

    title: str
    question: str
    blocks: tuple[Section, ...]


def each_block(within: Report | Section | Row | Disclosure) -> Iterator[Block]:
    """All blocks in their order, those inside others too."""
    for block in within.blocks:
        yield block
        if isinstance(block, Row | Disclosure | Section):
            yield from each_block(block)
