"""What makes a block fall, how well the field's criteria predict it, and findings beside published ones."""

import math
from typing import Final

from overturning.findings.causes import computed_outcomes_at_published_cells
from overturning.labels import element_size_note, friction_label
from overturning.report.blocks import Disclosure, Figure, Note, Said, Table, section, table
from overturning.report.results import Results
from overturning.report.text import capitalised, counted, interval, number, percent, shown, two_digits
from overturning.statistics.criteria import (
    CRITERIA,
    PULSE_VALID,
    SECONDARY_SOURCES,
    SLENDERNESS_ONLY,
    CriteriaScores,
    score_criteria,
)
from overturning.statistics.logistic import LogisticFit, coefficient_table, fit_overturning
from overturning.study.evaluation import Published
from overturning.units import CM, GAL

DOUBLED = {1: "PGA, and PGV with it,", 2: "PGV alone", 4: "the size of a block alone"}
"""What doubles where a predictor of `statistics.logistic.fit_overturning` grows by ln 2, by its place."""

MAX_CONTACT_WIDTH = 100.0
"""An interval of odds whose ends differ by more than this factor tells nothing."""

# How far a peak may lie from a published one whose processing is not known: each integration lets its choices in.
_PEAKS: Final = (
    ("pga", "pga_gal", "PGA, Gal", GAL, 0.01),
    ("pgv", "pgv_cm_s", "PGV, cm/s", CM, 0.05),
    ("pgd", "pgd_cm", "PGD, cm", CM, 0.20),
)


@section("What makes a block fall", "intensity")
def cause(results: Results) -> Said:
    """Falls in the plane of PGA and PGV/PGA, and the logistic fit; none where cases have no azimuth of their own."""
    if not results.model.one_component:
        return
    shown = results.figures / "plane.svg", "falls in the plane of PGA and PGV/PGA"
    if another := element_size_note(results.cube):
        yield Figure(*shown, "Each point is one plane of one record.", width=0.92)
        yield f"Limits and a fit go by a stone's own height and B/H. {another}, so neither is given."
        return
    fit = fit_overturning(results.cube, results.intensity)
    fitted = not fit.note.startswith("no fit")
    caption = (
        "Each point is one plane of one record. Lines: the field's criteria, by which a block falls to the right of "
        f"them{', and the fit to this study' if fitted else ''}."
    )
    if fitted and results.cube.sizes["friction"] > 1:
        most = friction_label(results.study, float(results.cube["friction"].max()))
        caption += f" Points are of {most}; the fit takes all frictions together."
    yield Figure(*shown, caption, width=0.92)
    yield doubling_sentence(fit)
    yield f"{capitalised(fit.note)}." if fit.note else None
    if fitted:
        rows = [
            (name, value, interval(low, high), interval(least, most))
            for name, value, low, high, least, most in coefficient_table(fit)
        ]
        yield table(("predictor", "coefficient", "95 % interval", "range of the data"), rows, "t2")
        yield Note(
            f"Logistic fit of the probability of overturning to {fit.rows:,} planes and blocks of "
            f"{counted(fit.clusters, 'earthquake')}; estimates, corrected for bias, and intervals by leaving out one "
            "earthquake at a time. PGV/PGA in s, H in m. It says nothing outside the range of the data."
        )


def doubling_sentence(fit: LogisticFit) -> str:
    """What doubling the motion or the block does to the odds of a fall; empty where nothing was fitted."""
    parts, untold = [], []
    for place, what in DOUBLED.items():
        factor, low, high = (2.0 ** float(values[place]) for values in (fit.coefficient, fit.low, fit.high))
        if math.isnan(factor):
            continue
        if high <= MAX_CONTACT_WIDTH * low:
            parts.append(f"by {two_digits(factor)} ({two_digits(low)} to {two_digits(high)}) where {what} doubles")
        else:
            untold.append(what)
    sentence = f"The odds of a fall are multiplied {'; '.join(parts)}." if parts else ""
    if not untold:
        return sentence
    unknown = (
        f"{counted(fit.clusters, 'earthquake')} cannot tell by how much the odds of a fall grow where "
        f"{' or '.join(untold)} doubles."
    )
    return f"{sentence} {unknown}".strip()


@section("How well the field's criteria predict these falls", "criteria")
def criteria(results: Results) -> Said:
    """Hits and misses of each criterion, over all and by block; none where outcomes, azimuths or sizes are untold."""
    asked = results.model.one_component and not element_size_note(results.cube)
    found = score_criteria(results.cube, results.intensity) if asked else None
    if found is None:
        return
    yield _sentence(found)
    rules = [
        (
            *(one.name, one.rule, one.overall.hit_rate, one.overall.false_alarm_rate),
            *(shown(one.skill), shown(one.within), one.within_valid),
        )
        for one in found.rules
    ]
    heads = ("rule", "a block falls where", "hits", "false alarms", "skill, all blocks at once", "skill within blocks")
    yield table((*heads, f"the same, ω/p ≤ {PULSE_VALID:g}"), rules, "tt%%nn2", anchor="criteria-summary")
    yield Note(
        "Each plane of every record with its own PGA and PGV, all frictions together, the cells' own outcomes. Hits: "
        "falls that were predicted, of all falls. False alarms: stands for which a fall was predicted, of all stands. "
        "Skill: hits less false alarms, 1 perfect, 0 a guess; of all blocks at once slender against stout counts too, "
        "within blocks (mean weighted by f(1 − f), f the share that falls) the motion alone. 95 % intervals: "
        "bootstrap over earthquakes. The criteria were made for the ground's peak values, not for those of a plane."
    )
    blocks = []
    for (height, shape), scores in found.blocks.items():
        each = (f"{percent(one.hit_rate)}, {percent(one.false_alarm_rate)}, {number(one.skill)}" for one in scores)
        blocks.append((height, shape, scores[0].falls, *each))
    names = ("H, m", "B/H", "falls", *(f"{one.name}: hits, false alarms, skill" for one in CRITERIA))
    by_block = table(names, blocks, "gg%", anchor="criteria-blocks", sortable=True)
    yield Disclosure("By size and slenderness", (by_block,))


def _sentence(found: CriteriaScores) -> str:
    """Sentences: the best criterion within blocks, and the criteria with less skill than a rule without motion."""
    blind = found.rules[-1]
    if not found.leads:
        return "Of each block all fall or all stand, so no criterion can show skill."
    said = _ranking(found)
    if blind.name == SLENDERNESS_ONLY:
        below = [one.name for one in found.rules[:-1] if one.overall.skill < blind.overall.skill]
        less = f"; {len(below)} of the {len(CRITERIA)} criteria have less ({'; '.join(below)})" if below else ""
        said += (
            f" Over all blocks at once a rule that knows nothing of the motion, {blind.rule}, has "
            f"{number(blind.overall.skill)}{less}."
        )
    if found.beyond > 0:
        said += (
            f" {percent(found.beyond)} of the planes and blocks lie beyond ω/p = {PULSE_VALID:g}, where the rule of "
            "the pulse with one impact is known to be far too low."
        )
    return said


def _ranking(found: CriteriaScores) -> str:
    """Sentence on the criterion with the most skill within blocks, and those from which it is not distinguished."""
    best, among = found.best, "Among blocks of one size and shape"
    skills = {one.name: one.within for one in found.rules}
    rivals = {name: lead for name, lead in found.leads.items() if not lead.low > 0}
    if not rivals:
        said = f"{among} the rule “{best.name}” predicts best: mean skill {shown(best.within)}."
    else:
        others = "; ".join(
            f"“{name}”, {shown(skills[name])}, with a difference of {shown(lead)}" for name, lead in rivals.items()
        )
        few = " (too few earthquakes for an interval)" if any(math.isnan(lead.low) for lead in rivals.values()) else ""
        said = (
            f"{among} no rule is shown to predict best: “{best.name}” has a mean skill of {shown(best.within)} and is "
            f"not distinguished from {others}{few}."
        )
    if unread := [f"“{name}”" for name in (best.name, *rivals) if name in SECONDARY_SOURCES]:
        said += f" The formula of {' and of '.join(unread)} is as others give it; the paper itself could not be read."
    return said


@section("Beside the published values", "published")
def published(results: Results) -> Said:
    """Peaks and findings beside the published ones; none where nothing was published."""
    there, rows = results.study.published, []
    if not there:
        return
    yield " ".join(capitalised(finding_sentence(results, variant)) for variant in results.cubes)
    yield _peaks(results)
    for variant in results.cubes:
        for size, overturns in computed_outcomes_at_published_cells(results, variant).items():
            holds = "holds" if overturns == tuple(row.overturns for row in there) else "does not hold"
            rows.append((variant, *size, *map(_does, overturns), holds))
    heads = (f"{_label(row)}: {_does(row.overturns)}" for row in there)
    yield table((_settings(results), "H, m", "µ", *heads, "finding"), rows, "tgg" + "t" * (len(there) + 1))


def _settings(results: Results) -> str:
    """What the study's settings are called: contacts, where its variants differ in nothing else."""
    others = any(one.scene or one.site or one.vertical is not None for one in results.study.variants.values())
    return "setting" if others else "contact"


def finding_sentence(results: Results, variant: str) -> str:
    """For which sizes of a variant the published outcomes are found; to stand within a sentence."""
    found, wanted = (
        computed_outcomes_at_published_cells(results, variant),
        tuple(row.overturns for row in results.study.published),
    )
    frictions = {friction for _, friction in found}
    sizes: dict[tuple[float, ...], list[str]] = {}
    for height in sorted({height for height, _ in found}):
        if there := tuple(sorted(one for one in frictions if found[height, one] == wanted)):
            sizes.setdefault(there, []).append(f"{height:g}")
    at = {
        these: f" with µ = {', '.join(f'{one:g}' for one in these)}" for these in sizes if len(these) < len(frictions)
    }
    parts = [f"for H = {', '.join(heights)} m{at.get(these, '')}" for these, heights in sizes.items()]
    where = " and ".join(parts) or "for none of the sizes"
    count = f"({sum(overturns == wanted for overturns in found.values())} of {len(found)})"
    return f"with the {variant} {_settings(results)} the published outcomes are found {where} {count}."


def _peaks(results: Results) -> Table:
    """Peaks along the published azimuths beside the published peaks."""
    ids = [name.id for name in results.record_names]
    rows = []
    for row in results.study.published:
        measures = results.intensity.isel(record=ids.index(row.record)).sel(azimuth=row.azimuth)
        for name, key, quantity, unit, tolerance in _PEAKS:
            there = getattr(row, key)
            if there is not None:
                found = float(measures[name]) / unit
                difference = found / there - 1
                shown = f"{100 * difference:+z.1f}\u00a0%".replace("-", "−")
                agrees = "agrees" if abs(difference) <= tolerance else "differs"
                rows.append((_label(row), quantity, f"{there:.1f}", f"{found:.1f}", shown, tolerance, agrees))
    heads = ("component", "quantity", "published", "found", "difference", "expected within", "")
    return table(heads, rows, "ttnnn%t")


def _does(overturns: bool | None) -> str:
    return "not found" if overturns is None else ("overturns" if overturns else "stands")


def _label(row: Published) -> str:
    return row.label or f"{row.record}, {row.azimuth:g}°"
