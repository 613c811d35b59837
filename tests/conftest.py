"""In which order two processes share the tests, and folders that both use."""

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest

FIRST = ("test_ladder.py", "test_body_closed_forms.py", "test_rocking.py", "test_study.py")
"""Files whose tests compile the kernels of scenes, of bodies in space and of blocks: else both processes would compile
the same one at the same time. Then the longest: at the end, it would leave one process idle."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: FIRST.index(item.path.name) if item.path.name in FIRST else len(FIRST))


@pytest.fixture(scope="session")
def made_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[Path], object]], Path]:
    """Make a folder by its name once for all processes of a session; tests must not change it."""
    root = tmp_path_factory.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root

    def once(name: str, make: Callable[[Path], object]) -> Path:
        folder, made = root / f"shared-{name}", root / f"shared-{name}.made"
        with (root / f"shared-{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not made.exists():
                make(folder)
                made.touch()
        return folder

    return once
