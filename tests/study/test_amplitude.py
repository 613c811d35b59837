"""Several factors on a motion: a dimension of the cube, whose cells are those of the motion times each factor."""

from pathlib import Path

import numpy as np
import pytest

from overturning.dem.simulate import simulate
from overturning.errors import ConfigError, ResultError
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.records.store import rounded, write_motion
from overturning.study.convergence import read_sample
from overturning.study.cube import open_cube
from overturning.study.gather import gather
from overturning.study.load import check_study
from overturning.study.recheck import recheck
from overturning.study.scenes import numerics_of
from overturning.study.sections import Verification
from overturning.study.sweep import sweep_record

SMALL = {
    "name": "small", "records": {"use": ["a"]}, "azimuth": {"step": 45}, "b_over_h": [0.15, 0.25, 0.4],
    "friction": [0.7],
    "ensemble": {"members": 8},
}  # fmt: skip
PULSE = 4.0 * np.sin(2 * np.pi * np.arange(101) / 100)
RECORD = rounded(Record("a", PULSE, 0.3 * PULSE, None, 0.01))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("cubes")
    write_motion(RECORD, made / "motion" / "a.nc")
    for name, more in (("one", {}), ("three", {"amplitude": [0.5, 1, 2]})):
        study = check_study(SMALL | more, "test")
        told: list[float] = []
        numerics = numerics_of(study, progress=lambda done, whole, told=told: told.append(done / whole))
        sweep_record(study, RECORD, made / f"{name}-part.nc", numerics=numerics)
        # It never goes back, whichever factor it is at, and ends at the whole.
        assert told == sorted(told)
        assert told[-1] == pytest.approx(1.0)
        gather(study, [RECORD], [made / f"{name}-part.nc"], made / f"{name}.nc")
    return made


def test_as_recorded_it_is_the_cube_without_the_axis(folder: Path) -> None:
    with open_cube(folder / "one.nc") as one, open_cube(folder / "three.nc") as three:
        assert set(one.data_vars) == set(three.data_vars)
        for name in one.data_vars:
            np.testing.assert_array_equal(one[name], three[name])
        assert (three["members"] > 0).any()


def test_each_factor_is_the_motion_times_it(folder: Path) -> None:
    motion = Motion.of(RECORD)
    with open_cube(folder / "three.nc", amplitude=None) as cube:
        assert cube["overturned"].dims == ("record", "amplitude", "azimuth", "height", "b_over_h", "friction")
        shares = []
        for factor in (0.5, 2.0):
            own = cube.sel(amplitude=factor).isel(record=0)
            again = simulate(
                motion.times(factor),
                azimuth_deg=own["azimuth"].values,
                height=[0.6],
                b_over_h=SMALL["b_over_h"],
                friction=[0.7],
            )
            for name in ("overturned", "peak_rotation", "residual_slip"):
                np.testing.assert_array_equal(own[name], again[name])
            assert (own["members"] == 0).all()
            assert np.isnan(own["probability_towards"]).all()
            shares.append(float(np.abs(own["overturned"]).mean()))
        assert shares[0] < shares[1]


def test_a_recheck_finds_every_factor_the_same_and_a_sample_is_as_recorded(folder: Path) -> None:
    found = recheck(folder / "three.nc", cells=72)
    assert (found.of, found.cells, found.same) == (72, 72, True)
    samples = [read_sample(folder / f"{name}.nc", Verification(at_least=12)) for name in ("one", "three")]
    np.testing.assert_array_equal(*(sample.answers["overturned"] for sample in samples))


def test_the_record_itself_and_a_known_factor_are_needed(folder: Path) -> None:
    with pytest.raises(ConfigError, match="1 is missing"):
        check_study(SMALL | {"amplitude": [0.5, 2]}, "test")
    with pytest.raises(ResultError, match=r"no amplitude 3; known: 0.5, 1, 2"):
        open_cube(folder / "three.nc", amplitude=3.0)
    other = check_study(SMALL | {"amplitude": [1, 3]}, "test")
    with pytest.raises(ResultError, match="factors on the motion"):
        gather(other, [RECORD], [folder / "three-part.nc"], folder / "none.nc")
