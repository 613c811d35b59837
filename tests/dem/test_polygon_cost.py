"""Cost of a step: proportional to the number of elements of a stack. Operations are counted, not timed."""

from typing import Any

import numpy as np
import pytest

from overturning.dem.numerics import NumericalOptions
from overturning.dem.polygon import rows
from overturning.dem.polygon.plan import plan_scene_simulation
from overturning.dem.polygon.state import ElementState
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene
from tests.dem.compiled.polygon_steps import (
    run_case_and_return_max_tested_pairs_and_state,
    solve_equations_and_count_nonzero_submatrices,
)
from tests.dem.polygon_scenes import block_element, motion_towards_north, scene_of_elements

VELOCITY_CORRECTION_X_ROW_OFFSET = rows.ELEMENT_ROW_LAYOUT.row_offset_of_field(
    ElementState, "predicted.step_end_velocity_correction.x"
)


def count_nonzero_submatrices_and_solve_by_both_solvers(
    size: int, links: list[tuple[int, int]], seed: int
) -> tuple[int, np.ndarray, np.ndarray]:
    """Return the number of nonzero submatrices, the kernel's and a dense solver's solution of random equations."""
    rng = np.random.default_rng(seed)
    blocks = np.zeros((size, size, 3, 3))
    for i, k in [*links, *((k, i) for i, k in links)]:
        blocks[i, k] = 0.3 * rng.normal(size=(3, 3))
    for k in range(size):
        blocks[k, k] = 3.0 * np.eye(3) + 0.3 * rng.normal(size=(3, 3))
    right = rng.normal(size=(size, 3))
    state = np.zeros(rows.VALUE_COUNT_PER_CASE_IN_ALL_LANES + size * rows.VALUE_COUNT_PER_ELEMENT_IN_ALL_LANES)
    places = (
        rows.VALUE_COUNT_PER_CASE_IN_ALL_LANES
        + np.arange(size)[:, None] * rows.VALUE_COUNT_PER_ELEMENT_IN_ALL_LANES
        + VELOCITY_CORRECTION_X_ROW_OFFSET
        + np.arange(3) * rows.PARALLEL_CASE_COUNT
    )
    for j in range(rows.PARALLEL_CASE_COUNT):
        state[places + j] = right
    used, left_over, _, _ = solve_equations_and_count_nonzero_submatrices(
        state, blocks, np.array(links, np.int64), size
    )
    assert not left_over, "the pattern is empty for the next step"
    dense = blocks.transpose(0, 2, 1, 3).reshape(3 * size, 3 * size)
    return used, state[places + 5], np.linalg.solve(dense, right.ravel()).reshape(size, 3)


@pytest.mark.parametrize("size", [2, 8, 33, 64])
def test_solving_a_stack_needs_submatrices_in_proportion_to_its_elements(size: int) -> None:
    chain = [(k, k + 1) for k in range(size - 1)]
    for links in (chain, [(k, i) for i, k in chain]):
        used, found, expected = count_nonzero_submatrices_and_solve_by_both_solvers(size, links, size)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
        assert used == 3 * size - 2


@pytest.mark.parametrize("seed", range(5))
def test_the_solution_for_any_contact_pattern_equals_a_dense_solution(seed: int) -> None:
    rng, size = np.random.default_rng(seed), 9
    every = [(int(i), int(k)) for i, k in rng.integers(0, size, (14, 2)) if i != k]
    links = list({tuple(sorted(pair)): pair for pair in every}.values())
    _, found, expected = count_nonzero_submatrices_and_solve_by_both_solvers(size, links, seed)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def max_tested_pairs_per_step_and_final_state(
    made: Scene, peak: float, samples: int, sleep: bool
) -> tuple[int, np.ndarray]:
    """Simulate a scene for some samples; return the most pairs of elements tested in a step, and the final state.

    With `sleep` False, pairs that cannot touch are tested in every step, too.
    """
    time = np.arange(0.0, 2.0, 0.01)
    motion = motion_towards_north(peak * np.sin(2.0 * np.pi * time))
    planned: Any = plan_scene_simulation(
        PlanarModel(made),
        motion,
        Cases([0.0], *reference_element_height_and_b_over_h(made), 0.6),
        NumericalOptions(leave_out=False),
    )
    chosen = np.zeros(1, np.int64)
    most, found, _ = run_case_and_return_max_tested_pairs_and_state(
        planned.kernel_input(chosen, planned.create_result_tables(1), 1), samples, sleep
    )
    return most, found


def stack_of_equal_blocks(count: int) -> Scene:
    """Return a scene of equal blocks (0.5 m × 0.2 m), each on the one before."""
    return scene_of_elements(*(block_element(f"b{k}", 0.5, 0.2, f"b{k - 1}" if k else "ground") for k in range(count)))


def test_a_step_tests_contacts_between_neighbouring_elements_only() -> None:
    """With the ground, n elements make n (n + 1)/2 pairs."""
    most = [
        max_tested_pairs_per_step_and_final_state(stack_of_equal_blocks(count), 1.0, 20, True)[0] for count in (8, 16)
    ]
    assert most[0] < 36
    # Each element is tested against the next one, and at most the one after that.
    assert (np.array(most) <= 2 * np.array([8, 16])).all()


def test_suspending_contact_tests_of_pairs_does_not_change_a_tower_collapse() -> None:
    made = scene_of_elements(*(block_element(f"b{k}", 0.2, 0.4, f"b{k - 1}" if k else "ground") for k in range(5)))
    most, state = max_tested_pairs_per_step_and_final_state(made, 12.0, 200, True)
    every, expected = max_tested_pairs_per_step_and_final_state(made, 12.0, 200, False)
    assert (most, every) != (15, 15)
    poses = [rows.ELEMENT_ROW_LAYOUT.row_offset_of_field(ElementState, f"pose.{name}") for name in ("x", "z", "angle")]
    speeds = [
        rows.ELEMENT_ROW_LAYOUT.row_offset_of_field(ElementState, f"velocity.{name}") for name in ("x", "z", "angular")
    ]
    found, full = (
        values[rows.VALUE_COUNT_PER_CASE_IN_ALL_LANES :].reshape(-1, rows.VALUE_COUNT_PER_ELEMENT_IN_ALL_LANES)[
            :, [*poses, *speeds]
        ]
        for values in (state, expected)
    )
    assert np.abs(full[1:, 2]).max() > 0.1, "it moves"
    np.testing.assert_array_equal(found, full)
