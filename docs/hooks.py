"""What the documentation site is made of beside its pages: tables from the package, and the notebook, which is run."""

import ast
import base64
import contextlib
import io
import json
import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
NOTEBOOK = DOCS / "first-look.ipynb"


def on_files(files: Any, config: Any) -> Any:
    """Add the notebook as a page."""
    from mkdocs.structure.files import File

    files.append(File.generated(config, "first-look.md", content=notebook_page(NOTEBOOK)))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Fill in the tables, and take away links to what is no page of the site."""
    markdown = re.sub(r"<!-- made: (\w+) -->", lambda found: TABLES[found[1]](), markdown)
    markdown = markdown.replace("](../config/README.md", "](reference/config.md")
    return re.sub(r"\[([^\]]+)\]\(\.\./(?!formats|method|reference|scenes)[^)]*\)", r"\1", markdown)


def commands() -> str:
    """Every command with its own help."""
    import click
    import typer

    from overturning.cli import app

    root: Any = typer.main.get_command(app)
    parts = []

    def add(command: Any, name: str) -> None:
        context = click.Context(command, info_name=name, max_content_width=100)
        parts.append(f"## {name}\n\n```text\n{command.get_help(context)}\n```")
        for below, one in getattr(command, "commands", {}).items():
            add(one, f"{name} {below}")

    for name, command in root.commands.items():
        add(command, f"overturning {name}")
    return "\n\n".join(parts)


def keys() -> str:
    """The keys of a study."""
    from overturning.study.document import tables

    return tables()["keys"]


def columns() -> str:
    """The columns of the record table."""
    from overturning.study.document import tables

    return tables()["columns"]


def variables() -> str:
    """The variables of the cube, those of the ensemble too."""
    from overturning.model.variables import PLANE_ENSEMBLE_VARIABLES, VARIABLES

    return _table((*VARIABLES, *PLANE_ENSEMBLE_VARIABLES))


def space() -> str:
    """The variables of a cube in space."""
    from overturning.model.variables import BODY_ENSEMBLE_VARIABLES, BODY_VARIABLES, FACE_VARIABLES

    return _table((*BODY_VARIABLES, *FACE_VARIABLES, *BODY_ENSEMBLE_VARIABLES))


def _table(every: Any) -> str:
    rows = (f"| `{one.name}` | {one.dtype} | {one.units} | {one.long_name} |" for one in every)
    return "\n".join(["| variable | type | unit | meaning |", "|---|---|---|---|", *rows])


TABLES = {"commands": commands, "keys": keys, "columns": columns, "variables": variables, "space": space}


def run_notebook(path: Path) -> list[tuple[str, str, str]]:
    """Run the cells of a notebook in order: kind, source, and what each shows as Markdown."""
    space: dict[str, Any] = {"__name__": "__main__"}
    shown = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        source, kind = "".join(cell["source"]), str(cell["cell_type"])
        shown.append((kind, source, _output(source, space) if kind == "code" else ""))
    return shown


def _output(source: str, space: dict[str, Any]) -> str:
    """What a cell prints, and the value of its last line where that is an expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), space)
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), space) if last is not None else None
    parts = [f"```text\n{printed.getvalue().rstrip()}\n```"] if printed.getvalue() else []
    if hasattr(value, "savefig"):
        parts.append(_picture(value))
    elif value is not None:
        parts.append(f"```text\n{value}\n```")
    return "\n\n".join(parts)


def _picture(figure: Any) -> str:
    from tempfile import TemporaryDirectory

    from overturning.figures.style import save, style

    with TemporaryDirectory() as folder, style():
        save(figure, Path(folder) / "figure.svg")
        data = base64.b64encode((Path(folder) / "figure.svg").read_bytes()).decode("ascii")
    return f'<img alt="figure of the cell above" src="data:image/svg+xml;base64,{data}">'


def notebook_page(path: Path) -> str:
    """A notebook as a page, with what its cells show now."""
    parts = []
    for kind, source, output in run_notebook(path):
        parts += [f"```python\n{source}\n```", output] if kind == "code" else [source]
    return "\n\n".join(part for part in parts if part) + "\n"
