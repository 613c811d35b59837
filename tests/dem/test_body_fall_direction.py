"""Fall tilt of bodies without rotational symmetry, as a function of the direction of the lean."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from overturning.dem.simulate import simulate_as_arrays
from overturning.dem.trajectory import trajectory
from overturning.model import polyhedron
from overturning.model.body import Body
from overturning.model.shapes import Cylinder, Polyhedron, RectangularPrism, RegularPrism
from overturning.model.solid import RigidSolid
from overturning.model.tipping import LEAN_DIRECTION_COUNT, fall_tilt_by_lean_direction
from overturning.motion.motion import Motion
from tests.dem.compiled.body_end import is_body_fallen_in_kernel

BOX = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (0.0, 0.6)])
BLOCK_WITH_BEVELLED_LEFT_FOOT = np.array(
    [[x, y, z] for y in (-0.3, 0.3) for x, z in ((-0.02, 0), (0.45, 0), (0.45, 0.5), (-0.34, 0.5), (-0.42, 0.24))]
)
"""Block with a facet at the foot of its left side that touches the ground at 31°. Tipping angles: 17.6° to the left,
55.3° to the right, 48.3° to front and back."""


@pytest.mark.parametrize(
    ("push", "azimuth"), [(18.0, None), (20.0, 180.0), (24.0, 180.0), (25.0, 180.0), (26.0, 0.0), (30.0, 0.0)]
)
def test_the_fall_azimuth_of_a_faceted_block_is_the_side_on_which_it_rests(
    push: float, azimuth: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 25 m/s² the block leans 37° to the right, comes back, and ends on its facet at the left."""
    shaking = np.zeros(1500)
    shaking[50:100] = -push
    motion = Motion(shaking, 0 * shaking, sampling_interval=0.004, trust_data=True)
    same = {"orientation_deg": 0.0, "friction": 2.0}
    found = simulate_as_arrays(
        motion,
        Body(Polyhedron(BLOCK_WITH_BEVELLED_LEFT_FOOT)),
        **(same | {"orientation_deg": [0.0], "friction": [2.0]}),
    )
    assert found["overturned"].item() == (azimuth is not None)
    # The same case with a fall tilt of 80°, which is simulated for longer.
    real = polyhedron._least_resting_tilt_on_other_faces_and_normals
    monkeypatch.setattr(
        polyhedron,
        "_least_resting_tilt_on_other_faces_and_normals",
        lambda *arguments: (np.radians(80.0), real(*arguments)[1]),
    )
    path = trajectory(motion, Body(Polyhedron(BLOCK_WITH_BEVELLED_LEFT_FOOT, "longer")), **same)
    top = np.degrees(np.arctan2(path["tilt_east"][-1], path["tilt_north"][-1])) % 360.0
    tilt = np.degrees(np.arcsin(np.hypot(path["tilt_east"], path["tilt_north"])[-1]))
    if azimuth is None:
        assert tilt < 1.0
    else:
        assert tilt > 30.0
        for way in (float(top), found["fall_azimuth"].item()):
            assert abs((way - azimuth + 180.0) % 360.0 - 180.0) < 1.0


def is_leaning_body_fallen_in_kernel(stone: RigidSolid, lean_direction: float, tilt: float) -> bool:
    """True if the kernel counts a body that leans by `tilt` in the direction `turn` (rad) as fallen."""
    half, least = 0.5 * tilt, np.cos(0.999 * stone.least_tilt_to_rest_on_another_face_rad)
    return is_body_fallen_in_kernel(
        np.cos(half),
        -np.sin(lean_direction) * np.sin(half),
        np.cos(lean_direction) * np.sin(half),
        least,
        stone.lean_sector_start_vector_and_min_fall_dot_product,
    )


def centre_heights_of_leaning_body(points: np.ndarray, lean_direction: float, tilts: np.ndarray) -> np.ndarray:
    """Return the heights of the centre above the ground of a body that leans by `tilts` in a direction `turn` (rad)."""
    down = np.array([np.cos(lean_direction) * np.sin(tilts), np.sin(lean_direction) * np.sin(tilts), -np.cos(tilts)])
    return (points @ down).max(axis=0)


def released_leaning_body_rolls_back(points: np.ndarray, lean_direction: float, tilt: float) -> bool:
    """True if a body released at this lean rolls back onto its base; found by steps that lower the centre."""
    down = np.array([np.cos(lean_direction) * np.sin(tilt), np.sin(lean_direction) * np.sin(tilt), -np.cos(tilt)])
    rng, step = np.random.default_rng(0), 0.02
    while step > 1e-5:
        tries = down + step * rng.normal(size=(60, 3))
        tries /= np.linalg.norm(tries, axis=1)[:, None]
        heights = (points @ tries.T).max(axis=0)
        if heights.min() < (points @ down).max() - 1e-9:
            down = tries[heights.argmin()]
        else:
            step *= 0.5
    return bool(down[2] < -0.9999)


@pytest.mark.parametrize("seed", range(6))
def test_the_fall_tilt_is_the_next_tilt_at_which_the_leaning_body_can_rest(seed: int) -> None:
    """At the fall tilt the height of the centre has a minimum from which the body does not roll back."""
    rng = np.random.default_rng(seed)
    lump = rng.normal(size=(14, 3))
    lump = lump / np.linalg.norm(lump, axis=1)[:, None] * [0.3, 0.25, 0.25]
    low = np.array([[0.16, 0.1, -0.2], [-0.17, 0.12, -0.2], [-0.14, -0.13, -0.2], [0.15, -0.12, -0.2]])
    whole = np.concatenate([low, lump[lump[:, 2] > -0.15]])
    whole = whole[ConvexHull(whole).vertices]
    stone, hull = Polyhedron(whole).unscaled_solid, polyhedron._hull_of_checked_convex_vertices(whole)
    size = float(np.ptp(whole, axis=0).max())
    fall = fall_tilt_by_lean_direction(
        hull, size, *polyhedron._least_resting_tilt_on_other_faces_and_normals(hull, size, 0.0)
    )
    assert len(stone.lean_sector_start_vector_and_min_fall_dot_product) > 3
    for number in rng.integers(0, LEAN_DIRECTION_COUNT, 25):
        turn = 2.0 * np.pi * (number + 0.5) / LEAN_DIRECTION_COUNT
        tilts = np.arange(0.0, np.pi, np.radians(0.05))
        heights = centre_heights_of_leaning_body(hull.vertices_from_centre_of_mass, turn, tilts)
        valleys = 1 + np.flatnonzero((heights[1:-1] < heights[:-2]) & (heights[1:-1] < heights[2:]))
        stays = (
            tilts[k]
            for k in valleys
            if not released_leaning_body_rolls_back(hull.vertices_from_centre_of_mass, turn, tilts[k])
        )
        limit = max(next(stays, np.pi), stone.least_tilt_to_rest_on_another_face_rad)
        assert fall.fall_tilt_in_each_direction_rad[number] == pytest.approx(limit, abs=np.radians(0.1)), np.degrees(
            turn
        )
        some = rng.uniform(0.0, min(limit, 3.0), 5)
        np.testing.assert_allclose(
            centre_heights_of_leaning_body(stone.contact_points_from_centre_of_mass, turn, some),
            centre_heights_of_leaning_body(hull.vertices_from_centre_of_mass, turn, some),
            rtol=0,
            atol=1e-9,
        )
        for tilt, expected in ((0.998 * limit - 2e-3, False), (limit + 2e-3, True)):
            assert is_leaning_body_fallen_in_kernel(stone, turn, tilt) == expected, (
                np.degrees(turn),
                np.degrees(tilt),
            )
    for face in stone.resting_face_normals_after_fall:  # lying on a face is a fall
        assert is_leaning_body_fallen_in_kernel(stone, np.arctan2(face[1], face[0]), np.arccos(-face[2]))


def test_boxes_prisms_and_cylinders_have_one_fall_tilt_in_all_directions() -> None:
    wider = np.array([[x * s, y * s, z] for s, z in ((0.2, 0.0), (0.3, 0.9)) for x in (-1, 1) for y in (-1, 1)])
    for shape in (Polyhedron(BOX), Polyhedron(wider), RectangularPrism(), RegularPrism(8), Cylinder()):
        assert len(shape.solid(0.6, 0.4, 1.0).lean_sector_start_vector_and_min_fall_dot_product) == 0, shape.name
