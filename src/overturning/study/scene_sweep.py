"""The outcome of a study's scene on the study's grid, and of the members of its ensemble."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.blocks import Cases
from overturning.dem.cases import run_cases
from overturning.dem.polygon.cases import run_scene_cases
from overturning.dem.polygon.geometry import native_size, place, symmetric
from overturning.dem.polygon.scene import Scene
from overturning.dem.polygon.simulate import block_contact, is_block, simulate_scene_arrays
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.motion.motion import Motion
from overturning.study.config import Study
from overturning.study.ensemble import Runner
from overturning.study.scenes import scene_of


def simulate_study_scene(
    study: Study,
    variant: str,
    motion: Motion,
    azimuth_deg: FloatArray,
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
    scene, factor, own_ratio = _size_of(study, variant)
    height = np.array(study.height)
    height = height if factor == 1.0 else np.round(height * factor, 10)
    b_over_h = np.array(study.b_over_h) if own_ratio is None else np.array([own_ratio])
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


def scene_runner(study: Study, variant: str) -> Runner:
    """A runner of a variant's scene: cases hold the study's own heights, and factors on its slenderness.

    Returns
    -------
    Runner
        For `overturning.study.ensemble.run_ensemble`. A block on a wide ground takes the fast kernel, as in the sweep.
    """
    scene, factor, own_ratio = _size_of(study, variant)
    options: dict[str, Any] = {
        "scheme": study.simulation.scheme or DEFAULT_SCHEME,
        "time_step": study.simulation.time_step,
        "leave_out": study.simulation.leave_out,
    }

    def run(
        motion: Motion, cases: Cases, *, threads: int, progress: Callable[[int, int], None] | None
    ) -> tuple[NDArray[np.int8], int]:
        ratio = np.asarray(cases.b_over_h)
        if own_ratio is not None:
            # The scene keeps its own slenderness; the member's factor on the study's applies to it.
            nominal = np.array(study.b_over_h)
            ratio = own_ratio * (ratio / nominal[np.abs(np.log(ratio[:, None] / nominal)).argmin(axis=1)])
        height = np.asarray(cases.height)
        height = height if factor == 1.0 else np.round(height * factor, 10)
        sized = replace(cases, height=height, b_over_h=np.round(ratio, 12))
        if is_block(scene):
            law = scene.law(*scene.elements)
            if law.friction is not None:
                sized = replace(sized, friction=np.full(cases.size, law.friction))
            density = scene.materials[scene.elements[1].material].density
            single = run_cases(
                motion, sized, threads=threads, progress=progress, density=density, contact=block_contact(scene),
                **options,
            )  # fmt: skip
            return single.overturned, int(single.block_steps.sum())
        found = run_scene_cases(scene, motion, sized, threads=threads, progress=progress, **options)
        flags = found.overturned if len(scene.free) > 1 else found.overturned[:, 0]
        return flags, int(found.block_steps.sum())

    return run


def mirrors(scene: Scene | None) -> bool:
    """Whether φ + 180° mirrors φ, so that half of the azimuths are computed; a block always does."""
    return scene is None or is_block(scene) or symmetric(place(scene))


def _size_of(study: Study, variant: str) -> tuple[Scene, float, float | None]:
    """A variant's scene, the factor on the study's heights, and its own B/H where the study's are not for it."""
    scene = scene_of(study, variant)
    assert scene is not None  # asked for scenes only
    assert study.scene is not None  # a variant has a scene only beside the study's
    if scene == study.scene:
        return scene, 1.0, None
    own_height, own_ratio = native_size(scene)
    factor = own_height / native_size(study.scene)[0]
    return scene, factor, own_ratio if scene.reference_name != study.scene.reference_name else None
