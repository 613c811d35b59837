"""Films of real trajectories."""

import numpy as np
import pytest

from overturning.dem.simulate import simulate_arrays, trajectory
from overturning.errors import ArgumentError
from overturning.figures.film import corners
from overturning.figures.film_of_trajectory import contact_forces, film_of, movement, outcome, overturning_time
from overturning.figures.film_page import film_page
from overturning.motion.motion import Motion

BLOCK = {"height": 0.6, "b_over_h": 0.3, "friction": 1.0}


@pytest.fixture(scope="module")
def motion() -> Motion:
    """One cycle of a sine towards north after two quiet seconds, strong enough to throw a slender block."""
    time = np.arange(0, 6, 0.01)
    pulse = np.where((time > 2) & (time < 3), 9.0 * np.sin(2 * np.pi * (time - 2)), 0.0)
    return Motion(pulse, 0 * pulse, sampling_interval=0.01)


def test_a_fall(motion: Motion) -> None:
    path = trajectory(motion, azimuth_deg=0, **BLOCK)
    side = path.attrs["overturned"]
    assert side != 0
    cell = simulate_arrays(motion, azimuth_deg=[0], **{name: [value] for name, value in BLOCK.items()})
    assert overturning_time(path) == pytest.approx(float(cell["overturning_time"].item()), abs=0.011)
    assert outcome(path).startswith("falls towards N0°E" if side > 0 else "falls towards N180°E")
    film = film_of([path], [motion.along(0)], 0.01, "pulse")
    assert film.start == pytest.approx(1.0, abs=0.3)  # the quiet second before is not shown
    body = film.panels[0].bodies[1]
    assert abs(body.rotation[-1]) == pytest.approx(np.pi / 2, abs=0.1)
    lowest = min(corners(body, frame)[:, 1].min() for frame in range(0, film.frames, 5))
    assert lowest > -0.01  # nothing sinks into the base


def test_falls_of_opposite_planes_mirror_each_other(motion: Motion) -> None:
    one, other = (trajectory(motion, azimuth_deg=angle, **BLOCK) for angle in (0, 180))
    assert one.attrs["overturned"] == -other.attrs["overturned"]
    assert outcome(one) == outcome(other)


def test_standing_blocks_need_no_movement(motion: Motion) -> None:
    path = trajectory(motion, azimuth_deg=90, **BLOCK)
    assert movement(path) is None
    assert outcome(path).startswith("stands")
    film = film_of([path], [motion.along(90)], 0.01, "nothing")
    assert film.frames > 10


def test_in_step(motion: Motion) -> None:
    paths = [trajectory(motion, azimuth_deg=angle, **BLOCK) for angle in (0, 90)]
    film = film_of(paths, [motion.along(0), motion.along(90)], 0.01, "two")
    assert film.end < 6  # it stops at the fall
    assert [panel.title for panel in film.panels] == ["N0°E", "N90°E"]
    assert len(film_page(film).encode()) < 300_000


def test_forces_at_rest_carry_the_weight(motion: Motion) -> None:
    path = trajectory(motion, azimuth_deg=0, **BLOCK)
    point, force = contact_forces(path)
    assert force[50].sum(axis=0) == pytest.approx([0, 1], abs=1e-3)
    assert force[50, 0] == pytest.approx(force[50, 1], abs=1e-3)
    assert point[50] == pytest.approx(np.array([[-0.09, 0], [0.09, 0]]), abs=1e-4)
    rocking = int(np.argmax(np.abs(path["rotation"].to_numpy()) > 0.1))
    lifted = 0 if float(path["rotation"][rocking]) > 0 else 1
    assert force[rocking, lifted] == pytest.approx([0, 0])


def test_upward_acceleration_adds_to_the_weight(motion: Motion) -> None:
    pushed = Motion(0 * motion.north, 0 * motion.east, np.full(motion.samples, 3.0), sampling_interval=0.01)
    path = trajectory(pushed, azimuth_deg=0, leave_out=False, **BLOCK)
    force = contact_forces(path, np.full(path.sizes["time"], 3.0))[1]
    assert force[100].sum(axis=0) == pytest.approx([0, 1 + 3.0 / 9.80665], abs=2e-3)


def test_no_trajectory() -> None:
    with pytest.raises(ArgumentError, match="at least one"):
        film_of([], [], 0.01, "none")
