# Reading and checking of the study; names of files and settings that all rules share.

import hashlib
import json
import shlex
import sys
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.logging import logger
from snakemake.utils import update_config

from overturning.commands.fork_client import start_fork_server
from overturning.errors import OverturningError
from overturning.files import atomic_write
from overturning.statistics.fragility_files import openquake_file_name
from overturning.surveys.counted_stones import read_counted_stones
from overturning.study.grounds import (
    soil_layers_and_records_by_soil_cube_name,
    check_soil_sites_occur_in_survey_table,
    survey_cube_name_and_other_cube_names_by_site,
)
from overturning.study.preflight import (
    find_record_rows_and_files,
    check_soil_curve_package,
    read_and_process_records_and_collect_notes,
    check_results_folder_is_writable,
    estimate_and_check_study_size,
    estimate_job_seconds_by_workflow_rule,
    explorer_fits_single_page,
    estimate_cases_time_memory_and_disk_of_study,
)
from overturning.study.load import study_from_content, read_unvalidated_study_content
from overturning.study.resume import (
    DAMAGED_FILE_LOG_PREFIX,
    back_up_cubes,
    lock_results_folder_or_refuse,
    restore_deleted_cubes_from_backups,
    remove_files_of_dropped_records,
    remove_damaged_results_and_fix_future_times,
    remove_results_no_longer_made,
)
from overturning.study.sources import package_source_hash
from snakemake_logger_plugin_overturning import SNAKEMAKE_OPTIONS_WITHOUT_COMPUTATION

DEFAULT_STUDY = Path("config/near-fault.yaml")
# Largest size of settings passed on the command line, bytes; Linux limits an argument to 128 KiB.
LONGEST_SETTINGS = 1 << 16


# Number of jobs for the cases of each record; a profile changes it by `set-scatter: sweep=8`.
scattergather:
    sweep=1,


CHUNKS = len(gather.sweep("{scatteritem}"))


def load_study_and_records():
    """Return the checked study, the entries of its records in the record table, and the files of each record."""
    given = workflow.config_settings.configfiles
    where = ", ".join(Path(file).name for file in given) or str(DEFAULT_STUDY)
    try:
        for file in given:
            # Snakemake silently accepts duplicate keys and reads 045 as 37: check the files first.
            if Path(file).suffix != ".json":
                read_unvalidated_study_content(Path(file))
        # Snakemake has already merged the files of --configfile and the keys of --config. A workflow that uses this one
        # as a module passes a complete study, not only the keys of --config.
        overrides = workflow.config_settings.config
        whole = given or ({"name", "records"} <= config.keys() and config != overrides)
        remedy = "name a study file with --configfile"
        keys = (
            config if whole else read_unvalidated_study_content(DEFAULT_STUDY, remedy)
        )
        if not whole:
            update_config(keys, config)
        study = study_from_content(keys, where)
        estimate_and_check_study_size(study, where, chunks_per_record=CHUNKS)
        entries, files = find_record_rows_and_files(study, where)
        for number, survey in enumerate(study.surveys):
            # Report errors in the survey now, not after the sweep.
            stones = read_counted_stones(Path(survey.stones))
            check_soil_sites_occur_in_survey_table(
                study, number, {one.site for one in stones}, where
            )
        if workflow.is_main_process:
            results = Path("results", study.name)
            # Requests that compute nothing need neither the lock nor a repair.
            if not (
                workflow.output_settings.dryrun
                or SNAKEMAKE_OPTIONS_WITHOUT_COMPUTATION & set(sys.argv)
            ):
                check_results_folder_is_writable(results)
                lock_results_folder_or_refuse(Path(".snakemake", "run.lock"))
                # An interrupted run has kept the backups.
                restore_deleted_cubes_from_backups(results)
                for path in remove_damaged_results_and_fix_future_times(results):
                    logger.warning(f"{DAMAGED_FILE_LOG_PREFIX}{path}")
                for name, count in remove_files_of_dropped_records(
                    results, entries
                ).items():
                    logger.warning(
                        f"record {name} is no longer in the study: removed its {count} files in {results}"
                    )
            # Records that were read before are not read again.
            motion = results / "read"
            new = {
                name: entry
                for name, entry in entries.items()
                if not (motion / f"{name}.nc").is_file()
            }
            surface = [
                motion / variant / f"{name}.nc"
                for variant, one in study.variants.items()
                if one.site
                for name in entries
            ]
            for ground, (_, names) in soil_layers_and_records_by_soil_cube_name(
                study
            ).items():
                surface += [motion / ground / f"{name}.nc" for name in names]
            # A report of existing results does not need the packages that computed them.
            if (study.site and new) or not all(path.is_file() for path in surface):
                check_soil_curve_package(study, where)
            read_and_process_records_and_collect_notes(study, new)
        return study, entries, files
    except OverturningError as error:
        raise WorkflowError(str(error)) from None


STUDY, ENTRIES, FILES = load_study_and_records()
SETTINGS = STUDY.model_dump(mode="json")
RECORDS = list(ENTRIES)
ORDER = {name: place for place, name in enumerate(RECORDS)}
# Keys that do not affect the cube; the report reads them from the study.
REPORT_KEYS = (
    *("title", "question", "asks", "language", "primary"),
    *("population", "surveys", "figures", "crate"),
)
# Keys that define the cases and their computation.
CASES = (
    *("scene", "body", "orientation", "azimuth", "height", "b_over_h", "friction"),
    *("density", "contact", "simulation"),
)
CUBE_KEYS = [key for key in SETTINGS if key not in REPORT_KEYS]
VARIANTS = ["nominal", *STUDY.variants]
ON_SOIL = [name for name, variant in STUDY.variants.items() if variant.site]
# Soil below cemeteries of surveys, by name of its cube; computed like a variant, for the records of the surveys only.
GROUNDS = {
    name: soil.model_dump(mode="json")
    for name, (soil, _) in soil_layers_and_records_by_soil_cube_name(STUDY).items()
}
RECORDS_ON_GROUND = {
    name: use
    for name, (_, use) in soil_layers_and_records_by_soil_cube_name(STUDY).items()
}
GROUND_PATTERN = "|".join(map(re.escape, GROUNDS)) or "(?!)"  # (?!): never
RESULTS = f"results/{STUDY.name}"
LOGS = f"{RESULTS}/logs"
BENCHMARKS = f"{RESULTS}/benchmarks"  # time and memory of each job
REPORT = f"{RESULTS}/report.html"
FIGURES = f"{RESULTS}/figures"
EXPLORER = f"{RESULTS}/explore.html"
FINDINGS = f"{RESULTS}/findings.json"
# The page of a large cube has a separate file with the cells of each record.
CELL_FILES = (
    []
    if explorer_fits_single_page(STUDY)
    else [directory(f"{RESULTS}/explore-records")]
)
PAPER = f"{RESULTS}/report.pdf"
CRATE = f"{RESULTS}/ro-crate-metadata.json"
MEMBERS = f"{RESULTS}/members.csv"
CUBES = [
    f"{RESULTS}/cube.nc",
    *(f"{RESULTS}/cube.{name}.nc" for name in STUDY.variants),
]


# Periods T of the measures Sa(T) for fragility curves of the population.
PERIODS = STUDY.population.period if STUDY.population else ()
FRAGILITY = [f"{RESULTS}/fragility/fragility.csv"] if STUDY.population else []
FITTED_CURVES = [f"{RESULTS}/fragility/curves.json"] if STUDY.population else []

SURVEYS = list(range(1, len(STUDY.surveys) + 1))
# Surveys for which the motion is inferred, too.
BACKWARDS = [number for number in SURVEYS if STUDY.surveys[number - 1].backwards]

# Number of records whose figures are drawn in one job. With few records the first figure appears early; with one, the
# imports of a job without fork server (on a cluster) would take longer than its figures. Each batch is a separate rule,
# because it has no wildcard.
BATCH = max(4, -(-len(RECORDS) // 16))
BATCHES = {
    f"record_figures_{at // BATCH + 1}": RECORDS[at : at + BATCH]
    for at in range(0, len(RECORDS), BATCH)
}

# Memory and time limit of one job of the sweep, for a cluster; the limit is five times the expected time.
SIZE = estimate_cases_time_memory_and_disk_of_study(STUDY, CHUNKS)
SWEEP_MB = round(SIZE.largest_job_memory_bytes / 1e6)
READING_MB = round(SIZE.cube_reading_memory_bytes / 1e6)
SECONDS = estimate_job_seconds_by_workflow_rule(STUDY, CHUNKS)
SWEEP_MINUTES = 10 + round(SECONDS["sweep"] / 12)

# The progress line weights jobs by their expected time; the first figure is named as soon as the file exists.
logger.info(
    "Expected time of jobs",
    extra={
        "expected_s": SECONDS
        | dict.fromkeys(BATCHES, 0.5 + SECONDS["record_figures"] * BATCH),
        "first_figure": f"{FIGURES}/polar/{RECORDS[0]}.svg",
    },
)

CONVERGENCE = [f"{RESULTS}/convergence.json"] if STUDY.verification != "none" else []


wildcard_constraints:
    record="|".join(map(re.escape, RECORDS)),
    variant="|".join(map(re.escape, [*VARIANTS, *GROUNDS])),


def step_settings(*keys, use=RECORDS, variant="nominal", **parts):
    """Return the part of the study on which a step depends, as JSON, so that other changes do not repeat the step.

    `keys` are whole keys of the study; `parts` names keys inside a key. If the text is too long for a command (for
    thousands of records), the name of a file with the text is returned. For the soil below a cemetery (`variant`), the
    soil is the only variant, and records are not multiplied by further amplitudes.
    """
    # A study must use each of its pulses, and published values must belong to its records: leave out the others.
    own = SETTINGS["records"]
    pulses = {name: own["pulses"][name] for name in use if name in own["pulses"]}
    records = own | {"use": list(use), "pulses": pulses}
    # A stack has no azimuths.
    part = {key: SETTINGS[key] for key in keys if key != "records" and key in SETTINGS}
    # Only a 3-D body may have an ensemble of reliefs and orientations; other ensembles do not depend on the body.
    if {"relief", "orientation"} & part.get("ensemble", {}).keys():
        part["body"] = SETTINGS["body"]
    if "published" in part:
        part["published"] = [row for row in part["published"] if row["record"] in use]
    for key, inside in parts.items():
        part[key] = {name: SETTINGS[key][name] for name in inside}
    if variant in GROUNDS:
        own = {"variants": {variant: {"site": GROUNDS[variant]}}, "amplitude": [1.0]}
        part |= {key: value for key, value in own.items() if key in part}
    return text_or_file(
        json.dumps({"name": STUDY.name, "records": records, **part}), "yaml"
    )


def text_or_file(text, kind):
    """Return a text for a command, or the name of a file with the text if it is too long."""
    if len(text) < LONGEST_SETTINGS:
        return text
    # The name depends on the content, so that a change of the content changes the command. Each process of Snakemake
    # finds the file or writes it.
    digest = hashlib.sha256(text.encode()).hexdigest()
    path = Path(".snakemake", "settings", f"{digest}.{kind}")
    if not path.is_file():
        with atomic_write(path) as unfinished:
            unfinished.write_text(text, encoding="utf-8")
    return str(path)


# Subpackages on which the results of a step depend.
NUMERICS = ("dem", "model", "motion", "study")
DRAWING = (*NUMERICS, "records", "statistics", "surveys", "translation", "figures")


def step_source_hash(*subpackages):
    """Return the hash of the sources on which a step depends: the given subpackages and `commands`."""
    return package_source_hash("commands", *subpackages)


@cache
def file_hash(path):
    """Return the hash of a user's file; its time is not sufficient, because a replacement may be older."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def variant_name(wildcards):
    """Return the name of the variant from the suffix of the cube."""
    return wildcards.suffix.removeprefix(".") or "nominal"


def own_variant(wildcards):
    """Return a list with the variant of a job, or [] if the job is not of a variant of the study.

    A step that is given its own variant alone does not run again if another one is added, changed or removed.
    """
    return [name for name in STUDY.variants if name == wildcards.variant]


def motion_folder(variant):
    """Return the folder of the motions of a variant: its own folder if it has soil layers, else that of the study."""
    own = variant in ON_SOIL or variant in GROUNDS
    return f"{RESULTS}/motion/{variant}" if own else f"{RESULTS}/motion"


def unlabelled_motion_folder(variant):
    """Return the folder of the motions of a variant without the labels of the record table."""
    own = variant in ON_SOIL or variant in GROUNDS
    return f"{RESULTS}/read/{variant}" if own else f"{RESULTS}/read"


def records_of_cube(wildcards):
    """Return the records of a cube: all of the study, or those of the surveys on the soil below a cemetery."""
    return RECORDS_ON_GROUND.get(variant_name(wildcards), RECORDS)


def part_files_of_cube(wildcards):
    """Return the parts of a cube, for all records and chunks."""
    return gather.sweep(
        f"{RESULTS}/sweep/{variant_name(wildcards)}/{{record}}.{{scatteritem}}.nc",
        record=records_of_cube(wildcards),
    )


def cube_of_ground(name):
    """Return the cube with the motion at the surface of some soil, by the name of the variant or soil."""
    return f"{RESULTS}/cube.nc" if name == "nominal" else f"{RESULTS}/cube.{name}.nc"


def sweep_priority(wildcards):
    """Return a priority above 1, up to 2, that decreases along the list of records, so that a figure is drawn soon.

    The figures of the first records are drawn as soon as the sweeps of these records end. Parts of variants come last,
    because no figure of a record needs them.
    """
    if wildcards.variant != "nominal":
        return 1
    return 2 - ORDER[wildcards.record] / len(RECORDS)


def survey_settings(wildcards):
    """Return the settings of a survey by its number."""
    return STUDY.surveys[int(wildcards.number) - 1]


def survey_grounds(wildcards):
    """Return the name of the ground of a survey (`cube_of_ground`), and those of single cemeteries by name."""
    return survey_cube_name_and_other_cube_names_by_site(
        STUDY, survey_settings(wildcards)
    )


def surface_motions_of_survey(wildcards):
    """Return the motions of the record of a survey at the surfaces of the soils below its cemeteries."""
    default, by_site = survey_grounds(wildcards)
    soils = [name for name in {default: None, **dict.fromkeys(by_site.values())}]
    record = survey_settings(wildcards).record
    return [f"{motion_folder(name)}/{record}.nc" for name in soils if name != "nominal"]


def figure_files(name, **wildcards):
    """Return the files of a figure, one per format; the first is the one in the report."""
    return expand(
        f"{FIGURES}/{name}.{{format}}", format=STUDY.figures.formats, **wildcards
    )
