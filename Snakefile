# Workflow of a study of overturning gravestones, from record files to a report.
#
#   snakemake --cores 2                                       run the default study, config/near-fault.yaml
#   snakemake --cores 2 --configfile config/mine.yaml         run another study
#   snakemake --report provenance.html                        write the provenance of each figure

from snakemake.utils import min_version

min_version("9.27")


# Used only with --software-deployment-method apptainer; `make setup` in the image installs the locked packages.
container: "docker://python:3.12"


# The priorities of the rules set the order of jobs that are ready: first jobs that others wait for; figures of a record
# during the sweep of the next; the report; explore and fragility, which the report does not need; last the crate, which
# describes all results.
include: "workflow/rules/common.smk"
include: "workflow/rules/read.smk"
include: "workflow/rules/rotate.smk"
include: "workflow/rules/sweep.smk"
include: "workflow/rules/gather.smk"
include: "workflow/rules/convergence.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/survey.smk"
include: "workflow/rules/population.smk"
include: "workflow/rules/report.smk"


report: "workflow/report/workflow.rst"


rule all:
    default_target: True
    input:
        # All results: of files that no step needs, Snakemake detects only those listed here as missing. The crate
        # describes every result, and needs each.
        rules.crate.input,
        rules.crate.output,
    localrule: True


# Files of the study that other settings would not make.
MADE = [
    *CONVERGENCE,
    *([MEMBERS] if STUDY.ensemble.members else []),
    *(FRAGILITY and rules.fragility.output),
    *expand(rules.survey.output, number=SURVEYS),
    *expand(rules.backwards.output, number=BACKWARDS),
    *rules.figures.output,
    *(path for name in BATCHES for path in getattr(rules, name).output),
]


onstart:
    for name in remove_results_no_longer_made(
        Path(RESULTS), [str(Path(path).relative_to(RESULTS)) for path in MADE]
    ):
        logger.warning(
            f"{RESULTS}/{name} is not made with the present settings of the study: removed"
        )
    back_up_cubes(Path(RESULTS))
    if workflow.local_exec:
        start_fork_server(Path(BENCHMARKS, "steps.tsv"))


onerror:
    restore_deleted_cubes_from_backups(Path(RESULTS))


onsuccess:
    restore_deleted_cubes_from_backups(Path(RESULTS))
    made = [path for path in (*CUBES, REPORT, EXPLORER) if Path(path).exists()]
    logger.info(
        "\n  ".join([f"Cube and report of the study {STUDY.name!r}:", *made]),
        extra={"result": True},
    )
