"""Two surveys with a known answer: stones drawn from the prediction, and stones that fell any way."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest, chisquare

from overturning.errors import ArgumentError
from overturning.findings.surveys import survey_prediction_findings
from overturning.settings import StonePopulation
from overturning.statistics.bootstrap import exact_share_interval
from overturning.surveys.comparison import compare_survey_with_prediction
from overturning.surveys.fall_directions import octant_weights_of_fallen_stone
from overturning.surveys.population import population_outcome_rates_by_record
from overturning.surveys.prediction import (
    STANDING_OR_FALL_SIDES,
    SiteFallPrediction,
    note_on_b_over_h_far_outside_study,
    observed_standing_or_side_index,
)
from overturning.surveys.stones import OCTANTS, Stone
from overturning.surveys.stored_comparison import StoredSurveyComparison


@pytest.fixture
def cube_of_falls_around_azimuth_60(make_cube_from_fall_rules, make_sector_fall_rule):
    """Return the cube of one site: blocks fall in planes within 30° of 60°, towards 60°."""
    return make_cube_from_fall_rules(make_sector_fall_rule(60, 30), azimuth=range(0, 360, 2))


def fallen_stone(azimuth: float, **more) -> Stone:
    """Return a stone that fell towards an azimuth, degrees."""
    return Stone(fell=True, fall_azimuth_deg=azimuth % 360, has_octant_direction=False, **more)


def random_fallen_stones(n: int, centre: float, half_width_deg: float, seed: int) -> list[Stone]:
    """Return `n` stones whose fall azimuths are drawn at random within `half_width_deg` of `centre`, degrees."""
    return [
        fallen_stone(a)
        for a in np.random.default_rng(seed).uniform(centre - half_width_deg, centre + half_width_deg, n)
    ]


def test_prediction_for_stones_of_unknown_face_averages_all_azimuths(cube_of_falls_around_azimuth_60) -> None:
    prediction = SiteFallPrediction(cube_of_falls_around_azimuth_60, random_outcome_stone_share=0)
    density = prediction.sector_probabilities_given_fall_for_unknown_face()
    assert density.sum() == pytest.approx(1)
    inside = np.abs((prediction.azimuth - 60 + 180) % 360 - 180) <= 30
    assert density[inside].sum() == pytest.approx(1)
    octants = prediction.octant_probabilities_from_sectors(density)
    assert octants.sum() == pytest.approx(1)
    # 29° to 91° in sectors: 22.5–67.5 is NE, 67.5–112.5 is E.
    assert octants[OCTANTS.index("NE")] == pytest.approx(38.5 / 62, abs=0.01)
    assert octants[OCTANTS.index("E")] == pytest.approx(23.5 / 62, abs=0.01)


def test_survey_drawn_from_the_prediction_fits_and_random_falls_do_not(cube_of_falls_around_azimuth_60) -> None:
    drawn, blind = (
        compare_survey_with_prediction(random_fallen_stones(40, *of), cube_of_falls_around_azimuth_60)
        for of in ((60, 30, 1), (0, 180, 2))
    )
    assert (drawn.fallen, drawn.known_direction_falls_without_face_or_b_over_h) == (40, 40)
    assert drawn.observed_mean_direction_deg == pytest.approx(60, abs=8)
    assert drawn.log_likelihood_ratio > 40
    assert blind.log_likelihood_ratio < 0
    assert max(drawn.likelihood_ratio_p, drawn.octant_uniformity_test.p_value) < 0.001
    assert min(blind.likelihood_ratio_p, blind.octant_uniformity_test.p_value) > 0.05
    assert drawn.exact_azimuth_watson_u2_test.p_value > 0.05
    assert (
        max(
            one.p_value
            for one in (blind.exact_azimuth_watson_u2_test, blind.octant_chi_square_test, blind.octant_watson_u2_test)
        )
        < 0.001
    )


@pytest.mark.long
def test_p_values_are_uniform_for_falls_in_random_directions(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 30), azimuth=range(0, 360, 10))
    p = [
        compare_survey_with_prediction(
            random_fallen_stones(12, 0, 180, seed=i), site, random_survey_count=200
        ).likelihood_ratio_p
        for i in range(60)
    ]
    assert np.mean(np.array(p) < 0.2) == pytest.approx(0.2, abs=0.13)
    assert np.mean(p) == pytest.approx(0.5, abs=0.12)


def test_one_impossible_fall_excludes_a_prediction_without_background(cube_of_falls_around_azimuth_60) -> None:
    """A single fall in a direction of probability 0 excludes a prediction without background.

    Only falls towards 30° to 90° are predicted, and a survey of such falls fits.
    """
    inside, outside = random_fallen_stones(20, 60, 25, seed=4), fallen_stone(200)
    found = compare_survey_with_prediction(inside, cube_of_falls_around_azimuth_60, random_outcome_stone_share=0.0)
    share = found.predicted_count_by_octant / 20
    there = share > 0
    assert found.octant_chi_square_test.statistic == pytest.approx(
        chisquare(found.observed_count_by_octant[there], 20 * share[there]).statistic
    )
    assert found.octant_chi_square_test.p_value > 0.05
    ruled_out = compare_survey_with_prediction(
        [*inside, outside], cube_of_falls_around_azimuth_60, random_outcome_stone_share=0.0
    )
    assert ruled_out.octant_chi_square_test.statistic == math.inf
    assert ruled_out.octant_chi_square_test.p_value < 1e-3
    assert (ruled_out.log_likelihood_ratio, ruled_out.likelihood_ratio_p) == (-math.inf, 1.0)


def test_falls_noted_as_octants_carry_less_evidence_than_azimuths(cube_of_falls_around_azimuth_60) -> None:
    exact = random_fallen_stones(30, 60, 30, seed=3)
    coarse = [
        Stone(fell=True, fall_azimuth_deg=45.0 * (((s.fall_azimuth_deg + 22.5) % 360) // 45), has_octant_direction=True)
        for s in exact
    ]
    fine = compare_survey_with_prediction(exact, cube_of_falls_around_azimuth_60)
    grouped = compare_survey_with_prediction(coarse, cube_of_falls_around_azimuth_60)
    assert np.array_equal(fine.observed_count_by_octant, grouped.observed_count_by_octant)
    assert 0 < grouped.log_likelihood_ratio < fine.log_likelihood_ratio
    assert grouped.exact_azimuth_watson_u2_test.n == 0


def test_count_of_a_stone_equals_repeated_stones(cube_of_falls_around_azimuth_60) -> None:
    one = compare_survey_with_prediction(
        [fallen_stone(60), fallen_stone(60), fallen_stone(80)], cube_of_falls_around_azimuth_60
    )
    two = compare_survey_with_prediction(
        [fallen_stone(60, stone_count=2), fallen_stone(80)], cube_of_falls_around_azimuth_60
    )
    assert one.log_likelihood_ratio == two.log_likelihood_ratio
    assert one.observed_count_by_octant.tolist() == two.observed_count_by_octant.tolist()


def test_stones_outside_the_grid_of_b_over_h_are_counted(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 30), azimuth=range(0, 360, 2), b_over_h=(0.2, 0.3, 0.4))
    inside = [fallen_stone(60), fallen_stone(60, b_over_h=0.4), fallen_stone(60, b_over_h=0.2, b_over_h_side=0.3)]
    outside = [fallen_stone(60, b_over_h=0.5, stone_count=2), fallen_stone(60, b_over_h=0.2, b_over_h_side=0.1)]
    found = compare_survey_with_prediction([*inside, *outside], cube)
    assert found.stones_outside_b_over_h_grid == 3
    assert compare_survey_with_prediction(outside[1:], cube).stones_outside_b_over_h_grid == 1
    assert compare_survey_with_prediction(inside, cube).stones_outside_b_over_h_grid == 0


@pytest.mark.parametrize(
    ("shape", "predicted"),
    [((0.2, 0.2), True), ((0.2, 0.49), True), ((0.2, 0.6), False), ((0.15, 0.3), False), ((0.6, 0.6), False)],
)
def test_stones_far_outside_the_grid_of_b_over_h_are_not_predicted(make_cube_from_fall_rules, shape, predicted) -> None:
    """A stone whose B/H in one direction is far outside the grid of the study is not predicted.

    Regression: a thin headstone, in one direction far stouter than all blocks of the study, was predicted to fall in
    that direction as they do.
    """
    cube = make_cube_from_fall_rules(
        lambda azimuth, *_: np.isfinite(azimuth), azimuth=range(0, 360, 2), b_over_h=(0.2, 0.3, 0.4)
    )
    stone = fallen_stone(0, face_azimuth_deg=0.0, b_over_h=shape[0], b_over_h_side=shape[1], stone_count=2)
    found = compare_survey_with_prediction([stone], cube)
    assert found.stones_far_outside_b_over_h_grid == (0 if predicted else 2)
    assert np.isfinite(found.computed_fall_share) == predicted
    assert (found.confusion_matrix is not None) == predicted
    if not predicted:
        assert found.log_likelihood_ratio == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("shapes", "count", "theirs"),
    [
        ([(0.2, 0.6), (0.3, 0.7)], 4, "0.6 to 0.7"),
        ([(0.1, 0.3)], 2, "0.1"),
        ([(0.17, 0.49), (math.nan, math.nan)], 0, ""),
    ],
)
def test_note_counts_stones_far_outside_the_grid_of_a_study(shapes, count, theirs) -> None:
    stones = [fallen_stone(0, b_over_h=front, b_over_h_side=side, stone_count=2) for front, side in shapes]
    notes = note_on_b_over_h_far_outside_study(stones, (0.2, 0.3, 0.4), "a.csv")
    start = (
        f"a.csv: {count} stones with b_over_h or b_over_h_side {theirs}, far outside the study's b_over_h, 0.2 to 0.4:"
    )
    assert [note.startswith(start) for note in notes] == [True] * bool(count)


def test_a_stone_stouter_than_blocks_that_stand_also_stands(make_cube_from_fall_rules) -> None:
    cube = make_cube_from_fall_rules(
        lambda azimuth, *_: np.isnan(azimuth), azimuth=range(0, 360, 2), b_over_h=(0.2, 0.3, 0.4)
    )
    stone = Stone(False, math.nan, has_octant_direction=False, face_azimuth_deg=0.0, b_over_h=0.3, b_over_h_side=0.9)
    found = compare_survey_with_prediction([stone], cube)
    assert (found.stones_far_outside_b_over_h_grid, found.computed_fall_share) == (0, 0.0)


@pytest.mark.parametrize(("front", "side"), [(0.2, 0.2), (0.2, 0.35), (0.5, 0.5)])
def test_prediction_for_unknown_face_azimuth_averages_all_face_azimuths(
    make_cube_from_fall_rules, front: float, side: float
) -> None:
    """The prediction for an unknown face is the mean of those for all face azimuths.

    Blocks fall in planes within 60° of 20°; those of B/H below 0.4 fall in all planes. If blocks fall in both planes
    of a stone, the earlier fall decides.
    """

    def fall_rule_near_azimuth_20_or_below_b_over_h_0_4(azimuth, _, slender, __):
        off = (azimuth - 20 + 90) % 180 - 90
        return np.where((np.abs(off) <= 60) | (slender < 0.4), np.where(np.cos(np.radians(azimuth - 50)) > 0, 1, -1), 0)

    cube = make_cube_from_fall_rules(fall_rule_near_azimuth_20_or_below_b_over_h_0_4, azimuth=range(0, 360, 10))
    times = 3 + np.random.default_rng(3).random(18)
    shape = cube["overturned"].shape
    cube["overturning_time"] = (
        cube["overturned"].dims,
        np.broadcast_to(np.tile(times, 2)[None, :, None, None, None], shape),
    )
    prediction = SiteFallPrediction(cube, random_outcome_stone_share=0)
    counts = np.zeros(36)
    for face in range(0, 360, 10):
        sides = prediction.standing_and_side_probabilities(standing_stone_of_known_face(face, front, side))
        for turn in range(4):
            counts[(face // 10 + 9 * turn) % 36] += sides[1 + turn]
    assert prediction.sector_probabilities_given_fall_for_unknown_face(front, side) == pytest.approx(
        counts / counts.sum()
    )
    if front == side:  # a population of squares, drawn one by one
        shape = {"low": 0.7 * front, "high": 0.7 * front}
        stones = StonePopulation(width=shape, height={"low": 0.7, "high": 0.7}, stones=8192)
        octants = population_outcome_rates_by_record(cube, stones)["fall_octant"].to_numpy().ravel()
        assert prediction.octant_probabilities_from_sectors(
            prediction.sector_probabilities_given_fall_for_unknown_face(front)
        ) == pytest.approx(octants / octants.sum(), abs=0.02)


def standing_stone_of_known_face(face: float = 60, front_b_over_h: float = 0.3, side_b_over_h: float = 0.3) -> Stone:
    """Return a stone that stands, with the azimuth of its face and B/H of front and side."""
    return Stone(False, math.nan, False, b_over_h=front_b_over_h, b_over_h_side=side_b_over_h, face_azimuth_deg=face)


@pytest.mark.parametrize(
    ("stone", "most"),
    [
        (standing_stone_of_known_face(60, 0.2, 0.5), "forwards"),
        (standing_stone_of_known_face(60, 0.5, 0.2), "stood"),
        (standing_stone_of_known_face(330, 0.5, 0.2), "to its right"),
    ],
)
def test_a_rectangular_stone_falls_over_its_slender_side(
    make_cube_from_fall_rules, make_sector_fall_rule, stone: Stone, most: str
) -> None:
    """Blocks fall in planes within 30° of 60°, up to B/H 0.3 only: a stone that is broad towards 60° stands."""
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 30, largest_b_over_h=0.3), azimuth=range(0, 360, 2))
    sides = SiteFallPrediction(site, random_outcome_stone_share=0).standing_and_side_probabilities(stone)
    assert STANDING_OR_FALL_SIDES[int(np.argmax(sides))] == most
    assert sides.sum() == pytest.approx(1)


@pytest.mark.parametrize(("face", "step", "north"), [(30, 15, 37.5), (45, 30, 22.5), (52, 2, 15.5), (60, 30, 7.5)])
def test_predicted_azimuths_are_uniform_within_45_degrees_of_the_face_normal(
    make_cube_from_fall_rules, make_sector_fall_rule, face, step, north
) -> None:
    """Predicted falls cover the 90° about the face normal evenly, even if 90° is no multiple of the azimuth step.

    `north` is the width of their part in octant N, degrees.
    """
    site = make_cube_from_fall_rules(make_sector_fall_rule(face, step), azimuth=range(0, 360, step))
    stone = fallen_stone(face, b_over_h=0.3, face_azimuth_deg=face)
    expected = compare_survey_with_prediction(
        [stone], site, random_outcome_stone_share=0, random_survey_count=1
    ).predicted_count_by_octant
    assert expected == pytest.approx([north / 90, 0.5, (45 - north) / 90, 0, 0, 0, 0, 0], abs=1e-3)


def cube_with_fall_times_along_60_and_150(
    make_cube_from_fall_rules, fall_time_along_60_s, fall_time_along_150_s, **more
):
    """Return a cube: blocks fall towards 60° and 150° (to the right) at the given times, s, in the two planes."""

    def fall_sides_along_60_and_150_deg(azimuth, *_rest):
        away = np.isin(azimuth, (240, 330))
        return np.where(np.isin(azimuth, (60, 150)), 1, np.where(away, -1, 0))

    cube = make_cube_from_fall_rules(fall_sides_along_60_and_150_deg, azimuth=range(0, 360, 30), **more)
    times = np.where(np.isin(cube["azimuth"] % 180, 60), fall_time_along_60_s, fall_time_along_150_s)
    shape = cube["overturned"].shape
    return cube.assign(
        overturning_time=(cube["overturned"].dims, np.broadcast_to(times[None, :, None, None, None], shape))
    )


@pytest.mark.parametrize(
    ("front", "across", "expected"),
    [
        (5.0, 6.0, [0, 1, 0, 0, 0]),
        (6.0, 5.0, [0, 0, 1, 0, 0]),
        # Where no order is known both share.
        (5.0, 5.0, [0, 0.5, 0.5, 0, 0]),
        (math.nan, 5.0, [0, 0.5, 0.5, 0, 0]),
        (math.nan, math.nan, [0, 0.5, 0.5, 0, 0]),
    ],
)
def test_the_earlier_fall_of_two_planes_decides_the_direction(
    make_cube_from_fall_rules, front: float, across: float, expected: list[float]
) -> None:
    sides = SiteFallPrediction(
        cube_with_fall_times_along_60_and_150(make_cube_from_fall_rules, front, across), random_outcome_stone_share=0
    ).standing_and_side_probabilities(standing_stone_of_known_face())
    assert sides == pytest.approx(expected)


def test_ensemble_runs_of_both_planes_are_combined_as_independent(make_cube_from_fall_rules) -> None:
    """In each plane half of the runs fall, earlier in the front plane: ¼ stand, ½ fall forwards, ¼ to the right."""
    cube = cube_with_fall_times_along_60_and_150(make_cube_from_fall_rules, 5.0, 6.0)
    half = np.abs(cube["overturned"]) * 0.5
    towards, away = half.where(cube["overturned"] > 0, 0.0), half.where(cube["overturned"] < 0, 0.0)
    cube = cube.assign(probability_towards=towards, probability_away=away)
    assert SiteFallPrediction(cube, random_outcome_stone_share=0).standing_and_side_probabilities(
        standing_stone_of_known_face()
    ) == pytest.approx([0.25, 0.5, 0.25, 0, 0])


def test_falls_in_both_planes_are_combined_at_equal_height_and_friction(make_cube_from_fall_rules) -> None:
    """At one friction blocks fall forwards, at the other to the right, so that no stone is predicted to stand."""

    def fall_sides_along_axis_set_by_friction(azimuth, height, slender, friction):
        axis = np.where(friction < 0.5, 60, 150)
        return np.where(azimuth == axis, 1, np.where(azimuth == axis + 180, -1, 0))

    cube = make_cube_from_fall_rules(
        fall_sides_along_axis_set_by_friction, azimuth=range(0, 360, 30), friction=(0.33, 1.0)
    )
    assert SiteFallPrediction(cube, random_outcome_stone_share=0).standing_and_side_probabilities(
        standing_stone_of_known_face()
    ) == pytest.approx([0, 0.5, 0.5, 0, 0])


def test_predictions_are_interpolated_between_azimuths_and_b_over_h(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 1, largest_b_over_h=0.3), azimuth=range(0, 360, 30))
    prediction = SiteFallPrediction(site, random_outcome_stone_share=0)
    assert prediction.standing_and_side_probabilities(standing_stone_of_known_face(75.0, side_b_over_h=0.5))[
        1
    ] == pytest.approx(0.5)
    assert prediction.standing_and_side_probabilities(
        standing_stone_of_known_face(front_b_over_h=0.35, side_b_over_h=0.5)
    )[1] == pytest.approx(0.5)


def test_cells_without_an_outcome_do_not_count_as_standing(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 1), azimuth=range(0, 360, 30))
    site["overturned"][..., 0] = np.nan  # one friction of two
    sides = SiteFallPrediction(site, random_outcome_stone_share=0).standing_and_side_probabilities(
        standing_stone_of_known_face()
    )
    assert sides == pytest.approx([0, 1, 0, 0, 0])
    site["overturned"][:] = np.nan
    assert SiteFallPrediction(site, random_outcome_stone_share=0).standing_and_side_probabilities(
        standing_stone_of_known_face()
    ).sum() == pytest.approx(1)


def test_azimuths_without_outcomes_get_the_mean_fall_probability(make_cube_from_fall_rules) -> None:
    """Fall azimuths whose plane has unknown outcomes get the mean probability of the other azimuths.

    Blocks fall in all planes but one, whose outcomes are unknown.
    """
    cube = make_cube_from_fall_rules(
        lambda azimuth, *_: np.where(azimuth % 180 == 90, np.nan, 1.0), azimuth=range(0, 180, 10)
    )
    prediction = SiteFallPrediction(cube, random_outcome_stone_share=0)
    # Towards its azimuth a plane falls always, away from it never; of plane 90 either is as likely.
    towards = np.where(prediction.azimuth < 180, 1.0, 0.0)
    # Nor is anything known of stones that face 0 or 90: one of their planes is that one.
    unknown = prediction.azimuth % 90 == 0
    towards[unknown] = towards[~unknown].mean()
    assert prediction.sector_probabilities_given_fall_for_unknown_face() == pytest.approx(towards / towards.sum())


def test_falls_normal_to_the_known_faces_are_not_tested_for_fit(cube_of_falls_around_azimuth_60) -> None:
    """Falls of stones with known faces, which are close to the normals of edges, are not tested for fit.

    Stones drawn from the prediction fall within some degrees of the normals, not evenly over 90°, so that a test of
    fit would reject them.
    """
    generator = np.random.default_rng(8)
    chances = SiteFallPrediction(cube_of_falls_around_azimuth_60).standing_and_side_probabilities(
        standing_stone_of_known_face(45)
    )[1:]
    edges = generator.choice(4, size=40, p=chances / chances.sum())
    azimuths = 45 + 90 * edges + generator.normal(0, 8, size=40)
    known = [fallen_stone(a, b_over_h=0.3, b_over_h_side=0.3, face_azimuth_deg=45) for a in azimuths]
    found = compare_survey_with_prediction(known, cube_of_falls_around_azimuth_60)
    assert (
        max(found.octant_chi_square_test.p_value, found.exact_azimuth_watson_u2_test.p_value) < 0.01
    )  # evenly over 90° they are not
    assert found.log_likelihood_ratio > 0
    assert found.likelihood_ratio_p < 0.05
    assert survey_prediction_findings(
        StoredSurveyComparison("", "", "", found)
    ).has_falls_with_known_face_and_b_over_h, "so that the report has no test of fit"
    unknown = compare_survey_with_prediction([fallen_stone(a) for a in azimuths], cube_of_falls_around_azimuth_60)
    assert not survey_prediction_findings(
        StoredSurveyComparison("", "", "", unknown)
    ).has_falls_with_known_face_and_b_over_h
    assert min(unknown.octant_chi_square_test.p_value, unknown.exact_azimuth_watson_u2_test.p_value) < 0.05


def test_confusion_matrix_of_observed_and_predicted_sides_is_counted_right(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 30, largest_b_over_h=0.3), azimuth=range(0, 360, 2))
    stones = [
        Stone(True, 65.0, False, stone_count=3, b_over_h=0.2, b_over_h_side=0.5, face_azimuth_deg=60),
        Stone(False, math.nan, False, stone_count=2, b_over_h=0.5, face_azimuth_deg=60),
        Stone(True, 240.0, False, b_over_h=0.2, b_over_h_side=0.5, face_azimuth_deg=60),
        fallen_stone(60),
    ]
    comparison = compare_survey_with_prediction(stones, site)
    assert comparison.confusion_matrix is not None
    assert comparison.confusion_matrix[1, 1] == 3
    assert comparison.confusion_matrix[0, 0] == 2
    assert comparison.confusion_matrix[3, 1] == 1
    assert comparison.confusion_matrix.sum() == 6
    assert comparison.known_direction_falls_without_face_or_b_over_h == 1
    assert (comparison.fallen, comparison.stood) == (5, 2)


@pytest.mark.parametrize(
    ("given", "without"),
    [
        ({}, (1, 1)),
        ({"b_over_h": 0.2}, (1, 0)),
        ({"b_over_h_side": 0.2}, (1, 0)),
        ({"face_azimuth_deg": 60.0}, (0, 1)),
        ({"face_azimuth_deg": 60.0, "b_over_h": 0.2}, (0, 0)),
        ({"face_azimuth_deg": 60.0, "b_over_h_side": 0.2}, (0, 0)),
    ],
)
def test_falls_without_face_azimuth_or_b_over_h_are_counted(
    cube_of_falls_around_azimuth_60, given: dict[str, float], without: tuple[int, int]
) -> None:
    stone = fallen_stone(60, **given)
    for stones in ([stone], [stone, fallen_stone(62, b_over_h=0.2, face_azimuth_deg=60.0)]):
        found = compare_survey_with_prediction(stones, cube_of_falls_around_azimuth_60)
        assert (
            found.known_direction_falls_without_face_azimuth,
            found.known_direction_falls_without_b_over_h,
        ) == without
        assert found.known_direction_falls_without_face_or_b_over_h == int(any(without))


def test_a_fall_in_an_unknown_direction_counts_as_a_fall_and_has_no_direction(cube_of_falls_around_azimuth_60) -> None:
    """Stones with unknown direction do not affect statistics of directions (regression: they counted as standing)."""
    stones = [*random_fallen_stones(20, 60, 30, 3), Stone(False, math.nan, False, stone_count=4)]
    lost = Stone(True, math.nan, False, stone_count=5, b_over_h=0.2, face_azimuth_deg=60.0)
    without = compare_survey_with_prediction(stones, cube_of_falls_around_azimuth_60)
    found = compare_survey_with_prediction([*stones, lost], cube_of_falls_around_azimuth_60)
    assert (found.fallen, found.stood, found.fallen_count_in_known_direction, found.falls_without_direction) == (
        25,
        4,
        20,
        5,
    )
    np.testing.assert_array_equal(found.observed_count_by_octant, without.observed_count_by_octant)
    for name in (
        "log_likelihood_ratio",
        "likelihood_ratio_p",
        "observed_mean_direction_deg",
        "exact_azimuth_watson_u2_test",
        "confusion_matrix",
    ):
        assert getattr(found, name) == getattr(without, name)
    only = compare_survey_with_prediction([lost], cube_of_falls_around_azimuth_60)
    assert only.observed_count_by_octant.sum() == 0
    doubted = survey_prediction_findings(StoredSurveyComparison("x", "", "site", only, ("x: radians?",)))
    assert (doubted.survey_file_warnings, doubted.falls_in_known_direction) == (["x: radians?"], 0)


def fall_rule_by_friction_and_height(azimuth, height, slender, friction):
    """Return overturning flags: in every plane blocks of B/H up to 0.3 fall, at low friction only those 1.2 m high."""
    return np.where(azimuth < 180, 1, -1) * (slender < 0.35) * ((friction > 0.5) | (height > 1))


STANDING_STONE = Stone(False, math.nan, False, b_over_h=0.2, face_azimuth_deg=0.0)


@pytest.mark.parametrize(
    ("stones", "mean", "low", "high"),
    [
        # Four blocks of the grid: one of them stands.
        ([fallen_stone(0, b_over_h=0.2)], 0.75, 0.0, 1.0),
        ([STANDING_STONE], 0.75, 0.0, 1.0),
        ([fallen_stone(0, b_over_h=0.4)], 0.0, math.nan, math.nan),  # the same for all blocks: no range
        # Half-way between a B/H that falls and one that stands.
        ([fallen_stone(0, b_over_h=0.35, face_azimuth_deg=0.0)], 0.75 * 0.75, 0.0, 0.75),
        # Known heights; of 0.9 m half falls at the low friction, and outside the grid the nearest height counts.
        ([fallen_stone(0, b_over_h=0.2, height_m=1.2)], 1.0, math.nan, math.nan),
        ([fallen_stone(0, b_over_h=0.2, height_m=0.9)], 0.75, 0.5, 1.0),
        ([fallen_stone(0, b_over_h=0.2, height_m=3.0), fallen_stone(0, b_over_h=0.2, height_m=0.2)], 0.75, 0.5, 1.0),
        # Without sizes: three of five B/H fall.
        ([fallen_stone(0)], 0.6 * 0.75, 0.0, 0.6),
        ([fallen_stone(0, stone_count=3), fallen_stone(0, b_over_h=0.5)], 0.75 * 0.6 * 0.75, 0.0, 0.75 * 0.6),
    ],
)
def test_computed_share_of_falls_has_the_range_over_height_and_friction(
    make_cube_from_fall_rules, stones: list[Stone], mean: float, low: float, high: float
) -> None:
    found = compare_survey_with_prediction(
        stones, make_cube_from_fall_rules(fall_rule_by_friction_and_height), random_survey_count=1
    )
    share = (found.computed_fall_share, found.lowest_computed_fall_share, found.highest_computed_fall_share)
    assert share == pytest.approx((mean, low, high), nan_ok=True)
    assert found.stones_outside_height_grid == sum(one.height_m in (0.2, 3.0) for one in stones)


def test_computed_fall_share_uses_the_known_face_or_all_orientations(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    """The computed fall share uses the known face of a stone, or all orientations if the face is unknown.

    Blocks fall in planes within 30° of 60°. A square stone falls if either of its two planes is among them, as for
    60° of each 90° of orientations.
    """
    site = make_cube_from_fall_rules(
        make_sector_fall_rule(60, 30), azimuth=range(0, 360, 1), height=(0.6,), friction=(1.0,)
    )
    shares = [
        compare_survey_with_prediction([stone], site, random_survey_count=1).computed_fall_share
        for stone in (
            fallen_stone(60, b_over_h=0.3),
            standing_stone_of_known_face(60),
            standing_stone_of_known_face(105),
            standing_stone_of_known_face(150),
            fallen_stone(60),
        )
    ]
    assert shares == pytest.approx([61 / 90, 1, 0, 1, 61 / 90], abs=1e-9)
    heights = make_cube_from_fall_rules(
        make_sector_fall_rule(60, 30), azimuth=range(0, 360, 5), height=(0.6, 1.2), friction=(1.0,)
    )
    half = (
        fallen_stone(60, b_over_h=0.3, height_m=0.8, face_azimuth_deg=60),
        fallen_stone(60, b_over_h=0.3, height_m=0.8),
    )
    for stones, of in (
        ([standing_stone_of_known_face(60)], site),
        (list(half), heights),
    ):  # one height and friction, or height stated
        single = compare_survey_with_prediction(stones, of, random_survey_count=1)
        assert math.isnan(single.lowest_computed_fall_share)
        assert math.isnan(single.highest_computed_fall_share)


def test_observed_share_and_predicted_mean_direction_match_known_values(cube_of_falls_around_azimuth_60) -> None:
    """The share 14 of 20 has SciPy's exact interval.

    Falls spread evenly within δ of 60° have the mean direction 60° and the resultant sin δ/δ.
    """
    stones = [fallen_stone(60, stone_count=14), Stone(False, math.nan, False, stone_count=6)]
    found = survey_prediction_findings(
        StoredSurveyComparison(
            "",
            "",
            "",
            compare_survey_with_prediction(stones, cube_of_falls_around_azimuth_60, random_outcome_stone_share=0.0),
        )
    )
    exact = binomtest(14, 20).proportion_ci(method="exact")
    assert found.observed_fall_share is not None
    observed = found.observed_fall_share
    assert (observed.value, observed.low, observed.high) == pytest.approx((0.7, exact.low, exact.high))
    half = np.radians(31)
    assert found.predicted_mean_direction_deg == pytest.approx(60)
    assert found.predicted_fall_direction_resultant_length == pytest.approx(np.sin(half) / half, abs=2e-3)
    only = compare_survey_with_prediction(stones[:1], cube_of_falls_around_azimuth_60)
    assert survey_prediction_findings(StoredSurveyComparison("", "", "", only)).observed_fall_share is None, (
        "perhaps the fallen ones alone"
    )


@pytest.mark.parametrize(("count", "total"), [(0, 9), (9, 9), (1, 9), (40, 41), (0, 1)])
def test_exact_interval_of_a_share_matches_scipy(count: int, total: int) -> None:
    assert exact_share_interval(count, total) == pytest.approx(
        tuple(binomtest(count, total).proportion_ci(method="exact"))
    )


@pytest.mark.parametrize(("azimuth", "side"), [(60, 1), (104, 1), (106, 2), (240, 3), (330, 4), (16, 1), (14, 4)])
def test_side_of_a_fall_follows_from_face_and_fall_azimuth(azimuth: float, side: int) -> None:
    assert observed_standing_or_side_index(fallen_stone(azimuth, face_azimuth_deg=60.0, b_over_h=0.4)) == side


def test_likelihood_ratio_is_neutral_without_predicted_falls_and_missing_without_observed_ones(
    make_cube_from_fall_rules,
) -> None:
    site = make_cube_from_fall_rules(lambda a, *_rest: np.zeros_like(a))
    comparison = compare_survey_with_prediction([fallen_stone(10), fallen_stone(200)], site)
    assert comparison.log_likelihood_ratio == pytest.approx(0, abs=1e-9)
    standing = compare_survey_with_prediction([Stone(False, math.nan, False)], site)
    assert (standing.fallen, standing.stood) == (0, 1)
    assert math.isnan(standing.log_likelihood_ratio)


@pytest.mark.parametrize(("b_over_h", "share"), [(0.2, 1.0), (0.3, 0.0), (0.1 + 0.2, 0.0), (0.35, math.nan)])
def test_fall_share_at_a_grid_b_over_h_ignores_missing_outcomes_at_the_next_one(
    make_cube_from_fall_rules, b_over_h: float, share: float
) -> None:
    site = make_cube_from_fall_rules(lambda *of: np.where(of[2] > 0.35, np.nan, np.where(of[2] < 0.25, 1, 0)))
    stone = Stone(False, math.nan, False, b_over_h=b_over_h, face_azimuth_deg=60.0)
    found = compare_survey_with_prediction([stone], site, random_outcome_stone_share=0.0)
    assert found.computed_fall_share == pytest.approx(share, nan_ok=True)


def test_stones_without_a_computed_outcome_are_counted_and_not_predicted_to_stand(make_cube_from_fall_rules) -> None:
    """Slender blocks fall in every plane, to both azimuths equally; stout ones have no outcome, at any height."""
    site = make_cube_from_fall_rules(lambda *of: np.where(of[2] > 0.35, np.nan, np.where(of[0] < 180, 1, -1)))
    site["overturned"].loc[{"height": 1.2}] = np.nan
    slender = Stone(False, math.nan, False, stone_count=2, height_m=1.0, b_over_h=0.2, face_azimuth_deg=60.0)
    stout = Stone(False, math.nan, False, stone_count=3, b_over_h=0.4, face_azimuth_deg=60.0)
    fell = fallen_stone(60, stone_count=5, b_over_h=0.5, face_azimuth_deg=60.0)
    found = compare_survey_with_prediction([slender, stout, fell, fallen_stone(10, b_over_h=0.4)], site)
    assert (found.stones_without_computed_outcome, found.known_direction_falls_without_computed_outcome) == (9, 6)
    assert found.computed_fall_share == 1.0
    assert found.confusion_matrix[0, 1:].sum() == found.confusion_matrix.sum() == 2
    np.testing.assert_allclose(found.predicted_count_by_octant, 6 / 8, atol=1e-9)
    of_study = survey_prediction_findings(StoredSurveyComparison("stones.csv", "0" * 64, "vale", found))
    assert (of_study.stones_with_checked_most_probable_outcome, of_study.falls_with_predicted_direction) == (2, 0)
    assert compare_survey_with_prediction([stout], site).confusion_matrix is None


@pytest.mark.parametrize("background", [0.0, 0.05])
def test_fallen_stones_that_never_fall_in_the_simulations_are_counted(
    make_cube_from_fall_rules, background: float
) -> None:
    """Fallen stones of B/H 0.45 are counted, since blocks fall in every plane up to B/H 0.3 and none broader falls."""
    site = make_cube_from_fall_rules(lambda azimuth, _, shape, *_rest: np.where(azimuth < 180, 1, -1) * (shape < 0.35))
    slender = fallen_stone(10)
    stout = fallen_stone(200, b_over_h=0.45)
    faced = fallen_stone(80, b_over_h=0.45, face_azimuth_deg=80.0)
    found = [
        compare_survey_with_prediction(list(stones), site, random_outcome_stone_share=background)
        for stones in ((slender, stout), (stout, faced))
    ]
    assert [one.known_direction_falls_without_any_computed_fall for one in found] == [1, 2]
    np.testing.assert_allclose(found[1].predicted_count_by_octant, 2 / 8, atol=1e-9)
    assert (
        compare_survey_with_prediction(
            [slender], site, random_outcome_stone_share=background
        ).known_direction_falls_without_any_computed_fall
        == 0
    )


def test_comparison_refuses_empty_surveys_several_records_and_3d_cubes(
    make_cube_from_fall_rules, cube_of_falls_around_azimuth_60
) -> None:
    with pytest.raises(ArgumentError, match="none"):
        compare_survey_with_prediction([], cube_of_falls_around_azimuth_60)
    with pytest.raises(ArgumentError, match="2 records"):
        compare_survey_with_prediction(
            [fallen_stone(1)], make_cube_from_fall_rules(lambda a, *_rest: np.zeros_like(a), events=("A", "B"))
        )
    with pytest.raises(ArgumentError, match="background"):
        compare_survey_with_prediction(
            [fallen_stone(1)], cube_of_falls_around_azimuth_60, random_outcome_stone_share=1.0
        )
    with pytest.raises(ArgumentError, match="of 3-D bodies"):
        compare_survey_with_prediction([fallen_stone(1)], cube_of_falls_around_azimuth_60.rename(azimuth="orientation"))


def test_a_16_point_direction_between_two_octants_counts_half_in_each() -> None:
    def octant_shares_of_fall(azimuth: float, **notation: bool) -> dict[str, float]:
        found = octant_weights_of_fallen_stone(Stone(True, azimuth, **{"has_octant_direction": False, **notation}))
        return {name: round(float(share), 9) for name, share in zip(OCTANTS, found, strict=True) if share > 0}

    assert octant_shares_of_fall(22.5, has_16_point_direction=True) == {"N": 0.5, "NE": 0.5}
    assert octant_shares_of_fall(337.5, has_16_point_direction=True) == {"NW": 0.5, "N": 0.5}
    assert octant_shares_of_fall(45, has_16_point_direction=True) == {"NE": 1}
    # NNE from magnetic north, declination 5°: 16.25° to 38.75°, of which 6.25° lie in N.
    assert octant_shares_of_fall(27.5, has_16_point_direction=True) == {
        "N": round(6.25 / 22.5, 9),
        "NE": round(16.25 / 22.5, 9),
    }
    assert octant_shares_of_fall(22.5) == {"NE": 1}
    assert octant_shares_of_fall(315, has_octant_direction=True) == {"NW": 1}


@pytest.mark.parametrize("declination", [6.5, 6.6])
def test_stones_split_between_octants_count_as_whole_stones(
    cube_of_falls_around_azimuth_60, declination: float
) -> None:
    """Tests count two stones even if the fractions of each in two octants add up to less than 1 by rounding.

    The rounding occurs with a declination of 6.5°. In an eighth of random surveys two stones lie at least as near to
    each other as these, whatever the prediction, so that p exceeds 0.1.
    """
    stones = [Stone(True, wind + declination, False, has_16_point_direction=True) for wind in (22.5, 45.0)]
    found = compare_survey_with_prediction(stones, cube_of_falls_around_azimuth_60)
    assert {found.octant_uniformity_test.n, found.octant_chi_square_test.n, found.octant_watson_u2_test.n} == {2}
    assert found.octant_uniformity_test.p_value > 0.1


def test_stones_of_each_site_are_compared_with_the_motion_there(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    """Stones at A and B fall as under two motions; log likelihood ratio and predicted counts add up over the sites."""
    east, west = (
        make_cube_from_fall_rules(make_sector_fall_rule(towards, 30), azimuth=range(0, 360, 2)) for towards in (90, 270)
    )
    at_a = [replace(stone, site="A") for stone in random_fallen_stones(20, 90, 30, seed=1)]
    at_b = [replace(stone, site="B") for stone in random_fallen_stones(20, 270, 30, seed=2)]
    both = compare_survey_with_prediction([*at_a, *at_b], east, results_cube_by_site={"B": west})
    alone = compare_survey_with_prediction(at_a, east), compare_survey_with_prediction(at_b, west)
    assert both.log_likelihood_ratio == pytest.approx(sum(one.log_likelihood_ratio for one in alone))
    assert both.predicted_count_by_octant == pytest.approx(sum(one.predicted_count_by_octant for one in alone))
    assert both.log_likelihood_ratio > 40 > 0 > compare_survey_with_prediction(at_b, east).log_likelihood_ratio
    # Shares by hand: where each plane falls and where none does.
    stands = make_cube_from_fall_rules(lambda azimuth, *_: 0 * azimuth, azimuth=range(0, 360, 2))
    falls = make_cube_from_fall_rules(lambda azimuth, *_: np.where(azimuth < 180, 1, -1), azimuth=range(0, 360, 2))
    stones = [
        replace(standing_stone_of_known_face(), site="A", stone_count=3),
        replace(standing_stone_of_known_face(), site="B", stone_count=1),
    ]
    found = compare_survey_with_prediction(stones, stands, results_cube_by_site={"B": falls})
    assert found.computed_fall_share == pytest.approx(1 / 4)
    # B lists its fallen stones alone: they count neither in the observed nor in the computed share.
    only_fallen = [stones[0], Stone(True, 90.0, False, site="B", stone_count=5), Stone(True, 90.0, False, site="A")]
    found = compare_survey_with_prediction(only_fallen, stands, results_cube_by_site={"B": falls})
    assert found.fallen == 6
    assert found.fallen_count_at_sites_with_standing_stones == 1
    assert found.stone_count_at_sites_with_standing_stones == 4
    assert found.computed_fall_share == 0.0


def test_cubes_of_the_sites_of_a_survey_need_equal_grids(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    fine, coarse = (
        make_cube_from_fall_rules(make_sector_fall_rule(60, 30), azimuth=range(0, 360, step)) for step in (2, 4)
    )
    with pytest.raises(ArgumentError, match="site 'B': its cube has other values of azimuth"):
        compare_survey_with_prediction(random_fallen_stones(3, 60, 30, 1), fine, results_cube_by_site={"B": coarse})
