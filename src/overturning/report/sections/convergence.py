"""How exact the answers are: part of the study, run again with finer steps and with stiffer springs."""

from typing import Final

from overturning.report.blocks import Block, Caution, Note, Paragraph, Section, Table
from overturning.report.results import Results
from overturning.report.text import percent
from overturning.study.convergence import ASIDE, NUDGE, WARN_ABOVE, Convergence, Repetition
from overturning.study.ensemble import wilson

_SETTINGS: Final = {"finer": "a smaller simulation.time_step", "stiffer": "a larger contact.stiffness"}


def _repetitions(found: Convergence) -> dict[str, tuple[str, Repetition]]:
    """Each repetition with what it is called."""
    names = f"steps {found.finer_by} times finer", f"springs {found.stiffer_by:g} times stiffer"
    return {"finer": (names[0], found.finer), "stiffer": (names[1], found.stiffer)}


def convergence(results: Results) -> Section | None:
    """What changes when a part of the study is run again; none where the study leaves it out."""
    found = results.convergence
    if found is None:
        return None
    repetitions = _repetitions(found).values()
    warns = [
        name
        for name, part in repetitions
        if any(outcome.flags_undivided > WARN_ABOVE * outcome.cases for outcome in part.outcomes)
    ]
    blocks: list[Block] = []
    if warns:
        warning = (
            f"Warning: with {' and with '.join(warns)} more than {percent(WARN_ABOVE)} of the flags change, those not "
            "counted that the neighbourhood does not agree on. Do not trust single cells of this study; a smaller time "
            "step or a stiffer contact is needed."
        )
        blocks.append(Caution(warning))
    text = _text(found) + _settled(found)
    if found.chosen:
        several = any(len(part.outcomes) > 1 for _, part in repetitions)
        text += " Each element of the scene is counted by itself." if several else ""
        text += " The variants were not run again." if results.study.variants else ""
    heads = ("run again with", "what changed", "changed", "compared", "share", "95 % interval", "no answer")
    note = (
        f"Interval by Wilson. The study itself took {found.study_block_steps:.3g} block steps. Seed of the choice: "
        f"{found.seed}."
    )
    way = "side" if results.model.one_component else f"azimuth, by {ASIDE:g}° or more"
    side = f"{way}, where it falls"
    agreed = bool(results.study.ensemble.members)
    rows = tuple(row for name, part in repetitions for row in _rows(name, part, found.study_block_steps, side, agreed))
    blocks += [Paragraph(text), Table((*heads, "block steps", "of the study's"), rows, "tt"), Note(note)]
    return Section("How exact these answers are", tuple(blocks), anchor="convergence")


def dependence(results: Results) -> Paragraph | None:
    """How much of the answer depends on step and stiffness, in a line, with the setting that would help."""
    found = results.convergence
    if found is None or not found.chosen:
        return None
    shares, helps, sure = [], [], 0.0
    for kind, (name, part) in _repetitions(found).items():
        outcomes = [one for one in part.outcomes if one.cases]
        if outcomes:
            share = max(one.flags / one.cases for one in outcomes)
            shares.append(f"{percent(share, 1)} of the flags with {name}")
            undivided = max(one.flags_undivided / one.cases for one in outcomes)
            helps += [_SETTINGS[kind]] if undivided > WARN_ABOVE else []
            sure = max(sure, undivided)
    if not shares:
        return None
    text = f"Run again, {found.chosen} cases change {' and '.join(shares)}"
    if results.study.ensemble.members:
        text += f", at most {percent(sure, 1)} where the neighbourhood of a case agrees on one"
    if not helps:
        return Note(f"{text}: this little of the answer depends on the computation.")
    return Caution(
        f"{text}. Do not trust single cells; {' and '.join(helps)} would help (How exact these answers are, below)."
    )


def _text(found: Convergence) -> str:
    """How many cases were run again, and why no more."""
    chosen, wanted = found.chosen, found.wanted
    allowed = "the study itself" if found.cost == 1 else f"{found.cost:g} times the study itself"
    short = f"the {wanted} that were asked for would have taken more block steps than {allowed}"
    if chosen == 0:
        unknown = "So this report cannot say how exact its answers are."
        return f"No case was run again: {short} (verification.cost). {unknown}"
    why = f" ({short}; verification.cost sets this bound, and so few leave the intervals wide)"
    return (
        f"{chosen} of the {found.cells} cases, drawn at random, were run again{why if chosen < wanted else ''}; "
        f"{found.at_rest} of them lie below the thresholds of rocking and sliding and cannot change."
    )


def _settled(found: Convergence) -> str:
    """What a finer computation settles of what changed, and what none does."""
    settling = found.settling
    changed, looked, settled, chaotic = settling.changed, settling.looked_at, settling.settled, settling.chaotic
    if not changed:
        return ""
    if not looked:
        return f" With finer steps {_cases(changed)} changed; verification.cost leaves no room to look why."
    which = _were(changed, "it", "they") if looked == changed else _were(looked, f"{looked} of them")
    low, high = map(float, wilson(chaotic, found.chosen))
    interval = f"95 % interval {100 * low:.2f} to {percent(high, 2)}"
    share = f"{percent(chaotic / found.chosen, 2)} of the cases run again ({interval})"
    decided = f"; no computation decides these{f', {share}' if looked == changed else ''}" if chaotic else ""
    return (
        f" With finer steps {_cases(changed)} changed; {which} computed twice more, in steps half as long as those, "
        f"and in those under a motion stronger by a factor of 1 + {NUDGE:g}, less than is known of any. {settled} kept "
        f"the answer of the finer steps, which so is settled; {looked - settled - chaotic} changed with the shorter steps "
        f"only and would need finer ones yet; {chaotic or 'none'} changed with the motion{decided}."
    )


def _were(count: int, one: str, more: str = "") -> str:
    return f"{one} was" if count == 1 else f"{more or one} were"


def _cases(count: int) -> str:
    return "1 case" if count == 1 else f"{count} cases"


def _rows(name: str, part: Repetition, own: int, side: str, agreed: bool) -> list[tuple[str, ...]]:
    """Rows of one repetition; its name and its work, also as a share of the study's own, stand in the first."""
    if not part.outcomes:
        return [(name, f"not possible: {part.refused}", *[""] * 7)]
    rows: list[tuple[str, ...]] = []
    for outcome in part.outcomes:
        whose = f"{outcome.element} " if outcome.element else ""
        undivided = ("of these where the neighbourhood agrees", outcome.flags_undivided, outcome.cases)
        for what, changed, compared in (
            ("falls or stands", outcome.flags, outcome.cases),
            *([undivided] if agreed else []),
            (side, outcome.sides, outcome.fallen),
        ):
            low, high = map(float, wilson(changed, compared))
            share, bounds = "–", "–"
            if compared:
                share, bounds = percent(changed / compared, 2), f"{100 * low:.2f} to {percent(high, 2)}"
            rows.append(("", whose + what, str(changed), str(compared), share, bounds, "", "", ""))
    unanswered, steps = max(outcome.unanswered for outcome in part.outcomes), part.block_steps
    work = (str(unanswered), f"{steps:.3g}", percent(steps / own) if own else "")
    return [(name, *rows[0][1:-3], *work), *rows[1:]]
