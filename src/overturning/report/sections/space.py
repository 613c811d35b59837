"""What falls follow that may go any way, how good the plane is beside them, how far stones turn."""

import math

import numpy as np
import xarray as xr

from overturning.report.blocks import Block, Figure, Note, Paragraph, Section, table
from overturning.report.results import Results
from overturning.report.text import counted, degrees, estimate, number, percent
from overturning.statistics.bootstrap import Mean
from overturning.statistics.by_record import record_groups
from overturning.statistics.earthquakes import followed
from overturning.statistics.space import plane_agreement, plane_counts, turns, twist

CLASSES = 3
"""Parts of the B/H of a study that a table tells apart."""


def follows(results: Results) -> Section | None:
    """What a stone follows, by slenderness; none where it moves under one component, or nothing falls."""
    if results.model.one_component or not results.fallen > 0:
        return None
    count = results.cube.sizes["b_over_h"]
    parts = _classes(count)
    found = followed(results.cube, results.intensity, [slice(0, count), *parts])
    ratio = results.cube["b_over_h"].to_numpy()
    heads = [f"B/H {ratio[part][0]:g} to {ratio[part][-1]:g}" for part in parts]
    rows = [
        (group, name, "axis" if axial else "direction", means[0].n, *map(_shown, means))
        for group, references in found.items()
        for (name, axial), means in references.items()
    ]
    by_reference = table(("records", "reference", "as", "earthquakes", "all B/H", *heads), rows, "ttt")
    caption = (
        "How far falls follow each reference, by slenderness: mean over earthquakes with its 95 % interval by "
        "bootstrap. Above as axes (1 along it, −1 across), below as directions (1 with its head, −1 against it)."
    )
    note = Note(
        "Δ is the angle between a fall and the reference of its record; the mean of cos 2Δ, or of cos Δ, over a "
        "record's falls is averaged over the records of an earthquake, then over earthquakes. Peaks are those of the "
        "horizontal vector and have a head; the pulse is the strongest wavelet coefficient of the velocity over all "
        "directions, an axis like the fault normal."
    )
    alt = "alignment of falls with peaks, pulse and fault normal"
    figure = Figure(results.figures / "follow.svg", alt, caption, width=0.9)
    blocks: list[Block] = [*map(Paragraph, follow_sentences(found)), figure, by_reference, note]
    return Section("What does a stone follow?", tuple(blocks), anchor="follows")


def _classes(count: int) -> list[slice]:
    """The B/H in parts of about equal number; none where there are too few to tell apart."""
    if count < 2 * CLASSES:
        return []
    return [slice(count * part // CLASSES, count * (part + 1) // CLASSES) for part in range(CLASSES)]


def _shown(mean: Mean) -> str:
    return estimate(mean.value, mean.low, mean.high)


def follow_sentences(found: dict[str, dict[tuple[str, bool], list[Mean]]]) -> list[str]:
    """What falls follow most, over all B/H, by group of records, and whether zero lies in its interval."""
    sentences = []
    for group, references in found.items():
        axes = {name: means[0] for (name, axial), means in references.items() if axial and means[0].n}
        if not axes:
            continue
        best = max(axes, key=lambda name: axes[name].value)
        who = "Fall" if group == "all records" else f"Of the records {group}, fall"
        certain = "its interval leaves out 0"
        if not axes[best].low > 0:
            certain = "but its interval takes in 0, so nothing is shown"
        others = ", ".join(f"{name} {number(mean.value)}" for name, mean in axes.items() if name != best)
        text = (
            f"{who} axes lie closest to that of the {best}: mean cos 2Δ {_shown(axes[best])} over "
            f"{counted(axes[best].n, 'earthquake')}, {certain} ({others})."
        )
        if head := references.get((best, False)):
            ends = {"with its head": head[0].low > 0, "against its head": head[0].high < 0}
            way = next((text for text, shown in ends.items() if shown), "with no preferred end shown")
            text += f" Blocks fall {way} (mean cos Δ {_shown(head[0])})."
        sentences.append(text)
    return sentences


def plane_beside(results: Results) -> Section | None:
    """How good the plane is; none where no planes were computed beside the bodies."""
    if "plane_overturned" not in results.cube:
        return None
    cube, counts = results.cube, plane_counts(results.cube)
    whole = plane_agreement(counts)
    text = (
        "A stone is said to fall in planes where it falls in the vertical plane of either pair of its faces. This "
        f"tells rightly whether it falls in space in {percent(whole.flag, 1)} of {whole.cases:,} cases; "
        f"{percent(whole.only_space, 1)} fall in space alone, {percent(whole.only_plane, 1)} in a plane alone. Of "
        f"those that fall in both, {percent(whole.face)} go over the edge that the plane names, and the axes lie "
        f"{degrees(whole.axis)} apart on average."
    )
    groups = {name: counts.isel(record=members.nonzero()[0]) for name, members in record_groups(cube).items()}
    by_record = [(name.id, *_agreement(counts.isel(record=[index]))) for index, name in enumerate(results.names)]
    by_shape = [
        (ratio, group, *_agreement(part.sel(b_over_h=[ratio])))
        for ratio in cube["b_over_h"].to_numpy()
        for group, part in groups.items()
    ]
    heads = ("flag right", "falls in space alone", "in a plane alone", "edge right", "axes apart")
    note = Note(
        "Nominal outcomes. Where a stone would fall in both planes, the one in which it passes the point of no return "
        "first decides. Edge right: the fall lies within 45° of the predicted one. Two axes that have nothing to do "
        "with each other lie 45° apart on average."
    )
    shapes = table(("B/H", "records", *heads), by_shape, "gt%%%%°")
    blocks = (
        Paragraph(text),
        table(("record", *heads), by_record, "l%%%%°", sortable=True),
        Section("Where the plane fails, by B/H", (shapes,)),
        note,
    )
    return Section("How good is the plane?", blocks, anchor="planes")


def _agreement(counts: xr.Dataset) -> tuple[float, ...]:
    found = plane_agreement(counts)
    return found.flag, found.only_space, found.only_plane, found.face, found.axis


def _above(angle: float) -> str:
    """An angle rounded up to a tenth of a degree."""
    return number(math.ceil(10.0 * angle) / 10.0, 1)


def twists(results: Results) -> Section | None:
    """How far stones turn that do not fall; none where they cannot."""
    if not results.model.twists:
        return None
    turned = turns(results.cube)
    whole = twist(np.concatenate(list(turned.values())))
    if whole.stones == 0:
        return Section("How far stones turn", (Paragraph("No stone moved and stood."),), anchor="twist")
    text = (
        f"Of the {whole.stones:,} cases that move and do not fall, half turn about the vertical by less than "
        f"{_above(whole.median)}°, a tenth by more than {number(whole.most, 1)}°, and one by "
        f"{number(whole.largest, 0)}°. Field surveys report such stones as rotated."
    )
    rows = [
        (*shape, found.stones, found.median, found.most, found.largest)
        for shape, angles in turned.items()
        if (found := twist(angles)).stones
    ]
    heads = ("B/H", "µ", "stones", "median, °", "nine of ten below, °", "largest, °")
    by_shape = table(heads, rows, "ggd111", sortable=True)
    return Section("How far stones turn", (Paragraph(text), by_shape), anchor="twist")
