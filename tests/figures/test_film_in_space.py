"""The film of a body in space: its faces, its data, and its page in a real browser."""

from pathlib import Path

import numpy as np
import pytest

from overturning.dem.body.trajectory import trajectory_in_space
from overturning.errors import ArgumentError
from overturning.figures.axis import axis_figure
from overturning.figures.film import SpacePanel, film_data
from overturning.figures.film_in_space import faces_of
from overturning.figures.film_movie import write_film_movie
from overturning.figures.film_of_trajectory import film_of, outcome
from overturning.figures.film_page import write_film_page
from overturning.figures.style import style
from overturning.motion.motion import Motion
from tests.figures.chromium import browser


@pytest.fixture(scope="module")
def motion() -> Motion:
    time = np.arange(0, 2.5, 0.01)
    pulse = 7.0 * np.sin(2 * np.pi * time / 1.0) * (time < 1.0)
    return Motion(pulse * np.cos(0.5), pulse * np.sin(0.5), sampling_interval=0.01)


@pytest.fixture(scope="module")
def paths(motion: Motion) -> list:
    return [
        trajectory_in_space(motion, orientation_deg=10.0, height=0.6, b_over_h=ratio, friction=0.8)
        for ratio in (0.25, 0.6)
    ]


def test_a_box_has_six_faces_that_look_outwards() -> None:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)], float)
    faces = faces_of(corners)
    assert sorted(map(len, faces)) == [4] * 6
    for face in faces:
        a, b, c = corners[list(face[:3])]
        assert np.cross(b - a, c - b) @ corners[list(face)].mean(axis=0) > 0


def test_the_corners_of_its_poses_stand_on_the_base_and_lie_where_it_fell(paths: list, motion: Motion) -> None:
    film = film_of(paths, motion, "title")
    panel = film.panels[0]
    assert isinstance(panel, SpacePanel)

    def corners(frame: int) -> np.ndarray:
        w, *u = panel.quaternion[frame] / np.linalg.norm(panel.quaternion[frame])
        turned = panel.corners + 2 * np.cross(u, np.cross(u, panel.corners) + w * panel.corners)
        return panel.position[frame] + turned

    lowest = [corners(frame)[:, 2].min() for frame in range(len(panel.position))]
    assert np.abs(lowest).max() < 0.02, "between samples it may hover, but does not sink"
    moved = corners(len(panel.position) - 1)[panel.corners[:, 2] > 0].mean(axis=0) - panel.position[0]
    azimuth = np.degrees(np.arctan2(moved[0], moved[1])) % 360
    assert azimuth == pytest.approx(float(paths[0]["fall_azimuth"]), abs=15)
    assert panel.outcome.startswith("falls towards ")
    assert "slipped" in film.panels[1].outcome
    assert "stands" in outcome(paths[1])
    assert len(film_data(film)["panels"][0]["motions"]) == 2


def test_a_film_in_space_is_a_page(paths: list, motion: Motion, tmp_path: Path) -> None:
    film = film_of(paths, motion, "title")
    with pytest.raises(ArgumentError, match=r"end it in \.html"):
        write_film_movie(film, tmp_path / "film.gif")
    assert not list(tmp_path.iterdir())


def test_the_figure_of_the_axis(paths: list, motion: Motion) -> None:
    with style():
        figure = axis_figure(paths[0], motion, "title")
        titles = [axes.get_title() for axes in figure.axes]
        line = next(line for line in figure.axes[0].lines if line.get_label() == "axis of the body")
    assert "falls towards" in titles[0]
    end = np.array([line.get_xdata()[-1], line.get_ydata()[-1]])
    assert np.degrees(np.arctan2(*end)) % 360 == pytest.approx(float(paths[0]["fall_azimuth"]), abs=3)
    assert np.hypot(*end) > 80, "nearly lying"


@pytest.mark.browser
def test_dragging_turns_it(paths: list, motion: Motion, tmp_path: Path) -> None:
    write_film_page(film_of(paths, motion, "title"), tmp_path / "film.html")
    with browser(tmp_path / "profile") as page:
        page.open(tmp_path / "film.html")
        page.wait("document.querySelector('.film').dataset.ready === 'true'")
        picture = "document.querySelector('canvas').toDataURL()"
        before = page.evaluate(picture)
        x, y = page.evaluate(
            "(() => { const b = document.querySelector('canvas').getBoundingClientRect(); return [b.x + 90, b.y + 90]; "
            "})()"
        )
        for kind, across in (("mousePressed", 0), ("mouseMoved", 60), ("mouseReleased", 60)):
            page.call("Input.dispatchMouseEvent", type=kind, x=x + across, y=y, button="left", clickCount=1)
        turned = page.evaluate(picture)
        assert turned != before
        page.evaluate("document.querySelector('.film').focus()")
        page.press("a", "KeyA", "a")
        assert page.evaluate(picture) != turned
        page.press("End")
        text = page.evaluate("document.querySelector('.film-outcome').textContent")
        assert text.startswith("falls towards")
        assert page.complaints == []
