"""Values as a study file has them: numbers with units, ranges, azimuths.

A plain number is in the key's own unit, a text may name another one.
"""

import re
from functools import partial
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from overturning.model.element import StrictModel

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"

# Unit names and their factor to the key's own unit.
_UNITS: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "kg/m³": dict.fromkeys(("kg/m³", "kg/m3", "kg/m^3"), 1.0)
    | dict.fromkeys(("g/cm³", "g/cm3", "t/m³", "t/m3"), 1000.0),
    "°": {"°": 1.0, "deg": 1.0, "degree": 1.0, "degrees": 1.0},
    "N/m": {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "GN/m": 1e9},
    "N·s/m": {"N·s/m": 1.0, "N*s/m": 1.0, "N s/m": 1.0, "kN·s/m": 1e3, "kN*s/m": 1e3},
    "rad": {"rad": 1.0, "mrad": 1e-3},
}


def parse_quantity(value: object, unit: str) -> float:
    """Convert a number, or a text such as ``"60 cm"``, to a number in `unit`; a ValueError lists the units that fit."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError(f"give a number in {unit}")
    if not isinstance(value, str):
        return float(value)
    match = re.fullmatch(rf"\s*({_NUMBER})\s*(.*?)\s*", value)
    if match is None:
        raise ValueError(f"give a number in {unit}")
    factor = 1.0 if match[2] == "" else _UNITS[unit].get(match[2])
    if factor is None:
        raise ValueError(f"unit {match[2]!r} does not fit; use {unit} or one of {', '.join(_UNITS[unit])}")
    # Dividing by the inverse keeps 60 cm at exactly 0.6 m.
    return float(match[1]) * factor if factor >= 1 else float(match[1]) / round(1 / factor)


def _in(unit: str) -> tuple[Any, Any]:
    """Return a validator that reads a number in `unit`, and a field that has the unit in the schema."""
    read = BeforeValidator(partial(parse_quantity, unit=unit), json_schema_input_type=float | str)
    return read, Field(json_schema_extra={"unit": unit})


Metre = Annotated[float, *_in("m")]
Second = Annotated[float, *_in("s")]
Density = Annotated[float, *_in("kg/m³")]
Degree = Annotated[float, *_in("°")]
Stiffness = Annotated[float, *_in("N/m")]
Damping = Annotated[float, *_in("N·s/m")]
Radian = Annotated[float, *_in("rad")]

_MAX_VALUES = 100_000
_MAX_AZIMUTHS = 36_000

_WHOLE_STEPS = tuple(step for step in range(1, 181) if 360 % step == 0)


class Range(StrictModel):
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
        """Return the values, rounded to 1e-10 so that 0.1 + 2 · 0.05 is 0.2."""
        count = int(np.floor((self.stop - self.start) / self.step + 1e-9)) + 1
        return tuple(round(self.start + index * self.step, 10) for index in range(count))


class AzimuthRange(StrictModel):
    """Azimuths from start by step up to stop, which is excluded: 0° and 360° are the same direction."""

    start: Degree = Field(default=0.0, ge=0, lt=360, description="first azimuth, degrees clockwise from north")
    stop: Degree = Field(default=360.0, gt=0, le=360, description="end of the range, excluded")
    step: Degree = Field(default=5.0, gt=0, le=360, description="distance between azimuths, degrees")
    also: tuple[Degree, ...] = Field(
        default=(), description="additional azimuths, degrees, for example those of a publication"
    )

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if self.stop <= self.start:
            raise ValueError(f"empty range: stop {self.stop:g} does not lie above start {self.start:g}")
        steps = (self.stop - self.start) / self.step
        if steps > _MAX_AZIMUTHS:
            raise ValueError(f"more than {_MAX_AZIMUTHS:,} azimuths; use a larger step")
        if self.stop - self.start == 360.0 and abs(steps - round(steps)) > 1e-9:
            near = sorted(_WHOLE_STEPS, key=lambda step: abs(step - self.step))[:2]
            fitting = " or ".join(f"{step:g}" for step in sorted(near))
            raise ValueError(f"step {self.step:g}° does not close the circle; take {fitting}, whose multiple is 360°")
        return self

    def values(self) -> tuple[float, ...]:
        """Return the azimuths, ascending, each once."""
        count = int(np.ceil((self.stop - self.start) / self.step - 1e-9))
        grid = {round(self.start + index * self.step, 10) for index in range(count)}
        return tuple(sorted(grid | {round(azimuth % 360.0, 10) for azimuth in self.also}))


def _listed(value: Any) -> Any:
    """Convert a range or a single value to a list; a list is returned unchanged."""
    if isinstance(value, dict):
        return Range.model_validate(value).values()
    return [value] if isinstance(value, int | float | str) else value


def _ascending(values: tuple[float, ...]) -> tuple[float, ...]:
    """Sort values; a ValueError if there are none, or if one is repeated."""
    if not values:
        raise ValueError("empty list; give at least one value")
    if len(set(values)) != len(values):
        raise ValueError(f"a value stands twice in {list(values)}")
    return tuple(sorted(values))


_Value = TypeVar("_Value", bound=float)
Values = Annotated[tuple[_Value, ...], BeforeValidator(_listed), AfterValidator(_ascending)]
"""Values as a study gives them: one, a list, or start, stop and step."""
