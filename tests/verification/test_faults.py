"""The short form of `make faults`: a study outlives a fault of two kinds."""

from pathlib import Path

import pytest

from verification.faults.__main__ import put
from verification.faults.kinds import KINDS

pytestmark = pytest.mark.workflow


def test_there_are_fifty_faults() -> None:
    assert sum(kind.times for kind in KINDS) == 50


def test_a_study_outlives_a_kill_and_an_injury(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OVERTURNING_HOLDS", raising=False)
    chosen = [(kind, 1) for kind in KINDS if kind.says in ("Snakemake alone killed", "a byte of a part changed")]
    assert len(chosen) == 2
    assert set(put(chosen, tmp_path, brief=True).values()) == {(1, 1)}
