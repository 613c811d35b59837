# A study of overturning gravestones, from record files to a report.
#
#   snakemake --cores 2                                       the default study, config/near-fault.yaml
#   snakemake --cores 2 --configfile config/mine.yaml         another one
#   snakemake --report provenance.html                        how each figure came about

from snakemake.utils import min_version

min_version("9.27")


# Used only with --software-deployment-method apptainer; `make setup` in the image gives what the lock pins.
container: "docker://python:3.12"


# By `priority` what is ready begins thus: what others wait for; figures of a record beside the sweep of the next; the
# report; what it does not wait for, explore and fragility, beside it; and last the crate, which describes them all.
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
        EXPLORER,
        FRAGILITY,
        expand(rules.survey.output, number=SURVEYS),
        rules.report.input,
        rules.report.output,
        rules.crate.output,
    localrule: True


onstart:
    keep_cubes(Path(RESULTS))


onerror:
    put_cubes_back(Path(RESULTS))


onsuccess:
    put_cubes_back(Path(RESULTS))
    made = [path for path in (*CUBES, REPORT, EXPLORER) if Path(path).exists()]
    logger.info(
        "\n  ".join([f"Cube and report of the study {STUDY.name!r}:", *made]),
        extra={"result": True},
    )
