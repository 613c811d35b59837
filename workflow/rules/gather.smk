# Parts to one cube per contact setting. Run times go into timing.csv and nowhere else: the cube is the same each time.


def variant_of(wildcards):
    """Name of the contact setting from the suffix of the cube."""
    return wildcards.suffix.removeprefix(".") or "nominal"


def parts_of_cube(wildcards):
    """Parts of every record."""
    return expand(
        f"{RESULTS}/sweep/{variant_of(wildcards)}/{{record}}.nc", record=RECORDS
    )


rule gather:
    input:
        study=ancient(STUDY_FILE),
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
        parts=parts_of_cube,
    output:
        f"{RESULTS}/cube{{suffix}}.nc",
    log:
        f"{LOGS}/gather{{suffix}}.log",
    wildcard_constraints:
        suffix=rf"(?:\.(?:{'|'.join(map(re.escape, STUDY.variants)) or '(?!)'}))?",  # (?!): never
    resources:
        mem_mb=800,
    params:
        study=STUDY.model_dump_json(),
        variant=variant_of,
        motions=f"{RESULTS}/motion",
        sweep=f"{RESULTS}/sweep",
        sources=sources("gather"),
    shell:
        "overturning gather --study {input.study} --variant {params.variant} --motions {params.motions}"
        " --parts {params.sweep}/{params.variant} --output {output} 2> {log}"


rule timing:
    input:
        expand(
            f"{RESULTS}/sweep/{{variant}}/{{record}}.csv",
            variant=VARIANTS,
            record=RECORDS,
        ),
    output:
        f"{RESULTS}/timing.csv",
    log:
        f"{LOGS}/timing.log",
    localrule: True
    shell:
        "awk 'FNR > 1 || NR == 1' {input} > {output} 2> {log}"
