# Parts to one cube per contact setting. Run times go into timing.csv and nowhere else: the cube is the same each time.


rule gather:
    input:
        motions=lambda wildcards: expand(
            f"{motions_of(variant_of(wildcards))}/{{record}}.nc", record=RECORDS
        ),
        parts=parts_of_cube,
    output:
        f"{RESULTS}/cube{{suffix}}.nc",
    log:
        f"{LOGS}/gather{{suffix}}.log",
    wildcard_constraints:
        suffix=rf"(?:\.(?:{'|'.join(map(re.escape, STUDY.variants)) or '(?!)'}))?",  # (?!): never
    resources:
        mem_mb=lambda wildcards, attempt: attempt * READING_MB,
    params:
        study=settings(*(key for key in SETTINGS if key not in BESIDE)),
        variant=variant_of,
        motions=lambda wildcards, input: Path(input.motions[0]).parent,
        parts=lambda wildcards, input: Path(input.parts[0]).parent,
        chunks=CHUNKS,
        sources=sources("workflow:gather"),
    shell:
        "overturning gather --study {params.study:q} --variant {params.variant} --motions {params.motions}"
        " --parts {params.parts} --chunks {params.chunks} --output {output} 2> {log}"


rule timing:
    input:
        sweep=gather.sweep(
            f"{RESULTS}/sweep/{{variant}}/{{record}}.{{scatteritem}}.csv",
            variant=VARIANTS,
            record=RECORDS,
        ),
        verification=[VERIFICATION_TIMING] if VERIFIED else [],
    output:
        f"{RESULTS}/timing.csv",
    log:
        f"{LOGS}/timing.log",
    localrule: True
    params:
        study=settings("scene", "body", "orientation", "variants"),
        sweep=lambda wildcards, input: Path(input.sweep[0]).parents[1],
        chunks=CHUNKS,
        verification=lambda wildcards, input: " ".join(
            f"--verification {each}" for each in input.verification
        ),
        sources=sources("workflow:timing"),
    shell:
        "overturning timing --study {params.study:q} --sweep {params.sweep} --chunks {params.chunks}"
        " {params.verification} --output {output} 2> {log}"
