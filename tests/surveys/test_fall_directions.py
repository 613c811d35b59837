"""Tests of observed fall directions do not depend on north, on a mirror, or on the resolution of the directions."""

import math
from dataclasses import replace

import numpy as np
import pytest

from overturning.surveys.comparison import compare_survey_with_prediction
from overturning.surveys.prediction import SiteFallPrediction
from overturning.surveys.stones import Stone


def fallen_stone(azimuth: float, **more) -> Stone:
    """Return a stone that fell towards an azimuth, degrees."""
    return Stone(fell=True, fall_azimuth_deg=azimuth % 360, has_octant_direction=False, **more)


def cube_with_fall_direction_by_slenderness(
    make_cube_from_fall_rules,
    stout_azimuth_deg: float = 200.0,
    half_width_deg: float = 40.0,
    angular_period_deg: float = 360.0,
):
    """Return a cube on a grid of 15°: slender blocks fall around 60° and stout ones around `stout_azimuth_deg`.

    Both fall within `half_width_deg` of their azimuth and, with an `angular_period_deg` of 180°, of the opposite one.
    """

    def fall_rule(azimuth: np.ndarray, _: np.ndarray, b_over_h: np.ndarray, *__: np.ndarray) -> np.ndarray:
        away = azimuth - np.where(b_over_h < 0.3, 60.0, stout_azimuth_deg)
        return (
            np.abs((away + 0.5 * angular_period_deg) % angular_period_deg - 0.5 * angular_period_deg) <= half_width_deg
        )

    return make_cube_from_fall_rules(fall_rule, azimuth=range(0, 360, 15), b_over_h=[0.2, 0.4])


def cube_with_two_fall_axes(make_cube_from_fall_rules):
    """Return a cube in which slender blocks fall along the axis of 60° to both sides, and stout ones along 150°."""
    return cube_with_fall_direction_by_slenderness(make_cube_from_fall_rules, 150.0, 20.0, 180.0)


@pytest.mark.parametrize("turn", [90, 195, 300])
@pytest.mark.parametrize("cube_of", [cube_with_fall_direction_by_slenderness, cube_with_two_fall_axes])
def test_rotating_survey_and_cube_together_changes_no_test_result(
    make_cube_from_fall_rules, cube_of, turn: int
) -> None:
    """Rotating survey and cube together changes no test result, for stones of two B/H with different directions.

    Directions predicted to both sides of an axis have no mean.
    """
    cube, generator = cube_of(make_cube_from_fall_rules), np.random.default_rng(5)
    stones = [
        fallen_stone(azimuth, b_over_h=b)
        for azimuth, b in zip(generator.uniform(0, 360, 20), [0.2, 0.4] * 10, strict=True)
    ]
    turned = [replace(stone, fall_azimuth_deg=(stone.fall_azimuth_deg + turn) % 360) for stone in stones]
    first, second = (
        compare_survey_with_prediction(stones, cube),
        compare_survey_with_prediction(turned, cube.roll(azimuth=turn // 15, roll_coords=False)),
    )
    assert (first.predicted_resultant_length < 1e-6) == (cube_of is cube_with_two_fall_axes)
    assert second.exact_azimuth_watson_u2_test.statistic == pytest.approx(
        first.exact_azimuth_watson_u2_test.statistic, rel=1e-6
    )
    assert second.log_likelihood_ratio == pytest.approx(first.log_likelihood_ratio, rel=1e-6)


@pytest.mark.long
def test_p_values_of_exact_azimuths_are_uniform_for_falls_to_both_sides(make_cube_from_fall_rules) -> None:
    cube, generator = cube_with_two_fall_axes(make_cube_from_fall_rules), np.random.default_rng(8)
    p = []
    for _ in range(200):
        b = generator.choice([0.2, 0.4], 20)
        centre = np.where(b < 0.3, 60.0, 150.0) + 180.0 * generator.integers(0, 2, 20)
        azimuth = centre + generator.uniform(-22.5, 22.5, 20)
        stones = [fallen_stone(float(one), b_over_h=float(of)) for one, of in zip(azimuth, b, strict=True)]
        p.append(
            compare_survey_with_prediction(
                stones, cube, random_outcome_stone_share=0.0, random_survey_count=20
            ).exact_azimuth_watson_u2_test.p_value
        )
    assert np.mean(np.array(p) <= 0.05) < 0.1
    assert np.mean(np.array(p) <= 0.5) == pytest.approx(0.5, abs=0.12)


@pytest.mark.parametrize(
    ("step", "count", "surveys"),
    [
        (30, 100, 40),
        *(pytest.param(*one, 200, marks=pytest.mark.long) for one in ((5, 200), (10, 200), (15, 100), (45, 40))),
    ],
)
def test_a_true_prediction_fits_azimuths_recorded_in_steps(
    make_cube_from_fall_rules, make_sector_fall_rule, step: int, count: int, surveys: int
) -> None:
    """Tests seldom reject a true prediction if fall azimuths drawn from it are rounded to steps.

    Tests for continuous angles would reject every survey in steps of 30°. So would tests of octants that each hold one
    or two of the possible azimuths. An azimuth split between two octants varies less than a whole stone, so that the
    tests of octants reject a true prediction less often than their level states.
    """
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 60), azimuth=range(0, 360, 5))
    predicted, generator = SiteFallPrediction(site), np.random.default_rng(1)
    share, width = predicted.sector_probabilities_given_fall_for_unknown_face(), np.diff(predicted.borders)
    p = []
    for _ in range(surveys):
        place = generator.choice(share.size, count, p=share)
        azimuth = np.round((predicted.borders[place] + generator.random(count) * width[place]) / step) * step
        stones = [fallen_stone(float(one), fall_azimuth_recording_step_deg=float(step)) for one in azimuth]
        found = compare_survey_with_prediction(stones, site, random_survey_count=200)
        p.append(
            [
                found.exact_azimuth_watson_u2_test.p_value,
                found.octant_chi_square_test.p_value,
                found.octant_watson_u2_test.p_value,
            ]
        )
    rejected = np.mean(np.array(p) <= 0.05, axis=0)
    assert rejected.max() <= (0.15 if surveys < 100 else 0.1)
    assert np.mean(np.array(p)[:, 0] <= 0.5) == pytest.approx(0.5, abs=0.2 if surveys < 100 else 0.1)


def test_a_wrong_prediction_does_not_fit_azimuths_recorded_in_steps(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 60), azimuth=range(0, 360, 5))
    stones = [
        fallen_stone(30.0 * number, fall_azimuth_recording_step_deg=30.0)
        for number in (5, 6, 6, 7, 7, 7, 8, 8, 9)
        for _ in range(3)
    ]
    found = compare_survey_with_prediction(stones, site)
    assert (
        max(
            found.exact_azimuth_watson_u2_test.p_value,
            found.octant_chi_square_test.p_value,
            found.octant_watson_u2_test.p_value,
        )
        < 0.01
    )


def test_expected_octant_counts_follow_the_steps_of_observed_azimuths(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    """All blocks fall within 52.5° to 67.5°, noted as 60° in steps of 30°: a quarter of the step is in octant E."""
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 1), azimuth=range(0, 360, 15))
    found = compare_survey_with_prediction(
        [fallen_stone(60, fall_azimuth_recording_step_deg=30.0)], site, random_outcome_stone_share=0.0
    )
    np.testing.assert_allclose(found.observed_count_by_octant, [0, 0.75, 0.25, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(found.predicted_count_by_octant, found.observed_count_by_octant, atol=1e-12)


def fallen_stone_of_compass_point(number: int, **more) -> Stone:
    """Return a stone whose fall direction is noted as one of the 16 compass points, numbered clockwise from north."""
    return Stone(True, 22.5 * number, False, has_16_point_direction=True, **more)


def test_mirrored_survey_and_prediction_keep_likelihood_ratio(make_cube_from_fall_rules) -> None:
    """Mirroring both a survey of compass points and the prediction does not change the likelihood ratio.

    On a grid of 15°, every second of the 16 compass points is an azimuth of the grid, and the others lie half-way
    between two.
    """
    cube = cube_with_fall_direction_by_slenderness(make_cube_from_fall_rules)
    mirrored = cube.isel(azimuth=[-i % 24 for i in range(24)]).assign_coords(azimuth=cube["azimuth"])
    numbers = [1, 3, 3, 5, 7, 9, 10]
    one = compare_survey_with_prediction([fallen_stone_of_compass_point(n, b_over_h=0.2) for n in numbers], cube)
    other = compare_survey_with_prediction(
        [fallen_stone_of_compass_point(-n % 16, b_over_h=0.2) for n in numbers], mirrored
    )
    assert other.log_likelihood_ratio == pytest.approx(one.log_likelihood_ratio, rel=1e-9)


def test_probability_of_a_compass_point_is_the_mean_density_over_its_width(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    """All falls lie within 52.5° to 67.5°: a quarter of these 15° lies in NE (up to 56.25°), the rest in ENE."""
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 1), azimuth=range(0, 360, 15))
    for number, share in ((2, 3.75 / 15), (3, 11.25 / 15)):
        found = compare_survey_with_prediction(
            [fallen_stone_of_compass_point(number)], cube, random_outcome_stone_share=0.0
        )
        assert found.log_likelihood_ratio == pytest.approx(math.log(share * 16), rel=1e-9)
    assert (
        compare_survey_with_prediction(
            [fallen_stone_of_compass_point(4)], cube, random_outcome_stone_share=0.0
        ).log_likelihood_ratio
        == -math.inf
    )


@pytest.mark.long
def test_p_values_of_compass_points_are_uniform_for_random_directions(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 40), azimuth=range(0, 360, 15))
    generator = np.random.default_rng(3)
    p = [
        compare_survey_with_prediction(
            [fallen_stone_of_compass_point(int(n)) for n in generator.integers(0, 16, 15)],
            cube,
            random_survey_count=300,
        ).likelihood_ratio_p
        for _ in range(200)
    ]
    assert np.mean(np.array(p) <= 0.05) < 0.09
    assert np.mean(np.array(p) <= 0.5) == pytest.approx(0.5, abs=0.11)


def test_mean_direction_is_reported_only_if_random_directions_are_rejected(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    site = make_cube_from_fall_rules(make_sector_fall_rule(60, 30), azimuth=range(0, 360, 2))
    around = compare_survey_with_prediction([fallen_stone(azimuth) for azimuth in (3, 100)], site)
    assert around.observed_resultant_length > 0.6
    assert math.isnan(around.observed_mean_direction_deg)
    assert compare_survey_with_prediction(
        [fallen_stone(azimuth) for azimuth in range(30, 90, 4)], site
    ).observed_mean_direction_deg == pytest.approx(60, abs=10)
