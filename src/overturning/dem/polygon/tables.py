"""Rows of the tables of a 2-D scene: parameters of cases, limits and results."""

from typing import Final, NamedTuple

from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts
from overturning.dem.kernel.tuples import table_dtype_of_named_tuples


class SceneCaseTableRow(NamedTuple):
    """Parameters of a case of a 2-D scene.

    Columns of the kernel's input table, before those of `CaseStepLengthsAndDoublingCounts`.
    """

    amplitude_factor: float
    """Factor on the base accelerations of the record."""
    max_base_acceleration_without_motion_g: float
    """Horizontal acceleration over g up to which the scene stays at rest."""
    friction_coefficient_if_law_has_none: float
    """Coefficient of friction of contact laws without one."""
    dashpot_coefficient_multiplier: float
    """Factor on the dashpot coefficients of all contacts."""
    first_simulated_sample: float
    """First sample that is computed."""
    cannot_start_moving_from_sample: float
    """Sample from which on the input motion cannot start any movement."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""
    earliest_end_sample_if_decided: float
    """Sample up to which a decided case is computed on, for the path of its fallen elements; 0: it ends at once."""


class ElementFallAndSupportTableRow(NamedTuple):
    """Fall limits, support and overturning energy of each element: columns of the scene kernel's table of elements."""

    is_free: float
    """1 if the element is free, else 0."""
    rotation_counting_as_fall_to_minus_x: float
    """Rotation to −x at which the element has fallen, rad."""
    rotation_counting_as_fall_to_plus_x: float
    """Rotation to +x at which the element has fallen, rad."""
    tipping_rotation_to_minus_x: float
    """Rotation to −x from which the element cannot come back, rad."""
    tipping_rotation_to_plus_x: float
    """Rotation to +x from which the element cannot come back, rad."""
    first_support_or_own_element_index: float
    """Index of the first element that carries this one at rest, or its own index."""
    index_of_held_element_at_stack_bottom: float
    """Index of the element at the bottom of the stack if that one is held, fixed in space; else −1."""
    energy_needed_to_overturn: float
    """Energy needed to overturn the element, J."""


class ScenePenetrationAndEnergyLimits(NamedTuple):
    """Limits for a scene of one size: penetration at which a case fails, and energies that decide whether it ends."""

    max_penetration: float
    """Penetration beyond which a case has failed, m."""
    max_kinetic_energy_at_rest: float
    """Kinetic energy of all free elements below which they count as at rest, J."""
    min_overturning_energy: float
    """Smallest energy needed to overturn an element, J."""
    min_reference_energy_of_energy_error: float
    """Least energy by which the error of the energy balance is divided, J."""


class SceneResultTableRow(NamedTuple):
    """Results of a case of a 2-D scene: columns of the kernel's table of results, one row per case."""

    status: float
    """`CaseStatus` as a number."""
    peak_penetration: float
    """Largest penetration, m."""
    energy_error: float
    """Absolute error of the energy balance over the largest of base work, absorbed energy and a least energy."""
    block_steps: float
    """Number of steps, summed over the free elements."""
    samples_left_out: float
    """Number of samples that were skipped at rest."""


class ElementResultRow(NamedTuple):
    """Results of one element of a 2-D scene: columns of the kernel's table, one row per case and element."""

    overturned: float
    """Side of the fall: 1 towards the azimuth, −1 away from it, 0 standing."""
    overturning_time: float
    """Time of the fall, s from the start of the record: last time at which the element could come back; NaN: none."""
    peak_rotation: float
    """Largest absolute rotation, rad; `outcome_arrays_by_variable_name` divides it by the tipping angle."""
    peak_slip: float
    """Largest absolute slip of the base on its support, m."""
    residual_slip: float
    """Signed slip of the base on its support at the end of the case, m."""


CASE_TABLE_DTYPE: Final = table_dtype_of_named_tuples(SceneCaseTableRow, CaseStepLengthsAndDoublingCounts)


ELEMENT_FALL_AND_SUPPORT_DTYPE: Final = table_dtype_of_named_tuples(ElementFallAndSupportTableRow)


TERMINATION_LIMITS_DTYPE: Final = table_dtype_of_named_tuples(ScenePenetrationAndEnergyLimits)


RESULT_TABLE_DTYPE: Final = table_dtype_of_named_tuples(SceneResultTableRow)


ELEMENT_RESULT_TABLE_DTYPE: Final = table_dtype_of_named_tuples(ElementResultRow)
