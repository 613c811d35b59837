"""`overturning recheck` and `overturning survey` on a finished study."""

from pathlib import Path

import pytest
import xarray as xr

from overturning.cli import main
from overturning.surveys.comparison import read_survey_comparison


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    return int(stop.value.code or 0)


def test_recheck(hostile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("recheck", str(hostile / "cube.nc"), "--cells", "10") == 0
    assert "10 of " in (text := capsys.readouterr().out)
    assert "all identical, bit for bit" in text


def test_recheck_without_motions(hostile: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("recheck", str(hostile / "cube.nc"), "--motions", str(tmp_path)) == 1
    assert "--motions" in capsys.readouterr().err


def test_recheck_of_a_part(hostile: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with xr.open_dataset(hostile / "cube.nc", decode_timedelta=False) as cube:
        cube.isel(azimuth=slice(1, None)).to_netcdf(tmp_path / "part.nc")
    assert run("recheck", str(tmp_path / "part.nc"), "--motions", str(hostile / "motion")) == 1
    assert "part.nc: a part of its study's cube; recheck the cube that the run made" in capsys.readouterr().err


def test_survey(hostile: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stones, figure = tmp_path / "stones.csv", tmp_path / "survey.svg"
    stones.write_text(
        "fell,azimuth_deg,octant,count,b_over_h,face_azimuth_deg\n"
        "yes,60,,2,,\nyes,,SW,3,,\nno,,,1,0.4,60\nyes,240,,1,0.2,60\n"
    )
    assert (
        run("survey", str(stones), "--cube", str(hostile / "cube.nc"), "--record", "one", "--figure", str(figure)) == 0
    )
    text = capsys.readouterr().out
    assert "6 stones fell, 1 stood" in text
    assert "For 5 of 6 falls" in text
    assert "2 stones of known face" in text
    assert "Share that fell: 86\u00a0% (42 to 100), computed" in text  # 6 of 7
    assert figure.read_text(encoding="utf-8").startswith("<?xml")


def test_survey_by_site(hostile: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stones, output = tmp_path / "stones.csv", tmp_path / "survey.json"
    stones.write_text("site,fell,azimuth_deg,count\nA,yes,60,4\nA,no,,1\nB,yes,240,2\nC,yes,,3\n")
    cube = str(hostile / "cube.nc")
    assert run("survey", str(stones), "--cube", cube, "--record", "one", "--output", str(output)) == 0
    text = capsys.readouterr().out.replace("\u00a0", " ")
    assert "9 stones fell and 1 stand" in text, "the summary of the survey by itself"
    assert "The computed directions fit the observed ones" in text
    rows = [line.split("  ") for line in text.partition("  log likelihood ratio  ")[2].split("\n")[1:4]]
    assert [[cell.strip() for cell in row if cell.strip()][:4] for row in rows] == [
        ["A", "4", "1", "80 % (28 to 99)"], ["B", "2", "0", "–"], ["C", "3", "0", "–"],
    ]  # fmt: skip
    stored = read_survey_comparison(output)
    alone = dict(stored.sites)
    assert list(alone) == ["A", "B", "C"]
    # Sites are independent: their log likelihood ratios add up to that of the survey.
    ratios = [one.log_likelihood_ratio for one in alone.values() if one.fallen_count_in_known_direction]
    assert sum(ratios) == pytest.approx(stored.comparison.log_likelihood_ratio)


@pytest.mark.parametrize(
    ("more", "message"),
    [((), "--record"), (("--record", "three"), "no record 'three'"), (("--figure", "a.bmp"), "use the extension")],
)
def test_survey_errors(
    hostile: Path, tmp_path: Path, more: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    stones = tmp_path / "stones.csv"
    stones.write_text("octant\nN\n")
    assert run("survey", str(stones), "--cube", str(hostile / "cube.nc"), *more) == 1
    assert message in capsys.readouterr().err
