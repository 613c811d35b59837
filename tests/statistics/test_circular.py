"""Circular statistics against worked examples of textbooks and an independent library."""

import itertools
import math

import numpy as np
import pytest
from pycircstat2 import hypothesis, load_data
from scipy.stats import chisquare, multinomial

from overturning.errors import ArgumentError
from overturning.statistics.circular import (
    chi_square_test_of_sectors,
    fall_shares_by_sector,
    mean_angle_deg_and_mean_resultant_length,
    rayleigh_test_by_random_rotation,
    sector_index,
    watson_u2_test,
    watson_u2_test_of_sectors,
    wrap_axis_difference_to_90_deg,
)

# Mardia & Jupp (2000), Directional Statistics, example 2.1: stops of a roulette wheel.
ROULETTE_STOPS_DEG = [43, 45, 52, 61, 75, 88, 88, 279, 357]
# Zar (2010), Biostatistical Analysis, example 26.4: lean of trees.
TREE_LEANS_DEG = [45, 55, 81, 96, 110, 117, 132, 154]


def test_first_sector_is_centred_on_north_and_indices_stay_in_range() -> None:
    assert sector_index([0, 22.4, 22.5, 337.4, 337.5, 720, -40], 8).tolist() == [0, 0, 1, 7, 0, 0, 7]
    # Rounding brings −22.5° − 4e-15 to 360° and not below it.
    assert int(sector_index(math.nextafter(-22.5, -90.0), 8)) in (0, 7)


@pytest.mark.parametrize(
    ("angles", "axial", "mean", "length"),
    [
        ([15, 355], False, (5, 1e-9), (math.cos(math.radians(10)), 1e-9)),
        (ROULETTE_STOPS_DEG, False, (51, 0.5), (0.711, 5e-4)),
        (TREE_LEANS_DEG, False, (99, 0.5), (0.82522, 1e-5)),
        # Axes have no head, so that opposite directions cancel and axes at right angles do.
        ([10, 190], True, (10, 1e-9), (1, 1e-9)),
        ([170, 10], True, (0, 1e-9), (math.cos(math.radians(20)), 1e-9)),
        ([10, 190], False, (math.nan, 0), (0, 1e-12)),
        ([0, 90], True, (math.nan, 0), (0, 1e-12)),
        ([], False, (math.nan, 0), (math.nan, 0)),
    ],
)
def test_mean_angle_and_resultant_match_textbook_examples(angles, axial, mean, length) -> None:
    for value, (expected, within) in zip(
        mean_angle_deg_and_mean_resultant_length(angles, axial=axial), (mean, length), strict=True
    ):
        assert value == pytest.approx(expected, abs=within, nan_ok=True)


def test_weight_of_an_angle_counts_as_repetition() -> None:
    assert mean_angle_deg_and_mean_resultant_length([20, 100], [2, 1]) == pytest.approx(
        mean_angle_deg_and_mean_resultant_length([20, 20, 100])
    )


def test_difference_of_two_axes_is_wrapped_to_90_degrees() -> None:
    assert wrap_axis_difference_to_90_deg([0, 90, -90, 91, 180, 270, -1]).tolist() == [
        0,
        90,
        90,
        -89,
        0,
        90,
        -1,
    ]


def test_watson_u2_test_matches_a_worked_example() -> None:
    # Kanji (2006), 100 Statistical Tests, test 96; vanishing directions of thirteen pigeons.
    pigeons = watson_u2_test(np.array([20, 135, 145, 165, 170, 200, 300, 325, 335, 350, 350, 350, 355]) / 360)
    assert pigeons.statistic == pytest.approx(0.1361, abs=5e-5)
    assert pigeons.p_value > 0.1


@pytest.mark.parametrize("n", [5, 40])
def test_watson_u2_test_matches_critical_values_of_stephens(n: int) -> None:
    # Stephens (1970), table 1: modified U² at 10, 5, 2.5 and 1 %, for every n.
    for critical, level in ((0.152, 0.10), (0.187, 0.05), (0.221, 0.025), (0.267, 0.01)):
        wanted = critical / (1 + 0.8 / n) + 0.1 / n - 0.1 / n**2
        # A sample with exactly that U²: points at the centres of n equal parts, all squeezed by a factor.
        rank = (2 * np.arange(1, n + 1) - 1) / (2 * n) - 0.5
        squeeze = 1 - math.sqrt((wanted - 1 / (12 * n)) / (rank**2).sum())
        result = watson_u2_test(0.5 + squeeze * rank)
        assert result.statistic == pytest.approx(wanted)
        assert result.p_value == pytest.approx(level, rel=0.05)  # the table has three digits


@pytest.mark.parametrize("name", ["B3", "B7", "B11", "B12"])  # Fisher (1993), appendix B
def test_watson_u2_test_matches_pycircstat2_for_any_origin(name: str) -> None:
    angle = load_data(name, source="fisher")["θ"].to_numpy(dtype=float)
    radians = np.radians(angle)
    watson = hypothesis.watson_test(radians, n_simulation=4999)
    for turn in (0, 77, 200):  # whatever the origin
        ours = watson_u2_test((angle + turn) % 360 / 360)
        assert ours.statistic == pytest.approx(watson.U2, rel=1e-9)
        assert ours.p_value == pytest.approx(watson.pval, abs=0.02)


def test_grouped_watson_p_value_matches_enumeration_of_all_tables() -> None:
    counts, p = np.array([4, 1, 0, 1]), np.array([0.4, 0.3, 0.2, 0.1])

    def watson_u2_of_counts(table: tuple[int, ...]) -> float:
        s = np.cumsum(np.array(table) - 6 * p)
        return float((((s - (s * p).sum()) ** 2) * p).sum() / 6)

    tables = [t for t in itertools.product(range(7), repeat=4) if sum(t) == 6]
    exact = sum(
        multinomial.pmf(t, 6, p) for t in tables if watson_u2_of_counts(t) >= watson_u2_of_counts(tuple(counts)) - 1e-12
    )
    result = watson_u2_test_of_sectors(counts, p)
    assert result.statistic == pytest.approx(watson_u2_of_counts(tuple(counts)))
    assert result.p_value == pytest.approx(exact, abs=0.01)


def test_grouped_watson_statistic_is_larger_for_adjacent_sectors() -> None:
    even = np.full(8, 1 / 8)
    counts = ([6, 6, 0, 0, 0, 0, 0, 0], [0, 0, 6, 6, 0, 0, 0, 0], [6, 0, 0, 0, 6, 0, 0, 0])
    together, rotated, apart = (watson_u2_test_of_sectors(one, even) for one in counts)
    assert together.statistic > 2 * apart.statistic
    assert rotated.statistic == pytest.approx(together.statistic)


def test_chi_square_test_matches_scipy() -> None:
    counts, p = np.array([30, 22, 25, 43.0]), np.full(4, 0.25)
    ours, theirs = chi_square_test_of_sectors(counts, p), chisquare(counts)
    assert (ours.statistic, ours.p_value) == (pytest.approx(theirs.statistic), pytest.approx(theirs.pvalue, abs=0.01))


@pytest.mark.parametrize("probability", [[0.5, 0.6], [1.5, -0.5], [1.0]])
def test_invalid_sector_probabilities_are_refused(probability: list[float]) -> None:
    with pytest.raises(ArgumentError):
        watson_u2_test_of_sectors([1, 2], probability)
    with pytest.raises(ArgumentError, match="0 to 1"):
        watson_u2_test([0.2, 1.2])


def test_goodness_of_fit_tests_without_observations_have_no_p_value() -> None:
    for result in (watson_u2_test([]), watson_u2_test_of_sectors([0, 0], [0.5, 0.5])):
        assert result.n == 0
        assert math.isnan(result.p_value)


@pytest.mark.parametrize("place", [0.0, 0.3, 1.0])
def test_one_angle_alone_does_not_reject_random_directions(place: float) -> None:
    assert watson_u2_test([place]).p_value == 1.0
    assert watson_u2_test_of_sectors(np.eye(8)[int(7 * place)], np.full(8, 1 / 8)).p_value == 1.0


@pytest.mark.parametrize("angles", [TREE_LEANS_DEG, ROULETTE_STOPS_DEG, [10, 130, 250, 20, 140], [0, 100, 170, 300]])
def test_common_axis_test_of_unit_vectors_agrees_with_rayleighs_test(angles: list[float]) -> None:
    """The p-value agrees with Zar's approximation for Rayleigh's test (2010, equation 27.4).

    The approximation is good to a few parts in 1,000.
    """
    radians = np.radians(angles)
    found, n = rayleigh_test_by_random_rotation(np.cos(radians), np.sin(radians)), len(angles)
    length = n * abs(np.exp(1j * radians).mean())
    expected = math.exp(math.sqrt(1 + 4 * n + 4 * (n**2 - length**2)) - (1 + 2 * n))
    assert (found.n, found.statistic) == (n, pytest.approx(length / n))
    assert found.p_value == pytest.approx(expected, abs=0.02)


def test_common_axis_p_value_of_two_vectors_follows_from_their_angle() -> None:
    """The angle between two random unit vectors is uniform from 0 to 180°, so that the p-value is angle/180°."""
    for angle in (4.0, 30.0, 120.0):
        found = rayleigh_test_by_random_rotation(np.cos(np.radians([0, angle])), np.sin(np.radians([0, angle])))
        assert found.p_value == pytest.approx(angle / 180, abs=0.02)
    assert rayleigh_test_by_random_rotation([0.3], [0.1]).p_value == 1.0
    assert math.isnan(rayleigh_test_by_random_rotation([], []).p_value)


@pytest.mark.parametrize("winds", [(0, 0), (0, 4), (0, 4, 0), (0, 1, 0, 0), (1, 2, 4, 6)])
@pytest.mark.parametrize("fold", [1, 2])
def test_p_value_of_compass_directions_matches_full_enumeration(winds: tuple[int, ...], fold: int) -> None:
    """If directions are random, all 8ⁿ sequences of n of the eight compass points are equally probable."""

    def resultant_length_of_compass_points(wind: np.ndarray) -> np.ndarray:
        return np.abs(np.exp(0.25j * math.pi * fold * wind).mean(axis=-1))

    every = np.stack(np.meshgrid(*len(winds) * [np.arange(8)]), axis=-1)
    expected = (
        resultant_length_of_compass_points(every) >= resultant_length_of_compass_points(np.array(winds)) - 1e-9
    ).mean()
    angle = np.radians(45.0 * fold * np.array(winds))
    found = rayleigh_test_by_random_rotation(np.cos(angle), np.sin(angle), 45.0 * fold)
    assert found.p_value == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize("count", [8, 14])
def test_common_axis_test_has_its_nominal_size_and_high_power(count: int) -> None:
    """The test for a common axis rejects isotropic vectors in 5 % of samples, and aligned ones in at least 93 %.

    The vectors are random, of length 0.3 to 0.9; the aligned ones have von Mises' κ = 3.
    """
    generator, found = np.random.default_rng(42), {}
    for kappa, samples in ((0.0, 1000), (3.0, 300)):
        vectors = np.exp(1j * generator.vonmises(1.0, kappa, (samples, count)))
        vectors *= generator.uniform(0.3, 0.9, (samples, count))
        tests = [rayleigh_test_by_random_rotation(one.real, one.imag) for one in vectors]
        found[kappa] = np.mean([one.p_value <= 0.05 for one in tests])
    assert found[0.0] == pytest.approx(0.05, abs=0.02)
    assert found[3.0] >= 0.93


@pytest.mark.parametrize(
    ("angles", "weight", "wide", "shares"),
    [
        ([0, 7.4, 352.6, 359], None, 0.0, {0: 1.0}),
        ([-7.6, 7.6, 90], None, 0.0, {23: 1 / 3, 1: 1 / 3, 6: 1 / 3}),
        ([-7.5, 7.5], None, 0.0, {23: 0.25, 0: 0.5, 1: 0.25}),  # on borders: half on either side
        ([352.5, 97.5], [3.0, 1.0], 0.0, {23: 0.375, 0: 0.375, 6: 0.125, 7: 0.125}),
        ([0, 180], [3.0, 1.0], 0.0, {0: 0.75, 12: 0.25}),
        ([7.5], None, 15.0, {0: 0.5, 1: 0.5}),
        ([0], None, 45.0, {23: 1 / 3, 0: 1 / 3, 1: 1 / 3}),
        ([0], None, 30.0, {23: 0.25, 0: 0.5, 1: 0.25}),
    ],
)
def test_shares_of_sectors_match_hand_computation(
    angles: list[float], weight: list[float] | None, wide: float, shares: dict[int, float]
) -> None:
    """There are 24 sectors of 15°, the first from −7.5° to 7.5°.

    An azimuth noted in steps of several degrees is shared among the sectors that its step overlaps.
    """
    found = fall_shares_by_sector(angles, None if weight is None else np.array(weight), wide)
    expected = np.zeros(24)
    expected[list(shares)] = list(shares.values())
    np.testing.assert_allclose(found, expected, atol=1e-12)
