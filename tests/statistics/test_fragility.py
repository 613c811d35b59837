"""Fits recover the lognormal curves of synthetic shares; files follow the rules of OpenQuake."""

import configparser
import csv
import math
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import norm

from overturning.errors import ArgumentError
from overturning.statistics.fragility import (
    FittedFragilityCurve,
    fit_fragility_curve,
    fit_lognormal_median_and_log_std,
    variance_share_between_records,
)
from overturning.statistics.fragility_files import (
    openquake_file_name,
    write_fragility_csv,
    write_openquake_fragility_model,
)
from tests.statistics.conftest import fit_curve_to_lognormal_fall_rates

NRML_NAMESPACE = "{http://openquake.org/xmlns/nrml/0.5}"


def test_fit_recovers_a_known_lognormal_curve() -> None:
    x = np.geomspace(0.1, 2, 40)
    median, spread = fit_lognormal_median_and_log_std(x, norm.cdf(np.log(x / 0.6) / 0.4))
    assert (median, spread) == pytest.approx((0.6, 0.4), rel=1e-4)


def test_fit_recovers_the_curve_from_single_falls_and_stands() -> None:
    generator = np.random.default_rng(3)
    x = np.repeat(np.geomspace(0.1, 2, 30), 200)
    fell = generator.random(x.size) < norm.cdf(np.log(x / 0.6) / 0.4)
    median, spread = fit_lognormal_median_and_log_std(x, fell.astype(float))
    assert (median, spread) == pytest.approx((0.6, 0.4), rel=0.05)


def test_fragility_fit_converges_if_strong_records_overturn_nothing() -> None:
    """Rates of 64 stones under 28 records, for which full Newton steps oscillate; reference: SciPy's BFGS."""
    pga = [
        *(0.413, 0.432, 0.287, 0.426, 0.368, 0.504, 0.623, 0.728, 0.680, 0.640, 0.214, 0.722, 0.261, 0.422, 0.635),
        *(0.677, 0.265, 1.053, 0.385, 0.489, 0.498, 1.400, 0.752, 0.417, 0.289, 0.433, 0.898, 0.316),
    ]
    fell = [0, 0, 0, 5, 0, 7, 22, 1, 60, 36, 0, 5, 0, 9, 14, 17, 0, 0, 0, 1, 1, 9, 28, 4, 0, 8, 64, 0]
    x, share = np.log(pga), np.array(fell) / 64

    def negative_log_likelihood(coefficients: NDArray[np.float64]) -> float:
        z = coefficients[0] + coefficients[1] * x
        return -float(np.sum(share * norm.logcdf(z) + (1 - share) * norm.logsf(z)))

    constant, slope = minimize(negative_log_likelihood, [0.0, 1.0]).x
    assert fit_lognormal_median_and_log_std(pga, share) == pytest.approx(
        (math.exp(-constant / slope), 1 / slope), rel=1e-4
    )


@pytest.mark.parametrize("share", [[0, 0, 0], [1, 1, 1], [1, 0.5, 0], [0, 0, 1], [0, 0.5, 1]])
def test_no_curve_is_fitted_to_shares_that_determine_none(share: list[float]) -> None:
    assert math.isnan(fit_lognormal_median_and_log_std([1.0, 2.0, 4.0], share)[0])
    # Shares without weight, which alone would allow a curve, change nothing.
    more = fit_lognormal_median_and_log_std([1.0, 2.0, 4.0, 1.1, 3.9], [*share, 0.4, 0.6], [1, 1, 1, 0, 0])
    assert math.isnan(more[0])


def test_fall_shares_outside_0_to_1_are_refused() -> None:
    with pytest.raises(ArgumentError, match="0 to 1"):
        fit_lognormal_median_and_log_std([1.0, 2.0], [0.0, 1.2])


def test_interval_of_the_fragility_median_resamples_whole_earthquakes() -> None:
    """The interval of a median of fragility is that of bootstrap samples of whole earthquakes.

    Four earthquakes have a median of 0.5 and four of 1: the interval ends at the medians of samples that hold only
    one earthquake of either kind.

    A sample of eight has no earthquake of a kind with a probability of 0.4 %, and at most one with 3.5 % (binomial), so
    that the 2.5 % quantile is that of samples with one.
    """
    x, median = np.geomspace(0.1, 3, 15), np.repeat([0.5, 1.0], 4)
    share = norm.cdf(np.log(x / median[:, None]) / 0.3).ravel()
    ends = [fit_lognormal_median_and_log_std(np.tile(x, 8), share, np.repeat([8 - k, k], 60))[0] for k in (1, 7)]
    curve = fit_fragility_curve("all", ("PGA", "g"), np.tile(x, 8), share, np.repeat(list("abcdefgh"), 15))
    assert curve.median_interval == pytest.approx(ends, rel=1e-6)


def write_and_read_openquake_fragility_functions(
    curves: list[FittedFragilityCurve], folder: Path
) -> list[ElementTree.Element]:
    """Write fragility curves as an OpenQuake model and return its fragility functions as XML elements."""
    write_openquake_fragility_model(curves, folder / "f.xml", "gravestones")
    return ElementTree.parse(folder / "f.xml").getroot()[0].findall(f"{NRML_NAMESPACE}fragilityFunction")


def intensity_levels_and_fall_probabilities(function: ElementTree.Element) -> list[NDArray[np.float64]]:
    return [
        np.array(str(function.findtext(f"{NRML_NAMESPACE}{name}")).split(), dtype=float) for name in ("imls", "poes")
    ]


def test_median_above_all_intensities_is_written_as_infinite(tmp_path: Path) -> None:
    curve = fit_curve_to_lognormal_fall_rates(2, 0.5, "stout", largest_intensity=1)
    assert curve.median == pytest.approx(2, rel=1e-3)
    write_fragility_csv([curve], tmp_path / "f.csv")
    row = (tmp_path / "f.csv").read_text(encoding="utf-8").splitlines()[1]
    assert row == '"stout",PGA,g,inf,inf,inf,nan,0.1,1,nan,nan,stout'
    levels, chances = intensity_levels_and_fall_probabilities(
        *write_and_read_openquake_fragility_functions([curve], tmp_path)
    )
    assert levels[-1] == 1
    assert chances[-1] == pytest.approx(norm.cdf(-np.log(2) / 0.5), abs=1e-4)


def test_openquake_and_csv_files_hold_the_fitted_curve(tmp_path: Path) -> None:
    curve = fit_curve_to_lognormal_fall_rates(0.6, 0.4, "B/H < 0.4")
    assert curve.median_interval == pytest.approx((0.6, 0.6), rel=1e-3)  # all earthquakes alike
    levels, chances = intensity_levels_and_fall_probabilities(
        *write_and_read_openquake_fragility_functions([curve], tmp_path)
    )
    assert chances == pytest.approx(norm.cdf(np.log(levels / 0.6) / 0.4), abs=1e-4)
    assert (np.diff(levels) > 0).all()
    write_fragility_csv([curve], tmp_path / "f.csv")
    assert (tmp_path / "f.csv").read_text(encoding="utf-8").splitlines()[1].startswith('"B/H < 0.4",PGA,g,0.6,')
    with pytest.raises(ArgumentError, match="PGA or"):
        write_openquake_fragility_model([], tmp_path / "g.xml", "none")


@pytest.mark.parametrize(("between", "within"), [(0.5, 0.3), (0.15, 0.45), (0.0, 0.4)])
def test_variance_between_records_is_separated_from_that_between_stones(between: float, within: float) -> None:
    """60 records have medians at the quantiles of a lognormal distribution, and 200 stones have random capacities.

    The medians are not drawn: the standard error of a spread of 60 random values would be 9 %.
    """
    generator = np.random.default_rng(5)
    x = np.tile(np.geomspace(0.2, 2, 6), (60, 1)) * np.exp(generator.normal(0, 0.2, (60, 1)))
    own = math.log(0.6) + between * norm.ppf((np.arange(60) + 0.5) / 60)[:, None]
    share = generator.binomial(200, norm.cdf((np.log(x) - own) / within)) / 200
    record = np.repeat(np.arange(60), 6)
    median, spread = fit_lognormal_median_and_log_std(x.ravel(), share.ravel())
    assert spread == pytest.approx(math.hypot(between, within), rel=0.06)
    found = variance_share_between_records((median, spread), x.ravel(), share.ravel(), record, 200)
    assert found == pytest.approx((between / math.hypot(between, within)) ** 2, abs=0.06)


def test_equal_outcomes_of_all_stones_count_as_record_to_record_variance() -> None:
    x = np.geomspace(0.2, 2, 40)
    share = (norm.ppf((np.random.default_rng(2).permutation(40) + 0.5) / 40) < np.log(x / 0.6) / 0.5).astype(float)
    fit = fit_lognormal_median_and_log_std(x, share)
    assert variance_share_between_records(fit, x, share, np.arange(40), 100) > 0.9


def test_names_of_stone_classes_and_intensities_are_valid_for_openquake(tmp_path: Path) -> None:
    """Ids of fragility functions have 1 to 60 characters of a-zA-Z0-9_-, as OpenQuake requires.

    OpenQuake's rule is `openquake.hazardlib.valid.simple_id`.
    """
    names = ("B/H up to 0.45, H up to 0.75 m", "B/H above 0.45, H up to 0.75 m", "all stones")
    curves = [fit_curve_to_lognormal_fall_rates(0.6, 0.4, name, ("SA(0.5)", "g")) for name in names]
    assert openquake_file_name("SA(0.5)") == "fragility-sa-0.5.xml"
    functions = write_and_read_openquake_fragility_functions(curves, tmp_path)
    taken = [str(one.get("id")) for one in functions]
    assert len(set(taken)) == 3
    assert all(re.fullmatch(r"[a-zA-Z0-9_\-]{1,60}", one) for one in taken)
    write_fragility_csv(curves, tmp_path / "f.csv")
    assert all(one in (tmp_path / "f.csv").read_text(encoding="utf-8") for one in taken)
    assert {one.get("imt") for function in functions for one in function.iter(f"{NRML_NAMESPACE}imls")} == {"SA(0.5)"}


OPENQUAKE_EXAMPLE_FOLDER = Path(__file__).parents[2] / "surveys" / "openquake"


def test_shipped_openquake_example_is_consistent_and_valid(tmp_path: Path) -> None:
    """The shipped OpenQuake example follows the rules of NRML 0.5 and of OpenQuake's readers.

    The rules are those for file names, columns, cost types, sites and ids.
    """
    job = configparser.ConfigParser()
    job.read(OPENQUAKE_EXAMPLE_FOLDER / "job.ini", encoding="utf-8")
    files = {key: value for part in job.values() for key, value in part.items() if key.endswith(("_file", "_csv"))}
    assert files.pop("contents_fragility_file") == openquake_file_name("PGA")
    assert all((OPENQUAKE_EXAMPLE_FOLDER / name).is_file() for name in files.values())
    model = ElementTree.parse(OPENQUAKE_EXAMPLE_FOLDER / files["exposure_file"]).getroot()[0]
    assert model.tag == f"{NRML_NAMESPACE}exposureModel"
    assert [one.get("name") for one in model.iter(f"{NRML_NAMESPACE}costType")] == ["contents"]
    assets = read_csv_rows(OPENQUAKE_EXAMPLE_FOLDER / str(model.findtext(f"{NRML_NAMESPACE}assets")))
    sites = read_csv_rows(OPENQUAKE_EXAMPLE_FOLDER / files["sites_csv"])
    fields = read_csv_rows(OPENQUAKE_EXAMPLE_FOLDER / files["gmfs_file"])
    assert [(one["lon"], one["lat"]) for one in assets] == [(one["lon"], one["lat"]) for one in sites]
    assert {one["site_id"] for one in fields} == {one["site_id"] for one in sites}
    assert all(float(one["number"]) > 0 and float(one["contents"]) > 0 for one in assets)
    assert all(float(one["gmv_PGA"]) > 0 for one in fields)

    (function,) = write_and_read_openquake_fragility_functions([fit_curve_to_lognormal_fall_rates(0.6, 0.4)], tmp_path)
    root = ElementTree.parse(tmp_path / "f.xml").getroot()
    (fragilities,) = root
    assert (root.tag, fragilities.tag) == (f"{NRML_NAMESPACE}nrml", f"{NRML_NAMESPACE}fragilityModel")
    assert fragilities.get("lossCategory") == model.get("category") == "contents"
    assert {one["taxonomy"] for one in assets} == {function.get("id")}
    imls, poes = function
    states = str(fragilities.findtext(f"{NRML_NAMESPACE}limitStates")).split()
    assert (function.get("format"), [poes.get("ls")]) == ("discrete", states)
    levels, chances = intensity_levels_and_fall_probabilities(function)
    assert levels.size == chances.size
    assert float(str(imls.get("noDamageLimit"))) <= levels[0]
    assert (np.diff(levels) > 0).all()
    assert (np.diff(chances) >= 0).all()
    assert 0 <= chances[0] <= chances[-1] <= 1


def read_csv_rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as table:
        return list(csv.DictReader(table))
