"""What falls follow that may go any way, how good the plane is beside them, how far stones turn."""

import math
from functools import partial

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.figures.alignment import estimate_to_draw
from overturning.figures.answer import references_figure
from overturning.report.blocks import Figure, Note, Said, Section, section, table
from overturning.report.results import Results
from overturning.report.text import capitalised, counted, degrees, number, of_group, percent, shown, verdict
from overturning.statistics.bootstrap import Mean
from overturning.statistics.by_record import record_groups
from overturning.statistics.earthquakes import ReferenceAlignment
from overturning.statistics.space import planar_agreement_shares, summarise_twist, twist_angles


@section("What does a stone follow?", "follows")
def follows(results: Results) -> Said:
    """What a stone follows, by slenderness; none where it moves under one component, or nothing falls."""
    if results.model.one_component or not results.share_overturned > 0:
        return
    found, heads = results.reference_alignment
    yield from follow_sentences(found, heads)
    yield follow_shown(results)
    rows: list[tuple[str | int, ...]] = []
    for group, references in found.items():
        for (name, axial), (whole, *each) in references.means.items():
            # Slender blocks may fall with the head and stouter ones against it: their mean would say neither.
            mean = shown(whole) if axial or not heads else "–"
            rows.append((group, name, "axis" if axial else "direction", whole.n, mean, *map(shown, each)))
        if references.closer:
            pair = " less ".join(references.closest)
            rows.append((group, pair, "axis", references.closer[0].n, *map(shown, references.closer)))
    yield table(("records", "reference", "as", "earthquakes", "all B/H", *heads), rows, "ttt")
    yield Note(
        "Δ is the angle between a fall and the reference of its record; the mean of cos 2Δ, or of cos Δ, over a "
        "record's falls is averaged over the records of an earthquake, then over earthquakes. Peaks are those of the "
        "horizontal vector and have a head; the pulse is the strongest wavelet coefficient (db4) of the velocity over "
        "all directions, an axis like the fault normal. The radial direction, where the epicentre is known, leads away "
        "from it at the station; the transverse axis lies across it."
    )


def references_shown(results: Results) -> Figure:
    """Alignment with each reference over all B/H, drawn."""
    found, _ = results.reference_alignment
    groups = {
        group: {name: estimate_to_draw(means[0]) for (name, axial), means in of_group.means.items() if axial}
        for group, of_group in found.items()
    }
    drawing = results.drawn("references", partial(references_figure, groups))
    caption = (
        "Alignment of falls with each reference: mean cos 2Δ over earthquakes, with its 95 % interval by bootstrap."
    )
    return Figure(drawing, "alignment of falls with peaks, pulse, fault normal and radial direction", caption)


def follow_shown(results: Results) -> Figure:
    """What falls follow, drawn."""
    caption = (
        "How far falls follow each reference, by slenderness: mean over earthquakes with its 95 % interval by "
        "bootstrap; hollow: of one or two earthquakes. Above as axes (1 along it, −1 across), below as directions (1 "
        "with its head, −1 against it)."
    )
    alt = "alignment of falls with peaks, pulse, fault normal and radial direction"
    return Figure(results.figures / "follow.svg", alt, caption, width=0.9)


def follow_sentences(found: dict[str, ReferenceAlignment], parts: list[str]) -> list[str]:
    """What falls follow most, by group of records, how sure that is, and to which end, by slenderness."""
    sentences = []
    for group, references in found.items():
        if not references.closest:
            continue
        best, *others = references.closest
        mean, *_ = references.means[best, True]
        who = f"of the records{of_group(group)}, fall" if of_group(group) else "fall"
        leaves_out, takes_in = "its interval leaves out 0", "but its interval takes in 0, so nothing is shown"
        rest = ", ".join(
            f"{name} {number(means[0].value)}{_of_fewer(means[0], mean)}"
            for (name, axial), means in references.means.items()
            if axial and name != best and means[0].n
        )
        text = (
            f"Secondary: {who} axes lie closest to that of the {best}: mean cos 2Δ {shown(mean)} over "
            f"{counted(mean.n, 'earthquake')}, {verdict(mean, leaves_out, leaves_out, takes_in)}"
            f"{f' ({rest})' if rest else ''}."
        )
        if others:
            closer = references.closer[0]
            lie = "They lie closer to it" if closer.low > 0 else "They are not shown to lie closer to it"
            text += f" {lie} than to that of the {others[0]}: difference of the cosines {shown(closer)}."
        if heads := references.means.get((best, False)):
            ends = zip(parts, heads[1:], strict=True) if parts else [("", heads[0])]
            said = "; ".join(
                f"{f'{part}: ' if part else ''}{shown(one)}, {counted(one.n, 'earthquake')}, "
                f"{verdict(one, 'with it', 'against it', 'no end shown')}"
                for part, one in ends
                if one.n
            )
            text += f" Mean cos Δ, 1 where blocks fall with its head and −1 against it: {said}."
        sentences.append(text)
    return sentences


def follow_answer(found: dict[str, ReferenceAlignment], parts: list[str]) -> list[str]:
    """Return the reference closest to the falls, and the end they go to, for each group of records.

    Every part of the B/H is listed, whatever its interval says: the parts whose intervals exclude 0 are a selection.
    """
    said, ends = list[str](), list[Mean]()
    for group, references in found.items():
        if not references.closest:
            continue
        best = references.closest[0]
        mean, *_ = references.means[best, True]
        who = capitalised(f"{of_group(group)} fall".strip())
        normal = references.means.get(("fault normal", True), [Mean(0, *(math.nan,) * 3)])[0]
        less = f"; with the fault normal {number(normal.value)}{_of_fewer(normal, mean)}"
        less = less if normal.n and best != "fault normal" else ""
        text = (
            f"{who} axes lie closest to that of the {best}: mean cos 2Δ {shown(mean)}, "
            f"{counted(mean.n, 'earthquake')}{less}."
        )
        known = references.means.get((best, False), [mean])[1:]
        ways = [
            f"{part} {shown(one)}, {verdict(one, 'with it', 'against it', 'no end shown', 'too few earthquakes')}"
            for part, one in zip(parts, known, strict=False)
            if one.n
        ]
        if ways:
            text += f" Mean cos Δ, 1 where stones fall with its head and −1 against it: {'; '.join(ways)}."
            ends += [one for one in known if not math.isnan(one.low)]
        said.append(text)
    if ends:
        excluding = sum(bool(verdict(one, "a", "b", "", "")) for one in ends)
        said.append(f"{excluding} of these {len(ends)} intervals exclude 0; by chance one in 20 would.")
    return said


def _of_fewer(one: Mean, best: Mean) -> str:
    """Over how many earthquakes a mean is that is not over those of the best."""
    return "" if one.n == best.n else f" over {counted(one.n, 'earthquake')}"


def plane_answer(results: Results) -> str:
    """How good the plane is, in a sentence."""
    whole = {name: float(one) for name, one in planar_agreement_shares(results.planar_agreement_counts).items()}
    return (
        f"The planes of its faces tell rightly whether a stone falls in {percent(whole['flag'], 1)} of the cases "
        f"({percent(whole['flag_beside'], 1)} of those whose neighbour in B/H does otherwise), and over which edge in "
        f"{percent(whole['face'])} of the falls."
    )


@section("How good is the plane?", "planes")
def plane_beside(results: Results) -> Said:
    """How good the plane is; none where no planes were computed beside the bodies."""
    if "plane_overturned" not in results.cube:
        return
    counts = results.planar_agreement_counts
    whole = {name: float(one) for name, one in planar_agreement_shares(counts).items()}
    yield (
        "A stone is said to fall in planes where it falls in the vertical plane of either pair of its faces. This "
        f"tells rightly whether it falls in space in {percent(whole['flag'], 1)} of {whole['cases']:,.0f} cases, and "
        f"in {percent(whole['flag_beside'], 1)} of those whose neighbour in B/H does otherwise, where it is hard to "
        f"tell; {percent(whole['only_space'], 1)} fall in space alone, {percent(whole['only_plane'], 1)} in a plane "
        f"alone. Of those that fall in both, {percent(whole['face'])} go over the edge that the plane names, and the "
        f"axes lie {degrees(whole['axis'])} apart on average."
    )
    by_record = zip((name.id for name in results.record_names), *_agreement(counts, "record"), strict=True)
    groups = record_groups(results.cube)
    of_groups = [_agreement(counts.isel(record=members.nonzero()[0]), "b_over_h") for members in groups.values()]
    by_shape = [
        (ratio, group, *(column[place] for column in columns))
        for place, ratio in enumerate(counts["b_over_h"].to_numpy())
        for group, columns in zip(groups, of_groups, strict=True)
    ]
    heads = ("flag right", "falls in space alone", "in a plane alone", "edge right", "axes apart")
    yield table(("record", *heads), by_record, "l%%%%°", sortable=True)
    shapes = table(("B/H", "records", *heads), by_shape, "gt%%%%°")
    yield Section("Where the plane fails, by B/H", (shapes,))
    yield Note(
        "Nominal outcomes. Where a stone would fall in both planes, the one in which it passes the point of no return "
        "first decides. Edge right: the fall lies within 45° of the predicted one. Two axes that have nothing to do "
        "with each other lie 45° apart on average."
    )


def _agreement(counts: xr.Dataset, along: str) -> list[FloatArray]:
    """Columns of a table by record or B/H."""
    found = planar_agreement_shares(counts, along)
    return [found[name].to_numpy() for name in ("flag", "only_space", "only_plane", "face", "axis")]


@section("How far stones turn", "twist")
def twists(results: Results) -> Said:
    """How far stones turn that do not fall; none where they cannot."""
    if not results.model.twists:
        return
    turned = twist_angles(results.cube)
    whole = summarise_twist(np.concatenate(list(turned.values())))
    if whole.stones == 0:
        yield "No stone moved and stood."
        return
    text = (
        f"Of the {whole.stones:,} cases that move and do not fall, half turn about the vertical by less than "
        f"{number(math.ceil(10.0 * whole.median) / 10.0, 1)}°, a tenth by more than {number(whole.most, 1)}°, and "
        f"one by {number(whole.largest, 0)}°. Field surveys report such stones as rotated."
    )
    if results.study.body is not None and results.study.body.plan == "circle":
        text += (
            " A cylinder that has rocked rolls on its rim for minutes, since rolling costs nothing here: its turn, and "
            "its slip, are those at the end of its case, not those of a column at rest."
        )
    yield text
    rows = [(*shape, *found) for shape, angles in turned.items() if (found := summarise_twist(angles)).stones]
    heads = ("B/H", "µ", "stones", "median, °", "nine of ten below, °", "largest, °")
    yield table(heads, rows, "ggd111", sortable=True)
