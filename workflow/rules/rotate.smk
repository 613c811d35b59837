# Intensity measures of the motions along each azimuth, one job for all records.


rule rotate:
    input:
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
    output:
        f"{RESULTS}/intensity.nc",
    log:
        f"{LOGS}/rotate.log",
    benchmark:
        f"{BENCHMARKS}/rotate.tsv"
    priority: 3
    resources:
        mem_mb=800,
    params:
        folder=lambda wildcards, input: Path(input.motions[0]).parent,
        study=step_settings(
            "azimuth", **({"population": ["period"]} if PERIODS else {})
        ),
        sources=step_source_hash("motion", "study"),
    shell:
        "overturning rotate --study {params.study:q} --motions {params.folder} --output {output} 2> {log}"
