"""A study of a scene in 3-D: its keys, and its way through sweep, ensemble, gathering, recheck and repetition."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.dem.simulate import simulate_as_arrays
from overturning.errors import ConfigError
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.scene import parse_scene_content
from overturning.model.stack import Stack
from overturning.motion.motion import Motion
from overturning.records.store import read_record_from_motion_file
from overturning.statistics.elements import count_falls_of_each_and_any_element
from overturning.study.convergence_check import rerun_cases_with_finer_steps_and_stiffer_contacts
from overturning.study.cube import open_cube, select_element_and_amplitude, study_of_cube
from overturning.study.film_options import film_command_options_and_stone_sizes
from overturning.study.load import study_from_content, study_settings_with_file_names_for_absolute_paths
from overturning.study.recheck import recompute_and_compare_random_cases
from overturning.study.sample import read_random_case_sample
from overturning.study.schema import Study
from overturning.surveys.displacements import compare_falls_shifts_and_twists
from overturning.surveys.stones import read_survey_table
from tests.expect import expect_error, run_overturning_and_return_printed_text
from tests.study.small_study import simulate_study_cube
from tests.study.test_space_study import record_of_two_cycles

SMALL_STUDY: dict[str, Any] = {
    "name": "stack",
    "records": {"use": ["a"]},
    "scene": "three-tier",
    "orientation": {"step": 30},
    "friction": [0.4, 0.7],
    "amplitude": [1, 1.5],
    "ensemble": {"members": 4, "where": "everywhere"},
    "verification": {"at_least": 4, "cost": 50},
}
STONES = ["lower-base", "upper-base", "shaft"]


@pytest.fixture(scope="module")
def study_settings() -> Study:
    """Settings of a small study of a 3-D stack."""
    return study_from_content(SMALL_STUDY, "stack")


@pytest.fixture(scope="module")
def cube_file(study_settings: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Path of the cube of the small study."""
    return simulate_study_cube(study_settings, [record_of_two_cycles(up=True)], tmp_path_factory.mktemp("stack"))


@pytest.fixture(scope="module")
def read_motion_stored_beside_cube(cube_file: Path) -> Motion:
    """Motion of the record as the study stored it."""
    return Motion.of(read_record_from_motion_file(cube_file.parent / "motion" / "a.nc"))


@pytest.fixture(scope="module")
def loaded_cube(cube_file: Path) -> xr.Dataset:
    """The cube of the small study, for all elements and amplitudes."""
    with open_cube(cube_file, element=None, amplitude=None) as opened:
        return opened.load()


@pytest.mark.parametrize(("plan", "measured"), [(8, 10.0), ("circle", 29.0)])
def test_estimated_computing_time_of_drum_columns_is_within_twice_the_measured(
    plan: str | int, measured: float
) -> None:
    """Estimated computing times of columns of drums are within a factor of 2 of measured ones.

    `measured` is the time of a column of two polygonal or round drums and a capital, over that of one with square
    drums.
    """
    ground = {"name": "ground", "kind": "driven", "width": 40, "depth": 40, "height": 1, "at": (0, -1)}

    def computing_time_of_column_case_over_that_of_2d_block(**drum: Any) -> float:
        drums = [{"height": 0.8, "name": f"drum-{k}", "stands_on": ("ground", "drum-0")[k]} | drum for k in range(2)]
        capital = {"name": "capital", "width": 0.8, "depth": 0.8, "height": 0.3, "stands_on": "drum-1"}
        column = parse_scene_content({"name": "column", "reference": "capital", "elements": [ground, *drums, capital]})
        return Stack(column).case_computing_time_over_that_of_2d_block

    times = computing_time_of_column_case_over_that_of_2d_block(
        width=0.6, plan=plan
    ) / computing_time_of_column_case_over_that_of_2d_block(width=0.6, depth=0.6)
    assert measured / 2 <= times <= 2 * measured


def test_the_cube_of_a_stack_has_orientations_and_an_outcome_of_each_stone(
    loaded_cube: xr.Dataset, study_settings: Study
) -> None:
    sizes = {"record": 1, "amplitude": 2, "orientation": 3, "height": 1, "b_over_h": 1, "friction": 2, "element": 3}
    assert dict(loaded_cube.sizes) == sizes
    assert loaded_cube["element"].to_numpy().tolist() == STONES
    assert loaded_cube["orientation"].to_numpy().tolist() == [0, 30, 60]
    for name in ("overturned", "fall_azimuth", "overturning_time", "peak_tilt", "residual_twist", "slid_off"):
        assert "element" in loaded_cube[name].dims, name
    assert {"residual_slip_north", "residual_slip_east"} <= set(loaded_cube.data_vars)
    assert study_of_cube(loaded_cube) == study_settings
    assert isinstance(default_model_of_same_kind_as_results_cube(loaded_cube), Stack)
    assert loaded_cube["vertical"].item() == 1
    shares = {row.element_name: row.fall_share for row in count_falls_of_each_and_any_element(loaded_cube)}
    assert 0.0 < shares["shaft"] <= 1.0


def test_cells_of_a_stack_cube_equal_those_of_simulate_as_arrays(
    loaded_cube: xr.Dataset, read_motion_stored_beside_cube: Motion, study_settings: Study
) -> None:
    sizes = {"height": study_settings.height, "b_over_h": study_settings.b_over_h}  # rounded in the study
    alone = simulate_as_arrays(
        read_motion_stored_beside_cube.scaled_by(1.5),
        study_settings.scene,
        orientation_deg=[30.0],
        friction=[0.7],
        **sizes,
    )
    for name in ("overturned", "fall_azimuth", "peak_tilt", "residual_twist", "residual_slip_north", "slid_off"):
        cell = loaded_cube[name].isel(record=0).sel(amplitude=1.5, orientation=30, friction=0.7).to_numpy().ravel()
        found = alone[name].ravel()
        found = np.where(found == -128, np.nan, found) if found.dtype.kind == "i" else found
        np.testing.assert_array_equal(np.float32(cell), np.float32(found), err_msg=name)


def test_the_ensemble_of_a_stack_has_probabilities_and_directions_of_each_stone(loaded_cube: xr.Dataset) -> None:
    nominal = loaded_cube.sel(amplitude=1.0)
    assert nominal["probability_falls"].dims[-1] == "element"
    shares = nominal["probability_falls"].to_numpy()
    assert ((shares >= 0.0) & (shares <= 1.0)).all()
    assert (nominal["members"] == 4).all()
    length = np.hypot(nominal["fall_north"], nominal["fall_east"]).to_numpy()
    assert (length <= shares + 1e-6).all()
    assert np.isnan(loaded_cube["probability_falls"].sel(amplitude=1.5)).all()


def test_a_recheck_reproduces_every_bit_of_a_stack_cube(cube_file: Path) -> None:
    found = recompute_and_compare_random_cases(cube_file, max_random_case_count=4)
    assert found.values_are_identical_and_hash_is_correct, found.difference_messages
    assert found.cell_count_with_recomputed_ensemble > 0


def test_the_convergence_check_of_a_stack_compares_each_stone(cube_file: Path, study_settings: Study) -> None:
    sample = read_random_case_sample(cube_file, study_settings.verification)
    done = read_record_from_motion_file(cube_file.parent / "motion" / "a.nc")
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(study_settings, [done], sample)
    for part in (found.finer_step_rerun, found.stiffer_contact_rerun):
        assert [one.element for one in part.changes_by_element] == STONES


def test_a_stack_study_with_all_defaults_is_read_back_equal(study_settings: Study) -> None:
    content = json.loads(json.dumps(study_settings_with_file_names_for_absolute_paths(study_settings)))
    assert study_from_content(content, "complete") == study_settings
    assert "azimuth" not in content


@pytest.mark.parametrize("step", [5, 30])
def test_a_study_passed_to_a_job_as_json_stays_a_stack(step: int) -> None:
    """A study of a stack that a job reads from JSON stays a stack, even with an orientation step of 5°.

    This step is the default, which 2-D studies of earlier versions also contain.
    """
    whole = study_from_content(SMALL_STUDY | {"orientation": {"step": step}}, "stack")
    read = study_from_content(json.loads(json.dumps(whole.model_dump(mode="json"))), "job")
    assert read == whole
    assert read.is_stack


def test_a_planar_study_saved_with_all_settings_by_an_earlier_version_stays_planar() -> None:
    plane = study_from_content(SMALL_STUDY | {"orientation": None}, "plane")
    content = study_settings_with_file_names_for_absolute_paths(plane) | {"orientation": {"start": 0.0, "step": 5.0}}
    assert study_from_content(content, "earlier") == plane


def test_film_command_for_a_stack_names_its_scene(loaded_cube: xr.Dataset) -> None:
    found = film_command_options_and_stone_sizes(loaded_cube)
    assert found["missing"] == ""
    assert found["options"] == ["--scene", "three-tier"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scene": "against-a-wall"}, "element wall does not stand free on ground"),
        ({"scene": None}, "orientation: only a 3-D body or a stack has one"),
        ({"orientation": {"step": 40}}, "a step of 40° does not divide 90°, after which the stack looks the same"),
        ({"orientation": {"step": 30, "start": 50}}, "orientation.start: 50°; it must lie below the step, 30°"),
        ({"azimuth": {"step": 30}}, "azimuth: a 3-D body or stack moves in all directions at once"),
        ({"azimuth": {}, "orientation": {}}, "azimuth: a 3-D body or stack moves in all directions at once"),
        ({"variants": {"wall": {"scene": "against-a-wall"}}}, "variants.wall.scene: orientation: scene against-a-wall"),
    ],
)
def test_a_wrong_setting_of_a_stack_study_is_refused_with_its_key(change: dict[str, Any], message: str) -> None:
    with expect_error(ConfigError, message):
        study_from_content({key: value for key, value in (SMALL_STUDY | change).items() if value is not None}, "stack")


def test_surveyed_twist_and_slip_are_compared_relative_to_the_stone_below(
    loaded_cube: xr.Dataset, cube_file: Path, tmp_path: Path
) -> None:
    """Surveyed twist and slip of a stone are compared with the computed ones relative to the stone below.

    Each stone and amplitude factor has a different twist and slip, so that values of a wrong stone would be noticed.
    """
    own, stronger = np.array([1.0, 2.0, 12.0]), np.array([0.0, 100.0])
    order = ("element", "amplitude")
    twist = xr.DataArray(own[:, None] + stronger, dims=order)
    known = loaded_cube.assign(
        overturned=xr.zeros_like(loaded_cube["overturned"]),
        residual_twist=xr.zeros_like(loaded_cube["residual_twist"]) + twist,
        residual_slip_north=xr.zeros_like(loaded_cube["residual_slip_north"]) + 0.003 * twist,
        residual_slip_east=xr.zeros_like(loaded_cube["residual_slip_east"]) - 0.004 * twist,
    )
    stones = tmp_path / "stones.csv"
    stones.write_text('outcome,face_azimuth_deg,count\n"shifted 6 cm, twisted 12",30,7\nstands,0,3\n', encoding="utf-8")
    shaft = select_element_and_amplitude(known, cube_file)
    found = {
        one.name: one for one in compare_falls_shifts_and_twists(read_survey_table(stones), shaft).compared_statistics
    }
    assert (found["twist_deg"].observed, found["twist_deg"].computed) == pytest.approx((12.0, 12.0), rel=1e-6)
    assert (found["shift_m"].observed, found["shift_m"].computed) == pytest.approx((0.06, 0.005 * 12.0), rel=1e-6)
    assert (found["twisted"].observed, found["twisted"].computed, found["clockwise"].computed) == (0.7, 1.0, 1.0)

    text = run_overturning_and_return_printed_text("survey", stones, "--cube", cube_file)
    falls = (
        loaded_cube["overturned"].sel(amplitude=1.0, orientation=[0, 30]).mean(["orientation", "friction"]).squeeze()
    )
    assert falls.sel(element="shaft") == 1.0 > falls.sel(element="lower-base")
    assert re.search(r"\n\s*fell\s+10\s+0\s% \(0 to 31\)\s+100\s% \(100 to 100\)", text), "that of the shaft"
