"""Run a random sample of the cells of a cube again and compare the results bit by bit."""

from dataclasses import dataclass, field
from functools import cache
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from overturning.errors import ArgumentError, ResultError
from overturning.model.grid import Grid
from overturning.model.results import COUNTS
from overturning.motion.motion import Motion
from overturning.records.store import read_motion
from overturning.study.cube import motion_folder, open_cube, study_of
from overturning.study.netcdf import content_hash, open_raw
from overturning.study.scenes import grid_of, model_for, motion_of, numerics_of
from overturning.study.schema import Study
from overturning.study.sweep import ensemble_of, member_runner, scaled, simulate_variant, variables_of


@dataclass
class Recheck:
    """Result of a recheck."""

    of: int  # number of cells of the cube
    content_as_stated: bool  # True if the values match the hash in the file
    cells: int = 0  # number of cells that were run again
    ensemble_cells: int = 0  # of these, with their ensemble
    differences: list[str] = field(default_factory=list)  # a line per value that differs

    @property
    def same(self) -> bool:
        """True if all values agree."""
        return not self.differences and self.content_as_stated


def recheck(path: Path, motions: Path | None = None, *, cells: int = 200, seed: int = 1) -> Recheck:
    """Run a random sample of the cells of a cube again; the default folder of motions is ``motion`` next to it.

    An `ArgumentError` is raised if `cells` is below 1, a `ResultError` if the cube or a motion is missing, or if the
    cube is only a part of the cube of its study.
    """
    if cells < 1:
        raise ArgumentError(f"cells: {cells}; at least 1")
    with open_cube(path, amplitude=None) as cube:
        study, variant = study_of(cube), str(cube.attrs["variant"])
        names = [str(name) for name in cube["record_id"].to_numpy()]
        grid, variables = grid_of(study, variant), variables_of(study)
        whole = grid.rows | ({"amplitude": np.array(grid.amplitude)} if grid.amplitude else {})
        if any(cube.sizes.get(name) != row.size or not np.allclose(cube[name], row) for name, row in whole.items()):
            raise ResultError(f"{path}: a part of its study's cube; recheck the cube that the run made")
    folder = motions or motion_folder(path, study, variant)
    # Each motion as recorded, and at all amplitudes of the study if there are several.
    scales = grid.amplitude or (1.0,)
    shape = (len(names), len(scales), *grid.shape)

    @cache
    def motion_named(name: str) -> Motion:
        if not (of_record := folder / f"{name}.nc").is_file():
            raise ResultError(f"{of_record}: no such motion; name the folder of the motions with --motions")
        return motion_of(study, read_motion(of_record), variant)

    with open_raw(path, "opened", "run the study again") as file:
        result = Recheck(prod(shape), content_hash(file, variables) == file.content_sha256)
        generator = np.random.Generator(np.random.PCG64(seed))
        chosen = np.sort(generator.choice(result.of, size=min(cells, result.of), replace=False))
        for index, scale, *place in np.column_stack(np.unravel_index(chosen, shape)).tolist():
            cell = (index, *((scale,) if grid.amplitude else ()), *place)
            with_ensemble = "members" in file.variables and bool(file["members"][cell] > 0)
            motion = scaled(motion_named(names[index]), scales[scale])
            again = _recompute_cell(motion, grid, place, study, variant, with_ensemble)
            result.ensemble_cells += with_ensemble
            result.cells += 1
            where = ", ".join(f"{d} {grid[d][i]:g}" for d, i in zip(grid.names, place, strict=True))
            where += f", amplitude {scales[scale]:g}" if grid.amplitude else ""
            for variable in (variable for variable in variables if variable.name in again):
                kept, new = file[variable.name][cell], variable.encode(again[variable.name])
                if new.tobytes() != kept.tobytes():
                    text = f"{names[index]}, {where}: {variable.name} is {kept} in the cube, {new} here"
                    result.differences.append(text)
    return result


def _recompute_cell(
    motion: Motion, grid: Grid, place: list[int], study: Study, variant: str, with_ensemble: bool
) -> dict[str, Any]:
    """Return the values of a cell by name, simulated with its direction and the one it may be copied from."""
    sources = model_for(study, variant).computed_cells(grid).cell[place[0]]
    source = int(sources[place[3] if sources.size > 1 else 0])
    directions = list(dict.fromkeys([source, place[0]] if study.simulation.leave_out else [place[0]]))
    rows = zip(grid.names, [directions, *([i] for i in place[1:])], strict=True)
    few = grid.replace_rows(**{name: grid[name][chosen] for name, chosen in rows})
    arrays = simulate_variant(study, variant, motion, few, numerics_of(study))
    if with_ensemble:
        run = member_runner(study, variant, motion, numerics_of(study))
        arrays |= ensemble_of(study, variant, everywhere=True).run(motion, few, arrays, run)[0]
    cell = (-1, *(0,) * (len(place) - 1))
    return {name: values[cell] for name, values in arrays.items() if name not in COUNTS}
