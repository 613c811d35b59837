"""Compute a random sample of a cube's cells again and compare them bit for bit."""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from overturning.dem.grid import opposite_azimuths
from overturning.dem.simulate import simulate_arrays
from overturning.dem.variables import VARIABLES
from overturning.errors import ArgumentError, ResultError
from overturning.records.store import read_motion
from overturning.study.config import Study
from overturning.study.cube import open_cube, study_of
from overturning.study.ensemble import ENSEMBLE_VARIABLES, blocks, run_ensemble
from overturning.study.grid import DIMENSIONS, Grid
from overturning.study.members import Members, draw_members
from overturning.study.scene_sweep import mirrors, scene_runner, simulate_study_scene
from overturning.study.scenes import scene_of
from overturning.study.sweep import motion_of, simulation_arguments, variables_of


@dataclass
class Recheck:
    """What a recheck found.

    Attributes
    ----------
    cells : int
        Cells computed again.
    of : int
        Cells of the cube.
    ensemble_cells : int
        Of these, how many with their ensemble.
    content_as_stated : bool
        Whether the file's numbers have the hash that the file states.
    differences : list of str
        One line per value that differs.
    """

    cells: int
    of: int
    ensemble_cells: int = 0
    content_as_stated: bool = True
    differences: list[str] = field(default_factory=list)

    @property
    def same(self) -> bool:
        """Nothing differs."""
        return not self.differences and self.content_as_stated


def recheck(path: Path, motions: Path | None = None, *, cells: int = 200, seed: int = 1) -> Recheck:
    """Compute a random sample of cells again.

    Parameters
    ----------
    path : Path
        The cube.
    motions : Path, optional
        Folder of the processed motions; ``motion`` beside the cube where not given.
    cells : int
        Size of the sample; every record has its share.
    seed : int
        Of the sample.

    Returns
    -------
    Recheck

    Raises
    ------
    ArgumentError
        If no cell is asked for.
    ResultError
        If the cube or a motion is not there.
    """
    from netCDF4 import Dataset

    if cells < 1:
        raise ArgumentError(f"cells: {cells}; at least 1")
    folder = motions or path.parent / "motion"
    with open_cube(path) as cube:
        study, variant = study_of(cube), str(cube.attrs["variant"])
        names = [str(name) for name in cube["record_id"].to_numpy()]
    grid = Grid.of(study, variant)
    members = draw_members(study.ensemble) if study.ensemble.members else None
    variables = variables_of(study)
    generator = np.random.Generator(np.random.PCG64(seed))
    with Dataset(path) as file:
        file.set_auto_maskandscale(False)
        result = Recheck(0, len(names) * grid.size)
        digest = hashlib.sha256()
        for variable in variables:
            digest.update(variable.name.encode())
            for index in range(len(names)):
                digest.update(np.ascontiguousarray(file[variable.name][index]).tobytes())
        result.content_as_stated = digest.hexdigest() == file.content_sha256
        chosen = np.sort(generator.choice(result.of, size=min(cells, result.of), replace=False))
        for index, name in enumerate(names):
            places = chosen[chosen // grid.size == index] % grid.size
            if places.size == 0:
                continue
            motion_file = folder / f"{name}.nc"
            if not motion_file.is_file():
                raise ResultError(f"{motion_file}: no such motion; name the folder of the motions with --motions")
            motion = motion_of(study, read_motion(motion_file))
            stored = {variable.name: file[variable.name][index] for variable in variables}
            for flat in places:
                place = tuple(int(i) for i in np.unravel_index(flat, grid.shape))
                again = _again(motion, grid, place, study, variant)
                if members is not None and stored["members"][place] > 0:
                    again |= _ensemble_again(motion, grid, place, members, study, variant)
                    result.ensemble_cells += 1
                result.cells += 1
                _compare(result, name, grid, place, stored, again, {v.name: v.fill_value for v in variables})
    return result


def _again(motion: Any, grid: Grid, place: tuple[int, ...], study: Study, variant: str) -> dict[str, Any]:
    source = int(opposite_azimuths(grid.azimuth.astype(np.float64))[place[0]])
    mirrored = source >= 0 and study.simulation.leave_out
    azimuths = np.array([float(grid.azimuth[i].item()) for i in ([source] if mirrored else []) + [place[0]]])
    height, b_over_h, friction = (
        float(getattr(grid, name)[i]) for name, i in zip(DIMENSIONS[1:], place[1:], strict=True)
    )
    if scene_of(study, variant) is not None:
        cell = {"height": (height,), "b_over_h": (b_over_h,), "friction": (friction,)}
        found = simulate_study_scene(study.model_copy(update=cell), variant, motion, azimuths)
    else:
        found = simulate_arrays(
            motion, azimuth_deg=azimuths, height=[height], b_over_h=[b_over_h], friction=[friction],
            **simulation_arguments(study, variant),
        )  # fmt: skip
    return {variable.name: found[variable.name][-1, 0, 0, 0] for variable in VARIABLES}


def _ensemble_again(
    motion: Any, grid: Grid, place: tuple[int, ...], members: Members, study: Study, variant: str
) -> dict[str, Any]:
    source = int(opposite_azimuths(grid.azimuth.astype(np.float64))[place[0]])
    scene = scene_of(study, variant)
    mirrored = source >= 0 and study.simulation.leave_out and mirrors(scene)
    at = (source if mirrored else place[0], *place[1:])
    one = Grid(*(getattr(grid, name)[[i]] for name, i in zip(DIMENSIONS, at, strict=True)))
    none = np.zeros((1, 1, 1, 1), dtype=np.int8)
    run = blocks(**simulation_arguments(study, variant)) if scene is None else scene_runner(study, variant)
    flags = none if not grid.element else np.zeros((1, 1, 1, 1, len(grid.element)), dtype=np.int8)
    found, _ = run_ensemble(motion, one, flags, none, members, everywhere=True, run=run)
    values = {variable.name: found[variable.name][0, 0, 0, 0] for variable in ENSEMBLE_VARIABLES}
    if mirrored:
        for name in ("probability", "scramble_difference"):
            values[f"{name}_towards"], values[f"{name}_away"] = values[f"{name}_away"], values[f"{name}_towards"]
    return values


def _compare(
    result: Recheck,
    record: str,
    grid: Grid,
    place: tuple[int, ...],
    stored: dict[str, Any],
    again: dict[str, Any],
    missing: dict[str, Any],
) -> None:
    for name, value in again.items():
        kept = stored[name][place]
        new = np.asarray(value).astype(kept.dtype)
        if new.dtype.kind == "f":
            new = np.where(np.isnan(new), np.asarray(missing[name], new.dtype), new)
        if new.tobytes() != kept.tobytes():
            where = ", ".join(f"{d} {getattr(grid, d)[i]:g}" for d, i in zip(DIMENSIONS, place, strict=True))
            result.differences.append(f"{record}, {where}: {name} is {kept} in the cube, {new} here")
