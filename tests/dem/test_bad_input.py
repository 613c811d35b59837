"""Bad arguments are refused with name, value and bound; cases without a valid outcome are marked and have no flag."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from overturning.dem.kernel import balance
from overturning.dem.numerics import BODY_STEP_COST_IN_BLOCK_STEPS, ELEMENT_STEP_COST_IN_BLOCK_STEPS, NumericalOptions
from overturning.dem.run import plan_simulation, run_cases, simulate_cases
from overturning.dem.simulate import simulate, simulate_as_arrays
from overturning.dem.trajectory import trajectory
from overturning.errors import ArgumentError, ConfigError
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import Contact, VertexContact
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene, gravestone, load_scene, parse_scene_content
from overturning.model.shapes import RectangularPrism
from overturning.model.stack import Stack
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import block_element, load_shipped_scene, scene_of_elements
from tests.expect import expect_error

ACCELERATION = 4.0 * np.sin(np.arange(200) * 0.1)
MOTION = Motion(ACCELERATION, 0.3 * ACCELERATION, sampling_interval=0.01)
GRID: dict[str, Any] = {"azimuth_deg": [0.0], "height": [0.6], "b_over_h": [0.3], "friction": [1.0]}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"azimuth_deg": []}, ["azimuth_deg", "at least one"]),
        ({"azimuth_deg": [np.nan]}, ["azimuth_deg", "nan"]),
        ({"b_over_h": [0.0]}, ["b_over_h", "above 0"]),
        ({"b_over_h": [-0.2]}, ["b_over_h", "-0.2", "above 0"]),
        ({"height": [0.0]}, ["height", "above 0"]),
        ({"height": [np.inf]}, ["height", "inf"]),
        ({"height": [0.6, 60.0]}, ["height", "60 m", "0.01 to 50 m", "centimetres"]),
        ({"height": [0.009]}, ["height", "0.009 m", "0.01 to 50 m"]),
        ({"friction": [-0.1]}, ["friction", "-0.1", "at least 0"]),
        ({"scheme": "euler"}, ["scheme", "euler", "centred"]),
        ({"time_step": 0.01}, ["time_step", "0.01", "at most"]),
        ({"time_step": -1.0}, ["time_step", "positive"]),
        ({"time_step": "2 stable"}, ["time_step", "2 stable"]),
        ({"time_step": 1e-12}, ["time_step: 1e-12, a time step", "steps", "at least 5e-09 s"]),
        ({"time_step": "1e-9 stable"}, ["time_step: '1e-9 stable'", "at least 5e-09 s"]),
        ({"budget": 10**30}, ["budget: 1000000", "at most 1000000000000000"]),
        ({"refinement": 2**70}, ["refinement: 1180591620717411303424", "at most 65536"]),
        ({"aspect": "a"}, ["aspect: 'a'; it must be a number"]),
        ({"aspect": [[1, 2]]}, ["aspect: shape (1, 2); give one row"]),
        ({"aspect": 1j}, ["aspect: '1j'; it must be a number"]),
        ({"aspect": {}}, ["aspect: '{}'; it must be a number"]),
        ({"aspect": -1.0}, ["aspect: -1; it must be above 0"]),
        ({"threads": 0}, ["threads", "at least 1"]),
        ({"threads": "2", "refinement": 1.5, "budget": True}, ["threads: '2'", "refinement: 1.5", "budget: True"]),
        ({"leave_out": "no", "general": 1}, ["leave_out: 'no'; give True or False", "general: 1; give True or False"]),
        ({"time_step": None}, ["time_step: None", "'auto'"]),
        ({"progress": 3}, ["progress: 3", "a function"]),
        ({"azimuth_deg": [1e300]}, ["azimuth_deg: 1e+300", "at most 1e+06 degrees"]),
        ({"friction": [[0.1, 0.2]]}, ["friction: shape (1, 2); give one row"]),
        ({"azimuth_deg": None}, ["azimuth_deg is not given", "or orientation_deg for a 3-D body"]),
        ({"orientation_deg": [0.0]}, ["both are given", "give azimuth_deg for a block"]),
        ({"model": "square"}, ["model: 'square'; give 'rectangle'", "from 3 to 96"]),
        ({"model": gravestone(Contact(damping=1e12)), "scheme": "cundall"}, ["damping", "steps"]),
        ({"model": gravestone(Contact(stiffness=1e18))}, ["stiffness", "penetration", "below"]),
    ],
)
def test_bad_arguments_of_a_simulation_are_refused(change: dict[str, Any], words: list[str]) -> None:
    with expect_error(ArgumentError, *words):
        simulate_as_arrays(MOTION, **{**GRID, **change})


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"stiffness": -1.0}, "stiffness"),
        ({"stiffness": "soft"}, "soft"),
        ({"stiffness_ratio": np.nan}, "stiffness_ratio"),
        ({"damping": -3500.0}, "damping"),
        ({"damping": 1.0, "damping_ratio": 1.0}, "both"),
        ({"stiffness": 1e7, "static_penetration": 1e-6}, "static_penetration 1e-06 and stiffness 1e.07 N/m .*keep one"),
    ],
)
def test_bad_contact_parameters_are_refused(arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        Contact(**arguments)


def test_unstable_step_message_names_a_stable_step() -> None:
    with pytest.raises(ValueError, match="at most") as refusal:
        simulate_as_arrays(MOTION, **GRID, time_step=0.01)
    largest = float(str(refusal.value).split("at most ")[1].split(" s")[0])
    found = simulate_as_arrays(MOTION, **GRID, time_step=0.99 * largest)
    assert (found["block_steps"] > 0).all()


def test_too_many_cases_are_refused_with_the_memory_they_need() -> None:
    with pytest.raises(ValueError, match="GiB"):
        simulate_as_arrays(
            MOTION,
            azimuth_deg=np.arange(1000.0),
            height=np.ones(1000),
            b_over_h=np.full(100, 0.3),
            friction=np.ones(10),
        )


def test_case_arrays_of_unequal_length_and_tilts_beyond_balance_are_refused() -> None:
    with pytest.raises(ValueError, match="lengths differ"):
        Cases([0.0, 1.0], [0.6, 0.6, 0.6], 0.3, 1.0)
    with pytest.raises(ValueError, match="initial_tilt"):
        Cases(0.0, 0.6, 0.3, 1.0, initial_tilt=0.4)


def test_friction_argument_is_refused_for_a_scene_that_sets_all_coefficients() -> None:
    own = scene_of_elements(
        block_element("low", 0.24, 0.6), contacts=[{"between": ["stone", "stone"], "friction": 0.5}]
    )
    with expect_error(ArgumentError, "friction: [0.1, 1.0]", "scene test has coefficients of its own"):
        simulate(MOTION, own, azimuth_deg=0.0, friction=[0.1, 1.0])
    with expect_error(ArgumentError, "friction: 0.1", "scene test has coefficients of its own"):
        trajectory(MOTION, own, azimuth_deg=0.0, friction=0.1)
    assert simulate(MOTION, own, azimuth_deg=0.0).friction.values.tolist() == [1.0]
    stone = {"name": "low", "width": 0.24, "depth": 0.24, "height": 0.6, "stands_on": "ground"}
    ground = {"name": "ground", "kind": "driven", "width": 40.0, "height": 1.0, "at": [0.0, -1.0]}
    law = {"between": ["stone", "stone"], "friction": 0.5}
    stack = Scene.model_validate({"name": "test", "contacts": [law], "elements": [ground, stone]})
    with expect_error(ArgumentError, "friction: [1.0, 0.2]", "scene test has coefficients of its own"):
        simulate(MOTION, stack, orientation_deg=0.0, friction=[1.0, 0.2])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Cases("east", 0.6, 0.3, 1.0), ["azimuth_deg: 'east'; it must be a number"]),
        (lambda: Cases(0.0, 0.6, 0.3, [1.0, None, "smooth"]), ["friction: \"[1.0, None, 'smooth']\""]),
        (lambda: Motion(["a"], [0.0], sampling_interval=0.01), ["north: \"['a']\"; it must be a number"]),
        (lambda: Motion(ACCELERATION, ACCELERATION, "up", sampling_interval=0.01), ["up: 'up'; it must be a number"]),
        (lambda: Motion(ACCELERATION, ACCELERATION, sampling_interval="fast"), ["sampling_interval: 'fast'"]),
        # type: ignore[arg-type]
        (
            lambda: Motion(ACCELERATION, ACCELERATION, sampling_interval=[0.01]),
            ["sampling_interval: shape (1,); give one number"],
        ),  # type: ignore[arg-type]
        (
            lambda: Motion(ACCELERATION, ACCELERATION, sampling_interval=1e-9),
            ["sampling_interval: 1e-09 s; give at least 1e-06 s"],
        ),
        (lambda: run_cases(MOTION, None, load_shipped_scene("three-tier")), ["cases: a NoneType; give Cases("]),
        # type: ignore[arg-type]
        (lambda: Body("square"), ["shape: 'square'; give 'rectangle'"]),
        (lambda: Scene(name="one"), ["elements: this key is needed"]),  # type: ignore[call-arg]
    ],
)
def test_the_error_names_an_argument_of_wrong_type_or_value(make: Callable[[], object], words: list[str]) -> None:
    with expect_error(ArgumentError, *words):
        make()


@pytest.mark.parametrize(
    ("keys", "word"),
    [
        ({"width": 1e300, "height": 1.0}, "width 1e+300 m; it must be 1e-06 to 1e+06 m"),
        ({"width": 1.0, "height": 1e-300}, "height 1e-300 m; it must be"),
        ({"width": 0.3, "height": 0.6, "depth": 1e300}, "depth 1e+300 m; it must be"),
        ({"width": 0.3, "height": 0.6, "depth": 1e-300}, "depth 1e-300 m; it must be"),
        ({"width": 1e200, "height": 1.0, "plan": 6}, "width 1e+200 m; it must be"),
        ({"vertices": [[0, 0], [1e300, 0], [0, 1]]}, "vertices 1e+300 m; a coordinate is at most 1e+06 m"),
        ({"pieces": [[[0, 0], [1, 0], [0, -1e300]]]}, "pieces -1e+300 m; a coordinate is at most"),
        ({"width": 0.3, "height": 0.6, "at": [1e300, 0]}, "at 1e+300 m; a coordinate is at most"),
    ],
)
def test_the_error_names_element_and_key_of_a_length_out_of_bounds(keys: dict[str, Any], word: str) -> None:
    with expect_error(ConfigError, f"element stone: {word}"):
        scene_of_elements({"name": "stone", "stands_on": "ground", **keys})


@pytest.mark.parametrize("depth", [1e-6, 1e6])
@pytest.mark.filterwarnings("error")
def test_a_stone_of_extreme_depth_is_simulated_in_3d_without_a_warning(depth: float) -> None:
    stone = scene_of_elements({"name": "stone", "stands_on": "ground", "width": 0.3, "height": 0.6, "depth": depth})
    assert np.isfinite(simulate(MOTION, stone, orientation_deg=0.0).status.item())


@pytest.mark.parametrize("direction", ["azimuth_deg", "orientation_deg"])
def test_the_error_names_a_reference_element_too_thin_for_a_stone(direction: str) -> None:
    """The reference element is the first free one, a levelling slab of 1 mm; the error proposes the key `reference`."""
    slab = {"name": "slab", "stands_on": "ground", "width": 0.5, "depth": 0.5, "height": 0.001}
    made = scene_of_elements(slab, {"name": "stone", "stands_on": "slab", "width": 0.3, "depth": 0.3, "height": 0.6})
    with expect_error(ArgumentError, "height: element slab of scene test is 0.001 m high", "reference:"):
        simulate(MOTION, made, **{direction: 0.0})


def test_models_with_a_contact_or_scene_of_a_wrong_type_are_refused() -> None:
    with expect_error(ConfigError, "scene: a dict", "path or name of a file"):
        load_scene({"name": "one"})  # type: ignore[arg-type]
    with expect_error(ArgumentError, "scene: 'three-tier'", "load_scene"):
        Stack("three-tier")  # type: ignore[arg-type]
    with expect_error(ArgumentError, "contact: Contact(", "VertexContact"):
        Stack(load_shipped_scene("three-tier"), contact=Contact())  # type: ignore[arg-type]
    with expect_error(ArgumentError, "contact: VertexContact(", "a Contact"):
        gravestone(contact=VertexContact())  # type: ignore[arg-type]
    with expect_error(ArgumentError, "aspect: [2.0]", "depths of its scene"):
        run_cases(MOTION, Cases([0.0], 0.636, 0.38, 0.5, aspect=2.0), Stack(load_shipped_scene("three-tier")))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"amplitude": [1.0, 2.0]}, ["amplitude: [1.0, 2.0]; give one number"]),
        ({"aftermath": "x"}, ["aftermath: 'x'; give one number"]),
        ({"aftermath": 1e6, "b_over_h": 0.2, "amplitude": 3.0}, ["trajectory: a path of", "a shorter aftermath"]),
    ],
)
def test_bad_arguments_of_a_stacks_trajectory_are_refused(options: dict[str, Any], words: list[str]) -> None:
    with expect_error(ArgumentError, *words):
        trajectory(MOTION, load_shipped_scene("three-tier"), orientation_deg=0.0, **options)


@pytest.mark.parametrize("model", [None, "three-tier", "circle", 6])
def test_aspect_is_refused_for_models_other_than_a_rectangle(model: Any) -> None:
    made = load_shipped_scene(model) if model == "three-tier" else model
    with expect_error(ArgumentError, "aspect: [1.0, 2.0]", "only a rectangle"):
        run_cases(MOTION, Cases(0.0, 0.6, 0.3, 1.0, aspect=[1.0, 2.0]), made)


def test_a_case_with_an_energy_error_has_no_overturning_flag_or_time() -> None:
    # A static penetration of a tenth of the width: rebounds leave the range of the contact law.
    soft = run_cases(
        Motion(ACCELERATION, ACCELERATION, sampling_interval=0.01),
        Cases(0.0, 0.6, [0.1, 0.2, 0.3], 1.0),
        gravestone(Contact(static_penetration=0.1)),
        time_step="1 stable",
    )
    marked = soft.status == CaseStatus.UNSTABLE
    assert marked.any()
    assert (soft.overturned[marked] == -128).all()
    assert np.isnan(soft.overturning_time[marked]).all()


def test_a_case_over_its_step_budget_is_marked_and_has_no_outcome() -> None:
    found = run_cases(MOTION, Cases(0.0, 0.6, 0.3, 1.0), budget=500)
    assert found.status.tolist() == [CaseStatus.OVER_BUDGET]
    assert found.overturned.tolist() == [-128]


def test_reruns_with_more_steps_count_against_the_step_budget_of_a_case(monkeypatch: pytest.MonkeyPatch) -> None:
    """A case whose energy never balances is run with 1, 4 and 16 times the steps unless its budget ends it earlier."""
    monkeypatch.setattr(balance, "MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO", -1.0)
    once = run_cases(MOTION, Cases(0.0, 0.6, 0.3, 1.0)).block_steps.item() / 21
    found = run_cases(MOTION, Cases(0.0, 0.6, 0.3, 1.0), budget=round(8 * once))
    assert found.status.tolist() == [CaseStatus.OVER_BUDGET]
    assert 7 * once < found.block_steps.item() < 9 * once


def test_a_case_ends_when_its_step_budget_is_used_up() -> None:
    """The budget of a scene counts the steps of all elements; a case may exceed its budget by the steps of a sample."""
    budget, step = 400_000, {"time_step": "0.02 stable", "leave_out": False}
    scene, cases = load_shipped_scene("three-tier"), Cases(0.0, 0.636, 0.38, 1.0)
    numerics = NumericalOptions(budget=budget, **step)
    stones, steps = (
        simulate_cases(scene, MOTION, cases, numerics),
        plan_simulation(PlanarModel(scene), MOTION, cases, numerics).steps_per_sample.item(),
    )
    assert stones.status.tolist() == [CaseStatus.OVER_BUDGET]
    assert stones.overturned.tolist() == [[-128] * 3]
    assert (
        budget / ELEMENT_STEP_COST_IN_BLOCK_STEPS
        <= stones.block_steps.item()
        < budget / ELEMENT_STEP_COST_IN_BLOCK_STEPS + 3 * steps
    )
    body = Cases(20.0, 0.6, 0.3, 1.0)
    solid, steps = (
        simulate_cases(RectangularPrism(), MOTION, body, numerics),
        plan_simulation(Body(RectangularPrism(), VertexContact()), MOTION, body, numerics).steps_per_sample.item(),
    )
    assert solid.status.tolist() == [CaseStatus.OVER_BUDGET]
    assert (
        budget / BODY_STEP_COST_IN_BLOCK_STEPS
        <= solid.block_steps.item()
        < budget / BODY_STEP_COST_IN_BLOCK_STEPS + steps
    )


def test_a_slab_rattling_under_a_million_times_heavier_stone_exceeds_its_budget() -> None:
    """The slab's contacts change in nearly every step, so steps are halved to the finest; it would take hours."""
    slab = {"name": "slab", "width": 0.5, "height": 0.1, "stands_on": "ground", "material": "light"}
    stone = {"name": "stone", "width": 0.3, "height": 0.8, "stands_on": "slab"}
    ground = {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]}
    densities = {"stone": {"density": 2650.0}, "light": {"density": 2650.0 * 4.8e-6}}
    soft = {"between": ["stone", "light"], "static_penetration": 2e-5}
    scene = parse_scene_content(
        {"name": "slab", "materials": densities, "contacts": [soft], "elements": [ground, slab, stone]}
    )
    wave = 8.0 * np.sin(12.0 * np.arange(600) * 0.01)
    motion = Motion(wave, 0 * wave, sampling_interval=0.01)
    found = simulate_cases(
        scene, motion, Cases(0.0, 0.1, 5.0, 1.0), NumericalOptions(budget=ELEMENT_STEP_COST_IN_BLOCK_STEPS * 200_000)
    )
    assert found.status.tolist() == [CaseStatus.OVER_BUDGET]
    assert found.block_steps.item() < 201_000
