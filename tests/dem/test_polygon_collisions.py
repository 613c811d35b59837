"""Collisions of two polygons in free flight: momentum, angular momentum and energy."""

import numpy as np
import pytest

from overturning.dem.polygon.plan import PolygonSimulationPlan
from tests.dem.polygon_scenes import (
    GROUND,
    block_element,
    motion_at_rest,
    motion_towards_north,
    overwrite_initial_state_of_element,
    plan_single_case,
    run_planned_case,
    scene_of_elements,
)

FloatArray = np.ndarray


def _momenta_and_energy_of_collision_in_flight(
    friction: float, damping: float, seed: int, time_step: str = "auto"
) -> tuple[PolygonSimulationPlan, FloatArray, FloatArray]:
    """Simulate two polygons that collide in flight; return plan, momenta (x, z, angular) and kinetic energy."""
    law = {"between": ["stone", "stone"], "friction": friction, "stiffness": 2e7, "damping": damping}
    free = {"fallen_rotation_deg": 180}
    pebble = {
        "name": "pebble",
        "vertices": [[0, 0], [0.5, 0], [0.6, 0.4], [0.2, 0.6], [-0.1, 0.3]],
        "at": [3, 0],
    } | free
    made = scene_of_elements(
        GROUND, block_element("stone", 0.4, 0.7, x=-3, **free), pebble, gravity=1e-12, contacts=[law]
    )
    rng = np.random.default_rng(seed)
    motion = motion_at_rest(1.2, 0.005)
    how = plan_single_case(made, motion, time_step=time_step)
    overwrite_initial_state_of_element(
        how, 1, x=-0.8, z=10.0, angle=rng.uniform(-1.5, 1.5), vx=1.0, vz=0.1 * rng.normal(), vw=rng.normal()
    )
    overwrite_initial_state_of_element(
        how, 2, x=0.8, z=10.0 + 0.2 * rng.normal(), angle=rng.uniform(-1.5, 1.5), vx=-1.5, vz=0.0, vw=rng.normal()
    )
    _, _, poses = run_planned_case(how, motion)
    bodies = how.prepared_scenes_by_size_and_damping[0].elements[1:]
    mass, inertia = np.array([b.mass for b in bodies]), np.array([b.inertia_about_centre_of_mass for b in bodies])
    x, z, _, vx, vz, vw = np.moveaxis(poses[:, 1:], 2, 0)
    impulse = np.stack([mass * vx, mass * vz], axis=-1).sum(axis=1)
    # Clockwise: moment of (X, Z) at (p, q) is q X − p Z.
    turning = (inertia * vw + mass * ((z - 10.0) * vx - x * vz)).sum(axis=1)
    energy = 0.5 * (mass * (vx**2 + vz**2) + inertia * vw**2).sum(axis=1)
    return how, np.column_stack([impulse, turning]), energy


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("friction", "damping"), [(0.0, 0.0), (0.5, 3e3)])
def test_momenta_are_conserved_in_a_collision(friction: float, damping: float, seed: int) -> None:
    _, momenta, energy = _momenta_and_energy_of_collision_in_flight(friction, damping, seed)
    scale = np.abs(momenta[0]).max()
    assert abs(energy[-1] / energy[0] - 1) > 1e-3 or damping == 0  # they collided
    # Equal and opposite forces at one point; in the angular sum the velocities lag by half a step.
    assert np.abs(momenta[:, :2] - momenta[0, :2]).max() < 1e-11 * scale
    assert np.abs(momenta[-1, 2] - momenta[0, 2]) < 2e-4 * scale


@pytest.mark.long
@pytest.mark.parametrize(("time_step", "bound"), [("auto", 2e-2), ("0.05 stable", 1e-3), ("0.01 stable", 5e-5)])
def test_a_collision_without_friction_and_damping_conserves_energy(time_step: str, bound: float) -> None:
    """The time of first contact is resolved to one step, so the energy error decreases with the step."""
    for seed in range(6):
        _, _, energy = _momenta_and_energy_of_collision_in_flight(0.0, 0.0, seed, time_step)
        assert energy.min() < 0.97 * energy[0]  # part of it was in the springs: they collided
        assert energy[-1] == pytest.approx(energy[0], rel=bound)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("friction", "damping"), [(0.0, 3e3), (0.5, 3e3), (5.0, 2e4)])
def test_energy_never_rises_in_a_collision(friction: float, damping: float, seed: int) -> None:
    _, _, energy = _momenta_and_energy_of_collision_in_flight(friction, damping, seed)
    assert energy.max() <= energy[0] * (1 + 5e-3)
    assert energy[-1] < energy[0]


def test_energy_balances_for_a_stack_shaken_to_pieces() -> None:
    """Work of the motion equals energy plus losses to 1e-2, through falls and slides of all elements."""
    made = scene_of_elements(*(block_element(f"b{n}", 0.3, 0.4, "ground" if n == 0 else f"b{n - 1}") for n in range(4)))
    time = np.arange(0, 6, 0.005)
    motion = motion_towards_north(7.0 * np.sin(2 * np.pi * time / 0.8), 0.005)
    for friction in (0.3, 0.7, 2.0):
        answers, _, _ = run_planned_case(plan_single_case(made, motion, friction), motion, samples_after_record=4000)
        assert answers.energy_error[0] < 1e-2
        assert answers.status[0] == 0
    assert (answers.overturned != 0).any()
