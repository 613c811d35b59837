"""Results and reports of a tiny study, made once."""

from collections.abc import Callable
from pathlib import Path

import pytest

from overturning.findings.collect import findings, write_findings
from overturning.report.write import write_report
from overturning.study.cube import open_cube, study_of_cube
from overturning.study.schema import Study
from overturning.translation.texts import installed_fonts_of_language
from tests.report.test_rendering import SCRIPT_AS_NAME, elements_of_well_formed_page
from tests.report.tiny_studies import pulse_record, simulate_study_into_result_folder

REPORT_PAGE_FILE_NAME, REPORT_PDF_FILE_NAME = "report.html", "report.pdf"
SharedFolderMaker = Callable[[str, Callable[[Path], object]], Path]


@pytest.fixture(scope="session")
def results_with_hostile_names(make_folder_once: SharedFolderMaker) -> Path:
    """Return the results of a study of two records, with and without a pulse, whose names contain scripts."""
    pulse = {
        "station": SCRIPT_AS_NAME,
        "event": "#panic() $x^2$ $\\foo$ & co",
        "fault_strike_deg": 330.0,
        "extra": {"pulse": True},
    }
    without = {"event": SCRIPT_AS_NAME, "fault_strike_deg": 300.0, "extra": {"pulse": False}}
    records = [pulse_record("one", 60, 6.0, **pulse), pulse_record("two", 10, 5.0, **without)]

    def write_results_and_findings(folder: Path) -> None:
        simulate_study_into_result_folder(folder, records, title=SCRIPT_AS_NAME, azimuth={"step": 15})
        write_findings(findings(folder), folder / "findings.json")

    return make_folder_once("hostile", write_results_and_findings)


@pytest.fixture(scope="session")
def report_page_and_pdf(results_with_hostile_names: Path, make_folder_once: SharedFolderMaker) -> tuple[str, bytes]:
    """Return page and PDF of a report in which names of records contain HTML and scripts; the page is well formed."""
    folder = make_folder_once(
        "rendered",
        lambda folder: write_report(
            results_with_hostile_names, folder / REPORT_PAGE_FILE_NAME, folder / REPORT_PDF_FILE_NAME
        ),
    )
    page = (folder / REPORT_PAGE_FILE_NAME).read_text(encoding="utf-8")
    elements_of_well_formed_page(page)
    return page, (folder / REPORT_PDF_FILE_NAME).read_bytes()


@pytest.fixture(scope="session")
def study_in_japanese(results_with_hostile_names: Path) -> Study:
    """Return the study of the results with hostile names, with Japanese as its language."""
    with open_cube(results_with_hostile_names / "cube.nc") as cube:
        study = study_of_cube(cube)
    assert study.language == "en"
    return study.model_copy(update={"language": "ja"})


@pytest.fixture(scope="session")
def japanese_report_page_and_pdf(
    results_with_hostile_names: Path, study_in_japanese: Study, make_folder_once: SharedFolderMaker
) -> tuple[str, bytes]:
    """Return page and PDF of the report in Japanese; the PDF is empty where there is no Japanese font."""

    def write_japanese_report(folder: Path) -> None:
        pdf = folder / REPORT_PDF_FILE_NAME if installed_fonts_of_language("ja") else None
        write_report(results_with_hostile_names, folder / REPORT_PAGE_FILE_NAME, pdf, study_in_japanese)

    folder = make_folder_once("japanese", write_japanese_report)
    pdf = folder / REPORT_PDF_FILE_NAME
    return (folder / REPORT_PAGE_FILE_NAME).read_text(encoding="utf-8"), pdf.read_bytes() if pdf.is_file() else b""
