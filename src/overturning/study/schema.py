"""The study configuration: the one source of defaults, of the JSON schema and of the key table in config/README.md."""

import math
from typing import Annotated, Any, Final, Literal, Self

from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    SerializerFunctionWrapHandler,
    Tag,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)

from overturning.errors import REASON_SEPARATOR
from overturning.model.cases import MAX_STONE_HEIGHT_M, MIN_STONE_HEIGHT_M, checked_stone_height
from overturning.model.contact import ContactSettings
from overturning.model.geometry import rounded_reference_height_and_b_over_h
from overturning.model.scene import Scene, gravestone
from overturning.quantities import DensityInKgPerM3, Metre
from overturning.records.site import SoilSite
from overturning.records.steps import ProcessingSteps
from overturning.settings import EnsembleSettings, StonePopulation
from overturning.study.evaluation import (
    CrateMetadata,
    FigureSettings,
    Language,
    PrimaryStatistic,
    PublishedPeaksAndBlockOutcome,
    QuestionKind,
    SurveySettings,
)
from overturning.study.misfits import incompatible_setting_messages
from overturning.study.sections import (
    BodyShapeSettings,
    ConvergenceCheckSettings,
    OrientationRange,
    RecordSettings,
    SceneChoice,
    SimulationSettings,
    StudyOrVariantName,
    Variant,
    load_scene_if_name_or_path,
)
from overturning.study.values import AzimuthRange, ValueListOrRange
from overturning.units import DEFAULT_STONE_DENSITY_KG_M3
from overturning.validation import StrictModel

SlendernessBOverH = Annotated[float, Field(gt=0, le=10)]
StoneHeightMetres = Annotated[
    Metre, AfterValidator(checked_stone_height), Field(ge=MIN_STONE_HEIGHT_M, le=MAX_STONE_HEIGHT_M)
]
FrictionCoefficient = Annotated[float, Field(ge=0, le=100)]
AmplitudeFactor = Annotated[float, Field(gt=0, le=100)]


_KEYS_MARKING_STUDY_STORED_WITH_DEFAULTS: Final = frozenset(
    {"azimuth", "body", "contact", "crate", "figures", "simulation"}
)
"""Some of the keys of a study that was stored complete; nobody writes all of them by hand."""


class Study(StrictModel):
    """Settings of a study, from its YAML file: records, stones, simulation, and evaluation of the outcomes."""

    name: StudyOrVariantName = Field(
        description="name of the study and of its folder under results/: small letters, digits, hyphens"
    )
    title: str = Field(default="", description="title of the report")
    question: str = Field(default="", description="the question that the report answers")
    asks: QuestionKind = Field(
        default="direction",
        description="kind of the question; the Answer of the report depends on it. `direction`: direction of falls "
        "relative to the fault. `reference`: the reference that falls follow (peaks, pulse or fault). `vertical`, "
        "`scene`, `site`: effect of vertical motion, of another scene or of another site, case by case, compared with "
        "the variant `primary.against`. `survey`: comparison of the study with a survey or a publication",
    )
    language: Language = Field(
        default="en", description="language of report, figures, films and explorer: English (`en`) or Japanese (`ja`)"
    )
    primary: PrimaryStatistic = Field(default=PrimaryStatistic(), description="the statistic that answers the question")
    records: RecordSettings = Field(description="the records")
    processing: ProcessingSteps | None = Field(
        default=None,
        description="processing steps in order; not given: the default steps for raw files, none for processed ones",
    )
    site: SoilSite | None = Field(
        default=None, description="soil above the records, which are treated as rock motions; not given: no soil"
    )
    scene: SceneChoice = Field(
        default_factory=gravestone,
        description="scene of polygons: name of a file in config/scenes, a path, or the scene itself; not given: one "
        "block. With a scene, the defaults of `height` and `b_over_h` are those of the scene, and an ensemble is run "
        "only if `ensemble` is given",
        json_schema_extra={"default": "gravestone"},
    )
    body: BodyShapeSettings | None = Field(
        default=None, description="a free 3-D body instead of a 2-D scene in vertical planes; not given: 2-D"
    )
    orientation: OrientationRange | None = Field(
        default=None,
        description="directions that a 3-D body or stack faces. With `scene`, the scene is simulated in 3-D as a stack "
        "of stones. Not given: every 5° for a body; a scene is 2-D",
    )
    azimuth: AzimuthRange = Field(
        default=AzimuthRange(),
        description="azimuths of the motion, degrees clockwise from north; a 3-D body has `orientation` instead",
    )
    b_over_h: ValueListOrRange[SlendernessBOverH] = Field(
        default=(0.2, 0.3, 0.4), description="slenderness B/H: a list, or start, stop, step"
    )
    height: ValueListOrRange[StoneHeightMetres] = Field(
        default=(0.6,), description="heights of the block, m: a list, or start, stop, step"
    )
    friction: ValueListOrRange[FrictionCoefficient] = Field(
        default=(1.0,), description="friction coefficients µ: a list, or start, stop, step"
    )
    amplitude: ValueListOrRange[AmplitudeFactor] = Field(
        default=(1.0,),
        description="factors on each whole record (with a `site`, on the motion at the surface), including 1: a list, "
        "or start, stop, step. Several factors are a dimension of the cube; the ensemble is run for factor 1 only",
    )
    density: DensityInKgPerM3 = Field(
        default=DEFAULT_STONE_DENSITY_KG_M3, gt=0, description="density of the block, kg/m³"
    )
    contact: ContactSettings = Field(
        default=ContactSettings(), description="springs, dashpots and slider at each corner"
    )
    simulation: SimulationSettings = Field(default=SimulationSettings(), description="how the cases are computed")
    ensemble: EnsembleSettings = Field(
        default=EnsembleSettings(),
        description="repetitions (members) of a case with slightly different parameters; their share that falls is a "
        "probability",
    )
    verification: Annotated[
        Annotated[Literal["none"], Tag("literal")]
        | Annotated[ConvergenceCheckSettings, Tag("settings of verification")],
        # Distinguish both forms before validation, so that a wrong key gives one message, not one for each form.
        # `no`, `off` and nothing are not settings either; they are answered with the word that is needed.
        Discriminator(lambda value: "literal" if isinstance(value, str | bool | None) else "settings of verification"),
    ] = Field(default=ConvergenceCheckSettings(), description="`none`, or settings of the convergence check")
    variants: dict[StudyOrVariantName, Variant] = Field(
        default={},
        description="the study repeated with another contact, scene, site or vertical motion, by name; each variant "
        "has its own cube, and settings that it does not give are those of the study",
    )
    published: tuple[PublishedPeaksAndBlockOutcome, ...] = Field(
        default=(), description="published values; the report compares the study with them"
    )
    population: StonePopulation | None = Field(
        default=None, description="a population of stones, whose fall rate is computed under each record"
    )
    surveys: tuple[SurveySettings, ...] = Field(
        default=(),
        description="surveys of fallen stones; the report compares each with the prediction of the study for its site",
    )

    figures: FigureSettings = Field(
        default=FigureSettings(), description="size, resolution and kinds of the figures' files"
    )
    crate: CrateMetadata = Field(
        default=CrateMetadata(), description="authors and terms, for the research crate of the results"
    )

    @model_serializer(mode="wrap")
    def _serialize_without_azimuths_of_a_stack(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Serialize the study to a dictionary, without azimuths for a 3-D stack, which has orientations instead."""
        content: dict[str, Any] = handler(self)
        if self.is_stack:
            content.pop("azimuth", None)
        return content

    @model_validator(mode="before")
    @classmethod
    def _fill_defaults_from_scene_or_body(cls, unvalidated_study_settings: Any) -> Any:
        """Set missing heights, B/H and ensemble settings of a study from its scene or 3-D body."""
        if not isinstance(unvalidated_study_settings, dict):
            return unvalidated_study_settings
        filled = {
            key: value for key, value in unvalidated_study_settings.items() if key != "scene" or value is not None
        }
        if filled.get("body") is not None:
            if filled.get("orientation") is None:
                filled["orientation"] = OrientationRange()
            return cls._fill_missing_height_and_b_over_h_from_vertices(filled)
        default = OrientationRange().model_dump(mode="json")
        if filled.keys() >= _KEYS_MARKING_STUDY_STORED_WITH_DEFAULTS and filled.get("orientation") == default:
            # A 2-D study stored by an earlier version, in which every study had orientations.
            del filled["orientation"]
        if "scene" not in filled:
            return filled
        try:
            filled["scene"] = Scene.model_validate(load_scene_if_name_or_path(unvalidated_study_settings["scene"]))
        except ValueError:
            return filled  # the field says what is wrong, and where
        height, b_over_h = rounded_reference_height_and_b_over_h(filled["scene"])
        filled.setdefault("height", [height])
        filled.setdefault("b_over_h", [b_over_h])
        filled.setdefault("ensemble", {"members": 0})
        return filled

    @staticmethod
    def _fill_missing_height_and_b_over_h_from_vertices(unvalidated_study_settings: dict[str, Any]) -> dict[str, Any]:
        """Set missing height and B/H of a study from the vertices of its 3-D body."""
        try:
            shape = BodyShapeSettings.model_validate(unvalidated_study_settings["body"]).body_shape()
        except ValidationError:
            return unvalidated_study_settings  # said where the body stands
        if not shape.slenderness_is_parameter:
            own = round(shape.solid(1.0, 1.0, 1.0).b_over_h, 10)
            if list(unvalidated_study_settings.setdefault("b_over_h", [own])) != [own]:
                raise ValueError("b_over_h: the body of these vertices has its own; leave it out")
            unvalidated_study_settings.setdefault("height", [round(getattr(shape, "unscaled_height", 1.0), 10)])
        return unvalidated_study_settings

    @field_validator("amplitude")
    @classmethod
    def _check_amplitudes_include_1(cls, motion_amplitude_factors: tuple[float, ...]) -> tuple[float, ...]:
        """Raise a ValueError unless the amplitude factors include 1, the record as recorded."""
        if 1.0 not in motion_amplitude_factors:
            raise ValueError("1 is missing: the report is of the records as recorded; add it")
        return motion_amplitude_factors

    @field_validator("variants")
    @classmethod
    def _fill_variant_contacts(cls, variants: dict[str, Variant], info: ValidationInfo) -> dict[str, Variant]:
        """Set the missing keys in the contact settings of a variant, if it has any, to those of the study."""
        own: ContactSettings = info.data.get("contact", ContactSettings())
        # What is not given is filled in, so that a filled-in study is the same when it is read again.
        return {
            name: one.model_copy(update={"contact": one.contact and one.contact.with_defaults(own)})
            for name, one in variants.items()
        }

    @field_validator("surveys")
    @classmethod
    def _set_only_record_in_surveys_without_one(
        cls, surveys: tuple[SurveySettings, ...], info: ValidationInfo
    ) -> tuple[SurveySettings, ...]:
        """Set the record of each survey that names none, if the study has only one record."""
        use: tuple[str, ...] = info.data["records"].use if "records" in info.data else ()
        if len(use) != 1:
            return surveys
        # The record is filled in, so that a filled-in study says which one it was.
        return tuple(
            survey.model_copy(update={"record": use[0] if survey.record is None else survey.record})
            for survey in surveys
        )

    @model_validator(mode="after")
    def _check_settings_are_compatible(self) -> Self:
        """Raise a ValueError with a line for each incompatible combination of settings."""
        if wrong := list(dict.fromkeys(incompatible_setting_messages(self))):
            raise ValueError(REASON_SEPARATOR.join(wrong))
        return self

    @property
    def has_several_heights_frictions_or_aspects(self) -> bool:
        """True if the study has several heights, frictions or aspects, so that one map does not show all blocks."""
        return len(self.height) * len(self.friction) * len(self.aspect_ratios_d_over_b) > 1

    @property
    def cases_per_record(self) -> int:
        """Number of cases per record: all combinations of direction, aspect, height, B/H and friction."""
        return math.prod(
            map(
                len,
                (
                    self.azimuths_or_orientations_deg,
                    self.aspect_ratios_d_over_b,
                    self.height,
                    self.b_over_h,
                    self.friction,
                ),
            )
        )

    @property
    def azimuths_or_orientations_deg(self) -> tuple[float, ...]:
        """Azimuths of the motion (2-D), or orientations of the 3-D body or stack, degrees, in ascending order."""
        if self.orientation is None:
            return tuple(self.azimuth.expand_azimuths())
        if self.body is None:
            return self.orientation.orientations_of_stack(self.scene)
        return self.orientation.orientations_of_body(self.body)

    @property
    def is_stack(self) -> bool:
        """True if the study simulates its scene in 3-D, as a stack of prisms."""
        return self.body is None and self.orientation is not None

    @property
    def aspect_ratios_d_over_b(self) -> tuple[float, ...]:
        """Aspect ratios D/B (depth over width) of the 3-D body; 1 for a 2-D study."""
        return (1.0,) if self.body is None else self.body.aspect
