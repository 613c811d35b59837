"""The report of a tiny study on the page and on paper."""

import json
import re
from pathlib import Path

from overturning.report.write import write_report
from overturning.study.cube import open_cube, study_of_cube
from overturning.study.recheck import recheck
from overturning.translation.texts import installed_fonts_of_language
from tests.expect import lacking
from tests.report.conftest import report_of


def test_the_same_bytes(hostile: Path, rendered: tuple[str, bytes]) -> None:
    assert report_of(hostile) == rendered
    assert rendered[1].startswith(b"%PDF")


def test_nothing_from_outside_and_nothing_run(rendered: tuple[str, bytes]) -> None:
    page, _ = rendered
    assert "<script>window.hurt" not in page
    assert "&lt;script&gt;window.hurt" in page
    # The page names only the page next to it, and works without it.
    assert set(re.findall(r'(?:src|href)="(?!#|data:)([^"#]*)', page)) == {"explore.html"}
    for script in re.findall(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL):
        json.loads(script)


def test_the_language_of_a_study_and_of_the_command(rendered: tuple[str, bytes], hostile: Path, tmp_path: Path) -> None:
    with open_cube(hostile / "cube.nc") as cube:
        study = study_of_cube(cube)
    assert study.language == "en"
    japanese, other, pdf = tmp_path / "ja.html", tmp_path / "other.html", tmp_path / "ja.pdf"
    font = bool(installed_fonts_of_language("ja"))
    write_report(hostile, japanese, pdf if font else None, study.model_copy(update={"language": "ja"}))
    write_report(hostile, other, language="ja")
    page = japanese.read_text(encoding="utf-8")
    assert page == other.read_text(encoding="utf-8")
    assert '<html lang="ja">' in page
    assert "<b>図1.</b>" in page
    assert '<html lang="en">' in rendered[0]
    if not font:
        lacking("no Japanese font (Debian package fonts-noto-cjk): the PDF is not written")
    assert pdf.read_bytes().startswith(b"%PDF")


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
