"""The logistic fit against a published example, a known answer and identities."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import linprog, minimize
from scipy.special import expit
from scipy.stats import t

from overturning.errors import ArgumentError
from overturning.statistics.logistic import (
    PREDICTOR_NAMES,
    coefficient_interval_and_predictor_range_rows,
    fit_logistic_model,
    fit_logistic_overturning_model,
    overturning_regression_data,
)

# Dalal, Fowlkes & Hoadley (1989), JASA 84: joint temperature (°F) and thermal distress of 23 launches before
# Challenger.
SHUTTLE_JOINT_TEMPERATURE_F = [
    66,
    70,
    69,
    68,
    67,
    72,
    73,
    70,
    57,
    63,
    70,
    78,
    67,
    53,
    67,
    75,
    70,
    81,
    76,
    79,
    75,
    76,
    58,
]
SHUTTLE_JOINT_DISTRESS = [0, 1, 0, 0, 0, 0, 0, 0, 1, 1, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 1]


def test_fit_matches_published_estimates_for_challenger_launches() -> None:
    """The published estimates for joint distress by temperature are those of maximum likelihood."""
    fit = fit_logistic_model(
        np.array(SHUTTLE_JOINT_TEMPERATURE_F)[:, None],
        SHUTTLE_JOINT_DISTRESS,
        np.arange(23),
        compute_jackknife_intervals=False,
    )
    assert fit.coefficient_estimates == pytest.approx([15.0429, -0.2322], abs=1e-4)
    assert np.isnan([*fit.coefficient_interval_lows, *fit.standard_errors]).all()
    assert float(fit.fall_probability([31.0])) == pytest.approx(0.9996, abs=1e-4)


def maximum_likelihood_coefficients_by_bfgs(design: np.ndarray, outcome: np.ndarray) -> np.ndarray:
    """Return the coefficients of maximum likelihood by another optimiser (SciPy's BFGS)."""

    def negative_log_likelihood_and_gradient(coefficients: np.ndarray) -> tuple[float, np.ndarray]:
        z = design @ coefficients
        return float(np.logaddexp(0.0, z).sum() - outcome @ z), design.T @ (expit(z) - outcome)

    found = minimize(
        negative_log_likelihood_and_gradient, np.zeros(design.shape[1]), jac=True, method="BFGS", options={"gtol": 1e-9}
    )
    return np.asarray(found.x)


def random_predictors_and_falls_with_slope(seed: int, slope: float, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Return two normal predictors, and falls whose log odds rise by `slope` per standard deviation of the first."""
    generator = np.random.default_rng(seed)
    x = generator.normal(size=(rows, 2))
    return x, (generator.random(rows) < expit(slope * (x @ [1.0, -0.5]))).astype(float)


def is_separated_by_a_plane(design: np.ndarray, outcome: np.ndarray) -> bool:
    """Return whether a plane separates falls from stands, by linear programming (Stiemke's theorem).

    A share between 0 and 1 counts as both a fall and a stand. No plane separates them if the rows of falls and the
    negated rows of stands, each times a positive factor, can add up to zero.
    """
    signed = np.concatenate([design[outcome > 0], -design[outcome < 1]])
    zero = np.zeros(design.shape[1])
    return not linprog(np.ones(len(signed)), A_eq=signed.T, b_eq=zero, bounds=(1.0, None)).success


@pytest.mark.parametrize("slope", [5.0, 10.0, 20.0, 40.0])
@pytest.mark.parametrize("rows", [40, 200])
def test_fit_is_called_separated_only_if_a_plane_separates_falls(slope: float, rows: int) -> None:
    """A steep fit is called separated exactly if a plane separates falls from stands; else it matches SciPy's BFGS."""
    for seed in range(12):
        x, y = random_predictors_and_falls_with_slope(seed, slope, rows)
        design = np.column_stack([np.ones(rows), x])
        fit = fit_logistic_model(x, y, np.zeros(rows), compute_jackknife_intervals=False)
        assert (
            "predictors separate falls from stands" in fit.reason_without_estimate_or_interval
        ) == is_separated_by_a_plane(design, y), (
            seed,
            fit.reason_without_estimate_or_interval,
        )
        if not fit.reason_without_estimate_or_interval:
            assert fit.coefficient_estimates == pytest.approx(
                maximum_likelihood_coefficients_by_bfgs(design, y), rel=1e-4
            ), seed


@pytest.mark.parametrize(
    ("outcome", "separated"),
    [
        ([0, 1, 0, 1, 1, 1], True),  # in the plane on the left, falls only on the right
        ([0, 1, 0, 1, 0, 1], False),
        ([0, 1, 0.5, 1, 1, 1], True),
        ([0.5, 0.5, 0.5, 1, 1, 1], True),
        ([0, 1, 0, 1, 0.5, 1], False),
        ([0, 0, 0, 1, 0.5, 1], True),
        ([0, 0, 0.1, 0.9, 1, 1], False),
    ],
)
def test_reference_check_of_separation_handles_ties_and_shares(outcome: list[float], separated: bool) -> None:
    """The predictor has two values with three rows each.

    An outcome between 0 and 1 counts as both a fall and a stand.
    """
    x = np.repeat([[0.0], [1.0]], 3, axis=0)
    assert is_separated_by_a_plane(np.column_stack([np.ones(6), x]), np.array(outcome)) == separated
    fit = fit_logistic_model(x, outcome, np.arange(6), compute_jackknife_intervals=False)
    assert (fit.reason_without_estimate_or_interval, bool(np.isnan(fit.coefficient_estimates).all())) == (
        "no fit: predictors separate falls from stands" if separated else "", separated
    )  # fmt: skip
    if not separated:
        means = np.reshape(outcome, (2, 3)).mean(axis=1)
        log_odds = np.log(means / (1 - means))
        assert fit.coefficient_estimates == pytest.approx([log_odds[0], log_odds[1] - log_odds[0]])


def test_fit_has_no_interval_if_omitting_one_earthquake_separates_the_data() -> None:
    """There is no interval if falls and stands overlap in a single earthquake, without which a plane separates them.

    If falls and stands overlap in several earthquakes, there is an interval.
    """
    x = np.linspace(-1.0, 1.0, 60)
    event, above = np.arange(60) % 10, (x > 0).astype(float)
    alone = np.where((event == 0) & (np.abs(x) < 0.5), 1 - above, above)
    fit = fit_logistic_model(x[:, None], alone, event)
    assert (
        fit.reason_without_estimate_or_interval
        == "no interval: without one earthquake predictors separate falls from stands"
    )
    assert np.isfinite(fit.coefficient_estimates).all()
    several = np.where(np.abs(x) < 0.2, 1 - above, above)
    several[np.abs(x) < 0.12] = above[np.abs(x) < 0.12]
    assert fit_logistic_model(x[:, None], several, event).reason_without_estimate_or_interval == ""


@pytest.mark.parametrize(
    ("x", "y"),
    [
        (np.array(SHUTTLE_JOINT_TEMPERATURE_F)[:, None] / 10.0 - 7.0, np.array(SHUTTLE_JOINT_DISTRESS)),
        random_predictors_and_falls_with_slope(1, 10.0, 240),
    ],
    ids=["launches", "steep"],
)
def test_estimates_and_errors_match_a_jackknife_over_clusters(x: np.ndarray, y: np.ndarray) -> None:
    """Logistic estimates and errors match SciPy's BFGS and the jackknife formulas over 12 clusters of rows."""
    cluster, design = np.arange(y.size) % 12, np.column_stack([np.ones(y.size), x])
    whole = maximum_likelihood_coefficients_by_bfgs(design, y)
    without = np.array(
        [maximum_likelihood_coefficients_by_bfgs(design[cluster != one], y[cluster != one]) for one in range(12)]
    )
    error = np.sqrt(11 / 12 * ((without - without.mean(axis=0)) ** 2).sum(axis=0))
    fit = fit_logistic_model(x, y, cluster)
    assert fit.coefficient_estimates == pytest.approx(12 * whole - 11 * without.mean(axis=0), rel=1e-4)
    assert fit.standard_errors == pytest.approx(error, rel=1e-4)
    assert fit.coefficient_interval_highs - fit.coefficient_estimates == pytest.approx(
        t.ppf(0.975, 11) * error, rel=1e-4
    )


def random_predictors_falls_and_earthquakes(
    generator: np.random.Generator, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return predictors, falls (0 or 1) and earthquake numbers of the cases of random records.

    The numbers of records per earthquake are those of the default study.
    """
    records = np.resize([4, 1, 1, 4, 1, 2, 1, 4, 2, 4, 1, 1, 1, 1], count)
    event = np.repeat(np.arange(count), records)
    strength = generator.normal(0, 0.3, count)[event] + generator.normal(0, 0.5, event.size)
    ratio = generator.normal(0, 0.4, event.size)
    own = generator.normal(0, 1.5, count)[event] + generator.normal(0, 1.2, event.size)
    slender = np.tile(np.log(np.linspace(0.1, 0.6, 6) / 0.3), 6)
    plane = np.repeat(generator.normal(0, 0.1, (event.size, 6)), 6, axis=1)
    over_west = strength[:, None] + plane - slender
    table = np.stack(np.broadcast_arrays(over_west, ratio[:, None], slender), axis=-1)
    falls = generator.random(over_west.shape) < expit(table @ [2.5, 1.5, 0.3] + own[:, None])
    return table.reshape(-1, 3), falls.ravel().astype(float), np.repeat(event, 36)


@pytest.mark.long
def test_intervals_cover_the_slopes_and_estimates_are_unbiased() -> None:
    """Jackknife intervals cover the true slopes of a logistic model in 92 to 97.5 % of samples.

    Regression: sandwich intervals with Student's t covered the slopes in 89 to 91 % of samples, and slopes on ln PGA
    were 5 to 11 % too large.

    The true slopes are those of a fit to 4,000 earthquakes, and so include the random effects of earthquakes.
    """
    generator = np.random.default_rng(42)
    truth = fit_logistic_model(
        *random_predictors_falls_and_earthquakes(generator, 4000), compute_jackknife_intervals=False
    ).coefficient_estimates
    fits = [fit_logistic_model(*random_predictors_falls_and_earthquakes(generator, 14)) for _ in range(600)]
    fits = [fit for fit in fits if not fit.reason_without_estimate_or_interval]
    assert len(fits) > 580
    held = np.mean(
        [(fit.coefficient_interval_lows <= truth) & (truth <= fit.coefficient_interval_highs) for fit in fits], axis=0
    )
    assert (held >= 0.92).all(), held
    assert (held <= 0.975).all(), held
    mean = np.mean([fit.coefficient_estimates for fit in fits], axis=0)
    assert mean[1:3] == pytest.approx(truth[1:3], rel=0.045)


def test_no_interval_if_the_fit_depends_on_one_earthquake() -> None:
    """There is no interval if all falls are in one earthquake, or if a predictor varies in one earthquake only."""
    x, event = np.linspace(-1, 1, 40), np.arange(40) // 4
    falls = np.where(event == 5, np.arange(40) % 2, 0)
    fit = fit_logistic_model(x[:, None], falls, event)
    assert "are of one earthquake" in fit.reason_without_estimate_or_interval
    table = np.column_stack([x, np.where(event == 5, np.arange(40) % 4, 0)])
    fit = fit_logistic_model(table, np.arange(40) % 2, event)
    assert "without one earthquake predictors are linearly dependent" in fit.reason_without_estimate_or_interval
    assert np.isfinite(fit.coefficient_estimates).all()
    assert np.isnan(fit.coefficient_interval_lows).all()


@pytest.mark.parametrize("share", [0.5, 0.01, 1e-9])
def test_equal_fall_shares_give_an_intercept_and_zero_slope(share: float) -> None:
    """The likeliest intercept is the logit of the share, and the likeliest slope 0."""
    x = np.linspace(-1, 1, 40)[:, None]
    fit = fit_logistic_model(x, np.full(40, share), np.arange(40) % 10)
    assert fit.reason_without_estimate_or_interval == ""
    assert fit.coefficient_estimates == pytest.approx([math.log(share / (1 - share)), 0.0], abs=1e-6)
    # Without earthquake 0, which has falls and stands, all shares are equal.
    group = np.append(np.zeros(20), 1 + np.arange(20) % 9)
    mixed = np.append(np.arange(20) % 2, np.full(20, share))
    assert fit_logistic_model(x, mixed, group).reason_without_estimate_or_interval == ""


def test_repeating_all_rows_of_clusters_leaves_standard_errors_unchanged() -> None:
    """Each cluster counts once, however many equal rows it has."""
    x, y = np.array(SHUTTLE_JOINT_TEMPERATURE_F)[:, None], np.array(SHUTTLE_JOINT_DISTRESS)
    single = fit_logistic_model(x, y, np.arange(23))
    double = fit_logistic_model(np.repeat(x, 3, axis=0), np.repeat(y, 3), np.repeat(np.arange(23), 3))
    assert double.standard_errors == pytest.approx(single.standard_errors, rel=1e-6)
    independent = fit_logistic_model(np.repeat(x, 3, axis=0), np.repeat(y, 3), np.arange(69))
    assert (independent.standard_errors < 0.7 * single.standard_errors).all()


def test_weight_of_a_row_counts_as_repetition() -> None:
    x, y = np.array(SHUTTLE_JOINT_TEMPERATURE_F)[:, None], np.array(SHUTTLE_JOINT_DISTRESS)
    weighted = fit_logistic_model(x, y, np.arange(23), weights=1 + y)
    repeated = fit_logistic_model(np.repeat(x, 1 + y, axis=0), np.repeat(y, 1 + y), np.repeat(np.arange(23), 1 + y))
    assert weighted.coefficient_estimates == pytest.approx(repeated.coefficient_estimates, rel=1e-8)
    assert weighted.standard_errors == pytest.approx(repeated.standard_errors, rel=1e-8)


def test_rows_of_zero_weight_do_not_affect_the_fit() -> None:
    """Rows of zero weight form no clusters of the jackknife.

    If all rows of positive weight fall, the reason stated for the missing fit is that everything falls.
    """
    x, y = np.array(SHUTTLE_JOINT_TEMPERATURE_F, np.float64)[:, None], np.array(SHUTTLE_JOINT_DISTRESS, np.float64)
    whole = fit_logistic_model(x, y, np.arange(23))
    more = fit_logistic_model(
        np.vstack([x, x[:4]]), np.append(y, 1 - y[:4]), np.arange(27), weights=np.append(np.ones(23), np.zeros(4))
    )
    assert (more.row_count, more.earthquake_cluster_count) == (23, 23)
    np.testing.assert_array_equal(more.standard_errors, whole.standard_errors)
    alike = fit_logistic_model(x[:3], [1, 1, 0], range(3), weights=[1, 1, 0])
    assert alike.reason_without_estimate_or_interval == "no fit: everything falls"


def test_intervals_cover_the_slope_despite_a_random_shift_of_each_cluster() -> None:
    """With a shift common to each cluster the 95 % interval still holds the slope in most samples."""
    generator, held = np.random.default_rng(2), 0
    for _ in range(150):
        group = np.repeat(np.arange(25), 30)
        x = generator.normal(size=group.size) + generator.normal(size=25)[group]
        linear = 0.8 * x + 0.5 * generator.normal(size=25)[group]
        y = generator.random(group.size) < 1 / (1 + np.exp(-linear))
        fit = fit_logistic_model(x[:, None], y.astype(float), group)
        held += (
            fit.coefficient_interval_lows[1] <= 0.8 * 0.94 <= fit.coefficient_interval_highs[1]
        )  # marginal slope: shrunk by about 1/√(1 + 0.35 · 0.25)
    assert held / 150 > 0.88


@pytest.mark.parametrize(
    ("outcome", "word"),
    [([0, 0, 0, 0], "nothing falls"), ([1, 1, 1, 1], "everything falls"), ([0, 0, 1, 1], "separate")],
)
def test_the_note_states_why_a_fit_fails(outcome: list[int], word: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A failed fit states its reason.

    So it does with NumPy before 2.4, which cannot compute the rank of a matrix without rows.
    """
    rank = np.linalg.matrix_rank
    monkeypatch.setattr(np.linalg, "matrix_rank", lambda matrix: rank(matrix) if len(matrix) else np.max(matrix))
    fit = fit_logistic_model([[1.0], [2.0], [3.0], [4.0]], outcome, [0, 1, 2, 3])
    assert word in fit.reason_without_estimate_or_interval
    assert np.isnan(fit.coefficient_estimates).all()


@pytest.mark.parametrize("earthquakes", [1, 2, 7, 8])
def test_few_earthquakes_give_no_interval(earthquakes: int) -> None:
    """Fewer than eight earthquakes give no interval."""
    fit = fit_logistic_model(
        np.array(SHUTTLE_JOINT_TEMPERATURE_F)[:, None], SHUTTLE_JOINT_DISTRESS, np.arange(23) % earthquakes
    )
    assert np.isfinite(fit.coefficient_estimates).all()
    assert np.isfinite([fit.coefficient_interval_lows, fit.coefficient_interval_highs]).all() == (earthquakes == 8)
    assert ("no interval: fewer than 8 earthquakes" in fit.reason_without_estimate_or_interval) == (earthquakes < 8)


@pytest.mark.parametrize("constant", [0.6, -1.14, 1e4])
@pytest.mark.parametrize("rounding", [0.0, 1e-9, 1e-7])
def test_a_constant_predictor_has_no_coefficient(constant: float, rounding: float) -> None:
    """A predictor that varies by rounding only counts as constant and has no coefficient.

    Regression: ln PGV/PGA of a pulse, which varies by rounding only, had a coefficient of −10¹².
    """
    near = constant * (1.0 + rounding * np.cos(np.arange(23.0)))
    x = np.column_stack([SHUTTLE_JOINT_TEMPERATURE_F, near])
    fit, without = (fit_logistic_model(one, SHUTTLE_JOINT_DISTRESS, np.arange(23)) for one in (x, x[:, :1]))
    assert fit.coefficient_estimates[:2] == pytest.approx(without.coefficient_estimates)
    assert fit.standard_errors[:2] == pytest.approx(without.standard_errors)
    assert np.isnan([fit.coefficient_estimates[2], fit.standard_errors[2]]).all()


@pytest.mark.parametrize(("x", "outcome"), [([[1.0]], [1, 0]), ([[1.0], [2.0]], [0, 2]), ([[1.0], [math.nan]], [0, 1])])
def test_regression_data_of_wrong_shape_or_value_are_refused(x: list[list[float]], outcome: list[int]) -> None:
    with pytest.raises(ArgumentError):
        fit_logistic_model(x, outcome, range(len(outcome)))


def test_fit_to_a_cube_recovers_the_known_slope(make_cube_from_fall_rules: Callable[..., xr.Dataset]) -> None:
    """Blocks fall above West's limit by a noisy margin; the fit recovers the slope on PGA over the limit."""
    generator = np.random.default_rng(4)
    azimuth = np.arange(0, 360, 10.0)
    pga = np.exp(generator.uniform(0, 2.5, size=(12, 1)) + 0.1 * np.cos(np.radians(2 * azimuth)))
    pgv = pga * np.exp(generator.uniform(-3, -1.5, size=(12, 1)))
    cube = make_cube_from_fall_rules(
        lambda a, *_rest: np.zeros_like(a), azimuth=azimuth, events=[f"E{i}" for i in range(12)]
    )
    limit = 9.80665 * cube["b_over_h"].values[None, None, None, :, None]
    linear = 3 * np.log(pga[:, :, None, None, None] / limit) + np.log(pgv / pga)[:, :, None, None, None] + 2
    fell = generator.random(cube["overturned"].shape) < 1 / (1 + np.exp(-linear))
    cube["overturned"] = cube["overturned"].copy(data=fell.astype(np.float32))
    intensity = xr.Dataset(
        {"pga": (("record", "azimuth"), pga), "pgv": (("record", "azimuth"), pgv)}, coords={"azimuth": azimuth}
    )
    predictors, outcome, event, weight = overturning_regression_data(cube.chunk({"record": 1}), intensity)
    assert predictors.shape == (12 * 18 * 2 * 5, 4)
    assert weight.mean() == pytest.approx(1)
    assert set(event) == set(range(12))
    assert outcome.mean() == pytest.approx(float(cube["overturned"].isel(azimuth=slice(18)).mean()), abs=1e-6)
    fit = fit_logistic_overturning_model(cube, intensity)
    assert (fit.row_count, fit.earthquake_cluster_count) == (2160, 12)
    assert fit.coefficient_interval_lows[1] < 3 < fit.coefficient_interval_highs[1]
    assert fit.coefficient_interval_lows[2] < 1 < fit.coefficient_interval_highs[2]
    table = coefficient_interval_and_predictor_range_rows(fit)
    assert [row[0] for row in table] == ["intercept", *PREDICTOR_NAMES]
    assert table[4][4] == pytest.approx(np.log(0.6))
    with pytest.raises(ArgumentError, match="azimuths"):
        fit_logistic_overturning_model(cube, intensity.isel(azimuth=slice(5)))
