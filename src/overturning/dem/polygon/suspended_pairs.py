"""Suspended pairs: pairs too far apart to touch soon are skipped until their elements have moved far enough.

Any two of n elements can meet, but a stone in a stack touches only two others. A pair is suspended as long as the sum
over all steps of the largest motion of any element is too small to bring it into contact. Meanwhile each element adds
up its own motion; the pair gets these sums when it is resumed, so that its nearest faces are searched in the same step
as if it had never been suspended.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import (
    ALLOCATING_INLINE_OPTIONS,
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
)
from overturning.dem.kernel.mechanics import updated_maximum
from overturning.dem.polygon import rows
from overturning.dem.polygon.state import ElementMotionSinceFirstPairSuspended

MOTION_SUM_MARK_OF_ACTIVE_PAIR: Final = -1.0
"""Value of `PairContactTestSchedule.motion_sum_at_next_contact_test` for an active pair."""


class PairContactTestSchedule(NamedTuple):
    """Element pairs tested for contact at each step, and the motions at which distant pairs are tested again."""

    indices_of_pairs_tested_each_step: Any
    """Indices of the pairs tested at each step, ascending, shape (pairs,); the first `active_pair_count` are valid."""
    may_touch_by_pair: Any
    """True for a pair that could touch in this step, shape (pairs,)."""
    motion_sum_at_next_contact_test: Any
    """Sum of motions (m) at which each pair is tested again, or `MOTION_SUM_MARK_OF_ACTIVE_PAIR`, shape (pairs,)."""
    active_pair_count: Any
    """Number of active pairs, shape (1,)."""
    largest_motion_sum_next_test_sum_and_lever_arm: Any
    """Largest sum of motions of two elements so far (m), sum at which the next pair is tested again (m), and longest
    lever arm of a pair not tested now (m), shape (3,)."""
    largest_motions_over_elements_by_case: Any
    """Largest motion (m) and rotation (rad) of any element in the last step, then the same as predicted for this step;
    four rows with a column per case, shape (4 columns,)."""


LARGEST_MOTION_SUM_INDEX, NEXT_PAIR_TEST_MOTION_SUM_INDEX, LEVER_ARM_INDEX_IN_MOTION_SUMS = 0, 1, 2


@njit(**ALLOCATING_INLINE_OPTIONS)
def create_contact_test_schedule_of_all_pairs(pair_count: int) -> Any:
    """Return the schedule of a scene with `pair_count` element pairs, all tested for contact at each step."""
    travel = np.zeros(3)
    travel[NEXT_PAIR_TEST_MOTION_SUM_INDEX] = np.inf
    number = np.zeros(1, np.int64)
    number[0] = pair_count
    return PairContactTestSchedule(
        np.arange(pair_count),
        np.zeros(pair_count, np.bool_),
        np.full(pair_count, MOTION_SUM_MARK_OF_ACTIVE_PAIR),
        number,
        travel,
        np.zeros(4 * rows.PARALLEL_CASE_COUNT),
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def update_largest_motions_with_element(element_state_rows: Any, largest_motions_over_elements_by_case: Any) -> None:
    """Include an element's motion in each case's maxima over elements, `largest_motions_over_elements_by_case`."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        item = rows.load_element_state(element_state_rows, j)
        largest_motions_over_elements_by_case[j] = updated_maximum(
            largest_motions_over_elements_by_case[j],
            item.step_motion_with_work_and_peaks_so_far.abs_dx_plus_abs_dz_in_step,
        )
        largest_motions_over_elements_by_case[rows.PARALLEL_CASE_COUNT + j] = updated_maximum(
            largest_motions_over_elements_by_case[rows.PARALLEL_CASE_COUNT + j],
            item.step_motion_with_work_and_peaks_so_far.abs_rotation_in_step,
        )
        largest_motions_over_elements_by_case[2 * rows.PARALLEL_CASE_COUNT + j] = updated_maximum(
            largest_motions_over_elements_by_case[2 * rows.PARALLEL_CASE_COUNT + j],
            item.predicted.abs_dx_plus_abs_dz_in_step,
        )
        largest_motions_over_elements_by_case[3 * rows.PARALLEL_CASE_COUNT + j] = updated_maximum(
            largest_motions_over_elements_by_case[3 * rows.PARALLEL_CASE_COUNT + j],
            item.predicted.abs_rotation_in_step,
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_last_step_to_summed_motion(element_state_rows: Any) -> None:
    """Add an element's motion in the last step to its sum of motions since the first pause of any contact tests."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        item = rows.load_element_state(element_state_rows, j)
        rows.store_motion_since_first_pair_suspended(
            element_state_rows,
            j,
            ElementMotionSinceFirstPairSuspended(
                item.motion_since_first_contact_test_pause.abs_dx_plus_abs_dz_sum
                + item.step_motion_with_work_and_peaks_so_far.abs_dx_plus_abs_dz_in_step,
                item.motion_since_first_contact_test_pause.abs_rotation_sum
                + item.step_motion_with_work_and_peaks_so_far.abs_rotation_in_step,
            ),
        )


@njit(**INLINE_OPTIONS)
def pair_motion_since_contact_tests_paused(
    pair_state_rows: Any, element_a_state_rows: Any, element_b_state_rows: Any, lane: int
) -> float:
    """Return two elements' Σ (|Δx| + |Δz| + lever arm × |rotation|), m, since the first pause of contact tests."""
    lever = rows.load_nearest_faces_and_motion_limits(pair_state_rows, lane).lever_arm_converting_rotation_to_motion
    a, b = (
        rows.load_element_state(element_a_state_rows, lane).motion_since_first_contact_test_pause,
        rows.load_element_state(element_b_state_rows, lane).motion_since_first_contact_test_pause,
    )
    return (a.abs_dx_plus_abs_dz_sum + b.abs_dx_plus_abs_dz_sum) + lever * (a.abs_rotation_sum + b.abs_rotation_sum)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def begin_pause_of_pair_contact_tests(
    pair_state_rows: Any, element_a_state_rows: Any, element_b_state_rows: Any
) -> None:
    """Pause contact tests of two elements: subtract their motion sums from the pair's `motion_since_face_search`."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        motion = pair_motion_since_contact_tests_paused(pair_state_rows, element_a_state_rows, element_b_state_rows, j)
        pair_state_rows[rows.MOTION_SINCE_FACE_SEARCH_ROW_OFFSET + j] = (
            pair_state_rows[rows.MOTION_SINCE_FACE_SEARCH_ROW_OFFSET + j] - motion
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def end_pause_of_pair_contact_tests(pair_state_rows: Any, element_a_state_rows: Any, element_b_state_rows: Any) -> None:
    """Resume contact tests of two elements: add their motion sums to the pair's `motion_since_face_search`."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        motion = pair_motion_since_contact_tests_paused(pair_state_rows, element_a_state_rows, element_b_state_rows, j)
        pair_state_rows[rows.MOTION_SINCE_FACE_SEARCH_ROW_OFFSET + j] = (
            pair_state_rows[rows.MOTION_SINCE_FACE_SEARCH_ROW_OFFSET + j] + motion
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def min_motion_to_contact_and_max_lever_arm(pair_state_rows: Any) -> tuple[float, float]:
    """Return the least motion (m) after which two elements could touch in any case, and their lever arm (m).

    The lever arm, the largest of all cases, converts rotation to motion. Both are 0 if the elements are near.
    """
    slack, lever = np.inf, 0.0
    for j in range(rows.PARALLEL_CASE_COUNT):
        reach, ahead = (
            pair_state_rows[rows.MAX_MOTION_WITHOUT_CONTACT_ROW_OFFSET + j],
            pair_state_rows[rows.MAX_MOTION_SINCE_SEARCH_AT_STEP_END_ROW_OFFSET + j],
        )
        # Written so that NaN keeps the pair active.
        if not ahead < 0.5 * reach:
            return 0.0, 0.0
        slack, lever = (
            min(slack, reach - ahead),
            max(lever, pair_state_rows[rows.ROTATION_TO_MOTION_LEVER_ARM_ROW_OFFSET + j]),
        )
    return slack, lever


@njit(**INTERNAL_COMPILE_OPTIONS)
def resume_contact_tests_after_motion(
    case_states: Any,
    scene_arrays: Any,
    pair_contact_test_schedule: PairContactTestSchedule,
    largest_motion_sum_of_any_two_elements: float,
) -> None:
    """Test again for contact those distant element pairs that could touch after a given sum of motions.

    `largest_motion_sum_of_any_two_elements` (m) counts from the first pause of any contact tests; infinity resumes all
    tests.
    """
    count, following = 0, np.inf
    for p in range(pair_contact_test_schedule.motion_sum_at_next_contact_test.size):
        at = pair_contact_test_schedule.motion_sum_at_next_contact_test[p]
        if at != MOTION_SUM_MARK_OF_ACTIVE_PAIR and not largest_motion_sum_of_any_two_elements < at:
            q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
            end_pause_of_pair_contact_tests(q, a, b)
            pair_contact_test_schedule.motion_sum_at_next_contact_test[p] = at = MOTION_SUM_MARK_OF_ACTIVE_PAIR
        if at == MOTION_SUM_MARK_OF_ACTIVE_PAIR:
            pair_contact_test_schedule.indices_of_pairs_tested_each_step[count] = p
            count += 1
        else:
            following = min(following, at)
    (
        pair_contact_test_schedule.active_pair_count[0],
        pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[NEXT_PAIR_TEST_MOTION_SUM_INDEX],
    ) = count, following
    if count == pair_contact_test_schedule.motion_sum_at_next_contact_test.size:
        pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[
            LARGEST_MOTION_SUM_INDEX
        ] = pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[
            LEVER_ARM_INDEX_IN_MOTION_SUMS
        ] = 0.0


@njit(**INTERNAL_COMPILE_OPTIONS)
def sum_motions_and_resume_contact_tests(
    case_states: Any, scene_arrays: Any, pair_contact_test_schedule: PairContactTestSchedule, element_count: int
) -> None:
    """Add the last step's motion to the sums of motions; test distant pairs again that could touch in this step."""
    if (
        pair_contact_test_schedule.active_pair_count[0]
        == pair_contact_test_schedule.motion_sum_at_next_contact_test.size
    ):
        return
    largest, lever = (
        pair_contact_test_schedule.largest_motions_over_elements_by_case,
        pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[LEVER_ARM_INDEX_IN_MOTION_SUMS],
    )
    for k in range(largest.size):
        largest[k] = 0.0
    for i in range(element_count):
        update_largest_motions_with_element(rows.slice_element_rows(case_states, i), largest)
    last, ahead = 0.0, 0.0
    for j in range(rows.PARALLEL_CASE_COUNT):
        moved, turned = largest[j], largest[rows.PARALLEL_CASE_COUNT + j]
        far, turn = largest[2 * rows.PARALLEL_CASE_COUNT + j], largest[3 * rows.PARALLEL_CASE_COUNT + j]
        last, ahead = max(last, moved + lever * turned), max(ahead, far + lever * turn)
    # Factor 2: both elements of a pair may move. Predicted motion counts twice, as in
    # `search.sum_pair_motion_and_count_near_and_search_cases`.
    pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[LARGEST_MOTION_SUM_INDEX] += 2.0 * last
    travel = (
        pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[LARGEST_MOTION_SUM_INDEX]
        + 4.0 * ahead
    )
    if (
        not travel
        < pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[NEXT_PAIR_TEST_MOTION_SUM_INDEX]
    ):
        resume_contact_tests_after_motion(case_states, scene_arrays, pair_contact_test_schedule, travel)
    for i in range(element_count):
        add_last_step_to_summed_motion(rows.slice_element_rows(case_states, i))


@njit(**INTERNAL_COMPILE_OPTIONS)
def keep_contact_tests_unless_distant(
    pair_state_rows: Any,
    element_a_state_rows: Any,
    element_b_state_rows: Any,
    pair_index: int,
    pair_contact_test_schedule: PairContactTestSchedule,
) -> bool:
    """Stop testing two elements for contact if they are too far apart to touch soon; return True if still tested."""
    slack, lever = min_motion_to_contact_and_max_lever_arm(pair_state_rows)
    if slack <= 0.0:
        return True
    begin_pause_of_pair_contact_tests(pair_state_rows, element_a_state_rows, element_b_state_rows)
    pair_contact_test_schedule.motion_sum_at_next_contact_test[pair_index] = (
        pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[LARGEST_MOTION_SUM_INDEX]
        + (1.0 - 1e-9) * slack
    )
    pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[NEXT_PAIR_TEST_MOTION_SUM_INDEX] = min(
        pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[NEXT_PAIR_TEST_MOTION_SUM_INDEX],
        pair_contact_test_schedule.motion_sum_at_next_contact_test[pair_index],
    )
    pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[LEVER_ARM_INDEX_IN_MOTION_SUMS] = max(
        pair_contact_test_schedule.largest_motion_sum_next_test_sum_and_lever_arm[LEVER_ARM_INDEX_IN_MOTION_SUMS],
        lever,
    )
    return False
