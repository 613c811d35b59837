"""Strip of four frames of a film, for paper: start, first uplift, near the fall, and lying."""

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.figures.film import (
    Film,
    FilmBody,
    FilmPanel,
    extent_of_free_2d_bodies_with_margin,
    polygon_vertices_by_frame,
)
from overturning.figures.film_words import STRIP_CAPTIONS_ALL_FALL, STRIP_CAPTIONS_NONE_FALL, STRIP_CAPTIONS_SOME_FALL
from overturning.figures.style import (
    INK,
    PAGE_WIDTH_INCHES,
    add_title_and_legend,
    create_panel_grid,
    largest_round_number_up_to,
)
from overturning.figures.svg_translation import break_text_at_width, pad_to_equal_line_count

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MIN_VISIBLE_UPLIFT_ANGLE_RAD: Final = 0.05
"""Rotation at which an uplift is visible in a small picture, rad."""

STONE_COLOUR: Final = "#c9c4ba"
GROUND_COLOUR: Final = "#8a8a86"


def film_strip_frame_times_and_captions(film: Film) -> tuple[FloatArray, tuple[str, ...]]:
    """Return times (s) and captions of the four frames that a printed film shows, the same for all its panels.

    The frames show the start, the first uplift, the fall and the end. The fall is the first one in any panel, at the
    overturning time; if nothing falls, the frame of the largest rotation replaces it. The first uplift is the first
    frame in which any stone has turned by `MIN_VISIBLE_UPLIFT_ANGLE_RAD`, or, if smaller, by half of the largest
    rotation before the fall.
    """
    angle = np.max(
        [
            rotation_or_tilt_angle_by_frame(body, film.frame_count)
            for panel in film.panels
            for body in panel.bodies
            if body.is_free
        ],
        axis=0,
    )
    falls = [
        panel.first_fall_time_for_printed_strip
        for panel in film.panels
        if np.isfinite(panel.first_fall_time_for_printed_strip)
    ]
    if falls:
        near, names = (
            min(falls),
            STRIP_CAPTIONS_ALL_FALL if len(falls) == len(film.panels) else STRIP_CAPTIONS_SOME_FALL,
        )
    else:
        near, names = float(film.frame_times[int(angle.argmax())]), STRIP_CAPTIONS_NONE_FALL
    before = angle[: max(1, int(np.searchsorted(film.frame_times, near)))]
    visible = min(MIN_VISIBLE_UPLIFT_ANGLE_RAD, 0.5 * float(before.max()))
    first = film.frame_times[int(np.argmax(before >= visible))] if visible > 0 else 0.5 * (film.first_frame_time + near)
    return np.maximum.accumulate(np.array([film.first_frame_time, first, near, film.last_frame_time])), names


def rotation_or_tilt_angle_by_frame(body: FilmBody, frame_count: int) -> FloatArray:
    """Return the angle by which a free body has turned since its first frame (3-D: its tilt), rad, shape (frames,)."""
    if body.face_vertex_indices:
        _, x, y, _ = body.angles_or_quaternions_by_frame.T / np.linalg.norm(body.angles_or_quaternions_by_frame, axis=1)
        angle = np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0))
    else:
        angle = np.abs(body.angles_or_quaternions_by_frame - body.angles_or_quaternions_by_frame[0])
    return np.asarray(np.pad(angle, (0, frame_count - angle.size), mode="edge"))


def film_strip_figure(film: Film, *, has_title: bool = True) -> "Figure":
    """Return a figure with four frames of each panel of a film, in rows, for printing."""
    times, names = film_strip_frame_times_and_captions(film)
    rows = len(film.panels)
    edges = (
        _axis_limits_of_body_view(film) if film.panels[0].shows_3d_body else extent_of_free_2d_bodies_with_margin(film)
    )
    left, right, bottom, top = edges
    tall = PAGE_WIDTH_INCHES / len(names) * min((top - bottom) / (right - left), 1.3)
    captions, lines = pad_to_equal_line_count(
        [
            break_text_at_width(_caption_below_frame_row(panel, rows), 0.97 * PAGE_WIDTH_INCHES, 8.0)
            for panel in film.panels
        ]
    )
    high = rows * (tall + 0.2 + 0.15 * (lines - 1)) + 0.25 + 0.35 * has_title
    figure, panels = create_panel_grid(rows, len(names), PAGE_WIDTH_INCHES, high)
    if has_title:
        add_title_and_legend(figure, film.title)
    for row, (panel, caption, axes_row) in enumerate(zip(film.panels, captions, panels, strict=True)):
        for column, (axes, time, name) in enumerate(zip(axes_row, times, names, strict=True)):
            axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
            axes.spines[:].set_visible(False)
            draw_film_panel_at_frame(axes, panel, (time - film.first_frame_time) / film.frame_interval)
            if row == 0:
                axes.set_title(f"{name}, {time:.2f} s", fontsize=8)
            if column == 0:
                draw_scale_bar(axes, edges)
        # A long line must not widen the first column: leave it out of the layout, but keep its height.
        axes_row[0].set_xlabel("\n".join(lines * " "), fontsize=8)
        below = {"transform": axes_row[0].transAxes, "fontsize": 8, "va": "top"}
        axes_row[0].text(0.0, -0.03, caption, **below).set_in_layout(False)
    return figure


def _caption_below_frame_row(panel: FilmPanel, film_panel_count: int) -> str:
    """Return the text below a panel's row of frames: bearings of left and right (2-D), heading, and outcome."""
    sides = (
        f"← {panel.left_and_right_bearings[0]}    {panel.left_and_right_bearings[1]} →      "
        if panel.left_and_right_bearings[0]
        else ""
    )
    return sides + (f"{panel.title}: " if film_panel_count > 1 else "") + panel.outcome_sentence


def draw_film_panel_at_frame(axes: Any, panel: FilmPanel, fractional_frame_index: float) -> None:
    """Draw the bodies of a film panel at a frame index; 2.5, for instance, is half-way between frames 2 and 3."""
    from matplotlib.patches import Polygon

    if panel.shows_3d_body:
        _draw_bodies_with_floor(axes, panel.bodies, fractional_frame_index)
        return
    for body in panel.bodies:
        look = (
            {"facecolor": STONE_COLOUR, "edgecolor": INK}
            if body.is_free
            else {"facecolor": GROUND_COLOUR, "edgecolor": "none"}
        )
        places = polygon_vertices_by_frame(body_at_frame(body, fractional_frame_index))[0]
        axes.add_patch(Polygon(places, closed=True, linewidth=0.7, **look))


def body_at_frame(body: FilmBody, fractional_frame_index: float) -> FilmBody:
    """Return a body with a single pose, at a frame index; 2.5, for instance, is half-way between frames 2 and 3.

    An index beyond the last frame gives the last pose.
    """

    def interpolate_array_at_fractional_frame_index(positions_or_rotations_by_frame: FloatArray) -> FloatArray:
        """Return positions or rotations, interpolated at `fractional_frame_index`, as an array of one frame."""
        low = min(int(fractional_frame_index), len(positions_or_rotations_by_frame) - 1)
        high, part = (
            min(low + 1, len(positions_or_rotations_by_frame) - 1),
            min(max(fractional_frame_index - low, 0.0), 1.0),
        )
        return np.asarray(
            positions_or_rotations_by_frame[low] * (1.0 - part) + positions_or_rotations_by_frame[high] * part
        )[None]

    return FilmBody(
        body.name,
        body.vertices_from_reference_point,
        interpolate_array_at_fractional_frame_index(body.reference_point_positions_by_frame),
        interpolate_array_at_fractional_frame_index(body.angles_or_quaternions_by_frame),
        body.is_free,
        body.face_vertex_indices,
    )


def draw_scale_bar(axes: Any, left_right_bottom_top_m: tuple[float, float, float, float]) -> None:
    """Draw a scale bar of a round length in the lower left corner of a view, given the edges of the view, m."""
    left, right, bottom, top = left_right_bottom_top_m
    length = largest_round_number_up_to(0.35 * (right - left))
    x, y = left + 0.04 * (right - left), bottom + 0.11 * (top - bottom)
    unit, name = (1e-3, "mm") if length < 0.009 else (1e-2, "cm") if length < 0.9 else (1.0, "m")
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.85}
    text = f"{length / unit:.0f} {name}"
    axes.text(x, y - 0.03 * (top - bottom), text, fontsize=7, ha="left", va="top", bbox=box, zorder=5)
    axes.plot([x, x + length], [y, y], color=INK, linewidth=1.6, solid_capstyle="butt", zorder=6)


CAMERA_AZIMUTH_RAD: Final = 2.7
CAMERA_ELEVATION_RAD: Final = 0.42
"""Direction of the camera of a 3-D film at its start, rad; as in the player."""

DIRECTION_TOWARDS_LIGHT: Final = np.array([0.35, -0.5, 0.79])


def _camera_view_matrix() -> FloatArray:
    """Return the rotation matrix, shape (3, 3), from (east, north, up) to the camera's (right, up, towards viewer)."""
    (sa, ca), (se, ce) = ((np.sin(one), np.cos(one)) for one in (CAMERA_AZIMUTH_RAD, CAMERA_ELEVATION_RAD))
    return np.array([[-ca, sa, 0.0], [-se * sa, -se * ca, ce], [ce * sa, ce * ca, se]])


def corners_of_body_at_frame(body: FilmBody, frame_index: int = 0) -> FloatArray:
    """Return east, north and up, m, of the n corners of a 3-D body in one frame, shape (n, 3)."""
    w, *u = body.angles_or_quaternions_by_frame[frame_index] / np.linalg.norm(
        body.angles_or_quaternions_by_frame[frame_index]
    )
    return np.asarray(
        body.reference_point_positions_by_frame[frame_index]
        + body.vertices_from_reference_point
        + 2.0 * np.cross(u, np.cross(u, body.vertices_from_reference_point) + w * body.vertices_from_reference_point)
    )


def _axis_limits_of_body_view(film: Film) -> tuple[float, float, float, float]:
    """Return the view (left, right, bottom, top), m, that contains the 3-D bodies of all panels in every frame."""
    camera = _camera_view_matrix()[:2]
    places = [
        (corners_of_body_at_frame(body, frame) - panel.bodies[0].reference_point_positions_by_frame[0] * [1, 1, 0])
        @ camera.T
        for panel in film.panels
        for body in panel.bodies
        for frame in range(len(body.reference_point_positions_by_frame))
    ]
    half = _half_floor_width_m(film.panels[0].bodies)
    floor = np.array([[-half, -half, 0], [half, -half, 0], [half, half, 0], [-half, half, 0]]) @ camera.T
    points = np.concatenate([*places, floor])
    (left, bottom), (right, top) = points.min(axis=0), points.max(axis=0)
    margin = 0.04 * max(right - left, top - bottom)
    return float(left - margin), float(right + margin), float(bottom - margin), float(top + margin)


def _half_floor_width_m(bodies: tuple[FilmBody, ...]) -> float:
    """Return half of the width of the floor on which 3-D bodies are drawn, m."""
    corners = np.concatenate([corners_of_body_at_frame(body) for body in bodies]) - bodies[
        0
    ].reference_point_positions_by_frame[0] * [
        1,
        1,
        0,
    ]
    return 1.4 * float(np.linalg.norm(corners - [0.0, 0.0, 0.5 * corners[:, 2].max()], axis=1).max())


def _draw_bodies_with_floor(axes: Any, bodies: tuple[FilmBody, ...], fractional_frame_index: float) -> None:
    """Draw 3-D bodies at a frame in order of distance, with floor, shadows and an arrow to the north."""
    from matplotlib.patches import Polygon

    camera, begin = _camera_view_matrix(), bodies[0].reference_point_positions_by_frame[0] * [1, 1, 0]
    half = _half_floor_width_m(bodies)
    floor = np.array([[-half, -half, 0], [half, -half, 0], [half, half, 0], [-half, half, 0]]) @ camera[:2].T
    axes.add_patch(Polygon(floor, closed=True, facecolor="#e9e9e6", edgecolor="#c4c4c0", linewidth=0.6))
    for share in (-0.5, 0.0, 0.5):
        for line in (
            [[share * half, -half, 0], [share * half, half, 0]],
            [[-half, share * half, 0], [half, share * half, 0]],
        ):
            axes.plot(*(np.array(line) @ camera[:2].T).T, color="#c4c4c0", linewidth=0.4)
    north = np.array([[0, 0.72 * half, 0], [0, half, 0]]) @ camera[:2].T
    axes.annotate("", north[1], north[0], arrowprops={"arrowstyle": "->", "color": "#0072b2"})
    axes.text(*(np.array([0, 1.12 * half, 0]) @ camera[:2].T), "N", fontsize=7, ha="center", va="center")
    placed = [(body, corners_of_body_at_frame(body_at_frame(body, fractional_frame_index)) - begin) for body in bodies]
    for body, corners in placed:
        for face in body.face_vertex_indices:  # the shadow straight below
            shadow = (corners[list(face)] * [1, 1, 0]) @ camera[:2].T
            axes.add_patch(Polygon(shadow, facecolor="#b9b9b4", edgecolor="none"))
    for body, corners in sorted(placed, key=lambda one: float(camera[2] @ one[1].mean(axis=0))):
        _draw_body(axes, body, corners, camera)


def _draw_body(
    axes: Any, body: FilmBody, corner_positions_east_north_up: FloatArray, camera_rotation_matrix: FloatArray
) -> None:
    """Draw the visible faces of a 3-D body, given the positions of its corners (m, shape (n, 3)) and the camera."""
    from matplotlib.patches import Polygon

    for face in body.face_vertex_indices:
        a, b, c = corner_positions_east_north_up[list(face[:3])]
        normal = np.cross(b - a, c - b)
        if camera_rotation_matrix[2] @ normal <= 0:
            continue
        bright = 0.72 + 0.28 * float(DIRECTION_TOWARDS_LIGHT @ normal / np.linalg.norm(normal))
        colour = tuple(np.clip(np.array([201, 196, 186]) * bright / 255.0, 0.0, 1.0))
        axes.add_patch(
            Polygon(
                corner_positions_east_north_up[list(face)] @ camera_rotation_matrix[:2].T,
                facecolor=colour,
                edgecolor=INK,
                linewidth=0.7,
                zorder=3,
            )
        )
