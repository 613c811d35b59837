"""Stones that lean over the rim of the stone below them, against the equations of a plane body on a sharp edge."""

import math
from typing import Any, Final

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from overturning.dem.trajectory import trajectory
from overturning.model.scene import Scene
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY as GRAVITY
from tests.dem.test_stack import INTERVAL

WIDTH, HEIGHT, BASE_WIDTH = 0.3, 0.6, 4.0
SHAFT_CENTRE_TO_BASE_RIM_DISTANCE: Final = 0.05
"""Distance of the shaft's centre from the rim of the base at rest, m."""
INERTIA_PER_MASS: Final = (WIDTH**2 + HEIGHT**2) / 12.0
"""Moment of inertia of the shaft per mass, m²."""


def overhanging_shaft(friction: float) -> Scene:
    """Return a scene in which a shaft overhangs one side of a broad, heavy base; `friction` is between the two."""
    return Scene.model_validate({
        "name": "rim", "reference": "shaft", "materials": {"stone": {}, "slick": {}},
        "contacts": (
            {"between": ("stone", "slick"), "friction": friction}, {"between": ("stone", "stone"), "friction": 5.0},
        ),
        "elements": (
            {"name": "ground", "kind": "driven", "width": 40.0, "height": 1.0, "at": (0.0, -1.0)},
            {"name": "base", "width": BASE_WIDTH, "depth": BASE_WIDTH, "height": 1.0, "stands_on": "ground"},
            {"name": "shaft", "width": WIDTH, "depth": WIDTH, "height": HEIGHT, "stands_on": "base",
             "at": (0.5 * BASE_WIDTH - SHAFT_CENTRE_TO_BASE_RIM_DISTANCE, 0.0), "material": "slick"},
        ),
    })  # fmt: skip


def path_of_overhanging_shaft(acceleration: np.ndarray[Any, Any], friction: float) -> xr.Dataset:
    """Return the path of a shaft that overhangs its base, under a ground acceleration towards the overhang, m/s²."""
    motion = Motion(acceleration, np.zeros(acceleration.size), sampling_interval=INTERVAL, trust_data=True)
    return trajectory(motion, overhanging_shaft(friction), orientation_deg=0.0, leave_out=False)


def tilt_of_shaft(path: xr.Dataset) -> np.ndarray[Any, Any]:
    """Return the angle by which the shaft leans towards the overhang, rad: arcsin of `tilt_north` in `path`."""
    return np.arcsin(path["tilt_north"].to_numpy()[:, 1])


def test_a_stone_without_friction_slides_over_the_rim_as_a_plane_body_does() -> None:
    """The force of the rim is normal to the base of the stone, which slides on it, and does no work.

    The reference holds x, z and θ of the centre relative to the rim, and the constraint that the rim touches the base.
    """
    time = np.arange(0.0, 1.2, INTERVAL)
    pulse = np.where(time < 0.1, -4.0, 0.0)
    path = path_of_overhanging_shaft(pulse, 0.0)
    speed = -float(np.trapezoid(pulse, time))
    passes = (
        -float(np.trapezoid(pulse * time, time)) / speed + SHAFT_CENTRE_TO_BASE_RIM_DISTANCE / speed
    )  # the centre is above the rim, s

    def sliding_plate_state_derivative(_: float, state: np.ndarray[Any, Any]) -> list[float]:
        """Return the time derivative of the state of the sliding plate (x, z, angle and their velocities)."""
        x, z, angle, vx, vz, spin = state
        normal, along = np.array([math.sin(angle), math.cos(angle)]), np.array([math.cos(angle), -math.sin(angle)])
        at = float(along @ [x, z])
        lever = x * normal[1] - z * normal[0]  # moment of a unit force about the centre, positive with the lean
        other = -GRAVITY * normal[1] + 2.0 * spin * float(along @ [vx, vz]) - spin**2 * float(normal @ [x, z])
        force = -other / (1.0 + at * lever / INERTIA_PER_MASS)
        assert force > 0.0
        return [vx, vz, spin, force * normal[0], force * normal[1] - GRAVITY, force * lever / INERTIA_PER_MASS]

    expected = solve_ivp(
        sliding_plate_state_derivative,
        (0.0, 0.33),
        [0.0, 0.5 * HEIGHT, 0.0, speed, 0.0, 0.0],
        rtol=1e-10,
        atol=1e-12,
        dense_output=True,
    ).sol
    since = path["time"].to_numpy() - passes
    leans = (since > 0.1) & (since < 0.33)
    known = expected(since[leans])[2]
    assert known.max() > 0.35
    np.testing.assert_allclose(tilt_of_shaft(path)[leans], known, rtol=6e-3)
    assert float(path["energy_error"]) < 1e-3


@pytest.mark.parametrize("level", [2.2, 2.6])
def test_a_rough_stone_turns_about_the_rim_like_a_pendulum(level: float) -> None:
    """The stone's centre is 0.05 m inside the rim and 0.3 m above it; the stone turns about the rim without slip."""
    time = np.arange(0.0, 1.2, INTERVAL)

    def base_acceleration(t: float) -> float:
        """Return the acceleration of the base at a time, m/s²."""
        return -level * min(1.0, max(0.0, 1.0 - (t - 0.2) / INTERVAL))

    path = path_of_overhanging_shaft(np.where(time < 0.2 + 0.5 * INTERVAL, -level, 0.0), 5.0)
    above = 0.5 * HEIGHT

    def sliding_plate_state_derivative(t: float, state: np.ndarray[Any, Any]) -> list[float]:
        """Return the time derivative of the state of the pendulum (angle and angular velocity)."""
        angle, spin = state
        x = -SHAFT_CENTRE_TO_BASE_RIM_DISTANCE * math.cos(angle) + above * math.sin(angle)
        z = SHAFT_CENTRE_TO_BASE_RIM_DISTANCE * math.sin(angle) + above * math.cos(angle)
        return [
            spin,
            (GRAVITY * x - base_acceleration(t) * z)
            / (INERTIA_PER_MASS + SHAFT_CENTRE_TO_BASE_RIM_DISTANCE**2 + above**2),
        ]

    expected = solve_ivp(
        sliding_plate_state_derivative, (0.0, 0.6), [0.0, 0.0], rtol=1e-10, atol=1e-12, max_step=1e-3, dense_output=True
    ).sol
    at = path["time"].to_numpy()
    known = expected(at[at < 0.6])[0]
    leans = known > 2e-3
    until = int(np.argmax(known))
    assert math.radians(1.0) < known[until]
    leans[until + 1 :] = False
    np.testing.assert_allclose(tilt_of_shaft(path)[: leans.size][leans], known[leans], rtol=2e-2, atol=1e-4)
