"""Bit-equal outcomes for any number of threads, grouping, order, mirror image and instruction set."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest

from overturning.dem import run as run_module
from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.dem.trajectory import trajectory
from overturning.model.cases import Cases
from overturning.records.catalogue import read_record_table
from overturning.records.read import read_record
from overturning.records.store import write_record_to_motion_file
from tests.dem.near_field import near_field
from tests.dem.paths import stone
from tests.expect import every_or_first, lacking

NAMES = (
    "overturned", "status", "overturning_time", "peak_rotation", "peak_slip", "residual_slip", "peak_penetration",
    "energy_error", "block_steps",
)  # fmt: skip
ROOT = Path(__file__).parents[2]


def equal(left: object, right: object, rows: np.ndarray | None = None) -> None:
    for name in NAMES:
        a, b = getattr(left, name), getattr(right, name)
        np.testing.assert_array_equal(a if rows is None else a[rows], b, err_msg=name)


@pytest.fixture(scope="module")
def cases() -> Cases:
    axes = ([0.0, 40.0, 77.7, 150.0], [0.6, 1.2], np.arange(0.1, 0.61, 0.1), [0.33, 1.0])
    return Cases(*(values.ravel() for values in np.meshgrid(*axes, indexing="ij")))


def subset(cases: Cases, rows: np.ndarray) -> Cases:
    return Cases(cases.azimuth_deg[rows], cases.height[rows], cases.b_over_h[rows], cases.friction[rows])


def test_threads_order_and_subset_change_no_bit(cases: Cases, monkeypatch: pytest.MonkeyPatch) -> None:
    motion, _, _ = near_field(10)
    whole = run_cases(motion, cases)
    equal(whole, run_cases(motion, cases, threads=2))
    order = np.random.default_rng(1).permutation(cases.case_count)
    equal(whole, run_cases(motion, subset(cases, order)), order)
    some = order[:17]
    equal(whole, run_cases(motion, subset(cases, some)), some)
    monkeypatch.setattr(run_module, "MAX_QUEUE_LENGTH", 3)
    equal(whole, run_cases(motion, cases))


def test_a_trajectory_is_bit_equal_to_its_cell() -> None:
    motion, _, _ = near_field(10)
    cell = {"azimuth_deg": 32.0, "height": 0.6, "b_over_h": 0.35, "friction": 0.58}
    found = simulate_as_arrays(motion, **{name: [value] for name, value in cell.items()})
    path = trajectory(motion, **cell)
    assert float(stone(path)["peak_rotation"]) == found["peak_rotation"].item()
    assert int(stone(path)["overturned"]) == found["overturned"].item()
    assert path.attrs["block_steps"] == found["block_steps"].item()
    largest = np.abs(stone(path).rotation.values).max() / np.arctan(0.35)
    assert (
        0.9 * float(stone(path)["peak_rotation"])
        < largest
        <= max(float(stone(path)["peak_rotation"]), 0.5 * np.pi / np.arctan(0.35)) * 1.2
    )


@pytest.mark.parametrize("vertical", [False, True])
def test_the_mirrored_half_of_the_azimuths_is_exact(vertical: bool) -> None:
    motion, _, _ = near_field(7)
    if vertical:
        motion = type(motion)(motion.north, motion.east, 0.4 * motion.north, sampling_interval=motion.sampling_interval)
    grid = {"height": [0.6], "b_over_h": [0.1, 0.25, 0.4], "friction": [0.33, 1.0]}
    azimuths = np.arange(0.0, 360.0, 15.0)
    mirrored = simulate_as_arrays(motion, azimuth_deg=azimuths, **grid)
    every = {}
    for azimuth in azimuths:
        for name, values in simulate_as_arrays(motion, azimuth_deg=[azimuth], **grid).items():
            every.setdefault(name, []).append(values)
    assert mirrored["mirrored"].any()
    assert (mirrored["overturned"] != 0).any()
    for name in NAMES[:-1]:
        np.testing.assert_array_equal(mirrored[name], np.concatenate(every[name]), err_msg=name)


# NumPy has its own code for each instruction set, with other last digits of exponentials and logarithms.
NUMPY_SETS = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
SSE2 = {
    "NUMBA_CPU_NAME": "x86-64", "NUMBA_CPU_FEATURES": "+sse2", "NPY_DISABLE_CPU_FEATURES": " ".join(NUMPY_SETS)
}  # fmt: skip
AVX2 = {
    "NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": "",
    "NPY_DISABLE_CPU_FEATURES": " ".join(name for name in NUMPY_SETS if "512" in name or name == "X86_V4"),
}  # fmt: skip
# Environment variables and number of threads by target; "host" uses the widest instruction set of the machine.
TARGETS = {
    "host": ({}, 2),
    "sse2, without fma": ({"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-AVX2", **SSE2}, 1),
    "avx2": (AVX2, 1),
}


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the motion that each target simulates."""
    folder = tmp_path_factory.mktemp("bits")
    motion, _, _ = near_field(10)
    part = slice(100, 500)
    np.savez(folder / "motion.npz", north=motion.north[part], east=motion.east[part], interval=motion.sampling_interval)
    write_record_to_motion_file(
        read_record(read_record_table(ROOT / "config" / "records.tsv")["rinaldi"], ROOT), folder / "motion.nc"
    )
    return folder


def hashes(stored: Path, target: str) -> str:
    variables, threads = TARGETS[target]
    inputs = [str(stored / "motion.npz"), str(stored / "motion.nc")]
    command = [sys.executable, "-m", "tests.dem.bits", *inputs, str(threads), str(stored / target / "cube")]
    done = subprocess.run(command, cwd=ROOT, env=os.environ | variables, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.fixture(scope="module")
def nominal(stored: Path) -> str:
    return hashes(stored, "host")


@pytest.mark.long
@pytest.mark.parametrize("target", every_or_first(list(TARGETS)[1:]))
def test_same_bits_for_each_instruction_set(target: str, stored: Path, nominal: str) -> None:
    if platform.machine() not in ("x86_64", "AMD64"):
        lacking("not an x86-64 processor")
    if target != "avx2" or llvm.get_host_cpu_features().get("avx2"):
        assert hashes(stored, target) == nominal
