"""Which source files a job depends on, as one hash: a change of them makes the workflow run the job again.

Snakemake's own trigger looks at the command of a rule, not at the package that the command calls.
"""

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def _file_of(name: str, roots: tuple[Path, ...]) -> Path | None:
    package, *parts = name.split(".")
    paths = [root.joinpath(*parts) for root in roots if root.name == package]
    files = [file for path in paths for file in (path / "__init__.py", path.with_suffix(".py"))]
    return next((file for file in files if file.is_file()), None)


def _named(name: str, roots: tuple[Path, ...]) -> tuple[Path, str]:
    """File and function of a name such as ``overturning.commands.workflow:sweep``."""
    module, _, function = name.partition(":")
    if (path := _file_of(module, roots)) is None:
        raise ValueError(f"{module} is no module of the package")
    return path, function


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """All statements inside of one, at any depth: a tenth of the nodes, and imports are among them."""
    for name in ("body", "orelse", "handlers", "finalbody", "cases"):
        for one in getattr(node, name, ()):
            yield one
            yield from _statements(one)


@cache
def _imports(path: Path, roots: tuple[Path, ...], function: str = "") -> frozenset[Path]:
    names = set()
    for node in _statements(part_of(path, function)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return frozenset(file for name in names if (file := _file_of(name, roots)) is not None)


def part_of(path: Path, function: str) -> ast.Module:
    """A module without the functions that one of its functions does not call; the whole one without its name."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if not function:
        return tree
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    if function not in functions:
        raise ValueError(f"{path.name} has no function {function!r}")
    kept = [function]
    for name in kept:
        inside = list(ast.walk(functions[name]))
        named = {node.id for node in inside if isinstance(node, ast.Name)}
        named -= {node.arg for node in inside if isinstance(node, ast.arg)}  # a parameter may be called like a function
        kept += sorted((named & set(functions)) - set(kept))
    tree.body = [node for node in tree.body if not isinstance(node, ast.FunctionDef) or node.name in kept]
    return tree


def sources_of(module: str, *others: Path) -> list[Path]:
    """Source files that a module is made of: its own and those it imports from the package, at any depth.

    Imports inside functions count; the package's own ``__init__`` does not, since it imports nothing by itself. After a
    colon the name of a function may follow, as in ``overturning.commands.workflow:sweep``: then only what that function
    needs counts. `others` are folders of further packages that are followed too. A ValueError where there is no such
    module or function.
    """
    roots = (PACKAGE, *others)
    first, function = _named(module, roots)
    seen, waiting = {first}, set(_imports(first, roots, function))
    while waiting := waiting - seen - {PACKAGE / "__init__.py"}:
        seen |= waiting
        waiting = set().union(*(_imports(path, roots) for path in waiting))
    return sorted(seen)


def source_hash(module: str, *others: Path) -> str:
    """Hash, sixteen hexadecimal digits, of the sources as of `sources_of` and of the templates and styles beside them.

    Of a function's own file only the part counts that the function is made of.
    """
    roots = (PACKAGE, *others)
    files = sources_of(module, *others)
    first, function = _named(module, roots)
    beside = {
        data
        for folder in {path.parent for path in files} - {PACKAGE}  # beside its files lies what belongs to other parts
        for data in folder.rglob("*")
        if data.suffix in {".html", ".css", ".js", ".typ", ".j2"}
    }
    digest = hashlib.sha256()
    for path in sorted({*files, *beside}):
        root = next(root for root in roots if path.is_relative_to(root))
        digest.update(path.relative_to(root).as_posix().encode())
        content = ast.unparse(part_of(first, function)).encode() if function and path == first else path.read_bytes()
        digest.update(hashlib.sha256(content).digest())
    return digest.hexdigest()[:16]
