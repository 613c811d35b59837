"""`overturning recheck` and `overturning survey` on a finished study."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.cli import main
from overturning.findings.collect import findings, write_findings
from overturning.report.write import write_report
from overturning.study.cube import open_cube
from overturning.study.load import study_from_content
from overturning.surveys.stored_comparison import read_survey_comparison
from tests.report.tiny_studies import pulse_record, simulate_study_into_result_folder


def run_command(*arguments: str) -> int:
    """Run the command line and return its exit status."""
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    return int(stop.value.code or 0)


def test_recheck_command_finds_recomputed_outcomes_identical(
    results_with_hostile_names: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command("recheck", str(results_with_hostile_names / "cube.nc"), "--cells", "10") == 0
    assert "10 of " in (text := capsys.readouterr().out)
    assert "all identical, bit for bit" in text


def test_error_of_recheck_without_motion_files_names_the_motions_option(
    results_with_hostile_names: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command("recheck", str(results_with_hostile_names / "cube.nc"), "--motions", str(tmp_path)) == 1
    assert "--motions" in capsys.readouterr().err


def test_recheck_command_refuses_a_subset_of_a_study_cube(
    results_with_hostile_names: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with xr.open_dataset(results_with_hostile_names / "cube.nc", decode_timedelta=False) as cube:
        cube.isel(azimuth=slice(1, None)).to_netcdf(tmp_path / "part.nc")
    assert (
        run_command("recheck", str(tmp_path / "part.nc"), "--motions", str(results_with_hostile_names / "motion")) == 1
    )
    assert "part.nc: a part of its study's cube; recheck the cube that the run made" in capsys.readouterr().err


def test_survey_command_compares_falls_with_a_record_and_draws_a_figure(
    results_with_hostile_names: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stones, figure = tmp_path / "stones.csv", tmp_path / "survey.svg"
    stones.write_text(
        "fell,azimuth_deg,octant,count,b_over_h,face_azimuth_deg\n"
        "yes,60,,2,,\nyes,,SW,3,,\nno,,,1,0.4,60\nyes,240,,1,0.2,60\n"
    )
    assert (
        run_command(
            "survey",
            str(stones),
            "--cube",
            str(results_with_hostile_names / "cube.nc"),
            "--record",
            "one",
            "--figure",
            str(figure),
        )
        == 0
    )
    text = capsys.readouterr().out
    assert "6 stones fell, 1 stood" in text
    assert "For 5 of 6 falls" in text
    assert "2 stones of known face" in text
    assert "Share that fell: 86\u00a0% (42 to 100), computed" in text  # 6 of 7
    assert figure.read_text(encoding="utf-8").startswith("<?xml")


def test_survey_command_compares_each_site_and_stores_the_result(
    results_with_hostile_names: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stones, output = tmp_path / "stones.csv", tmp_path / "survey.json"
    stones.write_text("site,fell,azimuth_deg,count\nA,yes,60,4\nA,no,,1\nB,yes,240,2\nC,yes,,3\n")
    cube = str(results_with_hostile_names / "cube.nc")
    assert run_command("survey", str(stones), "--cube", cube, "--record", "one", "--output", str(output)) == 0
    text = capsys.readouterr().out.replace("\u00a0", " ")
    assert "9 stones fell and 1 stand" in text, "the summary of the survey by itself"
    assert "The computed directions fit the observed ones" in text
    rows = [line.split("  ") for line in text.partition("  log likelihood ratio  ")[2].split("\n")[1:4]]
    assert [[cell.strip() for cell in row if cell.strip()][:4] for row in rows] == [
        ["A", "4", "1", "80 % (28 to 99)"], ["B", "2", "0", "–"], ["C", "3", "0", "–"],
    ]  # fmt: skip
    stored = read_survey_comparison(output)
    alone = dict(stored.comparisons_by_site)
    assert list(alone) == ["A", "B", "C"]
    # Sites are independent: their log likelihood ratios add up to that of the survey.
    ratios = [one.log_likelihood_ratio for one in alone.values() if one.fallen_count_in_known_direction]
    assert sum(ratios) == pytest.approx(stored.comparison.log_likelihood_ratio)


def test_survey_command_compares_twist_and_slip_with_a_3d_study(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Twist and slip are compared with the outcomes of the cube, in the command and in the report."""
    body: dict[str, Any] = {"body": {"aspect": [1]}, "orientation": {"step": 45}, "friction": [0.2, 0.35]}
    records = [pulse_record("one", 60, 6.0)]
    folder = simulate_study_into_result_folder(tmp_path / "tiny", records, drawn=False, b_over_h=[0.4, 0.5], **body)
    stones, output, figure = tmp_path / "stones.csv", folder / "survey" / "1.json", tmp_path / "survey.svg"
    stones.write_text(
        "site,outcome,face_azimuth_deg,b_over_h,count\n"
        "A,shifted 5 cm,45,0.4,3\nA,fell N,45,0.4,1\nB,twisted -7,0,0.5,2\nB,stands,0,0.5,6\n"
    )
    output.parent.mkdir()
    options = ("--cube", str(folder / "cube.nc"), "--output", str(output), "--figure", str(figure))
    assert run_command("survey", str(stones), *options) == 0
    text = capsys.readouterr().out.replace("\u00a0", " ")
    assert "compared with the stones of the study under the record one: 1 stone fell, 11 stood" in text
    assert figure.is_file()
    with open_cube(folder / "cube.nc") as cube:
        cells = [cube.isel(record=0).sel(orientation=face, b_over_h=shape) for face, shape in ((45, 0.4), (0, 0.5))]
        slip = [np.hypot(one["residual_slip_north"], one["residual_slip_east"]).fillna(0) for one in cells]
        stands = [one["overturned"] == 0 for one in cells]
        # Each of three stones of A and eight of B takes the share of its own standing cases, friction by friction.
        shares = [
            sum(
                n * float(((far >= 0.01) & up).isel(friction=at).sum())
                for n, far, up in zip((3, 8), slip, stands, strict=True)
            )
            / 11
            for at in range(2)
        ]
        assert all(bool(up.all()) for up in stands), "otherwise the sum above needs weights"
    content = {"name": "tiny", "asks": "survey", "records": {"use": ["one"]}, "b_over_h": [0.4, 0.5], **body}
    survey = {"stones": str(stones), "backwards": False}
    study = study_from_content(content | {"verification": "none", "surveys": [survey]}, "tiny.yaml")
    found = findings(folder, study)
    (survey_found,) = found.survey_displacements
    assert (found.surveys, [one.site for one in survey_found.sites]) == ([], ["A", "B"])
    shifted = next(
        one for one in survey_found.all_sites.compared_shares_and_medians if one.share_or_median_name == "shifted"
    )
    assert (shifted.observed_stone_count, shifted.observed.value) == (11, pytest.approx(3 / 11))
    assert shifted.computed.value == pytest.approx(np.mean(shares))
    assert 0 < np.mean(shares) < 1, "so that the comparison is not one of zeros"
    write_findings(found, folder / "findings.json")
    write_report(folder, folder / "report.html", None, study)
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Observed and computed falls, twist and slip" in page
    assert "of the standing: shifted by 1" in page
    # The stone like the one that fell to the north stands in this study.
    directions = survey_found.all_sites.fall_direction_findings
    assert directions is not None
    assert (
        directions.falls_in_known_direction,
        directions.known_direction_falls_without_any_computed_fall,
        directions.log_likelihood_ratio,
    ) == (1, 1, 0.0)
    assert "<h1>No stone like the fallen ones falls in the study</h1>" in page


@pytest.mark.parametrize(
    ("more", "message"),
    [((), "--record"), (("--record", "three"), "no record 'three'"), (("--figure", "a.bmp"), "use the extension")],
)
def test_survey_command_reports_invalid_options(
    results_with_hostile_names: Path,
    tmp_path: Path,
    more: tuple[str, ...],
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    stones = tmp_path / "stones.csv"
    stones.write_text("octant\nN\n")
    assert run_command("survey", str(stones), "--cube", str(results_with_hostile_names / "cube.nc"), *more) == 1
    assert message in capsys.readouterr().err
