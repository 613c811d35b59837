"""Stacks in 3-D: known answers of compounds, offsets, extreme shapes, mirror images and trajectories."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from overturning.dem.simulate import simulate
from overturning.dem.trajectory import trajectory
from overturning.errors import ArgumentError
from overturning.figures.film_of_trajectory import film_of_trajectories, outcome_sentence
from overturning.model.cases import Cases
from overturning.model.element import Element
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import Scene, load_scene
from overturning.model.stack import Stack
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from tests.dem.motions import simulate_under_each_motion
from tests.dem.polygon_scenes import REPOSITORY
from tests.dem.reference.particles import final_slip_with_flights_and_landings
from tests.dem.test_stack import (
    INTERVAL,
    THREE_BOXES,
    acceleration_components_with_plateau,
    motion_from_north_and_west_accelerations,
    random_horizontal_accelerations,
    simulate_stack_under_north_west_accelerations,
    stack_of_boxes,
)


def test_a_shaft_on_a_broad_base_rocks_as_on_the_ground() -> None:
    """The base is so broad and heavy that only the shaft moves; its peak tilts are those of the shaft alone."""
    motions = [
        motion_from_north_and_west_accelerations(4.2 * random_horizontal_accelerations(seed, components=1))
        for seed in (0, 1, 2)
    ]
    shaft = (0.2, 0.2, 0.6)
    cases = Cases(0.0, 0.6, 0.2 / 0.6, 3.0)
    alone, above = (
        simulate_under_each_motion(Stack(scene), motions, cases).peak_tilt[:, 0]
        for scene in (stack_of_boxes(shaft), stack_of_boxes((2.0, 2.0, 0.3), shaft))
    )
    assert alone.shape == (3,)
    assert alone.min() > 0.5
    assert alone.max() < 15.0
    assert above[:, 0].max() < 1e-2
    np.testing.assert_allclose(above[:, 1], alone, rtol=5e-3)


@pytest.mark.parametrize("push", [1.5, 2.0])
def test_a_slender_stone_that_slid_and_still_rocks_counts_as_standing(push: float) -> None:
    """The ground has no rim, so the stone stands as firmly as before; it slips by four widths while in the air."""
    along, up = push * np.sin(0.08 * np.arange(40)), np.full(40, -15.0)
    along[-1] = up[-1] = 0.0
    motion = Motion(along, 0 * along, up, sampling_interval=0.01, trust_data=True)
    found = simulate(
        motion, stack_of_boxes((0.09, 0.09, 0.6)), orientation_deg=[0.0, 10.0], friction=0.5, leave_out=False
    )
    assert found.status.to_numpy().ravel().tolist() == [CaseStatus.SIMULATED] * 2
    assert found.overturned.to_numpy().ravel().tolist() == [0, 0]
    slip = final_slip_with_flights_and_landings(along, up, 0.01, 0.5)
    np.testing.assert_allclose(found.residual_slip_north.to_numpy().ravel(), slip, rtol=0.01)


def test_two_cubes_on_each_other_tip_like_one_stone_of_their_height() -> None:
    """Two cubes in one column tip as one stone of twice the height: at B/H = 0.5 of the whole."""
    column = stack_of_boxes((0.3, 0.3, 0.3), (0.3, 0.3, 0.3))
    below, above = (
        simulate_stack_under_north_west_accelerations(
            column, acceleration_components_with_plateau(0.5 * share, 0.0), [0.0], 3.0
        )
        for share in (0.97, 1.06)
    )
    assert below.peak_tilt.to_numpy().max() < 0.02
    assert above.overturned.to_numpy().ravel().tolist() == [1.0, 1.0]
    assert above.slid_off.to_numpy().max() == 0.0


def shaft_off_centre(offset: float) -> Scene:
    """Return a shaft on a base, shifted from its middle by `offset`, m, towards the orientation."""
    return Scene(name="offset", reference="shaft", elements=(
        Element(name="ground", kind="driven", width=40.0, height=1.0, at=(0.0, -1.0)),
        Element(name="base", width=0.5, depth=0.5, height=0.2, stands_on="ground"),
        Element(name="shaft", width=0.3, depth=0.3, height=0.6, stands_on="base", at=(offset, 0.0)),
    ))  # fmt: skip


@pytest.mark.parametrize("offset", [0.05, 0.2, 0.24, 0.245])
def test_an_overhanging_stone_stays_at_rest_while_its_centre_is_supported(offset: float) -> None:
    """At an offset of 0.245 m the shaft overhangs by 0.145 m, and its centre is 5 mm from the rim of the base."""
    quiet = Motion(np.zeros(200), np.zeros(200), sampling_interval=INTERVAL, trust_data=True)
    found = simulate(quiet, shaft_off_centre(offset), orientation_deg=[0.0], friction=[0.6], leave_out=False)
    assert found.overturned.to_numpy().max() == 0.0
    assert found.status.item() == CaseStatus.SIMULATED
    assert found.peak_tilt.to_numpy().max() < 1e-3
    assert found.energy_error.item() < 1e-6
    assert np.abs(found.residual_slip_north.to_numpy()).max() < 1e-8
    assert Stack(shaft_off_centre(offset)).rotational_symmetry_period_deg == 360.0


def test_an_overhanging_stone_tips_over_the_rim_only_above_the_static_limit() -> None:
    """The shaft's centre is 0.05 m from the rim and 0.3 m above it: it tips at g/6 towards the rim."""
    below, above = (
        simulate_stack_under_north_west_accelerations(
            shaft_off_centre(0.2), acceleration_components_with_plateau(-share / 6.0, 0.0), [0.0], 3.0
        )
        for share in (0.94, 1.1)
    )
    assert below.overturned.to_numpy().max() == 0.0
    assert above.overturned.to_numpy().ravel().tolist() == [0.0, 1.0]
    assert above.slid_off.to_numpy().ravel()[1] == 1.0, "over the rim of the base, not over its own edge"
    assert abs((float(above.fall_azimuth.to_numpy().ravel()[1]) + 180.0) % 360.0 - 180.0) < 20.0


@pytest.mark.parametrize("ratio", [0.4, 1.0, 1.5])
def test_a_size_at_which_the_stack_cannot_stand_is_refused(ratio: float) -> None:
    """The base is the reference: at B/H = 1.5 it is 0.3 m wide, but the shaft's centre is 0.2 m from its middle."""
    scene = shaft_off_centre(0.2).model_copy(update={"reference": "base"})
    quiet = Motion(np.zeros(20), np.zeros(20), sampling_interval=INTERVAL, trust_data=True)
    with pytest.raises(ArgumentError, match="centre of mass outside it"):
        simulate(quiet, scene, orientation_deg=[0.0], friction=[0.6], b_over_h=[ratio])


def test_a_stack_with_a_parallelogram_has_a_symmetry_period_of_360_degrees() -> None:
    """A parallelogram looks the same after half a turn about its axis across the plane, not about the vertical."""
    leaning = Scene(name="leaning", elements=(
        Element(name="ground", kind="driven", width=40.0, height=1.0, at=(0.0, -1.0)),
        Element(
            name="stone", vertices=((-0.25, 0.0), (0.125, 0.0), (0.25, 0.5), (-0.125, 0.5)), depth=0.3,
            stands_on="ground",
        ),
    ))  # fmt: skip
    assert Stack(leaning).rotational_symmetry_period_deg == 360.0
    assert Stack(load_scene("three-tier", REPOSITORY)).rotational_symmetry_period_deg == 90.0


def test_a_cross_of_pieces_stands_at_0_1_g_and_falls_at_0_4_g() -> None:
    scene = load_scene("cross", REPOSITORY)
    still, moving = (
        simulate_stack_under_north_west_accelerations(
            scene, acceleration_components_with_plateau(level, 30.0), [0.0], 0.7
        )
        for level in (0.1, 0.4)
    )
    assert still.status.item() == CaseStatus.AT_REST
    assert moving.status.item() == CaseStatus.SIMULATED
    assert moving.overturned.to_numpy().ravel()[-1] == 1.0


def test_the_mirror_image_of_a_case_has_the_mirrored_outcome() -> None:
    """Sums over contact points round differently in the mirror image; where a case is sensitive, this grows to 3°.

    All samples are simulated: `tests/dem/test_leave_out.py` is about the effect of skipping some.
    """
    sides = np.array([[[1.0], [1.0]], [[1.0], [-1.0]]])
    motions = [
        motion_from_north_and_west_accelerations(7.0 * random_horizontal_accelerations(seed) * side)
        for side in sides
        for seed in range(6)
    ]
    cases = Cases(0.0, *reference_element_height_and_b_over_h(THREE_BOXES), 0.6)
    found = simulate_under_each_motion(Stack(THREE_BOXES), motions, cases, leave_out=False)
    assert found.overturned[:, 0].tolist() == [[0, 0, 1]] * 12
    one, other = found.fall_azimuth[:6, 0, 2], found.fall_azimuth[6:, 0, 2]
    away = np.abs((one + other + 180.0) % 360.0 - 180.0)
    assert away.max() < 10.0
    assert np.median(away) < 0.1


@pytest.mark.long
def test_simulations_of_extreme_stacks_never_fail_and_are_rarely_unstable_or_over_budget() -> None:
    """Two to five stones, thin slabs, slender shafts, mass ratios to 1e4, µ 0 to 10, vertical motion beyond −1 g."""
    dice, statuses = np.random.default_rng(45), []
    for _ in range(60):
        sizes: list[tuple[float, float, float]] = []
        width = dice.uniform(0.3, 1.5)
        for _ in range(int(dice.integers(2, 6))):
            height = max(0.012, width * 10.0 ** dice.uniform(-1.5, 0.7))
            sizes.append((width, width * dice.uniform(0.5, 2.0), height))
            width *= dice.uniform(0.3, 1.3)
        interval = float(dice.choice([0.005, 0.01, 0.02, 0.05]))
        t = np.arange(0.0, 4.0, interval)
        rows = [10.0 ** dice.uniform(0.0, 1.3) * np.sin(2.0 * np.pi * dice.uniform(0.5, 5.0) * t) for _ in range(3)]
        motion = Motion(*rows, sampling_interval=interval, trust_data=True)
        friction = float(dice.choice([0.0, 0.2, 0.6, 1.0, 10.0]))
        found = simulate(
            motion,
            stack_of_boxes(*sizes),
            orientation_deg=[0.0, 37.0],
            friction=[friction],
            budget=20_000_000,
            threads=1,
        )
        statuses += found.status.to_numpy().ravel().astype(int).tolist()
        known = found.overturned.to_numpy()[np.isfinite(found.overturned.to_numpy())]
        assert set(known.tolist()) <= {0.0, 1.0}
    counts = np.bincount(statuses, minlength=6)
    # Without friction, or under strong vertical motion, a stack may slide or hop on until the time limit.
    assert counts[CaseStatus.FAILED] == 0, counts
    assert counts[CaseStatus.UNSTABLE] + counts[CaseStatus.OVER_BUDGET] <= 0.12 * len(statuses), counts


def test_the_slip_of_a_stone_on_a_twisted_stone_is_given_as_north_and_east_components() -> None:
    """Expected slip from the path: shift of the middle of the cap's base over the shaft's face at its last pose."""
    scene = Scene.model_validate({
        "name": "cap", "reference": "shaft", "materials": {"stone": {}, "slick": {}},
        "contacts": [
            {"between": ["stone", "stone"], "friction": 0.7}, {"between": ["slick", "stone"], "friction": 0.5},
        ],
        "elements": [
            {"name": "ground", "kind": "driven", "width": 40.0, "height": 1.0, "at": [0.0, -1.0]},
            {"name": "shaft", "width": 0.242, "depth": 0.242, "height": 0.636, "stands_on": "ground"},
            {"name": "cap", "width": 0.08, "depth": 0.08, "height": 0.02, "material": "slick", "stands_on": "shaft"},
        ],
    })  # fmt: skip
    rows = 5.0 * random_horizontal_accelerations(0)
    motion = Motion(rows[0], -rows[1], sampling_interval=INTERVAL, trust_data=True)
    path = trajectory(motion, scene, orientation_deg=40.0)
    assert abs(float(path["residual_twist"].to_numpy()[0])) > 5.0
    place, upward = path["place"].to_numpy(), np.array([0.0, 0.0, 1.0])
    on_shaft, shaft = [], None
    for row in (0, -1):
        shaft, cap = (Rotation.from_quat(path["quaternion"].to_numpy()[row, n], scalar_first=True) for n in (0, 1))
        apart = place[row, 1] - 0.01 * cap.apply(upward) - (place[row, 0] + 0.318 * shaft.apply(upward))
        on_shaft.append(shaft.inv().apply(apart))
    assert shaft is not None
    east, north, _ = shaft.apply(on_shaft[1] - on_shaft[0])
    assert np.hypot(north, east) > 0.01
    found = [float(path[f"residual_slip_{name}"].to_numpy()[1]) for name in ("north", "east")]
    assert found == pytest.approx([north, east], abs=1e-6)


def test_a_stack_trajectory_has_the_outcome_of_its_case_and_films_all_stones() -> None:
    rows = 9.0 * random_horizontal_accelerations(0)
    motion = Motion(rows[0], -rows[1], sampling_interval=INTERVAL, trust_data=True)
    scene = load_scene("three-tier", REPOSITORY)
    case: dict[str, Any] = {"orientation_deg": 20.0, "friction": 0.6}
    path, cell = trajectory(motion, scene, aftermath=3.0, **case), simulate(motion, scene, **case)
    for name in ("overturned", "fall_azimuth", "peak_tilt", "residual_twist", "energy_error"):
        np.testing.assert_array_equal(np.ravel(path[name]), np.ravel(cell[name]), name)
    assert path["place"].dims == ("time", "element", "enu")
    assert (np.diff(path["time"]) > 0.0).all()
    fallen = path["overturned"].to_numpy() == 1.0
    assert fallen.any()
    assert (path["simulated"].to_numpy()[-1] == ~fallen).all()
    heights = path["place"].to_numpy()[-1, fallen, 2]
    assert (heights < 0.5).all(), "a fallen stone is drawn down to the ground"
    along_north = np.interp(path["time"], INTERVAL * np.arange(motion.sample_count), motion.north, right=0.0)
    np.testing.assert_allclose(path["ground_acceleration"].to_numpy()[:, 1], along_north, atol=1e-6)
    film = film_of_trajectories([path], motion, "film")
    assert [body.name for body in film.panels[0].bodies] == ["lower-base", "upper-base", "shaft"]
    assert film.panels[0].shows_3d_body
    assert "of 3 fall" in outcome_sentence(path)
