"""Types of arrays that the whole package uses."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
"""Array of numbers in double precision, of any shape."""
