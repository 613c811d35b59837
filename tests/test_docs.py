"""The documentation: line length, links, drawings, and named files."""

import base64
import csv
import importlib.util
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from overturning.cli import main
from overturning.model.status import CaseStatus
from overturning.model.variables import (
    BODY_OUTCOME_VARIABLES,
    OUTCOME_VARIABLES_OF_2D_RUNS_IN_FACE_PLANES,
    PLANAR_OUTCOME_VARIABLES,
)
from tests.expect import skip_test_unless_skipping_is_forbidden

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "README.ja.md", ROOT / "config" / "README.md", *sorted(DOCS.rglob("*.md"))]
MAX_LINE_LENGTH = 130
MAX_DRAWING_BYTES = 30_000

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def text_without_code(page: Path) -> str:
    """Return the text of a page of the docs without its code blocks and inline code."""
    text = re.sub(r"^ *```.*?^ *```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"`[^`\n]*`", "code", text)


def heading_anchors(page: Path) -> set[str]:
    """Return the anchors of a page: headings in lower case, without punctuation, with hyphens for blanks."""
    found: set[str] = set()
    for heading in re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), flags=re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        found.add(slug if slug not in found else f"{slug}-1")
    return found


@each_page
def test_no_line_of_the_docs_exceeds_130_characters(page):
    made = False  # by a script: the columns of its tables are what they are
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        made = (made or "begin -->" in line or "made by" in line) and "end" not in re.findall(
            r"<!--.*?(end).*?-->", line
        )
        assert len(line) <= MAX_LINE_LENGTH or (made and line.startswith("|")), (
            f"{page.name}:{number}: {len(line)} characters"
        )


PERCENTAGES_NOT_MEASURED = {
    "README.md": {"1"}, "README.ja.md": set(), "method.md": set(), "measurements.md": {"1"}, "glossary.md": {"2", "95"},
    "validation.md": {"0.5", "1", "2", "95"}, "surveys.md": {"5", "20", "40", "90", "95"},
    "shaking-table.md": {"19", "95"},
    "tutorial.md": {"0.00"},
    "criteria.md": {"0.05", "11"}, "soft-ground.md": {"2"}, "formats.md": {"0.5", "95"}, "scale.md": set(),
    "scenes.md": set(), "index.md": set(),
}  # fmt: skip
"""Percentages that a study sets, that others published, or of an interval: all others come from a table of results."""


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.name in PERCENTAGES_NOT_MEASURED and page.parent != ROOT / "config"]
)
def test_no_measured_percentage_in_the_docs_is_typed_by_hand(page):
    text = re.sub(r"<!-- ([\w-]+):begin -->.*?<!-- \1:end -->", "", text_without_code(page), flags=re.DOTALL)
    text = re.sub(r"<!--=[\w-]+-->.*?<!--/-->", "", text, flags=re.DOTALL)
    found = set(re.findall(r"([\d.]+)\s*%", text))
    assert found <= PERCENTAGES_NOT_MEASURED[page.name], "put it into verification/sentences.py"


@each_page
def test_each_link_in_the_docs_has_a_target(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", text_without_code(page)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        to = (page.parent / path).resolve() if path else page
        assert to.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in heading_anchors(to), (
            f"{page.name}: {target}; there are {sorted(heading_anchors(to))}"
        )


def test_the_readme_links_every_page_and_each_linked_table_exists():
    readme = PAGES[0].read_text(encoding="utf-8")
    assert [page.name for page in DOCS.glob("*.md") if f"(docs/{page.name})" not in readme] == []
    texts = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [
        path for path in re.findall(r"(verification/results/[\w-]+\.csv)", texts) if not (ROOT / path).is_file()
    ] == []


def test_the_readme_has_its_sections_in_order():
    text = PAGES[0].read_text(encoding="utf-8")
    places = [text.index(part) for part in ("rotates", "![", "    make run ", "    make test ", "<!-- found:end -->")]
    assert places == sorted(places)
    assert len(text.split()) <= 900


@each_page
def test_markers_of_generated_tables_come_in_pairs(page):
    text = page.read_text(encoding="utf-8")
    begins, ends = (re.findall(rf"^<!-- ([\w-]+):{side} -->$", text, flags=re.MULTILINE) for side in ("begin", "end"))
    assert begins == ends
    assert len(set(begins)) == len(begins)


@each_page
def test_no_line_of_a_docs_paragraph_begins_with_an_html_marker(page):
    """In Markdown such a line ends the paragraph and is taken as HTML."""
    assert re.findall(r"^ *<!--=[\w-]+-->.+$", page.read_text(encoding="utf-8"), flags=re.MULTILINE) == []


def test_drawings_in_the_docs_equal_the_output_of_their_script(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(DOCS)  # as where the script is run
    load_docs_script("draw").main(tmp_path)
    drawn = sorted(tmp_path.iterdir())
    assert drawn
    shown = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for drawing in drawn:
        kept = DOCS / "images" / drawing.name
        assert drawing.read_bytes() == kept.read_bytes(), f"{kept}: run python docs/draw.py"
        assert drawing.stat().st_size < MAX_DRAWING_BYTES
        assert f"(images/{drawing.name})" in shown


def test_each_image_in_the_docs_is_shown_on_a_page():
    shown = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [image.name for image in (DOCS / "images").iterdir() if f"images/{image.name})" not in shown] == []


def rows_of_docs_table_on_extending_the_package() -> list[str]:
    """Return the rows of the table in docs/method.md that states where each kind of extension is added."""
    section = (DOCS / "method.md").read_text(encoding="utf-8").split("## Where would I add", 1)[1]
    return [line for line in section.splitlines() if line.startswith("| a ")]


@pytest.mark.parametrize(
    "row", rows_of_docs_table_on_extending_the_package(), ids=lambda row: row.split("|")[1].strip()
)
def test_paths_in_the_docs_on_where_to_extend_the_package_exist(row):
    for name, path in re.findall(r"(?:`([A-Z]+)` in )?`([\w./-]+/[\w./-]*|\w+\.py)`", row):
        found = [base / path for base in (ROOT / "src" / "overturning", ROOT) if (base / path).exists()]
        assert found, path
        assert not name or re.search(rf"^{name}\b", found[0].read_text(encoding="utf-8"), flags=re.MULTILINE), row


def test_docs_explain_each_case_status_and_each_variable():
    method, glossary = ((DOCS / name).read_text(encoding="utf-8") for name in ("method.md", "glossary.md"))
    table = method.split("| `status` |", 1)[1].split("\n\n", 1)[0]
    assert re.findall(r"^\| `(\w+)` \|", table, flags=re.MULTILINE) == [status.name.lower() for status in CaseStatus]
    assert [variable.name for variable in PLANAR_OUTCOME_VARIABLES if f"`{variable.name}`" not in glossary] == []
    in_space = (*BODY_OUTCOME_VARIABLES, *OUTCOME_VARIABLES_OF_2D_RUNS_IN_FACE_PLANES)
    assert [variable.name for variable in in_space if f"`{variable.name}`" not in glossary] == []


def load_docs_script(name):
    """Import a Python script of the docs folder as a module."""
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def docs_hooks_module():
    """The script docs/hooks.py, which fills in the pages when the site is built."""
    return load_docs_script("hooks")


def test_the_notebook_is_stored_with_its_current_output(docs_hooks_module):
    kept = json.loads(docs_hooks_module.NOTEBOOK.read_text(encoding="utf-8"))
    pictures = []
    for cell, now in zip(kept["cells"], docs_hooks_module.executed(docs_hooks_module.NOTEBOOK)["cells"], strict=True):
        for output, made in zip(cell.get("outputs", []), now.get("outputs", []), strict=True):
            data, new = output.get("data", {}), made.get("data", {})
            # The pixels are those of the fonts of a machine: the size of the picture is compared.
            shown = [base64.b64decode(one.pop("image/png", b""))[:24] for one in (data, new)]
            assert shown[0] == shown[1]
            assert output == made, "run python docs/hooks.py"
            pictures += [len(shown[0])] if shown[0] else []
    assert pictures == [24, 24]
    assert docs_hooks_module.NOTEBOOK.stat().st_size < 200_000


def test_the_site_hooks_fill_in_the_reference_pages(docs_hooks_module):
    filled = {}
    for page in (DOCS / "reference").glob("*.md"):
        made = filled[page.stem] = docs_hooks_module.on_page_markdown(page.read_text(encoding="utf-8"))
        assert "<!-- made" not in made
        assert "](../config" not in made
    commands = filled["command-line"]
    assert "## overturning records fetch url" in commands
    assert "--animate" in commands
    assert re.findall(r"^  .*\.\.\.$", commands, flags=re.MULTILINE) == [], "a list says the half of a command"
    assert "`figures.dpi`" in filled["config"]


def test_the_first_page_has_a_film_and_the_site_an_explorer_page(docs_hooks_module):
    first = docs_hooks_module.on_page_markdown((DOCS / "index.md").read_text(encoding="utf-8"))
    assert first.index('src="film.html"') < first.index("rotates strong-motion records") < first.index('"explore.html"')
    assert f"`{docs_hooks_module.FILM} --animate film.html`" in first
    assert "](first-look.md)" in first  # the notebook is a page of the site
    film, explorer = docs_hooks_module.film_page(), docs_hooks_module.explorer_page()
    assert 'class="film"' in film
    assert docs_hooks_module.STUDY["question"] in explorer
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', explorer, flags=re.DOTALL)
    cells = json.loads(data)
    assert [record["id"] for record in cells["records"]] == [docs_hooks_module.RECORD]
    assert cells["height"] == docs_hooks_module.STUDY["height"]


@pytest.mark.parametrize("command", ["records check", "one --record wtmc --azimuth 332"])
def test_the_tutorial_shows_the_output_of_its_commands(command, monkeypatch, capsys):
    tutorial = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    words, shown = re.search(
        rf"^    overturning ({command}(?:.*\\\n)?.*)\n\n((?:    .*\n)+)", tutorial, flags=re.MULTILINE
    ).groups()
    monkeypatch.chdir(ROOT)
    with pytest.raises(SystemExit) as stop:
        main(words.partition("\\")[0].split())  # what follows in a second line are files to write
    assert not stop.value.code
    made = ("    film", "    figure")
    lines = [line[4:].partition(" …") for line in shown.splitlines() if not line.startswith(made)]
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == len(lines) > 2
    for found, (line, cut, _) in zip(printed, lines, strict=True):
        assert found.startswith(line) if cut else found == line


@each_page
def test_records_added_in_docs_commands_have_ids_not_yet_in_the_table(page):
    shipped = subprocess.run(
        ["git", "show", ":config/records.tsv"], cwd=ROOT, capture_output=True, text=True, encoding="utf-8", check=False
    ).stdout  # without the records that a user has added
    lines = (shipped or (ROOT / "config" / "records.tsv").read_text(encoding="utf-8")).splitlines()
    known = {row["id"] for row in csv.DictReader((line for line in lines if line[:1] != "#"), delimiter="\t")}
    assert "wtmc" in known
    added = re.findall(r"^ *overturning records add .*--id (\S+)", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert known.isdisjoint(added), "the command is refused: the id is in config/records.tsv already"


def test_every_docs_page_is_in_the_table_of_contents():
    contents = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert [page.name for page in DOCS.rglob("*.md") if f": {page.relative_to(DOCS)}" not in contents] == []


@pytest.mark.long
def test_the_site_builds_with_checked_links_and_an_executed_notebook(tmp_path):
    if importlib.util.find_spec("material") is None:
        skip_test_unless_skipping_is_forbidden("mkdocs-material is not installed (group docs)")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    start = (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
    outside = re.findall(r'(?:src|href)="(https?://[^"]+)"', start)
    assert [link for link in outside if not link.startswith("https://squidfunk.github.io")] == []
    method = (tmp_path / "site" / "method.html").read_text(encoding="utf-8")
    formulas = (DOCS / "method.md").read_text(encoding="utf-8").count("```math")
    assert method.count('<div class="formula"><math') == formulas >= 16
    assert "\\tfrac" not in method
    # What stands below the item of a list belongs to it, and the numbers go on.
    assert re.search(r"<ol>\s*<li>\s*<p><em>Predict</em>(?:(?!</ol>).)*<li>\s*<p><em>Commit", method, flags=re.DOTALL)
    notebook = (tmp_path / "site" / "first-look.html").read_text(encoding="utf-8")
    assert "561 samples of 0.005 s" in notebook
    assert notebook.count('<img alt="figure') == 2
    assert "of the cases overturn" in notebook
