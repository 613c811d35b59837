"""A film as GIF or MP4."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.errors import ArgumentError, MissingDataError
from overturning.figures.film import Film, Panel, corners, view
from overturning.figures.style import FALLS, INK, SERIES, caption, labels, style
from overturning.files import atomic_write
from overturning.units import GAL

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GIF_INTERVAL = 0.06
"""Time between the pictures of a GIF, s: its clock counts hundredths, and browsers slow down what is below 0.02."""

KINDS = (".gif", ".mp4")


class _Stage:
    """One figure whose artists are moved from frame to frame."""

    def __init__(self, film: Film) -> None:
        import matplotlib.pyplot as plt
        from matplotlib.patches import Polygon

        self.film = film
        planes = [panel for panel in film.panels if isinstance(panel, Panel)]
        if len(planes) < len(film.panels):
            raise ArgumentError("a film in space is a page that can be turned; end it in .html")
        columns = len(planes)
        self.figure: Figure
        self.figure, grid = plt.subplots(
            2, columns, figsize=(3.6 * columns, 4.4), height_ratios=(3.4, 1), squeeze=False, layout="constrained"
        )
        caption(self.figure, film.title)
        left, right, bottom, top = view(film)
        largest = max(float(np.abs(panel.acceleration).max(initial=0.0)) for panel in planes) / GAL or 1.0
        self.rows: list[tuple[Panel, list[tuple[Any, Any]], Any, Any]] = []
        for panel, scene, trace in zip(planes, grid[0], grid[1], strict=True):
            scene.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
            scene.spines[:].set_visible(False)
            scene.set_title(f"{panel.title}\n← {panel.left}        {panel.right} →", fontsize=8)
            shapes = []
            for body in panel.bodies:
                shape = Polygon(
                    corners(body, 0), closed=True, facecolor="#c9c4ba" if body.free else "#8a8a86",
                    edgecolor=INK if body.free else "none", linewidth=0.8,
                )  # fmt: skip
                scene.add_patch(shape)
                shapes.append((body, shape))
            text = scene.set_xlabel(" ", fontsize=8)
            time = np.arange(panel.acceleration.size) * panel.sampling_interval
            trace.plot(time, panel.acceleration / GAL, color=SERIES[0], linewidth=0.6)
            trace.set(xlim=(film.start, max(film.end, film.start + 1e-3)), ylim=(-1.05 * largest, 1.05 * largest))
            labels(trace, "time, s", "Gal")
            self.rows.append((panel, shapes, trace.axvline(film.start, color=FALLS, linewidth=1.2), text))

    def show(self, frame: int) -> None:
        time = self.film.start + frame * self.film.frame_interval
        for panel, shapes, mark, text in self.rows:
            for body, shape in shapes:
                shape.set_xy(corners(body, frame))
            mark.set_xdata([time, time])
            due = self.film.end - 1e-9 if np.isnan(panel.outcome_time) else panel.outcome_time
            text.set_text(panel.outcome if time >= due else " ")


def check_movie(path: Path) -> None:
    """Refuse an MP4 where there is no ffmpeg; a `MissingDataError` says so, best before anything is computed."""
    from shutil import which

    if path.suffix.lower() == ".mp4" and which("ffmpeg") is None:
        raise MissingDataError(f"{path.name}: MP4 needs the program ffmpeg; install it, or write .gif or .html instead")


def write_film_movie(film: Film, path: Path) -> None:
    """Write a film as GIF (with Pillow) or MP4 (with ffmpeg, where it is installed).

    Raises
    ------
    ArgumentError
        If the ending is another one.
    MissingDataError
        If an MP4 is asked for and there is no ffmpeg.
    """
    import matplotlib.pyplot as plt
    from matplotlib import animation

    kind = path.suffix.lower()
    if kind not in KINDS:
        raise ArgumentError(f"{path.name}: unknown kind of animation; end it in .html, .gif or .mp4")
    check_movie(path)
    interval = GIF_INTERVAL if kind == ".gif" else 0.04
    step = max(1, round(interval / film.frame_interval))
    rate: Any = 1 / (step * film.frame_interval)
    frames = [*range(0, film.frames - 1, step), film.frames - 1]
    with style():
        stage = _Stage(film)
        writer: Any
        if kind == ".gif":
            writer = animation.PillowWriter(fps=rate)
        else:
            # No date and no encoder version in the file: both change from run to run.
            writer = animation.FFMpegWriter(
                fps=rate, codec="libx264",
                extra_args=["-pix_fmt", "yuv420p", "-fflags", "+bitexact", "-flags:v", "+bitexact"],
            )  # fmt: skip
        with atomic_write(path) as part:
            named = part.with_name(f"{part.name}{kind}")  # the writers tell the kind by the name
            try:
                with writer.saving(stage.figure, str(named), dpi=90):
                    for frame in frames:
                        stage.show(frame)
                        writer.grab_frame()
                named.replace(part)
            finally:
                named.unlink(missing_ok=True)
        plt.close(stage.figure)
