"""What rests in another pose than it began has fallen: against the height of the centre over all rotations."""

from typing import Any

import numpy as np
import pytest

from overturning.dem.cases import Cases
from overturning.dem.polygon.geometry import native_size, place
from overturning.dem.run import run
from overturning.dem.scene import Scene
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import GROUND, ROOT, block, scene, shaken, shipped, still

STEP = np.radians(0.02)
ALL_SHIPPED = sorted(path.stem for path in (ROOT / "config" / "scenes").glob("*.yaml"))


def valleys(vertices: np.ndarray) -> np.ndarray:
    """Rotations, rad, at which the centre of a body that rolls over a level is lower than just before and just after."""
    angles = np.arange(-np.pi, np.pi, STEP)
    height = (np.outer(np.sin(angles), vertices[:, 0]) - np.outer(np.cos(angles), vertices[:, 1])).max(axis=1)
    lowest = (height < np.roll(height, 1)) & (height < np.roll(height, -1))
    return angles[lowest]


def least_other_rest(vertices: np.ndarray) -> float:
    rests = np.abs(valleys(vertices))
    return float(np.sort(rests)[1]) if rests.min() < 2 * STEP else float(rests.min())


@pytest.mark.parametrize("name", ALL_SHIPPED)
def test_elements_of_shipped_scenes_have_fallen_where_they_can_rest(name: str) -> None:
    for item in place(shipped(name)):
        if not item.fixed:
            assert item.fallen == pytest.approx(least_other_rest(item.shape.vertices), abs=STEP), item.element.name
            if item.element.width is not None:
                assert item.fallen == pytest.approx(0.5 * np.pi, abs=1e-11)


def standing_polygon(generator: np.random.Generator) -> list[list[float]]:
    """A convex polygon that stands on the side between its first two vertices."""
    while True:
        angles = np.sort(generator.uniform(0, 2 * np.pi, generator.integers(3, 9)))
        points = np.stack([np.cos(angles), generator.uniform(0.5, 1.5) * np.sin(angles)], axis=1)
        points = (points - points[0]) @ turn_down(points[1] - points[0])
        made = scene({"name": "body", "vertices": points.tolist(), "stands_on": "ground"}) if convex(points) else None
        if made is not None and np.abs(valleys(place(made)[1].shape.vertices)).min() < 2 * STEP:
            return points.tolist()


def turn_down(side: np.ndarray) -> np.ndarray:
    x, z = side / np.linalg.norm(side)
    return np.array([[x, -z], [z, x]])


def convex(points: np.ndarray) -> bool:
    edges = np.roll(points, -1, axis=0) - points
    following = np.roll(edges, -1, axis=0)
    return bool((edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] > 0.02).all())


def test_random_polygons_have_fallen_where_they_can_rest() -> None:
    generator = np.random.default_rng(5)
    for _ in range(60):
        vertices = standing_polygon(generator)
        body = place(scene({"name": "body", "vertices": vertices, "stands_on": "ground"}))[1]
        assert body.fallen == pytest.approx(least_other_rest(body.shape.vertices), abs=2 * STEP), vertices


def flags_and_angles(made: Scene, motion: Motion, **keys: Any) -> tuple[np.ndarray, np.ndarray]:
    found = run(made, motion, Cases([0.0], *native_size(made), 0.7, **keys))
    return found.overturned[0], found.peak_rotation[0]


@pytest.mark.parametrize("peak", [8.0, 9.0])
def test_a_boulder_that_comes_to_rest_on_another_side_has_fallen(peak: float) -> None:
    time = np.arange(0, 1.005, 0.01)
    for sign in (1.0, -1.0):
        flags, _ = flags_and_angles(shipped("boulder"), shaken(sign * peak * np.sin(2 * np.pi * time)))
        assert flags[0] != 0, "it lies at 51° or 46°"


def test_a_stone_that_begins_leaning_lies_after_less_than_a_right_angle() -> None:
    """0.1 wide and 0.6 high, tilted by 10°, beyond its 9.5°: its side comes down after another 80°."""
    made = scene(GROUND, block("stone", 0.1, 0.6, rotation_deg=10.0))
    assert np.degrees(place(made)[1].fallen) == pytest.approx(80.0)
    flags, _ = flags_and_angles(made, still(1.0))
    assert flags.tolist() == [1]


def test_an_angle_that_a_scene_gives_counts() -> None:
    for asked in (30.0, 90.0, 120.0):
        made = scene(GROUND, block("stone", 0.1, 0.6, fallen_rotation_deg=asked))
        assert np.degrees(place(made)[1].fallen) == pytest.approx(asked)
    assert shipped("gravestone").single_block
    assert scene(GROUND, block("stone", 0.1, 0.6, fallen_rotation_deg=90)).single_block
    assert not scene(GROUND, block("stone", 0.1, 0.6, fallen_rotation_deg=30)).single_block
