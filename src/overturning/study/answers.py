"""Whether two computations of the same cases answer alike: fallen or not, and to which side."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from overturning.model.variables import INT8_MISSING

ASIDE: Final = 15.0
"""Degrees between two azimuths of a fall in space from which they are not the same."""

Answers = NDArray[np.void]
"""Answers to cases, of which `unanswered` makes room for `overturned`, `azimuth` and `block_steps`."""


def unanswered(count: int, elements: int) -> Answers:
    """Room for answers: a flag for each element, the azimuth of a fall in space in degrees, else NaN, and the work."""
    answers = np.zeros(count, [("overturned", np.int8, (elements,)), ("azimuth", "f4"), ("block_steps", np.int64)])
    answers["azimuth"] = np.nan
    return answers


class Counts(BaseModel):
    """How far the answers to the same cases differ."""

    cases: int  # with an answer in both
    flags: int  # of these, that fall in one answer and stand in the other
    fallen: int  # that fall in both
    sides: int  # of these, that fall to the other side, in space `ASIDE` or more away
    unanswered: int  # without an answer in one or both

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(**{name: getattr(self, name) + getattr(other, name) for name in Counts.model_fields})


def compare(first: NDArray[np.int8], second: NDArray[np.int8], elsewhere: NDArray[np.bool_] | None = None) -> Counts:
    """Count how far two arrays of `overturned` differ: +1, −1, 0, or −128 where there is no answer.

    `elsewhere` says of each case in space whether its two falls go another way, which flags say in planes.
    """
    known = (first != INT8_MISSING) & (second != INT8_MISSING)
    fell, fell_too = first != 0, second != 0
    both = known & fell & fell_too
    other = first != second if elsewhere is None else (first != second) | elsewhere
    counted = {"cases": known, "flags": known & (fell != fell_too), "fallen": both, "sides": both & other}
    return Counts(**{name: int(mask.sum()) for name, mask in (counted | {"unanswered": ~known}).items()})


def elsewhere(first: Answers, second: Answers, aside_deg: float = ASIDE) -> NDArray[np.bool_]:
    """Which of the bodies in space that fall in both answers go so many degrees or more apart; in planes none."""
    both = ((first["overturned"] == 1) & (second["overturned"] == 1)).all(axis=1)
    turn = np.where(both, first["azimuth"], 0.0) - np.where(both, second["azimuth"], 0.0)
    return np.asarray(np.abs((turn + 180.0) % 360.0 - 180.0) >= aside_deg)


def differ(first: Answers, second: Answers) -> NDArray[np.bool_]:
    """Which cases have another answer, of any element; shape (n,)."""
    return (first["overturned"] != second["overturned"]).any(axis=1) | elsewhere(first, second)
