"""Self-contained pages (HTML): templates of the package, the player of films, data that cannot end their script."""

import json
from importlib import resources
from pathlib import Path
from typing import Any

from overturning.figures.film import Film
from overturning.files import write_text


def template(name: str, room: str = "figures") -> str:
    """The text of a template of this package."""
    return resources.files("overturning").joinpath(room, "templates", name).read_text(encoding="utf-8")


def player_script() -> str:
    """The player, once per page, with what draws bodies in space."""
    return "".join(map(template, ("page.js", "space.js", "player.js")))


def embedded_json(data: Any) -> str:
    """Data as JSON that cannot end the script element it stands in, whatever a record is called."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def page(name: str, css: str, js: str, data: Any, **more: Any) -> str:
    """A template's page with style, script and data of the package's own, and more that is escaped.

    Nothing in it comes from outside, and it is the same each time.
    """
    import jinja2
    from markupsafe import Markup

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    own = {"css": Markup(css), "js": Markup(js), "data": Markup(embedded_json(data))}
    return environment.from_string(template(name)).render(**own, **more)


def film_page(film: Film) -> str:
    """The page of a film."""
    return page("film.html.j2", template("player.css"), player_script(), film.data(), film=film)


def write_film_page(film: Film, path: Path) -> None:
    """Write the page of a film into a file."""
    write_text(path, film_page(film))
