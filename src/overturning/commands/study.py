"""`overturning study`: check a study file; write the JSON schema and the key table."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="Check a study file; write schema and key table.")


@app.command()
def check(path: Annotated[Path, typer.Argument(help="study file (YAML)")]) -> None:
    """Check a study file and say how many cases it has."""
    from overturning.study.load import entries_of, load_study
    from overturning.surveys.stones import read_survey

    study = load_study(path)
    records = entries_of(study, str(path))
    for survey in study.surveys:
        read_survey(Path(survey.stones))
    print(f"{path}: study {study.name!r}, {len(records)} records × {study.cases} cases = {len(records) * study.cases}")


@app.command()
def document(
    folder: Annotated[Path, typer.Argument(help="folder of schema.json and README.md")] = Path("config"),
) -> None:
    """Write config/schema.json and the key table in config/README.md from the model."""
    from overturning.study.document import write_documentation

    write_documentation(folder)
