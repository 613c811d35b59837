"""A study of a free body in space: its keys, and its way through sweep, ensemble, gathering, recheck and repetition."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.dem.simulate import simulate_as_arrays
from overturning.errors import ConfigError, ResultError
from overturning.findings.study import scanned_stone_volume_tilt_and_relief
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.records.store import read_record_from_motion_file
from overturning.study.answers import (
    count_outcome_differences,
    create_outcome_array_to_fill,
    fall_azimuths_differ,
    mask_of_cases_with_different_falls,
)
from overturning.study.convergence_check import rerun_cases_with_finer_steps_and_stiffer_contacts
from overturning.study.cube import open_cube, study_of_cube
from overturning.study.ensemble_members import draw_parameter_changes_of_members
from overturning.study.film_options import film_command_options_and_stone_sizes
from overturning.study.gather import merge_outcome_files_into_cube
from overturning.study.load import load_study, load_study_from_file_or_json, study_from_content
from overturning.study.recheck import recompute_and_compare_random_cases
from overturning.study.sample import read_random_case_sample
from overturning.study.schema import Study
from overturning.study.sections import ConvergenceCheckSettings
from overturning.study.sweep import simulate_and_write_cases_of_record
from tests.expect import run_overturning_and_return_printed_text
from tests.model.solids import (
    box,
    column_with_overhanging_slab,
    mass_properties_of_solid_from_its_boxes,
    rotate_surface,
    write_mesh,
)
from tests.study.small_study import simulate_study_cube

SMALL_STUDY: dict[str, Any] = {
    "name": "space",
    "records": {"use": ["a"]},
    "body": {"aspect": [1, 2]},
    "orientation": {"step": 45},
    "b_over_h": [0.15, 0.25, 0.4],
    "friction": [0.7],
    "ensemble": {"members": 4, "where": "everywhere"},
    "verification": {"at_least": 6, "cost": 50},
}


def record_of_two_cycles(name: str = "a", up: bool = False) -> Record:
    """Record of two cycles of a sine towards N20°E, with a weaker one across it."""
    time = np.arange(0, 3, 0.01)
    cycle, across = (np.where(time < 1.6, np.sin(2 * np.pi * (time - lag) / 0.8), 0.0) for lag in (0.0, 0.2))
    north, east = 5.0 * cycle * np.cos(0.35) - 2.0 * across, 5.0 * cycle * np.sin(0.35) + across
    vertical = 3.0 * np.sin(2 * np.pi * time / 0.3) if up else None
    return Record(name, north, east, vertical, 0.01, event="E", fault_strike_deg=290.0)


@pytest.fixture(scope="module")
def study_settings() -> Study:
    """Settings of a small study of 3-D prisms."""
    return study_from_content(SMALL_STUDY, "space")


@pytest.fixture(scope="module")
def cube_file(study_settings: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Path of the cube of the small study."""
    return simulate_study_cube(study_settings, [record_of_two_cycles()], tmp_path_factory.mktemp("space"))


@pytest.fixture(scope="module")
def read_motion_stored_beside_cube(cube_file: Path) -> Motion:
    """Motion of the record as the study stored it."""
    return Motion.of(read_record_from_motion_file(cube_file.parent / "motion" / "a.nc"))


@pytest.fixture(scope="module")
def loaded_cube(cube_file: Path) -> xr.Dataset:
    """The cube of the small study."""
    with open_cube(cube_file) as opened:
        return opened.load()


def test_a_3d_cube_has_orientation_and_aspect_in_place_of_azimuth(
    loaded_cube: xr.Dataset, study_settings: Study
) -> None:
    assert dict(loaded_cube.sizes) == {
        "record": 1,
        "orientation": 4,
        "height": 1,
        "b_over_h": 3,
        "aspect": 2,
        "friction": 1,
    }
    assert loaded_cube["orientation"].to_numpy().tolist() == [0, 45, 90, 135]
    assert study_settings.cases_per_record == loaded_cube["overturned"].size
    assert study_of_cube(loaded_cube) == study_settings
    assert loaded_cube["vertical"].item() == 0


def test_flags_in_a_3d_cube_have_their_documented_values(loaded_cube: xr.Dataset) -> None:
    """Flag variables have one meaning for each flag value, and no other values (CF 1.11, section 3.5)."""
    flags = {name: values for name, values in loaded_cube.variables.items() if "flag_values" in values.attrs}
    assert {"overturned", "plane_overturned", "repeated", "vertical"} <= set(flags)
    for name, values in flags.items():
        allowed = values.attrs["flag_values"].tolist()
        assert len(allowed) == len(values.attrs["flag_meanings"].split()), name
        found = values.to_numpy().astype(np.float64)
        assert set(found[np.isfinite(found)].tolist()) <= set(allowed), name
    assert {0, 1} <= set(loaded_cube["plane_overturned"].to_numpy().ravel().tolist()), "both are looked at"


def test_cells_of_a_3d_cube_equal_those_of_simulate_as_arrays(
    loaded_cube: xr.Dataset, read_motion_stored_beside_cube: Motion
) -> None:
    alone = simulate_as_arrays(
        read_motion_stored_beside_cube,
        "rectangle",
        orientation_deg=[45.0],
        height=[0.6],
        b_over_h=[0.25],
        aspect=[2.0],
        friction=[0.7],
    )
    for name in ("overturned", "fall_azimuth", "fall_face", "peak_tilt", "residual_twist", "energy_error"):
        cell = loaded_cube[name].isel(record=0).sel(orientation=45, b_over_h=0.25, aspect=2, height=0.6, friction=0.7)
        np.testing.assert_array_equal(np.float32(cell), np.float32(alone[name].item()), err_msg=name)


def test_a_square_prism_has_equal_outcomes_after_a_quarter_turn(loaded_cube: xr.Dataset) -> None:
    square, oblong = (
        loaded_cube["repeated"].sel(aspect=aspect).isel(record=0, height=0, b_over_h=0, friction=0) for aspect in (1, 2)
    )
    assert square.to_numpy().tolist() == [0, 0, 1, 1]
    assert oblong.to_numpy().tolist() == [0, 0, 0, 0]
    for name in ("overturned", "fall_azimuth", "members", "probability_falls", "fall_north", "plane_overturned"):
        values = loaded_cube[name].sel(aspect=1)
        np.testing.assert_array_equal(values.sel(orientation=0), values.sel(orientation=90), err_msg=name)


def test_planar_outcomes_in_a_3d_cube_equal_those_of_the_2d_kernel(
    loaded_cube: xr.Dataset, read_motion_stored_beside_cube: Motion
) -> None:
    along = simulate_as_arrays(
        read_motion_stored_beside_cube, azimuth_deg=[45.0], height=[0.6], b_over_h=[0.15, 0.25, 0.4], friction=[0.7]
    )
    across = simulate_as_arrays(
        read_motion_stored_beside_cube, azimuth_deg=[135.0], height=[0.6], b_over_h=[0.3, 0.5, 0.8], friction=[0.7]
    )
    sides = [found["overturned"].ravel().astype(int) for found in (along, across)]
    times = [np.nan_to_num(found["overturning_time"].ravel(), nan=np.inf) for found in (along, across)]
    cells = loaded_cube.isel(record=0, height=0, friction=0).sel(orientation=45, aspect=2)
    assert cells["plane_overturned"].to_numpy().tolist() == [int(a != 0 or b != 0) for a, b in zip(*sides, strict=True)]
    expected = [
        np.nan if not (a or b) else (45.0 if a > 0 else 225.0) if s <= t else (135.0 if b > 0 else 315.0)
        for a, b, s, t in zip(*sides, *times, strict=True)
    ]
    np.testing.assert_array_equal(cells["plane_fall_azimuth"], expected)
    assert np.isfinite(expected).any()


def test_3d_ensemble_statistics_equal_those_of_members_run_one_by_one(
    loaded_cube: xr.Dataset, study_settings: Study, read_motion_stored_beside_cube: Motion
) -> None:
    members = draw_parameter_changes_of_members(study_settings.ensemble)
    angles, falls = [], []
    for i in range(members.member_count):
        scaled = Motion(
            read_motion_stored_beside_cube.north * members.amplitude_factor[i],
            read_motion_stored_beside_cube.east * members.amplitude_factor[i],
            sampling_interval=0.01,
        )
        one = simulate_as_arrays(
            scaled, "rectangle", orientation_deg=[45.0 + members.azimuth_change_deg[i]], height=[0.6],
            b_over_h=[0.25 * members.b_over_h_factor[i]],
            friction=[0.7 * members.friction_factor[i]],
        )  # fmt: skip
        falls.append(int(one["overturned"].item()))
        angles.append(np.radians(one["fall_azimuth"].item() - members.azimuth_change_deg[i]))
    cell = loaded_cube.isel(record=0, height=0, friction=0).sel(orientation=45, b_over_h=0.25, aspect=1)
    # The dashpots' spread, which a call has no argument for, moves an azimuth by far less than this.
    assert cell["probability_falls"] == pytest.approx(np.mean(falls))
    assert float(cell["fall_north"]) == pytest.approx(np.nansum(np.cos(angles)) / 4, abs=0.03)
    assert float(cell["fall_east"]) == pytest.approx(np.nansum(np.sin(angles)) / 4, abs=0.03)
    assert float(cell["fall_axis_cosine"]) == pytest.approx(np.nansum(np.cos(2 * np.array(angles))) / 4, abs=0.06)
    first, second = np.reshape(falls, (2, 2)).mean(axis=1)
    assert cell["scramble_difference"] == pytest.approx(first - second)
    # Where one or three of four members fall it is half of one scramble more than of the other.
    uneven = loaded_cube["probability_falls"].isin([0.25, 0.75])
    assert uneven.any()
    assert (np.abs(loaded_cube["scramble_difference"].where(uneven, 0.5)) == 0.5).all()


def test_a_recheck_reproduces_every_bit_of_a_3d_cube(cube_file: Path) -> None:
    found = recompute_and_compare_random_cases(cube_file, max_random_case_count=12)
    assert found.values_are_identical_and_hash_is_correct
    assert found.cell_count_with_recomputed_ensemble == 12


def test_convergence_of_a_3d_study_is_checked_with_finer_and_stiffer_reruns(
    cube_file: Path, study_settings: Study
) -> None:
    assert isinstance(study_settings.verification, ConvergenceCheckSettings)
    sample = read_random_case_sample(cube_file, study_settings.verification)
    assert sample.grid_indices.shape == (6, 5)
    done = replace(sample, block_time_step_count_of_whole_study=10_000_000)
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(
        study_settings, [read_record_from_motion_file(cube_file.parent / "motion" / "a.nc")], done
    )
    for part in (found.finer_step_rerun, found.stiffer_contact_rerun):
        assert part.block_steps > 0
        assert part.changes_by_element[0].cases == found.rerun_case_count == 6


def test_fall_azimuths_more_than_fifteen_degrees_apart_count_as_different() -> None:
    first, second = create_outcome_array_to_fill(4, 1), create_outcome_array_to_fill(4, 1)
    first["overturned"][:, 0] = second["overturned"][:, 0] = flags = np.array([1, 1, 1, 0], np.int8)
    first["azimuth"][:, 0], second["azimuth"][:, 0] = [359.0, 10.0, 100.0, np.nan], [13.0, 26.0, 110.0, np.nan]
    found = count_outcome_differences(flags, flags, fall_azimuths_differ(first, second)[:, 0])
    assert (found.cases, found.flags, found.fallen, found.sides) == (4, 0, 3, 1)
    assert mask_of_cases_with_different_falls(first, second).tolist() == [False, True, False, False]


def test_merging_a_3d_cube_refuses_a_2d_sweep_part(cube_file: Path, study_settings: Study, tmp_path: Path) -> None:
    data = {name: value for name, value in SMALL_STUDY.items() if name not in ("body", "orientation")}
    plane = study_from_content(data | {"azimuth": {"step": 180}, "ensemble": {"members": 0}}, "plane")
    simulate_and_write_cases_of_record(plane, record_of_two_cycles(), tmp_path / "a.nc")
    space = study_settings.model_copy(update={"ensemble": plane.ensemble})
    with pytest.raises(ResultError, match=r"another (version|study)"):
        merge_outcome_files_into_cube(space, [record_of_two_cycles()], [tmp_path / "a.nc"], tmp_path / "cube.nc")


def test_vertical_motion_is_applied_to_3d_bodies_and_flagged_in_the_cube(tmp_path: Path) -> None:
    data = SMALL_STUDY | {"orientation": {"step": 90}, "body": {}, "ensemble": {"members": 0}, "b_over_h": [0.25]}
    cubes = []
    for vertical in (True, False):
        study = study_from_content(data | {"simulation": {"vertical": vertical}}, "space")
        with open_cube(simulate_study_cube(study, [record_of_two_cycles(up=True)], tmp_path)) as opened:
            cubes.append(opened.load())
    assert [cube["vertical"].item() for cube in cubes] == [1, 0]
    assert float(cubes[0]["peak_tilt"].max()) != float(cubes[1]["peak_tilt"].max())


def test_a_3d_study_with_all_defaults_is_read_back_equal_from_json(study_settings: Study) -> None:
    assert load_study_from_file_or_json(study_settings.model_dump_json()) == study_settings
    shipped = load_study(Path(__file__).parents[2] / "config" / "in-space.yaml")
    assert len(shipped.records.use) * shipped.cases_per_record == 33_264
    assert load_study_from_file_or_json(shipped.model_dump_json()) == shipped


BOULDER_VERTICES = [[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.15, 0.15)] + [[0.05, 0.0, 0.7]]


def test_a_study_of_a_polyhedron_takes_its_height_from_the_vertices() -> None:
    study = study_from_content({"name": "b", "records": {"use": ["a"]}, "body": {"vertices": BOULDER_VERTICES}}, "b")
    assert study.height == (0.7,)
    assert len(study.azimuths_or_orientations_deg) == 72
    assert load_study_from_file_or_json(study.model_dump_json()) == study


def test_a_loaded_study_keeps_its_mesh_vertices_without_the_mesh_file(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    faces = [(1, 2, 3), (2, 4, 3), (1, 5, 2), (2, 5, 4), (4, 5, 3), (3, 5, 1)]
    lines = [*(f"v {x} {y} {z}" for x, y, z in BOULDER_VERTICES), *(f"f {a} {b} {c}" for a, b, c in faces)]
    (tmp_path / "stone.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    study = study_from_content(
        {"name": "b", "records": {"use": ["a"]}, "body": {"mesh": str(tmp_path / "stone.obj")}}, "b"
    )
    assert study.body is not None
    assert sorted(study.body.vertices or ()) == sorted(tuple(map(float, vertex)) for vertex in BOULDER_VERTICES)
    assert load_study_from_file_or_json(study.model_dump_json()) == study, "and the file is no longer needed"
    given = study_from_content({"name": "b", "records": {"use": ["a"]}, "body": {"vertices": BOULDER_VERTICES}}, "b")
    assert given.body is not None
    assert study.body.model_dump().keys() == given.body.model_dump().keys() == {"plan", "aspect", "vertices", "mesh"}
    with pytest.raises(ConfigError, match=r"gone\.obj"):
        study_from_content({"name": "b", "records": {"use": ["a"]}, "body": {"mesh": "gone.obj"}}, "b")


def test_study_check_reports_how_an_open_mesh_was_repaired(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The study check reports that a box of 0.3 m³ without its base was closed by a flat lid.

    The box is convex, so that it becomes a polyhedron.
    """
    pytest.importorskip("trimesh")
    whole = box((0.5, 0.6, 1.0))
    open_below = whole._replace(triangles=whole.triangles[~(whole.triangle_corners[:, :, 2] == 0.0).all(axis=1)])
    mesh = write_mesh(open_below, tmp_path / "box.obj")
    path = tmp_path / "study.yaml"
    path.write_text(f"name: b\nrecords: {{pulses: {{p: sine amplitude_gal=300 period_s=1}}}}\nbody: {{mesh: {mesh}}}\n")
    monkeypatch.chdir(Path(__file__).parents[2])
    lines = run_overturning_and_return_printed_text("study", "check", path)
    assert f"{path}: body: as scanned: volume 0.3 m³\n" in lines
    assert f"{path}: body: the open base is closed by a flat lid; its 4 open edges" in lines


def test_a_study_of_a_scan_stores_its_geometry_and_mass_properties(tmp_path: Path) -> None:
    """A study of a scan stores the stone's geometry and mass properties and no longer needs the scan file.

    Stored are the points that can touch the ground, mass properties, tilt and relief of the stone.
    """
    pytest.importorskip("trimesh")
    path = write_mesh(rotate_surface(column_with_overhanging_slab(), 0, 4.0), tmp_path / "statue.stl", 1000.0)
    about = {"mesh": str(path), "mesh_unit": "mm", "relief": "1 mm"}
    study = study_from_content({"name": "b", "records": {"use": ["a"]}, "body": about}, "b")
    assert study.body is not None
    assert study.body.scan is not None
    volume, centre, _ = mass_properties_of_solid_from_its_boxes("statue")
    assert (study.body.scan.volume, study.body.scan.tilt) == pytest.approx((volume, 4.0), abs=1e-3)
    assert (study.body.relief, study.height) == (0.001, pytest.approx((0.8,)))
    facts = scanned_stone_volume_tilt_and_relief(study)
    assert facts is not None
    assert (
        facts.volume_m3,
        facts.tilt_from_scan_to_stable_pose_deg,
        facts.load_bearing_height_above_lowest_point_mm,
    ) == pytest.approx((volume, 4.0, 1.0), abs=1e-3)
    assert study.b_over_h == pytest.approx(((0.1 - centre[0]) / centre[2],), abs=1e-5)
    path.unlink()
    assert load_study_from_file_or_json(study.model_dump_json()) == study
    sizes, attributes = {"height": [0.8], "b_over_h": [0.3]}, {"study": study.model_dump_json(), "variant": "nominal"}
    film = film_command_options_and_stone_sizes(xr.Dataset(coords=sizes, attrs=attributes))
    assert "overturning one --mesh FILE" in film["missing"], "the explorer names the command for a scan"
    with pytest.raises(ConfigError, match="only a mesh"):
        study_from_content(
            {"name": "b", "records": {"use": ["a"]}, "body": {"vertices": BOULDER_VERTICES, "relief": 0.001}}, "b"
        )
