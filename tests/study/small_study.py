"""Small studies: settings, a record, and the cube of them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from overturning.records.record import Record
from overturning.records.store import read_record_from_motion_file, write_record_to_motion_file
from overturning.study.gather import merge_outcome_files_into_cube
from overturning.study.load import study_from_content
from overturning.study.parts import WHOLE_RECORD_CHUNK, SweepChunk, paths_of_chunk_outcome_files
from overturning.study.schema import Study
from overturning.study.sweep import simulate_and_write_cases_of_record


def small_study(**more: object) -> Study:
    """Return a small study of two records; keyword arguments replace its settings."""
    base = {
        "name": "small", "records": {"use": ["a", "b"]}, "azimuth": {"step": 60}, "b_over_h": [0.2, 0.3, 0.4],
        "height": [0.6], "friction": [0.58], "verification": {"at_least": 10},
    }  # fmt: skip
    return study_from_content(base | more, "small")


def sine_cycle_record(
    name: str = "a", peak: float = 6.0, east_over_north: float = 0.3, begin: float = 1.0, cycles: int = 1
) -> Record:
    """Return a record: sine cycles of 0.8 s northwards, `east_over_north` times that eastwards, then 2.2 s of rest."""
    end = begin + 0.8 * cycles
    time = np.arange(0, end + 2.2, 0.01)
    sine = peak * np.sin(2 * np.pi * (time - begin) / 0.8)
    cycle = np.round(np.where((time > begin) & (time < end), sine, 0.0), 9)
    about = {"station": "S", "event": "E", "source": "made", "licence": "none", "sha256": "0" * 64}
    return Record(name, cycle, np.round(east_over_north * cycle, 9), None, 0.01, **about)


def simulate_study_cube(
    settings: Study, records: Sequence[Record], folder: Path, variant: str = "nominal", chunks: int = 1
) -> Path:
    """Simulate a variant of a study and return the path of its cube, in a folder that also gets the motion files."""
    for record in records:
        write_record_to_motion_file(record, folder / "motion" / f"{record.record_id}.nc")
    kept = [read_record_from_motion_file(folder / "motion" / f"{record.record_id}.nc") for record in records]
    parts = paths_of_chunk_outcome_files(folder / "sweep" / variant, [record.record_id for record in records], chunks)
    for number, part in enumerate(parts):
        chunk = SweepChunk(number % chunks + 1, chunks) if chunks > 1 else WHOLE_RECORD_CHUNK
        simulate_and_write_cases_of_record(settings, kept[number // chunks], part, variant, chunk=chunk)
    path = folder / ("cube.nc" if variant == "nominal" else f"cube.{variant}.nc")
    merge_outcome_files_into_cube(settings, kept, parts, path, variant)
    return path
