"""Results and reports of a tiny study, made once."""

from collections.abc import Callable
from pathlib import Path

import pytest

from overturning.findings.collect import findings, write_findings
from overturning.report.write import write_report
from overturning.study.cube import open_cube, study_of_cube
from overturning.study.schema import Study
from overturning.translation.texts import installed_fonts_of_language
from tests.report.test_rendering import BAD, elements
from tests.report.tiny_studies import make_results, pulse_record

PAGE, PAPER = "report.html", "report.pdf"
Made = Callable[[str, Callable[[Path], object]], Path]


@pytest.fixture(scope="session")
def hostile(made_once: Made) -> Path:
    """Two records whose names come from a file that means harm, one with a pulse and one without."""
    pulse = {
        "station": BAD,
        "event": "#panic() $x^2$ $\\foo$ & co",
        "fault_strike_deg": 330.0,
        "extra": {"pulse": True},
    }
    without = {"event": BAD, "fault_strike_deg": 300.0, "extra": {"pulse": False}}
    records = [pulse_record("one", 60, 6.0, **pulse), pulse_record("two", 10, 5.0, **without)]

    def make(folder: Path) -> None:
        make_results(folder, records, title=BAD, azimuth={"step": 15})
        write_findings(findings(folder), folder / "findings.json")

    return made_once("hostile", make)


@pytest.fixture(scope="session")
def rendered(hostile: Path, made_once: Made) -> tuple[str, bytes]:
    """Page and PDF; the page is well formed."""
    folder = made_once("rendered", lambda folder: write_report(hostile, folder / PAGE, folder / PAPER))
    page = (folder / PAGE).read_text(encoding="utf-8")
    elements(page)
    return page, (folder / PAPER).read_bytes()


@pytest.fixture(scope="session")
def study_in_japanese(hostile: Path) -> Study:
    with open_cube(hostile / "cube.nc") as cube:
        study = study_of_cube(cube)
    assert study.language == "en"
    return study.model_copy(update={"language": "ja"})


@pytest.fixture(scope="session")
def japanese(hostile: Path, study_in_japanese: Study, made_once: Made) -> tuple[str, bytes]:
    """Page and PDF of the study in Japanese; the PDF is empty where there is no Japanese font."""

    def make(folder: Path) -> None:
        pdf = folder / PAPER if installed_fonts_of_language("ja") else None
        write_report(hostile, folder / PAGE, pdf, study_in_japanese)

    folder = made_once("japanese", make)
    pdf = folder / PAPER
    return (folder / PAGE).read_text(encoding="utf-8"), pdf.read_bytes() if pdf.is_file() else b""
