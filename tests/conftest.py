"""In which order two processes share the tests, and folders that both use."""

import fcntl
import gc
import os
from collections.abc import Callable, Generator
from pathlib import Path

import pytest
from xdist.scheduler import LoadFileScheduling

KERNEL_COMPILING_TEST_FILES_IN_ORDER = (
    "test_ladder.py", "test_one.py", "test_digests.py", "test_closed_forms.py", "test_bad_input.py",
    "test_polygon_cost.py",
)  # fmt: skip
"""Files whose tests compile the kernels of scenes and stacks. They run in one process, in this order: two processes
would compile the same kernel at the same time, and a second variant of a kernel takes a quarter of the first."""

TEST_FILES_SHARING_PARSED_SOURCES = ("test_layers.py", "test_locks.py")
"""Files whose tests search the same Python sources for imports: in one process, so that each is parsed once."""

WORKFLOW_TEST_FILES = ("test_study.py", "test_messages.py", "test_imports.py")
"""Files whose tests plan studies by Snakemake: in one process, so that it is imported once."""

TEST_FILES_RUN_FIRST = (
    *KERNEL_COMPILING_TEST_FILES_IN_ORDER, "test_body_closed_forms.py", "test_rocking.py", "test_study.py",
    "test_messages.py",
    "test_in_browsers.py", "test_explorer_in_browsers.py", "test_commands_on_results.py", "test_japanese_figures.py",
    "test_fetch.py", "test_imports.py", "test_new_project.py", "test_python.py", "test_fork_server.py",
)  # fmt: skip
"""Files that run first: those that compile, then the longest, which would leave one process idle at the end."""


class GroupedFileScheduling(LoadFileScheduling):
    """Scheduler that runs all tests of a file, or of a group of files that share costly work, in one process."""

    def _split_scope(self, nodeid: str) -> str:
        file = super()._split_scope(nodeid)
        name = file.rpartition("/")[2]
        groups = {
            "kernels": KERNEL_COMPILING_TEST_FILES_IN_ORDER,
            "sources": TEST_FILES_SHARING_PARSED_SOURCES,
            "workflow": WORKFLOW_TEST_FILES,
        }
        return next((group for group, names in groups.items() if name in names), file)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> GroupedFileScheduling | None:
    """Distribute test files by `GroupedFileScheduling` under ``--dist loadfile``."""
    return GroupedFileScheduling(config, log) if config.getoption("dist") == "loadfile" else None


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Import the test modules without garbage collection: it would scan all modules ten times."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run the test files listed in `TEST_FILES_RUN_FIRST` first, in that order."""
    items.sort(
        key=lambda item: (
            TEST_FILES_RUN_FIRST.index(item.path.name)
            if item.path.name in TEST_FILES_RUN_FIRST
            else len(TEST_FILES_RUN_FIRST)
        )
    )


def pytest_collection_finish() -> None:
    """Exclude the imported modules and tests from garbage collection: they stay, and scanning them takes seconds."""
    gc.freeze()
    gc.set_threshold(300_000, 20, 50)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish() -> None:
    """Exclude all objects from garbage collection, since pytest would scan them five times at the end."""
    gc.freeze()


@pytest.fixture(scope="session")
def make_folder_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[Path], object]], Path]:
    """Return a function that makes a shared folder once for all test processes; tests must not change the folder."""
    root = tmp_path_factory.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root

    def make_folder_if_missing(name: str, make: Callable[[Path], object]) -> Path:
        folder, made = root / f"shared-{name}", root / f"shared-{name}.made"
        with (root / f"shared-{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not made.exists():
                make(folder)
                made.touch()
        return folder

    return make_folder_if_missing
