"""Mesh files of stones: Wavefront OBJ, Stanford PLY and STL, read by trimesh (group `mesh`)."""

from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from overturning.errors import ArgumentError
from overturning.model.element import MAX_ELEMENT_LENGTH_M, MIN_ELEMENT_LENGTH_M
from overturning.model.scan import ScanResult, stone_in_nearest_stable_pose_from_surface
from overturning.model.surface import TriangleSurface, open_edges, repair_surface_and_close_base

MAX_MESH_FILE_BYTES: Final = 200_000_000
"""Largest size of a mesh file, bytes. The numbers of a text file take several times as much memory."""

MESH_FILE_SUFFIXES: Final = (".obj", ".ply", ".stl")
"""Extensions of mesh files."""

MeshLengthUnit = Literal["m", "cm", "mm"]
"""Unit of the coordinates of a mesh file."""

UNITS_PER_METRE: Final[dict[str, float]] = {"m": 1.0, "cm": 100.0, "mm": 1000.0}
"""Number of units in a metre. Dividing by it keeps 600 mm at exactly 0.6 m."""

PLAUSIBLE_STONE_SIZE_RANGE_M: Final = (0.05, 10.0)
"""Range of the largest extent of a stone, m, within which an undeclared unit is taken for metres."""


MAX_MESH_COORDINATE_IN_FILE_UNIT: Final = float(np.finfo(np.float32).max)
"""Largest coordinate of a mesh file, in its unit: that of single precision."""

MAX_COORDINATE_ROUNDING_TO_STONE_SIZE_RATIO: Final = 1e-4
"""Largest step between coordinates in single precision, as a share of the size of the stone."""


def import_trimesh() -> Any:
    """Return the package trimesh; raise an ArgumentError with the installation command if it is missing."""
    try:
        import trimesh as package
    except ImportError as error:
        raise ArgumentError(
            f"mesh files need trimesh, which cannot be imported ({error}); python -m pip install 'overturning[mesh]'"
        ) from None
    return package


def read_mesh_surface(path: Path | str, unit: MeshLengthUnit | None = None) -> TriangleSurface:
    """Read the triangle surface in a mesh file, z up; polygonal faces are divided and equal vertices merged.

    Parameters
    ----------
    path : Path or str
        Mesh file: .obj, .ply or .stl.
    unit : {"m", "cm", "mm"}, optional
        Unit of the file's coordinates; metres if not given.

    Raises
    ------
    ArgumentError
        If the format is not supported, the file is damaged or too large, the size is implausible in metres and no unit
        is given, or no stone has the size that follows from the unit.
    """
    path = Path(path)
    if path.suffix.lower() not in MESH_FILE_SUFFIXES:
        raise ArgumentError(f"{path}: unknown mesh format; give {', '.join(MESH_FILE_SUFFIXES)}")
    try:
        if path.stat().st_size > MAX_MESH_FILE_BYTES:
            raise ArgumentError(f"{path}: larger than {MAX_MESH_FILE_BYTES} bytes; reduce the number of faces")
    except OSError as error:
        raise ArgumentError(f"{path}: {error.strerror}") from None
    vertices, triangles = _parse_mesh_file(path)
    if not len(vertices) or not (np.abs(vertices) <= MAX_MESH_COORDINATE_IN_FILE_UNIT).all():
        raise ArgumentError(f"{path}: damaged, or not in {path.suffix.lower()} format")
    _check_resolution_of_coordinates(vertices, path)
    vertices = vertices / UNITS_PER_METRE[unit or "m"]
    extent = float(np.ptp(vertices, axis=0).max())
    if unit is None and not PLAUSIBLE_STONE_SIZE_RANGE_M[0] <= extent <= PLAUSIBLE_STONE_SIZE_RANGE_M[1]:
        guess = "mm" if extent > 100.0 else "cm" if extent > PLAUSIBLE_STONE_SIZE_RANGE_M[1] else "m"
        raise ArgumentError(
            f"{path}: the mesh is {extent:.4g} m large if its unit is the metre; "
            f"a stone is {PLAUSIBLE_STONE_SIZE_RANGE_M[0]:g} to "
            f"{PLAUSIBLE_STONE_SIZE_RANGE_M[1]:g} m large: declare the unit of the file (m, cm or mm; perhaps {guess})"
        )
    if not MIN_ELEMENT_LENGTH_M <= extent <= MAX_ELEMENT_LENGTH_M:
        raise ArgumentError(
            f"{path}: the mesh is {extent:.4g} m large; a stone must be {MIN_ELEMENT_LENGTH_M:g} to "
            f"{MAX_ELEMENT_LENGTH_M:g} m large: correct the unit of the file, {unit}"
        )
    return TriangleSurface(vertices, triangles)


def _check_resolution_of_coordinates(vertices_in_file_unit: Any, path: Path) -> None:
    """Raise an ArgumentError if coordinates in single precision are too coarse for the size of the stone.

    STL files, and most PLY files, store 7 digits (single precision): map coordinates would be rounded to centimetres.
    """
    single = path.suffix.lower() != ".obj" and bool(
        (vertices_in_file_unit == vertices_in_file_unit.astype(np.float32)).all()
    )
    largest, extent = float(np.abs(vertices_in_file_unit).max()), float(np.ptp(vertices_in_file_unit, axis=0).max())
    step = float(np.spacing(np.float32(largest)))
    if single and step > MAX_COORDINATE_ROUNDING_TO_STONE_SIZE_RATIO * extent:
        raise ArgumentError(
            f"{path}: coordinates of up to {largest:.7g} in single precision are multiples of "
            f"{step:.2g}, too coarse for a size of {extent:.3g}: move the mesh to the origin before it is exported, or "
            "export it as OBJ"
        )


def _parse_mesh_file(path: Path) -> tuple[Any, Any]:
    """Return the vertices (n, 3) and triangles (m, 3) of a mesh file; m is 0 for a file without faces."""
    package = import_trimesh()
    kind = path.suffix.lower()[1:]
    options = {"skip_materials": True, "split_objects": False, "group_material": False} if kind == "obj" else {}
    try:
        with path.open("rb") as opened:
            loaded = package.load_scene(opened, file_type=kind, process=False, **options)
        shapes = list(loaded.geometry.values())
        solids = [shape for shape in shapes if len(getattr(shape, "faces", ()))]
        if not solids:
            points = [np.asarray(shape.vertices, np.float64) for shape in shapes]
            return np.concatenate(points), np.zeros((0, 3), np.int64)
        mesh = package.util.concatenate(solids) if len(solids) > 1 else solids[0]
        if np.shape(mesh.vertices)[1] != 3 or not (np.abs(mesh.vertices) <= MAX_MESH_COORDINATE_IN_FILE_UNIT).all():
            raise ValueError
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        vertices = np.asarray(mesh.vertices, np.float64)
        return vertices, _remove_degenerate_triangles(vertices, np.asarray(mesh.faces, np.int64))
    except ArgumentError:
        raise
    except OSError as error:
        raise ArgumentError(f"{path}: {error.strerror}") from None
    except Exception:  # trimesh raises many types for damaged files
        hint = " (faces of a binary PLY file need equal numbers of corners)" if kind == "ply" else ""
        raise ArgumentError(f"{path}: damaged, or not in {path.suffix.lower()} format{hint}") from None


def _remove_degenerate_triangles(face_vertex_positions: Any, triangle_vertex_indices: Any) -> Any:
    """Remove triangles with two equal corners, and triangles with all corners on one line unless this opens a hole.

    A face with a corner in the middle of an edge may be divided so that one of its triangles lies on a line; without
    that triangle the surface would be open.
    """
    a, b, c = triangle_vertex_indices.T
    triangle_vertex_indices = triangle_vertex_indices[(a != b) & (b != c) & (c != a)]
    a, b, c = (face_vertex_positions[triangle_vertex_indices[:, k]] for k in range(3))
    wide = np.cross(b - a, c - a).any(axis=1)
    opens = len(open_edges(triangle_vertex_indices[wide])) > len(open_edges(triangle_vertex_indices))
    return triangle_vertex_indices if opens else triangle_vertex_indices[wide]


def read_scanned_stone(
    path: Path | str, unit: MeshLengthUnit | None = None, max_load_bearing_base_point_height_m: float | None = None
) -> ScanResult:
    """Read a scanned stone from a mesh file, and rotate it to the nearest pose in which it can stand.

    Parameters
    ----------
    path : Path or str
        Mesh file: .obj, .ply or .stl; z up.
    unit : {"m", "cm", "mm"}, optional
        Unit of the file's coordinates; metres if not given.
    max_load_bearing_base_point_height_m : float, optional
        Height above the lowest point up to which the points of the base bear, m; default
        `overturning.model.scan.DEFAULT_LOAD_BEARING_BASE_RELIEF_M`.

    Raises
    ------
    ArgumentError
        If the file cannot be read (see `read_mesh_surface`), has holes, or the body cannot be simulated.
    """
    surface = read_mesh_surface(path, unit)
    try:
        return stone_in_nearest_stable_pose_from_surface(
            *repair_surface_and_close_base(surface), Path(path).stem, max_load_bearing_base_point_height_m
        )
    except ArgumentError as error:
        raise ArgumentError(f"{path}: {error}") from None
