"""Sweep: simulate all cases of one record, or a chunk of them, and write one part of the cube."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.dem.faces import simulate_grid_and_2d_face_planes_of_rectangle
from overturning.dem.numerics import NumericalOptions, ProgressCallback
from overturning.dem.run import simulate_cases
from overturning.model.cases import Cases
from overturning.model.grid import CaseGrid
from overturning.model.results import CASE_COUNTER_NAMES, CaseResults
from overturning.model.variables import RELIEF_ENSEMBLE_VARIABLES, OutcomeVariable
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.study.ensemble import EnsembleMemberCaseRunner, EnsembleRunner, subtask_progress_callback
from overturning.study.ensemble_members import EnsembleParameterChanges, draw_parameter_changes_of_members
from overturning.study.parts import WHOLE_RECORD_CHUNK, SweepChunk, grid_of_chunk, write_outcome_file_of_chunk
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    StudyToSceneSizeConversion,
    numerical_options_of_study,
    record_motion_with_up_only_if_variant_uses_it,
    variant_grid,
    variant_model,
)
from overturning.study.schema import Study

ASSUMED_NOMINAL_RUN_SHARE_OF_PROGRESS = 0.15
"""Assumed share of the nominal run in the work of a sweep with an ensemble; only for the progress line."""

_AMPLITUDE_FACTOR_OF_WARM_UP_CASE = 3.0
"""Factor on the motion for loading kernels; with it nearly every record moves the first stone of the grid."""


def cube_variables_of_study(study: Study) -> tuple[OutcomeVariable, ...]:
    """Return the variables in the results cube of a study: outcomes, and ensemble results if it has an ensemble."""
    model = variant_model(study)
    return (
        *model.outcome_variables,
        *model.outcome_variables_of_2d_runs_in_face_planes,
        *(model.ensemble_variables if study.ensemble.members else ()),
        *(RELIEF_ENSEMBLE_VARIABLES if study.ensemble.members and study.ensemble.relief else ()),
    )


def create_ensemble_runner(
    study: Study,
    variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    members: EnsembleParameterChanges | None = None,
    run_cells_far_from_outcome_changes: bool = False,
) -> EnsembleRunner:
    """Create the ensemble runner of a study or variant, with the given parameter changes or newly drawn ones."""
    settings = study.ensemble
    run_cells_far_from_outcome_changes = run_cells_far_from_outcome_changes or settings.where == "everywhere"
    return EnsembleRunner(
        variant_model(study, variant),
        members or draw_parameter_changes_of_members(settings),
        run_cells_far_from_outcome_changes,
        settings.half_width,
    )


def simulate_variant(
    study: Study, variant: str, motion: Motion, grid: CaseGrid, numerics: NumericalOptions
) -> dict[str, NDArray[Any]]:
    """Simulate all cases of a parameter grid for a study or variant; return outcome arrays by variable name.

    A variant's scene is scaled by the same factor as the study's scene. The reference element, which sets the size of
    the scene, gets the B/H of the grid if it has the same name in both scenes. Otherwise it keeps its own B/H, and the
    outcomes are the same for all B/H of the grid.
    """
    model, sizes = variant_model(study, variant), StudyToSceneSizeConversion.for_variant(study, variant)
    sized = grid.copy_with_dimension_values(height=sizes.to_variant_reference_stone_heights(grid["height"]))
    if sizes.scene_b_over_h_if_study_reference_differs is None:
        return simulate_grid_and_2d_face_planes_of_rectangle(model, motion, sized, numerics)
    arrays = simulate_grid_and_2d_face_planes_of_rectangle(
        model,
        motion,
        sized.copy_with_dimension_values(b_over_h=np.array([sizes.scene_b_over_h_if_study_reference_differs])),
        numerics,
    )
    counts = {name: arrays.pop(name) for name in CASE_COUNTER_NAMES}
    return {name: np.repeat(values, grid.shape[2], axis=2) for name, values in arrays.items()} | counts


def create_ensemble_member_case_runner(
    study: Study, variant: str, motion: Motion, numerics: NumericalOptions
) -> EnsembleMemberCaseRunner:
    """Return a function that simulates ensemble runs of a study or variant for cases with the study's stone sizes."""
    model: Any = variant_model(study, variant)
    sizes = StudyToSceneSizeConversion.for_variant(study, variant)

    def simulate_members_with_study_stone_sizes(
        cases_with_study_stone_sizes: Cases,
        progress: ProgressCallback | None,
        max_height_of_bearing_base_points_m: float | None = None,
    ) -> CaseResults:
        """Simulate ensemble runs, after converting the sizes of the study's stone to those of the variant's scene."""
        height, b_over_h = (
            np.asarray(cases_with_study_stone_sizes.height),
            np.asarray(cases_with_study_stone_sizes.b_over_h),
        )
        ratio = sizes.to_variant_reference_stone_b_over_h(b_over_h, np.array(study.b_over_h))
        sized = replace(
            cases_with_study_stone_sizes, height=sizes.to_variant_reference_stone_heights(height), b_over_h=ratio
        )
        body = (
            model
            if max_height_of_bearing_base_points_m is None
            else model.with_base_relief(max_height_of_bearing_base_points_m)
        )
        return simulate_cases(body, motion, sized, replace(numerics, progress=progress))

    return simulate_members_with_study_stone_sizes


def simulate_and_write_cases_of_record(
    study: Study,
    record: Record,
    output_path: Path,
    variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    *,
    members: EnsembleParameterChanges | None = None,
    chunk: SweepChunk = WHOLE_RECORD_CHUNK,
    numerics: NumericalOptions | None = None,
) -> None:
    """Simulate all cases of one record, or a chunk (part) of them, and write the outcomes to a NetCDF file.

    Ensemble members (sets of parameter changes) are drawn from the settings of the study if not given. `numerics` are
    from `numerical_options_of_study`, with threads, progress and cluster. The file also states the number of block
    steps (time steps × blocks); its sum over the chunks does not depend on the division into chunks or on threads.
    """
    grid, motion = (
        grid_of_chunk(study, variant_grid(study, variant), chunk, variant),
        record_motion_with_up_only_if_variant_uses_it(study, record, variant),
    )
    attributes = {"record_id": record.record_id, "variant": variant}
    if not grid.case_count:
        write_outcome_file_of_chunk(output_path, grid, {}, attributes | {"block_steps": 0})
        return
    numerics = numerics or numerical_options_of_study(study)
    factors = grid.motion_amplitude_factors_if_several or (1.0,)
    work = [
        *(ASSUMED_NOMINAL_RUN_SHARE_OF_PROGRESS for _ in factors),
        *([1.0 - ASSUMED_NOMINAL_RUN_SHARE_OF_PROGRESS] if study.ensemble.members else []),
    ]
    ends = (np.cumsum([0.0, *work]) / sum(work)).tolist()
    reports = [subtask_progress_callback(numerics.progress, *between) for between in pairwise(ends)]
    answers = [
        simulate_variant(study, variant, scale_motion(motion, factor), grid, replace(numerics, progress=progress))
        for factor, progress in zip(factors, reports, strict=False)  # the last is then the ensemble's
    ]
    block_steps = sum(int(np.sum(one["block_steps"])) for one in answers)
    outcome = answers[factors.index(1.0)]
    if study.ensemble.members:
        ensemble, runner = (
            create_ensemble_runner(study, variant, members),
            create_ensemble_member_case_runner(study, variant, motion, numerics),
        )
        spread, more = ensemble.choose_cases_and_run_their_ensembles(motion, grid, outcome, runner, reports[-1])
        outcome |= spread
        block_steps += more
    if grid.motion_amplitude_factors_if_several:
        outcome = _stack_outcomes_along_first_amplitude_axis(answers, cube_variables_of_study(study), outcome)
    write_outcome_file_of_chunk(
        output_path, grid, outcome, attributes | {"block_steps": block_steps}, cube_variables_of_study(study)
    )


def load_compiled_simulation_code(
    study: Study, record: Record, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
) -> None:
    """Load the compiled simulation code of a study into this process, by simulating one case that moves."""
    grid = variant_grid(study, variant)
    one_case = grid.copy_with_dimension_values(**{name: grid[name][:1] for name in grid.dimension_names})
    motion = record_motion_with_up_only_if_variant_uses_it(study, record, variant).scaled_by(
        _AMPLITUDE_FACTOR_OF_WARM_UP_CASE
    )
    simulate_variant(study, variant, motion, one_case, numerical_options_of_study(study))


def scale_motion(motion: Motion, amplitude_factor: float) -> Motion:
    """Return a motion with its accelerations multiplied by an amplitude factor."""
    return motion if amplitude_factor == 1.0 else motion.scaled_by(amplitude_factor)


def _stack_outcomes_along_first_amplitude_axis(
    outcomes_by_name_for_each_amplitude: list[dict[str, NDArray[Any]]],
    outcome_variables: tuple[OutcomeVariable, ...],
    nominal_outcomes_by_variable_name: dict[str, NDArray[Any]],
) -> dict[str, NDArray[Any]]:
    """Join outcomes for all amplitude factors along a new first axis; ensemble results exist for factor 1 only."""
    unknown = {one.name: 0 if one.name == "members" else one.missing_value_in_memory for one in outcome_variables}
    missing = {name: np.full_like(nominal_outcomes_by_variable_name[name], value) for name, value in unknown.items()}
    return {
        name: np.stack([one.get(name, absent) for one in outcomes_by_name_for_each_amplitude])
        for name, absent in missing.items()
    }
