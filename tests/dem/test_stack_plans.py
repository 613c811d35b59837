"""Stacks of prisms on regular polygons and of cylinders, in 3-D: closed forms, the single body, and symmetry."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from overturning.dem.kernel import balance
from overturning.dem.run import simulate_cases
from overturning.dem.simulate import simulate
from overturning.dem.trajectory import trajectory
from overturning.errors import ArgumentError
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.element import Element, Material, PlanShape
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import Scene
from overturning.model.shapes import Cylinder, RegularPrism
from overturning.model.stack import Stack
from overturning.model.stack_stones import contact_patches_at_rest
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY as GRAVITY
from tests.dem.motions import simulate_under_each_motion
from tests.dem.test_stack import (
    INTERVAL,
    acceleration_components_with_plateau,
    motion_from_north_and_west_accelerations,
    random_horizontal_accelerations,
    simulate_stack_orientations,
    simulate_stack_under_north_west_accelerations,
)

PLAN_SHAPES: list[PlanShape] = [6, 8, "circle"]


def stack_of_prisms(*stones: tuple[PlanShape, float, float]) -> Scene:
    """Return a stack on the ground from (plan, width, height), m, the lowest first; rectangles are squares."""
    elements = [Element(name="ground", kind="driven", width=40.0, height=1.0, at=(0.0, -1.0))]
    for number, (plan, width, height) in enumerate(stones):
        depth = {"depth": width} if plan == "rectangle" else {}
        elements.append(Element(
            name=f"stone-{number}", plan=plan, width=width, height=height, stands_on=elements[-1].name, **depth
        ))  # fmt: skip
    return Scene(name="prisms", reference=elements[-1].name, elements=tuple(elements))


@pytest.mark.parametrize("plan", PLAN_SHAPES)
def test_mass_inertia_and_base_of_a_stacked_stone_are_those_of_its_prism(plan: PlanShape) -> None:
    (stone,) = Stack(stack_of_prisms((plan, 0.4, 1.2))).stones()
    x, y = stone.base_corners_xy_from_centre_of_mass.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    square = np.sum(cross * (x * x + x * np.roll(x, -1) + np.roll(x, -1) ** 2)) / (6.0 * cross.sum())
    square = 0.01 if plan == "circle" else square  # r²/4
    np.testing.assert_allclose(
        stone.inertia_per_mass, np.diag([square + 0.12, square + 0.12, 2.0 * square]), atol=1e-12
    )
    area = math.pi * 0.04 if plan == "circle" else plan * 0.04 * math.tan(math.pi / plan)
    assert 0.5 * cross.sum() == pytest.approx(area)
    assert stone.mass == pytest.approx(2650.0 * area * 1.2, rel=2e-2)
    assert stone.mass / Stack(stack_of_prisms(("rectangle", 0.4, 1.2))).stones()[0].mass == pytest.approx(area / 0.16)
    assert stone.nearest_base_side_distance == pytest.approx(0.2, rel=1e-9 if plan != "circle" else 1e-2)


@pytest.mark.parametrize("plan", PLAN_SHAPES)
def test_free_rocking_about_a_side_loses_the_velocity_that_housner_predicts(plan: PlanShape) -> None:
    """The velocity ratio is 1 − 2 b²/(I/m + b² + h²) with b, distance of the side, and h, height of the centre.

    In a landing, corners between the two opposite sides carry no force; if they did, the ratio would be 2 to 5 % more.
    """
    scene = stack_of_prisms((plan, 0.4, 1.2))
    (stone,) = Stack(scene).stones()
    b, h, t = stone.nearest_base_side_distance, 0.6, np.arange(0.0, 6.0, INTERVAL)
    pulse = np.where(t < 0.5, 1.6 * b / h * GRAVITY * np.sin(2.0 * np.pi * t), 0.0)
    motion = Motion(pulse, np.zeros(t.size), sampling_interval=INTERVAL, trust_data=True)
    path = trajectory(motion, scene, orientation_deg=0.0, friction=3.0)
    tilt, free = np.abs(path["tilt_north"].to_numpy()[:, 0]), path["time"].to_numpy() > 1.05
    tops = [i for i in range(2, len(tilt) - 2) if free[i] and tilt[i] > 2e-3 and tilt[i] >= tilt[i - 2 : i + 3].max()]
    arm, critical = math.hypot(b, h), math.atan2(b, h)
    energy = arm * (np.cos(critical - tilt[tops]) - math.cos(critical))
    ratio = np.sqrt(energy[1:4] / energy[:3])
    np.testing.assert_allclose(ratio, 1.0 - 2.0 * b * b / (stone.inertia_per_mass[1, 1] + b * b + h * h), rtol=2e-3)


def test_a_hexagonal_shaft_tips_over_its_nearest_side_at_the_static_threshold() -> None:
    """The threshold is d/(h cos φ) g: d, distance of a side; h, height of the centre; φ, its normal to the motion."""
    scene, angles = stack_of_prisms(("rectangle", 0.6, 0.3), (6, 0.25, 0.75)), np.array([0.0, 15.0, 30.0, 100.0])
    cosines = np.cos(np.radians(angles[:, None] - 60.0 * np.arange(6))).max(axis=1)
    motion = Motion(*acceleration_components_with_plateau(1.0, 0.0), sampling_interval=INTERVAL, trust_data=True)
    level = np.outer([0.97, 1.04], 0.125 / cosines / 0.375)
    found = simulate_stack_orientations(scene, motion, np.tile(angles, 2), level.ravel())
    assert found.peak_tilt[:4].max() < 0.02
    assert (found.overturned[4:] == [0, 1]).all()


@pytest.mark.parametrize("plan", PLAN_SHAPES)
def test_a_stack_of_one_prism_agrees_with_the_model_of_a_single_body(plan: PlanShape) -> None:
    """Friction acts per contact face in a stack, but per corner in a single body: flags near the limit may differ.

    All samples are simulated: `tests/dem/test_leave_out.py` is about the effect of skipping some.
    """
    motions = [
        motion_from_north_and_west_accelerations(4.5 * random_horizontal_accelerations(seed)) for seed in range(10)
    ]
    cases = Cases(0.0, 0.75, 1.0 / 3.0, 0.8)
    models = (
        Stack(stack_of_prisms((plan, 0.25, 0.75))),
        Body(Cylinder() if plan == "circle" else RegularPrism(int(plan))),
    )
    stack, body = (simulate_under_each_motion(model, motions, cases, leave_out=False) for model in models)
    assert ((stack.overturned == body.overturned) & (stack.overturned >= 0)).sum() >= 9
    both = (stack.overturned == 1) & (body.overturned == 1)
    azimuths = np.abs((stack.fall_azimuth[both] - body.fall_azimuth[both] + 180.0) % 360.0 - 180.0)
    assert len(azimuths) >= 2
    assert np.median(azimuths) < 20.0


def test_a_stack_that_still_rocks_long_after_the_record_but_cannot_fall_has_an_outcome() -> None:
    """A tall shaft rocks longer than the small cap above it; quiet time after the record changes nothing."""
    stack = stack_of_prisms(("circle", 0.6, 0.2), (8, 0.25, 0.8), ("circle", 0.3, 0.1))
    short, long = (
        simulate(Motion.sine(3.2, 0.6, azimuth_deg=10, rest=rest), stack, orientation_deg=[0.0, 10.0], friction=[0.6])
        for rest in (0.2, 30.0)
    )
    for found in (short, long):
        assert (found.status == CaseStatus.SIMULATED).all()
        assert (found.overturned == 0.0).all()
    np.testing.assert_allclose(short.peak_tilt, long.peak_tilt, rtol=1e-3, atol=1e-3)


def test_the_symmetry_period_of_a_stack_is_common_to_all_its_stones() -> None:
    periods = {
        (("rectangle", 0.5, 0.3), (8, 0.3, 0.6)): 90.0, (("rectangle", 0.5, 0.3), (6, 0.3, 0.6)): 180.0,
        (("rectangle", 0.5, 0.3), ("circle", 0.3, 0.6)): 90.0, ((6, 0.5, 0.3), (3, 0.3, 0.6)): 120.0,
        (("circle", 0.5, 0.3), ("circle", 0.3, 0.6)): 22.5, ((5, 0.5, 0.3), (6, 0.3, 0.6)): 360.0,
    }  # fmt: skip
    for stones, period in periods.items():
        assert Stack(stack_of_prisms(*stones)).rotational_symmetry_period_deg == period


def test_a_rotation_by_the_symmetry_period_gives_the_same_outcome() -> None:
    rows, scene = 7.0 * random_horizontal_accelerations(3), stack_of_prisms((6, 0.5, 0.3), (6, 0.25, 0.7))
    motion = Motion(rows[0], -rows[1], sampling_interval=INTERVAL, trust_data=True)
    found = simulate_cases(Stack(scene), motion, Cases([10.0, 70.0, 130.0], 0.7, 0.25 / 0.7, 0.7))
    assert (found.overturned == found.overturned[0]).all()
    assert (found.overturned[:, 1] == 1).all()
    np.testing.assert_allclose(found.fall_azimuth[:, 1], found.fall_azimuth[0, 1], atol=2.0)


@pytest.mark.parametrize("plan", PLAN_SHAPES)
def test_prisms_balance_energy_as_well_as_boxes_and_rest_off_centre(plan: PlanShape) -> None:
    """A case is rerun in finer steps until its energy error is below 0.01: the median says more than the maximum.

    The error of stacks of boxes of these sizes has a median of 0.0008 under these motions, and is at most 0.0055.
    """
    scene = stack_of_prisms((8, 0.6, 0.3), (plan, 0.3, 0.8))
    cases = Cases([0.0, 20.0], *reference_element_height_and_b_over_h(scene), 0.6)
    found = simulate_under_each_motion(
        Stack(scene),
        [motion_from_north_and_west_accelerations(6.0 * random_horizontal_accelerations(seed)) for seed in range(8)],
        cases,
    )
    assert (found.status == CaseStatus.SIMULATED).all()
    assert np.median(found.energy_error) < 2e-3
    assert found.energy_error.max() < 1e-2
    elements = (*scene.elements[:2], scene.elements[2].model_copy(update={"at": (0.2, 0.0)}))
    quiet = Motion(np.zeros(100), np.zeros(100), sampling_interval=INTERVAL, trust_data=True)
    rests = simulate(quiet, Scene(name="offset", reference="stone-1", elements=elements), orientation_deg=[0.0],
                     friction=[0.6], leave_out=False)  # fmt: skip
    assert rests.overturned.to_numpy().max() == 0.0
    assert rests.peak_tilt.to_numpy().max() < 1e-2


@pytest.mark.parametrize(("ratio", "seed", "friction"), [(0.99, 2, 0.5), (1.3, 0, 1.0), (1.3, 2, 1.0)])
def test_light_stones_below_a_heavy_one_do_not_vibrate_on_to_the_end_of_the_case(
    ratio: float, seed: int, friction: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A contact's dashpot is made for the mass of all stones above; it stops a light stone in under 1/512 of a step."""
    monkeypatch.setattr(balance, "MAX_RERUNS_UNTIL_ENERGY_BALANCES", 0)
    stack = Stack(
        stack_of_prisms(*(("rectangle", 0.4 * ratio**number, height) for number, height in enumerate((0.2, 0.2, 0.6))))
    )
    cases = Cases(np.arange(7.0, 90.0, 22.5), *reference_element_height_and_b_over_h(stack.scene), friction)
    found = simulate_cases(
        stack, motion_from_north_and_west_accelerations(5.0 * random_horizontal_accelerations(seed)), cases
    )
    assert (found.status == CaseStatus.SIMULATED).all()
    assert found.energy_error.max() < 5e-3
    assert found.block_steps.max() < 1e6


@pytest.mark.parametrize("heights", [(0.4, 0.4), (0.1, 0.1, 0.1)])
def test_stones_of_equal_width_balance_their_energy_at_the_first_attempt(
    heights: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A slip replaces all points of a contact patch, which are corners of either face or crossings of their sides.

    A point that is new to the patch brings the energy of its spring, and must not open or close in a long step.
    """
    monkeypatch.setattr(balance, "MAX_RERUNS_UNTIL_ENERGY_BALANCES", 0)
    stack, orientations = (
        Stack(stack_of_prisms(*(("rectangle", 0.4, height) for height in heights))),
        np.arange(7.0, 90.0, 11.25),
    )
    cases = Cases(orientations, *reference_element_height_and_b_over_h(stack.scene), 0.5)
    for seed in range(3):
        found = simulate_cases(
            stack, motion_from_north_and_west_accelerations(8.0 * random_horizontal_accelerations(seed)), cases
        )
        assert (found.status == CaseStatus.SIMULATED).all(), seed
        assert found.energy_error.max() < 1e-3, seed


@pytest.mark.parametrize("plan", PLAN_SHAPES)
@pytest.mark.parametrize(
    "taper", [0.0, *(pytest.param(one, marks=pytest.mark.long) for one in (0.0002, 0.001, 0.004, 0.009, -0.002, -0.01))]
)
def test_columns_of_drums_balance_their_energy(plan: PlanShape, taper: float) -> None:
    """The rims of the upper drum's base and of the lower drum's top (nearly) coincide, and cross at changing points.

    A column that still rocks seconds after the record may be undecided.
    """
    scene = stack_of_prisms(*((plan, 0.4 - taper * number, 0.5) for number in range(2)))
    found = simulate_stack_under_north_west_accelerations(
        scene, 5.5 * random_horizontal_accelerations(21), [20.0, 30.0], 0.7
    )
    assert set(found.status.to_numpy().ravel()) <= {CaseStatus.SIMULATED, CaseStatus.UNDECIDED}
    assert found.energy_error.to_numpy().max() < 5e-3
    assert (found.status == CaseStatus.SIMULATED).any()


@pytest.mark.parametrize("plan", PLAN_SHAPES)
def test_a_drum_on_an_equal_drum_loses_nearly_the_velocity_that_housner_predicts(plan: PlanShape) -> None:
    """All corners carry in a landing where the rims coincide, so the velocity after it is 2 to 5 % above Housner's."""
    heavy = {"materials": {"stone": Material(), "lead": Material(density=2e5)}}
    scene = stack_of_prisms((plan, 0.4, 0.3), (plan, 0.4, 1.2)).model_copy(update=heavy)
    ground, lower, upper = scene.elements
    scene = scene.model_copy(update={"elements": (ground, lower.model_copy(update={"material": "lead"}), upper)})
    stone, t = Stack(scene).stones()[1], np.arange(0.0, 6.0, INTERVAL)
    b, h = stone.nearest_base_side_distance, 0.6
    pulse = np.where(t < 0.5, 1.6 * b / h * GRAVITY * np.sin(2.0 * np.pi * t), 0.0)
    motion = Motion(pulse, np.zeros(t.size), sampling_interval=INTERVAL, trust_data=True)
    path = trajectory(motion, scene, orientation_deg=0.0, friction=3.0)
    assert path["tilt_north"].to_numpy()[:, 0].max() < 1e-3
    tilt, free = np.abs(path["tilt_north"].to_numpy()[:, 1]), path["time"].to_numpy() > 1.05
    tops = [i for i in range(2, len(tilt) - 2) if free[i] and tilt[i] > 2e-3 and tilt[i] >= tilt[i - 2 : i + 3].max()]
    arm, critical = math.hypot(b, h), math.atan2(b, h)
    energy = arm * (np.cos(critical - tilt[tops]) - math.cos(critical))
    ratio = np.sqrt(energy[1:4] / energy[:3]) / (1.0 - 2.0 * b * b / (stone.inertia_per_mass[1, 1] + b * b + h * h))
    assert ((ratio > 0.995) & (ratio < 1.055)).all()


def test_a_prism_whose_centre_lies_outside_the_face_below_is_refused() -> None:
    """At 0.28 m from the octagon's middle the upper stone meets it, but its centre is beyond the side at 0.25 m.

    The upper stone narrows with B/H: at 0.1 and 0.3 m from the middle its base, 0.06 m wide, does not meet it at all.
    """

    def scene_of_offset_prism(offset: float) -> Scene:
        """Return a scene of a prism on another one, shifted from its middle by `offset`, m."""
        elements = stack_of_prisms((8, 0.5, 0.3), (6, 0.2, 0.6)).elements
        return Scene(name="offset", reference="stone-1", elements=(
            *elements[:2], elements[2].model_copy(update={"at": (offset, 0.0)})
        ))  # fmt: skip

    with pytest.raises(ArgumentError, match="stone-1 has its centre of mass outside it"):
        Stack(scene_of_offset_prism(0.28))
    narrow = Stack(scene_of_offset_prism(0.24)).stones(0.6, 0.1)
    far = [narrow[0], replace(narrow[1], centre_of_mass_x_at_rest=0.3)]
    assert contact_patches_at_rest(narrow)[1].side_distances_from_mass_centre_above.min() > 0.0
    assert contact_patches_at_rest(far)[1].side_distances_from_mass_centre_above.min() < 0.0


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"plan": 2, "width": 0.3, "height": 0.5}, "greater than or equal to 3"),
        ({"plan": 17, "width": 0.3, "height": 0.5}, "less than or equal to 16"),
        ({"plan": "square", "width": 0.3, "height": 0.5}, "'rectangle' or 'circle'"),
        ({"plan": "circle", "width": 0.3, "height": 0.5, "depth": 0.3}, "plan circle has no depth of its own"),
        ({"plan": 6, "vertices": [[0, 0], [1, 0], [1, 1]]}, "plan 6 needs a width and a height"),
    ],
)
def test_an_invalid_plan_shape_of_an_element_is_refused(content: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        Element.model_validate({"name": "a", **content})


def test_a_scene_element_survives_json_unchanged() -> None:
    for element in stack_of_prisms((6, 0.5, 0.3), ("circle", 0.3, 0.6)).elements:
        assert Element.model_validate(element.model_dump(mode="json")) == element
