"""A sweep in chunks: every cell in one chunk, and the cube's bytes the same for any number of them."""

from pathlib import Path

import numpy as np
import pytest

from overturning.errors import ArgumentError
from overturning.study.netcdf import hdf5_chunk_shape
from overturning.study.parts import SweepChunk, grid_of_chunk
from overturning.study.scenes import variant_grid
from tests.study.small_study import simulate_study_cube, sine_cycle_record, small_study

ENSEMBLE_IN_ALL_CELLS = {"ensemble": {"members": 16, "where": "everywhere"}}
PLANAR_STUDY = ENSEMBLE_IN_ALL_CELLS | {
    "azimuth": {"step": 45, "also": [32]},
    "b_over_h": [0.2, 0.3],
    "friction": [0.33, 1.0],
}
STUDY_IN_3D = ENSEMBLE_IN_ALL_CELLS | {
    "body": {"plan": "rectangle", "aspect": [1.0, 1.5]},
    "orientation": {"step": 30},
    "b_over_h": [0.2, 0.3],
    "friction": [0.6],
    "azimuth": {},
}


@pytest.mark.parametrize("keys", [PLANAR_STUDY, STUDY_IN_3D], ids=["planes", "space"])
def test_bytes_of_the_cube_do_not_depend_on_the_number_of_sweep_chunks(keys: dict[str, object], tmp_path: Path) -> None:
    settings, records = small_study(**keys), [sine_cycle_record("a", 4.0), sine_cycle_record("b")]
    whole, *others = (
        simulate_study_cube(settings, records, tmp_path / str(chunks), chunks=chunks).read_bytes()
        for chunks in (1, 2, 7)  # more than there are groups of directions
    )
    assert others == [whole, whole]


@pytest.mark.parametrize("keys", [PLANAR_STUDY, STUDY_IN_3D], ids=["planes", "space"])
@pytest.mark.parametrize("chunks", [1, 3, 50])
def test_every_cell_of_a_grid_is_in_exactly_one_sweep_chunk(keys: dict[str, object], chunks: int) -> None:
    settings = small_study(**keys)
    grid = variant_grid(settings)
    pieces = [grid_of_chunk(settings, grid, SweepChunk(number, chunks)) for number in range(1, chunks + 1)]
    directions = np.concatenate([piece.direction_values_deg for piece in pieces])
    np.testing.assert_array_equal(np.sort(directions), grid.direction_values_deg)
    for piece in pieces:
        assert [piece[name].tolist() for name in grid.dimension_names[1:]] == [
            grid[name].tolist() for name in grid.dimension_names[1:]
        ]


def test_opposite_azimuths_share_a_sweep_chunk() -> None:
    settings = small_study(**PLANAR_STUDY | {"azimuth": {"step": 10}})
    sizes = []
    for number in range(1, 6):
        azimuth = grid_of_chunk(settings, variant_grid(settings), SweepChunk(number, 5))["azimuth"]
        assert set((azimuth + 180) % 360) == set(azimuth)
        sizes.append(azimuth.size)
    assert sorted(sizes) == [6, 6, 8, 8, 8], "eighteen such pairs, shared out as evenly as they can be"


@pytest.mark.parametrize("text", ["", "3", "0-of-2", "3-of-2", "1-of-0", "a-of-b"])
def test_an_invalid_chunk_number_such_as_3_of_2_is_refused(text: str) -> None:
    with pytest.raises(ArgumentError, match=r"chunk: .*; write a number and that of all chunks, 3-of-8"):
        SweepChunk.parse(text)


@pytest.mark.parametrize(
    ("grid", "chunk"),
    [
        ((72, 1, 10, 2), (72, 1, 10, 2)),  # 1,440 values: one chunk
        ((36_000, 1, 1000, 1), (1048, 1, 1000, 1)),  # 2²⁰ // 1000 directions
        ((10, 2000, 1000), (1, 2000, 1000)),  # one direction has more than 2²⁰ values
        ((3, 0, 5), (3, 0, 5)),
    ],
)
def test_an_hdf5_chunk_holds_all_cells_of_one_or_more_directions(grid: tuple[int, ...], chunk: tuple[int, ...]) -> None:
    assert hdf5_chunk_shape(grid) == chunk
