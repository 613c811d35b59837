# Record files to processed motion, one job per record.


rule read:
    input:
        lambda wildcards: FILES[wildcards.record],
        study=ancient(STUDY_FILE),
    output:
        f"{RESULTS}/motion/{{record}}.nc",
    log:
        f"{LOGS}/read/{{record}}.log",
    resources:
        mem_mb=500,
    params:
        settings=settings("processing"),
        entry=lambda wildcards: ENTRIES[wildcards.record].model_dump_json(),
        sources=sources("read"),
    shell:
        "overturning read --study {input.study} --record {wildcards.record} --output {output} 2> {log}"
