"""`overturning study`: write or check a study file; write the JSON schema and the key table."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="Write or check a study file; write schema and key table.")


@app.command()
def check(path: Annotated[Path, typer.Argument(help="study file (YAML)")]) -> None:
    """Find what a run would find: wrong keys, missing and damaged files, too many cases; and about what it takes."""
    from overturning.study.load import load_study
    from overturning.study.preflight import check_files, check_records, check_size
    from overturning.surveys.stones import read_survey

    study = load_study(path)
    size = check_size(study, str(path))
    entries, _ = check_files(study, str(path))
    for survey in study.surveys:
        read_survey(Path(survey.stones))
    for said in check_records(study, entries):
        print(said)
    print(f"{path}: study {study.name!r}, {size}")
    if study.surveys:
        print("which motion its surveys ask for takes minutes to an hour more, once for stones of such sizes")


@app.command()
def new(
    name: Annotated[str, typer.Option(prompt="Name of the study", help="of its file and its folder of results")],
    records: Annotated[str, typer.Option(prompt="Records, ids of the table with commas between", help="ids: a,b")],
    title: Annotated[str, typer.Option(help="title of the report")] = "",
    step: Annotated[float, typer.Option(help="step of the azimuth, degrees")] = 15.0,
    folder: Annotated[Path, typer.Option(help="folder of the file")] = Path("config"),
) -> None:
    """Write a new study file, asking for what is not given."""
    from overturning.errors import ArgumentError, ConfigError
    from overturning.files import atomic_write, check_output
    from overturning.study.document import study_template
    from overturning.study.load import entries_of, load_study

    path = folder / f"{name}.yaml"
    if path.exists():
        raise ArgumentError(f"{path}: is there already; choose another name")
    check_output(path, "--folder")
    with atomic_write(path) as part:
        part.write_text(study_template(name, records.replace(",", " ").split(), title, step), encoding="utf-8")
        try:
            entries_of(load_study(part), str(path))
        except ConfigError as error:  # names the file that will not be there
            raise ConfigError(str(error).replace(str(part), str(path))) from None
    print(f"{path}: edit it, then overturning study check {path}")


@app.command()
def document(
    folder: Annotated[Path, typer.Argument(help="folder of schema.json and README.md")] = Path("config"),
) -> None:
    """Write config/schema.json and the key table in config/README.md from the model."""
    from overturning.study.document import write_documentation

    write_documentation(folder)
