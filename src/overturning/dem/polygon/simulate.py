"""The functions users call: a grid of cases of a scene, as arrays and as a dataset."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.dem.cases import Progress
from overturning.dem.contact import Contact
from overturning.dem.grid import Grid, axis, dataset
from overturning.dem.polygon.arrays import WIDE
from overturning.dem.polygon.cases import run_scene_cases
from overturning.dem.polygon.geometry import native_size, place, symmetric
from overturning.dem.polygon.scene import Scene
from overturning.dem.simulate import simulate_arrays
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.dem.variables import PER_ELEMENT
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr


def is_block(scene: Scene) -> bool:
    """Whether a scene is one upright free rectangle in the middle of a driven one: the fast kernel's scene."""
    if len(scene.elements) != 2 or scene.gravity != STANDARD_GRAVITY:
        return False
    ground, block = scene.elements
    return (
        ground.kind == "driven"
        and block.kind == "free"
        and ground.vertices is None
        and block.vertices is None
        and ground.rotation_deg == block.rotation_deg == 0
        and block.fallen_rotation_deg == 90
        and block.fallen_drop is None
        and block.at[0] == ground.at[0]
        and (ground.width or 0) > WIDE * max(block.width or 0, block.height or 0)
    )


def block_contact(scene: Scene) -> Contact:
    """The contact of a two-rectangle scene as the fast kernel takes it."""
    ground, block = scene.elements
    law = scene.law(ground, block)
    return Contact(
        stiffness=law.stiffness,
        stiffness_ratio=law.stiffness_ratio,
        damping_ratio=law.damping_ratio,
        damping=law.damping,
        static_penetration=law.static_penetration,
    )


def simulate_scene_arrays(
    scene: Scene,
    motion: Motion,
    *,
    azimuth_deg: ArrayLike,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    scheme: str | None = None,
    time_step: float | str = "auto",
    leave_out: bool = True,
    threads: int = 1,
    progress: Progress | None = None,
    general: bool = False,
) -> dict[str, NDArray[Any]]:
    """Simulate every combination of azimuth, size, slenderness and friction of a scene under one motion.

    Parameters
    ----------
    scene : Scene
        The scene.
    motion : Motion
        The ground's.
    azimuth_deg : array_like, shape (a,)
        Degrees clockwise from north.
    height, b_over_h : array_like, shape (h,), (b,), optional
        Height (m) and slenderness of the reference element; the scene's own where not given. All lengths scale with
        the height; the slenderness changes the reference element's width alone.
    friction : array_like, shape (f,)
        µ of every contact law without one.
    scheme, time_step, leave_out, threads, progress
        As in `overturning.dem.simulate.simulate_arrays`.
    general : bool
        Take the general kernel where the fast one would do.

    Returns
    -------
    dict of ndarray, shape (a, h, b, f) or (a, h, b, f, elements)
        The cube's variables by name and ``block_steps``. The last dimension, the free elements in the scene's order,
        is there for `PER_ELEMENT` where the scene has more than one.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    own_height, own_ratio = native_size(scene)
    axes = [
        axis("azimuth_deg", azimuth_deg),
        axis("height", own_height if height is None else height),
        axis("b_over_h", own_ratio if b_over_h is None else b_over_h),
        axis("friction", friction),
    ]
    if is_block(scene) and not general:
        law = scene.law(*scene.elements)
        arrays = simulate_arrays(
            motion, azimuth_deg=axes[0], height=axes[1], b_over_h=axes[2],
            friction=axes[3] if law.friction is None else [law.friction],
            density=scene.materials[scene.elements[1].material].density, contact=block_contact(scene),
            time_step=time_step, leave_out=leave_out, threads=threads, progress=progress,
            scheme=scheme or DEFAULT_SCHEME,
        )  # fmt: skip
        whole = tuple(axis.size for axis in axes)
        return {name: np.broadcast_to(values, whole).copy() for name, values in arrays.items()}
    mirrors = all(symmetric(place(scene, h, b)) for h in axes[1].tolist() for b in axes[2].tolist())
    grid = Grid.of(axes, leave_out and mirrors)
    found = run_scene_cases(
        scene, motion, grid.cases, scheme=scheme, time_step=time_step, leave_out=leave_out, threads=threads,
        progress=progress,
    )  # fmt: skip
    arrays = grid.spread(found)
    if len(scene.free) == 1:
        arrays |= {name: arrays[name][..., 0] for name in PER_ELEMENT}
    return arrays


def simulate_scene(
    scene: Scene,
    motion: Motion,
    *,
    azimuth_deg: ArrayLike,
    height: ArrayLike | None = None,
    b_over_h: ArrayLike | None = None,
    friction: ArrayLike = 1.0,
    **options: Any,
) -> "xr.Dataset":
    """The same as `simulate_scene_arrays`, as a dataset with named coordinates.

    Returns
    -------
    xarray.Dataset
        The cube's variables over `azimuth`, `height`, `b_over_h`, `friction` and, for those of `PER_ELEMENT` where
        there is more than one free element, `element`.
    """
    own_height, own_ratio = native_size(scene)
    arrays = simulate_scene_arrays(
        scene, motion, azimuth_deg=azimuth_deg, height=height, b_over_h=b_over_h, friction=friction, **options
    )
    height, b_over_h = own_height if height is None else height, own_ratio if b_over_h is None else b_over_h
    return dataset(
        arrays,
        {
            "azimuth": (axis("azimuth_deg", azimuth_deg), "degree", "azimuth, clockwise from north"),
            "height": (axis("height", height), "m", "height of the reference element"),
            "b_over_h": (axis("b_over_h", b_over_h), "1", "slenderness B/H of the reference element"),
            "friction": (axis("friction", friction), "1", "friction coefficient"),
        },
        scene.free if len(scene.free) > 1 else (),
        {"scene": scene.name},
    )
