"""One look for all figures, and files that are the same bytes each time."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

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

DASHED: Final[Any] = (0, (4, 2))
DASHES: Final[tuple[Any, ...]] = ("-", (0, (5, 1.5)), (0, (1, 1.2)), (0, (5, 1, 1, 1)), (0, (3, 3)), (0, (8, 2)))
# Rasterised cells inside an SVG need no more; a PNG is looked at closer.
_DPI: Final = {"svg": 110, "png": 200}
_SMALL_DPI: Final = 115

_SETTINGS: Final[Any] = {
    "font.family": ["DejaVu Sans", "sans-serif"],  # comes with Matplotlib; a page without it takes the next
    "font.size": 9,
    "axes.titlesize": 10,
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color", "xtick.color", "ytick.color"), INK),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right"), False),
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
    """Write a figure to a .svg or .png file, a small .png with so many ``colours``, and close it.

    It is the same bytes each time.
    """
    import matplotlib.pyplot as plt
    from PIL import Image

    _lay_out_once(figure)
    kind = path.suffix.removeprefix(".")
    # No date and no version of the program that drew it: both would change bytes that nobody sees.
    metadata: dict[str, Any] = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
    with atomic_write(path) as part:
        figure.savefig(part, format=kind, metadata=metadata, dpi=_SMALL_DPI if colours else _DPI[kind])
        if kind == "svg":
            part.write_text(compact(part.read_text(encoding="utf-8")), encoding="utf-8")
        elif colours:  # a third of the bytes, for pages that show dozens
            with Image.open(part) as full:
                small = full.convert("RGB").quantize(colours, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
            small.save(part, format="PNG", optimize=True)
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


def short(value: float) -> str:
    """A number as a title shows it: three digits, whole from 100 on, never with an exponent of ten up to a million."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def grid(rows: int, columns: int, width: float, height: float, polar: bool = False, layout: Any = "constrained") -> Any:
    """A figure of that size, inches, and its panels, an array of shape (rows, columns)."""
    import matplotlib.pyplot as plt

    kind = {"projection": "polar"} if polar else None
    return plt.subplots(rows, columns, figsize=(width, height), subplot_kw=kind, squeeze=False, layout=layout)


def caption(
    figure: "Figure", title: str, of: Any = None, columns: int = 1, first: Sequence[Any] = (), last: Sequence[Any] = ()
) -> None:
    """Put a title above a figure and below it the legend of one of its panels, other marks before and after its own."""
    lines = [*first, *(of.get_legend_handles_labels()[0] if of is not None else ()), *last]
    if lines:
        figure.legend(handles=lines, loc="outside lower center", ncols=columns, fontsize=8)
    if title:
        figure.suptitle(title, fontsize=10, parse_math=False)


def labels(axes: Any, across: str, up: str, which: str = "major") -> None:
    """Name both axes of a panel, in small letters."""
    axes.set_xlabel(across, fontsize=8)
    axes.set_ylabel(up, fontsize=8)
    axes.tick_params(labelsize=7, which=which)


def line_through_origin(axes: Any, azimuth_deg: float, half: float, **look: Any) -> None:
    """Draw a line along an azimuth on a plan, east to the right and north up, so far to either side of the origin."""
    east, north = half * np.sin(np.radians(azimuth_deg)), half * np.cos(np.radians(azimuth_deg))
    axes.plot([-east, east], [-north, north], color=FAULT, **look)


def compass(axes: Any, names: Sequence[str] = ("N", "NE", "E", "SE", "S", "SW", "W", "NW"), pad: float = 0) -> None:
    """Turn a polar axes into a compass: north up, clockwise, eight directions named."""
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_xticks(np.radians(np.arange(0, 360, 45)), names)
    axes.tick_params(axis="x", pad=pad)
    axes.spines["polar"].set_linewidth(0.6)


def radius_ticks(axes: Any, top: float, ticks: dict[float, str] | None = None, **look: Any) -> None:
    """End a compass at a radius and put small numbers along it, between two of its named directions."""
    axes.set_ylim(0.0, top)
    if ticks is not None:
        axes.set_yticks(list(ticks), list(ticks.values()))
    axes.set_rlabel_position(112.5)
    axes.tick_params(axis="y", labelsize=7, **look)


def slenderness_ticks(axes: Any, top: float, otherwise: float) -> None:
    """Ticks of B/H on a compass that ends at ``top``; one tick ``otherwise`` where no round number lies below that."""
    ticks = [tick for tick in (0.2, 0.4, 0.6, 0.8, 1.0) if tick < top] or [round(otherwise, 2)]
    radius_ticks(axes, top, {tick: f"{tick:g}" for tick in ticks})


def mark_fault_normal(axes: Any, fault_normal_deg: float, label: str | None = "fault normal") -> None:
    """Mark both ends of the fault normal on a compass with a dashed line; nothing where its azimuth is NaN."""
    if not np.isfinite(fault_normal_deg):
        return
    angles, radius = np.radians([fault_normal_deg, fault_normal_deg + 180.0]), axes.get_ylim()[1]
    axes.plot(
        [angles[0], angles[0], angles[1]], [radius, 0.0, radius],
        color=FAULT, linewidth=1.4, linestyle=DASHED, label=label, zorder=5,
    )  # fmt: skip
