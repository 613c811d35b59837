"""Outcomes of cases, in the order of the cases."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING, OutcomeVariable

CASE_COUNTER_NAMES = ("block_steps", "samples_left_out")
"""Counters of each case, next to the variables of its model."""


class CaseResults:
    """Outcomes of simulated cases: one array for each outcome variable, such as fall and peak rotation.

    Arrays have the names and types of the variables. For n cases, their shape is (n,), or (n, elements) for variables
    of each element if the scene has several free elements.
    Two counters are added: `block_steps`, computed time steps × free elements, and `samples_left_out`, samples that
    were skipped because the object is at rest. Missing values are NaN, or −128 in arrays of int8.
    """

    def __init__(self, **arrays: NDArray[Any]) -> None:
        vars(self).update(arrays)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> NDArray[Any]: ...

    @classmethod
    def of_unmoved_cases(
        cls, outcome_variables: tuple[OutcomeVariable, ...], case_count: int, free_element_count: int = 1
    ) -> Self:
        """Return the outcomes (no fall, no displacement) of cases whose base motion is too weak to move the object."""
        shape = (case_count, free_element_count) if free_element_count > 1 else (case_count,)
        arrays = {
            item.name: np.zeros(shape if item.has_element_dimension else case_count, item.dtype_in_file)
            for item in outcome_variables
        }
        for item in outcome_variables:
            if item.is_missing_for_standing_cases:
                arrays[item.name][:] = item.missing_value_in_memory
        arrays["status"][:] = CaseStatus.AT_REST
        return cls(**arrays, **{name: np.zeros(case_count, np.int64) for name in CASE_COUNTER_NAMES})

    def store_outcomes(
        self, case_indices: NDArray[np.int64], outcome_values_by_variable_name: Mapping[str, Any]
    ) -> None:
        """Store outcomes of some cases by variable name; overturning is missing for cases not simulated to the end."""
        status = np.asarray(outcome_values_by_variable_name["status"]).astype(np.int8)
        with np.errstate(invalid="ignore", over="ignore"):
            for name, values in outcome_values_by_variable_name.items():
                kept: NDArray[Any] = vars(self)[name]
                answered = (status == CaseStatus.SIMULATED).reshape(-1, *(1,) * (kept.ndim - 1))
                if name == "overturned":
                    values = np.where(answered, values, INT8_MISSING)
                if name == "overturning_time":
                    values = np.where(answered, values, np.nan)
                kept[case_indices] = values
