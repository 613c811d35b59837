"""Which source files of the package a job depends on, as one hash: a change of them makes the workflow run the job again."""

import ast
import hashlib
from functools import cache
from pathlib import Path

_ROOT = Path(__file__).parents[1]


def _file_of(name: str) -> Path | None:
    parts = name.split(".")
    if parts[0] != _ROOT.name:
        return None
    path = _ROOT.joinpath(*parts[1:])
    if (path / "__init__.py").is_file():
        return path / "__init__.py"
    return path.with_suffix(".py") if path.with_suffix(".py").is_file() else None


@cache
def _imports(path: Path) -> frozenset[Path]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    files = {_file_of(name) for name in names}
    return frozenset(file for file in files if file is not None)


def sources_of(module: str) -> list[Path]:
    """Source files that a module of the package is made of: its own and those it imports, at any depth.

    Imports inside functions count; the package's own ``__init__`` does not, since it imports nothing by itself.

    Parameters
    ----------
    module : str
        Full name, for instance ``overturning.commands.sweep``.

    Returns
    -------
    list of Path
        Sorted.

    Raises
    ------
    ValueError
        If the package has no such module.
    """
    first = _file_of(module)
    if first is None:
        raise ValueError(f"{module} is no module of the package")
    seen: set[Path] = set()
    waiting = [first]
    while waiting:
        path = waiting.pop()
        if path not in seen and path != _ROOT / "__init__.py":
            seen.add(path)
            waiting.extend(_imports(path))
    return sorted(seen)


def source_hash(module: str) -> str:
    """Hash of the sources a module is made of, and of the data files (templates, styles) beside them.

    Parameters
    ----------
    module : str
        Full name of the module.

    Returns
    -------
    str
        Sixteen hexadecimal digits.
    """
    files = sources_of(module)
    beside = {
        data
        for path in files
        for data in path.parent.rglob("*")
        if data.suffix in {".html", ".css", ".js", ".typ", ".j2"}
    }
    digest = hashlib.sha256()
    for path in sorted({*files, *beside}):
        digest.update(path.relative_to(_ROOT).as_posix().encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]
