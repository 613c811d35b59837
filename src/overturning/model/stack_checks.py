"""Checks of a scene as a 3-D stack of stones: reasons why it cannot be simulated as one."""

import math
from typing import Final

import numpy as np

from overturning.errors import ArgumentError
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO
from overturning.model.element import ContactLaw
from overturning.model.geometry import PlacedElement, scale_and_place_elements
from overturning.model.scene import Scene
from overturning.model.stack_stones import (
    LEVEL_FACE_TOLERANCE_TO_STONE_HEIGHT_RATIO,
    StackStone,
    contact_patches_at_rest,
    end_x_of_lowest_or_highest_face,
    stack_stone_of_element,
)
from overturning.model.stack_touch import TiltAtFurtherContactBeforeTipping, lower_faces_touched_before_tipping
from overturning.units import STANDARD_GRAVITY

MIN_GROUND_MARGIN_AROUND_STACK_M: Final = 5.0
"""Least distance, m, by which the ground of a stack reaches beyond it; for small stones, in sizes of the largest one.

In 3-D the ground is a plane without end, from which no stone can slide off."""


def check_scene_can_be_simulated_as_3d_stack(scene: Scene) -> None:
    """Raise an `ArgumentError` with the reasons if a scene cannot be simulated as a 3-D stack of stones."""
    if faults := reasons_scene_is_no_stack(scene):
        raise ArgumentError(
            f"orientation_deg: scene {scene.name} is no stack of stones ({'; '.join(faults)}); compute it in 2-D with "
            "azimuth_deg"
        )


def reasons_scene_is_no_stack(scene: Scene) -> list[str]:
    """Return the reasons why a scene cannot be simulated as a 3-D stack of stones; an empty list if it can be."""
    ground, *stones = scene.elements
    faults = [] if ground.kind == "driven" else [f"element {ground.name} is not driven"]
    if ground.width is None or ground.rotation_deg:
        faults.append(f"element {ground.name} is no level ground")
    if scene.gravity != STANDARD_GRAVITY:
        faults.append(f"gravity {scene.gravity:g} m/s²")
    for below, element in zip(scene.elements, stones, strict=False):
        if element.kind != "free" or element.stands_on != below.name:
            faults.append(f"element {element.name} does not stand free on {below.name}")
        elif element.rotation_deg or element.at[1] != 0.0:
            faults.append(f"element {element.name} is rotated or raised")
        elif "depth" not in element.model_fields_set:
            faults.append(f"element {element.name} has no depth: give its depth")
        if element.fallen_rotation_deg is not None:
            faults.append(
                f"element {element.name} has fallen_rotation_deg {element.fallen_rotation_deg:g}, which 3-D does not "
                "have: leave it out"
            )
        law = scene.contact_law(below, element)
        if law.static_penetration != DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO:
            faults.append(
                f"the contact of {element.name} has static_penetration {law.static_penetration:g}, which 3-D does not "
                "have: leave it out"
            )
        if law.stiffness != "auto" or law.damping is not None:
            faults.append(f"the contact of {element.name} has a stiffness or dashpot of 2-D corners")
    return faults or _reasons_stones_are_not_level_or_balanced(scene)


def _reasons_stones_are_not_level_or_balanced(scene: Scene) -> list[str]:
    """Return reasons why stones of a scene do not stand in balance with level faces; an empty list if they do."""
    ground, *placed = scale_and_place_elements(scene)
    faults = []
    for item, following in zip(placed, [*placed[1:], None], strict=True):
        for name, lowest in (("base", True), ("upper face", False)):
            if lowest or following is not None:
                left, right = end_x_of_lowest_or_highest_face(item, lowest)
                whole = _outline_length_at_lowest_or_highest_level(item, lowest) >= (right - left) * (
                    1.0 - LEVEL_FACE_TOLERANCE_TO_STONE_HEIGHT_RATIO
                )
                flat = _outline_length_at_lowest_or_highest_level(item, lowest) > 0.0
                faults += [f"element {item.element.name} has no level {name}"] if not flat else []
                faults += [f"element {item.element.name} has a gap in its {name}"] if flat and not whole else []
    ends = placed[0].vertices_in_scene[:, 0] - ground.centre_of_mass_x
    margin = 0.5 * float(ground.shape.width) - float(np.abs(ends).max())
    largest = max(max(item.shape.width, item.shape.height) for item in placed)
    if margin < MIN_GROUND_MARGIN_AROUND_STACK_M * min(1.0, largest):
        faults.append(
            f"element {ground.element.name} is only {ground.shape.width:.3g} m wide, so that "
            f"{placed[0].element.name} could slide off it; make it a free stone on a wider ground"
        )
    if faults:
        return faults
    stones = [stack_stone_of_element(item, item.element.depth, ContactLaw(between=("a", "b"))) for item in placed]
    faults = reasons_stones_do_not_stand(stones)
    body = "; simulate it as a body in 3-D, given as a polyhedron or a mesh" if len(stones) == 1 else ""
    return [f"{fault}{body}" for fault in faults]


def reasons_stones_do_not_stand(stones: list[StackStone]) -> list[str]:
    """Return reasons why stones, lowest first, do not stand in balance on their bases; empty if they do."""
    faults = [
        f"what stands on the joint below {stone.name} has its centre of mass outside it"
        for stone, patch in zip(stones, contact_patches_at_rest(stones), strict=True)
        if not np.all(patch.side_distances_from_mass_centre_above > 0.0)
    ]
    return faults or [
        f"the outline of element {touch.tipping_stone_name} would meet the face below {_contact_tilt_text(touch)} "
        f"over the edge of its base at {math.degrees(touch.tipping_tilt_rad):.3g}°"
        for touch in lower_faces_touched_before_tipping(stones)
        if touch.touched_face.depth_below_base_of_tipping_stone == 0.0
    ]


def unsimulated_overhang_contact_warnings(stones: list[StackStone]) -> list[str]:
    """Return a warning for each stone whose overhang would touch a lower stone or the ground before the stone tips.

    The warnings are in the order of the stones from the lowest up, and name the face that is touched first. The
    simulation does not have this contact: the stone passes through the face.
    """
    first: dict[str, TiltAtFurtherContactBeforeTipping] = {}
    for touch in lower_faces_touched_before_tipping(stones):
        if touch.touched_face.depth_below_base_of_tipping_stone > 0.0:
            first.setdefault(touch.tipping_stone_name, touch)
    return [
        f"element {touch.tipping_stone_name} overhangs, and would meet "
        f"{touch.touched_face.name_of_stone_with_face or 'the ground'} "
        f"{_contact_tilt_text(touch)} over the rim of the stone below at {math.degrees(touch.tipping_tilt_rad):.3g}°"
        for touch in first.values()
    ]


def _contact_tilt_text(contact_before_tipping: TiltAtFurtherContactBeforeTipping) -> str:
    """Return a text for a warning: the tilt at which a stone touches a face below, before it tips."""
    tilt_deg = math.degrees(contact_before_tipping.tilt_when_touching_face_below_rad)
    return f"at a tilt of {tilt_deg:.3g}°, before it tips"


def _outline_length_at_lowest_or_highest_level(placed_element: PlacedElement, use_lowest_face: bool) -> float:
    """Return the total length (m) of an element's outline at its lowest, or highest, level."""
    x, z = placed_element.shape.vertices_from_whole_polygon_centroid.T
    on = np.abs(z - (z.min() if use_lowest_face else z.max())) <= LEVEL_FACE_TOLERANCE_TO_STONE_HEIGHT_RATIO * np.ptp(z)
    return float(np.abs(np.roll(x, -1) - x)[on & np.roll(on, -1)].sum())
