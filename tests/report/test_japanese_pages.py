"""Report and explorer in Japanese: no English word is left on the pages, and letters are legible on a phone."""

import base64
import json
import re
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from overturning.figures.explore import explorer_page_data, explorer_page_html
from overturning.translation.texts import translate_visible_texts_to
from tests.figures.test_explore import cube, space_cube
from tests.figures.test_japanese_figures import svg_texts
from tests.report.browsers import answers
from tests.report.test_explorer_in_browsers import HELPERS, painted
from tests.translation.test_tables import english_words

ALL_TEXTS = """
const shown = (page) => {
  const parts = [];
  const walk = (node) => {
    if (node.nodeType === 3) parts.push(node.data);
    else if (!["SCRIPT", "STYLE", "CODE"].includes(node.tagName)) {
      if (node.nodeType === 1) for (const name of ["aria-label", "aria-valuetext", "title", "aria-roledescription"])
        parts.push(node.getAttribute(name) || "");
      node.childNodes.forEach(walk); } };
  walk(page.body);
  return parts.join(" "); };
const drawn = [];
const write = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...more) {
  drawn.push(text);
  write.call(this, text, ...more); };
const seen = [document.title];
for (const option of document.querySelector("select[data-name=colour]").options) {
  choose("colour", option.value);
  seen.push(shown(document)); }
for (const key of ["ArrowUp", "ArrowUp", "ArrowRight", "ArrowRight"]) {
  press(canvas, key); seen.push(shown(document)); }
point("pointermove", 180, 0.5); seen.push(shown(document));
location.hash = "#record=none&azimuth=x&b_over_h=7";
await new Promise((done) => setTimeout(done, 200));
seen.push(shown(document));
return {texts: seen.join(" "), drawn: drawn.join(" ")};
"""
LETTERS = """
const {wide, seen} = await onPhone((page) => {
  const sizes = [];
  for (const one of page.querySelectorAll("figure > svg, figure > .narrow > svg")) {
    if (!one.getBoundingClientRect().width) continue;  // in a fold
    const scale = one.getBoundingClientRect().width / one.viewBox.baseVal.width;
    for (const text of one.querySelectorAll("text")) sizes.push(scale * parseFloat(text.style.fontSize)); }
  return [Math.min(...sizes), sizes.length]; });
return {wide, least: seen[0], letters: seen[1]};
"""
NAMES = {"script", "window", "hurt", "none", "space", "report", "HTML", "html"}
"""Parts of the hostile names, and of an address, that no table translates."""


@pytest.mark.browser
def test_the_explorer_has_no_english_word(tmp_path: Path) -> None:
    with translate_visible_texts_to("ja"):
        pages = {
            name: (explorer_page_html(explorer_page_data(data), "report.html"), HELPERS + ALL_TEXTS)
            for name, data in (("2-D", cube()), ("part", painted()), ("3-D", space_cube()))
        }
    for name, found in answers("chromium", pages, tmp_path / "profile").items():
        assert not english_words(found["texts"]) - NAMES, name
        assert not english_words(found["drawn"]) - NAMES, name
        assert re.search("[ぁ-ん]", found["drawn"]), name


def test_figures_and_films_of_the_report_have_no_english_word(japanese: tuple[str, bytes]) -> None:
    page, _ = japanese
    folded = re.findall(r"data:image/svg\+xml;base64,([^\"]+)", page)
    drawings = [base64.b64decode(one).decode("utf-8") for one in folded]
    drawings += re.findall(r"<svg .*?</svg>", page, flags=re.DOTALL)
    assert len(drawings) >= 8
    names = NAMES | {"event", "two", "one", "panic", "foo", "amp", "Tiny", "synthetic"}
    for drawing in drawings:
        assert not english_words(svg_texts(unescape(drawing))) - names
    films = re.findall(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL)
    assert films
    for film in films:
        assert not english_words(" ".join(texts_of(json.loads(film)))) - names


def texts_of(data: Any) -> Iterator[str]:
    """Yield the texts of a film; names of bodies, which are not shown, and packed numbers are left out."""
    if isinstance(data, dict):
        for key, one in data.items():
            yield from texts_of(one) if key not in ("data", "name") else ()
    elif isinstance(data, list):
        for one in data:
            yield from texts_of(one)
    elif isinstance(data, str):
        yield data


@pytest.mark.browser
def test_letters_of_figures_are_legible_on_a_phone(rendered: tuple[str, bytes], tmp_path: Path) -> None:
    found = answers("chromium", {"report": (rendered[0], LETTERS)}, tmp_path / "profile")["report"]
    assert found["letters"] > 20
    assert found["least"] >= 9.0
    assert found["wide"] <= 390
