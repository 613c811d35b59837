"""A missing flag is NaN in all datasets that a user gets, from a cube and without one."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import overturning
from overturning.figures.film_of_trajectory import film_of_trajectories, outcome_sentence
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion

SINE_MOTION = Motion.sine(6.0, 0.8)
# The wall's face is at 0.22 m, so that a stone of 0.6 m overlaps it at rest from B/H = 0.7333 on.
SIZES_AND_FRICTION = {"height": [0.6], "b_over_h": [0.2, 0.3, 0.75, 0.9], "friction": [1.0]}
AZIMUTHS = np.arange(0.0, 360.0, 45.0)


@pytest.fixture(scope="module")
def simulated_and_saved_outcomes(tmp_path_factory: pytest.TempPathFactory) -> tuple[xr.Dataset, xr.Dataset]:
    """Outcomes of the same cases, as returned by `simulate` and as read from the saved cube of a study."""
    own = overturning.simulate(
        SINE_MOTION, overturning.load_scene("against-a-wall"), azimuth_deg=AZIMUTHS, **SIZES_AND_FRICTION
    )
    keys: dict[str, Any] = {**SIZES_AND_FRICTION}
    path: Path = tmp_path_factory.mktemp("study") / "cube.nc"
    overturning.run_study(
        [SINE_MOTION], scene="against-a-wall", azimuth={"step": 45}, ensemble={"members": 0}, **keys
    ).to_netcdf(path)
    with overturning.open_cube(path) as cube:
        return own, cube.isel(record=0).load()


def test_flags_of_cases_without_outcome_are_nan_in_simulations_and_cubes(
    simulated_and_saved_outcomes: tuple[xr.Dataset, xr.Dataset],
) -> None:
    own, cube = simulated_and_saved_outcomes
    overlaps = np.broadcast_to(
        np.array(SIZES_AND_FRICTION["b_over_h"])[:, None] > 2 * 0.22 / 0.6, own["overturned"].shape
    )
    for dataset in (own, cube):
        np.testing.assert_array_equal(dataset["overturned"].isnull(), overlaps)
    for name in own.data_vars:
        assert own[name].dtype == cube[name].dtype == np.float32, name
        np.testing.assert_array_equal(own[name], cube[name], err_msg=str(name))
    assert own["overturned"].isel(azimuth=0, height=0, friction=0).to_numpy().tolist()[0] == -1


def test_means_over_a_cube_count_only_cases_with_an_outcome(
    simulated_and_saved_outcomes: tuple[xr.Dataset, xr.Dataset],
) -> None:
    own, cube = simulated_and_saved_outcomes
    known = own["overturned"].sel(b_over_h=[0.2, 0.3]).to_numpy()
    share = float(np.count_nonzero(known)) / known.size
    assert 0.5 < share < 1.0
    for dataset in (own, cube):
        assert float(abs(dataset["overturned"]).mean()) == pytest.approx(share)
    # Half of all cells has no outcome, and `!= 0` counts them as fallen.
    assert float((own["overturned"] != 0).mean()) == pytest.approx(0.5 + share / 2)


def test_a_simulated_dataset_is_equal_after_saving_and_opening(
    simulated_and_saved_outcomes: tuple[xr.Dataset, xr.Dataset], tmp_path: Path
) -> None:
    own = simulated_and_saved_outcomes[0]
    own.to_netcdf(tmp_path / "outcome.nc")
    with xr.open_dataset(tmp_path / "outcome.nc", decode_timedelta=False) as again:
        assert again.equals(own)
    table = overturning.to_dataframe(own)
    assert table["overturned"].isna().sum() == own["overturned"].size // 2


@pytest.mark.parametrize("model", [None, "three-tier", "rectangle"])
def test_a_case_that_exceeds_its_step_budget_is_nan(model: str | None) -> None:
    made = overturning.load_scene(model) if model == "three-tier" else model
    direction = "orientation_deg" if model == "rectangle" else "azimuth_deg"
    motion = Motion(SINE_MOTION.north, SINE_MOTION.north, sampling_interval=SINE_MOTION.sampling_interval)
    case = {direction: 30.0, "height": 0.636, "b_over_h": 0.38}
    cell = overturning.simulate(motion, made, **case, budget=200)
    path = overturning.trajectory(motion, made, **case, budget=200)
    for found in (cell, path):
        assert (found["status"] == CaseStatus.OVER_BUDGET).all()
        assert found["overturned"].isnull().all()
        assert np.isnan(float(abs(found["overturned"]).mean()))
    assert path["overturned"].dtype == path["status"].dtype == np.float32
    assert outcome_sentence(path) == "no outcome: needs more steps than a case may take"
    assert film_of_trajectories([path], motion, "over its budget").panels
