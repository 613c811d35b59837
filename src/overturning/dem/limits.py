"""Beyond what a case has no answer."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

DEEPEST: Final = 0.2
"""Penetration, in half the smaller side, beyond which the contact law no longer holds."""

AFTERMATH: Final = 20.0
"""Time after the record, in 1/p, at which a block that may still fall is undecided."""


def sinks_too_far(sunk: FloatArray, size: FloatArray | float) -> NDArray[np.bool_]:
    """Whether a weight at rest presses a contact in beyond what its law holds for, so that a case has no answer.

    `sunk` is the static penetration, m, `size` the smaller side of what rests, m.
    """
    return ~(sunk <= DEEPEST * 0.5 * np.asarray(size))
