"""The variables of an outcome: names, types, fill values and meanings, the same in a simulation's dataset and in the cube."""

from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from overturning.dem.status import Status

INT8_MISSING: Final = -128
"""Fill value of int8 variables."""

INT16_MISSING: Final = -32768
"""Fill value of int16 variables."""

FLOAT32_MISSING: Final = np.float32(9.969209968386869e36)
"""Fill value of float32 variables: netCDF's own default."""


PER_ELEMENT: Final = ("overturned", "overturning_time", "peak_rotation", "peak_slip", "residual_slip")
"""Variables that have the dimension `element` where a scene has more than one free element."""


@dataclass(frozen=True)
class Variable:
    """One variable of the outcome.

    Attributes
    ----------
    name : str
        Its name in the cube.
    dtype : str
        Type in the file.
    attributes : dict
        CF attributes.
    """

    name: str
    dtype: str
    attributes: dict[str, Any] = field(default_factory=dict)

    @property
    def fill_value(self) -> Any:
        """What stands where nothing was found."""
        return {"i1": np.int8(INT8_MISSING), "i2": np.int16(INT16_MISSING)}.get(self.dtype, FLOAT32_MISSING)


VARIABLES: Final = (
    Variable(
        "overturned",
        "i1",
        {
            "long_name": "side to which the block falls",
            "units": "1",
            "flag_values": np.array([-1, 0, 1], dtype=np.int8),
            "flag_meanings": "falls_towards_azimuth_plus_180 stands falls_towards_azimuth",
            "comment": "missing where the outcome was not found; see status",
        },
    ),
    Variable(
        "status",
        "i1",
        {
            "long_name": "how the outcome was found",
            "units": "1",
            "flag_values": np.array([int(code) for code in Status], dtype=np.int8),
            "flag_meanings": " ".join(code.name.lower() for code in Status),
        },
    ),
    Variable(
        "mirrored",
        "i1",
        {
            "long_name": "cell is the mirror of the one at the opposite azimuth",
            "units": "1",
            "flag_values": np.array([0, 1], dtype=np.int8),
            "flag_meanings": "computed mirrored",
        },
    ),
    Variable(
        "overturning_time",
        "f4",
        {
            "long_name": "last time the rotation passed the critical angle before the block fell, after the start of the record",
            "units": "s",
        },
    ),
    Variable(
        "peak_rotation",
        "f4",
        {"long_name": "largest absolute rotation over the critical angle arctan(B/H)", "units": "1"},
    ),
    Variable("peak_slip", "f4", {"long_name": "largest slip of the midpoint of the block's base", "units": "m"}),
    Variable("residual_slip", "f4", {"long_name": "slip of the midpoint of the block's base at the end", "units": "m"}),
    Variable("peak_penetration", "f4", {"long_name": "largest penetration of any contact", "units": "m"}),
    Variable(
        "energy_error",
        "f4",
        {"long_name": "residual of work and energy over the larger of input and the energy to overturn", "units": "1"},
    ),
)
