"""How falls lie to the fault normal, and where they go: the alignment of each group of records, roses, by shape."""

import math
from itertools import product

import numpy as np

from overturning.report.blocks import Disclosure, Figure, Note, Said, Table, section, table
from overturning.report.results import Results
from overturning.report.text import counted, degrees, interval, number, of_group, shown, verdict
from overturning.statistics.bootstrap import Mean, mean_over_earthquakes
from overturning.statistics.by_record import record_groups
from overturning.statistics.circular import LEAST_RESULTANT
from overturning.statistics.earthquakes import AxisSummary, axes_by_earthquake
from overturning.statistics.falls import fall_counting_rule


def alignment_sentences(results: Results, *, primary: bool) -> tuple[str, ...]:
    """Alignment of each group of records with the fault normal, and the difference of two groups.

    The first group is the primary one, where the alignment is the primary statistic.
    """
    scale = "the alignment of fall axes with the fault normal (1 normal to the fault, −1 along it)"
    values = [f"{_alignment(one)}{of_group(name)}" for name, one in results.axis_summaries.items()]
    difference, said = results.alignment_difference, []
    if difference is not None and difference.n:
        ends = interval(difference.low, difference.high, "too few earthquakes for an interval")
        some, none = (f": {which} difference between the two is shown" for which in ("a", "no"))
        values.append(f"the difference {number(difference.value)} ({ends}){verdict(difference, some, some, none, '')}")
    if primary:
        says = _verdict(next(iter(results.axis_summaries.values())).alignment)
        said.append(f"Primary statistic, fixed beforehand: {scale} is {values.pop(0)}: {says}.")
        said.append(_under_rules(results))
        scale = "the alignment"
    if values:
        said.append(f"Secondary: {scale} is {'; '.join(values)}.")
    return tuple(filter(None, said))


def axes_sentence(results: Results) -> str:
    """Mean axes of each group, and how many earthquakes lie closer to the normal than to the fault."""
    known = {of_group(name): one for name, one in results.axis_summaries.items()}
    means = " and ".join(f"{_mean_axis(one)}{name}" for name, one in known.items())
    text = f"The fall axes of {results.words.blocks} lie on average {means}."
    if closer := " and ".join(
        f"{one.closer_to_normal} of {one.with_axis}{name}" for name, one in known.items() if one.with_axis
    ):
        lie = "lies" if sum(one.with_axis for one in known.values()) == 1 else "lie"
        text += f" Of the earthquakes whose falls have an axis {closer} {lie} closer to the normal than to the fault."
    return text


def _alignment(summary: AxisSummary) -> str:
    one = summary.alignment
    sure = "" if math.isnan(one.low) else f"95 % interval {interval(one.low, one.high)}; "
    count = counted(one.n, "earthquake")
    if one.n < summary.earthquakes:
        count = f"{one.n} of {counted(summary.earthquakes, 'earthquake')}, with falls and a known fault"
    return f"{number(one.value)} of at most {number(summary.largest)} ({sure}{count})" if one.n else "not known"


def _under_rules(results: Results) -> str:
    """Range of the alignment of the first group over the rules that choose blocks, and how many intervals exclude 0."""
    group, found = next(iter(results.alignment_by_rule.items()))
    known = [one.alignment for one in found if one.alignment.n]
    if not known:
        return ""
    low, high = (number(end(one.value for one in known)) for end in (min, max))
    excluding, tested = (
        [one for one in known if verdict(one, *ways)] for ways in (("a", "b", "", ""), ("a", "a", "a", ""))
    )
    sure = f"; its interval excludes 0 under {len(excluding) or 'none'} of {len(tested)}" if tested else ""
    ends = f"goes from {low} to {high}" if low != high else f"stays at {low}"
    return f"Over the rules that choose which blocks count, the alignment {ends}{of_group(group)}{sure}."


def agreement_within(results: Results) -> str:
    """How far the fall axes of one record agree, over earthquakes, by group of records."""
    lengths = results.record_means["axis_resultant"].to_numpy()
    parts = [
        shown(mean_over_earthquakes(np.where(members, lengths, np.nan), results.events)) + of_group(name)
        for name, members in record_groups(results.cube).items()
    ]
    return (
        f"Within a record the fall axes of {results.words.blocks} agree with a mean resultant of "
        f"{' and '.join(parts)}; 1 means that all are alike, 0 that they have no axis in common. "
        f"{results.words.which}".rstrip()
    )


def _verdict(alignment: Mean) -> str:
    """What the interval of the alignment says."""
    if alignment.n == 0:
        return "no earthquake has falls and a known fault"
    normal, fault = (
        "falls lie closer to the fault normal than to the fault",
        "falls lie closer to the fault than to its normal",
    )
    few = f"{counted(alignment.n, 'earthquake')} {'is' if alignment.n == 1 else 'are'} too few for an interval"
    return verdict(alignment, normal, fault, "neither the normal nor the fault is shown to be preferred", few)


def _mean_axis(summary: AxisSummary) -> str:
    if math.isnan(summary.axis_deg):
        p_value = "" if math.isnan(summary.axis_p_value) else f" (p = {number(summary.axis_p_value)})"
        return f"along no common axis{p_value}"
    spread = "" if math.isnan(summary.half_width_deg) else f"\u00a0{half_width(summary)}"
    return f"{degrees(abs(summary.axis_deg))}{spread} from the fault normal"


def half_width(summary: AxisSummary) -> str:
    """Half of the interval of a mean axis, ± 12°."""
    width = summary.half_width_deg
    return "–" if math.isnan(width) else f"±\u00a0{degrees(width)}"


def axes_shown(results: Results) -> Figure | None:
    """The alignment of each earthquake and its mean, drawn; none where no earthquake has falls and a known fault."""
    if not any(one.alignment.n for one in results.axis_summaries.values()):
        return None
    caption = (
        f"Alignment of the falls of each earthquake with its fault normal, over {results.words.blocks}, and the mean "
        "over earthquakes with its 95 % interval where there are enough: 1 if all fall across the fault, −1 if all "
        "fall along it, 0 if neither."
    )
    return Figure(results.figures / "axes.svg", "alignment of falls with the fault normal by earthquake", caption)


@section("Where blocks fall", "rose")
def falls(results: Results) -> Said:
    """Rose of fall azimuths, and the alignment with the fault normal by shape; none where nothing falls."""
    if not results.share_overturned > 0:
        return
    caption = f"{results.words.rose} {results.words.which}".rstrip()
    yield Figure(results.figures / "rose.svg", "rose of fall azimuths", caption)
    if not results.model.one_component:
        of_each = "The same for each earthquake, its records taken together; blue: fault normals."
        alt = "roses of fall azimuths by earthquake"
        yield Figure(results.figures / "earthquakes.svg", alt, of_each, width=1.0)
    if results.has_comparable_axis:
        yield from _of_axes(results)


def _of_axes(results: Results) -> Said:
    """How falls lie to fault normals, leaving out what the answer says already."""
    answered = results.study.primary.statistic == "alignment"
    if results.study.asks not in ("direction", "reference") and not answered:
        yield from alignment_sentences(results, primary=False)
    yield from (axes_sentence(results), agreement_within(results))
    if not (answered and results.study.asks == "direction"):
        yield axes_shown(results)
    rows = [
        (
            *(name, s.earthquakes, s.alignment.n, s.alignment.value, interval(s.alignment.low, s.alignment.high)),
            *(s.largest, abs(s.axis_deg), half_width(s), f"{s.closer_to_normal} of {s.with_axis}"),
        )
        for name, s in results.axis_summaries.items()
    ]
    heads = ("records", "earthquakes", "with falls and a known fault", "alignment", "interval", "largest possible")
    yield table((*heads, "mean axis from normal", "interval", "closer to normal"), rows, "tnn2n2°")
    weighed = f" Each case counts with {results.words.weighed}." if results.study.ensemble.members else ""
    yield Note(
        f"Falls of {results.words.blocks}. Alignment: cos 2Δ, Δ the angle between a fall and the fault normal of "
        "its record, is averaged over the falls of a record, over the records of an earthquake, and over "
        "earthquakes: 1 normal to the fault, −1 along it, 0 neither. Within a record it cannot exceed the resultant "
        f"of its own falls; the mean of these is the largest possible alignment.{weighed} An earthquake has an "
        f"axis where the resultant of its falls reaches {LEAST_RESULTANT:g}; these are counted as closer to the normal "
        "or not. A mean axis is given where a test over earthquakes (by random rotations) rejects “no "
        "common axis” at 5 %. Intervals: 95 %, bootstrap over earthquakes (expanded percentile)."
    )
    yield from _by_rule(results)
    about_shapes = Note(
        "Earthquakes are those of known faults; counted are those with falls of "
        f"{results.words.blocks}, over which the alignment is the mean. "
        "No p-value is given here: with so many shapes some would look small by chance."
    )
    yield Disclosure("Alignment with the fault normal by B/H and friction", (_by_shape(results), about_shapes))


def _by_rule(results: Results) -> Said:
    """Alignment under each rule that chooses the blocks whose falls count."""
    own = fall_counting_rule(results.cube)
    direction = "plane" if results.model.one_component else results.model.direction
    rows = [
        (
            one.rule.name.format(direction) + (" (this report)" if one.rule is own else ""),
            *(group, one.records, one.alignment.n, one.alignment.value),
            *(interval(one.alignment.low, one.alignment.high), one.largest),
        )
        for group, found in results.alignment_by_rule.items()
        for one in found
    ]
    heads = (
        "blocks that overturn",
        "records",
        "with falls",
        "earthquakes",
        "alignment",
        "interval",
        "largest possible",
    )
    yield table(heads, rows, "ttnn2n2")
    yield Note(
        "The alignment under other rules that choose which blocks count; the rule of this report was fixed before any "
        f"result was seen. {results.words.why_these}"
    )


def _by_shape(results: Results) -> Table:
    """Mean alignment over earthquakes for each B/H and friction, heights taken together, and over how many it is."""
    cube = results.cube
    heads, columns = ["B/H", "µ"], []
    for name, chosen in record_groups(cube).items():
        axes = axes_by_earthquake(cube.isel(record=np.flatnonzero(chosen)), "b_over_h", "friction")
        found = axes["falls"].sum("event"), axes["cosine"].count("event"), axes["cosine"].mean("event")
        columns += [one.to_numpy().ravel() for one in found]
        heads += [f"earthquakes with falls, {name}", f"of these counted, {name}", f"alignment, {name}"]
    shapes = product(cube["b_over_h"].to_numpy(), cube["friction"].to_numpy())
    rows = [(*shape, *each) for shape, *each in zip(shapes, *columns, strict=True)]
    return table(heads, rows, "gg" + "nn2" * (len(columns) // 3), sortable=True)
