"""Simulate a random sample of the cases of a results cube again, and compare the outcomes bit by bit."""

from dataclasses import dataclass, field
from functools import cache
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from overturning.errors import ArgumentError, ResultError
from overturning.files import checksum_at_end_matches
from overturning.model.grid import CaseGrid
from overturning.model.results import CASE_COUNTER_NAMES
from overturning.motion.motion import Motion
from overturning.records.store import read_record_from_motion_file
from overturning.study.cube import motion_folder_of_cube, open_cube, study_of_cube
from overturning.study.netcdf import open_netcdf_without_masking_and_scaling, outcome_content_hash
from overturning.study.scenes import (
    cube_covers_study_grid,
    numerical_options_of_study,
    record_motion_with_up_only_if_variant_uses_it,
    variant_grid,
    variant_model,
)
from overturning.study.schema import Study
from overturning.study.sweep import (
    create_ensemble_member_case_runner,
    create_ensemble_runner,
    cube_variables_of_study,
    scale_motion,
    simulate_variant,
)


@dataclass
class ResimulationComparison:
    """Result of simulating cases of a results cube again: their number, and a line for each value that differs."""

    cube_cell_count: int  # number of cells of the cube
    stored_values_match_content_hash: bool  # True if the values match the hash in the file
    recomputed_cell_count: int = 0  # number of cells that were run again
    cell_count_with_recomputed_ensemble: int = 0  # of these, with their ensemble
    difference_messages: list[str] = field(default_factory=list)  # a line per value that differs

    @property
    def values_are_identical_and_hash_is_correct(self) -> bool:
        """True if all recomputed values are identical, and if the hash stored in the results cube is correct."""
        return not self.difference_messages and self.stored_values_match_content_hash


def stated_or_computed_hash_of_cube_outcomes(cube_path: Path) -> str:
    """Return the hash of the outcomes in a results cube, to detect changes by another program.

    If the checksum at the end of the file is correct, the file is unchanged since its run, and its attribute
    ``content_sha256`` is returned. Otherwise the hash is computed, since another program that saves the cube removes
    the checksum but keeps the attribute.
    """
    with open_cube(cube_path, element=None, amplitude=None) as cube:
        variables, stated = cube_variables_of_study(study_of_cube(cube)), str(cube.attrs["content_sha256"])
    if checksum_at_end_matches(cube_path):
        return stated
    with open_netcdf_without_masking_and_scaling(cube_path, "opened", "run the study again") as file:
        return outcome_content_hash(file, [one for one in variables if one.name in file.variables])


def recompute_and_compare_random_cases(
    cube_path: Path, motion_folder: Path | None = None, *, max_random_case_count: int = 200, seed: int = 1
) -> ResimulationComparison:
    """Simulate a random sample of cases of a results cube again, and compare the outcomes bit for bit.

    An `ArgumentError` is raised if `max_random_case_count` is below 1; a `ResultError` if the cube or a motion is
    missing, or if the cube does not have all cases of its study.
    """
    if max_random_case_count < 1:
        raise ArgumentError(f"cells: {max_random_case_count}; at least 1")
    with open_cube(cube_path, amplitude=None) as cube:
        study, variant = study_of_cube(cube), str(cube.attrs["variant"])
        names = [str(name) for name in cube["record_id"].to_numpy()]
        grid, variables = variant_grid(study, variant), cube_variables_of_study(study)
        if not cube_covers_study_grid(cube, study):
            raise ResultError(f"{cube_path}: a part of its study's cube; recheck the cube that the run made")
    folder = motion_folder or motion_folder_of_cube(cube_path, study, variant)
    # Each motion as recorded, and at all amplitudes of the study if there are several.
    scales = grid.motion_amplitude_factors_if_several or (1.0,)
    shape = (len(names), len(scales), *grid.shape)

    @cache
    def read_motion_with_components_used_by_study(record_id: str) -> Motion:
        """Read the stored motion of a record, without vertical component if the study or variant does not apply it."""
        if not (of_record := folder / f"{record_id}.nc").is_file():
            raise ResultError(f"{of_record}: no such motion; name the folder of the motions with --motions")
        return record_motion_with_up_only_if_variant_uses_it(study, read_record_from_motion_file(of_record), variant)

    with open_netcdf_without_masking_and_scaling(cube_path, "opened", "run the study again") as file:
        result = ResimulationComparison(prod(shape), outcome_content_hash(file, variables) == file.content_sha256)
        generator = np.random.Generator(np.random.PCG64(seed))
        chosen = np.sort(
            generator.choice(
                result.cube_cell_count, size=min(max_random_case_count, result.cube_cell_count), replace=False
            )
        )
        for index, scale, *place in np.column_stack(np.unravel_index(chosen, shape)).tolist():
            cell = (index, *((scale,) if grid.motion_amplitude_factors_if_several else ()), *place)
            with_ensemble = "members" in file.variables and bool(file["members"][cell] > 0)
            motion = scale_motion(read_motion_with_components_used_by_study(names[index]), scales[scale])
            again = _recompute_case_of_grid(motion, grid, place, study, variant, with_ensemble)
            result.cell_count_with_recomputed_ensemble += with_ensemble
            result.recomputed_cell_count += 1
            where = ", ".join(f"{d} {grid[d][i]:g}" for d, i in zip(grid.dimension_names, place, strict=True))
            where += f", amplitude {scales[scale]:g}" if grid.motion_amplitude_factors_if_several else ""
            for variable in (variable for variable in variables if variable.name in again):
                kept, new = file[variable.name][cell], variable.encode(again[variable.name])
                if new.tobytes() != kept.tobytes():
                    text = f"{names[index]}, {where}: {variable.name} is {kept} in the cube, {new} here"
                    result.difference_messages.append(text)
    return result


def _recompute_case_of_grid(
    motion: Motion,
    grid: CaseGrid,
    grid_indices_of_case: list[int],
    study: Study,
    variant: str,
    with_ensemble_runs: bool,
) -> dict[str, Any]:
    """Simulate one case of the grid again, or the case whose symmetric copy it is; return outcomes by variable name."""
    sources = (
        variant_model(study, variant)
        .simulated_direction_for_each_direction(grid)
        .simulated_direction_index[grid_indices_of_case[0]]
    )
    source = int(sources[grid_indices_of_case[3] if sources.size > 1 else 0])
    directions = list(
        dict.fromkeys([source, grid_indices_of_case[0]] if study.simulation.leave_out else [grid_indices_of_case[0]])
    )
    rows = zip(grid.dimension_names, [directions, *([i] for i in grid_indices_of_case[1:])], strict=True)
    few = grid.copy_with_dimension_values(**{name: grid[name][chosen] for name, chosen in rows})
    arrays = simulate_variant(study, variant, motion, few, numerical_options_of_study(study))
    if with_ensemble_runs:
        run = create_ensemble_member_case_runner(study, variant, motion, numerical_options_of_study(study))
        arrays |= create_ensemble_runner(
            study, variant, run_cells_far_from_outcome_changes=True
        ).choose_cases_and_run_their_ensembles(motion, few, arrays, run)[0]
    cell = (-1, *(0,) * (len(grid_indices_of_case) - 1))
    return {name: values[cell] for name, values in arrays.items() if name not in CASE_COUNTER_NAMES}
