"""Abstract model of the object on the ground: dimensions, outcome variables, symmetry and falls.

The kernels compute a model (`overturning.dem.run`). Studies, statistics, surveys, figures and report use this interface
only.
"""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import ArrayLike, FloatArray
from overturning.model.grid import Grid
from overturning.model.symmetry import FULL_TURN, Sources, representatives
from overturning.model.variables import Variable

if TYPE_CHECKING:
    import xarray as xr


class Outcomes(NamedTuple):
    """Outcomes of n stones under one record at each amplitude; arrays of shape (amplitudes, n)."""

    fell: NDArray[np.bool_]
    """True for a stone that fell."""
    known: NDArray[np.bool_]
    """True where an outcome was found."""
    azimuth: FloatArray
    """Azimuth towards which a stone fell, degrees clockwise from north; NaN for a stone that stands."""
    slip: FloatArray
    """Residual displacement, m; NaN for planar models, which do not compute slip out of their plane."""
    twist: FloatArray
    """Residual rotation about the vertical, degrees; NaN for a stone that fell and for models without twist."""

    def some(self, own: NDArray[np.bool_]) -> "Outcomes":
        """Select a subset of the stones, given as a mask of shape (n,)."""
        chosen: Any = (values[:, own] for values in self)
        return Outcomes(*chosen)


class Model(ABC):
    """Abstract model.

    A subclass must be constructible without arguments, because a cube does not store its parameters.
    """

    variables: ClassVar[tuple[Variable, ...]]
    """Outcome variables."""
    ensemble_variables: ClassVar[tuple[Variable, ...]]
    """Variables that summarise the ensemble members of a cell (see `tally`)."""
    comment: ClassVar[str]
    """Meaning of ``overturned``, for the attributes of a cube."""
    direction: ClassVar[str]
    """Dimension of a cube along which the motion or the body is rotated about the vertical."""
    case_dims: ClassVar[tuple[str, ...]]
    """Dimensions other than the record and the direction: size, slenderness, friction."""
    copied: ClassVar[str]
    """Variable that is 1 where the outcome was copied from a symmetric cell."""
    one_component: ClassVar[bool]
    """True for planar models: each direction has one component of the motion, and a fall goes to either side of it."""
    twists: ClassVar[bool]
    """True if the model can rotate about the vertical."""
    reads: ClassVar[tuple[str, ...]]
    """Variables that `falls` reads, as far as a cube has them."""
    reads_outcomes: ClassVar[tuple[str, ...]]
    """Variables that `outcomes` reads."""

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of a case, the direction first."""
        return (self.direction, *self.case_dims)

    @property
    @abstractmethod
    def elements(self) -> tuple[str, ...]:
        """Names of the free elements, in order."""

    @property
    @abstractmethod
    def cost(self) -> float:
        """Approximate cost of a case relative to a case of a single block."""

    @property
    @abstractmethod
    def attributes(self) -> dict[str, str]:
        """Attributes that describe the model in a dataset."""

    @abstractmethod
    def sizes(self, height: ArrayLike | None, b_over_h: ArrayLike | None) -> tuple[ArrayLike, ArrayLike]:
        """Return heights (m) and B/H, the model's own where not given.

        Raises
        ------
        ArgumentError
            If a size is missing and the model has none of its own, or is given and cannot be chosen.
        """

    @abstractmethod
    def periods(self, aspect: FloatArray) -> FloatArray:
        """Return the rotation period of a case, degrees, shape (1,) or (aspects,); 0 for a body of revolution."""

    @abstractmethod
    def stiffer(self, factor: float) -> "Model":
        """Return the model with contact stiffness × `factor`."""

    @property
    def further_variables(self) -> tuple[Variable, ...]:
        """Variables that a study adds to the outcome variables."""
        return ()

    @property
    def sized(self) -> bool:
        """True if the slenderness can be chosen."""
        return True

    @property
    def oblong(self) -> bool:
        """True if the aspect of the base can be chosen."""
        return False

    @property
    def direction_attributes(self) -> dict[str, float]:
        """Attributes of the direction coordinate of a cube."""
        return {}

    def distinct(self, grid: Grid) -> Grid:
        """Return the grid with one friction value if the swept coefficient has no effect on the model."""
        return grid

    def sources(self, grid: Grid, symmetric: bool = True) -> Sources:
        """Return for each direction the direction that is computed in its place.

        Parameters
        ----------
        grid : Grid
            Cases.
        symmetric : bool
            Use the symmetry of the model; otherwise only a full turn leaves a case unchanged.

        Returns
        -------
        Sources
            Shape (directions, 1) or (directions, aspects); `turn_deg` is the clockwise rotation from the computed case
            to the requested one.
        """
        return representatives(grid.directions, self._periods(grid) if symmetric else FULL_TURN)

    def _periods(self, grid: Grid) -> FloatArray:
        return self.periods(grid["aspect"] if "aspect" in grid.names else np.ones(1))

    @abstractmethod
    def rotate_outcomes(self, arrays: dict[str, NDArray[Any]], grid: Grid, sources: Sources) -> None:
        """Rotate outcomes in the shape of the grid from their source to the requested case, and mark the copies."""

    @abstractmethod
    def tally(
        self, flags: NDArray[np.int8], azimuth_deg: FloatArray, scramble: NDArray[np.int64]
    ) -> dict[str, NDArray[Any]]:
        """Compute `ensemble_variables`, one row per cell.

        Parameters
        ----------
        flags : ndarray of int8, shape (cells, members) or (cells, members, elements)
            Outcome of each member.
        azimuth_deg : ndarray, shape (cells, members)
            Azimuth of the fall in 3-D, degrees.
        scramble : ndarray of int, shape (members,)
            Number of the scrambled Sobol sequence of each member.
        """

    @abstractmethod
    def representative(self, cube: "xr.Dataset") -> NDArray[np.intp]:
        """Return the positions along the direction that hold each distinct case once."""

    @abstractmethod
    def falls(self, cube: "xr.Dataset", *, ensemble: bool = True) -> "xr.Dataset":
        """Return the falls of the representative cells, as lazy as the cube.

        Parameters
        ----------
        cube : Dataset
            Cube with the variables of `reads`, as stored or decoded.
        ensemble : bool
            Use the ensemble members of a cell where they were run; otherwise the nominal outcome.

        Returns
        -------
        Dataset
            ``falls``, the probability of falling; ``direction_cosine``, ``direction_sine``, ``axis_cosine`` and
            ``axis_sine``, expected values of cos φ, sin φ, cos 2φ and sin 2φ of the azimuth φ of the fall, 0 where
            nothing falls. All are missing where the outcome is missing. ``weight``: weight of each cell along the
            direction; the weights sum to 1.
        """

    @abstractmethod
    def spread(self, cube: "xr.Dataset") -> "xr.Dataset":
        """Return the disagreement of the ensemble members in the representative cells.

        Returns
        -------
        Dataset
            ``towards`` and ``away``, shares of the members that fall to either side, missing where none was run. Where
            falls have azimuths of their own ``away`` is 0, and of the cells in which members ``agree`` that it falls
            there are those in which they fall ``apart``, each its own way.
        """

    @abstractmethod
    def outcomes(self, site: "xr.Dataset", face_deg: FloatArray, cells: dict[str, NDArray[np.intp]]) -> Outcomes:
        """Return the outcomes of stones of square footprint.

        Parameters
        ----------
        site : Dataset
            Cube of one record, with or without the dimension of amplitudes.
        face_deg : ndarray, shape (n,)
            Azimuth that the front of each stone faces, degrees.
        cells : dict of ndarray, shape (n,)
            Positions of each stone along height, B/H and friction.
        """


def select_cells(
    site: "xr.Dataset", names: tuple[str, ...], cells: dict[str, NDArray[np.intp]]
) -> dict[str, FloatArray]:
    """Return variables of a record at cells, by name, shape (amplitudes, *shape of the positions)."""
    several = ["amplitude"] if "amplitude" in site.dims else []
    place = (slice(None) if several else None, *cells.values())
    return {name: np.asarray(site[name].transpose(*several, *cells).to_numpy()[place], np.float64) for name in names}
