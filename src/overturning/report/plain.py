"""A section of the report for a terminal: its sentences and tables, without figures and small print."""

from collections.abc import Iterator

from overturning.report.blocks import Answer, Note, Paragraph, Section, Table, each_block


def plain_lines(section: Section) -> Iterator[str]:
    """Lines to print."""
    for block in each_block(section):
        if isinstance(block, Answer):
            yield from block.sentences
        elif isinstance(block, Paragraph) and not isinstance(block, Note):
            yield f"\n{block.text}"
        elif isinstance(block, Table):
            rows = (block.heads, *block.rows)
            widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
            yield ""
            for row in rows:
                cells = zip(block.kinds, row, widths, strict=True)
                aligned = (text.rjust(width) if kind == "n" else text.ljust(width) for kind, text, width in cells)
                yield "  " + "  ".join(aligned).rstrip()
