"""Builders of test scenes, and runs of scenes from any initial state."""

from pathlib import Path
from typing import Any

import numpy as np

from overturning.dem.numerics import NumericalOptions
from overturning.dem.polygon import rows as k
from overturning.dem.polygon.plan import PolygonSimulationPlan, plan_scene_simulation
from overturning.dem.polygon.state import ElementState
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.planes import PlanarModel
from overturning.model.results import CaseResults
from overturning.model.scene import Scene, load_scene, parse_scene_content
from overturning.motion.motion import Motion

REPOSITORY = Path(__file__).parents[2]
GROUND = {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]}
SHIPPED_SCENES = ("gravestone", "three-tier", "against-a-wall", "boulder")


def load_shipped_scene(name: str) -> Scene:
    """Return a scene of the folder config/scenes by its name, such as "three-tier"."""
    return load_scene(name, REPOSITORY)


def scene_of_elements(*elements: dict[str, Any], **keys: Any) -> Scene:
    """Return a scene of the given elements; a driven ground is added if there is none."""
    given = list(elements)
    if not any(element.get("kind") == "driven" for element in given):
        given.insert(0, GROUND)
    return parse_scene_content({"name": "test", "elements": given, **keys})


def block_element(
    name: str, width: float, height: float, on: str = "ground", x: float = 0.0, **keys: Any
) -> dict[str, Any]:
    """Return the element of a scene file for a rectangular block that stands on another element; lengths in m."""
    return {"name": name, "width": width, "height": height, "stands_on": on, "at": [x, 0], **keys}


def motion_at_rest(duration: float, interval: float = 0.01) -> Motion:
    """Return the motion of a base at rest; duration and sampling interval in s."""
    zero = np.zeros(round(duration / interval) + 1)
    return Motion(zero, zero, sampling_interval=interval)


def motion_towards_north(acceleration: Any, interval: float = 0.01) -> Motion:
    """Return a motion towards north with the given acceleration, m/s²."""
    values = np.asarray(acceleration, dtype=np.float64)
    return Motion(values, 0 * values, sampling_interval=interval)


def plan_single_case(made: Scene, motion: Motion, friction: float = 1.0, **options: Any) -> PolygonSimulationPlan:
    """Plan one case of a scene with the sizes of its file, along azimuth 0; times at rest are not skipped."""
    height, ratio = reference_element_height_and_b_over_h(made)
    return plan_scene_simulation(
        PlanarModel(made),
        motion,
        Cases([0.0], [height], [ratio], [friction]),
        NumericalOptions(leave_out=False, **options),
    )


def run_planned_case(
    plan: PolygonSimulationPlan, motion: Motion, samples_after_record: int = 0
) -> tuple[CaseResults, np.ndarray, np.ndarray]:
    """Run a planned case; return results, times (s), and poses with velocities, shape (samples, elements, 6).

    The result covers the record and `samples_after_record` samples after it.
    """
    rows = motion.sample_count + samples_after_record
    path = np.zeros((rows, 2 + 6 * plan.scene_arrays.piece_vertex_counts.size))
    answers, path = plan.simulate_group_with_reruns_on_energy_error(np.zeros(1, np.int64), np.zeros(1, np.int64), path)
    path = path[:rows]  # a case may last longer
    return CaseResults(**answers), path[:, 0], path[:, 2:].reshape(len(path), -1, 6)


def overwrite_initial_state_of_element(plan: PolygonSimulationPlan, element: int, **values: float) -> None:
    """Set x, z, angle, vx, vz or vw of an element at the start; it must not touch another element there."""

    def set_initial_state_number_of_element(path: str, number: float) -> None:
        """Set one number of the element's initial state; `path` names the field, such as "pose.x"."""
        row = (
            k.CASE_ROW_LAYOUT.row_count
            + element * k.ELEMENT_ROW_LAYOUT.row_count
            + k.ELEMENT_ROW_LAYOUT.row_offset_of_field(ElementState, path) // k.PARALLEL_CASE_COUNT
        )
        plan.scene_arrays.initial_state_by_scene_variant[0, row] = number

    paths = {"x": "pose.x", "z": "pose.z", "vx": "velocity.x", "vz": "velocity.z", "vw": "velocity.angular"}
    for name, value in values.items():
        if name == "angle":
            set_initial_state_number_of_element("pose.angle", value)
            set_initial_state_number_of_element("pose.cos", np.cos(value))
            set_initial_state_number_of_element("pose.sin", np.sin(value))
        else:
            set_initial_state_number_of_element(paths[name], value)
