"""The report of a tiny study, on the page, on paper, and in a browser."""

import json
import re
import sys
from pathlib import Path

import pytest

from overturning.report.blocks import Film, Report, each_block
from overturning.study.recheck import recheck
from tests.report.reading import report_of

sys.path.insert(0, str(Path(__file__).parents[1] / "figures"))
from tests.figures.chromium import browser


def test_the_same_bytes(hostile: Path, rendered: tuple[str, bytes]) -> None:
    assert report_of(hostile) == rendered
    assert rendered[1].startswith(b"%PDF")


def test_nothing_from_outside_and_nothing_run(rendered: tuple[str, bytes]) -> None:
    page, _ = rendered
    assert "<script>window.hurt" not in page
    assert "&lt;script&gt;window.hurt" in page
    # The page beside it is the only thing it names, and does without.
    assert set(re.findall(r'(?:src|href)="(?!#|data:)([^"]*)', page)) == {"explore.html"}
    for script in re.findall(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL):
        json.loads(script)


@pytest.mark.browser
def test_in_a_browser(rendered: tuple[str, bytes], report: Report, tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text(rendered[0], encoding="utf-8")
    with browser(tmp_path / "profile", 1000, 900) as page:
        page.open(tmp_path / "report.html")
        assert page.evaluate("window.hurt") is None
        assert page.evaluate("document.title") == "<script>window.hurt = 1</script>"
        films = page.evaluate("document.querySelectorAll('.film[data-ready=true]').length")
        assert films == sum(isinstance(block, Film) for block in each_block(report)) >= 1
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
