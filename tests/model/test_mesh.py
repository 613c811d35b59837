"""Mesh files: three formats and their variants, units, damaged and unsuitable files."""

from pathlib import Path

import numpy as np
import pytest

from overturning.errors import ArgumentError
from overturning.model.mesh import import_trimesh, read_mesh_surface, read_scanned_stone
from overturning.model.scan import ScannedStone
from overturning.model.shapes import Polyhedron
from overturning.model.surface import mass_properties_inside_surface
from tests.expect import expect_error
from tests.model.solids import (
    FUNCTIONS_MAKING_SURFACES_OF_SOLIDS,
    box,
    l_shaped_prism,
    mass_properties_of_solid_from_its_boxes,
    write_mesh,
)

MESH_FILE_NAMES = ("a.obj", "a.ply", "a.text.ply", "a.stl", "a.text.stl")


@pytest.fixture(autouse=True)
def _skip_test_without_trimesh() -> None:
    """Skip the test if trimesh is not installed."""
    pytest.importorskip("trimesh")


@pytest.mark.parametrize("file", MESH_FILE_NAMES)
@pytest.mark.parametrize("name", FUNCTIONS_MAKING_SURFACES_OF_SOLIDS)
def test_every_mesh_format_gives_the_same_mass_properties(tmp_path: Path, file: str, name: str) -> None:
    found = mass_properties_inside_surface(
        read_mesh_surface(write_mesh(FUNCTIONS_MAKING_SURFACES_OF_SOLIDS[name](), tmp_path / file)).triangle_corners
    )
    for one, other in zip(found, mass_properties_of_solid_from_its_boxes(name), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-7)


@pytest.mark.parametrize("file", MESH_FILE_NAMES)
def test_a_convex_mesh_becomes_a_polyhedron(tmp_path: Path, file: str) -> None:
    scan = read_scanned_stone(write_mesh(box((0.4, 0.3, 0.8)), tmp_path / file))
    assert isinstance(scan.shape, Polyhedron)
    assert scan.volume_m3 == pytest.approx(0.4 * 0.3 * 0.8)
    assert (scan.rotation_to_stable_pose.scan_tilt_from_stable_pose_deg, scan.mesh_change_notes, scan.shape.name) == (
        0.0,
        [],
        (tmp_path / file).stem,
    )
    np.testing.assert_allclose(
        scan.shape.unscaled_solid.inertia_per_mass,
        Polyhedron(box((0.4, 0.3, 0.8)).vertices).unscaled_solid.inertia_per_mass,
        rtol=1e-6,
    )


def test_variants_of_obj_ply_and_stl_are_read(tmp_path: Path) -> None:
    """Variants: polygons as faces, negative vertex numbers, numbers of normals, comments, further columns and lists."""
    whole, n = l_shaped_prism(), 6
    points = whole.vertices
    faces = [[0, 1, 2, 3, 4, 5], [6, 11, 10, 9, 8, 7], *([k, n + k, n + (k + 1) % n, (k + 1) % n] for k in range(n))]
    lines = "".join("v {} {} {}\n".format(*point) for point in points)
    slashes = "".join("f " + " ".join(f"{k + 1}//1" for k in face) + "\n" for face in faces)
    (tmp_path / "slashes.obj").write_text(f"# a stone\nvn 0 0 1\n{lines}{slashes}")
    (tmp_path / "back.obj").write_text(
        lines + "".join("f " + " ".join(str(k - 2 * n) for k in face) + "\n" for face in faces)
    )
    columns = "".join(f"property float {axis}\n" for axis in "xyz") + "property uchar red\n"
    head = f"ply\nformat {{}} 1.0\ncomment a stone\nelement vertex {2 * n}\n{columns}element face {len(faces)}\n"
    head += "property list uchar int vertex_indices\nproperty uchar red\nend_header\n"
    rows = "".join("{} {} {} 7\n".format(*point) for point in points)
    rows += "".join(" ".join(map(str, [len(face), *face, 7])) + "\n" for face in faces)
    (tmp_path / "columns.ply").write_text(head.format("ascii") + rows)
    packed = b"".join(point.astype(">f4").tobytes() + b"\7" for point in points)
    mixed = packed + b"".join(bytes([len(face)]) + np.array(face, ">i4").tobytes() + b"\7" for face in faces)
    binary = head.format("binary_big_endian")
    (tmp_path / "mixed.ply").write_bytes(binary.encode() + mixed)
    with expect_error(ArgumentError, "mixed.ply", "equal numbers of corners", brief=True):
        read_mesh_surface(tmp_path / "mixed.ply")
    (tmp_path / "mixed.ply").unlink()
    packed += b"".join(b"\3" + face.astype(">i4").tobytes() + b"\7" for face in whole.triangles)
    binary = binary.replace(f"element face {len(faces)}", f"element face {len(whole.triangles)}")
    (tmp_path / "big.ply").write_bytes(binary.encode() + packed)
    for path in sorted(tmp_path.iterdir()):
        found = mass_properties_inside_surface(read_mesh_surface(path).triangle_corners)
        for one, other in zip(found, mass_properties_of_solid_from_its_boxes("l-shape"), strict=True):
            np.testing.assert_allclose(one, other, atol=1e-7, err_msg=path.name)


def test_volume_and_inertia_of_a_mesh_equal_those_of_trimesh(tmp_path: Path) -> None:
    path = write_mesh(l_shaped_prism(), tmp_path / "a.ply")
    found, other = (
        mass_properties_inside_surface(read_mesh_surface(path).triangle_corners),
        import_trimesh().load_mesh(path),
    )
    assert found.signed_volume == pytest.approx(other.volume)
    np.testing.assert_allclose(found.centre_of_mass, other.center_mass)
    np.testing.assert_allclose(found.inertia_per_mass, other.moment_inertia / other.volume, atol=1e-12)


@pytest.mark.parametrize("start", range(5))
def test_a_mesh_vertex_in_the_middle_of_an_edge_leaves_the_surface_closed(tmp_path: Path, start: int) -> None:
    """A face with a vertex in the middle of an edge is split into triangles; one may have collinear corners."""
    points = [*((x, y, z) for z in (0.0, 0.8) for x, y in ((0, 0), (0.2, 0), (0.2, 0.3), (0, 0.3))), (0.1, 0.0, 0.8)]
    upper = np.roll([4, 8, 5, 6, 7], start).tolist()
    faces = [[3, 2, 1, 0], upper, [0, 1, 5, 8, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    text = "".join("v {} {} {}\n".format(*point) for point in points)
    text += "".join("f " + " ".join(str(k + 1) for k in face) + "\n" for face in faces)
    (tmp_path / "box.obj").write_text(text)
    assert read_scanned_stone(tmp_path / "box.obj").volume_m3 == pytest.approx(0.048, rel=1e-12)


@pytest.mark.parametrize("corners", [((1, 0, 0), (1.1, 0, 0), (1.2, 0, 0)), ((0, 0, 0), (0.1, 0, 0), (0.2, 0, 0))])
def test_a_stray_triangle_of_zero_area_is_ignored(tmp_path: Path, corners: tuple[tuple[float, ...], ...]) -> None:
    path = write_mesh(box((0.2, 0.3, 0.8)), tmp_path / "a.obj")
    more = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f -3 -2 -1\n"
    path.write_text(path.read_text() + more)
    assert read_scanned_stone(path).volume_m3 == pytest.approx(0.048, rel=1e-6)


def test_a_mesh_of_implausible_size_needs_its_unit_declared(tmp_path: Path) -> None:
    path = write_mesh(l_shaped_prism(), tmp_path / "stone.obj", 1000.0)
    with expect_error(ArgumentError, "stone.obj", "800 m large", "declare the unit", "perhaps mm", brief=True):
        read_scanned_stone(path)
    assert read_scanned_stone(path, "mm").volume_m3 == pytest.approx(
        mass_properties_of_solid_from_its_boxes("l-shape")[0]
    )
    path = write_mesh(l_shaped_prism(), tmp_path / "stone.ply", 100.0)
    with expect_error(ArgumentError, "80 m large", "perhaps cm", brief=True):
        read_scanned_stone(path)
    assert read_scanned_stone(path, "cm").volume_m3 == pytest.approx(
        mass_properties_of_solid_from_its_boxes("l-shape")[0]
    )
    with expect_error(ArgumentError, "0.0008 m", brief=True):
        read_scanned_stone(write_mesh(l_shaped_prism(), tmp_path / "small.ply"), "mm")


@pytest.mark.parametrize(
    ("factor", "reason"),
    [(1e307, "damaged"), (1e100, "damaged"), (1e30, "correct the unit"), (1e-9, "correct the unit")],
)
def test_a_mesh_larger_or_smaller_than_any_stone_is_refused(tmp_path: Path, factor: float, reason: str) -> None:
    whole = l_shaped_prism()
    with expect_error(ArgumentError, "whole.obj", reason, brief=True):
        read_scanned_stone(write_mesh(whole._replace(vertices=whole.vertices * factor), tmp_path / "whole.obj"), "m")


def test_a_mesh_whose_vertices_lie_in_a_plane_is_refused(tmp_path: Path) -> None:
    (tmp_path / "flat.obj").write_text("v 0 0\nv 1 0\nv 1 1\nf 1 2 3\n")
    with expect_error(ArgumentError, "flat.obj", "damaged", brief=True):
        read_scanned_stone(tmp_path / "flat.obj", "m")


@pytest.mark.parametrize("file", ["far.stl", "far.ply", "far.obj"])
def test_a_mesh_with_map_coordinates_in_single_precision_is_refused(tmp_path: Path, file: str) -> None:
    """Single precision (STL) is refused; PLY in double precision and OBJ text with all digits are exact enough."""
    whole, place = l_shaped_prism(), np.array([400_000.0, 3_900_000.0, 120.0])
    path = write_mesh(whole._replace(vertices=whole.vertices + place), tmp_path / file)
    if file != "far.stl":
        assert read_scanned_stone(path).volume_m3 == pytest.approx(
            mass_properties_of_solid_from_its_boxes("l-shape")[0], rel=1e-6
        )
        return
    with expect_error(ArgumentError, file, "single precision", "multiples of 0.25", "move the mesh to", brief=True):
        read_scanned_stone(path)


def test_a_non_convex_mesh_becomes_a_scanned_stone(tmp_path: Path) -> None:
    scan = read_scanned_stone(
        write_mesh(l_shaped_prism(), tmp_path / "stone.stl"), max_load_bearing_base_point_height_m=0.001
    )
    assert isinstance(scan.shape, ScannedStone)
    assert scan.shape.max_load_bearing_base_point_height_m == 0.001
    _, centre, _ = mass_properties_of_solid_from_its_boxes("l-shape")
    assert scan.shape.unscaled_solid.b_over_h == pytest.approx(min(centre[0], 0.15) / centre[2], abs=1e-5)


def test_damaged_and_unknown_mesh_files_are_refused_by_name(tmp_path: Path) -> None:
    whole = l_shaped_prism()
    cases = {
        "box.xyz": (b"", ["box.xyz", ".obj, .ply, .stl"]),
        "broken.stl": (b"solid", ["broken.stl"]),
        "empty.obj": (b"", ["empty.obj", "damaged"]),
        "torn.ply": (write_mesh(whole, tmp_path / "a.ply").read_bytes()[:-40], ["torn.ply"]),
        "number.obj": (b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ["number.obj"]),
        "points.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n", ["points.obj", "without faces"]),
        "sheet.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ["sheet.obj"]),
    }
    for name, (content, words) in cases.items():
        (tmp_path / name).write_bytes(content)
        with expect_error(ArgumentError, *words, brief=True):
            read_scanned_stone(tmp_path / name)
    with expect_error(ArgumentError, "gone.obj: No such file", brief=True):
        read_scanned_stone(tmp_path / "gone.obj")
    hole = whole._replace(triangles=whole.triangles[2:])
    with expect_error(ArgumentError, "hole.ply", "not closed at", "fill the holes", brief=True):
        read_scanned_stone(write_mesh(hole, tmp_path / "hole.ply"))
