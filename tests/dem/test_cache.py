"""Cache of compiled kernels: reuse by the next process, damaged files, edited sources, and isolation from Numba."""

import gc
import os
import runpy
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numba
import numpy as np
import pytest

from overturning import kernel_cache
from overturning.dem.kernel import queue
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.simulate import simulate_as_arrays
from overturning.kernel_cache import cache_compiled_kernel, kernel_cache_directory
from overturning.motion.motion import Motion
from tests.test_layers import imported_project_modules, source_paths_of_package_verification_and_tests


def test_a_damaged_cache_file_is_a_cache_miss(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "tiny.py").write_text("def twice(x):\n    return 2 * x\n", encoding="utf-8")
    monkeypatch.setitem(sys.modules, "tiny", ModuleType("tiny"))  # imported with a function that is loaded from a file
    caplog.set_level("DEBUG", logger="overturning")
    gc.freeze()  # what earlier tests have left need not be searched each time for the function compiled last

    def compile_and_count_cache_hits_and_misses() -> tuple[int, int]:
        """Compile and call a small kernel like a new process; return the numbers of cache hits and misses."""
        gc.collect()  # Numba would find the data of the previous function in memory
        caplog.clear()
        module = runpy.run_path(str(tmp_path / "tiny.py"), run_name="tiny")
        cached = cache_compiled_kernel(numba.njit(module["twice"]))
        assert cached(21.0) == 42.0
        return sum(cached.stats.cache_hits.values()), sum(cached.stats.cache_misses.values())

    assert compile_and_count_cache_hits_and_misses() == (0, 1)
    assert compile_and_count_cache_hits_and_misses() == (1, 0)
    assert caplog.messages == []
    for ending in ("nbc", "nbi"):
        (file,) = (tmp_path / "cache").rglob(f"*.{ending}")
        content = file.read_bytes()
        changed = bytearray(content)
        changed[len(content) // 2] ^= 1
        for damaged in (content[:100], content[:-1], b"", bytes(changed)):
            file.write_bytes(damaged)
            assert compile_and_count_cache_hits_and_misses() == (0, 1)
            assert any("compiled again" in message for message in caplog.messages)
            assert compile_and_count_cache_hits_and_misses() == (1, 0)


def test_an_inner_kernel_function_can_be_called_by_compiled_code_only() -> None:
    inner = numba.njit(**INTERNAL_COMPILE_OPTIONS)(lambda x: x + x)
    assert numba.njit(lambda x: inner(x) + 2.0)(20.0) == 42.0
    with pytest.raises(TypeError, match=r"called by compiled code only"):
        inner(21.0)


def test_importing_the_package_changes_no_setting_of_numba_or_llvm() -> None:
    """Numba's classes, options and settings, which other code compiles with, are the same before and after import."""
    program = """if True:
        import gc, sys
        import numba, numba.core.codegen, numba.core.compiler, numba.core.cpu, numba.core.dispatcher, numba.core.options
        from numba.core import base, errors, event, postproc, typed_passes, typing
        from numba.core.registry import cpu_target

        def state():
            owners = [one for name, module in sorted(sys.modules.items()) if name.startswith("numba.core") and module
                      for one in vars(module).values() if isinstance(one, type) and one.__module__ == name]
            found = {f"{one.__module__}.{one.__qualname__}.{key}": id(value)
                     for one in owners for key, value in vars(one).items() if callable(value)}
            found |= {name: value for name, value in vars(numba.config).items() if name.isupper()}
            codegen = cpu_target.target_context.codegen()
            return found | {"library": codegen._library_class, "features": codegen._tm_features, "gc": gc.isenabled()}

        numba.njit(lambda x: x + 1.0)(1.0)
        before = state()
        from overturning.dem.kernel.queue import run_case_queue
        from overturning.dem.simulate import simulate_as_arrays
        after = state()
        print([name for name in before if before[name] != after.get(name)])
    """
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    package = Path(kernel_cache.__file__).parent
    assert [path for path in package.rglob("*.py") if "set_option(" in path.read_text(encoding="utf-8")] == []


def test_a_kernel_edited_after_import_is_not_cached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    module = tmp_path / "tiny.py"
    module.write_text("def twice(x):\n    return 2 * x\n", encoding="utf-8")
    twice = cache_compiled_kernel(numba.njit(runpy.run_path(str(module))["twice"]))
    module.write_text("def twice(x):\n    return x + x + 1\n", encoding="utf-8")
    assert twice(21.0) == 42.0
    assert list((tmp_path / "cache").rglob("*.nbi")) == []


def test_a_compiled_kernel_is_written_to_the_cache_folder() -> None:
    wave = 4.0 * np.sin(0.1 * np.arange(200))
    case = {"azimuth_deg": [0.0], "height": [0.6], "b_over_h": [0.3], "friction": [1.0]}
    simulate_as_arrays(Motion(wave, 0 * wave, sampling_interval=0.01), **case)
    assert list(kernel_cache_directory().glob("*.nbi"))
    assert list(kernel_cache_directory().glob("*.nbc"))


@pytest.mark.long
def test_kernel_variants_compiled_by_different_processes_are_not_confused(tmp_path: Path) -> None:
    """Kernels with and without vertical motion are compiled by two processes; a third process loads both."""
    program = """if True:
        import sys
        import numpy as np
        from overturning.dem.simulate import simulate_as_arrays
        from overturning.motion.motion import Motion
        wave = 4.0 * np.sin(9.0 * np.arange(200) * 0.01)
        case = {"azimuth_deg": [0.0, 40.0], "height": [0.6], "b_over_h": [0.2, 0.4], "friction": [0.5]}
        for base in sys.argv[1:]:
            motion = Motion(wave, 0.5 * wave, 0.5 * wave if base == "up" else None, sampling_interval=0.01)
            found = simulate_as_arrays(motion, scheme="cundall", **case)
            print(base, found["status"].ravel(), found["peak_slip"].ravel(), found["block_steps"].sum())
    """
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}

    def printed_lines_of_program_for_base_motions(*bases: str) -> list[str]:
        """Run the Python code `program` for some base motions in a new process, and return its output lines."""
        done = subprocess.run(
            [sys.executable, "-c", program, *bases], env=environment, capture_output=True, text=True, check=True
        )
        return done.stdout.splitlines()

    assert printed_lines_of_program_for_base_motions("level") + printed_lines_of_program_for_base_motions(
        "up"
    ) == printed_lines_of_program_for_base_motions("level", "up")


def test_the_cache_folder_depends_on_all_modules_that_kernels_import() -> None:
    """A compiled-in constant of a module that is not hashed would leave a stale kernel in use."""
    for name, path in source_paths_of_package_verification_and_tests().items():
        if name.startswith("overturning.dem.") and "numba" in path.read_text(encoding="utf-8"):
            types = {"overturning.arrays", "overturning.motion.motion"}  # nothing in them is compiled
            assert {
                source_paths_of_package_verification_and_tests()[other]
                for other in imported_project_modules(name) - types
            } <= {*kernel_cache._SOURCE_PATHS_IN_KERNEL_DIGEST}, name
    assert queue.run_case_queue._cache._cache_path == str(kernel_cache_directory())
