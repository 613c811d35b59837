"""Elements, materials and contact laws of a scene file (config/scenes/)."""

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.contact import Contact
from overturning.model.pieces import outline_of_joined_pieces
from overturning.model.polygon import Polygon, make_polygon, rectangle_vertices
from overturning.units import DEFAULT_STONE_DENSITY_KG_M3
from overturning.validation import StrictModel

LowercaseHyphenName = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]*$")]
PositiveNumber = Annotated[float, Field(gt=0)]


MIN_ELEMENT_LENGTH_M, MAX_ELEMENT_LENGTH_M = 1e-6, 1e6
"""Range of the lengths of an element, m; beyond it, areas and moments of inertia lose their digits or overflow."""

PlanShape = Literal["rectangle", "circle"] | Annotated[int, Field(ge=3, le=16)]


def plan_area_of_circle_or_regular_polygon(plan: PlanShape, inscribed_circle_diameter: float) -> float:
    """Return the area, m², of a circular plan, or of a regular polygon around a circle of this diameter (m)."""
    if plan == "circle":
        return 0.25 * math.pi * inscribed_circle_diameter * inscribed_circle_diameter
    assert isinstance(plan, int)
    return 0.25 * plan * math.tan(math.pi / plan) * inscribed_circle_diameter * inscribed_circle_diameter


class Material(StrictModel):
    """Material of the elements (polygons) of a scene file."""

    density: PositiveNumber = Field(default=DEFAULT_STONE_DENSITY_KG_M3, description="density, kg/m³")


class ContactLaw(Contact):
    """Contact law between two materials: springs, dashpots and friction at each vertex."""

    between: tuple[LowercaseHyphenName, LowercaseHyphenName] = Field(description="the two materials, in any order")
    friction: Annotated[float, Field(ge=0)] | None = Field(
        default=None, description="friction coefficient µ; not given: the values of the study"
    )

    @property
    def contact_without_friction(self) -> Contact:
        """Springs and dashpots of the contact law between two materials, without its friction."""
        return Contact(**self.model_dump(include={*Contact.model_fields}))


class Element(StrictModel):
    """Element of a scene file: a rigid polygon with its material and position."""

    name: LowercaseHyphenName = Field(description="name, unique in the scene")
    kind: Literal["free", "driven", "held"] = Field(
        default="free",
        description="free: moves by itself; driven: moves with the record; held: fixed in space",
    )
    material: LowercaseHyphenName = Field(default="stone", description="material")
    width: PositiveNumber | None = Field(default=None, description="width of a rectangle, m")
    height: PositiveNumber | None = Field(default=None, description="height of a rectangle, m")
    vertices: tuple[tuple[float, float], ...] | None = Field(
        default=None, description="vertices [x, z] of any other polygon, convex or not, counter-clockwise, m"
    )
    pieces: tuple[tuple[tuple[float, float], ...], ...] | None = Field(
        default=None,
        min_length=1,
        description="instead of vertices: convex polygons joined at their sides without overlap, in any order, "
        "each a counter-clockwise list of vertices, m",
    )
    depth: PositiveNumber = Field(default=1.0, description="depth across the plane, m")
    plan: PlanShape = Field(
        default="rectangle",
        description="plan of an element given by width and height, in a stack in 3-D: `rectangle` (width × depth), "
        "`circle` of the width as diameter, or the number of sides, 3 to 16, of a regular polygon around this circle, "
        "whose first side faces the orientation. A 2-D scene takes the rectangle width × height of equal mass",
    )
    stands_on: LowercaseHyphenName | None = Field(
        default=None, description="element on whose highest point the lowest vertex stands; not given: on z = 0"
    )
    at: tuple[float, float] = Field(
        default=(0.0, 0.0),
        description="position [x, z] of the middle of a rectangle's lower side, or of the vertices' origin, m; "
        "z is relative to the level of `stands_on` if that is given",
    )
    rotation_deg: float = Field(default=0.0, description="rotation towards +x, applied before the shift, degrees")
    fallen_rotation_deg: float | None = Field(
        default=None,
        gt=0,
        le=180,
        description="rotation that counts as overturned, degrees; "
        "not given: the least rotation at which it can rest on another face",
    )
    fallen_drop: PositiveNumber | None = Field(
        default=None,
        description="final drop of its centre that also counts as overturned, m; "
        "not given: a tenth of its initial height",
    )

    @model_validator(mode="before")
    @classmethod
    def _fill_depth_from_plan(cls, unvalidated_element_content: Any) -> Any:
        """Compute a missing depth so that width × depth is the plan area of the circle or regular polygon."""
        if (
            not isinstance(unvalidated_element_content, dict)
            or unvalidated_element_content.get("plan", "rectangle") == "rectangle"
            or "depth" in unvalidated_element_content
        ):
            return unvalidated_element_content
        width, plan = unvalidated_element_content.get("width"), unvalidated_element_content["plan"]
        if not isinstance(width, int | float) or width <= 0 or not (plan == "circle" or isinstance(plan, int)):
            return unvalidated_element_content  # the fields say what is wrong
        if (isinstance(plan, int) and not 3 <= plan <= 16) or not MIN_ELEMENT_LENGTH_M <= width <= MAX_ELEMENT_LENGTH_M:
            return unvalidated_element_content
        return unvalidated_element_content | {
            "depth": plan_area_of_circle_or_regular_polygon(plan, float(width)) / float(width)
        }

    @model_validator(mode="after")
    def _check_lengths_and_coordinates_in_range(self) -> Self:
        """Raise a ValueError if a length or coordinate of an element is outside the allowed range."""
        for name in ("width", "height", "depth"):
            length = getattr(self, name)
            if length is not None and not MIN_ELEMENT_LENGTH_M <= length <= MAX_ELEMENT_LENGTH_M:
                raise ValueError(
                    f"element {self.name}: {name} {length:g} m; it must be {MIN_ELEMENT_LENGTH_M:g} to "
                    f"{MAX_ELEMENT_LENGTH_M:g} m"
                )
        outlines = {"at": (self.at,), "vertices": self.vertices or (), "pieces": sum(self.pieces or (), ())}
        for name, points in outlines.items():
            for coordinate in (coordinate for point in points for coordinate in point):
                if not abs(coordinate) <= MAX_ELEMENT_LENGTH_M:
                    raise ValueError(
                        f"element {self.name}: {name} {coordinate:g} m; a coordinate is at most "
                        f"{MAX_ELEMENT_LENGTH_M:g} m"
                    )
        return self

    @model_validator(mode="after")
    def _check_dimensions_of_round_or_polygonal_plan(self) -> Self:
        """Raise a ValueError if an element with circular or polygonal plan lacks width and height, or gives a depth."""
        if self.plan == "rectangle":
            return self
        if self.width is None:
            raise ValueError(f"element {self.name}: plan {self.plan} needs a width and a height")
        if not math.isclose(
            self.depth * self.width, plan_area_of_circle_or_regular_polygon(self.plan, self.width), rel_tol=1e-6
        ):
            raise ValueError(f"element {self.name}: plan {self.plan} has no depth of its own; leave depth out")
        return self

    @model_validator(mode="after")
    def _check_geometry_and_fall_settings(self) -> Self:
        """Raise a ValueError unless an element has one kind of geometry, and fall settings only if it is free."""
        rectangle = self.width is not None and self.height is not None
        forms = (rectangle, self.vertices is not None, self.pieces is not None)
        if sum(forms) != 1 or (not rectangle and (self.width or self.height)):
            raise ValueError(f"element {self.name}: give either width and height, or vertices, or pieces")
        if self.kind != "free" and self.fallen_rotation_deg is not None:
            raise ValueError(
                f"element {self.name}: fallen_rotation_deg {self.fallen_rotation_deg:g}; what is {self.kind} cannot "
                "fall: leave it out, or set kind: free"
            )
        if self.kind != "free" and self.fallen_drop is not None:
            raise ValueError(
                f"element {self.name}: fallen_drop {self.fallen_drop:g} m; what is {self.kind} cannot fall: leave it "
                "out, or set kind: free"
            )
        return self

    @property
    def vertices_before_rotation_and_shift(self) -> FloatArray:
        """Vertices of the element as given in the scene file, before rotation and shift, shape (n, 2), m."""
        if self.vertices is not None:
            points = np.array(self.vertices, dtype=np.float64)
        elif self.pieces is not None:
            for number, piece in enumerate(self.pieces, 1):
                if make_polygon(f"{self.name}, piece {number}", piece).convex_pieces_if_not_convex:
                    raise ArgumentError(
                        f"element {self.name}: piece {number} is not convex; split it, or give the outline of all as "
                        "vertices"
                    )
            points = outline_of_joined_pieces(self.name, [np.array(piece) for piece in self.pieces])
        else:
            assert self.width is not None  # one form is given
            assert self.height is not None
            points = rectangle_vertices(self.width, self.height)
        return points

    def rotate_points(self, points: FloatArray) -> FloatArray:
        """Return points, shape (n, 2), m, rotated clockwise by the element's angle from the scene file."""
        if self.rotation_deg:
            # Rounded, since libm differs between processors in the last digit.
            c, s = (round(float(f(np.radians(self.rotation_deg))), 12) for f in (np.cos, np.sin))
            points = np.column_stack([c * points[:, 0] + s * points[:, 1], c * points[:, 1] - s * points[:, 0]])
        return points

    @property
    def rotated_vertices(self) -> FloatArray:
        """Vertices of the element after the rotation and before the shift given in the scene file, shape (n, 2), m."""
        return self.rotate_points(self.vertices_before_rotation_and_shift)

    @property
    def rotated_unshifted_polygon(self) -> Polygon:
        """Polygon of the element after the rotation and before the shift given in the scene file."""
        return make_polygon(self.name, self.rotated_vertices)

    @property
    def unrotated_width_and_height(self) -> tuple[float, float]:
        """Width and height of the element before the rotation given in the scene file, m."""
        upright = make_polygon(self.name, self.vertices_before_rotation_and_shift)
        return upright.width, upright.height
