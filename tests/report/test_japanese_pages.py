"""The report in Japanese: no English word is left in its figures and films."""

import base64
import json
import re
from collections.abc import Iterator
from html import unescape
from typing import Any

from tests.figures.test_japanese_figures import svg_texts
from tests.report.test_explorer_in_browsers import UNTRANSLATED_NAMES
from tests.translation.test_tables import untranslated_latin_words


def test_figures_and_films_of_the_report_have_no_english_word(japanese_report_page_and_pdf: tuple[str, bytes]) -> None:
    page, _ = japanese_report_page_and_pdf
    folded = re.findall(r"data:image/svg\+xml;base64,([^\"]+)", page)
    drawings = [base64.b64decode(one).decode("utf-8") for one in folded]
    drawings += re.findall(r"<svg .*?</svg>", page, flags=re.DOTALL)
    assert len(drawings) >= 8
    names = UNTRANSLATED_NAMES | {"event", "two", "one", "panic", "foo", "amp", "Tiny", "synthetic"}
    for drawing in drawings:
        assert not untranslated_latin_words(svg_texts(unescape(drawing))) - names
    films = re.findall(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL)
    assert films
    for film in films:
        assert not untranslated_latin_words(" ".join(visible_texts_in_film_data(json.loads(film)))) - names


def visible_texts_in_film_data(data: Any) -> Iterator[str]:
    """Yield the texts of a film; names of bodies, which are not shown, and packed numbers are left out."""
    if isinstance(data, dict):
        for key, one in data.items():
            yield from visible_texts_in_film_data(one) if key not in ("data", "name") else ()
    elif isinstance(data, list):
        for one in data:
            yield from visible_texts_in_film_data(one)
    elif isinstance(data, str):
        yield data
