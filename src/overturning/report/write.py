"""The report of a study, from its results to the files."""

from pathlib import Path

from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.report.blocks import Figure, each_block
from overturning.report.build import build_report
from overturning.report.html import pieces_of
from overturning.report.pdf import render_pdf
from overturning.report.results import open_results
from overturning.study.schema import Study


def write_report(results: Path, path: Path, pdf: Path | None = None, beside: Study | None = None) -> None:
    """Write the report of a study's folder of results as a page (HTML), and as PDF, the same bytes each time.

    Title, question, surveys, population and settings of the figures are those of `beside`, or of the cube's study where
    it is not given. `ResultError` if a result is missing.
    """
    with open_results(results, beside) as opened:
        report = build_report(opened)
        for block in each_block(report):
            if isinstance(block, Figure) and not block.path.is_file():
                raise ResultError(f"{block.path}: no such figure; run the figures of the study first")
        with atomic_write(path) as part, part.open("w", encoding="utf-8") as page:
            page.writelines(pieces_of(report))
        if pdf is not None:
            with atomic_write(pdf) as part:
                part.write_bytes(render_pdf(report))
