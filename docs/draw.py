"""Draw the diagrams of these pages: docs/images/block.svg, clock.svg, data.svg and nearest-faces.svg.

Usage: python docs/draw.py [FOLDER]. The files are reproducible (a test compares them). The nearest faces are found
by the package itself.
"""

import math
import sys
from collections.abc import Sequence
from pathlib import Path

from pen import Pen, Point

from overturning.figures.style import FALL_COLOUR, FAULT_COLOUR, MISSING_COLOUR
from overturning.model.element import Element
from overturning.model.geometry import (
    PlacedElement,
    nearest_faces_and_separation,
    possible_contact_points_of_elements,
    scale_and_place_elements,
)
from overturning.model.scene import Scene

IMAGES = Path(__file__).parent / "images"
STONE, GROUND = "#f4ead9", "#d9d9d6"


def draw_block_with_forces() -> Pen:
    """Draw the block, its state and forces, and the plan with the azimuth."""
    pen = Pen(960, 340, "The block with B, H, alpha and R; rotation, forces and penetration; the azimuth in plan")
    for x, words in ((140, "Shape"), (460, "State and forces, in the vertical plane"), (810, "Plan")):
        pen.text((x, 22), words, bold=True)
    _draw_block_dimensions(pen)
    _draw_rotated_block_with_forces(pen)
    _draw_plan_with_azimuth(pen)
    return pen


def _draw_block_dimensions(pen: Pen) -> None:
    left, right, top, floor = 90, 200, 85, 265
    middle = (145, 175)
    pen.shape([(20, floor), (260, floor), (260, floor + 24), (20, floor + 24)], fill=GROUND, stroke="none")
    pen.line((20, floor), (260, floor))
    pen.shape([(left, floor), (left, top), (right, top), (right, floor)], fill=STONE)
    pen.line(middle, (right, floor), colour=FAULT_COLOUR, width=1.8)
    pen.dot(middle)
    alpha = math.degrees(math.atan((right - left) / (floor - top)))
    pen.arc((right, floor), 62, 0, -alpha, colour=FAULT_COLOUR, tip=False)
    pen.text((187, 194), "α", colour=FAULT_COLOUR)
    pen.text((158, 222), "R", colour=FAULT_COLOUR)
    pen.arrow((left, 65), (right, 65), width=1, both=True)
    pen.text((145, 57), "B")
    pen.arrow((70, floor), (70, top), width=1, both=True)
    pen.text((62, 179), "H", anchor="end")
    pen.text((145, 316), "tan α = B/H,  R = ½√(B² + H²)", size=12)


def _draw_rotated_block_with_forces(pen: Pen) -> None:
    floor, corner, half, theta = 245, (500, 256), (55, 90), math.radians(17)
    c, s = math.cos(theta), math.sin(theta)

    def at(x: float, up: float) -> Point:
        # A point of the block, seen from its right lower corner, turned clockwise.
        return corner[0] + c * x + s * up, corner[1] + s * x - c * up

    pen.shape([(300, floor), (650, floor), (650, floor + 52), (300, floor + 52)], fill=GROUND, stroke="none")
    pen.shape([at(0, 0), at(-2 * half[0], 0), at(-2 * half[0], 2 * half[1]), at(0, 2 * half[1])], fill=STONE)
    pen.line((300, floor), (650, floor))
    middle = at(-half[0], half[1])
    # The rotation, between the vertical through the centre and the block's own axis.
    pen.line(middle, (middle[0], 50), dash="4 3", width=1)
    pen.line(middle, at(-half[0], 2 * half[1] + 20), dash="4 3", width=1)
    pen.arc(middle, 105, 0, 17, colour=FALL_COLOUR)
    pen.text((middle[0] + 44, middle[1] - 98), "θ > 0", colour=FALL_COLOUR, anchor="start")
    # Body forces in the frame of the base, and what shakes it.
    pen.arrow(middle, (middle[0] - 78, middle[1]), colour=FAULT_COLOUR)
    pen.text((middle[0] - 84, middle[1] + 4), "−m a", colour=FAULT_COLOUR, anchor="end")
    pen.arrow(middle, (middle[0], middle[1] + 46), colour=FAULT_COLOUR)
    pen.text((middle[0] - 62, middle[1] + 64), "−m (g + a_{up})", colour=FAULT_COLOUR, anchor="start", size=12)
    pen.dot(middle)
    pen.text((middle[0] + 9, middle[1] - 3), "(x, z)", anchor="start")
    pen.arrow((330, floor + 26), (390, floor + 26), colour=FAULT_COLOUR, width=2.4)
    pen.text((398, floor + 30), "a(t)", colour=FAULT_COLOUR, anchor="start")
    # The forces of the base on the right corner.
    pen.arrow((corner[0], corner[1] + 40), corner, colour=FALL_COLOUR, width=2)
    pen.text((corner[0] + 8, corner[1] + 36), "f_n", colour=FALL_COLOUR, anchor="start")
    pen.arrow(corner, (corner[0] + 46, corner[1]), colour=FALL_COLOUR, width=2)
    pen.text((corner[0] + 52, corner[1] + 9), "f_s", colour=FALL_COLOUR, anchor="start")
    pen.line((corner[0] + 92, floor), (corner[0] + 92, corner[1]), width=3)
    pen.text((corner[0] + 100, corner[1] + 5), "U_n", anchor="start")
    pen.text((corner[0] + 14, floor - 8), "right", size=12, anchor="start")
    lifted = at(-2 * half[0], 0)
    pen.text((lifted[0] - 8, lifted[1] + 4), "left", size=12, anchor="end")
    pen.arrow((590, 130), (590, 80), width=1.3)
    pen.text((590, 72), "z")
    pen.arrow((590, 130), (640, 130), width=1.3)
    pen.text((646, 134), "s", anchor="start")
    pen.text((475, 316), "The penetration is drawn far too large.", size=12)


def _draw_plan_with_azimuth(pen: Pen) -> None:
    centre, radius, azimuth = (810, 165), 92, math.radians(60)
    towards = (math.sin(azimuth), -math.cos(azimuth))
    pen.dot(centre, radius, fill="#ffffff", stroke=MISSING_COLOUR)
    for words, (dx, dy) in (("N", (0, -1)), ("E", (1, 0)), ("S", (0, 1)), ("W", (-1, 0))):
        pen.text((centre[0] + (radius + 13) * dx, centre[1] + (radius + 13) * dy + 5), words, colour=MISSING_COLOUR)
    pen.line(centre, (centre[0], centre[1] - radius), dash="4 3", width=1)
    side, front = 16, 16
    corners = [(-side, -front), (side, -front), (side, front), (-side, front)]
    pen.shape(
        [
            (centre[0] + x * towards[0] - y * towards[1], centre[1] + x * towards[1] + y * towards[0])
            for x, y in corners
        ],
        fill=STONE,
    )
    far = (centre[0] - 84 * towards[0], centre[1] - 84 * towards[1])
    pen.line(centre, far, dash="4 3")
    tip = (centre[0] + 128 * towards[0], centre[1] + 128 * towards[1])
    pen.arrow(centre, tip, colour=FALL_COLOUR, width=2)
    pen.text((tip[0] + 4, tip[1] - 8), "s", colour=FALL_COLOUR)
    pen.arc(centre, 52, 0, 60)
    pen.text((centre[0] + 33, centre[1] - 56), "φ")
    pen.text((centre[0] + 112, centre[1] - 22), "+1", colour=FALL_COLOUR, bold=True, anchor="start")
    pen.text((far[0] - 26, far[1] + 21), "−1", bold=True)
    pen.text((810, 300), "overturned: the side to which it falls", size=12)
    pen.text((702, 318), "a = a_{north} cos φ + a_{east} sin φ", size=12, anchor="start")


WHOLE, LONG, SHORT, FINE = "#e9e9e6", "#cfe3f0", "#f6c9a0", FALL_COLOUR


def draw_step_lengths_around_contact_change() -> Pen:
    """Draw the rejected and accepted time steps of the centred scheme around a change of contact."""
    pen = Pen(960, 345, "Whole steps, shorter steps around a change of contact, and whole steps again")
    unit, left, top = 150.0, 30.0, 66.0
    zoom, origin, low = 800.0, 80.0, 222.0
    # In whole steps, the finest 1/128. A longer step begins at a multiple of its length.
    change = 1.578125 + 1 / 128
    spans = [
        (0, 1, WHOLE, 1), (1, 1.5, LONG, 2), (1.5, 1.5625, SHORT, 16), (1.5625, 1.578125, FINE, 64),
        (1.578125, 1.65625, FINE, 128), (1.65625, 1.78125, FINE, 64), (1.78125, 2.0625, SHORT, 32),
        (2.0625, 2.625, SHORT, 16), (2.625, 3, LONG, 8), (3, 3.5, LONG, 4), (3.5, 5, LONG, 2), (5, 6, WHOLE, 1),
    ]  # fmt: skip
    ends = [(left + unit, top + 34), (left + 2 * unit, top + 34), (origin + zoom, low), (origin, low)]
    pen.shape(ends, fill="#f3f3f1", stroke="none")
    for start, end, colour, parts in spans:
        _draw_period_of_equal_steps(pen, left + unit * start, left + unit * end, top, 34, colour, unit / parts)
        if end > 1 and start < 2:
            inner = [origin + zoom * (min(max(edge, 1), 2) - 1) for edge in (start, end)]
            _draw_period_of_equal_steps(pen, *inner, low, 34, colour, zoom / parts)
    at = left + unit * change
    pen.arrow((at, top - 22), (at, top))
    pen.text((at, top - 28), "a contact opens or closes", size=12)
    pen.text((left, top - 28), "time →", size=12, anchor="start")
    for start, end, words in (
        (0, 1, "whole steps"),
        (change, 2.625, "eight of each length"),
        (2.625, 5, "then two of each"),
        (5, 6, "whole steps"),
    ):
        _draw_labelled_bracket(pen, left + unit * start, left + unit * end, top + 44, words)
    # The step of the change, enlarged: what is refused on the way to it.
    for start, end, height in (
        (0.0, 1.0, 72.0),
        (0.5, 1.0, 52.0),
        (0.5, 0.75, 32.0),
        (0.5, 0.625, 22.0),
        (0.5625, 0.59375, 14.0),
    ):
        a, b = origin + zoom * start, origin + zoom * end
        pen.arc(((a + b) / 2, low), (b - a) / 2, 90, -90, colour=FAULT_COLOUR, dash="4 3", flat=2 * height / (b - a))
    pen.text((origin + 150, low - 30), "rejected: a contact would change", anchor="start", colour=FAULT_COLOUR, size=12)
    at = origin + zoom * (change - 1)
    pen.line((at, low - 5), (at, low + 44), width=2.2)
    pen.text((at - 6, low + 52), "the change, in a finest step", size=12, anchor="end")
    _draw_labelled_bracket(pen, at, origin + zoom * 0.65625, low + 40, "eight of the finest")
    x = 150.0
    for colour, words, room in (
        (WHOLE, "whole step", 150),
        (LONG, "1/2 to 1/8", 150),
        (SHORT, "1/16, 1/32", 150),
        (FINE, "1/64, 1/128: the finest here", 0),
    ):
        pen.shape([(x, 308), (x + 22, 308), (x + 22, 324), (x, 324)], fill=colour, width=0.6)
        pen.text((x + 30, 321), words, anchor="start", size=12)
        x += room
    return pen


def _draw_period_of_equal_steps(
    pen: Pen, start: float, end: float, top: float, height: float, colour: str, step: float
) -> None:
    """Draw a period filled with steps of one length."""
    pen.shape([(start, top), (end, top), (end, top + height), (start, top + height)], fill=colour, width=0.8)
    if step < 2:
        return
    for i in range(1, int((end - start) / step + 0.999)):
        pen.line((start + i * step, top), (start + i * step, top + height), width=0.6)


def _draw_labelled_bracket(pen: Pen, start: float, end: float, top: float, words: str) -> None:
    pen.line((start + 2, top), (start + 2, top + 6), (end - 2, top + 6), (end - 2, top), width=0.9)
    pen.text(((start + end) / 2, top + 22), words, size=12)


def draw_data_flow_to_report() -> Pen:
    """Draw the flow of the data through the package, from record files to the report."""
    pen = Pen(960, 216, "From record files to motion.nc, the parts of the sweep, cube.nc and the report")
    top, low, half = 40, 138, 58
    boxes = {
        (72, top): "record files", (270, top): "motion.nc", (468, top): "parts", (666, top): "cube.nc",
        (886, top): "report",
        (270, low): "intensity.nc", (468, low): "study YAML", (666, low): "survey CSV",
    }  # fmt: skip
    for (x, y), words in boxes.items():
        pen.shape([(x - half, y - 17), (x + half, y - 17), (x + half, y + 17), (x - half, y + 17)], fill=STONE)
        pen.text((x, y + 5), words)
    for start, end, words, room in (
        (72, 270, "read", "records/"), (270, 468, "sweep", "dem/"), (468, 666, "gather", "study/"),
        (666, 886, "draw, write", "statistics/"),
    ):  # fmt: skip
        pen.arrow((start + half, top), (end - half, top))
        pen.text(((start + end) / 2, top - 9), words, size=12)
        pen.text(((start + end) / 2, top + 18), room, size=11, colour=MISSING_COLOUR)
    pen.text((776, top + 32), "figures/ report/", size=11, colour=MISSING_COLOUR)
    pen.arrow((270, top + 17), (270, low - 17))
    pen.text((262, 94), "rotate", size=12, anchor="end")
    pen.text((278, 94), "motion/", size=11, anchor="start", colour=MISSING_COLOUR)
    pen.arrow((468, low - 17), (468, top + 17))
    pen.text((460, 94), "cases", size=12, anchor="end")
    pen.text((476, 94), "study/", size=11, anchor="start", colour=MISSING_COLOUR)
    pen.line((666 + half, low), (868, low), (868, top + 22), width=1.6)
    pen.arrow((868, top + 40), (868, top + 17))
    pen.text((796, low - 9), "compare", size=12)
    pen.text((796, low + 18), "surveys/", size=11, colour=MISSING_COLOUR)
    pen.line((270, low + 17), (270, low + 46), (904, low + 46), (904, top + 22), width=1.6)
    pen.arrow((904, top + 40), (904, top + 17))
    return pen


PANELS: dict[str, tuple[dict, dict]] = {
    "a corner on a wide face": (
        {"kind": "driven", "width": 3.0, "height": 0.6, "at": (0, -0.6)},
        {"width": 0.7, "height": 1.3, "rotation_deg": 14, "at": (0, 0.075)},
    ),
    "a stack that has slid": (
        {"kind": "driven", "width": 1.5, "height": 0.6, "at": (0, -0.6)},
        {"width": 1.5, "height": 0.7, "at": (0.45, 0)},
    ),
    "beyond 45° the next side is nearest": (
        {"kind": "driven", "width": 3.0, "height": 0.6, "at": (0, -0.6)},
        {"width": 0.7, "height": 1.3, "rotation_deg": 62, "at": (-0.5, 0.3)},
    ),
    "a corner against a wall": (
        {"kind": "driven", "width": 0.4, "height": 2.0, "at": (0.9, -0.6)},
        {"width": 0.6, "height": 1.3, "rotation_deg": 24, "at": (-0.12, 0.0)},
    ),
}


def _place_two_elements(*elements: dict) -> tuple[PlacedElement, PlacedElement]:
    # The drawing's elements overlap or hang, which a scene must not; only their places are wanted.
    scene = Scene.model_construct(
        name="drawing", gravity=9.8, reference=None, contacts=(),
        materials=Scene.model_fields["materials"].default,
        elements=tuple(Element(name=f"e{number}", **element) for number, element in enumerate(elements)),
    )  # fmt: skip
    first, second = scale_and_place_elements(scene)
    return second, first


def draw_nearest_faces() -> Pen:
    """Draw the nearest faces of two elements and the vertices that are tested."""
    pen = Pen(960, 230, "Nearest faces of two elements and the vertices that are tested")
    for index, (title, elements) in enumerate(PANELS.items()):
        a, b = _place_two_elements(*elements)
        centre = 120 + 240 * index

        def at(point: Sequence[float], centre: float = centre) -> Point:
            return centre + 85 * float(point[0]), 172 - 85 * float(point[1])

        pen.text((centre, 22), title, size=12)
        for item, colour in ((b, GROUND), (a, STONE)):
            pen.shape(
                [at((min(max(x, -1.35), 1.35), max(z, -0.6))) for x, z in item.vertices_in_scene],
                fill=colour,
                width=0.8,
            )
        face_a, face_b, _ = nearest_faces_and_separation(a, b)
        for item, face, colour in ((a, face_a, FALL_COLOUR), (b, face_b, FAULT_COLOUR)):
            ends = item.vertices_in_scene[[face, (face + 1) % len(item.vertices_in_scene)]]
            normal, middle = item.shape.face_geometry_and_contact_flag_table[face, 4:6], ends.mean(axis=0)
            pen.line(*(at((min(max(x, -1.35), 1.35), z)) for x, z in ends), colour=colour, width=2.6)
            pen.arrow(at(middle), at(middle + 0.28 * normal), colour=colour)
            for end in ends:
                if abs(end[0]) < 1.35:
                    pen.dot(at(end), 4, fill="#ffffff", stroke=colour)
        for end in possible_contact_points_of_elements(a, b):
            if math.isfinite(end.signed_gap):
                pen.dot(at(end.vertex_position), 4)
    return pen


DRAWINGS = {
    "block.svg": draw_block_with_forces,
    "clock.svg": draw_step_lengths_around_contact_change,
    "data.svg": draw_data_flow_to_report,
    "nearest-faces.svg": draw_nearest_faces,
}


def main(folder: Path = IMAGES) -> None:
    """Draw and write all diagrams."""
    for name, draw in DRAWINGS.items():
        draw().save(folder / name)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
