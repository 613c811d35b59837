"""Simulation of a grid of cases under one motion: public functions that return arrays or a dataset."""

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import ArrayLike, convert_argument_to_float_array, create_xarray_dataset
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.errors import ArgumentError, refuse_unknown_keywords
from overturning.model.falls import model_from_scene_or_shape
from overturning.model.grid import CF_ATTRIBUTES_BY_DIMENSION, CaseGrid, checked_finite_values
from overturning.model.model import Model
from overturning.model.planes import PlanarModel
from overturning.model.results import CASE_COUNTER_NAMES
from overturning.model.scene import Scene
from overturning.model.scene_model import SceneModel
from overturning.model.shapes import Shape
from overturning.motion.motion import Accelerogram, Motion, as_motion

if TYPE_CHECKING:
    import xarray as xr


def create_case_grid(
    model: Model,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    *,
    friction: ArrayLike = 1.0,
    aspect: ArrayLike = 1.0,
    azimuth_deg: ArrayLike | None = None,
    orientation_deg: ArrayLike | None = None,
) -> CaseGrid:
    """Return the grid of all combinations of a model's case parameters, given as for `overturning.simulate`.

    Raises
    ------
    ArgumentError
        If the direction is not the model's (azimuth in 2-D, orientation in 3-D), or an array is empty or out of bounds.
    """
    if (
        isinstance(model, SceneModel)
        and not model.scene.has_contact_with_unset_friction
        and (convert_argument_to_float_array("friction", friction) != 1.0).any()
    ):
        raise ArgumentError(
            f"friction: {np.asarray(friction).tolist()}; scene {model.scene.name} has coefficients of its own; "
            "leave it out"
        )
    height, b_over_h = model.height_and_b_over_h_or_defaults(height, b_over_h)
    direction = azimuth_deg if model.is_planar else orientation_deg
    if direction is None or (azimuth_deg is not None and orientation_deg is not None):
        fault = "both are given" if direction is not None else f"{model.direction_dimension_name}_deg is not given"
        raise ArgumentError(
            f"azimuth_deg, orientation_deg: {fault}; give azimuth_deg for a block or scene in 2-D, or orientation_deg "
            "for a 3-D body, such as 'rectangle', or a stack of stones in 3-D"
        )
    aspects = checked_finite_values("aspect", aspect)
    if (wrong := aspects[aspects <= 0.0]).size:
        raise ArgumentError(f"aspect: {wrong[0]:g}; it must be above 0")
    model.symmetry_periods_by_aspect_deg(aspects)
    sizes = {"height": height, "b_over_h": b_over_h, "friction": friction, "aspect": aspect}
    several = model.free_element_names if len(model.free_element_names) > 1 else ()
    rows: dict[str, Any] = {f"{model.direction_dimension_name}_deg": direction} | {
        name: sizes[name] for name in model.case_dims_without_direction
    }
    return CaseGrid.from_values(several, **rows)


def simulate_grid(model: Model, motion: Motion, grid: CaseGrid, numerics: NumericalOptions) -> dict[str, NDArray[Any]]:
    """Simulate the cases of a grid under one motion; return arrays of the shape of the grid by variable name."""
    few = model.keep_one_friction_if_scene_sets_all(grid)
    sources = model.simulated_direction_for_each_direction(few, numerics.leave_out)
    own, of_each = np.arange(few.case_count).reshape(few.shape), few.case_count // few.shape[0]
    answering = few.broadcast_over_grid(sources.simulated_direction_index) * of_each + own % of_each
    computed, place = np.unique(answering, return_inverse=True)
    turn_deg = few.broadcast_over_grid(sources.clockwise_rotation_from_simulated_deg).ravel()[computed]
    results = simulate_cases(
        model, motion, few.cases_at_grid_indices(np.unravel_index(computed, few.shape), turn_deg), numerics
    )
    arrays = {name: values[place.reshape(few.shape)] for name, values in vars(results).items()}
    model.adapt_and_mark_copied_outcomes_in_place(arrays, few, sources)
    for name in CASE_COUNTER_NAMES:
        arrays[name][answering != own] = 0
    copies, last = grid.shape[-1] // few.shape[-1], len(grid.shape) - 1
    return {name: np.repeat(values, copies, axis=last) for name, values in arrays.items()}


def simulate_as_arrays(
    motion: Accelerogram, model: Model | Scene | Shape | str | int | None = None, **parameters: Any
) -> dict[str, NDArray[Any]]:
    """Simulate a block, scene or body for all combinations of direction, size and friction; return arrays.

    Parameters and exceptions are those of `overturning.simulate`.

    Returns
    -------
    dict of ndarray, shape of the grid or (…, elements)
        The model's variables by name, as the kernels have them: missing floats are NaN, missing integers the fill value
        -128. Also ``block_steps`` of each cell, and ``samples_left_out``, the number of samples skipped because
        everything was at rest; both are 0 for a cell copied from an equivalent one. The last dimension, the free
        elements in the scene's order, exists only if the scene has several and the variable is per element.
    """
    model = model_from_scene_or_shape(model, scene_becomes_3d_stack=parameters.get("orientation_deg") is not None)
    numerics = {item.name: parameters.pop(item.name) for item in fields(NumericalOptions) if item.name in parameters}
    return simulate_grid(model, as_motion(motion), create_case_grid(model, **parameters), NumericalOptions(**numerics))


@refuse_unknown_keywords(NumericalOptions)
def simulate(
    motion: Accelerogram,
    model: Model | Scene | Shape | str | int | None = None,
    *,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    aspect: ArrayLike = 1.0,
    azimuth_deg: ArrayLike | None = None,
    orientation_deg: ArrayLike | None = None,
    **options: Any,
) -> "xr.Dataset":
    """Simulate a block, scene or body for all combinations of direction, size and friction; return a dataset.

    Parameters
    ----------
    motion : Motion or Record
        Input motion; a record as `overturning.read` returns it. A 3-D body is moved by all components, a 2-D model by
        the component along the azimuth and the vertical one.
    model : Scene, str, int or Shape, optional
        A scene (`overturning.load_scene`), or the shape of a 3-D body: "rectangle", "circle", the number of sides of a
        regular prism, or a polyhedron. A scene is simulated in 2-D with `azimuth_deg`, and in 3-D with
        `orientation_deg` if it is a stack: stones with a `depth` or a round or polygonal `plan`, each on the one
        before. Default: a single 2-D block. To choose contact or density, pass `overturning.gravestone` (2-D) or
        `overturning.Body` (3-D).
    height, b_over_h : array_like, shape (h,), (b,), optional
        Height (m) and slenderness of the reference element; default: those of the scene or polyhedron. All lengths
        scale with the height; the slenderness changes only the width of the reference element.
    friction : array_like, shape (f,)
        µ of every contact law that has no coefficient; an error if all contacts of the scene have one.
    aspect : array_like, shape (a,)
        D/B of a 3-D rectangle: width across the orientation over width along it.
    azimuth_deg : array_like, shape (n,)
        2-D models: azimuth of the plane of motion, degrees clockwise from north, any real numbers.
    orientation_deg : array_like, shape (n,)
        3-D bodies: azimuth that the body's first side faces, degrees clockwise from north, any real numbers.
    **options
        Fields of `overturning.dem.numerics.NumericalOptions`.

    Returns
    -------
    xarray.Dataset
        The model's variables. Dimensions of a 2-D model: `azimuth`, `height`, `b_over_h` and `friction`, and
        `element` for variables per element of a scene with several free elements. Dimensions of a 3-D body:
        `orientation`, `height`, `b_over_h`, `aspect` and `friction`. Flags are floats, and missing values are NaN, as
        in `overturning.open_cube`: `abs(outcome.overturned).mean()` is the fraction overturned of the cases that have
        an outcome, but `outcome.overturned != 0` is also true for missing values.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.

    Examples
    --------
    >>> import numpy as np, overturning
    >>> pulse = 6.0 * np.sin(2 * np.pi * np.arange(101) / 100)
    >>> motion = overturning.Motion(pulse, 0 * pulse, sampling_interval=0.01)
    >>> plane = overturning.simulate(motion, azimuth_deg=[0, 180], height=[0.6], b_over_h=[0.15])
    >>> int(plane.overturned.sum())  # the two directions mirror each other
    0
    >>> space = overturning.simulate(motion, "rectangle", orientation_deg=[0, 30], height=[0.6], b_over_h=[0.15])
    >>> space.overturned.values.ravel().tolist()
    [1.0, 1.0]
    """
    model = model_from_scene_or_shape(model, scene_becomes_3d_stack=orientation_deg is not None)
    motion = as_motion(motion)
    grid = create_case_grid(
        model,
        height,
        b_over_h,
        friction=friction,
        aspect=aspect,
        azimuth_deg=azimuth_deg,
        orientation_deg=orientation_deg,
    )
    arrays = simulate_grid(model, motion, grid, NumericalOptions(**options))
    coordinates: dict[str, Any] = {
        name: (name, grid[name], CF_ATTRIBUTES_BY_DIMENSION[name]) for name in grid.dimension_names
    }
    if grid.free_element_names_if_several:
        coordinates["element"] = ("element", list(grid.free_element_names_if_several))
    if (angles := element_critical_angle_coordinate_or_none(model, grid)) is not None:
        coordinates["critical_angle"] = angles
    level = "none: the motion has two components, so the base moves level"
    return create_xarray_dataset(
        {
            item.name: (
                grid.one_record_cube_dimensions_of_variable(item),
                item.decode(arrays[item.name]),
                item.cf_attributes,
            )
            for item in model.outcome_variables
        },
        coordinates,
        model.identifying_dataset_attributes | {"vertical_motion": level if motion.up is None else "as recorded"},
    )


def element_critical_angle_coordinate_or_none(
    model: Model, grid: CaseGrid
) -> tuple[tuple[str, ...], NDArray[np.float64], dict[str, str]] | None:
    """Return dimensions, values (degrees) and attributes of the critical angles of a scene's free elements, or None.

    None for a single block or body, whose critical angle follows from B/H.
    """
    if not isinstance(model, PlanarModel) or model.scene.can_use_single_block_kernel:
        return None
    from overturning.dem.polygon.prepare import CRITICAL_ANGLE_ATTRIBUTES, free_element_critical_angles_deg

    angles = free_element_critical_angles_deg(model.scene, grid["b_over_h"])
    return (
        (("b_over_h", "element"), angles, CRITICAL_ANGLE_ATTRIBUTES)
        if grid.free_element_names_if_several
        else (("b_over_h",), angles[:, 0], CRITICAL_ANGLE_ATTRIBUTES)
    )
