# Record files to processed motion, one job per record.


def files_of_record(wildcards):
    """Files of a record that the user has put there; none for records that come with a package."""
    try:
        return find_paths(ENTRIES[wildcards.record], Path(STUDY.records.folder))
    except OverturningError as error:
        raise WorkflowError(str(error)) from None


rule read:
    input:
        files_of_record,
        study=ancient(STUDY_FILE),
    output:
        f"{RESULTS}/motion/{{record}}.nc",
    log:
        f"{LOGS}/read/{{record}}.log",
    resources:
        mem_mb=500,
    params:
        settings=settings("processing"),
        entry=lambda wildcards: ENTRIES[wildcards.record].model_dump_json(),
        sources=sources("read"),
    shell:
        "overturning read --study {input.study} --record {wildcards.record} --output {output} 2> {log}"
