"""Steps of the workflow: each subcommand does the work of one rule, for a study given as a file or as JSON.

Imports are inside the functions, so that each command starts quickly.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

StudyFileOrJsonOption = Annotated[str, typer.Option(help="study file, or its content as JSON")]
OptionalStudyOption = Annotated[
    str | None,
    typer.Option("--study", help="study file or JSON; its figures, surveys and population replace those of the cube"),
]
MotionFolderOption = Annotated[Path, typer.Option(help="folder of the motions")]
VariantNameOption = Annotated[str, typer.Option(help="name of the contact setting")]
ThreadCountOption = Annotated[int, typer.Option(min=1, help="number of threads or processes")]
ChunkCountOption = Annotated[
    int, typer.Option(min=1, help="number of chunks into which the cases of each record are split")
]
OutcomePartFolderOption = Annotated[Path, typer.Option(help="folder of the parts")]
CubePathOption = Annotated[Path, typer.Option(help="the study's cube (NetCDF)")]
IntensityMeasureFileOption = Annotated[Path, typer.Option(help="intensity measures of the study's records (NetCDF)")]
FigureFolderOption = Annotated[Path, typer.Option(help="folder for the figures")]
NetCDFOutputOption = Annotated[Path, typer.Option(help="NetCDF file to write")]


def _create_percent_progress_printer() -> Callable[[int, int], None]:
    """Return a function that prints progress in per cent on standard error, at most once a second, for the log."""
    last, said = time.monotonic(), 0

    def print_progress(finished_work_unit_count: int, total_case_or_step_count: int) -> None:
        """Print the share of finished work in per cent, if it has risen and the last output is over 1 s ago.

        A unit of work is whatever the simulation counts, such as a case or a time step of a block.
        """
        nonlocal last, said
        now, share = (
            time.monotonic(),
            100 * finished_work_unit_count // total_case_or_step_count if total_case_or_step_count else 100,
        )
        if share > said and now - last >= 1.0:
            last, said = now, share
            print(f"{share}%", file=sys.stderr, flush=True)

    return print_progress


def read_and_process_record(
    study: StudyFileOrJsonOption,
    record: Annotated[str, typer.Option(help="id in the record table")],
    output: NetCDFOutputOption,
) -> None:
    """Read and process one record, and write its motion; station, event and site names are added later."""
    from overturning.errors import ArgumentError
    from overturning.records.processing import process_record
    from overturning.records.read import read_record_without_station_and_event_names
    from overturning.records.store import write_record_to_motion_file
    from overturning.study.load import load_study_from_file_or_json, read_record_table_rows_of_study

    settings = load_study_from_file_or_json(study)
    entries = read_record_table_rows_of_study(settings, settings.name)
    if record not in entries:
        raise ArgumentError(f"--record {record}: not in the study {settings.name}; it has {', '.join(entries)}")
    entry = entries[record]
    raw = read_record_without_station_and_event_names(entry, Path(settings.records.folder))
    done = process_record(raw, settings.processing, settings.site)
    write_record_to_motion_file(done, output, unprocessed_record=None if done is raw else raw)


def _load_study_and_processed_motions(study_file_or_json: str, motion_folder: Path) -> tuple[Any, list[Any]]:
    """Return a study, and the processed motions of its records, read from a folder, in the order of the study."""
    from overturning.records.store import read_record_from_motion_file
    from overturning.study.load import load_study_from_file_or_json

    settings = load_study_from_file_or_json(study_file_or_json)
    return settings, [read_record_from_motion_file(motion_folder / f"{name}.nc") for name in settings.records.use]


def compute_surface_motions(
    study: StudyFileOrJsonOption,
    motions: MotionFolderOption,
    output: Annotated[Path, typer.Option(help="folder for the motions at the surface")],
    variant: VariantNameOption = "nominal",
) -> None:
    """Compute the surface motion of each record on top of the soil layers of one variant of a study."""
    from overturning.records.processing import process_record
    from overturning.records.store import write_record_to_motion_file
    from overturning.study.scenes import settings_changed_by_variant

    settings, records = _load_study_and_processed_motions(study, motions)
    for rock in records:
        write_record_to_motion_file(
            process_record(rock, (), settings_changed_by_variant(settings, variant).site),
            output / f"{rock.record_id}.nc",
            unprocessed_record=rock,
        )


def add_station_event_and_site_to_motions(
    study: StudyFileOrJsonOption,
    motions: MotionFolderOption,
    output: Annotated[Path, typer.Option(help="folder for the motions with labels")],
) -> None:
    """Add station, event and site from the record table to the stored motions of all records."""
    from overturning.records import read
    from overturning.records.store import (
        read_record_before_processing_if_processed,
        read_record_from_motion_file,
        write_record_to_motion_file,
    )
    from overturning.study.load import load_study_from_file_or_json, read_record_table_rows_of_study

    settings = load_study_from_file_or_json(study)
    for name, entry in read_record_table_rows_of_study(settings, settings.name).items():
        path = motions / f"{name}.nc"
        before = read_record_before_processing_if_processed(path)
        labelled = None if before is None else read.copy_record_with_metadata_of_table_row(before, entry)
        write_record_to_motion_file(
            read.copy_record_with_metadata_of_table_row(read_record_from_motion_file(path), entry),
            output / path.name,
            unprocessed_record=labelled,
        )


def compute_intensity_measures(
    study: StudyFileOrJsonOption, motions: MotionFolderOption, output: NetCDFOutputOption
) -> None:
    """Compute the intensity measures, such as PGA, of all records along each azimuth of the study."""
    from overturning.study.intensity import write_intensity_measures

    write_intensity_measures(*_load_study_and_processed_motions(study, motions), output)


def write_random_parameter_changes_of_ensemble(
    study: StudyFileOrJsonOption, output: Annotated[Path, typer.Option(help="table of members to write (CSV)")]
) -> None:
    """Draw the random parameter changes of the runs (members) of a study's ensemble, and write them as CSV."""
    from overturning.study.ensemble_members import draw_parameter_changes_of_members
    from overturning.study.load import load_study_from_file_or_json

    draw_parameter_changes_of_members(load_study_from_file_or_json(study).ensemble).write_csv(output)


def simulate_cases_of_record(
    study: StudyFileOrJsonOption,
    motion: Annotated[Path, typer.Option(help="processed motion (NetCDF)")],
    output: NetCDFOutputOption,
    variant: VariantNameOption = "nominal",
    chunk: Annotated[str, typer.Option(help="number of the chunk and of all chunks: 3-of-8")] = "1-of-1",
    members: Annotated[Path | None, typer.Option(help="members of the ensemble (CSV)")] = None,
    threads: ThreadCountOption = 1,
) -> None:
    """Simulate all cases of one record, or one chunk (part) of them, and write the outcomes."""
    from overturning.records.store import read_record_from_motion_file
    from overturning.study.ensemble_members import EnsembleParameterChanges
    from overturning.study.load import load_study_from_file_or_json
    from overturning.study.parts import SweepChunk
    from overturning.study.scenes import numerical_options_of_study
    from overturning.study.sweep import simulate_and_write_cases_of_record

    settings, part = load_study_from_file_or_json(study), SweepChunk.parse(chunk)
    record, drawn = (
        read_record_from_motion_file(motion),
        EnsembleParameterChanges.read_csv(members) if members else None,
    )
    numerics = numerical_options_of_study(settings, threads, _create_percent_progress_printer())
    simulate_and_write_cases_of_record(settings, record, output, variant, members=drawn, chunk=part, numerics=numerics)


def merge_outcome_files_into_cube(
    study: StudyFileOrJsonOption,
    motions: MotionFolderOption,
    parts: OutcomePartFolderOption,
    output: NetCDFOutputOption,
    variant: VariantNameOption = "nominal",
    chunks: ChunkCountOption = 1,
) -> None:
    """Combine the files with outcomes of all records and chunks into the results cube of a study or variant."""
    from overturning.study.gather import merge_outcome_files_into_cube
    from overturning.study.parts import paths_of_chunk_outcome_files

    settings, records = _load_study_and_processed_motions(study, motions)
    merge_outcome_files_into_cube(
        settings, records, paths_of_chunk_outcome_files(parts, settings.records.use, chunks), output, variant
    )


def fit_fragility(
    study: StudyFileOrJsonOption,
    cube: CubePathOption,
    intensity: IntensityMeasureFileOption,
    output: Annotated[Path, typer.Option(help="folder for fragility.csv, curves.json and the OpenQuake models (XML)")],
) -> None:
    """Fit fragility curves to the share of a stone population that falls; write them as CSV and for OpenQuake."""
    import xarray as xr

    from overturning.errors import ConfigError
    from overturning.statistics.fragility_files import (
        is_openquake_measure,
        openquake_file_name,
        write_fragility_csv,
        write_openquake_fragility_model,
    )
    from overturning.study.cube import open_cube
    from overturning.study.load import load_study_from_file_or_json
    from overturning.surveys.fragility_results import FRAGILITY_CURVES_PATH, write_fragility_curves
    from overturning.surveys.population import fit_population_fragility_curves, population_outcome_rates_by_record

    settings = load_study_from_file_or_json(study)
    if settings.population is None:
        raise ConfigError(f"{settings.name}: no population; add the key population to the study")
    with open_cube(cube, amplitude=None) as outcomes, xr.open_dataset(intensity) as measures:
        rates = population_outcome_rates_by_record(outcomes, settings.population)
        curves = fit_population_fragility_curves(rates, measures)
        write_fragility_curves(curves, rates, measures, output / FRAGILITY_CURVES_PATH.name)
    write_fragility_csv(curves, output / "fragility.csv")
    for measure in filter(is_openquake_measure, dict.fromkeys(one.measure for one in curves)):
        chosen = [one for one in curves if one.measure == measure]
        write_openquake_fragility_model(chosen, output / openquake_file_name(measure), "gravestones")


def recompute_sample_to_check_convergence(
    study: StudyFileOrJsonOption,
    motions: MotionFolderOption,
    cube: CubePathOption,
    output: Annotated[Path, typer.Option(help="result file to write (JSON)")],
    threads: ThreadCountOption = 1,
) -> None:
    """Simulate a random sample of cases again with finer time steps and stiffer contacts, and store the changes."""
    from overturning.errors import ConfigError
    from overturning.stored import write_result_as_json
    from overturning.study.convergence_check import rerun_cases_with_finer_steps_and_stiffer_contacts
    from overturning.study.sample import read_random_case_sample, read_sample_to_compare_with_rigid_block

    settings, records = _load_study_and_processed_motions(study, motions)
    if isinstance(settings.verification, str):
        raise ConfigError(f"{settings.name}: verification: none; remove the key for a convergence check")
    sample = read_random_case_sample(cube, settings.verification)
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings,
        records,
        sample,
        threads,
        _create_percent_progress_printer(),
        read_sample_to_compare_with_rigid_block(cube, settings),
    )
    write_result_as_json(found, output)


def draw_figures_of_records(
    study: StudyFileOrJsonOption,
    parts: OutcomePartFolderOption,
    intensity: IntensityMeasureFileOption,
    motions: MotionFolderOption,
    output: FigureFolderOption,
    chunks: ChunkCountOption = 1,
) -> None:
    """Draw the figures of single records from the files with their outcomes."""
    from functools import partial
    from tempfile import TemporaryDirectory

    from overturning.figures.record import draw_record_figures
    from overturning.figures.write import write_figure_and_delete_files_in_other_formats
    from overturning.study.gather import merge_outcome_files_into_cube
    from overturning.study.parts import paths_of_chunk_outcome_files
    from overturning.translation.texts import use_translation_language

    settings, records = _load_study_and_processed_motions(study, motions)
    write = partial(write_figure_and_delete_files_in_other_formats, settings.figures)
    with TemporaryDirectory() as folder, use_translation_language(settings.language):
        cube = Path(folder) / "cube.nc"
        merge_outcome_files_into_cube(
            settings, records, paths_of_chunk_outcome_files(parts, settings.records.use, chunks), cube
        )
        draw_record_figures(cube, intensity, output, write)


def draw_figures_of_study(
    study: StudyFileOrJsonOption,
    cube: CubePathOption,
    intensity: IntensityMeasureFileOption,
    output: FigureFolderOption,
) -> None:
    """Draw the figures that combine all records of a study, and the map of its stations."""
    from functools import partial

    from overturning.figures.study import draw_study_figures
    from overturning.figures.write import write_figure_and_delete_files_in_other_formats
    from overturning.study.load import load_study_from_file_or_json
    from overturning.translation.texts import use_translation_language

    settings = load_study_from_file_or_json(study)
    with use_translation_language(settings.language):
        draw_study_figures(
            cube, intensity, output, partial(write_figure_and_delete_files_in_other_formats, settings.figures)
        )


def choose_rerun_and_draw_illustrative_cases(
    cube: CubePathOption,
    motions: MotionFolderOption,
    output: FigureFolderOption,
    compared_cube: Annotated[
        Path | None,
        typer.Option("--against", help="cube of the variant with which the study is compared, for the first film"),
    ] = None,
    record: Annotated[
        list[str] | None, typer.Option(help="record from which cases are chosen (repeatable); all if not given")
    ] = None,
) -> None:
    """Choose the cases that best illustrate a study; simulate them again and draw their films and figures."""
    from overturning.figures.illustrative import choose_simulate_and_draw_illustrative_cases

    choose_simulate_and_draw_illustrative_cases(cube, motions, output, compared_cube, record or ())


def write_study_report(
    results: Annotated[Path, typer.Option(help="folder of the study's results")],
    output: Annotated[Path, typer.Option(help="page to write (HTML)")],
    pdf: Annotated[Path | None, typer.Option(help="PDF file of the report")] = None,
    study: OptionalStudyOption = None,
    language: Annotated[str | None, typer.Option(help="language: en or ja; not given: that of the study")] = None,
) -> None:
    """Write the HTML report of a study from its results folder; on request also as PDF."""
    from overturning.report.write import write_report
    from overturning.study.load import load_study_from_file_or_json

    write_report(results, output, pdf, load_study_from_file_or_json(study) if study else None, language)


def write_research_data_package(
    results: Annotated[Path, typer.Option(help="folder of the study's results")],
    produced_files: Annotated[
        str, typer.Option("--made", help="files and folders to describe, one per line, or a file with them")
    ],
    study: StudyFileOrJsonOption,
) -> None:
    """Write the study file and the metadata that describe the results as a research data package (RO-Crate)."""
    from overturning.study.crate import write_complete_study_file_and_ro_crate_metadata
    from overturning.study.load import load_study_from_file_or_json

    names = produced_files if "\n" in produced_files else Path(produced_files).read_text(encoding="utf-8")
    write_complete_study_file_and_ro_crate_metadata(
        load_study_from_file_or_json(study), results, [Path(name) for name in names.splitlines()]
    )


WORKFLOW_STEPS_BY_COMMAND: dict[str, Callable[..., None]] = {
    "read": read_and_process_record,
    "surface": compute_surface_motions,
    "describe": add_station_event_and_site_to_motions,
    "rotate": compute_intensity_measures,
    "members": write_random_parameter_changes_of_ensemble,
    "sweep": simulate_cases_of_record,
    "gather": merge_outcome_files_into_cube,
    "check-convergence": recompute_sample_to_check_convergence,
    "fragility": fit_fragility,
    "record-figures": draw_figures_of_records,
    "figures": draw_figures_of_study,
    "illustrative": choose_rerun_and_draw_illustrative_cases,
    "report": write_study_report,
    "crate": write_research_data_package,
}
"""Functions of all steps by command name, in the order of a run."""
