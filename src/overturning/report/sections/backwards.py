"""What surveys say of the motion, for the report and for the terminal."""

import math
from pathlib import Path

import numpy as np

from overturning.figures.style import short
from overturning.report.blocks import Answer, Block, Caution, Figure, Note, Section, Table
from overturning.report.results import Results
from overturning.report.text import counted, degrees, percent
from overturning.surveys.inversion import LEVEL, NO_FIT, POWER, Backwards
from overturning.units import CM

SHOWN = 12
"""Motions in the table, the likeliest first."""

BLUNT = 135.0
"""Width of the axis's arc, degrees, from which no axis is told; 162 hold nine tenths where nothing is known."""


def backwards(results: Results) -> Section | None:
    """What each survey of the study says of the motion; none where it has none."""
    sections = []
    for number, found in enumerate(results.backwards, 1):
        drawing = results.drawings / f"backwards-{number}.svg"
        draw_posterior(found, drawing)
        sections.append(backwards_section(found, drawing))
    return Section("From the stones back to the motion", tuple(sections), anchor="backwards") if sections else None


def draw_posterior(found: Backwards, path: Path) -> None:
    """Draw a posterior into a file."""
    from overturning.figures.backwards import posterior_figure
    from overturning.figures.style import save, style

    one, curves = found.posterior, {}
    for name, values in found.strengths.items():
        order = np.argsort(values.ravel(), kind="stable")
        below = [each.sum(axis=2).ravel()[order].cumsum() for each in (one.probability, one.prior)]
        curves[name] = (values.ravel()[order], *below, one.interval(values))
    shares = dict(zip(one.sources, one.of_sources().tolist(), strict=True))
    with style():
        save(posterior_figure(found.name, one.of_axes(), one.axis_arc(), shares, curves), path)


def backwards_section(found: Backwards, figure: Path | None = None) -> Section:
    """What a survey says of the motion, with its figure where it has one."""
    one = found.posterior
    blocks: list[Block] = [Answer(tuple(backwards_sentences(found)))]
    blocks += [Caution(text) for text in cautions(found)]
    if figure is not None:
        caption = (
            "Axis of the largest velocity with the arc of 90 %, the likeliest motions, and how strong they were, before and after "
            "the survey; the band is the stated interval, an arrow stands where the library ends before it."
        )
        blocks.append(Figure(figure, "posterior of axis, motion, PGV and PGA", caption))
    shares, before = one.of_sources(), one.prior.sum(axis=(1, 2))
    rows = tuple(
        (one.sources[i], percent(float(shares[i])), percent(float(before[i]))) for i in np.argsort(-shares)[:SHOWN]
    )
    about = Note(
        f"Every motion, scaled to peak velocities of {one.level[0] / CM:.0f} to {one.level[-1] / CM:.0f} cm/s and turned every way, "
        "was equally likely before. Peaks are the largest over all azimuths. No motion of the library is taken to be the true one: "
        f"stones that are written down alike differ, the motion differs over the site, and directions count to the power {POWER:g}, "
        "so that such intervals hold the truth of simulated surveys under records that are left out (docs/surveys.md). "
        f"{percent(found.fixed)} of the stones are taken to be fixed. Whether fallen bodies tell the intensity at all is doubted "
        "(Aslam et al. 1980, J. Struct. Div. ASCE 106(2), 377)."
    )
    blocks += [Table(("motion", "probability", "before"), rows, "t"), about]
    return Section(f"What moved the ground: {found.name}", tuple(blocks))


def backwards_sentences(found: Backwards) -> list[str]:
    """Bounds on PGV and PGA, and the axis of the motion."""
    one, parts = found.posterior, []
    for name, values in found.strengths.items():
        (low, high), (least, most) = one.interval(values), one.interval(values, prior=True)
        measure, unit = name.split(", ")
        parts.append(f"{measure} {_between(low, high, unit)} (before the survey {_between(least, most, unit)})")
    seen = f"From {counted(found.fell, 'stone')} that fell and {found.stood} that stood"
    middle, width = one.axis_arc()
    axis = (
        f"No axis of the motion can be told: {percent(LEVEL)} of the probability takes {degrees(width)} of the 180°."
        if width >= BLUNT
        else f"The motion's axis, that of its largest velocity, is {degrees(middle, 180)} ± {degrees(width / 2)}, with {percent(LEVEL)} "
        "probability."
    )
    return [f"{seen}, with {percent(LEVEL)} probability: {'; '.join(parts)}.", axis]


def cautions(found: Backwards) -> list[str]:
    """What is to be said where the library ends before the answer, or does not fit the survey."""
    weakest, strongest = found.posterior.edges()
    tail, said = (1 - LEVEL) / 2, []
    if strongest > tail:
        said.append(
            f"The survey asks for more than any motion here: {percent(strongest)} of the probability lies on the strongest level, "
            f"{found.posterior.level[-1] / CM:.0f} cm/s. No upper bound is given."
        )
    if weakest > tail:
        said.append(
            f"The survey asks for less than any motion here: {percent(weakest)} of the probability lies on the weakest level, "
            f"{found.posterior.level[0] / CM:.0f} cm/s. No lower bound is given."
        )
    if found.fit < NO_FIT:
        said.append(
            f"No motion here fits this survey: of surveys drawn from the answer, so few fit as badly that p is {found.fit:.2g} "
            "(posterior predictive check). The bounds above do not hold; look for stones that were pushed or moved, or "
            "for sizes or directions that were mistaken."
        )
    return said


def _between(low: float, high: float, unit: str) -> str:
    """An interval in words, of which an end may be missing."""
    if math.isinf(high):
        return f"at least {short(low)} {unit}" if low > 0 else "of any size"
    return f"{short(low)} to {short(high)} {unit}" if low > 0 else f"at most {short(high)} {unit}"
