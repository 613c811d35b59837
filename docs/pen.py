"""SVG writer with one style for all diagrams of `draw.py`; its bytes are reproducible."""

import math
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Final

INK: Final = "#222222"
Point = tuple[float, float]


class Pen:
    """Writer of shapes and text as SVG, in pixels, y downwards."""

    def __init__(self, width: float, height: float, title: str) -> None:
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
            f'width="{width:g}" height="{height:g}" '
            'font-family="DejaVu Sans, Verdana, sans-serif" font-size="13" stroke-linejoin="round">',
            f"<title>{escape(title)}</title>",
            f'<rect width="{width:g}" height="{height:g}" fill="white"/>',
        ]

    def save(self, path: Path) -> None:
        """Write the drawing."""
        path.write_text("\n".join([*self.parts, "</svg>", ""]), encoding="utf-8")

    def shape(
        self,
        points: Sequence[Point],
        fill: str = "none",
        stroke: str = INK,
        width: float = 1.2,
        dash: str = "",
        close: bool = True,
    ) -> None:
        """Draw a polygon or an open line."""
        name = "polygon" if close else "polyline"
        places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<{name} points="{places}" fill="{fill}" stroke="{stroke}" stroke-width="{width:g}"{dashed}/>'
        )

    def line(self, *points: Point, colour: str = INK, width: float = 1.2, dash: str = "") -> None:
        """Draw an open line."""
        self.shape(points, stroke=colour, width=width, dash=dash, close=False)

    def dot(self, at: Point, radius: float = 3, fill: str = INK, stroke: str = INK) -> None:
        """Draw a dot, or a ring if it is filled with the paper colour."""
        self.parts.append(
            f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{radius:g}" fill="{fill}" '
            f'stroke="{stroke}" stroke-width="1.5"/>'
        )

    def head(self, tip: Point, angle: float, colour: str = INK, size: float = 8) -> None:
        """Draw the head of an arrow along an angle, rad, from +x towards +y."""
        sides = [(tip[0] - size * math.cos(angle + d), tip[1] - size * math.sin(angle + d)) for d in (-0.4, 0.4)]
        self.shape([tip, *sides], fill=colour, stroke=colour, width=0.5)

    def arrow(
        self, start: Point, tip: Point, colour: str = INK, width: float = 1.6, both: bool = False, dash: str = ""
    ) -> None:
        """Draw a straight arrow, with a head at its tip or at both ends."""
        angle = math.atan2(tip[1] - start[1], tip[0] - start[0])
        short = (tip[0] - 5 * math.cos(angle), tip[1] - 5 * math.sin(angle))
        self.line(start, short, colour=colour, width=width, dash=dash)
        self.head(tip, angle, colour)
        if both:
            self.head(start, angle + math.pi, colour)

    def arc(
        self,
        centre: Point,
        radius: float,
        start: float,
        end: float,
        colour: str = INK,
        tip: bool = True,
        dash: str = "",
        flat: float = 1.0,
    ) -> None:
        """Draw an arc between azimuths (degrees clockwise from up) with head at its end; `flat` scales its height."""
        steps = max(8, int(abs(end - start) / 4))
        angles = [math.radians(start + (end - start) * i / steps) for i in range(steps + 1)]
        points = [(centre[0] + radius * math.sin(a), centre[1] - flat * radius * math.cos(a)) for a in angles]
        self.line(*points, colour=colour, width=1.4, dash=dash)
        if tip:
            (x0, y0), (x1, y1) = points[-3], points[-1]
            self.head(points[-1], math.atan2(y1 - y0, x1 - x0), colour, 7)

    def text(
        self, at: Point, words: str, anchor: str = "middle", colour: str = INK, size: float = 13, bold: bool = False
    ) -> None:
        """Write text; a letter or ``{letters}`` after ``_`` is a subscript."""
        weight = ' font-weight="bold"' if bold else ""
        self.parts.append(
            f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" text-anchor="{anchor}" fill="{colour}" '
            f'font-size="{size:g}"{weight}>{_lowered(words)}</text>'
        )


def _lowered(words: str) -> str:
    first, *rest = words.split("_")
    out = escape(first)
    for piece in rest:
        low, after = (
            (piece[1 : piece.index("}")], piece[piece.index("}") + 1 :]) if piece[0] == "{" else (piece[0], piece[1:])
        )
        out += f'<tspan dy="3" font-size="9.5">{escape(low)}</tspan>' + (
            f'<tspan dy="-3">{escape(after)}</tspan>' if after else ""
        )
    return out
