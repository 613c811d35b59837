"""What came of cases, in the order in which they were given."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING, VARIABLES


class Answers(NamedTuple):
    """What a kernel says of some cases, named as in `Results`, from `overturned` on of each free element."""

    status: FloatArray
    peak_penetration: FloatArray
    energy_error: FloatArray
    block_steps: FloatArray
    overturned: FloatArray
    overturning_time: FloatArray
    peak_rotation: FloatArray
    peak_slip: FloatArray
    residual_slip: FloatArray


@dataclass(frozen=True)
class Results:
    """What came of each case, named and typed like the cube's variables.

    Attributes
    ----------
    overturned : ndarray of int8, shape (n, free elements)
        +1 fallen towards the azimuth, −1 away from it, 0 standing where it stood, −128 where there is no answer.
    status : ndarray of int8, shape (n,)
        A `Status`.
    overturning_time : ndarray of float32, shape (n, free elements)
        s after the record's start, until which it could still have come back; NaN where the element does not fall.
    peak_rotation : ndarray of float32, shape (n, free elements)
        Largest abs(θ)/α; α is that of the element alone on what it stands on. In degrees where it has none of its own.
    peak_slip, residual_slip : ndarray of float32, shape (n, free elements)
        Of the midpoint of its base on what it stands on, m; the peak is a magnitude, the residual positive towards the
        azimuth.
    peak_penetration : ndarray of float32, shape (n,)
        Of any contact, m.
    energy_error : ndarray of float32, shape (n,)
        Residual of work and energy over the larger of input and the least energy to overturn an element.
    block_steps : ndarray of int64, shape (n,)
        Steps computed, times free elements.

    The results of one element (`element`, and those of `run_cases`) have the shape (n,) throughout.
    """

    overturned: NDArray[np.int8]
    status: NDArray[np.int8]
    overturning_time: NDArray[np.float32]
    peak_rotation: NDArray[np.float32]
    peak_slip: NDArray[np.float32]
    residual_slip: NDArray[np.float32]
    peak_penetration: NDArray[np.float32]
    energy_error: NDArray[np.float32]
    block_steps: NDArray[np.int64]

    @classmethod
    def at_rest(cls, count: int, elements: int) -> Self:
        """Results of cases none of which moves."""
        arrays = {
            variable.name: np.zeros((count, elements) if variable.per_element else count, variable.dtype)
            for variable in VARIABLES
            if variable.name != "mirrored"
        }
        arrays["status"][:], arrays["overturning_time"][:] = Status.AT_REST, np.nan
        return cls(**arrays, block_steps=np.zeros(count, np.int64))

    def store(self, chosen: NDArray[np.int64], answers: Answers) -> None:
        """Put in what the kernel found for the chosen cases."""
        status = answers.status.astype(np.int8)
        with np.errstate(invalid="ignore", over="ignore"):
            answered = (status == Status.SIMULATED)[:, None]
            values = answers._asdict() | {
                "status": status,
                "overturned": np.where(answered, answers.overturned, INT8_MISSING),
                "overturning_time": np.where(answered, answers.overturning_time, np.nan),
            }
            for name, column in values.items():
                getattr(self, name)[chosen] = column

    def element(self, index: int) -> Self:
        """The results of one free element."""
        return type(self)(
            **{name: values[:, index] if values.ndim > 1 else values for name, values in vars(self).items()}
        )
