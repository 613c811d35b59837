"""`make scale`: how large a study may be; measures, and puts the tables into docs/scale.md."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

from verification.scale import large, on_paper, same_bytes
from verification.scale.made import SPACE
from verification.tables import (
    RESULTS,
    Figure,
    figures_table,
    lines_of,
    markdown,
    parts_of,
    publish,
    read_figures,
    write_csv,
    write_figures,
)

PARTS = ("bytes", "slurm", "chunk", "gather", "lazy", "lazy-space", "planning")
FIGURES = RESULTS / "scale.csv"
RUNS = RESULTS / "scale-bytes.csv"


def main(
    parts: Annotated[list[str] | None, typer.Argument(help=f"{', '.join(PARTS)}; all where none is named")] = None,
    records: Annotated[int, typer.Option(help="records of a million cases in each cube that is read lazily")] = 100,
) -> None:
    """Measure, keep the figures, and publish what is known of all parts."""
    chosen = parts_of(parts, PARTS)
    if {"bytes", "slurm"} & set(chosen):
        runs = same_bytes.here() if "bytes" in chosen else []
        if "slurm" in chosen:
            runs += same_bytes.on_slurm(files=(same_bytes.CUBE, same_bytes.REPORT))
        publish({"scale-bytes": bytes_table(kept(runs))})
    measures: dict[str, Callable[[Path], list[Figure]]] = {
        "chunk": large.measure_chunk,
        "gather": large.measure_gather,
        "lazy": lambda folder: large.measure_lazily(folder, records),
        "lazy-space": lambda folder: large.measure_lazily(folder, records, SPACE, "made cube in space"),
        "planning": lambda _: on_paper.measure_planning(),
    }
    for name, measure in measures.items():
        if name in chosen:
            with tempfile.TemporaryDirectory(prefix="scale-") as folder:
                write_figures(measure(Path(folder)), FIGURES, keep=True)
    figures = read_figures(FIGURES)
    publish({"scale": figures_table(figures)})
    if {one.quantity for one in figures} >= on_paper.NEEDED:
        publish({"scale-on-paper": paper_table(figures)})


def kept(runs: list[same_bytes.Run]) -> list[same_bytes.Run]:
    """These runs, and those kept in the repository of ways that were not tried again; keeps them all."""
    known = {(run.way, run.file): run for run in runs}
    if RUNS.is_file():
        old = [same_bytes.Run(*row) for row in lines_of(pd.read_csv(RUNS))]
        known = {(run.way, run.file): run for run in old} | known
    write_csv(pd.DataFrame(list(known.values())), RUNS)
    return list(known.values())


def bytes_table(runs: list[same_bytes.Run]) -> str:
    """What each way gave, as a table, and on how many cores."""
    cores = len(os.sched_getaffinity(0))
    first = {run.file: run.sha256 for run in reversed(runs)}
    rows = []
    for run in sorted(runs, key=lambda run: run.file):
        same = "yes" if run.sha256 == first[run.file] else "**no**"
        rows.append((run.way, f"{run.seconds:.0f}", f"`{run.file}`", f"`{run.sha256[:16]}`", same))
    table = markdown(("way", "time, s", "file", "its SHA-256", "same bytes"), rows)
    return f"{table}\n\nMeasured with {cores} core{'s' * (cores > 1)} at hand."


def paper_table(figures: list[Figure]) -> str:
    """The study on paper, as a table."""
    return figures_table(on_paper.on_paper({one.quantity: one.value for one in figures}))


if __name__ == "__main__":
    typer.run(main)
