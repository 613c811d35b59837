"""Survival of stones, compared with closed forms and quadrature."""

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import binomtest, norm

from overturning.cli import main
from overturning.statistics.fragility_files import write_fragility_csv
from overturning.surveys.hazard import (
    FragilityCurveParametersRow,
    HazardCurve,
    read_fragility_curves,
    read_hazard_curves_by_intensity_measure,
)
from overturning.surveys.standing import estimate_standing_probability, upper_bound_of_annual_fall_rate
from tests.statistics.conftest import fit_curve_to_lognormal_fall_rates


def power_law_hazard(k0: float, k: float, low: float, high: float, count: int = 2) -> HazardCurve:
    """Return a hazard curve with annual rates k0 x^−k at levels from ``low`` to ``high``, g."""
    level = np.geomspace(low, high, count)
    return HazardCurve("PGA", "g", level, k0 * level**-k)


def fragility_curve_row(median: float, spread: float, **more: float) -> FragilityCurveParametersRow:
    return FragilityCurveParametersRow(
        stones="all stones", measure="PGA", unit="g", median=median, log_spread=spread, **more
    )


@pytest.mark.parametrize(("k", "median", "spread"), [(2.0, 0.6, 0.4), (3.5, 1.2, 0.7), (1.0, 0.2, 0.05)])
@pytest.mark.parametrize("count", [2, 40])
def test_fall_rate_under_a_power_law_hazard_matches_the_closed_form(
    k: float, median: float, spread: float, count: int
) -> None:
    """The rate is k0 m^−k exp(k²β²/2), with median m and log spread β of the fragility (Cornell et al. 2002)."""
    hazard = power_law_hazard(1e-4, k, 1e-4, 1e4, count)
    found = estimate_standing_probability(fragility_curve_row(median, spread), hazard, 500.0)
    rate = 1e-4 * median**-k * math.exp(0.5 * (k * spread) ** 2)
    assert found.annual_fall_rate_per_stone == pytest.approx(rate, rel=1e-9)
    assert found.standing_probability == pytest.approx(math.exp(-500 * rate), rel=1e-9)


def test_fall_rate_under_any_hazard_matches_quadrature() -> None:
    level, rate = np.array([0.05, 0.2, 0.5, 1.0]), np.array([2e-2, 2e-3, 3e-4, 2e-5])
    hazard = HazardCurve("PGA", "g", level, rate)

    def annual_fall_rate_per_unit_level(x: float, a: float, one: float, k: float) -> float:
        return float(norm.cdf(np.log(x / 0.6) / 0.4) * k * one * a**k * x ** (-k - 1))

    def annual_fall_rate_from_hazard_curve_by_quadrature(low: float, high: float) -> float:
        """Return the annual rate of falls at levels from `low` to `high`, g: ∫ P |dν|, integrated by SciPy.

        P is the fall probability and ν the hazard curve; ln ν is linear in ln level between the levels of the curve.
        """
        total = 0.0
        for a, b, one, two in zip(level[:-1], level[1:], rate[:-1], rate[1:], strict=True):
            k = math.log(one / two) / math.log(b / a)
            ends = max(a, low), min(b, high)
            if ends[0] < ends[1]:
                total += quad(annual_fall_rate_per_unit_level, *ends, args=(a, one, k), epsrel=1e-11)[0]
        return total

    top = norm.cdf(math.log(1 / 0.6) / 0.4) * rate[-1]
    found = estimate_standing_probability(
        fragility_curve_row(0.6, 0.4, median_low=0.6, median_high=math.inf, least=0.3, most=0.8), hazard, 1000.0
    )
    assert found.annual_fall_rate_per_stone == pytest.approx(
        annual_fall_rate_from_hazard_curve_by_quadrature(0, 9) + top, rel=1e-8
    )
    assert found.fall_rate_share_outside_fragility_data == pytest.approx(
        1
        - annual_fall_rate_from_hazard_curve_by_quadrature(0.3, 0.8)
        / (annual_fall_rate_from_hazard_curve_by_quadrature(0, 9) + top),
        rel=1e-7,
    )
    assert (found.standing_probability_low, found.standing_probability_high) == pytest.approx(
        (math.exp(-1000 * (annual_fall_rate_from_hazard_curve_by_quadrature(0, 9) + rate[-1])), 1.0), rel=1e-8
    )
    inside = estimate_standing_probability(fragility_curve_row(0.6, 0.4, least=0.01, most=4.0), hazard, 1000.0)
    assert inside.fall_rate_share_outside_fragility_data == pytest.approx(0.0, abs=1e-12), (
        "the last level's falls were beyond records that reach it"
    )
    without = estimate_standing_probability(fragility_curve_row(0.6, 0.4), hazard, 1000.0)
    assert without.standing_probability == found.standing_probability
    assert math.isnan(without.standing_probability_low)
    assert math.isnan(without.standing_probability_high)


def test_stones_of_differing_strength_survive_longer_than_equal_ones() -> None:
    """If records add no spread, each stone falls at its own level s; SciPy averages the survival over all stones.

    In T years, a stone survives with the probability exp(−k0 s^−k T), where the hazard curve is k0 s^−k a year.
    """
    hazard = power_law_hazard(1e-3, 2.0, 1e-4, 1e4)
    found = estimate_standing_probability(
        fragility_curve_row(0.6, 0.5, record_spread=0.0, other_spread=0.5), hazard, 300.0
    )
    share, _ = quad(lambda v: norm.pdf(v) * math.exp(-0.3 * (0.6 * math.exp(0.5 * v)) ** -2), -8, 8)
    assert found.standing_share_if_each_stone_keeps_its_deviation == pytest.approx(share, rel=1e-3)
    assert found.standing_share_if_each_stone_keeps_its_deviation > found.standing_probability
    alike = estimate_standing_probability(
        fragility_curve_row(0.6, 0.5, record_spread=0.5, other_spread=0.0), hazard, 300.0
    )
    assert alike.standing_share_if_each_stone_keeps_its_deviation == pytest.approx(alike.standing_probability)


def test_upper_bound_of_a_rate_without_falls_is_the_rule_of_three() -> None:
    """The posterior density T exp(−λT) of the rate λ after T years has 95 % below 3.00/T: the rule of three."""
    assert upper_bound_of_annual_fall_rate(1000.0) == pytest.approx(2.9957e-3, rel=1e-4)
    assert quad(lambda rate: 50 * math.exp(-50 * rate), 0, upper_bound_of_annual_fall_rate(50.0))[0] == pytest.approx(
        0.95
    )


@pytest.fixture
def fragility_and_hazard_files(tmp_path: Path) -> tuple[Path, Path]:
    """Write fragility curves of two classes and a hazard curve, and return their files."""
    made = [
        fit_curve_to_lognormal_fall_rates(0.6, 0.4, "B/H up to 0.4, H up to 0.6 m"),
        fit_curve_to_lognormal_fall_rates(9, 0.8, "stout"),
    ]
    made.append(
        fit_curve_to_lognormal_fall_rates(1.0, math.inf, "stout", ("PGV/PGA", "s"))
    )  # half fall everywhere: no curve fits
    write_fragility_csv(made, tmp_path / "fragility.csv")
    (tmp_path / "hazard.csv").write_text(
        "measure,unit,level,annual_rate\nPGA,g,0.01,1\nPGA,g,10,1e-6\n", encoding="utf-8"
    )
    return tmp_path / "fragility.csv", tmp_path / "hazard.csv"


@pytest.fixture
def run_stood_command(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Return a function that runs `overturning stood` with curves, hazard and years, and returns its output."""

    def run_command(*files: Path, years: float, stones: Path | None = None) -> str:
        with pytest.raises(SystemExit):
            main(["stood", *map(str, files), "--years", f"{years:g}", *(["--stones", str(stones)] if stones else [])])
        return "".join(capsys.readouterr())

    return run_command


def test_stood_command_reads_the_files_that_a_run_writes(
    fragility_and_hazard_files: tuple[Path, Path], run_stood_command: Callable[..., str]
) -> None:
    known, *_ = read_fragility_curves(fragility_and_hazard_files[0])
    assert known.median == pytest.approx(0.6, rel=1e-3)
    survey = fragility_and_hazard_files[0].with_name("survey.csv")
    survey.write_text("fell,octant,count\nno,,4\n", encoding="utf-8")
    text = run_stood_command(*fragility_and_hazard_files, years=1000, stones=survey)
    rate = 1e-4 * 0.6**-2 * math.exp(2 * 0.4**2)
    assert f"{rate:.3g}" in text
    assert f"{100 * math.exp(-1000 * rate):.0f}\u00a0%" in text
    assert (
        f"{upper_bound_of_annual_fall_rate(1000) / rate:.2g}" in text
    )  # the hazard may be so many times as large, and no more
    assert "stout, PGA: the median lies beyond the records" in text
    assert "4 stones stood 1000 years: the rate of falls lies below 0.003 a year" in text
    assert "in the row of their class alone" in text, "stones of any size had bounded the hazard for each class"
    survey.write_text("fell,octant,count\nno,,4\nyes,N,1\n", encoding="utf-8")
    # The interval that `overturning survey` prints for the same stones.
    exact = binomtest(4, 5).proportion_ci(method="exact")
    interval = f"80\u00a0% ({100 * exact.low:.0f}\u00a0% to {100 * exact.high:.0f}\u00a0%)"
    assert f"4 of 5 stones stand, {interval}" in run_stood_command(
        *fragility_and_hazard_files, years=1000, stones=survey
    )
    row = next(line for line in run_stood_command(*fragility_and_hazard_files, years=1).splitlines() if "B/H" in line)
    assert f"{100 * math.exp(-rate):.2f}\u00a0%" in row, "which stood as 1.00"


def test_stood_command_gives_no_result_if_no_curve_fits_the_falls(
    fragility_and_hazard_files: tuple[Path, Path], run_stood_command: Callable[..., str]
) -> None:
    fragility_and_hazard_files[1].write_text(
        "measure,unit,level,annual_rate\nPGV/PGA,s,0.01,1\nPGV/PGA,s,1,0.1\n", encoding="utf-8"
    )
    assert (
        run_stood_command(*fragility_and_hazard_files, years=1000)
        == "stout, PGV/PGA: no curve fits the falls; no result\n"
    )


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
def test_stood_command_refuses_an_invalid_hazard(
    fragility_and_hazard_files: tuple[Path, Path], rows: str, said: str, run_stood_command: Callable[..., str]
) -> None:
    fragility_and_hazard_files[1].write_text("measure,unit,level,annual_rate\n" + rows, encoding="utf-8")
    assert said in run_stood_command(*fragility_and_hazard_files, years=100)


@pytest.mark.parametrize(
    ("measure", "true_unit", "factor", "cause"),
    [
        (("PGA", "g"), 0.6, 981.0, "are they in Gal? Divide them by 981"),
        (("PGV", "cm/s"), 60.0, 0.01, "are they in m/s?"),
    ],
)
def test_a_hazard_whose_unit_is_wrong_is_refused(
    tmp_path: Path,
    run_stood_command: Callable[..., str],
    measure: tuple[str, str],
    true_unit: float,
    factor: float,
    cause: str,
) -> None:
    """A hazard curve is accepted in the unit of its label and refused if its levels are in another unit.

    In another unit, falls would come from levels beyond the records.
    """
    files = tmp_path / "fragility.csv", tmp_path / "hazard.csv"
    files[0].write_text(
        "stones,measure,unit,median,log_spread,least,most\n"
        f"all,{','.join(measure)},{true_unit},0.4,{true_unit / 6},{true_unit * 3}\n",
        "utf-8",
    )

    def stood_output_for_scaled_hazard(scale: float) -> str:
        levels = scale * true_unit * np.geomspace(0.02, 5, 30)
        rows = "".join(
            f"{','.join(measure)},{level},{1e-4 * (level / scale / true_unit) ** -2.5}\n" for level in levels
        )
        files[1].write_text(f"measure,unit,level,annual_rate\n{rows}", "utf-8")
        return run_stood_command(*files, years=800)

    right, wrong = stood_output_for_scaled_hazard(1.0), stood_output_for_scaled_hazard(factor)
    assert "are they in" not in right
    assert "P(stands 800 years)" in right
    assert wrong.startswith(f"error: {files[1]}: {measure[0]}: levels of ")
    assert cause in wrong
    assert "come from levels beyond the records" in wrong
    assert "P(stands" not in wrong


@pytest.mark.parametrize(("top", "refused"), [(2.0, True), (8.0, True), (9.9, True), (30.0, False)])
def test_hazard_in_m_s_labelled_cm_s_is_refused_up_to_10_m_s(
    tmp_path: Path, run_stood_command: Callable[..., str], top: float, refused: bool
) -> None:
    """Regression: levels up to 8 m/s labelled cm/s were accepted, though all records are stronger than 8 cm/s."""
    files = tmp_path / "fragility.csv", tmp_path / "hazard.csv"
    files[0].write_text(
        "stones,measure,unit,median,log_spread,least,most\nall,PGV,cm/s,60,0.4,20,180\n", encoding="utf-8"
    )
    rows = "".join(f"PGV,cm/s,{level},{1e-4 * (level / 0.6) ** -2.5}\n" for level in np.geomspace(0.01, top, 30))
    files[1].write_text(f"measure,unit,level,annual_rate\n{rows}", encoding="utf-8")
    text = run_stood_command(*files, years=800)
    assert text.startswith(f"error: {files[1]}: PGV: levels of ") == refused
    assert ("are they in m/s?" in text) == refused
    assert ("come from levels beyond the records" in text) == refused


def write_survey_and_return_fragility_and_hazard_files(folder: Path, lowest_level_g: float) -> tuple[Path, Path]:
    """Write a fragility curve, a hazard curve and a survey of one standing stone; return the paths of the two curves.

    The log spreads are 0.5 (stones) and 0.3 (records), and the hazard is 1e-4 x^−2.5 a year up to 10 g.
    """
    fields = "median", "log_spread", "record_spread", "other_spread"
    values = 0.6, math.hypot(0.3, 0.5), 0.3, 0.5
    curves, hazard, survey = (folder / f"{name}.csv" for name in ("fragility", "hazard", "survey"))
    curves.write_text(f"stones,measure,unit,{','.join(fields)}\nall,PGA,g,{','.join(map(str, values))}\n", "utf-8")
    rows = "".join(f"PGA,g,{level},{1e-4 * level**-2.5}\n" for level in np.geomspace(lowest_level_g, 10, 30))
    hazard.write_text(f"measure,unit,level,annual_rate\n{rows}", "utf-8")
    survey.write_text("fell,octant,count\nno,,1\n", "utf-8")
    return curves, hazard


def test_largest_hazard_compatible_with_survivors_lets_5_percent_stand(
    tmp_path: Path, run_stood_command: Callable[..., str]
) -> None:
    """The largest reported hazard leaves 5 % of stones standing, as counted with random earthquakes.

    Stones of random strength and earthquakes are drawn one by one: the survivors are the stronger stones.
    """
    text = run_stood_command(
        *write_survey_and_return_fragility_and_hazard_files(tmp_path, 0.01), years=800, stones=tmp_path / "survey.csv"
    )
    row = next(line for line in text.splitlines() if line.startswith("  all "))
    factor, generator = float(row.split()[-1]), np.random.default_rng(5)
    assert factor > 5 * 3.0 / (800 * float(row.split()[2]))
    stands, weakest = 0, 0.05  # g; of the falls 0.3 % come from weaker shaking
    for capacity in 0.6 * np.exp(0.5 * generator.normal(size=4000)):
        earthquakes = generator.poisson(800 * factor * 1e-4 * weakest**-2.5)
        shaking = weakest * generator.random(earthquakes) ** (-1 / 2.5)
        stands += bool((np.log(shaking / capacity) + 0.3 * generator.normal(size=earthquakes) < 0).all())
    assert stands / 4000 == pytest.approx(0.05, abs=0.012)


def test_fall_rate_below_the_first_hazard_level_is_reported(
    tmp_path: Path, run_stood_command: Callable[..., str]
) -> None:
    """The reported rate of falls below the first level equals the gain in rate with a curve that begins lower.

    At the first level of the higher curve, 1 % of stones fall.
    """
    spread, rates = math.hypot(0.3, 0.5), []
    for first in (0.155, 0.0155, 0.005):
        files = write_survey_and_return_fragility_and_hazard_files(tmp_path, first)
        text = run_stood_command(*files, years=800)
        rates.append(
            (
                estimate_standing_probability(
                    fragility_curve_row(0.6, spread), read_hazard_curves_by_intensity_measure(files[1])["PGA"], 800.0
                ).annual_fall_rate_per_stone,
                text,
            )
        )
    (high, said), (low, quiet), _ = rates
    assert low - high > 0.08 * low
    (added,) = re.findall(r"it would add (\S+) falls a year", said)
    assert float(added) == pytest.approx(low - high, rel=0.05)
    assert "it would add" not in quiet
