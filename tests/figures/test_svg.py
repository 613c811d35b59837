"""An SVG made small shows what it showed: its texts, its picture's pixels, its ticks where they were."""

import base64
import io
import re
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from overturning.figures import write
from overturning.figures.style import DPI, caption, compass, grid, labels, style
from overturning.figures.svg import compact
from overturning.figures.write import save


def drawn(path: Path, small: bool) -> str:
    """Two panels with logarithmic ticks, marks, a picture inside, and formulas."""
    import matplotlib.pyplot as plt

    random = np.random.Generator(np.random.PCG64(1))
    with style():
        figure, axes = plt.subplots(1, 2)
        axes[0].loglog([1, 10, 1e4], [1e-3, 1, 1e3], marker="o", label="a < b & c")
        axes[1].scatter(*random.random((2, 50)), c=["#ff0000", "#00ff00"] * 25, linewidths=0, antialiaseds=False,
        rasterized=True)  # fmt: skip
        axes[1].set_title("µ · H/B")
        axes[0].legend()
        if small:
            save(figure, path)
        else:
            figure.savefig(path, dpi=DPI)
            plt.close(figure)
    return path.read_text(encoding="utf-8")


def texts(svg: str) -> str:
    """All that can be read."""
    return "".join(re.findall(r">([^<>\n]+)</t", svg))


def pixels(svg: str) -> np.ndarray:
    """The picture inside."""
    (data,) = re.findall(r"data:image/png;base64,([^\"]*)", svg)
    with Image.open(io.BytesIO(base64.b64decode(data))) as picture:
        return np.asarray(picture.convert("RGBA"))


def test_small_svg_shows_the_same(tmp_path: Path) -> None:
    large, small = drawn(tmp_path / "large.svg", small=False), drawn(tmp_path / "small.svg", small=True)
    assert small.count("\n") < 0.2 * large.count("\n")
    assert len(small) < 0.6 * len(large)
    assert texts(small) == texts(large)
    assert "µ · H/B" in texts(small)
    np.testing.assert_array_equal(pixels(small), pixels(large))
    named = set(re.findall(r'id="(\w+)"', small))
    assert set(re.findall(r'(?:href="#|url\(#)(\w+)', small)) <= named, "what is referred to is there"
    assert small == drawn(tmp_path / "again.svg", small=True)


def test_neighbouring_ticks_are_one_path_at_their_places() -> None:
    use = '<g><use xlink:href="#m" x="{}.1234567" y="2" style="stroke: #222"/></g>'
    made = compact(
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"><g id="axes">'
        '<defs><path id="m" d="M 0 0 \nL 0 3.5 \n" style="fill: none"/></defs>'
        f"{use.format(10)}{use.format(20)}</g></svg>"
    )
    assert '<path style="stroke: #222; fill: none" d="M 10.12 2 L 10.12 5.5 M 20.12 2 L 20.12 5.5" />' in made


def compasses(path: Path) -> bytes:
    """Two compasses and a panel with texts turned and of several lines, a legend, and axes with and without a name."""
    with style():
        figure, panels = grid(1, 2, 6.4, 3.5, polar=True)
        for axes in panels.flat:
            compass(axes)
            axes.plot([0.0, 1.0, 2.0], [1e-3, 2e-3, 3e-3], label="one")
            axes.set_title("two\nlines", fontsize=9)
        beside = figure.add_axes((0.7, 0.7, 0.2, 0.2))
        beside.loglog([1, 1e4], [1e-3, 1e3])
        labels(beside, "", "up")
        beside.annotate("turned", (10, 1), rotation=30, ha="right", rotation_mode="anchor")
        caption(figure, "Title", panels[0, 0])
        save(figure, path)
    return path.read_bytes()


@pytest.mark.parametrize("kind", ["svg", "png"])
def test_what_is_spared_changes_no_byte(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Texts that are measured once and names of axes that are not looked for stand where Matplotlib puts them."""
    spared = compasses(tmp_path / f"spared.{kind}")
    monkeypatch.setattr(write, "_measure_once", nullcontext)
    monkeypatch.setattr("matplotlib.axis.Axis.set_label_coords", lambda *_: None)
    assert compasses(tmp_path / f"whole.{kind}") == spared
