"""Outcome variables: names, types, fill values and meanings, in a simulation's dataset and in the cube.

Code that writes, mirrors, gathers or compares outcomes uses tables like `PLANAR_OUTCOME_VARIABLES`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.model.status import CaseStatus

INT8_MISSING: Final = -128
"""Fill value of int8 variables."""

MAX_FACE_COUNT_OF_BODY_WITH_NUMBERED_FACES: Final = 127
"""Largest number of sides of a body whose sides are numbered in an outcome (int8); a scan may have more facets."""

INT16_MISSING: Final = -32768
"""Fill value of int16 variables."""

FLOAT32_MISSING: Final = np.float32(9.969209968386869e36)
"""Fill value of float32 variables: netCDF's own default."""


def mask_of_known_outcomes(stored_or_decoded_overturning_flag: Any) -> Any:
    """Return a mask that is True where an overturning flag, as stored or decoded, is not missing."""
    return np.abs(stored_or_decoded_overturning_flag.astype("float32")) <= 1


@dataclass(frozen=True)
class OutcomeVariable:
    """Outcome variable of a simulation: name, data type, units, and behaviour under mirroring of the case."""

    name: str  # in the cube
    dtype_in_file: str  # in the file
    long_name: str
    units: str = "1"
    has_element_dimension: bool = False  # has the dimension `element` if a scene has several free elements
    is_missing_for_standing_cases: bool = False  # missing for cases that stand
    is_odd_under_mirroring: bool = False  # changes sign if the plane is seen from behind, from φ + 180°
    mirror_counterpart_name: str = ""  # variable that replaces it if the plane is seen from behind
    further_cf_attributes: Mapping[str, Any] = field(default_factory=dict)  # further CF attributes

    @property
    def fill_value_in_file(self) -> Any:
        """Fill value of the variable: the value in a file for a missing outcome."""
        return {"i1": np.int8(INT8_MISSING), "i2": np.int16(INT16_MISSING)}.get(self.dtype_in_file, FLOAT32_MISSING)

    @property
    def missing_value_in_memory(self) -> Any:
        """Value of a missing outcome in memory: NaN for floats, the fill value of the file for integers."""
        return np.nan if self.dtype_in_file[0] == "f" else self.fill_value_in_file

    @property
    def cf_attributes(self) -> dict[str, Any]:
        """CF attributes of the variable, by name: long name, units and further ones."""
        return {"long_name": self.long_name, "units": self.units, **self.further_cf_attributes}

    def values_mirrored_to_opposite_azimuth(
        self, outcome_arrays: Mapping[str, NDArray[Any]], case_index_or_mask: Any = ...
    ) -> NDArray[Any]:
        """Return this variable's values at azimuth φ + 180°, mirrored from a symmetric scene's outcomes at φ."""
        values = np.asarray(outcome_arrays[self.mirror_counterpart_name or self.name][case_index_or_mask])
        # 0 stays 0 and not −0, so that equal cubes are equal bytes.
        return (
            np.where((values == 0) | (values == self.fill_value_in_file), values, -values)
            if self.is_odd_under_mirroring
            else values
        )

    def decode(self, stored_values: Any) -> NDArray[Any]:
        """Convert values as stored in a file to xarray's decoded form: integers become float32, NaN if missing."""
        array = np.asarray(stored_values)
        if array.dtype.kind == "f":
            return array
        return np.where(array == self.fill_value_in_file, np.float32(np.nan), array.astype(np.float32))

    def encode(self, decoded_values: Any) -> NDArray[Any]:
        """Convert values to the form stored in a file: its data type, and the fill value in place of NaN."""
        array = np.asarray(decoded_values)
        if array.dtype.kind == "f":
            array = np.where(np.isnan(array), self.fill_value_in_file, array)
        return array.astype(self.dtype_in_file)


_STATUS_VARIABLE: Final = OutcomeVariable(
    "status", "i1", "how the outcome was found", further_cf_attributes={
        "flag_values": np.array([int(code) for code in CaseStatus], dtype=np.int8),
        "flag_meanings": " ".join(code.name.lower() for code in CaseStatus),
    },
)  # fmt: skip
_PEAK_PENETRATION_VARIABLE: Final = OutcomeVariable("peak_penetration", "f4", "largest penetration of any contact", "m")
_ENERGY_ERROR_VARIABLE: Final = OutcomeVariable(
    "energy_error", "f4", "residual of work and energy over the larger of input and the energy to overturn"
)
_COUNT_OF_MEMBERS_WITH_OUTCOME_VARIABLE: Final = OutcomeVariable("members", "i2", "ensemble members with an outcome")

PLANAR_OUTCOME_VARIABLES: Final = (
    OutcomeVariable("overturned", "i1", "side to which the block falls", "1", True, is_odd_under_mirroring=True,
    further_cf_attributes={
        "flag_values": np.array([-1, 0, 1], dtype=np.int8),
        "flag_meanings": "falls_towards_azimuth_plus_180 stands falls_towards_azimuth",
        "comment": "missing where the outcome was not found; see status",
    }),
    _STATUS_VARIABLE,
    OutcomeVariable("mirrored", "i1", "cell is the mirror of the one at the opposite azimuth", further_cf_attributes={
        "flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "computed mirrored",
    }),
    OutcomeVariable(
        "overturning_time", "f4",
        "last time at which what fell could still have come back, after the start of the record",
        "s", True, is_missing_for_standing_cases=True,
    ),
    OutcomeVariable(
        "peak_rotation", "f4", "largest absolute rotation over the critical angle", "1", True, further_cf_attributes={
            "comment": "in degrees of an element without a critical angle of its own; see critical_angle",
        },
    ),
    OutcomeVariable("peak_slip", "f4", "largest slip of the midpoint of the block's base", "m", True),
    OutcomeVariable("residual_slip", "f4", "slip of the midpoint of the block's base at the end", "m", True,
    is_odd_under_mirroring=True),
    _PEAK_PENETRATION_VARIABLE,
    _ENERGY_ERROR_VARIABLE,
)  # fmt: skip
"""Outcome variables of planar models."""

BODY_OUTCOME_VARIABLES: Final = (
    OutcomeVariable("overturned", "i1", "whether the block falls", further_cf_attributes={
        "flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "stands falls",
        "comment": "missing where the outcome was not found; see status",
    }),
    _STATUS_VARIABLE,
    OutcomeVariable(
        "fall_azimuth", "f4", "azimuth to which the top goes when the block has fallen, clockwise from north", "degree",
        is_missing_for_standing_cases=True,
    ),
    OutcomeVariable(
        "fall_face", "i1",
        "side that points most nearly down when the block has fallen, "
        "counted clockwise from the one that faces the orientation",
        is_missing_for_standing_cases=True,
        further_cf_attributes={"comment": "missing where the block stands or has no sides"},
    ),
    OutcomeVariable("peak_tilt", "f4", "largest angle between the block's axis and the vertical", "degree"),
    OutcomeVariable(
        "overturning_time", "f4",
        "last time the tilt passed the least critical angle before the block fell, after the start of the record", "s",
        is_missing_for_standing_cases=True,
    ),
    OutcomeVariable(
        "peak_slip", "f4", "largest horizontal displacement of the point of the base below the centre", "m"
    ),
    OutcomeVariable("residual_slip_north", "f4", "northward displacement of that point at the end", "m"),
    OutcomeVariable("residual_slip_east", "f4", "eastward displacement of that point at the end", "m"),
    OutcomeVariable(
        "residual_twist", "f4", "rotation about the vertical at the end, clockwise from above", "degree",
        further_cf_attributes={"comment": "missing where the block falls"},
    ),
    _PEAK_PENETRATION_VARIABLE,
    _ENERGY_ERROR_VARIABLE,
    OutcomeVariable(
        "angular_momentum_error", "f4",
        "residual of vertical angular momentum about the initial place and of moments, over m sqrt(g R^3)",
    ),
    OutcomeVariable("repeated", "i1", "cell is the same case as one at a smaller orientation", further_cf_attributes={
        "flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "computed repeated",
    }),
)  # fmt: skip
"""Outcome variables of a 3-D body."""

_PLANE_ENSEMBLE_ATTRIBUTES: Final = {
    "comment": "spread over the neighbourhood stated in the study; missing where the ensemble was not run"
}

PLANE_ENSEMBLE_VARIABLES: Final = (
    *(
        OutcomeVariable(
            f"probability_{side}", "f4", f"share of ensemble members that fall towards {where}", "1", True,
            mirror_counterpart_name=f"probability_{other}", further_cf_attributes=_PLANE_ENSEMBLE_ATTRIBUTES,
        )
        for side, other, where in (
            ("towards", "away", "the azimuth"), ("away", "towards", "the azimuth plus 180 degrees"),
        )
    ),
    *(
        OutcomeVariable(
            f"scramble_difference_{side}", "f4", f"probability_{side} of the first scramble minus that of the second",
            "1", True, mirror_counterpart_name=f"scramble_difference_{other}",
        )
        for side, other in (("towards", "away"), ("away", "towards"))
    ),
    _COUNT_OF_MEMBERS_WITH_OUTCOME_VARIABLE,
)  # fmt: skip
"""Ensemble variables of planar models."""

OUTCOME_VARIABLES_OF_2D_RUNS_IN_FACE_PLANES: Final = (
    OutcomeVariable(
        "plane_overturned", "i1", "whether the block falls in the vertical plane of either pair of faces",
        further_cf_attributes={"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "stands falls"},
    ),
    OutcomeVariable(
        "plane_fall_azimuth", "f4",
        "azimuth to which it falls in that plane, of two the one that passes no return first", "degree",
    ),
)  # fmt: skip
"""Variables of the 2-D prediction in the vertical planes of a rectangle's faces; see `overturning.dem.faces`."""

_CF_ATTRIBUTES_OF_3D_ENSEMBLE_VARIABLES: Final = {
    "comment": "over the neighbourhood stated in the study; missing where the ensemble was not run"
}

BODY_ENSEMBLE_VARIABLES: Final = (
    OutcomeVariable("probability_falls", "f4", "share of ensemble members that fall",
    further_cf_attributes=_CF_ATTRIBUTES_OF_3D_ENSEMBLE_VARIABLES),
    *(
        OutcomeVariable(
            name, "f4", f"mean over members of the {what} of the fall, 0 where it stands",
            further_cf_attributes=_CF_ATTRIBUTES_OF_3D_ENSEMBLE_VARIABLES
        )
        for name, what in (
            ("fall_north", "northward component of the direction"),
            ("fall_east", "eastward component of the direction"),
            ("fall_axis_cosine", "cosine of twice the azimuth"), ("fall_axis_sine", "sine of twice the azimuth"),
        )
    ),
    OutcomeVariable("scramble_difference", "f4", "probability_falls of the first scramble minus that of the second"),
    _COUNT_OF_MEMBERS_WITH_OUTCOME_VARIABLE,
)  # fmt: skip
"""Ensemble variables of a 3-D body."""

RELIEF_ENSEMBLE_VARIABLES: Final = tuple(
    OutcomeVariable(
        f"probability_falls_{half}_relief",
        "f4",
        f"share of ensemble members that fall among those with the {half}er half of the reliefs",
        further_cf_attributes=_CF_ATTRIBUTES_OF_3D_ENSEMBLE_VARIABLES,
    )
    for half in ("low", "high")
)
"""Further ensemble variables of a scanned stone whose members differ in relief."""
