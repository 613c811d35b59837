"""2-D model: a block or a scene in the vertical plane of each azimuth.

A scene with mirror symmetry has the same outcome, mirrored, under the motions along φ and φ + 180°, so shares, means
and roses count each plane once; for any other scene both are separate cases. The azimuths of one record are the same
ground motion seen from many sides, not independent samples: no function of this module returns a p-value.
"""

from dataclasses import dataclass, field, replace
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError, ResultError
from overturning.model.edges import fall_flag_and_azimuth_from_planes
from overturning.model.geometry import azimuth_period_of_outcome_deg
from overturning.model.grid import CaseGrid
from overturning.model.model import StoneOutcomesByAmplitudeFactor, values_at_grid_indices
from overturning.model.plane_weights import (
    distinct_plane_indices,
    plane_azimuth_period_deg,
    plane_weights_by_azimuth_spacing,
)
from overturning.model.scene import Scene, gravestone
from overturning.model.scene_model import SceneModel
from overturning.model.symmetry import (
    SimulatedDirectionsForRequestedDirections,
    copy_with_mirrored_planes_marked,
    nearest_simulated_planes,
)
from overturning.model.variables import (
    INT8_MISSING,
    PLANAR_OUTCOME_VARIABLES,
    PLANE_ENSEMBLE_VARIABLES,
    mask_of_known_outcomes,
)

if TYPE_CHECKING:
    import xarray as xr

VARIABLE_NAMES_READ_FOR_FALL_PROBABILITY = ("overturned", "probability_towards", "probability_away")
"""Variables of a cube that `fall_probabilities_towards_and_away` reads."""


def fall_probabilities_towards_and_away(cube: "xr.Dataset", *, use_ensemble: bool = True) -> "xr.Dataset":
    """Return, for each case of a 2-D results dataset, the probabilities of falls towards azimuths φ and φ + 180°.

    Parameters
    ----------
    cube : Dataset
        Results; ``overturned`` as stored or decoded.
    use_ensemble : bool
        Use the ensemble's probabilities where the cube has them; elsewhere 0 or 1 from ``overturned``.

    Returns
    -------
    Dataset
        ``towards`` and ``away`` (float32, dimensions of ``overturned``; NaN where the outcome is missing); lazy
        arrays if those of the cube are lazy.

    Raises
    ------
    ResultError
        If the dataset has no variable ``overturned``.
    """
    if "overturned" not in cube:
        raise ResultError("the dataset has no variable 'overturned'; it is not a cube of this program")
    import xarray as xr

    stored = cube["overturned"]
    flag, made = stored.variable, {}  # variables have no coordinates, which need not be compared at each operation
    known = mask_of_known_outcomes(flag)
    for sign, name, where in ((1, "towards", "azimuth"), (-1, "away", "azimuth + 180°")):
        chance = (flag == sign).where(known).astype("float32")
        if use_ensemble and "probability_towards" in cube:
            chance = cube[f"probability_{name}"].variable.astype("float32").fillna(chance)
        chance.attrs = {"long_name": f"probability of falling towards the {where}", "units": "1"}
        made[name] = chance
    return xr.Dataset(made, stored.coords)


@dataclass(frozen=True)
class PlanarModel(SceneModel):
    """2-D model: a block or a scene that moves in a vertical plane, one plane for each azimuth."""

    scene: Scene = field(default_factory=gravestone)

    outcome_variables: ClassVar = PLANAR_OUTCOME_VARIABLES
    ensemble_variables: ClassVar = PLANE_ENSEMBLE_VARIABLES
    overturned_variable_comment: ClassVar = (
        "overturned: +1 when the block falls towards the azimuth, -1 towards azimuth + 180 degrees, 0 when it stands"
    )
    direction_dimension_name: ClassVar = "azimuth"
    case_dims_without_direction: ClassVar = ("height", "b_over_h", "friction")
    symmetry_copy_flag_variable_name: ClassVar = "mirrored"
    is_planar: ClassVar = True
    can_rotate_about_vertical: ClassVar = False
    variable_names_read_for_fall_probability: ClassVar = VARIABLE_NAMES_READ_FOR_FALL_PROBABILITY
    variable_names_read_for_square_stones: ClassVar = ("overturned", "overturning_time")

    @property
    @override
    def case_computing_time_over_that_of_2d_block(self) -> float:
        """Computing time of a case over that of a 2-D block: 1 with one free element, otherwise 5 per free element."""
        return 1.0 if len(self.free_element_names) == 1 else 5.0 * len(self.free_element_names)

    @property
    @override
    def azimuth_period_attribute_in_2d_or_empty(self) -> dict[str, float]:
        return {"period": azimuth_period_of_outcome_deg(self.scene)}

    @override
    def symmetry_periods_by_aspect_deg(self, depth_over_width: FloatArray) -> FloatArray:
        if (depth_over_width != 1.0).any():
            raise ArgumentError(f"aspect: {depth_over_width.tolist()}; only a rectangle in space has one")
        return np.array([azimuth_period_of_outcome_deg(self.scene)])

    @override
    def with_stiffness_factor(self, stiffness_factor: float) -> "PlanarModel":
        """Return a copy of the model with all contact stiffnesses, also default ones, multiplied by a factor."""
        laws = []
        for pair in combinations_with_replacement(self.scene.materials, 2):
            law = self.scene.contact_law_of_materials(*pair)
            changed: dict[str, float] = {"static_penetration": law.static_penetration / stiffness_factor}
            if law.stiffness != "auto":
                changed = {"stiffness": law.stiffness * stiffness_factor}
            laws.append(law.model_copy(update=changed))
        return replace(self, scene=self.scene.model_copy(update={"contacts": tuple(laws)}))

    @override
    def keep_one_friction_if_scene_sets_all(self, grid: CaseGrid) -> CaseGrid:
        """Return the grid, with its first friction only if the scene sets all frictions: others give equal cases."""
        return (
            grid
            if self.scene.has_contact_with_unset_friction
            else grid.copy_with_dimension_values(friction=grid["friction"][:1])
        )

    @override
    def simulated_direction_for_each_direction(
        self, grid: CaseGrid, use_symmetry: bool = True
    ) -> SimulatedDirectionsForRequestedDirections:
        """Return the azimuth to simulate for each grid azimuth φ: φ, or φ + 180° if its outcome is mirrored."""
        found = super().simulated_direction_for_each_direction(grid, use_symmetry)
        if not use_symmetry:
            return found
        return copy_with_mirrored_planes_marked(found, float(self._symmetry_periods_of_grid_aspects_deg(grid)[0]))

    @override
    def adapt_and_mark_copied_outcomes_in_place(
        self,
        outcome_arrays: dict[str, NDArray[Any]],
        grid: CaseGrid,
        equivalent_directions: SimulatedDirectionsForRequestedDirections,
    ) -> None:
        mirrored = grid.broadcast_over_grid(equivalent_directions.is_mirrored)
        outcome_arrays["mirrored"] = mirrored.astype(np.int8)
        for variable in self.outcome_variables:
            if variable.name != "mirrored":
                outcome_arrays[variable.name][mirrored] = variable.values_mirrored_to_opposite_azimuth(
                    outcome_arrays, mirrored
                )

    @override
    def ensemble_statistics_by_case(
        self,
        fall_flag_by_case_and_member: NDArray[np.int8],
        fall_azimuth_by_case_and_member_deg: FloatArray,
        sobol_scramble_of_member: NDArray[np.int64],
    ) -> dict[str, NDArray[Any]]:
        """Compute, for each case, the shares of ensemble runs that fall towards the motion's azimuth and away from it.

        The result also has the number of runs with an outcome, ``members``, and for each share the difference between
        the two Sobol scrambles, which are independent halves of the runs.
        """
        known = fall_flag_by_case_and_member != INT8_MISSING
        counted = known.sum(axis=1)
        found = {"members": counted if counted.ndim == 1 else counted.min(axis=1)}
        for name, side in (("towards", 1), ("away", -1)):
            shares = []
            for chosen in (
                np.ones(sobol_scramble_of_member.size, dtype=bool),
                sobol_scramble_of_member == 0,
                sobol_scramble_of_member == 1,
            ):
                count = known[:, chosen].sum(axis=1)
                fell = (fall_flag_by_case_and_member[:, chosen] == side).sum(axis=1)
                with np.errstate(invalid="ignore"):
                    shares.append(np.where(count > 0, fell / np.maximum(count, 1), np.nan))
            found[f"probability_{name}"], found[f"scramble_difference_{name}"] = shares[0], shares[1] - shares[2]
        return found

    @override
    def distinct_direction_indices(self, cube: "xr.Dataset") -> NDArray[np.intp]:
        return distinct_plane_indices(cube["azimuth"].to_numpy(), plane_azimuth_period_deg(cube))

    @override
    def fall_probability_and_direction_by_case(self, cube: "xr.Dataset", *, use_ensemble: bool = True) -> "xr.Dataset":
        import xarray as xr

        p = fall_probabilities_towards_and_away(cube, use_ensemble=use_ensemble).isel(
            azimuth=self.distinct_direction_indices(cube)
        )
        angle = np.radians(p["azimuth"].variable.to_base_variable().astype("float64"))
        towards, away = p["towards"].variable, p["away"].variable  # without coordinates, as above
        falls, net = towards + away, towards - away
        found = xr.Dataset(
            {
                "falls": falls,
                "direction_cosine": net * np.cos(angle),
                "direction_sine": net * np.sin(angle),
                "axis_cosine": falls * np.cos(2 * angle),
                "axis_sine": falls * np.sin(2 * angle),
                "weight": (
                    "azimuth",
                    plane_weights_by_azimuth_spacing(p["azimuth"].to_numpy(), plane_azimuth_period_deg(cube)),
                ),
            },
            p.coords,
        )
        found["falls"].attrs.update(long_name="probability of falling", units="1")
        return found

    @override
    def ensemble_fall_shares_by_side_and_case(self, cube: "xr.Dataset") -> "xr.Dataset":
        import xarray as xr

        half = cube.isel(azimuth=self.distinct_direction_indices(cube))
        return xr.Dataset({side: half[f"probability_{side}"] for side in ("towards", "away")})

    @override
    def look_up_square_stone_outcomes(
        self,
        one_record_cube: "xr.Dataset",
        front_azimuth_by_stone_deg: FloatArray,
        grid_indices_by_dimension: dict[str, NDArray[np.intp]],
    ) -> StoneOutcomesByAmplitudeFactor:
        """Return the outcomes of square stones, from 2-D results in the two vertical planes normal to their faces."""
        faces = np.stack([front_azimuth_by_stone_deg, front_azimuth_by_stone_deg + 90])
        period = plane_azimuth_period_deg(one_record_cube)
        planes = nearest_simulated_planes(one_record_cube["azimuth"].to_numpy(), faces, period)
        both = {
            "azimuth": planes.simulated_direction_index,
            **{name: np.stack([at, at]) for name, at in grid_indices_by_dimension.items()},
        }
        found = values_at_grid_indices(one_record_cube, self.variable_names_read_for_square_stones, both)
        side = np.where(planes.is_mirrored, -found["overturned"], found["overturned"])
        side = np.where(planes.is_within_simulated_directions, side, np.nan).swapaxes(0, 1)
        towards = np.broadcast_to((faces[:, None] + np.where(side < 0, 180, 0)) % 360, side.shape)
        fell, azimuth = fall_flag_and_azimuth_from_planes(
            np.abs(side), found["overturning_time"].swapaxes(0, 1), towards
        )
        untold = np.full(fell.shape, np.nan)
        return StoneOutcomesByAmplitudeFactor(fell == 1, np.isfinite(fell), azimuth, untold, untold)
