"""3-D model of a stack: each stone stands on the one below, and the lowest stone on the ground."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError, refuse_unknown_keywords
from overturning.model.contact import VertexContact
from overturning.model.geometry import azimuth_period_of_outcome_deg
from overturning.model.grid import CaseGrid
from overturning.model.scene import Scene, gravestone
from overturning.model.scene_model import SceneModel
from overturning.model.space import ThreeDimensionalModel
from overturning.model.stack_checks import check_scene_can_be_simulated_as_3d_stack
from overturning.model.stack_stones import POLYGON_SIDES_FOR_CIRCLE, StackStone, stack_stones
from overturning.model.symmetry import FULL_TURN_DEG, SimulatedDirectionsForRequestedDirections
from overturning.model.variables import BODY_ENSEMBLE_VARIABLES, BODY_OUTCOME_VARIABLES, OutcomeVariable

_NAMES_OF_VARIABLES_PER_STONE: Final = {
    "overturned", "fall_azimuth", "peak_tilt", "overturning_time", "residual_slip_north", "residual_slip_east",
    "residual_twist",
}  # fmt: skip
_LONG_NAMES_THAT_DIFFER_FOR_STACK: Final = {
    "peak_tilt": "largest angle between the stone's axis and the vertical",
    "residual_slip_north": "northward displacement, at the end, of the base on the face below from its place at rest",
    "residual_slip_east": "eastward displacement, at the end, of the base on the face below from its place at rest",
    "residual_twist": "rotation at the end relative to what the stone stands on, clockwise from above",
}

STACK_OUTCOME_VARIABLES: Final = (
    *(
        replace(
            item, has_element_dimension=item.name in _NAMES_OF_VARIABLES_PER_STONE,
            long_name=_LONG_NAMES_THAT_DIFFER_FOR_STACK.get(item.name, item.long_name),
        )
        for item in BODY_OUTCOME_VARIABLES
        if item.name not in {"fall_face", "peak_slip", "angular_momentum_error"}
    ),
    OutcomeVariable(
        "slid_off", "i1", "whether the stone fell because it slid over the rim of what it stands on", "1", True,
        further_cf_attributes={
            "flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "stands_or_tips slides_off",
        },
    ),
)  # fmt: skip
"""Outcome variables of a stack."""


def default_stack_scene() -> Scene:
    """Return the default scene of a stack: one gravestone on the ground, 0.24 m wide and deep, 0.6 m high."""
    scene = gravestone()
    ground, stone = scene.elements
    return scene.model_copy(update={"elements": (ground, stone.model_copy(update={"depth": stone.width}))})


@refuse_unknown_keywords()
@dataclass(frozen=True)
class Stack(SceneModel, ThreeDimensionalModel):
    """3-D model of a stack of stones, each of which stands with its base on the upper face of the stone below.

    Parameters
    ----------
    scene : Scene
        Scene of a ground and of free elements with a `depth`, each of which stands on the element listed before it.
    contact : VertexContact
        Springs and dashpots of the joints.

    Raises
    ------
    ArgumentError
        If the scene cannot be simulated as a stack, or an argument has another type.
    """

    scene: Scene = field(default_factory=default_stack_scene)
    contact: VertexContact = field(default_factory=VertexContact)

    def __post_init__(self) -> None:
        if not isinstance(self.scene, Scene):
            raise ArgumentError(f"scene: {self.scene!r}; give a scene, such as load_scene('three-tier')")
        if not isinstance(self.contact, VertexContact):
            raise ArgumentError(f"contact: {self.contact!r}; a stack in 3-D has a VertexContact")
        check_scene_can_be_simulated_as_3d_stack(self.scene)

    outcome_variables: ClassVar = STACK_OUTCOME_VARIABLES
    ensemble_variables: ClassVar = tuple(
        replace(item, has_element_dimension=item.name != "members") for item in BODY_ENSEMBLE_VARIABLES
    )
    overturned_variable_comment: ClassVar = "overturned: 1 when a stone falls, towards fall_azimuth, 0 when it stands"
    case_dims_without_direction: ClassVar = ("height", "b_over_h", "friction")

    @property
    @override
    def case_computing_time_over_that_of_2d_block(self) -> float:
        """Computing time of a case relative to a 2-D block: the sum over stones of 60 · (base corners / 4)³.

        A circular base counts as 16 corners. A base that rolls on many corners needs a short step for each corner that
        opens or closes, and each step takes longer.
        """
        return 60.0 * sum((stone.base_corners_xy_from_centre_of_mass.shape[0] / 4.0) ** 3 for stone in self.stones())

    @override
    def symmetry_periods_by_aspect_deg(self, depth_over_width: FloatArray) -> FloatArray:
        if depth_over_width.tolist() != [1.0]:
            raise ArgumentError(f"aspect: {depth_over_width.tolist()}; a stack has the depths of its scene")
        return np.array([self.rotational_symmetry_period_deg])

    @property
    def rotational_symmetry_period_deg(self) -> float:
        """Rotation about the vertical after which the stack looks the same, degrees; 90 if all bases are square."""
        if azimuth_period_of_outcome_deg(self.scene) == FULL_TURN_DEG:
            return FULL_TURN_DEG
        # Equal parts of a turn after which all stones look the same; a circle looks the same after any.
        parts = math.gcd(*(stone.rotational_symmetry_order for stone in self.stones()))
        return FULL_TURN_DEG / (parts or POLYGON_SIDES_FOR_CIRCLE)

    @override
    def with_stiffness_factor(self, stiffness_factor: float) -> "Stack":
        penetration = self.contact.static_penetration / stiffness_factor
        return replace(self, contact=self.contact.model_copy(update={"static_penetration": penetration}))

    @override
    def keep_one_friction_if_scene_sets_all(self, grid: CaseGrid) -> CaseGrid:
        return (
            grid
            if self.scene.has_contact_with_unset_friction
            else grid.copy_with_dimension_values(friction=grid["friction"][:1])
        )

    @override
    def simulated_direction_for_each_direction(
        self, grid: CaseGrid, use_symmetry: bool = True
    ) -> SimulatedDirectionsForRequestedDirections:
        """Return, for each orientation of a grid, the equivalent one to simulate and the rotation from it."""
        period = self._symmetry_periods_of_grid_aspects_deg(grid) if use_symmetry else np.full(1, FULL_TURN_DEG)
        turn = np.floor(grid.direction_values_deg[:, None] / period) * period
        return replace(
            super().simulated_direction_for_each_direction(grid, use_symmetry),
            clockwise_rotation_from_simulated_deg=turn,
        )

    # Once an element is selected, the cube of a stack has the variables of the cube of a body.

    @override
    def ensemble_statistics_by_case(
        self,
        fall_flag_by_case_and_member: NDArray[np.int8],
        fall_azimuth_by_case_and_member_deg: FloatArray,
        sobol_scramble_of_member: NDArray[np.int64],
    ) -> dict[str, NDArray[Any]]:
        found = super().ensemble_statistics_by_case(
            fall_flag_by_case_and_member, fall_azimuth_by_case_and_member_deg, sobol_scramble_of_member
        )
        members = found["members"]
        return found | {"members": members if members.ndim == 1 else members.min(axis=1)}

    def stones(self, height: float | None = None, b_over_h: float | None = None) -> list[StackStone]:
        """Return the stones of the stack, lowest first, scaled to a height (m) and B/H of the reference element."""
        return stack_stones(self.scene, height, b_over_h)
