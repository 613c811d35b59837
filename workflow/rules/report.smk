# Explorer, report and research crate.


rule explore:
    input:
        cube=f"{RESULTS}/cube.nc",
    output:
        CELL_FILES,
        page=EXPLORER,
    log:
        f"{LOGS}/explore.log",
    benchmark:
        f"{BENCHMARKS}/explore.tsv"
    resources:
        mem_mb=1000,
    params:
        study=step_settings(
            *CUBE_KEYS,
            *("title", "question", "language"),
            figures=("height", "friction"),
        ),
        report=Path(REPORT).name,
        sources=step_source_hash(*DRAWING),
    shell:
        "overturning explore {input.cube} --output {output.page} --study {params.study:q}"
        " --report {params.report} > {log} 2>&1"


# Every number of the report, as data.
rule findings:
    input:
        cubes=CUBES,
        intensity=f"{RESULTS}/intensity.nc",
        fragility=FITTED_CURVES,
        convergence=CONVERGENCE,
        backwards=expand(f"{RESULTS}/survey/{{number}}.motion.nc", number=BACKWARDS),
        surveys=expand(f"{RESULTS}/survey/{{number}}.json", number=SURVEYS),
    output:
        FINDINGS,
    log:
        f"{LOGS}/findings.log",
    benchmark:
        f"{BENCHMARKS}/findings.tsv"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * READING_MB,
    params:
        study=step_settings(
            *CUBE_KEYS,
            *("title", "question", "asks", "primary", "population", "surveys"),
            figures=("height", "friction"),
        ),
        sources=step_source_hash(
            *NUMERICS, "records", "statistics", "surveys", "findings"
        ),
    shell:
        "overturning findings {input.cubes[0]} --study {params.study:q} --output {output} > {log} 2>&1"


rule report:
    input:
        findings=FINDINGS,
        cubes=CUBES,
        intensity=f"{RESULTS}/intensity.nc",
        figures=[
            *(path for name in BATCHES for path in getattr(rules, name).output),
            *rules.figures.output,
            *rules.illustrative.output,
        ],
        fragility=FITTED_CURVES,
        convergence=CONVERGENCE,
        backwards=expand(f"{RESULTS}/survey/{{number}}.motion.nc", number=BACKWARDS),
        surveys=expand(f"{RESULTS}/survey/{{number}}.json", number=SURVEYS),
    output:
        pdf=PAPER,
        page=report(
            REPORT,
            caption="../report/report.rst",
            category="Study",
            labels={"figure": "report"},
        ),
    log:
        f"{LOGS}/report.log",
    benchmark:
        f"{BENCHMARKS}/report.tsv"
    priority: 1
    resources:
        mem_mb=lambda wildcards, attempt: attempt * READING_MB,
    params:
        folder=lambda wildcards, output: Path(output[0]).parent,
        study=step_settings(*SETTINGS),
        sources=step_source_hash(*DRAWING, "findings", "report"),
    shell:
        "overturning report --study {params.study:q} --results {params.folder} --output {output.page}"
        " --pdf {output.pdf} 2> {log}"


# Research crate of all results. It lists no parts, logs or run times, so that it does not depend on the execution.
rule crate:
    input:
        rules.report.input,
        rules.report.output,
        rules.findings.output,
        rules.explore.output,
        FRAGILITY and rules.fragility.output,
        expand(rules.survey.output, number=SURVEYS),
        [MEMBERS] if STUDY.ensemble.members else [],
        [
            f"{motion_folder(variant)}/{record}.nc"
            for variant in ["nominal", *ON_SOIL]
            for record in RECORDS
        ],
        [
            path
            for name, records in RECORDS_ON_GROUND.items()
            for path in (
                cube_of_ground(name),
                *(f"{motion_folder(name)}/{record}.nc" for record in records),
            )
        ],
    output:
        f"{RESULTS}/study.yaml",
        crate=CRATE,
    log:
        f"{LOGS}/crate.log",
    benchmark:
        f"{BENCHMARKS}/crate.tsv"
    resources:
        mem_mb=500,
    params:
        study=step_settings(*SETTINGS),
        folder=lambda wildcards, output: Path(output.crate).parent,
        made=lambda wildcards, input: text_or_file("\n".join(sorted(set(input))), "txt"),
        sources=step_source_hash("study", "records"),
    shell:
        "overturning crate --study {params.study:q} --results {params.folder} --made {params.made:q} 2> {log}"
