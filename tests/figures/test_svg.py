"""A compact SVG has the same texts, pixels and tick positions."""

import base64
import io
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from overturning.figures.style import (
    DPI,
    add_title_and_legend,
    create_panel_grid,
    label_axes,
    turn_axes_into_compass,
    use_package_matplotlib_settings,
)
from overturning.figures.svg import compact_svg
from overturning.figures.write import save_figure_files


def draw_two_panels_as_svg(path: Path, reduce_file_size: bool) -> str:
    """Draw two panels with logarithmic ticks, markers, raster image and formulas; return the SVG as text."""
    import matplotlib.pyplot as plt

    random = np.random.Generator(np.random.PCG64(1))
    with use_package_matplotlib_settings():
        figure, axes = plt.subplots(1, 2)
        axes[0].loglog([1, 10, 1e4], [1e-3, 1, 1e3], marker="o", label="a < b & c")
        axes[1].scatter(*random.random((2, 50)), c=["#ff0000", "#00ff00"] * 25, linewidths=0, antialiaseds=False,
        rasterized=True)  # fmt: skip
        axes[1].set_title("µ · H/B")
        axes[0].legend()
        if reduce_file_size:
            save_figure_files(figure, path)
        else:
            figure.savefig(path, dpi=DPI)
            plt.close(figure)
    return path.read_text(encoding="utf-8")


def svg_text(svg: str) -> str:
    """Return all texts of an SVG."""
    return "".join(re.findall(r">([^<>\n]+)</t", svg))


def pixels_of_png_embedded_in_svg(svg: str) -> np.ndarray:
    """Return the pixels of the raster image in an SVG."""
    (data,) = re.findall(r"data:image/png;base64,([^\"]*)", svg)
    with Image.open(io.BytesIO(base64.b64decode(data))) as picture:
        return np.asarray(picture.convert("RGBA"))


def test_compact_svg_looks_the_same(tmp_path: Path) -> None:
    large, small = (
        draw_two_panels_as_svg(tmp_path / "large.svg", reduce_file_size=False),
        draw_two_panels_as_svg(tmp_path / "small.svg", reduce_file_size=True),
    )
    assert len(small) < 0.9 * len(large)
    assert svg_text(small) == svg_text(large)
    assert "µ · H/B" in svg_text(small)
    np.testing.assert_array_equal(pixels_of_png_embedded_in_svg(small), pixels_of_png_embedded_in_svg(large))
    named = set(re.findall(r'id="([^"]+)"', small))
    assert set(re.findall(r'(?:href="#|url\(#)([^")]+)', small)) <= named, "what is referred to is there"
    assert small == draw_two_panels_as_svg(tmp_path / "again.svg", reduce_file_size=True)


def test_compact_svg_rounds_coordinates_but_not_scale_factors() -> None:
    made = compact_svg(
        '<svg><metadata>\n<x>1</x></metadata><g id="axes_1"><path id="m" d="M 0.123456 -1.996 \nL 3 4.5001 \n"/>'
        '<use xlink:href="#m" x="10.1234567" y="2" transform="scale(0.1234567 1)" style="width: 0.1234567"/></g></svg>'
    )
    assert made == (
        '<svg><g><path id="m" d="M 0.12 -2 L 3 4.5"/>'
        '<use xlink:href="#m" x="10.12" y="2" transform="scale(0.1234567 1)" style="width: 0.1234567"/></g></svg>'
    )


def draw_compasses(*paths: Path) -> list[bytes]:
    """Draw two compasses and a panel with rotated texts and a legend to files; return the bytes of each file."""
    with use_package_matplotlib_settings():
        figure, panels = create_panel_grid(1, 2, 6.4, 3.5, polar=True)
        for axes in panels.flat:
            turn_axes_into_compass(axes)
            axes.plot([0.0, 1.0, 2.0], [1e-3, 2e-3, 3e-3], label="one")
            axes.set_title("two\nlines", fontsize=9)
        beside = figure.add_axes((0.7, 0.7, 0.2, 0.2))
        beside.loglog([1, 1e4], [1e-3, 1e3])
        label_axes(beside, "", "up")
        beside.annotate("turned", (10, 1), rotation=30, ha="right", rotation_mode="anchor")
        add_title_and_legend(figure, "Title", panels[0, 0])
        save_figure_files(figure, *paths)
    return [path.read_bytes() for path in paths]


def test_skipping_empty_axis_labels_changes_no_byte_of_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """PNG and SVG of a figure share the layout of the file written first, here the PNG; no byte of either changes."""
    spared = draw_compasses(tmp_path / "spared.png", tmp_path / "spared.svg")
    monkeypatch.setattr("matplotlib.axis.Axis.set_label_coords", lambda *_: None)
    assert draw_compasses(tmp_path / "whole.png", tmp_path / "whole.svg") == spared


@pytest.mark.parametrize("kind", ["svg", "png", "pdf"])
def test_a_figure_can_be_saved_after_its_style_context_has_ended(kind: str, tmp_path: Path) -> None:
    with use_package_matplotlib_settings():
        figure, panels = create_panel_grid(1, 1, 3.0, 3.0, polar=False)
        panels[0, 0].set_title("µ · φ")
    save_figure_files(figure, tmp_path / f"one.{kind}", width_inches=2.0)
    save_figure_files(figure, tmp_path / f"two.{kind}")
    assert all((tmp_path / f"{name}.{kind}").stat().st_size > 0 for name in ("one", "two"))


def draw_panels_with_many_ticks(*paths: Path) -> tuple[list[bytes], int]:
    """Draw panels with all kinds of axes and a colour bar; return the bytes of the files and the number of ticks."""
    with use_package_matplotlib_settings():
        figure, panels = create_panel_grid(2, 3, 6.4, 4.5, sharex="col")
        for number, axes in enumerate(panels.flat):
            axes.plot([0.13, 2.1, 97.3], [3e-2, 2.0, 123.4])
            label_axes(axes, f"x of {number}", "y")
        panels[0, 0].set(xscale="log", yscale="log")
        panels[0, 1].set(yscale="symlog")
        panels[1, 1].invert_yaxis()
        panels[1, 2].set(ylim=(1e6, 1e6 + 0.5), xlim=(10.0, 20.0))
        panels[0, 2].twinx().plot([1, 2], [-7, 5])
        panels[0, 2].minorticks_on()
        mesh = panels[1, 0].pcolormesh([0.0, 1.0], [0.0, 1.0], [[0.3]], vmin=-0.13, vmax=0.97)
        figure.colorbar(mesh, ax=panels[1, 0], location="bottom")
        save_figure_files(figure, *paths)
    axes_of_all = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    ticks = sum(len(axis.majorTicks) + len(axis.minorTicks) for axis in axes_of_all)
    return [path.read_bytes() for path in paths], ticks


def test_skipping_outer_ticks_changes_no_byte_of_saved_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """SVG and PNG of a figure share the layout of the file written first, here the SVG; no byte of either changes."""
    spared, few = draw_panels_with_many_ticks(tmp_path / "spared.svg", tmp_path / "spared.png")
    monkeypatch.setattr("overturning.figures.ticks.limit_ticks_to_axis_range", lambda _: None)
    whole, many = draw_panels_with_many_ticks(tmp_path / "whole.svg", tmp_path / "whole.png")
    assert spared == whole
    assert few < 0.9 * many
