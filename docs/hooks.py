"""Hooks of the documentation site: tables, formulas, the executed notebook, a film and the explorer of a small study.

`python docs/hooks.py` runs the notebook and keeps in it what its cells show.
"""

import ast
import base64
import contextlib
import html
import io
import json
import re
import tempfile
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
NOTEBOOK = DOCS / "first-look.ipynb"
RECORD = "wtmc"
FILM = f"overturning one --record {RECORD} --azimuth 332 --b-over-h 0.3 --friction 1"
STUDY: dict[str, Any] = {
    "title": "Blocks at Te Mara Farm, Kaikoura 2016",
    "question": "Towards which azimuths do blocks fall under this record?",
    "azimuth": {"step": 10}, "b_over_h": {"start": 0.15, "stop": 0.6, "step": 0.05}, "height": [0.6, 1.2],
    "friction": [0.6], "ensemble": {"members": 4},
}  # fmt: skip
"""Study of the site's explorer."""


def on_files(files: Any, config: Any) -> Any:
    """Add the notebook as a page, and the pages of a film and of the explorer."""
    from mkdocs.structure.files import File

    files.append(File.generated(config, "first-look.md", content=notebook_page(NOTEBOOK)))
    for name, page in (("film.html", film_page), ("explore.html", explorer_page)):
        files.append(File.generated(config, name, content=page()))
    return files


def film_page() -> str:
    """Return the page of the film of `FILM`, a stone under the record that the package contains."""
    from overturning.cli import main

    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        path = Path(folder) / "film.html"
        with contextlib.suppress(SystemExit):
            main([*FILM.split()[1:], "--animate", str(path)])
        return path.read_text(encoding="utf-8")


def explorer_page() -> str:
    """Return the explorer of a small study of the record that the package contains; it takes seconds."""
    import overturning
    from overturning.figures.explore import write_explorer

    cube = overturning.run_study([RECORD], threads=2, **STUDY)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "explore.html"
        write_explorer(cube, path)
        return path.read_text(encoding="utf-8")


def film() -> str:
    """Return the frame of the film, for the first page."""
    fit = "try { this.style.height = this.contentDocument.body.offsetHeight + 'px' } catch {}"
    frame = f'<iframe class="film" src="film.html" title="{FILM}" onload="{fit}"></iframe>'
    return f"{frame}\n\nMade by `{FILM} --animate film.html`."


def explorer() -> str:
    """Return a link to the explorer."""
    return '<p><a class="md-button" href="explore.html">Look at every case of a small study</a></p>'


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Fill in the tables, and remove links to files that are not pages of the site."""
    markdown = re.sub(r"<!-- made: (\w+) -->", lambda found: TABLES[found[1]](), markdown)
    markdown = markdown.replace("](../config/README.md", "](reference/config.md")
    markdown = markdown.replace(f"({NOTEBOOK.name})", f"({NOTEBOOK.stem}.md)")  # page made by `on_files`
    return re.sub(
        r"(?<!!)\[([^\]]+)\]\(\.\./(?!formats|method|reference|scenes|surveys\.md)[^)]*\)", r"\1", _lists(markdown)
    )


def _lists(markdown: str) -> str:
    """Indent the content of list items by four spaces, as the site requires; the forge accepts three.

    Code that stands by itself is left alone.
    """
    parts = re.split(r"(^```.*?^```$)", markdown, flags=re.DOTALL | re.MULTILINE)
    for place in range(0, len(parts), 2):
        indented = re.sub(r"^   (?=\S)", "    ", parts[place], flags=re.MULTILINE)
        parts[place] = re.sub(r"^(    .*\n)(?=\d+\. )", r"\1\n", indented, flags=re.MULTILINE)
    return "".join(parts)


def on_page_content(content: str, **_: Any) -> str:
    """Convert formulas to MathML, and widen table cells that contain a sentence."""
    content = re.sub(r'(?<=<div class="formula">)(.*?)(?=</div>)', _formula, content, flags=re.DOTALL)
    return re.sub(r"<td>(?=[^<]{40})", '<td class="sentence">', content)


def _formula(found: re.Match[str]) -> str:
    """Return the equations of a formula, which are shown side by side if there is room."""
    from latex2mathml.converter import convert

    return "".join(convert(part.strip(), display="block") for part in html.unescape(found[1]).split(r"\qquad"))


def commands() -> str:
    """Return every command with its help."""
    import click
    import typer

    from overturning.commands.application import app

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
    """Return the table of the keys of a study."""
    from overturning.study.document import markdown_tables_of_study_keys_and_record_columns

    return markdown_tables_of_study_keys_and_record_columns()["keys"]


def columns() -> str:
    """Return the table of the columns of the record table."""
    from overturning.study.document import markdown_tables_of_study_keys_and_record_columns

    return markdown_tables_of_study_keys_and_record_columns()["columns"]


def variables() -> str:
    """Return the table of the variables of a cube, the ensemble included."""
    from overturning.model.variables import PLANAR_OUTCOME_VARIABLES, PLANE_ENSEMBLE_VARIABLES

    return _table((*PLANAR_OUTCOME_VARIABLES, *PLANE_ENSEMBLE_VARIABLES))


def space() -> str:
    """Return the table of the variables of a 3-D cube."""
    from overturning.model.variables import (
        BODY_ENSEMBLE_VARIABLES,
        BODY_OUTCOME_VARIABLES,
        OUTCOME_VARIABLES_OF_2D_RUNS_IN_FACE_PLANES,
    )

    return _table((*BODY_OUTCOME_VARIABLES, *OUTCOME_VARIABLES_OF_2D_RUNS_IN_FACE_PLANES, *BODY_ENSEMBLE_VARIABLES))


def _table(every: Any) -> str:
    rows = (f"| `{one.name}` | {one.dtype_in_file} | {one.units} | {one.long_name} |" for one in every)
    return "\n".join(["| variable | type | unit | meaning |", "|---|---|---|---|", *rows])


TABLES = {
    "film": film,
    "explorer": explorer,
    "commands": commands,
    "keys": keys,
    "columns": columns,
    "variables": variables,
    "space": space,
}


def executed(path: Path) -> dict[str, Any]:
    """Run the cells of a notebook in order and return it with their current output."""
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    space: dict[str, Any] = {"__name__": "__main__"}
    for count, cell in enumerate((one for one in notebook["cells"] if one["cell_type"] == "code"), 1):
        printed, value = _run("".join(cell["source"]), space)
        cell["execution_count"], cell["outputs"] = count, []
        if printed:
            cell["outputs"] += [{"name": "stdout", "output_type": "stream", "text": printed.splitlines(keepends=True)}]
        if value is not None:
            data = {"text/plain": [repr(value)]}
            if hasattr(value, "_repr_png_"):
                data["image/png"] = base64.b64encode(value._repr_png_()).decode("ascii")
            about = {"execution_count": count, "metadata": {}, "output_type": "execute_result"}
            cell["outputs"] += [{"data": data, **about}]
    return notebook


def _run(source: str, space: dict[str, Any]) -> tuple[str, Any]:
    """Run a cell; return its printed output, and the value of its last line if it is an expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), space)
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), space) if last is not None else None
    return printed.getvalue(), value


def notebook_page(path: Path) -> str:
    """Return a notebook as a page, with its current output."""
    parts = []
    for cell in executed(path)["cells"]:
        source = "".join(cell["source"])
        parts.append(f"```python\n{source}\n```" if cell["cell_type"] == "code" else source)
        for output in cell.get("outputs", []):
            data = output.get("data", {"text/plain": output.get("text")})
            if "image/png" in data:
                shown = f'<img alt="figure of the cell above" src="data:image/png;base64,{data["image/png"]}">'
            else:
                shown = "```text\n" + "".join(data["text/plain"]).rstrip() + "\n```"
            parts.append(shown)
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":  # keep in the notebook what its cells show
    NOTEBOOK.write_text(json.dumps(executed(NOTEBOOK), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
