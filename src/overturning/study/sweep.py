"""The sweep: every case of one record, into one part of the cube."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.dem.contact import Contact
from overturning.dem.simulate import simulate_arrays
from overturning.dem.variables import FLOAT32_MISSING, VARIABLES, Variable
from overturning.errors import ConfigError
from overturning.files import atomic_write
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.study.config import Study
from overturning.study.ensemble import ENSEMBLE_VARIABLES, Runner, blocks, run_ensemble
from overturning.study.grid import Grid
from overturning.study.members import Members, draw_members
from overturning.study.netcdf import add_coordinates, add_elements, add_variable
from overturning.study.scene_sweep import scene_runner, simulate_study_scene
from overturning.study.scenes import NOMINAL, scene_of
from overturning.study.sections import ContactSettings

NOMINAL_SHARE = 0.15
"""Share of a sweep's work that the nominal run has beside a usual ensemble; only for the progress line."""


def variant_names(study: Study) -> list[str]:
    """Names of the contact settings of a study, the nominal one first."""
    return [NOMINAL, *study.variants]


def contact_of(study: Study, variant: str) -> Contact:
    """The contact of a variant.

    Raises
    ------
    ConfigError
        If the study has no such variant.
    """
    if variant not in variant_names(study):
        raise ConfigError(f"{study.name}: no variant {variant!r}; known: {', '.join(variant_names(study))}")
    settings: ContactSettings = study.contact if variant == NOMINAL else study.variants[variant].contact
    return Contact(
        stiffness=settings.stiffness,
        stiffness_ratio=settings.stiffness_ratio,
        damping_ratio=settings.damping_ratio,
        damping=settings.damping,
    )


def simulation_arguments(study: Study, variant: str = NOMINAL) -> dict[str, Any]:
    """What a study hands to the simulation beside motion and grid."""
    given = {} if study.simulation.scheme is None else {"scheme": study.simulation.scheme}
    return {
        "density": study.density,
        "contact": contact_of(study, variant),
        "time_step": study.simulation.time_step,
        "leave_out": study.simulation.leave_out,
        **given,
    }


def variables_of(study: Study) -> tuple[Variable, ...]:
    """The variables of a study's cube: those of the outcome, and of the ensemble where there is one."""
    return (*VARIABLES, *ENSEMBLE_VARIABLES) if study.ensemble.members else VARIABLES


def motion_of(study: Study, record: Record) -> Motion:
    """The motion of a record as a study applies it: without the vertical component where the study leaves it out."""
    up = record.up if study.simulation.vertical else None
    return Motion(record.north, record.east, up, sampling_interval=record.sampling_interval)


def sweep_record(
    study: Study,
    record: Record,
    path: Path,
    variant: str = NOMINAL,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
    members: Members | None = None,
) -> int:
    """Simulate every case of one record and write them as a part of the cube.

    Parameters
    ----------
    study : Study
        The study.
    record : Record
        The processed record.
    path : Path
        NetCDF file to make.
    variant : str
        Name of the contact settings.
    threads : int
        Number of threads.
    progress : callable, optional
        Called now and then with the work done and the whole work, in block steps.
    members : Members, optional
        Of the ensemble; drawn from the study where not given.

    Returns
    -------
    int
        Block steps computed.
    """
    grid, motion = Grid.of(study, variant), motion_of(study, record)
    attributes = {"record_id": record.record_id, "variant": variant}
    with_ensemble = study.ensemble.members > 0
    first = 1.0 if not with_ensemble else NOMINAL_SHARE
    azimuth, begin = grid.azimuth.astype(np.float64), _part_of(progress, 0.0, first)
    run: Runner
    if scene_of(study, variant) is not None:
        outcome = simulate_study_scene(study, variant, motion, azimuth, threads, begin)
        run = scene_runner(study, variant)
    else:
        arguments = simulation_arguments(study, variant)
        outcome = simulate_arrays(
            motion, azimuth_deg=azimuth, height=grid.height, b_over_h=grid.b_over_h, friction=grid.friction,
            threads=threads, progress=begin, **arguments,
        )  # fmt: skip
        run = blocks(**arguments)
    block_steps = int(np.sum(outcome["block_steps"]))
    if with_ensemble:
        spread, more = run_ensemble(
            motion,
            grid,
            outcome["overturned"],
            outcome["mirrored"],
            members or draw_members(study.ensemble),
            everywhere=study.ensemble.where == "everywhere",
            threads=threads,
            run=run,
            progress=_part_of(progress, first, 1.0),
        )
        outcome |= spread
        block_steps += more
    write_part(path, grid, outcome, attributes, variables_of(study))
    return block_steps


def _part_of(
    progress: Callable[[int, int], None] | None, begin: float, end: float
) -> Callable[[int, int], None] | None:
    """Progress of one phase as progress of the whole, in millionths."""
    if progress is None:
        return None

    def report(done: int, total: int) -> None:
        progress(int(1e6 * (begin + (end - begin) * (done / total if total else 1.0))), 1_000_000)

    return report


def write_part(
    path: Path,
    grid: Grid,
    outcome: dict[str, NDArray[np.generic]],
    attributes: dict[str, str],
    variables: tuple[Variable, ...] = VARIABLES,
) -> None:
    """Write the outcome on a grid, or on a piece of one, as a part of the cube."""
    from netCDF4 import Dataset

    with atomic_write(path) as part, Dataset(part, "w", format="NETCDF4") as file:
        add_coordinates(file, grid.coordinates())
        add_elements(file, grid.element)
        for variable in variables:
            values = outcome[variable.name]
            if values.dtype.kind == "f":
                values = np.where(np.isnan(values), FLOAT32_MISSING, values)
            dimensions = grid.dimensions(variable.name)
            add_variable(file, variable, dimensions, grid.shape_of(variable.name))[:] = values
        file.setncatts(attributes)
