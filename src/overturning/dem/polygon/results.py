"""Results of a case of a 2-D scene."""

from typing import Any

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.polygon import rows
from overturning.dem.polygon.case_end import (
    MAX_SUPPORT_GAP_OVER_PENETRATION_LIMIT,
    find_fallen_elements_and_store_side_and_time,
    larger_peak_rotation_of_both_sides,
)
from overturning.dem.polygon.energy import (
    contact_force_work_while_velocities_lag_poses,
    kinetic_and_gravitational_energy,
)
from overturning.dem.polygon.resting import (
    largest_penetration_so_far,
)


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_fallen_and_write_case_results(
    case_states: Any, lane: int, scene_arrays: Any, case_result_row: Any, element_result_rows_of_case: Any
) -> None:
    """Mark the fallen elements of a case, and write the results of the case and of its elements into table rows."""
    v = int(case_states[rows.SCENE_VARIANT_INDEX_ROW_OFFSET + lane])
    fall_and_support_table, limits = scene_arrays.fall_and_support_table[v], scene_arrays.termination_limits[v]
    find_fallen_elements_and_store_side_and_time(
        case_states,
        lane,
        scene_arrays,
        fall_and_support_table,
        MAX_SUPPORT_GAP_OVER_PENETRATION_LIMIT * limits.max_penetration,
    )
    work, absorbed = 0.0, contact_force_work_while_velocities_lag_poses(case_states, lane, scene_arrays)
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, _, _ = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        absorbed += q[rows.ABSORBED_ENERGY_ROW_OFFSET + lane]
    for e in range(fall_and_support_table.size):
        item = rows.load_element_state(rows.slice_element_rows(case_states, e), lane)
        totals, record = item.step_motion_with_work_and_peaks_so_far, item.slip_fall_side_and_last_upright_time
        work += totals.work_by_base_and_fixing_forces_so_far
        element_result_rows_of_case[e].overturned = record.fall_side
        element_result_rows_of_case[e].overturning_time = (
            record.last_time_recoverable_and_above_fall_limit if record.fall_side != 0.0 else np.nan
        )
        element_result_rows_of_case[e].peak_rotation = min(larger_peak_rotation_of_both_sides(item), 0.5 * np.pi)
        element_result_rows_of_case[e].peak_slip, element_result_rows_of_case[e].residual_slip = (
            record.peak_slip_on_support,
            record.current_slip_on_support,
        )
    balance = (
        (
            kinetic_and_gravitational_energy(case_states, lane, scene_arrays)
            - rows.load_scene_state(case_states, lane).initial_energy
        )
        - work
        + absorbed
    )
    case_result_row.peak_penetration = largest_penetration_so_far(case_states, lane, scene_arrays)
    case_result_row.energy_error = abs(balance) / max(work, limits.min_reference_energy_of_energy_error, absorbed)
