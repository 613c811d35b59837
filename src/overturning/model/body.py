"""3-D model: a rigid body that moves with all components of the motion and can fall towards any azimuth."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from overturning.arrays import ArrayLike, FloatArray
from overturning.errors import ArgumentError, suggest_closest_keyword
from overturning.model.contact import VertexContact
from overturning.model.grid import Grid
from overturning.model.model import Model, StoneOutcomes, values_at_cells
from overturning.model.shapes import RectangularPrism, Shape, shape_from_name_or_sides
from overturning.model.symmetry import FULL_TURN, ComputedCells, nearest_computed_cells
from overturning.model.variables import (
    BODY_ENSEMBLE_VARIABLES,
    BODY_VARIABLES,
    FACE_VARIABLES,
    INT8_MISSING,
    OutcomeVariable,
    outcome_is_known,
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
"""Cube variables with ensemble means, by name of the variable of `Model.fall_probability_and_direction_by_cell`."""


def cell_weight_in_direction_statistics(
    fall_share: ArrayLike, mean_fall_north: ArrayLike, mean_fall_east: ArrayLike, member_count: ArrayLike
) -> FloatArray:
    """Return each cell's weight in direction statistics: 1 if all its members fall one way, 0 if in all directions.

    The square of the mean resultant length R of k members that fall exceeds that of the directions they are drawn from:
    without any common direction k R² is 1 on average. So the weight is √((k R² − 1)/(k − 1)), 0 where that is
    negative and 1 where fewer than two members fall, as they tell nothing of a spread.

    Parameters
    ----------
    fall_share, mean_fall_north, mean_fall_east : array_like
        ``probability_falls``, ``fall_north`` and ``fall_east``; NaN where no member was run.
    member_count : array_like
        Members with an outcome.
    """
    fell = np.nan_to_num(np.asarray(fall_share, np.float64))
    count = fell * np.asarray(member_count, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        square = (np.asarray(mean_fall_north, np.float64) ** 2 + np.asarray(mean_fall_east, np.float64) ** 2) / fell**2
        known = np.sqrt(np.clip((count * square - 1.0) / (count - 1.0), 0.0, 1.0))
    return np.asarray(np.where(count > 1.5, known, 1.0))


@dataclass(frozen=True)
class Start:
    """Initial position and velocity of a 3-D body that does not start at rest, in axes that turn with the orientation.

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


@suggest_closest_keyword()
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

    shape: Shape = field(default_factory=RectangularPrism)
    contact: VertexContact = field(default_factory=VertexContact)
    start: Start | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", shape_from_name_or_sides(self.shape))
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
    def free_element_names(self) -> tuple[str, ...]:
        return (self.shape.name,)

    @property
    @override
    def case_cost_over_block_cost(self) -> float:
        return 18.0

    @property
    @override
    def scene_or_body_attributes(self) -> dict[str, str]:
        return {"body": self.shape.name}

    @property
    @override
    def study_variables_besides_outcomes(self) -> tuple[OutcomeVariable, ...]:
        """Variables of the 2-D prediction in the vertical planes of a rectangle's faces; empty for other shapes."""
        return FACE_VARIABLES if self.aspect_is_parameter else ()

    @property
    @override
    def slenderness_is_parameter(self) -> bool:
        return self.shape.slenderness_is_parameter

    @property
    @override
    def aspect_is_parameter(self) -> bool:
        return self.shape.aspect_is_parameter

    @override
    def height_and_b_over_h_or_defaults(
        self, height: ArrayLike | None, b_over_h: ArrayLike | None
    ) -> tuple[ArrayLike, ArrayLike]:
        """Return the given height (m) and B/H; a polyhedron has its own B/H, and its own height by default."""
        if self.shape.slenderness_is_parameter:
            if b_over_h is None or height is None:
                name = "b_over_h" if b_over_h is None else "height"
                raise ArgumentError(f"{name}: not given; a {self.shape.name} has none of its own")
            return height, b_over_h
        if b_over_h is not None:
            raise ArgumentError(f"b_over_h: a {self.shape.name} has its own; leave it out")
        own = getattr(self.shape, "unscaled_height", 1.0)
        return own if height is None else height, self.shape.solid(own, 1.0, 1.0).b_over_h

    @override
    def rotation_periods_deg(self, aspect: FloatArray) -> FloatArray:
        if not self.shape.aspect_is_parameter and aspect.tolist() != [1.0]:
            raise ArgumentError(f"aspect: {aspect.tolist()}; only a rectangle has one")
        return np.array([self.shape.solid(1.0, 0.5, float(value)).period for value in aspect])

    @override
    def with_stiffness_factor(self, stiffness_factor: float) -> "Body":
        penetration = self.contact.static_penetration / stiffness_factor
        return replace(self, contact=self.contact.model_copy(update={"static_penetration": penetration}))

    @override
    def computed_cell_of_each_direction(self, grid: Grid, use_symmetry: bool = True) -> ComputedCells:
        """Return, for each orientation of a grid, the computed orientation, a whole number of rotation periods away."""
        direction = grid.direction_values_deg[:, None]
        period = self._rotation_periods_of_grid_deg(grid) if use_symmetry else np.full(1, FULL_TURN)
        whole = np.floor(direction / np.where(period > 0.0, period, 1.0))
        if use_symmetry and self.start is not None and np.where(period > 0.0, whole, direction).any():
            raise ArgumentError(
                "start: it turns with the body, so that orientations at which the body looks the same are cases of "
                "their own; say leave_out=False"
            )
        return replace(
            super().computed_cell_of_each_direction(grid, use_symmetry),
            turn_deg=np.where(period > 0.0, whole * period, direction),
        )

    @override
    def rotate_copied_outcomes_in_place(
        self, outcome_arrays: dict[str, NDArray[Any]], grid: Grid, computed_cells: ComputedCells
    ) -> None:
        own = np.arange(computed_cells.cell.shape[0])[:, None]
        outcome_arrays["repeated"] = grid.broadcast_over_grid(computed_cells.cell != own).astype(np.int8)
        faces = len(self.shape.solid(1.0, 0.5, 1.0).faces)
        turns = np.round(grid.broadcast_over_grid(computed_cells.turn_deg) / FULL_TURN * max(faces, 1)).astype(np.int64)
        down = outcome_arrays["fall_face"] != INT8_MISSING
        outcome_arrays["fall_face"][down] = (outcome_arrays["fall_face"][down] - turns[down]) % max(faces, 1)

    @override
    def ensemble_variables_of_cells(
        self, member_flags: NDArray[np.int8], fall_azimuth_deg: FloatArray, sobol_scramble_of_member: NDArray[np.int64]
    ) -> dict[str, NDArray[Any]]:
        """Compute the share of ensemble members that fall and the mean sines and cosines of their fall directions."""
        known, fell, angle = member_flags != INT8_MISSING, member_flags == 1, np.radians(fall_azimuth_deg)
        first, second = (
            (sobol_scramble_of_member == number).reshape(-1, *(1,) * (known.ndim - 2)) for number in (0, 1)
        )

        def member_mean(member_values: Any, selected_members: Any = True) -> FloatArray:
            """Return each cell's mean over the selected members with an outcome; a standing member counts as 0."""
            count = (known & selected_members).sum(axis=1)
            # Rounded: cosines differ in the last digit between processors.
            total = np.round(np.where(fell & selected_members, member_values, 0.0), 9).sum(axis=1)
            return np.where(count > 0, total / np.maximum(count, 1), np.nan)

        return {
            "probability_falls": member_mean(1.0),
            "fall_north": member_mean(np.cos(angle)),
            "fall_east": member_mean(np.sin(angle)),
            "fall_axis_cosine": member_mean(np.cos(2 * angle)),
            "fall_axis_sine": member_mean(np.sin(2 * angle)),
            "scramble_difference": member_mean(1.0, first) - member_mean(1.0, second),
            "members": known.sum(axis=1),
        }

    @override
    def distinct_direction_indices(self, cube: "xr.Dataset") -> NDArray[np.intp]:
        return np.arange(cube.sizes[self.direction])

    @override
    def fall_probability_and_direction_by_cell(self, cube: "xr.Dataset", *, use_ensemble: bool = True) -> "xr.Dataset":
        import xarray as xr

        known = outcome_is_known(cube["overturned"])
        fell = (cube["overturned"] == 1).where(known)
        azimuth = cube["fall_azimuth"].astype("float64") * (np.pi / 180.0)
        found = {"falls": fell.astype("float64")}
        for kind, angle in (("direction", azimuth), ("axis", 2.0 * azimuth)):
            for name, of in (("cosine", np.cos), ("sine", np.sin)):
                values = xr.apply_ufunc(of, angle, dask="allowed")
                found[f"{kind}_{name}"] = values.where(fell == 1, 0.0).where(known)
        if use_ensemble and "probability_falls" in cube:
            found = {name: cube[_MEMBERS[name]].astype("float64").fillna(values) for name, values in found.items()}
        count = cube.sizes[self.direction]
        return xr.Dataset({**found, "weight": (self.direction, np.full(count, 1.0 / count))})

    @override
    def member_fall_shares_by_cell(self, cube: "xr.Dataset") -> "xr.Dataset":
        """Return, for each cell, the share of members that fall, and whether the directions of their falls differ.

        Directions differ if they spread by more than 15° about their mean.
        """
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
    def square_stone_outcomes(
        self, site_cube: "xr.Dataset", face_azimuth_deg: FloatArray, cell_positions: dict[str, NDArray[np.intp]]
    ) -> StoneOutcomes:
        """Return, for each stone, the outcome of the square prism with the nearest orientation in a cube."""
        square = site_cube.isel(aspect=int(np.flatnonzero(site_cube["aspect"].to_numpy() == 1.0)[0]))
        sources = nearest_computed_cells(site_cube[self.direction].to_numpy(), face_azimuth_deg, SQUARE_PERIOD)
        found = values_at_cells(square, self.reads_outcomes, {self.direction: sources.cell, **cell_positions})
        flag = found["overturned"]
        slip = np.hypot(found["residual_slip_north"], found["residual_slip_east"])
        return StoneOutcomes(flag == 1, np.isfinite(flag), found["fall_azimuth"], slip, found["residual_twist"])
