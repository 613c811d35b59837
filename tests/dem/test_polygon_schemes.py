"""Both integration schemes of the scene kernel: convergence to the same motion, and fallen stones coming to rest."""

import numpy as np
import pytest

from overturning.arrays import FloatArray
from overturning.dem.numerics import NumericalOptions
from overturning.dem.polygon import submatrices
from overturning.dem.run import simulate_cases
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import Scene
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from tests.dem.compiled.polygon_steps import subtract_product_and_divide_submatrices
from tests.dem.polygon_scenes import block_element, load_shipped_scene, motion_towards_north, scene_of_elements


def _scene_with_contact_law(made: Scene, **law: float) -> Scene:
    """Return a copy of the scene `made` with the contact law `law` between its stones."""
    return Scene.model_validate(made.model_dump() | {"contacts": [{"between": ("stone", "stone")} | law]})


def _strong_motion() -> Motion:
    """Return 4 s of strong horizontal motion."""
    time = np.arange(0, 4, 0.01)
    return Motion(np.round(9 * np.sin(5 * time), 9), np.round(6 * np.cos(4 * time), 9), sampling_interval=0.01)


def _cases_in_twelve_azimuths(made: Scene) -> Cases:
    """Return cases of a scene in twelve azimuths, with low and high friction in turn."""
    height, ratio = reference_element_height_and_b_over_h(made)
    return Cases(np.arange(12) * 30.0, height, ratio, np.tile([0.3, 1.0], 6))


@pytest.mark.long
def test_both_schemes_converge_to_one_motion() -> None:
    """For a rocking stack, the centred scheme's error decreases with its step, and Cundall's result agrees to 1e-3."""
    made = _scene_with_contact_law(
        load_shipped_scene("three-tier"), static_penetration=2e-5
    )  # soft, since Cundall's step shrinks with the stiffness
    height, _ = reference_element_height_and_b_over_h(made)
    time = np.arange(0, 2, 0.01)
    motion = motion_towards_north(np.round(4.0 * np.sin(9 * time) * (time < 0.7), 9))
    cases = Cases(0.0, height, [0.335, 0.34, 0.345, 0.35, 0.36], 1.0)

    def peak_rotations_of_shaft(time_step: str, scheme: str = "centred") -> FloatArray:
        """Return the peak rotation of the shaft over its critical angle α in each case; all stones must stand."""
        found = simulate_cases(made, motion, cases, NumericalOptions(scheme=scheme, time_step=time_step))
        assert (found.overturned == 0).all()
        return found.peak_rotation[:, 2].astype(np.float64)

    finest = peak_rotations_of_shaft("0.01 stable")
    assert (finest > 0.05).all()
    error = [np.abs(peak_rotations_of_shaft(f"{fraction} stable") / finest - 1).max() for fraction in (0.5, 0.12, 0.03)]
    assert error[2] < error[1] < error[0] < 5e-3
    assert np.abs(peak_rotations_of_shaft("0.1 stable", "cundall") / finest - 1).max() < 1e-3


@pytest.mark.long
@pytest.mark.parametrize("ratio", [0.05, 1.0, 3.0, 8.0])
def test_fallen_and_standing_stones_come_to_rest_at_the_default_step(ratio: float) -> None:
    """For any damping, vibrations end before a case becomes undecided, and work and energy balance."""
    made = _scene_with_contact_law(load_shipped_scene("three-tier"), damping_ratio=ratio)
    found = simulate_cases(made, _strong_motion(), _cases_in_twelve_azimuths(made), NumericalOptions(leave_out=False))
    assert (found.overturned[:, 2] != 0).any()
    assert (found.status == CaseStatus.SIMULATED).all()
    assert found.energy_error.max() < 1e-3


def test_all_cases_of_a_tower_are_decided_and_its_top_falls_in_some() -> None:
    made = scene_of_elements(*(block_element(f"b{k}", 0.4, 0.2, f"b{k - 1}" if k else "ground") for k in range(6)))
    found = simulate_cases(made, _strong_motion(), _cases_in_twelve_azimuths(made), NumericalOptions(leave_out=False))
    assert (found.overturned[:, 5] != 0).any()
    assert (found.status == CaseStatus.SIMULATED).all()


def test_submatrix_operations_of_the_kernel_equal_those_of_numpy() -> None:
    given = np.random.default_rng(2).normal(size=(2, 3, 3)) + 3.0 * np.eye(3)
    size = submatrices.SUBMATRIX_ROW_LAYOUT.array_length
    fresh, added, one, other = (
        np.repeat(matrix.ravel(), size // 9) for matrix in (np.full((3, 3), np.nan), given[0], *given)
    )
    subtract_product_and_divide_submatrices(fresh, added, one, other)
    np.testing.assert_allclose(fresh.reshape(3, 3, -1)[..., 5], -given[0] @ given[1])
    np.testing.assert_allclose(added.reshape(3, 3, -1)[..., 5], given[0] - given[0] @ given[1])
    np.testing.assert_allclose(one.reshape(3, 3, -1)[..., 5], given[0] @ np.linalg.inv(given[1]))
