"""`run_cases`: amplitudes, initial tilts, progress, free flight, the kernel cache, and imports."""

import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np

from overturning.dem.run import run_cases
from overturning.kernel_cache import kernel_cache_directory, sources_digest
from overturning.model.cases import Cases
from overturning.motion.motion import Motion

TIME = np.arange(400) * 0.01
SINE_CYCLES = np.sin(2 * np.pi * TIME / 0.9) * (TIME < 1.8)


def test_amplitude_is_a_factor_on_the_motion() -> None:
    once = run_cases(
        Motion(4.0 * SINE_CYCLES, 0 * TIME, 1.0 * SINE_CYCLES, sampling_interval=0.01), Cases(0.0, 0.6, [0.2, 0.3], 0.5)
    )
    half = Motion(2.0 * SINE_CYCLES, 0 * TIME, 0.5 * SINE_CYCLES, sampling_interval=0.01)
    twice = run_cases(half, Cases(0.0, 0.6, [0.2, 0.3], 0.5, amplitude=2.0))
    assert once.peak_rotation.max() > 0.05
    np.testing.assert_array_equal(once.peak_rotation, twice.peak_rotation)
    np.testing.assert_array_equal(once.overturned, twice.overturned)


def test_the_damping_factor_of_a_case_changes_its_peak_rotation() -> None:
    motion = Motion(4.0 * SINE_CYCLES, 0 * TIME, sampling_interval=0.01)
    found = run_cases(motion, Cases(0.0, 0.6, 0.39, 1.0, damping_factor=[1.0, 0.05]))
    assert found.peak_rotation[0] != found.peak_rotation[1]


def test_opposite_initial_tilts_give_equal_peak_rotation_and_opposite_slip() -> None:
    still = Motion(0 * TIME, 0 * TIME, sampling_interval=0.01)
    found = run_cases(still, Cases(0.0, 0.6, 0.3, 1.0, initial_tilt=[0.1, -0.1]))
    np.testing.assert_allclose(found.peak_rotation, 0.1 / np.arctan(0.3), rtol=1e-6)
    assert found.residual_slip[0] == -found.residual_slip[1]


def test_a_block_stands_and_its_energy_balances_after_free_flight() -> None:
    up = np.where(TIME < 0.3, -1.5 * 9.80665, 0.0)
    found = run_cases(Motion(0 * TIME, 0 * TIME, up, sampling_interval=0.01), Cases(0.0, 0.6, 0.8, 1.0))
    assert found.status.tolist() == [0]
    assert found.overturned.tolist() == [0]
    assert found.energy_error[0] < 1e-2


def test_reported_progress_never_decreases_and_ends_at_the_total_steps() -> None:
    calls: list[tuple[int, int]] = []
    found = run_cases(
        Motion(4.0 * SINE_CYCLES, 0 * TIME, sampling_interval=0.01), Cases(0.0, 0.6, np.linspace(0.1, 0.5, 50), 0.5),
        progress=lambda done, total: calls.append((done, total)),
    )  # fmt: skip
    assert calls[-1][0] == calls[-1][1] >= found.block_steps.sum(), "steps of cases that end early count as done"
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)
    assert found.block_steps.sum() > 0


def test_the_digest_for_the_cache_folder_changes_with_the_source_code(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text("from numba import njit")
    before = sources_digest(tmp_path)
    (tmp_path / "a.py").write_text("from numba import njit, prange")
    assert sources_digest(tmp_path) != before
    assert kernel_cache_directory().name.startswith("overturning-")


def test_a_simulation_with_cached_kernels_imports_no_expensive_module() -> None:
    """With a cached kernel, modules for compilation, figures and dask are not imported."""
    program = """if True:
        import sys
        import numpy as np
        import overturning
        from overturning.dem.simulate import simulate_as_arrays
        wave = 4.0 * np.sin(0.1 * np.arange(200))
        motion = overturning.Motion(wave, 0.0 * wave, sampling_interval=0.01)
        case = {"azimuth_deg": 0.0, "height": 0.6, "b_over_h": 0.3, "friction": 1.0}
        simulate_as_arrays(motion, **case)
        in_a_sweep = {*sys.modules}
        overturning.simulate(motion, **case)
        overturning.trajectory(motion, **case)
        heavy = {"scipy.linalg", "scipy.spatial", "scipy.signal", "scipy.optimize", "matplotlib", "dask.array"}
        print(*sorted(heavy & {*sys.modules} | {"xarray", "pandas"} & in_a_sweep))
    """
    run = partial(subprocess.run, [sys.executable, "-c", program], capture_output=True, text=True, check=True)
    found = run().stdout.strip()
    if found:  # the modules that compiled the kernels
        found = run().stdout.strip()
    assert found == ""
