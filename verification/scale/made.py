"""Synthetic studies, parts and cubes of any size, filled with random numbers in place of results."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.model.status import CaseStatus
from overturning.model.variables import OutcomeVariable
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.records.store import round_samples_to_stored_decimals, write_record_to_motion_file
from overturning.study.gather import create_cube_structure, merge_outcome_files_into_cube
from overturning.study.load import study_from_content
from overturning.study.parts import SweepChunk, grid_of_chunk, path_of_chunk_outcome_file, write_outcome_file_of_chunk
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant_grid
from overturning.study.schema import Study
from overturning.study.sweep import cube_variables_of_study

FALLEN_SHARE_OF_SYNTHETIC_CELLS: Final = 0.3
"""Share of the cells that fall, as in the default study."""

SHARE_OF_SYNTHETIC_CELLS_WITH_ENSEMBLE: Final = 0.6
"""Share of the cells with an ensemble."""

MILLION_CASE_2D_GRID: Final = {
    "azimuth": {"step": 1},
    "height": {"start": 0.5, "stop": 0.9, "step": 0.1},
    "b_over_h": {"start": 0.05, "stop": 0.6, "step": 0.01},
    "friction": {"start": 0.3, "stop": 1.2, "step": 0.1},
}
"""Grid of 1,008,000 2-D cases."""

MILLION_CASE_3D_STUDY_SETTINGS: Final = {
    "body": {"plan": "rectangle", "aspect": [1, 2]},
    "orientation": {"step": 1},
    "ensemble": {"members": 24},
    "population": {},
} | {name: MILLION_CASE_2D_GRID[name] for name in ("height", "b_over_h", "friction")}
"""Settings of a study with 1,008,000 3-D cases."""


def synthetic_study(record_count: int, grid_settings: dict[str, Any] | None = None) -> Study:
    """Return a study with `record_count` records; the default grid has a million 2-D cases for each."""
    names = [f"made-{number:03d}" for number in range(record_count)]
    about = {"name": "made", "verification": "none", "figures": {"formats": ["png"], "dpi": 72}}
    return study_from_content(about | {"records": {"use": names}} | (grid_settings or MILLION_CASE_2D_GRID), "made")


def synthetic_records(study: Study) -> Iterator[Record]:
    """Yield a different pulse for each record, in five earthquakes; half of the records count as having a pulse."""
    for number, name in enumerate(study.records.use):
        # A second pulse at right angles to the first, so that every direction has motion. Delay or period differ by
        # record: records that differ in amplitude and axes only would be refused as copies of one motion.
        one, other = (
            Motion.sine(amplitude=amplitude, period=0.6 + 0.1 * (number // 40), azimuth_deg=7.0 * number + turn)
            for amplitude, turn in ((2.0 + 0.05 * number, 0.0), (1.0 + 0.025 * number, 90.0))
        )
        delay = 20 + 5 * (number % 40)
        north, east = one.north + np.roll(other.north, delay), one.east + np.roll(other.east, delay)
        record = Record(name, north, east, None, one.sampling_interval)
        known = {"pulse": number % 2 == 0, "event_latitude": 35.0, "event_longitude": 133.0}
        yield round_samples_to_stored_decimals(replace(
            record, station=name, event=f"earthquake {number % 5}", fault_strike_deg=10.0 * (number % 5), extra=known
        ))  # fmt: skip


def random_outcome_values(
    outcome_variable: OutcomeVariable, shape: tuple[int, ...], seed: int, ensemble_member_count: int
) -> NDArray[Any]:
    """Return random values in place of the results of an outcome variable; float32 values have 23 random bits."""
    generator = np.random.default_rng(seed)
    if outcome_variable.name == "overturned" and outcome_variable.is_odd_under_mirroring:
        return generator.choice(
            np.array([-1, 0, 1], np.int8),
            shape,
            p=[
                FALLEN_SHARE_OF_SYNTHETIC_CELLS / 2,
                1 - FALLEN_SHARE_OF_SYNTHETIC_CELLS,
                FALLEN_SHARE_OF_SYNTHETIC_CELLS / 2,
            ],
        )
    if outcome_variable.name.endswith("overturned"):
        return synthetic_fall_flags_of_3d_body(outcome_variable, shape, seed).astype(np.int8)
    if outcome_variable.name == "status":
        return np.full(shape, int(CaseStatus.SIMULATED), np.int8)
    if outcome_variable.dtype_in_file != "f4":
        return np.full(
            shape, ensemble_member_count if outcome_variable.name == "members" else 0, outcome_variable.dtype_in_file
        )
    values: NDArray[Any] = generator.random(shape, np.float32)
    if outcome_variable.name == "overturning_time":
        values[generator.random(shape, np.float32) > FALLEN_SHARE_OF_SYNTHETIC_CELLS] = np.nan
    if outcome_variable.name.endswith("fall_azimuth"):
        return np.where(
            synthetic_fall_flags_of_3d_body(outcome_variable, shape, seed), 360 * values, np.float32(np.nan)
        )
    if outcome_variable.name == "residual_twist":
        return np.where(
            synthetic_fall_flags_of_3d_body(outcome_variable, shape, seed), np.float32(np.nan), values - np.float32(0.5)
        )
    if outcome_variable.name.startswith(("probability", "scramble", "fall_")):
        # Shares of members; NaN for cells without an ensemble.
        values = np.round(values * 0.5 * ensemble_member_count) / np.float32(ensemble_member_count)
        values[generator.random(shape, np.float32) > SHARE_OF_SYNTHETIC_CELLS_WITH_ENSEMBLE] = np.nan
    return values


def synthetic_fall_flags_of_3d_body(
    outcome_variable: OutcomeVariable, shape: tuple[int, ...], seed: int
) -> NDArray[np.bool_]:
    """Return True at random for cells in which a synthetic 3-D body, or its 2-D model, falls.

    The flags are the same for all variables of the body, and for all those of the model (named ``plane…``).
    """
    return (
        np.random.default_rng((seed, outcome_variable.name.startswith("plane"))).random(shape, np.float32)
        < FALLEN_SHARE_OF_SYNTHETIC_CELLS
    )


def write_synthetic_partial_results(
    study: Study, folder: Path, chunk_count_per_record: int, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
) -> list[Path]:
    """Write files with random values in place of the results of every chunk of cases of every record of a study."""
    grid, variables, paths = variant_grid(study, variant), cube_variables_of_study(study), []
    for number, name in enumerate(study.records.use):
        for part in range(1, chunk_count_per_record + 1):
            chunk = SweepChunk(part, chunk_count_per_record)
            piece = grid_of_chunk(study, grid, chunk, variant)
            values = {
                variable.name: random_outcome_values(
                    variable,
                    piece.one_record_cube_shape_of_variable(variable),
                    1000 * number + part,
                    study.ensemble.members,
                )
                for variable in variables
            }
            paths.append(path_of_chunk_outcome_file(folder, name, chunk))
            write_outcome_file_of_chunk(
                paths[-1], piece, values, {"record_id": name, "variant": variant, "block_steps": 0}, variables
            )
    return paths


def write_synthetic_motions(study: Study, folder: Path) -> None:
    """Write the motion file of every record of a study."""
    for record in synthetic_records(study):
        write_record_to_motion_file(record, folder / f"{record.record_id}.nc")


def write_study_as_json(study: Study, path: Path) -> None:
    """Write the study to a file."""
    path.write_text(json.dumps(study.model_dump(mode="json", exclude_defaults=True) | {"name": study.name}), "utf-8")


def write_synthetic_cube(
    study: Study, path: Path, distinct_record_count: int, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
) -> None:
    """Write a cube whose first `distinct_record_count` records have synthetic values of their own.

    The other records repeat these.
    """
    import h5py
    from netCDF4 import Dataset

    records = list(synthetic_records(study))
    few = study.model_copy(
        update={"records": study.records.model_copy(update={"use": study.records.use[:distinct_record_count]})}
    )
    parts = write_synthetic_partial_results(few, path.parent / "parts", 1, variant)
    merge_outcome_files_into_cube(few, records[:distinct_record_count], parts, path.with_name("few.nc"), variant)
    for part in parts:
        part.unlink()
    with Dataset(path, "w", format="NETCDF4") as cube:
        create_cube_structure(cube, study, records, variant)
        cube.content_sha256 = "made: random numbers"
    with h5py.File(path.with_name("few.nc")) as source, h5py.File(path, "r+") as cube:
        for variable in cube_variables_of_study(study):
            blocks = source[variable.name].id
            for index in range(blocks.get_num_chunks()):
                place = blocks.get_chunk_info(index).chunk_offset
                mask, data = blocks.read_direct_chunk(place)
                for record in range(place[0], len(records), distinct_record_count):
                    cube[variable.name].id.write_direct_chunk((record, *place[1:]), data, mask)
    path.with_name("few.nc").unlink()
