"""The population of a study: what stands in the cemetery, instead of one stone after another."""

from typing import Self

from pydantic import Field, field_validator, model_validator

from overturning.dem.cases import check_heights
from overturning.dem.element import Model
from overturning.study.quantity import Degree, Metre


class Spread(Model):
    """Values spread evenly between two ends."""

    low: float = Field(gt=0, description="lowest value")
    high: float = Field(gt=0, description="highest value")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.high < self.low:
            raise ValueError(f"high {self.high:g} lies below low {self.low:g}; exchange them")
        return self


class Population(Model):
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
    stones: int = Field(default=256, ge=16, le=65536, description="stones drawn, the same under every record")
    seed: int = Field(default=1, ge=0, description="seed of the draw")

    @field_validator("height")
    @classmethod
    def _of_stones(cls, height: Spread) -> Spread:
        check_heights([height.low, height.high])
        return height
