"""Soil below the cemeteries of surveys: one cube for equal layers, and errors for unknown cemeteries."""

from typing import Any

import pytest

from overturning.errors import ConfigError
from overturning.study.grounds import (
    check_soil_sites_occur_in_survey_table,
    soil_layers_and_records_by_soil_cube_name,
    soil_setting_keys_and_values_of_study,
    survey_cube_name_and_other_cube_names_by_site,
)
from overturning.study.load import study_from_content
from overturning.study.schema import Study


def soil_site_settings(thickness_m: float, velocity_m_s: float = 150) -> dict[str, Any]:
    """Return the settings of one soil layer over rock."""
    return {
        "layers": [{"thickness_m": thickness_m, "velocity_m_s": velocity_m_s}],
        "rock": {"velocity_m_s": 760},
    }


def study_with_surveys(*surveys: dict[str, Any], **more: Any) -> Study:
    """Return a study of two records and of surveys with these settings; `more` gives other settings of the study."""
    content = {"name": "mine", "records": {"use": ["rinaldi", "petrolia"]}, "surveys": surveys}
    return study_from_content(content | more, "mine.yaml")


def test_surveys_with_equal_soil_layers_share_one_cube_of_their_records() -> None:
    mine = study_with_surveys(
        {
            "stones": "a.csv",
            "record": "rinaldi",
            "site": soil_site_settings(10),
            "sites": {"River": soil_site_settings(20), "Church": soil_site_settings(10)},
        },
        {"stones": "b.csv", "record": "petrolia", "sites": {"Hill": soil_site_settings(10.0)}},
        {"stones": "c.csv", "record": "petrolia"},
    )
    (first, by_site), (second, at_hill), third = (
        survey_cube_name_and_other_cube_names_by_site(mine, one) for one in mine.surveys
    )
    assert by_site.keys() == {"River"}, "the church has the layers of the whole survey"
    assert (second, at_hill, third) == ("nominal", {"Hill": first}, ("nominal", {}))
    assert {name: records for name, (_, records) in soil_layers_and_records_by_soil_cube_name(mine).items()} == {
        first: ["rinaldi", "petrolia"],
        by_site["River"]: ["rinaldi"],
    }
    keys = [key for key, _ in soil_setting_keys_and_values_of_study(mine)]
    assert keys == ["surveys.0.site", "surveys.0.sites.River", "surveys.0.sites.Church", "surveys.1.sites.Hill"]


def test_a_survey_uses_the_cube_of_a_variant_with_the_same_soil_layers() -> None:
    survey = {"stones": "a.csv", "record": "rinaldi", "site": soil_site_settings(10)}
    same, other = (
        study_with_surveys(survey, variants={"clay": one})
        for one in ({"site": soil_site_settings(10)}, {"site": soil_site_settings(11)})
    )
    assert (
        survey_cube_name_and_other_cube_names_by_site(same, same.surveys[0]),
        soil_layers_and_records_by_soil_cube_name(same),
    ) == (
        ("clay", {}),
        {},
    )
    assert len(soil_layers_and_records_by_soil_cube_name(other)) == 1
    flat = study_with_surveys(survey, variants={"flat": {"site": soil_site_settings(10), "vertical": False}})
    assert len(soil_layers_and_records_by_soil_cube_name(flat)) == 1, "a variant that changes more than the soil"


def test_soil_cube_names_do_not_depend_on_other_surveys_or_explicit_defaults() -> None:
    own = {"stones": "a.csv", "record": "rinaldi", "site": soil_site_settings(10)}
    alone = study_with_surveys(own)
    second = study_with_surveys({"stones": "b.csv", "record": "rinaldi", "site": soil_site_settings(5)}, own)
    spelled = study_with_surveys(own | {"site": soil_site_settings(10) | {"motion": "outcrop"}})
    (name,) = soil_layers_and_records_by_soil_cube_name(alone)
    assert name in soil_layers_and_records_by_soil_cube_name(second)
    assert [*soil_layers_and_records_by_soil_cube_name(spelled)] == [name]
    assert soil_layers_and_records_by_soil_cube_name(study_with_surveys()) == {}


@pytest.mark.parametrize(
    ("known", "remedy"),
    [({"River", "Hill"}, "did you mean River"), ({"A", ""}, "its sites are A"), ({""}, "give `site` instead")],
)
def test_the_error_names_an_unknown_cemetery_of_a_survey(known: set[str], remedy: str) -> None:
    mine = study_with_surveys({"stones": "a.csv", "record": "rinaldi", "sites": {"Rivre": soil_site_settings(10)}})
    message = rf"^mine\.yaml: surveys\.0\.sites\.Rivre: no stone of a\.csv has this site; .*{remedy}"
    with pytest.raises(ConfigError, match=message):
        check_soil_sites_occur_in_survey_table(mine, 0, known, "mine.yaml")
    check_soil_sites_occur_in_survey_table(mine, 0, {"Rivre"}, "mine.yaml")
