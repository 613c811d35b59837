# Record files to processed motion, one job per record.


rule read:
    input:
        lambda wildcards: FILES[wildcards.record],
    output:
        f"{RESULTS}/motion/{{record}}.nc",
    log:
        f"{LOGS}/read/{{record}}.log",
    resources:
        mem_mb=500,
    params:
        study=lambda wildcards: settings("processing", use=[wildcards.record]),
        entry=lambda wildcards: ENTRIES[wildcards.record].model_dump_json(),
        sources=sources("workflow:read"),
    shell:
        "overturning read --study {params.study:q} --record {wildcards.record} --output {output} 2> {log}"
