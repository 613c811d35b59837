# Motion to the outcome of every case, one job per record, contact setting and chunk: into how many chunks the cases of
# a record are cut is said by the profile (set-scatter) and shows in no result. The log has per cents.


rule members:
    output:
        MEMBERS,
    log:
        f"{LOGS}/members.log",
    benchmark:
        f"{BENCHMARKS}/members.tsv"
    priority: 3
    params:
        # Of no record: another one in the study must not draw the members again, and with them every part.
        study=settings("ensemble", use=["none"]),
        sources=sources(*NUMERICS),
    shell:
        "overturning members --study {params.study:q} --output {output} 2> {log}"


rule sweep:
    input:
        motion=lambda wildcards: f"{samples_of(wildcards.variant)}/{wildcards.record}.nc",
        members=[MEMBERS] if STUDY.ensemble.members else [],
    output:
        f"{RESULTS}/sweep/{{variant}}/{{record}}.{{scatteritem}}.nc",
    log:
        f"{LOGS}/sweep/{{variant}}/{{record}}.{{scatteritem}}.log",
    benchmark:
        f"{BENCHMARKS}/sweep/{{variant}}/{{record}}.{{scatteritem}}.tsv"
    priority: 1
    threads: 1
    resources:
        mem_mb=lambda wildcards, attempt: attempt * SWEEP_MB,
        runtime=lambda wildcards, attempt: attempt * SWEEP_MINUTES,
    params:
        study=lambda wildcards: settings(
            *(*CASES, "amplitude", "variants", "ensemble"), use=[wildcards.record]
        ),
        sources=sources(*NUMERICS),
        members=lambda wildcards, input: " ".join(
            f"--members {each}" for each in input.members
        ),
    shell:
        "overturning sweep --study {params.study:q} --variant {wildcards.variant} --chunk {wildcards.scatteritem}"
        " --motion {input.motion} --output {output} --threads {threads} {params.members} 2> {log}"
