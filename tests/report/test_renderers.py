"""The page and the paper are two renderings of one list of sections, and hold no words of their own."""

import html
import json
import re
import shutil
import zlib
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from overturning.errors import ResultError
from overturning.report.blocks import (
    Answer,
    Block,
    Bullets,
    Caution,
    Code,
    Disclosure,
    Figure,
    Film,
    Link,
    Note,
    Paragraph,
    Report,
    Row,
    Section,
    Table,
    each_block,
    table,
)
from overturning.report.pdf import paper_data, render_pdf
from overturning.report.plain import plain_lines
from overturning.report.write import write_report
from tests.report.reading import Balance, render_html, texts

HARM = "</script><script>window.hurt = 1</script> \"' & #panic() $x^2$ [*a* _b_ = @c `d` \\e {{ f }}"
SQUARE = '<svg xmlns="http://www.w3.org/2000/svg" width="10pt" height="10pt" viewBox="0 0 10 10"><rect id="a"/></svg>'


def drawn(pages: bytes) -> int:
    """Rough size of what the pages draw: bytes of the inflated streams."""
    total = 0
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pages, flags=re.DOTALL):
        try:
            total += len(zlib.decompress(stream))
        except zlib.error:
            continue
    return total


def shown_on_page(page: str) -> str:
    """Return the readable text of a page, with the descriptions of figures."""
    body = page[page.index("<body>") :]
    seen = re.findall(r'(?:aria-label|alt)="([^"]*)"', body)
    body = re.sub(r"<svg.*?</svg>|<script.*?</script>", "", body, flags=re.DOTALL)
    return html.unescape(re.sub(r"<[^>]*>", "\n", body) + "\n" + "\n".join(seen))


def paper_texts(data: Any) -> list[str]:
    if isinstance(data, dict):
        return [text for value in data.values() for text in paper_texts(value)]
    if isinstance(data, list):
        return [text for value in data for text in paper_texts(value)]
    return [data] if isinstance(data, str) else []


@pytest.fixture
def everything(tmp_path: Path) -> Report:
    """Every kind of block, each of its texts harmful."""
    figure = Figure(tmp_path / "figure.svg", HARM, HARM, width=0.5)
    figure.path.write_text(SQUARE, encoding="utf-8")
    rows = ((HARM, HARM, HARM, HARM), ("b", "–", "one", "f" * 64))
    four = table((HARM, HARM, HARM, HARM), rows, "tnlc", anchor=HARM, sortable=True)
    blocks: tuple[Block, ...] = (
        Answer((HARM, HARM)), Link(HARM, "beside.html"), Paragraph(HARM), Note(HARM), Caution(HARM),
        Bullets((HARM, HARM)), Code(HARM), figure, four,
        table(("", ""), ((HARM, HARM),)), Film({"title": HARM}, HARM), Row((figure, four), (1.0, 2.0)),
        Disclosure(HARM, (Row((figure,)),)), Section(HARM, (Section(HARM, (Paragraph(HARM),)),), HARM, together=True),
    )  # fmt: skip
    return Report(HARM, HARM, (Section(HARM, blocks, HARM),))


def test_names_from_files_are_text(everything: Report) -> None:
    page = render_html(everything)
    parser = Balance()
    parser.feed(page)
    assert parser.open == []
    assert "<script>window" not in page
    film = re.search(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL)
    assert film is not None
    assert json.loads(film[1]) == {"title": HARM}
    written = sum(text == HARM for text in texts(everything))
    # The replacement of a film is for paper only; the title, a link, and a heading in the contents appear
    # twice.
    assert shown_on_page(page).count(HARM.splitlines()[0]) == written
    assert sum(text == HARM for text in paper_texts(paper_data(everything, {}))) >= written
    assert render_pdf(everything).startswith(b"%PDF")


def test_the_page_has_every_text_and_figure_and_paper_those_that_are_not_folded_away(report: Report) -> None:
    page, files = shown_on_page(render_html(report)), {}
    paper = paper_data(report, files)
    on_paper = set(paper_texts(paper))

    def printed(block: Any) -> Any:
        """A part without what stands on the page only."""
        if not hasattr(block, "blocks"):
            return block
        return replace(
            block, blocks=tuple(printed(one) for one in block.blocks if getattr(one, "medium", "") != "page")
        )

    whole, kept = list(each_block(report)), list(each_block(printed(report)))
    assert any(isinstance(block, Disclosure) for block in whole)
    assert not any(isinstance(block, Disclosure) for block in kept)
    for shown, blocks, other in ((page, whole, "paper"), (on_paper, kept, "page")):
        for block in blocks:
            if isinstance(block, Film):
                assert block.text in on_paper
            elif getattr(block, "medium", "") != other:
                for text in texts(replace(block, blocks=()) if hasattr(block, "blocks") else block):
                    assert text in shown, text
    figures = [block for block in whole if isinstance(block, Figure)]
    assert render_html(report).count("<figure>") == len(figures)
    assert set(files) == {block.path for block in kept if isinstance(block, Figure)} < {one.path for one in figures}
    tables = [sum(isinstance(block, Table) for block in blocks) for blocks in (whole, kept)]
    assert [render_html(report).count("<table"), json.dumps(paper).count('"kind": "table"')] == tables
    films = sum(isinstance(block, Film) for block in whole)
    assert render_html(report).count('class="film"') == films >= 1


def test_the_renderers_hold_no_words() -> None:
    assert shown_on_page(render_html(Report("Title", "", ()))).split() == ["Title"]
    source = resources.files("overturning").joinpath("report/templates/report.typ").read_text(encoding="utf-8")
    source = re.sub(r"^//.*$", "", source, flags=re.MULTILINE)
    strings = re.findall(r'"([^"\n]*)"', source)
    assert [text for text in strings if " " in text] == ["1 / 1", "Libertinus Serif", "no such kind of block: "]


def test_contents_lead_to_every_section(report: Report) -> None:
    page = render_html(report)
    contents = re.search(r'<nav class="contents">(.*?)</nav>', page)
    assert contents is not None
    for part in report.blocks:
        assert f'<a href="#{part.anchor}">{html.escape(part.title)}</a>' in contents[1]
        assert page.count(f'id="{part.anchor}"') == 1


def test_each_figure_keeps_its_own_identifiers(everything: Report) -> None:
    ids = re.findall(r'id="(figure[^"]*)"', render_html(everything))
    assert len(ids) == len(set(ids)) == 3


def test_paper_draws_what_it_is_given(everything: Report) -> None:
    section = everything.blocks[0]
    without = replace(everything, blocks=(replace(section, blocks=section.blocks[:3]),))
    assert drawn(render_pdf(everything)) > drawn(render_pdf(without)) + 1000
    assert render_pdf(everything) == render_pdf(everything)


def test_a_missing_or_torn_figure_is_named(hostile: Path, tmp_path: Path, everything: Report) -> None:
    folder = shutil.copytree(hostile, tmp_path / "results")
    (folder / "figures" / "rose.svg").unlink()
    with pytest.raises(ResultError, match=r"rose\.svg: no such figure; run the figures"):
        write_report(folder, tmp_path / "report.html", tmp_path / "report.pdf")
    assert list(tmp_path.glob("report.*")) == []
    (tmp_path / "figure.svg").write_text("<svg", encoding="utf-8")
    with pytest.raises(ResultError, match="draw the figures again"):
        render_pdf(everything)


def test_a_section_on_a_terminal() -> None:
    fruit = table(("what", "number"), (("apples", 7), ("a", "123456789")), "t")
    lines = list(plain_lines(Section("", (Answer(("Yes.",)), fruit, Note("small"), Paragraph("So.")))))
    assert lines == ["Yes.", "", "  what       number", "  apples          7", "  a       123456789", "\nSo."]
