"""Choice between the 2-D and the 3-D model. To add a model, write a subclass of `Model` and name it here."""

from typing import TYPE_CHECKING

from overturning.model.body import Body
from overturning.model.model import Model
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene
from overturning.model.shapes import Shape, shape_from_name_or_sides
from overturning.model.stack import Stack

if TYPE_CHECKING:
    import xarray as xr


def default_model_of_same_kind_as_results_cube(cube: "xr.Dataset") -> Model:
    """Return a model of the kind (2-D, 3-D body or 3-D stack) whose outcomes a results dataset contains."""
    if Body.direction_dimension_name not in cube.dims:
        return PlanarModel()
    # A part of a cube may lack any variable, but keeps its coordinates: a body has aspects, a stack its own depths.
    is_stack = "slid_off" in cube or ("height" in cube.coords and "aspect" not in cube.coords)
    return Stack() if is_stack else Body()


def model_from_scene_or_shape(
    model_scene_shape_name_or_side_count: Model | Scene | Shape | str | int | None, scene_becomes_3d_stack: bool = False
) -> Model:
    """Return the model of a scene, of a 3-D body with a given shape, or of a single 2-D block (None).

    A model is returned unchanged. A scene becomes a 2-D model, or a 3-D stack if `scene_becomes_3d_stack` is true.

    Raises
    ------
    ArgumentError
        If no shape has the given name, or the scene of a 3-D model is no stack.
    """
    if isinstance(model_scene_shape_name_or_side_count, Model):
        return model_scene_shape_name_or_side_count
    if model_scene_shape_name_or_side_count is None:
        return PlanarModel()
    if isinstance(model_scene_shape_name_or_side_count, Scene):
        return (
            Stack(model_scene_shape_name_or_side_count)
            if scene_becomes_3d_stack
            else PlanarModel(model_scene_shape_name_or_side_count)
        )
    return Body(shape_from_name_or_sides(model_scene_shape_name_or_side_count))
