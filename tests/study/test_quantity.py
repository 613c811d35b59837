import pytest

from overturning.study.quantity import parse_quantity


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [
        (0.6, "m", 0.6),
        (1, "m", 1.0),
        ("0.6", "m", 0.6),
        ("60 cm", "m", 0.6),
        ("600mm", "m", 0.6),
        ("2.65 g/cm³", "kg/m³", 2650.0),
        ("3.5 kN·s/m", "N·s/m", 3500.0),
        ("1e9 N/m", "N/m", 1e9),
        ("60°", "°", 60.0),
    ],
)
def test_number_in_the_unit_of_the_key(value: object, unit: str, expected: float) -> None:
    assert parse_quantity(value, unit) == expected


@pytest.mark.parametrize("value", ["60 kg", "0.6 ft", "60 cm 3", "tall", None, True, [1.0]])
def test_wrong_unit_or_no_number_is_refused(value: object) -> None:
    with pytest.raises(ValueError, match="m"):
        parse_quantity(value, "m")
