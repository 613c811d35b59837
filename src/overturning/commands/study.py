"""`overturning study`: check a study file; write the JSON schema and the key table."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="Check a study file; write schema and key table.")


@app.command()
def check(path: Annotated[Path, typer.Argument(help="study file (YAML)")]) -> None:
    """Find what a run would find: wrong keys, missing and damaged files, too many cases. Says what a run takes, about."""
    from overturning.study.check import check_files, check_records, check_size
    from overturning.study.load import load_study
    from overturning.surveys.stones import read_survey

    study = load_study(path)
    size = check_size(study, str(path))
    entries, _ = check_files(study, str(path))
    for survey in study.surveys:
        read_survey(Path(survey.stones))
    check_records(study, entries)
    print(f"{path}: study {study.name!r}, {size}")


@app.command()
def document(
    folder: Annotated[Path, typer.Argument(help="folder of schema.json and README.md")] = Path("config"),
) -> None:
    """Write config/schema.json and the key table in config/README.md from the model."""
    from overturning.study.document import write_documentation

    write_documentation(folder)
