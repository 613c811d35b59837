"""A folder to work in."""

from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture
def isolated_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield an empty working folder; the test fails if anything is written next to it."""
    inner = tmp_path / "inner"
    inner.mkdir()
    monkeypatch.chdir(inner)
    yield inner
    assert [path.name for path in tmp_path.iterdir()] == ["inner"]
