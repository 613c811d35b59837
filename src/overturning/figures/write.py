"""Reproducible figure files in the size and formats of a study, and folders of figures."""

import re
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from overturning.errors import ArgumentError
from overturning.figures.style import DPI, MATPLOTLIB_SETTINGS, REMOVED_FILE_METADATA, use_package_matplotlib_settings
from overturning.figures.svg import compact_svg
from overturning.figures.svg_translation import translate_svg
from overturning.files import atomic_write, write_text
from overturning.quantities import parse_quantity
from overturning.study.evaluation import FIGURE_FILE_FORMATS, FigureSettings
from overturning.translation.texts import ENGLISH, check_font_is_installed, current_language, font_language_of_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

TITLE_TEXT_THAT_REMOVES_TITLE: Final = "none"
"""Title of a figure that is to have none."""


def save_figure_files(
    figure: "Figure",
    *paths: Path,
    dpi: float = DPI,
    width_inches: float | None = None,
    font_size_pt: float | None = None,
) -> None:
    """Write a figure to one or more files (.svg, .png or .pdf), byte for byte equal each time.

    Parameters
    ----------
    figure : Figure
        The figure.
    *paths : Path
        Files with the extension .svg, .png or .pdf.
    dpi : float
        Dots per inch of raster images.
    width_inches : float, optional
        Width of the file, inches; the proportions stay the same.
    font_size_pt : float, optional
        Size of the main font in the file, pt; the panels then fill the remaining space. If not given, the text is
        scaled with the figure.

    Raises
    ------
    MissingDataError
        If a PNG or PDF needs a font that is not installed: for the current language, or for Japanese names.
    """
    from overturning.figures.ticks import limit_ticks_to_axis_range

    own = MATPLOTLIB_SETTINGS["font.size"]
    scale = font_size_pt / own if font_size_pt else (width_inches or figure.get_figwidth()) / figure.get_figwidth()
    if (wide := (width_inches or figure.get_figwidth()) / scale) != figure.get_figwidth():
        figure.set_size_inches(wide, wide * figure.get_figheight() / figure.get_figwidth())
    compute_layout_at_first_drawing_or_on_request(figure)
    limit_ticks_to_axis_range(figure)
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        if not axis.get_label_text():  # else Matplotlib would measure all ticks to place an empty label
            axis.set_label_coords(0.5, 0.0)
    for path in paths:
        kind = path.suffix.removeprefix(".")
        if kind != "svg":
            check_font_is_installed(current_language(), path.name)
        with atomic_write(path) as part:
            if kind != "svg" and ((scale != 1.0 and kind == "pdf") or current_language() != ENGLISH):
                _save_figure_by_typst(figure, part, kind, scale, dpi)
                continue
            with _collect_characters_without_glyph() as missing:
                figure.savefig(part, format=kind, metadata=REMOVED_FILE_METADATA[kind], dpi=dpi * scale)
            if missing and kind != "svg":  # an SVG is drawn with the fonts of its viewer
                check_font_is_installed(font_language_of_text("".join(missing)), path.name)
                _save_figure_by_typst(figure, part, kind, scale, dpi, "".join(missing))
            if kind == "svg":
                text = translate_svg(compact_svg(part.read_text(encoding="utf-8")))
                if scale != 1.0:  # change the size of the page; the coordinates inside stay the same
                    size = r'(?<==")([\d.]+)(?=pt")'
                    text = re.sub(size, lambda one: f"{scale * float(one[0]):.2f}", text, count=2)
                part.write_text(text, encoding="utf-8")


@contextmanager
def _collect_characters_without_glyph() -> Iterator[list[str]]:
    """Context manager: yield a list, later filled with the characters missing in Matplotlib's font; no warnings."""
    missing: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.filterwarnings("always", message=_MISSING_GLYPH_WARNING_PATTERN)
        yield missing
    for one in caught:
        if found := re.match(_MISSING_GLYPH_WARNING_PATTERN, str(one.message)):
            missing.append(chr(int(found[1])))
        else:
            warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)


_MISSING_GLYPH_WARNING_PATTERN: Final = r"Glyph (\d+) "


def _save_figure_by_typst(
    figure: "Figure",
    path: Path,
    pdf_or_png: str,
    enlargement_factor: float,
    dpi: float,
    characters_needing_system_font: str = "",
) -> None:
    """Write a figure as PDF or PNG, enlarged by `enlargement_factor`, by converting its SVG with the program typst.

    `characters_needing_system_font` are characters, as in the name of a place, that only a font of the system has.
    """
    import matplotlib
    import matplotlib.font_manager
    import typst

    translated = current_language() != ENGLISH
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        drawing = folder / "figure.svg"
        with _collect_characters_without_glyph():
            figure.savefig(drawing, format="svg", metadata=REMOVED_FILE_METADATA["svg"], dpi=dpi * enlargement_factor)
        if translated:
            drawing.write_text(translate_svg(drawing.read_text(encoding="utf-8")), encoding="utf-8")
        wide, high = (72.0 * enlargement_factor * inches for inches in figure.get_size_inches())
        page = f"#set page(width: {wide:.3f}pt, height: {high:.3f}pt, margin: 0pt)\n"
        (folder / "page.typ").write_text(page + '#image("figure.svg", width: 100%)\n', encoding="utf-8")
        families = [one for one in matplotlib.rcParams["font.family"] if one != "sans-serif"]
        fonts = sorted({Path(matplotlib.font_manager.findfont(one)).parent for one in families})
        options: dict[str, Any] = {"format": pdf_or_png, "ppi": dpi} if pdf_or_png == "png" else {"format": pdf_or_png}
        path.write_bytes(
            typst.compile(
                folder / "page.typ",
                root=folder,
                ignore_system_fonts=not (translated or characters_needing_system_font),
                font_paths=list(fonts),
                timestamp=0,
                **options,
            )
        )


def remove_layout_engine_and_check_if_text_cut_or_overlaps(figure: "Figure") -> bool:
    """Remove the layout engine of a figure; return True if a title or legend is cut off at the edge, or texts overlap.

    Without the engine, the panels of the figure keep their positions.
    """
    figure.set_layout_engine("none")
    with _collect_characters_without_glyph():
        figure.draw_without_rendering()  # Matplotlib keeps the places of labels in pixels of the file written last
    renderer, whole = figure.canvas.get_renderer(), figure.bbox.padded(2.0)  # type: ignore[attr-defined]
    shown = [axes for axes in figure.axes if axes.get_visible()]
    titles = [one.get_window_extent(renderer).padded(-1.0) for one in (axes.title for axes in shown) if one.get_text()]
    outer = [one.get_window_extent(renderer) for one in figure.texts if _is_visible_non_empty_text(one)]
    outer += [
        one.get_window_extent(renderer).padded(-2.0 * _TEXT_BOX_MARGIN_PX) for one in figure.legends
    ]  # a legend has margins
    if any(not whole.contains(*corner) for box in (*titles, *outer) for corner in (box.min, box.max)):
        return True
    inner = [
        one.get_window_extent(renderer) for axes in shown for one in _visible_horizontal_or_vertical_panel_texts(axes)
    ]
    boxes = [box.padded(-_TEXT_BOX_MARGIN_PX) for box in (*titles, *outer, *inner)]
    return any(one.overlaps(other) for place, one in enumerate(boxes) for other in boxes[:place])


_TEXT_BOX_MARGIN_PX: Final = 3.0
"""Margin of the box of a text, pixels: boxes that only touch do not overlap."""


def _is_visible_non_empty_text(text: "Text") -> bool:
    """True if a text is visible and has letters."""
    return bool(text.get_visible() and text.get_text())


def _visible_horizontal_or_vertical_panel_texts(axes: Any) -> "list[Text]":
    """Return the visible texts of a panel that are horizontal or vertical: axis labels, tick labels and notes."""
    found = [one for one in (axes.xaxis.label, axes.yaxis.label, *axes.texts) if one.get_rotation() % 90.0 == 0.0]
    for along, axis in enumerate((axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        room = 1e-6 * (high - low)
        labels = axis.get_majorticklabels() if axis.get_visible() else ()
        found += [one for one in labels if low - room <= one.get_position()[along] <= high + room]
    return [one for one in found if _is_visible_non_empty_text(one)]


def set_figure_title(figure: "Figure", title: str | None) -> None:
    """Replace the title of a figure; "none" removes the title, and None leaves it unchanged."""
    if title is not None and (title != TITLE_TEXT_THAT_REMOVES_TITLE or figure.get_suptitle()):
        text = figure.suptitle("" if title == TITLE_TEXT_THAT_REMOVES_TITLE else title, parse_math=False)
        text.set_in_layout(title != TITLE_TEXT_THAT_REMOVES_TITLE)


def parse_font_family_and_size(font_text: str) -> tuple[str | None, float | None]:
    """Parse a font such as ``8``, ``Liberation Serif`` or ``Liberation Serif 8`` into its family and size, pt.

    The family can also be a font file (.ttf or .otf). None stands for the figure's own family or size.
    """
    from matplotlib import font_manager

    family, _, last = font_text.strip().rpartition(" ")
    try:
        size: float | None = float(last)
    except ValueError:
        family, size = font_text.strip(), None
    if size is not None and not 1.0 <= size <= 72.0:
        raise ArgumentError(f"--font {font_text!r}: {size:g} pt; it must be 1 to 72 pt")
    if family.endswith((".ttf", ".otf")) and Path(family).is_file():
        font_manager.fontManager.addfont(family)
        family = font_manager.FontProperties(fname=family).get_name()
    if family:
        try:
            font_manager.findfont(family, fallback_to_default=False)
        except ValueError:
            raise ArgumentError(
                f"--font {font_text!r}: no font {family!r} is installed; name a font file (.ttf)"
            ) from None
    return family or None, size


_CUT_OR_OVERLAPPING_TEXT_REMEDY: Final = (
    "choose a larger --width, a smaller --font, or fewer panels by --height and --friction"
)


def parse_figure_width_inches(width_text: str) -> float | None:
    """Convert a width such as ``80mm`` to inches; return None for an empty text."""
    try:
        metres = parse_quantity(width_text, "m") if width_text else None
    except ValueError as problem:
        raise ArgumentError(f"--width {width_text!r}: {problem}") from None
    if metres is not None and not 0.02 <= metres <= 2.0:
        raise ArgumentError(f"--width {width_text!r}: {metres:g} m; it must be 0.02 to 2 m, 80mm")
    return None if metres is None else metres / 0.0254


def save_figure_and_return_text_layout_warning(
    figure: "Figure",
    path: Path,
    *,
    dpi: float,
    width_inches: float | None,
    requested_font_family_or_size_text: str = "",
) -> str:
    """Write a figure to a file, and return a warning if texts are cut off or overlap; "" if there is no problem.

    `requested_font_family_or_size_text` is a size, a family or both; see `parse_font_family_and_size`. An
    `ArgumentError` is raised if the font is not installed, or if the text leaves no room for the panels.
    """
    import matplotlib as mpl
    from matplotlib.text import Text

    family, size = (
        parse_font_family_and_size(requested_font_family_or_size_text)
        if requested_font_family_or_size_text
        else (None, None)
    )
    with use_package_matplotlib_settings(), warnings.catch_warnings():
        warnings.filterwarnings("error", "constrained_layout not applied")
        if family:  # ticks that are made while drawing have the family of the settings
            mpl.rcParams["font.family"] = [family, *MATPLOTLIB_SETTINGS["font.family"]]
            for text in figure.findobj(Text):
                text.set_fontfamily(mpl.rcParams["font.family"])
        try:
            save_figure_files(figure, path, dpi=dpi, width_inches=width_inches, font_size_pt=size)
        except UserWarning:
            raise ArgumentError(
                f"{path.name}: the text leaves no room for the panels; {_CUT_OR_OVERLAPPING_TEXT_REMEDY}"
            ) from None
    return (
        f"text is cut off or overlaps; {_CUT_OR_OVERLAPPING_TEXT_REMEDY}"
        if remove_layout_engine_and_check_if_text_cut_or_overlaps(figure)
        else ""
    )


FigureWriterInAllFormats = Callable[["Figure", Path], None]
"""Function that writes a figure to a path without extension, in all formats of a study."""


def write_figure_and_delete_files_in_other_formats(
    figure_settings: FigureSettings, figure: "Figure", path_without_suffix: Path
) -> None:
    """Write a figure with the size, resolution and file formats that a study sets; delete files in other formats.

    `path_without_suffix` is the path without extension.
    """
    figure.set_size_inches(*(figure_settings.size * figure.get_size_inches()))
    for kind in set(FIGURE_FILE_FORMATS) - set(figure_settings.formats):
        path_without_suffix.with_name(f"{path_without_suffix.name}.{kind}").unlink(missing_ok=True)
    save_figure_files(
        figure,
        *(path_without_suffix.with_name(f"{path_without_suffix.name}.{kind}") for kind in figure_settings.formats),
        dpi=figure_settings.dpi,
    )


@contextmanager
def empty_folder_then_write_list_of_new_files(folder: Path) -> Iterator[None]:
    """Context manager: empty a folder, then write a text file with the names of all files made in the folder.

    The text file lies next to the folder, such as ``maps.txt`` for ``maps/``. It is read by
    `overturning.study.resume.remove_damaged_results_and_fix_future_times`, since the number of files is not known in
    advance. The folder is emptied so that files of an earlier study are not taken for those of this one.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    yield
    names = sorted(path.relative_to(folder.parent).as_posix() for path in folder.iterdir())
    write_text(folder.with_suffix(".txt"), "".join(f"{name}\n" for name in names))


def compute_layout_at_first_drawing_or_on_request(figure: "Figure") -> Callable[[], None]:
    """Make a figure compute its layout only at its first drawing and on request; return a function for requests."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    draw, due = figure.draw, [True]

    def compute_layout_if_due_instead_of_drawing(renderer: Any) -> None:
        """Compute the layout of the figure, without drawing, at the first call and at the next call after a request.

        If Matplotlib has removed the layout engine, draw the figure instead.
        """
        engine = figure.get_layout_engine()
        if not isinstance(engine, ConstrainedLayoutEngine):  # Matplotlib has removed it: the final drawing
            draw(renderer)
        elif due[0]:  # only once for all files of a figure
            due[0] = False
            engine.execute(figure)

    def request_layout_at_next_drawing() -> None:
        """Request that the layout of the figure is computed again at its next drawing."""
        due[0] = True

    figure.draw = compute_layout_if_due_instead_of_drawing  # type: ignore[method-assign]
    return request_layout_at_next_drawing
