"""Soil layers below the cemeteries of surveys: names of their cubes, and checks of the names of cemeteries."""

import hashlib
from collections.abc import Collection, Iterator

from overturning.errors import ConfigError, closest_name_hint
from overturning.records.site import SoilSite
from overturning.study.evaluation import SurveySettings
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
from overturning.study.schema import Study
from overturning.study.sections import Variant


def variant_or_soil_cube_name(study: Study, soil_site: SoilSite | None) -> str:
    """Return the name of the results cube that is computed with motions on top of given soil layers.

    Without soil the name is "nominal". If a variant of the study changes only the soil, to these layers, it is the name
    of this variant; otherwise a name with a hash of the layers, so that equal layers are simulated once.
    """
    if soil_site is None:
        return NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
    for name, variant in study.variants.items():
        if variant == Variant(site=soil_site):
            return name
    return f"soil-{hashlib.sha256(soil_site.model_dump_json().encode()).hexdigest()[:8]}"


def survey_cube_name_and_other_cube_names_by_site(study: Study, survey: SurveySettings) -> tuple[str, dict[str, str]]:
    """Return the name of a survey's results cube, and by site the cube names of sites with other soil layers.

    Sites (cemeteries) with the soil layers of the survey are left out. For the names see `variant_or_soil_cube_name`.
    """
    default = variant_or_soil_cube_name(study, survey.site)
    named = {site: variant_or_soil_cube_name(study, soil) for site, soil in survey.sites.items()}
    return default, {site: name for site, name in named.items() if name != default}


def soil_layers_and_records_by_soil_cube_name(study: Study) -> dict[str, tuple[SoilSite, list[str]]]:
    """Return, by cube name, the survey soil layers that need a results cube, and the records to simulate on them.

    Soil layers of a variant are left out, since each variant has a cube. Records are in the order of the study.
    """
    soils, records = dict[str, SoilSite](), dict[str, set[str | None]]()
    for survey in study.surveys:
        for soil in (survey.site, *survey.sites.values()):
            name = variant_or_soil_cube_name(study, soil)
            if soil is not None and name not in study.variants:
                soils[name] = soil
                records.setdefault(name, set()).add(survey.record)
    return {name: (soil, [one for one in study.records.use if one in records[name]]) for name, soil in soils.items()}


def soil_setting_keys_and_values_of_study(study: Study) -> Iterator[tuple[str, SoilSite]]:
    """Yield key and value of each setting of soil layers: of the study, its variants and its surveys."""
    if study.site is not None:
        yield "site", study.site
    for name, variant in study.variants.items():
        if variant.site is not None:
            yield f"variants.{name}.site", variant.site
    for number, survey in enumerate(study.surveys):
        if survey.site is not None:
            yield f"surveys.{number}.site", survey.site
        for name, soil in survey.sites.items():
            yield f"surveys.{number}.sites.{name}", soil


def check_soil_sites_occur_in_survey_table(
    study: Study, survey_index: int, site_names_in_survey_table: Collection[str], study_file_in_error_messages: str
) -> None:
    """Raise a `ConfigError` if soil layers are set for a site that does not occur in the survey's table.

    Surveys are counted from 0; `site_names_in_survey_table` are the names in the column ``site`` of its table.
    """
    for name in study.surveys[survey_index].sites:
        if name not in site_names_in_survey_table:
            named = sorted(one for one in site_names_in_survey_table if one)
            there = f"its sites are {', '.join(named)}" if named else "no stone has one; give `site` instead of `sites`"
            remedy = closest_name_hint(name, named, there)
            raise ConfigError(
                f"{study_file_in_error_messages}: surveys.{survey_index}.sites.{name}: no stone of "
                f"{study.surveys[survey_index].stones} has this site; {remedy}"
            )
