"""Memory layout of scene cases: the fields of named tuples are rows of an array that has a column per case.

The array has the rows of the case (`SceneStateAndConstants`), then those of each element (`ElementState`) and pair
(`PairState`). Functions for one case take and return these tuples; ``load_element_state(rows, j)``, ``store_pose(rows,
j, pose)`` and so on read and write column j. The innermost loops run over the columns without branches, so that LLVM
vectorises them. They use only ``+ - * /`` and comparisons: the bits of a case depend neither on its neighbours, nor on
the thread, nor on the vector width of the processor.
"""

from collections.abc import Iterable
from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import (
    INTERNAL_COMPILE_OPTIONS,
    TupleRowLayout,
    create_tuple_sum_difference_and_maximum_functions,
    create_window_slicer,
)
from overturning.dem.polygon.faces import ContactSegment
from overturning.dem.polygon.mechanics import PredictedStretchAndAssumedFriction
from overturning.dem.polygon.state import (
    ElementState,
    PairContactStateAfterLastStep,
    PairState,
    SceneStateAndConstants,
    StepContactChangesAsFloats,
)

PARALLEL_CASE_COUNT: Final = 8
"""Number of cases computed together: one widest vector, so that the data of a stack of three fits into the L1 cache."""


class PairContactResultsDuringStep(NamedTuple):
    """Intermediate contact results for two elements in a centred-scheme step, from prediction to solution."""

    contact_segment: ContactSegment
    predicted_stretch_and_friction_at_point_1: PredictedStretchAndAssumedFriction
    predicted_stretch_and_friction_at_point_2: PredictedStretchAndAssumedFriction
    contact_state_after_step: PairContactStateAfterLastStep
    """History at the end of the step, used only if the step is accepted."""


CASE_ROW_LAYOUT: Final = TupleRowLayout(PARALLEL_CASE_COUNT, SceneStateAndConstants)
ELEMENT_ROW_LAYOUT: Final = TupleRowLayout(PARALLEL_CASE_COUNT, ElementState)
PAIR_ROW_LAYOUT: Final = TupleRowLayout(PARALLEL_CASE_COUNT, PairState, PairContactResultsDuringStep)
VALUE_COUNT_PER_CASE_IN_ALL_LANES, VALUE_COUNT_PER_ELEMENT_IN_ALL_LANES, VALUE_COUNT_PER_PAIR_IN_ALL_LANES = (
    CASE_ROW_LAYOUT.array_length,
    ELEMENT_ROW_LAYOUT.array_length,
    PAIR_ROW_LAYOUT.array_length,
)

load_scene_state, store_scene_state, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(SceneStateAndConstants)
_, store_horizontal_base_acceleration, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(
    SceneStateAndConstants, "base_acceleration.horizontal"
)
_, store_vertical_base_acceleration, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(
    SceneStateAndConstants, "base_acceleration.vertical"
)
_, store_next_step_to_attempt, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(
    SceneStateAndConstants, "current_step_length_and_repetitions"
)
_, store_step_decision_and_next_attempt, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(
    SceneStateAndConstants, "step_decision_and_next_attempt"
)
_, store_largest_contact_changes, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(SceneStateAndConstants, "contact_changes")
create_zero_step_contact_changes = create_tuple_sum_difference_and_maximum_functions(StepContactChangesAsFloats).zero
load_element_state, _, _ = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(ElementState)
load_pose, store_pose, store_pose_unless_rejected = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(ElementState, "pose")
_, store_velocity, store_velocity_unless_rejected = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(ElementState, "velocity")
_, store_predicted_motion, _ = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(ElementState, "predicted")
load_step_end_velocity_correction, store_step_end_velocity_correction, _ = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(
    ElementState, "predicted.step_end_velocity_correction"
)
_, store_acceleration, store_acceleration_unless_rejected = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(
    ElementState, "acceleration"
)
load_contact_force_sum, store_contact_force_sum, _ = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(
    ElementState, "contact_force_sum"
)
load_element_constants, _, _ = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(ElementState, "constants")
_, store_step_motion_work_and_peaks, store_step_motion_work_and_peaks_unless_rejected = (
    ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(ElementState, "step_motion_with_work_and_peaks_so_far")
)
_, store_motion_since_first_pair_suspended, _ = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(
    ElementState, "motion_since_first_contact_test_pause"
)
_, store_slip_and_fall_state, _ = ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(
    ElementState, "slip_fall_side_and_last_upright_time"
)
load_rest_pose_and_slip_measurement_points, store_rest_pose_and_slip_measurement_points, _ = (
    ELEMENT_ROW_LAYOUT.tuple_reader_and_writer(ElementState, "rest_pose_and_slip_measurement_points")
)
load_pair_state, _, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(PairState)
_, store_nearest_face_of_a, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(PairState, "nearest_face_of_a")
_, store_nearest_face_of_b, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(PairState, "nearest_face_of_b")
_, store_vertex_contact_limits, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(
    PairState, "ranges_where_vertices_touch_opposite_faces"
)
_, store_contact_law, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(PairState, "contact_law")
load_nearest_faces_and_motion_limits, store_nearest_faces_and_motion_limits, _ = (
    PAIR_ROW_LAYOUT.tuple_reader_and_writer(PairState, "nearest_faces")
)
_, store_contact_history, store_contact_history_unless_rejected = PAIR_ROW_LAYOUT.tuple_reader_and_writer(
    PairState, "history"
)
_, store_previous_vertex_positions, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(
    PairState, "history.previous_vertex_positions"
)
load_point_1_history, store_point_1_history, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(PairState, "history.point_1")
load_intermediate_step_results, _, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(PairContactResultsDuringStep)
_, store_contact_segment, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(
    PairContactResultsDuringStep,
    "contact_segment",
    ("cosine_of_angle_between_outward_normals", "sine_of_angle_between_outward_normals", "is_in_contact"),
)
_, store_predicted_stretch_and_friction_at_point_1, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(
    PairContactResultsDuringStep, "predicted_stretch_and_friction_at_point_1"
)
_, store_predicted_stretch_and_friction_at_point_2, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(
    PairContactResultsDuringStep, "predicted_stretch_and_friction_at_point_2"
)
_, store_history_after_step, _ = PAIR_ROW_LAYOUT.tuple_reader_and_writer(
    PairContactResultsDuringStep, "contact_state_after_step"
)

# Rows that are accessed singly.
_SINGLY_ACCESSED_CASE_FIELD_PATHS = (
    "base_acceleration.ticks_since_sample_start current_sample initial_energy scene_variant_index "
    "interval_index_of_last_case_end_test "
    "last_sample_of_continued_sliding_case.end_sample_while_sliding_or_zero_if_unknown "
    "current_step_length_and_repetitions.length_in_ticks "
    "contact_changes.contact_or_nearest_faces_changed step_decision_and_next_attempt.positive_if_rejected"
)
(
    TICKS_SINCE_SAMPLE_START_ROW_OFFSET,
    CURRENT_SAMPLE_ROW_OFFSET,
    INITIAL_ENERGY_ROW_OFFSET,
    SCENE_VARIANT_INDEX_ROW_OFFSET,
    LAST_END_TEST_INTERVAL_INDEX_ROW_OFFSET,
    SLIDING_CASE_END_SAMPLE_ROW_OFFSET,
    ATTEMPTED_STEP_TICKS_ROW_OFFSET,
    CONTACT_CHANGED_ROW_OFFSET,
    STEP_IS_REJECTED_ROW_OFFSET,
) = (CASE_ROW_LAYOUT.row_offset_of_field(SceneStateAndConstants, p) for p in _SINGLY_ACCESSED_CASE_FIELD_PATHS.split())
_ELEMENT_FIELD_PATHS_OF_ROW_OFFSETS = (
    "constants.has_inertial_forces_in_base_frame step_motion_with_work_and_peaks_so_far.abs_dx_plus_abs_dz_in_step "
    "step_motion_with_work_and_peaks_so_far.abs_rotation_in_step "
    "slip_fall_side_and_last_upright_time.last_time_recoverable_and_above_fall_limit "
    "slip_fall_side_and_last_upright_time.last_time_on_support slip_fall_side_and_last_upright_time.fall_side"
)
(
    MOVES_RELATIVE_TO_BASE_ROW_OFFSET,
    STEP_ABS_DX_PLUS_ABS_DZ_ROW_OFFSET,
    STEP_ABS_ROTATION_ROW_OFFSET,
    LAST_TIME_ABLE_TO_RETURN_ROW_OFFSET,
    LAST_TIME_ON_SUPPORT_ROW_OFFSET,
    FALL_SIDE_ROW_OFFSET,
) = (ELEMENT_ROW_LAYOUT.row_offset_of_field(ElementState, p) for p in _ELEMENT_FIELD_PATHS_OF_ROW_OFFSETS.split())
LAST_TICK_ABLE_TO_RETURN_UPRIGHT_ROW_OFFSET: Final = ELEMENT_ROW_LAYOUT.row_offset_of_field(
    ElementState, "step_motion_with_work_and_peaks_so_far.last_recoverable_tick_in_sample"
)
_PAIR_FIELD_PATHS_OF_ROW_OFFSETS = (
    "nearest_faces.max_motion_keeping_nearest_faces nearest_faces.max_motion_without_contact "
    "nearest_faces.motion_since_face_search nearest_faces.relative_motion_bound_since_search_at_step_end "
    "signed_mu_of_point_1_or_0_if_sticking signed_mu_of_point_2_or_0_if_sticking history.absorbed_energy"
)
(
    MAX_MOTION_KEEPING_NEAREST_FACES_ROW_OFFSET,
    MAX_MOTION_WITHOUT_CONTACT_ROW_OFFSET,
    MOTION_SINCE_FACE_SEARCH_ROW_OFFSET,
    MAX_MOTION_SINCE_SEARCH_AT_STEP_END_ROW_OFFSET,
    POINT_1_SIGNED_FRICTION_OR_ZERO_ROW_OFFSET,
    POINT_2_SIGNED_FRICTION_OR_ZERO_ROW_OFFSET,
    ABSORBED_ENERGY_ROW_OFFSET,
) = (PAIR_ROW_LAYOUT.row_offset_of_field(PairState, p) for p in _PAIR_FIELD_PATHS_OF_ROW_OFFSETS.split())
ROTATION_TO_MOTION_LEVER_ARM_ROW_OFFSET: Final = PAIR_ROW_LAYOUT.row_offset_of_field(
    PairState, "nearest_faces.lever_arm_converting_rotation_to_motion"
)
ROW_OFFSET_FROM_POINT_1_TO_POINT_2: Final = PAIR_ROW_LAYOUT.row_offset_of_field(
    PairState, "history.point_2.tangential_spring_stretch"
) - PAIR_ROW_LAYOUT.row_offset_of_field(PairState, "history.point_1.tangential_spring_stretch")


def flatten_nested_tuples(nested_tuples: Iterable[Any]) -> list[float]:
    """Return the numbers of nested tuples as a flat list, in the order of the rows of the state array."""
    return [
        number
        for value in nested_tuples
        for number in (flatten_nested_tuples(value) if isinstance(value, tuple) else [float(value)])
    ]


slice_element_rows: Final = create_window_slicer(
    VALUE_COUNT_PER_ELEMENT_IN_ALL_LANES, VALUE_COUNT_PER_CASE_IN_ALL_LANES
)
"""``slice_element_rows(state, i)``: return the rows of element i."""

_slice_pair_rows = create_window_slicer(VALUE_COUNT_PER_PAIR_IN_ALL_LANES, VALUE_COUNT_PER_CASE_IN_ALL_LANES, 1)


@njit(inline="always", **INTERNAL_COMPILE_OPTIONS)
def slice_pair_and_element_rows(case_states: Any, scene_arrays: Any, pair_index: int) -> tuple[Any, Any, Any]:
    """Return views of the state array: the rows of a contact and of its elements a and b, for all cases in parallel."""
    q = _slice_pair_rows(
        case_states,
        scene_arrays.fall_and_support_table.shape[1] * VALUE_COUNT_PER_ELEMENT_IN_ALL_LANES
        + pair_index * VALUE_COUNT_PER_PAIR_IN_ALL_LANES,
    )
    return (
        q,
        slice_element_rows(case_states, scene_arrays.pair_element_and_piece_indices[pair_index, 0]),
        slice_element_rows(case_states, scene_arrays.pair_element_and_piece_indices[pair_index, 1]),
    )
