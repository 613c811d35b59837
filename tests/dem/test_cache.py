"""Compiled kernels are kept for the next process, and a torn file of theirs is a miss."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.postproc import PostProcessor

from overturning.dem.kernel import cache, compiling, queue
from overturning.dem.kernel.cache import cache_directory, keep_compiled
from overturning.dem.kernel.compiling import without_unused_work
from overturning.dem.kernel.lanes import INNER
from overturning.dem.simulate import simulate_arrays
from overturning.motion.motion import Motion
from tests.test_layers import imports, modules


def test_a_damaged_cache_file_is_a_miss(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "tiny.py").write_text("def twice(x):\n    return 2 * x\n", encoding="utf-8")

    def compiled() -> tuple[int, int]:
        """Compile anew what a fresh process would, and tell how often the cache had it and how often not."""
        kept = keep_compiled(numba.njit(runpy.run_path(str(tmp_path / "tiny.py"))["twice"]))
        assert kept(21.0) == 42.0
        return sum(kept.stats.cache_hits.values()), sum(kept.stats.cache_misses.values())

    assert compiled() == (0, 1)
    assert compiled() == (1, 0)
    for ending in ("nbc", "nbi"):
        (torn,) = (tmp_path / "cache").rglob(f"*.{ending}")
        kept = torn.read_bytes()
        changed = bytearray(kept)
        changed[len(kept) // 2] ^= 1
        for damaged in (kept[:100], kept[:-1], b"", bytes(changed)):
            torn.write_bytes(damaged)
            assert compiled() == (0, 1)
            assert compiled() == (1, 0)


def test_what_compiled_code_alone_calls_gets_no_machine_code_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    inner = numba.njit(**INNER)(lambda x: x + x)
    outer = keep_compiled(numba.njit(lambda x: inner(x) + 1.0))
    assert outer(21.0) == 43.0
    engine = outer.targetctx.codegen()._engine
    (of_inner,), (of_outer,) = inner.overloads.values(), outer.overloads.values()
    assert engine.is_symbol_defined(of_outer.fndesc.llvm_cpython_wrapper_name)
    assert not engine.is_symbol_defined(of_inner.fndesc.llvm_func_name)
    assert numba.njit(lambda x: inner(x) + 2.0)(20.0) == 42.0, "it is there for others to call"
    for never_called in (inner, numba.njit(**INNER)(inner.py_func)):
        with pytest.raises(TypeError, match="lambda> is for compiled code alone: call"):
            never_called(21.0)


def test_what_was_edited_after_it_was_imported_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    module = tmp_path / "tiny.py"
    module.write_text("def twice(x):\n    return 2 * x\n", encoding="utf-8")
    kept = keep_compiled(numba.njit(runpy.run_path(str(module))["twice"]))
    module.write_text("def twice(x):\n    return x + x + 1\n", encoding="utf-8")
    assert kept(21.0) == 42.0
    assert list((tmp_path / "cache").rglob("*.nbi")) == []


def test_the_kernel_is_kept_for_the_next_process() -> None:
    wave = 4.0 * np.sin(0.1 * np.arange(200))
    case = {"azimuth_deg": [0.0], "height": [0.6], "b_over_h": [0.3], "friction": [1.0]}
    simulate_arrays(Motion(wave, 0 * wave, sampling_interval=0.01), **case)
    assert list(cache_directory().glob("*.nbi"))
    assert list(cache_directory().glob("*.nbc"))


@pytest.mark.long
def test_variants_that_different_processes_have_compiled_do_not_answer_for_each_other(tmp_path: Path) -> None:
    """Blocks on a level base and on one that also moves up, each compiled by its own process; a third loads both."""
    program = """if True:
        import sys
        import numpy as np
        from overturning.dem.simulate import simulate_arrays
        from overturning.motion.motion import Motion
        wave = 4.0 * np.sin(9.0 * np.arange(200) * 0.01)
        case = {"azimuth_deg": [0.0, 40.0], "height": [0.6], "b_over_h": [0.2, 0.4], "friction": [0.5]}
        for base in sys.argv[1:]:
            motion = Motion(wave, 0.5 * wave, 0.5 * wave if base == "up" else None, sampling_interval=0.01)
            found = simulate_arrays(motion, scheme="cundall", **case)
            print(base, found["status"].ravel(), found["peak_slip"].ravel(), found["block_steps"].sum())
    """
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}

    def run(*bases: str) -> list[str]:
        done = subprocess.run(
            [sys.executable, "-c", program, *bases], env=environment, capture_output=True, text=True, check=True
        )
        return done.stdout.splitlines()

    assert run("level") + run("up") == run("level", "up")


def test_all_that_kernels_import_names_the_folder_of_the_cache() -> None:
    """A constant of a module that is compiled in, but not hashed, would be answered by a stale kernel."""
    for name, path in modules().items():
        if name.startswith("overturning.dem.") and "numba" in path.read_text(encoding="utf-8"):
            types = {"overturning.arrays", "overturning.motion.motion"}  # nothing of them is compiled
            assert {modules()[other] for other in imports(name) - types} <= {*cache._COMPILED}, name
    assert queue.run_queue._cache._cache_path == str(cache_directory())


def test_another_version_of_numba_compiles_as_it_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is changed of its inner workings is changed in the version alone for which that was written."""
    target, processor = queue.run_queue.targetctx, PostProcessor
    usual = target.codegen()._library_class, processor.run
    with without_unused_work(target):
        assert target.codegen()._library_class is not usual[0]
        assert processor.run is not usual[1]
    monkeypatch.setattr(compiling, "KNOWN", "another")
    with without_unused_work(target):
        assert (target.codegen()._library_class, processor.run) == usual
