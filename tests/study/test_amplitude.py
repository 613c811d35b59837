"""Several factors on a motion: a dimension of the cube, whose cells are those of the motion times each factor."""

from pathlib import Path

import numpy as np
import pytest

import overturning
from overturning import plot
from overturning.dem.simulate import simulate
from overturning.errors import MissingDataError, ResultError
from overturning.motion.motion import Motion
from overturning.study.cube import open_cube
from overturning.study.gather import merge_outcome_files_into_cube
from overturning.study.intensity import write_intensity_measures
from overturning.study.load import study_from_content
from overturning.study.recheck import recompute_and_compare_random_cases
from overturning.study.sample import read_random_case_sample
from overturning.study.scenes import numerical_options_of_study
from overturning.study.sections import ConvergenceCheckSettings
from overturning.study.sweep import simulate_and_write_cases_of_record
from tests.expect import expect_error
from tests.study.small_study import simulate_study_cube, sine_cycle_record

SMALL_STUDY = {
    "name": "small", "records": {"use": ["a"]}, "azimuth": {"step": 45}, "b_over_h": [0.15, 0.25, 0.4],
    "friction": [0.7],
    "ensemble": {"members": 8},
}  # fmt: skip
RECORD = sine_cycle_record("a", 4.0)


@pytest.fixture(scope="module")
def cube_paths_without_and_with_amplitude_factors(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Paths of the cubes of a study without amplitude factors (``one``) and with three of them (``three``)."""
    folder = tmp_path_factory.mktemp("cubes")
    several = {"one": {}, "three": {"amplitude": [0.5, 1, 2]}}
    return {
        name: simulate_study_cube(study_from_content(SMALL_STUDY | more, name), [RECORD], folder / name)
        for name, more in several.items()
    }


def test_progress_of_a_sweep_increases_to_the_total_over_all_amplitude_factors(tmp_path: Path) -> None:
    told: list[float] = []
    settings = study_from_content(SMALL_STUDY | {"amplitude": [0.5, 1, 2]}, "test")
    numerics = numerical_options_of_study(settings, progress=lambda done, whole: told.append(done / whole))
    simulate_and_write_cases_of_record(settings, RECORD, tmp_path / "part.nc", numerics=numerics)
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1.0)


def test_amplitude_factor_1_gives_the_cube_without_the_amplitude_axis(
    cube_paths_without_and_with_amplitude_factors: dict[str, Path],
) -> None:
    with (
        open_cube(cube_paths_without_and_with_amplitude_factors["one"]) as one,
        open_cube(cube_paths_without_and_with_amplitude_factors["three"]) as three,
    ):
        assert set(one.data_vars) == set(three.data_vars)
        for name in one.data_vars:
            np.testing.assert_array_equal(one[name], three[name])
        assert (three["members"] > 0).any()


def test_each_amplitude_factor_multiplies_the_motion(
    cube_paths_without_and_with_amplitude_factors: dict[str, Path],
) -> None:
    motion = Motion.of(RECORD)
    with open_cube(cube_paths_without_and_with_amplitude_factors["three"], amplitude=None) as cube:
        assert cube["overturned"].dims == ("record", "amplitude", "azimuth", "height", "b_over_h", "friction")
        shares = []
        for factor in (0.5, 2.0):
            own = cube.sel(amplitude=factor).isel(record=0)
            again = simulate(
                motion.scaled_by(factor),
                azimuth_deg=own["azimuth"].values,
                height=[0.6],
                b_over_h=SMALL_STUDY["b_over_h"],
                friction=[0.7],
            )
            for name in ("overturned", "peak_rotation", "residual_slip"):
                np.testing.assert_array_equal(own[name], again[name])
            assert (own["members"] == 0).all()
            assert np.isnan(own["probability_towards"]).all()
            shares.append(float(np.abs(own["overturned"]).mean()))
        assert shares[0] < shares[1]


def test_recomputed_cases_equal_the_cube_at_all_amplitude_factors(
    cube_paths_without_and_with_amplitude_factors: dict[str, Path],
) -> None:
    found = recompute_and_compare_random_cases(
        cube_paths_without_and_with_amplitude_factors["three"], max_random_case_count=72
    )
    assert (found.cube_cell_count, found.recomputed_cell_count, found.values_are_identical_and_hash_is_correct) == (
        72,
        72,
        True,
    )
    samples = [
        read_random_case_sample(
            cube_paths_without_and_with_amplitude_factors[name], ConvergenceCheckSettings(at_least=12)
        )
        for name in ("one", "three")
    ]
    np.testing.assert_array_equal(*(sample.study_outcomes["overturned"] for sample in samples))


def test_an_unknown_amplitude_factor_is_refused(cube_paths_without_and_with_amplitude_factors: dict[str, Path]) -> None:
    with pytest.raises(ResultError, match=r"no amplitude 3; known: 0.5, 1, 2"):
        open_cube(cube_paths_without_and_with_amplitude_factors["three"], amplitude=3.0)
    other, parts = (
        study_from_content(SMALL_STUDY | {"amplitude": [1, 3]}, "test"),
        cube_paths_without_and_with_amplitude_factors["three"].parent / "sweep" / "nominal",
    )
    with pytest.raises(ResultError, match="its amplitude values are not those of the study"):
        merge_outcome_files_into_cube(
            other,
            [RECORD],
            list(parts.iterdir()),
            cube_paths_without_and_with_amplitude_factors["three"].with_name("none.nc"),
        )


def test_figures_for_scaled_motion_state_the_factor_and_use_no_unscaled_pga(
    cube_paths_without_and_with_amplitude_factors: dict[str, Path],
) -> None:
    """Regression: falls under twice the record were plotted at the PGA of the record itself."""
    path = cube_paths_without_and_with_amplitude_factors["three"]
    write_intensity_measures(study_from_content(SMALL_STUDY, "test"), [RECORD], path.with_name("intensity.nc"))
    with overturning.open_cube(path, amplitude=2.0) as twice, overturning.open_cube(path) as once:
        of_twice, of_once = (plot.fall_map(cube) for cube in (twice, once))
        titles = [figure.get_suptitle() for figure in (of_twice, of_once)]
        assert ["motion × 2" in title for title in titles] == [True, False]
        assert titles[0].replace(", motion × 2", "") == titles[1]
        # The ensemble is run for the record as it is: of twice the record there is no probability, nor a bar for one.
        assert len(of_once.axes) == len(of_twice.axes) + 1
        for draw in (
            plot.outcomes_by_pga_and_pgv_ratio,
            plot.pga_and_pgv_by_azimuth,
            plot.hodograph,
            plot.time_histories,
        ):
            with expect_error(MissingDataError, "only for the factor 1, not 2", brief=True):
                draw(twice)
        assert set(overturning.to_dataframe(twice)["amplitude"]) == {2.0}
        assert "amplitude" not in overturning.to_dataframe(once)
        (point, *_) = plot.outcomes_by_pga_and_pgv_ratio(once).axes[0].collections
        assert point.get_offsets()[:, 0].max() <= 100 * np.hypot(RECORD.north, RECORD.east).max()
