"""Rocking stack of two blocks, against the equations of two rigid bodies and an independent contact simulation."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from overturning.arrays import FloatArray
from overturning.model.scene import Scene
from overturning.units import STANDARD_GRAVITY
from tests.dem.polygon_scenes import (
    block_element,
    motion_towards_north,
    overwrite_initial_state_of_element,
    plan_single_case,
    run_planned_case,
    scene_of_elements,
)
from tests.dem.reference.scalar_stack import trajectory_of_two_stacked_blocks

LOWER_BLOCK_WIDTH_AND_HEIGHT, UPPER_BLOCK_WIDTH_AND_HEIGHT = np.array([0.6, 1.0]), np.array([0.3, 0.8])
"""Widths and heights, m; the upper block stands in the middle of the lower one."""


def rotate_clockwise(angle: float, arm: FloatArray) -> FloatArray:
    """Return an arm (x, z) rotated clockwise by an angle, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * arm[0] + s * arm[1], c * arm[1] - s * arm[0]])


def lever_arms_of_stack_rocking_at_right_corner(side: int) -> tuple[FloatArray, ...]:
    """Return arms of a stack: lower right corner to lower centre and to upper pivot; upper pivot to upper centre."""
    corner = 0.5 * side * UPPER_BLOCK_WIDTH_AND_HEIGHT[0]
    foot = -0.5 * LOWER_BLOCK_WIDTH_AND_HEIGHT[0]
    return (
        np.array([foot, 0.5 * LOWER_BLOCK_WIDTH_AND_HEIGHT[1]]),
        np.array([foot + corner, LOWER_BLOCK_WIDTH_AND_HEIGHT[1]]),
        np.array([-corner, 0.5 * UPPER_BLOCK_WIDTH_AND_HEIGHT[1]]),
    )


def centres_of_blocks(side: int, angles: FloatArray) -> FloatArray:
    """Return the centres (x, z), m, of the lower and the upper block at their rotations `angles`, rad."""
    to_lower, to_corner, to_upper = lever_arms_of_stack_rocking_at_right_corner(side)
    foot = np.array([0.5 * LOWER_BLOCK_WIDTH_AND_HEIGHT[0], 0.0])
    upper = foot + rotate_clockwise(angles[0], to_corner) + rotate_clockwise(angles[1], to_upper)
    return np.array([foot + rotate_clockwise(angles[0], to_lower), upper])


def rotations_of_rigid_stack_until_impact(
    side: int, angles: tuple[float, float], base: Callable[[float], float], duration: float
) -> FloatArray:
    """Return the rotations, rad, of two stacked rigid blocks until the first impact, shape (samples, 2)."""
    to_lower, to_corner, to_upper = lever_arms_of_stack_rocking_at_right_corner(side)
    (m, n), (i, j) = (
        (LOWER_BLOCK_WIDTH_AND_HEIGHT.prod(), UPPER_BLOCK_WIDTH_AND_HEIGHT.prod()),
        (size.prod() * size @ size / 12 for size in (LOWER_BLOCK_WIDTH_AND_HEIGHT, UPPER_BLOCK_WIDTH_AND_HEIGHT)),
    )

    def sliding_plate_state_derivative(time: float, state: FloatArray) -> FloatArray:
        """Return the time derivative of the rotations of two stacked blocks and of their angular velocities."""
        (lower, upper), (v, w) = state[:2], state[2:]
        a, b, c = (rotate_clockwise(angle + 0.5 * np.pi, arm) for angle, arm in
                   ((lower, to_lower), (lower, to_corner), (upper, to_upper)))  # fmt: skip
        weight = np.array([-base(time), -STANDARD_GRAVITY])
        mass = [[m * a @ a + i + n * b @ b, n * b @ c], [n * b @ c, n * c @ c + j]]
        of_lower = weight + v * v * rotate_clockwise(lower, to_lower)
        of_upper = weight + v * v * rotate_clockwise(lower, to_corner) + w * w * rotate_clockwise(upper, to_upper)
        return np.array([v, w, *np.linalg.solve(mass, [m * of_lower @ a + n * of_upper @ b, n * of_upper @ c])])

    def impact_event(_: float, state: FloatArray) -> float:
        """Event function: 0 where a block meets its support."""
        return float(min(state[0], side * (state[1] - state[0])))

    impact_event.terminal = True  # type: ignore[attr-defined]
    samples = np.arange(0.0, duration, 0.005)
    return (
        solve_ivp(
            sliding_plate_state_derivative,
            (0, duration),
            [*angles, 0, 0],
            t_eval=samples,
            events=impact_event,
            rtol=1e-11,
            atol=1e-13,
        )
        .y[:2]
        .T
    )


@pytest.mark.parametrize("amplitude", [0.0, 2.0])
@pytest.mark.parametrize(("side", "angles"), [(1, (0.1, 0.16)), (-1, (0.15, -0.1))], ids=["same way", "opposite ways"])
def test_a_stack_released_on_its_corners_rocks_like_two_rigid_bodies(
    side: int, angles: tuple[float, float], amplitude: float
) -> None:
    """The kernel agrees with two rigid bodies to 1e-5 m and rad until the first impact."""
    time = np.arange(100) * 0.005
    motion = motion_towards_north(amplitude * np.sin(6 * time), 0.005)
    wanted = rotations_of_rigid_stack_until_impact(
        side, angles, lambda t: float(np.interp(t, time, motion.north)), time[-1]
    )
    assert np.ptp(wanted, axis=0).min() > 0.05
    how = plan_single_case(
        scene_of_elements(
            block_element("lower", *LOWER_BLOCK_WIDTH_AND_HEIGHT),
            block_element("upper", *UPPER_BLOCK_WIDTH_AND_HEIGHT, "lower"),
        ),
        motion,
        3.0,
    )
    for element, (angle, (x, z)) in enumerate(zip(angles, centres_of_blocks(side, np.array(angles)), strict=True), 1):
        overwrite_initial_state_of_element(how, element, x=x, z=z, angle=angle)
    _, times, poses = run_planned_case(how, motion)
    end = len(wanted)
    np.testing.assert_allclose(times[1:end], time[1:end])
    np.testing.assert_allclose(poses[1:end, 1:, 2], wanted[1:], rtol=0, atol=1e-5)
    places = [centres_of_blocks(side, angles) for angles in wanted[1:]]
    np.testing.assert_allclose(poses[1:end, 1:, :2], places, rtol=0, atol=1e-5)


def count_changes_of_rocking_corner(angle: FloatArray) -> int:
    """Return how many times a rocking body changed from one corner to the other."""
    sides = np.sign(angle[np.abs(angle) > 1e-3])
    return int((np.diff(sides) != 0).sum())


@pytest.mark.long
@pytest.mark.parametrize(
    ("lower", "upper", "amplitude", "rate", "friction"),
    [
        ((0.6, 1.0), (0.3, 0.8), 5.8, 15.0, 1.0),
        ((0.6, 1.0), (0.3, 0.8), 4.6, 15.0, 0.5),
        ((0.6, 1.0), (0.3, 0.8), 4.6, 10.0, 1.0),
        ((0.4, 1.0), (0.3, 0.6), 3.4, 10.0, 1.0),
        ((0.4, 1.0), (0.3, 0.6), 3.4, 15.0, 0.5),
    ],
)
def test_a_shaken_stack_agrees_with_an_independent_integration(
    lower: tuple[float, float], upper: tuple[float, float], amplitude: float, rate: float, friction: float
) -> None:
    """Under two sine cycles the kernel agrees with the same contact law in the explicit steps of `scalar_stack`."""
    time = np.arange(200) * 0.01
    motion = motion_towards_north(np.where(time < 4 * np.pi / rate, amplitude * np.sin(rate * time), 0.0))
    made = scene_of_elements(block_element("lower", *lower), block_element("upper", *upper, "lower"))
    law = {"between": ("stone", "stone"), "static_penetration": 2e-5, "damping_ratio": 1.0}
    made = Scene.model_validate(made.model_dump() | {"contacts": [law]})
    plain = trajectory_of_two_stacked_blocks(motion.north, 0.01, np.array([lower, upper]), 2e-5, friction, 0)
    assert (
        count_changes_of_rocking_corner(plain[:, 0, 2])
        + count_changes_of_rocking_corner(plain[:, 1, 2] - plain[:, 0, 2])
        >= 3
    )
    assert np.abs(plain[:, 1, 2]).max() > 0.05
    for step, bound in (("0.03 stable", 1e-4), ("auto", 5e-3)):
        _, _, poses = run_planned_case(plan_single_case(made, motion, friction, time_step=step), motion)
        np.testing.assert_allclose(poses[1:200, 1:, :3], plain[1:, :, :3], rtol=0, atol=bound)
