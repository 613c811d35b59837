"""Results of tiny studies."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tiny_studies import make_results, pulse_record

from overturning.records.record import Record

Make = Callable[..., Path]


@pytest.fixture(scope="session")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two records whose names come from a file that means harm."""
    bad = "<script>window.hurt = 1</script>"
    records = [
        pulse_record(
            "one",
            60,
            6.0,
            station=bad,
            event="#panic() $x^2$ $\\foo$ & co",
            fault_strike_deg=330.0,
            extra={"pulse": True},
        ),
        pulse_record("two", 10, 5.0, event=bad, fault_strike_deg=300.0, extra={"pulse": False}),
    ]
    return make_results(tmp_path_factory.mktemp("hostile"), records, title=bad, azimuth={"step": 15})


@pytest.fixture
def results(tmp_path: Path) -> Make:
    def make(records: list[Record], **study: Any) -> Path:
        return make_results(tmp_path, records, **study)

    return make
