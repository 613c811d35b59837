"""`overturning backwards`: what motion made the stones of a survey fall."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from overturning.records.record import Record


def backwards(
    stones: Annotated[
        Path, typer.Argument(help="the survey (CSV): azimuth_deg or octant, b_over_h, height_m, round, …")
    ],
    motion: Annotated[
        list[Path] | None,
        typer.Option(help="motion of a study (NetCDF), once for each, beside the records and pulses that come along"),
    ] = None,
    alone: Annotated[bool, typer.Option("--alone", help="ask among the named motions only")] = False,
    fixed: Annotated[float, typer.Option(min=0, max=0.99, help="share of stones fixed to their base")] = 0.0,
    background: Annotated[float, typer.Option(min=0, max=0.99, help="share of stones that do anything")] = 0.05,
    figure: Annotated[Path | None, typer.Option(help="figure to draw: .svg or .png")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the posterior as a file (NetCDF), for a report")
    ] = None,
    threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 2,
) -> None:
    """Say how strong the motion was that made stones fall, along which axis, and which motions could have been it.

    What stones of these sizes do under each motion is computed once, in minutes, or in an hour for many sizes, and kept
    in the user's cache folder.
    """
    import sys
    import time

    from overturning.files import check_output
    from overturning.report.plain import plain_lines
    from overturning.report.sections.surveys import backwards_section, draw_posterior, sizes_taken
    from overturning.surveys.inversion import Inversion
    from overturning.surveys.library import candidates
    from overturning.surveys.posterior import write_backwards
    from overturning.surveys.responses import Responses, StoneKind
    from overturning.surveys.stones import read_survey

    check_output(figure, "--figure", ".svg", ".png")
    check_output(output, "--output")
    rows = read_survey(stones)
    library = candidates(named_apart(motion or ()), alone=alone)
    began = said = time.monotonic()

    def progress(done: int, total: int) -> None:
        nonlocal said
        now = time.monotonic()
        if 0 < done < total and now - said > 2:
            said, left = now, (now - began) * (total - done) / done
            computed = f"{done} of {total} motions computed, {100 * done // total}%"  # a run reads the per cents
            print(f"{computed}, about {left:.0f} s to go", file=sys.stderr, flush=True)

    responses = Responses(library, [StoneKind.of(stone) for stone in rows], threads=threads, progress=progress)
    result = Inversion(responses, background, fixed).answer(stones.name, rows)
    print(*plain_lines(backwards_section(result)), sep="\n")
    if taken := sizes_taken(rows):
        print(taken)
    if output is not None:
        write_backwards(result, output)
    if figure is not None:
        draw_posterior(result, figure)
        print(f"figure: {figure}")


def named_apart(paths: Sequence[Path]) -> "list[Record]":
    """Motions of a study by the ids of their records, those of one id, as a record's on rock and on soil, by files."""
    from overturning.records.store import read_motion

    records = [read_motion(path) for path in paths]
    ids = [one.record_id for one in records]
    files = zip(records, paths, strict=True)
    return [replace(one, record_id=str(path)) if ids.count(one.record_id) > 1 else one for one, path in files]
