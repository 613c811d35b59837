"""The report as one self-contained HTML page, the same bytes each time it is made."""

import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

from overturning.errors import ResultError
from overturning.files import whole


def write_report(results: Path, path: Path) -> None:
    """Write the report of a study.

    Parameters
    ----------
    results : Path
        Folder of the study's results: cube, intensities and figures.
    path : Path
        The page to make.

    Raises
    ------
    ResultError
        If a result is missing.
    """
    import jinja2

    from overturning.report.content import content

    data = content(results)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("overturning", "report/templates"),
        autoescape=True,  # names come from files: a station called <script> is shown, not run
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["percent"] = lambda share: "–" if share != share else f"{share:.0%}"
    environment.filters["asdict"] = asdict

    def figure(name: str) -> Any:
        return jinja2.utils.markupsafe.Markup(inline_svg(results / "figures" / f"{name}.svg"))

    page = environment.get_template("report.html.j2").render(**data, figure=figure)
    with whole(path) as part:
        part.write_text(page, encoding="utf-8")


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
    return re.sub(
        r'(<svg[^>]*?) width="[^"]*pt"', r"\1", re.sub(r'(<svg[^>]*?) height="[^"]*pt"', r"\1", text, count=1), count=1
    )
