"""The report of a tiny study on the page and on paper."""

import json
import re
from pathlib import Path

from overturning.report.write import write_report
from overturning.study.recheck import recheck
from overturning.study.schema import Study
from tests.expect import lacking


def test_the_same_bytes_in_the_language_of_the_command(
    hostile: Path, rendered: tuple[str, bytes], study_in_japanese: Study, tmp_path: Path
) -> None:
    page, pdf = tmp_path / "again.html", tmp_path / "again.pdf"
    write_report(hostile, page, pdf, study_in_japanese, language="en")
    assert (page.read_text(encoding="utf-8"), pdf.read_bytes()) == rendered
    assert rendered[1].startswith(b"%PDF")


def test_nothing_from_outside_and_nothing_run(rendered: tuple[str, bytes]) -> None:
    page, _ = rendered
    assert "<script>window.hurt" not in page
    assert "&lt;script&gt;window.hurt" in page
    # The page names only the page next to it, and works without it.
    assert set(re.findall(r'(?:src|href)="(?!#|data:)([^"#]*)', page)) == {"explore.html"}
    for script in re.findall(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL):
        json.loads(script)


def test_the_language_of_a_study(rendered: tuple[str, bytes], japanese: tuple[str, bytes]) -> None:
    page, pdf = japanese
    assert '<html lang="ja">' in page
    assert "<b>図1.</b>" in page
    assert '<html lang="en">' in rendered[0]
    if not pdf:
        lacking("no Japanese font (Debian package fonts-noto-cjk): the PDF is not written")
    assert pdf.startswith(b"%PDF")


def test_recheck(hostile: Path, tmp_path: Path) -> None:
    found = recheck(hostile / "cube.nc", cell_count=40)
    assert found.is_identical
    assert found.cells == 40
    assert found.ensemble_cells > 0
    changed = tmp_path / "cube.nc"
    changed.write_bytes((hostile / "cube.nc").read_bytes())
    from netCDF4 import Dataset

    with Dataset(changed, "a") as file:
        file.set_auto_maskandscale(False)
        file["overturned"][:] = 1 - file["overturned"][:]
    spoilt = recheck(changed, hostile / "motion", cell_count=10)
    assert not spoilt.content_as_stated
    assert len(spoilt.differences) >= 5
    assert "overturned is" in spoilt.differences[0]
