"""State of a scene case, its elements and their pairs: named tuples, stored in rows of an array by `rows`."""

from typing import NamedTuple

from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import LastSampleOfContinuedSlidingCase
from overturning.dem.kernel.ground import LinearBaseAcceleration


class SceneBaseAccelerationInSample(NamedTuple):
    """Base acceleration in the present sample, linear in time, and ticks (time units) since the sample's start."""

    horizontal: LinearBaseAcceleration
    """Acceleration of the base towards the azimuth as a linear function of time, m/s²."""
    vertical: LinearBaseAcceleration
    """Upward acceleration of the base as a linear function of time, m/s²."""
    ticks_since_sample_start: float
    """Ticks since the start of the sample."""


class StepContactChangesAsFloats(NamedTuple):
    """Contact changes of an attempted step (`StepContactChanges`), stored as floats: above 0 for True."""

    contact_or_nearest_faces_changed: float
    """A contact opened, closed or moved to another vertex, or the nearest faces of a pair changed."""
    has_wrong_slip_assumption: float
    has_velocity_against_assumed_slip: float
    pair_slides_on_both_points: float
    """A pair of elements slides on both of its contact points."""
    friction_sign_changed_in_step: float


class StepDecisionAndNextAttempt(NamedTuple):
    """Decision on an attempted step (accepted or rejected), and slip assumption and length of the next attempt."""

    positive_if_rejected: float
    """Above 0 if the step is rejected."""
    next_attempt_keeps_slip_assumption: float
    """Above 0 if the next attempt assumes the same sticking and sliding as this one."""
    next_attempt: NextStepToAttempt
    """Length and number of repetitions of the next attempt."""


class SceneStateAndConstants(NamedTuple):
    """State and constants of a scene in one case; `ElementState` and `PairState` hold those of elements and pairs."""

    base_acceleration: SceneBaseAccelerationInSample
    tick_duration: float
    """Length of a tick, s."""
    ticks_per_second: float
    """Ticks per second, 1/s."""
    velocity_lag_behind_pose: float
    """Time by which velocities lag behind poses, s."""
    case_step_length_settings: CaseStepLengthsAndDoublingCounts
    current_step_length_and_repetitions: NextStepToAttempt
    """Length of the present step, and its number of repetitions."""
    contact_changes: StepContactChangesAsFloats
    """Contact changes in the present step."""
    step_decision_and_next_attempt: StepDecisionAndNextAttempt
    """Decision on the present step."""
    amplitude_factor: float
    """Factor on the base accelerations of the record."""
    max_base_acceleration_without_motion_g: float
    """Horizontal base acceleration over g up to which a scene at rest stays at rest."""
    current_sample: float
    """Current sample of the record."""
    cannot_start_moving_from_sample: float
    """Sample from which on the input motion cannot start any movement."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""
    initial_energy: float
    """Energy at the start, J."""
    scene_variant_index: float
    """Index of the variant of the scene (one size and damping)."""
    interval_index_of_last_case_end_test: float
    """Index of the `CASE_END_TEST_INTERVAL_S` of the record in which the case was last tested for its end."""
    last_sample_of_continued_sliding_case: LastSampleOfContinuedSlidingCase


class Pose(NamedTuple):
    """Pose of an element: position of its centre (m), clockwise rotation (rad), cosine and sine of the rotation."""

    x: float
    z: float
    angle: float
    cos: float
    sin: float


class PlanarMotionOrForce(NamedTuple):
    """Velocity (m/s, rad/s), acceleration, or force and moment (N, N m) of an element."""

    x: float
    z: float
    angular: float
    """Angular velocity (rad/s) or acceleration, positive clockwise, or moment (N m)."""


class ElementConstants(NamedTuple):
    """Masses, rotation limits and driven or held state of an element, which do not change during a case."""

    inverse_mass: float
    """1/m, 1/kg; 0 if forces do not move the element."""
    inverse_inertia: float
    """1/I, 1/(kg m²); 0 if moments do not rotate the element."""
    mass: float
    """Mass m, kg; 0 if forces do not move the element."""
    is_subject_to_gravity: float
    """1 if gravity acts on the element, else 0."""
    has_inertial_forces_in_base_frame: float
    """0 if the element moves with the base, else 1: it then has inertial forces in the frame of the base."""
    is_fixed_in_space: float
    """1 if the element is fixed in space, else 0."""
    critical_angle_or_else_fall_rotation: float
    """Critical angle α, rad; for an element that has none, the rotation at which it has fallen."""
    max_recoverable_rotation_to_minus_x: float
    """Rotation to −x up to which the element can come back, rad."""
    max_recoverable_rotation_to_plus_x: float
    """Rotation to +x up to which the element can come back, rad."""


class ElementStepMotionWorkAndPeaks(NamedTuple):
    """Motion of an element in the last step, work done on it so far, and its peak rotations so far."""

    abs_dx_plus_abs_dz_in_step: float
    """Displacement in the last step, |Δx| + |Δz|, m."""
    abs_rotation_in_step: float
    """Absolute rotation in the last step, rad."""
    work_by_base_and_fixing_forces_so_far: float
    """Work done on the element so far by the moving base, and by the forces that hold a fixed element, J."""
    peak_rotation_to_minus_x: float
    """Largest rotation to −x, rad."""
    peak_rotation_to_plus_x: float
    """Largest rotation to +x, rad."""
    last_recoverable_tick_in_sample: float
    """Last tick of this sample at which the element could come back, −1 if none."""
    power_against_inertial_or_fixing_forces: float
    """Power of the element against inertial and holding forces at the end of the last step, W (centred scheme)."""


class ElementMotionSinceFirstPairSuspended(NamedTuple):
    """Sums of an element's displacements and rotations since the first pause of any contact tests."""

    abs_dx_plus_abs_dz_sum: float
    """Sum of |Δx| + |Δz| over the steps, m."""
    abs_rotation_sum: float
    """Sum of its absolute rotations, rad."""


class ElementSlipFallSideAndLastUprightTime(NamedTuple):
    """Slip of an element, last times upright and on its support, and fall side; updated at least once per sample."""

    last_time_recoverable_and_above_fall_limit: float
    """Last time at which the element could come back from its rotation and was above its fall limit, s."""
    last_time_on_support: float
    """Last time at which the element touched the element that carried it at rest, s."""
    fall_side: float
    """Side to which the element has fallen, ±1; 0 if it stands."""
    peak_slip_on_support: float
    """Largest absolute slip, m."""
    current_slip_on_support: float
    """Current slip on the supporting element, m."""


class ElementRestPoseAndSlipMeasurementPoints(NamedTuple):
    """Rest position of an element, and the points of its base and its support between which slip is measured."""

    slip_reference_point_x_in_element_axes: float
    """Reference point of the element's base, from its centre in its own axes, m, x component."""
    base_point_z_in_element_axes: float
    """Reference point of the element's base, z component, m."""
    base_point_x_in_support_axes: float
    """Same point in the axes of the supporting element, from that element's centre, m; the distance is the slip."""
    base_point_z_in_support_axes: float
    """Same point in the axes of the supporting element, z component, m."""
    centre_x: float
    """Centre at rest, m."""
    centre_z: float
    """Height of the centre at rest, m."""
    fallen_if_centre_z_below: float
    """Height of the centre below which the element has fallen, m."""


class PredictedElement(NamedTuple):
    """Predicted state of an element at the end of a step of the centred scheme, and its velocity correction."""

    pose: Pose
    velocity_at_half_step: PlanarMotionOrForce
    """Velocity after half of the step."""
    velocity_at_step_end: PlanarMotionOrForce
    """Velocity at the end of the step."""
    abs_dx_plus_abs_dz_in_step: float
    """Displacement in the step, |Δx| + |Δz|, m."""
    abs_rotation_in_step: float
    """Absolute rotation in the step, rad."""
    step_end_velocity_correction: PlanarMotionOrForce
    """Correction of the velocity at the end of the step, from the solution of the equations."""


class ElementState(NamedTuple):
    """State of an element: pose and force at the step end, velocity at `velocity_lag_behind_pose` (s) before it."""

    pose: Pose
    velocity: PlanarMotionOrForce
    predicted: PredictedElement
    acceleration: PlanarMotionOrForce
    contact_force_sum: PlanarMotionOrForce
    constants: ElementConstants
    step_motion_with_work_and_peaks_so_far: ElementStepMotionWorkAndPeaks
    motion_since_first_contact_test_pause: ElementMotionSinceFirstPairSuspended
    slip_fall_side_and_last_upright_time: ElementSlipFallSideAndLastUprightTime
    rest_pose_and_slip_measurement_points: ElementRestPoseAndSlipMeasurementPoints


class ElementFace(NamedTuple):
    """Face of an element in the axes of the element: outward normal, distance, and both ends."""

    outward_normal_x: float
    """Outward normal, x component."""
    outward_normal_z: float
    """Outward normal, z component."""
    face_line_distance_from_element_centre: float
    """Distance from the centre, m."""
    start_along_tangent: float
    """Place of the first end along the tangent (−n_z, n_x), m."""
    end_along_tangent: float
    """Place of the second end along the tangent, m."""


class ContactPointConstants(NamedTuple):
    """Contact law at a contact point of two elements: springs, dashpot and friction."""

    normal_stiffness: float
    """Normal stiffness K, N/m."""
    tangential_stiffness: float
    """Tangential stiffness K_s, N/m."""
    dashpot_coefficient: float
    """Coefficient h of the dashpots in both directions, N s/m."""
    friction_coefficient: float
    """Coefficient of friction μ; negative if the case sets it."""
    tangential_compliance_or_zero_without_spring: float
    """1/K_s, m/N; 0 without tangential stiffness."""
    prescribed_flat_landing_duration: float
    """Duration of a flat landing after the first touch, s (in the initial rows: in h/K); 0 if there is no such rule."""


class VertexContactLimitsAlongOppositeFace(NamedTuple):
    """Limits (m) along the opposite face between which a face's vertex can touch it; ±infinity if it never can.

    Vertices on the cut between two convex pieces of an element are no contact points.
    """

    min_contact_coordinate_of_first_vertex_of_a: float
    """Smallest place of a's first vertex, for contact point 1."""
    min_contact_coordinate_of_second_vertex_of_b: float
    """Smallest place of b's second vertex, for contact point 1."""
    max_contact_coordinate_of_second_vertex_of_a: float
    """Largest place of a's second vertex, for contact point 2."""
    max_contact_coordinate_of_first_vertex_of_b: float
    """Largest place of b's first vertex, for contact point 2."""


class NearestFacesAndMotionLimits(NamedTuple):
    """Indices of the nearest faces of elements a and b, and the relative motion for which they remain valid."""

    face_index_of_a: float
    """Index of a's nearest face; −1 before the first search."""
    face_index_of_b: float
    """Index of b's nearest face; −1 before the first search."""
    lever_arm_converting_rotation_to_motion: float
    """Lever arm that converts a rotation to motion, m."""
    max_motion_keeping_nearest_faces: float
    """Motion before the nearest faces can change, m."""
    max_motion_without_contact: float
    """Motion before a contact can begin, m; −1 if there may be one now."""
    motion_since_face_search: float
    """Motion since the search, m."""
    relative_motion_bound_since_search_at_step_end: float
    """Upper bound of the motion since the search at the end of this step, m."""


class VertexPositionAtFace(NamedTuple):
    """Position of a face's vertex relative to the opposite face: depth behind it and place along it, m."""

    depth: float
    """Depth behind the other face, m; negative in front of it."""
    position_along_opposite_face: float
    """Place along the other face, m; b's vertices are measured in the opposite direction."""


class VertexPositionsAtOtherFace(NamedTuple):
    """Positions of the four end vertices of two elements' nearest faces, each relative to the other face."""

    first_vertex_of_face_a: VertexPositionAtFace
    second_vertex_of_face_a: VertexPositionAtFace
    first_vertex_of_face_b: VertexPositionAtFace
    second_vertex_of_face_b: VertexPositionAtFace


class PlanarContactPointStateAfterLastStep(NamedTuple):
    """State of a contact point of two elements after the last step: spring stretch, vertex, forces, landing time."""

    tangential_spring_stretch: float
    """Stretch of the tangential spring, m."""
    contact_vertex_status_code: float
    """Vertex at the contact point: `CONTACT_CODE_OPEN`, `CONTACT_CODE_VERTEX_OF_A`, `CONTACT_CODE_VERTEX_OF_B` or
    `CONTACT_CODE_TRANSFERRED_FROM_OTHER_FACES`."""
    normal_force: float
    """Normal force, N."""
    tangential_force: float
    """Tangential force, N."""
    remaining_flat_landing_time: float
    """Remaining time of a flat landing, s; 0 or less if there is none."""


CONTACT_CODE_OPEN, CONTACT_CODE_VERTEX_OF_A, CONTACT_CODE_VERTEX_OF_B, CONTACT_CODE_TRANSFERRED_FROM_OTHER_FACES = (
    0.0,
    1.0,
    -1.0,
    2.0,
)
"""Values of the owner of a contact point's vertex: no contact, a's vertex, b's vertex, transferred from other faces."""


class PairContactStateAfterLastStep(NamedTuple):
    """Contact state of two elements after the last step: vertex positions, both contact points, absorbed energy."""

    previous_vertex_positions: VertexPositionsAtOtherFace
    """Positions of the vertices at the last step."""
    point_1: PlanarContactPointStateAfterLastStep
    """History of contact point 1."""
    point_2: PlanarContactPointStateAfterLastStep
    """History of contact point 2."""
    peak_penetration: float
    """Largest penetration so far, m."""
    absorbed_energy: float
    """Energy that the contact has absorbed from the elements, J."""


class PairState(NamedTuple):
    """State of two elements, a and b, that can touch: nearest faces, contact law and contact state."""

    nearest_face_of_a: ElementFace
    nearest_face_of_b: ElementFace
    ranges_where_vertices_touch_opposite_faces: VertexContactLimitsAlongOppositeFace
    contact_law: ContactPointConstants
    nearest_faces: NearestFacesAndMotionLimits
    history: PairContactStateAfterLastStep
    signed_mu_of_point_1_or_0_if_sticking: float
    """±μ if contact point 1 was sliding at the last solution, else 0 (centred scheme)."""
    signed_mu_of_point_2_or_0_if_sticking: float
    """±μ if contact point 2 was sliding at the last solution, else 0 (centred scheme)."""
    rest_support_sign_plus_if_a_on_b: float
    """1 if a was carried by b at rest, −1 if b was carried by a, else 0."""
