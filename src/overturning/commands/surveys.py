"""`overturning survey`, `backwards` and `stood`: inference from stones that fell or still stand."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

if TYPE_CHECKING:
    from overturning.records.record import Record
    from overturning.surveys.standing import Hazard, SurvivalEstimate

NEGLIGIBLE: Final = 0.01
"""Share of the falls from shaking below the hazard's first level up to which no note is printed."""


def survey(
    stones: Annotated[Path, typer.Argument(help="the survey (CSV): azimuth_deg or octant, count, …")],
    cube: Annotated[Path, typer.Option(help="cube of a study that holds the site's record (NetCDF)")],
    record: Annotated[
        str | None, typer.Option(help="id of the site's record; optional if the cube has only one")
    ] = None,
    background: Annotated[float, typer.Option(help="share of stones assumed to fall in a random direction")] = 0.05,
    figure: Annotated[Path | None, typer.Option(help="figure to draw: .svg, .png or .pdf")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="file for the comparison (JSON), used by the report")
    ] = None,
) -> None:
    """Compare the observed fall directions of a survey with those that the cube predicts."""
    from overturning.files import check_output
    from overturning.labels import azimuth_gap_label, variant_label
    from overturning.report.plain import plain_lines
    from overturning.report.sections.surveys import survey_section
    from overturning.study.cube import open_cube, record_number
    from overturning.surveys.comparison import compare_survey, survey_result, write_survey
    from overturning.surveys.stones import read_survey_with_notes

    check_output(figure, "--figure", ".svg", ".png", ".pdf")
    check_output(output, "--output")
    rows, notes, doubts = read_survey_with_notes(stones)
    with open_cube(cube, chunks={"record": 1}) as data:
        site = data.isel(record=[record_number(data, record)]).load()
        name = str(site["record_id"].item())
        comparison, gaps = compare_survey(rows, site, background=background), azimuth_gap_label(site)
        against = ", ".join([name, *variant_label(site)])
    result = survey_result(stones, name, comparison, doubts)
    print(f"{result.stones} against {against}")
    for note in notes:
        print(note)
    print(*plain_lines(survey_section(result, gaps=gaps)), sep="\n")
    if output is not None:
        write_survey(result, output)
    if figure is not None:
        from overturning.figures.style import style
        from overturning.figures.write import save
        from overturning.surveys.rose import survey_figure

        with style():
            save(survey_figure(comparison, f"{stones.name}, {against}"), figure)
        print(f"figure: {figure}")


def backwards(
    stones: Annotated[
        Path, typer.Argument(help="the survey (CSV): azimuth_deg or octant, b_over_h, height_m, round, …")
    ],
    motion: Annotated[
        list[Path] | None,
        typer.Option(help="motion of a study (NetCDF), in addition to the built-in ones; may be given several times"),
    ] = None,
    alone: Annotated[bool, typer.Option("--alone", help="use only the motions given by --motion")] = False,
    fixed: Annotated[float, typer.Option(min=0, max=0.99, help="share of stones fixed to their base")] = 0.0,
    background: Annotated[float, typer.Option(min=0, max=0.99, help="share of stones with a random outcome")] = 0.05,
    figure: Annotated[Path | None, typer.Option(help="figure to draw: .svg or .png")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="file for the posterior (NetCDF), used by the report")
    ] = None,
    threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 2,
) -> None:
    """Infer strength and axis of the motion that overturned stones, and the probability of each candidate motion.

    The responses of stones of these sizes to each motion are computed once, in minutes (up to an hour for many sizes),
    and stored in the user's cache folder.
    """
    import sys
    import time

    from overturning.files import check_output
    from overturning.report.plain import plain_lines
    from overturning.report.sections.surveys import backwards_section, draw_posterior, sizes_taken
    from overturning.report.text import counted
    from overturning.study.preflight import format_time
    from overturning.surveys.inversion import Inversion
    from overturning.surveys.library import candidates
    from overturning.surveys.posterior import write_inversion
    from overturning.surveys.responses import Responses, missing_cases, stone_kinds
    from overturning.surveys.stones import read_survey_with_notes

    check_output(figure, "--figure", ".svg", ".png")
    check_output(output, "--output")
    rows, notes, doubts = read_survey_with_notes(stones)
    for note in (*notes, *doubts):
        print(note)
    kinds = stone_kinds(rows, str(stones))
    library = candidates(motions_with_unique_ids(motion or ()), alone=alone)
    cases, seconds = missing_cases(library, kinds)
    if cases:
        under, expected = counted(len(library), "motion"), format_time(seconds / threads)
        print(
            f"{cases:,} cases under {under} to compute, about {expected} on {threads} threads",
            file=sys.stderr,
            flush=True,
        )
    began = said = time.monotonic()

    def progress(done: int, total: int) -> None:
        nonlocal said
        now = time.monotonic()
        if 0 < done < total and now - said > 2:
            said, left = now, (now - began) * (total - done) / done
            computed = f"{done} of {total} motions computed, {100 * done // total}%"  # a run reads the percentage
            print(f"{computed}, about {left:.0f} s remaining", file=sys.stderr, flush=True)

    responses = Responses(library, kinds, threads=threads, progress=progress)
    result = Inversion(responses, background, fixed).answer(stones.name, rows)
    print(*plain_lines(backwards_section(result)), sep="\n")
    if taken := sizes_taken(rows):
        print(taken)
    if output is not None:
        write_inversion(result, output)
    if figure is not None:
        draw_posterior(result, figure)
        print(f"figure: {figure}")


def motions_with_unique_ids(paths: Sequence[Path]) -> "list[Record]":
    """Return motions named by their record ids; motions with the same id (on rock and on soil) are named by file."""
    from overturning.records.store import read_motion

    records = [read_motion(path) for path in paths]
    ids = [one.record_id for one in records]
    files = zip(records, paths, strict=True)
    return [replace(one, record_id=str(path)) if ids.count(one.record_id) > 1 else one for one, path in files]


def _hazard_doubts(path: Path, hazards: "dict[str, Hazard]", outcomes: "Sequence[SurvivalEstimate]") -> list[str]:
    """Return doubts about the units of hazard curves; raise a ResultError if falls come from beyond the records."""
    import math

    from overturning.errors import ResultError
    from overturning.report.text import percent
    from overturning.surveys.standing import LARGEST_SHARE_BEYOND, implausible_levels

    doubts = {one.measure: f"{path}: {why}" for one in hazards.values() if (why := implausible_levels(one))}
    for one in outcomes:
        if one.measure in doubts and not one.beyond <= LARGEST_SHARE_BEYOND:
            falls = "no falls" if math.isnan(one.beyond) else f"{percent(one.beyond)} of the falls of {one.stones}"
            raise ResultError(f"{doubts[one.measure]}; {falls} come from levels beyond the records")
    return list(doubts.values())


def stood(
    fragility: Annotated[Path, typer.Argument(help="fragility curves of a run (CSV)")],
    hazard: Annotated[Path, typer.Argument(help="hazard curves (CSV): measure, unit, level, annual_rate")],
    years: Annotated[float, typer.Option(min=1e-3, max=1e7, help="exposure time of the stones (their age), years")],
    stones: Annotated[
        Path | None, typer.Option(help="survey (CSV); if none of its stones fell, it bounds the rate of falls")
    ] = None,
) -> None:
    """Compute the probability that stones survive years of a hazard, and the bound that standing stones put on it.

    Earthquakes are a Poisson process: λ = ∫ P(fall | x) |dν(x)|, P(stands) = exp(−λT).
    """
    import math

    from overturning.errors import ResultError
    from overturning.report.blocks import Section, table
    from overturning.report.plain import plain_lines
    from overturning.report.text import counted, percent, share
    from overturning.study.ensemble import wilson
    from overturning.surveys.standing import (
        BOUND_PROBABILITY,
        hazard_bound,
        rate_bound,
        read_curves,
        read_hazard,
        standing,
        weaker_falls,
    )
    from overturning.surveys.stones import read_survey_with_notes

    curves, hazards = read_curves(fragility), read_hazard(hazard)
    rows, notes, _ = (None, [], []) if stones is None else read_survey_with_notes(stones)
    for note in notes:
        print(note)
    upright, fell = (sum(one.count for one in rows or () if one.fell is kind) for kind in (False, True))
    bound = rate_bound(years) if upright and not fell else math.nan
    units = {one.measure: one.unit for one in curves}
    for measure in hazards.keys() & units.keys():
        own = hazards[measure].unit
        if own != units[measure]:
            raise ResultError(f"{hazard}: {measure} in {own}, but {fragility} has it in {units[measure]}; convert it")
    shared = [one for one in curves if one.measure in hazards]
    if not shared:
        raise ResultError(f"{hazard}: {', '.join(hazards)}; {fragility} has {', '.join(units)}: give one of these")
    known = [(one, hazards[one.measure]) for one in shared if math.isfinite(one.log_spread)]
    outcomes = [standing(*one, years) for one in known]
    for why in _hazard_doubts(hazard, hazards, outcomes):
        print(why)
    for row in shared:
        if not math.isfinite(row.log_spread):
            why = "no curve fits the falls" if math.isnan(row.median) else "the median lies beyond the records"
            print(f"{row.stones}, {row.measure}: {why}; no result")
    lines = [
        (
            *(one.stones, one.measure, f"{one.rate:.3g}", share(one.stands, one.low, one.high)),
            *(one.share, one.beyond, "–" if math.isnan(most := hazard_bound(*of, years, bound)) else f"{most:.3g}"),
        )
        for of, one in zip(known, outcomes, strict=True)
    ]
    heads = ("stones", "measure", "falls a year", f"P(stands {years:g} years)", "share of the class that stands")
    more = ("of the falls, beyond the records", "largest factor on the hazard")
    if lines:
        print(*plain_lines(Section("What has stood", (table((*heads, *more), lines, "tttt%%t"),))), sep="\n")
    for (row, curve), found in zip(known, outcomes, strict=True):
        if (uncounted := weaker_falls(row, curve)) > NEGLIGIBLE * found.rate:
            print(
                f"{found.stones}, {found.measure}: {percent(found.first, 1)} fall at the hazard's first level, "
                f"{curve.level[0]:g} {curve.unit}; weaker shaking is not counted, and would add {uncounted:.2g} falls "
                "a year down to a tenth of that level if the curve goes on as it begins: begin the hazard curve lower"
            )
    if not math.isnan(bound):
        print(
            f"{counted(upright, 'stone')} stood {years:g} years: their rate of falls lies below {bound:.3g} a year "
            f"with {percent(BOUND_PROBABILITY)} probability; they share their earthquakes and count as one. The "
            "hazard is bounded in the line of their class alone, which is not sought by the sizes in the survey"
        )
    elif rows is not None:
        low, high = wilson(upright, upright + fell)
        standing_share = share(upright / (upright + fell), float(low), float(high))
        print(f"{upright} of {upright + fell} stones stand, {standing_share}; where some fell no bound is given")
