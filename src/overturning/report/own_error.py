"""What the report says of its own error: a part of the study, run again more exactly."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from overturning.study.comparison import wilson
from overturning.study.config import Study
from overturning.study.own_error import KINDS, WARN_ABOVE, is_verified
from overturning.study.own_error_file import read_verification

_NAMES: Final = {"finer": "steps {finer_by} times finer", "stiffer": "springs {stiffer_by:g} times stiffer"}


@dataclass(frozen=True)
class Repetition:
    """One row of the report's table.

    Attributes
    ----------
    name : str
        What was changed.
    refused : str
        Why it could not be computed; empty where it could.
    rows : tuple of (str, int, int, float, float, float)
        What may change, changed, compared, share and its 95 % interval.
    unanswered : int
        Cases without an answer in the study or in the repetition.
    block_steps : int
        Work.
    cost : float
        Work over that of the study.
    warns : bool
        Whether more flags changed than the report accepts silently.
    """

    name: str
    refused: str = ""
    rows: tuple[tuple[str, int, int, float, float, float], ...] = ()
    unanswered: int = 0
    block_steps: int = 0
    cost: float = float("nan")
    warns: bool = False


def own_error(study: Study, results: Path) -> dict[str, Any] | None:
    """What the template shows, or None where the study leaves the verification out.

    Parameters
    ----------
    study : Study
        The study.
    results : Path
        Folder of its results.

    Raises
    ------
    ResultError
        If the outcome is missing.
    """
    if not is_verified(study):
        return None
    found = read_verification(results / "verification.json")
    repetitions = [_repetition(found, kind) for kind in KINDS]
    return {
        "text": _text(found, len(study.variants)),
        "seed": found["seed"],
        "warn_above": WARN_ABOVE,
        "repetitions": repetitions,
        "warns": [row.name for row in repetitions if row.warns],
        "study_block_steps": found["study_block_steps"],
    }


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
    if len(_outcomes(found)) > 1:
        text += " Each element of the scene is counted by itself."
    if variants:
        text += " The variants were not run again."
    return text


def _outcomes(found: dict[str, Any]) -> list[dict[str, Any]]:
    return next((found[kind]["outcomes"] for kind in KINDS if "outcomes" in found[kind]), [])


def _repetition(found: dict[str, Any], kind: str) -> Repetition:
    name, part = _NAMES[kind].format(**found), found[kind]
    if "refused" in part:
        return Repetition(name, part["refused"])
    rows = []
    for outcome in part["outcomes"]:
        whose = f"{outcome['element']} " if outcome["element"] else ""
        for what, changed, compared in (
            (f"{whose}falls or stands", outcome["flags"], outcome["cases"]),
            (f"{whose}side, where it falls", outcome["sides"], outcome["fallen"]),
        ):
            share = changed / compared if compared else float("nan")
            rows.append((what, changed, compared, share, *wilson(changed, compared)))
    return Repetition(
        name,
        rows=tuple(rows),
        unanswered=max(outcome["unanswered"] for outcome in part["outcomes"]),
        block_steps=part["block_steps"],
        cost=part["block_steps"] / found["study_block_steps"] if found["study_block_steps"] else float("nan"),
        warns=any(outcome["flags"] > WARN_ABOVE * outcome["cases"] for outcome in part["outcomes"]),
    )
