# Simulation of all cases, one job per record, variant and chunk. The profile sets the number of chunks (set-scatter),
# which does not affect the results. The log contains the progress in per cent.


rule members:
    output:
        MEMBERS,
    log:
        f"{LOGS}/members.log",
    benchmark:
        f"{BENCHMARKS}/members.tsv"
    priority: 3
    params:
        # Without records: a new record in the study must not repeat this rule and with it all parts.
        study=step_settings("ensemble", use=["none"]),
        sources=step_source_hash(*NUMERICS),
    shell:
        "overturning members --study {params.study:q} --output {output} 2> {log}"


rule sweep:
    input:
        motion=lambda wildcards: f"{unlabelled_motion_folder(wildcards.variant)}/{wildcards.record}.nc",
        members=[MEMBERS] if STUDY.ensemble.members else [],
    output:
        f"{RESULTS}/sweep/{{variant}}/{{record}}.{{scatteritem}}.nc",
    log:
        f"{LOGS}/sweep/{{variant}}/{{record}}.{{scatteritem}}.log",
    benchmark:
        f"{BENCHMARKS}/sweep/{{variant}}/{{record}}.{{scatteritem}}.tsv"
    priority: sweep_priority
    threads: 1
    resources:
        mem_mb=lambda wildcards, attempt: attempt * SWEEP_MB,
        runtime=lambda wildcards, attempt: attempt * SWEEP_MINUTES,
    params:
        study=lambda wildcards: step_settings(
            *(*CASES, "amplitude", "ensemble"),
            use=[wildcards.record],
            variant=wildcards.variant,
            variants=own_variant(wildcards),
        ),
        sources=step_source_hash(*NUMERICS),
        members=lambda wildcards, input: " ".join(
            f"--members {each}" for each in input.members
        ),
    shell:
        "overturning sweep --study {params.study:q} --variant {wildcards.variant} --chunk {wildcards.scatteritem}"
        " --motion {input.motion} --output {output} --threads {threads} {params.members} 2> {log}"
