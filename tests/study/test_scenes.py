"""Scenes in a study: defaults, refusals, and a cube with elements from sweep to report tables."""

import dataclasses
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from overturning import plot
from overturning.dem.run import simulate_cases
from overturning.errors import ArgumentError, ConfigError, ResultError
from overturning.figures.explore import explorer_page_data
from overturning.findings.contrast import compare_study_with_variants, element_fall_findings
from overturning.findings.results import StudyResults
from overturning.labels import variant_label_in_list_if_not_nominal
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import gravestone, load_scene
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.statistics.elements import (
    compare_falls_of_two_stones_over_earthquakes,
    count_falls_of_each_and_any_element,
    count_falls_of_two_stones,
)
from overturning.study.cube import open_cube
from overturning.study.ensemble_members import draw_parameter_changes_of_members
from overturning.study.load import study_from_content
from overturning.study.recheck import recompute_and_compare_random_cases
from overturning.study.scenes import variant_scene
from overturning.study.schema import Study
from tests.expect import run_overturning_and_return_printed_text
from tests.study.small_study import simulate_study_cube, sine_cycle_record

ROOT = Path(__file__).parents[2]
POLAR_MAP_AND_BOUNDARY_TITLES = (
    "µ = 0.9, H = 0.636 m; radius: slenderness B/H",
    "largest B/H that falls, by azimuth of the motion",
)


@pytest.fixture(autouse=True)
def _change_to_project_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run each test in the folder of the project, to which the names of scene files refer."""
    monkeypatch.chdir(ROOT)  # scenes are named from the project's folder


def _three_tier_study(**keys: Any) -> Study:
    """Return a study of the three-tier grave."""
    return study_from_content(
        {"name": "stack", "records": {"use": ["pulse"]}, "scene": "three-tier", **keys}, "study.yaml"
    )


def _record_of_two_sine_cycles() -> Record:
    """Return a record of two sine cycles with a peak of 9 m/s²."""
    return sine_cycle_record("pulse", 9.0, 0.2, begin=0.0, cycles=2)


def test_a_study_of_a_scene_has_the_sizes_of_the_scene_by_default() -> None:
    study = _three_tier_study()
    assert study.height == (0.636,)
    assert study.b_over_h == pytest.approx((0.242 / 0.636,), abs=1e-9)
    assert study.ensemble.members == 0
    assert Study.model_validate(study.model_dump(mode="json")) == study


def test_a_study_without_a_scene_uses_the_shipped_gravestone_scene() -> None:
    study = study_from_content(
        {
            "name": "plain", "records": {"use": ["pulse"]}, "density": 2000, "contact": {"damping_ratio": 0.5},
            "variants": {"soft": {"contact": {"stiffness": 1e7}}},
        },
        "study.yaml",
    )  # fmt: skip
    assert study.scene == gravestone() == load_scene("gravestone")
    assert (study.height, study.b_over_h, study.ensemble.members) == ((0.6,), (0.2, 0.3, 0.4), 24)
    scene, soft = variant_scene(study), variant_scene(study, "soft")
    assert scene.can_use_single_block_kernel
    assert scene.materials["stone"].density == soft.materials["stone"].density == 2000
    assert scene.contact_law(*scene.elements).contact_without_friction == Contact(damping_ratio=0.5)
    assert soft.contact_law(*soft.elements).contact_without_friction == Contact(stiffness=1e7, damping_ratio=0.5)
    again = Study.model_validate(study.model_dump(mode="json"))
    assert again == study
    assert variant_scene(again, "soft") == soft
    with pytest.raises(ConfigError, match="no variant 'hard'; known: nominal, soft"):
        variant_scene(study, "hard")


def test_the_cube_of_a_scene_has_outcomes_of_each_element(tmp_path: Path) -> None:
    study = _three_tier_study(
        variants={"monolith": {"scene": "monolith"}, "alone": {"scene": "shaft-alone"}},
        azimuth={"start": 0, "stop": 360, "step": 60}, b_over_h=[0.2, 0.25], friction=[0.5, 0.9],
    )  # fmt: skip
    paths = {
        name: simulate_study_cube(study, [_record_of_two_sine_cycles()], tmp_path, name)
        for name in ("nominal", *study.variants)
    }
    nominal = paths["nominal"]
    with open_cube(nominal, element=None) as cube:
        assert cube["overturned"].dims == ("record", "azimuth", "height", "b_over_h", "friction", "element")
        assert cube["status"].dims == ("record", "azimuth", "height", "b_over_h", "friction")
        rows = {row.element_name: row for row in count_falls_of_each_and_any_element(cube)}
        assert list(rows) == ["lower-base", "upper-base", "shaft", "any element"]
        np.testing.assert_allclose(cube["critical_angle"].sel(element="shaft"), np.degrees(np.arctan([0.2, 0.25])))
        assert rows["shaft"].fall_count == int((cube["overturned"].sel(element="shaft") != 0).sum()) > 0
        assert (
            rows["shaft"].count_of_falls_with_no_earlier_fall
            == rows["shaft"].fall_count
            == rows["any element"].fall_count
        )
        assert rows["lower-base"].fall_count == 0
        assert explorer_page_data(cube)["title"] == "stack, H and B/H of the shaft"
    with open_cube(nominal) as shaft, open_cube(paths["alone"]) as alone:
        assert variant_label_in_list_if_not_nominal(alone) == ["variant alone"]
        assert str(shaft["element"].item()) == "shaft"
        assert shaft["overturned"].dims == alone["overturned"].dims
        found = count_falls_of_two_stones(shaft, alone)
        assert found["cases"].item() == 24
        sides, others = shaft["overturned"].to_numpy(), alone["overturned"].to_numpy()
        assert found["both"].item() == np.count_nonzero((sides != 0) & (others != 0)) > 0
        assert found["same_way"].item() == np.count_nonzero((sides == others) & (sides != 0))
        # Turned by 180° a symmetric scene falls the other way.
        sides = shaft["overturned"].to_numpy()
        np.testing.assert_array_equal(sides[:, 3:], -sides[:, :3])
    # A map of the base stood under the name of the shaft, whose B/H it goes by.
    for element, whose in (("shaft", ": shaft"), ("upper-base", ": upper-base, by H and B/H of the shaft")):
        with open_cube(nominal, element=element) as one:
            falls = bool((one["overturned"] != 0).any())
            titles = [
                draw(one).get_suptitle().replace("\n", " ")
                for draw in (plot.fall_map, plot.overturning_boundary)[: 1 + falls]
            ]
            if not falls:
                with pytest.raises(ArgumentError, match="boundary: nothing to draw: none of the 24 cases"):
                    plot.overturning_boundary(one)
        assert falls is (element == "shaft")
        assert titles == [f"S, E three-tier{whose} {axis}" for axis in POLAR_MAP_AND_BOUNDARY_TITLES[: 1 + falls]]
    # The limit of West, a ≥ g B/H, lay at 0.2 g for a monolith that does not rock below 0.53 g.
    for path, element, why in (("nominal", "upper-base", "not of the upper"), ("monolith", None, "a B/H of 0.463")):
        with open_cube(paths[path], element=element) as one, pytest.raises(ArgumentError, match=f"plane: .*{why}"):
            plot.outcomes_by_pga_and_pgv_ratio(one)
    for element in (None, "shaft"):
        with open_cube(nominal, chunks={"record": 1}, element=element) as lazy:
            assert lazy["overturned"].chunks is not None
            assert lazy["event"].chunks is None, "what describes a record is read at once"
            assert str(nominal) in {file.path for file in psutil.Process().open_files()}
        assert str(nominal) not in {file.path for file in psutil.Process().open_files()}
    with open_cube(paths["monolith"]) as monolith:
        # Its own shape is not that of the swept shaft, so its outcome is the same for each B/H.
        values = monolith["peak_rotation"].to_numpy()
        np.testing.assert_array_equal(values[:, :, :, 0], values[:, :, :, 1])
        # Its centroid lies over the middle of a base 0.545 m wide, and its α is none of the shaft's.
        x, y = np.array(load_scene("monolith").elements[1].vertices).T
        across = x * np.roll(y, -1) - np.roll(x, -1) * y
        centre = ((y + np.roll(y, -1)) * across).sum() / (3 * across.sum())
        np.testing.assert_allclose(monolith["critical_angle"], np.degrees(np.arctan(0.2725 / centre)))
        assert "the monolith has 1.85 times that height and a B/H of 0.463" in monolith["b_over_h"].attrs["comment"]
        assert variant_label_in_list_if_not_nominal(monolith)[0] == (
            "variant monolith (H and B/H are those of the study's shaft; the monolith has 1.85 times that height and "
            "a B/H of 0.463 whatever the shaft has)"
        )
        exported = run_overturning_and_return_printed_text("cube", "export", paths["monolith"], tmp_path / "cases.csv")
        assert f"cases.csv: 24 cases, {variant_label_in_list_if_not_nominal(monolith)[0]}\n" in exported
    cubes = {name: open_cube(path, element=None) for name, path in paths.items()}
    results = StudyResults(
        study=study, reference_element_cube=cubes["nominal"], cubes_by_variant=cubes,
        intensity_measures=cubes["nominal"], convergence=None, survey_comparisons=(),
    )  # fmt: skip
    elements, contrasts = element_fall_findings(results), compare_study_with_variants(results)
    # A study of the upper base is compared with the variant that has a shaft by the shaft, which is in both scenes.
    scene = study.scene.model_copy(update={"reference": "upper-base"})
    of_base = compare_study_with_variants(replace(results, study=study.model_copy(update={"scene": scene})))
    compared = [
        [(one.compared_element_in_study, one.compared_element_in_variant) for one in each]
        for each in (contrasts, of_base)
    ]
    assert compared == [[("shaft", "monolith"), ("shaft", "shaft")], [("upper-base", "monolith"), ("shaft", "shaft")]]
    assert of_base[1] == contrasts[1]
    for cube in cubes.values():
        cube.close()
    names = ["lower-base", "upper-base", "shaft", "any element", "monolith", "shaft"]
    assert [one.element for one in elements] == names
    assert len(contrasts) == 2
    assert contrasts[0].share_overturned_only_in_study.value == pytest.approx(rows["shaft"].fall_count / 24)
    with pytest.raises(ResultError, match="no element 'roof'; known: lower-base"):
        open_cube(nominal, element="roof")


def test_comparison_of_two_stones_counts_falls_and_their_order() -> None:
    import xarray as xr

    def cube_of_fall_times(times: list[float], **more: list[float]) -> xr.Dataset:
        rows = {"overturning_time": times, **more}
        return xr.Dataset({name: (("record", "azimuth"), np.reshape(values, (2, 3))) for name, values in rows.items()})

    nan = float("nan")
    this = cube_of_fall_times([2.0, 3.0, nan, 1.0, nan, 4.0], overturned=[1, -1, 0, 1, nan, 1])
    other = cube_of_fall_times([2.5, 2.0, nan, nan, 1.0, 3.0], overturned=[1, 1, 0, 0, 1, 1])
    found = count_falls_of_two_stones(this, other)
    names = ("cases", "both", "only_this", "only_other", "same_way", "earlier")
    assert found["same_time"].to_numpy().tolist() == [0, 0]
    assert [found[name].to_numpy().tolist() for name in names] == [[3, 2], [2, 1], [0, 1], [0, 0], [1, 1], [1, 0]]
    both = compare_falls_of_two_stones_over_earthquakes(found, np.array(["one", "other"]))
    assert (both.share_of_cases_both_fall.mean, both.share_of_cases_only_this_falls.mean) == (
        pytest.approx((2 / 3 + 1 / 2) / 2),
        1 / 4,
    )
    assert (
        both.same_direction_share_if_both_fall.mean,
        both.this_earlier_share_if_both_fall.mean,
        both.this_earlier_share_if_both_fall.earthquake_count,
    ) == (pytest.approx(3 / 4), 1 / 4, 2)
    # Of three and two cases with a fall in either, the first stone falls first or alone in 1 of 2 and 1 of 2.
    assert both.this_first_or_alone_share_if_any_falls.mean == pytest.approx((1 / 2 + 1 / 2) / 2)
    # Falls at the same time are first in neither: half of them counts here, half there.
    ties = count_falls_of_two_stones(this, this), count_falls_of_two_stones(other, other)
    assert [
        compare_falls_of_two_stones_over_earthquakes(
            one, np.array(["one", "other"])
        ).this_first_or_alone_share_if_any_falls.mean
        for one in ties
    ] == [0.5, 0.5]
    late = cube_of_fall_times([2.0, 4.0, 1.0, 1.0, nan, 3.0], overturned=[1, 1, 1, 0, 1, 1])
    firsts = [
        compare_falls_of_two_stones_over_earthquakes(
            count_falls_of_two_stones(*pair), np.array(["one", "other"])
        ).this_first_or_alone_share_if_any_falls.mean
        for pair in ((this, late), (late, this))
    ]  # here: together, first, not at all; alone, unknown, later
    assert firsts == [pytest.approx(((0.5 + 1 + 0) / 3 + (1 + 0) / 2) / 2), pytest.approx(1 - firsts[0])]
    # In space a fall has an azimuth of its own.
    towards = {"overturned": [1, 1, 0, 1, 1, 1], "fall_azimuth": [350.0, 10, nan, 90, 90, 0]}
    across = {"overturned": [1, 1, 0, 0, 1, 1], "fall_azimuth": [30.0, 60, nan, nan, 46, 200]}
    times = [1.0] * 6
    counts = count_falls_of_two_stones(cube_of_fall_times(times, **towards), cube_of_fall_times(times, **across))
    assert counts["same_way"].to_numpy().tolist() == [
        1,
        1,
    ]


def test_variant_without_vertical_keeps_contact_settings(tmp_path: Path) -> None:
    """A variant without vertical motion equals a study without vertical motion, and keeps the contact settings.

    With the contact settings of the study a block of B/H 0.35 falls, with the default ones it stands.
    """
    record = dataclasses.replace(_record_of_two_sine_cycles(), up=0.8 * _record_of_two_sine_cycles().north)
    grid = {"azimuth": {"step": 60}, "b_over_h": [0.2, 0.35], "friction": [0.9], "ensemble": {"members": 0}}
    grid["contact"] = {"damping_ratio": 0.2}
    study = study_from_content(
        {"name": "plain", "records": {"use": ["pulse"]}, **grid, "variants": {"flat": {"vertical": False}}}, "a.yaml"
    )
    without = study.model_copy(update={"simulation": study.simulation.model_copy(update={"vertical": False})})
    cubes = [
        open_cube(simulate_study_cube(one, [record], tmp_path / str(index), variant))
        for index, (one, variant) in enumerate(((study, "nominal"), (study, "flat"), (without, "nominal")))
    ]
    for name in ("overturned", "peak_rotation"):
        np.testing.assert_array_equal(cubes[1][name], cubes[2][name])
        assert not np.array_equal(cubes[0][name], cubes[1][name])
    assert [cube["vertical"].item() for cube in cubes] == [1, 0, 0]


@pytest.mark.parametrize("variant", ["nominal", "monolith", "gravestone"])
def test_scene_ensemble_probabilities_equal_fall_shares_of_members(tmp_path: Path, variant: str) -> None:
    """Ensemble probabilities of an element equal the fall shares of members simulated by themselves.

    The members have changed amplitude, B/H, friction, damping and azimuth.
    """
    study = _three_tier_study(
        azimuth={"start": 0, "stop": 360, "step": 90}, b_over_h=[0.3], friction=[0.8],
        ensemble={"members": 8, "where": "everywhere", "amplitude": 0.2},
        variants={"monolith": {"scene": "monolith"}, "gravestone": {"scene": "gravestone"}},
    )  # fmt: skip
    record, members = _record_of_two_sine_cycles(), draw_parameter_changes_of_members(study.ensemble)
    path = simulate_study_cube(study, [record], tmp_path, variant)
    with open_cube(path, element=None) as cube:
        towards, away = (cube[f"probability_{name}"].to_numpy()[0] for name in ("towards", "away"))
        several = "element" in cube["probability_towards"].dims
        assert (cube["members"] == 8).all()
    assert several == (variant == "nominal")
    scene = variant_scene(study, variant)
    height, own = reference_element_height_and_b_over_h(scene)
    own = 0.3 if variant == "nominal" else own
    cases = Cases(
        members.azimuth_change_deg,
        height,
        own * members.b_over_h_factor,
        0.8 * members.friction_factor,
        members.amplitude_factor,
        members.damping_factor,
    )
    motion = Motion(record.north, record.east, sampling_interval=0.01)
    flags = simulate_cases(scene, motion, cases).overturned
    flags = flags[:, -1] if several else flags
    last = (..., -1) if several else ...
    assert towards[last].ravel()[0] == pytest.approx((flags == 1).mean())
    assert away[last].ravel()[0] == pytest.approx((flags == -1).mean())
    # The opposite azimuth is the mirror.
    np.testing.assert_array_equal(towards[last].ravel()[2], away[last].ravel()[0])
    assert (flags != 0).any()


@pytest.mark.parametrize("variant", ["nominal", "wall"])
def test_a_recheck_reproduces_the_cube_of_a_scene_cell_by_cell(tmp_path: Path, variant: str) -> None:
    """The recomputed cells include opposite azimuths, all elements, a variant with another B/H, and an ensemble."""
    study = _three_tier_study(
        azimuth={"start": 0, "stop": 360, "step": 180}, b_over_h=[0.25, 0.3, 0.35], friction=[0.8],
        ensemble={"members": 2, "where": "everywhere"}, variants={"wall": {"scene": "against-a-wall"}},
    )  # fmt: skip
    found = recompute_and_compare_random_cases(
        simulate_study_cube(study, [_record_of_two_sine_cycles()], tmp_path, variant), max_random_case_count=6
    )
    assert found.difference_messages == []
    assert found.recomputed_cell_count == found.cell_count_with_recomputed_ensemble == 6
