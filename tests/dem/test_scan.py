"""Scanned stones in the 3-D model: a statue with an overhang rocks on the edges of its footprint."""

import numpy as np
import pytest

from overturning.dem.simulate import simulate_as_arrays
from overturning.model.body import Body
from overturning.model.scan import ScannedStone, stone_in_nearest_stable_pose_from_surface
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.model.solids import column_with_overhanging_slab, mass_properties_of_solid_from_its_boxes


def motion_rising_to_constant_acceleration(acceleration: float) -> Motion:
    """Return a motion along north that grows to an acceleration, m/s², within 3 s and stays there for 3 s."""
    ramp = np.minimum(np.arange(600) * 0.01 / 3.0, 1.0)
    return Motion(acceleration * ramp, np.zeros(600), sampling_interval=0.01, trust_data=True)


@pytest.mark.parametrize("side", [1, -1])
def test_a_statue_falls_over_the_edge_of_its_footprint_from_the_true_centre(side: int) -> None:
    """The threshold is g b/h: b from the edge of the foot (not of the slab) to the mass centre, h above the base.

    The mass centre is that of the volume, not of the convex hull. The base is pushed away from the side over which the
    statue falls.
    """
    _, centre, _ = mass_properties_of_solid_from_its_boxes("statue")
    stone = stone_in_nearest_stable_pose_from_surface(column_with_overhanging_slab(), [], "statue").shape
    assert isinstance(stone, ScannedStone)
    threshold = STANDARD_GRAVITY * (0.1 - side * centre[0]) / centre[2]
    assert stone.unscaled_solid.b_over_h == pytest.approx((0.1 - centre[0]) / centre[2], abs=1e-5)
    for factor, falls in ((0.98, 0), (1.02, 1)):
        found = simulate_as_arrays(
            motion_rising_to_constant_acceleration(-side * factor * threshold),
            Body(stone),
            orientation_deg=[0.0],
            friction=[2.0],
        )
        assert found["overturned"].item() == falls
        if falls:
            assert abs((found["fall_azimuth"].item() - (0.0 if side > 0 else 180.0) + 180.0) % 360.0 - 180.0) < 1.0


def test_the_height_limit_of_bearing_points_decides_whether_a_scan_falls() -> None:
    """At a limit of 1 mm the stone bears on its lowest points only and falls; at 10 mm on more, and stands."""
    points = np.array(
        [[x, y, z] for a, z in ((0.05, 0.0), (0.07, 0.008), (0.07, 0.8)) for x in (-a, a) for y in (-a, a)]
    )
    stone = ScannedStone(points, (0.0, 0.0, 0.4), (0.055, 0.055, 0.003, 0.0, 0.0, 0.0), 0.001)
    bodies = [Body(stone.with_base_relief(relief)) for relief in (0.001, 0.010)]
    assert [body.shape.solid(0.8, 1, 1).b_over_h for body in bodies] == pytest.approx([0.05 / 0.4, 0.07 / 0.4])
    motion = motion_rising_to_constant_acceleration(0.15 * STANDARD_GRAVITY)
    outcomes = [simulate_as_arrays(motion, body, orientation_deg=[0.0])["overturned"].item() for body in bodies]
    assert outcomes == [1, 0]
