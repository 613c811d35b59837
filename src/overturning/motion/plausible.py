"""Whether accelerations can be those of an earthquake, or their unit is another than the one they were given in."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.motion.integration import integrate
from overturning.units import CM, STANDARD_GRAVITY, UNITS

LARGEST_PGA: Final = 5.0 * STANDARD_GRAVITY
"""Above the largest ever recorded, 4.1 g (vector sum, Iwate-Miyagi 2008, IWTH25), m/s²."""

LARGEST_PGV: Final = 1000.0 * CM
"""Three times the largest ever recorded, about 3 m/s (Chi-Chi 1999, TCU068), m/s."""

SMALLEST_PGA: Final = 1e-4 * STANDARD_GRAVITY
"""A tenth of a Gal: felt by nobody, m/s²."""

_LIKELY: Final = (0.005 * STANDARD_GRAVITY, 2.0 * STANDARD_GRAVITY)


def implausible(components: Sequence[FloatArray], sampling_interval: float, *, unit: str = "", pgv: bool = True) -> str:
    """What speaks against the size of a motion, and the unit that would make it plausible; empty where nothing does.

    Parameters
    ----------
    components : sequence of array, shape (n,)
        Accelerations, m/s².
    sampling_interval : float
        s.
    unit : str
        The unit that the numbers were declared in, of `units.UNITS`; empty: the file's own.
    pgv : bool
        Whether to look at the velocity too; not where an offset has not been taken away yet.

    Notes
    -----
    A motion that is exactly zero is rest in every unit, and passes.
    """
    peak = max(float(np.abs(samples).max()) for samples in components)
    velocity = 0.0
    if pgv:
        velocity = max(float(np.abs(integrate(samples, sampling_interval)).max()) for samples in components)
    if peak > LARGEST_PGA:
        what, bound = f"peak acceleration {peak / STANDARD_GRAVITY:.3g} g", "at most 5 g"
    elif 0.0 < peak < SMALLEST_PGA:
        what, bound = f"peak acceleration {peak / STANDARD_GRAVITY:.3g} g", "at least 0.0001 g"
    elif velocity > LARGEST_PGV:
        what, bound = f"peak velocity {velocity / CM:.4g} cm/s", "at most 1000 cm/s"
    else:
        return ""
    return f"{what} ({bound} is taken for ground motion); {_other_unit(peak, unit)}"


def _other_unit(peak: float, unit: str) -> str:
    """The units in which the same numbers would be a likely ground motion."""
    if not unit:
        return "the file's unit is not what it says, or an offset or a spike is in it"
    scale = UNITS[unit]
    names = {"gal": "Gal", "g": "g", "m/s2": "m/s²", "mg": "mg", "mm/s2": "mm/s²"}
    likely = [
        f"{shown} ({peak / scale * UNITS[name] / STANDARD_GRAVITY:.2g} g)"
        for name, shown in names.items()
        if UNITS[name] != scale and _LIKELY[0] <= peak / scale * UNITS[name] <= _LIKELY[1]
    ]
    name = names.get(unit, unit)
    return f"numbers declared in {name} look like {' or '.join(likely)}" if likely else f"{name} is not their unit"
