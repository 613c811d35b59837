"""Falls of stones of a 3-D stack: from a stone that moves, one after the other, in free flight; scenes refused."""

import re
from typing import Any

import numpy as np
import pytest

from overturning.dem.simulate import simulate
from overturning.dem.stack.statics import joint_constants_of_stack, stone_constants_and_initial_states_table
from overturning.dem.trajectory import trajectory
from overturning.errors import ArgumentError
from overturning.model.contact import VertexContact
from overturning.model.scene import Scene
from overturning.model.shapes import Polyhedron
from overturning.model.stack import Stack
from overturning.model.stack_checks import reasons_scene_is_no_stack, unsimulated_overhang_contact_warnings
from overturning.model.stack_stones import stack_stones
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY as GRAVITY
from tests.expect import expect_error
from verification.reference.sliding import peak_and_final_slip

Rectangles = list[list[list[float]]]


def stack_of_stones(*stones: dict[str, Any], **more: Any) -> Scene:
    """Return a scene of stones on a wide ground, each on the one before; keys are those of a scene file."""
    elements: list[dict[str, Any]] = [
        {"name": "ground", "kind": "driven", "width": 40.0, "height": 1.0, "at": (0.0, -1.0)}
    ]
    for number, stone in enumerate(stones):
        elements.append({"name": f"stone-{number}", "stands_on": elements[-1]["name"], **stone})
    return Scene.model_validate({"name": "test", "reference": elements[-1]["name"], "elements": elements, **more})


def motion_towards_north(samples: np.ndarray) -> Motion:
    """Return a motion towards north with samples every 0.01 s, m/s²."""
    return Motion(samples, np.zeros(samples.size), sampling_interval=0.01, trust_data=True)


def half_sine_pulse(time: np.ndarray, begin: float, end: float, peak: float) -> np.ndarray:
    """Return a half sine between two times, s, with a peak, and 0 outside."""
    inside = (time > begin) & (time < end)
    return np.where(inside, peak * np.sin(np.pi * (time - begin) / (end - begin)), 0.0)


def test_a_stone_that_slid_off_keeps_this_outcome_if_its_support_falls_later() -> None:
    time = np.arange(0.0, 12.0, 0.01)
    scene = stack_of_stones(
        {"width": 0.4, "depth": 0.4, "height": 1.0}, {"width": 0.4, "depth": 0.4, "height": 0.2, "material": "slick"},
        materials={"stone": {}, "slick": {}},
        contacts=[{"between": ("stone", "stone"), "friction": 1.0}, {"between": ("stone", "slick"), "friction": 0.05}],
    )  # fmt: skip
    early = half_sine_pulse(time, 1.0, 2.6, 2.0)
    for motion, pillar_falls in ((early, 0.0), (early + half_sine_pulse(time, 8.0, 9.0, 8.0), 1.0)):
        found = simulate(motion_towards_north(motion), scene, orientation_deg=[0.0])
        assert found.overturned.to_numpy().ravel().tolist() == [pillar_falls, 1.0]
        assert found.slid_off.to_numpy().ravel().tolist() == [0.0, 1.0]
        assert found.overturning_time.to_numpy().ravel()[1] == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize(("offset", "peak"), [(0.0, 12.0), (-0.1, 6.0)])
def test_a_thin_stone_on_a_rocking_stone_that_comes_back_has_not_fallen(offset: float, peak: float) -> None:
    """The cap sinks by far more than a tenth of its height as the pillar leans, but stays in full contact with it."""
    time = np.arange(0.0, 6.0, 0.01)
    rough = [{"between": ("stone", "stone"), "friction": 3.0}]
    scene = stack_of_stones(
        {"width": 0.3, "depth": 0.3, "height": 0.6}, {"width": 0.24, "depth": 0.24, "height": 0.04, "at": (offset, 0)},
        contacts=rough,
    )  # fmt: skip
    inside = (time > 0.5) & (time < 1.1)
    motion = motion_towards_north(np.where(inside, -peak * np.sin(2.0 * np.pi * (time - 0.5) / 0.6), 0.0))
    found = simulate(motion, scene, orientation_deg=[0.0])
    assert found.overturned.to_numpy().ravel().tolist() == [0.0, 0.0]
    pillar, cap = found.peak_tilt.to_numpy().ravel()
    assert pillar > 10.0
    assert cap == pytest.approx(pillar, abs=1e-3)
    in_plane = simulate(motion, scene, azimuth_deg=[0.0])
    assert in_plane.overturned.to_numpy().ravel().tolist() == [0.0, 0.0]


def test_a_stone_that_slides_off_a_stone_that_leans_has_fallen() -> None:
    """The pillar leans towards the push, while a cap without friction lags behind and drops beside the pillar."""
    time = np.arange(0.0, 5.0, 0.01)
    smooth = [{"between": ("stone", "slick"), "friction": 0.0}, {"between": ("stone", "stone"), "friction": 3.0}]
    scene = stack_of_stones(
        {"width": 0.3, "depth": 0.3, "height": 0.6}, {"width": 0.2, "depth": 0.2, "height": 0.04, "material": "slick"},
        contacts=smooth, materials={"stone": {}, "slick": {}},
    )  # fmt: skip
    found = simulate(motion_towards_north(half_sine_pulse(time, 0.5, 1.5, 4.0)), scene, orientation_deg=[0.0])
    assert found.overturned.to_numpy().ravel()[1] == 1.0
    assert found.slid_off.to_numpy().ravel()[1] == 1.0


def test_a_fallen_stone_flies_relative_to_the_base_that_accelerates() -> None:
    """At a constant acceleration a of the base, a fallen stone moves as in a throw with the acceleration −a − g."""
    time = np.arange(0.0, 4.0, 0.01)
    push = np.interp(time, [0.0, 1.0, 3.5, 4.0], [0.0, 6.0, 6.0, 0.0])
    lift = np.interp(time, [0.0, 1.0, 3.5, 4.0], [0.0, -3.0, -3.0, 0.0])
    scene = stack_of_stones({"width": 0.6, "depth": 0.6, "height": 2.0}, {"width": 0.3, "depth": 0.3, "height": 0.5},
                    contacts=[{"between": ("stone", "stone"), "friction": 2.0}])  # fmt: skip
    motion = Motion(push, np.zeros(push.size), lift, sampling_interval=0.01, trust_data=True)
    path = trajectory(motion, scene, orientation_deg=0.0, aftermath=1.0)
    place, velocity = path["place"].to_numpy()[:, 1], path["velocity"].to_numpy()[:, 1]
    last = int(np.flatnonzero(path["simulated"].to_numpy()[:, 1] > 0.0)[-1])
    for later in (last + 5, last + 20):
        passed = float(path["time"].to_numpy()[later] - path["time"].to_numpy()[last])
        thrown = velocity[last] * passed + 0.5 * np.array([0.0, -6.0, 3.0 - GRAVITY]) * passed**2
        np.testing.assert_allclose(place[later] - place[last], thrown, atol=1e-9)


CUBE_SIZE: dict[str, Any] = {"width": 0.5, "depth": 0.5, "height": 0.5}


@pytest.mark.parametrize(
    ("below", "stone", "rim", "peak"),
    [
        ({"width": 0.5, "depth": 0.5, "height": 0.3}, {**CUBE_SIZE, "at": (0.2, 0.0)}, 0.05, 4.0),
        ({"vertices": [[-0.5, 0.0], [0.5, 0.0], [0.15, 0.3], [-0.15, 0.3]], "depth": 0.5}, CUBE_SIZE, 0.15, 9.0),
        ({"width": 1.5, "depth": 1.5, "height": 0.3}, CUBE_SIZE, 0.25, 14.0),
    ],
)
def test_a_stone_is_upright_until_its_centre_passes_the_edge_that_it_tips_over(
    below: dict[str, Any], stone: dict[str, Any], rim: float, peak: float
) -> None:
    """A stone falls when its tilt passes atan(`rim`/0.25 m), by its trajectory and in the 2-D scene."""
    time = np.arange(0.0, 4.0, 0.005)
    wave = np.where(time < 0.8, -peak * np.sin(2.0 * np.pi * time / 0.8), 0.0)
    motion = Motion(wave, 0.0 * wave, sampling_interval=0.005)
    scene = stack_of_stones(below, stone, contacts=[{"between": ("stone", "stone"), "friction": 2.0}])
    plane = simulate(motion, scene, azimuth_deg=0.0)
    path = trajectory(motion, scene, orientation_deg=0.0)
    assert path["overturned"].to_numpy().tolist() == np.abs(plane.overturned.to_numpy().ravel()).tolist() == [0.0, 1.0]
    tilt = np.hypot(path["tilt_north"], path["tilt_east"]).to_numpy()[:, 1]
    computed = path["simulated"].to_numpy()[:, 1] > 0.0
    upright = path["time"].to_numpy()[computed & (tilt < np.sin(np.arctan(rim / 0.25)))]
    found = float(path["overturning_time"].to_numpy()[1])
    assert upright[-1] <= found < upright[-1] + 0.006
    assert found == pytest.approx(float(plane.overturning_time.to_numpy().ravel()[1]), abs=0.01)


def test_the_critical_angle_of_a_slab_held_down_by_a_stone_is_that_of_both() -> None:
    """The slab's centre is 0.05 m beyond the rim; that of both stones is 0.16 m inside the rim and 0.23 m above it."""
    stones = Stack(stack_of_stones(
        CUBE_SIZE, {"width": 1.0, "depth": 0.5, "height": 0.1, "at": (0.3, 0.0)},
        {"width": 0.3, "depth": 0.5, "height": 0.5, "at": (-0.35, 0.0)},
    )).stones()  # fmt: skip
    table = stone_constants_and_initial_states_table(stones, joint_constants_of_stack(stones, VertexContact()))
    assert np.degrees(np.arcsin(np.sqrt(table["critical_lean_squared_sine_on_contact_at_rest"]))) == pytest.approx(
        np.degrees(np.arctan([1.0, 0.16 / 0.23, 0.15 / 0.25]))
    )


def rectangle_outline(left: float, right: float, low: float, high: float) -> list[list[float]]:
    """Return the outline of a rectangle from the coordinates of its four sides, m."""
    return [[left, low], [right, low], [right, high], [left, high]]


CUP_PIECES: Rectangles = [
    rectangle_outline(-0.3, 0.3, 0.0, 0.1),
    rectangle_outline(-0.3, -0.2, 0.1, 0.3),
    rectangle_outline(0.2, 0.3, 0.1, 0.3),
]
RECTANGLES_OF_TABLE_SHAPED_STONE: Rectangles = [
    rectangle_outline(-0.3, -0.2, 0.0, 0.3),
    rectangle_outline(0.2, 0.3, 0.0, 0.3),
    rectangle_outline(-0.3, 0.3, 0.3, 0.4),
]
BOX_SIZE: dict[str, Any] = {"width": 0.5, "depth": 0.4, "height": 0.3}


@pytest.mark.parametrize(
    ("stones", "reason"),
    [
        (({"pieces": CUP_PIECES, "depth": 0.4}, BOX_SIZE), "stone-0 has a gap in its upper face"),
        (
            (BOX_SIZE, {"pieces": RECTANGLES_OF_TABLE_SHAPED_STONE, "depth": 0.4, "at": (0.1, 0.0)}),
            "stone-1 has a gap in its base",
        ),
    ],
)
def test_a_contact_face_with_a_gap_is_refused_in_a_stack(stones: tuple[dict[str, Any], ...], reason: str) -> None:
    """The contact of two stones is one polygon: over a gap it would carry a stone that falls into the gap."""
    motion = motion_towards_north(np.full(100, 0.001))
    with expect_error(ArgumentError, reason, "compute it in 2-D"):
        simulate(motion, stack_of_stones(*stones), orientation_deg=[0.0])


def shouldered_stone(height: float, depth: float = 0.6) -> dict[str, Any]:
    """Return a stone 0.6 m wide whose base is 0.2 m wide; its sides slope up to full width at `height`, m."""
    slopes = [[-0.1, 0.0], [0.1, 0.0], [0.3, height], [0.3, 1.0], [-0.3, 1.0], [-0.3, height]]
    return {"vertices": slopes, "depth": depth}


PIECES_OF_STONE_ON_LOW_NARROW_FOOT: Rectangles = [
    rectangle_outline(-0.1, 0.1, 0.0, 0.02),
    rectangle_outline(-0.3, 0.3, 0.02, 1.0),
]


@pytest.mark.parametrize(
    ("stone", "support", "tilt_deg"),
    [
        (shouldered_stone(0.02), None, np.degrees(np.arctan(0.02 / 0.2))),
        (shouldered_stone(0.02), 1.0, np.degrees(np.arctan(0.02 / 0.2))),
        # The shoulder hangs beyond the rim; the slope below it touches the rim.
        (shouldered_stone(0.02), 0.4, np.degrees(np.arctan(0.02 / 0.2))),
        # The lower face ends within the base, and the stone tips over its rim.
        (shouldered_stone(0.02), 0.15, None),
        # Level shoulders: nearest to the rim, 0.15 m and 0.01 m from the base.
        ({"pieces": PIECES_OF_STONE_ON_LOW_NARROW_FOOT, "depth": 0.6}, None, np.degrees(np.arctan(0.02 / 0.2))),
        ({"pieces": PIECES_OF_STONE_ON_LOW_NARROW_FOOT, "depth": 0.6}, 0.5, np.degrees(np.arctan(0.02 / 0.15))),
        ({"pieces": PIECES_OF_STONE_ON_LOW_NARROW_FOOT, "depth": 0.6}, 0.22, None),
        # Along the outline the stone tips first; over a corner of a deep base it tips later, and meets the ground.
        (shouldered_stone(0.06, depth=0.6), None, np.degrees(np.arctan(0.06 / (0.2 * np.cos(np.radians(5.0)))))),
        (shouldered_stone(0.06, depth=0.1), None, None),
        (shouldered_stone(0.15), None, None),
    ],
)
def test_a_stone_whose_outline_touches_its_support_before_it_tips_is_refused(
    stone: dict[str, Any], support: float | None, tilt_deg: float | None
) -> None:
    """A point at height z and distance d beyond the edge of the base touches at the tilt atan(z/d)."""
    below = () if support is None else ({"width": support, "depth": 0.6, "height": 0.3},)
    faults = reasons_scene_is_no_stack(stack_of_stones(*below, stone))
    if tilt_deg is None:
        assert faults == []
        return
    (fault,) = faults
    assert f"outline of element stone-{len(below)} would meet the face below" in fault
    assert ("polyhedron" in fault) == (support is None)
    touching, critical = (float(text) for text in re.findall(r"([\d.]+)°", fault))
    # Points that divide the outline stand for those between them.
    assert touching == pytest.approx(tilt_deg, rel=0.03)
    assert touching < critical


def stack_of_plates_below_overhanging_cube(*plates: dict[str, Any], at: float = 0.0) -> Scene:
    """Return a stack of plates, lowest first, and a cube of 0.6 m that overhangs them, shifted by ``at``, m."""
    return stack_of_stones(*plates, {"width": 0.6, "depth": 0.6, "height": 0.6, "at": (at, 0.0)})


def square_plate(width: float, height: float, **others: Any) -> dict[str, Any]:
    """Return a square plate, width and height in m."""
    return {"width": width, "depth": width, "height": height, **others}


DIAGONAL_OVERHANG = np.hypot(0.1, 0.1)
"""Overhang of the cube over a corner of a plate 0.4 m wide, m; on this corner it balances at 43.3°."""


@pytest.mark.parametrize(
    ("plates", "at", "met", "tilt_deg"),
    [
        ([square_plate(0.4, 0.03)], 0.0, "the ground", np.degrees(np.arcsin(0.03 / DIAGONAL_OVERHANG))),
        ([square_plate(0.4, 0.09)], 0.0, "the ground", np.degrees(np.arcsin(0.09 / DIAGONAL_OVERHANG))),
        ([square_plate(0.4, 0.1)], 0.0, None, None),
        ([square_plate(0.6, 0.02)], 0.0, None, None),
        # The cube's overhang, 0.15 m by 0.1 m, is larger on the side to which it is shifted.
        ([square_plate(0.4, 0.06)], 0.05, "the ground", np.degrees(np.arcsin(0.06 / np.hypot(0.15, 0.1)))),
        # A wide plate is met at the depth of the narrow one on it.
        (
            [square_plate(1.0, 0.3), square_plate(0.4, 0.03)],
            0.0,
            "stone-0",
            np.degrees(np.arcsin(0.03 / DIAGONAL_OVERHANG)),
        ),
        # The corner passes outside the lowest plate, whose own corner meets the cube's base.
        (
            [square_plate(0.5, 0.3), square_plate(0.4, 0.01)],
            0.0,
            "stone-0",
            np.degrees(np.arctan(0.02 / DIAGONAL_OVERHANG)),
        ),
        # The lowest plate is as wide as the narrow one, and high.
        ([square_plate(0.4, 0.3), square_plate(0.4, 0.03)], 0.0, None, None),
    ],
)
def test_a_warning_names_a_face_that_an_overhanging_stone_meets_before_it_tips(
    plates: list[dict[str, Any]], at: float, met: str | None, tilt_deg: float | None
) -> None:
    """A point that overhangs by a meets a face at a depth h below the contact when the stone tilts by asin(h/a)."""
    touches = unsimulated_overhang_contact_warnings(
        stack_stones(stack_of_plates_below_overhanging_cube(*plates, at=at))
    )
    if met is None:
        assert touches == []
        return
    (touch,) = touches
    assert f"element stone-{len(plates)} overhangs, and would meet {met}" in touch
    touching, critical = (float(text) for text in re.findall(r"([\d.]+)°", touch))
    assert touching == pytest.approx(tilt_deg, rel=0.01)
    assert touching < critical


def test_an_outline_meeting_the_face_below_is_refused_even_if_ground_is_met_first() -> None:
    """The stone meets the rim of the plate at atan(0.02/0.15) = 7.6°; on a thin plate it meets the ground at 6.6°."""
    for thickness in (0.3, 0.003):
        scene = stack_of_stones(
            {"width": 0.5, "depth": 0.6, "height": thickness},
            {"pieces": PIECES_OF_STONE_ON_LOW_NARROW_FOOT, "depth": 0.6},
        )
        (fault,) = reasons_scene_is_no_stack(scene)
        assert "outline of element stone-1 would meet the face below" in fault
        touches = unsimulated_overhang_contact_warnings(stack_stones(scene))
        assert ["would meet the ground" in touch for touch in touches] == [True] * (thickness < 0.1)


@pytest.mark.parametrize(("height", "is_met"), [(0.03, True), (0.1, False)])
def test_the_overhang_of_a_cylinder_is_that_of_its_radius(height: float, is_met: bool) -> None:
    """A cylinder of 0.3 m radius on a plate of 0.2 m radius tips at 33.7°; its rim is then 0.055 m lower."""
    round_cube = {"width": 0.6, "height": 0.6, "plan": "circle"}
    scene = stack_of_stones({"width": 0.4, "height": height, "plan": "circle"}, round_cube)
    assert reasons_scene_is_no_stack(scene) == []
    touches = unsimulated_overhang_contact_warnings(stack_stones(scene))
    assert ["would meet the ground" in touch for touch in touches] == [True] * is_met


def test_a_shouldered_stone_is_refused_only_in_a_stack() -> None:
    """As a stack, it would tip over the edge of its base; in 2-D and as a polyhedron it rocks on its shoulders."""
    time = np.arange(0.0, 4.0, 0.005)
    wave = np.where(time < 0.8, 3.0 * np.sin(2.0 * np.pi * time / 0.8), 0.0)
    motion, stone = Motion(wave, 0.0 * wave, sampling_interval=0.005), shouldered_stone(0.02)
    corners = [[x, y, z] for x, z in stone["vertices"] for y in (-0.3, 0.3)]
    assert simulate(motion, stack_of_stones(stone), azimuth_deg=0.0).overturned.item() == 0.0
    assert simulate(motion, Polyhedron(corners), orientation_deg=0.0).overturned.item() == 0.0
    with expect_error(ArgumentError, "outline of element stone-0", "compute it in 2-D"):
        simulate(motion, stack_of_stones(stone), orientation_deg=0.0)


def test_a_stack_is_refused_at_a_b_over_h_at_which_a_shoulder_would_touch() -> None:
    """At twice the width the stone tips at nearly twice the angle, but its shoulders touch at about half the angle."""
    scene = stack_of_stones(shouldered_stone(0.06, depth=0.1))
    quiet = motion_towards_north(np.zeros(20))
    assert simulate(quiet, scene, orientation_deg=0.0, b_over_h=[0.6]).overturned.item() == 0.0
    with expect_error(ArgumentError, "b_over_h: 1.2 at the height 1 m; then the outline of element stone-0 would meet"):
        simulate(quiet, scene, orientation_deg=0.0, b_over_h=[0.6, 1.2])


@pytest.mark.parametrize(
    ("stone", "law", "reason"),
    [
        ({"fallen_rotation_deg": 30.0}, {}, "element stone-0 has fallen_rotation_deg 30"),
        ({}, {"static_penetration": 1e-5}, "contact of stone-0 has static_penetration 1e-05"),
        ({}, {"stiffness": 1e8}, "contact of stone-0 has a stiffness"),
        ({}, {"static_penetration": 1e-7, "stiffness_ratio": 0.5}, None),
    ],
)
def test_a_scene_key_that_the_3d_model_ignores_is_refused(
    stone: dict[str, Any], law: dict[str, Any], reason: str | None
) -> None:
    """A key with its default value is accepted, since it changes nothing."""
    scene = stack_of_stones({**BOX_SIZE, **stone}, contacts=[{"between": ("stone", "stone"), **law}])
    quiet = motion_towards_north(np.zeros(20))
    if reason is None:
        assert simulate(quiet, scene, orientation_deg=[0.0]).overturned.item() == 0.0
    else:
        with expect_error(ArgumentError, reason, "compute it in 2-D"):
            simulate(quiet, scene, orientation_deg=[0.0])


def test_stones_made_of_pieces_like_a_cup_or_a_tee_are_accepted_in_a_stack() -> None:
    """A gap in a face on which nothing stands does not matter, nor do pieces that join to one level face."""
    tee = [
        rectangle_outline(-0.1, 0.1, 0.0, 0.3),
        rectangle_outline(-0.3, 0.0, 0.3, 0.4),
        rectangle_outline(0.0, 0.3, 0.3, 0.4),
    ]
    quiet = motion_towards_north(np.zeros(100))
    for stones in ((BOX_SIZE, {"pieces": CUP_PIECES, "depth": 0.4}), ({"pieces": tee, "depth": 0.4}, BOX_SIZE)):
        assert simulate(quiet, stack_of_stones(*stones), orientation_deg=[0.0]).overturned.to_numpy().max() == 0.0


def test_the_required_ground_width_follows_the_longer_foot_of_an_l_stone() -> None:
    """The stone is an L with its long foot to one side, so its mass centre is not in the middle of its width."""
    foot = [[-0.1, 0.0], [1.5, 0.0], [1.5, 0.2], [0.2, 0.2], [0.2, 1.2], [-0.1, 1.2]]
    for width, fits in ((12.5, False), (13.1, True)):
        elements: list[dict[str, Any]] = [
            {"name": "ground", "kind": "driven", "width": width, "height": 1.0, "at": (0.0, -1.0)},
            {"name": "stone", "vertices": foot, "depth": 1.0, "stands_on": "ground"},
        ]
        scene = Scene.model_validate({"name": "foot", "reference": "stone", "elements": elements})
        if fits:
            assert simulate(motion_towards_north(np.zeros(50)), scene, orientation_deg=[0.0]).overturned.item() == 0.0
        else:
            with expect_error(ArgumentError, "ground is only 12.5 m wide", brief=False):
                simulate(motion_towards_north(np.zeros(50)), scene, orientation_deg=[0.0])


@pytest.mark.parametrize(("width", "at"), [(0.4, 0.0), (0.4, 0.15), (1.2, 0.0)])
def test_a_stack_on_a_driven_plinth_instead_of_the_ground_is_refused(width: float, at: float) -> None:
    """In 3-D the ground has no rim; a stone that overhangs a plinth, or slides off it, would stand."""
    elements: list[dict[str, Any]] = [
        {"name": "plinth", "kind": "driven", "width": width, "depth": width, "height": 0.5, "at": (0.0, -0.5)},
        {"name": "stone", "width": 0.3, "depth": 0.3, "height": 0.6, "stands_on": "plinth", "at": (at, 0.0)},
    ]
    scene = Scene.model_validate({"name": "plinth", "reference": "stone", "elements": elements})
    with expect_error(ArgumentError, f"element plinth is only {width:g} m wide", "wider ground", "compute it in 2-D"):
        simulate(motion_towards_north(np.zeros(100)), scene, orientation_deg=[0.0])


@pytest.mark.parametrize("friction", [0.008, 0.02])
@pytest.mark.parametrize("count", [1, 2])
def test_a_stack_that_slides_for_long_is_simulated_to_its_stop(friction: float, count: int) -> None:
    """The stack slides for 8 s or more, longer than the usual end of a case, 20/p (Housner's p) after the record."""
    pulse = 1.2 * np.sin(0.5 * np.pi * np.arange(401) * 0.005)
    motion = Motion(0.6 * pulse, 0.8 * pulse, sampling_interval=0.005)
    stones = [{"width": 0.5, "depth": 0.5, "height": 0.2, "material": "slick"},
              {"width": 0.2, "depth": 0.2, "height": 0.6, "material": "rough"}]  # fmt: skip
    scene = stack_of_stones(
        *stones[:count], materials={"stone": {}, "slick": {}, "rough": {}},
        contacts=[
            {"between": ("stone", "slick"), "friction": friction}, {"between": ("slick", "rough"), "friction": 0.7},
        ],
    )  # fmt: skip
    found = simulate(motion, scene, orientation_deg=[20.0])
    slip = peak_and_final_slip(pulse, 0.005, friction)[1]
    assert found.overturned.to_numpy().ravel().tolist() == [0.0] * count
    assert found.residual_slip_north.to_numpy().ravel()[0] == pytest.approx(0.6 * slip, rel=5e-3)
    assert found.residual_slip_east.to_numpy().ravel()[0] == pytest.approx(0.8 * slip, rel=5e-3)
    path = trajectory(motion, scene, orientation_deg=20.0)
    east, north, _ = (path.place[-1] - path.place[0]).to_numpy()[0]
    assert np.hypot(east, north) == pytest.approx(abs(slip), rel=5e-3)
    azimuth = float(np.degrees(np.arctan2(0.8, 0.6)))
    in_plane = simulate(motion, scene, azimuth_deg=[azimuth])
    assert in_plane.overturned.to_numpy().ravel().tolist() == [0.0] * count
    assert in_plane.residual_slip.to_numpy().ravel()[0] == pytest.approx(slip, rel=5e-3)
    if count == 2:
        x = trajectory(motion, scene, azimuth_deg=azimuth).x.sel(element="stone-0")
        assert float(x[-1] - x[0]) == pytest.approx(slip, rel=5e-3)
