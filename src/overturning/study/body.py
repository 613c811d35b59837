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
            raise ValueError(str(error).removeprefix("body: ")) from None
        if not shape.oblong and self.aspect != (1.0,):
            raise ValueError(f"aspect {list(self.aspect)}: only a rectangle has one; leave it out")
        return self

    def shape(self) -> "Shape":
        """The kind of body; an `ArgumentError` where there is none."""
        # Imported here: what a study in planes needs not is not waited for.
        from overturning.dem.solid.shapes import Polyhedron, shape_of

        return shape_of(self.plan if self.vertices is None else Polyhedron(self.vertices))


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

    def values(self, body: BodySettings) -> tuple[float, ...]:
        """The orientations, ascending; one alone of a body that looks the same from everywhere.

        A ValueError where the step does not divide the turn after which the body of an aspect looks the same, or the start does
        not lie below the step.
        """
        from overturning.dem.solid.shapes import orientation_grid

        shape = body.shape()
        try:
            # What symmetry repeats of one aspect must be in the grid of all.
            for aspect in body.aspect:
                orientation_grid(self.step, shape, aspect)
            grid = orientation_grid(self.step, shape, body.aspect)
        except ArgumentError as error:
            raise ValueError(str(error)) from None
        if self.start >= self.step:
            raise ValueError(f"orientation.start: {self.start:g}°; it must lie below the step, {self.step:g}°")
        return tuple(round(self.start + value, 10) for value in grid.tolist())


IN_PLANES_ONLY: Final = {
    "scene": "a study has a scene in planes or a body in space; keep one",
    "azimuth": "a body in space moves in all directions at once; give orientation, the azimuths that it faces",
    "published": "a body in space faces no single azimuth; compare in a study in planes",
    "surveys": "surveys are compared with a study in planes; leave them out here",
    "density": "nothing depends on it in space, where the contact is relative to the weight; leave it out",
}
"""Keys that a study in space refuses, with the reason."""
