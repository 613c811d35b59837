"""What a model says of its cubes: which dimension is a direction, which cells stand for all, what falls they hold.

Statistics, surveys, figures and report work from that and need not know what stood on the ground.
"""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

if TYPE_CHECKING:
    import xarray as xr


class Outcomes(NamedTuple):
    """What stones do under one record at each amplitude, each shape (amplitudes, n)."""

    fell: NDArray[np.bool_]
    known: NDArray[np.bool_]
    """whether there is an answer;"""
    azimuth: FloatArray
    """azimuth towards which a stone fell, degrees; NaN where it did not;"""
    slip: FloatArray
    """residual displacement, m;"""
    twist: FloatArray
    """residual turn about the vertical, degrees; NaN where it fell, and where the model has none."""

    def some(self, own: NDArray[np.bool_]) -> "Outcomes":
        """Those of some of the stones."""
        chosen: Any = (values[:, own] for values in self)
        return Outcomes(*chosen)


class Model(ABC):
    """What stands on the ground, as its cubes tell it."""

    direction: ClassVar[str]
    """Dimension of a cube along which the motion, or the body, is turned about the vertical."""
    case_dims: ClassVar[tuple[str, ...]]
    """Dimensions of the block: all others but the record."""
    copied: ClassVar[str]
    """Variable that is 1 where another cell answered for this one."""
    one_component: ClassVar[bool]
    """Whether each direction has its own component of the motion, along which it falls to one side or the other."""
    twists: ClassVar[bool]
    """Whether it can turn about the vertical."""
    reads: ClassVar[tuple[str, ...]]
    """Variables that `falls` takes, those of a cube that are there."""
    reads_spread: ClassVar[tuple[str, ...]]
    """Variables that `spread` takes beside these."""
    reads_outcomes: ClassVar[tuple[str, ...]]
    """Variables that `outcomes` takes."""

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of a case, the direction first."""
        return (self.direction, *self.case_dims)

    @abstractmethod
    def representative(self, cube: "xr.Dataset") -> NDArray[np.intp]:
        """Positions along the direction of the cells that stand for all: each case once."""

    @abstractmethod
    def falls(self, cube: "xr.Dataset", *, ensemble: bool = True) -> "xr.Dataset":
        """Falls of the representative cells, as lazy as the cube.

        Parameters
        ----------
        cube : Dataset
            With those of `reads` that it has, as stored or decoded.
        ensemble : bool
            Take what the members of an ensemble say of a cell where they were run, else the nominal outcome.

        Returns
        -------
        Dataset
            ``falls``, the probability of falling; ``direction_cosine``, ``direction_sine``, ``axis_cosine`` and
            ``axis_sine``, expected values of cos φ, sin φ, cos 2φ and sin 2φ of the azimuth φ of the fall, 0 where
            nothing falls. All are missing where the outcome is. ``weight`` over the direction, which sums to 1: how
            much each cell counts.
        """

    @abstractmethod
    def spread(self, cube: "xr.Dataset") -> "xr.Dataset":
        """How divided the members of an ensemble are, of the representative cells.

        Returns
        -------
        Dataset
            ``falls`` (probability, missing where no member was run), ``gap`` (of it between the two scrambles), and of
            the cells in which members ``agree`` that it falls those in which they fall ``apart``, each its own way.
        """

    @abstractmethod
    def outcomes(self, site: "xr.Dataset", face_deg: FloatArray, cells: dict[str, NDArray[np.intp]]) -> Outcomes:
        """What stones of square footprint do.

        Parameters
        ----------
        site : Dataset
            Cube of one record, with or without the dimension of amplitudes.
        face_deg : ndarray, shape (n,)
            Azimuth that the front of each stone looks to.
        cells : dict of ndarray, shape (n,)
            Its places along height, B/H and friction.
        """


def picked(site: "xr.Dataset", names: tuple[str, ...], cells: dict[str, NDArray[np.intp]]) -> dict[str, FloatArray]:
    """Variables of a record by name at cells, places by dimension of one shape: shape (amplitudes, *shape)."""
    several = ["amplitude"] if "amplitude" in site.dims else []
    place = (slice(None) if several else None, *cells.values())
    return {name: np.asarray(site[name].transpose(*several, *cells).to_numpy()[place], np.float64) for name in names}
