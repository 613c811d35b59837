"""A grid of cases over azimuth, height, slenderness and friction: which cells are computed, and what all of them hold."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.dem.blocks import Cases, check_count
from overturning.dem.cases import CaseResults
from overturning.dem.variables import INT8_MISSING, PER_ELEMENT, VARIABLES
from overturning.errors import ArgumentError

if TYPE_CHECKING:
    import xarray as xr


DIMENSIONS: Final = ("azimuth", "height", "b_over_h", "friction")

# Variables that change sign when the plane is looked at from behind.
_ODD: Final = ("overturned", "residual_slip")


def axis(name: str, values: ArrayLike) -> FloatArray:
    """The values of an argument as a row of at least one."""
    row = np.atleast_1d(np.asarray(values, dtype=np.float64))
    if row.ndim != 1 or row.size == 0:
        raise ArgumentError(f"{name}: shape {row.shape}; give a row of at least one value")
    return row


def opposite_azimuths(azimuth_deg: FloatArray) -> NDArray[np.int64]:
    """For each azimuth the position of the one at φ+180° that answers for it, or −1 where it is computed.

    Of a pair, the first in the list is computed and the second mirrored.
    """
    reduced = np.mod(azimuth_deg, 360.0)
    first: dict[float, int] = {}
    source = np.full(azimuth_deg.size, -1, np.int64)
    for index, azimuth in enumerate(reduced):
        source[index] = first.get(float(np.mod(azimuth + 180.0, 360.0)), -1)
        if source[index] < 0:
            first.setdefault(float(azimuth), index)
    return source


@dataclass(frozen=True)
class Grid:
    """The cells of a grid.

    Attributes
    ----------
    axes : sequence of ndarray
        Azimuth (degrees), height (m), slenderness and friction.
    opposite : ndarray of int64, shape (azimuths,)
        As of `opposite_azimuths`; −1 throughout where every azimuth is computed.
    """

    axes: Sequence[FloatArray]
    opposite: NDArray[np.int64]

    @classmethod
    def of(cls, axes: Sequence[FloatArray], mirror: bool) -> "Grid":
        """The grid over these axes; whether one azimuth may answer for its opposite."""
        check_count(int(np.prod([float(values.size) for values in axes])))
        return cls(axes, opposite_azimuths(axes[0]) if mirror else np.full(axes[0].size, -1, np.int64))

    @property
    def computed(self) -> NDArray[np.int64]:
        """Positions of the azimuths that are computed."""
        return np.flatnonzero(self.opposite < 0)

    @property
    def cases(self) -> Cases:
        """The cases to compute."""
        cells = np.meshgrid(self.axes[0][self.computed], *self.axes[1:], indexing="ij")
        return Cases(*(values.ravel() for values in cells))

    def spread(self, found: CaseResults) -> dict[str, NDArray[Any]]:
        """The outcome of the cases in the grid's shape, mirrored where another azimuth answers."""
        computed, mirrored = self.computed, self.opposite >= 0
        # Where each azimuth's answer stands among the computed ones.
        place = np.searchsorted(computed, np.where(mirrored, self.opposite, np.arange(mirrored.size)))
        shape = (computed.size, *(values.size for values in self.axes[1:]))
        arrays: dict[str, NDArray[Any]] = {}
        for name in (*(variable.name for variable in VARIABLES if variable.name != "mirrored"), "block_steps"):
            values = getattr(found, name)
            values = values.reshape(*shape, *values.shape[1:])[place]
            if name in _ODD:
                turned = values[mirrored]
                # 0 stays 0 and not −0, so that equal cubes are equal bytes.
                stays = (turned == 0) | (turned == INT8_MISSING if name == "overturned" else False)
                values[mirrored] = np.where(stays, turned, -turned)
            elif name == "block_steps":
                values[mirrored] = 0
            arrays[name] = values
        arrays["mirrored"] = np.broadcast_to(mirrored[:, None, None, None], arrays["status"].shape).astype(np.int8)
        return arrays


def dataset(
    arrays: Mapping[str, NDArray[Any]],
    axes: Mapping[str, tuple[FloatArray, str, str]],
    elements: Sequence[str] = (),
    attributes: Mapping[str, Any] | None = None,
) -> "xr.Dataset":
    """The arrays of a grid with named coordinates.

    Parameters
    ----------
    arrays : mapping
        The cube's variables by name.
    axes : mapping
        Values, unit and long name of each of `DIMENSIONS`.
    elements : sequence of str
        Names of the elements, the last dimension of `PER_ELEMENT`; empty where there is no such dimension.
    attributes : mapping, optional
        Of the dataset.
    """
    import xarray as xr

    coordinates: dict[str, Any] = {
        name: (name, values, {"units": units, "long_name": text}) for name, (values, units, text) in axes.items()
    }
    if elements:
        coordinates["element"] = ("element", list(elements))
    return xr.Dataset(
        {
            variable.name: (
                (*axes, "element") if elements and variable.name in PER_ELEMENT else tuple(axes),
                arrays[variable.name],
                dict(variable.attributes),
            )
            for variable in VARIABLES
        },
        coordinates,
        attributes,
    )
