"""What surveys say of the motion, for the report and for the terminal."""

from pathlib import Path

import numpy as np

from overturning.figures.style import short
from overturning.report.blocks import Answer, Block, Figure, Note, Section, Table
from overturning.report.results import Results
from overturning.report.text import counted, degrees, percent
from overturning.statistics.circular import resultant
from overturning.surveys.inversion import DIRECTION_ERROR_DEG
from overturning.surveys.inversion_file import Backwards

LEVEL = 0.9
"""Probability inside the stated intervals."""

SHOWN = 12
"""Motions in the table, the likeliest first."""


def backwards(results: Results) -> Section | None:
    """What each survey of the study says of the motion, among the study's records; none where it has none."""
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
        curves[name] = (values.ravel()[order], *below)
    shares = dict(zip(one.sources, one.of_sources().tolist(), strict=True))
    with style():
        turned = "azimuth of the motion" if found.along_north else "motion turned clockwise by"
        save(posterior_figure(found.name, turned, one.azimuth, one.of_azimuths(), shares, curves), path)


def backwards_section(found: Backwards, figure: Path | None = None) -> Section:
    """What a survey says of the motion, with its figure where it has one."""
    one = found.posterior
    blocks: list[Block] = [Answer(tuple(backwards_sentences(found)))]
    if figure is not None:
        caption = "Azimuth of the motion or angle by which it is turned, the likeliest motions, and how strong they were, before and after the survey."
        blocks.append(Figure(figure, "posterior of azimuth, motion, PGA and PGV", caption))
    shares, before = one.of_sources(), one.prior.sum(axis=(1, 2))
    rows = tuple(
        (one.sources[i], percent(float(shares[i])), percent(float(before[i]))) for i in np.argsort(-shares)[:SHOWN]
    )
    about = Note(
        f"Every motion, factor from {one.amplitude[0]:g} to {one.amplitude[-1]:g} and azimuth, by which the motion is turned "
        f"clockwise, was equally likely before. Directions are measured to ± {DIRECTION_ERROR_DEG:g}°; {percent(found.fixed)} of "
        "the stones are taken to be fixed. What is not known of a stone is drawn from a population. The answer holds among "
        "these motions: one that is not among them cannot be found."
    )
    blocks += [Table(("motion", "probability", "before"), rows, "t"), about]
    return Section(f"What moved the ground: {found.name}", tuple(blocks))


def backwards_sentences(found: Backwards) -> list[str]:
    """Bounds on PGA and PGV, and the axis of the motion."""
    one, parts = found.posterior, []
    for name, values in found.strengths.items():
        (low, high), (least, most) = one.interval(values, LEVEL), one.interval(values, LEVEL, prior=True)
        measure, unit = name.split(", ")
        parts.append(
            f"{measure} {short(low)} to {short(high)} {unit} (before the survey {short(least)} to {short(most)} {unit})"
        )
    seen = f"From {counted(found.fell, 'stone')} that fell and {found.stood} that stood"
    sentences = [f"{seen}, with {percent(LEVEL)} probability: {'; '.join(parts)}."]
    axis, length = resultant(one.azimuth, one.of_azimuths(), axial=True)
    if length <= 0.2:
        sentences.append("No axis of the motion can be told.")
    elif found.along_north:
        sentences.append(f"The motion's axis is {degrees(axis)} (resultant {length:.2f}; 1 would be certain).")
    else:
        turn, share = resultant(one.azimuth, one.of_azimuths())
        turn = axis if share <= 0.2 else turn
        sentences.append(
            f"The motion fits best turned by {degrees(turn)} clockwise (resultant {max(share, length):.2f}; 1 would be certain)."
        )
    return sentences
