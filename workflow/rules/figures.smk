# Cube and intensities to figures, one job.

FIGURES = f"{RESULTS}/figures"


rule figures:
    input:
        cube=f"{RESULTS}/cube.nc",
        intensity=f"{RESULTS}/intensity.nc",
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
    output:
        polar=report(
            expand(f"{FIGURES}/polar/{{record}}.png", record=RECORDS),
            caption="../report/polar.rst",
            category="Overturning by azimuth",
        ),
        intensity=report(
            expand(f"{FIGURES}/intensity/{{record}}.png", record=RECORDS),
            caption="../report/intensity.rst",
            category="Intensity by azimuth",
        ),
        rose=report(
            f"{FIGURES}/rose.svg",
            caption="../report/rose.rst",
            category="Study",
            labels={"figure": "rose of fall azimuths"},
        ),
        axes=report(
            f"{FIGURES}/axes.svg",
            caption="../report/axes.rst",
            category="Study",
            labels={"figure": "fall axes by earthquake"},
        ),
        plane=report(
            f"{FIGURES}/plane.svg",
            caption="../report/plane.rst",
            category="Study",
            labels={"figure": "PGA and PGV/PGA"},
        ),
        history=report(
            expand(f"{FIGURES}/history/{{record}}.svg", record=RECORDS),
            caption="../report/history.rst",
            category="Time histories",
        ),
        telling=directory(f"{FIGURES}/telling"),
        maps=directory(f"{FIGURES}/maps"),  # empty where no record has coordinates
    log:
        f"{LOGS}/figures.log",
    threads: 2
    resources:
        mem_mb=1000,
    params:
        folder=lambda wildcards, output: Path(output.rose).parent,
        motions=lambda wildcards, input: Path(input.motions[0]).parent,
        sources=sources("workflow:figures"),
    shell:
        "overturning figures --cube {input.cube} --intensity {input.intensity} --motions {params.motions}"
        " --output {params.folder} --threads {threads} 2> {log}"
