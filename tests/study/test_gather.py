"""Gathering of parts into a cube: every cell in its place, and missing parts are detected."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from compliance_checker.runner import CheckSuite, ComplianceChecker

from overturning.errors import ResultError
from overturning.labels import earthquake_assignment_notes
from overturning.model.scene import load_scene
from overturning.model.status import CaseStatus
from overturning.model.variables import FLOAT32_MISSING, INT8_MISSING, PLANAR_OUTCOME_VARIABLES
from overturning.records.record import Record
from overturning.study.cube import open_cube, record_sources, record_sources_and_processing_by_id, study_of_cube
from overturning.study.gather import create_cube_structure, merge_outcome_files_into_cube
from overturning.study.load import study_from_content
from overturning.study.parts import write_outcome_file_of_chunk
from overturning.study.scenes import variant_grid, variant_model
from overturning.study.schema import Study

RECORD_NAMES = ("first", "second")
GRID_AND_ENSEMBLE_SETTINGS = {
    "azimuth": {"step": 45},
    "b_over_h": [0.2, 0.4, 0.6],
    "friction": [0.5, 1.0],
    "ensemble": {"members": 0},
}
STUDY = study_from_content(
    {"name": "small", "records": {"use": list(RECORD_NAMES)}, **GRID_AND_ENSEMBLE_SETTINGS}, "test"
)
ZERO_SAMPLES = np.zeros(10)
STATION_LOCATION_AND_FAULT_STRIKE = {"latitude": 35.2, "longitude": 133.4, "fault_strike_deg": 30.0}
EXTRA_FIELDS = {"pulse": True, "event_latitude": 35.3, "event_longitude": 133.3}
RECORDS = [
    Record(
        "first",
        ZERO_SAMPLES,
        ZERO_SAMPLES,
        None,
        0.01,
        station="A",
        event="E",
        **STATION_LOCATION_AND_FAULT_STRIKE,
        extra=EXTRA_FIELDS,
    ),
    Record("second", ZERO_SAMPLES, ZERO_SAMPLES, ZERO_SAMPLES, 0.01, station="<script>", event="E"),
]


def random_outcomes(shape: tuple[int, ...], seed: int) -> dict[str, np.ndarray]:
    """Return random outcome variables of a grid shape."""
    rng = np.random.default_rng(seed)
    values = {
        v.name: rng.random(shape).astype(v.dtype_in_file) for v in PLANAR_OUTCOME_VARIABLES if v.dtype_in_file == "f4"
    }
    values |= {"overturned": rng.integers(-1, 2, shape, dtype=np.int8), "status": np.zeros(shape, np.int8)}
    return values | {"mirrored": np.zeros(shape, np.int8)}


def write_random_outcome_files(folder: Path, pieces: int = 1) -> list[Path]:
    """Write files of random outcomes as a sweep would, in `pieces` files per record, and return their paths."""
    grid, paths = variant_grid(STUDY), []
    for seed, name in enumerate(RECORD_NAMES):
        full = random_outcomes(grid.shape, seed)
        for piece, places in enumerate(np.array_split(np.arange(grid["azimuth"].size), pieces)):
            path = folder / f"{name}-{pieces}-{piece}.nc"
            part = grid.copy_with_dimension_values(azimuth=grid["azimuth"][places])
            cells = {variable: values[places] for variable, values in full.items()}
            write_outcome_file_of_chunk(
                path, part, cells, {"record_id": name, "variant": "nominal", "block_steps": places.size}
            )
            paths.append(path)
    return paths


def cube_merged_from_random_outcome_files(
    folder: Path, records: list[Record] = RECORDS, settings: Study = STUDY
) -> xr.Dataset:
    """Merge parts of random outcomes into a cube of the study, with other records or settings if given."""
    merge_outcome_files_into_cube(settings, records, write_random_outcome_files(folder), folder / "cube.nc")
    with open_cube(folder / "cube.nc") as opened:
        return opened.load()


@pytest.fixture(scope="module")
def study_cube(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """The cube of the study, which tests must not change."""
    return cube_merged_from_random_outcome_files(tmp_path_factory.mktemp("gathered"))


def test_merging_puts_every_cell_at_its_place_in_the_cube(study_cube: xr.Dataset) -> None:
    found = study_cube
    assert found.attrs["block_steps"] == 2 * variant_grid(STUDY)["azimuth"].size, "one a direction"
    for seed in range(2):
        for name, values in random_outcomes(variant_grid(STUDY).shape, seed).items():
            np.testing.assert_array_equal(found[name].isel(record=seed), values)
    assert found["fault_normal"].values.tolist()[0] == 120.0
    assert np.isnan(found["fault_normal"].values[1])
    assert found["vertical"].values.tolist() == [0, 1]
    assert found["pulse"].values[0] == 1
    assert np.isnan(found["pulse"].values[1])
    assert found["station_latitude"].values.tolist()[0] == 35.2
    assert found["station_longitude"].values.tolist()[0] == 133.4
    assert found["epicentre_latitude"].values.tolist()[0] == 35.3
    assert found["epicentre_longitude"].values.tolist()[0] == 133.3
    assert np.isnan([found[name].values[1] for name in found.coords if "itude" in name]).all()
    assert study_of_cube(found) == STUDY


def test_sources_of_site_coordinates_are_stored_only_as_attributes(study_cube: xr.Dataset, tmp_path: Path) -> None:
    """The sources of coordinates are stored with the sources of the records.

    Coordinates and variables of the cube stay identical.
    """
    places = {"coordinates_source": "survey", "fault_trace": "35 133, 36 133", "fault_trace_source": "map"}
    with_places = cube_merged_from_random_outcome_files(
        tmp_path, [replace(RECORDS[0], extra=EXTRA_FIELDS | places), RECORDS[1]]
    )
    first, second = record_sources(with_places)
    assert {name: first[name] for name in places} == places
    assert not {*places} & {*second}
    assert with_places.identical(study_cube.assign_attrs(record_sources=with_places.attrs["record_sources"]))


@pytest.mark.parametrize(("scene", "period"), [("gravestone", 180.0), ("three-tier", 180.0), ("against-a-wall", 360.0)])
def test_a_cube_states_the_azimuth_period_after_which_cases_repeat(scene: str, period: float, tmp_path: Path) -> None:
    """A wall on one side makes opposite azimuths two different cases, so that the period is 360°.

    The wall prevents falls towards it only.
    """
    of_scene = STUDY.model_copy(update={"scene": load_scene(scene)})
    with netCDF4.Dataset(tmp_path / "cube.nc", "w") as cube:
        create_cube_structure(cube, of_scene, [])
        assert cube["azimuth"].period == period
    grid = variant_grid(of_scene)
    answering = np.unique(
        variant_model(of_scene).simulated_direction_for_each_direction(grid).simulated_direction_index
    ).size
    assert answering == np.unique(grid["azimuth"] % period).size
    assert (answering == grid["azimuth"].size) == (period == 360)


def test_record_metadata_are_copied_to_the_cube(tmp_path: Path) -> None:
    numbers = {"magnitude": 7.8, "rupture_distance": 1.5, "vs30": 410.0, "pulse_period": 2.2}
    known = numbers | {"site_class": "C", "wall": "foot", "agency_processing": "gefiltert in Zürich"}
    described = [replace(RECORDS[0], extra=RECORDS[0].extra | known), RECORDS[1]]
    found = cube_merged_from_random_outcome_files(tmp_path, described)
    processing = known.pop("agency_processing")
    for name, value in known.items():
        assert found[name].values[0] == value
        assert found[name].values[1] == "" if isinstance(value, str) else np.isnan(found[name].values[1])
    assert found["rupture_distance"].attrs["units"] == "km"
    accounts = record_sources_and_processing_by_id(found)
    assert set(accounts) == set(RECORD_NAMES)
    assert accounts["first"]["data"] == "raw"
    assert accounts["first"]["duration_s"] == 0.09
    assert accounts["first"]["agency"] == processing
    assert processing in found.attrs["record_processing"], "as it is written, for those who look at it with ncdump"


def test_two_names_of_one_earthquake_are_merged_in_the_cube_with_a_note(tmp_path: Path) -> None:
    names = ("Loma Prieta 10/18/1989", "Loma Prieta, CA")
    named = [
        replace(record, event=name, extra={"origin_time": f"1989-10-18T00:04:{second}Z"})
        for record, name, second in zip(RECORDS, names, (15, 14), strict=True)
    ]
    found = cube_merged_from_random_outcome_files(tmp_path, named)
    assert found["event"].to_numpy().tolist() == [names[0]] * 2
    assert earthquake_assignment_notes(found) == [
        f"'{names[0]}' and '{names[1]}' are one earthquake (one origin, 1989-10-18 00:04)"
    ]


def test_sweep_parts_in_any_order_give_a_cube_with_the_same_bytes(tmp_path: Path) -> None:
    merge_outcome_files_into_cube(STUDY, RECORDS, write_random_outcome_files(tmp_path), tmp_path / "whole.nc")
    merge_outcome_files_into_cube(STUDY, RECORDS, write_random_outcome_files(tmp_path, 3)[::-1], tmp_path / "pieces.nc")
    assert (tmp_path / "whole.nc").read_bytes() == (tmp_path / "pieces.nc").read_bytes()


def test_missing_cells_are_refused_and_no_cube_is_written(tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="no part holds all cells of second"):
        merge_outcome_files_into_cube(
            STUDY, RECORDS, write_random_outcome_files(tmp_path, 2)[:-1], tmp_path / "cube.nc"
        )
    assert not [path for path in tmp_path.iterdir() if "cube" in path.name]


def test_a_sweep_part_of_another_study_is_refused(tmp_path: Path) -> None:
    other = STUDY.model_copy(update={"friction": (0.5, 0.9)})
    with pytest.raises(ResultError, match="its friction values are not those of the study"):
        merge_outcome_files_into_cube(other, RECORDS, write_random_outcome_files(tmp_path), tmp_path / "cube.nc")
    with pytest.raises(ResultError, match="which are not in this study"):
        merge_outcome_files_into_cube(STUDY, RECORDS[:1], write_random_outcome_files(tmp_path), tmp_path / "cube.nc")
    broken = tmp_path / "broken.nc"
    broken.write_bytes(b"CDF nothing")
    with pytest.raises(ResultError, match=r"broken\.nc: damaged"):
        merge_outcome_files_into_cube(STUDY, RECORDS, [broken], tmp_path / "cube.nc")


def test_missing_outcomes_in_a_cube_are_nan_and_never_a_flag(tmp_path: Path) -> None:
    paths = write_random_outcome_files(tmp_path)
    grid = variant_grid(STUDY)
    cells = random_outcomes(grid.shape, 0)
    cells["overturned"][2, 0, 1, 1] = INT8_MISSING
    cells["overturning_time"][2, 0, 1, 1] = FLOAT32_MISSING
    cells["status"][2, 0, 1, 1] = CaseStatus.UNDECIDED
    write_outcome_file_of_chunk(paths[0], grid, cells, {"record_id": "first", "variant": "nominal", "block_steps": 5})
    merge_outcome_files_into_cube(STUDY, RECORDS, paths, tmp_path / "cube.nc")
    with open_cube(tmp_path / "cube.nc") as cube:
        assert int(cube["overturned"].isnull().sum()) == 1
        assert np.isnan(cube["overturned"][0, 2, 0, 1, 1])
        assert np.isnan(cube["overturning_time"][0, 2, 0, 1, 1])
        assert cube["status"][0, 2, 0, 1, 1] == CaseStatus.UNDECIDED


def test_pulse_and_vertical_flags_of_a_cube_have_cf_flag_meanings(study_cube: xr.Dataset) -> None:
    found = study_cube
    for name, meanings in (("pulse", "no_pulse pulse"), ("vertical", "horizontal_only with_vertical")):
        assert found[name].attrs["flag_values"].tolist() == [0, 1]
        assert found[name].attrs["flag_meanings"] == meanings


@pytest.mark.filterwarnings("ignore:The ioos_sos checker is deprecated")
def test_a_cube_passes_the_cf_convention_checker(study_cube: xr.Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    CheckSuite.load_all_available_checkers()
    ComplianceChecker.run_checker(study_cube.encoding["source"], ["cf:1.11"], verbose=0, criteria="strict")
    report = capsys.readouterr().out
    remarks = [line for line in report.splitlines() if line.startswith("* ")]
    # The checker takes a dimension called height for the vertical axis and asks for its standard name. The convention
    # goes by no variable's name (§1.3), and its standard name is the distance of a place above the ground.
    taken_for_an_axis = "'height' should have standard_name='height'"
    assert [line for line in remarks if taken_for_an_axis not in line] == []
    assert study_cube["height"].attrs == {"long_name": "height of the block", "units": "m"}
    assert "Compliance Checker Report" in report
    errors = [line for line in report.partition(" Errors ")[2].splitlines() if line.startswith("* ")]
    assert len(errors) == report.count(taken_for_an_axis) == len(remarks)


def test_opening_a_file_that_is_not_a_cube_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="a folder; name the cube in it"):
        open_cube(tmp_path)
    with pytest.raises(ResultError, match="no such cube"):
        open_cube(tmp_path / "none.nc")
    with pytest.raises(ResultError, match=r"x\.nc: cannot be opened \(.+\); check its name and permissions"):
        open_cube(tmp_path / f"{'x' * 300}.nc")
    write_outcome_file_of_chunk(
        tmp_path / "part.nc", variant_grid(STUDY), random_outcomes(variant_grid(STUDY).shape, 0), {"record_id": "a"}
    )
    with pytest.raises(ResultError, match="not a cube"):
        open_cube(tmp_path / "part.nc")


def test_a_cube_contains_no_paths_of_this_machine(tmp_path: Path) -> None:
    folder = STUDY.records.model_copy(update={"folder": str(tmp_path / "mine")})
    found = cube_merged_from_random_outcome_files(tmp_path, settings=STUDY.model_copy(update={"records": folder}))
    assert str(tmp_path) not in repr(dict(found.attrs))


def test_dask_is_imported_only_when_a_cube_is_read_in_chunks(study_cube: xr.Dataset) -> None:
    program = f"""if True:
        import sys
        sys.modules["distributed"] = None  # of the group cluster, which users seldom install
        from pathlib import Path
        from xarray.namedarray.pycompat import array_type
        from overturning.study.cube import open_cube
        with open_cube(Path({study_cube.encoding["source"]!r})) as cube:
            print((cube["overturned"] == 0).sum().item(), "dask.array" in sys.modules)
        with open_cube(Path({study_cube.encoding["source"]!r}), {{"record": 1}}) as cube:
            known = isinstance(cube["overturned"].data, array_type("dask"))
            print((cube["overturned"] == 0).sum().compute().item(), known)
    """
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    whole, spared, by_record, known = done.stdout.split()
    assert (whole, spared, known) == (by_record, "False", "True")
