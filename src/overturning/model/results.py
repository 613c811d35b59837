"""Outcomes of cases, in the order of the cases."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING, Variable

COUNTS = ("block_steps", "samples_left_out")
"""Counters of each case, next to the variables of its model."""


class Results:
    """Outcomes of cases: arrays named and typed like the variables of their model.

    Arrays have the shape (n,), or (n, elements) for variables of each element if the scene has several free elements.
    Two counters are added: `block_steps`, computed steps × free elements, and `samples_left_out`, samples of rest
    that were skipped. Missing values are −128 and NaN.
    """

    def __init__(self, **arrays: NDArray[Any]) -> None:
        vars(self).update(arrays)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> NDArray[Any]: ...

    @classmethod
    def at_rest(cls, variables: tuple[Variable, ...], count: int, elements: int = 1) -> Self:
        """Return results of cases that stay at rest."""
        shape = (count, elements) if elements > 1 else (count,)
        arrays = {item.name: np.zeros(shape if item.per_element else count, item.dtype) for item in variables}
        for item in variables:
            if item.of_falls:
                arrays[item.name][:] = item.missing
        arrays["status"][:] = Status.AT_REST
        return cls(**arrays, **{name: np.zeros(count, np.int64) for name in COUNTS})

    def store(self, chosen: NDArray[np.int64], answers: Mapping[str, Any]) -> None:
        """Store the outcomes of chosen cases, by name; flags and times of cases without an outcome become missing."""
        status = np.asarray(answers["status"]).astype(np.int8)
        with np.errstate(invalid="ignore", over="ignore"):
            for name, values in answers.items():
                kept: NDArray[Any] = vars(self)[name]
                answered = (status == Status.SIMULATED).reshape(-1, *(1,) * (kept.ndim - 1))
                if name == "overturned":
                    values = np.where(answered, values, INT8_MISSING)
                if name == "overturning_time":
                    values = np.where(answered, values, np.nan)
                kept[chosen] = values
