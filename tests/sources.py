"""Import statements of Python sources, found once for all tests of a process that read them."""

import ast
from collections.abc import Iterator
from functools import cache


@cache
def import_statements(source: str) -> tuple[ast.Import | ast.ImportFrom, ...]:
    """Return all import statements of a source, also those inside functions.

    The tree is not kept: the nodes of all sources would slow down each garbage collection.
    """
    return tuple(node for node in _statements(ast.parse(source)) if isinstance(node, ast.Import | ast.ImportFrom))


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements of a module, also those inside others; they are a tenth of what `ast.walk` yields."""
    for part in ("body", "orelse", "handlers", "finalbody", "cases"):
        for one in getattr(tree, part, ()):
            yield one
            yield from _statements(one)
