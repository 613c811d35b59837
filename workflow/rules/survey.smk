# Comparison of surveys of fallen stones with the cube, and inference of the motion, one job per survey each.


rule survey:
    input:
        stones=lambda wildcards: survey_settings(wildcards).stones,
        cube=lambda wildcards: cube_of_ground(survey_grounds(wildcards)[0]),
        site_cubes=lambda wildcards: [
            cube_of_ground(name)
            for name in dict.fromkeys(survey_grounds(wildcards)[1].values())
        ],
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
        site_cubes=lambda wildcards: " ".join(
            f"--site-cube {shlex.quote(f'{site}={cube_of_ground(name)}')}"
            for site, name in survey_grounds(wildcards)[1].items()
        ),
        sources=step_source_hash(*DRAWING, "findings", "report"),
    shell:
        "overturning survey {input.stones:q} --cube {input.cube} {params.site_cubes} --record {params.record}"
        " --background {params.background} --figure {output.figure} --output {output.comparison} > {log} 2>&1"


rule backwards:
    input:
        stones=lambda wildcards: survey_settings(wildcards).stones,
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
        surface=surface_motions_of_survey,
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
            f"--motion {each}" for each in (*input.motions, *input.surface)
        ),
        background=lambda wildcards: survey_settings(wildcards).background,
        sources=step_source_hash("surveys", "statistics", *NUMERICS),
    shell:
        "overturning backwards {input.stones:q} {params.motions} --background {params.background}"
        " --threads {threads} --output {output} > {log} 2>&1"
