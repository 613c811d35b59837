"""Statistics of a large cube hold a part of it at a time: a record more enlarges them by a share of it."""

import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from overturning.figures.rose import fall_roses_by_group_figure
from overturning.figures.scene import fall_roses_by_element_figure
from overturning.figures.style import use_package_matplotlib_settings
from overturning.findings.causes import logistic_fit_findings, skill_of_published_criteria
from overturning.findings.direction import fall_alignments_with_references, planar_model_agreement
from overturning.findings.exactness import ensemble_findings, final_twist_findings
from overturning.findings.opening import open_study_results
from overturning.findings.results import StudyResults
from overturning.settings import StonePopulation
from overturning.statistics.elements import count_falls_of_each_and_any_element, count_falls_of_two_stones
from overturning.statistics.illustrative import find_best_case_for_each_behaviour
from overturning.study import cube as cube_module
from overturning.study.cube import open_cube
from overturning.study.intensity import write_intensity_measures
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant_names
from overturning.surveys.population import population_outcome_rates_by_record
from verification.scale.made import synthetic_records, synthetic_study, write_synthetic_cube

pytestmark = pytest.mark.long

BLOCK_GRID: dict[str, Any] = {
    "height": {"start": 0.5, "stop": 0.9, "step": 0.1},
    "b_over_h": {"start": 0.05, "stop": 0.6, "step": 0.05},
    "friction": {"start": 0.3, "stop": 1.2, "step": 0.1},
}
SETTINGS_BY_STUDY_KIND: dict[str, dict[str, Any]] = {
    "planes": BLOCK_GRID | {"azimuth": {"step": 5}},
    "space": BLOCK_GRID | {"body": {"aspect": [1, 2]}, "orientation": {"step": 3}, "ensemble": {"members": 4}},
    "scene": BLOCK_GRID
    | {"scene": "three-tier", "variants": {"monolith": {"scene": "monolith"}}}
    | {"azimuth": {"step": 10}, "ensemble": {"members": 4}},
}
SMALLER_RECORD_COUNT, LARGER_RECORD_COUNT = 1, 3
MAX_MEMORY_GROWTH_OVER_ADDED_DATA_SIZE = (
    1 / 3
)  # of the bytes of the records that are more, as the cube's types have them

Statistic = Callable[[StudyResults], object]


def element_and_variant_statistics(results: StudyResults) -> list[object]:
    """Compute the statistics of a report that concern the elements and variants of a scene."""
    stones = {name: results.cube_of_default_element(name) for name in results.cubes_by_variant}
    one, other = stones.values()
    said = [
        count_falls_of_two_stones(one, other),
        ensemble_findings(results),
        fall_roses_by_element_figure(stones),
    ]
    return said + [count_falls_of_each_and_any_element(cube) for cube in results.cubes_by_variant.values()]


STATISTICS_BY_STUDY_KIND: dict[str, dict[str, Statistic]] = {
    "planes": {
        "axes of earthquakes": lambda results: results.fall_axis_to_fault_normal_summary_by_record_group,
        "share that falls": lambda results: results.share_overturned,
        "statuses": lambda results: results.case_and_missing_outcome_counts_by_status,
        "rose": lambda results: fall_roses_by_group_figure(results.reference_element_cube),
        "logistic fit": logistic_fit_findings,
        "criteria": skill_of_published_criteria,
    },
    "space": {
        "roses": lambda results: fall_roses_by_group_figure(results.reference_element_cube),
        "references": fall_alignments_with_references,
        "planar model": planar_model_agreement,
        "twist": final_twist_findings,
        "ensemble": ensemble_findings,
        "population": lambda results: population_outcome_rates_by_record(
            results.reference_element_cube, StonePopulation()
        ),
        "illustrative cases": lambda results: find_best_case_for_each_behaviour(results.reference_element_cube),
    },
    "scene": {"elements and variants": element_and_variant_statistics},
}


@pytest.fixture(scope="module")
def result_folders_with_few_and_many_records(
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[dict[str, list[Path]]]:
    """Folders of study results with few and with many records, by kind of study."""
    made: dict[str, list[Path]] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(Path(__file__).parents[2])  # scenes are named from the project's folder
        for kind, grid in SETTINGS_BY_STUDY_KIND.items():
            made[kind] = [
                tmp_path_factory.mktemp(f"{kind}-{records}") for records in (SMALLER_RECORD_COUNT, LARGER_RECORD_COUNT)
            ]
            for records, folder in zip((SMALLER_RECORD_COUNT, LARGER_RECORD_COUNT), made[kind], strict=True):
                study = synthetic_study(records, grid)
                for variant in variant_names(study):
                    name = "cube.nc" if variant == NAME_OF_STUDY_ITSELF_AMONG_VARIANTS else f"cube.{variant}.nc"
                    write_synthetic_cube(study, folder / name, distinct_record_count=1, variant=variant)
                write_intensity_measures(study, list(synthetic_records(study)), folder / "intensity.nc")
        yield made


def peak_memory_bytes(statistic: Statistic, folder: Path) -> int:
    """Return the peak memory, bytes, that NumPy and Python allocate to compute a statistic of stored results."""
    with open_study_results(folder) as results, use_package_matplotlib_settings():
        tracemalloc.start()
        statistic(results)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, name) for kind, names in STATISTICS_BY_STUDY_KIND.items() for name in names]
)
def test_memory_of_report_statistics_grows_little_with_each_record(
    kind: str,
    name: str,
    result_folders_with_few_and_many_records: dict[str, list[Path]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cube_module, "MAX_CUBE_VALUES_IN_MEMORY", 0)  # these are as small as tests must be
    statistic, few_many = STATISTICS_BY_STUDY_KIND[kind][name], result_folders_with_few_and_many_records[kind]
    with open_study_results(few_many[0]) as results, use_package_matplotlib_settings():
        statistic(results)  # what is imported and kept on the first call
    few, many = (peak_memory_bytes(statistic, folder) for folder in few_many)
    with open_cube(few_many[0] / "cube.nc", element=None) as cube:
        more = cube.nbytes / SMALLER_RECORD_COUNT * (LARGER_RECORD_COUNT - SMALLER_RECORD_COUNT)
    assert (many - few) / more < MAX_MEMORY_GROWTH_OVER_ADDED_DATA_SIZE, (
        f"{(many - few) / more:.2f} of the records' own size"
    )
