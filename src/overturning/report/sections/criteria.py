"""How well the field's criteria foretell the falls of the study."""

import math

from overturning.report.blocks import Block, Disclosure, Note, Paragraph, Section, Table
from overturning.report.results import Results
from overturning.report.text import interval, number, percent
from overturning.statistics.criteria import CRITERIA, CriteriaScores, Score, criteria_scores


def criteria(results: Results) -> Section | None:
    """Hits and misses of each criterion, over all and by block; none where outcomes or azimuths are not known."""
    if not results.model.one_component:
        return None
    found = criteria_scores(results.cube, results.intensity)
    if found is None:
        return None
    about = Note(
        "Each plane of every record with its own PGA and PGV, all frictions together, the cells' own outcomes. Hits: "
        "falls "
        "that were foretold, of all falls. False alarms: stands for which a fall was foretold, of all stands. Skill: "
        "hits "
        "less false alarms, 1 perfect, 0 a guess; its 95 % interval by bootstrap over earthquakes. The criteria were "
        "made "
        "for the ground's peak values, not for those of a plane."
    )
    blocks: list[Block] = [
        Paragraph(_sentence(found)),
        _summary(found),
        about,
        Disclosure("By size and slenderness", (_by_block(found),)),
    ]
    return Section("How well the field's criteria foretell these falls", tuple(blocks), anchor="criteria")


def _sentence(found: CriteriaScores) -> str:
    """Which criterion has the most skill, and how the others err."""
    skills = [one.skill for one in found.overall]
    if any(math.isnan(skill) for skill in skills):
        return "Everything falls or everything stands, so no criterion can show skill."
    best = max(range(len(skills)), key=skills.__getitem__)
    parts = [
        f"{one.name} foretells {percent(score.hit_rate)} of the falls at {percent(score.false_alarm_rate)} false alarms"
        for one, score in zip(CRITERIA, found.overall, strict=True)
    ]
    head = f"Of the field's criteria {CRITERIA[best].name} has the most skill here ({number(skills[best])})."
    return f"{head} {'; '.join(parts)}."


def _summary(found: CriteriaScores) -> Table:
    rows = tuple(
        (
            *(one.name, one.rule, percent(score.hit_rate), percent(score.false_alarm_rate)),
            *(number(score.skill), interval(*bounds), percent(score.right)),
        )
        for one, score, bounds in zip(CRITERIA, found.overall, found.interval, strict=True)
    )
    heads = ("criterion", "a block falls where", "hits", "false alarms", "skill", "interval", "right")
    return Table(heads, rows, "tt", anchor="criteria-summary")


def _by_block(found: CriteriaScores) -> Table:
    rows = tuple(
        (f"{height:g}", f"{shape:g}", percent(found.falls[height, shape]), *map(_cell, scores))
        for (height, shape), scores in found.blocks.items()
    )
    heads = ("H, m", "B/H", "falls", *(f"{one.name}: hits, false alarms, skill" for one in CRITERIA))
    return Table(heads, rows, "nn", anchor="criteria-blocks", sortable=True)


def _cell(score: Score) -> str:
    return f"{percent(score.hit_rate)}, {percent(score.false_alarm_rate)}, {number(score.skill)}"
