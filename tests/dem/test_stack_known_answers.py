"""Stacks in 3-D against closed forms: opening of each joint, restitution of compounds, and invariances."""

import math
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from overturning.dem.simulate import simulate
from overturning.dem.trajectory import trajectory
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.results import CaseResults
from overturning.model.scene import Scene
from overturning.model.stack import Stack
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY as GRAVITY
from tests.dem.motions import simulate_under_each_motion
from tests.dem.test_stack import (
    INTERVAL,
    THREE_BOXES,
    acceleration_components_with_plateau,
    motion_from_north_and_west_accelerations,
    random_horizontal_accelerations,
    simulate_stack_orientations,
    stack_of_boxes,
)

STACK_BY_WEAKEST_JOINT = {
    0: stack_of_boxes((0.3, 0.3, 0.3), (0.5, 0.5, 0.3), (0.4, 0.4, 0.2)),
    1: stack_of_boxes((0.8, 0.8, 0.3), (0.3, 0.36, 0.3), (0.4, 0.5, 0.4)),
    2: THREE_BOXES,
}
"""Stacks by the joint that opens first."""


def stone_sizes(scene: Scene) -> np.ndarray[Any, Any]:
    """Return width, depth and height of the stones of a stack, m, from the lowest up."""
    return np.array([[one.width, one.depth, one.height] for one in scene.elements[1:]], float)


def horizontal_to_vertical_ratio_opening_joint(scene: Scene, joint: int, angle: float) -> float:
    """Return the ratio of horizontal to vertical acceleration at which a joint opens.

    A joint is the contact of a stone with the one below; 0 is the lowest. The angle, degrees, is that from the width
    of the stones to the horizontal acceleration.
    """
    sizes, turn = stone_sizes(scene), np.radians(angle)
    mass, tops = sizes.prod(axis=1), np.cumsum(sizes[:, 2])
    centre = np.sum((mass * (tops - 0.5 * sizes[:, 2]))[joint:]) / mass[joint:].sum()
    patch = sizes[joint, :2] if joint == 0 else np.minimum(sizes[joint, :2], sizes[joint - 1, :2])
    directions = np.array([abs(math.cos(turn)), abs(math.sin(turn))])
    return float(np.min(0.5 * patch / np.maximum(directions, 1e-12)) / (centre - (tops - sizes[:, 2])[joint]))


@pytest.mark.parametrize("lift", [-1.1, 0.0, 0.7])
@pytest.mark.parametrize("joint", [0, 1, 2])
def test_each_joint_opens_at_its_static_threshold(joint: int, lift: float) -> None:
    """A joint opens at (g + a_up) d/z: d, distance of the nearest side; z, height of the centre of the stones above.

    The base moves north and up, `lift` times as much up; the stack is turned to each angle.
    """
    scene, angles = STACK_BY_WEAKEST_JOINT[joint], (0.0, 25.0, 90.0, 160.0)
    ratios = np.array([horizontal_to_vertical_ratio_opening_joint(scene, joint, angle) for angle in angles])
    for angle, ratio in zip(angles, ratios, strict=True):
        assert ratio < 0.97 * min(
            horizontal_to_vertical_ratio_opening_joint(scene, other, angle) for other in range(3) if other != joint
        )
    level = np.outer([0.98, 1.03], ratios)
    level /= 1.0 - level * lift  # from level = share · ratio · (1 + lift · level), in g
    up = np.interp(np.arange(0.0, 6.5, INTERVAL), [0.0, 1.0, 6.0, 6.5], [0.0, lift, lift, 0.0]) * GRAVITY
    motion = Motion(*acceleration_components_with_plateau(1.0, 0.0), up, sampling_interval=INTERVAL, trust_data=True)
    tilts = simulate_stack_orientations(scene, motion, np.tile(angles, 2), level.ravel()).peak_tilt.reshape(2, 4, 3)
    assert tilts[0].max() < 0.02
    # The stones above the joint move; those below stay.
    assert tilts[1, :, joint:].min() > 0.3
    assert tilts[1, :, :joint].max(initial=0.0) < 0.3


def free_rocking_velocity_ratios(scene: Scene, mass: float, arm: float, critical: float, stone: int) -> list[float]:
    """Return the ratios of the angular velocities after and before the impacts of free rocking in a plane.

    The energy at the top of each swing, M g R (cos(α − θ) − cos α), falls by the square of the ratio.
    """
    motion = Motion(
        *acceleration_histories_of_joint_opening_pulse(scene, stone), sampling_interval=INTERVAL, trust_data=True
    )
    path = trajectory(motion, scene, orientation_deg=0.0, friction=3.0)
    tilt = np.abs(path["tilt_north"].to_numpy()[:, stone])
    free = path["time"].to_numpy() > 1.05
    tops = [
        index
        for index in range(2, len(tilt) - 2)
        if free[index] and tilt[index] > 2e-3 and tilt[index] >= tilt[index - 2 : index + 3].max()
    ]
    swings = []
    for index in tops:
        a, b, c = tilt[index - 1 : index + 2]
        swings.append(b + 0.125 * (a - c) ** 2 / max(2.0 * b - a - c, 1e-15))
    energy = [mass * GRAVITY * arm * (math.cos(critical - swing) - math.cos(critical)) for swing in swings]
    return [math.sqrt(later / earlier) for earlier, later in pairwise(energy)]


def acceleration_histories_of_joint_opening_pulse(scene: Scene, stone: int) -> np.ndarray[Any, Any]:
    """Return north and east accelerations of 6 s: a half sine of 0.5 s to north that opens the joint below a stone."""
    t = np.arange(0.0, 6.0, INTERVAL)
    level = 1.6 * horizontal_to_vertical_ratio_opening_joint(scene, stone, 0.0) * GRAVITY
    return np.stack([np.where(t < 0.5, level * np.sin(2.0 * np.pi * t), 0.0), np.zeros(t.size)])


@pytest.mark.parametrize(("width", "height"), [(0.3, 0.9), (0.4, 1.6)])
def test_a_shaft_on_a_broad_base_loses_the_velocity_that_housner_predicts(width: float, height: float) -> None:
    scene = stack_of_boxes((2.0, 2.0, 0.3), (width, width, height))
    arm = 0.5 * math.hypot(width, height)
    ratios = free_rocking_velocity_ratios(scene, 1.0, arm, math.atan2(width, height), 1)
    assert len(ratios) >= 3
    sine = math.sin(math.atan2(width, height))
    np.testing.assert_allclose(ratios[:3], 1.0 - 1.5 * sine * sine, rtol=2e-3)


def test_two_stones_that_land_together_lose_velocity_like_one_stone() -> None:
    """The ratio of velocities at an impact is (I + M (Z² − b²))/(I + M (Z² + b²)) (Spanos et al. 2001).

    I, M and Z: inertia, mass and height of the centre of both stones together; b: half their width. The upper stone
    stays on the lower one, as the impulse that stops its fall and turns it passes through their contact.
    """
    scene = stack_of_boxes((0.4, 0.4, 0.5), (0.4, 0.4, 0.5))
    (b, _, h), mass = stone_sizes(scene)[0], 1.0
    half, centres = 0.5 * b, np.array([0.5 * h, 1.5 * h])
    inertia = 2.0 * mass * (b * b + h * h) / 12.0 + mass * float(((centres - h) ** 2).sum())
    e = (inertia + 2.0 * mass * (h * h - half * half)) / (inertia + 2.0 * mass * (h * h + half * half))
    # Velocities of the upper stone before and after, about the old and the new corner, for ω = 1 before.
    before, after = np.array([centres[1], half]), e * np.array([centres[1], -half])
    impulse = mass * (after - before)  # along x, and along z
    turn = mass * (b * b + h * h) / 12.0 * (e - 1.0)
    position = (-turn + (h - centres[1]) * impulse[0]) / impulse[1]
    assert abs(position) < half
    ratios = free_rocking_velocity_ratios(scene, 2.0 * mass, math.hypot(half, h), math.atan2(half, h), 0)
    assert len(ratios) >= 3
    np.testing.assert_allclose(ratios[:3], e, rtol=3e-3)


@cache
def outcomes_with_divided_sampling_interval(parts: int) -> CaseResults:
    """Return the outcomes of two orientations under four motions, each sampling interval divided into `parts`."""
    t, interval = np.arange(0.0, 10.0, INTERVAL), INTERVAL / parts
    times = np.arange(0.0, t[-1] + 0.4 * interval, interval)
    motions = [
        Motion(
            *(np.interp(times, t, row) for row in 8.0 * random_horizontal_accelerations(seed)),
            sampling_interval=interval,
            trust_data=True,
        )
        for seed in range(4)
    ]
    cases = Cases([0.0, 45.0], *reference_element_height_and_b_over_h(THREE_BOXES), 0.6)
    return simulate_under_each_motion(Stack(THREE_BOXES), motions, cases, leave_out=False)


@pytest.mark.parametrize("seed", range(4))
def test_linear_interpolation_of_a_record_changes_no_fall_of_a_stack(seed: int) -> None:
    """The base acceleration is linear between samples, so twice as many samples describe the same motion.

    All samples are simulated: which of them are skipped depends on the sampling interval.
    """
    first, second = (outcomes_with_divided_sampling_interval(parts) for parts in (1, 2))
    np.testing.assert_array_equal(first.overturned[seed], second.overturned[seed])
    stands = first.overturned[seed] == 0
    assert stands.any()
    np.testing.assert_allclose(first.peak_tilt[seed][stands], second.peak_tilt[seed][stands], rtol=0.05, atol=0.05)


def test_threads_and_order_of_cases_change_no_bit_of_stack_outcomes() -> None:
    rows = 9.0 * random_horizontal_accelerations(2)
    motion = Motion(rows[0], -rows[1], sampling_interval=INTERVAL, trust_data=True)
    orientations = [0.0, 15.0, 30.0, 45.0, 60.0]
    one, two = (
        simulate(motion, THREE_BOXES, orientation_deg=orientations, friction=[0.5, 0.8], threads=threads)
        for threads in (1, 2)
    )
    reverse = simulate(motion, THREE_BOXES, orientation_deg=orientations[::-1], friction=[0.8, 0.5], threads=1)
    for name in ("overturned", "fall_azimuth", "peak_tilt", "energy_error", "residual_twist"):
        np.testing.assert_array_equal(one[name], two[name], name)
        np.testing.assert_array_equal(one[name], reverse[name].sel(one[name].coords), name)


SEEDS_OF_MOTIONS_WITH_CONVERGED_STATUE_TILTS = (1, 2, 9, 10, 20, 21)
"""Motions of the first 22 under which time steps 16 times shorter give both the same tilts within 3 %."""


@cache
def outcomes_of_statue_and_single_stone() -> list[CaseResults]:
    """Return outcomes under some motions: of a statue on a pedestal, and of one stone of the size of both together."""
    motions, outcomes = (
        [
            motion_from_north_and_west_accelerations(8.0 * random_horizontal_accelerations(seed))
            for seed in SEEDS_OF_MOTIONS_WITH_CONVERGED_STATUE_TILTS
        ],
        [],
    )
    for scene in (stack_of_boxes((0.5, 0.5, 0.1), (0.5, 0.5, 0.9)), stack_of_boxes((0.5, 0.5, 1.0))):
        cases = Cases([0.0, 30.0], *reference_element_height_and_b_over_h(scene), 3.0)
        outcomes.append(simulate_under_each_motion(Stack(scene), motions, cases))
    return outcomes


@pytest.mark.parametrize("number", range(len(SEEDS_OF_MOTIONS_WITH_CONVERGED_STATUE_TILTS)))
def test_a_statue_on_its_pedestal_moves_as_one_stone_while_their_joint_stays_closed(number: int) -> None:
    """A thin pedestal below a statue of the same width: the lower joint opens first, and both lean together."""
    both, one = outcomes_of_statue_and_single_stone()
    tilts, alone = both.peak_tilt[number], one.peak_tilt[number]
    assert alone.max() > 0.5
    np.testing.assert_allclose(tilts[:, 1], alone, rtol=0.1, atol=0.05)
    np.testing.assert_array_equal(both.overturned[number][:, 1], one.overturned[number])
