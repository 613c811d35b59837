"""Sections on cemeteries and soft ground for known fall rates."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

from overturning.motion.jma_intensity import SURVEY_RULE
from overturning.motion.soil import Layer, Rock
from overturning.records.site import Site
from overturning.report.results import Results
from overturning.report.sections.ground import ground
from overturning.report.sections.population import population
from overturning.settings import Population
from overturning.study.sections import Variant
from overturning.surveys.population import population_rates, record_jma_intensities
from overturning.units import STANDARD_GRAVITY
from tests.report.reading import of_study, tables, text_of

Make = Callable[..., Results]


@pytest.fixture
def cemetery(one_record: Make) -> Results:
    results, stones = one_record(3), Population(stones=64)
    rates = population_rates(results.cube, stones)
    return replace(of_study(results, population=stones), populations={"nominal": rates})


def under(cemetery: Results, rates: xr.Dataset) -> Results:
    """The cemetery with other rates, under as many copies of its first record."""
    first = [0] * rates.sizes["record"]
    cube, intensity = (one.isel(record=first) for one in (cemetery.cube, cemetery.intensity))
    return replace(cemetery, cube=cube, intensity=intensity, populations={"nominal": rates})


def eight_earthquakes(cemetery: Results) -> xr.Dataset:
    """Rates of the first record eight times, each of an earthquake of its own."""
    rates = cemetery.populations["nominal"].isel(record=[0] * 8)
    return rates.assign_coords(event=("record", list("abcdefgh")))


def said(section: Any) -> str:
    return text_of(section).replace("\u00a0", " ")


def test_rates_with_intervals_by_record_and_no_turn_from_planes(cemetery: Results) -> None:
    shown = population(cemetery)
    (table,) = [table for table in tables(shown) if table.heads[0] == "record"]
    assert table.heads[1:3] == ("fell, % (95 %)", "most fell towards ± 22.5°")
    rate = float(cemetery.populations["nominal"]["fall_rate"][0, 0])
    assert table.rows[0][1].replace("\u00a0", " ").startswith(f"{100 * rate:.0f} % (")
    assert "no plane can tell" in said(shown)
    assert "% of the stones stand shifted" not in said(shown)
    # Nor where a record fells them all, of which none was left to stand: 0 % was said to be shifted under all records.
    cube = cemetery.cube.copy()
    cube["overturned"] = xr.where(cube["record_id"] == cube["record_id"][0], 1.0, cube["overturned"]).transpose(
        *cube["overturned"].dims
    )
    found = population_rates(cube, cemetery.study.population or Population())
    assert float(found["fall_rate"][0, 0]) == 1.0
    assert "stand shifted" not in said(population(replace(cemetery, cube=cube, populations={"nominal": found})))


def test_missing_planes_are_noted_with_the_rates(cemetery: Results) -> None:
    assert "No plane" not in said(population(cemetery))
    part = replace(cemetery, cube=cemetery.cube.isel(azimuth=slice(0, 6)))
    told = "No plane between 75° and 180° was computed: a face that looks there falls as in the nearest plane."
    assert told in said(population(part))


def test_stones_without_an_answer_are_counted(cemetery: Results) -> None:
    assert "Rates are of the stones with an answer" not in said(population(cemetery))
    found = cemetery.populations["nominal"].copy(deep=True)
    found["unknown"][0] = 0.3
    told = "Rates are of the stones with an answer: 10 % of them have none in the mean, 30 % under one record."
    assert told in said(population(replace(cemetery, populations={"nominal": found})))


def test_stones_beyond_the_grid_are_warned_of(cemetery: Results) -> None:
    """All of them are taller than the study's one height."""
    assert "100 % of the stones are larger or smaller" in said(population(cemetery))
    found = cemetery.populations["nominal"].assign_attrs(outside=0.1)
    inside = said(population(replace(cemetery, populations={"nominal": found})))
    assert "larger or smaller" not in inside
    assert "10 % of them lie beyond the study's grid" in inside


def test_the_rule_of_field_surveys_beside_the_instrumental_intensity(cemetery: Results) -> None:
    """Three motions of intensity 6.2 with a rate of 0.5 keep the rule, three of 5.2 with 0.95 do not."""
    one = cemetery.populations["nominal"]
    many = xr.concat([one, one], dim="record")
    many["fall_rate"][:] = np.repeat([0.5, 0.95], 3)[:, None]
    results = under(cemetery, many)
    results.intensity["jma_intensity"] = ("record", np.repeat([6.2, 5.2], 3))
    assert record_jma_intensities(many.assign_coords(amplitude=[10.0]), results.intensity)[0] == pytest.approx(8.2)
    text = said(population(results))
    assert "where 40 to 90 % fall, which they take for 6 upper, the instrumental intensity is 6.2" in text
    # Exact bounds of 3 of 3 earthquakes and of 0 of 3: 0.05^(1/3) = 0.37, and 1 less that.
    assert "in 100 % (37 to 100) of 3 motions, 3 records of 3 earthquakes, higher in 0 % (0 to 63);" in text
    assert "where 90 % or more fall, which they take for 7, the instrumental intensity is 5.2" in text
    assert SURVEY_RULE[0][:2] == (0.4, 0.9)


def test_the_share_of_motions_that_keep_the_rule_counts_earthquakes_and_the_missing_vertical(cemetery: Results) -> None:
    """Eight earthquakes of one motion with a rate of 0.5: three of intensity 6.2, three of 6.46 and two of 6.55.

    JMA publishes 6.46, the median, as 6.4.

    Six of eight are of the degree; of the samples 0.4 % hold at most two of them, 2.7 % at most three (binomial, 6/8),
    so the 0.57 % quantile of the expanded percentile is three. With 0.1 for the vertical component three are.
    """
    one = eight_earthquakes(cemetery)
    one["fall_rate"][:] = 0.5
    results = under(cemetery, one)
    results.intensity["jma_intensity"] = ("record", np.full(8, np.nan))
    results.intensity["jma_intensity_horizontal"] = ("record", np.repeat([6.2, 6.46, 6.55], [3, 3, 2]))
    text = said(population(results))
    assert "is of that degree in 75 % (38 to 100) of 8 motions, 8 records of 8 earthquakes, higher in 25 %" in text
    assert "with 0.1 for the vertical component of that degree in 38 %" in text
    assert "the instrumental intensity is 6.4 in the median" in text
    # With three components nothing is added.
    results.intensity["jma_intensity"] = results.intensity["jma_intensity_horizontal"]
    text = said(population(results))
    assert "75 % (38 to 100) of 8 motions" in text
    assert "vertical component" not in text


def test_a_median_beyond_the_data_is_no_number(cemetery: Results) -> None:
    """Rates of Φ(ln(x/2)/0.5) for PGA of 0.2 to 1.4 g: half of the stones fall above that, not at 2 g."""
    pga = np.geomspace(0.2, 1.4, 8)
    one = eight_earthquakes(cemetery)
    one["fall_rate"][:] = norm.cdf(np.log(pga / 2) / 0.5)[:, None]
    one["class_rate"][:] = norm.cdf(np.log(pga / 0.8) / 0.5)[:, None, None]
    results = under(cemetery, one)
    for name, factor in (("pga", STANDARD_GRAVITY), ("pgv", 1.0)):
        results.intensity[f"{name}_rotd"] = (("record", "percentile"), np.tile(factor * pga[:, None], 3))
    shown = population(results)
    (table,) = [table for table in tables(shown) if table.anchor == "fragility"]
    whole, of_class, *_ = table.rows
    assert whole[1:] == ("PGA, g", "above 1.4", "above 1.4", "–", "–", "–")
    assert of_class[1:3] == ("PGA, g", "0.800")
    assert of_class[-1] == "0.50"


def test_soft_ground_in_a_sentence(cemetery: Results) -> None:
    clayey = Layer(thickness_m=20, velocity_m_s=150, curve="Vucetic & Dobry (91), PI=30")
    soft = Variant(site=Site(layers=(clayey,), rock=Rock(velocity_m_s=760)))
    rock, clay = (cemetery.populations["nominal"].copy(deep=True) for _ in range(2))
    for found, rate, axis in ((rock, 0.1, 175.0), (clay, 0.6, 5.0)):
        found["fall_rate"][:], found["fall_axis"][:], found["fall_resultant"][:] = rate, axis, 0.3
    clay["fall_rate"][2] = 0.0  # no axis there
    rock["fall_axis"][1], rock["fall_resultant"][1] = 95.0, 0.04  # nor where stones fall every way alike
    step = {"step": "site", "chosen": "north converged, strain 1 %; east not converged (last change 3.0 %), strain 2 %"}
    account = {"peaks": {"pga": [4.903325, 9.80665]}, "steps": [step]}
    cube = cemetery.cube.assign_attrs(record_processing=json.dumps({"one": account}))
    both = {"populations": {"nominal": rock, "clay": clay}, "cubes": {"nominal": cube, "clay": cube}}
    results = replace(of_study(cemetery, variants={"clay": soft}), **both)
    shown = ground(results)
    text = said(shown)
    assert (
        "mean fall rate is 10 % on rock; 40 % through 20 m of soil (150 m/s), the axis of falls turned by 10°" in text
    )
    stronger = {name: one.assign_coords(amplitude=[1.5]) for name, one in results.populations.items()}
    assert "Under the motions at the surface times 1.5 the mean" in said(ground(replace(results, populations=stronger)))
    assert "one, 20 m of soil (150 m/s): east not converged (last change 3.0 %)" in text
    (table,) = tables(shown)
    assert [cell.replace("\u00a0", " ") for cell in table.rows[1]] == [
        "1",
        "20 m of soil (150 m/s)",
        "1.00",
        "40 %",
        "60 %",
        "2",
        "10° (1)",
    ]
    assert "stronger records would soften the soil more" in text
    hard = Site(layers=(clayey.model_copy(update={"curve": None}),), rock=Rock(velocity_m_s=760))
    settled = cemetery.cube.assign_attrs(record_processing=json.dumps({"one": account | {"steps": []}}))
    linear = replace(
        of_study(results, variants={"clay": Variant(site=hard)}), cubes={"nominal": settled, "clay": settled}
    )
    of_linear = said(ground(linear))
    assert "20 m of soil (150 m/s) is linear: strong motion softens it no more than weak." in of_linear
    assert not any(words in of_linear for words in ("iteration", "stronger records would", "equivalent-linear"))
    several = of_study(linear, variants={"clay": Variant(site=hard), "soft": soft})
    several = replace(several, populations=results.populations | {"soft": clay}, cubes=linear.cubes | {"soft": settled})
    count = len(cemetery.record_names)
    # Soils with equal layers are distinguished.
    both_said = said(ground(several))
    assert f"Every iteration of the {count} motions converged. clay: 20 m of soil (150 m/s) is linear" in both_said
    assert "40 % through clay: 20 m of soil (150 m/s), the axis" in both_said
    assert "40 % through soft: 20 m of soil (150 m/s), the axis" in both_said
    beyond = {name: one.assign_attrs(outside=0.8) for name, one in results.populations.items()}
    assert "80 % of the stones are larger" in said(ground(replace(results, populations=beyond)))
    assert ground(cemetery) is None
