"""Closed surfaces of non-convex solids with known mass properties, and writers of mesh files."""

from pathlib import Path

import numpy as np

from overturning.model.surface import TriangleSurface

BOX_CORNERS_AND_SIGNS_BY_SOLID = {
    "l-shape": [((0, 0, 0), (0.6, 0.3, 0.2), 1), ((0, 0, 0.2), (0.2, 0.3, 0.8), 1)],
    "ring": [((-0.4, -0.3, 0), (0.4, 0.3, 0.25), 1), ((-0.25, -0.15, 0), (0.25, 0.15, 0.25), -1)],
    "statue": [((-0.1, -0.1, 0), (0.1, 0.1, 0.6), 1), ((-0.25, -0.1, 0.6), (0.3, 0.1, 0.8), 1)],
}
"""Boxes of a solid, low and high corner, m; the sign is −1 for a box that is cut out."""


def mass_properties_of_solid_from_its_boxes(name: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Return volume, centroid and inertia tensor per mass of a solid, by the parallel axis theorem over its boxes."""
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for low, high, sign in BOX_CORNERS_AND_SIGNS_BY_SOLID[name]:
        side, middle = np.subtract(high, low), np.add(high, low) / 2
        own = sign * np.prod(side)
        volume += own
        first += own * middle
        second += own * (np.diag(side**2) / 12 + np.outer(middle, middle))
    centre = first / volume
    spread = second / volume - np.outer(centre, centre)
    return volume, centre, np.trace(spread) * np.eye(3) - spread


def extrude_xz_outline_along_y(outline: list[tuple[float, float]], low: float, high: float) -> TriangleSurface:
    """Extrude an outline in (x, z), anticlockwise and star-shaped about its first corner, along y from low to high."""
    n = len(outline)
    points = np.array([[x, y, z] for y in (low, high) for x, z in outline])
    fan = np.array([[0, k, k + 1] for k in range(1, n - 1)])
    sides = [[k, n + k, (k + 1) % n] for k in range(n)] + [[(k + 1) % n, n + k, n + (k + 1) % n] for k in range(n)]
    return TriangleSurface(points, np.concatenate([fan, n + fan[:, ::-1], sides]))


def l_shaped_prism() -> TriangleSurface:
    """Return a prism of L-shaped section."""
    return extrude_xz_outline_along_y([(0.2, 0.2), (0.2, 0.8), (0, 0.8), (0, 0), (0.6, 0), (0.6, 0.2)], 0.0, 0.3)


def rectangular_ring() -> TriangleSurface:
    """Return a rectangular ring: a box with a rectangular hole through it."""
    around = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    squares = [
        [[a * x, b * y, z] for a, b in around]
        for x, y, z in ((0.4, 0.3, 0), (0.4, 0.3, 0.25), (0.25, 0.15, 0.25), (0.25, 0.15, 0))
    ]
    triangles = []
    for level in range(4):
        lower, upper = 4 * level, 4 * ((level + 1) % 4)
        for k in range(4):
            one, other = k, (k + 1) % 4
            triangles += [[lower + one, lower + other, upper + one], [lower + other, upper + other, upper + one]]
    return TriangleSurface(np.array(squares, dtype=float).reshape(-1, 3), np.array(triangles))


def box(side: tuple[float, float, float]) -> TriangleSurface:
    """Return a box with a corner at the origin and the given sides along x, y and z."""
    x, y, z = side
    return extrude_xz_outline_along_y([(x, 0), (x, z), (0, z), (0, 0)], 0.0, y)


def column_with_overhanging_slab() -> TriangleSurface:
    """Return a column with a slab on it that overhangs on two sides, by different lengths."""
    column = [(-0.1, 0.6), (-0.1, 0), (0.1, 0), (0.1, 0.6)]
    points = [(0.3, 0.6), (0.3, 0.8), (-0.25, 0.8), (-0.25, 0.6)]
    outline = column + points
    n = len(outline)
    vertices = np.array([[x, y, z] for y in (-0.1, 0.1) for x, z in outline])
    front = np.array([[0, 1, 2], [0, 2, 3], [3, 4, 5], [0, 3, 5], [0, 5, 6], [0, 6, 7]])
    sides = [[k, n + k, (k + 1) % n] for k in range(n)] + [[(k + 1) % n, n + k, n + (k + 1) % n] for k in range(n)]
    return TriangleSurface(vertices, np.concatenate([front, n + front[:, ::-1], sides]))


FUNCTIONS_MAKING_SURFACES_OF_SOLIDS = {
    "l-shape": l_shaped_prism,
    "ring": rectangular_ring,
    "statue": column_with_overhanging_slab,
}


def rotate_surface(surface: TriangleSurface, axis: int, angle_deg: float) -> TriangleSurface:
    """Rotate a surface about a coordinate axis."""
    cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    one, other = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[[one, other], [one, other]] = cosine
    matrix[one, other], matrix[other, one] = -sine, sine
    return surface._replace(vertices=surface.vertices @ matrix.T)


def write_mesh(surface: TriangleSurface, path: Path, factor: float = 1.0) -> Path:
    """Write a surface times `factor` as OBJ, PLY or STL by its suffix; ".text" before .ply or .stl means text."""
    points, faces = surface.vertices * factor, surface.triangles
    if path.suffix == ".obj":
        lines = ["v {} {} {}".format(*one) for one in points] + ["f {} {} {}".format(*one) for one in faces + 1]
        path.write_text("# a stone\n" + "\n".join(lines) + "\n")
    elif path.suffix == ".stl":
        corners = points[faces].astype("<f4")
        if ".text" in path.name:
            loops = ("".join(f"vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in one) for one in corners)
            body = "".join(f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops)
            path.write_text(f"solid stone\n{body}endsolid stone\n")
        else:
            rows = b"".join(bytes(12) + one.tobytes() + bytes(2) for one in corners)
            path.write_bytes(bytes(80) + len(corners).to_bytes(4, "little") + rows)
    else:
        form = "ascii" if ".text" in path.name else "binary_little_endian"
        head = f"ply\nformat {form} 1.0\nelement vertex {len(points)}\n"
        head += "".join(f"property double {axis}\n" for axis in "xyz")
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        if form == "ascii":
            rows = "".join("{} {} {}\n".format(*one) for one in points) + "".join(
                "3 {} {} {}\n".format(*one) for one in faces
            )
            path.write_text(head + rows)
        else:
            packed = b"".join(b"\3" + one.astype("<i4").tobytes() for one in faces)
            path.write_bytes(head.encode() + points.astype("<f8").tobytes() + packed)
    return path
