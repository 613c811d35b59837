"""Films: data, page, GIF and MP4."""

import base64
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.layout_engine import ConstrainedLayoutEngine
from PIL import Image

from overturning.errors import ArgumentError, MissingDataError
from overturning.figures.film import Film, FilmPanel, extent_of_free_2d_bodies_with_margin, polygon_vertices_by_frame
from overturning.figures.film_movie import write_film_as_gif_or_mp4
from overturning.figures.film_strip import film_strip_figure
from overturning.figures.page import film_page_html, write_film_html_page
from overturning.figures.style import use_package_matplotlib_settings
from tests.figures.films import FILM_BASE, film_of_one_falling_and_one_rocking_block, rocking_film_block


def unpack_film_numbers(packed: dict[str, Any]) -> np.ndarray:
    """Return the numbers that a film page stores as a scale and the base64 text of 16-bit integers."""
    return np.frombuffer(base64.b64decode(packed["data"]), "<i2") * packed["scale"]


def test_positions_and_rotations_survive_packing_into_the_page() -> None:
    film = film_of_one_falling_and_one_rocking_block()
    for panel, data in zip(film.panels, film.player_data()["panels"], strict=True):
        body, packed = panel.bodies[1], data["bodies"][1]
        assert unpack_film_numbers(packed["position"]).reshape(-1, 2) == pytest.approx(
            body.reference_point_positions_by_frame, abs=2e-5
        )
        assert unpack_film_numbers(packed["rotation"]) == pytest.approx(body.angles_or_quaternions_by_frame, abs=1e-4)
    assert "NaN" not in json.dumps(film.player_data())


def test_positive_rotation_in_a_film_turns_towards_the_right() -> None:
    standing, turned = polygon_vertices_by_frame(rocking_film_block(np.array([0.0, 0.3])))
    assert standing[:, 1].min() == pytest.approx(0)
    assert turned[1] == pytest.approx([0.12, 0.0])  # it turns about its right lower corner
    assert turned[2, 0] > standing[2, 0]
    assert turned[0, 1] > 0


def test_film_view_contains_all_free_bodies() -> None:
    left, right, bottom, top = extent_of_free_2d_bodies_with_margin(film_of_one_falling_and_one_rocking_block())
    assert left < -0.12
    assert 0.12 + 0.6 < right < 2, "the fallen block lies to the right of its corner, and the wide base does not count"
    assert bottom < 0 < 0.6 < top


def test_film_page_is_small_reproducible_and_self_contained(tmp_path: Path) -> None:
    for name in ("a.html", "b.html"):
        write_film_html_page(film_of_one_falling_and_one_rocking_block(duration=30.0), tmp_path / name)
    page = (tmp_path / "a.html").read_bytes()
    assert page == (tmp_path / "b.html").read_bytes()
    assert len(page) < 300_000
    for word in (b"http", b"@import"):
        assert word not in page
    assert page.count(b"src=") == page.count(b'src="data:image/svg+xml;base64,') == 1, "the strip, inside the page"


def test_motion_thinned_for_a_film_keeps_its_peak() -> None:
    acceleration = np.zeros(4000)
    acceleration[1237] = 7.0
    panel = FilmPanel("p", "stands", np.nan, (FILM_BASE, rocking_film_block(np.zeros(100))), acceleration, 0.0005)
    ((motion,),) = (trace["rows"] for trace in Film("f", 0.0, 0.02, (panel,)).player_data()["panels"][0]["traces"])
    assert unpack_film_numbers(motion).max() == pytest.approx(700, rel=1e-3)
    assert len(unpack_film_numbers(motion)) < 250


def test_films_without_panels_or_with_non_finite_poses_are_refused() -> None:
    with pytest.raises(ArgumentError, match="at least one"):
        Film("f", 0.0, 0.02, ())
    with pytest.raises(ArgumentError, match="not finite"):
        Film(
            "f",
            0.0,
            0.02,
            (FilmPanel("p", "", np.nan, (rocking_film_block(np.array([0.0, np.nan])),), np.zeros(3), 0.1),),
        )


@pytest.mark.long
def test_gif_has_the_frames_of_the_film(tmp_path: Path) -> None:
    for name in ("a.gif", "b.gif"):
        write_film_as_gif_or_mp4(film_of_one_falling_and_one_rocking_block(duration=0.9), tmp_path / name)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()
    with Image.open(tmp_path / "a.gif") as picture:
        assert picture.n_frames == 46
        assert picture.info["duration"] == 100, "a fifth of the speed"
        first = picture.convert("L").tobytes()
        picture.seek(picture.n_frames - 1)
        assert picture.convert("L").tobytes() != first
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.gif", "b.gif"]


LONG_OUTCOME = "2 of 3 fall: shaft falls towards N32°E at 2.22 s; upper-base falls towards S32°W at 3.14 s"


def film_with_long_outcome(duration: float) -> Film:
    """Return a film of two panels; the text of the outcome of the second is longer than a panel is wide."""
    film = film_of_one_falling_and_one_rocking_block(duration=duration)
    return replace(film, panels=(film.panels[0], replace(film.panels[1], outcome_sentence=LONG_OUTCOME)))


def test_a_long_outcome_is_broken_into_lines_in_a_movie(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No letter reaches the right edge. The text of the outcome of a panel without a fall appears in the last frame.

    The layout is computed for the first frame and for the last one, which has a new text, but not for the second one.
    """
    layouts: list[object] = []
    execute = ConstrainedLayoutEngine.execute
    monkeypatch.setattr(
        ConstrainedLayoutEngine, "execute", lambda self, figure: layouts.append(figure) or execute(self, figure)
    )
    write_film_as_gif_or_mp4(film_with_long_outcome(0.04), tmp_path / "a.gif")
    assert len(layouts) == 2
    with Image.open(tmp_path / "a.gif") as picture:
        assert picture.n_frames == 3
        picture.seek(picture.n_frames - 1)
        grey = np.asarray(picture.convert("L"), dtype=np.float64)
    assert grey[int(0.55 * len(grey)) : int(0.75 * len(grey)), -4:].min() > 200


def test_a_movie_shows_the_vertical_motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The lowest curve is the vertical motion; the motion along the azimuth, here zero, is a flat line above it."""
    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", lambda *_: None)  # slow, and places matter little here
    panel = film_of_one_falling_and_one_rocking_block(duration=0.0).panels[0]
    up = np.array([0.0, 3.0, -3.0, 3.0, 0.0])
    shaken = replace(
        panel, horizontal_base_acceleration=0.0 * up, vertical_base_acceleration=up, acceleration_sampling_interval=2e-4
    )
    write_film_as_gif_or_mp4(Film("f", 0.0, 0.02, (shaken,)), tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as picture:
        red, _, blue = np.moveaxis(np.asarray(picture.convert("RGB"), dtype=np.int64), -1, 0)
    curve = np.flatnonzero((blue - red > 90).any(axis=1))
    assert np.ptp(curve[curve > curve.max() - 60]) > 20


def test_a_long_outcome_is_broken_into_lines_in_a_strip() -> None:
    with use_package_matplotlib_settings():
        figure = film_strip_figure(film_with_long_outcome(0.4))
        figure.draw_without_rendering()
        captions = [text for axes in figure.axes for text in axes.texts if "fall" in text.get_text()]
        boxes = [text.get_window_extent() for text in captions]
    assert all(figure.bbox.contains(*corner) for box in boxes for corner in (box.min, box.max))
    assert " ".join(captions[-1].get_text().split()).endswith(LONG_OUTCOME)


def test_mp4_is_written_or_the_error_names_ffmpeg(tmp_path: Path) -> None:
    if shutil.which("ffmpeg") is None:
        with pytest.raises(MissingDataError, match="ffmpeg"):
            write_film_as_gif_or_mp4(film_of_one_falling_and_one_rocking_block(duration=0.4), tmp_path / "a.mp4")
        assert not list(tmp_path.iterdir())
        return
    write_film_as_gif_or_mp4(film_of_one_falling_and_one_rocking_block(duration=0.4), tmp_path / "a.mp4")
    assert os.path.getsize(tmp_path / "a.mp4") > 1000


def test_movie_files_other_than_gif_and_mp4_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match="avi"):
        write_film_as_gif_or_mp4(film_of_one_falling_and_one_rocking_block(duration=0.4), tmp_path / "a.avi")


def test_title_of_a_film_cannot_end_the_script_of_its_page() -> None:
    page = film_page_html(
        film_of_one_falling_and_one_rocking_block(duration=0.4, title="</script><script>window.hurt = 1</script>")
    )
    assert "<script>window.hurt" not in page
