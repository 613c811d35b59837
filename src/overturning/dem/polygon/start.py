"""Start of a scene case: state of the case and of its pairs of elements in the column of a lane."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import LastSampleOfContinuedSlidingCase
from overturning.dem.kernel.ground import LinearBaseAcceleration
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.polygon import rows
from overturning.dem.polygon.contact_history import set_pair_forces_from_penetration_and_stretch
from overturning.dem.polygon.energy import pair_spring_energy
from overturning.dem.polygon.search import update_nearest_faces_and_contact_history
from overturning.dem.polygon.state import (
    ContactPointConstants,
    SceneBaseAccelerationInSample,
    SceneStateAndConstants,
    StepDecisionAndNextAttempt,
)

CASE_END_TEST_INTERVAL_S: Final = 0.1
"""Interval at which a case is tested for its end, s of the record; at least one sample."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_initial_case_state(
    case_states: Any,
    lane: int,
    case_parameter_row: Any,
    scene_variant_index: float,
    sampling_interval: float,
    ticks_per_sample: float,
    velocity_lag_behind_pose_steps: float,
) -> None:
    """Write the initial `SceneStateAndConstants` of a case into column `lane` of the state array."""
    step, none, last_check = (
        sampling_interval / ticks_per_sample,
        LinearBaseAcceleration(0.0, 0.0, 0.0),
        case_parameter_row.first_simulated_sample // max(int(CASE_END_TEST_INTERVAL_S / sampling_interval), 1),
    )
    first = NextStepToAttempt(
        case_parameter_row.min_allowed_step_ticks, case_parameter_row.steps_before_doubling_after_contact_change, 0.0
    )
    case_step_length_settings = CaseStepLengthsAndDoublingCounts(
        case_parameter_row.min_allowed_step_ticks,
        case_parameter_row.longest_step_with_all_contacts_closed_ticks,
        case_parameter_row.steps_before_doubling_after_contact_change,
        case_parameter_row.long_steps_before_doubling,
    )
    rows.store_scene_state(
        case_states,
        lane,
        SceneStateAndConstants(
            base_acceleration=SceneBaseAccelerationInSample(none, none, 0.0),
            tick_duration=step,
            ticks_per_second=ticks_per_sample / sampling_interval,
            velocity_lag_behind_pose=velocity_lag_behind_pose_steps * step,
            case_step_length_settings=case_step_length_settings,
            current_step_length_and_repetitions=first,
            contact_changes=rows.create_zero_step_contact_changes(),
            step_decision_and_next_attempt=StepDecisionAndNextAttempt(0.0, 0.0, NextStepToAttempt(0.0, 0.0, 0.0)),
            amplitude_factor=case_parameter_row.amplitude_factor,
            max_base_acceleration_without_motion_g=case_parameter_row.max_base_acceleration_without_motion_g,
            current_sample=case_parameter_row.first_simulated_sample,
            cannot_start_moving_from_sample=case_parameter_row.cannot_start_moving_from_sample,
            end_sample_if_undecided=case_parameter_row.end_sample_if_undecided,
            initial_energy=0.0,
            scene_variant_index=scene_variant_index,
            interval_index_of_last_case_end_test=last_check,
            last_sample_of_continued_sliding_case=LastSampleOfContinuedSlidingCase(0.0),
        ),
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_initial_pair_states(
    case_states: Any, lane: int, case_parameter_row: Any, scene_arrays: Any, face_table_by_piece: Any
) -> None:
    """Write contact law, nearest faces and loads at rest of all contacts of a scene into column `lane`."""
    lag = rows.load_scene_state(case_states, lane).velocity_lag_behind_pose
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        m, n, pair = (
            scene_arrays.pair_element_and_piece_indices[p, 2],
            scene_arrays.pair_element_and_piece_indices[p, 3],
            rows.load_pair_state(q, lane),
        )
        law, settled = pair.contact_law, pair.nearest_faces.max_motion_keeping_nearest_faces == np.inf
        friction = (
            law.friction_coefficient
            if law.friction_coefficient >= 0.0
            else case_parameter_row.friction_coefficient_if_law_has_none
        )
        dashpot = law.dashpot_coefficient * case_parameter_row.dashpot_coefficient_multiplier
        rows.store_contact_law(q, lane, ContactPointConstants(
            law.normal_stiffness, law.tangential_stiffness, dashpot, friction,
            law.tangential_compliance_or_zero_without_spring,
            law.prescribed_flat_landing_duration * dashpot / law.normal_stiffness
        ))  # fmt: skip
        update_nearest_faces_and_contact_history(
            q,
            a,
            b,
            lane,
            2.0 * lag,
            face_table_by_piece[m, : scene_arrays.piece_vertex_counts[m]],
            face_table_by_piece[n, : scene_arrays.piece_vertex_counts[n]],
        )
        if settled:
            (
                q[rows.MAX_MOTION_KEEPING_NEAREST_FACES_ROW_OFFSET + lane],
                q[rows.MAX_MOTION_WITHOUT_CONTACT_ROW_OFFSET + lane],
            ) = (
                np.inf,
                -1.0,
            )
        set_pair_forces_from_penetration_and_stretch(q, lane)
        q[rows.ABSORBED_ENERGY_ROW_OFFSET + lane] = pair_spring_energy(rows.load_pair_state(q, lane))
