"""Films as GIF or MP4 files."""

from collections.abc import Callable
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.errors import ArgumentError, MissingDataError
from overturning.figures.film import Film, free_body_extent, vertex_paths
from overturning.figures.film_strip import GROUND, STONE, draw_scale_bar
from overturning.figures.film_words import SPEEDS, movie_title
from overturning.figures.style import FALLS, INK, SERIES, caption, grid, labels, style
from overturning.files import atomic_write, check_output_path
from overturning.units import GAL

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPEED = next(iter(SPEEDS))
"""Speed of a movie, as a share of real time: that at which a film starts in the player. A frame of a film then takes
0.1 s, a multiple of the unit of a GIF."""

KINDS = (".gif", ".mp4")


def check_movie(path: Path, *, in_space: bool) -> None:
    """Raise an error if a 3-D film is not to be a page, or if an MP4 is to be written without ffmpeg.

    It is called before the simulation, so that no time is lost.
    """
    if in_space and path.suffix.lower() != ".html":
        raise ArgumentError(f"{path.name}: a film of a 3-D body is an HTML page; use the extension .html")
    if path.suffix.lower() == ".mp4" and which("ffmpeg") is None:
        raise MissingDataError(f"{path.name}: MP4 needs the program ffmpeg; install it, or write .gif or .html instead")


def write_film_movie(film: Film, path: Path) -> None:
    """Write a film as GIF (with Pillow) or MP4 (with ffmpeg, if it is installed); the file is reproducible.

    Raises the errors of `check_movie`, and an `ArgumentError` for any other extension.
    """
    from matplotlib import animation

    kind = path.suffix.lower()
    check_movie(path, in_space=film.panels[0].in_space)
    check_output_path(path, "film", *KINDS)
    rate: Any = SPEED / film.frame_interval
    # Leave date and encoder version out of the file, because they differ between runs.
    exact = ["-pix_fmt", "yuv420p", "-fflags", "+bitexact", "-flags:v", "+bitexact"]
    with style(), atomic_write(path) as part:
        figure, show = _stage(film)
        writer: Any = animation.PillowWriter(fps=rate)
        if kind == ".mp4":
            writer = animation.FFMpegWriter(fps=rate, codec="libx264", extra_args=exact)
        named = part.with_name(f"{part.name}{kind}")  # the writers choose the format by the extension
        try:
            with writer.saving(figure, str(named), dpi=90):
                for frame in range(film.frames):
                    show(frame)
                    writer.grab_frame()
            named.replace(part)
        finally:
            named.unlink(missing_ok=True)


def _stage(film: Film) -> "tuple[Figure, Callable[[int], None]]":
    """Return a figure of the film, and a function that moves its artists to a frame."""
    from matplotlib.patches import Polygon

    columns = len(film.panels)
    figure, panels = grid(2, columns, 3.6 * columns, 4.4, height_ratios=(3.4, 1))
    caption(figure, movie_title(film.title, SPEEDS[SPEED]))
    left, right, bottom, top = free_body_extent(film)
    largest = max(float(np.abs(panel.acceleration).max(initial=0.0)) for panel in film.panels) / GAL or 1.0
    rows: list[tuple[Any, ...]] = []
    for panel, scene, trace in zip(film.panels, *panels, strict=True):
        scene.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
        scene.spines[:].set_visible(False)
        scene.set_title("{}\n← {}        {} →".format(panel.title, *panel.sides), fontsize=8)
        shapes = []
        for body in panel.bodies:
            look = {"facecolor": STONE, "edgecolor": INK} if body.free else {"facecolor": GROUND, "edgecolor": "none"}
            shapes.append(
                (
                    vertex_paths(body),
                    scene.add_patch(Polygon(vertex_paths(body)[0], closed=True, linewidth=0.8, **look)),
                )
            )
        time = np.arange(panel.acceleration.size) * panel.sampling_interval
        trace.plot(time, panel.acceleration / GAL, color=SERIES[0], linewidth=0.6)
        trace.set(xlim=(film.start, max(film.end, film.start + 1e-3)), ylim=(-1.05 * largest, 1.05 * largest))
        labels(trace, "time, s", "Gal")
        mark = trace.axvline(film.start, color=FALLS, linewidth=1.2)
        draw_scale_bar(scene, (left, right, bottom, top))
        rows.append((panel, shapes, mark, scene.set_xlabel(" ", fontsize=8)))

    def show(frame: int) -> None:
        time = film.start + frame * film.frame_interval
        for panel, shapes, mark, text in rows:
            for places, shape in shapes:
                shape.set_xy(places[min(frame, len(places) - 1)])
            mark.set_xdata([time, time])
            due = film.end - 1e-9 if np.isnan(panel.outcome_time) else panel.outcome_time
            text.set_text(panel.outcome if time >= due else " ")

    return figure, show
