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
from tests.dem.near_field import near_field_motion_and_fault_component_azimuths
from tests.dem.paths import trajectory_of_element_named_stone
from tests.expect import other_instruction_sets_to_compile_for, skip_test_unless_skipping_is_forbidden

COMPARED_RESULTS = (
    "overturned", "status", "overturning_time", "peak_rotation", "peak_slip", "residual_slip", "peak_penetration",
    "energy_error", "block_steps",
)  # fmt: skip
REPOSITORY = Path(__file__).parents[2]


def assert_bit_equal(left: object, right: object, rows: np.ndarray | None = None) -> None:
    """Assert that two results have the same bits; `rows` selects cases of `left`."""
    for name in COMPARED_RESULTS:
        a, b = getattr(left, name), getattr(right, name)
        np.testing.assert_array_equal(a if rows is None else a[rows], b, err_msg=name)


@pytest.fixture(scope="module")
def cases_of_small_block_grid() -> Cases:
    """Provide cases of blocks over a small grid."""
    axes = ([0.0, 40.0, 77.7, 150.0], [0.6, 1.2], np.arange(0.1, 0.61, 0.1), [0.33, 1.0])
    return Cases(*(values.ravel() for values in np.meshgrid(*axes, indexing="ij")))


def select_cases(cases: Cases, rows: np.ndarray) -> Cases:
    """Return the cases at given indices."""
    return Cases(cases.azimuth_deg[rows], cases.height[rows], cases.b_over_h[rows], cases.friction[rows])


def test_threads_order_and_subset_of_cases_change_no_bit(
    cases_of_small_block_grid: Cases, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion, _, _ = near_field_motion_and_fault_component_azimuths(10)
    whole = run_cases(motion, cases_of_small_block_grid)
    assert_bit_equal(whole, run_cases(motion, cases_of_small_block_grid, threads=2))
    order = np.random.default_rng(1).permutation(cases_of_small_block_grid.case_count)
    assert_bit_equal(whole, run_cases(motion, select_cases(cases_of_small_block_grid, order)), order)
    some = order[:17]
    assert_bit_equal(whole, run_cases(motion, select_cases(cases_of_small_block_grid, some)), some)
    monkeypatch.setattr(run_module, "MAX_CASES_PER_KERNEL_CALL", 3)
    assert_bit_equal(whole, run_cases(motion, cases_of_small_block_grid))


def test_a_trajectory_is_bit_equal_to_the_same_case_of_a_grid() -> None:
    motion, _, _ = near_field_motion_and_fault_component_azimuths(10)
    cell = {"azimuth_deg": 32.0, "height": 0.6, "b_over_h": 0.35, "friction": 0.58}
    found = simulate_as_arrays(motion, **{name: [value] for name, value in cell.items()})
    path = trajectory(motion, **cell)
    assert float(trajectory_of_element_named_stone(path)["peak_rotation"]) == found["peak_rotation"].item()
    assert int(trajectory_of_element_named_stone(path)["overturned"]) == found["overturned"].item()
    assert path.attrs["block_steps"] == found["block_steps"].item()
    largest = np.abs(trajectory_of_element_named_stone(path).rotation.values).max() / np.arctan(0.35)
    assert (
        0.9 * float(trajectory_of_element_named_stone(path)["peak_rotation"])
        < largest
        <= max(float(trajectory_of_element_named_stone(path)["peak_rotation"]), 0.5 * np.pi / np.arctan(0.35)) * 1.2
    )


@pytest.mark.parametrize("vertical", [False, True])
def test_azimuths_filled_by_mirroring_are_bit_equal_to_simulated_ones(vertical: bool) -> None:
    motion, _, _ = near_field_motion_and_fault_component_azimuths(7)
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
    for name in COMPARED_RESULTS[:-1]:
        np.testing.assert_array_equal(mirrored[name], np.concatenate(every[name]), err_msg=name)


# NumPy has its own code for each instruction set, with other last digits of exponentials and logarithms.
NUMPY_INSTRUCTION_SETS = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
SSE2_ENVIRONMENT_VARIABLES = {
    "NUMBA_CPU_NAME": "x86-64",
    "NUMBA_CPU_FEATURES": "+sse2",
    "NPY_DISABLE_CPU_FEATURES": " ".join(NUMPY_INSTRUCTION_SETS),
}
AVX2_ENVIRONMENT_VARIABLES = {
    "NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": "",
    "NPY_DISABLE_CPU_FEATURES": " ".join(name for name in NUMPY_INSTRUCTION_SETS if "512" in name or name == "X86_V4"),
}  # fmt: skip
# Environment variables and number of threads by target; "host" uses the widest instruction set of the machine.
ENVIRONMENT_AND_THREADS_BY_PROCESSOR = {
    "host": ({}, 2),
    "sse2, without fma": ({"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-AVX2", **SSE2_ENVIRONMENT_VARIABLES}, 1),
    "avx2": (AVX2_ENVIRONMENT_VARIABLES, 1),
}


@pytest.fixture(scope="module")
def folder_of_motions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Provide a folder with two motions, .npz and .nc, that are simulated for each target processor."""
    folder = tmp_path_factory.mktemp("bits")
    motion, _, _ = near_field_motion_and_fault_component_azimuths(10)
    part = slice(100, 500)
    np.savez(folder / "motion.npz", north=motion.north[part], east=motion.east[part], interval=motion.sampling_interval)
    write_record_to_motion_file(
        read_record(read_record_table(REPOSITORY / "config" / "records.tsv")["rinaldi"], REPOSITORY),
        folder / "motion.nc",
    )
    return folder


def outcome_hashes_for_target_processor(folder_of_motions: Path, target: str) -> str:
    """Return the hashes that `tests.dem.bits` prints in a process with the settings of a target processor."""
    variables, threads = ENVIRONMENT_AND_THREADS_BY_PROCESSOR[target]
    inputs = [str(folder_of_motions / "motion.npz"), str(folder_of_motions / "motion.nc")]
    command = [sys.executable, "-m", "tests.dem.bits", *inputs, str(threads), str(folder_of_motions / target / "cube")]
    done = subprocess.run(
        command, cwd=REPOSITORY, env=os.environ | variables, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.fixture(scope="module")
def outcome_hashes_of_host(folder_of_motions: Path) -> str:
    """Provide the hashes of outcomes for this machine's processor."""
    return outcome_hashes_for_target_processor(folder_of_motions, "host")


@pytest.mark.long
@pytest.mark.parametrize(
    "target", other_instruction_sets_to_compile_for(list(ENVIRONMENT_AND_THREADS_BY_PROCESSOR)[1:])
)
def test_outcomes_have_the_same_bits_for_each_instruction_set(
    target: str, folder_of_motions: Path, outcome_hashes_of_host: str
) -> None:
    if platform.machine() not in ("x86_64", "AMD64"):
        skip_test_unless_skipping_is_forbidden("not an x86-64 processor")
    if target != "avx2" or llvm.get_host_cpu_features().get("avx2"):
        assert outcome_hashes_for_target_processor(folder_of_motions, target) == outcome_hashes_of_host
