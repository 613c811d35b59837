"""Statistics of a cube in memory that a record more hardly enlarges: those of 10⁸ cells stay within 2 GB."""

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from overturning.figures.rose import rose_figure
from overturning.figures.style import style
from overturning.report.results import Results
from overturning.statistics.criteria import criteria_scores
from overturning.statistics.earthquakes import axes_by_group, summarise_axes
from overturning.statistics.falls import overturns
from overturning.statistics.logistic import overturning_fit
from overturning.study.cube import open_cube, study_of
from verification.scale.made import made_study, write_made_cube

GRID = {
    "azimuth": {"step": 5},
    "height": {"start": 0.5, "stop": 0.9, "step": 0.1},
    "b_over_h": {"start": 0.05, "stop": 0.6, "step": 0.05},
    "friction": {"start": 0.3, "stop": 1.2, "step": 0.1},
}
FEW, MANY = 1, 4
MOST = 15.0  # bytes per cell, 1.5 GB of 10⁸ cells


def results_of(cube: xr.Dataset, folder: Path) -> Results:
    return Results(study_of(cube), cube, {"nominal": cube}, xr.Dataset(), folder, folder, [], None, ())


STATISTICS: dict[str, Callable[[xr.Dataset, xr.Dataset, Path], object]] = {
    "axes of earthquakes": lambda cube, *_: [summarise_axes(each) for each in axes_by_group(cube).values()],
    "share that falls": lambda cube, *_: overturns(cube).mean().compute(),
    "statuses": lambda cube, _, folder: results_of(cube, folder).statuses,
    "rose": lambda cube, *_: rose_figure(cube),
    "logistic fit": lambda cube, intensity, _: overturning_fit(cube, intensity),
    "criteria": lambda cube, intensity, _: criteria_scores(cube, intensity),
}


@pytest.fixture(scope="module")
def cubes(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    paths = [tmp_path_factory.mktemp("made") / f"{records}.nc" for records in (FEW, MANY)]
    for records, path in zip((FEW, MANY), paths, strict=True):
        write_made_cube(made_study(records, GRID), path, different=1)
    return paths


def peak(statistic: Callable[[xr.Dataset, xr.Dataset, Path], object], path: Path) -> int:
    """Largest memory of a statistic, bytes, that NumPy and Python allocate."""
    with open_cube(path, chunks={"record": 1}) as cube, style():
        azimuth = cube["azimuth"].to_numpy()
        generator = np.random.default_rng(1)
        values = {name: generator.uniform(1, 9, (cube.sizes["record"], azimuth.size)) for name in ("pga", "pgv")}
        dims = ("record", "azimuth")
        intensity = xr.Dataset({name: (dims, each) for name, each in values.items()}, {"azimuth": azimuth})
        tracemalloc.start()
        statistic(cube, intensity, path.parent)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most


@pytest.mark.parametrize("name", STATISTICS)
def test_a_record_more_takes_little_memory(name: str, cubes: list[Path]) -> None:
    peak(STATISTICS[name], cubes[0])  # what is imported and kept on the first call
    few, many = (peak(STATISTICS[name], path) for path in cubes)
    with open_cube(cubes[0]) as cube:
        cells = cube["overturned"].size / FEW * (MANY - FEW)
    assert (many - few) / cells < MOST, f"{(many - few) / cells:.1f} bytes per cell"
