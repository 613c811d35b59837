"""Values as a study file has them: ranges and azimuths."""

from typing import Annotated, Any, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from overturning.quantities import Degree
from overturning.validation import StrictModel

_MAX_VALUES_IN_RANGE = 100_000
_MAX_AZIMUTHS_IN_RANGE = 36_000

_WHOLE_DEGREE_STEPS_DIVIDING_360 = tuple(step for step in range(1, 181) if 360 % step == 0)


class ValueRange(StrictModel):
    """Range of values from start to stop by step; stop is included if a whole number of steps leads to it."""

    start: float = Field(description="first value")
    stop: float = Field(description="last value, included where a step meets it")
    step: float = Field(gt=0, description="distance between values")

    @model_validator(mode="after")
    def _check_order_and_value_count(self) -> Self:
        """Raise a ValueError if stop lies below start, or if the range has too many values."""
        if self.stop < self.start:
            raise ValueError(f"empty range: stop {self.stop:g} lies below start {self.start:g}")
        if (self.stop - self.start) / self.step > _MAX_VALUES_IN_RANGE:
            raise ValueError(f"more than {_MAX_VALUES_IN_RANGE} values; use a larger step")
        return self

    def expand_values(self) -> tuple[float, ...]:
        """Return all values of the range, rounded to 1e-10 so that 0.1 + 2 · 0.05 gives exactly 0.2."""
        count = int(np.floor((self.stop - self.start) / self.step + 1e-9)) + 1
        return tuple(round(self.start + index * self.step, 10) for index in range(count))


class AzimuthRange(StrictModel):
    """Azimuths, degrees, from start by step to below stop (360° is the same as 0°), and the values of ``also``."""

    start: Degree = Field(default=0.0, ge=0, lt=360, description="first azimuth, degrees clockwise from north")
    stop: Degree = Field(default=360.0, gt=0, le=360, description="end of the range, excluded")
    step: Degree = Field(default=5.0, gt=0, le=360, description="distance between azimuths, degrees")
    also: tuple[Degree, ...] = Field(
        default=(), description="additional azimuths, degrees, for example those of a publication"
    )

    @model_validator(mode="after")
    def _check_order_count_and_step_closing_circle(self) -> Self:
        """Raise a ValueError if the range is empty, too long, or a full circle that the step does not divide evenly."""
        if self.stop <= self.start:
            raise ValueError(f"empty range: stop {self.stop:g} does not lie above start {self.start:g}")
        steps = (self.stop - self.start) / self.step
        if steps > _MAX_AZIMUTHS_IN_RANGE:
            raise ValueError(f"more than {_MAX_AZIMUTHS_IN_RANGE:,} azimuths; use a larger step")
        if self.stop - self.start == 360.0 and abs(steps - round(steps)) > 1e-9:
            near = sorted(_WHOLE_DEGREE_STEPS_DIVIDING_360, key=lambda step: abs(step - self.step))[:2]
            fitting = " or ".join(f"{step:g}" for step in sorted(near))
            raise ValueError(f"step {self.step:g}° does not close the circle; take {fitting}, whose multiple is 360°")
        return self

    def expand_azimuths(self) -> tuple[float, ...]:
        """Return all azimuths of the range, degrees, in ascending order and without repetition."""
        count = int(np.ceil((self.stop - self.start) / self.step - 1e-9))
        grid = {round(self.start + index * self.step, 10) for index in range(count)}
        return tuple(sorted(grid | {round(azimuth % 360.0, 10) for azimuth in self.also}))


def _to_value_list(value_or_range_in_study_file: Any) -> Any:
    """Convert the value of a study setting, a range or single number, to a list of values; a list stays unchanged."""
    if isinstance(value_or_range_in_study_file, dict):
        return ValueRange.model_validate(value_or_range_in_study_file).expand_values()
    return (
        [value_or_range_in_study_file]
        if isinstance(value_or_range_in_study_file, int | float | str)
        else value_or_range_in_study_file
    )


def _sort_and_check_unique_values(setting_values: tuple[float, ...]) -> tuple[float, ...]:
    """Sort the values of a setting; raise a ValueError if there are none, or if one occurs twice."""
    if not setting_values:
        raise ValueError("empty list; give at least one value")
    if len(set(setting_values)) != len(setting_values):
        raise ValueError(f"a value stands twice in {list(setting_values)}")
    return tuple(sorted(setting_values))


_Value = TypeVar("_Value", bound=float)
ValueListOrRange = Annotated[
    tuple[_Value, ...], BeforeValidator(_to_value_list), AfterValidator(_sort_and_check_unique_values)
]
"""Type of a study setting with several values: one number, a list, or start, stop and step."""
