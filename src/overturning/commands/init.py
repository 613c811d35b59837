"""`overturning init`: a folder for studies of one's own."""

from pathlib import Path
from typing import Annotated

import typer

WORKFLOW = ("Snakefile", "profiles", "workflow")
"""What Snakemake needs beside a study, at the top of the repository and of any project."""

PARTS = (*WORKFLOW, "config/records.tsv", "config/scenes", "config/schema.json", "config/README.md")


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
