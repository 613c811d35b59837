"""A film as one self-contained HTML page, or as an element of another page."""

import json
from importlib import resources
from pathlib import Path
from typing import Any

from overturning.figures.film import Film, film_data
from overturning.files import atomic_write


def _template(name: str) -> str:
    return resources.files("overturning").joinpath("figures/templates", name).read_text(encoding="utf-8")


def player_script() -> str:
    """The player, once per page, with what draws bodies in space."""
    return _template("space.js") + _template("player.js")


def player_style() -> str:
    """Its style sheet, once per page."""
    return _template("player.css")


def embedded_json(data: Any) -> str:
    """Data as JSON that cannot end the script element it stands in, whatever a record is called."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def film_page(film: Film) -> str:
    """The page (HTML): film, player and style, nothing from outside; the same each time."""
    import jinja2
    from markupsafe import Markup

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    parts: dict[str, Any] = {"css": player_style(), "js": player_script(), "data": embedded_json(film_data(film))}
    page = environment.from_string(_template("film.html.j2"))
    return page.render(film=film, **{name: Markup(text) for name, text in parts.items()})


def write_film_page(film: Film, path: Path) -> None:
    """Write the page into a file."""
    with atomic_write(path) as part:
        part.write_text(film_page(film), encoding="utf-8")
