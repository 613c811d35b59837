"""Mean direction and axis of single falls: by hand, with scipy, and coverage of the interval."""

import math

import numpy as np
import pytest
import scipy

from overturning.statistics.mean_direction import MAX_OBSERVATIONS_FOR_BOOTSTRAP, mean_direction_with_interval


def test_mean_direction_and_axis_of_eight_falls_match_hand_computation() -> None:
    # Four falls at 30° and four at 50°: mean 40°, resultant cos 10°. As axes: 40°, cos 20°.
    falls = [30.0, 50.0] * 4
    found, axis = (
        mean_direction_with_interval(falls),
        mean_direction_with_interval([*falls[:4], *(one + 180 for one in falls[4:])], axial=True),
    )
    assert found.significant_mean_deg == pytest.approx(40)
    assert found.mean_resultant_length == pytest.approx(math.cos(math.radians(10)))
    assert axis.significant_mean_deg == pytest.approx(40)
    assert axis.mean_resultant_length == pytest.approx(math.cos(math.radians(20)))
    assert 0 < found.interval_half_width_deg <= 10
    assert found.test_of_no_common_direction.p_value < 0.001


def test_opposite_falls_have_a_mean_axis_and_no_mean_direction() -> None:
    falls = np.array([10, 20, 30, 15, 25, 190, 200, 210, 195, 205])
    assert math.isnan(mean_direction_with_interval(falls).significant_mean_deg)
    assert mean_direction_with_interval(falls, axial=True).significant_mean_deg == pytest.approx(20)


def test_mean_direction_and_axis_match_scipy() -> None:
    falls = np.random.default_rng(1).vonmises(math.radians(310), 2.0, 40) * 180 / math.pi
    expected = math.degrees(scipy.stats.circmean(np.radians(falls)))
    assert mean_direction_with_interval(falls).significant_mean_deg == pytest.approx(expected)
    n, length = 40, mean_direction_with_interval(falls).mean_resultant_length
    assert length == pytest.approx(1 - scipy.stats.circvar(np.radians(falls)))
    assert mean_direction_with_interval(falls).test_of_no_common_direction.p_value < math.exp(-n * length**2) + 0.001


def test_rayleigh_p_value_of_random_falls_matches_its_approximation() -> None:
    falls = np.random.default_rng(7).uniform(0, 360, 60)
    found = mean_direction_with_interval(falls)
    assert found.test_of_no_common_direction.p_value == pytest.approx(
        math.exp(-60 * found.mean_resultant_length**2), abs=0.03
    )


@pytest.mark.parametrize("falls", [[], [40.0], [40.0, 41.0, 39.0]])
def test_mean_direction_of_few_falls_has_no_interval(falls: list[float]) -> None:
    assert math.isnan(mean_direction_with_interval(falls).interval_half_width_deg)
    assert mean_direction_with_interval(falls).observation_count == len(falls)


@pytest.mark.parametrize(("count", "concentration"), [(12, 2.0), (30, 1.0)])
def test_intervals_of_the_mean_direction_cover_the_true_direction(count: int, concentration: float) -> None:
    generator = np.random.default_rng(3)
    covered = list[bool]()
    for _ in range(300):
        falls = np.degrees(generator.vonmises(math.radians(355), concentration, count))
        found = mean_direction_with_interval(falls, bootstrap_sample_count=500)
        if math.isfinite(found.significant_mean_deg):
            covered.append(abs((found.significant_mean_deg - 355 + 180) % 360 - 180) <= found.interval_half_width_deg)
    assert len(covered) > 250
    assert 0.91 <= np.mean(covered) <= 0.99


@pytest.mark.parametrize(("step", "spread"), [(45, 1), (45, 8), (45, 15), (22.5, 3), (22.5, 40), (10, 2)])
def test_intervals_cover_the_true_direction_of_azimuths_noted_in_steps(step: float, spread: float) -> None:
    """Intervals of the mean direction cover the true direction if fall azimuths are rounded to coarse steps.

    Falls that scatter less than the step share a rounding error, which their scatter does not show.
    """
    generator, covered = np.random.default_rng(6), list[bool]()
    for true in generator.uniform(0, 360, 200):
        falls = step * np.round((true + spread * generator.normal(size=20)) / step)
        found = mean_direction_with_interval(falls, step, bootstrap_sample_count=500)
        covered.append(abs((found.significant_mean_deg - true + 180) % 360 - 180) <= found.interval_half_width_deg)
    assert np.mean(covered) >= 0.9


@pytest.mark.parametrize(
    ("axial", "spread", "count", "anywhere"),
    [
        (False, 8, 300, 0.0), (False, 8, 100, 0.08), (False, 3, 1500, 0.0), (True, 8, 300, 0.0),
        *(pytest.param(False, *one, marks=pytest.mark.long)
          for one in ((8, 1500, 0.08), (12, 1000, 0.0), (15, 300, 0.08), (20, 1000, 0.0), (35, 300, 0.0))),
    ],
)  # fmt: skip
def test_intervals_of_many_compass_directions_cover_the_true_direction(
    axial: bool, spread: float, count: int, anywhere: float
) -> None:
    """Intervals of the mean direction of many falls allow for their rounding to eight compass points.

    The sampling error of many falls is small, so that their common rounding error matters.

    Regression: with a scatter of 8° and 8 % of falls in random directions, 41 % of the intervals contained the true
    direction, since a bound from the variance of all falls took the spread of the random falls for scatter of the
    others. For 300 falls without random ones it was 81 %.
    """
    generator, covered, full = np.random.default_rng(6), list[bool](), 180.0 if axial else 360.0
    for true in generator.uniform(0, full, 100):
        falls = true + spread * generator.normal(size=count) + 180.0 * axial * generator.integers(0, 2, count)
        falls = np.where(generator.random(count) < anywhere, generator.uniform(0, 360, count), falls)
        found = mean_direction_with_interval(45 * np.round(falls / 45), 45.0, axial=axial, bootstrap_sample_count=300)
        covered.append(
            abs((found.significant_mean_deg - true + full / 2) % full - full / 2) <= found.interval_half_width_deg
        )
    assert np.mean(covered) >= 0.9


def test_rounding_much_finer_than_the_scatter_does_not_widen_the_interval() -> None:
    """Equal values among twenty falls that scatter by about 20°, noted in degrees, are no sign of a common error."""
    falls = np.round(90.0 + 20.0 * np.random.default_rng(3).normal(size=20))
    noted, exact = (mean_direction_with_interval(falls, step).interval_half_width_deg for step in (1.0, 0.0))
    assert noted == exact


def test_equal_compass_directions_have_an_interval_of_half_their_step() -> None:
    many = mean_direction_with_interval([90.0] * (MAX_OBSERVATIONS_FOR_BOOTSTRAP + 1), 45.0)
    assert (many.significant_mean_deg, many.interval_half_width_deg) == (pytest.approx(90.0), pytest.approx(22.5))
    falls = [0.0] * 5 + [180.0] * 4
    found, axis = (mean_direction_with_interval(falls, 45.0, axial=axial) for axial in (False, True))
    assert math.isnan(found.significant_mean_deg)
    assert (axis.significant_mean_deg % 180, axis.interval_half_width_deg) == (
        pytest.approx(0, abs=1e-9),
        pytest.approx(22.5),
    )


def test_interval_of_four_times_as_many_falls_is_half_as_wide() -> None:
    generator = np.random.default_rng(4)
    few = np.degrees(generator.vonmises(1.0, 1.0, MAX_OBSERVATIONS_FOR_BOOTSTRAP))
    of_few, of_many = (mean_direction_with_interval(angles) for angles in (few, np.tile(few, 4)))
    assert of_many.significant_mean_deg == pytest.approx(of_few.significant_mean_deg)
    assert of_many.interval_half_width_deg == pytest.approx(of_few.interval_half_width_deg / 2, rel=0.06)
