"""`overturning init` and `study`: a folder for studies; write or check a study file; write schema and key table."""

from pathlib import Path
from typing import Annotated

import typer

WORKFLOW = ("Snakefile", "profiles", "workflow")
"""What Snakemake needs beside a study, at the top of the repository and of any project."""

PARTS = (*WORKFLOW, "config/records.tsv", "config/scenes", "config/schema.json", "config/README.md")

app = typer.Typer(no_args_is_help=True, help="Write or check a study file; write schema and key table.")


def init(folder: Annotated[Path, typer.Argument(help="folder to make")]) -> None:
    """Make a folder with a study, the record table, scenes, and the workflow that runs it."""
    import shlex
    import shutil

    from overturning.errors import ArgumentError
    from overturning.files import atomic_write, project_folders
    from overturning.study.document import study_template

    if folder.exists() and any(folder.iterdir() if folder.is_dir() else [folder]):
        raise ArgumentError(f"{folder}: is there already and not empty; name a folder to make")
    project = next(root for root in project_folders() if (root / PARTS[0]).is_file())
    for part in PARTS:
        source, target = project / part, folder / part
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copyfile(source, target)
    (folder / "resources" / "records").mkdir(parents=True)
    with atomic_write(folder / "config" / "near-fault.yaml") as text:
        text.write_text(study_template("near-fault", ["rinaldi", "petrolia"]), encoding="utf-8")
    print(
        f"{folder}: study config/near-fault.yaml, record table, scenes, workflow. Go on with\n"
        f"  cd {shlex.quote(str(folder))}\n  overturning study check config/near-fault.yaml\n  snakemake --cores 2"
    )


@app.command()
def check(path: Annotated[Path, typer.Argument(help="study file (YAML)")]) -> None:
    """Find what a run would find: wrong keys, missing and damaged files, too many cases; and about what it takes."""
    from overturning.study.load import load_study
    from overturning.study.preflight import check_files, check_packages, check_records, check_size
    from overturning.surveys.stones import read_survey

    study = load_study(path)
    size = check_size(study, str(path))
    check_packages(study, str(path))
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
