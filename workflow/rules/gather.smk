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
        gather.sweep(
            f"{RESULTS}/sweep/{{variant}}/{{record}}.{{scatteritem}}.csv",
            variant=VARIANTS,
            record=RECORDS,
        ),
        [VERIFICATION_TIMING] if VERIFIED else [],
    output:
        f"{RESULTS}/timing.csv",
    log:
        f"{LOGS}/timing.log",
    localrule: True
    shell:
        "awk 'FNR > 1 || NR == 1' {input} > {output} 2> {log}"
