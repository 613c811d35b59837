"""Self-contained HTML pages: templates, the film player, and JSON that is safe inside a script element."""

import json
from base64 import b64encode
from html import escape
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from overturning.figures.film import Film
from overturning.figures.film_words import KEYBOARD_HELP_TEXT
from overturning.files import write_text
from overturning.translation.texts import ENGLISH, current_language, translate, translate_nested_texts_except_data


def read_template_text(file_name: str, subpackage: str = "figures") -> str:
    """Return the text of a file in the folder ``templates`` of a subpackage of `overturning`."""
    return resources.files("overturning").joinpath(subpackage, "templates", file_name).read_text(encoding="utf-8")


def film_player_script() -> str:
    """Return the script of the film player, including the drawing of 3-D bodies; a page needs it once."""
    return "".join(map(read_template_text, ("page.js", "space.js", "player.js")))


def json_for_script(data: Any) -> str:
    """Return data as JSON that is safe inside an HTML script element: the characters <, > and & are escaped."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def render_page_template(template_name: str, style_sheet: str, javascript: str, script_data: Any, **more: Any) -> str:
    """Fill an HTML page template with a style sheet, a script, its data and further template variables (`more`).

    Plain texts in `more` are HTML-escaped. The page loads nothing from the network and is reproducible.
    """
    import jinja2
    from markupsafe import Markup

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    own = {"css": Markup(style_sheet), "js": Markup(javascript), "data": Markup(json_for_script(script_data))}
    return environment.from_string(read_template_text(template_name)).render(**own, **more)


def film_html_element(
    film_player_data: dict[str, Any], film_strip_path: Path | None = None, alternative_text: str = ""
) -> str:
    """Return the HTML element of a film; the script `film_player_script` turns it into a player.

    Parameters
    ----------
    film_player_data : dict
        Film, from `overturning.figures.film.Film.player_data`.
    film_strip_path : path, optional
        Strip of the film (SVG or PNG), shown in print and without JavaScript.
    alternative_text : str
        Alternative text of the strip.
    """
    shown = ""
    if film_strip_path is not None:
        kind = {".svg": "image/svg+xml", ".png": "image/png"}[film_strip_path.suffix]
        source = f"data:{kind};base64,{b64encode(film_strip_path.read_bytes()).decode('ascii')}"
        shown = f'<figure class="film-strip"><img alt="{escape(alternative_text)}" src="{source}"></figure>'
    texts = json_for_script(
        translate_nested_texts_except_data(film_player_data) if current_language() != ENGLISH else film_player_data
    )
    return f'<div class="film"><script type="application/json">{texts}</script>{shown}</div>'


def film_page_html(film: Film) -> str:
    """Return the HTML page of a film with its player; when printed, it shows four frames instead."""
    from markupsafe import Markup

    from overturning.figures.film_strip import film_strip_figure
    from overturning.figures.style import use_package_matplotlib_settings
    from overturning.figures.write import save_figure_files

    with TemporaryDirectory() as folder, use_package_matplotlib_settings():
        strip = Path(folder) / "strip.svg"
        save_figure_files(film_strip_figure(film, has_title=False), strip)
        player = Markup(film_html_element(film.player_data(), strip, translate(film.title)))
    about = {
        "title": translate(film.title),
        "player": player,
        "keys": [translate(one) for one in (KEYBOARD_HELP_TEXT, film.panels[0].keyboard_help_specific_to_2d_or_3d)],
        "language": current_language(),
    }
    return render_page_template("film.html.j2", read_template_text("player.css"), film_player_script(), {}, **about)


def write_film_html_page(film: Film, path: Path) -> None:
    """Write the HTML page of a film to a file."""
    write_text(path, film_page_html(film))
