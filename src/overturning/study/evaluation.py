"""Sections of a study file for the evaluation of outcomes: figures, question, comparisons, population."""

import datetime
from typing import Annotated, Final, Literal

from pydantic import Field, field_validator

from overturning.model.element import LowercaseHyphenName
from overturning.quantities import Degree, Metre
from overturning.records.site import SoilSite
from overturning.validation import StrictModel

FIGURE_FILE_FORMATS: Final = ("svg", "png", "pdf")


class FigureSettings(StrictModel):
    """Size, resolution and formats of the figures of a study."""

    size: float = Field(default=1.0, ge=0.5, le=4, description="factor on the size of the figures; the font size stays")
    dpi: int = Field(
        default=200,
        ge=50,
        le=1200,
        description="dots per inch of PNG files, and of the cells of polar maps in SVG and PDF",
    )
    formats: tuple[Literal["svg", "png", "pdf"], ...] = Field(
        default=("svg",),
        description="file formats, from svg, png and pdf; svg is always written for the report, and is the only format "
        "of illustrative cases",
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
    def _sort_figure_formats_and_add_svg(cls, figure_file_formats: tuple[str, ...]) -> tuple[str, ...]:
        """Return the file formats for figures in a fixed order, with SVG added if it is not among them."""
        return tuple(kind for kind in FIGURE_FILE_FORMATS if kind == "svg" or kind in figure_file_formats)


class CrateMetadata(StrictModel):
    """Licence, date and authors for the research data package (RO-Crate) of the results."""

    licence: str = Field(
        default="",
        description="licence of the results, or its URL: https://spdx.org/licenses/CC-BY-4.0",
    )
    date: datetime.date | None = Field(
        default=None, description="day of publication; not given: release date of this version of overturning"
    )
    authors: tuple[Annotated[str, Field(min_length=1)], ...] = Field(default=(), description="names of the authors")


class PublishedPeaksAndBlockOutcome(StrictModel):
    """Published peaks and outcome for one component of a record, with which the study is compared."""

    record: str = Field(description="id of the record")
    azimuth: Degree = Field(description="azimuth of the component, one of the study's, degrees clockwise from north")
    label: str = Field(default="", description="name of the component, for instance N60E")
    pga_gal: float | None = Field(default=None, gt=0, description="peak ground acceleration, Gal")
    pgv_cm_s: float | None = Field(default=None, gt=0, description="peak ground velocity, cm/s")
    pgd_cm: float | None = Field(default=None, gt=0, description="peak ground displacement, cm")
    b_over_h: float = Field(gt=0, description="B/H of the block with a published outcome, one of the study's")
    overturns: bool = Field(description="`true` if the block overturns")


QuestionKind = Literal["direction", "reference", "vertical", "scene", "site", "survey"]
"""Kinds of questions."""

Language = Literal["en", "ja"]
"""Languages of a report, by their code of ISO 639-1."""

QUESTIONS_COMPARING_VARIANT_WITH_STUDY: Final = ("vertical", "scene", "site")
"""Questions that compare a variant with the study, named after the setting that the variant changes."""


class PrimaryStatistic(StrictModel):
    """Statistic that answers a study's question; it is chosen before the results are known."""

    statistic: Literal["alignment", "share", "fall_rate", "published"] = Field(
        default="alignment",
        description="the one statistic that answers the question, chosen before the results are seen. `alignment`: "
        "of falls with the fault normal (mean of cos 2Δ, Δ the angle between them), of the records with "
        "a velocity pulse if the others are their control. `share`: of the cases that overturn. "
        "`fall_rate`: of the population. `published`: share of published outcomes that are reproduced",
    )
    against: LowercaseHyphenName | None = Field(
        default=None, description="variant whose share or fall rate is subtracted from that of the study"
    )


class SurveySettings(StrictModel):
    """Survey of fallen stones, with which the study's predicted falls at the site of the survey are compared."""

    stones: str = Field(
        min_length=1, description="survey of fallen stones (CSV, see docs/formats.md); path from the project's folder"
    )
    record: str | None = Field(
        default=None, description="id of the record of the site; not needed if the study has only one record"
    )
    site: SoilSite | None = Field(
        default=None,
        description="soil layers below the stones, as in `site` of a study; the record is the motion of the rock. Not "
        "given: the record as it is",
    )
    sites: dict[str, SoilSite] = Field(
        default={},
        description="soil layers below single cemeteries, by the name in the column `site` of the survey; the other "
        "cemeteries have those of `site`",
    )
    background: float = Field(default=0.05, ge=0, lt=1, description="share of stones assumed to fall at random")
    backwards: bool = Field(
        default=True,
        description="also estimate the motion from the survey; may take some minutes, once for stones of these "
        "sizes. `false`: compare only",
    )
