# Reads and checks the study; names of files and settings that all steps share. No science here.

import hashlib
import json
import sys
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.logging import logger
from snakemake.utils import update_config

from overturning.errors import OverturningError
from overturning.files import atomic_write
from overturning.statistics.fragility_files import measure_file
from overturning.surveys.stones import read_survey
from overturning.study.preflight import (
    check_files,
    check_packages,
    check_records,
    check_results,
    check_size,
    job_seconds,
    fits_single_page,
    size_of,
)
from overturning.study.load import check_study, read_study
from overturning.study.resume import (
    DAMAGED,
    backup_cubes,
    lock,
    restore_cubes,
    remove_leftovers,
    repair,
)
from overturning.study.sources import source_hash
from snakemake_logger_plugin_overturning import QUERY_OPTIONS

DEFAULT_STUDY = Path("config/near-fault.yaml")
# Bytes of a step's settings that go into its command; Linux allows a command of a shell 128 KiB.
LONGEST_SETTINGS = 1 << 16


# The cases of each record in so many jobs; a profile says otherwise by `set-scatter: sweep=8`.
scattergather:
    sweep=1,


CHUNKS = len(gather.sweep("{scatteritem}"))


def load():
    """The checked study, the rows of the record table it uses, and the files of each that the user has put there."""
    given = workflow.config_settings.configfiles
    where = ", ".join(Path(file).name for file in given) or str(DEFAULT_STUDY)
    try:
        for file in given:
            # Snakemake takes a key that stands twice, and 045 for 37, without a word.
            if Path(file).suffix != ".json":
                read_study(Path(file))
        # Snakemake has merged the files of --configfile and the keys of --config already; a workflow that uses this one
        # as a module hands over a whole study, and not only what --config says.
        said = workflow.config_settings.config
        whole = given or ({"name", "records"} <= config.keys() and config != said)
        keys = config if whole else read_study(DEFAULT_STUDY)
        if not whole:
            update_config(keys, config)
        study = check_study(keys, where)
        check_size(study, where, chunks=CHUNKS)
        entries, files = check_files(study, where)
        for survey in study.surveys:
            # A wrong line is better known now than after the sweep.
            read_survey(Path(survey.stones))
        if workflow.is_main_process:
            results = Path("results", study.name)
            # Requests that change nothing neither need the folder alone nor repair it.
            if not (workflow.output_settings.dryrun or QUERY_OPTIONS & set(sys.argv)):
                check_results(results)
                lock(Path(".snakemake", "run.lock"))
                restore_cubes(results)  # which a run that was killed has kept
                for path in repair(results):
                    logger.warning(f"{DAMAGED}{path}")
                for name, count in remove_leftovers(results, entries).items():
                    logger.warning(
                        f"record {name} is no longer in the study: removed its {count} files in {results}"
                    )
            # What has been read before is not read again.
            motion = results / "read"
            new = {
                name: entry
                for name, entry in entries.items()
                if not (motion / f"{name}.nc").is_file()
            }
            soils = [motion / name for name, one in study.variants.items() if one.site]
            # Results that are there can be reported without the packages that made them.
            if (study.site and new) or not all(
                (soil / f"{name}.nc").is_file() for soil in soils for name in entries
            ):
                check_packages(study, where)
            check_records(study, new)
        return study, entries, files
    except OverturningError as error:
        raise WorkflowError(str(error)) from None


STUDY, ENTRIES, FILES = load()
SETTINGS = STUDY.model_dump(mode="json")
RECORDS = list(ENTRIES)
# The cube does not depend on them, nor says anything about them; the report takes them from the study.
BESIDE = (
    *("title", "question", "asks", "primary"),
    *("population", "surveys", "figures", "crate"),
)
# What its cases are, and how they are computed.
CASES = (
    *("scene", "body", "orientation", "azimuth", "height", "b_over_h", "friction"),
    *("density", "contact", "simulation"),
)
OF_CUBE = [key for key in SETTINGS if key not in BESIDE]
VARIANTS = ["nominal", *STUDY.variants]
ON_SOIL = [name for name, variant in STUDY.variants.items() if variant.site]
RESULTS = f"results/{STUDY.name}"
LOGS = f"{RESULTS}/logs"
BENCHMARKS = f"{RESULTS}/benchmarks"  # time and memory of each job, beside its log
REPORT = f"{RESULTS}/report.html"
FIGURES = f"{RESULTS}/figures"
EXPLORER = f"{RESULTS}/explore.html"
# Of a large cube the page is given each record's cells by a file of its own.
CELLS_APART = [] if fits_single_page(STUDY) else [directory(f"{RESULTS}/explore-records")]
PAPER = f"{RESULTS}/report.pdf"
CRATE = f"{RESULTS}/ro-crate-metadata.json"
MEMBERS = f"{RESULTS}/members.csv"
CUBES = [
    f"{RESULTS}/cube.nc",
    *(f"{RESULTS}/cube.{name}.nc" for name in STUDY.variants),
]


# Of Sa(T), over which a population asks for curves.
PERIODS = STUDY.population.period if STUDY.population else ()
FRAGILITY = [f"{RESULTS}/fragility/fragility.csv"] if STUDY.population else []

SURVEYS = list(range(1, len(STUDY.surveys) + 1))
# Those for which the motion is searched for, too.
BACKWARDS = [number for number in SURVEYS if STUDY.surveys[number - 1].backwards]

# Figures of so many records are one job: its imports take longer than drawing one. Each is a rule, as no wildcard is in
# it.
BATCH = max(7, -(-len(RECORDS) // 16))
BATCHES = {
    f"record_figures_{at // BATCH + 1}": RECORDS[at : at + BATCH]
    for at in range(0, len(RECORDS), BATCH)
}

# Of one job of the sweep, for a cluster: memory, and five times the run time that is expected.
SIZE = size_of(STUDY, CHUNKS)
SWEEP_MB = round(SIZE.memory_bytes / 1e6)
READING_MB = round(SIZE.reading_bytes / 1e6)
SECONDS = job_seconds(STUDY, CHUNKS)
SWEEP_MINUTES = 10 + round(SECONDS["sweep"] / 12)

# The line of progress weighs jobs by their expected time.
logger.info(
    "Expected time of jobs",
    extra={
        "expected_s": SECONDS
        | dict.fromkeys(BATCHES, 1.5 + SECONDS["record_figures"] * BATCH)
    },
)

CONVERGENCE = [f"{RESULTS}/convergence.json"] if STUDY.verification != "none" else []


wildcard_constraints:
    record="|".join(map(re.escape, RECORDS)),
    variant="|".join(map(re.escape, VARIANTS)),


def settings(*keys, use=RECORDS, **parts):
    """The part of the study that one step depends on, as a study: what is not in it cannot change that step's result.

    Of a key among the parts the keys inside are named. Where that is too long for a command, of thousands of records,
    it is the name of a file that holds it.
    """
    # A study uses each pulse that stands in it, and what is published is of its records: those of other jobs are left
    # out.
    own = SETTINGS["records"]
    pulses = {name: own["pulses"][name] for name in use if name in own["pulses"]}
    records = own | {"use": list(use), "pulses": pulses}
    part = {key: SETTINGS[key] for key in keys if key != "records"}
    if "published" in part:
        part["published"] = [row for row in part["published"] if row["record"] in use]
    for key, inside in parts.items():
        part[key] = {name: SETTINGS[key][name] for name in inside}
    return handed(json.dumps({"name": STUDY.name, "records": records, **part}), "yaml")


def handed(text, kind):
    """A text for a command; where that is too long for one, the name of a file of a kind that holds it."""
    if len(text) < LONGEST_SETTINGS:
        return text
    # Named by its content, so that a change of it is one of the command; each process of Snakemake finds it or makes
    # it.
    digest = hashlib.sha256(text.encode()).hexdigest()
    path = Path(".snakemake", "settings", f"{digest}.{kind}")
    if not path.is_file():
        with atomic_write(path) as unfinished:
            unfinished.write_text(text, encoding="utf-8")
    return str(path)


# Rooms of the package that the results of a step depend on.
NUMERICS = ("dem", "model", "motion", "study")
DRAWING = (*NUMERICS, "records", "statistics", "surveys", "figures")


def sources(*rooms):
    """Hash of the sources that a step depends on: rooms of the package, and the steps themselves."""
    return source_hash("commands", *rooms)


@cache
def content(path):
    """Hash of a file of the user's: one that takes its place may be older, as files out of an archive are."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def variant_of(wildcards):
    """Name of the contact setting from the suffix of the cube."""
    return wildcards.suffix.removeprefix(".") or "nominal"


def motions_of(variant):
    """Folder of the motions of a variant: of its own ones where it has soil, else of the study's."""
    return f"{RESULTS}/motion/{variant}" if variant in ON_SOIL else f"{RESULTS}/motion"


def samples_of(variant):
    """Folder of the same motions before the labels of the record table are in them."""
    return f"{RESULTS}/read/{variant}" if variant in ON_SOIL else f"{RESULTS}/read"


def parts_of_cube(wildcards):
    """Parts of every record."""
    return gather.sweep(
        f"{RESULTS}/sweep/{variant_of(wildcards)}/{{record}}.{{scatteritem}}.nc",
        record=RECORDS,
    )


def survey_of(wildcards):
    """Settings of a survey by its number."""
    return STUDY.surveys[int(wildcards.number) - 1]


def drawn(name, **wildcards):
    """Files of a figure, one per format, the one that the report shows first."""
    return expand(
        f"{FIGURES}/{name}.{{format}}", format=STUDY.figures.formats, **wildcards
    )
