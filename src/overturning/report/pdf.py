"""The report as PDF, by typst. No words of the report stand here; all text reaches typst as data, never as markup."""

import json
import shutil
import tempfile
from dataclasses import asdict
from importlib import resources
from pathlib import Path
from typing import Any

from overturning.errors import ResultError
from overturning.report.blocks import Block, Disclosure, Figure, Film, Paragraph, Report, Row, Section, each_block


def paper_data(report: Report) -> dict[str, Any]:
    """The report as plain data for typst.

    Parameters
    ----------
    report : Report
        What it says.

    Returns
    -------
    dict
        Title, question and blocks; each block with its class as ``kind``, a figure with its number in the place of its
        file, a film as the text that stands for it.
    """
    numbers = {figure: f"{number}{figure.path.suffix}" for number, figure in enumerate(_figures(report), 1)}

    def plain(blocks: tuple[Block, ...]) -> list[dict[str, Any]]:
        shown = []
        for block in blocks:
            if isinstance(block, Paragraph) and block.medium == "page":
                continue
            one = Paragraph(block.text) if isinstance(block, Film) else block
            more: dict[str, Any] = {"kind": type(one).__name__.lower()}
            if isinstance(one, Row | Disclosure | Section):
                data = {name: value for name, value in vars(one).items() if name != "blocks"}
                more["blocks"] = plain(one.blocks)
            else:
                data = asdict(one)
            if isinstance(one, Figure):
                data["path"] = numbers[one]
            shown.append(data | more)
        return shown

    return {"title": report.title, "question": report.question, "blocks": plain(report.sections)}


def _figures(report: Report) -> list[Figure]:
    return list(dict.fromkeys(block for block in each_block(report.sections) if isinstance(block, Figure)))


def render_pdf(report: Report) -> bytes:
    """The pages, the same bytes each time.

    Parameters
    ----------
    report : Report
        What they say.

    Returns
    -------
    bytes
        The PDF.

    Raises
    ------
    ResultError
        If a figure cannot be read.
    """
    import typst

    template = resources.files("overturning").joinpath("report/templates/report.typ").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "report.typ").write_text(template, encoding="utf-8")
        (folder / "data.json").write_text(json.dumps(paper_data(report), ensure_ascii=False), encoding="utf-8")
        for number, figure in enumerate(_figures(report), 1):
            shutil.copyfile(figure.path, folder / f"{number}{figure.path.suffix}")
        try:
            # Only the fonts that come with typst, and no clock: the same pages on every machine.
            pages: bytes = typst.compile(
                folder / "report.typ", root=folder, format="pdf", ignore_system_fonts=True, font_paths=[], timestamp=0
            )
        except typst.TypstError as error:
            reason = str(error).splitlines()[0]
            raise ResultError(f"the PDF of the report cannot be made ({reason}); draw the figures again") from None
    return pages
