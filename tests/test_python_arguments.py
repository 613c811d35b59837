"""Arguments in Python: wrong ones are named; arrays, threads and settings of the user stay as they are."""

from collections import namedtuple
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import obspy
import pytest
import xarray as xr

import overturning
from overturning.errors import OverturningError
from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.records.record import Record
from tests.expect import expect_error

WAVE = Motion.sine(6.0, 0.8)
GRID: dict[str, Any] = {"azimuth": {"step": 90}, "b_over_h": [0.2, 0.3], "height": [0.6], "friction": [0.5, 1.0]}
NO_ENSEMBLE: dict[str, Any] = {"ensemble": {"members": 0}}


def cube_of_small_study() -> xr.Dataset:
    """Simulate a small study without an ensemble."""
    return overturning.run_study([WAVE], **GRID, **NO_ENSEMBLE)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: overturning.findings(cube_of_small_study()), ["cube: a Dataset", "the path of cube.nc"]),
        (lambda: overturning.findings(None), ["cube: a NoneType", "the path of cube.nc"]),
        (lambda: overturning.open_cube(3), ["path: a int", "the path of cube.nc"]),
        (lambda: overturning.open_cube("cube.nc", amplitude="x"), ["amplitude: 'x'", "number"]),
        (lambda: overturning.open_cube("cube.nc", chunks="x"), ["chunks: 'x'", '"auto"']),
        (lambda: overturning.read(None), ["paths: a NoneType", "the path of a file"]),
        (lambda: overturning.read(["a", 3]), ["paths: a int", "the path of a file"]),
        (lambda: overturning.read("a.csv", record_id=3), ["record_id: a int", "text"]),
        (lambda: overturning.read_survey(3), ["path: a int", "the path of a file"]),
        (lambda: overturning.read_survey("a.csv", declination_deg="east"), ["declination_deg: 'east'", "number"]),
        (lambda: overturning.to_dataframe(None), ["cube: a NoneType", "open_cube"]),
        (lambda: overturning.to_dataframe(cube_of_small_study()[["peak_slip"]]), ["cube: a Dataset", "open_cube"]),
        (
            lambda: overturning.to_dataframe(overturning.trajectory(WAVE, azimuth_deg=0, height=0.6, b_over_h=0.3)),
            ["cube: a Dataset", "open_cube"],
        ),
        (lambda: Motion.from_obspy(obspy.Trace()), ["stream: a Trace", "Stream"]),
        (lambda: Motion.from_obspy(None), ["stream: a NoneType", "Stream"]),
        (lambda: Motion.from_obspy(WAVE.to_obspy(), unit=["gal"]), ["unit: ['gal']", "known are"]),
        (lambda: Motion.from_record(None), ["record: a NoneType", "overturning.read"]),
        (lambda: Motion.sine(6.0, 0.8, rest="1 s"), ["rest: '1 s'", "number"]),
        (lambda: Motion.sine(6.0, 0.8, rest=[1, 2]), ["rest: [1, 2]", "at least 0"]),
        (lambda: Motion([0, 1], [0, 1], sampling_interval=np.timedelta64(5, "ms")), ["sampling_interval", "number"]),
        (lambda: Motion([0, 1], [0, 1], sampling_interval=0.01, trust_data="no"), ["trust_data: 'no'", "True or"]),
        (lambda: Record("x", [0.0, 1.0], [0.0, 1.0], None, 0.01), ["record x: north: list", "array of float64"]),
        (lambda: Record("x", np.arange(9), np.arange(9.0), None, 0.01), ["north: ndarray of int64", "float64"]),
        (lambda: overturning.gravestone(density="heavy"), ["density: 'heavy'", "number"]),
        (lambda: overturning.gravestone(density=True), ["density: True", "above 0"]),
        (lambda: overturning.gravestone(contact=[1]), ["contact: [1]", "Contact"]),
        (lambda: overturning.plot.fall_map(cube_of_small_study(), record=[]), ["record: none", "an id of the cube"]),
        (lambda: overturning.plot.fall_map(cube_of_small_study(), record=3), ["no record 3", "motion-1"]),
        (lambda: overturning.plot.rotation_slip_and_uplift([]), ["no trajectory", "overturning.trajectory"]),
        (lambda: overturning.plot.rotation_slip_and_uplift(None), ["a NoneType", "overturning.trajectory"]),
        (lambda: Cases(np.ma.array([0.0, 90.0], mask=[0, 1]), 0.6, 0.3, 1.0), ["azimuth_deg: 1 masked"]),
        (lambda: Cases(1e12, 0.6, 0.3, 1.0), ["azimuth_deg: 1e+12", "at most 1e+06"]),
        (
            lambda: overturning.simulate(WAVE, azimuth_deg=np.ma.array([0, 90], mask=[0, 1]), height=0.6, b_over_h=0.3),
            ["azimuth_deg: 1 masked"],
        ),
        (
            lambda: overturning.simulate(WAVE, azimuth_deg=0, height=np.array([1], "m8[s]"), b_over_h=0.3),
            ["height", "number"],
        ),
        (lambda: overturning.simulate(WAVE, azimuth_deg=np.array([1 + 2j]), height=0.6, b_over_h=0.3), ["number"]),
    ],
)
def test_a_wrong_argument_is_named_in_the_error(call: Callable[[], object], words: list[str]) -> None:
    with expect_error(OverturningError, *words):
        call()


def test_cases_hold_copies_of_the_arrays_they_are_made_from() -> None:
    slenderness = np.array([0.3, 0.2])
    cases = Cases(0.0, 1.0, slenderness, 1.0)
    slenderness[:] = 0.6
    assert np.asarray(cases.b_over_h).tolist() == [0.3, 0.2]
    with pytest.raises(ValueError, match="read-only"):
        np.asarray(cases.height)[0] = -3.0


def test_records_and_cases_are_equal_only_to_themselves() -> None:
    record = Record("x", np.arange(9.0), np.arange(9.0), None, 0.01)
    assert record in [record]
    assert record not in [deepcopy(record)]
    assert len({record, record}) == 1
    cases = Cases([0, 1], 1.0, 0.3, 1.0)
    assert cases == cases
    assert cases != Cases([0, 1], 1.0, 0.3, 1.0)


def test_any_object_with_the_components_of_a_motion_is_accepted() -> None:
    made = namedtuple("made", "north east up sampling_interval")(WAVE.north, WAVE.east, None, WAVE.sampling_interval)
    grid: dict[str, Any] = {"azimuth_deg": [0, 90], "height": 0.6, "b_over_h": 0.3}
    xr.testing.assert_identical(overturning.simulate(made, **grid), overturning.simulate(WAVE, **grid))


def test_a_scene_is_loaded_from_a_folder_given_as_a_string() -> None:
    root = Path(__file__).parents[1]
    assert overturning.load_scene("three-tier", str(root)) == overturning.load_scene("three-tier", root)


def test_simulate_and_run_study_give_the_same_outcomes_of_a_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    """By default, `simulate` and `run_study` give a scene exactly its reference element's height and B/H."""
    monkeypatch.chdir(Path(__file__).parents[1])
    cell = overturning.run_study([WAVE], scene="three-tier", azimuth={"step": 90}, **NO_ENSEMBLE).isel(record=0)
    alone = overturning.simulate(WAVE, overturning.load_scene("three-tier"), azimuth_deg=[0, 90, 180, 270])
    assert alone["b_over_h"].to_numpy().tolist() == cell["b_over_h"].to_numpy().tolist()
    for name in ("overturned", "peak_slip", "peak_rotation"):
        np.testing.assert_array_equal(alone[name].to_numpy().ravel(), cell[name].to_numpy().ravel())


def test_a_single_case_of_a_cube_becomes_a_table_of_one_row() -> None:
    one = cube_of_small_study().isel(record=0, azimuth=1, height=0, b_over_h=0, friction=0)
    table = overturning.to_dataframe(one)
    assert len(table) == 1
    assert table["peak_slip"].item() == one["peak_slip"].item()


@pytest.mark.parametrize(
    "part",
    [
        lambda cube: cube.where(cube["friction"] > 0.6, drop=True),
        lambda cube: cube.drop_encoding(),
        lambda cube: xr.Dataset.from_dict(cube.to_dict()),
    ],
)
def test_a_selection_of_a_cube_in_memory_is_drawn(part: Callable[[xr.Dataset], xr.Dataset]) -> None:
    assert overturning.plot.fall_map(part(cube_of_small_study())).axes


def test_studies_and_figures_do_not_depend_on_concurrent_threads() -> None:
    before = dict(mpl.rcParams)
    alone = cube_of_small_study()

    def run_study_and_draw_map(_: int) -> tuple[xr.Dataset, Any]:
        cube = cube_of_small_study()
        return cube, overturning.plot.fall_map(cube)

    with ThreadPoolExecutor(3) as pool:
        made = list(pool.map(run_study_and_draw_map, range(6)))
    for cube, figure in made:
        xr.testing.assert_equal(cube, alone)
        assert figure.axes
    assert dict(mpl.rcParams) == before
