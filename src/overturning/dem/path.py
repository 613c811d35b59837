"""Trajectory of a 2-D case: motion of all elements of a scene over time, and the contact forces between them."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.model.geometry import PlacedElement
from overturning.model.results import CaseResults
from overturning.model.scene import Scene
from overturning.model.variables import PLANAR_OUTCOME_VARIABLES

POSE_AND_RATE_VARIABLES: Final = {
    "x": ("m", "centre towards the azimuth, in the frame of the base"),
    "z": ("m", "height of the centre"),
    "rotation": ("rad", "rotation, positive towards the azimuth"),
    "velocity_x": ("m s-1", "velocity towards the azimuth, relative to the base"),
    "velocity_z": ("m s-1", "upward velocity"),
    "angular_velocity": ("rad s-1", "angular velocity"),
}


def dataset_variable_tuple(
    dimensions_separated_by_spaces: str, values: Any, units: str, long_name: str
) -> tuple[Any, ...]:
    """Return a variable of a dataset as the tuple of its dimensions, its values and its attributes.

    `dimensions_separated_by_spaces` are names separated by spaces; the attributes are `units` and `long_name`.
    """
    return dimensions_separated_by_spaces.split(), values, {"units": units, "long_name": long_name}


@dataclass(frozen=True)
class PlanarSceneTrajectory:
    """Motion of all elements of a scene over time in one case, with the contact forces."""

    scene: Scene
    placed_elements: list[PlacedElement]
    critical_angles_by_free_element: FloatArray  # shape (elements,): α of each free element, rad
    time: FloatArray  # shape (rows,): time after the start of the record, s
    base_acceleration_towards_azimuth: FloatArray  # shape (rows,): acceleration of the base towards the azimuth, m/s²
    poses_and_rates: FloatArray  # shape (rows, elements, 6): x, z, rotation and their rates, in the frame of the base
    mean_contact_forces_until_next_row: (
        FloatArray  # shape (rows, contacts, 2): mean force on the first element until the next row, N
    )
    contact_force_points: (
        FloatArray  # shape (rows, contacts, 2): point at which the force acts, m; NaN without contact or unknown
    )
    contact_element_names: list[tuple[str, str]]  # names of the two elements of each contact

    def variables_coordinates_and_attributes(
        self, results: CaseResults
    ) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        """Return variables (including those of `results`), coordinates and attributes of the trajectory's dataset."""
        vertices = np.full(
            (
                len(self.placed_elements),
                max(len(item.shape.vertices_from_whole_polygon_centroid) for item in self.placed_elements),
                2,
            ),
            np.nan,
        )
        for item, row in zip(self.placed_elements, vertices, strict=True):
            row[: len(item.shape.vertices_from_whole_polygon_centroid)] = (
                item.shape.vertices_from_whole_polygon_centroid
            )
        x, _, angle = np.moveaxis(self.poses_and_rates[:, :, :3], 2, 0)
        low = np.nanmin(vertices[:, :, 1], axis=1)
        side = vertices[:, :, 1] <= (low + 1e-9 * np.nanmax(vertices[:, :, 1], axis=1))[:, None]
        # The middle of the lower side is not necessarily below the centre.
        aside = np.mean(vertices[:, :, 0], axis=1, where=side)
        slip = (
            x
            - [item.centre_of_mass_x for item in self.placed_elements]
            + low * np.sin(angle)
            + aside * (np.cos(angle) - 1.0)
        )
        variables = {
            name: dataset_variable_tuple("time element", self.poses_and_rates[:, :, column], *about)
            for column, (name, about) in enumerate(POSE_AND_RATE_VARIABLES.items())
        }
        mean = "mean from this time to the next"
        variables |= {
            "base_slip": dataset_variable_tuple(
                "time element", slip, "m", "displacement of the middle of the lower side"
            ),
            "ground_acceleration": dataset_variable_tuple(
                "time", self.base_acceleration_towards_azimuth, "m s-2", "acceleration of the base towards the azimuth"
            ),
            "contact_force": dataset_variable_tuple(
                "time contact xz", self.mean_contact_forces_until_next_row, "N", f"force on contact_on, {mean}"
            ),
            "contact_place": dataset_variable_tuple(
                "time contact xz", self.contact_force_points, "m", f"where it acts, {mean}"
            ),
            "contact_on": ("contact", [on for on, _ in self.contact_element_names]),
            "contact_by": ("contact", [by for _, by in self.contact_element_names]),
            "kind": ("element", [item.element.kind for item in self.placed_elements]),
            "critical_angle": dataset_variable_tuple(
                "element", self.critical_angles_by_free_element, "rad", "critical angle"
            ),
            "fallen_angle": dataset_variable_tuple(
                "element side",
                [
                    (np.nan, np.nan) if item.has_prescribed_motion else item.fall_rotations_to_minus_and_plus_x_rad
                    for item in self.placed_elements
                ],
                "rad",
                "rotation to a side at which it has fallen",
            ),
            "vertices": dataset_variable_tuple(
                "element vertex xz", vertices, "m", "vertices about the centre, counter-clockwise"
            ),
        }
        variables |= self._dataset_tuples_of_outcome_variables(results)
        coordinates = {
            "time": dataset_variable_tuple("time", self.time, "s", "time after the record's start"),
            "element": ("element", [item.element.name for item in self.placed_elements]),
            "side": ("side", [-1, 1], {"long_name": "side over which it tips, 1 towards the azimuth"}),
        }
        weight = self.scene.gravity * sum(item.mass for item in self.placed_elements if not item.has_prescribed_motion)
        return variables, coordinates, {"reference": self.scene.name_of_element_shown_by_default, "weight": weight}

    def _dataset_tuples_of_outcome_variables(self, results: CaseResults) -> dict[str, Any]:
        """Return, by outcome name, dimensions, values and attributes; missing values for driven or held elements."""
        variables: dict[str, Any] = {}
        free = [index for index, item in enumerate(self.placed_elements) if not item.has_prescribed_motion]
        for variable in (item for item in PLANAR_OUTCOME_VARIABLES if item.name != "mirrored"):
            values = getattr(results, variable.name)[0]
            if variable.has_element_dimension:
                values, of_free = (
                    np.full(len(self.placed_elements), variable.missing_value_in_memory, variable.dtype_in_file),
                    values,
                )
                values[free] = of_free
            dimensions = ("element",) if variable.has_element_dimension else ()
            variables[variable.name] = (dimensions, variable.decode(values), variable.cf_attributes)
        return variables
