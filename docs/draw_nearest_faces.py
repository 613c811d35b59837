"""Draw docs/images/nearest-faces.svg: which faces of two elements are nearest, and which vertices carry force.

Usage: python docs/draw_nearest_faces.py. The faces and vertices are those that the package itself finds.
"""

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from overturning.dem.polygon.geometry import Placed, common_stretch, nearest_faces, place
from overturning.dem.scene import Scene
from overturning.figures.style import FALLS, FAULT, INK, save, style

IMAGE = Path(__file__).parent / "images" / "nearest-faces.svg"


def _pair(*elements: dict[str, Any]) -> tuple[Placed, Placed]:
    # The drawing's elements overlap or hang, which a scene must not; only their places are wanted.
    scene = Scene.model_construct(
        name="drawing", gravity=9.8, reference=None, contacts=(),
        materials=Scene.model_fields["materials"].default,
        elements=tuple(_element(number, **element) for number, element in enumerate(elements)),
    )  # fmt: skip
    first, second = place(scene)
    return second, first


def _element(number: int, **keys: Any) -> Any:
    from overturning.dem.element import Element

    return Element(name=f"e{number}", **keys)


PANELS = {
    "a corner on a wide face": _pair(
        {"kind": "driven", "width": 3.0, "height": 0.6, "at": (0, -0.6)},
        {"width": 0.7, "height": 1.3, "rotation_deg": 14, "at": (0, 0.075)},
    ),
    "a stack that has slid": _pair(
        {"kind": "driven", "width": 1.5, "height": 0.6, "at": (0, -0.6)},
        {"width": 1.5, "height": 0.7, "at": (0.45, 0)},
    ),
    "beyond 45° the next side is nearest": _pair(
        {"kind": "driven", "width": 3.0, "height": 0.6, "at": (0, -0.6)},
        {"width": 0.7, "height": 1.3, "rotation_deg": 62, "at": (-0.5, 0.3)},
    ),
    "a corner against a wall": _pair(
        {"kind": "driven", "width": 0.4, "height": 2.0, "at": (0.9, -0.6)},
        {"width": 0.6, "height": 1.3, "rotation_deg": 24, "at": (-0.12, 0.0)},
    ),
}


def _draw(axes: Any, a: Placed, b: Placed, title: str) -> None:
    face_a, face_b, _ = nearest_faces(a, b)
    for item, colour in ((b, "#d9d9d6"), (a, "#f4ead9")):
        axes.fill(*item.points.T, facecolor=colour, edgecolor=INK, linewidth=0.7)
    for item, face, colour in ((a, face_a, FALLS), (b, face_b, FAULT)):
        ends = item.points[[face, (face + 1) % len(item.points)]]
        axes.plot(*ends.T, color=colour, linewidth=2.4, solid_capstyle="butt")
        axes.plot(*ends.T, linestyle="", marker="o", markersize=5, markerfacecolor="white", markeredgecolor=colour)
        normal = item.shape.faces()[face, 4:6]
        middle = ends.mean(axis=0)
        axes.annotate("", middle + 0.28 * normal, middle, arrowprops={"arrowstyle": "->", "color": colour})
    for end in common_stretch(a, b):
        if np.isfinite(end.gap):
            axes.plot(*end.point, marker="o", markersize=5, color=INK, zorder=5)
    axes.set_aspect("equal")
    axes.set_xlim(-1.3, 1.35)
    axes.set_ylim(-0.62, 1.6)
    axes.axis("off")
    axes.set_title(title, fontsize=8.5)


def main() -> None:
    """Draw and write the figure."""
    with style():
        figure, panels = plt.subplots(1, len(PANELS), figsize=(10.5, 2.7), layout="constrained")
        for axes, (title, (a, b)) in zip(panels, PANELS.items(), strict=True):
            _draw(axes, a, b, title)
        save(figure, IMAGE)


if __name__ == "__main__":
    main()
