"""Contact forces in a scene's trajectory, checked against the momentum changes computed from the poses."""

import numpy as np
import pytest
import xarray as xr

from overturning.dem.trajectory import trajectory
from overturning.figures.film_of_trajectory import film_of_trajectories
from overturning.model.geometry import scale_and_place_elements
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import load_shipped_scene

G = 9.80665
FRICTION = 0.5


def motion_of_one_sine_cycle_after_rest(peak: float) -> Motion:
    """Return a sine cycle of 1 s after one quiet second."""
    time = np.arange(400) * 0.01
    north = np.where((time > 1) & (time <= 2), peak * np.sin(2 * np.pi * time), 0.0)
    return Motion(north, 0 * north, sampling_interval=0.01)


@pytest.fixture(scope="module", params=["gravestone", "three-tier", "against-a-wall", "boulder"])
def scene_trajectory(request: pytest.FixtureRequest) -> xr.Dataset:
    """Provide the trajectory of a shipped scene under a pulse."""
    return trajectory(
        motion_of_one_sine_cycle_after_rest(6.0), load_shipped_scene(request.param), azimuth_deg=0.0, friction=FRICTION
    )


def force_and_moment_on_element(scene_trajectory: xr.Dataset, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the sums of the contact forces on an element and of their moments about its centre, by time."""
    force = np.zeros((scene_trajectory.sizes["time"], 2))
    moment = np.zeros(scene_trajectory.sizes["time"])
    centre = np.stack([scene_trajectory["x"].sel(element=name), scene_trajectory["z"].sel(element=name)], axis=1)
    centre[:-1] = 0.5 * (centre[1:] + centre[:-1])  # mean over each sample, like the contact places
    for index in range(scene_trajectory.sizes["contact"]):
        on, by = scene_trajectory["contact_on"][index], scene_trajectory["contact_by"][index]
        sign = float(on == name) - float(by == name)
        each = sign * scene_trajectory["contact_force"].to_numpy()[:, index]
        arm = np.nan_to_num(scene_trajectory["contact_place"].to_numpy()[:, index] - centre)
        force, moment = force + each, moment + arm[:, 1] * each[:, 0] - arm[:, 0] * each[:, 1]
    return force, moment


def test_forces_change_the_momentum_of_each_element(scene_trajectory: xr.Dataset) -> None:
    """M Δv = ∫ (Σ f − m (g + a)) dt and I Δω = ∫ Σ r × f dt from the start to any sample.

    Exceptions: the few samples during an impact, as velocities are known to half a step only. Contact places are means
    over a sample, so the moment is less exact.
    """
    time, ground = scene_trajectory["time"].to_numpy(), scene_trajectory["ground_acceleration"].to_numpy()
    known = np.flatnonzero(np.isfinite(scene_trajectory["contact_force"].to_numpy()).all(axis=(1, 2)))
    assert known.size == len(time) - known[0] > 100
    steps = np.diff(time)[known[:-1]]
    for item in scale_and_place_elements(load_shipped_scene(scene_trajectory.attrs["scene"])):
        if item.has_prescribed_motion:
            continue
        force, moment = (
            values[known[:-1]] for values in force_and_moment_on_element(scene_trajectory, item.element.name)
        )
        base = 0.5 * (ground[1:] + ground[:-1])[known[:-1]]
        one = scene_trajectory.sel(element=item.element.name)
        for rate, name, allowed in (
            (force[:, 0] / item.mass - base, "velocity_x", 0.01),
            (force[:, 1] / item.mass - G, "velocity_z", 0.01),
            (moment / item.inertia_about_centre_of_mass, "angular_velocity", 0.03),
        ):
            found = one[name].to_numpy()[known]
            gained = np.concatenate([[0.0], np.cumsum(rate * steps)])
            scale = max(np.abs(found).max(), np.abs(np.diff(found)).sum())
            wrong = np.abs(gained - (found - found[0]))
            assert np.quantile(wrong, 0.98) < allowed * scale, name
            assert wrong[-1] < allowed * scale, name


def test_forces_press_at_vertices_and_respect_coulomb_friction(scene_trajectory: xr.Dataset) -> None:
    upright = scene_trajectory["contact_by"].isin(["ground", "pedestal"]).to_numpy()
    force = scene_trajectory["contact_force"].to_numpy()[:, upright]
    force = force[np.isfinite(force).all(axis=(1, 2))]
    assert (force[:, :, 1] >= 0).all()
    weight = scene_trajectory.attrs["weight"]
    if scene_trajectory.attrs["scene"] == "against-a-wall":  # its ground is level
        assert (np.abs(force[:, :, 0]) <= FRICTION * force[:, :, 1] + 1e-9 * weight).all()
        heights = scene_trajectory["contact_place"].to_numpy()[:, upright, 1]
        assert np.nanmax(np.abs(heights)) < 1e-3
    assert force[0].sum(axis=0) == pytest.approx([0.0, weight], abs=1e-3 * weight)


def test_the_slip_of_a_base_is_that_of_the_middle_of_its_lower_side(scene_trajectory: xr.Dataset) -> None:
    """The middle of the two lowest vertices is not necessarily below the centre; the ground does not rotate."""
    item = next(
        one
        for one in scale_and_place_elements(load_shipped_scene(scene_trajectory.attrs["scene"]))
        if not one.has_prescribed_motion
    )
    way, low = scene_trajectory.sel(element=item.element.name), item.shape.vertices_from_whole_polygon_centroid
    low = low[low[:, 1] < low[:, 1].min() + 1e-9].mean(axis=0)
    turn = way["rotation"].to_numpy()
    x = way["x"].to_numpy() + low[0] * np.cos(turn) + low[1] * np.sin(turn)
    np.testing.assert_allclose(way["base_slip"], x - (item.centre_of_mass_x + low[0]), atol=1e-12)


def test_the_film_shows_forces_over_weight_at_their_points_of_action(scene_trajectory: xr.Dataset) -> None:
    film = film_of_trajectories([scene_trajectory], motion_of_one_sine_cycle_after_rest(6.0), "film")
    panel = film.panels[0]
    assert panel.contact_forces_over_weight is not None
    assert panel.contact_positions_by_frame is not None
    assert panel.contact_forces_over_weight.shape == panel.contact_positions_by_frame.shape
    assert panel.contact_forces_over_weight.shape[0] == film.frame_count
    assert np.isfinite(panel.contact_forces_over_weight).all()
    assert np.isfinite(panel.contact_positions_by_frame).all()
    standing = panel.contact_forces_over_weight[0][
        panel.contact_positions_by_frame[0, :, 1] < panel.contact_positions_by_frame[0, :, 1].min() + 1e-3
    ]
    assert standing[:, 1].sum() == pytest.approx(1.0, abs=1e-3)
    unknown = film.frame_times > float(scene_trajectory["time"][-1])
    assert not panel.contact_forces_over_weight[unknown].any(), "forces are unknown after the last sample"


def test_a_scene_that_stays_at_rest_has_missing_contact_forces() -> None:
    path = trajectory(motion_of_one_sine_cycle_after_rest(0.1), load_shipped_scene("three-tier"), azimuth_deg=0.0)
    assert path["status"] == 1
    assert np.isnan(path["contact_force"]).all()
    assert (
        film_of_trajectories([path], motion_of_one_sine_cycle_after_rest(0.1), "still")
        .panels[0]
        .contact_forces_over_weight
        is None
    )
