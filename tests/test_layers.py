"""Imports run one way: down the package's layers, from checks and tests into the package, never in a circle."""

import ast
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.sources import import_statements

IMPORT_LAYERS = [
    "units",
    "errors",
    "arrays",
    "files",
    "validation",
    "quantities",
    "tables",
    "stored",
    "kernel_cache",
    "motion",
    "records",
    "model",
    "settings",
    "dem",
    "study",
    "labels",
    "translation",
    "statistics",
    "figures",
    "surveys",
    "findings",
    "report",
    "plot",
    "commands",
    "cli",
    "__main__",
]
"""Each imports only from those above it in this list."""

ROOT = Path(__file__).parents[1]
PACKAGES = {"overturning": ROOT / "src" / "overturning", "verification": ROOT / "verification", "tests": ROOT / "tests"}


@cache
def source_paths_of_package_verification_and_tests() -> dict[str, Path]:
    """Return the paths of all modules of the package, the verification and the tests, by module name."""
    found = {}
    for package, folder in PACKAGES.items():
        for path in sorted(folder.rglob("*.py")):
            parts = (package, *path.relative_to(folder).with_suffix("").parts)
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def imported_project_modules(module: str) -> frozenset[str]:
    """Return the names of the project modules that a module imports, also inside functions."""
    names, text = set(), source_paths_of_package_verification_and_tests()[module].read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)) if "import_module" in text else import_statements(text):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module} imports relatively; write the full name"
            below = {f"{node.module}.{alias.name}" for alias in node.names}
            names |= below & source_paths_of_package_verification_and_tests().keys() or {str(node.module)}
        elif isinstance(node, ast.Call) and _last_name_of_called_function(node.func) == "import_module":
            names |= {one.value for one in node.args if isinstance(one, ast.Constant)}
    return frozenset((names & source_paths_of_package_verification_and_tests().keys()) - {module})


def _last_name_of_called_function(function: ast.expr) -> str:
    """Return the last part of the name of a called function, such as ``import_module``; empty if it has none."""
    return (
        function.attr if isinstance(function, ast.Attribute) else function.id if isinstance(function, ast.Name) else ""
    )


def layer_of_module(module: str) -> str:
    """Return the layer, a top-level subpackage or module, to which a module of the package belongs.

    Empty for the package itself.
    """
    return (*module.split("."), "")[1]


def test_each_module_imports_only_from_allowed_layers() -> None:
    faults = []
    for name in (name for name in source_paths_of_package_verification_and_tests() if name.startswith("overturning.")):
        assert layer_of_module(name) in IMPORT_LAYERS, f"{layer_of_module(name)} is not a layer"
        allowed = ["", *IMPORT_LAYERS[: IMPORT_LAYERS.index(layer_of_module(name)) + 1]]
        faults += [
            f"{name} imports {other}"
            for other in imported_project_modules(name)
            if not other.startswith("overturning") or layer_of_module(other) not in allowed
        ]
    assert faults == []


IMPORTERS_OF_VERIFICATION = ("verification", "tests.verification", "tests.workflow")
"""Folders that may import verification: itself, its tests, and tests that run whole studies."""


def test_only_allowed_folders_import_verification() -> None:
    for name in source_paths_of_package_verification_and_tests():
        others = {other for other in imported_project_modules(name) if not other.startswith("verification.reference.")}
        packages = {other.partition(".")[0] for other in others}
        if name.startswith("verification"):
            assert "tests" not in packages, name
        if name.startswith("verification.reference") or not name.startswith(IMPORTERS_OF_VERIFICATION):
            assert "verification" not in packages, name


def test_the_project_has_no_circular_imports() -> None:
    try:
        TopologicalSorter(
            {name: imported_project_modules(name) for name in source_paths_of_package_verification_and_tests()}
        ).prepare()
    except CycleError as error:
        pytest.fail(f"a circle of imports: {' → '.join(error.args[1])}")


def test_the_package_does_not_import_the_workflow_engine() -> None:
    for name, path in source_paths_of_package_verification_and_tests().items():
        if name.startswith("overturning"):
            assert "import snakemake" not in path.read_text(encoding="utf-8"), path
