"""Compiled kernels are kept for the next process, and a torn file of theirs is a miss."""

import runpy
from pathlib import Path

import numba
import numpy as np
import pytest

from overturning.dem.kernel.cache import cache_directory, keep_compiled
from overturning.dem.simulate import simulate_arrays
from overturning.motion.motion import Motion


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
