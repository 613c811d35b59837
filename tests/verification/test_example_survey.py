"""The example survey: made from a motion of known axis, and its worked example in docs/how-to/survey.md."""

from collections import Counter

import numpy as np
import pytest

import overturning
from overturning.motion.direction import angle_between_azimuths
from overturning.units import STANDARD_GRAVITY
from verification import example_survey
from verification.example_survey import (
    DIRECTION_NOTATION_BY_SITE,
    EXAMPLE_SURVEY_FILE,
    ROSE_DIAGRAM_FILE,
    SURVEY_DOCS_PAGE_FILE,
    InventedStone,
    invent_and_simulate_stones_by_cemetery,
    true_azimuth_in_field_notation,
)


@pytest.fixture(scope="module")
def invented_stones() -> dict[str, list[InventedStone]]:
    """The invented stones of the example survey."""
    return invent_and_simulate_stones_by_cemetery()


def test_the_example_survey_equals_the_output_of_its_script(
    invented_stones: dict[str, list[InventedStone]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(example_survey, "invent_and_simulate_stones_by_cemetery", lambda: invented_stones)
    assert EXAMPLE_SURVEY_FILE.read_text(encoding="utf-8") == example_survey.survey_csv_text(), (
        "python -m verification.example_survey"
    )


def test_the_survey_page_shows_the_output_of_its_commands() -> None:
    page = SURVEY_DOCS_PAGE_FILE.read_text(encoding="utf-8")
    for mark, block in example_survey.survey_command_output_by_marker().items():
        assert f"<!-- {mark}:begin -->\n\n{example_survey.fenced_code_block(block)}\n\n<!-- {mark}:end -->" in page, (
            "python -m verification.example_survey"
        )
    true, text = example_survey.true_motion_of_example_survey(), " ".join(page.split())
    azimuth = f"{true.peak_velocity_azimuth_deg:.0f}°"
    assert f"the velocity of the ground motion is largest along the azimuth {azimuth}" in text
    pgv, pga = f"{100 * true.pgv_m_s:.0f} cm/s", f"{true.pga_m_s2 / STANDARD_GRAVITY:.2f} g"
    assert (
        f"has the peak ground velocity (PGV) {pgv} and the peak ground acceleration (PGA) {pga}, and its velocity is "
        f"largest along {azimuth}"
    ) in text
    inferred = page.partition("<!-- example-survey-backwards:begin -->")[2].partition("<!--")[0]
    assert [site for site in DIRECTION_NOTATION_BY_SITE if f"\n  {site} " in inferred] == [
        *DIRECTION_NOTATION_BY_SITE
    ], "a line for each site"
    header, *rows = [line.strip() for line in page.split("\n") if line.startswith("        ") and ";" in line]
    lines = EXAMPLE_SURVEY_FILE.read_text(encoding="utf-8").splitlines()
    assert header in lines
    assert set(rows) <= set(lines)
    assert ROSE_DIAGRAM_FILE.read_text(encoding="utf-8").startswith("<?xml")


def test_the_example_survey_is_read_as_it_was_invented(invented_stones: dict[str, list[InventedStone]]) -> None:
    stones = overturning.read_survey(EXAMPLE_SURVEY_FILE)
    assert stones.attrs["warnings"] == []
    assert Counter(stones["site"]) == dict.fromkeys(DIRECTION_NOTATION_BY_SITE, 20)
    true_stones = [stone for site in DIRECTION_NOTATION_BY_SITE for stone in invented_stones[site]]
    width = {"Hill": 0.5, "River": 11.25, "Church": 0.5}
    for (_, row), stone in zip(stones.iterrows(), true_stones, strict=True):
        assert row["height_m"] == stone.height
        if row["counted_as"] == "not counted":
            continue
        assert (row["counted_as"] == "fell") == np.isfinite(stone.fall_azimuth_deg)
        if np.isfinite(row["azimuth_deg"]):
            assert angle_between_azimuths(row["azimuth_deg"], stone.fall_azimuth_deg) <= width[row["site"]] + 1e-9
        if np.isfinite(row["face_azimuth_deg"]):
            assert angle_between_azimuths(row["face_azimuth_deg"], stone.face_azimuth_deg) <= 0.5 + 1e-9


@pytest.mark.parametrize(
    ("azimuth", "notation", "text"),
    [
        (100.0, "winds", "E"), (102.0, "winds", "ESE"), (10.0, "degrees", "348"), (162.5, "bearings", "S 40° E"),
        (357.5, "bearings", "N 25° W"), (232.5, "bearings", "S 30° W"), (52.5, "bearings", "N 30° E"),
    ],
)  # fmt: skip
def test_invented_directions_are_written_in_the_notation_of_their_site(
    azimuth: float, notation: str, text: str
) -> None:
    assert true_azimuth_in_field_notation(azimuth, notation) == text
