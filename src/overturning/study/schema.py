"""The study configuration: the one source of defaults, of the JSON schema and of the key table in config/README.md."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, Final, Literal, Self

from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.model.cases import HIGHEST, LOWEST, checked_height
from overturning.model.element import Keys, Name
from overturning.model.geometry import native_size
from overturning.model.scene import Scene, gravestone
from overturning.records.site import Site
from overturning.records.steps import Steps
from overturning.study.evaluation import CONTRASTS, Asks, Crate, Figures, Population, Primary, Published, Survey
from overturning.study.sections import (
    BodySettings,
    ContactSettings,
    Ensemble,
    Orientations,
    Records,
    SceneChoice,
    Simulation,
    Variant,
    Verification,
    scene_of_choice,
)
from overturning.study.values import AzimuthRange, Density, Metre, Values
from overturning.units import GRANITE_DENSITY

_IN_PLANES_ONLY: Final = {
    "scene": "a study has a scene in planes or a body in space; keep one",
    "azimuth": "a body in space moves in all directions at once; give orientation, the azimuths that it faces",
    "published": "a body in space faces no single azimuth; compare in a study in planes",
    "surveys": "surveys are compared with a study in planes; leave them out here",
    "density": "nothing depends on it in space, where the contact is relative to the weight; leave it out",
}
"""Keys that a study in space refuses, with the reason."""

Slenderness = Annotated[float, Field(gt=0, le=10)]
Height = Annotated[Metre, AfterValidator(checked_height), Field(ge=LOWEST, le=HIGHEST)]
Friction = Annotated[float, Field(ge=0, le=100)]
Factor = Annotated[float, Field(gt=0, le=100)]


class Study(Keys):
    """A study: which records, which blocks, how computed."""

    name: Name = Field(description="name of the study and of its folder under results/: small letters, digits, hyphens")
    title: str = Field(default="", description="title of the report")
    question: str = Field(default="", description="the question that the report answers")
    asks: Asks = Field(
        default="direction",
        description="kind of the question, for which the report builds its answer: `direction` of falls relative to "
        "the fault; which `reference` they follow, peaks, pulse or fault; what `vertical` motion, another `scene` or "
        "another `site` changes, case by case beside the variant that `primary.against` names; a `survey`, or a "
        "publication, beside the study",
    )
    primary: Primary = Field(default=Primary(), description="the statistic that answers the question")
    records: Records = Field(description="the records")
    processing: Steps | None = Field(
        default=None,
        description="processing steps in order; not given: by kind of file (processed files are left alone)",
    )
    site: Site | None = Field(
        default=None, description="soil that the records, taken for rock, go through; not given: the ground they are of"
    )
    scene: SceneChoice = Field(
        default_factory=gravestone,
        description="scene of polygons: name of a file in config/scenes, a path, or the scene itself; not given: one "
        "block. With one `height` and `b_over_h` are its own where they are not given, and no ensemble is run without "
        "`ensemble`",
        json_schema_extra={"default": "gravestone"},
    )
    body: BodySettings | None = Field(
        default=None, description="a free body in space instead of a scene in vertical planes; not given: in planes"
    )
    orientation: Orientations = Field(default=Orientations(), description="directions that a body in space faces")
    azimuth: AzimuthRange = Field(
        default=AzimuthRange(),
        description="azimuths of the motion, degrees clockwise from north; a body in space has `orientation` instead",
    )
    b_over_h: Values[Slenderness] = Field(
        default=(0.2, 0.3, 0.4), description="slenderness B/H: a list, or start, stop, step"
    )
    height: Values[Height] = Field(default=(0.6,), description="heights of the block, m: a list, or start, stop, step")
    friction: Values[Friction] = Field(
        default=(1.0,), description="friction coefficients µ: a list, or start, stop, step"
    )
    amplitude: Values[Factor] = Field(
        default=(1.0,),
        description="factors on each whole record, with a `site` on what comes through the soil, 1 among them: a list, "
        "or start, stop, step; a dimension of the cube where there is more than one, and the ensemble is run for 1 "
        "only",
    )
    density: Density = Field(default=GRANITE_DENSITY, gt=0, description="density of the block, kg/m³")
    contact: ContactSettings = Field(
        default=ContactSettings(), description="springs, dashpots and slider at each corner"
    )
    simulation: Simulation = Field(default=Simulation(), description="how the cases are computed")
    ensemble: Ensemble = Field(
        default=Ensemble(), description="each case run again in a neighbourhood, to see how far its answer holds"
    )
    verification: Annotated[
        Annotated[Literal["none"], Tag("literal")] | Annotated[Verification, Tag("settings of verification")],
        # Told apart beforehand, so that a wrong key is one message and not one per form.
        Discriminator(lambda value: "literal" if isinstance(value, str) else "settings of verification"),
    ] = Field(default=Verification(), description="`none`, or which part of the study is run again more exactly")
    variants: dict[Name, Variant] = Field(
        default={},
        description="further settings of contact, scene, site or vertical motion by name, each with a cube of its own; "
        "what one does not give is as in the study",
    )
    published: tuple[Published, ...] = Field(
        default=(), description="published values; the report compares the study with them"
    )
    population: Population | None = Field(
        default=None, description="a cemetery of many stones, whose fall rate is wanted under each record"
    )
    surveys: tuple[Survey, ...] = Field(
        default=(), description="surveys of fallen stones; the report compares each with what its site's cube predicts"
    )

    figures: Figures = Field(default=Figures(), description="size, resolution and kinds of the figures' files")
    crate: Crate = Field(default=Crate(), description="authors and terms, for the research crate of the results")

    @model_validator(mode="before")
    @classmethod
    def _as_the_scene_has_it(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        filled = {key: value for key, value in data.items() if key != "scene" or value is not None}
        if filled.get("body") is not None:
            return cls._as_the_body_has_it(filled)
        if "scene" not in filled:
            return filled
        filled["scene"] = Scene.model_validate(scene_of_choice(data["scene"]))
        height, b_over_h = native_size(filled["scene"])
        filled.setdefault("height", [round(height, 10)])
        filled.setdefault("b_over_h", [round(b_over_h, 10)])
        filled.setdefault("ensemble", {"members": 0})
        return filled

    @staticmethod
    def _as_the_body_has_it(filled: dict[str, Any]) -> dict[str, Any]:
        try:
            shape = BodySettings.model_validate(filled["body"]).shape()
        except ValidationError:
            return filled  # said where the body stands
        if not shape.sized:
            own = round(shape.body(1.0, 1.0, 1.0).b_over_h, 10)
            if list(filled.setdefault("b_over_h", [own])) != [own]:
                raise ValueError("b_over_h: the body of these vertices has its own; leave it out")
            filled.setdefault("height", [round(getattr(shape, "height", 1.0), 10)])
        return filled

    @field_validator("amplitude")
    @classmethod
    def _as_recorded_too(cls, amplitude: tuple[float, ...]) -> tuple[float, ...]:
        if 1.0 not in amplitude:
            raise ValueError("1 is missing: the report is of the records as recorded; add it")
        return amplitude

    @field_validator("variants")
    @classmethod
    def _contact_of_the_study(cls, variants: dict[str, Variant], info: ValidationInfo) -> dict[str, Variant]:
        own: ContactSettings = info.data.get("contact", ContactSettings())
        # What is not given is filled in, so that a filled-in study is the same when it is read again.
        return {
            name: one.model_copy(update={"contact": one.contact and one.contact.over(own)})
            for name, one in variants.items()
        }

    @field_validator("surveys")
    @classmethod
    def _site_of_a_survey(cls, surveys: tuple[Survey, ...], info: ValidationInfo) -> tuple[Survey, ...]:
        use: tuple[str, ...] = info.data["records"].use if "records" in info.data else ()
        if len(use) != 1:
            return surveys
        # The record is filled in, so that a filled-in study says which one it was.
        return tuple(
            survey.model_copy(update={"record": use[0] if survey.record is None else survey.record})
            for survey in surveys
        )

    @model_validator(mode="after")
    def _parts_fit_together(self) -> Self:
        if wrong := next(self._misfits(), ""):
            raise ValueError(wrong)
        return self

    def _misfits(self) -> Iterator[str]:
        """What does not go together, the key first."""
        named = [name for name, variant in self.variants.items() if variant.scene is not None]
        if named and (self.body is not None or "scene" not in self.model_fields_set):
            yield f"variants.{named[0]}.scene: only a study with a scene can have another one beside it"
        contacts = {f"variants.{name}.": one.contact for name, one in self.variants.items() if one.contact is not None}
        contacts[""] = self.contact
        if self.body is not None:
            yield from self._misfits_of_body(self.body, contacts)
        elif self.orientation != Orientations():
            yield "orientation: only a body in space has one; give `body`, or `azimuth` instead"
        if self.body is None and self.population is not None:
            own = self.population.model_dump(include={"shifted", "rotated"}).items()
            if said := [name for name, value in own if value != Population.model_fields[name].default]:
                yield f"population.{said[0]}: only stones in space are told shifted or rotated; give `body`"
        yield from self._misfits_of_scenes(contacts)
        if "nominal" in self.variants:
            yield "variants: the name nominal is that of the study's own contact; choose another"
        if bare := [name for name, variant in self.variants.items() if variant == Variant()]:
            yield f"variants.{bare[0]}: it changes nothing; give contact, scene, site or vertical, or leave it out"
        on_soil = [name for name, variant in self.variants.items() if variant.site is not None]
        if self.site is not None and on_soil:
            yield f"variants.{on_soil[0]}.site: the study has a site too; make that a variant as well"
        yield from self._misfits_of_primary()
        yield from self._misfits_of_question()
        for key in ("height", "friction"):
            if (one := getattr(self.figures, key)) is not None and one not in getattr(self, key):
                yield f"figures.{key}: {one:g} is not computed; add it to {key}, or name one of them"
        yield from self._misfits_of_observations()

    def _misfits_of_observations(self) -> Iterator[str]:
        for row in self.published:
            if row.record not in self.records.use:
                yield f"published: record {row.record!r} is not in records.use"
            if row.azimuth not in self.azimuth.values():
                yield f"published: azimuth {row.azimuth:g} is not computed; add it to azimuth.also"
            if row.b_over_h not in self.b_over_h:
                yield f"published: B/H {row.b_over_h:g} is not computed; add it to b_over_h"
        for index, survey in enumerate(self.surveys):
            if survey.record is None:
                yield f"surveys.{index}.record: {len(self.records.use)} records; name the one of the survey's site"
            elif survey.record not in self.records.use:
                yield f"surveys.{index}.record: {survey.record!r} is not in records.use"

    def _misfits_of_body(self, body: BodySettings, contacts: dict[str, ContactSettings]) -> Iterator[str]:
        for key, reason in _IN_PLANES_ONLY.items():
            if getattr(self, key) != (gravestone() if key == "scene" else Study.model_fields[key].default):
                yield f"{key}: {reason}"
        if self.population is not None and (body.plan != "rectangle" or 1.0 not in body.aspect):
            yield "population: its stones are of square plan; give body {plan: rectangle, aspect: [1]}"
        self.orientation.values(body)
        if self.simulation.scheme not in (None, DEFAULT_SCHEME):
            yield f"simulation.scheme: a body in space has {DEFAULT_SCHEME!r} alone; leave it out"
        for where, contact in contacts.items():
            if contact.stiffness != "auto" or contact.damping is not None:
                yield f"{where}contact: in space stiffness is auto and the dashpot is given as damping_ratio"
        if not body.shape().sized and self.ensemble.b_over_h not in (0.0, Ensemble.model_fields["b_over_h"].default):
            yield "ensemble.b_over_h: the body of these vertices keeps its own in every run; leave it out"
        if self.ensemble.initial_tilt:
            yield "ensemble.initial_tilt: a body in space starts at rest; leave it at 0"

    def _misfits_of_primary(self) -> Iterator[str]:
        statistic, against = self.primary.statistic, self.primary.against
        if statistic == "published" and not self.published:
            yield "primary.statistic: nothing is published to compare with; give `published`"
        if statistic == "fall_rate" and self.population is None:
            yield "primary.statistic: there are no stones whose rate it is; give `population`"
        if against is not None and statistic not in ("share", "fall_rate"):
            yield f"primary.against: {statistic} is that of the study itself; leave it out"
        if against is not None and against not in self.variants:
            yield f"primary.against: {against!r} is none of the variants"

    def _misfits_of_question(self) -> Iterator[str]:
        if self.asks == "survey" and not (self.surveys or self.published):
            yield "asks: survey, and there is nothing to compare with; give `surveys` or `published`"
        if self.asks == "reference" and self.body is None:
            yield "asks: reference, which only a body in space is free to follow; give `body`, or ask for direction"
        if self.asks not in CONTRASTS:
            return
        if self.primary.against not in self.variants:
            yield f"asks: {self.asks}, beside which variant? name one in primary.against"
            return
        other = getattr(self.variants[self.primary.against], self.asks)
        if other is None or other == getattr(self.simulation, self.asks, None):
            yield f"asks: {self.asks}, but variant {self.primary.against!r} has none of its own; change it there"

    def _misfits_of_scenes(self, contacts: dict[str, ContactSettings]) -> Iterator[str]:
        scenes = {f"variants.{name}.": one.scene or self.scene for name, one in self.variants.items()}
        scenes[""] = self.scene
        own = [where for where, scene in scenes.items() if scene != gravestone()]  # that takes contact and density
        for where in own:
            if contacts.get(where, ContactSettings()) != ContactSettings():
                yield f"{where}contact: the scene has contact laws of its own; set them in the scene file"
        if own and self.population is not None:
            yield f"population: its stones are single blocks; leave out {own[-1]}scene, or population"
        swept = any(scene.sweeps_friction for scene in scenes.values())
        if not swept and self.friction != Study.model_fields["friction"].default:
            yield "friction: the scene has coefficients of its own; leave it out"
        if "" in own and self.density != GRANITE_DENSITY:
            yield "density: the scene's materials have it; set it in the scene file"
        if own and self.ensemble.members and self.ensemble.initial_tilt:
            yield f"ensemble.initial_tilt: a scene starts at rest ({own[-1]}scene); leave it at 0"

    @property
    def several_blocks(self) -> bool:
        """Whether there are others than the one of the large maps."""
        return len(self.height) * len(self.friction) * len(self.aspects) > 1

    @property
    def cases(self) -> int:
        """Number of cases per record."""
        return math.prod(map(len, (self.directions, self.aspects, self.height, self.b_over_h, self.friction)))

    @property
    def directions(self) -> tuple[float, ...]:
        """Azimuths of the motion, or orientations of the body in space, degrees, ascending."""
        return tuple(self.azimuth.values() if self.body is None else self.orientation.values(self.body))

    @property
    def aspects(self) -> tuple[float, ...]:
        """D/B of a body in space."""
        return (1.0,) if self.body is None else self.body.aspect
