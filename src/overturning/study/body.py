"""What a study in space says of its body, and of the directions that it faces."""

from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from overturning.dem.element import Model
from overturning.errors import ArgumentError, OverturningError
from overturning.study.quantity import Degree, Metre
from overturning.study.ranges import Values

if TYPE_CHECKING:
    from overturning.dem.solid.shapes import Shape

Aspect = Annotated[float, Field(gt=0, le=10)]
Sides = Annotated[int, Field(ge=3, le=96)]


class BodySettings(Model):
    """A free body in space."""

    plan: Literal["rectangle", "circle"] | Sides = Field(
        default="rectangle",
        description="base of a right prism: `rectangle`, `circle`, or the number of sides of a regular one",
    )
    aspect: Values[Aspect] = Field(
        default=(1.0,),
        description="D/B of a rectangle, width across over that along the orientation: a list, or a range",
    )
    vertices: tuple[tuple[Metre, Metre, Metre], ...] | None = Field(
        default=None,
        description="instead of a prism: vertices of a convex body that stands on its lowest face (x, y, z up; m)",
    )

    mesh: str | None = Field(
        default=None,
        description="instead of vertices: mesh of such a body (OBJ, PLY or STL, m); path from the project's folder",
    )

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any) -> Any:
        # A mesh is read at once, so that a filled-in study holds the whole body.
        if not isinstance(data, dict) or data.get("mesh") is None:
            return data
        from overturning.dem.solid.mesh import read_mesh

        try:
            read = read_mesh(str(data["mesh"]))
        except OverturningError as error:
            raise ValueError(f"mesh: {error}") from None
        return {key: value for key, value in data.items() if key != "mesh"} | {
            "vertices": np.asarray(read.vertices).tolist()
        }

    @model_validator(mode="after")
    def _possible(self) -> Self:
        try:
            shape = self.shape()
        except ArgumentError as error:
            raise ValueError(str(error)) from None
        if not shape.oblong and self.aspect != (1.0,):
            raise ValueError(f"aspect {list(self.aspect)}: only a rectangle has one; leave it out")
        return self

    def shape(self) -> "Shape":
        """The kind of body; an `ArgumentError` where there is none."""
        # Imported here: what a study in planes needs not is not waited for.
        from overturning.dem.solid.shapes import Polyhedron, shape_of

        return shape_of(self.plan if self.vertices is None else Polyhedron(self.vertices))

    def periods(self) -> tuple[float, ...]:
        """Turn about the vertical after which the body of each aspect looks the same, degrees; 0 where any one does."""
        from overturning.dem.solid.grid import periods_of

        return tuple(periods_of(self.shape(), np.array(self.aspect)).tolist())


class Orientations(Model):
    """Directions that a body faces: from start by step, up to the turn after which it looks the same."""

    start: Degree = Field(
        default=0.0, ge=0, lt=360, description="first azimuth that the body faces, degrees clockwise from north"
    )
    step: Degree = Field(
        default=5.0,
        gt=0,
        le=360,
        description="distance between them, degrees; up to the turn after which the body looks the same (a square 90°, a "
        "rectangle 180°), which it must divide",
    )

    def check(self, periods: tuple[float, ...]) -> None:
        """Refuse a grid that the body's symmetry does not close, by a ValueError that names a step that does."""
        for period in periods:
            parts = period / self.step
            if period and (abs(parts - round(parts)) > 1e-9 * parts or parts < 0.5):
                near = period / max(1, round(parts))
                raise ValueError(
                    f"orientation.step: {self.step:g}° does not divide the {period:g}° after which the body looks the same; "
                    f"give {near:.10g}"
                )
        if self.start >= self.step and max(periods) > 0:
            raise ValueError(f"orientation.start: {self.start:g}°; it must lie below the step, {self.step:g}°")

    def values(self, periods: tuple[float, ...]) -> tuple[float, ...]:
        """The orientations, ascending; one alone of a body that looks the same from everywhere."""
        count = max(1, round(max(periods) / self.step))
        return tuple(round(self.start + index * self.step, 10) for index in range(count))


IN_PLANES_ONLY: Final = {
    "scene": "a study has a scene in planes or a body in space; keep one",
    "published": "a body in space faces no single azimuth; compare in a study in planes",
    "surveys": "surveys are compared with a study in planes; leave them out here",
    "density": "nothing depends on it in space, where the contact is relative to the weight; leave it out",
}
"""Keys that a study in space refuses, with the reason."""


def check_heights(height: tuple[float, ...]) -> None:
    """Refuse what is no stone by its size, by a ValueError: perhaps its unit was mistaken."""
    from overturning.dem.solid.shapes import check_height

    for value in height:
        try:
            check_height(value)
        except ArgumentError as error:
            raise ValueError(str(error)) from None
