"""Rendering of the report's Markdown as HTML, PDF and text: structure, numbering, and hostile names."""

import html.parser
import re
import zlib
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs

import pytest

from overturning import report
from overturning.errors import ResultError
from overturning.findings.collect import Findings
from overturning.report.page import render_report_html_page
from overturning.report.paper import compile_report_pdf
from overturning.report.render import (
    LANGUAGES,
    ReportMedia,
    escape_markdown,
    parse_markdown_and_number_figures_and_tables,
    render_template_as_markdown,
)
from overturning.report.terminal import terminal_lines_of_markdown
from overturning.report.write import TextsAboutReportFilm
from overturning.translation.texts import installed_fonts_of_language
from tests.report.by_hand import (
    RECORD_FINDING,
    STUDY_FINDINGS,
    findings_with_changed_entries,
    handwritten_findings_of_study,
)

SCRIPT_AS_NAME = "<script>window.hurt = 1</script>"
HOSTILE_NAMES = [
    SCRIPT_AS_NAME,
    "a | b",
    "*x* _y_ `z`",
    "[l](javascript:1)",
    "# h",
    "::: fold",
    "$x^2$ #panic()",
    "a\\nb",
    "&amp; <b>",
]

SMALL_SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="100pt" height="50pt"><g id="a"/><use href="#a"/></svg>'


class ParserOfWellFormedPage(html.parser.HTMLParser):
    """Parser that lists the elements of a page, with attributes, and checks that they are closed in order."""

    VOID_ELEMENTS = frozenset({"meta", "img", "br", "input", "link", "hr"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """List an element, and expect its end unless it is a void element."""
        self.found.append((tag, dict(attrs)))
        if tag not in self.VOID_ELEMENTS:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Skip a self-closing element."""

    def handle_endtag(self, tag: str) -> None:
        """Check that the element that ends is the last one opened."""
        assert self.open.pop() == tag


def elements_of_well_formed_page(page: str) -> list[tuple[str, dict[str, str | None]]]:
    """Return tag and attributes of the elements of a page, after a check that it is well formed."""
    parser = ParserOfWellFormedPage()
    parser.feed(page)
    assert parser.open == []
    return parser.found


def render_markdown_as_html_page(text: str, figures: dict[str, Path] | None = None, films: Any = None) -> str:
    """Render Markdown as an HTML page."""
    return render_report_html_page(
        parse_markdown_and_number_figures_and_tables(text), "title", "en", figures, films or {}
    )


def findings_with_given_names_and_titles(*names: str) -> Findings:
    """Return findings that contain three given names in all titles and names."""
    one, two, three = names
    record = RECORD_FINDING | {"id": one, "station": two, "event": three}
    data = findings_with_changed_entries(
        STUDY_FINDINGS["survey"], study={"title": one, "question": two}, records=[record]
    )
    return Findings.model_validate(data | {"sources": [{"record": three, "source": one, "licence": two}]})


@pytest.fixture(scope="module")
def tags_of_page_with_harmless_names() -> list[str]:
    """Return the tags of the report page on findings whose names contain no HTML."""
    return [
        tag
        for tag, _ in elements_of_well_formed_page(
            render_markdown_as_html_page(
                render_template_as_markdown(findings_with_given_names_and_titles("a", "b", "c"))
            )
        )
    ]


@pytest.mark.parametrize("name", HOSTILE_NAMES)
def test_hostile_name_changes_no_page_element_and_is_shown_unchanged(
    name: str, tags_of_page_with_harmless_names: list[str]
) -> None:
    tree = parse_markdown_and_number_figures_and_tables(
        render_template_as_markdown(findings_with_given_names_and_titles(name, name, name))
    )
    assert [
        tag for tag, _ in elements_of_well_formed_page(render_report_html_page(tree, "title", "en", None, {}))
    ] == tags_of_page_with_harmless_names
    assert "".join(name.split()) in "".join("".join(terminal_lines_of_markdown(tree)).split())


def test_report_chapter_of_a_record_links_to_the_record_in_the_explorer() -> None:
    """The explorer reads the part behind # as a query string (URLSearchParams), as `parse_qs` does."""
    names = ["rinaldi", "imperial-06", "a b+c&d=e#f%20_g_", *HOSTILE_NAMES]
    data = findings_with_changed_entries(
        STUDY_FINDINGS["survey"], records=[RECORD_FINDING | {"id": name} for name in names]
    )
    media = ReportMedia(figure_names_by_record=dict.fromkeys(names, ("polar/x",)), explorer_address="explore.html")
    found = elements_of_well_formed_page(
        render_markdown_as_html_page(
            render_template_as_markdown(Findings.model_validate(data), films_and_figures=media)
        )
    )
    addresses = [str(a["href"]) for tag, a in found if tag == "a" and "explore.html#" in str(a["href"])]
    pages, fragments = zip(*(address.split("#", 1) for address in addresses), strict=True)
    assert {*pages} == {"explore.html"}
    assert [parse_qs(one, strict_parsing=True) for one in dict.fromkeys(fragments)] == [{"record": [n]} for n in names]
    bare = elements_of_well_formed_page(
        render_markdown_as_html_page(
            render_template_as_markdown(
                Findings.model_validate(data),
                films_and_figures=ReportMedia(figure_names_by_record=media.figure_names_by_record),
            )
        )
    )
    assert not any(word in str(a.get("href")) for word in ("explore", "#record=") for tag, a in bare)


@pytest.mark.parametrize("name", HOSTILE_NAMES)
def test_text_escaped_for_markdown_is_read_back_unchanged(name: str) -> None:
    (line,) = terminal_lines_of_markdown(parse_markdown_and_number_figures_and_tables(f"x {escape_markdown(name)} y"))
    assert line == f"x {' '.join(name.split(chr(10)))} y"


def test_figures_and_tables_are_numbered_except_in_folded_sections(tmp_path: Path) -> None:
    figures = {name: tmp_path / f"{name}.svg" for name in "abc"}
    for path in figures.values():
        path.write_text(SMALL_SVG)
    table = "::: table Sizes\n| a |\n|--:|\n| 1 |\n:::\n"
    text = '![one](a "A")\n\n:::: fold More\n![two](b "B")\n\n' + table + '\n::::\n\n![three](c "C")\n\n' + table
    page = render_markdown_as_html_page(text, figures)
    assert "<b>Figure 1.</b> A" in page
    assert "<b>Figure 2.</b> C" in page
    assert "<figcaption>B</figcaption>" in page
    assert page.count("<b>Table 1.</b> Sizes") == 1
    assert '<td class="n">1</td>' in page
    # Identifiers of two figures differ in the page; a figure in a fold is an image, which a browser reads later.
    assert 'id="figure-1-a"' in page
    assert 'href="#figure-1-a"' in page
    assert [attrs["loading"] for tag, attrs in elements_of_well_formed_page(page) if tag == "img"] == ["lazy"]
    with pytest.raises(ResultError, match="b: no such figure"):
        render_markdown_as_html_page(text, {"a": figures["a"]})


def test_figures_and_tables_are_numbered_in_the_words_of_the_language() -> None:
    text = '![one](a "A")\n\n::: table Sizes\n| a |\n|--:|\n| 1 |\n:::\n'
    page = render_report_html_page(parse_markdown_and_number_figures_and_tables(text), "題", "ja", None, {})
    assert "<b>図1.</b> A" in page
    assert "<b>表1.</b> Sizes" in page
    assert "<title>題</title>" in page


def test_anchor_link_emphasis_and_list_are_rendered_as_html(tmp_path: Path) -> None:
    page = render_markdown_as_html_page("{#here}\n## Title\n\n[to *it*](#here) and **bold**\n\n- one\n- two\n")
    assert '<h2 id="here">Title</h2>' in page
    assert '<a href="#here">to <em>it</em></a> and <strong>bold</strong>' in page
    assert page.count("<li>") == 2


def test_figures_side_by_side_in_the_pdf_are_drawn_for_a_phone(tmp_path: Path) -> None:
    """Half a page is as wide as a phone; a figure drawn for a page would have letters of half their size there."""
    page, phone = tmp_path / "page.svg", tmp_path / "phone.svg"
    for path, width in ((page, 482), (phone, 241)):
        path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}pt" height="99pt"></svg>', "utf-8")
    pair, alone = (
        parse_markdown_and_number_figures_and_tables(text)
        for text in ('::: pair\n![alt](a "A")\n:::\n', '![alt](a "A")\n')
    )
    figures = {"a": page, "narrow/a": phone}
    assert compile_report_pdf(pair, "T", "en", figures) == compile_report_pdf(pair, "T", "en", {"a": phone})
    assert compile_report_pdf(alone, "T", "en", figures) == compile_report_pdf(alone, "T", "en", {"a": page})
    assert compile_report_pdf(alone, "T", "en", figures) != compile_report_pdf(alone, "T", "en", {"a": phone})


def decompressed_pdf_streams(pdf: bytes) -> list[bytes]:
    """Return the decompressed streams of a PDF file, among them one for each page."""
    found = re.findall(rb"/FlateDecode.*?stream\r?\n(.*?)\r?\nendstream", pdf, re.S)
    return [zlib.decompress(one) for one in found]


def test_caption_of_a_table_is_on_the_pdf_page_of_the_table() -> None:
    """As longer text moves a table (8 pt letters) to the next page, its caption (8.5 pt letters) moves with it."""
    pages = []
    for lines in range(33, 49):
        text = "\n\n".join(["# T", *["Line."] * lines])
        table = "::: table Caption.\n| a | b |\n|---|---|\n| 1 | 2 |\n:::\n"
        pdf = compile_report_pdf(parse_markdown_and_number_figures_and_tables(f"{text}\n\n{table}"), "T", "en", {})
        (page,) = (one for one in decompressed_pdf_streams(pdf) if b" 8.5 Tf" in one)
        assert b" 8 Tf" in page, lines
        pages.append(b" 17 Tf" in page)
    assert pages[0]
    assert not pages[-1]


def test_no_figure_is_above_the_title_of_the_pdf(tmp_path: Path) -> None:
    """The title of the PDF, in letters of 17 pt, is higher on the page than the upper edge of the first figure."""
    (tmp_path / "a.svg").write_text(SMALL_SVG, encoding="utf-8")
    tree = parse_markdown_and_number_figures_and_tables('# Title\n\nShort.\n\n![alt](a "A")\n\n## Next\n\nMore.\n')
    pdf = compile_report_pdf(tree, "T", "en", {"a": tmp_path / "a.svg"})
    (content,) = (one for one in decompressed_pdf_streams(pdf) if b" 17 Tf" in one)
    title = re.search(rb"([\d.]+) cm[^Q]*? 17 Tf", content)
    figure = re.search(rb"/Alt\(alt\)>>BDC\s+q [\d.]+ ([\d.]+) m", content)
    assert title
    assert figure
    assert float(figure[1]) < float(title[1])


@pytest.mark.skipif(not installed_fonts_of_language("ja"), reason="no Japanese font is installed")
@pytest.mark.parametrize("place", ["text", "figure"])
def test_japanese_names_in_an_english_pdf_have_their_letters(tmp_path: Path, place: str) -> None:
    """A Japanese font is embedded only if a text or a figure has Japanese letters, which would be boxes without it."""
    texts, font = {"text": "Hino", "figure": "Hino"}, b"CJK"

    def compile_pdf_with_names_in_text_and_figure() -> bytes:
        svg = SMALL_SVG.replace('<g id="a"/>', f'<text id="a" y="9">{texts["figure"]}</text>')
        (tmp_path / "a.svg").write_text(svg, encoding="utf-8")
        return compile_report_pdf(
            parse_markdown_and_number_figures_and_tables(f'# {texts["text"]}\n\n![alt](a "A")\n'),
            "T",
            "en",
            {"a": tmp_path / "a.svg"},
        )

    assert font not in compile_pdf_with_names_in_text_and_figure()
    texts[place] = "日野"
    assert font in compile_pdf_with_names_in_text_and_figure()


def test_error_names_a_damaged_figure_and_the_remedy(tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text(SMALL_SVG[:-9], encoding="utf-8")
    with pytest.raises(ResultError, match=r"a\.svg is damaged: delete it, and run the study again"):
        compile_report_pdf(
            parse_markdown_and_number_figures_and_tables('# T\n\n![alt](a "A")\n'), "T", "en", {"a": tmp_path / "a.svg"}
        )


@pytest.mark.parametrize("name", ["answer", "caution", "kicker", "limits", "note", "pair"])
def test_style_sheet_has_a_rule_for_each_class_of_report_passage(name: str) -> None:
    style = (Path(report.__file__).parent / "templates" / "report.css").read_text(encoding="utf-8")
    assert f'class="{name}"' in render_markdown_as_html_page(f"::: {name}\ntext\n:::\n")
    assert re.search(rf"\.{name}\b", style)


def test_page_omits_passages_for_print_only_and_the_pdf_is_reproducible(tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text(SMALL_SVG)
    text = '# T\n\n:::: fold F\nfolded\n\n::::\n\n::: paper\npaper\n\n:::\n\n![alt](a "A")\n\n```\ncode\n```\n'
    figures = {"a": tmp_path / "a.svg"}
    assert "paper</p>" not in render_markdown_as_html_page(text, figures)
    first, second = (
        compile_report_pdf(parse_markdown_and_number_figures_and_tables(text), "T", "en", figures) for _ in range(2)
    )
    assert first == second
    assert first.startswith(b"%PDF")


def test_terminal_report_has_sentences_and_aligned_tables() -> None:
    text = "**One** sentence.\n\n::: table T\n| name | n |\n|---|--:|\n| a | 1 |\n| bcd | 23 |\n:::\n"
    assert list(terminal_lines_of_markdown(parse_markdown_and_number_figures_and_tables(text))) == [
        "One sentence.",
        "",
        "  name   n",
        "  a      1",
        "  bcd   23",
    ]


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("study", STUDY_FINDINGS)
def test_every_report_is_well_formed_without_cube_and_figures(study: str, language: str) -> None:
    film = TextsAboutReportFilm("film-1", "Title", "A stone", (("north", "falls"), ("south", "stands")), "rule")
    media = ReportMedia(
        films=[film, film],
        figure_names_by_record={"vale": ("polar/vale", "intensity/vale")},
        explorer_address="explore.html",
        station_map_names=["maps/1", "maps/2"],
        has_rose_of_all_falls=True,
        has_posterior_figures=True,
    )
    tree = parse_markdown_and_number_figures_and_tables(
        render_template_as_markdown(handwritten_findings_of_study(study), language, media)
    )
    page = render_report_html_page(tree, study, language, None, {})
    assert f'<html lang="{language}">' in page
    found = elements_of_well_formed_page(page)
    anchors = {attrs["id"] for _, attrs in found if "id" in attrs}
    targets = [str(attrs["href"]) for tag, attrs in found if tag == "a"]
    assert [one for one in targets if one.startswith("#") and one[1:] not in anchors] == []
    assert sum(tag == "h1" for tag, _ in found) == 1
    for word in (">nan", "NaN", ">None", "Undefined", "inf ", "{{", "{%", "{#", ":::"):
        assert word not in page.partition("<main>")[2].partition("</main>")[0], word
