"""Plan of a simulation: kernel input for the cases of a model, their results, and the trajectory of a case."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.balance import rerun_until_energy_balances_or_mark_unstable
from overturning.dem.kernel.ground import (
    BaseAccelerationsAndMaximaInWindowAhead,
    max_acceleration_in_window_by_rest_check,
)
from overturning.dem.kernel.queue import SettingsCommonToParallelCases, run_case_queue
from overturning.dem.numerics import NumericalOptions
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.model import Model
from overturning.model.results import CaseResults
from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion

MAX_TRAJECTORY_DATASET_VALUES: Final = 100_000_000
"""Largest number of float64 values in the dataset of a path (0.8 GB)."""


def check_trajectory_size(min_trajectory_value_count: float) -> None:
    """Raise an `ArgumentError` if a trajectory of at least `min_trajectory_value_count` numbers would be too large."""
    if min_trajectory_value_count > MAX_TRAJECTORY_DATASET_VALUES:
        raise ArgumentError(
            f"trajectory: a path of {8e-9 * min_trajectory_value_count:.1f} GB or more, "
            f"at most {8e-9 * MAX_TRAJECTORY_DATASET_VALUES:.1f} GB; cut "
            "the motion to its strong part, take a larger time_step, a shorter aftermath or, in a scene, fewer elements"
        )


class Trajectory(Protocol):
    """Motion of a model over time in one case."""

    def variables_coordinates_and_attributes(
        self, results: CaseResults
    ) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        """Return variables (including those of `results`), coordinates and attributes of the trajectory's dataset."""


def group_numbers_of_equal_cases(*case_columns: NDArray[Any]) -> NDArray[np.int64]:
    """Return a group number for each of n cases, shape (n,): equal if the cases agree in all given columns."""
    return np.asarray(np.unique(np.stack(case_columns), axis=1, return_inverse=True)[1]).ravel()


@dataclass(frozen=True, kw_only=True)
class SimulationPlan(ABC):
    """Plan (checked input and settings) of the simulation of a model in n cases, for one compiled kernel.

    The values of a case depend only on this case and its motion, so that subsets give the same results.
    """

    shares_long_queue_between_two_threads: ClassVar[bool] = False
    """True if a long queue is split in two, so that two threads share its work."""
    run_case_queue_function: ClassVar[Any] = staticmethod(run_case_queue)
    """Function that runs a queue of cases."""
    result_dtype: ClassVar[Any]
    """Dtype of the kernel's result table; its columns include `status`, `energy_error` and `block_steps`."""
    trajectory_row_dtype: ClassVar[Any]
    """Dtype of a row of the path; if structured, it has a column `time`."""
    index_or_field_name_of_trajectory_time: ClassVar[Any] = "time"
    """Index of the time in a row of the path."""
    trajectory_columns_of_base_acceleration: ClassVar[Any] = ("ground_acceleration",)
    """Indices of the base motion in a row of the path."""
    dataset_values_per_trajectory_row: ClassVar[int] = 1
    """Number of values per time in the dataset of a path; limits the number of rows."""
    step_cost_in_block_steps: ClassVar[int] = 1
    """Block steps charged to the budget for one step."""

    model: Model
    motion: Motion
    cases: Cases
    numerics: NumericalOptions
    motion_row_by_case: NDArray[np.int64]  # shape (n,): row of `base_accelerations_by_direction` for each case
    base_accelerations_by_direction: (
        FloatArray  # shape (directions, …, samples + 3): acceleration of the base in each direction, m/s²
    )
    steps_per_sample: NDArray[np.int64]  # shape (n,): steps per sample
    first_simulated_sample: NDArray[np.int64]  # shape (n,): first sample that is computed
    stays_at_rest: NDArray[np.bool_]  # shape (n,): below the thresholds of rocking and sliding for the whole record
    has_too_soft_contacts: NDArray[np.bool_]  # shape (n,): `static_penetration_exceeds_limit`; such cases are not run
    case_table: NDArray[np.void]  # shape (n,): the kernel's table of cases

    @property
    def parallel_group_by_case(self) -> NDArray[np.int64]:
        """Group number of each case, shape (n,); cases with the same number are simulated in parallel."""
        return self.steps_per_sample

    @property
    def unscaled_upward_acceleration(self) -> FloatArray | None:
        """Unscaled upward base acceleration by sample, then three zeros, m/s²; None without vertical motion."""
        return None if self.motion.up is None else np.concatenate([self.motion.up, np.zeros(3)])

    @cached_property
    def max_base_accelerations_after_rest_checks_m_s2(self) -> tuple[FloatArray, FloatArray]:
        """Largest unscaled horizontal and vertical base accelerations in a time window after each rest check, m/s²."""
        across = (
            np.abs(self.base_accelerations_by_direction)
            if self.base_accelerations_by_direction.ndim == 2
            else np.sqrt((self.base_accelerations_by_direction**2).sum(axis=1))
        )
        up = (
            np.zeros(self.base_accelerations_by_direction.shape[-1])
            if self.unscaled_upward_acceleration is None
            else np.abs(self.unscaled_upward_acceleration)
        )
        interval = self.motion.sampling_interval
        return max_acceleration_in_window_by_rest_check(across, interval), max_acceleration_in_window_by_rest_check(
            up, interval
        )

    def initial_results_at_rest_or_missing(self) -> CaseResults:
        """Return results of cases before simulation: unmoved, or missing and `UNSTABLE` where contacts are too soft."""
        results = CaseResults.of_unmoved_cases(
            self.model.outcome_variables, self.cases.case_count, len(self.model.free_element_names)
        )
        results.status[self.has_too_soft_contacts], results.overturned[self.has_too_soft_contacts] = (
            CaseStatus.UNSTABLE,
            INT8_MISSING,
        )
        return results

    def simulate_group_with_reruns_on_energy_error(
        self,
        case_numbers: NDArray[np.int64],
        counter_of_block_steps_done: NDArray[np.int64],
        trajectory_buffer_of_first_case: NDArray[Any] | None = None,
    ) -> tuple[dict[str, Any], NDArray[Any]]:
        """Simulate cases of one group; repeat, with finer steps, those whose energy balance has too large an error.

        Parameters
        ----------
        case_numbers : ndarray of int64, shape (m,)
            Indices of the cases.
        counter_of_block_steps_done : ndarray of int64, shape (1,)
            Incremented by the block steps done, to show progress.
        trajectory_buffer_of_first_case : ndarray, shape (rows, …), optional
            Buffer for the trajectory of the first case; extended if it is too short. Default: none is recorded.

        Returns
        -------
        outcomes : dict of ndarray, shape (m, …)
            Variables by name; see `outcome_arrays_by_variable_name`.
        trajectory : ndarray, shape (rows, …)
            Trajectory of the first case; no rows if `trajectory_buffer_of_first_case` was not given.
        """
        tables = self.create_result_tables(case_numbers.size)
        results, buffer = (
            tables["results"],
            self.create_trajectory_buffer(is_recorded=False)
            if trajectory_buffer_of_first_case is None
            else trajectory_buffer_of_first_case,
        )
        recorded = buffer

        def simulate_cases_in_rows(result_rows: NDArray[np.int64], step_divisor: int) -> None:
            """Simulate the cases in these rows of the result table, with each time step divided by `step_divisor`."""
            nonlocal recorded
            buffer[:] = 0.0
            recorded, count = self.run_case_queue_function(
                self.kernel_input(case_numbers, tables, step_divisor), result_rows, counter_of_block_steps_done, buffer
            )
            if count < 0:  # the path has reached its limit
                check_trajectory_size(2 * recorded.size * self.dataset_values_per_trajectory_row)
            recorded = recorded[:count]

        rerun_until_energy_balances_or_mark_unstable(simulate_cases_in_rows, results["status"], results["energy_error"])
        return self.outcome_arrays_by_variable_name(case_numbers, tables), recorded

    def simulate_single_case(self, simulated_time_after_outcome_s: float = 0.0) -> tuple[CaseResults, Trajectory]:
        """Simulate the single case of the plan; return its results and its trajectory.

        The trajectory continues for `simulated_time_after_outcome_s` seconds after the outcome is known.
        """
        results, path, only = (
            self.initial_results_at_rest_or_missing(),
            self.create_trajectory_buffer(is_recorded=True),
            np.zeros(1, np.int64),
        )
        before = self.motion.sample_count
        if self.stays_at_rest[0] or self.has_too_soft_contacts[0]:
            path = path[:0]
        else:
            before = int(self.first_simulated_sample[0])
            outcomes, path = self.simulate_group_with_reruns_on_energy_error(only, np.zeros(1, np.int64), path)
            results.store_outcomes(only, outcomes)
            if simulated_time_after_outcome_s > 0.0:
                path = self.extend_trajectory_rows_of_scene_or_stack(
                    path, simulated_time_after_outcome_s, np.atleast_1d(results.overturned[0]) == 1
                )
        rest = self.trajectory_rows_at_rest(self.motion.sample_count)
        return results, self.convert_trajectory_rows(
            self.insert_skipped_sample_rows(np.concatenate([rest[:before], path]), rest)
        )

    def extend_trajectory_rows_of_scene_or_stack(
        self,
        trajectory_rows: NDArray[Any],
        added_time_s: float,  # noqa: ARG002
        has_fallen_by_element: NDArray[np.bool_],  # noqa: ARG002
    ) -> NDArray[Any]:
        """Return the trajectory rows unchanged; scenes and stacks override this to add `added_time_s` seconds.

        `has_fallen_by_element`, shape (elements,), is True for the elements that fell by the end of the case.
        """
        return trajectory_rows

    def insert_skipped_sample_rows(
        self, trajectory_rows: NDArray[Any], base_motion_row_by_sample: NDArray[Any]
    ) -> NDArray[Any]:
        """Return trajectory rows with rows inserted for the samples that were skipped because the model was at rest.

        In a skipped sample, the body has the pose of the row that follows, and the base its own motion, taken from
        `base_motion_row_by_sample`, which has a row for each sample of the record.
        """
        interval, time = self.motion.sampling_interval, trajectory_rows[self.index_or_field_name_of_trajectory_time]
        missing = np.maximum(np.rint(np.diff(time, prepend=time[:1]) / interval).astype(np.int64) - 1, 0)
        after = np.repeat(np.arange(len(trajectory_rows)), missing + 1)
        # Number of samples between each row and the computed row that follows it; 0 for computed rows.
        ahead = np.repeat(np.cumsum(missing + 1), missing + 1) - 1 - np.arange(after.size)
        filled, new = trajectory_rows[after], ahead > 0
        filled[self.index_or_field_name_of_trajectory_time] = time[after] - ahead * interval
        for column in self.trajectory_columns_of_base_acceleration:
            ground = np.interp(
                filled[self.index_or_field_name_of_trajectory_time],
                base_motion_row_by_sample[self.index_or_field_name_of_trajectory_time],
                base_motion_row_by_sample[column],
            )
            filled[column] = np.where(new, ground, filled[column])
        return filled

    def common_kernel_input_fields(
        self,
        case_numbers: NDArray[np.int64],
        result_tables: dict[str, NDArray[np.void]],
        step_divisor: int,
        ticks_per_whole_step: float,
        parallel_case_count: int,
    ) -> dict[str, Any]:
        """Return, by name, the input fields that the kernels of all models share (see `KernelInput`)."""
        cases, steps = self.case_table[case_numbers], int(self.steps_per_sample[case_numbers[0]]) * step_divisor
        # The shortest step is given in ticks, and a tick is shorter by the same factor.
        cases["steps_before_doubling_after_contact_change"] *= step_divisor
        settings = SettingsCommonToParallelCases(
            sample_count=self.motion.sample_count,
            sampling_interval=self.motion.sampling_interval,
            ticks_per_sample=ticks_per_whole_step * steps,
            attempted_steps_between_end_checks=steps,
            free_element_count=len(self.model.free_element_names),
            max_steps_times_elements_per_case=self.numerics.budget // self.step_cost_in_block_steps,
            max_trajectory_rows=MAX_TRAJECTORY_DATASET_VALUES // self.dataset_values_per_trajectory_row,
            parallel_case_count=parallel_case_count,
        )
        ground, row = (
            BaseAccelerationsAndMaximaInWindowAhead(
                self.base_accelerations_by_direction,
                self.unscaled_upward_acceleration,
                *self.max_base_accelerations_after_rest_checks_m_s2,
            ),
            self.motion_row_by_case[case_numbers],
        )
        return {
            "settings": settings,
            "cases": cases,
            "motion_row_by_case": row,
            "results": result_tables["results"],
            "ground_motion": ground,
        }

    def create_result_tables(self, case_count: int) -> dict[str, NDArray[np.void]]:
        """Return tables of zeros, by name, such as ``results``, that the kernel fills with a row for each case."""
        return {"results": np.zeros(case_count, self.result_dtype)}

    @abstractmethod
    def kernel_input(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]], step_divisor: int
    ) -> Any:
        """Return the kernel's input for the cases `case_numbers`, with each time step divided by `step_divisor`.

        The kernel fills `result_tables`.
        """

    @abstractmethod
    def outcome_arrays_by_variable_name(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]]
    ) -> dict[str, Any]:
        """Return arrays of the cases' outcomes by name of the variable, from the tables that the kernel has filled.

        One of the names is ``block_steps``: number of time steps times number of stones.
        """

    def create_trajectory_buffer(self, is_recorded: bool) -> NDArray[Any]:
        """Return a buffer for a trajectory: with a row per sample, or without rows if no trajectory is recorded."""
        rows = self.motion.sample_count if is_recorded else 0
        check_trajectory_size(rows * self.dataset_values_per_trajectory_row)
        return np.zeros(rows, self.trajectory_row_dtype)

    def trajectory_rows_at_rest(self, sample_count: int) -> NDArray[Any]:
        """Return trajectory rows of the model at rest, one for each of the first `sample_count` samples."""
        rows = np.zeros(sample_count, self.trajectory_row_dtype)
        rows["time"] = np.arange(sample_count) * self.motion.sampling_interval
        return rows

    @abstractmethod
    def convert_trajectory_rows(self, trajectory_rows: NDArray[Any]) -> Trajectory:
        """Convert the kernel's output rows of the plan's only case to a trajectory object."""


def azimuth_row_by_case_and_base_accelerations(motion: Motion, cases: Cases) -> tuple[NDArray[np.int64], FloatArray]:
    """Return the row of each of n cases in an array of unscaled base accelerations, and this array, m/s².

    The shapes are (n,) and (azimuths, samples + 3): a row for each distinct azimuth, with three zeros after the record.
    """
    if (np.asarray(cases.aspect) != 1.0).any():
        raise ArgumentError(f"aspect: {np.unique(cases.aspect).tolist()}; only a rectangle of the 3-D model has one")
    azimuths, row = np.unique(np.asarray(cases.azimuth_deg), return_inverse=True)
    ground = np.zeros((azimuths.size, motion.sample_count + 3))
    for index, azimuth in enumerate(azimuths):
        ground[index, : motion.sample_count] = motion.acceleration_along(float(azimuth))
    return row, ground


def evaluate_and_round_to_12_decimals(function: np.ufunc, arguments: FloatArray) -> FloatArray:
    """Return `function` at `arguments`, rounded to 12 decimals, because the last digit differs between processors."""
    distinct, where = np.unique(arguments, return_inverse=True)
    return np.asarray(np.round(function(distinct), 12)[where])
