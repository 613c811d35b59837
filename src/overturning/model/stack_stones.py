"""Stones of a 3-D stack: faces, mass and inertia of the elements of a scene, extruded to their depth."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.model.element import ContactLaw, Element, PlanShape
from overturning.model.geometry import PlacedElement, scale_and_place_elements
from overturning.model.scene import Scene
from overturning.model.shapes import Cylinder, RegularPrism

POLYGON_SIDES_FOR_CIRCLE: Final = 16
"""Number of sides of the regular polygon, of equal area, that stands for a circle."""

LEVEL_FACE_TOLERANCE_TO_STONE_HEIGHT_RATIO: Final = 1e-6
"""Largest height of a vertex above a level face to which it belongs, as a share of the stone's height."""


@dataclass(frozen=True)
class StackStone:
    """Stone of a 3-D stack: the outline of its scene element in the vertical plane, extruded to its depth.

    The axes are x (the azimuth of the orientation), y (90° anticlockwise of it) and z (up), from the centre of mass.
    """

    name: str
    mass: float  # kg
    inertia_per_mass: FloatArray  # about the centre of mass per mass, shape (3, 3), m²
    centre_of_mass_x_at_rest: float  # position of the centre of mass at rest, m
    centre_height_above_base: float  # height of the centre of mass above the base, m
    upper_face_height_above_centre: float  # height of the upper face above the centre of mass, m
    base_corners_xy_from_centre_of_mass: FloatArray  # anticlockwise from above, shape (corners, 2), m
    upper_face_corners_xy_from_centre_of_mass: FloatArray  # as the base's; the base if nothing can stand on the stone
    outline_xz_from_centre_of_mass: FloatArray  # vertices of the element in the plane, shape (n, 2), m: x and z
    depth_along_y: float  # m
    fall_threshold_drop: float  # drop of the centre of mass at which the stone counts as fallen, m
    base_joint_friction: float | None  # coefficient of friction of the joint below; None for the value of each case
    tangential_to_normal_stiffness_of_joint_below: (
        float | None
    )  # K_s/K_n of the joint below; None for that of the model
    base_joint_damping_ratio: float | None  # damping ratio of the joint below; None for that of the model
    rotational_symmetry_order: (
        int  # number of equal parts of a turn about the vertical after which the stone looks the same; 0: circle
    )

    @property
    def has_rectangular_faces(self) -> bool:
        """True if the stone's base and upper face are rectangles along x and y."""
        return (
            len(self.base_corners_xy_from_centre_of_mass) == 4
            and len(np.unique(self.base_corners_xy_from_centre_of_mass[:, 0])) == 2
        )

    @property
    def nearest_base_side_distance(self) -> float:
        """Horizontal distance of the nearest side of the base from the centre of mass, m."""
        return float(
            np.abs(self.base_corners_xy_from_centre_of_mass).min()
            if self.has_rectangular_faces
            else polygon_side_distances_from_point(self.base_corners_xy_from_centre_of_mass).min()
        )

    def drawn_corners_and_edges(self) -> tuple[FloatArray, FloatArray]:
        """Return the stone's corners from its centre of mass, (2 n, 3), m, and its edges as corner index pairs."""
        if not self.has_rectangular_faces:
            count = len(self.base_corners_xy_from_centre_of_mass)
            corners = np.concatenate([
                np.column_stack([self.base_corners_xy_from_centre_of_mass, np.full(count, height)])
                for height in (-self.centre_height_above_base, self.upper_face_height_above_centre)
            ])  # fmt: skip
        else:
            count, half = len(self.outline_xz_from_centre_of_mass), 0.5 * self.depth_along_y
            x, z = self.outline_xz_from_centre_of_mass.T
            corners = np.concatenate([np.stack([x, np.full(count, side), z], axis=1) for side in (-half, half)])
        ring = np.stack([np.arange(count), (np.arange(count) + 1) % count], axis=1)
        across = np.stack([np.arange(count), np.arange(count) + count], axis=1)
        return corners, np.concatenate([ring, ring + count, across])


def stack_stones(
    scene: Scene, reference_element_height: float | None = None, reference_element_b_over_h: float | None = None
) -> list[StackStone]:
    """Return the stones of a scene from the lowest up, scaled to height (m) and B/H of the reference element.

    A change of B/H changes width and depth of the reference element in the same proportion.
    """
    placed = scale_and_place_elements(scene, reference_element_height, reference_element_b_over_h)
    own_width, own_height = scene.element(scene.size_reference_element_name).unrotated_width_and_height
    scale = 1.0 if reference_element_height is None else reference_element_height / own_height
    wider = 1.0 if reference_element_b_over_h is None else reference_element_b_over_h * own_height / own_width
    stones = []
    for below, item in zip(scene.elements, placed[1:], strict=False):
        element = scene.element(item.element.name)  # with the depth of the scene
        depth = element.depth * scale * (wider if element.name == scene.size_reference_element_name else 1.0)
        density = _density_of_element(scene, element)
        stones.append(stack_stone_of_element(item, depth, scene.contact_law(below, element), density))
    return stones


def _density_of_element(scene: Scene, element: Element) -> float:
    """Return the density of an element's material, kg/m³."""
    return scene.materials[element.material].density


def polygon_side_distances_from_point(polygon_vertices: FloatArray, x_of_point_on_x_axis: float = 0.0) -> FloatArray:
    """Return the distances (m) of an anticlockwise convex polygon's sides from a point (x, 0) inside it."""
    side = np.roll(polygon_vertices, -1, axis=0) - polygon_vertices
    inward = side[:, 1] * (polygon_vertices[:, 0] - x_of_point_on_x_axis) - side[:, 0] * polygon_vertices[:, 1]
    return np.asarray(inward / np.sqrt((side**2).sum(axis=1)))


def _plan_corners_and_inertia_per_mass(
    plan: PlanShape, inscribed_circle_diameter: float, height: float
) -> tuple[FloatArray, FloatArray]:
    """Return the corners (m) of a circular or polygonal plan, anticlockwise, and the stone's inertia per mass (m²).

    The first side of a polygon faces +x. A circle becomes a regular polygon of `POLYGON_SIDES_FOR_CIRCLE` sides and
    equal area; the inertia is that of the cylinder.
    """
    shape = Cylinder() if plan == "circle" else RegularPrism(int(plan))
    solid = ring = shape.solid(height, inscribed_circle_diameter / height, 1.0)
    if plan == "circle":
        # Rounded, since libm differs between processors in the last digit.
        wider = round(
            math.sqrt(math.pi / (POLYGON_SIDES_FOR_CIRCLE * math.tan(math.pi / POLYGON_SIDES_FOR_CIRCLE))), 12
        )
        ring = RegularPrism(POLYGON_SIDES_FOR_CIRCLE).solid(height, wider * inscribed_circle_diameter / height, 1.0)
    return np.asarray(ring.contact_points_from_centre_of_mass[:, :2]), np.asarray(solid.inertia_per_mass)


def stack_stone_of_element(
    placed_element: PlacedElement,
    depth_across_plane: float,
    contact_law_of_joint_below: ContactLaw,
    density: float = 1.0,
) -> StackStone:
    """Convert a scene element to a 3-D stone with a depth (m), density (kg/m³) and contact law of the joint below."""
    outline = placed_element.shape.vertices_from_whole_polygon_centroid
    xx, zz, xz = _second_moments_of_polygon_area(outline) / placed_element.shape.area
    yy, half = depth_across_plane * depth_across_plane / 12.0, 0.5 * depth_across_plane
    faces = []
    for lowest in (True, False):
        left, right = end_x_of_lowest_or_highest_face(placed_element, lowest)
        # A stone on which nothing can stand has no upper face; the base stands in for it.
        left, right = (left, right) if right > left else end_x_of_lowest_or_highest_face(placed_element, True)
        faces.append(np.array([[right, -half], [right, half], [left, half], [left, -half]]))
    plan = placed_element.element.plan
    is_square = (
        len(outline) == 4 and np.array_equal(faces[0], faces[1]) and np.ptp(faces[0][:, 0]) == depth_across_plane
    )
    symmetry = 4 if is_square else 2
    inertia = np.array([[yy + zz, 0.0, -xz], [0.0, xx + zz, 0.0], [-xz, 0.0, xx + yy]])
    if plan != "rectangle":
        ring, inertia = _plan_corners_and_inertia_per_mass(plan, *(float(side) for side in np.ptp(outline, axis=0)))
        faces, symmetry = [ring, ring], (0 if plan == "circle" else int(plan))
    stiffness_ratio = (
        contact_law_of_joint_below.stiffness_ratio
        if "stiffness_ratio" in contact_law_of_joint_below.model_fields_set
        else None
    )
    return StackStone(
        name=placed_element.element.name, mass=density * depth_across_plane * placed_element.shape.area,
        inertia_per_mass=inertia, rotational_symmetry_order=symmetry,
        centre_of_mass_x_at_rest=placed_element.centre_of_mass_x, centre_height_above_base=-float(outline[:, 1].min()),
        upper_face_height_above_centre=float(outline[:, 1].max()),
        base_corners_xy_from_centre_of_mass=faces[0], upper_face_corners_xy_from_centre_of_mass=faces[1],
        outline_xz_from_centre_of_mass=outline,
        depth_along_y=depth_across_plane, fall_threshold_drop=placed_element.fall_threshold_drop,
        base_joint_friction=contact_law_of_joint_below.friction,
        tangential_to_normal_stiffness_of_joint_below=stiffness_ratio,
        base_joint_damping_ratio=contact_law_of_joint_below.damping_ratio,
    )  # fmt: skip


def end_x_of_lowest_or_highest_face(placed_element: PlacedElement, use_lowest_face: bool) -> FloatArray:
    """Return x (m, from the centre of mass) of both ends of an element's lowest or highest face; equal at a vertex."""
    x, z = placed_element.shape.vertices_from_whole_polygon_centroid.T
    level = z.min() if use_lowest_face else z.max()
    on = x[np.abs(z - level) <= LEVEL_FACE_TOLERANCE_TO_STONE_HEIGHT_RATIO * np.ptp(z)]
    return np.array([on.min(), on.max()])


def _second_moments_of_polygon_area(vertices: FloatArray) -> FloatArray:
    """Return the second moments of area ∫x² dA, ∫z² dA and ∫xz dA of an anticlockwise polygon, m⁴."""
    (x, z), (p, q) = vertices.T, np.roll(vertices, -1, axis=0).T
    cross = x * q - p * z
    return np.array([
        np.sum(cross * (x * x + x * p + p * p)) / 12.0, np.sum(cross * (z * z + z * q + q * q)) / 12.0,
        np.sum(cross * (x * q + 2.0 * x * z + 2.0 * p * q + p * z)) / 24.0,
    ])  # fmt: skip


@dataclass(frozen=True)
class ContactPatchAndMassAboveAtRest:
    """Contact area (polygon) of a stone on its support at rest, and mass and centre of the stones above this area."""

    corners_xy_in_stack_axes: FloatArray  # horizontal positions, anticlockwise, shape (n, 2), m
    corner_stiffness_shares: FloatArray  # share of the stiffness at each corner, shape (n,)
    side_distances_from_mass_centre_above: (
        FloatArray  # distance of each side of the patch from below that centre of mass, shape (n,), m; −: outside
    )
    mass_above: float  # mass of all stones above, kg
    height_of_centre_of_all_mass_above: float  # height of their centre of mass above the patch, m


def _rectangular_contact_corners(stone: StackStone, stone_below: StackStone | None) -> FloatArray | None:
    """Return the corners of the contact area below a box on a box or the ground; None if a face is not a rectangle."""
    if not (stone.has_rectangular_faces and (stone_below is None or stone_below.has_rectangular_faces)):
        return None
    base = stone.base_corners_xy_from_centre_of_mass + np.array([stone.centre_of_mass_x_at_rest, 0.0])
    low, high = base.min(axis=0), base.max(axis=0)
    if stone_below is not None:
        face = stone_below.upper_face_corners_xy_from_centre_of_mass + np.array(
            [stone_below.centre_of_mass_x_at_rest, 0.0]
        )
        low, high = np.maximum(low, face.min(axis=0)), np.minimum(high, face.max(axis=0))
    return np.array([[high[0], low[1]], [high[0], high[1]], [low[0], high[1]], [low[0], low[1]]])


def _polygonal_contact_corners(stone: StackStone, stone_below: StackStone | None) -> FloatArray:
    """Return the corners of the contact area (overlap of a stone's base and the face below); empty without overlap.

    The base is clipped by one side of the face after the other (Sutherland & Hodgman 1974).
    """
    patch = stone.base_corners_xy_from_centre_of_mass + np.array([stone.centre_of_mass_x_at_rest, 0.0])
    if stone_below is None:
        return patch
    face = stone_below.upper_face_corners_xy_from_centre_of_mass + np.array([stone_below.centre_of_mass_x_at_rest, 0.0])
    for a, b in zip(face, np.roll(face, -1, axis=0), strict=True):
        inside = (b[0] - a[0]) * (patch[:, 1] - a[1]) - (b[1] - a[1]) * (patch[:, 0] - a[0])
        kept = []
        for p, q, at, to in zip(patch, np.roll(patch, -1, axis=0), inside, np.roll(inside, -1), strict=True):
            kept += [p] if at >= 0.0 else []
            kept += [p + at / (at - to) * (q - p)] if (at < 0.0) != (to < 0.0) else []
        patch = np.array(kept)
        if len(patch) < 3:
            return np.zeros((0, 2))
    return patch


def contact_patches_at_rest(stones: list[StackStone]) -> list[ContactPatchAndMassAboveAtRest]:
    """Return the contact area below each stone of a stack at rest, from the lowest stone up."""
    level = np.concatenate(
        [[0.0], np.cumsum([stone.centre_height_above_base + stone.upper_face_height_above_centre for stone in stones])]
    )
    mass = np.array([stone.mass for stone in stones])
    x, z = (
        np.array([stone.centre_of_mass_x_at_rest for stone in stones]),
        level[:-1] + np.array([stone.centre_height_above_base for stone in stones]),
    )
    found = []
    for k, stone in enumerate(stones):
        below = stones[k - 1] if k > 0 else None
        total = float(np.sum(mass[k:]))
        middle = float(np.sum(mass[k:] * x[k:]) / total)
        corners = _rectangular_contact_corners(stone, below)
        if corners is not None:
            (right, back), (left, front) = corners[1], corners[3]
            weights, reach = np.full(4, 0.25), np.array([right - middle, back, middle - left, -front])
        else:
            corners = _polygonal_contact_corners(stone, below)
            if corners.size == 0:
                found.append(ContactPatchAndMassAboveAtRest(corners, np.zeros(0), np.array([-np.inf]), total, 0.0))
                continue
            length = np.sqrt(((np.roll(corners, -1, axis=0) - corners) ** 2).sum(axis=1))
            weights, reach = (
                0.5 * (length + np.roll(length, 1)) / length.sum(),
                polygon_side_distances_from_point(corners, middle),
            )
        height = float(np.sum(mass[k:] * z[k:]) / total - level[k])
        found.append(ContactPatchAndMassAboveAtRest(corners, weights, reach, total, height))
    return found
