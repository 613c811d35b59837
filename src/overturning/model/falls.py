"""Choice between the 2-D and the 3-D model. To add a model, write a subclass of `Model` and name it here."""

from typing import TYPE_CHECKING

from overturning.model.body import Body
from overturning.model.model import Model
from overturning.model.planes import Planes
from overturning.model.scene import Scene
from overturning.model.shapes import Shape, shape_of

if TYPE_CHECKING:
    import xarray as xr


def model_of(cube: "xr.Dataset") -> Model:
    """Return the model, 2-D or 3-D, whose outcomes a cube (or a selection from it) holds."""
    return Body() if Body.direction in cube.dims else Planes()


def as_model(model_argument: Model | Scene | Shape | str | int | None) -> Model:
    """Return the model for a model, a scene (2-D), the shape of a body (3-D), or None (single 2-D block).

    Raises
    ------
    ArgumentError
        If no shape has the given name.
    """
    if isinstance(model_argument, Model):
        return model_argument
    if model_argument is None:
        return Planes()
    return Planes(model_argument) if isinstance(model_argument, Scene) else Body(shape_of(model_argument))
