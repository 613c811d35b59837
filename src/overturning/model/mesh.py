"""Vertices of a body from a mesh file: Wavefront OBJ, Stanford PLY, STL.

The faces of the file are only used to check that the body is convex.
"""

import io
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import scipy

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.shapes import Polyhedron

MAX_BYTES: Final = 50_000_000
"""Largest size of a mesh file, bytes. The parsed numbers of a text file take about ten times as much memory."""

NOTCH_TOLERANCE: Final = 1e-3
"""Depth of a side inside the hull that is attributed to rounding in the file, as a share of the body's size."""

ReadNumbers = Callable[[str, int], list[float]]
"""Function of a type name and a count that returns the next numbers of a PLY file."""

Mesh = tuple[FloatArray, list[list[int]]]
"""Vertices, shape (n, 3), m, and the vertex indices of each face in order."""

_STL_HEADER: Final = 84
_STL_TRIANGLE: Final = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_PLY_TYPES: Final = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    **{f"{kind}{8 * size}": f"{kind[0]}{size}" for kind in ("int", "uint") for size in (1, 2, 4)},
    "double": "f8",
    "float32": "f4",
    "float64": "f8",
}


def read_mesh_polyhedron(path: Path | str) -> Polyhedron:
    """Read a convex body from a mesh file (.obj, .ply or .stl), z up, lengths in metres.

    Raises
    ------
    ArgumentError
        If the format is not supported, the file is damaged, the body is not convex, or it cannot be simulated (see
        `Polyhedron`).
    """
    path = Path(path)
    readers = {".obj": _parse_obj, ".ply": _parse_ply, ".stl": _parse_stl}
    if path.suffix.lower() not in readers:
        raise ArgumentError(f"{path}: unknown mesh format; give {', '.join(readers)}")
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ArgumentError(f"{path}: larger than {MAX_BYTES} bytes; give its convex hull, or fewer vertices")
        vertices, faces = readers[path.suffix.lower()](path.read_bytes())
        ends = [pair for face in faces for pair in zip(face, face[1:] + face[:1], strict=True)]
        sides = vertices[np.array(ends, np.int64).reshape(-1, 2)]
    except OSError as error:
        raise ArgumentError(f"{path}: {error.strerror}") from None
    except ArgumentError:
        raise
    except (ValueError, KeyError, IndexError, StopIteration):
        raise ArgumentError(f"{path}: damaged, or not in {path.suffix.lower()} format") from None
    try:
        body = Polyhedron(np.unique(vertices, axis=0), name=path.stem)
        _check_convex(np.asarray(body.vertices), sides)
    except ArgumentError as error:
        raise ArgumentError(f"{path}: {error}") from None
    return body


def _check_convex(vertices: FloatArray, mesh_sides: FloatArray) -> None:
    """Raise an `ArgumentError` if a mesh is not convex: one of its sides lies inside the hull of its vertices.

    Checking the vertices is not enough: all vertices of a notched slab lie on its hull.
    """
    planes = scipy.spatial.ConvexHull(vertices).equations
    inside = -(mesh_sides.mean(axis=1) @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    if np.max(inside, initial=0.0) > NOTCH_TOLERANCE * np.ptp(vertices, axis=0).max():
        one, other = mesh_sides[inside.argmax()].round(6).tolist()
        raise ArgumentError(
            f"body: not convex; the side from {one} to {other} runs {inside.max():.3g} m inside the hull of the "
            "vertices: give the vertices of a convex body"
        )


def _parse_obj(content: bytes) -> Mesh:
    """Return the vertices and faces of an OBJ mesh.

    A face lists vertex numbers, before the first slash, from 1 or negative from the latest vertex.
    """
    faces, count = [], 0
    for text in content.decode("utf-8", errors="replace").splitlines():
        line = text.partition("#")[0].split()
        count += line[:1] == ["v"]
        if line[:1] == ["f"]:
            numbers = [int(word.split("/")[0]) for word in line[1:]]
            faces.append([number - 1 if number > 0 else count + number for number in numbers])
    return _numbers_after_keyword(content, "v", 1), faces


def _numbers_after_keyword(mesh_text: bytes, keyword: str, skipped_word_count: int) -> FloatArray:
    """Return three numbers from each line that begins with a keyword, after the first `skipped_word_count` words."""
    lines = (line.split() for line in mesh_text.decode("utf-8", errors="replace").splitlines())
    return np.array(
        [
            [float(value) for value in line[skipped_word_count : skipped_word_count + 3]]
            for line in lines
            if line and line[0] == keyword
        ]
    )


def _parse_stl(content: bytes) -> Mesh:
    """Return the vertices and faces of a binary or text STL mesh."""
    count = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    if len(content) == _STL_HEADER + count * _STL_TRIANGLE.itemsize:
        corners = np.frombuffer(content, _STL_TRIANGLE, count, _STL_HEADER)["corners"].astype(np.float64).reshape(-1, 3)
    else:
        corners = _numbers_after_keyword(content, "vertex", 1)
    return corners, np.arange(len(corners)).reshape(-1, 3).tolist() if len(corners) % 3 == 0 else []


def _parse_ply(content: bytes) -> Mesh:
    """Return the vertices and faces of a binary or text PLY mesh."""
    head, _, body = content.partition(b"end_header")
    body = body[body.index(b"\n") + 1 :]
    lines = [line.split() for line in head.decode("ascii").splitlines()]
    form = next(line[1] for line in lines if line[:1] == ["format"])
    elements: list[tuple[str, int, list[list[str]]]] = []
    for line in lines:
        if line[:1] == ["element"]:
            elements.append((line[1], int(line[2]), []))
        if line[:1] == ["property"]:
            elements[-1][2].append(line[1:])
    (first, count, columns), (second, many, kinds) = (*elements, ("", 0, []))[:2]
    if first != "vertex":
        raise ValueError("vertices must come first")
    names = [name for _, name in columns]
    if form == "ascii":
        read: ReadNumbers = partial(_next_text_numbers, iter(body.decode("ascii").split()))
        table = np.array(read("", count * len(names))).reshape(count, len(names))
        vertices = table[:, [names.index(axis) for axis in "xyz"]]
    else:
        order = "<" if form == "binary_little_endian" else ">"
        layout = np.dtype([(name, order + _PLY_TYPES[kind]) for kind, name in columns])
        records = np.frombuffer(body, layout, count)
        vertices = np.stack([records[axis].astype(np.float64) for axis in "xyz"], axis=1)
        read = partial(_next_binary_numbers, io.BytesIO(body[records.nbytes :]), order)
    return vertices, _read_ply_faces(read, many, kinds) if second == "face" else []


def _next_text_numbers(words: Iterator[str], _type_name: str, count: int) -> list[float]:
    """Return the next `count` numbers of a text PLY file; the type is ignored, as text needs none."""
    return [float(next(words)) for _ in range(count)]


def _next_binary_numbers(stream: io.BytesIO, byte_order: str, type_name: str, count: int) -> list[float]:
    """Return the next `count` numbers of a PLY data type from a binary file."""
    layout = np.dtype(byte_order + _PLY_TYPES[type_name])
    return np.frombuffer(stream.read(count * layout.itemsize), layout, count).tolist() if count else []


def _read_ply_faces(read_numbers: ReadNumbers, face_count: int, property_types: list[list[str]]) -> list[list[int]]:
    """Return the vertex indices of each face of a PLY file; `property_types` are its header's type words."""
    faces = []
    for _ in range(face_count):
        for *of_list, kind, name in property_types:
            values = read_numbers(kind, int(read_numbers(of_list[1], 1)[0]) if of_list else 1)
            if name in {"vertex_indices", "vertex_index"}:
                faces.append([int(value) for value in values])
    return faces
