"""Held elements stay where they are in space while the ground moves below them."""

import numpy as np
import pytest

from tests.dem.polygon_scenes import GROUND, block, one_case, run, scene, shaken


def test_a_stone_on_a_held_shelf_does_not_feel_the_shaking() -> None:
    shelf = {"name": "shelf", "kind": "held", "width": 2.0, "height": 0.5, "at": [5, 0.1]}
    made = scene(GROUND, shelf, block("stone", 0.2, 0.8, "shelf"), block("other", 0.2, 0.8))
    time = np.arange(0, 2, 0.01)
    motion = shaken(np.where(time < 1, 6.0 * np.sin(2 * np.pi * time), 0.0))
    answers, at, poses = run(one_case(made, motion), motion)
    # ü = A sin ωt for one period leaves the ground with u = A t/ω − A sin(ωt)/ω²; in its frame the shelf goes the other
    # way.
    omega = 2 * np.pi
    exact = np.where(at < 1, 6.0 * (at / omega - np.sin(omega * at) / omega**2), 6.0 / omega)
    shelf_way, stone_way = (poses[:, k, 0] - poses[0, k, 0] for k in (1, 2))
    assert shelf_way == pytest.approx(-exact, abs=2e-3 * exact.max())
    assert np.abs(stone_way - shelf_way).max() < 1e-8
    assert np.abs(poses[:, 2, 2]).max() < 1e-8
    # The stone on the ground does.
    assert np.abs(poses[:, 3, 2]).max() > 0.05
    assert answers.overturned[0, 0] == 0
