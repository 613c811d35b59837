"""The report of a tiny study on the page and on paper."""

import base64
import json
import re
from pathlib import Path

import numpy as np

from overturning.figures.explore import explorer_data
from overturning.records.store import read_motion
from overturning.study.cube import open_cube
from overturning.study.recheck import recheck
from tests.report.reading import report_of


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


def test_the_motion_of_the_sketch_is_that_of_the_record(hostile: Path) -> None:
    with open_cube(hostile / "cube.nc", element=None) as opened:
        data, without = explorer_data(opened, hostile / "motion"), explorer_data(opened, hostile)
    assert data["sketch"] == ""
    assert [record["cells"]["motion"] for record in without["records"]] == [None, None]
    for record in data["records"]:
        motion, given = record["cells"]["motion"], read_motion(hostile / "motion" / f"{record['id']}.nc")
        assert motion["interval"] == given.sampling_interval
        north, east = (np.frombuffer(base64.b64decode(part), "<i2") * motion["step"] for part in motion["components"])
        np.testing.assert_allclose(north, given.north, atol=motion["step"])
        np.testing.assert_allclose(east, given.east, atol=motion["step"])


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
