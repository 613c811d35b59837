"""3-D model: a rigid body that moves with all components of the motion and can fall towards any azimuth."""

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from overturning.arrays import ArrayLike, FloatArray, convert_argument_to_finite_array
from overturning.errors import ArgumentError, refuse_unknown_keywords
from overturning.model.contact import VertexContact
from overturning.model.grid import CaseGrid
from overturning.model.scan import ScannedStone
from overturning.model.shapes import RectangularPrism, Shape, shape_from_name_or_sides
from overturning.model.space import ThreeDimensionalModel
from overturning.model.symmetry import FULL_TURN_DEG, SimulatedDirectionsForRequestedDirections
from overturning.model.variables import (
    BODY_ENSEMBLE_VARIABLES,
    BODY_OUTCOME_VARIABLES,
    INT8_MISSING,
    OUTCOME_VARIABLES_OF_2D_RUNS_IN_FACE_PLANES,
    OutcomeVariable,
)


@dataclass(frozen=True)
class InitialState:
    """Initial position and velocity of a 3-D body that starts moving or tilted, in axes that turn with its orientation.

    Parameters
    ----------
    centre_position : tuple
        Position of the centre, m; z above the base.
    rest_to_initial_quaternion_wxyz : tuple
        Rotation from the rest position (w, x, y, z).
    centre_velocity, angular_velocity : tuple
        Velocity of the centre, m/s, and angular velocity, rad/s.

    Raises
    ------
    ArgumentError
        If a tuple has another length, or a number that is not finite.
    """

    centre_position: tuple[float, float, float]
    rest_to_initial_quaternion_wxyz: tuple[float, float, float, float]
    centre_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        counts = {
            "centre_position": 3,
            "rest_to_initial_quaternion_wxyz": 4,
            "centre_velocity": 3,
            "angular_velocity": 3,
        }
        for name, count in counts.items():
            values = convert_argument_to_finite_array(name, getattr(self, name), (count,))
            object.__setattr__(self, name, tuple(values.tolist()))


@refuse_unknown_keywords()
@dataclass(frozen=True)
class Body(ThreeDimensionalModel):
    """3-D model of one rigid body on a flat base; statistics weight its initial orientations equally.

    Parameters
    ----------
    shape : str, int or Shape
        "rectangle", "circle", the number of sides of a regular prism, or a polyhedron.
    contact : VertexContact
        Springs and dashpots at each vertex.
    start : InitialState, optional
        Initial state; at rest if not given.

    Raises
    ------
    ArgumentError
        If no shape has the given name, the contact is not a `VertexContact`, or the start not an `InitialState`.
    """

    shape: Shape = field(default_factory=RectangularPrism)
    contact: VertexContact = field(default_factory=VertexContact)
    start: InitialState | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", shape_from_name_or_sides(self.shape, "shape"))
        if not isinstance(self.contact, VertexContact):
            raise ArgumentError(f"contact: a {type(self.contact).__name__}; a 3-D body has a VertexContact")
        if not isinstance(self.start, InitialState | None):
            raise ArgumentError(f"start: a {type(self.start).__name__}; give an InitialState, or nothing")

    outcome_variables: ClassVar = BODY_OUTCOME_VARIABLES
    ensemble_variables: ClassVar = BODY_ENSEMBLE_VARIABLES
    overturned_variable_comment: ClassVar = "overturned: 1 when the body falls, towards fall_azimuth, 0 when it stands"
    case_dims_without_direction: ClassVar = ("height", "b_over_h", "aspect", "friction")

    @property
    @override
    def free_element_names(self) -> tuple[str, ...]:
        return (self.shape.name,)

    @property
    @override
    def case_computing_time_over_that_of_2d_block(self) -> float:
        return 18.0

    @property
    @override
    def identifying_dataset_attributes(self) -> dict[str, str]:
        return {"body": self.shape.name}

    @property
    @override
    def outcome_variables_of_2d_runs_in_face_planes(self) -> tuple[OutcomeVariable, ...]:
        """Outcome variables of the 2-D simulations in the vertical planes of a rectangular body's faces.

        Empty for other shapes.
        """
        return OUTCOME_VARIABLES_OF_2D_RUNS_IN_FACE_PLANES if self.depth_over_width_is_parameter else ()

    @property
    @override
    def slenderness_is_parameter(self) -> bool:
        return self.shape.slenderness_is_parameter

    @property
    @override
    def depth_over_width_is_parameter(self) -> bool:
        return self.shape.depth_over_width_is_parameter

    @override
    def height_and_b_over_h_or_defaults(
        self, height: ArrayLike | None, b_over_h: ArrayLike | None
    ) -> tuple[ArrayLike, ArrayLike]:
        """Return the given height (m) and B/H; a polyhedron has a fixed B/H, and a default height if None is given."""
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
    def symmetry_periods_by_aspect_deg(self, depth_over_width: FloatArray) -> FloatArray:
        if not self.shape.depth_over_width_is_parameter and depth_over_width.tolist() != [1.0]:
            raise ArgumentError(f"aspect: {depth_over_width.tolist()}; only a rectangle has one")
        return np.array([self.shape.solid(1.0, 0.5, float(value)).symmetry_period_deg for value in depth_over_width])

    def with_base_relief(self, max_load_bearing_base_point_height_m: float) -> "Body":
        """Return a copy of a scanned stone with another relief, the height (m) up to which base points bear load."""
        if not isinstance(self.shape, ScannedStone):
            raise ArgumentError(f"relief: a {self.shape.name} has none; only a scanned stone has")
        return replace(self, shape=self.shape.with_base_relief(max_load_bearing_base_point_height_m))

    @override
    def with_stiffness_factor(self, stiffness_factor: float) -> "Body":
        penetration = self.contact.static_penetration / stiffness_factor
        return replace(self, contact=self.contact.model_copy(update={"static_penetration": penetration}))

    @override
    def simulated_direction_for_each_direction(
        self, grid: CaseGrid, use_symmetry: bool = True
    ) -> SimulatedDirectionsForRequestedDirections:
        """Return, for each orientation of a grid, an orientation to simulate instead, equivalent by symmetry."""
        direction = grid.direction_values_deg[:, None]
        period = self._symmetry_periods_of_grid_aspects_deg(grid) if use_symmetry else np.full(1, FULL_TURN_DEG)
        whole = np.floor(direction / np.where(period > 0.0, period, 1.0))
        if use_symmetry and self.start is not None and np.where(period > 0.0, whole, direction).any():
            raise ArgumentError(
                "start: it turns with the body, so that orientations at which the body looks the same are cases of "
                "their own; say leave_out=False"
            )
        return replace(
            super().simulated_direction_for_each_direction(grid, use_symmetry),
            clockwise_rotation_from_simulated_deg=np.where(period > 0.0, whole * period, direction),
        )

    @override
    def adapt_and_mark_copied_outcomes_in_place(
        self,
        outcome_arrays: dict[str, NDArray[Any]],
        grid: CaseGrid,
        equivalent_directions: SimulatedDirectionsForRequestedDirections,
    ) -> None:
        super().adapt_and_mark_copied_outcomes_in_place(outcome_arrays, grid, equivalent_directions)
        faces = len(self.shape.solid(1.0, 0.5, 1.0).resting_face_normals_after_fall)
        turns = np.round(
            grid.broadcast_over_grid(equivalent_directions.clockwise_rotation_from_simulated_deg)
            / FULL_TURN_DEG
            * max(faces, 1)
        ).astype(np.int64)
        down = outcome_arrays["fall_face"] != INT8_MISSING
        outcome_arrays["fall_face"][down] = (outcome_arrays["fall_face"][down] - turns[down]) % max(faces, 1)
