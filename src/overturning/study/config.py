"""The study configuration: the one source of defaults, of the JSON schema and of the key table in config/README.md."""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    field_validator,
    model_validator,
)

from overturning.dem.polygon.scene import Scene, load_scene
from overturning.records.steps import Step
from overturning.study.quantity import Damping, Degree, Density, Metre, Radian, Second, Stiffness
from overturning.units import GRANITE_DENSITY

_MAX_VALUES = 100_000


class _Model(BaseModel):
    # A misspelt key must be an error, and what a job computes must not depend on who changed the model on the way.
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Range(_Model):
    """Values from start to stop by step. The stop is included where a step meets it."""

    start: float = Field(description="first value")
    stop: float = Field(description="last value, included where a step meets it")
    step: float = Field(gt=0, description="distance between values")

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if self.stop < self.start:
            raise ValueError(f"empty range: stop {self.stop:g} lies below start {self.start:g}")
        if (self.stop - self.start) / self.step > _MAX_VALUES:
            raise ValueError(f"more than {_MAX_VALUES} values; use a larger step")
        return self

    def values(self) -> tuple[float, ...]:
        """The values, rounded to 1e-10 so that 0.1 + 2 · 0.05 is 0.2."""
        count = int(np.floor((self.stop - self.start) / self.step + 1e-9)) + 1
        return tuple(round(self.start + index * self.step, 10) for index in range(count))


class AzimuthRange(_Model):
    """Azimuths from start by step up to stop, which is excluded: 0° and 360° are the same direction."""

    start: Degree = Field(default=0.0, ge=0, lt=360, description="first azimuth, degrees clockwise from north")
    stop: Degree = Field(default=360.0, gt=0, le=360, description="end of the range, excluded")
    step: Degree = Field(default=5.0, gt=0, le=360, description="distance between azimuths, degrees")
    also: tuple[Degree, ...] = Field(
        default=(), description="further azimuths, degrees, for instance those of the paper"
    )

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if self.stop <= self.start:
            raise ValueError(f"empty range: stop {self.stop:g} does not lie above start {self.start:g}")
        return self

    def values(self) -> tuple[float, ...]:
        """The azimuths, ascending, each once."""
        count = int(np.ceil((self.stop - self.start) / self.step - 1e-9))
        grid = {round(self.start + index * self.step, 10) for index in range(count)}
        return tuple(sorted(grid | {round(azimuth % 360.0, 10) for azimuth in self.also}))


def _ascending(values: tuple[float, ...]) -> tuple[float, ...]:
    if not values:
        raise ValueError("empty list; give at least one value")
    if len(set(values)) != len(values):
        raise ValueError(f"a value stands twice in {list(values)}")
    return tuple(sorted(values))


PulseName = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]*$")]


class Records(_Model):
    """Which records to study and where they are described."""

    table: str = Field(
        default="config/records.tsv", description="record table, tab-separated; path from the project's folder"
    )
    folder: str = Field(default="resources/records", description="folder of the record files that the user provides")
    use: tuple[str, ...] = Field(min_length=1, description="ids of the records in the table, in the order of the cube")
    pulses: dict[PulseName, str] = Field(
        default={},
        description="synthetic records by id, one line each: `sine amplitude_gal=300 period_s=1 azimuth_deg=60`; used after the others",
    )

    @model_validator(mode="before")
    @classmethod
    def _use_every_pulse(cls, data: Any) -> Any:
        if isinstance(data, dict) and isinstance(data.get("pulses"), dict) and data["pulses"]:
            use = list(data.get("use") or ())
            return data | {"use": [*use, *(name for name in data["pulses"] if name not in use)]}
        return data

    @field_validator("use")
    @classmethod
    def _each_once(cls, ids: tuple[str, ...]) -> tuple[str, ...]:
        twice = sorted({name for name in ids if ids.count(name) > 1})
        if twice:
            raise ValueError(f"{', '.join(twice)} stands twice; name each record once")
        return ids


class ContactSettings(_Model):
    """Springs, dashpots and slider at each corner."""

    stiffness: Literal["auto"] | Stiffness = Field(
        default="auto", description="normal spring K_n per corner, N/m; auto: static penetration of 2e-5 B"
    )
    stiffness_ratio: float = Field(default=1.0, ge=0, description="tangential over normal stiffness, K_s/K_n")
    damping_ratio: float | None = Field(
        default=None,
        ge=0,
        description="damping ratio ξ of heave on both corners; 1 where neither it nor damping is given",
    )
    damping: Damping | None = Field(default=None, ge=0, description="dashpot h per corner instead of the ratio, N·s/m")

    @model_validator(mode="after")
    def _one_damping(self) -> Self:
        if self.damping_ratio is not None and self.damping is not None:
            raise ValueError("damping_ratio and damping are both given; keep one")
        if self.stiffness != "auto" and self.stiffness <= 0:
            raise ValueError(f"stiffness {self.stiffness:g} N/m; it must be above 0, or auto")
        return self


class Simulation(_Model):
    """How the cases are computed."""

    scheme: str | None = Field(
        default=None, description="integration scheme; the kernel's default where it is not given"
    )
    time_step: Literal["auto"] | Second = Field(
        default="auto", description="time step, s; auto: a fixed share of the stable one"
    )
    vertical: bool = Field(default=True, description="apply the vertical motion of the records that have one")
    leave_out: bool = Field(default=True, description="leave out what provably changes no flag and no side")

    @field_validator("time_step")
    @classmethod
    def _positive(cls, step: float | str) -> float | str:
        if isinstance(step, float) and step <= 0:
            raise ValueError("the time step must be above 0 s, or auto")
        return step


def _scene_of(given: Any) -> Any:
    # A name or path is read at once, so that a filled-in study holds the whole scene.
    return load_scene(given) if isinstance(given, str) else given


SceneChoice = Annotated[Scene, BeforeValidator(_scene_of, json_schema_input_type=str | Scene)]


class Variant(_Model):
    """A second setting, computed beside the nominal one into a cube of its own: of the contact, or of the scene."""

    scene: SceneChoice | None = Field(
        default=None,
        description="scene of this variant, scaled like the study's; B/H applies where its reference element has the same name",
    )
    contact: ContactSettings = Field(default=ContactSettings(), description="contact of this variant")


class Ensemble(_Model):
    """Each case run again in a neighbourhood: uniform half-widths, scrambled Sobol points."""

    members: int = Field(default=16, ge=0, le=4096, description="runs per case, even (two scrambles); 0 leaves it out")
    where: Literal["boundary", "everywhere"] = Field(
        default="boundary", description="cells within two B/H steps of a change of flag, or all cells"
    )
    amplitude: float = Field(default=0.02, ge=0, lt=1, description="half-width of the motion's amplitude, share")
    b_over_h: float = Field(default=0.01, ge=0, lt=1, description="half-width of B/H, share")
    friction: float = Field(default=0.05, ge=0, lt=1, description="half-width of the friction coefficient, share")
    damping: float = Field(default=0.2, ge=0, lt=1, description="half-width of the contact's damping, share")
    azimuth: Degree = Field(default=2.0, ge=0, le=90, description="half-width of the sensor's azimuth, degrees")
    initial_tilt: Radian = Field(default=0.0, ge=0, lt=1.5, description="half-width of the tilt at the start, rad")
    seed: int = Field(default=1, ge=0, description="seed of the scrambles")

    @field_validator("members")
    @classmethod
    def _even(cls, members: int) -> int:
        if members % 2:
            raise ValueError("an even number is needed: half of the members belong to each of two scrambles")
        return members


class Verification(_Model):
    """A random part of the study run again more exactly, to see how far its answers hang on the computation."""

    share: float = Field(
        default=0.02,
        gt=0,
        le=1,
        description="share of the study's cases that is run again; `verification: none` leaves it out",
    )
    at_least: int = Field(default=200, ge=1, description="number of cases at least, or all of a smaller study")
    cost: float = Field(
        default=1.0,
        gt=0,
        description="block steps of both repetitions, at most, as a share of the study's own: a small study has fewer cases run again",
    )
    seed: int = Field(default=1, ge=0, description="seed of the choice")


class Published(_Model):
    """What a publication states of one component, to compare the study with."""

    record: str = Field(description="id of the record")
    azimuth: Degree = Field(description="azimuth of the component, one of the study's, degrees clockwise from north")
    label: str = Field(default="", description="name of the component, for instance N60E")
    pga_gal: float | None = Field(default=None, gt=0, description="peak ground acceleration, Gal")
    pgv_cm_s: float | None = Field(default=None, gt=0, description="peak ground velocity, cm/s")
    pgd_cm: float | None = Field(default=None, gt=0, description="peak ground displacement, cm")
    b_over_h: float = Field(gt=0, description="slenderness of the block whose outcome is stated, one of the study's")
    overturns: bool = Field(description="whether the block overturns")


class Survey(_Model):
    """Stones that somebody has found fallen, to compare with what the study predicts for their site."""

    stones: str = Field(
        min_length=1, description="survey of fallen stones (CSV, see docs/formats.md); path from the project's folder"
    )
    record: str | None = Field(
        default=None, description="id of the site's record; not needed where the study has one record only"
    )
    background: float = Field(default=0.05, ge=0, lt=1, description="share of the stones taken to fall any way")


def _none_or_settings(value: Any) -> str:
    # Told apart beforehand, so that a wrong key is one message and not one per form.
    return "literal" if isinstance(value, str) else "settings of verification"


Name = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]*$")]
Slenderness = Annotated[float, Field(gt=0, le=10)]
Height = Annotated[Metre, Field(gt=0, le=100)]
Friction = Annotated[float, Field(ge=0, le=100)]


class Study(_Model):
    """A study: which records, which blocks, how computed."""

    name: Name = Field(description="name of the study and of its folder under results/: small letters, digits, hyphens")
    title: str = Field(default="", description="title of the report")
    question: str = Field(default="", description="the question that the report answers")
    records: Records = Field(description="the records")
    processing: tuple[Step, ...] | None = Field(
        default=None,
        description="processing steps in order; not given: by kind of file (processed files are left alone)",
    )
    scene: SceneChoice | None = Field(
        default=None,
        description="scene of polygons: name of a file in config/scenes, a path, or the scene itself; not given: one block",
    )
    azimuth: AzimuthRange = Field(
        default=AzimuthRange(), description="azimuths of the motion, degrees clockwise from north"
    )
    b_over_h: tuple[Slenderness, ...] = Field(
        default=(0.2, 0.3, 0.4), description="slenderness B/H: a list, or start, stop, step"
    )
    height: tuple[Height, ...] = Field(
        default=(0.6,), description="heights of the block, m: a list, or start, stop, step"
    )
    friction: tuple[Friction, ...] = Field(
        default=(1.0,), description="friction coefficients µ: a list, or start, stop, step"
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
        Discriminator(_none_or_settings),
    ] = Field(default=Verification(), description="`none`, or which part of the study is run again more exactly")
    variants: dict[Name, Variant] = Field(
        default={}, description="further settings of contact or scene by name, each with a cube of its own"
    )
    published: tuple[Published, ...] = Field(
        default=(), description="published values; the report compares the study with them"
    )
    surveys: tuple[Survey, ...] = Field(
        default=(), description="surveys of fallen stones; the report compares each with what its site's cube predicts"
    )

    @model_validator(mode="before")
    @classmethod
    def _as_the_scene_has_it(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("scene") is None:
            return data
        from overturning.dem.polygon.geometry import native_size

        filled = dict(data)
        filled["scene"] = Scene.model_validate(_scene_of(data["scene"]))
        height, b_over_h = native_size(filled["scene"])
        filled.setdefault("height", [round(height, 10)])
        filled.setdefault("b_over_h", [round(b_over_h, 10)])
        filled.setdefault("ensemble", {"members": 0})
        return filled

    @model_validator(mode="after")
    def _scene_has_its_own_contact(self) -> Self:
        if self.scene is None:
            named = [name for name, variant in self.variants.items() if variant.scene is not None]
            if named:
                raise ValueError(f"variants.{named[0]}.scene: only a study with a scene can have another one beside it")
            return self
        contacts = {"": self.contact} | {
            f"variants.{name}.": variant.contact for name, variant in self.variants.items()
        }
        for where, contact in contacts.items():
            if contact != ContactSettings():
                raise ValueError(f"{where}contact: the scene has contact laws of its own; set them in the scene file")
        if self.density != GRANITE_DENSITY:
            raise ValueError("density: the scene's materials have it; set it in the scene file")
        if self.ensemble.members:
            raise ValueError("ensemble.members: scenes are computed without an ensemble; leave it out or set it to 0")
        return self

    @field_validator("b_over_h", "height", "friction", mode="before")
    @classmethod
    def _range_or_list(cls, value: Any) -> Any:
        if isinstance(value, dict):
            return Range.model_validate(value).values()
        return [value] if isinstance(value, int | float | str) else value

    @field_validator("b_over_h", "height", "friction")
    @classmethod
    def _sorted(cls, values: tuple[float, ...]) -> tuple[float, ...]:
        return _ascending(values)

    @model_validator(mode="after")
    def _nominal_is_taken(self) -> Self:
        if "nominal" in self.variants:
            raise ValueError("variants: the name nominal is that of the study's own contact; choose another")
        return self

    @model_validator(mode="after")
    def _published_is_computed(self) -> Self:
        for row in self.published:
            if row.record not in self.records.use:
                raise ValueError(f"published: record {row.record!r} is not in records.use")
            if row.azimuth not in self.azimuth.values():
                raise ValueError(f"published: azimuth {row.azimuth:g} is not computed; add it to azimuth.also")
            if row.b_over_h not in self.b_over_h:
                raise ValueError(f"published: B/H {row.b_over_h:g} is not computed; add it to b_over_h")
        return self

    @model_validator(mode="before")
    @classmethod
    def _site_of_a_survey(cls, data: Any) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("surveys"), list | tuple):
            return data
        records = data.get("records")
        use = list(records.get("use") or ()) if isinstance(records, dict) else []
        if isinstance(records, dict) and isinstance(records.get("pulses"), dict):
            use += [name for name in records["pulses"] if name not in use]
        # The record is filled in, so that a filled-in study says which one it was.
        filled = [
            {**survey, "record": use[0]}
            if isinstance(survey, dict) and survey.get("record") is None and len(use) == 1
            else survey
            for survey in data["surveys"]
        ]
        return data | {"surveys": filled}

    @model_validator(mode="after")
    def _survey_has_a_site(self) -> Self:
        for index, survey in enumerate(self.surveys):
            if survey.record is None:
                raise ValueError(
                    f"surveys.{index}.record: {len(self.records.use)} records; name the one of the survey's site"
                )
            if survey.record not in self.records.use:
                raise ValueError(f"surveys.{index}.record: {survey.record!r} is not in records.use")
        return self

    @property
    def cases(self) -> int:
        """Number of cases per record."""
        return len(self.azimuth.values()) * len(self.height) * len(self.b_over_h) * len(self.friction)
