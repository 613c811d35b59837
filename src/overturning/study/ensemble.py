"""Ensemble: each case is run again with slightly changed parameters, to estimate the probability of falling.

The changes are scrambled Sobol points within the widths that a study sets, the same for every cell. The result
describes how sensitive the outcome is to parameters that are not known exactly; it does not describe how probable
these parameters are.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import ProgressCallback
from overturning.model.cases import Cases
from overturning.model.grid import CaseGrid
from overturning.model.model import Model
from overturning.model.variables import INT8_MISSING, RELIEF_ENSEMBLE_VARIABLES, OutcomeVariable
from overturning.motion.direction import angle_between_azimuths
from overturning.motion.motion import Motion
from overturning.study.ensemble_members import EnsembleParameterChanges

NORMAL_QUANTILE_OF_TWO_SIDED_95_PERCENT: Final = NormalDist().inv_cdf(0.975)
"""Quantile 0.975 of the standard normal distribution, 1.96."""


ENSEMBLE_CELLS_EACH_SIDE_OF_OUTCOME_CHANGE: Final = 2
"""Number of cells on either side of a change of outcome along B/H with ensemble runs under `where: boundary`."""

MIN_FALL_AZIMUTH_CHANGE_BETWEEN_CELLS_DEG: Final = 30.0
"""Smallest angle between the falls of neighbouring 3-D cells that counts as a change of outcome, degrees."""

MEMBERS_PER_BATCH: Final = 8
"""Number of runs in a batch, half from each Sobol sequence; convergence of a case is tested after each batch."""

MAX_ROTATED_MOTION_SAMPLES_IN_MEMORY = 20_000_000
"""Largest number of samples of rotated motions in memory (160 MB)."""

MAX_MEMBER_CASES_PER_RUN: Final = 1_000_000
"""Largest number of member cases that are run together (300 MB)."""

EnsembleMemberCaseRunner = Callable[..., Any]
"""Function of cases, progress and, for a scanned stone, a relief (m) that runs cases under the nominal motion."""

ArraysByVariableName = dict[str, NDArray[Any]]


def mask_of_cases_for_ensemble_runs(
    nominal_fall_flags: NDArray[np.int8],
    choose_all_cells: bool,
    grid_dimension_count: int = 4,
    nominal_fall_azimuth_deg: FloatArray | None = None,
) -> NDArray[np.bool_]:
    """Return a mask of the cases that get ensemble runs: those near a change of outcome along B/H, or all.

    All cases are chosen with `choose_all_cells`, or if there is a single B/H. Otherwise those among the nearest two on
    each side of a change, along B/H, of the nominal fall flag of any element; a missing flag differs from all others.
    In the 3-D model, where flags do not show the direction, a change of the fall azimuth by
    `MIN_FALL_AZIMUTH_CHANGE_BETWEEN_CELLS_DEG` or more counts, too (`nominal_fall_azimuth_deg`, NaN without a fall).
    Flags have shape (a, h, b, …) or (a, h, b, …, elements): a directions, h heights, b values of B/H.
    """
    shape = nominal_fall_flags.shape[:grid_dimension_count]
    if choose_all_cells or shape[2] == 1:
        return np.ones(shape, dtype=bool)
    change = nominal_fall_flags[:, :, 1:] != nominal_fall_flags[:, :, :-1]
    change = change.any(axis=grid_dimension_count) if change.ndim > grid_dimension_count else change
    if nominal_fall_azimuth_deg is not None:
        azimuth = nominal_fall_azimuth_deg.astype(np.float64)
        turned = (
            angle_between_azimuths(azimuth[:, :, 1:], azimuth[:, :, :-1]) >= MIN_FALL_AZIMUTH_CHANGE_BETWEEN_CELLS_DEG
        )
        change = change | (turned.any(axis=grid_dimension_count) if turned.ndim > grid_dimension_count else turned)
    # A change between i and i + 1 selects i − 1 to i + 2.
    reach = ENSEMBLE_CELLS_EACH_SIDE_OF_OUTCOME_CHANGE
    padded = np.pad(change, [(reach, reach) if axis == 2 else (0, 0) for axis in range(grid_dimension_count)])
    return np.asarray(sliding_window_view(padded, 2 * reach, axis=2).any(axis=-1))


def wilson_95_percent_interval(matching_count: ArrayLike, total_count: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Compute the 95 % Wilson interval (low, high) of a share of cases; (0, 1) if `total_count` is 0.

    Wilson (1927), Journal of the American Statistical Association 22. SciPy's function is too slow: one share per call.
    """
    n, k = np.asarray(total_count, np.float64), np.asarray(matching_count, np.float64)
    known = np.maximum(n, 1.0)
    z = NORMAL_QUANTILE_OF_TWO_SIDED_95_PERCENT
    share, square = k / known, z * z / known
    middle = (share + 0.5 * square) / (1.0 + square)
    half = z / (1.0 + square) * np.sqrt(share * (1.0 - share) / known + 0.25 * square / known)
    return np.where(k == 0, 0.0, middle - half), np.where(k == n, 1.0, middle + half)


def fall_probability_convergence_mask(member_fall_flags: NDArray[np.int8], max_half_width: float) -> NDArray[np.bool_]:
    """True for cases whose fall probabilities are accurate enough without further ensemble runs, shape (cases,).

    Criterion: for every element, the intervals (`wilson_95_percent_interval`) of the probabilities of a fall to +1 and
    to −1 have half-widths of at most `max_half_width`. Flags have shape (cases, members) or (cases, members,
    elements), and are missing if a member has no outcome or was not run yet. Each case is judged by its own flags only.
    """
    known = (member_fall_flags != INT8_MISSING).sum(axis=1)
    known_well = mask_of_narrow_fall_share_intervals(
        (member_fall_flags == 1).sum(axis=1), (member_fall_flags == -1).sum(axis=1), known, max_half_width
    )
    return np.asarray(known_well.reshape(len(member_fall_flags), -1).all(axis=1))


def mask_of_narrow_fall_share_intervals(
    plus_1_fall_counts: NDArray[Any],
    run_counts_of_falls_to_minus_1: NDArray[Any],
    known_outcome_counts: ArrayLike,
    max_half_width: float,
) -> NDArray[np.bool_]:
    """True where the 95 % intervals of the shares of falls to +1 and to −1 have half-widths up to a maximum."""
    ends = [
        wilson_95_percent_interval(count, known_outcome_counts)
        for count in (plus_1_fall_counts, run_counts_of_falls_to_minus_1)
    ]
    return np.asarray(np.logical_and(*(high - low <= 2.0 * max_half_width for low, high in ends)))


def fall_shares_by_relief_variable_name(
    member_fall_flags: NDArray[np.int8], high_base_relief_mask_by_member: NDArray[np.bool_]
) -> dict[str, NDArray[Any]]:
    """Return shares of falls among runs with low and high relief, the height up to which base points bear load.

    Flags have shape (cases, members), each share has shape (cases,); a share is NaN if none of its runs has an outcome.
    """
    known = member_fall_flags != INT8_MISSING
    counts = [((known & half).sum(axis=1), ((member_fall_flags == 1) & half).sum(axis=1)) for half in (
        ~high_base_relief_mask_by_member, high_base_relief_mask_by_member)]  # fmt: skip
    return {
        variable.name: np.where(count > 0, fell / np.maximum(count, 1), np.nan)
        for variable, (count, fell) in zip(RELIEF_ENSEMBLE_VARIABLES, counts, strict=True)
    }


def subtask_progress_callback(
    progress: ProgressCallback | None, share_before: float, share_after: float
) -> ProgressCallback | None:
    """Return a callback that takes the progress of part of a task and reports that of the whole to `progress`."""
    if progress is None:
        return None
    share = share_after - share_before
    return lambda done, total: progress(round(1e6 * (share_before + share * (done / total if total else 1.0))), 10**6)


@dataclass(frozen=True)
class EnsembleRunner:
    """Ensemble of a study: runs all cases, or those near a change of outcome, with changed parameters."""

    model: Model
    members: EnsembleParameterChanges
    run_all_cells: bool = True  # run all cells, not only those near a change of outcome
    max_fall_probability_interval_half_width: float = 0.0  # 0: every cell gets all members

    @property
    def ensemble_result_variables(self) -> tuple[OutcomeVariable, ...]:
        """Output variables with the ensemble results of each case, such as the probability of a fall."""
        return (
            *self.model.ensemble_variables,
            *(RELIEF_ENSEMBLE_VARIABLES if self.members.varies_scanned_base_relief else ()),
        )

    def choose_cases_and_run_their_ensembles(
        self,
        motion: Motion,
        grid: CaseGrid,
        nominal_outcomes_by_variable_name: Mapping[str, NDArray[Any]],
        run_cases: EnsembleMemberCaseRunner,
        progress: ProgressCallback | None = None,
    ) -> tuple[ArraysByVariableName, int]:
        """Run ensembles of all cases, or of those near an outcome change; return results and cost (steps × stones).

        `nominal_outcomes_by_variable_name` has `overturned`, shape (a, h, b, …) or (a, h, b, …, elements), and the
        flag of cases that are copied from others by symmetry; these are not run, their results are copied, too.
        `run_cases` simulates the cases that it is given. The results, arrays by variable name, have the shape of the
        grid, (a, h, b, …), or that of `overturned` if they differ between elements; missing floats are NaN.
        """
        overturned, members = nominal_outcomes_by_variable_name["overturned"], self.members
        computed = nominal_outcomes_by_variable_name[self.model.symmetry_copy_flag_variable_name] == 0
        azimuths = nominal_outcomes_by_variable_name.get("fall_azimuth")
        chosen = computed & mask_of_cases_for_ensemble_runs(overturned, self.run_all_cells, len(grid.shape), azimuths)
        arrays: ArraysByVariableName = {}
        for variable in self.ensemble_result_variables:
            shape = overturned.shape if variable.has_element_dimension else grid.shape
            arrays[variable.name] = np.full(shape, 0 if variable.name == "members" else np.nan, variable.dtype_in_file)
        directions = np.flatnonzero(chosen.any(axis=tuple(range(1, chosen.ndim))))
        together = max(1, min(MEMBERS_PER_BATCH, members.member_count))
        cells_of_each = max(1, int(np.prod(chosen.shape[1:])))
        most = MAX_ROTATED_MOTION_SAMPLES_IN_MEMORY // motion.sample_count
        group = max(1, min(most, MAX_MEMBER_CASES_PER_RUN // cells_of_each) // together)
        work, done, block_steps = max(1, int(chosen.sum())), 0, 0
        for start in range(0, directions.size, group):
            some = np.zeros_like(chosen)
            some[directions[start : start + group]] = True
            cells = np.argwhere(chosen & some)
            flags = np.full((len(cells), members.member_count, *overturned.shape[len(grid.shape) :]), INT8_MISSING)
            scene_becomes_3d_stack = self.model.direction_dimension_name == "orientation"
            azimuth = np.full(flags.shape if scene_becomes_3d_stack else flags.shape[:2], np.nan)
            of_group = subtask_progress_callback(progress, done / work, (done + len(cells)) / work)
            block_steps += self._run_members_until_converged_and_count_block_steps(
                grid, cells, run_cases, flags, azimuth, of_group
            )
            sensor = members.azimuth_change_deg.reshape(-1, *(1,) * (azimuth.ndim - 2))
            found = self.model.ensemble_statistics_by_case(flags, azimuth - sensor, members.sobol_sequence_number)
            if members.varies_scanned_base_relief:
                found |= fall_shares_by_relief_variable_name(flags, members.above_median_relief_mask)
            for name, values in found.items():
                arrays[name][tuple(cells.T)] = values
            done += len(cells)
        self._copy_to_symmetric_cells(grid, arrays, ~computed)
        return arrays, block_steps

    def _run_members_until_converged_and_count_block_steps(
        self, grid: CaseGrid, cell_indices: NDArray[np.int64], run_cases: EnsembleMemberCaseRunner,
        member_fall_flags: NDArray[np.int8], member_fall_azimuths_deg: FloatArray, progress: ProgressCallback | None,
    ) -> int:  # fmt: skip
        """Run members in batches until each case converges; write outcomes to arrays, return cost (steps × stones)."""
        batches, block_steps = self.members.split_members_into_batches_of_both_sequences(MEMBERS_PER_BATCH), 0
        unsettled = np.arange(len(cell_indices))
        for index, batch in enumerate(batches):
            of_batch = subtask_progress_callback(progress, index / len(batches), (index + 1) / len(batches))
            # Members with a relief of their own are other bodies, so each of them is run by itself.
            relief = self.members.relief_m
            for own in batch[:, None] if self.members.varies_scanned_base_relief else [batch]:
                results = run_cases(
                    self._cases_for_each_cell_and_ensemble_member(grid, cell_indices[unsettled],
                    self.members.select_members(own)),
                    of_batch, *([float(relief[own[0]])] if self.members.varies_scanned_base_relief else []),
                )  # fmt: skip
                block_steps += int(results.block_steps.sum())
                new = results.overturned.reshape(unsettled.size, own.size, *member_fall_flags.shape[2:])
                member_fall_flags[unsettled[:, None], own] = new
                if (towards := getattr(results, "fall_azimuth", None)) is not None:
                    azimuths = towards.reshape(unsettled.size, own.size, *member_fall_azimuths_deg.shape[2:])
                    member_fall_azimuths_deg[unsettled[:, None], own] = azimuths
            half_width = self.max_fall_probability_interval_half_width
            unsettled = unsettled[~fall_probability_convergence_mask(member_fall_flags[unsettled], half_width)]
            if unsettled.size == 0:
                break
        if progress:
            progress(1, 1)
        return block_steps

    def _cases_for_each_cell_and_ensemble_member(
        self, grid: CaseGrid, cell_indices: NDArray[np.int64], members: EnsembleParameterChanges
    ) -> Cases:
        """Return cases to simulate: each cell with the parameter changes of each ensemble member, sorted by cell."""
        direction, *rest = (
            grid[name][cell_indices[:, at], None].astype(np.float64) for at, name in enumerate(grid.dimension_names)
        )
        same = np.ones(members.member_count)
        centres = dict(zip(grid.dimension_names[1:], rest, strict=True))
        sizes = {name: value * getattr(members, f"{name}_factor", same) for name, value in centres.items()}
        alike = {"amplitude": members.amplitude_factor, "initial_tilt": members.initial_tilt_rad}
        alike["damping_factor"] = members.damping_factor
        return Cases(
            # Rotating the sensor anticlockwise is equivalent to rotating plane or body clockwise by the same angle.
            (direction + members.azimuth_change_deg + members.orientation_change_deg).ravel(),
            **{name: values.ravel() for name, values in sizes.items()},
            **{name: np.tile(one, len(cell_indices)) for name, one in alike.items()},
        )

    def _copy_to_symmetric_cells(self, grid: CaseGrid, results: ArraysByVariableName, is_copy: NDArray[Any]) -> None:
        """Copy ensemble results of simulated cases to the cases that equal them by symmetry, in `results`."""
        source = self.model.simulated_direction_for_each_direction(grid).simulated_direction_index
        for column in range(source.shape[1]):
            # In the 3-D model the period depends on the aspect, the dimension before friction.
            rest = (slice(None), slice(None), column) if source.shape[1] > 1 else ()
            alike = is_copy[(slice(None), *rest)]
            behind = np.flatnonzero(alike.any(axis=tuple(range(1, alike.ndim))))
            where = (source[behind, column], *rest)
            seen = {
                item.name: item.values_mirrored_to_opposite_azimuth(results, where)
                for item in self.ensemble_result_variables
            }
            for name, values in seen.items():
                results[name][(behind, *rest)] = values
