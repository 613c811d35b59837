"""One look for all figures, and files that are the same bytes each time."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from overturning.figures.svg import compact
from overturning.files import atomic_write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe & Ito's palette: told apart by the colour-blind; the chosen ones differ in lightness too, so in grey as well.
INK: Final = "#222222"
FALLS: Final = "#c44a00"
FALLS_OPPOSITE: Final = "#f6c9a0"
STANDS: Final = "#f4f4f2"
MISSING: Final = "#8a8a8a"
FAULT: Final = "#0072b2"
SERIES: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")

DASHES: Final[tuple[Any, ...]] = ("-", (0, (5, 1.5)), (0, (1, 1.2)), (0, (5, 1, 1, 1)), (0, (3, 3)), (0, (8, 2)))
# Rasterised cells inside an SVG need no more; a PNG is looked at closer.
_DPI: Final = {"svg": 110, "png": 200}
_SMALL_DPI: Final = 115

_SETTINGS: Final[Any] = {
    "font.family": ["DejaVu Sans", "sans-serif"],  # comes with Matplotlib; a page without it takes the next
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "grid.color": "#c8c8c8",
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "figure.dpi": 100,
    "svg.hashsalt": "overturning",  # ids inside the file, otherwise random
    "svg.fonttype": "none",  # text stays text: a fifth of the size, and it can be searched
}


@contextmanager
def style() -> Iterator[None]:
    """Draw with the project's settings, without a display."""
    import matplotlib as mpl

    mpl.use("Agg")
    with mpl.rc_context():
        mpl.rcdefaults()  # a user's own settings must not change the bytes
        mpl.rcParams.update(_SETTINGS)
        yield


def save(figure: "Figure", path: Path, colours: int = 0) -> None:
    """Write a figure as SVG or PNG, the same bytes each time, and close it.

    Parameters
    ----------
    figure : matplotlib Figure
        The figure.
    path : Path
        File ending in .svg or .png.
    colours : int
        Colours of the palette of a small .png; 0 for all of them.
    """
    import matplotlib.pyplot as plt

    _lay_out_once(figure)
    kind = path.suffix.removeprefix(".")
    # No date and no version of the program that drew it: both would change bytes that nobody sees.
    metadata: dict[str, Any] = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
    with atomic_write(path) as part:
        if kind == "png" and colours:
            _save_small(figure, part, colours)
        else:
            figure.savefig(part, format=kind, metadata=metadata, dpi=_DPI[kind])
        if kind == "svg":
            part.write_text(compact(part.read_text(encoding="utf-8")), encoding="utf-8")
    plt.close(figure)


def _lay_out_once(figure: "Figure") -> None:
    """Spare the drawing that Matplotlib makes, and throws away, only for the layout that comes with it."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    draw = figure.draw

    def draw_or_lay_out(renderer: Any) -> None:
        engine = figure.get_layout_engine()
        if isinstance(engine, ConstrainedLayoutEngine):  # no longer where the picture itself is drawn
            engine.execute(figure)
        else:
            draw(renderer)

    figure.draw = draw_or_lay_out  # type: ignore[method-assign]


def _save_small(figure: "Figure", path: Path, colours: int) -> None:
    """A picture with a palette: a third of the bytes, for pages that show dozens."""
    import io

    from PIL import Image

    picture = io.BytesIO()
    figure.savefig(picture, format="png", metadata={"Software": None}, dpi=_SMALL_DPI)
    with Image.open(picture) as full:
        full.convert("RGB").quantize(colours, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(
            path, format="PNG", optimize=True
        )


def short(value: float) -> str:
    """A number as a title shows it: three digits, whole from 100 on, never with an exponent of ten up to a million."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def probability_colours() -> Any:
    """Colours of a probability from 0 (paper) to 1 (the colour of falls, then darker): lightness falls all the way."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("probability", [STANDS, "#f6c9a0", "#e58a4b", FALLS, "#6e2300"])


def caption(figure: "Figure", title: str, of: Any = None, columns: int = 1) -> None:
    """Put a title above a figure and below it the legend of one of its panels, where that has anything to tell."""
    lines, names = of.get_legend_handles_labels() if of is not None else ([], [])
    if lines:
        figure.legend(lines, names, loc="outside lower center", ncols=columns, fontsize=8)
    if title:
        figure.suptitle(title, fontsize=10, parse_math=False)


def labels(axes: Any, across: str, up: str, which: str = "major") -> None:
    """Name both axes of a panel, in small letters."""
    axes.set_xlabel(across, fontsize=8)
    axes.set_ylabel(up, fontsize=8)
    axes.tick_params(labelsize=7, which=which)


def radius_labels(axes: Any, **settings: Any) -> None:
    """Small numbers along the radius of a compass, between two of its named directions."""
    axes.set_rlabel_position(112.5)
    axes.tick_params(axis="y", labelsize=7, **settings)


def compass(axes: Any) -> None:
    """Turn a polar axes into a compass: north up, clockwise, eight directions named."""
    import numpy as np

    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_xticks(np.radians(np.arange(0, 360, 45)), ["N", "NE", "E", "SE", "S", "SW", "W", "NW"])
    axes.tick_params(axis="x", pad=0)
    axes.spines["polar"].set_linewidth(0.6)


def mark_fault_normal(axes: Any, fault_normal_deg: float, radius: float, label: bool = True) -> None:
    """Mark both ends of the fault normal on a compass with a dashed line.

    Parameters
    ----------
    axes : polar Axes
        A compass.
    fault_normal_deg : float
        Azimuth of the fault normal, degrees; nothing is drawn where it is NaN.
    radius : float
        Length of the line in data units.
    label : bool
        Whether the line appears in the legend.
    """
    import numpy as np

    if not np.isfinite(fault_normal_deg):
        return
    angles = np.radians([fault_normal_deg, fault_normal_deg + 180.0])
    axes.plot(
        [angles[0], angles[0], angles[1]],
        [radius, 0.0, radius],
        color=FAULT,
        linewidth=1.4,
        linestyle=(0, (4, 2)),
        label="fault normal" if label else None,
        zorder=5,
    )
