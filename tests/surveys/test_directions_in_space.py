"""Observed fall directions next to those of 3-D cubes: closed forms, and a truth that the tests invent."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
from overturning.findings.survey_displacements import survey_displacement_findings
from overturning.report.render import render_template_as_markdown
from overturning.stored import read_json_result, write_result_as_json
from overturning.surveys.directions_in_space import (
    FALL_DIRECTION_SECTORS,
    FallDirectionComparisonIn3D,
    fall_shares_by_sector_smoothed_over_arcs,
)
from overturning.surveys.displacement_results import StoredDisplacementComparison
from overturning.surveys.displacements import compare_falls_shifts_and_twists
from overturning.surveys.stones import OCTANTS, read_survey_table
from tests.surveys.test_displacements import CUBE_GRID, cube_of_unmoved_stones_except_given_values


def compare_directions_of_survey(
    folder: Path, rows: str, cube: xr.Dataset, background: float = 0.05, sites: dict[str, xr.Dataset] | None = None
) -> FallDirectionComparisonIn3D:
    """Write a survey of these rows, compare its fall directions with a 3-D cube, and return the comparison."""
    path = folder / "stones.csv"
    path.write_text(f"site,outcome,face_azimuth_deg,height_m,b_over_h,count\n{rows}", encoding="utf-8")
    found = compare_falls_shifts_and_twists(
        read_survey_table(path), cube, sites, random_fall_direction_share=background
    ).fall_direction_comparison
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("azimuth", "octants"),
    [(0.0, {"N": 1.0}), (382.5, {"N": 0.5, "NE": 0.5}), (280.0, {"W": 1 - 10 / 45, "NW": 10 / 45})],
)
def test_a_computed_fall_is_spread_over_45_degrees_about_its_azimuth(azimuth: float, octants: dict[str, float]) -> None:
    shares = FALL_DIRECTION_SECTORS.octant_probabilities_from_sectors(
        fall_shares_by_sector_smoothed_over_arcs(np.array([azimuth]))
    )
    assert shares.sum() == pytest.approx(1.0)
    assert dict(zip(OCTANTS, shares, strict=True)) == pytest.approx(dict.fromkeys(OCTANTS, 0.0) | octants, abs=2e-3)


def test_log_likelihood_ratio_and_octants_match_hand_computation(tmp_path: Path) -> None:
    """Log-likelihood ratio and octant counts of surveyed fall directions match a computation by hand.

    All computed stones fall northwards: with a background share b, a fall to N is 8 (1 − b) + b times as probable as
    by chance.
    """
    rows = "A,fell N,0,0.5,0.3,3\nA,fell S,0,0.5,0.3,1\nA,fell,0,0.5,0.3,2\nA,stands,0,0.5,0.3,5\n"
    found = compare_directions_of_survey(
        tmp_path, rows, cube_of_unmoved_stones_except_given_values(overturned=1.0, fall_azimuth=0.0), background=0.2
    )
    assert (
        found.fallen_in_known_direction,
        found.known_direction_falls_without_any_computed_fall,
        found.known_direction_falls_without_computed_outcome,
    ) == (4, 0, 0)
    assert found.log_likelihood_ratio == pytest.approx(3 * np.log(8 * 0.8 + 0.2) + np.log(0.2))
    # As large by chance: three or four of four stones in one octant of eight.
    chance = (4 * 7 + 1) / 8**4
    assert found.likelihood_ratio_p == pytest.approx(chance, abs=5 * (chance / 2000) ** 0.5)
    assert found.observed_count_by_octant.tolist() == [3.0, 0, 0, 0, 1.0, 0, 0, 0]
    assert found.predicted_count_by_octant == pytest.approx([4 * (0.8 + 0.2 / 8), *[4 * 0.2 / 8] * 7])
    assert (found.observed_resultant_length, found.predicted_mean_direction_deg) == pytest.approx((0.5, 0.0), abs=1e-9)


@pytest.mark.parametrize(("language", "sentence"), [("en", "worse than random directions"), ("ja", "観測に合わない")])
def test_a_fall_that_is_impossible_without_background_is_stored_and_reported(
    tmp_path: Path, language: str, sentence: str
) -> None:
    """The log likelihood ratio is −∞, and every random survey has a ratio at least as large, so that p = 1."""
    path = tmp_path / "stones.csv"
    path.write_text("outcome,count\nfell N,3\nfell S,1\n", encoding="utf-8")
    cube = cube_of_unmoved_stones_except_given_values(overturned=1.0, fall_azimuth=0.0)
    found = compare_falls_shifts_and_twists(read_survey_table(path), cube, random_fall_direction_share=0.0)
    write_result_as_json(StoredDisplacementComparison("s", "x", "a", found), tmp_path / "comparison.json")
    stored = read_json_result(StoredDisplacementComparison, tmp_path / "comparison.json", "survey")
    assert stored.all_sites_comparison.fall_direction_comparison is not None
    assert (
        stored.all_sites_comparison.fall_direction_comparison.log_likelihood_ratio,
        stored.all_sites_comparison.fall_direction_comparison.likelihood_ratio_p,
    ) == (
        -np.inf,
        1.0,
    )
    results = ResultsPrintedBySurveyCommands(survey_displacements=[survey_displacement_findings(stored)])
    text = render_template_as_markdown(results, template_name="displacements", language=language)
    assert sentence in text
    assert " −∞" in text


def test_each_stone_is_compared_with_falls_of_its_own_face_and_site(tmp_path: Path) -> None:
    """In this cube, each stone falls towards the azimuth of its face, which is the orientation of its case.

    A square stone that faces 90° equals one that faces 0°.
    """
    orientation = np.asarray(CUBE_GRID["orientation"])[:, None, None, None]
    cube = cube_of_unmoved_stones_except_given_values(overturned=1.0, fall_azimuth=orientation)
    assert compare_directions_of_survey(
        tmp_path, "A,fell 45,45,0.5,0.3,1\n", cube
    ).predicted_mean_direction_deg == pytest.approx(45.0)
    assert compare_directions_of_survey(
        tmp_path, "A,fell 45,90,0.5,0.3,1\n", cube
    ).predicted_mean_direction_deg % 360 == pytest.approx(0.0)
    other = {"B": cube_of_unmoved_stones_except_given_values(overturned=1.0, fall_azimuth=270.0)}
    found = compare_directions_of_survey(tmp_path, "B,fell W,45,0.5,0.3,1\n", cube, sites=other)
    assert found.predicted_mean_direction_deg == pytest.approx(270.0)


def test_stones_without_a_computed_fall_are_predicted_to_fall_at_random(tmp_path: Path) -> None:
    flags = np.array([0.0, np.nan, 1.0])[:, None]
    rows = "A,fell N,0,0.5,0.3,2\nA,fell E,0,0.5,0.4,3\nA,fell S,0,0.5,0.5,1\n"
    found = compare_directions_of_survey(
        tmp_path, rows, cube_of_unmoved_stones_except_given_values(overturned=flags, fall_azimuth=180.0)
    )
    assert (
        found.fallen_in_known_direction,
        found.known_direction_falls_without_any_computed_fall,
        found.known_direction_falls_without_computed_outcome,
    ) == (6, 2, 3)
    assert found.log_likelihood_ratio == pytest.approx(np.log(8 * 0.95 + 0.05)), "of the last stone alone"


def test_no_direction_comparison_without_known_fall_directions(tmp_path: Path) -> None:
    path = tmp_path / "stones.csv"
    path.write_text("outcome\nstands\nfell direction unknown\n", encoding="utf-8")
    assert (
        compare_falls_shifts_and_twists(
            read_survey_table(path), cube_of_unmoved_stones_except_given_values(overturned=1.0)
        ).fall_direction_comparison
        is None
    )


def test_directions_drawn_from_the_study_fit_and_opposite_ones_do_not(tmp_path: Path) -> None:
    """Fall directions drawn from the cube fit, opposite ones do not.

    The likelihood ratio does not change if survey and cube are rotated together.
    """
    generator = np.random.default_rng(11)
    shape = tuple(len(one) for one in CUBE_GRID.values())
    azimuth = (60.0 + generator.normal(0.0, 30.0, shape)) % 360.0
    cube = cube_of_unmoved_stones_except_given_values(overturned=1.0, fall_azimuth=azimuth)
    falls = [azimuth[tuple(int(generator.integers(size)) for size in shape)] for _ in range(25)]

    def comparison_of_rotated_survey(turn: float, common_turn_deg: float = 0.0) -> FallDirectionComparisonIn3D:
        rows = "".join(f"A,fell {(one + turn + common_turn_deg) % 360:.1f},,,,1\n" for one in falls)
        return compare_directions_of_survey(
            tmp_path, rows, cube.assign(fall_azimuth=(cube["fall_azimuth"] + common_turn_deg) % 360.0)
        )

    right = comparison_of_rotated_survey(0.0)
    wrong = comparison_of_rotated_survey(180.0)
    turned = comparison_of_rotated_survey(0.0, common_turn_deg=45.0)
    assert right.log_likelihood_ratio > 10
    assert right.likelihood_ratio_p < 0.001
    assert wrong.log_likelihood_ratio < -10
    assert wrong.likelihood_ratio_p > 0.9
    assert turned.log_likelihood_ratio == pytest.approx(right.log_likelihood_ratio, abs=1e-9)
    assert right.observed_mean_direction_deg == pytest.approx(60.0, abs=15.0)
    assert right.predicted_mean_direction_deg == pytest.approx(60.0, abs=5.0)


@pytest.mark.parametrize(
    ("b_over_h", "sentence"),
    [(0.3, "No stone like the fallen ones is known to fall in the study"), (0.9, "The study has no stone like those")],
)
def test_report_distinguishes_cells_without_outcome_from_stones_outside_the_grid(
    tmp_path: Path, b_over_h: float, sentence: str
) -> None:
    path = tmp_path / "stones.csv"
    path.write_text(f"outcome,b_over_h\nfell N,{b_over_h}\nstands,{b_over_h}\n", encoding="utf-8")
    found = compare_falls_shifts_and_twists(
        read_survey_table(path), cube_of_unmoved_stones_except_given_values(overturned=np.nan)
    )
    results = survey_displacement_findings(StoredDisplacementComparison("s", "x", "a", found))
    assert sentence in render_template_as_markdown(
        ResultsPrintedBySurveyCommands(survey_displacements=[results]), template_name="displacements"
    )
