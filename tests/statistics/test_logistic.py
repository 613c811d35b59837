"""The logistic fit against a published example, a known answer and identities."""

import numpy as np
import pytest
import xarray as xr

from overturning.errors import ArgumentError
from overturning.statistics.logistic import PREDICTORS, describe, logistic_fit, overturning_fit, overturning_rows

# Dalal, Fowlkes & Hoadley (1989), JASA 84: joint temperature (°F) and thermal distress of 23 launches before
# Challenger.
TEMPERATURE = [66, 70, 69, 68, 67, 72, 73, 70, 57, 63, 70, 78, 67, 53, 67, 75, 70, 81, 76, 79, 75, 76, 58]
DISTRESS = [0, 1, 0, 0, 0, 0, 0, 0, 1, 1, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 1]


def test_challenger() -> None:
    fit = logistic_fit(np.array(TEMPERATURE)[:, None], DISTRESS, np.arange(23))
    assert fit.coefficient == pytest.approx([15.0429, -0.2322], abs=1e-4)
    assert float(fit.probability([31.0])) == pytest.approx(0.9996, abs=1e-4)


def test_clustered_errors_do_not_change_when_clusters_repeat_themselves() -> None:
    x, y = np.array(TEMPERATURE)[:, None], np.array(DISTRESS)
    single = logistic_fit(x, y, np.arange(23))
    double = logistic_fit(np.repeat(x, 3, axis=0), np.repeat(y, 3), np.repeat(np.arange(23), 3))
    assert double.standard_error == pytest.approx(single.standard_error, rel=1e-6)
    independent = logistic_fit(np.repeat(x, 3, axis=0), np.repeat(y, 3), np.arange(69))
    assert (independent.standard_error < 0.7 * single.standard_error).all()


def test_weights_are_repetitions() -> None:
    x, y = np.array(TEMPERATURE)[:, None], np.array(DISTRESS)
    weighted = logistic_fit(x, y, np.arange(23), weight=1 + y)
    repeated = logistic_fit(np.repeat(x, 1 + y, axis=0), np.repeat(y, 1 + y), np.repeat(np.arange(23), 1 + y))
    assert weighted.coefficient == pytest.approx(repeated.coefficient, rel=1e-8)
    assert weighted.standard_error == pytest.approx(repeated.standard_error, rel=1e-8)


def test_intervals_cover_with_clusters() -> None:
    """With a shift common to each cluster the 95 % interval still holds the slope in most samples."""
    generator, held = np.random.default_rng(2), 0
    for _ in range(150):
        group = np.repeat(np.arange(25), 30)
        x = generator.normal(size=group.size) + generator.normal(size=25)[group]
        linear = 0.8 * x + 0.5 * generator.normal(size=25)[group]
        y = generator.random(group.size) < 1 / (1 + np.exp(-linear))
        fit = logistic_fit(x[:, None], y.astype(float), group)
        held += fit.low[1] <= 0.8 * 0.94 <= fit.high[1]  # marginal slope: shrunk by about 1/√(1 + 0.35 · 0.25)
    assert held / 150 > 0.88


@pytest.mark.parametrize(
    ("outcome", "word"),
    [([0, 0, 0, 0], "nothing falls"), ([1, 1, 1, 1], "everything falls"), ([0, 0, 1, 1], "separate")],
)
def test_where_there_is_no_fit_it_is_said_why(outcome: list[int], word: str) -> None:
    fit = logistic_fit([[1.0], [2.0], [3.0], [4.0]], outcome, [0, 1, 2, 3])
    assert word in fit.note
    assert np.isnan(fit.coefficient).all()


@pytest.mark.parametrize("earthquakes", [1, 2, 7, 8])
def test_few_earthquakes_give_no_interval(earthquakes: int) -> None:
    """Fewer than eight give none anywhere."""
    fit = logistic_fit(np.array(TEMPERATURE)[:, None], DISTRESS, np.arange(23) % earthquakes)
    assert np.isfinite(fit.coefficient).all()
    assert np.isfinite([fit.low, fit.high]).all() == (earthquakes == 8)
    assert ("no interval: fewer than 8 earthquakes" in fit.note) == (earthquakes < 8)


def test_a_constant_predictor_has_no_coefficient() -> None:
    x = np.column_stack([TEMPERATURE, np.full(23, 0.6)])
    fit = logistic_fit(x, DISTRESS, np.arange(23))
    assert fit.coefficient[:2] == pytest.approx([15.0429, -0.2322], abs=1e-4)
    assert np.isnan(fit.coefficient[2])


@pytest.mark.parametrize(("x", "outcome"), [([[1.0]], [1, 0]), ([[1.0], [2.0]], [0, 2])])
def test_bad_shapes(x: list[list[float]], outcome: list[int]) -> None:
    with pytest.raises(ArgumentError):
        logistic_fit(x, outcome, range(len(outcome)))


def test_fit_of_a_cube(make_cube) -> None:
    """Blocks that fall above West's limit by a noisy margin: the slope on PGA over the limit comes back."""
    generator = np.random.default_rng(4)
    azimuth = np.arange(0, 360, 10.0)
    pga = np.exp(generator.uniform(0, 2.5, size=(12, 1)) + 0.1 * np.cos(np.radians(2 * azimuth)))
    pgv = pga * np.exp(generator.uniform(-3, -1.5, size=(12, 1)))
    cube = make_cube(lambda a, *_rest: np.zeros_like(a), azimuth=azimuth, events=[f"E{i}" for i in range(12)])
    limit = 9.80665 * cube["b_over_h"].values[None, None, None, :, None]
    linear = 3 * np.log(pga[:, :, None, None, None] / limit) + np.log(pgv / pga)[:, :, None, None, None] + 2
    fell = generator.random(cube["overturned"].shape) < 1 / (1 + np.exp(-linear))
    cube["overturned"] = cube["overturned"].copy(data=fell.astype(np.float32))
    intensity = xr.Dataset(
        {"pga": (("record", "azimuth"), pga), "pgv": (("record", "azimuth"), pgv)}, coords={"azimuth": azimuth}
    )
    predictors, outcome, event, weight = overturning_rows(cube.chunk({"record": 1}), intensity)
    assert predictors.shape == (12 * 18 * 2 * 5, 4)
    assert weight.mean() == pytest.approx(1)
    assert set(event) == set(range(12))
    assert outcome.mean() == pytest.approx(float(cube["overturned"].isel(azimuth=slice(18)).mean()), abs=1e-6)
    fit = overturning_fit(cube, intensity)
    assert (fit.rows, fit.clusters) == (2160, 12)
    assert fit.low[1] < 3 < fit.high[1]
    assert fit.low[2] < 1 < fit.high[2]
    table = describe(fit)
    assert [row[0] for row in table] == ["intercept", *PREDICTORS]
    assert table[4][4] == pytest.approx(np.log(0.6))
    with pytest.raises(ArgumentError, match="azimuths"):
        overturning_fit(cube, intensity.isel(azimuth=slice(5)))
