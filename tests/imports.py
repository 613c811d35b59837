"""Import statements of a module, found without parsing the rest of it, which would take most of the time."""

import ast
import re
from collections.abc import Iterator
from textwrap import dedent

_STATEMENT = re.compile(r"^[ \t]*(?:from[ \t]+[\w.]+[ \t]+)?import\b[ \t]*(?:[\w., \t]*\([^)]*\)|[^\n]*)", re.MULTILINE)
"""Import that begins a line, as the linter demands; its names may stand in brackets on several lines."""


def import_nodes(source: str) -> Iterator[ast.Import | ast.ImportFrom]:
    """Yield the imports of a module, also those inside functions; a text in it that looks like one counts, too."""
    found = list(dict.fromkeys(dedent(one) for one in _STATEMENT.findall(source)))
    try:
        statements = ast.parse("\n".join(found)).body
    except SyntaxError:  # prose of a docstring, or a continued line
        statements = list(ast.walk(ast.parse(source)))
    yield from (one for one in statements if isinstance(one, ast.Import | ast.ImportFrom))
