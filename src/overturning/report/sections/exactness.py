"""How exact the answers are: the spread over the neighbourhood of each case, and part of the study run again."""

import math
from typing import Any, Final, NamedTuple

import numpy as np

from overturning.findings.exactness import count_disagreeing_cells
from overturning.report.blocks import Caution, Note, Paragraph, Said, section, table
from overturning.report.results import Results
from overturning.report.text import counted, percent
from overturning.study.answers import MAX_AZIMUTH_DIFFERENCE_DEG
from overturning.study.convergence import (
    AMPLITUDE_PERTURBATION,
    AMPLITUDE_REACH,
    MIN_AZIMUTH_SHIFT_DEG,
    WARN_ABOVE,
    Convergence,
    RerunResult,
    RigidComparison,
)
from overturning.study.ensemble import cells_to_run, wilson_interval
from overturning.study.sample import NO_SLIP_FRICTION

_SETTINGS: Final = {"finer": "a smaller simulation.time_step", "stiffer": "a larger contact.stiffness"}

_NEEDED: Final = "; a smaller time step or a stiffer contact is needed"
"""In planes: the springs of a body in space are those of its weight."""


def _repetitions(found: Convergence) -> dict[str, tuple[str, RerunResult]]:
    """Each repetition with what it is called."""
    names = f"steps {found.finer_by} times finer", f"springs {found.stiffer_by:g} times stiffer"
    return {"finer": (names[0], found.finer), "stiffer": (names[1], found.stiffer)}


def _undivided(part: RerunResult) -> list[float]:
    """Share of flags that change where the neighbourhood is not divided, of each element."""
    return [one.flags_undivided / one.undivided for one in part.outcomes if one.undivided]


@section("How exact these answers are", "convergence")
def convergence(results: Results) -> Said:
    """What changes when a part of the study is run again; none where the study leaves it out."""
    found = results.convergence
    if found is None:
        return
    repetitions = _repetitions(found).values()
    if warns := [name for name, part in repetitions if max(_undivided(part), default=0.0) > WARN_ABOVE]:
        yield Caution(
            f"Warning: with {' and with '.join(warns)} more than {percent(WARN_ABOVE)} of the flags change even where "
            "the neighbourhood is not divided. Do not trust single cells of this study"
            f"{_NEEDED if results.model.one_component else ''}."
        )
    text, rigid = _text(found) + _settled(found) + _moved(results, found), found.rigid
    if found.chosen:
        several = any(len(part.outcomes) > 1 for _, part in repetitions)
        text += " Each element of the scene is counted by itself." if several else ""
        text += " The variants were not run again." if results.study.variants else ""
    agreed = bool(results.study.ensemble.members)
    yield text + (_beside_rigid(rigid, agreed) if rigid else "")
    way = "side" if results.model.one_component else f"azimuth, by {MAX_AZIMUTH_DIFFERENCE_DEG:g}° or more"
    drawn = Sampling(f"{way}, where it falls", agreed, found.chosen < found.computed)
    rows = [row for name, part in repetitions for row in _rows(name, part, found.study_block_steps, drawn)]
    if rigid:
        part = RerunResult(block_steps=0, outcomes=[rigid])
        rows += _rows("exact rigid block", part, 0, drawn._replace(sampled=_is_sampled(rigid)))
    heads = ("run again with", "what changed", "changed", "compared", "share", "95 % interval", "no answer")
    yield table((*heads, "block steps", "of the study's"), rows, "tt")
    yield Note(
        "Interval of a random sample, by Wilson; a count of all cells has none. The study itself took "
        f"{found.study_block_steps:.3g} block steps. Seed of the choice: {found.seed}."
    )


def dependence(results: Results) -> Paragraph | None:
    """How much of the answer depends on step and stiffness, in a few lines, with the setting that would help."""
    found = results.convergence
    if found is None or not found.chosen:
        return None
    flags, ways, agreed, warned = [], [], list[float](), list[str]()
    for kind, (name, part) in _repetitions(found).items():
        outcomes = [one for one in part.outcomes if one.cases]
        if outcomes:
            flags.append(f"in {percent(max(one.flags / one.cases for one in outcomes), 1)} of the cases with {name}")
            undivided = _undivided(part)
            warned += [kind] if max(undivided, default=0.0) > WARN_ABOVE else []
            agreed += undivided
        if fallen := sum(one.fallen for one in outcomes):
            sides = sum(one.sides for one in outcomes)
            bounds = f" ({_wilson(sides, fallen, 1)})" if found.chosen < found.computed else ""
            ways.append((f"{percent(sides / fallen, 1)}{bounds}", f"with {name}"))
    if not flags:
        return None
    text = f"{found.chosen:,} cases were run again."
    if ways:
        where = (
            "to the other side" if results.model.one_component else f"{MAX_AZIMUTH_DIFFERENCE_DEG:g}° or more elsewhere"
        )
        (first, with_it), *more = ways
        text += f" Of the falls {' and '.join([f'{first} go {where} {with_it}', *map(' '.join, more)])}."
    text += f"{_moved(results, found)} Whether a block falls at all changes {' and '.join(flags)}"
    if results.study.ensemble.members and agreed:
        most = f"at most {percent(max(agreed), 1)}" if max(agreed) > 0.0 else "none"
        text += f"; where the neighbourhood of a case is not divided, in {most}"
    if not warned:
        return Paragraph(f"{text}. No single cell is more certain than that.")
    helps = " and ".join(_SETTINGS[kind] for kind in warned if kind == "finer" or results.model.one_component)
    would = f"; {helps} would help" if helps else ""
    return Caution(f"{text}. Do not trust single cells{would} (How exact these answers are, below).")


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
        f"{chosen:,} of the {found.cells:,} cases, drawn at random, were run again{why if chosen < wanted else ''}; "
        f"{f'{found.at_rest:,}' if found.at_rest else 'none'} of them {'lies' if found.at_rest < 2 else 'lie'} below "
        "the thresholds of rocking and sliding and cannot change."
    )


def _moved(results: Results, found: Convergence) -> str:
    """Share of falls in space whose azimuth moves under nearly the same motion, and their weight in directions."""
    one = found.amplitude
    if one is None or not one.falls:
        return ""
    bounds = f" ({_wilson(one.moved, one.falls, 1)})" if found.chosen < found.computed else ""
    weight = "the study has no ensemble, so that directions, axes and roses count them in full"
    if results.study.ensemble.members:
        of_all = percent(one.weight_moved / one.weight if one.weight else math.nan, 1)
        weight = (
            f"each fall counts in directions with its resultant over the ensemble, these with {of_all} of the weight"
        )
    return (
        f" Of {counted(one.falls, 'fall')} {percent(one.moved / one.falls, 1)}{bounds} go {MIN_AZIMUTH_SHIFT_DEG:g}° "
        f"or more elsewhere under motions within ± {percent(AMPLITUDE_REACH)} of the amplitude; {weight}."
    )


def _settled(found: Convergence) -> str:
    """What a finer computation settles of what changed, and what none does."""
    settling = found.settling
    changed, looked, settled, chaotic = settling.changed, settling.looked_at, settling.settled, settling.chaotic
    if not changed:
        return ""
    head = f" With finer steps {counted(changed, 'case')} changed; "
    if not looked:
        return f"{head}verification.cost leaves no room to look why."
    all_of_them, were = looked == changed, "was" if looked == 1 else "were"
    which = ("it" if changed == 1 else "they") if all_of_them else f"{looked} of them"
    bounds = f" (95 % interval {_wilson(chaotic, found.chosen)})" if found.chosen < found.computed else ""
    share = f": {percent(chaotic / found.chosen, 2)} of the cases run again{bounds}"
    undecided = f", and no computation can decide {'it' if chaotic == 1 else 'them'}"
    decided = f"{undecided}{share if all_of_them else ''}" if chaotic else ""
    return (
        f"{head}{which} {were} computed twice more, in steps half as long as those, and in those under a motion "
        f"stronger by a factor of 1 + {AMPLITUDE_PERTURBATION:g}, far less than any record is known to. {settled} kept "
        f"the answer of the finer steps, which is thereby settled; {looked - settled - chaotic} changed with the "
        f"shorter steps only and would need finer ones still; {chaotic or 'none'} changed with the motion{decided}."
    )


def _beside_rigid(found: RigidComparison, agreed: bool) -> str:
    """In how many cells the exact rigid block has the study's answer."""

    def same(changed: int, sides: int, cases: int) -> tuple[str, ...]:
        return tuple(percent(1 - wrong / cases, 2) for wrong in (changed, changed + sides))

    drawn = f", {found.cases + found.unanswered:,} of them drawn at random" if _is_sampled(found) else ""
    text = f" Blocks of µ ≥ {NO_SLIP_FRICTION:g} with B/H below µ do not slide ({found.cells:,} cases{drawn})."
    if found.unanswered:
        text += (
            f" In {counted(found.unanswered, 'case')} there is nothing to compare: an answer is missing, as that of "
            "the rigid block is under a record in which the ground drops by more than g."
        )
    if not found.cases:
        return text
    flag, side = same(found.flags, found.sides, found.cases)
    text += (
        f" Housner's rigid block, solved exactly, gives {'the others' if found.unanswered else 'them'} the same flag "
        f"in {flag} and the same flag and side in {side} of the cases"
    )
    if agreed and found.undivided:
        sure = same(found.flags_undivided, found.sides_undivided, found.undivided)
        text += f", where the neighbourhood is not divided in {' and '.join(sure)}"
    return f"{text}."


def _wilson(count: int, of: int, digits: int = 2) -> str:
    """The interval of a share, %."""
    low, high = map(float, wilson_interval(count, of))
    return f"{100 * low:.{digits}f} to {percent(high, digits)}"


class Sampling(NamedTuple):
    """Row names of a comparison, and the kind of its sample.

    Attributes
    ----------
    side : str
        Name of a change of side.
    agreed : bool
        True if the study has an ensemble.
    sampled : bool
        True if the cases are a random part; the count of all cells has no sampling interval.
    """

    side: str
    agreed: bool
    sampled: bool


def _is_sampled(found: RigidComparison) -> bool:
    """True if only a part of the cells was compared with the rigid block."""
    return found.cases + found.unanswered < found.cells


def _rows(name: str, part: RerunResult, own: int, drawn: Sampling) -> list[tuple[Any, ...]]:
    """Rows of one repetition; its name and its work, also as a share of the study's own, stand in the first."""
    if not part.outcomes:
        return [(name, f"not possible: {part.refused}", *[""] * 7)]
    rows: list[tuple[Any, ...]] = []
    for outcome in part.outcomes:
        whose = f"{outcome.element} " if outcome.element else ""
        undivided = ("of these where the neighbourhood is not divided", outcome.flags_undivided, outcome.undivided)
        sides = (undivided[0], outcome.sides_undivided, outcome.fallen_undivided)
        one_side = (
            "of these where all of the neighbourhood falls one way",
            outcome.sides_agreed,
            outcome.fallen_agreed,
        )
        for what, changed, compared in (
            ("falls or stands", outcome.flags, outcome.cases),
            *([undivided] if drawn.agreed else []),
            (drawn.side, outcome.sides, outcome.fallen),
            *([sides, one_side] if drawn.agreed else []),
        ):
            bounds = _wilson(changed, compared) if drawn.sampled else "all cells"
            share = (percent(changed / compared, 2), bounds) if compared else "––"
            rows.append(("", whose + what, changed, compared, *share, "", "", ""))
    unanswered, steps = max(outcome.unanswered for outcome in part.outcomes), part.block_steps
    work = (f"{steps:.3g}", percent(steps / own, 1) if own else "") if steps else ("", "")
    return [(name, *rows[0][1:-3], unanswered, *work), *rows[1:]]


@section("Uncertainty", "uncertainty")
def ensemble(results: Results) -> Said:
    """How many cells near a change of flag have runs that are divided; none without an ensemble."""
    model, settings, found = results.model, results.study.ensemble, count_disagreeing_cells(results)
    if found is None:
        return
    changing = "flag" if model.one_component else "flag or of fall azimuth"
    text = f"No cell lies near a change of {changing}, so the ensemble had nothing to run."
    if found.share_of_cells_repeated and found.share_disagreeing is not None:
        fewest, times, until = f"{found.fewest_runs_per_cell:.0f}", f"{found.most_runs_per_cell:.0f}", ""
        if fewest != times:
            mean, within = f"{found.mean_runs_per_cell:.0f}", f"within ± {settings.half_width:g}"
            until = f" (on average {mean}; no more once the 95 % intervals of its probabilities are {within})"
            times = f"{fewest} to {times}"
        alike = np.zeros((1, 1, results.cube.sizes["b_over_h"], 1), np.int8)
        near = "" if cells_to_run(alike, settings.where == "everywhere").all() else f" near a change of {changing}"
        share_falling_both_ways = math.nan if found.share_falling_both_ways is None else found.share_falling_both_ways
        apart = results.words.apart.format(percent(share_falling_both_ways, 1))
        text = (
            f"Each cell{near} ({percent(found.share_of_cells_repeated)} of all) was run {times} more "
            f"times with slightly different amplitude, shape, friction, damping and {model.direction}{until}. In "
            f"{percent(found.share_disagreeing, 1)} of them some of the first {found.first_batch_runs} "
            f"runs fall and others stand (more runs would divide more cells); {apart} This is the spread over the "
            "neighbourhood stated in the study, not a probability of what happened."
        )
    yield text
