"""Cases on a dask cluster of two processes: bit-equal to one process, also if a worker is killed."""

import os
import signal
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

import overturning
from overturning.dem.simulate import simulate_as_arrays
from overturning.errors import ArgumentError

if TYPE_CHECKING:
    from distributed import Client

pytestmark = pytest.mark.long

MOTION = overturning.Motion.sine(amplitude=5.0, period=0.8, azimuth_deg=60)


@pytest.fixture(scope="module")
def dask_client() -> Iterator["Client"]:
    """Provide a dask client with two worker processes."""
    from distributed import Client, LocalCluster  # half a second that collection need not wait

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster,
        Client(cluster) as client,
    ):
        yield client


def cases_over_azimuth_and_b_over_h() -> overturning.Cases:
    """Return 2040 cases: blocks of 17 slendernesses in 120 azimuths."""
    azimuth, ratio = (grid.ravel() for grid in np.meshgrid(np.arange(0.0, 360.0, 3.0), np.linspace(0.1, 0.5, 17)))
    return overturning.Cases(azimuth, 0.6, ratio, 0.7)


def test_a_sweep_on_a_cluster_is_bit_equal_to_one_in_a_single_process(dask_client: "Client") -> None:
    grid = {"azimuth_deg": range(0, 360, 2), "height": [0.6, 1.0], "b_over_h": [0.2, 0.3, 0.4], "friction": [0.5, 1.0]}
    alone, spread = (overturning.simulate(MOTION, **grid, client=each) for each in (None, dask_client))
    assert spread.identical(alone)
    space = {"orientation_deg": range(0, 90, 5), "height": [0.6], "b_over_h": [0.2, 0.3], "friction": [0.6]}
    one, two = (simulate_as_arrays(MOTION, "rectangle", **space, client=each) for each in (None, dask_client))
    for name, values in one.items():
        np.testing.assert_array_equal(two[name], values)


def test_a_killed_worker_loses_no_result(dask_client: "Client") -> None:
    killed = []

    def kill_worker_once(done: int, total: int) -> None:
        """Kill one worker when the first cases are finished."""
        if not killed:
            assert done < total, "the worker was killed too late: no tasks were left"
            killed.append(next(iter(dask_client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    spread = overturning.run_cases(
        MOTION, cases_over_azimuth_and_b_over_h(), client=dask_client, progress=kill_worker_once
    )
    alone = overturning.run_cases(MOTION, cases_over_azimuth_and_b_over_h())
    assert killed
    for name, values in vars(alone).items():
        np.testing.assert_array_equal(getattr(spread, name), values)


def test_an_error_on_a_worker_is_raised_locally(dask_client: "Client") -> None:
    with pytest.raises(ArgumentError, match="time_step"):
        overturning.run_cases(MOTION, cases_over_azimuth_and_b_over_h(), client=dask_client, time_step=-1.0)
    with pytest.raises(ArgumentError, match=r"client: str; give a dask.distributed.Client\(\)"):
        overturning.run_cases(MOTION, cases_over_azimuth_and_b_over_h(), client="here")
