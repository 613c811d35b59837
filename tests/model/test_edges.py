"""First edge that a stone passes, by hand."""

import numpy as np

from overturning.model.edges import fall_flag_and_azimuth_from_planes, fall_probability_over_each_edge

NAN = np.nan


def test_the_earlier_fall_of_two_planes_decides_the_fall_azimuth() -> None:
    #        both, second first | both, first first | one | the other | neither | no time needed where one falls
    falls = [[1, 1, 1, 0, 0, 1], [1, 1, 0, 1, 0, 0]]
    time = [[3.0, 2.0, 9.0, NAN, NAN, NAN], [2.5, 2.5, NAN, 1.0, NAN, NAN]]
    towards = np.array([[0.0] * 6, [90.0] * 6])
    fell, azimuth = fall_flag_and_azimuth_from_planes(falls, time, towards)
    assert fell.tolist() == [1, 1, 1, 1, 0, 1]
    np.testing.assert_array_equal(azimuth, [90, 0, 0, 90, NAN, 0])


def test_a_missing_plane_outcome_never_counts_as_standing() -> None:
    fell, azimuth = fall_flag_and_azimuth_from_planes(
        [[NAN, NAN, NAN], [0, 1, NAN]], [[NAN] * 3, [NAN, 2.0, NAN]], np.zeros((2, 3))
    )
    assert np.isnan(fell).all()
    assert np.isnan(azimuth).all()


def test_falls_in_two_planes_with_a_missing_time_have_no_direction() -> None:
    fell, azimuth = fall_flag_and_azimuth_from_planes([[1], [1]], [[NAN], [2.0]], [[0.0], [90.0]])
    assert fell.tolist() == [1]
    assert np.isnan(azimuth).all()


def test_the_plane_with_the_earliest_fall_decides_the_fall_azimuth() -> None:
    """A round column falls in each of eighteen planes at another time; the earliest fall gives its azimuth."""
    time = np.random.default_rng(1).permutation(18).astype(float)
    fell, azimuth = fall_flag_and_azimuth_from_planes(np.ones(18), time, 10.0 * np.arange(18))
    assert (fell, azimuth) == (1, 10 * np.flatnonzero(time == 0)[0])


def test_a_certain_fall_has_its_whole_probability_at_the_edge_passed_first() -> None:
    generator = np.random.default_rng(2)
    falls, time = generator.integers(0, 2, (2, 500)).astype(float), generator.permutation(1000).reshape(2, 500) * 0.01
    fell, azimuth = fall_flag_and_azimuth_from_planes(falls, time, np.array([[0.0], [90.0]]) * np.ones((2, 500)))
    over = fall_probability_over_each_edge(falls, time)
    assert (over.sum(axis=0) == fell).all()
    assert (over[:, fell == 1].argmax(axis=0) * 90 == azimuth[fell == 1]).all()


def test_probabilities_of_falls_over_two_edges_match_a_hand_calculation() -> None:
    """Of fall probabilities 1/2 and 1/5, the joint 1/10 is for the edge passed first, or split 5 to 2 if not known."""
    for first, second, shared in ((1.0, 2.0, 1.0), (2.0, 1.0, 0.0), (NAN, 1.0, 5 / 7)):
        over = fall_probability_over_each_edge(np.array([[0.5], [0.2]]), np.array([[first], [second]]))
        np.testing.assert_allclose(over[:, 0], [0.4 + 0.1 * shared, 0.1 + 0.1 * (1 - shared)])
