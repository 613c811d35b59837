"""Shares of cases that change when part of a study is computed again."""

import math

from overturning.findings.values import Finding, Number
from overturning.study.convergence import Convergence, ElementChanges
from overturning.study.ensemble import wilson_interval


class ChangedCases(Finding):
    """Cases that change in a second computation, with the interval of a random sample (Wilson)."""

    count: int
    """Number of cases that change."""
    compared: int
    """Number of cases that are compared."""
    value: Number
    """Share of the compared cases that change; None if none is compared."""
    low: Number
    """Lower end of the 95 % interval; None if all cases of the study are compared."""
    high: Number


class SecondComputation(Finding):
    """Comparison of a study with a second computation of part of its cases."""

    computation: str
    """"finer" (shorter steps), "stiffer" (stiffer contact), or "rigid" (exact rigid block without sliding)."""
    factor: Number
    """Factor on the number of steps or on the stiffness; None for the rigid block."""
    element: str
    """Element that is compared; empty for a single block."""
    refused: str
    """Reason why the computation was not possible; otherwise empty."""
    falls_or_stands: ChangedCases
    """Cases that fall in one computation and stand in the other."""
    falls_or_stands_undivided: ChangedCases
    """Share of `falls_or_stands` among the cases whose ensemble agrees whether the block falls."""
    side: ChangedCases
    """Cases that fall in both computations, but to different sides (in 3-D: 30° or more apart)."""
    side_agreed: ChangedCases
    """Share of `side` among the cases whose ensemble falls to one side only."""


def share_of_changed_cases(count: int, compared: int, sampled: bool) -> ChangedCases:
    """Return the share of changed cases, with an interval if the cases are a random sample."""
    low, high = map(float, wilson_interval(count, compared)) if sampled and compared else (math.nan, math.nan)
    share = count / compared if compared else math.nan
    return ChangedCases(count=count, compared=compared, value=share, low=low, high=high)


def second_computations(found: Convergence) -> list[SecondComputation]:
    """Return the comparisons of a study with its second computations."""
    rows = []
    for name, factor, part in (
        ("finer", found.finer_by, found.finer), ("stiffer", found.stiffer_by, found.stiffer)
    ):  # fmt: skip
        sampled = found.chosen < found.computed
        rows += [_compared(name, factor, one, sampled) for one in part.outcomes]
        if not part.outcomes:
            none = share_of_changed_cases(0, 0, sampled)
            rows.append(
                SecondComputation(
                    computation=name, factor=factor, element="", refused=part.refused, falls_or_stands=none,
                    falls_or_stands_undivided=none, side=none, side_agreed=none,
                )
            )  # fmt: skip
    rigid = found.rigid
    if rigid is not None and rigid.cases:
        rows.append(_compared("rigid", math.nan, rigid, rigid.cases + rigid.unanswered < rigid.cells))
    return rows


def _compared(name: str, factor: float, one: ElementChanges, sampled: bool) -> SecondComputation:
    return SecondComputation(
        computation=name,
        factor=factor,
        element=one.element,
        refused="",
        falls_or_stands=share_of_changed_cases(one.flags, one.cases, sampled),
        falls_or_stands_undivided=share_of_changed_cases(one.flags_undivided, one.undivided, sampled),
        side=share_of_changed_cases(one.sides, one.fallen, sampled),
        side_agreed=share_of_changed_cases(one.sides_agreed, one.fallen_agreed, sampled),
    )
