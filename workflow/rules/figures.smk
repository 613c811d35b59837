# Figures: of some records as soon as their parts exist, during the sweep; of all records together and of the
# illustrative cases, from the cube and the intensity measures.

CAUSES = ["plane"] if STUDY.orientation is None else ["follow", "earthquakes"]
SOURCES = step_source_hash(*DRAWING)

for name, batch in BATCHES.items():

    rule:
        name:
            name
        input:
            parts=gather.sweep(
                f"{RESULTS}/sweep/nominal/{{record}}.{{scatteritem}}.nc", record=batch
            ),
            motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=batch),
            intensity=f"{RESULTS}/intensity.nc",
        output:
            polar=report(
                figure_files("polar/{record}", record=batch),
                caption="../report/polar.rst",
                category="Overturning by azimuth",
            ),
            blocks=(
                figure_files("blocks/{record}", record=batch)
                if STUDY.has_several_heights_frictions_or_aspects
                else []
            ),
            intensity=report(
                figure_files("intensity/{record}", record=batch),
                caption="../report/intensity.rst",
                category="Intensity by azimuth",
            ),
        log:
            f"{LOGS}/{name}.log",
        benchmark:
            f"{BENCHMARKS}/record_figures/{name}.tsv"
        priority: 2
        resources:
            mem_mb=lambda wildcards, attempt: attempt * READING_MB,
        params:
            study=step_settings(*CUBE_KEYS, "figures", "language", use=batch),
            parts=lambda wildcards, input: Path(input.parts[0]).parent,
            motions=lambda wildcards, input: Path(input.motions[0]).parent,
            chunks=CHUNKS,
            folder=lambda wildcards, output: Path(output.polar[0]).parents[1],
            sources=SOURCES,
        shell:
            "overturning record-figures --study {params.study:q} --parts {params.parts} --chunks {params.chunks}"
            " --motions {params.motions} --intensity {input.intensity} --output {params.folder} 2> {log}"


rule figures:
    input:
        cube=f"{RESULTS}/cube.nc",
        intensity=f"{RESULTS}/intensity.nc",
    output:
        rose=report(
            figure_files("rose"),
            caption="../report/rose.rst",
            category="Study",
            labels={"figure": "rose of fall axes"},
        ),
        axes=report(
            figure_files("axes"),
            caption="../report/axes.rst",
            category="Study",
            labels={"figure": "alignment by earthquake"},
        ),
        causes=report(
            sum((figure_files(name) for name in CAUSES), []),
            caption=f"../report/{CAUSES[0]}.rst",
            category="Study",
            labels={"figure": "what falls go with"},
        ),
        maps=directory(f"{FIGURES}/maps"),  # empty if no record has coordinates
        names=f"{FIGURES}/maps.txt",
    log:
        f"{LOGS}/figures.log",
    benchmark:
        f"{BENCHMARKS}/figures.tsv"
    priority: 2
    resources:
        mem_mb=lambda wildcards, attempt: attempt * READING_MB,
    params:
        folder=lambda wildcards, output: Path(output.rose[0]).parent,
        # `figures` selects one height and one friction.
        study=step_settings("figures", "height", "friction", "language"),
        sources=step_source_hash(*DRAWING),
    shell:
        "overturning figures --study {params.study:q} --cube {input.cube} --intensity {input.intensity}"
        " --output {params.folder} 2> {log}"


# The first film of a contrast shows both settings; films of a survey show its record.
AGAINST = STUDY.primary.against
FILMED = (
    sorted({each.record for each in STUDY.surveys}) if STUDY.asks == "survey" else []
)


rule illustrative:
    input:
        cube=f"{RESULTS}/cube.nc",
        against=f"{RESULTS}/cube.{AGAINST}.nc" if AGAINST else [],
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
        soil=(
            expand(f"{RESULTS}/motion/{AGAINST}/{{record}}.nc", record=RECORDS)
            if AGAINST in ON_SOIL
            else []
        ),
    output:
        folder=directory(f"{FIGURES}/illustrative"),
        names=f"{FIGURES}/illustrative.txt",
    log:
        f"{LOGS}/illustrative.log",
    benchmark:
        f"{BENCHMARKS}/illustrative.tsv"
    priority: 2
    resources:
        mem_mb=lambda wildcards, attempt: attempt * READING_MB,
    params:
        motions=lambda wildcards, input: Path(input.motions[0]).parent,
        against=f"--against {RESULTS}/cube.{AGAINST}.nc" if AGAINST else "",
        records=" ".join(f"--record {record}" for record in FILMED),
        sources=step_source_hash(*DRAWING),
    shell:
        "overturning illustrative --cube {input.cube} {params.against} {params.records} --motions {params.motions}"
        " --output {output.folder} 2> {log}"
