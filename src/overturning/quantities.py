"""Numbers with units in files: a plain number is in the key's own unit, a text may name another one."""

import re
from functools import partial
from numbers import Real
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

_NUMBER_PATTERN = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"

# Unit names and their factor to the key's own unit.
_FACTORS_BY_KEY_UNIT_AND_GIVEN_UNIT: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "kg/m³": dict.fromkeys(("kg/m³", "kg/m3", "kg/m^3"), 1.0)
    | dict.fromkeys(("g/cm³", "g/cm3", "t/m³", "t/m3"), 1000.0),
    "°": {"°": 1.0, "deg": 1.0, "degree": 1.0, "degrees": 1.0},
    "N/m": {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "GN/m": 1e9},
    "N·s/m": {"N·s/m": 1.0, "N*s/m": 1.0, "N s/m": 1.0, "kN·s/m": 1e3, "kN*s/m": 1e3},
    "rad": {"rad": 1.0, "mrad": 1e-3},
}


def parse_quantity(number_or_text_with_unit: object, target_unit: str) -> float:
    """Convert a number in `target_unit`, or a text such as ``"60 cm"``, to a number in `target_unit`.

    A text with a unit of another kind raises a ValueError.
    """
    if isinstance(number_or_text_with_unit, bool) or not isinstance(number_or_text_with_unit, Real | str):
        raise ValueError(f"give a number in {target_unit}")
    if not isinstance(number_or_text_with_unit, str):
        return float(number_or_text_with_unit)
    match = re.fullmatch(rf"\s*({_NUMBER_PATTERN})\s*(.*?)\s*", number_or_text_with_unit)
    if match is None:
        raise ValueError(f"give a number in {target_unit}")
    factor = 1.0 if match[2] == "" else _FACTORS_BY_KEY_UNIT_AND_GIVEN_UNIT[target_unit].get(match[2])
    if factor is None:
        raise ValueError(
            f"unit {match[2]!r} does not fit; use {target_unit} or one of "
            f"{', '.join(_FACTORS_BY_KEY_UNIT_AND_GIVEN_UNIT[target_unit])}"
        )
    # Dividing by the inverse keeps 60 cm at exactly 0.6 m.
    return float(match[1]) * factor if factor >= 1 else float(match[1]) / round(1 / factor)


def _unit_validator_and_schema_field(unit: str) -> tuple[Any, Any]:
    """Return pydantic annotations for a quantity: a validator that converts to `unit`, and the unit in the schema."""
    read = BeforeValidator(partial(parse_quantity, target_unit=unit), json_schema_input_type=float | str)
    return read, Field(json_schema_extra={"unit": unit})


Metre = Annotated[float, *_unit_validator_and_schema_field("m")]
Second = Annotated[float, *_unit_validator_and_schema_field("s")]
DensityInKgPerM3 = Annotated[float, *_unit_validator_and_schema_field("kg/m³")]
Degree = Annotated[float, *_unit_validator_and_schema_field("°")]
StiffnessInNPerM = Annotated[float, *_unit_validator_and_schema_field("N/m")]
DampingInNSPerM = Annotated[float, *_unit_validator_and_schema_field("N·s/m")]
Radian = Annotated[float, *_unit_validator_and_schema_field("rad")]
