"""Checks of the answers of the stability map, which share no code with the kernels.

An element of a scene has fallen for good at the rotation at which it can rest on another face (a rectangle at 90°).
An overdamped stone that falls on its side creeps towards this angle and need not reach it. An element that ends past
its tipping angle, has dropped or has lost its support has fallen, too. So there are two angles: an element rotated by
more than `rotations_requiring_fallen_flag` must be marked as fallen, one rotated by less than
`least_possible_rotation_of_fallen_elements` must not; between these angles both flags are accepted.
"""

from collections.abc import Sequence
from enum import IntEnum
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.balance import MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO
from overturning.dem.limits import MAX_PENETRATION_TO_HALF_SIDE_RATIO
from overturning.dem.polygon.prepare import SceneEquilibriumStiffnessAndRockingLimits
from overturning.model.geometry import PlacedElement
from overturning.model.results import CaseResults
from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.stability.cases import BlockCaseOfNumericalStabilityMap

RIGHT_ANGLE_RAD: Final = 0.5 * np.pi
"""Rotation that turns an upright face down, rad."""

ROTATION_TOLERANCE_RAD: Final = 1e-6
"""Tolerance for a rotation that is stored as a share of α in single precision."""

MAX_ROUNDING_SLIP_PER_METRE: Final = 1e-9
"""Largest slip of a block at rest due to rounding, per metre of its size."""


class StabilityCheckVerdict(IntEnum):
    """Outcome of a case of the map of stability after the checks."""

    ALL_CHECKS_HOLD = 0
    """Computed, and every check holds."""
    NOT_SIMULATED_AT_REST = 1
    """Not simulated; an independent check finds the whole motion below both thresholds."""
    UNDECIDED_AT_END_TIME = 2
    """A stone may still fall when the simulation ends."""
    NUMERICALLY_UNSTABLE = 3
    """Marked by the program: energy balance violated, rotation unbounded, or an invalid contact."""
    STOPPED_BY_ERROR = 4
    OVER_STEP_BUDGET = 5
    ARGUMENT_REFUSED = 6
    """An error that names the argument."""
    WRONG_WITHOUT_WARNING = 7
    """A flag that a check contradicts. There must be none."""

    @property
    def label(self) -> str:
        """Word for the outcome in tables and in the description of the stored column."""
        return _CHECKED_OUTCOME_LABELS[self.value]


_CHECKED_OUTCOME_LABELS: Final = (
    "right", "at_rest", "undecided", "unstable", "failed", "over_budget", "refused", "silent",
)  # fmt: skip


class BoundsOnCaseResults(NamedTuple):
    """Bounds that the results of a case must keep, computed from shapes, contacts and motion only."""

    largest_penetration_under_own_weight: float
    """Largest static penetration, m."""
    smallest_element_side: float
    """Smallest side of an element, m; the allowed penetration is a share of it."""
    contact_width_for_stiffness_check: float
    """Width of a contact, m; for a stiff contact the static penetration is small compared with it."""
    motion_peak_horizontal_to_apparent_gravity_ratio: float
    """Largest ratio of horizontal to vertical acceleration, |a|/(g + a_up)."""
    min_horizontal_to_apparent_gravity_ratio_to_move: float
    """Ratio of horizontal to vertical acceleration below which nothing moves."""
    min_horizontal_to_apparent_gravity_ratio_to_fall_if_stiff: float
    """Ratio of horizontal to vertical acceleration below which nothing falls if contacts are stiff."""
    max_slip_without_shaking: float = np.inf
    """Slip from which an element counts as moved in a case without shaking, m."""


def name_of_first_failed_check(
    bounds_on_case_results: BoundsOnCaseResults, results: CaseResults, case_index: int, flags_match_rotations: bool
) -> str:
    """Return the name of the first check that the results of a case fail; empty if all checks hold.

    A case without an outcome (marked by its status) must have no flag. A case with a flag must have balanced energy,
    bounded penetration and finite numbers. A case left out as at rest must have a motion below the thresholds of
    rocking and sliding. Without shaking nothing may move; far below the threshold of rocking nothing may fall if
    contacts are stiff. `flags_match_rotations` is True if flags and rotations are consistent.
    """
    limit = MAX_PENETRATION_TO_HALF_SIDE_RATIO * 0.5 * bounds_on_case_results.smallest_element_side
    if not CaseStatus(results.status[case_index]).trajectory_has_known_outcome:
        return "" if np.all(results.overturned[case_index] == INT8_MISSING) else "flag in spite of the mark"
    if not np.isin(results.overturned[case_index], (-1, 0, 1)).all():
        return "no flag and no mark"
    numbers = (
        results.energy_error,
        results.peak_penetration,
        results.peak_rotation,
        results.peak_slip,
        results.residual_slip,
    )
    if not all(np.isfinite(values[case_index]).all() for values in numbers):
        return "a number is not finite"
    if bounds_on_case_results.largest_penetration_under_own_weight > limit or results.peak_penetration[
        case_index
    ] > limit * (1 + 1e-6):
        return "penetration"
    if results.energy_error[case_index] > MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO:
        return "energy balance"
    fallen = results.overturned[case_index] != 0
    if not flags_match_rotations:
        return "flag and rotation"
    if np.any(np.isfinite(results.overturning_time[case_index]) != fallen):
        return "flag and time"
    if (
        results.status[case_index] == CaseStatus.AT_REST
        and bounds_on_case_results.motion_peak_horizontal_to_apparent_gravity_ratio
        > bounds_on_case_results.min_horizontal_to_apparent_gravity_ratio_to_move
    ):
        return "left out above a threshold"
    if bounds_on_case_results.motion_peak_horizontal_to_apparent_gravity_ratio == 0.0 and np.any(
        fallen | (results.peak_slip[case_index] > bounds_on_case_results.max_slip_without_shaking)
    ):
        return "moved without motion"
    if (
        np.any(fallen)
        and bounds_on_case_results.motion_peak_horizontal_to_apparent_gravity_ratio
        < 0.2 * bounds_on_case_results.min_horizontal_to_apparent_gravity_ratio_to_fall_if_stiff
        and bounds_on_case_results.largest_penetration_under_own_weight
        < 1e-4 * bounds_on_case_results.contact_width_for_stiffness_check
    ):
        return "fell below the threshold of rocking"
    return ""


def motion_peak_horizontal_to_apparent_gravity_ratio(motion: Motion) -> float:
    """Return the largest |a|/(g + a_up) of a motion, a towards north; infinite if the ground falls faster than g."""
    weight = STANDARD_GRAVITY + (np.zeros(motion.sample_count) if motion.up is None else motion.up)
    if (weight <= 0).any():
        return float("inf")
    return float(np.max(np.abs(motion.north) / weight))


def static_penetration(case: BlockCaseOfNumericalStabilityMap) -> float:
    """Return the static penetration δ = m g/(2 K_n), m."""
    return case.density * case.b_over_h * case.height**2 * STANDARD_GRAVITY / (2.0 * case.normal_stiffness_per_corner)


def name_of_first_failed_block_check(
    case: BlockCaseOfNumericalStabilityMap, motion: Motion, results: CaseResults
) -> str:
    """Return the first failed check of a single block (see `name_of_first_failed_check`); empty if all hold.

    The check that no block falls far below the threshold of rocking is made only if µ is below half of B/H.
    """
    width, ratio = case.b_over_h * case.height, case.b_over_h
    stands = ratio if case.friction < 0.5 * ratio else 0.0
    bounds = BoundsOnCaseResults(
        static_penetration(case), min(width, case.height), width,
        motion_peak_horizontal_to_apparent_gravity_ratio(motion),
        min(ratio, case.friction), stands, MAX_ROUNDING_SLIP_PER_METRE * (width + case.height),
    )  # fmt: skip
    lies = results.peak_rotation[0] * np.arctan(ratio) >= RIGHT_ANGLE_RAD * (1 - ROTATION_TOLERANCE_RAD)
    return name_of_first_failed_check(bounds, results, 0, bool((results.overturned[0] != 0) == lies))


def name_of_first_failed_scene_check(
    prepared_scene: SceneEquilibriumStiffnessAndRockingLimits,
    friction: float,
    motion: Motion,
    results: CaseResults,
    case_index: int = 0,
) -> str:
    """Return the first failed check of a scene with one μ for all contacts; see `name_of_first_failed_check`."""
    size = min(item.smaller_of_width_and_height for item in prepared_scene.elements if not item.has_prescribed_motion)
    bound = min(min_acceleration_ratio_to_start_rocking(prepared_scene.elements), friction)
    bounds = BoundsOnCaseResults(
        largest_penetration_under_own_weight(prepared_scene),
        size,
        size,
        motion_peak_horizontal_to_apparent_gravity_ratio(motion),
        bound * (1 + 1e-9),
        bound,
    )
    turned = (
        results.peak_rotation[case_index]
        * prepared_scene.tipping_angles_or_one_degree_in_rad[prepared_scene.free_element_indices]
    )
    return name_of_first_failed_check(
        bounds,
        results,
        case_index,
        flags_match_rotations(prepared_scene, np.atleast_1d(results.overturned[case_index]) != 0, turned),
    )


def largest_penetration_under_own_weight(prepared_scene: SceneEquilibriumStiffnessAndRockingLimits) -> float:
    """Return the largest static penetration, m, of the contacts between elements of a scene.

    The two ends of a contact share its weight.
    """
    return float(
        np.max(
            prepared_scene.pair_contact_laws.carried_weight_at_rest
            / (2.0 * prepared_scene.pair_contact_laws.normal_stiffness),
            initial=0.0,
        )
    )


def min_acceleration_ratio_to_start_rocking(placed_elements: Sequence[PlacedElement]) -> float:
    """Return the lowest |a|/(g + a_up) at which the rigid scene can rock (a horizontal, a_up upward acceleration).

    This is the least ratio of lever arm to height of the common centre of mass of an element and all elements above
    it.

    Computed from the shapes only, for scenes in which each element stands on the middle of another.
    """
    free = sorted(
        (item for item in placed_elements if not item.has_prescribed_motion), key=lambda item: item.centre_of_mass_z
    )
    least = np.inf
    for k, item in enumerate(free):
        above = free[k:]
        mass = sum(part.mass for part in above)
        x = sum(part.mass * part.centre_of_mass_x for part in above) / mass
        z = sum(part.mass * part.centre_of_mass_z for part in above) / mass
        level = item.vertices_in_scene[:, 1].min()
        foot = item.vertices_in_scene[item.vertices_in_scene[:, 1] < level + 1e-9 * item.smaller_of_width_and_height][
            :, 0
        ]
        if k > 0:
            below = free[k - 1].vertices_in_scene
            top = below[below[:, 1] > level - 1e-6 * item.smaller_of_width_and_height][:, 0]
            foot = np.clip(foot, top.min(), top.max())
        least = min(least, (foot.max() - x) / (z - level), (x - foot.min()) / (z - level))
    return float(max(least, 0.0))


def flags_match_rotations(
    prepared_scene: SceneEquilibriumStiffnessAndRockingLimits,
    has_fallen_flag_by_element: NDArray[np.bool_],
    peak_rotation_rad_by_element: FloatArray,
) -> bool:
    """True if the flags of the free elements are consistent with their largest rotations, rad, limited to 90°."""
    early = has_fallen_flag_by_element & (
        peak_rotation_rad_by_element
        < least_possible_rotation_of_fallen_elements(prepared_scene) - ROTATION_TOLERANCE_RAD
    )
    missed = ~has_fallen_flag_by_element & (
        peak_rotation_rad_by_element > rotations_requiring_fallen_flag(prepared_scene) - ROTATION_TOLERANCE_RAD
    )
    return not (early | missed).any()


def rotations_requiring_fallen_flag(prepared_scene: SceneEquilibriumStiffnessAndRockingLimits) -> FloatArray:
    """Return the rotation, rad, to either side from which each free element must be marked as fallen.

    This is `fallen_rotation_deg` of the element if given, else the rotation at which it rests on another face. If the
    element then lies level on a face of length L, the rotation is less by asin(δ/L): with the static penetration
    δ = m g/(2 K_n) at the near end of the face, the far end touches that much before level. K_n is that of the softest
    contact of the element. Results contain rotations up to 90° only: the limit is infinite for larger angles.
    """
    angle = _fall_rotation_thresholds_of_free_elements(prepared_scene)
    for place, index in enumerate(prepared_scene.free_element_indices):
        item = prepared_scene.elements[index]
        # The longest face that this rotation turns down.
        length = max(
            (
                length
                for turn, length in _rotation_and_length_of_each_face_when_down(item)
                if abs(abs(turn) - angle[place]) < 1e-9
            ),
            default=0.0,
        )
        if length > 0.0:
            mine = [k for k, pair in enumerate(prepared_scene.pairs) if index in pair[:2]]
            pressed = (
                item.mass * STANDARD_GRAVITY / (2.0 * prepared_scene.pair_contact_laws.normal_stiffness[mine].min())
            )
            angle[place] -= np.arcsin(min(pressed / length, 1.0))
    return np.where(angle > RIGHT_ANGLE_RAD, np.inf, angle)


def least_possible_rotation_of_fallen_elements(prepared_scene: SceneEquilibriumStiffnessAndRockingLimits) -> FloatArray:
    """Return the rotation, rad, below which each free element cannot have fallen.

    It is at most the tipping angle; 0 for an element that can lose its support or that falls by dropping.
    """
    found = []
    for index, asked in zip(
        prepared_scene.free_element_indices, _fall_rotation_thresholds_of_free_elements(prepared_scene), strict=True
    ):
        item = prepared_scene.elements[index]
        on_ground = all(
            prepared_scene.elements[k].has_prescribed_motion for k in prepared_scene.carrier_indices_by_element[index]
        )
        x, z = item.shape.vertices_from_whole_polygon_centroid.T
        base = x[z < z.min() + 1e-9 * item.smaller_of_width_and_height]
        tips = float(np.arctan2(min(base.max(), -base.min()), -z.min()))
        found.append(min(asked, tips, RIGHT_ANGLE_RAD) if on_ground and item.element.fallen_drop is None else 0.0)
    return np.array(found)


def _fall_rotation_thresholds_of_free_elements(prepared_scene: SceneEquilibriumStiffnessAndRockingLimits) -> FloatArray:
    """Return the rotation, rad, from which each free element counts as fallen.

    This is `fallen_rotation_deg` of the element if given, else the least rotation to another resting face, on the side
    where it is larger.
    """
    items = [prepared_scene.elements[index] for index in prepared_scene.free_element_indices]
    asked = [item.element.fallen_rotation_deg for item in items]
    return np.array([
        max(_least_rotations_to_other_resting_face(item)) if angle is None else np.radians(angle)
        for item, angle in zip(items, asked, strict=True)
    ])  # fmt: skip


def _least_rotations_to_other_resting_face(element: PlacedElement) -> tuple[float, float]:
    """Return the least rotations to either side, rad, at which an element rests on another face; π if none."""
    tilts = [angle for angle, _ in _rotation_and_length_of_each_face_when_down(element)]
    stable = np.array(
        [
            angle
            for angle in tilts
            if _centre_height(element, angle) < min(_centre_height(element, angle + d) for d in (-1e-6, 1e-6))
        ]
    )
    stands = min(tilts, key=abs)
    others = stable[stable != stands]
    return float((-others[others < 0]).min(initial=np.pi)), float(others[others > 0].min(initial=np.pi))


def _rotation_and_length_of_each_face_when_down(element: PlacedElement) -> list[tuple[float, float]]:
    """Return the rotation that turns each face of the convex hull down, rad, and the length of the face, m."""
    found = []
    for first, second in combinations(element.shape.vertices_from_whole_polygon_centroid, 2):
        x, z = second - first
        turns = (float(np.arctan2(z, x)), float(np.arctan2(-z, -x)))
        lowest = (
            t
            for t in turns
            if first[1] * np.cos(t) - first[0] * np.sin(t)
            < 1e-9 * element.smaller_of_width_and_height - _centre_height(element, t)
        )
        found += [(turn, float(np.hypot(x, z))) for turn in lowest]
    return found


def _centre_height(element: PlacedElement, element_rotation_rad: float) -> float:
    """Return the height of the centroid above the lowest vertex of the rotated element, m."""
    x, z = element.shape.vertices_from_whole_polygon_centroid.T
    return float((x * np.sin(element_rotation_rad) - z * np.cos(element_rotation_rad)).max())
