"""Vertices of a body from a mesh file: Wavefront OBJ, Stanford PLY, STL. Its faces follow, since it is convex."""

from pathlib import Path
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.shapes import Polyhedron

MOST_BYTES: Final = 50_000_000
"""Bytes of a mesh; as text, of which the numbers take some ten times as much memory."""

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


def read_mesh(path: Path | str) -> Polyhedron:
    """The convex body of a mesh file (.obj, .ply or .stl), z up, lengths in metres.

    Raises
    ------
    ArgumentError
        If the file is of another kind or broken, or the body is none that can be simulated (`Polyhedron`).
    """
    path = Path(path)
    readers = {".obj": _obj, ".ply": _ply, ".stl": _stl}
    if path.suffix.lower() not in readers:
        raise ArgumentError(f"{path}: not a mesh that can be read; give {', '.join(readers)}")
    try:
        if path.stat().st_size > MOST_BYTES:
            raise ArgumentError(f"{path}: larger than {MOST_BYTES} bytes; give its convex hull, or fewer vertices")
        vertices = np.unique(readers[path.suffix.lower()](path.read_bytes()), axis=0)
    except OSError as error:
        raise ArgumentError(f"{path}: {error.strerror}") from None
    except ArgumentError:
        raise
    except (ValueError, KeyError, IndexError, StopIteration):
        raise ArgumentError(f"{path}: broken, or not the {path.suffix.lower()} format") from None
    try:
        return Polyhedron(vertices, name=path.stem)
    except ArgumentError as error:
        raise ArgumentError(f"{path}: {error}") from None


def _obj(content: bytes) -> FloatArray:
    return _rows(content, "v", 1)


def _rows(content: bytes, word: str, skip: int) -> FloatArray:
    """Three numbers from each line that begins with a word."""
    lines = (line.split() for line in content.decode("utf-8", errors="replace").splitlines())
    return np.array([[float(value) for value in line[skip : skip + 3]] for line in lines if line and line[0] == word])


def _stl(content: bytes) -> FloatArray:
    count = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    if len(content) == _STL_HEADER + count * _STL_TRIANGLE.itemsize:
        return np.frombuffer(content, _STL_TRIANGLE, count, _STL_HEADER)["corners"].astype(np.float64).reshape(-1, 3)
    return _rows(content, "vertex", 1)


def _ply(content: bytes) -> FloatArray:
    head, _, body = content.partition(b"end_header")
    lines = [line.split() for line in head.decode("ascii").splitlines()]
    form = next(line[1] for line in lines if line[:1] == ["format"])
    first = next(index for index, line in enumerate(lines) if line[:1] == ["element"])
    if lines[first][1] != "vertex":
        raise ValueError("vertices must come first")
    count, columns = int(lines[first][2]), []
    for line in lines[first + 1 :]:
        if line[:1] == ["element"]:
            break
        if line[:1] == ["property"]:
            columns.append((line[2], _PLY_TYPES[line[1]]))
    body = body[body.index(b"\n") + 1 :]
    names = [name for name, _ in columns]
    if form == "ascii":
        table = np.array(
            [[float(value) for value in line.split()] for line in body.decode("ascii").splitlines()[:count]]
        )
        return table[:, [names.index(axis) for axis in "xyz"]]
    order = "<" if form == "binary_little_endian" else ">"
    records = np.frombuffer(body, np.dtype([(name, order + kind) for name, kind in columns]), count)
    return np.stack([records[axis].astype(np.float64) for axis in "xyz"], axis=1)
