"""A sweep in chunks: every cell in one chunk, and the cube's bytes the same for any number of them."""

from pathlib import Path

import numpy as np
import pytest

from overturning.errors import ArgumentError
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.study.gather import gather
from overturning.study.grid import grid_of
from overturning.study.load import check_study
from overturning.study.parts import Chunk, parts_of, piece_of
from overturning.study.schema import Study
from overturning.study.sweep import sweep_record

PLANES = {"azimuth": {"step": 45, "also": [32]}, "b_over_h": [0.2, 0.3], "friction": [0.33, 1.0]}
SPACE = {
    "body": {"plan": "rectangle", "aspect": [1.0, 1.5]},
    "orientation": {"step": 30},
    "b_over_h": [0.2, 0.3],
    "friction": [0.6],
}


def study(keys: dict[str, object]) -> Study:
    ensemble = {"members": 16, "where": "everywhere"}
    base = {"name": "small", "records": {"use": ["a", "b"]}, "height": [0.6], "ensemble": ensemble}
    return check_study(base | keys, "small")


def record(name: str) -> Record:
    motion = Motion.sine(amplitude=4.0 if name == "a" else 6.0, period=0.8, azimuth_deg=70)
    return Record(name, motion.north, motion.east, None, motion.sampling_interval)


def cube_in_chunks(settings: Study, chunks: int, folder: Path) -> bytes:
    records = [record(name) for name in settings.records.use]
    parts = parts_of(folder, settings.records.use, chunks)
    for number, part in enumerate(parts):
        sweep_record(settings, records[number // chunks], part, chunk=Chunk(number % chunks + 1, chunks))
    gather(settings, records, parts, folder / "cube.nc")
    return (folder / "cube.nc").read_bytes()


@pytest.mark.parametrize("keys", [PLANES, SPACE], ids=["planes", "space"])
def test_bytes_of_the_cube_are_the_same_for_any_number_of_chunks(keys: dict[str, object], tmp_path: Path) -> None:
    settings = study(keys)
    whole = cube_in_chunks(settings, 1, tmp_path / "1")
    for chunks in (2, 7):  # more than there are groups of directions
        assert cube_in_chunks(settings, chunks, tmp_path / str(chunks)) == whole


@pytest.mark.parametrize("keys", [PLANES, SPACE], ids=["planes", "space"])
@pytest.mark.parametrize("chunks", [1, 3, 50])
def test_every_cell_is_in_one_chunk(keys: dict[str, object], chunks: int) -> None:
    settings = study(keys)
    grid = grid_of(settings)
    pieces = [piece_of(settings, grid, Chunk(number, chunks)) for number in range(1, chunks + 1)]
    directions = np.concatenate([getattr(piece, grid.names[0]) for piece in pieces])
    np.testing.assert_array_equal(np.sort(directions), getattr(grid, grid.names[0]))
    for piece in pieces:
        assert [getattr(piece, name).tolist() for name in grid.names[1:]] == [
            getattr(grid, name).tolist() for name in grid.names[1:]
        ]


def test_azimuths_that_mirror_each_other_share_a_chunk() -> None:
    settings = study({**PLANES, "azimuth": {"step": 10}})
    sizes = []
    for number in range(1, 6):
        azimuth = piece_of(settings, grid_of(settings), Chunk(number, 5)).azimuth
        assert set((azimuth + 180) % 360) == set(azimuth)
        sizes.append(azimuth.size)
    assert sorted(sizes) == [6, 6, 8, 8, 8], "eighteen such pairs, shared out as evenly as they can be"


@pytest.mark.parametrize("text", ["", "3", "0-of-2", "3-of-2", "1-of-0", "a-of-b"])
def test_a_text_that_names_no_chunk_is_refused(text: str) -> None:
    with pytest.raises(ArgumentError, match=r"chunk: .*; write a number and that of all chunks, 3-of-8"):
        Chunk.parse(text)
