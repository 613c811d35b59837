"""What goes into the general kernel and what comes out of it: named columns."""

from typing import Final

import numpy as np

from overturning.dem.kernel.clock import Clock

CASE: Final = np.dtype([(name, "f8") for name in (
    "amplitude", "friction", "damping", "first", "calm", "after", *Clock._fields,
)])  # fmt: skip
"""What a case is computed with: factor on the motion, swept friction, factor on the dashpots, samples from which it is computed, at
which it can rest for good, and at which it is undecided; the clock."""

ELEMENT: Final = np.dtype([(name, "f8") for name in (
    "is_free", "fall_angle", "tips_back", "tips_on", "support", "barrier",
)])  # fmt: skip
"""Of an element whether it is free, angle at which it has fallen for good, angles from which it cannot come back towards −x and +x
(rad), what it stands on, and the energy that its overturning takes (J)."""

LIMITS: Final = np.dtype([(name, "f8") for name in ("deepest", "rest_energy", "least_barrier", "least_scale")])
"""Of a scene its deepest penetration (m), kinetic energy at rest, least barrier, and least energy that an error is a share of (J)."""

RESULT: Final = np.dtype([(name, "f8") for name in ("status", "depth", "energy", "steps")])
"""Result of a case; `steps` are those of its free elements together."""

ELEMENT_RESULT: Final = np.dtype([(name, "f8") for name in ("side", "time", "angle", "slip", "residual")])
"""Result of an element."""

# A trajectory's columns: time and ground acceleration, then six for each element,
(T_TIME, T_GROUND) = range(2)
(T_X, T_Z, T_ANGLE, T_VX, T_VZ, T_VW) = range(6)
# and, where forces are asked for, five for both ends of each pair: mean force on its first element from this sample to the
# next, mean normal force, and that times the place.
(T_FX, T_FZ, T_LOAD, T_LOAD_X, T_LOAD_Z) = range(5)
FORCE_COLUMNS: Final = 5
