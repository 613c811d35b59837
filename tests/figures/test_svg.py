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
    project_style,
    turn_axes_into_compass,
)
from overturning.figures.svg import compact_svg
from overturning.figures.write import save_figure_files


def drawn(path: Path, small: bool) -> str:
    """Draw two panels with logarithmic ticks, markers, a raster image and formulas; return the SVG."""
    import matplotlib.pyplot as plt

    random = np.random.Generator(np.random.PCG64(1))
    with project_style():
        figure, axes = plt.subplots(1, 2)
        axes[0].loglog([1, 10, 1e4], [1e-3, 1, 1e3], marker="o", label="a < b & c")
        axes[1].scatter(*random.random((2, 50)), c=["#ff0000", "#00ff00"] * 25, linewidths=0, antialiaseds=False,
        rasterized=True)  # fmt: skip
        axes[1].set_title("µ · H/B")
        axes[0].legend()
        if small:
            save_figure_files(figure, path)
        else:
            figure.savefig(path, dpi=DPI)
            plt.close(figure)
    return path.read_text(encoding="utf-8")


def texts(svg: str) -> str:
    """Return all texts of an SVG."""
    return "".join(re.findall(r">([^<>\n]+)</t", svg))


def pixels(svg: str) -> np.ndarray:
    """Return the pixels of the raster image in an SVG."""
    (data,) = re.findall(r"data:image/png;base64,([^\"]*)", svg)
    with Image.open(io.BytesIO(base64.b64decode(data))) as picture:
        return np.asarray(picture.convert("RGBA"))


def test_compact_svg_looks_the_same(tmp_path: Path) -> None:
    large, small = drawn(tmp_path / "large.svg", small=False), drawn(tmp_path / "small.svg", small=True)
    assert len(small) < 0.9 * len(large)
    assert texts(small) == texts(large)
    assert "µ · H/B" in texts(small)
    np.testing.assert_array_equal(pixels(small), pixels(large))
    named = set(re.findall(r'id="([^"]+)"', small))
    assert set(re.findall(r'(?:href="#|url\(#)([^")]+)', small)) <= named, "what is referred to is there"
    assert small == drawn(tmp_path / "again.svg", small=True)


def test_coordinates_are_rounded_but_factors_are_exact() -> None:
    made = compact_svg(
        '<svg><metadata>\n<x>1</x></metadata><g id="axes_1"><path id="m" d="M 0.123456 -1.996 \nL 3 4.5001 \n"/>'
        '<use xlink:href="#m" x="10.1234567" y="2" transform="scale(0.1234567 1)" style="width: 0.1234567"/></g></svg>'
    )
    assert made == (
        '<svg><g><path id="m" d="M 0.12 -2 L 3 4.5"/>'
        '<use xlink:href="#m" x="10.12" y="2" transform="scale(0.1234567 1)" style="width: 0.1234567"/></g></svg>'
    )


def compasses(path: Path) -> bytes:
    """Draw two compasses and a panel with rotated texts, a legend, and axes with and without labels."""
    with project_style():
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
        save_figure_files(figure, path)
    return path.read_bytes()


@pytest.mark.parametrize("kind", ["svg", "png"])
def test_skipping_empty_axis_labels_changes_no_byte(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spared = compasses(tmp_path / f"spared.{kind}")
    monkeypatch.setattr("matplotlib.axis.Axis.set_label_coords", lambda *_: None)
    assert compasses(tmp_path / f"whole.{kind}") == spared


@pytest.mark.parametrize("kind", ["svg", "png", "pdf"])
def test_figure_is_saved_outside_the_style_context(kind: str, tmp_path: Path) -> None:
    with project_style():
        figure, panels = create_panel_grid(1, 1, 3.0, 3.0, polar=False)
        panels[0, 0].set_title("µ · φ")
    save_figure_files(figure, tmp_path / f"one.{kind}", width=2.0)
    save_figure_files(figure, tmp_path / f"two.{kind}")
    assert all((tmp_path / f"{name}.{kind}").stat().st_size > 0 for name in ("one", "two"))
