# Record files to processed motions, one job per record. Labels are added by a separate rule: after a change of a label,
# such as the name of an event, no sweep is repeated.


rule read:
    input:
        lambda wildcards: FILES[wildcards.record],
    output:
        f"{RESULTS}/read/{{record}}.nc",
    log:
        f"{LOGS}/read/{{record}}.log",
    benchmark:
        f"{BENCHMARKS}/read/{{record}}.tsv"
    priority: 3
    resources:
        mem_mb=500,
    params:
        study=lambda wildcards: step_settings(
            "processing", "site", use=[wildcards.record]
        ),
        entry=lambda wildcards: ENTRIES[wildcards.record]
        .copy_with_descriptive_columns_reset()
        .model_dump_json(),
        content=lambda wildcards: [file_hash(path) for path in FILES[wildcards.record]],
        sources=step_source_hash("records", "motion", "study"),
    shell:
        "overturning read --study {params.study:q} --record {wildcards.record} --output {output} 2> {log}"


# Motions at the surface of the soil of a variant. One job for all records: its imports take longer than one record.
rule surface:
    input:
        expand(f"{RESULTS}/read/{{record}}.nc", record=RECORDS),
    output:
        expand(f"{RESULTS}/read/{{{{variant}}}}/{{record}}.nc", record=RECORDS),
    log:
        f"{LOGS}/surface/{{variant}}.log",
    benchmark:
        f"{BENCHMARKS}/surface/{{variant}}.tsv"
    wildcard_constraints:
        variant="|".join(map(re.escape, ON_SOIL)) or "(?!)",  # (?!): never
    priority: 3
    resources:
        mem_mb=800,
    params:
        study=lambda wildcards: step_settings(
            *("scene", "body", "orientation"), variants=own_variant(wildcards)
        ),
        motions=lambda wildcards, input: Path(input[0]).parent,
        folder=lambda wildcards, output: Path(output[0]).parent,
        sources=step_source_hash("records", "motion", "study"),
    shell:
        "overturning surface --study {params.study:q} --variant {wildcards.variant} --motions {params.motions}"
        " --output {params.folder} 2> {log}"


# Motion of a record at the surface of the soil below a cemetery, for the comparison with a survey.
rule cemetery_surface:
    input:
        f"{RESULTS}/read/{{record}}.nc",
    output:
        f"{RESULTS}/read/{{ground}}/{{record}}.nc",
    log:
        f"{LOGS}/surface/{{ground}}/{{record}}.log",
    benchmark:
        f"{BENCHMARKS}/surface/{{ground}}/{{record}}.tsv"
    wildcard_constraints:
        ground=GROUND_PATTERN,
    priority: 3
    resources:
        mem_mb=800,
    params:
        study=lambda wildcards: step_settings(
            *("scene", "body", "orientation", "variants"),
            use=[wildcards.record],
            variant=wildcards.ground,
        ),
        motions=lambda wildcards, input: Path(input[0]).parent,
        folder=lambda wildcards, output: Path(output[0]).parent,
        sources=step_source_hash("records", "motion", "study"),
    shell:
        "overturning surface --study {params.study:q} --variant {wildcards.ground} --motions {params.motions}"
        " --output {params.folder} 2> {log}"


rule describe_cemetery:
    input:
        f"{RESULTS}/read/{{ground}}/{{record}}.nc",
    output:
        f"{RESULTS}/motion/{{ground}}/{{record}}.nc",
    log:
        f"{LOGS}/describe/{{ground}}/{{record}}.log",
    benchmark:
        f"{BENCHMARKS}/describe/{{ground}}/{{record}}.tsv"
    wildcard_constraints:
        ground=GROUND_PATTERN,
    priority: 3
    resources:
        mem_mb=800,
    params:
        study=lambda wildcards: step_settings(use=[wildcards.record]),
        labels=lambda wildcards: ENTRIES[wildcards.record].model_dump_json(),
        motions=lambda wildcards, input: Path(input[0]).parent,
        folder=lambda wildcards, output: Path(output[0]).parent,
        sources=step_source_hash("model", "study"),
    shell:
        "overturning describe --study {params.study:q} --motions {params.motions} --output {params.folder} 2> {log}"


# Labels of station, event and site from the record table; samples do not change.
rule describe:
    input:
        expand(f"{RESULTS}/read/{{{{soil}}}}{{record}}.nc", record=RECORDS),
    output:
        expand(f"{RESULTS}/motion/{{{{soil}}}}{{record}}.nc", record=RECORDS),
    log:
        f"{LOGS}/describe/{{soil}}motions.log",
    benchmark:
        f"{BENCHMARKS}/describe/{{soil}}motions.tsv"
    wildcard_constraints:
        soil=rf"(?:(?:{'|'.join(map(re.escape, ON_SOIL)) or '(?!)'})/)?",  # (?!): never
    priority: 3
    resources:
        mem_mb=800,
    params:
        study=step_settings(),
        labels=text_or_file(
            "".join(entry.model_dump_json() for entry in ENTRIES.values()), "txt"
        ),
        motions=lambda wildcards, input: Path(input[0]).parent,
        folder=lambda wildcards, output: Path(output[0]).parent,
        sources=step_source_hash("model", "study"),
    shell:
        "overturning describe --study {params.study:q} --motions {params.motions} --output {params.folder} 2> {log}"
