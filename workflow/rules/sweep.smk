# Motion to the outcome of every case, one job per record and contact setting. How far the whole sweep is stands on the
# terminal; the log has a line now and then.


rule sweep:
    input:
        motion=f"{RESULTS}/motion/{{record}}.nc",
    output:
        part=f"{RESULTS}/sweep/{{variant}}/{{record}}.nc",
        timing=f"{RESULTS}/sweep/{{variant}}/{{record}}.csv",
    log:
        f"{LOGS}/sweep/{{variant}}/{{record}}.log",
    threads: 1
    resources:
        mem_mb=800,
        # Only for the progress line; unlike a parameter it does not make a sweep run again when a record is added.
        records=len(RECORDS),
    params:
        study=lambda wildcards: settings(
            *("azimuth", "height", "b_over_h", "friction", "density"),
            *("contact", "simulation", "variants"),
            use=[wildcards.record],
        ),
        sources=sources("sweep"),
    shell:
        "overturning sweep --study {params.study:q} --variant {wildcards.variant} --motion {input.motion}"
        " --output {output.part} --timing {output.timing} --threads {threads} --records {resources.records} --log {log}"
