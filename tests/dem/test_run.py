"""Running any model: choice of kernel, equal outcomes of grid, cases and paths, and limits of a path."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.dem import plan
from overturning.dem.block.plan import BlockSimulationPlan
from overturning.dem.block.tables import RESULT_TABLE_DTYPE, TRAJECTORY_ROW_DTYPE
from overturning.dem.kernel.queue import grow_trajectory_array_if_needed, run_case_queue
from overturning.dem.numerics import NumericalOptions
from overturning.dem.plan import SimulationPlan
from overturning.dem.polygon import tables
from overturning.dem.polygon.plan import PolygonSimulationPlan
from overturning.dem.run import plan_simulation, run_cases, simulate_cases
from overturning.dem.simulate import create_case_grid, simulate_as_arrays, simulate_grid
from overturning.dem.trajectory import trajectory
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.falls import model_from_scene_or_shape
from overturning.model.planes import PlanarModel
from overturning.model.results import CASE_COUNTER_NAMES
from overturning.model.scene import gravestone, parse_scene_content
from overturning.model.variables import INT8_MISSING, PLANAR_OUTCOME_VARIABLES, PLANE_ENSEMBLE_VARIABLES
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import load_shipped_scene, motion_towards_north
from tests.expect import expect_error

TIME = np.arange(300) * 0.01
MOTION = motion_towards_north(np.round(6.0 * np.sin(2 * np.pi * TIME / 0.9) * (TIME < 1.8), 9))
CASES = Cases(0.0, 0.6, [0.2, 0.3], 0.7)


def test_result_columns_of_planar_kernels_have_the_names_of_outcome_variables() -> None:
    """`CaseResults.store_outcomes` copies columns by name, so that no table translates the names."""
    names = {variable.name for variable in PLANAR_OUTCOME_VARIABLES} - {"mirrored"} | {*CASE_COUNTER_NAMES}
    assert {*RESULT_TABLE_DTYPE.names} == names
    assert {*tables.RESULT_TABLE_DTYPE.names, *tables.ELEMENT_RESULT_TABLE_DTYPE.names} == names


@pytest.mark.parametrize(
    ("name", "general", "kind"),
    [
        ("gravestone", False, BlockSimulationPlan),
        ("shaft-alone", False, BlockSimulationPlan),
        ("gravestone", True, PolygonSimulationPlan),
        ("three-tier", False, PolygonSimulationPlan),
        ("against-a-wall", False, PolygonSimulationPlan),
    ],
)
def test_the_block_kernel_is_used_for_a_lone_block_unless_general_is_set(name: str, general: bool, kind: type) -> None:
    assert (
        type(plan_simulation(PlanarModel(load_shipped_scene(name)), MOTION, CASES, NumericalOptions(general=general)))
        is kind
    )


def test_all_simulation_functions_give_the_same_outcomes_of_a_gravestone() -> None:
    contact = Contact(damping_ratio=0.7)
    results = simulate_cases(gravestone(contact, 2000.0), MOTION, CASES)
    assert results.overturned.shape == (2,)
    alone = run_cases(MOTION, CASES, gravestone(contact, 2000.0))
    arrays = simulate_as_arrays(
        MOTION, gravestone(contact), azimuth_deg=0.0, height=0.6, b_over_h=[0.2, 0.3], friction=0.7
    )
    for variable in PLANAR_OUTCOME_VARIABLES:
        if variable.name != "mirrored":
            np.testing.assert_array_equal(getattr(alone, variable.name), arrays[variable.name].ravel())
    path = trajectory(MOTION, gravestone(contact), azimuth_deg=0.0, b_over_h=0.3, friction=0.7)
    stone = path.sel(element="stone")
    assert stone["peak_rotation"] == alone.peak_rotation[1]
    assert path.attrs["block_steps"] == alone.block_steps[1]


@pytest.mark.parametrize(
    "model", [None, load_shipped_scene("three-tier"), "rectangle", 6], ids=["block", "scene", "rectangle", "hexagon"]
)
def test_a_grid_a_list_of_cases_and_a_trajectory_have_the_same_outcomes(model: Any) -> None:
    known = model_from_scene_or_shape(model)
    axes = {
        f"{known.direction_dimension_name}_deg": [10.0, 50.0],
        "height": [0.6],
        "b_over_h": [0.25, 0.75],
        "friction": [0.7],
    }
    arrays = simulate_as_arrays(MOTION, model, **axes)
    cells = [cell.ravel() for cell in np.meshgrid(*axes.values(), indexing="ij")]
    results = simulate_cases(model, MOTION, Cases(*cells))
    assert len(np.unique(results.overturned)) > 1
    one = {name: float(values[-1]) for name, values in axes.items()}
    path = trajectory(MOTION, model, **one)
    path = path.sel(element=list(known.free_element_names)) if "element" in path.dims else path
    for variable in known.outcome_variables:
        if variable.name != known.symmetry_copy_flag_variable_name:
            values = getattr(results, variable.name)
            np.testing.assert_array_equal(arrays[variable.name].reshape(values.shape), values, err_msg=variable.name)
            shown = variable.decode(values[-1])
            np.testing.assert_array_equal(path[variable.name].to_numpy().squeeze(), shown, err_msg=variable.name)


@pytest.mark.parametrize(("model", "orientation"), [("circle", 30.0), (5, 100.0), ("rectangle", 130.0)])
def test_a_trajectory_is_bit_equal_to_its_case_at_equivalent_orientations(model: Any, orientation: float) -> None:
    size = {"height": 0.6, "b_over_h": 0.25, "friction": 0.7}
    cell = simulate_as_arrays(MOTION, model, orientation_deg=orientation, **size)
    path = trajectory(MOTION, model, orientation_deg=orientation, **size)
    assert path.attrs["orientation_deg"] == orientation
    for variable in model_from_scene_or_shape(model).outcome_variables:
        if variable.name != "repeated":
            shown = variable.decode(cell[variable.name]).item()
            np.testing.assert_array_equal(path[variable.name], shown, err_msg=variable.name)


def test_outcomes_repeat_along_friction_if_the_scene_sets_its_own_friction() -> None:
    law = {"between": ("stone", "stone"), "friction": 0.3}
    scene = parse_scene_content(load_shipped_scene("gravestone").model_dump() | {"contacts": [law]})
    model = PlanarModel(scene)
    grid = create_case_grid(model, azimuth_deg=[0.0, 180.0])
    # A study may sweep friction for another variant; a direct simulation refuses the argument.
    arrays = simulate_grid(
        model, MOTION, grid.copy_with_dimension_values(friction=np.array([0.1, 0.9])), NumericalOptions()
    )
    with expect_error(ArgumentError, "friction: [0.1, 0.9]; scene gravestone has coefficients of its own", brief=True):
        simulate_as_arrays(MOTION, scene, azimuth_deg=[0.0, 180.0], friction=[0.1, 0.9])
    swept = simulate_as_arrays(MOTION, azimuth_deg=[0.0, 180.0], friction=[0.3])
    for name, values in arrays.items():
        np.testing.assert_array_equal(values, np.repeat(swept[name], 2, axis=3), err_msg=name)


def test_mirrored_outcomes_for_the_opposite_azimuth_change_sign() -> None:
    """Fall sides and slips change sign, except missing flags and zeros; probabilities of both sides are exchanged."""
    arrays = {
        "overturned": np.array([1, -1, 0, INT8_MISSING], np.int8), "residual_slip": np.array([0.5, -0.5, 0.0, np.nan]),
        "peak_slip": np.array([0.5, 0.5, 0.0, 0.1]), "probability_towards": np.zeros(4), "probability_away": np.ones(4),
    }  # fmt: skip
    seen = {
        item.name: item.values_mirrored_to_opposite_azimuth(arrays)
        for item in (*PLANAR_OUTCOME_VARIABLES, *PLANE_ENSEMBLE_VARIABLES)
        if item.name in arrays
    }
    assert seen["overturned"].tolist() == [-1, 1, 0, INT8_MISSING]
    np.testing.assert_array_equal(seen["residual_slip"], [-0.5, 0.5, 0.0, np.nan])
    assert not np.signbit(seen["residual_slip"][2])
    np.testing.assert_array_equal(seen["peak_slip"], arrays["peak_slip"])
    assert (seen["probability_towards"] == 1).all()
    assert (seen["probability_away"] == 0).all()


@pytest.mark.parametrize("kind", ["block", "space"])
def test_a_trajectory_beyond_its_record_is_computed_in_a_single_run(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = list[int]()
    monkeypatch.setattr(
        SimulationPlan,
        "run_case_queue_function",
        staticmethod(lambda *arguments: calls.append(1) or run_case_queue(*arguments)),
    )
    time = np.arange(60) * 0.01
    wave = Motion(5.0 * np.sin(11.0 * time), 0 * time, sampling_interval=0.01)
    if kind == "block":
        path = trajectory(wave, azimuth_deg=0.0, height=0.6, b_over_h=0.4)
    else:
        path = trajectory(wave, "rectangle", orientation_deg=10.0, height=0.6, b_over_h=0.4)
    assert len(calls) == 1
    assert path.sizes["time"] > wave.sample_count
    steps = np.diff(path["time"])
    assert steps.min() >= 0
    assert steps.max() <= 0.0101, "a sample"
    assert path["time"][-1] > time[-1]


def test_a_trajectory_above_the_memory_limit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def return_too_many_trajectory_rows(*_: Any) -> Any:
        """Return a trajectory of ten million rows in place of the kernel."""
        return np.broadcast_to(np.zeros((), TRAJECTORY_ROW_DTYPE), 10_000_000), -1

    with monkeypatch.context() as patch, expect_error(ArgumentError, "trajectory", "GB", "at most 0.8 GB", "time_step"):
        patch.setattr(SimulationPlan, "run_case_queue_function", staticmethod(return_too_many_trajectory_rows))
        trajectory(MOTION, azimuth_deg=0.0, height=0.6, b_over_h=0.1)
    long = Motion(np.zeros(3_000_000), np.zeros(3_000_000), sampling_interval=0.01)
    with expect_error(ArgumentError, "trajectory", "at most 0.8 GB", "cut the motion"):
        trajectory(long, load_shipped_scene("three-tier"), azimuth_deg=0.0, leave_out=False)


@pytest.mark.parametrize("model", ["block", "rectangle"])
def test_a_trajectory_is_computed_up_to_the_memory_limit_and_refused_beyond(
    monkeypatch: pytest.MonkeyPatch, model: str
) -> None:
    time = np.arange(60) * 0.01
    wave = Motion(5.0 * np.sin(11.0 * time), 0 * time, sampling_interval=0.01)

    def compute_trajectory() -> xr.Dataset:
        """Compute the trajectory of a block or body."""
        where: dict[str, Any] = {"azimuth_deg": 0.0} if model == "block" else {"model": model, "orientation_deg": 0.0}
        return trajectory(wave, height=0.6, b_over_h=0.4, friction=0.1, leave_out=False, **where)

    path = compute_trajectory()
    numbers = sum(values.size for values in path.variables.values() if "time" in values.dims)
    # The kernel requests rows for a whole sample.
    monkeypatch.setattr(plan, "MAX_TRAJECTORY_DATASET_VALUES", numbers + 20 * numbers // path.sizes["time"])
    assert compute_trajectory().sizes == path.sizes
    monkeypatch.setattr(plan, "MAX_TRAJECTORY_DATASET_VALUES", numbers - 1)
    with expect_error(ArgumentError, "trajectory", "GB or more", "cut the motion"):
        compute_trajectory()


def test_an_extended_trajectory_array_keeps_its_rows() -> None:
    path = np.arange(4.0).astype([("time", "f8")])
    assert grow_trajectory_array_if_needed.py_func(path, 4, 100) is path
    longer = grow_trajectory_array_if_needed(path, 5, 100)
    assert longer.shape == (8,)
    np.testing.assert_array_equal(longer[:4], path)
    assert grow_trajectory_array_if_needed(path, 50, 100).shape == (50,)
    assert grow_trajectory_array_if_needed.py_func(path, 101, 100) is path
