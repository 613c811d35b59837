"""Compute a random sample of a cube's cells again and compare them bit for bit."""

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
    """What a recheck found."""

    of: int  # cells of the cube
    content_as_stated: bool  # whether the file's numbers have the hash that the file states
    cells: int = 0  # computed again
    ensemble_cells: int = 0  # of these, with their ensemble
    differences: list[str] = field(default_factory=list)  # a line per value that differs

    @property
    def same(self) -> bool:
        """Nothing differs."""
        return not self.differences and self.content_as_stated


def recheck(path: Path, motions: Path | None = None, *, cells: int = 200, seed: int = 1) -> Recheck:
    """Compute a random sample of a cube's cells again; the motions are in ``motion`` beside it where not given.

    An `ArgumentError` says that no cell is asked for, a `ResultError` that the cube or a motion is not there, or that
    the cube is a part of that of its study.
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
    # Under each motion as recorded, and at each of the study's amplitudes where there are several.
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
                kept, new = file[variable.name][cell], variable.stored(again[variable.name])
                if new.tobytes() != kept.tobytes():
                    text = f"{names[index]}, {where}: {variable.name} is {kept} in the cube, {new} here"
                    result.differences.append(text)
    return result


def _recompute_cell(
    motion: Motion, grid: Grid, place: list[int], study: Study, variant: str, with_ensemble: bool
) -> dict[str, Any]:
    """The cell's values by name, computed from its direction and, before it, the one that may answer for it."""
    sources = model_for(study, variant).sources(grid).cell[place[0]]
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
