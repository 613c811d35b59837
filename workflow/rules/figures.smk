# Cube and intensities to figures, one job.

CAUSES = ["plane"] if STUDY.body is None else ["follow", "earthquakes"]


rule figures:
    input:
        cube=f"{RESULTS}/cube.nc",
        intensity=f"{RESULTS}/intensity.nc",
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
    output:
        polar=report(
            drawn("polar/{record}", record=RECORDS),
            caption="../report/polar.rst",
            category="Overturning by azimuth",
        ),
        intensity=report(
            drawn("intensity/{record}", record=RECORDS),
            caption="../report/intensity.rst",
            category="Intensity by azimuth",
        ),
        rose=report(
            drawn("rose"),
            caption="../report/rose.rst",
            category="Study",
            labels={"figure": "rose of fall azimuths"},
        ),
        axes=report(
            drawn("axes"),
            caption="../report/axes.rst",
            category="Study",
            labels={"figure": "fall axes by earthquake"},
        ),
        causes=report(
            sum((drawn(name) for name in CAUSES), []),
            caption=f"../report/{CAUSES[0]}.rst",
            category="Study",
            labels={"figure": "what falls go with"},
        ),
        history=report(
            expand(f"{FIGURES}/history/{{record}}.svg", record=RECORDS),
            caption="../report/history.rst",
            category="Time histories",
        ),
        illustrative=directory(f"{FIGURES}/illustrative"),
        maps=directory(f"{FIGURES}/maps"),  # empty where no record has coordinates
        drawn=f"{FIGURES}/{DRAWN}",
    log:
        f"{LOGS}/figures.log",
    benchmark:
        f"{BENCHMARKS}/figures.tsv"
    threads: 2
    resources:
        mem_mb=lambda wildcards, attempt: attempt * READING_MB,
    params:
        folder=lambda wildcards, output: Path(output.illustrative).parent,
        study=settings("figures"),
        motions=lambda wildcards, input: Path(input.motions[0]).parent,
        sources=sources("workflow:figures"),
    shell:
        "overturning figures --study {params.study:q} --cube {input.cube} --intensity {input.intensity} --motions {params.motions}"
        " --output {params.folder} --threads {threads} 2> {log}"
