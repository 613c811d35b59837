"""Positions of the elements of a scene, their nearest faces, and their contacts at rest."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Final, NamedTuple, Protocol

import numpy as np

from overturning.arrays import FloatArray
from overturning.model.element import Element, Material
from overturning.model.polygon import Polygon, make_polygon
from overturning.model.symmetry import FULL_TURN_DEG, PLANE_SYMMETRY_PERIOD_DEG

MAX_GAP_TO_ELEMENT_SIZE_RATIO_AT_CONTACT: Final = 1e-7
"""Gap, as a share of the smaller element's size, up to which two elements touch at rest."""

DEFAULT_FALL_THRESHOLD_DROP_TO_HEIGHT_RATIO: Final = 0.1
"""Default final drop of the centre at which an element counts as fallen, as a share of its height."""

MIN_GROUND_WIDTH_TO_LARGEST_ELEMENT_RATIO: Final = 20.0
"""Least width of a ground, in widths or heights of the largest element that is not the ground."""

MIN_GROUND_WIDTH_FOR_SINGLE_BLOCK_KERNEL_M: Final = 30.0
"""Least width of a ground on which the kernel of single blocks, which knows no end of the ground, is used, m.

Half of it is more than ground displacements in earthquakes."""


class SceneElementsAndMaterials(Protocol):
    """Elements, materials and reference element of a scene, which determine where the elements stand."""

    @property
    def elements(self) -> tuple[Element, ...]:
        """Elements of the scene; each one is listed after the element on which it stands."""

    @property
    def materials(self) -> Mapping[str, Material]:
        """Materials of the elements of the scene, by name."""

    @property
    def size_reference_element_name(self) -> str:
        """Name of the reference element: the element whose height and B/H are varied in a study."""


@dataclass(frozen=True)
class PlacedElement:
    """Element at its position in a scene, with mass, inertia and the drop of its centre that counts as a fall."""

    element: Element
    shape: Polygon
    centre_of_mass_x: float  # horizontal position in the scene, m
    centre_of_mass_z: float  # height in the scene, m
    mass: float  # kg
    inertia_about_centre_of_mass: float  # kg·m²
    fall_threshold_drop: float  # drop of its centre at which it counts as fallen, m

    @property
    def vertices_in_scene(self) -> FloatArray:
        """Vertices of the element at its position in the scene, shape (n, 2), m."""
        return self.shape.vertices_from_whole_polygon_centroid + np.array(
            [self.centre_of_mass_x, self.centre_of_mass_z]
        )

    @property
    def convex_parts(self) -> "list[PlacedElement]":
        """Convex pieces of the element, each as a placed element; the element itself if it is convex."""
        return [replace(self, shape=piece) for piece in self.shape.convex_pieces_if_not_convex] or [self]

    @property
    def smaller_of_width_and_height(self) -> float:
        """Smaller of the element's width and height, m."""
        return min(self.shape.width, self.shape.height)

    @property
    def fall_rotations_to_minus_and_plus_x_rad(self) -> tuple[float, float]:
        """Rotations to −x and +x (rad) from which the element counts as fallen: from scene file, else by shape."""
        asked = self.element.fallen_rotation_deg
        return (
            self.shape.smallest_rotations_to_other_resting_face_rad
            if asked is None
            else (round(float(np.radians(asked)), 12),) * 2
        )

    @property
    def has_prescribed_motion(self) -> bool:
        """True if forces do not move the element: it is driven by the base motion or held fixed."""
        return self.element.kind != "free"


class ConvexPiecePairIndices(NamedTuple):
    """Indices of two convex pieces that can touch: of their elements in the scene, and of each piece in its element."""

    first_element_index: int
    second_element_index: int
    piece_index_in_first_element: int = 0
    second_piece_index: int = 0


@dataclass(frozen=True)
class ContactPointGeometry:
    """Possible contact point of two elements: an end of the segment along which their nearest faces overlap."""

    signed_gap: float  # m, negative if the elements overlap; infinite if there is no common segment
    vertex_position: tuple[float, float]  # the vertex, m
    normal_from_second_to_first: tuple[float, float]  # unit vector
    positive_slip_direction_of_first_element: tuple[float, float]  # direction in which slip of the first counts


def scale_and_place_elements(
    scene: SceneElementsAndMaterials,
    reference_element_height: float | None = None,
    reference_element_b_over_h: float | None = None,
) -> list[PlacedElement]:
    """Return the elements of a scene at their positions, for a height (m) and B/H of the reference element.

    Width, height and position of every element scale with this height, except that the ground
    (`wide_ground_element_name`) never becomes narrower. B/H changes only the width of the reference element, and its
    depth if its `plan` is not a rectangle. Height and B/H are those before the rotation of the reference element, so
    that a rectangle stays a rectangle. Raises an ArgumentError for an invalid polygon.
    """
    own = next(element for element in scene.elements if element.name == scene.size_reference_element_name)
    own_width, own_height = own.unrotated_width_and_height
    scale = 1.0 if reference_element_height is None else reference_element_height / own_height
    ground = wide_ground_element_name(scene)
    placed: list[PlacedElement] = []
    for element in scene.elements:
        points = element.vertices_before_rotation_and_shift
        if element.name == ground:
            points[:, 0] *= max(1.0, 1.0 / scale)
        if reference_element_b_over_h is not None and element.name == scene.size_reference_element_name:
            middle = 0.5 * (points[:, 0].max() + points[:, 0].min())
            # Rounded once, exactly as the width B/H · H of a single block.
            wider = reference_element_b_over_h * own_height / own_width
            points[:, 0] = (points[:, 0] - middle) * wider + middle
            if element.plan != "rectangle":
                element = element.model_copy(update={"depth": element.depth * wider})
        shape = make_polygon(element.name, element.rotate_points(points) * scale)
        shift_x, shift_z = element.at[0] * scale, element.at[1] * scale
        x, z = shape.centroid_in_given_coordinates[0] + shift_x, shape.centroid_in_given_coordinates[1] + shift_z
        if element.stands_on is not None:
            below = next(other for other in placed if other.element.name == element.stands_on)
            x = below.centre_of_mass_x + x
            z = (
                float(below.vertices_in_scene[:, 1].max())
                + shift_z
                - float(shape.vertices_from_whole_polygon_centroid[:, 1].min())
            )
        # A centred element has exactly x = 0, so that a symmetric scene is symmetric bit by bit.
        x = 0.0 if abs(x) < 1e-9 * shape.width else x
        per_area = scene.materials[element.material].density * element.depth
        drop = DEFAULT_FALL_THRESHOLD_DROP_TO_HEIGHT_RATIO * shape.height
        if element.fallen_drop is not None:
            drop = element.fallen_drop * scale
        inertia = per_area * shape.polar_second_moment_about_centroid
        placed.append(PlacedElement(element, shape, x, z, per_area * shape.area, inertia, drop))
    return placed


def wide_ground_element_name(scene: SceneElementsAndMaterials) -> str | None:
    """Return the name of the ground: a fixed upright rectangle, too wide to slide off, below all others; or None."""
    free = [item.rotated_unshifted_polygon for item in scene.elements if item.kind == "free"]
    largest = max(max(shape.width, shape.height) for shape in free)
    for one in scene.elements:
        if one.kind == "free" or one.width is None or one.height is None or one.rotation_deg or one.stands_on:
            continue
        top, others = (one.at[0], one.at[1] + one.height), [item for item in scene.elements if item is not one]
        spans = [item.rotated_vertices + np.array(item.at) - top for item in others if item.stands_on is None]
        above = all(span[:, 1].min() >= 0.0 and np.abs(span[:, 0]).max() < 0.5 * one.width for span in spans)
        if above and one.width > MIN_GROUND_WIDTH_TO_LARGEST_ELEMENT_RATIO * largest:
            return one.name
    return None


def azimuth_period_of_outcome_deg(scene: SceneElementsAndMaterials) -> float:
    """Return the azimuth period of a scene's outcome: 180° if the scene is mirror-symmetric, else 360°.

    With mirror symmetry, each element is its own mirror image, so that the outcome at azimuth φ + 180° is exactly the
    mirror image of that at φ.
    """
    mirror = all(
        item.centre_of_mass_x == 0.0 and item.shape.is_convex_and_mirror_symmetric
        for item in scale_and_place_elements(scene)
    )
    return PLANE_SYMMETRY_PERIOD_DEG if mirror else FULL_TURN_DEG


def reference_element_height_and_b_over_h(scene: SceneElementsAndMaterials) -> tuple[float, float]:
    """Return height (m) and B/H of a scene's reference element as given in the scene file, before its rotation."""
    width, height = next(
        item.unrotated_width_and_height for item in scene.elements if item.name == scene.size_reference_element_name
    )
    return height, width / height


def rounded_reference_height_and_b_over_h(scene: SceneElementsAndMaterials) -> tuple[float, float]:
    """Return the default height (m) and B/H of a scene's reference element, rounded to ten decimals.

    Studies store sizes with as many decimals, so that a single simulation exactly repeats a case of a study.
    """
    height, b_over_h = reference_element_height_and_b_over_h(scene)
    return round(height, 10), round(b_over_h, 10)


def nearest_vertex_distance_from_each_face(element: PlacedElement, other_element: PlacedElement) -> FloatArray:
    """Return, for each face of a convex element, the signed distance (m) of another element's nearest vertex.

    The distance from the line through the face is positive outside the element.
    """
    faces = element.shape.face_geometry_and_contact_flag_table
    points = other_element.vertices_in_scene - np.array([element.centre_of_mass_x, element.centre_of_mass_z])
    reach = faces[:, 4:5] * points[:, 0] + faces[:, 5:6] * points[:, 1]
    return np.asarray(reach.min(axis=1) - faces[:, 6])


def nearest_faces_and_separation(first_element: PlacedElement, second_element: PlacedElement) -> tuple[int, int, float]:
    """Return the indices of two convex elements' nearest faces, and the separation of these faces, m.

    Face i runs from vertex i to vertex i + 1. The separation is negative if the elements overlap.
    """
    faces_a, faces_b = (item.shape.face_geometry_and_contact_flag_table for item in (first_element, second_element))
    products = faces_a[:, 4:5] * faces_b[:, 4] + faces_a[:, 5:6] * faces_b[:, 5]
    candidates = [
        *zip(
            -nearest_vertex_distance_from_each_face(first_element, second_element),
            products.min(axis=1),
            range(len(faces_a)),
            products.argmin(axis=1),
            strict=True,
        ),
        *zip(
            -nearest_vertex_distance_from_each_face(second_element, first_element),
            products.min(axis=0),
            products.argmin(axis=0),
            range(len(faces_b)),
            strict=True,
        ),
    ]
    best = min(candidates, key=lambda candidate: candidate[:2])  # the first one of equals
    return int(best[2]), int(best[3]), float(-best[0])


def possible_contact_points_of_elements(
    first_element: PlacedElement, second_element: PlacedElement
) -> tuple[ContactPointGeometry, ContactPointGeometry]:
    """Return both possible contact points of two convex elements: the ends of the overlap of their nearest faces.

    Each end is at the vertex of one face that lies opposite the other face.
    """
    face_a, face_b, _ = nearest_faces_and_separation(first_element, second_element)
    fa = first_element.shape.face_geometry_and_contact_flag_table[face_a]
    fb = second_element.shape.face_geometry_and_contact_flag_table[face_b]
    shift_x = first_element.centre_of_mass_x - second_element.centre_of_mass_x
    delta = np.array([shift_x, first_element.centre_of_mass_z - second_element.centre_of_mass_z])

    def position_on_face_and_contact_point(
        element_of_vertex: PlacedElement,
        vertex_from_own_centre: FloatArray,
        centre_offset_from_opposite_element: FloatArray,
        opposite_face_table_row: FloatArray,
        sign_of_normal_towards_first_element: float,
        one_if_vertex_can_bear_load: float,
    ) -> tuple[float, ContactPointGeometry]:
        """Return a vertex's position (m) along the opposite face from its middle, and the contact point there."""
        x, z = vertex_from_own_centre + centre_offset_from_opposite_element
        gap = opposite_face_table_row[4] * x + opposite_face_table_row[5] * z - opposite_face_table_row[6]
        along = opposite_face_table_row[4] * z - opposite_face_table_row[5] * x - opposite_face_table_row[7]
        nx, nz = (sign_of_normal_towards_first_element * float(part) for part in opposite_face_table_row[4:6])
        point = (
            float(vertex_from_own_centre[0] + element_of_vertex.centre_of_mass_x),
            float(vertex_from_own_centre[1] + element_of_vertex.centre_of_mass_z),
        )
        can_bear_load = one_if_vertex_can_bear_load * opposite_face_table_row[11] > 0
        is_possible = can_bear_load and abs(along) <= opposite_face_table_row[8]
        return along, ContactPointGeometry(
            float(gap) if is_possible else np.inf,
            point,
            (nx, nz),
            (nz, -nx),
        )

    ends = []
    for mine, theirs, side in ((0, 1, 1.0), (1, 0, -1.0)):
        along, end = position_on_face_and_contact_point(
            first_element, fa[2 * mine : 2 * mine + 2], delta, fb, 1.0, fa[9 + mine]
        )
        other = fb[2 * theirs : 2 * theirs + 2]
        ends.append(
            end
            if side * along <= fb[8]
            else position_on_face_and_contact_point(second_element, other, -delta, fa, -1.0, fb[9 + theirs])[1]
        )
    return ends[0], ends[1]


def _index_pairs_and_gaps_of_movable_elements(placed_elements: list[PlacedElement]) -> Iterator[tuple[int, int, float]]:
    """Yield the indices and the gap (m) of each pair of scene elements of which forces can move at least one."""
    for (j, b), (i, a) in combinations(enumerate(placed_elements), 2):
        if not (a.has_prescribed_motion and b.has_prescribed_motion):
            gaps = (
                max(
                    nearest_vertex_distance_from_each_face(p, q).max(),
                    nearest_vertex_distance_from_each_face(q, p).max(),
                )
                for p, q in product(a.convex_parts, b.convex_parts)
            )
            yield i, j, float(min(gaps))


def convex_piece_pairs_with_movable_element(placed_elements: list[PlacedElement]) -> list[ConvexPiecePairIndices]:
    """Return all pairs of convex pieces of two elements, except pairs in which forces can move neither element.

    The distance does not matter: a stone can slide far on smooth ground, and a wall held fixed in space can come as
    near as the ground moves.
    """
    return [
        ConvexPiecePairIndices(i, j, m, n)
        for (j, b), (i, a) in combinations(enumerate(placed_elements), 2)
        if not (a.has_prescribed_motion and b.has_prescribed_motion)
        for m, n in product(
            range(len(placed_elements[i].shape.convex_parts)), range(len(placed_elements[j].shape.convex_parts))
        )
    ]


def convex_pieces_of_each_pair(
    placed_elements: list[PlacedElement], piece_pairs: list[ConvexPiecePairIndices]
) -> list[tuple[PlacedElement, PlacedElement]]:
    """Return, for each pair of convex pieces that can touch, both pieces at their positions in the scene."""
    parts = [item.convex_parts for item in placed_elements]
    return [
        (
            parts[pair.first_element_index][pair.piece_index_in_first_element],
            parts[pair.second_element_index][pair.second_piece_index],
        )
        for pair in piece_pairs
    ]
