"""What has stood, against closed forms and quadrature."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from overturning.cli import main
from overturning.statistics.fragility import fragility
from overturning.statistics.fragility_files import write_fragility_csv
from overturning.surveys.standing import CurveRow, Hazard, rate_bound, read_curves, standing


def power_law(k0: float, k: float, low: float, high: float, count: int = 2) -> Hazard:
    level = np.geomspace(low, high, count)
    return Hazard("PGA", "g", level, k0 * level**-k)


def curve(median: float, spread: float, **more: float) -> CurveRow:
    return CurveRow(stones="all stones", measure="PGA", unit="g", median=median, log_spread=spread, **more)


@pytest.mark.parametrize(("k", "median", "spread"), [(2.0, 0.6, 0.4), (3.5, 1.2, 0.7), (1.0, 0.2, 0.05)])
@pytest.mark.parametrize("count", [2, 40])
def test_a_lognormal_fragility_under_a_power_law(k: float, median: float, spread: float, count: int) -> None:
    """λ = k0 m^−k exp(k²β²/2) (Cornell et al. 2002)."""
    hazard = power_law(1e-4, k, 1e-4, 1e4, count)
    found = standing(curve(median, spread), hazard, 500.0)
    rate = 1e-4 * median**-k * math.exp(0.5 * (k * spread) ** 2)
    assert found.rate == pytest.approx(rate, rel=1e-9)
    assert found.stands == pytest.approx(math.exp(-500 * rate), rel=1e-9)


def test_any_hazard_by_quadrature_and_what_lies_beyond_the_records() -> None:
    level, rate = np.array([0.05, 0.2, 0.5, 1.0]), np.array([2e-2, 2e-3, 3e-4, 2e-5])
    hazard = Hazard("PGA", "g", level, rate)

    def density(x: float, a: float, one: float, k: float) -> float:
        return float(norm.cdf(np.log(x / 0.6) / 0.4) * k * one * a**k * x ** (-k - 1))

    def falls(low: float, high: float) -> float:
        """∫ P |dν| with ν straight in logarithms, by SciPy."""
        total = 0.0
        for a, b, one, two in zip(level[:-1], level[1:], rate[:-1], rate[1:], strict=True):
            k = math.log(one / two) / math.log(b / a)
            ends = max(a, low), min(b, high)
            if ends[0] < ends[1]:
                total += quad(density, *ends, args=(a, one, k), epsrel=1e-11)[0]
        return total

    top = norm.cdf(math.log(1 / 0.6) / 0.4) * rate[-1]
    found = standing(curve(0.6, 0.4, median_low=0.6, median_high=math.inf, least=0.3, most=0.8), hazard, 1000.0)
    assert found.rate == pytest.approx(falls(0, 9) + top, rel=1e-8)
    assert found.beyond == pytest.approx(1 - falls(0.3, 0.8) / (falls(0, 9) + top), rel=1e-7)
    assert (found.low, found.high) == pytest.approx((math.exp(-1000 * (falls(0, 9) + rate[-1])), 1.0), rel=1e-8)
    without = standing(curve(0.6, 0.4), hazard, 1000.0)
    assert without.stands == found.stands
    assert math.isnan(without.low)
    assert math.isnan(without.high)


def test_stones_that_keep_what_sets_them_apart_stand_longer() -> None:
    """Without a spread of records stone s falls as often as ln s is exceeded: E exp(−k0 s^−k T), by SciPy."""
    hazard = power_law(1e-3, 2.0, 1e-4, 1e4)
    found = standing(curve(0.6, 0.5, record_spread=0.0, other_spread=0.5), hazard, 300.0)
    share, _ = quad(lambda v: norm.pdf(v) * math.exp(-0.3 * (0.6 * math.exp(0.5 * v)) ** -2), -8, 8)
    assert found.share == pytest.approx(share, rel=1e-3)
    assert found.share > found.stands
    alike = standing(curve(0.6, 0.5, record_spread=0.5, other_spread=0.0), hazard, 300.0)
    assert alike.share == pytest.approx(alike.stands)


def test_a_rate_after_years_without_a_fall() -> None:
    """The posterior T exp(−λT) holds 95 % below 3.00/T: the rule of three."""
    assert rate_bound(1000.0) == pytest.approx(2.9957e-3, rel=1e-4)
    assert quad(lambda rate: 50 * math.exp(-50 * rate), 0, rate_bound(50.0))[0] == pytest.approx(0.95)


@pytest.fixture
def tables(tmp_path: Path) -> tuple[Path, Path]:
    x = np.tile(np.geomspace(0.1, 2, 20), 4)
    share, event = norm.cdf(np.log(x / 0.6) / 0.4), np.repeat(list("abcdefgh"), 10)
    made = [fragility("B/H up to 0.4, H up to 0.6 m", ("PGA", "g"), x, share, event)]
    made.append(fragility("stout", ("PGA", "g"), x, norm.cdf(np.log(x / 9) / 0.8), event))
    made.append(fragility("stout", ("PGV/PGA", "s"), x, np.full(x.size, 0.5), event))  # no curve fits
    write_fragility_csv(made, tmp_path / "fragility.csv")
    (tmp_path / "hazard.csv").write_text(
        "measure,unit,level,annual_rate\nPGA,g,0.01,1\nPGA,g,10,1e-6\n", encoding="utf-8"
    )
    return tmp_path / "fragility.csv", tmp_path / "hazard.csv"


def test_the_command_reads_what_a_run_writes(tables: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    known, *_ = read_curves(tables[0])
    assert known.median == pytest.approx(0.6, rel=1e-3)
    survey = tables[0].with_name("survey.csv")
    survey.write_text("fell,octant,count\nno,,4\n", encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["stood", *map(str, tables), "--years", "1000", "--stones", str(survey)])
    text = capsys.readouterr().out
    rate = 1e-4 * 0.6**-2 * math.exp(2 * 0.4**2)
    assert f"{rate:.3g}" in text
    assert f"{rate_bound(1000) / rate:.2g}" in text  # the hazard may be so many times as large, and no more
    assert "stout, PGA: the median lies beyond the records" in text
    assert "4 stones stood 1000 years: their rate of falls lies below 0.003 a year" in text
    survey.write_text("fell,octant,count\nno,,4\nyes,N,1\n", encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["stood", *map(str, tables), "--years", "1000", "--stones", str(survey)])
    assert "4 of 5 stones stand" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("PGA,g,0.1,1\nPGA,g,0.1,0.5\n", "ascending levels"),
        ("PGA,g,0.1,1\nPGA,g,0.2,2\n", "rates that do not grow"),
        ("PGA,g,0.1,1\nPGA,g,0.2,0\n", "line 3: column annual_rate '0'"),
        ("PGA,g,0.1,1\n", "PGA has one level"),
        ("PGA,cm/s2,10,1\nPGA,cm/s2,20,0.1\n", "convert it"),
        ("PGV,cm/s,10,1\nPGV,cm/s,20,0.1\n", "give one of these"),
        ("", "no level"),
    ],
)
def test_a_wrong_hazard_is_told(
    tables: tuple[Path, Path], rows: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    tables[1].write_text("measure,unit,level,annual_rate\n" + rows, encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["stood", *map(str, tables), "--years", "100"])
    assert said in capsys.readouterr().err
