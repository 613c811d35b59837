"""Printed output and figures of the tutorial are those of today's program."""

import pytest

from overturning.study.load import study_from_content
from overturning.study.preflight import estimate_cases_time_memory_and_disk_of_study
from verification import tutorial
from verification.tables import RESULT_TABLE_FOLDER, read_measured_numbers


def test_the_tutorial_page_shows_the_survey_and_study_of_its_script() -> None:
    page = (tutorial.ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    for line in tutorial.TUTORIAL_SURVEY_CSV.splitlines():
        assert f"    {line}\n" in page
    assert "b_over_h: {start: 0.1, stop: 0.6, step: 0.1}\n    height: [0.6]\n    friction: [0.58, 1.0]\n" in page
    assert "azimuth: {step: 10}" in page
    assert '"orientation": {"step": 5}, "b_over_h": {"start": 0.1, "stop": 0.6, "step": 0.05}' in page


def test_the_tutorial_shows_the_cost_estimate_printed_for_its_study() -> None:
    page = (tutorial.ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    study = study_from_content(
        {"name": "mine", "records": {"use": ["wtmc"]}, **tutorial.TUTORIAL_STUDY_SETTINGS}, "mine.yaml"
    )
    assert f"    config/mine.yaml: study 'mine', {estimate_cases_time_memory_and_disk_of_study(study)}\n" in page


@pytest.mark.long
def test_the_survey_command_prints_what_the_tutorial_shows() -> None:
    stored = (RESULT_TABLE_FOLDER / "tutorial-survey.txt").read_text(encoding="utf-8")
    assert tutorial.output_of_tutorial_survey_command() == stored, "python -m verification.tutorial"


@pytest.mark.long
def test_stored_numbers_of_the_tutorial_equal_a_new_measurement() -> None:
    stored = {one.quantity: one.value for one in read_measured_numbers(RESULT_TABLE_FOLDER / "tutorial.csv")}
    today = {
        one.quantity: one.value
        for one in (
            *tutorial.count_2d_falls_with_and_without_vertical_motion(),
            *tutorial.count_3d_falls_with_and_without_vertical_motion(),
        )
    }
    assert stored == pytest.approx(today, rel=1e-5), "python -m verification.tutorial"
