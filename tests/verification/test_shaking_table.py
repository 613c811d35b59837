"""Comparison with shaking-table tests, on synthetic tests with known answers."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from overturning.arrays import FloatArray
from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.errors import ResultError
from overturning.model.cases import Cases
from overturning.statistics.bootstrap import (
    bootstrap_interval,
    interval_tail_share_for_few_earthquakes,
    mean_of_each_bootstrap_sample,
)
from verification.shaking_table import small_table
from verification.shaking_table.__main__ import (
    counts_and_scores_of_rectangles_by_damping_class,
    main,
    model_scores_with_intervals_and_predictions,
)
from verification.shaking_table.clouds import (
    PRISM_DISTRIBUTION,
    RECTANGLE_DISTRIBUTION,
    RandomStoneBoundsAndFallSimulator,
    StonesWithSimulatedOutcomes,
    is_in_any_candidate_size_range,
    sample_stones,
    simulate_random_stones_or_read_outcomes,
)
from verification.shaking_table.data import SPECIMEN_NUMBERS, ShakingTableTests, read_shaking_table_tests
from verification.shaking_table.models import (
    ENSEMBLE_AND_PEAKS_MODEL_NAME,
    NEIGHBOURHOOD_CENTRE_B_OVER_H,
    NEIGHBOURHOOD_CENTRE_HEIGHTS_M,
    PGA_PGV_LOGISTIC_MODEL_NAME,
    PRISMS_MODEL_NAME,
    RECTANGLES_MODEL_NAME,
    index_of_most_likely_size_neighbourhood,
    smoothed_fall_shares_by_size_and_test,
    split_into_odd_learning_and_even_predicted_tests,
    splits_leaving_out_one_motion,
)
from verification.shaking_table.scores import (
    bootstrap_interval_over_motions,
    bootstrap_samples_of_test_indices,
    f1_auc_and_brier_score,
    reliability_bins,
)


def test_prediction_scores_match_a_hand_calculation() -> None:
    p, fell = np.array([0.9, 0.6, 0.4, 0.1]), np.array([True, False, True, False])
    f1, auc, brier = f1_auc_and_brier_score(p, fell)
    assert f1 == pytest.approx(0.5)  # one hit, one miss, one false alarm
    assert auc == pytest.approx(0.75)
    assert brier == pytest.approx((0.01 + 0.36 + 0.36 + 0.01) / 4)
    _, area, _ = f1_auc_and_brier_score(np.array([0.9, 0.5, 0.5, 0.1]), fell)
    assert area == pytest.approx(0.875), "equal probabilities count as half"


def test_score_intervals_resample_motions_and_are_wider_for_few_motions() -> None:
    """Regression: plain percentile intervals were too short for few motions.

    The two tests of each motion are equal here, so the interval is that of ten values, not twenty.
    """
    values = np.random.default_rng(3).normal(size=10)
    motions, tests = np.repeat([f"RSN{i}" for i in range(10)], 2), np.repeat(values, 2)
    samples = bootstrap_samples_of_test_indices(motions, 20_000)
    found = bootstrap_interval_over_motions(np.array([tests[drawn].mean() for drawn in samples]), 10)
    packages = bootstrap_interval(mean_of_each_bootstrap_sample, values, bootstrap_sample_count=20_000, seed=4)
    assert tuple(found) == pytest.approx(tuple(packages), abs=0.04 * values.std())
    plain = np.quantile([tests[drawn].mean() for drawn in samples], [0.025, 0.975])
    assert found.high - found.low > 1.15 * (plain[1] - plain[0])
    assert np.isnan(bootstrap_interval_over_motions(np.arange(100.0), 7)).all()
    assert len(bootstrap_samples_of_test_indices(motions, 100)) == np.ceil(
        10 / interval_tail_share_for_few_earthquakes(10)
    )


def test_a_reliability_bin_without_falls_has_an_exact_upper_bound() -> None:
    """Regression: the interval of a bin without falls had no width.

    Its upper bound is 1 − 0.05^(1/20) for 20 motions, however many tests each motion has.
    """
    motions = np.repeat([f"RSN{i}" for i in range(20)], 3)
    probabilities, fell = np.tile([0.01, 0.01, 0.99], 20), np.tile([False, False, True], 20)
    first, last = reliability_bins(probabilities, fell, motions, 40)
    bound = 0.05 ** (1 / 20)
    assert (first.fallen_share, first.fallen_share_interval_low, first.fallen_share_interval_high) == (
        0.0,
        0.0,
        pytest.approx(1 - bound),
    )
    assert (last.fallen_share, last.fallen_share_interval_low, last.fallen_share_interval_high) == (
        1.0,
        pytest.approx(bound),
        1.0,
    )


@pytest.mark.parametrize("kind", [RECTANGLE_DISTRIBUTION, PRISM_DISTRIBUTION], ids=lambda kind: kind.name)
def test_sampled_stones_span_the_bounds_of_their_distribution(kind: RandomStoneBoundsAndFallSimulator) -> None:
    rows = sample_stones(kind, 256)
    for name, (low, high) in kind.bounds_by_parameter.items():
        assert low <= rows[name].min() < (1.05 * low or 0.05 * high)
        assert high * 0.95 < rows[name].max() <= high


@pytest.mark.parametrize("kind", [RECTANGLE_DISTRIBUTION, PRISM_DISTRIBUTION], ids=lambda kind: kind.name)
def test_stones_outside_all_size_neighbourhoods_do_not_change_fall_fractions(
    kind: RandomStoneBoundsAndFallSimulator,
) -> None:
    rows = sample_stones(kind, 256)
    near, fell = is_in_any_candidate_size_range(rows), np.random.default_rng(2).random((3, 256)) < 0.4
    whole = StonesWithSimulatedOutcomes(rows["b_over_h"], rows["height"], rows["damping"], fell)
    part = StonesWithSimulatedOutcomes(
        rows["b_over_h"][near], rows["height"][near], rows["damping"][near], fell[:, near]
    )
    assert 0.8 < near.mean() < 1
    np.testing.assert_array_equal(
        smoothed_fall_shares_by_size_and_test(part), smoothed_fall_shares_by_size_and_test(whole)
    )


@pytest.mark.long
def test_prisms_and_rectangles_fall_only_under_strong_motion() -> None:
    """Far below every threshold nothing falls; under a pulse of 1 s and 8 m/s² slender stones do."""
    time = np.arange(400) * 0.005
    pulse = np.where(time < 1, np.sin(2 * np.pi * time), 0.0)
    one = ShakingTableTests(
        np.arange(2), np.array(["a", "b"]), [0.1 * pulse, 8.0 * pulse], 0.005, np.array([0.1, 8.0]), np.ones(2),
        dict.fromkeys(SPECIMEN_NUMBERS, np.zeros(2, bool)),
    )  # fmt: skip
    for kind in (RECTANGLE_DISTRIBUTION, PRISM_DISTRIBUTION):
        found = simulate_random_stones_or_read_outcomes(kind, one, stone_count=64)
        assert not found.fell_by_test_and_stone[0].any()
        assert found.fell_by_test_and_stone[1][found.b_over_h < 0.2].mean() > 0.8


def invented_overturning_acceleration(b_over_h: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return the synthetic acceleration, m/s², at which a rectangle falls; it grows with B/H and height."""
    return 9.8 * b_over_h * (1 + height**2)


def synthetic_shaking_table_tests(
    peak: np.ndarray, threshold: np.ndarray, generator: np.random.Generator
) -> ShakingTableTests:
    """Return equally many tests of each of twelve motions; a stone falls if the peak exceeds its threshold."""
    return ShakingTableTests(
        laboratory_test_numbers=np.arange(peak.size),
        played_record_names=np.repeat([f"RSN{i}" for i in range(12)], peak.size // 12),
        accelerations=[np.zeros(2)] * peak.size,
        sampling_interval=0.005,
        measured_pga=peak,
        measured_pgv=0.1 * peak * np.exp(generator.normal(0, 0.3, peak.size)),
        fell_by_specimen=dict.fromkeys(SPECIMEN_NUMBERS, peak > threshold),
    )


@pytest.fixture(scope="module")
def synthetic_tests_and_stones() -> tuple[ShakingTableTests, StonesWithSimulatedOutcomes]:
    """Return 300 tests of twelve motions on a rectangle of B/H 0.15 and height 0.8 m, and the simulated stones."""
    generator = np.random.default_rng(1)
    peak = np.exp(generator.uniform(np.log(0.5), np.log(8), 300))
    rows = sample_stones(RECTANGLE_DISTRIBUTION, 4096)
    fell = peak[:, None] * rows["amplitude"] > invented_overturning_acceleration(rows["b_over_h"], rows["height"])
    threshold = invented_overturning_acceleration(np.array(0.15), np.array(0.8)) * np.exp(
        generator.normal(0, 0.35, 300)
    )
    tests = synthetic_shaking_table_tests(peak, threshold, generator)
    return tests, StonesWithSimulatedOutcomes(rows["b_over_h"], rows["height"], rows["damping"], fell)


@pytest.fixture(scope="module")
def synthetic_stone_fall_shares_by_size(
    synthetic_tests_and_stones: tuple[ShakingTableTests, StonesWithSimulatedOutcomes],
) -> FloatArray:
    """Smoothed share of simulated stones of similar B/H and height that fall, by size and test."""
    return smoothed_fall_shares_by_size_and_test(synthetic_tests_and_stones[1])


def test_the_likeliest_size_range_has_the_true_overturning_acceleration(
    synthetic_tests_and_stones: tuple[ShakingTableTests, StonesWithSimulatedOutcomes],
    synthetic_stone_fall_shares_by_size: FloatArray,
) -> None:
    tests, _ = synthetic_tests_and_stones
    centre = index_of_most_likely_size_neighbourhood(
        synthetic_stone_fall_shares_by_size, tests.fell_by_specimen[1], np.arange(150)
    )
    shape, size = divmod(centre, NEIGHBOURHOOD_CENTRE_HEIGHTS_M.size)
    assert invented_overturning_acceleration(
        NEIGHBOURHOOD_CENTRE_B_OVER_H[shape], NEIGHBOURHOOD_CENTRE_HEIGHTS_M[size]
    ) == pytest.approx(invented_overturning_acceleration(np.array(0.15), np.array(0.8)), rel=0.15)


def test_models_predict_unseen_synthetic_shaking_table_tests_reliably(
    synthetic_tests_and_stones: tuple[ShakingTableTests, StonesWithSimulatedOutcomes],
    synthetic_stone_fall_shares_by_size: FloatArray,
) -> None:
    tests, _ = synthetic_tests_and_stones
    rows, held = model_scores_with_intervals_and_predictions(
        tests,
        {
            RECTANGLES_MODEL_NAME: synthetic_stone_fall_shares_by_size,
            PRISMS_MODEL_NAME: synthetic_stone_fall_shares_by_size,
        },
        bootstrap_sample_count=40,
    )
    values = rows.set_index(["split", "specimen", "model", "score"])["value"]
    for split in ("odd to even", "motion left out"):
        for model in (PGA_PGV_LOGISTIC_MODEL_NAME, RECTANGLES_MODEL_NAME, ENSEMBLE_AND_PEAKS_MODEL_NAME):
            assert values[split, 1, model, "AUC"] > 0.94
            assert values[split, 1, model, "Brier score"] < 0.11
    assert (rows["low"] <= rows["value"] + 0.02).all()
    assert np.isfinite(held["motion left out", RECTANGLES_MODEL_NAME, 1]).all()
    for one in reliability_bins(
        held["motion left out", RECTANGLES_MODEL_NAME, 1], tests.fell_by_specimen[1], tests.played_record_names, 40
    ):
        if np.isfinite(one.fallen_share_interval_low):  # at least eight motions
            assert one.fallen_share_interval_low - 0.25 <= one.mean_probability <= one.fallen_share_interval_high + 0.25


def test_every_simulated_rectangle_is_in_exactly_one_damping_class(
    synthetic_tests_and_stones: tuple[ShakingTableTests, StonesWithSimulatedOutcomes],
) -> None:
    tests, made = synthetic_tests_and_stones
    found = counts_and_scores_of_rectangles_by_damping_class(tests, made)
    assert list(found) == ["0.9 to 1.6", "1.6 to 2.8", "2.8 to 5.1", "5.1 to 9.0"]
    assert sum(count for count, _ in found.values()) == made.damping_ratio_over_default.size
    assert all(rows.shape == (2, 3) and np.isfinite(rows).all() for _, rows in found.values())


def test_no_shaking_table_test_is_predicted_from_its_own_motion(
    synthetic_tests_and_stones: tuple[ShakingTableTests, StonesWithSimulatedOutcomes],
) -> None:
    tests, _ = synthetic_tests_and_stones
    for learn, predict in splits_leaving_out_one_motion(tests):
        assert not set(tests.played_record_names[learn]) & set(tests.played_record_names[predict])
    learn, predict = next(split_into_odd_learning_and_even_predicted_tests(tests))
    assert (tests.laboratory_test_numbers[learn] % 2 == 1).all()
    assert (tests.laboratory_test_numbers[predict] % 2 == 0).all()


def test_the_error_names_a_missing_array_or_file_of_shaking_table_tests(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = {
        "acceleration": np.arange(10, dtype=np.int16), "scale": 0.5, "start": [0, 4, 10], "sampling_interval": 0.005,
        "test": [11, 12], "motion": ["RSN1_A_X", "RSN1_A_Y"], "pga_g": [0.1, 0.2], "pgv": [0.01, 0.02],
        "overturned_1": [0, 1], "overturned_2": [0, 0],
    }  # fmt: skip
    np.savez(tmp_path / "tests.npz", **whole)
    tests = read_shaking_table_tests(tmp_path)
    assert tests.accelerations[1] == pytest.approx([2, 2.5, 3, 3.5, 4, 4.5])
    assert set(tests.played_record_names) == {"RSN1"}
    assert tests.fell_by_specimen[1].tolist() == [False, True]
    np.savez(tmp_path / "tests.npz", **{key: value for key, value in whole.items() if key != "pgv"})
    with pytest.raises(ResultError, match="no array 'pgv'"):
        read_shaking_table_tests(tmp_path)
    main(tmp_path / "nowhere")
    assert "no tests.npz" in capsys.readouterr().out


def test_small_table_motion_has_stated_peaks_and_table_tests_are_counted() -> None:
    for pga, ratio in ((0.4, 0.05), (1.0, 0.2)):
        motion = small_table.one_cosine_cycle(pga, ratio)
        along = motion.north
        assert np.abs(along).max() == pytest.approx(pga * 9.80665, rel=1e-6)
        velocity = np.cumsum(along) * motion.sampling_interval
        assert np.abs(velocity).max() == pytest.approx(pga * 9.80665 * ratio, rel=0.02)
        assert abs(velocity[-1]) < 0.03 * np.abs(velocity).max()
    sizes = {
        name: len(small_table.read_small_table_tests(name)) for name in small_table.DATE_AND_ORIENTATION_BY_TEST_FILE
    }
    # Omitted: three tests without a motion, and two with an outcome other than Y or N.
    assert sizes == {"exp0": 83, "exp270": 134, "PBR_0": 135, "PBR_90": 63}
    assert small_table.read_small_table_tests("exp270")["fell"].sum() == 51  # 50 times Y, once y


@pytest.mark.long
def test_the_fit_to_small_shaking_table_tests_recovers_a_known_block() -> None:
    """The B/H and height fitted to either half of the tests agree with the block's to 20 and 50 %.

    The size of the block lies between the centres of the size neighbourhoods. Each half of the tests is predicted
    from the other half only.
    """
    grid = [(pga, ratio) for pga in np.linspace(0.1, 1.0, 10) for ratio in np.linspace(0.03, 0.3, 8)]
    motions = [small_table.one_cosine_cycle(*pair) for pair in grid]
    fell = [bool(simulate_rigid_rocking(motion, Cases(0.0, 0.2, 0.15, 1.0)).overturned[0]) for motion in motions]
    tests = pd.DataFrame(grid, columns=["pga", "ratio"]).assign(fell=fell).sample(frac=1.0, random_state=1)
    shares = small_table.simulate_fall_shares_by_size_and_test(tests)
    probabilities, centres = small_table.predict_each_half_from_the_other(tests, shares)
    for b_over_h, height in centres:
        assert b_over_h == pytest.approx(0.15, rel=0.2)
        assert height == pytest.approx(0.2, rel=0.5)
    assert np.mean((probabilities["rigid block"] > 0.5) == tests["fell"]) > 0.9
    other = tests["fell"].to_numpy().copy()
    other[1::2] ^= True
    learnt, p = (
        each["rigid block"]
        for each in (small_table.predict_each_half_from_the_other(tests.assign(fell=other), shares)[0], probabilities)
    )
    assert np.array_equal(learnt[1::2], p[1::2])
    assert not np.array_equal(learnt[::2], p[::2])
