"""Checks of the rotation at which a stone has fallen: outcomes that fit are accepted, others are reported."""

from functools import cache

import numpy as np
import pytest

from overturning.dem.polygon.prepare import SceneEquilibriumStiffnessAndRockingLimits, prepare_scene
from overturning.dem.run import simulate_cases
from overturning.model.cases import Cases
from overturning.model.element import ContactLaw
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.results import CaseResults
from overturning.model.scene import Scene
from tests.dem.polygon_scenes import load_shipped_scene
from tests.verification.test_stability_scenes import one_second_sine_cycle
from verification.stability.checks import (
    flags_match_rotations,
    least_possible_rotation_of_fallen_elements,
    name_of_first_failed_scene_check,
    rotations_requiring_fallen_flag,
)


def simulate_falling_case(scene: Scene) -> CaseResults:
    """Simulate a case in which the stone of a scene falls; in the three-tier grave, only the shaft falls."""
    return simulate_cases(
        scene, one_second_sine_cycle(6.0), Cases([180.0], *reference_element_height_and_b_over_h(scene), 0.7)
    )


@cache
def three_tier_grave_and_falling_case() -> tuple[SceneEquilibriumStiffnessAndRockingLimits, CaseResults]:
    """The prepared three-tier grave and the results of its falling case; tests change only copies."""
    scene = load_shipped_scene("three-tier")
    return prepare_scene(scene), simulate_falling_case(scene)


def results_with_other_rotations_and_flags(
    prepared: SceneEquilibriumStiffnessAndRockingLimits, found: CaseResults, turned_deg: list[float], flags: list[int]
) -> CaseResults:
    """Return results with other rotations and flags, and overturning times that fit them."""
    rotation = np.radians([turned_deg]) / prepared.tipping_angles_or_one_degree_in_rad[prepared.free_element_indices]
    times = np.where(np.array([flags]) != 0, 3.0, np.nan)
    changed = {
        "peak_rotation": rotation,
        "overturned": np.array([flags], np.int8),
        "overturning_time": times.astype(np.float32),
    }
    return CaseResults(**vars(found) | changed)


@pytest.mark.parametrize(
    ("turned_deg", "flags", "fits"),
    [
        ([3.0, 90.0, 90.0], [0, 1, -1], True),
        ([3.0, 40.0, 89.95], [0, 0, 1], True),  # caught on its last hundredth
        ([3.0, 40.0, 89.95], [0, 0, 0], True),  # the same, not yet counted
        ([3.0, 40.0, 20.0], [0, 0, 1], True),  # without what carried it
        ([3.0, 40.0, 20.0], [1, 0, 1], False),  # on the ground
        ([3.0, 90.0, 90.0], [0, 0, 1], False),
        ([3.0, 89.9999995, 90.0], [0, 0, 1], False),  # lies flat
        ([3.0, 89.9999995, 90.0], [0, 1, 1], True),
        ([3.0, 40.0, 90.0], [1, 0, 1], False),
    ],
)
def test_overturning_flags_that_contradict_the_rotations_are_reported(
    turned_deg: list[float], flags: list[int], fits: bool
) -> None:
    prepared, found = three_tier_grave_and_falling_case()
    answer = results_with_other_rotations_and_flags(prepared, found, turned_deg, flags)
    assert name_of_first_failed_scene_check(prepared, 0.7, one_second_sine_cycle(6.0), answer) == (
        "" if fits else "flag and rotation"
    )


def test_a_block_with_softer_contact_lies_flat_at_a_smaller_rotation() -> None:
    """A block of height H and static penetration δ counts as fallen from arcsin(δ/H) short of 90°.

    The static penetration δ is given as a share of the width B.
    """
    for share in (1e-4, 1e-2):
        law = ContactLaw(between=("stone", "stone"), static_penetration=share)
        scene = load_shipped_scene("gravestone").model_copy(update={"contacts": (law,)})
        short = np.arcsin(share * reference_element_height_and_b_over_h(scene)[1])
        assert 0.5 * np.pi - rotations_requiring_fallen_flag(prepare_scene(scene)) == pytest.approx(short, rel=1e-6)
        assert least_possible_rotation_of_fallen_elements(prepare_scene(scene)) == pytest.approx(np.arctan(0.4))


def test_a_boulder_counts_as_fallen_when_it_lies_on_its_next_side() -> None:
    """A boulder counts as fallen when it has rotated by the inclination of the face next to its base.

    The faces from (0.22, 0) to (0.52, 0.31) and from (−0.18, 0) to (−0.56, 0.47) reach the ground when the boulder
    has rotated by their inclinations.

    Results hold rotations without their signs: only beyond the larger inclination has the boulder certainly fallen.
    """
    prepared = prepare_scene(load_shipped_scene("boulder"))
    comes_down = np.arctan2(0.47, 0.38)
    assert prepared.elements[-1].fall_rotations_to_minus_and_plus_x_rad == pytest.approx(
        (comes_down, np.arctan2(0.31, 0.30)), abs=1e-9
    )
    assert rotations_requiring_fallen_flag(prepared)[0] == pytest.approx(comes_down, abs=1e-4)
    assert 0.1 < least_possible_rotation_of_fallen_elements(prepared)[0] < 0.5 * comes_down
    assert not flags_match_rotations(prepared, np.array([False]), np.array([comes_down]))
    assert flags_match_rotations(prepared, np.array([False]), np.array([0.9 * comes_down]))
    assert not flags_match_rotations(prepared, np.array([True]), np.array([0.09]))


def test_the_rotation_that_a_scene_defines_as_fallen_is_used() -> None:
    scene = load_shipped_scene("gravestone")
    tips = np.degrees(np.arctan(0.4))
    for asked, drop, early, lying in ((60.0, None, tips, 60.0), (120.0, None, tips, np.inf), (90.0, 0.2, 0.0, 90.0)):
        elements = [
            item
            if item.kind == "driven"
            else item.model_copy(update={"fallen_rotation_deg": asked, "fallen_drop": drop})
            for item in scene.elements
        ]
        prepared = prepare_scene(scene.model_copy(update={"elements": tuple(elements)}))
        assert np.degrees(least_possible_rotation_of_fallen_elements(prepared)) == pytest.approx(early)
        assert np.degrees(rotations_requiring_fallen_flag(prepared)) == pytest.approx(lying, abs=1e-2)
