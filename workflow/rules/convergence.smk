# Convergence check: a sample of the cases again with finer time steps and stiffer contacts.


rule convergence:
    input:
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
        cube=f"{RESULTS}/cube.nc",
    output:
        f"{RESULTS}/convergence.json",
    log:
        f"{LOGS}/convergence.log",
    benchmark:
        f"{BENCHMARKS}/convergence.tsv"
    priority: 2
    threads: 1
    resources:
        mem_mb=800,
    params:
        study=step_settings(*CASES, "verification"),
        motions=lambda wildcards, input: Path(input.motions[0]).parent,
        sources=step_source_hash(*NUMERICS),
    shell:
        "overturning check-convergence --study {params.study:q} --motions {params.motions} --cube {input.cube}"
        " --output {output} --threads {threads} 2> {log}"
