"""Films of 2-D and 3-D trajectories, and the figure of a 3-D body's axis."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from overturning.dem.simulate import simulate_as_arrays
from overturning.dem.trajectory import trajectory
from overturning.errors import ArgumentError
from overturning.figures.film import extent_of_free_2d_bodies_with_margin, polygon_vertices_by_frame
from overturning.figures.film_movie import write_film_as_gif_or_mp4
from overturning.figures.film_of_body import convex_hull_faces
from overturning.figures.film_of_trajectory import (
    SIMULATED_TIME_AFTER_OUTCOME_S,
    film_of_trajectories,
    first_and_last_movement_times_for_film,
    outcome_sentence,
)
from overturning.figures.film_strip import film_strip_frame_times_and_captions
from overturning.figures.page import film_page_html
from overturning.figures.response import tilt_path_and_hodographs_figure
from overturning.figures.style import use_package_matplotlib_settings
from overturning.figures.svg_translation import translate_svg
from overturning.figures.write import remove_layout_engine_and_check_if_text_cut_or_overlaps, save_figure_files
from overturning.model.scene import load_scene, parse_scene_content
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from overturning.records.catalogue import read_record_table
from overturning.records.processing import process_record
from overturning.records.read import read_record
from overturning.records.store import round_samples_to_stored_decimals
from tests.dem.paths import lower_corner_penetrations, trajectory_of_element_named_stone
from tests.figures.films import trajectory_of_3d_body
from tests.figures.test_film import unpack_film_numbers

RECORD_TABLE = Path(__file__).parents[2] / "config" / "records.tsv"

SLENDER_BLOCK = {"height": 0.6, "b_over_h": 0.3, "friction": 1.0}


@pytest.fixture(scope="module")
def sine_motion_after_rest() -> Motion:
    """Return 2 s of rest and one sine cycle to the north, strong enough to overturn a slender block."""
    time = np.arange(0, 6, 0.01)
    pulse = np.where((time > 2) & (time < 3), 9.0 * np.sin(2 * np.pi * (time - 2)), 0.0)
    return Motion(pulse, 0 * pulse, sampling_interval=0.01)


def test_film_of_a_fall_ends_with_the_block_on_its_side(sine_motion_after_rest: Motion) -> None:
    path = trajectory(sine_motion_after_rest, azimuth_deg=0, **SLENDER_BLOCK)
    side = int(trajectory_of_element_named_stone(path)["overturned"])
    assert side != 0
    cell = simulate_as_arrays(
        sine_motion_after_rest, azimuth_deg=[0], **{name: [value] for name, value in SLENDER_BLOCK.items()}
    )
    assert float(trajectory_of_element_named_stone(path)["overturning_time"]) == cell["overturning_time"].item()
    assert outcome_sentence(path).startswith("falls towards N at" if side > 0 else "falls towards S at")
    film = film_of_trajectories([path], sine_motion_after_rest, "pulse")
    assert film.first_frame_time == pytest.approx(1.6, abs=0.2)  # the quiet time before is not shown
    body = film.panels[0].bodies[1]
    assert body.angles_or_quaternions_by_frame[-1] == pytest.approx(side * np.pi / 2)
    assert sorted(polygon_vertices_by_frame(body)[-1, :, 1]) == pytest.approx([0, 0, 0.18, 0.18]), "it lies on its side"
    turned = np.abs(trajectory_of_element_named_stone(path)["rotation"].to_numpy()[-1])
    assert turned < np.pi / 2, "the path itself ends before"
    assert np.abs(np.diff(body.reference_point_positions_by_frame[:, 0])).max() < 0.06, "and does not jump"
    assert polygon_vertices_by_frame(body)[..., 1].min() > -0.01, "nothing sinks into the base"


def test_films_of_opposite_azimuths_mirror_each_other(sine_motion_after_rest: Motion) -> None:
    one, other = (trajectory(sine_motion_after_rest, azimuth_deg=angle, **SLENDER_BLOCK) for angle in (0, 180))
    assert int(trajectory_of_element_named_stone(one)["overturned"]) == -int(
        trajectory_of_element_named_stone(other)["overturned"]
    )
    assert outcome_sentence(one) == outcome_sentence(other)


def test_film_of_a_block_that_does_not_move_still_has_frames(sine_motion_after_rest: Motion) -> None:
    path = trajectory(sine_motion_after_rest, azimuth_deg=90, **SLENDER_BLOCK)
    assert first_and_last_movement_times_for_film(path) is None
    assert outcome_sentence(path).startswith("stands")
    film = film_of_trajectories([path], sine_motion_after_rest, "nothing")
    assert film.frame_count > 10


def test_a_film_of_two_azimuths_has_a_panel_for_each_and_ends_at_the_fall(sine_motion_after_rest: Motion) -> None:
    paths = [trajectory(sine_motion_after_rest, azimuth_deg=angle, **SLENDER_BLOCK) for angle in (0, 90)]
    film = film_of_trajectories(paths, sine_motion_after_rest, "two")
    assert film.last_frame_time < 6  # it stops at the fall
    assert [panel.title.split()[-1] for panel in film.panels] == ["N", "E"]
    assert len(film_page_html(film).encode()) < 300_000


def test_frames_show_the_trajectory_and_the_ground_at_their_times(sine_motion_after_rest: Motion) -> None:
    """In a frame the block has the pose of its trajectory, and the ground the exact displacement of the sine cycle."""
    path = trajectory(sine_motion_after_rest, azimuth_deg=0, **SLENDER_BLOCK)
    film = film_of_trajectories([path], sine_motion_after_rest, "pulse")
    panel, one = film.panels[0], trajectory_of_element_named_stone(path)
    frame = 40
    assert film.frame_times[frame] == pytest.approx(film.first_frame_time + 0.8)
    for name, column in (("x", 0), ("z", 1)):
        there = np.interp(film.frame_times[frame], path["time"], one[name])
        assert panel.bodies[1].reference_point_positions_by_frame[frame, column] == pytest.approx(there, abs=1e-12)
    assert panel.bodies[1].angles_or_quaternions_by_frame[frame] == pytest.approx(
        np.interp(film.frame_times[frame], path["time"], one["rotation"])
    )
    along, level = panel.ground_displacement_by_frame.T
    since = np.clip(film.frame_times - 2.0, 0.0, 1.0)
    exact = 9.0 / (2 * np.pi) * (since - np.sin(2 * np.pi * since) / (2 * np.pi))
    assert along == pytest.approx(exact, abs=2e-3)
    assert not level.any()
    left, right, _, _ = extent_of_free_2d_bodies_with_margin(film, adds_ground_displacement=True)
    seen = (polygon_vertices_by_frame(panel.bodies[1]) + panel.ground_displacement_by_frame[:, None])[..., 0]
    assert left < seen.min() < seen.max() < right


@pytest.mark.parametrize("height", [0.3, 6.0])
def test_ground_of_a_film_reaches_beyond_the_picture(height: float) -> None:
    """The ground fills the picture even if it rises by 1 m, or if the stone is higher than the ground is thick."""
    time = np.arange(0, 3, 0.01)
    wave = 0.6 * (2 * np.pi) ** 2 * np.cos(2 * np.pi * time) * (time < 2)
    motion = Motion(0.1 * wave, 0 * wave, wave, sampling_interval=0.01)
    film = film_of_trajectories(
        [trajectory(motion, azimuth_deg=0, **SLENDER_BLOCK | {"height": height})], motion, "thrown"
    )
    ground = polygon_vertices_by_frame(film.panels[0].bodies[0])
    shift = film.panels[0].ground_displacement_by_frame
    assert np.ptp(shift[:, 1]) > 1.0
    for moving in (False, True):
        left, right, bottom, _ = extent_of_free_2d_bodies_with_margin(film, adds_ground_displacement=moving)
        places = ground + (shift[:, None] if moving else 0.0)
        assert (places[..., 1].min(axis=1) < bottom).all()
        assert (places[..., 0].min(axis=1) < left).all()
        assert (places[..., 0].max(axis=1) > right).all()


def test_film_of_a_stack_ends_when_its_stones_lie() -> None:
    """All stones are slower than 1 cm/s in the last frame; when the outcome is decided, a stone is still falling."""
    motion = Motion.sine(7.0, 0.8)
    given = {"azimuth_deg": 0.0, "friction": 0.7}
    cut, path = (
        trajectory(motion, load_scene("three-tier"), **given, aftermath=time)
        for time in (0.0, SIMULATED_TIME_AFTER_OUTCOME_S)
    )
    film = film_of_trajectories([path], motion, "stack")
    speed = np.hypot(path["velocity_x"], path["velocity_z"]).max("element")
    assert float(speed.interp(time=float(cut["time"][-1]))) > 0.1
    assert float(speed.interp(time=film.last_frame_time)) < 0.01
    assert film.last_frame_time < float(path["time"][-1]), "it stops when nothing moves"


def test_outcome_of_several_falls_appears_after_the_last_fall() -> None:
    """A stone 12 cm wide falls before one 30 cm wide: the text names both falls, a printed strip shows the first."""
    elements = [{"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]}]
    for name, width, place in (("slim", 0.12, -2.0), ("stout", 0.3, 2.0)):
        elements.append({"name": name, "width": width, "height": 0.9, "stands_on": "ground", "at": [place, 0]})
    scene, motion = (
        parse_scene_content({"name": "two", "reference": "slim", "elements": elements}),
        Motion.sine(8.0, 1.0),
    )
    film = film_of_trajectories(
        [trajectory(motion, scene, azimuth_deg=0.0, aftermath=SIMULATED_TIME_AFTER_OUTCOME_S)], motion, "two"
    )
    panel = film.panels[0]
    times = [float(time) for time in re.findall(r"at ([\d.]+) s", panel.outcome_sentence)]
    assert panel.outcome_sentence.startswith("2 of 2 fall: slim falls")
    assert times[0] + 0.1 < times[1]
    assert [panel.first_fall_time_for_printed_strip, panel.last_fall_time] == pytest.approx(times, abs=0.006)
    assert film_strip_frame_times_and_captions(film)[0][2] == panel.first_fall_time_for_printed_strip


def test_films_of_two_settings_share_their_frames() -> None:
    """Panels with and without vertical motion have the same frames; each has a trace of the vertical motion."""
    level = Motion.sine(5.0, 0.8)
    up = 4.0 * np.sin(2 * np.pi * 5.0 * np.arange(level.sample_count) * level.sampling_interval)
    shaken = Motion(*level.horizontal_components, up, sampling_interval=level.sampling_interval)
    paths = [trajectory(each, azimuth_deg=0, **SLENDER_BLOCK) for each in (shaken, level)]
    film = film_of_trajectories(paths, [shaken, level], "both", headings=["with", "without"])
    assert [panel.title for panel in film.panels] == ["with", "without"]
    data = film.player_data()
    assert data["frames"] == len(film.frame_times)
    for panel, path in zip(film.panels, paths, strict=True):
        there = np.interp(film.frame_times, path["time"], trajectory_of_element_named_stone(path)["x"])
        moving = film.frame_times <= float(path["time"][-1])
        assert panel.bodies[1].reference_point_positions_by_frame[moving, 0] == pytest.approx(there[moving], abs=1e-12)
    assert [len(panel["traces"]) for panel in data["panels"]] == [2, 2]
    peaks = [
        [np.abs(unpack_film_numbers(trace["rows"][0])).max() for trace in panel["traces"]] for panel in data["panels"]
    ]
    assert peaks[0] == pytest.approx([500, 400], rel=0.01)
    assert peaks[1] == pytest.approx([500, 0], rel=0.01)
    assert data["peak"] == pytest.approx(500, rel=0.01)


def contact_forces_over_weight(path: xr.Dataset) -> np.ndarray:
    """Return the contact forces of a trajectory divided by the weight of the block."""
    return path["contact_force"].to_numpy() / path.attrs["weight"]


def test_contact_forces_at_rest_add_up_to_the_weight(sine_motion_after_rest: Motion) -> None:
    path = trajectory(sine_motion_after_rest, azimuth_deg=0, **SLENDER_BLOCK)
    force, point = contact_forces_over_weight(path), path["contact_place"].to_numpy()
    assert force[50].sum(axis=0) == pytest.approx([0, 1], abs=1e-3)
    assert force[50, 0] == pytest.approx(force[50, 1], abs=1e-3)
    assert point[50] == pytest.approx(np.array([[-0.09, 0], [0.09, 0]]), abs=1e-4)
    rotation = trajectory_of_element_named_stone(path)["rotation"].to_numpy()
    rocking = int(np.argmax(np.abs(rotation) > 0.1))
    lifted = 0 if rotation[rocking] > 0 else 1
    assert force[rocking, lifted] == pytest.approx([0, 0])
    assert np.isnan(point[rocking, lifted]).all()


def test_upward_acceleration_adds_to_the_contact_forces(sine_motion_after_rest: Motion) -> None:
    up = np.full(sine_motion_after_rest.sample_count, 3.0)
    pushed = Motion(
        0 * sine_motion_after_rest.north, 0 * sine_motion_after_rest.east, up, sampling_interval=0.01, trust_data=True
    )
    path = trajectory(pushed, azimuth_deg=0, leave_out=False, **SLENDER_BLOCK)
    assert contact_forces_over_weight(path)[100].sum(axis=0) == pytest.approx([0, 1 + 3.0 / 9.80665], abs=2e-3)


@pytest.fixture(
    scope="module",
    params=[("rinaldi", 32, 0.4, 0.6, 1.0), ("rinaldi", 32, 0.3, 0.6, 0.33), ("erzincan", 0, 0.25, 1.2, 0.58)],
)
def block_trajectory_under_record(request: pytest.FixtureRequest) -> xr.Dataset:
    """Return the path of a block that falls, falls while it slides, or rocks and stands, with the base velocity."""
    name, azimuth, b_over_h, height, friction = request.param
    record = round_samples_to_stored_decimals(
        process_record(read_record(read_record_table(RECORD_TABLE)[name], Path()), None)
    )
    shaking = Motion(record.north, record.east, None, sampling_interval=record.sampling_interval)
    path = trajectory(shaking, azimuth_deg=azimuth, height=height, b_over_h=b_over_h, friction=friction)
    # The record is linear between its samples, which are not all rows of the path.
    sample = np.arange(shaking.sample_count) * shaking.sampling_interval
    every = np.union1d(sample, path["time"])
    ground = np.interp(every, sample, shaking.acceleration_along(azimuth))
    velocity = np.concatenate([[0.0], np.cumsum(0.5 * (ground[1:] + ground[:-1]) * np.diff(every))])
    return path.assign(base_velocity=("time", np.interp(path["time"], every, velocity)))


def test_contact_forces_are_compressive_and_within_the_friction_limit(
    block_trajectory_under_record: xr.Dataset,
) -> None:
    """Forces are never tensile, and friction is at most μ times the normal force."""
    force = contact_forces_over_weight(block_trajectory_under_record)
    along, normal = force.sum(axis=1).T
    assert force[:, :, 1].min() >= 0
    # Allowed: 0.5 % of the weight, since the time of a sample is known to one step.
    assert (np.abs(along) - block_trajectory_under_record.attrs["friction"] * normal).max() < 5e-3
    up = lower_corner_penetrations(block_trajectory_under_record).T < 0
    stays_up = up[:-1] & up[1:]
    assert force[:-1][stays_up].max(initial=0.0) == 0
    assert stays_up.sum() > 50


def test_contact_forces_and_weight_account_for_the_change_of_momentum(
    block_trajectory_under_record: xr.Dataset,
) -> None:
    """M Δv = ∫ (Σ f + weight) dt from the start to any sample, and I Δω = ∫ Σ r × f dt."""
    force = contact_forces_over_weight(block_trajectory_under_record)[:-1]
    one = trajectory_of_element_named_stone(block_trajectory_under_record)
    time, g = block_trajectory_under_record["time"].to_numpy(), 9.80665
    centre = np.stack([one["x"], one["z"]], axis=1)
    arm = np.nan_to_num(
        block_trajectory_under_record["contact_place"].to_numpy()[:-1] - 0.5 * (centre[1:] + centre[:-1])[:, None, :]
    )
    half = (
        np.array([block_trajectory_under_record.attrs["b_over_h"], 1.0])
        * block_trajectory_under_record.attrs["height"]
        / 2
    )
    moment = (arm[:, :, 1] * force[:, :, 0] - arm[:, :, 0] * force[:, :, 1]).sum(axis=1)
    for rate, velocity, allowed in (
        (
            force.sum(axis=1)[:, 0] * g,
            (one["velocity_x"] + block_trajectory_under_record["base_velocity"]).to_numpy(),
            1e-3,
        ),
        ((force.sum(axis=1)[:, 1] - 1.0) * g, one["velocity_z"].to_numpy(), 1e-3),
        (moment * g / ((half**2).sum() / 3), one["angular_velocity"].to_numpy(), 0.01),
    ):
        gained = np.cumsum(rate * np.diff(time))
        found = velocity[1:] - velocity[0]
        assert np.abs(gained - found).max() < allowed * np.abs(found).max()


def test_the_outcome_sentence_gives_rotation_of_a_leaning_stone_in_degrees() -> None:
    ground = {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]}
    oblique = {"name": "stone", "width": 0.3, "height": 0.6, "stands_on": "ground", "rotation_deg": 10}
    scene = parse_scene_content({"name": "oblique", "reference": "stone", "elements": [ground, oblique]})
    quiet = Motion.sine(0.01, 1.0)
    text = outcome_sentence(trajectory(quiet, scene, azimuth_deg=0))
    assert re.fullmatch(r"stands; rotates by up to 1\d(\.\d)?°", text), text


def test_rolling_cylinder_is_not_reported_at_rest() -> None:
    """The cylinder rolls on its rim, and still rolls half a minute after the end of the motion."""
    motion = Motion.sine(4.5, 0.8, azimuth_deg=20)
    rest = np.zeros(round(30 / motion.sampling_interval))
    later = Motion(
        *(np.append(each, rest) for each in motion.horizontal_components), sampling_interval=motion.sampling_interval
    )
    given = {"height": 2.0, "b_over_h": 0.35, "orientation_deg": 0.0}
    short, long = (trajectory(each, "circle", **given) for each in (motion, later))
    assert abs(float(short.residual_twist) - float(long.residual_twist)) > 30
    for path in (short, long):
        assert outcome_sentence(path).endswith("cm by the end, where it still rocks or rolls")
    assert outcome_sentence(trajectory(later, "rectangle", **given)).endswith("by the end")


@pytest.mark.parametrize("status", [one for one in CaseStatus if not one.trajectory_has_known_outcome])
def test_the_outcome_sentence_of_a_case_without_outcome_states_the_reason(status: CaseStatus) -> None:
    sentence = outcome_sentence(xr.Dataset({"status": status.value}))
    assert sentence.startswith("no outcome: ")
    assert ("moving" in sentence) == (status is CaseStatus.UNDECIDED)
    assert ("steps" in sentence) == (status is CaseStatus.OVER_BUDGET)


def test_film_without_trajectory_is_refused() -> None:
    with pytest.raises(ArgumentError, match="at least one"):
        film_of_trajectories([], Motion(np.zeros(2), np.zeros(2), sampling_interval=0.01), "none")


@pytest.fixture(scope="module")
def pulse_along_oblique_azimuth() -> Motion:
    """Return a motion along 29° (0.5 rad): one sine cycle of 1 s and 7 m/s²."""
    time = np.arange(0, 2.5, 0.01)
    samples = 7.0 * np.sin(2 * np.pi * time / 1.0) * (time < 1.0)
    return Motion(samples * np.cos(0.5), samples * np.sin(0.5), sampling_interval=0.01)


@pytest.fixture(scope="module")
def trajectories_of_falling_and_standing_body(pulse_along_oblique_azimuth: Motion) -> list:
    """Return the trajectories of a slender 3-D body, which falls, and of a stout one, which stands."""
    return [trajectory_of_3d_body(pulse_along_oblique_azimuth, ratio) for ratio in (0.25, 0.6)]


def test_film_body_of_a_box_has_six_outward_faces() -> None:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)], float)
    faces = convex_hull_faces(corners)
    assert sorted(map(len, faces)) == [4] * 6
    for face in faces:
        a, b, c = corners[list(face[:3])]
        assert np.cross(b - a, c - b) @ corners[list(face)].mean(axis=0) > 0


def test_filmed_3d_body_stays_on_the_base_and_falls_to_its_azimuth(
    trajectories_of_falling_and_standing_body: list, pulse_along_oblique_azimuth: Motion
) -> None:
    film = film_of_trajectories(trajectories_of_falling_and_standing_body, pulse_along_oblique_azimuth, "title")
    panel = film.panels[0]
    (body,) = panel.bodies
    rest = body.vertices_from_reference_point

    def corner_positions_at_film_frame(frame: int) -> np.ndarray:
        w, *u = body.angles_or_quaternions_by_frame[frame] / np.linalg.norm(body.angles_or_quaternions_by_frame[frame])
        return body.reference_point_positions_by_frame[frame] + rest + 2 * np.cross(u, np.cross(u, rest) + w * rest)

    lowest = [corner_positions_at_film_frame(frame)[:, 2].min() for frame in range(film.frame_count)]
    assert np.abs(lowest).max() < 0.02, "between samples it may hover, but does not sink"
    moved = (
        corner_positions_at_film_frame(film.frame_count - 1)[rest[:, 2] > 0].mean(axis=0)
        - body.reference_point_positions_by_frame[0]
    )
    azimuth = np.degrees(np.arctan2(moved[0], moved[1])) % 360
    assert azimuth == pytest.approx(float(trajectories_of_falling_and_standing_body[0]["fall_azimuth"]), abs=15)
    assert panel.outcome_sentence.startswith("falls towards ")
    assert "slipped" in film.panels[1].outcome_sentence
    assert "stands" in outcome_sentence(trajectories_of_falling_and_standing_body[1])
    assert len(film.player_data()["panels"][0]["traces"][0]["rows"]) == 2


def test_film_of_a_3d_body_is_refused_as_a_gif(
    trajectories_of_falling_and_standing_body: list, pulse_along_oblique_azimuth: Motion, tmp_path: Path
) -> None:
    film = film_of_trajectories(trajectories_of_falling_and_standing_body, pulse_along_oblique_azimuth, "title")
    with pytest.raises(ArgumentError, match=r"use the extension \.html"):
        write_film_as_gif_or_mp4(film, tmp_path / "film.gif")
    assert not list(tmp_path.iterdir())


def test_axis_figure_of_a_standing_body_has_a_short_title(tmp_path: Path) -> None:
    """The title states only the largest tilt: with twist and slip too, it would cover the title next to it."""
    time = np.arange(0, 2, 0.01)
    weak = Motion(2.5 * np.sin(2 * np.pi * time), 0 * time, sampling_interval=0.01)
    path = trajectory_of_3d_body(weak, 0.5)
    with use_package_matplotlib_settings():
        figure = tilt_path_and_hodographs_figure(path, weak, "title")
        save_figure_files(figure, tmp_path / "axis.svg")
    assert figure.axes[0].get_title().split("\n")[1] == f"stands; largest tilt {float(path['peak_tilt']):.1f}°"
    assert not remove_layout_engine_and_check_if_text_cut_or_overlaps(figure)
    assert "転倒せず、最大傾斜" in translate_svg((tmp_path / "axis.svg").read_text(encoding="utf-8"), "ja")


def test_axis_figure_of_a_stack_has_name_and_critical_angle_of_the_stone() -> None:
    """A shaft 0.2 m wide, 0.1 m deep and 0.6 m high balances at arctan(1/6), whatever the B/H of the stack."""
    elements = [
        {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]},
        {"name": "base", "width": 0.5, "height": 0.2, "depth": 0.5, "stands_on": "ground"},
        {"name": "shaft", "width": 0.2, "height": 0.6, "depth": 0.1, "stands_on": "base"},
    ]
    stack = parse_scene_content({"name": "narrow", "reference": "shaft", "elements": elements})
    time = np.arange(0, 0.5, 0.01)
    weak = Motion(0.1 * np.sin(2 * np.pi * time), 0 * time, sampling_interval=0.01)
    path = trajectory(weak, stack, orientation_deg=0.0)
    axes = tilt_path_and_hodographs_figure(path, weak, "title").axes[0]
    assert axes.get_title().startswith("tilt of the axis of the shaft, degrees\nstands")
    circle = next(line for line in axes.lines if line.get_label() == "least critical angle")
    assert np.hypot(*circle.get_xydata().T) == pytest.approx(np.degrees(np.arctan(1 / 6)))


def test_critical_angles_and_axis_figure_of_a_stack_match_its_2d_scene_and_reference() -> None:
    """The reference element is a foot; a shaft stands on it 0.2 m off its middle and carries a roof.

    The shaft balances over the rim of the foot, 0.1 m off the axis of the shaft: arctan(0.1/0.45). The roof, 0.2 m
    high, balances over the rim of the shaft: arctan(0.15/0.1). The same scene in 2-D has the same angles.
    """
    elements = [
        {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]},
        {"name": "foot", "width": 0.6, "height": 0.25, "depth": 0.6, "stands_on": "ground"},
        {"name": "shaft", "width": 0.3, "height": 0.9, "depth": 0.3, "stands_on": "foot", "at": [0.2, 0.0]},
        {"name": "roof", "width": 0.7, "height": 0.2, "depth": 0.7, "stands_on": "shaft"},
    ]
    stack = parse_scene_content({"name": "lantern", "reference": "foot", "elements": elements})
    weak = Motion(0.1 * np.sin(2 * np.pi * np.arange(0, 0.5, 0.01)), np.zeros(50), sampling_interval=0.01)
    in_space, in_plane = trajectory(weak, stack, orientation_deg=0.0), trajectory(weak, stack, azimuth_deg=0.0)
    np.testing.assert_allclose(in_space["critical_angle"], np.arctan([0.3 / 0.125, 0.1 / 0.45, 0.15 / 0.1]))
    free = in_plane.sel(element=["foot", "shaft", "roof"])
    np.testing.assert_allclose(in_space["critical_angle"], free["critical_angle"])
    assert in_space.attrs["weight"] == pytest.approx(in_plane.attrs["weight"])
    assert in_space.attrs["reference"] == in_plane.attrs["reference"] == "foot"
    assert (
        tilt_path_and_hodographs_figure(in_space, weak, "title")
        .axes[0]
        .get_title()
        .startswith("tilt of the axis of the foot")
    )


def test_tilt_path_figure_shows_fall_direction_of_body_axis(
    trajectories_of_falling_and_standing_body: list, pulse_along_oblique_azimuth: Motion
) -> None:
    with use_package_matplotlib_settings():
        figure = tilt_path_and_hodographs_figure(
            trajectories_of_falling_and_standing_body[0], pulse_along_oblique_azimuth, "title"
        )
        titles = [axes.get_title() for axes in figure.axes]
        line = next(line for line in figure.axes[0].lines if line.get_label() == "axis of the body")
    assert "falls towards" in titles[0]
    end = np.array([line.get_xdata()[-1], line.get_ydata()[-1]])
    assert np.degrees(np.arctan2(*end)) % 360 == pytest.approx(
        float(trajectories_of_falling_and_standing_body[0]["fall_azimuth"]), abs=3
    )
    assert np.hypot(*end) > 80, "nearly lying"
    looks = {one.get_label(): (one.get_marker(), one.get_color()) for one in figure.legends[0].get_lines()}
    dots = [axes.lines[1] for axes in figure.axes[1:]]
    assert [(dot.get_marker(), dot.get_color()) for dot in dots] == 2 * [looks["peak"]] != 2 * [looks["end"]]
    deep = (
        tilt_path_and_hodographs_figure(
            trajectories_of_falling_and_standing_body[0].assign_attrs(aspect=0.5), pulse_along_oblique_azimuth, "title"
        )
        .axes[0]
        .lines[0]
    )
    least = np.degrees(
        np.arctan(0.5 * trajectories_of_falling_and_standing_body[0].attrs["b_over_h"])
    )  # over the edges of its narrower sides
    assert np.hypot(*deep.get_xydata().T) == pytest.approx(least)
