"""Results of tiny studies: two that are swept once, and what is made of one of them in memory."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from overturning.report.blocks import Report
from overturning.report.build import build_report
from overturning.report.results import Results, open_results
from tests.report.reading import BAD, report_of
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


@pytest.fixture(scope="session")
def opened(hostile: Path) -> Results:
    """All of it in memory, the file closed."""
    with open_results(hostile) as results:
        cube, intensity = results.cube.load(), results.intensity.load()
        return replace(results, cube=cube, cubes={"nominal": cube}, intensity=intensity)


@pytest.fixture(scope="session")
def report(opened: Results) -> Report:
    return build_report(opened)


@pytest.fixture(scope="session")
def rendered(hostile: Path) -> tuple[str, bytes]:
    """Page and paper."""
    return report_of(hostile)


@pytest.fixture
def one_record(opened: Results) -> Callable[..., Results]:
    """Results of as many copies as wanted of the record with a pulse, each of an earthquake of its own."""

    def make(copies: int = 1, azimuth: slice = slice(None), **values: Any) -> Results:
        chosen = [0] * copies
        names = {name: ("record", [f"{name} {i}" for i in range(copies)]) for name in ("station", "event", "record_id")}
        cube = opened.cube.isel(record=chosen, azimuth=azimuth).load().assign(names)
        for name, value in values.items():
            cube[name] = xr.zeros_like(cube[name]) + value
        intensity = opened.intensity.isel(record=chosen, azimuth=azimuth).load()
        # Figures of a missing study are only named.
        return replace(opened, cube=cube, cubes={"nominal": cube}, intensity=intensity)

    return make
