"""Sources of the project that several tests read: import statements, and the files that come with the program."""

import ast
import subprocess
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]


def shipped_files(pattern: str) -> list[Path]:
    """Return the files of the project that match a pattern, without those that a user has added to a checkout."""
    found = sorted(ROOT.glob(pattern))
    listed = subprocess.run(["git", "ls-files", "-z", pattern], cwd=ROOT, capture_output=True, text=True, check=False)
    shipped = {ROOT / name for name in listed.stdout.split("\0") if name}
    return [path for path in found if path in shipped] if shipped else found


@cache
def import_statements(source: str) -> tuple[ast.Import | ast.ImportFrom, ...]:
    """Return all import statements of a source text, also those inside functions.

    The syntax tree is not kept: the nodes of all sources would slow down each garbage collection.
    """
    return tuple(node for node in _walk_statements(ast.parse(source)) if isinstance(node, ast.Import | ast.ImportFrom))


def _walk_statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements of a syntax tree, also nested ones, but no expressions.

    Expressions are nine tenths of the nodes that `ast.walk` yields.
    """
    for part in ("body", "orelse", "handlers", "finalbody", "cases"):
        for one in getattr(tree, part, ()):
            yield one
            yield from _walk_statements(one)
