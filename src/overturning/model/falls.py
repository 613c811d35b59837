"""Choice of the model. To add one, write a subclass of `Model` and name it here."""

from typing import TYPE_CHECKING

from overturning.model.body import Body
from overturning.model.model import Model
from overturning.model.planes import Planes
from overturning.model.scene import Scene
from overturning.model.shapes import Shape, shape_of

if TYPE_CHECKING:
    import xarray as xr


def model_of(cube: "xr.Dataset") -> Model:
    """Return the model whose outcomes a cube, or a part of it, holds."""
    return Body() if Body.direction in cube.dims else Planes()


def as_model(given: Model | Scene | Shape | str | int | None) -> Model:
    """Return the model for an argument: a model, a scene (2-D), the shape of a body (3-D), or None for a single block.

    Raises
    ------
    ArgumentError
        If no shape has the given name.
    """
    if isinstance(given, Model):
        return given
    if given is None:
        return Planes()
    return Planes(given) if isinstance(given, Scene) else Body(shape_of(given))
