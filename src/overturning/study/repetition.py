"""How a study's cases are run again more exactly."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np

from overturning.dem.cases import Cases
from overturning.dem.run import run
from overturning.dem.scene import Scene
from overturning.motion.motion import Motion
from overturning.study.config import Study
from overturning.study.scenes import numerics_of, scene_of

FINER: Final = 8
"""Steps of the first repetition in each of the study's."""

NUDGE: Final = 1e-9
"""Share by which the motion is made stronger to see whether an answer hangs on less than is known of it."""

STIFFER: Final = 4.0
"""Stiffness of the second repetition over the study's; the finest steps are half as long for it, the whole ones are not."""

Again = Callable[[Motion, Any], Any]
"""What runs cases again under a motion."""


def cases_of(study: Study) -> Callable[..., Any]:
    """What makes cases of a study from a row of values per dimension."""
    if study.body is None:
        return Cases
    from overturning.dem.solid.cases import SpaceCases

    return SpaceCases


def repetitions(study: Study) -> dict[str, Again]:
    """How each repetition of a study's nominal cases is computed, by name.

    A step given in seconds shrinks with the period of the stiffer contact; an automatic one follows the stable one.
    """
    numerics = numerics_of(study)
    step = numerics.time_step
    shorter = step if isinstance(step, str) else step / np.sqrt(STIFFER)
    if study.body is not None:
        from overturning.study.space import space_repetition

        return {
            "finer": space_repetition(study, 1.0, replace(numerics, refinement=FINER)),
            "finest": space_repetition(study, 1.0, replace(numerics, refinement=2 * FINER)),
            "stiffer": space_repetition(study, STIFFER, replace(numerics, time_step=shorter)),
        }
    scene = scene_of(study)
    return {
        "finer": partial(run, scene, numerics=replace(numerics, refinement=FINER)),
        "finest": partial(run, scene, numerics=replace(numerics, refinement=2 * FINER)),
        "stiffer": partial(run, stiffer_scene(scene), numerics=replace(numerics, time_step=shorter)),
    }


def stiffer_scene(scene: Scene) -> Scene:
    """The scene with all springs `STIFFER` times as stiff, also those of the default contact law."""
    laws = []
    for pair in itertools.combinations_with_replacement(scene.materials, 2):
        law = scene.law_between(*pair)
        assert law.static_penetration is not None  # `law_between` gives it
        changed: dict[str, float] = {"static_penetration": law.static_penetration / STIFFER}
        if law.stiffness != "auto":
            changed = {"stiffness": law.stiffness * STIFFER}
        laws.append(law.model_copy(update=changed))
    return scene.model_copy(update={"contacts": tuple(laws)})
