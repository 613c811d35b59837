"""Random sample of the cases of a results cube, with the outcomes of the study, for the convergence check."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.model.planes import PlanarModel
from overturning.model.space import MIN_RESULTANT_OF_AGREEING_FALLS, case_weight_in_direction_statistics
from overturning.study.answers import CaseOutcomeArray, create_outcome_array_to_fill
from overturning.study.netcdf import open_netcdf_without_masking_and_scaling
from overturning.study.scenes import variant_grid, variant_model
from overturning.study.schema import Study
from overturning.study.sections import ConvergenceCheckSettings

MIN_FRICTION_TO_COMPARE_WITH_NON_SLIDING_BLOCK: Final = 1.0
"""Smallest friction of a rectangular block (with B/H below it) that is compared with a block that cannot slide."""

MAX_CELLS_COMPARED_WITH_RIGID_BLOCK: Final = 25_000
"""Largest number of cells compared with the rigid block (two or three seconds of processor time)."""

_FALL_PROBABILITY_VARIABLES: Final = ("probability_towards", "probability_away", "probability_falls")
"""Variables whose sum is the share of members that fall."""

_PROBABILITY_ROUNDING_TOLERANCE: Final = 1e-6


@dataclass(frozen=True)
class RandomCaseSample:
    """Random sample of the cases of a results cube with their outcomes, in the order in which they are run again."""

    record_indices: NDArray[np.int64]  # position of the record, shape (n,)
    grid_indices: NDArray[np.int64]  # positions along the dimensions of the study, shape (n, 4), or (n, 5) in space
    study_outcomes: CaseOutcomeArray
    is_below_rocking_and_sliding_thresholds: NDArray[
        np.bool_
    ]  # below the thresholds of rocking and sliding, shape (n,)
    ensemble_members_disagree_on_fall: NDArray[
        np.bool_
    ]  # some members of the ensemble fall and others stand, shape (n, elements)
    ensemble_members_disagree_on_fall_or_side: NDArray[
        np.bool_
    ]  # divided, or falls to both sides (3-D: agreement < `MIN_RESULTANT_OF_AGREEING_FALLS`), same shape
    fall_direction_statistics_weight: NDArray[
        np.float64
    ]  # weight of a fall in direction statistics (`case_weight_in_direction_statistics`), shape (n,)
    study_case_count_without_symmetry_copies: (
        int  # number of cases of the study that were computed, not copied by symmetry
    )
    block_time_step_count_of_whole_study: int  # of the whole study


def choose_random_record_and_grid_indices(
    convergence_check_settings: ConvergenceCheckSettings,
    record_count: int,
    cell_is_simulated_not_copied_mask: NDArray[np.bool_],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Choose n cases of a study at random; return their record indices (n,) and grid indices (n, dimensions).

    The first cases of the choice are a random choice, too. `cell_is_simulated_not_copied_mask` has the shape of the
    grid and is the same for every record; where it is False, the case is a symmetric copy of another and is not chosen.
    """
    cells = np.argwhere(cell_is_simulated_not_copied_mask)
    wanted = max(
        convergence_check_settings.at_least,
        round(convergence_check_settings.share * record_count * cell_is_simulated_not_copied_mask.size),
    )
    order = np.random.Generator(np.random.PCG64(convergence_check_settings.seed)).permutation(
        record_count * len(cells)
    )[:wanted]
    return order // len(cells), cells[order % len(cells)]


def mask_of_single_blocks_that_cannot_slide(study: Study) -> NDArray[np.bool_]:
    """Return a mask of a study's grid: True for single rectangular blocks with too much friction to slide."""
    model, grid = variant_model(study), variant_grid(study)
    if not (isinstance(model, PlanarModel) and model.scene.can_use_single_block_kernel):
        return np.zeros(grid.shape, np.bool_)
    own = model.scene.contact_law(*model.scene.elements).friction
    friction = grid["friction"] if own is None else np.full(grid["friction"].size, own)
    holds = (friction >= MIN_FRICTION_TO_COMPARE_WITH_NON_SLIDING_BLOCK) & (friction > grid["b_over_h"][:, None])
    return np.broadcast_to(holds, grid.shape)


def read_random_case_sample(
    cube_path: Path,
    convergence_check_settings: ConvergenceCheckSettings,
    candidate_cell_mask: NDArray[np.bool_] | None = None,
) -> RandomCaseSample:
    """Choose cases of a results cube at random, and read their outcomes from the cube.

    A case can be chosen if it was computed (not copied by symmetry) and, if given, is True in `candidate_cell_mask`,
    shaped like the grid. A ResultError is raised if the cube cannot be read.
    """
    with open_netcdf_without_masking_and_scaling(cube_path, "opened", "run the study again") as file:
        records = file.dimensions["record"].size
        # With several amplitudes, use the outcomes for the motions as recorded.
        recorded = (int(np.flatnonzero(file["amplitude"][:] == 1.0)[0]),) if "amplitude" in file.dimensions else ()
        computed = file["mirrored" if "mirrored" in file.variables else "repeated"][(0, *recorded)] == 0
        computed = computed if candidate_cell_mask is None else computed & candidate_cell_mask
        record, index = choose_random_record_and_grid_indices(convergence_check_settings, records, computed)
        place = np.argsort(np.argsort(record, kind="stable"))

        def read_variable_of_sampled_cases(variable_name: str) -> NDArray[Any]:
            """Read a variable of the n chosen cases from the cube, shape (n, elements), one record at a time."""
            of = [file[variable_name][(at, *recorded)][tuple(index[record == at].T)] for at in range(records)]
            return np.concatenate(of)[place].reshape(record.size, -1)

        overturned = read_variable_of_sampled_cases("overturned")
        answers = create_outcome_array_to_fill(*overturned.shape)
        answers["overturned"] = overturned
        if "fall_azimuth" in file.variables:
            answers["azimuth"] = read_variable_of_sampled_cases("fall_azimuth")
        falls = np.zeros(overturned.shape, np.float32)
        falls += sum(
            read_variable_of_sampled_cases(name) for name in _FALL_PROBABILITY_VARIABLES if name in file.variables
        )
        divided, at_rest = (
            (falls > 0) & (falls < 1 - _PROBABILITY_ROUNDING_TOLERANCE),
            read_variable_of_sampled_cases("status")[:, 0] == 1,
        )
        apart = divided.copy()
        if "probability_towards" in file.variables:
            towards = read_variable_of_sampled_cases("probability_towards")
            apart |= (towards > _PROBABILITY_ROUNDING_TOLERANCE) & (towards < 1 - _PROBABILITY_ROUNDING_TOLERANCE)
        weight = np.ones(record.size)
        if "fall_north" in file.variables:
            parts = [read_variable_of_sampled_cases(name) for name in ("fall_north", "fall_east")]
            apart |= (falls > 0) & (np.hypot(*parts) < MIN_RESULTANT_OF_AGREEING_FALLS * falls)
            # In a stack, the highest stone.
            weight = case_weight_in_direction_statistics(
                falls, parts[0], parts[1], read_variable_of_sampled_cases("members")
            )[:, -1]
        cases = records * int(computed.sum())
        return RandomCaseSample(record, index, answers, at_rest, divided, apart, weight, cases, int(file.block_steps))


def read_sample_to_compare_with_rigid_block(cube_path: Path, study: Study) -> RandomCaseSample | None:
    """Read up to `MAX_CELLS_COMPARED_WITH_RIGID_BLOCK` random cases of blocks that have too much friction to slide.

    They are compared with a rigid block. None if there are no such cases, or the study has no convergence check.
    """
    among = mask_of_single_blocks_that_cannot_slide(study)
    settings = study.verification
    if not among.any() or isinstance(settings, str):
        return None
    return read_random_case_sample(
        cube_path, settings.model_copy(update={"share": 0.0, "at_least": MAX_CELLS_COMPARED_WITH_RIGID_BLOCK}), among
    )
