"""Common base class of the 3-D models, whose stones fall towards any azimuth: one case for each orientation."""

from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from overturning.arrays import ArrayLike, FloatArray
from overturning.model.grid import CaseGrid
from overturning.model.model import Model, StoneOutcomesByAmplitudeFactor, values_at_grid_indices
from overturning.model.symmetry import SimulatedDirectionsForRequestedDirections, nearest_simulated_directions
from overturning.model.variables import INT8_MISSING, mask_of_known_outcomes

if TYPE_CHECKING:
    import xarray as xr

SQUARE_SYMMETRY_PERIOD_DEG: Final = 90.0
"""Rotation period of a stone of square footprint, degrees."""

MIN_RESULTANT_OF_AGREEING_FALLS: Final = float(np.cos(np.radians(15.0)))
"""Mean resultant of directions that lie 15° to either side of their mean."""

_ENSEMBLE_MEAN_VARIABLE_BY_STATISTIC: Final = {
    "falls": "probability_falls",
    "direction_cosine": "fall_north",
    "direction_sine": "fall_east",
    "axis_cosine": "fall_axis_cosine",
    "axis_sine": "fall_axis_sine",
}
"""Cube variables with ensemble means, by name of the variable of `Model.fall_probability_and_direction_by_case`."""


def case_weight_in_direction_statistics(
    member_fall_share_by_case: ArrayLike,
    mean_northward_fall_component_by_case: ArrayLike,
    mean_fall_east_over_all_members_by_case: ArrayLike,
    member_count_by_case: ArrayLike,
) -> FloatArray:
    """Return each case's weight in fall-direction statistics: 1 if ensemble runs agree, 0 if falls are random.

    Let R be the mean resultant length of the fall directions of the k members (ensemble runs) that fall. Random
    directions give k R² = 1 on average. So the weight is √((k R² − 1)/(k − 1)), or 0 where k R² is below 1.
    The weight is 1 where fewer than two members fall, because the spread is then unknown.

    Parameters
    ----------
    member_fall_share_by_case : array_like
        ``probability_falls`` of the results; NaN where no member was run.
    mean_northward_fall_component_by_case : array_like
        ``fall_north`` of the results: mean cosine of the fall azimuth over all members, 0 for standing ones.
    mean_fall_east_over_all_members_by_case : array_like
        ``fall_east`` of the results: mean sine of the fall azimuth over all members, 0 for standing ones.
    member_count_by_case : array_like
        Number of members with an outcome.
    """
    fell = np.nan_to_num(np.asarray(member_fall_share_by_case, np.float64))
    count = fell * np.asarray(member_count_by_case, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        square = (
            np.asarray(mean_northward_fall_component_by_case, np.float64) ** 2
            + np.asarray(mean_fall_east_over_all_members_by_case, np.float64) ** 2
        ) / fell**2
        known = np.sqrt(np.clip((count * square - 1.0) / (count - 1.0), 0.0, 1.0))
    return np.asarray(np.where(count > 1.5, known, 1.0))


class ThreeDimensionalModel(Model):
    """Abstract base class of the 3-D models; all initial orientations have equal weight in statistics."""

    direction_dimension_name: ClassVar = "orientation"
    symmetry_copy_flag_variable_name: ClassVar = "repeated"
    is_planar: ClassVar = False
    can_rotate_about_vertical: ClassVar = True
    variable_names_read_for_fall_probability: ClassVar = (
        "overturned",
        "fall_azimuth",
        *_ENSEMBLE_MEAN_VARIABLE_BY_STATISTIC.values(),
    )
    variable_names_read_for_square_stones: ClassVar = (
        "overturned", "fall_azimuth", "residual_slip_north", "residual_slip_east", "residual_twist"
    )  # fmt: skip

    @override
    def adapt_and_mark_copied_outcomes_in_place(
        self,
        outcome_arrays: dict[str, NDArray[Any]],
        grid: CaseGrid,
        equivalent_directions: SimulatedDirectionsForRequestedDirections,
    ) -> None:
        own = np.arange(equivalent_directions.simulated_direction_index.shape[0])[:, None]
        outcome_arrays["repeated"] = grid.broadcast_over_grid(
            equivalent_directions.simulated_direction_index != own
        ).astype(np.int8)

    @override
    def ensemble_statistics_by_case(
        self,
        fall_flag_by_case_and_member: NDArray[np.int8],
        fall_azimuth_by_case_and_member_deg: FloatArray,
        sobol_scramble_of_member: NDArray[np.int64],
    ) -> dict[str, NDArray[Any]]:
        """Compute each case's share of ensemble runs that fall, and means of cosine and sine of the fall azimuth."""
        known, fell = fall_flag_by_case_and_member != INT8_MISSING, fall_flag_by_case_and_member == 1
        angle = np.radians(fall_azimuth_by_case_and_member_deg)
        first, second = (
            (sobol_scramble_of_member == number).reshape(-1, *(1,) * (known.ndim - 2)) for number in (0, 1)
        )

        def mean_over_runs_with_standing_as_zero(
            values_by_case_and_member: Any, selected_member_mask: Any = True
        ) -> FloatArray:
            """Return each case's mean of values over selected ensemble runs with an outcome; standing counts as 0."""
            count = (known & selected_member_mask).sum(axis=1)
            # Rounded: cosines differ in the last digit between processors.
            total = np.round(np.where(fell & selected_member_mask, values_by_case_and_member, 0.0), 9).sum(axis=1)
            return np.where(count > 0, total / np.maximum(count, 1), np.nan)

        return {
            "probability_falls": mean_over_runs_with_standing_as_zero(1.0),
            "fall_north": mean_over_runs_with_standing_as_zero(np.cos(angle)),
            "fall_east": mean_over_runs_with_standing_as_zero(np.sin(angle)),
            "fall_axis_cosine": mean_over_runs_with_standing_as_zero(np.cos(2 * angle)),
            "fall_axis_sine": mean_over_runs_with_standing_as_zero(np.sin(2 * angle)),
            "scramble_difference": mean_over_runs_with_standing_as_zero(1.0, first)
            - mean_over_runs_with_standing_as_zero(1.0, second),
            "members": known.sum(axis=1),
        }

    @override
    def distinct_direction_indices(self, cube: "xr.Dataset") -> NDArray[np.intp]:
        return np.arange(cube.sizes[self.direction_dimension_name])

    @override
    def fall_probability_and_direction_by_case(self, cube: "xr.Dataset", *, use_ensemble: bool = True) -> "xr.Dataset":
        import xarray as xr

        known = mask_of_known_outcomes(cube["overturned"])
        fell = (cube["overturned"] == 1).where(known)
        azimuth = cube["fall_azimuth"].astype("float64") * (np.pi / 180.0)
        found = {"falls": fell.astype("float64")}
        for kind, angle in (("direction", azimuth), ("axis", 2.0 * azimuth)):
            for name, of in (("cosine", np.cos), ("sine", np.sin)):
                values = xr.apply_ufunc(of, angle, dask="allowed")
                found[f"{kind}_{name}"] = values.where(fell == 1, 0.0).where(known)
        if use_ensemble and "probability_falls" in cube:
            found = {
                name: cube[_ENSEMBLE_MEAN_VARIABLE_BY_STATISTIC[name]].astype("float64").fillna(values)
                for name, values in found.items()
            }
        count = cube.sizes[self.direction_dimension_name]
        return xr.Dataset({**found, "weight": (self.direction_dimension_name, np.full(count, 1.0 / count))})

    @override
    def ensemble_fall_shares_by_side_and_case(self, cube: "xr.Dataset") -> "xr.Dataset":
        """Return, for each case, the share of its ensemble runs that fall, and whether their fall directions differ.

        ``towards`` is the share, ``away`` 0. ``agree`` is True if all runs fall; ``apart``, if moreover their
        directions spread by more than 15° about their mean.
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
                "apart": agree & (length < MIN_RESULTANT_OF_AGREEING_FALLS),
            }
        )

    @override
    def look_up_square_stone_outcomes(
        self,
        one_record_cube: "xr.Dataset",
        front_azimuth_by_stone_deg: FloatArray,
        grid_indices_by_dimension: dict[str, NDArray[np.intp]],
    ) -> StoneOutcomesByAmplitudeFactor:
        """Return, for each stone, the outcome of the square prism simulated with the nearest orientation."""
        square = one_record_cube
        if "aspect" in one_record_cube.dims:
            square = one_record_cube.isel(aspect=int(np.flatnonzero(one_record_cube["aspect"].to_numpy() == 1.0)[0]))
        sources = nearest_simulated_directions(
            one_record_cube[self.direction_dimension_name].to_numpy(),
            front_azimuth_by_stone_deg,
            SQUARE_SYMMETRY_PERIOD_DEG,
        )
        found = values_at_grid_indices(
            square,
            self.variable_names_read_for_square_stones,
            {self.direction_dimension_name: sources.simulated_direction_index, **grid_indices_by_dimension},
        )
        flag = found["overturned"]
        slip = np.hypot(found["residual_slip_north"], found["residual_slip_east"])
        return StoneOutcomesByAmplitudeFactor(
            flag == 1, np.isfinite(flag), found["fall_azimuth"], slip, found["residual_twist"]
        )
