"""From a prepared scene to the kernel's arrays: the column at rest, faces, rules and limits."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.limits import DEEPEST
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.prepare import Prepared, smallest
from overturning.model.geometry import WIDE, Placed, common_stretch, partners, parts_of

CALM_KINETIC: Final = 1e-9
"""Kinetic energy at rest, as a share of m g times the half of the smallest side of the lightest element."""


FLAT: Final = 0.999
"""An element that lies on another face has turned by this share of its angle at least: its contacts give way."""


def kernel_column(prepared: Prepared) -> FloatArray:
    """The rows of a column at rest, as the kernel wants them, shape (rows,)."""
    from overturning.dem.polygon import rows
    from overturning.dem.polygon import state as k

    placed, laws, still = prepared.placed, prepared.laws, k.Plane(0.0, 0.0, 0.0)
    elements = []
    for index, item in enumerate(placed):
        dx, dz, turn = prepared.displacement[index]
        # The pair that is turned keeps length 1 to the last digit for the minute rotations of a scene at rest.
        pose = k.Pose(item.x + dx, item.z + dz, turn, 1.0 - 0.5 * turn * turn, turn * (1.0 - turn * turn / 6.0))
        free = (0.0, 0.0, 0.0, 0.0) if item.fixed else (1.0 / item.mass, 1.0 / item.inertia, item.mass, 1.0)
        frame, held = float(item.element.kind != "driven"), float(item.element.kind == "held")
        support, (x, z) = placed[prepared.support[index]], prepared.base[index]
        elements.append(
            k.Element(
                pose, still, k.Trial(pose, still, still, 0.0, 0.0, still), still, still,
                k.Body(*free, frame, held, float(prepared.critical[index])),
                k.Course(moved=0.0, turned=0.0, work=0.0, peak_angle=abs(turn), last_upright=-1.0, power=0.0),
                k.Standing(
                    0.0, 0.0, 0.0, 0.0, 0.0, x - item.x, z - item.z, x - support.x, z - support.z,
                    item.x, item.z, item.z - item.drop,
                ),
            )
        )  # fmt: skip
    settled = np.inf if rests_on_one_face(placed) else 0.0
    nearest = k.Nearest(face_a=-1.0, face_b=-1.0, lever=0.0, limit=settled, reach=-1.0, used=0.0, ahead=0.0)
    seen, face = k.Seen(0.0, 0.0), k.Face(0.0, 0.0, 0.0, 0.0, 0.0)
    unseen = k.Vertices(seen, seen, seen, seen)
    pairs, free_ends, stands = (
        [],
        k.Bounds(0.0, 0.0, 0.0, 0.0),
        [float(j in prepared.carriers[i]) - (i in prepared.carriers[j]) for i, j in prepared.pairs],
    )
    for index, (a, b) in enumerate(partners(placed, prepared.pairs)):
        tangential = laws.tangential[index]
        compliance = 1.0 / tangential if tangential > 0 else 0.0
        law = k.Law(laws.normal[index], tangential, laws.dashpot[index], laws.friction[index], compliance)
        ends = [k.Memory(0.0, rows.OPEN, 0.0, 0.0)] * 2
        for at, side, slip in prepared.springs:
            if at == index:
                ends[side] = k.Memory(slip, rows.MINE if _is_first(a, b, side) else rows.THEIRS, 0.0, 0.0)
        pairs.append(
            k.Pair(face, face, free_ends, law, nearest, unseen, ends[0], ends[1], 0.0, 0.0, 0.0, 0.0, stands[index])
        )
    step = [0.0] * (rows.PAIR.count - len(rows.flat(pairs[0])) if pairs else 0)
    return np.array(
        [0.0] * rows.CASE.count + rows.flat(elements) + [number for pair in pairs for number in rows.flat(pair) + step]
    )


def rests_on_one_face(placed: list[Placed]) -> bool:
    """Whether the first nearest faces stay so until the case ends: one upright rectangle on a wide driven one.

    Its lower corners alone can touch the ground until it lies on its side, and then it has fallen.
    """
    if len(placed) != 2:
        return False
    ground, block = placed
    rectangles = all(item.element.width is not None and item.element.rotation_deg == 0 for item in placed)
    return (
        rectangles
        and ground.element.kind == "driven"
        and block.element.kind == "free"
        and fallen_angle(block) < 0.5 * np.pi
        and abs(float(block.points[:, 1].min() - ground.points[:, 1].max())) <= 1e-9 * block.size
        and ground.shape.width > WIDE * max(block.shape.width, block.shape.height) + 2.0 * abs(block.x - ground.x)
    )


def _is_first(a: Placed, b: Placed, side: int) -> bool:
    """Whether the vertex of an end is the first element's."""
    point = common_stretch(a, b)[side].point
    return bool(min(np.hypot(x - point[0], z - point[1]) for x, z in a.points) < 1e-9 * a.size)


def kernel_shapes(prepared: Prepared) -> tuple[NDArray[np.int64], FloatArray]:
    """Numbers of vertices of all convex pieces, shape (pieces,), and faces, shape (pieces, most vertices, 12)."""
    parts = [part for item in prepared.placed for part in item.shape.parts]
    sizes = np.array([len(part.vertices) for part in parts], dtype=np.int64)
    shapes = np.zeros((len(sizes), int(sizes.max()), 12))
    for index, part in enumerate(parts):
        shapes[index, : sizes[index]] = part.faces
    return sizes, shapes


def kernel_layout(prepared: Prepared) -> NDArray[np.int64]:
    """The two elements of each pair, and their pieces by their numbers among those of all, shape (pairs, 4)."""
    counts = [len(item.shape.parts) for item in prepared.placed]
    first = np.cumsum([0, *counts]).tolist()
    parts = parts_of(prepared.placed, prepared.pairs)
    rows = [(i, j, first[i] + m, first[j] + n) for (i, j), (m, n) in zip(prepared.pairs, parts, strict=True)]
    return np.array(rows, dtype=np.int64).reshape(-1, 4)


def fallen_angle(item: Placed) -> float:
    """Rotation at which an element counts as fallen, rad: `FLAT` of the one that brings a face down, or that of its scene."""
    brings_down = item.element.fallen_rotation_deg in (None, 90.0)
    return round(FLAT * item.fallen, 12) if brings_down else item.fallen


def _energies(prepared: Prepared, n: int) -> tuple[float, float]:
    """Energy that overturns an element, and that its errors are a share of, J.

    One that falls by itself needs none, however little is left; its errors are measured by its weight times its size.
    """
    item, barrier = prepared.placed[n], float(prepared.barrier[n])
    whole = item.mass * prepared.scene.gravity * item.size
    return (barrier, barrier) if barrier > 1e-6 * whole else (-np.inf, whole)


def kernel_rules(prepared: Prepared) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """When elements have fallen, of `tables.ELEMENT`, shape (elements,), and when a case has failed or rests, of `tables.LIMITS`."""
    rules, limits = np.zeros(len(prepared.placed), t.ELEMENT), np.zeros((), t.LIMITS)
    free = [item for item in prepared.placed if not item.fixed]
    for index, item in enumerate(prepared.placed):
        back, on = prepared.tips[index]
        rules[index] = (
            0.0 if item.fixed else 1.0, fallen_angle(item), back, on, prepared.support[index], prepared.barrier[index]
        )  # fmt: skip
    lightest = min(free, key=lambda item: item.mass)
    barriers, scales = zip(*(_energies(prepared, n) for n in prepared.free), strict=True)
    limits["deepest"] = DEEPEST * 0.5 * smallest(prepared.placed)
    limits["rest_energy"] = CALM_KINETIC * lightest.mass * prepared.scene.gravity * 0.5 * lightest.size
    limits["least_barrier"], limits["least_scale"] = min(barriers), min(scales)
    return rules, limits
