"""Compare the outcomes of two computations of the same cases: fallen or not, and to which side."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from overturning.model.variables import INT8_MISSING

MAX_AZIMUTH_DIFFERENCE_DEG: Final = 15.0
"""Smallest difference of the azimuths of two 3-D falls that counts as a change of direction, degrees."""

CaseOutcomes = NDArray[np.void]
"""Structured array of outcomes with the fields `overturned`, `azimuth` and `block_steps`; see `empty_outcomes`."""


def empty_outcomes(count: int, elements: int) -> CaseOutcomes:
    """Create an array of outcomes: flag of each element, azimuth of a 3-D fall, degrees (otherwise NaN), steps."""
    answers = np.zeros(count, [("overturned", np.int8, (elements,)), ("azimuth", "f4"), ("block_steps", np.int64)])
    answers["azimuth"] = np.nan
    return answers


class Counts(BaseModel):
    """Counts of cases whose outcomes in two computations differ."""

    cases: int  # with an outcome in both
    flags: int  # of these, fall in one computation and stand in the other
    fallen: int  # with a fall in both
    sides: int  # of these, to the other side, or azimuths differ by `MAX_AZIMUTH_DIFFERENCE_DEG` or more (3-D)
    unanswered: int  # without an outcome in one or both

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(**{name: getattr(self, name) + getattr(other, name) for name in Counts.model_fields})


def compare(first: NDArray[np.int8], second: NDArray[np.int8], elsewhere: NDArray[np.bool_] | None = None) -> Counts:
    """Count the differences between two arrays of `overturned`: +1, −1, 0, or −128 without an outcome.

    `elsewhere` is True for 3-D cases whose two falls have different directions; in planar models the flags show it.
    """
    known = (first != INT8_MISSING) & (second != INT8_MISSING)
    fell, fell_too = first != 0, second != 0
    both = known & fell & fell_too
    other = first != second if elsewhere is None else (first != second) | elsewhere
    counted = {"cases": known, "flags": known & (fell != fell_too), "fallen": both, "sides": both & other}
    return Counts(**{name: int(mask.sum()) for name, mask in (counted | {"unanswered": ~known}).items()})


def azimuths_differ(
    first: CaseOutcomes, second: CaseOutcomes, aside_deg: float = MAX_AZIMUTH_DIFFERENCE_DEG
) -> NDArray[np.bool_]:
    """True for 3-D cases that fall in both, with azimuths at least `aside_deg` apart; False for planar models."""
    both = ((first["overturned"] == 1) & (second["overturned"] == 1)).all(axis=1)
    turn = np.where(both, first["azimuth"], 0.0) - np.where(both, second["azimuth"], 0.0)
    return np.asarray(np.abs((turn + 180.0) % 360.0 - 180.0) >= aside_deg)


def outcomes_differ(first: CaseOutcomes, second: CaseOutcomes) -> NDArray[np.bool_]:
    """True for cases in which the outcome of any element differs; shape (n,)."""
    return (first["overturned"] != second["overturned"]).any(axis=1) | azimuths_differ(first, second)
