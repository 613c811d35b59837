"""Results of a tiny study, swept once."""

from collections.abc import Callable
from pathlib import Path

import pytest

from overturning.findings.collect import findings, write_findings
from overturning.report.write import write_report
from tests.report.test_rendering import BAD, elements
from tests.report.tiny_studies import make_results, pulse_record


@pytest.fixture(scope="session")
def hostile(made_once: Callable[[str, Callable[[Path], object]], Path]) -> Path:
    """Two records whose names come from a file that means harm, one with a pulse and one without."""
    pulse = {
        "station": BAD,
        "event": "#panic() $x^2$ $\\foo$ & co",
        "fault_strike_deg": 330.0,
        "extra": {"pulse": True},
    }
    without = {"event": BAD, "fault_strike_deg": 300.0, "extra": {"pulse": False}}
    records = [pulse_record("one", 60, 6.0, **pulse), pulse_record("two", 10, 5.0, **without)]
    return made_once("hostile", lambda folder: make_results(folder, records, title=BAD, azimuth={"step": 15}))


def report_of(folder: Path) -> tuple[str, bytes]:
    """Return page and PDF of a results folder; the page is well formed."""
    write_findings(findings(folder), folder / "findings.json")
    write_report(folder, folder / "report.html", folder / "report.pdf")
    page = (folder / "report.html").read_text(encoding="utf-8")
    elements(page)
    return page, (folder / "report.pdf").read_bytes()


@pytest.fixture(scope="session")
def rendered(hostile: Path) -> tuple[str, bytes]:
    """Page and PDF."""
    return report_of(hostile)
