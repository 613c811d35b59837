"""The model whose falls a cube holds. To add a model, write a subclass of `Model` and name it here."""

from typing import TYPE_CHECKING

from overturning.model.body import Body
from overturning.model.model import Model
from overturning.model.planes import Planes

if TYPE_CHECKING:
    import xarray as xr


def model_of(cube: "xr.Dataset") -> Model:
    """The model whose outcomes a cube, or a part of it, holds."""
    return Body() if Body.direction in cube.dims else Planes()
