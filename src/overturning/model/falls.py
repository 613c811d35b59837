"""Which model is meant. To add one, write a subclass of `Model` and name it here."""

from typing import TYPE_CHECKING

from overturning.model.body import Body
from overturning.model.model import Model
from overturning.model.planes import Planes
from overturning.model.scene import Scene
from overturning.model.shapes import Shape, shape_of

if TYPE_CHECKING:
    import xarray as xr


def model_of(cube: "xr.Dataset") -> Model:
    """The model whose outcomes a cube, or a part of it, holds."""
    return Body() if Body.direction in cube.dims else Planes()


def as_model(given: Model | Scene | Shape | str | int | None) -> Model:
    """A model as it is given, a scene in planes, or a body in space by its shape; a single block where there is none.

    Raises
    ------
    ArgumentError
        If there is no shape of a name.
    """
    if isinstance(given, Model):
        return given
    if given is None:
        return Planes()
    return Planes(given) if isinstance(given, Scene) else Body(shape_of(given))
