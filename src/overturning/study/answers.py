"""Compare the outcomes of two computations of the same cases: fallen or not, and to which side."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from overturning.model.variables import INT8_MISSING
from overturning.motion.direction import angle_between_azimuths

MIN_COUNTED_FALL_AZIMUTH_DIFFERENCE_DEG: Final = 15.0
"""Smallest difference of the azimuths of two 3-D falls that counts as a change of direction, degrees."""

CaseOutcomeArray = NDArray[np.void]
"""Structured array of outcomes: fields `overturned`, `azimuth`, `block_steps`; see `create_outcome_array_to_fill`."""


def create_outcome_array_to_fill(case_count: int, element_count: int) -> CaseOutcomeArray:
    """Create an array of outcomes to be filled: fall flags 0 and azimuths NaN of each element, time steps 0."""
    answers = np.zeros(
        case_count,
        [("overturned", np.int8, (element_count,)), ("azimuth", "f4", (element_count,)), ("block_steps", np.int64)],
    )
    answers["azimuth"] = np.nan
    return answers


class OutcomeDifferenceCountsOfTwoComputations(BaseModel):
    """Numbers of cases compared between two computations, and of those with different outcomes."""

    cases: int  # with an outcome in both
    flags: int  # of these, fall in one computation and stand in the other
    fallen: int  # with a fall in both
    sides: int  # of these, to the other side (3-D: azimuths differ by `MIN_COUNTED_FALL_AZIMUTH_DIFFERENCE_DEG`)
    unanswered: int  # without an outcome in one or both

    def __add__(self, other: "OutcomeDifferenceCountsOfTwoComputations") -> "OutcomeDifferenceCountsOfTwoComputations":
        return OutcomeDifferenceCountsOfTwoComputations(
            **{
                name: getattr(self, name) + getattr(other, name)
                for name in OutcomeDifferenceCountsOfTwoComputations.model_fields
            }
        )


def count_outcome_differences(
    first_fall_flags: NDArray[np.int8],
    second_fall_flags: NDArray[np.int8],
    fall_azimuth_differs_mask: NDArray[np.bool_] | None = None,
) -> OutcomeDifferenceCountsOfTwoComputations:
    """Count the cases in which two arrays of fall flags differ: 1 or −1 (fallen), 0 (stands), −128 (no outcome).

    `fall_azimuth_differs_mask` is True for 3-D cases that fall twice but in different directions; in 2-D models the
    sign of the flag shows the direction.
    """
    known = (first_fall_flags != INT8_MISSING) & (second_fall_flags != INT8_MISSING)
    fell, fell_too = first_fall_flags != 0, second_fall_flags != 0
    both = known & fell & fell_too
    other = (
        first_fall_flags != second_fall_flags
        if fall_azimuth_differs_mask is None
        else (first_fall_flags != second_fall_flags) | fall_azimuth_differs_mask
    )
    counted = {"cases": known, "flags": known & (fell != fell_too), "fallen": both, "sides": both & other}
    return OutcomeDifferenceCountsOfTwoComputations(
        **{name: int(mask.sum()) for name, mask in (counted | {"unanswered": ~known}).items()}
    )


def fall_azimuths_differ(
    first_outcomes: CaseOutcomeArray,
    second_outcomes: CaseOutcomeArray,
    min_azimuth_difference_deg: float = MIN_COUNTED_FALL_AZIMUTH_DIFFERENCE_DEG,
) -> NDArray[np.bool_]:
    """True where an element falls in both of two 3-D computations, but to azimuths at least a given angle apart.

    The shape is (n, elements).
    """
    both = (first_outcomes["overturned"] == 1) & (second_outcomes["overturned"] == 1)
    first, second = (np.where(both, one["azimuth"], 0.0) for one in (first_outcomes, second_outcomes))
    return np.asarray(angle_between_azimuths(first, second) >= min_azimuth_difference_deg)


def mask_of_cases_with_different_falls(
    first_outcomes: CaseOutcomeArray, second_outcomes: CaseOutcomeArray
) -> NDArray[np.bool_]:
    """True for cases in which two computations differ in whether or where any element falls; shape (cases,)."""
    flags_differ = first_outcomes["overturned"] != second_outcomes["overturned"]
    return np.asarray((flags_differ | fall_azimuths_differ(first_outcomes, second_outcomes)).any(axis=1))
