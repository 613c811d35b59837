"""The sections of a study file that say what is made of its outcomes: figures, question, comparisons, population."""

import datetime
from typing import Annotated, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from overturning.model.cases import check_heights
from overturning.model.element import Name, StrictModel
from overturning.study.values import Degree, Metre, Second

FORMATS: Final = ("svg", "png", "pdf")


class Figures(StrictModel):
    """How the figures of a study are written: polar maps, intensity by azimuth, rose, axes, plane."""

    size: float = Field(default=1.0, ge=0.5, le=4, description="factor on the size of the figures; letters keep theirs")
    dpi: int = Field(
        default=200,
        ge=50,
        le=1200,
        description="dots per inch of PNG files, and of the cells of polar maps in SVG and PDF",
    )
    formats: tuple[Literal["svg", "png", "pdf"], ...] = Field(
        default=("svg",),
        description="kinds of files, of svg, png and pdf; svg is always written, for the report, and of time "
        "histories, illustrative cases and sites alone",
    )
    height: Metre | None = Field(
        default=None,
        gt=0,
        description="height of the block of the large maps, one of the study's; not given: the first",
    )
    friction: float | None = Field(
        default=None,
        ge=0,
        description="friction of the block of the large maps, one of the study's; not given: the last",
    )

    @field_validator("formats")
    @classmethod
    def _in_order(cls, formats: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(kind for kind in FORMATS if kind == "svg" or kind in formats)


class Crate(StrictModel):
    """What the research crate of the results says that only those know who publish them."""

    licence: str = Field(
        default="",
        description="terms of what was computed, or where they stand: https://spdx.org/licenses/CC-BY-4.0",
    )
    date: datetime.date | None = Field(
        default=None, description="day of publication; not given: that of the version of overturning, no clock's"
    )
    authors: tuple[Annotated[str, Field(min_length=1)], ...] = Field(default=(), description="names of the authors")


class Published(StrictModel):
    """What a publication states of one component, to compare the study with."""

    record: str = Field(description="id of the record")
    azimuth: Degree = Field(description="azimuth of the component, one of the study's, degrees clockwise from north")
    label: str = Field(default="", description="name of the component, for instance N60E")
    pga_gal: float | None = Field(default=None, gt=0, description="peak ground acceleration, Gal")
    pgv_cm_s: float | None = Field(default=None, gt=0, description="peak ground velocity, cm/s")
    pgd_cm: float | None = Field(default=None, gt=0, description="peak ground displacement, cm")
    b_over_h: float = Field(gt=0, description="slenderness of the block whose outcome is stated, one of the study's")
    overturns: bool = Field(description="whether the block overturns")


Asks = Literal["direction", "reference", "vertical", "scene", "site", "survey"]
"""Kinds of questions."""

CONTRASTS: Final = ("vertical", "scene", "site")
"""Those of a variant beside the study, named like what the variant changes."""


class Primary(StrictModel):
    """The one statistic that answers a study's question; all others are called secondary."""

    statistic: Literal["alignment", "share", "fall_rate", "published"] = Field(
        default="alignment",
        description="the one statistic that answers the question, chosen before the results are seen: `alignment` of "
        "falls with the fault normal, of the records with a velocity pulse where others are their control; `share` of "
        "the cases that overturn; `fall_rate` of the population; `published` outcomes that are found again",
    )
    against: Name | None = Field(
        default=None, description="variant whose share or fall rate is taken from the study's own"
    )


class Survey(StrictModel):
    """Stones that somebody has found fallen, to compare with what the study predicts for their site."""

    stones: str = Field(
        min_length=1, description="survey of fallen stones (CSV, see docs/formats.md); path from the project's folder"
    )
    record: str | None = Field(
        default=None, description="id of the site's record; not needed where the study has one record only"
    )
    background: float = Field(default=0.05, ge=0, lt=1, description="share of the stones taken to fall any way")
    backwards: bool = Field(
        default=True,
        description="search for the motion that the stones ask for, too: minutes to an hour, once for stones of such "
        "sizes; false: compare only",
    )


class Spread(StrictModel):
    """Values spread evenly between two ends."""

    low: float = Field(gt=0, description="lowest value")
    high: float = Field(gt=0, description="highest value")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.high < self.low:
            raise ValueError(f"high {self.high:g} lies below low {self.low:g}; exchange them")
        return self


class Population(StrictModel):
    """A cemetery: the distribution of its stones, and how strongly each record is to shake it."""

    width: Spread = Field(default=Spread(low=0.3, high=0.4), description="widths of the square shafts, m: low, high")
    height: Spread = Field(default=Spread(low=0.6, high=0.9), description="heights of the shafts, m: low, high")
    friction: Spread = Field(default=Spread(low=0.5, high=0.9), description="friction coefficients µ: low, high")
    fixed: float = Field(default=0.0, ge=0, lt=1, description="share of stones fixed to their base, which do not fall")
    face: Degree | None = Field(
        default=None, description="azimuth that the faces look to, degrees; not given: stones look any way"
    )
    face_spread: Degree = Field(
        default=10.0, ge=0, le=180, description="half-width of the faces' azimuths about `face`, degrees"
    )
    shifted: Metre = Field(default=0.01, gt=0, description="residual slip from which a standing stone is shifted, m")
    rotated: Degree = Field(
        default=5.0, gt=0, le=180, description="turn about the vertical from which a standing stone is rotated, degrees"
    )
    period: tuple[Annotated[Second, Field(ge=0.01, le=10)], ...] = Field(
        default=(), description="periods of Sa(T), s, over which there are fragility curves beside PGA and PGV"
    )
    stones: int = Field(default=256, ge=16, le=65536, description="stones drawn, the same under every record")
    seed: int = Field(default=1, ge=0, description="seed of the draw")

    @model_validator(mode="after")
    def _spread_about_a_face(self) -> Self:
        if self.face is None and self.face_spread != Population.model_fields["face_spread"].default:
            raise ValueError(f"face_spread {self.face_spread:g}° is about `face`, which is not given; give it")
        return self

    @field_validator("height")
    @classmethod
    def _of_stones(cls, height: Spread) -> Spread:
        check_heights([height.low, height.high])
        return height
