"""The answer to the study's question: how falls lie to the fault normal, with their uncertainty; and where they go."""

import math
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.report.blocks import Answer, Block, Disclosure, Figure, Note, Paragraph, Section, Table, table
from overturning.report.results import Results
from overturning.report.sections.causes import finding_sentence
from overturning.report.sections.exactness import dependence
from overturning.report.sections.records import record_directions
from overturning.report.text import counted, degrees, estimate, interval, number, percent
from overturning.statistics.bootstrap import mean_over_earthquakes
from overturning.statistics.by_record import record_groups
from overturning.statistics.circular import LEAST_RESULTANT
from overturning.statistics.earthquakes import AxisSummary, axes_by_earthquake
from overturning.statistics.falls import overturns
from overturning.study.cube import earthquakes_said
from overturning.study.scenes import NOMINAL, scene_of

MOST_RECORDS_IN_WORDS = 5
"""Records whose directions still stand in sentences; of more the table tells."""

_SHARES: Final = {
    "share": "the share of the cases that overturn",
    "fall_rate": "the fall rate of the population under the records as they are",
}
"""Primary statistics that are shares of something under each record."""


def answer(results: Results) -> Section:
    """The answer, what it is counted over, and the axes it comes from."""
    said = [*scene_sentences(results), *answer_sentences(results)]
    axes: tuple[Block, ...] = ()
    if results.tells_axes:
        said.append(agreement_within(results))
        caption = (
            f"Fall axis of each earthquake relative to its fault normal, over {results.words.blocks}; the point grows "
            "with how strongly the axes agree. Below, the mean over earthquakes with its bootstrap interval. Which "
            "side of the fault normal counts as positive is arbitrary, so only axes are compared."
        )
        alt = "fall axis of each earthquake relative to its fault normal"
        axes = (Figure(results.figures / "axes.svg", alt, caption, width=0.82),)
    exact, sentences = dependence(results), Answer((*said, *_directions_in_words(results)))
    blocks = (sentences, *((exact,) if exact else ()), Paragraph(_counted(results)), *axes, Note(_cases(results)))
    return Section("Answer", blocks, anchor="answer")


def scene_sentences(results: Results) -> tuple[str, ...]:
    """In how many cases anything of a scene of several elements falls, which, and of which one the rest speaks."""
    if not results.elements:
        return ()
    *each, anything = results.elements
    if not anything.falls:
        return ("Nothing of the scene falls in any case whose outcome is known.",)
    shares = ", ".join(f"the {one.name} in {percent(one.share)}" for one in each)
    shown = scene_of(results.study).shown_name
    return (
        f"In {percent(anything.share)} of the cases something falls: {shares}. “Blocks” are the {shown} in what "
        "follows.",
    )


def answer_sentences(results: Results) -> tuple[str, ...]:
    """The primary statistic, then what else is told of axes, called secondary; or why nothing is."""
    first = () if results.study.primary.statistic == "alignment" else (primary_sentence(results),)
    if untold := _untold(results):
        return *first, untold
    return *first, *alignment_sentences(results, primary=not first)


def _untold(results: Results) -> str:
    """Why nothing is said of the axes of falls relative to a fault; empty where something is."""
    known = " whose outcome is known" if any(absent for _, absent in results.statuses.values()) else ""
    share = f"{percent(results.fallen)} of the cases overturn"
    if math.isnan(results.fallen):
        return "No outcome was found, so nothing can be said; see the causes below."
    if results.fallen <= 0:
        nothing = "so these records say nothing about the direction of falls"
        return f"No block{known} overturned in any direction, {nothing}."
    if results.one_axis:
        return f"{share}; with a single plane of motion nothing is said about direction."
    if results.fallen >= 1:
        return f"Every block{known} overturned in every plane: there is no axis along which blocks fall more easily."
    if not results.faults_known:
        return f"{share}; no fault normal is known, so nothing is said relative to a fault."
    return ""


def primary_sentence(results: Results) -> str:
    """The primary statistic of a study where it is not the alignment, with its interval and what that says."""
    primary, cubes = results.study.primary, results.cubes
    if primary.statistic == "published":
        return f"Primary statistic, fixed beforehand: {finding_sentence(results, NOMINAL)}".replace(": With", ": with")

    def of_record(variant: str) -> FloatArray:
        if primary.statistic == "fall_rate":
            return results.populations[variant]["fall_rate"].sel(amplitude=1.0).to_numpy()
        falls = overturns(results.reference_cube(variant))
        return falls.mean([name for name in falls.dims if name != "record"]).compute().to_numpy().astype(np.float64)

    own, what = of_record(NOMINAL), _SHARES[primary.statistic]
    less = of_record(primary.against) if primary.against in cubes else np.zeros(own.size)
    found = mean_over_earthquakes(own - less, results.cube["event"].to_numpy().astype(str), draws=10_000)
    if primary.against in cubes:
        what += f", less that of the variant {primary.against}"
    # A share of one decimal where its interval is no wider than some per cent.
    digits = int(found.high - found.low < 0.1)
    shown = f"{number(100 * found.value, digits)}\u00a0%"
    if math.isnan(found.low):
        sure = f"{counted(found.n, 'earthquake')}, too few for an interval"
    else:
        ends = " to ".join(number(100 * end, digits) for end in (found.low, found.high))
        sure = f"95 % interval {ends} %; {counted(found.n, 'earthquake')}"
    text = f"Primary statistic, fixed beforehand: {what}, a mean over earthquakes, is {shown} ({sure})"
    if primary.against not in cubes or math.isnan(found.low):
        return f"{text}."
    ways = {"more fall than in the variant": found.low > 0, "fewer fall than in the variant": found.high < 0}
    return f"{text}: {next((way for way, shown in ways.items() if shown), 'no difference is shown')}."


def alignment_sentences(results: Results, *, primary: bool) -> tuple[str, ...]:
    """Alignment of each group, their difference, mean axes, and how many earthquakes lie closer to what.

    The first group is the primary one, where the alignment is the primary statistic.
    """
    scale = "the alignment of fall axes with the fault normal (1 normal to the fault, −1 along it)"
    known = {_name(name): one for name, one in results.axes.items()}
    values = [f"{_alignment(one)}{name}" for name, one in known.items()]
    difference, said = results.axes_difference, []
    if difference is not None and difference.n:
        few = math.isnan(difference.low)
        ends = "too few earthquakes for an interval" if few else interval(difference.low, difference.high)
        shown = "a" if difference.low > 0 or difference.high < 0 else "no"
        verdict = "" if few else f": {shown} difference between the two is shown"
        values.append(f"the difference {number(difference.value)} ({ends}){verdict}")
    if primary:
        one = next(iter(known.values()))
        said.append(f"Primary statistic, fixed beforehand: {scale} is {values.pop(0)}: {_verdict(one)}.")
        scale = "the alignment"
    if values:
        said.append(f"Secondary: {scale} is {'; '.join(values)}.")
    means = " and ".join(f"{_mean_axis(one)}{name}" for name, one in known.items())
    told = f"{'The' if values else 'Secondary: the'} fall axes of {results.words.blocks} lie on average {means}."
    if closer := " and ".join(f"{one.closer_to_normal} of {one.told}{name}" for name, one in known.items() if one.told):
        lie = "lies" if sum(one.told for one in known.values()) == 1 else "lie"
        told += f" Of the earthquakes whose falls have an axis {closer} {lie} closer to the normal than to the fault."
    return *said, told


def _alignment(summary: AxisSummary) -> str:
    one = summary.alignment
    sure = "" if math.isnan(one.low) else f"95 % interval {interval(one.low, one.high)}; "
    count = counted(one.n, "earthquake")
    if one.n < summary.earthquakes:
        count = f"{one.n} of {counted(summary.earthquakes, 'earthquake')} with falls"
    return f"{number(one.value)} ({sure}{count})" if one.n else "not known"


def agreement_within(results: Results) -> str:
    """How far the fall axes of one record agree, over earthquakes, by group of records."""
    lengths, events = results.record_means["axis_resultant"].to_numpy(), results.cube["event"].to_numpy().astype(str)
    parts = []
    for name, members in record_groups(results.cube).items():
        found = mean_over_earthquakes(np.where(members, lengths, np.nan), events)
        parts.append(estimate(found.value, found.low, found.high) + _name(name))
    return (
        f"Within a record the fall axes of {results.words.blocks} agree with a mean resultant of "
        f"{' and '.join(parts)}; 1 means that all are alike, 0 that they have no axis in common. "
        f"{results.words.which}".rstrip()
    )


def _verdict(summary: AxisSummary) -> str:
    """What the interval of the alignment says."""
    one = summary.alignment
    if one.n == 0:
        return "no earthquake has falls and a known fault"
    if math.isnan(one.low):
        return f"{counted(one.n, 'earthquake')} {'is' if one.n == 1 else 'are'} too few for an interval"
    if one.low > 0:
        return "falls lie closer to the fault normal than to the fault"
    if one.high < 0:
        return "falls lie closer to the fault than to its normal"
    return "neither the normal nor the fault is shown to be preferred"


def _name(group: str) -> str:
    """Name of a group inside a sentence; nothing for the only one."""
    return "" if group == "all records" else " " + group.replace("without (control)", "without a pulse")


def _mean_axis(summary: AxisSummary) -> str:
    if math.isnan(summary.axis_deg):
        return "along no common axis"
    spread = "" if math.isnan(summary.half_width_deg) else f"\u00a0{half_width(summary)}"
    return f"{degrees(abs(summary.axis_deg))}{spread} from the fault normal"


def half_width(summary: AxisSummary) -> str:
    """Half of the interval of a mean axis, ± 12°."""
    width = summary.half_width_deg
    return "–" if math.isnan(width) else f"±\u00a0{degrees(width)}"


def _directions_in_words(results: Results) -> list[str]:
    """Mean fall direction and axis of each of a few records where there is no fault to compare them with."""
    many = len(results.names) > MOST_RECORDS_IN_WORDS
    if many or results.faults_known or not results.fallen > 0 or results.one_axis:
        return []
    return [
        f"{name.station}: mean fall direction {direction} (resultant {one}), mean fall axis {axis} (resultant "
        f"{other}), over {results.words.blocks}, each plane once; a resultant near 0 means falls to nearly every side."
        for name, (direction, one, axis, other, *_) in zip(results.names, record_directions(results), strict=True)
        if direction != "–" or axis != "–"
    ]


def _counted(results: Results) -> str:
    """How many records and earthquakes, and what their number means."""
    records, with_vertical = len(results.names), results.with_vertical
    names = "".join(f" {said}." for said in earthquakes_said(results.cube))
    vertical = {
        0: " None of these records has vertical motion; what it would change is not in these numbers.",
        records: "",
    }.get(with_vertical, f" {with_vertical} records have vertical motion, the others none.")
    return (
        f"{counted(records, 'record')} of {counted(results.earthquake_count, 'earthquake')}.{names} Records of one "
        f"earthquake are not independent, so earthquakes are counted, not records; {results.model.direction}s of one "
        f"record are the same motion seen from many sides, so they are no samples at all.{vertical}"
    )


def _cases(results: Results) -> str:
    """Of how many cases the report speaks, and how many have no outcome."""
    cases = int(results.cube["overturned"].size)
    computed = int((results.cube[results.model.copied] == 0).sum().compute())
    falls = results.elements[-1].share if results.elements else results.fallen
    what = "In {} of them something falls." if results.elements else "{} of them overturn."
    share = "" if math.isnan(falls) else f" {what.format(percent(falls))}"
    copied = f"{computed:,} were computed, the others are {results.words.copies}"
    others = "all were computed" if computed == cases else copied
    absent = ", ".join(f"{count:,} {name}" for name, (_, count) in results.statuses.items() if count)
    missing = f"Without an outcome: {absent}." if absent else "No outcome is missing."
    of = " × ".join(("record", *results.model.dims)).replace("b_over_h", "B/H")
    factors = len(results.study.amplitude) - 1
    times = f" The cube also has them under the records multiplied by {counted(factors, 'other factor')}."
    more = times if factors else ""
    return f"The study has {cases:,} cases ({of}); {others}.{share} {missing}{more}"


def falls(results: Results) -> Section | None:
    """Rose of fall azimuths, and the alignment with the fault normal by shape; none where nothing falls."""
    if not results.fallen > 0:
        return None
    folder = results.figures
    caption = f"{results.words.rose} {results.words.which}".rstrip()
    blocks: list[Block] = [Figure(folder / "rose.svg", "rose of fall azimuths", caption, width=0.8)]
    if not results.model.one_component:
        of_each = "The same for each earthquake, its records taken together; dashed: fault normals."
        alt = "roses of fall azimuths by earthquake"
        blocks.append(Figure(folder / "earthquakes.svg", alt, of_each, width=0.9))
    if results.tells_axes:
        about = (
            f"Falls of {results.words.blocks}. Alignment: cos 2Δ, Δ the angle between a fall and the fault normal of "
            "its record, is averaged over the falls of a record, over the records of an earthquake, and over "
            f"earthquakes: 1 normal to the fault, −1 along it, 0 neither.{_weighed(results)} An earthquake has an axis "
            f"where the resultant of its falls reaches {LEAST_RESULTANT:g}; these are counted as closer to the normal "
            "or not. Intervals: 95 %, bootstrap over earthquakes."
        )
        blocks += [_summary(results.axes), Note(about)]
        note = Note(
            f"Counted are the earthquakes with falls of {results.words.blocks}; the alignment is the mean over these. "
            "No p-value is given here: with so many shapes some would look small by chance."
        )
        blocks.append(Disclosure("Alignment with the fault normal by B/H and friction", (_by_shape(results), note)))
    return Section("Where blocks fall", tuple(blocks), anchor="rose")


def _weighed(results: Results) -> str:
    """That means take falls with their probabilities, and roses do not; empty without an ensemble."""
    if not results.study.ensemble.members:
        return ""
    return (
        " Each case counts with the probability of its fall over its neighbourhood; the rose counts the falls of the "
        "cases themselves."
    )


def _by_shape(results: Results) -> Table:
    """Mean alignment over earthquakes for each B/H and friction, heights taken together, and over how many it is."""
    cube = results.cube
    heads, columns = ["B/H", "µ"], []
    for name, chosen in record_groups(cube).items():
        axes = axes_by_earthquake(cube.isel(record=np.flatnonzero(chosen)), "b_over_h", "friction")
        found = axes["falls"].sum("event"), axes["cosine"].count("event"), axes["cosine"].mean("event")
        columns += [one.to_numpy() for one in found]
        heads += [f"earthquakes with falls, {name}", f"of these counted, {name}", f"alignment, {name}"]
    rows = [
        (b_over_h, friction, *(column[i, j] for column in columns))
        for i, b_over_h in enumerate(cube["b_over_h"].to_numpy())
        for j, friction in enumerate(cube["friction"].to_numpy())
    ]
    return table(heads, rows, "gg" + "nn2" * (len(columns) // 3), sortable=True)


def _summary(axes: dict[str, AxisSummary]) -> Table:
    rows = [
        (
            *(name, s.earthquakes, s.alignment.n, s.alignment.value, interval(s.alignment.low, s.alignment.high)),
            *(abs(s.axis_deg), half_width(s), f"{s.closer_to_normal} of {s.told}"),
        )
        for name, s in axes.items()
    ]
    heads = ("records", "earthquakes", "with falls", "alignment", "interval", "mean axis from normal", "interval")
    return table((*heads, "closer to normal"), rows, "tnn2n°")
