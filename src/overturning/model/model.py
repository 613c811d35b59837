"""A model, what stands on the ground: its dimensions, its outcome, its symmetry, and what falls its cubes hold.

The kernels compute it (`overturning.dem.run`). Studies, statistics, surveys, figures and report work from what it says
and need not know what it is.
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
    """What stones do under one record at each amplitude, each shape (amplitudes, n)."""

    fell: NDArray[np.bool_]
    known: NDArray[np.bool_]
    """whether there is an answer;"""
    azimuth: FloatArray
    """azimuth towards which a stone fell, degrees; NaN where it did not;"""
    slip: FloatArray
    """residual displacement, m; NaN in planes, which stones leave oblique to their faces, by far more than in them;"""
    twist: FloatArray
    """residual turn about the vertical, degrees; NaN where it fell, and where the model has none."""

    def some(self, own: NDArray[np.bool_]) -> "Outcomes":
        """Those of some of the stones."""
        chosen: Any = (values[:, own] for values in self)
        return Outcomes(*chosen)


class Model(ABC):
    """What stands on the ground; as of a cube it is made without arguments, since that tells no more of it."""

    variables: ClassVar[tuple[Variable, ...]]
    """Variables of an outcome."""
    ensemble_variables: ClassVar[tuple[Variable, ...]]
    """What the members of an ensemble say of a cell, as `tally` has it."""
    comment: ClassVar[str]
    """What ``overturned`` means."""
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
    reads_outcomes: ClassVar[tuple[str, ...]]
    """Variables that `outcomes` takes."""

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
        """About what a case takes, over one of a single block."""

    @property
    @abstractmethod
    def attributes(self) -> dict[str, str]:
        """What a dataset says of it."""

    @abstractmethod
    def sizes(self, height: ArrayLike | None, b_over_h: ArrayLike | None) -> tuple[ArrayLike, ArrayLike]:
        """Heights (m) and B/H, its own where not given; `ArgumentError` where it has none, or they cannot be chosen."""

    @abstractmethod
    def periods(self, aspect: FloatArray) -> FloatArray:
        """Turn after which a case is the same, degrees, shape (1,) or of each aspect; 0 where it is after any turn."""

    @abstractmethod
    def stiffer(self, factor: float) -> "Model":
        """The same with springs so many times as stiff."""

    @property
    def further_variables(self) -> tuple[Variable, ...]:
        """What a study finds beside the outcome."""
        return ()

    @property
    def sized(self) -> bool:
        """Whether its slenderness can be chosen."""
        return True

    @property
    def oblong(self) -> bool:
        """Whether the aspect of its base is free."""
        return False

    @property
    def direction_attributes(self) -> dict[str, float]:
        """What a cube says of its directions."""
        return {}

    def distinct(self, grid: Grid) -> Grid:
        """The grid with one value of friction where the coefficient that is swept counts for nothing."""
        return grid

    def sources(self, grid: Grid, symmetric: bool = True) -> Sources:
        """Which direction of a grid answers for each, shape (directions, 1) or (directions, aspects).

        `turn_deg` is the turn clockwise of what is computed to the case that is asked for. Where it is not to be taken
        as `symmetric`, a full turn alone leaves a case the same.
        """
        return representatives(grid.directions, self._periods(grid) if symmetric else FULL_TURN)

    def _periods(self, grid: Grid) -> FloatArray:
        return self.periods(grid["aspect"] if "aspect" in grid.names else np.ones(1))

    @abstractmethod
    def turned(self, arrays: dict[str, NDArray[Any]], grid: Grid, sources: Sources) -> None:
        """Turn answers in a grid's shape, each taken from its source, to the case asked for, and mark those taken."""

    @abstractmethod
    def tally(
        self, flags: NDArray[np.int8], azimuth_deg: FloatArray, scramble: NDArray[np.int64]
    ) -> dict[str, NDArray[Any]]:
        """Values of `ensemble_variables`, a row per cell.

        Of the members, shape (cells, members), the `flags`, which may have a last dimension of elements, the azimuths
        of falls in space, and the number of the scramble, shape (members,).
        """

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
            ``towards`` and ``away``, shares of the members that fall to either side, missing where none was run. Where
            falls have azimuths of their own ``away`` is 0, and of the cells in which members ``agree`` that it falls
            there are those in which they fall ``apart``, each its own way.
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
