"""Films as GIF or MP4 files."""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from overturning.errors import ArgumentError, MissingDataError
from overturning.figures.film import Film, FilmPanel, extent_of_free_2d_bodies_with_margin, polygon_vertices_by_frame
from overturning.figures.film_strip import GROUND_COLOUR, STONE_COLOUR, draw_scale_bar
from overturning.figures.film_words import PLAYBACK_SPEED_LABELS, movie_title_with_speed
from overturning.figures.style import (
    FALL_COLOUR,
    INK,
    MATPLOTLIB_SETTINGS,
    SERIES_COLOURS,
    add_title_and_legend,
    create_panel_grid,
    label_axes,
    use_package_matplotlib_settings,
)
from overturning.figures.svg_translation import break_text_at_width, pad_to_equal_line_count
from overturning.figures.write import compute_layout_at_first_drawing_or_on_request
from overturning.files import atomic_write, check_output_path
from overturning.translation.texts import (
    ENGLISH,
    FONT_PACKAGE_AND_NAMES_BY_LANGUAGE,
    current_language,
    font_language_of_text,
    translate,
)
from overturning.units import GAL

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOVIE_SPEED_OVER_REAL_TIME = next(iter(PLAYBACK_SPEED_LABELS))
"""Speed of a movie, as a share of real time: that at which a film starts in the player. A frame of a film then takes
0.1 s, a multiple of the unit of a GIF."""

MOVIE_SUFFIXES = (".gif", ".mp4")

_PANEL_WIDTH_INCHES: Final = 3.6
"""Width of a panel of a movie, inches."""

_CJK_FONT_PATH_PATTERN: Final = re.compile(r"cjk|ipa", re.IGNORECASE)
"""Part of the path of a font that may have Japanese characters."""


def check_film_can_be_written(path: Path, *, is_3d: bool) -> None:
    """Raise an error for a 3-D film in another format than .html, and for an MP4 if ffmpeg is not installed.

    A call before the simulation saves the time for a film that could not be written.
    """
    if is_3d and path.suffix.lower() != ".html":
        raise ArgumentError(f"{path.name}: a film of a 3-D body is an HTML page; use the extension .html")
    if path.suffix.lower() == ".mp4" and which("ffmpeg") is None:
        raise MissingDataError(f"{path.name}: MP4 needs the program ffmpeg; install it, or write .gif or .html instead")


def write_film_as_gif_or_mp4(film: Film, path: Path) -> None:
    """Write a film as GIF (with Pillow) or MP4 (with ffmpeg, if it is installed); the file is reproducible.

    Raises the errors of `check_film_can_be_written`, and an `ArgumentError` for an extension other than .gif and .mp4.
    """
    import matplotlib as mpl
    from matplotlib import animation

    from overturning.figures.ticks import limit_ticks_to_axis_range

    kind = path.suffix.lower()
    check_film_can_be_written(path, is_3d=film.panels[0].shows_3d_body)
    check_output_path(path, "film", *MOVIE_SUFFIXES)
    rate: Any = MOVIE_SPEED_OVER_REAL_TIME / film.frame_interval
    # Leave date and encoder version out of the file, because they differ between runs.
    exact = ["-pix_fmt", "yuv420p", "-fflags", "+bitexact", "-flags:v", "+bitexact"]
    with use_package_matplotlib_settings(), atomic_write(path) as part:
        if current_language() != ENGLISH:
            film = _translate_panel_texts_of_film(film)
        names = "".join([film.title, *(panel.outcome_sentence for panel in film.panels)])
        if (language := font_language_of_text(names)) != ENGLISH:
            mpl.rcParams["font.family"] = [
                MATPLOTLIB_SETTINGS["font.family"][0],
                name_of_installed_font_of_language(language, path.name),
            ]
        figure, move_artists_and_tell_if_text_changed = _create_movie_figure_and_updater(film)
        limit_ticks_to_axis_range(figure)
        compute_layout_again = compute_layout_at_first_drawing_or_on_request(
            figure
        )  # the layout takes longer than the drawing
        writer: Any = animation.PillowWriter(fps=rate)
        if kind == ".mp4":
            writer = animation.FFMpegWriter(fps=rate, codec="libx264", extra_args=exact)
        named = part.with_name(f"{part.name}{kind}")  # the writers choose the format by the extension
        try:
            with writer.saving(figure, str(named), dpi=90):
                for frame in range(film.frame_count):
                    if move_artists_and_tell_if_text_changed(frame):
                        compute_layout_again()
                    writer.grab_frame()
            named.replace(part)
        finally:
            named.unlink(missing_ok=True)


def name_of_installed_font_of_language(language: str, file_name_in_error_message: str) -> str:
    """Return the name of an installed font for a language; without one, raise an error with the package to install."""
    from matplotlib import font_manager

    package, names = FONT_PACKAGE_AND_NAMES_BY_LANGUAGE[language]
    known = {one.fname for one in font_manager.fontManager.ttflist}
    for path in font_manager.findSystemFonts():  # the list of fonts that Matplotlib keeps may be older than the font
        if path not in known and _CJK_FONT_PATH_PATTERN.search(path):
            font_manager.fontManager.addfont(path)
    listed = {one.name for one in font_manager.fontManager.ttflist}
    if found := [name for name in names if name in listed and "Serif" not in name]:
        return found[0]
    raise MissingDataError(
        f"{file_name_in_error_message}: no font for the language {language}; install the Debian package {package}"
    )


def _translate_panel_texts_of_film(film: Film) -> Film:
    """Return a film with the headings and outcomes of its panels translated into the current language."""
    panels = (
        replace(panel, title=translate(panel.title), outcome_sentence=translate(panel.outcome_sentence))
        for panel in film.panels
    )
    return replace(film, panels=tuple(panels))


def _translated_movie_title_with_speed(film: Film, max_line_width_inches: float) -> str:
    """Return the title of a movie with its playback speed; if not in English, translated and broken into lines."""
    title = movie_title_with_speed(film.title, PLAYBACK_SPEED_LABELS[MOVIE_SPEED_OVER_REAL_TIME])
    if current_language() == ENGLISH:
        return title
    return break_text_at_width(translate(title), max_line_width_inches, 10.5)


def _create_movie_figure_and_updater(film: Film) -> "tuple[Figure, Callable[[int], bool]]":
    """Return a figure for a film, and a function that draws the film's frame of a given index in this figure.

    The function returns True if an outcome text has changed, which requires a new layout.
    """
    from matplotlib.patches import Polygon

    columns = len(film.panels)
    outcomes, most_lines = pad_to_equal_line_count(
        [break_text_at_width(panel.outcome_sentence, 0.9 * _PANEL_WIDTH_INCHES, 8.0) for panel in film.panels]
    )
    traces = len(film.panels[0].labelled_acceleration_traces(film.has_vertical_motion))
    tall = 3.4 + 1.0 * traces + 0.15 * (most_lines - 1)
    figure, panels = create_panel_grid(
        1 + traces, columns, _PANEL_WIDTH_INCHES * columns, tall, height_ratios=(3.4, *traces * [1])
    )
    add_title_and_legend(figure, _translated_movie_title_with_speed(film, figure.get_figwidth()))
    left, right, bottom, top = extent_of_free_2d_bodies_with_margin(film)
    rows: list[tuple[Any, ...]] = []
    for panel, outcome, scene, *trace_axes in zip(film.panels, outcomes, *panels, strict=True):
        scene.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
        scene.spines[:].set_visible(False)
        scene.set_title("{}\n← {}        {} →".format(panel.title, *panel.left_and_right_bearings), fontsize=8)
        shapes = []
        for body in panel.bodies:
            look = (
                {"facecolor": STONE_COLOUR, "edgecolor": INK}
                if body.is_free
                else {"facecolor": GROUND_COLOUR, "edgecolor": "none"}
            )
            shapes.append(
                (
                    polygon_vertices_by_frame(body),
                    scene.add_patch(Polygon(polygon_vertices_by_frame(body)[0], closed=True, linewidth=0.8, **look)),
                )
            )
        marks = _draw_traces_and_current_time_lines(trace_axes, film, panel)
        draw_scale_bar(scene, (left, right, bottom, top))
        rows.append((panel, outcome, shapes, marks, scene.set_xlabel("", fontsize=8)))

    def move_artists_and_tell_if_text_changed(frame_index: int) -> bool:
        """Move the drawn bodies and time marks to a frame; return True if an outcome text has changed."""
        text_changed = False
        time = film.first_frame_time + frame_index * film.frame_interval
        for panel, outcome, shapes, marks, text in rows:
            for places, shape in shapes:
                shape.set_xy(places[min(frame_index, len(places) - 1)])
            for mark in marks:
                mark.set_xdata([time, time])
            due = film.last_frame_time - 1e-9 if np.isnan(panel.last_fall_time) else panel.last_fall_time
            shown = outcome if time >= due else "\n".join(most_lines * " ")
            text_changed |= text.get_text() != shown
            text.set_text(shown)
        return text_changed

    return figure, move_artists_and_tell_if_text_changed


def _draw_traces_and_current_time_lines(trace_axes: Sequence[Any], film: Film, panel: FilmPanel) -> list[Any]:
    """Draw the acceleration traces of a film panel; return the lines that mark the current time, to be moved later.

    All traces of a film have one scale. Horizontal and vertical traces are named only if both are drawn.
    """
    largest, marks = film.peak_base_acceleration_of_all_panels / GAL or 1.0, []
    for axes, (label, components) in zip(
        trace_axes, panel.labelled_acceleration_traces(film.has_vertical_motion), strict=True
    ):
        for component in components:
            time = np.arange(component.size) * panel.acceleration_sampling_interval
            axes.plot(time, component / GAL, color=SERIES_COLOURS[0], linewidth=0.6)
        axes.set(
            xlim=(film.first_frame_time, max(film.last_frame_time, film.first_frame_time + 1e-3)),
            ylim=(-1.05 * largest, 1.05 * largest),
        )
        if len(trace_axes) > 1:
            axes.set_title(translate(label), fontsize=8)
        label_axes(axes, translate("time, s") if axes is trace_axes[-1] else "", "Gal")
        marks.append(axes.axvline(film.first_frame_time, color=FALL_COLOUR, linewidth=1.2))
    return marks
