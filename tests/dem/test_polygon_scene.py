"""Scene files: shipped scenes, fixed elements, and refusals that name the element and the remedy."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from overturning.dem.numerics import NumericalOptions
from overturning.dem.polygon.arrays import is_upright_rectangle_on_wide_driven_ground
from overturning.dem.polygon.prepare import prepare_scene
from overturning.dem.run import simulate_cases
from overturning.dem.simulate import simulate, simulate_as_arrays
from overturning.errors import ConfigError
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.geometry import (
    azimuth_period_of_outcome_deg,
    nearest_faces_and_separation,
    scale_and_place_elements,
)
from overturning.model.scene import Scene, load_scene, parse_scene_content
from overturning.model.stack_stones import stack_stones
from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import (
    GROUND,
    SHIPPED_SCENES,
    block_element,
    load_shipped_scene,
    motion_at_rest,
    motion_towards_north,
    plan_single_case,
    scene_of_elements,
)
from tests.dem.polygon_scenes import run_planned_case as run_from_start

LOW_BLOCK = {"name": "low", "width": 1.0, "height": 0.5, "stands_on": "ground"}


@pytest.mark.parametrize("name", SHIPPED_SCENES)
def test_shipped_scenes_are_at_rest_and_cannot_rock_below_a_quarter_g(name: str) -> None:
    prepared = prepare_scene(load_shipped_scene(name))
    assert prepared.has_static_equilibrium
    assert prepared.no_rocking_below_acceleration_g > 0.25


def test_only_symmetric_scenes_have_an_azimuth_period_of_180_degrees() -> None:
    assert [azimuth_period_of_outcome_deg(load_shipped_scene(name)) for name in SHIPPED_SCENES] == [180, 180, 360, 360]


def test_only_the_gravestone_of_the_shipped_scenes_is_a_single_block() -> None:
    assert [load_shipped_scene(name).can_use_single_block_kernel for name in SHIPPED_SCENES] == [
        True,
        False,
        False,
        False,
    ]


def test_the_automatic_contact_of_a_block_equals_that_of_the_block_kernel() -> None:
    made = load_shipped_scene("gravestone")
    prepared = prepare_scene(made, reference_element_height=1.2, reference_element_b_over_h=0.3)
    stone = prepared.elements[1]
    normal, tangential, dashpot = made.contact_law(
        *made.elements
    ).contact_without_friction.corner_stiffness_and_damping_per_mass(0.36, 1.2, 2650.0)
    assert made.contact_law(*made.elements).contact_without_friction == Contact()
    assert prepared.pair_contact_laws.normal_stiffness[0] / stone.mass == pytest.approx(float(normal), rel=1e-12)
    assert prepared.pair_contact_laws.tangential_stiffness[0] / stone.mass == pytest.approx(
        float(tangential), rel=1e-12
    )
    assert prepared.pair_contact_laws.dashpot_coefficient[0] / stone.mass == pytest.approx(float(dashpot), rel=1e-12)


def test_each_contact_of_a_stack_carries_the_weight_above_it() -> None:
    prepared = prepare_scene(load_shipped_scene("three-tier"))
    weight = [item.mass * 9.80665 for item in prepared.elements[1:]]
    carried = dict(
        zip((pair[:2] for pair in prepared.pairs), prepared.pair_contact_laws.carried_weight_at_rest, strict=True)
    )
    assert carried[(1, 0)] == pytest.approx(sum(weight), rel=1e-9)
    assert carried[(2, 1)] == pytest.approx(sum(weight[1:]), rel=1e-9)
    assert carried[(3, 2)] == pytest.approx(weight[2], rel=1e-9)


def test_height_scales_all_lengths_and_b_over_h_only_the_reference_element() -> None:
    made = load_shipped_scene("three-tier")
    base, thin = (
        scale_and_place_elements(made),
        scale_and_place_elements(made, reference_element_height=2 * 0.636, reference_element_b_over_h=0.2),
    )
    assert thin[3].shape.width == pytest.approx(0.2 * 2 * 0.636)
    assert thin[2].shape.width == pytest.approx(2 * base[2].shape.width)
    assert thin[3].vertices_in_scene[:, 1].min() == pytest.approx(2 * base[3].vertices_in_scene[:, 1].min())


@pytest.mark.parametrize("plan", ["circle", 8])
def test_the_mass_of_a_prism_follows_the_width_given_by_b_over_h(plan: str | int) -> None:
    """A shaft 0.3 m wide has the mass of one drawn 0.12 m wide that B/H = 0.5 makes 0.3 m wide, in 2-D and 3-D."""

    def scene_of_shaft_on_foot(width: float) -> Scene:
        """Return a scene of a shaft, `width` m wide, on a foot."""
        foot = {"name": "foot", "plan": plan, "width": 0.3, "height": 0.9, "stands_on": "ground"}
        shaft = {"name": "shaft", "plan": plan, "width": width, "height": 0.6, "stands_on": "foot"}
        return scene_of_elements(foot, shaft, reference="shaft")

    drawn, given = (
        scale_and_place_elements(scene_of_shaft_on_foot(width), reference_element_b_over_h=0.5) for width in (0.3, 0.12)
    )
    assert given[2].mass == pytest.approx(drawn[2].mass, rel=1e-12)
    assert given[2].inertia_about_centre_of_mass == pytest.approx(drawn[2].inertia_about_centre_of_mass, rel=1e-12)
    in_space = [stack_stones(scene_of_shaft_on_foot(width), 0.6, 0.5)[1] for width in (0.3, 0.12)]
    assert in_space[0].mass == pytest.approx(in_space[1].mass, rel=1e-12)
    assert in_space[0].mass == pytest.approx(drawn[2].mass, rel=1e-3 if plan == "circle" else 1e-12)


@pytest.mark.parametrize("gap", [1.59, 1.61, 2.0])
def test_a_wall_fixed_in_space_stops_a_stone_carried_towards_it(gap: float) -> None:
    """The ground moves by 4 m below a wall fixed in space; the wall stops the stone, and the ground slides on below."""
    t = np.arange(0, 30, 0.01)
    motion = motion_towards_north(0.25 * np.sin(0.4 * np.pi * (t - 1)) * ((t >= 1) & (t < 21)))
    wall = {"name": "wall", "kind": "held", "width": 0.5, "height": 1.5, "at": [0.3 + gap, 0]}
    found = simulate(
        motion, scene_of_elements(block_element("stone", 0.1, 0.3), wall), azimuth_deg=[0.0], friction=[0.5]
    )
    assert found.residual_slip.item() == pytest.approx(gap - motion.displacement[0].max(), abs=1e-5)


def test_a_contact_that_carries_hardly_any_weight_still_gets_stiff_springs() -> None:
    """Two stones that stand flush sink in unequally and press on each other with a ten-thousandth of their weight."""
    flush = scene_of_elements(block_element("one", 0.44, 1.01), block_element("other", 0.47, 1.13, x=0.455))
    prepared = prepare_scene(flush)
    carried = prepared.pair_contact_laws.carried_weight_at_rest
    assert 0.0 < carried[carried > 0.0].min() < 1e-3 * carried.max()
    assert prepared.pair_contact_laws.gravity_load_for_contact_stiffness.min() > 0.1 * carried.max()
    found = simulate(motion_at_rest(0.1), flush, azimuth_deg=[0.0], friction=[0.6])
    assert found.status.item() in (CaseStatus.SIMULATED, CaseStatus.AT_REST)


@pytest.mark.parametrize(
    ("ground", "stone", "keys"),
    [
        ({"width": 6.2}, {}, {}),
        ({"at": [10.0, -1]}, {"at": [10.0, 0]}, {}),
        ({}, {"depth": 4.0}, {"contacts": [{"between": ["stone", "stone"], "stiffness": 5e7}]}),
    ],
    ids=["a ground that ends", "beside the middle of the ground", "a contact over the depth of the ground"],
)
def test_a_block_beyond_the_assumptions_of_the_block_kernel_is_simulated_as_a_scene(
    ground: dict[str, Any], stone: dict[str, Any], keys: dict[str, Any]
) -> None:
    """Ground that ends 3.1 m from its middle, a block 10 m off the origin, and a depth of 4 m on ground 1 m deep."""
    assert scene_of_elements(GROUND, block_element("stone", 0.2, 0.8)).can_use_single_block_kernel
    assert not scene_of_elements(
        {**GROUND, **ground}, {**block_element("stone", 0.2, 0.8), **stone}, **keys
    ).can_use_single_block_kernel


def test_the_nearest_faces_of_two_elements_are_those_that_face_most_directly() -> None:
    """Below 45° of rotation the lower side faces the ground most directly, above 45° the next side."""
    for angle, face in ((0.0, 0), (30.0, 0), (44.9, 0), (45.1, 1), (80.0, 1)):
        made = scene_of_elements(
            GROUND, {**LOW_BLOCK, "rotation_deg": angle, "at": [0, 1e-9]}, block_element("on", 0.1, 0.1, x=5)
        )
        placed = scale_and_place_elements(made)
        found = nearest_faces_and_separation(placed[1], placed[0])
        assert found[:2] == (face, 2), angle
        assert found[2] == pytest.approx(1e-9, abs=1e-12)


def test_elements_separated_by_a_single_side_do_not_overlap() -> None:
    """A ridge 1 cm next to a block: only the side of the block separates them, no side of the ridge does."""
    ridge = {"name": "ridge", "vertices": [[0, 0], [0.4, 0], [0.6, 0.3], [0.4, 0.6], [0, 0.6]], "stands_on": "ground"}
    tip = scale_and_place_elements(scene_of_elements(GROUND, ridge | {"at": [0, 0]}))[1].vertices_in_scene[:, 0].max()

    def block_beside_ridge(gap: float) -> Scene:
        """Return a scene of the ridge and a block, `gap` m from the tip of the ridge; negative if they overlap."""
        return scene_of_elements(
            GROUND, ridge | {"at": [0, 0]}, block_element("block", 0.4, 0.6, x=float(tip + gap + 0.2))
        )

    assert {(1, 0), (2, 0), (2, 1)} <= {pair[:2] for pair in prepare_scene(block_beside_ridge(0.01)).pairs}
    with pytest.raises(ConfigError, match=r"overlaps ridge by 0\.01 m"):
        block_beside_ridge(-0.01)


@pytest.mark.parametrize("height", [0.6, 2.0])
def test_a_case_becomes_undecided_20_over_p_after_the_record(height: float) -> None:
    """Housner's frequency parameter of a block is p = √(3g/4R), with half the diagonal R (Housner 1963)."""
    motion = motion_at_rest(1.0)
    how = plan_single_case(scene_of_elements(block_element("block", 0.4 * height, height)), motion)
    p = np.sqrt(0.75 * 9.80665 / (0.5 * np.hypot(0.4 * height, height)))
    assert (how.case_table["end_sample_if_undecided"][0] - motion.sample_count) * 0.01 == pytest.approx(
        20 / p, abs=0.011
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"elements": [GROUND, {**LOW_BLOCK, "at": [0, -0.1]}]}, "element low: overlaps ground by 0.1 m"),
        ({"elements": [GROUND, {**LOW_BLOCK, "at": [0, 0.2]}]}, "element low: hangs in the air.*stands_on"),
        ({"elements": [GROUND, LOW_BLOCK, {**LOW_BLOCK, "name": "up", "at": [3, 2]}]}, "element up: hangs in the air"),
        ({"elements": [LOW_BLOCK | {"stands_on": None}, {**LOW_BLOCK, "name": "up", "stands_on": "low"}]},
        "no element is driven.*kind: driven"),
        ({"elements": [GROUND, {**GROUND, "name": "wall", "at": [30, 0]}]}, "no element is free"),
        ({"elements": [GROUND, LOW_BLOCK, LOW_BLOCK]}, "element low is listed twice"),
        ({"elements": [GROUND, {**LOW_BLOCK, "stands_on": "grund"}]}, "stands_on 'grund' is not an element"),
        ({"elements": [GROUND, {**LOW_BLOCK, "material": "jade"}]}, "no material 'jade'; known: stone"),
        ({"elements": [GROUND, {**LOW_BLOCK, "vertices": [[0, 0], [1, 0], [0, 1]]}]},
        "either width and height, or vertices"),
        ({"elements": [GROUND, {"name": "p", "vertices": [[0, 0], [0, 1], [1, 0]]}]},
        "element p: the polygon runs clockwise"),
        ({"elements": [GROUND, {**LOW_BLOCK, "hight": 2}]}, "elements.low.hight: unknown key"),
        ({"elements": [GROUND, {**LOW_BLOCK, "width": -1}]}, "elements.low.width: .*greater than 0"),
        ({"reference": "shaft"}, "reference: no element 'shaft'; known: ground, low"),
        ({"reference": "ground"}, "reference: ground is the ground of a single block; leave it out, or name low"),
        ({"contacts": [{"between": ["stone", "wood"]}]}, "contacts: no material 'wood'"),
        ({"contacts": [{"between": ["stone", "stone"], "damping": 1, "damping_ratio": 1}]}, "both given; keep one"),
        ({"contacts": [{"between": ["stone", "stone"], "stiffness": 1e7, "static_penetration": 1e-6}]},
        r"contacts.0: static_penetration 1e-06 and stiffness 1e\+07 N/m are both given; keep one"),
        ({"elements": [GROUND | {"fallen_rotation_deg": 60}, LOW_BLOCK]},
        "element ground: fallen_rotation_deg 60; what is driven cannot fall: leave it out"),
        ({"elements": [GROUND, LOW_BLOCK,
                       {**GROUND, "name": "wall", "kind": "held", "at": [30, 0], "fallen_drop": 0.2}]},
        "element wall: fallen_drop 0.2 m; what is held cannot fall: leave it out"),
    ],
)  # fmt: skip
def test_inconsistent_scene_entries_are_refused_with_the_reason(change: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        parse_scene_content({"name": "test", "elements": [GROUND, LOW_BLOCK], **change}, "scene.yaml")


def test_the_error_names_a_scene_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no file.*known: .*gravestone"):
        load_scene("gone", tmp_path)
    (tmp_path / "bad.yaml").write_text("elements: [", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"bad.yaml, line 1: not valid YAML"):
        load_scene("bad.yaml", tmp_path)
    (tmp_path / "list.yaml").write_text("- 1", encoding="utf-8")
    with pytest.raises(ConfigError, match="a mapping"):
        load_scene("list.yaml", tmp_path)


def test_the_boulder_has_its_closed_form_critical_angle() -> None:
    prepared = prepare_scene(load_shipped_scene("boulder"))
    assert np.isfinite(prepared.pair_contact_laws.normal_stiffness).all()
    assert prepared.weaker_side_critical_angles_else_fall_angles[1] == pytest.approx(
        np.arctan2(0.2 - (prepared.elements[1].centre_of_mass_x - 0.02), prepared.elements[1].centre_of_mass_z),
        rel=1e-9,
    )


@pytest.mark.parametrize(
    ("elements", "alone"),
    [
        ([block_element("stone", 0.3, 0.6)], True),
        ([block_element("stone", 0.3, 0.6, x=2.0)], True),
        ([block_element("stone", 0.3, 0.6, fallen_rotation_deg=120)], False),
        ([block_element("stone", 0.3, 0.6, rotation_deg=90)], False),
        ([{"name": "stone", "vertices": [[-0.2, 0], [0.2, 0], [0, 0.6]], "stands_on": "ground"}], False),
        ([block_element("stone", 3.0, 1.0)], False),  # too large for this ground
        ([block_element("stone", 0.3, 0.6), block_element("cap", 0.2, 0.1, "stone")], False),
    ],
)
def test_only_a_lone_upright_rectangle_on_wide_ground_is_recognised_as_such(
    elements: list[dict[str, object]], alone: bool
) -> None:
    assert is_upright_rectangle_on_wide_driven_ground(scale_and_place_elements(scene_of_elements(*elements))) == alone


@pytest.mark.parametrize("height", [0.02, 0.6, 3.0])
def test_the_ground_is_long_enough_for_any_stone_to_slide_on(height: float) -> None:
    """A frictionless stone of any size stays in place while the ground moves by A T²/2π below it."""
    time = np.arange(0.0, 3.0, 0.01)
    motion = motion_towards_north(np.where(time <= 2.0, 5.0 * np.sin(np.pi * time), 0.0))
    found = simulate_cases(
        load_shipped_scene("shaft-alone"), motion, Cases(0.0, height, 0.5, 0.0), NumericalOptions(general=True)
    )
    assert found.overturned.tolist() == [0]
    np.testing.assert_allclose(found.peak_slip, 5.0 * 2.0**2 / (2.0 * np.pi), rtol=1e-3)


def test_an_element_past_the_end_of_the_ground_has_a_missing_outcome() -> None:
    """Below a frictionless stone, ground 40 m wide moves by 8 m in 2 s and then at 8 m/s, past its end."""
    motion = motion_towards_north(np.where(np.arange(450) < 200, 4.0, 0.0))
    found = simulate_cases(
        load_shipped_scene("shaft-alone"), motion, Cases(0.0, 0.6, 0.5, 0.0), NumericalOptions(general=True)
    )
    assert found.status.tolist() == [CaseStatus.UNSTABLE]
    assert found.overturned.tolist() == [INT8_MISSING]


def test_stone_on_shelf_fixed_in_space_does_not_rock() -> None:
    """Elements of kind `held` are fixed in space while the ground moves."""
    shelf = {"name": "shelf", "kind": "held", "width": 2.0, "height": 0.5, "at": [5, 0.1]}
    made = scene_of_elements(GROUND, shelf, block_element("stone", 0.2, 0.8, "shelf"), block_element("other", 0.2, 0.8))
    time = np.arange(0, 2, 0.01)
    motion = motion_towards_north(np.where(time < 1, 6.0 * np.sin(2 * np.pi * time), 0.0))
    answers, at, poses = run_from_start(plan_single_case(made, motion), motion)
    # ü = A sin ωt for one period gives the ground u = A t/ω − A sin(ωt)/ω²; in its frame the shelf moves the
    # other way.
    omega = 2 * np.pi
    exact = np.where(at < 1, 6.0 * (at / omega - np.sin(omega * at) / omega**2), 6.0 / omega)
    shelf_way, stone_way = (poses[:, k, 0] - poses[0, k, 0] for k in (1, 2))
    assert shelf_way == pytest.approx(-exact, abs=2e-3 * exact.max())
    assert np.abs(stone_way - shelf_way).max() < 1e-8
    assert np.abs(poses[:, 2, 2]).max() < 1e-8
    # The stone on the ground is shaken.
    assert np.abs(poses[:, 3, 2]).max() > 0.05
    assert answers.overturned[0, 0] == 0


@pytest.mark.parametrize("rise", [1.0, -1.0])
def test_stones_on_a_fixed_shelf_stand_when_the_ground_rises(rise: float) -> None:
    """The ground rises by A T²/2π = 1.3 m towards two stones on a fixed shelf, which do not move."""
    shelf = {"name": "shelf", "kind": "held", "width": 2.0, "height": 0.5, "at": [0, 3.0]}
    stones = (
        block_element("stone", 0.3, 0.6, "shelf"),
        block_element("upper", 0.2, 0.4, "stone"),
        block_element("below", 0.3, 0.6),
    )
    made = scene_of_elements(GROUND, shelf, *stones)
    time = np.arange(0, 4, 0.01)
    up = np.where(time < 2, rise * 2.0 * np.sin(np.pi * time), 0.0)
    motion = Motion(0.001 * up, 0 * up, up, sampling_interval=0.01)
    assert motion.displacement[2][-1] == pytest.approx(rise * 2.0 * 4.0 / (2.0 * np.pi), rel=1e-3)
    found = simulate_as_arrays(motion, made, azimuth_deg=[0.0], friction=[0.6])
    assert found["overturned"].ravel().tolist() == [0, 0, 0]
    assert np.abs(found["peak_slip"]).max() < 1e-3
