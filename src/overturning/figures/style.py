"""Common style of all figures: colours, sizes, helpers for axes, legends and compasses."""

import gc
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.figures.svg_translation import break_lines_and_widen_to_max_line_count
from overturning.model.plane_weights import mask_of_azimuths_before_gap_and_grid_step

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe & Ito's palette, safe for colour blindness; the chosen colours also differ in lightness, for print in grey.
INK: Final = "#222222"
FALL_COLOUR: Final = "#c44a00"
STANDS_COLOUR: Final = "#e6e6e4"
HATCH_COLOUR: Final = "#a3a3a3"
PROBABILITY_COLOUR_STOPS: Final = (
    (0.0, "#ffffff"),
    (0.1, "#fadfc8"),
    (0.4, "#e8955a"),
    (0.7, "#c44a00"),
    (1.0, "#6e2300"),
)
"""Share of a ramp of probabilities, and its colour there; only 0 is white, grey is no probability."""

MISSING_COLOUR: Final = "#8a8a8a"
FAULT_COLOUR: Final = "#0072b2"
SERIES_COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")

DASHED_LINE_STYLE: Final[Any] = (0, (4, 2))
SERIES_LINE_STYLES: Final[tuple[Any, ...]] = (
    "-",
    (0, (5, 1.5)),
    (0, (1, 1.2)),
    (0, (5, 1, 1, 1)),
    (0, (3, 3)),
    (0, (8, 2)),
)
DPI: Final = 200
"""Dots per inch of a PNG, and of rasterised parts of an SVG or PDF."""

PAGE_WIDTH_INCHES: Final = 6.69
"""Usable width of a page of the report, inches; a wider figure would be scaled down together with its text."""

PHONE_FIGURE_WIDTH_INCHES: Final = 3.35
"""Width of a figure for a phone, inches: at 366 CSS pixels a letter of 7.5 pt is 11 pixels high."""

_FIRST_CJK_CODE_POINT: Final = 0x2E80
"""Number of the first Chinese or Japanese character."""

_PHONE_COMPASS_HEIGHT_INCHES: Final = 1.15 * PHONE_FIGURE_WIDTH_INCHES
"""Height of a compass with its title on a phone, inches."""

_IS_DRAWING_FOR_PHONE: Final = ContextVar("narrow", default=False)

# Leave out the date and the program's version: with them, files would not be reproducible.
REMOVED_FILE_METADATA: Final[dict[str, dict[str, Any]]] = {
    "svg": {"Date": None, "Creator": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}

MATPLOTLIB_SETTINGS: Final[Any] = {
    "font.family": ["DejaVu Sans", "sans-serif"],  # the first comes with Matplotlib, the second is the fallback in SVG
    "font.size": 9,
    "axes.titlesize": 10,
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color", "xtick.color", "ytick.color"), INK),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right"), False),
    "grid.color": "#c8c8c8",
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "figure.dpi": 100,
    "svg.hashsalt": "overturning",  # ids inside the file, otherwise random
    "svg.fonttype": "none",  # text stays text: searchable, and a fifth of the file size
}


@contextmanager
def arrange_panels_for_phone() -> Iterator[None]:
    """Context manager for phone figures: `create_panel_grid` puts panels below each other instead of side by side."""
    token = _IS_DRAWING_FOR_PHONE.set(True)
    try:
        yield
    finally:
        _IS_DRAWING_FOR_PHONE.reset(token)


def is_drawing_for_phone() -> bool:
    """True if figures are drawn for a phone: within a block of `arrange_panels_for_phone`."""
    return _IS_DRAWING_FOR_PHONE.get()


_MATPLOTLIB_SETTINGS_LOCK: Final = threading.RLock()
"""Lock of Matplotlib's settings while a thread draws with those of this package."""


@contextmanager
def use_package_matplotlib_settings() -> Iterator[None]:
    """Context manager that uses the Matplotlib settings of this package and restores those of the user afterwards.

    The settings are those of the process: another thread that enters the context waits until the first has left it.
    """
    import matplotlib as mpl

    _MATPLOTLIB_SETTINGS_LOCK.acquire()
    collects = gc.isenabled()
    gc.disable()  # a figure holds many live objects: garbage collection takes a fifth of the drawing time
    try:
        with mpl.rc_context():
            mpl.rcdefaults()  # a user's own settings must not change the files
            mpl.rcParams.update(MATPLOTLIB_SETTINGS)
            yield
    finally:
        if collects:
            gc.enable()
        _MATPLOTLIB_SETTINGS_LOCK.release()


def indices_and_values_of_minima_and_maxima(
    samples: FloatArray, samples_per_group: int
) -> tuple[NDArray[np.intp], FloatArray]:
    """Return, in order of time, indices and values of the minimum and maximum of each group of successive samples.

    A group has `samples_per_group` samples; the last group may have fewer.
    """
    padded = np.pad(samples, (0, -samples.size % samples_per_group), mode="edge").reshape(-1, samples_per_group)
    within = np.sort(np.stack([padded.argmin(axis=1), padded.argmax(axis=1)], axis=1), axis=1)
    places = (within + samples_per_group * np.arange(len(padded))[:, None]).ravel()
    return places, padded.ravel()[places]


def largest_round_number_up_to(upper_limit: float) -> float:
    """Return the largest round number (1, 2 or 5 times a power of ten) that is not above a positive limit."""
    power = 10.0 ** np.floor(np.log10(upper_limit) + 1e-10)
    return float(max(digit * power for digit in (1.0, 2.0, 5.0) if digit * power <= upper_limit * (1.0 + 1e-9)))


def format_at_least_three_significant_digits(value: float) -> str:
    """Format a number with three significant digits, or without decimals if its absolute value is 100 or more."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:z.3g}"


def compass_bearing_text(azimuth_deg: float) -> str:
    """Return an azimuth, degrees, as a bearing such as N60°E (60), S28°E (152) or N (0)."""
    azimuth = round(azimuth_deg % 360.0, 2) % 360.0
    if azimuth % 90.0 == 0.0:
        return "NESW"[int(azimuth // 90.0)]
    north, east = azimuth < 90.0 or azimuth > 270.0, azimuth < 180.0
    from_pole = min(azimuth, 360.0 - azimuth) if north else abs(azimuth - 180.0)
    return f"{'N' if north else 'S'}{round(from_pole, 2):g}°{'E' if east else 'W'}"


def create_figure(width_inches: float, height_inches: float, layout_engine: Any = "constrained") -> "Figure":
    """Return an empty figure of a given size, inches, which notebooks display without pyplot."""
    from io import BytesIO

    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    def render_figure_as_png() -> bytes:
        data = BytesIO()
        with use_package_matplotlib_settings():
            figure.savefig(data, format="png", metadata=REMOVED_FILE_METADATA["png"])
        return data.getvalue()

    figure = Figure(figsize=(width_inches, height_inches), layout=layout_engine)
    FigureCanvasAgg(figure)
    figure._repr_png_ = render_figure_as_png  # type: ignore[attr-defined]
    return figure


def create_panel_grid(
    row_count: int,
    column_count: int,
    width_inches: float,
    height_inches: float,
    visible_count: int | None = None,
    *,
    polar: Any = False,
    layout_engine: Any = "constrained",
    **more: Any,
) -> Any:
    """Return a figure of a given size, inches, and its panels as an array of shape (row_count, column_count).

    Only the first `visible_count` panels are visible, by default all. `polar` is True or a class of polar
    panels. Further keywords go to `matplotlib.figure.Figure.subplots`. Inside `arrange_panels_for_phone` all panels
    stand below each other.
    """
    kind = {"axes_class": polar} if isinstance(polar, type) else {"projection": "polar"} if polar else None
    if _IS_DRAWING_FOR_PHONE.get():
        count = row_count * column_count if visible_count is None else visible_count
        panel_height = (
            height_inches / row_count * (PHONE_FIGURE_WIDTH_INCHES * column_count / width_inches if polar else 1.0)
        )
        height = panel_height * count
        if polar:  # title, colour bar and legend of a figure of several maps are there only once
            besides = max(0.0, height_inches - row_count * width_inches / column_count)
            height = min(height, _PHONE_COMPASS_HEIGHT_INCHES * count + besides)
        figure = create_figure(PHONE_FIGURE_WIDTH_INCHES, height + 0.3, layout_engine)
        more = {name: value for name, value in more.items() if name != "width_ratios"}
        column = figure.subplots(count, 1, subplot_kw=kind, squeeze=False, **more).ravel()
        panels = np.full(row_count * column_count, None)
        panels[:count] = column
        return figure, panels.reshape(row_count, column_count)
    figure = create_figure(width_inches, height_inches, layout_engine)
    return figure, add_panel_grid(figure, row_count, column_count, visible_count, subplot_kw=kind, **more)


def add_panel_grid(
    figure: "Figure", row_count: int, column_count: int, visible_count: int | None = None, **more: Any
) -> Any:
    """Add panels to a figure in rows and columns, also on a phone; return them, shape (row_count, column_count).

    Only the first `visible_count` panels are visible, by default all. Further keywords go to
    `matplotlib.figure.Figure.subplots`.
    """
    panels = figure.subplots(row_count, column_count, squeeze=False, **more)
    for axes in panels.flat[visible_count:] if visible_count is not None else ():
        axes.set_visible(False)
    return panels


def wrap_name_into_lines(text: str, max_letters_per_line: int) -> list[str]:
    """Break a text, such as the name of a place, into lines of at most `max_letters_per_line` Latin letters.

    Chinese and Japanese characters, between which there are no spaces, are about twice as wide.
    """
    if all(ord(character) < _FIRST_CJK_CODE_POINT for character in text):
        return wrap(text, max_letters_per_line) or [""]
    return break_lines_and_widen_to_max_line_count([text], 0.45 * max_letters_per_line, max_line_count=len(text))


def add_title_and_legend(
    figure: "Figure",
    title: str,
    labelled_panel: Any = None,
    legend_column_count: int = 1,
    legend_handles_before_panel_marks: Sequence[Any] = (),
    last_legend_handles: Sequence[Any] = (),
) -> None:
    """Put a title above a figure and a legend below.

    The legend has, in this order, `legend_handles_before_panel_marks`, all labelled lines and symbols of
    `labelled_panel`, and `last_legend_handles`.
    """
    marks = [
        *legend_handles_before_panel_marks,
        *(labelled_panel.get_legend_handles_labels()[0] if labelled_panel is not None else ()),
        *last_legend_handles,
    ]
    if marks:
        columns = 1 if _IS_DRAWING_FOR_PHONE.get() else legend_column_count
        figure.legend(handles=marks, loc="outside lower center", ncols=columns, fontsize=8)
    if title:
        max_letters = int(13 * figure.get_figwidth())  # about 13 characters of this size fit in an inch
        lines = [part for line in title.splitlines() for part in wrap_name_into_lines(line, max_letters)]
        figure.suptitle("\n".join(lines), fontsize=10, parse_math=False)


def legend_patch(colour_or_style: Any, label: str) -> Any:
    """Return a filled legend rectangle with a label, given its colour or Matplotlib keywords such as a hatch."""
    from matplotlib.patches import Patch

    filled = {"facecolor": colour_or_style, "edgecolor": "#777777"}
    own = colour_or_style if isinstance(colour_or_style, dict) else filled
    return Patch(label=label, **({"linewidth": 0.4} | own))


def label_axes(axes: Any, x_label: str, y_label: str, ticks_with_small_labels: str = "major") -> None:
    """Label the axes of a panel, and make the labels of its major ticks, minor ticks or both small."""
    axes.set_xlabel(x_label, fontsize=8)
    axes.set_ylabel(y_label, fontsize=8)
    axes.tick_params(labelsize=8, which=ticks_with_small_labels)


def write_note_in_empty_panel(axes: Any, note: str) -> None:
    """Write a note in the middle of a panel in which nothing is drawn, and leave out its ticks."""
    axes.text(0.5, 0.5, note, transform=axes.transAxes, ha="center", va="center", fontsize=8, color=MISSING_COLOUR)
    axes.set(xticks=[], yticks=[])


def set_logarithmic_ticks(axis: Any) -> None:
    """Set ticks of a logarithmic axis at 1, 2 and 5 times powers of ten, formatted without exponents.

    An axis with fewer than two of these between its limits has them at 1, 1.5, 2, 3, 4, 5, 6 and 8 times powers of ten.
    """
    from matplotlib.ticker import LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    few = np.outer(10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1), (1, 2, 5))
    enough = np.count_nonzero((few >= low) & (few <= high)) >= 2
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if enough else (1, 1.5, 2, 3, 4, 5, 6, 8)))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_formatter(NullFormatter())


def label_logarithmic_ticks(axis: Any) -> None:
    """Label the ticks of a logarithmic axis as 0.1, 1, 10; as powers of ten if the axis goes beyond 0.0001 or 100 000.

    The labels replace those of Matplotlib, which are formulas and slow to draw.
    """

    def format_tick(tick_position: float, _: int | None = None) -> str:
        """Format a tick value as decimal number, or as power of ten on an axis with a very wide range."""
        low, high = axis.get_view_interval()
        if low > 1e-4 and high < 1e5:
            return f"{tick_position:g}"
        return f"$\\mathdefault{{10^{{{np.log10(tick_position):.3g}}}}}$"

    axis.set_major_formatter(format_tick)


def draw_line_through_origin(axes: Any, azimuth_deg: float, half_length: float, **look: Any) -> None:
    """Draw a line through the point (0, 0) of a map along an azimuth, `half_length` (map units) to each side."""
    east, north = half_length * np.sin(np.radians(azimuth_deg)), half_length * np.cos(np.radians(azimuth_deg))
    axes.plot([-east, east], [-north, north], color=FAULT_COLOUR, **look)


def turn_axes_into_compass(
    axes: Any,
    direction_names: Sequence[str] = ("N", "NE", "E", "SE", "S", "SW", "W", "NW"),
    name_distance_pt: float = 0,
) -> None:
    """Make a polar axis a compass: north at the top, angles clockwise, with eight named directions."""
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.tick_params(axis="x", pad=name_distance_pt)  # cheaper before the eight ticks exist
    axes.set_xticks(np.radians(np.arange(0, 360, 45)), direction_names)
    axes.spines["polar"].set_linewidth(0.6)


AZIMUTH_SECTOR_WIDTH_OF_SINGLE_PLANE_DEG: Final = 5.0
"""Width of the sector of an azimuth, degrees, if a single plane was simulated, so that the grid has no step."""


def gap_azimuths_one_step_from_simulated_ones(simulated_azimuths_deg: FloatArray) -> FloatArray:
    """Return the azimuths, degrees, one grid step inside both ends of each range of azimuths without simulations.

    For a single plane (one azimuth, or two opposite ones) the step is `AZIMUTH_SECTOR_WIDTH_OF_SINGLE_PLANE_DEG`.
    """
    azimuth: FloatArray = np.unique(np.round(np.asarray(simulated_azimuths_deg, dtype=np.float64), 6))
    if np.unique(azimuth % 180.0).size == 1:
        around = [
            azimuth - AZIMUTH_SECTOR_WIDTH_OF_SINGLE_PLANE_DEG,
            azimuth + AZIMUTH_SECTOR_WIDTH_OF_SINGLE_PLANE_DEG,
        ]
        return np.asarray(np.round(np.concatenate(around) % 360.0, 10))
    not_computed, step = mask_of_azimuths_before_gap_and_grid_step(azimuth, 360.0)
    begins, ends = azimuth[not_computed], np.roll(azimuth, -1)[not_computed]
    return np.round(np.concatenate([begins + step, ends - step]) % 360.0, 10)


def set_outer_radius_and_radius_ticks(
    axes: Any, compass_rim_radius: float, tick_labels: dict[float, str] | None = None, **look: Any
) -> None:
    """Set outer radius and radius ticks of a polar axis; its small tick labels are placed along the azimuth 112.5°."""
    axes.set_ylim(0.0, compass_rim_radius)
    if tick_labels is not None:
        axes.set_yticks(list(tick_labels), list(tick_labels.values()))
    axes.set_rlabel_position(112.5)
    axes.tick_params(axis="y", labelsize=8, **look)
    for label in axes.get_yticklabels():  # legible on any background
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85})


def mark_fault_normal_on_polar_rim(axes: Any, fault_normal_deg: float, label: str | None = "fault normal") -> None:
    """Mark the azimuth of the fault normal at both ends on the rim of a polar axis; do nothing if it is NaN."""
    if not np.isfinite(fault_normal_deg):
        return
    radius, (angle, opposite) = axes.get_ylim()[1], np.radians([fault_normal_deg, fault_normal_deg + 180.0])
    if axes.xaxis.get_visible():
        axes.tick_params(axis="x", pad=max(4.0, axes.xaxis.get_tick_params().get("pad", 0.0)))
    ends = [0.93 * radius, 1.03 * radius]  # the rim covers neither the data nor the names of directions
    axes.plot(
        [angle, angle, np.nan, opposite, opposite], [*ends, np.nan, *ends],
        color=FAULT_COLOUR, linewidth=2.6, label=label, zorder=5, clip_on=False,
    )  # fmt: skip
    axes.set_ylim(0.0, radius)


def mark_direction_away_from_epicentre_on_polar_rim(axes: Any, away_azimuth_deg: float) -> None:
    """Mark the azimuth away from the epicentre by an arrowhead on the rim of a polar axis; do nothing if NaN."""
    if not np.isfinite(away_azimuth_deg):
        return
    radius = axes.get_ylim()[1]
    axes.plot(
        np.radians(away_azimuth_deg), radius, marker=(3, 0, -away_azimuth_deg), markersize=10, markeredgecolor="white",
        color=SERIES_COLOURS[2], linestyle="none", label="away from the epicentre", zorder=6, clip_on=False,
    )  # fmt: skip
    axes.set_ylim(0.0, radius)
