"""Twist and slip of surveyed stones next to those of 3-D cubes, with a truth that the tests invent."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy
import xarray as xr

from overturning.errors import ArgumentError
from overturning.findings.survey_displacements import survey_displacement_findings
from overturning.statistics.bootstrap import exact_median_interval
from overturning.surveys.displacement_results import FallAndDisplacementComparison, StoredDisplacementComparison
from overturning.surveys.displacements import compare_falls_shifts_and_twists
from overturning.surveys.stones import SurveyTable, read_survey_table

CUBE_GRID: dict[str, Any] = {
    "record": ["a"],
    "orientation": np.arange(0.0, 90.0, 15.0),
    "height": [0.5, 0.8],
    "b_over_h": [0.3, 0.4, 0.5],
    "friction": [0.5, 0.7],
}


def cube_of_unmoved_stones_except_given_values(**values: Any) -> xr.Dataset:
    """Return a 3-D cube on `CUBE_GRID` of stones that neither fall nor move, but for the given variables."""
    shape = tuple(len(one) for one in CUBE_GRID.values())
    nothing = {
        "overturned": 0.0,
        "fall_azimuth": np.nan,
        "residual_slip_north": 0.0,
        "residual_slip_east": 0.0,
        "residual_twist": 0.0,
    }
    return xr.Dataset(
        {name: (tuple(CUBE_GRID), np.broadcast_to(np.asarray(one, np.float64), shape).copy())
         for name, one in (nothing | values).items()},
        CUBE_GRID,
    )  # fmt: skip


def survey_table_of_rows(folder: Path, rows: str) -> SurveyTable:
    """Write a survey with these rows and read it."""
    path = folder / "stones.csv"
    path.write_text(f"site,outcome,face_azimuth_deg,height_m,b_over_h,count\n{rows}", encoding="utf-8")
    return read_survey_table(path)


def compared_statistics_by_name(found: FallAndDisplacementComparison) -> dict[str, Any]:
    """Return the measures of a comparison (share that fell, twist, ...) by their names."""
    return {one.name: one for one in found.compared_statistics}


def test_shares_and_medians_of_a_survey_match_hand_counts(tmp_path: Path) -> None:
    """The observed shares and medians are counted by hand.

    In the cube, stones slip by 3 cm and twist by −8° at one of two frictions.
    """
    stones = survey_table_of_rows(
        tmp_path,
        "A,fell,0,0.5,0.3,2\nA,stands,0,0.5,0.3,3\nA,shifted 3 cm,0,0.5,0.3,1\nB,twisted -10,0,0.5,0.3,2\n"
        "B,twisted 6,0,0.5,0.3,1\nB,shifted,0,0.5,0.3,1\nB,shifted 4 mm,0,0.5,0.3,1\nB,broken,0,0.5,0.3,7\n",
    )
    slips = np.array([0.0, 0.03])
    found = compare_falls_shifts_and_twists(
        stones, cube_of_unmoved_stones_except_given_values(residual_slip_east=-slips, residual_twist=[0.0, -8.0])
    )
    assert (found.fell, found.stood, found.standing_stones_without_standing_simulation) == (2, 9, 0)
    assert found.similar_computed_case_count == 2, "one orientation, height and B/H, two frictions"
    measures = compared_statistics_by_name(found)
    # The stone that is shifted by an unknown amount counts in no share of shifts.
    for name, matching, n in (("fell", 2, 11), ("shifted", 1, 8), ("twisted", 3, 9), ("clockwise", 1, 3)):
        exact = scipy.stats.binomtest(matching, n).proportion_ci(method="exact")
        one = measures[name]
        assert one.observed_stone_count == n, name
        assert (one.observed, one.observed_low, one.observed_high) == pytest.approx((matching / n, *exact)), name
    assert (measures["fell"].computed, measures["shifted"].computed, measures["clockwise"].computed) == (0, 0.5, 0)
    assert (measures["shifted"].computed_low, measures["shifted"].computed_high) == (0.0, 1.0), "range over frictions"
    assert (measures["shift_m"].observed, measures["shift_m"].computed) == pytest.approx((0.03, 0.03))
    assert (measures["twist_deg"].observed, measures["twist_deg"].computed) == (10.0, 8.0)
    assert np.isnan(measures["twist_deg"].observed_low), "three stones have no interval of the median"


def test_a_stone_is_compared_with_its_face_azimuth_and_size(tmp_path: Path) -> None:
    """The computed twist identifies the case: 100 × orientation + 10 × height + B/H index + 5, degrees."""
    names = 100.0 * np.arange(6)[:, None, None, None] + 10.0 * np.arange(2)[:, None, None] + np.arange(3)[:, None]
    cube = cube_of_unmoved_stones_except_given_values(residual_twist=names + 5.0)

    def computed_twist_and_case_count(row: str) -> tuple[float, int]:
        found = compare_falls_shifts_and_twists(survey_table_of_rows(tmp_path, row), cube)
        return compared_statistics_by_name(found)["twist_deg"].computed, found.similar_computed_case_count

    # A square looks alike every 90°: 107° is 17°, nearest to 15°.
    assert computed_twist_and_case_count("A,stands,107,0.52,0.41,1\n") == (100.0 + 0.0 + 1.0 + 5.0, 2)
    assert computed_twist_and_case_count("A,stands,359,2.0,0.3,1\n") == (0.0 + 10.0 + 0.0 + 5.0, 2)
    assert computed_twist_and_case_count("A,stands,,0.8,0.5,1\n")[1] == 2 * 6, (
        "every orientation of a stone whose face is not known"
    )
    assert computed_twist_and_case_count("A,stands,0,,,1\n")[1] == 2 * 2 * 3, "every size"


def test_intervals_of_a_survey_drawn_from_a_cube_contain_the_values_of_the_cube(tmp_path: Path) -> None:
    """For stones drawn from the cube, the intervals of the observed values contain the computed values."""
    generator = np.random.default_rng(7)
    shape = tuple(len(one) for one in CUBE_GRID.values())
    falls = (generator.random(shape) < np.array([0.2, 0.4, 0.1])[:, None]).astype(float)
    twists = np.where(falls == 1, np.nan, generator.normal(2.0, 5.0, shape))
    slips = np.where(falls == 1, 0.0, generator.exponential(0.015, shape))
    cube = cube_of_unmoved_stones_except_given_values(
        overturned=falls, residual_twist=twists, residual_slip_north=slips
    )
    rows = []
    for _ in range(500):
        at = tuple(int(generator.integers(size)) for size in shape)
        size = f"{CUBE_GRID['orientation'][at[1]]:g},{CUBE_GRID['height'][at[2]]:g},{CUBE_GRID['b_over_h'][at[3]]:g},1"
        outcome = f'"shifted {1000 * slips[at]:.2f} mm, twisted {twists[at]:.2f}"'
        rows.append(f"A,{'fell' if falls[at] else outcome},{size}\n")
    stones = survey_table_of_rows(tmp_path, "".join(rows))
    found = compare_falls_shifts_and_twists(stones, cube)
    measures = compared_statistics_by_name(found)
    assert found.similar_computed_case_count == cube["overturned"].size
    for name, one in measures.items():
        assert one.observed_low <= one.computed <= one.observed_high, name
    # A truth whose twists are all reversed is rejected.
    other = compared_statistics_by_name(
        compare_falls_shifts_and_twists(stones, cube.assign(residual_twist=-cube["residual_twist"]))
    )
    assert other["clockwise"].computed < other["clockwise"].observed_low
    assert other["twisted"].computed == measures["twisted"].computed


def test_stones_that_stand_where_the_study_has_only_falls_are_counted(tmp_path: Path) -> None:
    falls = np.array([1.0, 0.0, 0.0])[:, None]
    stones = survey_table_of_rows(tmp_path, "A,stands,0,0.5,0.3,2\nA,shifted 2 cm,0,0.5,0.5,1\n")
    found = compare_falls_shifts_and_twists(
        stones, cube_of_unmoved_stones_except_given_values(overturned=falls, residual_slip_north=0.02)
    )
    assert (found.standing_stones_without_standing_simulation, found.stood) == (2, 3)
    assert compared_statistics_by_name(found)["shifted"].computed == 1.0, "of the stone that can stand"
    nowhere = compare_falls_shifts_and_twists(
        survey_table_of_rows(tmp_path, "A,stands,0,0.5,0.3,2\n"),
        cube_of_unmoved_stones_except_given_values(overturned=1.0),
    )
    assert np.isnan(compared_statistics_by_name(nowhere)["shifted"].computed)


def test_stones_without_a_computed_outcome_are_counted_as_such(tmp_path: Path) -> None:
    unknown = np.array([np.nan, 0.0, 1.0])[:, None]
    stones = survey_table_of_rows(
        tmp_path, "A,stands,0,0.5,0.3,2\nA,fell,0,0.5,0.3,3\nA,stands,0,0.5,0.4,1\nA,stands,0,0.5,0.5,4\n"
    )
    found = compare_falls_shifts_and_twists(stones, cube_of_unmoved_stones_except_given_values(overturned=unknown))
    assert (
        found.stones_without_computed_outcome,
        found.standing_stones_without_standing_simulation,
        found.similar_computed_case_count,
    ) == (5, 4, 4)
    assert compared_statistics_by_name(found)["fell"].computed == pytest.approx(4 / 5), "of the stones with an outcome"


def test_stones_far_outside_the_grid_are_counted_and_not_compared(tmp_path: Path) -> None:
    """Stones up to a quarter outside the grid (B/H 0.3 to 0.5, D/B 1) are compared, those farther outside are not."""
    path = tmp_path / "stones.csv"
    path.write_text(
        "outcome,b_over_h,b_over_h_side,count\n"
        "stands,0.24,,1\nfell,0.23,,2\nstands,0.62,,4\nstands,0.64,,8\nstands,0.3,0.37,16\nfell,0.3,0.4,32\n",
        encoding="utf-8",
    )
    cube = cube_of_unmoved_stones_except_given_values(overturned=[[1.0], [0.0], [0.0]]).expand_dims(aspect=[1.0])
    found = compare_falls_shifts_and_twists(read_survey_table(path), cube)
    assert (
        found.stones_far_outside_b_over_h_or_aspect_range,
        found.stones_without_computed_outcome,
        found.standing_stones_without_standing_simulation,
    ) == (2 + 8 + 32, 0, 1 + 16)
    assert compared_statistics_by_name(found)["fell"].computed == pytest.approx((1 + 16) / (1 + 4 + 16))
    assert compared_statistics_by_name(found)["fell"].observed == pytest.approx(34 / 63), "all stones"
    findings = survey_displacement_findings(StoredDisplacementComparison("s", "h", "a", found)).all_sites
    assert findings.stones_far_outside_b_over_h_or_aspect_range == 42


@pytest.mark.parametrize("row", ["fell,30,0.8,0.2,0.4,30", "fell,120,0.8,0.4,0.2,30"])
def test_a_stone_described_from_its_narrow_face_gives_the_same_comparison(tmp_path: Path, row: str) -> None:
    """A stone gives the same comparison if described from its broad face, 30°, or from its narrow face, 120°.

    The cube has only stones described from the broad face, with D/B of at least 1.
    """
    grid = {"record": ["a"], "orientation": np.arange(0.0, 180.0, 15.0), "height": [0.8], "b_over_h": [0.2, 0.4],
            "aspect": [1.0, 2.0], "friction": [0.7]}  # fmt: skip
    nothing = np.zeros(tuple(map(len, grid.values())))
    falls, azimuth = nothing.copy(), np.full(nothing.shape, np.nan)
    falls[:, 2, :, 0, 1], azimuth[:, 2, :, 0, 1] = 1.0, 30.0  # B/H 0.2, D/B 2, facing 30°
    values = {"overturned": falls, "fall_azimuth": azimuth, "residual_slip_north": nothing,
              "residual_slip_east": nothing, "residual_twist": nothing}  # fmt: skip
    cube = xr.Dataset({name: (tuple(grid), one) for name, one in values.items()}, grid)
    path = tmp_path / "stones.csv"
    header = "outcome,face_azimuth_deg,height_m,b_over_h,b_over_h_side,azimuth_deg"
    path.write_text(f"{header}\n{row}\n", encoding="utf-8")
    found = compare_falls_shifts_and_twists(read_survey_table(path), cube)
    assert (found.stones_far_outside_b_over_h_or_aspect_range, found.similar_computed_case_count) == (0, 1)
    assert compared_statistics_by_name(found)["fell"].computed == 1.0
    assert found.fall_direction_comparison is not None
    assert found.fall_direction_comparison.log_likelihood_ratio > 1.5


def test_displacements_of_each_site_are_compared_with_its_cube(tmp_path: Path) -> None:
    stones = survey_table_of_rows(tmp_path, "A,stands,0,0.5,0.3,1\nB,stands,0,0.5,0.3,1\n")
    still, moved = (
        cube_of_unmoved_stones_except_given_values(),
        cube_of_unmoved_stones_except_given_values(residual_slip_north=0.05),
    )
    found = compare_falls_shifts_and_twists(stones, still, {"B": moved})
    assert compared_statistics_by_name(found)["shifted"].computed == 0.5
    assert (
        compared_statistics_by_name(compare_falls_shifts_and_twists(stones.select_site("B"), moved))["shifted"].computed
        == 1.0
    )


def test_a_survey_of_fallen_stones_only_has_no_share_that_fell(tmp_path: Path) -> None:
    fell = compared_statistics_by_name(
        compare_falls_shifts_and_twists(
            survey_table_of_rows(tmp_path, "A,fell,0,0.5,0.3,4\n"),
            cube_of_unmoved_stones_except_given_values(overturned=1.0),
        )
    )["fell"]
    assert (fell.observed_stone_count, fell.computed) == (0, 1.0)
    assert np.isnan(fell.observed)
    both = survey_table_of_rows(tmp_path, "A,fell,0,0.5,0.3,1\nA,stands,0,0.5,0.3,3\nB,fell,0,0.5,0.3,5\n")
    fell = compared_statistics_by_name(
        compare_falls_shifts_and_twists(
            both,
            cube_of_unmoved_stones_except_given_values(),
            {"B": cube_of_unmoved_stones_except_given_values(overturned=1.0)},
        )
    )["fell"]
    assert (fell.observed_stone_count, fell.observed, fell.computed) == (4, 0.25, 0.0), (
        "without B, which lists fallen stones only"
    )


def test_2_d_cubes_empty_surveys_and_wrong_shares_of_random_directions_are_refused(tmp_path: Path) -> None:
    stones = survey_table_of_rows(tmp_path, "A,stands,0,0.5,0.3,1\n")
    with pytest.raises(ArgumentError, match="cube: of 2-D blocks"):
        compare_falls_shifts_and_twists(
            stones, cube_of_unmoved_stones_except_given_values().drop_vars("residual_twist")
        )
    with pytest.raises(ArgumentError, match="stones: none counts"):
        compare_falls_shifts_and_twists(
            survey_table_of_rows(tmp_path, "A,broken,0,0.5,0.3,1\n"), cube_of_unmoved_stones_except_given_values()
        )
    for share in (1.0, 1.5, -0.1, np.nan):
        with pytest.raises(ArgumentError, match=r"background: .*; a share from 0 to below 1"):
            compare_falls_shifts_and_twists(
                stones, cube_of_unmoved_stones_except_given_values(), random_fall_direction_share=share
            )


def test_displacement_findings_are_in_centimetres(tmp_path: Path) -> None:
    stones = survey_table_of_rows(tmp_path, "A,shifted 25 mm,0,0.5,0.3,8\n")
    stored = StoredDisplacementComparison(
        "s",
        "x",
        "a",
        compare_falls_shifts_and_twists(stones, cube_of_unmoved_stones_except_given_values(residual_slip_east=0.03)),
    )
    found = survey_displacement_findings(stored)
    shift = next(one for one in found.all_sites.compared_shares_and_medians if one.share_or_median_name == "shift_m")
    assert (shift.observed.value, shift.observed.low, shift.computed.value) == pytest.approx((2.5, 2.5, 3.0))
    assert (found.min_shift_counted_as_shifted_cm, found.min_twist_counted_as_twisted_deg) == pytest.approx((1.0, 5.0))


@pytest.mark.parametrize("n", [6, 9, 20, 101])
def test_interval_of_a_median_has_at_least_its_stated_probability(n: int) -> None:
    """The ranks of the interval enclose the median with a binomial probability of at least 95 %.

    Ranks closer by one on each side enclose the median with less than 95 %.
    """
    low, high = exact_median_interval(np.random.default_rng(n).permutation(n))
    rank = int(low) + 1

    def probability_that_ranks_enclose_median(r: int) -> float:
        return float(1 - 2 * scipy.stats.binom.cdf(r - 1, n, 0.5))

    assert high == n - rank
    assert probability_that_ranks_enclose_median(rank) >= 0.95 > probability_that_ranks_enclose_median(rank + 1)
    assert np.isnan(exact_median_interval(np.arange(5.0)).low)
