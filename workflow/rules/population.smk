# Fragility curves from the fraction overturned in a population of stones.


rule fragility:
    input:
        cube=f"{RESULTS}/cube.nc",
        intensity=f"{RESULTS}/intensity.nc",
    output:
        f"{RESULTS}/fragility/fragility.csv",
        f"{RESULTS}/fragility/curves.json",
        f"{RESULTS}/fragility/fragility-pga.xml",
        f"{RESULTS}/fragility/fragility-pgv.xml",
        [
            f"{RESULTS}/fragility/{openquake_file_name(f'SA({period})')}"
            for period in PERIODS
        ],
    log:
        f"{LOGS}/fragility.log",
    benchmark:
        f"{BENCHMARKS}/fragility.tsv"
    resources:
        mem_mb=800,
    params:
        study=step_settings("body", "orientation", "population"),
        folder=lambda wildcards, output: Path(output[0]).parent,
        sources=step_source_hash("surveys", "statistics", *NUMERICS),
    shell:
        "overturning fragility --study {params.study:q} --cube {input.cube} --intensity {input.intensity}"
        " --output {params.folder} 2> {log}"
