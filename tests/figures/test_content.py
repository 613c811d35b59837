"""Figures without content are refused with the reason and a remedy."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from overturning import Motion, open_cube, plot
from overturning.errors import ArgumentError
from overturning.model.status import CaseStatus
from overturning.records.record import Record
from overturning.study.intensity import write_intensity_measures
from tests.expect import expect_error, run_overturning_and_return_printed_text
from tests.figures.test_explore import random_3d_cube
from tests.study.small_study import simulate_study_cube, sine_cycle_record, small_study

NAMES_OF_FALL_FIGURES = ("boundary", "rose", "earthquakes", "axes")
NAMES_OF_OUTCOME_FIGURES = ("polar", "blocks", "plane", *NAMES_OF_FALL_FIGURES)


def write_cube_and_intensities_of_records(folder: Path, *records: Record) -> Path:
    """Write a cube with its motions and intensity measures, and return the path of the cube."""
    settings = small_study(ensemble={"members": 0}, records={"use": [record.record_id for record in records]})
    write_intensity_measures(settings, list(records), folder / "intensity.nc")
    return simulate_study_cube(settings, list(records), folder)


@pytest.fixture(scope="module")
def path_of_cube_without_falls(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a cube of a record of 100 Gal: the widest block (B/H 0.2) rocks from 196 Gal on, so all cases stand."""
    record = replace(sine_cycle_record("a", 1.0), fault_strike_deg=30.0)
    return write_cube_and_intensities_of_records(tmp_path_factory.mktemp("weak"), record)


@pytest.fixture(scope="module")
def path_of_cube_with_falls_without_fault_strike(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a cube with falls under a record without a fault strike."""
    return write_cube_and_intensities_of_records(tmp_path_factory.mktemp("strong"), sine_cycle_record("a", 6.0))


@pytest.mark.parametrize("kind", NAMES_OF_FALL_FIGURES)
def test_figure_of_falls_is_refused_without_falls(path_of_cube_without_falls: Path, tmp_path: Path, kind: str) -> None:
    out = tmp_path / "empty.svg"
    text = run_overturning_and_return_printed_text("figure", kind, path_of_cube_without_falls, "-o", out, status=1)
    assert text.startswith(f"error: {kind}: nothing to draw: none of the 18 cases with an outcome overturns; choose ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["polar", "blocks", "plane"])
def test_maps_are_drawn_if_all_blocks_stand(path_of_cube_without_falls: Path, tmp_path: Path, kind: str) -> None:
    run_overturning_and_return_printed_text("figure", kind, path_of_cube_without_falls, "-o", tmp_path / "stands.svg")
    assert (tmp_path / "stands.svg").stat().st_size > 1000


@pytest.mark.parametrize("kind", NAMES_OF_OUTCOME_FIGURES)
def test_figures_of_a_cube_without_outcomes_are_refused(
    path_of_cube_with_falls_without_fault_strike: Path, kind: str
) -> None:
    with open_cube(path_of_cube_with_falls_without_fault_strike) as cube:
        missing = {name: xr.full_like(cube[name], np.nan) for name in ("overturned", "fall_azimuth") if name in cube}
        status = xr.full_like(cube["status"], CaseStatus.OVER_BUDGET) if "status" in cube else None
        beside = cube.assign(missing | ({} if status is None else {"status": status}))
        beside.encoding["source"] = str(path_of_cube_with_falls_without_fault_strike)
        with expect_error(ArgumentError, f"{kind}: nothing to draw: none of the 18 cases has an outcome", brief=True):
            plot.CUBE_FIGURE_FUNCTIONS[kind](beside)


def test_fall_axes_figure_needs_a_fault_strike_and_roses_do_not(
    path_of_cube_with_falls_without_fault_strike: Path,
) -> None:
    with open_cube(path_of_cube_with_falls_without_fault_strike) as cube:
        assert plot.fall_rose(cube).axes
        with expect_error(ArgumentError, "axes: nothing to draw: the fault strike of no record", "fault_strike_deg"):
            plot.fall_alignment_by_earthquake(cube)


def test_figure_of_fall_alignment_needs_falls_and_a_reference_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    cube = random_3d_cube().assign_coords(pulse=("record", [1, 1]))
    unknown = xr.Dataset({name: ("record", [np.nan] * 2) for name in ("pgv_azimuth", "pga_azimuth", "pulse_axis")})
    monkeypatch.setattr(plot, "read_intensity_measures", lambda _: unknown)
    stands = cube.assign(overturned=xr.zeros_like(cube["overturned"]), fall_azimuth=cube["fall_azimuth"] * np.nan)
    with expect_error(ArgumentError, "follow: nothing to draw: none of the", "cases with an outcome overturns"):
        plot.fall_alignment_by_b_over_h(stands)
    no_fault = cube.assign_coords(fault_normal=("record", [np.nan, np.nan]))
    with expect_error(ArgumentError, "follow: nothing to draw: no record with falls has a known peak"):
        plot.fall_alignment_by_b_over_h(no_fault)


def test_figures_of_motion_are_refused_for_ground_at_rest(tmp_path: Path) -> None:
    still = Motion(np.zeros(500), np.zeros(500), sampling_interval=0.01, trust_data=True)
    for kind, draw in (("history", plot.time_histories), ("spectra", plot.spectra)):
        with expect_error(ArgumentError, f"{kind}: nothing to draw: the ground does not move (peak 0 Gal)"):
            draw(still)
    dead = write_cube_and_intensities_of_records(
        tmp_path, replace(sine_cycle_record("a", 0.0), extra={"trusted_data": True})
    )
    for kind in ("intensity", "hodograph", "history"):
        assert f"error: {kind}: nothing to draw: the ground" in run_overturning_and_return_printed_text(
            "figure", kind, dead, "-o", tmp_path / "still.svg", status=1
        )


def test_this_file_tests_the_content_check_of_every_kind_of_figure() -> None:
    assert {*NAMES_OF_OUTCOME_FIGURES, "follow", "intensity", "hodograph", "history"} == set(plot.CUBE_FIGURE_FUNCTIONS)


def test_dir_of_public_modules_shows_exactly_the_names_in_all() -> None:
    import overturning

    for module in (overturning, plot):
        assert [name for name in dir(module) if name.startswith("_") and name != "__version__"] == []
        assert set(dir(module)) - {"__version__"} == set(module.__all__)
    named = {draw.__name__ for draw in plot.CUBE_FIGURE_FUNCTIONS.values()}
    assert named | {"rotation_slip_and_uplift", "spectra"} == set(plot.__all__)
