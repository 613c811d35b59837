"""Reading a report: its texts, its blocks of one kind, and a whole page and paper made of a results folder."""

import html.parser
import re
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from overturning.report.blocks import Film, Report, Section, Table, each_block
from overturning.report.html import pieces_of
from overturning.report.results import Results
from overturning.report.write import write_report


def render_html(report: Report) -> str:
    """The whole page."""
    return "".join(pieces_of(report))


NO_TEXT = {"kinds", "anchor", "medium", "file"}

NUMBER = re.compile(r"[−-]?\d+(?:[.,]\d+)*")

BAD = "<script>window.hurt = 1</script>"
"""A name from a stranger's file."""


def texts(part: Any) -> list[str]:
    """Every text of a report, or of a part of it."""
    if isinstance(part, str):
        return [part]
    if isinstance(part, Film):
        return [part.text]
    if is_dataclass(part):
        return [
            text for field in fields(part) if field.name not in NO_TEXT for text in texts(getattr(part, field.name))
        ]
    return [text for one in part for text in texts(one)] if isinstance(part, tuple) else []


def text_of(part: Any) -> str:
    """All texts as one."""
    return "\n".join(texts(part))


def numbers(text: str) -> list[str]:
    """Every number of a text, in its order."""
    return NUMBER.findall(text)


def of_study(results: Results, **settings: Any) -> Results:
    """The results under a study with other settings."""
    return replace(results, study=results.study.model_copy(update=settings))


def tables(section: Report | Section) -> list[Table]:
    return [block for block in each_block(section) if isinstance(block, Table)]


def column(table: Table, head: str, which: int = 0) -> list[str]:
    """Cells below a heading; where several columns have it, of one of them."""
    place = [index for index, one in enumerate(table.heads) if one == head][which]
    return [row[place] for row in table.rows]


class Balance(html.parser.HTMLParser):
    """Every element that is opened is closed, in order."""

    VOID = frozenset({"meta", "img", "br", "input", "link", "hr"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        assert self.open, tag
        assert self.open.pop() == tag, tag


def report_of(folder: Path) -> tuple[str, bytes]:
    """Page and paper of a results folder, well formed and without numbers that are none."""
    write_report(folder, folder / "report.html", folder / "report.pdf")
    page = (folder / "report.html").read_text(encoding="utf-8")
    parser = Balance()
    parser.feed(page)
    assert parser.open == []
    for word in (">nan", "NaN", ">None", "inf%", "nan°"):
        assert word not in re.sub(
            r"<svg.*?</svg>|<script.*?</script>|<pre>.*?</pre>|src=\"data:[^\"]*\"", "", page, flags=re.DOTALL
        ), word
    return page, (folder / "report.pdf").read_bytes()
