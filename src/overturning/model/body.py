"""A body in space: it faces an orientation, moves with all components of the motion, and falls towards any azimuth."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from overturning.arrays import ArrayLike, FloatArray
from overturning.errors import ArgumentError, suggest_keywords
from overturning.model.contact import VertexContact
from overturning.model.grid import Grid
from overturning.model.model import Model, Outcomes, select_cells
from overturning.model.shapes import Rectangle, Shape, shape_of
from overturning.model.symmetry import FULL_TURN, Sources, nearest
from overturning.model.variables import (
    BODY_ENSEMBLE_VARIABLES,
    BODY_VARIABLES,
    FACE_VARIABLES,
    INT8_MISSING,
    Variable,
    answered,
)

if TYPE_CHECKING:
    import xarray as xr

SQUARE_PERIOD: Final = 90.0
"""Rotation period of a stone of square footprint, degrees."""

MIN_AGREEMENT: Final = float(np.cos(np.radians(15.0)))
"""Mean resultant of directions that lie 15° to either side of their mean."""

_MEMBERS: Final = {
    "falls": "probability_falls",
    "direction_cosine": "fall_north",
    "direction_sine": "fall_east",
    "axis_cosine": "fall_axis_cosine",
    "axis_sine": "fall_axis_sine",
}
"""Variable of a cube that holds the mean over members of each variable of `Model.falls`."""


def direction_weight(falls: ArrayLike, north: ArrayLike, east: ArrayLike, members: ArrayLike) -> FloatArray:
    """Return the weight of a fall in direction statistics: the resultant of the directions of its members.

    The square of the mean resultant length R of k members that fall exceeds that of the directions they are drawn from:
    without any common direction k R² is 1 on average. So the weight is √((k R² − 1)/(k − 1)), 0 where that is negative
    and 1 where fewer than two members fall, as they tell nothing of a spread.

    Parameters
    ----------
    falls, north, east : array_like
        ``probability_falls``, ``fall_north`` and ``fall_east``; NaN where no member was run.
    members : array_like
        Members with an outcome.
    """
    fell = np.nan_to_num(np.asarray(falls, np.float64))
    count = fell * np.asarray(members, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        square = (np.asarray(north, np.float64) ** 2 + np.asarray(east, np.float64) ** 2) / fell**2
        known = np.sqrt(np.clip((count * square - 1.0) / (count - 1.0), 0.0, 1.0))
    return np.asarray(np.where(count > 1.5, known, 1.0))


@dataclass(frozen=True)
class Start:
    """Initial state of a body that does not start at rest, in axes rotated to its orientation.

    Parameters
    ----------
    place : tuple
        Position of the centre, m; z above the base.
    quaternion : tuple
        Rotation from the rest position (w, x, y, z).
    velocity, angular_velocity : tuple
        Velocity, m/s, and angular velocity, rad/s.
    """

    place: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)


@suggest_keywords()
@dataclass(frozen=True)
class Body(Model):
    """3-D model: one rigid body on a flat base; each orientation of the grid has the same weight.

    Parameters
    ----------
    shape : str, int or Shape
        "rectangle", "circle", the number of sides of a regular prism, or a polyhedron.
    contact : VertexContact
        Springs and dashpots at each vertex.
    start : Start, optional
        Initial state; at rest if not given.

    Raises
    ------
    ArgumentError
        If no shape has the given name, or the contact is not a `VertexContact`.
    """

    shape: Shape = field(default_factory=Rectangle)
    contact: VertexContact = field(default_factory=VertexContact)
    start: Start | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", shape_of(self.shape))
        if not isinstance(self.contact, VertexContact):
            raise ArgumentError(f"contact: a {type(self.contact).__name__}; a body in space has a VertexContact")

    variables: ClassVar = BODY_VARIABLES
    ensemble_variables: ClassVar = BODY_ENSEMBLE_VARIABLES
    comment: ClassVar = "overturned: 1 when the body falls, towards fall_azimuth, 0 when it stands"
    direction: ClassVar = "orientation"
    case_dims: ClassVar = ("height", "b_over_h", "aspect", "friction")
    copied: ClassVar = "repeated"
    one_component: ClassVar = False
    twists: ClassVar = True
    reads: ClassVar = ("overturned", "fall_azimuth", *_MEMBERS.values())
    reads_outcomes: ClassVar = (
        "overturned", "fall_azimuth", "residual_slip_north", "residual_slip_east", "residual_twist"
    )  # fmt: skip

    @property
    @override
    def elements(self) -> tuple[str, ...]:
        return (self.shape.name,)

    @property
    @override
    def cost(self) -> float:
        return 18.0

    @property
    @override
    def attributes(self) -> dict[str, str]:
        return {"body": self.shape.name}

    @property
    @override
    def further_variables(self) -> tuple[Variable, ...]:
        """A rectangle also has the prediction of the planes of its faces."""
        return FACE_VARIABLES if self.oblong else ()

    @property
    @override
    def sized(self) -> bool:
        return self.shape.sized

    @property
    @override
    def oblong(self) -> bool:
        return self.shape.oblong

    @override
    def sizes(self, height: ArrayLike | None, b_over_h: ArrayLike | None) -> tuple[ArrayLike, ArrayLike]:
        """A polyhedron has a slenderness and a height of its own."""
        if self.shape.sized:
            if b_over_h is None or height is None:
                name = "b_over_h" if b_over_h is None else "height"
                raise ArgumentError(f"{name}: not given; a {self.shape.name} has none of its own")
            return height, b_over_h
        if b_over_h is not None:
            raise ArgumentError(f"b_over_h: a {self.shape.name} has its own; leave it out")
        own = getattr(self.shape, "height", 1.0)
        return own if height is None else height, self.shape.body(own, 1.0, 1.0).b_over_h

    @override
    def periods(self, aspect: FloatArray) -> FloatArray:
        if not self.shape.oblong and aspect.tolist() != [1.0]:
            raise ArgumentError(f"aspect: {aspect.tolist()}; only a rectangle has one")
        return np.array([self.shape.body(1.0, 0.5, float(value)).period for value in aspect])

    @override
    def stiffer(self, factor: float) -> "Body":
        penetration = self.contact.static_penetration / factor
        return replace(self, contact=self.contact.model_copy(update={"static_penetration": penetration}))

    @override
    def sources(self, grid: Grid, symmetric: bool = True) -> Sources:
        """The computed case is rotated back by whole symmetry periods."""
        direction = grid.directions[:, None]
        period = self._periods(grid) if symmetric else np.full(1, FULL_TURN)
        whole = np.floor(direction / np.where(period > 0.0, period, 1.0))
        if symmetric and self.start is not None and np.where(period > 0.0, whole, direction).any():
            raise ArgumentError(
                "start: it turns with the body, so that orientations at which the body looks the same are cases of "
                "their own; say leave_out=False"
            )
        return replace(super().sources(grid, symmetric), turn_deg=np.where(period > 0.0, whole * period, direction))

    @override
    def rotate_outcomes(self, arrays: dict[str, NDArray[Any]], grid: Grid, sources: Sources) -> None:
        own = np.arange(sources.cell.shape[0])[:, None]
        arrays["repeated"] = grid.over_all(sources.cell != own).astype(np.int8)
        faces = len(self.shape.body(1.0, 0.5, 1.0).faces)
        turns = np.round(grid.over_all(sources.turn_deg) / FULL_TURN * max(faces, 1)).astype(np.int64)
        down = arrays["fall_face"] != INT8_MISSING
        arrays["fall_face"][down] = (arrays["fall_face"][down] - turns[down]) % max(faces, 1)

    @override
    def tally(
        self, flags: NDArray[np.int8], azimuth_deg: FloatArray, scramble: NDArray[np.int64]
    ) -> dict[str, NDArray[Any]]:
        """Compute the share of members that fall and the means of their directions."""
        known, fell, angle = flags != INT8_MISSING, flags == 1, np.radians(azimuth_deg)

        def mean(values: Any, chosen: Any = True) -> FloatArray:
            count = (known & chosen).sum(axis=1)
            # Rounded: cosines differ in the last digit between processors.
            total = np.round(np.where(fell & chosen, values, 0.0), 9).sum(axis=1)
            return np.where(count > 0, total / np.maximum(count, 1), np.nan)

        return {
            "probability_falls": mean(1.0),
            "fall_north": mean(np.cos(angle)),
            "fall_east": mean(np.sin(angle)),
            "fall_axis_cosine": mean(np.cos(2 * angle)),
            "fall_axis_sine": mean(np.sin(2 * angle)),
            "scramble_difference": mean(1.0, scramble == 0) - mean(1.0, scramble == 1),
            "members": known.sum(axis=1),
        }

    @override
    def representative(self, cube: "xr.Dataset") -> NDArray[np.intp]:
        return np.arange(cube.sizes[self.direction])

    @override
    def falls(self, cube: "xr.Dataset", *, ensemble: bool = True) -> "xr.Dataset":
        import xarray as xr

        known = answered(cube["overturned"])
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

    @override
    def spread(self, cube: "xr.Dataset") -> "xr.Dataset":
        """Members agree if all fall; they fall apart if they lie more than 15° about their mean."""
        import xarray as xr

        falls = cube["probability_falls"]
        length = xr.apply_ufunc(np.hypot, cube["fall_north"], cube["fall_east"]) / falls.where(falls > 0)
        agree = falls == 1
        return xr.Dataset(
            {
                "towards": falls,
                "away": 0.0 * falls,
                "agree": agree,
                "apart": agree & (length < MIN_AGREEMENT),
            }
        )

    @override
    def outcomes(self, site: "xr.Dataset", face_deg: FloatArray, cells: dict[str, NDArray[np.intp]]) -> Outcomes:
        """The outcome is that of the square prism with the nearest orientation."""
        square = site.isel(aspect=int(np.flatnonzero(site["aspect"].to_numpy() == 1.0)[0]))
        sources = nearest(site[self.direction].to_numpy(), face_deg, SQUARE_PERIOD)
        found = select_cells(square, self.reads_outcomes, {self.direction: sources.cell, **cells})
        flag = found["overturned"]
        slip = np.hypot(found["residual_slip_north"], found["residual_slip_east"])
        return Outcomes(flag == 1, np.isfinite(flag), found["fall_azimuth"], slip, found["residual_twist"])
