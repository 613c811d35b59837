"""A block or a scene in vertical planes: each azimuth has its own component of the motion, along which all falls go.

Under the motions along φ and φ + 180° a scene that is its own mirror image is one vertical plane and one run, so
shares, means and roses take each plane once; any other scene is a case of its own under each. The azimuths of one
record are the same ground motion seen from many sides, not independent samples: nothing in this module gives a p-value.
"""

from dataclasses import dataclass, field, replace
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError, ResultError
from overturning.model.edges import first_edge
from overturning.model.geometry import native_size, plane_period
from overturning.model.grid import Grid
from overturning.model.model import Model, Outcomes, picked
from overturning.model.scene import Scene, gravestone
from overturning.model.symmetry import PLANE_PERIOD, Sources, mirrored_planes, nearest, nearest_planes
from overturning.model.variables import INT8_MISSING, PLANE_ENSEMBLE_VARIABLES, VARIABLES, answered

if TYPE_CHECKING:
    import xarray as xr

FALLS = ("overturned", "probability_towards", "probability_away")
"""Variables of a cube that `fall_probability` takes."""


def period_of(cube: "xr.Dataset | xr.DataArray") -> float:
    """Turn of the motion after which a case is the same, degrees: 180, or 360 of a scene without mirror image."""
    return float(cube["azimuth"].attrs.get("period", PLANE_PERIOD))


def plane_index(azimuth_deg: ArrayLike, period: float = PLANE_PERIOD) -> NDArray[np.intp]:
    """Positions of one azimuth per case, in the order of azimuth modulo the period.

    Parameters
    ----------
    azimuth_deg : array_like, shape (n,)
        Azimuths, degrees.
    period : float
        As of `period_of`.

    Returns
    -------
    ndarray of int
        Of φ and φ + 180° the one below 180° where both are there and are one plane.
    """
    azimuth = np.asarray(azimuth_deg, dtype=np.float64)
    planes = np.unique(np.round(azimuth % period, 6) % period)
    return nearest(azimuth, planes, period).cell if azimuth.size else np.zeros(0, np.intp)


def gaps_of(azimuth_deg: ArrayLike, period: float = PLANE_PERIOD) -> tuple[NDArray[np.bool_], float]:
    """Which distances of neighbours on a circle are parts of it that were not computed, and the step elsewhere.

    Parameters
    ----------
    azimuth_deg : array_like, shape (n,)
        Ascending azimuths modulo the period, each once, degrees.
    period : float
        After so many degrees the first one comes again.

    Returns
    -------
    not_computed : ndarray of bool, shape (n,)
        Whether the distance from each azimuth to the next one is at least twice as wide as both of its neighbours and
        as the step: one azimuth of a regular grid is missing, or more. The last distance is that to the first azimuth.
    step : float
        Half of what was computed lies between azimuths no farther apart than this, degrees: that of a regular grid,
        also where azimuths were added between its points.
    """
    azimuth = np.round(np.asarray(azimuth_deg, dtype=np.float64), 6)
    gap = np.diff(azimuth, append=azimuth[:1] + period)
    wide: NDArray[np.bool_] = gap >= 2.0 * np.maximum(np.roll(gap, 1), np.roll(gap, -1)) * (1.0 - 1e-9)
    computed = np.sort(gap[~wide])
    step = float(computed[np.searchsorted(np.cumsum(computed), 0.5 * computed.sum())])
    return wide & (gap >= 2.0 * step * (1.0 - 1e-9)), step


def plane_weight(
    plane_azimuth_deg: ArrayLike, period: float = PLANE_PERIOD, *, whole_circle: bool = False
) -> FloatArray:
    """Share of the half circle that each plane stands for: half the way to both neighbours (trapezoidal rule).

    A regular grid gets equal weights; azimuths added between its points share the weight of their neighbourhood, so
    that a study's extra azimuths do not count twice. The planes at the ends of a grid over a part of the circle do not
    stand for the rest of it, of which nothing is known, but for half a step of it (`gaps_of`).

    Parameters
    ----------
    plane_azimuth_deg : array_like, shape (n,)
        Ascending azimuths of the planes, modulo the period.
    period : float
        As of `period_of`; 360 where the share is of the whole circle.
    whole_circle : bool
        Let them stand for it all the same, half of the gap each.

    Returns
    -------
    ndarray, shape (n,)
        Sums to 1.
    """
    plane = np.round(np.asarray(plane_azimuth_deg, dtype=np.float64) % period, 6)
    gap = np.diff(plane, append=plane[:1] + period)
    if not whole_circle:
        not_computed, step = gaps_of(plane, period)
        period -= float((gap[not_computed] - step).sum())
        gap[not_computed] = step
    return (gap + np.roll(gap, 1)) / (2.0 * period)


def azimuth_weight(azimuth_deg: ArrayLike, period: float = PLANE_PERIOD) -> FloatArray:
    """How much each azimuth of a circle counts: 1 on a regular grid; one added shares the part of its neighbours."""
    azimuth = np.asarray(azimuth_deg, dtype=np.float64)
    index = plane_index(azimuth, period)
    weight = plane_weight(azimuth[index], period) * index.size
    return np.asarray(weight[nearest(azimuth[index], azimuth, period).cell])


def fall_probability(cube: "xr.Dataset", *, ensemble: bool = True) -> "xr.Dataset":
    """Probability of falling towards φ and towards φ + 180°, cell by cell.

    Parameters
    ----------
    cube : Dataset
        The cube; ``overturned`` as stored or decoded.
    ensemble : bool
        Take the ensemble's probabilities where the cube has them, else (and elsewhere) the nominal flag as 0 or 1.

    Returns
    -------
    Dataset
        ``towards``, ``away`` (float32, dimensions of ``overturned``; missing where the outcome is), as lazy as the
        cube.

    Raises
    ------
    ResultError
        If the dataset has no variable ``overturned``.
    """
    if "overturned" not in cube:
        raise ResultError("the dataset has no variable 'overturned'; it is not a cube of this program")
    flag = cube["overturned"]
    import xarray as xr

    made = {}
    for sign, name, where in ((1, "towards", "azimuth"), (-1, "away", "azimuth + 180°")):
        chance = (flag == sign).where(answered(flag)).astype("float32")
        if ensemble and "probability_towards" in cube:
            chance = cube[f"probability_{name}"].astype("float32").fillna(chance)
        chance.attrs = {"long_name": f"probability of falling towards the {where}", "units": "1"}
        made[name] = chance
    return xr.Dataset(made)


@dataclass(frozen=True)
class Planes(Model):
    """A block or a scene in the vertical plane of each azimuth."""

    scene: Scene = field(default_factory=gravestone)

    variables: ClassVar = VARIABLES
    ensemble_variables: ClassVar = PLANE_ENSEMBLE_VARIABLES
    comment: ClassVar = (
        "overturned: +1 when the block falls towards the azimuth, -1 towards azimuth + 180 degrees, 0 when it stands"
    )
    direction: ClassVar = "azimuth"
    case_dims: ClassVar = ("height", "b_over_h", "friction")
    copied: ClassVar = "mirrored"
    one_component: ClassVar = True
    twists: ClassVar = False
    reads: ClassVar = FALLS
    reads_outcomes: ClassVar = ("overturned", "overturning_time")

    @property
    def elements(self) -> tuple[str, ...]:
        """As of `Model.elements`."""
        return self.scene.free

    @property
    def cost(self) -> float:
        """As of `Model.cost`: any other scene than a single block has the general kernel."""
        return 1.0 if len(self.elements) == 1 else 5.0 * len(self.elements)

    @property
    def attributes(self) -> dict[str, str]:
        """As of `Model.attributes`."""
        return {"scene": self.scene.name}

    @property
    def direction_attributes(self) -> dict[str, float]:
        """As of `Model.direction_attributes`."""
        return {"period": plane_period(self.scene)}

    def sizes(self, height: ArrayLike | None, b_over_h: ArrayLike | None) -> tuple[ArrayLike, ArrayLike]:
        """As of `Model.sizes`, of the reference element."""
        own_height, own_ratio = native_size(self.scene)
        return own_height if height is None else height, own_ratio if b_over_h is None else b_over_h

    def periods(self, aspect: FloatArray) -> FloatArray:
        """As of `Model.periods`."""
        if (aspect != 1.0).any():
            raise ArgumentError(f"aspect: {aspect.tolist()}; only a rectangle in space has one")
        return np.array([plane_period(self.scene)])

    def stiffer(self, factor: float) -> "Planes":
        """As of `Model.stiffer`, also those of the default contact law."""
        laws = []
        for pair in combinations_with_replacement(self.scene.materials, 2):
            law = self.scene.law_between(*pair)
            changed: dict[str, float] = {"static_penetration": law.static_penetration / factor}
            if law.stiffness != "auto":
                changed = {"stiffness": law.stiffness * factor}
            laws.append(law.model_copy(update=changed))
        return replace(self, scene=self.scene.model_copy(update={"contacts": tuple(laws)}))

    def distinct(self, grid: Grid) -> Grid:
        """As of `Model.distinct`: a scene may have all coefficients of its own."""
        return grid if self.scene.sweeps_friction else grid.changed(friction=grid["friction"][:1])

    def sources(self, grid: Grid, symmetric: bool = True) -> Sources:
        """As of `Model.sources`; mirrored at φ + 180°."""
        found = super().sources(grid, symmetric)
        return mirrored_planes(found, float(self._periods(grid)[0])) if symmetric else found

    def turned(self, arrays: dict[str, NDArray[Any]], grid: Grid, sources: Sources) -> None:
        """As of `Model.turned`."""
        mirrored = grid.over_all(sources.mirrored)
        arrays["mirrored"] = mirrored.astype(np.int8)
        for variable in self.variables:
            if variable.name != "mirrored":
                arrays[variable.name][mirrored] = variable.mirrored(arrays, mirrored)

    def tally(
        self,
        flags: NDArray[np.int8],
        azimuth_deg: FloatArray,  # noqa: ARG002, a plane has its own
        scramble: NDArray[np.int64],
    ) -> dict[str, NDArray[Any]]:
        """As of `Model.tally`: shares of the members that fall to either side."""
        known = flags != INT8_MISSING
        counted = known.sum(axis=1)
        found = {"members": counted if counted.ndim == 1 else counted.min(axis=1)}
        for name, side in (("towards", 1), ("away", -1)):
            shares = []
            for chosen in (np.ones(scramble.size, dtype=bool), scramble == 0, scramble == 1):
                count, fell = known[:, chosen].sum(axis=1), (flags[:, chosen] == side).sum(axis=1)
                with np.errstate(invalid="ignore"):
                    shares.append(np.where(count > 0, fell / np.maximum(count, 1), np.nan))
            found[f"probability_{name}"], found[f"scramble_difference_{name}"] = shares[0], shares[1] - shares[2]
        return found

    def representative(self, cube: "xr.Dataset") -> NDArray[np.intp]:
        """One azimuth per plane."""
        return plane_index(cube["azimuth"].to_numpy(), period_of(cube))

    def falls(self, cube: "xr.Dataset", *, ensemble: bool = True) -> "xr.Dataset":
        """As of `Model.falls`."""
        import xarray as xr

        p = fall_probability(cube, ensemble=ensemble).isel(azimuth=self.representative(cube))
        angle = np.radians(p["azimuth"].astype("float64"))
        falls, net = p["towards"] + p["away"], p["towards"] - p["away"]
        return xr.Dataset({
            "falls": falls.assign_attrs(long_name="probability of falling", units="1"),
            "direction_cosine": net * np.cos(angle),
            "direction_sine": net * np.sin(angle),
            "axis_cosine": falls * np.cos(2 * angle),
            "axis_sine": falls * np.sin(2 * angle),
            "weight": ("azimuth", plane_weight(p["azimuth"].to_numpy(), period_of(cube))),
        })  # fmt: skip

    def spread(self, cube: "xr.Dataset") -> "xr.Dataset":
        """As of `Model.spread`."""
        import xarray as xr

        half = cube.isel(azimuth=self.representative(cube))
        return xr.Dataset({side: half[f"probability_{side}"] for side in ("towards", "away")})

    def outcomes(self, site: "xr.Dataset", face_deg: FloatArray, cells: dict[str, NDArray[np.intp]]) -> Outcomes:
        """As of `Model.outcomes`: it can fall in the planes of both pairs of faces, and does as `first_edge` says."""
        faces = np.stack([face_deg, face_deg + 90])
        planes = nearest_planes(site["azimuth"].to_numpy(), faces, period_of(site))
        both = {"azimuth": planes.cell, **{name: np.stack([at, at]) for name, at in cells.items()}}
        found = picked(site, self.reads_outcomes, both)
        side = np.where(planes.mirrored, -found["overturned"], found["overturned"])
        side = np.where(planes.known, side, np.nan).swapaxes(0, 1)
        towards = np.broadcast_to((faces[:, None] + np.where(side < 0, 180, 0)) % 360, side.shape)
        fell, azimuth = first_edge(np.abs(side), found["overturning_time"].swapaxes(0, 1), towards)
        untold = np.full(fell.shape, np.nan)
        return Outcomes(fell == 1, np.isfinite(fell), azimuth, untold, untold)
