"""Termination of a scene case: test which elements have fallen, and whether the case has ended."""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.ending import CASE_NOT_ENDED, set_slide_end_once_and_check_case_continues
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.dem.kernel.mechanics import updated_maximum
from overturning.dem.polygon import rows
from overturning.dem.polygon.energy import (
    element_kinetic_energy,
    scene_energy,
)
from overturning.dem.polygon.resting import (
    all_free_elements_tilt_far_below_critical_angle,
    any_element_can_still_land,
    count_closed_points_of_standing_elements,
    element_has_tipped,
    element_has_tipped_or_dropped,
    largest_penetration_so_far,
    last_supported_time_or_inf_if_supported_now,
    longest_time_until_sliding_stops,
    no_element_tipped_dropped_or_unsupported,
)
from overturning.dem.polygon.state import ElementState
from overturning.model.status import CaseStatus

MAX_TILT_OVER_CRITICAL_ANGLE_TO_STAND_FOR_GOOD: Final = 0.1
"""Largest rotation, over α, of an element that stands for good if the rest of the record cannot lift or slide it."""
MAX_SLIP_OVER_HALF_HEIGHT_TO_STAND_FOR_GOOD: Final = 1.0
"""Largest slip, over half its height, of an element that stands for good."""
MAX_KINETIC_OVER_OVERTURNING_ENERGY_TO_STAND: Final = 0.1
"""Largest kinetic energy of an element that stands for good, over the energy needed to overturn it; also of all free
elements, over the smallest energy needed to overturn one."""

MAX_SUPPORT_GAP_OVER_PENETRATION_LIMIT: Final = 0.1
"""Largest gap between an element and its support, as a share of the penetration limit."""


class ElementCountsAndKineticEnergy(NamedTuple):
    """Numbers of standing, fallen and safely standing free elements, kinetic energy, checks of finiteness and slip."""

    sum_to_detect_nonfinite_state: float
    """Sum that is finite if the poses and velocities of all elements are."""
    kinetic_energy_of_free_elements: float
    """Kinetic energy of the free elements, J."""
    standing_element_count: int
    """Number of free elements that stand."""
    fallen_element_count: int
    """Number of free elements that have fallen."""
    safely_standing_element_count: int
    """Number of free elements that stand for good if the rest of the record cannot lift or slide them."""
    any_slid_over_tenth_of_half_height: bool
    """True if an element has slid by more than a tenth of half its height."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def case_status(
    case_states: Any,
    lane: int,
    scene_arrays: Any,
    rocking_groups_immovable_from_sample: Any,
    sample_index_at_record_end: float,
    sampling_interval: float,
) -> int:
    """Return the `CaseStatus` of the case in column `lane` of the state array, `CASE_NOT_ENDED` before its end.

    The record ends at sample `sample_index_at_record_end`. `rocking_groups_immovable_from_sample`, shape (groups,),
    holds the sample from which the base motion cannot move each group of elements that can rock as one body.
    """
    case = rows.load_scene_state(case_states, lane)
    v = int(case.scene_variant_index)
    fall_and_support_table, limits = scene_arrays.fall_and_support_table[v], scene_arrays.termination_limits[v]
    check, moving, standing, fallen, safe, slid = store_new_fall_sides_and_count_elements(
        case_states, lane, fall_and_support_table
    )
    if not np.isfinite(check) or largest_penetration_so_far(case_states, lane, scene_arrays) > limits.max_penetration:
        return CaseStatus.UNSTABLE
    gap = MAX_SUPPORT_GAP_OVER_PENETRATION_LIMIT * limits.max_penetration
    # A fallen element may still hit, or slide into, one that stands.
    calm = (
        fallen > 0
        and safe == standing
        and moving < MAX_KINETIC_OVER_OVERTURNING_ENERGY_TO_STAND * limits.min_overturning_energy
    )
    if standing == 0 or (
        calm
        and no_standing_group_can_move_nor_element_land(
            case_states, lane, scene_arrays, fall_and_support_table, rocking_groups_immovable_from_sample, gap
        )
    ):
        return CaseStatus.SIMULATED
    if case.current_sample < sample_index_at_record_end and case.current_sample < case.cannot_start_moving_from_sample:
        return CASE_NOT_ENDED
    # A scene at rest after the last time at which it could start to move stays at rest: there is no kinetic energy,
    # and every standing element has at least two loaded points.
    if (
        moving < limits.max_kinetic_energy_at_rest
        and count_closed_points_of_standing_elements(case_states, lane, scene_arrays, fall_and_support_table)
        >= 2 * standing
    ):
        return CaseStatus.SIMULATED
    if case.current_sample < sample_index_at_record_end:
        return CASE_NOT_ENDED
    if (
        fallen == 0
        and not slid
        and all_elements_stand_and_outcomes_are_final(
            case_states, lane, scene_arrays, fall_and_support_table, limits.min_overturning_energy, gap
        )
    ):
        return CaseStatus.SIMULATED
    if case.current_sample < case.end_sample_if_undecided:
        return CASE_NOT_ENDED
    # Upright elements that slide are simulated until friction has stopped them.
    sliding_time = 0.0
    if all_free_elements_tilt_far_below_critical_angle(
        case_states, lane, fall_and_support_table
    ) and no_element_tipped_dropped_or_unsupported(case_states, lane, scene_arrays, fall_and_support_table, gap):
        sliding_time = longest_time_until_sliding_stops(case_states, lane, scene_arrays)
    if set_slide_end_once_and_check_case_continues(
        case_states,
        rows.SLIDING_CASE_END_SAMPLE_ROW_OFFSET + lane,
        case.current_sample,
        sliding_time,
        sampling_interval,
    ):
        return CASE_NOT_ENDED
    still = moving < 1e-4 * limits.min_reference_energy_of_energy_error or not any_element_can_fall_without_base_motion(
        case_states, lane, fall_and_support_table, scene_arrays.gravity
    )
    return (
        CaseStatus.SIMULATED
        if still and not any_element_can_still_land(case_states, lane, scene_arrays, fall_and_support_table, gap)
        else CaseStatus.UNDECIDED
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def no_standing_group_can_move_nor_element_land(
    case_states: Any,
    lane: int,
    scene_arrays: Any,
    fall_and_support_table: Any,
    rocking_groups_immovable_from_sample: Any,
    max_support_gap: float,
) -> bool:
    """True if the remaining record cannot lift or slide a standing group, and no element in the air can still land."""
    sample = rows.load_scene_state(case_states, lane).current_sample
    weak = remaining_motion_cannot_move_standing_groups(
        case_states,
        lane,
        rocking_groups_immovable_from_sample,
        scene_arrays.lowest_and_last_element_index_by_rocking_group,
        sample,
    )
    return bool(
        weak
        and not any_element_can_still_land(case_states, lane, scene_arrays, fall_and_support_table, max_support_gap)
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def all_elements_stand_and_outcomes_are_final(
    case_states: Any,
    lane: int,
    scene_arrays: Any,
    fall_and_support_table: Any,
    min_overturning_energy: float,
    max_support_gap: float,
) -> bool:
    """True if all elements stand on their supports and cannot fall, exceed their peak rotation or slide further."""
    if not no_element_tipped_dropped_or_unsupported(
        case_states, lane, scene_arrays, fall_and_support_table, max_support_gap
    ):
        return False
    spare = scene_energy(case_states, lane, scene_arrays) - rows.load_scene_state(case_states, lane).initial_energy
    # No element can fall with less energy than this; the peak rotations are final if it cannot reach them again.
    over = spare < 0.5 * min_overturning_energy and not any_peak_rotation_can_grow(
        case_states, lane, fall_and_support_table, spare
    )
    return bool(over and not longest_time_until_sliding_stops(case_states, lane, scene_arrays) > 0.0)


@njit(**INTERNAL_COMPILE_OPTIONS)
def store_new_fall_sides_and_count_elements(
    case_states: Any, lane: int, fall_and_support_table: Any
) -> ElementCountsAndKineticEnergy:
    """Store the side (±1) to which elements newly fell; count elements that stand, have fallen, stand for good."""
    check, moving, standing, fallen, safe, slid = 0.0, 0.0, 0, 0, 0, False
    for i in range(fall_and_support_table.size):
        e = rows.slice_element_rows(case_states, i)
        item = rows.load_element_state(e, lane)
        check += item.pose.x + item.pose.z + item.velocity.x + item.velocity.z + item.velocity.angular + item.pose.cos
        if fall_and_support_table[i].is_free == 0.0:
            continue
        moving += element_kinetic_energy(item)
        slid = slid or abs(item.slip_fall_side_and_last_upright_time.current_slip_on_support) > 0.1 * abs(
            item.rest_pose_and_slip_measurement_points.base_point_z_in_element_axes
        )
        if item.slip_fall_side_and_last_upright_time.fall_side == 0.0:
            e[rows.FALL_SIDE_ROW_OFFSET + lane] = fall_side_by_peak_rotation_or_zero(item, fall_and_support_table[i])
        stands = e[rows.FALL_SIDE_ROW_OFFSET + lane] == 0.0
        standing, fallen = standing + int(stands), fallen + int(not stands)
        safe += int(
            stands and element_tilt_slip_and_energy_are_small(item, fall_and_support_table[i].energy_needed_to_overturn)
        )
    return ElementCountsAndKineticEnergy(check, moving, standing, fallen, safe, slid)


@njit(**INLINE_OPTIONS)
def larger_peak_rotation_of_both_sides(element: ElementState) -> float:
    """Return the larger of the peak rotations of an element to both sides, rad."""
    return updated_maximum(
        element.step_motion_with_work_and_peaks_so_far.peak_rotation_to_minus_x,
        element.step_motion_with_work_and_peaks_so_far.peak_rotation_to_plus_x,
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def fall_side_by_peak_rotation_or_zero(element: ElementState, fall_limits_of_element: Any) -> float:
    """Return the side (±1) to which an element's peak rotation so far counts as a fall; 0 if it has not fallen.

    The limit depends on the side. If both limits are reached, the current rotation decides.
    """
    back, on = (
        element.step_motion_with_work_and_peaks_so_far.peak_rotation_to_minus_x
        >= fall_limits_of_element.rotation_counting_as_fall_to_minus_x,
        element.step_motion_with_work_and_peaks_so_far.peak_rotation_to_plus_x
        >= fall_limits_of_element.rotation_counting_as_fall_to_plus_x,
    )
    if back and on:
        return 1.0 if element.pose.angle > 0.0 else -1.0
    return 1.0 if on else (-1.0 if back else 0.0)


@njit(**INTERNAL_COMPILE_OPTIONS)
def any_element_can_fall_without_base_motion(
    case_states: Any, lane: int, fall_and_support_table: Any, gravity: float
) -> bool:
    """True if any standing element has enough energy to overturn while the base is at rest.

    The energy needed is the overturning energy or, for an element without a tipping angle, 1 % of the potential energy
    that it loses from its rest position down to the height at which it counts as fallen.
    """
    for i in range(fall_and_support_table.size):
        item = rows.load_element_state(rows.slice_element_rows(case_states, i), lane)
        if (
            fall_and_support_table[i].is_free == 0.0
            or item.slip_fall_side_and_last_upright_time.fall_side != 0.0
            or element_has_tipped_or_dropped(item, fall_and_support_table[i])
        ):
            continue
        own, weight = (
            fall_and_support_table[i].tipping_rotation_to_plus_x < np.inf,
            item.constants.mass * gravity,
        )
        lift = weight * max(item.pose.z - item.rest_pose_and_slip_measurement_points.centre_z, 0.0) if own else 0.0
        needed = (
            fall_and_support_table[i].energy_needed_to_overturn
            if own
            else 0.01
            * weight
            * (
                item.rest_pose_and_slip_measurement_points.centre_z
                - item.rest_pose_and_slip_measurement_points.fallen_if_centre_z_below
            )
        )
        if element_kinetic_energy(item) + lift > needed:
            return True
    return False


@njit(**INTERNAL_COMPILE_OPTIONS)
def find_fallen_elements_and_store_side_and_time(
    case_states: Any, lane: int, scene_arrays: Any, fall_and_support_table: Any, max_support_gap: float
) -> None:
    """Find, at the end of a case, the free elements that have fallen, and store the side and time of their fall.

    An element has fallen if it has rotated to where it can rest on another face or past the angle from which it can
    return, if it is below its fall limit, or if none of its supports carries it any more.
    """
    found = True
    while found:
        found = False
        for i in range(fall_and_support_table.size):
            e = rows.slice_element_rows(case_states, i)
            if fall_and_support_table[i].is_free == 0.0 or e[rows.FALL_SIDE_ROW_OFFSET + lane] != 0.0:
                continue
            item, until = (
                rows.load_element_state(e, lane),
                last_supported_time_or_inf_if_supported_now(case_states, lane, scene_arrays, i, max_support_gap),
            )
            if element_has_tipped_or_dropped(item, fall_and_support_table[i]):
                until = item.slip_fall_side_and_last_upright_time.last_time_recoverable_and_above_fall_limit
            if until < np.inf:
                e[rows.FALL_SIDE_ROW_OFFSET + lane], e[rows.LAST_TIME_ABLE_TO_RETURN_ROW_OFFSET + lane], found = (
                    fall_side_by_rotation_or_displacement(item, fall_and_support_table[i]), until, True,
                )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def fall_side_by_rotation_or_displacement(element: ElementState, fall_limits_of_element: Any) -> float:
    """Return the side (±1 along x) of a fallen element: sign of its rotation if it tipped, else of its displacement.

    The slip of an element that tips does not count, as for a single block.
    """
    way = (
        element.pose.angle
        if element_has_tipped(element, fall_limits_of_element)
        else element.pose.x - element.rest_pose_and_slip_measurement_points.centre_x
    )
    return 1.0 if way > 0.0 or (way == 0.0 and element.pose.angle > 0.0) else -1.0


@njit(**INTERNAL_COMPILE_OPTIONS)
def remaining_motion_cannot_move_standing_groups(
    case_states: Any,
    lane: int,
    rocking_groups_immovable_from_sample: Any,
    lowest_and_last_element_index_by_rocking_group: Any,
    current_sample_index: float,
) -> bool:
    """True if the base motion from now on cannot lift or slide any group of stacked elements that stands."""
    for p in range(lowest_and_last_element_index_by_rocking_group.shape[0]):
        lowest, last = (
            rows.slice_element_rows(case_states, lowest_and_last_element_index_by_rocking_group[p, 0]),
            rows.slice_element_rows(case_states, lowest_and_last_element_index_by_rocking_group[p, 1]),
        )
        if (
            lowest[rows.FALL_SIDE_ROW_OFFSET + lane] == 0.0
            and last[rows.FALL_SIDE_ROW_OFFSET + lane] == 0.0
            and current_sample_index < rocking_groups_immovable_from_sample[p]
        ):
            return False
    return True


@njit(**INTERNAL_COMPILE_OPTIONS)
def element_tilt_slip_and_energy_are_small(element: ElementState, energy_needed_to_overturn: float) -> bool:
    """True if tilt, slip and kinetic energy of an element are small shares of those at which it could fall."""
    return bool(
        abs(element.pose.angle)
        < MAX_TILT_OVER_CRITICAL_ANGLE_TO_STAND_FOR_GOOD * element.constants.critical_angle_or_else_fall_rotation
        and abs(element.slip_fall_side_and_last_upright_time.current_slip_on_support)
        < MAX_SLIP_OVER_HALF_HEIGHT_TO_STAND_FOR_GOOD
        * abs(element.rest_pose_and_slip_measurement_points.base_point_z_in_element_axes)
        and element_kinetic_energy(element) < MAX_KINETIC_OVER_OVERTURNING_ENERGY_TO_STAND * energy_needed_to_overturn
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def any_peak_rotation_can_grow(
    case_states: Any, lane: int, fall_and_support_table: Any, scene_energy_above_initial_energy: float
) -> bool:
    """True if the scene's energy above its initial energy (J) could rotate an element beyond its peak rotation."""
    for e in range(fall_and_support_table.size):
        item = rows.load_element_state(rows.slice_element_rows(case_states, e), lane)
        reached = larger_peak_rotation_of_both_sides(item) / item.constants.critical_angle_or_else_fall_rotation
        if fall_and_support_table[e].is_free == 0.0 or reached < 1e-3:
            continue
        share = min(
            max(scene_energy_above_initial_energy / fall_and_support_table[e].energy_needed_to_overturn, 0.0),
            1.0,
        )
        if 1.0 - np.sqrt(1.0 - share) > reached:
            return True
    return False
