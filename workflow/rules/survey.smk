# Comparison of surveys of fallen stones with the cube, and inference of the motion, one job per survey each.


rule survey:
    input:
        stones=lambda wildcards: survey_settings(wildcards).stones,
        cube=f"{RESULTS}/cube.nc",
    output:
        comparison=f"{RESULTS}/survey/{{number}}.json",
        figure=report(
            f"{FIGURES}/survey/{{number}}.svg",
            caption="../report/survey.rst",
            category="Surveys",
        ),
    log:
        f"{LOGS}/survey/{{number}}.log",
    benchmark:
        f"{BENCHMARKS}/survey/{{number}}.tsv"
    wildcard_constraints:
        number=r"\d+",
    priority: 2
    resources:
        mem_mb=500,
    params:
        content=lambda wildcards: file_hash(survey_settings(wildcards).stones),
        record=lambda wildcards: survey_settings(wildcards).record,
        background=lambda wildcards: survey_settings(wildcards).background,
        sources=step_source_hash(*DRAWING, "findings", "report"),
    shell:
        "overturning survey {input.stones:q} --cube {input.cube} --record {params.record}"
        " --background {params.background} --figure {output.figure} --output {output.comparison} > {log} 2>&1"


rule backwards:
    input:
        stones=lambda wildcards: survey_settings(wildcards).stones,
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
    output:
        f"{RESULTS}/survey/{{number}}.motion.nc",
    log:
        f"{LOGS}/survey/{{number}}.motion.log",
    benchmark:
        f"{BENCHMARKS}/survey/{{number}}.motion.tsv"
    wildcard_constraints:
        number=r"\d+",
    priority: 2
    threads: 2
    resources:
        mem_mb=800,
    params:
        content=lambda wildcards: file_hash(survey_settings(wildcards).stones),
        motions=lambda wildcards, input: " ".join(
            f"--motion {each}" for each in input.motions
        ),
        background=lambda wildcards: survey_settings(wildcards).background,
        sources=step_source_hash("surveys", "statistics", *NUMERICS),
    shell:
        "overturning backwards {input.stones:q} {params.motions} --background {params.background}"
        " --threads {threads} --output {output} > {log} 2>&1"
