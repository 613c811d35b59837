"""The survey in the report and on the terminal: a survey drawn from the prediction, and one that fell any way."""

import re
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from overturning.labels import azimuth_gap_label
from overturning.report.results import open_results
from overturning.report.sections.answer import answer
from overturning.report.sections.surveys import survey_section
from overturning.study.cube import open_cube
from overturning.study.evaluation import Primary
from overturning.surveys.comparison import read_survey_result
from tests.report.reading import of_study, report_of, text_of
from tests.report.test_commands_on_results import run
from tests.report.tiny_studies import make_results, pulse_record

pytestmark = pytest.mark.long

TOWARDS = "octant,count\nNE,14\n"
ANY_WAY = "azimuth_deg\n" + "\n".join(str(angle) for angle in range(5, 360, 18)) + "\n"
FACES = (
    "azimuth_deg,b_over_h,b_over_h_side,face_azimuth_deg,fell,count\n"
    ",0.2,0.9,60,no,1\n240,0.2,0.9,60,yes,2\n60,0.2,0.9,60,yes,6\n"
)


@pytest.fixture(scope="module")
def surveyed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("surveyed")
    surveys = []
    for name, text in (("towards", TOWARDS), ("any-way", ANY_WAY), ("<b>faces", FACES)):
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
        surveys.append({"stones": str(folder / f"{name}.csv")})
    place = {"latitude": 35.275, "longitude": 133.46, "extra": {"event_latitude": 35.275, "event_longitude": 133.35}}
    record = pulse_record("site", 60, 6.0, fault_strike_deg=330.0, **place)
    results = make_results(folder, [record], surveys=surveys, azimuth={"step": 15}, ensemble={"members": 0})
    for folder in ("survey", "figures/survey"):  # as the workflow does; the commands make none
        (results / folder).mkdir(parents=True, exist_ok=True)
    for number, survey in enumerate(surveys, 1):
        more = (
            "--figure",
            str(results / f"figures/survey/{number}.svg"),
            "--output",
            str(results / f"survey/{number}.json"),
        )
        assert run("survey", survey["stones"], "--cube", str(results / "cube.nc"), *more) == 0
        motion = ("--motion", str(results / "motion/site.nc"), "--output", str(results / f"survey/{number}.motion.nc"))
        assert run("backwards", survey["stones"], "--alone", *motion) == 0
    return results


@pytest.fixture(scope="module")
def reported(surveyed: Path) -> tuple[str, bytes]:
    return report_of(surveyed)


def test_the_report_has_each_survey(surveyed: Path, reported: tuple[str, bytes]) -> None:
    page, paper = reported
    towards, any_way, faces = page.split(">Survey: ")[1:]
    faces = faces.partition("</section>")[0]
    assert towards.startswith("towards.csv, site</h")
    assert "The prediction does better than the guess that stones fall any way (log likelihood ratio " in towards
    assert "14 stones fell, 0 stood. Mean fall direction 45°" in towards
    assert (
        "For the stones that fell face azimuth and B/H are not given, so the prediction assumes stones turned every way"
        in towards
    )
    assert "grouped Watson" in towards
    assert "The prediction does no better" in any_way
    assert "the directions differ from it by more than chance" in any_way
    assert "Does it fit the exact azimuths?" in any_way
    assert "not given" not in faces
    assert "of 9 stones of known face did what was most probable for them" in faces
    assert "&lt;b&gt;faces.csv" in faces
    assert page.count(">What moved the ground: ") >= 3
    # All stones of the first survey fell towards the north-east, those of the second any way.
    (axis,) = re.findall(r"towards\.csv.*?that of its largest velocity, is (\d+)° ± ", page, re.DOTALL)[:1]
    assert abs(int(axis) - 45) <= 10
    assert "The motion may have been stronger than any motion here" in page
    assert "stones that fell and 0 that stood, with 90" in page
    assert str(surveyed) not in page
    # The map of the site, which is known here.
    assert [path.name for path in (surveyed / "figures" / "maps").iterdir()] == ["1.svg"]
    assert 'aria-label="map: event of site"' in page
    assert b"%PDF" in paper[:8]


def test_the_answer_of_several_surveys_names_each(surveyed: Path) -> None:
    with open_results(surveyed) as results:
        asked = of_study(results, asks="survey", primary=Primary(statistic="share"))
        lines = text_of(answer(asked)).splitlines()
        alone = text_of(answer(replace(asked, surveys=asked.surveys[:1])))
    assert [line.partition(": ")[0] for line in lines if ".csv: " in line] == [
        name for name in ("towards.csv", "any-way.csv", "<b>faces.csv") for _ in range(2)
    ]
    assert "any-way.csv: 20 stones fell, 0 stood." in "\n".join(lines)
    assert ".csv" not in alone


def test_missing_planes_are_noted_with_a_prediction(surveyed: Path) -> None:
    result = read_survey_result(surveyed / "survey" / "1.json")
    with open_cube(surveyed / "cube.nc") as cube:
        whole, part = azimuth_gap_label(cube), azimuth_gap_label(cube.isel(azimuth=slice(0, 6)))
    assert whole == ""
    said = "No plane between 75° and 180° was computed: there the prediction is made of what other planes say."
    assert said in text_of(survey_section(result, gaps=part))


def test_half_circle_is_complete_only_with_mirror_symmetry() -> None:
    for period, said in ((180.0, ""), (360.0, "between 165° and 360°")):
        azimuth = ("azimuth", np.arange(0, 180, 15), {"period": period})
        assert azimuth_gap_label(xr.Dataset(coords={"azimuth": azimuth})) == said


def test_terminal_output_matches_the_report(
    surveyed: Path, reported: tuple[str, bytes], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("survey", str(surveyed / "any-way.csv"), "--cube", str(surveyed / "cube.nc")) == 0
    text = capsys.readouterr().out
    page, _ = reported
    said = next(line for line in text.splitlines() if line.startswith("The prediction does no better"))
    assert said in unescape(page)
    assert "fell towards  observed  predicted" in text
