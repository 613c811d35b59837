"""The first film shows two blocks that both move."""

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.differing_cases import clearest_case_with_differing_outcomes
from overturning.statistics.illustrative import (
    ANY_ELEMENT_FALLS_VARIABLE,
    BOTH_SIDES_CASE_TITLE,
    FALLS_IN_ONE_VARIANT_ONLY_RULE,
    OPPOSITE_FALLS_IN_TWO_VARIANTS_RULE,
    find_best_case_for_each_behaviour,
)


@pytest.fixture
def illustrative_b_over_h_from_peak_rotations(make_cube_from_fall_rules) -> Callable[[list[float]], dict[str, float]]:
    """Return a function from the peak rotations of two blocks to the B/H of illustrative cases, by case title.

    Both blocks, of B/H 0.2 and 0.4, fall along the fault normal, 0°, and stand along the fault. The given peak
    rotations are those along the fault.
    """

    def b_over_h_of_cases(peak_rotations: list[float]) -> dict[str, float]:
        cube = make_cube_from_fall_rules(
            lambda azimuth, *_: np.cos(np.radians(azimuth)).round(), azimuth=[0, 90, 180, 270], height=[0.6],
            b_over_h=[0.2, 0.4], friction=[1.0], fault_normal=0.0,
        )  # fmt: skip
        rotation = xr.where(cube["overturned"] == 0, xr.DataArray(peak_rotations, dims="b_over_h"), 1.0)
        cube["peak_rotation"] = rotation.transpose(*cube["overturned"].dims)
        return {case.title: case.block_coordinates["b_over_h"] for case in find_best_case_for_each_behaviour(cube)}

    return b_over_h_of_cases


def illustrative_case_of_opposite_falls(cube: xr.Dataset) -> tuple[dict[str, float], tuple[float, ...]] | None:
    """Return the block and azimuths of the illustrative case of falls to opposite sides, or None.

    The azimuths are the neighbouring ones at which the block falls to opposite sides.
    """
    found = {
        case.title: (case.block_coordinates, case.panel_azimuths_deg)
        for case in find_best_case_for_each_behaviour(cube)
    }
    return found.get(BOTH_SIDES_CASE_TITLE)


def test_case_of_opposite_falls_exists_only_if_a_block_falls_to_both_sides(make_cube_from_fall_rules) -> None:
    """A case of opposite falls exists only if a block falls to opposite sides at neighbouring azimuths.

    The broad block falls away from the azimuth at 40° only, the slender one at 40° and 60°; elsewhere both fall
    towards the azimuth. In the ensembles only the slender one falls in every member.
    """

    def falls_near_axis_signed_by_half_circle(
        azimuth: np.ndarray, _: np.ndarray, broad: np.ndarray, __: np.ndarray
    ) -> np.ndarray:
        return np.where((azimuth == 40) | ((azimuth == 60) & (broad == 0.2)), -1.0, 1.0)

    grid = {"azimuth": list(range(0, 180, 20)), "height": [0.6], "b_over_h": [0.2, 0.4], "friction": [1.0]}
    cube = make_cube_from_fall_rules(falls_near_axis_signed_by_half_circle, **grid)
    assert illustrative_case_of_opposite_falls(cube) == (
        {"height": 0.6, "b_over_h": 0.4, "friction": 1.0},
        (40.0, 60.0),
    )
    chance = abs(cube["overturned"]).where(cube["b_over_h"] < 0.3, 0.6)
    likely = cube.assign(
        probability_towards=chance.where(cube["overturned"] > 0, 0.0),
        probability_away=chance.where(cube["overturned"] < 0, 0.0),
    )
    assert illustrative_case_of_opposite_falls(likely) == (
        {"height": 0.6, "b_over_h": 0.2, "friction": 1.0},
        (60.0, 80.0),
    )
    assert (
        illustrative_case_of_opposite_falls(
            make_cube_from_fall_rules(lambda azimuth, *_: np.ones_like(azimuth), **grid)
        )
        is None
    )
    assert (
        illustrative_case_of_opposite_falls(cube.where(cube["azimuth"] % 40 == 0, 0.0)) is None
    )  # none beside another


@pytest.mark.parametrize(("first", "side"), [(0, -1), (30, -1), (10, -1), (0, 1), (20, 1)])
def test_falls_at_right_angles_are_not_more_than_90_degrees_apart(
    make_cube_from_fall_rules, first: int, side: int
) -> None:
    """Falls to φ in one plane and to φ ± 90° in another are not opposite, whatever the rounding of cosines."""
    grid = {"azimuth": [first, first + 90], "height": [0.6], "b_over_h": [0.2], "friction": [1.0]}
    assert (
        illustrative_case_of_opposite_falls(
            make_cube_from_fall_rules(lambda azimuth, *_: np.where(azimuth == first, 1.0, side), **grid)
        )
        is None
    )


@pytest.mark.parametrize(
    ("rotations", "expected"),
    [([0.5, 0.0], 0.2), ([0.5, 0.5], 0.4), ([0.0, 0.0], 0.4)],
    ids=["the one that rocks along the fault too", "of those the broadest", "where none rocks one that only stands"],
)
def test_fault_normal_example_prefers_blocks_that_also_rock_along_the_fault(
    illustrative_b_over_h_from_peak_rotations, rotations: list[float], expected: float
) -> None:
    assert (
        illustrative_b_over_h_from_peak_rotations(rotations)["Falls normal to the fault, stands along it"] == expected
    )


@pytest.mark.parametrize(("rotations", "expected"), [([0.3, 0.7], 0.4), ([0.3, 0.0], 0.2), ([0.05, 0.0], None)])
def test_example_nearest_to_falling_has_the_largest_rotation_while_standing(
    illustrative_b_over_h_from_peak_rotations, rotations: list[float], expected: float
) -> None:
    assert illustrative_b_over_h_from_peak_rotations(rotations).get("Leans furthest of all that stand") == expected


@pytest.mark.parametrize(("turn", "titles"), [(-0.2, ["Stands, and has turned"]), (0.04, [])])
def test_twists_below_the_printed_resolution_make_no_illustrative_case(
    make_cube_from_fall_rules, turn: float, titles: list[str]
) -> None:
    cube = make_cube_from_fall_rules(
        lambda azimuth, *_: 0 * azimuth, azimuth=[0, 45], height=[0.6], b_over_h=[0.3], friction=[1.0]
    )
    still = cube.rename(azimuth="orientation").expand_dims(aspect=[1.0])
    still = still.assign(residual_twist=still["overturned"] + turn, fall_azimuth=still["overturned"] * np.nan)
    assert [case.title for case in find_best_case_for_each_behaviour(still)] == titles


def test_a_case_where_another_stone_falls_is_no_standing_example(make_cube_from_fall_rules) -> None:
    """A lower stone is no example of a standing stone if the upper one falls, since the film shows all stones."""
    cube = make_cube_from_fall_rules(
        lambda azimuth, *_: 0 * azimuth, azimuth=[0, 45], height=[0.6], b_over_h=[0.3], friction=[1.0]
    )
    still = cube.rename(azimuth="orientation").expand_dims(aspect=[1.0])
    turn = still["overturned"] + xr.where(still["orientation"] == 0, 8.0, 3.0)
    still = still.assign(residual_twist=turn, fall_azimuth=still["overturned"] * np.nan)
    other_falls = xr.broadcast(still["orientation"] == 0, still["overturned"])[0]
    (before,) = find_best_case_for_each_behaviour(still)
    (after,) = find_best_case_for_each_behaviour(still.assign({ANY_ELEMENT_FALLS_VARIABLE: other_falls}))
    assert (before.panel_azimuths_deg, after.panel_azimuths_deg) == ((0.0,), (45.0,))


CUBE_GRID = {"azimuth": list(range(0, 360, 30)), "height": [0.6], "b_over_h": [0.2, 0.3, 0.4], "friction": [1.0]}


def test_example_of_two_differing_settings_falls_in_one_of_them_only(make_cube_from_fall_rules) -> None:
    """The example case falls in the second setting only, as do most cases that differ and its neighbours."""

    def falls_in_first_setting(azimuth: np.ndarray, _: np.ndarray, broad: np.ndarray, __: np.ndarray) -> np.ndarray:
        return np.where(broad < 0.25, 1.0, 0.0) + 0 * azimuth

    def fall_rule_of_second_setting(
        azimuth: np.ndarray, _: np.ndarray, broad: np.ndarray, __: np.ndarray
    ) -> np.ndarray:
        falls = (broad < 0.25) & (azimuth % 180 != 150) | (broad < 0.35) & (azimuth % 180 > 20) & (azimuth % 180 < 100)
        return np.where(falls, 1.0, 0.0)

    cube, other = (
        make_cube_from_fall_rules(each, **CUBE_GRID, fault_normal=0.0)
        for each in (falls_in_first_setting, fall_rule_of_second_setting)
    )
    rocks = xr.full_like(cube["overturned"], 0.5)
    case = clearest_case_with_differing_outcomes(
        cube.assign(peak_rotation=rocks), other.assign(peak_rotation=rocks), ("nominal", "other")
    )
    assert case is not None
    assert (case.title, case.variant_name_by_panel) == (FALLS_IN_ONE_VARIANT_ONLY_RULE.case_title, ("nominal", "other"))
    assert case.block_coordinates["b_over_h"] == 0.3, "most of those that differ fall in the other setting only"
    assert case.panel_azimuths_deg == (60.0, 60.0), "its neighbours at 30° and 90° differ, too"


def test_two_settings_with_equal_outcomes_have_no_illustrative_case(make_cube_from_fall_rules) -> None:
    cube = make_cube_from_fall_rules(lambda azimuth, *_: 1.0 + 0 * azimuth, **CUBE_GRID, fault_normal=0.0)
    assert clearest_case_with_differing_outcomes(cube, cube, ("nominal", "other")) is None
    other = cube.assign(overturned=cube["overturned"].where(cube["azimuth"] != 60, -1.0))
    case = clearest_case_with_differing_outcomes(cube, other, ("nominal", "other"))
    assert case is not None
    assert (case.title, case.panel_azimuths_deg) == (
        OPPOSITE_FALLS_IN_TWO_VARIANTS_RULE.case_title,
        (60.0, 60.0),
    )
    assert case.block_coordinates["b_over_h"] in (0.3, 0.4)
