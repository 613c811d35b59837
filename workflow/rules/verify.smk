# Part of the study again, with finer steps and stiffer springs: how far its answers hang on the computation.


rule verification:
    input:
        motions=expand(f"{RESULTS}/motion/{{record}}.nc", record=RECORDS),
        cube=f"{RESULTS}/cube.nc",
        timing=expand(f"{RESULTS}/sweep/nominal/{{record}}.csv", record=RECORDS),
    output:
        outcome=VERIFICATION,
        timing=VERIFICATION_TIMING,
    log:
        f"{LOGS}/verification.log",
    threads: 2
    resources:
        mem_mb=800,
    params:
        study=settings(
            *("scene", "azimuth", "height", "b_over_h", "friction", "density"),
            *("contact", "simulation", "verification"),
        ),
        motions=lambda wildcards, input: Path(input.motions[0]).parent,
        sweep=lambda wildcards, input: Path(input.timing[0]).parent,
        sources=sources("verify_study"),
    shell:
        "overturning verify-study --study {params.study:q} --motions {params.motions} --cube {input.cube}"
        " --sweep {params.sweep} --output {output.outcome} --timing {output.timing} --threads {threads} --log {log}"


# The kernel itself, whatever the study: `make verify`.

CHECKS = "results/verification"


rule work_precision:
    output:
        table=f"{CHECKS}/{{part}}.nc",
        csv=f"{CHECKS}/{{part}}.csv",
    log:
        f"{CHECKS}/logs/{{part}}.log",
    wildcard_constraints:
        part="stiffness|rigid|energy",
    resources:
        mem_mb=800,
    params:
        sources=sources("verify"),
    shell:
        "overturning verify work-precision --part {wildcards.part} --output {output.table} --log {log}"


use rule work_precision as work_precision_over_steps with:
    wildcard_constraints:
        part="rocking|sliding",
    # The two longest, side by side first; then the maps, which take both cores; the short ones fill up the end.
    priority: 2


rule peers:
    output:
        table=f"{CHECKS}/peers.nc",
        csv=f"{CHECKS}/peers.csv",
    log:
        f"{CHECKS}/logs/peers.log",
    resources:
        mem_mb=800,
    params:
        sources=sources("verify"),
    shell:
        "python -m benchmarks.verification_peers --output {output.table} > {log} 2>&1"


rule stability:
    output:
        table=f"{CHECKS}/stability.nc",
        csv=f"{CHECKS}/stability.csv",
    log:
        f"{CHECKS}/logs/stability.log",
    priority: 1
    threads: 2
    resources:
        mem_mb=1500,
    params:
        sources=sources("verify"),
    shell:
        "overturning verify stability --output {output.table} --threads {threads} --log {log}"


rule stability_of_scenes:
    output:
        table=f"{CHECKS}/scenes.nc",
        csv=f"{CHECKS}/scenes.csv",
    log:
        f"{CHECKS}/logs/scenes.log",
    priority: 1
    threads: 2
    resources:
        mem_mb=1000,
    params:
        sources=sources("verify"),
    shell:
        "overturning verify scenes --output {output.table} --threads {threads} --log {log}"


rule verify:
    input:
        expand(
            f"{CHECKS}/{{part}}.nc",
            part=[
                *["rocking", "sliding", "stiffness", "rigid", "energy"],
                *["peers", "stability", "scenes"],
            ],
        ),
        page="docs/validation.md",
    output:
        f"{CHECKS}/orders.json",
    log:
        f"{CHECKS}/logs/page.log",
    resources:
        mem_mb=1000,
    params:
        results=lambda wildcards, output: Path(output[0]).parent,
        docs=lambda wildcards, input: Path(input.page).parent,
        sources=sources("verify"),
    shell:
        "overturning verify page --results {params.results} --docs {params.docs} --output {output} 2> {log}"
