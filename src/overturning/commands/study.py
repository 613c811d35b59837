"""`overturning init` and `study`: create a project folder, write or check a study file, write schema and key table."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from overturning.surveys.responses import StoneHeightAndSideRatios

WORKFLOW_FILES_AND_FOLDERS = ("Snakefile", "profiles", "workflow")
"""Files and folders of the workflow, at the top of the repository and of each project."""

FILES_AND_FOLDERS_COPIED_TO_NEW_PROJECT = (
    *WORKFLOW_FILES_AND_FOLDERS,
    "config/records.tsv",
    "config/scenes",
    "config/schema.json",
    "config/README.md",
)

app = typer.Typer(no_args_is_help=True, help="Write or check a study file; write schema and key table.")


def create_project(folder: Annotated[Path, typer.Argument(help="folder to create")]) -> None:
    """Create a folder for a new project, with a study file, the record table, scenes and the workflow."""
    import re
    import shlex
    import shutil

    from overturning.errors import ArgumentError
    from overturning.files import folders_of_shipped_files_in_wheel_and_checkout, write_text
    from overturning.study.document import adapt_readme_text_to_new_project, new_study_file_text

    if folder.exists() and any(folder.iterdir() if folder.is_dir() else [folder]):
        raise ArgumentError(f"{folder}: exists and is not empty; name a new folder")
    project = next(
        root
        for root in folders_of_shipped_files_in_wheel_and_checkout()
        if (root / FILES_AND_FOLDERS_COPIED_TO_NEW_PROJECT[0]).is_file()
    )
    for part in FILES_AND_FOLDERS_COPIED_TO_NEW_PROJECT:
        source, target = project / part, folder / part
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copyfile(source, target)
    (folder / "resources" / "records").mkdir(parents=True)
    readme = folder / "config" / "README.md"
    write_text(readme, adapt_readme_text_to_new_project(readme.read_text(encoding="utf-8")))
    name = re.sub("[^a-z0-9]+", "-", folder.resolve().name.lower())[:100].strip("-") or "study"
    study = f"config/{name}.yaml"
    # Both records have a fault strike, which the alignment needs.
    write_text(folder / study, new_study_file_text(name, ["rinaldi", "petrolia"], primary_statistic_name="alignment"))
    print(
        f"{folder}: study {study}, record table, scenes, workflow. Continue with\n"
        f"  cd {shlex.quote(str(folder))}\n  overturning study check {study}\n"
        f"  snakemake --cores 2 --configfile {study}"
    )


@app.command("check")
def check_study_file(path: Annotated[Path, typer.Argument(help="study file (YAML)")]) -> None:
    """Check a study before a run: keys, missing or damaged files, number of cases; and estimate time and memory."""
    from overturning.study.doubts import implausible_setting_warnings, warnings_on_ranges_not_reaching_their_stop
    from overturning.study.grounds import check_soil_sites_occur_in_survey_table
    from overturning.study.load import read_unvalidated_study_content, study_from_content
    from overturning.study.preflight import (
        check_soil_curve_package,
        estimate_and_check_study_size,
        find_record_rows_and_files,
        notes_if_primary_statistic_is_unavailable,
        read_and_process_records_and_collect_notes,
    )
    from overturning.study.sections import read_scan_of_body
    from overturning.surveys.counted_stones import read_fallen_and_standing_stones_notes_and_warnings
    from overturning.surveys.prediction import note_on_b_over_h_far_outside_study
    from overturning.surveys.responses import dimensions_of_survey_stones

    content = read_unvalidated_study_content(path)
    study = study_from_content(content, str(path))
    for doubt in (*implausible_setting_warnings(study), *warnings_on_ranges_not_reaching_their_stop(content)):
        print(f"{path}: {doubt}")
    size = estimate_and_check_study_size(study, str(path))
    check_soil_curve_package(study, str(path))
    entries, _ = find_record_rows_and_files(study, str(path))
    searched: list[StoneHeightAndSideRatios] = []
    for number, survey in enumerate(study.surveys):
        stones, notes, doubts = read_fallen_and_standing_stones_notes_and_warnings(Path(survey.stones))
        check_soil_sites_occur_in_survey_table(study, number, {stone.site for stone in stones}, str(path))
        searched += dimensions_of_survey_stones(stones, survey.stones) if survey.backwards else []
        if study.orientation is None:
            notes = [*notes, *note_on_b_over_h_far_outside_study(stones, study.b_over_h, survey.stones)]
        print(*notes, *doubts, sep="\n", end="\n" * bool(notes or doubts))
    for note in (
        *read_and_process_records_and_collect_notes(study, entries),
        *notes_if_primary_statistic_is_unavailable(study, entries),
    ):
        print(note)
    body = content.get("body")
    if isinstance(body, dict) and body.get("mesh") is not None:
        # Read again: the study holds the body, but not what was repaired in the file.
        for line in read_scan_of_body(body).description_lines():
            print(f"{path}: body: {line}")
    print(f"{path}: study {study.name!r}, {size}")
    if searched:
        print(_note_on_processor_time_to_infer_motion(searched, len(entries)))


def _note_on_processor_time_to_infer_motion(
    stone_dimensions_of_surveys: "Sequence[StoneHeightAndSideRatios]", study_record_count: int
) -> str:
    """Return a note on the processor time needed to infer the ground motion from each survey of a study."""
    from overturning.study.preflight import format_duration
    from overturning.surveys.library import candidate_motions
    from overturning.surveys.responses import count_cases_to_simulate_and_estimate_time_s

    library = candidate_motions()
    _, seconds = count_cases_to_simulate_and_estimate_time_s(library, stone_dimensions_of_surveys)
    # The study's own records are not read here: assume the mean time of the library motions for each.
    seconds += (
        count_cases_to_simulate_and_estimate_time_s(
            library, stone_dimensions_of_surveys, counts_cases_with_stored_outcomes=True
        )[1]
        * study_record_count
        / len(library)
    )
    return (
        f"search for the motion of the surveys: about {format_duration(seconds)} of additional processor time, once "
        "for stones of these sizes; `backwards: false` in a survey skips it"
    )


@app.command("new")
def create_study_file(
    name: Annotated[
        str, typer.Option(prompt="Name of the study", help="name of the study, of its file and its result folder")
    ],
    records: Annotated[
        str, typer.Option(prompt="Record ids, separated by commas", help="ids in the record table: a,b")
    ],
    title: Annotated[str, typer.Option(help="title of the report")] = "",
    step: Annotated[float, typer.Option(help="step of the azimuth, degrees")] = 15.0,
    folder: Annotated[Path, typer.Option(help="folder of the file")] = Path("config"),
) -> None:
    """Write a new study file; the command asks for options that are not given."""
    from overturning.errors import ArgumentError, ConfigError
    from overturning.files import atomic_write, check_output_path
    from overturning.study.document import new_study_file_text
    from overturning.study.load import load_study, read_record_table_rows_of_study
    from overturning.study.preflight import can_compute_fault_alignment

    path = folder / f"{name}.yaml"
    if path.exists():
        raise ArgumentError(f"{path}: exists already; choose another name")
    check_output_path(path, "--folder")
    ids = records.replace(",", " ").split()
    with atomic_write(path) as part:
        part.write_text(new_study_file_text(name, ids, title, step), encoding="utf-8")
        try:
            entries = read_record_table_rows_of_study(load_study(part), str(path))
        except ConfigError as error:  # name the requested file, not the temporary one
            raise ConfigError(str(error).replace(str(part), str(path))) from None
        if can_compute_fault_alignment(entries.values()):
            part.write_text(new_study_file_text(name, ids, title, step, "alignment"), encoding="utf-8")
    print(f"{path}: edit it, then overturning study check {path}")


@app.command("document")
def write_json_schemas_and_study_key_table(
    folder: Annotated[Path, typer.Argument(help="folder for schema.json and README.md")] = Path("config"),
) -> None:
    """Write the JSON schemas of study, findings and survey files, and the table of study keys in config/README.md."""
    from overturning.findings.collect import findings_schema
    from overturning.study.document import write_study_schemas_and_readme_tables
    from overturning.surveys.row import survey_row_json_schema_text

    write_study_schemas_and_readme_tables(folder)
    docs = folder.parent / "docs"
    if docs.is_dir():
        (docs / "findings.schema.json").write_text(findings_schema(), encoding="utf-8")
        (docs / "survey.schema.json").write_text(survey_row_json_schema_text(), encoding="utf-8")
