"""A body in space: it faces an orientation, moves with all components of the motion, and falls towards any azimuth."""

from typing import ClassVar, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.model import Model, Outcomes, picked
from overturning.model.symmetry import nearest

SQUARE_PERIOD: Final = 90.0
"""Turn after which a stone of square footprint looks the same, degrees."""

OF_ONE_MIND: Final = float(np.cos(np.radians(15.0)))
"""Mean resultant of directions that lie 15° to either side of their mean."""

_MEMBERS: Final = {
    "falls": "probability_falls",
    "direction_cosine": "fall_north",
    "direction_sine": "fall_east",
    "axis_cosine": "fall_axis_cosine",
    "axis_sine": "fall_axis_sine",
}
"""Falls by name, and the means over members that a cube has of them."""


class Body(Model):
    """One rigid body in space; every orientation of a grid that symmetry closes counts alike."""

    direction: ClassVar = "orientation"
    case_dims: ClassVar = ("height", "b_over_h", "aspect", "friction")
    copied: ClassVar = "repeated"
    one_component: ClassVar = False
    twists: ClassVar = True
    reads: ClassVar = ("overturned", "fall_azimuth", *_MEMBERS.values())
    reads_spread: ClassVar = ("scramble_difference",)
    reads_outcomes: ClassVar = (
        "overturned", "fall_azimuth", "residual_slip_north", "residual_slip_east", "residual_twist"
    )  # fmt: skip

    def representative(self, cube: xr.Dataset) -> NDArray[np.intp]:
        """Every orientation of the grid."""
        return np.arange(cube.sizes[self.direction])

    def falls(self, cube: xr.Dataset, *, ensemble: bool = True) -> xr.Dataset:
        """As of `Model.falls`."""
        known = cube["overturned"].notnull()
        fell = (cube["overturned"] == 1).where(known)
        azimuth = cube["fall_azimuth"].astype("float64") * (np.pi / 180.0)
        found = {"falls": fell.astype("float64")}
        for kind, angle in (("direction", azimuth), ("axis", 2.0 * azimuth)):
            for name, of in (("cosine", np.cos), ("sine", np.sin)):
                values = xr.apply_ufunc(of, angle, dask="allowed")
                found[f"{kind}_{name}"] = values.where(fell == 1, 0.0).where(known)
        if ensemble and "probability_falls" in cube:
            found = {name: cube[_MEMBERS[name]].astype("float64").fillna(values) for name, values in found.items()}
        count = cube.sizes[self.direction]
        return xr.Dataset({**found, "weight": (self.direction, np.full(count, 1.0 / count))})

    def spread(self, cube: xr.Dataset) -> xr.Dataset:
        """As of `Model.spread`; members agree where all fall, and fall apart more than 15° about their mean."""
        falls = cube["probability_falls"]
        length = xr.apply_ufunc(np.hypot, cube["fall_north"], cube["fall_east"]) / falls.where(falls > 0)
        agree = falls == 1
        return xr.Dataset(
            {
                "falls": falls,
                "gap": cube["scramble_difference"],
                "agree": agree,
                "apart": agree & (length < OF_ONE_MIND),
            }
        )

    def outcomes(self, site: xr.Dataset, face_deg: FloatArray, cells: dict[str, NDArray[np.intp]]) -> Outcomes:
        """As of `Model.outcomes`, of the square prism that faces most nearly the same way."""
        square = site.isel(aspect=int(np.flatnonzero(site["aspect"].to_numpy() == 1.0)[0]))
        sources = nearest(site[self.direction].to_numpy(), face_deg, SQUARE_PERIOD)
        found = picked(square, self.reads_outcomes, {self.direction: sources.cell, **cells})
        flag = found["overturned"]
        slip = np.hypot(found["residual_slip_north"], found["residual_slip_east"])
        return Outcomes(flag == 1, np.isfinite(flag), found["fall_azimuth"], slip, found["residual_twist"])
