# Cube and intensities to figures, one job.

FIGURES = f"{RESULTS}/figures"


rule figures:
    input:
        cube=f"{RESULTS}/cube.nc",
        intensity=f"{RESULTS}/intensity.nc",
    output:
        polar=report(
            expand(f"{FIGURES}/polar/{{record}}.svg", record=RECORDS),
            caption="../report/polar.rst",
            category="Overturning by azimuth",
        ),
        intensity=report(
            expand(f"{FIGURES}/intensity/{{record}}.svg", record=RECORDS),
            caption="../report/intensity.rst",
            category="Intensity by azimuth",
        ),
        rose=report(
            f"{FIGURES}/rose.svg",
            caption="../report/rose.rst",
            category="Study",
            labels={"figure": "rose of fall azimuths"},
        ),
    log:
        f"{LOGS}/figures.log",
    resources:
        mem_mb=1000,
    params:
        folder=lambda wildcards, output: Path(output.rose).parent,
        sources=sources("figures"),
    shell:
        "overturning figures --cube {input.cube} --intensity {input.intensity} --output {params.folder} 2> {log}"
