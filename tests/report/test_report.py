"""The report of tiny studies, on the page, on paper, and in a browser."""

import html.parser
import json
import re
import sys
from pathlib import Path

import pytest

from overturning.report.content import content
from overturning.report.page import write_report
from overturning.study.recheck import recheck

sys.path.insert(0, str(Path(__file__).parents[1] / "figures"))
from chromium import browser
from tiny_studies import pulse_record


class Balance(html.parser.HTMLParser):
    """Every element that is opened is closed, in order."""

    VOID = frozenset({"meta", "img", "br", "input", "link", "hr"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        assert self.open, tag
        assert self.open.pop() == tag, tag


def report_of(folder: Path) -> tuple[str, bytes]:
    write_report(folder, folder / "report.html", folder / "report.pdf")
    page = (folder / "report.html").read_text(encoding="utf-8")
    parser = Balance()
    parser.feed(page)
    assert parser.open == []
    for word in (">nan", "NaN", ">None", "inf%", "nan°"):
        assert word not in re.sub(
            r"<svg.*?</svg>|<script.*?</script>|<pre>.*?</pre>|src=\"data:[^\"]*\"", "", page, flags=re.DOTALL
        ), word
    return page, (folder / "report.pdf").read_bytes()


def answer_of(folder: Path) -> str:
    return " ".join(content(folder)["answer"])


def test_the_same_bytes(hostile: Path) -> None:
    first = report_of(hostile)
    assert report_of(hostile) == first
    assert first[1].startswith(b"%PDF")


def test_nothing_from_outside_and_nothing_run(hostile: Path) -> None:
    page, _ = report_of(hostile)
    assert "<script>window.hurt" not in page
    assert "&lt;script&gt;window.hurt" in page
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    for script in re.findall(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL):
        json.loads(script)


@pytest.mark.browser
def test_in_a_browser(hostile: Path, tmp_path: Path) -> None:
    report_of(hostile)
    with browser(tmp_path / "profile", 1000, 900) as page:
        page.open(hostile / "report.html")
        assert page.evaluate("window.hurt") is None
        assert page.evaluate("document.title") == "<script>window.hurt = 1</script>"
        films = page.evaluate("document.querySelectorAll('.film[data-ready=true]').length")
        assert films == len(content(hostile)["telling"]) >= 1
        # A click on a heading sorts, another one turns the order.
        column = "[...document.querySelectorAll('#peaks tbody tr')].map(r => r.cells[0].textContent)"
        assert page.evaluate(column) == ["one", "two"]
        page.click("#peaks th")
        page.click("#peaks th")
        assert page.evaluate(column) == ["two", "one"]
        page.click("#peaks th:nth-child(6)")
        assert page.evaluate(column) == ["two", "one"]  # by PGA, as numbers
        assert page.complaints == []
        # On a phone nothing is wider than the screen but what scrolls by itself.
        page.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")
        page.evaluate("document.querySelectorAll('td').forEach(d => d.append(' and some more'))")
        page.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_fall_normal_to_the_fault_is_said(results) -> None:
    records = [
        pulse_record(f"r{i}", 20.0 + 40 * i, 6.0, fault_strike_deg=290.0 + 40 * i, extra={"pulse": True})
        for i in range(4)
    ]
    folder = results(records, azimuth={"step": 20}, ensemble={"members": 0})
    report_of(folder)
    text = answer_of(folder)
    assert text.startswith("Blocks fall on average ")
    assert " ± " in text.split(":")[0]
    assert "(4 earthquakes)" in text
    assert "falls lie closer to the fault normal than to the fault" in text
    assert "4 of 4 earthquakes lie closer to the normal" in text


def test_one_record(results) -> None:
    folder = results([pulse_record("only", 60, 6.0, fault_strike_deg=330.0)], ensemble={"members": 0})
    page, _ = report_of(folder)
    assert "1 record of 1 earthquake." in page
    assert "from the fault normal (1 earthquake): " in answer_of(folder)
    assert "1 earthquake is too few for an interval" in answer_of(folder)


def test_a_map_where_coordinates_are_known(results) -> None:
    place = {"event": "Tottori", "fault_strike_deg": 330.0}
    epicentre = {"event_latitude": 35.275, "event_longitude": 133.35}
    records = [
        pulse_record("near", 60, 6.0, latitude=35.275, longitude=133.46, extra=epicentre, **place),
        pulse_record("far", 60, 6.0, latitude=35.725, longitude=133.35, **place),
        pulse_record("alone", 60, 6.0, latitude=10.0, longitude=20.0),  # one point is no map
    ]
    folder = results(records, ensemble={"members": 0})
    page, _ = report_of(folder)
    # A degree of latitude is 111.2 km; of longitude cos 35.275° of that.
    assert (
        "near: 10 km from the epicentre, in the direction 90°. far: 50 km from the epicentre, in the direction 0°."
        in page
    )
    assert [path.name for path in (folder / "figures" / "maps").iterdir()] == ["1.svg"]
    assert 'aria-label="map: Tottori"' in page


def test_no_map_and_no_gap_without_coordinates(hostile: Path) -> None:
    page, _ = report_of(hostile)
    assert "epicentre" not in page
    assert "map: " not in page


def test_no_falls(results) -> None:
    folder = results([pulse_record("weak", 60, 0.1, fault_strike_deg=330.0)])
    page, _ = report_of(folder)
    assert "No block overturned in any direction" in page
    assert "No fit: nothing falls" in page
    # No table of nothing but dashes.
    assert "Rayleigh" not in page
    assert 'id="rose"' not in page
    assert 'id="directions"' not in page


def test_everything_falls(results) -> None:
    still = pulse_record("strong", 60, 30.0, fault_strike_deg=330.0)
    turned = pulse_record("strong", 150, 30.0)
    both = type(still)(**{**vars(still), "north": still.north + turned.north, "east": still.east + 1.1 * turned.east})
    folder = results([both], b_over_h=[0.02, 0.03], azimuth={"start": 0, "stop": 90, "step": 30})
    page, _ = report_of(folder)
    assert content(folder)["fallen"] == 1
    assert "there is no axis along which blocks fall more easily" in page
    assert "Rayleigh" not in page  # no axis is told either


def test_an_unknown_fault(results) -> None:
    folder = results([pulse_record("only", 60, 6.0)], ensemble={"members": 0})
    page, _ = report_of(folder)
    assert "no fault normal is known" in page
    assert "only: mean fall direction " in page  # of the station of that name
    assert "fall axis relative to the fault normal" not in page


def test_one_azimuth(results) -> None:
    folder = results(
        [pulse_record("only", 60, 6.0)], azimuth={"start": 60, "stop": 61, "step": 10}, ensemble={"members": 0}
    )
    page, _ = report_of(folder)
    assert "with a single plane of motion nothing is said about direction" in page


def test_recheck(hostile: Path, tmp_path: Path) -> None:
    found = recheck(hostile / "cube.nc", cells=40)
    assert found.same
    assert found.cells == 40
    assert found.ensemble_cells > 0
    changed = tmp_path / "cube.nc"
    changed.write_bytes((hostile / "cube.nc").read_bytes())
    from netCDF4 import Dataset

    with Dataset(changed, "a") as file:
        file.set_auto_maskandscale(False)
        file["overturned"][:] = 1 - file["overturned"][:]
    spoilt = recheck(changed, hostile / "motion", cells=10)
    assert not spoilt.content_as_stated
    assert len(spoilt.differences) >= 5
    assert "overturned is" in spoilt.differences[0]
