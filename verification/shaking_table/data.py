"""Shaking-table tests: measured motion, record that was played, and outcome of each specimen."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

TESTS_SOURCE: Final = (
    "github.com/ZhiangChen/virtual_shake_robot_pybullet, commit 9f239e7e21280702be9ba7a40ed9b47a35868a52, folder "
    "data/Shake_Table_Response"
)
TESTS_FILE_NAME: Final = "tests.npz"
SPECIMEN_NUMBERS: Final = (1, 2)
_ARRAY_NAMES: Final = (
    "acceleration", "scale", "start", "sampling_interval", "test", "motion", "pga_g", "pgv", "overturned_1",
    "overturned_2",
)  # fmt: skip


@dataclass(frozen=True)
class ShakingTableTests:
    """Shaking-table tests of both specimens; arrays have one entry per test."""

    __test__ = False  # tell pytest that this class is not a test case

    laboratory_test_numbers: NDArray[np.int64]  # as numbered by the laboratory
    played_record_names: NDArray[np.str_]
    """Record that was played, without its component. Tests of one record are not independent."""
    accelerations: list[FloatArray]
    """Measured acceleration along the axis of the table in each test, m/s²."""
    sampling_interval: float  # s
    measured_pga: FloatArray  # of the measured motion, m/s²
    measured_pgv: FloatArray  # of the measured motion, m/s
    fell_by_specimen: dict[int, NDArray[np.bool_]]
    """True where a specimen fell, by specimen."""

    def measured_motion(self, test_index: int) -> Motion:
        """Return the measured ground motion of one test, towards azimuth 0."""
        along = self.accelerations[test_index]
        return Motion(along, np.zeros_like(along), sampling_interval=self.sampling_interval)


def read_shaking_table_tests(folder: Path) -> ShakingTableTests:
    """Read the shaking-table tests from a folder.

    Raises
    ------
    ResultError
        If the file or one of its arrays is missing.
    """
    path = folder / TESTS_FILE_NAME
    if not path.is_file():
        raise ResultError(f"{folder}: no {TESTS_FILE_NAME}; for its contents and source see docs/shaking-table.md")
    with np.load(path, allow_pickle=False) as stored:
        missing = [name for name in _ARRAY_NAMES if name not in stored]
        if missing:
            raise ResultError(f"{path}: no array {missing[0]!r}; docs/shaking-table.md lists the arrays")
        data = {name: stored[name] for name in _ARRAY_NAMES}
    start = data["start"]
    samples = data["acceleration"].astype(np.float64) * float(data["scale"])
    # RSN1234_NAME_COMPONENT: both components of a record are predicted together.
    record = np.array([str(name).split("_")[0] for name in data["motion"]])
    return ShakingTableTests(
        laboratory_test_numbers=data["test"].astype(np.int64),
        played_record_names=record,
        accelerations=[samples[first:end] for first, end in pairwise(start)],
        sampling_interval=float(data["sampling_interval"]),
        measured_pga=data["pga_g"].astype(np.float64) * STANDARD_GRAVITY,
        measured_pgv=data["pgv"].astype(np.float64),
        fell_by_specimen={one: data[f"overturned_{one}"] == 1 for one in SPECIMEN_NUMBERS},
    )
