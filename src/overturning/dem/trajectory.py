"""The path of a model in one case, and the forces in it."""

from typing import TYPE_CHECKING, Any

from overturning.arrays import dataset
from overturning.dem.numerics import Numerics
from overturning.dem.run import plan_of
from overturning.dem.simulate import grid_over
from overturning.errors import ArgumentError, suggest_keywords
from overturning.model.cases import Cases
from overturning.model.falls import as_model
from overturning.model.model import Model
from overturning.model.scene import Scene
from overturning.model.shapes import Shape
from overturning.motion.motion import Accelerogram, as_motion

if TYPE_CHECKING:
    import xarray as xr


@suggest_keywords(Numerics, "aspect", "amplitude", "initial_tilt")
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
    """The path of a model in one case, bit-equal to its cell of a sweep with the same arguments.

    Parameters
    ----------
    motion, model, height, b_over_h, azimuth_deg, orientation_deg, friction
        As in `overturning.simulate`, one value each.
    **options
        `aspect` as in `overturning.simulate`; `amplitude`, `initial_tilt` as in `overturning.Cases`; fields of
        `overturning.dem.numerics.Numerics`.

    Returns
    -------
    xarray.Dataset
        In planes over `time` (about once per sample of the record, for a single block more often where a contact
        changes or a step is done again; after the record until the case ends) and `element` (all of them): `x`, `z`
        (centre, m), `rotation` (rad, positive towards the azimuth), `velocity_x`, `velocity_z` (m/s),
        `angular_velocity` (rad/s), `base_slip` (m, of the middle of the lower side from its place), all in the frame of
        the base; `ground_acceleration` over `time` (m/s²). Over `time` and `contact` (both ends of each pair of
        elements that can meet): `contact_force` (N, on the element `contact_on` from `contact_by`; mean from this time
        to the next) and `contact_place` (m; mean weighted by the normal force), NaN where nothing is known and, of the
        place, where nothing touches. Over `element`: `kind`, `critical_angle` (α, rad), `fallen_angle` (rotation at
        which it has fallen, rad; also over `side`, −1 and 1), `vertices` (about the centre, m, NaN beyond an element's
        last) and the cell's outcome, NaN where the element is not free; the whole case's outcome without a
        dimension. The general kernel adds the forces up at each of its steps; for a single block they follow from the
        path.

        In space over `time`, in the frame of the base: `place` and `velocity` of the centre over `enu` (east, north,
        up; m and m/s), `quaternion` over `wxyz`, the rotation from the pose at rest, `angular_velocity` over `enu`
        (rad/s), `tilt_north` and `tilt_east` (components of the body's axis, 1), `ground_acceleration` over `enu`
        (m/s²). Over `corner` and `enu`, `outline`: the body at rest about its centre, m; over `edge` and `end`,
        `edges` between corners. So a corner is at place + quaternion · outline · conjugate. And the cell's outcome.

        Attributes: the model, what it was called with, and the case's block steps; of a scene also the name of its
        reference element and the weight of all free elements (N).

    Raises
    ------
    ArgumentError
        As `overturning.simulate`, where there is more than one case, and where the path would be longer than
        `overturning.dem.plan.MAX_PATH_NUMBERS`.
    """
    model, more = as_model(model), {name: options.pop(name, 1.0) for name in ("aspect", "amplitude")}
    grid = grid_over(
        model, height, b_over_h, friction=friction, aspect=more["aspect"], azimuth_deg=azimuth_deg,
        orientation_deg=orientation_deg,
    )  # fmt: skip
    if grid.size != 1:
        raise ArgumentError(f"trajectory: {grid.size} cases; give one value each, or take simulate")
    size = {name: float(grid[name].item()) for name in ("height", "b_over_h", "friction")}
    tilt = options.pop("initial_tilt", 0.0)
    numerics = Numerics(**options)
    # Turned back as far as it looks the same, like the cell: the bits of a turned body are others.
    sources = model.sources(grid, numerics.leave_out)
    case = Cases(grid.directions - sources.turn_deg.ravel(), **size, **more, initial_tilt=tilt)
    results, path = plan_of(model, as_motion(motion), case, numerics).trace()
    views = {name: values.reshape(grid.shape + values.shape[1:]) for name, values in vars(results).items()}
    model.rotate_outcomes(views, grid, sources)
    variables, coordinates, attributes = path.dataset_parts(results)
    known = {f"{model.direction}_deg": grid.directions.item(), **size, **more}
    given = {name: value for name, value in known.items() if name != "aspect" or name in model.case_dims}
    return dataset(
        variables, coordinates, model.attributes | attributes | given | {"block_steps": int(results.block_steps[0])}
    )
