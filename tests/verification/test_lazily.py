"""Statistics of a cube in memory that a record more hardly enlarges: those of 10⁸ cells stay within 2 GB."""

import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from overturning.figures.intensity_plane import intensity_plane_figure
from overturning.figures.rose import rose_figure
from overturning.figures.space import earthquake_roses_figure, space_rose_figure
from overturning.figures.style import style
from overturning.report.build import SECTIONS
from overturning.report.results import Results, open_results
from overturning.statistics.logistic import overturning_fit
from overturning.statistics.space import followed_by_slenderness
from overturning.statistics.telling import telling_cases
from overturning.statistics.telling_in_space import telling_in_space
from overturning.study.cube import open_cube
from overturning.study.intensity import write_intensity
from overturning.study.scenes import NOMINAL, variant_names
from verification.scale.made import made_records, made_study, write_made_cube

BLOCKS: dict[str, Any] = {
    "height": {"start": 0.5, "stop": 0.9, "step": 0.1},
    "b_over_h": {"start": 0.05, "stop": 0.6, "step": 0.05},
    "friction": {"start": 0.3, "stop": 1.2, "step": 0.1},
}
KINDS: dict[str, dict[str, Any]] = {
    "plane": BLOCKS | {"azimuth": {"step": 5}, "population": {}},
    "space": BLOCKS
    | {"body": {"aspect": [1, 2]}, "orientation": {"step": 3}, "azimuth": {"step": 15}, "population": {}}
    | {"ensemble": {"members": 4}},
    "scene": BLOCKS
    | {"scene": "three-tier", "azimuth": {"step": 5}, "ensemble": {"members": 4}}
    | {"variants": {"monolith": {"scene": "monolith"}}},
}
FEW, MANY = 1, 4
MOST = 15.0  # bytes per cell, 1.5 GB of 10⁸ cells

Statistic = Callable[[Results], object]

IN_REPORT: dict[str, Statistic] = {section.__name__: section for section in SECTIONS}
IN_FIGURES: dict[str, dict[str, Statistic]] = {
    "plane": {
        "rose": lambda results: rose_figure(results.cube),
        "plane": lambda results: intensity_plane_figure(
            results.cube, results.intensity, overturning_fit(results.cube, results.intensity), 1.0
        ),
        "telling cases": lambda results: telling_cases(results.cube),
    },
    "space": {
        "roses": lambda results: space_rose_figure(results.cube),
        "roses of earthquakes": lambda results: earthquake_roses_figure(results.cube),
        "follow": lambda results: followed_by_slenderness(results.cube, results.intensity),
        "telling cases": lambda results: telling_in_space(results.cube),
    },
    "scene": {},
}
CASES = [(kind, name) for kind in KINDS for name in (*IN_FIGURES[kind], *IN_REPORT)]


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, list[Path]]]:
    """Folders of results by kind, of few records and of many."""
    made: dict[str, list[Path]] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(Path(__file__).parents[2])  # scenes are named from the project's folder
        for kind, grid in KINDS.items():
            made[kind] = [tmp_path_factory.mktemp(f"{kind}-{records}") for records in (FEW, MANY)]
            for records, folder in zip((FEW, MANY), made[kind], strict=True):
                study = made_study(records, grid)
                for variant in variant_names(study):
                    name = "cube.nc" if variant == NOMINAL else f"cube.{variant}.nc"
                    write_made_cube(study, folder / name, different=1, variant=variant)
                write_intensity(study, list(made_records(study)), folder / "intensity.nc")
                (folder / "figures" / "telling").mkdir(parents=True)
                (folder / "figures" / "telling" / "telling.json").write_text("[]", "utf-8")
        yield made


def peak(statistic: Statistic, folder: Path) -> int:
    """Largest memory of a statistic, bytes, that NumPy and Python allocate."""
    with open_results(folder) as results, style():
        tracemalloc.start()
        statistic(results)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_a_record_more_takes_little_memory(kind: str, name: str, folders: dict[str, list[Path]]) -> None:
    statistic = IN_FIGURES[kind].get(name) or IN_REPORT[name]
    import time

    t = time.time()
    peak(statistic, folders[kind][0])
    print("took", time.time() - t)  # what is imported and kept on the first call
    few, many = (peak(statistic, folder) for folder in folders[kind])
    with open_cube(folders[kind][0] / "cube.nc", element=None) as cube:
        cells = cube["overturned"].size / FEW * (MANY - FEW)
    print(f"{kind} {name}: {(many - few) / cells:.1f} {few / cells * 3:.1f}")
    assert (many - few) / cells < MOST, f"{(many - few) / cells:.1f} bytes per cell"
