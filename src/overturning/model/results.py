"""What came of cases, in the order in which they were given."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING, Variable

COUNTS = ("block_steps", "samples_left_out")
"""What is counted of each case beside its model's variables."""


class Results:
    """What came of each case: arrays named and typed like the variables of its model.

    Each has the shape (n,), or (n, elements) where it is each element's and the scene has more than one free element.
    Beside the variables `block_steps`: steps computed, times free elements, and `samples_left_out`, for which a case at
    rest was not followed. Missing are −128 and NaN.
    """

    def __init__(self, **arrays: NDArray[Any]) -> None:
        vars(self).update(arrays)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> NDArray[Any]: ...

    @classmethod
    def at_rest(cls, variables: tuple[Variable, ...], count: int, elements: int = 1) -> Self:
        """Results of cases none of which moves."""
        shape = (count, elements) if elements > 1 else (count,)
        arrays = {item.name: np.zeros(shape if item.per_element else count, item.dtype) for item in variables}
        for item in variables:
            if item.of_falls:
                arrays[item.name][:] = item.missing
        arrays["status"][:] = Status.AT_REST
        return cls(**arrays, **{name: np.zeros(count, np.int64) for name in COUNTS})

    def store(self, chosen: NDArray[np.int64], answers: Mapping[str, Any]) -> None:
        """Put in what a kernel found for chosen cases, by name; times and flags without an answer are missing."""
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
