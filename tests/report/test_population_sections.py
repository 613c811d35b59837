"""What the sections on a cemetery and on soft ground say of rates that are known."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.motion.jma_intensity import SURVEY_RULE
from overturning.records.steps import Layer, Rock, Site
from overturning.report.results import Results
from overturning.report.sections.population import ground, population
from overturning.study.sections import Population, Variant
from overturning.surveys.population import jma_intensities, population_rates
from tests.report.reading import tables, text_of

Make = Callable[..., Results]


@pytest.fixture
def cemetery(one_record: Make) -> Results:
    results, stones = one_record(3), Population(stones=64)
    study = results.study.model_copy(update={"population": stones})
    return replace(results, study=study, populations={"nominal": population_rates(results.cube, stones)})


def said(section: Any) -> str:
    return text_of(section).replace("\u00a0", " ")


def test_rates_with_intervals_by_record_and_no_turn_from_planes(cemetery: Results) -> None:
    shown = population(cemetery)
    assert shown is not None
    (table,) = [table for table in tables(shown) if table.heads[0] == "record"]
    assert table.heads[1:3] == ("fell, % (95 %)", "shifted, % (95 %)")
    rate = float(cemetery.populations["nominal"]["fall_rate"][0, 0])
    assert table.rows[0][1].replace("\u00a0", " ").startswith(f"{100 * rate:.0f} % (")
    assert "no plane can tell" in said(shown)


def test_the_rule_of_field_surveys_beside_the_instrumental_intensity(cemetery: Results) -> None:
    """Three motions of intensity 6.2 with a rate of 0.5 keep the rule, three of 5.2 with 0.95 do not."""
    one = cemetery.populations["nominal"]
    many = xr.concat([one, one], dim="record")
    many["fall_rate"][:] = np.repeat([0.5, 0.95], 3)[:, None]
    intensity = xr.concat([cemetery.intensity, cemetery.intensity], dim="record")
    intensity["jma_intensity"] = ("record", np.repeat([6.2, 5.2], 3))
    assert jma_intensities(many.assign_coords(amplitude=[10.0]), intensity)[0] == pytest.approx(8.2)
    cube = xr.concat([cemetery.cube, cemetery.cube], dim="record")
    text = said(population(replace(cemetery, cube=cube, populations={"nominal": many}, intensity=intensity)))
    assert "where 40 to 90 % fall, which they take for 6 upper, the instrumental intensity is 6.2" in text
    assert "in 100 % of 3 motions" in text
    assert "where 90 % or more fall, which they take for 7, the instrumental intensity is 5.2" in text
    assert SURVEY_RULE[0][:2] == (0.4, 0.9)


def test_soft_ground_in_a_sentence(cemetery: Results) -> None:
    soft = Variant(site=Site(layers=(Layer(thickness_m=20, velocity_m_s=150),), rock=Rock(velocity_m_s=760)))
    rock, clay = (cemetery.populations["nominal"].copy(deep=True) for _ in range(2))
    rock["fall_rate"][:], rock["fall_axis"][:] = 0.1, 175.0
    clay["fall_rate"][:], clay["fall_axis"][:] = 0.6, 5.0
    clay["fall_rate"][2] = 0.0  # no axis there
    step = {"step": "site", "chosen": "north converged, strain 1 %; east not converged (last change 3.0 %), strain 2 %"}
    account = {"peaks": {"pga": [4.903325, 9.80665]}, "steps": [step]}
    cube = cemetery.cube.assign_attrs(record_processing=json.dumps({"one": account}))
    study = cemetery.study.model_copy(update={"variants": {"clay": soft}})
    results = replace(
        cemetery, study=study, populations={"nominal": rock, "clay": clay}, cubes={"nominal": cube, "clay": cube}
    )
    shown = ground(results)
    assert shown is not None
    text = said(shown)
    assert (
        "mean fall rate is 10 % on rock; 40 % through 20 m of soil (150 m/s), the axis of falls turned by 10°" in text
    )
    assert "one, 20 m of soil (150 m/s): east not converged (last change 3.0 %)" in text
    (table,) = tables(shown)
    assert [cell.replace("\u00a0", " ") for cell in table.rows[1]] == [
        "1",
        "20 m of soil (150 m/s)",
        "1.00",
        "40 %",
        "60 %",
        "2",
        "10° (2)",
    ]
    assert ground(cemetery) is None
