# Motion to the outcome of every case, one job per record and contact setting. How far the whole sweep is stands on the
# terminal; the log has a line now and then.


rule sweep:
    input:
        study=ancient(STUDY_FILE),
        motion=f"{RESULTS}/motion/{{record}}.nc",
    output:
        part=f"{RESULTS}/sweep/{{variant}}/{{record}}.nc",
        timing=f"{RESULTS}/sweep/{{variant}}/{{record}}.csv",
    log:
        f"{LOGS}/sweep/{{variant}}/{{record}}.log",
    threads: 1
    resources:
        mem_mb=800,
    params:
        settings=settings(
            "azimuth", "height", "b_over_h", "friction", "density", "simulation"
        ),
        contact=contact_settings,
        sources=sources("sweep"),
    shell:
        "overturning sweep --study {input.study} --variant {wildcards.variant} --motion {input.motion}"
        " --output {output.part} --timing {output.timing} --threads {threads} --log {log}"
