"""The report as one self-contained HTML page, the same bytes each time it is made."""

import base64
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

from overturning.errors import ResultError
from overturning.files import atomic_write


def write_report(results: Path, path: Path, pdf: Path | None = None) -> None:
    """Write the report of a study.

    Parameters
    ----------
    results : Path
        Folder of the study's results: cube, intensities and figures.
    path : Path
        The page to make.
    pdf : Path, optional
        The same on paper.

    Raises
    ------
    ResultError
        If a result is missing.
    """
    import jinja2
    from markupsafe import Markup

    from overturning.figures.film_page import embedded_json, player_script, player_style
    from overturning.report.content import content
    from overturning.report.paper import write_paper
    from overturning.report.sentences import percent

    data = content(results)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("overturning", "report/templates"),
        autoescape=True,  # names come from files: a station called <script> is shown, not run
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["percent"] = percent
    environment.filters["asdict"] = asdict

    def figure(name: str, text: str) -> Any:
        return Markup(inline_figure(results / "figures" / name, text))

    films = {number: Markup(embedded_json(case["film"])) for number, case in enumerate(data["telling"], 1)}
    page = environment.get_template("report.html.j2").render(
        **data, figure=figure, films=films, player=Markup(player_script()), player_style=Markup(player_style())
    )
    with atomic_write(path) as part:
        part.write_text(page, encoding="utf-8")
    if pdf is not None:
        write_paper(data, results / "figures", pdf)


def inline_figure(path: Path, text: str) -> str:
    """A figure to stand inside a page: an SVG as an element, a PNG as data.

    Parameters
    ----------
    path : Path
        The figure, .svg or .png.
    text : str
        What it shows, for those who cannot see it.

    Returns
    -------
    str
        HTML.

    Raises
    ------
    ResultError
        If the figure is not there.
    """
    from markupsafe import escape

    if path.suffix == ".svg":
        return inline_svg(path).replace("<svg", f'<svg role="img" aria-label="{escape(text)}"', 1)
    if not path.is_file():
        raise ResultError(f"{path}: no such figure; run the figures of the study first")
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img alt="{escape(text)}" src="data:image/png;base64,{data}">'


def inline_svg(path: Path) -> str:
    """An SVG figure to stand inside a page.

    Identifiers are given the figure's name, since those of two figures would otherwise be one in the page.

    Parameters
    ----------
    path : Path
        The figure.

    Returns
    -------
    str
        The ``svg`` element.

    Raises
    ------
    ResultError
        If the figure is not there.
    """
    if not path.is_file():
        raise ResultError(f"{path}: no such figure; run the figures of the study first")
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    prefix = re.sub(r"\W", "-", f"{path.parent.name}-{path.stem}")
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'(\bid="|xlink:href="#|href="#|url\(#)', rf"\g<1>{prefix}-", text)
    size = re.search(r'<svg[^>]*? width="([0-9.]+)pt"', text)
    if size is None:
        return text
    # As wide as it was drawn where there is room, so that its letters are as large as those around it.
    style = f' style="width:100%;max-width:{float(size[1]) * 4 / 3 / 16:.1f}rem"'
    for name in ("width", "height"):
        text = re.sub(rf'(<svg[^>]*?) {name}="[0-9.]+pt"', r"\1", text, count=1)
    return text.replace("<svg", f"<svg{style}", 1)
