"""Settings of a study that statistics and surveys also use: the ensemble, and a population of stones."""

from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, field_validator, model_serializer, model_validator

from overturning.model.cases import check_stone_heights_within_allowed_range
from overturning.quantities import Degree, Metre, Radian, Second
from overturning.validation import StrictModel

RELATIVE_TOLERANCE_OUTSIDE_GRID: Final = 0.02
"""Share of a height, B/H or friction by which a stone may lie outside the simulated values: rounding, 1/3 as 0.33."""

MAX_LOAD_BEARING_BASE_RELIEF_M: Final = 0.03
"""Largest relief of a scanned stone (height up to which points of its base bear), m; see `overturning.model.scan`."""


class UniformRange(StrictModel):
    """Uniform distribution between a lowest and a highest value."""

    low: float = Field(gt=0, description="lowest value")
    high: float = Field(gt=0, description="highest value")

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        """Raise a ValueError if the highest value is below the lowest."""
        if self.high < self.low:
            raise ValueError(f"high {self.high:g} lies below low {self.low:g}; exchange them")
        return self


class LengthRange(UniformRange):
    """Uniform distribution of a length between a lowest and a highest value, numbers in m or texts with a unit."""

    low: Metre = Field(gt=0, description="lowest value, m")
    high: Metre = Field(gt=0, description="highest value, m")


class EnsembleSettings(StrictModel):
    """Settings of the ensemble: runs of a case with inputs from uniform distributions around the nominal values."""

    members: int = Field(
        default=24, ge=0, le=4096, description="largest number of members (runs) per case, even; 0: no ensemble"
    )
    half_width: float = Field(
        default=0.19,
        ge=0,
        lt=0.5,
        description="a case gets no further batch of 8 members once the 95 % intervals of its probabilities are within "
        "± this value; 24 members always reach 0.19; 0: all members are run",
    )
    where: Literal["boundary", "everywhere"] = Field(
        default="boundary",
        description="`boundary`: cases within two B/H steps of a change of outcome (in 3-D also of a change of fall "
        "azimuth by 30°), with a single B/H all cases; `everywhere`: all cases",
    )
    amplitude: float = Field(default=0.02, ge=0, lt=1, description="half-width of the motion's amplitude, share")
    b_over_h: float = Field(default=0.01, ge=0, lt=1, description="half-width of B/H, share")
    friction: float = Field(default=0.05, ge=0, lt=1, description="half-width of the friction coefficient, share")
    damping: float = Field(default=0.2, ge=0, lt=1, description="half-width of the contact's damping, share")
    azimuth: Degree = Field(default=2.0, ge=0, le=90, description="half-width of the sensor's azimuth, degrees")
    initial_tilt: Radian = Field(default=0.0, ge=0, lt=1.5, description="half-width of the initial tilt, rad")
    relief: LengthRange | None = Field(
        default=None,
        description="relief under the base of a scanned stone, m: low, high; uniform. Not given: every run has that of "
        "the body",
    )
    orientation: Degree = Field(
        default=0.0, ge=0, le=180, description="half-width of the orientation of a 3-D body on the ground, degrees"
    )
    seed: int = Field(default=1, ge=0, description="seed of the two scrambled sequences")

    @model_serializer(mode="wrap")
    def _leave_out_relief_and_orientation_if_unset(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Return the settings as a dictionary; relief and orientation are left out if the runs do not vary them."""
        content: dict[str, Any] = handler(self)
        unused = [name for name in ("relief", "orientation") if not content.get(name)]
        return {name: value for name, value in content.items() if name not in unused}

    def has_ensemble_runs_for_all_cases(self, b_over_h_count: int) -> bool:
        """Return True if all cases get ensemble runs, False if only cases near a change of outcome along B/H do.

        `b_over_h_count` is the number of values of B/H of the study; with one value there is no change along B/H.
        """
        return self.where == "everywhere" or b_over_h_count == 1

    @field_validator("relief")
    @classmethod
    def _check_relief_is_within_limit(cls, max_bearing_point_height_range: LengthRange | None) -> LengthRange | None:
        """Raise a ValueError if the relief of a scanned base can exceed `MAX_LOAD_BEARING_BASE_RELIEF_M`.

        The relief is the height up to which points of the base bear load.
        """
        if (
            max_bearing_point_height_range is not None
            and max_bearing_point_height_range.high > MAX_LOAD_BEARING_BASE_RELIEF_M
        ):
            raise ValueError(
                f"high {max_bearing_point_height_range.high:g} m; at most {MAX_LOAD_BEARING_BASE_RELIEF_M:g} m (the "
                f"unit is the metre)"
            )
        return max_bearing_point_height_range

    @field_validator("members")
    @classmethod
    def _check_member_count_is_even(cls, member_count: int) -> int:
        """Raise a ValueError if the number of ensemble members is odd; each Sobol sequence gives half of them."""
        if member_count % 2:
            raise ValueError("an even number is needed: half of the members belong to each of two scrambles")
        return member_count


class StonePopulation(StrictModel):
    """Population of stones, such as a cemetery: distributions of size, friction and face azimuth."""

    width: LengthRange = Field(
        default=LengthRange(low=0.3, high=0.4), description="widths of the square shafts, m: low, high"
    )
    height: LengthRange = Field(
        default=LengthRange(low=0.6, high=0.9), description="heights of the shafts, m: low, high"
    )
    friction: UniformRange = Field(
        default=UniformRange(low=0.5, high=0.9), description="friction coefficients µ: low, high"
    )
    fixed: float = Field(
        default=0.0,
        ge=0,
        lt=1,
        description="share of stones fixed to their base, which do not fall; fragility curves are of the other stones",
    )
    face: Degree | None = Field(default=None, description="azimuth of the faces, degrees; not given: random azimuths")
    face_spread: Degree = Field(
        default=10.0, ge=0, le=180, description="half-width of the faces' azimuths about `face`, degrees"
    )
    shifted: Metre = Field(default=0.01, gt=0, description="residual slip from which a standing stone is shifted, m")
    rotated: Degree = Field(
        default=5.0,
        gt=0,
        le=180,
        description="rotation about the vertical from which a standing stone counts as rotated, degrees",
    )
    period: tuple[Annotated[Second, Field(ge=0.01, le=10)], ...] = Field(
        default=(),
        description="periods of Sa(T), s, for fragility curves in addition to those for PGA, PGV and PGV/PGA",
    )
    stones: int = Field(default=256, ge=16, le=65536, description="stones drawn, the same under every record")
    seed: int = Field(default=1, ge=0, description="seed of the draw")

    @model_validator(mode="after")
    def _check_face_azimuth_if_spread_given(self) -> Self:
        """Raise a ValueError if a spread of the face azimuths is given, but no mean face azimuth."""
        if self.face is None and self.face_spread != StonePopulation.model_fields["face_spread"].default:
            raise ValueError(f"face_spread {self.face_spread:g}° is about `face`, which is not given; give it")
        return self

    @field_validator("height")
    @classmethod
    def _check_stone_heights(cls, height: LengthRange) -> LengthRange:
        """Raise an error if heights of the stone population are outside the allowed range."""
        check_stone_heights_within_allowed_range([height.low, height.high])
        return height
