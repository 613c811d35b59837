"""Stones of a 3-D stack: faces, mass and inertia of the elements of a scene, extruded to their depth."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.element import ContactLaw, Element
from overturning.model.geometry import PlacedElement, place_elements
from overturning.model.scene import Scene
from overturning.units import STANDARD_GRAVITY

LEVEL_TOLERANCE: Final = 1e-6
"""Largest height of a vertex above a level face to which it belongs, as a share of the stone's height."""


@dataclass(frozen=True)
class StackStone:
    """Stone of a stack: the outline of its element in the plane of the scene, extruded to its depth.

    The axes are x (the azimuth of the orientation), y (90° anticlockwise of it) and z (up), from the centre of mass.
    """

    name: str
    mass: float  # kg
    inertia: FloatArray  # about the centre of mass per mass, shape (3, 3), m²
    x: float  # position of the centre of mass at rest, m
    foot: float  # height of the centre of mass above the base, m
    top: float  # height of the upper face above the centre of mass, m
    base: FloatArray  # corners of the base, anticlockwise from above, shape (4, 2), m
    upper: FloatArray  # corners of the upper face, or of the base if nothing can stand on the stone, shape (4, 2), m
    outline: FloatArray  # vertices of the element in the plane, shape (n, 2), m: x and z
    depth: float  # m
    drop: float  # drop of the centre of mass at which the stone counts as fallen, m
    friction: float | None  # coefficient of friction of the joint below; None for the value of each case
    stiffness_ratio: float | None  # K_s/K_n of the joint below; None for that of the model
    damping_ratio: float | None  # damping ratio of the joint below; None for that of the model

    def drawn_corners_and_edges(self) -> tuple[FloatArray, FloatArray]:
        """Return corners about the centre of mass, shape (2 n, 3), m, and edges as corner indices, shape (3 n, 2)."""
        count, half = len(self.outline), 0.5 * self.depth
        x, z = self.outline.T
        corners = np.concatenate([np.stack([x, np.full(count, side), z], axis=1) for side in (-half, half)])
        ring = np.stack([np.arange(count), (np.arange(count) + 1) % count], axis=1)
        across = np.stack([np.arange(count), np.arange(count) + count], axis=1)
        return corners, np.concatenate([ring, ring + count, across])


def reasons_scene_is_no_stack(scene: Scene) -> list[str]:
    """Return the reasons why a scene is no stack that can be simulated in 3-D; an empty list if it is one."""
    ground, *stones = scene.elements
    faults = [] if ground.kind == "driven" else [f"element {ground.name} is not driven"]
    if ground.width is None or ground.rotation_deg:
        faults.append(f"element {ground.name} is no level ground")
    if scene.gravity != STANDARD_GRAVITY:
        faults.append(f"gravity {scene.gravity:g} m/s²")
    for below, element in zip(scene.elements, stones, strict=False):
        if element.kind != "free" or element.stands_on != below.name:
            faults.append(f"element {element.name} does not stand free on {below.name}")
        elif element.rotation_deg or element.at[1] != 0.0:
            faults.append(f"element {element.name} is rotated or raised")
        elif "depth" not in element.model_fields_set:
            faults.append(f"element {element.name} has no depth")
        law = scene.contact_law(below, element)
        if law.stiffness != "auto" or law.damping is not None:
            faults.append(f"the contact of {element.name} has a stiffness or dashpot of 2-D corners")
    return faults or _level_face_and_balance_faults(scene)


def _level_face_and_balance_faults(scene: Scene) -> list[str]:
    """Return the reasons why stones of a scene do not stand on each other with level faces and in balance."""
    placed = place_elements(scene)[1:]
    faults = [
        f"element {item.element.name} has no level {name}"
        for item, following in zip(placed, [*placed[1:], None], strict=True)
        for name, lowest in (("base", True), ("upper face", False))
        if (lowest or following is not None) and np.ptp(_ends_of_level_face(item, lowest)) == 0.0
    ]
    if faults:
        return faults
    stones = [_stone_of_element(item, item.element.depth, ContactLaw(between=("a", "b"))) for item in placed]
    patches = patches_at_rest(stones)
    return [
        f"what stands on the joint below {stone.name} has its centre of mass outside it"
        for stone, patch in zip(stones, patches, strict=True)
        if not np.all(patch.reach > 0.0)
    ]


def stack_stones(scene: Scene, height: float | None = None, b_over_h: float | None = None) -> list[StackStone]:
    """Return the stones of a scene from the lowest up; height (m) and B/H are those of the reference element.

    A change of B/H changes width and depth of the reference element in the same proportion.
    """
    placed = place_elements(scene, height, b_over_h)
    own_width, own_height = scene.element(scene.size_reference_element_name).unrotated_width_and_height
    scale = 1.0 if height is None else height / own_height
    wider = 1.0 if b_over_h is None else b_over_h * own_height / own_width
    stones = []
    for below, item in zip(scene.elements, placed[1:], strict=False):
        element = item.element
        depth = element.depth * scale * (wider if element.name == scene.size_reference_element_name else 1.0)
        stones.append(_stone_of_element(item, depth, scene.contact_law(below, element), _density(scene, element)))
    return stones


def _density(scene: Scene, element: Element) -> float:
    """Return the density of an element, kg/m³."""
    return scene.materials[element.material].density


def _stone_of_element(item: PlacedElement, depth: float, law: ContactLaw, density: float = 1.0) -> StackStone:
    """Return the stone of an element with its depth (m) and density (kg/m³), and the contact law below it."""
    outline = item.shape.vertices
    xx, zz, xz = _second_moments(outline) / item.shape.area
    yy, half = depth * depth / 12.0, 0.5 * depth
    faces = []
    for lowest in (True, False):
        left, right = _ends_of_level_face(item, lowest)
        # A stone on which nothing can stand has no upper face; the base stands in for it.
        left, right = (left, right) if right > left else _ends_of_level_face(item, True)
        faces.append(np.array([[right, -half], [right, half], [left, half], [left, -half]]))
    return StackStone(
        name=item.element.name, mass=density * depth * item.shape.area,
        inertia=np.array([[yy + zz, 0.0, -xz], [0.0, xx + zz, 0.0], [-xz, 0.0, xx + yy]]),
        x=item.x, foot=-float(outline[:, 1].min()), top=float(outline[:, 1].max()), base=faces[0], upper=faces[1],
        outline=outline, depth=depth, drop=item.drop, friction=law.friction,
        stiffness_ratio=law.stiffness_ratio if "stiffness_ratio" in law.model_fields_set else None,
        damping_ratio=law.damping_ratio,
    )  # fmt: skip


def _ends_of_level_face(item: PlacedElement, lowest: bool) -> FloatArray:
    """Return the left and right end of the lowest or highest level face of an element, m; equal if it has none."""
    x, z = item.shape.vertices.T
    level = z.min() if lowest else z.max()
    on = x[np.abs(z - level) <= LEVEL_TOLERANCE * np.ptp(z)]
    return np.array([on.min(), on.max()])


def _second_moments(vertices: FloatArray) -> FloatArray:
    """Return ∫x² dA, ∫z² dA and ∫xz dA of a polygon with anticlockwise vertices, m⁴."""
    (x, z), (p, q) = vertices.T, np.roll(vertices, -1, axis=0).T
    cross = x * q - p * z
    return np.array([
        np.sum(cross * (x * x + x * p + p * p)) / 12.0, np.sum(cross * (z * z + z * q + q * q)) / 12.0,
        np.sum(cross * (x * q + 2.0 * x * z + 2.0 * p * q + p * z)) / 24.0,
    ])  # fmt: skip


@dataclass(frozen=True)
class ContactPatchAtRest:
    """Rectangle in which a stone at rest touches its support, and the centre of mass of all stones above it."""

    corners: FloatArray  # horizontal positions, shape (4, 2), m
    reach: FloatArray  # distance of each side of the patch from below that centre of mass, shape (4,), m; −: outside
    mass: float  # mass of all stones above, kg
    height: float  # height of their centre of mass above the patch, m


def patches_at_rest(stones: list[StackStone]) -> list[ContactPatchAtRest]:
    """Return the patch below each stone of a stack at rest, from the lowest up."""
    level = np.concatenate([[0.0], np.cumsum([stone.foot + stone.top for stone in stones])])
    mass = np.array([stone.mass for stone in stones])
    x, z = np.array([stone.x for stone in stones]), level[:-1] + np.array([stone.foot for stone in stones])
    found = []
    for k, stone in enumerate(stones):
        base = stone.base + np.array([stone.x, 0.0])
        low, high = base.min(axis=0), base.max(axis=0)
        if k > 0:
            face = stones[k - 1].upper + np.array([stones[k - 1].x, 0.0])
            low, high = np.maximum(low, face.min(axis=0)), np.minimum(high, face.max(axis=0))
        total = float(np.sum(mass[k:]))
        centre = np.array([np.sum(mass[k:] * x[k:]) / total, 0.0])
        corners = np.array([[high[0], low[1]], [high[0], high[1]], [low[0], high[1]], [low[0], low[1]]])
        reach = np.array([*(high - centre), *(centre - low)])
        found.append(ContactPatchAtRest(corners, reach, total, float(np.sum(mass[k:] * z[k:]) / total - level[k])))
    return found


def check_stack(scene: Scene) -> None:
    """Raise an ArgumentError with the reasons if a scene is no stack that can be simulated in 3-D."""
    if faults := reasons_scene_is_no_stack(scene):
        raise ArgumentError(
            f"orientation_deg: scene {scene.name} is no stack of stones ({'; '.join(faults)}); compute it in 2-D with "
            "azimuth_deg"
        )
