"""Cross-field validation of a study: combinations of settings that are not compatible."""

from collections.abc import Iterator
from typing import Any, Final

from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.model.contact import ContactSettings
from overturning.model.scene import gravestone
from overturning.settings import EnsembleSettings, StonePopulation
from overturning.study.evaluation import QUESTIONS_COMPARING_VARIANT_WITH_STUDY
from overturning.study.sections import BodyShapeSettings, Variant
from overturning.units import DEFAULT_STONE_DENSITY_KG_M3

_REASONS_TO_REFUSE_KEYS_IN_3D: Final = {
    "scene": "a study has a scene or a single 3-D body; keep one",
    "azimuth": "a 3-D body or stack moves in all directions at once; give orientation, the azimuths that it faces",
    "published": "a 3-D body or stack faces no single azimuth; compare in a 2-D study",
    "density": "nothing depends on it in 3-D, where the contact is relative to the weight; leave it out",
}
"""Keys that a study with the 3-D model refuses, with the reason."""


def incompatible_setting_messages(study: Any) -> Iterator[str]:
    """Yield a message, which begins with the key, for each incompatible combination of study settings."""
    named = [name for name, variant in study.variants.items() if variant.scene is not None]
    if named and (study.body is not None or "scene" not in study.model_fields_set):
        yield f"variants.{named[0]}.scene: only a study with a scene can have a variant with another scene"
    contacts = {f"variants.{name}.": one.contact for name, one in study.variants.items() if one.contact is not None}
    contacts[""] = study.contact
    if study.body is not None:
        yield from _messages_of_settings_incompatible_with_3d_body(study, study.body, contacts)
    elif study.is_stack:
        yield from _stack_conflict_messages(study)
    yield from _messages_on_settings_that_need_a_body(study)
    yield from _planar_scene_conflict_messages(study, contacts)
    yield from _invalid_variant_messages(study)
    yield from _primary_statistic_conflict_messages(study)
    yield from _research_question_conflict_messages(study)
    for key in ("height", "friction"):
        if (one := getattr(study.figures, key)) is not None and one not in getattr(study, key):
            yield f"figures.{key}: {one:g} is not computed; add it to {key}, or name one of them"
    yield from _survey_and_published_value_error_messages(study)


def _messages_on_settings_that_need_a_body(study: Any) -> Iterator[str]:
    """Yield, for a study without 3-D body, a message for each ensemble or population setting that needs a body."""
    if study.body is None and (study.ensemble.relief is not None or study.ensemble.orientation):
        yield "ensemble.relief, ensemble.orientation: only a single 3-D body has them; give `body`, or leave them out"
    if study.body is None and study.population is not None:
        own = study.population.model_dump(include={"shifted", "rotated"}).items()
        if said := [name for name, value in own if value != StonePopulation.model_fields[name].default]:
            yield f"population.{said[0]}: only 3-D stones have shifts and rotations; give `body`"


def _invalid_variant_messages(study: Any) -> Iterator[str]:
    """Yield a message for each invalid variant (a repetition of the study with some settings changed)."""
    if "nominal" in study.variants:
        yield "variants: the name nominal is that of the study's own contact; choose another"
    if bare := [name for name, variant in study.variants.items() if variant == Variant()]:
        yield f"variants.{bare[0]}: it changes nothing; give contact, scene, site or vertical, or leave it out"
    on_soil = [name for name, variant in study.variants.items() if variant.site is not None]
    if study.site is not None and on_soil:
        yield f"variants.{on_soil[0]}.site: the study has a site too; make that a variant as well"


def _survey_and_published_value_error_messages(study: Any) -> Iterator[str]:
    """Yield a message for each survey or published value that does not fit the records, grid or soil of the study."""
    for row in study.published:
        if row.record not in study.records.use:
            yield f"published: record {row.record!r} is not in records.use"
        if row.azimuth not in study.azimuth.expand_azimuths():
            yield f"published: azimuth {row.azimuth:g} is not computed; add it to azimuth.also"
        if row.b_over_h not in study.b_over_h:
            yield f"published: B/H {row.b_over_h:g} is not computed; add it to b_over_h"
    for index, survey in enumerate(study.surveys):
        if survey.record is None:
            yield f"surveys.{index}.record: {len(study.records.use)} records; name the one of the survey's site"
        elif survey.record not in study.records.use:
            yield f"surveys.{index}.record: {survey.record!r} is not in records.use"
        if study.site is not None and (survey.site is not None or survey.sites):
            key = "site" if survey.site is not None else f"sites.{next(iter(survey.sites))}"
            yield (
                f"surveys.{index}.{key}: the study has a site too, whose layers would come twice; give the layers at "
                "each survey, or only at the study"
            )


def _messages_of_settings_incompatible_with_3d_body(
    study: Any, body_settings: BodyShapeSettings, contact_settings_by_key_prefix: dict[str, ContactSettings]
) -> Iterator[str]:
    """Yield a message for each setting that is incompatible with a 3-D body."""
    for key, reason in _REASONS_TO_REFUSE_KEYS_IN_3D.items():
        if getattr(study, key) != (gravestone() if key == "scene" else type(study).model_fields[key].default):
            yield f"{key}: {reason}"
    if study.population is not None and (body_settings.plan != "rectangle" or 1.0 not in body_settings.aspect):
        yield "population: its stones are of square plan; give body {plan: rectangle, aspect: [1]}"
    try:
        study.orientation.orientations_of_body(body_settings)
    except ValueError as error:
        yield str(error)
    if study.simulation.scheme not in (None, DEFAULT_SCHEME):
        yield f"simulation.scheme: a 3-D body supports {DEFAULT_SCHEME!r} only; leave the key out"
    for where, contact in contact_settings_by_key_prefix.items():
        if contact.stiffness != "auto" or contact.damping is not None:
            yield f"{where}contact: in 3-D the stiffness is auto and the dashpot is given as damping_ratio"
    if not body_settings.body_shape().slenderness_is_parameter and study.ensemble.b_over_h not in (
        0.0,
        EnsembleSettings.model_fields["b_over_h"].default,
    ):
        yield "ensemble.b_over_h: the body of these vertices keeps its own in every run; leave it out"
    if study.ensemble.relief is not None and body_settings.scan is None:
        yield (
            "ensemble.relief: only a scanned stone has a relief; give body.mesh, and for a convex mesh also body.relief"
        )
    if study.ensemble.initial_tilt:
        yield "ensemble.initial_tilt: a 3-D body starts at rest; leave it at 0"


def _stack_conflict_messages(study: Any) -> Iterator[str]:
    """Yield a message for each setting that is incompatible with the 3-D simulation of a scene."""
    if study.scene == gravestone():
        yield "orientation: only a 3-D body or a stack has one; give `body` or `scene`, or `azimuth` instead"
        return
    for key, reason in _REASONS_TO_REFUSE_KEYS_IN_3D.items():
        given = "azimuth" in study.model_fields_set if key == "azimuth" else bool(getattr(study, key))
        if key not in ("scene", "density") and given:
            yield f"{key}: {reason}"
    try:
        study.orientation.orientations_of_stack(study.scene)
    except ValueError as error:
        yield str(error)
    for name, variant in study.variants.items():
        if variant.scene is not None:
            try:
                study.orientation.orientations_of_stack(variant.scene)
            except ValueError as error:
                yield f"variants.{name}.scene: {error}"
    if study.simulation.scheme not in (None, DEFAULT_SCHEME):
        yield f"simulation.scheme: a 3-D stack supports {DEFAULT_SCHEME!r} only; leave the key out"


def _primary_statistic_conflict_messages(study: Any) -> Iterator[str]:
    """Yield a message for each setting that is incompatible with the primary statistic."""
    statistic, against = study.primary.statistic, study.primary.against
    if statistic == "published" and not study.published:
        yield "primary.statistic: nothing is published to compare with; give `published`"
    if statistic == "fall_rate" and study.population is None:
        yield "primary.statistic: there are no stones whose rate it is; give `population`"
    if against is not None and statistic not in ("share", "fall_rate"):
        yield f"primary.against: {statistic} is that of the study itself; leave it out"
    if against is not None and against not in study.variants:
        known = f"; known: {', '.join(study.variants)}" if study.variants else "; the study has none"
        yield f"primary.against: {against!r} is none of the variants{known}"


def _research_question_conflict_messages(study: Any) -> Iterator[str]:
    """Yield a message for each setting that is incompatible with ``asks``, the kind of question of the study."""
    if study.asks == "survey" and not (study.surveys or study.published):
        yield "asks: survey, and there is nothing to compare with; give `surveys` or `published`"
    if study.asks == "reference" and study.body is None and not study.is_stack:
        yield "asks: reference, which only a 3-D body is free to follow; give `body`, or ask for direction"
    if study.asks not in QUESTIONS_COMPARING_VARIANT_WITH_STUDY:
        return
    if (against := study.primary.against) is not None and against not in study.variants:
        return  # named by `_primary_statistic_conflict_messages`
    if against is None:
        yield f"asks: {study.asks}, compared with which variant? name one in primary.against"
        return
    other = getattr(study.variants[against], study.asks)
    if other is None or other == getattr(study.simulation, study.asks, None):
        yield f"asks: {study.asks}, but variant {against!r} has none of its own; change it there"


def _planar_scene_conflict_messages(
    study: Any, contact_settings_by_key_prefix: dict[str, ContactSettings]
) -> Iterator[str]:
    """Yield a message for each setting that is incompatible with a 2-D scene."""
    scenes = {f"variants.{name}.": one.scene or study.scene for name, one in study.variants.items()}
    scenes[""] = study.scene
    own = [where for where, scene in scenes.items() if scene != gravestone()]  # that takes contact and density
    for where in own:
        if contact_settings_by_key_prefix.get(where, ContactSettings()) != ContactSettings():
            yield f"{where}contact: the scene has contact laws of its own; set them in the scene file"
    if own and study.population is not None:
        yield f"population: its stones are single blocks; leave out {own[-1]}scene, or population"
    swept = any(scene.has_contact_with_unset_friction for scene in scenes.values())
    if not swept and study.friction != type(study).model_fields["friction"].default:
        yield "friction: the scene has coefficients of its own; leave it out"
    if "" in own and study.density != DEFAULT_STONE_DENSITY_KG_M3:
        yield "density: the scene's materials have it; set it in the scene file"
    if own and study.ensemble.members and study.ensemble.initial_tilt:
        yield f"ensemble.initial_tilt: a scene starts at rest ({own[-1]}scene); leave it at 0"
