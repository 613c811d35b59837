"""The report in Japanese: no English word is left in its figures and films."""

import base64
import json
import re
from collections.abc import Iterator
from html import unescape
from typing import Any

from tests.figures.test_japanese_figures import svg_texts
from tests.report.test_explorer_in_browsers import NAMES
from tests.translation.test_tables import english_words


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
