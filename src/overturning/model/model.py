"""Abstract model of the object on the ground: dimensions, outcome variables, symmetry and falls.

The kernels compute a model (`overturning.dem.run`). Studies, statistics, surveys, figures and report use this interface
only.
"""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import ArrayLike, FloatArray
from overturning.model.grid import CaseGrid
from overturning.model.symmetry import (
    FULL_TURN_DEG,
    SimulatedDirectionsForRequestedDirections,
    first_equivalent_of_each_direction,
)
from overturning.model.variables import OutcomeVariable

if TYPE_CHECKING:
    import xarray as xr


class StoneOutcomesByAmplitudeFactor(NamedTuple):
    """Outcomes of n stones under one record, for each amplitude factor of the motion: arrays (amplitudes, n)."""

    fell: NDArray[np.bool_]
    """True for a stone that fell."""
    trajectory_has_known_outcome: NDArray[np.bool_]
    """True where an outcome was found."""
    fall_azimuth_deg: FloatArray
    """Azimuth towards which a stone fell, degrees clockwise from north; NaN for a stone that stands."""
    residual_slip_m: FloatArray
    """Final distance of the base from its initial place, m; NaN for planar models, without slip across the plane."""
    residual_twist_deg: FloatArray
    """Final rotation about the vertical, degrees clockwise from above; NaN if the stone fell or the model has none."""

    def select_stones(self, stone_mask: NDArray[np.bool_]) -> "StoneOutcomesByAmplitudeFactor":
        """Return the outcomes of the stones at which a mask of shape (n,) is True."""
        chosen: Any = (values[:, stone_mask] for values in self)
        return StoneOutcomesByAmplitudeFactor(*chosen)


class Model(ABC):
    """Abstract base class of the 2-D and 3-D models of an object (block, scene, body or stack) on the ground.

    A subclass must be constructible without arguments, because a results cube does not store its parameters.
    """

    outcome_variables: ClassVar[tuple[OutcomeVariable, ...]]
    """Outcome variables."""
    ensemble_variables: ClassVar[tuple[OutcomeVariable, ...]]
    """Statistics over the ensemble of a case: runs with slightly changed input (see `ensemble_statistics_by_case`)."""
    overturned_variable_comment: ClassVar[str]
    """Meaning of ``overturned``, for the attributes of a cube."""
    direction_dimension_name: ClassVar[str]
    """Dimension of a cube along which the motion or the body is rotated about the vertical."""
    case_dims_without_direction: ClassVar[tuple[str, ...]]
    """Dimensions other than the record and the direction: size, slenderness, friction."""
    symmetry_copy_flag_variable_name: ClassVar[str]
    """Variable that is 1 where the outcome was copied from a symmetric cell."""
    is_planar: ClassVar[bool]
    """True for planar models: each direction has one component of the motion, and a fall goes to either side of it."""
    can_rotate_about_vertical: ClassVar[bool]
    """True if the model can rotate about the vertical."""
    variable_names_read_for_fall_probability: ClassVar[tuple[str, ...]]
    """Variables that `fall_probability_and_direction_by_case` reads, as far as a cube has them."""
    variable_names_read_for_square_stones: ClassVar[tuple[str, ...]]
    """Variables that `look_up_square_stone_outcomes` reads."""

    @property
    def dimension_names(self) -> tuple[str, ...]:
        """Names of the parameters that define a case: first azimuth or orientation, then height, B/H, friction…."""
        return (self.direction_dimension_name, *self.case_dims_without_direction)

    @property
    @abstractmethod
    def free_element_names(self) -> tuple[str, ...]:
        """Names of the elements that forces can move (neither driven nor held), in the order of the scene."""

    @property
    @abstractmethod
    def case_computing_time_over_that_of_2d_block(self) -> float:
        """Approximate computing time of a case, relative to that of a single 2-D block."""

    @property
    @abstractmethod
    def identifying_dataset_attributes(self) -> dict[str, str]:
        """Attributes that identify the model in a results dataset: the name of its scene or body."""

    @abstractmethod
    def height_and_b_over_h_or_defaults(
        self, height: ArrayLike | None, b_over_h: ArrayLike | None
    ) -> tuple[ArrayLike, ArrayLike]:
        """Return height (m) and B/H of the cases; the model's own size replaces None.

        Raises
        ------
        ArgumentError
            If a size is missing and the model has none of its own, or is given and cannot be chosen.
        """

    @abstractmethod
    def symmetry_periods_by_aspect_deg(self, depth_over_width: FloatArray) -> FloatArray:
        """Return the rotation (degrees) about the vertical after which the model looks the same, for each ratio D/B.

        The shape is (aspects,); the rotation is 0 for a body of revolution.
        """

    @abstractmethod
    def with_stiffness_factor(self, stiffness_factor: float) -> "Model":
        """Return a copy of the model whose contact stiffness is multiplied by `stiffness_factor`."""

    @property
    def outcome_variables_of_2d_runs_in_face_planes(self) -> tuple[OutcomeVariable, ...]:
        """Outcome variables of additional 2-D simulations in the planes of a body's faces; none by default."""
        return ()

    @property
    def slenderness_is_parameter(self) -> bool:
        """True if the slenderness B/H can be chosen for each case; False if the body's shape fixes it."""
        return True

    @property
    def depth_over_width_is_parameter(self) -> bool:
        """True if the aspect ratio D/B of the base can be chosen for each case."""
        return False

    @property
    def azimuth_period_attribute_in_2d_or_empty(self) -> dict[str, float]:
        """Attribute ``period`` (degrees) of the azimuth coordinate of a 2-D results dataset, by name; empty in 3-D."""
        return {}

    def keep_one_friction_if_scene_sets_all(self, grid: CaseGrid) -> CaseGrid:
        """Reduce a grid to its first friction if the scene sets all frictions (equal cases); else keep all."""
        return grid

    def simulated_direction_for_each_direction(
        self, grid: CaseGrid, use_symmetry: bool = True
    ) -> SimulatedDirectionsForRequestedDirections:
        """Return, for each direction of a grid, the direction equivalent by symmetry that is simulated instead.

        Parameters
        ----------
        grid : CaseGrid
            Cases.
        use_symmetry : bool
            Use the symmetry of the model; otherwise only directions a full turn apart are equivalent.

        Returns
        -------
        SimulatedDirectionsForRequestedDirections
            Simulated directions; arrays of shape (directions, 1) or (directions, aspects).
        """
        return first_equivalent_of_each_direction(
            grid.direction_values_deg,
            self._symmetry_periods_of_grid_aspects_deg(grid) if use_symmetry else FULL_TURN_DEG,
        )

    def _symmetry_periods_of_grid_aspects_deg(self, grid: CaseGrid) -> FloatArray:
        """Return the symmetry period (degrees) for each aspect D/B of a grid; shape (1,) for a grid without aspects."""
        return self.symmetry_periods_by_aspect_deg(grid["aspect"] if "aspect" in grid.dimension_names else np.ones(1))

    @abstractmethod
    def adapt_and_mark_copied_outcomes_in_place(
        self,
        outcome_arrays: dict[str, NDArray[Any]],
        grid: CaseGrid,
        equivalent_directions: SimulatedDirectionsForRequestedDirections,
    ) -> None:
        """Rotate, in place, outcomes copied from a direction equivalent by symmetry, and mark them as copies."""

    @abstractmethod
    def ensemble_statistics_by_case(
        self,
        fall_flag_by_case_and_member: NDArray[np.int8],
        fall_azimuth_by_case_and_member_deg: FloatArray,
        sobol_scramble_of_member: NDArray[np.int64],
    ) -> dict[str, NDArray[Any]]:
        """Compute statistics over the ensemble runs of each case, such as the share of runs in which the stone falls.

        Parameters
        ----------
        fall_flag_by_case_and_member : ndarray of int8, shape (cells, members) or (cells, members, elements)
            Outcome of each member.
        fall_azimuth_by_case_and_member_deg : ndarray, shape (cells, members)
            Azimuth of the fall in 3-D, degrees.
        sobol_scramble_of_member : ndarray of int, shape (members,)
            Number of the scrambled Sobol sequence of each member.
        """

    @abstractmethod
    def distinct_direction_indices(self, cube: "xr.Dataset") -> NDArray[np.intp]:
        """Return indices of directions in a results dataset, one for each set of directions equivalent by symmetry."""

    @abstractmethod
    def fall_probability_and_direction_by_case(self, cube: "xr.Dataset", *, use_ensemble: bool = True) -> "xr.Dataset":
        """Return fall probability and mean fall direction of each case, without copies of other cases by symmetry.

        Parameters
        ----------
        cube : Dataset
            Cube with the variables of `variable_names_read_for_fall_probability`, as stored or decoded.
        use_ensemble : bool
            Use the ensemble members of a case where they were run; otherwise the nominal outcome.

        Returns
        -------
        Dataset
            ``falls``, the probability of falling; ``direction_cosine``, ``direction_sine``, ``axis_cosine`` and
            ``axis_sine``, expected values of cos φ, sin φ, cos 2φ and sin 2φ of the azimuth φ of the fall, 0 where
            nothing falls. All are missing where the outcome is missing, and lazy if the cube is. ``weight``: weight of
            each direction in means over directions; the weights sum to 1.
        """

    @abstractmethod
    def ensemble_fall_shares_by_side_and_case(self, cube: "xr.Dataset") -> "xr.Dataset":
        """Return the shares of ensemble runs that fall to either side, for each case that is no copy by symmetry.

        Returns
        -------
        Dataset
            ``towards`` and ``away``: shares of the runs that fall towards the azimuth and away from it, missing
            without runs. In 3-D, ``towards`` is the share of all falls and ``away`` is 0; ``agree`` is True where all
            runs fall, ``apart`` where they all fall but in different directions.
        """

    @abstractmethod
    def look_up_square_stone_outcomes(
        self,
        one_record_cube: "xr.Dataset",
        front_azimuth_by_stone_deg: FloatArray,
        grid_indices_by_dimension: dict[str, NDArray[np.intp]],
    ) -> StoneOutcomesByAmplitudeFactor:
        """Look up the outcome of each square stone in simulated results, at its size and at the nearest direction.

        Parameters
        ----------
        one_record_cube : Dataset
            Cube of one record, with or without the dimension of amplitudes.
        front_azimuth_by_stone_deg : ndarray, shape (n,)
            Azimuth that the front of each stone faces, degrees.
        grid_indices_by_dimension : dict of ndarray, shape (n,)
            Indices of each stone along height, B/H and friction in the cube.
        """


def values_at_grid_indices(
    one_record_cube: "xr.Dataset",
    variable_names: tuple[str, ...],
    grid_indices_by_dimension: dict[str, NDArray[np.intp]],
) -> dict[str, FloatArray]:
    """Return the values of some variables, by name, at given grid indices in the results dataset of one record.

    Each array has one row per amplitude; its further dimensions are those of the index arrays.
    """
    several = ["amplitude"] if "amplitude" in one_record_cube.dims else []
    place = (slice(None) if several else None, *grid_indices_by_dimension.values())
    return {
        name: np.asarray(
            one_record_cube[name].transpose(*several, *grid_indices_by_dimension).to_numpy()[place], np.float64
        )
        for name in variable_names
    }
