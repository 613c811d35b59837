# A cemetery of many stones under each record at several amplitudes: fall rates. One job for all records.


rule population:
    input:
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
    output:
        f"{RESULTS}/population.nc",
    log:
        f"{LOGS}/population.log",
    threads: 2
    resources:
        mem_mb=800,
    params:
        study=settings("scene", "density", "contact", "simulation", "population"),
        motions=lambda wildcards, input: Path(input.motions[0]).parent,
        sources=sources("workflow:population"),
    shell:
        "overturning population --study {params.study:q} --motions {params.motions} --output {output}"
        " --threads {threads} --log {log}"


rule fragility:
    input:
        population=f"{RESULTS}/population.nc",
        intensity=f"{RESULTS}/intensity.nc",
    output:
        f"{RESULTS}/fragility/fragility.csv",
        f"{RESULTS}/fragility/fragility-pga.xml",
        f"{RESULTS}/fragility/fragility-pgv.xml",
    log:
        f"{LOGS}/fragility.log",
    resources:
        mem_mb=500,
    params:
        folder=lambda wildcards, output: Path(output[0]).parent,
        sources=sources("workflow:fragility"),
    shell:
        "overturning fragility --population {input.population} --intensity {input.intensity} --output {params.folder}"
        " 2> {log}"
