"""Film of a comparison of two settings, from the cubes of a small study."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from overturning.figures import illustrative
from overturning.figures.drawn_case import IllustrativeCaseWithFigures, read_illustrative_case_list
from overturning.figures.write import save_figure_files
from overturning.model.scene import load_scene
from overturning.study.cube import open_cube
from tests.figures.test_film import unpack_film_numbers
from tests.study.small_study import simulate_study_cube, sine_cycle_record, small_study


def save_only_film_strips_and_create_other_files_empty(figure: Figure, path: Path) -> None:
    """Write a figure to a file if it is a film strip; otherwise create an empty file, to save time."""
    if path.stem.endswith("-strip"):
        save_figure_files(figure, path)
    else:
        path.touch()


@pytest.fixture(scope="module")
def folder_and_differing_cases_with_figures(
    tmp_path_factory: pytest.TempPathFactory,
) -> tuple[Path, list[IllustrativeCaseWithFigures]]:
    """Draw the cases in which a study and its variant without vertical motion differ, and return folder and cases."""
    folder = tmp_path_factory.mktemp("contrast")
    level = sine_cycle_record("a")
    shaken = np.where(np.abs(level.north) > 0, 5.9, 0.0)
    settings = small_study(
        records={"use": ["a"]},
        variants={"level": {"vertical": False}},
        b_over_h=[0.2, 0.25, 0.3, 0.35, 0.4],
        primary={"statistic": "share", "against": "level"},
        asks="vertical",
    )
    record = replace(level, up=np.round(shaken, 9))
    cube, other = (simulate_study_cube(settings, [record], folder, name) for name in ("nominal", "level"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(illustrative, "save_figure_files", save_only_film_strips_and_create_other_files_empty)
        illustrative.choose_simulate_and_draw_illustrative_cases(cube, folder / "motion", folder / "cases", other)
    return folder, read_illustrative_case_list(folder / "cases")


def test_first_differing_case_falls_in_one_setting_and_stands_in_the_other(
    folder_and_differing_cases_with_figures: tuple[Path, list[IllustrativeCaseWithFigures]],
) -> None:
    folder, cases = folder_and_differing_cases_with_figures
    first = cases[0]
    assert first.variant_name_by_panel == ("nominal", "level")
    ratio = float(first.block_parameters_text.split("B/H = ")[1].split(",")[0])
    falls = []
    for name in ("cube", "cube.level"):
        with open_cube(folder / f"{name}.nc") as cube:
            falls.append(bool((np.abs(cube["overturned"].sel(b_over_h=ratio, method="nearest")) == 1).any()))
    assert sorted(falls) == [False, True]
    ends = [panel["outcomeTime"] for panel in first.film["panels"]]
    assert [end is not None for end in ends] == falls, "the film shows what the cubes hold"
    assert len(set(first.panel_headings)) == 2


def test_films_of_both_settings_have_the_same_horizontal_motion(
    folder_and_differing_cases_with_figures: tuple[Path, list[IllustrativeCaseWithFigures]],
) -> None:
    _, cases = folder_and_differing_cases_with_figures
    along, up = (
        [unpack_film_numbers(panel["traces"][row]["rows"][0]) for panel in cases[0].film["panels"]] for row in (0, 1)
    )
    assert along[0] == pytest.approx(along[1])
    assert np.abs(up[0]).max() == pytest.approx(590, rel=1e-3)
    assert not up[1].any()


def test_film_strip_of_each_differing_case_is_written(
    folder_and_differing_cases_with_figures: tuple[Path, list[IllustrativeCaseWithFigures]],
) -> None:
    folder, cases = folder_and_differing_cases_with_figures
    for case in cases:
        assert (folder / "cases" / case.film_strip_file_name).stat().st_size > 1000


def test_two_scenes_are_compared_by_the_stone_they_share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the case shown, the shaft that both scenes have falls in one of them; the reference, a base, never falls."""
    monkeypatch.setattr(illustrative, "save_figure_files", save_only_film_strips_and_create_other_files_empty)
    scene = load_scene("three-tier").model_copy(update={"reference": "upper-base"})
    settings = small_study(
        records={"use": ["a"]}, scene=scene, height=[0.27], b_over_h=[1.3, 1.4], friction=[0.4, 0.7],
        azimuth={"step": 30}, variants={"alone": {"scene": "shaft-alone"}}, asks="scene",
        primary={"statistic": "share", "against": "alone"},
    )  # fmt: skip
    cube, other = (
        simulate_study_cube(settings, [sine_cycle_record("a", peak=4.5)], tmp_path, name)
        for name in ("nominal", "alone")
    )
    illustrative.choose_simulate_and_draw_illustrative_cases(cube, tmp_path / "motion", tmp_path / "cases", other)
    first = read_illustrative_case_list(tmp_path / "cases")[0]
    assert first.variant_name_by_panel == ("nominal", "alone")
    assert ["fall" in outcome for outcome in first.panel_outcomes] == [False, True]
