"""Public function that returns the trajectory of a model in one case as a dataset, with contact forces."""

from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.arrays import create_xarray_dataset
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import plan_simulation
from overturning.dem.simulate import create_case_grid
from overturning.errors import ArgumentError, refuse_unknown_keywords
from overturning.model.cases import Cases
from overturning.model.falls import model_from_scene_or_shape
from overturning.model.model import Model
from overturning.model.scene import Scene
from overturning.model.shapes import Shape
from overturning.motion.motion import Accelerogram, as_motion

if TYPE_CHECKING:
    import xarray as xr


@refuse_unknown_keywords(NumericalOptions, "aspect", "amplitude", "initial_tilt", "aftermath")
def trajectory(
    motion: Accelerogram,
    model: Model | Scene | Shape | str | int | None = None,
    *,
    height: float | None = None,
    b_over_h: float | None = None,
    azimuth_deg: float | None = None,
    orientation_deg: float | None = None,
    friction: float = 1.0,
    **options: Any,
) -> "xr.Dataset":
    """Simulate one case and return its trajectory; the outcome equals that of `overturning.simulate` bit by bit.

    Parameters
    ----------
    motion, model, height, b_over_h, azimuth_deg, orientation_deg, friction
        As in `overturning.simulate`, one value each.
    **options
        `aspect` as in `overturning.simulate`; `amplitude`, `initial_tilt` as in `overturning.Cases`; fields of
        `overturning.dem.numerics.NumericalOptions`; `aftermath`, time for which the path of a scene goes on after its
        outcome is known, s (default 0): its stones then fall on, and slide until they lie.

    Returns
    -------
    xarray.Dataset
        The outcome variables of the case, and the path. Times are about one per sample of the record, and continue
        after it until the case ends; a single block has more at contact changes and repeated steps.

        2-D models, all in the frame of the base:

        - over `time` and `element` (fixed ones included): `x`, `z` of the centre (m), `rotation` (rad, positive towards
          the azimuth), `velocity_x`, `velocity_z` (m/s), `angular_velocity` (rad/s), and `base_slip`, the displacement
          of the middle of the lower side (m);
        - over `time`: `ground_acceleration` (m/s²);
        - over `time` and `contact` (both ends of each pair of elements that can touch): `contact_force`, on element
          `contact_on` from `contact_by`, averaged until the next time (N; NaN if unknown), and `contact_place`, where
          it acts, averaged with the normal force as weight (m; NaN if unknown or without contact). The scene kernel
          sums the forces over its steps; for a single block they are computed from the path;
        - over `element`: `kind`, `critical_angle` (α, rad), `fallen_angle` (rotation to `side` −1 or 1 at which it
          has fallen, rad), `vertices` about the centre (m; NaN beyond the last), and outcome variables per element,
          NaN for fixed elements.

        3-D bodies and stacks, all in the frame of the base:

        - over `time`: `place` and `velocity` of the centre over `enu` (east, north, up; m and m/s), `quaternion` over
          `wxyz` (rotation from the pose at rest), `angular_velocity` over `enu` (rad/s), `tilt_north` and `tilt_east`
          (components of the body's axis, 1), and `ground_acceleration` over `enu` (m/s²);
        - `outline` over `corner` and `enu`: corners of the body at rest about its centre (m). In motion, a corner is at
          place + quaternion · outline · conjugate;
        - `edges` over `edge` and `end`: the two corners of each edge.

        Stacks have the dimension `element` in all variables of a stone, `simulated` (1 until the stone has fallen), and
        `critical_angle` (rad). With `aftermath`, a fallen stone goes on in free flight until it meets the ground.

        Attributes: those of the model, the arguments of the case, and its block steps; for a scene also the name of the
        reference element and the weight of all free elements (N).

    Raises
    ------
    ArgumentError
        As in `overturning.simulate`; also if there is more than one case, or the path is longer than
        `overturning.dem.plan.MAX_TRAJECTORY_DATASET_VALUES`.
    """
    model = model_from_scene_or_shape(model, scene_becomes_3d_stack=orientation_deg is not None)
    more = {name: options.pop(name, 1.0) for name in ("aspect", "amplitude")}
    grid = create_case_grid(
        model, height, b_over_h, friction=friction, aspect=more["aspect"], azimuth_deg=azimuth_deg,
        orientation_deg=orientation_deg,
    )  # fmt: skip
    if grid.case_count != 1:
        raise ArgumentError(f"trajectory: {grid.case_count} cases; give one value each, or use simulate")
    size = {name: float(grid[name].item()) for name in ("height", "b_over_h", "friction")}
    tilt, aftermath = options.pop("initial_tilt", 0.0), options.pop("aftermath", 0.0)
    for name, value in {"amplitude": more["amplitude"], "initial_tilt": tilt, "aftermath": aftermath}.items():
        if isinstance(value, str) or not np.isscalar(value):
            raise ArgumentError(f"{name}: {value!r}; give one number")
    if not (np.isfinite(aftermath) and aftermath >= 0.0):
        raise ArgumentError(f"aftermath: {aftermath}; a finite number of seconds, at least 0")
    numerics = NumericalOptions(**options)
    # Rotated to the equivalent direction that a grid computes: in another one, the last bits of the result differ.
    sources = model.simulated_direction_for_each_direction(grid, numerics.leave_out)
    case = Cases(
        grid.direction_values_deg - sources.clockwise_rotation_from_simulated_deg.ravel(),
        **size,
        **more,
        initial_tilt=tilt,
    )
    results, path = plan_simulation(model, as_motion(motion), case, numerics).simulate_single_case(aftermath)
    views = {name: values.reshape(grid.shape + values.shape[1:]) for name, values in vars(results).items()}
    model.adapt_and_mark_copied_outcomes_in_place(views, grid, sources)
    variables, coordinates, attributes = path.variables_coordinates_and_attributes(results)
    known = {f"{model.direction_dimension_name}_deg": grid.direction_values_deg.item(), **size, **more}
    given = {
        name: value for name, value in known.items() if name != "aspect" or name in model.case_dims_without_direction
    }
    return create_xarray_dataset(
        variables,
        coordinates,
        model.identifying_dataset_attributes | attributes | given | {"block_steps": int(results.block_steps[0])},
    )
