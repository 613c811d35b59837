"""How exact the answers are: part of the study, run again with finer steps and with stiffer springs."""

from typing import Any, Final

from overturning.report.blocks import Block, Caution, Note, Paragraph, Section, Table, number_columns, text_columns
from overturning.report.results import Results
from overturning.report.text import percent
from overturning.verification.intervals import wilson
from overturning.verification.study import KINDS, WARN_ABOVE

_NAMES: Final = {"finer": "steps {finer_by} times finer", "stiffer": "springs {stiffer_by:g} times stiffer"}


def own_error(results: Results) -> Section | None:
    """What changes when a part is run again; none where the study leaves it out."""
    return own_error_section(results.verification, len(results.study.variants)) if results.verification else None


def own_error_section(found: dict[str, Any], variants: int) -> Section:
    """What changes when a part of a study is run again.

    Parameters
    ----------
    found : dict
        What the verification of the study found.
    variants : int
        Variants of the study, which are not run again.

    Returns
    -------
    Section
    """
    warns = [
        _NAMES[kind].format(**found)
        for kind in KINDS
        if any(outcome["flags"] > WARN_ABOVE * outcome["cases"] for outcome in _outcomes(found, kind))
    ]
    blocks: list[Block] = []
    if warns:
        blocks.append(
            Caution(
                f"Warning: with {' and with '.join(warns)} more than {percent(WARN_ABOVE)} of the flags change. Do not trust "
                "single cells of this study; a smaller time step or a stiffer contact is needed."
            )
        )
    columns = text_columns("run again with", "what changed") + number_columns(
        *("changed", "compared", "share", "95 % interval", "no answer", "block steps", "of the study's")
    )
    blocks += [
        Paragraph(_text(found, variants)),
        Table(columns, tuple(row for kind in KINDS for row in _rows(found, kind))),
        Note(
            f"Interval by Wilson. The study itself took {found['study_block_steps']:.3g} block steps. Seed of the choice: "
            f"{found['seed']}."
        ),
    ]
    return Section("How exact these answers are", tuple(blocks), anchor="own-error")


def _text(found: dict[str, Any], variants: int) -> str:
    """How many cases were run again, and why no more."""
    chosen, wanted = found["chosen"], found["wanted"]
    allowed = "the study itself" if found["cost"] == 1 else f"{found['cost']:g} times the study itself"
    short = f"the {wanted} that were asked for would have taken more block steps than {allowed}"
    if chosen == 0:
        return (
            f"No case was run again: {short} (verification.cost). So this report cannot say how exact its answers are."
        )
    why = (
        f" ({short}; verification.cost sets this bound, and so few leave the intervals wide)" if chosen < wanted else ""
    )
    text = (
        f"{chosen} of the {found['cells']} cases, drawn at random, were run again{why}; {found['at_rest']} of them lie below the "
        "thresholds of rocking and sliding and cannot change."
    )
    if any(len(_outcomes(found, kind)) > 1 for kind in KINDS):
        text += " Each element of the scene is counted by itself."
    return text + (" The variants were not run again." if variants else "")


def _outcomes(found: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return list(found[kind].get("outcomes", ()))


def _rows(found: dict[str, Any], kind: str) -> list[tuple[str, ...]]:
    """Rows of one repetition; its name and its work stand in the first."""
    name, part = _NAMES[kind].format(**found), found[kind]
    if "refused" in part:
        return [(name, f"not possible: {part['refused']}", *[""] * 7)]
    steps, own = part["block_steps"], found["study_block_steps"]
    outcomes = part["outcomes"]
    unanswered = max(outcome["unanswered"] for outcome in outcomes)
    work = (str(unanswered), f"{steps:.3g}", percent(steps / own) if own else "")
    rows: list[tuple[str, ...]] = []
    for outcome in outcomes:
        whose = f"{outcome['element']} " if outcome["element"] else ""
        for what, changed, compared in (
            ("falls or stands", outcome["flags"], outcome["cases"]),
            ("side, where it falls", outcome["sides"], outcome["fallen"]),
        ):
            low, high = wilson(changed, compared)
            known = (
                (percent(changed / compared, 2), f"{100 * low:.2f} to {percent(high, 2)}") if compared else ("–", "–")
            )
            more = ("", "", "") if rows else work
            rows.append(("" if rows else name, whose + what, str(changed), str(compared), *known, *more))
    return rows
