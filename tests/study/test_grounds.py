"""Soil below the cemeteries of surveys: one cube for equal layers, and errors for unknown cemeteries."""

from typing import Any

import pytest

from overturning.errors import ConfigError
from overturning.study.grounds import (
    check_survey_site_names,
    soil_cube_names_of_survey,
    soil_layers_with_own_cube,
    soil_settings_of_study,
)
from overturning.study.load import study_from_content
from overturning.study.schema import Study


def soil(thickness_m: float, velocity_m_s: float = 150) -> dict[str, Any]:
    """Return a description of one layer over rock."""
    return {
        "layers": [{"thickness_m": thickness_m, "velocity_m_s": velocity_m_s}],
        "rock": {"velocity_m_s": 760},
    }


def study(*surveys: dict[str, Any], **more: Any) -> Study:
    content = {"name": "mine", "records": {"use": ["rinaldi", "petrolia"]}, "surveys": surveys}
    return study_from_content(content | more, "mine.yaml")


def test_equal_layers_have_one_cube_and_only_the_records_of_their_surveys() -> None:
    mine = study(
        {"stones": "a.csv", "record": "rinaldi", "site": soil(10), "sites": {"River": soil(20), "Church": soil(10)}},
        {"stones": "b.csv", "record": "petrolia", "sites": {"Hill": soil(10.0)}},
        {"stones": "c.csv", "record": "petrolia"},
    )
    (first, by_site), (second, at_hill), third = (soil_cube_names_of_survey(mine, one) for one in mine.surveys)
    assert by_site.keys() == {"River"}, "the church has the layers of the whole survey"
    assert (second, at_hill, third) == ("nominal", {"Hill": first}, ("nominal", {}))
    assert {name: records for name, (_, records) in soil_layers_with_own_cube(mine).items()} == {
        first: ["rinaldi", "petrolia"],
        by_site["River"]: ["rinaldi"],
    }
    keys = [key for key, _ in soil_settings_of_study(mine)]
    assert keys == ["surveys.0.site", "surveys.0.sites.River", "surveys.0.sites.Church", "surveys.1.sites.Hill"]


def test_the_cube_of_a_variant_with_the_same_layers_is_used() -> None:
    survey = {"stones": "a.csv", "record": "rinaldi", "site": soil(10)}
    same, other = (study(survey, variants={"clay": one}) for one in ({"site": soil(10)}, {"site": soil(11)}))
    assert (soil_cube_names_of_survey(same, same.surveys[0]), soil_layers_with_own_cube(same)) == (("clay", {}), {})
    assert len(soil_layers_with_own_cube(other)) == 1
    flat = study(survey, variants={"flat": {"site": soil(10), "vertical": False}})
    assert len(soil_layers_with_own_cube(flat)) == 1, "a variant that changes more than the soil"


def test_names_do_not_depend_on_other_surveys_or_on_defaults_that_are_written() -> None:
    own = {"stones": "a.csv", "record": "rinaldi", "site": soil(10)}
    alone, second = study(own), study({"stones": "b.csv", "record": "rinaldi", "site": soil(5)}, own)
    spelled = study(own | {"site": soil(10) | {"motion": "outcrop"}})
    (name,) = soil_layers_with_own_cube(alone)
    assert name in soil_layers_with_own_cube(second)
    assert [*soil_layers_with_own_cube(spelled)] == [name]
    assert soil_layers_with_own_cube(study()) == {}


@pytest.mark.parametrize(
    ("known", "remedy"),
    [({"River", "Hill"}, "did you mean River"), ({"A", ""}, "its sites are A"), ({""}, "give `site` instead")],
)
def test_unknown_cemetery(known: set[str], remedy: str) -> None:
    mine = study({"stones": "a.csv", "record": "rinaldi", "sites": {"Rivre": soil(10)}})
    message = rf"^mine\.yaml: surveys\.0\.sites\.Rivre: no stone of a\.csv has this site; .*{remedy}"
    with pytest.raises(ConfigError, match=message):
        check_survey_site_names(mine, 0, known, "mine.yaml")
    check_survey_site_names(mine, 0, {"Rivre"}, "mine.yaml")
