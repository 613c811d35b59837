"""Layers import downwards only: each from those above it in this list, never the other way."""

import ast
from pathlib import Path

import pytest

import overturning

LAYERS = [
    "units",
    "errors",
    "arrays",
    "files",
    "tables",
    "motion",
    "records",
    "dem",
    "reference",
    "study",
    "verification",
    "statistics",
    "figures",
    "surveys",
    "report",
    "commands",
    "cli",
]
ROOT = Path(overturning.__file__).parent
FILES = sorted(p for p in ROOT.rglob("*.py") if p.parent != ROOT or p.stem in LAYERS)


def imported_layers(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} imports relatively; write the full name"
            names |= {node.module or ""} | {f"{node.module}.{alias.name}" for alias in node.names}
    return {
        parts[1]
        for name in names
        if (parts := name.split("."))[0] == "overturning" and len(parts) > 1 and parts[1] in LAYERS
    }


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_imports_only_from_layers_above(path: Path) -> None:
    own = path.relative_to(ROOT).parts[0].removesuffix(".py")
    assert own in LAYERS, f"{own} is not a layer of DESIGN"
    above = LAYERS[: LAYERS.index(own) + 1]
    assert imported_layers(path) <= set(above)


def test_the_package_does_not_know_the_workflow_engine() -> None:
    for path in ROOT.rglob("*.py"):
        assert "import snakemake" not in path.read_text(encoding="utf-8"), path
