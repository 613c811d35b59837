"""Limits beyond which a case has no valid outcome."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

MAX_PENETRATION_TO_HALF_SIDE_RATIO: Final = 0.2
"""Largest penetration for which the contact law holds, as a share of half the smaller side."""

MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD: Final = 20.0
"""Time after the record, in 1/p, after which a block that may still fall is undecided."""


def static_penetration_exceeds_limit(
    static_penetration_m: FloatArray, smaller_side_of_element_m: FloatArray | float
) -> NDArray[np.bool_]:
    """True for each static penetration above a tenth of the element's smaller side: such a case has no outcome.

    Parameters
    ----------
    static_penetration_m : ndarray
        Static penetration, m.
    smaller_side_of_element_m : ndarray or float
        Smaller side of the resting element, m.
    """
    return ~(static_penetration_m <= MAX_PENETRATION_TO_HALF_SIDE_RATIO * 0.5 * np.asarray(smaller_side_of_element_m))
