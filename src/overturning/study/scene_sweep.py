"""The outcome of a study's scene on the study's grid."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.dem.polygon.geometry import native_size
from overturning.dem.polygon.simulate import simulate_scene_arrays
from overturning.motion.motion import Motion
from overturning.study.config import Study
from overturning.study.scenes import scene_of


def simulate_study_scene(
    study: Study,
    variant: str,
    motion: Motion,
    azimuth_deg: NDArray[np.float64],
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, NDArray[Any]]:
    """Simulate a variant's scene on the study's grid.

    The scene of a variant is scaled by the same factor as the study's own; the slenderness is that of its reference
    element where this has the name of the study's, otherwise the scene keeps its own and the outcome is repeated.

    Parameters
    ----------
    study, variant : Study, str
        Whose scene, sizes, slendernesses and frictions.
    motion : Motion
        The ground's.
    azimuth_deg : ndarray
        Degrees clockwise from north.
    threads, progress
        As in `overturning.dem.polygon.simulate.simulate_scene_arrays`.

    Returns
    -------
    dict of ndarray
        Variables by name, of shape (azimuth, height, b_over_h, friction) or with a last dimension of elements.
    """
    scene = scene_of(study, variant)
    assert scene is not None  # asked for scenes only
    assert study.scene is not None  # a variant has a scene only beside the study's
    height, b_over_h = np.array(study.height), np.array(study.b_over_h)
    if scene != study.scene:
        own_height, own_ratio = native_size(scene)
        height = np.round(height * (own_height / native_size(study.scene)[0]), 10)
        if scene.reference_name != study.scene.reference_name:
            b_over_h = np.array([own_ratio])
    arrays = simulate_scene_arrays(
        scene,
        motion,
        azimuth_deg=azimuth_deg,
        height=height,
        b_over_h=b_over_h,
        friction=np.array(study.friction),
        scheme=study.simulation.scheme,
        time_step=study.simulation.time_step,
        leave_out=study.simulation.leave_out,
        threads=threads,
        progress=progress,
    )
    if len(b_over_h) < len(study.b_over_h):
        for name, values in arrays.items():
            if name != "block_steps":
                arrays[name] = np.repeat(values, len(study.b_over_h), axis=2)
    return arrays
