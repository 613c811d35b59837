"""Directions, outcomes and numbers in the notations of field books."""

import math

import pytest

from overturning.surveys.notation import (
    COMPASS_POINTS_16,
    StatedOutcome,
    azimuth_unit_warning,
    parse_direction,
    parse_outcome,
)


@pytest.mark.parametrize(
    ("text", "azimuth"),
    [
        ("0", 0), ("125", 125), ("-10", -10), ("12.5", 12.5), ("12,5", 12.5), ("125°", 125), ("125 deg", 125),
        ("\N{MINUS SIGN}5", -5), ("S40E", 140), ("s40e", 140), ("N 25° W", 335), ("N25°W", 335), ("S 12,5 W", 192.5),
        ("N0E", 0), ("N90E", 90), ("S90W", 270), ("S0E", 180), ("N 90 W", 270),
    ],
)  # fmt: skip
def test_direction_notations_are_read_as_azimuths(text: str, azimuth: float) -> None:
    found = parse_direction(text)
    assert found.azimuth_deg == pytest.approx(azimuth)
    assert found.index_in_16_compass_points is None


def test_the_16_compass_points_are_22_5_degrees_apart() -> None:
    by_hand = {"N": 0, "NNE": 22.5, "ENE": 67.5, "E": 90, "ESE": 112.5, "SSE": 157.5, "WSW": 247.5, "NNW": 337.5}
    assert {name: parse_direction(name).azimuth_deg for name in by_hand} == by_hand
    assert [parse_direction(name.lower()).azimuth_deg for name in COMPASS_POINTS_16] == [22.5 * i for i in range(16)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("S95E", "0 to 90 degrees, as in S40E"),
        ("E40S", "quadrant bearing such as S40E"),
        ("NNNE", "one of the 16 compass points"),
        ("390", "in gon"),
        ("1e9", "from -360 to 360"),
    ],
)
def test_invalid_directions_are_refused_with_the_expected_notation(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        parse_direction(text)


@pytest.mark.parametrize(
    ("text", "kinds", "more"),
    [
        ("fell", ("fell",), {}),
        ("Fallen", ("fell",), {}),
        ("fell SE", ("fell",), {"azimuth": 135}),
        ("fell to S40E", ("fell",), {"azimuth": 140}),
        ("fell, direction not known", ("fell",), {"unknown": True}),
        ("fell direction unknown", ("fell",), {"unknown": True}),
        ("fell (direction unknown)", ("fell",), {"unknown": True}),
        ("fell in an unknown direction", ("fell",), {"unknown": True}),
        ("stands", ("stands",), {}),
        ("shifted", ("shifted",), {}),
        ("shifted 3 cm", ("shifted",), {"shift": 0.03}),
        ("shifted 25mm", ("shifted",), {"shift": 0.025}),
        ("shifted by 2,5 cm", ("shifted",), {"shift": 0.025}),
        ("twisted 10", ("twisted",), {"twist": 10}),
        ("twisted by -7.5°", ("twisted",), {"twist": -7.5}),
        ("twisted +12", ("twisted",), {"twist": 12}),
        ("twisted 12º", ("twisted",), {"twist": 12}),
        ("twisted \N{MINUS SIGN}12, broken", ("twisted", "broken"), {"twist": -12}),
        ("twisted 8 degrees anticlockwise", ("twisted",), {"twist": -8}),
        ("twisted 8 cw", ("twisted",), {"twist": 8}),
        ("shifted 3 cm, twisted 10", ("shifted", "twisted"), {"shift": 0.03, "twist": 10}),
        ("twisted 10 and shifted 12 mm", ("twisted", "shifted"), {"shift": 0.012, "twist": 10}),
        ("fell; broken", ("fell", "broken"), {}),
        ("broken + repaired", ("broken", "repaired"), {}),
        ("fixed to its base", ("fixed",), {}),
        ("?", ("unknown",), {}),
    ],
)
def test_outcome_notations_are_read_as_kinds_and_values(
    text: str, kinds: tuple[str, ...], more: dict[str, float]
) -> None:
    found = parse_outcome(text)
    expected = StatedOutcome()._replace(
        states_unknown_fall_direction=bool(more.get("unknown", False)),
        shift_m=more.get("shift", math.nan),
        clockwise_twist_deg=more.get("twist", math.nan),
    )
    assert found.kinds == kinds
    assert found.states_unknown_fall_direction == expected.states_unknown_fall_direction
    assert found.fall_direction.azimuth_deg == pytest.approx(more.get("azimuth", math.nan), nan_ok=True)
    assert found.shift_m == pytest.approx(expected.shift_m, nan_ok=True)
    assert found.clockwise_twist_deg == pytest.approx(expected.clockwise_twist_deg, nan_ok=True)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("perhaps", "write fell, fell direction unknown, stands"),
        ("stnads", "did you mean stands"),
        ("toppeld", "did you mean toppled"),
        ("shifted 3", "give the unit of the shift"),
        ("shifted 30 m", "from 0 to 10 m"),
        ("twisted 200", "from -180 to 180 degrees, clockwise positive"),
        ("twisted -8 anticlockwise", "not both"),
        ("stands, direction unknown", "only a fall has a direction"),
        ("fell, stands", "fell or stands, not both"),
        ("fell northwards", "quadrant bearing"),
        ("fell unknown", "write fell direction unknown"),
        ("fell broken", "separate several outcomes by a comma, as in fell, broken"),
        ("fell N, fell S", "fell is stated twice"),
        ("twisted 10, twisted 20", "twisted is stated twice"),
        ("shifted 3 cm and shifted 5 cm", "shifted is stated twice"),
        ("fell N; direction unknown", "gives a direction and states that it is not known"),
    ],
)
def test_invalid_outcomes_are_refused_with_the_expected_words(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        parse_outcome(text)


def test_azimuths_suggesting_radians_give_a_warning_from_three_values_on() -> None:
    assert azimuth_unit_warning("azimuth_deg", [0.5, 1.5, 0.5, math.nan], "a.csv") == ""
    assert azimuth_unit_warning("azimuth_deg", [0.5, 1.5, 2.5], "a.csv").endswith("57.29578")
