"""Film strip of a case: four frames in columns, and a title that states size, friction and direction."""

import math

import numpy as np
import pytest

from overturning.figures.film import Film, polygon_vertices_by_frame
from overturning.figures.film_case import film_title_facts
from overturning.figures.film_strip import (
    body_at_frame,
    draw_scale_bar,
    film_strip_figure,
    film_strip_frame_times_and_captions,
)
from overturning.figures.film_words import (
    STRIP_CAPTIONS_ALL_FALL,
    STRIP_CAPTIONS_NONE_FALL,
    STRIP_CAPTIONS_SOME_FALL,
    film_title_text,
    length_with_unit,
)
from overturning.figures.style import create_figure, use_package_matplotlib_settings
from overturning.model.body import Body
from overturning.model.planes import PlanarModel
from overturning.model.scene import gravestone, load_scene
from overturning.model.shapes import shape_from_name_or_sides
from tests.figures.films import film_of_one_falling_and_one_rocking_block


def test_film_strip_shows_the_times_of_uplift_and_fall() -> None:
    """The first block rotates by (π/2) ((t − 1)/1.5)³ from 1 s on.

    The second one rotates by 0.1 e⁻ᵗ sin 2πt, that is by 0.05 at 0.1 s.
    """
    film = film_of_one_falling_and_one_rocking_block()
    times, names = film_strip_frame_times_and_captions(film)
    assert names == STRIP_CAPTIONS_SOME_FALL, "the other block does not lie at the end"
    assert times == pytest.approx([0.0, 0.1, 2.1, film.last_frame_time], abs=0.021)
    alone = Film("falls", 0.0, 0.02, film.panels[:1])
    assert film_strip_frame_times_and_captions(alone)[1] == STRIP_CAPTIONS_ALL_FALL
    assert film_strip_frame_times_and_captions(alone)[0][1] == pytest.approx(
        1.0 + 1.5 * (0.05 / (math.pi / 2)) ** (1 / 3), abs=0.021
    )


def test_film_strip_of_a_standing_stone_shows_its_largest_rotation() -> None:
    times, names = film_strip_frame_times_and_captions(
        Film("stands", 0.0, 0.02, film_of_one_falling_and_one_rocking_block().panels[1:])
    )
    assert names == STRIP_CAPTIONS_NONE_FALL
    # The largest of e⁻ᵗ sin 2πt is where tan 2πt = 2π.
    assert times[2] == pytest.approx(math.atan(2 * math.pi) / (2 * math.pi), abs=0.011)


def test_film_strip_columns_show_the_body_at_the_times_of_their_captions() -> None:
    film = film_of_one_falling_and_one_rocking_block()
    with use_package_matplotlib_settings():
        figure = film_strip_figure(film)
    assert len(figure.axes) == 8
    times, _ = film_strip_frame_times_and_captions(film)
    for column, time in enumerate(times):
        drawn = figure.axes[column].patches[1].get_xy()[:-1]
        body = body_at_frame(film.panels[0].bodies[1], time / 0.02)
        assert drawn == pytest.approx(polygon_vertices_by_frame(body)[0])
    fallen = figure.axes[3].patches[1].get_xy()
    assert np.ptp(fallen[:, 1]) == pytest.approx(0.24), "it lies on its side"


@pytest.mark.parametrize(
    ("width", "text", "length"),
    [(0.004, "1 mm", 0.001), (0.03, "1 cm", 0.01), (1.5, "50 cm", 0.5), (3.0, "1 m", 1.0), (300.0, "100 m", 100.0)],
)
def test_scale_bar_is_the_longest_round_length_within_a_third_of_the_width(
    width: float, text: str, length: float
) -> None:
    axes = create_figure(2.0, 2.0).subplots()
    draw_scale_bar(axes, (-width / 2, width / 2, 0.0, width))
    assert axes.texts[0].get_text() == text
    assert np.ptp(axes.lines[0].get_xdata()) == pytest.approx(length)


def test_lengths_are_written_in_cm_or_m() -> None:
    assert [length_with_unit(one) for one in (0.18, 0.242, 1.0, 1.25)] == ["18 cm", "24.2 cm", "1 m", "1.25 m"]


def test_film_titles_state_size_friction_and_direction() -> None:
    block = {"height": 0.6, "b_over_h": 0.3, "friction": 0.7}
    for model, size in (
        (Body(shape_from_name_or_sides("rectangle")), "A square stone 18 cm wide and 60 cm high"),
        (Body(shape_from_name_or_sides("circle")), "A round stone 18 cm across and 60 cm high"),
        (PlanarModel(gravestone()), "A stone 18 cm wide and 60 cm high"),
    ):
        title = film_title_text(film_title_facts(model, block, "Rinaldi", motion_azimuth_or_orientation_deg=30.0))
        assert title.startswith(f"{size}, friction 0.7, ")
        assert "N30°E" in title
        assert title.endswith("Rinaldi" if isinstance(model, Body) else "N30°E")
    deep = film_title_text(
        film_title_facts(Body(shape_from_name_or_sides("rectangle")), block | {"aspect": 2.0}, "Rinaldi")
    )
    assert deep.startswith("A stone 18 cm wide, 36 cm deep and 60 cm high")
    stack = film_title_text(film_title_facts(PlanarModel(load_scene("three-tier")), block, "Rinaldi"))
    assert "shaft 18 cm wide and 60 cm high" in stack
