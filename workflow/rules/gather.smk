# Parts of the sweep to one cube per variant. Cubes are reproducible: run times are stored only in benchmarks/.


rule gather:
    input:
        motions=lambda wildcards: expand(
            f"{motion_folder(variant_name(wildcards))}/{{record}}.nc",
            record=records_of_cube(wildcards),
        ),
        parts=part_files_of_cube,
    output:
        f"{RESULTS}/cube{{suffix}}.nc",
    log:
        f"{LOGS}/gather{{suffix}}.log",
    benchmark:
        f"{BENCHMARKS}/gather{{suffix}}.tsv"
    wildcard_constraints:
        suffix=rf"(?:\.(?:{'|'.join(map(re.escape, [*STUDY.variants, *GROUNDS])) or '(?!)'}))?",  # (?!): never
    priority: 3
    resources:
        mem_mb=lambda wildcards, attempt: attempt * READING_MB,
    params:
        study=lambda wildcards: step_settings(
            *CUBE_KEYS, use=records_of_cube(wildcards), variant=variant_name(wildcards)
        ),
        variant=variant_name,
        motions=lambda wildcards, input: Path(input.motions[0]).parent,
        parts=lambda wildcards, input: Path(input.parts[0]).parent,
        chunks=CHUNKS,
        sources=step_source_hash("model", "study"),
    shell:
        "overturning gather --study {params.study:q} --variant {params.variant} --motions {params.motions}"
        " --parts {params.parts} --chunks {params.chunks} --output {output} 2> {log}"
