"""What a survey says of the motion, for the report and for the terminal."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from overturning.arrays import FloatArray
from overturning.figures.style import short
from overturning.report.blocks import Answer, Block, Figure, Note, Section, Table
from overturning.report.text import counted, degrees, percent
from overturning.statistics.circular import resultant
from overturning.surveys.inversion import DIRECTION_ERROR_DEG, Posterior
from overturning.surveys.stones import Stone
from overturning.units import CM, STANDARD_GRAVITY

LEVEL = 0.9
"""Probability inside the stated intervals."""

Peaks = Mapping[str, tuple[float, float]]
"""Largest PGA, m/s², and PGV, m/s, of each motion as it is."""


def strengths(found: Posterior, peaks: Peaks) -> dict[str, FloatArray]:
    """PGA in g and PGV in cm/s of each motion at each factor, shape (s, a)."""
    pga, pgv = np.array([peaks[name] for name in found.sources]).T[:, :, None] * found.amplitude
    return {"PGA, g": pga / STANDARD_GRAVITY, "PGV, cm/s": pgv / CM}


def draw_posterior(found: Posterior, peaks: Peaks, title: str, path: Path) -> None:
    """Draw a posterior into a file."""
    from overturning.figures.backwards import posterior_figure
    from overturning.figures.style import save, style

    curves = {}
    for name, values in strengths(found, peaks).items():
        order = np.argsort(values.ravel(), kind="stable")
        below = [one.sum(axis=2).ravel()[order].cumsum() for one in (found.probability, found.prior)]
        curves[name] = (values.ravel()[order], *below)
    shares = dict(zip(found.sources, found.of_sources().tolist(), strict=True))
    with style():
        save(posterior_figure(title, found.azimuth, found.of_azimuths(), shares, curves), path)


def backwards_section(
    name: str, stones: Sequence[Stone], found: Posterior, peaks: Peaks, figure: Path | None = None, fixed: float = 0.0
) -> Section:
    """What a survey says of the motion, with its figure where it has one."""
    blocks: list[Block] = [Answer(tuple(_sentences(stones, found, peaks)))]
    if figure is not None:
        caption = "Azimuth of the motion, the likeliest motions, and how strong they were, before and after the survey."
        blocks.append(Figure(figure, "posterior of azimuth, motion, PGA and PGV", caption))
    shares, before = found.of_sources(), found.prior.sum(axis=(1, 2))
    rows = tuple(
        (found.sources[i], percent(float(shares[i])), percent(float(before[i]))) for i in np.argsort(-shares)[:12]
    )
    about = Note(
        f"Every motion, factor from {found.amplitude[0]:g} to {found.amplitude[-1]:g} and azimuth was equally likely before. "
        f"Directions are measured to ± {DIRECTION_ERROR_DEG:g}°; {percent(fixed)} of the stones are taken to be fixed. What is not "
        "known of a stone is drawn from the population. The answer holds among these motions: one that is not among them "
        "cannot be found."
    )
    blocks += [Table(("motion", "probability", "before"), rows, "t"), about]
    return Section(f"What moved the ground: {name}", tuple(blocks), anchor="backwards")


def _sentences(stones: Sequence[Stone], found: Posterior, peaks: Peaks) -> list[str]:
    fell = sum(stone.count for stone in stones if stone.fell)
    stood = sum(stone.count for stone in stones if not stone.fell)
    parts = []
    for name, values in strengths(found, peaks).items():
        (low, high), (least, most) = found.interval(values, LEVEL), found.interval(values, LEVEL, prior=True)
        measure, unit = name.split(", ")
        parts.append(
            f"{measure} {short(low)} to {short(high)} {unit} (before the survey {short(least)} to {short(most)} {unit})"
        )
    sentences = [
        f"From {counted(fell, 'stone')} that fell and {stood} that stood, with {percent(LEVEL)} probability: {'; '.join(parts)}."
    ]
    axis, length = resultant(found.azimuth, found.of_azimuths(), axial=True)
    if length > 0.2:
        sentences.append(f"The motion's axis is {degrees(axis)} (resultant {length:.2f}; 1 would be certain).")
    else:
        sentences.append("No axis of the motion can be told.")
    return sentences
