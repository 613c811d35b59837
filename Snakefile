# A study of overturning gravestones, from record files to a report.
#
#   snakemake --cores 2                                       the default study, config/near-fault.yaml
#   snakemake --cores 2 --configfile config/mine.yaml         another one
#   snakemake --report provenance.html                        how each figure came about

import os

from snakemake.utils import min_version

min_version("9.0")


# Used only with --software-deployment-method apptainer; `make setup` in the image gives what the lock pins.
container: "docker://python:3.12"


include: "workflow/rules/common.smk"
include: "workflow/rules/read.smk"
include: "workflow/rules/rotate.smk"
include: "workflow/rules/sweep.smk"
include: "workflow/rules/gather.smk"
include: "workflow/rules/verify.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/survey.smk"
include: "workflow/rules/population.smk"
include: "workflow/rules/report.smk"


report: "workflow/report/workflow.rst"


rule all:
    default_target: True
    input:
        CUBES,
        REPORT,
        FRAGILITY,
        f"{RESULTS}/timing.csv",
    localrule: True


onsuccess:
    print(f"\nCube and report of the study {STUDY.name!r}:")
    for made in filter(os.path.exists, (*CUBES, REPORT)):
        print(f"  {made}")
