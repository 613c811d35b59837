"""A section of the report for a terminal: its sentences and tables, without figures and small print."""

from collections.abc import Iterator

from overturning.report.blocks import Answer, Note, Paragraph, Section, Table, each_block


def plain_lines(section: Section) -> Iterator[str]:
    """Lines to print.

    Parameters
    ----------
    section : Section
        The section.

    Yields
    ------
    str
    """
    for block in each_block(section.blocks):
        match block:
            case Answer():
                yield from block.sentences
            case Note():
                continue
            case Paragraph():
                yield from ("", block.text)
            case Table():
                yield from ("", *_table_lines(block))


def _table_lines(table: Table) -> Iterator[str]:
    rows = (tuple(column.head for column in table.columns), *table.rows)
    widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
    for row in rows:
        cells = (
            text.rjust(width) if column.kind == "number" else text.ljust(width)
            for column, text, width in zip(table.columns, row, widths, strict=True)
        )
        yield "  " + "  ".join(cells).rstrip()
